"""Curves of a frequency response as tables, data sets and files, and measured curves from files."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from io import BufferedRandom
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import shown
from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._types import Array, At, ComplexArray
from gearbow.errors import SceneError
from gearbow.exchange.tables import NamedColumns, read_table

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = [
    "Curve",
    "MeasuredCurve",
    "read_measured",
    "to_dataframe",
    "to_xarray",
    "write_mat",
    "write_uff",
]

#: Directions of a response in UFF 58, and the dimension of a displacement there.
_UFF_DIRECTIONS = {"x": 1, "y": 2, "z": 3, "twist": 4}
#: Data types of UFF 58: displacement, velocity, acceleration, and excitation force.
_UFF_TYPES = {"m": 8, "rad": 8, "N": 13}
_UFF_QUANTITIES = {8: "displacement", 11: "velocity", 12: "acceleration"}
#: Function types of UFF 58.
_UFF_FRF = 4


@dataclass(frozen=True)
class Curve:
    """A signal of a frequency response in one direction."""

    #: Place: a name, (shaft, position), or (driver, driven) of a mesh.
    at: Any
    #: "displacement", "bearing force" or "mesh force".
    kind: str
    #: "x", "y", "z", "twist" or "mesh".
    direction: str
    unit: str
    #: Phasors, shape (*frequencies, sources).
    values: ComplexArray

    @property
    def place(self) -> str:
        """The place as a text."""
        return _text(self.at)

    @property
    def label(self) -> str:
        """Name of a column."""
        kind = "" if self.kind == "displacement" else f"{self.kind} "
        direction = "" if self.direction == "mesh" else self.direction
        return f"{self.place} {kind}{direction}".rstrip() + f" [{self.unit}]"


def to_dataframe(
    curves: Iterable[Curve], frequencies: Array, speeds: Array, sources: Sequence[str]
) -> "pd.DataFrame":
    """Give curves as a table with one row for each frequency and source."""
    with extra("dataframe"):
        import pandas as pd  # noqa: PLC0415

    count = len(sources)
    columns: dict[str, Any] = {
        "frequency [rad/s]": np.repeat(frequencies.ravel(), count),
        "speed [rad/s]": np.repeat(speeds.ravel(), count),
        "source": list(sources) * frequencies.size,
    }
    columns |= {curve.label: curve.values.ravel() for curve in curves}
    table: pd.DataFrame = pd.DataFrame(columns)
    return table


def to_xarray(
    curves: Sequence[Curve],
    axes: Sequence[str],
    coordinates: Mapping[str, Array],
    sources: Sequence[str],
    *,
    parts: bool = False,
) -> "xr.Dataset":
    """Give curves as a data set; with `parts`, complex numbers as a dimension "part"."""
    with extra("netcdf"):
        import xarray as xr  # noqa: PLC0415

    dimensions = (*axes, "source")
    variables: dict[str, Any] = {}
    for curve in curves:
        name, unit = curve.label.rsplit(" [", 1)
        values: Any = curve.values
        shape = dimensions
        if parts:
            values, shape = np.stack([values.real, values.imag], axis=-1), (*dimensions, "part")
        variables[name.replace("/", " – ")] = (shape, values, {"units": unit[:-1]})
    given: dict[str, Any] = {"source": ("source", np.array(sources))}
    if parts:
        given["part"] = ("part", np.array(["real", "imaginary"]))
    for name, own in coordinates.items():
        given[name] = (tuple(axes) if own.ndim == len(axes) else name, own, {"units": "rad/s"})
    return xr.Dataset(variables, given)


def write_mat(
    file: BufferedRandom,
    curves: Iterable[Curve],
    frequencies: Array,
    speeds: Array,
    sources: Sequence[str],
) -> None:
    """Write a file of MATLAB: vectors, and one structure for each curve."""
    with extra("matlab"):
        from scipy.io import savemat  # noqa: PLC0415

    listed = [
        {
            "place": curve.place,
            "kind": curve.kind,
            "direction": curve.direction,
            "unit": curve.unit,
            "values": curve.values,
        }
        for curve in curves
    ]
    content = {
        "frequencies": frequencies,
        "speeds": speeds,
        "sources": np.array(sources, dtype=object),
        "curves": np.array(listed, dtype=object),
    }
    savemat(file, content, do_compression=False, oned_as="column")


def write_uff(
    path: Path,
    curves: Iterable[Curve],
    frequencies: Array,
    speeds: Array,
    sources: Sequence[str],
) -> None:
    """Write curves as data sets 58 of universal files, one for each source."""
    with extra("uff"):
        import pyuff  # noqa: PLC0415

    hertz = frequencies / (2.0 * np.pi)
    even = hertz.size > 1 and np.allclose(np.diff(hertz), np.diff(hertz)[0], rtol=1e-9, atol=0.0)
    nodes: dict[str, int] = {}
    sets = []
    for curve in curves:
        node = nodes.setdefault(curve.place, len(nodes) + 1)
        for number, source in enumerate(sources):
            sets.append(
                {
                    "type": 58,
                    "binary": 0,
                    "func_type": _UFF_FRF,
                    "id1": f"{curve.label} due to {source}"[:80],
                    "id2": f"at {speeds.ravel()[0]:g} rad/s of the reference shaft",
                    "id3": f"place {curve.place}"[:80],
                    "id4": f"source {source}"[:80],
                    "id5": "gearbow",
                    "ver_num": 0,
                    "load_case_id": 0,
                    "rsp_ent_name": curve.place[:10],
                    "rsp_node": node,
                    "rsp_dir": _UFF_DIRECTIONS.get(curve.direction, 0),
                    "ref_ent_name": "source",
                    "ref_node": number + 1,
                    "ref_dir": 0,
                    "x": hertz,
                    "data": curve.values[..., number],
                    "num_pts": hertz.size,
                    "abscissa_spacing": int(even),
                    "abscissa_min": float(hertz[0]),
                    "abscissa_inc": float(hertz[1] - hertz[0]) if even else 0.0,
                    "ord_data_type": 6,
                    "abscissa_spec_data_type": 18,
                    "abscissa_axis_units_lab": "Hz",
                    "ordinate_spec_data_type": _UFF_TYPES.get(curve.unit, 0),
                    "ordinate_axis_units_lab": curve.unit,
                    "orddenom_spec_data_type": 13,
                    "orddenom_axis_units_lab": "N",
                    "spec_data_type": 6,
                    "z_axis_value": 0.0,
                }
            )
    file = pyuff.UFF(str(path))
    file.write_sets(sets, mode="overwrite")


@dataclass(frozen=True, eq=False)
class MeasuredCurve(ReadOnly):
    """A measured frequency response function.

    Parameters
    ----------
    at : str or tuple of (str, float)
        Place of the response.
    direction : {"x", "y", "z", "twist"}
        Direction of the response.
    quantity : {"displacement", "velocity", "acceleration"}
        Quantity of the response.
    frequencies : ndarray, shape (k,)
        Frequencies [rad/s].
    values : ndarray, shape (k,)
        Phasors of the response to the source.
    source : int
        Number of the source in the response that it is compared with.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> curve = gb.results.MeasuredCurve("pinion", "y", "velocity", np.ones(3), 1j * np.ones(3))
    >>> curve.label
    'pinion y'
    """

    at: At
    direction: str
    quantity: str
    frequencies: Array
    values: ComplexArray
    source: int = 0

    @property
    def label(self) -> str:
        """Name of the curve in figures.

        Returns
        -------
        str
            Place and direction.
        """
        return f"{_text(self.at)} {self.direction}"


def _text(at: Any) -> str:
    """Give a place as a text: "pinion", "input@0.2" or "pinion/wheel"."""
    if isinstance(at, str):
        return at
    first, second = at
    return f"{first}/{second}" if isinstance(second, str) else f"{first}@{second:g}"


def read_measured(path: Path, places: Mapping[int, At] | None) -> list[MeasuredCurve]:
    """Read measured curves from a universal file or a table."""
    if path.suffix.lower() in (".uff", ".unv"):
        return _read_uff(path, places or {})
    return _read_table(path)


#: Columns of a table: a place, and a direction with the real or imaginary part.
_COLUMNS = NamedColumns(
    re.compile(r"(.+?)\s+((?:[xyz]|twist)\s+(?:re|im))", re.IGNORECASE),
    {
        f"{direction} {part}": (
            ("measured.twist",)
            if direction == "twist"
            else ("measured.displacement", "measured.velocity", "measured.acceleration")
        )
        for direction in _UFF_DIRECTIONS
        for part in ("re", "im")
    },
    "pinion y re [m/s²]",
)


def _read_table(path: Path) -> list[MeasuredCurve]:
    """Read a frequency and pairs of columns such as "pinion y re [m/s²]"."""
    table = read_table(path, {"frequency": "frequency"}, named=_COLUMNS)
    if "frequency" not in table.numbers:
        raise SceneError(f'{path}: needs the column "frequency [Hz]"')
    curves = []
    for name in table.numbers:
        curve, _, part = name.rpartition(" ")
        if name == "frequency":
            continue
        names = [f"{curve} {each}" for each in ("re", "im")]
        if not set(names) <= table.numbers.keys() or len({table.fields[n] for n in names}) > 1:
            raise SceneError(f"{path}: {curve} needs a column re and a column im of one quantity")
        if part == "re":
            real, imaginary = (table.numbers[n] for n in names)
            name_of_place, _, direction = curve.rpartition(" ")
            try:
                at = _place(name_of_place)
            except ValueError:
                raise SceneError(f"{path}: {curve}: the position behind @ must be in m") from None
            quantity = table.fields[name].removeprefix("measured.").replace("twist", "displacement")
            values = real + 1j * imaginary
            frequencies = table.numbers["frequency"]
            curves.append(MeasuredCurve(at, direction, quantity, frequencies, values))
    if not curves:
        raise SceneError(f'{path}: needs columns such as "{_COLUMNS.example}"')
    return curves


def _place(text: str) -> At:
    """Read "pinion" or "input@0.2"."""
    name, sign, position = text.rpartition("@")
    return (name, float(position)) if sign else text


def _read_uff(path: Path, places: Mapping[int, At]) -> list[MeasuredCurve]:
    """Read the frequency response functions of a universal file."""
    with extra("uff"):
        import pyuff  # noqa: PLC0415

    file = pyuff.UFF(str(path))
    types = file.get_set_types()
    directions = {number: name for name, number in _UFF_DIRECTIONS.items()}
    curves = []
    for index in np.flatnonzero(np.atleast_1d(types) == 58):
        given = file.read_sets(int(index))
        if given["func_type"] != _UFF_FRF:
            continue
        own = re.match(r"place (.+\S)", str(given.get("id3", "")))
        node = int(given["rsp_node"])
        if node not in places and own is None:
            raise SceneError(
                f"places: needs the place of node {node} of {path}, for example "
                f'places={{{node}: ("input", 0.2)}}, got {shown(dict(places))}'
            )
        at = places[node] if node in places else _place(own[1])  # type: ignore[index]  # checked
        quantity = _UFF_QUANTITIES.get(int(given["ordinate_spec_data_type"]))
        direction = directions.get(abs(int(given["rsp_dir"])))
        if quantity is None or direction is None:
            continue
        sign = 1.0 if given["rsp_dir"] > 0 else -1.0
        hertz = np.asarray(given["x"], dtype=np.float64)
        values = sign * np.asarray(given["data"], dtype=np.complex128)
        source = max(0, int(given["ref_node"]) - 1) if own is not None else 0
        curves.append(MeasuredCurve(at, direction, quantity, 2.0 * np.pi * hertz, values, source))
    if not curves:
        raise SceneError(f"{path}: has no frequency response function of a motion (data set 58)")
    return curves
