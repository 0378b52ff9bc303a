"""``gearbow check``, ``plot``, ``modes``, ``efficiency`` and others without runs."""

import argparse
import warnings
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from gearbow.analysis.protocol import ratios_by_shaft
from gearbow.cli.answer import Answer, Drawing
from gearbow.cli.arguments import (
    Commands,
    add_command,
    add_kind,
    add_scene,
    figure,
    is_run,
    named_item,
    quantity,
    read_run,
    spaced,
    speed,
    speed_line,
)
from gearbow.cli.systems import read_system, refuse_options
from gearbow.errors import SceneError
from gearbow.results.steady import SteadyState
from gearbow.units.speed import RevolutionsPerMinuteArray, given_unit

if TYPE_CHECKING:
    from gearbow._types import RunFigure

__all__ = ["add"]


def add(commands: Commands) -> None:
    """Add the commands."""
    parser = add_command(
        commands,
        "check",
        check,
        "check a scene file, and summarise the system",
        "  gearbow check scene.toml\n  gearbow check scene.toml --json",
    )
    add_scene(parser)

    parser = add_command(
        commands,
        "plot",
        plot,
        "draw the train to scale, or the signals of a run",
        "  gearbow plot scene.toml\n  gearbow plot scene.toml --out train.svg\n"
        "  gearbow plot run.npz --kind spectrum --out spectrum.png",
    )
    add_scene(parser, "or the file of a run")
    add_kind(parser, default=None)
    parser.add_argument(
        "--at", nargs="+", metavar="ITEM", help="places or meshes of a run; default: all"
    )
    parser.add_argument(
        "--out", type=figure, help="file of the figure; default: train.png, or the kind of a run"
    )

    parser = add_command(
        commands,
        "modes",
        modes,
        "print natural frequencies, damping and whirl at one speed",
        '  gearbow modes scene.toml\n  gearbow modes scene.toml --speed "1500 rpm" --count 20',
    )
    add_scene(parser)
    parser.add_argument(
        "--speed", type=speed, default=0.0, help='for example "1500 rpm"; default: 0'
    )
    parser.add_argument("--count", type=int, default=10, help="number of modes; default: 10")
    parser.add_argument(
        "--vibrating",
        action="store_true",
        help="leave out rigid-body and overdamped motions",
    )

    parser = add_command(
        commands,
        "campbell",
        campbell,
        "print the speeds at which shafts and teeth excite a mode",
        '  gearbow campbell scene.toml --to "6000 rpm"\n'
        '  gearbow campbell scene.toml --to "6000 rpm" --harmonics 0 --out campbell.png',
    )
    add_scene(parser)
    parser.add_argument("--from", type=speed, default=0.0, dest="first", help="default: 0")
    parser.add_argument(
        "--to", type=speed, required=True, dest="last", help='for example "6000 rpm"'
    )
    parser.add_argument("--points", type=int, default=50, help="number of speeds; default: 50")
    parser.add_argument("--count", type=int, default=10, help="number of modes; default: 10")
    parser.add_argument(
        "--harmonics", type=int, default=1, help="harmonics of the tooth frequencies; default: 1"
    )
    parser.add_argument(
        "--out", type=figure, help="write the diagram to this file, for example .png"
    )

    parser = add_command(
        commands,
        "efficiency",
        efficiency,
        "print the losses of the meshes by friction, and the efficiency of the train",
        '  gearbow efficiency scene.toml --speed "1500 rpm"\n'
        '  gearbow efficiency scene.toml --speed "500 rpm" "3000 rpm" --out losses.png',
    )
    add_scene(parser)
    parser.add_argument(
        "--speed", type=speed, nargs="+", required=True, help='for example "1500 rpm"; or several'
    )
    parser.add_argument("--out", type=figure, help="write a figure to this file, for example .png")

    parser = add_command(
        commands,
        "bow-limits",
        bow_limits,
        "print the bow of a shaft at which teeth jam, interfere or lose contact",
        '  gearbow bow-limits scene.toml --shaft input --speed "1500 rpm"\n'
        '  gearbow bow-limits scene.toml --shaft input --speed "1500 rpm" --out bow.png',
    )
    add_scene(parser)
    parser.add_argument("--shaft", nargs="+", required=True, help="one shaft, or several together")
    parser.add_argument(
        "--speed", type=speed, nargs="+", required=True, help='for example "1500 rpm"; or several'
    )
    parser.add_argument(
        "--phase", type=quantity("phase"), help="angle in the shaft; default: the worst one"
    )
    parser.add_argument("--out", type=figure, help="write a figure to this file, for example .png")


def check(given: argparse.Namespace) -> Answer:
    """Check a scene."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        system = read_system(given)
    for warning in caught:
        warnings.showwarning(warning.message, warning.category, warning.filename, warning.lineno)
    found = [str(warning.message) for warning in caught]
    ratios = ratios_by_shaft(system)
    data = {
        "scene": str(given.scene),
        "warnings": found,
        "parts": {key: len(value) for key, value in system.description.items() if key in _LISTS},
        "degrees_of_freedom": len(system.dofs),
        "speed_ratios": ratios,
    }
    count = f"{len(found)} warning{'' if len(found) == 1 else 's'}" if found else "no warnings"
    return Answer(f"{given.scene}: valid, {count}\n{system}", data)


#: The keys of a description that are lists of parts.
_LISTS = (
    *("shafts", "gears", "disks", "meshes", "bearings", "torques"),
    *("supports", "housings", "couplings", "drives", "forces"),
)


def plot(given: argparse.Namespace) -> Answer:
    """Draw the train, or the signals of a run."""
    if is_run(given.scene):
        refuse_options(given)
        run = read_run(given.scene)
        recorded = (run.response if isinstance(run, SteadyState) else run).recorded
        at = None if given.at is None else [named_item(recorded, text) for text in given.at]
        kind: RunFigure = given.kind or "orbits"
        out = given.out or figure(f"{kind}.png")
        return Answer("", {"file": str(out)}, Drawing(lambda: run.plot(kind, at), out))
    for option in ("kind", "at"):
        if getattr(given, option) is not None:
            raise SceneError(f"--{option}: is for the file of a run (.npz or .nc); leave it out")
    system: Any = read_system(given)
    out = given.out or figure("train.png")
    return Answer("", {"file": str(out)}, Drawing(system.plot, out))


def modes(given: argparse.Namespace) -> Answer:
    """Find modes."""
    system = read_system(given)
    found = system.modes(given.speed, count=given.count, vibrating=given.vibrating)
    rows = zip(found.frequencies_hz, found.damping_ratios, found.whirl, found.names(), strict=True)
    keys = ("frequency_hz", "damping_ratio", "whirl", "name")
    data = {"speed": given.speed, "modes": [dict(zip(keys, row, strict=True)) for row in rows]}
    head = [speed_line(given.speed)] if given.speed else []
    return Answer("\n".join([*head, found.table()]), data)


def campbell(given: argparse.Namespace) -> Answer:
    """Find the Campbell diagram."""
    speeds = spaced(given, "speeds")
    system = read_system(given)
    if given_unit((given.first, given.last)) == "rpm":
        speeds = speeds.view(RevolutionsPerMinuteArray)
    found = system.campbell(speeds, count=given.count, harmonics=given.harmonics)
    keys = ("speed", "frequency_hz", "damping_ratio", "whirl", "mode")
    data = {
        "speeds": found.speeds,
        "frequencies_hz": found.frequencies_hz,
        "damping_ratios": found.damping_ratios,
        "intersections": [
            {key: getattr(one, key) for key in keys} | {"excited_by": one.line.name}
            for one in found.intersections
        ],
        "thresholds": [asdict(one) for one in found.thresholds],
        "file": None if given.out is None else str(given.out),
    }
    drawing = None if given.out is None else Drawing(found.plot, given.out)
    return Answer(f"{speed_line(given.first, given.last)}\n{found.table()}", data, drawing)


def efficiency(given: argparse.Namespace) -> Answer:
    """Find the losses of the meshes."""
    found = read_system(given).efficiency(given.speed)
    keys = ("speeds", "input_power", "power", "force", "coefficient", "loss", "efficiency")
    data = {
        "meshes": found.meshes,
        **{key: getattr(found, key) for key in keys},
        "file": None if given.out is None else str(given.out),
    }
    drawing = None if given.out is None else Drawing(found.plot, given.out)
    return Answer("\n".join([speed_line(*given.speed), found.table()]), data, drawing)


def bow_limits(given: argparse.Namespace) -> Answer:
    """Find the limits of a bow."""
    system = read_system(given)
    found = system.bow_limits(given.shaft, given.speed, phase=given.phase)
    data = {
        "shafts": found.shafts,
        "present": found.present,
        "limits": [asdict(one) for one in found.found],
        "file": None if given.out is None else str(given.out),
    }
    drawing = None if given.out is None else Drawing(found.plot, given.out)
    return Answer("\n".join([speed_line(*given.speed), found.table()]), data, drawing)
