"""Result of one run: the signals over the last revolution of the slowest shaft, and their values.

All teeth of a gear are identical and the speed ratios are whole numbers. The steady motion
therefore repeats after one revolution of the slowest shaft. The mean is taken over this period, and
a difference between its start and its end is a remaining transient.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gearbow._types import Array
from gearbow.recording.channels import MESH, POINT
from gearbow.study.case import Case, system
from gearbow.study.settings import Settings

if TYPE_CHECKING:
    from gearbow.results.response import Response
    from gearbow.system import RotorSystem

__all__ = ["UNITS", "Measured", "measure", "signals"]

#: Unit of each recorded quantity.
UNITS = {**POINT, "radius": "m", **MESH, "line_of_action": "rad"}


@dataclass(frozen=True, eq=False)
class Measured:
    """Signals over one revolution of the slowest shaft."""

    turn: Array
    signals: dict[tuple[str, str], Array]
    events: tuple[str, ...]

    def mean(self, of: str, quantity: str) -> float:
        """Return the mean of a signal over the revolution."""
        return float(self.signals[of, quantity][:-1].mean())

    def peak_to_peak(self, of: str, quantity: str) -> float:
        """Return the peak-to-peak value of a signal over the revolution."""
        return float(np.ptp(self.signals[of, quantity]))

    def largest(self, of: str, quantity: str) -> float:
        """Return the largest value of a signal."""
        return float(self.signals[of, quantity].max())

    def smallest(self, of: str, quantity: str) -> float:
        """Return the smallest value of a signal."""
        return float(self.signals[of, quantity].min())

    def orbit(self, gear: str) -> float:
        """Return the peak-to-peak displacement of a gear, the larger one of v and w."""
        return max(self.peak_to_peak(gear, "v"), self.peak_to_peak(gear, "w"))

    def periodicity_error(self) -> float:
        """Return the difference between the end and the start of the revolution."""
        parts = [
            abs(float(values[-1] - values[0])) / float(np.ptp(values))
            for (_, quantity), values in self.signals.items()
            if quantity in {"v", "w", "force"} and np.ptp(values) > 0.0
        ]
        return max(parts, default=0.0)

    @property
    def always_in_contact(self) -> bool:
        """Whether the contact ratio of every mesh is above 1 at all times."""
        return all(
            values.min() > 1.0
            for (_, quantity), values in self.signals.items()
            if quantity == "contact_ratio"
        )

    def relative_difference(self, other: "Measured", of: str, quantities: tuple[str, ...]) -> float:
        """Return the relative difference between this run and a reference run."""
        mine = np.array([self.signals[of, quantity] for quantity in quantities])
        others = np.array([other.signals[of, quantity] for quantity in quantities])
        vibration = others - others.mean(axis=1, keepdims=True)
        difference, scale = (float(np.linalg.norm(each)) for each in (mine - others, vibration))
        return difference / scale if scale > 0.0 else (np.inf if difference > 0.0 else 0.0)


def measure(settings: Settings, case: Case) -> Measured:
    """Simulate a case and return the signals of its last revolution."""
    return signals(settings, system(settings, case), case)


def signals(settings: Settings, train: "RotorSystem", case: Case) -> Measured:
    """Simulate the system of a case and return the signals of its last revolution."""
    slowest = float(np.abs(train.speed_ratios).min())
    turn = 2.0 * np.pi / (case.speed * slowest)
    parts = np.linspace(0.0, 1.0, settings.samples + 1)
    begin = settings.settle * turn
    response = train.simulate(
        begin + turn,
        case.speed,
        # Rounding must not put the last output time after the end of the run.
        times=np.minimum(begin + parts * turn, begin + turn),
        accuracy=case.accuracy,
        geometry=case.geometry,
    )
    events = {
        f"{event.driver}/{event.driven} {event.kind}"
        for event in response.events
        if event.time >= begin
    }
    return Measured(parts, _signals(train, response), tuple(sorted(events)))


def _signals(train: "RotorSystem", response: "Response") -> dict[tuple[str, str], Array]:
    signals: dict[tuple[str, str], Array] = {}
    for gear in train.gears:
        motion = response.displacement(gear.name)
        signals[gear.name, "v"] = motion[:, 0]
        signals[gear.name, "w"] = motion[:, 1]
        signals[gear.name, "radius"] = np.hypot(*motion.T)
    names = [shaft.name for shaft in train.shafts]
    shafts = {gear.name: names.index(gear.shaft) for gear in train.gears}
    for mesh in train.meshes:
        there = response.mesh((mesh.driver, mesh.driven))
        name = f"{mesh.driver}/{mesh.driven}"
        for quantity in (
            "contact_ratio",
            "pressure_angle",
            "centre_distance",
            "centre_line_angle",
            "force",
        ):
            signals[name, quantity] = getattr(there, quantity)
        # The angle between the line of centres and the line of action is π/2 minus the pressure
        # angle, in the direction of rotation of the driver.
        sign = np.sign(train.speed_ratios[shafts[mesh.driver]])
        signals[name, "line_of_action"] = there.centre_line_angle + sign * (
            np.pi / 2.0 - there.pressure_angle
        )
    return signals
