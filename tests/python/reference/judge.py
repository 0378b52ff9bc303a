"""Motion of an independent train from rest: SciPy's DOP853 on the first-order equations.

M q'' + (C + speed G) q' + K q + sum of mesh forces = bow(t) + unbalance(t) + torque + gravity
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from reference import elements
from reference.train import Train

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    train: Train
    time: Array
    q: Array  # (k, n)
    qd: Array

    def displacement(self, name: str) -> Array:
        place = self.train.place(name)
        at = [self.train.dof(*place, c) for c in (elements.V, elements.W)]
        return self.q[:, at]

    def twist(self, name: str) -> Array:
        return self.q[:, self.train.dof(*self.train.place(name), elements.T)]

    def mesh_force(self, index: int, live: bool) -> Array:
        mesh = self.train.meshes[index]
        at = self.train.interface(mesh)
        return np.array(
            [mesh.law.force(q[at], qd[at], live)[0] for q, qd in zip(self.q, self.qd, strict=True)]
        )

    def contact_ratio(self, index: int) -> Array:
        mesh = self.train.meshes[index]
        at = self.train.interface(mesh)
        return np.array(
            [mesh.law.contact_ratio(mesh.law.centres(q[at][:2], q[at][3:5])[0]) for q in self.q]
        )


def from_rest(
    train: Train, speed: float, times: Array, live: bool = True, rtol: float = 1e-10
) -> Motion:
    """Integrate from q = q' = 0 at t = 0."""
    n = train.size
    stiffness, damping = train.grounded, train.viscous + speed * train.gyroscopic
    inverse = np.linalg.inv(train.mass)
    acceleration = np.hstack([-inverse @ stiffness, -inverse @ damping])
    steady = inverse @ train.steady_force()
    turning = [
        (spin, inverse @ at_0, inverse @ at_90) for spin, at_0, at_90 in train.turning_force(speed)
    ]
    interfaces = [(train.interface(mesh), mesh.law) for mesh in train.meshes]
    pushes = [inverse[:, at] for at, _ in interfaces]

    def rate(t: float, state: Array) -> Array:
        a = acceleration @ state + steady
        for spin, at_0, at_90 in turning:
            a += np.cos(spin * t) * at_0 + np.sin(spin * t) * at_90
        for (at, law), push in zip(interfaces, pushes, strict=True):
            a += push @ law.force(state[at], state[n + at], live)[1]
        return np.concatenate([state[n:], a])

    scale = np.concatenate([np.full(n, 1e-14), np.full(n, 1e-10)])  # m and rad; m/s and rad/s
    found = solve_ivp(
        rate, (0.0, times[-1]), np.zeros(2 * n), "DOP853", times, rtol=rtol, atol=scale
    )
    assert found.success, found.message
    return Motion(train, times, found.y[:n].T, found.y[n:].T)
