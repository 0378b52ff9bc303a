"""What harmonic responses have in common: phasors of the motion at places and of sensors."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np

from gearbow._core import Model
from gearbow._read_only import ReadOnly
from gearbow._result import Result
from gearbow._types import Array, At, ComplexArray, Plain
from gearbow.description.coordinates import Coordinates
from gearbow.description.places import Places
from gearbow.description.train import Train
from gearbow.errors import SceneError
from gearbow.results.at_places import Vibration
from gearbow.sensors.sensor import SignalSensor

#: Power of iω by which each kind of motion follows from the displacement.
DERIVATIVES = {"displacement": 0, "velocity": 1, "acceleration": 2}
#: Largest number of places in a table, and in a figure without names.
PRINTED_PLACES = 3


class HarmonicResponse(Result, ReadOnly, Vibration[ComplexArray, ComplexArray]):
    """Phasors x of a motion: each source contributes the real part of x exp(iωt)."""

    coordinates: Coordinates
    description: Mapping[str, Plain]
    _bearings: tuple[tuple[str, float], ...]
    _bearing_force: ComplexArray

    @property
    @abstractmethod
    def _motion(self) -> ComplexArray:
        """Displacement of each degree of freedom, shape (..., sources, n)."""

    @property
    @abstractmethod
    def _rates(self) -> Array:
        """Angular frequency of each source [rad/s], shape (..., sources) or (..., 1)."""

    def _model(self) -> Model:
        """Compile the system again: a result is plain data, without the compiled model."""
        return Model(dict(self.description))

    def axial_displacement(self, at: At) -> ComplexArray:
        """Axial displacement of a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            Place, as for `displacement`.

        Returns
        -------
        ndarray, shape (...,)
            Phasors [m].

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no axial motion.
        """
        return self._at("axial", at)

    def measure(self, sensor: SignalSensor) -> ComplexArray:
        """Signal of a sensor.

        Parameters
        ----------
        sensor : Probe or Accelerometer
            The sensor. Its run-out, a complex number, has a part in the synchronous response to its
            own shaft, and none in the response to another source.

        Returns
        -------
        ndarray, shape (...,)
            Phasors in the unit of the sensor.

        Raises
        ------
        SceneError
            If the sensor gives no signal, as a tachometer.
        GearbowError
            If the system has no such place, or not the motion that the sensor measures.
        """
        if not isinstance(sensor, SignalSensor):
            raise SceneError(f"sensor: must be a gb.Probe or gb.Accelerometer, got {sensor!r}")
        return self._signal(sensor)

    def _signal(self, sensor: Any) -> ComplexArray:
        """Give the phasors of the signal of a sensor."""
        signal: ComplexArray = sensor._sensed(self._at)
        return signal

    def _at(self, quantity: str, at: Any) -> ComplexArray:
        found: ComplexArray
        if quantity == "bearing_force":
            i = Places.of("bearing", self._bearings).index(at)
            found = self._bearing_force[..., 2 * i : 2 * i + 2]
        elif quantity == "bearing_displacement":
            found = self._in_bearing(at)
        elif quantity == "twist":
            found = self.coordinates.twisted(self._motion, at)
        elif quantity.startswith("axial"):
            kind = quantity.removeprefix("axial").removeprefix("_") or "displacement"
            found = self.coordinates.axial_displacement(self._motion, at)
            found = self._derived(found, self._rates, kind)
        else:
            found = self.coordinates.displacement(self._motion, at)
            found = self._derived(found, self._rates[..., None], quantity)
        return found

    @staticmethod
    def _derived(phasors: ComplexArray, rates: Array, quantity: str) -> ComplexArray:
        """Multiply displacements by the power of iω."""
        power = DERIVATIVES[quantity]
        return phasors * (1j * rates) ** power if power else phasors

    def _in_bearing(self, at: Any) -> ComplexArray:
        """Give the displacement of a shaft relative to what its bearing stands on."""
        shaft, x = self._bearings[Places.of("bearing", self._bearings).index(at)]
        moved: ComplexArray = self.coordinates.displacement(self._motion, (shaft, x))
        bearings = self.description["bearings"]
        number = Places.of("bearing", [(b["shaft"], b["position"]) for b in bearings]).index(at)
        base = bearings[number].get("support")
        if base is None:
            return moved
        if isinstance(base, Mapping):
            base = base.get("name") or f"bearings[{number}].support"
        housings = {each["name"]: each for each in self.description.get("housings", ())}
        if isinstance(base, str) and base in housings:
            train = Train.of(self.description, self._model().speed_ratios)
            foot = train.layout.shaft(shaft).origin + np.array([x, 0.0, 0.0])
            arm = foot - housings[base].get("position", [0.0, 0.0, 0.0])
            below = self.coordinates.of_point(self._motion, base, arm)
        else:
            node = (base, 0.0) if isinstance(base, str) else tuple(base)
            below = self.coordinates.displacement(self._motion, node)
        relative: ComplexArray = moved - below
        return relative
