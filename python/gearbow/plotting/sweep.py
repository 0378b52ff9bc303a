"""Figures of a value of a sweep over one or two parameters."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.style import PALETTE, GivenAxes, panels

__all__ = ["sweep"]


def sweep(
    axes: Mapping[str, Sequence[float]], values: Array, name: str, *, ax: GivenAxes = None
) -> Figure:
    """Draw a value over one or two parameters."""
    names = list(axes)
    # A map needs ascending axes; a grid may have any order.
    orders = [np.argsort(axis, kind="stable") for axis in axes.values()]
    points = [np.array(axis)[order] for axis, order in zip(axes.values(), orders, strict=True)]
    found = values[np.ix_(*orders)]
    with panels(1, 4.5, columns=1, width=7.0, ax=ax) as (figure, (panel,)):
        if len(names) == 1:
            panel.plot(points[0], found, "o-", color=PALETTE[0], markersize=4.0)
            panel.set(xlabel=names[0], ylabel=name)
        else:
            drawn = panel.pcolormesh(
                *points, found.T, cmap="cividis", shading="nearest", rasterized=True
            )
            figure.colorbar(drawn, ax=panel, label=name)
            panel.grid(visible=False)
            panel.set(xlabel=names[0], ylabel=names[1])
    return figure
