"""A report as a page: its language, texts, tables of results, and figures, in one HTML file.

Every text is English, with the German one in `german.toml`: `say` writes a sentence of the report,
and `word` a text that a result or a figure brings along. A figure is both an interactive one of
plotly, whose script the page contains once, and an image. A reader without scripts and a printer
see the image.
"""

import cmath
import gzip
import math
import re
import sys
from base64 import b64encode
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from gearbow._extras import extra
from gearbow._files import printable, replacing
from gearbow._result import Column, Result
from gearbow._shown import short
from gearbow._types import Language
from gearbow.units.fields import DIMENSIONLESS, unit_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Columns whose texts are words of the program, not names of the user.
_WORDED = (
    *("shaft", "whirl", "verdict", "within", "largest motion", "excited by", "limit", "why"),
    *("place", "at", "signal", "bearing", "side", "notch", "planes", "quantity", "largest order"),
    *("response", "rating"),
)
#: Resolution of an image of pixels [1/in], 190 on paper.
_RESOLUTION = 110
#: Number of points of curves above which a vector graphic is larger than an image of pixels, which
#: has 50 to 150 kB.
_DENSE_POINTS = 2_000


@dataclass(frozen=True)
class Note:
    """A paragraph; one that a reader must not overlook is a warning."""

    text: str
    warning: bool = False
    kind = "note"


def note(text: str, /, *, warning: bool = False, **values: Any) -> Note:
    """Write a paragraph in the language of the report, with values in its places."""
    return Note(say(text, **values), warning)


@dataclass(frozen=True)
class Code:
    """Lines of a program or file, behind a heading that opens them."""

    title: str
    text: str
    file: str | None = None
    kind = "code"

    @property
    def label(self) -> str:
        """What the link to save the file says."""
        return say("save as {file}", file=self.file)

    @property
    def link(self) -> str:
        """The text as the address of a file to save."""
        return f"data:text/plain;base64,{b64encode(self.text.encode()).decode()}"


@dataclass(frozen=True)
class Table:
    """A table of texts with a heading."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    remarks: Sequence[str] = ()
    numeric: Sequence[bool] = ()
    kind = "table"

    @classmethod
    def of(
        cls,
        title: str,
        columns: Sequence[Column],
        remarks: Sequence[str] = (),
    ) -> "Table":
        """Make a table of columns with units."""
        count = len(columns[0].values) if columns else 0
        cells = []
        for column in columns:
            heading, *own = column.cells(range(count))
            cells.append([word(heading), *(map(word, own) if column.name in _WORDED else own)])
        head, *rows = zip(*cells, strict=True)
        return cls(title, head, rows, remarks, [not column.is_text for column in columns])

    @classmethod
    def of_result(cls, result: Result, title: str, numbers: Sequence[int] | None = None) -> "Table":
        """Make a table of a result with its remarks, and with other numbers of its modes."""
        with result._showing():
            columns = [
                replace(column, values=[numbers[i - 1] for i in column.values])
                if numbers is not None and column.name == "mode"
                else column
                for column in result._columns()
            ]
            remarks = [word(text) for text in (*result._remarks(), *result._left_out())]
            return cls.of(title, columns, remarks)


@dataclass(frozen=True)
class Picture:
    """A figure: its caption, an image, and the interactive figure as packed JSON of plotly."""

    caption: str
    image: str
    interactive: str
    #: Width and height of the interactive figure [px].
    size: tuple[float, float]
    #: Width of the figure relative to that of the page [%].
    width: float
    kind = "picture"


Block: TypeAlias = Note | Code | Table | Picture


@dataclass
class Section:
    """A section of a report."""

    name: str
    title: str
    blocks: list[Block] = field(default_factory=list)


def picture(figure: "Figure", caption: str, *, space: dict[str, Any] | None = None) -> Picture:
    """Make a picture of a figure of matplotlib, or of it and an interactive one in space."""
    with extra("report"):
        from matplotlib.text import Text  # noqa: PLC0415
        from matplotlib.ticker import FixedLocator, FuncFormatter  # noqa: PLC0415
        from plotly.io.json import to_json_plotly  # noqa: PLC0415

        from gearbow.plotting.interactive import WIDTH, converted, write_png  # noqa: PLC0415

    for text in figure.findobj(Text) if language() != "en" else ():
        text.set_text(word(text.get_text()))
    for panel in figure.axes if language() != "en" else ():
        for axis in (panel.xaxis, panel.yaxis):
            places = axis.get_major_locator()
            # Names of ticks are written again at each drawing.
            if isinstance(places, FixedLocator) and isinstance(
                axis.get_major_formatter(), FuncFormatter
            ):
                names = [word(text.get_text()) for text in axis.get_ticklabels()]
                axis.set_ticks(axis.get_majorticklocs(), names)
    stream = BytesIO()
    lines = [line for panel in figure.axes for line in panel.lines]
    dense = sum(np.size(line.get_xdata()) for line in lines) > _DENSE_POINTS
    given = space or converted(figure, stream, _RESOLUTION if dense else None)
    if space is not None:
        write_png(figure, stream, _RESOLUTION)
    kind = "png" if dense or space is not None else "svg+xml"
    image = f"data:image/{kind};base64,{b64encode(stream.getvalue()).decode()}"
    layout = given["layout"]
    size = (float(layout["width"]), float(layout["height"]))
    return Picture(caption, image, _packed(to_json_plotly(given)), size, 100.0 * size[0] / WIDTH)


def _packed(text: str) -> str:
    """Compress a text that a script of the page reads."""
    return b64encode(gzip.compress(text.encode(), mtime=0)).decode()


@cache
def _script() -> str:
    """Give the script of plotly, which is the same on every page."""
    from plotly.offline import get_plotlyjs  # noqa: PLC0415

    return _packed(get_plotlyjs())


def write(
    path: Path, title: str, facts: Sequence[tuple[str, str]], sections: Sequence[Section]
) -> None:
    """Write the page."""
    with extra("report"):
        import jinja2  # noqa: PLC0415

    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    template = files(__package__).joinpath("page.html").read_text("utf-8")
    text = environment.from_string(template).render(
        title=title,
        facts=facts,
        sections=sections,
        script=_script(),
        language=language(),
    )
    with replacing(path) as file:
        file.write(printable(text).encode())


#: How a drawing writes quantities in SI units: factor and unit.
_WRITTEN = {
    "m": (1e3, "mm"),
    "rad": (180.0 / math.pi, "°"),
    "kg m": (1e6, "g mm"),
    "Pa": (1e-9, "GPa"),
    "N/m": (1e-6, "N/µm"),
}
#: Fields that are complex: a size and an angle in the shaft.
_TURNING = ("unbalance", "runout")
#: Names of fields that are not those of the table with spaces.
_NAMES = {"youngs_modulus": "Young's modulus", "poisson_ratio": "Poisson's ratio"}
#: Fields with a word of a fixed set.
_WORDS = ("shape", "kind", "model", "phase", "foundation")
#: Largest number of columns of a table of parts.
_COLUMNS = 9
#: Longest list of numbers that a table shows.
_LONGEST = 6


def parts_tables(system: Any) -> list[Table]:
    """Make a table of each kind of part, with the fields that were given."""
    tables, options = [], []
    for key, given in system.description.items():
        if not (isinstance(given, list) and given and isinstance(given[0], Mapping)):
            options.append((word(key.replace("_", " ")), _cell(given, key)))
            continue
        kinds = [type(part).__name__ for part in getattr(system, key)]
        for kind in dict.fromkeys(kinds):
            own = [part for part, its in zip(given, kinds, strict=True) if its == kind]
            words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", kind).lower()
            title = key if len(set(kinds)) == 1 or words == "bearing" else f"{words}s"
            title = word(title if title == key else title.capitalize())
            tables += _parts_tables(title[:1].upper() + title[1:], key, own)
    if options:
        head = (word("option"), word("value"))
        tables.append(Table(word("Options"), head, options, numeric=(False, False)))
    return tables


def _parts_tables(title: str, key: str, given: Sequence[Mapping[str, Any]]) -> list[Table]:
    """Make the table of a kind of part, and one for each list of segments in it."""
    pieces: dict[str, list[dict[str, Any]]] = {}
    plain = []
    for part in given:
        own = dict(part)
        if isinstance(part.get("elastic"), Mapping):
            own["elastic"], interfaces = _elastic(part["elastic"])
            pieces.setdefault("elastic.interfaces", []).extend(
                {"of": part["name"], **each} for each in interfaces
            )
        for name, value in part.items():
            if isinstance(value, list) and value and isinstance(value[0], Mapping):
                rows = [{"of": part.get("name", ""), **one} for one in own.pop(name)]
                pieces.setdefault(name, []).extend(rows)
        plain.append(own)
    tables = [_parts_table(title, key, plain)]
    for name, rows in pieces.items():
        parts = title if language() == "de" else title.lower()
        if name == "elastic.interfaces":
            heading = "Interfaces of elastic housings"
        else:
            heading = f"{name.replace('_', ' ').capitalize()} of {parts}, from left to right"
        heading = word(heading)
        tables.append(_parts_table(heading, f"{key}[0].{name}", rows))
    return tables


def _elastic(body: Mapping[str, Any]) -> tuple[str, list[dict[str, Any]]]:
    """Summarise the modes of an elastic housing, and list its interfaces without their rows."""
    frequencies = np.array(body["frequencies"], dtype=np.float64) / (2.0 * math.pi)
    modes = say(
        "{count} modes up to {highest} kHz",
        count=frequencies.size,
        highest=f"{1e-3 * frequencies.max(initial=0.0):.4g}",
    )
    interfaces = [
        {"interface": name, **{key: value for key, value in given.items() if key != "rows"}}
        for name, given in body["interfaces"].items()
    ]
    return modes, interfaces


def _parts_table(title: str, key: str, given: Sequence[Mapping[str, Any]]) -> Table:
    """Make a table with a row for each part, or with a column for each if it were too wide."""
    fields = list(dict.fromkeys(name for part in given for name in part))
    head = [_heading(f"{key}.{name}", [part.get(name) for part in given]) for name in fields]
    rows = [[_cell(part.get(name), f"{key}.{name}", unit="") for name in fields] for part in given]
    numeric = [any(_is_number(part.get(name)) for part in given) for name in fields]
    if len(fields) <= _COLUMNS or len(given) > _COLUMNS:
        return Table(title, head, rows, numeric=numeric)
    first, *others = zip(head, *rows, strict=True)
    return Table(title, first, others, numeric=[False, *[True] * len(given)])


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | complex) and not isinstance(value, bool)


def _heading(path: str, values: Sequence[Any]) -> str:
    """Write the name of a field, with its unit if a value is a number or a list of numbers."""
    unit = unit_of(path)
    name = word(path.rpartition(".")[2].replace("_", " "))
    plain = any(_is_number(value) or _is_numbers(value) for value in values)
    if not plain or unit in (None, DIMENSIONLESS):
        return name
    return f"{name} [{_written(unit)[1]}]"


def _written(unit: str | None) -> tuple[float, str | None]:
    """Give the factor and the unit of a table."""
    factor, text = _WRITTEN.get(unit or "", (1.0, unit))
    return factor, None if text is None else text.replace("^2", "²").replace("^3", "³")


def _is_place(value: Any) -> bool:
    """Tell whether a value is a shaft and a position on it."""
    given = value if isinstance(value, list | tuple) else ()
    return len(given) == 2 and isinstance(given[0], str) and _is_number(given[1])


def _is_numbers(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return bool(value) and all(_is_number(each) or _is_numbers(each) for each in value)
    return _is_number(value)


def _cell(value: Any, path: str, unit: str | None = None) -> str:
    """Write a value; `unit` "" leaves the unit to the heading."""
    if value is None:
        return ""
    if isinstance(value, bool | np.bool_):
        return word("yes" if value else "no")
    if isinstance(value, Mapping):
        return ", ".join(
            f"{word(_NAMES.get(k, k.replace('_', ' ')))} {_cell(v, f'{path}.{k}')}"
            for k, v in value.items()
        )
    if _is_place(value):
        position = _cell(value[1], "shafts[0].length")
        return word(f"{value[0]} at {position}")
    if isinstance(value, list | tuple):
        if path.endswith(_TURNING) and len(value) == 2:
            number = complex(*value)
            size, angle = _cell(abs(number), path, unit), math.degrees(cmath.phase(number))
            return f"{size} at {angle:.4g}°"
        if len(value) > _LONGEST and _is_numbers(value):
            return short(np.array(value, dtype=np.float64))
        sign = "; " if any(isinstance(each, Mapping) for each in value) else ", "
        cells = [_cell(each, f"{path}[{i}]", unit) for i, each in enumerate(value)]
        nested = any(isinstance(each, list | tuple) for each in value)
        return sign.join(f"({text})" if nested else text for text in cells)
    if not _is_number(value):
        # A word of a fixed set, not a name that the user gave.
        is_word = path.rpartition(".")[2] in _WORDS
        return word(str(value).replace("_", " ")) if is_word else str(value)
    factor, written = _written(unit_of(path))
    digits = 4 if written == "°" else 6
    text = f"{factor * value:.{digits}g}".replace("e+0", "e")
    shown = written if unit is None and written not in (None, DIMENSIONLESS) else unit
    return f"{text}{'' if shown in ('', '°') else ' '}{shown}" if shown else text


if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_language: ContextVar[Language] = ContextVar("language", default="en")
#: Names that the user gave, which are no words.
_names: ContextVar[Collection[str]] = ContextVar("names", default=())


@contextmanager
def speaking(language: Language, names: Collection[str]) -> Iterator[None]:
    """Write texts in a language, and names of the user as they are."""
    tokens = _language.set(language), _names.set(names)
    try:
        yield
    finally:
        _language.reset(tokens[0])
        _names.reset(tokens[1])


def language() -> Language:
    """Give the language of the report that is written."""
    return _language.get()


@cache
def german() -> Mapping[str, dict[str, str]]:
    """Give the German "sentences" of the report and "words" of results by the English ones."""
    text = files(__package__).joinpath("german.toml").read_text("utf-8")
    found: dict[str, dict[str, str]] = tomllib.loads(text)
    return found


def say(text: str, /, **values: Any) -> str:
    """Write a sentence or heading of the report, with values in its places."""
    template = german()["sentences"][text] if language() == "de" else text
    return template.format(**values)


def word(text: str) -> str:
    """Translate a text of a result: words, a name with a unit, or a sentence with values."""
    if language() == "en" or text in _names.get():
        return text
    words = german()["words"]
    if text in words:
        return words[text]
    name, bracket, unit = text.partition(" [")
    if bracket and name in words:
        return f"{words[name]}{bracket}{unit}"
    for pattern, template in _patterns():
        found = pattern.fullmatch(text)
        if found:
            return template.format(**{key: word(value) for key, value in found.groupdict().items()})
    # Lists of motions or orders.
    return ", ".join(map(word, text.split(", "))) if ", " in text else text


@cache
def _patterns() -> tuple[tuple[re.Pattern[str], str], ...]:
    """Give what a text with values looks like, and its translation."""
    found = []
    for text, translation in german()["words"].items():
        if "{" in text:
            parts = re.split(r"\{(\w+)\}", text)
            fixed = [re.escape(part) for part in parts[::2]]
            groups = [f"(?P<{name}>.+?)" for name in parts[1::2]] + [""]
            pairs = zip(fixed, groups, strict=True)
            pattern = "".join(piece for pair in pairs for piece in pair)
            found.append((re.compile(pattern, re.DOTALL), translation))
    return tuple(found)
