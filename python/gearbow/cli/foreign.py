"""``gearbow import``: print the scene file of a system that another program wrote."""

import argparse
from dataclasses import asdict
from pathlib import Path

from gearbow.cli.answer import Answer
from gearbow.cli.arguments import Commands, add_command
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
        '  gearbow import gearbox.rexs --load-case 2 --bearing "other=1e8" > train.toml\n'
        "  gearbow import rotor.json > rotor.toml",
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
            help=f'stiffness of a {name}, for example "6210={unit}"; other= is for all others',
        )
    parser.add_argument("--json", action="store_true", help="print JSON in place of text")


def import_(given: argparse.Namespace) -> Answer:
    """Print a scene, or the contents of the file."""
    data: dict[str, object] = {"file": str(given.file)}
    if given.file.suffix.lower() not in ENDINGS:
        if given.list or given.load_case is not None or given.bearing or given.coupling:
            raise SceneError(f"{given.file}: only REXS files have options, and end with .rexs")
        system = RotorSystem.from_ross(given.file)
        return _answer(system, f"# From {given.file.name}, a rotor of ROSS", data)
    contents = rexs_contents(given.file)
    data |= {
        "load_cases": [asdict(case) for case in contents.load_cases],
        "missing": [asdict(each) for each in contents.missing],
        "notes": list(contents.notes),
    }
    if given.list:
        return Answer(contents.table(), data)
    system = RotorSystem.read_rexs(
        given.file,
        load_case=given.load_case,
        bearings=_stiffnesses(given.bearing, "bearings.stiffness"),
        couplings=_stiffnesses(given.coupling, "couplings.torsional_stiffness"),
    )
    return _answer(system, _heading(given, contents), data)


def _stiffnesses(given: list[str], path: str) -> dict[str, float]:
    found = {}
    for each in given:
        name, sign, value = each.rpartition("=")
        if not sign:
            raise SceneError(f'{path}: must be NAME=STIFFNESS, got "{each}"')
        found[name] = parsed(value, path, bare=True)
    return found


def _heading(given: argparse.Namespace, contents: RexsContents) -> str:
    heading = f"# From {given.file.name}, REXS {contents.version} of {contents.application}"
    case = contents.load_cases[(given.load_case or 1) - 1]
    if case.speed is None:
        return heading
    return f'{heading}\n# Load case {case.number}: {case.speed!r} rad/s of "{contents.reference}"'


def _answer(system: RotorSystem, heading: str, data: dict[str, object]) -> Answer:
    return Answer(f"{heading}\n\n{system._model.to_toml()}", data | {"scene": system.description})
