"""Unbalance placement and level 1 of the stability analysis of API 617, for a report.

API Standard 617 (2002) and API RP 684 (2005). The unbalance of the response analysis is twice
6350 W/N [g mm], with the mass W on the journals [kg] and the highest continuous speed N [1/min].
Level 1 raises a cross-coupled stiffness in the middle of the rotor until the first forward mode
loses its damping.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from gearbow._result import Column, in_micrometres
from gearbow._types import Array
from gearbow.analysis.protocol import variant
from gearbow.description.bow import largest_displacement
from gearbow.description.layout import ratios_by_shaft
from gearbow.description.loads import Bearing
from gearbow.description.places import place_label
from gearbow.report.page import Block, Table, note, picture, say
from gearbow.report.shared import Contents
from gearbow.results.modes import Modes
from gearbow.units.speed import PER_MINUTE, speed_factor

#: Unbalance of the response analysis: W/N times this [g mm/(kg min)].
_UNBALANCE = 2.0 * 6350.0
#: Displacement of a second plane from which it has half the unbalance, relative to the largest.
_SECOND_PLANE = 0.5
#: Share of the kinetic energy from which a mode belongs to a shaft.
_OWN_MODE = 0.5
#: Damping ratio above which a mode is no resonance.
_OVERDAMPED = 0.7
#: First stiffness of the search, relative to that of one mass, and largest number of its doublings.
_FIRST, _DOUBLINGS = 0.25, 20
#: Largest number of further steps, and decrement that is zero, relative to the first.
_SEARCH, _NEAR_ZERO = 12, 1e-2
#: Number of points of the curve of the decrement.
_CURVE = 7
#: Smallest logarithmic decrement of level 1, and smallest ratio Q₀/Q_A.
_DECREMENT, _RATIO = 0.1, 2.0


def unbalance(contents: Contents) -> Iterator[Block]:
    """Give the response to the unbalance of API 617 on each shaft."""
    speed, system = contents.need_operating(), contents.system
    bodies = [*system.gears, *system.disks]
    if not any(direction == "v" for *_, direction in system.dofs):
        yield note("Unbalance placement of API 617: the system has no lateral motion.")
        return
    planes: dict[str, complex] = {}
    rows: list[tuple[Any, ...]] = []
    first: dict[str, str] = {}
    weights = system.mass_properties().mass
    for (shaft, ratio), mass in zip(ratios_by_shaft(system).items(), weights, strict=True):
        own = [body.name for body in bodies if body.shaft == shaft]
        mode = _own_mode(contents.modes, shaft)
        if not own or mode is None:
            lacks = say("no mode of its own among {count}", count=len(contents.modes.whirl))
            if not own:
                lacks = say("no gear or disk as a plane")
            yield note(
                "Unbalance placement of API 617: {shaft} has {lacks}.",
                shaft=shaft,
                lacks=lacks,
            )
            continue
        turns = abs(ratio * speed) * speed_factor(PER_MINUTE)
        amount = 1e-6 * _UNBALANCE * mass / turns
        chosen = _planes(contents.modes, mode, own)
        planes |= {name: amount * share for name, share in chosen.items()}
        first[shaft] = next(iter(chosen))
        hertz, whirl = contents.modes.frequencies_hz[mode], contents.modes.whirl[mode]
        places = ", ".join(
            name if share.real > 0 else say("{name} (opposite)", name=name)
            for name, share in chosen.items()
        )
        rows.append((shaft, mass, turns, hertz, whirl, places, 1e6 * amount))
    if not rows:
        return
    names, masses, speeds, frequencies, whirls, at, amounts = zip(*rows, strict=True)
    yield Table.of(
        say("Unbalance of API 617, 2 · 6350 W/N, where the lowest mode of each shaft moves most"),
        [
            Column("shaft", names),
            Column("mass W", np.array(masses), "kg"),
            Column("speed N", np.array(speeds), PER_MINUTE, ".5g"),
            Column("mode", np.array(frequencies), "Hz", ".4g"),
            Column("whirl", whirls),
            Column("planes", at),
            Column("unbalance", np.array(amounts), "g mm"),
        ],
        remarks=[say("Two planes of opposite motion have half of it each. The bows are left out.")],
    )
    made = variant(
        contents.meshed,
        shafts=[replace(shaft, bow=None) for shaft in contents.meshed.shafts],
        **{
            kind: [
                replace(body, unbalance=planes.get(body.name, 0.0))
                for body in getattr(system, kind)
            ]
            for kind in ("gears", "disks")
        },
    )
    found = contents.response_of(made)
    for name, place in first.items():
        peaks = found._peaks(made._model, place, name, contents.options.operating)
        if len(peaks):
            title = say(
                "Unbalance of API 617 on {shaft}: peaks of {place}", shaft=name, place=place
            )
            yield Table.of_result(peaks, title)
        else:
            yield note(
                "Unbalance of API 617 on {shaft}: the response at {place} has no peak in this "
                "range.",
                shaft=name,
                place=place,
            )
    yield from _vibration(contents, made, list(first))


def _own_mode(modes: Modes, shaft: str) -> int | None:
    """Find the lowest lateral oscillation that belongs to a shaft."""
    shares = modes.energy_shares()
    lateral = sum(shares.get((shaft, direction), 0.0) for direction in "vw")
    is_own = (np.broadcast_to(lateral, modes.frequencies_hz.shape) >= _OWN_MODE) & (
        modes.frequencies_hz > 0.0
    )
    found = np.flatnonzero(is_own & (np.abs(modes.damping_ratios) < _OVERDAMPED))
    return int(found[0]) if found.size else None


def _planes(modes: Modes, mode: int, own: list[str]) -> dict[str, complex]:
    """Give the share of the unbalance on one body, or on two that move against each other."""
    sense = math.copysign(1.0, modes.speed)
    motion = {}
    for name in own:
        v, w = modes.displacement(name)[mode]
        motion[name] = v + 1j * sense * w
    largest = max(own, key=lambda name: abs(motion[name]))
    relative = {name: float((value / motion[largest]).real) for name, value in motion.items()}
    second = min(own, key=lambda name: relative[name])
    if relative[second] > -_SECOND_PLANE:
        return {largest: 1.0 + 0j}
    return {largest: 0.5 + 0j, second: -0.5 + 0j}


def _vibration(contents: Contents, made: Any, shafts: list[str]) -> Iterator[Block]:
    """Compare the vibration at the bearings with the limit of API 617."""
    operating = contents.options.operating
    assert operating is not None
    found = made.synchronous(
        np.linspace(*operating, 9) if operating[0] != operating[1] else [operating[1]]
    )
    ratios = ratios_by_shaft(made)
    places = [(b.shaft, b.position) for b in made.bearings if b.shaft in shafts]
    if not places:
        return
    largest = [2.0 * float(found._own(found.orbit(at), at).max()) for at in places]
    limits = [
        largest_displacement("API 617", ratios[shaft] * contents.speed) for shaft, _ in places
    ]
    within = ["yes" if size <= limit else "no" for size, limit in zip(largest, limits, strict=True)]
    yield Table.of(
        say("Vibration at the bearings with this unbalance, at the operating speed"),
        [
            Column("bearing", list(map(place_label, places))),
            Column("peak-to-peak", np.array(largest), "m", ".4g", in_micrometres()),
            Column("limit of API 617", np.array(limits), "m", ".4g", in_micrometres()),
            Column("within", within),
        ],
        remarks=[
            say(
                "25.4 µm √(12000/N), at most 25.4 µm; of the shaft itself, not relative to a "
                "support."
            )
        ],
    )


def level_1(contents: Contents) -> Iterator[Block]:
    """Find the cross-coupled stiffness at which the first forward mode loses its damping."""
    system, speed = contents.system, contents.need_operating()
    name = say("Stability level 1 of API 617")
    if len(system.shafts) > 1:
        yield note(
            "{name}: it is defined for one rotor, and this train has {count} shafts.",
            name=name,
            count=len(system.shafts),
        )
        return
    modes, (shaft,) = contents.modes, system.shafts
    forward = [
        i
        for i, whirl in enumerate(modes.whirl)
        if whirl == "forward"
        and modes.frequencies_hz[i] > 0.0
        and modes.damping_ratios[i] < _OVERDAMPED
    ]
    bodies = [*system.gears, *system.disks]
    if not forward or not bodies:
        lacks = say("no forward mode among {count}", count=len(modes.whirl))
        if not bodies:
            lacks = say("no disk or gear")
        yield note("{name}: the rotor has {lacks}.", name=name, lacks=lacks)
        return
    mode = forward[0]
    body = max(bodies, key=lambda body: float(np.abs(modes.displacement(body.name)[mode]).max()))

    def decrement(stiffness: float) -> float:
        cross = math.copysign(stiffness, speed)
        added = Bearing(shaft.name, body.position, stiffness=[[0.0, cross], [-cross, 0.0]])
        made = variant(contents.meshed, bearings=[*system.bearings, added])
        found = made.modes(speed, count=len(modes.whirl))
        nearest = min(
            (i for i in found._vibrations() if found.whirl[i] == "forward"),
            key=lambda i: abs(found.frequencies_hz[i] - modes.frequencies_hz[mode]),
            default=mode,
        )
        ratio = float(found.damping_ratios[nearest])
        return 2.0 * math.pi * ratio / math.sqrt(1.0 - ratio**2)

    first = decrement(0.0)
    if not first > 0.0:
        yield note(
            "{name}: the first forward mode is unstable without cross coupling.",
            warning=True,
            name=name,
        )
        return
    # A mass m on a shaft with the damping c loses it at the stiffness c ω, which is m ω² δ/π.
    mass = float(system.mass_properties().mass.sum())
    scale = mass * (2.0 * math.pi * float(modes.frequencies_hz[mode])) ** 2 * first / math.pi
    removing = _zero(decrement, first, scale)
    if removing is None:
        yield note(
            "{name}: a cross-coupled stiffness at {body} does not remove the damping.",
            name=name,
            body=body.name,
        )
        return
    # Unequal bearings keep the damping up to a stiffness at which it falls steeply.
    curve = np.unique([*np.linspace(0.0, 1.2, _CURVE) * removing, removing])
    values = np.array([first, *map(decrement, curve[1:])])
    limits = [float(_crossing(curve, values, level)) for level in (0.0, _DECREMENT)]
    yield picture(
        _figure(curve, values),
        say(
            "{name}: logarithmic decrement of the first forward mode over a cross-coupled "
            "stiffness at {body}.",
            name=name,
            body=body.name,
        ),
    )
    largest = min(limits[0] / _RATIO, limits[1])
    passed = say(
        "Level 1 is passed up to an anticipated cross coupling Q_A of {largest} N/m",
        largest=f"{largest:.3g}",
    )
    if not largest > 0.0:
        passed = say("Level 1 is not passed even without cross coupling")
    yield note(
        "{name}: the decrement is {first} without cross coupling and zero at Q₀ = {zero} N/m. "
        "{passed} (Q₀/Q_A ≥ 2, decrement ≥ 0.1). Q_A follows from power, diameters and "
        "densities of the stages, which a scene does not have; the criterion of the gas "
        "density is not evaluated.",
        warning=not largest > 0.0,
        name=name,
        first=f"{first:.3g}",
        zero=f"{limits[0]:.3g}",
        passed=passed,
    )


def _zero(decrement: Callable[[float], float], first: float, scale: float) -> float | None:
    """Find the smallest stiffness at which the decrement is zero; None for none."""
    low, at_low, high = 0.0, first, _FIRST * scale
    for _ in range(_DOUBLINGS):
        at_high = decrement(high)
        if at_high < 0.0:
            break
        low, at_low, high = high, at_high, 2.0 * high
    else:
        return None
    for _ in range(_SEARCH):
        # The secant, away from the ends, so that both of them move.
        part = min(max(at_low / (at_low - at_high), 0.1), 0.9)
        middle = low + part * (high - low)
        value = decrement(middle)
        if abs(value) < _NEAR_ZERO * first:
            return middle
        if value > 0.0:
            low, at_low = middle, value
        else:
            high, at_high = middle, value
    return low + at_low / (at_low - at_high) * (high - low)


def _crossing(x: Array, y: Array, level: float) -> float:
    """Find where a falling curve reaches a level."""
    below = np.flatnonzero(y <= level)
    if not below.size:
        return math.inf
    i = int(below[0])
    if i == 0:
        return 0.0
    return float(x[i - 1] + (level - y[i - 1]) * (x[i] - x[i - 1]) / (y[i] - y[i - 1]))


def _figure(stiffnesses: Array, decrements: Array) -> Any:
    """Draw the decrement over the cross-coupled stiffness."""
    from gearbow.plotting.style import panels  # noqa: PLC0415

    with panels(1, 3.6, columns=1) as (figure, (panel,)):
        panel.plot(1e-6 * stiffnesses, decrements, "o-", markersize=4.0)
        panel.axhline(0.0, color="black", linewidth=1.0)
        panel.axhline(_DECREMENT, color="0.4", linestyle="--", linewidth=1.0)
        panel.set(xlabel="cross-coupled stiffness [N/µm]", ylabel="logarithmic decrement")
    return figure
