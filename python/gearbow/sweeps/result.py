"""Results of sweeps, their tables and their data sets."""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from gearbow._convert import nearest, shown, text
from gearbow._core import require_memory
from gearbow._extras import extra
from gearbow._files import check_name
from gearbow._result import Column, Result
from gearbow._shown import Shown, short
from gearbow._types import Plain
from gearbow.errors import ChannelError, CheckpointWarning, GearbowError, SceneError, warn
from gearbow.sweeps import store
from gearbow.sweeps.points import Outcome, Points, Values
from gearbow.units.fields import DIMENSIONLESS, unit_of
from gearbow.units.speed import showing_in, shown_unit, speed_factor

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def _readable(unit: str, largest: float) -> tuple[float, str]:
    """Give factor and unit in which a figure shows values up to the largest one."""
    if unit == "m" and largest < 1.0:
        return (1e6, "µm") if largest < 1e-3 else (1e3, "mm")
    if unit == "rad":
        return 180.0 / np.pi, "°"
    return (speed_factor(), shown_unit()) if unit == "rad/s" else (1.0, unit)


@dataclass(frozen=True, eq=False)
class SweepPoint(Shown):
    """One point of a sweep.

    Parameters
    ----------
    parameters : mapping of {str: object}
        The parameters.
    values : mapping of {str: NumPy scalar or ndarray}, optional
        Measured values by name, "value" without a dict; None if the point has no result.
    error : str
        Type and message of the error; empty if the point did not fail.
    details : str
        The traceback of the error.

    Examples
    --------
    >>> import gearbow as gb
    >>> def shaft(diameter):
    ...     return gb.Shaft("rotor", length=1.0, outer_diameter=diameter)
    >>> sweep = gb.sweep(shaft, {"diameter": [0.04, 0.05]}, lambda shaft, diameter: shaft.length)
    >>> sweep[1].parameters
    {'diameter': 0.05}
    """

    parameters: Mapping[str, Any]
    values: Values | None
    error: str = ""
    details: str = field(default="", repr=False)


class Sweep(Result, Sequence[SweepPoint]):
    """Measured values of many systems, made by `gearbow.sweep`.

    A sweep is the sequence of its points, in the order of the parameters: the last parameter of a
    grid varies fastest.

    Parameters
    ----------
    points : Points
        The parameters.
    outcomes : mapping of {int: Outcome}
        Outcome of each computed point.
    functions : tuple of (dict, dict)
        Identities of `make` and `measure`.

    Examples
    --------
    >>> import gearbow as gb
    >>> def shaft(diameter, length):
    ...     rotor = gb.Shaft("rotor", length=length, outer_diameter=diameter)
    ...     bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, length)]
    ...     return gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> def lowest(system, **parameters):
    ...     return system.modes().frequencies_hz[2]
    >>> sweep = gb.sweep(shaft, {"diameter": [0.04, 0.05], "length": [0.5, 1.0]}, lowest)
    >>> sweep
    Sweep(diameter 2 × length 2: 4 points)
    >>> print(sweep[1].parameters, f"{sweep[1].values['value']:.0f} Hz")
    {'diameter': 0.04, 'length': 1.0} 314 Hz
    >>> print(sweep.values().round())
    [[1074.  314.]
     [1100.  379.]]
    """

    _own_endings = (store.SUFFIX,)

    def __init__(
        self,
        points: Points,
        outcomes: Mapping[int, Outcome],
        functions: tuple[dict[str, str], dict[str, str]],
    ) -> None:
        self._points = points
        self._outcomes = dict(outcomes)
        self._functions = functions

    @property
    def parameters(self) -> Mapping[str, tuple[Any, ...]]:
        """Values of each parameter: of each axis of a grid, or of each point of a list."""
        points = self._points
        return MappingProxyType({name: tuple(points.column(name)) for name in points.names})

    @property
    def failed(self) -> tuple[SweepPoint, ...]:
        """The points that ended with an error, with their parameters and errors."""
        numbers = (number for number, found in self._outcomes.items() if found.values is None)
        return tuple(self[number] for number in sorted(numbers))

    @property
    def computed(self) -> int:
        """Number of computed points, with the failed ones; less than `len` if interrupted."""
        return len(self._outcomes)

    def values(self, name: str | None = None) -> NDArray[Any]:
        """Return a measured value of all points.

        Parameters
        ----------
        name : str, optional
            The value; None if there is only one.

        Returns
        -------
        ndarray, shape (parameters..., axes...)
            One axis for each parameter of a grid, or one for a list of points, then the axes of the
            value. Points that failed or were not computed are NaN, for texts empty; whole numbers
            and truth values then become floats.

        Raises
        ------
        ChannelError
            If there is no value of this name, or more than one value and no name.
        GearbowError
            If the shape of the value differs between points.
        """
        names = self._names()
        if name is None and len(names) == 1:
            (name,) = names
        if name is not None:
            text(name, "name")
        if name not in names:
            if not names:
                errors = [point.error for point in self.failed[:1]]
                raise ChannelError(
                    f"no point has a value; {errors[0] if errors else 'none was computed'}"
                )
            what = "there is more than one value" if name is None else f"{name!r}: is no value"
            near = "" if name is None else nearest(name, names)
            raise ChannelError(f"{what}{near}; the values are {', '.join(names)}")
        return column(name, self._outcomes, len(self)).reshape(
            self._points.shape + shape_of(name, self._outcomes)
        )

    def to_xarray(self) -> "xr.Dataset":
        """Return the sweep as a data set.

        Returns
        -------
        xarray.Dataset
            One variable for each value. The dimensions are the parameters of a grid, or "point"
            with the parameters as coordinates, then ``name_0``, ``name_1``... for the axes of a
            value. For points without values, see `values`.

        Raises
        ------
        GearbowError
            If the shape of a value differs between points, or a value has the name of a parameter.
        """
        named = {name: self.values(name) for name in self._names()}
        return to_xarray(self._points, named)

    def plot(
        self,
        name: str | None = None,
        *,
        units: Mapping[str, str] | None = None,
        ax: Any = None,
    ) -> "Figure":
        """Draw a value over one, two or three parameters of a grid.

        Parameters
        ----------
        name : str, optional
            Name of the value, a number at each point; None if there is only one.
        units : mapping of {str: str}, optional
            Units of parameters and values for the labels, e.g. ``{"bow": "m"}``. A parameter with
            the name of a field of a part, such as ``outer_diameter``, has the unit of this field.
            The figure has lengths [m] in m, mm or µm, angles [rad] in degrees, and speeds [rad/s]
            in the unit in which the grid gives them.
        ax : Axes or sequence of Axes, optional
            Panel, or one for each value of the first of three parameters; None makes a figure.

        Returns
        -------
        matplotlib.figure.Figure
            A line over one parameter; a map with colours over two; such a map for each value of the
            first one of three. Points that failed are empty. The figure is neither shown nor saved.

        Raises
        ------
        GearbowError
            If the sweep is no grid, not one to three of its parameters vary, one of them is not
            numeric, the value is no number, or `ax` is not one panel.
        """
        with extra("plot"):
            from gearbow.plotting import analyses as figures  # noqa: PLC0415

        if self._points.axes is None:
            raise GearbowError("plot: needs a sweep over a grid; read values and draw them")
        axes = {key: axis for key, axis in self.parameters.items() if len(axis) > 1}
        if len(axes) not in (1, 2, 3):
            raise GearbowError(
                f"plot: draws one to three parameters, but {len(axes)} vary: "
                f"{', '.join(axes) or 'none'}"
            )
        for key, axis in axes.items():
            if not all(isinstance(value, int | float) for value in axis):
                raise GearbowError(f"plot: the parameter {key} is not numeric")
        values = self.values(name)
        name = name or self._names()[0]
        if values.ndim != len(self._points.shape) or values.dtype.kind not in "biuf":
            raise GearbowError(f"plot: {name} is not one number at each point")
        known = {key: unit for key in axes if (unit := unit_of(key)) not in (None, DIMENSIONLESS)}
        if units is not None and not isinstance(units, Mapping):
            raise SceneError(f"units: must be a mapping of names to units, got {shown(units)}")
        named = {**known, **{key: text(unit, "units") for key, unit in (units or {}).items()}}
        labels = dict.fromkeys((*axes, name), "")
        drawn: dict[str, Any] = {**axes, name: values.squeeze()}
        with showing_in(self._points.speed_unit):
            for key in labels:
                own = np.array(drawn[key])
                largest = np.abs(own[np.isfinite(own)]).max(initial=0.0)
                factor, unit = _readable(named.get(key, ""), float(largest))
                labels[key], drawn[key] = f"{key} [{unit}]" if unit else key, factor * own
        value = drawn.pop(name)
        return figures.sweep(drawn, value, name, labels=labels, ax=ax)

    def _heading(self) -> list[str]:
        return [repr(self)]

    def _columns(self) -> list[Column]:
        """Give a row for each point; a value that is no number is a short text."""
        given = [point.parameters for point in self]
        names = self._points.names
        columns = [Column(name, _plain([one[name] for one in given])) for name in names]
        found = [point.values or {} for point in self]
        for name in self._names():
            values = [one.get(name, np.nan) for one in found]
            columns.append(Column(name, _plain([np.asarray(value)[()] for value in values])))
        errors = [point.error for point in self]
        return [*columns, Column("error", errors)] if any(errors) else columns

    def _series(self) -> list[Column]:
        named = {name: self.values(name) for name in self._names()}
        return columns(self._points, named, [point.error for point in self])

    def _save_own(self, path: Any, ending: str) -> None:  # noqa: ARG002  # the path has it
        store.write(path, self._head(), self._outcomes)

    def _dataset(self) -> "xr.Dataset":
        return for_netcdf(self.to_xarray())

    def _head(self) -> dict[str, Plain]:
        return store.head_of(*self._functions, self._points.plain())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Sweep":
        """Read a ".sweep" file of `save` or a store, complete or not.

        Points that have changed since they were written count as not computed; a
        `CheckpointWarning` names them.

        Parameters
        ----------
        path : str or path-like
            The file. Its name ends with ".sweep".
        """
        path, _ = check_name(path, [store.SUFFIX])
        found = store.read(path)
        head, outcomes = found.head, found.outcomes
        if damage := found.damage():
            message = f"{path}: is damaged: {damage}; they count as not computed"
            warn(message, CheckpointWarning)
        points = store.points_of(head)
        if max(outcomes, default=-1) >= len(points):
            raise GearbowError(
                f"{path}: contains the point {max(outcomes)}, but there are {len(points)} points"
            )
        return cls(points, outcomes, (head["make"], head["measure"]))

    def _names(self) -> list[str]:
        """Names of the values of all points, each once."""
        found = (self._outcomes[number].values for number in sorted(self._outcomes))
        return list(
            dict.fromkeys(name for values in found if values is not None for name in values)
        )

    def __len__(self) -> int:
        return len(self._points)

    def __iter__(self) -> Iterator[SweepPoint]:
        return (self[number] for number in range(len(self)))

    @overload
    def __getitem__(self, index: int) -> SweepPoint: ...
    @overload
    def __getitem__(self, index: slice) -> list[SweepPoint]: ...
    def __getitem__(self, index: int | slice) -> SweepPoint | list[SweepPoint]:
        if isinstance(index, slice):
            return [self[number] for number in range(*index.indices(len(self)))]
        parameters = self._points[index]
        found = self._outcomes.get(index % len(self), Outcome())
        return SweepPoint(parameters, found.values, found.error, found.details)

    def __repr__(self) -> str:
        points, failed = self._points, len(self.failed)
        names = [f"{name} {size}" for name, size in zip(points.names, points.shape, strict=False)]
        text = " × ".join(names) if points.axes is not None else ", ".join(points.names)
        missing = len(self) - self.computed
        counts = [f"{len(self)} points"]
        counts += [f"{failed} failed"] * bool(failed) + [f"{missing} not computed"] * bool(missing)
        return f"{type(self).__name__}({text}: {', '.join(counts)})"


def _plain(values: Sequence[Any]) -> Sequence[Any]:
    """Give numbers and texts as they are, and other values as short texts."""
    plain = all(isinstance(value, bool | int | float | str | np.generic) for value in values)
    return values if plain else [short(value) for value in values]


def shape_of(name: str, outcomes: Mapping[int, Outcome]) -> tuple[int, ...]:
    """Return the shape of a value, which must be the same at all points."""
    shapes: dict[tuple[int, ...], int] = {}
    for number in sorted(outcomes):
        found = outcomes[number].values
        if found is not None and name in found:
            shapes.setdefault(np.shape(found[name]), number)
    if len(shapes) > 1:
        (one, at), (other, there), *_ = shapes.items()
        raise GearbowError(
            f"{name}: has the shape {one} at point {at} and {other} at point {there}; let "
            "`measure` return arrays of one shape, or read the values of each point"
        )
    return next(iter(shapes), ())


def column(name: str, outcomes: Mapping[int, Outcome], count: int) -> NDArray[Any]:
    """Return a value of all points, shape (points, axes...); NaN or an empty text without one."""
    shape = shape_of(name, outcomes)
    found = {
        number: np.asarray(outcome.values[name])
        for number, outcome in outcomes.items()
        if outcome.values is not None and name in outcome.values
    }
    kind = np.result_type(*{value.dtype for value in found.values()})
    if len(found) < count and kind.kind in "biu":
        kind = np.dtype(np.float64)
    # The array, and its copy with the axes of the parameters.
    size = 2.0 * count * kind.itemsize * float(np.prod(shape, dtype=np.float64))
    remedy = "read the values point by point, or let `measure` return fewer"
    require_memory(name, f"the values of {count} points", size, remedy)
    missing: Any = "" if kind.kind == "U" else np.nan
    values = np.full((count, *shape), missing if len(found) < count else kind.type(), kind)
    for number, value in found.items():
        values[number] = value
    return values


def to_xarray(points: Points, values: Mapping[str, NDArray[Any]]) -> "xr.Dataset":
    """Return values as a data set; see `Sweep.to_xarray`."""
    with extra("sweep"):
        import xarray as xr  # noqa: PLC0415
    _check_names(points, values)
    grid = points.axes is not None
    dims = points.names if grid else ("point",)
    coordinates = {
        name: (name if grid else "point", _coordinate(points.column(name))) for name in points.names
    }
    variables = {
        name: ((*dims, *(f"{name}_{axis}" for axis in range(array.ndim - len(dims)))), array)
        for name, array in values.items()
    }
    return xr.Dataset(variables, coordinates)


def for_netcdf(data: "xr.Dataset") -> "xr.Dataset":
    """Change a data set for a netCDF file, which has neither complex numbers nor half precision."""
    variables: dict[str, Any] = {}
    for name, variable in data.data_vars.items():
        if variable.dtype.kind == "c":
            variables |= {f"{name}_real": variable.real, f"{name}_imag": variable.imag}
        else:
            half = variable.dtype == np.float16
            variables[str(name)] = variable.astype(np.float32) if half else variable
    plain: xr.Dataset = data.drop_vars(list(data.data_vars)).assign(variables)
    return plain


def columns(
    points: Points, values: Mapping[str, NDArray[Any]], errors: Sequence[str]
) -> list[Column]:
    """Return values as columns, with one for each entry of an array."""
    _check_names(points, values)
    rows = [points[number] for number in range(len(points))]
    table: dict[str, Any] = {name: [row[name] for row in rows] for name in points.names}
    for name, array in values.items():
        axes = array.ndim - len(points.shape)
        shape = array.shape[array.ndim - axes :]
        flat = array.reshape(len(points), *shape)
        for entry in np.ndindex(shape):
            label = f"{name}[{', '.join(map(str, entry))}]" if entry else name
            index = (slice(None), *entry)
            table[label] = flat[index]
    table |= {"error": list(errors)}
    return [Column(name, found) for name, found in table.items()]


def _check_names(points: Points, values: Mapping[str, NDArray[Any]]) -> None:
    for name in points.names:
        if name in values:
            raise GearbowError(
                f"{name}: is the name of a parameter and of a value; let `measure` return another "
                "name"
            )


def _coordinate(values: list[Any]) -> Any:
    """Return an axis of numbers or texts; other values are represented by their text."""
    plain = all(isinstance(value, bool | int | float | complex) for value in values)
    return values if plain else [str(value) for value in values]
