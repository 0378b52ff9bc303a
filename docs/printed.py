"""Keep the blocks of the documents that a command prints.

Such a block stands between ``<!-- printed by: COMMAND -->`` and ``<!-- end -->``. This script
writes what the commands print now; with ``--check`` it changes nothing and fails if a block
differs. Blocks that are ``measured by`` their command hold times, which are never twice the same,
or errors near round-off, which are not on two machines: only ``--measured`` writes these, and
nothing else. Blocks that are ``studied by`` their command
take minutes unless the runs of the study are kept: they are for ``--studied``.
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = r"(<!-- {} by: (.+?) -->\n).*?(<!-- end -->)"


def printed(command: str) -> str:
    """Run a Python script of the repository."""
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
    """Write or check the documents."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--check", action="store_true", help="only say whether a block differs")
    parser.add_argument("--measured", action="store_true", help="write the blocks that hold times")
    parser.add_argument("--studied", action="store_true", help="write the blocks of the bow study")
    given = parser.parse_args()
    check: bool = given.check
    kind = "measured" if given.measured else "studied" if given.studied else "printed"
    block = re.compile(BLOCK.format(kind), re.DOTALL)
    stale = []
    for document in DOCUMENTS:
        old = document.read_text(encoding="utf-8")
        new = block.sub(lambda found: f"{found[1]}{printed(found[2])}{found[3]}", old)
        if new != old:
            stale.append(str(document.relative_to(ROOT)))
            if not check:
                document.write_text(new, encoding="utf-8")
    if check and stale:
        sys.exit(f"{', '.join(stale)}: differs from what its commands print; run: make readme")


if __name__ == "__main__":
    main()
