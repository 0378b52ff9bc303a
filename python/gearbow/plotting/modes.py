"""Overview of mode shapes along the shafts."""

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array, ComplexArray, NodalDof
from gearbow.description.layout import Layout
from gearbow.plotting.style import GivenAxes, colour, legend, panels, text_size

__all__ = ["assurance", "overview"]


def overview(
    titles: Sequence[str],
    shapes: ComplexArray,
    dofs: Sequence[NodalDof],
    drawn: Sequence[str],
    layout: Layout,
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw mode shapes along the shafts."""
    shafts = [shaft.name for shaft in layout.shafts]
    places = {base.name: float(np.mean([x for _, x in base.feet])) for base in layout.bases}
    if not titles:
        return _without_modes(ax)
    with panels(len(titles), 3.5, columns=2, width=13.0, ax=ax) as (figure, axes):
        for mode, (panel, title) in enumerate(zip(axes, titles, strict=True)):
            lines = {"v": "-", "w": "--"} if drawn[mode] == "lateral" else {drawn[mode]: "-"}
            shape = _real(shapes[mode], [direction in lines for _, _, direction in dofs])
            for (direction, line), (i, shaft) in product(lines.items(), enumerate(shafts)):
                at = [n for n, (s, _, d) in enumerate(dofs) if (s, d) == (shaft, direction)]
                x = [dofs[n][1] for n in at]
                name = None if direction == "w" else shaft
                panel.plot(x, shape[at], line, color=colour(i), label=name)
            for (direction, line), (i, name) in product(lines.items(), enumerate(places)):
                at = [n for n, (s, _, d) in enumerate(dofs) if (s, d) == (name, direction)]
                face = colour(len(shafts) + i) if line == "-" else "white"
                style: dict[str, Any] = {"color": colour(len(shafts) + i), "markerfacecolor": face}
                if at:
                    own = name if line == "-" else None
                    panel.plot(places[name], shape[at[0]], "s", markersize=8.0, label=own, **style)
            panel.set_title(title, fontsize=text_size(1.0))
            panel.set(xlabel="position [m]")
            label = "y (z dashed, open)" if places else "y (z dashed)"
            label = {"lateral": label, "u": "x"}.get(drawn[mode], drawn[mode])
            panel.set(ylabel=label, ylim=(-1.15, 1.15))
        legend(figure, axes[0], ax=ax)
    return figure


def _real(shape: ComplexArray, drawn: Sequence[bool]) -> Array:
    """Give the real part of a complex shape, scaled so that its largest drawn entry is 1."""
    largest = shape[int(np.argmax(np.where(drawn, np.abs(shape), 0.0)))]
    return np.real(shape / largest) if largest != 0.0 else np.real(shape)


def _without_modes(ax: GivenAxes) -> Figure:
    """Say that there is no mode to draw."""
    with panels(1, 3.5, columns=1, width=6.5, ax=ax) as (figure, (panel,)):
        panel.set_title("no modes", fontsize=text_size(1.0))
    return figure


def assurance(mac: Array, computed: Array, measured: Array, *, ax: GivenAxes = None) -> Figure:
    """Draw MAC of computed and measured modes as a table of colours."""
    if mac.size == 0:
        return _without_modes(ax)
    with panels(1, 6.0, columns=1, width=8.0, ax=ax) as (figure, (panel,)):
        image = panel.imshow(mac.T, vmin=0.0, vmax=1.0, origin="lower", cmap="Blues", aspect="auto")
        figure.colorbar(image, ax=panel, label="MAC")
        for (i, j), value in np.ndenumerate(mac):
            dark = value > 0.6  # light text on a dark colour
            if value >= 0.005:
                panel.text(
                    i,
                    j,
                    f"{value:.2f}",
                    ha="center",
                    va="center",
                    color="white" if dark else "black",
                )
        for ticks, axis, values in (
            (panel.set_xticks, "computed", computed),
            (panel.set_yticks, "measured", measured),
        ):
            ticks(np.arange(values.size), [f"{i + 1}: {f:.4g} Hz" for i, f in enumerate(values)])
            panel.set(**{f"{'x' if axis == 'computed' else 'y'}label": f"{axis} mode"})
        panel.tick_params(axis="x", rotation=45.0)
        panel.grid(visible=False)
    return figure
