"""Amplitudes at known orders, by least squares.

The excitation frequencies of a train are known exactly. A simultaneous least-squares fit of the
sines and cosines of all orders therefore replaces a spectrum. If the signal contains no other
frequencies, the amplitudes are exact for a record of any length. The RMS of the remainder is
reported.
"""

import math
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import number, text, whole
from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._result import Column, Result, in_degrees, in_micrometres, written_unit
from gearbow._types import Array, ComplexArray, Record
from gearbow.description.kinematics import Kinematics, Order
from gearbow.description.speed import SpeedProfile
from gearbow.errors import AccuracyWarning, GearbowError, outside
from gearbow.orders.channel import channel
from gearbow.orders.harmonics import ALWAYS, MOST_HARMONICS, SEPARATION, significant
from gearbow.recording.record import RunRecord
from gearbow.sensors.sensor import SignalSensor
from gearbow.units.speed import SpeedUnit, speed_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Orders", "orders"]

#: Largest share of the remainder in the RMS about the mean without a warning: the orders then
#: contain 91 % of the power.
_LARGE_REST = 0.3
#: Smallest RMS about the mean of a signal that is more than round-off, relative to its largest
#: value.
_ROUND_OFF = 1e-9


@dataclass(frozen=True, eq=False)
class Orders(Result, ReadOnly):
    """Amplitude of a signal at each order of a train.

    The signal is mean + Re Σ A_j exp(i ω_j t) plus a remainder, which contains everything that
    these orders do not: higher harmonics, natural frequencies, transients. Look at `rest_share`
    before you rank the orders.

    Parameters
    ----------
    orders : tuple of Order
        The orders.
    frequencies_hz : ndarray, shape (n,)
        Frequencies of the orders [Hz].
    amplitudes : ndarray, shape (n,)
        Complex amplitudes A_j in the unit of the signal.
    mean : float
        Mean of the signal.
    rest : float
        RMS of the remainder in the unit of the signal. A sine of amplitude A has the RMS A/√2.
    label : str
        Name of the signal, e.g. "g1 v".
    unit : str
        Unit of the signal.
    speed : float, optional
        Speed of the reference shaft [rad/s].
    speed_unit : {"rad/s", "rpm"}
        Unit of speeds in tables and figures: that in which the speed was given.

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4,
    ...                  bow=gb.Bow.half_sine(1e-4))
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem([rotor], bearings=bearings)
    >>> middle = ("rotor", 0.5)
    >>> response = system.simulate(0.5, 100.0, record=[middle], output_step=1e-3)
    >>> print(f"{1e6 * response.orders(middle).amplitude('1× rotor'):.1f} µm")
    102.6 µm
    """

    orders: tuple[Order, ...]
    frequencies_hz: Array
    amplitudes: ComplexArray
    mean: float
    rest: float
    label: str
    unit: str
    speed: float | None = None
    speed_unit: SpeedUnit = "rad/s"

    @property
    def rest_share(self) -> float:
        """Share of the remainder in the motion.

        Returns
        -------
        float
            RMS of the remainder divided by the RMS of the signal about its mean: 0 if the orders
            contain the complete motion; 0 for a constant signal.
        """
        total = math.hypot(self.rest, float(np.linalg.norm(self.amplitudes)) / math.sqrt(2.0))
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
            Amplitude in the unit of the signal.

        Raises
        ------
        GearbowError
            If there is no such order.
        """
        text(name, "name")
        for order, value in zip(self.orders, self.amplitudes, strict=True):
            if name in order.names:
                return float(abs(value))
        raise GearbowError(
            f"no order is called {name!r}; there are {', '.join(o.names[0] for o in self.orders)}"
        )

    def _heading(self, speed_unit: SpeedUnit) -> list[str]:
        at = "" if self.speed is None else f" at {speed_text(self.speed, speed_unit)}"
        factor, unit = written_unit(self.unit)
        mean = f"mean {factor * self.mean:.6g} {unit}"
        return [f"orders of {self.label}{at}: {mean}, {self._remainder()}"]

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

    def plot(self, count: int = 12, *, ax: Any = None) -> "Figure":
        """Draw the largest orders as bars with their names.

        Parameters
        ----------
        count : int
            Number of orders.
        ax : Axes, optional
            Panel for the bars; None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            Amplitude of each order, on a logarithmic scale if the amplitudes differ by more than a
            factor of 30. The colour shows whether a shaft, a mesh, a sideband or a bearing excites
            the order. The title gives the mean, the number of orders and the remainder.
        """
        with extra("plot"):
            from gearbow.plotting import orders as figures  # noqa: PLC0415

        amplitudes = np.abs(self.amplitudes)
        largest = np.argsort(-amplitudes, kind="stable")[: whole(count, "count")]
        chosen = np.sort(largest)
        names = [f"{self.orders[j].names[0]} ({self.frequencies_hz[j]:.4g} Hz)" for j in chosen]
        factor, unit = written_unit(self.unit)
        label = f"amplitude of {self.label} [{unit}]"
        drawn = f"{chosen.size} largest of " if chosen.size < amplitudes.size else ""
        title = (
            f"mean {factor * self.mean:.4g} {unit}; {drawn}{amplitudes.size} orders; "
            f"{self._remainder()}"
        )
        return figures.orders(names, factor * amplitudes[chosen], label, title=title, ax=ax)

    def _remainder(self) -> str:
        """Describe what the orders do not contain."""
        share = f"{100.0 * self.rest_share:.3g} %"
        factor, unit = written_unit(self.unit)
        return f"rest {factor * self.rest:.2g} {unit} RMS ({share} of the motion)"

    def __repr__(self) -> str:
        largest = int(np.argmax(np.abs(self.amplitudes)))
        return (
            f"Orders({self.label} [{self.unit}]; {len(self.orders)} orders, largest "
            f"{abs(self.amplitudes[largest]):.4g} at {self.orders[largest]})"
        )


def orders(
    run: RunRecord,
    at: Record | SignalSensor,
    quantity: str | None = None,
    *,
    shaft_harmonics: int = 4,
    mesh_harmonics: int | None = None,
    sidebands: int = 1,
    bearing_harmonics: int = 3,
    skip_time: float = 0.0,
) -> Orders:
    """Fit the orders of a train to a recorded signal."""
    if run.kinematics is None:
        raise GearbowError("the orders are unknown, because the response has no kinematics")
    if isinstance(run.speed, SpeedProfile):
        raise GearbowError("orders need a constant speed; the speed of this run changes")
    signal = channel(run, at, quantity)
    begin = run.time[0] if run.time.size else 0.0
    kept = run.time >= begin + number(skip_time, "skip_time")
    time, values = run.time[kept], signal.values[kept]
    hertz = abs(run.speed) / (2.0 * np.pi)
    meshes = ALWAYS if mesh_harmonics is None else mesh_harmonics
    found = run.kinematics.orders(shaft_harmonics, meshes, sidebands, bearing_harmonics)
    _check(time, hertz * np.array([order.value for order in found]), found)
    fitted = _fit(time, values, found, hertz)
    if mesh_harmonics is None:
        more = _more(run.kinematics, sidebands, found)
        fitted = _extended(time, values, fitted, more, hertz)
    result = Orders(
        fitted.orders,
        fitted.frequencies,
        fitted.amplitudes,
        fitted.mean,
        float(np.sqrt(np.mean(fitted.remainder**2))),
        signal.label,
        signal.unit,
        abs(run.speed),
        run.speed_unit,
    )
    _warn(result, values)
    return result


@dataclass(frozen=True, eq=False)
class _Fit:
    """A fit: orders, frequencies [Hz], amplitudes, mean and remainder over time."""

    orders: tuple[Order, ...]
    frequencies: Array
    amplitudes: ComplexArray
    mean: float
    remainder: Array


def _fit(time: Array, values: Array, found: tuple[Order, ...], hertz: float) -> _Fit:
    """Fit sines and cosines of all orders by least squares."""
    frequencies = hertz * np.array([order.value for order in found])
    angles = 2.0 * np.pi * np.outer(time - time[0], frequencies)
    columns = np.hstack([np.ones((time.size, 1)), np.cos(angles), np.sin(angles)])
    fitted, *_ = np.linalg.lstsq(columns, values, rcond=None)
    count = frequencies.size
    # Phases refer to the time 0, like the angles of the shafts.
    turned = np.exp(-2j * np.pi * frequencies * time[0])
    amplitudes = (fitted[1 : count + 1] - 1j * fitted[count + 1 :]) * turned
    return _Fit(found, frequencies, amplitudes, float(fitted[0]), values - columns @ fitted)


def _more(kinematics: Kinematics, sidebands: int, found: tuple[Order, ...]) -> list[Order]:
    """List the higher harmonics of the tooth frequencies that are not among the orders."""
    known = np.array([order.value for order in found])
    return [
        order
        for order in kinematics.orders(0, MOST_HARMONICS, sidebands, 0)
        if not np.isclose(known, order.value, rtol=1e-9, atol=0.0).any()
    ]


def _extended(
    time: Array, values: Array, fitted: _Fit, candidates: list[Order], hertz: float
) -> _Fit:
    """Add the significant candidates to a fit."""
    lines = np.column_stack([fitted.frequencies, np.abs(fitted.amplitudes)])
    if not fitted.remainder.std() > _ROUND_OFF * float(np.abs(values).max()):
        return fitted
    chosen = significant(time, fitted.remainder, candidates, hertz, lines)
    if not chosen:
        return fitted
    found = sorted((*fitted.orders, *(candidates[j] for j in chosen)), key=lambda each: each.value)
    return _fit(time, values, tuple(found), hertz)


def _warn(found: Orders, values: Array) -> None:
    """Warn if the orders do not contain a large part of the motion."""
    moves = float(values.std()) > _ROUND_OFF * float(np.abs(values).max())
    if moves and found.rest_share > _LARGE_REST:
        warnings.warn(
            f"orders: {100.0 * found.rest_share:.0f} % of the RMS of {found.label} is not at these "
            "orders: look at its spectrum; omit a transient with skip_time, or give more "
            "shaft_harmonics, mesh_harmonics or sidebands",
            AccuracyWarning,
            stacklevel=outside(),
        )


def _check(time: Array, frequencies: Array, found: tuple[Order, ...]) -> None:
    """Refuse a record that is too short to separate the orders, or has too long an output step."""
    if frequencies.size == 0 or not frequencies[0] > 0.0:
        raise GearbowError("orders need a rotating train and at least one harmonic")
    if time.size <= 2 * frequencies.size + 1:
        raise GearbowError(
            f"{frequencies.size} orders need more than {2 * frequencies.size + 1} times, "
            f"got {time.size}"
        )
    span = float(time[-1] - time[0])
    gaps = np.diff(frequencies, prepend=0.0)
    closest = int(gaps.argmin())
    gap = float(gaps[closest])
    if span * gap < SEPARATION:
        below = repr(found[closest - 1].names[0]) if closest > 0 else "the mean"
        raise GearbowError(
            f"{below} and {found[closest].names[0]!r} with a distance of {gap:.3g} Hz need a "
            f"record of {SEPARATION / gap:.3g} s, got {span:.3g} s: simulate for longer, or ask "
            "for fewer orders (shaft_harmonics, mesh_harmonics, sidebands, bearing_harmonics)"
        )
    step = float(np.diff(time).max())
    if not math.isfinite(step) or step * frequencies[-1] >= 0.5:
        raise GearbowError(
            f"an order of {frequencies[-1]:.4g} Hz needs an output_step below "
            f"{0.5 / frequencies[-1]:.2g} s, got {step:.2g} s: reduce it, or ask for fewer orders"
        )
