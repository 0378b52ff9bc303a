"""A branch of steady states over a parameter: amplitudes, stability, special points, files."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from gearbow._extras import extra
from gearbow._lookup import one_of
from gearbow._result import Column, WithSpeeds, data_frame, in_micrometres, written_unit
from gearbow._shown import read_only, short
from gearbow._types import Array, ComplexArray, Record, RunData, SignalQuantity, Statistic
from gearbow.description.places import is_pair
from gearbow.errors import GearbowError
from gearbow.orders.spectrum import channel
from gearbow.recording.channels import CHANNELS, signals, with_signals
from gearbow.recording.container import typed
from gearbow.recording.record import RunRecord
from gearbow.results.response import Response, Stored
from gearbow.results.steady import instability
from gearbow.units.speed import SpeedUnit

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

#: Unit of each parameter; torque and bow are factors.
UNITS = {"speed": "rad/s", "torque": "", "bow": "", "backlash": "m"}
#: Statistics of a signal over a period, in the order of the rows of each point.
STATISTICS: tuple[Statistic, ...] = get_args(Statistic)


@dataclass
class BranchData:
    """Points of a branch as plain data."""

    parameter: str
    speed: float
    unknowns: int
    values: list[float]
    kinds: list[str]
    multipliers: list[list[tuple[float, float]]]
    message: str = ""


class Continuation(WithSpeeds, Stored):
    """A branch of steady states, made by `gearbow.RotorSystem.continuation`.

    Parameters
    ----------
    signals : Response
        Minimum, maximum, mean and root mean square about the mean of each recorded signal over a
        period: four rows for each point.
    data : BranchData
        The points.

    Attributes
    ----------
    parameter : {"speed", "torque", "bow", "backlash"}
        The parameter.
    values : ndarray, shape (p,)
        Its value at each point, in the order along the branch: it turns at folds.
    multipliers : tuple of ndarray
        Floquet multipliers of each point, the largest first.
    stable : ndarray of bool, shape (p,)
        Whether small disturbances of each motion decay.
    kinds : tuple of str
        "" for an ordinary point, or "fold", "flip", "contact loss" for a located one.
    folds, flips, contact_loss : ndarray
        Values at the located points of each kind.
    message : str
        Why the branch ended before the end of the interval; "" if it did not.

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=2, bow=bow)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=1e3) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> branch = system.continuation("bow", 1.0, 2.0, speed=100.0, record=[("rotor", 0.5)])
    >>> amplitude = branch.amplitude(("rotor", 0.5))
    >>> print(f"{amplitude[-1] / amplitude[0]:.3f}", branch.stable.all())
    2.000 True
    """

    def __init__(self, signals: Response, data: BranchData) -> None:
        self._signals, self._data = signals, data
        self.speed_unit = signals.speed_unit
        self.parameter = data.parameter
        self.message = data.message
        self.values: Array = np.array(data.values)
        self.kinds = tuple(data.kinds)
        self.multipliers: tuple[ComplexArray, ...] = tuple(
            np.array([complex(*z) for z in found]) for found in data.multipliers
        )
        self.stable: NDArray[np.bool_] = np.array(
            [instability(found) is None for found in self.multipliers], dtype=bool
        )
        self.folds, self.flips, self.contact_loss = (
            self.values[np.array(self.kinds) == kind] for kind in ("fold", "flip", "contact loss")
        )
        read_only(vars(self))

    def amplitude(self, at: Record, quantity: SignalQuantity | None = None) -> Array:
        """Give half of the peak-to-peak value of a signal over a period.

        Parameters
        ----------
        at : str or tuple
            Place of the signal, as for `Response.spectrum`.
        quantity : str, optional
            Quantity, as for `Response.spectrum`.

        Returns
        -------
        ndarray, shape (p,)
            Amplitude at each point.
        """
        return (self.statistic("max", at, quantity) - self.statistic("min", at, quantity)) / 2.0

    def statistic(
        self, name: Statistic, at: Record, quantity: SignalQuantity | None = None
    ) -> Array:
        """Give one number that describes a signal over a period.

        Parameters
        ----------
        name : {"min", "max", "mean", "rms"}
            The number; "rms" is the root mean square about the mean.
        at : str or tuple
            Place of the signal, as for `Response.spectrum`.
        quantity : str, optional
            Quantity, as for `Response.spectrum`.

        Returns
        -------
        ndarray, shape (p,)
            The number at each point.
        """
        return self._statistic(one_of(name, STATISTICS, "name"), at, quantity)

    def _statistic(self, name: str, at: Record, quantity: SignalQuantity | None) -> Array:
        """Give one statistic of a signal at each point."""
        found: Array = channel(self._signals._to_record(), at, quantity).values
        chosen: Array = found[STATISTICS.index(name) :: len(STATISTICS)].copy()
        return chosen

    def plot(
        self,
        at: Record | None = None,
        quantity: SignalQuantity | None = None,
        *,
        statistic: Statistic | None = None,
        speed_unit: SpeedUnit | None = None,
        ax: Any = None,
    ) -> "Figure":
        """Draw a signal over the parameter: stable motions solid, unstable ones dashed.

        A branch that ends before the end of its interval has an open circle at its last point.

        Parameters
        ----------
        at : str or tuple, optional
            Place of the signal, as for `Response.spectrum`; None is the first recorded mesh, or the
            first recorded place of a system without meshes.
        quantity : str, optional
            Quantity, as for `Response.spectrum`.
        statistic : {"min", "max", "mean", "rms"}, optional
            Number that describes the signal; None is the amplitude.
        speed_unit : str, optional
            Unit of the axis of a branch over the speed, as for `table`; None is the given one.
        ax : Axes, optional
            Panel for the branch; None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            The figure. It is neither shown nor saved.

        Raises
        ------
        GearbowError
            If nothing was recorded, or `ax` is not one panel.
        """
        with extra("plot"):
            from gearbow.plotting import analyses as figures  # noqa: PLC0415
            from gearbow.plotting.style import speed_axis  # noqa: PLC0415

        with self._showing(speed_unit):
            factor, label = speed_axis()
        if self.parameter != "speed":
            unit = UNITS[self.parameter]
            factor, unit = written_unit(unit)
            label = f"{self.parameter} [{unit}]" if unit else f"{self.parameter} factor"
        at = self._first() if at is None else at
        name = channel(self._signals._to_record(), at, quantity)
        values = (
            self.amplitude(at, quantity)
            if statistic is None
            else self._statistic(one_of(statistic, STATISTICS, "statistic"), at, quantity)
        )
        size, unit = written_unit(name.unit)
        return figures.branch(
            factor * self.values,
            size * values,
            self.stable,
            self.kinds,
            is_open=bool(self.message),
            labels=(label, f"{statistic or 'amplitude'} of {name.label} [{unit}]"),
            ax=ax,
        )

    def to_dataframe(
        self, at: Record | None = None, quantity: SignalQuantity | None = None
    ) -> "pd.DataFrame":
        """Give the branch as a table with one row for each point.

        Parameters
        ----------
        at : str or tuple, optional
            Place of the signal, as for `plot`.
        quantity : str, optional
            Quantity, as for `Response.spectrum`.

        Returns
        -------
        pandas.DataFrame
            Columns with their unit: the parameter, "stable", "kind", and the statistics and the
            amplitude of the signal.
        """
        return data_frame(self._of(self._first() if at is None else at, quantity))

    def _of(self, at: Record, quantity: SignalQuantity | None = None) -> list[Column]:
        """Give a row for each point, with the statistics and the amplitude of a signal."""
        name = channel(self._signals._to_record(), at, quantity)
        found: dict[str, Array] = {each: self.statistic(each, at, quantity) for each in STATISTICS}
        found["amplitude"] = self.amplitude(at, quantity)
        written = in_micrometres(name.unit)
        return [
            *self._points(),
            *(
                Column(f"{each} of {name.label}", values, name.unit, ".4g", written)
                for each, values in found.items()
            ),
        ]

    def _points(self) -> list[Column]:
        unit = UNITS[self.parameter]
        name = self.parameter if unit else f"{self.parameter} factor"
        return [
            Column(name, self.values, unit, ".6g"),
            Column("stable", self.stable),
            Column("kind", self.kinds),
        ]

    def _heading(self) -> list[str]:
        at = "" if self.parameter == "speed" else f" at {self._speed_text(self._data.speed)}"
        lines = [f"branch of steady states over the {self.parameter}{at}"]
        return [*lines, f"open end: {self.message}"] if self.message else lines

    def _columns(self) -> list[Column]:
        return self._of(self._first()) if self._signals.recorded else self._points()

    def _first(self) -> Record:
        """Give the first recorded mesh, or the first recorded place."""
        recorded = sorted(self._signals.recorded, key=lambda item: not is_pair(item))
        if not recorded:
            raise GearbowError("nothing was recorded; give record=['meshes'] to continuation")
        return recorded[0]

    def _stored(self) -> tuple[RunRecord, dict[str, Any]]:
        return self._signals._to_record(), {"branch": vars(self._data)}

    @classmethod
    def _restored(cls, run: RunRecord, about: dict[str, Any], path: Any) -> "Continuation":
        if "branch" not in about:
            raise GearbowError(f"{path}: is not a continuation")
        typed(BranchData)(about["branch"], "branch")
        return cls(Response._from_record(run), BranchData(**about["branch"]))

    def __repr__(self) -> str:
        span = f"{self.values[0]:g} to {self.values[-1]:g}" if self.values.size else "empty"
        return (
            f"Continuation({self.parameter} {span}, {self.values.size} points, "
            f"{self.folds.size} folds, {self.flips.size} flips"
            f"{f', open end: {short(self.message)}' if self.message else ''})"
        )


def summary(periods: Sequence[RunData]) -> RunData:
    """Describe each signal of recorded periods by four numbers, as rows of one recording."""
    recorded = [signals(period) for period in periods]
    found = {
        name: _numbers([period[name] for period in recorded])
        for name, channel in CHANNELS.items()
        if name in recorded[-1] and channel.owner is not None
    }
    time = np.arange(len(STATISTICS) * len(periods), dtype=float)
    return with_signals({**periods[-1], "events": []}, time, found)


def _numbers(series: Sequence[Array]) -> Array:
    """Give the numbers of one signal at all points."""
    rows = [np.stack([a.min(axis=0), a.max(axis=0), a.mean(axis=0), a.std(axis=0)]) for a in series]
    return np.concatenate(rows)
