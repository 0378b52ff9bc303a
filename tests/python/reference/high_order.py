"""A shaft of elements of degree p in another basis: Lagrange polynomials for u and φ.

The displacement u = v + iw has the degree p + 1 and the rotation φ = G − iB the degree p on each element, both
continuous. Nodal and internal shape functions of the package span the same space for p > 1 with shear
deformation, so that frequencies and responses are equal up to round-off. All integrals are taken by
Gauss quadrature.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from reference.elements import Section

Array = NDArray[np.float64]


def lagrange(degree: int) -> list[Polynomial]:
    """Give the polynomials over [0, 1] of equally spaced points, first those of the two ends."""
    points = np.linspace(0.0, 1.0, degree + 1)
    points = np.concatenate([points[[0, -1]], points[1:-1]])
    found = []
    for i, point in enumerate(points):
        others = np.delete(points, i)
        found.append(Polynomial.fromroots(others) / np.prod(point - others))
    return found


@dataclass(frozen=True)
class Shaft:
    """A shaft in complex coordinates: u of all nodes, φ of all nodes, then the inner points."""

    nodes: Sequence[float]  # m
    sections: Sequence[Section]  # of each element
    degree: int
    breaks: Sequence[float] = ()  # m; where the curvature of a bow has a kink

    def assemble(self) -> tuple[Array, Array, Array]:
        """Give mass, rotary inertia (a part of the mass) and stiffness."""
        matrices = [np.zeros((self.size, self.size)) for _ in range(3)]
        for element, section in enumerate(self.sections):
            at, weights, shapes = self.shapes(element)
            u, turn, slope, curvature = shapes
            shear = section.kappa * section.shear_modulus * section.area
            bending = section.youngs_modulus * section.moment
            rotary = section.density * section.moment * (turn * weights) @ turn.T
            strain = slope - turn
            parts = (
                section.density * section.area * (u * weights) @ u.T + rotary,
                rotary,
                bending * (curvature * weights) @ curvature.T
                + shear * (strain * weights) @ strain.T,
            )
            for matrix, part in zip(matrices, parts, strict=True):
                matrix[np.ix_(at, at)] += part
        mass, rotary, stiffness = matrices
        return mass, rotary, stiffness

    def bow_force(self, curvature: Callable[[Array], Array]) -> NDArray[np.complex128]:
        """Give the force of a stress-free shape with the curvature b''(x)."""
        force = np.zeros(self.size, dtype=complex)
        for element, section in enumerate(self.sections):
            at, weights, shapes = self.shapes(element)
            x = self.nodes[element] + self.abscissae(element)[0] * np.diff(self.nodes)[element]
            bending = section.youngs_modulus * section.moment
            force[at] += bending * shapes[3] @ (weights * curvature(x))
        return force

    def weight(self) -> Array:
        """Give the force of a unit acceleration along y."""
        force = np.zeros(self.size)
        for element, section in enumerate(self.sections):
            at, weights, shapes = self.shapes(element)
            force[at] += section.density * section.area * shapes[0] @ weights
        return force

    @property
    def size(self) -> int:
        return 2 * len(self.nodes) + len(self.sections) * (2 * self.degree - 1)

    def abscissae(self, element: int) -> tuple[Array, Array]:
        """Give points and weights over [0, 1]: a Gauss rule on each piece between two breaks."""
        start, end = self.nodes[element], self.nodes[element + 1]
        inside = [(x - start) / (end - start) for x in self.breaks if start < x < end]
        x, weight = leggauss(self.degree + 12)
        pieces = [(a, b - a) for a, b in pairwise([0.0, *inside, 1.0])]
        points = [a + size * (1 + x) / 2 for a, size in pieces]
        return np.concatenate(points), np.concatenate([size * weight / 2 for _, size in pieces])

    def shapes(self, element: int) -> tuple[Array, Array, list[Array]]:
        """Give indices, weights [m], and u, φ, u' and φ' of every shape function at the points."""
        length = np.diff(self.nodes)[element]
        x, weight = self.abscissae(element)
        displacements, rotations = lagrange(self.degree + 1), lagrange(self.degree)
        inner = 2 * len(self.nodes) + element * (2 * self.degree - 1)
        second = inner + self.degree
        ends = np.array([element, element + 1])
        at = np.concatenate([ends, np.arange(inner, second), ends + len(self.nodes)])
        at = np.concatenate([at, np.arange(second, second + self.degree - 1)])
        none = np.zeros((len(rotations), x.size)), np.zeros((len(displacements), x.size))

        def values(of: Sequence[Polynomial]) -> Array:
            return np.array([one(x) for one in of])

        slopes = [one.deriv() / length for one in displacements]
        curvatures = [one.deriv() / length for one in rotations]
        return (
            at,
            weight * length,
            [
                np.vstack([values(displacements), none[0]]),
                np.vstack([none[1], values(rotations)]),
                np.vstack([values(slopes), none[0]]),
                np.vstack([none[1], values(curvatures)]),
            ],
        )
