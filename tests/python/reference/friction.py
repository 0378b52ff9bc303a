"""Friction between the flanks, from the velocities of both gears at the points of contact.

The contact points lie on the common tangent of the base circles. Both gears turn with their
prescribed spins about their moving centres; the friction of a pair opposes the difference of their
velocities, and changes its sign as x (15 - 10 x^2 + 3 x^4)/8 within `transition` base pitches.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference.teeth import TeethLaw

Array = NDArray[np.float64]


def turned(vector: Array) -> Array:
    """Turn a vector (y, z) by 90 degrees counter-clockwise: x-axis times vector."""
    return np.array([-vector[1], vector[0]])


def cross(a: Array, b: Array) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def ramp(x: float) -> float:
    x = min(max(x, -1.0), 1.0)
    return x * (15 - 10 * x**2 + 3 * x**4) / 8


@dataclass(frozen=True)
class FrictionLaw(TeethLaw):
    """Teeth without relief, backlash and run-out, with Coulomb friction."""

    coefficient: float = 0.0
    transition: float = 0.1

    def pairs(self, q: Array, angles: Any) -> list[tuple[float, float]]:
        """Give the position of each pair and its share of the mesh force."""
        s, low, high = self.place(q, angles)
        assert self.pair is not None
        found, first = [], int(np.floor((low - s) / self.law.base_pitch)) - 1
        for j in range(first, first + 7):
            at = float(s + j * self.law.base_pitch)
            load = float(self.weight(at - low) * self.weight(high - at) * self.pair(at))
            if load > 0.0:
                found.append((at, load))
        total = sum(load for _, load in found)
        return [(at, load / total) for at, load in found]

    def friction(self, q: Array, qd: Array, angles: Any, spins: Array, force: float) -> Any:
        """Give the friction on the driven gear (y, z), both moments and the dissipated power."""
        law, psi = self.law, self.law.centre_line_angle
        centre_a = q[0:2] if self.live else np.zeros(2)
        rest = law.centre_distance * np.array([np.cos(psi), np.sin(psi)])
        centre_b = rest + (q[3:5] if self.live else 0.0)
        apart = centre_b - centre_a
        distance, u = np.hypot(*apart), apart / np.hypot(*apart)
        cos = law.sum_of_radii / distance
        sin = np.sqrt(1 - cos**2)
        normal = law.sigma * cos * turned(u) + sin * u
        # the radius to the tangent point is perpendicular to the line of action
        radius = cos * u - law.sigma * sin * turned(u)
        total, moments, power = np.zeros(2), np.zeros(2), 0.0
        for at, share in self.pairs(q, angles):
            arm_a = law.base_radius_a * radius + at * normal
            arm_b = arm_a - apart
            sliding = spins[0] * turned(arm_a) - spins[1] * turned(arm_b)
            # both gears have the same velocity along the line of action
            assert abs(sliding @ normal) < 1e-9 * np.abs(spins[0]) * distance
            along = float(sliding @ radius)
            full = abs(spins[0] - spins[1]) * self.transition * law.base_pitch / 2
            on_b = self.coefficient * abs(force) * share * ramp(along / full) * radius
            total += on_b
            own = np.array([cross(arm_a, -on_b), cross(arm_b, on_b)])
            moments += own
            actual = (spins[0] + qd[2]) * turned(arm_a) - (spins[1] + qd[5]) * turned(arm_b)
            power += float(on_b @ (actual + qd[0:2] - qd[3:5]))
        return total, moments, power

    def force(self, q: Array, qd: Array, angles: Array, spins: Array) -> tuple[float, Array]:
        force, out = super().force(q, qd, angles, spins)
        on_b, moments, _ = self.friction(q, qd, angles, spins, force)
        return force, out + np.array([*-on_b, moments[0], *on_b, moments[1]])


def ohlendorf(teeth: tuple[int, int], angle: float, tips: tuple[float, float]) -> float:
    """Give the tooth loss factor of spur gears with the contact ratios of both tips (Ohlendorf 1958)."""
    z1, z2 = teeth
    e1, e2 = (
        z / (2 * np.pi) * (np.sqrt((tip / (z / 2 * np.cos(angle))) ** 2 - 1) - np.tan(angle))
        for z, tip in zip(teeth, tips, strict=True)
    )
    u = z2 / z1
    return float(np.pi * (u + 1) / (z1 * u) * (1 - e1 - e2 + e1**2 + e2**2))


def helical_loss(
    reach: tuple[float, float, float], pitch: float, overlap: float, *, count: int = 4000
) -> float:
    """Give the mean over the mesh cycle of |s - s_C| on all contact lines, loaded equally per length.

    `reach` has the beginning and the end of the path of contact, and the pitch point.
    """
    low, high, pitch_point = reach
    xi = (np.arange(count) + 0.5) / count - 0.5
    means = []
    for s in (np.arange(200) + 0.5) / 200 * pitch:
        places = [s + j * pitch + xi * overlap for j in range(-20, 60)]
        inside = [y[(y >= low) & (y <= high)] for y in places]
        every = np.concatenate(inside)
        means.append(np.abs(every - pitch_point).mean())
    return float(np.mean(means))
