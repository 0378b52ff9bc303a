"""Derivatives of harmonic responses and of the static equilibrium with respect to parameters."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np

from gearbow._convert import shown
from gearbow._core import Model, harmonic_forms
from gearbow._lookup import one_of
from gearbow._types import Array, ComplexArray, Plain
from gearbow.analysis.protocol import System
from gearbow.description.coordinates import Coordinates
from gearbow.description.parameter import Parameter
from gearbow.description.places import Places, is_pair, place, place_label
from gearbow.errors import ChannelError, SceneError
from gearbow.results.frequency_response import FrequencyResponse
from gearbow.results.response_sensitivity import ResponseSensitivity
from gearbow.results.static import Static
from gearbow.results.synchronous import Synchronous
from gearbow.sensors.sensor import SignalSensor
from gearbow.system.parameter_family import ParameterFamily, extrapolated

__all__ = ["of_equilibrium", "of_harmonic", "of_synchronous"]

#: Round-off of differences over the sum of absolute elastic terms, relative to that over a result.
_ROUND_OFF_OF_TERMS = 1e-3
#: Number of motions that judge differences.
_JUDGED = 50
#: Unit, and number of derivatives with respect to time, of a quantity at a place.
_QUANTITIES = {
    "displacement": ("m", 0),
    "velocity": ("m/s", 1),
    "acceleration": ("m/s²", 2),
    "twist": ("rad", 0),
    "axial_displacement": ("m", 0),
    "bearing_force": ("N", 0),
}
#: Integrations from the quantity of a motion of the ground to its displacement.
_INTEGRATIONS = {"displacement": 0, "velocity": 1, "acceleration": 2}


@dataclass(frozen=True)
class _Signal:
    """What is differentiated: a place with a quantity, a mesh or a sensor."""

    at: Any
    quantity: str
    label: str
    unit: str
    components: tuple[str, ...]

    @classmethod
    def of(cls, at: Any, quantity: str, known: Sequence[str]) -> "_Signal":
        """Check a place, mesh or sensor."""
        one_of(quantity, known, "quantity")
        if isinstance(at, SignalSensor):
            if quantity != "displacement":
                raise SceneError(f"quantity: a sensor has its own signal, got {shown(quantity)}")
            return cls(at, "sensor", at.label, at.unit, ("",))
        found = place(at)
        if is_pair(found):
            if quantity != "displacement":
                raise SceneError(f"quantity: a mesh has its force only, got {shown(quantity)}")
            return cls(found, "mesh", f"mesh {'/'.join(found)}", "N", ("",))
        lateral = quantity not in ("twist", "axial_displacement")
        name = "" if quantity == "displacement" else f" {quantity.replace('_', ' ')}"
        label = f"{place_label(found)}{name}"
        return cls(
            found, quantity, label, _QUANTITIES[quantity][0], ("y", "z") if lateral else ("",)
        )

    @property
    def kind(self) -> str:
        """Whether it is the force of a mesh or a bearing, or a motion."""
        return {"mesh": "mesh", "bearing_force": "bearing"}.get(self.quantity, "motion")

    def index(self, known: Sequence[Any]) -> int:
        """Find the number of a bearing or mesh among those of a result."""
        kind = self.kind
        places = Places(kind, ([tuple(each)] for each in known))
        found = places.find(self.at)
        if found is None:
            raise ChannelError(f"at: no {kind} {shown(self.at)}; there are {places}")
        return found

    def derivatives(self) -> int:
        """Give the number of derivatives of the displacement with respect to time."""
        if self.quantity != "sensor":
            return _QUANTITIES.get(self.quantity, ("", 0))[1]
        asked: list[str] = []

        def of(quantity: str, _: Any) -> Array:
            asked.append(quantity)
            return np.zeros(2)

        self.at._sensed(of)
        return _QUANTITIES[asked[0].replace("axial_", "").replace("axial", "displacement")][1]

    def moved(self, coordinates: Coordinates, motion: Any) -> Any:
        """Give the displacements of which the signal consists, with its components last."""
        if self.quantity == "sensor":

            def of(quantity: str, at: Any) -> Any:
                if quantity.startswith("axial"):
                    return coordinates.axial_displacement(motion, at)
                return coordinates.displacement(motion, at)

            return self.at._sensed(of)[..., None]
        if self.quantity == "twist":
            return coordinates.twisted(motion, self.at)[..., None]
        if self.quantity == "axial_displacement":
            return coordinates.axial_displacement(motion, self.at)[..., None]
        return coordinates.displacement(motion, self.at)


@dataclass(frozen=True, eq=False)
class _Terms:
    """Entries of equations and outputs of harmonic motions, and the numbers of these motions."""

    keys: Any
    values: ComplexArray
    motions: Any
    width: int

    def __sub__(self, other: "_Terms") -> "_Terms":
        return self + -1.0 * other

    def __add__(self, other: "_Terms") -> "_Terms":
        if np.array_equal(self.keys, other.keys):
            return self._with(self.keys, self.values + other.values)
        keys = np.union1d(self.keys, other.keys)
        values = np.zeros((keys.size, self.values.shape[1]), dtype=np.complex128)
        for each in (self, other):
            values[np.searchsorted(keys, each.keys)] += each.values
        return self._with(keys, values)

    def __mul__(self, factor: float) -> "_Terms":
        return self._with(self.keys, self.values * factor)

    __rmul__ = __mul__

    def chosen(self, places: Any) -> "_Terms":
        """Leave out other entries."""
        return self._with(self.keys[places], self.values[places])

    def judged(self) -> "_Terms":
        """Keep some motions, which show how accurate differences of the entries are."""
        some = self.motions[:: 1 + self.motions.size // _JUDGED]
        return dataclasses.replace(self, motions=some)

    def _with(self, keys: Any, values: ComplexArray) -> "_Terms":
        return dataclasses.replace(self, keys=keys, values=values)


@dataclass(frozen=True, eq=False)
class _Harmonic:
    """Harmonic motions, k pairs of a frequency and a speed, with what excites and measures them."""

    family: ParameterFamily
    frequencies: Array
    speeds: Array
    sources: list[dict[str, Plain]]
    phasors: ComplexArray
    signal: _Signal
    #: Number of the bearing or mesh whose force is the signal.
    index: int

    def derivatives(self, parameters: Sequence[Parameter]) -> tuple[ComplexArray, ComplexArray]:
        """Give the signal (k, sources, components), and its derivatives (p, k, sources, ...)."""
        base = self.family.base
        outputs = self._outputs(base.coordinates)
        adjoint = base._model.harmonic_adjoint(self.frequencies, self.speeds, outputs)
        terms = self._terms(base._model, outputs)
        # At a node, the outputs do not depend on the elements.
        is_fixed = isinstance(outputs, tuple) or np.count_nonzero(outputs, axis=-1).max() <= 1
        none, size_of = np.zeros_like(adjoint), len(self.family.names)
        own_rows = [each.chosen(each.keys >= size_of * each.width) for each in terms]
        values: ComplexArray = np.sum([self._forms(each, none) for each in own_rows], axis=0)
        sizes = dataclasses.replace(self, phasors=np.abs(self.phasors).astype(np.complex128))
        stiffness = np.eye(1, 5, dtype=np.complex128)
        elastic = (
            each.judged()._with(each.keys, np.abs(each.values) * stiffness) for each in terms
        )
        own = np.abs(adjoint).astype(np.complex128)
        largest = max((float(np.max(np.abs(sizes._forms(e, own)))) for e in elastic), default=0.0)
        # The sum of absolute elastic terms has the round-off of a much larger response.
        largest *= _ROUND_OFF_OF_TERMS

        def size(change: _Terms) -> float:
            forms = self._forms(change.judged(), adjoint)
            return float(np.max(np.abs(forms), initial=0.0))

        slopes = np.zeros((len(parameters), *values.shape), dtype=np.complex128)
        for row, parameter in enumerate(parameters):

            def of(value: float, parameter: Parameter = parameter) -> list[Any]:
                model = self.family.model(parameter, value)
                own = outputs if is_fixed else self._outputs(self.family.coordinates(model))
                return self._terms(model, own, (base._model, outputs))

            for change in extrapolated(of, parameter.path, parameter.value, largest, size):
                slopes[row] -= self._forms(change, adjoint)
        return values, slopes

    def _outputs(self, coordinates: Coordinates) -> Any:
        """Give what the core calls outputs: factors of displacements, a bearing or a mesh."""
        if self.signal.kind != "motion":
            return self.signal.kind, self.index
        rows = self.signal.moved(coordinates, np.eye(len(coordinates.dofs)))
        return np.ascontiguousarray(np.moveaxis(rows, -1, 0), dtype=np.complex128)

    def _terms(
        self, model: Model, outputs: Any, base: tuple[Model, Any] | None = None
    ) -> list[_Terms]:
        """Assemble the entries, less those of a base, once for all motions or for each speed."""
        depends = model.depends_on_speed
        states = self.speeds if depends else np.sign(self.speeds)
        scale = float(np.max(np.abs(self.frequencies), initial=0.0)) or 1.0
        width = len(self.family.names) + max(len(self.sources), len(self.signal.components))
        found = []
        for state in np.unique(states):
            motions = np.flatnonzero(states == state)
            rows, columns, values = model.harmonic_terms(
                float(self.speeds[motions[0]]), scale, self.sources, outputs, base
            )
            found.append(_Terms(rows * width + columns, values, motions, width))
        return found

    def _forms(self, terms: _Terms, adjoint: ComplexArray) -> ComplexArray:
        """Evaluate (yᵀ, eᵀ) B (x, e) at the motions of the terms; it is zero at others."""
        acting = terms.values.any(axis=1)
        # A slice of all motions is no copy.
        own = slice(None) if terms.motions.size == self.frequencies.size else terms.motions
        harmonics = np.stack([self.frequencies[own], self.speeds[own]], axis=-1)
        rows, columns = np.divmod(terms.keys[acting], terms.width)
        integrations = [_INTEGRATIONS.get(str(each.get("quantity")), 0) for each in self.sources]
        forms = harmonic_forms(
            harmonics,
            (rows, columns, np.ascontiguousarray(terms.values[acting])),
            adjoint[own],
            self.phasors[own],
            integrations,
        )
        rate = (1j * harmonics[:, 0]) ** self.signal.derivatives()
        found = np.zeros(
            (self.frequencies.size, len(self.sources), adjoint.shape[1]), dtype=np.complex128
        )
        found[own] = np.swapaxes(forms * rate[:, None, None], 1, 2)
        return found


def of_harmonic(
    family: ParameterFamily,
    parameters: Sequence[Parameter],
    of: FrequencyResponse,
    at: Any,
    quantity: str,
) -> ResponseSensitivity:
    """Give the derivatives of a signal of a frequency response."""
    _require_own(family, of.description)
    signal = _Signal.of(at, quantity, tuple(_QUANTITIES))
    shape = of.frequencies.shape
    motions = _Harmonic(
        family,
        of.frequencies.ravel(),
        of.speeds.ravel(),
        of._sources,
        of.phasors.reshape(-1, *of.phasors.shape[-2:]),
        signal,
        _index(signal, family.origin, of._bearings),
    )
    values, slopes = motions.derivatives(parameters)
    return _result(
        "frequency response",
        parameters,
        signal,
        values.reshape(shape + values.shape[1:]),
        slopes.reshape(slopes.shape[:1] + shape + slopes.shape[2:]),
        sources=of.sources,
        axes=of.axes,
        frequencies=of.frequencies,
        speeds=of.speeds,
        speed_unit=of.speed_unit,
    )


def of_synchronous(
    family: ParameterFamily,
    parameters: Sequence[Parameter],
    of: Synchronous,
    at: Any,
    quantity: str,
) -> ResponseSensitivity:
    """Give the derivatives of a signal of a synchronous response: that of each shaft."""
    _require_own(family, of.description)
    if of.slow_roll is not None:
        raise SceneError("of: give the response before the subtraction of slow-roll amplitudes")
    signal = _Signal.of(at, quantity, tuple(_QUANTITIES))
    index = _index(signal, family.origin, of._bearings)
    parts = []
    for i, (shaft, ratio) in enumerate(zip(of.shafts, family.base.speed_ratios, strict=True)):
        source: dict[str, Plain] = {
            "kind": "shaft",
            "shaft": shaft,
            "excitation": of.excitation,
        }
        own = np.ascontiguousarray(of.amplitudes[:, i : i + 1])
        motions = _Harmonic(family, ratio * of.speeds, of.speeds, [source], own, signal, index)
        parts.append(motions.derivatives(parameters))
    return _result(
        "synchronous response",
        parameters,
        signal,
        np.concatenate([values for values, _ in parts], axis=1),
        np.concatenate([slopes for _, slopes in parts], axis=2),
        sources=tuple(f"shaft {shaft}" for shaft in of.shafts),
        axes=("speed",),
        frequencies=None,
        speeds=of.speeds,
        speed_unit=of.speed_unit,
    )


def of_equilibrium(
    family: ParameterFamily,
    parameters: Sequence[Parameter],
    of: Static,
    at: Any,
    quantity: str,
) -> ResponseSensitivity:
    """Give the derivatives of a signal of the static equilibrium."""
    known = ("displacement", "twist", "axial_displacement", "bearing_force")
    if isinstance(at, SignalSensor):
        raise SceneError(f"at: a sensor measures no equilibrium, got {shown(at)}")
    signal = _Signal.of(at, quantity, known)
    geometry, speed, state = of.geometry, of.speed, np.ascontiguousarray(of.state)
    base = family.base._model.static(geometry, speed)
    # The change of a scene moves an equilibrium much further than a repeated computation.
    if base["state"].shape != state.shape or not np.allclose(
        base["state"], state, rtol=1e-6, atol=1e-6 * np.max(np.abs(state), initial=0.0)
    ):
        raise SceneError("of: is no equilibrium of this system; give a result of this system")

    def signal_of(model: Model, moved: Array) -> Array:
        if signal.quantity == "mesh":
            data = model.static(geometry, speed, moved)
            return np.atleast_1d(data["mesh"]["force"][signal.index(data["meshes"])])
        if signal.quantity == "bearing_force":
            data = model.static(geometry, speed, moved)
            force: Array = data["bearing_force"][signal.index(data["bearings"])]
            return force
        found: Array = signal.moved(family.coordinates(model), moved)
        return found

    model = family.base._model
    values = signal_of(model, state)
    load = float(np.max(np.abs(model.static(geometry, speed, 0.0 * state)["unbalanced"])))
    largest = [load, float(np.max(np.abs(state), initial=0.0)), float(np.max(np.abs(values)))]
    slopes = np.zeros((len(parameters), values.size))
    for row, parameter in enumerate(parameters):

        @cache
        def varied(value: float, parameter: Parameter = parameter) -> Model:
            return family.model(parameter, value)

        def at_state(value: float, name: str, varied: Any = varied) -> list[Any]:
            return [varied(value).static(geometry, speed, state)[name]]

        path, value = parameter.path, parameter.value
        force, fixed = (
            -extrapolated(partial(at_state, name=name), path, value, size)[0]
            for name, size in zip(("unbalanced", "without_null_motions"), largest, strict=False)
        )
        # An equilibrium contains no null motion of its own system.
        change = model.static_changes(geometry, speed, state, force[None, :])[0] + fixed

        def along(other: float, varied: Any = varied, value: float = value, q: Any = change) -> Any:
            return [signal_of(varied(other), state + (other - value) * q)]

        slopes[row] = -extrapolated(along, path, value, largest[2])[0]
    return _result(
        "static equilibrium",
        parameters,
        signal,
        values[None, :],
        slopes[:, None, :],
        sources=("",),
        axes=(),
        frequencies=None,
        speeds=None,
        speed_unit=of.speed_unit,
    )


def _require_own(family: ParameterFamily, description: Any) -> None:
    if dict(description) != family.origin.description:
        raise SceneError("of: is no response of this system; give a result of this system")


def _index(signal: _Signal, system: System, bearings: Sequence[Any]) -> int:
    """Find the number of the bearing or mesh whose force is the signal."""
    meshes = [(mesh.driver, mesh.driven) for mesh in system.meshes]
    known = {"bearing": bearings, "mesh": meshes}.get(signal.kind)
    return -1 if known is None else signal.index(known)


def _result(
    kind: str,
    parameters: Sequence[Parameter],
    signal: _Signal,
    values: Any,
    derivatives: Any,
    **axes: Any,
) -> ResponseSensitivity:
    return ResponseSensitivity(
        kind=kind,
        parameters=tuple(each.path for each in parameters),
        parameter_values=np.array([each.value for each in parameters]),
        units=tuple(each.unit for each in parameters),
        label=signal.label,
        unit=signal.unit,
        components=signal.components,
        values=values,
        derivatives=derivatives,
        **axes,
    )
