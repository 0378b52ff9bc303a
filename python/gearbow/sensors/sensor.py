"""What sensors have in common."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, TypeAlias

from gearbow._shown import Shown
from gearbow._types import Array, At
from gearbow.recording.record import Recorded

#: A quantity ("displacement", "axial_acceleration", …) of the motion of a place: over time, or its
#: phasors.
Motion: TypeAlias = Callable[[Any, At], Any]


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

    @abstractmethod
    def _sensed(self, motion: Motion) -> Any:
        """Give the part of the signal that is linear in the motion."""


def degrees_text(angle: float) -> str:
    """Give an angle in degrees for a label."""
    return f"{math.degrees(angle):.4g}°"
