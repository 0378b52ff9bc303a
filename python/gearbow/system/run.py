"""Arguments and recorded data of a run."""

import math
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearbow._convert import BYTES, number, real, shown
from gearbow._types import RunData
from gearbow.analysis.protocol import System
from gearbow.description.places import place
from gearbow.description.speed import SpeedProfile
from gearbow.errors import SceneError, SceneWarning, outside
from gearbow.recording.channels import signals, with_signals
from gearbow.results.response import Response
from gearbow.results.steady import SteadyState

#: Accepted types of the speed of a run.
SpeedLike: TypeAlias = float | SpeedProfile | Callable[[Any], Any] | tuple[ArrayLike, ArrayLike]


def given_speed(speed: object, begin: float, duration: float) -> float | SpeedProfile:
    """Read the speed of a run: a number, a profile, a function of time, or points."""
    if isinstance(speed, SpeedProfile):
        return speed
    if callable(speed):
        return SpeedProfile.function(speed, duration, begin=begin)
    if isinstance(speed, (tuple, list)) and len(speed) == 2:
        return SpeedProfile.table(*speed)
    if isinstance(speed, np.ndarray) and speed.ndim > 0 and len(speed) == 2:
        return SpeedProfile.table(*speed)
    wanted = "a number, a SpeedProfile, a function of time or (times, speeds)"
    found = float(real(speed, "speed", wanted))
    if not math.isfinite(found):
        raise SceneError(f"speed: must be finite, got {found}")
    return found


def warn_of_early_end(speed: object, profile: float | SpeedProfile, end: float) -> None:
    """Warn if points of the speed end before the run; a profile says by its class that it stays."""
    if isinstance(speed, SpeedProfile) or not isinstance(profile, SpeedProfile):
        return
    last = float(profile.breaks[-1])
    if last < end * (1.0 - 1e-9):
        warnings.warn(
            f"speed: the last time is {last:g} s, but the run ends at {end:g} s; the speed stays "
            f"{float(profile([last])[0]):g} rad/s. Give times up to the end of the run, or "
            "gb.SpeedProfile.table(times, speeds), which means a constant speed afterwards",
            SceneWarning,
            stacklevel=outside(),
        )


def beginning(initial: object, start: float | None) -> tuple[str | dict[str, Any], float]:
    """Read the initial state and the start time. A continued run starts at the end of the other."""
    if isinstance(initial, SteadyState):
        initial = initial.response
    if isinstance(initial, Response):
        initial = initial.final
    if isinstance(initial, str):
        return initial, 0.0 if start is None else number(start, "start")
    if not isinstance(initial, Mapping) or "time" not in initial:
        raise SceneError(f"initial: must be a name or a response, got {shown(initial)}")
    if start is not None:
        raise SceneError("start: cannot be given with a response to continue; leave it out")
    return dict(initial), number(initial["time"], "initial.time")


def in_order(data: RunData, rows: NDArray[np.intp] | None) -> RunData:
    """Arrange rows in the order of the given times. An incomplete run has only the first rows."""
    data = data.copy()
    data.pop("checkpoint", None)
    if rows is None:
        return data
    rows = rows[rows < data["time"].size]
    found = {name: values[rows] for name, values in signals(data).items()}
    return with_signals(data, data["time"][rows], found)


def requests(record: object, system: System) -> list[Any]:
    """Convert the argument `record` to names and tuples of names and positions."""
    if record is None:
        # What a user of this system looks at first.
        if system.gears:
            return ["gears", "meshes"]
        return ["disks" if system.disks else "nodes", "bearings"]
    if isinstance(record, str):
        return [record]
    if not isinstance(record, Iterable) or isinstance(record, (Mapping, *BYTES)):
        raise SceneError(f"record: must be a list of names or tuples, got {shown(record)}")
    return [place(entry, f"record[{i}]") for i, entry in enumerate(record)]
