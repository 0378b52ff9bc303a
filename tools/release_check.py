"""Build the wheel and the source distribution, check both, and use them in clean environments.

    python tools/release_check.py

Checks the metadata (twine), the stable ABI (abi3audit), the contents (check-wheel-contents), that
all versions of the project agree, and that the wheel, which is built from the source distribution,
contains the licences. Then it installs the wheel on the oldest and the newest supported Python; in
each environment it runs a bowed rotor and the command `gearbow`.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
#: Oldest supported Python, and the newest that the build supports.
PYTHONS = ("3.10", "3.13")
#: Licence files that the wheel contains: that of gearbow, and those of the compiled dependencies.
LICENCES = ("LICENSE", "LICENSES-DEPENDENCIES.txt")
#: Import, a figure of merit that needs the compiled core, and the version.
SMOKE = """
import gearbow as gb
shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=gb.Bow.half_sine(1e-4))
bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
disk = gb.Disk("disk", "rotor", 0.5, mass=5.0, diametral_inertia=0.01, polar_inertia=0.02)
system = gb.RotorSystem(shafts=[shaft], disks=[disk], bearings=bearings)
response = system.simulate(0.02, 100.0, record=["disk"])
assert 1e-5 < abs(response.displacement("disk")).max() < 1e-3
print("gearbow", gb.__version__)
"""


def main() -> int:
    """Run all checks; the first that fails ends the program."""
    version = versions()
    with tempfile.TemporaryDirectory() as place:
        dist = Path(place) / "dist"
        # With --sdist, maturin builds the wheel from the source distribution.
        build = tool("maturin", "build", "--release", "--locked", "--sdist", "--out", str(dist))
        call(
            *build, "--interpreter", sys.executable, env={"CARGO_TARGET_DIR": str(ROOT / "target")}
        )
        [wheel], [source] = list(dist.glob("*.whl")), list(dist.glob("*.tar.gz"))
        assert f"-{version}-cp310-abi3-" in wheel.name, wheel.name
        call(*tool("twine", "check", "--strict", str(wheel), str(source)))
        call(*tool("abi3audit", "--strict", str(wheel)))
        call(*tool("check-wheel-contents", str(wheel)))
        licences(wheel)
        dependencies()
        for python in PYTHONS:
            use(wheel, python, Path(place) / python)
        kept = ROOT / "dist"
        kept.mkdir(exist_ok=True)
        for file in (wheel, source):
            shutil.copy2(file, kept)
            print(f"{file.name}: {file.stat().st_size / 1e6:.1f} MB")
    return 0


def versions() -> str:
    """Give the version, which Cargo.toml, CITATION.cff and CHANGELOG.md agree on."""
    found = {
        name: re.search(pattern, (ROOT / name).read_text(encoding="utf-8"), re.MULTILINE)
        for name, pattern in (
            ("Cargo.toml", r'^version = "([\d.]+)"'),
            ("CITATION.cff", r"^version: ([\d.]+)$"),
            ("CHANGELOG.md", r"^## \[(\d[\d.]*)\]"),
        )
    }
    stated = {name: match and match[1] for name, match in found.items()}
    if len(set(stated.values())) != 1:
        raise SystemExit(f"the versions differ: {stated}")
    return str(stated["Cargo.toml"])


def licences(wheel: Path) -> None:
    """Check that a wheel contains the licences."""
    with zipfile.ZipFile(wheel) as archive:
        names = [Path(name).name for name in archive.namelist() if ".dist-info/licenses/" in name]
    if missing := sorted(set(LICENCES) - set(names)):
        raise SystemExit(f"{wheel.name} does not contain {missing}")


def dependencies() -> None:
    """Check that the licences are those of the compiled dependencies."""
    listed = (ROOT / LICENCES[1]).read_text(encoding="utf-8")
    tree = ("tree", "--locked", "--features", "python", "--edges", "normal", "--prefix", "none")
    lines = subprocess.run(
        ["cargo", *tree], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.splitlines()
    crates = {tuple(line.split()[:2]) for line in lines if line.strip()}
    absent = [f"{name} {v[1:]}" for name, v in sorted(crates) if name != "gearbow"]
    absent = [crate for crate in absent if f"- {crate}\n" not in listed]
    if absent:
        raise SystemExit(f"{LICENCES[1]} does not list {absent}; run `make licences`")


def use(wheel: Path, python: str, place: Path) -> None:
    """Install a wheel in a new environment, and use it away from the sources."""
    call(*tool("uv", "venv", "--quiet", "--python", python, str(place)))
    call(*tool("uv", "pip", "install", "--quiet", "--python", str(place), str(wheel)))
    interpreter = place / "bin" / "python"
    call(str(interpreter), "-I", "-c", SMOKE, cwd=place)
    call(str(place / "bin" / "gearbow"), "--help", cwd=place, quiet=True)


def tool(name: str, *arguments: str) -> list[str]:
    """Give the command of a tool that is installed beside this interpreter."""
    return [str(Path(sys.executable).parent / name), *arguments]


def call(
    *command: str, cwd: Path = ROOT, env: dict[str, str] | None = None, quiet: bool = False
) -> None:
    """Run a command; its failure ends the program."""
    print("+", Path(command[0]).name, *command[1:], flush=True)
    output = subprocess.DEVNULL if quiet else None
    done = subprocess.run(
        command, cwd=cwd, env={**os.environ, **(env or {})}, stdout=output, check=False
    )
    if done.returncode:
        raise SystemExit(f"{Path(command[0]).name} failed with status {done.returncode}")


if __name__ == "__main__":
    sys.exit(main())
