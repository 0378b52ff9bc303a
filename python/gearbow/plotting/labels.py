"""Labels without overlap: each takes the free one of several places."""

from collections.abc import Iterable, Iterator
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes

from gearbow._types import Array
from gearbow.plotting.style import figure_of, text_size

__all__ = ["Box", "Labels", "around"]

#: Left, bottom, right and top of a box.
Box: TypeAlias = tuple[float, float, float, float]
#: A place of a label: its anchor (x, y), and the direction in which the text lies from it, with
#: components between -1 and 1.
Place: TypeAlias = tuple[tuple[float, float], tuple[float, float]]

#: Size of a label relative to the font size.
_SIZE = 0.93
#: Distances of a text from its anchor [pt]; a line leads to a text that is farther away.
_GAPS = (4.0, 22.0, 40.0, 60.0, 85.0, 115.0)
#: Weight of an overlap with another label or with the edge, relative to one with an obstacle.
_TEXT = 1000.0
#: Cost of the distance of a text [pixel² per pt]: a text over a part is better than one far away.
_DISTANCE = 15.0
#: Background of a text, through which the drawing is visible.
_PAPER = {"facecolor": "white", "edgecolor": "none", "alpha": 0.65, "pad": 0.8}
#: A smaller component of a direction centres the text.
_CENTRED = 0.4


class Labels:
    """Labels of a panel whose limits are final.

    Parameters
    ----------
    panel : matplotlib.axes.Axes
        The panel.
    point : float
        Size of a printed point, 1/72 in, in the units of the axes [m].
    """

    def __init__(self, panel: Axes, point: float) -> None:
        self.panel, self.point = panel, point
        self._pixel = figure_of(panel).dpi / 72.0
        self._boxes: list[Box] = []
        self._weights: list[float] = []

    def avoid(self, *boxes: Box, strictly: bool = False) -> None:
        """Keep labels away from boxes.

        Parameters
        ----------
        *boxes : tuple of float
            Left, bottom, right and top in coordinates of the data.
        strictly : bool
            Whether a box counts as much as another label.
        """
        for left, bottom, right, top in boxes:
            corners = self.panel.transData.transform([(left, bottom), (right, top)])
            self._boxes.append(tuple(corners.ravel().tolist()))
            self._weights.append(_TEXT if strictly else 1.0)

    def add(self, text: str, places: Iterable[Place], **style: Any) -> None:
        """Write a label at the place with the smallest overlap.

        Parameters
        ----------
        text : str
            The label.
        places : iterable of ((float, float), (float, float))
            Anchors, each with the direction of the text; preferred places first.
        **style
            Properties of the text.
        """
        style = {"fontsize": text_size(_SIZE), **style}
        trial = self.panel.text(0.0, 0.0, text, **style)
        extent = trial.get_window_extent()
        trial.remove()
        given = list(places)
        ways = np.tile([way for _, way in given], (len(_GAPS), 1))
        gaps = np.repeat(_GAPS, len(given))
        anchors = np.tile(self.panel.transData.transform([at for at, _ in given]), (len(_GAPS), 1))
        # The text lies at the middle, the left or the right of its anchor, as `_align` says.
        start = anchors + self._pixel * gaps[:, np.newaxis] * ways
        size = np.array([extent.width, extent.height])
        low = start - size * np.where(np.abs(ways) < _CENTRED, 0.5, ways < 0.0)
        boxes = np.hstack([low, low + size])
        best = int(np.argmin(self._costs(boxes) + _DISTANCE * gaps))
        at, way = given[best % len(given)]
        leader = {"arrowstyle": "-", "color": "0.4", "linewidth": 0.8, "shrinkA": 1, "shrinkB": 0}
        self.panel.annotate(
            text,
            at,
            xytext=(gaps[best] * way[0], gaps[best] * way[1]),
            textcoords="offset points",
            ha=_align(way[0], ("right", "center", "left")),
            va=_align(way[1], ("top", "center", "bottom")),
            arrowprops=leader if gaps[best] > _GAPS[0] else None,
            annotation_clip=False,
            zorder=9.0,
            bbox=_PAPER,
            **style,
        )
        self._boxes.append(tuple(boxes[best].tolist()))
        self._weights.append(_TEXT)

    def _costs(self, boxes: Array) -> Array:
        """Give the weighted area of each box that overlaps others or lies outside the panel."""
        panel = np.array([self.panel.bbox.extents])
        size = np.prod(boxes[:, 2:] - boxes[:, :2], axis=1)
        outside = size - _areas(boxes, panel)[:, 0]
        # Round-off of an area inside the panel is no overlap.
        costs: Array = np.where(outside > 1e-6 * size, _TEXT * outside, 0.0)
        if self._boxes:
            costs += _areas(boxes, np.array(self._boxes)) @ np.array(self._weights)
        return costs


def around(
    left: float, bottom: float, right: float, top: float, ways: Iterable[tuple[float, float]]
) -> Iterator[Place]:
    """Give places of a label around a box.

    Parameters
    ----------
    left, bottom, right, top : float
        The box.
    ways : iterable of (float, float)
        Directions from the middle of the box, with components between -1 and 1.

    Yields
    ------
    ((float, float), (float, float))
        Point of the edge in this direction, and the direction.
    """
    for way in ways:
        x = (left + right) / 2.0 + way[0] * (right - left) / 2.0
        y = (bottom + top) / 2.0 + way[1] * (top - bottom) / 2.0
        yield (x, y), way


def _areas(boxes: Array, others: Array) -> Array:
    """Give the common areas of boxes, shape (boxes, others)."""
    low = np.maximum(boxes[:, np.newaxis, :2], others[np.newaxis, :, :2])
    high = np.minimum(boxes[:, np.newaxis, 2:], others[np.newaxis, :, 2:])
    areas: Array = np.prod(np.maximum(high - low, 0.0), axis=2)
    return areas


def _align(component: float, names: tuple[str, str, str]) -> Any:
    """Give the alignment of a text for a component of its direction."""
    return names[1] if abs(component) < _CENTRED else names[2 if component > 0.0 else 0]
