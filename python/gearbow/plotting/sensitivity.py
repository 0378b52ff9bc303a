"""Figure of the effect of parameters on frequencies or speeds."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.style import PALETTE, GivenAxes, named_ticks, panels, remark

__all__ = ["tornado"]

#: Largest number of bars in a panel.
_BARS = 12


def tornado(
    parameters: Sequence[str],
    outputs: Sequence[str],
    effects: Array,
    *,
    of: str,
    ax: GivenAxes = None,
) -> Figure:
    """Draw bars of the effect of each parameter on each output, the largest on top."""
    count, bars = max(len(outputs), 1), min(len(parameters), _BARS)
    height = 1.6 + 0.45 * bars
    with panels(count, height, columns=1, width=10.0, ax=ax) as (figure, found):
        if not outputs:
            remark(found[0], "no mode with stiffness")
        for panel, output, column in zip(found, outputs, effects.T, strict=False):
            order = np.argsort(-np.abs(column), kind="stable")[:_BARS][::-1]
            values = column[order]
            colours = [PALETTE[0] if value >= 0.0 else PALETTE[1] for value in values]
            panel.barh(np.arange(order.size), values, color=colours)
            named_ticks(panel.yaxis, np.arange(order.size), [parameters[i] for i in order])
            panel.axvline(0.0, color="0.2", linewidth=1.0)
            panel.grid(visible=False, axis="y")
            # Round-off is no effect: the axis shows at least a thousandth of a percent.
            most = max(float(np.max(np.abs(values), initial=0.0)), 1e-3)
            panel.set_xlim(-1.1 * most, 1.1 * most)
            axis = f"change of the {of} [%] for 1 % of the parameter"
            panel.set(title=output, xlabel=axis, ylabel="parameter")
            if len(parameters) > _BARS:
                remark(panel, f"{len(parameters) - _BARS} further parameters have less effect")
    return figure
