"""All runs of a study, on all cores, each kept in a file as soon as it is done.

The file of a run is named by all that its result depends on. A study that was interrupted goes on
where it stopped; one with another parameter runs what that changes. A file is replaced as a whole.
"""

import os
import zipfile
import zlib
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import numpy as np
from tqdm import tqdm

from gearbow._files import replacing
from gearbow.study.case import Case, cases, key
from gearbow.study.measure import Measured, measure
from gearbow.study.settings import Settings

__all__ = ["Results", "find", "run"]

Results = Mapping[Case, Measured]

#: What reading a missing or damaged file raises; an unknown type of compression is a RuntimeError.
_INVALID = (
    *(FileNotFoundError, EOFError, zipfile.BadZipFile, zlib.error, KeyError, ValueError),
    *(TypeError, AttributeError, RuntimeError, OverflowError, MemoryError, SyntaxError),
)


def run(
    settings: Settings, folder: Path, workers: int | None = None, *, progress: bool = False
) -> Results:
    """Run a study, or what is missing of it.

    Parameters
    ----------
    settings : Settings
        The study.
    folder : path-like
        Where the files of the runs are kept.
    workers : int, optional
        How many runs at once; None is the number of cores. Results do not depend on it.
    progress : bool
        Whether to show a bar.

    Returns
    -------
    mapping of {Case: Measured}
        Every run, in the order of `cases`.

    Raises
    ------
    GearbowError
        If a run fails; those that are done are kept.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    wanted = {case: folder / f"{key(settings, case)}.npz" for case in cases(settings)}
    missing = [case for case, path in wanted.items() if _read(path) is None]
    # The engine lets go of the interpreter, so that threads run side by side.
    pool = ThreadPoolExecutor(max_workers=workers or os.cpu_count())
    try:
        futures = [pool.submit(_make, settings, case, wanted[case]) for case in missing]
        bar = tqdm(
            as_completed(futures),
            total=len(wanted),
            initial=len(wanted) - len(missing),
            unit="run",
            disable=not progress,
        )
        for future in bar:
            future.result()
    finally:
        pool.shutdown(cancel_futures=True)
    # What is reported is always what the files hold, so that a study in two parts is the same.
    results = {case: _read(path) for case, path in wanted.items()}
    return {case: result for case, result in results.items() if result is not None}


def find(settings: Settings, case: Case, folder: Path) -> Measured:
    """Read the run of a case, or make and keep it.

    Parameters
    ----------
    settings : Settings
        The study.
    case : Case
        The case; it need not be one of `cases`.
    folder : path-like
        Where the files of the runs are kept.

    Returns
    -------
    Measured
        What the file of the run holds.

    Raises
    ------
    GearbowError
        If the run fails.
    OSError
        If its file cannot be written.
    """
    path = Path(folder) / f"{key(settings, case)}.npz"
    found = _read(path)
    if found is None:
        _make(settings, case, path)
        found = _read(path)
    if found is None:
        raise OSError(f"{path}: cannot be read after it was written")
    return found


def _make(settings: Settings, case: Case, path: Path) -> None:
    measured = measure(settings, case)
    names = list(measured.signals)
    values = np.array([measured.signals[name] for name in names])
    # What changes, in single precision: seven digits of the swing, half the size.
    first = values[:, :1]
    with replacing(path) as file:
        np.savez_compressed(
            file,
            turn=measured.turn,
            names=np.array(names),
            first=first,
            change=(values - first).astype(np.float32),
            events=np.array(measured.events, dtype=np.str_),
        )


def _read(path: Path) -> Measured | None:
    """Read the file of a run; one that is missing or damaged is to be made again."""
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            names = [(str(of), str(quantity)) for of, quantity in file["names"]]
            signals = dict(zip(names, file["first"] + file["change"], strict=True))
            return Measured(file["turn"], signals, tuple(str(event) for event in file["events"]))
    except _INVALID:
        return None
