"""Change one place of the program at a time, and count how many of these mutants the tests catch.

    python tools/mutants.py [--python 150] [--rust 60] [--seed 1] [--left-out PART ...]

The mutants are drawn at random from those of cosmic-ray (Python) and of `cargo mutants` (Rust). All
work happens in a copy of the repository in target/mutants. A Python mutant runs the tests that
execute its line; one run of all tests with coverage finds them. A Rust mutant runs the Rust tests,
then the Python tests of `TESTS_OF`. The script prints each mutant that no test catches, and the
share of caught mutants with its standard deviation.
"""

from __future__ import annotations

import argparse
import difflib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
from math import sqrt
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names
from coverage import CoverageData

COPY = Path("target/mutants")
#: Time limit of the tests of one mutant [s]. A mutant that exceeds it counts as caught.
TIME_LIMIT = 900.0
#: Largest number of tests for one Python mutant.
MAX_TESTS = 300
#: Parts of the names of operators that nearly every test catches: they change the type of a value.
CRUDE = ("Shift", "Bit", "Decorator", "Variable", "Invert", "Exception", "_Is", "Mod", "FloorDiv")
#: Patterns of the Python tests of a folder of the Rust core.
TESTS_OF = {
    "analysis/campbell": "campbell or stability or structured or closed_form or published",
    "analysis/discretisation": "discretisation or elements or accuracy",
    "analysis/simulate": "run or response or exponential or checkpoint or modal or initial",
    "analysis/steady": "steady or periodic or continuation",
    "analysis": "campbell or synchronous or balance or static or stability or memory or long_work",
    "connection": "bearing or mesh or teeth or drive or force or flank or random",
    "element": "element or closed_form or published or axial",
    "exponential": "exponential or sample or contact or step or teeth or changing",
    "film": "journal or equilibri",
    "integrate": "order or method or event or run or time",
    "linalg": "structured or mode or campbell or published",
    "mesh": "mesh or teeth or helical or path or flank or profile",
    "modal": "mode or modal or structured or campbell or static or equilibri or stability",
    "model": "scene or bow or support or coupling or axial or reference or matri",
    "motion": "energy or invariant or response or speed",
    "python": "error or options or persistence or checkpoint or names",
    "rolling": "rolling or equilibri",
    "scene": "scene or description or name or number or unit or kinematic",
}


def passes(command: list[str], limit: float | None = TIME_LIMIT) -> bool:
    """Return whether a command succeeds in the copy within a time limit [s]."""
    environment = os.environ | {
        "CARGO_INCREMENTAL": "1",
        "CARGO_TARGET_DIR": str(Path("target").resolve()),
        "PYO3_PYTHON": sys.executable,
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONPATH": str((COPY / "python").resolve()),
    }
    process = subprocess.Popen(
        command,
        cwd=COPY,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        return process.wait(limit) == 0
    except subprocess.TimeoutExpired:
        # The workers of pytest belong to the session of the command.
        os.killpg(process.pid, signal.SIGKILL)
        return False


def pytest(*arguments: str, limit: float | None = TIME_LIMIT) -> bool:
    """Return whether Python tests of the copy pass."""
    return passes([sys.executable, "-m", "pytest", "-q", "-x", "-n2", *arguments], limit)


def cargo(*arguments: str) -> bool:
    """Return whether a cargo command succeeds in the copy; more parts compile faster."""
    parts = "profile.release.package.gearbow.codegen-units=64"
    return passes(["cargo", *arguments, "--release", "--locked", "--config", parts], None)


def build() -> bool:
    """Compile the extension of the copy."""
    if not cargo("build", "--lib", "--features", "python"):
        return False
    shutil.copy("target/release/libgearbow.so", COPY / "python/gearbow/_core.abi3.so")
    return True


def draw_python(chance: random.Random, left_out: list[str]) -> tuple[Path, str, str, int]:
    """Draw a module, the mutated source text, its original and the line of the change."""
    modules = [
        path
        for path in sorted((COPY / "python/gearbow").rglob("*.py"))
        if not any(part in path.as_posix() for part in left_out)
    ]
    while True:
        path = chance.choices(modules, [path.stat().st_size for path in modules])[0]
        source = path.read_text(encoding="utf-8")
        name = chance.choice([n for n in operator_names() if not any(word in n for word in CRUDE)])
        operator = get_operator(name)()
        nodes = ast_nodes(get_ast(source))
        lines = [start[0] for node in nodes for start, _ in operator.mutation_positions(node)]
        if lines:
            occurrence = chance.randrange(len(lines))
            return path, mutate_code(source, operator, occurrence), source, lines[occurrence]


def python_mutants(count: int, chance: random.Random, left_out: list[str]) -> list[str]:
    """Return the differences of the Python mutants that no test catches."""
    survivors: list[str] = []
    if not count:
        return survivors
    if not pytest("--cov=gearbow", "--cov-context=test", "tests/python", limit=None):
        raise SystemExit("The tests fail without any change: mend them first.")
    data = CoverageData(str(COPY / ".coverage"))
    data.read()
    for _ in range(count):
        path, mutant, source, line = draw_python(chance, left_out)
        contexts = data.contexts_by_lineno(str(path.resolve()))
        # A line that runs at the import belongs to all tests of its module.
        names = set(contexts.get(line, ())) - {""} or set().union(*contexts.values()) - {""}
        tests = sorted({name.split("|")[0] for name in names})
        path.write_text(mutant, encoding="utf-8")
        chosen = chance.sample(tests, min(len(tests), MAX_TESTS))
        caught = bool(chosen) and not pytest(*chosen)
        path.write_text(source, encoding="utf-8")
        lines = difflib.unified_diff(source.splitlines(), mutant.splitlines(), str(path), n=0)
        survivors += report(caught, "\n".join(lines))
    return survivors


def rust_mutants(count: int, chance: random.Random, left_out: list[str]) -> list[str]:
    """Return the differences of the Rust mutants that no test catches."""
    survivors = []
    listed = subprocess.run(
        ["cargo", "mutants", "--list", "--diff", "--json"],
        cwd=COPY,
        check=True,
        capture_output=True,
    )
    mutants = [m for m in json.loads(listed.stdout) if not any(p in m["file"] for p in left_out)]
    chance.shuffle(mutants)
    while count > 0:
        mutant = mutants.pop()
        header, changed = mutant["diff"].split("\n@@", 1)
        difference = f"{header.splitlines()[0]}\n+++ {mutant['file']}\n@@{changed}"
        apply = ["git", "apply", "-p0", "-"]
        subprocess.run(apply, input=difference.encode(), cwd=COPY, check=True)
        # Code that does not compile is no mutant.
        if cargo("test", "--no-run") and build():
            pattern = next(
                (p for f, p in TESTS_OF.items() if mutant["file"].startswith(f"src/{f}")), ""
            )
            caught = not cargo("test") or not pytest("tests/python", "-k", pattern)
            survivors += report(caught, mutant["diff"])
            count -= 1
        subprocess.run(["git", "checkout", "--quiet", "src"], cwd=COPY, check=True)
    return survivors


def report(caught: bool, difference: str) -> list[str]:
    """Print the fate of a mutant, and return its difference if no test catches it."""
    print("caught" if caught else "MISSED", difference, sep="\n", flush=True)
    return [] if caught else [difference]


def main() -> None:
    """Make the copy, examine the mutants, and print the share that the tests catch."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--python", type=int, default=150, help="number of Python mutants")
    parser.add_argument("--rust", type=int, default=60, help="number of Rust mutants")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--left-out", nargs="*", default=[], help="parts of names of files")
    given = parser.parse_args()
    shutil.rmtree(COPY, ignore_errors=True)
    subprocess.run(["git", "clone", "--quiet", ".", str(COPY)], check=True)
    if not build():
        raise SystemExit("The extension does not compile.")
    chance = random.Random(given.seed)
    missed = python_mutants(given.python, chance, given.left_out)
    missed += rust_mutants(given.rust, chance, given.left_out)
    count = given.python + given.rust
    share = 1.0 - len(missed) / count
    deviation = sqrt(share * (1.0 - share) / count)
    (COPY / "missed.diff").write_text("\n\n".join(missed), encoding="utf-8")
    print(f"caught {count - len(missed)} of {count} mutants: {share:.0%} ± {deviation:.0%}")


if __name__ == "__main__":
    main()
