"""Derivatives of harmonic responses and of the static equilibrium with respect to parameters."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np

from gearbow._convert import one_of, shown
from gearbow._core import Model
from gearbow._types import Array, ComplexArray, Plain
from gearbow.analysis.protocol import System
from gearbow.description.coordinates import Coordinates, time_derivatives
from gearbow.description.places import Places, is_pair, place, place_label
from gearbow.description.train import Parameter
from gearbow.errors import SceneError
from gearbow.results.frequency_response import FrequencyResponse
from gearbow.results.sensitivity import ResponseSensitivity
from gearbow.results.static import Static
from gearbow.results.synchronous import Synchronous
from gearbow.sensors import SignalSensor
from gearbow.system.parameter_family import (
    Motions,
    ParameterFamily,
    described,
    extrapolated,
    is_damped,
    require_memory_of,
)
from gearbow.units.fields import QUANTITIES

#: Round-off of differences over the sum of absolute elastic terms, relative to that over a result.
_ROUND_OFF_OF_TERMS = 1e-3


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
        components = ("y", "z") if lateral else ("",)
        return cls(found, quantity, label, QUANTITIES[quantity], components)

    @property
    def kind(self) -> str:
        """Whether it is the force of a mesh or a bearing, or a motion."""
        return {"mesh": "mesh", "bearing_force": "bearing"}.get(self.quantity, "motion")

    def index(self, known: Sequence[Any]) -> int:
        """Find the number of a bearing or mesh among those of a result."""
        return Places.of(self.kind, known).index(self.at)

    def derivatives(self) -> int:
        """Give the number of derivatives of the displacement with respect to time."""
        asked = [self.quantity]

        def of(quantity: str, _: Any) -> Array:
            asked[0] = quantity
            return np.zeros(2)

        if self.quantity == "sensor":
            self.at._sensed(of)
        return time_derivatives(asked[0])

    def moved(self, coordinates: Coordinates, motion: Any) -> Any:
        """Give the displacements of which the signal consists, with its components last."""
        if self.quantity == "sensor":
            return self.at._sensed(partial(coordinates.motion, motion))[..., None]
        found = coordinates.motion(motion, self.quantity, self.at)
        return found[..., None] if len(self.components) == 1 else found


def _harmonic(
    family: ParameterFamily,
    parameters: Sequence[Parameter],
    motions: tuple[Array, Array, list[dict[str, Plain]], ComplexArray],
    signal: _Signal,
    index: int,
) -> tuple[ComplexArray, ComplexArray]:
    """Give a signal (k, sources, components) of motions, and its derivatives (p, k, ...)."""
    # `index` is the number of the bearing or mesh whose force is the signal.
    frequencies, speeds, sources, phasors = motions
    base = family.base

    def outputs_of(coordinates: Coordinates) -> Any:
        # What the core calls outputs: factors of displacements, a bearing or a mesh.
        if signal.kind != "motion":
            return signal.kind, index
        rows = signal.moved(coordinates, np.eye(len(coordinates.dofs)))
        return np.ascontiguousarray(np.moveaxis(rows, -1, 0), dtype=np.complex128)

    vectors = len(sources) + len(signal.components)
    require_memory_of(frequencies.size, len(family.names), vectors)
    outputs = outputs_of(base.coordinates)
    rates = np.asarray(1j * frequencies, dtype=np.complex128)
    seen = Motions(
        family,
        rates,
        speeds,
        phasors,
        base._model.harmonic_adjoint(frequencies, speeds, outputs),
        sources,
        outputs,
        [time_derivatives(str(each.get("quantity"))) for each in sources],
        is_damped(family, parameters),
    )
    # At a node, the outputs do not depend on the elements.
    is_fixed = isinstance(outputs, tuple) or np.count_nonzero(outputs, axis=-1).max() <= 1
    terms = seen.terms(base._model, outputs)
    plain = dataclasses.replace(seen, adjoint=np.zeros_like(seen.adjoint))
    of_outputs = [each.chosen(each.keys >= len(family.names) * each.width) for each in terms]
    values: ComplexArray = np.sum([plain.of_entries(each) for each in of_outputs], axis=0)
    sizes = dataclasses.replace(
        seen,
        phasors=np.abs(seen.phasors).astype(np.complex128),
        adjoint=np.abs(seen.adjoint).astype(np.complex128),
    )
    elastic = (sizes.of_entries(each.elastic(), judged=True) for each in terms)
    largest = max((float(np.max(np.abs(each))) for each in elastic), default=0.0)
    # The sum of absolute elastic terms has the round-off of a much larger response.
    largest *= _ROUND_OFF_OF_TERMS

    def outputs_with(model: Model) -> Any:
        return outputs if is_fixed else outputs_of(family.coordinates(model))

    slopes = np.zeros((len(parameters), *np.swapaxes(values, 1, 2).shape), dtype=np.complex128)
    for row, parameter in enumerate(parameters):
        slopes[row] = np.swapaxes(seen.slopes(parameter, largest, outputs_with), 1, 2)
    rate = (rates ** signal.derivatives())[:, None, None]
    return np.swapaxes(values, 1, 2) * rate, slopes * rate


def of_harmonic(
    family: ParameterFamily,
    parameters: Sequence[Parameter],
    of: FrequencyResponse,
    at: Any,
    quantity: str,
) -> ResponseSensitivity:
    """Give the derivatives of a signal of a frequency response."""
    _require_own(family, of.description)
    signal = _Signal.of(at, quantity, tuple(QUANTITIES))
    shape = of.frequencies.shape
    phasors = of.phasors.reshape(-1, *of.phasors.shape[-2:])
    motions = (of.frequencies.ravel(), of.speeds.ravel(), of._sources, phasors)
    index = _index(signal, family.origin, of._bearings)
    values, slopes = _harmonic(family, parameters, motions, signal, index)
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
    signal = _Signal.of(at, quantity, tuple(QUANTITIES))
    index = _index(signal, family.origin, of._bearings)
    parts = []
    for i, (shaft, ratio) in enumerate(
        zip(of.shafts, family.base._model.ratios_in_frames, strict=True)
    ):
        source: dict[str, Plain] = {
            "kind": "shaft",
            "shaft": shaft,
            "excitation": of.excitation,
        }
        own = np.ascontiguousarray(of.amplitudes[:, i : i + 1])
        motions = (ratio * of.speeds, of.speeds, [source], own)
        parts.append(_harmonic(family, parameters, motions, signal, index))
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
        **described(parameters),
        label=signal.label,
        unit=signal.unit,
        components=signal.components,
        values=values,
        derivatives=derivatives,
        **axes,
    )
