"""What sensors have in common."""

import math
from abc import ABC, abstractmethod
from typing import ClassVar

from gearbow._shown import Shown
from gearbow._types import Array
from gearbow.recording.record import Recorded

__all__ = ["Sensor", "SignalSensor", "degrees_text"]


class Sensor(Shown, ABC):
    """A sensor, which measures a recorded motion."""

    @abstractmethod
    def measure(self, recording: Recorded) -> Array:
        """Measure a recorded motion."""


class SignalSensor(Sensor):
    """A sensor with one value for each recorded time."""

    #: Unit of the signal.
    unit: ClassVar[str]

    @property
    @abstractmethod
    def label(self) -> str:
        """Name of the signal in tables and figures."""


def degrees_text(angle: float) -> str:
    """Give an angle in degrees for a label."""
    return f"{math.degrees(angle):.4g}°"
