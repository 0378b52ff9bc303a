"""Labels without overlap: each takes the free one of several places.

Each label in turn takes its best place, given the places of the others, until none moves: a
descent over one label at a time.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes

from gearbow._types import Array
from gearbow.plotting.style import figure_of, text_extent, text_size

#: Smallest number of bodies on a shaft with numbered names that share one label.
_SERIES = 4

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
_DISTANCE = 20.0
#: Background of a text, through which the drawing is visible.
_PAPER = {"facecolor": "white", "edgecolor": "none", "alpha": 0.65, "pad": 0.8}
#: Free space around a text [pt].
_MARGIN = 1.5
#: Number of points of a line to a text that must not cross other texts.
_LEADER_POINTS = 8
#: Largest number of rounds in which labels look for better places.
_ROUNDS = 10
#: A smaller component of a direction centres the text.
_CENTRED = 0.4


@dataclass(frozen=True)
class _Label:
    """A label with the places that it may take."""

    text: str
    style: dict[str, Any]
    anchors: Array
    ways: Array
    gaps: Array
    boxes: Array
    leaders: Array


class Labels:
    """Labels of a panel whose limits are final."""

    def __init__(self, panel: Axes, point: float) -> None:
        self.panel, self.point = panel, point
        self._pixel = figure_of(panel).dpi / 72.0
        self._boxes: list[Box] = []
        self._weights: list[float] = []
        self._labels: list[_Label] = []

    def avoid(self, *boxes: Box, strictly: bool = False) -> None:
        """Keep labels away from boxes."""
        for left, bottom, right, top in boxes:
            corners = self.panel.transData.transform([(left, bottom), (right, top)])
            self._boxes.append(tuple(corners.ravel().tolist()))
            self._weights.append(_TEXT if strictly else 1.0)

    def add(self, text: str, places: Iterable[Place], **style: Any) -> None:
        """Add a label."""
        style = {"fontsize": text_size(_SIZE), **style}
        extent = text_extent(self.panel, text, **style)
        given = list(places)
        ways = np.tile([way for _, way in given], (len(_GAPS), 1))
        gaps = np.repeat(_GAPS, len(given))
        anchors = np.tile([at for at, _ in given], (len(_GAPS), 1))
        pixels = self.panel.transData.transform(anchors)
        # The text lies at the middle, the left or the right of its anchor, as `_align` says.
        start = pixels + self._pixel * gaps[:, np.newaxis] * ways
        margin = _MARGIN * self._pixel
        size = np.array([extent.width, extent.height])
        low = start - size * np.where(np.abs(ways) < _CENTRED, 0.5, ways < 0.0)
        boxes = np.hstack([low - margin, low + size + margin])
        along = np.linspace(0.0, 1.0, _LEADER_POINTS)[:, np.newaxis]
        points = pixels[:, np.newaxis] + along * (start - pixels)[:, np.newaxis]
        half = np.where(gaps > _GAPS[0], margin, 0.0)[:, np.newaxis, np.newaxis]
        leaders = np.concatenate([points - half, points + half], axis=2)
        self._labels.append(_Label(text, style, anchors, ways, gaps, boxes, leaders))

    def place(self) -> None:
        """Write all labels, each at the place with the smallest overlap, given the others."""
        chosen: list[int | None] = [None] * len(self._labels)
        fixed = [self._fixed_costs(label) for label in self._labels]
        for _ in range(_ROUNDS):
            before = list(chosen)
            for number, label in enumerate(self._labels):
                others = [
                    (other.boxes[at], other.leaders[at])
                    for other, at in zip(self._labels, chosen, strict=True)
                    if at is not None and other is not label
                ]
                chosen[number] = int(np.argmin(fixed[number] + _mutual_costs(label, others)))
            if chosen == before:
                break
        for label, at in zip(self._labels, chosen, strict=True):
            if at is not None:
                self._write(label, at)

    def _write(self, label: _Label, place: int) -> None:
        """Write a label at one of its places, with a line to its anchor if it is far away."""
        way, gap = label.ways[place], float(label.gaps[place])
        leader = {"arrowstyle": "-", "color": "0.4", "linewidth": 0.8, "shrinkA": 1, "shrinkB": 0}
        self.panel.annotate(
            label.text,
            tuple(label.anchors[place]),
            xytext=(gap * way[0], gap * way[1]),
            textcoords="offset points",
            ha=_align(way[0], ("right", "center", "left")),
            va=_align(way[1], ("top", "center", "bottom")),
            arrowprops=leader if gap > _GAPS[0] else None,
            annotation_clip=False,
            zorder=9.0,
            bbox=_PAPER,
            **label.style,
        )

    def _fixed_costs(self, label: _Label) -> Array:
        """Give the costs of the places of a label without the other labels, shape (places,)."""
        panel = np.array([self.panel.bbox.extents])
        size = np.prod(label.boxes[:, 2:] - label.boxes[:, :2], axis=1)
        outside = size - _areas(label.boxes, panel)[:, 0]
        # Round-off of an area inside the panel is no overlap.
        costs: Array = np.where(outside > 1e-6 * size, _TEXT * outside, 0.0)
        if self._boxes:
            costs += _areas(label.boxes, np.array(self._boxes)) @ np.array(self._weights)
        costs += _DISTANCE * label.gaps
        return costs


def series(names: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Unite names that differ in a number only: "stage 1" to "stage 9" are "stage 1–9"."""
    stems: dict[str, list[tuple[int, str]]] = {}
    for name in names:
        found = re.fullmatch(r"(.*?)(\d+)", name)
        if found is not None:
            stems.setdefault(found[1], []).append((int(found[2]), name))
    many = {stem: sorted(own) for stem, own in stems.items() if len(own) >= _SERIES}
    united = [
        (f"{stem}{own[0][0]}–{own[-1][0]}", [name for _, name in own]) for stem, own in many.items()
    ]
    inside = {name for _, own in united for name in own}
    return [*((name, [name]) for name in names if name not in inside), *united]


def around(ways: Iterable[tuple[float, float]], *boxes: Box) -> Iterator[Place]:
    """Give places of one label around boxes."""
    edges = np.array(boxes)
    left, bottom = edges[:, :2].min(axis=0).tolist()
    right, top = edges[:, 2:].max(axis=0).tolist()
    for way in ways:
        x = (left + right) / 2.0 + way[0] * (right - left) / 2.0
        y = (bottom + top) / 2.0 + way[1] * (top - bottom) / 2.0
        yield (x, y), way


def _mutual_costs(label: _Label, others: Sequence[tuple[Array, Array]]) -> Array:
    """Give the weighted area that each place of a label shares with labels and their lines."""
    if not others:
        return np.zeros(len(label.boxes))
    texts = np.array([box for box, _ in others])
    lines = np.concatenate([leader for _, leader in others])
    common = _areas(label.boxes, np.concatenate([texts, lines])).sum(axis=1)
    crossed = _areas(label.leaders.reshape(-1, 4), texts).sum(axis=1)
    costs: Array = _TEXT * (common + crossed.reshape(len(label.boxes), -1).sum(axis=1))
    return costs


def _areas(boxes: Array, others: Array) -> Array:
    """Give the common areas of boxes, shape (boxes, others)."""
    low = np.maximum(boxes[:, np.newaxis, :2], others[np.newaxis, :, :2])
    high = np.minimum(boxes[:, np.newaxis, 2:], others[np.newaxis, :, 2:])
    areas: Array = np.prod(np.maximum(high - low, 0.0), axis=2)
    return areas


def _align(component: float, names: tuple[str, str, str]) -> Any:
    """Give the alignment of a text for a component of its direction."""
    return names[1] if abs(component) < _CENTRED else names[2 if component > 0.0 else 0]
