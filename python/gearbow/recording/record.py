"""A recorded run as plain data, and the contact of its meshes."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import IntEnum
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gearbow._convert import shown
from gearbow._core import mesh_geometry
from gearbow._shown import ReadOnly, Shown, short, to_html
from gearbow._types import Array, Plain, Record, RunData
from gearbow.description.gears import Gear
from gearbow.description.layout import Kinematics
from gearbow.description.part import tuples
from gearbow.description.speed import SpeedProfile
from gearbow.errors import ChannelError, GearbowError, SceneError
from gearbow.units.speed import SpeedUnit


class Contact(IntEnum):
    """Flanks of a mesh that are in contact.

    NONE is 0, DRIVE 1, BACK 2 and BOTH 3. The drive flanks push the driven gear in its direction of
    rotation, the back flanks against it. Both are in contact where the displacements of the shafts
    reduce the centre distance by more than the backlash allows.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.results.Contact(2)
    <Contact.BACK: 2>
    """

    NONE = 0
    DRIVE = 1
    BACK = 2
    BOTH = 3


#: Contact after each kind of event that changes it.
_AFTER = {
    "contact": Contact.DRIVE,
    "back contact": Contact.BACK,
    "separation": Contact.NONE,
    "tight": Contact.BOTH,
}


@dataclass(frozen=True)
class ContactShares(Shown):
    """Shares of the time in each state of contact of a mesh; their sum is 1.

    Parameters
    ----------
    drive, back, both, none : float
        Shares with contact of the drive flanks only, the back flanks only, both, and none.

    Examples
    --------
    >>> import gearbow as gb
    >>> shares = gb.results.ContactShares(drive=0.9, back=0.02, both=0.0, none=0.08)
    >>> print(f"{shares.lost:.2f}")
    0.10
    """

    drive: float
    back: float
    both: float
    none: float

    @property
    def lost(self) -> float:
        """Share of the time without contact of the drive flanks: `back` and `none`."""
        return self.back + self.none


@dataclass(frozen=True)
class ErrorEstimate(Shown):
    """Error of one kind of signal: RMS of the difference / RMS of the signal about its mean.

    Parameters
    ----------
    elements, modes, integration : float
        Contributions of the elements, of the modes that are left out, and of the integration.
    total : float
        Error of the signal with all of them.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.results.ErrorEstimate(elements=2e-3, modes=0.0, integration=1e-4, total=2e-3).total
    0.002
    """

    elements: float
    modes: float
    integration: float
    total: float


class Errors(dict[str, ErrorEstimate]):
    """Estimated errors of a run by the kind of signal."""

    def __init__(
        self, estimates: Mapping[str, ErrorEstimate], *, window: float, chaotic: bool
    ) -> None:
        super().__init__(estimates)
        self.window = window
        self.chaotic = chaotic

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (dict(self), self.window, self.chaotic)

    def __str__(self) -> str:
        lines = [
            f"{kind}: {each.total:.1e} (elements {each.elements:.1e}, modes {each.modes:.1e}, "
            f"integration {each.integration:.1e})"
            for kind, each in self.items()
        ]
        lines.append(f"over the first {self.window:g} s")
        if self.chaotic:
            lines.append(
                "chaotic contact: small differences grow to the size of the signals, so that no "
                "run predicts the time history after the first impacts"
            )
        return "\n".join(lines)

    def _plain(self) -> dict[str, Plain]:
        """Convert to data that JSON can hold."""
        estimates = {kind: asdict(each) for kind, each in self.items()}
        return {"window": self.window, "chaotic": self.chaotic, "estimates": estimates}

    @classmethod
    def _from_plain(cls, given: Mapping[str, Plain] | None) -> "Errors | None":
        """Read the data of `_plain`."""
        if given is None:
            return None
        estimates = {kind: ErrorEstimate(**each) for kind, each in given["estimates"].items()}
        return _made(estimates, given["window"], given["chaotic"])


def _made(estimates: Mapping[str, ErrorEstimate], window: float, chaotic: bool) -> Errors:
    return Errors(estimates, window=window, chaotic=chaotic)


#: Names of the options of a run.
OPTIONS = (
    *("duration", "speed", "method", "step", "rtol", "stages", "modes"),
    *("initial", "record", "geometry", "start", "accuracy"),
)
#: Arrays of a final state from which a run continues.
_ARRAYS = {"state": np.float64, "memory": np.float64, "contact_modes": np.int64}


@dataclass(frozen=True, eq=False)
class RunRequest(Shown):
    """The scene and the options of a run, from which the same run can be made again."""

    description: Mapping[str, Plain]
    options: Mapping[str, Any]

    def plain(self) -> dict[str, Plain]:
        """Convert to data that JSON can hold."""
        return {"description": dict(self.description), "options": _plain(dict(self.options))}

    @classmethod
    def from_plain(cls, given: Mapping[str, Plain] | None) -> "RunRequest | None":
        """Read the data of `plain`."""
        if given is None:
            return None
        options = dict(given["options"])
        initial = options.get("initial")
        if isinstance(initial, Mapping):
            options["initial"] = {name: _array(name, value) for name, value in initial.items()}
        options["record"] = [tuples(item) for item in options["record"]]
        return cls(given["description"], options)


def _array(name: str, value: Plain) -> Any:
    """Convert a list of numbers to an array; another entry stays the same."""
    if name not in _ARRAYS:
        return value
    try:
        return np.array(value, dtype=_ARRAYS[name]).reshape(len(value))
    except (TypeError, ValueError, OverflowError) as error:
        raise GearbowError(f"request.options.initial.{name}: {error}") from None


def _plain(value: Any) -> Plain:
    """Convert arrays in mappings to lists."""
    if isinstance(value, Mapping):
        return {name: _plain(entry) for name, entry in value.items()}
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


@dataclass(frozen=True, eq=False)
class RunRecord(Shown):
    """All data of a run that a file contains."""

    data: RunData
    speed: float | SpeedProfile
    kinematics: Kinematics | None = None
    accuracy: str | None = None
    request: RunRequest | None = None
    errors: Errors | None = None
    #: Period of a steady motion, of which this is one period [s].
    period: float | None = None
    speed_unit: SpeedUnit = "rad/s"

    @property
    def time(self) -> Array:
        """Recorded times [s]."""
        return self.data["time"]

    @property
    def recorded(self) -> list[Record]:
        """Recorded items, in the form of the argument `record` of `simulate`."""
        items: list[Record] = []
        for shaft, position, names in self.data["points"]:
            items.extend(names or [(shaft, position)])
        items.extend((driver, driven) for driver, driven in self.data["meshes"])
        items.extend(("bearing", shaft, position) for shaft, position in self.data["bearings"])
        items += [name for name in ("velocity", "acceleration") if name in self.data]
        items += ["section_forces"] if "section_force" in self.data else []
        return [*items, "energy"] if self.data["energy"] is not None else items

    @property
    def recorded_shafts(self) -> list[str]:
        """Shafts with recorded section forces."""
        if not self.data["sections"]:
            raise self.missing("a section force", "section_forces")
        return list(dict.fromkeys(shaft for shaft, *_ in self.data["sections"]))

    def missing(self, what: str, record: Record) -> ChannelError:
        """Make the error for something that was not recorded; it lists what was."""
        recorded = ", ".join(repr(item) for item in self.recorded) or "nothing"
        return ChannelError(
            f"{what} was not recorded; give record=[{record!r}, ...] to simulate "
            f"(recorded: {recorded})"
        )

    def asked(self, by: str) -> RunRequest:
        """Give the request of the run, without which the system is unknown."""
        if self.request is None:
            raise GearbowError(
                f"{by}: this response does not know its system; take a response that simulate "
                "returned or that save wrote"
            )
        return self.request

    def _to_record(self) -> "RunRecord":
        """Give the record, as a response does."""
        return self


#: Units of the section forces by their names, in the order of their values.
SECTION_FORCES = {
    "axial_force": "N",
    "shear_y": "N",
    "shear_z": "N",
    "moment_y": "N m",
    "moment_z": "N m",
    "torque": "N m",
}


class Recorded(Protocol):
    """A recorded run, for example a `gearbow.Response`."""

    def _to_record(self) -> RunRecord:
        """Give the recorded run as plain data."""


def recorded_run(given: object, path: str) -> RunRecord:
    """Give the data of a response."""
    if isinstance(given, type) or not hasattr(given, "_to_record"):
        raise SceneError(f"{path}: must be a Response, got {shown(given)}")
    found: RunRecord = given._to_record()
    return found


class Event(NamedTuple):
    """A change of the contact of a mesh.

    Parameters
    ----------
    time : float
        Time [s].
    driver, driven : str
        Names of the driving and the driven gear.
    kind : str
        "contact" (the drive flanks meet), "back contact" (the back flanks meet), "separation" (the
        flanks separate), "tight" (both flanks are in contact), "contact ratio below 1", "contact
        ratio above 1", "tip interference" (a tip reaches the root circle of the other gear), "tip
        clearance" (the tip interference ends), "involute interference" (a tip reaches beyond the
        base circle of the other gear, which shortens the path of contact) or "involute clearance"
        (the involute interference ends).

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.results.Event(0.1, "pinion", "wheel", "separation").kind
    'separation'
    """

    time: float
    driver: str
    driven: str
    kind: str

    def _repr_html_(self) -> str:
        rows = zip(self._fields, map(short, self), strict=True)
        return to_html(repr(self), (("", ""), *rows))


@dataclass(frozen=True, eq=False)
class MeshResponse(ReadOnly):
    """Time history of one mesh at the k times of a response.

    Parameters
    ----------
    deflection : ndarray, shape (k,)
        Mesh deflection along the line of action of the drive flanks [m].
    force : ndarray, shape (k,)
        Net mesh force [N]: that of the drive flanks minus that of the back flanks. Where both
        flanks are in contact, each carries more than this force. A negative force is contact of the
        back flanks; without backlash, teeth that pull.
    stiffness : ndarray, shape (k,)
        Mesh stiffness [N/m].
    pressure_angle : ndarray, shape (k,)
        Operating pressure angle [rad]; NaN where base circles overlap, in frozen geometry only.
    centre_distance : ndarray, shape (k,)
        Distance between the moving centres [m].
    centre_line_angle : ndarray, shape (k,)
        Angle of the line of centres, driver to driven, from y towards z [rad].
    contact_ratio, pairs_in_contact : ndarray, shape (k,)
        Contact ratio, NaN where base circles overlap, and number of tooth pairs that carry load.
    thrust : ndarray, shape (k,)
        Axial force of the teeth on the driven gear [N], opposite on the driver; zero of spur gears.
    friction_force : ndarray, shape (k,)
        Friction of all pairs on the driven gear [N], across the line of action of the pressed
        flanks, positive from the centre of the driver to its tangent point.
    friction_power : ndarray, shape (k,)
        Power that the friction dissipates [W].
    contact : ndarray of int8, shape (k,)
        Flanks in contact, as values of `gearbow.results.Contact`: 0 none, 1 drive, 2 back, 3 both.
        They follow from the exact events. `Response.contact_shares` gives shares of the time.

    Examples
    --------
    >>> import gearbow as gb
    >>> run = gb.examples()["geared_pair"].load().simulate(1e-3, 100.0)
    >>> print(f"{run.mesh('pinion/wheel').force.mean():.0f} N")
    1429 N
    """

    deflection: Array
    force: Array
    stiffness: Array
    pressure_angle: Array
    centre_distance: Array
    centre_line_angle: Array
    contact_ratio: Array
    pairs_in_contact: Array
    thrust: Array
    friction_force: Array
    friction_power: Array
    contact: NDArray[np.int8]


@dataclass(frozen=True)
class Statistics(Shown):
    """Counts and step lengths of a simulation.

    Parameters
    ----------
    steps, rejected, evaluations, events : int
        Numbers of steps, of rejected ones, of evaluations, and of contact changes that end a step.
    step_min, step_max : float
        Lengths of the shortest and of the longest step [s].
    omega_max : float
        Highest undamped natural frequency of the model [rad/s].
    limited_by : {"step", "stability", "tolerance"}
        What limited most steps.
    condition : float
        Condition number of the modes; NaN if the method does not use modes.
    modes : int or None
        Number of modes that a reduced model keeps.
    modes_error : tuple of float or None
        Estimated error of displacements and of mesh forces from the reduction to these modes.

    Examples
    --------
    >>> import gearbow as gb
    >>> run = gb.examples()["bowed_rotor"].load().simulate(0.01, 100.0, record=[])
    >>> isinstance(run.statistics, gb.results.Statistics), run.statistics.events
    (True, 0)
    """

    steps: int
    rejected: int
    evaluations: int
    events: int
    step_min: float
    step_max: float
    omega_max: float
    limited_by: str
    condition: float
    modes: int | None = None
    modes_error: tuple[float, float] | None = None

    def __getitem__(self, name: str) -> Any:
        return getattr(self, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.__dataclass_fields__)


def contact_at(times: Array, events: Sequence[Event], first: Contact) -> NDArray[np.int8]:
    """Find the contact of a mesh at given times."""
    changes, states = _changes(events)
    after = np.array([first, *states], dtype=np.int8)
    return after[np.searchsorted(changes, times, side="right")]


def shares(begin: float, end: float, events: Sequence[Event], first: Contact) -> ContactShares:
    """Find the share of each state of contact between two times."""
    changes, _ = _changes(events)
    bounds = np.concatenate([[begin], changes[(changes > begin) & (changes < end)], [end]])
    lengths = np.diff(bounds)
    weights = lengths / (end - begin) if end > begin else np.ones(1)
    found = contact_at(bounds[:-1], events, first)
    total = np.bincount(found, weights=weights, minlength=len(Contact))
    return ContactShares(
        **{name: float(total[Contact[name.upper()]]) for name in ("drive", "back", "both", "none")}
    )


def first_contact(
    time: Array, mesh: Mapping[str, Array], events: Sequence[Event], scene: "MeshScene | None"
) -> Contact:
    """Find the contact before the first change, which no event tells."""
    changes, _ = _changes(events)
    before = int(np.searchsorted(time, changes[0])) if changes.size else time.size
    if before == 0 or (scene is not None and scene.backlash is None):
        return Contact.DRIVE
    at = {name: float(values[before - 1]) for name, values in mesh.items()}
    if at["stiffness"] == 0.0:
        return Contact.NONE
    if scene is None:
        return Contact.DRIVE if at["force"] >= 0.0 else Contact.BACK
    if scene.back_deflection(at) > 0.0:
        return Contact.BOTH if at["deflection"] > 0.0 else Contact.BACK
    return Contact.DRIVE


@dataclass(frozen=True)
class MeshScene(Shown):
    """Backlash of a mesh, and what lets it change with the centre distance."""

    backlash: float | None
    centre_distance: float
    pressure_angle: float
    base_helix_cosine: float
    #: Whether a gear is internal, so that the clearance of the flanks shrinks with the distance.
    internal: bool
    frozen: bool

    @classmethod
    def of(cls, request: RunRequest, driver: str, driven: str) -> "MeshScene":
        """Take the data of one mesh from the scene of a run."""
        plain = {entry["name"]: entry for entry in request.description["gears"]}
        gear: Gear = Gear._from_description(plain[driver])
        pairs = [(entry["driver"], entry["driven"]) for entry in request.description["meshes"]]
        index = pairs.index((driver, driven))
        at_rest = mesh_geometry(request.description)[index]
        return cls(
            request.description["meshes"][index].get("backlash"),
            at_rest["centre_distance"],
            at_rest["pressure_angle"],
            math.sqrt(1.0 - (math.sin(gear.helix_angle) * math.cos(gear.pressure_angle)) ** 2),
            sum(at_rest["base_radii"]) < 0.0,
            request.options.get("geometry") == "frozen",
        )

    def back_deflection(self, at: Mapping[str, float]) -> float:
        """Find the deflection of the back flanks, positive in contact."""
        distance, angle, rest = at["centre_distance"], at["pressure_angle"], self.pressure_angle
        if self.frozen:
            longer = math.sin(rest) * (distance - self.centre_distance)
        else:
            involute = math.tan(angle) - angle - math.tan(rest) + rest
            longer = distance * math.cos(angle) * involute
        wider = -2.0 * longer if self.internal else 2.0 * longer
        return -at["deflection"] - (self.backlash or 0.0) - wider * self.base_helix_cosine


def _changes(events: Sequence[Event]) -> tuple[Array, list[Contact]]:
    """Give the times at which the contact changes, and the contact after each."""
    changes = [event for event in events if event.kind in _AFTER]
    changes.sort(key=lambda event: event.time)
    return np.array([event.time for event in changes]), [_AFTER[each.kind] for each in changes]
