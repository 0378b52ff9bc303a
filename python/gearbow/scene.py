"""The parts of a rotor system: what a user describes, in SI units and radians.

Each part is an immutable record of what was given. It is checked, all of it, when a
`gearbow.RotorSystem` is made; what cannot be is a `gearbow.SceneError` that names the place.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any

from numpy.typing import ArrayLike

from gearbow._convert import real
from gearbow._describe import Part, expect, parts, place
from gearbow._types import At, Plain
from gearbow.bow import Bow
from gearbow.speed_table import SpeedTable
from gearbow.stiffness import Stiffness, TipRelief, TransmissionError

__all__ = ["STEEL", "Bearing", "Disk", "Gear", "Material", "Mesh", "Segment", "Shaft", "Torque"]


@dataclass(frozen=True)
class Material(Part):
    """Isotropic elastic material.

    Parameters
    ----------
    youngs_modulus : float
        Young's modulus E [Pa].
    density : float
        Density ρ [kg/m³].
    poisson_ratio : float, optional
        Poisson's ratio ν; either this or `shear_modulus`.
    shear_modulus : float, optional
        Shear modulus G [Pa]; E = 2G(1 + ν) gives the one from the other.

    Examples
    --------
    >>> import gearbow as gb
    >>> titanium = gb.Material(114e9, 4430.0, poisson_ratio=0.34)
    """

    youngs_modulus: float
    density: float
    poisson_ratio: float | None = None
    shear_modulus: float | None = None


#: Steel: 207 GPa, Poisson's ratio 0.3, 7850 kg/m³.
STEEL = Material(youngs_modulus=207e9, density=7850.0, poisson_ratio=0.3)


@dataclass(frozen=True)
class Segment(Part):
    """A part of a stepped shaft that has one cross section.

    Parameters
    ----------
    length : float
        Length [m].
    outer_diameter : float
        Outer diameter [m].
    inner_diameter : float
        Diameter of the bore [m].
    elements : int
        Least number of elements.

    Examples
    --------
    >>> import gearbow as gb
    >>> seat = gb.Segment(length=0.1, outer_diameter=0.06)
    """

    length: float
    outer_diameter: float
    inner_diameter: float = 0.0
    elements: int = 1


@dataclass(frozen=True)
class Shaft(Part):
    """A shaft of Timoshenko beam elements along x, uniform or stepped.

    Parameters
    ----------
    name : str
        Name, unlike every other name of the system.
    length : float
        Length of a uniform shaft [m].
    outer_diameter : float
        Outer diameter of a uniform shaft [m].
    inner_diameter : float
        Diameter of its bore [m].
    elements : int
        Least number of elements of a uniform shaft. Every position at which something stands
        becomes a node: the element there is split.
    segments : sequence of Segment
        The steps from x = 0, in place of the four above.
    material : Material
        What it is made of.
    shear : bool
        Whether it deforms in shear; False is the Rayleigh beam.
    bow : Bow, optional
        Its residual bow; None is straight.

    Notes
    -----
    Shape functions: Nelson, *A finite rotating shaft element using Timoshenko beam theory*, J.
    Mech. Des. 102 (1980); shear coefficient: Cowper (1966).

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1.5e-4)
    >>> shaft = gb.Shaft("input", length=0.5, outer_diameter=0.05, elements=8, bow=bow)
    >>> steps = [gb.Segment(0.1, 0.04), gb.Segment(0.4, 0.05, elements=4)]
    >>> stepped = gb.Shaft("output", segments=steps)
    """

    name: str
    _: KW_ONLY
    length: float | None = None
    outer_diameter: float | None = None
    inner_diameter: float = 0.0
    elements: int | None = None
    segments: Sequence[Segment] | None = None
    material: Material = STEEL
    shear: bool = True
    bow: Bow | None = None

    def _describe(self, path: str) -> dict[str, Plain]:
        shaft = self
        if self.bow is not None and expect(self.bow, Bow, f"{path}.bow").curve is not None:
            length = self._length(path)
            bow = None if length is None else self.bow._sampled(length, f"{path}.bow")
            shaft = replace(self, bow=bow)
        return super(Shaft, shaft)._describe(path)

    def _length(self, path: str) -> float | None:
        """Give the length along which a curve is read; None where the core will refuse it."""
        if self.segments is None:
            lengths = [] if self.length is None else [real(self.length, f"{path}.length")]
        else:
            segments = parts(self.segments, Segment, f"{path}.segments")
            lengths = [
                real(segment.length, f"{path}.segments[{i}].length")
                for i, segment in enumerate(segments)
            ]
        length = math.fsum(lengths)
        return length if 0.0 < length < math.inf else None

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "Shaft":
        given = dict(description)
        for key, kind in (("material", Material), ("bow", Bow)):
            if key in given:
                given[key] = kind._from_description(given[key])
        if "segments" in given:
            given["segments"] = tuple(Segment._from_description(s) for s in given["segments"])
        return cls(**given)


class _Body(Part):
    """What disks and gears have in common: what stands at an angle in the shaft is complex."""

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> Any:
        given = dict(description)
        for key in ("unbalance", "run_out"):
            if isinstance(given.get(key), (list, tuple)):
                given[key] = complex(*given[key])
        return cls(**given)


@dataclass(frozen=True)
class Disk(_Body):
    """A rigid disk on a shaft.

    Parameters
    ----------
    name : str
        Name, unlike every other name of the system.
    shaft : str
        Name of its shaft.
    position : float
        Where on the shaft, from its left end [m].
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
    """A spur gear: a rigid disk with involute teeth.

    Parameters
    ----------
    name : str
        Name, unlike every other name of the system.
    shaft : str
        Name of its shaft.
    position : float
        Where on the shaft, from its left end [m].
    teeth : int
        Number of teeth.
    module : float
        Module [m]; either this or `base_radius`.
    base_radius : float
        Base radius [m].
    face_width : float
        Face width [m].
    pressure_angle : float
        Pressure angle of the basic rack [rad].
    profile_shift : float
        Profile shift coefficient.
    tip_radius : float
        Tip radius [m]; that of full-depth teeth if left out.
    mass : float
        Mass [kg]; that of a solid steel disk on the pitch circle if left out, like the inertias.
    diametral_inertia : float
        Moment of inertia about a diameter [kg m²].
    polar_inertia : float
        Moment of inertia about the axis [kg m²].
    unbalance : complex
        Mass times eccentricity [kg m]; its argument is the angle in the shaft.
    run_out : complex
        How far the base circle stands off the axis of the shaft [m]; its argument is the angle in
        the shaft.

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
    profile_shift: float = 0.0
    tip_radius: float | None = None
    mass: float | None = None
    diametral_inertia: float | None = None
    polar_inertia: float | None = None
    unbalance: complex = 0.0
    run_out: complex = 0.0


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
        Stiffness along the line of action: a constant [N/m], or a model. None is the mean of ISO
        6336-1, `Stiffness.iso6336`, which needs the face width of both gears.
    damping_ratio : float
        Ratio ζ of the damping 2ζ√(k mₑ), with the mass mₑ that the two gears have on the line of
        action.
    damping : float, optional
        Damping along the line of action [N s/m], in place of the ratio.
    centre_line_angle : float
        Angle of the line from the driver's centre to the driven's, from y towards z [rad].
    centre_distance : float, optional
        Distance of the centres at rest [m]; None is the sum of the reference pitch radii.
    backlash : float, optional
        Clearance of the flanks along the line of action, for the centres at rest [m]; None is a
        mesh that never parts and pulls as well as it pushes.
    tip_relief : TipRelief, optional
        Relief of the tips of both gears; None is none.
    error : TransmissionError, optional
        Unloaded transmission error; None is none.

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
    centre_line_angle: float = 0.0
    centre_distance: float | None = None
    backlash: float | None = None
    tip_relief: TipRelief | None = None
    error: TransmissionError | None = None

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "Mesh":
        given = dict(description)
        if isinstance(given.get("stiffness"), Mapping):
            given["stiffness"] = Stiffness._from_description(given["stiffness"])
        for key, kind in (("tip_relief", TipRelief), ("error", TransmissionError)):
            if key in given:
                given[key] = kind._from_description(given[key])
        return cls(**given)


@dataclass(frozen=True)
class Bearing(Part):
    """A bearing between a shaft and the ground, linear in displacement and velocity.

    Parameters
    ----------
    shaft : str
        Name of its shaft.
    position : float
        Where on the shaft, from its left end [m].
    stiffness : float, pair, 2×2 array or SpeedTable
        Stiffness [N/m]: the same in every direction, (yy, zz), or [[yy, yz], [zy, zz]]; a table
        of one of these over the speed of the shaft.
    damping : float, pair, 2×2 array or SpeedTable
        Damping [N s/m], in the same forms.

    Examples
    --------
    >>> import gearbow as gb
    >>> bearing = gb.Bearing("input", 0.0, stiffness=(1e8, 2e8), damping=500.0)
    """

    shaft: str
    position: float
    _: KW_ONLY
    stiffness: ArrayLike | SpeedTable
    damping: ArrayLike | SpeedTable = 0.0

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "Bearing":
        given = dict(description)
        for key in ("stiffness", "damping"):
            if isinstance(given.get(key), Mapping):
                given[key] = SpeedTable._from_description(given[key])
        return cls(**given)


@dataclass(frozen=True)
class Torque(Part):
    """A constant torque on a shaft, positive about +x.

    Parameters
    ----------
    at : str or tuple of (str, float)
        A gear or disk by name, or (shaft, position [m]).
    value : float or "balance"
        The torque [N m]; "balance" is what `Torque.balance` says.

    Examples
    --------
    >>> import gearbow as gb
    >>> drive, load = gb.Torque("g1", 250.0), gb.Torque.balance("g4")
    """

    at: At
    value: float | str

    @classmethod
    def balance(cls, at: At) -> "Torque":
        """Apply the torque that keeps the train in balance against all the others.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        Torque
            The torque, whose value follows.
        """
        return cls(at, "balance")

    def _describe(self, path: str) -> dict[str, Plain]:
        at = place(self.at, f"{path}.at")
        if isinstance(self.value, str) and self.value == "balance":
            return {"at": at, "balance": True}
        return {"at": at, "value": real(self.value, f"{path}.value", 'a number [N m] or "balance"')}

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "Torque":
        at = description["at"]
        at = at if isinstance(at, str) else (at[0], at[1])
        return cls.balance(at) if description.get("balance") else cls(at, description["value"])
