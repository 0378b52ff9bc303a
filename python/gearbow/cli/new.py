"""``gearbow new``: write the scene file of an example."""

import argparse
from pathlib import Path

from gearbow._files import check_name, replacing
from gearbow.cli.answer import Answer
from gearbow.cli.arguments import Commands, add_command
from gearbow.errors import SceneError
from gearbow.machines.examples import example, scene_files
from gearbow.units.speed import given_unit, speed_text

__all__ = ["EXAMPLE", "add"]

#: The scene that the command writes by itself: a pair with a comment on each part.
EXAMPLE = Path(__file__).with_name("example.toml")


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "new",
        new,
        "write a commented example of a scene file",
        "  gearbow new\n  gearbow new pump.toml\n  gearbow new --example coaxial reducer.toml",
    )
    parser.add_argument("path", nargs="?", default="scene.toml", help="default: %(default)s")
    known = ", ".join(scene_files())
    parser.add_argument(
        "--example",
        metavar="NAME",
        help=f"a complete machine, by its name or a part of it: {known}",
    )
    parser.add_argument("--force", action="store_true", help="replace an existing file")
    parser.set_defaults(json=False)


def new(given: argparse.Namespace) -> Answer:
    """Write the example."""
    path, _ = check_name(given.path, [".toml"])
    if path.exists() and not given.force:
        raise SceneError(f"{path}: exists; give another name, or --force to replace it")
    machine = None if given.example is None else example(given.example)
    source, speed = EXAMPLE, "1500 rpm"
    if machine is not None:
        source, speed = (
            machine.path,
            speed_text(machine.speed, given_unit(machine.speed) or "rad/s"),
        )
    with replacing(path) as file:
        file.write(source.read_bytes())
    text = f'wrote {path}; next: gearbow check {path}, gearbow modes {path} --speed "{speed}"'
    return Answer(text, {"file": str(path)})
