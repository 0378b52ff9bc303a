"""One system, used by eight threads at the same time without a lock."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np

from reference.machines import hostile

if TYPE_CHECKING:
    import gearbow as gb

THREADS = 8
SPEED = 150.0


def answers(system: gb.RotorSystem) -> list[np.ndarray]:
    """Return modes, a synchronous response and a run."""
    modes = system.modes(speed=SPEED, count=8)
    response = system.synchronous([0.5 * SPEED, SPEED])
    run = system.simulate(2e-4, SPEED)
    gear = system.description["gears"][0]["name"]
    return [modes.frequencies_hz, modes.shapes, response.displacement(gear), run.displacement(gear)]


def test_eight_threads_share_one_system():
    """They begin together with an empty cache, which each of them wants to fill."""
    expected = answers(hostile())
    shared = hostile()
    start = threading.Barrier(THREADS)

    def ask(_: int) -> list[np.ndarray]:
        start.wait()
        return answers(shared)

    with ThreadPoolExecutor(THREADS) as pool:
        found = list(pool.map(ask, range(THREADS)))
    for results in found:
        for one, other in zip(results, expected, strict=True):
            np.testing.assert_array_equal(one, other)
