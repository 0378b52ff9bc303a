"""The equation of motion of one linear system, with the sparse solvers of SciPy.

ARPACK finds eigenvalues by shift-invert with factors of the quadratic matrix polynomial, which has
half the size of the first-order form. SuperLU solves linear systems. Modal damping has a low rank.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import LinearOperator, eigs, splu

from programs.scenes import Array

SHIFT = 100.0  # real shift of the eigenvalues, near the lowest frequencies, rad/s
DIRECT = 20  # least number of undamped modes whose modal damping is not left to refinement
ABOVE = 1.5  # modes up to this multiple of |λ| are among them: beyond, refinement converges
CONVERGED = 1e-8  # relative change at which iterative refinement ends
SECANT = 1e-6  # part of the interval at which the secant method ends
MAX_SECANTS = 20  # it needs about three steps
MAX_REFINEMENTS = 5  # three are enough away from an eigenvalue

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Pencil:
    """P(λ) = λ² M + λ (C + B R Bᵀ) + K of a system at one speed.

    Parameters
    ----------
    mass, damping, stiffness : csc_matrix, shape (n, n)
        M, C with the gyroscopic matrix times the speed, and K.
    momenta : ndarray, shape (n, m), optional
        B: mass matrix times undamped modes of unit modal mass, by ascending frequency. Without,
        there is no modal damping.
    rates : ndarray, shape (m,), optional
        Diagonal of R: 2 ζ ω of each mode, positive [1/s].
    ratio : float, optional
        ζ of all modes.
    """

    mass: Any
    damping: Any
    stiffness: Any
    momenta: Array | None = None
    rates: Array | None = None
    ratio: float = 0.0

    def damped(self, x: Any) -> Any:
        """Return the damping forces of velocities x."""
        found = self.damping @ x
        if self.momenta is not None and self.rates is not None:
            found = found + self.momenta @ (self.rates * (self.momenta.T @ x))
        return found

    def inverse(self, value: complex) -> Callable[[Any], Any]:
        """Return the function that solves P(value) x = force.

        Woodbury's formula adds the modal damping of the lowest modes to the sparse factors, and
        iterative refinement that of the others, whose part is small.
        """
        polynomial = csc_matrix(self.stiffness + value * (self.damping + value * self.mass))
        factors = splu(polynomial)
        solve: Callable[[Any], Any] = factors.solve
        if self.momenta is None or self.rates is None:
            return solve
        momenta, rates = self.momenta, self.rates
        frequencies = rates / (2.0 * self.ratio)
        direct = max(DIRECT, int(np.searchsorted(frequencies, ABOVE * abs(value))))
        low = momenta[:, :direct]
        motions = solve(low.astype(polynomial.dtype))
        small = lu_factor(np.diag(1.0 / (value * rates[:direct])) + low.T @ motions)

        def corrected(force: Any) -> Any:
            x = solve(force)
            return x - motions @ lu_solve(small, low.T @ x)

        def refined(force: Any) -> Any:
            found = corrected(force)
            # Next to an eigenvalue, where P is nearly singular, round-off prevents convergence.
            for _ in range(MAX_REFINEMENTS):
                modal = momenta @ (value * rates * (momenta.T @ found))
                change = corrected(force - polynomial @ found - modal)
                found = found + change
                if np.linalg.norm(change) <= CONVERGED * np.linalg.norm(found):
                    break
            return found

        return refined

    def eigenvalues(self, count: int) -> tuple[Complex, Complex]:
        """Return `count` eigenvalues near the shift and their displacements (n, count)."""
        n = self.mass.shape[0]
        solve = self.inverse(SHIFT)

        def inverse(y: Array) -> Array:
            q, v = y[:n], y[n:]
            u = -solve(self.mass @ (v + SHIFT * q) + self.damped(q))
            return np.concatenate([u, q + SHIFT * u])

        operator = LinearOperator((2 * n, 2 * n), matvec=inverse, dtype=float)
        inverted, vectors = eigs(operator, k=count, v0=np.ones(2 * n))
        return SHIFT + 1.0 / inverted, vectors[:n]

    def refined(self, value: complex, x: Complex, steps: int) -> tuple[complex, Complex]:
        """Return an eigenvalue and its displacements after some steps of Newton's method."""
        for _ in range(steps):
            slope = self.damped(x) + 2.0 * value * (self.mass @ x)
            # The eigenvalue changes by (xᴴ x) / (xᴴ P⁻¹ P' x).
            found = self.inverse(value)(slope)
            value = value - (x.conj() @ x) / (x.conj() @ found)
            x = found / np.linalg.norm(found)
        return value, x

    def between(self, other: "Pencil", part: float) -> "Pencil":
        """Return the linear interpolation to another speed; modal damping stays the same."""
        mass, damping, stiffness = (
            (1.0 - part) * mine + part * yours
            for mine, yours in (
                (self.mass, other.mass),
                (self.damping, other.damping),
                (self.stiffness, other.stiffness),
            )
        )
        return Pencil(mass, damping, stiffness, self.momenta, self.rates, self.ratio)


def crossings(
    ends: tuple[Pencil, Pencil], speeds: tuple[float, float], orders: Sequence[float], count: int
) -> list[float]:
    """Return the speeds at which Im λ = order·Ω between two speeds [rad/s].

    `count` eigenvalues at both speeds give the starts. The secant method follows the speed, and
    Newton's method the eigenvalue.
    """
    (lower, shapes), (upper, _) = (end.eigenvalues(count) for end in ends)
    found = []
    for value, shape in zip(lower, shapes.T, strict=True):
        other = upper[np.argmin(np.abs(upper - value))]
        for order in orders:
            gaps = [value.imag - order * speeds[0], other.imag - order * speeds[1]]
            if value.imag > 1.0 and gaps[0] * gaps[1] < 0.0:
                found.append(_crossing(ends, speeds, order, gaps, (value, shape)))
    return found


def _crossing(
    ends: tuple[Pencil, Pencil],
    speeds: tuple[float, float],
    order: float,
    gaps: list[float],
    start: tuple[complex, Complex],
) -> float:
    """Return the part of the interval at which the gap is zero, as a speed [rad/s]."""
    parts, (value, x) = [0.0, 1.0], start
    for _ in range(MAX_SECANTS):
        slope = (gaps[-1] - gaps[-2]) / (parts[-1] - parts[-2])
        part = parts[-1] - gaps[-1] / slope
        value, x = ends[0].between(ends[1], part).refined(value, x, 2)
        parts.append(part)
        gaps.append(value.imag - order * (speeds[0] + part * (speeds[1] - speeds[0])))
        if abs(parts[-1] - parts[-2]) <= SECANT or gaps[-1] == gaps[-2]:
            break
    return speeds[0] + parts[-1] * (speeds[1] - speeds[0])
