"""Style of all figures: colours, settings, panels and legends."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure

__all__ = ["MICRO", "PALETTE", "STYLE", "colour", "legend", "panels"]

#: Micrometres per metre.
MICRO = 1e6

#: Colours for colour-blind readers: Okabe and Ito, *Color universal design* (2008).
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

#: Settings of every figure. The font is legible at half size.
STYLE: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.formatter.limits": (-4, 5),
    "axes.grid": True,
    "axes.prop_cycle": cycler(color=PALETTE),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.constrained_layout.use": True,
    "font.size": 14.0,
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "savefig.dpi": 150,
}


@contextmanager
def panels(
    count: int, height: float, *, columns: int, width: float = 12.0, sharex: bool = False
) -> Iterator[tuple[Figure, list[Axes]]]:
    """Make a figure with rows of panels.

    The style of gearbow applies within the `with` block.

    Parameters
    ----------
    count : int
        Number of panels.
    height : float
        Height of a row [in].
    columns : int
        Largest number of columns.
    width : float
        Width of the figure [in].
    sharex : bool
        Whether all panels have the same horizontal axis.

    Yields
    ------
    figure : matplotlib.figure.Figure
        The figure.
    panels : list of matplotlib.axes.Axes
        The panels, row by row.
    """
    columns = min(columns, count)
    rows = -(-count // columns)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height * rows + 0.8))
        grid = figure.subplots(rows, columns, squeeze=False, sharex=sharex)
        found = list(grid.flat)
        for panel in found[count:]:
            panel.remove()
        yield figure, found[:count]
        figure.align_ylabels()


def legend(figure: Figure, panel: Axes, title: str | None = None) -> None:
    """Place one legend above the panels.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    panel : matplotlib.axes.Axes
        The panel with the labelled lines.
    title : str, optional
        Title of the legend.
    """
    handles, labels = panel.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), title=title)


def colour(number: int) -> str:
    """Give the colour of a line by its number.

    Parameters
    ----------
    number : int
        Number of the line, from 0.

    Returns
    -------
    str
        Colour of the palette.
    """
    return PALETTE[number % len(PALETTE)]
