"""A geared train assembled in NumPy with dense matrices: bow force, unbalance and meshes.

Coordinates run over shafts, then nodes along x, then v, w, B, G, t. Angles of shaft s at time t: ratio_s * speed * t.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from reference import elements
from reference.mesh_law import MeshLaw

Array = NDArray[np.float64]
Curve = Callable[[float], complex]
Place = tuple[str, float]  # shaft, position


@dataclass(frozen=True)
class ShaftPart:
    length: float
    section: elements.Section
    count: int = 1


@dataclass(frozen=True)
class ShaftSpec:
    name: str
    parts: Sequence[ShaftPart]
    ratio: float = 1.0
    bow: Curve | None = None
    bow_slope: Curve | None = None


@dataclass(frozen=True)
class RigidSpec:
    """A disk or a gear."""

    name: str
    shaft: str
    position: float
    mass: float
    diametral: float
    polar: float
    unbalance: complex = 0j


@dataclass(frozen=True)
class BearingSpec:
    shaft: str
    position: float
    stiffness: Array
    damping: Array
    support: Place | None = None  # a place on another shaft; None is the ground


@dataclass(frozen=True)
class MeshSpec:
    driver: str
    driven: str
    law: MeshLaw


@dataclass(frozen=True)
class TurningBow:
    """Forces of a bow at the shaft angles 0 and pi/2, and the row of the twist with which it turns."""

    ratio: float
    at_0: Array
    at_90: Array
    twist: Array


@dataclass
class Train:
    shafts: Sequence[ShaftSpec]
    rigid: Sequence[RigidSpec] = ()
    bearings: Sequence[BearingSpec] = ()
    meshes: Sequence[MeshSpec] = ()
    torques: Sequence[tuple[str | Place, float]] = ()  # at a gear, a disk or a place
    gravity: tuple[float, float] = (0.0, 0.0)
    bow_torque: bool = False  # whether bows turn with the twist
    nodes: dict[str, Array] = field(init=False)
    offset: dict[str, int] = field(init=False)

    def __post_init__(self) -> None:
        self.nodes, self.offset, count = {}, {}, 0
        for shaft in self.shafts:
            places, start = [0.0], 0.0
            for part in shaft.parts:
                places += [start + part.length * (i + 1) / part.count for i in range(part.count)]
                start += part.length
            for position in self._positions(shaft.name):
                if min(abs(position - p) for p in places) > 1e-9 * start:
                    places.append(position)
            self.nodes[shaft.name] = np.array(sorted(places))
            self.offset[shaft.name] = count
            count += 5 * len(places)
        self.size = count
        self._assemble()

    def _positions(self, shaft: str) -> list[float]:
        places = [(x.shaft, x.position) for x in (*self.rigid, *self.bearings)]
        places += [bearing.support for bearing in self.bearings if bearing.support]
        places += [at for at, _ in self.torques if isinstance(at, tuple)]
        return [position for name, position in places if name == shaft]

    def dof(self, shaft: str, position: float, coordinate: int) -> int:
        gaps = np.abs(self.nodes[shaft] - position)
        assert gaps.min() < 1e-9, f"no node at {shaft} {position}"
        return self.offset[shaft] + 5 * int(np.argmin(gaps)) + coordinate

    def dofs(self) -> list[tuple[str, float, str]]:
        return [
            (s.name, float(x), c)
            for s in self.shafts
            for x in self.nodes[s.name]
            for c in ("v", "w", "B", "G", "twist")
        ]

    def place(self, name: str | Place) -> Place:
        if isinstance(name, tuple):
            return name
        return next((r.shaft, r.position) for r in self.rigid if r.name == name)

    def interface(self, mesh: MeshSpec) -> NDArray[np.intp]:
        """Give the indices of v_a, w_a, t_a, v_b, w_b, t_b."""
        gears = (self.place(mesh.driver), self.place(mesh.driven))
        return np.array(
            [self.dof(*gear, c) for gear in gears for c in (elements.V, elements.W, elements.T)]
        )

    def _assemble(self) -> None:
        n = self.size
        self.mass, self.gyroscopic = np.zeros((n, n)), np.zeros((n, n))
        self.elastic = np.zeros((n, n))  # only the shafts
        self.elements: dict[str, list[Array]] = {}  # elastic matrices along each shaft
        for shaft in self.shafts:
            x, i = self.nodes[shaft.name], self.offset[shaft.name]
            ends = np.cumsum([part.length for part in shaft.parts])
            self.elements[shaft.name] = []
            for j in range(len(x) - 1):
                middle = (x[j] + x[j + 1]) / 2
                section = shaft.parts[int(np.searchsorted(ends, middle))].section
                m, k, g = elements.beam(section, x[j + 1] - x[j])
                here = slice(i + 5 * j, i + 5 * j + 10)
                self.mass[here, here] += m
                self.elastic[here, here] += k
                self.elements[shaft.name].append(k)
                self.gyroscopic[here, here] += shaft.ratio * g
        ratios = {s.name: s.ratio for s in self.shafts}
        for body in self.rigid:
            i = self.dof(body.shaft, body.position, 0)
            m, g = elements.disk(body.mass, body.diametral, body.polar)
            self.mass[i : i + 5, i : i + 5] += m
            self.gyroscopic[i : i + 5, i : i + 5] += ratios[body.shaft] * g
        self.grounded = self.elastic.copy()  # shafts and bearings, without meshes
        self.viscous = np.zeros((n, n))
        for bearing in self.bearings:
            ends = [((bearing.shaft, bearing.position), 1.0)]
            ends += [(bearing.support, -1.0)] if bearing.support else []
            apart = np.zeros((2, n))
            for place, sign in ends:
                i = self.dof(*place, 0)
                apart[:, i : i + 2] = sign * np.eye(2)
            self.grounded += apart.T @ bearing.stiffness @ apart
            self.viscous += apart.T @ bearing.damping @ apart

    def linear(self) -> tuple[Array, Array]:
        """Give stiffness and damping with each mesh linearised at rest."""
        stiffness, damping = self.grounded.copy(), self.viscous.copy()
        for mesh in self.meshes:
            at, g = self.interface(mesh), mesh.law.gradient_at_rest()
            stiffness[np.ix_(at, at)] += mesh.law.stiffness * np.outer(g, g)
            damping[np.ix_(at, at)] += mesh.law.damping * np.outer(g, g)
        return stiffness, damping

    def bow_shape(self, shaft: ShaftSpec, angle: float) -> Array:
        """Give the stress-free nodal vector of one shaft, rotated by `angle`."""
        q = np.zeros(self.size)
        if shaft.bow is None or shaft.bow_slope is None:
            return q
        turn = np.exp(1j * angle)
        for j, x in enumerate(self.nodes[shaft.name]):
            i = self.offset[shaft.name] + 5 * j
            b, slope = shaft.bow(float(x)) * turn, shaft.bow_slope(float(x)) * turn
            q[i : i + 4] = b.real, b.imag, -slope.imag, slope.real
        return q

    @cached_property
    def turning_bows(self) -> list[TurningBow]:
        """Bows that turn with the twist."""
        bows: list[TurningBow] = []
        if not self.bow_torque:
            return bows
        for shaft in (s for s in self.shafts if s.bow is not None):
            shapes = [self.bow_shape(shaft, angle) for angle in (0.0, np.pi / 2)]
            start = self.offset[shaft.name]
            twist = np.zeros(self.size)
            for j, k in enumerate(self.elements[shaft.name]):
                ends = [b[start + 5 * j : start + 5 * j + 10] for b in shapes]
                strain = sum(end @ k @ end for end in ends)
                twist[[start + 5 * j + elements.T, start + 5 * j + 5 + elements.T]] += strain
            twist /= twist.sum()
            # the drive holds the rigid-body rotation
            rotation = np.zeros(self.size)
            for other in self.shafts:
                at = self.offset[other.name] + elements.T
                nodes = len(self.nodes[other.name])
                rotation[at : at + 5 * nodes : 5] = other.ratio / shaft.ratio
            momentum = self.mass @ rotation
            twist -= momentum / (momentum @ rotation)
            bows.append(TurningBow(shaft.ratio, *(self.elastic @ b for b in shapes), twist))
        return bows

    def twisted_bow(self, angle: float, q: Array) -> Array:
        """Give what the twist adds to the bow forces at an angle of the reference shaft."""
        force = np.zeros(self.size)
        for bow in self.turning_bows:
            before = bow.ratio * angle
            after = before + bow.twist @ q
            force += (np.cos(after) - np.cos(before)) * bow.at_0
            force += (np.sin(after) - np.sin(before)) * bow.at_90
            force += (np.cos(after) * bow.at_90 - np.sin(after) * bow.at_0) @ q * bow.twist
        return force

    def steady_force(self) -> Array:
        """Give the forces of torques and gravity."""
        f = np.zeros(self.size)
        for at, value in self.torques:
            f[self.dof(*self.place(at), elements.T)] += value
        field_ = np.zeros(self.size)
        field_[elements.V :: 5], field_[elements.W :: 5] = self.gravity
        return f + self.mass @ field_

    def turning_force(self, speed: float) -> list[tuple[float, Array, Array]]:
        """Give per shaft the spin and the bow and unbalance force at the angles 0 and pi/2."""
        out = []
        for shaft in self.shafts:
            spin = shaft.ratio * speed
            parts = []
            for angle in (0.0, np.pi / 2):
                f = self.elastic @ self.bow_shape(shaft, angle)
                for body in (r for r in self.rigid if r.shaft == shaft.name):
                    push = body.unbalance * spin**2 * np.exp(1j * angle)
                    i = self.dof(body.shaft, body.position, 0)
                    f[i : i + 2] += push.real, push.imag
                parts.append(f)
            out.append((spin, parts[0], parts[1]))
        return out

    def synchronous(self, speed: float) -> list[NDArray[np.complex128]]:
        """Give per exciting shaft the amplitude Q of q(t) = Re[Q exp(i ratio_s speed t)]."""
        stiffness, damping = self.linear()
        out = []
        for spin, at_0, at_90 in self.turning_force(speed):
            dynamic = (
                stiffness - spin**2 * self.mass + 1j * spin * (damping + speed * self.gyroscopic)
            )
            out.append(np.linalg.lstsq(dynamic, at_0 - 1j * at_90, rcond=1e-14)[0])
        return out

    def eigenvalues(
        self, speed: float, lateral_only: bool = False, torsion_only: bool = False
    ) -> NDArray[np.complex128]:
        """Give the damped eigenvalues with positive imaginary part in ascending order."""
        stiffness, damping = self.linear()
        keep = np.arange(self.size)
        if lateral_only:
            keep = keep[keep % 5 != elements.T]
        if torsion_only:
            keep = keep[keep % 5 == elements.T]
        sub = np.ix_(keep, keep)
        m, k = self.mass[sub], stiffness[sub]
        c = damping[sub] + speed * self.gyroscopic[sub]
        scale = np.diag(1 / np.sqrt(np.diag(m)))
        m, k, c = scale @ m @ scale, scale @ k @ scale, scale @ c @ scale
        n = len(keep)
        state = np.block(
            [[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]]
        )
        values = np.linalg.eigvals(state)
        values = values[values.imag > 1e-3]
        return values[np.argsort(np.abs(values.imag))]

    def highest_frequency(self) -> float:
        stiffness, _ = self.linear()
        root = 1 / np.sqrt(np.diag(self.mass))
        m = self.mass * np.outer(root, root)
        k = stiffness * np.outer(root, root)
        low = np.linalg.cholesky(m)
        inverse = np.linalg.inv(low)
        return float(np.sqrt(np.linalg.eigvalsh(inverse @ k @ inverse.T)[-1]))
