"""Linear analyses of a scene as a careful user would write them with the sparse solvers of SciPy.

The matrices come from gearbow. Modes are those of `programs.pencil`. SuperLU solves linear systems.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import eigsh, splu

import gearbow as gb
from programs.dense import Pair, bow_force, torques
from programs.pencil import SHIFT, Complex, Pencil
from programs.scenes import Array, bodies


class Sparse:
    """Matrices and loads of a system with meshes linearised at rest.

    Parameters
    ----------
    system : RotorSystem
        A system with bows and unbalances, without modal damping.
    speed : float
        Speed of the reference shaft that determines the flanks in contact [rad/s].
    """

    def __init__(self, system: gb.RotorSystem, speed: float) -> None:
        matrices = system.matrices(speed)
        self.mass, self.stiffness = csc_matrix(matrices.mass), csc_matrix(matrices.stiffness)
        self.damping, self.gyroscopic = (
            csc_matrix(matrices.damping),
            csc_matrix(matrices.gyroscopic),
        )
        self.index = {dof: i for i, dof in enumerate(system.dofs)}
        self.n = len(self.index)
        self.system, self.speed = system, speed
        self.ratios = [float(ratio) for ratio in system.speed_ratios]
        self.bows = [bow_force(shaft, self.index) for shaft in system.shafts]
        self.unbalances = [self._unbalance(shaft.name) for shaft in system.shafts]

    def _unbalance(self, shaft: str) -> Complex:
        """Return the unbalance of a shaft, the force divided by the square of its speed."""
        force = np.zeros(self.n, dtype=complex)
        for part in bodies(self.system):
            if part.shaft == shaft:
                force[self.index[shaft, part.position, "v"]] += part.unbalance
                force[self.index[shaft, part.position, "w"]] -= 1j * part.unbalance
        return force

    def pencil(self, speed: float) -> Pencil:
        """Return the equation of motion at a speed."""
        return Pencil(self.mass, self.damping + speed * self.gyroscopic, self.stiffness)

    def frequencies(self, speed: float, count: int) -> Array:
        """Return the positive frequencies [Hz], ascending; `count` eigenvalues are computed."""
        return positive(self.pencil(speed).eigenvalues(count)[0])

    def exact_frequencies(self, speed: float, count: int) -> Array:
        """Return the lowest frequencies [Hz], refined by inverse iteration with their own shift."""
        pencil = self.pencil(speed)
        values, vectors = pencil.eigenvalues(4 * count + 12)
        kept = [i for i in np.argsort(values.imag) if values[i].imag > 1.0][: count + 2]
        refined = [pencil.refined(values[i], vectors[:, i], 2)[0] for i in kept]
        return positive(np.array(refined))[:count]

    def forces(self, speed: float) -> Iterator[tuple[int, float, Complex]]:
        """Yield index, speed [rad/s] and force of each shaft with bow or unbalance."""
        rows = zip(self.ratios, self.bows, self.unbalances, strict=True)
        for shaft, (ratio, bow, unbalance) in enumerate(rows):
            omega = ratio * speed
            force = bow + omega**2 * unbalance
            if force.any():
                yield shaft, omega, force

    def responses(self, speeds: Sequence[float], refinements: int = 0) -> Complex:
        """Return the response to bow and unbalance (speeds, shafts as sources, n)."""
        found = np.zeros((len(speeds), len(self.ratios), self.n), dtype=complex)
        for i, speed in enumerate(speeds):
            damping = self.damping + speed * self.gyroscopic
            for j, omega, force in self.forces(speed):
                dynamic = csc_matrix(self.stiffness - omega**2 * self.mass + 1j * omega * damping)
                factors = splu(dynamic)
                found[i, j] = factors.solve(force)
                for _ in range(refinements):
                    found[i, j] += factors.solve(residual(dynamic, found[i, j], force))
        return found

    def frequency_response(
        self, frequencies: Array, place: tuple[str, float], refinements: int = 0
    ) -> Complex:
        """Return the response (frequencies, n) to a unit force along y of the order 1."""
        force = np.zeros(self.n, dtype=complex)
        shaft, position = place
        force[self.index[shaft, position, "v"]] = 1.0
        found = np.zeros((len(frequencies), self.n), dtype=complex)
        for i, omega in enumerate(frequencies):
            damping = self.damping + omega * self.gyroscopic
            dynamic = csc_matrix(self.stiffness - omega**2 * self.mass + 1j * omega * damping)
            factors = splu(dynamic)
            found[i] = factors.solve(force)
            for _ in range(refinements):
                found[i] += factors.solve(residual(dynamic, found[i], force))
        return found

    def modally_damped(self, speeds: Sequence[float], ratio: float, count: int) -> Complex:
        """Return the same with modal damping on the lowest `count` undamped modes."""
        modal = modal_damping(self.stiffness, self.mass, ratio, count)
        found = np.zeros((len(speeds), len(self.ratios), self.n), dtype=complex)
        for i, speed in enumerate(speeds):
            damping = self.damping + speed * self.gyroscopic
            pencil = Pencil(self.mass, damping, self.stiffness, *modal, ratio=ratio)
            for j, omega, force in self.forces(speed):
                found[i, j] = pencil.inverse(1j * omega)(force)
        return found

    def static(self, tolerance: float, *, extended: bool = False) -> Array:
        """Return the equilibrium under the torques with live meshes, by a simplified Newton method.

        Balanced torques leave the rigid-body rotation free: a spring fixes the first twist.
        """
        force = torques(self.system, self.index)
        alone, pairs = self.stiffness.tolil(), []
        for mesh in self.system.meshes:
            pair = Pair(self.system, mesh, self.speed)
            alone[np.ix_(pair.at, pair.at)] -= pair.mean * np.outer(pair.rest, pair.rest)
            pairs.append(pair)
        first = next(i for dof, i in self.index.items() if dof[2] == "twist")
        fixed = self.stiffness.tolil()
        fixed[first, first] *= 2.0
        factors, without = splu(csc_matrix(fixed)), csr_matrix(alone)
        found, still = np.zeros(self.n), [0.0] * 6
        while True:
            load = force.copy()
            for pair in pairs:
                load[pair.at] -= pair.live(found[pair.at].tolist(), still)
            missing = residual(without, found, load) if extended else load - without @ found
            change = factors.solve(missing)
            found += change
            if np.linalg.norm(change) <= tolerance * np.linalg.norm(found):
                return found


def modal_damping(stiffness: Any, mass: Any, ratio: float, count: int) -> tuple[Array, Array]:
    """Return M φ (n, m) and 2ζω (m,) of the lowest `count` undamped modes but rigid-body ones.

    The frequencies ascend.
    """
    squares, shapes = eigsh(csc_matrix(stiffness), count, mass, sigma=-(SHIFT**2))
    elastic = [i for i in np.argsort(squares) if squares[i] > SHIFT]
    return mass @ shapes[:, elastic], 2.0 * ratio * np.sqrt(squares[elastic])


def positive(values: Complex) -> Array:
    """Return the frequencies [Hz] of the eigenvalues with positive imaginary part, ascending."""
    frequencies: Array = np.sort(values.imag[values.imag > 1.0]) / (2.0 * np.pi)
    return frequencies


def residual(matrix: csc_matrix | csr_matrix, x: Any, force: Any) -> Any:
    """Return force − matrix·x in the precision of `force`, computed with extended precision."""
    rows = csr_matrix(matrix)
    extended = np.result_type(force.dtype, np.longdouble)
    products = rows.data.astype(extended) * x.astype(extended)[rows.indices]
    sums = np.add.reduceat(products, rows.indptr[:-1])
    return (force.astype(extended) - sums).astype(force.dtype)
