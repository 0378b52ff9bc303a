"""Run the tests of this folder and print their guarantees and margins as the tables of
docs/limits.md.
"""

from __future__ import annotations

import math
import sys
from collections import defaultdict
from pathlib import Path

import pytest

HERE = Path(__file__).parent


class Limits:
    """A pytest plugin that collects the records of the fixture `hold` for each test file."""

    def __init__(self) -> None:
        self.rows: dict[str, list[tuple[str, str, float, float, str]]] = defaultdict(list)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        for name, value in report.user_properties if report.when == "call" else ():
            if name == "limit":
                self.rows[report.location[0]].append(value)


def below(value: float) -> str:
    """Round an error up to a power of ten, above 0.05 to tenths: the output does not depend on the
    machine.
    """
    if value > 0.05:
        return f"{math.ceil(10 * value) / 10:g}"
    return f"1e{math.ceil(math.log10(value)):d}" if value > 0 else "0"


def table(rows: list[tuple[str, str, float, float, str]]) -> str:
    lines = [
        "| property | tested range | tolerance | measured error below | warning or error at the limit |",
        "|---|---|---|---|---|",
    ]
    for promise, through, found, allowed, beyond in rows:
        held = f"{allowed:g}".replace("e-0", "e-") if allowed > 1e-300 else "0"
        lines.append(f"| {promise} | {through} | {held} | {below(found)} | {beyond} |")
    return "\n".join(lines)


def main() -> None:
    limits = Limits()
    options = ["-p", "no:terminal", "-p", "no:cacheprovider", str(HERE)]
    failed = pytest.main(options, plugins=[limits])
    if failed:
        sys.exit(f"the tests in {HERE.name} do not pass")
    for file, rows in sorted(limits.rows.items()):
        theme = Path(file).stem.removeprefix("test_").replace("_", " ")
        print(f"\n**{theme.capitalize()}**\n\n{table(rows)}")


if __name__ == "__main__":
    main()
