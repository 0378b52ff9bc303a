"""Influence coefficients of trial runs beside those of the model."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._read_only import ReadOnly
from gearbow._result import Column, Figured, Written, in_degrees
from gearbow._types import Array, At, ComplexArray
from gearbow.description.places import place_label
from gearbow.identification.measurement import Measurement
from gearbow.units.speed import SpeedUnit, speed_factor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow.identification.result import Identification

#: Largest relative difference of the speeds of two runs that are compared. The vibration that both
#: share then cancels in their difference, unless the speed is that of a sharp resonance.
_SAME_SPEED = 0.01
#: Influence of a micrometre for each gram millimetre.
_WRITTEN = Written("µm/(g mm)", 1.0)


@dataclass(frozen=True, eq=False)
class TrialInfluence(Figured, ReadOnly):
    """Influence coefficients of trial runs, beside those of the identified model.

    A coefficient is the change of the 1× vibration of a probe for each unbalance in a plane. That
    of a trial run is its difference to a run without trial weight at the same speed.

    `plot` draws phase and amplitude of the coefficients against the speed: points of the trial
    runs with 95 % intervals and lines of the model, for each plane and probe.

    Parameters
    ----------
    planes : tuple of str or (str, float)
        Plane of the trial weight, for each of k coefficients.
    probes : tuple of str
        Label of the probe.
    speeds : ndarray, shape (k,)
        Speed of the trial run [rad/s].
    measured : ndarray, shape (k,)
        Complex coefficient of the trial run [m/(kg m)].
    model : ndarray, shape (k,)
        That of the model between the same speeds [m/(kg m)].
    half_widths : ndarray, shape (k,)
        Half width of the 95 % interval of each component of the measured one, which follows from
        the noise of both runs [m/(kg m)].
    speed_unit : {"rad/s", "rpm"}
        Unit of speeds in tables.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> found = gb.results.TrialInfluence(
    ...     ("disk",), ("probe",), np.array([100.0]), np.array([0.1 + 0j]), np.array([0.11 + 0j]),
    ...     np.array([0.02]),
    ... )
    >>> print(f"{abs(found.measured[0] - found.model[0]):.2f} m/(kg m)")
    0.01 m/(kg m)
    """

    planes: tuple[At, ...]
    probes: tuple[str, ...]
    speeds: Array
    measured: ComplexArray
    model: ComplexArray
    half_widths: Array
    speed_unit: SpeedUnit = "rad/s"

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import harmonic as figures  # noqa: PLC0415

        curves: dict[str, list[int]] = {}
        for i, (plane, probe) in enumerate(zip(self.planes, self.probes, strict=True)):
            curves.setdefault(f"{place_label(plane)} → {probe}", []).append(i)
        return figures.influence(
            {
                name: figures.Influence(
                    speed_factor() * self.speeds[own],
                    self.measured[own],
                    self.model[own],
                    self.half_widths[own],
                )
                for name, own in curves.items()
            },
            ax=ax,
        )

    def _heading(self) -> list[str]:
        return ["influence coefficients of trial runs and of the model"]

    def _columns(self) -> list[Column]:
        """Give a row for each plane, probe and speed."""
        unit = "m/(kg m)"
        return [
            Column("plane", [place_label(plane) for plane in self.planes]),
            Column("probe", list(self.probes)),
            Column("speed", self.speeds, "rad/s"),
            Column("trial run", np.abs(self.measured), unit, ".3g", _WRITTEN),
            Column("± trial run", self.half_widths, unit, ".2g", _WRITTEN),
            Column("angle of trial run", np.angle(self.measured), "rad", ".1f", in_degrees()),
            Column("model", np.abs(self.model), unit, ".3g", _WRITTEN),
            Column("angle of model", np.angle(self.model), "rad", ".1f", in_degrees()),
        ]


def trial_influence(found: "Identification[Any]", speed_unit: SpeedUnit) -> TrialInfluence | None:
    """Compare all runs with one trial weight with those without; None without such runs."""
    noise = {one.probe: value for one, value in zip(found.probes, found.noise, strict=True)}
    runs = list(zip(found.measurements, found.fitted, strict=True))
    rows = []
    for trial, fitted in runs:
        if len(trial.trial_weights) != 1:
            continue
        ((plane, weight),) = trial.trial_weights.items()
        for base, fitted_base in runs:
            if base.trial_weights:
                continue
            for i, j in _same_speeds(trial, base):
                for label in (each for each in trial.labels if each in base.labels):
                    at, at_base = trial.labels.index(label), base.labels.index(label)
                    measured = trial.amplitudes[i, at] - base.amplitudes[j, at_base]
                    model = fitted[i, at] - fitted_base[j, at_base]
                    if np.isfinite(measured) and trial.references[at] == base.references[at_base]:
                        scatter = np.sqrt(2.0) * found.factor * noise[label] / abs(weight)
                        speed = trial.speeds[i]
                        rows.append(
                            (plane, label, speed, measured / weight, model / weight, scatter)
                        )
    if not rows:
        return None
    planes, probes, *numbers = zip(*rows, strict=True)
    speeds, measured, model, scatter = map(np.array, numbers)
    return TrialInfluence(planes, probes, speeds, measured, model, scatter, speed_unit)


def _same_speeds(trial: Measurement, base: Measurement) -> list[tuple[int, int]]:
    """Give the rows of two runs whose speeds agree."""
    if (trial.speed_shaft, trial.phase_angle) != (base.speed_shaft, base.phase_angle):
        return []
    pairs = []
    for i, speed in enumerate(trial.speeds):
        j = int(np.argmin(np.abs(base.speeds - speed)))
        if abs(base.speeds[j] - speed) <= _SAME_SPEED * abs(speed):
            pairs.append((i, j))
    return pairs
