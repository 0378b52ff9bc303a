"""Files of sweeps: SQLite databases that grow by one row for each finished point.

The table ``head`` has one row: format, versions, functions and parameters as a JSON text. The table
``points`` has one row for each point: a JSON text with the number of the point and either the name,
type and shape of each value or the error, then a line feed and the little-endian bytes of the
values. Each row has the SHA-256 digest of its content. Nothing is pickled, and numbers are not
rounded.

SQLite writes each row as one transaction with a rollback journal beside the file. A process that is
killed leaves a journal that the next reader rolls back. Write-ahead logs need memory that processes
share, which network drives lack. https://www.sqlite.org/atomiccommit.html
"""

import errno
import hashlib
import json
import os
import sqlite3
import sys
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from gearbow._core import __version__
from gearbow._files import FileLock, check_name, differences, parsing, replacing, short
from gearbow._types import Plain
from gearbow.errors import CheckpointWarning, GearbowError, SceneError, warn
from gearbow.recording.container import anything, each, entries, record, row, text, whole
from gearbow.sweeps.points import Outcome, Points

#: The tables of a file.
_TABLES = (
    "CREATE TABLE head (content BLOB, digest BLOB)",
    "CREATE TABLE points (number INTEGER PRIMARY KEY, content BLOB, digest BLOB)",
)
#: Suffix of these files.
SUFFIX = ".sweep"
_FORMAT = 1
#: Size of a page of a database [bytes], the smallest of SQLite: damage of the structure of a page
#: concerns the rows of this page.
_PAGE = 512
#: Time for which a reader and a writer wait for each other [s]: a transaction takes milliseconds.
_WAIT = 30.0
#: What an error of the store says after its cause.
_STAY = (
    "the store cannot be written: {}; the points that it contains stay, and the same call "
    "continues when the cause is removed"
)
#: Most numbers of points in a message.
_MOST_NAMED = 10
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


@dataclass
class Contents:
    """What a file contains."""

    head: dict[str, Plain]
    outcomes: dict[int, Outcome] = field(default_factory=dict)
    damaged: set[int] = field(default_factory=set)
    structure: str = ""

    def damage(self) -> str:
        """Describe the damage."""
        named = ", ".join(map(str, sorted(self.damaged)[:_MOST_NAMED]))
        more = len(self.damaged) - _MOST_NAMED
        found = []
        if self.damaged:
            points = "points" if len(self.damaged) > 1 else "point"
            found.append(f"the {points} {named}{f' and {more} more' if more > 0 else ''}")
        if self.structure:
            found.append(f"its structure ({self.structure}), so that points may be missing")
        return " and ".join(found)


def head_of(
    make: Mapping[str, str], measure: Mapping[str, str], parameters: Mapping[str, Plain]
) -> dict[str, Plain]:
    """Return the head of a file: what identifies a sweep."""
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
    """File of a running sweep. Within a ``with`` statement no other sweep can use it."""

    def __init__(self, path: str | os.PathLike[str], head: dict[str, Plain]) -> None:
        self.path, _ = check_name(path, [SUFFIX], "store")
        self.known: dict[int, Outcome] = {}
        self._head = json.loads(json.dumps(head))
        self._lock = FileLock(self.path, "store", "sweep")
        self._database: sqlite3.Connection | None = None
        if not self.path.parent.is_dir():
            raise SceneError(f"store: there is no folder {self.path.parent}")

    def __enter__(self) -> "Store":
        self._lock.acquire()
        try:
            self._open()
        except BaseException:
            self._close()
            raise
        return self

    def _open(self) -> None:
        if not self.path.exists():
            write(self.path, self._head, {})
        try:
            found = read(self.path)
        except GearbowError as error:
            raise SceneError(f"store: {error}; remove it or give another file") from None
        for where, was, now in differences(found.head, self._head):
            raise SceneError(
                f"store: {self.path} belongs to a sweep with {where} {short(was)}, not "
                f"{short(now)}; remove it or give another file"
            )
        if damage := found.damage():
            warn(
                f"store: {self.path} is damaged: {damage}; its {len(found.outcomes)} intact points "
                "stay, and the others are computed again",
                CheckpointWarning,
            )
            write(self.path, self._head, found.outcomes)  # without the damage
        self.known = {i: one for i, one in found.outcomes.items() if one.values is not None}
        with _system_errors(self.path, _STAY):
            self._database = _connect(self.path)
            self._database.execute("BEGIN IMMEDIATE")  # fails for a file that is only readable
            self._database.execute("COMMIT")

    def __exit__(self, *_: object) -> None:
        self._close()

    def _close(self) -> None:
        try:
            if self._database is not None:
                self._database.close()
        finally:
            self._database = None
            self._lock.release()

    def add(self, number: int, outcome: Outcome) -> None:
        """Write the outcome of a point."""
        if self._database is None:
            raise SceneError("store: the file is not open")
        with _system_errors(self.path, _STAY):
            _insert(self._database, number, outcome)


@contextmanager
def _system_errors(path: Path | None = None, text: str = "{}") -> Iterator[None]:
    """Turn an error of SQLite into one of the operating system."""
    try:
        yield
    except sqlite3.Error as error:
        code = errno.ENOSPC if "full" in str(error) else errno.EIO
        raise OSError(code, text.format(error), path and str(path)) from error


def write(
    path: str | os.PathLike[str], head: Mapping[str, Plain], outcomes: Mapping[int, Outcome]
) -> None:
    """Write a file with these outcomes, completely or not at all."""
    # Nobody else knows the temporary file, and `replacing` removes it after an error: it needs
    # neither locks nor a journal.
    with (
        replacing(path) as file,
        _system_errors(),
        closing(_connect(Path(file.name), "&nolock=1")) as database,
    ):
        database.execute("PRAGMA journal_mode = OFF")
        database.execute("PRAGMA synchronous = OFF")
        database.execute(f"PRAGMA page_size = {_PAGE}")
        database.execute("BEGIN")
        for table in _TABLES:
            database.execute(table)
        content = json.dumps(head).encode()
        database.execute("INSERT INTO head VALUES (?, ?)", (content, _digest(content)))
        for number in sorted(outcomes):
            _insert(database, number, outcomes[number])
        database.execute("COMMIT")


def read(path: str | os.PathLike[str]) -> Contents:
    """Read a file of a sweep."""
    with Path(path).open("rb"):  # an error of the system names the cause
        pass
    with (
        parsing(path, "a sweep of gearbow", own=True),
        closing(_connect(Path(path))) as database,
    ):
        tables = database.execute("SELECT sql FROM sqlite_master").fetchall()
        if tables != [(table,) for table in _TABLES]:
            raise GearbowError("it has other tables")
        content, digest = database.execute("SELECT content, digest FROM head").fetchone()
        if digest != _digest(content):
            raise GearbowError("its head has changed since it was written")
        return _points(database, _head(content))


def _connect(path: Path, options: str = "") -> sqlite3.Connection:
    """Open a database, each statement of which is a transaction."""
    address = f"{path.absolute().as_uri()}?mode=rw{options}"
    database = sqlite3.connect(address, timeout=_WAIT, isolation_level=None, uri=True)
    database.execute("PRAGMA synchronous = FULL")
    return database


def _insert(database: sqlite3.Connection, number: int, outcome: Outcome) -> None:
    content = _content(number, outcome)
    values = (number, content, _digest(content))
    database.execute("INSERT OR REPLACE INTO points VALUES (?, ?, ?)", values)


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


def _points(database: sqlite3.Connection, head: dict[str, Plain]) -> Contents:
    """Read the rows of the points; where the structure is damaged, from both ends."""
    found = Contents(head, structure=_structure(database))
    ends: list[int] = []
    for order in ("ASC", "DESC"):
        number = -1
        try:
            rows = database.execute(f"SELECT * FROM points ORDER BY number {order}")
            for number, content, digest in rows:
                _keep(found, number, content, digest)
        except sqlite3.DatabaseError as error:
            found.structure = found.structure or str(error)
            ends.append(number)
        if not found.structure:
            return found
    if len(ends) == 2:
        found.damaged.update(range(ends[0] + 1, ends[1] if ends[1] >= 0 else len(points_of(head))))
    found.damaged.difference_update(found.outcomes)
    return found


def _structure(database: sqlite3.Connection) -> str:
    """Check the structure of a database; empty if it is intact."""
    try:
        (answer,) = database.execute("PRAGMA quick_check(1)").fetchone()
    except sqlite3.DatabaseError as error:
        return str(error)
    return "" if answer == "ok" else " ".join(str(answer).split())


def points_of(head: Mapping[str, Any]) -> Points:
    """Return the points of a sweep."""
    return Points(next(iter(head["parameters"].values())))


def _keep(found: Contents, number: int, content: object, digest: object) -> None:
    """Keep the outcome of a row, or its number if the row has changed."""
    if not isinstance(content, bytes) or digest != _digest(content):
        found.damaged.add(number)
        return
    of, outcome = _outcome(content)
    if of == number:
        found.outcomes[number] = outcome
    else:
        found.damaged.add(number)


def _content(number: int, outcome: Outcome) -> bytes:
    if outcome.values is None:
        about: dict[str, Plain] = {"error": outcome.error, "details": outcome.details}
        return json.dumps({"point": number, **about}).encode() + b"\n"
    arrays = {name: np.asarray(value) for name, value in outcome.values.items()}
    kinds = {name: f"{array.dtype.kind}{array.dtype.itemsize}" for name, array in arrays.items()}
    values = [(name, kinds[name], array.shape) for name, array in arrays.items()]
    parts = [array.astype(array.dtype.newbyteorder("<")).tobytes() for array in arrays.values()]
    return b"\n".join([json.dumps({"point": number, "values": values}).encode(), b"".join(parts)])


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


def _outcome(content: bytes) -> tuple[int, Outcome]:
    text_of, _, data = content.partition(b"\n")
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
