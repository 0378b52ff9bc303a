"""The sections of a report and what they compute.

A section is a generator of blocks. What it cannot compute for a system becomes a sentence with the
reason, and the blocks before it stay.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gearbow._result import Column, in_micrometres, in_percent, replaced
from gearbow.description.bow import BowLimit
from gearbow.description.layout import assumptions, ratios_by_shaft, tooth_orders
from gearbow.description.places import place_label
from gearbow.description.rolling import RollingBearing
from gearbow.description.shafts import Shaft, segments_of
from gearbow.report import api617
from gearbow.report.operation import motion, resonances, strength
from gearbow.report.page import Block, Note, Picture, Table, note, parts_tables, picture, say, word
from gearbow.report.shared import UNDAMPED, Contents, Make, margins, reason_of, resonances_of
from gearbow.results.bow_limits import BowLimits
from gearbow.results.campbell import Intersection
from gearbow.results.modes import Modes
from gearbow.results.peak import marks
from gearbow.units.speed import PER_MINUTE, speed_factor

#: Damping ratio from which a mode is no resonance, and number of critical speeds of the summary.
_OVERDAMPED, _NAMED = 0.7, 6
#: Number of modes of the overview, and of those in three dimensions.
_OVERVIEW, _IN_SPACE = 6, 4


def drawing(contents: Contents) -> Iterator[Block]:
    """Draw the train to scale."""
    system = contents.system
    yield picture(system.plot(), say("The train to scale; bows are enlarged."))
    turns, tooth = contents.speed / (2.0 * math.pi), tooth_orders(system)
    rows = []
    for shaft, ratio in ratios_by_shaft(system).items():
        gears = [gear for gear in system.gears if gear.shaft == shaft]
        row = [shaft, f"{ratio:.6g}"]
        if contents.speed:
            row += [f"{60.0 * ratio * turns:.6g}", f"{abs(ratio * turns):.6g}"]
        row.append(", ".join(f"{gear.name} ({gear.teeth})" for gear in gears))
        teeth = [tooth[gear.name] * (abs(turns) or 1.0) for gear in gears]
        rows.append([*row, ", ".join(dict.fromkeys(f"{each:.6g}" for each in teeth))])
    head = ["shaft", "speed ratio", f"speed [{PER_MINUTE}]", "1× [Hz]", "gears (teeth)"]
    title = say("Shafts and tooth frequencies")
    if contents.speed:
        speed = contents.text(contents.speed)
        title = say("Shafts and tooth frequencies at {speed}", speed=speed)
    if not contents.speed:
        head = [*head[:2], head[-1]]
    if system.gears:
        head.append("tooth frequency [Hz]" if contents.speed else "tooth frequency / speed")
    else:
        head, rows = head[:-1], [row[:-2] for row in rows]
    numeric = [name not in ("shaft", "gears (teeth)") for name in head]
    yield Table(title, list(map(word, head)), rows, numeric=numeric)


def data(contents: Contents) -> Iterator[Block]:
    """List the data and what is assumed."""
    system = contents.system
    yield note(
        "Values are those of the description; fields that are not listed have their defaults. "
        "x runs along the shafts; seen with +x towards the viewer, y points right and z up. "
        "Positions count from the left end of a shaft."
    )
    yield from parts_tables(system)
    assumed = assumptions(system)
    if assumed:
        yield Table(
            say("Assumed where the description says nothing"),
            (word("parts"), word("assumption")),
            [list(map(word, text.split(": ", 1))) for text in assumed],
            numeric=(False, False),
        )


def mass(contents: Contents) -> Iterator[Block]:
    """List masses and inertias."""
    system = contents.system
    found = system.mass_properties()
    yield Table.of_result(found, say("Mass properties of the shafts with sleeves, gears and disks"))
    reduced = float(system.speed_ratios**2 @ found.polar_inertia)
    yield note(
        "The polar inertia of all shafts, reduced to the reference shaft, is {inertia} kg m².",
        inertia=f"{reduced:.4g}",
    )


def static(contents: Contents) -> Iterator[Block]:
    """Give the loads of meshes and bearings at equilibrium."""
    from gearbow.plotting.style import quantity  # noqa: PLC0415

    found = contents.static
    yield Table.of_result(found, say("Static equilibrium {where}", where=contents.where))
    meshes = [(mesh.driver, mesh.driven) for mesh in contents.system.meshes]
    if meshes:
        states = [found.mesh(pair) for pair in meshes]
        columns = [Column("mesh", ["–".join(pair) for pair in meshes])]
        for name, factor, unit in (
            ("force", 1.0, "N"),
            ("thrust", 1.0, "N"),
            ("stiffness", 1e-6, "N/µm"),
            ("pressure_angle", 180.0 / math.pi, "°"),
            ("centre_distance", 1e3, "mm"),
            ("contact_ratio", 1.0, ""),
        ):
            values = factor * np.array([getattr(state, name) for state in states])
            columns.append(Column(name.replace("_", " "), values, unit, ".6g"))
        yield Table.of(say("Meshes at equilibrium"), columns)
        pair, state = max(zip(meshes, states, strict=True), key=lambda one: abs(one[1].force))
        force = f"{quantity(abs(state.force), 'N')}, {'–'.join(pair)}"
        contents.find("Largest static mesh force: {force}.", force=force)
    yield picture(found.plot(), say("Static deflection of the shafts."))


def life(contents: Contents) -> Iterator[Block]:
    """Give the rating life of the bearings."""
    contents.need_operating()
    bearings = contents.system.bearings
    if all(getattr(one, "dynamic_rating", None) is None for one in bearings) and not any(
        isinstance(one, RollingBearing) for one in bearings
    ):
        yield note("No bearing is a rolling bearing or has a dynamic rating.")
        return
    found = contents.static.bearing_life()
    yield Table.of_result(found, say("Life of bearings"))
    yield picture(found.plot(), say("Basic rating life of the bearings."))
    first = found.shortest
    contents.find(
        "Shortest basic rating life: {hours} h, bearing {bearing}.",
        hours=f"{first.hours:.4g}",
        bearing=word(place_label(first.at)),
    )


def modes(contents: Contents) -> Iterator[Block]:
    """Show natural modes."""
    found = contents.modes
    yield Table.of_result(found, say("Modes {where}", where=contents.where))
    yield picture(found.plot(count=_OVERVIEW), say("Shapes along the shafts."))
    elastic = found._vibrations()
    for number in elastic[:_IN_SPACE]:
        yield _in_space(found, number + 1)


def _in_space(found: Modes, number: int) -> Picture:
    """Show a mode in three dimensions."""
    from gearbow.plotting.interactive import scene  # noqa: PLC0415
    from gearbow.plotting.shapes import parts  # noqa: PLC0415

    title, shape, dofs = found._drawn(number)
    space = scene(parts(shape, dofs, found.layout), title)
    caption = say(
        "Mode {number} in three dimensions, enlarged; the mouse turns and enlarges the view.",
        number=number,
    )
    return picture(found.plot(number), caption, space=space)


def campbell(contents: Contents) -> Iterator[Block]:
    """Show the Campbell diagram."""
    found = contents.campbell
    operating = contents.options.operating
    yield picture(found.plot(operating=operating), say("Campbell diagram. Grey: operating speed."))
    if found.intersections or found.thresholds:
        title = say("Intersections and stability thresholds")
        yield Table.of_result(found, title, contents.numbers(found))
    else:
        yield note("No line of excitation crosses a mode, and no mode changes its stability.")


def criticals(contents: Contents) -> Iterator[Block]:
    """Give separation margins and amplification factors."""
    operating = contents.options.operating
    found = contents.campbell.criticals
    if found:
        peaks = resonances_of(found, operating)
        yield Table.of(
            say("Critical speeds of the Campbell diagram, with the amplification factor 1/(2ζ)"),
            [
                Column("mode", [contents.numbers(contents.campbell)[one.mode] for one in found]),
                Column("critical speed", [one.speed for one in found], "rad/s", ".2f"),
                Column("frequency", [one.frequency_hz for one in found], "Hz", ".3f"),
                Column("excited by", [one.line.name for one in found]),
                Column("whirl", [one.whirl for one in found]),
                Column(
                    "damping ratio",
                    np.array([one.damping_ratio for one in found]),
                    "",
                    ".3f",
                    in_percent("damping"),
                ),
                *margins(peaks),
            ],
            [say(API_684), say(_OTHER_MODES)],
        )
        _find_nearest(contents, found)
    else:
        yield note("No shaft excites a mode at its own frequency in this range of speeds.")
    places = _largest(contents)
    close = 0
    for place in places:
        peaks_at, at = _peaks(contents, place), word(place_label(place))
        close += sum(peak.verdict in ("too close", "unstable") for peak in peaks_at)
        if len(peaks_at):
            yield Table.of_result(
                peaks_at,
                say("Peaks of {place}, excited by {shaft}", place=at, shaft=peaks_at.source),
            )
        else:
            yield note("{place}: the response has no peak in this range of speeds.", place=at)
    if operating is not None and places and close:
        contents.find(
            "Separation margins after API RP 684: peaks of the response to bow and unbalance that "
            "are too close to the operating speed, or unstable: {count}.",
            warning=True,
            count=close,
        )
    elif operating is not None and places:
        contents.find(
            "Separation margins after API RP 684: no peak of the response to bow and unbalance is "
            "too close to the operating speed."
        )
    yield from api617.unbalance(contents)


API_684 = (
    "Required margin after API RP 684: 17 (1 − 1/(AF − 1.5)) % below and 10 % more above the "
    "operating speed; none for AF < 2.5."
)


def _find_nearest(contents: Contents, found: Sequence[Intersection]) -> None:
    """Name the critical speeds that are nearest to the operating speed, in ascending order."""
    unit, speed = contents.options.unit, contents.speed
    near = sorted(
        (one for one in found if one.damping_ratio < _OVERDAMPED),
        key=lambda one: abs(one.speed - speed),
    )[:_NAMED]
    if not near:
        contents.find("No shaft excites a lightly damped mode at its own frequency.")
        return
    texts = [
        f"{speed_factor(unit) * one.speed:.4g} ({one.line.name}, {word(one.whirl)})"
        for one in sorted(near, key=lambda one: abs(one.speed))
    ]
    speeds = ", ".join(texts)
    if len(near) == len(found):
        contents.find("Critical speeds [{unit}]: {speeds}.", unit=unit, speeds=speeds)
    else:
        contents.find("Nearest critical speeds [{unit}]: {speeds}.", unit=unit, speeds=speeds)


_LINEARISED = (
    "Of the motion about the static equilibrium, linearised with mean mesh stiffnesses and with "
    "the coefficients of the bearings at this speed."
)
_OTHER_MODES = (
    "The standard means lateral modes; unbalance and bow do not excite axial motion and, without "
    "teeth, no torsion. The response shows which of the speeds matter."
)


def _largest(contents: Contents) -> list[Any]:
    """Give the places with the largest response."""
    found = contents.synchronous
    moving = [at for at in found._places() if np.any(found._own(found.orbit(at), at) > 0.0)]
    return found._largest(moving)


def _peaks(contents: Contents, place: Any) -> Any:
    """Find the peaks at a place once for all sections."""
    found = contents.synchronous
    model, span = contents.system._model, contents.options.operating
    return contents.kept(
        f"peaks of {place_label(place)}", lambda: found._peaks(model, place, None, span)
    )


def stability(contents: Contents) -> Iterator[Block]:
    """Give damping at the operating speed, thresholds and ranges of instability."""
    found = contents.modes
    ratio = np.clip(found.damping_ratios, -1.0, 1.0)
    order = found._vibrations()
    with np.errstate(divide="ignore"):
        decrement = 2.0 * math.pi * ratio / np.sqrt(1.0 - ratio**2)
    names = found.names()
    where = contents.where
    yield Table.of(
        say("Logarithmic decrement {where}", where=where),
        [
            Column("mode", np.array(order) + 1),
            Column("frequency", found.frequencies_hz[order], "Hz", ".3f"),
            Column("decrement", decrement[order], "", ".4g", None, 2.0 * math.pi * UNDAMPED),
            Column("whirl", [found.whirl[i] for i in order]),
            Column("largest motion", [names[i] for i in order]),
        ],
        remarks=[say(_LINEARISED)],
    )
    growing = [
        i
        for i in range(len(ratio))
        if found.eigenvalues[i].real > UNDAMPED * abs(found.eigenvalues[i])
    ]
    state = say("unstable") if growing else say("stable")
    free = [i + 1 for i in order if abs(ratio[i]) <= UNDAMPED]
    contents.find(
        "The linear motion {where} is {state}.", warning=bool(growing), where=where, state=state
    )
    if len(free) == len(order) and not growing:
        contents.find("No mode has damping: resonances have no finite amplitude.", warning=True)
    yield note(
        "The motion {where} is {state}: {growing} of {count} modes grow.",
        warning=bool(growing),
        where=where,
        state=state,
        growing=len(growing),
        count=len(ratio),
    )
    ranges = contents.campbell.unstable_ranges
    if ranges:
        ends = ", ".join(
            say("{low} to {high}", low=contents.text(low), high=contents.text(high))
            for low, high in ranges
        )
        yield contents.find(
            "Speeds at which a mode is unstable: {speeds}.", warning=True, speeds=ends
        )
    else:
        yield note("No mode of the Campbell diagram is unstable in its range of speeds.")
    yield from api617.level_1(contents)


def response(contents: Contents) -> Iterator[Block]:
    """Show the response to bow and unbalance."""
    from gearbow.plotting import harmonic  # noqa: PLC0415

    system, found = contents.system, contents.synchronous
    places = _largest(contents)
    if not places:
        lateral = any(direction == "v" for *_, direction in system.dofs)
        reason = (
            say("no shaft has a bow and no body an unbalance")
            if lateral
            else say("the system has no lateral motion")
        )
        yield note("There is no response to bow and unbalance: {reason}.", reason=reason)
        return
    curves, peaks = {}, {}
    for place in places:
        own, label = _peaks(contents, place), word(place_label(place))
        curves[label] = harmonic.Curve(found.speeds, own.amplitude, own.phase)
        peaks[label] = marks(own)
    figure = harmonic.bode(
        curves,
        "m",
        peaks=peaks,
        operating=contents.options.operating,
    )
    yield picture(
        figure,
        say(
            "Phase and amplitude (major semi-axis) where the orbits are largest; AF: amplification "
            "factor."
        ),
    )
    speed = contents.need_operating()
    parts = {
        kind: system.synchronous([speed], excitation=kind) for kind in ("both", "bow", "unbalance")
    }
    every = found._places()
    orbits = {
        kind: np.array([part._own(part.orbit(at), at)[0] for at in every])
        for kind, part in parts.items()
    }
    phase = np.array([parts["both"]._own(parts["both"].phase(at), at)[0] for at in every])
    yield Table.of(
        say(
            "Major semi-axis of the orbit that the own shaft excites at {speed}",
            speed=contents.text(speed),
        ),
        [
            Column("place", list(map(place_label, every))),
            *(
                Column(
                    "bow and unbalance" if kind == "both" else kind,
                    values,
                    "m",
                    ".4g",
                    in_micrometres(),
                )
                for kind, values in orbits.items()
            ),
            Column("phase", np.degrees(phase), "°", ".1f"),
        ],
        remarks=[say("Phase: angle of the high spot in the shaft, from its mark at angle 0.")],
    )


def bow(contents: Contents) -> Iterator[Block]:
    """Give the largest bow of each shaft."""
    speed, system = contents.need_operating(), contents.system
    if not any(direction == "v" for *_, direction in system.dofs):
        yield note("A bow has no effect: the system has no lateral motion.")
        return
    for shaft in system.shafts:
        bearings = [bearing.position for bearing in system.bearings if bearing.shaft == shaft.name]
        limits = [BowLimit.displacement((shaft.name, x), "API 617") for x in bearings]
        try:
            found = contents.with_bows.bow_limits(
                shaft.name, speed, limits=[*limits, *contents.options.limits]
            )
        except Exception as error:  # noqa: BLE001  # the limits of the other shafts are of use
            reason = reason_of(error)
            yield note("{shaft}: not computed, because {reason}", shaft=shaft.name, reason=reason)
            contents.find(
                "Limits of the bow of {shaft}: {reason}.",
                warning=True,
                shaft=shaft.name,
                reason=reason,
            )
            continue
        found = _meaningful(found, shaft)
        yield Table.of_result(
            found,
            say(
                "Limits of the bow of {shaft} at {speed}; present bow {bow} µm",
                shaft=shaft.name,
                speed=contents.text(speed),
                bow=f"{1e6 * found.present:.4g}",
            ),
        )
        first = found.deciding
        if first is not None:
            contents.find(
                "Bow of {shaft}: {present} µm of at most {most} µm, by the limit {limit} ({at}).",
                warning=found.margin < 0.0,
                shaft=shaft.name,
                present=f"{1e6 * found.present:.4g}",
                most=f"{1e6 * first.bow:.4g}",
                limit=word(first.limit),
                at=word(first.at),
            )
        else:
            contents.find("No bow of {shaft} up to its diameter reaches a limit.", shaft=shaft.name)
    yield note(
        "The value of API 617 for the vibration of a shaft, 25.4 µm √(12000/n), is a reference "
        "at each bearing; whether the standard applies to this machine is for its user to "
        "decide. Bows above the largest diameter of the shaft are no limits: the shaft is "
        "destroyed before."
    )


def _meaningful(found: BowLimits, shaft: Shaft) -> BowLimits:
    """Leave out bows that are larger than the largest diameter of the shaft."""
    ends = ((one.outer_diameter, one.end_outer_diameter or 0.0) for one in segments_of(shaft))
    diameter = max(size for pair in ends for size in pair)
    why = say("above the diameter of the shaft, {diameter} mm", diameter=f"{1e3 * diameter:.4g}")
    return replaced(
        found,
        found=tuple(
            replace(one, bow=math.inf, why=why) if diameter < one.bow < math.inf else one
            for one in found.found
        ),
    )


def accuracy(contents: Contents) -> Iterator[Block]:
    """Give elements, residuals and warnings."""
    system = contents.system
    for line in str(system.discretisation).splitlines()[len(system.shafts) :]:
        yield Note(f"{word(line[:1].upper() + line[1:])}.")
    elements = system.discretisation.shafts.items()
    rows = [(name, " + ".join(map(str, each.numbers)), str(each.degree)) for name, each in elements]
    yield Table(
        say("Elements"),
        (word("shaft"), word("elements of its segments"), word("degree")),
        rows,
        numeric=(False, False, True),
    )
    residuals: list[tuple[str, str]] = []
    measured: dict[str, tuple[str, Callable[[Any], float]]] = {
        "static": (say("static equilibrium: unbalanced part of the load"), lambda r: r.residual),
        "modes": (say("modes: part of the forces, largest"), lambda r: r.residuals.max()),
        "campbell": (
            say("critical speeds and tooth resonances, largest"),
            lambda r: max((one.residual for one in r.intersections), default=0.0),
        ),
        "synchronous": (
            say("response to bow and unbalance: backward error, largest"),
            lambda r: r.residuals.max(),
        ),
    }
    for name, (title, value) in measured.items():
        found = contents.finished(name)
        if found is not None:
            residuals.append((title, f"{float(value(found)):.1e}"))
    yield Table(
        say("Residuals of the equations"),
        (word("result"), word("residual")),
        residuals,
        numeric=(False, True),
    )
    given = [(word("file"), text) for text in system._notes]
    given += [(word("description"), text) for text in system._model.warnings]
    every = [*given, *contents.warned]
    if every:
        head = (word("section"), word("warning"))
        yield Table(say("Warnings"), head, every, numeric=(False, False))
    else:
        yield note("There were no warnings.")


#: Name, title and content of each section, in their order.
SECTIONS: tuple[tuple[str, str, Make], ...] = (
    ("drawing", "Drawing", drawing),
    ("data", "Data and assumptions", data),
    ("mass", "Mass properties", mass),
    ("static", "Static loads", static),
    ("life", "Life of bearings", life),
    ("modes", "Natural modes", modes),
    ("campbell", "Campbell diagram", campbell),
    ("criticals", "Critical speeds", criticals),
    ("resonances", "Resonances near the operating speed", resonances),
    ("stability", "Stability", stability),
    ("response", "Response to unbalance and bow", response),
    ("strength", "Strength of the shafts", strength),
    ("bow", "Limits of the bow", bow),
    ("motion", "Motion at the operating speed", motion),
    ("accuracy", "Accuracy and warnings", accuracy),
)
