"""Check the facts that several files state, and report the placeholders.

    python tools/metadata.py [--release]

The address of the repository, the contact and the DOI do not exist yet. Each has one placeholder,
which names the reserved domain placeholder.invalid. With `--release` a placeholder is an error.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: Part of every placeholder. No address can have this domain (RFC 2606).
MARK = "placeholder.invalid"
#: Files that may contain placeholders.
PLACES = ("*.md", "*.toml", "*.cff", "docs/**/*.md", "paper/*", "conda/*", ".github/**/*")
#: Where the version stands.
VERSIONS = {
    "Cargo.toml": r'^version = "([\d.]+)"',
    "Cargo.lock": r'^name = "gearbow"\nversion = "([\d.]+)"',
    "CITATION.cff": r"^version: ([\d.]+)$",
    "CHANGELOG.md": r"^## \[(\d[\d.]*)\]",
    "conda/recipe.yaml": r'^  version: "([\d.]+)"$',
}


def main() -> None:
    """Check the metadata."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--release", action="store_true", help="placeholders are errors")
    release: bool = parser.parse_args().release
    print(f"version {version()}, Python {', '.join(pythons())}")
    found = placeholders()
    print(f"{len(found)} placeholders, to be replaced before a release:")
    for line in found:
        print(f"  {line}")
    if release and found:
        sys.exit("the release would contain placeholders")


def version() -> str:
    """Give the version, which all files agree on."""
    stated = {}
    for name, pattern in VERSIONS.items():
        found = re.search(pattern, (ROOT / name).read_text(encoding="utf-8"), re.MULTILINE)
        stated[name] = found[1] if found else "none"
    if len(set(stated.values())) != 1:
        raise SystemExit(f"the versions differ: {stated}")
    return stated["Cargo.toml"]


def pythons() -> list[str]:
    """Give the supported versions of Python, those of the classifiers, from the oldest on."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    found = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', text)
    oldest = re.search(r'^requires-python = ">=(3\.\d+)"', text, re.MULTILINE)
    if not found or not oldest or found[0] != oldest[1]:
        raise SystemExit(f"pyproject.toml: requires-python is not the first of {found}")
    return found


def placeholders() -> list[str]:
    """Give the file and the line of each placeholder, and its text."""
    files = sorted({path for place in PLACES for path in ROOT.glob(place) if path.is_file()})
    return [
        f"{path.relative_to(ROOT).as_posix()}:{number}: {line.strip()}"
        for path in files
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if MARK in line
    ]


if __name__ == "__main__":
    main()
