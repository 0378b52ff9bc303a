"""Around a simulation: the times to record, the order of the rows, the progress bar."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from tqdm import tqdm

from gearbow._types import Array, Progress, RunData
from gearbow.errors import SceneError


def number(value: object, name: str) -> float:
    """Read an argument that must be a number."""
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise SceneError(f"{name}: must be a number, got {value!r}") from None


def beginning(initial: object, start: float | None) -> tuple[str | dict[str, Any], float]:
    """Tell where a run starts, and when: what is continued goes on when it ended."""
    if isinstance(initial, str):
        return initial, 0.0 if start is None else number(start, "start")
    if not isinstance(initial, Mapping) or "time" not in initial:
        raise SceneError(f"initial: must be a name or a response, got {initial!r}")
    if start is not None:
        raise SceneError("start: must be left out where a response is continued")
    return dict(initial), float(initial["time"])


def distinct(times: ArrayLike) -> tuple[Array, NDArray[np.intp]]:
    """Sort the user's times, each once, and tell which of them each row is."""
    try:
        given = np.asarray(times, dtype=np.float64).reshape(-1)
    except (TypeError, ValueError):
        raise SceneError(f"times: must be numbers, got {times!r}") from None
    return np.unique(given, return_inverse=True)


def grid(start: float, duration: float, step: float) -> Array:
    """Lay recorded times from the start to the end, with the end where a step meets it."""
    if not 0.0 < duration < np.inf:
        return np.array([start])  # the core knows what to say of such a duration
    if not 0.0 < step < np.inf:
        raise SceneError(f"output_step: must be positive and finite, got {step!r}")
    count = int(np.floor(duration / step * (1.0 + 1e-12))) + 1
    times: Array = np.minimum(start + step * np.arange(count), start + duration)
    return times


def in_order(data: RunData, rows: NDArray[np.intp] | None) -> RunData:
    """Give the rows in the order the user asked for; a partial run has only the first."""
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
