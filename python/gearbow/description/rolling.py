"""Rolling bearings: balls or rollers between a shaft and what it stands on."""

from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import matrix, number, real
from gearbow._core import ring_coefficients, rolling_coefficients, rolling_estimate
from gearbow._shown import ReadOnly
from gearbow._types import Array, Plain, RollingContact, RollingKind
from gearbow.description.part import Part
from gearbow.description.places import Base
from gearbow.errors import SceneError

#: Fields of a rolling bearing of which a description has at least one.
ROLLING_FIELDS = ("elements", "designation", "boundary")


@dataclass(frozen=True, eq=False)
class RollingCoefficients(ReadOnly):
    """Equilibrium of a rolling bearing under a static load, and the linear coefficients there.

    Parameters
    ----------
    displacement : ndarray, shape (2,)
        Displacement of the shaft along y and z [m].
    stiffness, damping : ndarray, shape (2, 2)
        Stiffness [N/m] and damping [N s/m] over (y, z).
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


@dataclass(frozen=True, eq=False)
class RingCoefficients(ReadOnly):
    """Equilibrium of a rolling bearing under radial load, thrust and tilt, and its stiffness there.

    The coordinates are u along the axis, v along y, w along z, and the rotations B and G about y
    and z of the inner ring relative to the outer one.

    Parameters
    ----------
    displacement : ndarray, shape (5,)
        Displacements (u, v, w) [m] and rotations (B, G) [rad].
    force : ndarray, shape (5,)
        Forces [N] and moments [N m] of the shaft on the bearing.
    stiffness : ndarray, shape (5, 5)
        Their derivatives [N/m, N/rad, N m/rad], a symmetric matrix.
    contact_forces, contact_angles : ndarray, shape (n,)
        Force of each element normal to the races [N], and its contact angle under the load [rad].

    Examples
    --------
    >>> import gearbow as gb
    >>> bearing = gb.RollingBearing("rotor", 0.0, "32008X").ring_coefficients(1000.0, thrust=800.0)
    >>> print(f"{1e6 * bearing.displacement[0]:.1f} µm along the axis")
    3.5 µm along the axis
    """

    displacement: Array
    force: Array
    stiffness: Array
    contact_forces: Array
    contact_angles: Array


@dataclass(frozen=True)
class RollingEstimate(ReadOnly):
    """Rolling elements of a bearing, estimated from its boundary dimensions.

    Parameters
    ----------
    kind : str
        Kind of the bearing, e.g. "deep_groove".
    bore, outer, width : float
        Boundary dimensions [m].
    elements : int
        Number of rolling elements.
    element_diameter, pitch_diameter : float
        Diameter of an element, and of the circle through their centres [m].
    roller_length : float or None
        Effective length of a roller [m].
    contact_angle : float
        Contact angle [rad].
    stiffness_uncertainty : float
        Relative uncertainty of the stiffness under a load without clearance: the number of elements
        is uncertain by one to three, their sizes by about a tenth.

    Examples
    --------
    >>> import gearbow as gb
    >>> estimate = gb.RollingBearing("rotor", 0.0, "6308").estimate
    >>> estimate.elements, round(1e3 * estimate.element_diameter, 2)
    (8, 15.0)
    """

    kind: RollingKind
    bore: float
    outer: float
    width: float
    elements: int
    element_diameter: float
    pitch_diameter: float
    roller_length: float | None
    contact_angle: float
    stiffness_uncertainty: float


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
    designation : str, optional
        Designation of the series 60, 62, 63, N2, NU2 or 320 without suffixes, e.g. "6308". Its
        elements are estimated (`estimate`); fields that are given replace the estimate.
    kind : str, optional
        "deep_groove", "angular_contact", "cylindrical_roller", "tapered_roller" or "needle_cage":
        kind of a bearing whose elements are estimated from its `boundary`.
    boundary : (float, float, float), optional
        Bore, outside diameter and width [m]; of a needle cage the diameters of both raceways.
    elements : int, optional
        Number n of rolling elements, balls or rollers.
    element_diameter, pitch_diameter : float, optional
        Diameter d of an element, and D of the circle through their centres [m].
    clearance : float, optional
        Radial internal clearance during operation (ISO 5753) [m]: the distance that the shaft can
        move without load from one side to the opposite side, twice the radial gap. A negative value
        is a preload. With a designation or a boundary, None means 0, because fits and temperature
        use up most of the clearance.
    hertz_stiffness : float, optional
        Stiffness K of one element between both races [N/m^1.5] or, for a roller, [N/m^(10/9)]. None
        is that of the geometry for bearing steel (206 GPa, 0.3): Brewe and Hamrock for balls,
        Palmgren for rollers.
    contact : {"ball", "roller"}, optional
        Point contact, or line contact; None is that of the kind, or balls.
    contact_angle : float, optional
        Angle of the line of contact to the radial plane [rad]; None is that of the estimate, or 0.
        With five degrees of freedom, a positive angle carries a load of the shaft along +x, and a
        negative one a load along −x.
    degrees_of_freedom : {2, 5}
        Directions in which the rings move against each other: 2 are y and z; 5 are also the axis
        and the tilts about y and z, with forces and moments that depend on all five. The contact
        angle of a ball then follows from the load.
    axial_preload : float
        Axial force without displacement [N] of a bearing with five degrees of freedom, in the
        direction in which it carries; with the contact angle 0, along x, or along −x if it is
        negative. Two bearings with opposite contact angles and the same preload balance each
        other.
    damping : float, pair or 2×2 array
        Damping between shaft and bearing [N s/m], constant.
    phase : float
        Angle of the first element from y towards z at the shaft angle 0 [rad].
    inner_groove, outer_groove : float, optional
        Groove radius of a race over the ball diameter, above 0.5; None is 0.52.
    roller_length : float, optional
        Effective length of a roller [m]; a roller bearing needs it or `hertz_stiffness`.
    axial_stiffness : float
        Stiffness along the axis of the shaft [N/m]; it has no influence on the radial force. With
        five degrees of freedom, it and `tilting_stiffness` follow from the rolling elements.
    axial_damping : float
        Damping along the axis of the shaft [N s/m].
    tilting_stiffness, tilting_damping : float
        Those against rotations of the shaft about y and z [N m/rad, N m s/rad].
    dynamic_rating, static_rating : float, optional
        Basic load ratings C and C₀ [N] for `bearing_life`. None is that of a catalogue for deep
        groove ball bearings of the series 60, 62 and 63, else that of ISO 281 and ISO 76.
    support : str, Support or tuple of (str, float), optional
        What it stands on, as for `Bearing`.

    Notes
    -----
    The cage turns at (1 − γ)/2 times the speed of the shaft (`cage_order`), γ = (d/D) cos α, where
    the outer ring stands; n times this is the ball-pass order of the outer ring
    (`ball_pass_order`). Between two shafts, `shaft` carries the inner ring and the shaft of
    `support` the outer one, whose speed adds (1 + γ)/2 of itself to that of the cage. Slip and
    centrifugal forces are not modelled.

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
    designation: str | None = None
    _: KW_ONLY
    kind: RollingKind | None = None
    boundary: tuple[float, float, float] | None = None
    elements: int | None = None
    element_diameter: float | None = None
    pitch_diameter: float | None = None
    clearance: float | None = None
    hertz_stiffness: float | None = None
    contact: RollingContact | None = None
    contact_angle: float | None = None
    degrees_of_freedom: int = 2
    axial_preload: float = 0.0
    damping: "ArrayLike" = 0.0
    phase: float = 0.0
    inner_groove: float | None = None
    outer_groove: float | None = None
    roller_length: float | None = None
    axial_stiffness: float = 0.0
    axial_damping: float = 0.0
    tilting_stiffness: float = 0.0
    tilting_damping: float = 0.0
    dynamic_rating: float | None = None
    static_rating: float | None = None
    support: Base | None = None

    def _describe(self, path: str) -> dict[str, Plain]:
        if all(getattr(self, name) is None for name in ROLLING_FIELDS):
            raise SceneError(
                f'{path}: needs a designation such as "6308", or kind and boundary, or elements, '
                "element_diameter, pitch_diameter and clearance"
            )
        return super()._describe(path)

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
        """
        cage = None if cage_angle is None else number(cage_angle, "cage_angle")
        found = rolling_coefficients(self._describe("bearing"), (0.0, -number(load, "load")), cage)
        return RollingCoefficients(
            np.array(found["displacement"]),
            found["stiffness"],
            found["damping"],
            np.array(found["contact_forces"]),
        )

    def ring_coefficients(
        self, load: float, thrust: float = 0.0, tilt: "ArrayLike" = (0.0, 0.0)
    ) -> RingCoefficients:
        """Find the displacement under radial load and thrust, and the coupled stiffness there.

        The rings move radially and along the axis and tilt against each other. The contact angle of
        a ball follows from the load (Jones); that of a roller is fixed.

        Parameters
        ----------
        load : float
            Load of the shaft on the bearing along −z [N].
        thrust : float
            Load on the bearing along +x [N]; it presses elements with a positive contact angle.
        tilt : (float, float)
            Rotations of the shaft about y and z [rad], which the shaft prescribes.

        Returns
        -------
        RingCoefficients
            Displacement, force, stiffness, contact forces and contact angles.

        Raises
        ------
        ConvergenceError
            If the bearing does not carry the load, such as a thrust without a contact angle.

        References
        ----------
        T. A. Harris, *Rolling Bearing Analysis*, 4th ed., Wiley, 2001, chapter 7.

        Examples
        --------
        >>> import gearbow as gb
        >>> bearing = gb.RollingBearing.from_dimensions(
        ...     "rotor", 0.0, bore=0.09, outer=0.16, width=0.03, kind="angular_contact"
        ... )
        >>> found = bearing.ring_coefficients(0.0, thrust=17800.0)
        >>> float(found.contact_angles.round(2)[0])
        0.73
        """
        turned = matrix(tilt, "tilt")
        if turned.shape != (2,):
            raise SceneError(f"tilt: must be two rotations (B, G), got the shape {turned.shape}")
        forces = (number(thrust, "thrust"), 0.0, -number(load, "load"))
        rotations = (float(turned[0]), float(turned[1]))
        found = ring_coefficients(self._describe("bearing"), forces, rotations)
        return RingCoefficients(**{name: np.array(value) for name, value in found.items()})

    @classmethod
    def from_dimensions(
        cls,
        shaft: str,
        position: float,
        *,
        bore: float,
        outer: float,
        width: float,
        kind: RollingKind = "deep_groove",
        **options: Any,
    ) -> "RollingBearing":
        """Make a bearing from its boundary dimensions, with an estimate of its elements.

        Parameters
        ----------
        shaft : str
            Name of its shaft.
        position : float
            Position on the shaft, from its left end [m].
        bore, outer, width : float
            Bore, outside diameter and width [m].
        kind : str
            "deep_groove", "angular_contact", "cylindrical_roller", "tapered_roller" or
            "needle_cage".
        **options
            Other fields of `RollingBearing`, such as `clearance` and `support`.

        Returns
        -------
        RollingBearing
            The bearing; its `estimate` has number and size of the elements.

        Examples
        --------
        >>> import gearbow as gb
        >>> bearing = gb.RollingBearing.from_dimensions(
        ...     "rotor", 0.1, bore=0.045, outer=0.085, width=0.019, kind="cylindrical_roller"
        ... )
        >>> bearing.estimate.elements
        14
        """
        boundary = (real(bore, "bore"), real(outer, "outer"), real(width, "width"))
        return cls(shaft, position, kind=kind, boundary=boundary, **options)

    @property
    def estimate(self) -> RollingEstimate | None:
        """Elements estimated from a designation or from boundary dimensions.

        Fields that the bearing gives are left out; None without designation and boundary.
        """
        found = rolling_estimate(self._describe("bearing"))
        return None if found is None else RollingEstimate(**found)

    @property
    def stiffness_of_contact(self) -> float:
        """Stiffness K of one element between both races, given or that of the geometry.

        Its unit is N/m^1.5, or N/m^(10/9) for a roller.
        """
        found = rolling_coefficients(self._describe("bearing"), (0.0, 0.0), None)
        return found["hertz_stiffness"]

    @property
    def cage_order(self) -> float:
        """Speed of the cage over the speed of the shaft, where the outer ring stands.

        It is (1 − (d/D) cos α)/2.
        """
        found = rolling_coefficients(self._describe("bearing"), (0.0, 0.0), None)
        return found["cage_ratio"]

    @property
    def ball_pass_order(self) -> float:
        """Frequency at which elements pass a point of the outer ring, over that of the shaft.

        It is the number of elements times `cage_order`.
        """
        return self._count * self.cage_order

    @property
    def _count(self) -> int:
        """Number of elements, given or estimated."""
        found = rolling_coefficients(self._describe("bearing"), (0.0, 0.0), None)
        return found["elements"]

    @property
    def _angle(self) -> float:
        """Contact angle, given or estimated [rad]."""
        if self.contact_angle is not None:
            return self.contact_angle
        estimate = self.estimate
        return 0.0 if estimate is None else estimate.contact_angle

    @property
    def _rolls(self) -> bool:
        """Whether the elements are rollers."""
        estimate = self.estimate if self.contact is None else None
        length = None if estimate is None else estimate.roller_length
        return self.contact == "roller" or length is not None
