"""Formulas of one gear mesh: the change of length of a crossed belt between the base circles.

    c = C0 (cos psi, sin psi) + (u_b - u_a),   C = |c|,   gamma = arg c,   alpha = arccos(S / C),   S = r_a + r_b
    delta = sigma [r_a t_a + r_b t_b - S (gamma - psi)] - S (inv alpha - inv alpha_0)

y points right, z up, +x towards the viewer, angles count counter-clockwise; sigma is the sign of the driver's spin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def involute(angle: float) -> float:
    return np.tan(angle) - angle


@dataclass(frozen=True)
class MeshLaw:
    """A mesh in which gear a drives gear b, in SI units and radians."""

    base_radius_a: float
    base_radius_b: float
    centre_distance: float
    centre_line_angle: float
    stiffness: float
    damping: float = 0.0
    sigma: float = 1.0
    tip_radius_a: float = np.nan
    tip_radius_b: float = np.nan
    teeth_a: int = 0

    @property
    def sum_of_radii(self) -> float:
        return self.base_radius_a + self.base_radius_b

    @property
    def angle_at_rest(self) -> float:
        return float(np.arccos(self.sum_of_radii / self.centre_distance))

    @property
    def base_pitch(self) -> float:
        return 2 * np.pi * self.base_radius_a / self.teeth_a

    def centres(self, u_a: Array, u_b: Array) -> tuple[float, float, float]:
        """Give centre distance, pressure angle and centre-line angle (near psi) at q."""
        psi = self.centre_line_angle
        y = self.centre_distance * np.cos(psi) + u_b[0] - u_a[0]
        z = self.centre_distance * np.sin(psi) + u_b[1] - u_a[1]
        distance = float(np.hypot(y, z))
        # the angle is relative to psi, which avoids the branch cut of arctan2
        off = np.arctan2(z * np.cos(psi) - y * np.sin(psi), y * np.cos(psi) + z * np.sin(psi))
        return distance, float(np.arccos(self.sum_of_radii / distance)), float(psi + off)

    def deflection(self, u_a: Array, u_b: Array, twist_a: float, twist_b: float) -> float:
        _, alpha, gamma = self.centres(u_a, u_b)
        s = self.sum_of_radii
        turned = (
            self.base_radius_a * twist_a
            + self.base_radius_b * twist_b
            - s * (gamma - self.centre_line_angle)
        )
        return self.sigma * turned - s * (involute(alpha) - involute(self.angle_at_rest))

    def gradient(self, u_a: Array, u_b: Array) -> Array:
        """Give the gradient of the deflection in (v_a, w_a, t_a, v_b, w_b, t_b)."""
        _, alpha, gamma = self.centres(u_a, u_b)
        return self._line(alpha, gamma)

    def gradient_at_rest(self) -> Array:
        return self._line(self.angle_at_rest, self.centre_line_angle)

    def _line(self, alpha: float, gamma: float) -> Array:
        across = self.sigma * np.cos(alpha)
        along = np.sin(alpha)
        n_y = -across * np.sin(gamma) + along * np.cos(gamma)
        n_z = across * np.cos(gamma) + along * np.sin(gamma)
        spin_a, spin_b = self.sigma * self.base_radius_a, self.sigma * self.base_radius_b
        return np.array([n_y, n_z, spin_a, -n_y, -n_z, spin_b])

    def force(self, q: Array, qd: Array, live: bool = True) -> tuple[float, Array]:
        """Give the tooth force and the generalised forces on (v_a, w_a, t_a, v_b, w_b, t_b)."""
        if live:
            delta = self.deflection(q[0:2], q[3:5], q[2], q[5])
            gradient = self.gradient(q[0:2], q[3:5])
        else:
            gradient = self.gradient_at_rest()
            delta = float(gradient @ q)
        force = self.stiffness * delta + self.damping * float(gradient @ qd)
        return force, -force * gradient

    def contact_ratio(self, distance: float) -> float:
        """Give the contact ratio: the path of contact between both tip circles over the base pitch.

        The line of action touches both base circles. The part within tip circle a begins at the
        point of tangency on a and has the length sqrt(tip^2 - base^2). The same holds for b.
        """
        segment = np.sqrt(distance**2 - self.sum_of_radii**2)
        of_a = min(segment, np.sqrt(self.tip_radius_a**2 - self.base_radius_a**2))
        of_b = min(segment, np.sqrt(self.tip_radius_b**2 - self.base_radius_b**2))
        return float((of_a + of_b - segment) / self.base_pitch)
