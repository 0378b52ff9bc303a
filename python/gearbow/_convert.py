"""Arguments: conversion to plain numbers, names with suggestions, and misspelt keywords.

The only definition of a valid number. Strings, booleans, complex numbers, dates and masked arrays
are not real numbers, even if Python or NumPy can convert them: they are probably mistakes. Every
error is a `SceneError` that begins with the path of the argument. Quantities of pint are converted
to the SI unit of the path.
"""

import inspect
import math
import numbers
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache, wraps
from operator import index
from types import FunctionType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from gearbow._types import Array, Dof, NodalDof, Plain
from gearbow.errors import SceneError
from gearbow.units.fields import is_quantity, magnitude, unit_of

if TYPE_CHECKING:
    from typing_extensions import Self


#: Integers of at least this magnitude are converted to floats: the core reads 64-bit integers.
_LARGEST_INTEGER = 2**63
#: Largest count: the core counts with at least 32 bits.
LARGEST_COUNT = 2**32 - 1
#: Keys whose values may be complex.
_COMPLEX = ("unbalance", "runout", "offset", "angle", "misalignment")
#: Types of bytes, which are no sequences of numbers.
BYTES = (bytes, bytearray, memoryview)
#: Longest representation of a value in an error message.
_LONGEST = 100
#: Half of a character of UTF-16, which UTF-8 has not.
_SURROGATE = re.compile("[\ud800-\udfff]")


def shown(value: object) -> str:
    """Give the representation of a value, shortened for an error message."""
    try:
        text = repr(value)
    except ValueError:  # integers of more than 4300 digits have none
        text = "a very large integer"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def real(value: object, path: str, wanted: str = "a number") -> float:
    """Convert one real number; NaN and infinity pass, because the core rejects them."""
    if type(value) is float:
        return value
    value = _scalar(value, path)
    if not _is_real(value):
        raise SceneError(f"{path}: must be {wanted}, got {shown(value)}{_remedy(value, path)}")
    try:
        if hasattr(value, "__index__"):
            whole = index(value)
            return whole if abs(whole) < _LARGEST_INTEGER else float(whole)
        return float(value)  # type: ignore[arg-type]  # it has __float__
    except (TypeError, ValueError):
        raise SceneError(f"{path}: must be {wanted}, got {shown(value)}") from None
    except OverflowError:
        raise SceneError(
            f"{path}: must be below 1.8e308, the largest floating-point number, got {shown(value)}"
        ) from None


def _scalar(value: object, path: str) -> object:
    """Give the value of a quantity with a unit, and that of an array without axes."""
    if is_quantity(value):
        value = magnitude(value, path)
    return value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value


def number(value: object, path: str, *, infinite: bool = False) -> float:
    """Convert one real number, finite unless `infinite` is set."""
    found = float(real(value, path))
    if not (math.isfinite(found) or (infinite and found == math.inf)):
        raise SceneError(f"{path}: must be finite, got {found}")
    return found


def positive(value: object, path: str, below: float = math.inf, *, infinite: bool = False) -> float:
    """Convert one positive number less than `below`, finite unless `infinite` is set."""
    found = number(value, path, infinite=infinite)
    if not (0.0 < found < below or found == below == math.inf):
        bound = "positive" if math.isinf(below) else f"between 0 and {below:g}"
        raise SceneError(f"{path}: must be {bound}, got {value!r}")
    return found


def whole(value: object, path: str, least: int = 1, most: int = LARGEST_COUNT) -> int:
    """Convert one whole number; 25.0 is valid, 25.5 is invalid."""
    found = real(value, path, "a whole number")
    if not float(found).is_integer():
        raise SceneError(f"{path}: must be a whole number, got {found}")
    if found < least:
        raise SceneError(f"{path}: must be at least {least}, got {shown(value)}")
    if found > most:
        raise SceneError(f"{path}: must be at most {most}, got {shown(value)}")
    return int(found)


def complex_number(value: object, path: str) -> Plain:
    """Convert a real number, a complex number or a pair [re, im]; complex becomes a pair."""
    value = _scalar(value, path)
    if isinstance(value, (complex, np.complexfloating)):
        return [float(value.real), float(value.imag)]
    if isinstance(value, (tuple, list, np.ndarray)):
        return nested(value, path)
    return real(value, path)


def nested(value: object, path: str) -> Plain:
    """Convert a real number, or sequences of them in sequences, to numbers and lists."""
    if is_quantity(value):
        value = magnitude(value, path)
    if isinstance(value, np.ma.MaskedArray):
        raise SceneError(f"{path}: must not be a masked array; give its `.filled()` values")
    if hasattr(value, "__array__") and not isinstance(value, np.generic):
        value = np.asarray(value)
        if value.ndim > 0 and value.dtype.kind in "iuf":
            # Extended precision has no other plain form.
            return value.astype(np.float64).tolist() if value.dtype.kind == "f" else value.tolist()
    if getattr(value, "ndim", None) == 0 or not _is_sequence(value):
        return real(value, path)
    return [nested(item, f"{path}[{i}]") for i, item in enumerate(value)]  # type: ignore[arg-type,var-annotated]  # checked


def array(values: object, path: str, *, least: int = 1) -> Array:
    """Convert a sequence of finite real numbers; a single number is a sequence of one."""
    found = matrix(values, path)
    if found.ndim == 0:
        found = found.reshape(1)
    if found.ndim != 1:
        raise SceneError(f"{path}: must be one sequence of numbers, got the shape {found.shape}")
    if found.size < least:
        raise SceneError(f"{path}: must have at least {least} number(s), got {found.size}")
    if not np.isfinite(found).all():
        i = int(np.argmin(np.isfinite(found)))
        raise SceneError(f"{path}[{i}]: must be finite, got {found[i]}")
    return found


def matrix(values: object, path: str) -> Array:
    """Convert nested sequences of real numbers to an array of any number of axes."""
    converted = nested(values, path)  # its errors are ValueErrors too
    try:
        found: Array = np.array(converted, dtype=np.float64)
    except ValueError:
        raise SceneError(f"{path}: must have rows of equal lengths, got {shown(values)}") from None
    return found


def text(value: object, path: str) -> str:
    """Convert a string."""
    if not isinstance(value, str):
        raise SceneError(f"{path}: must be text, got {shown(value)}")
    if "\0" in value:  # no file format has it in a text
        raise SceneError(f"{path}: must not contain the character NUL, got {shown(value)}")
    if (lone := _SURROGATE.search(value)) is not None:
        sign = f"U+{ord(lone[0]):04X}"
        raise SceneError(
            f"{path}: must not contain the lone surrogate {sign}, which no file has in a text, "
            f"got {value!a}"
        )
    return str(value)


def function(value: object, path: str) -> Callable[..., Any]:
    """Check that a value can be called."""
    if not callable(value):
        raise SceneError(f"{path}: must be a function, got {shown(value)}")
    return value


def items(values: object, path: str, of: str) -> list[Any]:
    """Convert a list or another iterable to a list; a text, bytes or a mapping is none."""
    if not _is_sequence(values) or getattr(values, "ndim", None) == 0:
        raise SceneError(f"{path}: must be a list of {of}, got {shown(values)}")
    return list(values)  # type: ignore[call-overload,no-any-return]  # checked


def truth(value: object, path: str) -> bool:
    """Convert a truth value."""
    if not isinstance(value, (bool, np.bool_)):
        raise SceneError(f"{path}: must be True or False, got {shown(value)}")
    return bool(value)


def _remedy(value: object, path: str) -> str:
    """Say how to write a number that was given as a text or in a list."""
    if isinstance(value, (list, tuple)) and len(value) == 1 and _is_real(value[0]):
        return f"; write {shown(value[0])} without brackets"
    if not isinstance(value, str):
        return ""
    from gearbow.units.parse import FUNCTIONS, parsed  # noqa: PLC0415  # only for this message

    try:
        plain = f"{parsed(value, path, bare=True):.12g}"
    except SceneError as error:
        _, found, remedy = str(error).partition("did you mean ")
        return f"; {found}{remedy}" if found else ""
    unit = unit_of(path)
    text = f"; write {plain} without quotes{'' if unit in (None, '1') else f' [{unit}]'}"
    number, _, given = value.strip().partition(" ")
    function = FUNCTIONS.get(given)
    return text if function is None else f"{text}, or gb.{function}({number})"


def _is_real(value: object) -> bool:
    if isinstance(value, (bool, np.bool_, str, *BYTES, np.ma.MaskedArray)):
        return False
    if isinstance(value, np.generic):
        return value.dtype.kind in "iuf"
    if isinstance(value, numbers.Complex):
        return isinstance(value, numbers.Real)
    if getattr(value, "ndim", 0) != 0:
        return False
    return hasattr(value, "__float__") or hasattr(value, "__index__")


def _is_sequence(value: object) -> bool:
    return isinstance(value, Iterable) and not isinstance(value, (str, *BYTES, Mapping))


@contextmanager
def showing(plain: Any) -> Iterator[None]:
    """Add the given value to errors of the core about the shape of an entry of plain data."""
    try:
        yield
    except SceneError as error:
        path, _, message = str(error).partition(": ")
        if not message.startswith(("expected ", "invalid type: sequence", "invalid length")):
            raise
        value = plain
        try:
            for name, i in re.findall(r"([^.\[\]]+)|\[(\d+)\]", path):
                value = value[name or int(i)]
        except (KeyError, IndexError, TypeError):  # a name that the user chose may have dots
            raise error from None
        raise SceneError(f"{error}, got {shown(value)}") from None


def copied(value: Any, path: str) -> Plain:
    """Convert nested mappings and sequences of numbers, strings and booleans to plain data."""
    if is_quantity(value):
        value = magnitude(value, path)
    if isinstance(value, Mapping):
        return {
            text(key, f"{path or 'description'}: the key"): copied(
                item, f"{path}.{key}" if path else key
            )
            for key, item in value.items()
            if item is not None
        }
    if isinstance(value, (str, bool, np.bool_)):
        return text(value, path) if isinstance(value, str) else bool(value)
    if path.rsplit(".", 1)[-1] in _COMPLEX:
        return complex_number(value, path)
    if _is_sequence(value) and not isinstance(value, np.ndarray):
        return [copied(item, f"{path}[{i}]") for i, item in enumerate(value)]
    return nested(value, path)


def nearest(given: str, names: Iterable[str]) -> str:
    """Give the end of a message that suggests the most similar name, or an empty string."""
    from difflib import get_close_matches  # noqa: PLC0415  # only error messages need it

    found = get_close_matches(given, list(names), n=1)
    return f'; did you mean "{found[0]}"?' if found else ""


def one_of(given: object, names: Iterable[str], path: str) -> str:
    """Check that a value is one of the given names."""
    known = list(names)
    if isinstance(given, str) and given in known:
        return given
    near = nearest(given, known) if isinstance(given, str) else ""
    raise SceneError(f"{path}: must be one of {', '.join(known)}, got {shown(given)}{near}")


def nodal(dofs: Sequence[Dof]) -> list[NodalDof]:
    """Give the degrees of freedom of the nodes, which precede those within the elements."""
    return [(shaft, x, direction) for shaft, x, direction in dofs if not isinstance(x, tuple)]


#: Names of other programs and of textbooks, with those of gearbow.
_SYNONYMS = {
    "z": ("teeth",),
    "n_teeth": ("teeth",),
    "m": ("module", "mass"),
    "modul": ("module",),
    "b": ("face_width",),
    "width": ("face_width",),
    "alpha": ("pressure_angle",),
    "pr_angle": ("pressure_angle",),
    "beta": ("helix_angle",),
    "shift": ("profile_shift",),
    "pinion": ("driver",),
    "wheel": ("driven",),
    "gear": ("driven",),
    "od": ("outer_diameter",),
    "odl": ("outer_diameter",),
    "d": ("outer_diameter",),
    "idl": ("inner_diameter",),
    "bore": ("inner_diameter",),
    "l": ("length",),
    "e": ("youngs_modulus",),
    "rho": ("density",),
    "ip": ("polar_inertia",),
    "id": ("diametral_inertia", "inner_diameter"),
    "kxx": ("stiffness",),
    "k": ("stiffness",),
    "cxx": ("damping",),
    "c": ("damping",),
    "stiffness": ("torsional_stiffness",),
    "damping": ("torsional_damping",),
    "rpm": ("speed",),
    "omega": ("speed",),
}

_Call = TypeVar("_Call", bound=Callable[..., Any])


class _Signature:
    """The signature of a class is that of its initialisation."""

    def __get__(self, _: object, owner: type) -> inspect.Signature:
        signature = inspect.signature(owner.__init__)  # type: ignore[misc]  # of a class
        return signature.replace(parameters=list(signature.parameters.values())[1:])


class CheckedMethods:
    """Base of classes whose methods refuse an unknown keyword argument with a suggestion."""

    def __init_subclass__(cls, **given: Any) -> None:
        super().__init_subclass__(**given)
        for name, value in list(vars(cls).items()):
            if name.startswith("_"):
                continue
            if isinstance(value, FunctionType):
                setattr(cls, name, checked(value))
            elif isinstance(value, classmethod | staticmethod):
                setattr(cls, name, type(value)(checked(value.__func__)))


class CheckedKeywords(CheckedMethods):
    """Base of classes that refuse an unknown keyword argument with a suggestion."""

    # Without it, the signature of `__new__` would hide that of `__init__`.
    __signature__: Any = _Signature()

    def __new__(cls, *_: Any, **given: Any) -> "Self":
        _check_class(cls, given)
        return super().__new__(cls)


def checked(function: _Call) -> _Call:
    """Let a function refuse an unknown keyword argument with a suggestion."""
    code = inspect.unwrap(function).__code__
    first = code.co_posonlyargcount
    names = code.co_varnames[first : code.co_argcount + code.co_kwonlyargcount]
    names = tuple(name for name in names if name not in ("self", "cls"))
    if not names or code.co_flags & inspect.CO_VARKEYWORDS:
        return function

    @wraps(function)
    def call(*args: Any, **given: Any) -> Any:
        if given:
            _check(function.__name__, names, given)
        return function(*args, **given)

    return call  # type: ignore[return-value]  # it has the parameters of the function


def _check(where: str, names: Iterable[str], given: Mapping[str, object]) -> None:
    """Refuse a keyword argument that a class or a function does not have."""
    for name in given:
        if name not in names:
            raise TypeError(
                f"{where}: has no parameter {name!r}, got {name}={shown(given[name])}"
                f"{_hint(name, tuple(names))}"
            )


def _hint(name: str, names: tuple[str, ...]) -> str:
    """Give the end of a message that suggests a name, or lists all of them."""
    known = [own for own in _SYNONYMS.get(name.lower(), ()) if own in names]
    if known:
        return f'; did you mean "{known[0]}"?'
    return nearest(name, names) or "; its parameters are " + ", ".join(names)


def _check_class(cls: type, given: Mapping[str, object]) -> None:
    """Refuse a keyword argument that the initialisation of a class does not have."""
    names = _parameters(cls)
    if names:
        _check(cls.__name__, names, given)


@cache
def _parameters(cls: type) -> tuple[str, ...]:
    """Give the names of the parameters of a class; none if it takes any name."""
    found = inspect.signature(cls).parameters.values()
    if any(parameter.kind is parameter.VAR_KEYWORD for parameter in found):
        return ()
    return tuple(parameter.name for parameter in found)
