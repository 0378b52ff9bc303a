"""Figures of what people look at.

A figure is returned, never shown, and no global setting of matplotlib changes.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import product
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearbow._describe import is_pair, places
from gearbow._types import Array, At, ComplexArray
from gearbow.energy import ENERGIES, WORKS
from gearbow.errors import GearbowError
from gearbow.orders.spectrum import amplitudes

if TYPE_CHECKING:
    from gearbow.energy import EnergyBalance
    from gearbow.modes import Modes
    from gearbow.response import Response
    from gearbow.synchronous import Synchronous

__all__ = [
    "KINDS",
    "PALETTE",
    "STYLE",
    "energy_balance",
    "history",
    "mesh",
    "modes",
    "orbits",
    "spectrum",
    "synchronous",
    "twist",
]

#: Colours that stay apart for colour-blind readers: Okabe and Ito, *Color universal design* (2008).
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

#: Settings of every figure: large enough to be read at half size.
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

_MICRO = 1e6


def orbits(response: "Response", names: At | Sequence[At] | None = None) -> Figure:
    """Draw the path of each centre in the plane of rotation.

    Parameters
    ----------
    response : Response
        The response.
    names : str, tuple of (str, float), or sequence of them, optional
        What to draw; None is all that has a name, or else all that there is.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each centre, v to the right and w up, in µm.
    """
    chosen = _points(response, names)
    with _figure(len(chosen), 3.8, columns=4, width=4.0 * min(4, len(chosen))) as (figure, panels):
        for panel, name in zip(panels, chosen, strict=True):
            v, w = _MICRO * response.displacement(name).T
            panel.plot(v, w)
            panel.plot(v[-1:], w[-1:], "o", color=PALETTE[1])
            panel.set(title=_label(name), xlabel="v [µm]", ylabel="w [µm]")
            panel.set_aspect("equal", adjustable="datalim")
            panel.locator_params(nbins=5)
    return figure


def history(response: "Response", names: At | Sequence[At] | None = None) -> Figure:
    """Draw the displacement of each centre against time.

    Parameters
    ----------
    response : Response
        The response.
    names : str, tuple of (str, float), or sequence of them, optional
        What to draw; None is all that has a name, or else all that there is.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each centre, v and w in µm.
    """
    chosen = _points(response, names)
    with _figure(len(chosen), 2.4, columns=1, sharex=True) as (figure, panels):
        for panel, name in zip(panels, chosen, strict=True):
            panel.plot(response.time, _MICRO * response.displacement(name), label=["v", "w"])
            panel.set(ylabel=f"{_label(name)} [µm]")
        panels[-1].set(xlabel="time [s]")
        _legend(figure, panels[0])
    return figure


def twist(response: "Response", names: At | Sequence[At] | None = None) -> Figure:
    """Draw the twist of each point against time.

    Parameters
    ----------
    response : Response
        The response.
    names : str, tuple of (str, float), or sequence of them, optional
        What to draw; None is all that has a name, or else all that there is.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each point, in mrad from the uniform spin.
    """
    chosen = _points(response, names)
    with _figure(len(chosen), 2.4, columns=1, sharex=True) as (figure, panels):
        for panel, name in zip(panels, chosen, strict=True):
            panel.plot(response.time, 1e3 * response.twist(name))
            panel.set(ylabel=f"{_label(name)} [mrad]")
        panels[-1].set(xlabel="time [s]")
    return figure


def mesh(
    response: "Response", names: tuple[str, str] | Sequence[tuple[str, str]] | None = None
) -> Figure:
    """Draw the geometry of the meshes, which follows their moving centres.

    Parameters
    ----------
    response : Response
        The response.
    names : tuple of (str, str), or sequence of them, optional
        Pairs (driver, driven); None is all of them.

    Returns
    -------
    matplotlib.figure.Figure
        A column for each pair: contact ratio, pressure angle and angle of the line of centres
        [degrees].
    """
    given: Any = response._data["meshes"] if names is None else names
    pairs: list[tuple[str, str]] = [given] if is_pair(given) else list(given)
    if not pairs:
        raise GearbowError("no mesh was recorded; give record=['meshes'] to simulate")
    columns = len(pairs)
    with _figure(3 * columns, 2.6, columns=columns, width=max(9.0, 6.0 * columns), sharex=True) as (
        figure,
        panels,
    ):
        for column, (driver, driven) in enumerate(pairs):
            pair = response.mesh(driver, driven)
            rows = {
                "contact ratio": pair.contact_ratio,
                "pressure angle [°]": np.degrees(pair.pressure_angle),
                "line of centres [°]": np.degrees(pair.centre_line_angle),
            }
            for row, (label, values) in enumerate(rows.items()):
                panel = panels[row * columns + column]
                panel.plot(response.time, values, color=_colour(column))
                panel.set(ylabel=label)
                # A hundredth of a degree on twenty: the ticks say it in full.
                panel.ticklabel_format(axis="y", useOffset=False)
            panels[column].set(title=f"{driver} – {driven}")
            panels[2 * columns + column].set(xlabel="time [s]")
    return figure


def spectrum(response: "Response", names: At | Sequence[At] | None = None) -> Figure:
    """Draw the amplitude spectrum of the displacement of each centre.

    Parameters
    ----------
    response : Response
        The response, recorded at equally spaced times.
    names : str, tuple of (str, float), or sequence of them, optional
        What to draw; None is all that has a name, or else all that there is.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each centre: amplitude of v and w [µm] against frequency [Hz], through a Hann
        window.

    Raises
    ------
    GearbowError
        If the times are not equally spaced.
    """
    chosen = _points(response, names)
    highest = 0.0
    with _figure(len(chosen), 2.4, columns=1, sharex=True) as (figure, panels):
        for panel, name in zip(panels, chosen, strict=True):
            frequency, amplitude = amplitudes(response.time, response.displacement(name))
            panel.semilogy(frequency, _MICRO * amplitude, label=["v", "w"])
            panel.set(ylabel=f"{_label(name)} [µm]")
            # Decades of round-off below the peak tell nothing.
            top = amplitude.max()
            if top > 0.0:
                panel.set_ylim(_MICRO * 1e-6 * top, _MICRO * 2.0 * top)
                highest = max(highest, frequency[np.any(amplitude > 1e-6 * top, axis=1)][-1])
        if highest > 0.0:
            panels[-1].set_xlim(0.0, 1.1 * highest)
        panels[-1].set(xlabel="frequency [Hz]")
        _legend(figure, panels[0])
    return figure


def synchronous(response: "Synchronous", names: At | Sequence[At]) -> Figure:
    """Draw the largest semi-axis of the orbits against the speed.

    Parameters
    ----------
    response : Synchronous
        The linear response.
    names : str, tuple of (str, float), or sequence of them
        Gears, disks or (shaft, position [m]).

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each name, one line for each shaft that excites the train.
    """
    chosen = places(names, "names")
    with _figure(len(chosen), 2.8, columns=1, sharex=True) as (figure, panels):
        for panel, name in zip(panels, chosen, strict=True):
            orbit = _MICRO * response.orbit(name)
            for source, shaft in enumerate(response.shafts):
                if np.any(orbit[:, source] > 0.0):
                    panel.semilogy(
                        response.speeds,
                        orbit[:, source],
                        label=shaft,
                        color=_colour(source),
                    )
            panel.set(ylabel=f"{_label(name)} [µm]")
        panels[-1].set(xlabel="speed of the reference shaft [rad/s]")
        _legend(figure, panels[0], title="excited by the shaft")
    return figure


def energy_balance(balance: "EnergyBalance") -> Figure:
    """Draw energies, works and what is left over, against time.

    Parameters
    ----------
    balance : EnergyBalance
        The balance.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each [J]; terms that are zero throughout are left out.
    """
    rows = {"energy": (ENERGIES, "total"), "work": (WORKS, "work"), "residual": ((), "residual")}
    with _figure(3, 3.0, columns=1, sharex=True) as (figure, panels):
        for panel, (label, (terms, total)) in zip(panels, rows.items(), strict=True):
            for i, name in enumerate(terms):
                values = getattr(balance, name)
                if np.any(values != 0.0):
                    panel.plot(balance.time, values, color=_colour(i), label=name)
            panel.plot(balance.time, getattr(balance, total), color=PALETTE[-1], label="all")
            panel.set(ylabel=f"{label} [J]")
            if terms:
                panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        panels[-1].set(xlabel="time [s]")
    return figure


def modes(result: "Modes", count: int = 6) -> Figure:
    """Draw the first mode shapes along the shafts.

    Parameters
    ----------
    result : Modes
        The modes.
    count : int
        How many.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each mode: v (solid) and w (dashed), or the twist where that has more than
        half of the energy, over the largest of them.
    """
    names = result.names()[:count]
    shares = result.energy_shares()
    twisting = sum(share for (_, direction), share in shares.items() if direction == "twist")
    twists = np.broadcast_to(twisting, len(result.whirl)) > 0.5
    shafts = list(dict.fromkeys(shaft for shaft, _, _ in result.dofs))
    with _figure(len(names), 3.0, columns=2, width=13.0) as (figure, panels):
        for mode, (panel, name) in enumerate(zip(panels, names, strict=True)):
            lines = {"twist": "-"} if twists[mode] else {"v": "-", "w": "--"}
            shape = _real(result.shapes[mode], [d in lines for _, _, d in result.dofs])
            for (direction, line), (i, shaft) in product(lines.items(), enumerate(shafts)):
                at = [n for n, (s, _, d) in enumerate(result.dofs) if (s, d) == (shaft, direction)]
                x = [result.dofs[n][1] for n in at]
                label = None if direction == "w" else shaft
                panel.plot(x, shape[at], line, color=_colour(i), label=label)
            panel.set(title=f"{result.frequencies_hz[mode]:.1f} Hz: {name}", xlabel="position [m]")
            panel.set(ylabel="twist" if twists[mode] else "v (w dashed)", ylim=(-1.15, 1.15))
        _legend(figure, panels[0])
    return figure


#: The drawings of a response, by the name that `Response.plot` takes.
KINDS: dict[str, Callable[..., Figure]] = {
    "orbits": orbits,
    "history": history,
    "twist": twist,
    "mesh": mesh,
    "spectrum": spectrum,
}


@contextmanager
def _figure(
    count: int, height: float, *, columns: int, width: float = 12.0, sharex: bool = False
) -> Iterator[tuple[Figure, list[Axes]]]:
    """Lay out panels in rows; the style holds as long as something is drawn."""
    columns = min(columns, count)
    rows = -(-count // columns)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height * rows + 0.8))
        grid = figure.subplots(rows, columns, squeeze=False, sharex=sharex)
        panels = list(grid.flat)
        for panel in panels[count:]:
            panel.remove()
        yield figure, panels[:count]
        figure.align_ylabels()


def _legend(figure: Figure, panel: Axes, title: str | None = None) -> None:
    """Put one legend above the panels, where it covers no data."""
    handles, labels = panel.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), title=title)


def _points(response: "Response", names: At | Sequence[At] | None) -> list[At]:
    if names is not None:
        return list(places(names, "names"))
    points = response._data["points"]
    named: list[At] = [names[0] for _, _, names in points if names]
    chosen = named or [(shaft, position) for shaft, position, _ in points]
    if not chosen:
        raise GearbowError("no motion was recorded; give record=['gears'] to simulate")
    return chosen


def _label(name: At) -> str:
    return name if isinstance(name, str) else f"{name[0]} at {name[1]:g} m"


def _colour(number: int) -> str:
    return PALETTE[number % len(PALETTE)]


def _real(shape: ComplexArray, counted: Sequence[bool]) -> Array:
    """Turn a complex shape until the largest of the counted entries is 1."""
    largest = shape[int(np.argmax(np.where(counted, np.abs(shape), 0.0)))]
    return np.real(shape / largest) if largest != 0.0 else np.real(shape)
