"""Tables in files, with the unit of each column in its heading or below it: CSV, Excel, MATLAB.

Of MATLAB, files of versions 4 to 7 with vectors of numbers. `scipy.io.loadmat` ends the process for
some damaged files. The reader here checks each size before it takes the bytes.
"""

import csv
import math
import os
import re
import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gearbow._convert import nearest, shown
from gearbow._extras import extra
from gearbow._files import as_path, parsing
from gearbow._types import Array
from gearbow.errors import SceneError
from gearbow.units.fields import is_frequency, unit_of
from gearbow.units.parse import fits, parsed

#: Field of amplitudes of vibration, which are peak, peak-to-peak or RMS values.
VIBRATION = "measured.amplitude"
#: What multiplies a value of a sinusoidal vibration to give its amplitude, from zero to peak.
DETECTIONS = {"peak": 1.0, "peak-to-peak": 0.5, "rms": math.sqrt(2.0)}
#: How headings say so, in the order of `DETECTIONS`.
_DETECTION = re.compile(
    r"(?<![A-Za-z0-9-])(?:((?:(?:0|zero)(?:-to)?-)(?:p|pk|peak)|pk|peak)|(pp|p-p|pk-pk|peak(?:-to)?-peak)"
    r"|(rms))(?![A-Za-z0-9-])",
    re.IGNORECASE,
)
#: Endings of tables; a text file may have none.
ENDINGS = (".csv", ".txt", ".tsv", ".dat", ".asc", ".xlsx", ".xlsm", ".mat")
#: Bytes that other encodings than Windows-1252 use for letters: those of DOS and Mac, and UTF-8.
_AMBIGUOUS = re.compile(rb"[\x80-\x9f]|[\xc2-\xf4][\x80-\xbf]")
_NUMBER = re.compile(r"\s*[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?\s*", re.ASCII)
#: A number whose commas may separate thousands.
_THOUSANDS = re.compile(r"\s*[-+]?[1-9]\d{0,2}(,\d{3})+\s*", re.ASCII)
#: A comment; errors of Excel begin with the same sign.
_COMMENT = re.compile(r"\s*#(?!N/A|DIV/0!|REF!|VALUE!|NUM!|NAME\?|NULL!)")
#: Heading with a unit: "phase [deg]" or "phase (deg)".
_HEADING = re.compile(r"\s*([^\[(]+?)\s*(?:\[(.*)\]|\((.*)\))?\s*")
#: What separates the words of a name.
_SPACE = re.compile(r"[\s_-]+")
#: What stands in a row of units below a column without one.
_NO_UNIT = ("", "-", "–", "—")

#: Most characters of a heading or number; some expressions for headings take the square of it.
_LONGEST_CELL = 400


@dataclass(frozen=True)
class NamedColumns:
    """Columns that name a part of the user's, such as "pinion y re" or "A amplitude"."""

    #: Its two groups are the name and the quantity.
    pattern: re.Pattern[str]
    #: One field for each quantity, or several, of which the unit chooses one.
    fields: Mapping[str, tuple[str, ...]]
    example: str


@dataclass(frozen=True)
class _Line:
    """The texts of a line of a table, and where it is: "line 3"."""

    where: str
    cells: Sequence[str]


@dataclass(frozen=True)
class _Heading:
    """A column: its name, the fields of which its unit chooses one, and what its heading says."""

    name: str
    fields: tuple[str, ...]
    unit: str
    detection: str | None
    where: str

    @property
    def is_text(self) -> bool:
        """Whether the column has names instead of numbers."""
        return self.fields == ("",)


@dataclass(frozen=True, eq=False)
class Table:
    """Columns by name: numbers in SI units, texts; fields and units as the headings have them."""

    path: Path
    lines: Sequence[str]
    numbers: Mapping[str, Array]
    texts: Mapping[str, Sequence[str]]
    fields: Mapping[str, str]
    units: Mapping[str, str]

    def where(self, index: int, name: str) -> str:
        """Give the beginning of the error of a cell."""
        return f'{self.path}: {self.lines[index]}, column "{name}"'


def read_table(
    path: str | os.PathLike[str],
    columns: Mapping[str, str],
    *,
    named: NamedColumns | None = None,
    hints: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    detection: str | None = None,
) -> Table:
    """Read a table whose columns have the given fields; an empty field is for names."""
    # Units and the detection are for headings without them, hints end messages for unknown ones.
    path = as_path(path, "path")
    lines, separator = _lines(path)
    head, *body = _without_empty_columns(lines) or [_Line("", ())]
    found: list[_Heading] = []
    for cell in head.cells:
        one = _heading(cell, columns, named, hints or {}, f"{path}: {head.where}")
        if any(one.name == other.name for other in found):
            raise SceneError(f"{path}: {head.where}: the column {one.name!r} occurs twice")
        found.append(one)
    for line in body:
        if len(line.cells) != len(found):
            kind = "entries" if any(one.is_text for one in found) else "numbers"
            raise SceneError(
                f"{path}: {line.where}: must have {len(found)} {kind}, as the headings, got "
                f"{len(line.cells)}"
            )
    if body and _is_row_of_units(body[0], found):
        below, *body = body
        pairs = zip(found, below.cells, strict=True)
        found = [_with_unit(one, cell, f"{path}: {below.where}") for one, cell in pairs]
    if not body:
        raise SceneError(f"{path}: needs a line of headings and lines of numbers")
    found = [replace(one, unit=one.unit or (units or {}).get(one.name, "")) for one in found]
    rows = [line.cells for line in body]
    columns_of = {one: [cells[i] for cells in rows] for i, one in enumerate(found)}
    texts = {one.name: [c.strip() for c in own] for one, own in columns_of.items() if one.is_text}
    cells = {one: own for one, own in columns_of.items() if not one.is_text}
    table = Table(
        path, [line.where for line in body], {}, texts, {}, {o.name: o.unit for o in found}
    )
    commas = _has_decimal_commas([cell for own in cells.values() for cell in own], separator)
    numbers, fields = {}, {}
    for one, own in cells.items():
        name, field = one.name, _field(one)
        scale = DETECTIONS[_detection(one, detection)] if field == VIBRATION else 1.0
        unit = one.unit if one.unit and parsed(f"1 {one.unit}", field) != 1.0 else ""
        values = [
            _number(cell, unit, field, table.where(i, name), commas=commas)
            for i, cell in enumerate(own)
        ]
        numbers[name], fields[name] = scale * np.array(values), field
    return replace(table, numbers=numbers, fields=fields)


def _lines(path: Path) -> tuple[list[_Line], str]:
    """Read the lines of a table without comments, and the separator of a text file."""
    ending = path.suffix.lower()
    if ending in (".xlsx", ".xlsm"):
        return _from_excel(path), ""
    if ending == ".mat":
        return _from_matlab(path), ""
    if ending in ("", *ENDINGS):
        return _from_text(path)
    kind = "an Excel file of before 2007" if ending == ".xls" else "no table that gearbow reads"
    raise SceneError(f"{path}: is {kind}; save it as .xlsx or .csv")


def _decoded(path: Path) -> str:
    """Read a text in UTF-8, UTF-16 or, where no other encoding is likely, Windows-1252."""
    data = path.read_bytes()
    encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    with parsing(path, "a table"):
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError as error:
            if encoding == "utf-16" or _AMBIGUOUS.search(data):
                line = data.count(b"\n", 0, error.start) + 1
                raise SceneError(
                    f"{path}: line {line}: byte {data[error.start]:#04x} is neither UTF-8, UTF-16 "
                    'nor clearly Windows-1252; save it as UTF-8 (in Excel: "CSV UTF-8")'
                ) from None
            text = data.decode("cp1252")
    if "\0" in text:
        raise SceneError(f"{path}: is no text file; a workbook of Excel must end with .xlsx")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _from_text(path: Path) -> tuple[list[_Line], str]:
    """Read the lines of a text file, and their separator; a space stands for any white space."""
    lines = enumerate(_decoded(path).split("\n"), start=1)
    rows = [(i, line) for i, line in lines if line.strip() and not _COMMENT.match(line)]
    separator = next((each for each in ";\t," if rows and each in rows[0][1]), " ")
    places = ((f"line {i}", line) for i, line in rows)
    return [_Line(at, _cells(line, separator, f"{path}: {at}")) for at, line in places], separator


def _cells(line: str, separator: str, where: str) -> list[str]:
    """Split a line into its cells."""
    if separator == " ":  # a unit in brackets belongs to the heading before it
        return re.findall(r"[^\s\[(]+(?:\s*\[[^\]]*\]|\s*\([^)]*\))?|[\[(]\S*", line)
    try:
        return next(csv.reader([line], delimiter=separator))
    except csv.Error as error:
        raise SceneError(f"{where}: is no line of a CSV file: {error}") from None


def _from_excel(path: Path) -> list[_Line]:
    """Read the rows of the first sheet."""
    with extra("dataframe"):
        import pandas as pd  # noqa: PLC0415

        import_module("openpyxl")  # pandas would report it in its own words
    with path.open("rb") as file, parsing(path, "an Excel file (.xlsx)"):
        sheet = pd.read_excel(file, header=None, dtype=object)
    lines = []
    for i, row in enumerate(sheet.itertuples(index=False), start=1):
        cells = ["" if pd.isna(cell) else str(cell) for cell in row]
        if any(cells) and not _COMMENT.match(cells[0]):
            lines.append(_Line(f"row {i}", cells))
    return lines


def _from_matlab(path: Path) -> list[_Line]:
    """Read the vectors of a MATLAB file, whose names are the headings."""
    vectors = read_vectors(path)
    sizes = {value.size for value in vectors.values()}
    if len(sizes) > 1:
        raise SceneError(f"{path}: its vectors must have one length, got {sorted(sizes)}")
    rows = zip(*(value.tolist() for value in vectors.values()), strict=True)
    lines = [_Line(f"value {i}", [repr(each) for each in row]) for i, row in enumerate(rows, 1)]
    return [_Line("names", list(vectors)), *lines]


def _without_empty_columns(lines: list[_Line]) -> list[_Line]:
    """Remove columns at the end without a heading and without numbers, as of Excel."""
    full = width = len(lines[0].cells) if lines else 0
    while width and not any("".join(line.cells[width - 1 : width]).strip() for line in lines):
        width -= 1
    return [
        replace(line, cells=line.cells[:width]) if len(line.cells) == full else line
        for line in lines
    ]


def _heading(
    cell: str,
    columns: Mapping[str, str],
    named: NamedColumns | None,
    hints: Mapping[str, str],
    where: str,
) -> _Heading:
    if len(cell) > _LONGEST_CELL:
        raise SceneError(f"{where}: {shown(cell)} is too long for a heading")
    words: set[str] = set()
    text = cell
    if VIBRATION in columns.values():
        words = {
            name
            for word in _DETECTION.finditer(cell)
            for name, found in zip(DETECTIONS, word.groups(), strict=True)
            if found
        }
        text = _DETECTION.sub("", cell)
    found = _HEADING.fullmatch(text)
    given = "" if found is None else found[1].strip(" _")
    name = _SPACE.sub("_", given.lower())
    name = next((n for n in columns if n.replace("_", "") == name.replace("_", "")), name)
    match = named and name not in columns and named.pattern.fullmatch(given)
    if found is None or not (name in columns or match):
        hint = hints.get(name) or _of_unit(cell.strip(), columns) or _behind(cell, columns)
        hint = hint or nearest(name, columns)
        known = f"there are {', '.join(columns)}"
        if named:
            known = f'no heading such as "{named.example}", and not one of {", ".join(columns)}'
        raise SceneError(
            f"{where}: {cell.strip()!r} is {'' if named else 'not a column; '}{known}{hint}"
        )
    fields: tuple[str, ...] = (columns.get(name, ""),)
    if named and match:
        wanted = _SPACE.sub("", match[2].lower())
        quantity = next(each for each in named.fields if _SPACE.sub("", each) == wanted)
        name, fields = f"{match[1]} {quantity}", named.fields[quantity]
    if len(words) > 1 or (words and VIBRATION not in fields):
        raise SceneError(
            f'{where}, column "{name}": one of peak, peak-to-peak and RMS is for an amplitude, got '
            f"{cell.strip()!r}"
        )
    unit = (found[2] or found[3] or "").strip(" _,")
    return _Heading(name, fields, unit, next(iter(words), None), f'{where}, column "{name}"')


def _is_row_of_units(line: _Line, headings: Sequence[_Heading]) -> bool:
    """Tell whether a line has units below columns of numbers, and nothing below names."""
    given = [(one.is_text, cell.strip()) for one, cell in zip(headings, line.cells, strict=True)]
    units = [cell for is_text, cell in given if not is_text and cell not in _NO_UNIT]
    is_bare = all(cell in _NO_UNIT for is_text, cell in given if is_text)
    return bool(units) and is_bare and not any(_NUMBER.match(unit) for unit in units)


def _with_unit(heading: _Heading, cell: str, where: str) -> _Heading:
    """Give a heading with the unit below it."""
    where = f'{where}, column "{heading.name}"'
    unit = re.sub(r"^[\[(](.*)[\])]$", r"\1", cell.strip())
    if unit in _NO_UNIT:
        return heading
    below = _heading(f"x [{unit}]", {"x": heading.fields[0]}, None, {}, where)
    for old, new in ((heading.unit, below.unit), (heading.detection, below.detection)):
        if old and new and old != new:
            raise SceneError(f"{where}: has {old} in its heading and {new} below it")
    return replace(
        heading,
        unit=below.unit or heading.unit,
        detection=below.detection or heading.detection,
        where=where,
    )


def _field(heading: _Heading) -> str:
    """Choose the field of a column by its unit, and check the unit."""
    fields, unit = heading.fields, heading.unit
    wanted = " or ".join(dict.fromkeys(str(unit_of(field)) for field in fields))
    try:
        if not unit and (len(fields) > 1 or is_frequency(fields[0])):
            raise SceneError(f"x: needs its unit in brackets, {wanted}, or Hz of a frequency")
        for field in fields:
            if not unit or fits(unit, field):
                return field
        raise SceneError(f"x: must have a unit that converts to {wanted}, got {unit!r}")
    except SceneError as error:
        raise SceneError(f"{heading.where}: {str(error).partition(': ')[2]}") from None


def _detection(heading: _Heading, given: str | None) -> str:
    """Say what the amplitudes of a column are; zero to peak if nothing says it."""
    if given and heading.detection and given != heading.detection:
        raise SceneError(
            f"{heading.where}: its heading says {heading.detection}, the argument detection {given}"
        )
    return heading.detection or given or "peak"


def _of_unit(cell: str, columns: Mapping[str, str]) -> str:
    """Give the end of a message for a heading that is a unit, with the column that it fits."""
    for name, field in columns.items():
        try:
            parsed(f"1 {cell}", field)
        except SceneError:
            continue
        return f'; a unit stands in brackets behind its column, for example "{name} [{cell}]"'
    return ""


def _behind(cell: str, columns: Mapping[str, str]) -> str:
    """Give the end of a message for a column whose unit stands in no or in wrong brackets."""
    found = re.fullmatch(r"\s*(\w+)\s*[^\w\s]?\s*([^\[\](){}]+?)\s*\W?\s*", cell)
    if found is None or found[1].lower() not in columns:
        return ""
    return f'; write the unit in brackets: "{found[1].lower()} [{found[2]}]"'


def _has_decimal_commas(cells: Sequence[str], separator: str) -> bool:
    """Tell whether all numbers of a table have decimal commas, not commas between thousands."""
    commas = [cell for cell in cells if "," in cell]
    if not commas or separator == "," or any("." in cell for cell in cells):
        return False
    # Only programs with decimal commas separate columns by semicolons.
    return separator == ";" or not all(_THOUSANDS.fullmatch(cell) for cell in commas)


def _number(cell: str, unit: str, field: str, where: str, *, commas: bool) -> float:
    """Read a number with the unit of its column; the unit is empty in SI units."""
    plain = cell.replace(",", ".", 1) if commas and "." not in cell else cell
    # Python also reads digits with underscores, "nan" and "inf".
    if len(cell) > _LONGEST_CELL or not _NUMBER.fullmatch(plain):
        wanted = "comma" if commas else "point"
        raise SceneError(f"{where}: must be a number with a decimal {wanted}, got {shown(cell)}")
    # The text, not the number: the conversion of a text is correctly rounded.
    found = parsed(f"{plain} {unit}", field) if unit else float(plain)
    if not math.isfinite(found):
        raise SceneError(f"{where}: must be below 1.8e308 in SI units, got {shown(cell)}")
    return found


#: Largest content of a compressed array [bytes].
_MAX_SIZE = 100_000_000
#: Types of data elements, and the two that contain other elements.
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8"}
_TYPES |= {12: "i8", 13: "u8"}
_MATRIX, _COMPRESSED = 14, 15
#: Classes of sparse matrices, and of arrays: double, single and whole numbers of 8 to 64 bits.
_SPARSE, _NUMERIC = 5, range(6, 16)
_COMPLEX = 0x0800
#: Types of numbers in version 4.
_TYPES_4 = ("f8", "f4", "i4", "i2", "u2", "u1")
#: Name, shape and numbers of a variable; the numbers are None unless they are real.
Variable: TypeAlias = "tuple[str, tuple[int, ...], Array | Sparse | None]"


@dataclass(frozen=True, eq=False)
class Sparse:
    """A sparse matrix of MATLAB: its numbers by columns, their rows, and where columns start."""

    rows: NDArray[np.int64]
    starts: NDArray[np.int64]
    numbers: Array


def read_vectors(path: Path) -> dict[str, Array]:
    """Read the variables of a file, each of which must be a vector of numbers."""
    vectors = {}
    for name, shape, values in read_variables(path):
        if values is None or isinstance(values, Sparse):
            raise SceneError(f"{path}: {name}: must be a vector of numbers")
        if len(shape) > 2 or min(shape, default=1) != 1:
            raise SceneError(f"{path}: {name}: must be a vector, has the shape {shape}")
        vectors[name] = values
    return vectors


def read_variables(path: Path) -> list[Variable]:
    """Read name, shape and numbers of each variable; the numbers are None unless they are real."""
    data = path.read_bytes()
    with parsing(path, "a MATLAB file of a version before 7.3"):
        if data[:8] == b"\x89HDF\r\n\x1a\n" or data[:10] == b"MATLAB 7.3":
            raise ValueError("save it with -v7")
        order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
        return list(_version_4(data) if order is None else _version_5(data, order))


def _version_5(data: bytes, order: str) -> Iterator[Variable]:
    """Give the variables of a file of version 5 to 7."""
    at = 128
    while at < len(data):
        kind, content, at = _element(data, at, order)
        if kind == _COMPRESSED:
            stream = zlib.decompressobj()
            unpacked = stream.decompress(content, _MAX_SIZE)
            if not stream.eof:
                raise ValueError(f"a compressed array has no end, or over {_MAX_SIZE} bytes")
            kind, content, _ = _element(unpacked, 0, order)
        if kind != _MATRIX:
            raise ValueError(f"an element of type {kind} is no array")
        yield from _array(content, order)


def _array(content: bytes, order: str) -> Iterator[Variable]:
    """Give the variable of an array; what has no name belongs to MATLAB."""
    _, flags, at = _element(content, 0, order)
    (what,) = struct.unpack_from(f"{order}I", flags)
    _, sizes, at = _element(content, at, order)
    shape = tuple(np.frombuffer(sizes, f"{order}i4").tolist())
    _, letters, at = _element(content, at, order)
    name = letters.decode("ascii")
    if what & 0xFF not in (_SPARSE, *_NUMERIC) or what & _COMPLEX:
        if name:
            yield name, shape, None
        return
    found = []
    for _ in range(3 if what & 0xFF == _SPARSE else 1):
        kind, numbers, at = _element(content, at, order)
        found.append(np.frombuffer(numbers, f"{order}{_TYPES[kind]}"))
    if what & 0xFF == _SPARSE:
        rows, starts, values = found
        count = int(starts[-1])  # MATLAB reserves places behind the numbers
        own = rows[:count].astype(np.int64), starts.astype(np.int64)
        yield name, shape, Sparse(*own, values[:count].astype(np.float64))
    else:
        yield name, shape, _numbers(found[0], shape, name)


def _element(data: bytes, at: int, order: str) -> tuple[int, bytes, int]:
    """Give type and content of the element at a place, and the place of the next one."""
    kind, size = struct.unpack_from(f"{order}II", data, at)
    begin, step = at + 8, -(-size // 8) * 8
    if kind >> 16:  # at most four bytes, in the place of the size
        kind, size, begin, step = kind & 0xFFFF, kind >> 16, at + 4, 4
        if size > 4:
            raise ValueError(f"a short element has {size} bytes")
    if kind == _COMPRESSED:
        step = size
    if begin + size > len(data):
        raise ValueError(f"an element of {size} bytes is longer than the file")
    return kind, data[begin : begin + size], begin + step


def _version_4(data: bytes) -> Iterator[Variable]:
    """Give the variables of a file of version 4."""
    at = 0
    while at < len(data):
        order = "<" if struct.unpack_from("<I", data, at)[0] < 10_000 else ">"
        kind, rows, columns, imaginary, length = struct.unpack_from(f"{order}5I", data, at)
        digit, rest = kind // 10 % 10, kind % 10
        if kind // 1000 != (order == ">") or kind // 100 % 10 or digit >= len(_TYPES_4):
            raise ValueError("it has no header of MATLAB")
        begin = at + 20 + length
        name = data[at + 20 : begin].rstrip(b"\0").decode("ascii")
        dtype = np.dtype(f"{order}{_TYPES_4[digit]}")
        at = begin + rows * columns * dtype.itemsize * (2 if imaginary else 1)
        if begin > len(data) or at > len(data):
            raise ValueError(f"the array {name!r} is longer than the file")
        if rest or imaginary:
            yield name, (rows, columns), None
        else:
            yield (
                name,
                (rows, columns),
                _numbers(np.frombuffer(data[begin:at], dtype), (rows, columns), name),
            )


def _numbers(found: NDArray[Any], shape: tuple[int, ...], name: str) -> Array:
    """Give the numbers of an array, as many as its shape says."""
    wanted = 1
    for size in shape:
        wanted *= size
    if found.size != wanted or min(shape, default=0) < 0:
        raise ValueError(f"the array {name!r} of shape {shape} has {found.size} numbers")
    return found.astype(np.float64)
