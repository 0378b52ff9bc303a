"""Tables of the bow study: CSV files with all results, and the Markdown layout."""

import csv
from collections.abc import Iterable, Sequence
from io import TextIOWrapper
from pathlib import Path

import numpy as np

from gearbow._files import replacing
from gearbow._lookup import nodal
from gearbow.study.case import Case, system
from gearbow.study.measure import UNITS
from gearbow.study.runs import Results
from gearbow.study.settings import Settings

__all__ = ["markdown", "write"]

_CASE = (
    "layout",
    "torque [N m]",
    "speed [rad/s]",
    "bow / radius",
    "bow on",
    "bow phase, second shaft [rad]",
    "bow phase, third shaft [rad]",
    "geometry",
    "accuracy",
)

_MODES = ("layout", "mode", "frequency [Hz]", "damping ratio", "whirl", "largest motion")
_SHAPES = ("layout", "mode", "shaft", "position [m]", "direction", "real", "imaginary")


def write(settings: Settings, results: Results, folder: Path) -> None:
    """Write the CSV files of a study."""
    numbers = ("mean", "smallest", "largest", "peak_to_peak")
    rows = (
        (
            *_row(case),
            of,
            quantity,
            UNITS[quantity],
            *(repr(getattr(found, number)(of, quantity)) for number in numbers),
        )
        for case, found in results.items()
        for of, quantity in found.signals
    )
    titles = ("gear or mesh", "quantity", "unit", "mean", "smallest", "largest", "peak to peak")
    _write(folder / "cases.csv", (*_CASE, *titles), rows)
    events = ((*_row(case), event) for case, found in results.items() for event in found.events)
    _write(folder / "events.csv", (*_CASE, "event"), events)
    frequencies: list[tuple[object, ...]] = []
    shapes: list[tuple[object, ...]] = []
    for layout in settings.layouts:
        modes = system(settings, Case(layout, 0.0, 1.0)).modes(count=settings.modes)
        for mode, name in enumerate(modes.names()):
            frequency, damping = modes.frequencies_hz[mode], modes.damping_ratios[mode]
            frequencies.append(
                (layout, mode + 1, f"{frequency:.6g}", f"{damping:.6g}", modes.whirl[mode], name)
            )
            # The scale and the phase of a mode shape are arbitrary: the largest entry becomes 1.
            shape = modes.shapes[mode]
            shape = shape / shape[np.argmax(np.abs(shape))]
            for (shaft, x, direction), entry in zip(nodal(modes.dofs), shape, strict=False):
                parts = (f"{entry.real:.6g}", f"{entry.imag:.6g}")
                shapes.append((layout, mode + 1, shaft, f"{x:g}", direction, *parts))
    _write(folder / "modes.csv", _MODES, frequencies)
    _write(folder / "mode_shapes.csv", _SHAPES, shapes)


def markdown(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [titles, ["---"] * len(titles), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _row(case: Case) -> tuple[object, ...]:
    return (
        case.layout,
        f"{case.torque:g}",
        f"{case.speed:g}",
        f"{case.bow:g}",
        case.where,
        *(f"{phase:.6g}" for phase in case.phases),
        case.geometry,
        case.accuracy,
    )


def _write(path: Path, titles: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with replacing(path) as file:
        text = TextIOWrapper(file, encoding="utf-8", newline="")
        table = csv.writer(text, lineterminator="\n")
        table.writerow(titles)
        table.writerows(rows)
        text.flush()
        text.detach()  # keeps the underlying file open
