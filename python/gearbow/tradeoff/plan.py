"""The plan of a study: the checked arguments of `gearbow.RotorSystem.tradeoff`."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Generic

from gearbow._convert import items, number, truth, whole
from gearbow._lookup import one_of
from gearbow._times import grid
from gearbow._types import Array
from gearbow.accuracy.refine import MAX_DEGREE
from gearbow.analysis.protocol import S, System
from gearbow.errors import SceneError
from gearbow.tradeoff.models import Model, degrees_of, simplified
from gearbow.tradeoff.settings import METHODS, Setting, ladders
from gearbow.tradeoff.signals import Signal, read_signals

__all__ = ["Plan", "plan"]

_INITIAL = ("synchronous", "static", "rest")


@dataclass(frozen=True, eq=False)
class Plan(Generic[S]):
    """All runs of a study."""

    system: S
    duration: float
    speed: float
    wanted: tuple[Signal, ...]
    times: Array
    initial: str
    settings: list[Setting]
    simpler: list[Model[S]]
    degrees: list[int]
    repeats: int

    def settings_of(self, model: Model[S]) -> list[Setting]:
        """Return the settings of a simplified model."""
        methods = model.methods or (self.settings[0].method,)
        return [setting for setting in self.settings if setting.method in methods]

    def common(self) -> dict[str, Any]:
        """Return the options of `simulate` that all runs share."""
        record = list(dict.fromkeys(signal.of for signal in self.wanted))
        return {"times": self.times, "record": record, "initial": self.initial}


def plan(
    system: S,
    duration: float,
    speed: float,
    signals: object,
    *,
    methods: str | Iterable[str] | None,
    steps: Iterable[float] | None,
    tolerances: Iterable[float] | None,
    modes: Iterable[int] | None,
    elements: Iterable[float],
    degrees: Iterable[int] | None,
    frozen: bool,
    mean_stiffness: bool,
    initial: str,
    output_step: float | None,
    repeats: int,
) -> Plan[S]:
    """Read and check the arguments of a study."""
    duration, speed = number(duration, "duration"), number(speed, "speed")
    if not 0.0 < duration < math.inf:
        raise SceneError(f"duration: must be positive and finite, got {duration!r}")
    if not math.isfinite(speed):
        raise SceneError(f"speed: must be finite, got {speed!r}")
    one_of(initial, _INITIAL, "initial")
    if output_step is None:
        output_step = system.default_output_step(duration, speed)
    factors, orders = _numbers(elements, "elements"), _degrees(degrees, system)
    names = _methods(methods)
    settings = ladders(
        system,
        speed,
        names,
        None if steps is None else _numbers(steps, "steps"),
        None if tolerances is None else _numbers(tolerances, "tolerances", most=1.0),
    )
    if not settings:
        raise SceneError(f"methods: no settings for {', '.join(names)}; give tolerances or steps")
    return Plan(
        system=system,
        duration=duration,
        speed=speed,
        wanted=read_signals(system, signals),
        times=grid(0.0, duration, number(output_step, "output_step")),
        initial=initial,
        settings=settings,
        simpler=simplified(
            system,
            frozen=truth(frozen, "frozen"),
            mean_stiffness=truth(mean_stiffness, "mean_stiffness"),
            factors=factors,
            degrees=orders,
            modes=_modes(modes, names, system),
        ),
        degrees=orders,
        repeats=whole(repeats, "repeats"),
    )


def _methods(given: str | Iterable[str] | None) -> list[str]:
    if given is None:
        return list(METHODS)
    names = [given] if isinstance(given, str) else items(given, "methods", "names")
    for i, name in enumerate(names):
        one_of(name, METHODS, f"methods[{i}]")
    if not names:
        raise SceneError("methods: must name at least one method, got an empty list")
    return list(dict.fromkeys(names))


def _modes(given: Iterable[int] | None, names: list[str], system: System) -> list[int]:
    """Read the numbers of modes; the default is 1/2, 1/4 and 1/8 of all modes."""
    if "exponential" not in names:
        return []
    if given is None:
        return [count for count in (len(system.dofs) // part for part in (2, 4, 8)) if count]
    return [whole(count, f"modes[{i}]") for i, count in enumerate(items(given, "modes", "numbers"))]


def _degrees(given: Iterable[int] | None, system: System) -> list[int]:
    """Read the degrees; the default is one below and one above those of the system."""
    if given is None:
        known = degrees_of(system)
        return [degree for degree in (min(known) - 1, max(known) + 1) if 1 <= degree <= MAX_DEGREE]
    found = [
        whole(degree, f"degrees[{i}]")
        for i, degree in enumerate(items(given, "degrees", "numbers"))
    ]
    for i, degree in enumerate(found):
        if degree > MAX_DEGREE:
            raise SceneError(f"degrees[{i}]: must be from 1 to {MAX_DEGREE}, got {degree}")
    return found


def _numbers(values: Iterable[object], name: str, most: float = math.inf) -> list[float]:
    """Read a list of positive numbers without duplicates."""
    found = []
    for i, value in enumerate(items(values, name, "numbers")):
        read = number(value, f"{name}[{i}]")
        if not 0.0 < read < most:
            bound = "positive and finite" if math.isinf(most) else f"between 0 and {most:g}"
            raise SceneError(f"{name}[{i}]: must be {bound}, got {value!r}")
        found.append(read)
    return list(dict.fromkeys(found))
