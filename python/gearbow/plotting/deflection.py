"""Figure of a static deflection along the shafts."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array, Dof
from gearbow.description.layout import Layout
from gearbow.plotting.style import (
    MICRO,
    GivenAxes,
    colour,
    common_round_off,
    label_x,
    legend,
    panels,
)
from gearbow.plotting.within_elements import refined

__all__ = ["deflection"]


def deflection(
    state: Array, dofs: Sequence[Dof], layout: Layout, *, ax: GivenAxes = None
) -> Figure:
    """Draw the displacements of the shafts along y and z, or their twist."""
    values, nodes = refined(state[np.newaxis].astype(np.complex128), dofs, layout)
    directions = {direction for *_, direction in nodes}
    rows = {"v": ("displacement y [µm]", MICRO), "w": ("displacement z [µm]", MICRO)}
    if "v" not in directions:
        rows = {"twist": ("twist [mrad]", 1e3)}
    with panels(len(rows), 3.2, columns=1, sharex=True, ax=ax) as (figure, axes):
        for panel, (direction, (label, factor)) in zip(axes, rows.items(), strict=True):
            for i, shaft in enumerate(layout.shafts):
                own = sorted(
                    (x, factor * float(value.real))
                    for (name, x, kind), value in zip(nodes, values[0], strict=True)
                    if (name, kind) == (shaft.name, direction)
                )
                if not own:
                    continue
                x, y = np.array(own).T
                panel.plot(shaft.origin[0] + x, y, color=colour(i), label=shaft.name)
                marks = [body.position for body in layout.bodies if body.shaft == shaft.name]
                at = shaft.origin[0] + np.array(marks)
                panel.plot(at, np.interp(marks, x, y), "o", color=colour(i), markersize=5.0)
            panel.set(ylabel=label)
        # Without gravity along y, round-off would fill its panel.
        common_round_off(axes)
        label_x(axes, "position [m]")
        legend(figure, axes[0], ax=ax)
    return figure
