"""What each command does and prints: one function for each command."""

import argparse
import inspect
import json
import math
import warnings
import webbrowser
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._extras import extra
from gearbow._files import check_name, check_output, replacing
from gearbow._types import Array
from gearbow.analysis.protocol import variant
from gearbow.cli.arguments import (
    PLACES,
    figure,
    is_run,
    items,
    named_item,
    output,
    read_options,
    read_run,
    read_system,
    refuse_options,
    spaced,
    speed_line,
    speed_of_file,
    unknown_of,
)
from gearbow.description.layout import ratios_by_shaft
from gearbow.description.loads import Force, MeshExcitation, Source, Torque
from gearbow.description.places import is_pair, is_place, place_label
from gearbow.description.speed import SpeedProfile
from gearbow.errors import SceneError
from gearbow.exchange.rexs import RexsContents, rexs_contents
from gearbow.identification.identify import identify as identified
from gearbow.identification.measurement import Measurement
from gearbow.machines.examples import described, example, scene_files
from gearbow.results.response import Response
from gearbow.results.steady import SteadyState
from gearbow.studies.result import Tradeoff
from gearbow.system.read import REXS, format_of
from gearbow.system.rotor_system import RotorSystem
from gearbow.units.parse import parsed
from gearbow.units.speed import as_given, given_unit, speed_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow._types import FrequencyQuantity, RunFigure

#: The scene that `gearbow new` writes by itself: a pair with a comment on each part.
EXAMPLE = Path(__file__).with_name("example.toml")
#: The guide that `gearbow skill` prints.
SKILL = Path(__file__).with_name("skill.md")
#: The JSON schema of what each command prints with --json, by the name of the command.
SCHEMAS = Path(__file__).with_name("schemas.json")
#: The keys of a description that are lists of parts.
_LISTS = (
    *("shafts", "gears", "disks", "meshes", "bearings", "torques"),
    *("supports", "housings", "couplings", "drives", "forces"),
)
#: Methods whose command gives the accuracy of the system, which decides its elements.
_OF_ACCURACY = (RotorSystem.simulate, RotorSystem.steady_state)


@dataclass(frozen=True)
class Answer:
    """What a command prints, as text and as data, and what draws the figure that follows it."""

    text: str
    data: Mapping[str, Any]
    draw: "Callable[[], Figure] | None" = None


def _call(owner: Any, given: argparse.Namespace, **changes: Any) -> Any:
    """Call the method of the command with the options that are its parameters."""
    signature = inspect.signature(given.analysis)
    options = {
        name: each
        for name, each in vars(given).items()
        if name in signature.parameters and each is not None
    }
    bound = signature.bind_partial(owner, **options | changes)
    return getattr(owner, given.analysis.__name__)(*bound.args[1:], **bound.kwargs)


def _found(given: argparse.Namespace, **changes: Any) -> Any:
    """Read the system of a command, and call its method."""
    system = read_system(given)
    if given.analysis in _OF_ACCURACY and given.accuracy is not None:
        # The warnings of the scene are those of `load`.
        system, changes["accuracy"] = variant(system, accuracy=given.accuracy), None
    for name in PLACES:
        if getattr(given, name, None) is not None:
            changes[name] = items(system, getattr(given, name), name)
    return _call(system, given, **changes)


def _found_or_stopped(
    answer: Callable[[Any, argparse.Namespace], Answer], given: argparse.Namespace, **changes: Any
) -> Answer:
    """Answer with the result of the method of the command, or with its part before Ctrl-C."""
    given.complete = True
    try:
        found = _found(given, **changes)
    except KeyboardInterrupt as stop:
        given.complete = False
        partial = getattr(stop, "response", getattr(stop, "tradeoff", None))
        if partial is not None and np.size(getattr(partial, "time", 0.0)):
            stop.answer = answer(partial, given)  # type: ignore[attr-defined]
        raise
    return answer(found, given)


def _answer(
    given: argparse.Namespace,
    found: Any,
    *lines: str,
    draw: "Callable[[], Figure] | None" = None,
    **data: Any,
) -> Answer:
    """Answer with the given speeds, the table of a result and further lines."""
    # The schema names the data, which are those of the result unless the command gives them.
    names = _schemas()["properties"][given.command]["properties"]
    data = _fields(found, *(name for name in names if hasattr(found, name))) | data
    speeds = _speeds(given)
    head = [speed_line(*speeds)] if speeds else []
    for name in ("figure", "out"):
        if name in given:
            file = getattr(given, name)
            data["file"] = None if file is None else str(file)
    if draw is None and "figure" in given:
        draw = found.plot
    return Answer("\n".join([*head, found.table(), *lines]), data, draw)


def _speeds(given: argparse.Namespace) -> list[float]:
    """Give the speeds that the command was given, of a range its ends."""
    if getattr(given, "spectrum", None) is not None:
        return [case[0] for case in given.spectrum]
    found: list[float] = []
    for name in ("first", "speed", "speeds", "end_speed"):
        one = getattr(given, name, None)
        found += one if isinstance(one, list) else [] if one is None else [one]
    return found


def result(given: argparse.Namespace) -> Answer:
    """Print the result of the method of the command."""
    return _answer(given, _found(given))


def _schemas() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(SCHEMAS.read_text(encoding="utf-8"))
    return found


def _fields(found: object, *names: str) -> dict[str, Any]:
    return {name: getattr(found, name) for name in names}


def new(given: argparse.Namespace) -> Answer:
    """Write a commented example of a scene file."""
    path, _ = check_name(given.path, [".toml"])
    if path.exists() and not given.force:
        raise SceneError(f"{path}: exists; give another name, or --force to replace it")
    machine = described(EXAMPLE) if given.example is None else example(given.example)
    source, speed = machine.path, speed_text(machine.speed, given_unit(machine.speed) or "rad/s")
    # A scene names the files of its elastic housings, which stand beside it.
    bodies = source.parent.glob(f"{source.stem}.housing*.npz")
    for given_file, target in (
        (source, path),
        *((one, path.with_name(one.name)) for one in bodies),
    ):
        with replacing(target) as file:
            file.write(given_file.read_bytes())
    text = f'wrote {path}; next: gearbow check {path}, gearbow modes {path} --speed "{speed}"'
    return Answer(text, {"file": str(path)})


def report(given: argparse.Namespace) -> Answer:
    """Write a report."""
    given.path, _ = check_name(given.path or f"{given.scene.stem}.html", [".html"], "--out")
    if given.operating is not None and len(given.operating) > 2:
        raise SceneError(f"--speed: give one speed, or two, got {len(given.operating)}")
    if given.first is not None and given.speeds is None:
        raise SceneError("--from: needs --to")
    if given.speeds is not None and given.first is None:
        # Journal bearings carry nothing at speed 0.
        given.first = as_given(0.05 * given.speeds, given_unit(given.speeds))
    speeds = None if given.speeds is None else spaced(given, "speeds")
    system, ends = read_system(given), given.operating
    operating = speed_of_file(given) if ends is None else (ends[0], ends[-1])
    title = given.title or given.scene.stem
    _call(system, given, operating=operating, speeds=speeds, title=title)
    return Answer(f"report: {given.path}", {"file": str(given.path)})


def demo(given: argparse.Namespace) -> Answer:
    """Write the report of an example, and open it in the browser."""
    machine = example(given.example)
    out, _ = check_name(given.out or f"{machine.name}.html", [".html"], "--out")
    machine.load().report(
        out, operating=machine.speed, title=machine.title, progress=given.progress
    )
    if not given.no_open:
        webbrowser.open(out.resolve().as_uri())
    return Answer(f"report: {out}", {"file": str(out)})


def import_(given: argparse.Namespace) -> Answer:
    """Print the scene of a REXS file (.rexs, .rexsj, .rexsz) or a rotor of ROSS (.toml, .json)."""
    read_options(given)  # their errors come before those of the file
    found = format_of(given.scene)
    data: dict[str, object] = {"file": str(given.scene)}
    if given.list and found != REXS:
        raise SceneError(f"--list: is for a {REXS.name}, but {given.scene} is a {found.name}")
    contents = rexs_contents(given.scene) if found == REXS else None
    if contents is not None:
        data |= _fields(contents, "load_cases", "missing", "notes")
        if given.list:
            return Answer(contents.table(), data)
    system = read_system(given)
    data["scene"] = system.description
    heading = f"# From {given.scene.name}, a {found.name}"
    if contents is not None:
        heading = _heading(given, contents)
    if given.out is None:
        return Answer(f"{heading}\n\n{system._model.to_toml()}", data)
    path, ending = check_name(given.out, [".toml", ".rexs"], "--out")
    if ending == ".rexs":
        system.save(path)
    else:
        with replacing(path) as file:
            file.write(f"{heading}\n\n{system._model.to_toml()}".encode())
    return Answer(f"wrote {path}; next: gearbow check {path}", data)


def _heading(given: argparse.Namespace, contents: RexsContents) -> str:
    heading = f"# From {given.scene.name}, REXS {contents.version} of {contents.application}"
    case = contents.load_cases[(given.load_case or 1) - 1]
    if case.speed is None:
        return heading
    return f'{heading}\n# Load case {case.number}: {case.speed!r} rad/s of "{contents.reference}"'


def check(given: argparse.Namespace) -> Answer:
    """Check a scene file, and summarise the system."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        system = read_system(given)
    for warning in caught:
        warnings.showwarning(warning.message, warning.category, warning.filename, warning.lineno)
    found = [str(warning.message) for warning in caught]
    data = {
        "scene": str(given.scene),
        "warnings": found,
        "parts": {key: len(value) for key, value in system.description.items() if key in _LISTS},
        "degrees_of_freedom": len(system.dofs),
        "speed_ratios": ratios_by_shaft(system),
    }
    count = f"{len(found)} warning{'' if len(found) == 1 else 's'}" if found else "no warnings"
    return Answer(f"{given.scene}: valid, {count}\n{system}", data)


def plot(given: argparse.Namespace) -> Answer:
    """Draw the train to scale, or the signals of a run."""
    draw: Callable[[], Figure]
    if is_run(given.scene):
        refuse_options(given)
        run = read_run(given.scene)
        recorded = (run.response if isinstance(run, SteadyState) else run).recorded
        at = None if given.at is None else [named_item(recorded, text, "at") for text in given.at]
        kind: RunFigure = given.kind or "orbits"
        name, draw = f"{kind}.png", lambda: run.plot(kind, at)
    else:
        for option in ("kind", "at"):
            if getattr(given, option) is not None:
                raise SceneError(f"--{option}: is for the file of a run (.npz); leave it out")
        name, draw = "train.png", read_system(given).plot
    given.figure = given.figure or figure(name)
    return Answer("", {"file": str(given.figure)}, draw)


def modes(given: argparse.Namespace) -> Answer:
    """Find modes."""
    found = _found(given)
    rows = zip(found.frequencies_hz, found.damping_ratios, found.whirl, found.names(), strict=True)
    keys = ("frequency_hz", "damping_ratio", "whirl", "name")
    return _answer(given, found, modes=[dict(zip(keys, row, strict=True)) for row in rows])


def campbell(given: argparse.Namespace) -> Answer:
    """Find the Campbell diagram."""
    found = _call(read_system(given), given, speeds=spaced(given, "speeds"))
    keys = ("speed", "frequency_hz", "damping_ratio", "whirl", "mode")
    crossings = [
        {**_fields(one, *keys), "excited_by": one.line.name} for one in found.intersections
    ]
    return _answer(given, found, intersections=crossings)


def bow_limits(given: argparse.Namespace) -> Answer:
    """Find the limits of a bow."""
    found = _found(given)
    return _answer(given, found, limits=found.found)


def response(given: argparse.Namespace) -> Answer:
    """Find the response to a harmonic source."""
    frequencies = spaced(given, "frequencies")
    system = read_system(given)
    (at,) = items(system, [given.at], "at")
    found = _call(system, given, frequencies=frequencies, source=_source(given.source))
    motion: FrequencyQuantity = "twist" if system.motion == "torsion" else "displacement"
    signals: dict[str, Any]
    if is_pair(at):
        unit, signals = "N", {"mesh_force": found.mesh_force(at)[:, 0]}
    elif motion == "twist":
        unit, signals = "rad", {"twist": found.twist(at)[:, 0]}
    else:
        unit, signals = "m", dict(zip("yz", found.displacement(at)[:, 0, :2].T, strict=True))
    lines = [f"largest response at {given.at} to {given.source}:"]
    data: dict[str, Any] = {"frequencies": frequencies, "speed": given.speed, "unit": unit}
    for name, values in signals.items():
        size = np.abs(values)
        peak = int(np.argmax(size))
        hertz = frequencies[peak] / (2.0 * math.pi)
        lines.append(f"  {name.replace('_', ' ')}: {size[peak]:.4g} {unit} at {hertz:.4g} Hz")
        data |= {f"{name}_real": values.real, f"{name}_imag": values.imag}
    data["file"] = None if given.figure is None else str(given.figure)
    return Answer("\n".join(lines), data, lambda: found.plot(at, motion))


def _source(text: str) -> Source:
    if "/" in text:
        return MeshExcitation(text)
    place, _, direction = text.rpartition(":")
    name, sign, position = place.rpartition(":")
    at: Any = (name, parsed(position, "source.position", bare=True)) if sign else place
    if direction == "twist":
        return Torque(at, 1.0)
    forces = {"y": {"value": 1.0}, "z": {"value": 1j}, "x": {"axial": 1.0}}
    if not place or direction not in forces:
        raise SceneError(
            f"source: must be a place and a direction, such as input:0.2:y, pinion:z, "
            f"pinion:twist, or a mesh such as pinion/wheel, got {text!r}"
        )
    return Force(at, **forces[direction])  # type: ignore[arg-type]  # either is a number


def run(given: argparse.Namespace) -> Answer:
    """Simulate."""
    changes = {}
    if given.end_speed is not None:
        changes["speed"] = SpeedProfile.ramp(given.speed, given.end_speed, given.duration)
    return _found_or_stopped(_saved, given, **changes)


def _saved(found: Response, given: argparse.Namespace) -> Answer:
    found.speed_unit = given_unit(_speeds(given)) or found.speed_unit
    data = {
        "complete": given.complete,
        "accuracy": found._level,
        "time": [found.time[0], found.time[-1]],
        "samples": found.time.size,
        **_signals(found),
        "events": len(found.events),
        "statistics": found.statistics,
    }
    lines = [f"{found.statistics.steps} steps, {len(found.events)} events"]
    lines += _save(found, given)
    return _answer(given, found, *lines, draw=lambda: found.plot(given.kind or "orbits"), **data)


def steady(given: argparse.Namespace) -> Answer:
    """Find the steady state."""
    found = _found(given)
    multipliers = found.multipliers()
    largest = float(abs(multipliers[0])) if multipliers.size else None
    data = {
        "accuracy": found.response._level,
        "stable": found.is_stable(),
        "instability": found.instability(),
        "largest_multiplier": largest,
        **_signals(found.response),
    }
    state = "stable" if found.is_stable() else f"unstable: {found.instability()}"
    size = "below 0.9" if largest is None else f"{largest:.6g}"
    line = f"{state}; magnitude of the largest multiplier {size}"
    return _answer(given, found, line, *_save(found, given), **data)


def _save(found: Response | SteadyState, given: argparse.Namespace) -> list[str]:
    """Save the signals if the command names a file, and give the line that says so."""
    if given.out is None:
        return []
    found.save(given.out)
    return [f"signals: {given.out}"]


def _signals(response: Response) -> dict[str, Any]:
    points, meshes, bearings = {}, {}, {}
    recorded: list[Any] = response.recorded
    for one in recorded:
        if is_pair(one):
            mesh = response.mesh(one)
            sizes = {"force": _size(mesh.force), "contact_ratio": _size(mesh.contact_ratio)}
            meshes["/".join(one)] = sizes
        elif isinstance(one, tuple) and len(one) == 3:
            force = np.linalg.norm(response.bearing_force(one[1:]), axis=1)
            bearings[place_label(one[1:])] = {"force": _size(force)}
        elif is_place(one) or (isinstance(one, str) and one != "energy"):
            values = response.displacement(one)
            points[place_label(one)] = {
                "peak_to_peak": np.ptp(values, axis=0),
                "mean": values.mean(axis=0),
            }
    return {"points": points, "meshes": meshes, "bearings": bearings}


def _size(values: Array) -> dict[str, float]:
    return {"min": float(values.min()), "max": float(values.max()), "mean": float(values.mean())}


def tradeoff(given: argparse.Namespace) -> Answer:
    """Measure error and CPU time of many settings."""
    return _found_or_stopped(_trials, given)


def _trials(found: Tradeoff[RotorSystem], given: argparse.Namespace) -> Answer:
    keys = ("model", "method", "model_error", "errors", "error", "seconds", "rate", "steps")
    front = found.front()
    data: dict[str, Any] = {
        "uncertainty": found.floor,
        "trials": [
            {**_fields(trial, *keys), "setting": str(trial), "front": trial in front}
            for trial in found.trials
        ],
        "skipped": [str(skipped) for skipped in found.skipped],
    }
    return _answer(given, found, **data)


def orders(given: argparse.Namespace) -> Answer:
    """Find the orders of a signal."""
    run = read_run(given.run)
    response = run.response if isinstance(run, SteadyState) else run
    recorded: list[Any] = response.recorded
    at = recorded[0] if given.at is None else named_item(recorded, given.at, "at")
    found = _call(response, given, at=at)
    rows = zip(found.orders, found.frequencies_hz, found.amplitudes, strict=True)
    data = {
        "signal": found.label,
        **_fields(found, "unit", "mean", "rest"),
        "orders": [
            {"order": o.value, "frequency_hz": hertz, "amplitude": abs(a), "excited_by": str(o)}
            for o, hertz, a in rows
        ],
    }
    return Answer(found.table(given.count), data)


def export(given: argparse.Namespace) -> Answer:
    """Write the signals of a run as a table (.csv, .xlsx) or a data set (.nc)."""
    run = read_run(given.run)
    check_output(Path(given.out))
    run.save(given.out)
    return Answer(f"signals: {given.out}", {"file": given.out})


def fmu(given: argparse.Namespace) -> Answer:
    """Write a functional mock-up unit."""
    given.path, _ = check_name(given.path or f"{given.scene.stem}.fmu", [".fmu"], "--out")
    _found(given)
    return Answer(f"unit: {given.path}", {"file": str(given.path)})


def identify(given: argparse.Namespace) -> Answer:
    """Identify unknowns."""
    system, runout = read_system(given), not given.no_runout
    unknowns = [unknown_of(system, text) for text in given.unknowns]
    measured = [Measurement.read_csv(path, detection=given.detection) for path in given.measured]
    found = identified(system, measured, unknowns, runout=runout, noise=given.noise)
    return _answer(given, found, **found.to_dict())


def skill(_: argparse.Namespace) -> Answer:
    """Print a short guide for coding assistants: calls, units, traps."""
    return Answer(SKILL.read_text(encoding="utf-8").rstrip(), {})


def schema(given: argparse.Namespace) -> Answer:
    """Print the JSON schema of what a command prints with --json."""
    schemas = _schemas()
    known = schemas["properties"]
    if given.of not in known:
        raise SceneError(f"COMMAND: must be one of {', '.join(known)}, got {given.of!r}")
    found = {"$schema": schemas["$schema"], **known[given.of], "$defs": schemas["$defs"]}
    return Answer(json.dumps(found, indent=2, ensure_ascii=False), {})


def completion(given: argparse.Namespace) -> Answer:
    """Print a script with which a shell completes commands, options and files."""
    with extra("completion"):
        import shtab  # noqa: PLC0415

    for command in given.commands.choices.values():
        for action in command._actions:
            if action.type in (Path, output, figure) or action.dest in ("path", "out"):
                action.complete = shtab.FILE
            if action.dest == "example":
                action.choices = list(scene_files())
    return Answer(shtab.complete(given.program, shell=given.shell), {})
