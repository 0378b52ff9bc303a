"""The film of a journal bearing at its equilibrium."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from gearbow.plotting.style import GivenAxes, colour, legend, panels

if TYPE_CHECKING:
    from gearbow.description.journal import PadFilm

#: Radius of the journal in clearances, so that a film is visible.
_JOURNAL_RADIUS = 4.0
#: Thickness of a pad and length of the highest pressure, in clearances.
_PAD_THICKNESS, _PRESSURE_LENGTH = 0.5, 2.5


def film(
    pads: Sequence["PadFilm"],
    place: tuple[float, float],
    clearance: float,
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw pads, journal and pressure across the shaft, and the film over the angle."""
    highest = max(float(pad.pressure.max()) for pad in pads)
    with panels(3, 4.4, columns=3, width=14.0, ax=ax) as (figure, (across, thickness, pressure)):
        centre = complex(*place) / clearance
        turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 181))
        _fill(across, centre + _JOURNAL_RADIUS * turn, fc="0.85", ec="black", label="journal")
        across.plot(0.0, 0.0, "+", color="black", label="centre of the bearing")
        across.plot(
            centre.real, centre.imag, "o", color="black", markersize=4.0, label="journal centre"
        )
        for number, pad in enumerate(pads):
            style: dict[str, Any] = {"color": colour(number)}
            direction = np.exp(1j * pad.angles)
            # the film of a tilted pad belongs to the journal at its place
            bore = centre + (_JOURNAL_RADIUS + pad.thickness / clearance) * direction
            back = bore + _PAD_THICKNESS * direction
            _fill(across, np.concatenate([bore, back[::-1]]), fc=style["color"], ec="black")
            share = pad.pressure / highest if highest > 0.0 else pad.pressure
            tips = back + _PRESSURE_LENGTH * share * direction
            _fill(
                across, np.concatenate([back, tips[::-1]]), fc=style["color"], ec="none", alpha=0.3
            )
            across.plot(tips.real, tips.imag, linewidth=1.0, **style)
            if pad.pivot is not None:
                at = np.interp(pad.pivot, pad.angles, np.arange(pad.angles.size))
                tip = back[round(float(at))] * (1.0 + 0.03)
                known: dict[str, Any] = {"label": "pivot"} if number == 0 else {}
                across.plot(tip.real, tip.imag, "^", color="black", markersize=7.0, **known)
            label = f"pad {number + 1}" if len(pads) > 1 else None
            degrees = np.degrees(pad.angles)
            thickness.plot(degrees, 1e6 * pad.thickness, label=label, **style)
            pressure.plot(degrees, 1e-6 * pad.pressure, **style)
        across.set_aspect("equal")
        across.set(xlabel="y [clearances]", ylabel="z [clearances]")
        across.set_title("gaps enlarged, pressure outside", loc="left")
        thickness.set(xlabel="angle from y towards z [°]", ylabel="film thickness [µm]")
        thickness.set_ylim(bottom=0.0)
        pressure.set(xlabel="angle from y towards z [°]", ylabel="pressure [MPa]")
        pressure.set_ylim(bottom=0.0)
        legend(figure, across, ax=ax)
        if len(pads) > 1 and ax is None:
            thickness.legend()
    return figure


def _fill(panel: Any, points: Any, **style: Any) -> None:
    panel.fill(points.real, points.imag, **style)
