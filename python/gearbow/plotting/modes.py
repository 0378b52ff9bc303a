"""Overview of mode shapes along the shafts."""

from collections.abc import Sequence
from itertools import product

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array, ComplexArray, NodalDof
from gearbow.plotting.style import GivenAxes, colour, legend, panels, text_size

__all__ = ["overview"]


def overview(
    titles: Sequence[str],
    shapes: ComplexArray,
    dofs: Sequence[NodalDof],
    drawn: Sequence[str],
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw mode shapes along the shafts."""
    shafts = list(dict.fromkeys(shaft for shaft, _, _ in dofs))
    with panels(len(titles), 3.5, columns=2, width=13.0, ax=ax) as (figure, axes):
        for mode, (panel, title) in enumerate(zip(axes, titles, strict=True)):
            lines = {"v": "-", "w": "--"} if drawn[mode] == "lateral" else {drawn[mode]: "-"}
            shape = _real(shapes[mode], [direction in lines for _, _, direction in dofs])
            for (direction, line), (i, shaft) in product(lines.items(), enumerate(shafts)):
                at = [n for n, (s, _, d) in enumerate(dofs) if (s, d) == (shaft, direction)]
                x = [dofs[n][1] for n in at]
                name = None if direction == "w" else shaft
                panel.plot(x, shape[at], line, color=colour(i), label=name)
            panel.set_title(title, fontsize=text_size(1.0))
            panel.set(xlabel="position [m]")
            label = "v (w dashed)" if drawn[mode] == "lateral" else drawn[mode]
            panel.set(ylabel=label, ylim=(-1.15, 1.15))
        legend(figure, axes[0], ax=ax)
    return figure


def _real(shape: ComplexArray, drawn: Sequence[bool]) -> Array:
    """Give the real part of a complex shape, scaled so that its largest drawn entry is 1."""
    largest = shape[int(np.argmax(np.where(drawn, np.abs(shape), 0.0)))]
    return np.real(shape / largest) if largest != 0.0 else np.real(shape)
