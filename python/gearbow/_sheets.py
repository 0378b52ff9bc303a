"""Tables as files: CSV, and Excel (.xlsx, Office Open XML, ECMA-376) without formulas."""

import math
import zipfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any
from xml.sax.saxutils import escape

from gearbow._files import printable, replacing
from gearbow.errors import GearbowError

if TYPE_CHECKING:
    import pandas as pd

#: Largest numbers of rows and columns of a sheet of Excel, from its specification; one row has the
#: headings.
_ROWS, _COLUMNS = 1_048_576, 16_384
#: Most characters of a cell, from the same specification.
_LONGEST_CELL = 32_767
#: First characters of a text that a program for tables takes as a formula.
_FORMULA = tuple("=+-@\t\r")
#: Rows that are put together at a time.
_CHUNK = 4096
_MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
_OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
_TYPE = "application/vnd.openxmlformats-officedocument.spreadsheetml"
_XML = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
_SHEET = "xl/worksheets/sheet1.xml"
#: Parts of a workbook with one sheet.
_PARTS = {
    "[Content_Types].xml": f'<Types xmlns="{_PACKAGE}/content-types"><Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    f'<Override PartName="/xl/workbook.xml" ContentType="{_TYPE}.sheet.main+xml"/>'
    f'<Override PartName="/{_SHEET}" ContentType="{_TYPE}.worksheet+xml"/></Types>',
    "_rels/.rels": f'<Relationships xmlns="{_PACKAGE}/relationships"><Relationship Id="rId1" '
    f'Type="{_OFFICE}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
    "xl/workbook.xml": f'<workbook xmlns="{_MAIN}" xmlns:r="{_OFFICE}"><sheets>'
    '<sheet name="Sheet1" sheetId="1" r:id="rId1"/></sheets></workbook>',
    "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{_PACKAGE}/relationships"><Relationship '
    f'Id="rId1" Type="{_OFFICE}/worksheet" Target="worksheets/sheet1.xml"/></Relationships>',
}


def save_table(frame: "pd.DataFrame", path: Path, ending: str) -> None:
    """Write a table without its index as ".csv" or ".xlsx"."""
    with replacing(path) as file:
        if ending == ".csv":
            file.write(_csv(frame))
        else:
            _write_sheet(frame, file)


def _csv(frame: "pd.DataFrame") -> bytes:
    """Give a table as CSV; a text that would be a formula begins with an apostrophe."""
    plain = frame.copy()
    for name in plain.columns:
        if plain[name].dtype.kind not in "biufc":
            plain[name] = plain[name].map(_without_formula)
    plain.columns = [_without_formula(str(name)) for name in plain.columns]
    return str(plain.to_csv(index=False)).encode()


def _without_formula(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    text = printable(value)
    if text.startswith(_FORMULA):
        try:
            complex(text)
        except ValueError:
            return f"'{text}"
    return text


def _write_sheet(frame: "pd.DataFrame", file: IO[bytes]) -> None:
    """Write a table as the only sheet of a workbook: numbers as numbers, texts as texts."""
    if len(frame) >= _ROWS or frame.shape[1] > _COLUMNS:
        raise GearbowError(
            f"path: a sheet of Excel has at most {_ROWS} rows and {_COLUMNS} columns, but this "
            f"table has {len(frame)} and {frame.shape[1]}; give .csv or .nc"
        )
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, text in _PARTS.items():
            archive.writestr(_entry(name), _XML + text)
        with archive.open(_entry(_SHEET), "w", force_zip64=True) as sheet:
            sheet.write(f'{_XML}<worksheet xmlns="{_MAIN}"><sheetData>'.encode())
            sheet.write(_row(map(_cell, map(str, frame.columns))).encode())
            for begin in range(0, len(frame), _CHUNK):
                part = frame.iloc[begin : begin + _CHUNK]
                columns = [map(_cell, part.iloc[:, i].tolist()) for i in range(part.shape[1])]
                sheet.write("".join(_rows(columns)).encode())
            sheet.write(b"</sheetData></worksheet>")


def _entry(name: str) -> zipfile.ZipInfo:
    """Give a member of the archive, without the time of writing."""
    entry = zipfile.ZipInfo(name)
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry


def _rows(columns: Iterable[Iterator[str]]) -> Iterator[str]:
    return map(_row, zip(*columns, strict=True))


def _row(cells: Iterable[str]) -> str:
    return f"<row>{''.join(cells)}</row>"


def _cell(value: Any) -> str:
    """Give a cell; NaN is empty, and what is neither number nor text a text."""
    if isinstance(value, bool):
        return f'<c t="b"><v>{value:d}</v></c>'
    if isinstance(value, int | float) and math.isfinite(value):
        return f"<c><v>{value!r}</v></c>"
    if value is None or value != value:  # noqa: PLR0124  # NaN
        return "<c/>"
    text = escape(printable(str(value))[:_LONGEST_CELL])
    return f'<c t="inlineStr"><is><t xml:space="preserve">{text}</t></is></c>'
