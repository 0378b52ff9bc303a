"""Speeds at which modes of a Campbell diagram become unstable."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gearbow._shown import Shown
from gearbow._types import Array, ComplexArray

#: Smallest ratio of a growth rate Re λ to |λ| that counts as unstable; round-off causes smaller
#: ones. The core has the same limit.
_MIN_GROWTH = 1e-6


@dataclass(frozen=True)
class StabilityThreshold(Shown):
    """A speed at which the damping of a mode changes its sign.

    Parameters
    ----------
    mode : int
        Number of the mode in the diagram, from 0.
    speed : float
        Speed of the reference shaft [rad/s].
    frequency_hz : float
        Frequency [Hz] of the mode at this speed, with which it oscillates at the threshold.
    whirl : str
        Whirl of the mode at this speed.
    above : {"unstable", "stable"}
        The mode at higher speeds. Unstable means a negative damping ratio: each disturbance grows.
    residual : float
        The larger one of ``|Re λ|/|λ|`` and the residual of the mode, as `Modes.residuals`.

    Examples
    --------
    The cross-coupled stiffness of a seal grows with the speed:

    >>> import gearbow as gb
    >>> seal = gb.SpeedTable([0.0, 400.0], [[[2e7, 0], [0, 2e7]], [[2e7, 4e6], [-4e6, 2e7]]])
    >>> bearings = [gb.Bearing("rotor", x, stiffness=seal, damping=5e3) for x in (0.0, 1.0)]
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.1)
    >>> disk = gb.Disk("disk", "rotor", 0.5, 20.0, 0.1, 0.2)
    >>> system = gb.RotorSystem([rotor], disks=[disk], bearings=bearings)
    >>> threshold = system.campbell([0.0, 200.0, 400.0], count=2).thresholds[0]
    >>> print(f"{threshold.speed:.1f} rad/s: {threshold.whirl}, {threshold.above} above")
    289.8 rad/s: forward, unstable above
    """

    mode: int
    speed: float
    frequency_hz: float
    whirl: str
    above: str
    residual: float


def unstable_ranges(
    speeds: Array, eigenvalues: ComplexArray, thresholds: Sequence[StabilityThreshold]
) -> tuple[tuple[float, float], ...]:
    """Find the ranges of speeds at which a mode is unstable."""
    found: list[tuple[float, float]] = []
    for mode in range(eigenvalues.shape[1]):
        own = [one for one in thresholds if one.mode == mode]
        growing = eigenvalues[:, mode].real > _MIN_GROWTH * np.abs(eigenvalues[:, mode])
        # The mode changes at its thresholds; between them its state at any speed holds.
        ends = np.array([speeds[0], *(one.speed for one in own), speeds[-1]])
        for low, high in pairwise(ends):
            before = next((one.above == "unstable" for one in own if one.speed == low), None)
            after = next((one.above == "stable" for one in own if one.speed == high), None)
            given = [state for state in (before, after) if state is not None]
            if given[0] if given else bool(growing.any()):
                found.append((float(low), float(high)))
    return _merged(found)


def _merged(ranges: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Unite overlapping ranges."""
    united: list[tuple[float, float]] = []
    for low, high in sorted(ranges):
        if united and low <= united[-1][1]:
            united[-1] = united[-1][0], max(high, united[-1][1])
        else:
            united.append((low, high))
    return tuple(united)
