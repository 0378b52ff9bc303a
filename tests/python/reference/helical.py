"""A pair of helical gears in NumPy: axial rods beside the train, and a deflection whose gradient is differentiated exactly.

The statement is that of vectors. The centres are c apart; the pitch point divides c in the ratio of the base radii. A gear
with the displacement x along its axis and the rotations B, G about y and z moves the pitch point along the axis by
x + B r_z - G r_y. An axial displacement X of a helicoid acts on its transverse section as the rotation -X tan(beta_b)/r.

    delta_n = cos(beta_b) {sigma [r_a t_a + r_b t_b - tan(beta_b) (X_a - X_b) - S (gamma - psi)] - S (inv alpha - inv alpha_0)}

Derivatives are those of complex steps, which have no round-off of differences.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from reference.train import Train

Array = NDArray[np.float64]

STEP = 1e-30


@dataclass(frozen=True)
class HelicalMesh:
    """Two helical gears; `helix` is the helix angle of the driver, right-hand positive."""

    teeth: tuple[int, int]
    module: float
    helix: float
    stiffness: float
    damping: float = 0.0
    angle: float = 0.0
    sigma: float = 1.0
    pressure_angle: float = np.radians(20.0)
    film: bool = False  # the drive flank separates at zero deflection, and damping always acts

    @property
    def radii(self) -> Array:
        """Give the reference radii."""
        return np.array(self.teeth) * self.module / np.cos(self.helix) / 2

    @property
    def transverse(self) -> float:
        return float(np.arctan(np.tan(self.pressure_angle) / np.cos(self.helix)))

    @property
    def base(self) -> float:
        """Give the helix angle on the base cylinder, from the lead."""
        return float(np.arctan(np.tan(self.helix) * np.cos(self.transverse)))

    def deflection(self, q: NDArray, live: bool) -> complex:
        """Give the deflection normal to the teeth at q: u, v, w, B, G, t of the driver, then of the driven gear."""
        a, b = q[:6], q[6:]
        base = self.radii * np.cos(self.transverse)
        total, distance = base.sum(), self.radii.sum()
        along = np.array([np.cos(self.angle), np.sin(self.angle)])
        across = np.array([-along[1], along[0]])
        apart = b[1:3] - a[1:3]
        vector = distance * along + (apart if live else 0.0)
        if live:
            length = np.sqrt(vector @ vector)
            turned = np.arctan((vector @ across) / (vector @ along))
            alpha = np.arctan(np.sqrt(length**2 - total**2) / total)
            opened = (np.tan(alpha) - alpha) - (np.tan(self.transverse) - self.transverse)
        else:
            turned = (apart @ across) / distance
            # the derivative of S inv(alpha) with respect to the centre distance is sin(alpha)
            opened = (apart @ along) * np.sin(self.transverse) / total
        shift = 0.0
        for gear, share, sign in ((a, base[0] / total, 1.0), (b, -base[1] / total, -1.0)):
            y, z = share * vector
            shift = shift + sign * (gear[0] + gear[3] * z - gear[4] * y)
        rolled = base[0] * a[5] + base[1] * b[5] - np.tan(self.base) * shift
        return np.cos(self.base) * (self.sigma * (rolled - total * turned) - total * opened)

    def gradient(self, q: Array, live: bool) -> Array:
        """Give the gradient of the deflection over the twelve coordinates."""
        return np.array(
            [self.deflection(q + 1j * STEP * row, live).imag / STEP for row in np.eye(12)]
        )

    def force(self, q: Array, qd: Array, live: bool) -> tuple[float, Array]:
        """Give the force normal to the teeth and the generalised forces."""
        g = self.gradient(q, live)
        deflection = self.deflection(q.astype(complex), live).real
        value = self.stiffness * (max(deflection, 0.0) if self.film else deflection)
        value += self.damping * (g @ qd)
        return value, -value * g


class HelicalTrain:
    """A train without meshes, axial rods of its shafts, axial and tilting springs, and helical meshes.

    Coordinates: those of the train, then u of every node.
    """

    def __init__(self, train: Train) -> None:
        self.train = train
        nodes = sum(len(x) for x in train.nodes.values())
        n = self.size = train.size + nodes
        self.mass, self.stiffness, self.damping = (np.zeros((n, n)) for _ in range(3))
        self.gyroscopic = np.zeros((n, n))
        old = slice(0, train.size)
        self.mass[old, old], self.stiffness[old, old] = train.mass, train.grounded
        self.damping[old, old], self.gyroscopic[old, old] = train.viscous, train.gyroscopic
        self.meshes: list[tuple[HelicalMesh, Array]] = []
        for shaft in train.shafts:
            x = train.nodes[shaft.name]
            ends = np.cumsum([part.length for part in shaft.parts])
            for left, right in pairwise(x):
                section = shaft.parts[int(np.searchsorted(ends, (left + right) / 2))].section
                at = [self.axial(shaft.name, place) for place in (left, right)]
                length, inertia = right - left, section.density * section.area * (right - left)
                stretch = section.youngs_modulus * section.area / length
                self.mass[np.ix_(at, at)] += inertia / 6 * np.array([[2.0, 1.0], [1.0, 2.0]])
                self.stiffness[np.ix_(at, at)] += stretch * np.array([[1.0, -1.0], [-1.0, 1.0]])
        for body in train.rigid:
            i = self.axial(body.shaft, body.position)
            self.mass[i, i] += body.mass

    def axial(self, shaft: str, position: float) -> int:
        """Give the index of u at a node."""
        return self.train.size + self.train.dof(shaft, position, 0) // 5

    def hold(self, shaft: str, position: float, axial: float, tilting: float) -> None:
        """Add springs along the axis and against tilting at a node."""
        i = self.axial(shaft, position)
        self.stiffness[i, i] += axial
        for coordinate in (2, 3):
            j = self.train.dof(shaft, position, coordinate)
            self.stiffness[j, j] += tilting

    def join(self, driver: str, driven: str, mesh: HelicalMesh) -> None:
        """Add a mesh between two gears."""
        at = []
        for place in (self.train.place(driver), self.train.place(driven)):
            at += [self.axial(*place), *(self.train.dof(*place, c) for c in range(5))]
        self.meshes.append((mesh, np.array(at)))

    def linear(self) -> Array:
        """Give the stiffness with each mesh linearised at rest."""
        total = self.stiffness.copy()
        for mesh, at in self.meshes:
            g = mesh.gradient(np.zeros(12), live=True)
            total[np.ix_(at, at)] += mesh.stiffness * np.outer(g, g)
        return total

    def from_rest(self, speed: float, times: Array, live: bool) -> tuple[Array, Array]:
        """Integrate from rest; give q (k, n), and the mesh forces (k, meshes)."""
        n, old = self.size, self.train.size
        inverse = np.linalg.inv(self.mass)
        damping = self.damping + speed * self.gyroscopic
        steady = np.zeros(n)
        steady[:old] = self.train.steady_force()
        turning = [
            (spin, np.pad(a, (0, n - old)), np.pad(b, (0, n - old)))
            for spin, a, b in self.train.turning_force(speed)
        ]

        def rate(t: float, state: Array) -> Array:
            q, qd = state[:n], state[n:]
            f = steady - self.stiffness @ q - damping @ qd
            for spin, a, b in turning:
                f += np.cos(spin * t) * a + np.sin(spin * t) * b
            for mesh, at in self.meshes:
                f[at] += mesh.force(q[at], qd[at], live)[1]
            return np.concatenate([qd, inverse @ f])

        scale = np.concatenate([np.full(n, 1e-14), np.full(n, 1e-10)])
        found = solve_ivp(
            rate, (0.0, times[-1]), np.zeros(2 * n), "DOP853", times, rtol=1e-10, atol=scale
        )
        assert found.success, found.message
        q, qd = found.y[:n].T, found.y[n:].T
        forces = [
            [mesh.force(one[at], rate_[at], live)[0] for one, rate_ in zip(q, qd, strict=True)]
            for mesh, at in self.meshes
        ]
        return q, np.array(forces).T
