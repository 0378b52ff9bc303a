"""Closed form of the receptance of a uniform Rayleigh beam with springs at its ends.

Equation with a force F e^{iωt} that acts at x₀ (Bishop and Johnson, The Mechanics of Vibration, 1960, chapter 7, with rotary
inertia): EI u'''' + ρI ω'² u'' − ρA ω² u = F δ(x − x₀). In a beam that turns with Ω the forward coordinate u = v + iw has
ω'² = ω² − 2ωΩ. Rayleigh damping αM + βK makes EI and the inertia complex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Beam:
    """A beam on springs against displacement and slope at both ends."""

    length: float = 1.2
    diameter: float = 0.06
    youngs_modulus: float = 207e9
    density: float = 7850.0
    rayleigh: tuple[float, float] = (0.0, 0.0)
    #: Stiffness against displacement [N/m] and against the slope [N m/rad] at the left and the right end.
    springs: tuple[tuple[float, float], tuple[float, float]] = ((0.0, 0.0), (0.0, 0.0))
    #: Spin [rad/s].
    spin: float = 0.0

    def receptance(self, at: float, force_at: float, frequency: float) -> complex:
        """Return u(at)/F for a force at `force_at` that rotates with `frequency`."""
        w, (alpha, beta) = frequency, self.rayleigh
        area = np.pi * self.diameter**2 / 4.0
        second = np.pi * self.diameter**4 / 64.0
        stiffness = self.youngs_modulus * second * (1.0 + 1j * w * beta)
        mass = self.density * area * (w**2 - 1j * w * alpha)
        rotary = self.density * second * (w**2 - 2.0 * w * self.spin - 1j * w * alpha)
        squares = np.roots([stiffness, rotary, -mass]).astype(complex)
        k = np.concatenate([np.sqrt(squares), -np.sqrt(squares)])
        # Every exponential is one at one end of its part, so that none is large.
        ends = [(0.0, force_at), (force_at, self.length)]

        def values(part: int, x: float, order: int) -> np.ndarray:
            start, end = ends[part]
            origin = np.where(k.real > 0.0, end, start)
            return k**order * np.exp(k * (x - origin))

        rows, right = [], []

        def add(first: np.ndarray, second: np.ndarray, value: complex = 0.0) -> None:
            row = np.concatenate([first, second])
            scale = np.abs(row).max()
            rows.append(row / scale)
            right.append(value / scale)

        none = np.zeros(4, dtype=complex)
        for part, x, sign, (lateral, tilting) in (
            (0, 0.0, 1.0, self.springs[0]),
            (1, self.length, -1.0, self.springs[1]),
        ):
            u, slope, curvature, third = (values(part, x, order) for order in range(4))
            # Force and moment of the springs on the end of the beam.
            for condition in (
                sign * (stiffness * third + rotary * slope) + lateral * u,
                sign * stiffness * curvature - tilting * slope,
            ):
                add(*((condition, none) if part == 0 else (none, condition)))
        for order, jump in ((0, 0.0), (1, 0.0), (2, 0.0), (3, 1.0 / stiffness)):
            add(-values(0, force_at, order), values(1, force_at, order), jump)
        found = np.linalg.solve(np.array(rows), np.array(right))
        part = 0 if at <= force_at else 1
        return complex(values(part, at, 0) @ found[4 * part : 4 * part + 4])
