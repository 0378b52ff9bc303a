"""Total error of the accuracy levels, its estimate, and the cost.

``python benches/accuracy/measure.py`` measures every level on every scene and prints a table in
Markdown; docs/tradeoff.md contains it. Arguments select levels and scenes by name.

The reference of a scene has elements of degree 5 or more and a smaller tolerance. Its degree
increases until two degrees agree to a tenth of the error that the level permits.
"""

import argparse
import sys
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import gearbow as gb
from gearbow.accuracy.levels import LEVELS, Level

sys.path.insert(0, str(Path(__file__).parents[1]))

from accuracy.scenes import SCENES, Scene

#: Largest degree of the elements.
MAX_DEGREE = 8
#: Tolerance of the reference relative to that of the level.
TIGHTER = 0.01


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
    setup, stepping : float
        CPU time of the set-up [s], and of a simulated second [s].
    degree : int
        Largest degree of the elements.
    """

    true: dict[str, float]
    estimated: dict[str, float]
    agreement: dict[str, float]
    coordinates: int
    setup: float
    stepping: float
    degree: int


def measure(scene: Scene, level: Level) -> Measured:
    """Measure one level on one scene."""
    system = scene.build().replace(resolution=level.name)
    options: dict[str, Any] = {"record": ["gears", "disks", "meshes"]}
    begin = time.process_time()
    fresh = system.replace()
    fresh.simulate(0.0, scene.speed, accuracy=level.name, times=[0.0], **options)
    setup = time.process_time() - begin
    begin = time.process_time()
    response = fresh.simulate(scene.duration, scene.speed, accuracy=level.name, **options)
    stepping = (time.process_time() - begin) / scene.duration
    exact, agreement = reference(system, scene, level, options)
    return Measured(
        true=difference(response, exact),
        estimated={kind: each.total for kind, each in response.errors.items()},
        agreement=agreement,
        coordinates=len(system.dofs),
        setup=setup,
        stepping=stepping,
        degree=max(each.degree for each in system.discretisation.shafts.values()),
    )


def reference(
    system: gb.RotorSystem, scene: Scene, level: Level, options: dict[str, Any]
) -> tuple[gb.Response, dict[str, float]]:
    """Run elements of increasing degree until two of them agree to a tenth of the level."""
    rtol = max(1e-12, TIGHTER * level.rtol)
    used = max(each.degree for each in system.discretisation.shafts.values())
    numbers = [(1, degree) for degree in range(max(5, used + 1), MAX_DEGREE + 1)]
    permitted = {"displacement": level.displacement, "mesh_force": level.mesh_force}
    last: gb.Response | None = None
    agreement: dict[str, float] = {}
    for factor, degree in [*numbers, (2, MAX_DEGREE - 1), (2, MAX_DEGREE)]:
        finer = refined(system, factor, degree)
        run = finer.simulate(
            scene.duration, scene.speed, method="exponential", rtol=rtol, **options
        )
        if last is not None:
            agreement = difference(last, run)
            if all(error < permitted[kind] / 10.0 for kind, error in agreement.items()):
                return run, agreement
        last = run
    assert last is not None
    return last, agreement


def refined(system: gb.RotorSystem, factor: int, degree: int) -> gb.RotorSystem:
    """Return the system with a multiple of its numbers of elements, and another degree."""
    description = system.description
    for shaft in description["shafts"]:
        elements = system.discretisation.shafts[shaft["name"]]
        parts = shaft.get("segments", [shaft])
        for part, number in zip(parts, elements.numbers, strict=True):
            part["elements"] = factor * number
        shaft["degree"] = degree
    return gb.RotorSystem.from_dict(description)


def difference(run: gb.Response, exact: gb.Response) -> dict[str, float]:
    """Return the largest error by kind of signal: RMS of the difference / RMS about the mean."""
    errors: dict[str, float] = {}
    for item in exact.recorded:
        if isinstance(item, str):
            kind, ours, theirs = "displacement", run.displacement(item), exact.displacement(item)
        else:
            driver, driven = item[:2]
            kind = "mesh_force"
            ours, theirs = (r.mesh(driver, str(driven)).force[:, None] for r in (run, exact))
        variation = theirs - theirs.mean(axis=0)
        if np.abs(variation).max() > 1e-9 * np.abs(theirs).max():
            error = float(np.linalg.norm(ours - theirs) / np.linalg.norm(variation))
            errors[kind] = max(errors.get(kind, 0.0), error)
    return errors


def table(levels: list[str], names: list[str]) -> Iterator[str]:
    """Yield the table in Markdown."""
    yield (
        "| level | scene | n | degree | error of displacement | estimate | error of mesh force "
        "| estimate | set-up [s] | CPU s per simulated s |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|"
    for level in levels:
        for name in names:
            found = measure(SCENES[name], LEVELS[level])
            cells = []
            for kind in ("displacement", "mesh_force"):
                known = kind in found.true
                cells += [
                    f"{errors[kind]:.1e}" if known else "–"
                    for errors in (found.true, found.estimated)
                ]
            yield (
                f"| {level} | {name} | {found.coordinates} | {found.degree} | {' | '.join(cells)} "
                f"| {found.setup:.2f} | {found.stepping:.2g} |"
            )


def main() -> None:
    """Measure the selected levels and scenes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("names", nargs="*", help="levels and scenes; all without")
    names = parser.parse_args().names
    warnings.simplefilter("ignore", gb.AccuracyWarning)
    levels = [level for level in LEVELS if level in names] or list(LEVELS)
    scenes = [name for name in SCENES if name in names] or list(SCENES)
    for line in table(levels, scenes):
        print(line, flush=True)


if __name__ == "__main__":
    main()
