"""Rolling bearings: balls or rollers between a shaft and what it stands on."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import number
from gearbow._core import rolling_coefficients
from gearbow._read_only import ReadOnly
from gearbow._types import Array, Plain, RollingContact
from gearbow.description.part import Part
from gearbow.description.supports import Support, with_support

__all__ = ["RollingBearing", "RollingCoefficients"]


@dataclass(frozen=True, eq=False)
class RollingCoefficients(ReadOnly):
    """Equilibrium of a rolling bearing under a static load, and the linear coefficients there.

    Parameters
    ----------
    displacement : ndarray, shape (2,)
        Displacement of the shaft along y and z [m].
    stiffness : ndarray, shape (2, 2)
        Stiffness over (y, z) [N/m].
    damping : ndarray, shape (2, 2)
        Damping over (y, z) [N s/m].
    contact_forces : ndarray, shape (n,)
        Contact force of each rolling element [N]; at the cage angle 0 for a mean.

    Examples
    --------
    >>> import gearbow as gb
    >>> bearing = gb.RollingBearing(
    ...     "rotor", 0.0, elements=9, element_diameter=0.0127, pitch_diameter=0.065, clearance=1e-5
    ... )
    >>> print(f"{bearing.coefficients(load=500.0).stiffness[1, 1]:.3g} N/m")
    9.79e+07 N/m
    """

    displacement: Array
    stiffness: Array
    damping: Array
    contact_forces: Array


@dataclass(frozen=True)
class RollingBearing(Part):
    """A ball or roller bearing, whose elements turn with the cage and carry in compression only.

    It is one of the `bearings` of a `gearbow.RotorSystem`. Each element carries Q = K δ^p with its
    deflection δ, p = 3/2 for balls and 10/9 for rollers. Runs follow the elements with the angle of
    the cage, so that the stiffness varies at the ball-pass frequency. Static equilibrium and linear
    analyses use the force averaged over the angle of the cage.

    Parameters
    ----------
    shaft : str
        Name of its shaft.
    position : float
        Position on the shaft, from its left end [m].
    elements : int
        Number n of rolling elements, balls or rollers.
    element_diameter : float
        Diameter d of a ball or roller [m].
    pitch_diameter : float
        Diameter D of the circle through the centres of the elements [m].
    clearance : float
        Radial internal clearance (ISO 5753): motion of the unloaded shaft from one side to the
        opposite one, twice the radial gap [m]. A negative clearance is a preload.
    hertz_stiffness : float, optional
        Stiffness K of one element between both races [N/m^1.5] or, for a roller, [N/m^(10/9)]. None
        is that of the geometry for bearing steel (206 GPa, 0.3): Brewe and Hamrock for balls,
        Palmgren for rollers.
    contact : {"ball", "roller"}
        Point contact, or line contact.
    contact_angle : float
        Angle of the line of contact to the radial plane [rad].
    damping : float, pair or 2×2 array
        Damping between shaft and bearing [N s/m], constant.
    phase : float
        Angle of the first element from y towards z at the shaft angle 0 [rad].
    inner_groove, outer_groove : float, optional
        Groove radius of a race over the ball diameter, above 0.5; None is 0.52.
    roller_length : float, optional
        Effective length of a roller [m]; a roller bearing needs it or `hertz_stiffness`.
    axial_stiffness : float
        Stiffness along the axis of the shaft [N/m]; it has no influence on the radial force.
    axial_damping : float
        Damping along the axis of the shaft [N s/m].
    tilting_stiffness : float
        Stiffness against rotations of the shaft about y and z [N m/rad].
    tilting_damping : float
        Damping of these rotations [N m s/rad].
    support : str or Support, optional
        What it stands on: the name of a support or housing of the system, or a support of its own.
        None is the ground.

    Notes
    -----
    The outer ring stands. The cage turns at (1 − (d/D) cos α)/2 times the speed of the shaft
    (`cage_order`); n times this is the ball-pass order of the outer ring (`ball_pass_order`).
    Slip, centrifugal forces and the axial motion of the shaft are not modelled.

    References
    ----------
    T. A. Harris, *Rolling Bearing Analysis*, 4th ed., Wiley, 2001, chapters 6 to 8.
    D. E. Brewe and B. J. Hamrock, *Simplified solution for elliptical-contact deformation between
    two elastic solids*, J. Lubr. Technol. 99, 1977.

    Examples
    --------
    >>> import gearbow as gb
    >>> bearing = gb.RollingBearing(
    ...     "rotor", 0.0, elements=9, element_diameter=0.0127, pitch_diameter=0.065, clearance=1e-5
    ... )
    >>> print(f"{bearing.cage_order:.4f} {bearing.ball_pass_order:.3f}")
    0.4023 3.621
    """

    shaft: str
    position: float
    _: KW_ONLY
    elements: int
    element_diameter: float
    pitch_diameter: float
    clearance: float
    hertz_stiffness: float | None = None
    contact: RollingContact = "ball"
    contact_angle: float = 0.0
    damping: ArrayLike = 0.0
    phase: float = 0.0
    inner_groove: float | None = None
    outer_groove: float | None = None
    roller_length: float | None = None
    axial_stiffness: float = 0.0
    axial_damping: float = 0.0
    tilting_stiffness: float = 0.0
    tilting_damping: float = 0.0
    support: str | Support | None = None

    def coefficients(self, load: float, cage_angle: float | None = None) -> RollingCoefficients:
        """Find the displacement under a static load, and stiffness and damping there.

        Parameters
        ----------
        load : float
            Load of the shaft on the bearing along −z [N].
        cage_angle : float, optional
            Angle of the cage [rad]. None averages the force over the angles of the cage (Sjövall's
            integral), as static equilibrium and linear analyses do.

        Returns
        -------
        RollingCoefficients
            Displacement, stiffness, damping and contact forces.

        Raises
        ------
        SceneError
            If the load or an entry of the bearing is impossible.
        """
        cage = None if cage_angle is None else number(cage_angle, "cage_angle")
        found = rolling_coefficients(self._describe("bearing"), (0.0, -number(load, "load")), cage)
        return RollingCoefficients(
            np.array(found["displacement"]),
            found["stiffness"],
            found["damping"],
            np.array(found["contact_forces"]),
        )

    @property
    def stiffness_of_contact(self) -> float:
        """Stiffness K of one element between both races, given or that of the geometry.

        Returns
        -------
        float
            Stiffness [N/m^1.5], or [N/m^(10/9)] for a roller.
        """
        found = rolling_coefficients(self._describe("bearing"), (0.0, 0.0), None)
        return found["hertz_stiffness"]

    @property
    def cage_order(self) -> float:
        """Speed of the cage over the speed of the shaft.

        Returns
        -------
        float
            (1 − (d/D) cos α)/2.
        """
        found = rolling_coefficients(self._describe("bearing"), (0.0, 0.0), None)
        return found["cage_ratio"]

    @property
    def ball_pass_order(self) -> float:
        """Frequency at which elements pass a point of the outer ring, over that of the shaft.

        Returns
        -------
        float
            The number of elements times `cage_order`.
        """
        return self.elements * self.cage_order

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "RollingBearing":
        return cls(**with_support(description))
