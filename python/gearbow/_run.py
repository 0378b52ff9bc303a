"""Around a simulation: the times to record, the order of the rows, the progress bar."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from gearbow._types import Array, Progress, RunData
from gearbow.errors import SceneError


def grid(start: float, duration: float, step: float) -> Array:
    """Lay recorded times from the start to the end, with the end where a step meets it."""
    if not (0.0 < step < np.inf and 0.0 <= duration < np.inf):
        raise SceneError(
            f"output_step: must be positive and finite, got {step!r} s over {duration!r} s"
        )
    count = int(np.floor(duration / step * (1.0 + 1e-12))) + 1
    times: Array = np.minimum(start + step * np.arange(count), start + duration)
    return times


def in_order(data: RunData, rows: NDArray[np.intp] | None) -> RunData:
    """Give the rows in the order the user asked for; a partial run has only the first."""
    if rows is None:
        return data
    rows = rows[rows < data["time"].size]
    energy = data["energy"]
    return {
        **data,
        "time": data["time"][rows],
        "displacement": data["displacement"][rows],
        "twist": data["twist"][rows],
        "bearing_force": data["bearing_force"][rows],
        "mesh": {name: values[rows] for name, values in data["mesh"].items()},
        "energy": None if energy is None else energy[rows],
    }


@contextmanager
def reported(progress: bool | Progress | None, duration: float) -> Iterator[Progress | None]:
    """Give what the core calls with the fraction done; True is a bar in simulated seconds."""
    if progress is not True:
        yield progress or None
        return
    with tqdm(
        total=duration, bar_format="{l_bar}{bar}| {n:.3g}/{total:.3g} s [{elapsed}<{remaining}]"
    ) as bar:

        def report(fraction: float) -> None:
            bar.update(fraction * duration - bar.n)

        yield report
        report(1.0)
