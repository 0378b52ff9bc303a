"""Runs of the bow study: a sweep over its cases, and the values of one run.

All teeth of a gear are identical and the speed ratios are whole numbers. The steady motion
therefore repeats after one revolution of the slowest shaft. The mean is taken over this period, and
a difference between its start and its end is a remaining transient.
"""

import math
from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import gearbow as gb
from cases import Case, Settings, cases, train

#: Unit of each signal of a gear and of a mesh.
GEAR = {"v": "m", "w": "m"}
MESH = {
    "contact_ratio": "1",
    "pressure_angle": "rad",
    "centre_distance": "m",
    "line_of_action": "rad",
    "force": "N",
}

Array = NDArray[np.float64]


class Measured:
    """Signals over one revolution of the slowest shaft."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        self.turn: Array = values["turn"]
        self.events = str(values["events"])
        self._values = values

    def __getitem__(self, signal: tuple[str, str]) -> Array:
        """Return a signal of a gear or a mesh."""
        values: Array = self._values[" ".join(signal)]
        return values

    def mean(self, of: str, quantity: str) -> float:
        """Return the mean of a signal over the revolution."""
        return float(self[of, quantity][:-1].mean())

    def peak_to_peak(self, of: str, quantity: str) -> float:
        """Return the peak-to-peak value of a signal over the revolution."""
        return float(np.ptp(self[of, quantity]))

    def largest(self, of: str, quantity: str) -> float:
        """Return the largest value of a signal."""
        return float(self[of, quantity].max())

    def smallest(self, of: str, quantity: str) -> float:
        """Return the smallest value of a signal."""
        return float(self[of, quantity].min())

    def orbit(self, gear: str) -> float:
        """Return the peak-to-peak displacement of a gear, the larger one of v and w."""
        return max(self.peak_to_peak(gear, "v"), self.peak_to_peak(gear, "w"))

    def periodicity_error(self) -> float:
        """Return the difference between the end and the start of the revolution."""
        signals = (self[signal] for signal in self.signals if signal[1] in {"v", "w", "force"})
        parts = [abs(float(x[-1] - x[0])) / float(np.ptp(x)) for x in signals if np.ptp(x) > 0.0]
        return max(parts, default=0.0)

    @property
    def always_in_contact(self) -> bool:
        """Whether the contact ratio of every mesh is above 1 at all times."""
        return all(
            self[of, name].min() > 1.0 for of, name in self.signals if name == "contact_ratio"
        )

    def relative_difference(self, other: "Measured", of: str, quantities: tuple[str, ...]) -> float:
        """Return the relative difference between this run and a reference run."""
        mine = np.array([self[of, quantity] for quantity in quantities])
        others = np.array([other[of, quantity] for quantity in quantities])
        vibration = others - others.mean(axis=1, keepdims=True)
        difference, scale = (float(np.linalg.norm(each)) for each in (mine - others, vibration))
        return difference / scale if scale > 0.0 else (np.inf if difference > 0.0 else 0.0)

    @property
    def signals(self) -> list[tuple[str, str]]:
        """List the signals as pairs of a gear or a mesh and a quantity."""
        named = (name.split(" ") for name in self._values if " " in name)
        return [(of, quantity) for of, quantity in named]


@dataclass(frozen=True)
class Teeth:
    """Dimensions of a mesh at rest, of full-depth teeth without profile shift [m, rad]."""

    centre_distance: float
    pressure_angle: float
    base_pitch: float
    tip_clearance: float

    @classmethod
    def of(cls, driver: gb.Gear, driven: gb.Gear) -> "Teeth":
        """Return the dimensions of two gears."""
        module, angle = driver.module, driver.pressure_angle
        assert module is not None
        first, second = (module * gear.teeth / 2.0 for gear in (driver, driven))
        return cls(
            centre_distance=first + second,
            pressure_angle=angle,
            base_pitch=math.pi * module * math.cos(angle),
            tip_clearance=0.25 * module,
        )


class Study:
    """Settings and results of a study, with the cases that tables and figures use."""

    def __init__(self, settings: Settings, results: Mapping[Case, Measured], folder: Path) -> None:
        self.settings = settings
        self.results = results
        self.folder = folder  # of the stores
        self.shafts = [shaft.name for shaft in settings.train.shafts]
        self.gears = {gear.name: gear for gear in settings.train.gears}
        self.teeth = {
            f"{mesh.driver}/{mesh.driven}": Teeth.of(
                self.gears[mesh.driver], self.gears[mesh.driven]
            )
            for mesh in settings.train.meshes
        }
        self.pairs = list(self.teeth)
        self.bows = [bow for bow in settings.bows if bow]
        self.base = settings.base
        self.bent = replace(self.base, bow=settings.phase_bow)

    def __getitem__(self, case: Case) -> Measured:
        # A case without bow does not depend on the shaft that the bow is on.
        return self.results[case if case.bow else replace(case, where=Case.where)]


def run(
    settings: Settings, folder: Path, executor: Executor | None = None, *, progress: bool = False
) -> Study:
    """Make all runs of a study that the store in the folder lacks."""
    folder.mkdir(parents=True, exist_ok=True)
    wanted = cases(settings)
    found = swept(
        partial(make, settings.train, settings.layouts),
        [asdict(case) for case in wanted],
        partial(measure, settings.samples, settings.settle),
        executor,
        folder / "runs.sweep",
        progress,
    )
    measured = (Measured(point.values or {}) for point in found)
    return Study(settings, dict(zip(wanted, measured, strict=True)), folder)


def swept(*arguments: Any) -> gb.Sweep:
    """Return a sweep without failed points."""
    found = gb.sweep(*arguments)
    if found.failed:
        point = found.failed[0]
        raise gb.GearbowError(
            f"{len(found.failed)} of {len(found)} runs failed; that of {dict(point.parameters)}: "
            f"{point.error}"
        )
    return found


def make(
    straight: gb.RotorSystem, layouts: Mapping[str, Mapping[str, float]], **parameters: Any
) -> gb.RotorSystem:
    """Make the system of a case."""
    return train(Settings(straight, layouts), Case(**parameters))


def measure(
    samples: int, settle: int, system: gb.RotorSystem, **parameters: Any
) -> dict[str, Array | str]:
    """Simulate a case and return the signals of its last revolution."""
    case = Case(**parameters)
    ratios = dict(zip((shaft.name for shaft in system.shafts), system.speed_ratios, strict=True))
    turn = 2.0 * np.pi / (case.speed * min(map(abs, ratios.values())))
    parts = np.linspace(0.0, 1.0, samples + 1)
    begin = settle * turn
    response = system.simulate(
        begin + turn,
        case.speed,
        # Rounding must not put the last output time after the end of the run.
        times=np.minimum(begin + parts * turn, begin + turn),
        geometry=case.geometry,
    )
    events = {f"{e.driver}/{e.driven} {e.kind}" for e in response.events if e.time >= begin}
    values: dict[str, Array | str] = {"turn": parts, "events": ", ".join(sorted(events))}
    for gear in system.gears:
        values[f"{gear.name} v"], values[f"{gear.name} w"] = response.displacement(gear.name).T
    shafts = {gear.name: gear.shaft for gear in system.gears}
    for mesh in system.meshes:
        there = response.mesh((mesh.driver, mesh.driven))
        # The angle between the line of centres and the line of action is π/2 minus the pressure
        # angle, in the direction of rotation of the driver.
        sign = np.sign(ratios[shafts[mesh.driver]])
        line = there.centre_line_angle + sign * (np.pi / 2.0 - there.pressure_angle)
        for quantity in MESH:
            own = line if quantity == "line_of_action" else getattr(there, quantity)
            values[f"{mesh.driver}/{mesh.driven} {quantity}"] = own
    return values
