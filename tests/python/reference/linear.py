"""Motion of a linear train, exact: the matrix exponential of its state with what acts on it.

M q'' + (C + speed G) q' + K q = f + sum of Re[F exp(i w t)]

Constant and turning forces are states of their own (1, cos w t, sin w t), so the whole is one exponential.
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
    damping: Array  # with speed times the gyroscopic matrix in it
    stiffness: Array
    steady: Array
    turning: Sequence[Turning] = field(default_factory=tuple)

    def motion(self, times: Array, q: Array, v: Array) -> tuple[Array, Array]:
        """Displacements and velocities at equally spaced `times`, the first of which is that of q and v."""
        n, sources = len(q), len(self.turning)
        low = np.linalg.cholesky(self.mass)

        def whiten(x: Array) -> Array:
            return np.asarray(solve_triangular(low, x, lower=True))

        stiffness = whiten(whiten(self.stiffness).T).T
        damping = whiten(whiten(self.damping).T).T
        # displacements are measured in velocities, by a frequency in the middle of those there are
        scale = np.sqrt(np.linalg.norm(stiffness, 2)) or 1.0
        size = 2 * n + 1 + 2 * sources
        matrix = np.zeros((size, size))
        matrix[:n, n : 2 * n] = scale * np.eye(n)
        matrix[n : 2 * n, :n] = -stiffness / scale
        matrix[n : 2 * n, n : 2 * n] = -damping
        state = np.zeros(size)
        state[:n], state[n : 2 * n] = scale * (low.T @ q), low.T @ v
        # forces are of the size of what they act on, and so are the states that carry them
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
