"""Compare the cost of steady states with that of running in, as a table for docs/steady.md.

Both begin at the same state and have the same tolerance. Running in ends at the first period whose
signals differ from the steady state by at most the stated error (RMS of the difference / RMS of the
signal about its mean, for the worst displacement of a gear or mesh force). The times are CPU times
of one process. `python benches/steady.py` takes some minutes; --quick leaves out 0.2 % damping.
--continuation prints a second table instead: the cost of a point of a branch over that of a steady
state, and its number of periods without those of the multipliers.
"""

import argparse
import importlib.util
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import gearbow as gb
from gearbow import _core
from gearbow._types import BranchParameter
from gearbow.system import continuation

GEARS = ("g1", "g2", "g3", "g4")
PAIRS = (("g1", "g2"), ("g3", "g4"))
MAX_PERIODS = 700
#: Number of points of a branch that passes a fold.
NEAR_FOLD = 30


def demo() -> gb.RotorSystem:
    """Return the train of examples/bowed_train.py."""
    path = Path(__file__).parents[1] / "examples" / "bowed_train.py"
    spec = importlib.util.spec_from_file_location("bowed_train", path)
    assert spec is not None
    assert spec.loader is not None
    example: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    found: gb.RotorSystem = example.train(0.05 * example.RADIUS)
    return found


def smooth(system: gb.RotorSystem) -> gb.RotorSystem:
    """Return the train with tooth pairs that engage smoothly, over a fifth of the base pitch."""
    stiffness = gb.Stiffness.square(1.5e8, engagement=0.2)
    return system.replace(meshes=[replace(mesh, stiffness=stiffness) for mesh in system.meshes])


def study() -> gb.RotorSystem:
    """Return the train of the bow study."""
    path = Path(__file__).parents[1] / "examples" / "machines" / "double_stage_train.toml"
    return gb.RotorSystem.load(path)


def signals(response: gb.Response) -> list[Any]:
    """Return the compared signals."""
    motion = [response.displacement(gear) for gear in GEARS]
    return [*motion, *(response.mesh(pair).force for pair in PAIRS)]


def difference(found: gb.Response, exact: list[Any]) -> float:
    """Return the error of the worst signal."""
    pairs = zip(signals(found), exact, strict=True)
    return max(
        float(np.sqrt(np.mean((a - b) ** 2) / np.mean((b - b.mean(axis=0)) ** 2))) for a, b in pairs
    )


def row(
    name: str, system: gb.RotorSystem, speed: float, error: float, options: dict[str, Any]
) -> list[str]:
    """Measure one case."""
    system.simulate(1e-3, speed, **options)  # modes and propagators belong to both
    begin = time.process_time()
    steady = system.steady_state(speed, initial="static", **options)
    cost = time.process_time() - begin
    exact, count = signals(steady.response), steady.response.time.size
    last: Any = "static"
    begin = time.process_time()
    for periods in range(1, MAX_PERIODS + 1):
        start = (periods - 1) * steady.period
        times = start + np.arange(count) * steady.period / count
        if not isinstance(last, str):
            times += last.final["time"] - start
        last = system.simulate(steady.period, speed, initial=last, times=times, **options)
        if difference(last, exact) <= error:
            break
    run_in = time.process_time() - begin
    reached = periods < MAX_PERIODS
    return [
        name,
        f"{speed:g}",
        options["geometry"],
        f"{error:.0e}",
        str(steady.periods),
        f"{periods}" if reached else f"> {periods}",
        f"{cost:.2f}",
        f"{run_in:.2f}",
        f"{run_in / cost:.1f}",
    ]


def branch_row(
    name: str,
    system: gb.RotorSystem,
    parameter: BranchParameter,
    interval: tuple[float, float],
    speed: float,
    *,
    rtol: float | None = 1e-8,
    count: int = 8,
) -> list[str]:
    """Measure the points of a branch; the speed is that of its start."""
    begin = time.process_time()
    steady = system.steady_state(speed, initial="static", rtol=rtol)
    alone = time.process_time() - begin
    periods = [0]
    correct: Any = _core.corrected_states

    def counted(model: Any, *, states: Any, levels: Any, **options: Any) -> Any:
        # Without levels, one more period chooses them.
        periods[0] += len(states) + (levels is None)
        return correct(model, states=states, levels=levels, **options)

    fixed = None if parameter == "speed" else speed
    begin = time.process_time()
    with (
        mock.patch.object(continuation, "corrected_states", counted),
        warnings.catch_warnings(),
    ):
        # The branch ends after a few points.
        warnings.simplefilter("ignore", gb.AccuracyWarning)
        branch = system.continuation(parameter, *interval, speed=fixed, rtol=rtol, max_points=count)
    points = branch.values.size
    cost = (time.process_time() - begin - alone) / points
    return [
        name,
        parameter,
        f"{speed:g}",
        str(2 * len(system.dofs)),
        f"{steady.periods}",
        f"{periods[0] / points:.1f}",
        f"{alone:.2f}",
        f"{cost:.2f}",
        f"{cost / alone:.1f}",
    ]


def branches() -> None:
    """Print the table of branches."""
    head = ["train, damping", "parameter", "speed [rad/s]", "states", "periods of a steady state"]
    head += ["of a point", "steady state [s]", "point [s]", "ratio"]
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    one, two = demo().replace(modal_damping=0.01), study().replace(modal_damping=0.02)
    for name, system, speed in (("demo train, 1 %", one, 100.0), ("study train, 2 %", two, 1000.0)):
        intervals: dict[BranchParameter, tuple[float, float]] = {
            "speed": (speed, 1.3 * speed),
            "bow": (0.5, 2.0),
        }
        for parameter, interval in intervals.items():
            print("| " + " | ".join(branch_row(name, system, parameter, interval, speed)) + " |")
            sys.stdout.flush()
    new = gb.RotorSystem.load(Path(gb.__file__).parent / "cli" / "example.toml")
    # Near a fold, where the steps are small, at the accuracy of the system.
    row = branch_row(
        "new scene, 1 %", new, "speed", (300.0, 600.0), 300.0, rtol=None, count=NEAR_FOLD
    )
    print("| " + " | ".join(row) + " |")


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--quick", action="store_true", help="leave out 0.2 % damping")
    parser.add_argument("--continuation", action="store_true", help="measure branches")
    given = parser.parse_args()
    if given.continuation:
        branches()
        return
    quick: bool = given.quick
    cases: list[tuple[str, gb.RotorSystem, float, float, str, float]] = []
    one = demo().replace(modal_damping=0.01)
    cases += [("demo train, 1 %", one, 100.0, 1e-8, "frozen", 1e-10)]
    cases += [("demo train, 1 %", one, 100.0, 1e-6, "live", 1e-10)]
    teeth = smooth(one)
    for speed in (100.0, 300.0, 1000.0):
        for geometry in ("frozen", "live"):
            cases.append(("demo train, smooth teeth, 1 %", teeth, speed, 2e-6, geometry, 1e-7))
    for damping in (0.02,) if quick else (0.02, 0.002):
        damped = study().replace(modal_damping=damping)
        for speed in (100.0, 1000.0):
            for geometry in ("frozen", "live"):
                name = f"study train, {100 * damping:g} %"
                cases.append((name, damped, speed, 1e-6, geometry, 1e-8))
    head = ["train, damping", "speed [rad/s]", "geometry", "error"]
    head += ["periods", "run-in", "CPU time [s]", "run-in [s]", "ratio"]
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for name, system, speed, error, geometry, rtol in cases:
        options = {"rtol": rtol, "geometry": geometry}
        print("| " + " | ".join(row(name, system, speed, error, options)) + " |")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
