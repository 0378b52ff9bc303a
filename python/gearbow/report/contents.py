"""The sections of a report and what they compute.

A section is a generator of blocks. What it cannot compute for a system becomes a sentence with the
reason, and the blocks before it stay.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from gearbow._result import Column, in_micrometres, in_percent
from gearbow.description.bow_limit import BowLimit
from gearbow.description.layout import assumptions
from gearbow.description.places import place_label
from gearbow.description.rolling import RollingBearing
from gearbow.errors import GearbowError
from gearbow.recording.record import recorded_run
from gearbow.report import api617
from gearbow.report.page import Block, Note, Picture, Table, parts_tables, picture
from gearbow.report.shared import SHOWN_REVOLUTIONS, Contents, Make, reason_of
from gearbow.results.campbell import Intersection
from gearbow.results.modes import Modes
from gearbow.results.peak import Peak, marks
from gearbow.results.steady import SMALLEST_MULTIPLIER, SteadyState
from gearbow.units.speed import speed_factor

#: Damping ratio, without its sign, of a mode that neither grows nor decays.
_GROWTH = 1e-6
#: Damping ratio from which a mode is no resonance, and number of critical speeds of the summary.
_OVERDAMPED, _NAMED = 0.7, 6
#: Number of modes of the overview, and of those in three dimensions.
_OVERVIEW, _IN_SPACE = 6, 4
#: Largest numbers of panels of a figure: orbits, bearings, spectra.
_ORBITS, _BEARINGS, _SPECTRA = 8, 4, 3


def drawing(contents: Contents) -> Iterator[Block]:
    """Draw the train to scale."""
    system = contents.system
    yield picture(system.plot(), "The train to scale; bows are enlarged.")
    turns = contents.speed / (2.0 * math.pi)
    rows = []
    for shaft, ratio in zip(system.shafts, system.speed_ratios, strict=True):
        gears = [gear for gear in system.gears if gear.shaft == shaft.name]
        row = [shaft.name, f"{ratio:.6g}"]
        if contents.speed:
            row += [f"{60.0 * ratio * turns:.6g}", f"{abs(ratio * turns):.6g}"]
        row.append(", ".join(f"{gear.name} ({gear.teeth})" for gear in gears))
        teeth = [abs(ratio * gear.teeth) * (abs(turns) or 1.0) for gear in gears]
        rows.append([*row, ", ".join(dict.fromkeys(f"{each:.6g}" for each in teeth))])
    head = ["shaft", "speed ratio", "speed [rpm]", "1× [Hz]", "gears (teeth)"]
    at = f" at {contents.text(contents.speed)}" if contents.speed else ""
    if not contents.speed:
        head = [*head[:2], head[-1]]
    if system.gears:
        head.append("tooth frequency [Hz]" if contents.speed else "tooth frequency / speed")
    else:
        head, rows = head[:-1], [row[:-2] for row in rows]
    numeric = [name not in ("shaft", "gears (teeth)") for name in head]
    yield Table(f"Shafts and tooth frequencies{at}", head, rows, numeric=numeric)


def data(contents: Contents) -> Iterator[Block]:
    """List the data and what is assumed."""
    system = contents.system
    yield Note(
        "Values are those of the description; fields that are not listed have their defaults. "
        "x runs along the shafts; seen with +x towards the viewer, y points right and z up. "
        "Positions count from the left end of a shaft."
    )
    yield from parts_tables(system)
    assumed = assumptions(system.shafts, system.gears, system.meshes, system.bearings)
    if assumed:
        yield Table(
            "Assumed where the description says nothing",
            ("parts", "assumption"),
            [text.split(": ", 1) for text in assumed],
            numeric=(False, False),
        )


def mass(contents: Contents) -> Iterator[Block]:
    """List masses and inertias."""
    system = contents.system
    found = system.mass_properties()
    yield Table.of_result(found)
    reduced = float(system.speed_ratios**2 @ found.polar_inertia)
    yield Note(
        f"The polar inertia of all shafts, reduced to the reference shaft, is {reduced:.4g} kg m²."
    )


def static(contents: Contents) -> Iterator[Block]:
    """Give the loads of meshes and bearings at equilibrium."""
    from gearbow.plotting.style import quantity  # noqa: PLC0415

    found = contents.static
    yield Table.of_result(found)
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
        yield Table.of("Meshes at equilibrium", columns)
        pair, state = max(zip(meshes, states, strict=True), key=lambda one: abs(one[1].force))
        force = f"{quantity(abs(state.force), 'N')}, {'–'.join(pair)}"
        contents.findings.append((f"Largest static mesh force: {force}.", False))
    yield picture(found.plot(), "Static deflection of the shafts.")


def life(contents: Contents) -> Iterator[Block]:
    """Give the rating life of the bearings."""
    contents.need_operating()
    bearings = contents.system.bearings
    if all(getattr(one, "dynamic_rating", None) is None for one in bearings) and not any(
        isinstance(one, RollingBearing) for one in bearings
    ):
        yield Note("No bearing is a rolling bearing or has a dynamic rating.")
        return
    found = contents.static.bearing_life()
    yield Table.of_result(found)
    yield picture(found.plot(), "Basic rating life of the bearings.")
    first = found.shortest
    text = f"Shortest basic rating life: {first.hours:.4g} h, bearing {place_label(first.at)}."
    contents.findings.append((text, False))


def modes(contents: Contents) -> Iterator[Block]:
    """Show natural modes."""
    found = contents.modes
    yield Table.of_result(found)
    yield picture(found.plot(count=_OVERVIEW), "Shapes along the shafts.")
    elastic = found._vibrations()
    for number in elastic[:_IN_SPACE]:
        yield _in_space(found, number + 1)


def _in_space(found: Modes, number: int) -> Picture:
    """Show a mode in three dimensions."""
    from gearbow.plotting.interactive import scene  # noqa: PLC0415
    from gearbow.plotting.shapes import parts  # noqa: PLC0415

    title, shape, dofs = found._drawn(number)
    space = scene(parts(shape, dofs, found.layout), title)
    caption = f"Mode {number} in three dimensions, enlarged; the mouse turns and enlarges the view."
    return picture(found.plot(number), caption, space=space)


def campbell(contents: Contents) -> Iterator[Block]:
    """Show the Campbell diagram."""
    found = contents.campbell
    operating = contents.options.operating
    if contents.speed < 0.0:
        yield Note(
            "The diagram is that of positive speeds; it shades the size of the operating speed."
        )
    yield picture(found.plot(operating=operating), "Campbell diagram. Grey: operating speed.")
    if found.intersections or found.thresholds:
        yield Table.of_result(found)
    else:
        yield Note("No line of excitation crosses a mode, and no mode changes its stability.")


def criticals(contents: Contents) -> Iterator[Block]:
    """Give separation margins and amplification factors."""
    operating = contents.options.operating
    found = contents.campbell.criticals
    span = None if operating is None else (abs(operating[0]), abs(operating[1]))
    if found:
        # The half-power points of a mode of damping ratio ζ are at N (1 ± ζ).
        peaks = [
            Peak(
                one.speed,
                math.nan,
                one.speed * (1.0 - one.damping_ratio),
                one.speed * (1.0 + one.damping_ratio),
                span,
                one.damping_ratio > -_GROWTH,
            )
            for one in found
        ]
        yield Table.of(
            "Critical speeds of the Campbell diagram, with the amplification factor 1/(2ζ)",
            [
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
                *_margins(peaks),
            ],
            [_API_684, _OTHER_MODES],
        )
        contents.findings.append((_nearest(contents, found), False))
    else:
        yield Note("No shaft excites a mode at its own frequency in this range of speeds.")
    places = _largest(contents)
    close = 0
    for place in places:
        peaks_at = _peaks(contents, place)
        close += sum(peak.verdict in ("too close", "unstable") for peak in peaks_at)
        if len(peaks_at):
            yield Table.of_result(peaks_at)
        else:
            yield Note(f"{place_label(place)}: the response has no peak in this range of speeds.")
    if operating is not None and places:
        text = "no peak of the response is too close to the operating speed"
        if close:
            count = f"{close} peak{'s' if close > 1 else ''} of the response"
            text = f"{count} too close to the operating speed, or unstable"
        contents.findings.append((f"Separation margins after API 684: {text}.", close > 0))
    yield from api617.unbalance(contents)


_API_684 = (
    "Required margin after API RP 684: 17 (1 − 1/(AF − 1.5)) % below and 10 % more above the "
    "operating speed; none for AF < 2.5."
)


def _nearest(contents: Contents, found: Sequence[Intersection]) -> str:
    """Name the critical speeds that are nearest to the operating speed, in ascending order."""
    unit, speed = contents.options.unit, abs(contents.speed)
    near = sorted(
        (one for one in found if one.damping_ratio < _OVERDAMPED),
        key=lambda one: abs(one.speed - speed),
    )[:_NAMED]
    if not near:
        return "No shaft excites a lightly damped mode at its own frequency."
    texts = [
        f"{speed_factor(unit) * one.speed:.4g} ({one.line.name}, {one.whirl})"
        for one in sorted(near, key=lambda one: one.speed)
    ]
    which = "Critical speeds" if len(near) == len(found) else "Nearest critical speeds"
    return f"{which} [{unit}]: {', '.join(texts)}."


_LINEARISED = (
    "Of the motion about the static equilibrium, linearised with mean mesh stiffnesses and with "
    "the coefficients of the bearings at this speed."
)
_OTHER_MODES = (
    "The standard means lateral modes; unbalance and bow do not excite axial motion and, without "
    "teeth, no torsion. The response shows which of the speeds matter."
)


def _margins(peaks: list[Peak]) -> list[Column]:
    """Give the columns of API 684."""
    return [
        Column("amplification factor", [peak.amplification_factor for peak in peaks]),
        Column("margin", [peak.separation_margin for peak in peaks], "%"),
        Column("required margin", [peak.required_margin for peak in peaks], "%"),
        Column("verdict", [peak.verdict for peak in peaks]),
    ]


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
    where = "at standstill" if not contents.speed else f"at {contents.text(contents.speed)}"
    yield Table.of(
        f"Logarithmic decrement {where}",
        [
            Column("mode", np.array(order) + 1),
            Column("frequency", found.frequencies_hz[order], "Hz", ".3f"),
            Column("decrement", decrement[order], "", ".4g", None, 2.0 * math.pi * _GROWTH),
            Column("whirl", [found.whirl[i] for i in order]),
            Column("largest motion", [names[i] for i in order]),
        ],
        remarks=[_LINEARISED],
    )
    growing = [
        i
        for i in range(len(ratio))
        if found.eigenvalues[i].real > _GROWTH * abs(found.eigenvalues[i])
    ]
    state = "unstable" if growing else "stable"
    contents.findings.append((f"The linear motion {where} is {state}.", bool(growing)))
    yield Note(
        f"The motion {where} is {state}: {len(growing)} of {len(ratio)} modes grow.", bool(growing)
    )
    ranges = contents.campbell.unstable_ranges
    if ranges:
        ends = ", ".join(f"{contents.text(low)} to {contents.text(high)}" for low, high in ranges)
        yield Note(f"Speeds at which a mode is unstable: {ends}.", True)
        contents.findings.append((f"A mode is unstable at {ends}.", True))
    else:
        yield Note("No mode of the Campbell diagram is unstable in its range of speeds.")
    yield from api617.level_1(contents)


def response(contents: Contents) -> Iterator[Block]:
    """Show the response to bow and unbalance."""
    from gearbow.plotting import harmonic  # noqa: PLC0415

    system, found = contents.system, contents.synchronous
    places = _largest(contents)
    if not places:
        lateral = any(direction == "v" for *_, direction in system.dofs)
        reason = (
            "no shaft has a bow and no body an unbalance"
            if lateral
            else "the system has no lateral motion"
        )
        yield Note(f"There is no response to bow and unbalance: {reason}.")
        return
    curves, peaks = {}, {}
    for place in places:
        own, label = _peaks(contents, place), place_label(place)
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
        "Phase and amplitude (major semi-axis) where the orbits are largest; AF: amplification "
        "factor.",
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
        f"Major semi-axis of the orbit that the own shaft excites at {contents.text(speed)}",
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
        remarks=["Phase: angle of the high spot in the shaft, from its mark at angle 0."],
    )


def bow(contents: Contents) -> Iterator[Block]:
    """Give the largest bow of each shaft."""
    speed, system = contents.need_operating(), contents.system
    if not any(direction == "v" for *_, direction in system.dofs):
        yield Note("A bow has no effect: the system has no lateral motion.")
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
            yield Note(f"{shaft.name}: not computed, because {reason}")
            contents.findings.append((f"Limits of the bow of {shaft.name}: {reason}.", True))
            continue
        yield Table.of_result(found)
        first = found.deciding
        if first is not None and found.present > 0.0:
            sizes = f"{1e6 * found.present:.4g} µm of at most {1e6 * first.bow:.4g} µm"
            text = f"Bow of {shaft.name}: {sizes}, by the limit {first.limit} ({first.at})."
            contents.findings.append((text, found.margin < 0.0))
    yield Note(
        "The value of API 617 for the vibration of a shaft, 25.4 µm √(12000/n), is a reference at "
        "each bearing; whether the standard applies to this machine is for its user to decide."
    )


def motion(contents: Contents) -> Iterator[Block]:
    """Show orbits, spectra and mesh geometry at the operating speed."""
    run, what, steady = contents.motion
    speed = contents.need_operating()
    yield Note(f"Motion at {contents.text(speed)}: {what}.")
    if steady is not None:
        yield _floquet(contents, steady)
    yield Table.of_result(run)
    end = float(run.time[-1])
    times = (max(float(run.time[0]), end - SHOWN_REVOLUTIONS * contents.turn()), end)
    bodies = [names[0] for _, _, names in recorded_run(run, "run").data["points"] if names]
    lateral = any(direction == "v" for *_, direction in contents.system.dofs)
    if lateral and bodies:
        for first in range(0, len(bodies), _ORBITS):
            own = bodies[first : first + _ORBITS]
            yield picture(run.plot("orbits", own, times=times), f"Orbits: {', '.join(own)}.")
        size = {name: float(np.ptp(run.displacement(name), axis=0).max()) for name in bodies}
        largest = sorted(bodies, key=lambda name: -size[name])[:_SPECTRA]
        yield picture(
            run.plot("spectrum", [name for name in bodies if name in largest]),
            "Amplitude spectra of the places with the largest motion.",
        )
    elif bodies:
        yield picture(run.plot("twist", bodies[:_ORBITS], times=times), "Twist of gears and disks.")
    pairs = [(mesh.driver, mesh.driven) for mesh in contents.system.meshes]
    for first in range(0, len(pairs), 2):
        two = pairs[first : first + 2]
        names = ", ".join("–".join(pair) for pair in two)
        figure = run.plot("mesh", two, times=times)
        yield picture(figure, f"Force, deflection and stiffness: {names}.")
        figure = run.plot("geometry", two, times=times)
        yield picture(figure, f"Mesh geometry at the moving centres: {names}.")
    if not pairs:
        yield Note("There is no mesh geometry: the system has no gears in mesh.")
    places = [(bearing.shaft, bearing.position) for bearing in contents.system.bearings]
    for first in range(0, len(places) if lateral else 0, _BEARINGS):
        few = places[first : first + _BEARINGS]
        names = ", ".join(map(place_label, few))
        yield picture(run.plot("bearings", few, times=times), f"Bearing forces: {names}.")


def _floquet(contents: Contents, steady: SteadyState) -> Note:
    """Say whether small disturbances of the steady state decay."""
    if not contents.system.meshes:
        return Note(
            "Whether small disturbances of this motion decay follows from the eigenvalues in the "
            "section on stability: no teeth change the stiffness of the system."
        )
    if steady.method == "quasi-periodic":
        contents.findings.append(("The steady state is stable.", False))
        return Note("The steady state is stable: the motion ran in, so that disturbances decay.")
    try:
        kind = steady.instability()
    except GearbowError as error:
        return Note(f"Stability of the steady state: not computed, because {error}")
    largest = max(map(abs, steady.multipliers()), default=0.0)
    # A motion that decays slowly has a multiplier that rounds to 1.
    near = abs(largest - 1.0) < 1e-3
    sign = "−" if largest < 1.0 else "+"
    shown = f"1 {sign} {abs(largest - 1.0):.1e}" if near else f"{largest:.4g}"
    size = f"the largest is {shown}" if largest else f"all are below {SMALLEST_MULTIPLIER:g}"
    section = "a part of the motion" if math.isinf(steady.period) else "a period"
    text = f"Floquet multipliers over {section}, with the changing stiffness of the teeth: {size}"
    state = "stable" if kind is None else f"unstable ({kind})"
    contents.findings.append((f"The steady state is {state}.", kind is not None))
    return Note(f"The steady state is {state}. {text}.", kind is not None)


def accuracy(contents: Contents) -> Iterator[Block]:
    """Give elements, residuals and warnings."""
    system = contents.system
    for line in str(system.discretisation).splitlines()[len(system.shafts) :]:
        yield Note(f"{line[:1].upper()}{line[1:]}.")
    elements = system.discretisation.shafts.items()
    rows = [(name, " + ".join(map(str, each.numbers)), str(each.degree)) for name, each in elements]
    yield Table(
        "Elements",
        ("shaft", "elements of its segments", "degree"),
        rows,
        numeric=(False, False, True),
    )
    residuals: list[tuple[str, str]] = []
    measured: dict[str, tuple[str, Callable[[Any], float]]] = {
        "static": ("static equilibrium: unbalanced part of the load", lambda r: r.residual),
        "modes": ("modes: part of the forces, largest", lambda r: r.residuals.max()),
        "campbell": (
            "critical speeds and tooth resonances, largest",
            lambda r: max((one.residual for one in r.intersections), default=0.0),
        ),
        "synchronous": (
            "response to bow and unbalance: backward error, largest",
            lambda r: r.residuals.max(),
        ),
    }
    for name, (title, value) in measured.items():
        found = contents.finished(name)
        if found is not None:
            residuals.append((title, f"{float(value(found)):.1e}"))
    yield Table(
        "Residuals of the equations", ("result", "residual"), residuals, numeric=(False, True)
    )
    given = [("file", text) for text in system._notes]
    given += [("description", text) for text in system._model.warnings]
    every = [*given, *contents.warned]
    if every:
        yield Table("Warnings", ("section", "warning"), every, numeric=(False, False))
    else:
        yield Note("There were no warnings.")


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
    ("stability", "Stability", stability),
    ("response", "Response to unbalance and bow", response),
    ("bow", "Limits of the bow", bow),
    ("motion", "Motion at the operating speed", motion),
    ("accuracy", "Accuracy and warnings", accuracy),
)
