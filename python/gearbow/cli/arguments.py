"""Arguments that several commands share."""

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from gearbow._extras import extra
from gearbow._files import check_name, check_output
from gearbow.cli.answer import Answer
from gearbow.errors import GearbowError, SceneError
from gearbow.recording.container import suffix
from gearbow.system.rotor_system import RotorSystem
from gearbow.units.parse import parsed

__all__ = [
    "Commands",
    "add_command",
    "add_duration",
    "add_scene",
    "add_speed",
    "figure",
    "item",
    "output",
    "quantity",
]

#: The subparsers of the program.
Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def add_command(
    commands: Commands,
    name: str,
    call: Callable[[argparse.Namespace], Answer],
    text: str,
    examples: str,
) -> argparse.ArgumentParser:
    """Add a command."""
    parser = commands.add_parser(
        name,
        help=text,
        description=text,
        epilog=f"examples:\n{examples}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(call=call)
    return parser


def add_scene(parser: argparse.ArgumentParser) -> None:
    """Add the scene file and the option for JSON."""
    parser.add_argument(
        "scene", type=Path, help="TOML file of the system; `gearbow new` writes one"
    )
    parser.add_argument("--json", action="store_true", help="print JSON in place of text")


def add_duration(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of a run: duration, speed and progress."""
    parser.add_argument(
        "--duration", type=quantity("duration"), required=True, help='for example 0.5 or "500 ms"'
    )
    add_speed(parser)


def add_speed(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of a computation at a speed: speed and progress."""
    parser.add_argument(
        "--speed",
        type=quantity("speed"),
        required=True,
        help='speed of the reference shaft, for example "1500 rpm"; a plain number is in rad/s',
    )
    parser.add_argument(
        "--progress",
        action=argparse.BooleanOptionalAction,
        help="show a progress bar on stderr; default: on a terminal, after 2 s",
    )


def quantity(field: str) -> Callable[[str], float]:
    """Make the type of an argument with a unit."""

    def read(text: str) -> float:  # numpydoc ignore=GL08
        try:
            return parsed(text, field, bare=True)
        except SceneError as error:
            raise argparse.ArgumentTypeError(str(error).removeprefix(f"{field}: ")) from None

    return read


def output(text: str) -> Path:
    """Read the name of a file for signals, and check that it can be written."""
    return _writable(lambda: suffix(text)[0])


def figure(text: str) -> Path:
    """Read the name of a file for a figure, and check that it can be drawn and written."""
    return _writable(partial(_check_figure, text))


def _check_figure(text: str) -> Path:
    """Require a suffix of a format that matplotlib writes."""
    with extra("plot"):
        from matplotlib.backend_bases import FigureCanvasBase  # noqa: PLC0415
    return check_name(text, [f".{each}" for each in sorted(FigureCanvasBase.filetypes)])[0]


def _writable(check: Callable[[], Path]) -> Path:
    """Check the name of a file and that it can be written."""
    try:
        path = check()
        check_output(path)
    except OSError as error:
        raise argparse.ArgumentTypeError(f"{error.filename}: {error.strerror}") from None
    except GearbowError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("path: ")) from None
    return path


def item(system: RotorSystem, text: str) -> Any:
    """Read one recorded item."""
    parts: tuple[Any, ...] = (*system.shafts, *system.gears, *system.disks)
    parts += (*system.supports, *system.housings)
    if text in {part.name for part in parts}:
        return text
    kind = ("bearing",) if text.startswith("bearing:") else ()
    name, sign, position = text.removeprefix("bearing:").rpartition("@")
    if sign:
        return (*kind, name, parsed(position, "position", bare=True))
    driver, sign, driven = text.partition("/")
    return (driver, driven) if sign else text
