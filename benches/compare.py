"""Compare gearbow with SciPy and ROSS: same scenes, same required error, one core each.

Every method simulates a scene from rest. The settings of a method range from cheap to expensive;
the result is the first setting whose error is small enough. The error is the RMS of the difference
from a reference divided by the RMS of the motion about its mean, for the worst gear. The reference
is gearbow's "rk45" with a tight tolerance, and SciPy's DOP853 checks it over a part of the
duration. Slow methods simulate only this part of the duration. Their error refers to this shorter
time, which is an advantage for them.

A cost is the CPU time per simulated second, measured in a separate process for each method. It
excludes the set-up, the time before the first step. After the search the methods are timed in turn
over several rounds, so that a change of the processor speed affects all methods. Costs are medians
over the rounds. Ratios are medians of the ratios to gearbow's cheapest method within each round.
``python benches/compare.py`` prints a Markdown table for each scene.
"""

import argparse
import importlib.util
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from programs.methods import CHECK, METHODS, REFERENCE, Method, Prepare, Run, TooSlow, offered
from programs.scenes import SCENES, Array, Scene

ROUNDS = 5
PATIENCE = 25.0  # limit of the CPU time of a run, s
SLOW = 5.0  # runs that take longer are timed only once, s
LEAST = 0.2  # shortest CPU time that is measured; shorter runs are repeated, s
QUICK = ("shaft", "square")  # scenes of a quick comparison
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def error_of(found: Array, exact: Array) -> float:
    """Return the error over the times of `found`, which may end earlier than those of `exact`."""
    exact = exact[:, : found.shape[1]]
    motion = np.sqrt(np.mean((exact - exact.mean(axis=1, keepdims=True)) ** 2, axis=(1, 2)))
    return float(np.max(np.sqrt(np.mean((found - exact) ** 2, axis=(1, 2))) / motion))


def timed(run: Run) -> tuple[Array, float]:
    """Return the result and the CPU time of a run; a short run is repeated and averaged."""
    begin, count = time.process_time(), 0
    while True:
        found = run()
        count += 1
        spent = time.process_time() - begin
        if spent > LEAST:
            return found, spent / count


def cost_of(
    prepare: Prepare, scene: Scene, method: Method, setting: dict[str, float]
) -> tuple[float, float]:
    """Return the CPU time per simulated second, and that of the set-up before the first step."""
    duration = scene.stretch if method.short else scene.duration
    first = prepare(2 * every(scene, setting) * scene.sample, setting, np.inf)
    timed(first)  # first call: compilation and imports are not measured
    start = timed(first)[1]
    _, cost = timed(prepare(duration, setting, np.inf))
    if cost <= 3.0 * start:
        # A run that takes hardly longer than its set-up is timed over a longer duration.
        duration *= 10.0
        _, cost = timed(prepare(duration, setting, np.inf))
    return (cost - start) / duration, start


def every(scene: Scene, setting: dict[str, float]) -> int:
    """Return the number of samples per step, at least one."""
    return max(1, round(setting.get("step", 0.0) / scene.sample))


def search(scene: Scene, method: Method, exact: Array, *, quick: bool) -> dict[str, Any]:
    """Find the cheapest setting that meets the required error, and a first measure of its cost."""
    patience = 1.5 if quick else PATIENCE
    duration = scene.stretch if method.short else scene.duration
    prepare = method.prepare(scene)
    row: dict[str, Any] = {"setting": None, "error": None, "cost": None, "start": None}
    row["duration"] = duration
    for setting in method.settings:
        begun = time.process_time()
        try:
            found = prepare(duration, setting, patience)()
        except TooSlow as slow:
            if row["error"] is None:
                return row | {"setting": setting, "cost": (time.process_time() - begun) / slow.done}
            return row
        spent = time.process_time() - begun
        error = error_of(found, exact[:, :: every(scene, setting)])
        if row["error"] is None or error < row["error"]:
            row |= {"setting": setting, "error": error, "cost": spent / duration}
        if error <= scene.error or 2.0 * spent > patience:
            return row
    return row


def work(arguments: argparse.Namespace, scene: Scene, folder: Path) -> None:
    """Carry out the task of one child process."""
    file = folder / f"{arguments.scene}.npy"
    if arguments.part in {"reference", "check"}:
        method = REFERENCE if arguments.part == "reference" else CHECK
        duration = scene.stretch / 2 if method.short else scene.duration
        found = method.prepare(scene)(duration, method.settings[0], np.inf)()
        if method is REFERENCE:
            np.save(file, found)
        else:
            print(json.dumps({"error": error_of(found, np.load(file))}))
    else:
        method = next(method for method in METHODS if method.title == arguments.part)
        if arguments.setting:
            setting = json.loads(arguments.setting)
            print(json.dumps(cost_of(method.prepare(scene), scene, method, setting)))
        else:
            print(json.dumps(search(scene, method, np.load(file), quick=arguments.quick)))


def apart(part: str, name: str, folder: Path, *, quick: bool, setting: str = "") -> Any:
    """Run a task in a child process on one core and return its result."""
    print(f"{name}: {part}", setting, file=sys.stderr)
    command = [sys.executable, __file__, "--part", part, "--scene", name, "--folder", str(folder)]
    command += ["--setting", setting]
    done = subprocess.run(
        [*command, *(["--quick"] if quick else [])],
        env={**os.environ, **dict.fromkeys(THREADS, "1")},
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    )
    # Libraries may print before the result.
    return json.loads(done.stdout.splitlines()[-1]) if done.stdout else None


def installed(method: Method) -> bool:
    """Return whether the program of a method is installed."""
    if method.program == "gearbow":
        return offered(method.name)
    return method.program != "ROSS" or importlib.util.find_spec("ross") is not None


def table(name: str, methods: list[Method], folder: Path, *, quick: bool) -> None:
    """Compare all methods in a scene and print its table."""
    scene = SCENES[name]
    apart("reference", name, folder, quick=quick)
    within = ""
    if not scene.own:
        check = apart("check", name, folder, quick=quick)["error"]
        within = f", error of the reference {check:.0e} (checked with SciPy)"
    rows = []
    for method in methods:
        offers = (scene.ross or not method.ross) and method.only in {"", name}
        if offers and (not scene.own or method.program == "gearbow" or method.only == name):
            rows.append((method, apart(method.title, name, folder, quick=quick)))
    again = [
        (method, row)
        for method, row in rows
        if row["error"] is not None and row["cost"] * row["duration"] < SLOW
    ]
    rounds: list[dict[str, float]] = []
    for _ in range(1 if quick else ROUNDS):
        costs = {}
        for method, row in again:
            setting = json.dumps(row["setting"])
            costs[method.title], row["start"] = apart(
                method.title, name, folder, quick=quick, setting=setting
            )
        rounds.append(costs)
    for method, row in again:
        row["cost"] = statistics.median(costs[method.title] for costs in rounds)
    met = {
        method.title: row["cost"]
        for method, row in again
        if method.program == "gearbow" and row["error"] <= scene.error
    }
    cheapest = min(met, key=met.__getitem__) if met else None
    print(f"\n{scene.title}.\nRequired error {scene.error:g}{within}.\n")
    print(
        "| program | method | setting | error | CPU s per simulated s | cost ratio | set-up [s] "
        "| simulated [s] |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for method, row in rows:
        setting = ", ".join(f"{key} {value:g}" for key, value in row["setting"].items())
        error = "time limit" if row["error"] is None else f"{row['error']:.1e}"
        sign = "≥ " if row["error"] is None or row["error"] > scene.error else ""
        start = "" if row["start"] is None else f"{row['start']:.2g}"
        ratio = ""
        if cheapest:
            ratios = [costs.get(method.title, row["cost"]) / costs[cheapest] for costs in rounds]
            ratio = f"{sign}{statistics.median(ratios):.3g}"
        print(
            f"| {method.program} | {method.name} | {setting} | {error} | {sign}{row['cost']:.3g}"
            f" | {ratio} | {start} | {row['duration']:g} |",
            flush=True,
        )


def main() -> None:
    """Compare all methods, or carry out the task of one child process."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--quick", action="store_true", help="fewer scenes, shorter runs")
    parser.add_argument("--scene", choices=SCENES, help="compare only this scene")
    parser.add_argument("--part", help=argparse.SUPPRESS)
    parser.add_argument("--setting", help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    names = [arguments.scene] if arguments.scene else QUICK if arguments.quick else list(SCENES)
    if arguments.part:
        scene = SCENES[arguments.scene]
        work(arguments, scene.shortened() if arguments.quick else scene, arguments.folder)
        return
    methods = [method for method in METHODS if installed(method)]
    for method in METHODS:
        if method not in methods:
            print(f"Skipped: {method.title} is not installed.")
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            table(name, methods, Path(folder), quick=arguments.quick)


if __name__ == "__main__":
    main()
