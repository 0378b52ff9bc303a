"""Names of files, files that are written as a whole, text files, and locks between processes.

gearbow writes every file with `replacing`. It writes a temporary file in the same folder, which
replaces the target when all data are on the disk. Only the store of a sweep adds to its file.
"""

import errno
import os
import re
import reprlib
import stat
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from io import BufferedRandom
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]
    import msvcrt

from gearbow._convert import shown
from gearbow.errors import GearbowError, SceneError

#: Longest file name that temporary files and locks contain as it is [bytes]; a file system has at
#: most 255.
_LONGEST_NAME = 200
#: Most links from one to the next, as Linux permits.
_MOST_LINKS = 40
#: Times after which Windows is asked again to replace a file that another program reads [s].
_RETRIES = (0.01, 0.03, 0.1, 0.3, 1.0)
#: Age from which Windows removes a temporary file that no program has open [s]. A writer closes its
#: file a moment before it renames it.
_ABANDONED = 3600.0
#: Most characters of the reason why a file is not read.
_LONGEST_REASON = 1000
#: First bytes of texts that editors and Excel save in an encoding other than UTF-8.
_MARKS = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16"}
#: What XML and files of text lack: control characters, halves of surrogate pairs, U+FFFE, U+FFFF.
_UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f\ud800-\udfff\ufffe\uffff]")


def printable(text: str) -> str:
    """Replace the characters of a text that a file of text or XML must not have."""
    return _UNPRINTABLE.sub("\N{REPLACEMENT CHARACTER}", text)


def check_name(path: object, endings: Sequence[str], argument: str = "path") -> tuple[Path, str]:
    """Check the name of a file, whose suffix means its format."""
    found = as_path(path, argument)
    ending = found.suffix.lower()
    if ending not in endings:
        *others, last = endings
        known = f"{', '.join(others)} or {last}" if others else last
        raise SceneError(
            f"{argument}: must end with {known}, which is the format, got {shown(str(found))}"
        )
    return found, ending


def as_path(path: object, argument: str) -> Path:
    """Check that a value is the name of a file."""
    if not isinstance(path, str | os.PathLike):
        raise SceneError(f"{argument}: must be the name of a file, got {shown(path)}")
    name = os.fspath(path)
    if not isinstance(name, str) or not name or "\0" in name:
        raise SceneError(f"{argument}: must be the name of a file, got {shown(name)}")
    return Path(name)


def check_output(path: Path) -> None:
    """Check, before a computation, that a file can be created or replaced."""
    with _unchanged(path):
        target = _target(path)
        if not target.parent.is_dir():
            raise FileNotFoundError(errno.ENOENT, f"there is no folder {target.parent}")
        if not os.access(target.parent, os.W_OK):
            raise PermissionError(errno.EACCES, f"the folder {target.parent} is not writable")


@contextmanager
def parsing(path: str | os.PathLike[str], kind: str, *, own: bool = False) -> Iterator[None]:
    """Turn every error of the block into one that names the file and what it should be."""
    # Each reader parses within this block: a damaged file makes libraries raise anything. Errors of
    # gearbow stay as they are, except for an `own` file: gearbow wrote it, so that each error means
    # damage.
    try:
        yield
    except RecursionError:
        raise SceneError(f"{path}: is nested too deeply; the file is damaged") from None
    except Exception as error:
        # A damaged file makes a library read at a negative position: EINVAL.
        system = isinstance(error, OSError) and error.errno not in (None, errno.EINVAL) and not own
        if system or isinstance(error, Warning):
            raise
        reason = str(error) or type(error).__name__
        if len(reason) > _LONGEST_REASON:  # names a damaged text
            reason = f"{reason[:_LONGEST_REASON]}…"
        if isinstance(error, GearbowError) and not own:
            if reason == str(error):
                raise
            raise SceneError(reason) from None
        damage = ", or damaged" if own else ""
        raise SceneError(f"{path}: is not {kind}{damage}: {reason}") from error


@contextmanager
def reading(path: str | os.PathLike[str], kind: str) -> Iterator[str]:
    """Read a text file in UTF-8, with or without a byte-order mark, and parse it in the block."""
    data = as_path(path, "path").read_bytes()
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        encoding = _MARKS.get(data[:2])
        guess = f"it is {encoding}" if encoding else "perhaps it is Windows-1252, as of Excel"
        line = data.count(b"\n", 0, error.start) + 1
        raise SceneError(
            f"{path}: is not UTF-8 text: byte {data[error.start]:#04x} in line {line}; {guess}; "
            'save it as UTF-8 (in Excel: "CSV UTF-8")'
        ) from None
    with parsing(path, kind):
        yield text


@contextmanager
def _unchanged(path: Path) -> Iterator[None]:
    """Name the file in every error of the system within the block."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        message = f"the file cannot be written and is unchanged: {reason}"
        raise OSError(error.errno or errno.EIO, message, str(path)) from error


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BufferedRandom]:
    """Open a temporary file that replaces `path` at the end of the block."""
    given = as_path(path, "path")
    trial: Path | None = None
    file: BufferedRandom | None = None
    with _unchanged(given):
        try:
            path = _target(given)
            _remove_abandoned(path)
            trial, file = _create(path)
            yield file
            file.flush()
            os.fsync(file.fileno())
            if fcntl is None:  # Windows does not rename a file that is open.
                file.close()
            _rename(trial, path)
            file.close()
        except BaseException:
            if file is not None:
                with suppress(OSError):  # closing retries to write the remaining data
                    file.close()
            if trial is not None:
                with suppress(OSError):
                    trial.unlink(missing_ok=True)
            raise
    _synchronise(path.parent)


def _rename(trial: Path, path: Path) -> None:
    """Replace a file; Windows refuses this while another program, such as a scanner, reads it."""
    delays: tuple[float, ...] = ()
    if fcntl is None:
        delays = _RETRIES
    for delay in delays:
        try:
            trial.replace(path)
        except PermissionError:
            time.sleep(delay)
        else:
            return
    trial.replace(path)


def reserve(file: BufferedRandom, size: int) -> None:
    """Extend an empty file by zeros for which the disk has the space."""
    if hasattr(os, "posix_fallocate") and size > 0:
        try:
            os.posix_fallocate(file.fileno(), 0, size)
        except OSError as error:
            if error.errno not in {errno.EINVAL, errno.EOPNOTSUPP}:  # the file system lacks it
                raise
        else:
            return
    zeros = bytes(min(size, 1 << 20))
    for start in range(0, size, 1 << 20):
        file.write(zeros[: size - start])
    file.flush()


class FileLock:
    """A lock for a file, which the operating system releases when its owner ends or is killed."""

    def __init__(self, path: Path, argument: str, user: str) -> None:
        self._protected = path
        self._argument = argument
        self._user = user
        self._path: Path | None = None
        self._number: int | None = None

    def acquire(self) -> None:
        """Acquire the lock, or fail immediately."""
        try:
            free = self._acquired()
        except OSError as error:
            raise SceneError(
                f"{self._argument}: {self._protected} cannot be protected from other "
                f"{self._user}s by a lock beside it: {error.strerror}; give a file in a folder "
                "that can be written to and whose file system has locks"
            ) from error
        if not free:
            raise SceneError(
                f"{self._argument}: {self._protected} is in use by another {self._user}, of this "
                f"process or of another one; wait until it has ended, or give each {self._user} a "
                "file of its own"
            )

    def _acquired(self) -> bool:
        """Try to acquire the lock; False if another owner holds it."""
        target = _followed(self._protected)
        self._path = target.with_name(f".{_short(target)}.lock")
        flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
        while self._number is None:
            number = os.open(self._path, flags, 0o666)
            try:
                if not _lock(number):
                    return False
                # The previous owner may have removed the file between the two calls.
                if _is_at(number, self._path):
                    self._number = number
            finally:
                if self._number is None:
                    os.close(number)
        return True

    def release(self) -> None:
        """Release the lock, if it is held, and remove its file."""
        if self._number is None or self._path is None:
            return
        number, self._number = self._number, None
        with suppress(OSError):
            if fcntl is None:  # Windows does not remove a file that is open.
                os.close(number)
                self._path.unlink()
            else:  # Remove it before the release, so that no other owner holds it.
                self._path.unlink()
        if fcntl is not None:
            os.close(number)


def _lock(number: int) -> bool:
    """Try to lock an open file; False if another owner holds it."""
    if fcntl is None:
        try:
            msvcrt.locking(number, msvcrt.LK_NBLCK, 1)
        except PermissionError:
            return False
        return True
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    return True


def _is_at(number: int, path: Path) -> bool:
    """Return whether an open file is the one at `path`."""
    if fcntl is None:  # Windows neither removes nor renames a file that is open.
        return True
    try:
        return os.path.samestat(os.fstat(number), path.lstat())
    except FileNotFoundError:
        return False


def _target(path: Path) -> Path:
    """Give the file that is written; reject one that is no regular file, such as a device."""
    path = _followed(path)
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return path
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "it is a device, not a file")
    return path


def _followed(path: Path) -> Path:
    """Follow symbolic links to the file itself, which need not exist."""
    for _ in range(_MOST_LINKS):
        try:
            path = path.parent.resolve() / path.name
        except RuntimeError:  # a loop of folders, up to Python 3.12
            break
        # Such as /dev/stdout: a file that a program has opened.
        if path.parts[1:2] == ("proc",) or path.parts[1:3] == ("dev", "fd"):
            raise OSError(errno.EINVAL, "it is a device, not a file")
        if not path.is_symlink():
            return path
        path = path.parent / path.readlink()
    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))


def _short(path: Path) -> str:
    """Shorten a file name, so that an affix fits into the 255 bytes of a name."""
    name = os.fsencode(path.name)
    if len(name) <= _LONGEST_NAME:
        return path.name
    import hashlib  # noqa: PLC0415

    return f"{path.name[:40]}-{hashlib.sha256(name).hexdigest()[:16]}"


def _create(path: Path) -> tuple[Path, BufferedRandom]:
    """Create a temporary file for `path`, locked while its writer runs."""
    while True:
        trial = path.with_name(f".{_short(path)}.{os.urandom(8).hex()}.part")
        file = trial.open("x+b")
        if fcntl is None:
            return trial, file
        with suppress(OSError):  # Without locks an abandoned file is never removed, which is safe.
            _lock(file.fileno())
        if _is_at(file.fileno(), trial):  # else another writer removed it as abandoned
            with suppress(OSError):
                trial.chmod(stat.S_IMODE(path.stat().st_mode))
            return trial, file
        file.close()


def _remove_abandoned(path: Path) -> None:
    """Remove temporary files for `path` whose writers were killed."""
    start = f".{_short(path)}."
    with os.scandir(path.parent) as entries:
        found = [entry.name for entry in entries if entry.name.startswith(start)]
    for name in found:
        middle = name.removeprefix(start).removesuffix(".part")
        if not name.endswith(".part") or len(middle) != 16:
            continue
        left = path.with_name(name)
        with suppress(OSError):
            if fcntl is None:
                if time.time() - left.stat().st_mtime > _ABANDONED:
                    left.unlink()  # fails if it is open
                continue
            number = os.open(left, os.O_RDWR | os.O_NOFOLLOW)
            try:
                if _lock(number) and _is_at(number, left):
                    left.unlink()
            finally:
                os.close(number)


def _synchronise(folder: Path) -> None:
    """Write the new name in a folder to the disk, if the system permits it."""
    if os.name != "posix":
        return
    with suppress(OSError):  # the file is complete; some file systems cannot synchronise folders
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)


def short(value: Any) -> str:
    """Format a value of a file for a message, shortened if necessary."""
    return str(value) if isinstance(value, str | float | int | None) else reprlib.repr(value)


def differences(was: Any, now: Any, where: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Find the differences between two pieces of plain data."""
    if isinstance(was, dict) and isinstance(now, dict):
        for name in {**was, **now}:
            place = f"{where}.{name}".lstrip(".")
            yield from differences(was.get(name), now.get(name), place)
    elif isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
        for i, (a, b) in enumerate(zip(was, now, strict=True)):
            yield from differences(a, b, f"{where}[{i}]")
    elif repr(was) != repr(now):
        yield where, was, now
