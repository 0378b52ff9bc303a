"""Files of sweeps: one file that grows by one record for each finished point.

Every record is sealed: its length (8 bytes, little-endian), the SHA-256 digest of its content, and
the content. The content of the first record is the head, a JSON text: format, versions, functions
and parameters. That of every other record is a JSON text with the number of the point and either
the name, type and shape of each value or the error, then a line feed and the little-endian bytes of
the values. Nothing is pickled, and numbers are not rounded.

A process that is killed while it writes leaves an incomplete record at the end. It is ignored.
"""

import hashlib
import json
import os
import sys
from collections.abc import Iterator, Mapping
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._compare import differences, short
from gearbow._core import __version__
from gearbow._files import BusyError, FileLock, replacing
from gearbow._types import Plain
from gearbow.errors import GearbowError, SceneError
from gearbow.recording.schema import anything, each, entries, record, row, text, whole
from gearbow.sweeps.outcome import Outcome

if TYPE_CHECKING:
    from io import FileIO

__all__ = ["Store", "head_of", "read", "write"]

_FORMAT = 1
#: Length of what precedes the content of a record: its own length and the digest.
_SEAL = 8 + hashlib.sha256().digest_size
#: Types of values: letters of NumPy, with the number of bytes.
_KINDS = {f"{kind}{size}" for kind in "iu" for size in (1, 2, 4, 8)}
_KINDS |= {"b1", "f2", "f4", "f8", "c8", "c16"}

_FUNCTION = record(name=text, digest=text)
_HEAD = record(
    sweep=whole, version=text, python=text, make=_FUNCTION, measure=_FUNCTION, parameters=record()
)
_POINT = record(point=whole)
_VALUES = each(row(text, text, each(whole)))
_GRID = record(grid=entries(each(anything)))
_LIST = record(points=each(record()))


def head_of(
    make: Mapping[str, str], measure: Mapping[str, str], parameters: Mapping[str, Plain]
) -> dict[str, Plain]:
    """Return the head of a file: what identifies a sweep.

    Parameters
    ----------
    make, measure : mapping
        Identities of the functions.
    parameters : mapping
        The points as plain data.

    Returns
    -------
    dict
        The head.
    """
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {
        "sweep": _FORMAT,
        "version": __version__,
        "python": python,  # the digests of the functions depend on it
        "make": dict(make),
        "measure": dict(measure),
        "parameters": dict(parameters),
    }


class Store:
    """File of a running sweep. Within a ``with`` statement no other sweep can use it.

    Parameters
    ----------
    path : str or path-like
        The file. It need not exist.
    head : dict
        The head of the sweep.

    Attributes
    ----------
    known : dict of {int: Outcome}
        Outcomes of the points that the file contains at the start, without failed ones.

    Raises
    ------
    SceneError
        If the folder is missing, or the file belongs to another sweep, is no file of a sweep, is
        damaged, or is in use.
    """

    def __init__(self, path: str | os.PathLike[str], head: dict[str, Plain]) -> None:
        self.path = Path(path)
        self.known: dict[int, Outcome] = {}
        self._head = json.loads(json.dumps(head))
        self._lock = FileLock(self.path)
        self._file: FileIO | None = None
        self._end = 0
        if not self.path.parent.is_dir():
            raise SceneError(f"store: there is no folder {self.path.parent}")

    def __enter__(self) -> "Store":
        try:
            self._lock.acquire()
        except BusyError:
            raise SceneError(
                f"store: {self.path} is in use by another sweep; wait until it has ended, or give "
                "each sweep a file of its own"
            ) from None
        try:
            self._open()
        except BaseException:
            self._lock.release()
            raise
        return self

    def _open(self) -> None:
        if not self.path.exists():
            write(self.path, self._head, {})
        try:
            head, found, self._end = _read(self.path)
        except GearbowError as error:
            raise SceneError(f"store: {error}; remove it or give another file") from None
        for where, was, now in differences(head, self._head):
            raise SceneError(
                f"store: {self.path} belongs to a sweep with {where} {short(was)}, not "
                f"{short(now)}; remove it or give another file"
            )
        self.known = {i: outcome for i, outcome in found.items() if outcome.values is not None}
        # Without a buffer, which would keep the data of a write that failed.
        self._file = self.path.open("r+b", buffering=0)

    def __exit__(self, *_: object) -> None:
        try:
            if self._file is not None:
                with self._file as file:
                    os.fsync(file.fileno())
        finally:
            self._file = None
            self._lock.release()

    def add(self, number: int, outcome: Outcome) -> None:
        """Write the outcome of a point.

        Parameters
        ----------
        number : int
            Number of the point.
        outcome : Outcome
            Its outcome.

        Raises
        ------
        OSError
            If the file cannot be written. Its complete records remain.
        """
        if self._file is None:
            raise SceneError("store: the file is not open")
        sealed = _sealed(_content(number, outcome))
        # An interrupted call may have left a part of a record.
        self._file.seek(self._end)
        self._file.truncate()
        left = memoryview(sealed)
        while left:
            left = left[self._file.write(left) :]
        self._end += len(sealed)


def write(
    path: str | os.PathLike[str], head: Mapping[str, Plain], outcomes: Mapping[int, Outcome]
) -> None:
    """Write a file with these outcomes, completely or not at all.

    Parameters
    ----------
    path : str or path-like
        The file.
    head : mapping
        The head of the sweep.
    outcomes : mapping of {int: Outcome}
        Outcome of each finished point.

    Raises
    ------
    OSError
        If the file cannot be written. An existing file is unchanged.
    """
    with replacing(path) as file:
        file.write(_sealed(json.dumps(head).encode()))
        for number in sorted(outcomes):
            file.write(_sealed(_content(number, outcomes[number])))


def read(path: str | os.PathLike[str]) -> tuple[dict[str, Plain], dict[int, Outcome]]:
    """Read a file of a sweep.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    head : dict
        The head of the sweep.
    outcomes : dict of {int: Outcome}
        Outcome of each finished point.

    Raises
    ------
    GearbowError
        If the file is damaged or has another content.
    OSError
        If the file cannot be opened.
    """
    head, outcomes, _ = _read(Path(path))
    return head, outcomes


def _sealed(content: bytes) -> bytes:
    return len(content).to_bytes(8, "little") + hashlib.sha256(content).digest() + content


def _content(number: int, outcome: Outcome) -> bytes:
    if outcome.values is None:
        about: dict[str, Plain] = {"error": outcome.error, "details": outcome.details}
        return json.dumps({"point": number, **about}).encode() + b"\n"
    arrays = {name: np.asarray(value) for name, value in outcome.values.items()}
    kinds = {name: f"{array.dtype.kind}{array.dtype.itemsize}" for name, array in arrays.items()}
    values = [(name, kinds[name], array.shape) for name, array in arrays.items()]
    parts = [array.astype(array.dtype.newbyteorder("<")).tobytes() for array in arrays.values()]
    return b"\n".join([json.dumps({"point": number, "values": values}).encode(), b"".join(parts)])


def _read(path: Path) -> tuple[dict[str, Plain], dict[int, Outcome], int]:
    """Read the head, the outcomes, and the position of the end of the last complete record."""
    data = memoryview(path.read_bytes())
    try:
        records = _records(data)
        _, first = next(records, (0, None))
        if first is None:
            raise GearbowError("it does not begin with the head of a sweep")
        head = _head(bytes(first))
        outcomes: dict[int, Outcome] = {}
        last = _SEAL + len(first)
        for end, content in records:
            number, outcome = _outcome(content)
            outcomes[number] = outcome
            last = end
    except (GearbowError, ValueError, RecursionError) as error:
        raise GearbowError(f"{path}: not a sweep of gearbow, or damaged: {error}") from None
    return head, outcomes, last


def _records(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Give the end and the content of each record; ignore an incomplete record at the end."""
    begin = 0
    while len(data) - begin > _SEAL:
        end = begin + _SEAL + int.from_bytes(data[begin : begin + 8], "little")
        content = data[begin + _SEAL : end]
        if hashlib.sha256(content).digest() != data[begin + 8 : begin + _SEAL]:
            # A loss of power may leave zeros at the end.
            if end < len(data) and any(data[begin:]):
                raise GearbowError(f"the record at byte {begin} has changed since it was written")
            return
        if end > len(data):
            return
        yield end, content
        begin = end


def _head(content: bytes) -> dict[str, Plain]:
    about: dict[str, Plain] = json.loads(content)
    record(sweep=whole)(about, "")
    if about["sweep"] != _FORMAT:
        raise GearbowError(
            f"it has the format {about['sweep']}, this version of gearbow reads {_FORMAT}"
        )
    _HEAD(about, "")
    (_GRID if "grid" in about["parameters"] else _LIST)(about["parameters"], "parameters")
    return about


def _outcome(content: memoryview) -> tuple[int, Outcome]:
    text_of, _, data = bytes(content).partition(b"\n")
    about = json.loads(text_of)
    _POINT(about, "")
    if "error" in about:
        record(error=text, details=text)(about, "")
        return about["point"], Outcome(None, about["error"], about["details"])
    record(values=_VALUES)(about, "")
    values: dict[str, Any] = {}
    begin = 0
    for name, kind, shape in about["values"]:
        size = prod(shape) * _dtype(kind).itemsize
        array = np.frombuffer(data[begin : begin + size], _dtype(kind)).reshape(shape)
        # Native byte order, writable.
        values[name] = array.astype(array.dtype.newbyteorder("="))[()]
        begin += size
    if begin != len(data):
        raise GearbowError(f"point {about['point']}: has {len(data)} bytes of values, not {begin}")
    return about["point"], Outcome(values)


def _dtype(kind: str) -> np.dtype[Any]:
    """Return the type of a value. The size of a text is that of its characters, 4 bytes each."""
    if kind in _KINDS:
        return np.dtype(f"<{kind}")
    if kind.startswith("U") and kind[1:].isdecimal() and int(kind[1:]) % 4 == 0:
        return np.dtype(f"<U{int(kind[1:]) // 4}")
    raise GearbowError(f"{kind!r} is not a type of a value")
