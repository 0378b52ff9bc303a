"""Files that are replaced as a whole."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["replacing"]


@contextmanager
def replacing(path: str | os.PathLike[str], writer: str = "") -> Iterator[Path]:
    """Give a name to write to; the file is replaced once all is on the disk, or not at all.

    `writer` tells those apart that may write the same file at once.
    """
    path = Path(path).resolve()
    trial = path.with_name(f".{path.stem}{writer}.part{path.suffix}")
    try:
        yield trial
        with trial.open("rb+") as file:
            os.fsync(file.fileno())
        trial.replace(path)
    except BaseException:
        trial.unlink(missing_ok=True)
        raise
    if os.name == "posix":  # where the new name is in a folder that can be synchronised itself
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
