"""One shaft on its lowest modes, as a careful user of SciPy would write it."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh

import gearbow as gb
from programs.scenes import Array, Scene


class FewModes:
    """Right-hand side over the amplitudes of modes and their rates, at a linearly changing speed.

    Parameters
    ----------
    scene : Scene
        One shaft with disks, unbalance and modal damping, and a ramp of the speed.
    count : int
        Number of modes.
    """

    def __init__(self, scene: Scene, count: int) -> None:
        system = scene.build()
        matrices = system.matrices()
        squares, shapes = eigh(matrices.stiffness, matrices.mass)
        lateral = [i for i in range(len(squares)) if self._is_lateral(matrices.dofs, shapes[:, i])]
        chosen = lateral[:count]
        modes = shapes[:, chosen]
        ratio = system.modal_damping or 0.0
        if not isinstance(ratio, float):
            raise TypeError("modal_damping: must be one ratio for this comparison")
        self.stiffness = squares[chosen]
        self.damping = 2.0 * ratio * np.sqrt(self.stiffness)
        self.gyroscopic = modes.T @ matrices.gyroscopic @ modes
        index = {dof: i for i, dof in enumerate(matrices.dofs)}
        self.rows = np.array(
            [[modes[index[shaft, x, d]] for d in ("v", "w")] for shaft, x in scene.points]
        )
        self.unbalance = sum(
            disk.unbalance
            * (
                modes[index[disk.shaft, disk.position, "v"]]
                - 1j * modes[index[disk.shaft, disk.position, "w"]]
            )
            for disk in system.disks
        )
        assert isinstance(scene.speed, gb.SpeedProfile)
        self.rate, self.speed = (float(value) for value in scene.speed.coefficients[-2:, 0])

    @staticmethod
    def _is_lateral(
        dofs: Sequence[tuple[str, float | tuple[float, float], str]], shape: Array
    ) -> bool:
        """Return whether a mode bends the shaft."""
        return dofs[int(np.argmax(np.abs(shape)))][2] != "twist"

    def __call__(self, t: float, y: Array) -> Array:
        """Return the rates."""
        q, v = np.split(y, 2)
        speed = self.speed + self.rate * t
        angle = t * (self.speed + self.rate * t / 2.0)
        turned = (speed**2 - 1j * self.rate) * np.exp(1j * angle)
        # Re(u e^{iϑ}) acts on v and Im(u e^{iϑ}) on w.
        force = np.real(self.unbalance * turned)
        inner = self.stiffness * q + self.damping * v + speed * (self.gyroscopic @ v)
        return np.concatenate([v, force - inner])

    def displacements(self, y: Array) -> Array:
        """Return the displacements (points, times, 2) of states (2·count, times)."""
        count = len(self.stiffness)
        return np.moveaxis(self.rows @ y[:count], 1, 2)
