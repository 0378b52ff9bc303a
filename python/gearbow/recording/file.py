"""Files of responses.

Both file formats contain the arrays, and one JSON text with all other data. Nothing is pickled.
Numbers are not rounded, so that a run can continue from a loaded response.
"""

import json
import os
from dataclasses import fields
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearbow._core import check_final
from gearbow._files import replacing
from gearbow.description.kinematics import Kinematics
from gearbow.description.speed import read_speed
from gearbow.errors import GearbowError
from gearbow.recording.channels import MESH, RATES, ROLLING
from gearbow.recording.container import Container, Header, opened, suffix, write_netcdf
from gearbow.recording.energy import ENERGIES, WORKS
from gearbow.recording.errors import ErrorEstimate, Errors
from gearbow.recording.record import RunRecord
from gearbow.recording.request import OPTIONS, RunRequest
from gearbow.recording.schema import (
    any_number,
    anything,
    each,
    entries,
    flag,
    number,
    optional,
    record,
    row,
    text,
    whole,
)
from gearbow.recording.tables import CHANNELS, FORMAT, OPTIONAL, arrays_of, metadata_of, to_xarray

__all__ = ["load", "read", "save"]

#: Arrays of the final state. Their lengths depend on the method.
_STATE = {"state": np.float64, "memory": np.float64, "contact_modes": np.int64}

#: Required entries of the metadata.
_METADATA = record(
    format=whole,
    accuracy=optional(text),
    request=optional(
        record(description=record(), options=record(**dict.fromkeys(OPTIONS, anything)))
    ),
    errors=optional(
        record(
            window=number,
            chaotic=flag,
            estimates=entries(record(**{each.name: number for each in fields(ErrorEstimate)})),
        )
    ),
    kinematics=optional(
        record(
            shafts=each(row(text, number)),
            meshes=each(row(text, text, text, text, number)),
            bearings=each(row(text, number, number)),
            forces=each(row(text, text, number)),
        )
    ),
    points=each(row(text, number, each(text))),
    bearings=each(row(text, number)),
    rolling_bearings=each(row(text, number)),
    meshes=each(row(text, text)),
    statistics=record(
        **dict.fromkeys(("steps", "rejected", "evaluations", "events"), whole),
        **dict.fromkeys(("step_min", "step_max", "omega_max", "condition"), any_number),
        limited_by=text,
        modes=optional(whole),
        modes_error=optional(row(any_number, any_number)),
    ),
    events=each(row(number, text, text, text)),
    final=record(),
    empty=record(),
)
#: A changing speed; a constant speed is a number.
_PROFILE = record(breaks=each(number), coefficients=each(each(number)))


def save(run: RunRecord, path: str | os.PathLike[str], **more: Any) -> None:
    """Write a recorded run to a ``.npz`` or ``.nc`` file, completely or not at all."""
    path, ending = suffix(path)
    metadata = metadata_of(run, more)
    if ending == ".nc":
        dataset = to_xarray(run).assign_attrs(metadata=metadata)
        with replacing(path) as file:
            write_netcdf(dataset, file)
        return
    with replacing(path) as file:
        np.savez(file, metadata=np.array(metadata), **arrays_of(run))  # type: ignore[arg-type]


def load(path: str | os.PathLike[str]) -> RunRecord:
    """Read a file of `save`."""
    return read(path)[0]


def read(path: str | os.PathLike[str]) -> tuple[RunRecord, dict[str, Any]]:
    """Read a file of `save` with its metadata."""
    with opened(path) as file:
        about = json.loads(file.metadata())
        record(format=whole)(about, "")
        if about["format"] != FORMAT:
            raise GearbowError(
                f"it has the format {about['format']}, this version of gearbow reads {FORMAT}"
            )
        # A file may leave out rolling bearings.
        about.setdefault("rolling_bearings", [])
        if isinstance(about.get("kinematics"), dict):
            about["kinematics"].setdefault("bearings", [])
            about["kinematics"].setdefault("forces", [])
        checked = dict(about)
        if isinstance(about.get("statistics"), dict):
            # A file may leave out the reduction of a run with all modes.
            checked["statistics"] = {"modes": None, "modes_error": None, **about["statistics"]}
        _METADATA(checked, "")
        (_PROFILE if isinstance(about.get("speed"), dict) else number)(about.get("speed"), "speed")
        arrays = _read_arrays(file, about)
        return _run(about, arrays), about


def _read_arrays(file: Container, about: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """Check the type and shape of each array, then read it."""

    def header(name: str) -> Header | None:
        # The metadata describe arrays without elements, which netCDF cannot contain.
        if name not in about["empty"]:
            return file.header(name)
        row(each(whole), text)(about["empty"][name], f"empty.{name}")
        shape, kind = about["empty"][name]
        if prod(shape) != 0:
            raise GearbowError(f"empty.{name}: must have no elements, got the shape {shape}")
        return tuple(shape), np.dtype(kind)

    time = header("time")
    sizes: dict[str, int | None] = {
        "time": time[0][0] if time is not None and time[0] else 0,
        "axis": 2,
        **{f"{name}": len(about[f"{name}s"]) for name in ("point", "bearing")},
        "mesh": len(about["meshes"]),
        "rolling": len(about["rolling_bearings"]),
    }
    expected: dict[str, tuple[type, tuple[int | None, ...]]] = {
        "time": (np.float64, (sizes["time"],)),
        **{
            name: (np.float64, tuple(sizes[axis] for axis in axes))
            for name, (_, axes) in CHANNELS.items()
        },
        **{f"final_{name}": (kind, (None,)) for name, kind in _STATE.items()},
    }
    # A run without energies or rates, a system without axial motion, and an older file lack these
    # arrays.
    for group in ("energy", *RATES, "axial", "bearing_displacement"):
        names = [name for name in expected if name.startswith(group)]
        if all(header(name) is None for name in names):
            expected = {name: value for name, value in expected.items() if name not in names}
    if not about["rolling_bearings"]:
        expected = {
            name: value for name, value in expected.items() if not name.startswith("rolling_")
        }
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
                f"{name}: must be {np.dtype(kind)} of shape ({wanted}), got {found[1]} of shape "
                f"{found[0]}"
            )
        values = np.empty(found[0]) if name in about["empty"] else file.read(name)
        arrays[name] = np.ascontiguousarray(values, dtype=kind)
    return arrays


def _run(about: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> RunRecord:
    """Make a recorded run from checked data."""
    final = {**about["final"], **{name: arrays[f"final_{name}"] for name in _STATE}}
    check_final(final)
    mesh = {name: arrays[f"mesh_{name}"] for name in MESH}
    rolling = [arrays[f"rolling_{name}"] for name in ROLLING if about["rolling_bearings"]]
    contact = np.stack(rolling, 2) if rolling else np.empty((arrays["time"].size, 0, len(ROLLING)))
    energies = {name: arrays.get(f"energy_{name}") for name in (*ENERGIES, *WORKS)}
    return RunRecord(
        data={
            "time": arrays["time"],
            "points": [(shaft, position, names) for shaft, position, names in about["points"]],
            "displacement": arrays["displacement"],
            "twist": arrays["twist"],
            "bearings": [(shaft, position) for shaft, position in about["bearings"]],
            "bearing_force": arrays["bearing_force"],
            "rolling_bearings": [
                (shaft, position) for shaft, position in about["rolling_bearings"]
            ],
            "rolling_contact": contact,
            "meshes": [(driver, driven) for driver, driven in about["meshes"]],
            "mesh": mesh,
            "energy": arrays.get("energy"),
            "energy_terms": energies if "energy" in arrays else None,
            "events": [tuple(event) for event in about["events"]],
            "final": final,
            "statistics": {
                # JSON has lists, the core gives tuples.
                name: tuple(value) if isinstance(value, list) else value
                for name, value in about["statistics"].items()
            },
            **{name: arrays[name] for name in OPTIONAL if name in arrays},  # type: ignore[typeddict-item]
        },
        speed=read_speed(about["speed"]),
        kinematics=Kinematics.from_plain(about["kinematics"]),
        accuracy=about["accuracy"],
        request=RunRequest.from_plain(about["request"]),
        errors=Errors.from_plain(about["errors"]),
    )
