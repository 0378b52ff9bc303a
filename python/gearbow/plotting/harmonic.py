"""Figures of harmonic responses: Bode and polar plots, orbits over the speed, waterfall."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearbow._types import Array, ComplexArray
from gearbow.plotting.labels import Labels
from gearbow.plotting.orders import speed_map
from gearbow.plotting.style import (
    MICRO,
    GivenAxes,
    colour,
    label_x,
    legend,
    log_scale,
    panels,
    place_legend,
    quantity,
    remark,
    shade_operating,
    speed_axis,
    text_size,
)

#: Name of the amplitude by its unit, the unit of the figure and its factor.
_QUANTITIES = {
    "m": ("displacement", "µm", MICRO),
    "m/s": ("velocity", "mm/s", 1e3),
    "m/s²": ("acceleration", "m/s²", 1.0),
    "rad": ("twist", "mrad", 1e3),
    "N": ("force", "N", 1.0),
}
#: Smallest orbit of a figure relative to the largest one of its panels, and the size below which
#: one is shown only where all are small [m].
_VISIBLE, _TINY = 1e-5, 1e-10
#: Ratio of a peak to the median of a response from which its axis is logarithmic.
_RESONANT = 30.0
#: Directions in which a text stands from its point.
_AROUND = ((1.0, 0.5), (-1.0, 0.5), (1.0, -0.5), (-1.0, -0.5), (1.0, 1.0), (-1.0, 1.0))


@dataclass(frozen=True, eq=False)
class Curve:
    """Amplitude and phase [rad] of a signal along an axis; the phase is NaN where there is none."""

    along: Array
    size: Array
    phase: Array

    @classmethod
    def of(cls, along: Array, phasors: ComplexArray) -> "Curve":
        """Make the curve of phasors."""
        phase = np.where(phasors == 0.0, np.nan, np.angle(phasors))
        return cls(along, np.abs(phasors), phase)


def bode(
    curves: Mapping[str, Curve],
    unit: str,
    *,
    over: str = "speed",
    frf: bool = False,
    pairs: bool = False,
    peaks: Mapping[str, Sequence[tuple[float, float, str | None]]] | None = None,
    operating: tuple[float, float] | None = None,
    speed_unit: str = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw phase above amplitude; an `frf` has its amplitude above, on a logarithmic axis."""
    # Peaks have speed, amplitude and text, half-power points no text; with `pairs`, two curves each
    # have a colour.
    name, shown, scale = _QUANTITIES[unit]
    factor, label = speed_axis(speed_unit) if over == "speed" else (0.5 / np.pi, "frequency [Hz]")
    marked: list[tuple[tuple[float, float], str, Any]] = []
    still: list[str] = []
    with panels(2, 3.6, columns=1, sharex=True, ax=ax) as (figure, axes):
        amplitudes, phases = axes if frf else axes[::-1]
        for panel in axes if operating is not None else ():
            shade_operating(panel, factor * np.array(operating))
        for number, (signal, curve) in enumerate(curves.items()):
            style: dict[str, Any] = {
                "color": colour(number // 2 if pairs else number),
                "linestyle": ("-", "--", "-.", ":")[number % (2 if pairs else 4)],
            }
            known = np.isfinite(curve.phase)
            if not np.any(known & (curve.size > 0.0)):
                still.append(signal)
                continue
            # The phase has no jumps of 360°; its value at the first point is unchanged.
            turned = np.degrees(np.unwrap(curve.phase[known]))
            lines = {phases: (curve.along[known], turned)}
            own = (peaks or {}).get(signal, ())
            lines[amplitudes] = _merged(curve, own)
            if frf:
                # A logarithmic axis has no zero.
                lines[amplitudes] = (curve.along, np.where(curve.size == 0.0, np.nan, curve.size))
            for panel, (x, values) in lines.items():
                named: dict[str, Any] = {"label": signal} if panel is axes[0] else {}
                panel.plot(
                    factor * x, (scale if panel is amplitudes else 1.0) * values, **named, **style
                )
            for speed, peak, text in own:
                if text is not None:
                    at = (factor * speed, scale * peak)
                    amplitudes.plot(*at, "v", color=style["color"], markersize=8.0)
                    marked.append((at, text, style["color"]))
        if still:
            remark(axes[0], f"not excited: {', '.join(still)}")
        phases.set(ylabel="phase [°]")
        amplitudes.set(ylabel=f"{name if frf else 'amplitude'} [{shown}]")
        label_x(axes, label)
        if frf:
            log_scale(amplitudes)
        else:
            _scale(amplitudes, has_peaks=bool(marked))
        legend(figure, axes[0], ax=ax)
    labels = Labels(amplitudes, 0.0)
    for at, text, shade in marked:
        labels.add(text, [(at, way) for way in _AROUND], fontsize=text_size(0.79), color=shade)
    labels.place()
    return figure


def _scale(panel: Axes, *, has_peaks: bool) -> None:
    """Scale amplitudes: from zero, or logarithmic if a peak would press all else to the axis."""
    drawn = [np.asarray(line.get_ydata(), dtype=np.float64) for line in panel.lines]
    curves = [values for values in drawn if values.size > 1]
    sizes = np.concatenate([np.zeros(1), *curves])
    top = float(np.max(sizes, initial=0.0))
    usual = float(np.median(sizes[sizes > 0.0])) if top > 0.0 else 0.0
    if top > _RESONANT * usual > 0.0:
        log_scale(panel)
        panel.set_ylim(max(0.5 * float(sizes[sizes > 0.0].min()), 1e-3 * usual), 3.0 * top)
        return
    panel.set_ylim(bottom=0.0)
    if has_peaks:
        # The factors of the peaks stay within the panel.
        panel.set_ylim(top=1.08 * panel.get_ylim()[1])


def polar(
    curves: Mapping[str, Curve], unit: str, *, ends: str | None = None, ax: GivenAxes = None
) -> Figure:
    """Draw curves in the complex plane; with a speed unit `ends`, speeds at ends and maximum."""
    _, shown, scale = _QUANTITIES[unit]
    named: list[tuple[tuple[float, float], str, Any]] = []
    with panels(1, 7.0, columns=1, width=8.0, ax=ax) as (figure, (panel,)):
        for number, (name, curve) in enumerate(curves.items()):
            style: dict[str, Any] = {"color": colour(number), "label": name}
            points = scale * curve.size * np.exp(1j * curve.phase)
            panel.plot(points.real, points.imag, marker=".", markersize=3, **style)
            if ends is not None and np.isfinite(points).any():
                known = np.flatnonzero(np.isfinite(points))
                largest = known[np.argmax(np.abs(points[known]))]
                for i in dict.fromkeys((int(known[0]), int(largest), int(known[-1]))):
                    at = (float(points[i].real), float(points[i].imag))
                    panel.plot(*at, "o", color=style["color"], markersize=5.0)
                    speed = f"{speed_axis(ends)[0] * curve.along[i]:.4g} {ends}"
                    named.append((at, speed, style["color"]))
        panel.axhline(0.0, color="0.6", linewidth=0.8)
        panel.axvline(0.0, color="0.6", linewidth=0.8)
        panel.set_aspect("equal", adjustable="datalim")
        # Labels such as −0.0025 are longer than Matplotlib expects.
        panel.locator_params(axis="x", nbins=5)
        panel.set(xlabel=f"real part [{shown}]", ylabel=f"imaginary part [{shown}]")
        legend(figure, panel, ax=ax)
    labels = Labels(panel, 0.0)
    for at, text, shade in named:
        labels.add(text, [(at, way) for way in _AROUND], fontsize=text_size(0.79), color=shade)
    labels.place()
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
        hertz, label = frequencies / (2.0 * np.pi), f"{name} [{shown}]"
        least = float(np.min(amplitudes, where=amplitudes > 0.0, initial=amplitudes.max()))
        speed_map(panel, hertz, speeds, scale * amplitudes, label, least=scale * least)
        panel.set(ylabel=speed_axis("rad/s")[1])
    return figure


def synchronous(
    speeds: Array,
    orbits: Mapping[str, Array],
    shafts: Sequence[str],
    *,
    speed_unit: str = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw the major semi-axis of the orbits against the speed."""
    factor, label = speed_axis(speed_unit)
    with panels(len(orbits), 3.2, columns=1, sharex=True, ax=ax) as (figure, axes):
        largest = max(float(orbit.max(initial=0.0)) for orbit in orbits.values())
        least = max(_VISIBLE * largest, min(_TINY, 1e-2 * largest))
        for panel, (name, orbit) in zip(axes, orbits.items(), strict=True):
            for source, shaft in enumerate(shafts):
                if np.any(orbit[:, source] > least):
                    values = MICRO * orbit[:, source]
                    panel.plot(factor * speeds, values, label=shaft, color=colour(source))
            panel.set(ylabel=f"{name} [µm]")
            if not panel.lines:
                remark(panel, f"below {quantity(least, 'm', 2)}")
                panel.set_yticks([])
                continue
            log_scale(panel)
            if panel.get_ylim()[0] < MICRO * least:
                panel.set_ylim(bottom=MICRO * least)
        label_x(axes, label)
        # A shaft may have a line in some of the panels only.
        entries: dict[str, Any] = {}
        for panel in axes:
            handles, labels = panel.get_legend_handles_labels()
            entries |= dict(zip(labels, handles, strict=True))
        title = "excited by the shaft"
        place_legend(figure, axes[0], (list(entries.values()), list(entries)), title=title, ax=ax)
    return figure


def _merged(
    curve: Curve, further: Sequence[tuple[float, float, str | None]]
) -> tuple[Array, Array]:
    """Give a curve through its points and further ones in ascending order within its ends."""
    if not further:
        return curve.along, curve.size
    low, high = curve.along.min(), curve.along.max()
    within = [(x, y) for x, y, _ in further if low <= x <= high]
    x, y = np.array([*zip(curve.along, curve.size, strict=True), *within]).T
    order = np.argsort(x, kind="stable")
    return x[order], y[order]
