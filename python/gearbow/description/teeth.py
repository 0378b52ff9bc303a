"""Tip relief and transmission error of a mesh."""

from collections.abc import Sequence
from dataclasses import dataclass

from gearbow.description.part import Part, freeze

__all__ = ["TipRelief", "TransmissionError"]

#: (amplitude [m], phase [rad]) of the orders 1, 2, ….
Harmonics = Sequence[Sequence[float]]


@dataclass(frozen=True)
class TipRelief(Part):
    """Relief of the tips of both gears: what the flanks stand back at the ends of the path.

    Parameters
    ----------
    amount : float
        How far the flank stands back at the end of the path of contact [m].
    length : float
        How far it reaches along the path, from either end [m].
    shape : {"linear", "parabolic"}
        How it begins: at a corner, or tangent to the involute.

    Notes
    -----
    It needs a stiffness that is made of tooth pairs: "square", "parabolic" or "potential_energy". A
    relieved pair carries once the mesh has deflected by more than its relief.

    Examples
    --------
    >>> import gearbow as gb
    >>> relief = gb.TipRelief(15e-6, length=3e-3)
    >>> mesh = gb.Mesh("g1", "g2", stiffness=gb.Stiffness.square(pair=2e8), tip_relief=relief)
    """

    amount: float
    length: float
    shape: str = "linear"


@dataclass(frozen=True)
class TransmissionError(Part):
    """Unloaded transmission error of a mesh along its line of action.

    Parameters
    ----------
    tooth : sequence of (float, float), optional
        Amplitude a [m] and phase p [rad] of each harmonic 1, 2, … of the mesh frequency.
    driver : sequence of (float, float), optional
        The same of the driver's shaft, e.g. its eccentricity and ovality.
    driven : sequence of (float, float), optional
        The same of the driven shaft.
    table : sequence of float, optional
        Values at 0, 1/n, 2/n, … of the mesh cycle [m], at least three; a periodic cubic spline goes
        through them.

    Notes
    -----
    The parts add up to e = Σ a_n cos(nzϑ + p_n), where ϑ is the angle that a shaft has spun: for
    `tooth` that of the driver, with its z teeth, for `driver` and `driven` that of either shaft,
    with z = 1. The deflection of the mesh is smaller by e, as if so much were missing from the
    driving flanks; the flanks behind them have no error.

    Examples
    --------
    A tooth error of 5 µm with its second harmonic, and 20 µm at each turn of the driven gear:

    >>> import gearbow as gb
    >>> error = gb.TransmissionError(tooth=[(5e-6, 0.0), (1e-6, 1.2)], driven=[(20e-6, 0.0)])
    >>> error.driven
    ((2e-05, 0.0),)
    """

    tooth: Harmonics | None = None
    driver: Harmonics | None = None
    driven: Harmonics | None = None
    table: Sequence[float] | None = None

    def __post_init__(self) -> None:
        freeze(self, "tooth", "driver", "driven", "table")
