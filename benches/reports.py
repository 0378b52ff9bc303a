"""Cost of a report of each machine of examples/machines at its rated speed.

``python benches/reports.py`` writes the reports into a temporary folder and prints CPU time and
size as a table in Markdown, which docs/report.md contains. It fails if a section is not complete.
"""

import sys
import time
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import gearbow as gb


def main() -> int:
    """Write the reports and print the table."""
    warnings.simplefilter("ignore")  # a report lists the warnings
    incomplete = []
    print("| machine | degrees of freedom | CPU time [s] | size [MB] |")
    print("|---|---|---|---|")
    with TemporaryDirectory() as folder:
        for name, machine in gb.examples().items():
            system = machine.load()
            path = Path(folder) / f"{name}.html"
            begin = time.process_time()
            system.report(path, operating=machine.speed)
            seconds = time.process_time() - begin
            if "Not computed" in path.read_text(encoding="utf-8"):
                incomplete.append(name)
            size = path.stat().st_size / 1e6
            print(f"| {name} | {len(system.dofs)} | {seconds:.0f} | {size:.1f} |", flush=True)
    for name in incomplete:
        print(f"{name}: a section is not complete", file=sys.stderr)
    return 1 if incomplete else 0


if __name__ == "__main__":
    sys.exit(main())
