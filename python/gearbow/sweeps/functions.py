"""Identity of a function: what a stored sweep must have in common with the call that resumes it.

The identity is the digest of the bytecode, of the default values, and of what the function refers
to: variables of enclosing functions, global values, and functions of its own module. Functions of
other modules and classes are not examined.
"""

import functools
import hashlib
import types
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from gearbow.errors import GearbowError


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
