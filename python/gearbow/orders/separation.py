"""Segments of a record, and the orders that it separates."""

import math
from bisect import bisect
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gearbow._types import Array, ComplexArray
from gearbow.description.layout import Order

# Least squares over the angle of the reference shaft: a complete record, or segments of it.
#
# A signal is a mean and the sum of A_j cos(2π n_j θ + φ_j) over the revolutions θ of the reference
# shaft, for orders n_j that are known exactly. In a record at a constant speed, mean and
# amplitudes are constants. In a segment of a run-up they are polynomials, and a Hann window gives
# the middle of the segment the largest weight (local regression: Fan and Gijbels, *Local
# polynomial modelling and its applications*, 1996).

#: Degree of the amplitudes in a segment. A parabola follows the peak of a resonance.
_DEGREE = 2
#: Largest distance of a sample from its place in a period that is divided evenly, in steps.
_UNEVEN = 1e-6
#: Distance of neighbouring segments, relative to their length. The window has 85 % of its largest
#: weight halfway between two segments.
_DISTANCE = 0.25


@dataclass(frozen=True, eq=False)
class SignalSegment:
    """A part of a record: revolutions of the reference shaft and values over its samples."""

    centre: float
    turns: Array
    values: Array
    #: Half of the length in revolutions; None for a complete record.
    half: float | None = None
    #: Period of the motion in revolutions if the samples divide it evenly; otherwise None.
    period: float | None = None

    def waves(self, orders: Array, values: Array) -> ComplexArray:
        """Sum values times e^(-2πi n θ) of each order n; θ counts from the first sample."""
        if self.period is not None:
            found: ComplexArray = np.fft.rfft(values)[np.rint(orders * self.period).astype(int)]
            return found
        turns = self.turns - self.turns[0]
        return np.array([np.exp(-2j * np.pi * order * turns) @ values for order in orders])

    @property
    def degree(self) -> int:
        """Degree of mean and amplitudes."""
        return 0 if self.half is None else _DEGREE

    @property
    def weights(self) -> Array:
        """Weights of the samples in the fit, with the sum 1."""
        if self.half is None:
            uniform: Array = np.full(self.turns.shape, 1.0 / self.turns.size)
            return uniform
        return self.window

    @property
    def window(self) -> Array:
        """Weights of a Hann window over the segment, with the sum 1."""
        turns = self.turns
        if self.half is None:
            weights = 1.0 - np.cos(2.0 * np.pi * (turns - turns[0]) / (turns[-1] - turns[0]))
        else:
            weights = 1.0 + np.cos(np.pi * (turns - self.centre) / self.half)
        found: Array = weights / weights.sum()
        return found


@dataclass(frozen=True, eq=False)
class OrderFit:
    """Orders with a row of amplitudes and a mean for each segment, and what is left of it."""

    orders: tuple[Order, ...]
    amplitudes: ComplexArray
    means: Array
    remainders: tuple[Array, ...]

    @property
    def values(self) -> Array:
        """Orders as numbers."""
        return np.array([order.value for order in self.orders])

    @property
    def largest(self) -> Array:
        """Largest amplitude of each order in all segments."""
        largest: Array = np.abs(self.amplitudes).max(axis=0)
        return largest


def cut(
    turns: Array, values: Array, length: float | None, period: float | None = None
) -> list[SignalSegment]:
    """Divide a record into segments of a length [revolutions]; without one, it is one segment."""
    if length is None:
        if period is not None:
            even = turns[0] + period * np.arange(turns.size) / turns.size
            if np.abs(turns - even).max() > _UNEVEN * period / turns.size:
                period = None
        return [SignalSegment(float(turns[0] + turns[-1]) / 2.0, turns, values, period=period)]
    half, span = length / 2.0, float(turns[-1] - turns[0])
    count = max(1, round((span - length) / (_DISTANCE * length)) + 1)
    centres = np.linspace(turns[0] + half, turns[-1] - half, count)
    first = np.searchsorted(turns, centres - half)
    end = np.searchsorted(turns, centres + half, "right")
    return [
        SignalSegment(float(centre), turns[a:b], values[a:b], half)
        for centre, a, b in zip(centres, first, end, strict=True)
    ]


def fit(segments: Sequence[SignalSegment], orders: tuple[Order, ...]) -> OrderFit:
    """Fit all orders to each segment."""
    numbers = np.array([order.value for order in orders])
    found = [_fit(segment, numbers) for segment in segments]
    return OrderFit(
        orders,
        np.array([amplitudes for amplitudes, _, _ in found]),
        np.array([mean for _, mean, _ in found]),
        tuple(remainder for _, _, remainder in found),
    )


def _fit(segment: SignalSegment, numbers: Array) -> tuple[ComplexArray, float, Array]:
    """Give amplitudes and mean in the middle of a segment, and its remainder."""
    if segment.period is not None:
        return _fit_period(segment, numbers, segment.period)
    terms = segment.degree + 1
    angles = 2.0 * np.pi * np.outer(segment.turns - segment.centre, numbers)
    waves = np.hstack([np.ones((segment.turns.size, 1)), np.cos(angles), np.sin(angles)])
    if segment.half is None:
        columns, middle = waves, np.ones(1)
        fitted, *_ = np.linalg.lstsq(columns, segment.values, rcond=None)
    else:
        x = (segment.turns - segment.centre) / segment.half
        powers = np.polynomial.legendre.legvander(x, segment.degree)
        columns = (powers[:, :, np.newaxis] * waves[:, np.newaxis, :]).reshape(x.size, -1)
        weighted = columns * segment.weights[:, np.newaxis]
        # The orders are so far apart that the normal equations have a condition below 1e4.
        fitted = np.linalg.solve(columns.T @ weighted, weighted.T @ segment.values)
        middle = np.polynomial.legendre.legvander(np.zeros(1), segment.degree)[0]
    remainder: Array = segment.values - columns @ fitted
    at_middle = middle @ fitted.reshape(terms, -1)
    count = numbers.size
    # Phases refer to the angle 0 of the reference shaft.
    turned = np.exp(-2j * np.pi * numbers * segment.centre)
    amplitudes = (at_middle[1 : count + 1] - 1j * at_middle[count + 1 :]) * turned
    return amplitudes, float(at_middle[0]), remainder


def _fit_period(
    segment: SignalSegment, numbers: Array, period: float
) -> tuple[ComplexArray, float, Array]:
    """Give the same for samples that divide a period evenly, where the waves are orthogonal."""
    values, count = segment.values, segment.turns.size
    mean = float(values.mean())
    amplitudes = 2.0 / count * segment.waves(numbers, values)
    spectrum = np.zeros(count // 2 + 1, complex)
    spectrum[np.rint(numbers * period).astype(int)] = amplitudes / 2.0
    remainder: Array = values - mean - np.fft.irfft(spectrum, count, norm="forward")
    # Phases refer to the angle 0 of the reference shaft.
    return amplitudes * np.exp(-2j * np.pi * numbers * segment.turns[0]), mean, remainder


#: Smallest phase difference of neighbouring orders over a complete record, in periods.
SEPARATION = 0.5
#: The same over a segment, whose amplitudes are parabolas: the condition of the fit of five orders
#: at this distance is 3.6, at 3 periods 12, and at 2 periods 1e6.
SEGMENT_SEPARATION = 4.0
#: Factor by which the distance of separate orders grows until the samples determine all of them.
_WIDER = 1.25
#: Largest number of orders that the warning names in each of its parts.
_MOST_NAMED = 3


@dataclass(frozen=True)
class Sampling:
    """What decides about the separation of orders in a record."""

    #: Length of the record or of its segments in revolutions of the reference shaft.
    length: float
    #: Smallest phase difference of neighbouring orders over this length, in periods.
    periods: float
    #: Smallest number of samples in this length, and coefficients of a mean or a half amplitude.
    samples: int
    coefficients: int
    #: Largest distance of samples in revolutions, and in seconds.
    step: float
    output_step: float
    #: Mean speed in revolutions per second.
    speed: float
    is_segment: bool

    @property
    def distance(self) -> float:
        """Smallest distance of orders that are separate."""
        return self.periods / self.length if self.length > 0.0 else math.inf

    @property
    def most_orders(self) -> int:
        """Largest number of orders that the samples determine."""
        return max(0, (self.samples // self.coefficients - 2) // 2)

    def resolves(self, value: float) -> bool:
        """Return whether the samples are dense enough for an order."""
        return value * self.step < 0.5


@dataclass(frozen=True)
class Separated:
    """Orders of a fit, the simplest of each group of orders that the record does not separate."""

    orders: tuple[Order, ...]
    #: Groups of several orders, those that belong to the mean, and those of too high a frequency.
    merged: tuple[tuple[Order, ...], ...]
    with_mean: tuple[Order, ...]
    unresolved: tuple[Order, ...]

    def absent(self, name: str) -> str | None:
        """Say why an order is not among those of the fit."""
        if any(name in order.names for order in self.with_mean):
            return f"the record is too short to separate {name!r} from the mean"
        if any(name in order.names for order in self.unresolved):
            return f"the recorded times are too far apart for {name!r}"
        return None


def separated(ranked: Sequence[Order], sampling: Sampling) -> Separated:
    """Merge the orders that a record does not separate, and leave out those above half its rate."""
    resolved = [order for order in ranked if sampling.resolves(order.value)]
    unresolved = tuple(order for order in ranked if not sampling.resolves(order.value))
    distance = sampling.distance
    groups, with_mean = _groups(resolved, distance)
    while len(groups) > sampling.most_orders:
        distance *= _WIDER
        groups, with_mean = _groups(resolved, distance)
    return Separated(
        tuple(
            Order(group[0].value, tuple(name for order in group for name in order.names))
            for group in groups
        ),
        tuple(tuple(group) for group in groups if len(group) > 1),
        tuple(with_mean),
        unresolved,
    )


def _groups(ranked: Sequence[Order], distance: float) -> tuple[list[list[Order]], list[Order]]:
    """Group orders around the simplest of them, ascending; and list those near the order zero."""
    values: list[float] = []
    groups: list[list[Order]] = []
    with_mean: list[Order] = []
    for order in ranked:
        if not order.value >= distance:
            with_mean.append(order)
            continue
        at = bisect(values, order.value)
        near = min(
            (i for i in (at - 1, at) if 0 <= i < len(values)),
            key=lambda i: abs(values[i] - order.value),
            default=None,
        )
        if near is not None and abs(values[near] - order.value) < distance:
            groups[near].append(order)
        else:
            values.insert(at, order.value)
            groups.insert(at, [order])
    return groups, with_mean


def shortcomings(found: Separated, ranked: Sequence[Order], sampling: Sampling) -> str | None:
    """Say everything that a record does not separate or resolve, with all remedies."""
    reasons, remedies = [], []
    if found.merged:
        first = found.merged[:_MOST_NAMED]
        shown = "; ".join(" with ".join(map(_named, group[:2])) for group in first)
        more = len(found.merged) - _MOST_NAMED
        reasons.append(
            f"{sum(map(len, found.merged))} orders are too close to each other and share "
            f"{len(found.merged)} amplitudes ({shown}{f'; and {more} more' if more > 0 else ''})"
        )
    if found.with_mean:
        reasons.append(f"{_list(found.with_mean)} cannot be separated from the mean")
    if found.merged or found.with_mean:
        values = [0.0, *sorted(order.value for order in ranked if sampling.resolves(order.value))]
        gap = min(b - a for a, b in pairwise(values))
        needed = sampling.periods / gap
        if sampling.is_segment:
            remedies.append(f"give revolutions={needed:.3g} and a longer run")
        elif needed > sampling.length:
            remedies.append(f"simulate for {needed / sampling.speed:.3g} s")
        else:
            remedies.append("reduce output_step")
        remedies.append(
            "ask for fewer orders (shaft_harmonics, mesh_harmonics, sidebands, bearing_harmonics)"
        )
    if found.unresolved:
        highest = max(order.value for order in found.unresolved)
        longest = 0.5 * sampling.output_step / (highest * sampling.step)
        reasons.append(f"{_list(found.unresolved)} have less than two samples in a period")
        remedies.append(f"reduce output_step from {sampling.output_step:.3g} s to {longest:.2g} s")
    if not reasons:
        return None
    what = (
        f"segments of {sampling.length:.3g} revolutions"
        if sampling.is_segment
        else f"a record of {sampling.length / sampling.speed:.3g} s"
    )
    return f"in {what}, {'; '.join(reasons)}: {', or '.join(remedies)}"


def _named(order: Order) -> str:
    return repr(order.names[0])


def _list(orders: Sequence[Order]) -> str:
    """Name the first of several orders."""
    more = len(orders) - _MOST_NAMED
    shown = ", ".join(map(_named, orders[:_MOST_NAMED]))
    return shown if more <= 0 else f"{shown} and {more} more"


#: Number of harmonics of every tooth frequency that belong to the default, and largest number.
ALWAYS, MOST_HARMONICS = 3, 30
#: Largest number of orders that are added to those, which bounds the cost of the fit.
_MOST_ADDED = 100
#: Smallest amplitude of an added order, relative to the largest amplitude of all orders. A figure
#: with a linear scale shows no smaller one.
_SIGNIFICANT = 0.01


def significant(
    segments: Sequence[SignalSegment],
    fitted: OrderFit,
    candidates: Sequence[Order],
    sampling: Sampling,
) -> list[Order]:
    """Choose orders that carry a significant part of what a fit leaves."""
    resolved = [order for order in candidates if sampling.resolves(order.value)]
    values = np.array([order.value for order in resolved])
    sizes = np.zeros(values.size)
    for segment, remainder in zip(segments, fitted.remainders, strict=True):
        # The window keeps a line from appearing at the others.
        weighted = 2.0 * segment.window * remainder
        sizes = np.maximum(sizes, np.abs(segment.waves(values, weighted)))
    least = _SIGNIFICANT * max(fitted.largest.max(initial=0.0), sizes.max(initial=0.0))
    most = min(_MOST_ADDED, sampling.most_orders - len(fitted.orders))
    taken: list[float] = fitted.values.tolist()
    chosen: list[Order] = []
    for j in np.argsort(-sizes, kind="stable"):
        if len(chosen) >= most or not sizes[j] > least:
            break
        if np.abs(np.array(taken) - values[j]).min(initial=np.inf) >= sampling.distance:
            taken.append(float(values[j]))
            chosen.append(resolved[j])
    return chosen
