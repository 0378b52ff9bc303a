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
from gearbow.system.parameter_family import ParameterFamily, extrapolated

__all__ = ["of_intersections", "of_modes"]

#: Eigenvalues with a smaller relative difference are equal.
_EQUAL = 1e-8
#: Relative distance of the shift from the eigenvalues in the inverse iteration, and its steps.
_SHIFT, _ITERATIONS = 1e-10, 4
#: Largest residual of an eigenvector, over the forces in it.
_RESIDUAL = 1e-6


@dataclass(frozen=True)
class _DynamicStiffness:
    """Parts of the dynamic stiffness K + λ C + λ² M at one speed, C with the gyroscopic moments."""

    mass: Array
    damping: Array
    stiffness: Array

    @classmethod
    def of(cls, model: Model, speed: float) -> "_DynamicStiffness":
        found = model.matrices(speed)
        damping = found["damping"] + speed * found["gyroscopic"]
        return cls(found["mass"], damping, found["stiffness"])

    def at(self, value: complex) -> ComplexArray:
        """Give the dynamic stiffness."""
        made: ComplexArray = self.stiffness + value * self.damping + value**2 * self.mass
        return made

    def slope(self, value: complex) -> ComplexArray:
        """Give its derivative with respect to the eigenvalue."""
        made: ComplexArray = self.damping + 2.0 * value * self.mass
        return made

    def forms(self, groups: Sequence["_Group"]) -> list[ComplexArray]:
        """Give yᴴ Z(λ) x of each group."""
        return [group.left @ self.forces(group.value, group.right) for group in groups]

    def forces(self, value: complex, motion: ComplexArray) -> ComplexArray:
        """Give Z(λ) x, from products of real matrices."""
        parts = np.hstack([motion.real, motion.imag])
        by_part = (
            factor * (matrix @ parts)
            for factor, matrix in (
                (1.0, self.stiffness),
                (value, self.damping),
                (value**2, self.mass),
            )
        )
        real, imaginary = np.hsplit(sum(by_part), 2)
        return real + 1j * imaginary


@dataclass(frozen=True)
class _Group:
    """Equal eigenvalues at one speed with their vectors, for which yᴴ (C + 2λM) x = 1."""

    value: complex
    right: ComplexArray
    left: ComplexArray

    @classmethod
    def of(cls, found: _DynamicStiffness, value: complex, count: int, what: str) -> "_Group":
        # Translations and rotations have different units: the vectors are scaled by the energies.
        energy = np.abs(np.diag(found.stiffness)) + abs(value) ** 2 * np.diag(found.mass)
        scale = 1.0 / np.sqrt(energy)[:, None]
        inverse = np.linalg.inv(scale * found.at(value * (1.0 + _SHIFT)) * scale.T)
        right, most = _null_vectors(inverse, count)
        right, left = scale * right, (scale * _null_vectors(inverse.conj().T, count)[0]).conj().T
        parts = [
            np.linalg.norm(scale * (matrix @ right))
            for matrix in (found.stiffness, value * found.damping, value**2 * found.mass)
        ]
        rest = np.linalg.norm(scale * found.forces(value, right))
        if rest > _RESIDUAL * max(parts):
            raise SceneError(f"of: {what} is no mode of this system; give a result of this system")
        if most > count:
            raise GearbowError(
                f"of: {what} has the same eigenvalue as another mode, so that it has no derivative "
                "by itself; compute modes with a count that contains both"
            )
        product = left @ found.slope(value) @ right
        if np.linalg.cond(product) > 1.0 / _EQUAL:
            raise GearbowError(
                f"of: the eigenvalues of {what} have fewer vectors than their number (critical "
                "damping), so that they have no derivative; change the damping or leave it out"
            )
        return cls(value, right, np.linalg.solve(product, left))


def _null_vectors(inverse: ComplexArray, count: int) -> tuple[ComplexArray, int]:
    """Find vectors of equal eigenvalues by inverse iteration, and the number of these."""
    size = inverse.shape[0]
    wide = min(size, count + 2)
    # Fixed numbers give the same result at every call.
    vectors = np.random.default_rng(0).standard_normal((size, wide)).astype(complex)
    for _ in range(_ITERATIONS):
        vectors, growth, _ = np.linalg.svd(inverse @ vectors, full_matrices=False)
    equal = int(np.sum(growth > _SHIFT / _EQUAL * growth[0]))
    return vectors[:, :count], equal


def _derivatives(
    family: ParameterFamily,
    parameter: Parameter,
    speeds: Sequence[float],
    groups: Sequence[Sequence[_Group]],
) -> list[ComplexArray]:
    """Give -yᴴ dZ/dp x of all groups at all speeds."""
    largest = max((abs(group.value) for own in groups for group in own), default=0.0)

    def forms(value: float) -> list[ComplexArray]:
        model = family.model(parameter, value)
        return [
            form
            for speed, own in zip(speeds, groups, strict=True)
            for form in _DynamicStiffness.of(model, speed).forms(own)
        ]

    return extrapolated(forms, parameter.path, parameter.value, largest)


def of_modes(family: ParameterFamily, parameters: Sequence[Parameter], of: Modes) -> Sensitivity:
    """Give the derivatives of the modes of a result."""
    members = _equal([complex(value) for value in of.eigenvalues])
    base = _DynamicStiffness.of(family.base._model, of.speed)
    kept = [own for own in members if of.whirl[own[0]] != "rigid" and of.eigenvalues[own[0]] != 0.0]
    values = [complex(np.mean(of.eigenvalues[own])) for own in kept]
    groups = [
        _Group.of(base, value, len(own), f"mode {own[0] + 1}")
        for value, own in zip(values, kept, strict=True)
    ]
    slopes = np.full((len(parameters), of.eigenvalues.size), complex(np.nan, np.nan))
    for row, parameter in enumerate(parameters):
        forms = _derivatives(family, parameter, [of.speed], [groups])
        for own, form in zip(kept, forms, strict=True):
            found = np.linalg.eigvals(form)
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


def of_intersections(
    family: ParameterFamily, parameters: Sequence[Parameter], of: Campbell
) -> Sensitivity:
    """Give the derivatives of the intersections of a Campbell diagram."""
    # An eigenvalue λ = σ + i n Ω of order n moves by a dp + b dΩ, so that dΩ/dp = Im a/(n - Im b).
    crossings = of.intersections
    values, groups, along = [], [], []
    for i, crossing in enumerate(crossings):
        frequency, ratio = 2.0 * math.pi * crossing.frequency_hz, crossing.damping_ratio
        value = complex(-ratio * frequency / math.sqrt(1.0 - ratio**2), frequency)
        what = f"intersection {i + 1}"
        values.append(value)
        own = _Group.of(_DynamicStiffness.of(family.base._model, crossing.speed), value, 1, what)
        groups.append([own])

        def forms(speed: float, own: _Group = own) -> list[ComplexArray]:
            return _DynamicStiffness.of(family.base._model, speed).forms([own])

        slope = extrapolated(forms, "speed", crossing.speed, abs(value))
        along.append(complex(slope[0][0, 0]))
    speeds = [crossing.speed for crossing in crossings]
    orders = np.array([crossing.line.order for crossing in crossings])
    rates, shape = np.array(along, dtype=complex), (len(parameters), len(crossings))
    fixed = np.empty(shape, dtype=complex)
    for row, parameter in enumerate(parameters):
        slopes = _derivatives(family, parameter, speeds, groups)
        fixed[row] = [own[0, 0] for own in slopes]
    derivatives = fixed.imag / (orders - rates.imag)
    return Sensitivity(
        kind="critical speed",
        parameters=tuple(each.path for each in parameters),
        parameter_values=np.array([each.value for each in parameters]),
        units=tuple(each.unit for each in parameters),
        outputs=tuple(f"mode {each.mode + 1} with {each.line.name}" for each in crossings),
        output_values=np.array(speeds),
        derivatives=derivatives,
        damping_ratios=_damping_slopes(
            np.array(values, dtype=complex), fixed + rates * derivatives
        ),
        equal=(),
        speed=None,
        speed_unit=of.speed_unit,
    )
