"""Arguments of commands: how they are declared, which ones commands share, and what they read."""

import argparse
import inspect
import re
from collections.abc import Callable, Container, Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args, get_origin

import numpy as np

from gearbow._convert import nearest
from gearbow._extras import extra
from gearbow._files import check_name, check_output
from gearbow._types import Array
from gearbow.description.gears import Mesh
from gearbow.errors import GearbowError, SceneError
from gearbow.exchange.rexs import rexs_contents
from gearbow.exchange.rexs_joints import CATALOGUE
from gearbow.identification import unknown
from gearbow.identification.unknown import Unknown
from gearbow.recording import container
from gearbow.recording.container import ARCHIVE, EXPORT, require_netcdf
from gearbow.results.response import Response
from gearbow.results.steady import SteadyState
from gearbow.system.read import REXS, format_of, read
from gearbow.system.rotor_system import RotorSystem
from gearbow.units.fields import DIMENSIONLESS, unit_of
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

#: Parameters that are places, meshes and groups.
PLACES = ("record", "signals", "torque_inputs")


def option(name: str, text: str, read: Callable[[str], object] = str, **settings: Any) -> Argument:
    """Declare an argument: its help, its type, and settings of `ArgumentParser.add_argument`."""
    return lambda parser: parser.add_argument(name, help=text, type=read, **settings)


def flag(name: str, text: str) -> Argument:
    """Declare an option without a value."""
    return lambda parser: parser.add_argument(name, action="store_true", help=text)


def parameter(
    name: str,
    option: str = "",
    text: str = "",
    *,
    of: Callable[..., Any] | None = None,
    **settings: Any,
) -> Argument:
    """Declare an option that is a parameter of the method of the command, or of another method."""
    # Type and default follow from the signature of the method, the help from its documentation;
    # `text` adds to the help, and `settings` replace what follows.
    option = option or f"--{name.replace('_', '-')}"

    def add(parser: argparse.ArgumentParser) -> argparse.Action:  # numpydoc ignore=GL08
        method = of or parser.get_default("analysis")
        found = _of_signature(inspect.signature(method).parameters[name], option)
        said = [*_documented(method, name, found | settings), *([text] if text else [])]
        found["help"] = "; ".join(said).replace("%", "%%")
        return parser.add_argument(option, dest=name, **found | settings)

    return add


def _of_signature(given: inspect.Parameter, option: str) -> dict[str, Any]:
    """Give the settings of an option that follow from the annotation and the default."""
    kind = given.annotation
    if kind is bool:
        return {"action": "store_true"}
    has_default = given.default is not given.empty
    found: dict[str, Any] = {"default": given.default} if has_default else {"required": True}
    for each in (kind, *get_args(kind)):
        if get_origin(each) is Literal:
            return found | {"choices": get_args(each)}
    found["metavar"] = option.removeprefix("--").upper().replace("-", "_")
    if given.name in PLACES:
        return found | {"nargs": "+", "metavar": "ITEM"}
    text = str(kind)
    if "ArrayLike" in text or "Sequence" in text:
        found["nargs"] = "+"
    if unit_of(given.name) not in (None, DIMENSIONLESS):
        return found | {"type": quantity(given.name)}
    return found | {"type": next((each for each in (int, float) if each.__name__ in text), str)}


def _documented(
    method: Callable[..., Any], name: str, settings: Mapping[str, Any]
) -> Iterator[str]:
    """Give the beginning of the text about a parameter, and its default."""
    found = re.search(
        rf"^(?:\w+, )*{name}(?:, \w+)* : .*\n((?:    .*\n)+)", inspect.getdoc(method) or "", re.M
    )
    text = "" if found is None else " ".join(found[1].split())  # python -OO has no documentation
    first = re.split(r"[.;:](?:\s|$)|, as for `", text)[0].removeprefix("Whether to ")
    if first:
        yield first if first[1:2].isupper() else first[0].lower() + first[1:]
    default = settings.get("default")
    if default not in (None, ()):
        yield f"default: {default:g}" if isinstance(default, float) else f"default: {default}"
    elif not settings.get("required"):
        for usual in re.findall(r"None (?:is|gives) (.+?)\.(?:\s|$)", text):
            yield f"default: {usual}"


def quantity(field: str) -> Callable[[str], float]:
    """Make the type of an argument with a unit; a plain number is in SI units."""

    def read(text: str) -> float:  # numpydoc ignore=GL08
        try:
            return parsed_speed(text, field, bare=True)
        except SceneError as error:
            raise argparse.ArgumentTypeError(str(error).removeprefix(f"{field}: ")) from None

    return read


def spectrum_case(text: str) -> tuple[float, float, float]:
    """Read a case of a load spectrum: speed, torque and share of the time."""
    parts = text.split(",")
    if len(parts) != 3:
        raise argparse.ArgumentTypeError(
            f'must be "speed, torque, share", such as "150 rad/s, 250 N m, 0.6", got "{text}"'
        )
    torque, share = quantity("spectrum.torque"), quantity("spectrum.share")
    return quantity("speed")(parts[0]), torque(parts[1]), share(parts[2])


def _writable(check: Callable[[str], Path]) -> Callable[[str], Path]:
    """Make the type of the name of a file that can be written."""

    def read(text: str) -> Path:  # numpydoc ignore=GL08
        try:
            path = check(text)
            check_output(path)
        except OSError as error:
            raise argparse.ArgumentTypeError(f"{error.filename}: {error.strerror}") from None
        except GearbowError as error:
            raise argparse.ArgumentTypeError(str(error).removeprefix("path: ")) from None
        return path

    return read


@_writable
def output(text: str) -> Path:
    """Require a suffix of a file that holds all signals of a run."""
    path, ending = check_name(text, (ARCHIVE, EXPORT))
    if ending == EXPORT:
        require_netcdf()
    return path


@_writable
def figure(text: str) -> Path:
    """Require a suffix of a format that matplotlib writes."""
    with extra("plot"):
        from matplotlib.backend_bases import FigureCanvasBase  # noqa: PLC0415
    return check_name(text, [f".{each}" for each in sorted(FigureCanvasBase.filetypes)])[0]


JSON = flag("--json", "print JSON in place of text")
RUN = option("run", "file of a run, .npz", Path)


def progress(parser: argparse.ArgumentParser) -> argparse.Action:
    """Add the option for a progress bar."""
    return parser.add_argument(
        "--progress",
        action=argparse.BooleanOptionalAction,
        help="show a progress bar on stderr; default: on a terminal, after 2 s",
    )


ACCURACY = parameter("accuracy", help="instead of the accuracy of the scene")
RECORD = parameter(
    "record",
    help="names and groups, shaft@position, driver/driven, bearing:shaft@position; default: "
    "gears and meshes, or disks and bearings without gears",
)
SIGNALS = parameter("signals", text="ITEM: a gear, disk, shaft@position or driver/driven")
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


def drawn(name: str, text: str) -> Argument:
    """Declare the file of a figure."""
    metavar = name.removeprefix("--").upper()
    return option(name, text, figure, dest="figure", metavar=metavar)


KIND = parameter(
    "kind",
    of=Response.plot,
    default=None,
    help="what a figure of a run shows; default: orbits",
)
FIGURE = drawn("--out", "write a figure to this file, for example .png")


def from_to(
    name: str, points: int, first: str, last: str, *, default: Any = None, required: bool = True
) -> Argument:
    """Declare speeds or frequencies, a parameter of the method, by their first and last one."""

    def add(parser: argparse.ArgumentParser) -> None:  # numpydoc ignore=GL08
        read = quantity(name)
        parser.add_argument(
            "--from", type=read, dest="first", default=default, help=f"first of the {name}; {first}"
        )
        text = f"last of the {name}; {last}"
        parser.add_argument(
            "--to", type=read, dest=name, metavar="TO", help=text, required=required
        )
        text = f"number of {name}; default: %(default)s"
        parser.add_argument("--points", type=int, default=points, help=text)

    return add


def spaced(given: argparse.Namespace, name: str) -> Array:
    """Give the values of --from, --to and --points."""
    first, last, points = given.first, getattr(given, name), given.points
    if points < 2 or not (last > first or last < -abs(first)):
        raise SceneError(
            f"--to: need --points of at least 2, and --to above --from or, of negative speeds, "
            f"below it, got {points} points from {first:g} to {last:g} rad/s"
        )
    found: Array = as_given(np.linspace(first, last, points), given_unit((first, last)))
    return found


def speed_line(*speeds: float) -> str:
    """Write the speeds in the given unit and in the other one, the given one first."""
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


def unknown_of(system: RotorSystem, given: str) -> Unknown:
    """Read an unknown, such as "bow:input:2" or "unbalance:input@0.4"."""
    kind, _, rest = given.partition(":")
    kinds = ("bow", "unbalance", "runout", "parameter")
    if kind not in kinds or bool(rest) == (kind == "runout"):
        raise SceneError(
            f"unknown: must be bow:SHAFT, bow:SHAFT:SHAPES, unbalance:PLACE, runout or "
            f"parameter:PATH, got {given!r}{nearest(kind, kinds)}"
        )
    if kind == "bow":
        shaft, _, count = rest.partition(":")
        if count and not count.isdecimal():
            raise SceneError(f"unknown: the number of shapes must be a whole number, got {given!r}")
        return unknown.bow(shaft, int(count or 1))
    if kind == "unbalance":
        return unknown.unbalance(items(system, [rest], "unknown")[0])
    return unknown.parameter(rest) if rest else unknown.runout()


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
