"""Figures against the speed: Campbell diagram, critical speed map, Bode plot, orbits."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from gearbow._types import Array
from gearbow.plotting.style import MICRO, PALETTE, colour, legend, panels

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

_SPEED = "speed of the reference shaft [rad/s]"


def campbell(
    speeds: Array,
    frequencies_hz: Array,
    damping_ratios: Array,
    whirl: NDArray[np.str_],
    *,
    lines: Sequence[tuple[str, float]],
    intersections: Sequence[tuple[float, float]],
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

    Returns
    -------
    matplotlib.figure.Figure
        Frequencies with excitation lines and intersections above, damping ratios below.
    """
    top = 1.08 * float(frequencies_hz.max(initial=1.0))
    # The whirl at speed 0 has no direction: take that of the second speed.
    if len(speeds) > 1:
        whirl = np.concatenate([whirl[1:2], whirl[1:]])
    with panels(2, 4.6, columns=1, sharex=True) as (figure, (upper, lower)):
        for mode in range(frequencies_hz.shape[1]):
            _by_whirl(upper, speeds, frequencies_hz[:, mode], whirl[:, mode])
            _by_whirl(lower, speeds, 100.0 * damping_ratios[:, mode], whirl[:, mode])
        for name, order in lines:
            _excitation_line(upper, name, order, float(speeds[-1]), top)
        if intersections:
            x, y = np.transpose(intersections)
            upper.plot(x, y, "o", color="black", markersize=5, markerfacecolor="white")
        upper.set(ylabel="frequency [Hz]", ylim=(0.0, top))
        lower.set(ylabel="damping ratio [%]", xlabel=_SPEED)
        lower.set_xlim(speeds[0], max(speeds[-1], speeds[0] + 1.0))
        shown = [name for name in MARKS if np.any(whirl == name)]
        handles = [
            Line2D([], [], color=MARKS[name][0], linestyle=MARKS[name][1], marker=MARKS[name][2])
            for name in shown
        ]
        figure.legend(handles, shown, loc="outside upper left", ncols=len(shown))
    return figure


def critical_speed_map(stiffnesses: Array, lines: Mapping[str, Array], excitation: float) -> Figure:
    """Draw critical speeds against the bearing stiffness.

    Parameters
    ----------
    stiffnesses : ndarray, shape (k,)
        Stiffness of every bearing [N/m].
    lines : mapping of {str: ndarray of shape (k, m)}
        Critical speeds [rad/s] of each whirl.
    excitation : float
        Order of the excitation.

    Returns
    -------
    matplotlib.figure.Figure
        Critical speeds against stiffness, both axes logarithmic.
    """
    with panels(1, 6.0, columns=1, width=9.0) as (figure, (panel,)):
        for whirl, (shade, line, mark) in MARKS.items():
            style: dict[str, Any] = {
                "color": shade,
                "linestyle": line,
                "marker": mark,
                "markersize": 4,
            }
            for number, speeds in enumerate(lines[whirl].T if whirl in lines else ()):
                label = whirl if number == 0 else None
                panel.loglog(stiffnesses, speeds, label=label, **style)
        panel.set(xlabel="stiffness of every bearing [N/m]", ylabel="critical speed [rad/s]")
        panel.set_title(f"ω = {excitation:g} Ω")
        legend(figure, panel)
    return figure


def bode(speeds: Array, lines: Mapping[str, tuple[Array, Array]]) -> Figure:
    """Draw phase and amplitude against the speed.

    Parameters
    ----------
    speeds : ndarray, shape (speeds,)
        Speeds of the reference shaft [rad/s].
    lines : mapping of {str: tuple of ndarray of shape (speeds,)}
        Phase [rad] and major semi-axis of the orbit [m] by label.

    Returns
    -------
    matplotlib.figure.Figure
        Phase [°] above, major semi-axis of the orbits [µm] below.
    """
    with panels(2, 3.6, columns=1, sharex=True) as (figure, (upper, lower)):
        for number, (label, (phase, amplitude)) in enumerate(lines.items()):
            style: dict[str, Any] = {
                "color": colour(number),
                "linestyle": ("-", "--", "-.", ":")[number % 4],
            }
            known = np.isfinite(phase)
            # The phase has no jumps of 360°; its value at the first speed is unchanged.
            upper.plot(speeds[known], np.degrees(np.unwrap(phase[known])), label=label, **style)
            lower.plot(speeds, MICRO * amplitude, **style)
        upper.set(ylabel="phase [°]")
        lower.set(ylabel="amplitude [µm]", xlabel=_SPEED)
        lower.set_ylim(bottom=0.0)
        legend(figure, upper)
    return figure


def synchronous(speeds: Array, orbits: Mapping[str, Array], shafts: Sequence[str]) -> Figure:
    """Draw the major semi-axis of the orbits against the speed.

    Parameters
    ----------
    speeds : ndarray, shape (speeds,)
        Speeds of the reference shaft [rad/s].
    orbits : mapping of {str: ndarray of shape (speeds, shafts)}
        Major semi-axis of the orbit [m] for each shaft as the source, by label.
    shafts : sequence of str
        Names of the shafts.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each label, one line for each shaft as the source.
    """
    with panels(len(orbits), 2.8, columns=1, sharex=True) as (figure, axes):
        for panel, (label, orbit) in zip(axes, orbits.items(), strict=True):
            for source, shaft in enumerate(shafts):
                if np.any(orbit[:, source] > 0.0):
                    values = MICRO * orbit[:, source]
                    panel.semilogy(speeds, values, label=shaft, color=colour(source))
            panel.set(ylabel=f"{label} [µm]")
        axes[-1].set(xlabel=_SPEED)
        legend(figure, axes[0], title="excited by the shaft")
    return figure


def _excitation_line(panel: Axes, name: str, order: float, last: float, top: float) -> None:
    """Draw an excitation line within the axes, with its name at its end."""
    reach = min(last, 2.0 * np.pi * top / order) if order else last
    ends = np.array([0.0, reach])
    panel.plot(ends, order * ends / (2.0 * np.pi), color="0.45", linewidth=1.0)
    inside = reach == last
    panel.annotate(
        name,
        (reach, order * reach / (2.0 * np.pi)),
        xytext=(4, 0) if inside else (6, -2),
        textcoords="offset points",
        va="center" if inside else "top",
        fontsize=12,
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
