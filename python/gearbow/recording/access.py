"""What a recorded run shows at a place, and its balance of energy."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, text
from gearbow._result import Column, Figured
from gearbow._shown import ReadOnly
from gearbow._times import begin_after
from gearbow._types import Array, Plain, Section
from gearbow.description.places import Places, place
from gearbow.description.speed import SpeedProfile
from gearbow.errors import ChannelError
from gearbow.recording.record import (
    Contact,
    ContactShares,
    Event,
    MeshResponse,
    MeshScene,
    Recorded,
    RunRecord,
    contact_at,
    first_contact,
    shares,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Fields that are energies of the system, and fields that are work done on it.
ENERGIES = ("kinetic", "shafts", "bearings", "meshes")
WORKS = ("torque", "gravity", "drive", "unbalance", "teeth", "damping")


@dataclass(frozen=True, eq=False)
class EnergyBalance(Figured, ReadOnly):
    """Energies of a system and the work done on it, at the k times of a response.

    `plot` draws energies, works and the residual against time in three panels. Terms that are
    zero throughout are omitted.

    Parameters
    ----------
    time : ndarray, shape (k,)
        Times [s].
    kinetic : ndarray, shape (k,)
        Kinetic energy of the vibration, without that of the rigid-body rotation [J].
    shafts : ndarray, shape (k,)
        Elastic energy of the shafts; a bowed shaft without load has none [J].
    bearings, meshes : ndarray, shape (k,)
        Elastic energy of the bearings, and of the meshes [J].
    torque, gravity : ndarray, shape (k,)
        Work of the torques on the vibration, and of gravity [J].
    drive : ndarray, shape (k,)
        Work of the drive that keeps bowed shafts, deflected ones with internal damping, and
        carriers with planets that move laterally, at the prescribed speed and changes the stiffness
        of bearings with the speed [J]. The energies of such planets are relative to the carrier.
    unbalance : ndarray, shape (k,)
        Work of the unbalance [J].
    teeth : ndarray, shape (k,)
        Work of the teeth: time-varying stiffness, transmission error and run-out [J].
    damping : ndarray, shape (k,)
        Work of damping forces, negative, and of the cross-coupled stiffness of bearings [J].

    Notes
    -----
    Work is zero at the start of the run, also if the run continues another one. The `residual` is
    the integration error.

    Examples
    --------
    A bowed shaft is released from rest. Its energy is constant:

    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=bow)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e9) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> response = system.simulate(0.01, speed=0.0, initial="rest", record="energy", rtol=1e-8)
    >>> balance = response.energy_balance()
    >>> bool(abs(balance.residual).max() < 1e-6 * balance.total.max())
    True
    """

    _indexed: ClassVar[bool] = True

    time: Array
    kinetic: Array
    shafts: Array
    bearings: Array
    meshes: Array
    torque: Array
    gravity: Array
    drive: Array
    unbalance: Array
    teeth: Array
    damping: Array

    @property
    def total(self) -> Array:
        """Kinetic energy and elastic energy of shafts, bearings and meshes [J], shape (k,)."""
        return self.kinetic + self.shafts + self.bearings + self.meshes

    @property
    def work(self) -> Array:
        """Total work on the system since the start of the run [J], shape (k,).

        It is the work of torque, gravity, drive, unbalance, teeth and damping.
        """
        return self.torque + self.gravity + self.drive + self.unbalance + self.teeth + self.damping

    @property
    def residual(self) -> Array:
        """Change of energy that the work does not explain since the first recorded time.

        The unit is J, the shape (k,). It is the change of `total` minus the change of `work`: the
        integration error.
        """
        total, work = self.total, self.work
        return (total - total[:1]) - (work - work[:1])

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import response as figures  # noqa: PLC0415

        def _terms(names: tuple[str, ...]) -> dict[str, Array]:
            return {name: getattr(self, name) for name in names}

        rows = {
            "energy": (_terms(ENERGIES), self.total),
            "work": (_terms(WORKS), self.work),
            "residual": (_terms(()), self.residual),
        }
        return figures.energy_balance(self.time, rows, ax=ax)

    def _terms(self) -> dict[str, Array]:
        names = [*[field.name for field in fields(self)][1:], "total", "work", "residual"]
        return {name: getattr(self, name) for name in names}

    def _columns(self) -> list[Column]:
        terms = self._terms()
        values = np.array(list(terms.values())).reshape(len(terms), -1)
        if not values.size:
            values = np.full((len(terms), 1), np.nan)
        return [
            Column("term", list(terms)),
            Column("smallest", values.min(axis=1), "J"),
            Column("largest", values.max(axis=1), "J"),
            Column("at the end", values[:, -1], "J"),
        ]

    def _series(self) -> list[Column]:
        terms = self._terms().items()
        return [Column("time", self.time, "s"), *(Column(name, own, "J") for name, own in terms)]


@dataclass(frozen=True, eq=False)
class BearingMotion(ReadOnly):
    """Force on a journal or rolling bearing, with the place of the journal or the load of elements.

    An equilibrium has one value of each quantity, a response one for each of its k times.

    Parameters
    ----------
    force : ndarray, shape (2,) or (k, 2)
        Force of the shaft on the bearing along y and z [N].
    eccentricity_ratio : float or ndarray, shape (k,), optional
        Displacement of the journal over the radial clearance; None for a rolling bearing.
    attitude_angle : float or ndarray, shape (k,), optional
        Angle from the force to the displacement, from y towards z [rad], between −π and π. In a
        steady film it has the sign of the rotation of the shaft. None for a rolling bearing.
    loaded_elements, largest_contact_force : ndarray, shape (k,), optional
        Number of loaded rolling elements and largest contact force [N]; None for a journal bearing.

    Examples
    --------
    >>> import gearbow as gb
    >>> size = {"diameter": 0.05, "length": 0.02, "clearance": 5e-5}
    >>> films = [gb.JournalBearing("rotor", x, viscosity=0.02, **size) for x in (0.0, 1.0)]
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    >>> system = gb.RotorSystem([rotor], bearings=films, gravity=9.81)
    >>> print(f"{system.static(speed=300.0).journal(('rotor', 0.0)).eccentricity_ratio:.3f}")
    0.185
    >>> size = {"elements": 9, "element_diameter": 0.0127, "pitch_diameter": 0.065}
    >>> bearings = [
    ...     gb.RollingBearing("rotor", x, **size, clearance=1e-5, damping=100.0) for x in (0.0, 1.0)
    ... ]
    >>> run = system.replace(bearings=bearings).simulate(0.01, 300.0, record=["bearings"])
    >>> run.rolling(("rotor", 0.0)).loaded_elements.shape == run.time.shape
    True
    """

    force: Array
    eccentricity_ratio: Array | None = None
    attitude_angle: Array | None = None
    loaded_elements: Array | None = None
    largest_contact_force: Array | None = None


def journal_motion(
    bearings: Iterable[Mapping[str, Plain]],
    at: tuple[str, float],
    displacement: Array,
    force: Array,
) -> BearingMotion:
    """Find the motion of a journal from the displacement of the shaft relative to its bearing."""
    journals = [bearing for bearing in bearings if "viscosity" in bearing]
    known = Places.of("bearing", [(each["shaft"], each["position"]) for each in journals])
    i = known.index(at, "journal bearing")
    (y, z), (along_y, along_z) = np.moveaxis(displacement, -1, 0), np.moveaxis(force, -1, 0)
    return BearingMotion(
        force=force,
        eccentricity_ratio=np.hypot(y, z) / float(journals[i]["clearance"]),
        attitude_angle=np.arctan2(along_y * z - along_z * y, along_y * y + along_z * z),
    )


#: Quantities of the motion of a place, by the names of their arrays.
Quantity = Literal[
    "displacement",
    "twist",
    "axial",
    "velocity",
    "twist_rate",
    "acceleration",
    "axial_velocity",
    "axial_acceleration",
]


def motion(run: RunRecord, quantity: Quantity, at: Any) -> Array:
    """Give a quantity of the motion of a place."""
    points = run.data["points"]
    known = Places("place", ([(shaft, x), *names] for shaft, x, names in points))
    point = known.find(at)
    if point is None:
        at = place(at)
        raise run.missing(f"the motion of {at!r}", at)
    if quantity.startswith("axial"):
        _along_axis(run, "axial")
    plain: dict[str, Any] = dict(run.data)
    found: Array | None = plain.get(quantity)
    if found is None:
        group = "acceleration" if quantity.endswith("acceleration") else "velocity"
        raise run.missing(f"the {quantity.replace('_', ' ')} of {place(at)!r}", group)
    return found[:, point]


def bearing_force(run: RunRecord, at: object) -> Array:
    """Give the lateral force on a bearing."""
    return run.data["bearing_force"][:, _bearing(run, at)]


def axial_bearing_force(run: RunRecord, at: object) -> Array:
    """Give the axial force on a bearing."""
    bearing = _bearing(run, at)
    return _along_axis(run, "axial_bearing_force")[:, bearing]


def bearing_displacement(run: RunRecord, at: object) -> Array:
    """Give the displacement of a shaft relative to what its bearing stands on."""
    bearing = _bearing(run, at)
    found = run.data.get("bearing_displacement")
    if found is None:
        raise ChannelError("the file of this run has no displacements at bearings; run again")
    return found[:, bearing]


def journal(run: RunRecord, at: object) -> BearingMotion:
    """Give the motion of a journal in its bearing."""
    force, displacement = bearing_force(run, at), bearing_displacement(run, at)
    bearings = () if run.request is None else run.request.description.get("bearings", ())
    return journal_motion(bearings, place(at), displacement, force)


def rolling(self: Recorded, at: tuple[str, float]) -> BearingMotion:
    """Time history of a rolling bearing.

    Parameters
    ----------
    at : tuple of (str, float)
        Shaft and position of the bearing [m].

    Returns
    -------
    BearingMotion
        Force, number of loaded elements and largest contact force.
    """
    run = self._to_record()
    force = bearing_force(run, at)
    i = Places.of("bearing", run.data["rolling_bearings"]).index(at, "rolling bearing")
    loaded, largest = np.moveaxis(run.data["rolling_contact"][:, i], -1, 0)
    return BearingMotion(force, loaded_elements=loaded, largest_contact_force=largest)


def _bearing(run: RunRecord, at: object) -> int:
    i = Places.of("bearing", run.data["bearings"]).find(at)
    if i is None:
        shaft, position = place(at)
        what = f"the bearing force at ({shaft!r}, {position:g})"
        raise run.missing(what, ("bearing", shaft, position))
    return i


def _along_axis(run: RunRecord, name: Literal["axial", "axial_bearing_force"]) -> Array:
    """Give an array of the axial motion."""
    found = run.data.get(name)
    if found is None:
        raise ChannelError(
            "the system has no axial motion; helical gears, axial forces and bearings with "
            "axial_stiffness cause it"
        )
    return found


def section_forces(run: RunRecord, at: Any) -> tuple[list[Section], Array]:
    """Give the sections at a place, or of a shaft, and their forces, shape (times, k, 6)."""
    at = place(at)
    points = run.data["points"]
    point = Places("place", ([(shaft, x), *names] for shaft, x, names in points)).find(at)
    shaft, position, _ = (at, None, ()) if point is None else points[point]
    known = run.data["sections"]
    own = [i for i, (name, x, _) in enumerate(known) if name == shaft and position in {None, x}]
    if not own:
        raise run.missing(f"a section force at {at!r}", "section_forces")
    own.sort(key=lambda i: (known[i][1], known[i][2] == "beyond"))
    values = np.concatenate([run.data["section_force"], run.data["section_moment"]], axis=-1)
    return [known[i] for i in own], values[:, own]


def at_side(sections: Sequence[Section], side: str) -> int:
    """Choose among the sections at one place: at an end of the shaft there is only one."""
    return next((i for i, (*_, own) in enumerate(sections) if own == side), 0)


class PlanetMotion(NamedTuple):
    """Angle of a planet about the axis of a ring [rad] and force of their mesh [N], (k,) each."""

    angle: Array
    force: Array


def planets_of(run: RunRecord, ring: str) -> list[PlanetMotion]:
    """Give the motion of all gears that mesh with an internal gear; they turn with the carrier."""
    if run.request is None:
        raise ChannelError("the positions of the planets are unknown: the response has no scene")
    scene = run.request.description
    bodies = {each["name"]: each for each in (*scene["gears"], *scene.get("disks", ()))}
    if not bodies.get(ring, {}).get("internal"):
        internal = [name for name, each in bodies.items() if each.get("internal")]
        raise ChannelError(
            f'ring_sensor.ring: no internal gear is called "{ring}"; there are '
            f"{', '.join(internal) or 'none'}"
        )
    found = []
    for each in scene["meshes"]:
        if ring not in (each["driver"], each["driven"]):
            continue
        carrier = each.get("carrier")
        turned: float | Array = 0.0
        if carrier is not None:
            shaft = bodies[carrier]["shaft"] if isinstance(carrier, str) else carrier[0]
            turned = angle(run, shaft)
        # The line of centres goes from the driver to the driven gear.
        opposite = np.pi if each["driven"] == ring else 0.0
        at_rest = each.get("centre_line_angle", 0.0) + opposite
        recorded = _mesh_values(run, _mesh(run, (each["driver"], each["driven"])))
        angles = np.broadcast_to(at_rest + turned, run.time.shape)
        found.append(PlanetMotion(angles, recorded["force"]))
    return found


def mesh(self: Recorded, at: str | tuple[str, str]) -> MeshResponse:
    """Time history of one mesh.

    Parameters
    ----------
    at : tuple of (str, str) or str
        The two gears, (driver, driven) in either order, or "driver/driven".

    Returns
    -------
    MeshResponse
        Force and deflection, and the geometry of the moving centres.
    """
    run = self._to_record()
    i = _mesh(run, at)
    contact = contact_at(run.time, *_contact(run, i))
    return MeshResponse(**_mesh_values(run, i), contact=contact)


def contact_shares(
    self: Recorded, at: str | tuple[str, str], *, skip_time: float = 0.0
) -> ContactShares:
    """Find the shares of the time with contact of drive flanks, back flanks, both or none.

    The contact changes at the exact times of the events, also between recorded instants.

    Parameters
    ----------
    at : tuple of (str, str) or str
        The mesh, as for `mesh`.
    skip_time : float
        Time at the beginning that is ignored [s].

    Returns
    -------
    ContactShares
        The shares between the first and the last recorded time; `ContactShares.lost` is the
        share without contact of the drive flanks. A mesh without backlash is always in contact.
    """
    run = self._to_record()
    begin = begin_after(run.time, skip_time)
    return shares(begin, float(run.time[-1]), *_contact(run, _mesh(run, at)))


def mesh_names(run: RunRecord, at: object) -> tuple[str, str]:
    """Give driver and driven gear of a recorded mesh."""
    driver, driven = run.data["meshes"][_mesh(run, at)]
    return driver, driven


def _mesh(run: RunRecord, at: object) -> int:
    i = Places.of("mesh", run.data["meshes"]).find(at)
    if i is None:
        driver, driven = place(at)
        raise run.missing(f"the mesh of {driver!r} with {driven!r}", (driver, driven))
    return i


def _mesh_values(run: RunRecord, mesh: int) -> dict[str, Array]:
    return {name: values[:, mesh] for name, values in run.data["mesh"].items()}


def _contact(run: RunRecord, mesh: int) -> tuple[list[Event], Contact]:
    """Give the events of a mesh, and its contact before the first of them."""
    driver, driven = run.data["meshes"][mesh]
    own = [each for each in events(run) if (each.driver, each.driven) == (driver, driven)]
    scene = None if run.request is None else MeshScene.of(run.request, driver, driven)
    return own, first_contact(run.time, _mesh_values(run, mesh), own, scene)


def events(run: RunRecord) -> tuple[Event, ...]:
    """Give the contact events of the teeth."""
    return tuple(Event(*event) for event in run.data["events"])


def energy(run: RunRecord) -> Array:
    """Give the energy of the vibration."""
    found = run.data["energy"]
    if found is None:
        raise run.missing("the energy", "energy")
    return found


def energy_balance(self: Recorded) -> EnergyBalance:
    """Compare the energies of the system with the work done on it.

    Returns
    -------
    EnergyBalance
        The terms, their sums, and the residual, which is the integration error.
    """
    run = self._to_record()
    terms = run.data["energy_terms"]
    if terms is None:
        raise run.missing("the energy balance", "energy")
    return EnergyBalance(time=run.time, **terms)


def speeds(run: RunRecord, times: ArrayLike | None = None) -> Array:
    """Give the speed of the reference shaft [rad/s]."""
    t = run.time if times is None else array(times, "times", least=0)
    if isinstance(run.speed, SpeedProfile):
        return run.speed(t)
    return np.full(t.shape, run.speed)


def angle(self: Recorded, shaft: str, times: "ArrayLike | None" = None) -> Array:
    """Prescribed angle of a shaft, without its twist.

    Parameters
    ----------
    shaft : str
        Name of the shaft.
    times : array_like, shape (n,), optional
        Times [s]; None is the k recorded times.

    Returns
    -------
    ndarray, shape (k,) or (n,)
        Angle about x, not reduced to one revolution [rad].
    """
    run = self._to_record()
    found: Array = _ratio(run, shaft) * reference_angle(run, times)
    return found


def reference_angle(run: RunRecord, times: ArrayLike | None = None) -> Array:
    """Give the prescribed angle of the reference shaft [rad]."""
    known, high, low = run.data["final"]["anchor"]
    t = run.time if times is None else array(times, "times", least=0)
    turned: Array
    if isinstance(run.speed, SpeedProfile):
        turned = run.speed.angle(t) - run.speed.angle(known)
    else:
        turned = run.speed * (t - known)
    angles: Array = high + (low + turned)
    return angles


def spin(self: Recorded, shaft: str, times: "ArrayLike | None" = None) -> Array:
    """Prescribed angular velocity of a shaft.

    Parameters
    ----------
    shaft : str
        Name of the shaft.
    times : array_like, shape (n,), optional
        Times [s]; None is the k recorded times.

    Returns
    -------
    ndarray, shape (k,) or (n,)
        Angular velocity about x [rad/s].
    """
    run = self._to_record()
    found: Array = _ratio(run, shaft) * speeds(run, times)
    return found


def _ratio(run: RunRecord, shaft: str) -> float:
    """Find the signed speed ratio of a shaft."""
    if run.kinematics is None:
        raise ChannelError("the angles of the shafts are unknown: the response has no kinematics")
    ratios = dict(run.kinematics.shafts)
    if text(shaft, "shaft") not in ratios:
        raise ChannelError(f"no shaft is called {shaft!r}; there are {', '.join(ratios)}")
    return ratios[shaft]
