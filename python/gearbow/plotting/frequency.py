"""Figures against the speed: Campbell diagram, critical speed map, Bode plot, orbits."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from gearbow._types import Array
from gearbow.plotting.style import (
    MICRO,
    PALETTE,
    GivenAxes,
    colour,
    label_x,
    legend,
    panels,
    place_legend,
    speed_axis,
    text_size,
)

__all__ = ["MARKS", "bode", "campbell", "critical_speed_map", "synchronous"]

#: Colour, line style and marker of each whirl. They differ without colour too.
MARKS: dict[str, tuple[str, Any, str]] = {
    "forward": (PALETTE[0], "-", "^"),
    "backward": (PALETTE[1], "--", "v"),
    "planar": (PALETTE[5], "-", "s"),
    "torsion": (PALETTE[2], "-.", "o"),
    "coupled": (PALETTE[3], ":", "D"),
    "rigid": (PALETTE[6], "-", "."),
}

#: Ratio of the largest to the smallest damping ratio above which their scale is logarithmic, and
#: the smallest damping ratio on that scale [%].
_DECADES, _LEAST_DAMPING = 10.0, 1e-3
#: Colour of the operating speeds.
_OPERATING = "0.88"


def campbell(
    speeds: Array,
    frequencies_hz: Array,
    damping_ratios: Array,
    whirl: NDArray[np.str_],
    *,
    lines: Sequence[tuple[str, float]],
    intersections: Sequence[tuple[float, float]],
    operating: tuple[float, float] | None = None,
    speed_unit: str = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw frequencies and damping ratios against the speed.

    Parameters
    ----------
    speeds : ndarray, shape (k,)
        Speeds of the reference shaft [rad/s].
    frequencies_hz : ndarray, shape (k, m)
        Natural frequencies [Hz].
    damping_ratios : ndarray, shape (k, m)
        Damping ratios.
    whirl : ndarray of str, shape (k, m)
        Whirl of each mode.
    lines : sequence of (str, float)
        Name and order of each excitation line.
    intersections : sequence of (float, float)
        Speed [rad/s] and frequency [Hz] of each intersection.
    operating : (float, float), optional
        Lowest and highest operating speed [rad/s].
    speed_unit : {"rad/s", "rpm"}
        Unit of the axis of speeds.
    ax : Axes or sequence of two Axes, optional
        Panels of the user.

    Returns
    -------
    matplotlib.figure.Figure
        Frequencies with excitation lines and intersections above, damping ratios below.
    """
    factor, label = speed_axis(speed_unit)
    top = 1.08 * float(frequencies_hz.max(initial=1.0))
    last = max(float(speeds[-1]), *(operating or (0.0,)))
    # The whirl at speed 0 has no direction: take that of the second speed.
    if len(speeds) > 1:
        whirl = np.concatenate([whirl[1:2], whirl[1:]])
    with panels(2, 4.6, columns=1, sharex=True, ax=ax) as (figure, axes):
        upper, lower = axes
        for panel in axes if operating is not None else ():
            _operating(panel, factor * np.array(operating))
        for mode in range(frequencies_hz.shape[1]):
            _by_whirl(upper, factor * speeds, frequencies_hz[:, mode], whirl[:, mode])
            _by_whirl(lower, factor * speeds, 100.0 * damping_ratios[:, mode], whirl[:, mode])
        _excitation_lines(upper, [(n, o / factor) for n, o in lines], factor * last, top)
        if intersections:
            x, y = np.transpose(intersections)
            upper.plot(factor * x, y, "o", color="black", markersize=5, markerfacecolor="white")
        upper.set(ylabel="frequency [Hz]", ylim=(0.0, top))
        lower.set(ylabel="damping ratio [%]")
        _scale(lower, 100.0 * damping_ratios)
        label_x(axes, label)
        for panel in axes:
            panel.set_xlim(factor * speeds[0], factor * max(last, speeds[0] + 1.0))
        shown = [name for name in MARKS if np.any(whirl == name)]
        handles: list[Any] = [
            Line2D([], [], color=MARKS[name][0], linestyle=MARKS[name][1], marker=MARKS[name][2])
            for name in shown
        ]
        if operating is not None:
            handles.append(Patch(color=_OPERATING))
            shown.append("operating speed")
        place_legend(figure, upper, (handles, shown), ax=ax)
    return figure


def critical_speed_map(
    stiffnesses: Array,
    lines: Mapping[str, Array],
    excitation: float,
    *,
    actual: Sequence[float] = (),
    speed_unit: str = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw critical speeds against the bearing stiffness.

    Parameters
    ----------
    stiffnesses : ndarray, shape (k,)
        Stiffness of every bearing [N/m].
    lines : mapping of {str: ndarray of shape (k, m)}
        Critical speeds [rad/s] of each whirl.
    excitation : float
        Order of the excitation.
    actual : sequence of float
        Stiffnesses of the bearings of the system [N/m].
    speed_unit : {"rad/s", "rpm"}
        Unit of the axis of speeds.
    ax : Axes, optional
        Panel of the user.

    Returns
    -------
    matplotlib.figure.Figure
        Critical speeds against stiffness, both axes logarithmic.
    """
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
                panel.loglog(stiffnesses, factor * speeds, label=label, **style)
        if actual:
            _span(panel, min(actual), max(actual), "stiffness of the system")
        panel.set(xlabel="stiffness of every bearing [N/m]")
        panel.set(ylabel=f"critical speed [{speed_unit}]", title=f"ω = {excitation:g} Ω")
        legend(figure, panel, ax=ax)
    return figure


def bode(
    speeds: Array,
    lines: Mapping[str, tuple[Array, Array]],
    *,
    speed_unit: str = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw phase and amplitude against the speed.

    Parameters
    ----------
    speeds : ndarray, shape (speeds,)
        Speeds of the reference shaft [rad/s].
    lines : mapping of {str: tuple of ndarray of shape (speeds,)}
        Phase [rad] and major semi-axis of the orbit [m] by label.
    speed_unit : {"rad/s", "rpm"}
        Unit of the axis of speeds.
    ax : sequence of two Axes, optional
        Panels of the user.

    Returns
    -------
    matplotlib.figure.Figure
        Phase [°] above, major semi-axis of the orbits [µm] below.
    """
    factor, label = speed_axis(speed_unit)
    with panels(2, 3.6, columns=1, sharex=True, ax=ax) as (figure, axes):
        upper, lower = axes
        for number, (name, (phase, amplitude)) in enumerate(lines.items()):
            style: dict[str, Any] = {
                "color": colour(number),
                "linestyle": ("-", "--", "-.", ":")[number % 4],
            }
            known = np.isfinite(phase)
            # The phase has no jumps of 360°; its value at the first speed is unchanged.
            upper.plot(
                factor * speeds[known], np.degrees(np.unwrap(phase[known])), label=name, **style
            )
            lower.plot(factor * speeds, MICRO * amplitude, **style)
        upper.set(ylabel="phase [°]")
        lower.set(ylabel="amplitude [µm]")
        label_x(axes, label)
        lower.set_ylim(bottom=0.0)
        legend(figure, upper, ax=ax)
    return figure


def synchronous(
    speeds: Array,
    orbits: Mapping[str, Array],
    shafts: Sequence[str],
    *,
    speed_unit: str = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw the major semi-axis of the orbits against the speed.

    Parameters
    ----------
    speeds : ndarray, shape (speeds,)
        Speeds of the reference shaft [rad/s].
    orbits : mapping of {str: ndarray of shape (speeds, shafts)}
        Major semi-axis of the orbit [m] for each shaft as the source, by label.
    shafts : sequence of str
        Names of the shafts.
    speed_unit : {"rad/s", "rpm"}
        Unit of the axis of speeds.
    ax : Axes or sequence of Axes, optional
        Panels of the user, one for each label.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each label, one line for each shaft as the source.
    """
    factor, label = speed_axis(speed_unit)
    with panels(len(orbits), 3.2, columns=1, sharex=True, ax=ax) as (figure, axes):
        for panel, (name, orbit) in zip(axes, orbits.items(), strict=True):
            for source, shaft in enumerate(shafts):
                if np.any(orbit[:, source] > 0.0):
                    values = MICRO * orbit[:, source]
                    panel.semilogy(factor * speeds, values, label=shaft, color=colour(source))
            panel.set(ylabel=f"{name} [µm]")
        label_x(axes, label)
        legend(figure, axes[0], title="excited by the shaft", ax=ax)
    return figure


def _operating(panel: Axes, speeds: Array) -> None:
    """Shade the operating speeds; a single one is a line."""
    if speeds[0] == speeds[1]:
        panel.axvline(speeds[0], color=_OPERATING, linewidth=6.0, zorder=0.5)
    else:
        panel.axvspan(*speeds, color=_OPERATING, linewidth=0.0, zorder=0.5)


def _span(panel: Axes, low: float, high: float, label: str) -> None:
    """Shade a range of a logarithmic axis; a narrow one is a line."""
    if high > 1.05 * low:
        panel.axvspan(low, high, color="0.85", linewidth=0.0, zorder=0.5, label=label)
    else:
        panel.axvline(low, color="0.4", linestyle=(0, (6, 3)), zorder=0.5, label=label)


def _scale(panel: Axes, damping: Array) -> None:
    """Choose the scale of the damping ratios [%], so that small and large ones are legible."""
    sizes = np.abs(damping[np.abs(damping) > _LEAST_DAMPING])
    if sizes.size == 0 or sizes.max() < _DECADES * sizes.min():
        panel.set_ylim(bottom=min(0.0, 1.1 * float(damping.min(initial=0.0))))
        return
    if damping.min() < -_LEAST_DAMPING:  # an unstable mode: its negative ratio has to be visible
        panel.set_yscale("symlog", linthresh=float(sizes.min()))
        panel.axhline(0.0, color="black", linewidth=1.0)
    else:
        panel.set_yscale("log", subs=(2, 5))
        for axis in (panel.yaxis.set_major_formatter, panel.yaxis.set_minor_formatter):
            axis(FuncFormatter(lambda value, _: f"{value:g}"))
        panel.set_ylim(0.7 * float(sizes.min()), 1.4 * float(sizes.max()))


def _excitation_lines(
    panel: Axes, lines: Sequence[tuple[str, float]], last: float, top: float
) -> None:
    """Draw excitation lines within the axes, with their names at the ends.

    The slope of a line is 2π times the frequency [Hz] over the speed in the unit of the axis.
    """
    # A line of text takes about a twentieth of the height.
    space, free = 0.055 * top, -np.inf
    for name, slope in sorted(lines, key=lambda line: abs(line[1])):
        reach = min(last, 2.0 * np.pi * top / slope) if slope else last
        ends = np.array([0.0, reach])
        panel.plot(ends, slope * ends / (2.0 * np.pi), color="0.45", linewidth=1.0)
        end = slope * reach / (2.0 * np.pi)
        inside = reach == last
        at = max(end, free) if inside else end
        free = at + space
        panel.annotate(
            name,
            (reach, at),
            xytext=(5, 0) if inside else (0, 3),
            textcoords="offset points",
            va="center" if inside else "bottom",
            ha="left" if inside else "center",
            fontsize=text_size(0.86),
            annotation_clip=False,
        )


def _by_whirl(panel: Axes, speeds: Array, values: Array, whirl: NDArray[np.str_]) -> None:
    """Draw a line in pieces with the style of their whirl."""
    changes = [0, *(np.flatnonzero(whirl[1:] != whirl[:-1]) + 1), len(whirl)]
    for first, last in pairwise(changes):
        shade, line, mark = MARKS[str(whirl[first])]
        # Each piece begins at the last point of the previous one, so that the line has no gap.
        piece = slice(max(first - 1, 0), last)
        panel.plot(
            speeds[piece],
            values[piece],
            color=shade,
            linestyle=line,
            marker=mark,
            markersize=5,
            markevery=max(1, len(speeds) // 12),
        )
