"""Around a simulation: its speed, the times to record, the order of the rows, the progress bar."""

import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from tqdm import tqdm

from gearbow._convert import array, number, real, shown
from gearbow._types import Array, Plain, Progress, RunData
from gearbow.errors import RunTimeWarning, SceneError
from gearbow.speed import SpeedProfile

if TYPE_CHECKING:
    from types import FrameType

#: What the speed of a run may be given as.
SpeedLike: TypeAlias = float | SpeedProfile | Callable[[Any], Any] | tuple[ArrayLike, ArrayLike]


#: A run that is estimated to take longer than this is worth a warning [s].
LONG_RUN = 3600.0
#: How long a run is watched before its run time is estimated [s].
WATCHED = 1.0

#: More recorded times than this are refused: the gears of a pair alone would fill 10 GB.
MOST_TIMES = 100_000_000


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
    return float(real(speed, "speed", wanted))


def plain_speed(speed: float | SpeedProfile) -> Plain:
    """Give a speed as plain data."""
    return speed._plain() if isinstance(speed, SpeedProfile) else speed


def read_speed(plain: Plain) -> float | SpeedProfile:
    """Read a speed from plain data."""
    return SpeedProfile(**plain) if isinstance(plain, dict) else float(plain)


def beginning(initial: object, start: float | None) -> tuple[str | dict[str, Any], float]:
    """Tell where a run starts, and when: what is continued goes on when it ended."""
    if isinstance(initial, str):
        return initial, 0.0 if start is None else number(start, "start")
    if not isinstance(initial, Mapping) or "time" not in initial:
        raise SceneError(f"initial: must be a name or a response, got {shown(initial)}")
    if start is not None:
        raise SceneError("start: must be left out where a response is continued")
    return dict(initial), number(initial["time"], "initial.time")


def distinct(times: ArrayLike) -> tuple[Array, NDArray[np.intp]]:
    """Sort the user's times, each once, and tell which of them each row is."""
    return np.unique(array(times, "times", least=0), return_inverse=True)


def grid(start: float, duration: float, step: float) -> Array:
    """Lay recorded times from the start to the end, with the end where a step meets it."""
    if not 0.0 < duration < np.inf:
        return np.array([start])  # the core knows what to say of such a duration
    if not 0.0 < step < np.inf:
        raise SceneError(f"output_step: must be positive and finite, got {step!r}")
    with np.errstate(over="ignore"):
        steps = np.floor(np.float64(duration) / step * (1.0 + 1e-12))
    if not steps < MOST_TIMES:
        raise SceneError(
            f"output_step: {step!r} s in a run of {duration!r} s asks for {steps:.3g} times, "
            f"more than the {MOST_TIMES:.0e} that a response may hold"
        )
    count = int(steps) + 1
    times: Array = np.minimum(start + step * np.arange(count), start + duration)
    return times


def in_order(data: RunData, rows: NDArray[np.intp] | None) -> RunData:
    """Give the rows in the order the user asked for; a partial run has only the first."""
    data = data.copy()
    data.pop("checkpoint", None)
    if rows is None:
        return data
    rows = rows[rows < data["time"].size]
    energy, terms = data["energy"], data["energy_terms"]
    return {
        **data,
        "time": data["time"][rows],
        "displacement": data["displacement"][rows],
        "twist": data["twist"][rows],
        "bearing_force": data["bearing_force"][rows],
        "mesh": {name: values[rows] for name, values in data["mesh"].items()},
        "energy": None if energy is None else energy[rows],
        "energy_terms": None if terms is None else {k: v[rows] for k, v in terms.items()},
    }


@contextmanager
def reported(
    progress: bool | Progress | None, total: float, unit: str = "s", *, estimate: bool = True
) -> Iterator[Progress | None]:
    """Give what is called with the fraction done; True is a bar, in simulated seconds or else.

    With `estimate`, a run of more than an hour is warned of.
    """
    if progress is not True:
        report = progress or None
        yield _Estimate(report) if estimate else report
        return
    with tqdm(
        total=total,
        bar_format="{l_bar}{bar}| {n:.3g}/{total:.3g} " + unit + " [{elapsed}<{remaining}]",
        # Every report is shown, however little was done: the remaining time stands beside it.
        miniters=0,
    ) as bar:

        def show(fraction: float) -> None:
            bar.update(fraction * total - bar.n)

        yield _Estimate(show) if estimate else show
        show(1.0)


class _Estimate:
    """Passes the fraction done on, and warns once of a run of more than an hour."""

    def __init__(self, report: Progress | None) -> None:
        self._report = report
        self._first: tuple[float, float] | None = None
        self._told = False

    def __call__(self, fraction: float) -> None:
        if self._report is not None:
            self._report(fraction)
        now = time.perf_counter()
        # A run that is continued begins with a part done; the set-up before the first report counts
        # for nothing.
        begin, done = self._first = self._first or (now, fraction)
        elapsed = now - begin
        if self._told or elapsed < WATCHED or fraction <= done:
            return
        self._told = True
        left = elapsed * (1.0 - fraction) / (fraction - done)
        if elapsed + left > LONG_RUN:
            warnings.warn(
                f"simulate: takes about {(elapsed + left) / 3600.0:.3g} h at the pace of the first "
                f"{elapsed:.2g} s; shorten the duration, loosen rtol, use fewer elements, or keep "
                'the run in a file by checkpoint="run.npz"',
                RunTimeWarning,
                stacklevel=_outside(),
            )


def _outside() -> int:
    """Count the frames up to the first one outside the package: the line that asked for the run."""
    level = 0
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_globals.get("__name__", "").split(".")[0] == "gearbow":
        level, frame = level + 1, frame.f_back
    return level + 1
