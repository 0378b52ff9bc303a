"""Figures of a value of a sweep over one to three parameters."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.style import PALETTE, GivenAxes, panels, text_size

__all__ = ["sweep"]


def sweep(
    axes: Mapping[str, Sequence[float]],
    values: Array,
    name: str,
    *,
    labels: Mapping[str, str],
    ax: GivenAxes = None,
) -> Figure:
    """Draw a value over one, two or three parameters."""
    names = list(axes)
    # A map needs ascending axes; a grid may have any order.
    orders = [np.argsort(axis, kind="stable") for axis in axes.values()]
    points = [np.array(axis)[order] for axis, order in zip(axes.values(), orders, strict=True)]
    found = values[np.ix_(*orders)]
    if len(names) == 1:
        with panels(1, 4.5, columns=1, width=7.0, ax=ax) as (figure, (panel,)):
            panel.plot(points[0], found, "o-", color=PALETTE[0], markersize=4.0)
            panel.set(xlabel=labels[names[0]], ylabel=labels[name])
        return figure
    # The first of three parameters has a panel for each value.
    parts = found if len(names) == 3 else found[np.newaxis]
    style: dict[str, Any] = {"cmap": "cividis", "shading": "nearest", "rasterized": True}
    style |= {"vmin": np.nanmin(found), "vmax": np.nanmax(found)}
    width = 7.0 if len(parts) == 1 else 13.0
    with panels(len(parts), 4.5, columns=2, width=width, ax=ax) as (figure, all_panels):
        for number, (panel, part) in enumerate(zip(all_panels, parts, strict=True)):
            drawn = panel.pcolormesh(*points[-2:], part.T, **style)
            figure.colorbar(drawn, ax=panel, label=labels[name])
            panel.grid(visible=False)
            panel.set(xlabel=labels[names[-2]], ylabel=labels[names[-1]])
            if len(names) == 3:
                title = f"{labels[names[0]]} = {points[0][number]:g}"
                panel.set_title(title, fontsize=text_size(1.0))
    return figure
