"""Results as tables: the one way in which they are printed, converted and saved.

A result gives the columns of its table by `_columns`; `print`, `table`, notebooks, `to_dataframe`
and `save` follow. A result of long series gives a summary there, and the series by `_series`.
"""

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from gearbow._convert import whole
from gearbow._extras import extra
from gearbow._files import check_name, printable
from gearbow._shown import Shown, Table, listed, span, to_html
from gearbow._types import Array
from gearbow.errors import GearbowError
from gearbow.units.speed import SpeedUnit, showing_in, shown_unit, speed_factor, speed_text

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

#: Number of rows that `print` shows.
PRINTED_ROWS = 12
#: Endings of files with the table of a result.
TABLE_ENDINGS = (".csv", ".xlsx", ".nc")


@dataclass(frozen=True)
class Written:
    """How text tables write the numbers of a column: unit, factor, and another name."""

    unit: str
    factor: float
    name: str | None = None


#: Size below which numbers of a table are round-off, relative to the largest.
ROUND_OFF = 1e-9


@dataclass(frozen=True, eq=False)
class Column:
    """A column of a table: a quantity in SI units, or words, with one value for each row."""

    name: str
    values: Sequence[Any] | Any
    unit: str = ""
    form: str = ".4g"
    written: Written | None = None
    #: Size below which text tables write 0 [SI], for each row or for all: round-off says nothing.
    round_off: Any = 0.0

    @property
    def heading(self) -> str:
        """Name and unit in a data frame."""
        return _heading(self.name, self.unit)

    def cells(self, rows: Sequence[int]) -> list[str]:
        """Write the heading and the values of some rows."""
        written = self.written or Written(self.unit, 1.0)
        if self.unit == "rad/s" and self.written is None:
            written = Written(shown_unit(), speed_factor())
        heading = _heading(written.name or self.name, written.unit)
        least = np.broadcast_to(self.round_off, len(self.values))
        return [
            heading,
            *(
                _cell(self._without_round_off(row, least), self.form, written.factor)
                for row in rows
            ),
        ]

    def _without_round_off(self, row: int, least: Any) -> Any:
        """Give a value, or 0 for one that is smaller than the round-off."""
        value = self.values[row]
        if least[row] > 0.0 and abs(value) < least[row]:
            return 0.0
        return value

    @property
    def is_text(self) -> bool:
        """Whether the values are words, which begin at the left."""
        return len(self.values) > 0 and isinstance(self.values[0], str | np.str_)


def in_percent(name: str) -> Written:
    """Write a ratio in percent."""
    return Written("%", 100.0, name)


def in_micrometres(unit: str = "m") -> Written | None:
    """Write displacements in micrometres; quantities with another unit stay the same."""
    return Written("µm", 1e6) if unit == "m" else None


def written_unit(unit: str) -> tuple[float, str]:
    """Give factor and unit in which a quantity is written: displacements in micrometres."""
    written = in_micrometres(unit)
    return (1.0, unit) if written is None else (written.factor, written.unit)


def in_degrees() -> Written:
    """Write an angle in degrees."""
    return Written("°", 180.0 / np.pi)


def _heading(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _cell(value: Any, form: str, factor: float) -> str:
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer) and factor == 1.0:
        return str(value)
    if isinstance(value, float | np.floating | int | np.integer):
        return plain_text(factor * float(value), form)
    return "" if value is None else str(value)


def plain_text(value: float, form: str) -> str:
    """Write a number without the sign of a zero; "–" for an unknown one."""
    if np.isnan(value):
        return "–"
    if np.isinf(value):
        return "∞" if value > 0.0 else "−∞"
    text = f"{value:{form}}"
    if text.endswith(("e+04", "e+05")):
        # 14190 N, not 1.419e+04 N: the digits are those of the format.
        text = f"{float(text):.0f}"
    return text.lstrip("-") if float(text) == 0.0 else text


def data_frame(columns: Sequence[Column], *, indexed: bool = False) -> "pd.DataFrame":
    """Make a data frame of columns; the first one can be its index."""
    with extra("dataframe"):
        import pandas as pd  # noqa: PLC0415

    found = {column.heading: column.values for column in columns}
    index = None
    if indexed:
        name = next(iter(found))
        index = pd.Index(found.pop(name), name=name)
    frame: pd.DataFrame = pd.DataFrame(found, index=index)
    return frame


def _without_complex(frame: "pd.DataFrame") -> "pd.DataFrame":
    """Replace each complex column by one of real and one of imaginary parts."""
    columns: dict[str, Any] = {}
    for name in map(str, frame.columns):
        values = frame[name]
        if values.dtype.kind == "c":
            label, *unit = name.rsplit(" [", 1)
            for part, numbers in (("re", np.real(values)), ("im", np.imag(values))):
                columns[" [".join([f"{label} {part}", *unit])] = numbers
        else:
            columns[name] = values
    found: pd.DataFrame = type(frame)(columns, index=frame.index)
    return found


class Result(Shown):
    """Base of results with a table."""

    #: Endings of files that hold the complete result, which `load` reads.
    _own_endings: ClassVar[tuple[str, ...]] = ()
    #: Whether the first column of `_series` is the index of the data frame.
    _indexed: ClassVar[bool] = False

    def _columns(self) -> list[Column]:
        """Give the columns of the table."""
        raise NotImplementedError

    def _series(self) -> list[Column]:
        """Give the columns of the data frame: those of the table, unless it is a summary."""
        return self._columns()

    def _heading(self) -> list[str]:
        """Give the lines above the table."""
        return []

    def _remarks(self) -> list[str]:
        """Give the lines below the table."""
        return []

    def _left_out(self) -> list[str]:
        """Name the excitations of the system that the result does not contain."""
        names = getattr(self, "left_out", ())
        return [f"excitation left out: {', '.join(names)}"] if names else []

    def _save_own(self, path: Any, ending: str) -> None:
        """Write a file with one of the `_own_endings`."""
        raise NotImplementedError

    def _showing(self, given: SpeedUnit | None = None) -> AbstractContextManager[None]:
        """Write speeds in the given unit, or in that in which the user gave the speed."""
        own: SpeedUnit | None = getattr(self, "speed_unit", None)
        if given is not None and own is None:
            raise GearbowError("speed_unit: this result has no speeds; leave it out")
        return showing_in((own or "rad/s") if given is None else given)

    def table(self, count: int | None = None, *, speed_unit: SpeedUnit | None = None) -> str:
        """Format the result as a text table.

        Parameters
        ----------
        count : int, optional
            Number of rows; None is all.
        speed_unit : {"rad/s", "rpm"}, optional
            Unit of speeds; None is that in which the speed was given. Not for results without any.

        Returns
        -------
        str
            What the result is, the headings with units, and the rows.
        """
        with self._showing(speed_unit):
            return self._text(None if count is None else whole(count, "count"))

    def _text(self, most: int | None, *, counted: bool = False) -> str:
        """Format the first rows, and say how many others there are if they are counted."""
        columns = self._columns()
        count = len(columns[0].values) if columns else 0
        rows = range(count if most is None else min(count, most))
        cells = []
        for column in columns:
            own = column.cells(rows)
            width = max(map(len, own))
            cells.append(
                [text.ljust(width) if column.is_text else text.rjust(width) for text in own]
            )
        lines = ["  ".join(row).rstrip() for row in zip(*cells, strict=True)]
        left = count - len(rows)
        if not count:
            lines.append("none")
        elif counted and left:
            lines.append(f"… and {left} more row{'s' if left > 1 else ''}; table() gives all")
        return "\n".join([*self._heading(), *lines, *self._remarks(), *self._left_out()])

    def _rows(self) -> Table:
        columns = self._columns()
        rows = range(len(columns[0].values)) if columns else ()
        cells = [column.cells(rows) for column in columns]
        return tuple(zip(*cells, strict=True))

    def __str__(self) -> str:
        with self._showing():
            return self._text(PRINTED_ROWS, counted=True)

    def _repr_html_(self) -> str:
        with self._showing():
            return to_html("\n".join([repr(self), *self._heading()]), self._rows())

    def to_dataframe(self) -> "pd.DataFrame":
        """Convert the result to a data frame.

        Returns
        -------
        pandas.DataFrame
            One row for each row of the table, or for each time or frequency of a result with
            series. Headings have the SI units of the values.
        """
        return data_frame(self._series(), indexed=self._indexed)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result to a file, whose ending means the format.

        Parameters
        ----------
        path : str or path-like
            The file. ".csv" and ".xlsx" (Excel) hold the table of `to_dataframe`, ".nc" (netCDF)
            its columns with their units or, for other programs, all of a run. A result with a
            method `load` has an ending whose file holds everything without rounding: ".npz"
            (NumPy) of a run, a steady state or a branch, ".sweep" of a sweep.

        Raises
        ------
        GearbowError
            If the table is larger than a sheet of Excel.
        """
        self._write(path)

    def _write(self, path: str | os.PathLike[str], *chosen: Any) -> None:
        """Write a file of all that the result contains, or of what is chosen of it."""
        others = [each for each in TABLE_ENDINGS if each not in self._own_endings]
        found, ending = check_name(path, (*self._own_endings, *others))
        if ending in self._own_endings:
            self._save_own(found, ending, *chosen)
        elif ending == ".nc":
            from gearbow.recording.container import require_netcdf, save_netcdf  # noqa: PLC0415

            require_netcdf()
            save_netcdf(self._dataset(*chosen), found)
        else:
            frame = self.to_dataframe(*chosen)
            from gearbow._sheets import save_table  # noqa: PLC0415  # few runs need it

            table = frame.reset_index() if self._indexed else frame
            save_table(_without_complex(table), found, ending)

    def _dataset(self) -> "xr.Dataset":
        """Give the columns as variables over the rows."""
        import xarray as xr  # noqa: PLC0415

        variables = {}
        for column in self._series():
            units = {"units": column.unit} if column.unit else {}
            values = np.asarray(column.values)
            variables[column.name.replace("/", "–")] = (
                "row",
                np.array([printable(each) for each in values], object)
                if values.dtype.kind == "U"
                else values,
                units,
            )
        return xr.Dataset(variables)


class WithSpeeds:
    """Base of results with speeds.

    Attributes
    ----------
    speed_unit : {"rad/s", "rpm"}
        Unit of speeds in tables and figures: that in which the speed was given.
    """

    speed_unit: SpeedUnit = "rad/s"

    def _remember(self, unit: SpeedUnit) -> None:
        """Keep the unit of speeds, also for the results within this one."""
        for inner in vars(self).values():
            if isinstance(inner, WithSpeeds):
                inner._remember(unit)
        vars(self)["speed_unit"] = unit

    def _speed_text(self, speeds: float | list[float] | Array) -> str:
        """Write a speed, several ones, or the ends of an array of speeds with their unit."""
        unit = shown_unit(self.speed_unit)
        if isinstance(speeds, list):
            return f"{listed([speed_factor(unit) * speed for speed in speeds])} {unit}"
        if isinstance(speeds, np.ndarray):
            return f"{span(speed_factor(unit) * speeds)} {unit}"
        return speed_text(speeds, unit)


_Speeds = TypeVar("_Speeds", bound=WithSpeeds)


class Figured(Result):
    """Base of results that one figure shows."""

    def _draw(self, ax: Any, /) -> "Figure":
        """Draw the figure."""
        raise NotImplementedError

    def plot(self, *, ax: Any = None, speed_unit: SpeedUnit | None = None) -> "Figure":
        """Draw the result, as the description of its class says.

        Parameters
        ----------
        ax : Axes or sequence of Axes, optional
            One for each panel of the figure; None makes a new figure.
        speed_unit : {"rad/s", "rpm"}, optional
            Unit of speeds; None is that in which the speed was given. Not for results without any.

        Returns
        -------
        matplotlib.figure.Figure
            The figure. It is neither shown nor saved.
        """
        with extra("plot"):
            from gearbow.plotting import style  # noqa: F401, PLC0415  # as the figure does

        with self._showing(speed_unit):
            return self._draw(ax)


def replaced(result: _Speeds, **changes: Any) -> _Speeds:
    """Copy a result with other fields; the unit of its speeds, which is no field, stays."""
    found = replace(result, **changes)  # type: ignore[type-var]
    found._remember(result.speed_unit)
    return found
