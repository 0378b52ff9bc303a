"""Amplitudes at the orders that are known, by least squares.

The frequencies of a train are known exactly, so nothing has to be read off a spectrum: sines and
cosines of all orders are fitted at once. The amplitudes are exact whenever the signal holds no
others, whether the record is a whole number of turns or not; what is left over is reported.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gearbow._convert import number, whole
from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._types import Array, ComplexArray, Record
from gearbow.errors import GearbowError
from gearbow.orders.channel import channel
from gearbow.orders.kinematics import Order
from gearbow.speed import SpeedProfile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow.response import Response

__all__ = ["Orders", "orders"]

#: Part of a period by which neighbouring orders must have parted over the record.
_APART = 0.5


@dataclass(frozen=True, eq=False)
class Orders(ReadOnly):
    """Amplitude of a signal at each order of a train.

    The signal is mean + Re Σ A_j exp(i ω_j t), and what is left over.

    Parameters
    ----------
    orders : tuple of Order
        The orders.
    frequencies_hz : ndarray, shape (n,)
        Their frequencies [Hz].
    amplitudes : ndarray, shape (n,)
        Complex amplitudes A_j, in the unit of the signal.
    mean : float
        What is constant.
    rest : float
        RMS of what no order holds.
    label : str
        What the signal is, e.g. "g1 v".
    unit : str
        Its unit.
    """

    orders: tuple[Order, ...]
    frequencies_hz: Array
    amplitudes: ComplexArray
    mean: float
    rest: float
    label: str
    unit: str

    def amplitude(self, name: str) -> float:
        """Look up an order by any of its names.

        Parameters
        ----------
        name : str
            A name such as "1× input", "2× mesh g1–g2" or "1× mesh g1–g2 − 1× middle".

        Returns
        -------
        float
            The amplitude, in the unit of the signal.

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
        """Lay the orders out as text, the largest amplitude first.

        Parameters
        ----------
        count : int, optional
            How many rows; None is all of them.

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

    def plot(self, count: int = 12) -> "Figure":
        """Draw the largest orders as bars with their names.

        Parameters
        ----------
        count : int
            How many.

        Returns
        -------
        matplotlib.figure.Figure
            Amplitude of each order on a logarithmic scale.
        """
        with extra("plot"):
            from gearbow.orders import figures  # noqa: PLC0415

        return figures.orders(self, whole(count, "count"))

    def __str__(self) -> str:
        return self.table()


def orders(
    response: "Response",
    of: Record,
    quantity: str | None = None,
    *,
    shaft_harmonics: int = 4,
    mesh_harmonics: int = 3,
    sidebands: int = 1,
    skip_time: float = 0.0,
) -> Orders:
    """Fit the orders of a train to a recorded signal; `Response.orders` says more.

    Parameters
    ----------
    response : Response
        The response.
    of : str or tuple
        What it belongs to.
    quantity : str, optional
        Which quantity of it.
    shaft_harmonics, mesh_harmonics, sidebands : int
        How many orders.
    skip_time : float
        Time at the beginning that is left out [s].

    Returns
    -------
    Orders
        The amplitudes.
    """
    if response.kinematics is None:
        raise GearbowError("the orders of this response are unknown: its file does not tell them")
    if isinstance(response.speed, SpeedProfile):
        raise GearbowError("orders need a constant speed; this run changes it")
    signal = channel(response, of, quantity)
    kept = response.time >= (response.time[0] if response.time.size else 0.0) + number(
        skip_time, "skip_time"
    )
    time, values = response.time[kept], signal.values[kept]
    found = response.kinematics.orders(shaft_harmonics, mesh_harmonics, sidebands)
    frequencies = np.array([order.value for order in found]) * abs(response.speed) / (2.0 * np.pi)
    _check(time, frequencies)
    angles = 2.0 * np.pi * np.outer(time - time[0], frequencies)
    columns = np.hstack([np.ones((time.size, 1)), np.cos(angles), np.sin(angles)])
    fitted, *_ = np.linalg.lstsq(columns, values, rcond=None)
    rest = float(np.sqrt(np.mean((values - columns @ fitted) ** 2)))
    count = frequencies.size
    # Phases count from the time 0, from which the angles of the shafts do.
    turned = np.exp(-2j * np.pi * frequencies * time[0])
    amplitudes = (fitted[1 : count + 1] - 1j * fitted[count + 1 :]) * turned
    return Orders(found, frequencies, amplitudes, float(fitted[0]), rest, signal.label, signal.unit)


def _check(time: Array, frequencies: Array) -> None:
    """Refuse a record that is too short to tell the orders apart, or too coarse to see them."""
    if frequencies.size == 0 or not frequencies[0] > 0.0:
        raise GearbowError("orders need a train that turns, and at least one harmonic")
    if time.size <= 2 * frequencies.size + 1:
        raise GearbowError(
            f"{frequencies.size} orders need more than {2 * frequencies.size + 1} times, "
            f"got {time.size}"
        )
    span = float(time[-1] - time[0])
    gap = float(np.diff(frequencies, prepend=0.0).min())
    if span * gap < _APART:
        raise GearbowError(
            f"orders {gap:.3g} Hz apart are told apart from {_APART / gap:.3g} s on, "
            f"the record holds {span:.3g} s: simulate for longer, or ask for fewer orders"
        )
    step = float(np.diff(time).max())
    if not math.isfinite(step) or step * frequencies[-1] >= 0.5:
        raise GearbowError(
            f"an order of {frequencies[-1]:.4g} Hz needs an output_step below "
            f"{0.5 / frequencies[-1]:.2g} s, got {step:.2g} s: record finer, or ask for fewer"
        )
