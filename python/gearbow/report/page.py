"""A report as a page: blocks of text, tables and figures, in one HTML file without links to others.

A figure is both an interactive one of plotly, whose script the page contains once, and an image. A
reader without scripts and a printer see the image.
"""

from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from gearbow._extras import extra
from gearbow._files import printable, replacing
from gearbow._result import Column, Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Resolution of an image in three dimensions [1/in]; the others are vector graphics.
_RESOLUTION = 110


@dataclass(frozen=True)
class Note:
    """A paragraph; one that a reader must not overlook is a warning."""

    text: str
    warning: bool = False
    kind = "note"


@dataclass(frozen=True)
class Code:
    """Lines of a program or file, behind a heading that opens them."""

    title: str
    text: str
    file: str | None = None
    kind = "code"

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
        cells = [column.cells(range(count)) for column in columns]
        head, *rows = zip(*cells, strict=True)
        return cls(title, head, rows, remarks, [not column.is_text for column in columns])

    @classmethod
    def of_result(cls, result: Result, title: str | None = None) -> "Table":
        """Make a table of a result, with its heading and remarks."""
        with result._showing():
            first, *others = [*([] if title is None else [title]), *result._heading()]
            remarks = [*others, *result._remarks(), *result._left_out()]
            return cls.of(first[:1].upper() + first[1:], result._columns(), remarks)


@dataclass(frozen=True)
class Picture:
    """A figure: its caption, an image, and the interactive figure as JSON of plotly."""

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
        from plotly.io.json import to_json_plotly  # noqa: PLC0415

        from gearbow.plotting.interactive import WIDTH, converted  # noqa: PLC0415

    stream = BytesIO()
    given = space or converted(figure, stream)
    if space is not None:
        figure.savefig(stream, format="png", dpi=_RESOLUTION)
    kind = "svg+xml" if space is None else "png"
    image = f"data:image/{kind};base64,{b64encode(stream.getvalue()).decode()}"
    layout = given["layout"]
    # A "</" would end the element of the page.
    text = to_json_plotly(given).replace("</", "<\\/")
    size = (float(layout["width"]), float(layout["height"]))
    return Picture(caption, image, text, size, 100.0 * size[0] / WIDTH)


def write(
    path: Path, title: str, facts: Sequence[tuple[str, str]], sections: Sequence[Section]
) -> None:
    """Write the page."""
    with extra("report"):
        import jinja2  # noqa: PLC0415
        from plotly.offline import get_plotlyjs  # noqa: PLC0415

    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    template = files(__package__).joinpath("page.html").read_text("utf-8")
    text = environment.from_string(template).render(
        title=title, facts=facts, sections=sections, script=get_plotlyjs()
    )
    with replacing(path) as file:
        file.write(printable(text).encode())
