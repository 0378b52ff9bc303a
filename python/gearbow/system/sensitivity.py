"""Derivatives of results with respect to numbers of a system, here of modes and critical speeds."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np

from gearbow._convert import items, shown
from gearbow._progress import working
from gearbow._types import Array, ComplexArray
from gearbow.analysis.protocol import System
from gearbow.description.parameter import Parameter
from gearbow.errors import GearbowError, SceneError
from gearbow.results.campbell import Campbell
from gearbow.results.frequency_response import FrequencyResponse
from gearbow.results.modes import Modes
from gearbow.results.response_sensitivity import ResponseSensitivity
from gearbow.results.sensitivity import Sensitivity
from gearbow.results.static import Static
from gearbow.results.synchronous import Synchronous
from gearbow.system.linear import matrices
from gearbow.system.parameter_family import ParameterFamily, extrapolated
from gearbow.system.response_sensitivity import of_equilibrium, of_harmonic, of_synchronous

__all__ = ["sensitivity"]

#: Eigenvalues with a smaller relative difference are equal.
_EQUAL = 1e-8
#: Relative distance of the shift from the eigenvalues in the inverse iteration, and its steps.
_SHIFT, _ITERATIONS = 1e-10, 4
#: Largest residual of an eigenvector, over the forces in it.
_RESIDUAL = 1e-6


@overload
def sensitivity(
    self: System,
    parameters: str | Sequence[str],
    of: Modes | Campbell,
    *,
    progress: bool | None = None,
) -> Sensitivity: ...
@overload
def sensitivity(
    self: System,
    parameters: str | Sequence[str],
    of: FrequencyResponse | Synchronous | Static,
    *,
    at: Any,
    quantity: str = "displacement",
    progress: bool | None = None,
) -> ResponseSensitivity: ...
def sensitivity(
    self: System,
    parameters: str | Sequence[str],
    of: Modes | Campbell | FrequencyResponse | Synchronous | Static,
    *,
    at: Any = None,
    quantity: str | None = None,
    progress: bool | None = None,
) -> Sensitivity | ResponseSensitivity:
    """Find derivatives of a result with respect to parameters of the system.

    Parameters
    ----------
    parameters : str or sequence of str
        Numbers of the system by their path, for example "bearings[0].stiffness",
        "shafts['input'].segments[1].outer_diameter", "gears['wheel'].position" or
        "modal_damping". Entries of lists have numbers from 0, or names in quotes.
    of : Modes, Campbell, FrequencyResponse, Synchronous or Static
        Result of this system: its modes; its Campbell diagram, for the intersections with the
        excitation lines (critical speeds and tooth resonances); a response or the equilibrium.
    at : str, tuple or sensor, optional
        Place, mesh or, of a response, `gb.Probe` or `gb.Accelerometer`, whose signal of a response
        or equilibrium is differentiated.
    quantity : str, optional
        What is differentiated at a place: "displacement" (default), "velocity", "acceleration",
        "twist", "axial_displacement" or "bearing_force"; of an equilibrium no velocity and
        acceleration. A mesh has its force.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Sensitivity or ResponseSensitivity
        Derivatives of the natural frequencies or of the speeds, and of the damping ratios; or of a
        signal of a response or equilibrium.

    Raises
    ------
    SceneError
        If a path does not lead to a number, `of` is not a result of this system, or an argument is
        invalid.
    ConvergenceError
        If the matrices have no derivative with respect to a parameter: it cannot change at all, or
        the nodes would change, for example because a gear would leave the end of a segment.
    GearbowError
        If two modes have equal eigenvalues at an intersection, a count of modes separates them, or
        there is no such place.

    Notes
    -----
    For an eigenvalue with the right and the left vector x and y, the derivative is
    ``-yᴴ(dK + λ dC + λ² dM)x / yᴴ(C + 2λM)x``, where C includes ΩG. Groups of equal eigenvalues
    have the eigenvalues of their small matrix. For a response ``Z a = f`` with the output ``r a``,
    it is ``dr a + y(df - dZ a)`` with one adjoint solution ``Zᵀ y = r`` for all parameters. For an
    equilibrium q with the unbalanced forces F(q, p), ``dq = K⁻¹ dF`` with the tangent K. The
    derivatives of the matrices are central differences of the assembly with two or three steps,
    extrapolated; those of an equilibrium (oil films) are included. Elements keep their number and
    their degree, and move with the segments and the parts at their ends. R. L. Fox, M. P. Kapoor,
    *Rates of change of eigenvalues and eigenvectors*, AIAA J. 6 (1968); equal eigenvalues: H.
    Baumgärtel, *Analytic perturbation theory* (1985); adjoint solutions: M. B. Giles, N. A. Pierce,
    *An introduction to the adjoint approach to design*, Flow Turbul. Combust. 65 (2000).

    Examples
    --------
    The first critical speed of a stiff shaft in soft bearings is nearly proportional to the square
    root of their stiffness:

    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=0.2, outer_diameter=0.1)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e7) for x in (0.0, 0.2)]
    >>> system = gb.RotorSystem([rotor], bearings=bearings, motion="lateral")
    >>> paths = ["bearings[0].stiffness", "bearings[1].stiffness"]
    >>> found = system.sensitivity(paths, system.campbell([100.0, 2000.0], count=2))
    >>> f"{found.relative[:, 0].sum():.2f}"
    '0.50'

    The static deflection under a force is inversely proportional to it:

    >>> push = gb.Force(("rotor", 0.0), 1.0)
    >>> response = system.frequency_response([0.0], source=push)
    >>> found = system.sensitivity(paths, response, at=("rotor", 0.0))
    >>> found.relative[:, 0, 0, 0].round(2)
    array([-1., -0.])
    """
    given = [parameters] if isinstance(parameters, str) else items(parameters, "parameters", "text")
    if not given:
        raise SceneError('parameters: name at least one, such as "bearings[0].stiffness"')
    if not isinstance(of, Modes | Campbell | FrequencyResponse | Synchronous | Static):
        raise SceneError(
            "of: must be a result of modes, campbell, frequency_response, synchronous or static, "
            f"got {shown(of)}"
        )
    if isinstance(of, Modes | Campbell):
        for name, value in (("at", at), ("quantity", quantity)):
            if value is not None:
                raise SceneError(f"{name}: belongs to responses and equilibria, got {shown(value)}")
    elif at is None:
        raise SceneError("at: name the place, mesh or sensor whose signal is differentiated")
    wanted = "displacement" if quantity is None else quantity
    family = ParameterFamily(self)
    found = [Parameter.find(family.entry, path, f"parameters[{i}]") for i, path in enumerate(given)]
    with working(progress, f"derivatives with respect to {len(found)} parameters"):
        if isinstance(of, Modes):
            return _of_modes(family, found, of)
        if isinstance(of, Campbell):
            return _of_intersections(family, found, of)
        if isinstance(of, FrequencyResponse):
            return of_harmonic(family, found, of, at, wanted)
        if isinstance(of, Synchronous):
            return of_synchronous(family, found, of, at, wanted)
        return of_equilibrium(family, found, of, at, wanted)


@dataclass(frozen=True)
class _DynamicStiffness:
    """Parts of the dynamic stiffness K + λ C + λ² M at one speed, C with the gyroscopic moments."""

    mass: Array
    damping: Array
    stiffness: Array

    @classmethod
    def of(cls, system: System, speed: float) -> "_DynamicStiffness":
        found = matrices(system, speed)
        return cls(found.mass, found.damping + speed * found.gyroscopic, found.stiffness)

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
        system = family.system(parameter, value)
        return [
            form
            for speed, own in zip(speeds, groups, strict=True)
            for form in _DynamicStiffness.of(system, speed).forms(own)
        ]

    return extrapolated(forms, parameter.path, parameter.value, largest)


def _of_modes(family: ParameterFamily, parameters: Sequence[Parameter], of: Modes) -> Sensitivity:
    """Give the derivatives of the modes of a result."""
    members = _equal([complex(value) for value in of.eigenvalues])
    base = _DynamicStiffness.of(family.base, of.speed)
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


def _of_intersections(
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
        own = _Group.of(_DynamicStiffness.of(family.base, crossing.speed), value, 1, what)
        groups.append([own])

        def forms(speed: float, own: _Group = own) -> list[ComplexArray]:
            return _DynamicStiffness.of(family.base, speed).forms([own])

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
