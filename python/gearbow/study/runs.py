"""Runs of the bow study: sweeps over its cases, which files store.

The name of a file is a digest of everything that its results depend on. An interrupted study
therefore continues with the missing runs, and a study with other parameters has another file.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearbow.errors import GearbowError
from gearbow.study.case import Case, cases, influential, key, system
from gearbow.study.measure import Measured, signals
from gearbow.study.settings import Settings
from gearbow.sweeps.result import SweepPoint
from gearbow.sweeps.run import sweep
from gearbow.system import RotorSystem

__all__ = ["Results", "find", "run"]

Results = Mapping[Case, Measured]


def run(
    settings: Settings, folder: Path, workers: int | None = None, *, progress: bool = False
) -> Results:
    """Make all missing runs of a study and return all results."""
    with nullcontext() if workers is None else ThreadPoolExecutor(workers) as executor:
        return _run(settings, cases(settings), Path(folder), executor, progress=progress)


def find(settings: Settings, case: Case, folder: Path) -> Measured:
    """Return the result of a case; make the run if its file is missing."""
    return _run(settings, [case], Path(folder), None)[case]


def _run(
    settings: Settings,
    wanted: Sequence[Case],
    folder: Path,
    executor: Executor | None,
    *,
    progress: bool = False,
) -> Results:
    folder.mkdir(parents=True, exist_ok=True)
    simulated = influential(settings)
    done = sweep(
        partial(_make, simulated),
        [asdict(case) for case in wanted],
        partial(_measure, simulated),
        executor,
        folder / f"{key(settings, wanted)}.sweep",
        progress,
    )
    if done.failed:
        point = done.failed[0]
        raise GearbowError(
            f"study: {len(done.failed)} of {len(done)} runs failed; that of "
            f"{Case(**point.parameters)}: {point.error}"
        )
    return dict(zip(wanted, map(_unpacked, done), strict=True))


def _make(settings: Settings, **parameters: Any) -> RotorSystem:
    return system(settings, Case(**parameters))


def _measure(settings: Settings, train: RotorSystem, **parameters: Any) -> dict[str, NDArray[Any]]:
    """Return the signals as deviations from the first value in single precision: seven digits."""
    measured = signals(settings, train, Case(**parameters))
    names = list(measured.signals)
    values = np.array([measured.signals[name] for name in names])
    first = values[:, :1]
    return {
        "turn": measured.turn,
        "names": np.array(names),
        "first": first,
        "change": (values - first).astype(np.float32),
        "events": np.array(measured.events, dtype=np.str_),
    }


def _unpacked(point: SweepPoint) -> Measured:
    values = point.values or {}
    names = [(str(of), str(quantity)) for of, quantity in values["names"]]
    found = dict(zip(names, values["first"] + values["change"], strict=True))
    return Measured(values["turn"], found, tuple(str(event) for event in values["events"]))
