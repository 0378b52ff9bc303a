"""Costs of gearbow that other programs have no equivalent of: further calls on one system."""

import functools
import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

import gearbow as gb
from programs.scenes import BOW, MEAN, SMOOTH, SPEED, SQUARE, STAGES, TORQUE, TRAIN, geared
from programs.timing import timed

#: A measurement that can be repeated, and the error of the run that it measures.
Prepared: TypeAlias = tuple[Callable[[], float], float | None]

RAMP = gb.SpeedProfile.ramp(100.0, 175.0, 0.5)  # 150 rad/s²
RUN_UP = 0.5  # duration of the compared run-ups, s
CHECKED = 0.02  # part of a run that is compared with a reference, s
RATE = 51200.0  # of the samples, Hz
GEARS = ("g1", "g2", "g3", "g4")
MESHES = (("g1", "g2"), ("g3", "g4"))


@dataclass(frozen=True)
class Call:
    """A call and its unit."""

    title: str
    unit: str
    prepare: Callable[[], Prepared]


def cost(run: Callable[[], Any]) -> float:
    """Return the CPU time of a run [s]."""
    return timed(lambda: run)[1]


def train(stiffness: gb.Stiffness = SMOOTH, **options: Any) -> gb.RotorSystem:
    """Return the double-stage train of the scenes."""
    return geared(TRAIN, STAGES, stiffness, 0.05, **options)


def study_train(modal_damping: float | None) -> gb.RotorSystem:
    """Return the train of docs/study.md with bowed shafts."""
    path = Path(__file__).parents[2] / "examples" / "machines" / "double_stage_train.toml"
    system = gb.RotorSystem.load(path)
    shafts = [replace(shaft, bow=gb.Bow.half_sine(BOW)) for shaft in system.shafts]
    return system.replace(shafts=shafts, modal_damping=modal_damping)


def error(system: gb.RotorSystem, found: gb.Response, speed: Any, **options: Any) -> float:
    """Return the error of the gear displacements, relative to their motion about the mean."""
    exact = system.simulate(
        float(found.time[-1]), speed, method="rk45", rtol=1e-9, times=found.time, **options
    )
    pairs = [(found.displacement(gear), exact.displacement(gear)) for gear in GEARS]
    return max(float(np.linalg.norm(a - b) / np.linalg.norm(b - b.mean(axis=0))) for a, b in pairs)


def warm() -> Prepared:
    """Simulate 1 ms, again and again."""
    system = train()
    run = functools.partial(system.simulate, 1e-3, SPEED)
    return lambda: 1e3 * cost(run), error(system, run(), SPEED)


def torque() -> Prepared:
    """Simulate 1 ms with another torque each time."""
    system, values = train(), itertools.count(1)
    system.simulate(1e-3, SPEED)

    def changed() -> gb.RotorSystem:
        return with_torque(system, TORQUE * (1.0 + 1e-3 * next(values)))

    other = changed()
    return (
        lambda: 1e3 * cost(lambda: changed().simulate(1e-3, SPEED)),
        error(other, other.simulate(1e-3, SPEED), SPEED),
    )


def speed() -> Prepared:
    """Simulate 1 ms at another speed each time."""
    system, values = train(), itertools.count(1)
    system.simulate(1e-3, SPEED)

    def run() -> gb.Response:
        return system.simulate(1e-3, SPEED * (1.0 + 1e-3 * next(values)))

    other = 1.5 * SPEED
    return lambda: 1e3 * cost(run), error(system, system.simulate(1e-3, other), other)


def with_torque(system: gb.RotorSystem, value: float) -> gb.RotorSystem:
    """Return a train with another torque."""
    return system.replace(torques=[gb.Torque("g1", value), gb.Torque.balance("g4")])


def part(
    work: Callable[[gb.RotorSystem, float], Any], *, torque: bool = False
) -> Callable[[], Prepared]:
    """Measure a part of the set-up at another speed, or with another torque, each time."""

    def prepare() -> Prepared:
        system, values = train(), itertools.count(1)
        first(system, SPEED)

        def measured() -> float:
            factor = 1.0 + 1e-3 * next(values)
            if not torque:
                return 1e3 * cost(lambda: work(system, factor * SPEED))
            other = with_torque(system, factor * TORQUE)
            return 1e3 * cost(lambda: work(other, SPEED))

        return measured, None

    return prepare


def first(system: gb.RotorSystem, speed: float) -> gb.Response:
    """Simulate 1 ms with two samples."""
    return system.simulate(1e-3, speed, output_step=1e-3)


def described() -> Prepared:
    """Describe and check a train with another torque."""
    system, values = train(), itertools.count(1)
    return lambda: 1e3 * cost(lambda: with_torque(system, TORQUE + next(values))), None


def warm_with(samples: int) -> Callable[[], Prepared]:
    """Simulate 1 ms with this number of samples, again and again."""

    def prepare() -> Prepared:
        system, times = train(), np.linspace(0.0, 1e-3, samples)
        return lambda: 1e3 * cost(lambda: system.simulate(1e-3, SPEED, times=times)), None

    return prepare


def samples() -> Prepared:
    """Record many samples, and hardly any."""
    system, duration = train(), 0.2
    run = functools.partial(system.simulate, duration, SPEED)
    count = round(RATE * duration)
    times = np.arange(count) / RATE

    def measured() -> float:
        more = cost(lambda: run(times=times)) - cost(lambda: run(output_step=duration))
        return 1e6 * more / count

    short = system.simulate(CHECKED, SPEED, times=times[times <= CHECKED])
    return measured, error(system, short, SPEED)


def energy(rtol: float) -> Prepared:
    """Record the energy beside gears and meshes, and do not."""
    system = train()
    run = functools.partial(system.simulate, CHECKED, SPEED, rtol=rtol, output_step=1e-4)
    record = ("gears", "meshes", "energy")
    exact = system.simulate(
        CHECKED, SPEED, method="rk45", rtol=1e-10, output_step=1e-4, record=record
    ).energy
    found = run(record=record).energy
    return (
        lambda: cost(lambda: run(record=record)) / cost(run),
        float(np.linalg.norm(found - exact) / np.linalg.norm(exact - exact.mean())),
    )


def step(geometry: str) -> Prepared:
    """Simulate fixed steps with two stages."""
    system = train()
    options: dict[str, Any] = {
        "method": "exponential",
        "step": 2e-5,
        "stages": 2,
        "geometry": geometry,
    }

    def measured() -> float:
        counts, costs = [], []
        for duration in (0.1, 0.3):
            run = functools.partial(
                system.simulate, duration, SPEED, output_step=duration, **options
            )
            counts.append(run().statistics.steps)
            costs.append(cost(run))
        return 1e6 * (costs[1] - costs[0]) / (counts[1] - counts[0])

    short = system.simulate(CHECKED, SPEED, output_step=1e-4, **options)
    return measured, error(system, short, SPEED, geometry=geometry)


def events() -> Prepared:
    """Simulate sharp engagement, and constant stiffness without events, at a loose tolerance."""
    options: dict[str, Any] = {"rtol": 0.1, "stages": 2}
    runs = [
        functools.partial(system.simulate, 0.3, SPEED, output_step=0.3, **options)
        for system in (train(SQUARE), train(MEAN))
    ]
    count = runs[0]().statistics.events
    short = train(SQUARE).simulate(CHECKED, SPEED, output_step=1e-4, **options)
    return (
        lambda: 1e6 * (cost(runs[0]) - cost(runs[1])) / count,
        error(train(SQUARE), short, SPEED),
    )


def run_up(build: Callable[[], gb.RotorSystem]) -> Prepared:
    """Simulate a run-up, and the same time at its mean speed."""
    system = build()
    change = functools.partial(system.simulate, RUN_UP, RAMP)
    steady = functools.partial(system.simulate, RUN_UP, 137.5)
    short = system.simulate(CHECKED, RAMP, output_step=1e-4)
    return lambda: cost(change) / cost(steady), error(system, short, RAMP)


CALLS = (
    Call("1 ms of a train, n = 240, repeated", "ms", warm),
    Call("1 ms after a change of the torque", "ms", torque),
    Call("1 ms after a change of the speed", "ms", speed),
    Call("a recorded sample, at 51.2 kHz", "µs", samples),
    Call("a step, two stages, frozen geometry", "µs", functools.partial(step, "frozen")),
    Call("a step, two stages, live geometry", "µs", functools.partial(step, "live")),
    Call("an event of sharp engagement, at `rtol=0.1`", "µs", events),
    Call("energy recorded / not recorded, at `rtol=1e-3`", "", functools.partial(energy, 1e-3)),
    Call("energy recorded / not recorded, at `rtol=1e-6`", "", functools.partial(energy, 1e-6)),
    Call(
        "run-up / constant speed, train of the study, 2 % modal damping",
        "",
        functools.partial(run_up, functools.partial(study_train, 0.02)),
    ),
    Call(
        "run-up / constant speed, without modal damping",
        "",
        functools.partial(run_up, functools.partial(study_train, None)),
    ),
    Call(
        "run-up / constant speed, train with elements of 2 mm",
        "",
        functools.partial(run_up, functools.partial(train, seats=True)),
    ),
)
SETUP = (
    Call("1 ms, repeated, 2 samples", "ms", warm_with(2)),
    Call("1 ms, repeated, 1001 samples", "ms", warm_with(1001)),
    Call("description of a system with another torque", "ms", described),
    Call(
        "static equilibrium with another torque",
        "ms",
        part(lambda system, speed: system.static(speed=speed), torque=True),
    ),
    Call(
        "synchronous motion with another torque",
        "ms",
        part(lambda system, speed: system.synchronous([speed]), torque=True),
    ),
    Call("1 ms with another torque, 2 samples", "ms", part(first, torque=True)),
    Call(
        "all modes at another speed",
        "ms",
        part(lambda system, speed: system.modes(speed)),
    ),
    Call("1 ms at another speed, 2 samples", "ms", part(first)),
)
