"""A recorded run as a data set or a table, and the names, units and axes of its arrays."""

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearbow._extras import extra
from gearbow._types import Array, RunData
from gearbow.description.speed import plain_speed
from gearbow.recording.channels import BEARING, MESH, POINT, RATE_UNITS, RATES, ROLLING
from gearbow.recording.energy import ENERGIES, WORKS
from gearbow.recording.record import RunRecord

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = [
    "CHANNELS",
    "FORMAT",
    "OPTIONAL",
    "arrays_of",
    "metadata_of",
    "optional_arrays",
    "to_dataframe",
    "to_xarray",
]

#: Number of the file format. It increases if older readers cannot read a newer file.
FORMAT = 1

#: Arrays over time that a run may lack: rates, those of axial motion, and those that older files do
#: not contain.
OPTIONAL = (*RATES, "axial", "axial_bearing_force", "bearing_displacement")
#: Unit and axes of every array over time.
CHANNELS = {
    "displacement": ("m", ("time", "point", "axis")),
    "twist": ("rad", ("time", "point")),
    **{
        name: (RATE_UNITS[name], ("time", "point", "axis")[: 2 + (len(quantities) == 2)])
        for name, quantities in RATES.items()
    },
    "axial": ("m", ("time", "point")),
    "bearing_force": ("N", ("time", "bearing", "axis")),
    "bearing_displacement": ("m", ("time", "bearing", "axis")),
    "axial_bearing_force": ("N", ("time", "bearing")),
    "energy": ("J", ("time",)),
    **{f"energy_{name}": ("J", ("time",)) for name in (*ENERGIES, *WORKS)},
    **{f"mesh_{name}": (unit, ("time", "mesh")) for name, unit in MESH.items()},
    **{f"rolling_{name}": (unit, ("time", "rolling")) for name, unit in ROLLING.items()},
}


def to_xarray(run: RunRecord) -> "xr.Dataset":
    """Convert a recorded run to a data set with units."""
    with extra("netcdf"):
        import xarray as xr  # noqa: PLC0415

    arrays = {name: values for name, values in arrays_of(run).items() if values.size}
    data = run.data
    variables: dict[str, Any] = {}
    for name, values in arrays.items():
        if name in CHANNELS:
            unit, axes = CHANNELS[name]
            variables[name] = (axes, values, {"units": unit})
        elif name.startswith("final_"):
            variables[name] = ((f"{name}_entry",), values)
    labels = {
        "point": [
            "+".join(names) or f"{shaft}@{position:g}" for shaft, position, names in data["points"]
        ],
        "mesh": ["/".join(pair) for pair in data["meshes"]],
        "bearing": [f"{shaft}@{position:g}" for shaft, position in data["bearings"]],
        "rolling": [f"{shaft}@{position:g}" for shaft, position in data["rolling_bearings"]],
    }
    coordinates: dict[str, Any] = {
        name: (name, np.array(label)) for name, label in labels.items() if label
    }
    coordinates["axis"] = ("axis", np.array(["y", "z"]))
    if "time" in arrays:
        coordinates["time"] = ("time", data["time"], {"units": "s"})
    dataset = xr.Dataset(variables, coordinates, {"metadata": metadata_of(run, {})})
    for variable in dataset.variables.values():
        # No array uses a value that marks missing data.
        variable.encoding["_FillValue"] = None
    return dataset


def to_dataframe(run: RunRecord) -> "pd.DataFrame":
    """Convert a recorded run to a table."""
    with extra("dataframe"):
        import pandas as pd  # noqa: PLC0415

    data = run.data
    columns = {}
    along = data.get("axial")
    for i, (shaft, position, names) in enumerate(data["points"]):
        for name in names or [f"{shaft}@{position:g}"]:
            columns[f"{name} y [m]"] = data["displacement"][:, i, 0]
            columns[f"{name} z [m]"] = data["displacement"][:, i, 1]
            columns[f"{name} twist [rad]"] = data["twist"][:, i]
            columns |= _rate_columns(data, i, name)
            if along is not None:
                columns[f"{name} x [m]"] = along[:, i]
    for i, pair in enumerate(data["meshes"]):
        for field, values in data["mesh"].items():
            columns[f"{'/'.join(pair)} {field} [{MESH[field]}]"] = values[:, i]
    columns |= _bearing_columns(data)
    if data["energy"] is not None:
        columns["energy [J]"] = data["energy"]
    for name, values in (data["energy_terms"] or {}).items():
        columns[f"{'energy' if name in ENERGIES else 'work'} {name} [J]"] = values
    table: pd.DataFrame = pd.DataFrame(columns, index=pd.Index(data["time"], name="time [s]"))
    return table


def _rate_columns(data: RunData, point: int, name: str) -> dict[str, Array]:
    """Collect the recorded rates of a point by their names with units."""
    recorded = optional_arrays(data)
    columns: dict[str, Array] = {}
    for array, quantities in RATES.items():
        if array in recorded:
            signals = recorded[array][:, point].reshape(-1, len(quantities)).T
            for quantity, values in zip(quantities, signals, strict=True):
                columns[f"{name} {quantity} [{POINT[quantity]}]"] = values
    return columns


def _bearing_columns(data: RunData) -> dict[str, Array]:
    """Collect the quantities of bearings by their names with units."""
    columns: dict[str, Array] = {}
    thrust, displacement = data.get("axial_bearing_force"), data.get("bearing_displacement")
    for i, (shaft, position) in enumerate(data["bearings"]):
        for axis, (field, unit) in enumerate(BEARING.items()):
            columns[f"{shaft}@{position:g} {field} [{unit}]"] = data["bearing_force"][:, i, axis]
        if thrust is not None:
            columns[f"{shaft}@{position:g} force_x [N]"] = thrust[:, i]
        if displacement is not None:
            for axis, field in enumerate(("displacement_y", "displacement_z")):
                columns[f"{shaft}@{position:g} {field} [m]"] = displacement[:, i, axis]
    for i, (shaft, position) in enumerate(data["rolling_bearings"]):
        for j, (field, unit) in enumerate(ROLLING.items()):
            columns[f"{shaft}@{position:g} {field} [{unit}]"] = data["rolling_contact"][:, i, j]
    return columns


def optional_arrays(data: RunData) -> dict[str, Array]:
    """Collect the recorded arrays of those that a run may lack."""
    plain: dict[str, Any] = dict(data)
    return {name: plain[name] for name in OPTIONAL if name in plain}


def arrays_of(run: RunRecord) -> dict[str, NDArray[Any]]:
    """Collect all arrays of a recorded run by their names in a file."""
    data = run.data
    arrays: dict[str, NDArray[Any]] = {
        "time": data["time"],
        "displacement": data["displacement"],
        "twist": data["twist"],
        "bearing_force": data["bearing_force"],
    }
    arrays |= optional_arrays(data)
    arrays |= {f"mesh_{name}": values for name, values in data["mesh"].items()}
    if data["rolling_bearings"]:
        contact = data["rolling_contact"]
        arrays |= {f"rolling_{name}": contact[:, :, j].copy() for j, name in enumerate(ROLLING)}
    if data["energy"] is not None:
        arrays["energy"] = data["energy"]
    terms = data["energy_terms"] or {}
    arrays |= {f"energy_{name}": values for name, values in terms.items()}
    state = data["final"].items()
    return arrays | {
        f"final_{name}": value for name, value in state if isinstance(value, np.ndarray)
    }


def metadata_of(run: RunRecord, more: dict[str, Any]) -> str:
    """Write everything except arrays as JSON, which keeps all digits of a float."""
    data = run.data
    arrays = arrays_of(run)
    about = {
        "format": FORMAT,
        "speed": plain_speed(run.speed),
        "accuracy": run.accuracy,
        "request": None if run.request is None else run.request.plain(),
        "errors": None if run.errors is None else run.errors.plain(),
        "kinematics": None if run.kinematics is None else asdict(run.kinematics),
        "points": data["points"],
        "bearings": data["bearings"],
        "rolling_bearings": data["rolling_bearings"],
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
