"""Look up names, suggest similar ones, and refuse misspelt keyword arguments."""

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, wraps
from types import FunctionType
from typing import TYPE_CHECKING, Any, TypeVar

from gearbow._convert import shown
from gearbow._types import Dof, NodalDof
from gearbow.errors import SceneError

if TYPE_CHECKING:
    from typing_extensions import Self


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
