"""``gearbow run``, ``steady`` and ``tradeoff``: commands that integrate in time."""

import argparse
import math
from dataclasses import asdict
from typing import Any

import numpy as np

from gearbow._types import Array
from gearbow.accuracy.levels import LEVELS
from gearbow.analysis.protocol import variant
from gearbow.cli.answer import Answer, Drawing
from gearbow.cli.arguments import (
    Commands,
    add_command,
    add_duration,
    add_kind,
    add_scene,
    add_speed,
    figure,
    item,
    output,
    quantity,
    speed,
    speed_line,
)
from gearbow.cli.systems import read_system
from gearbow.description.places import is_pair, is_place, place_label
from gearbow.description.speed import SpeedProfile
from gearbow.results.response import Response
from gearbow.system.rotor_system import RotorSystem
from gearbow.tradeoff.result import Tradeoff
from gearbow.units.speed import given_unit

__all__ = ["add"]


def add(commands: Commands) -> None:
    """Add the commands."""
    parser = add_command(
        commands,
        "run",
        run,
        "simulate the motion, print the size of the signals, and save them",
        '  gearbow run scene.toml --duration 0.5 --speed "1500 rpm" --out run.npz\n'
        '  gearbow run scene.toml --duration "10 s" --speed 0 --end-speed "3000 rpm" \\\n'
        "      --record gears meshes shaft@0.25 --checkpoint run.npz",
    )
    add_scene(parser)
    add_duration(parser)
    parser.add_argument("--end-speed", type=speed, help="change the speed linearly to this one")
    add_signals(parser)
    parser.add_argument(
        "--checkpoint",
        type=output,
        help="save during the run; the same command continues after an interruption",
    )
    parser.add_argument(
        "--figure", type=figure, help="draw the signals to this file, for example .png"
    )
    add_kind(parser, default="orbits")

    parser = add_command(
        commands,
        "steady",
        steady,
        "find the motion that remains after the transient, and whether it is stable",
        '  gearbow steady scene.toml --speed "1500 rpm" --record gears meshes --out steady.npz',
    )
    add_scene(parser)
    add_speed(parser)
    add_signals(parser)

    parser = add_command(
        commands,
        "tradeoff",
        tradeoff,
        "measure error and CPU time of methods and settings",
        '  gearbow tradeoff scene.toml --duration 0.1 --speed "1500 rpm" --signals pinion/wheel',
    )
    add_scene(parser)
    add_duration(parser)
    parser.add_argument(
        "--signals",
        nargs="+",
        metavar="ITEM",
        help="a gear, disk, shaft@position or driver/driven; default: the first gear, or the first "
        "disk without gears",
    )
    parser.add_argument(
        "--budget", type=quantity("budget"), default=60.0, help="limit of the time; default: 60 s"
    )


def add_signals(parser: argparse.ArgumentParser) -> None:
    """Add the options of a command that records signals."""
    parser.add_argument(
        "--accuracy", choices=list(LEVELS), help="instead of the accuracy of the scene"
    )
    parser.add_argument(
        "--record",
        nargs="+",
        metavar="ITEM",
        help="names and groups, shaft@position, driver/driven, bearing:shaft@position; default: "
        "gears and meshes, or disks and bearings without gears",
    )
    parser.add_argument(
        "--out", type=output, help="save the signals, also after Ctrl-C; .npz or .nc"
    )


def _loaded(given: argparse.Namespace) -> RotorSystem:
    """Load the scene with the accuracy that the command gives."""
    system = read_system(given)
    if given.accuracy is None:
        return system
    # The warnings of the scene are those of `load`.
    return variant(system, accuracy=given.accuracy)


def _items(system: RotorSystem, given: argparse.Namespace) -> list[Any] | None:
    return None if given.record is None else [item(system, text) for text in given.record]


def run(given: argparse.Namespace) -> Answer:
    """Simulate."""
    system = _loaded(given)
    wanted: float | SpeedProfile = given.speed
    if given.end_speed is not None:
        wanted = SpeedProfile.ramp(given.speed, given.end_speed, given.duration)
    try:
        response = system.simulate(
            given.duration,
            wanted,
            record=_items(system, given),
            checkpoint=given.checkpoint,
            progress=given.progress,
        )
    except KeyboardInterrupt as stop:
        found: Response | None = getattr(stop, "response", None)
        if found is not None and found.time.size:
            stop.answer = _saved(found, given, complete=False)  # type: ignore[attr-defined]
        raise
    return _saved(response, given, complete=True)


def _saved(response: Response, given: argparse.Namespace, *, complete: bool) -> Answer:
    """Save a response, and describe it."""
    ends = [given.speed] + ([] if given.end_speed is None else [given.end_speed])
    response.speed_unit = given_unit(ends) or response.speed_unit
    if given.out is not None:
        response.save(given.out)
    data = {
        "complete": complete,
        "accuracy": response._level,
        "time": [response.time[0], response.time[-1]],
        "samples": response.time.size,
        **_signals(response),
        "events": len(response.events),
        "statistics": asdict(response.statistics),
        "file": None if given.out is None else str(given.out),
    }
    lines = [speed_line(*ends), response.table()]
    lines.append(f"{data['statistics']['steps']} steps, {data['events']} events")
    drawing = None
    if given.figure is not None:
        drawing = Drawing(lambda: response.plot(given.kind), given.figure)
    return Answer("\n".join([*lines, *_file_line(data)]), data, drawing)


def steady(given: argparse.Namespace) -> Answer:
    """Find the steady state."""
    system = _loaded(given)
    found = system.steady_state(
        given.speed,
        record=_items(system, given),
        progress=given.progress,
    )
    multipliers = found.multipliers()
    largest = float(abs(multipliers[0])) if multipliers.size else None
    if given.out is not None:
        found.save(given.out)
    data = {
        "period": None if math.isinf(found.period) else found.period,
        "residual": found.residual,
        "method": found.method,
        "accuracy": found.response._level,
        "stable": found.is_stable(),
        "instability": found.instability(),
        "largest_multiplier": largest,
        **_signals(found.response),
        "file": None if given.out is None else str(given.out),
    }
    state = "stable" if found.is_stable() else f"unstable: {found.instability()}"
    size = "below 0.9" if largest is None else f"{largest:.6g}"
    lines = [speed_line(given.speed), found.table()]
    lines.append(f"{state}; magnitude of the largest multiplier {size}")
    return Answer("\n".join([*lines, *_file_line(data)]), data)


def _signals(response: Response) -> dict[str, Any]:
    """Describe the recorded signals."""
    points = {}
    recorded: list[Any] = response.recorded
    for name in [one for one in recorded if is_place(one) or _is_name(one)]:
        values = response.displacement(name)
        points[place_label(name)] = {
            "peak_to_peak": np.ptp(values, axis=0),
            "mean": values.mean(axis=0),
        }
    meshes = {}
    for driver, driven in filter(is_pair, recorded):
        mesh = response.mesh((driver, driven))
        sizes = {"force": _size(mesh.force), "contact_ratio": _size(mesh.contact_ratio)}
        meshes[f"{driver}/{driven}"] = sizes
    bearings = {}
    for shaft, x in [one[1:] for one in recorded if isinstance(one, tuple) and len(one) == 3]:
        force = np.linalg.norm(response.bearing_force((shaft, x)), axis=1)
        bearings[place_label((shaft, x))] = {"force": _size(force)}
    return {"points": points, "meshes": meshes, "bearings": bearings}


def _file_line(data: dict[str, Any]) -> list[str]:
    return [f"signals: {data['file']}"] if data["file"] else []


def _is_name(recorded: Any) -> bool:
    return isinstance(recorded, str) and recorded != "energy"


def _size(values: Array) -> dict[str, float]:
    return {"min": float(values.min()), "max": float(values.max()), "mean": float(values.mean())}


def tradeoff(given: argparse.Namespace) -> Answer:
    """Measure error and CPU time of many settings."""
    system = read_system(given)
    signals = None if given.signals is None else [item(system, text) for text in given.signals]
    try:
        found = system.tradeoff(
            given.duration, given.speed, signals, budget=given.budget, progress=given.progress
        )
    except KeyboardInterrupt as stop:
        partial: Tradeoff[RotorSystem] | None = getattr(stop, "tradeoff", None)
        if partial is not None:
            stop.answer = _answer(partial)  # type: ignore[attr-defined]
        raise
    return _answer(found)


def _answer(found: Tradeoff[RotorSystem]) -> Answer:
    keys = ("model", "method", "model_error", "errors", "error", "seconds", "rate", "steps")
    trials = [{key: getattr(trial, key) for key in keys} for trial in found.trials]
    front = found.front()
    for row, trial in zip(trials, found.trials, strict=True):
        row["setting"] = str(trial)
        row["front"] = trial in front
    data = {
        "duration": found.duration,
        "speed": found.speed,
        "signals": found.signals,
        "uncertainty": found.floor,
        "trials": trials,
        "skipped": [str(skipped) for skipped in found.skipped],
    }
    return Answer(f"{speed_line(found.speed)}\n{found.table()}", data)
