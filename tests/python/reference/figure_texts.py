"""Texts of a figure as the reader sees them: which overlap, and which the figure cuts off."""

from __future__ import annotations

from itertools import combinations
from typing import Any

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


def area(box: Bbox | None) -> float:
    return 0.0 if box is None else box.width * box.height


def check_texts(figure: Any) -> None:
    """Require that no two texts of a figure overlap, and that none is cut off."""
    figure.draw_without_rendering()
    placed = [(text.get_text(), box_of(text)) for text in texts_of(figure)]
    for (a, first), (b, second) in combinations(placed, 2):
        common = area(Bbox.intersection(first, second))
        assert common <= TOUCHING * min(area(first), area(second)), f"{a!r} overlaps {b!r}"
    for text, box in placed:
        inside = area(Bbox.intersection(box, figure.bbox))
        assert inside >= (1.0 - TOUCHING) * area(box), f"{text!r} is cut off"
