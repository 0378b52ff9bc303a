"""Tables in CSV files, with the unit of each column in its heading."""

import csv
import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gearbow._convert import shown
from gearbow._files import reading
from gearbow._lookup import nearest
from gearbow._types import Array
from gearbow.errors import SceneError
from gearbow.units.fields import unit_of
from gearbow.units.parse import parsed

__all__ = ["Columns", "read_columns", "read_table"]

_NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*", re.ASCII)

#: Heading with a unit: "speed [rpm]" or "speed (rpm)".
_HEADING = re.compile(r"\s*([^\[(]+?)\s*(?:\[(.*)\]|\((.*)\))?\s*")


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of a file: numbers in SI units, names, units of the headings, and line numbers."""

    numbers: dict[str, Array]
    names: dict[str, list[str]]
    units: dict[str, str]
    lines: list[int]


def read_columns(
    path: str | os.PathLike[str],
    known: Mapping[str, str],
    hints: Mapping[str, str] | None = None,
) -> dict[str, Array]:
    """Read the columns of a CSV file in SI units."""
    return read_table(path, known, (), hints).numbers


def read_table(
    path: str | os.PathLike[str],
    known: Mapping[str, str],
    texts: Sequence[str],
    hints: Mapping[str, str] | None = None,
) -> Columns:
    """Read columns of numbers and of names from a CSV file."""
    with reading(path) as text:
        lines = text.splitlines()
    rows = [(i, line) for i, line in enumerate(lines, start=1) if line.strip()]
    rows = [(i, line) for i, line in rows if not line.lstrip().startswith("#")]
    if len(rows) < 2:
        raise SceneError(f"{path}: needs a line of headings and lines of numbers")
    separator = next((each for each in ";\t" if each in rows[0][1]), ",")
    head, *body = ((i, _cells(line, separator, f"{path}: line {i}")) for i, line in rows)
    fields = {**known, **dict.fromkeys(texts, "")}
    units = _headings(head[1], fields, hints or {}, f"{path}: line {head[0]}")
    found: dict[str, list[float]] = {name: [] for name in units if name in known}
    names: dict[str, list[str]] = {name: [] for name in units if name not in known}
    for i, cells in body:
        if len(cells) != len(units):
            raise SceneError(
                f"{path}: line {i}: must have {len(units)} {'entries' if names else 'numbers'}, as "
                f"the headings, got {len(cells)}"
            )
        for (name, unit), cell in zip(units.items(), cells, strict=True):
            if name in names:
                names[name].append(cell.strip())
                continue
            found[name].append(
                _number(cell, unit, known[name], f'{path}: line {i}, column "{name}"')
            )
    numbers = {name: np.array(values) for name, values in found.items()}
    return Columns(numbers, names, units, [i for i, _ in body])


def _cells(line: str, separator: str, where: str) -> list[str]:
    """Split a line into its cells."""
    try:
        return next(csv.reader([line], delimiter=separator))
    except csv.Error as error:
        raise SceneError(f"{where}: is no line of a CSV file: {error}") from None


def _headings(
    cells: Sequence[str], known: Mapping[str, str], hints: Mapping[str, str], where: str
) -> dict[str, str]:
    """Give the names of the columns, and the unit of each one."""
    units: dict[str, str] = {}
    for cell in cells:
        heading = _HEADING.fullmatch(cell)
        name = "" if heading is None else heading[1].lower().replace(" ", "_")
        if heading is None or name not in known:
            hint = hints.get(name) or _of_unit(cell.strip(), known) or _behind(cell, known)
            hint = hint or nearest(name, known)
            raise SceneError(
                f"{where}: {cell.strip()!r} is not a column; there are {', '.join(known)}{hint}"
            )
        if name in units:
            raise SceneError(f"{where}: the column {name!r} occurs twice")
        try:
            units[name] = heading[2] or heading[3] or ""
            parsed(f"1 {units[name] or unit_of(known[name])}", known[name])
        except SceneError as error:
            raise SceneError(f'{where}, column "{name}": {str(error).partition(": ")[2]}') from None
    return units


def _of_unit(cell: str, known: Mapping[str, str]) -> str:
    """Give the end of a message for a heading that is a unit, with the column that it fits."""
    for name, field in known.items():
        try:
            parsed(f"1 {cell}", field)
        except SceneError:
            continue
        return f'; a unit stands in brackets behind its column, for example "{name} [{cell}]"'
    return ""


def _behind(cell: str, known: Mapping[str, str]) -> str:
    """Give the end of a message for a column whose unit stands in no or in wrong brackets."""
    found = re.fullmatch(r"\s*(\w+)\s*[^\w\s]?\s*([^\[\](){}]+?)\s*\W?\s*", cell)
    if found is None or found[1].lower() not in known:
        return ""
    return f'; write the unit in brackets: "{found[1].lower()} [{found[2]}]"'


def _number(cell: str, unit: str, field: str, where: str) -> float:
    """Read a number with the unit of its column; the unit is empty in SI units."""
    # Python also reads digits with underscores.
    if not _NUMBER.fullmatch(cell):
        raise SceneError(f"{where}: must be a number with a decimal point, got {shown(cell)}")
    # The text, not the number: the conversion of a text is correctly rounded.
    found = parsed(f"{cell} {unit}", field) if unit else float(cell)
    if not math.isfinite(found):
        raise SceneError(f"{where}: must be below 1.8e308 in SI units, got {shown(cell)}")
    return found
