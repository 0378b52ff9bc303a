"""Texts of a figure as the reader sees them: which overlap, and which the figure cuts off."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.text import Text
from matplotlib.transforms import Bbox

#: Share of a text that another one may cover, or that may lie outside the figure: boxes of texts that touch.
TOUCHING = 0.05


def texts_of(figure: Any) -> list[Text]:
    """Return all visible texts: titles, labels and numbers of axes, names in panels, legends."""
    found = [text for legend in figure.legends for text in legend.get_texts()]
    for panel in figure.axes:
        found += [*panel.texts, panel.title, panel._left_title, panel._right_title]
        found += [text for legend in [panel.get_legend()] if legend for text in legend.get_texts()]
        for axis in (panel.xaxis, panel.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
            found += [axis.label, *(tick.label1 for tick in ticks)]
    return [text for text in found if text.get_visible() and text.get_text().strip()]


def box_of(text: Text) -> Bbox:
    text.get_window_extent()  # moves an annotation to its place
    return Text.get_window_extent(text)  # without the line to its anchor


def box_along(text: Text) -> Bbox:
    """Return the box of a text in axes along and across its lines, about the corner of the figure."""
    angle, (x, y) = np.radians(text.get_rotation()), np.mean(box_of(text).get_points(), axis=0)
    text.set_rotation(0.0)
    size = np.array(box_of(text).size)
    text.set_rotation(np.degrees(angle))
    centre = np.array(
        [x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)]
    )
    return Bbox([centre - size / 2.0, centre + size / 2.0])


def boxes_of(first: Text, second: Text) -> tuple[Bbox, Bbox]:
    """Return the boxes of two texts: along their lines, if these are parallel."""
    along = first.get_rotation() == second.get_rotation()
    return (box_along(first), box_along(second)) if along else (box_of(first), box_of(second))


def area(box: Bbox | None) -> float:
    return 0.0 if box is None else box.width * box.height


def check_texts(figure: Any) -> None:
    """Require that no two texts of a figure overlap, and that none is cut off."""
    figure.draw_without_rendering()
    placed = [(text, box_of(text)) for text in texts_of(figure)]
    for (first, box), (second, other) in combinations(placed, 2):
        # Boxes of oblique texts contain much that is empty, and are compared only where these overlap.
        if Bbox.intersection(box, other) is None:
            continue
        boxes = boxes_of(first, second)
        smaller = min(area(box) for box in boxes)
        common = area(Bbox.intersection(*boxes))
        assert common <= TOUCHING * smaller, f"{first.get_text()!r} overlaps {second.get_text()!r}"
    for text, box in placed:
        inside = area(Bbox.intersection(box, figure.bbox))
        assert inside >= (1.0 - TOUCHING) * area(box), f"{text.get_text()!r} is cut off"
