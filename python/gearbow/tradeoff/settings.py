"""Settings of a study: methods as data, each with a series of steps or tolerances."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

from gearbow.analysis.protocol import System


@dataclass(frozen=True)
class Method:
    """A method of integration and the values of its error control."""

    options: Mapping[str, Any]
    control: str
    ladder: tuple[float, ...]
    finest: tuple[float, ...] = ()
    unit: str = ""


#: Methods of a study by name. The first method that fits the budget gives the reference.
METHODS: dict[str, Method] = {
    "exponential": Method(
        {"method": "exponential"},
        "rtol",
        (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10),
        (1e-12, 1e-10, 1e-8),
    ),
    "rk45": Method(
        {"method": "rk45"}, "rtol", (1e-2, 1e-4, 1e-6, 1e-8, 1e-10), (1e-12, 1e-10, 1e-8)
    ),
    "rk4": Method(
        {"method": "rk4"},
        "step",
        (2.5, 1.0, 0.5, 0.25, 0.125),
        (0.03125, 0.0625, 0.125, 0.25),
        "stability",
    ),
    "etdrk4": Method(
        {"method": "etdrk4"}, "step", (0.02, 0.01, 0.004, 0.002, 0.001), unit="passing"
    ),
    **{
        f"exponential, {stages} stages": Method(
            {"method": "exponential", "stages": stages},
            "step",
            (0.1, 0.04, 0.02, 0.01, 0.004),
            unit="passing",
        )
        for stages in (2, 4)
    },
}


@dataclass(frozen=True)
class Setting:
    """A method with a step [s] or a tolerance."""

    method: str
    value: float

    @property
    def options(self) -> dict[str, Any]:
        """The options of `simulate`."""
        method = METHODS[self.method]
        return {**method.options, method.control: self.value}

    def __str__(self) -> str:
        is_step = METHODS[self.method].control == "step"
        return f"{self.method}, " + (
            f"step {self.value:.3g} s" if is_step else f"rtol {self.value:.0e}"
        )


def ladders(
    system: System,
    speed: float,
    names: Sequence[str],
    steps: Sequence[float] | None,
    tolerances: Sequence[float] | None,
) -> list[Setting]:
    """Return the settings of a study, from loose to tight, with alternating methods."""
    columns = []
    for name in names:
        method = METHODS[name]
        given = steps if method.control == "step" else tolerances
        values = _values(system, speed, method, method.ladder) if given is None else list(given)
        columns.append([Setting(name, value) for value in sorted(values, reverse=True)])
    return _alternating(columns)


def references(system: System, speed: float) -> list[Setting]:
    """Return candidates for the reference run, the tightest first."""
    return _alternating(
        [Setting(name, value) for value in _values(system, speed, method, method.finest)]
        for name, method in METHODS.items()
    )


def _alternating(columns: Iterable[list[Setting]]) -> list[Setting]:
    """Return the first settings of all methods, then the second ones, and so on."""
    rows = zip_longest(*columns)
    return [setting for row in rows for setting in row if setting is not None]


def _values(system: System, speed: float, method: Method, ladder: Sequence[float]) -> list[float]:
    if method.control == "rtol":
        return list(ladder)
    if method.unit == "stability":
        unit = _stable_step(system, speed)
        # Three digits, so that the printed options are the options of the run.
        return [float(f"{unit * factor:.3g}") for factor in ladder]
    unit = _passing(system, speed)
    return [_round(unit * factor) for factor in ladder] if math.isfinite(unit) else []


def _round(value: float) -> float:
    """Round to 1, 2 or 5 times a power of ten, so that steps end at the output times."""
    power = math.floor(math.log10(value))
    return float(
        f"{min((1, 2, 5, 10), key=lambda digit: abs(digit - value / 10.0**power))}e{power}"
    )


def _stable_step(system: System, speed: float) -> float:
    """Return the default step of "rk4"."""
    omega = system.simulate(0.0, speed, method="rk4").statistics.omega_max
    few = system.simulate(10.0 / omega, speed, method="rk4", times=[0.0])
    return few.statistics.step_max


def _passing(system: System, speed: float) -> float:
    """Return the shortest period of a shaft rotation or tooth passing."""
    # The default output step is a twentieth of this period.
    return 20.0 * system.default_output_step(math.inf, speed)
