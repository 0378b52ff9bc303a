"""CPU times of the machines of examples/machines, beside SciPy on the same matrices.

``python benches/fleet.py`` measures every analysis of every machine and stores each result in
``fleet.json`` as soon as it is complete. ``--machine`` and ``--analysis`` select some of them; the
other stored results stay. ``--stored`` measures nothing and prints the stored results as tables in
Markdown; docs/comparison.md contains them.

The programs run in turn, each with one thread. A time is the median over the rounds, and a ratio is
the median of the ratios of the CPU times within each round. A further round takes place while the
CPU time of all rounds stays below a limit. A row fails if the results differ by more than its
analysis accepts, 1e-6 for most; the script then ends with an error.
"""

import argparse
import json
import statistics
import sys
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import gearbow as gb
from programs.fleet import DURATION, FOLDER, LINEAR, OPTIONAL, OTHERS, Machine, Work
from programs.timing import ROUNDS, in_rounds, measured, median_ratio, one_thread

STORED = Path(__file__).with_name("fleet.json")
LIMIT = 10.0  # CPU time of all rounds of one analysis, s
ANALYSES = {**OTHERS, **LINEAR, **OPTIONAL}
MACHINES = tuple(path.stem for path in sorted(FOLDER.glob("*.toml")))


@dataclass(frozen=True)
class Measured:
    """Cost of an analysis of one machine.

    Parameters
    ----------
    setting : str
        What is computed.
    cpu, wall : float
        CPU time and wall time of gearbow [s].
    scipy_cpu : float, optional
        CPU time of SciPy [s]. Without, only gearbow carries out the analysis.
    ratio : float, optional
        CPU time of gearbow divided by that of SciPy.
    difference : float, optional
        Largest relative difference of the results.
    accepted : float
        Difference above which the row fails.
    """

    setting: str
    cpu: float
    wall: float
    scipy_cpu: float | None = None
    ratio: float | None = None
    difference: float | None = None
    accepted: float = 1e-6


def measure(work: Work) -> Measured:
    """Measure an analysis of one machine in turn by the programs that carry it out."""
    found, first = measured(work.gearbow)
    costs = {"gearbow": [first]}
    works = {"gearbow": lambda: measured(work.gearbow)[1]}
    difference = None
    if work.scipy is not None and work.difference is not None:
        prepare = work.scipy
        exact, peer = measured(prepare)
        difference = work.difference(found, exact)
        costs["SciPy"] = [peer]
        works["SciPy"] = lambda: measured(prepare)[1]
    total = sum(cost.cpu for values in costs.values() for cost in values)
    further = in_rounds(works, min(ROUNDS, max(1, int(LIMIT / total))) - 1)
    for name, values in further.items():
        costs[name] += values
    cpu = {name: [cost.cpu for cost in values] for name, values in costs.items()}
    return Measured(
        work.setting,
        statistics.median(cpu["gearbow"]),
        statistics.median(cost.wall for cost in costs["gearbow"]),
        statistics.median(cpu["SciPy"]) if difference is not None else None,
        median_ratio(cpu["gearbow"], cpu["SciPy"]) if difference is not None else None,
        difference,
        work.accepted,
    )


def read(path: Path) -> dict[str, dict[str, Any]]:
    """Return the stored results by machine and analysis."""
    if not path.exists():
        return {}
    found: dict[str, dict[str, Any]] = json.loads(path.read_text("utf-8"))
    return found


def store(path: Path, machine: Machine, analysis: str, result: Measured | str | None) -> None:
    """Store one result, or why the machine has none; without both, remove it."""
    stored = read(path)
    of_machine = stored.setdefault(machine.name, {"measured": {}})
    of_machine["coordinates"] = len(machine.system.dofs)
    if result is None:
        of_machine["measured"].pop(analysis, None)
    else:
        known = {"lacking": result} if isinstance(result, str) else asdict(result)
        of_machine["measured"][analysis] = known
    path.write_text(json.dumps(stored, indent=1, sort_keys=True) + "\n", "utf-8")


def readable(seconds: float) -> str:
    """Return a time with its unit."""
    return f"{seconds:.3g} s" if seconds >= 0.9995 else f"{1e3 * seconds:.3g} ms"


@dataclass(frozen=True)
class Row:
    """Result of an analysis of one machine with `size` degrees of freedom, or why it has none."""

    machine: str
    size: int
    analysis: str
    measured: Measured | str


def rows_of(stored: dict[str, dict[str, Any]]) -> list[Row]:
    """Return the stored results, in the order of the machines and the analyses."""
    return [
        Row(
            name,
            stored[name]["coordinates"],
            analysis,
            kept[analysis].get("lacking") or Measured(**kept[analysis]),
        )
        for name in sorted(stored)
        for kept in (stored[name]["measured"],)
        for analysis in ANALYSES
        if analysis in kept
    ]


def linear_table(rows: list[Row]) -> None:
    """Print the rows of both programs."""
    heads = ("machine", "n", "analysis", "gearbow", "SciPy", "gearbow / SciPy", "difference")
    print("\n|", " | ".join(heads), "| wall time |")
    print("|" + "---|" * (len(heads) + 1))
    for row in rows:
        found = row.measured
        if isinstance(found, str):
            lacking = (row.machine, str(row.size), f"`{row.analysis}`: {found}")
            print("|", " | ".join([*lacking, *["–"] * 5]), "|")
            continue
        if found.ratio is None or found.scipy_cpu is None or found.difference is None:
            continue
        failed = "" if found.difference <= found.accepted else " (fails)"
        cells = (
            *(row.machine, str(row.size), f"`{row.analysis}`, {found.setting}"),
            *(readable(found.cpu), readable(found.scipy_cpu), f"{found.ratio:.3g}"),
            *(f"{found.difference:.0e}{failed}", readable(found.wall)),
        )
        print("|", " | ".join(cells), "|")


def other_table(rows: list[Row]) -> None:
    """Print the rows of gearbow alone, and the simulated time per CPU time."""
    heads = [analysis.replace("_", " ") for analysis in OTHERS]
    print("\n| machine | n |", " | ".join(heads), "| simulated s per CPU s |")
    print("|---|---|" + "---|" * (len(heads) + 1))
    for name, size in dict.fromkeys((row.machine, row.size) for row in rows):
        own = {
            row.analysis: row.measured
            for row in rows
            if row.machine == name and isinstance(row.measured, Measured)
        }
        times = [
            f"{readable(own[each].cpu)} ({readable(own[each].wall)})" if each in own else ""
            for each in OTHERS
        ]
        rate = f"{DURATION / own['run'].cpu:.3g}" if "run" in own else ""
        print(f"| {name} | {size} |", " | ".join(times), "|", rate, "|")


def main() -> None:
    """Measure, or print the stored results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--machine", action="append", choices=MACHINES, help="all without")
    parser.add_argument("--analysis", action="append", choices=[*ANALYSES], help="all without")
    parser.add_argument("--stored", action="store_true", help="print the stored results")
    parser.add_argument("--results", type=Path, default=STORED, help="file of the stored results")
    given = parser.parse_args()
    path: Path = given.results
    failed = []
    if not given.stored:
        one_thread()
        # Warnings of the machines belong to their tests.
        warnings.simplefilter("ignore", gb.AccuracyWarning)
        for name in given.machine or MACHINES:
            machine = Machine(FOLDER / f"{name}.toml")
            for analysis in given.analysis or [*OTHERS, *LINEAR]:
                print(f"{name}, {analysis} ...", file=sys.stderr, flush=True)
                result: Measured | str | None
                try:
                    work = ANALYSES[analysis](machine)
                    result = work if isinstance(work, str) else measure(work)
                except gb.GearbowError as error:
                    failed.append(f"{name}, {analysis}: {type(error).__name__}: {error}")
                    result = None
                if (
                    isinstance(result, Measured)
                    and not (result.difference or 0.0) <= result.accepted
                ):
                    failed.append(f"{name}, {analysis}: difference {result.difference:.1e}")
                store(path, machine, analysis, result)
    rows = rows_of(read(path))
    linear_table(rows)
    other_table(rows)
    if failed:
        sys.exit("\n".join(failed))


if __name__ == "__main__":
    main()
