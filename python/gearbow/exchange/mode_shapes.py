"""Mode shapes in universal files: nodes as data set 2411, and one data set 55 for each mode."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gearbow._convert import shown
from gearbow._files import parsing
from gearbow._read_only import ReadOnly
from gearbow._types import Array, At, ComplexArray
from gearbow.errors import SceneError
from gearbow.exchange.universal import DataSet, data_sets, line_of, write

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
