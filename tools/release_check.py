"""Build the wheel and the source distribution, check both, and use them in clean environments.

    make release-check

Checks what the files of the project state (tools/metadata.py), the workflows (check-jsonschema),
the metadata (twine), the stable ABI (abi3audit), the symbols of glibc (auditwheel), the contents
(check-wheel-contents), and that wheel and list of licences are complete. Then it installs the wheel
and the source distribution on the oldest supported Python and on the newest that this machine has,
and uses them (tools/use_package.py). It says which versions of Python it did not check.
"""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import metadata

ROOT = Path(__file__).resolve().parents[1]
#: Newest version of glibc whose symbols a wheel for `manylinux2014` may use.
GLIBC = (2, 17)
#: Environment in which the source distribution is compiled: quickly, and its dependencies once.
#: Installation and completeness are checked, not the cost of a run.
QUICK = {
    "CARGO_TARGET_DIR": str(ROOT / "target" / "source"),
    "CARGO_PROFILE_RELEASE_OPT_LEVEL": "1",
}
#: Licence files that the wheel contains: that of gearbow, and those of the compiled dependencies.
LICENCES = ("LICENSE", "LICENSES-DEPENDENCIES.txt")
#: Files with a schema, by its name.
SCHEMAS = {
    "github-workflows": ".github/workflows/*.yml",
    "github-issue-forms": ".github/ISSUE_TEMPLATE/[!c]*.yml",
    "github-issue-config": ".github/ISSUE_TEMPLATE/config.yml",
    "dependabot": ".github/dependabot.yml",
    "citation-file-format": "CITATION.cff",
}


def main() -> None:
    """Run all checks; the first that fails ends the program."""
    version = metadata.version()
    call(sys.executable, "tools/metadata.py")
    for schema, pattern in SCHEMAS.items():
        files = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob(pattern))
        call(*tool("check-jsonschema", "--builtin-schema", f"vendor.{schema}", *files))
    with tempfile.TemporaryDirectory() as folder:
        wheel, source = build(Path(folder))
        call(*tool("twine", "check", "--strict", str(wheel), str(source)))
        call(*tool("abi3audit", "--strict", str(wheel)))
        call(*tool("check-wheel-contents", str(wheel)))
        assert wheel.name.startswith(f"gearbow-{version}-cp310-abi3-"), wheel.name
        licences(wheel)
        dependencies()
        if sys.platform == "linux":
            symbols(wheel)
        use(wheel, source)
        kept = ROOT / "dist"
        kept.mkdir(exist_ok=True)
        for file in (wheel, source):
            shutil.copy2(file, kept)
            print(f"dist/{file.name}: {file.stat().st_size / 1e6:.1f} MB")


def build(place: Path) -> tuple[Path, Path]:
    """Build the source distribution, and the wheel from it."""
    options = ["--zig", "--compatibility", "manylinux2014"] if sys.platform == "linux" else []
    build = ("build", "--release", "--locked", "--sdist", "--out", str(place), *options)
    call(*tool("maturin", *build, "--interpreter", sys.executable))
    [wheel], [source] = place.glob("*.whl"), place.glob("*.tar.gz")
    return wheel, source


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


def symbols(wheel: Path) -> None:
    """Check the versions of the symbols of glibc that a wheel uses."""
    report = json.loads(output(*tool("auditwheel", "show", "--json", str(wheel))))
    used = re.findall(r"GLIBC_(\d+)\.(\d+)", json.dumps(report))
    newest = max((int(major), int(minor)) for major, minor in used)
    print(f"{wheel.name}: needs glibc {newest[0]}.{newest[1]}")
    if newest > GLIBC or f"manylinux_{GLIBC[0]}_{GLIBC[1]}_" not in wheel.name:
        raise SystemExit(f"{wheel.name}: is no wheel for manylinux2014")


def use(wheel: Path, source: Path) -> None:
    """Use wheel and source distribution on the oldest and the newest Python of this machine."""
    supported = metadata.pythons()
    found = {version: path for version in supported if (path := interpreter(version))}
    chosen = [version for version in supported if version in found]
    chosen = sorted({*chosen[-1:], *(supported[:1] if supported[0] in found else [])})
    for version in chosen:
        for package in (wheel, source):
            call(found[version], "tools/use_package.py", str(package), environment=QUICK)
    for version in supported:
        if version not in chosen:
            why = "is not on this machine" if version not in found else "is neither end"
            print(f"Python {version}: not checked, it {why}")


def interpreter(version: str) -> str | None:
    """Find a Python of a version that can make environments."""
    name = f"python{version}"
    folder = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    others = sorted(map(str, folder.glob(f"{version}.*/bin/{name}")))
    question = "import ensurepip, sys, venv; print('%d.%d' % sys.version_info[:2])"
    for path in (shutil.which(name), *others, sys.executable, shutil.which("python3")):
        if path is not None:
            asked = subprocess.run(
                [path, "-c", question], check=False, capture_output=True, text=True
            )
            if asked.stdout.strip() == version:
                return path
    return None


def tool(name: str, *arguments: str) -> list[str]:
    """Give the command of a tool that is installed beside this interpreter."""
    return [str(Path(sys.executable).parent / name), *arguments]


def call(*command: str, environment: dict[str, str] | None = None) -> None:
    """Run a command; its failure ends the program."""
    print("+", Path(command[0]).name, *command[1:], flush=True)
    variables = {**os.environ, **(environment or {})}
    done = subprocess.run(command, cwd=ROOT, env=variables, check=False)
    if done.returncode:
        raise SystemExit(f"{Path(command[0]).name} failed with status {done.returncode}")


def output(*command: str) -> str:
    """Return what a command prints."""
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


if __name__ == "__main__":
    print(f"Python {platform.python_version()}, {platform.platform()}")
    main()
