"""Amplitudes of a recorded signal at the orders of the train.

The orders that a train excites are known exactly, and so is the angle of its shafts. A simultaneous
least-squares fit of the sines and cosines of all orders over this angle therefore replaces a
spectrum. If the signal contains no other orders, the amplitudes are exact for a record of any
length. At a changing speed, the fit of short segments gives amplitudes over the speed. The RMS of
the remainder is reported.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import number, text, whole
from gearbow._extras import extra
from gearbow._result import Column, Result, WithSpeeds, in_degrees, in_micrometres, written_unit
from gearbow._shown import ReadOnly
from gearbow._types import Array, ComplexArray, Record, SignalQuantity
from gearbow.description.layout import Kinematics, Order
from gearbow.description.speed import SpeedProfile
from gearbow.errors import AccuracyWarning, GearbowError, warn
from gearbow.orders.separation import (
    ALWAYS,
    MOST_HARMONICS,
    SEGMENT_SEPARATION,
    SEPARATION,
    OrderFit,
    Sampling,
    Separated,
    SignalSegment,
    cut,
    fit,
    separated,
    shortcomings,
    significant,
)
from gearbow.orders.spectrum import channel
from gearbow.recording import access
from gearbow.recording.record import RunRecord
from gearbow.sensors import SignalSensor
from gearbow.units.speed import SpeedUnit, in_given_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Largest share of the remainder in the RMS about the mean without a warning: the orders then
#: contain 91 % of the power.
_LARGE_REST = 0.3
#: Smallest RMS about the mean of a signal that is more than round-off, relative to its largest
#: value.
_ROUND_OFF = 1e-9
#: Largest length of the segments by default, relative to the record of a run-up.
_MOST_PART = 0.2
#: Largest difference of an order from a multiple of the order of the period, in periods: both are
#: rounded.
_HARMONIC = 1e-6


@dataclass(frozen=True, eq=False)
class Orders(WithSpeeds, Result, ReadOnly):
    """Amplitude of a signal at each order of a train.

    The signal is mean + Re Σ A_j exp(i n_j ϑ(t)) plus a remainder, which contains everything that
    these orders do not: higher harmonics, natural frequencies, transients. ϑ is the angle of the
    reference shaft in the sense of its rotation. Look at `rest_share` before you rank the orders.

    At a constant speed, A_j is constant. At a changing speed, `tracks` contains A_j in the middle
    of each of m segments, and `amplitudes` those of the segment where the order is largest.

    Parameters
    ----------
    orders : tuple of Order
        The orders. Orders that the record does not separate are one order with all their names.
    frequencies_hz : ndarray, shape (n,)
        Frequencies of the orders where they are largest [Hz].
    amplitudes : ndarray, shape (n,)
        Complex amplitudes A_j in the unit of the signal where they are largest.
    mean : float
        Mean of the signal.
    rest : float
        RMS of the remainder in the unit of the signal. A sine of amplitude A has the RMS A/√2.
    label, unit : str
        Name of the signal, e.g. "g1 v", and its unit.
    times : ndarray, shape (m,)
        Times in the middle of the segments [s]; m is 1 for a complete record.
    speeds : ndarray, shape (m,)
        Magnitude of the speed of the reference shaft at these times [rad/s].
    tracks : ndarray, shape (m, n)
        Complex amplitudes A_j at these times in the unit of the signal.
    speed : float, optional
        Speed of the reference shaft [rad/s].

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> response = system.simulate(0.5, 100.0, record=["disk"], output_step=1e-3)
    >>> print(f"{1e6 * response.orders('disk').amplitude('1× rotor'):.1f} µm")
    33.1 µm
    """

    orders: tuple[Order, ...]
    frequencies_hz: Array
    amplitudes: ComplexArray
    mean: float
    rest: float
    label: str
    unit: str
    times: Array
    speeds: Array
    tracks: ComplexArray
    _separated: Separated = field(repr=False)
    speed: float | None = None

    @property
    def rest_share(self) -> float:
        """RMS of the remainder divided by the RMS of the signal about its mean.

        It is 0 if the orders contain the complete motion, and for a constant signal.
        """
        power = float(np.linalg.norm(self.tracks)) / math.sqrt(2.0 * self.times.size)
        total = math.hypot(self.rest, power)
        return self.rest / total if total > 0.0 else 0.0

    def amplitude(self, name: str) -> float:
        """Find the amplitude of an order by one of its names.

        Parameters
        ----------
        name : str
            A name such as "1× input", "2× mesh g1–g2" or "1× mesh g1–g2 − 1× middle".

        Returns
        -------
        float
            Amplitude in the unit of the signal; at a changing speed, the largest one.
        """
        return float(abs(self.amplitudes[self._index(name)]))

    def track(self, name: str) -> Array:
        """Find the amplitudes of an order over the segments by one of its names.

        Parameters
        ----------
        name : str
            A name, as for `amplitude`.

        Returns
        -------
        ndarray, shape (m,)
            Amplitudes at `times` and `speeds` in the unit of the signal.
        """
        found: Array = np.abs(self.tracks[:, self._index(name)])
        return found

    def _index(self, name: str) -> int:
        """Find an order by one of its names."""
        text(name, "name")
        for j, order in enumerate(self.orders):
            if name in order.names:
                return j
        names = ", ".join(order.names[0] for order in self.orders)
        why = self._separated.absent(name) or f"no order is called {name!r}"
        raise GearbowError(f"{why}; there are {names or 'no orders'}")

    def _heading(self) -> list[str]:
        at = "" if self.speed is None else f" at {self._speed_text(self.speed)}"
        factor, unit = written_unit(self.unit)
        mean = f"mean {factor * self._shown_mean():.6g} {unit}"
        return [f"orders of {self.label}{at}: {mean}, {self._remainder()}"]

    def _shown_mean(self) -> float:
        """Give the mean, or 0 where it is round-off of the amplitudes."""
        least = _ROUND_OFF * float(np.abs(self.amplitudes).max(initial=0.0))
        return 0.0 if abs(self.mean) < least else self.mean

    def _columns(self) -> list[Column]:
        """Give a row for each order, the largest amplitude first."""
        order = np.argsort(-np.abs(self.amplitudes), kind="stable")
        amplitudes, written = self.amplitudes[order], in_micrometres(self.unit)
        return [
            Column("order", np.array([self.orders[j].value for j in order]), "", ".6g"),
            Column("frequency", self.frequencies_hz[order], "Hz"),
            Column("amplitude", np.abs(amplitudes), self.unit, ".4g", written),
            Column("phase", np.angle(amplitudes), "rad", ".1f", in_degrees()),
            Column("excited by", [str(self.orders[j]) for j in order]),
        ]

    def plot(
        self, count: int | None = None, *, ax: Any = None, speed_unit: SpeedUnit | None = None
    ) -> "Figure":
        """Draw the largest orders: bars with their names, or lines over the speed of a run-up.

        Parameters
        ----------
        count : int, optional
            Number of orders; None is 12 bars or 6 lines.
        ax : Axes, optional
            Panel for the figure; None makes a new figure.
        speed_unit : str, optional
            Unit of the axis of speeds, as for `table`; None is that of the result.

        Returns
        -------
        matplotlib.figure.Figure
            Amplitude of each order. Bars are on a logarithmic scale if the amplitudes differ by
            more than a factor of 30. Their colour shows whether a shaft, a mesh, a sideband or a
            bearing excites the order. The title gives the mean, the number of orders and the
            remainder. Where the speed is constant over several segments, lines are over time.
        """
        with extra("plot"):
            from gearbow.plotting import orders as figures  # noqa: PLC0415

        amplitudes = np.abs(self.amplitudes)
        largest = np.argsort(-amplitudes, kind="stable")
        most = (12 if self.times.size == 1 else 6) if count is None else whole(count, "count")
        chosen = np.sort(largest[:most])
        factor, unit = written_unit(self.unit)
        label = f"amplitude of {self.label} [{unit}]"
        drawn = f"{chosen.size} largest of " if chosen.size < amplitudes.size else ""
        title = (
            f"mean {factor * self._shown_mean():.4g} {unit}; {drawn}{amplitudes.size} orders; "
            f"{self._remainder()}"
        )
        if self.times.size > 1:
            names = [self.orders[j].names[0] for j in chosen]
            tracks = factor * np.abs(self.tracks[:, chosen])
            over_time = bool(np.ptp(self.speeds) <= _ROUND_OFF * self.speeds.max())
            x = self.times if over_time else self.speeds
            lines = dict(zip(names, tracks.T, strict=True))
            with self._showing(speed_unit):
                return figures.tracks(x, lines, label, title=title, over_time=over_time, ax=ax)
        names = [f"{self.orders[j].names[0]} ({self.frequencies_hz[j]:.4g} Hz)" for j in chosen]
        with self._showing(speed_unit):
            return figures.orders(names, factor * amplitudes[chosen], label, title=title, ax=ax)

    def _remainder(self) -> str:
        """Describe what the orders do not contain."""
        share = f"{100.0 * self.rest_share:.3g} %"
        factor, unit = written_unit(self.unit)
        return f"rest {factor * self.rest:.2g} {unit} RMS ({share} of the motion)"

    def __repr__(self) -> str:
        largest = ""
        if self.orders:
            j = int(np.argmax(np.abs(self.amplitudes)))
            largest = f", largest {abs(self.amplitudes[j]):.4g} at {self.orders[j]}"
        return f"Orders({self.label} [{self.unit}]; {len(self.orders)} orders{largest})"


@in_given_unit
def orders(
    run: RunRecord,
    at: Record | SignalSensor,
    quantity: SignalQuantity | None = None,
    *,
    shaft_harmonics: int = 4,
    mesh_harmonics: int | None = None,
    sidebands: int = 1,
    bearing_harmonics: int = 3,
    skip_time: float = 0.0,
    revolutions: float | None = None,
    noise: float = 0.0,
) -> Orders:
    """Fit the orders of a train to a recorded signal; `noise` is the RMS of that added to it."""
    if run.kinematics is None:
        raise GearbowError("the orders are unknown, because the response has no kinematics")
    signal = channel(run, at, quantity)
    meshes = ALWAYS if mesh_harmonics is None else mesh_harmonics
    ranked = run.kinematics.ranked(shaft_harmonics, meshes, sidebands, bearing_harmonics)
    begin = run.time[0] if run.time.size else 0.0
    kept = run.time >= begin + number(skip_time, "skip_time")
    time, values, turns = run.time[kept], signal.values[kept], _turns(run)[kept]
    if not ranked or not turns.size or not np.ptp(turns) > 0.0:
        raise GearbowError("orders need a rotating train and at least one harmonic")
    order_of_period = _order_of_period(run)
    silent = [order for order in ranked if not _is_multiple(order.value, order_of_period)]
    excited = [order for order in ranked if _is_multiple(order.value, order_of_period)]
    length = _length(run, turns, excited, revolutions)
    period = 1.0 / order_of_period if order_of_period else None
    segments = cut(turns, values, length, period)
    sampling = _sampling(segments, time, turns)
    chosen = separated(excited, sampling)
    fitted = fit(segments, chosen.orders)
    if mesh_harmonics is None and _moves(fitted, values):
        more = [
            order
            for order in _more(run.kinematics, sidebands, ranked)
            if _is_multiple(order.value, order_of_period)
        ]
        added = significant(segments, fitted, more, sampling)
        if added:
            every = sorted((*fitted.orders, *added), key=lambda order: order.value)
            fitted = fit(segments, tuple(every))
    fitted = _with_silent(fitted, silent)
    times = np.interp([segment.centre for segment in segments], turns, time)
    speeds = np.abs(access.speeds(run, times))
    largest = np.argmax(np.abs(fitted.amplitudes), axis=0)
    result = Orders(
        orders=fitted.orders,
        frequencies_hz=speeds[largest] / (2.0 * np.pi) * fitted.values,
        amplitudes=np.take_along_axis(fitted.amplitudes, largest[np.newaxis], axis=0)[0],
        mean=float(fitted.means.mean()),
        rest=_rest(segments, fitted),
        label=signal.label,
        unit=signal.unit,
        times=times,
        speeds=speeds,
        tracks=fitted.amplitudes,
        _separated=chosen,
        speed=None if isinstance(run.speed, SpeedProfile) else abs(run.speed),
    )
    _warn(result, values, shortcomings(chosen, excited, sampling), noise)
    return result


def _turns(run: RunRecord) -> Array:
    """Give the revolutions of the reference shaft, which ascend."""
    turns = access.reference_angle(run) / (2.0 * np.pi)
    return -turns if access.speeds(run).sum() < 0.0 else turns


def _order_of_period(run: RunRecord) -> float | None:
    """Give the order whose multiples a periodic motion contains; None for any other motion."""
    if run.period is None or isinstance(run.speed, SpeedProfile) or not run.speed:
        return None
    return 2.0 * math.pi / (run.period * abs(run.speed))


def _is_multiple(value: float, order_of_period: float | None) -> bool:
    """Return whether a motion with this period can contain an order."""
    if order_of_period is None:
        return True
    periods = value / order_of_period
    return abs(periods - round(periods)) < _HARMONIC * max(1.0, periods)


def _length(
    run: RunRecord, turns: Array, found: Sequence[Order], revolutions: float | None
) -> float | None:
    """Give the length of the segments; None is the complete record."""
    span = float(np.ptp(turns))
    if revolutions is not None:
        length = number(revolutions, "revolutions")
        if not 0.0 < length <= span:
            raise GearbowError(
                f"revolutions: must be positive and at most the {span:.6g} revolutions of the "
                f"record, got {length:g}"
            )
        return length
    if not isinstance(run.speed, SpeedProfile):
        return None
    gaps = np.diff([0.0, *sorted(order.value for order in found)])
    return min(SEGMENT_SEPARATION / float(gaps.min()), _MOST_PART * span)


def _sampling(segments: Sequence[SignalSegment], time: Array, turns: Array) -> Sampling:
    """Describe what the samples of a record determine."""
    first = segments[0]
    steps = np.diff(turns)
    return Sampling(
        length=float(np.ptp(turns)) if first.half is None else 2.0 * first.half,
        periods=SEPARATION if first.half is None else SEGMENT_SEPARATION,
        samples=min(segment.turns.size for segment in segments),
        coefficients=first.degree + 1,
        step=float(steps.max(initial=0.0)),
        output_step=float(np.diff(time).max(initial=0.0)),
        speed=float(np.ptp(turns) / np.ptp(time)),
        is_segment=first.half is not None,
    )


def _with_silent(fitted: OrderFit, silent: Sequence[Order]) -> OrderFit:
    """Add orders with the amplitude zero, which the period of the motion excludes."""
    if not silent:
        return fitted
    every = (*fitted.orders, *silent)
    none = np.zeros((len(fitted.amplitudes), len(silent)))
    ascending = np.argsort([order.value for order in every], kind="stable")
    return replace(
        fitted,
        orders=tuple(every[j] for j in ascending),
        amplitudes=np.hstack([fitted.amplitudes, none])[:, ascending],
    )


def _rest(segments: Sequence[SignalSegment], fitted: OrderFit) -> float:
    """Give the RMS of the remainder."""
    powers = [
        float(segment.weights @ remainder**2)
        for segment, remainder in zip(segments, fitted.remainders, strict=True)
    ]
    return math.sqrt(float(np.mean(powers)))


def _more(kinematics: Kinematics, sidebands: int, found: Sequence[Order]) -> list[Order]:
    """List the higher harmonics of the tooth frequencies that are not among the orders."""
    known = np.array([order.value for order in found])
    return [
        order
        for order in kinematics.orders(
            shaft_harmonics=0,
            mesh_harmonics=MOST_HARMONICS,
            sidebands=sidebands,
            bearing_harmonics=0,
        )
        if not np.isclose(known, order.value, rtol=1e-9, atol=0.0).any()
    ]


def _moves(fitted: OrderFit, values: Array) -> bool:
    """Return whether a fit leaves more than round-off."""
    left = max(float(np.std(remainder)) for remainder in fitted.remainders)
    return left > _ROUND_OFF * float(np.abs(values).max())


def _warn(found: Orders, values: Array, shortcoming: str | None, noise: float) -> None:
    """Warn if the record is too short or too coarse, or the orders leave out much of the motion."""
    reasons = [] if shortcoming is None else [shortcoming]
    moves = float(values.std()) > _ROUND_OFF * float(np.abs(values).max())
    expected = noise / found.rest if found.rest > noise else 1.0
    share = found.rest_share * math.sqrt(1.0 - expected**2)
    if moves and share > _LARGE_REST:
        reasons.append(
            f"{100.0 * share:.0f} % of the RMS of {found.label} is not at these "
            "orders: look at its spectrum; omit a transient with skip_time, or give more "
            "shaft_harmonics, mesh_harmonics or sidebands"
        )
    if reasons:
        warn(f"orders: {'. '.join(reasons)}", AccuracyWarning)
