"""Figure of the limits of a bow against the speed."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.style import (
    MICRO,
    PALETTE,
    GivenAxes,
    colour,
    legend,
    log_scale,
    panels,
    remark,
    speed_axis,
)

__all__ = ["bow_limits"]


def bow_limits(
    speeds: Array,
    lines: Mapping[str, Array],
    present: float,
    *,
    label: str,
    speed_unit: str = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw one curve for each of the first limits that are reached, and the present bow."""
    factor, axis = speed_axis(speed_unit)
    with panels(1, 6.0, columns=1, width=10.0, ax=ax) as (figure, (panel,)):
        reached = {name: MICRO * bows for name, bows in lines.items() if np.any(np.isfinite(bows))}
        # `lines` ascend: the further ones are above all of these.
        for number, (name, bows) in enumerate(list(reached.items())[: len(PALETTE)]):
            style: dict[str, Any] = {
                "color": colour(number),
                "linestyle": ("-", "--", "-.", ":")[number % 4],
                "marker": "o" if speeds.size < 20 else None,
                "markersize": 4.0,
            }
            panel.plot(factor * speeds, np.where(bows > 0.0, bows, np.nan), label=name, **style)
            if np.any(bows == 0.0):
                remark(panel, f"{name}: exceeded without bow")
        if len(reached) > len(PALETTE):
            remark(panel, f"{len(reached) - len(PALETTE)} further limits are above")
        if present > 0.0:
            panel.axhline(MICRO * present, color="0.2", linewidth=2.5, label="present bow")
        if reached or present > 0.0:
            log_scale(panel)
        else:
            remark(panel, "no limit is reached")
        if speeds.size > 1 and not panel.dataLim.width > 0.0:  # no limit has a curve
            panel.set_xlim(*sorted(factor * speeds[[0, -1]]))
        panel.set(xlabel=axis, ylabel=f"{label} [µm]")
        legend(figure, panel, ax=ax)
    return figure
