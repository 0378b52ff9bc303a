"""Bows in two forms: as input of the package, and as a curve with its slope."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import gearbow as gb

Curve = Callable[[float], complex]


@dataclass(frozen=True)
class HalfSine:
    """Give the bow amplitude * sin(pi x / L) at the angle `phase` in the shaft."""

    amplitude: float
    phase: float = 0.0

    def curve(self, length: float) -> Curve:
        return lambda x: self.amplitude * np.exp(1j * self.phase) * np.sin(np.pi * x / length)

    def slope(self, length: float) -> Curve:
        k = np.pi / length
        return lambda x: self.amplitude * np.exp(1j * self.phase) * k * np.cos(k * x)

    def package(self, _: float) -> gb.Bow:
        return gb.Bow.half_sine(self.amplitude, phase=self.phase)


@dataclass(frozen=True)
class Kinked:
    """Give a curve in both planes that is neither zero nor straight at the bearings."""

    amplitude: float
    phase: float = 0.0

    def curve(self, length: float) -> Curve:
        scale = self.amplitude * np.exp(1j * self.phase)
        return lambda x: scale * (np.cos(2 * x / length) + 0.5j * np.exp(-x / length))

    def slope(self, length: float) -> Curve:
        scale = self.amplitude * np.exp(1j * self.phase) / length
        return lambda x: scale * (-2 * np.sin(2 * x / length) - 0.5j * np.exp(-x / length))

    def package(self, length: float) -> gb.Bow:
        return gb.Bow.function(self.curve(length))
