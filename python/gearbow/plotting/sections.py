"""Figures of section forces along the shafts."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.style import GivenAxes, colour, common_round_off, panels, text_size

#: Label of each panel, and the indices and names of its section forces.
_PANELS: tuple[tuple[str, dict[int, str]], ...] = (
    ("axial force [N]", {0: "N"}),
    ("shear force [N]", {1: "along y", 2: "along z"}),
    ("bending [N m]", {3: "about y", 4: "about z"}),
    ("torque [N m]", {5: "T"}),
)


class Course(NamedTuple):
    """Section forces along a shaft."""

    #: Positions of the sections, shape (k,) [m].
    positions: Array
    #: Smallest and largest section forces, shape (k, 6) [N, N m].
    low: Array
    high: Array
    #: Position [m] and name of what acts on the shaft.
    marks: Sequence[tuple[float, str]] = ()


def section_forces(courses: Mapping[str, Course], *, ax: GivenAxes = None) -> Figure:
    """Draw axial and shear force, bending moment and torque along shafts, a column for each."""
    columns = len(courses)
    count, width = len(_PANELS) * columns, max(7.0, 4.6 * columns)
    with panels(count, 2.1, columns=columns, width=width, sharex=True, ax=ax) as (figure, axes):
        for column, (shaft, course) in enumerate(courses.items()):
            own = axes[column::columns]
            for panel, (label, lines) in zip(own, _PANELS, strict=True):
                _draw(panel, course, lines)
                panel.set(ylabel=label if column == 0 else None)
            for x, name in course.marks:
                style: dict[str, Any] = {
                    "rotation": 40.0,
                    "fontsize": text_size(0.75),
                    "ha": "left",
                }
                own[0].text(
                    x, 1.02, name, transform=own[0].get_xaxis_transform(), va="bottom", **style
                )
            own[-1].set_xlabel(f"position on {shaft} [m]")
        for row in range(len(_PANELS)):
            common_round_off(axes[row * columns : (row + 1) * columns])
    return figure


def _draw(panel: Axes, course: Course, lines: Mapping[int, str]) -> None:
    """Draw the section forces of one panel between their smallest and largest values."""
    x = course.positions
    for number, (index, name) in enumerate(lines.items()):
        low, high = course.low[:, index], course.high[:, index]
        if (low != high).any():
            panel.fill_between(x, low, high, color=colour(number), alpha=0.25, linewidth=0.0)
            panel.plot(x, low, color=colour(number), linewidth=1.0)
        panel.plot(x, high, color=colour(number), linewidth=1.4, label=name)
    panel.axhline(0.0, color="0.6", linewidth=0.7, zorder=0.0)
    for at, _ in course.marks:
        panel.axvline(at, color="0.75", linewidth=0.7, linestyle=":", zorder=0.0)
    if len(lines) > 1:
        panel.legend(loc="best", fontsize=text_size(0.8))


def stresses(courses: Mapping[str, Sequence[Array]], *, ax: GivenAxes = None) -> Figure:
    """Draw positions [m], amplitudes and means of equivalent stresses [Pa] and utilisations."""
    # A row for each shaft: a page is as wide for many shafts as for one.
    has_limit = any(np.isfinite(course[3]).any() for course in courses.values())
    columns = 1 + has_limit
    with panels(
        columns * len(courses), 2.6, columns=columns, width=7.0 if columns == 1 else 12.0, ax=ax
    ) as (figure, axes):
        for row, (shaft, (x, amplitude, mean, utilisation)) in enumerate(courses.items()):
            own = axes[row * columns : (row + 1) * columns]
            own[0].plot(x, 1e-6 * amplitude, color=colour(0), label="amplitude, with notch factors")
            own[0].plot(x, 1e-6 * mean, color=colour(1), label="mean")
            own[0].set_ylabel("stress [MPa]")
            own[0].set_title(shaft, loc="left")
            if row == 0:
                own[0].legend(loc="best", fontsize=text_size(0.8))
            if has_limit:
                own[1].plot(x, utilisation, color=colour(2))
                own[1].axhline(1.0, color="0.5", linestyle="--", linewidth=0.9)
                own[1].set_ylabel("utilisation")
            for panel in own:
                panel.set_ylim(bottom=0.0)
                panel.locator_params(axis="x", nbins=6)
                panel.set_xlabel("position [m]")
    return figure
