"""``gearbow response``: the response to a harmonic source over the frequency."""

import argparse
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow.cli.answer import Answer, Drawing
from gearbow.cli.arguments import Commands, add_command, add_scene, figure, item, quantity, spaced
from gearbow.cli.systems import read_system
from gearbow.description.couplings import Force
from gearbow.description.loads import Torque
from gearbow.description.places import is_pair
from gearbow.description.sources import MeshExcitation, Source
from gearbow.errors import SceneError
from gearbow.units.parse import parsed

if TYPE_CHECKING:
    from gearbow._types import FrequencyQuantity

__all__ = ["add"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "response",
        response,
        "print or draw the response to a harmonic force, torque or transmission error",
        "  gearbow response train.toml --source input:0.2:y --at pinion --from 1Hz --to 5kHz"
        " --plot frf.png\n"
        '  gearbow response train.toml --source pinion/wheel --at input@0.1 --to 5kHz --speed "50'
        ' rad/s"',
    )
    add_scene(parser)
    parser.add_argument(
        "--source",
        required=True,
        help="unit force at a place along y, z or x (input:0.2:y, pinion:z), unit torque "
        "(pinion:twist), or a mesh with a transmission error of 1 µm (pinion/wheel)",
    )
    parser.add_argument(
        "--at", required=True, help="pinion, input@0.2, or a mesh pinion/wheel for its force"
    )
    parser.add_argument(
        "--from", type=quantity("frequency"), default="1Hz", dest="first", help="default: 1Hz"
    )
    parser.add_argument(
        "--to", type=quantity("frequency"), required=True, dest="last", help="for example 5kHz"
    )
    parser.add_argument(
        "--points", type=int, default=1000, help="number of frequencies; default: 1000"
    )
    parser.add_argument(
        "--speed", type=quantity("speed"), default=0.0, help='for example "1500 rpm"; default: 0'
    )
    parser.add_argument("--plot", type=figure, help="write a Bode plot to this file")


def source_of(text: str) -> Source:
    """Read a source."""
    if "/" in text:
        return MeshExcitation(text)
    place, _, direction = text.rpartition(":")
    name, sign, position = place.rpartition(":")
    at: Any = (name, parsed(position, "position", bare=True)) if sign else place
    if direction == "twist":
        return Torque(at, 1.0)
    forces = {"y": {"value": 1.0}, "z": {"value": 1j}, "x": {"axial": 1.0}}
    if not place or direction not in forces:
        raise SceneError(
            f"--source: must be a place and a direction, such as input:0.2:y, pinion:z, "
            f"pinion:twist, or a mesh such as pinion/wheel, got {text!r}"
        )
    return Force(at, **forces[direction])  # type: ignore[arg-type]  # either is a number


def response(given: argparse.Namespace) -> Answer:
    """Find the response."""
    frequencies = spaced(given, "frequencies")
    system = read_system(given)
    at = item(system, given.at)
    found = system.frequency_response(
        frequencies, source=source_of(given.source), speed=given.speed
    )
    signals: dict[str, Any]
    if is_pair(at):
        signals = {"mesh_force": found.mesh_force(at)[:, 0]}
        unit = "N"
    elif system.motion == "torsion":
        signals = {"twist": found.twist(at)[:, 0]}
        unit = "rad"
    else:
        across = found.displacement(at)[:, 0]
        signals = {"y": across[:, 0], "z": across[:, 1]}
        unit = "m"
    lines = [f"largest response at {given.at} to {given.source}:"]
    for name, values in signals.items():
        size = np.abs(values)
        peak = int(np.argmax(size))
        hertz = frequencies[peak] / (2.0 * math.pi)
        label = name.replace("_", " ")
        lines.append(f"  {label}: {size[peak]:.4g} {unit} at {hertz:.4g} Hz")
    data = {
        "frequencies": frequencies,
        "speed": given.speed,
        "unit": unit,
        **{f"{name}_real": values.real for name, values in signals.items()},
        **{f"{name}_imag": values.imag for name, values in signals.items()},
        "file": None if given.plot is None else str(given.plot),
    }
    motion: FrequencyQuantity = "twist" if system.motion == "torsion" else "displacement"
    drawing = None if given.plot is None else Drawing(lambda: found.plot(at, motion), given.plot)
    return Answer("\n".join(lines), data, drawing)
