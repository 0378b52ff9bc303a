"""Plant faults in a copy of the band solver of the Rust core and check that a test fails.

    python tests/mutation/core.py [WORD ...]

With words, the script plants only faults whose module or source text contains one of them. Each
fault compiles the copy anew, which takes one to two minutes. The exit status is 1 if the tests miss
a fault. `tests/python/test_planted_faults.py` checks that each text occurs once in its file.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from faults import Fault

ROOT = Path(__file__).parents[2]
#: Time limit of the build and of the tests of a fault [s].
PATIENCE = 3600.0
#: What the crate and its tests consist of.
PARTS = ("Cargo.toml", "Cargo.lock", "README.md", "src", "tests", "benches", "examples")

#: Modules relative to `src`, and the modules of tests that must catch the fault.
FAULTS = (
    # Woodbury's formula
    Fault(
        "linalg/coupled_bands.rs",
        "                *x -= value * force;",
        "                *x += value * force;",
        ("structured",),
    ),
    Fault(
        "linalg/couplings.rs",
        "            matrix[(i, i)] -= damper;",
        "            matrix[(i, i)] += damper;",
        ("structured",),
    ),
    Fault(
        "linalg/coupled_bands.rs",
        "Determinant::product(chains.chain(capacity.pivots()))",
        "Determinant::product(chains)",
        ("structured",),
    ),
    # a coupling between chains that is lost
    Fault(
        "linalg/coupled_bands.rs",
        "*self.couplings.entry((row, column)).or_default() += value;",
        "if row < column { *self.couplings.entry((row, column)).or_default() += value; }",
        ("structured",),
    ),
    # a coupling between the nodes of a band
    Fault(
        "linalg/band_order.rs",
        "            None => unknown + unknown / per_node * per_element,",
        "            None => unknown,",
        ("structured",),
    ),
    # circular coordinates
    Fault(
        "model/dynamic_stiffness.rs",
        "    for sign in [-1.0, 1.0] {",
        "    for sign in [1.0, -1.0] {",
        ("structured",),
    ),
    # the count of modes
    Fault(
        "modal/lowest.rs",
        "if missing == Some(0) && chosen",
        "if missing.is_some() && chosen",
        ("structured",),
    ),
    Fault(
        "modal/contour.rs",
        "let zeros = at.ln() * known.zeros as f64;",
        "let zeros = at.ln() * 0.0;",
        ("structured",),
    ),
    # the bound of the damping ratios ignores strong dampers
    Fault(
        "modal/bound.rs",
        "        damping: Complex64::from(-1.0),",
        "        damping: Complex64::ZERO,",
        ("structured",),
    ),
)


def main(words: list[str]) -> int:
    """Plant the faults and print the result of each."""
    chosen = [
        fault
        for fault in FAULTS
        if not words or any(word in fault.module or word in fault.text for word in words)
    ]
    copy = ROOT / "target" / "faults"
    shutil.rmtree(copy, ignore_errors=True)
    for part in PARTS:
        source = ROOT / part
        if source.is_dir():
            shutil.copytree(source, copy / part)
        else:
            copy.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, copy / part)
    if outcome(copy, tuple(sorted({name for fault in chosen for name in fault.tests}))) != "missed":
        raise SystemExit("the tests fail without a fault")
    caught = 0
    for fault in chosen:
        begin = time.perf_counter()
        path = copy / "src" / fault.module
        source = path.read_text(encoding="utf-8")
        path.write_text(source.replace(fault.text, fault.replacement), encoding="utf-8")
        what = outcome(copy, fault.tests)
        path.write_text(source, encoding="utf-8")
        caught += what == "caught"
        took = time.perf_counter() - begin
        change = f"{fault.text.strip()} → {fault.replacement.strip()}"
        print(f"{what:7} {took:5.1f} s  {fault.module}: {change}", flush=True)
    print(f"{caught} of {len(chosen)} faults caught")
    return int(caught < len(chosen))


def outcome(copy: Path, tests: tuple[str, ...]) -> str:
    """Give "missed" if all tests pass, "caught" if one fails, or "no run" if the copy is invalid."""
    if cargo_test(copy, "--no-run"):
        return "no run"
    return "caught" if cargo_test(copy, "--", *(f"{name}::" for name in tests)) else "missed"


def cargo_test(copy: Path, *arguments: str) -> int:
    """Build or run the tests of the copy; give the exit status."""
    done = subprocess.run(
        ["cargo", "test", "--locked", "--test", "rust", *arguments],
        cwd=copy,
        env={**os.environ, "CARGO_TARGET_DIR": str(ROOT / "target")},
        capture_output=True,
        timeout=PATIENCE,
        check=False,
    )
    return done.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
