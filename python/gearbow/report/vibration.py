"""Accelerations at the sensors of housings, or of gears and disks, for a report."""

import warnings
from collections.abc import Iterator

import numpy as np

from gearbow._result import ROUND_OFF, Column
from gearbow.errors import AccuracyWarning, GearbowError
from gearbow.report.page import Block, Table
from gearbow.report.shared import Contents
from gearbow.report.texts import say, word
from gearbow.results.response import Response

#: Number of gears and disks with the largest accelerations that stand for sensors.
_BODIES = 3


def vibration(contents: Contents) -> Iterator[Block]:
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
    table = Table.of(title, columns, remarks)
    contents.find(table)
    yield table


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
