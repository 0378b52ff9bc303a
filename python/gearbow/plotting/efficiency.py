"""Figure of the losses of a train."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.style import GivenAxes, colour, legend, named_ticks, panels, speed_axis

__all__ = ["losses"]


def losses(
    speeds: Array,
    names: Sequence[str],
    shares: Array,
    *,
    speed_unit: str = "rad/s",
    ax: GivenAxes = None,
) -> Figure:
    """Draw the loss of each mesh [% of the input power] over the speed; bars at a single speed."""
    factor, axis = speed_axis(speed_unit)
    total = shares.sum(axis=1)
    label = "loss by friction of teeth [% of input power]"
    height = 1.6 + 0.45 * len(names) if speeds.size == 1 else 5.0
    with panels(1, height, columns=1, width=9.0, ax=ax) as (figure, (panel,)):
        if speeds.size == 1:
            rows = np.arange(len(names) + 1)
            values = np.append(shares[0], total[0])
            panel.barh(rows, values, color=[colour(0)] * len(names) + ["0.4"])
            named_ticks(panel.yaxis, rows, [*names, "train"])
            panel.invert_yaxis()
            panel.grid(visible=False, axis="y")
            panel.set(xlabel=label, ylabel="mesh", title=f"{factor * speeds[0]:.5g} {speed_unit}")
        else:
            for i, (name, values) in enumerate(zip(names, shares.T, strict=True)):
                panel.plot(factor * speeds, values, color=colour(i), label=name)
            panel.plot(factor * speeds, total, color="0.2", linewidth=2.5, label="train")
            panel.set(xlabel=axis, ylabel=label)
            legend(figure, panel, ax=ax)
        panel.margins(y=0.08)
    return figure
