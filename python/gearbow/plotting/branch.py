"""Figure of a branch of steady states."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gearbow._types import Array
from gearbow.plotting.style import PALETTE, GivenAxes, panels

__all__ = ["branch"]

#: Marker of each kind of special point.
_MARKS = {"fold": "o", "flip": "s", "contact loss": "D"}


def branch(
    values: Array,
    amplitudes: Array,
    stable: NDArray[np.bool_],
    kinds: Sequence[str],
    *,
    labels: tuple[str, str],
    is_open: bool = False,
    ax: GivenAxes = None,
) -> Figure:
    """Draw a branch: stable parts solid, unstable ones dashed; markers for points and open ends."""
    with panels(1, 4.5, columns=1, width=7.0, ax=ax) as (drawing, (axes,)):
        named = set()
        for is_stable, group in groupby(
            range(values.size - 1), key=lambda i: stable[i : i + 2].all()
        ):
            part = list(group)
            points = slice(part[0], part[-1] + 2)
            name = "stable" if is_stable else "unstable"
            axes.plot(
                values[points],
                amplitudes[points],
                linestyle="-" if is_stable else "--",
                color=PALETTE[0] if is_stable else PALETTE[1],
                label=None if name in named else name,
            )
            named.add(name)
        for kind, mark in _MARKS.items():
            chosen = np.array(kinds) == kind
            if chosen.any():
                axes.plot(
                    values[chosen], amplitudes[chosen], mark, color="0.2", markersize=5, label=kind
                )
        if is_open:
            axes.plot(
                values[-1:],
                amplitudes[-1:],
                marker="o",
                linestyle="none",
                color=PALETTE[0] if stable[-1] else PALETTE[1],
                markerfacecolor="white",
                markersize=9,
                label="open end",
            )
        axes.set(xlabel=labels[0], ylabel=labels[1])
        axes.legend()
    return drawing
