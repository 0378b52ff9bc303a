"""Total error of the accuracy levels, its estimate, and the cost.

``python benches/accuracy/measure.py`` measures every level on every scene with two processes and
stores the results in ``results.json``. Arguments select levels and scenes by name; the other stored
results stay. ``--stored`` measures nothing and prints the stored results as a table in Markdown;
docs/tradeoff.md contains it.

All levels of a scene share one reference. Its elements have degree 5 or more, and a degree above
that of all measured runs. Its degree, then the number of its elements, increase until two of them
agree to a tenth of the errors that the most accurate measured level permits.
"""

import argparse
import json
import sys
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from functools import partial
from itertools import pairwise
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

import gearbow as gb
from gearbow.accuracy import LEVELS, Level, root_mean_square, unit_of_errors, variation

sys.path.insert(0, str(Path(__file__).parents[1]))

from accuracy.scenes import SCENES, Scene

STORED = Path(__file__).with_name("results.json")
#: Smallest and largest degree of the elements of a reference.
MIN_DEGREE = 5
MAX_DEGREE = 8
#: Factors between the lengths of the elements and those of the most accurate measured run.
FACTORS = (1.0, 1.5, 2.0)
#: Tolerance of the reference relative to that of the level, and its smallest value.
TIGHTER = 0.01
SMALLEST = 1e-11
#: Part of the permitted error to which two references agree.
AGREEMENT = 0.1
RECORD = ["gears", "disks", "meshes"]
KINDS = ("displacement", "mesh_force")


@dataclass(frozen=True)
class Measured:
    """Errors and cost of one run.

    Parameters
    ----------
    true, estimated : dict of {str: float}
        Measured and estimated total error by kind of signal.
    agreement : dict of {str: float}
        Difference of the last two references.
    coordinates : int
        Number of degrees of freedom.
    degree : int
        Largest degree of the elements.
    expected : float
        Error that the choice of the elements expects.
    setup, stepping, estimate : float
        CPU time of the set-up [s], of a simulated second [s], and of `response.errors()` [s].
    chaotic : bool
        Whether the response calls the contact chaotic.
    """

    true: dict[str, float]
    estimated: dict[str, float]
    agreement: dict[str, float]
    coordinates: int
    degree: int
    expected: float
    setup: float
    stepping: float
    estimate: float
    chaotic: bool


@dataclass(frozen=True)
class Run:
    """A run at an accuracy level, and its cost."""

    level: Level
    system: gb.RotorSystem
    response: gb.Response
    setup: float
    stepping: float


def measure(scene: Scene, levels: list[Level]) -> dict[str, Measured]:
    """Measure levels on one scene."""
    runs = [_run(scene, level) for level in levels]
    exact, agreement = reference(scene, runs)
    return {run.level.name: _measured(run, exact, agreement) for run in runs}


def _run(scene: Scene, level: Level) -> Run:
    system = scene.build().replace(accuracy=level.name)
    begin = time.process_time()
    fresh = system.replace()
    fresh.simulate(0.0, scene.speed, accuracy=level.name, times=[0.0], record=RECORD)
    setup = time.process_time() - begin
    begin = time.process_time()
    response = fresh.simulate(scene.duration, scene.speed, accuracy=level.name, record=RECORD)
    stepping = (time.process_time() - begin) / scene.duration
    return Run(level, system, response, setup, stepping)


def _measured(run: Run, exact: gb.Response, agreement: dict[str, float]) -> Measured:
    begin = time.process_time()
    errors = run.response.errors()
    expected = run.system.discretisation.expected_error
    assert expected is not None
    return Measured(
        true=difference(run.response, exact),
        estimated={kind: each.total for kind, each in errors.items()},
        agreement=agreement,
        coordinates=len(run.system.dofs),
        degree=_degree(run.system),
        expected=expected,
        setup=run.setup,
        stepping=run.stepping,
        estimate=time.process_time() - begin,
        chaotic=errors.chaotic,
    )


def reference(scene: Scene, runs: list[Run]) -> tuple[gb.Response, dict[str, float]]:
    """Run finer and finer elements until two runs agree to a tenth of the smallest error."""
    finest = runs[-1]
    rtol = max(SMALLEST, TIGHTER * min(run.level.rtol for run in runs))
    lowest = min(MAX_DEGREE, max(MIN_DEGREE, *(_degree(run.system) + 1 for run in runs)))
    ladder = [(1.0, degree) for degree in range(lowest, MAX_DEGREE)]
    last: gb.Response | None = None
    agreement: dict[str, float] = {}
    for factor, degree in [*ladder, *((factor, MAX_DEGREE) for factor in FACTORS)]:
        run = refined(finest.system, factor, degree).simulate(
            scene.duration, scene.speed, method="exponential", rtol=rtol, record=RECORD
        )
        if last is not None:
            agreement = difference(last, run)
            if all(
                error < AGREEMENT * getattr(finest.level, kind) for kind, error in agreement.items()
            ):
                return run, agreement
        last = run
    assert last is not None
    return last, agreement


def refined(system: gb.RotorSystem, factor: float, degree: int) -> gb.RotorSystem:
    """Return the system with elements that are shorter by a factor, and of another degree.

    The parts between bodies, bearings and shoulders are divided one by one, so that no element is
    much shorter than the others: the highest frequency determines the round-off.
    """
    description = system.description
    for shaft in description["shafts"]:
        elements = system.discretisation.shafts[shaft["name"]]
        parts = shaft.pop("segments", None) or [_section(shaft)]
        longest = max(p["length"] / n for p, n in zip(parts, elements.numbers, strict=True))
        ends = np.cumsum([0.0, *(part["length"] for part in parts)])
        places = [*ends, *_places(description, shaft["name"])]
        nodes = np.unique(np.round(places, 12))
        shaft["segments"] = [
            {
                **parts[min(int(np.searchsorted(ends[1:], (a + b) / 2)), len(parts) - 1)],
                "length": b - a,
                "elements": ceil(factor * (b - a) / longest - 1e-9),
            }
            for a, b in pairwise(nodes.tolist())
        ]
        shaft["degree"] = degree
    return gb.RotorSystem.from_dict(description)


def _section(shaft: dict[str, Any]) -> dict[str, Any]:
    """Move the dimensions of a shaft with one segment to this segment."""
    names = ("length", "outer_diameter", "inner_diameter", "elements")
    return {name: shaft.pop(name) for name in names if name in shaft}


def _places(description: dict[str, Any], shaft: str) -> list[float]:
    """Return the positions of gears, disks and bearings on a shaft [m]."""
    parts = [part for kind in ("gears", "disks", "bearings") for part in description.get(kind, ())]
    return [part["position"] for part in parts if part["shaft"] == shaft]


def _degree(system: gb.RotorSystem) -> int:
    return max(each.degree for each in system.discretisation.shafts.values())


def difference(run: gb.Response, exact: gb.Response) -> dict[str, float]:
    """Return the largest error by kind of signal, where signals of this kind vary."""
    errors: dict[str, float] = {}
    for item in exact.recorded:
        if isinstance(item, str):
            kind, ours, theirs = "displacement", run.displacement(item), exact.displacement(item)
        else:
            driver, driven = item[:2]
            kind = "mesh_force"
            ours, theirs = (r.mesh((driver, str(driven))).force[:, None] for r in (run, exact))
        if variation(theirs) > 0.0:
            error = root_mean_square(ours - theirs) / unit_of_errors(theirs)
            errors[kind] = max(errors.get(kind, 0.0), error)
    return errors


def table(stored: dict[str, dict[str, Any]]) -> Iterator[str]:
    """Yield the stored results as a table in Markdown."""
    yield (
        "| level | scene | n | degree | error of displacement | estimate | error of mesh force "
        "| estimate | reference | set-up [s] | CPU s per simulated s |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|"
    for level in LEVELS:
        for name in SCENES:
            found = stored.get(name, {}).get(level)
            if found is None:
                continue
            cells = [
                f"{found[source][kind]:.1e}" if kind in found["true"] else "–"
                for kind in KINDS
                for source in ("true", "estimated")
            ]
            agreement = ", ".join(f"{error:.0e}" for error in found["agreement"].values())
            yield (
                f"| {level} | {name} | {found['coordinates']} | {found['degree']} "
                f"| {' | '.join(cells)} | {agreement} | {found['setup']:.2f} "
                f"| {found['stepping']:.2g} |"
            )


def _read() -> dict[str, dict[str, Any]]:
    stored: dict[str, dict[str, Any]] = {}
    if STORED.exists():
        stored = json.loads(STORED.read_text(encoding="utf-8"))
    return stored


def _store(name: str, found: dict[str, Measured]) -> None:
    stored = _read()
    stored[name] = {
        **stored.get(name, {}),
        **{level: asdict(each) for level, each in found.items()},
    }
    STORED.write_text(json.dumps(stored, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def _measure_named(levels: list[str], name: str) -> dict[str, Measured]:
    warnings.simplefilter("ignore", gb.AccuracyWarning)
    return measure(SCENES[name], [LEVELS[level] for level in levels])


def _size(name: str) -> int:
    return len(SCENES[name].build().replace(accuracy="reference").dofs)


def main() -> None:
    """Measure the selected levels and scenes, or print the stored results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("names", nargs="*", help="levels and scenes; all without")
    parser.add_argument("--stored", action="store_true", help="print the stored results")
    parser.add_argument("--processes", type=int, default=2, help="number of processes")
    given = parser.parse_args()
    if given.stored:
        print("\n".join(table(_read())))
        return
    levels = [level for level in LEVELS if level in given.names] or list(LEVELS)
    scenes = [name for name in SCENES if name in given.names] or list(SCENES)
    with ProcessPoolExecutor(given.processes) as executor:
        # The smallest scenes come first, so that an early end leaves most results.
        todo = {
            executor.submit(partial(_measure_named, levels), name): name
            for name in sorted(scenes, key=_size)
        }
        for done in as_completed(todo):
            found = done.result()
            _store(todo[done], found)
            rows = {todo[done]: {level: asdict(each) for level, each in found.items()}}
            print("\n".join([*table(rows)][2:]), flush=True)


if __name__ == "__main__":
    main()
