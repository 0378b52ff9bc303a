"""Universal files (UFF): data sets 55, 58, 151, 164 and 2411 as plain data, and mode shapes.

A universal file consists of data sets of lines with fields of fixed widths. Fields of 13 characters
take as many digits as they hold, which every reader of such fields accepts.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearbow._convert import shown
from gearbow._files import parsing, printable, replacing
from gearbow._shown import ReadOnly
from gearbow._types import Array, At, ComplexArray
from gearbow.errors import SceneError
from gearbow.units.parse import parsed

#: The line before and after each data set.
_MARK = re.compile(rb"^ {4}-1[ \t]*\r?$", re.MULTILINE)
#: The same behind binary data, where a line need not begin.
_END = re.compile(rb"\s{0,2} {4}-1[ \t]*\r?$", re.MULTILINE)
#: Lines of a data set 58 before its numbers.
_HEADER = 11
_WIDTHS = {
    "dof": (5, 10, 5, 10, 11, 10, 4, 11, 10, 4),
    "form": (10, 10, 10, 13, 13, 13),
    "quantity": (10, 5, 5, 5, 21, 21),
}
#: Ordinate types of data set 58: width of a number, and whether it is complex.
_ORDINATES = {2: ("f4", False), 4: ("f8", False), 5: ("f4", True), 6: ("f8", True)}
#: Types of the quantities of data set 58 that have units of their own.
_ACCELERATION, FORCE = 12, 13
#: Unit "g" of accelerations, ISO 80000-3 [m/s²].
_STANDARD_GRAVITY = 9.80665
#: Most characters of a line.
_LINE = 80


@dataclass(frozen=True)
class Quantity:
    """What the numbers of an axis are: the type of data set 58, and the unit as its label."""

    kind: int = 0
    unit: str = "NONE"


@dataclass(frozen=True, eq=False)
class Function:
    """A data set 58: function type, names, response, reference and values."""

    kind: int
    names: Sequence[str]
    response: tuple[int, int]
    reference: tuple[int, int]
    abscissa: Array
    values: NDArray[Any]
    #: Of the abscissa, the values and what they are divided by.
    quantities: Sequence[Quantity]
    entities: tuple[str, str] = ("NONE", "NONE")


@dataclass(frozen=True)
class DataSet:
    """A data set: its number, its bytes behind the line of the number, and where it begins."""

    kind: int
    content: bytes
    where: str
    #: Order of bytes "<" or ">" of binary numbers; empty for text.
    order: str = ""

    def lines(self) -> list[str]:
        """Give the lines of a data set of text."""
        return self.content.decode("utf-8", "replace").split("\n")

    def numbers(self, lines: Iterable[str], widths: Sequence[int]) -> Array:
        """Read lines with fields of these widths, the last of which may be fewer."""
        found = []
        for line in lines:
            at = 0
            for width in widths:
                cell = line[at : at + width].strip()
                if cell:
                    found.append(float(cell.upper().replace("D", "E")))
                at += width
        return self._finite(np.array(found))

    def _finite(self, values: Array) -> Array:
        if not np.isfinite(values).all():
            raise SceneError(f"{self.where}: has numbers that are not finite")
        return values

    def function(self) -> Function:
        """Read a data set 58."""
        head = self.content.split(b"\n", _HEADER)
        if len(head) <= _HEADER:
            raise SceneError(f"{self.where}: ends within its header")
        lines = [line.decode("utf-8", "replace").rstrip("\r") for line in head[:_HEADER]]
        dof, form = _fields(lines[5], "dof"), _fields(lines[6], "form")
        ordinate, count, even = (int(cell or "0") for cell in form[:3])
        if ordinate not in _ORDINATES:
            raise SceneError(f"{self.where}: has values of the unknown type {ordinate}")
        number, is_complex = _ORDINATES[ordinate]
        parts = 2 if is_complex else 1
        wanted = max(count, 0) * (parts if even else parts + 1)
        if self.order:
            dtype = np.dtype(f"{self.order}{number}")
            data = head[_HEADER]
            found = np.frombuffer(data[: len(data) // dtype.itemsize * dtype.itemsize], dtype)
            # Behind the numbers may be the end of a line.
            values = self._finite(found[:wanted].astype(np.float64))
        else:
            if number == "f4":
                widths: tuple[int, ...] = (13,) * 6
            elif even:
                widths = (20,) * 4
            else:
                widths = (13, 20, 20) if is_complex else (13, 20, 13, 20)
            rows = head[_HEADER].decode("utf-8", "replace").split("\n")
            values = self.numbers(rows, widths)
        if values.size != wanted or count < 1:
            raise SceneError(f"{self.where}: must have {wanted} numbers, has {values.size}")
        table = values.reshape(count, -1)
        if even:
            begin, step = (float((cell or "0").upper().replace("D", "E")) for cell in form[3:5])
            abscissa: Array = begin + step * np.arange(count, dtype=np.float64)
        else:
            abscissa, table = table[:, 0], table[:, 1:]
        names = [line.strip() for line in lines[:5]]
        node, axis, reference, toward = (int(dof[i] or "0") for i in (5, 6, 8, 9))
        axes = [_fields(line, "quantity") for line in lines[7:10]]
        return Function(
            int(dof[0]),
            names,
            (node, axis),
            (reference, toward),
            abscissa,
            table[:, 0] + 1j * table[:, 1] if is_complex else table[:, 0],
            [Quantity(int(cells[0] or "0"), cells[5]) for cells in axes],
        )


def data_sets(path: Path) -> Iterator[DataSet]:
    """Read the data sets of a file, one after the other."""
    data = path.read_bytes()
    with parsing(path, "a universal file"):
        at = 0
        while (mark := _MARK.search(data, at)) is not None:
            head, _, content = data[mark.end() + 1 :].partition(b"\n")
            line = data.count(b"\n", 0, mark.end()) + 2
            where = f"{path}: line {line}"
            if not re.fullmatch(rb"\s*[0-9]{1,6}[bB]?.*", head.rstrip(b"\r")[:80]):
                raise SceneError(f"{where}: must be the number of a data set, got {head[:20]!r}")
            begin = mark.end() + 1 + len(head) + 1
            order, size = "", 0
            if head[6:7].lower() == b"b":
                order = "<" if head[7:13].strip() == b"1" else ">"
                size = sum(len(line) + 1 for line in content.split(b"\n", _HEADER)[:_HEADER])
                size += int(head[31:43].strip() or b"0")
            end = (_END if order else _MARK).search(data, min(begin + size, len(data)))
            if end is None and order:  # a wrong size
                end = _END.search(data, begin)
            if end is None:
                raise SceneError(f"{where}: the data set has no end; the file is not complete")
            kind = int(head[:6].strip(b" \r\tbB") or b"0")
            content = data[begin : end.start()]
            yield DataSet(kind, content, f"{where}: data set {kind}", order)
            at = end.end()


@dataclass(frozen=True)
class FileUnits:
    """Units of a foreign universal file: how many make one of SI (data set 164)."""

    length: float = 1.0
    force: float = 1.0
    given: bool = False

    def factor(self, quantity: Quantity, kind: int, where: str, *, turns: bool = False) -> float:
        """Give what converts a quantity of this kind to SI units; its label counts first."""
        label = re.sub(r"(?<=[a-z])([23])\b", r"^\1", quantity.unit.strip())
        if label == "g" and kind == _ACCELERATION:
            return _STANDARD_GRAVITY
        # Of a velocity or acceleration, the length in one second.
        field, seconds = "length", {11: " s", 12: " s^2"}.get(kind, "")
        if kind == FORCE:
            field = "torques.value" if turns else "forces.value"
        elif turns:
            field = "phase"
        if label and label != "NONE":
            try:
                return parsed(f"1 {label}{seconds}", field)
            except SceneError:
                if not self.given:
                    raise SceneError(
                        f"{where}: the unit {label!r} is unknown, and the file has no data set 164"
                    ) from None
        if kind == FORCE:
            return 1.0 / (self.force * (self.length if turns else 1.0))
        return 1.0 if turns else 1.0 / self.length


def units_of(sets: Iterable[DataSet]) -> FileUnits:
    """Read the units of a file, its data set 164."""
    for one in sets:
        if one.kind == 164:
            length, force = one.numbers(one.lines()[1:], (25, 25, 25))[:2]
            if not (length > 0.0 and force > 0.0):
                raise SceneError(f"{one.where}: factors of units must be positive")
            return FileUnits(float(length), float(force), given=True)
    return FileUnits()


def origin_of(sets: Iterable[DataSet]) -> str:
    """Name model, description and program of a file for messages, by its data set 151."""
    for one in sets:
        if one.kind == 151:
            names = [line.strip() for line in one.lines()[:3]]
            return f" ({', '.join(name for name in names if name not in ('', 'NONE'))})"
    return ""


def _fields(line: str, name: str) -> list[str]:
    """Cut a line into the fields of a record."""
    found, at = [], 0
    for width in _WIDTHS[name]:
        found.append(line[at : at + width].strip())
        at += width
    return found


def write(path: Path, sets: Iterable[tuple[int, Iterable[str]]]) -> None:
    """Write data sets, each with its number and its lines."""
    with replacing(path) as file:
        for kind, lines in sets:
            file.write(f"    -1\n{kind:6d}\n".encode())
            file.writelines(f"{line}\n".encode() for line in lines)
            file.write(b"    -1\n")


def line_of(text: str) -> str:
    """Give a line with a text, which may be cut only where this is visible."""
    plain = " ".join(printable(text).splitlines())
    return plain if len(plain) <= _LINE else f"{plain[: _LINE - 1]}…"


def whole_line(text: str) -> str:
    """Give a line with a text that a reader needs."""
    if len(text) > _LINE or [printable(text)] != text.splitlines():
        raise SceneError(
            f"path: a line of a universal file has {_LINE} printable characters, too few for "
            f"{text!r}; give another name, or a file .nc"
        )
    return text


def function_lines(given: Function) -> Iterator[str]:
    """Give the lines of a data set 58 with complex values."""
    yield from given.names
    response, reference = given.response, given.reference
    entities = [f"{name[:10]:<10}" for name in given.entities]
    yield (
        f"{given.kind:5d}{0:10d}{0:5d}{0:10d} {entities[0]}{response[0]:10d}{response[1]:4d}"
        f" {entities[1]}{reference[0]:10d}{reference[1]:4d}"
    )
    yield f"{6:10d}{given.abscissa.size:10d}{0:10d}{0.0:13.5E}{0.0:13.5E}{0.0:13.5E}"
    for each in (*given.quantities, Quantity()):
        yield f"{each.kind:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {each.unit:<20}"
    for x, value in zip(given.abscissa.tolist(), given.values.tolist(), strict=True):
        yield f"{_fitted(x):>13}{value.real:20.12E}{value.imag:20.12E}"


def _fitted(number: float) -> str:
    """Give a number with all digits for which a field of 13 characters has the space."""
    texts = (f"{number:.{digits}g}" for digits in range(12, 0, -1))
    return next(text for text in texts if len(text) <= 12)


#: Analysis types of data set 55: normal modes, and complex modes of displacements and velocities.
_NORMAL, _COMPLEX, _VELOCITY = 2, 3, 7
#: What id5 says of a file of gearbow, whose nodes are those of the system in their order.
_OWN = "gearbow"


@dataclass(frozen=True, eq=False)
class MeasuredShapes(ReadOnly):
    """Measured mode shapes.

    Parameters
    ----------
    places : tuple of (str or (str, float))
        Places of the motions.
    frequencies_hz : ndarray, shape (k,)
        Natural frequencies [Hz].
    displacements : ndarray, shape (k, places, 2)
        Shapes along y and z, in any unit; NaN for what was not measured.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> shapes = np.array([[[1.0, np.nan], [0.5, np.nan]]])
    >>> measured = gb.results.MeasuredShapes(("pinion", ("input", 0.0)), np.array([81.0]), shapes)
    >>> measured.displacements.shape
    (1, 2, 2)
    """

    places: tuple[At, ...]
    frequencies_hz: Array
    displacements: ComplexArray


def write_uff(
    path: Path,
    *,
    positions: Array,
    displacements: ComplexArray,
    eigenvalues: ComplexArray,
    names: Sequence[str],
    speed: float,
) -> None:
    """Write positions (nodes, 3) and displacements (modes, nodes, 3) of modes."""
    sets: list[tuple[int, Iterable[str]]] = [(2411, _node_lines(positions))]
    for number, (value, shape, name) in enumerate(
        zip(eigenvalues, displacements, names, strict=True), start=1
    ):
        lines = [
            line_of(f"mode {number}, {name}"),
            f"{abs(value.imag) / (2.0 * np.pi):.9g} Hz",
            line_of(f"at {float(speed)!r} rad/s of the reference shaft"),
            "displacements along x, y, z",
            _OWN,
            # A structural model, complex modes of displacements in x, y, z as complex numbers.
            f"{1:10d}{_COMPLEX:10d}{2:10d}{8:10d}{5:10d}{3:10d}",
            f"{2:10d}{6:10d}{0:10d}{number:10d}",
            _reals([value.real, value.imag, 0.0, 0.0, 0.0, 0.0]),
        ]
        for node, moved in enumerate(shape, start=1):
            parts = [part for each in moved for part in (each.real, each.imag)]
            lines += [f"{node:10d}", _reals(parts)]
        sets.append((55, lines))
    write(path, sets)


def _node_lines(positions: Array) -> Iterator[str]:
    """Give the lines of a data set 2411, in which positions have all digits."""
    for number, position in enumerate(positions, start=1):
        yield f"{number:10d}{1:10d}{1:10d}{0:10d}"
        yield "".join(f"{each:25.16E}" for each in position)


def _reals(numbers: Iterable[float]) -> str:
    return "".join(f"{each:13.5E}" for each in numbers)


@dataclass(frozen=True, eq=False)
class _Shape:
    """A mode of a file: what wrote it, frequency [Hz], nodes and translations (nodes, 3)."""

    author: str
    frequency: float
    nodes: list[int]
    values: ComplexArray


def _shape(given: DataSet) -> _Shape | None:
    """Read a data set 55; None if it is no mode."""
    lines = given.lines()
    about = [int(cell) for cell in lines[5].split()]
    _, analysis, _, _, kind, count = about[:6]
    if analysis not in (_NORMAL, _COMPLEX, _VELOCITY):
        return None
    reals = given.numbers(lines[7:8], (13,) * 6)
    width = count * (2 if kind == 5 else 1)
    if kind not in (2, 5) or not 3 <= count <= 6:
        raise SceneError(f"{given.where}: must have 3 to 6 real or complex numbers for each node")
    nodes, rows = [], []
    step = 1 - (-width // 6)
    body = [line for line in lines[8:] if line.strip()]
    if len(body) % step:
        raise SceneError(f"{given.where}: ends within a node")
    for at in range(0, len(body), step):
        nodes.append(int(body[at]))
        numbers = given.numbers(body[at + 1 : at + step], (13,) * 6)
        if numbers.size != width:
            raise SceneError(f"{given.where}: node {nodes[-1]} must have {width} numbers")
        rows.append(numbers[0::2] + 1j * numbers[1::2] if kind == 5 else numbers)
    found = np.array(rows, dtype=np.complex128).reshape(len(nodes), -1)[:, :3]
    frequency = reals[0] if analysis == _NORMAL else abs(reals[1]) / (2.0 * np.pi)
    return _Shape(lines[4].strip(), float(frequency), nodes, found)


def read_uff(path: Path, places: Mapping[int, At] | None, nodes: Sequence[At]) -> MeasuredShapes:
    """Read the modes of a universal file; `nodes` are the places of a file of gearbow."""
    sets = [one for one in data_sets(path) if one.kind == 55]
    with parsing(path, "a universal file"):
        found = [shape for one in sets if (shape := _shape(one)) is not None]
    if not found:
        raise SceneError(f"{path}: has no mode shape (data set 55)")
    numbers = found[0].nodes
    own = found[0].author == _OWN
    known = dict(places or (enumerate(nodes, start=1) if own else ()))
    used = [number for number in numbers if number in known]
    if not used:
        raise SceneError(
            f"places: needs the place of a node of {path}, for example "
            f'places={{{numbers[0]}: ("input", 0.2)}}, got {shown(places)}'
        )
    frequencies, shapes = [], []
    for given in found:
        rows = {number: i for i, number in enumerate(given.nodes)}
        if any(number not in rows for number in used):
            raise SceneError(f"{path}: every mode must have the nodes {used}")
        shapes.append(given.values[[rows[number] for number in used], 1:])
        frequencies.append(given.frequency)
    return MeasuredShapes(
        tuple(known[number] for number in used), np.array(frequencies), np.array(shapes)
    )
