"""Figures of spectra, orders and waterfalls."""

from collections.abc import Sequence

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.style import PALETTE, panels

__all__ = ["orders", "spectrum", "waterfall"]

#: Smallest amplitudes of a spectrum and of a waterfall, relative to the largest.
_LINES, _COLOURS = 1e-6, 1e-3


def spectrum(frequencies_hz: Array, amplitudes: Array, label: str) -> Figure:
    """Draw one spectrum.

    Parameters
    ----------
    frequencies_hz : ndarray, shape (n,)
        Frequencies [Hz].
    amplitudes : ndarray, shape (n,)
        Amplitudes.
    label : str
        Name and unit of the signal.

    Returns
    -------
    matplotlib.figure.Figure
        Amplitude against frequency.
    """
    with panels(1, 4.0, columns=1) as (figure, (panel,)):
        panel.semilogy(frequencies_hz, amplitudes)
        top = amplitudes.max(initial=0.0)
        if top > 0.0:
            panel.set_ylim(_LINES * top, 2.0 * top)
            panel.set_xlim(0.0, _highest(frequencies_hz, amplitudes, _LINES))
        panel.set(xlabel="frequency [Hz]", ylabel=label)
    return figure


def orders(names: Sequence[str], amplitudes: Array, label: str) -> Figure:
    """Draw orders as bars.

    Parameters
    ----------
    names : sequence of str, length n
        Names of the orders.
    amplitudes : ndarray, shape (n,)
        Amplitudes.
    label : str
        Name and unit of the amplitude.

    Returns
    -------
    matplotlib.figure.Figure
        One bar for each order, the first at the top.
    """
    with panels(1, 1.2 + 0.45 * len(names), columns=1) as (figure, (panel,)):
        panel.barh(np.arange(len(names)), amplitudes, color=PALETTE[0], log=True)
        panel.set_yticks(np.arange(len(names)), names)
        panel.invert_yaxis()
        panel.grid(visible=False, axis="y")
        panel.set(xlabel=label)
    return figure


def waterfall(
    speeds: Array,
    frequencies_hz: Array,
    amplitudes: Array,
    label: str,
    *,
    lines: Sequence[tuple[str, float]],
    highest: float | None,
) -> Figure:
    """Draw spectra against the speed.

    Parameters
    ----------
    speeds : ndarray, shape (runs,)
        Speeds of the reference shaft, ascending [rad/s].
    frequencies_hz : ndarray, shape (n,)
        Frequencies [Hz].
    amplitudes : ndarray, shape (runs, n)
        Amplitudes.
    label : str
        Name and unit of the signal.
    lines : sequence of (str, float)
        Name and order of each line, by ascending order.
    highest : float or None
        Largest frequency of the figure [Hz]; None includes all visible amplitudes.

    Returns
    -------
    matplotlib.figure.Figure
        Amplitude as colour; dashed lines are orders of shafts and meshes.
    """
    top = float(amplitudes.max())
    if highest is None:
        highest = _highest(frequencies_hz, amplitudes.max(axis=0), _COLOURS)
    with panels(1, 6.0, columns=1) as (figure, (panel,)):
        drawn = panel.pcolormesh(
            frequencies_hz,
            speeds,
            np.maximum(amplitudes, _COLOURS * top),
            norm=LogNorm(_COLOURS * top, top) if top > 0.0 else None,
            cmap="cividis",
            shading="nearest",
            rasterized=True,
        )
        figure.colorbar(drawn, ax=panel, label=label)
        free = highest
        # Names from the highest order down; a name without space is omitted.
        for name, order in reversed(lines):
            at = order * speeds / (2.0 * np.pi)
            panel.plot(at, speeds, "--", color="white", linewidth=0.8)
            if at[-1] <= free:
                free = at[-1] - 0.04 * highest
                panel.annotate(
                    name,
                    (at[-1], speeds[-1]),
                    xytext=(0, 12),
                    textcoords="offset points",
                    rotation=35,
                    fontsize=10,
                    annotation_clip=False,
                )
        panel.grid(visible=False)
        panel.set(xlabel="frequency [Hz]", ylabel="speed of the reference shaft [rad/s]")
        panel.set_xlim(0.0, highest)
    return figure


def _highest(frequencies: Array, amplitudes: Array, fraction: float) -> float:
    """Give 1.1 times the largest frequency with an amplitude above a fraction of the maximum."""
    visible = np.flatnonzero(amplitudes > fraction * amplitudes.max(initial=0.0))
    end = float(frequencies[-1])
    return min(1.1 * float(frequencies[visible[-1]]), end) if visible.size else end
