"""Install a wheel or a source distribution in a new environment, and use it there.

    python tools/use_package.py dist/gearbow-0.2.0.tar.gz

It runs the example of the README, compares what it prints, and runs the program `gearbow`. It needs
nothing but a Python with venv, of the version to be checked, and runs on every system.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: The first Python block of the README with its output.
EXAMPLE = re.compile(r"^```python\n(.*?)^```\n\n```text\n(.*?)^```$", re.MULTILINE | re.DOTALL)
#: Commands of the program, in the order of their use.
COMMANDS = (
    ["--version"],
    ["new", "train.toml"],
    ["check", "train.toml"],
    ["modes", "train.toml", "--speed", "1500 rpm"],
    ["run", "train.toml", "--duration", "0.01", "--speed", "1500 rpm", "--out", "run.npz"],
)


def main() -> None:
    """Install and use a package; the first failure ends the program."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("package", type=Path, help="a wheel or a source distribution")
    package: Path = parser.parse_args().package.resolve(strict=True)
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        call(sys.executable, "-m", "venv", "environment", place=place)
        programs = place / "environment" / ("Scripts" if os.name == "nt" else "bin")
        python = str(programs / "python")
        # A missing wheel of NumPy must not start its compilation.
        pip = ("-m", "pip", "install", "--quiet", "--disable-pip-version-check")
        call(python, *pip, "--only-binary", "numpy", str(package), place=place)
        code, expected = example()
        printed = call(python, "-I", "-c", code, place=place)
        if printed.split() != expected.split():
            raise SystemExit(f"the example printed {printed!r}, not {expected!r}")
        for command in COMMANDS:
            call(str(programs / "gearbow"), *command, place=place)
    libc = " ".join(platform.libc_ver()).strip() or "no glibc"
    seconds = time.monotonic() - start
    print(
        f"{package.name}: works on Python {platform.python_version()}, {platform.system()} "
        f"{platform.machine()}, {libc} ({seconds:.0f} s)"
    )


def example() -> tuple[str, str]:
    """Give the code of the example of the README, and what it prints."""
    found = EXAMPLE.search((ROOT / "README.md").read_text(encoding="utf-8"))
    if found is None:
        raise SystemExit("README.md has no example with its output")
    return found[1], found[2]


def call(*command: str, place: Path) -> str:
    """Run a command in a folder, and return what it prints."""
    done = subprocess.run(
        command,
        cwd=place,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
    )
    if done.returncode:
        shown = " ".join(command[:6])
        raise SystemExit(f"{shown}: failed with status {done.returncode}\n{done.stdout}")
    return done.stdout


if __name__ == "__main__":
    main()
