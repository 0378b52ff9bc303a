"""Steps of a run whose torques and speed another program gives from step to step."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from gearbow._convert import items, nearest, number, positive, shown
from gearbow._result import Column
from gearbow._types import Accuracy, Record
from gearbow.analysis.protocol import System
from gearbow.description.loads import Torque
from gearbow.description.places import place, place_label
from gearbow.description.speed import SpeedProfile, plain_speed
from gearbow.description.time_series import TimeSeries
from gearbow.errors import AccuracyWarning, SceneError, SceneWarning
from gearbow.orders.spectrum import channel
from gearbow.recording import channels
from gearbow.results.response import Response
from gearbow.sensors import SignalSensor, signal_sensors

#: Steps after which the profile of the speed begins again, so that a step takes the same time after
#: any number of steps. The run then goes on from the state at this time, to within the tolerance.
_LONGEST_PROFILE = 64


@dataclass(frozen=True)
class Interface:
    """Inputs and outputs of a system that is stepped."""

    # Speed of the reference shaft at the beginning [rad/s].
    speed: float
    # Gears, disks or (shaft, position) with an input torque beside the torques of the system.
    torque_inputs: tuple[Any, ...] = ()
    # Smallest and largest value of an input speed [rad/s]; None keeps the speed.
    speed_input: tuple[float, float] | None = None
    # The other arguments of `simulate`.
    record: list[Record] | None = None
    sensors: tuple[SignalSensor, ...] = ()
    accuracy: Accuracy | None = None
    initial: str = "synchronous"

    @classmethod
    def of(
        cls,
        speed: object,
        torque_inputs: object,
        speed_input: object,
        record: object,
        sensors: object,
        **options: Any,
    ) -> "Interface":
        """Check the arguments of `RotorSystem.to_fmu`; a run checks places and options."""
        own = number(speed, "speed")
        places = items(torque_inputs, "torque_inputs", "places")
        found = tuple(place(at, f"torque_inputs[{i}]", "place") for i, at in enumerate(places))
        for i, at in enumerate(found):
            if at in found[:i]:
                raise SceneError(f"torque_inputs[{i}]: {shown(at)} is given twice")
        given = tuple(signal_sensors(sensors, "sensors"))
        recorded = None if record is None else items(record, "record", "names or tuples")
        limits = None if speed_input is None else _limits(speed_input, own)
        return cls(own, found, limits, recorded, given, **options)

    @property
    def inputs(self) -> dict[str, float]:
        """Names of the inputs and their values at the beginning [N m, rad/s]."""
        found = {f"torque {place_label(at)}": 0.0 for at in self.torque_inputs}
        return found if self.speed_input is None else {**found, "speed": self.speed}


def _limits(given: object, speed: float) -> tuple[float, float]:
    """Check smallest and largest speed of an input."""
    listed = items(given, "speed_input", "two speeds [rad/s]")
    if len(listed) != 2:
        raise SceneError(
            f"speed_input: must be the smallest and the largest speed [rad/s], got {shown(given)}"
        )
    low, high = (number(value, f"speed_input[{i}]") for i, value in enumerate(listed))
    if not (low < high and low * high >= 0.0):
        raise SceneError(
            "speed_input: must be two ascending speeds of one sign, because teeth keep their "
            f"flanks in a run, got {shown(given)}"
        )
    if not low <= speed <= high:
        raise SceneError(f"speed: must be within speed_input, {low:g} to {high:g}, got {speed:g}")
    return low, high


@dataclass(frozen=True)
class Knots:
    """Times [s], and the values of the inputs [N m, rad/s] that are reached at them."""

    times: list[float]
    torques: list[list[float]]
    speeds: list[float]

    def after(self, time: float, inputs: Sequence[float], speed: float) -> "Knots":
        """Add a time at which the inputs have the given values."""
        return Knots([*self.times, time], [*self.torques, list(inputs)], [*self.speeds, speed])

    def since(self, time: float) -> "Knots":
        """Leave out what lies before the last knot up to a time."""
        first = max([i for i, known in enumerate(self.times[:-1]) if known <= time], default=0)
        return Knots(self.times[first:], self.torques[first:], self.speeds[first:])


@dataclass(frozen=True)
class Instant:
    """All on which the following steps depend."""

    # Time [s], values of the inputs by name [N m, rad/s], and of the outputs [SI].
    time: float
    inputs: dict[str, float]
    outputs: list[float]
    # Final state of the run up to this time.
    final: dict[str, Any]
    # The inputs since the last whole step of the run, and since the profile of the speed began.
    torque_knots: Knots
    speed_knots: Knots


@dataclass
class CoSimulation:
    """A system that is stepped: every step is a run that continues the one before."""

    # An input is reached at the end of the step: a torque by a cubic without slope at both ends,
    # the speed linearly.
    system: System
    interface: Interface
    #: Names and units of the outputs, known from the beginning on.
    columns: list[Column] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self._now: Instant | None = None
        names = self.interface.inputs
        self._base = self._loaded(Knots([0.0, 1.0], [[0.0] * len(names)] * 2, []), changed=True)

    @property
    def now(self) -> Instant:
        """The present instant. It can be set to an earlier one."""
        if self._now is None:
            raise SceneError("begin: must be called before the first step")
        return self._now

    @now.setter
    def now(self, instant: Instant) -> None:
        self._now = instant

    def begin(self, time: float, inputs: Mapping[str, float] | None = None) -> None:
        """Begin at a time [s] with values of the inputs by name; the others are 0 or `speed`."""
        given = {**self.interface.inputs, **(inputs or {})}
        self._now = Instant(time, given, [], {}, *[Knots([], [], [])] * 2)
        self.set({})
        torques, speed = self._split(given)
        earlier = time - 1.0
        knots = Knots([earlier, time], [torques] * 2, [speed] * 2)
        self._run(time, 0.0, self.interface.initial, knots, knots)

    def set(self, inputs: Mapping[str, float]) -> None:
        """Set inputs by name, which the next step reaches at its end."""
        now = self.now
        for name, value in inputs.items():
            if name not in self.interface.inputs:
                known = list(self.interface.inputs)
                raise SceneError(
                    f"inputs: there is no {name!r}{nearest(name, known)}; there are {known}"
                )
            number(value, f"inputs[{name!r}]")
        self._now = replace(now, inputs={**now.inputs, **inputs})
        limits, speed = self.interface.speed_input, self._split(self._now.inputs)[1]
        if limits is not None and not limits[0] <= speed <= limits[1]:
            self._now = now
            raise SceneError(
                f"inputs['speed']: must be within speed_input, {limits[0]:g} to {limits[1]:g} "
                f"rad/s, got {speed:g}"
            )

    def step(self, duration: float) -> None:
        """Continue the run by a duration [s]. The instant is unchanged if the run fails."""
        now = self.now
        end = now.time + positive(duration, "step")
        torques, speed = self._split(now.inputs)
        speeds = now.speed_knots.after(end, [], speed)
        initial = dict(now.final)
        if len(speeds.times) > _LONGEST_PROFILE:
            speeds = Knots([now.time, end], [], speeds.speeds[-2:])
        elif self.interface.speed_input is not None:
            # The profile grows: up to now it is the one of the run that is continued.
            initial["speed"] = plain_speed(self._profile(speeds))
        whole = now.final["origin"] + now.final["elapsed"]
        with warnings.catch_warnings():
            # The first run has given the warnings about this system.
            warnings.simplefilter("ignore", SceneWarning)
            warnings.simplefilter("ignore", AccuracyWarning)
            self._run(
                now.time,
                duration,
                initial,
                now.torque_knots.after(end, torques, speed).since(whole),
                speeds,
            )

    def _run(
        self, time: float, duration: float, initial: Any, torques: Knots, speeds: Knots
    ) -> None:
        """Run to the end of a step, and keep what the next one needs."""
        face = self.interface
        varies = face.speed_input is not None
        response = self._loaded(torques).simulate(
            duration,
            self._profile(speeds) if varies else face.speed,
            initial=initial,
            start=time if isinstance(initial, str) else None,
            times=[time + duration],
            record=face.record,
            accuracy=face.accuracy,
        )
        self.columns = self._columns(response)
        self._now = replace(
            self.now,
            time=response.final["time"],
            outputs=[float(column.values[-1]) for column in self.columns],
            final=dict(response.final),
            torque_knots=torques,
            speed_knots=speeds if varies else Knots([], [], []),
        )

    def _columns(self, response: Response) -> list[Column]:
        """Give all outputs at the recorded time."""
        record = response._to_record()
        found = channels.series(record)[1:]
        for sensor in self.interface.sensors:
            signal = channel(record, sensor)
            found.append(Column(signal.label, signal.values, signal.unit))
        return found

    def _split(self, inputs: Mapping[str, float]) -> tuple[list[float], float]:
        """Give torques and speed of inputs by name."""
        values = [inputs[name] for name in self.interface.inputs if name != "speed"]
        return values, inputs.get("speed", self.interface.speed)

    def _loaded(self, knots: Knots, *, changed: bool = False) -> System:
        """Give the system with input torques; a `changed` one has elements for them."""
        if not self.interface.torque_inputs:
            return self.system
        flat = [0.0] * len(knots.times)
        added = [
            Torque(at, TimeSeries(knots.times, [row[i] for row in knots.torques], flat))
            for i, at in enumerate(self.interface.torque_inputs)
        ]
        torques = [*self.system.torques, *added]
        make = self.system.replace if changed else self._base._variation
        loaded: System = make(torques=torques)
        return loaded

    def _profile(self, knots: Knots) -> SpeedProfile:
        """Give the speed over time."""
        # Before the run it passes through the smallest and the largest speed: the linear motion of
        # a run is that of the middle of all speeds, and so is the same in all steps.
        low, high = self.interface.speed_input or (0.0, 0.0)
        first = knots.times[0]
        times = [first - 2.0, first - 1.0, *knots.times]
        return SpeedProfile.table(times, [low, high, *knots.speeds])
