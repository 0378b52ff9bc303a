"""Preparation of a run, and its checkpoints."""

import json
import math
import os
import time
from collections.abc import Callable, Iterable, Mapping
from types import TracebackType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gearbow._convert import BYTES, number, real, shown
from gearbow._core import __version__, check_final
from gearbow._files import FileLock, differences, short
from gearbow._types import Array, CoreCheckpoint, Plain, Progress, RunData
from gearbow.analysis.protocol import System
from gearbow.description.places import place
from gearbow.description.speed import SpeedProfile
from gearbow.errors import CheckpointWarning, GearbowError, SceneError, SceneWarning, warn
from gearbow.recording import container
from gearbow.recording.channels import signals, with_signals
from gearbow.recording.container import archive_name
from gearbow.recording.record import RunRecord
from gearbow.results.response import Response
from gearbow.results.steady import SteadyState


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
        warn(
            f"speed: the last time is {last:g} s, but the run ends at {end:g} s; the speed stays "
            f"{float(profile([last])[0]):g} rad/s. Give times up to the end of the run, or "
            "gb.SpeedProfile.table(times, speeds), which means a constant speed afterwards",
            SceneWarning,
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


# Checkpoint file of a long run.
#
# The file is a response with the data recorded so far. Its metadata contain the state of the
# interrupted run and the arguments of the run, so that only the same run can continue from it. A
# lock file prevents simultaneous use by a second run.

#: Runs the core. Arguments: remaining times, state of the interrupted run, progress callable.
Core: TypeAlias = Callable[[Array, CoreCheckpoint | None, Progress], RunData]


class _Due(Exception):  # noqa: N818  # it is not an error
    """It is time to write the file."""


class Checkpoint:
    """Checkpoint file of one run. Within a ``with`` statement no other run can use it."""

    def __init__(
        self, path: str | os.PathLike[str], interval: float, asked: Mapping[str, Any]
    ) -> None:
        self.path = archive_name(path, "checkpoint")
        self.interval = interval
        if not self.path.parent.is_dir():
            raise SceneError(f"checkpoint: there is no folder {self.path.parent}")
        self._asked = json.loads(json.dumps({"version": __version__, **_plain(asked)}))
        self._kept: RunData | None = None
        self._lock = FileLock(self.path, "checkpoint", "run")
        self.complete: RunRecord | None = None

    def __enter__(self) -> "Checkpoint":
        self._read()
        if self.complete is None:
            self._lock.acquire()
            try:
                self._read()  # Another run may have written the file before this run locked it.
            except BaseException:
                self._lock.release()
                raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._lock.release()

    def _read(self) -> None:
        """Read the file, if it exists."""
        self._kept = None
        try:
            record, about = container.read(self.path)
        except FileNotFoundError:
            return
        except (GearbowError, OSError) as error:
            raise self._invalid(error) from None
        try:
            known = about["checkpoint"]
            asked, checkpoint = known["asked"], known["checkpoint"]
            if checkpoint is not None:
                check_final(record.data["final"], checkpoint)
            different = list(differences(asked, self._asked))
        except (KeyError, TypeError):
            message = "it is a response without a valid checkpoint entry"
            raise self._invalid(message) from None
        except (GearbowError, RecursionError) as error:
            raise self._invalid(error) from None
        for where, was, now in different:
            raise SceneError(
                f"checkpoint: {self.path} belongs to a run with {where} {short(was)}, "
                f"not {short(now)}"
            )
        if checkpoint is None:
            self.complete = record
        else:
            self._kept = {**record.data, "checkpoint": checkpoint}

    def _invalid(self, reason: object) -> SceneError:
        return SceneError(
            f"checkpoint: {self.path} exists but is not valid, nothing was run: {reason}"
        )

    def run(
        self,
        core: Core,
        times: Array,
        speed: float | SpeedProfile,
        progress: Progress | None,
    ) -> RunData:
        """Run to the end, and write the file at regular intervals."""
        while True:
            kept = self._kept
            done = 0 if kept is None else kept["time"].size
            checkpoint = None if kept is None else (kept["final"], kept["checkpoint"])
            watch = _Watch(self.interval, progress)
            try:
                return _joined(kept, core(times[done:], checkpoint, watch))
            except BaseException as error:
                partial: RunData | None = getattr(error, "partial", None)
                if kept is not None and partial is None and isinstance(error, SceneError):
                    raise self._invalid(error) from None  # the state in the file does not fit
                joined = kept if partial is None else _joined(kept, partial)
                if joined is None:
                    raise
                self._kept = joined
                if (
                    watch.fraction < 1.0
                ):  # otherwise only the progress callable failed after the end of the run
                    self._write(joined, speed)
                if not isinstance(error, _Due):
                    error.partial = joined  # type: ignore[attr-defined]
                    raise

    def _write(self, data: RunData, speed: float | SpeedProfile) -> None:
        """Write the data recorded so far. An error other than a full disk carries the data."""
        try:
            self._save(RunRecord(data, speed), data["checkpoint"])
        except BaseException as error:
            error.partial = data  # type: ignore[attr-defined]
            raise

    def finish(self, record: RunRecord) -> None:
        """Write the complete run."""
        self._save(record, None)

    def _save(self, record: RunRecord, checkpoint: dict[str, Plain] | None) -> None:
        try:
            container.save(
                record, self.path, checkpoint={"asked": self._asked, "checkpoint": checkpoint}
            )
        except (OSError, MemoryError) as error:
            reason = getattr(error, "strerror", None) or str(error) or "out of memory"
            message = f"checkpoint: {self.path} could not be written and is unchanged: {reason}"
            warn(message, CheckpointWarning)


class _Watch:
    """Forwards the progress of a run, and interrupts the run when it is time to write the file."""

    def __init__(self, interval: float, progress: Progress | None) -> None:
        self.interval = interval
        self.progress = progress
        self.fraction = 0.0
        self._begun: tuple[float, float] | None = None

    def __call__(self, fraction: float) -> None:
        self.fraction = fraction
        now = time.monotonic()
        # The time counts from the first report, after the set-up. At least one step is done between
        # two writings.
        at, begun = self._begun = self._begun or (now, fraction)
        if self.progress is not None:
            self.progress(fraction)
        if begun < fraction < 1.0 and now - at >= self.interval:
            raise _Due


def _joined(first: RunData | None, second: RunData) -> RunData:
    """Append recorded data to the data recorded before."""
    if first is None:
        return second

    before, after = signals(first), signals(second)
    found = {name: np.concatenate([before[name], values]) for name, values in after.items()}
    times = np.concatenate([first["time"], second["time"]])
    joined = with_signals(second, times, found)
    joined["events"] = [*first["events"], *second["events"]]
    return joined


def _plain(value: Any) -> Any:
    """Convert arguments for JSON. The length and digest of an array represent it."""
    if isinstance(value, Mapping):
        return {str(name): _plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.ndarray):
        from hashlib import sha256  # noqa: PLC0415

        digest = sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return {"length": value.size, "digest": digest}
    return value.item() if isinstance(value, np.generic) else value
