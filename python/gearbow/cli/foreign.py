"""``gearbow import``: print the scene file of a system that another program wrote."""

import argparse
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

from gearbow._files import check_name, replacing
from gearbow.cli.answer import Answer
from gearbow.cli.arguments import Commands, add_command
from gearbow.description.gears import Mesh
from gearbow.errors import SceneError
from gearbow.exchange.rexs import RexsContents, rexs_contents
from gearbow.exchange.rexs_file import ENDINGS
from gearbow.system.rotor_system import RotorSystem
from gearbow.units.parse import parsed

__all__ = ["add"]


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
    for name, unit in (("bearing", "1e8 N/m"), ("coupling", "1e5 N m/rad")):
        parser.add_argument(
            f"--{name}",
            action="append",
            default=[],
            metavar="NAME=STIFFNESS",
            help=f'stiffness of a {name}, for example "6210={unit}"; "6210=none" leaves it out, '
            f'"other={unit}" is for all others without one',
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
    bearings = _stiffnesses(given.bearing, "bearings.stiffness")
    couplings = _stiffnesses(given.coupling, "couplings.torsional_stiffness")
    try:
        system = RotorSystem.read_rexs(
            given.file, load_case=given.load_case, bearings=bearings, couplings=couplings
        )
    except SceneError as error:
        options = "the options --load-case, --bearing and --coupling"
        raise SceneError(f"{error}; see --list, and {options}") from None
    return _answer(given, system, _heading(given, contents), data)


def _stiffnesses(given: list[str], path: str) -> dict[str, float | None]:
    return {
        name: None if value.strip() == "none" else parsed(value, path, bare=True)
        for name, value in _pairs(given, path, "NAME=STIFFNESS")
    }


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
