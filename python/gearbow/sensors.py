"""What sensors measure of a recorded run, such as probes, accelerometers and tachometers."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearbow._convert import (
    array,
    complex_number,
    items,
    number,
    one_of,
    positive,
    shown,
    text,
    truth,
    whole,
)
from gearbow._shown import Shown
from gearbow._times import crossings
from gearbow._types import Array, At
from gearbow.description.places import place, place_label
from gearbow.errors import SceneError
from gearbow.recording import access
from gearbow.recording.access import Quantity, angle, motion
from gearbow.recording.record import Recorded, RunRecord, recorded_run
from gearbow.units.fields import is_quantity, magnitude

#: What strain gauges measure.
GaugeQuantity: TypeAlias = Literal["torque", "bending"]
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

    def _measured(self, run: RunRecord) -> Array:
        """Give the signal of a recorded run."""
        measured: Array = self._sensed(lambda quantity, at: motion(run, quantity, at))
        return measured

    def measure(self, recording: Recorded) -> Array:
        """Measure a recorded motion.

        Parameters
        ----------
        recording : Response
            The recorded run.

        Returns
        -------
        ndarray, shape (k,)
            Signal at the recorded times, in the `unit` of the sensor: displacement towards a probe,
            or along +x, plus run-out [m]; acceleration without gravity [m/s²]; torque or bending
            moment [N m]; weighted forces of the meshes of a ring [N].

        Raises
        ------
        ChannelError
            If a motion or section forces were not recorded; the message says what to record. If an
            axial sensor measures a system without axial motion.
        """
        return self._measured(recorded_run(recording, "recording"))


def signal_sensors(given: object, path: str) -> list[SignalSensor]:
    """Check a list of sensors with a signal."""
    found = items(given, path, "sensors")
    for i, sensor in enumerate(found):
        if not isinstance(sensor, SignalSensor):
            raise SceneError(
                f"{path}[{i}]: must be a Probe, Accelerometer, StrainGauge or RingSensor, got "
                f"{shown(sensor)}"
            )
    return found


def degrees_text(angle: float) -> str:
    """Give an angle in degrees for a label."""
    return f"{math.degrees(angle):.4g}°"


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

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> response = system.simulate(2.0, gb.SpeedProfile.ramp(0.0, 20.0, duration=2.0))
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
    i, h, s = _interval(time, t)
    slope: Array = 6.0 * s * (1.0 - s) * (values[i + 1] - values[i]) / h
    return slope + (1.0 - s) * (1.0 - 3.0 * s) * rates[i] + s * (3.0 * s - 2.0) * rates[i + 1]


def _interval(time: Array, t: Array) -> tuple[NDArray[np.intp], Array, Array]:
    """Give the index of the interval of each time, its length, and the fraction within it."""
    i = np.clip(np.searchsorted(time, t, side="right") - 1, 0, time.size - 2)
    h = time[i + 1] - time[i]
    return i, h, (t - time[i]) / h


#: Run-out over the angle in the shaft: once per revolution, a function, or (angles, values).
RunOut: TypeAlias = "complex | Callable[[Any], Any] | tuple[ArrayLike, ArrayLike] | None"


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
    runout: RunOut = None
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
        """Name of the signal in tables and figures: kind, place and direction."""
        axial = ", axial" if self.axial else ""
        return f"probe {self.shaft} at {self.position:g} m, {degrees_text(self.angle)}{axial}"

    def _measured(self, run: RunRecord) -> Array:
        towards = super()._measured(run)
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


def _converted(given: Any) -> RunOut:
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
        """Name of the signal in tables and figures: kind, place and direction."""
        direction = "axial" if self.axial else degrees_text(self.angle)
        return f"accelerometer {place_label(self.at)}, {direction}"

    def _sensed(self, motion: Motion) -> Any:
        if self.axial:
            return motion("axial_acceleration", self.at)
        direction = np.array([np.cos(self.angle), np.sin(self.angle)])
        return motion("acceleration", self.at) @ direction


@dataclass(frozen=True)
class StrainGauge(SignalSensor):
    """Strain gauges on a turning shaft, calibrated in the torque or the bending moment there.

    Gauges of torque measure the torque in the section, those of bending the moment that stretches
    the fibre at their angle in the shaft: a force that stands still gives a signal once a turn, a
    bow that turns with the shaft a constant one.

    Parameters
    ----------
    at : str or tuple of (str, float)
        A gear or disk by name, or (shaft, position [m]); at a node, the section just before it. The
        section forces there must be recorded.
    quantity : {"torque", "bending"}
        What the gauges measure.
    angle : float
        Angle of the fibre in the shaft, from y towards z at shaft angle zero [rad]; 0 for torque.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.StrainGauge(("input", 0.1), "bending").label
    'strain gauge input at 0.1 m bending, 0°'
    """

    at: At
    quantity: GaugeQuantity = "torque"
    _: KW_ONLY
    angle: float = 0.0

    unit: ClassVar[str] = "N m"

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", place(self.at, "strain_gauge.at"))
        one_of(self.quantity, get_args(GaugeQuantity), "strain_gauge.quantity")
        object.__setattr__(self, "angle", number(self.angle, "strain_gauge.angle"))
        if self.quantity == "torque" and self.angle != 0.0:
            raise SceneError(
                f"strain_gauge.angle: gauges of torque have none, got {self.angle}; leave it out"
            )

    @property
    def label(self) -> str:
        """Name of the signal in tables and figures: kind, place and quantity."""
        direction = f", {degrees_text(self.angle)}" if self.quantity == "bending" else ""
        return f"strain gauge {place_label(self.at)} {self.quantity}{direction}"

    def _measured(self, run: RunRecord) -> Array:
        sections, forces = access.section_forces(run, self.at)
        values = forces[:, access.at_side(sections, "before")]
        if self.quantity == "torque":
            torque: Array = values[:, 5]
            return torque
        turned = np.exp(-1j * (access.angle(run, sections[0][0]) + self.angle))
        # A fibre is stretched by the moment about the axis that it lies to the right of.
        moment: Array = -np.imag((values[:, 3] + 1j * values[:, 4]) * turned)
        return moment

    def _sensed(self, motion: Motion) -> Any:
        if self.quantity == "bending":
            raise SceneError(
                "sensor: gauges of bending turn with the shaft, so that a harmonic motion has no "
                "phasor of their signal; measure a run, or gauges of torque"
            )
        return motion("torque", self.at)


@dataclass(frozen=True)
class RingSensor(SignalSensor):
    """A sensor at rest beside an internal gear, past which the carrier takes the planets.

    It measures the forces of the meshes of this gear with its planets, each with a weight w(β) that
    depends on the angle β between planet and sensor about the axis:
    w = cos²(πβ/(2 `width`)) within ±`width`, 0 elsewhere (Hann window). So each planet that passes
    modulates the signal. Multiply it by the acceleration at the sensor for a force of 1 N at the
    nearest teeth to get that of an accelerometer.

    Parameters
    ----------
    ring : str
        The internal gear. Its meshes must be recorded.
    angle : float
        Position of the sensor about the axis of the ring, from y towards z [rad].
    width : float, optional
        Angle between planet and sensor [rad] from which on the planet has no effect, at most π.
        None: π divided by the number of planets, so that the sensor sees one planet at a time.

    Raises
    ------
    SceneError
        If the name is no text, the angle is not finite, or the width is not above 0 and at most π.

    References
    ----------
    M. Inalpolat, A. Kahraman: A theoretical and experimental investigation of modulation sidebands
    of planetary gear sets. Journal of Sound and Vibration 323 (2009), 677-696.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.RingSensor("ring", angle=0.5).label
    'ring sensor ring, 28.65°'
    """

    ring: str
    _: KW_ONLY
    angle: float = 0.0
    width: float | None = None

    unit: ClassVar[str] = "N"

    def __post_init__(self) -> None:
        text(self.ring, "ring_sensor.ring")
        object.__setattr__(self, "angle", number(self.angle, "ring_sensor.angle"))
        if self.width is not None:
            width = positive(self.width, "ring_sensor.width")
            if width > math.pi:
                raise SceneError(f"ring_sensor.width: must be at most π rad, got {width}")
            object.__setattr__(self, "width", width)

    @property
    def label(self) -> str:
        """Name of the signal in tables and figures: kind, gear and position."""
        return f"ring sensor {self.ring}, {degrees_text(self.angle)}"

    def _measured(self, run: RunRecord) -> Array:
        planets = access.planets_of(run, self.ring)
        width = self.width or math.pi / len(planets)
        measured = np.zeros_like(run.time)
        for planet in planets:
            apart = planet.angle - self.angle
            # The nearer way around, so that |β| is at most π.
            apart -= 2.0 * np.pi * np.round(apart / (2.0 * np.pi))
            window = np.cos(0.5 * np.pi * apart / width) ** 2
            measured += np.where(np.abs(apart) < width, window * planet.force, 0.0)
        return measured

    def _sensed(self, _: Motion) -> Any:
        raise SceneError(
            "sensor: planets pass a sensor beside a ring, so that a harmonic motion has no phasor "
            "of its signal; measure a run"
        )
