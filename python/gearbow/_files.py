"""Files that are written as a whole, and locks between processes.

gearbow writes every file with `replacing`. It writes a temporary file in the same folder, which
replaces the target when all data are on the disk. Only the store of a sweep appends to its file.
"""

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BufferedRandom
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]
    import msvcrt

__all__ = ["BusyError", "FileLock", "replacing", "reserve"]


class BusyError(Exception):
    """Another owner holds the lock."""


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BufferedRandom]:
    """Open a temporary file that replaces `path` at the end of the block.

    After an error within the block, or of the disk, `path` is unchanged and the temporary file is
    removed. A killed process cannot remove its temporary file: the next writer of the same file
    removes it. An existing file keeps its permissions.

    Raises
    ------
    OSError
        If the file cannot be written. The message names `path` and the cause.
    """
    path = Path(path).resolve()
    trial: Path | None = None
    file: BufferedRandom | None = None
    try:
        _check_target(path)
        _remove_abandoned(path)
        trial, file = _create(path)
        yield file
        file.flush()
        os.fsync(file.fileno())
        if fcntl is None:  # Windows does not rename a file that is open.
            file.close()
        trial.replace(path)
        file.close()
    except BaseException as error:
        if file is not None:
            with suppress(OSError):  # closing retries to write the remaining data
                file.close()
        if trial is not None:
            with suppress(OSError):
                trial.unlink(missing_ok=True)
        if isinstance(error, OSError):
            reason = error.strerror or str(error)
            message = f"the file cannot be written and is unchanged: {reason}"
            raise OSError(error.errno or errno.EIO, message, str(path)) from error
        raise
    _synchronise(path.parent)


def reserve(file: BufferedRandom, size: int) -> None:
    """Extend an empty file by zeros for which the disk has the space.

    Raises
    ------
    OSError
        If the disk has not the space.
    """
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
    """A lock for a file, which the operating system releases when its owner ends or is killed.

    Locks of the operating system (``flock``, or ``msvcrt.locking`` on Windows) are used directly:
    they belong to an open file, so that they also exclude two threads of one process.

    Parameters
    ----------
    path : Path
        The protected file. The lock is a hidden empty file in the same folder.
    """

    def __init__(self, path: Path) -> None:
        path = path.resolve()
        self._path = path.with_name(f".{_short(path)}.lock")
        self._number: int | None = None

    def acquire(self) -> None:
        """Acquire the lock, or fail immediately.

        Raises
        ------
        BusyError
            If another owner holds it.
        OSError
            If the folder or its file system does not permit a lock.
        """
        flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
        while self._number is None:
            number = os.open(self._path, flags, 0o666)
            try:
                if not _lock(number):
                    raise BusyError
                # The previous owner may have removed the file between the two calls.
                if _is_at(number, self._path):
                    self._number = number
            finally:
                if self._number is None:
                    os.close(number)

    def release(self) -> None:
        """Release the lock, if it is held, and remove its file."""
        if self._number is None:
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
    try:
        return os.path.samestat(os.fstat(number), path.lstat())
    except FileNotFoundError:
        return False


def _check_target(path: Path) -> None:
    """Reject a target that is not a regular file, such as a folder or a device."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "it is a device, not a file")


def _short(path: Path) -> str:
    """Shorten a file name, so that an affix fits into the 255 bytes of a name."""
    return path.name[:40]


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
    """Remove temporary files for `path` whose writers were killed.

    A running writer holds a lock on its file. On Windows this is unknown, and nothing is removed.
    """
    if fcntl is None:
        return
    start = f".{_short(path)}."
    with os.scandir(path.parent) as entries:
        found = [entry.name for entry in entries if entry.name.startswith(start)]
    for name in found:
        middle = name.removeprefix(start).removesuffix(".part")
        if not name.endswith(".part") or len(middle) != 16:
            continue
        left = path.with_name(name)
        with suppress(OSError):
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
