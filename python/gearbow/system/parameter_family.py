"""Systems over a parameter, and the derivatives of their harmonic motions."""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from gearbow._core import Model, motion_forms, require_memory
from gearbow._types import Array, ComplexArray, Plain
from gearbow.analysis.protocol import System, variant
from gearbow.description.coordinates import Coordinates
from gearbow.description.places import is_place
from gearbow.description.shafts import Segment, Shaft, Sleeve, segments_of
from gearbow.description.train import PARTS, Parameter
from gearbow.errors import ConvergenceError, GearbowError

#: Largest step of the difference quotients, divided by the value of the parameter, and number of
#: trials. The next trial has a tenth of the step if the quotients of three steps do not agree, for
#: example because a part would move past a node.
_STEP, _STEPS = 2e-3, 4
#: Largest accepted difference of the last two extrapolated values: divided by the largest
#: derivative with respect to this parameter, and, for round-off, divided by the derivative of the
#: largest eigenvalue if it were proportional to the parameter.
_DISAGREEMENT, _ROUND_OFF = 1e-7, 1e-10
#: Two steps are enough if their quotients differ by less than this part of the derivative.
_SMOOTH = 1e-4
#: Steps from the value 0 [SI unit of the parameter]: the first one that changes the result by this
#: part of its largest value is taken.
_STEPS_FROM_ZERO, _CHANGE_FROM_ZERO = tuple(10.0**n for n in range(-6, 13, 2)), 1e-5
#: Positions that differ by less are the same node [m].
_SAME_NODE = 1e-9


class ParameterFamily:
    """Systems over a parameter, whose elements keep their number and move with the parts."""

    def __init__(self, base: System) -> None:
        self.origin = base
        given = base._model.resolved()["shafts"]
        self.shafts = tuple(Shaft._from_description(shaft) for shaft in given)
        self._parts = [_parts_along(base, shaft) for shaft in self.shafts]
        self.base: System = variant(base, shafts=self._of_nodes(self.shafts))
        self.names = [name for name, *_ in self.base.dofs]
        self._description: dict[str, Any] = dict(self.base.description)
        same = len(self.base.dofs) == len(base.dofs)
        if not same:
            raise ConvergenceError(
                f"parameters: the nodes cannot follow the parts: {len(base.dofs)} degrees of "
                f"freedom become {len(self.base.dofs)}"
            )

    def entry(self, key: str) -> Any:
        """Give a list of parts, or an option."""
        return self.shafts if key == "shafts" else getattr(self.origin, key)

    def model(self, parameter: Parameter, value: float) -> Model:
        """Give the model of the system with another value of a parameter."""
        key = parameter.key
        given = self.entry(key)
        changed = parameter.changed(given, value)
        if key in PARTS:
            # Only the part with the parameter is described again.
            plain = dict(self._description)
            listed = plain[key] = list(plain[key])
            for i, (old, part) in enumerate(zip(given, changed, strict=True)):
                if part is not old:
                    path = f"{key}[{i}]"
                    is_shaft = key == "shafts"
                    listed[i] = self._plain_shaft(i, part) if is_shaft else part._describe(path)
            made = Model(plain)
        else:
            made = variant(self.base, **{key: changed})._model
        if [name for name, *_ in made.dofs] != self.names:
            raise ConvergenceError(
                f"the nodes change with it: {len(self.names)} degrees of freedom become "
                f"{len(made.dofs)} at {value:.9g} {parameter.unit}, because a part would "
                "leave the end of a shaft or segment or another part; shift one of them"
            )
        return made

    def _plain_shaft(self, index: int, shaft: Shaft) -> dict[str, Any]:
        """Describe a changed shaft: only the segments that differ, if nothing else does."""
        old, known = self.shafts[index], self._description["shafts"][index]
        others = (field.name for field in fields(shaft) if field.name != "segments")
        if any(getattr(shaft, name) is not getattr(old, name) for name in others):
            return _of_nodes(shaft, self._parts[index])._describe(f"shafts[{index}]")
        made: list[Any] = []
        rows = zip(segments_of(old), segments_of(shaft), self._parts[index], strict=True)
        # The description has one segment for each part between boundaries within a segment.
        for before, after, boundaries in rows:
            first, path = len(made), f"shafts[{index}].segments[{len(made)}]"
            if after is before:
                made += known["segments"][first : first + len(boundaries) + 1]
            else:
                made += [part._describe(path) for part in _between(after, boundaries)]
        return {**known, "segments": made}

    def coordinates(self, model: Model) -> Coordinates:
        """Give the degrees of freedom of a model by name and place."""
        made: System = type(self.base)._from_model(model)
        return made.coordinates

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
    pairs = zip(segments_of(shaft), boundaries, strict=True)
    made = [part for segment, inner in pairs for part in _between(segment, inner)]
    none: dict[str, Any] = {"length": None, "outer_diameter": None, "inner_diameter": 0.0}
    return replace(shaft, segments=made, elements=None, **none)


def _between(segment: Segment, inner: Sequence[float]) -> list[Segment]:
    """Give the parts of a segment between its boundaries, over its length."""
    return [segment._between(begin, end) for begin, end in pairwise([0.0, *inner, 1.0])]


def extrapolated(
    forms: Callable[[float], list[Any]],
    path: str,
    value: float,
    largest: float,
    size: Callable[[Any], float] = lambda form: float(np.max(np.abs(form), initial=0.0)),
) -> list[Any]:
    """Differentiate a list of matrices over a value, and change the sign."""
    reason: GearbowError | None = None
    for step in _steps(forms, value, largest, size):
        try:
            found, error = _difference(forms, value, step, size)
        except GearbowError as refused:
            reason = refused
            continue
        most = max(map(size, found), default=0.0)
        if error <= _DISAGREEMENT * most + _ROUND_OFF * largest / (abs(value) or step):
            return [-1.0 * form for form in found]
        reason = ConvergenceError(
            f"the differences of three steps disagree by {error / most:.1e} at the step {step:.1e}"
        )
    raise ConvergenceError(f"parameters: {path}: has no derivative at {value:.9g}: {reason}")


def _steps(
    forms: Callable[[float], list[Any]],
    value: float,
    largest: float,
    size: Callable[[Any], float],
) -> Iterator[float]:
    """Give steps to try: a part of the value, or from 0 one that changes a form by this part."""
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
        if _largest(_changes(first, changed), size) > _CHANGE_FROM_ZERO * largest:
            break
    yield from (step / 10.0**i for i in range(_STEPS))


def _difference(
    forms: Callable[[float], list[Any]],
    value: float,
    step: float,
    size: Callable[[Any], float],
) -> tuple[list[Any], float]:
    """Extrapolate differences of two or three steps, with the change by the last extrapolation."""
    slopes: list[list[Any]] = []
    first = None
    for h in (step, step / 2.0, step / 4.0):
        above = forms(value + h)
        if first is None:
            try:
                below = forms(value - h)
            except GearbowError:
                # A number at the end of its range, such as the damping 0, changes to one side only.
                first = below = forms(value)
        else:
            below = first
        width = h if first is not None else 2.0 * h
        slopes.append([change * (1.0 / width) for change in _changes(below, above)])
        if len(slopes) == 2:
            change, most = _largest(_changes(*slopes), size), _largest(slopes[1], size)
            # The terms of higher order are smaller than the extrapolated ones as these are than
            # the derivative.
            if first is None and change <= _SMOOTH * most:
                found = _extrapolate(slopes[0], slopes[1], 4.0)
                return found, change**2 / most if most > 0.0 else 0.0
    ratio = 4.0 if first is None else 2.0
    once = [_extrapolate(slopes[i], slopes[i + 1], ratio) for i in (0, 1)]
    twice = _extrapolate(once[0], once[1], ratio**2 if first is None else 4.0)
    return twice, _largest(_changes(once[1], twice), size)


def _changes(before: list[Any], after: list[Any]) -> list[Any]:
    return [b - a for a, b in zip(before, after, strict=True)]


def _largest(forms: list[Any], size: Callable[[Any], float]) -> float:
    return max(map(size, forms), default=0.0)


def _extrapolate(coarse: list[Any], fine: list[Any], ratio: float) -> list[Any]:
    """Remove the leading error, which falls by a ratio from the coarse to the fine value."""
    return [b + (b - a) * (1.0 / (ratio - 1.0)) for a, b in zip(coarse, fine, strict=True)]


#: Number of motions that judge differences.
_JUDGED = 50
#: Columns of the entries: factors of 1, i sgn(Im λ), λ, λΩ and -λ², as in the core.
_CONSTANT, _GYROSCOPIC, _INERTIA = 0, 3, 4
#: Relative difference below which the squares of two frequencies count as equal, and relative step
#: of the derivative of a damping rate.
_EQUAL_SQUARES, _RATE_STEP = 1e-7, 1e-4
#: Arrays of the size of the adjoint solutions and of the responses that exist at one time.
_COPIES = 4


@dataclass(frozen=True, eq=False)
class ModalDamping:
    """Modal damping D = MΦ diag(2ζω) ΦᵀM of some motions, and its derivatives."""

    # With the eigenvalues λ of K over M, D is M f(M⁻¹K) for the rates f(λ) = 2ζ√λ. In the modes,
    # its change is that of a function of a matrix, G_ij dK_ij + (f_j - λ_j G_ij) dM_ij with the
    # divided differences G of f (Daleckii and Krein 1965; Higham, Functions of Matrices, 2008,
    # section 3.2). The derivative needs the modes of the unchanged system only.

    #: Shapes Φ (m, n), and ω² (m,) [1/s²], of which the first `damped` have damping.
    shapes: Array
    squares: Array
    damped: int
    #: Rates of the system at these modes and at neighbouring squares [1/s].
    rates: Array
    rates_beside: tuple[Array, Array]
    #: Coordinates of adjoint solutions (k, outputs, m) and of motions (k, sources, m) in the modes.
    left: ComplexArray
    right: ComplexArray

    @classmethod
    def of(
        cls, model: Model, speed: float, highest: float, adjoint: ComplexArray, motion: ComplexArray
    ) -> "ModalDamping":
        """Compute the modes of a model at a speed for a highest frequency [rad/s]."""
        found = model.damped_motions(speed, highest)
        momenta, squares, damped = found["momenta"], found["squares"], found["damped"]

        def rates(factor: float) -> Array:
            return _rates(model, factor * squares, damped)

        return cls(
            found["shapes"],
            squares,
            damped,
            rates(1.0),
            (rates(1.0 - _RATE_STEP), rates(1.0 + _RATE_STEP)),
            _product(adjoint, momenta.T),
            _product(motion, momenta.T),
        )

    @cached_property
    def divided(self) -> Array:
        """Divided differences of the rates over the squares of the frequencies."""
        before, after = self.rates_beside
        span = 2.0 * _RATE_STEP * self.squares
        slopes = np.divide(after - before, span, out=np.zeros_like(span), where=span > 0.0)
        above = np.subtract.outer(self.squares, self.squares)
        largest = np.maximum.outer(self.squares, self.squares)
        found = 0.5 * np.add.outer(slopes, slopes)
        far = np.abs(above) > _EQUAL_SQUARES * largest
        np.divide(np.subtract.outer(self.rates, self.rates), above, out=found, where=far)
        return found

    def rates_of(self, model: Model) -> Array:
        """Give the rates of another model at the frequencies of these modes."""
        return _rates(model, self.squares, self.damped)

    def forms(self, own: Any, terms: "Terms") -> ComplexArray:
        """Evaluate yᵀ dD x of the motions `own` for a change, (k, outputs, sources)."""
        right = self.right[own]
        changed: ComplexArray = right * terms.rates
        rows, columns = np.divmod(terms.keys, terms.width)
        size = self.shapes.shape[1]
        inside = (rows < size) & (columns < size)
        rows, columns, values = rows[inside], columns[inside], terms.values[inside].real
        # The first entries are those of -K, with the forces that circulate.
        stiffness = self._projected(rows, columns, -values[:, _CONSTANT])
        mass = self._projected(rows, columns, values[:, _INERTIA])
        if stiffness is not None or mass is not None:
            change = np.zeros_like(self.divided)
            if stiffness is not None:
                change += self.divided * stiffness
            if mass is not None:
                change += (self.rates - self.divided * self.squares) * mass
            changed = changed + _product(right, change)
        found: ComplexArray = self.left[own] @ np.swapaxes(changed, 1, 2)
        return found

    def _projected(self, rows: Any, columns: Any, values: Array) -> Array | None:
        """Give the symmetric part of ΦᵀAΦ for entries sorted by rows; None without any."""
        acting = values != 0.0
        if not acting.any():
            return None
        rows, columns, values = rows[acting], columns[acting], values[acting]
        starts = np.flatnonzero(np.diff(rows, prepend=-1))
        # One mode after the other: the products of all would take the memory of all entries.
        products = np.stack(
            [np.add.reduceat(values * shape[columns], starts) for shape in self.shapes]
        )
        found = self.shapes[:, rows[starts]] @ products.T
        symmetric: Array = 0.5 * (found + found.T)
        return symmetric


def require_memory_of(points: int, size: int, vectors: int) -> None:
    """Refuse derivatives of motions, with a number of vectors for each point, that do not fit."""
    needed = 16.0 * _COPIES * points * size * vectors
    what = f"the derivatives of {points} motions of {size} degrees of freedom"
    require_memory("of", what, needed, "differentiate a result with fewer points")


def described(parameters: Sequence[Parameter]) -> dict[str, Any]:
    """Give paths, values and units of parameters, as results have them."""
    return {
        "parameters": tuple(each.path for each in parameters),
        "parameter_values": np.array([each.value for each in parameters]),
        "units": tuple(each.unit for each in parameters),
    }


def is_damped(family: ParameterFamily, parameters: Sequence[Parameter]) -> bool:
    """Whether a system has modal damping, or it is one of the parameters."""
    by_parameter = any(each.key == "modal_damping" for each in parameters)
    return by_parameter or family.entry("modal_damping") is not None


def _rates(model: Model, squares: Array, damped: int) -> Array:
    found = np.zeros(squares.size)
    found[:damped] = model.damping_rates(squares[:damped])
    return found


def _product(left: ComplexArray, right: Array) -> ComplexArray:
    """Multiply complex by real numbers in half of the operations of complex ones."""
    made: ComplexArray = left.real @ right + 1j * (left.imag @ right)
    return made


@dataclass(frozen=True, eq=False)
class _Group:
    """Motions that have the same entries, by their numbers, and their modal damping."""

    motions: Any
    modal: ModalDamping | None

    def judged(self) -> Any:
        """Give the numbers of some motions, which show how accurate differences are."""
        return self.motions[:: 1 + self.motions.size // _JUDGED]


@dataclass(frozen=True, eq=False)
class Terms:
    """Entries of equations and outputs of a group of motions, and the rates of modal damping."""

    keys: Any
    values: ComplexArray
    rates: Array
    group: _Group
    width: int

    def __sub__(self, other: "Terms") -> "Terms":
        return self + -1.0 * other

    def __add__(self, other: "Terms") -> "Terms":
        rates = self.rates + other.rates
        if np.array_equal(self.keys, other.keys):
            return self._with(self.keys, self.values + other.values, rates)
        keys = np.union1d(self.keys, other.keys)
        values = np.zeros((keys.size, self.values.shape[1]), dtype=np.complex128)
        for each in (self, other):
            values[np.searchsorted(keys, each.keys)] += each.values
        return self._with(keys, values, rates)

    def __mul__(self, factor: float) -> "Terms":
        return self._with(self.keys, self.values * factor, self.rates * factor)

    __rmul__ = __mul__

    def chosen(self, places: Any) -> "Terms":
        """Leave out other entries and modal damping."""
        return self._with(self.keys[places], self.values[places], 0.0 * self.rates)

    def only_rates(self) -> "Terms":
        """Leave out all entries."""
        return self._with(self.keys[:0], self.values[:0], self.rates)

    def gyroscopic(self) -> "Terms":
        """Keep the gyroscopic entries, whose forces are proportional to the speed."""
        values = np.zeros_like(self.values)
        values[:, _GYROSCOPIC] = self.values[:, _GYROSCOPIC]
        return self._with(self.keys, values, 0.0 * self.rates)

    def elastic(self) -> "Terms":
        """Keep the absolute elastic entries."""
        values = np.zeros_like(self.values)
        values[:, _CONSTANT] = np.abs(self.values[:, _CONSTANT])
        return self._with(self.keys, values, 0.0 * self.rates)

    def _with(self, keys: Any, values: ComplexArray, rates: Array) -> "Terms":
        return dataclasses.replace(self, keys=keys, values=values, rates=rates)


@dataclass(frozen=True, eq=False)
class Motions:
    """Motions e^{λt} of a system, k points of a rate λ and a speed, with adjoint solutions."""

    family: ParameterFamily
    rates: ComplexArray
    speeds: Array
    #: Motions x (k, sources, n) and adjoint solutions y (k, outputs, n).
    phasors: ComplexArray
    adjoint: ComplexArray
    #: Sources, what the core calls outputs, and the number of integrations of each source.
    sources: list[dict[str, Plain]]
    outputs: Any
    integrations: list[int]
    #: Whether the modal damping differs from that of the unchanged system, which may be zero.
    is_damped: bool

    @cached_property
    def highest(self) -> float:
        """Largest frequency in question [rad/s]."""
        return float(np.max(np.abs(self.rates), initial=0.0)) or 1.0

    @cached_property
    def groups(self) -> list[_Group]:
        """Groups of motions with the same entries."""
        model = self.family.base._model
        frequencies = self.rates.imag
        states = [self.speeds if model.depends_on_speed else np.sign(self.speeds)]
        if any(shaft.loss_factor != 0.0 for shaft in self.family.shafts):
            # Structural damping of a shaft has the sign of the frequency relative to it.
            states.append(np.sign(frequencies))
            spins = np.outer(self.speeds, model.speed_ratios)
            for spin in (*spins.T, *-spins.T):
                relative = frequencies - spin
                states.append(
                    np.where(np.abs(relative) <= 1e-13 * np.abs(spin), 0.0, np.sign(relative))
                )
        numbers = np.unique(np.stack(states), axis=1, return_inverse=True)[1].ravel()
        found = []
        for number in range(int(numbers.max(initial=-1)) + 1):
            own = np.flatnonzero(numbers == number)
            modal = None
            if self.is_damped:
                modal = ModalDamping.of(
                    model,
                    float(self.speeds[own[0]]),
                    self.highest,
                    self.adjoint[own],
                    self.phasors[own],
                )
            found.append(_Group(own, modal))
        return found

    def terms(
        self, model: Model, outputs: Any, base: Any = None, speed: float | None = None
    ) -> list[Terms]:
        """Assemble the entries, less those of a base, for each group; at another speed if given."""
        width = len(self.family.names) + max(len(self.sources), self.adjoint.shape[1])
        found = []
        for group in self.groups:
            first = group.motions[0]
            rate, at_speed = complex(self.rates[first]), float(self.speeds[first])
            at = (rate.real, rate.imag, at_speed if speed is None else speed)
            rows, columns, values = model.harmonic_terms(
                at, self.highest, self.sources, outputs, base
            )
            rates = group.modal.rates_of(model) if group.modal else np.zeros(0)
            found.append(Terms(rows * width + columns, values, rates, group, width))
        return found

    def slopes(
        self, parameter: Parameter, largest: float, outputs: Callable[[Model], Any]
    ) -> ComplexArray:
        """Give (yᵀ, eᵀ) dB/dp (x, e) of each motion, whose round-off is relative to `largest`."""
        base = self.family.base._model, self.outputs

        def of(value: float) -> list[Terms]:
            model = self.family.model(parameter, value)
            return self.terms(model, outputs(model), base)

        return self.change(of, parameter.path, parameter.value, largest)

    def change(
        self, of: Callable[[float], list[Terms]], path: str, value: float, largest: float
    ) -> ComplexArray:
        """Differentiate the forms of entries over a value."""

        def size(change: Terms) -> float:
            forms = self.of_entries(change, judged=True)
            if change.group.modal is not None:
                # Changes of the modes follow from those of the entries.
                judged = change.group.judged()
                forms = forms + self._of_damping(change.only_rates(), judged)
            return float(np.max(np.abs(forms), initial=0.0))

        found = self._zeros()
        for each in extrapolated(of, path, value, largest, size):
            found -= self.of_entries(each)
            if each.group.modal is not None:
                own = each.group.motions
                found[own] -= self._of_damping(each, own)
        return found

    def of_entries(self, terms: Terms, judged: bool = False) -> ComplexArray:
        """Evaluate (yᵀ, eᵀ) B (x, e) at the motions of the terms, or some; zero at others."""
        own = terms.group.judged() if judged else terms.group.motions
        acting = terms.values.any(axis=1)
        rows, columns = np.divmod(terms.keys[acting], terms.width)
        entries = rows, columns, np.ascontiguousarray(terms.values[acting])
        # A slice of all motions is no copy.
        places = slice(None) if own.size == self.rates.size else own
        forms = motion_forms(
            self.rates[places],
            self.speeds[places],
            entries,
            self.adjoint[places],
            self.phasors[places],
            self.integrations,
        )
        if judged or own.size == self.rates.size:
            return forms
        found = self._zeros()
        found[own] = forms
        return found

    def _zeros(self) -> ComplexArray:
        shape = (self.rates.size, self.adjoint.shape[1], self.phasors.shape[1])
        return np.zeros(shape, dtype=np.complex128)

    def _of_damping(self, terms: Terms, motions: Any) -> ComplexArray:
        """Evaluate the forms of the force -λ dD x."""
        group = terms.group
        assert group.modal is not None  # as the caller checks
        own = np.searchsorted(group.motions, motions)
        found: ComplexArray = -self.rates[motions, None, None] * group.modal.forms(own, terms)
        return found
