"""Resonances near the operating speed: modes at the orders of shafts and teeth, for a report."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from gearbow._result import Column, in_percent
from gearbow.errors import GearbowError
from gearbow.report.page import Block, Table, note
from gearbow.report.shared import ABOVE, BELOW, UNDAMPED, Contents, margins, resonances_of
from gearbow.report.texts import say, word
from gearbow.results.campbell import Intersection


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
