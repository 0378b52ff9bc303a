"""Print the best and the worst of the comparison, from docs/comparison.md and fleet.json."""

import json
import re
from pathlib import Path
from typing import NamedTuple

FOLDER = Path(__file__).resolve().parent
DOCUMENT = FOLDER.parent / "docs" / "comparison.md"
FLEET = FOLDER / "fleet.json"
SCENES = {
    "shaft": "one bowed shaft",
    "pair": "geared pair, constant mesh stiffness",
    "square": "double-stage train, sharp tooth engagement",
    "seats": "double-stage train with elements of 2 mm",
    "live": "double-stage train, live geometry",
    "jeffcott": "run-up of a Jeffcott rotor",
}
ANALYSES = {
    "modes": "modes",
    "campbell": "Campbell diagram",
    "intersection": "one intersection of it",
    "synchronous": "synchronous response",
    "critical_speed_map": "critical speed map",
}


class Case(NamedTuple):
    """One system: cost of gearbow over that of the cheapest other program, and both in words."""

    ratio: float
    words: str


def table(name: str) -> list[list[str]]:
    """Return the cells of the table that `benches/compare.py NAME` printed, with its head."""
    text = DOCUMENT.read_text(encoding="utf-8")
    start = re.escape(f"<!-- measured by: python benches/compare.py {name} -->")
    found = re.search(start + r"\n(.*?)<!-- end -->", text, re.DOTALL)
    lines = found[1].splitlines() if found else []
    cells = [
        [cell.strip() for cell in line.strip("|").split("|")] for line in lines if line[:1] == "|"
    ]
    return [row for row in cells if not row[0].startswith("---")]


def scene(title: str, rows: list[list[str]]) -> Case | None:
    """Compare the cheapest methods that meet the required error; None without another program."""
    meeting = [row for row in rows[1:] if row[4] and "≥" not in row[4]]
    own = [float(row[4]) for row in meeting if row[0] == "gearbow"]
    others = [row for row in meeting if row[0] != "gearbow"]
    if not own or not others:
        return None
    other = min(others, key=lambda row: float(row[4]))
    words = f"{title}: {min(own):.3g} s per simulated s, {other[0]} ({other[1]}) {other[4]} s"
    return Case(min(own) / float(other[4]), words)


def readable(seconds: float) -> str:
    """Return a time with its unit."""
    return f"{seconds:.3g} s" if seconds >= 0.9995 else f"{1e3 * seconds:.3g} ms"


def machines(analysis: str) -> list[Case]:
    """Return the stored results of an analysis of complete machines."""
    cases = []
    for name, machine in json.loads(FLEET.read_text(encoding="utf-8")).items():
        found = machine["measured"].get(analysis)
        if found and found.get("ratio"):
            times = f"{readable(found['cpu'])}, SciPy {readable(found['scipy_cpu'])}"
            words = f"`{name}`, n = {machine['coordinates']}, {found['setting']}: {times}"
            cases.append(Case(found["ratio"], words))
    return cases


def line(title: str, cases: list[Case]) -> str:
    """Return the row of a kind of work: its best and its worst case."""
    best, worst = min(cases), max(cases)
    return f"| {title} | {best.words} | {best.ratio:.3g} | {worst.words} | {worst.ratio:.3g} |"


def main() -> None:
    """Print one row for each kind of work."""
    print("\n| CPU time | best case | gearbow / other | worst case | gearbow / other |")
    print("|---|---|---|---|---|")
    found = [scene(title, table(name)) for name, title in SCENES.items()]
    print(line("time integration", [case for case in found if case is not None]))
    for analysis, title in ANALYSES.items():
        print(line(title, machines(analysis)))


if __name__ == "__main__":
    main()
