"""Build the page that runs gearbow in a browser: one file, which works without a network.

It needs a Rust compiler with the target wasm32-unknown-unknown, the program wasm-bindgen of the
version of the crate, and the Python package plotly, whose script the page embeds:

    python web/build.py target/web/try.html

A compiler without the target can build the standard library from its sources. Debian 12 has both
(`apt install rustc-web cargo-web rust-web-src lld`); the environment then is

    PATH=/usr/bin:$PATH RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1
    CARGO_UNSTABLE_BUILD_STD=std,panic_abort CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=wasm-ld
"""

import argparse
import base64
import json
import os
import re
import shutil
import subprocess
import sys
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path

import gearbow as gb
from gearbow.units import fields, parse

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "web" / "page"
TARGET = "wasm32-unknown-unknown"
BUILT = ROOT / "target" / "web"
#: Highest speed of the diagrams over the rated speed.
SPEED_RANGE = 1.5
#: Machines of the page; it shows the first one when it opens.
MACHINES = (
    "double_stage_train",
    "geared_pair",
    "bowed_rotor",
    "idler_train",
    "coaxial_reducer",
    "helical_gear",
    "overhung_rotor",
)


def missing() -> list[str]:
    """List what the build needs and does not find, with the way to get it."""
    found = []
    library = subprocess.run(
        [os.environ.get("RUSTC", "rustc"), "--print", "target-libdir", "--target", TARGET],
        capture_output=True,
        text=True,
        check=False,
    )
    has_library = list(Path(library.stdout.strip()).glob("libcore-*"))
    if not has_library and "CARGO_UNSTABLE_BUILD_STD" not in os.environ:
        found.append(
            f"the Rust target {TARGET}: `rustup target add {TARGET}`, or on Debian 13 and later "
            "`apt install rustc libstd-rust-dev-wasm32 lld`"
        )
    lock = (ROOT / "web" / "Cargo.lock").read_text(encoding="utf-8")
    version = re.findall(r'name = "wasm-bindgen"\nversion = "(.+)"', lock)[0]
    bindgen = shutil.which("wasm-bindgen")
    is_same = bindgen and version in subprocess.check_output([bindgen, "--version"], text=True)
    if not is_same:
        found.append(
            f"wasm-bindgen {version}: `cargo install wasm-bindgen-cli --version {version}`"
        )
    if find_spec("plotly") is None:
        found.append("the Python package plotly: `pip install plotly`")
    return found


def compile_program() -> tuple[str, bytes]:
    """Compile the crate; return the script that loads it, and the program."""
    command = ["cargo", "build", "--release", "--locked", "--target", TARGET, "--target-dir", BUILT]
    subprocess.run(command, cwd=ROOT / "web", check=True)
    program = BUILT / TARGET / "release" / "gearbow_web.wasm"
    command = ["wasm-bindgen", "--target", "no-modules", "--no-typescript", "--out-dir", BUILT]
    subprocess.run([*command, program], check=True)
    script = (BUILT / "gearbow_web.js").read_text(encoding="utf-8")
    return script, (BUILT / "gearbow_web_bg.wasm").read_bytes()


def units() -> dict[str, object]:
    """Return the table of units of the package in the form of `web/src/units.rs`."""

    def unit(ten: int, factor: Fraction, pi: int, dimension: tuple[int, int, int]) -> object:
        return {"ten": ten, "factor": float(factor), "pi": pi, "dimension": dimension}

    with_prefix = {
        name: unit(ten, Fraction(1), 0, dimension)
        for name, (ten, dimension) in parse.WITH_PREFIX.items()
    }
    others = {
        name: unit(0, factor, pi, dimension)
        for name, (factor, pi, dimension) in parse.OTHERS.items()
    }
    frequencies = {
        name: unit(0, factor, pi, (0, 0, -1)) for name, (factor, pi) in parse.FREQUENCIES.items()
    }
    return {
        "fields": fields.FIELDS,
        "prefixes": parse.PREFIXES,
        "with_prefix": with_prefix,
        "others": others,
        "frequencies": frequencies,
        "signs": parse.SIGNS,
    }


def examples() -> dict[str, dict[str, object]]:
    """Give the machines of the page with their rated speed."""
    machines = gb.examples()
    return {
        name: {
            "scene": machines[name].path.read_text(encoding="utf-8"),
            "speed_rpm": machines[name].speed / gb.rpm(1),
            "fastest_rpm": SPEED_RANGE * machines[name].speed / gb.rpm(1),
        }
        for name in MACHINES
    }


def page() -> str:
    """Put everything into one page."""
    import plotly.offline  # noqa: PLC0415  # only where the page can be built

    glue, program = compile_program()

    def in_script(value: object) -> str:
        return json.dumps(value, ensure_ascii=False).replace("</", "<\\/")

    parts = {
        "style": (PAGE / "style.css").read_text(encoding="utf-8"),
        "script": (PAGE / "page.js").read_text(encoding="utf-8"),
        "plotly": plotly.offline.get_plotlyjs(),
        "glue": glue,
        "program": base64.b64encode(program).decode(),
        "units": in_script(units()),
        "examples": in_script(examples()),
    }
    text = (PAGE / "page.html").read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda part: parts[part[1]], text)


def main() -> int:
    """Build the page, or say what is missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path)
    given = parser.parse_args()
    lacking = missing()
    if lacking:
        print("The page to try gearbow is left out. It needs:", file=sys.stderr)
        for line in lacking:
            print(f"- {line}", file=sys.stderr)
        return 2
    given.path.parent.mkdir(parents=True, exist_ok=True)
    given.path.write_text(page(), encoding="utf-8")
    print(f"{given.path}: {given.path.stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
