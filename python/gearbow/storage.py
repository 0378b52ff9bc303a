"""A response as a file, a data set or a table.

Both file formats hold the same: the arrays, and one JSON text for what is not an array. Nothing is
pickled, floats keep every bit, and the state at the end comes back as it was, so that a loaded
response can be continued.
"""

import json
import os
from dataclasses import asdict, fields
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearbow._container import Container, Header, netcdf_bytes, opened, suffix
from gearbow._core import check_final
from gearbow._extras import extra
from gearbow._files import replacing
from gearbow._run import plain_speed, read_speed
from gearbow._schema import any_number, each, number, optional, record, row, text, whole
from gearbow.energy import ENERGIES, WORKS
from gearbow.errors import GearbowError
from gearbow.orders.kinematics import Kinematics
from gearbow.response import MeshResponse, Response, Statistics

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


#: Arrays of the final state. The number of their entries depends on the method.
_STATE = {"state": np.float64, "memory": np.float64, "contact_modes": np.int64}

#: What the metadata must hold.
_METADATA = record(
    format=whole,
    expected_error=optional(number),
    accuracy=optional(text),
    kinematics=optional(
        record(shafts=each(row(text, number)), meshes=each(row(text, text, text, text, number)))
    ),
    points=each(row(text, number, each(text))),
    bearings=each(row(text, number)),
    meshes=each(row(text, text)),
    statistics=record(
        **dict.fromkeys(("steps", "rejected", "evaluations", "events"), whole),
        **dict.fromkeys(("step_min", "step_max", "omega_max", "condition"), any_number),
        limited_by=text,
    ),
    events=each(row(number, text, text, text)),
    final=record(),
    empty=record(),
)
#: A speed that changes; a constant one is a number.
_PROFILE = record(breaks=each(number), coefficients=each(each(number)))


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
        If the suffix is another, or the libraries for it are missing.
    OSError
        If it cannot be written; a file that was there is still there.
    """
    ending = suffix(path)
    metadata = _metadata(response, more)
    if ending == ".nc":
        content = netcdf_bytes(to_xarray(response).assign_attrs(metadata=metadata))
        with replacing(path) as file:
            for part in content:
                file.write(part)
        return
    with replacing(path) as file:
        np.savez(file, metadata=np.array(metadata), **_arrays(response))  # type: ignore[arg-type]


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
        If the suffix is another, or the file is damaged or holds something else; the text names
        the file and the problem.
    OSError
        If the file cannot be opened.
    """
    return read(path)[0]


def read(path: str | os.PathLike[str]) -> tuple[Response, dict[str, Any]]:
    """Read a file that `save` wrote, with all that stands beside the arrays.

    Everything is checked before memory is allocated for it: reading an invalid file takes no more
    memory than a small multiple of its size.

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
        If the suffix is another, or the file is damaged or holds something else; the text names
        the file and the problem.
    OSError
        If the file cannot be opened.
    """
    with opened(path) as file:
        about = json.loads(file.metadata())
        record(format=whole)(about, "")
        if about["format"] != _FORMAT:
            raise GearbowError(
                f"it is written in format {about['format']}, this version reads {_FORMAT}"
            )
        _METADATA(about, "")
        (_PROFILE if isinstance(about.get("speed"), dict) else number)(about.get("speed"), "speed")
        arrays = _read_arrays(file, about)
        return _response(about, arrays), about


def _read_arrays(file: Container, about: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """Read all arrays, each after a check of its type and shape."""

    def header(name: str) -> Header | None:
        # What has no elements has no place in netCDF; the metadata tell of it.
        if name not in about["empty"]:
            return file.header(name)
        row(each(whole), text)(about["empty"][name], f"empty.{name}")
        shape, kind = about["empty"][name]
        if prod(shape) != 0:
            raise GearbowError(f"empty.{name}: must have no elements, has shape {shape}")
        return tuple(shape), np.dtype(kind)

    time = header("time")
    sizes: dict[str, int | None] = {
        "time": time[0][0] if time is not None and time[0] else 0,
        "axis": 2,
        **{f"{name}": len(about[f"{name}s"]) for name in ("point", "bearing")},
        "mesh": len(about["meshes"]),
    }
    expected: dict[str, tuple[type, tuple[int | None, ...]]] = {
        "time": (np.float64, (sizes["time"],)),
        **{
            name: (np.float64, tuple(sizes[axis] for axis in axes))
            for name, (_, axes) in _CHANNELS.items()
        },
        **{f"final_{name}": (kind, (None,)) for name, kind in _STATE.items()},
    }
    energies = [name for name in expected if name.startswith("energy")]
    if all(header(name) is None for name in energies):
        expected = {name: value for name, value in expected.items() if name not in energies}
    arrays: dict[str, NDArray[Any]] = {}
    for name, (kind, shape) in expected.items():
        found = header(name)
        if found is None:
            raise GearbowError(f"{name}: is missing")
        fits = len(found[0]) == len(shape) and all(
            wanted in {None, size} for size, wanted in zip(found[0], shape, strict=True)
        )
        if found[1].newbyteorder("=") != kind or not fits:
            wanted = ", ".join("any" if size is None else str(size) for size in shape)
            raise GearbowError(
                f"{name}: must be {np.dtype(kind)} of shape ({wanted}), is {found[1]} of shape "
                f"{found[0]}"
            )
        values = np.empty(found[0]) if name in about["empty"] else file.read(name)
        arrays[name] = np.ascontiguousarray(values, dtype=kind)
    return arrays


def _response(about: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> Response:
    """Make a response of what was read."""
    final = {**about["final"], **{name: arrays[f"final_{name}"] for name in _STATE}}
    check_final(final)
    mesh = {field.name: arrays[f"mesh_{field.name}"] for field in fields(MeshResponse)}
    energies = {name: arrays.get(f"energy_{name}") for name in (*ENERGIES, *WORKS)}
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
            "energy_terms": energies if "energy" in arrays else None,  # type: ignore[typeddict-item]
            "events": [tuple(event) for event in about["events"]],
            "final": final,
            "statistics": {
                field.name: about["statistics"][field.name] for field in fields(Statistics)
            },
        },
        read_speed(about["speed"]),
    )
    response.expected_error, response.accuracy = about["expected_error"], about["accuracy"]
    response.kinematics = Kinematics._from_plain(about["kinematics"])
    return response


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
    with extra("netcdf"):
        import xarray as xr  # noqa: PLC0415

    arrays = {name: values for name, values in _arrays(response).items() if values.size}
    data = response._data
    variables: dict[str, Any] = {}
    for name, values in arrays.items():
        if name in _CHANNELS:
            unit, axes = _CHANNELS[name]
            variables[name] = (axes, values, {"units": unit})
        elif name.startswith("final_"):
            variables[name] = ((f"{name}_entry",), values)
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
    with extra("dataframe"):
        import pandas as pd  # noqa: PLC0415

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
    about = {
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
        **more,
    }
    return json.dumps(about)
