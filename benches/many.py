"""Print the cost of many runs of the train of the bow study: shared set-up, and two threads.

The runs differ in the torque and in the phases of the bows. The accuracy is "engineering", and the
sizes are two durations. `python benches/many.py` takes a minute on two idle cores; the argument
gives the number of runs. The share of the calling thread bounds the part of the work that threads
cannot share: it alone may hold the lock of the interpreter. With --wall, the wall-clock time of two
threads is compared with that of one, which needs two idle cores. With --profile, the parts of a run
with `simulate_many` are printed instead.
"""

import argparse
import itertools
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import gearbow as gb

SPEED = 100.0  # of the input shaft, rad/s
DURATIONS = (0.1, 1.0)  # s
SCALED = 1000  # runs
REPEATS = 2


def train() -> gb.RotorSystem:
    """Return the train of the bow study."""
    path = Path(__file__).parents[1] / "examples" / "machines" / "double_stage_train.toml"
    return gb.RotorSystem.load(path)


def variations(base: gb.RotorSystem, count: int) -> list[dict[str, Any]]:
    """Return torques and bow phases of each run."""
    found = []
    for number in range(count):
        shafts = [
            replace(shaft, bow=gb.Bow.half_sine(1.25e-3, phase=0.1 * number * place))
            for place, shaft in enumerate(base.shafts)
        ]
        torques = [gb.Torque("g1", 100.0 + 150.0 * number / count), gb.Torque.balance("g4")]
        found.append({"shafts": shafts, "torques": torques})
    return found


def measured(work: Callable[[], object]) -> tuple[float, float]:
    """Return CPU time and wall-clock time [s], each the shortest of the repetitions."""
    best = (float("inf"), float("inf"))
    for _ in range(REPEATS):
        cpu, wall = time.process_time(), time.perf_counter()
        work()
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        best = (min(best[0], cpu), min(best[1], wall))
    return best


def calling_share(base: gb.RotorSystem, changes: list[dict[str, Any]], duration: float) -> float:
    """Return the CPU time of the calling thread over that of the process."""
    cpu, own = time.process_time(), time.thread_time()
    for change in changes:
        base._variation(**change).simulate(duration, SPEED)
    cpu, own = time.process_time() - cpu, time.thread_time() - own
    return own / cpu


def row(duration: float, count: int, *, wall: bool) -> list[str]:
    """Measure runs of one duration."""
    base = train()
    changes = variations(base, count)

    def alone() -> None:
        for change in changes:
            plain = base.replace(**change).description
            gb.RotorSystem.from_dict(plain).simulate(duration, SPEED)

    def together(threads: int) -> Callable[[], object]:
        def work() -> None:
            with ThreadPoolExecutor(threads) as executor:
                # A system without modes of earlier calls.
                fresh = gb.RotorSystem.from_dict(base.description)
                fresh.simulate_many(changes, duration, SPEED, executor=executor)

        return work

    apart, _ = measured(alone)
    shared, one = measured(together(1))
    scale = SCALED / count
    cells = [
        f"{duration:g} s",
        f"{apart * scale:.0f} s",
        f"{shared * scale:.0f} s",
        f"{shared / apart:.2f}",
        f"{100.0 * calling_share(base, changes, duration):.0f} %",
    ]
    if wall:
        _, two = measured(together(2))
        cells.append(f"{two / one:.2f}")
    return cells


def profile(count: int) -> list[tuple[str, float]]:
    """Return the parts of a run of the longest duration with the mean of their CPU times [ms]."""
    duration = max(DURATIONS)
    base = train()
    changes = variations(base, count)
    base._variation(**changes[0]).simulate(duration, SPEED)  # modes of the system
    totals = dict.fromkeys(("make", "first", "again", "bare"), 0.0)
    for change in changes:
        marks = [time.process_time()]
        varied = base._variation(**change)
        marks.append(time.process_time())
        for _ in range(2):
            varied.simulate(duration, SPEED)
            marks.append(time.process_time())
        varied.simulate(duration, SPEED, output_step=duration)
        marks.append(time.process_time())
        varied.simulate(duration, SPEED, output_step=duration)
        marks.append(time.process_time())
        make, first, again, _, bare = (end - begin for begin, end in itertools.pairwise(marks))
        for part, value in zip(totals, (make, first, again, bare), strict=True):
            totals[part] += value / count
    parts = {
        "system of the variation": totals["make"],
        "set-up: equilibrium, synchronous motion, check of the modes": totals["first"]
        - totals["again"],
        "steps": totals["bare"],
        "output": totals["again"] - totals["bare"],
    }
    return [(part, 1e3 * value) for part, value in parts.items()]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("count", type=int, nargs="?", default=40, help="number of runs")
    parser.add_argument("--wall", action="store_true", help="compare two threads with one")
    parser.add_argument("--profile", action="store_true", help="print the parts of a run")
    given = parser.parse_args()
    count: int = given.count
    if given.profile:
        print(f"Means of {count} runs of {max(DURATIONS):g} s.\n")
        print("| part of a run | CPU |\n|---|---|")
        for part, value in profile(count):
            print(f"| {part} | {value:.1f} ms |")
        return
    titles = ["duration of a run", f"CPU, {SCALED} separate runs", "with `simulate_many`", "ratio"]
    titles.append("share of the calling thread")
    titles += ["wall clock, two threads / one"] * given.wall
    print(f"Times are those of {count} runs, scaled to {SCALED}.\n")
    print(f"| {' | '.join(titles)} |\n|{'---|' * len(titles)}")
    for duration in DURATIONS:
        print(f"| {' | '.join(row(duration, count, wall=given.wall))} |")


if __name__ == "__main__":
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        main()
