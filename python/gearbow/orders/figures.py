"""Figures of spectra, orders and waterfalls."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plots import PALETTE, _figure

if TYPE_CHECKING:
    from gearbow.orders.fit import Orders
    from gearbow.orders.spectrum import Spectrum
    from gearbow.orders.waterfall import Waterfall

#: Parts of the largest amplitude below which nothing is drawn.
_LINES, _COLOURS = 1e-6, 1e-3


def spectrum(result: "Spectrum") -> Figure:
    """Draw one spectrum.

    Parameters
    ----------
    result : Spectrum
        The spectrum.

    Returns
    -------
    matplotlib.figure.Figure
        Amplitude against frequency.
    """
    with _figure(1, 4.0, columns=1) as (figure, (panel,)):
        panel.semilogy(result.frequencies_hz, result.amplitudes)
        top = result.amplitudes.max(initial=0.0)
        if top > 0.0:
            panel.set_ylim(_LINES * top, 2.0 * top)
            panel.set_xlim(0.0, _highest(result.frequencies_hz, result.amplitudes, _LINES))
        panel.set(xlabel="frequency [Hz]", ylabel=f"{result.label} [{result.unit}]")
    return figure


def orders(result: "Orders", count: int) -> Figure:
    """Draw the largest orders as bars.

    Parameters
    ----------
    result : Orders
        The orders.
    count : int
        How many.

    Returns
    -------
    matplotlib.figure.Figure
        One bar for each order, by ascending frequency.
    """
    amplitudes = np.abs(result.amplitudes)
    chosen = np.sort(np.argsort(-amplitudes, kind="stable")[:count])
    with _figure(1, 1.2 + 0.45 * len(chosen), columns=1) as (figure, (panel,)):
        names = [f"{result.orders[j].names[0]} ({result.frequencies_hz[j]:.4g} Hz)" for j in chosen]
        panel.barh(np.arange(len(chosen)), amplitudes[chosen], color=PALETTE[0], log=True)
        panel.set_yticks(np.arange(len(chosen)), names)
        panel.invert_yaxis()
        panel.grid(visible=False, axis="y")
        panel.set(xlabel=f"amplitude of {result.label} [{result.unit}]")
    return figure


def waterfall(result: "Waterfall", highest: float | None) -> Figure:
    """Draw spectra over the speed.

    Parameters
    ----------
    result : Waterfall
        The spectra.
    highest : float or None
        Frequency up to which to draw [Hz].

    Returns
    -------
    matplotlib.figure.Figure
        Amplitude as colour; dashed lines are first orders of shafts and meshes.
    """
    top = float(result.amplitudes.max())
    if highest is None:
        highest = _highest(result.frequencies_hz, result.amplitudes.max(axis=0), _COLOURS)
    with _figure(1, 6.0, columns=1) as (figure, (panel,)):
        drawn = panel.pcolormesh(
            result.frequencies_hz,
            result.speeds,
            np.maximum(result.amplitudes, _COLOURS * top),
            norm=LogNorm(_COLOURS * top, top) if top > 0.0 else None,
            cmap="cividis",
            shading="nearest",
            rasterized=True,
        )
        figure.colorbar(drawn, ax=panel, label=f"{result.label} [{result.unit}]")
        free = highest
        # From the fastest down, so that of crowded lines the first has its name.
        known = () if result.kinematics is None else result.kinematics.orders(1, 4, 0)
        for order in reversed(known):
            at = order.value * result.speeds / (2.0 * np.pi)
            panel.plot(at, result.speeds, "--", color="white", linewidth=0.8)
            if at[-1] <= free:
                free = at[-1] - 0.04 * highest
                panel.annotate(
                    order.names[0],
                    (at[-1], result.speeds[-1]),
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


def _highest(frequencies: Array, amplitudes: Array, part: float) -> float:
    """Give the frequency above which nothing stands out, and a little more."""
    seen = np.flatnonzero(amplitudes > part * amplitudes.max(initial=0.0))
    end = float(frequencies[-1])
    return min(1.1 * float(frequencies[seen[-1]]), end) if seen.size else end
