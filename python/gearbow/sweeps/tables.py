"""Values of a sweep as arrays, data sets and tables."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearbow._core import require_memory
from gearbow._extras import extra
from gearbow._result import Column
from gearbow.errors import GearbowError
from gearbow.sweeps.points import Outcome, Points

if TYPE_CHECKING:
    import xarray as xr


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
