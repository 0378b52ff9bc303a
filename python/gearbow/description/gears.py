"""Disks, gears and the meshes between gears."""

import math
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any

from gearbow._types import Plain
from gearbow.description.part import Part
from gearbow.description.stiffness import Stiffness
from gearbow.description.teeth import MeshFriction, TipRelief, TransmissionError


class _Body(Part):
    """Base of disks and gears: a quantity with an angle in the shaft is complex."""

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> Any:
        given = dict(description)
        for key in ("unbalance", "runout"):
            if isinstance(given.get(key), (list, tuple)):
                given[key] = complex(*given[key])
        return cls(**given)


@dataclass(frozen=True)
class Disk(_Body):
    """A rigid disk on a shaft.

    Parameters
    ----------
    name : str
        Name, unique in the system.
    shaft : str
        Name of its shaft.
    position : float
        Position on the shaft, from its left end [m].
    mass : float
        Mass [kg].
    diametral_inertia : float
        Moment of inertia about a diameter [kg m²].
    polar_inertia : float
        Moment of inertia about the axis [kg m²].
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
class Gear(_Body):
    """A spur or helical gear: a rigid disk with involute teeth.

    Parameters
    ----------
    name : str
        Name, unique in the system.
    shaft : str
        Name of its shaft.
    position : float
        Position on the shaft, from its left end [m].
    teeth : int
        Number of teeth.
    module : float
        Module [m], of a helical gear the normal module; give either this or `base_radius`.
    base_radius : float
        Base radius [m].
    face_width : float
        Face width [m].
    pressure_angle : float
        Pressure angle of the basic rack [rad], which is that in the normal section.
    helix_angle : float
        Helix angle on the reference circle [rad], positive for a right-hand helix; gears in mesh
        have opposite hands of the same angle. A spur gear has 0.
    profile_shift : float
        Profile shift coefficient x; needs `module`. Meshes without `centre_distance` place the
        centres so that the flanks have no play.
    tip_radius : float
        Tip radius [m]; the default is that of full-depth teeth, r + m (1 + x), shortened where the
        profile shifts would leave a tip clearance below 0.1 module.
    mass : float
        Mass [kg]; the defaults of mass and inertias are those of a solid steel disk with the
        diameter of the pitch circle.
    diametral_inertia : float
        Moment of inertia about a diameter [kg m²].
    polar_inertia : float
        Moment of inertia about the axis [kg m²].
    unbalance : complex
        Mass times eccentricity [kg m]; its argument is the angle in the shaft.
    runout : complex
        Eccentricity of the base circle relative to the axis of the shaft [m]; its argument is the
        angle in the shaft.

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
    driver : str
        Name of the driving gear.
    driven : str
        Name of the driven gear.
    stiffness : float or Stiffness, optional
        Stiffness along the line of action, normal to the teeth: a constant [N/m], or a model. None
        is the mean stiffness of ISO 6336-1, `Stiffness.iso6336`, which needs the face width of both
        gears.
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
        Loss factor η of the stiffness, K(1 + iη sgn ω): structural damping of modes,
        Campbell diagrams, `frequency_response` and `synchronous`. Runs refuse it.
    centre_line_angle : float
        Angle of the line of centres, driver to driven, from y towards z [rad].
    centre_distance : float, optional
        Distance of the centres at rest [m]; None is the one without play, which follows from the
        profile shifts (ISO 21771). It is the sum of the reference pitch radii if they add up to 0.
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
    centre_distance: float | None = None
    backlash: float | None = None
    tip_relief: TipRelief | None = None
    error: TransmissionError | None = None
    friction: float | MeshFriction | None = None

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "Mesh":
        given = dict(description)
        if isinstance(given.get("stiffness"), Mapping):
            given["stiffness"] = Stiffness._from_description(given["stiffness"])
        if isinstance(given.get("friction"), Mapping):
            given["friction"] = MeshFriction._from_description(given["friction"])
        for key, kind in (("tip_relief", TipRelief), ("error", TransmissionError)):
            if key in given:
                given[key] = kind._from_description(given[key])
        return cls(**given)
