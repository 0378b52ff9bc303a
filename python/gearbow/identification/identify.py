"""`gearbow.identify`: bow, unbalance, run-out and parameters from measured 1× vibration."""

from collections.abc import Sequence
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, items, shown, truth
from gearbow._types import Array
from gearbow.analysis.protocol import S
from gearbow.description.layout import left_out
from gearbow.errors import AccuracyWarning, SceneError, warn
from gearbow.identification.fit import (
    WeightedFit,
    chi_squared_tail,
    component_groups,
    fit,
    inseparable,
    solve,
    student,
)
from gearbow.identification.measurement import Measurement
from gearbow.identification.responses import LinearModel, assembled, with_numbers
from gearbow.identification.result import Identification, ProbeResidual
from gearbow.identification.unknown import RunoutUnknown, Unknown, runout as unknown_runout
from gearbow.units.fields import unit_of
from gearbow.units.speed import in_given_unit

#: Amplitudes over the standard deviation that a test of 5 % finds in 95 %: the square is the
#: noncentrality 15.44 of χ² with two degrees of freedom, or (1.960 + 1.645)² with one.
_DETECTABLE = {2: 3.930, 1: 3.605}
#: Share of the residual below which phases with the opposite sign fit better than by chance.
_OPPOSITE = 0.5
#: Residual relative to the vibration that is round-off of an exact fit.
_ROUND_OFF = 1e-8
#: Standard deviations below the expectation at which the differences between neighbours say that a
#: residual is no noise: chance does this once in a thousand identifications.
_SMOOTH = NormalDist().inv_cdf(0.999)


@in_given_unit
def identify(
    system: S,
    measured: Measurement | Sequence[Measurement],
    unknowns: Sequence[Unknown],
    *,
    runout: bool = True,
    noise: "ArrayLike | None" = None,
) -> Identification[S]:
    """Find bow, unbalance, run-out and parameters of a system from measured 1× vibration.

    The 1× response is linear in bow, unbalance and run-out. Parameters are found by nonlinear least
    squares around it (variable projection), with differences of complete analyses as derivatives.

    Parameters
    ----------
    system : RotorSystem
        The system. Its bows and unbalances are known, except where they are unknowns.
    measured : Measurement or sequence of them
        Measured amplitudes: run-downs, and runs with trial weights.
    unknowns : sequence
        Made by `gearbow.unknown`. Each replaces the value in the system.
    runout : bool
        Whether every probe has an unknown run-out. If not, that of the probe is exact.
    noise : float or array_like, shape (probes,), optional
        Standard deviation of the real and of the imaginary part of a measured amplitude [m]; for
        each probe, in the order of the measurements. None estimates it from the residual.

    Returns
    -------
    Identification
        Estimates with 95 % intervals, what the data cannot separate, and residuals.

    Raises
    ------
    SceneError
        If an argument is invalid, or all measurements have one speed.
    ConvergenceError
        If the parameters do not converge.
    GearbowError
        If there are too few amplitudes to estimate the noise.

    Warns
    -----
    AccuracyWarning
        If phases of the opposite sign fit much better: the sense of rotation or the sign of the
        phases is probably wrong. If the noise is estimated, and residuals at neighbouring speeds
        are alike: the model does not describe the vibration, and the intervals are too small.

    Notes
    -----
    Noise differs from one speed to the next, but an error of the model changes little. Half the
    mean square of the differences between neighbours is therefore an estimate of the noise that
    needs no model; its ratio to the mean square has the expectation 1 and, for N numbers, the
    variance 1/N (J. von Neumann, *Distribution of the ratio of the mean square successive
    difference to the variance*, Ann. Math. Statist. 12, 1941). A ratio whose probability is below
    0.1 % causes the warning.

    G. H. Golub and V. Pereyra, *Separable nonlinear least squares: the variable projection method
    and its applications*, Inverse Problems 19 (2003).

    Examples
    --------
    >>> from dataclasses import replace
    >>> import numpy as np
    >>> import gearbow as gb
    >>> bent = gb.examples()["bowed_rotor"].load()
    >>> system = bent.replace(shafts=[replace(bent.shafts[0], bow=None)])
    >>> speeds = np.linspace(20.0, 200.0, 30)
    >>> vectors = bent.synchronous(speeds).displacement("disk")[:, 0, :1]
    >>> measured = gb.Measurement(speeds, vectors, [gb.Probe("rotor", 0.23)])
    >>> found = gb.identify(system, measured, [gb.unknown.bow("rotor")], noise=1e-6)
    >>> print(f"{1e6 * abs(found.values[0]):.1f} µm ± {1e6 * found.half_widths[0, 0]:.1f} µm")
    40.0 µm ± 1.5 µm
    """
    if not isinstance(system, _system_types()):
        raise SceneError(f"system: must be a gb.RotorSystem, got {shown(system)}")
    given = [measured] if isinstance(measured, Measurement) else items(measured, "measured", "data")
    for i, each in enumerate(given):
        if not isinstance(each, Measurement):
            raise SceneError(f"measured[{i}]: must be a gb.Measurement, got {shown(each)}")
    if not given:
        raise SceneError("measured: must have at least one measurement")
    wanted = items(unknowns, "unknowns", "what gb.unknown makes")
    listed = any(isinstance(each, RunoutUnknown) for each in wanted)
    subtracted = any(each.slow_roll is not None for each in given)
    if not truth(runout, "runout") and (listed or subtracted):
        reason = "unknowns contain it" if listed else "slow-roll amplitudes were subtracted"
        raise SceneError(f"runout: must not be False, because {reason}")
    if runout and not listed:
        wanted.append(unknown_runout())
    model = LinearModel.of(system, given, wanted)
    return result_of(system, model, given, _checked_noise(noise, len(model.channels)))


def _system_types() -> type:
    from gearbow.system.rotor_system import RotorSystem  # noqa: PLC0415  # it is defined later

    return RotorSystem


def _checked_noise(noise: ArrayLike | None, channels: int) -> Array | None:
    if noise is None:
        return None
    values = array(noise, "noise")
    if values.size not in (1, channels):
        raise SceneError(
            f"noise: must be one number, or one for each of {channels} probes, got {values.size}"
        )
    if not values.min() > 0.0:
        raise SceneError(f"noise: must be positive, got {values.min():g}")
    return values if values.size == channels else np.full(channels, values[0])


def result_of(
    system: S, model: LinearModel[S], given: Sequence[Measurement], noise: Array | None
) -> Identification[S]:
    """Fit a model, and describe the solution."""
    found = fit(model, noise)
    if not _warn_of_opposite_sense(model, found) and noise is None:
        _warn_of_smooth_residual(model, found)
    terms = len(model.terms)
    values = np.concatenate([found.values[0::2] + 1j * found.values[1::2], found.parameters])
    # The fit has logarithms of parameters.
    factors = np.concatenate([np.ones(2 * terms), found.parameters])
    covariance = found.covariance * np.outer(factors, factors)
    names = [term.name for term in model.terms] + [each.path for each in model.parameters]
    parts = [f"{part} of {term.name}" for term in model.terms for part in ("re", "im")]
    units = [term.unit for term in model.terms]
    units += [unit_of(each.path) or "1" for each in model.parameters]
    detectable = []
    for own in component_groups(model):
        block = covariance[np.ix_(own, own)]
        largest = np.inf if not np.isfinite(block).all() else np.linalg.eigvalsh(block)[-1]
        detectable.append(_DETECTABLE[len(own)] * np.sqrt(largest))
    fitted = [np.full(each.amplitudes.shape, np.nan, dtype=np.complex128) for each in given]
    for (m, i, j), amplitude in zip(model.cells.tolist(), found.fitted, strict=True):
        fitted[m][i, j] = amplitude
    identified = with_numbers(system, model.parameters, found.parameters.tolist())
    by_channel = np.zeros(len(model.channels))
    by_channel[model.channel] = found.noise
    return Identification(
        names=tuple(names),
        units=tuple(units),
        values=values,
        components=(*parts, *(each.path for each in model.parameters)),
        estimates=np.concatenate([found.values, found.parameters]),
        covariance=covariance,
        factor=student(found.noise_freedom),
        singular_values=found.singular_values,
        inseparable=inseparable(model, names, found),
        detectable=np.array(detectable),
        noise=by_channel,
        noise_is_estimated=noise is None,
        probes=_residuals(model, found),
        measurements=tuple(given),
        fitted=tuple(fitted),
        system=assembled(identified, model, values[:terms].tolist()),
        left_out=left_out(system),
        _model=model,
    )


def _residuals(model: LinearModel[Any], found: WeightedFit) -> tuple[ProbeResidual, ...]:
    """Test the residual of each probe."""
    squares = np.abs(found.residual) ** 2
    free = 2.0 - found.leverage.reshape(2, -1).sum(axis=0)
    residuals = []
    for c, label in enumerate(model.labels):
        own = model.channel == c
        chi_squared = float((squares[own] / found.noise[own] ** 2).sum())
        freedom = float(free[own].sum())
        rms = float(np.sqrt(squares[own].mean() / 2.0))
        tail = chi_squared_tail(chi_squared, freedom)
        residuals.append(ProbeResidual(label, rms, chi_squared, freedom, tail))
    return tuple(residuals)


def _warn_of_opposite_sense(model: LinearModel[Any], found: WeightedFit) -> bool:
    """Warn if amplitudes with the opposite sign of the phase fit much better, and tell so."""
    target = np.conj(model.measured) - (found.fitted - found.of_terms)
    columns = found.derivative[:, : 2 * len(model.terms)]
    noise = np.concatenate([found.noise, found.noise])
    rows = np.concatenate([target.real, target.imag]) / noise
    solution = solve(columns, rows)
    if solution.rank == rows.size:
        return False  # as many unknowns as numbers fit anything
    opposite = float(np.linalg.norm(solution.remainder))
    own = float(np.linalg.norm(np.abs(found.residual) / found.noise))
    is_better = opposite < _OPPOSITE * own
    if is_better:
        warn(
            f"measured: with phases of the opposite sign, {100.0 * opposite / own:.2g} % of the "
            "residual remains: check whether phases are lags, and the sense of rotation (the sign "
            "of the speeds)",
            AccuracyWarning,
        )
    return is_better


def _warn_of_smooth_residual(model: LinearModel[Any], found: WeightedFit) -> None:
    """Warn if the residual is alike at neighbouring speeds, so that it is no noise."""
    differences, squares = [], []
    for m in np.unique(model.cells[:, 0]):
        for c in range(len(model.channels)):
            own = np.flatnonzero((model.cells[:, 0] == m) & (model.channel == c))
            values = found.residual[own[np.argsort(model.speed[own], kind="stable")]]
            differences.append(np.abs(np.diff(values)) ** 2 / 2.0)
            squares.append(np.abs(values) ** 2)
    between, total = np.concatenate(differences), np.concatenate(squares)
    least = _ROUND_OFF * float(np.abs(model.measured).max())
    if between.size == 0 or total.mean() <= least**2:
        return
    ratio = float(between.mean() / total.mean())
    # An amplitude is two numbers.
    if (1.0 - ratio) * np.sqrt(2 * between.size) > _SMOOTH:
        residual, scatter = (1e6 * np.sqrt(each.mean() / 2.0) for each in (total, between))
        warn(
            f"noise: the residual of {residual:.3g} µm is alike at neighbouring speeds, whose "
            f"differences show a noise of {scatter:.3g} µm: the model does not describe the "
            "vibration, and the intervals are too small; add unknowns, or give noise= at least the "
            "error of the model",
            AccuracyWarning,
        )
