"""Figure of a balancing correction: deflection before and after it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.style import (
    MICRO,
    PALETTE,
    GivenAxes,
    label_x,
    legend,
    named_ticks,
    panels,
    text_size,
)

__all__ = ["balance"]


def balance(
    speeds: Sequence[str],
    points: Sequence[str | float],
    before: Array,
    residual: Array,
    *,
    label: str,
    limits: tuple[Array, Array] | None = None,
    ax: GivenAxes = None,
) -> Figure:
    """Draw the deflection at the points before and after the correction, a panel for each speed."""
    named = any(isinstance(point, str) for point in points)
    x = np.arange(len(points)) if named else np.array(points)
    with panels(len(speeds), 3.4, columns=1, sharex=True, ax=ax) as (figure, axes):
        for number, (panel, speed) in enumerate(zip(axes, speeds, strict=True)):
            parts = {"before": before[number], "predicted with the correction": residual[number]}
            for i, (name, values) in enumerate(parts.items()):
                style: dict[str, Any] = {"color": PALETTE[i], "label": name}
                if named:
                    panel.bar(x + 0.4 * (i - 0.5), MICRO * values, width=0.4, **style)
                else:
                    panel.plot(x, MICRO * values, "o-", markersize=4.0, **style)
            if named:
                named_ticks(panel.xaxis, x, [str(point) for point in points])
            if limits is not None:
                low, high = (MICRO * each[number] for each in limits)
                place = x + 0.2 if named else x
                panel.vlines(place, low, high, color="black", label="95 % interval")
            panel.set(ylabel=label)
            panel.set_ylim(bottom=0.0)
            panel.set_title(f"at {speed}", loc="left", fontsize=text_size(1.0))
        label_x(axes, "measuring point" if named else "position [m]")
        legend(figure, axes[0], ax=ax)
    return figure
