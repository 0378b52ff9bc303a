"""Files of recorded runs.

An archive contains the arrays, and one JSON text with all other data. Nothing is pickled. Numbers
are not rounded, so that a run can continue from a loaded response.
"""

import json
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearbow._core import check_final
from gearbow._files import replacing
from gearbow.description.layout import Kinematics
from gearbow.description.speed import read_speed
from gearbow.errors import GearbowError
from gearbow.recording.channels import (
    CHANNELS,
    FORMAT,
    OWNERS,
    arrays_of,
    metadata_of,
    with_signals,
)
from gearbow.recording.container import (
    Archive,
    any_number,
    anything,
    archive_name,
    each,
    entries,
    flag,
    number,
    opened,
    optional,
    record,
    row,
    text,
    typed,
    whole,
)
from gearbow.recording.record import (
    OPTIONS,
    ErrorEstimate,
    Errors,
    RunRecord,
    RunRequest,
    Statistics,
)
from gearbow.units.speed import speed_factor

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
            estimates=entries(typed(ErrorEstimate)),
        )
    ),
    kinematics=optional(typed(Kinematics)),
    points=each(row(text, number, each(text))),
    bearings=each(row(text, number)),
    rolling_bearings=each(row(text, number)),
    meshes=each(row(text, text)),
    sections=each(row(text, number, text)),
    statistics=typed(Statistics, any_number),
    events=each(row(number, text, text, text)),
    final=record(),
)
#: A changing speed; a constant speed is a number.
_PROFILE = record(breaks=each(number), coefficients=each(each(number)))


def save(run: RunRecord, path: str | os.PathLike[str], **more: Any) -> None:
    """Write a recorded run to an archive, completely or not at all."""
    metadata = np.array(metadata_of(run, more))
    with replacing(archive_name(path)) as file:
        np.savez(file, metadata=metadata, **arrays_of(run))  # type: ignore[arg-type]


def read(path: str | os.PathLike[str], argument: str = "path") -> tuple[RunRecord, dict[str, Any]]:
    """Read a file of `save` with its metadata."""
    with opened(path, argument) as file:
        about = json.loads(file.metadata())
        record(format=whole)(about, "")
        if about["format"] != FORMAT:
            raise GearbowError(
                f"it has the format {about['format']}, this version of gearbow reads {FORMAT}"
            )
        # A file may leave out rolling bearings, sections, and the unit of the speed.
        about.setdefault("speed_unit", "rad/s")
        about.setdefault("rolling_bearings", [])
        about.setdefault("sections", [])
        if isinstance(about.get("kinematics"), dict):
            about["kinematics"].setdefault("bearings", [])
            about["kinematics"].setdefault("forces", [])
        checked = dict(about)
        if isinstance(about.get("statistics"), dict):
            # A file may leave out the reduction of a run with all modes.
            checked["statistics"] = {"modes": None, "modes_error": None, **about["statistics"]}
        _METADATA(checked, "")
        speed_factor(about["speed_unit"])
        (_PROFILE if isinstance(about.get("speed"), dict) else number)(about.get("speed"), "speed")
        arrays = _read_arrays(file, about)
        return _run(about, arrays), about


def _read_arrays(file: Archive, about: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """Check the type and shape of each array, then read it."""
    time = file.header("time")
    sizes: dict[str, int | None] = {
        "time": time[0][0] if time is not None and time[0] else 0,
        "axis": 2,
        "component": 3,
        **{owner: len(about[entry]) for owner, entry in OWNERS.items()},
    }
    expected: dict[str, tuple[type, tuple[int | None, ...]]] = {
        "time": (np.float64, (sizes["time"],)),
        **{
            name: (np.float64, tuple(sizes[axis] for axis in channel.axes))
            for name, channel in CHANNELS.items()
        },
        **{f"final_{name}": (kind, (None,)) for name, kind in _STATE.items()},
    }
    # A run without energies or rates, a system without axial motion, and an older file lack the
    # arrays of a group.
    for group in {channel.group for channel in CHANNELS.values()} - {None}:
        names = [name for name, channel in CHANNELS.items() if channel.group == group]
        if all(file.header(name) is None for name in names):
            expected = {name: value for name, value in expected.items() if name not in names}
    if not about["rolling_bearings"]:
        expected = {
            name: value for name, value in expected.items() if not name.startswith("rolling_")
        }
    arrays: dict[str, NDArray[Any]] = {}
    for name, (kind, shape) in expected.items():
        found = file.header(name)
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
        arrays[name] = np.ascontiguousarray(file.read(name), dtype=kind)
    return arrays


def _run(about: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> RunRecord:
    """Make a recorded run from checked data."""
    final = {**about["final"], **{name: arrays[f"final_{name}"] for name in _STATE}}
    check_final(final)
    plain = {
        "points": [(shaft, position, names) for shaft, position, names in about["points"]],
        **{
            entry: [tuple(each) for each in about[entry]]
            for entry in ("bearings", "rolling_bearings", "meshes", "sections", "events")
        },
        "final": final,
        # JSON has lists, the core gives tuples.
        "statistics": {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in about["statistics"].items()
        },
    }
    recorded = {name: values for name, values in arrays.items() if name in CHANNELS}
    return RunRecord(
        data=with_signals(plain, arrays["time"], recorded),
        speed=read_speed(about["speed"]),
        kinematics=Kinematics.from_plain(about["kinematics"]),
        accuracy=about["accuracy"],
        request=RunRequest.from_plain(about["request"]),
        errors=Errors._from_plain(about["errors"]),
        speed_unit=about["speed_unit"],
    )
