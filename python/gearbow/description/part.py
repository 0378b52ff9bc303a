"""Conversion of the parts of a user to the plain description of the core, and back.

This module makes no physical checks: the core checks the values. Only an object of the wrong class
is detected here. It raises a `SceneError` with its path, as all other errors do.
"""

import dataclasses
import types
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import CheckedKeywords, complex_number, nested, real, shown, text, truth
from gearbow._shown import Shown
from gearbow._types import Plain
from gearbow.errors import SceneError
from gearbow.units.fields import has_quantity, is_quantity, magnitude, quantities_exist

P = TypeVar("P", bound="Part")


class Part(CheckedKeywords, Shown):
    """Base of every dataclass that describes a piece of a system."""

    def _describe(self, path: str) -> dict[str, Plain]:
        """Give the fields that differ from their default as plain data."""
        given = {}
        kinds = _kinds(type(self))  # type: ignore[arg-type]  # classes have hashes
        for field in dataclasses.fields(self):  # type: ignore[arg-type]  # every Part is a dataclass
            value, allowed = getattr(self, field.name), kinds[field.name]
            same = isinstance(value, complex) and value == field.default
            if value is None or (same and float not in allowed and int not in allowed):
                continue
            found = _read(value, allowed, f"{path}.{field.name}")
            make = field.default_factory
            default = make() if callable(make) else field.default
            if isinstance(default, Part) and isinstance(found, dict):
                default = default._describe(f"{path}.{field.name}")
            if tuples(found) != default:
                given[field.name] = found
        return given

    def _in_si(self: P, path: str) -> P:
        """Replace quantities of pint by numbers in SI units; a part without any is the same."""
        if not quantities_exist():
            return self
        fields = dataclasses.fields(self)  # type: ignore[arg-type]  # every Part is a dataclass
        given = {field.name: getattr(self, field.name) for field in fields}
        found = {name: _in_si(value, f"{path}.{name}") for name, value in given.items()}
        changes = {name: value for name, value in found.items() if value is not given[name]}
        return dataclasses.replace(self, **changes) if changes else self  # type: ignore[type-var]

    @classmethod
    def _from_description(cls: type[P], description: Mapping[str, Plain]) -> P:
        """Make the part, or the subclass with the given fields, from its plain description."""
        part = _fitting((cls, *cls.__subclasses__()), description)
        kinds = _kinds(part)  # type: ignore[arg-type]  # classes have hashes
        given = {name: _made(value, kinds.get(name, ())) for name, value in description.items()}
        return part(**given)


@cache
def _kinds(part: type[Part]) -> dict[str, tuple[Any, ...]]:
    """Give the types that each field of a part may have."""
    unions = (Union, types.UnionType)
    given = {
        field: _members(hint) if get_origin(hint) in unions else (hint,)
        for field, hint in get_type_hints(part).items()
    }
    # The core checks which texts a field may have: a type with some texts is a text.
    return {
        field: tuple(str if get_origin(kind) is Literal else kind for kind in kinds)
        for field, kinds in given.items()
    }


def _members(union: Any) -> tuple[Any, ...]:
    """Give the members of a union; `ArrayLike`, which is itself a union, counts as one member."""
    members, arrays = get_args(union), get_args(ArrayLike)
    # From NumPy 2.5 on, `ArrayLike` is a name of its own, which is a member as it is.
    if arrays and set(arrays) <= set(members):
        return (ArrayLike, *(member for member in members if member not in arrays))
    return members


def _read(value: object, kinds: tuple[Any, ...], path: str) -> Plain:
    """Convert the value of a field to plain data."""
    parts_allowed = _classes(kinds)
    if isinstance(value, Part) and parts_allowed:
        return expect(value, parts_allowed[0], path)._describe(path)
    if ArrayLike in kinds:
        return nested(value, path)
    tuples_allowed = (get_args(kind) for kind in kinds if get_origin(kind) is tuple)
    forms = [form for form in tuples_allowed if form[0] is str]
    if forms and not isinstance(value, str):
        return _read_place(value, forms, path)
    named = _type_of_named(kinds)
    if named is not None:
        return _read_named(value, named, path)
    if str in kinds and (isinstance(value, str) or float not in kinds):
        return text(value, path)
    if float in kinds or int in kinds:
        wanted = [f"or a gb.{kind.__name__}" for kind in parts_allowed]
        return real(value, path, " ".join(["a number", *wanted]))
    if complex in kinds:
        return complex_number(value, path)
    if bool in kinds:
        return truth(value, path)
    if parts_allowed:
        return expect(value, parts_allowed[0], path)._describe(path)
    entry = _class_of_entries(kinds)
    if entry is None:
        return nested(value, path)
    return [part._describe(f"{path}[{i}]") for i, part in enumerate(parts(value, entry, path))]


def _made(value: Plain, kinds: tuple[Any, ...]) -> Any:
    """Convert plain data to the value of a field, the inverse of `_read`."""
    if isinstance(value, Mapping):
        classes = _classes(kinds)
        if classes:
            return made(classes, value)
        named = _type_of_named(kinds)
        return {key: _made(tuples(one), (named,)) for key, one in value.items()}
    if not isinstance(value, list | tuple):
        return value
    if complex in kinds:
        return complex(*value)
    if any(get_origin(kind) is tuple for kind in kinds):
        return tuples(value)
    entry = _class_of_entries(kinds)
    return value if entry is None else tuple(map(entry._from_description, value))


def made(classes: Sequence[type[P]], description: Mapping[str, Plain]) -> P:
    """Make the part that has all fields of a plain description, of the first fitting class."""
    return _fitting(classes, description)._from_description(description)


def _fitting(classes: Sequence[type[P]], description: Mapping[str, Plain]) -> type[P]:
    """Choose the class that has all fields of a plain description."""
    names = description.keys()
    fitting = (one for one in classes if names <= one.__dataclass_fields__.keys())  # type: ignore[attr-defined]
    return next(fitting, classes[0])


def _classes(kinds: Iterable[Any]) -> list[type[Part]]:
    """Give the parts among the types of a field."""
    return [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Part)]


def _class_of_entries(kinds: Iterable[Any]) -> type[Part] | None:
    """Give the class of the entries of a field that is a sequence of parts."""
    entries = [get_args(kind)[0] for kind in kinds if get_origin(kind) is Sequence]
    return next(iter(_classes(entries)), None)


def _type_of_named(kinds: Iterable[Any]) -> Any:
    """Give the type of the values of a field that is a mapping by name; None for another field."""
    return next((get_args(kind)[1] for kind in kinds if get_origin(kind) is Mapping), None)


def _read_named(value: object, kind: Any, path: str) -> dict[str, Plain]:
    """Convert a mapping by name."""
    if not isinstance(value, Mapping):
        raise SceneError(f"{path}: must be a dict by name, got {shown(value)}")
    return {text(key, path): _read(one, (kind,), f"{path}.{key}") for key, one in value.items()}


def _read_place(value: object, forms: Sequence[tuple[Any, ...]], path: str) -> list[Plain]:
    """Convert (shaft, position) or (housing, interface) to the entries of one of the forms."""
    if not isinstance(value, tuple | list) or len(value) != len(forms[0]):
        raise SceneError(
            f"{path}: must be a name or a tuple such as (shaft, position), got {shown(value)}"
        )
    is_text = isinstance(value[1], str)
    form = next((one for one in forms if (one[1] is str) == is_text), forms[0])
    pairs = enumerate(zip(value, form, strict=True))
    return [(text if kind is str else real)(item, f"{path}[{i}]") for i, (item, kind) in pairs]


def _in_si(value: Any, path: str) -> Any:
    """Convert the quantities in the value of a field; a value without any is the same."""
    if is_quantity(value):
        return _plain(magnitude(value, path))
    if isinstance(value, Part):
        return value._in_si(path)
    if isinstance(value, Mapping):
        items = {key: _in_si(item, f"{path}.{key}") for key, item in value.items()}
        return value if all(items[key] is item for key, item in value.items()) else items
    if isinstance(value, list | tuple):
        entries = tuple(_in_si(item, f"{path}[{i}]") for i, item in enumerate(value))
        same = all(new is old for new, old in zip(entries, value, strict=True))
        return value if same else entries
    return value


def _plain(value: Any) -> Any:
    """Give arrays as nested tuples, and NumPy scalars as numbers."""
    return tuples(value.tolist()) if isinstance(value, np.ndarray | np.generic) else value


def freeze(part: Part, *names: str) -> None:
    """Convert sequences in the named fields of a part to tuples, so that they compare and hash."""
    for field in names:
        value = getattr(part, field)
        if value is not None and not has_quantity(value):
            object.__setattr__(part, field, tuples(nested(value, field)))


def tuples(value: Plain) -> Plain:
    """Convert nested lists and tuples to nested tuples."""
    # The core reports an invalid value that is not a list, with its path.
    return tuple(tuples(item) for item in value) if isinstance(value, list | tuple) else value


def expect(value: object, kind: type[P], path: str, *others: type[P]) -> P:
    """Return the value if it has one of the expected classes; raise an error otherwise."""
    if not isinstance(value, (kind, *others)):
        wanted = " or ".join(f"gb.{one.__name__}" for one in (kind, *others))
        raise SceneError(f"{path}: must be a {wanted}, got {shown(value)}")
    return cast("P", value)


def parts(given: object, kind: type[P], path: str, *others: type[P]) -> tuple[P, ...]:
    """Collect a list of parts of one class, or of some classes."""
    if isinstance(given, (str, bytes, Mapping)) or not isinstance(given, Iterable):
        remedy = "; put it in brackets" if isinstance(given, Part) else ""
        raise SceneError(
            f"{path}: must be a list of gb.{kind.__name__}, got {shown(given)}{remedy}"
        )
    return tuple(expect(part, kind, f"{path}[{i}]", *others) for i, part in enumerate(given))
