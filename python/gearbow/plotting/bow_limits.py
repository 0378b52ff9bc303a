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
    named_ticks,
    panels,
    remark,
    speed_axis,
)
from gearbow.units.speed import SpeedUnit, speed_text

__all__ = ["bow_limits"]

#: Ratio of the largest to the smallest bow from which their axis is logarithmic.
_WIDE = 30.0


def bow_limits(
    speeds: Array,
    lines: Mapping[str, Array],
    present: float,
    *,
    label: str,
    speed_unit: SpeedUnit = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw one curve for each of the first limits that are reached, and the present bow."""
    if speeds.size == 1:
        single = {name: MICRO * float(values[0]) for name, values in lines.items()}
        at = f"at {speed_text(float(speeds[0]), speed_unit)}"
        return _at_one_speed(single, MICRO * present, f"{label} [µm], {at}", ax=ax)
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


def _at_one_speed(
    bows: Mapping[str, float], present: float, label: str, *, ax: GivenAxes
) -> Figure:
    """Draw a bar for each of the first limits, and the present bow as a line."""
    shown = [(name, bow) for name, bow in bows.items() if np.isfinite(bow)][: len(PALETTE)]
    with panels(1, 0.5 * len(shown) + 1.2, columns=1, ax=ax) as (figure, (panel,)):
        names = [f"{name}: exceeded without bow" if bow == 0.0 else name for name, bow in shown]
        for row, (_, bow) in enumerate(shown):
            exceeded = bow < present
            panel.barh(row, bow, height=0.55, color=PALETTE[1 if exceeded else 0])
        named_ticks(panel.yaxis, range(len(shown)), names)
        panel.set_ylim(max(len(shown), 1) - 0.5, -0.5)
        if present > 0.0:
            panel.axvline(present, color="0.2", linewidth=2.5, label="present bow")
        sizes = [bow for _, bow in shown if bow > 0.0] + [present] * (present > 0.0)
        if sizes and max(sizes) > _WIDE * min(sizes):
            panel.set_xscale("log")
            panel.set_xlim(0.5 * min(sizes), 1.2 * max(sizes))
        else:
            panel.set_xlim(0.0, 1.08 * max(sizes, default=1.0))
        panel.grid(visible=False, axis="y")
        panel.set(xlabel=label)
        if not shown:
            remark(panel, "no limit is reached")
        elif len(bows) > len(shown):
            left = len(bows) - len(shown)
            limits = "limits are" if left > 1 else "limit is"
            remark(panel, f"{left} further {limits} above, or not reached")
        legend(figure, panel, ax=ax)
    return figure
