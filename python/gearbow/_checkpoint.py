"""A long run that is kept in a file while it goes on, and taken up again from there.

The file is a response like any other, of what was recorded so far; beside it stands where the run
was stopped, and what it was asked, so that no other run goes on from it. A lock beside the file
keeps a second run from using it at the same time.
"""

import hashlib
import json
import os
import reprlib
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, TypeAlias

import numpy as np

from gearbow import storage
from gearbow._container import suffix
from gearbow._convert import number
from gearbow._core import __version__, check_final
from gearbow._files import BusyError, FileLock
from gearbow._types import Array, CoreCheckpoint, Plain, Progress, RunData
from gearbow.errors import CheckpointWarning, GearbowError, SceneError
from gearbow.response import Response
from gearbow.speed import SpeedProfile

#: A run of the core: the times that are left, where it was stopped, and what is told how far it is.
Core: TypeAlias = Callable[[Array, CoreCheckpoint | None, Progress], RunData]


class _Due(Exception):  # noqa: N818  # nothing went wrong
    """It is time to write the file."""


class Checkpoint:
    """The file of one run, and what it holds; within a ``with`` statement no other run uses it.

    Parameters
    ----------
    path : str or path-like
        The file; it need not be there.
    interval : float
        Wall-clock time between two writings [s].
    asked : mapping
        All that makes the run this one, as plain data and arrays.

    Attributes
    ----------
    complete : Response or None
        The whole response, if the run has come to its end. Such a file is only read.

    Raises
    ------
    SceneError
        If the folder is missing, or if the file is of another run, no checkpoint, or in use by
        another run; the text names what differs and what to do.
    MissingExtraError
        If the libraries of the format are missing.
    """

    def __init__(
        self, path: str | os.PathLike[str], interval: object, asked: Mapping[str, Any]
    ) -> None:
        self.path = Path(path)
        self.interval = number(interval, "checkpoint_interval", infinite=True)
        if not self.interval > 0.0:
            raise SceneError(f"checkpoint_interval: must be positive, got {interval!r}")
        suffix(self.path)
        if not self.path.parent.is_dir():
            raise SceneError(f"checkpoint: there is no folder {self.path.parent}")
        self._asked = json.loads(json.dumps({"version": __version__, **_plain(asked)}))
        self._kept: RunData | None = None
        self._lock = FileLock(self.path)
        self.complete: Response | None = None

    def __enter__(self) -> "Checkpoint":
        self._read()
        if self.complete is None:
            self._acquire()
            try:
                self._read()  # Another run may have written it before the lock was taken.
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

    def _acquire(self) -> None:
        try:
            self._lock.acquire()
        except BusyError:
            raise SceneError(
                f"checkpoint: {self.path} is in use by another run, of this process or of another "
                "one; wait until that run has ended, or give each run a file of its own"
            ) from None
        except OSError as error:
            raise SceneError(
                f"checkpoint: {self.path} cannot be protected from other runs by a lock beside it: "
                f"{error.strerror}; give a file in a folder that can be written to and whose file "
                "system has locks"
            ) from error

    def _read(self) -> None:
        """Take up what the file holds, if there is one."""
        self._kept = None
        try:
            response, about = storage.read(self.path)
        except FileNotFoundError:
            return
        except (GearbowError, OSError) as error:
            raise self._invalid(error) from None
        try:
            known = about["checkpoint"]
            asked, checkpoint = known["asked"], known["checkpoint"]
            if checkpoint is not None:
                check_final(response._data["final"], checkpoint)
            differences = list(_differences(asked, self._asked))
        except (KeyError, TypeError):
            message = "it is a response, but has no valid entry about a run in progress"
            raise self._invalid(message) from None
        except (GearbowError, RecursionError) as error:
            raise self._invalid(error) from None
        for where, was, now in differences:
            raise SceneError(
                f"checkpoint: {self.path} is of a run whose {where} was {_short(was)}, "
                f"not {_short(now)}"
            )
        if checkpoint is None:
            self.complete = response
        else:
            self._kept = {**response._data, "checkpoint": checkpoint}

    def _invalid(self, reason: object) -> SceneError:
        return SceneError(
            f"checkpoint: {self.path} is there and is none, nothing was run: {reason}"
        )

    def run(
        self,
        core: Core,
        times: Array,
        speed: float | SpeedProfile,
        progress: Progress | None,
    ) -> RunData:
        """Run to the end, and write the file on the way.

        Parameters
        ----------
        core : callable
            What runs.
        times : ndarray
            All times to record [s], ascending.
        speed : float or SpeedProfile
            Speed of the reference shaft [rad/s].
        progress : callable or None
            Called with the fraction done.

        Returns
        -------
        mapping
            What was recorded. What ends the run early carries it as ``partial``.
        """
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
                    raise self._invalid(error) from None  # what the file holds does not fit
                joined = kept if partial is None else _joined(kept, partial)
                if joined is None:
                    raise
                self._kept = joined
                if watch.fraction < 1.0:  # else it had ended, and only who was told has failed
                    self._write(joined, speed)
                if not isinstance(error, _Due):
                    error.partial = joined  # type: ignore[attr-defined]
                    raise

    def _write(self, data: RunData, speed: float | SpeedProfile) -> None:
        """Write what there is; an error other than a full disk carries the data."""
        try:
            self._save(Response(data, speed), data["checkpoint"])
        except BaseException as error:
            error.partial = data  # type: ignore[attr-defined]
            raise

    def finish(self, response: Response) -> None:
        """Leave the whole response in the file.

        Parameters
        ----------
        response : Response
            The response.
        """
        self._save(response, None)

    def _save(self, response: Response, checkpoint: dict[str, Plain] | None) -> None:
        try:
            storage.save(
                response, self.path, checkpoint={"asked": self._asked, "checkpoint": checkpoint}
            )
        except (OSError, MemoryError) as error:
            reason = getattr(error, "strerror", None) or str(error) or "there is no memory for it"
            message = f"checkpoint: {self.path} could not be written and is as it was: {reason}"
            warnings.warn(message, CheckpointWarning, stacklevel=2)


class _Watch:
    """Tells how far a run is, and stops it when the file is due."""

    def __init__(self, interval: float, progress: Progress | None) -> None:
        self.interval = interval
        self.progress = progress
        self.fraction = 0.0
        self._begun: tuple[float, float] | None = None

    def __call__(self, fraction: float) -> None:
        self.fraction = fraction
        now = time.monotonic()
        # To assemble the run again takes its time too: the steps count, and there is one at least.
        at, begun = self._begun = self._begun or (now, fraction)
        if self.progress is not None:
            self.progress(fraction)
        if begun < fraction < 1.0 and now - at >= self.interval:
            raise _Due


def _joined(first: RunData | None, second: RunData) -> RunData:
    """Put what a run recorded behind what it had recorded before."""
    if first is None:
        return second

    def both(a: Any, b: Any) -> Any:
        if isinstance(a, dict):
            return {name: both(values, b[name]) for name, values in a.items()}
        return a if a is None else np.concatenate([a, b])

    recorded: Any = {
        name: both(first[name], second[name])
        for name in (
            *("time", "displacement", "twist", "bearing_force"),
            *("mesh", "energy", "energy_terms"),
        )
    }
    return {**second, **recorded, "events": [*first["events"], *second["events"]]}


def _short(value: Any) -> str:
    """Show a value of a file in a message, whatever its size."""
    return str(value) if isinstance(value, str | float | int | None) else reprlib.repr(value)


def _plain(value: Any) -> Any:
    """Give arguments as what JSON can hold, an array as what identifies it."""
    if isinstance(value, Mapping):
        return {str(name): _plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.ndarray):
        digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return {"length": value.size, "digest": digest}
    return value.item() if isinstance(value, np.generic) else value


def _differences(was: Any, now: Any, where: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Find where two pieces of plain data differ."""
    if isinstance(was, dict) and isinstance(now, dict):
        for name in {**was, **now}:
            place = f"{where}.{name}".lstrip(".")
            yield from _differences(was.get(name), now.get(name), place)
    elif isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
        for i, (a, b) in enumerate(zip(was, now, strict=True)):
            yield from _differences(a, b, f"{where}[{i}]")
    elif repr(was) != repr(now):
        yield where, was, now
