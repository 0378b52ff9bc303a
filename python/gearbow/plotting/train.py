"""Figure of a train to scale: side view and end view."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearbow.description.train import Train
from gearbow.plotting import symbols, views
from gearbow.plotting.labels import Box
from gearbow.plotting.style import STYLE, figure_of, given_axes, plain_texts, round_factor
from gearbow.plotting.views import SideView, bows

#: Width and largest height of the figure, and height of legend and labels of the axes [in].
_WIDTH, _HEIGHT, _BELOW = 13.5, 7.5, 1.6
#: Largest height of the end view below a side view [in].
_END = 4.6
#: Part of the width that the side view takes, and length of a train relative to its height from
#: which it takes the whole width, above the end view.
_SIDE, _LONG = 0.58, 6.5
#: Margins around the parts in both views, for names and symbols [pt].
_MARGIN = 46.0
#: Size of the largest bow on the page, as a fraction of the height of the parts.
_BOW = 0.12


def draw(train: Train, magnify: float | None, ax: Axes | Sequence[Axes] | None) -> Figure:
    """Draw a train."""
    side = SideView(train, magnification(train) if magnify is None else magnify)
    boxes = [side.extent(), views.end_extent(train)]
    entries = (symbols.handles(side.kinds), side.kinds)
    if ax is not None:
        panels = given_axes(ax, (1, 2), "side view, or side view and end view")
        figure = figure_of(panels[0])
        with plain_texts(figure):
            if side.kinds:
                panels[0].legend(*entries, fontsize="small", loc="best")
            _views(figure, side, panels, boxes)
        return figure
    with mpl.rc_context(STYLE):
        figure, panels = _new(boxes)
        if side.kinds:
            figure.legend(*entries, loc="outside lower center", ncols=6)
        with plain_texts(figure):
            _views(figure, side, panels, boxes)
    return figure


def magnification(train: Train) -> float:
    """Choose a round factor at which the largest bow is visible."""
    largest = max((float(np.abs(bow).max()) for _, bow in bows(train).values()), default=0.0)
    if largest == 0.0:
        return 1.0
    low, high = (views.end_extent(train)[i] for i in (1, 3))
    return round_factor(_BOW * (high - low) / largest)


def _new(boxes: Sequence[Box]) -> tuple[Figure, list[Axes]]:
    """Make a figure with two panels."""
    spans = np.array([[right - left, top - bottom] for left, bottom, right, top in boxes])
    margin = 2.0 * _MARGIN / 72.0
    if spans[0, 0] > _LONG * spans[0, 1]:
        width = _WIDTH - 2.0
        upper = float(np.clip(spans[0, 1] * (width - margin) / spans[0, 0] + margin, 3.2, _HEIGHT))
        lower = float(np.clip(spans[1, 1] * (width - margin) / spans[1, 0] + margin, 3.2, _END))
        figure = Figure(figsize=(_WIDTH, upper + lower + 1.5 * _BELOW))
        rows = figure.subplots(2, 1, height_ratios=[upper, lower], squeeze=False)
        return figure, rows[:, 0].tolist()
    widths = np.array([_SIDE, 1.0 - _SIDE]) * (_WIDTH - 2.0)
    heights = spans[:, 1] * (widths - margin) / spans[:, 0] + margin
    figure = Figure(figsize=(_WIDTH, float(np.clip(heights.max(), 3.5, _HEIGHT)) + _BELOW))
    panels = figure.subplots(1, 2, width_ratios=widths.tolist(), squeeze=False)[0].tolist()
    return figure, panels


def _views(figure: Figure, side: SideView, panels: Sequence[Axes], boxes: Sequence[Box]) -> None:
    """Draw the views, after the limits, which give the length of a point of the page."""
    bow = f", bow × {side.magnify:g}" if bows(side.train) else ""
    titles = (f"side view{bow}", "end view, seen along −x")
    upright = "y [m]" if side.development.true else "along the lines of centres [m]"
    labels = (("x [m]", upright), ("y [m]", "z [m]"))
    for panel, title, (x, y) in zip(panels, titles, labels, strict=False):
        panel.set(title=title, xlabel=x, ylabel=y)
        panel.grid(visible=False)
    # The width of the numbers at the axes depends on the limits, and the limits on this width.
    _fit_all(panels, boxes)
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
    points = _fit_all(panels, boxes)
    for panel in panels:
        panel.set_aspect("equal", adjustable="box")
    side.draw(panels[0], points[0])
    if len(panels) > 1:
        views.draw_end_view(panels[1], side.train, side.shades, points[1])


def _fit_all(panels: Sequence[Axes], boxes: Sequence[Box]) -> list[float]:
    return [_fit(panel, box) for panel, box in zip(panels, boxes, strict=False)]


def _fit(panel: Axes, box: Box) -> float:
    """Set limits with equal scales around a box, and give the length of a point of the page [m]."""
    size = panel.get_window_extent()
    scale = 72.0 / figure_of(panel).dpi
    pixels = np.array([size.width, size.height])
    # Very small panels keep a third of their size for the parts.
    available = np.maximum(pixels * scale - 2.0 * _MARGIN, pixels * scale / 3.0)
    point = float(np.max(np.array([box[2] - box[0], box[3] - box[1]]) / available))
    half = 0.5 * point * pixels * scale
    panel.set_xlim(0.5 * (box[0] + box[2]) - half[0], 0.5 * (box[0] + box[2]) + half[0])
    panel.set_ylim(0.5 * (box[1] + box[3]) - half[1], 0.5 * (box[1] + box[3]) + half[1])
    panel.locator_params(nbins=6)
    return point
