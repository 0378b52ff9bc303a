"""Figures of a Campbell diagram and of a critical speed map."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from numpy.typing import NDArray

from gearbow._types import Array
from gearbow.plotting.style import (
    MARKS,
    OPERATING,
    GivenAxes,
    log_scale,
    panels,
    place_legend,
    remark,
    shade_operating,
    smooth,
    speed_axis,
    text_extent,
    text_size,
)

#: Ratio of the largest to the smallest damping ratio above which their scale is logarithmic, and
#: the smallest damping ratio on that scale [%].
_DECADES, _LEAST_DAMPING = 10.0, 1e-3
#: Largest number of decades of positive damping ratios on a scale with negative ones.
_SIGNED_DECADES = 3
#: Damping ratio [%] above which modes do not determine the scale. Their amplification factor is
#: below 1/(2·0.2) = 2.5: API 684 (2005) counts them as critically damped.
_CRITICALLY_DAMPED = 20.0
#: Colour of the speeds at which the motion is unstable.
_UNSTABLE: dict[str, Any] = {"color": "#F09090", "alpha": 0.5, "linewidth": 0.0}
#: Marks of intersections and stability thresholds.
_CROSSED: dict[str, Any] = {
    "marker": "o",
    "linestyle": "none",
    "color": "black",
    "markersize": 5,
    "markerfacecolor": "white",
}
_THRESHOLD: dict[str, Any] = {
    "marker": "X",
    "linestyle": "none",
    "color": "black",
    "markersize": 10,
    "markerfacecolor": "#D00000",
}


def campbell(
    speeds: Array,
    frequencies_hz: Array,
    damping_ratios: Array,
    whirl: NDArray[np.str_],
    *,
    lines: Sequence[tuple[str, float]],
    intersections: Sequence[tuple[int, float, float, float]],
    thresholds: Sequence[tuple[int, float, float]] = (),
    unstable: Sequence[tuple[float, float]] = (),
    operating: tuple[float, float] | None = None,
    ax: GivenAxes = None,
) -> Figure:
    """Draw frequencies and damping ratios against the speed."""
    factor, label = speed_axis()
    top = 1.08 * float(frequencies_hz.max(initial=1.0))
    last = max(float(speeds[-1]), *(operating or (0.0,)), key=abs)
    # The whirl at speed 0 has no direction: take that of the second speed.
    if len(speeds) > 1:
        whirl = np.concatenate([whirl[1:2], whirl[1:]])
    percent = [(mode, x, y, 100.0 * z) for mode, x, y, z in intersections]
    percent += [(mode, x, y, 0.0) for mode, x, y in thresholds]
    with panels(2, 4.6, sharex=True, ax=ax, x=label, legend=False) as (figure, axes):
        upper, lower = axes
        for panel in axes:
            for span in unstable:
                panel.axvspan(*(factor * np.array(span)), **_UNSTABLE, zorder=0.6)
            if operating is not None:
                shade_operating(panel, factor * np.array(operating))
        for mode in range(frequencies_hz.shape[1]):
            known = np.array([row[1:] for row in percent if row[0] == mode]).reshape(-1, 3)
            x = factor * known[:, 0]
            own, kinds = frequencies_hz[:, mode], whirl[:, mode]
            _by_whirl(upper, (factor * speeds, own), (x, known[:, 1]), kinds)
            ratios = 100.0 * damping_ratios[:, mode]
            _by_whirl(lower, (factor * speeds, ratios), (x, known[:, 2]), kinds)
        # Negative speeds run from standstill to the left.
        far = last if abs(last) >= abs(speeds[0]) + 1.0 else speeds[0] + np.copysign(1.0, last)
        ends = factor * speeds[0], factor * far
        for panel in axes:
            panel.set_xlim(*ends)
        upper.set_ylim(0.0, top)
        _excitation_lines(upper, [(n, o / factor) for n, o in lines])
        if thresholds:
            _, x, y = np.transpose(thresholds)
            upper.plot(factor * x, y, **_THRESHOLD)
            lower.plot(factor * x, 0.0 * x, **_THRESHOLD)
        if intersections:
            _, x, y, _ = np.transpose(intersections)
            upper.plot(factor * x, y, label="intersection", **_CROSSED)
        upper.set(ylabel="frequency [Hz]")
        lower.set(ylabel="damping ratio [%]")
        _scale(lower, 100.0 * damping_ratios, signed=bool(thresholds))
        entries = _legend(whirl, bool(intersections), bool(thresholds))
        if len(unstable) > 0:
            entries["unstable"] = Patch(**_UNSTABLE)
        if operating is not None:
            entries["operating speed"] = Patch(color=OPERATING)
        place_legend(figure, upper, (list(entries.values()), list(entries)), ax=ax)
    return figure


def _legend(whirl: NDArray[np.str_], crossed: bool, limited: bool) -> dict[str, Any]:
    """Give the handles of lines and marks by label."""
    entries: dict[str, Any] = {
        name: Line2D([], [], color=shade, linestyle=line, marker=mark)
        for name, (shade, line, mark) in MARKS.items()
        if np.any(whirl == name)
    }
    if crossed:
        entries["intersection"] = Line2D([], [], **_CROSSED)
    if limited:
        entries["stability threshold"] = Line2D([], [], **_THRESHOLD)
    return entries


def _scale(panel: Axes, damping: Array, *, signed: bool) -> None:
    """Choose the scale of the damping ratios [%], so that small and large ones are legible."""
    beyond = np.abs(damping) > _CRITICALLY_DAMPED
    if beyond.any() and not beyond.all():
        damping = damping[~beyond]
        remark(panel, f"damping ratios above {_CRITICALLY_DAMPED:g} % are beyond the scale")
    sizes = np.abs(damping[np.abs(damping) > _LEAST_DAMPING])
    signed = signed or float(damping.min(initial=0.0)) < -_LEAST_DAMPING
    if signed:
        panel.axhline(0.0, color="black", linewidth=1.0)
    if sizes.size == 0 or sizes.max() < _DECADES * sizes.min():
        bottom, top = 1.1 * float(damping.min(initial=0.0)), 1.1 * float(damping.max(initial=0.0))
        # Without damping, round-off is no line of its own.
        panel.set_ylim(bottom, max(top, _LEAST_DAMPING))
    elif signed:  # an unstable mode: its negative ratio has to be visible
        _signed_scale(panel, damping)
    else:
        log_scale(panel)
        panel.set_ylim(0.7 * float(sizes.min()), 1.4 * float(sizes.max()))


def _signed_scale(panel: Axes, damping: Array) -> None:
    """Make a scale that is linear about zero and logarithmic beyond, with a label per decade."""
    low, high = float(damping.min(initial=0.0)), float(damping.max(initial=0.0))
    top = int(np.ceil(np.log10(max(high, -low))))
    first = top - _SIGNED_DECADES
    # The linear part takes as much height as a decade on each side of zero.
    panel.set_yscale("symlog", linthresh=10.0**first, linscale=1.0)
    decades = 10.0 ** np.arange(first, top + 1)
    ticks = np.concatenate([-decades[::-1], [0.0], decades])
    reach = 10.0**first
    bottom = min(1.6 * low, -0.6 * reach)
    panel.set_ylim(bottom, max(1.6 * high, reach))
    panel.yaxis.set_major_locator(FixedLocator(ticks.tolist()))
    panel.yaxis.set_minor_locator(NullLocator())
    panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


#: Width of a name beside the panel, relative to the panel, from which its gears have a line each.
_WIDE = 0.3


@dataclass
class _Above:
    """Names of excitation lines above the panel."""

    reach: float
    left: float
    names: list[str]


def _excitation_lines(panel: Axes, lines: Sequence[tuple[str, float]]) -> None:
    """Draw excitation lines within a panel with final limits, with their names at the ends."""
    (first, last), top = panel.get_xlim(), panel.get_ylim()[1]
    # Speeds of both senses have their sizes here.
    sense = np.copysign(1.0, last)
    first, last = abs(first), abs(last)
    style: dict[str, Any] = {"fontsize": text_size(0.86)}
    shift: dict[str, Any] = {"textcoords": "offset points", "annotation_clip": False}
    panel_size = panel.get_window_extent()
    beside: list[tuple[float, str]] = []
    above: list[_Above] = []
    for name, slope in sorted(lines, key=lambda line: abs(line[1])):
        slope = abs(slope)  # noqa: PLW2901
        reach = min(last, 2.0 * np.pi * top / slope) if slope else last
        if reach < first:
            continue
        path = np.array([0.0, reach])
        panel.plot(
            sense * path, slope * path / (2.0 * np.pi), color="0.45", linewidth=1.0, label=name
        )
        if reach == last:
            beside.append((slope * reach / (2.0 * np.pi), name))
            continue
        width = text_extent(panel, name, **style).width * (last - first) / panel_size.width
        if above and above[-1].left < reach + width / 2.0:
            # Names that would overlap stand one above the other, the steepest line at the top.
            above[-1].names.insert(0, name)
            above[-1].left = min(above[-1].left, above[-1].reach - width / 2.0)
        else:
            above.append(_Above(reach, reach - width / 2.0, [name]))
    free = -np.inf
    for end, name in beside:
        if text_extent(panel, name, **style).width > _WIDE * panel_size.width:
            name = name.replace("–", "–\n")  # noqa: PLW2901
        half = 0.55 * text_extent(panel, name, **style).height * top / panel_size.height
        at = max(end, free + half)
        free = at + half
        aside: dict[str, Any] = {"xytext": (5, 0), "va": "center", "ha": "left"}
        panel.annotate(name, (sense * last, at), **aside, **shift, **style)
    for group in above:
        upon: dict[str, Any] = {"xytext": (0, 3), "va": "bottom", "ha": "center"}
        panel.annotate("\n".join(group.names), (sense * group.reach, top), **upon, **shift, **style)


def _by_whirl(
    panel: Axes,
    computed: tuple[Array, Array],
    known: tuple[Array, Array],
    whirl: NDArray[np.str_],
) -> None:
    """Draw a curve in pieces with the style of their whirl."""
    speeds, values = computed
    x, y = smooth(np.concatenate([speeds, known[0]]), np.concatenate([values, known[1]]))
    changes = [0, *(np.flatnonzero(whirl[1:] != whirl[:-1]) + 1), len(whirl)]
    for first, last in pairwise(changes):
        shade, line, mark = MARKS[str(whirl[first])]
        # Each piece begins at the last point of the previous one, so that the line has no gap.
        ends = speeds[max(first - 1, 0)], speeds[last - 1]
        within = (x >= min(ends)) & (x <= max(ends))
        panel.plot(x[within], y[within], color=shade, linestyle=line, label=str(whirl[first]))
        panel.plot(
            speeds[first:last],
            values[first:last],
            color=shade,
            linestyle="none",
            marker=mark,
            markersize=5,
            markevery=max(1, len(speeds) // 24),
            label=str(whirl[first]),
        )


def critical_speed_map(
    stiffnesses: Array,
    lines: Mapping[str, Array],
    order: float,
    *,
    actual: Sequence[float] = (),
    ax: GivenAxes = None,
) -> Figure:
    """Draw critical speeds against the bearing stiffness."""
    factor, axis = speed_axis()
    with panels(1, 6.0, width=9.0, ax=ax) as (figure, (panel,)):
        for whirl, (shade, line, mark) in MARKS.items():
            style: dict[str, Any] = {
                "color": shade,
                "linestyle": line,
                "marker": mark,
                "markersize": 4,
            }
            for number, speeds in enumerate(lines[whirl].T if whirl in lines else ()):
                label = whirl if number == 0 else None
                panel.plot(stiffnesses, factor * np.abs(speeds), label=label, **style)
        panel.set_xscale("log")
        log_scale(panel)
        if actual:
            _span(panel, min(actual), max(actual), "stiffness of the system")
        panel.set(xlabel="stiffness of every bearing [N/m]")
        panel.set(ylabel=f"critical {axis}" + (" × −1" if order < 0.0 else ""))
        if order != 1.0:
            panel.set(title=f"excitation of the order {order:g}")
    return figure


def _span(panel: Axes, low: float, high: float, label: str) -> None:
    """Shade a range of a logarithmic axis; a narrow one is a line."""
    if high > 1.05 * low:
        panel.axvspan(low, high, color="0.85", linewidth=0.0, zorder=0.5, label=label)
    else:
        panel.axvline(low, color="0.4", linestyle=(0, (6, 3)), zorder=0.5, label=label)
