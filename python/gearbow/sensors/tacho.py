"""Tachometers: the times of the pulses of a shaft."""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import NDArray

from gearbow._convert import number, text, whole
from gearbow._times import crossings
from gearbow._types import Array
from gearbow.errors import SceneError
from gearbow.recording import access
from gearbow.recording.record import Recorded, RunRecord, recorded_run
from gearbow.sensors.sensor import Sensor


@dataclass(frozen=True)
class Tacho(Sensor):
    """A sensor of marks on a shaft, which gives one pulse for each mark that passes it.

    The times are exact: they are the roots of the angle of the shaft, not an interpolation of
    samples. With a position, the recorded twist there is part of the angle, between two samples as
    the cubic through their twists and twist rates.

    Parameters
    ----------
    shaft : str
        Name of the shaft.
    pulses : int
        Marks at equal angles around the shaft; the first is at the angle zero in the shaft.
    position : float, optional
        Position along the shaft [m], where the twist and its rate must be recorded. None leaves the
        twist out: the pulses are those of the prescribed rotation.
    angle : float
        Angular position of the sensor about the shaft, from y towards z [rad].

    Raises
    ------
    SceneError
        If the number of pulses is no positive whole number, or another number is not finite.

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> run_up = gb.SpeedProfile.ramp(0.0, 20.0, duration=2.0)
    >>> response = system.simulate(2.0, run_up)
    >>> response.measure(gb.Tacho("rotor")).round(6)
    array([0.      , 1.120998, 1.585331, 1.941626])
    """

    shaft: str
    pulses: int = 1
    _: KW_ONLY
    position: float | None = None
    angle: float = 0.0

    def __post_init__(self) -> None:
        text(self.shaft, "tacho.shaft")
        object.__setattr__(self, "pulses", whole(self.pulses, "tacho.pulses"))
        if self.position is not None:
            object.__setattr__(self, "position", number(self.position, "tacho.position"))
        object.__setattr__(self, "angle", number(self.angle, "tacho.angle"))

    def measure(self, recording: Recorded) -> Array:
        """Find the times of the pulses of a recorded run.

        Parameters
        ----------
        recording : Response
            The recorded run.

        Returns
        -------
        ndarray, shape (n,)
            Times of the pulses from the first recorded time up to the last one, ascending [s].

        Raises
        ------
        ChannelError
            If there is no such shaft, or the twist or its rate was not recorded.
        SceneError
            If the recorded times do not ascend, which the twist needs.
        """
        run = recorded_run(recording, "recording")
        if run.time.size == 0:
            return np.empty(0)
        nodes, angle, rate = self._rotation(run)
        spacing = 2.0 * np.pi / self.pulses
        return crossings(
            nodes, lambda t: (angle(t) - self.angle) / spacing, lambda t: rate(t) / spacing
        )

    def _rotation(
        self, run: RunRecord
    ) -> tuple[Array, Callable[[Array], Array], Callable[[Array], Array]]:
        """Give times between which the angle is monotone, and the angle and its rate over time."""
        # The speed of a run does not change its sign.
        nodes = np.unique([run.time.min(), run.time.max()])

        def angle(t: Array) -> Array:
            return access.angle(run, self.shaft, t)

        def rate(t: Array) -> Array:
            return access.spin(run, self.shaft, t)

        if self.position is None:
            return nodes, angle, rate
        place, time = (self.shaft, self.position), run.time
        if time.size > 1 and not np.diff(time).min() > 0.0:
            raise SceneError("tacho.position: the recorded times must ascend; leave position out")
        twist = access.motion(run, "twist", place)
        twist_rate = access.motion(run, "twist_rate", place)
        return (
            np.union1d(nodes, time),
            lambda t: angle(t) + _cubic(time, twist, twist_rate, t),
            lambda t: rate(t) + _cubic_rate(time, twist, twist_rate, t),
        )


def _cubic(time: Array, values: Array, rates: Array, t: Array) -> Array:
    """Interpolate samples by the cubics through their values and rates."""
    i, h, s = _interval(time, t)
    rise = s * s * (3.0 - 2.0 * s)
    bend = h * s * (1.0 - s)
    cubic: Array = (1.0 - rise) * values[i] + rise * values[i + 1]
    return cubic + bend * ((1.0 - s) * rates[i] - s * rates[i + 1])


def _cubic_rate(time: Array, values: Array, rates: Array, t: Array) -> Array:
    """Give the rate of `_cubic`."""
    i, h, s = _interval(time, t)
    slope: Array = 6.0 * s * (1.0 - s) * (values[i + 1] - values[i]) / h
    return slope + (1.0 - s) * (1.0 - 3.0 * s) * rates[i] + s * (3.0 * s - 2.0) * rates[i + 1]


def _interval(time: Array, t: Array) -> tuple[NDArray[np.intp], Array, Array]:
    """Give the index of the interval of each time, its length, and the fraction within it."""
    i = np.clip(np.searchsorted(time, t, side="right") - 1, 0, time.size - 2)
    h = time[i + 1] - time[i]
    return i, h, (t - time[i]) / h
