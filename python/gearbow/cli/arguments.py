"""Arguments that several commands share."""

import argparse
from collections.abc import Callable, Container
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from gearbow._extras import extra
from gearbow._files import check_name, check_output
from gearbow._types import Array
from gearbow.cli.answer import Answer
from gearbow.cli.systems import add_options
from gearbow.errors import GearbowError, SceneError
from gearbow.recording import file
from gearbow.recording.container import ENDINGS, suffix
from gearbow.results.response import Response
from gearbow.results.run_figures import PLOT_KINDS
from gearbow.results.steady import SteadyState
from gearbow.system.rotor_system import RotorSystem
from gearbow.units.parse import parsed
from gearbow.units.speed import (
    RevolutionsPerMinute,
    SpeedUnit,
    given_unit,
    speed_factor,
    unit_in_texts,
)

__all__ = [
    "Commands",
    "add_command",
    "add_duration",
    "add_kind",
    "add_progress",
    "add_scene",
    "add_speed",
    "figure",
    "is_run",
    "item",
    "named_item",
    "output",
    "quantity",
    "read_run",
    "spaced",
    "speed",
    "speed_line",
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


def add_scene(parser: argparse.ArgumentParser, others: str = "") -> None:
    """Add the file of the system, its options and the option for JSON."""
    parser.add_argument(
        "scene",
        type=Path,
        help="file of the system: TOML, which `gearbow new` writes, REXS or a rotor of ROSS"
        + (f"; {others}" if others else ""),
    )
    parser.add_argument("--json", action="store_true", help="print JSON in place of text")
    add_options(parser)


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
        type=speed,
        required=True,
        help='speed of the reference shaft, for example "1500 rpm"; a plain number is in rad/s',
    )
    add_progress(parser)


def add_progress(parser: argparse.ArgumentParser) -> None:
    """Add the option for a progress bar."""
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


def spaced(given: argparse.Namespace, what: str) -> Array:
    """Give the values of --from, --to and --points."""
    if given.points < 2 or not given.last > given.first:
        raise SceneError(
            f"{what}: need --points of at least 2 and --to above --from, got {given.points} points "
            f"from {given.first:g} to {given.last:g} rad/s"
        )
    values: Array = np.linspace(given.first, given.last, given.points)
    return values


def speed(text: str) -> float:
    """Read a speed; a plain number is in rad/s."""
    value = quantity("speed")(text)
    return RevolutionsPerMinute(value) if unit_in_texts(text) == "rpm" else value


def speed_line(*speeds: float) -> str:
    """Write the speeds in the given unit and in the other one, e.g. "1500 rad/s = 14,324 rpm"."""
    units: tuple[SpeedUnit, ...] = ("rad/s", "rpm")
    given = given_unit(speeds) or "rad/s"
    (other,) = (unit for unit in units if unit != given)
    own = " to ".join(f"{speed_factor(given) * value:.6g}" for value in speeds)
    found = [speed_factor(other) * value for value in speeds]
    texts = [f"{value:,.0f}" if abs(value) >= 1000.0 else f"{value:.5g}" for value in found]
    return f"{own} {given} = {' to '.join(texts)} {other}"


def add_kind(parser: argparse.ArgumentParser, *, default: str | None) -> None:
    """Add the kind of a figure of a run."""
    kinds = ", ".join(PLOT_KINDS)
    parser.add_argument(
        "--kind", choices=PLOT_KINDS, default=default, help=f"what a figure of a run shows: {kinds}"
    )


def is_run(path: Path) -> bool:
    """Tell whether a file holds recorded signals, by its ending."""
    return path.suffix.lower() in ENDINGS


def read_run(path: Path) -> Response | SteadyState:
    """Read the file of `run --out`, `run --checkpoint` or `steady --out`."""
    run, about = file.read(path)
    if "branch" in about:
        raise SceneError(f"{path}: is a branch of steady states; read it with Continuation.load")
    return SteadyState.load(path) if "steady" in about else Response.from_record(run)


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
    """Read one item to record."""
    parts: tuple[Any, ...] = (*system.shafts, *system.gears, *system.disks)
    parts += (*system.supports, *system.housings)
    return named_item({part.name for part in parts}, text)


def named_item(names: Container[Any], text: str) -> Any:
    """Read one recorded item; a name may contain any sign."""
    if text in names:
        return text
    kind = ("bearing",) if text.startswith("bearing:") else ()
    name, sign, position = text.removeprefix("bearing:").rpartition("@")
    if sign:
        return (*kind, name, parsed(position, "position", bare=True))
    driver, sign, driven = text.partition("/")
    return (driver, driven) if sign else text
