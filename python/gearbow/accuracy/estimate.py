"""The error of a run, estimated by runs with smaller tolerances, all modes and finer elements.

Each of these companion runs removes one cause of error, from the same initial state:

1. the same system with a much smaller tolerance: without the integration error,
2. with all modes, if the run left out some: without the error of the modes,
3. with finer elements: without the error of the elements.

The difference between one run and the next is the contribution of one cause, and the difference
between the given run and the last companion is the total error. All of them would share a wrong
initial state, so that this state is checked against its own equations first.
"""

import math
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gearbow._core import Model
from gearbow._times import grid
from gearbow._types import Array, RunData
from gearbow.accuracy.initial import check_initial_state
from gearbow.accuracy.levels import tolerance
from gearbow.accuracy.refine import refined
from gearbow.accuracy.scale import root_mean_square, unit_of_errors, variation
from gearbow.errors import AccuracyWarning
from gearbow.recording.channels import signals
from gearbow.recording.record import ErrorEstimate, Errors, RunRequest

__all__ = ["estimate_errors"]

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
