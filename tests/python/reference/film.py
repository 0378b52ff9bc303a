"""Oil film of a journal bearing by numerical integration: the short film, and Reynolds' equation on a regular grid.

The force of the journal on the film is the integral of the pressure. With the displacement e (m), the velocity v (m/s) and the
spin s (rad/s), the film thickness is h = c - e.n at the direction n = (cos a, sin a), and Reynolds' equation has the source
12 dh/dt + 6 s dh/da.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

Array = NDArray[np.float64]

#: Gauss-Legendre rule over the half circle with pressure.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)


@dataclass(frozen=True)
class Bearing:
    diameter: float
    length: float
    clearance: float
    viscosity: float


def source(angle: Array, e: Array, v: Array, spin: float) -> Array:
    """Give 12 dh/dt + 6 s dh/da [m/s]."""
    cos, sin = np.cos(angle), np.sin(angle)
    return -12 * (v[0] * cos + v[1] * sin) + 6 * spin * (e[0] * sin - e[1] * cos)


def short(bearing: Bearing, e: Array, v: Array, spin: float) -> Array:
    """Give the force on a short film [N]: d/dx(h^3 dp/dx) = mu * source with p = 0 at both ends, where that is positive."""
    # the source is -|s| cos(a - b): the pressure is positive within a quarter turn of b
    at_0, at_90 = (source(np.array(a), e, v, spin) for a in (0.0, np.pi / 2))
    middle = np.arctan2(-at_90, -at_0)
    angle = middle + np.pi / 2 * NODES
    cos, sin = np.cos(angle), np.sin(angle)
    h = bearing.clearance - e[0] * cos - e[1] * sin
    # the parabola p = -mu source (L^2/4 - x^2)/(2 h^3) has the integral -mu source L^3/(12 h^3)
    line = -bearing.viscosity * source(angle, e, v, spin) * bearing.length**3 / (12 * h**3)
    weighted = np.pi / 2 * WEIGHTS * line * bearing.diameter / 2
    return np.array([weighted @ cos, weighted @ sin])


def finite(
    bearing: Bearing,
    e: Array,
    v: Array,
    spin: float,
    *,
    grooves: list[tuple[float, float]],
    shape: tuple[int, int] = (270, 18),
) -> Array:
    """Give the force on a film of finite length [N], with p >= 0 (Reynolds' condition), on a regular grid."""
    count, rows = shape
    radius, c = bearing.diameter / 2, bearing.clearance
    angle = 2 * np.pi * np.arange(count) / count
    step, width = 2 * np.pi / count, bearing.length / 2 / rows

    def cube(a: Array) -> Array:
        return (c - e[0] * np.cos(a) - e[1] * np.sin(a)) ** 3

    right, node = cube(angle + step / 2), cube(angle)
    left = np.roll(right, 1)
    is_dry = np.zeros((count, rows), dtype=bool)
    for middle, extent in grooves:
        apart = (angle - middle + np.pi) % (2 * np.pi) - np.pi
        is_dry[np.abs(apart) <= extent / 2 + 1e-12] = True
    fixed = is_dry.copy()
    index = np.arange(count * rows).reshape(count, rows)
    half = np.ones(rows)
    half[0] = 0.5  # symmetry at the middle of the bearing
    around = half * width / (radius**2 * step)
    along = step / width
    entries = []

    def couple(a: Array, b: Array, value: Array) -> None:
        entries.extend([(a, a, value), (b, b, value), (a, b, -value), (b, a, -value)])

    couple(index, np.roll(index, -1, axis=0), right[:, None] * around)
    couple(index[:, :-1], index[:, 1:], np.repeat(node[:, None] * along, rows - 1, axis=1))
    entries.append((index[:, -1], index[:, -1], node * along))  # p = 0 at the end
    i, j, x = (np.concatenate([np.ravel(entry[k]) for entry in entries]) for k in range(3))
    matrix = coo_matrix((x, (i, j)), (count * rows, count * rows)).tocsr()
    assert np.all(left > 0)
    load = -bearing.viscosity * np.outer(source(angle, e, v, spin), half) * step * width
    load, fixed, wet = load.ravel(), fixed.ravel(), (load > 0).ravel() & ~fixed.ravel()
    for _ in range(100):
        pressure = np.zeros(count * rows)
        pressure[wet] = spsolve(matrix[wet][:, wet], load[wet])
        new = np.where(wet, pressure > 0, load - matrix @ pressure > 0) & ~fixed
        if np.array_equal(new, wet):
            break
        wet = new
    # trapezoidal rule over both halves of the length
    line = (np.maximum(pressure, 0.0).reshape(count, rows) * half).sum(axis=1) * 2 * width
    weighted = line * step * radius
    return np.array([weighted @ np.cos(angle), weighted @ np.sin(angle)])
