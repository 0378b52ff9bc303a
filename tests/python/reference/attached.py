"""A train with springs between any points, and with rigid bodies under its bearings.

The statement is that of vectors: a point of a rigid body at the distance r from its centre of mass moves by u + φ × r, and
a spring has the force K (difference of the displacements of its ends - its length at rest).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.linear import LinearTrain
from reference.train import Train

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RigidBody:
    """A rigid body with the moments of inertia about x, y and z; two coordinates without them."""

    mass: float
    inertia: tuple[float, float, float] | None = None

    @property
    def size(self) -> int:
        return 2 if self.inertia is None else 5

    def masses(self) -> list[float]:
        """Give the inertia of v, w, B, G and twist."""
        if self.inertia is None:
            return [self.mass] * 2
        x, y, z = self.inertia
        return [self.mass, self.mass, y, z, x]


class Attached:
    """Matrices of a train without bearings, of rigid bodies, and of the springs added to them."""

    def __init__(self, train: Train, *bodies: RigidBody) -> None:
        self.train, self.bodies = train, bodies
        self.first = train.size + np.cumsum([0, *(body.size for body in bodies)])
        self.size = int(self.first[-1])
        extra = np.zeros(self.size - train.size)
        stiffness, damping = train.linear()
        self.mass = self._embedded(train.mass)
        self.gyroscopic = self._embedded(train.gyroscopic)
        self.stiffness, self.damping = self._embedded(stiffness), self._embedded(damping)
        masses = [mass for body in bodies for mass in body.masses()]
        at = np.arange(train.size, self.size)
        self.mass[at, at] = masses
        self.steady = np.concatenate([train.steady_force(), extra])
        for body, first in zip(bodies, self.first[:-1], strict=True):
            self.steady[first : first + 2] += body.mass * np.array(train.gravity)
        self.turning = np.zeros(self.size, complex)

    def _embedded(self, matrix: Array) -> Array:
        whole = np.zeros((self.size, self.size))
        whole[: self.train.size, : self.train.size] = matrix
        return whole

    def node(self, shaft: str, position: float) -> Array:
        """Give the rows of v and w of a node."""
        return np.eye(self.size)[[self.train.dof(shaft, position, c) for c in (0, 1)]]

    def slopes(self, shaft: str, position: float) -> Array:
        """Give the rows of dv/dx = G and dw/dx = -B of a node."""
        gamma, b = (self.train.dof(shaft, position, c) for c in (3, 2))
        return np.eye(self.size)[[gamma, b]] * [[1.0], [-1.0]]

    def twist(self, shaft: str, position: float) -> Array:
        """Give the row of the twist of a node."""
        return np.eye(self.size)[[self.train.dof(shaft, position, 4)]]

    def point(self, body: int, arm: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Array:
        """Give the rows of the displacements along y and z of a point of a rigid body."""
        first, rows = self.first[body], np.zeros((2, self.size))
        rows[:, first : first + 2] = np.eye(2)
        if self.bodies[body].inertia is not None:
            for axis, column in ((1, 2), (2, 3), (0, 4)):  # B, G, twist
                rows[:, first + column] = np.cross(np.eye(3)[axis], arm)[1:]
        return rows

    def rotations(self, body: int) -> Array:
        """Give the rows of the rotations about x, y and z of a rigid body."""
        first = self.first[body]
        return np.eye(self.size)[[first + 4, first + 2, first + 3]]

    def spring(
        self,
        rows: Array,
        stiffness: Array | float,
        damping: Array | float = 0.0,
        rest: complex = 0.0,
        turning: complex = 0.0,
    ) -> None:
        """Add a spring over the displacements `rows @ q`, with the length at rest.

        The length is rest + turning exp(i angle), as displacements along y + iz.
        """
        stiffness, damping = (
            np.eye(len(rows)) * given if np.ndim(given) == 0 else np.asarray(given)
            for given in (stiffness, damping)
        )
        self.stiffness += rows.T @ stiffness @ rows
        self.damping += rows.T @ damping @ rows
        if rest or turning:
            self.steady += rows.T @ stiffness @ [rest.real, rest.imag]
            # y = Re(turning exp(i angle)) and z = Im(...) = Re(-i turning exp(i angle))
            self.turning += rows.T @ stiffness @ np.array([turning, -1j * turning])

    def excitation(self, speed: float) -> NDArray[np.complex128]:
        """Give the phasor of bow, unbalance and turning springs; one speed for all shafts."""
        total = self.turning.copy()
        for _, at_0, at_90 in self.train.turning_force(speed):
            total[: self.train.size] += at_0 - 1j * at_90
        return total

    def linear(self, speed: float) -> LinearTrain:
        """Give the equations at one speed of all shafts."""
        force = self.excitation(speed)
        turning = [(speed, force.real, -force.imag)]
        rates = self.damping + speed * self.gyroscopic
        return LinearTrain(self.mass, rates, self.stiffness, self.steady, turning)

    def synchronous(self, speed: float) -> NDArray[np.complex128]:
        """Give the phasors of the response to everything that turns."""
        rates = self.damping + speed * self.gyroscopic
        dynamic = self.stiffness - speed**2 * self.mass + 1j * speed * rates
        return np.linalg.lstsq(dynamic, self.excitation(speed), rcond=1e-14)[0]
