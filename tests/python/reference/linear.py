"""Exact motion of a linear train: matrix exponential of the state extended by the excitation.

M q'' + (C + speed G) q' + K q = f + sum of Re[F exp(i w t)]

The states 1, cos w t and sin w t represent constant and rotating forces in one exponential.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_triangular

Array = NDArray[np.float64]
Turning = tuple[float, Array, Array]  # spin, and the force at angle 0 and at a quarter turn


@dataclass(frozen=True)
class LinearTrain:
    mass: Array
    damping: Array  # includes speed times the gyroscopic matrix
    stiffness: Array
    steady: Array
    turning: Sequence[Turning] = field(default_factory=tuple)

    def motion(self, times: Array, q: Array, v: Array) -> tuple[Array, Array]:
        """Give displacements and velocities at equally spaced `times`, from q and v."""
        n, sources = len(q), len(self.turning)
        low = np.linalg.cholesky(self.mass)

        def whiten(x: Array) -> Array:
            return np.asarray(solve_triangular(low, x, lower=True))

        stiffness = whiten(whiten(self.stiffness).T).T
        damping = whiten(whiten(self.damping).T).T
        # a mean frequency scales displacements to velocities
        scale = np.sqrt(np.linalg.norm(stiffness, 2)) or 1.0
        size = 2 * n + 1 + 2 * sources
        matrix = np.zeros((size, size))
        matrix[:n, n : 2 * n] = scale * np.eye(n)
        matrix[n : 2 * n, :n] = -stiffness / scale
        matrix[n : 2 * n, n : 2 * n] = -damping
        state = np.zeros(size)
        state[:n], state[n : 2 * n] = scale * (low.T @ q), low.T @ v
        # the force states have the scale of the state on which they act
        forces = [self.steady, *(part for _, *parts in self.turning for part in parts)]
        unit = max(float(np.linalg.norm(whiten(f))) for f in forces) / scale or 1.0
        for place, force in enumerate(forces, 2 * n):
            matrix[n : 2 * n, place] = whiten(force) / unit
        state[2 * n] = unit
        for k, (spin, *_) in enumerate(self.turning):
            cos, sin = 2 * n + 1 + 2 * k, 2 * n + 2 + 2 * k
            matrix[cos, sin], matrix[sin, cos] = -spin, spin
            state[cos], state[sin] = unit * np.cos(spin * times[0]), unit * np.sin(spin * times[0])
        step = expm(matrix * (times[1] - times[0]))
        rows = [state]
        for _ in times[1:]:
            rows.append(step @ rows[-1])
        found = np.array(rows)
        back = np.linalg.inv(low.T)
        return found[:, :n] @ back.T / scale, found[:, n : 2 * n] @ back.T
