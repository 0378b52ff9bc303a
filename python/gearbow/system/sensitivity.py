"""Derivatives of natural frequencies and critical speeds with respect to numbers of a system."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from gearbow._convert import items, shown
from gearbow._progress import working
from gearbow._types import Array, ComplexArray
from gearbow.analysis.protocol import System, variant
from gearbow.description.parameter import Parameter
from gearbow.description.places import is_place
from gearbow.description.shafts import Shaft, Sleeve, segments_of
from gearbow.description.train import PARTS
from gearbow.errors import ConvergenceError, GearbowError, SceneError
from gearbow.results.campbell import Campbell
from gearbow.results.modes import Modes
from gearbow.results.sensitivity import Sensitivity
from gearbow.system.linear import matrices

__all__ = ["sensitivity"]

#: Largest step of the differences, over the value; it is divided by ten while the differences of
#: three steps disagree, for example because a part would pass a node.
_STEP, _STEPS = 2e-3, 4
#: Largest accepted difference of the two extrapolations: over the largest derivative with respect
#: to this parameter, and over that of an eigenvalue proportional to the parameter (round-off).
_DISAGREEMENT, _ROUND_OFF = 1e-7, 1e-10
#: Steps from the value 0 [SI units]: the first that changes an eigenvalue by this part counts.
_STEPS_FROM_ZERO, _CHANGE_FROM_ZERO = tuple(10.0**n for n in range(-6, 13, 2)), 1e-5
#: Eigenvalues with a smaller relative difference are equal.
_EQUAL = 1e-8
#: Relative distance of the shift from the eigenvalues in the inverse iteration, and its steps.
_SHIFT, _ITERATIONS = 1e-10, 4
#: Largest residual of an eigenvector, over the forces in it.
_RESIDUAL = 1e-6
#: Positions with a smaller difference are one node [m].
_SAME_NODE = 1e-9


def sensitivity(
    self: System,
    parameters: str | Sequence[str],
    of: Modes | Campbell,
    *,
    progress: bool | None = None,
) -> Sensitivity:
    """Find derivatives of natural frequencies or critical speeds with respect to parameters.

    Parameters
    ----------
    parameters : str or sequence of str
        Numbers of the system by their path, for example "bearings[0].stiffness",
        "shafts['input'].segments[1].outer_diameter", "gears['wheel'].position" or
        "modal_damping". Entries of lists have numbers from 0, or names in quotes.
    of : Modes or Campbell
        Result of this system: its modes, or its Campbell diagram, for the intersections with the
        excitation lines (critical speeds and tooth resonances).
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Sensitivity
        Derivatives of the natural frequencies or of the speeds, and of the damping ratios.

    Raises
    ------
    SceneError
        If a path does not lead to a number, or `of` is not a result of this system.
    ConvergenceError
        If the matrices have no derivative with respect to a parameter: it cannot change at all, or
        the nodes would change, for example because a gear would leave the end of a segment.
    GearbowError
        If two modes have equal eigenvalues at an intersection, or a count of modes separates them.

    Notes
    -----
    For an eigenvalue with the right and the left vector x and y, the derivative is
    ``-yᴴ(dK + λ dC + λ² dM)x / yᴴ(C + 2λM)x``, where C includes ΩG. The derivatives of the matrices
    are central differences of the assembly with three steps, extrapolated; those of an equilibrium
    (oil films) are included. Elements keep their number and their degree, and move with the
    segments and the parts at their ends. Groups of equal eigenvalues have the eigenvalues of their
    small matrix. R. L. Fox, M. P. Kapoor, *Rates of change of eigenvalues and eigenvectors*, AIAA
    J. 6 (1968); equal eigenvalues: H. Baumgärtel, *Analytic perturbation theory* (1985).

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
    """
    given = [parameters] if isinstance(parameters, str) else items(parameters, "parameters", "text")
    if not given:
        raise SceneError('parameters: name at least one, such as "bearings[0].stiffness"')
    if not isinstance(of, Modes | Campbell):
        raise SceneError(f"of: must be a result of modes or campbell, got {shown(of)}")
    family = _ParameterFamily(self)
    found = [Parameter.find(family.entry, path, f"parameters[{i}]") for i, path in enumerate(given)]
    with working(progress, f"derivatives with respect to {len(found)} parameters"):
        if isinstance(of, Modes):
            return _of_modes(family, found, of)
        return _of_intersections(family, found, of)


class _ParameterFamily:
    """Systems over a parameter, whose elements keep their number and move with the parts."""

    def __init__(self, base: System) -> None:
        self.origin = base
        given = base._model.resolved()["shafts"]
        self.shafts = tuple(Shaft._from_description(shaft) for shaft in given)
        self._parts = [_parts_along(base, shaft) for shaft in self.shafts]
        self.base: System = variant(base, shafts=self._of_nodes(self.shafts))
        self.names = [name for name, *_ in self.base.dofs]
        same = len(self.base.dofs) == len(base.dofs)
        if not same:
            raise ConvergenceError(
                f"parameters: the nodes cannot follow the parts: {len(base.dofs)} degrees of "
                f"freedom become {len(self.base.dofs)}"
            )

    def entry(self, key: str) -> Any:
        """Give a list of parts, or an option."""
        return self.shafts if key == "shafts" else getattr(self.origin, key)

    def system(self, parameter: Parameter, value: float) -> System:
        """Give the system with another value of a parameter."""
        changed = parameter.changed(self.entry(parameter.key), value)
        if parameter.key == "shafts":
            made: System = variant(self.base, shafts=self._of_nodes(changed))
        else:
            made = variant(self.base, **{parameter.key: changed})
        if [name for name, *_ in made.dofs] != self.names:
            raise ConvergenceError(
                f"the nodes change with it: {len(self.names)} degrees of freedom become "
                f"{len(made.dofs)} at {value:.9g} {parameter.unit}, because a part would "
                "leave the end of a shaft or segment or another part; shift one of them"
            )
        return made

    def _of_nodes(self, shafts: Sequence[Shaft]) -> list[Shaft]:
        """Give every shaft a segment for each element, with the boundaries of the first system."""
        return [_of_nodes(*pair) for pair in zip(shafts, self._parts, strict=True)]


def _parts_along(system: System, shaft: Shaft) -> list[list[float]]:
    """Give the boundaries of elements without parts on each segment, over its length."""
    places: list[float] = []
    for key in PARTS:
        for part in getattr(system, key):
            if getattr(part, "shaft", None) == shaft.name:
                ends = ("begin", "end") if isinstance(part, Sleeve) else ("position",)
                places += [float(getattr(part, end)) for end in ends]
            for each in (getattr(part, name, None) for name in ("at", "a", "b")):
                if is_place(each) and each[0] == shaft.name:  # type: ignore[index]  # checked
                    places.append(float(each[1]))  # type: ignore[index]  # checked
    found, begin = [], 0.0
    for segment in segments_of(shaft):
        count = segment.elements or 1
        inner = [i / count for i in range(1, count)]
        found.append(
            [
                part
                for part in inner
                if all(abs(begin + part * segment.length - x) > _SAME_NODE for x in places)
            ]
        )
        begin += segment.length
    return found


def _of_nodes(shaft: Shaft, boundaries: list[list[float]]) -> Shaft:
    """Give a shaft a segment between each two boundaries."""
    made = []
    for segment, inner in zip(segments_of(shaft), boundaries, strict=True):
        ends = [0.0, *inner, 1.0]
        made += [segment._between(begin, end) for begin, end in pairwise(ends)]
    none: dict[str, Any] = {"length": None, "outer_diameter": None, "inner_diameter": 0.0}
    return replace(shaft, segments=made, elements=None, **none)


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
    family: _ParameterFamily,
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

    return _extrapolated(forms, parameter.path, parameter.value, largest)


def _extrapolated(forms: Any, path: str, value: float, largest: float) -> list[ComplexArray]:
    """Differentiate small matrices over a value."""
    reason: GearbowError | None = None
    for step in _steps(forms, value, largest):
        try:
            found, error = _difference(forms, value, step)
        except GearbowError as refused:
            reason = refused
            continue
        most = max((np.max(np.abs(form)) for form in found), default=0.0)
        if error <= _DISAGREEMENT * most + _ROUND_OFF * largest / (abs(value) or step):
            return [-form for form in found]
        reason = ConvergenceError(
            f"the differences of three steps disagree by {error / most:.1e} at the step {step:.1e}"
        )
    raise ConvergenceError(f"parameters: {path}: has no derivative at {value:.9g}: {reason}")


def _steps(forms: Any, value: float, largest: float) -> Iterator[float]:
    """Give steps to try: a part of the value, or from 0 one that changes an eigenvalue."""
    if value != 0.0:
        yield from (_STEP * abs(value) / 10.0**i for i in range(_STEPS))
        return
    first = forms(0.0)
    step = _STEPS_FROM_ZERO[0]
    for step in _STEPS_FROM_ZERO:
        try:
            changed = forms(step)
        except GearbowError:
            break
        changes = (np.max(np.abs(b - a)) for a, b in zip(first, changed, strict=True))
        if max(changes, default=0.0) > _CHANGE_FROM_ZERO * largest:
            break
    yield from (step / 10.0**i for i in range(_STEPS))


def _difference(forms: Any, value: float, step: float) -> tuple[list[ComplexArray], float]:
    """Extrapolate differences of three steps, with the change by the last extrapolation."""
    parts = (step, step / 2.0, step / 4.0)
    try:
        slopes = [_slope(forms(value - h), forms(value + h), 2.0 * h) for h in parts]
        order = 2
    except GearbowError:
        # A number at the end of its range, such as the damping 0, changes to one side only.
        first = forms(value)
        slopes = [_slope(first, forms(value + h), h) for h in parts]
        order = 1
    once = [_extrapolate(slopes[i], slopes[i + 1], 2.0**order) for i in (0, 1)]
    twice = _extrapolate(once[0], once[1], 2.0 ** (2 * order if order == 2 else 2))
    changes = (np.max(np.abs(b - a)) for a, b in zip(once[1], twice, strict=True))
    return twice, float(max(changes, default=0.0))


def _slope(below: list[Any], above: list[Any], width: float) -> list[Any]:
    return [(b - a) / width for a, b in zip(below, above, strict=True)]


def _extrapolate(coarse: list[Any], fine: list[Any], ratio: float) -> list[Any]:
    """Remove the leading error, which falls by a ratio from the coarse to the fine value."""
    return [b + (b - a) / (ratio - 1.0) for a, b in zip(coarse, fine, strict=True)]


def _of_modes(family: _ParameterFamily, parameters: Sequence[Parameter], of: Modes) -> Sensitivity:
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
    family: _ParameterFamily, parameters: Sequence[Parameter], of: Campbell
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

        slope = _extrapolated(forms, "speed", crossing.speed, abs(value))
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
