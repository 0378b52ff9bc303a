"""Planetary stages: planets on pins of a carrier, as shafts, gears, meshes and bearings.

A stage adds a short shaft for every planet, the planet on it, its two meshes and its bearings. The
carrier stands still (star gear): it is the ground, or a housing. Or it turns, as a part of a shaft.
"""

import cmath
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from typing import Any

import numpy as np

from gearbow._convert import complex_number, real, shown, whole
from gearbow._types import At, MeshGeometry
from gearbow.description.gears import Disk, Gear, Mesh
from gearbow.description.journal import JournalBearing
from gearbow.description.loads import AnyBearing, Bearing, Drive
from gearbow.description.part import Part, freeze, parts
from gearbow.description.places import place
from gearbow.description.rolling import RollingBearing
from gearbow.description.shafts import Material, Shaft
from gearbow.errors import SceneError

#: Largest distance of (z_s + z_r) ψ/2π from a whole number at which teeth fit, in pitches.
_FITTING = 1e-6
#: Default material of pins: the planet has all the mass. A shaft of this density is massless.
_MASSLESS = Material(youngs_modulus=207e9, density=1.0, poisson_ratio=0.3)
#: Diameter of the shaft of a planet or of a ring at rest over that of the gear, in torsion: nothing
#: loads this shaft, and a quarter of a percent of the mass is its own.
_THIN = 0.05


@dataclass(frozen=True)
class RingGear(Part):
    """The ring gear of a planetary stage: an internal gear and what it stands on.

    Parameters
    ----------
    name : str
        Name of the gear, unique in the system.
    teeth : int
        Number of teeth.
    support : str, optional
        Name of the shaft that carries it; None is the ground, which needs a carrier that turns.
    position : float
        Position on the shaft, from its left end [m].
    module : float
        Module [m], of a helical gear the normal module.
    face_width : float, optional
        Face width [m].
    pressure_angle : float
        Pressure angle of the basic rack [rad].
    helix_angle : float
        Helix angle [rad]; an internal gear has the hand of its pinion.
    profile_shift : float
        Profile shift coefficient; a positive one moves the tips inwards.
    tip_radius : float, optional
        Tip radius [m]; None is that of full-depth teeth, as in `Gear`.
    mass : float, optional
        Mass [kg]; None is that of a steel ring, as in `Gear`.
    diametral_inertia, polar_inertia : float, optional
        Moments of inertia about a diameter and about the axis [kg m²].
    rotational_stiffness : float, optional
        Stiffness with which the ground holds the ring against rotation [N m/rad]; a ring on the
        ground needs it. For a bolted ring, 1e9 N/m times the square of its pitch radius is usual.
    rotational_damping : float
        Damping of this support [N m s/rad].
    lateral_stiffness : float, optional
        Stiffness with which the ground holds the ring along y and z [N/m], where planets move
        laterally on a carrier that turns; None holds only the rotation.
    lateral_damping : float
        Damping of this support along y and z [N s/m].
    axial_stiffness : float
        Its stiffness along the axis [N/m], which helical teeth need.
    tilting_stiffness : float, optional
        Its stiffness against tilting [N m/rad]. None is that of a rim which springs hold all around
        with the lateral stiffness: half of it times the square of the pitch radius.

    Examples
    --------
    A ring on the output shaft, and one in the housing:

    >>> import gearbow as gb
    >>> ring = gb.RingGear("ring", 72, support="output", position=0.1, module=3e-3, face_width=0.03)
    >>> ring = gb.RingGear("ring", 72, module=3e-3, face_width=0.03, rotational_stiffness=1e7)
    """

    name: str
    teeth: int
    support: str | None = None
    _: KW_ONLY
    position: float = 0.0
    module: float
    face_width: float | None = None
    pressure_angle: float = math.radians(20.0)
    helix_angle: float = 0.0
    profile_shift: float = 0.0
    tip_radius: float | None = None
    mass: float | None = None
    diametral_inertia: float | None = None
    polar_inertia: float | None = None
    rotational_stiffness: float | None = None
    rotational_damping: float = 0.0
    lateral_stiffness: float | None = None
    lateral_damping: float = 0.0
    axial_stiffness: float = 0.0
    tilting_stiffness: float | None = None

    def _on_ground(self, path: str) -> tuple[Shaft, Drive, Bearing | None]:
        """Give the shaft of a ring on the ground, which does not turn, and what holds it."""
        whole(self.teeth, f"{path}.teeth")
        if self.rotational_stiffness is None:
            raise SceneError(
                f"{path}.rotational_stiffness: a ring on the ground needs the stiffness that holds "
                "it against rotation [N m/rad]; for a bolted ring, 1e9 N/m times the square of its "
                "pitch radius is usual"
            )
        diameter = self.module * self.teeth / math.cos(self.helix_angle)
        shaft = Shaft(
            f"{self.name} mount",
            length=diameter if self.face_width is None else self.face_width,
            outer_diameter=_THIN * diameter,
            speed_ratio=0.0,
        )
        drive = Drive(self.name, self.rotational_stiffness, self.rotational_damping)
        if self.lateral_stiffness is None:
            return shaft, drive, None
        lateral = real(self.lateral_stiffness, f"{path}.lateral_stiffness")
        tilting = self.tilting_stiffness
        holding = Bearing(
            shaft.name,
            0.0,
            stiffness=lateral,
            damping=self.lateral_damping,
            axial_stiffness=self.axial_stiffness,
            tilting_stiffness=lateral * diameter**2 / 8.0 if tilting is None else tilting,
        )
        return shaft, drive, holding

    def _gear(self, shafts: Sequence[str], path: str) -> Gear:
        whole(self.teeth, f"{path}.teeth")
        for name, default in _UNSUPPORTED.items():
            if getattr(self, name) != default and self.support in shafts:
                raise SceneError(
                    f"{path}.{name}: is for a ring on the ground, and this one stands on "
                    f'"{self.support}"; leave it out, or give no support'
                )
        if self.support not in shafts:
            base = "the ground" if self.support is None else shown(self.support)
            raise SceneError(
                f"{path}.support: a ring on {base} does not turn, so that the carrier must: give "
                "the carrier of the stage as a disk or (shaft, position) and leave the ring on the "
                'ground (None), or give the name of a shaft for the ring, for example "'
                + (shafts[-1] if shafts else "output")
                + '"'
            )
        own = {name: getattr(self, name) for name in _SHARED}
        return Gear(**own, shaft=str(self.support), internal=True)


#: Fields of the support of a ring on the ground, with their defaults.
_UNSUPPORTED: dict[str, Any] = {
    field.name: field.default
    for field in fields(RingGear)
    if field.name.endswith(("_stiffness", "_damping"))
}
#: Fields that a ring gear has in common with a gear.
_SHARED = {field.name for field in fields(Gear)} & {field.name for field in fields(RingGear)}
#: Lists of a system to which a stage adds parts.
ADDED = ("shafts", "gears", "meshes", "bearings", "drives")


@dataclass(frozen=True)
class PlanetaryStage(Part):
    """A planetary stage: a sun, planets on pins of a carrier, and a ring.

    `RotorSystem(planetary_stages=...)` adds to its parts, for every planet with the number i from
    1: the gear "planet i", named after `planet`, its shaft "planet pin i", its meshes with sun and
    ring, and its bearings. Results, files and analyses know them as all others. The speeds obey
    z_sun (Ω_sun − Ω_carrier) = −z_ring (Ω_ring − Ω_carrier) (Willis).

    The carrier may turn. Planets without bearings are then on rigid pins, and the stage couples
    sun, ring and carrier in torsion; a disk "planet masses", named after `planet`, adds the inertia
    of the planets about the axis of the stage to the carrier. A ring on the ground gets a shaft at
    rest, "ring mount", named after the ring, and a drive that holds it. Planets with bearings move
    laterally in the frame of the carrier, in which they are computed; sun, ring and carrier then
    need bearings, too, or a ring on the ground a `lateral_stiffness`.

    Parameters
    ----------
    sun : str
        Name of the sun, a gear of the system.
    ring : str or RingGear
        The ring: the name of an internal gear of the system, or a ring gear on a shaft.
    planets : int or sequence of float
        Number of planets at equal angles, or their angles from y towards z [rad].
    carrier : str or tuple of (str, float), optional
        What carries the pins: a housing by name, or None for the ground (star gear). A carrier that
        turns is a disk or gear by name, or (shaft, position [m]).
    planet : Gear
        One planet. Its position is that on its shaft, the name of which is ignored.
    bearing : Bearing, JournalBearing, RollingBearing or sequence of them
        Bearings of one planet on its pin. Positions are those on the shaft of the planet; the name
        of the shaft is ignored. Two bearings, or one with a tilting stiffness, hold a planet
        against tilting. With a carrier that turns, none is a rigid pin, and others must be linear.
    pin : Shaft, optional
        Shaft of one planet, after whose name those of all planets are named. None is a massless
        steel shaft "planet pin" with the length of the face width and half of the diameter of the
        planet.
    sun_mesh, ring_mesh : Mesh, optional
        Meshes of one planet, with the names of sun, planet and ring; their driver decides on the
        direction of the power relative to the carrier. None: the sun drives the planets, and these
        the ring. Where the carrier drives the sun, as in a wind turbine, the ring drives the
        planets, and these the sun. Line of centres and phase of the teeth are set by the stage.
    centre_distance : float, optional
        Distance of the planets from the axis [m]. None is that without play, equal in both meshes.
    pin_errors : sequence of complex, optional
        Position error of the pin of each planet [m]: the real part outwards, the imaginary part
        along the circle of the pins, in the direction of positive rotation. It is the
        `Bearing.misalignment` of all bearings of the planet, which must be `gearbow.Bearing`. None
        is no error.

    Raises
    ------
    SceneError
        If the planets do not fit between sun and ring at these angles, or overlap.

    Examples
    --------
    >>> import gearbow as gb
    >>> tooth = {"module": 2e-3, "face_width": 0.02}
    >>> stage = gb.PlanetaryStage(
    ...     sun="sun",
    ...     ring=gb.RingGear("ring", 72, "output", position=0.05, **tooth),
    ...     planets=3,
    ...     planet=gb.Gear("planet", "pin", 0.01, teeth=24, **tooth),
    ...     bearing=[gb.Bearing("pin", x, stiffness=1e8, damping=500.0) for x in (0.0, 0.02)],
    ... )
    >>> system = gb.RotorSystem(
    ...     shafts=[gb.Shaft(n, length=0.1, outer_diameter=0.02) for n in ("input", "output")],
    ...     gears=[gb.Gear("sun", "input", 0.05, teeth=24, **tooth)],
    ...     bearings=[
    ...         gb.Bearing(n, x, stiffness=1e8, damping=500.0)
    ...         for n in ("input", "output")
    ...         for x in (0.0, 0.1)
    ...     ],
    ...     planetary_stages=[stage],
    ... )
    >>> print(system.speed_ratios)
    [ 1.         -0.33333333 -1.         -1.         -1.        ]

    The same with a ring at rest and a carrier that turns, 1/(1 + 72/24) of the speed of the sun:

    >>> stage = gb.PlanetaryStage(
    ...     sun="sun",
    ...     ring=gb.RingGear("ring", 72, **tooth, rotational_stiffness=1e7),
    ...     planets=3,
    ...     carrier="carrier",
    ...     planet=gb.Gear("planet", "pin", 0.01, teeth=24, **tooth),
    ... )
    >>> system = gb.RotorSystem(
    ...     shafts=[gb.Shaft(n, length=0.1, outer_diameter=0.02) for n in ("input", "output")],
    ...     gears=[gb.Gear("sun", "input", 0.05, teeth=24, **tooth)],
    ...     disks=[gb.Disk("carrier", "output", 0.05, 2.0, 0.005, 0.01)],
    ...     planetary_stages=[stage],
    ...     motion="torsion",
    ... )
    >>> print(system.speed_ratios)
    [ 1.    0.25  0.   -0.5  -0.5  -0.5 ]
    """

    sun: str
    ring: str | RingGear
    planets: int | Sequence[float]
    carrier: At | None = None
    _: KW_ONLY
    planet: Gear
    bearing: (
        Bearing
        | JournalBearing
        | RollingBearing
        | Sequence[Bearing | JournalBearing | RollingBearing]
    ) = ()
    pin: Shaft | None = None
    sun_mesh: Mesh | None = None
    ring_mesh: Mesh | None = None
    centre_distance: float | None = None
    pin_errors: Sequence[complex] | None = None

    def __post_init__(self) -> None:
        if isinstance(self.planets, list | tuple):
            freeze(self, "planets")
        if isinstance(self.pin_errors, list | tuple | np.ndarray):
            object.__setattr__(self, "pin_errors", tuple(self.pin_errors))

    def _angles(self, path: str) -> list[float]:
        """Give the angles of the planets [rad]."""
        if isinstance(self.planets, bool) or not isinstance(self.planets, int):
            if not isinstance(self.planets, tuple):
                raise SceneError(
                    f"{path}.planets: must be a whole number or a list of angles [rad], got "
                    f"{shown(self.planets)}"
                )
            angles = [real(angle, f"{path}.planets[{i}]") for i, angle in enumerate(self.planets)]
        else:
            angles = [2.0 * math.pi * i / self.planets for i in range(self.planets)]
        if not angles or not all(map(math.isfinite, angles)):
            raise SceneError(f"{path}.planets: at least one planet is needed, got {self.planets}")
        return angles

    def _planets(self) -> list[str]:
        count = len(self._angles("planets"))
        return [f"{self.planet.name} {i}" for i in range(1, count + 1)]

    def _check_fit(self, sun: Gear, ring: Gear, angles: Sequence[float], path: str) -> None:
        """Refuse angles at which the teeth of a planet do not fit between sun and ring."""
        total = sun.teeth + ring.teeth
        for angle in angles[1:]:
            turns = total * (angle - angles[0]) / (2.0 * math.pi)
            if abs(turns - round(turns)) > _FITTING * max(1.0, abs(turns)):
                near = angles[0] + 2.0 * math.pi * round(turns) / total
                raise SceneError(
                    f"{path}.planets: the teeth of a planet at {angle:.6g} rad do not fit between "
                    f"{sun.teeth} teeth of the sun and {ring.teeth} of the ring; angles must "
                    f"differ by multiples of 2π/{total}: {near:.10g} rad fits"
                )

    def _distance(self, sun: Gear, ring: Gear, path: str) -> float | None:
        """Give the distance of the planets from the axis; None if it follows from the teeth."""
        shifted = sun.profile_shift != 0.0 or ring.profile_shift != 0.0
        shifted = shifted or self.planet.profile_shift != 0.0
        fits = ring.teeth - self.planet.teeth == sun.teeth + self.planet.teeth
        if self.centre_distance is None and (shifted or not fits):
            raise SceneError(
                f"{path}.centre_distance: give it: with {sun.teeth}, {self.planet.teeth} and "
                f"{ring.teeth} teeth and these profile shifts, the meshes of a planet may have "
                "different distances without play"
            )
        return self.centre_distance

    def _meshes(self, sun: Gear, ring: Gear, path: str) -> tuple[Mesh, Mesh]:
        """Give the meshes of one planet in the direction of the power: the first drives it."""
        name = self.planet.name
        found = (
            self.sun_mesh or Mesh(sun.name, name),
            self.ring_mesh or Mesh(name, ring.name),
        )
        for field, mesh, other in (("sun_mesh", found[0], sun), ("ring_mesh", found[1], ring)):
            if {mesh.driver, mesh.driven} != {name, other.name}:
                raise SceneError(
                    f'{path}.{field}: must be between "{other.name}" and "{name}", got '
                    f'"{mesh.driver}" and "{mesh.driven}"'
                )
        if found[0].driver == name:
            found = found[::-1]
        if found[0].driven != name or found[1].driver != name:
            raise SceneError(
                f"{path}: the power flows from the sun over the planets to the ring, or back: one "
                "mesh must have the planet as its driven gear, the other as its driver"
            )
        return found

    def _turning(
        self, shafts: Sequence[str], bodies: Mapping[str, Gear | Disk], path: str
    ) -> tuple[str, float] | None:
        """Give shaft and position of a carrier that turns; None if it stands still."""
        if self.carrier is None:
            return None
        at = place(self.carrier, f"{path}.carrier", "place")
        if isinstance(at, str):
            if at in shafts:
                raise SceneError(
                    f'{path}.carrier: "{at}" is a shaft: give the disk on it that is the carrier, '
                    f'or ("{at}", x) with the position x of the carrier on it [m]'
                )
            return (bodies[at].shaft, bodies[at].position) if at in bodies else None
        return at[0], at[1]

    def _expand(
        self,
        shafts: Sequence[Shaft],
        gears: Sequence[Gear],
        disks: Sequence[Disk],
        path: str,
    ) -> dict[str, list[Any]]:
        """Give the parts that the stage adds."""
        self._check_kinds(path)
        names = [shaft.name for shaft in shafts]
        bodies: dict[str, Gear | Disk] = {gear.name: gear for gear in gears}
        bodies |= {disk.name: disk for disk in disks}
        turning = self._turning(names, bodies, path)
        bearings = self._bearings(path)
        if turning is None and not bearings:
            raise SceneError(f"{path}.bearing: the planets need bearings on their pins")
        added: dict[str, list[Any]] = {key: [] for key in ADDED}
        by_name = {gear.name: gear for gear in gears}
        if isinstance(self.ring, RingGear):
            given = self.ring
            if turning is not None and given.support is None:
                mount, drive, holding = given._on_ground(f"{path}.ring")
                added["shafts"].append(mount)
                added["drives"].append(drive)
                added["bearings"] += [] if holding is None else [holding]
                given = replace(given, support=mount.name, position=0.0, **_UNSUPPORTED)
                names.append(mount.name)
            ring = given._gear(names, f"{path}.ring")
            added["gears"].append(ring)
            by_name[ring.name] = ring
        for field, name in (("sun", self.sun), ("ring", self.ring)):
            if isinstance(name, str) and name not in by_name:
                raise SceneError(f'{path}.{field}: no gear is called "{name}"')
        sun = by_name[self.sun]
        ring = ring if isinstance(self.ring, RingGear) else by_name[self.ring]
        if not ring.internal or sun.internal or self.planet.internal:
            raise SceneError(
                f"{path}.ring: the ring needs internal=True, sun and planets must be external"
            )
        if isinstance(self.planets, int) and self.planets > sun.teeth + ring.teeth:
            raise SceneError(
                f"{path}.planets: {shown(self.planets)} planets do not fit between {sun.teeth} "
                f"teeth of the sun and {ring.teeth} of the ring"
            )
        angles = self._angles(path)
        self._check_fit(sun, ring, angles, path)
        distance = self._distance(sun, ring, path)
        meshes = self._meshes(sun, ring, path)
        self._check_neighbours(sun, angles, path)
        errors = self._pin_errors(len(angles), bearings, path)
        for i, (angle, error) in enumerate(zip(angles, errors, strict=True), start=1):
            own = f"{self.planet.name} {i}"
            pin = self._pin(turning is not None and not bearings, path)
            shaft = f"{pin.name} {i}"
            added["shafts"].append(replace(pin, name=shaft))
            added["gears"].append(replace(self.planet, name=own, shaft=shaft))
            for mesh in meshes:
                swap = {name: own if name == self.planet.name else name for name in _ends(mesh)}
                # The ring and the sun have one centre.
                outwards = mesh.driver in (sun.name, ring.name)
                added["meshes"].append(
                    replace(
                        mesh,
                        driver=swap[mesh.driver],
                        driven=swap[mesh.driven],
                        centre_line_angle=math.remainder(
                            angle if outwards else angle + math.pi, 2.0 * math.pi
                        ),
                        centre_distance=distance,
                        carrier=turning,
                    )
                )
            standing: dict[str, Any] = {"shaft": shaft, "support": turning or self.carrier}
            if error:
                standing["misalignment"] = error * cmath.exp(1j * angle)
            added["bearings"] += [replace(each, **standing) for each in bearings]
        return added

    def _pin_errors(
        self, count: int, bearings: Sequence[AnyBearing], path: str
    ) -> tuple[complex, ...]:
        """Give the position error of each pin [m]."""
        if self.pin_errors is None:
            return (0j,) * count
        given, at = self.pin_errors, f"{path}.pin_errors"
        if not isinstance(given, tuple) or len(given) != count:
            raise SceneError(
                f"{at}: must be a list of {count} numbers [m], one for each planet, got "
                f"{shown(given)}"
            )
        plain = [complex_number(error, f"{at}[{i}]") for i, error in enumerate(given)]
        errors = tuple(complex(*e) if isinstance(e, list) else complex(e) for e in plain)
        for i, error in enumerate(errors):
            if not cmath.isfinite(error):
                raise SceneError(f"{at}[{i}]: must be finite, got {shown(given[i])}")
        if any(errors) and not (bearings and all(isinstance(each, Bearing) for each in bearings)):
            raise SceneError(
                f"{at}: a pin that is off moves the planet on its bearings: give bearings of the "
                "planet, each a gb.Bearing"
            )
        return errors

    def _check_neighbours(self, sun: Gear, angles: Sequence[float], path: str) -> None:
        """Refuse planets whose tip circles overlap."""
        planet = self.planet
        if planet.module is None or len(angles) < 2:
            return
        scale = 0.5 * planet.module / math.cos(planet.helix_angle)
        radius = planet.tip_radius
        if radius is None:
            radius = scale * planet.teeth + planet.module * (1.0 + planet.profile_shift)
        distance = self.centre_distance or scale * (sun.teeth + planet.teeth)
        turn = 2.0 * math.pi
        placed = sorted((angle % turn, i) for i, angle in enumerate(angles))
        for (here, i), (there, j) in zip(placed, [*placed[1:], placed[0]], strict=True):
            apart = 2.0 * distance * math.sin(0.5 * ((there - here) % turn))
            if apart <= 2.0 * radius:
                raise SceneError(
                    f"{path}.planets: planets {i + 1} and {j + 1} overlap: their centres are "
                    f"{1e3 * apart:.4g} mm apart, their tip circles need {2e3 * radius:.4g} mm; "
                    "use fewer planets, or planets with fewer teeth"
                )

    def _check_kinds(self, path: str) -> None:
        """Refuse values of wrong classes; lists are checked where they are used."""
        plain = replace(
            self, planets=1, bearing=Bearing("pin", 0.0, stiffness=1.0), pin_errors=None
        )
        plain._describe(path)

    def _bearings(self, path: str) -> tuple[Bearing | JournalBearing | RollingBearing, ...]:
        given = self.bearing if isinstance(self.bearing, list | tuple) else (self.bearing,)
        return parts(given, Bearing, f"{path}.bearing", JournalBearing, RollingBearing)

    def _pin(self, twists: bool, path: str) -> Shaft:
        """Give the shaft of one planet, which may only twist."""
        if self.pin is not None:
            return self.pin
        planet = self.planet
        if planet.module is None or planet.face_width is None:
            raise SceneError(f"{path}.pin: give it, or module and face_width of the planet")
        diameter = planet.module * planet.teeth / math.cos(planet.helix_angle)
        name, length = f"{planet.name} pin", planet.face_width
        if twists:
            return Shaft(name, length=length, outer_diameter=_THIN * diameter)
        return Shaft(name, length=length, outer_diameter=0.5 * diameter, material=_MASSLESS)


def _ends(mesh: Mesh) -> tuple[str, str]:
    return mesh.driver, mesh.driven


def expanded(
    stages: Sequence[PlanetaryStage],
    shafts: Sequence[Shaft],
    gears: Sequence[Gear],
    disks: Sequence[Disk],
) -> dict[str, list[Any]]:
    """Give the parts that stages add to a system."""
    added: dict[str, list[Any]] = {key: [] for key in ADDED}
    for index, stage in enumerate(stages):
        path = f"planetary_stages[{index}]"
        for key, found in stage._expand(shafts, gears, disks, path).items():
            added[key] += found
    return added


def planet_masses(
    meshes: Iterable[Mesh],
    distances: Mapping[tuple[str, str], float],
    gears: Mapping[str, Gear],
    masses: Mapping[str, float],
    name: Callable[[str], str],
) -> list[Disk]:
    """Give disks with the inertia of planets on rigid pins about the axes of their carriers."""
    # Rigid pins move the planets along with the carrier; the spin of a planet about its own axis
    # is a motion of its own. Masses of shafts are in kg, centre distances of meshes in m; `name`
    # gives the name of a disk on a shaft.
    found: dict[tuple[str, float], list[tuple[float, float]]] = {}
    for mesh in meshes:
        rings = {end for end in _ends(mesh) if gears[end].internal}
        if rings and mesh.carrier is not None:
            (planet,) = {*_ends(mesh)} - rings
            orbit = (masses[gears[planet].shaft], distances[_ends(mesh)])
            found.setdefault(mesh.carrier, []).append(orbit)  # type: ignore[arg-type]  # a place
    disks = []
    for (shaft, position), orbits in found.items():
        total, polar = (sum(m * distance**power for m, distance in orbits) for power in (0, 2))
        disks.append(Disk(name(shaft), shaft, position, total, 0.5 * polar, polar))
    return disks


def tooth_angles(
    stage: PlanetaryStage,
    meshes: Sequence[Mesh],
    geometry: Mapping[tuple[str, str], MeshGeometry],
    gears: Mapping[str, Gear],
    ratios: Mapping[str, float],
) -> dict[tuple[str, str], float]:
    """Find `Mesh.tooth_angle` of the meshes that the planets of a stage drive."""
    # A planet has one position, which the mesh that drives it gives: the flank that drives the
    # next gear is the other one of the tooth in contact.
    pairs = [mesh for mesh in meshes if (mesh.driver, mesh.driven) in geometry]
    found = {}
    for name in stage._planets():
        first = next(mesh for mesh in pairs if mesh.driven == name)
        second = next(mesh for mesh in pairs if mesh.driver == name)
        planet = gears[name]
        shape = geometry[first.driver, name]
        driver, own = shape["base_radii"]
        # Signs of an internal driver: the belt lies on one side of both centres.
        sign = math.copysign(1.0, driver * own)
        total = abs(driver) + sign * own
        tangent = sign * math.sqrt(shape["centre_distance"] ** 2 - total**2)
        carrier = 0.0 if first.carrier is None else ratios[first.carrier[0]]
        sense = math.copysign(1.0, ratios[gears[first.driver].shaft] - carrier)
        line = math.atan2(tangent, total)
        position = abs(driver) * (sense * (first.tooth_angle - first.centre_line_angle) + line)
        touching = first.centre_line_angle - sense * line + (math.pi if sign > 0.0 else 0.0)
        turning = math.copysign(1.0, ratios[planet.shaft] - carrier)
        behind = touching - turning * (tangent - position) / own
        found[name, second.driven] = math.remainder(
            behind + 2.0 * turning * _half_angle(planet), 2.0 * math.pi
        )
    return found


def _half_angle(gear: Gear) -> float:
    """Give half the angle of a tooth of an external gear on the base circle [rad]."""
    tangent = math.tan(gear.pressure_angle)
    transverse = tangent / math.cos(gear.helix_angle)
    involute = transverse - math.atan(transverse)
    return (0.5 * math.pi + 2.0 * gear.profile_shift * tangent) / gear.teeth + involute
