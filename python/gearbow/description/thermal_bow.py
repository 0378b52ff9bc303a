"""A bow by the uneven heating of a journal."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gearbow._convert import positive
from gearbow._types import Array, At, ComplexArray
from gearbow.description.bow import Bow
from gearbow.description.part import Part, expect
from gearbow.description.places import place
from gearbow.description.sources import phasor


@dataclass(frozen=True)
class ThermalBow(Part):
    """A bow by the uneven heating of a journal, which its synchronous vibration causes.

    The side of a journal that is always nearest to the film or a seal becomes hotter than the
    other. The temperature difference T [K], a phasor that is fixed in the shaft, bends the shaft
    by b = B T and follows the vibration y at the journal slowly, τ dT/dt = g y - T.

    Parameters
    ----------
    at : str or tuple of (str, float)
        The journal, (shaft, position [m]), or a gear or disk by name.
    gain : complex or callable
        Temperature difference over the vibration, g [K/m]; its argument is the angle by which the
        hot spot is ahead of the high spot, in the direction of the shaft angle. A function has the
        speed of the shaft [rad/s] as its argument.
    time_constant : float
        Time constant τ of the temperature difference [s].
    shape : Bow
        Bow of the shaft at T = 1 K, with the hot spot along y.

    Raises
    ------
    SceneError
        If a value is invalid.

    Examples
    --------
    >>> import gearbow as gb
    >>> shape = gb.Bow.half_sine(1e-6)
    >>> gb.ThermalBow(("rotor", 0.1), gain=2e5 - 1e5j, time_constant=300.0, shape=shape).gain
    (200000-100000j)
    """

    at: At
    gain: complex | Callable[[float], complex]
    time_constant: float
    shape: Bow

    def __post_init__(self) -> None:
        place(self.at, "at", "place")
        positive(self.time_constant, "time_constant")
        expect(self.shape, Bow, "shape")
        if not callable(self.gain):
            phasor(self.gain, "gain")

    def _gains(self, speeds: Array) -> ComplexArray:
        """Give the gain [K/m] at speeds of the shaft [rad/s]."""
        gain = self.gain
        values = [gain(float(speed)) if callable(gain) else gain for speed in speeds]
        pairs = np.array([phasor(value, "gain") for value in values], dtype=float)
        found: ComplexArray = pairs.reshape(-1, 2) @ np.array([1.0, 1j])
        return found
