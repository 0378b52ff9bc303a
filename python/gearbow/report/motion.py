"""The motion at the operating speed, its stability and its accelerations, for a report."""

import math
import warnings
from collections.abc import Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np

from gearbow._result import ROUND_OFF, Column
from gearbow.description.places import place_label
from gearbow.errors import AccuracyWarning, GearbowError
from gearbow.recording.record import recorded_run
from gearbow.report.page import Block, Note, Table, note, picture
from gearbow.report.shared import SHOWN_REVOLUTIONS, Contents
from gearbow.report.texts import say, word
from gearbow.results.response import Response
from gearbow.results.steady import SMALLEST_MULTIPLIER, SteadyState

T = TypeVar("T")

#: Largest numbers of orbits, meshes, bearings and spectra in a figure.
_ORBITS, _MESHES, _BEARINGS, _SPECTRA = 8, 2, 4, 3
#: Number of gears and disks with the largest accelerations that stand for sensors.
_BODIES = 3


def motion(contents: Contents) -> Iterator[Block]:
    """Show orbits, spectra and mesh geometry at the operating speed."""
    run, what, steady = contents.motion
    speed = contents.need_operating()
    yield note("Motion at {speed}: {what}.", speed=contents.text(speed), what=what)
    if steady is not None:
        yield _floquet(contents, steady)
    yield from _vibration(contents)
    yield Table.of_result(run, say("Recorded signals"))
    end = float(run.time[-1])
    times = (max(float(run.time[0]), end - SHOWN_REVOLUTIONS * contents.turn()), end)
    bodies = [names[0] for _, _, names in recorded_run(run, "run").data["points"] if names]
    lateral = any(direction == "v" for *_, direction in contents.system.dofs)
    if lateral and bodies:
        for own in _parts(bodies, _ORBITS):
            caption = say("Orbits: {names}.", names=", ".join(own))
            yield picture(run.plot("orbits", own, times=times), caption)
        size = {name: float(np.ptp(run.displacement(name), axis=0).max()) for name in bodies}
        largest = sorted(bodies, key=lambda name: -size[name])[:_SPECTRA]
        yield picture(
            run.plot("spectrum", [name for name in bodies if name in largest]),
            say("Amplitude spectra of the places with the largest motion."),
        )
    elif bodies:
        figure = run.plot("twist", bodies[:_ORBITS], times=times)
        yield picture(figure, say("Twist of gears and disks."))
    pairs = [(mesh.driver, mesh.driven) for mesh in contents.system.meshes]
    for two in _parts(pairs, _MESHES):
        names = ", ".join("–".join(pair) for pair in two)
        figure = run.plot("mesh", two, times=times)
        yield picture(figure, say("Force, deflection and stiffness: {names}.", names=names))
        figure = run.plot("geometry", two, times=times)
        yield picture(figure, say("Mesh geometry at the moving centres: {names}.", names=names))
    if not pairs:
        yield note("There is no mesh geometry: the system has no gears in mesh.")
    places = [(bearing.shaft, bearing.position) for bearing in contents.system.bearings]
    for few in _parts(places if lateral else [], _BEARINGS):
        names = ", ".join(word(place_label(place)) for place in few)
        figure = run.plot("bearings", few, times=times)
        yield picture(figure, say("Bearing forces: {names}.", names=names))


def _parts(items: list[T], count: int) -> Iterator[list[T]]:
    """Divide a list into parts of at most `count` items."""
    return (items[first : first + count] for first in range(0, len(items), count))


def _floquet(contents: Contents, steady: SteadyState) -> Note:
    """Say whether small disturbances of the steady state decay."""
    if not contents.system.meshes:
        return note(
            "Whether small disturbances of this motion decay follows from the eigenvalues in "
            "the section on stability: no teeth change the stiffness of the system."
        )
    if steady.method == "quasi-periodic":
        contents.find("The steady state is {state}.", state=say("stable"))
        return note("The steady state is stable: the motion ran in, so that disturbances decay.")
    try:
        kind = steady.instability()
    except GearbowError as error:
        return note("Stability of the steady state: not computed, because {reason}", reason=error)
    largest = max(map(abs, steady.multipliers()), default=0.0)
    # A motion that decays slowly has a multiplier that rounds to 1.
    near = abs(largest - 1.0) < 1e-3
    sign = "−" if largest < 1.0 else "+"
    shown = f"1 {sign} {abs(largest - 1.0):.1e}" if near else f"{largest:.4g}"
    size = say("all are below {least}", least=f"{SMALLEST_MULTIPLIER:g}")
    if largest:
        size = say("the largest is {size}", size=shown)
    section = say("a part of the motion") if math.isinf(steady.period) else say("a period")
    state = say("stable") if kind is None else say("unstable ({kind})", kind=word(kind))
    found = note("The steady state is {state}.", warning=kind is not None, state=state)
    contents.find(found)
    more = say(
        "Floquet multipliers over {section}, with the changing stiffness of the teeth: {size}.",
        section=section,
        size=size,
    )
    return replace(found, text=f"{found.text} {more}")


def _vibration(contents: Contents) -> Iterator[Block]:
    """Give peak, RMS and largest order of the accelerations in the motion."""
    run, _, steady = contents.motion
    system = contents.system
    if not any(direction == "v" for *_, direction in system.dofs):
        return
    places = contents.sensors
    series = {name: run.acceleration(name) for name in places or _bodies(contents)}
    sizes = {name: float(np.abs(values).max()) for name, values in series.items()}
    if not places:
        places = sorted(series, key=lambda name: -sizes[name])[:_BODIES]
    if not places:
        return
    rows = []
    for name in places:
        effective_of = series[name].std(axis=0)
        for k, axis in enumerate("yz"):
            values, rms = series[name][:, k], float(effective_of[k])
            # The orders of the larger of the two stand for both.
            largest = steady is not None and k == int(effective_of.argmax())
            order = _largest_order(run, name, axis) if largest else ""
            rows.append((f"{name} {axis}", float(np.abs(values).max()), rms, order))
    names, peaks, effective, largest_orders = zip(*rows, strict=True)
    least = ROUND_OFF * max(peaks)
    columns = [
        Column("place", names),
        Column("peak", np.array(peaks), "m/s²", round_off=least),
        Column("RMS", np.array(effective), "m/s²", round_off=least),
        *([Column("largest order", largest_orders)] if any(largest_orders) else []),
    ]
    title = say("Accelerations at the sensors of the housings")
    if not contents.sensors:
        title = say("Largest accelerations of gears and disks")
    remarks = []
    if any(largest_orders):
        remarks.append(
            say(
                "Largest order: amplitude; the rest is the part of the RMS that orders of shafts "
                "and teeth do not contain."
            )
        )
    yield contents.find(Table.of(title, columns, remarks))


def _largest_order(run: Response, place: str, axis: str) -> str:
    """Name the largest order of an acceleration, with its amplitude and what no order contains."""
    try:
        with warnings.catch_warnings():
            # The text below gives the rest, of which the warning is.
            warnings.simplefilter("ignore", AccuracyWarning)
            found = run.orders(place, f"acceleration_{axis}")  # type: ignore[arg-type]
    except GearbowError:  # the record does not separate its orders
        return ""
    largest = int(np.abs(found.amplitudes).argmax())
    return say(
        "{order}: {size} m/s²; rest {rest} %",
        order=", ".join(map(word, found.orders[largest].names)),
        size=f"{abs(found.amplitudes[largest]):.4g}",
        rest=f"{100.0 * found.rest_share:.0f}",
    )


def _bodies(contents: Contents) -> list[str]:
    return [body.name for body in (*contents.system.gears, *contents.system.disks)]
