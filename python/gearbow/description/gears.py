"""Gears, disks and meshes, and the errors, relief and friction of their teeth."""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

from gearbow._types import At
from gearbow.description.part import Part, freeze
from gearbow.description.stiffness import Stiffness

#: (amplitude [m], phase [rad]) of the orders 1, 2, ….
Harmonics = Sequence[Sequence[float]]


@dataclass(frozen=True)
class TipRelief(Part):
    """Tip relief of both gears: material removed from the flanks at the ends of the path.

    Parameters
    ----------
    amount, length : float
        Relief at the end of the path of contact, and its length along the path from either end [m].
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
        Values at 0, 1/n, 2/n, … of the mesh cycle [m], at least three, of a periodic cubic spline.

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
        Dynamic viscosity of the oil at its temperature [Pa s]; with `roughness`, no `coefficient`.
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


@dataclass(frozen=True)
class Disk(Part):
    """A rigid disk on a shaft.

    Parameters
    ----------
    name, shaft : str
        Name, unique in the system, and name of its shaft.
    position : float
        Position on the shaft, from its left end [m].
    mass : float
        Mass [kg].
    diametral_inertia, polar_inertia : float
        Moments of inertia about a diameter and about the axis [kg m²].
    unbalance : complex
        Mass times eccentricity [kg m]; its argument is the angle in the shaft.

    Examples
    --------
    >>> import gearbow as gb
    >>> wheel = gb.Disk("wheel", "rotor", 0.5, 20.0, 0.1, 0.2, unbalance=1e-4j)
    """

    name: str
    shaft: str
    position: float
    mass: float
    diametral_inertia: float
    polar_inertia: float
    unbalance: complex = 0.0


@dataclass(frozen=True)
class Gear(Part):
    """A spur or helical gear: a rigid disk with involute teeth.

    Parameters
    ----------
    name, shaft : str
        Name, unique in the system, and name of its shaft.
    position : float
        Position on the shaft, from its left end [m].
    teeth : int
        Number of teeth.
    internal : bool
        Whether the teeth point inwards: a ring gear, which turns like its pinion.
    module : float
        Module [m], of a helical gear the normal module; give either this or `base_radius`.
    base_radius : float
        Base radius [m].
    face_width : float
        Face width [m].
    pressure_angle : float
        Pressure angle of the basic rack [rad], which is that in the normal section.
    helix_angle : float
        Helix angle on the reference circle [rad], positive for a right hand; gears in mesh have
        opposite hands, an internal gear that of its pinion. A spur gear has 0.
    profile_shift : float
        Profile shift coefficient x; needs `module`. Meshes without `centre_distance` place the
        centres so that the flanks have no play. That of an internal gear has the sign of ISO 21771:
        a positive one moves the tips inwards.
    tip_radius : float
        Tip radius [m]; the default is that of full-depth teeth, r + m (1 + x) or, of an internal
        gear, r − m (1 + x), shortened where the profile shifts would leave a tip clearance below
        0.1 module, or where an internal gear would reach beyond the base circle of its pinion.
    mass : float
        Mass [kg]; the defaults of mass and inertias are those of a solid steel disk with the
        diameter of the pitch circle, of an internal gear those of a steel ring from the pitch
        circle to 3.5 modules outside the root circle.
    diametral_inertia, polar_inertia : float
        Moments of inertia about a diameter and about the axis [kg m²].
    unbalance : complex
        Mass times eccentricity [kg m]; its argument is the angle in the shaft.
    runout : complex
        Eccentricity of the base circle to the axis [m]; its argument is the angle in the shaft.

    Examples
    --------
    >>> import gearbow as gb
    >>> pinion = gb.Gear("g1", shaft="input", position=0.25, teeth=25, module=3e-3, face_width=0.03)
    """

    name: str
    shaft: str
    position: float
    teeth: int
    _: KW_ONLY
    internal: bool = False
    module: float | None = None
    base_radius: float | None = None
    face_width: float | None = None
    pressure_angle: float = math.radians(20.0)
    helix_angle: float = 0.0
    profile_shift: float = 0.0
    tip_radius: float | None = None
    mass: float | None = None
    diametral_inertia: float | None = None
    polar_inertia: float | None = None
    unbalance: complex = 0.0
    runout: complex = 0.0


@dataclass(frozen=True)
class Mesh(Part):
    """Two gears in mesh, on parallel shafts.

    Parameters
    ----------
    driver, driven : str
        Names of the driving and the driven gear.
    stiffness : float or Stiffness, optional
        Stiffness along the line of action, normal to the teeth: a constant [N/m], or a model. None
        is `Stiffness.iso6336`, the mean of ISO 6336-1, with the face width of both gears.
    damping_ratio : float
        Damping ratio ζ of the damping 2ζ√(k mₑ), with the equivalent mass mₑ of the two gears on
        the line of action, all in the transverse section.
    damping : float, optional
        Damping along the line of action, normal to the teeth [N s/m], instead of the ratio.
    damping_in_separation : bool
        Whether the damping acts while the flanks are separated as well, as that of an oil film. The
        mesh force can then be tensile. False: only flanks in contact are damped. Without backlash
        or without damping, both values give the same motion.
    loss_factor : float
        Loss factor η of the stiffness, as for `Bearing`.
    centre_line_angle : float
        Angle of the line of centres, driver to driven, from y towards z [rad].
    tooth_angle : float
        Angle of a tooth of the driver at the time zero [rad]: that of its drive flank on the base
        circle. It sets the phase of the mesh cycle against that of other meshes.
    centre_distance : float, optional
        Distance of the centres at rest [m]; None is the one without play, which follows from the
        profile shifts (ISO 21771). It is the sum of the reference pitch radii if they add up to 0,
        with an internal gear their difference.
    backlash : float, optional
        Clearance of the flanks along the line of action, normal to the teeth, for the centres at
        rest [m]. None is a mesh that never separates: its force can be tensile.
    tip_relief : TipRelief, optional
        Relief of the tips of both gears; None is no relief.
    error : TransmissionError, optional
        Unloaded transmission error; None is no error.
    friction : float or MeshFriction, optional
        Sliding friction between the flanks: a coefficient, or a `MeshFriction`; None is no
        friction. It acts in runs and steady states, and `RotorSystem.efficiency` gives its loss.
        Modes, responses to harmonic forces and the static equilibrium do not contain it.
    carrier : str or tuple of (str, float), optional
        What carries the planet of this mesh, if it turns: a disk or gear by name, or (shaft,
        position [m]). Angles of both gears are then relative to it. Where the planet has no
        bearings on the carrier, the mesh acts in torsion only. `PlanetaryStage` sets it. None: the
        axes of both gears are fixed.

    Examples
    --------
    >>> import gearbow as gb
    >>> mesh = gb.Mesh("g1", "g2", stiffness=2e8, damping_ratio=0.05)
    >>> pairs = gb.Stiffness.parabolic(2e8, engagement=0.2)
    >>> mesh = gb.Mesh("g1", "g2", stiffness=pairs, damping_ratio=0.05, backlash=1e-4)
    """

    driver: str
    driven: str
    _: KW_ONLY
    stiffness: float | Stiffness | None = None
    damping_ratio: float = 0.0
    damping: float | None = None
    damping_in_separation: bool = False
    loss_factor: float = 0.0
    centre_line_angle: float = 0.0
    tooth_angle: float = 0.0
    centre_distance: float | None = None
    backlash: float | None = None
    tip_relief: TipRelief | None = None
    error: TransmissionError | None = None
    friction: float | MeshFriction | None = None
    carrier: At | None = None
