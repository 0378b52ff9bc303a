"""Matrices of frames of straight bars in space, in NumPy: six degrees of freedom at each node.

Bars are Timoshenko beams of circular section (Przemieniecki 1968, section 5.6) with half of their
mass at each end, which is accurate for short elements. They stand for a finite-element program in tests of elastic housings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class Frame:
    """Nodes (x, y, z) [m] and bars between them, with the radius of each [m]."""

    youngs_modulus: float = 2.1e11
    poisson_ratio: float = 0.3
    density: float = 7800.0
    nodes: list[tuple[float, float, float]] = field(default_factory=list)
    bars: list[tuple[int, int, float]] = field(default_factory=list)
    clamped: set[int] = field(default_factory=set)

    def node(self, *place: float) -> int:
        """Give the index of a node, which is made if there is none at the place."""
        at = tuple(round(float(x), 9) for x in place)
        if at not in self.nodes:
            self.nodes.append(at)  # type: ignore[arg-type]
        return self.nodes.index(at)  # type: ignore[arg-type]

    def bar(self, begin: Sequence[float], end: Sequence[float], radius: float, parts: int) -> None:
        """Add a bar of several elements."""
        a, b = np.array(begin, dtype=float), np.array(end, dtype=float)
        along = [self.node(*(a + (b - a) * i / parts)) for i in range(parts + 1)]
        self.bars += [(*pair, radius) for pair in pairwise(along)]

    def clamp(self, *place: float) -> None:
        self.clamped.add(self.node(*place))

    def rows(self, *place: float) -> list[int]:
        """Give the degrees of freedom of a node, without those of clamped nodes."""
        free = self._free()
        return [free.index(6 * self.node(*place) + i) for i in range(6)]

    def _free(self) -> list[int]:
        size = range(6 * len(self.nodes))
        return [i for i in size if i // 6 not in self.clamped]

    def matrices(self) -> tuple[Array, Array]:
        """Give mass and stiffness matrix of the free degrees of freedom."""
        size = 6 * len(self.nodes)
        mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
        for a, b, radius in self.bars:
            index = [6 * a + i for i in range(6)] + [6 * b + i for i in range(6)]
            m, k = self._element(np.array(self.nodes[a]), np.array(self.nodes[b]), radius)
            mass[np.ix_(index, index)] += m
            stiffness[np.ix_(index, index)] += k
        free = self._free()
        return mass[np.ix_(free, free)], stiffness[np.ix_(free, free)]

    def _element(self, begin: Array, end: Array, radius: float) -> tuple[Array, Array]:
        length = float(np.linalg.norm(end - begin))
        area, moment = np.pi * radius**2, np.pi * radius**4 / 4.0
        e, polar = self.youngs_modulus, 2.0 * moment
        g = e / (2.0 * (1.0 + self.poisson_ratio))
        # shear coefficient 0.9 of a solid circle, as finite-element programs take it
        shear = 12.0 * e * moment / (0.9 * g * area * length**2)
        k = np.zeros((12, 12))
        for i, rigidity in ((0, e * area), (3, g * polar)):
            k[np.ix_([i, i + 6], [i, i + 6])] = rigidity / length * np.array([[1, -1], [-1, 1]])
        s = length
        near, far = (4.0 + shear) * s * s, (2.0 - shear) * s * s
        bend = np.array(
            [
                [12, 6 * s, -12, 6 * s],
                [6 * s, near, -6 * s, far],
                [-12, -6 * s, 12, -6 * s],
                [6 * s, far, -6 * s, near],
            ]
        )
        bend *= e * moment / (s**3 * (1.0 + shear))
        for places, signs in (((1, 5, 7, 11), (1, 1, 1, 1)), ((2, 4, 8, 10), (1, -1, 1, -1))):
            sign = np.diag(signs)
            k[np.ix_(places, places)] += sign @ bend @ sign
        half = self.density * length / 2.0
        m = np.diag(2 * (3 * [half * area] + [half * polar] + 2 * [half * moment]))
        x = (end - begin) / length
        other = np.array([0.0, 0.0, 1.0]) if abs(x[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
        y = np.cross(other, x)
        y /= np.linalg.norm(y)
        turned = np.kron(np.eye(4), np.array([x, y, np.cross(x, y)]))
        return turned.T @ m @ turned, turned.T @ k @ turned
