"""Points of a sweep, a grid or a list of parameter values; outcomes; identity of its functions.

The identity of a function is what a stored sweep must have in common with the call that resumes it:
the digest of the bytecode, of the default values, and of what the function refers to: variables of
enclosing functions, global values, and functions of its own module. Functions of other modules and
classes are not examined.
"""

import functools
import hashlib
import math
import traceback
import types
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from typing import TYPE_CHECKING, Any, TypeAlias, overload

import numpy as np

from gearbow._convert import BYTES, shown
from gearbow._types import Plain
from gearbow.errors import GearbowError, SceneError
from gearbow.units.speed import SpeedUnit, given_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray


#: Accepted parameters of a sweep: a grid, or a list of points.
Parameters: TypeAlias = Mapping[str, Iterable[Any]] | Iterable[Mapping[str, Any]]


class Points(Sequence[dict[str, Any]]):
    """The points of a sweep; a grid is not expanded."""

    def __init__(self, given: object) -> None:
        self.axes: dict[str, list[Any]] | None = None
        self._rows: list[dict[str, Any]] = []
        #: Unit in which the speeds of a grid were given.
        self.speed_unit: SpeedUnit = "rad/s"
        if isinstance(given, Mapping):
            self.speed_unit = given_unit(list(given.values())) or "rad/s"
            self.axes = {
                _name(name, "parameters"): _list(values, f"parameters.{name}")
                for name, values in given.items()
            }
            self.names = tuple(self.axes)
        else:
            self._rows = [_row(row, i) for i, row in enumerate(_list(given, "parameters"))]
            self.names = tuple(self._rows[0])
        if not self.names:
            raise SceneError("parameters: must name at least one parameter, got none")
        for i, row in enumerate(self._rows):
            if set(row) != set(self.names):
                raise SceneError(
                    f"parameters[{i}]: must have the names {', '.join(self.names)} of "
                    f"parameters[0], got {', '.join(row) or 'none'}"
                )

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each parameter of a grid, or the number of points of a list."""
        if self.axes is None:
            return (len(self._rows),)
        return tuple(len(values) for values in self.axes.values())

    def __len__(self) -> int:
        return math.prod(self.shape)

    @overload
    def __getitem__(self, index: int) -> dict[str, Any]: ...
    @overload
    def __getitem__(self, index: slice) -> list[dict[str, Any]]: ...
    def __getitem__(self, index: int | slice) -> dict[str, Any] | list[dict[str, Any]]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        if not -len(self) <= index < len(self):
            raise IndexError(f"there are {len(self)} points, got the index {index}")
        index %= len(self)
        if self.axes is None:
            return {name: self._rows[index][name] for name in self.names}
        point = {}
        for name, values in reversed(self.axes.items()):
            index, place = divmod(index, len(values))
            point[name] = values[place]
        return {name: point[name] for name in self.names}

    def column(self, name: str) -> list[Any]:
        """Return the values of a parameter: of an axis of a grid, or of each point of a list."""
        if self.axes is not None:
            return self.axes[name]
        return [row[name] for row in self._rows]

    def plain(self) -> dict[str, Plain]:
        """Return the points as plain data."""
        if self.axes is not None:
            return {"grid": _plain(self.axes, "parameters")}
        return {"points": _plain([self[i] for i in range(len(self))], "parameters")}


def _name(name: object, where: str) -> str:
    if not isinstance(name, str):
        raise SceneError(f"{where}: the name of a parameter must be text, got {shown(name)}")
    return str(name)


def _list(values: object, where: str) -> list[Any]:
    """Read a list. NumPy numbers become those of Python, so that a file gives the same values."""
    if isinstance(values, np.ndarray) and values.ndim == 1:
        values = values.tolist()
    if isinstance(values, (str, *BYTES, Mapping)) or not isinstance(values, Iterable):
        wanted = "a list of values" if "." in where else "a dict of lists or a list of dicts"
        raise SceneError(f"{where}: must be {wanted}, got {shown(values)}")
    if isinstance(values, np.ndarray):
        raise SceneError(
            f"{where}: must be one list of values, got an array of the shape {values.shape}"
        )
    found = [_python(value) for value in values]
    if not found:
        raise SceneError(f"{where}: must have at least one entry, got none")
    return found


def _row(row: object, index: int) -> dict[str, Any]:
    where = f"parameters[{index}]"
    if not isinstance(row, Mapping):
        raise SceneError(f"{where}: must be a dict of the parameters of a point, got {shown(row)}")
    return {_name(name, where): _python(value) for name, value in row.items()}


def _python(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _plain(value: Any, where: str) -> Plain:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Mapping):
        return {
            _name(name, where): _plain(entry, f"{where}.{name}") for name, entry in value.items()
        }
    if isinstance(value, list | tuple):
        return [_plain(entry, f"{where}[{i}]") for i, entry in enumerate(value)]
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biufU":
        return value.tolist()
    raise SceneError(
        f"{where}: a file contains only numbers, texts, None and lists of them, got "
        f"{shown(value)}; use a number or a name as the parameter, and make the object from it in "
        "`make`"
    )


#: Name of the value if `measure` returns no dict.
SINGLE = "value"

#: Measured values by name: NumPy scalars, and arrays.
Values = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Outcome:
    """Measured values of a point, or its error."""

    values: Values | None = None
    error: str = ""
    details: str = field(default="", repr=False)


def compute(
    make: Callable[..., Any], measure: Callable[..., Any], parameters: dict[str, Any]
) -> Outcome:
    """Make the system of a point and measure it."""
    try:
        return Outcome(_values(measure(make(**parameters), **parameters)))
    except Exception as error:  # noqa: BLE001  # the other points continue
        return failure(error)


def failure(error: BaseException) -> Outcome:
    """Return the outcome of a failed point."""
    name = type(error).__qualname__
    text = f"{name}: {error}" if str(error) else name
    return Outcome(None, text, "".join(traceback.format_exception(error)))


def _values(found: object) -> dict[str, Any]:
    if not isinstance(found, Mapping):
        return {SINGLE: _value(found, "measure")}
    if not found:
        raise SceneError("measure: must return at least one value, got an empty dict")
    for name in found:
        if not isinstance(name, str):
            raise SceneError(f"measure: the name of a value must be text, got {shown(name)}")
    return {str(name): _value(value, f"measure: {name!r}") for name, value in found.items()}


def _value(value: object, where: str) -> Any:
    wanted = "must be a number, a text or an array of them"
    if isinstance(value, np.ma.MaskedArray):
        raise SceneError(f"{where}: must not be a masked array; give its `.filled()` values")
    try:
        array: NDArray[Any] = np.asarray(value)
    except (TypeError, ValueError):  # rows of different lengths
        raise SceneError(f"{where}: {wanted}, got {shown(value)}") from None
    if array.dtype.kind not in "biufcU":
        raise SceneError(f"{where}: {wanted}, got {shown(value)}")
    kind = array.dtype.newbyteorder("=")
    if kind.char in "gG":  # extended precision depends on the machine
        kind = np.dtype(np.float64 if kind.char == "g" else np.complex128)
    # A copy: `measure` may change its array later. `[()]` makes a scalar of an array without axes.
    return np.array(array, dtype=kind, order="C")[()]


def identity(function: Callable[..., Any]) -> dict[str, str]:
    """Return the name and the digest of a function."""
    digest = hashlib.sha256()
    for piece in _pieces(function, set()):
        digest.update(piece.encode())
        digest.update(b"\0")
    return {"name": _title(function), "digest": digest.hexdigest()[:32]}


def _title(function: Any) -> str:
    if isinstance(function, functools.partial):
        return _title(function.func)
    own = function if hasattr(function, "__qualname__") else type(function)
    return str(own.__qualname__)


def _pieces(value: Any, seen: set[int]) -> Iterator[str]:
    """Describe a value by texts that do not depend on memory addresses."""
    if value is None or isinstance(value, bool | int | float | complex | str | bytes):
        yield repr(value)
    elif isinstance(value, types.CodeType):
        yield from _code(value, seen)
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype}{value.shape}{hashlib.sha256(value.tobytes()).hexdigest()}"
    elif id(value) in seen:
        yield "seen"
    elif isinstance(value, types.FunctionType):
        yield from _function(value, {*seen, id(value)})
    else:
        yield type(value).__qualname__
        for part in _parts(value):
            yield from _pieces(part, {*seen, id(value)})


def _parts(value: Any) -> list[Any]:
    """Return the values that make up a container or an object."""
    if isinstance(value, functools.partial):
        return [value.func, value.args, value.keywords]
    if isinstance(value, types.MethodType):
        return [value.__func__, value.__self__]
    if isinstance(value, dict | types.MappingProxyType):
        return [part for item in value.items() for part in item]
    if isinstance(value, list | tuple):
        return list(value)
    if isinstance(value, set | frozenset):
        # The order of a set differs between processes.
        return sorted("\0".join(_pieces(item, set())) for item in value)
    if is_dataclass(value) and not isinstance(value, type):
        return [getattr(value, field.name) for field in fields(value)]
    if isinstance(getattr(type(value), "description", None), property):  # a system
        try:
            return [value.description]
        except GearbowError:  # loads that are functions of time have no plain form
            return [vars(value)]
    called = vars(type(value)).get("__call__")
    if isinstance(called, types.FunctionType):
        return [called, getattr(value, "__dict__", None)]
    return []


def _code(code: types.CodeType, seen: set[int]) -> Iterator[str]:
    yield code.co_code.hex()
    yield repr((code.co_names, code.co_varnames, code.co_freevars, code.co_argcount))
    for constant in code.co_consts:
        yield from _pieces(constant, seen)


def _function(function: types.FunctionType, seen: set[int]) -> Iterator[str]:
    yield from _code(function.__code__, seen)
    yield from _pieces((function.__defaults__, function.__kwdefaults__), seen)
    for cell in function.__closure__ or ():
        try:
            yield from _pieces(cell.cell_contents, seen)
        except ValueError:  # the variable has no value yet
            yield "empty"
    for name in sorted(_global_names(function.__code__)):
        value = function.__globals__.get(name)
        foreign = isinstance(value, types.FunctionType) and value.__module__ != function.__module__
        if not foreign and not isinstance(value, types.ModuleType):
            yield name
            yield from _pieces(value, seen)


def _global_names(code: types.CodeType) -> set[str]:
    inner = [constant for constant in code.co_consts if isinstance(constant, types.CodeType)]
    return set(code.co_names).union(*map(_global_names, inner))
