"""Bow study: what residual bow does to a double-stage train, as tables and figures.

``python examples/bow_study/study.py --out study`` makes the runs that the folder lacks and writes
tables and figures; ``--quick`` makes a small part. An interrupted study continues with the missing
runs. docs/study.md contains the results; ``make study`` updates them.
"""

import argparse
import csv
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path

import drawings
from cases import Settings, quick
from findings import TABLES
from runs import GEAR, MESH, Study, run


def main() -> None:
    """Make the study, or print one of its tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("study"), help="folder for all files")
    parser.add_argument("--quick", action="store_true", help="make a small part of the study only")
    parser.add_argument("--workers", type=int, help="number of parallel runs; default: all cores")
    parser.add_argument("--print", choices=list(TABLES), dest="table", help="print one table only")
    given = parser.parse_args()
    folder: Path = given.out
    settings = quick(Settings()) if given.quick else Settings()
    stores = folder / ("quick" if given.quick else "runs")
    executor = None if given.workers is None else ThreadPoolExecutor(given.workers)
    study = run(settings, stores, executor, progress=sys.stderr.isatty())
    if given.table:
        print(TABLES[given.table](study))
        return
    write(study, folder)
    print(f"{len(study.results)} runs; tables: {folder}")
    for path in drawings.write(study, folder):
        print(f"figure: {path}")


def write(study: Study, folder: Path) -> None:
    """Write the tables in Markdown, and the values of all runs as a CSV file."""
    tables = [f"## {name}\n\n{table(study)}" for name, table in TABLES.items()]
    text = "\n\n".join(["# Bow study", *tables])
    (folder / "findings.md").write_text(f"{text}\n", encoding="utf-8")
    signals = [(gear, name, unit) for gear in study.gears for name, unit in GEAR.items()]
    signals += [(pair, name, unit) for pair in study.pairs for name, unit in MESH.items()]
    values = ("mean", "smallest", "largest", "peak_to_peak")
    with (folder / "runs.csv").open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow([*asdict(study.base), "events", "of", "quantity", "unit", *values])
        for case, found in study.results.items():
            for of, name, unit in signals:
                numbers = [getattr(found, value)(of, name) for value in values]
                rows.writerow([*asdict(case).values(), found.events, of, name, unit, *numbers])


if __name__ == "__main__":
    main()
