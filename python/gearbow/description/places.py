"""Places: names, positions on shafts and meshes, found among known ones."""

import numbers
import re
from collections.abc import Container, Iterable, Mapping, Sequence
from typing import Any

from gearbow._convert import BYTES, real, shown
from gearbow.description.supports import Housing, Support
from gearbow.errors import ChannelError, SceneError
from gearbow.units.values import is_quantity

#: Positions with a smaller difference [m], or relative to a position above 1 m, are equal.
_SAME_POSITION = 1e-9
#: Forms of a place, by what is there.
_FORMS = {
    "item": "a name or a tuple such as (shaft, position)",
    "place": "a name or (shaft, position)",
    "bearing": "(shaft, position)",
    "mesh": '(driver, driven) or "driver/driven"',
}


class Places:
    """Known places, each with all its forms: names, (shaft, position) or (driver, driven)."""

    def __init__(self, kind: str, known: Iterable[Sequence[Any]]) -> None:
        self.kind = kind
        self.known = [tuple(forms) for forms in known]
        self._named: dict[Any, int] = {}
        self._along: dict[str, list[tuple[float, int]]] = {}
        for i, forms in enumerate(self.known):
            for form in forms:
                if is_place(form):
                    self._along.setdefault(form[0], []).append((float(form[1]), i))
                    continue
                self._named.setdefault(form, i)
                if is_pair(form):
                    self._named.setdefault(form[::-1], i)

    def find(self, at: object, path: str = "at") -> int | None:
        """Give the index of a place; None if it is none of the known ones."""
        wanted = place(at, path, self.kind)
        if not is_place(wanted):
            return self._named.get(wanted)
        position = wanted[1]
        for x, i in self._along.get(wanted[0], ()):
            if abs(x - position) <= _SAME_POSITION * max(1.0, abs(x)):
                return i
        return None

    def index(self, at: object, what: str = "") -> int:
        """Give the index of a known place; `what` is its name in the error if there is none."""
        found = self.find(at)
        if found is None:
            where = place(at)
            named = f"of {where[0]!r} with {where[1]!r}" if is_pair(where) else f"at {where}"
            raise ChannelError(f"at: no {what or self.kind} {named}; there are {self}")
        return found

    @classmethod
    def of(cls, kind: str, known: Iterable[Sequence[Any]]) -> "Places":
        """Make known places of one form each."""
        return cls(kind, ([tuple(each)] for each in known))

    def positions(self, shaft: str) -> list[float]:
        """Give the known positions on a shaft [m]."""
        return [x for x, _ in self._along.get(shaft, ())]

    def __str__(self) -> str:
        return ", ".join(repr(forms[-1]) for forms in self.known) or "none"


def place(at: object, path: str = "at", kind: str = "item") -> Any:
    """Convert a name, (shaft, position), a mesh or another recorded item to plain Python."""
    found: Any = None
    if isinstance(at, str):
        driver, slash, driven = at.partition("/")
        found = (driver, driven) if slash else at
    elif isinstance(at, (tuple, list)) and len(at) in (2, 3) and isinstance(at[0], str):
        found = tuple(
            item if isinstance(item, str) else real(item, f"{path}[{i}]", "a name or a number")
            for i, item in enumerate(at)
        )
    suits = {
        "item": found is not None,
        "place": isinstance(found, str) or is_place(found),
        "bearing": is_place(found),
        "mesh": is_pair(found),
    }
    if not suits[kind]:
        raise SceneError(f"{path}: must be {_FORMS[kind]}, got {shown(at)}")
    return found


def is_place(at: object) -> bool:
    """Return whether this is (shaft, position)."""
    return (
        isinstance(at, tuple)
        and len(at) == 2
        and isinstance(at[0], str)
        and (isinstance(at[1], numbers.Real) or is_quantity(at[1]))
    )


def is_pair(at: object) -> bool:
    """Return whether this is (driver, driven)."""
    return isinstance(at, tuple) and len(at) == 2 and all(isinstance(name, str) for name in at)


def places(given: object, path: str = "at", kind: str = "place") -> tuple[Any, ...]:
    """Convert one place, or several."""
    if isinstance(given, str) or is_place(given) or (is_pair(given) and kind == "mesh"):
        return (place(given, path, kind),)
    if not isinstance(given, Iterable) or isinstance(given, (Mapping, *BYTES)):
        raise SceneError(f"{path}: must be a list of names or tuples, got {shown(given)}")
    found = tuple(place(at, f"{path}[{i}]", kind) for i, at in enumerate(given))
    if not found:
        raise SceneError(f"{path}: must name at least one gear, disk or (shaft, position)")
    return found


def place_label(at: str | tuple[str, float]) -> str:
    """Give the label of a place in figures, e.g. "rotor at 0.5 m"."""
    return at if isinstance(at, str) else f"{at[0]} at {at[1]:g} m"


def names_of_bases(own: Iterable[object], *listed: Support | Housing) -> list[str]:
    """Give the names of what bearings stand on: their own supports, and those that are listed."""
    bases = [*listed, *(base for base in own if isinstance(base, Support))]
    return [base.name for base in bases if base.name is not None]


def cleaned(name: str) -> str:
    """Replace what names of gearbow do not contain: "/" and ":"."""
    return re.sub("[/:]", "-", name)


def unique(name: str, number: int, taken: Container[str]) -> str:
    """Clean a name, and add the number of its component if another part has it."""
    found = cleaned(name)
    return f"{found} [{number}]" if found in taken else found
