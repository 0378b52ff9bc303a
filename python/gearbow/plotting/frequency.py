"""Figures against the speed: critical speed map, Bode plot, orbits."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.labels import Labels
from gearbow.plotting.style import (
    MARKS,
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

__all__ = ["bode", "critical_speed_map", "synchronous"]

#: Smallest orbit of a figure relative to the largest one of its panels, and the size below which
#: one is shown only where all are small [m].
_VISIBLE, _TINY = 1e-5, 1e-10
#: Ratio of a peak to the median of a response from which its axis is logarithmic.
_RESONANT = 30.0
#: Directions in which the amplification factor of a peak stands from it.
_AROUND_A_PEAK = ((1.0, 0.5), (-1.0, 0.5), (1.0, -0.5), (-1.0, -0.5), (1.0, 1.0), (-1.0, 1.0))


def critical_speed_map(
    stiffnesses: Array,
    lines: Mapping[str, Array],
    order: float,
    *,
    actual: Sequence[float] = (),
    speed_unit: str = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw critical speeds against the bearing stiffness."""
    factor, _ = speed_axis(speed_unit)
    with panels(1, 6.0, columns=1, width=9.0, ax=ax) as (figure, (panel,)):
        for whirl, (shade, line, mark) in MARKS.items():
            style: dict[str, Any] = {
                "color": shade,
                "linestyle": line,
                "marker": mark,
                "markersize": 4,
            }
            for number, speeds in enumerate(lines[whirl].T if whirl in lines else ()):
                label = whirl if number == 0 else None
                panel.plot(stiffnesses, factor * speeds, label=label, **style)
        panel.set_xscale("log")
        log_scale(panel)
        if actual:
            _span(panel, min(actual), max(actual), "stiffness of the system")
        panel.set(xlabel="stiffness of every bearing [N/m]")
        panel.set(ylabel=f"critical speed of the reference shaft [{speed_unit}]")
        if order != 1.0:
            panel.set(title=f"excitation of the order {order:g}")
        legend(figure, panel, ax=ax)
    return figure


def bode(
    speeds: Array,
    lines: Mapping[str, tuple[Array, Array]],
    *,
    unit: str = "m",
    peaks: Mapping[str, Sequence[tuple[float, float, str]]] | None = None,
    known: Mapping[str, tuple[Array, Array]] | None = None,
    operating: tuple[float, float] | None = None,
    speed_unit: str = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw phase and amplitude against the speed; `known` has further points of amplitudes."""
    factor, label = speed_axis(speed_unit)
    size, shown = (MICRO, "µm") if unit == "m" else (1.0, unit)
    with panels(2, 3.6, columns=1, sharex=True, ax=ax) as (figure, axes):
        upper, lower = axes
        for panel in axes if operating is not None else ():
            shade_operating(panel, factor * np.array(operating))
        still: list[str] = []
        marked: list[tuple[tuple[float, float], str, Any]] = []
        for number, (name, (phase, amplitude)) in enumerate(lines.items()):
            style: dict[str, Any] = {
                "color": colour(number),
                "linestyle": ("-", "--", "-.", ":")[number % 4],
            }
            has_phase = np.isfinite(phase)
            if not np.any(has_phase & (amplitude > 0.0)):
                still.append(name)
                continue
            # The phase has no jumps of 360°; its value at the first speed is unchanged.
            upper.plot(
                factor * speeds[has_phase],
                np.degrees(np.unwrap(phase[has_phase])),
                label=name,
                **style,
            )
            curve = _merged((speeds, amplitude), (known or {}).get(name))
            lower.plot(factor * curve[0], size * curve[1], **style)
            for x, y, text in (peaks or {}).get(name, ()):
                lower.plot(factor * x, size * y, "v", color=style["color"], markersize=8.0)
                marked.append(((factor * x, size * y), text, style["color"]))
        if still:
            remark(upper, f"not excited: {', '.join(still)}")
        upper.set(ylabel="phase [°]")
        lower.set(ylabel=f"amplitude [{shown}]")
        label_x(axes, label)
        drawn = [np.asarray(line.get_ydata(), dtype=np.float64) for line in lower.lines]
        curves = [values for values in drawn if values.size > 1]
        sizes = np.concatenate([np.zeros(1), *curves])
        top = float(np.max(sizes, initial=0.0))
        usual = float(np.median(sizes[sizes > 0.0])) if top > 0.0 else 0.0
        if top > _RESONANT * usual > 0.0:
            # Beside the peak of a lightly damped mode, all else would lie on the axis.
            log_scale(lower)
            lower.set_ylim(max(0.5 * float(sizes[sizes > 0.0].min()), 1e-3 * usual), 3.0 * top)
        else:
            lower.set_ylim(bottom=0.0)
            if peaks and any(peaks.values()):
                # The factors of the peaks stay within the panel.
                lower.set_ylim(top=1.08 * lower.get_ylim()[1])
        legend(figure, upper, ax=ax)
    labels = Labels(lower, 0.0)
    for at, text, shade in marked:
        labels.add(
            text, [(at, way) for way in _AROUND_A_PEAK], fontsize=text_size(0.79), color=shade
        )
    labels.place()
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


def _merged(curve: tuple[Array, Array], further: tuple[Array, Array] | None) -> tuple[Array, Array]:
    """Give a curve through its points and further ones in ascending order within its ends."""
    speeds, values = curve
    if further is None or not further[0].size:
        return speeds, values
    within = (further[0] >= speeds.min()) & (further[0] <= speeds.max())
    x = np.concatenate([speeds, further[0][within]])
    order = np.argsort(x, kind="stable")
    return x[order], np.concatenate([values, further[1][within]])[order]


def _span(panel: Axes, low: float, high: float, label: str) -> None:
    """Shade a range of a logarithmic axis; a narrow one is a line."""
    if high > 1.05 * low:
        panel.axvspan(low, high, color="0.85", linewidth=0.0, zorder=0.5, label=label)
    else:
        panel.axvline(low, color="0.4", linestyle=(0, (6, 3)), zorder=0.5, label=label)
