"""Sections of a report at the operating speed: resonances, motion, accelerations and stresses."""

import math
import warnings
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from gearbow._result import ROUND_OFF, Column, Written, in_percent
from gearbow.description.places import place_label
from gearbow.errors import AccuracyWarning, GearbowError
from gearbow.recording.record import recorded_run
from gearbow.report.page import Block, Note, Table, note, picture, say, word
from gearbow.report.shared import (
    ABOVE,
    BELOW,
    SHOWN_REVOLUTIONS,
    UNDAMPED,
    Contents,
    margins,
    resonances_of,
)
from gearbow.results.campbell import Intersection
from gearbow.results.response import Response
from gearbow.results.steady import SMALLEST_MULTIPLIER, SteadyState


def resonances(contents: Contents) -> Iterator[Block]:
    """List the modes that orders of shafts and teeth meet near the operating speed."""
    found, span = contents.near, contents.options.operating
    assert span is not None
    limits: dict[str, Any] = {
        "low": contents.text(float(found.speeds[0])),
        "high": contents.text(float(found.speeds[-1])),
    }
    highest = float(contents.modes.frequencies_hz.max(initial=0.0))
    yield note(
        "Orders of shafts and teeth are compared with the modes up to {frequency} Hz, from {low} "
        "to {high}: API RP 684 requires margins of up to {below} % below and {above} % above the "
        "operating speed.",
        frequency=f"{highest:.4g}",
        below=f"{100 - 100 * BELOW:.0f}",
        above=f"{100 * ABOVE - 100:.0f}",
        **limits,
    )
    if highest < contents.excited:
        yield contents.find(
            "Teeth reach {frequency} Hz; modes above {highest} Hz are not compared.",
            warning=True,
            frequency=f"{contents.excited:.4g}",
            highest=f"{highest:.4g}",
        )
    near = found.intersections
    if not near:
        contents.find(
            "No order of shafts or teeth meets a mode (up to {frequency} Hz) from {low} to {high}.",
            frequency=f"{highest:.4g}",
            **limits,
        )
        yield note("No order of shafts or teeth meets a mode in this range of speeds.")
        return
    peaks = resonances_of(near, span)
    numbers = contents.numbers(found)
    distance = np.array([_distance(one.speed, span) for one in near])
    columns = [
        Column("mode", [numbers[one.mode] for one in near]),
        Column("frequency", np.array([one.frequency_hz for one in near]), "Hz", ".3f"),
        Column("whirl", [one.whirl for one in near]),
        Column("excited by", [one.line.name for one in near]),
        Column("order", np.array([abs(one.line.order) for one in near])),
        Column("speed", np.array([one.speed for one in near]), "rad/s", ".2f"),
        Column("distance", distance, "%", "+.1f"),
        Column("response", _responses(contents, near)),
    ]
    title = say("Modes that orders of shafts and teeth meet near the operating speed")
    remarks = [
        say(
            "Distance: from the operating speed, 0 within its range. Response at the resonance: "
            "largest orbit by bow and unbalance (major semi-axis), or mesh force by a transmission "
            "error of 1 µm; none without damping."
        )
    ]
    contents.find(Table.of(title, columns, remarks))
    close = min(zip(np.abs(distance), near, strict=True), key=lambda one: one[0])
    contents.find(
        "The nearest resonance: {source} meets mode {mode} ({frequency} Hz) {distance} % "
        "beside the operating speed.",
        warning=any(peak.verdict in ("too close", "unstable") for peak in peaks),
        source=word(close[1].line.name),
        mode=numbers[close[1].mode],
        frequency=f"{close[1].frequency_hz:.4g}",
        distance=f"{close[0]:.2g}",
    )
    damping = np.array([one.damping_ratio for one in near])
    yield Table.of(
        say("Margins of these modes after API RP 684"),
        [
            *columns[:1],
            *columns[3:6],
            Column("damping ratio", damping, "", ".3f", in_percent("damping")),
            *margins(peaks),
        ],
        [say("The standard means lateral modes and orders of shafts; teeth are listed alike.")],
    )


def _distance(speed: float, span: tuple[float, float]) -> float:
    """Give the distance of a speed from the operating speeds of its sign [%]; 0 between them."""
    low, high = span
    return 100.0 * (min(speed / low - 1.0, 0.0) + max(speed / high - 1.0, 0.0))


def _responses(contents: Contents, near: tuple[Intersection, ...]) -> list[str]:
    """Write the response of each resonance; "–" for one without a finite amplitude."""
    written = []
    for one in near:
        value = math.nan
        if abs(one.damping_ratio) > UNDAMPED:
            try:
                value = _response(contents.system, one)
            except GearbowError:  # the system has no such motion
                value = math.nan
        if not math.isfinite(value):
            written.append("–")
        elif one.line.kind == "shaft":
            written.append(f"{1e6 * value:.4g} µm")
        else:
            written.append(f"{value:.4g} N/µm")
    return written


def _response(system: Any, one: Intersection) -> float:
    """Give the largest orbit that a shaft excites [m], or the mesh force of 1 µm [N]."""
    if one.line.kind != "shaft":
        found = system.mesh_response(
            one.line.source, speeds=[one.speed], harmonics=[one.line.harmonic]
        )
        return float(np.abs(found.mesh_force(one.line.source)).max())
    response = system.synchronous([one.speed])
    source = response.shafts.index(one.line.source)
    places = [body.name for body in (*system.gears, *system.disks)]
    places += [(bearing.shaft, bearing.position) for bearing in system.bearings]
    return max((float(response.orbit(at)[0, source]) for at in places), default=math.nan)


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
    largest = steady.largest_multiplier()
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


#: How tables write stresses.
_MPA = Written("MPa", 1e-6)


def strength(contents: Contents) -> Iterator[Block]:
    """Give the worst section of each shaft, its stresses and its utilisation."""
    options = contents.options
    found = contents.system.stresses(
        contents.speed,
        endurance_limit=options.endurance_limit,
        tensile_strength=options.tensile_strength,
    )
    limited = np.isfinite(found.utilisation)
    measure = np.where(limited, found.utilisation, found.amplitude)
    shafts = [shaft for shaft, *_ in found.sections]
    worst = [
        max((i for i, own in enumerate(shafts) if own == name), key=lambda i: measure[i])
        for name in dict.fromkeys(shafts)
    ]
    least = ROUND_OFF * float(found.amplitude.max(initial=0.0))
    pairs = {"bending": found.bending, "axial": found.axial, "torsion": found.torsion}
    stresses = {
        f"{name} {kind}": values[:, k]
        for name, values in pairs.items()
        for k, kind in enumerate(("mean", "±"))
    }
    stresses |= {"equivalent mean": found.mean, "equivalent ±": found.amplitude}
    use = [Column("utilisation", found.utilisation[worst], "", ".3f")] if limited.any() else []
    yield Table.of(
        say("The worst section of each shaft"),
        [
            Column("shaft", [shafts[i] for i in worst]),
            Column("position", np.array([found.sections[i][1] for i in worst]), "m"),
            *(
                Column(name, values[worst], "Pa", ".4g", _MPA, least)
                for name, values in stresses.items()
            ),
            Column("notch", [found.notches[i] for i in worst]),
            *use,
        ],
        [
            say(
                "Nominal stresses of the turning shafts by the static equilibrium, bow and "
                "unbalance; ± is the amplitude. The equivalent amplitude has the notch factors "
                "(bending / torsion)."
            ),
            *(
                [say("Excitations that are not contained: {names}.", names=names)]
                if (names := ", ".join(map(word, found.left_out)))
                else []
            ),
        ],
    )
    open_steps = sum(text == "none given" for text in found.notches)
    if open_steps:
        yield note(
            "Sections at a step of the diameter without notch factors: {count}. Their real "
            "stresses are larger.",
            warning=True,
            count=open_steps,
        )
    yield picture(found.plot(), say("Equivalent stresses along the shafts."))
    i = found.worst
    shaft, x, _ = found.sections[i]
    values = {
        "shaft": shaft,
        "position": f"{1e3 * x:.4g}",
        "amplitude": _written(found.amplitude[i], least),
        "mean": _written(found.mean[i], least),
    }
    if not limited.any():
        contents.find(
            "Largest stress: amplitude {amplitude} MPa, mean {mean} MPa, {shaft} at {position} mm "
            "(no endurance limit was given).",
            **values,
        )
        return
    contents.find(
        "Largest utilisation of a shaft: {use} (amplitude {amplitude} MPa, mean {mean} MPa, {shaft}"
        " at {position} mm).",
        warning=bool(found.utilisation[i] > 1.0),
        use=f"{found.utilisation[i]:.3f}",
        **values,
    )


def _written(stress: float, least: float) -> str:
    """Write a stress [Pa] in MPa; what is not above round-off is zero."""
    return f"{1e-6 * stress if abs(stress) > least else 0.0:.4g}"
