"""gearbow beside SciPy and ROSS: the same scenes to the same error, one core each.

Every method simulates a scene from rest with settings from cheap to dear until its error is small
enough; the first setting that does counts. The error is the RMS of the difference to a reference
over the RMS of the motion about its mean, of the worst gear. The reference is gearbow's most exact
method with a tight tolerance, itself held against SciPy's DOP853 on a stretch. What takes minutes
simulates a stretch only, and its error is that over the stretch, which is in its favour.

Costs are CPU seconds per simulated second, in a process of each method's own; what a run takes
before its first step (`start`) is not part of them. Once all settings are found, the methods are
timed in turn, round after round, so that a machine that is faster at times is so for all of them;
costs are medians of the rounds, and so are the ratios to the cheapest of gearbow.
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
PATIENCE = 25.0  # CPU time of a run, s
SLOW = 5.0  # CPU time of a run that is not timed again, s
LEAST = 0.2  # CPU time that is measured, s
QUICK = ("shaft", "square")  # scenes for a look
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def error_of(found: Array, exact: Array) -> float:
    """Give the error over the times of `found`, which may be fewer or end earlier."""
    exact = exact[:, : found.shape[1]]
    motion = np.sqrt(np.mean((exact - exact.mean(axis=1, keepdims=True)) ** 2, axis=(1, 2)))
    return float(np.max(np.sqrt(np.mean((found - exact) ** 2, axis=(1, 2))) / motion))


def timed(run: Run) -> tuple[Array, float]:
    """Give what a run finds, and its CPU time; a short one is run until the clock can tell."""
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
    """Give what a setting costs per simulated second, and before the first step."""
    duration = scene.stretch if method.short else scene.duration
    first = prepare(2 * every(scene, setting) * scene.sample, setting, np.inf)
    timed(first)  # what is compiled or read when first needed is nobody's cost
    start = timed(first)[1]
    _, cost = timed(prepare(duration, setting, np.inf))
    if cost <= 3.0 * start:
        # What is over as soon as it has started is timed over longer.
        duration *= 10.0
        _, cost = timed(prepare(duration, setting, np.inf))
    return (cost - start) / duration, start


def every(scene: Scene, setting: dict[str, float]) -> int:
    """Give how many samples there are between steps: some have less than one, others more."""
    return max(1, round(setting.get("step", 0.0) / scene.sample))


def search(scene: Scene, method: Method, exact: Array, *, quick: bool) -> dict[str, Any]:
    """Find the cheapest setting that is exact enough, and what it costs at first sight."""
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
    """Do the part of one process."""
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
    """Do a part in a process of its own, on one core."""
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
    # Libraries may have said something before.
    return json.loads(done.stdout.splitlines()[-1]) if done.stdout else None


def installed(method: Method) -> bool:
    """Whether a method can be run here."""
    if method.program == "gearbow":
        return offered(method.name)
    return method.program != "ROSS" or importlib.util.find_spec("ross") is not None


def table(name: str, methods: list[Method], folder: Path, *, quick: bool) -> None:
    """Print the table of a scene."""
    scene = SCENES[name]
    apart("reference", name, folder, quick=quick)
    within = ""
    if not scene.own:
        check = apart("check", name, folder, quick=quick)["error"]
        within = f" (the reference is within {check:.0e} of SciPy's)"
    rows = []
    for method in methods:
        offers = (scene.ross or not method.ross) and method.only in {"", name}
        if offers and (not scene.own or method.program == "gearbow"):
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
    print(f"\n{scene.title}: error {scene.error:g}{within}\n")
    print("| program | method | setting | error | CPU s per s | ratio | start [s] | over [s] |")
    print("|---|---|---|---|---|---|---|---|")
    for method, row in rows:
        setting = ", ".join(f"{key} {value:g}" for key, value in row["setting"].items())
        error = "out of time" if row["error"] is None else f"{row['error']:.1e}"
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
    """Compare, or do the part of one process."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--quick", action="store_true", help="less of everything, for a look")
    parser.add_argument("--scene", choices=SCENES, help="this one alone")
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
            print(f"{method.title} is not installed here.")
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            table(name, methods, Path(folder), quick=arguments.quick)


if __name__ == "__main__":
    main()
