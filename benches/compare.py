"""Compare gearbow with SciPy and ROSS: the same work, the error beside the cost, one core each.

``python benches/compare.py`` prints Markdown tables of four kinds; arguments choose some of them.

- A **scene** is simulated from rest. The settings of a method range from cheap to expensive; the
  result is the first setting whose error is small enough. The error is the RMS of the difference
  from a reference divided by the RMS of the motion about its mean, for the worst gear. The
  reference is gearbow's "rk45" with a tight tolerance, and SciPy's DOP853 checks it over a part of
  the duration. Slow methods simulate only this part. Their error refers to this shorter time,
  which is an advantage for them. A cost is the CPU time per simulated second, without the set-up.
- An **analysis** is carried out on systems of increasing size, each time on a system that has kept
  nothing of earlier analyses.
- ``calls`` are further calls on one system, compared with each other, and ``memory`` is the peak
  memory of processes that analyse 9,000 elements.

Times are CPU times of all threads. All programs are timed in turn over several rounds, so that a
change of the processor speed affects all of them. Costs are medians over the rounds, and ratios
are medians of the ratios within each round.
"""

import argparse
import contextlib
import functools
import gc
import importlib
import math
import os
import statistics
import sys
import warnings
from collections.abc import Sequence

import gearbow as gb
from programs.analyses import ANALYSES, SUBJECTS, Analysis, Subject
from programs.calls import CALLS, SETUP, Call
from programs.memory import RUNS, WORKS, peak
from programs.methods import METHODS, Method, offered
from programs.scenes import SCENES, Scene
from programs.search import PATIENCE, Found, check, measure, reference, search
from programs.timing import (
    ROUNDS,
    Outcome,
    in_rounds,
    median_ratio,
    once,
    one_thread,
    timed,
)

SLOW = 1.0  # work that takes longer is timed only once, s
LIMIT = 15.0  # limit of the CPU time of an analysis, s
QUICK = ("shaft", "square", "modes", "calls")  # tables of a quick comparison
CALL_TABLES = {"calls": ("Calls on one system", CALLS), "setup": ("Parts of a set-up", SETUP)}
TABLES = (*SCENES, *ANALYSES, *CALL_TABLES, "memory")


def row(*cells: object) -> None:
    """Print a row of a table."""
    print("|", " | ".join(str(cell) for cell in cells), "|", flush=True)


def header(*cells: str) -> None:
    """Print the head of a table."""
    row(*cells)
    print("|" + "---|" * len(cells))


@functools.cache
def without_ross() -> str:
    """Return why ROSS cannot be used; empty if it can."""
    try:
        importlib.import_module("programs.ross_rotor")
    except ModuleNotFoundError as error:
        return "not installed" if error.name == "ross" else f"cannot be imported: {error}"
    except Exception as error:  # noqa: BLE001  # ROSS fails with some versions of its dependencies
        return f"cannot be imported: {type(error).__name__}"
    return ""


def unavailable(method: Method) -> str:
    """Return why a method cannot be used; empty if it can."""
    if method.program == "gearbow":
        return "" if offered(method.name) else "not in this version"
    return without_ross() if method.program == "ROSS" else ""


def scene_table(name: str, *, quick: bool) -> None:
    """Compare all methods in a scene."""
    scene = SCENES[name].shortened() if quick else SCENES[name]
    exact, within = reference(scene), ""
    if not scene.own:
        within = f", error of the reference {check(scene, exact):.0e} (checked with SciPy)"
    print(f"\n{scene.title}.\nRequired error {scene.error:g}{within}.\n")
    rows, missing = [], []
    for method in METHODS:
        offers = (scene.ross or not method.ross) and method.only in {"", name}
        if offers and (not scene.own or method.program == "gearbow" or method.only == name):
            reason = unavailable(method)
            if reason:
                missing.append((method, reason))
            else:
                rows.append(search(scene, method, exact, 1.5 if quick else PATIENCE))
    again = {r.method.title: r for r in rows if r.error is not None and r.cost * r.duration < SLOW}
    measured: dict[str, list[Found]] = {title: [] for title in again}

    def work(title: str) -> float:
        measured[title].append(measure(scene, again[title]))
        return measured[title][-1].cost

    works = {title: lambda title=title: work(title) for title in again}
    costs = in_rounds(works, 1 if quick else ROUNDS)
    print_scene(scene, rows, costs, {title: found[-1].start for title, found in measured.items()})
    for method, reason in missing:
        row(method.program, method.name, reason, "", "", "", "", "")


def print_scene(
    scene: Scene,
    rows: list[Found],
    costs: dict[str, list[float]],
    starts: dict[str, float | None],
) -> None:
    """Print the table of a scene."""
    medians = {title: statistics.median(values) for title, values in costs.items()}
    meeting = [
        r.method.title
        for r in rows
        if r.method.program == "gearbow" and r.method.title in costs and met(r, scene)
    ]
    cheapest = min(meeting, key=medians.__getitem__) if meeting else None
    header(
        *("program", "method", "setting", "error", "CPU s per simulated s", "cost ratio"),
        *("set-up [s]", "simulated [s]"),
    )
    for r in rows:
        title, sign = r.method.title, "" if met(r, scene) else "≥ "
        cost = medians.get(title, r.cost)
        ratio = ""
        if cheapest:
            units = costs[cheapest]
            ratio = f"{sign}{median_ratio(costs.get(title, [r.cost] * len(units)), units):.3g}"
        start = starts.get(title)
        row(
            r.method.program,
            r.method.name,
            ", ".join(f"{key} {value:g}" for key, value in r.setting.items()),
            "time limit" if r.error is None else f"{r.error:.1e}",
            f"{sign}{cost:.3g}",
            ratio,
            "" if start is None else f"{start:.2g}",
            f"{r.duration:g}",
        )


def met(found: Found, scene: Scene) -> bool:
    """Return whether a setting meets the required error."""
    return found.error is not None and found.error <= scene.error


class AnalysisTable:
    """Costs and errors of every program for an analysis of systems of increasing size."""

    def __init__(self, analysis: Analysis, *, quick: bool) -> None:
        self.analysis, self.rounds = analysis, 1 if quick else ROUNDS
        self.cells: dict[str, list[str]] = {name: [] for name in analysis.programs}
        self.ratios: dict[str, list[str]] = {name: [] for name in analysis.programs}
        self.trains: dict[str, dict[int, float]] = {name: {} for name in analysis.programs}
        self.stopped: dict[str, str] = {}  # reason why a program does not analyse larger trains
        self.heads: list[str] = []

    def measure(self, subject: Subject) -> None:
        """Measure all programs on one system."""
        system = subject.build()
        size = len(system.dofs)
        self.heads.append(f"{subject.title}, n = {size}")
        outcomes = {name: self.probe(name, subject, system) for name in self.analysis.programs}
        completed = any(outcome.value is not None for outcome in outcomes.values())
        exact = self.analysis.exact(system) if completed else None
        errors, costs, works = {}, {}, {}
        for name, program in self.analysis.programs.items():
            outcome = outcomes[name]
            if outcome.value is None:
                self.cells[name].append(outcome.reason)
                continue
            errors[name] = self.analysis.error(outcome.value, exact)
            costs[name] = [outcome.cost] * self.rounds
            if outcome.cost < SLOW:
                prepared = program(system)
                works[name] = lambda prepared=prepared: timed(prepared)[1]
        costs |= in_rounds(works, self.rounds)
        for name, values in costs.items():
            cost = statistics.median(values)
            self.cells[name].append(f"{readable(cost)}, {errors[name]:.0e}")
            if not subject.ross:
                self.trains[name][size] = cost
        for name in self.cells:
            both = name in costs and "gearbow" in costs
            ratio = f"{median_ratio(costs[name], costs['gearbow']):.3g}" if both else ""
            self.ratios[name].append(ratio)
        gc.collect()

    def probe(self, name: str, subject: Subject, system: gb.RotorSystem) -> Outcome[object]:
        """Run once in a process of its own, which ends at the time limit."""
        if name == "ROSS" and (without_ross() or not subject.ross):
            return Outcome(None, 0.0, without_ross() or "no model")
        if name in self.stopped and not subject.ross:
            return Outcome(None, 0.0, self.stopped[name])
        prepared = self.analysis.programs[name](system)
        outcome = once(prepared, LIMIT)
        if outcome.value is None:
            self.stopped[name] = outcome.reason
        return outcome

    def print(self) -> None:
        """Print the table, and the exponents of the growth."""
        print(f"\n{self.analysis.title}.\n")
        header("program", *self.heads, "growth")
        for name, cells in self.cells.items():
            row(name, *cells, growth(self.trains[name]))
            if name != "gearbow" and any(self.ratios[name]):
                row(f"{name} / gearbow", *self.ratios[name], "")


def readable(seconds: float) -> str:
    """Return a time with its unit."""
    return f"{seconds:.3g} s" if seconds >= 0.9995 else f"{1e3 * seconds:.3g} ms"


def growth(costs: dict[int, float]) -> str:
    """Return the exponent of the cost between the smallest and the largest train."""
    if len(costs) < 2:
        return ""
    small, large = min(costs), max(costs)
    exponent = math.log(costs[large] / costs[small]) / math.log(large / small)
    return f"n^{exponent:.2f} to n = {large}"


def analysis_table(name: str, *, quick: bool) -> None:
    """Compare all programs in an analysis."""
    table = AnalysisTable(ANALYSES[name], quick=quick)
    for subject in (SUBJECTS[name] for name in ANALYSES[name].subjects or SUBJECTS):
        if not (quick and subject.large):
            table.measure(subject)
    table.print()


def calls_table(title: str, calls: Sequence[Call], *, quick: bool) -> None:
    """Measure further calls on one system."""
    prepared = {call.title: call.prepare() for call in calls}
    works = {title: work for title, (work, _) in prepared.items()}
    for work in works.values():
        work()  # the first call fills caches
    values = in_rounds(works, 1 if quick else ROUNDS)
    print(f"\n{title}.\n")
    header("call", "cost", "error")
    for call in calls:
        error = prepared[call.title][1]
        cost = f"{statistics.median(values[call.title]):.3g} {call.unit}".rstrip()
        row(call.title, cost, "" if error is None else f"{error:.1e}")


def memory_table() -> None:
    """Measure the peak memory of processes that analyse a large system, and of runs."""
    runs = "Runs of a double-stage train, constant mesh stiffness, live geometry"
    for heading, titles in (("Three shafts with 3,000 elements each", WORKS), (runs, RUNS)):
        print(f"\n{heading}.\n")
        header("analysis", "peak memory [MB]", "CPU time [s]")
        for title in titles:
            row(title, *peak(title))


def main() -> None:
    """Print the chosen tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--quick", action="store_true", help="fewer tables, shorter runs")
    parser.add_argument("tables", nargs="*", choices=[*TABLES, []], help="all if none is given")
    given = parser.parse_args()
    one_thread()
    # Libraries that print write to the standard error instead.
    tables = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    warnings.simplefilter("ignore", gb.AccuracyWarning)
    quick: bool = given.quick
    with contextlib.redirect_stdout(tables):
        for name in given.tables or (QUICK if quick else TABLES):
            print(f"{name} ...", file=sys.stderr, flush=True)
            if name in SCENES:
                scene_table(name, quick=quick)
            elif name in ANALYSES:
                analysis_table(name, quick=quick)
            elif name in CALL_TABLES:
                calls_table(*CALL_TABLES[name], quick=quick)
            else:
                memory_table()


if __name__ == "__main__":
    main()
