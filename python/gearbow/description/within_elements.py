"""Motion within a shaft element, between its two nodes."""

from collections.abc import Iterator
from functools import cache
from typing import Any, TypeAlias

import numpy as np

from gearbow._types import Array

#: Position of a node or ends of an element [m], direction, and a row of values.
Entries: TypeAlias = dict[float | tuple[float, float], dict[str, Any]]
#: The direction of a displacement, that of its slope, and the sign of the slope.
PLANES = (("v", "G", 1.0), ("w", "B", -1.0))
#: The directions of a rod: the twist and the axial displacement.
RODS = ("twist", "u")


def motion_within(
    entries: Entries, ends: tuple[float, float], xi: Array, phi: float
) -> Iterator[tuple[str, Any]]:
    """Give the directions of an element, each with its values of shape (positions, columns)."""
    first, last = (entries[x] for x in ends)
    length = ends[1] - ends[0]
    inside: dict[str, dict[int, Any]] = {}
    for name, values in entries.get(ends, {}).items():
        direction = name.rstrip("0123456789")
        inside.setdefault(direction, {})[int(name[len(direction) :])] = values
    for across, slope, sign in PLANES:
        if across not in first:
            continue
        nodal = np.array([first[across], sign * first[slope], last[across], sign * last[slope]])
        u: Any = _displacement(xi, length, phi) @ nodal
        angle: Any = _rotation(xi, length, phi) @ nodal
        for n, values in inside.get(across, {}).items():
            # Without shear deformation the rotation is the slope of the displacement.
            own = _integrated(n) if phi > 0.0 else _integrated(n - 1).integ(lbnd=-1.0)
            u += _product(own, xi, values)
            if phi == 0.0:
                angle += _product(2.0 / length * own.deriv(), xi, values)
        for n, values in inside.get(slope, {}).items():
            angle += _product(_integrated(n), xi, sign * values)
        yield across, u
        yield slope, sign * angle
    for direction in RODS:
        if direction in first:
            along = np.outer(1.0 - xi, first[direction]) + np.outer(xi, last[direction])
            for n, values in inside.get(direction, {}).items():
                along += _product(_integrated(n), xi, values)
            yield direction, along


def _product(function: "np.polynomial.Legendre", xi: Array, values: Any) -> Any:
    """Give a polynomial at 2ξ − 1 times the values of the columns, shape (positions, columns)."""
    product: Any = np.outer(function(2.0 * xi - 1.0), values)
    return product


@cache
def _integrated(n: int) -> "np.polynomial.Legendre":
    """Give the integrated Legendre polynomial ψ_n = (P_n − P_{n−2})/√(4n − 2)."""
    basis = np.polynomial.Legendre.basis
    polynomial: np.polynomial.Legendre = (basis(n) - basis(n - 2)) / np.sqrt(4.0 * n - 2.0)
    return polynomial


def _displacement(xi: Array, length: float, phi: float) -> Array:
    """Give the shape functions of the displacement for (u₁, φ₁, u₂, φ₂), shape (positions, 4)."""
    functions = [
        1.0 - 3.0 * xi**2 + 2.0 * xi**3 + (1.0 - xi) * phi,
        length * (xi - 2.0 * xi**2 + xi**3 + (xi - xi**2) * phi / 2.0),
        3.0 * xi**2 - 2.0 * xi**3 + xi * phi,
        length * (-(xi**2) + xi**3 - (xi - xi**2) * phi / 2.0),
    ]
    return np.column_stack(functions) / (1.0 + phi)


def _rotation(xi: Array, length: float, phi: float) -> Array:
    """Give the shape functions of the rotation for (u₁, φ₁, u₂, φ₂), shape (positions, 4)."""
    functions = [
        6.0 / length * (xi**2 - xi),
        1.0 - 4.0 * xi + 3.0 * xi**2 + (1.0 - xi) * phi,
        6.0 / length * (xi - xi**2),
        -2.0 * xi + 3.0 * xi**2 + xi * phi,
    ]
    return np.column_stack(functions) / (1.0 + phi)
