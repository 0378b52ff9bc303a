"""Arguments of commands: how they are declared, those that commands share, and their texts."""

import argparse
from collections.abc import Callable, Container
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from gearbow._extras import extra
from gearbow._files import check_name, check_output
from gearbow._types import Array
from gearbow.accuracy import LEVELS
from gearbow.cli.systems import add_options
from gearbow.errors import GearbowError, SceneError
from gearbow.recording import container
from gearbow.recording.container import ARCHIVE, EXPORT, require_netcdf
from gearbow.results.response import Response
from gearbow.results.run_figures import PLOT_KINDS
from gearbow.results.steady import SteadyState
from gearbow.system.rotor_system import RotorSystem
from gearbow.units.parse import parsed
from gearbow.units.speed import (
    as_given,
    given_unit,
    other_unit,
    parsed_speed,
    speed_factor,
)

#: What adds an argument, or several, to the parser of a command.
Argument: TypeAlias = Callable[[argparse.ArgumentParser], "argparse.Action | None"]


def option(name: str, text: str, read: Callable[[str], object] = str, **settings: Any) -> Argument:
    """Declare an argument: its help, its type, and settings of `ArgumentParser.add_argument`."""
    return lambda parser: parser.add_argument(name, help=text, type=read, **settings)


def flag(name: str, text: str) -> Argument:
    """Declare an option without a value."""
    return lambda parser: parser.add_argument(name, action="store_true", help=text)


def number(name: str, default: int, text: str) -> Argument:
    """Declare an option whose value is a whole number."""
    return option(name, f"{text}; default: {default}", int, default=default)


def quantity(field: str) -> Callable[[str], float]:
    """Make the type of an argument with a unit; a plain number is in SI units."""

    def read(text: str) -> float:  # numpydoc ignore=GL08
        try:
            return (parsed_speed if field == "speed" else parsed)(text, field, bare=True)
        except SceneError as error:
            raise argparse.ArgumentTypeError(str(error).removeprefix(f"{field}: ")) from None

    return read


speed = quantity("speed")


def spectrum_case(text: str) -> tuple[float, float, float]:
    """Read a case of a load spectrum: speed, torque and share of the time."""
    parts = text.split(",")
    if len(parts) != 3:
        raise argparse.ArgumentTypeError(
            f'must be "speed, torque, share", such as "1500 rpm, 250 N m, 0.6", got "{text}"'
        )
    torque, share = quantity("spectrum.torque"), quantity("spectrum.share")
    return speed(parts[0]), torque(parts[1]), share(parts[2])


def output(text: str) -> Path:
    """Read the name of a file for signals, and check that it can be written."""
    return _writable(partial(_check_signals, text))


def _check_signals(text: str) -> Path:
    """Require a suffix of a file that holds all signals of a run."""
    path, ending = check_name(text, (ARCHIVE, EXPORT))
    if ending == EXPORT:
        require_netcdf()
    return path


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


JSON = flag("--json", "print JSON in place of text")
RUN = option("run", "file of a run, .npz", Path)
SPEED = option(
    "--speed",
    'speed of the reference shaft, for example "1500 rpm"; a plain number is in rad/s',
    speed,
    required=True,
)
SPEEDS = option("--speed", 'for example "1500 rpm"; or several', speed, nargs="+", required=True)
DURATION = option("--duration", 'for example 0.5 or "500 ms"', quantity("duration"), required=True)
ENDURANCE_LIMIT = option(
    "--endurance-limit",
    'stress amplitude that the shafts endure without a mean stress, for example "250 MPa"',
    quantity("endurance_limit"),
)
TENSILE_STRENGTH = option(
    "--tensile-strength",
    'tensile strength of the shafts, for example "700 MPa"; the endurance limit needs it',
    quantity("tensile_strength"),
)
COUNT = number("--count", 10, "number of modes")


def progress(parser: argparse.ArgumentParser) -> argparse.Action:
    """Add the option for a progress bar."""
    return parser.add_argument(
        "--progress",
        action=argparse.BooleanOptionalAction,
        help="show a progress bar on stderr; default: on a terminal, after 2 s",
    )


ACCURACY = option("--accuracy", "instead of the accuracy of the scene", choices=list(LEVELS))
RECORD = option(
    "--record",
    "names and groups, shaft@position, driver/driven, bearing:shaft@position; default: "
    "gears and meshes, or disks and bearings without gears",
    nargs="+",
    metavar="ITEM",
)
SIGNALS_OUT = option(
    "--out", "save the signals, also after Ctrl-C; .npz, or .nc for other programs", output
)


def scene(others: str = "") -> Argument:
    """Declare the file of the system, its options and the option for JSON."""

    def add(parser: argparse.ArgumentParser) -> None:
        parser.add_argument(
            "scene",
            type=Path,
            help="file of the system: TOML, which `gearbow new` writes, REXS or a rotor of ROSS"
            + (f"; {others}" if others else ""),
        )
        JSON(parser)
        add_options(parser)

    return add


def kind(default: str | None) -> Argument:
    """Declare the kind of a figure of a run."""
    kinds = ", ".join(PLOT_KINDS)
    return option(
        "--kind", f"what a figure of a run shows: {kinds}", choices=PLOT_KINDS, default=default
    )


def drawn(name: str, text: str) -> Argument:
    """Declare the file of a figure."""
    metavar = name.removeprefix("--").upper()
    return option(name, text, figure, dest="figure", metavar=metavar)


def spaced(given: argparse.Namespace) -> Array:
    """Give the values of --from, --to and --points."""
    is_after = given.last > given.first or given.last < -abs(given.first)
    if given.points < 2 or not is_after:
        raise SceneError(
            f"--to: need --points of at least 2, and --to above --from or, of negative speeds, "
            f"below it, got {given.points} points from {given.first:g} to {given.last:g} rad/s"
        )
    values = np.linspace(given.first, given.last, given.points)
    found: Array = as_given(values, given_unit((given.first, given.last)))
    return found


def speed_line(*speeds: float) -> str:
    """Write the speeds in the given unit and in the other one, e.g. "1500 rad/s = 14,324 rpm"."""
    given = given_unit(speeds) or "rad/s"
    other = other_unit(given)
    own = " to ".join(f"{speed_factor(given) * value:.6g}" for value in speeds)
    found = [speed_factor(other) * value for value in speeds]
    texts = [f"{value:,.0f}" if abs(value) >= 1000.0 else f"{value:.5g}" for value in found]
    return f"{own} {given} = {' to '.join(texts)} {other}"


def is_run(path: Path) -> bool:
    """Tell whether a file holds recorded signals, by its ending."""
    return path.suffix.lower() in (ARCHIVE, EXPORT)


def read_run(path: Path) -> Response | SteadyState:
    """Read the file of `run --out`, `run --checkpoint` or `steady --out`."""
    run, about = container.read(path, "run")
    if "branch" in about:
        raise SceneError(f"{path}: is a branch of steady states; read it with Continuation.load")
    return SteadyState.load(path) if "steady" in about else Response._from_record(run)


def items(system: RotorSystem, texts: list[str], name: str) -> list[Any]:
    """Read the items to record that an option names."""
    parts: tuple[Any, ...] = (*system.shafts, *system.gears, *system.disks)
    parts += (*system.supports, *system.housings)
    known = {part.name for part in parts}
    return [named_item(known, text, name) for text in texts]


def named_item(names: Container[Any], text: str, name: str) -> Any:
    """Read one recorded item of an option; the name of a part may contain any sign."""
    if text in names:
        return text
    group = ("bearing",) if text.startswith("bearing:") else ()
    part, sign, position = text.removeprefix("bearing:").rpartition("@")
    if sign:
        return (*group, part, parsed(position, f"{name}.position", bare=True))
    driver, sign, driven = text.partition("/")
    return (driver, driven) if sign else text
