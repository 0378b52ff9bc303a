"""Systems that commands read: scene files, and files of other programs with what these lack."""

import argparse
import re
from collections.abc import Iterator
from typing import Any

from gearbow.description.gears import Mesh
from gearbow.errors import SceneError
from gearbow.exchange.rexs import rexs_contents
from gearbow.exchange.rexs_joints import CATALOGUE
from gearbow.system.read import REXS, format_of, read
from gearbow.system.rotor_system import RotorSystem
from gearbow.units.parse import parsed

#: Words in place of the values of a bearing or coupling.
_WORDS = {"none": None, CATALOGUE: CATALOGUE}
#: Options of files of other programs, by the argument of `gearbow.read`.
_OPTIONS = {
    "load_case": "--load-case",
    "bearings": "--bearing",
    "couplings": "--coupling",
    "meshes": "--mesh",
}


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of files of other programs."""
    parser = command.add_argument_group("files of other programs")
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


def read_system(given: argparse.Namespace) -> RotorSystem:
    """Read the system of a command with its options."""
    options = read_options(given)
    try:
        return read(given.scene, **options)
    except SceneError as error:
        name, sign, rest = str(error).partition(": ")
        text = f"{_OPTIONS.get(name, name)}{sign}{rest}"
        if format_of(given.scene) == REXS:
            where = "--list" if given.command == "import" else "gearbow import --list"
            text += f"; see {where}, and the options --load-case, --bearing and --coupling"
        raise SceneError(text) from None


def speed_of_file(given: argparse.Namespace) -> float | None:
    """Give the speed of the load case of a REXS file; None without one, and for other files."""
    if format_of(given.scene) != REXS:
        return None
    cases = rexs_contents(given.scene).load_cases
    wanted = [case for case in cases if given.load_case in (None, case.number)]
    return wanted[0].speed if wanted else None


def refuse_options(given: argparse.Namespace) -> None:
    """Refuse the options of systems for the file of a run."""
    for name in read_options(given):
        raise SceneError(f"{_OPTIONS[name]}: is for a system, but {given.scene} is a run")


def read_options(given: argparse.Namespace) -> dict[str, Any]:
    """Give the options as arguments of `gearbow.read`."""
    bearings = _values(given.bearing, "bearings", "stiffness")
    couplings = _values(given.coupling, "couplings", "torsional_stiffness")
    values = (given.load_case, bearings, couplings, _meshes(given))
    pairs = zip(_OPTIONS, values, strict=True)
    return {name: value for name, value in pairs if value not in (None, {}, [])}


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
