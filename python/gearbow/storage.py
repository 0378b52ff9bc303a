"""A response as a file, a data set or a table.

Both file formats hold the same: the arrays, and one JSON text for what is not an array. Nothing is
pickled, floats keep every bit, and the state at the end comes back as it was, so that a loaded
response can be continued.
"""

import json
import os
import zipfile
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearbow._files import replacing
from gearbow._run import plain_speed, read_speed
from gearbow.energy import ENERGIES, WORKS
from gearbow.errors import GearbowError
from gearbow.orders.kinematics import Kinematics
from gearbow.response import Response

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["load", "save", "to_dataframe", "to_xarray"]

#: Number of the layout, raised whenever a reader of the one before would not understand it.
_FORMAT = 1

#: Unit and axes of every array over time.
_CHANNELS = {
    "displacement": ("m", ("time", "point", "axis")),
    "twist": ("rad", ("time", "point")),
    "bearing_force": ("N", ("time", "bearing", "axis")),
    "energy": ("J", ("time",)),
    **{f"energy_{name}": ("J", ("time",)) for name in (*ENERGIES, *WORKS)},
    "mesh_deflection": ("m", ("time", "mesh")),
    "mesh_force": ("N", ("time", "mesh")),
    "mesh_stiffness": ("N/m", ("time", "mesh")),
    "mesh_pressure_angle": ("rad", ("time", "mesh")),
    "mesh_centre_distance": ("m", ("time", "mesh")),
    "mesh_centre_line_angle": ("rad", ("time", "mesh")),
    "mesh_contact_ratio": ("1", ("time", "mesh")),
    "mesh_pairs_in_contact": ("1", ("time", "mesh")),
}


def save(response: Response, path: str | os.PathLike[str], **more: Any) -> None:
    """Write a response to a ``.npz`` or ``.nc`` file, whole or not at all.

    Parameters
    ----------
    response : Response
        The response.
    path : str or path-like
        The file; its suffix tells the format.
    **more
        What else is kept beside it, as plain data; `read` gives it back.

    Raises
    ------
    GearbowError
        If the suffix is another.
    OSError
        If it cannot be written; a file that was there is still there.
    """
    metadata = _metadata(response, more)
    if suffix(path) == ".nc":
        dataset = to_xarray(response).assign_attrs(metadata=metadata)
        with replacing(path) as trial:
            dataset.to_netcdf(trial, engine="h5netcdf")
        return
    with replacing(path) as trial:
        np.savez(trial, metadata=np.array(metadata), **_arrays(response))  # type: ignore[arg-type]


def load(path: str | os.PathLike[str]) -> Response:
    """Read a file that `save` wrote.

    Parameters
    ----------
    path : str or path-like
        A ``.npz`` or ``.nc`` file.

    Returns
    -------
    Response
        The response, the same to the last bit.

    Raises
    ------
    GearbowError
        If the suffix is another, or the file holds something else.
    """
    return read(path)[0]


def read(path: str | os.PathLike[str]) -> tuple[Response, dict[str, Any]]:
    """Read a file that `save` wrote, with all that stands beside the arrays.

    Parameters
    ----------
    path : str or path-like
        A ``.npz`` or ``.nc`` file.

    Returns
    -------
    response : Response
        The response, the same to the last bit.
    about : dict
        Everything else, and what `save` was given beside it.

    Raises
    ------
    GearbowError
        If the suffix is another, or the file holds something else.
    """
    try:
        arrays, metadata = (_read_netcdf if suffix(path) == ".nc" else _read_npz)(path)
        about = json.loads(metadata)
    except KeyError as error:
        raise GearbowError(f"{path}: not a response of gearbow, it has no {error}") from None
    if about["format"] != _FORMAT:
        raise GearbowError(
            f"{path}: written in format {about['format']}, this version reads {_FORMAT}"
        )
    # What has no elements has no place in netCDF.
    arrays |= {name: np.empty(shape, dtype) for name, (shape, dtype) in about["empty"].items()}
    mesh, terms, state = (_named(arrays, prefix) for prefix in ("mesh_", "energy_", "final_"))
    response = Response(
        {
            "time": arrays["time"],
            "points": [(shaft, position, names) for shaft, position, names in about["points"]],
            "displacement": arrays["displacement"],
            "twist": arrays["twist"],
            "bearings": [(shaft, position) for shaft, position in about["bearings"]],
            "bearing_force": arrays["bearing_force"],
            "meshes": [(driver, driven) for driver, driven in about["meshes"]],
            "mesh": mesh,
            "energy": arrays.get("energy"),
            "energy_terms": terms or None,
            "events": [tuple(event) for event in about["events"]],
            "final": {**about["final"], **state},
            "statistics": about["statistics"],
        },
        read_speed(about["speed"]),
    )
    response.expected_error, response.accuracy = about["expected_error"], about["accuracy"]
    response.kinematics = Kinematics._from_plain(about.get("kinematics"))
    return response, about


def to_xarray(response: Response) -> "xr.Dataset":
    """Give a response as a data set with units.

    Parameters
    ----------
    response : Response
        The response.

    Returns
    -------
    xarray.Dataset
        The arrays over time, point, axis, mesh and bearing; the state at the end as variables
        ``final_...``.
    """
    import xarray as xr  # noqa: PLC0415  # an extra

    arrays = {name: values for name, values in _arrays(response).items() if values.size}
    data = response._data
    variables: dict[str, Any] = {}
    for name, values in arrays.items():
        if name in _CHANNELS:
            unit, axes = _CHANNELS[name]
            variables[name] = (axes, values, {"units": unit})
        elif name.startswith("final_"):
            # netCDF has no complex numbers: real and imaginary part stand side by side.
            parts = values.view(np.float64).reshape(-1, 2) if np.iscomplexobj(values) else values
            variables[name] = ((f"{name}_entry", "part")[: parts.ndim], parts)
    labels = {
        "point": [
            "+".join(names) or f"{shaft}@{position:g}" for shaft, position, names in data["points"]
        ],
        "mesh": ["/".join(pair) for pair in data["meshes"]],
        "bearing": [f"{shaft}@{position:g}" for shaft, position in data["bearings"]],
    }
    coordinates: dict[str, Any] = {
        name: (name, np.array(label)) for name, label in labels.items() if label
    }
    coordinates["axis"] = ("axis", np.array(["y", "z"]))
    if "time" in arrays:
        coordinates["time"] = ("time", response.time, {"units": "s"})
    dataset = xr.Dataset(variables, coordinates, {"metadata": _metadata(response, {})})
    for variable in dataset.variables.values():
        # Every value is a value, none stands for a missing one.
        variable.encoding["_FillValue"] = None
    return dataset


def to_dataframe(response: Response) -> "pd.DataFrame":
    """Give a response as one table.

    Parameters
    ----------
    response : Response
        The response.

    Returns
    -------
    pandas.DataFrame
        Rows by time; columns such as "g1 v [m]", "g1/g2 force [N]", "input@0.5 force_y [N]",
        "energy [J]", "work damping [J]".
    """
    import pandas as pd  # noqa: PLC0415  # an extra

    data = response._data
    columns = {}
    for i, (shaft, position, names) in enumerate(data["points"]):
        for name in names or [f"{shaft}@{position:g}"]:
            columns[f"{name} v [m]"] = data["displacement"][:, i, 0]
            columns[f"{name} w [m]"] = data["displacement"][:, i, 1]
            columns[f"{name} twist [rad]"] = data["twist"][:, i]
    for i, pair in enumerate(data["meshes"]):
        for field, values in data["mesh"].items():
            columns[f"{'/'.join(pair)} {field} [{_CHANNELS[f'mesh_{field}'][0]}]"] = values[:, i]
    for i, (shaft, position) in enumerate(data["bearings"]):
        for axis, direction in enumerate("yz"):
            columns[f"{shaft}@{position:g} force_{direction} [N]"] = data["bearing_force"][
                :, i, axis
            ]
    if data["energy"] is not None:
        columns["energy [J]"] = data["energy"]
    for name, values in (data["energy_terms"] or {}).items():
        columns[f"{'energy' if name in ENERGIES else 'work'} {name} [J]"] = values
    table: pd.DataFrame = pd.DataFrame(columns, index=pd.Index(response.time, name="time [s]"))
    return table


def _named(arrays: dict[str, NDArray[Any]], prefix: str) -> dict[str, NDArray[Any]]:
    """Give the arrays whose names begin so, by what follows."""
    return {
        name.removeprefix(prefix): values
        for name, values in arrays.items()
        if name.startswith(prefix)
    }


def _arrays(response: Response) -> dict[str, NDArray[Any]]:
    data = response._data
    arrays: dict[str, NDArray[Any]] = {
        "time": data["time"],
        "displacement": data["displacement"],
        "twist": data["twist"],
        "bearing_force": data["bearing_force"],
    }
    arrays |= {f"mesh_{name}": values for name, values in data["mesh"].items()}
    if data["energy"] is not None:
        arrays["energy"] = data["energy"]
    terms = data["energy_terms"] or {}
    arrays |= {f"energy_{name}": values for name, values in terms.items()}
    state = data["final"].items()
    return arrays | {
        f"final_{name}": value for name, value in state if isinstance(value, np.ndarray)
    }


def _metadata(response: Response, more: dict[str, Any]) -> str:
    """Put what is not an array into text, in which a float reads back as the same one."""
    data = response._data
    arrays = _arrays(response)
    return json.dumps(
        {
            "format": _FORMAT,
            "speed": plain_speed(response.speed),
            "expected_error": response.expected_error,
            "accuracy": response.accuracy,
            "kinematics": None if response.kinematics is None else asdict(response.kinematics),
            "points": data["points"],
            "bearings": data["bearings"],
            "meshes": data["meshes"],
            "statistics": data["statistics"],
            "events": data["events"],
            "final": {
                name: value
                for name, value in data["final"].items()
                if not isinstance(value, np.ndarray)
            },
            "empty": {
                name: (values.shape, str(values.dtype))
                for name, values in arrays.items()
                if not values.size
            },
            "complex": [name for name, values in arrays.items() if np.iscomplexobj(values)],
            **more,
        }
    )


def _read_npz(path: str | os.PathLike[str]) -> tuple[dict[str, NDArray[Any]], str]:
    try:
        with Path(path).open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except (ValueError, EOFError, AttributeError, zipfile.BadZipFile) as error:
        raise GearbowError(f"{path}: not a response of gearbow: {error}") from None
    return arrays, str(arrays.pop("metadata"))


def _read_netcdf(path: str | os.PathLike[str]) -> tuple[dict[str, NDArray[Any]], str]:
    import xarray as xr  # noqa: PLC0415  # an extra

    # Times are plain seconds, not dates.
    with xr.open_dataset(
        path, engine="h5netcdf", decode_times=False, mask_and_scale=False
    ) as dataset:
        metadata = str(dataset.attrs["metadata"])
        names = [*dataset.data_vars, *(["time"] if "time" in dataset.coords else [])]
        arrays = {str(name): np.ascontiguousarray(dataset[name].to_numpy()) for name in names}
    for name in json.loads(metadata)["complex"]:
        if name in arrays:
            arrays[name] = arrays[name].view(np.complex128).reshape(-1)
    return arrays, metadata


def suffix(path: str | os.PathLike[str]) -> str:
    """Tell the format of a file.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    str
        ".npz" or ".nc".

    Raises
    ------
    GearbowError
        If the suffix is another.
    """
    ending = Path(path).suffix
    if ending not in {".npz", ".nc"}:
        raise GearbowError(f"{path}: the name of a response's file ends with .npz or .nc")
    return ending
