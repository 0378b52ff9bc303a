"""A recorded run as a data set or a table, and its arrays and metadata in a file."""

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearbow._extras import extra
from gearbow._types import Array, RunData
from gearbow.description.speed import plain_speed
from gearbow.recording.channels import CHANNELS, OWNERS, signals
from gearbow.recording.record import RunRecord

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["FORMAT", "arrays_of", "metadata_of", "to_dataframe", "to_xarray"]

#: Number of the file format. It increases if older readers cannot read a newer file.
FORMAT = 1


def to_xarray(run: RunRecord) -> "xr.Dataset":
    """Convert a recorded run to a data set with units."""
    with extra("netcdf"):
        import xarray as xr  # noqa: PLC0415

    arrays = {name: values for name, values in arrays_of(run).items() if values.size}
    data = run.data
    variables: dict[str, Any] = {}
    for name, values in arrays.items():
        if name in CHANNELS:
            channel = CHANNELS[name]
            variables[name] = (channel.axes, values, {"units": channel.unit})
        elif name.startswith("final_"):
            variables[name] = ((f"{name}_entry",), values)
    labels = {owner: ["+".join(names) for names in _labels(data, owner)] for owner in OWNERS}
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

    columns: dict[str, Array] = {}
    recorded = signals(run.data)
    for owner in (*OWNERS, None):
        own = {name: values for name, values in recorded.items() if CHANNELS[name].owner == owner}
        places = [("",)] if owner is None else _labels(run.data, owner)
        for i, label in ((i, label) for i, names in enumerate(places) for label in names):
            for name, values in own.items():
                channel = CHANNELS[name]
                series = values if owner is None else values[:, i]
                parts = series.reshape(-1, len(channel.quantities)).T
                for quantity, part in zip(channel.quantities, parts, strict=True):
                    columns[f"{label} {quantity} [{channel.unit}]".lstrip()] = part
    table: pd.DataFrame = pd.DataFrame(columns, index=pd.Index(run.time, name="time [s]"))
    return table


def _labels(data: RunData, owner: str) -> list[tuple[str, ...]]:
    """Give the labels of the places of a kind; a point may have several names."""
    if owner == "point":
        points = data["points"]
        return [tuple(names) or (f"{shaft}@{position:g}",) for shaft, position, names in points]
    if owner == "mesh":
        return [("/".join(pair),) for pair in data["meshes"]]
    bearings = data["bearings"] if owner == "bearing" else data["rolling_bearings"]
    return [(f"{shaft}@{position:g}",) for shaft, position in bearings]


def arrays_of(run: RunRecord) -> dict[str, NDArray[Any]]:
    """Collect all arrays of a recorded run by their names in a file."""
    state = run.data["final"].items()
    return {
        "time": run.time,
        **signals(run.data),
        **{f"final_{name}": value for name, value in state if isinstance(value, np.ndarray)},
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
