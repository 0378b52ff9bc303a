"""Runs of the bow study on all cores; each result is stored in a file.

The name of a file is a digest of everything that the result depends on. An interrupted study
therefore continues with the missing runs, and a study with other parameters repeats only the runs
that they affect. A file is written completely or not at all.
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

#: Errors of reading a missing or damaged file (RuntimeError: unknown compression).
_INVALID = (
    *(FileNotFoundError, EOFError, zipfile.BadZipFile, zlib.error, KeyError, ValueError),
    *(TypeError, AttributeError, RuntimeError, OverflowError, MemoryError, SyntaxError),
)


def run(
    settings: Settings, folder: Path, workers: int | None = None, *, progress: bool = False
) -> Results:
    """Make all missing runs of a study and return all results.

    Parameters
    ----------
    settings : Settings
        The study.
    folder : path-like
        Folder of the run files.
    workers : int, optional
        Number of parallel runs; None is the number of cores. It does not affect the results.
    progress : bool
        Whether to show a progress bar.

    Returns
    -------
    mapping of {Case: Measured}
        The results of all runs, in the order of `cases`.

    Raises
    ------
    GearbowError
        If a run fails. The files of the finished runs remain.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    wanted = {case: folder / f"{key(settings, case)}.npz" for case in cases(settings)}
    missing = [case for case, path in wanted.items() if _read(path) is None]
    # A simulation releases the interpreter lock, so threads run in parallel.
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
    # All results come from the files, so an interrupted study gives the same bits.
    results = {case: _read(path) for case, path in wanted.items()}
    return {case: result for case, result in results.items() if result is not None}


def find(settings: Settings, case: Case, folder: Path) -> Measured:
    """Return the result of a case; make the run if its file is missing.

    Parameters
    ----------
    settings : Settings
        The study.
    case : Case
        The case; it need not be one of `cases`.
    folder : path-like
        Folder of the run files.

    Returns
    -------
    Measured
        The result, as read from the file.

    Raises
    ------
    GearbowError
        If the run fails.
    OSError
        If the file cannot be written or read.
    """
    path = Path(folder) / f"{key(settings, case)}.npz"
    found = _read(path)
    if found is None:
        _make(settings, case, path)
        found = _read(path)
    if found is None:
        raise OSError(f"{path}: the file of a run cannot be read after writing it; check the disk")
    return found


def _make(settings: Settings, case: Case, path: Path) -> None:
    measured = measure(settings, case)
    names = list(measured.signals)
    values = np.array([measured.signals[name] for name in names])
    # Deviations from the first value in single precision: seven digits at half the size.
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
    """Return the content of a run file; None if it is missing or damaged."""
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            names = [(str(of), str(quantity)) for of, quantity in file["names"]]
            signals = dict(zip(names, file["first"] + file["change"], strict=True))
            return Measured(file["turn"], signals, tuple(str(event) for event in file["events"]))
    except _INVALID:
        return None
