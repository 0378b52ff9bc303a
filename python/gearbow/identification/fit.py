"""Weighted least squares with linear unknowns inside and parameters outside.

Variable projection: for given parameters, QR decomposition finds the linear unknowns; SciPy finds
the parameters with the projected residual (G. H. Golub and V. Pereyra, *SIAM J. Numer. Anal.* 10,
1973) and the derivative of L. Kaufman (*BIT* 15, 1975). Complex amplitudes are pairs of real
numbers. A Gaussian prior is one more row. Combinations that the data cannot separate are named in
words.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np

from gearbow._extras import extra
from gearbow._types import Array, ComplexArray
from gearbow.description.layout import ratios_by_shaft
from gearbow.errors import ConvergenceError, GearbowError
from gearbow.identification.responses import LinearModel

#: Relative step of the differences by parameters: central differences of responses with 1e-11 of
#: round-off have the smallest error near the cube root of it.
RELATIVE_STEP = 2e-4
#: Smallest singular value of a combination that the data see: its 95 % interval does not contain
#: values that alone would explain the whole vibration.
UNSEEN = NormalDist().inv_cdf(0.975)
#: Logarithms of factors by which each parameter is varied for the best start: up to a factor of 4.
_SCAN = np.linspace(-1.4, 1.4, 9)
#: Rounds of noise and fit where the noise is estimated and priors need it.
_ROUNDS = 4


@dataclass(frozen=True, eq=False)
class Solution:
    """A weighted linear least-squares solution."""

    values: Array
    remainder: Array
    rank: int
    orthogonal: Array


@dataclass(frozen=True, eq=False)
class _Weights:
    """Noise of each row [m], and 1/σ of the priors of components and of relative parameters."""

    noise: Array
    terms: Array
    parameters: Array


@dataclass(frozen=True, eq=False)
class WeightedFit:
    """Estimates of terms (re, im) and parameters; `derivative` is by their logarithms."""

    values: Array
    parameters: Array
    derivative: Array
    fitted: ComplexArray
    of_terms: ComplexArray
    residual: ComplexArray
    noise: Array
    noise_freedom: float
    #: Size of each component that alone causes the largest measured amplitude.
    scale: Array
    singular_values: Array
    directions: Array
    covariance: Array
    leverage: Array


def fit(model: LinearModel[Any], noise: float | Array | None) -> WeightedFit:
    """Fit all unknowns to the measured rows."""
    starts = np.array(model.starts())
    logarithms = np.zeros(starts.size)
    deviations = np.ones(model.channel.size) if noise is None else _by_row(model, noise)
    has_priors = any(t.prior for t in model.terms) or any(p.prior for p in model.parameters)
    freedom = np.inf
    rounds = 1 if noise is not None else _ROUNDS if has_priors else 2
    for number in range(rounds):
        # The first estimate of the noise cannot weigh priors.
        weights = _weights(model, deviations, active=noise is not None or number > 0)
        if starts.size:
            logarithms = _search(model, starts, logarithms, weights)
        if noise is not None:
            break
        known, columns = _evaluate(model, starts, logarithms)
        matrix, target = weighted(columns, model.measured - known, deviations)
        solution = solve(*_with_priors(matrix, target, weights.terms))
        free = 2 * model.channel.size - solution.rank - starts.size
        if free < 1:
            raise GearbowError(
                f"noise: {2 * model.channel.size} measured numbers do not give the noise beside "
                f"{solution.rank + starts.size} unknowns; give noise= or more speeds"
            )
        rows = matrix @ solution.values - target
        deviations = deviations * max(float(np.sqrt(rows @ rows / free)), _smallest(model))
        freedom = float(free)
    weights = _weights(model, deviations, active=True)
    return _finish(model, starts, logarithms, weights, freedom)


def _smallest(model: LinearModel[Any]) -> float:
    """Give the round-off of the measured amplitudes, relative to a unit of noise."""
    return float(np.finfo(np.float64).eps * np.abs(model.measured).max())


def solve(matrix: Array, target: Array) -> Solution:
    """Solve a least-squares problem; components without influence are zero."""
    norms = np.linalg.norm(matrix, axis=0)
    norms[norms == 0.0] = 1.0
    orthogonal, triangle = np.linalg.qr(matrix / norms)
    left, sizes, right = np.linalg.svd(triangle, full_matrices=False)
    kept = sizes > max(matrix.shape) * np.finfo(np.float64).eps * sizes.max(initial=0.0)
    basis = orthogonal @ left[:, kept]
    inside = basis.T @ target
    values = (right[kept].T @ (inside / sizes[kept])) / norms
    return Solution(values, target - basis @ inside, int(kept.sum()), basis)


def weighted(columns: ComplexArray, target: ComplexArray, noise: Array) -> tuple[Array, Array]:
    """Make real rows of complex ones, divided by the noise: all real parts, then the others."""
    flat = columns.reshape(len(columns), -1)
    matrix = np.concatenate([flat.real / noise[:, None], flat.imag / noise[:, None]])
    return matrix, np.concatenate([target.real / noise, target.imag / noise])


def derivatives(
    model: LinearModel[Any],
    starts: Array,
    logarithms: Array,
    values: Array,
) -> ComplexArray:
    """Differentiate the rows by the logarithm of each parameter, by central differences."""
    found = np.zeros((model.channel.size, starts.size), dtype=np.complex128)
    for i in range(starts.size):
        sides = []
        for sign in (1.0, -1.0):
            moved = logarithms.copy()
            moved[i] += sign * RELATIVE_STEP
            known, columns = _evaluate(model, starts, moved)
            sides.append(known + columns.reshape(len(columns), -1) @ values)
        found[:, i] = (sides[0] - sides[1]) / (2.0 * RELATIVE_STEP)
    return found


def _evaluate(
    model: LinearModel[Any],
    starts: Array,
    logarithms: Array,
) -> tuple[ComplexArray, ComplexArray]:
    return model.rows((starts * np.exp(logarithms)).tolist())


def _by_row(model: LinearModel[Any], noise: float | Array) -> Array:
    """Give the standard deviation of a component of each row [m]."""
    values = np.broadcast_to(np.asarray(noise, dtype=np.float64), (len(model.channels),))
    by_row: Array = values[model.channel]
    return by_row


def _weights(model: LinearModel[Any], noise: Array, *, active: bool) -> _Weights:
    """Give the weights of rows, of components of terms and of relative parameters."""
    terms = np.repeat([1.0 / t.prior if t.prior else 0.0 for t in model.terms], 2)
    relative = np.array([1.0 / p.prior[1] if p.prior else 0.0 for p in model.parameters])
    return _Weights(noise, float(active) * terms, float(active) * relative)


def _with_priors(
    matrix: Array,
    target: Array,
    priors: Array,
) -> tuple[Array, Array]:
    """Add the rows of priors of the terms, with their weights."""
    chosen = np.flatnonzero(priors)
    rows = np.zeros((chosen.size, matrix.shape[1]))
    rows[np.arange(chosen.size), chosen] = priors[chosen]
    return np.concatenate([matrix, rows]), np.concatenate([target, np.zeros(chosen.size)])


def _search(
    model: LinearModel[Any],
    starts: Array,
    begin: Array,
    weights: _Weights,
) -> Array:
    """Find the parameters that minimise the projected residual."""
    with extra("identify"):
        from scipy.optimize import least_squares  # noqa: PLC0415

    def residual(logarithms: Array) -> Array:
        """Give what no linear unknowns explain, and the distance from the priors."""
        known, columns = _evaluate(model, starts, logarithms)
        rows = weighted(columns, model.measured - known, weights.noise)
        left = solve(*_with_priors(*rows, weights.terms)).remainder
        return np.concatenate([left, np.expm1(logarithms) * weights.parameters])

    def slope(logarithms: Array) -> Array:
        """Differentiate the residual, for linear unknowns that do not change."""
        known, columns = _evaluate(model, starts, logarithms)
        rows = weighted(columns, model.measured - known, weights.noise)
        solution = solve(*_with_priors(*rows, weights.terms))
        change, _ = weighted(
            derivatives(model, starts, logarithms, solution.values), known, weights.noise
        )
        lacking = solution.remainder.size - len(change)
        change = np.concatenate([change, np.zeros((lacking, starts.size))])
        projected = solution.orthogonal @ (solution.orthogonal.T @ change) - change
        return np.concatenate([projected, np.diag(np.exp(logarithms) * weights.parameters)])

    # Near resonances the residual has several minima.
    best = begin.copy()
    for i in range(starts.size):
        tried = [best + step * np.eye(starts.size)[i] for step in _SCAN]
        best = min(tried, key=lambda each: float(np.linalg.norm(residual(each))))
    found = least_squares(residual, best, jac=slope, x_scale="jac", xtol=1e-10, ftol=1e-12)
    if found.status <= 0:
        raise ConvergenceError(
            f"identify: the parameters did not converge within {found.nfev} steps; their values "
            f"are {(starts * np.exp(found.x)).tolist()}"
        )
    logarithms: Array = found.x
    return logarithms


def _finish(
    model: LinearModel[Any],
    starts: Array,
    logarithms: Array,
    weights: _Weights,
    freedom: float,
) -> WeightedFit:
    """Find covariance, singular values and leverage of all components at the solution."""
    noise = weights.noise
    known, columns = _evaluate(model, starts, logarithms)
    matrix, target = weighted(columns, model.measured - known, noise)
    solution = solve(*_with_priors(matrix, target, weights.terms))
    change = derivatives(model, starts, logarithms, solution.values)
    flat = np.concatenate([columns.reshape(len(columns), -1), change], axis=1)
    complete, _ = weighted(flat, target=model.measured, noise=noise)
    scale = _scales(flat, model.measured, starts.size)
    priors = np.concatenate([weights.terms, weights.parameters * np.exp(logarithms)])
    # The rows of priors, zero where there are none, give every direction.
    left, sizes, directions = np.linalg.svd(
        np.concatenate([complete * scale, np.diag(priors * scale)]), full_matrices=False
    )
    kept = sizes > complete.shape[0] * np.finfo(np.float64).eps * sizes.max(initial=0.0)
    inverse = directions[kept].T / sizes[kept]
    root = scale[:, None] * inverse
    covariance = root @ root.T
    lost = (directions[~kept] ** 2).sum(axis=0) > np.finfo(np.float64).eps
    covariance[np.diag_indices_from(covariance)] += np.where(lost, np.inf, 0.0)
    values = _smallest_values(solution.values, scale, directions[sizes < UNSEEN])
    of_terms = columns.reshape(len(columns), -1) @ values
    fitted = known + of_terms
    basis = left[: complete.shape[0], kept]
    return WeightedFit(
        values=values,
        parameters=starts * np.exp(logarithms),
        derivative=complete,
        fitted=fitted,
        of_terms=of_terms,
        residual=model.measured - fitted,
        noise=noise,
        noise_freedom=freedom,
        scale=scale,
        singular_values=sizes,
        directions=directions,
        covariance=covariance,
        leverage=(basis**2).sum(axis=1),
    )


def _smallest_values(values: Array, scale: Array, unseen: Array) -> Array:
    """Take out of the terms what the data do not see: noise would make it arbitrarily large."""
    directions = unseen[:, : values.size]
    scaled = values / scale[: values.size]
    seen: Array = scaled - np.linalg.pinv(directions) @ (directions @ scaled)
    return seen * scale[: values.size]


def _scales(columns: ComplexArray, measured: ComplexArray, parameters: int) -> Array:
    """Give the size of each component that alone causes the largest measured amplitude."""
    largest = np.abs(columns).max(axis=0, initial=0.0)
    size = float(np.abs(measured).max())
    # Components without any influence have no such size.
    scale = np.divide(size, largest, out=np.ones_like(largest), where=largest > 0.0)
    if parameters:
        # A change by more than the value itself means nothing.
        scale[-parameters:] = np.minimum(scale[-parameters:], 1.0)
    found: Array = scale
    return found


def student(freedom: float) -> float:
    """Give the factor of a 95 % interval with estimated noise (Abramowitz and Stegun, 26.7.5)."""
    z = NormalDist().inv_cdf(0.975)
    if np.isinf(freedom):
        return z
    first, second = (z**3 + z) / 4.0, (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
    return z + first / freedom + second / freedom**2


def chi_squared_tail(value: float, freedom: float) -> float:
    """Give the probability of a larger χ² (Wilson and Hilferty, *PNAS* 17, 1931)."""
    # Leverages have round-off: a fit with as many unknowns as numbers leaves no freedom.
    if freedom <= np.sqrt(np.finfo(np.float64).eps):
        return float("nan")
    spread = 2.0 / (9.0 * freedom)
    return 1.0 - NormalDist().cdf(((value / freedom) ** (1.0 / 3.0) - (1.0 - spread)) / spread**0.5)


#: Smallest share of an unknown, or of a link of two unknowns, in a combination that is named.
_NAMED_SHARE = 0.05
#: Largest ratio of a speed to the first natural frequency at which the response to a bow is
#: nearly that of a run-out.
_LOW_SPEED = 0.7
#: Largest deviation of a factor from 1 or −1 that is called a sum or a difference.
_NEARLY_ONE = 0.05
#: Share of the variance of another unknown above which it shares the doubt of a combination.
_SHARED = 0.5


def component_groups(model: LinearModel[Any]) -> list[list[int]]:
    """Give the components of each unknown: (re, im) of a term, one of a parameter."""
    terms = len(model.terms)
    own = [[2 * j, 2 * j + 1] for j in range(terms)]
    return own + [[2 * terms + i] for i in range(len(model.parameters))]


def inseparable(model: LinearModel[Any], names: Sequence[str], fit: WeightedFit) -> tuple[str, ...]:
    """Name the combinations whose 95 % interval exceeds what alone explains all vibration."""
    lost = fit.singular_values < UNSEEN
    if not lost.any():
        return ()
    directions = fit.directions[lost]
    projector = directions.T @ directions
    groups = component_groups(model)
    links = np.array([[np.linalg.norm(projector[np.ix_(a, b)]) for b in groups] for a in groups])
    found = []
    for members in _clusters(links):
        components = [i for j in members for i in groups[j]]
        dimension = round(float(np.trace(projector[np.ix_(components, components)])))
        if len(members) == 1 or dimension >= len(components):
            found += [_unseen(model, names[j], j) for j in members]
        else:
            shared = _sharing(fit, groups, members)
            also = [names[j] for j in shared if links[j, j] <= _NAMED_SHARE]
            doubt = f"; this doubt is most of the interval of {_listed(also)}" if also else ""
            found.append(f"{_combined(model, names, members, fit)}{doubt}")
    return tuple(found)


def _sharing(fit: WeightedFit, groups: Sequence[list[int]], members: Sequence[int]) -> list[int]:
    """Find the unknowns whose variance comes mostly from what the data do not see of `members`."""
    of_members = [i for j in members for i in groups[j]]
    lost = (fit.directions[:, of_members] ** 2).sum(axis=1) > _SHARED
    lost &= fit.singular_values < UNSEEN
    # A singular value of zero has an infinite variance, of which any share is the whole.
    least = np.finfo(np.float64).eps * fit.singular_values.max(initial=0.0)
    sizes = np.maximum(fit.singular_values, max(least, np.finfo(np.float64).tiny))
    variances = (fit.directions / sizes[:, np.newaxis]) ** 2
    part, total = variances[lost].sum(axis=0), variances.sum(axis=0)
    return [j for j, own in enumerate(groups) if part[own].sum() > _SHARED * total[own].sum()]


def _listed(names: Sequence[str]) -> str:
    """List names in a sentence."""
    return " and ".join([text for text in (", ".join(names[:-1]), names[-1]) if text])


def _clusters(links: Array) -> list[list[int]]:
    """Find the groups of unknowns that appear together in lost directions."""
    waiting = [j for j in range(len(links)) if links[j, j] > _NAMED_SHARE]
    clusters = []
    while waiting:
        cluster, reached = [], [waiting.pop(0)]
        while reached:
            j = reached.pop()
            cluster.append(j)
            near = [k for k in waiting if links[j, k] > _NAMED_SHARE]
            reached += near
            waiting = [k for k in waiting if k not in near]
        clusters.append(sorted(cluster))
    return clusters


def _unseen(model: LinearModel[Any], name: str, index: int) -> str:
    """Say why one unknown cannot be found."""
    if index < len(model.terms):
        shaft = model.terms[index].shaft
        ratios = ratios_by_shaft(model.base)
        orders = [abs(ratios[channel.reference]) for channel in model.channels]
        if not np.isclose(orders, abs(ratios[shaft]), rtol=1e-9).any():
            return (
                f"{name}: unknown, because no probe has {shaft} as its reference: its vibration is "
                "at another order"
            )
    return (
        f"{name}: unknown, because its interval contains values that alone would cause the whole "
        f"measured vibration{_low_speed(model)}"
    )


def _combined(
    model: LinearModel[Any], names: Sequence[str], members: Sequence[int], fit: WeightedFit
) -> str:
    """Say what is known of several unknowns, and why not more."""
    listed = _listed([names[j] for j in members])
    what = "only their combined effect is known"
    terms = len(model.terms)
    if len(members) == 2 and max(members) < terms:
        first, second = (fit.derivative[:, 2 * j] for j in members)
        other = fit.derivative[:, 2 * members[0] + 1]
        # The second response as a complex multiple of the first one.
        size = first @ first
        factor = complex(first @ second / size, other @ second / size)
        if abs(factor - 1.0) < _NEARLY_ONE:
            what = "only their sum is known"
        elif abs(factor + 1.0) < _NEARLY_ONE:
            what = "only their difference is known"
        else:
            units = [model.terms[j].unit for j in members]
            unit = "" if units[0] == units[1] else f" [{units[0]}/({units[1]})]"
            angle = np.degrees(np.angle(factor))
            what = (
                f"only the first plus {abs(factor):.3g} ∠ {angle:.0f}°{unit} times the second "
                "is known"
            )
    low = _low_speed(model)
    shapes = ", because their responses have the same form at these probes and speeds"
    return f"{listed}: {what}{low or shapes}"


def _low_speed(model: LinearModel[Any]) -> str:
    """Say how far all speeds are below the first natural frequency, if they are."""
    modes = model.base.modes(0.0, count=min(10, len(model.base.dofs)))
    lateral = [
        frequency
        for frequency, whirl in zip(modes.frequencies_hz, modes.whirl, strict=True)
        if whirl not in ("rigid", "torsion", "axial") and frequency > 0.0
    ]
    if not lateral:
        return ""
    ratios = ratios_by_shaft(model.base)
    fastest = max(abs(ratios[channel.reference]) for channel in model.channels)
    share = float(np.abs(model.speeds).max()) * fastest / (2.0 * np.pi * lateral[0])
    if share > _LOW_SPEED:
        return ""
    return (
        f", because no speed is above {share:.2g} of the first natural frequency of "
        f"{lateral[0]:.4g} Hz"
    )
