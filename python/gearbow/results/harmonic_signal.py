"""What a Bode diagram shows of a place or a sensor: phase and amplitude over the speed."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._types import Array, At
from gearbow.description.places import place_label, places
from gearbow.errors import GearbowError
from gearbow.sensors.probe import Accelerometer, Probe
from gearbow.sensors.sensor import SignalSensor

if TYPE_CHECKING:
    from gearbow.results.synchronous import Synchronous

__all__ = ["HarmonicSignal", "harmonic_signals"]


@dataclass(frozen=True, eq=False)
class HarmonicSignal:
    """Phase [rad] and amplitude of what one shaft excites at a place or in a sensor."""

    label: str
    unit: str
    phase: Array
    amplitude: Array
    at: At | None
    source: str


def harmonic_signals(
    response: "Synchronous", given: Any, source: str | None
) -> list[HarmonicSignal]:
    """Give the signals of places and sensors; a place on no shaft has one for each shaft."""
    if isinstance(given, SignalSensor):
        given = [given]
    several = isinstance(given, list | tuple) and any(isinstance(x, SignalSensor) for x in given)
    chosen = list(given) if several else list(places(given))
    found = []
    for one in chosen:
        sensor = one if isinstance(one, SignalSensor) else None
        at = one if sensor is None else _place_of(sensor)
        label = place_label(one) if sensor is None else sensor.label
        shafts = response._sources(at, source)
        for shaft in shafts:
            number = response.shafts.index(shaft)
            if sensor is None:
                phase, amplitude = response.phase(one)[:, number], response.orbit(one)[:, number]
            else:
                values = _measured(response, sensor, number)
                phase = np.where(values == 0.0, np.nan, np.angle(values))
                amplitude = np.abs(values)
            if len(shafts) > 1 and not np.any(amplitude):
                continue
            name = f"{label}, excited by {shaft}" if len(shafts) > 1 else label
            unit = "m" if sensor is None else sensor.unit
            own = None if sensor is not None or len(shafts) > 1 else one
            found.append(HarmonicSignal(name, unit, phase, amplitude, own, shaft))
    if len({signal.unit for signal in found}) > 1:
        raise GearbowError("at: displacements and accelerations need a Bode diagram each")
    return found


def _place_of(sensor: SignalSensor) -> At:
    """Give the place of a sensor."""
    if isinstance(sensor, Probe):
        return (sensor.shaft, sensor.position)
    if isinstance(sensor, Accelerometer):
        return sensor.at
    raise GearbowError(f"at: must be a place, a Probe or an Accelerometer, got {sensor!r}")


def _measured(response: "Synchronous", sensor: Any, source: int) -> Any:
    """Give the complex amplitudes of the signal of a sensor, shape (speeds,)."""
    at = _place_of(sensor)
    coordinates, amplitudes = response.coordinates, response.amplitudes[:, source]
    direction = np.array([np.cos(sensor.angle), np.sin(sensor.angle)])

    def along(place: At) -> Any:
        if sensor.axial:
            return coordinates.axial_displacement(amplitudes, place)
        return coordinates.displacement(amplitudes, place) @ direction

    moved = along(at)
    if isinstance(sensor, Accelerometer):
        ratio = float(response._model().speed_ratios[source])
        return -((ratio * response.speeds) ** 2) * moved
    if sensor.support is not None:
        moved = moved - along(sensor.support)
    if sensor.runout is not None and response.shafts[source] == sensor.shaft:
        if not isinstance(sensor.runout, complex | float | int):
            raise GearbowError(
                "at: a Bode diagram needs the run-out of a probe as a complex number, because it "
                "shows what repeats once per revolution"
            )
        moved = moved + sensor.runout * np.exp(-1j * sensor.angle)
    return moved
