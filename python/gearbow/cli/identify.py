"""``gearbow identify``: bow, unbalance and run-out from a file of measured vibration."""

import argparse
from pathlib import Path

from gearbow.cli.answer import Answer, Drawing
from gearbow.cli.arguments import Commands, add_command, add_scene, figure, quantity
from gearbow.cli.systems import read_system
from gearbow.errors import SceneError
from gearbow.exchange.tables import DETECTIONS
from gearbow.identification.identify import identify
from gearbow.identification.measurement import Measurement
from gearbow.identification.unknown import parse

__all__ = ["add"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "identify",
        identified,
        "find bow, unbalance and run-out from measured once-per-revolution vibration",
        "  gearbow identify scene.toml run_down.csv --unknown bow:input:2 "
        "--unknown unbalance:pinion --plot fit.png\n"
        '  gearbow identify scene.toml run_down.csv --unknown bow:input --noise "1 um"',
    )
    add_scene(parser)
    parser.add_argument(
        "measured",
        type=Path,
        nargs="+",
        help="table: speed, shaft, position and angle of a probe, amplitude, phase; or a line for "
        'each speed, with columns such as "input@0.2 y amplitude [um pp]"',
    )
    parser.add_argument(
        "--detection",
        choices=DETECTIONS,
        help="what amplitudes are whose heading does not say it; default: peak",
    )
    parser.add_argument(
        "--unknown",
        action="append",
        required=True,
        metavar="UNKNOWN",
        help="bow:SHAFT, bow:SHAFT:SHAPES, unbalance:NAME, unbalance:SHAFT@POSITION or "
        "parameter:PATH; may be repeated",
    )
    parser.add_argument(
        "--no-runout", action="store_true", help="the probes have no unknown run-out"
    )
    parser.add_argument(
        "--noise",
        type=quantity("noise"),
        help='standard deviation of a component, for example "1 um"; default: from the residual',
    )
    parser.add_argument("--plot", type=figure, help="write a figure to this file")


def identified(given: argparse.Namespace) -> Answer:
    """Identify unknowns."""
    unknowns = []
    for text in given.unknown:
        try:
            unknowns.append(parse(text))
        except SceneError as error:
            raise SceneError(f"--{error}") from None
    measured = [Measurement.read_csv(path, detection=given.detection) for path in given.measured]
    system = read_system(given)
    found = identify(system, measured, unknowns, runout=not given.no_runout, noise=given.noise)
    data = {**found.to_dict(), "file": None if given.plot is None else str(given.plot)}
    drawing = None if given.plot is None else Drawing(found.plot, given.plot)
    return Answer(found.table(), data, drawing)
