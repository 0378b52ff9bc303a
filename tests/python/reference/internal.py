"""A mesh with an internal gear: the change of length of an open belt between the base circles.

With the base radius R of the ring, r of the pinion, D = R - r and cos alpha = D / C:

    pinion drives:  delta = sigma [r t_a - R t_b + D (gamma - psi)] + D (inv alpha - inv alpha_0)
    ring drives:    delta = sigma [R t_a - r t_b - D (gamma - psi)] + D (inv alpha - inv alpha_0)

gamma is the angle of the line of centres from a to b.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference.mesh_law import Array, MeshLaw, involute


@dataclass(frozen=True)
class InternalLaw(MeshLaw):
    """The mesh of a ring and its pinion; `base_radius_a` is that of the driver."""

    @property
    def ring_drives(self) -> bool:
        return self.base_radius_a > self.base_radius_b

    @property
    def sum_of_radii(self) -> float:  # of the belt: the difference
        return abs(self.base_radius_a - self.base_radius_b)

    @property
    def turn(self) -> float:
        """Sign of the rotation of the line of centres in the deflection."""
        return -1.0 if self.ring_drives else 1.0

    def deflection(self, u_a: Array, u_b: Array, twist_a: float, twist_b: float) -> float:
        _, alpha, gamma = self.centres(u_a, u_b)
        difference = self.sum_of_radii
        turned = self.base_radius_a * twist_a - self.base_radius_b * twist_b
        turned += self.turn * difference * (gamma - self.centre_line_angle)
        longer = difference * (involute(alpha) - involute(self.angle_at_rest))
        return self.sigma * turned + longer

    def _line(self, alpha: float, gamma: float) -> Array:
        difference = self.sum_of_radii
        distance = difference / np.cos(alpha)
        along = np.array([np.cos(gamma), np.sin(gamma)])
        across = np.array([-np.sin(gamma), np.cos(gamma)])
        # d gamma = across . dc / C, d alpha = along . dc / (C tan alpha), d inv alpha = tan^2 alpha d alpha
        of_c = self.sigma * self.turn * difference * across / distance
        of_c += difference * np.tan(alpha) * along / distance
        spin_a, spin_b = self.sigma * self.base_radius_a, -self.sigma * self.base_radius_b
        return np.array([*-of_c, spin_a, *of_c, spin_b])

    def contact_ratio(self, distance: float) -> float:
        """Give the contact ratio: from the tips of the ring to those of the pinion."""
        segment = np.sqrt(distance**2 - self.sum_of_radii**2)
        of_a = np.sqrt(self.tip_radius_a**2 - self.base_radius_a**2)
        of_b = np.sqrt(self.tip_radius_b**2 - self.base_radius_b**2)
        of_pinion, of_ring = (of_b, of_a) if self.ring_drives else (of_a, of_b)
        return float((of_pinion - max(of_ring - segment, 0.0)) / self.base_pitch)
