"""Update the blocks of the documents that contain the output of a command.

Such a block stands between ``<!-- printed by: COMMAND -->`` and ``<!-- end -->``. The script runs
each command and writes its output into the block. ``--check`` changes no file; the script then
fails if a block differs from the output. There are two more kinds of block:

- ``measured by``: the output contains times, which differ in every run, or errors near round-off,
  which differ between machines. ``--measured`` updates only these blocks.
- ``studied by``: the runs take minutes unless stored runs exist. ``--studied`` updates only these
  blocks.

Arguments choose documents: ``python docs/printed.py --measured docs/comparison.md README.md``.
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# The README after them: its summary of the comparison reads docs/comparison.md.
DOCUMENTS = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", ROOT / "paper/paper.md"]
BLOCK = r"(<!-- {} by: (.+?) -->\n).*?(<!-- end -->)"


@cache
def printed(command: str) -> str:
    """Run a Python script of the repository and return its output."""
    _, *arguments = shlex.split(command)
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=ROOT,
        check=True,
        stdout=subprocess.PIPE,
        encoding="utf-8",
        env={**os.environ, "PYTHONUTF8": "1"},
    )
    return done.stdout


def main() -> None:
    """Update or check the documents."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--check", action="store_true", help="fail if a block differs")
    parser.add_argument("--measured", action="store_true", help="update the measured blocks")
    parser.add_argument("--studied", action="store_true", help="update the blocks of the bow study")
    parser.add_argument("documents", nargs="*", type=Path, help="documents; all if none is given")
    given = parser.parse_args()
    check: bool = given.check
    kind = "measured" if given.measured else "studied" if given.studied else "printed"
    block = re.compile(BLOCK.format(kind), re.DOTALL)
    stale = []
    chosen = {path.resolve() for path in given.documents}
    for document in DOCUMENTS:
        if chosen and document not in chosen:
            continue
        old = document.read_text(encoding="utf-8")
        new = block.sub(lambda found: f"{found[1]}{printed(found[2])}{found[3]}", old)
        if new != old:
            stale.append(str(document.relative_to(ROOT)))
            if not check:
                document.write_text(new, encoding="utf-8")
    if check and stale:
        sys.exit(f"{', '.join(stale)}: differs from the output of its commands. Run: make readme")


if __name__ == "__main__":
    main()
