"""Journal bearings and squeeze films: the oil film around a shaft or around a ring."""

import dataclasses
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import number, positive
from gearbow._core import film_coefficients, squeeze_force
from gearbow._extras import extra
from gearbow._shown import ReadOnly
from gearbow._types import Array, FilmModel, Profile, Reduction, Rupture
from gearbow.description.part import Part, freeze
from gearbow.description.places import Base, Support

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class PadFilm(ReadOnly):
    """Film of one pad at an equilibrium, along the middle of its length.

    Parameters
    ----------
    angles, thickness, pressure : ndarray, shape (n,)
        Angles from y towards z [rad], thickness of the film [m], pressure over that outside [Pa].
    pivot : float or None
        Angle of the pivot of a tilting pad [rad].

    Examples
    --------
    >>> import gearbow as gb
    >>> bearing = gb.JournalBearing(
    ...     "s", 0.0, diameter=0.1, length=0.05, clearance=1e-4, viscosity=0.02, profile="lemon"
    ... )
    >>> for pad in bearing.coefficients(load=5000.0, speed=300.0).pads:
    ...     print(f"{1e6 * pad.thickness.min():.0f} µm, {1e-6 * pad.pressure.max():.2f} MPa")
    45 µm, 0.74 MPa
    33 µm, 3.30 MPa
    """

    angles: Array
    thickness: Array
    pressure: Array
    pivot: float | None


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
    pads : tuple of PadFilm
        Film of each pad.
    clearance : float
        Radial clearance of the bearing or, with preload, of a pad [m].

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
    pads: tuple[PadFilm, ...]
    clearance: float

    def plot(self, *, ax: Any = None) -> "Figure":
        """Draw pads, journal and pressure across the shaft, and the film over the angle.

        Gaps are enlarged: the radius of the journal is four clearances.

        Parameters
        ----------
        ax : matplotlib Axes or sequence of Axes, optional
            Panels of your own: across the shaft, thickness, pressure. None makes a figure.

        Returns
        -------
        matplotlib.figure.Figure
            The figure.

        Examples
        --------
        >>> import gearbow as gb
        >>> bearing = gb.JournalBearing(
        ...     "s", 0.0, diameter=0.1, length=0.05, clearance=1e-4, viscosity=0.02, profile="lemon"
        ... )
        >>> figure = bearing.coefficients(load=5000.0, speed=300.0).plot()
        """
        with extra("plot"):
            from gearbow.plotting.analyses import film  # noqa: PLC0415
        place = self.eccentricity_ratio * self.clearance
        y, z = place * np.sin(self.attitude_angle), -place * np.cos(self.attitude_angle)
        return film(self.pads, (float(y), float(z)), self.clearance, ax=ax)


def _coefficients(
    bearing: "JournalBearing | TiltingPadBearing",
    load: float,
    speed: float,
    frequency: float | None = None,
) -> FilmCoefficients:
    """Find the equilibrium of a journal under a load along −z, and the coefficients there."""
    weight, spin = number(load, "load"), number(speed, "speed")
    vibration = None if frequency is None else number(frequency, "frequency")
    found = film_coefficients(bearing._describe("bearing"), (0.0, -weight), spin, vibration)
    y, z = found["displacement"]
    turns = spin / (2.0 * np.pi)
    plain = bearing._in_si("bearing")
    bearing_number = plain.viscosity * turns * plain.length * plain.diameter / abs(weight)
    return FilmCoefficients(
        stiffness=found["stiffness"],
        damping=found["damping"],
        eccentricity_ratio=float(np.hypot(y, z) / plain.clearance),
        attitude_angle=float(np.arctan2(y, -z)),
        sommerfeld=float(bearing_number * (plain.diameter / (2.0 * plain.clearance)) ** 2),
        pads=tuple(PadFilm(**pad) for pad in found["pads"]),
        clearance=float(plain.clearance),
    )


@dataclass(frozen=True)
class Pad(Part):
    """A pad of fixed geometry of a `JournalBearing`.

    Parameters
    ----------
    begin, extent : float
        Angle at which its arc begins, from y towards z, and its extent, 0.1 to 6.2 or 2π [rad].
    length : float, optional
        Axial length [m]. None is that of the bearing.
    clearance : float, optional
        Difference of the radii of the pad and the journal [m]. None is that of the bearing.
    preload : float
        Preload m = 1 − (clearance of the bearing)/(clearance of the pad): the centre of the pad is
        m times its clearance away from the centre of the bearing.
    offset : float
        Place closest to the centred journal, as a part of the extent in the direction of rotation.

    Examples
    --------
    >>> import gearbow as gb
    >>> pads = [gb.Pad(begin, 1.9, preload=0.4, offset=0.6) for begin in (0.2, 2.3, 4.4)]
    >>> bearing = gb.JournalBearing(
    ...     "rotor", 0.0, diameter=0.1, length=0.05, clearance=1e-4, viscosity=0.02, pads=pads
    ... )
    """

    begin: float
    extent: float
    _: KW_ONLY
    length: float | None = None
    clearance: float | None = None
    preload: float = 0.0
    offset: float = 0.5


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
    diameter, length : float
        Diameter D of the journal and length L of the bearing [m].
    clearance : float
        Radial clearance c: difference of the radii of bearing and journal [m].
    viscosity : float
        Dynamic viscosity μ of the oil [Pa s].
    film : {"short", "finite"}, optional
        "short" is the solution for L ≪ D in closed form (Ocvirk), good up to L/D of about 0.5, of a
        plain bearing. "finite" interpolates a table of solutions of Reynolds' equation for each
        pad, for L/D from 0.1 to 2. The table is computed at the first use and kept on disk. None
        is "short" for a plain bearing and "finite" for other profiles.
    grooves : array_like, shape (k, 2), optional
        Axial grooves of a finite film, without pressure: angle of the middle, and extent [rad].
    profile : {"plain", "two axial grooves", "lemon", "offset", "three-lobe", "four-lobe"}, optional
        Profile of the bore. Its grooves of 20° are at y and −y; a bearing with three lobes has the
        middle of one at −z, one with four lobes a groove there. The halves of "offset" are
        displaced along their joint, so that the film narrows in the direction of rotation. The
        clearance is that of a lobe, from which the preload takes its part.
    preload : float, optional
        Preload m = 1 − (clearance of the bearing)/(clearance of a lobe), by default 0.5: the centre
        of each lobe is m times the clearance away from the centre of the bearing.
    offset : float, optional
        Place of a lobe that is closest to the centred journal, as a part of the extent of the lobe
        in the direction of rotation, by default 0.5, and the middle of the groove for "offset".
    orientation : float, optional
        Angle by which profile or grooves are turned, from y towards z [rad].
    pads : sequence of Pad, optional
        The pads of a bearing of any other geometry, instead of a profile.
    rupture : {"reynolds", "gumbel"}, optional
        Where a finite film ruptures: where pressure and its gradient vanish (Reynolds, the
        default), or where the pressure of a film without rupture is negative (Gümbel).
    axial_stiffness, axial_damping : float
        Those of a thrust bearing along the axis of the shaft [N/m, N s/m].
    support : str, Support or tuple of (str, float), optional
        What it stands on, as for `Bearing`.

    Notes
    -----
    Between two shafts, the film depends on the sum of their speeds, and carries nothing where they
    counter-rotate at one speed. The film is isoviscous, laminar and incompressible, and the journal
    stays parallel to the bearing. The pressure is never negative: the short film ruptures where it
    is not squeezed (Gümbel), the finite film where pressure and its gradient vanish (Reynolds).
    The force is the sum of those of the pads, each in the film between its own arc and the journal.

    Tables of pads are kept in the folder ``GEARBOW_CACHE``, by default ``gearbow`` in the user's
    folder of cached files (``~/.cache``, ``~/Library/Caches`` or ``%LOCALAPPDATA%``).

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

    The same journal in a lemon bore:

    >>> lemon = gb.JournalBearing(
    ...     "rotor", 0.0, diameter=0.1, length=0.03, clearance=1e-4, viscosity=0.1, profile="lemon"
    ... )
    >>> print(f"{lemon.coefficients(load=525.0, speed=157.08).eccentricity_ratio:.2f}")
    0.10
    """

    shaft: str
    position: float
    _: KW_ONLY
    diameter: float
    length: float
    clearance: float
    viscosity: float
    film: FilmModel | None = None
    grooves: "ArrayLike | None" = None
    profile: Profile | None = None
    preload: float | None = None
    offset: float | None = None
    orientation: float | None = None
    pads: Sequence[Pad] | None = None
    rupture: Rupture | None = None
    axial_stiffness: float = 0.0
    axial_damping: float = 0.0
    support: Base | None = None

    def __post_init__(self) -> None:
        freeze(self, "grooves")
        if isinstance(self.pads, list):
            object.__setattr__(self, "pads", tuple(self.pads))

    def coefficients(self, load: float, speed: float) -> FilmCoefficients:
        """Find the equilibrium under a static load, and stiffness and damping there.

        Parameters
        ----------
        load, speed : float
            Load along −z [N], and speed of the shaft about +x [rad/s], positive.

        Returns
        -------
        FilmCoefficients
            Stiffness, damping, eccentricity ratio and attitude angle; z is along the load.

        Raises
        ------
        SceneError
            If an entry of the bearing is impossible, or the journal touches the bearing.
        """
        return _coefficients(self, load, speed)


@dataclass(frozen=True)
class TiltingPadBearing(Part):
    """A journal bearing with equal pads that tilt about pivots.

    It is one of the `bearings` of a `gearbow.RotorSystem`. The tilts of its pads, and their motions
    along flexible pivots, are coordinates of the system in runs and in linear analyses, so that
    every mode has them at its own frequency. With ``reduced="synchronous"`` linear analyses have
    stiffness and damping without these coordinates instead, for vibrations at the speed of the
    shaft; runs refuse them.

    Parameters
    ----------
    shaft : str
        Name of its shaft.
    position : float
        Position on the shaft, from its left end [m].
    diameter, length : float
        Diameter D of the journal and length L of the pads [m].
    clearance : float
        Difference of the radii of a pad and the journal [m].
    viscosity : float
        Dynamic viscosity μ of the oil [Pa s].
    pad_count : int
        Number of pads, 3 to 12.
    pad_extent : float, optional
        Extent of the arc of a pad [rad]. None is 5/6 of its share of the turn, 60° with five pads.
    preload : float, optional
        Preload m = 1 − (clearance at the pivots)/(clearance of a pad), by default 0.5. A pad
        without preload may carry nothing: ``reduced="synchronous"`` leaves such pads out.
    offset : float, optional
        Place of the pivot, as a part of the extent in the direction of rotation, by default 0.5.
    orientation : float, optional
        Angle of the first pivot, from y towards z [rad]. None puts the load between two pads.
    pad_inertia : float, optional
        Moment of inertia of a pad about its pivot [kg m²]; reduced coefficients need none.
    pivot_stiffness : float, optional
        Stiffness of a pivot along its radius [N/m]. None is a rigid pivot.
    pad_mass : float, optional
        Mass of a pad on a flexible pivot [kg].
    reduced : {"synchronous", "own"}, optional
        "synchronous" eliminates the motions of the pads at the speed of the shaft. None and "own"
        keep them as coordinates, which gives every mode the coefficients at its own frequency.
    rupture : {"reynolds", "gumbel"}, optional
        Where the films rupture, as for `JournalBearing`.
    axial_stiffness, axial_damping : float
        Those of a thrust bearing along the axis of the shaft [N/m, N s/m].
    support : str, Support or tuple of (str, float), optional
        What it stands on, as for `Bearing`.

    Notes
    -----
    Friction of the pivots and the weight of the pads are neglected. A pad that turns about its
    pivot moves the centre of its arc by the radius of the journal times the angle.

    References
    ----------
    J. W. Lund, *Spring and damping coefficients for the tilting-pad journal bearing*, ASLE
    Transactions 7, 1964.

    Examples
    --------
    >>> import gearbow as gb
    >>> bearing = gb.TiltingPadBearing(
    ...     "pinion", 0.1, diameter=0.1, length=0.05, clearance=1.5e-4, viscosity=0.02,
    ...     pad_count=5, preload=0.3, pad_inertia=1e-4)
    >>> film = bearing.coefficients(load=3000.0, speed=1000.0)
    >>> print(f"{film.stiffness[1, 1]:.2e} N/m, cross-coupling {film.stiffness[0, 1]:.1e} N/m")
    7.07e+07 N/m, cross-coupling -7.6e+05 N/m
    """

    shaft: str
    position: float
    _: KW_ONLY
    diameter: float
    length: float
    clearance: float
    viscosity: float
    pad_count: int
    pad_extent: float | None = None
    preload: float | None = None
    offset: float | None = None
    orientation: float | None = None
    pad_inertia: float | None = None
    pivot_stiffness: float | None = None
    pad_mass: float | None = None
    reduced: Reduction | None = None
    rupture: Rupture | None = None
    axial_stiffness: float = 0.0
    axial_damping: float = 0.0
    support: Base | None = None

    def coefficients(
        self, load: float, speed: float, frequency: float | None = None
    ) -> FilmCoefficients:
        """Find the equilibrium under a static load, and stiffness and damping there.

        Parameters
        ----------
        load, speed : float
            Load along −z [N], and speed of the shaft about +x [rad/s], positive.
        frequency : float, optional
            Frequency at which the pads are eliminated [rad/s]. None is that of the rotation.

        Returns
        -------
        FilmCoefficients
            Stiffness, damping, eccentricity ratio (in clearances of a pad) and attitude angle. y is
            across the load, z along it.

        Raises
        ------
        SceneError
            If an entry of the bearing is impossible, or the journal touches a pad.
        """
        # Alone, a bearing has no coordinates: a pad may be without inertia or load.
        alone = dataclasses.replace(self, reduced="synchronous")
        return _coefficients(alone, load, speed, frequency)


@dataclass(frozen=True, eq=False)
class SqueezeCoefficients(ReadOnly):
    """Stiffness and damping of a squeeze film for a circular orbit about its centre.

    Parameters
    ----------
    stiffness : float
        Force towards the centre over the radius of the orbit [N/m], without the centring spring.
    damping : float
        Force against the motion over the velocity [N s/m].

    Examples
    --------
    >>> import gearbow as gb
    >>> film = gb.SqueezeFilm(diameter=0.1, length=0.025, clearance=1e-4, viscosity=0.02)
    >>> print(f"{film.coefficients(0.4).damping:.1f} N s/m")
    31880.2 N s/m
    """

    stiffness: float
    damping: float


@dataclass(frozen=True)
class SqueezeFilm(Support):
    """A squeeze film damper below a bearing: a ring that does not turn, in an oil film.

    ``support=gb.SqueezeFilm(...)`` of a bearing puts its outer ring on the film, and the film on
    the ground or, with `support`, on a housing. Several bearings share one that is listed by its
    name in `supports`. The film carries no static load: a centring spring does, `stiffness`.

    Parameters
    ----------
    name : str, optional
        Name, as that of a `Support`.
    mass : float
        Mass of the ring with what moves with it [kg]; a system needs a positive one.
    stiffness : float, pair or 2×2 array
        Stiffness of the centring spring [N/m].
    damping : float, pair or 2×2 array
        Damping beside that of the film [N s/m].
    axial_stiffness : float, optional
        Stiffness to the ground or housing along the axis [N/m], as that of a `Support`.
    axial_damping : float
        Damping to the ground or housing along the axis [N s/m].
    loss_factor : float
        Loss factor η of the centring spring.
    support : str or (str, str), optional
        Name of the housing below the film, or (elastic housing, interface). None: the ground.
    diameter, length, clearance : float
        Diameter of the ring, length of the film and radial clearance [m].
    viscosity : float
        Dynamic viscosity μ of the oil [Pa s].
    film : {"short", "finite"}, optional
        Model of the film, as for `JournalBearing`; short by default, which has open ends.
    ruptures : bool
        Whether the film ruptures where it is stretched (π film) or not (2π film, under pressure).

    Notes
    -----
    Linear analyses use the damping of small vibrations about the static position. That of a film
    that ruptures is half that of one that does not, because a small vibration squeezes one side and
    then the other. Runs have the nonlinear force of the film.

    References
    ----------
    E. J. Gunter, L. E. Barrett and P. E. Allaire, *Design of nonlinear squeeze-film dampers for
    aircraft engines*, J. Lubr. Technol. 99, 1977.

    Examples
    --------
    >>> import gearbow as gb
    >>> damper = gb.SqueezeFilm(
    ...     mass=2.0, stiffness=1e7, diameter=0.1, length=0.025, clearance=1e-4, viscosity=0.02)
    >>> print(f"{damper.coefficients(0.4).damping:.1f}")
    31880.2
    >>> bearing = gb.Bearing("rotor", 0.0, stiffness=2e8, support=damper)
    """

    _: KW_ONLY
    mass: float = 0.0
    stiffness: "ArrayLike" = 0.0
    diameter: float = 0.0
    length: float = 0.0
    clearance: float = 0.0
    viscosity: float = 0.0
    film: FilmModel | None = None
    ruptures: bool = True

    def coefficients(
        self, eccentricity_ratio: float, frequency: float = 1.0
    ) -> SqueezeCoefficients:
        """Find stiffness and damping for a circular orbit about the centre.

        Parameters
        ----------
        eccentricity_ratio : float
            Radius of the orbit over the clearance, between 0 and 1.
        frequency : float
            Frequency of the orbit [rad/s], to which the stiffness is proportional.

        Returns
        -------
        SqueezeCoefficients
            Stiffness and damping.
        """
        ratio = positive(eccentricity_ratio, "eccentricity_ratio", 1.0)
        whirl = positive(frequency, "frequency")
        plain = self._in_si("support")
        given = {"mass": 0.0, "stiffness": 0.0, **self._describe("support")}
        radius = ratio * plain.clearance
        along, across = squeeze_force(given, (radius, 0.0), (0.0, whirl * radius))
        return SqueezeCoefficients(stiffness=along / radius, damping=across / (whirl * radius))
