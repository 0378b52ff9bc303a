"""Orders that a record separates, and what to change for the others."""

import math
from bisect import bisect
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from gearbow.description.kinematics import Order

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
