"""Derivatives of modes and critical speeds with respect to parameters."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gearbow._core import Model
from gearbow._types import Array, ComplexArray
from gearbow.description.parameter import Parameter
from gearbow.errors import GearbowError, SceneError
from gearbow.results.campbell import Campbell
from gearbow.results.modes import Modes
from gearbow.results.sensitivity import Sensitivity
from gearbow.system.motions import Motions, Terms, is_damped, require_memory_of
from gearbow.system.parameter_family import ParameterFamily

#: Eigenvalues with a smaller relative difference are equal.
_EQUAL = 1e-8


@dataclass(frozen=True)
class _Group:
    """Equal eigenvalues at one speed with their vectors, for which yᵀ (C + 2λM) x = 1."""

    value: complex
    speed: float
    #: Right and left vectors (count, n).
    right: ComplexArray
    left: ComplexArray

    @classmethod
    def of(
        cls, model: Model, at: tuple[complex, float], count: int, highest: float, what: str
    ) -> "_Group":
        """Compute the vectors of a number of eigenvalues at a value and a speed."""
        value, speed = at
        found = model.null_vectors((value.real, value.imag), speed, count, highest)
        if not found["is_accurate"]:
            raise SceneError(f"of: {what} is no mode of this system; give a result of this system")
        if found["has_more"]:
            raise GearbowError(
                f"of: {what} has the same eigenvalue as another mode, so that it has no derivative "
                "by itself; compute modes with a count that contains both"
            )
        product = found["slopes"]
        if np.linalg.cond(product) > 1.0 / _EQUAL:
            raise GearbowError(
                f"of: the eigenvalues of {what} have fewer vectors than their number (critical "
                "damping), so that they have no derivative; change the damping or leave it out"
            )
        left = np.linalg.solve(product, found["left"]).astype(np.complex128)
        return cls(value, speed, found["right"], left)


def _motions(
    family: ParameterFamily, parameters: Sequence[Parameter], groups: Sequence[_Group]
) -> Motions:
    """Give the motions of groups, whose vectors are filled up with zeros to the same number."""
    size = len(family.names)
    most = max((len(group.right) for group in groups), default=0)
    require_memory_of(len(groups), size, 2 * most)

    def filled(name: str) -> ComplexArray:
        found = np.zeros((len(groups), most, size), dtype=np.complex128)
        for own, group in zip(found, groups, strict=True):
            own[: len(group.right)] = getattr(group, name)
        return found

    return Motions(
        family,
        np.array([group.value for group in groups], dtype=np.complex128),
        np.array([group.speed for group in groups], dtype=np.float64),
        filled("right"),
        filled("left"),
        # No source excites a mode.
        [],
        np.zeros((0, size), dtype=np.complex128),
        [0] * most,
        is_damped(family, parameters),
    )


def _derivatives(motions: Motions, parameter: Parameter) -> ComplexArray:
    """Give -yᵀ dZ/dp x of all groups."""
    return motions.slopes(parameter, motions.highest, lambda _: motions.outputs)


def of_modes(family: ParameterFamily, parameters: Sequence[Parameter], of: Modes) -> Sensitivity:
    """Give the derivatives of the modes of a result."""
    members = _equal([complex(value) for value in of.eigenvalues])
    kept = [own for own in members if of.whirl[own[0]] != "rigid" and of.eigenvalues[own[0]] != 0.0]
    values = [complex(np.mean(of.eigenvalues[own])) for own in kept]
    highest = max(map(abs, values), default=1.0)
    groups = [
        _Group.of(family.base._model, (value, of.speed), len(own), highest, f"mode {own[0] + 1}")
        for value, own in zip(values, kept, strict=True)
    ]
    motions = _motions(family, parameters, groups)
    slopes = np.full((len(parameters), of.eigenvalues.size), complex(np.nan, np.nan))
    for row, parameter in enumerate(parameters):
        for own, form in zip(kept, _derivatives(motions, parameter), strict=True):
            found = np.linalg.eigvals(form[: len(own), : len(own)])
            slopes[row, own] = found[np.argsort(found.imag, kind="stable")]
    frequencies = np.abs(of.eigenvalues.imag) / (2.0 * math.pi)
    return Sensitivity(
        kind="frequency",
        parameters=tuple(each.path for each in parameters),
        parameter_values=np.array([each.value for each in parameters]),
        units=tuple(each.unit for each in parameters),
        outputs=tuple(f"mode {i + 1} ({whirl})" for i, whirl in enumerate(of.whirl)),
        output_values=frequencies,
        derivatives=np.sign(of.eigenvalues.imag) * slopes.imag / (2.0 * math.pi),
        damping_ratios=_damping_slopes(of.eigenvalues, slopes),
        equal=tuple(tuple(i + 1 for i in own) for own in kept if len(own) > 1),
        speed=of.speed,
        speed_unit=of.speed_unit,
    )


def _equal(values: list[complex]) -> list[list[int]]:
    """Group equal eigenvalues."""
    groups: list[list[int]] = []
    for i, value in enumerate(values):
        for own in groups:
            if abs(value - values[own[0]]) <= _EQUAL * abs(value):
                own.append(i)
                break
        else:
            groups.append([i])
    return groups


def _damping_slopes(values: ComplexArray, slopes: ComplexArray) -> Array:
    """Differentiate the damping ratio -Re λ/|λ|."""
    with np.errstate(invalid="ignore", divide="ignore"):
        cross = values.real * slopes.imag - values.imag * slopes.real
        found: Array = values.imag * cross / np.abs(values) ** 3
    return found


def _along(motions: Motions) -> complex:
    """Give the derivative of one eigenvalue with respect to the speed."""
    model, speed = motions.family.base._model, float(motions.speeds[0])

    def of(value: float) -> list[Terms]:
        return motions.terms(model, motions.outputs, speed=value)

    gyroscopic = sum(motions.of_entries(each.gyroscopic()) for each in of(speed))
    found = complex(np.ravel(gyroscopic)[0]) / speed
    if model.depends_on_speed:
        found += complex(motions.change(of, "speed", speed, motions.highest)[0, 0, 0])
    return found


def of_intersections(
    family: ParameterFamily, parameters: Sequence[Parameter], of: Campbell
) -> Sensitivity:
    """Give the derivatives of the intersections of a Campbell diagram."""
    # An eigenvalue λ = σ + i n Ω of order n moves by a dp + b dΩ, so that dΩ/dp = Im a/(n - Im b).
    crossings = of.intersections
    ratios = [crossing.damping_ratio for crossing in crossings]
    frequencies = [2.0 * math.pi * crossing.frequency_hz for crossing in crossings]
    values = [
        complex(-ratio * frequency / math.sqrt(1.0 - ratio**2), frequency)
        for ratio, frequency in zip(ratios, frequencies, strict=True)
    ]
    highest, model = max(map(abs, values), default=1.0), family.base._model
    groups = [
        _Group.of(model, (value, crossing.speed), 1, highest, f"intersection {i + 1}")
        for i, (value, crossing) in enumerate(zip(values, crossings, strict=True))
    ]
    motions = _motions(family, parameters, groups)
    speeds = motions.speeds
    along = [_along(_motions(family, parameters, [group])) for group in groups]
    orders = np.array([crossing.line.order for crossing in crossings])
    rates, shape = np.array(along, dtype=complex), (len(parameters), len(crossings))
    fixed = np.empty(shape, dtype=complex)
    for row, parameter in enumerate(parameters):
        fixed[row] = _derivatives(motions, parameter)[:, 0, 0]
    derivatives = fixed.imag / (orders - rates.imag)
    return Sensitivity(
        kind="critical speed",
        parameters=tuple(each.path for each in parameters),
        parameter_values=np.array([each.value for each in parameters]),
        units=tuple(each.unit for each in parameters),
        outputs=tuple(f"mode {each.mode + 1} with {each.line.name}" for each in crossings),
        output_values=speeds,
        derivatives=derivatives,
        damping_ratios=_damping_slopes(
            np.array(values, dtype=complex), fixed + rates * derivatives
        ),
        equal=(),
        speed=None,
        speed_unit=of.speed_unit,
    )
