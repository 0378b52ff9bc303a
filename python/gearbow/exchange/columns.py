"""Tables in files, with the unit of each column in its heading: CSV, Excel and MATLAB."""

import csv
import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np

from gearbow._convert import shown
from gearbow._extras import extra
from gearbow._files import as_path, parsing, reading
from gearbow._lookup import nearest
from gearbow._types import Array
from gearbow.errors import SceneError
from gearbow.exchange.mat import read_vectors
from gearbow.units.fields import unit_of
from gearbow.units.parse import parsed

__all__ = ["Columns", "read_columns", "read_table"]

_NUMBER = re.compile(r"\s*[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?\s*", re.ASCII)

#: Heading with a unit: "speed [rpm]" or "speed (rpm)".
_HEADING = re.compile(r"\s*([^\[(]+?)\s*(?:\[(.*)\]|\((.*)\))?\s*")
#: Most characters of a heading or number; some expressions for headings take the square of it.
_LONGEST_CELL = 400


@dataclass(frozen=True)
class _TableLine:
    """The texts of a line of a table, and where it is: "line 3"."""

    where: str
    cells: Sequence[str]


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of a table: numbers in SI units, names, units of the headings, places of lines."""

    numbers: dict[str, Array]
    names: dict[str, list[str]]
    units: dict[str, str]
    lines: list[str]


def read_columns(
    path: str | os.PathLike[str],
    known: Mapping[str, str],
    hints: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> dict[str, Array]:
    """Read the columns of a table, whose fields `known` gives, in SI units."""
    return read_table(path, known, (), hints, units).numbers


def read_table(
    path: str | os.PathLike[str],
    known: Mapping[str, str],
    texts: Sequence[str],
    hints: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> Columns:
    """Read columns of numbers, as `read_columns`, and of names."""
    readers = {".xlsx": _from_excel, ".mat": _from_matlab}
    path = as_path(path, "path")
    lines = readers.get(path.suffix.lower(), _from_text)(path)
    if len(lines) < 2:
        raise SceneError(f"{path}: needs a line of headings and lines of numbers")
    head, *body = lines
    fields = {**known, **dict.fromkeys(texts, "")}
    found_units = _headings(head.cells, fields, hints or {}, units or {}, f"{path}: {head.where}")
    found: dict[str, list[float]] = {name: [] for name in found_units if name in known}
    names: dict[str, list[str]] = {name: [] for name in found_units if name not in known}
    for line in body:
        if len(line.cells) != len(found_units):
            raise SceneError(
                f"{path}: {line.where}: must have {len(found_units)} "
                f"{'entries' if names else 'numbers'}, as the headings, got {len(line.cells)}"
            )
        for (name, unit), cell in zip(found_units.items(), line.cells, strict=True):
            if name in names:
                names[name].append(cell.strip())
                continue
            where = f'{path}: {line.where}, column "{name}"'
            found[name].append(_number(cell, unit, known[name], where))
    numbers = {name: np.array(values) for name, values in found.items()}
    return Columns(numbers, names, found_units, [line.where for line in body])


def _from_text(path: Path) -> list[_TableLine]:
    """Read the lines of a text file, without comments."""
    with reading(path, "a table") as text:
        lines = text.splitlines()
    rows = [(i, line) for i, line in enumerate(lines, start=1) if line.strip()]
    rows = [(i, line) for i, line in rows if not line.lstrip().startswith("#")]
    separator = next((each for each in ";\t" if rows and each in rows[0][1]), ",")
    return [
        _TableLine(f"line {i}", _cells(line, separator, f"{path}: line {i}")) for i, line in rows
    ]


def _from_excel(path: Path) -> list[_TableLine]:
    """Read the rows of the first sheet, without comments."""
    with extra("dataframe"):
        import pandas as pd  # noqa: PLC0415

        import_module("openpyxl")  # pandas would report it in its own words
    with path.open("rb") as file, parsing(path, "an Excel file (.xlsx)"):
        sheet = pd.read_excel(file, header=None, dtype=object)
    lines = []
    for i, row in enumerate(sheet.itertuples(index=False), start=1):
        cells = ["" if pd.isna(cell) else str(cell) for cell in row]
        if any(cells) and not cells[0].startswith("#"):
            lines.append(_TableLine(f"row {i}", cells))
    return lines


def _from_matlab(path: Path) -> list[_TableLine]:
    """Read the vectors of a MATLAB file, whose names are the headings."""
    vectors = read_vectors(path)
    sizes = {value.size for value in vectors.values()}
    if len(sizes) > 1:
        raise SceneError(f"{path}: its vectors must have one length, got {sorted(sizes)}")
    rows = zip(*(value.tolist() for value in vectors.values()), strict=True)
    lines = [
        _TableLine(f"value {i}", [repr(each) for each in row])
        for i, row in enumerate(rows, start=1)
    ]
    return [_TableLine("names", list(vectors)), *lines]


def _cells(line: str, separator: str, where: str) -> list[str]:
    """Split a line into its cells."""
    try:
        return next(csv.reader([line], delimiter=separator))
    except csv.Error as error:
        raise SceneError(f"{where}: is no line of a CSV file: {error}") from None


def _headings(
    cells: Sequence[str],
    known: Mapping[str, str],
    hints: Mapping[str, str],
    given: Mapping[str, str],
    where: str,
) -> dict[str, str]:
    """Give the names of the columns, and the unit of each one."""
    units: dict[str, str] = {}
    for cell in cells:
        if len(cell) > _LONGEST_CELL:
            raise SceneError(f"{where}: {shown(cell)} is too long for a heading")
        heading = _HEADING.fullmatch(cell)
        name = "" if heading is None else heading[1].lower().replace(" ", "_")
        name = next((n for n in known if n.replace("_", "") == name.replace("_", "")), name)
        if heading is None or name not in known:
            hint = hints.get(name) or _of_unit(cell.strip(), known) or _behind(cell, known)
            hint = hint or nearest(name, known)
            raise SceneError(
                f"{where}: {cell.strip()!r} is not a column; there are {', '.join(known)}{hint}"
            )
        if name in units:
            raise SceneError(f"{where}: the column {name!r} occurs twice")
        try:
            units[name] = heading[2] or heading[3] or given.get(name, "")
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
    if len(cell) > _LONGEST_CELL or not _NUMBER.fullmatch(cell):
        raise SceneError(f"{where}: must be a number with a decimal point, got {shown(cell)}")
    # The text, not the number: the conversion of a text is correctly rounded.
    found = parsed(f"{cell} {unit}", field) if unit else float(cell)
    if not math.isfinite(found):
        raise SceneError(f"{where}: must be below 1.8e308 in SI units, got {shown(cell)}")
    return found
