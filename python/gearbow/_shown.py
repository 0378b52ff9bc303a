"""Short representations of public objects, one line and a table in HTML, and read-only results.

No representation contains an array: an array is its shape and its range. A class with more to say
overrides `_facts`, which both forms show, or `_rows`, the table in HTML.
"""

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from gearbow._convert import CheckedMethods

T = TypeVar("T")

#: Largest number of rows of a table, and of values in a list.
MOST_ROWS = 10
#: Longest representation, and longest value in it.
_LONGEST, _LONGEST_VALUE = 300, 80
#: Rows and columns of a table; the first row has the headings.
Table = Sequence[Sequence[str]]


def short(value: Any) -> str:
    """Format a value without arrays and long lists."""
    if isinstance(value, bool | np.bool_ | int | np.integer | None):
        return str(value)
    if isinstance(value, float | complex | np.floating | np.complexfloating):
        text = repr(value.item() if isinstance(value, np.generic) else value)
        return text if len(text) <= 10 else f"{value:.6g}"
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, str):
        return _cut(repr(value))
    if isinstance(value, Mapping):
        items = [f"{key!r}: {short(item)}" for key, item in value.items()]
        return _within("{", items, "}", f"{len(items)} entries")
    if isinstance(value, list | tuple):
        return _within("(", [short(item) for item in value], ")", f"{len(value)} entries")
    if callable(value):
        return str(getattr(value, "__qualname__", type(value).__name__))
    text = repr(value)
    return text if len(text) <= _LONGEST_VALUE else f"{type(value).__name__}(...)"


def _array(values: Any) -> str:
    if values.ndim > 0 and values.size <= 4:
        return (
            f"[{', '.join(_array(v) if v.ndim else short(v[()]) for v in map(np.asarray, values))}]"
        )
    shape = " × ".join(str(length) for length in values.shape)
    if values.ndim == 1 and values.dtype.kind in "iuf":
        return f"[{values.size} values, {span(values)}]"
    return f"[{shape} values]"


def span(values: Any) -> str:
    """Give the smallest and the largest value of real numbers."""
    known = values[np.isfinite(values)]
    if not known.size:
        return "none finite"
    low, high = float(known.min()), float(known.max())
    return f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"


def listed(values: Any, form: str = ".4g") -> str:
    """List the first numbers."""
    first = ", ".join(f"{value:{form}}" for value in values[:MOST_ROWS])
    return f"{first}, …" if len(values) > MOST_ROWS else first


def _within(begin: str, items: list[str], end: str, count: str) -> str:
    text = f"{begin}{', '.join(items)}{end}"
    return text if len(text) <= _LONGEST_VALUE else f"{begin}{count}{end}"


def _cut(text: str, longest: int = _LONGEST_VALUE) -> str:
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def to_html(title: str, rows: Table) -> str:
    """Format a title and the first rows of a table in HTML."""
    from html import escape  # noqa: PLC0415  # only notebooks need it

    head, *rest = rows
    lines = [f"<p><code>{escape(title)}</code></p>", "<table>"]
    for tag, row in [("th", head), *(("td", row) for row in rest[:MOST_ROWS])]:
        cells = "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in row)
        lines.append(f"<tr>{cells}</tr>")
    if len(rest) > MOST_ROWS:
        lines.append(f'<tr><td colspan="{len(head)}">… {len(rest)} rows</td></tr>')
    return "\n".join([*lines, "</table>"])


class Shown(CheckedMethods):
    """Base of public objects with a short representation and a table in notebooks."""

    def __init_subclass__(cls, **given: Any) -> None:
        super().__init_subclass__(**given)
        # A dataclass writes its own representation, with whole arrays, unless the class has one.
        if "__repr__" not in vars(cls):
            cls.__repr__ = cls.__repr__  # type: ignore[method-assign]

    def _facts(self) -> dict[str, str]:
        """Give the fields that differ from their defaults, as short texts."""
        found = {}
        for field in getattr(self, "__dataclass_fields__", {}).values():
            value = getattr(self, field.name)
            default = field.default_factory() if callable(field.default_factory) else field.default
            same = type(value) is type(default) and not isinstance(value, np.ndarray)
            if field.repr and not (value is default or (same and value == default)):
                found[field.name] = short(value)
        return found

    def _rows(self) -> Table:
        """Give the rows of the table in HTML, the headings first."""
        return (("", ""), *self._facts().items())

    def __repr__(self) -> str:
        facts = ", ".join(f"{name}={value}" for name, value in self._facts().items())
        return f"{type(self).__name__}({_cut(facts, _LONGEST)})"

    def _repr_html_(self) -> str:
        return to_html(repr(self), self._rows())


def read_only(data: T) -> T:
    """Make all arrays in (nested) mappings and sequences read-only, and return the data."""
    if isinstance(data, np.ndarray):
        data.setflags(write=False)
    elif isinstance(data, Mapping | list | tuple):
        for value in data.values() if isinstance(data, Mapping) else data:
            # The description of an elastic housing has thousands of numbers.
            if not isinstance(value, float):
                read_only(value)
    return data


class ReadOnly(Shown):
    """Base of every result that holds arrays: they are read-only, also in copies and pickles."""

    def __post_init__(self) -> None:
        read_only(vars(self))

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(read_only(state))
