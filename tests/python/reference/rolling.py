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


def hertz(diameter: float, ratio: float, groove: float, modulus: float, poisson: float) -> float:
    """Give the stiffness of a ball between both races by the exact solution of Hertz [N/m^1.5]."""
    sides = (2 * ratio / (1 - ratio), -2 * ratio / (1 + ratio))
    contacts = []
    for side in sides:
        curvature = (4 - 1 / groove + side) / diameter
        difference = (1 / groove + side) / (curvature * diameter)
        first, second, ellipticity = integrals(difference)
        approach = 2 * first / np.pi * (np.pi / (2 * ellipticity**2 * second)) ** (1 / 3)
        load = 3 * (1 - poisson**2) / (curvature * modulus)
        contacts.append((approach * curvature / 2 * load ** (2 / 3)) ** -1.5)
    return float(sum(contact ** (-2 / 3) for contact in contacts) ** -1.5)


def integrals(difference: float) -> tuple[float, float, float]:
    """Give the elliptic integrals F and E, and the ellipticity for a difference of curvatures."""
    # the midpoint rule converges exponentially for periodic functions
    angle = (np.arange(2000) + 0.5) / 2000 * np.pi / 2

    def both(ellipticity: float) -> tuple[float, float]:
        root = np.sqrt(1 - (1 - ellipticity**-2) * np.sin(angle) ** 2)
        return float((1 / root).mean() * np.pi / 2), float(root.mean() * np.pi / 2)

    low, high = 1.0001, 1e3
    for _ in range(100):
        middle = float(np.sqrt(low * high))
        first, second = both(middle)
        found = ((middle**2 + 1) * second - 2 * first) / ((middle**2 - 1) * second)
        low, high = (middle, high) if found < difference else (low, middle)
    return *both(low), low
