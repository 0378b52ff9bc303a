"""Curves of a frequency response as data sets and files, and measured curves from files."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from io import BufferedRandom
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import shown
from gearbow._extras import extra
from gearbow._files import parsing
from gearbow._shown import ReadOnly
from gearbow._types import Array, At, ComplexArray
from gearbow.description.loads import Force, Torque
from gearbow.errors import SceneError, SceneWarning, warn
from gearbow.exchange.tables import NamedColumns, read_table
from gearbow.exchange.universal import (
    FORCE,
    FileUnits,
    Function,
    Quantity,
    data_sets,
    function_lines,
    line_of,
    origin_of,
    units_of,
    whole_line,
    write,
)
from gearbow.units.fields import MOTIONS

if TYPE_CHECKING:
    import xarray as xr

#: Directions of a response in UFF 58, and the dimension of a displacement there.
_UFF_DIRECTIONS = {"x": 1, "y": 2, "z": 3, "twist": 4}
#: Data types of UFF 58: displacement, velocity, acceleration, and excitation force.
_UFF_TYPES = {"m": 8, "rad": 8, "N": 13}
_UFF_QUANTITIES = {8: "displacement", 11: "velocity", 12: "acceleration"}
_DIRECTIONS = {number: name for name, number in _UFF_DIRECTIONS.items()}
_TWIST = _UFF_DIRECTIONS["twist"]
#: What the last line of text of a file of gearbow says.
_OWN = "gearbow"
#: Function types of UFF 58.
_UFF_FRF = 4


@dataclass(frozen=True)
class Curve:
    """A signal of a frequency response in one direction."""

    #: Place: a name, (shaft, position), or (driver, driven) of a mesh.
    at: Any
    #: "displacement", "bearing force" or "mesh force".
    kind: str
    #: "x", "y", "z", "twist" or "mesh".
    direction: str
    unit: str
    #: Phasors, shape (*frequencies, sources).
    values: ComplexArray

    @property
    def place(self) -> str:
        """The place as a text."""
        return _text(self.at)

    @property
    def name(self) -> str:
        """Name of a column."""
        kind = "" if self.kind == "displacement" else f"{self.kind} "
        direction = "" if self.direction == "mesh" else self.direction
        return f"{self.place} {kind}{direction}".rstrip()


def to_xarray(
    curves: Sequence[Curve],
    axes: Sequence[str],
    coordinates: Mapping[str, Array],
    sources: Sequence[str],
    *,
    parts: bool = False,
) -> "xr.Dataset":
    """Give curves as a data set; with `parts`, complex numbers as a dimension "part"."""
    with extra("netcdf"):
        import xarray as xr  # noqa: PLC0415

    dimensions = (*axes, "source")
    variables: dict[str, Any] = {}
    for curve in curves:
        values: Any = curve.values
        shape = dimensions
        if parts:
            values, shape = np.stack([values.real, values.imag], axis=-1), (*dimensions, "part")
        variables[curve.name.replace("/", " – ")] = (shape, values, {"units": curve.unit})
    given: dict[str, Any] = {"source": ("source", np.array(sources))}
    if parts:
        given["part"] = ("part", np.array(["real", "imaginary"]))
    for name, own in coordinates.items():
        given[name] = (tuple(axes) if own.ndim == len(axes) else name, own, {"units": "rad/s"})
    return xr.Dataset(variables, given)


def write_mat(
    file: BufferedRandom,
    curves: Iterable[Curve],
    frequencies: Array,
    speeds: Array,
    sources: Sequence[str],
) -> None:
    """Write a file of MATLAB: vectors, and one structure for each curve."""
    with extra("matlab"):
        from scipy.io import savemat  # noqa: PLC0415

    names = ("place", "kind", "direction", "unit", "values")
    listed = [{name: getattr(curve, name) for name in names} for curve in curves]
    content = {
        "frequencies": frequencies,
        "speeds": speeds,
        "sources": np.array(sources, dtype=object),
        "curves": np.array(listed, dtype=object),
    }
    savemat(file, content, do_compression=False, oned_as="column")


def write_uff(
    path: Path,
    curves: Iterable[Curve],
    *,
    frequencies: Array,
    speeds: Array,
    sources: Sequence[str],
    plain: Sequence[Mapping[str, Any]],
) -> None:
    """Write curves for each unit of a source as data sets 58 of a universal file."""
    nodes: dict[str, int] = {}
    sets = []
    for curve in curves:
        node = nodes.setdefault(curve.place, len(nodes) + 1)
        for number, (source, given) in enumerate(zip(sources, plain, strict=True)):
            reference = reference_of(given)
            names = [
                line_of(f"{curve.name} [{curve.unit}] due to {source}"),
                line_of(f"at {float(speeds.ravel()[0])!r} rad/s of the reference shaft"),
                whole_line(f"place {curve.place}"),
                whole_line(f"source {source}"),
                _OWN,
            ]
            function = Function(
                _UFF_FRF,
                names,
                (node, _UFF_DIRECTIONS.get(curve.direction, 0)),
                (number + 1, reference.direction),
                frequencies / (2.0 * np.pi),
                curve.values[..., number] / reference.amplitude,
                (
                    Quantity(18, "Hz"),
                    Quantity(_UFF_TYPES.get(curve.unit, 0), curve.unit),
                    reference.quantity,
                ),
            )
            sets.append((58, function_lines(function)))
    write(path, sets)


@dataclass(frozen=True)
class _Reference:
    """What a function of a source is divided by: its amplitude, quantity and direction of UFF."""

    amplitude: complex
    quantity: Quantity
    direction: int = 0


def reference_of(source: Mapping[str, Any]) -> _Reference:
    """Give amplitude, quantity and direction of the plain data of a source."""
    kind = source["kind"]
    if kind == "mesh_error":
        return _Reference(complex(*source["error"]) or 1.0, Quantity(8, "m"))
    if kind == "torque":
        return _Reference(complex(*source["value"]) or 1.0, Quantity(13, "N m"), 4)
    if kind == "shaft":
        return _Reference(1.0, Quantity())
    parts = [complex(*pair) for pair in (source["axial"], *source["value"])]
    quantity = Quantity(13, "N")
    if kind == "ground":
        quantities = {name: number for number, name in _UFF_QUANTITIES.items()}
        name = source["quantity"]
        quantity = Quantity(quantities[name], MOTIONS[name].replace("²", "^2"))  # in ASCII
    acting = [i for i, part in enumerate(parts, start=1) if part]
    if len(acting) != 1:
        return _Reference(float(np.linalg.norm(parts)) or 1.0, quantity)
    (axis,) = acting
    amplitude = parts[axis - 1]
    if amplitude.imag == 0.0 and amplitude.real < 0.0:
        return _Reference(-amplitude, quantity, -axis)
    return _Reference(amplitude, quantity, axis)


@dataclass(frozen=True, eq=False)
class MeasuredCurve(ReadOnly):
    """A measured frequency response function.

    Parameters
    ----------
    at : str or tuple of (str, float)
        Place of the response.
    direction : {"x", "y", "z", "twist"}
        Direction of the response.
    quantity : {"displacement", "velocity", "acceleration"}
        Quantity of the response.
    frequencies, values : ndarray, shape (k,)
        Frequencies [rad/s], and phasors of the response to the source.
    source : int, Force or Torque
        Number of the source in the compared response; or the source, whose response the values are.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> curve = gb.results.MeasuredCurve("pinion", "y", "velocity", np.ones(3), 1j * np.ones(3))
    >>> curve.label
    'pinion y'
    """

    at: At
    direction: str
    quantity: str
    frequencies: Array
    values: ComplexArray
    source: int | Force | Torque = 0

    @property
    def label(self) -> str:
        """Name of the curve in figures: place and direction."""
        return f"{_text(self.at)} {self.direction}"


def _text(at: Any) -> str:
    """Give a place as a text: "pinion", "input@0.2" or "pinion/wheel"."""
    if isinstance(at, str):
        return at
    first, second = at
    return f"{first}/{second}" if isinstance(second, str) else f"{first}@{float(second)!r}"


def read_measured(
    path: Path,
    places: Mapping[int, At] | None,
    sources: Sequence[str],
    plain: Sequence[Mapping[str, Any]],
) -> list[MeasuredCurve]:
    """Read measured curves, with the labels and plain data of the sources of the response."""
    if path.suffix.lower() in (".uff", ".unv"):
        return _read_uff(path, places or {}, sources, plain)
    return _read_table(path)


#: Columns of a table: a place, and a direction with the real or imaginary part.
_COLUMNS = NamedColumns(
    re.compile(r"(.+?)\s+((?:[xyz]|twist)\s+(?:re|im))", re.IGNORECASE),
    {
        f"{direction} {part}": (
            ("measured.twist",)
            if direction == "twist"
            else ("measured.displacement", "measured.velocity", "measured.acceleration")
        )
        for direction in _UFF_DIRECTIONS
        for part in ("re", "im")
    },
    "pinion y re [m/s²]",
)


def _read_table(path: Path) -> list[MeasuredCurve]:
    """Read a frequency and pairs of columns such as "pinion y re [m/s²]"."""
    table = read_table(path, {"frequency": "frequency"}, named=_COLUMNS)
    if "frequency" not in table.numbers:
        raise SceneError(f'{path}: needs the column "frequency [Hz]"')
    curves = []
    for name in table.numbers:
        curve, _, part = name.rpartition(" ")
        if name == "frequency":
            continue
        names = [f"{curve} {each}" for each in ("re", "im")]
        if not set(names) <= table.numbers.keys() or len({table.fields[n] for n in names}) > 1:
            raise SceneError(f"{path}: {curve} needs a column re and a column im of one quantity")
        if part == "re":
            real, imaginary = (table.numbers[n] for n in names)
            place, _, direction = curve.rpartition(" ")
            quantity = table.fields[name].removeprefix("measured.").replace("twist", "displacement")
            values = real + 1j * imaginary
            frequencies = table.numbers["frequency"]
            curves.append(MeasuredCurve(_place(place), direction, quantity, frequencies, values))
    if not curves:
        raise SceneError(f'{path}: needs columns such as "{_COLUMNS.example}"')
    return curves


def _place(text: str) -> At:
    """Read "pinion" or "input@0.2"."""
    name, sign, position = text.rpartition("@")
    try:
        return (name, float(position)) if sign else text
    except ValueError:  # a name with this sign
        return text


def _read_uff(
    path: Path,
    places: Mapping[int, At],
    sources: Sequence[str],
    plain: Sequence[Mapping[str, Any]],
) -> list[MeasuredCurve]:
    """Read the frequency response functions of a universal file."""
    sets = list(data_sets(path))
    with parsing(path, "a universal file"):
        units, origin = units_of(sets), origin_of(sets)
        curves, left = [], []
        for one in sets:
            if one.kind != 58:
                continue
            function = one.function()
            known = function.kind == _UFF_FRF and function.quantities[0].kind in (0, 18)
            own = function.names[4] == _OWN and function.names[2].startswith("place ")
            kind, direction = function.quantities[1].kind, abs(function.response[1])
            if not known or kind not in _UFF_QUANTITIES or direction not in _DIRECTIONS:
                if not own:
                    left.append(f"{one.where} (function type {function.kind}, ordinate {kind})")
            elif own:
                curves.append(_own_curve(function, one.where, sources, plain))
            else:
                curves.append(_foreign_curve(function, f"{one.where}{origin}", places, units))
    if not curves:
        what = f"; it has {'; '.join(left)}" if left else ""
        raise SceneError(
            f"{path}: has no frequency response function of a motion (data set 58){what[:300]}"
        )
    if left:
        warn(
            f"{path}: left out {len(left)} data sets 58 that are no frequency response functions "
            f"of a motion, the first {left[0].removeprefix(f'{path}: ')}",
            SceneWarning,
        )
    return curves


def _own_curve(
    function: Function, where: str, sources: Sequence[str], plain: Sequence[Mapping[str, Any]]
) -> MeasuredCurve:
    """Give a curve of a file of gearbow, whose sources are those of the response."""
    number, label = function.reference[0] - 1, function.names[3].removeprefix("source ")
    if not 0 <= number < len(sources) or sources[number] != label:
        raise SceneError(
            f"{where}: has the source {number + 1}, {label!r}; those of the response are "
            f"{', '.join(sources)}"
        )
    at = _place(function.names[2].removeprefix("place "))
    return _curve(function, where, at, reference_of(plain[number]).amplitude, number)


def _foreign_curve(
    function: Function, where: str, places: Mapping[int, At], units: FileUnits
) -> MeasuredCurve:
    """Give a curve of another program, with the force at its reference as source."""

    def placed(node: int, what: str) -> At:
        if node not in places:
            raise SceneError(
                f"places: needs the place of the {what} node {node} of {where}, for example "
                f'places={{{node}: ("input", 0.2)}}, got {shown(dict(places))}'
            )
        return places[node]

    (node, axis), (reference, toward) = function.response, function.reference
    _, quantity, denominator = function.quantities
    factor = units.factor(quantity, quantity.kind, where, turns=abs(axis) == _TWIST)
    source: int | Force | Torque = 0
    if toward and denominator.kind in (0, 1, 9, FORCE):
        at, sign = placed(reference, "reference"), float(np.sign(toward))
        if abs(toward) > _TWIST:
            raise SceneError(f"{where}: gearbow has no source in the direction {toward}")
        if abs(toward) == _TWIST:
            source = Torque(at, sign)
        else:
            along = {1: 0.0, 2: 1.0, 3: 1j}[abs(toward)]
            source = Force(at, sign * along, axial=sign * (abs(toward) == 1))
        factor /= units.factor(denominator, FORCE, where, turns=abs(toward) == _TWIST)
    return _curve(function, where, placed(node, "response"), factor, source)


def _curve(
    function: Function, where: str, at: At, factor: complex, source: int | Force | Torque
) -> MeasuredCurve:
    """Give the curve of a function that becomes the response of a place by a factor."""
    abscissa = {"": 2.0 * np.pi, "NONE": 2.0 * np.pi, "HZ": 2.0 * np.pi, "RAD/S": 1.0}.get(
        function.quantities[0].unit.upper()
    )
    if abscissa is None:
        raise SceneError(f"{where}: the frequency must be in Hz, has {function.quantities[0]}")
    axis = function.response[1]
    # A sensor along −y measures the opposite.
    values = np.sign(axis) * factor * function.values.astype(np.complex128)
    direction, quantity = _DIRECTIONS[abs(axis)], _UFF_QUANTITIES[function.quantities[1].kind]
    return MeasuredCurve(at, direction, quantity, abscissa * function.abscissa, values, source)
