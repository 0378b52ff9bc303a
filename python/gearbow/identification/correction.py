"""Balancing weights for an identified system, the residual that they will leave, and trial runs."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array
from gearbow._result import Column, Figured, WithSpeeds, Written, in_degrees
from gearbow._shown import ReadOnly, listed
from gearbow._types import Array, At, ComplexArray
from gearbow.analysis.balance import Balance, balance, shaft_of_planes, with_unbalances
from gearbow.analysis.protocol import S
from gearbow.description.places import place_label, places
from gearbow.errors import GearbowError, SceneError
from gearbow.identification.fit import RELATIVE_STEP
from gearbow.identification.measurement import Measurement
from gearbow.identification.responses import assembled
from gearbow.results.synchronous import Synchronous, semi_axes
from gearbow.units.speed import shown_unit, speed_factor, speed_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow.identification.result import Identification

#: Samples of the estimates, with a fixed seed: they give limits of 95 % within 0.7 %.
_SAMPLES = 4000
#: Largest relative difference of the speeds of two runs that are compared. The vibration that both
#: share then cancels in their difference, unless the speed is that of a sharp resonance.
_SAME_SPEED = 0.01
#: Unit of influence coefficients in tables: displacement per unbalance. One is 1 m/(kg m).
_WRITTEN = Written("µm/(g mm)", 1.0)


@dataclass(frozen=True, eq=False)
class TrialInfluence(WithSpeeds, Figured, ReadOnly):
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
    measured, model : ndarray, shape (k,)
        Complex coefficients of the trial run and of the model between the same speeds [m/(kg m)].
    half_widths : ndarray, shape (k,)
        Half width of the 95 % interval of each measured component by the noise [m/(kg m)].

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


@dataclass(frozen=True, eq=False)
class Correction(WithSpeeds, Figured, ReadOnly, Generic[S]):
    """Balancing weights and the vibration that they leave.

    `plot` draws the major semi-axis of the orbits at the points before and after the
    correction, in one panel for each speed.

    Parameters
    ----------
    planes : tuple of str or (str, float)
        Gears, disks or (shaft, position [m]).
    unbalances : ndarray, shape (planes,)
        Complex unbalance to add in each plane [kg m]; its argument is the angle in the shaft.
    half_widths : ndarray, shape (planes, 2)
        Half width of the 95 % interval of amplitude [kg m] and angle [rad] of each.
    speeds : ndarray, shape (speeds,)
        Balancing speeds of the reference shaft [rad/s].
    points : tuple of str or (str, float)
        Where the vibration is small.
    before : ndarray, shape (speeds, points)
        Major semi-axis of the orbit without the weights [m].
    remaining : ndarray, shape (speeds, points)
        Semi-axis with the weights, for the estimates themselves: what no weights in these planes
        can remove at all speeds and points together [m].
    lower : ndarray, shape (speeds, points)
        Lower limit of the 95 % interval of the semi-axis with the weights [m].
    upper : ndarray, shape (speeds, points)
        Upper limit [m]; infinite if a component that the data do not determine has an influence.
    interval : tuple of (float, float)
        The 95 % interval of the RMS of the semi-axes with the weights over all speeds and points
        [m]. It contains the uncertainty of the estimates.
    influence : ndarray, shape (speeds, points, 2, planes)
        Influence coefficients of the model: amplitudes along y and z per unbalance [m/(kg m)].
    system : RotorSystem
        The identified system with the weights.
    trials : TrialInfluence, optional
        Influence coefficients of trial runs with one weight each, beside the model; None without.
    left_out : tuple of str
        Excitations of the system that the model of the vibration does not contain.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> measured = gb.Measurement([10.0, 200.0], [[50e-6], [85e-6]], [gb.Probe("rotor", 0.23)])
    >>> found = gb.identify(system, measured, [gb.unknown.bow("rotor")], runout=False, noise=1e-6)
    >>> weights = found.balance("disk", 200.0)
    >>> weights.remaining_share < 0.01
    True
    """

    planes: tuple[At, ...]
    unbalances: ComplexArray
    half_widths: Array
    speeds: Array
    points: tuple[At, ...]
    before: Array
    remaining: Array
    lower: Array
    upper: Array
    interval: tuple[float, float]
    influence: ComplexArray
    system: S = field(repr=False)
    trials: TrialInfluence | None = field(repr=False, default=None)
    left_out: tuple[str, ...] = ()

    @property
    def remaining_share(self) -> float:
        """Share of the vibration that no weights in these planes can remove.

        It is the RMS value of `remaining` divided by the RMS value of `before`.
        """
        before = float(np.linalg.norm(self.before))
        return float(np.linalg.norm(self.remaining)) / before if before > 0.0 else 0.0

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import analyses as figures  # noqa: PLC0415

        return figures.balance(
            [speed_text(speed) for speed in self.speeds],
            [place_label(point) for point in self.points],
            self.before,
            self.remaining,
            label="semi-axis [µm]",
            limits=(self.lower, self.upper),
            ax=ax,
        )

    def _heading(self) -> list[str]:
        speeds = listed(speed_factor() * self.speeds)
        before, low, high = (1e6 * x for x in (_rms(self.before), *self.interval))
        share = f"{100.0 * self.remaining_share:.2g} %"
        change = f"from {before:.3g} µm RMS to between {low:.3g} and {high:.3g} µm"
        rest = f"no weights in these planes can remove {share} of it"
        return [f"balance at {speeds} {shown_unit()}: {change}; {rest}"]

    def _remarks(self) -> list[str]:
        if self.trials is None:
            return []
        moved = np.abs(self.trials.measured - self.trials.model) > self.trials.half_widths
        text = (
            f"{moved.sum()} of {moved.size} influence coefficients of trial runs differ from those "
            "of the model by more than the noise explains in 95 %: see .trials"
        )
        return [text]

    def _columns(self) -> list[Column]:
        """Give a row for each plane."""
        grams = Written("g mm", 1e6)
        return [
            Column("plane", [place_label(plane) for plane in self.planes]),
            Column("unbalance", np.abs(self.unbalances), "kg m", ".4g", grams),
            Column("± unbalance", self.half_widths[:, 0], "kg m", ".2g", grams),
            Column("angle", np.angle(self.unbalances), "rad", ".1f", in_degrees()),
            Column("± angle", self.half_widths[:, 1], "rad", ".1f", in_degrees()),
        ]


def correct(
    found: "Identification[S]",
    planes: At | Sequence[At],
    speeds: "ArrayLike",
    points: At | Sequence[At] | None,
) -> Correction[S]:
    """Find the weights, and carry the covariance of the estimates to weights and residual."""
    model = found._model
    if model is None:
        raise GearbowError("balance: this identification has no model; identify again")
    wanted = array(speeds, "speeds")
    if not wanted.all():
        raise SceneError("speeds: must not be zero, where a weight has no effect")
    shaft = shaft_of_planes(found.system, places(planes, "planes"))
    chosen = places(_probe_places(found, shaft) if points is None else points, "points")
    nodes: dict[At, complex] = {point: 0.0 for point in chosen if isinstance(point, tuple)}
    correction = balance(with_unbalances(found.system, nodes), planes, wanted, points=chosen)
    base = with_unbalances(
        model.with_parameters(found.values[len(model.terms) :].real.tolist()),
        dict.fromkeys([*correction.points, *correction.planes], 0.0),
    )

    def read(response: Synchronous, shafts: Sequence[str], turn: complex) -> ComplexArray:
        """Read the displacements that the shaft of the planes causes."""
        if shaft not in shafts:
            return np.zeros((correction.speeds.size, len(correction.points), 2), np.complex128)
        return turn * _read(response, shaft, correction.points)

    _, units = model.responses(base, correction.speeds, read)
    columns = np.zeros((correction.residual.size, len(found.components)), dtype=np.complex128)
    for j, unit in units.items():
        if j < len(model.terms):
            columns[:, 2 * j : 2 * j + 2] = unit.reshape(-1, 2)
    for i in range(len(model.parameters)):
        columns[:, 2 * len(model.terms) + i] = _by_parameter(found, correction, i).ravel()
    return _with_limits(found, correction, columns)


def _probe_places(found: "Identification[S]", shaft: str) -> list[At]:
    """Give the places of the probes beside a shaft."""
    beside: list[At] = [
        (probe.shaft, probe.position)
        for each in found.measurements
        for probe in each.probes
        if probe.shaft == shaft
    ]
    if not beside:
        raise SceneError(f"points: no probe is beside {shaft}; give the points")
    return list(dict.fromkeys(beside))


def _read(response: Synchronous, shaft: str, points: Sequence[At]) -> ComplexArray:
    source = response.shafts.index(shaft)
    return np.stack([response.displacement(point)[:, source] for point in points], axis=1)


def _by_parameter(found: "Identification[S]", correction: Balance[S], index: int) -> ComplexArray:
    """Differentiate the residual by a parameter, with the weights as they are."""
    model = found._model
    assert model is not None
    terms = len(model.terms)
    values = found.values[terms:].real.copy()
    step = RELATIVE_STEP * values[index]
    weights = dict(zip(correction.planes, correction.unbalances.tolist(), strict=True))
    sides = []
    for sign in (1.0, -1.0):
        moved = values.copy()
        moved[index] += sign * step
        system = assembled(
            model.with_parameters(moved.tolist()), model, found.values[:terms].tolist()
        )
        nodes: dict[At, complex] = dict.fromkeys(correction.points, 0.0)
        balanced = with_unbalances(system, {**nodes, **weights})
        response = balanced.synchronous(correction.speeds)
        sides.append(_read(response, correction.shaft, correction.points))
    slope: ComplexArray = (sides[0] - sides[1]) / (2.0 * step)
    return slope


def _with_limits(
    found: "Identification[S]", correction: Balance[S], columns: ComplexArray
) -> Correction[S]:
    """Sample the estimates to find the limits of the residual."""
    influences = columns.any(axis=0)
    known = np.isfinite(np.diag(found.covariance))
    used = influences & known
    covariance = found.covariance[np.ix_(used, used)]
    sizes, vectors = np.linalg.eigh(covariance / np.outer(*[_deviations(covariance)] * 2))
    # The symmetric square root does not depend on the choice of eigenvectors of equal eigenvalues.
    symmetric = (vectors * np.sqrt(np.maximum(sizes, 0.0))) @ vectors.T
    root = _deviations(covariance)[:, None] * symmetric
    numbers = np.random.default_rng(0).standard_normal((root.shape[1], _SAMPLES))
    shape = correction.residual.shape
    changes = ((columns[:, used] @ root) @ numbers).T.reshape(-1, *shape)
    sampled = semi_axes(correction.residual + changes)
    lower, upper = np.percentile(sampled, [2.5, 97.5], axis=0)
    low, high = np.percentile(np.sqrt((sampled**2).mean(axis=(1, 2))), [2.5, 97.5])
    if (influences & ~known).any():
        upper, high = np.full_like(upper, np.inf), np.inf
    table = correction.influence.reshape(-1, len(correction.planes))
    weights = -np.linalg.pinv(table) @ columns[:, used] @ root
    half = np.empty((len(correction.planes), 2))
    for i, (value, row) in enumerate(zip(correction.unbalances, weights, strict=True)):
        turned = row * np.conj(value / abs(value) if value else 1.0)
        along, across = (found.factor * np.linalg.norm(x) for x in (turned.real, turned.imag))
        half[i] = along, np.pi if across >= abs(value) else np.arcsin(across / abs(value))
    return Correction(
        planes=correction.planes,
        unbalances=correction.unbalances,
        half_widths=half,
        speeds=correction.speeds,
        points=correction.points,
        before=semi_axes(correction.before),
        remaining=semi_axes(correction.residual),
        lower=lower,
        upper=upper,
        interval=(float(low), float(high)),
        influence=correction.influence,
        system=with_unbalances(
            found.system,
            dict(zip(correction.planes, correction.unbalances.tolist(), strict=True)),
        ),
        left_out=found.left_out,
        trials=trial_influence(found),
    )


def _deviations(covariance: Array) -> Array:
    deviations: Array = np.sqrt(np.diag(covariance))
    return deviations


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def trial_influence(found: "Identification[Any]") -> TrialInfluence | None:
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
    return TrialInfluence(planes, probes, speeds, measured, model, scatter)


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
