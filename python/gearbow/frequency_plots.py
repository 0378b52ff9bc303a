"""Figures of answers over the speed: Campbell diagram, critical speed map, Bode plot."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from gearbow._describe import places
from gearbow._types import Array, At
from gearbow.errors import GearbowError
from gearbow.plots import PALETTE, _colour, _figure, _label, _legend

if TYPE_CHECKING:
    from gearbow.campbell import Campbell
    from gearbow.critical import CriticalSpeedMap
    from gearbow.synchronous import Synchronous

__all__ = ["MARKS", "bode", "campbell", "critical_speed_map"]

#: What stands for a whirl: colour, line and mark, so that no reader needs the colour.
MARKS: dict[str, tuple[str, Any, str]] = {
    "forward": (PALETTE[0], "-", "^"),
    "backward": (PALETTE[1], "--", "v"),
    "planar": (PALETTE[5], "-", "s"),
    "torsion": (PALETTE[2], "-.", "o"),
    "coupled": (PALETTE[3], ":", "D"),
    "rigid": (PALETTE[6], "-", "."),
}

_MICRO = 1e6


def campbell(diagram: "Campbell") -> Figure:
    """Draw frequencies and damping ratios against the speed.

    Parameters
    ----------
    diagram : Campbell
        The diagram.

    Returns
    -------
    matplotlib.figure.Figure
        Frequencies with the excitation lines and the intersections above, damping ratios below.
    """
    speeds, frequencies = diagram.speeds, diagram.frequencies_hz
    top = 1.08 * float(frequencies.max(initial=1.0))
    # At rest no whirl has a sense: a line begins as it goes on.
    whirl = (
        np.concatenate([diagram.whirl[1:2], diagram.whirl[1:]])
        if len(speeds) > 1
        else diagram.whirl
    )
    with _figure(2, 4.6, columns=1, sharex=True) as (figure, panels):
        for mode in range(frequencies.shape[1]):
            _by_whirl(panels[0], speeds, frequencies[:, mode], whirl[:, mode])
            _by_whirl(panels[1], speeds, 100.0 * diagram.damping_ratios[:, mode], whirl[:, mode])
        for line in diagram.lines:
            reach = min(speeds[-1], 2.0 * np.pi * top / line.order) if line.order else speeds[-1]
            ends = np.array([0.0, reach])
            panels[0].plot(ends, line.order * ends / (2.0 * np.pi), color="0.45", linewidth=1.0)
            # Its name stands at the edge where it leaves what is shown.
            inside = reach == speeds[-1]
            panels[0].annotate(
                line.name,
                (reach, line.order * reach / (2.0 * np.pi)),
                xytext=(4, 0) if inside else (6, -2),
                textcoords="offset points",
                va="center" if inside else "top",
                fontsize=12,
            )
        met = [
            (intersection.speed, intersection.frequency_hz)
            for intersection in diagram.intersections
        ]
        if met:
            panels[0].plot(
                *np.transpose(met), "o", color="black", markersize=5, markerfacecolor="white"
            )
        panels[0].set(ylabel="frequency [Hz]", ylim=(0.0, top))
        panels[1].set(ylabel="damping ratio [%]", xlabel="speed of the reference shaft [rad/s]")
        panels[1].set_xlim(speeds[0], max(speeds[-1], speeds[0] + 1.0))
        shown = [name for name in MARKS if np.any(whirl == name)]
        handles = [
            Line2D([], [], color=MARKS[name][0], linestyle=MARKS[name][1], marker=MARKS[name][2])
            for name in shown
        ]
        figure.legend(handles, shown, loc="outside upper left", ncols=len(shown))
    return figure


def critical_speed_map(found: "CriticalSpeedMap", count: int = 4) -> Figure:
    """Draw critical speeds against the stiffness of the bearings.

    Parameters
    ----------
    found : CriticalSpeedMap
        The map.
    count : int
        How many lines of each whirl.

    Returns
    -------
    matplotlib.figure.Figure
        Both axes logarithmic.
    """
    with _figure(1, 6.0, columns=1, width=9.0) as (figure, (panel,)):
        for whirl, (colour, line, mark) in MARKS.items():
            try:
                lines = found.lines(whirl)[:, :count]
            except GearbowError:
                continue
            style: dict[str, Any] = {
                "color": colour,
                "linestyle": line,
                "marker": mark,
                "markersize": 4,
            }
            for number, speeds in enumerate(lines.T):
                label = whirl if number == 0 else None
                panel.loglog(found.stiffnesses, speeds, label=label, **style)
        panel.set(xlabel="stiffness of every bearing [N/m]", ylabel="critical speed [rad/s]")
        panel.set_title(f"ω = {found.excitation:g} Ω")
        _legend(figure, panel)
    return figure


def bode(response: "Synchronous", names: At | Sequence[At], source: str | None = None) -> Figure:
    """Draw phase and amplitude against the speed.

    Parameters
    ----------
    response : Synchronous
        The linear response.
    names : str, tuple of (str, float), or sequence of them
        Gears, disks or (shaft, position [m]).
    source : str, optional
        The shaft that excites; None is the shaft of each place.

    Returns
    -------
    matplotlib.figure.Figure
        Phase [°] above, the largest semi-axis of the orbits [µm] below.
    """
    with _figure(2, 3.6, columns=1, sharex=True) as (figure, (upper, lower)):
        for number, name in enumerate(places(names, "names")):
            own = response.system.dofs[response.system._lateral(name)[0]][0]
            shaft = response.shafts.index(own if source is None else source)
            style: dict[str, Any] = {
                "color": _colour(number),
                "linestyle": ("-", "--", "-.", ":")[number % 4],
            }
            phase = response.phase(name)[:, shaft]
            known = np.isfinite(phase)
            # Without jumps of a turn, from where it stands at the first speed.
            turned = np.degrees(np.unwrap(phase[known]))
            upper.plot(response.speeds[known], turned, label=_label(name), **style)
            lower.plot(response.speeds, _MICRO * response.orbit(name)[:, shaft], **style)
        upper.set(ylabel="phase [°]")
        lower.set(ylabel="amplitude [µm]", xlabel="speed of the reference shaft [rad/s]")
        lower.set_ylim(bottom=0.0)
        _legend(figure, upper)
    return figure


def _by_whirl(panel: Axes, speeds: Array, values: Array, whirl: NDArray[np.str_]) -> None:
    """Draw a line in pieces, each in the style of its whirl."""
    changes = [0, *(np.flatnonzero(whirl[1:] != whirl[:-1]) + 1), len(whirl)]
    for first, last in pairwise(changes):
        colour, line, mark = MARKS[str(whirl[first])]
        # A piece reaches the first point of the next, so that the line has no gap.
        piece = slice(max(first - 1, 0), last)
        every = max(1, len(speeds) // 12)
        panel.plot(
            speeds[piece],
            values[piece],
            color=colour,
            linestyle=line,
            marker=mark,
            markersize=5,
            markevery=every,
        )
