"""Amplitudes at known orders, by least squares.

The excitation frequencies of a train are known exactly. A simultaneous least-squares fit of the
sines and cosines of all orders therefore replaces a spectrum. If the signal contains no other
frequencies, the amplitudes are exact for a record of any length. The RMS of the remainder is
reported.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import number, whole
from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._shown import Table
from gearbow._types import Array, ComplexArray, Record
from gearbow.description.kinematics import Order
from gearbow.description.speed import SpeedProfile
from gearbow.errors import GearbowError
from gearbow.orders.channel import channel
from gearbow.recording.recording import Recording
from gearbow.sensors.sensor import SignalSensor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Orders", "orders"]

#: Smallest phase difference of neighbouring orders over the record, in periods.
_SEPARATION = 0.5


@dataclass(frozen=True, eq=False)
class Orders(ReadOnly):
    """Amplitude of a signal at each order of a train.

    The signal is mean + Re Σ A_j exp(i ω_j t) plus a remainder.

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
        RMS of the remainder.
    label : str
        Name of the signal, e.g. "g1 v".
    unit : str
        Unit of the signal.

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=gb.Bow.half_sine(1e-4))
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
        for order, value in zip(self.orders, self.amplitudes, strict=True):
            if name in order.names:
                return float(abs(value))
        raise GearbowError(
            f"no order is called {name!r}; there are {', '.join(o.names[0] for o in self.orders)}"
        )

    def table(self, count: int | None = None) -> str:
        """Format the orders as a text table, the largest amplitude first.

        Parameters
        ----------
        count : int, optional
            Number of rows; None is all.

        Returns
        -------
        str
            Order, frequency, amplitude and names.
        """
        rows = [f"{self.label}: mean {self.mean:.6g} {self.unit}, rest {self.rest:.2g}"]
        rows.append(f"{'order':>9}  {'[Hz]':>9}  {f'[{self.unit}]':>10}  excited by")
        most = None if count is None else whole(count, "count")
        largest = np.argsort(-np.abs(self.amplitudes), kind="stable")[:most]
        rows += [
            f"{self.orders[j].value:>9.6g}  {self.frequencies_hz[j]:>9.4g}"
            f"  {abs(self.amplitudes[j]):>10.4g}  {self.orders[j]}"
            for j in largest
        ]
        return "\n".join(rows)

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
            the order.
        """
        with extra("plot"):
            from gearbow.plotting import orders as figures  # noqa: PLC0415

        amplitudes = np.abs(self.amplitudes)
        largest = np.argsort(-amplitudes, kind="stable")[: whole(count, "count")]
        chosen = np.sort(largest)
        names = [f"{self.orders[j].names[0]} ({self.frequencies_hz[j]:.4g} Hz)" for j in chosen]
        label = f"amplitude of {self.label} [{self.unit}]"
        return figures.orders(names, amplitudes[chosen], label, ax=ax)

    def _rows(self) -> Table:
        largest = np.argsort(-np.abs(self.amplitudes), kind="stable")
        head = ("order", "frequency [Hz]", f"amplitude [{self.unit}]", "excitation")
        return (
            head,
            *(
                (
                    f"{self.orders[i].value:g}",
                    f"{self.frequencies_hz[i]:.3f}",
                    f"{abs(self.amplitudes[i]):.4g}",
                    str(self.orders[i]),
                )
                for i in largest
            ),
        )

    def __repr__(self) -> str:
        largest = int(np.argmax(np.abs(self.amplitudes)))
        return (
            f"Orders({self.label} [{self.unit}]; {len(self.orders)} orders, largest "
            f"{abs(self.amplitudes[largest]):.4g} at {self.orders[largest]})"
        )

    def __str__(self) -> str:
        return self.table()


def orders(
    recording: Recording,
    of: Record | SignalSensor,
    quantity: str | None = None,
    *,
    shaft_harmonics: int = 4,
    mesh_harmonics: int = 3,
    sidebands: int = 1,
    bearing_harmonics: int = 3,
    skip_time: float = 0.0,
) -> Orders:
    """Fit the orders of a train to a recorded signal.

    Parameters
    ----------
    recording : Recording
        The recorded run.
    of : str, tuple or SignalSensor
        Owner of the signal, as in `gearbow.Response.orders`.
    quantity : str, optional
        Quantity, as in `gearbow.Response.orders`.
    shaft_harmonics, mesh_harmonics, sidebands, bearing_harmonics : int
        Numbers of orders, as in `gearbow.Response.orders`.
    skip_time : float
        Time at the beginning that is ignored [s].

    Returns
    -------
    Orders
        The amplitudes.
    """
    if recording.kinematics is None:
        raise GearbowError("the orders are unknown, because the response has no kinematics")
    if isinstance(recording.speed, SpeedProfile):
        raise GearbowError("orders need a constant speed; the speed of this run changes")
    signal = channel(recording, of, quantity)
    begin = recording.time[0] if recording.time.size else 0.0
    kept = recording.time >= begin + number(skip_time, "skip_time")
    time, values = recording.time[kept], signal.values[kept]
    found = recording.kinematics.orders(
        shaft_harmonics, mesh_harmonics, sidebands, bearing_harmonics
    )
    frequencies = np.array([order.value for order in found]) * abs(recording.speed) / (2.0 * np.pi)
    _check(time, frequencies, found)
    angles = 2.0 * np.pi * np.outer(time - time[0], frequencies)
    columns = np.hstack([np.ones((time.size, 1)), np.cos(angles), np.sin(angles)])
    fitted, *_ = np.linalg.lstsq(columns, values, rcond=None)
    rest = float(np.sqrt(np.mean((values - columns @ fitted) ** 2)))
    count = frequencies.size
    # Phases refer to the time 0, like the angles of the shafts.
    turned = np.exp(-2j * np.pi * frequencies * time[0])
    amplitudes = (fitted[1 : count + 1] - 1j * fitted[count + 1 :]) * turned
    return Orders(found, frequencies, amplitudes, float(fitted[0]), rest, signal.label, signal.unit)


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
    if span * gap < _SEPARATION:
        below = repr(found[closest - 1].names[0]) if closest > 0 else "the mean"
        raise GearbowError(
            f"{below} and {found[closest].names[0]!r} with a distance of {gap:.3g} Hz need a "
            f"record of {_SEPARATION / gap:.3g} s, got {span:.3g} s: simulate for longer, or ask "
            "for fewer orders (shaft_harmonics, mesh_harmonics, sidebands, bearing_harmonics)"
        )
    step = float(np.diff(time).max())
    if not math.isfinite(step) or step * frequencies[-1] >= 0.5:
        raise GearbowError(
            f"an order of {frequencies[-1]:.4g} Hz needs an output_step below "
            f"{0.5 / frequencies[-1]:.2g} s, got {step:.2g} s: reduce it, or ask for fewer orders"
        )
