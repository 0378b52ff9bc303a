"""The derivative of a preconditioned residual: minus the identity, plus a matrix of low rank.

Broyden's update (C. G. Broyden, *Mathematics of Computation* 19, 1965) makes the derivative agree
with a measured change. Its inverse follows from a small system (the Sherman-Morrison-Woodbury
formula).
"""

from dataclasses import dataclass

import numpy as np

from gearbow._types import Array

#: Number of columns from which the matrix is compressed, and number of columns after that.
_COLUMNS = 60
_KEPT = 30
#: Part of a step outside the columns of R below which it is round-off.
_DEPENDENT = 1e-10


@dataclass(frozen=True)
class LowRank:
    """The derivative [−I + L Rᵀ, s] with respect to n states and a parameter."""

    left: Array
    right: Array
    slope: Array

    @classmethod
    def identity(cls, slope: Array) -> "LowRank":
        """Give the derivative without a matrix of low rank."""
        return cls(np.zeros((slope.size, 0)), np.zeros((slope.size, 0)), slope)

    def product(self, step: Array) -> Array:
        """Multiply by a step."""
        states, value = step[:-1], step[-1]
        change: Array = self.left @ (self.right.T @ states) - states + self.slope * value
        return change

    def updated(self, step: Array, change: Array) -> "LowRank":
        """Agree with the change of the residual along a step."""
        length = float(step @ step)
        if not length > 0.0:
            return self
        error = (change - self.product(step)) / length
        known = self.right.T @ step[:-1]
        left = self.left + np.outer(error, known)
        rest = step[:-1] - self.right @ known
        rest = rest - self.right @ (self.right.T @ rest)
        part = float(np.linalg.norm(rest))
        right = self.right
        if part > _DEPENDENT * np.sqrt(length):
            left = np.column_stack([left, part * error])
            right = np.column_stack([right, rest / part])
        if left.shape[1] > _COLUMNS:
            left, right = _compressed(left, right)
        return LowRank(left, right, self.slope + error * step[-1])

    def solve(self, row: Array, change: Array, length: float) -> Array:
        """Find the step with a change of the residual and a length along a row."""
        left, right, slope = self.left, self.right, self.slope
        count = left.shape[1]
        # The states of the step are L c + s λ − change with c = Rᵀ states.
        matrix = np.eye(count + 1)
        matrix[:count, :count] -= right.T @ left
        matrix[:count, count] = -right.T @ slope
        matrix[count, :count] = row[:-1] @ left
        matrix[count, count] = row[:-1] @ slope + row[-1]
        known = np.append(-right.T @ change, length + row[:-1] @ change)
        found = np.linalg.solve(matrix, known)
        return np.append(left @ found[:-1] + slope * found[-1] - change, found[-1])


def _compressed(left: Array, right: Array) -> tuple[Array, Array]:
    """Keep the largest singular values of L Rᵀ."""
    directions = np.linalg.svd(left, full_matrices=False)[2][:_KEPT].T
    return left @ directions, right @ directions
