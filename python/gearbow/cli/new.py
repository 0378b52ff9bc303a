"""``gearbow new``: write a commented example."""

import argparse
from pathlib import Path

from gearbow._files import check_name, replacing
from gearbow.cli.answer import Answer
from gearbow.cli.arguments import Commands, add_command
from gearbow.errors import SceneError

__all__ = ["EXAMPLE", "add"]

#: The scene that the command writes.
EXAMPLE = Path(__file__).with_name("example.toml")


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "new",
        new,
        "write a commented example of a scene file",
        "  gearbow new\n  gearbow new pump.toml",
    )
    parser.add_argument("path", nargs="?", default="scene.toml", help="default: %(default)s")
    parser.add_argument("--force", action="store_true", help="replace an existing file")
    parser.set_defaults(json=False)


def new(given: argparse.Namespace) -> Answer:
    """Write the example."""
    path, _ = check_name(given.path, [".toml"])
    if path.exists() and not given.force:
        raise SceneError(f"{path}: exists; give another name, or --force to replace it")
    with replacing(path) as file:
        file.write(EXAMPLE.read_bytes())
    text = f'wrote {path}; next: gearbow check {path}, gearbow modes {path} --speed "1500 rpm"'
    return Answer(text, {"file": str(path)})
