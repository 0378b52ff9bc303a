"""Tip relief, transmission error and friction of a mesh."""

from collections.abc import Sequence
from dataclasses import dataclass

from gearbow.description.part import Part, freeze

#: (amplitude [m], phase [rad]) of the orders 1, 2, ….
Harmonics = Sequence[Sequence[float]]


@dataclass(frozen=True)
class TipRelief(Part):
    """Tip relief of both gears: material removed from the flanks at the ends of the path.

    Parameters
    ----------
    amount : float
        Relief at the end of the path of contact [m].
    length : float
        Length of the relief along the path, from either end [m].
    shape : {"linear", "parabolic"}
        Start of the relief: with a corner, or tangent to the involute.

    Notes
    -----
    It needs a stiffness that consists of tooth pairs: "square", "parabolic" or "potential_energy".
    A pair with relief carries load when the mesh deflection exceeds the relief.

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
        The same for the harmonics of the driver's shaft, e.g. eccentricity and ovality.
    driven : sequence of (float, float), optional
        The same for the driven shaft.
    table : sequence of float, optional
        Values at 0, 1/n, 2/n, … of the mesh cycle [m], at least three; a periodic cubic spline goes
        through them.

    Notes
    -----
    The contributions add up to e = Σ a_n cos(nzϑ + p_n) with the rotation angle ϑ of a shaft. For
    `tooth` it is the angle of the driver, and z its number of teeth; for `driver` and `driven` it
    is the angle of this shaft, and z = 1. The error reduces the mesh deflection by e, like material
    removed from the drive flanks; the back flanks have no error.

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


@dataclass(frozen=True)
class MeshFriction(Part):
    """Sliding friction between the flanks of a mesh: a coefficient, or that of lubricated steel.

    Parameters
    ----------
    coefficient : float, optional
        Coefficient of friction μ; a plain number in place of a `MeshFriction` has the same meaning.
    viscosity : float, optional
        Dynamic viscosity of the oil at its temperature in the gearbox [Pa s]; with `roughness` in
        place of `coefficient`.
    roughness : float, optional
        Arithmetic mean roughness Ra of the flanks [m].
    lubricant_factor : float, optional
        Factor X_L of the lubricant; None is 1, that of mineral oil.
    transition : float
        Length of the path of contact, centred on the pitch point, on which the friction changes its
        sign, as a fraction of the base pitch; at most 0.5.

    Notes
    -----
    The friction μF_j of each tooth pair acts across the line of action, against the sliding of the
    flanks, which changes its direction at the pitch point of the moving centres. A stiffness
    without tooth pairs has the mean over the mesh cycle.

    Viscosity and roughness give the mean coefficient of ISO/TR 14179-2 (Schlenk 1994) for the load
    and the speed of each instant, at most 0.2,

        μ = 0.048 (F_bt/b / (v_ΣC ρ_redC))^0.2 η^−0.05 Ra^0.25 X_L,

    with the line load F_bt/b on the base circle, at least 150 N/mm, the sum v_ΣC of the rolling
    velocities at the pitch point, at a pitch line velocity of at most 50 m/s, and the reduced
    radius of curvature ρ_redC there; in N/mm, m/s, mm, mPa s and µm. Both gears need a face width.

    Examples
    --------
    >>> import gearbow as gb
    >>> mesh = gb.Mesh("g1", "g2", friction=0.05)
    >>> oil = gb.MeshFriction(viscosity=0.02, roughness=0.8e-6)
    >>> mesh = gb.Mesh("g1", "g2", stiffness=gb.Stiffness.square(pair=2e8), friction=oil)
    """

    coefficient: float | None = None
    viscosity: float | None = None
    roughness: float | None = None
    lubricant_factor: float | None = None
    transition: float = 0.1
