"""The machines of the package: scene, size, rated speed, and the warnings and refusals of each analysis.

A machine is a scene file whose header names the rated speed. A new file is a new row of the test matrix; it needs an entry in
`WARNINGS` or `REFUSALS` only if an analysis warns or is refused.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import gearbow as gb

#: The list of machines; `gb.examples` gives their files.
FOLDER = Path(__file__).parents[2] / "examples" / "machines"

_ACCURACY = (gb.AccuracyWarning, r"accuracy: \d+ modes leave an error of")
#: Category and beginning of each warning of (machine, analysis at a sense of rotation). Every other warning is an error.
WARNINGS: dict[tuple[str, str], tuple[tuple[type[Warning], str], ...]] = {}
#: Category and beginning of warnings of (machines, analyses) that depend on the length of a run; regular expressions.
POSSIBLE: dict[tuple[str, str], tuple[type[Warning], str]] = {
    # Short runs contain little but a transient.
    (
        "coaxial_reducer|helical_gear|idler_train",
        "changing|many|orders|run up|sensors|waterfall",
    ): _ACCURACY,
    # The transient of a run is no order.
    (".*", "orders"): (gb.AccuracyWarning, r"orders: \d+ % of the RMS"),
}

#: Error and beginning of its message of (machine, analysis at a sense of rotation), where an analysis is refused.
REFUSALS: dict[tuple[str, str], tuple[type[Exception], str]] = {
    # A branch needs a common period, which rolling elements do not have.
    **{
        (name, "branch +"): (
            gb.SceneError,
            "period: (the common period of the excitation|the frequencies have no common period)",
        )
        for name in (
            *("coaxial_reducer", "dual_rotor", "gearbox", "helical_gear", "idler_train"),
            *("spindle_drive", "tapered_reducer"),
        )
    },
}


#: Error and message of a machine that turns against its bearings.
OTHER_SENSE = (
    gb.SceneError,
    r"bearings\[\d+\]: no static equilibrium at -[\d.]+ rad/s: its film narrows in the other direction of rotation",
)


def turns_one_way(bearing: Any) -> bool:
    """Tell whether the film of a bearing narrows in one sense of rotation only."""
    return getattr(bearing, "profile", None) == "offset" and bearing.offset is None


@dataclass(eq=False)
class Machine:
    """One machine, with the results that its tests share."""

    name: str
    results: dict[str, Any] = field(default_factory=dict)

    @property
    def path(self) -> Path:
        return gb.examples()[self.name].path

    @property
    def speed(self) -> float:
        """Rated speed of the reference shaft [rad/s], from the header of the file."""
        return float(gb.examples()[self.name].speed)

    @cached_property
    def system(self) -> gb.RotorSystem:
        return gb.RotorSystem.load(self.path)

    def result(
        self, analysis: str, sense: int, compute: Callable[[gb.RotorSystem, float], Any]
    ) -> Any:
        """Return the result of an analysis at the rated speed in a sense of rotation, and check its warnings."""
        key = f"{analysis} {'+' if sense > 0 else '-'}"
        if key not in self.results:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                self.results[key] = compute(self.system, sense * self.speed)
            possible = [
                warning
                for (names, analyses), warning in POSSIBLE.items()
                if re.fullmatch(names, self.name) and re.fullmatch(analyses, analysis)
            ]
            check_warnings(caught, WARNINGS.get((self.name, key), ()), possible)
        return self.results[key]

    @cached_property
    def senses(self) -> tuple[int, ...]:
        """Senses of rotation that its bearings are made for."""
        return (1,) if any(turns_one_way(each) for each in self.system.bearings) else (1, -1)

    def refusal(self, analysis: str, sense: int) -> tuple[type[Exception], str] | None:
        if sense not in self.senses:
            return OTHER_SENSE
        return REFUSALS.get((self.name, f"{analysis} {'+' if sense > 0 else '-'}"))


def check_warnings(
    caught: list[warnings.WarningMessage],
    expected: Iterable[tuple[type[Warning], str]],
    possible: Iterable[tuple[type[Warning], str]] = (),
) -> None:
    """Require each expected warning, and no other but the possible ones."""

    def matches(warning: warnings.WarningMessage, one: tuple[type[Warning], str]) -> bool:
        return issubclass(warning.category, one[0]) and bool(re.match(one[1], str(warning.message)))

    left = list(expected)
    for each in caught:
        match = next((one for one in left if matches(each, one)), None)
        if match is not None:
            left.remove(match)
            continue
        known = any(matches(each, one) for one in possible)
        assert known, f"unexpected {each.category.__name__}: {each.message}"
    assert not left, f"no warning: {left}"


def rows_of_list() -> list[list[str]]:
    """Return the cells of each row of the list of machines."""
    lines = (FOLDER / "README.md").read_text("utf-8").splitlines()
    return [
        [cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("| [")
    ]


MACHINES = tuple(gb.examples())
#: Number of degrees of freedom of each machine, from the list of machines.
SIZES = {row[0].split(".toml")[0].strip("["): int(row[1]) for row in rows_of_list()}
