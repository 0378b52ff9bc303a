"""Figures of a frequency response: Bode, Nyquist, waterfall."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array, ComplexArray
from gearbow.plotting.style import MICRO, GivenAxes, colour, label_x, legend, log_scale, panels

__all__ = ["bode", "nyquist", "waterfall"]

#: Name of the amplitude by its unit, the unit of the figure and its factor.
_QUANTITIES = {
    "m": ("displacement", "µm", MICRO),
    "m/s": ("velocity", "mm/s", 1e3),
    "m/s²": ("acceleration", "m/s²", 1.0),
    "rad": ("twist", "mrad", 1e3),
    "N": ("force", "N", 1.0),
}


def bode(
    lines: Mapping[str, tuple[Array, ComplexArray]],
    unit: str,
    axis: str,
    *,
    pairs: bool = False,
    ax: GivenAxes = None,
) -> Figure:
    """Draw amplitude and phase; with `pairs`, two lines each have a colour."""
    quantity, shown, scale = _QUANTITIES[unit]
    over_speed = axis == "speed"
    factor = 1.0 if over_speed else 0.5 / np.pi
    label = "speed of the reference shaft [rad/s]" if over_speed else "frequency [Hz]"
    with panels(2, 3.6, columns=1, sharex=True, ax=ax) as (figure, axes):
        upper, lower = axes
        log_scale(upper)
        for number, (name, (along, values)) in enumerate(lines.items()):
            style: dict[str, Any] = {
                "color": colour(number // 2 if pairs else number),
                "linestyle": ("-", "--")[number % 2] if pairs else "-",
            }
            # A phasor that is zero has no phase.
            size = np.where(values == 0.0, np.nan, scale * np.abs(values))
            upper.plot(factor * along, size, label=name, **style)
            known = np.isfinite(size)
            phase = np.degrees(np.unwrap(np.angle(values[known])))
            lower.plot(factor * along[known], phase, **style)
        upper.set(ylabel=f"{quantity} [{shown}]")
        lower.set(ylabel="phase [°]")
        label_x(axes, label)
        legend(figure, upper, ax=ax)
    return figure


def nyquist(
    lines: Mapping[str, tuple[Array, ComplexArray]], unit: str, *, ax: GivenAxes = None
) -> Figure:
    """Draw curves in the complex plane."""
    _, shown, scale = _QUANTITIES[unit]
    with panels(1, 7.0, columns=1, width=8.0, ax=ax) as (figure, (panel,)):
        for number, (name, (_, values)) in enumerate(lines.items()):
            style: dict[str, Any] = {"color": colour(number), "label": name}
            points = scale * values
            panel.plot(points.real, points.imag, marker=".", markersize=3, **style)
        panel.axhline(0.0, color="0.6", linewidth=0.8)
        panel.axvline(0.0, color="0.6", linewidth=0.8)
        panel.set_aspect("equal", adjustable="datalim")
        # Labels such as −0.0025 are longer than Matplotlib expects.
        panel.locator_params(axis="x", nbins=5)
        panel.set(xlabel=f"real part [{shown}]", ylabel=f"imaginary part [{shown}]")
        legend(figure, panel, ax=ax)
    return figure


def waterfall(
    frequencies: Array,
    speeds: Array,
    amplitudes: Array,
    name: str,
    unit: str,
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw amplitudes over frequency and speed as a map."""
    _, shown, scale = _QUANTITIES[unit]
    with panels(1, 6.0, columns=1, width=10.0, ax=ax) as (figure, (panel,)):
        from matplotlib.colors import LogNorm  # noqa: PLC0415

        amplitudes = scale * amplitudes
        positive = amplitudes[amplitudes > 0.0]
        norm = LogNorm(positive.min(), positive.max()) if positive.size else None
        mesh = panel.pcolormesh(
            frequencies / (2.0 * np.pi), speeds, amplitudes, norm=norm, shading="nearest"
        )
        figure.colorbar(mesh, ax=panel, label=f"{name} [{shown}]")
        panel.grid(visible=False)
        panel.set(xlabel="frequency [Hz]", ylabel="speed of the reference shaft [rad/s]")
    return figure
