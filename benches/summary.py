"""Print the comparison of the README from the tables of docs/comparison.md."""

import re
from pathlib import Path

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "comparison.md"
PROGRAMS = ("gearbow", "SciPy", "ROSS")
SCENES = {
    "shaft": "one bowed shaft",
    "pair": "geared pair, constant mesh stiffness",
    "square": "double-stage train, sharp tooth engagement",
    "seats": "the same with elements of 2 mm",
    "live": "double-stage train, live geometry",
    "jeffcott": "run-up of a Jeffcott rotor",
}
ANALYSES = {
    "modes": "ten modes",
    "campbell": "Campbell diagram, 20 speeds",
    "synchronous": "synchronous response, 1000 speeds",
    "static": "static equilibrium",
}


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


def fastest(rows: list[list[str]], program: str) -> str:
    """Return the cost of the cheapest method of a program that meets the required error."""
    own = [row for row in rows if row[0] == program and row[4]]
    meeting = [row for row in own if "≥" not in row[4]]
    if meeting:
        best = min(meeting, key=lambda row: float(row[4]))
        return f"{best[4]} ({best[1]})" if program != "gearbow" else best[4]
    return "error not met" if own else next((row[2] for row in rows if row[0] == program), "–")


def scenes() -> None:
    """Print the costs of time integration."""
    print("\n| CPU s per simulated s | gearbow | SciPy | ROSS |\n|---|---|---|---|")
    for name, title in SCENES.items():
        rows = table(name)
        print(f"| {title} |", " | ".join(fastest(rows, program) for program in PROGRAMS), "|")


def analyses() -> None:
    """Print the costs of analyses, of the geared pair and of the smallest and largest train."""
    print("\n| CPU time, error | system | gearbow | SciPy | ROSS |\n|---|---|---|---|---|")
    for name, title in ANALYSES.items():
        rows = table(name)
        head = rows[0] if rows else []
        trains = [i for i, cell in enumerate(head) if cell.startswith("train")]
        pairs = [i for i, cell in enumerate(head) if cell.startswith("geared pair")]
        for i in [*pairs, *trains[:1], *trains[-1:]]:
            cells = {row[0]: row[i] for row in rows[1:]}
            values = " | ".join(cells.get(program, "–") for program in PROGRAMS)
            print(f"| {title} | {head[i]} | {values} |")


if __name__ == "__main__":
    scenes()
    analyses()
