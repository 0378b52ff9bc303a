"""A recorded run as a data set or a table, and its arrays and metadata in a file."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearbow._extras import extra
from gearbow._result import Column, written_unit
from gearbow._types import Array, RunData
from gearbow.description.places import place_label
from gearbow.description.speed import plain_speed
from gearbow.recording.channels import CHANNELS, OWNERS, signals
from gearbow.recording.record import RunRecord

if TYPE_CHECKING:
    import xarray as xr

#: Size of a mean value that is an error of the times of a run, relative to its extremes.
_ROUND_OFF = 1e-4
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


def series(run: RunRecord) -> list[Column]:
    """Give the times and all recorded signals as columns."""
    columns = [Column("time", run.time, "s")]
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
                    columns.append(Column(f"{label} {quantity}".lstrip(), part, channel.unit))
    return columns


def summary(run: RunRecord) -> list[Column]:
    """Give a row for each recorded signal: mean, extremes and peak-to-peak value."""
    names: list[str] = []
    units: list[str] = []
    values: list[Array] = []

    def add(name: str, signal: Array, unit: str) -> None:
        factor, own = written_unit(unit)
        names.append(name)
        units.append(own)
        values.append(factor * signal)

    data = run.data
    for i, (shaft, x, labels) in enumerate(data["points"]):
        label = ", ".join(labels) or place_label((shaft, x))
        for along, moved in zip("yz", data["displacement"][:, i].T, strict=True):
            add(f"{label} {along}", moved, "m")
    for i, pair in enumerate(data["meshes"]):
        add(f"{'/'.join(pair)} force", data["mesh"]["force"][:, i], "N")
        add(f"{'/'.join(pair)} contact ratio", data["mesh"]["contact_ratio"][:, i], "")
    for i, bearing in enumerate(data["bearings"]):
        force = np.hypot(*data["bearing_force"][:, i].T)
        add(f"bearing {place_label(bearing)} force", force, "N")
    if data["energy"] is not None:
        add("energy", data["energy"], "J")
    known = np.array(values).reshape(len(values), data["time"].size)
    if not known.size:
        known = np.full((len(values), 1), np.nan)
    low, high = known.min(axis=1), known.max(axis=1)
    return [
        Column("signal", names),
        Column("mean", known.mean(axis=1), round_off=_ROUND_OFF * np.maximum(abs(low), abs(high))),
        Column("smallest", low),
        Column("largest", high),
        Column("peak-to-peak", high - low),
        Column("unit", units),
    ]


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
        "speed_unit": run.speed_unit,
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
    import json  # noqa: PLC0415  # files only

    return json.dumps(about)
