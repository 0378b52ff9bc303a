"""Proximity probes, which measure the displacement of the surface of a shaft; accelerometers."""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, complex_number, number, text, truth
from gearbow._types import Array, At
from gearbow.description.places import place, place_label
from gearbow.errors import SceneError
from gearbow.recording.access import Quantity, angle, motion
from gearbow.recording.record import Recorded, recorded_run
from gearbow.sensors.sensor import Motion, SignalSensor, degrees_text
from gearbow.units.values import is_quantity, magnitude

#: Run-out over the angle in the shaft: once per revolution, a function, or (angles, values).
RunOut: TypeAlias = complex | Callable[[Any], Any] | tuple[ArrayLike, ArrayLike]


@dataclass(frozen=True, eq=False)
class Probe(SignalSensor):
    """A proximity probe beside a shaft.

    It measures the displacement of the shaft towards the probe, plus the run-out of the surface
    that passes below it. Displacements contain the bow of the shaft.

    Parameters
    ----------
    shaft : str
        Name of the shaft.
    position : float
        Position along the shaft [m]. The motion there must be recorded.
    angle : float
        Angular position of the probe about the shaft, from y towards z [rad].
    runout : complex, callable or tuple of (array_like, array_like), optional
        Deviation of the surface from a circle about the axis of the shaft [m], positive outwards,
        over the angle in the shaft [rad]; electrical run-out included. A complex number is an
        eccentricity with its angle in the shaft; a callable takes an array of angles; (angles,
        values) are interpolated linearly around the circumference. None is no run-out.
    support : str, optional
        Name of the support, housing or point of a housing on which the probe stands. Its
        displacement is subtracted and must be recorded. None is the ground.
    axial : bool
        Whether it measures the axial displacement of the shaft, along +x, on a collar instead. The
        run-out is then that of the face of the collar, positive along +x.

    Raises
    ------
    SceneError
        If a number is not finite, or the run-out is none of these forms.

    Examples
    --------
    >>> import gearbow as gb
    >>> probe = gb.Probe("input", position=0.3, angle=0.8, runout=5e-6j)
    >>> probe.label
    'probe input at 0.3 m, 45.84°'
    """

    shaft: str
    position: float
    _: KW_ONLY
    angle: float = 0.0
    runout: RunOut | None = None
    support: str | None = None
    axial: bool = False

    unit: ClassVar[str] = "m"

    def __post_init__(self) -> None:
        text(self.shaft, "probe.shaft")
        truth(self.axial, "probe.axial")
        for name in ("position", "angle"):
            object.__setattr__(self, name, number(getattr(self, name), f"probe.{name}"))
        if self.support is not None:
            text(self.support, "probe.support")
        object.__setattr__(self, "runout", _converted(self.runout))
        self._runout(np.zeros(1))

    @property
    def label(self) -> str:
        """Name of the signal in tables and figures.

        Returns
        -------
        str
            Kind, place and direction.
        """
        axial = ", axial" if self.axial else ""
        return f"probe {self.shaft} at {self.position:g} m, {degrees_text(self.angle)}{axial}"

    def measure(self, recording: Recorded) -> Array:
        """Measure a recorded motion.

        Parameters
        ----------
        recording : Response
            The recorded run.

        Returns
        -------
        ndarray, shape (k,)
            Displacement towards the probe, or along +x, plus run-out [m].

        Raises
        ------
        ChannelError
            If a motion was not recorded; the message says what to record. If an axial probe
            measures a system without axial motion.
        SceneError
            If the function of the run-out gives no finite numbers.
        """
        run = recorded_run(recording, "recording")
        towards: Array = self._sensed(lambda quantity, at: motion(run, quantity, at))
        if self.runout is None:
            return towards
        twist = motion(run, "twist", (self.shaft, self.position))
        return towards + self._runout(self.angle - angle(run, self.shaft) - twist)

    def _sensed(self, motion: Motion) -> Any:
        quantity: Quantity = "axial" if self.axial else "displacement"
        moved = motion(quantity, (self.shaft, self.position))
        if self.support is not None:
            moved = moved - motion(quantity, self.support)
        direction = np.array([np.cos(self.angle), np.sin(self.angle)])
        return moved if self.axial else moved @ direction

    def _runout(self, angles: Array) -> Array:
        """Give the run-out at angles in the shaft."""
        given = self.runout
        if given is None:
            return np.zeros_like(angles)
        if callable(given):
            values = array(given(angles), "probe.runout")
            if values.shape != angles.shape:
                raise SceneError(
                    f"probe.runout: the function must give one number for each of "
                    f"{angles.size} angles, got {values.size}"
                )
            return values
        if isinstance(given, tuple):
            known, values = (np.asarray(part, dtype=np.float64) for part in given)
            return np.interp(angles, known, values, period=2.0 * np.pi)
        eccentric: Array = np.real(given * np.exp(-1j * angles))
        return eccentric


def _converted(given: Any) -> RunOut | None:
    """Convert a run-out: a function stays, and other forms become plain numbers."""
    if given is None or callable(given):
        return given  # type: ignore[no-any-return]  # one of the forms
    if isinstance(given, tuple | list):
        if len(given) != 2:
            raise SceneError(f"probe.runout: must be (angles, values), got {len(given)} items")
        known = array(given[0], "probe.runout.angle")
        values = array(given[1], "probe.runout")
        if known.shape != values.shape:
            raise SceneError(
                f"probe.runout: must have as many angles as values, got {known.size} and "
                f"{values.size}"
            )
        return known, values
    plain = magnitude(given, "probe.runout") if is_quantity(given) else given
    try:
        pair = np.ravel(complex_number(plain, "probe.runout"))
        amplitude = complex(*pair)
    except (SceneError, TypeError):
        amplitude = complex(np.nan)
    if not np.isfinite(amplitude):
        raise SceneError(
            "probe.runout: must be a finite complex number, a function or (angles, values), "
            f"got {given!r}"
        )
    return amplitude


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
