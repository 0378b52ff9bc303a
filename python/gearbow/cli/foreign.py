"""``gearbow import``: print the scene file of a system that another program wrote."""

import argparse
from dataclasses import asdict
from pathlib import Path

from gearbow._files import check_name, replacing
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
        '  gearbow import gearbox.rexs --load-case 2 --bearing "other=1e8" --out train.toml\n'
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
            help=f'stiffness of a {name}, for example "6210={unit}"; "6210=none" leaves it out, '
            f'"other={unit}" is for all others without one',
        )
    parser.add_argument("--out", help="write the scene to this file .toml, in UTF-8 on all systems")
    parser.add_argument("--json", action="store_true", help="print JSON in place of text")


def import_(given: argparse.Namespace) -> Answer:
    """Print a scene, or the contents of the file."""
    data: dict[str, object] = {"file": str(given.file)}
    if given.file.suffix.lower() not in ENDINGS:
        if given.list or given.load_case is not None or given.bearing or given.coupling:
            raise SceneError(f"{given.file}: only REXS files have options, and end with .rexs")
        system = RotorSystem.from_ross(given.file)
        return _answer(given, system, f"# From {given.file.name}, a rotor of ROSS", data)
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
    found: dict[str, float | None] = {}
    for each in given:
        name, sign, value = each.rpartition("=")
        if not sign:
            raise SceneError(f'{path}: must be NAME=STIFFNESS, got "{each}"')
        found[name] = None if value.strip() == "none" else parsed(value, path, bare=True)
    return found


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
