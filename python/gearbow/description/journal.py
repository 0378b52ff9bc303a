"""Journal bearings: the oil film between a shaft and its bearing."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import number
from gearbow._core import film_coefficients
from gearbow._shown import ReadOnly
from gearbow._types import Array, FilmModel, Plain
from gearbow.description.part import Part, freeze
from gearbow.description.places import Base, with_support


@dataclass(frozen=True, eq=False)
class FilmCoefficients(ReadOnly):
    """Equilibrium of a journal under a static load, and the linear coefficients there.

    Parameters
    ----------
    stiffness : ndarray, shape (2, 2)
        Stiffness over (y, z) [N/m]: across the load, then along it, for a load along −z.
    damping : ndarray, shape (2, 2)
        Damping over (y, z) [N s/m].
    eccentricity_ratio : float
        Displacement of the journal over the radial clearance.
    attitude_angle : float
        Angle from the load to the displacement, in the sense of the rotation [rad].
    sommerfeld : float
        Sommerfeld number S = μNLD/W (R/c)² with the speed N in turns per second.

    Examples
    --------
    >>> import gearbow as gb
    >>> size = {"diameter": 0.1, "length": 0.03, "clearance": 1e-4}
    >>> bearing = gb.JournalBearing("rotor", 0.0, viscosity=0.1, **size)
    >>> film = bearing.coefficients(load=525.0, speed=157.08)
    >>> print(f"{film.attitude_angle:.3f} {film.sommerfeld:.3f}")
    1.233 3.571
    """

    stiffness: Array
    damping: Array
    eccentricity_ratio: float
    attitude_angle: float
    sommerfeld: float


@dataclass(frozen=True)
class JournalBearing(Part):
    """A plain bearing with an oil film, whose force is a nonlinear function of the motion.

    It is one of the `bearings` of a `gearbow.RotorSystem`. The load on the film follows from the
    static equilibrium with mesh forces, torques and gravity, so that stiffness and damping change
    with torque and speed. Linear analyses use the coefficients at the equilibrium of their speed;
    runs use the nonlinear film force.

    Parameters
    ----------
    shaft : str
        Name of its shaft.
    position : float
        Position on the shaft, from its left end [m].
    diameter : float
        Diameter D of the journal [m].
    length : float
        Length L of the bearing [m].
    clearance : float
        Radial clearance c: difference of the radii of bearing and journal [m].
    viscosity : float
        Dynamic viscosity μ of the oil [Pa s].
    film : {"short", "finite"}
        "short" is the solution for L ≪ D in closed form (Ocvirk), good up to L/D of about 0.5.
        "finite" interpolates a table of solutions of Reynolds' equation, for L/D from 0.1 to 2. The
        table is computed at the first use.
    grooves : array_like, shape (k, 2), optional
        Axial grooves of a finite film, in which the pressure is zero: angle of the middle, from y
        towards z, and extent [rad].
    axial_stiffness : float
        Stiffness along the axis of the shaft [N/m], that of a thrust bearing.
    axial_damping : float
        Damping along the axis of the shaft [N s/m].
    support : str, Support or tuple of (str, float), optional
        What it stands on: the name of a support or housing of the system, a support of its own, or
        (shaft, position [m]) of another shaft. None is the ground.

    Notes
    -----
    Between two shafts, the film depends on the sum of their speeds, and carries nothing where they
    counter-rotate at one speed. The film is isoviscous, laminar and incompressible, and the journal
    stays parallel to the bearing. The pressure is never negative: the short film ruptures where it
    is not squeezed (Gümbel), the finite film where pressure and its gradient vanish (Reynolds).

    References
    ----------
    F. W. Ocvirk, *Short-bearing approximation for full journal bearings*, NACA TN 2808, 1952.
    J. W. Lund and K. K. Thomsen, *A calculation method and data for the dynamic coefficients of
    oil-lubricated journal bearings*, ASME, 1978.

    Examples
    --------
    >>> import gearbow as gb
    >>> bearing = gb.JournalBearing(
    ...     "rotor", 0.0, diameter=0.1, length=0.03, clearance=1e-4, viscosity=0.1
    ... )
    >>> film = bearing.coefficients(load=525.0, speed=157.08)
    >>> print(f"{film.eccentricity_ratio:.4f}")
    0.2663
    """

    shaft: str
    position: float
    _: KW_ONLY
    diameter: float
    length: float
    clearance: float
    viscosity: float
    film: FilmModel = "short"
    grooves: "ArrayLike | None" = None
    axial_stiffness: float = 0.0
    axial_damping: float = 0.0
    support: Base | None = None

    def __post_init__(self) -> None:
        freeze(self, "grooves")

    def coefficients(self, load: float, speed: float) -> FilmCoefficients:
        """Find the equilibrium under a static load, and stiffness and damping there.

        Parameters
        ----------
        load : float
            Load of the shaft on the bearing along −z [N].
        speed : float
            Speed of the shaft about +x [rad/s], positive.

        Returns
        -------
        FilmCoefficients
            Stiffness, damping, eccentricity ratio and attitude angle. y is across the load, z
            along it.

        Raises
        ------
        SceneError
            If load or speed is not positive, an entry of the bearing is impossible, or the journal
            touches the bearing.
        """
        weight, spin = number(load, "load"), number(speed, "speed")
        found = film_coefficients(self._describe("bearing"), (0.0, -weight), spin)
        y, z = found["displacement"]
        turns = spin / (2.0 * np.pi)
        plain = self._in_si("bearing")
        bearing_number = plain.viscosity * turns * plain.length * plain.diameter / abs(weight)
        return FilmCoefficients(
            stiffness=found["stiffness"],
            damping=found["damping"],
            eccentricity_ratio=float(np.hypot(y, z) / plain.clearance),
            attitude_angle=float(np.arctan2(y, -z)),
            sommerfeld=float(bearing_number * (plain.diameter / (2.0 * plain.clearance)) ** 2),
        )

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "JournalBearing":
        return cls(**with_support(description))
