"""Rolling elements by direct summation, and their force averaged over the cage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Elements:
    count: int
    stiffness: float
    clearance: float
    exponent: float = 1.5
    phase: float = 0.0

    def places(self, cage: float) -> Array:
        angle = self.phase + cage + 2 * np.pi * np.arange(self.count) / self.count
        return np.array([np.cos(angle), np.sin(angle)])

    def approach(self, u: Array, cage: float) -> Array:
        """Give the deflection of each element [m]; negative where it is loose."""
        return u @ self.places(cage) - self.clearance / 2

    def force(self, u: Array, cage: float) -> Array:
        pressed = np.maximum(self.approach(u, cage), 0.0) ** self.exponent
        return self.stiffness * self.places(cage) @ pressed

    def mean_force(self, r: float, points: int = 20001) -> float:
        """Give the force along a displacement r, averaged over the cage (Sjövall's integral)."""
        if abs(self.clearance / 2) < r:
            end = np.arccos(self.clearance / 2 / r)
        else:
            end = np.pi if self.clearance < 0 else 0.0
        # the substitution makes the end of the loaded zone smooth
        t = (np.arange(points) + 0.5) / points * np.pi / 2
        angle, weight = end * np.sin(t), end * np.cos(t) * np.pi / 2 / points
        pressed = np.maximum(r * np.cos(angle) - self.clearance / 2, 0.0) ** self.exponent
        return float(self.count / np.pi * self.stiffness * (pressed * np.cos(angle) * weight).sum())
