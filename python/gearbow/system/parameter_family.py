"""Systems over a parameter, and derivatives of what follows from them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace
from itertools import pairwise
from typing import Any

import numpy as np

from gearbow._core import Model
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
        for before, after, inner in rows:
            first, path = len(made), f"shafts[{index}].segments[{len(made)}]"
            if after is before:
                made += known["segments"][first : first + len(inner) + 1]
            else:
                made += [part._describe(path) for part in _between(after, inner)]
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
