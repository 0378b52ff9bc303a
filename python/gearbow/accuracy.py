"""Accuracy levels of runs, and the error of a run estimated by more accurate runs."""

import math
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, cast

import numpy as np

from gearbow._core import SHARE_OF_MEAN, Model, accuracy_levels, user_order
from gearbow._times import grid
from gearbow._types import Accuracy, Array, Plain, RunData
from gearbow.description.speed import SpeedProfile, read_speed
from gearbow.errors import AccuracyWarning, ConvergenceError, SceneError, warn
from gearbow.recording.channels import signals
from gearbow.recording.record import ErrorEstimate, Errors, Event, RunRequest

#: What happens at events after which an impact follows.
CHANGES_OF_CONTACT = {"separation": "flanks separated", "tight": "both flanks touched"}


class Reduction(Protocol):
    """Number of modes that runs keep, and the error of displacements and mesh forces."""

    @property
    def modes(self) -> int | None:
        """Number of modes."""

    @property
    def modes_error(self) -> tuple[float, float] | None:
        """Estimated errors."""


@dataclass(frozen=True)
class Level:
    """An accuracy level."""

    name: Accuracy
    rtol: float
    displacement: float
    mesh_force: float

    def explanation(self, events: Iterable[Event], coarse: str | None) -> str:
        """Say what the level promises for a run."""
        sentence = (
            f"{self.name}: total error at most {self.displacement:.0e} of the RMS about the mean "
            f"of displacements and {self.mesh_force:.0e} of mesh forces (where the RMS is below "
            f"{SHARE_OF_MEAN:.0%} of the mean, of this share), over the first 0.1 s or the time "
            "that damping needs to forget; afterwards the error applies to RMS values and "
            f"spectra; rtol {self.rtol:.0e}"
        )
        if coarse is not None:
            sentence += f"; this promise does not include the elements: {coarse}"
        kinds = {event.kind for event in events}
        contact = [text for kind, text in CHANGES_OF_CONTACT.items() if kind in kinds]
        if contact:
            sentence += (
                f"; {' and '.join(contact)} in this run, and impacts can amplify small "
                "differences: after chaotic contact the error holds neither for the time history "
                "nor for spectra (`errors` tells whether the contact is chaotic)"
            )
        return sentence

    def is_stricter(self, other: "Level") -> bool:
        """Tell whether this level permits smaller errors than another one."""
        return self.mesh_force < other.mesh_force

    def coarse(self, model: Model, speed: float | None) -> str | None:
        """Say why the elements of a system are too coarse for the level."""
        permitted = self.mesh_force if model.has_meshes else self.displacement
        expected = model.expected_error()
        if expected > permitted:
            reason = (
                "the shafts give their numbers"
                if model.choice is None
                else "they have the largest number of coordinates that gearbow chooses"
            )
        elif speed is not None and model.expected_error(speed) > permitted:
            expected = model.expected_error(speed)
            reason = f"the teeth excite natural frequencies at {speed:g} rad/s"
        else:
            return None
        return f"{reason}, and an expected error of {expected:.0e}"

    def finer(self, model: Model, accuracy: str) -> str:
        """Say how a system of an accuracy gets elements that are fine enough for the level."""
        if model.choice is None:
            return "leave out the numbers of elements"
        finer = [name for name in LEVELS if LEVELS[name].is_stricter(LEVELS[accuracy])]
        more = f"call system.replace(accuracy={finer[0]!r}), or " if finer else ""
        advice = "compare `response.errors()`, which often is below it"
        return f"{advice}, or {more}give the shafts elements"


#: Accuracy levels by name, from cheap to accurate; `src/scene/accuracy.rs` contains the numbers.
LEVELS = {
    name: Level(cast("Accuracy", name), **numbers) for name, numbers in accuracy_levels().items()
}
#: Accuracy of a system for which none is given.
DEFAULT: Accuracy = "engineering"


def find_level(name: object, accuracy: str, given: Mapping[str, Any]) -> Level | None:
    """Find the accuracy level of a run of a system with an accuracy, which a run may loosen."""
    other = next((option for option, value in given.items() if value is not None), None)
    if name is None:
        return LEVELS[accuracy] if other is None else None
    if not isinstance(name, str) or name not in LEVELS:
        raise SceneError(f"accuracy: must be one of {', '.join(LEVELS)}, got {name!r}")
    if other is not None:
        raise SceneError(f"accuracy: cannot be given together with {other}")
    if LEVELS[name].is_stricter(LEVELS[accuracy]):
        raise SceneError(
            f"accuracy: {name!r} is stricter than {accuracy!r}, the accuracy of the system, which "
            f"decides its elements; run system.replace(accuracy={name!r})"
        )
    return LEVELS[name]


def tolerance(options: Mapping[str, Any]) -> float | None:
    """Give the tolerance of a run: the given one, or that of its accuracy level."""
    accuracy = options["accuracy"]
    rtol: float | None = options["rtol"]
    return LEVELS[accuracy].rtol if rtol is None and accuracy is not None else rtol


def check_reduction(statistics: Reduction, level: Level, *, given: bool) -> None:
    """Warn if the error of a reduction to fewer modes exceeds an accuracy level."""
    if statistics.modes_error is None:
        return
    kinds = ("displacements", "mesh forces")
    permitted = (level.displacement, level.mesh_force)
    cure = (
        "keep more modes, or leave out modes"
        if given
        else "give rtol instead of accuracy, which keeps all modes, for example "
        f"rtol={level.rtol / 100:.0e}"
    )
    for kind, error, most in zip(kinds, statistics.modes_error, permitted, strict=True):
        if error > most:
            message = (
                f"{'modes' if given else 'accuracy'}: {statistics.modes} modes leave an error of "
                f"{error:.1e} in {kind}, above {most:.0e} of accuracy {level.name!r}; {cure}"
            )
            warn(message, AccuracyWarning)


#: The unit in the words of tables and figures.
UNIT_OF_ERRORS = "RMS of the signal about its mean, at least 2 % of the mean"
#: A signal varies if its variation exceeds this fraction of its RMS: round-off varies less.
_VARIES = 1e-9


def unit_of_errors(values: Array) -> float:
    """Give the number by which the RMS of a difference is divided."""
    mean = float(np.linalg.norm(values.mean(axis=0)))
    return max(root_mean_square(values - values.mean(axis=0)), SHARE_OF_MEAN * mean)


def variation(values: Array) -> float:
    """Give the RMS of a signal about its mean; 0 if it is constant to round-off."""
    found = root_mean_square(values - values.mean(axis=0))
    return found if found > _VARIES * root_mean_square(values) else 0.0


def root_mean_square(values: Array) -> float:
    """Give the root mean square over time of the vector length."""
    return float(np.sqrt(np.mean(np.sum(values**2, axis=1))))


#: Recorded rates of displacements.
_RATES = ("velocity", "acceleration")
#: Shortest time over which errors are averaged, if the run is long enough [s].
_WINDOW = 0.1
#: Longest time over which errors are averaged [s]. Damping that needs more time counts as none.
_LONGEST = 1.0
#: Number of time constants after which damping has reduced a motion to 5 %.
_FORGET = 3.0
#: A mode takes part in the motion if gears or disks move by this fraction of its largest motion.
_MOVES = 0.01
#: Fewest compared samples.
_SAMPLES = 500
#: Factor between the tolerances of the run and of its companions. The error is about proportional
#: to the tolerance, so that 1 % of the error remains in the companion.
_TIGHTER = 0.01
#: Tolerance of the companion of a run with another method or with fixed steps.
_OTHER_METHOD = 1e-9
#: Tolerance of a run with a method and without a tolerance.
_DEFAULT_RTOL = 1e-6
#: Smallest tolerance that round-off permits.
_SMALLEST = 1e-13
#: Differences above this fraction of the signal are of its size.
_LARGE = 0.3
#: Smallest growth of the difference between two models, from the first to the last quarter of the
#: window, that shows chaotic motion. A phase error of undamped modes, which is proportional to
#: time, grows by a factor 6. The difference between two tolerances needs no growth: it is far below
#: the size of the signal unless the motion is chaotic.
_GROWTH = 15.0


@dataclass(frozen=True)
class _Signal:
    """A recorded signal: its kind, and its values (k, components)."""

    kind: str
    values: Array


def estimate_errors(request: RunRequest, modes: int | None) -> Errors:
    """Estimate the errors of a run by more accurate runs."""
    model = Model(dict(request.description))
    options = dict(request.options)
    window = _window(model, options)
    # A run as short as the window would keep all modes.
    options |= {"duration": window, "modes": modes or options["modes"]}
    with warnings.catch_warnings():
        # The run itself gave these warnings.
        warnings.simplefilter("ignore", AccuracyWarning)
        times = _times(model, options)
        check_initial_state(model, options)
        runs = list(_runs(request, model, options, times))
    own, exact, complete, fine = (_signals(run) for run in runs)
    estimates = {}
    for kind in dict.fromkeys(signal.kind for signal in fine):
        rows = [
            (a, b, c, d)
            for a, b, c, d in zip(own, exact, complete, fine, strict=True)
            if d.kind == kind and variation(d.values) > 0.0
        ]
        if rows:
            estimates[kind] = ErrorEstimate(
                elements=max(_difference(c, d, d) for _, _, c, d in rows),
                modes=max(_difference(b, c, d) for _, b, c, d in rows),
                integration=max(_difference(a, b, d) for a, b, _, d in rows),
                total=max(_difference(a, d, d) for a, _, _, d in rows),
            )
    contact = any(event[3] in {"separation", "back contact"} for event in runs[0]["events"])
    chaotic = contact and any(
        _diverges(a, b, 1.0) or _diverges(a, d, _GROWTH)
        for a, b, d in zip(own, exact, fine, strict=True)
        if d.kind not in _RATES
    )
    return Errors(estimates, window=window, chaotic=chaotic)


def _runs(
    request: RunRequest, model: Model, options: dict[str, Any], times: Array
) -> Iterator[RunData]:
    """Run the given settings, then the companions, each more accurate than the run before."""
    own = _run(model, options, times, _recorded(request))
    yield own
    record = _items(own)
    exact = {**options, **_tighter(options)}
    run = _run(model, exact, times, record)
    yield run
    complete = {**exact, "modes": None}
    if options["modes"] is not None:
        run = _run(model, complete, times, record)
    yield run
    fine = Model(refined(model.resolved()))
    yield _run(
        fine, {**complete, "initial": _embedded(fine, model, options["initial"])}, times, record
    )


def _run(model: Model, options: Mapping[str, Any], times: Array, record: list[Any]) -> RunData:
    given: Any = {**options, "record": record}
    return model.simulate(**given, times=times, checkpoint=None, progress=None)


def _embedded(fine: Model, model: Model, initial: Any) -> Any:
    """Give the initial state of a run in the coordinates of a model of higher degree."""
    if not isinstance(initial, Mapping):
        return initial
    state = fine.embed(model, initial["state"])
    return {**initial, "state": state, "memory": np.empty(0), "carry": 0.0}


def _recorded(request: RunRequest) -> list[Any]:
    """Give what the run recorded, without the energy."""
    return [item for item in request.options["record"] if item != "energy"]


def _items(data: RunData) -> list[Any]:
    """Give the recorded places, meshes and rates, which exist in a finer model."""
    places = [names[0] if names else (shaft, x) for shaft, x, names in data["points"]]
    return [*places, *data["meshes"], *(name for name in _RATES if name in data)]


def _tighter(options: Mapping[str, Any]) -> dict[str, Any]:
    """Choose the method and the tolerance of the companions."""
    rtol = _OTHER_METHOD
    if options["method"] == "exponential" and options["step"] is None:
        rtol = max(_SMALLEST, _TIGHTER * (tolerance(options) or _DEFAULT_RTOL))
    return {"method": "exponential", "rtol": rtol, "step": None, "stages": None, "accuracy": None}


def _window(model: Model, options: Mapping[str, Any]) -> float:
    """Find the time over which errors are averaged [s]."""
    duration: float = options["duration"]
    if duration <= _WINDOW:
        return duration
    return min(duration, max(_WINDOW, _memory(model, options)))


def _memory(model: Model, options: Mapping[str, Any]) -> float:
    """Find the time that damping needs to forget [s]; 0 if it needs more than 1 s."""
    speed = options["speed"]
    data = model.modes(speed if isinstance(speed, float) else 0.0)
    description = model.description()
    bodies = [body["name"] for key in ("gears", "disks") for body in description.get(key, ())]
    indices = [i for name in bodies for i in model.indices(name) if i is not None]
    shapes = np.abs(data["shapes"])
    moves = np.ones(len(shapes), bool)
    if indices:
        moves = shapes[:, indices].max(axis=1) > _MOVES * shapes.max(axis=1)
    decay = -data["eigenvalues"].real[moves & (data["frequencies_hz"] > 0.0)]
    slowest = decay.min(initial=math.inf)
    return _FORGET / slowest if slowest > _FORGET / _LONGEST else 0.0


def _times(model: Model, options: Mapping[str, Any]) -> Array:
    """Choose the compared instants."""
    window, speed, begin = options["duration"], options["speed"], options["start"]
    step = model.default_output_step(window, speed, begin)
    return grid(begin, window, min(step, window / _SAMPLES) if window > 0.0 else step)


def _signals(data: RunData) -> list[_Signal]:
    """Collect displacements, their recorded rates, and mesh forces."""
    arrays = signals(data)
    moved = [
        _Signal(kind, arrays[kind][:, i])
        for kind in ("displacement", *_RATES)
        if kind in arrays
        for i in range(len(data["points"]))
    ]
    forces = [
        _Signal("mesh_force", arrays["mesh_force"][:, [i]]) for i in range(len(data["meshes"]))
    ]
    return moved + forces


def _difference(first: _Signal, second: _Signal, scale: _Signal) -> float:
    """Give the RMS of a difference relative to the unit of the errors of a signal."""
    return root_mean_square(first.values - second.values) / unit_of_errors(scale.values)


def _diverges(own: _Signal, other: _Signal, growth: float) -> bool:
    """Tell whether a difference grows by a factor in the window, to the size of the signal."""
    size = variation(other.values)
    if not size > 0.0:
        return False
    parts = np.array_split(own.values - other.values, 4)
    first, *_, last = (root_mean_square(part) for part in parts)
    return last > max(_LARGE * size, growth * first)


#: Largest degree of an element. The core uses the same value.
MAX_DEGREE = 8


def refined(description: Mapping[str, Plain]) -> dict[str, Plain]:
    """Increase the degree of the elements of every shaft."""
    return {**description, "shafts": [_shaft(shaft) for shaft in description["shafts"]]}


def _shaft(shaft: Mapping[str, Any]) -> dict[str, Any]:
    degree = shaft.get("degree", 1)
    if degree < MAX_DEGREE:
        return {**shaft, "degree": 3 if degree == 1 else degree + 1}
    if "segments" not in shaft:
        return _divided(shaft)
    return {**shaft, "segments": [_divided(segment) for segment in shaft["segments"]]}


def _divided(part: Mapping[str, Any]) -> dict[str, Any]:
    return {**part, "elements": 2 * part.get("elements", 1)}


#: Largest residual of the equations of an initial state, relative to their loads, and largest
#: difference of the state from the motion that it consists of, relative to this motion. Equilibria
#: and responses are accurate to 1e-9 or better; the smallest promised error is 1e-6.
_LIMIT = 1e-6


def check_initial_state(model: Model, options: Mapping[str, Any]) -> None:
    """Check that the initial state of a run satisfies its equations."""
    initial, begin = options["initial"], options["start"]
    if not isinstance(initial, str) or initial == "rest":
        return
    profile = read_speed(options["speed"])
    speed = float(profile(begin)) if isinstance(profile, SpeedProfile) else profile
    static = model.static(options["geometry"], speed)
    unbalanced = [residual for _, residual in static["residuals"]]
    _check("the forces at the static equilibrium do not balance", speed, unbalanced)
    motion = [static["state"], np.zeros_like(static["state"])]
    if initial == "synchronous":
        response = model.synchronous(np.array([speed]), "both", 1)
        problem = "the synchronous response does not satisfy the equations of motion"
        _check(problem, speed, response["residuals"])
        spins = speed * model.speed_ratios
        angle = profile.angle(begin) if isinstance(profile, SpeedProfile) else speed * begin
        phasors = np.exp(1j * model.speed_ratios * angle)
        moving = phasors[:, np.newaxis] * response["phasors"][0]
        motion[0] = motion[0] + moving.real.sum(axis=0)
        motion[1] = -(spins[:, np.newaxis] * moving.imag).sum(axis=0)
    state = _state(model, options)
    for found, exact in zip(np.split(state, 2), motion, strict=True):
        size = np.abs(exact).max(initial=0.0)
        difference = np.abs(found - exact).max(initial=0.0)
        problem = f"the state is not the motion {initial!r} that it stands for"
        _check(problem, speed, difference / size if size > 0.0 else difference)


def _state(model: Model, options: Mapping[str, Any]) -> Array:
    """Give the displacements and velocities with which a run of all modes begins."""
    given: Any = {**options, "duration": 0.0, "modes": None, "accuracy": None, "record": []}
    times = np.array([options["start"]])
    run = model.simulate(**given, times=times, checkpoint=None, progress=None)
    return user_order(model, run["final"]["state"])


def _check(problem: str, speed: float, residuals: Any) -> None:
    """Refuse residuals above the limit, and those that are no numbers."""
    residual = float(np.max(residuals, initial=0.0))
    if not residual <= _LIMIT:
        raise ConvergenceError(
            f"initial: {problem} at {speed:g} rad/s: the residual is {residual:.1e}, above "
            f"{_LIMIT:.0e}; give another initial state, for example initial='rest'"
        )
