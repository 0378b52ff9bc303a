"""Least squares over the angle of the reference shaft: a complete record, or segments of it.

A signal is a mean and the sum of A_j cos(2π n_j θ + φ_j) over the revolutions θ of the reference
shaft, for orders n_j that are known exactly. In a record at a constant speed, mean and amplitudes
are constants. In a segment of a run-up they are polynomials, and a Hann window gives the middle of
the segment the largest weight (local regression: Fan and Gijbels, *Local polynomial modelling and
its applications*, 1996).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gearbow._types import Array, ComplexArray
from gearbow.description.kinematics import Order

#: Degree of the amplitudes in a segment. A parabola follows the peak of a resonance.
_DEGREE = 2
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


def cut(turns: Array, values: Array, length: float | None) -> list[SignalSegment]:
    """Divide a record into segments of a length in revolutions; None is the complete record."""
    if length is None:
        return [SignalSegment(float(turns[0] + turns[-1]) / 2.0, turns, values)]
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
