"""``gearbow import``: print the scene file of a system that another program wrote."""

import argparse
import re
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gearbow._files import check_name, replacing
from gearbow.cli.answer import Answer
from gearbow.cli.arguments import Commands, add_command
from gearbow.description.gears import Mesh
from gearbow.errors import SceneError
from gearbow.exchange.rexs import RexsContents, rexs_contents
from gearbow.exchange.rexs_file import ENDINGS
from gearbow.exchange.rexs_joints import CATALOGUE
from gearbow.system.rotor_system import RotorSystem
from gearbow.units.parse import parsed

__all__ = ["add"]

#: Words in place of the values of a bearing or coupling.
_WORDS = {"none": None, CATALOGUE: CATALOGUE}


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "import",
        import_,
        "print the scene of a REXS file (.rexs, .rexsj, .rexsz) or a rotor of ROSS (.toml, .json)",
        "  gearbow import gearbox.rexs --list\n"
        '  gearbow import gearbox.rexs --load-case 2 --bearing "other=1e8" --out train.toml\n'
        "  gearbow import rotor.json > rotor.toml\n"
        '  gearbow import geared.json --mesh "Gear 0/Gear 1=2e8" \\\n'
        '      --centre-line-angle "Gear 0/Gear 1=30 deg" --out geared.toml',
    )
    parser.add_argument("file", type=Path, help="file of another program")
    parser.add_argument(
        "--list", action="store_true", help="print load cases, missing values and notes instead"
    )
    parser.add_argument("--load-case", type=int, help="number of the load case of a REXS file")
    for name, unit, option in (
        ("bearing", "1e8 N/m", "clearance:10 um, damping:500"),
        ("coupling", "1e5 N m/rad", "torsional_stiffness:1e5, torsional_damping:5"),
    ):
        parser.add_argument(
            f"--{name}",
            action="append",
            default=[],
            metavar="NAME=VALUES",
            help=f'stiffness of a {name}, for example "6210={unit}", or its parameters, '
            f'"6210={option}"; "6210=none" leaves it out, "other={unit}" is for all others without '
            "one; a unique part of the name is enough",
        )
    for name, value, of_ross in (
        ("mesh", "STIFFNESS", 'gear_mesh_stiffness, for example "Gear 0/Gear 1=2e8 N/m"'),
        ("centre-line-angle", "ANGLE", 'orientation_angle, for example "Gear 0/Gear 1=30 deg"'),
    ):
        parser.add_argument(
            f"--{name}",
            action="append",
            default=[],
            metavar=f"DRIVER/DRIVEN={value}",
            help=f"two gears of a MultiRotor of ROSS with its {of_ross}",
        )
    parser.add_argument("--out", help="write the scene to this file .toml, in UTF-8 on all systems")
    parser.add_argument("--json", action="store_true", help="print JSON in place of text")


def import_(given: argparse.Namespace) -> Answer:
    """Print a scene, or the contents of the file."""
    data: dict[str, object] = {"file": str(given.file)}
    if given.file.suffix.lower() not in ENDINGS:
        if given.list or given.load_case is not None or given.bearing or given.coupling:
            options = "--list, --load-case, --bearing and --coupling"
            raise SceneError(f"{given.file}: only REXS files have {options}, and end with .rexs")
        system = RotorSystem.from_ross(given.file, meshes=_meshes(given))
        return _answer(given, system, f"# From {given.file.name}, a rotor of ROSS", data)
    if given.mesh or given.centre_line_angle:
        options = "--mesh and --centre-line-angle"
        raise SceneError(
            f"{given.file}: only rotors of ROSS have {options}; REXS files have stages"
        )
    contents = rexs_contents(given.file)
    data |= {
        "load_cases": [asdict(case) for case in contents.load_cases],
        "missing": [asdict(each) for each in contents.missing],
        "notes": list(contents.notes),
    }
    if given.list:
        return Answer(contents.table(), data)
    bearings = _values(given.bearing, "bearings", "stiffness")
    couplings = _values(given.coupling, "couplings", "torsional_stiffness")
    try:
        system = RotorSystem.read_rexs(
            given.file, load_case=given.load_case, bearings=bearings, couplings=couplings
        )
    except SceneError as error:
        options = "the options --load-case, --bearing and --coupling"
        raise SceneError(f"{error}; see --list, and {options}") from None
    return _answer(given, system, _heading(given, contents), data)


def _values(given: list[str], parts: str, stiffness: str) -> dict[str, Any]:
    """Give what an option says of each part: a stiffness, parameters, a word, or None."""
    found: dict[str, Any] = {}
    for name, value in _pairs(given, f"--{parts.removesuffix('s')}", "NAME=VALUES"):
        if value.strip() in _WORDS:
            found[name] = _WORDS[value.strip()]
        elif ":" in value:
            pairs = (each.partition(":") for each in value.split(","))
            found[name] = {
                key.strip(): _value(text, f"{parts}.{key.strip()}") for key, _, text in pairs
            }
        else:
            found[name] = parsed(value, f"{parts}.{stiffness}", bare=True)
    return found


def _value(text: str, path: str) -> float | int | str:
    """Read a parameter of a bearing or coupling; what is no number is a text."""
    plain = text.strip()
    if path.endswith(".designation") or not re.match(r"[-+]?\.?\d", plain):
        return plain
    return int(plain) if plain.isdigit() else parsed(plain, path, bare=True)


def _meshes(given: argparse.Namespace) -> list[Mesh]:
    """Give the meshes of a rotor of ROSS, each with the angle of its line of centres."""
    angles = {
        gears: parsed(value, "meshes.centre_line_angle", bare=True)
        for gears, value in _pairs(
            given.centre_line_angle, "--centre-line-angle", "DRIVER/DRIVEN=ANGLE"
        )
    }
    meshes = []
    for gears, value in _pairs(given.mesh, "--mesh", "DRIVER/DRIVEN=STIFFNESS"):
        driver, sign, driven = gears.partition("/")
        if not sign:
            raise SceneError(f'--mesh: must be DRIVER/DRIVEN=STIFFNESS, got "{gears}={value}"')
        stiffness = parsed(value, "meshes.stiffness", bare=True)
        angle = angles.pop(gears, 0.0)
        meshes.append(Mesh(driver, driven, stiffness=stiffness, centre_line_angle=angle))
    for gears in angles:
        raise SceneError(f'--centre-line-angle: no --mesh is given for "{gears}"')
    return meshes


def _pairs(given: list[str], path: str, form: str) -> Iterator[tuple[str, str]]:
    """Give names and values of an option."""
    for each in given:
        name, sign, value = each.rpartition("=")
        if not sign:
            raise SceneError(f'{path}: must be {form}, got "{each}"')
        yield name, value


def _heading(given: argparse.Namespace, contents: RexsContents) -> str:
    heading = f"# From {given.file.name}, REXS {contents.version} of {contents.application}"
    case = contents.load_cases[(given.load_case or 1) - 1]
    if case.speed is None:
        return heading
    return f'{heading}\n# Load case {case.number}: {case.speed!r} rad/s of "{contents.reference}"'


def _answer(
    given: argparse.Namespace, system: RotorSystem, heading: str, data: dict[str, object]
) -> Answer:
    text = f"{heading}\n\n{system._model.to_toml()}"
    data = data | {"scene": system.description}
    if given.out is None:
        return Answer(text, data)
    path, _ = check_name(given.out, [".toml"], "--out")
    with replacing(path) as file:
        file.write(text.encode())
    return Answer(f"wrote {path}; next: gearbow check {path}", data)
