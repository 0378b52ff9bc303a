"""Accelerometers on supports, housings and shafts."""

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from gearbow._convert import number, truth
from gearbow._types import Array, At
from gearbow.description.places import place, place_label
from gearbow.errors import SceneError
from gearbow.recording.access import motion
from gearbow.recording.record import Recorded, recorded_run
from gearbow.sensors.sensor import Motion, SignalSensor, degrees_text


@dataclass(frozen=True)
class Accelerometer(SignalSensor):
    """An accelerometer, which measures the acceleration of a place in one direction.

    Parameters
    ----------
    at : str or tuple of (str, float)
        Name of a support, housing or point of a housing, of a gear or disk, or (shaft,
        position [m]), for example that of a bearing. Its acceleration must be recorded.
    angle : float
        Lateral direction, from y towards z [rad].
    axial : bool
        Whether it measures along +x instead.

    Raises
    ------
    SceneError
        If the place is invalid, the angle is not finite, or an axial sensor has an angle.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.Accelerometer("pedestal", angle=0.0).label
    'accelerometer pedestal, 0°'
    """

    at: At
    _: KW_ONLY
    angle: float = 0.0
    axial: bool = False

    unit: ClassVar[str] = "m/s²"

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", place(self.at, "accelerometer.at"))
        object.__setattr__(self, "angle", number(self.angle, "accelerometer.angle"))
        truth(self.axial, "accelerometer.axial")
        if self.axial and self.angle != 0.0:
            raise SceneError(
                f"accelerometer.angle: an axial accelerometer has none, got {self.angle}; "
                "leave out angle or axial"
            )

    @property
    def label(self) -> str:
        """Name of the signal in tables and figures.

        Returns
        -------
        str
            Kind, place and direction.
        """
        direction = "axial" if self.axial else degrees_text(self.angle)
        return f"accelerometer {place_label(self.at)}, {direction}"

    def measure(self, recording: Recorded) -> Array:
        """Measure a recorded motion.

        Parameters
        ----------
        recording : Response
            The recorded run.

        Returns
        -------
        ndarray, shape (k,)
            Acceleration in the direction of the sensor, without gravity [m/s²].

        Raises
        ------
        ChannelError
            If the acceleration was not recorded; the message says what to record. If an axial
            sensor measures a system without axial motion.
        """
        run = recorded_run(recording, "recording")
        measured: Array = self._sensed(lambda quantity, at: motion(run, quantity, at))
        return measured

    def _sensed(self, motion: Motion) -> Any:
        if self.axial:
            return motion("axial_acceleration", self.at)
        direction = np.array([np.cos(self.angle), np.sin(self.angle)])
        return motion("acceleration", self.at) @ direction
