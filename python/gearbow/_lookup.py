"""Look up names, and suggest similar ones."""

from collections.abc import Iterable, Sequence

from gearbow._convert import shown
from gearbow._types import Dof, NodalDof
from gearbow.errors import SceneError


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
