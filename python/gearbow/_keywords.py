"""Keyword arguments of classes: a misspelt one is refused with the most similar name."""

import inspect
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from gearbow._convert import shown
from gearbow._lookup import nearest

if TYPE_CHECKING:
    from typing_extensions import Self

__all__ = ["CheckedKeywords"]


class _Signature:
    """The signature of a class is that of its initialisation."""

    def __get__(self, _: object, owner: type) -> inspect.Signature:
        signature = inspect.signature(owner.__init__)  # type: ignore[misc]  # of a class
        return signature.replace(parameters=list(signature.parameters.values())[1:])


class CheckedKeywords:
    """Base of classes that refuse an unknown keyword argument with a suggestion."""

    # Without it, the signature of `__new__` would hide that of `__init__`.
    __signature__: Any = _Signature()

    def __new__(cls, *_: Any, **given: Any) -> "Self":
        _check(cls, given)
        return super().__new__(cls)


def _check(cls: type, given: Mapping[str, object]) -> None:
    """Refuse a keyword argument that the class does not have.

    It is a `TypeError`, as for every function of Python, whose own message has no suggestion.
    """
    names = _parameters(cls)
    unknown = [name for name in given if name not in names] if names else []
    if unknown:
        name = unknown[0]
        raise TypeError(
            f"{cls.__name__}: has no parameter {name!r}, got {name}={shown(given[name])}"
            f"{nearest(name, names) or '; its parameters are ' + ', '.join(names)}"
        )


@cache
def _parameters(cls: type) -> tuple[str, ...]:
    """Give the names of the parameters of a class; none if it takes any name."""
    found = inspect.signature(cls).parameters.values()
    if any(parameter.kind is parameter.VAR_KEYWORD for parameter in found):
        return ()
    return tuple(parameter.name for parameter in found)
