"""``gearbow import``: print the scene file of a system that another program wrote."""

import argparse
from dataclasses import asdict

from gearbow._files import check_name, replacing
from gearbow.cli.answer import Answer
from gearbow.cli.arguments import Commands, add_command, add_scene
from gearbow.cli.systems import read_options, read_system
from gearbow.errors import SceneError
from gearbow.exchange.rexs import RexsContents, rexs_contents
from gearbow.system.read import REXS, format_of

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
    add_scene(parser)
    parser.add_argument(
        "--list", action="store_true", help="print load cases, missing values and notes instead"
    )
    parser.add_argument(
        "--out",
        help="write the scene to this file .toml, in UTF-8 on all systems, or to a file .rexs, "
        "with a warning about what REXS cannot hold",
    )


def import_(given: argparse.Namespace) -> Answer:
    """Print a scene, or the contents of the file."""
    read_options(given)  # their errors come before those of the file
    found = format_of(given.scene)
    data: dict[str, object] = {"file": str(given.scene)}
    if given.list and found != REXS:
        raise SceneError(f"--list: is for a {REXS.name}, but {given.scene} is a {found.name}")
    if found == REXS:
        contents = rexs_contents(given.scene)
        data |= {
            "load_cases": [asdict(case) for case in contents.load_cases],
            "missing": [asdict(each) for each in contents.missing],
            "notes": list(contents.notes),
        }
        if given.list:
            return Answer(contents.table(), data)
    system = read_system(given)
    heading = f"# From {given.scene.name}, a {found.name}"
    if found == REXS:
        heading = _heading(given, contents)
    text = f"{heading}\n\n{system._model.to_toml()}"
    data |= {"scene": system.description}
    if given.out is None:
        return Answer(text, data)
    path, ending = check_name(given.out, [".toml", ".rexs"], "--out")
    if ending == ".rexs":
        system.save(path)
    else:
        with replacing(path) as file:
            file.write(text.encode())
    return Answer(f"wrote {path}; next: gearbow check {path}", data)


def _heading(given: argparse.Namespace, contents: RexsContents) -> str:
    heading = f"# From {given.scene.name}, REXS {contents.version} of {contents.application}"
    case = contents.load_cases[(given.load_case or 1) - 1]
    if case.speed is None:
        return heading
    return f'{heading}\n# Load case {case.number}: {case.speed!r} rad/s of "{contents.reference}"'
