"""What sensors have in common."""

import math
from abc import ABC, abstractmethod
from typing import ClassVar

from gearbow._convert import shown
from gearbow._shown import Shown
from gearbow._types import Array
from gearbow.errors import SceneError
from gearbow.recording.recording import Recording

__all__ = ["Sensor", "SignalSensor", "check_recording", "degrees_text"]


class Sensor(Shown, ABC):
    """A sensor, which measures a recorded motion."""

    @abstractmethod
    def measure(self, recording: Recording) -> Array:
        """Measure a recorded motion."""


class SignalSensor(Sensor):
    """A sensor with one value for each recorded time."""

    #: Unit of the signal.
    unit: ClassVar[str]

    @property
    @abstractmethod
    def label(self) -> str:
        """Name of the signal in tables and figures."""


def check_recording(recording: object) -> None:
    """Check that a sensor can measure this value."""
    if not isinstance(recording, Recording):
        raise SceneError(f"recording: must be a Response, got {shown(recording)}")


def degrees_text(angle: float) -> str:
    """Give an angle in degrees for a label."""
    return f"{math.degrees(angle):.4g}°"
