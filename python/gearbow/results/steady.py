"""Steady states of periodic motions, and branches of them over a parameter."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from gearbow._convert import number as number_of, one_of
from gearbow._core import Model, multipliers
from gearbow._extras import extra
from gearbow._progress import working
from gearbow._result import Column, WithSpeeds, data_frame, in_micrometres, written_unit
from gearbow._shown import read_only, short
from gearbow._types import (
    Array,
    At,
    ComplexArray,
    Record,
    RunData,
    Side,
    SignalQuantity,
    Statistic,
)
from gearbow.description.places import is_pair
from gearbow.errors import GearbowError
from gearbow.orders.spectrum import channel
from gearbow.recording.channels import CHANNELS, signals, with_signals
from gearbow.recording.container import (
    any_number,
    each,
    number,
    optional,
    record,
    row,
    text,
    typed,
    whole,
)
from gearbow.recording.record import RunRecord
from gearbow.results.response import Response, Stored
from gearbow.results.run_figures import plot
from gearbow.results.section_forces import SectionForces
from gearbow.units.speed import SpeedUnit

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


#: Magnitude of the smallest multiplier that `SteadyState.multipliers` gives by default.
SMALLEST_MULTIPLIER = 0.9
#: Error of a multiplier. A motion with undamped modes, whose multipliers have the magnitude 1,
#: counts as stable.
_ERROR = 1e-6
#: Angle of a multiplier within which it counts as real [rad]: two real multipliers that meet have
#: angles of the square root of their error.
_REAL = 1e-3
#: Part of the record after which the multipliers of a motion without a period are given.
_PART = 0.1

#: Further entries of the metadata of a file.
_STEADY = record(
    period=any_number,
    residual=number,
    periods=whole,
    method=text,
    multipliers=optional(each(row(number, number))),
)


def instability(values: ComplexArray) -> str | None:
    """Name the instability of a periodic motion by its largest multiplier."""
    if not values.size:
        return None
    largest = values[np.argmax(np.abs(values))]
    if not abs(largest) > 1.0 + _ERROR:
        return None
    angle = abs(np.angle(largest))
    if angle < _REAL:
        return "fold"
    return "flip" if np.pi - angle < _REAL else "Neimark-Sacker"


class SteadyState(WithSpeeds, Stored):
    """The motion that repeats after each period, made by `gearbow.RotorSystem.steady_state`.

    Attributes
    ----------
    response : Response
        One period of the motion, without the instant at its end. Without a period, a part of it.
    period : float
        Period [s]; infinite for a motion without a common period.
    residual : float
        Difference of the state after one more period, relative to the motion about the
        equilibrium, both in the energy norm, which is zero for no difference. It is measured by a
        run with the given tolerance. For a sum, the largest of them; for
        a quasi-periodic motion, the part of the state at the begin of the record that is transient.
    periods : int
        Number of integrated periods with the recorded one; without a period, of the slowest source.
    method : {"linear", "nonlinear", "superposition", "quasi-periodic"}
        Whether the state after a period is an affine function of the state before; or how a motion
        without a common period was found: as a sum of motions, or by running in.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> steady = system.steady_state(100.0, record=["disk"])
    >>> print(f"{steady.period:.4f} s, stable: {steady.is_stable()}")
    0.0628 s, stable: True
    """

    _indexed = True

    def __init__(
        self, response: Response, data: dict[str, Any], model: Model | None = None
    ) -> None:
        self.response = response
        self.period: float = data["period"]
        self.residual: float = data["residual"]
        self.periods: int = data["periods"]
        self.method: str = data["method"]
        # The orders of the response follow from the period.
        response.period = self.period if math.isfinite(self.period) else None
        self.speed_unit = response.speed_unit
        self._model = model
        found = data.get("multipliers")
        self._multipliers = None if found is None else np.array([complex(*z) for z in found])
        self._largest = self._multipliers

    def multipliers(self, magnitude: float = SMALLEST_MULTIPLIER) -> ComplexArray:
        """Compute the Floquet multipliers, the largest first.

        They are the eigenvalues of the derivative of the state after a period with respect to the
        state before; for a motion without a period, after a tenth of the record. The rigid-body
        rotation of a train that nothing holds is left out. Modes that the run left out have the
        multipliers e^{λT} of the linear system. Those of the default magnitude are saved with it.

        Parameters
        ----------
        magnitude : float
            Smallest magnitude. The smaller it is, the more periods the computation takes.

        Returns
        -------
        ndarray, shape (m,)
            Complex multipliers.

        Raises
        ------
        ConvergenceError
            If a multiplier is not accurate.
        GearbowError
            If the motion does not know its system.
        """
        smallest = number_of(magnitude, "magnitude")
        if smallest != SMALLEST_MULTIPLIER:
            return self._computed(smallest)
        if self._multipliers is None:
            self._multipliers = self._computed(smallest)
        found: ComplexArray = self._multipliers.copy()
        return found

    def largest_multiplier(self) -> float:
        """Compute the magnitude of the largest multiplier, which decides about the stability.

        It takes fewer periods than all `multipliers` do, and none if these are known.

        Returns
        -------
        float
            Magnitude; 0 if all are below the default magnitude of `multipliers`.
        """
        return float(np.abs(self._largest_multipliers()).max(initial=0.0))

    def _largest_multipliers(self) -> ComplexArray:
        """Give the largest multipliers of the default magnitude; smaller ones may be missing."""
        if self._multipliers is not None:
            return self._multipliers
        if self._largest is None:
            self._largest = self._computed(SMALLEST_MULTIPLIER, only_largest=True)
        return self._largest

    def _computed(self, smallest: float, *, only_largest: bool = False) -> ComplexArray:
        """Compute the multipliers from a magnitude on."""
        request = self.response.request
        if request is None:
            raise GearbowError(
                "multipliers: this motion does not know its system; take that of steady_state"
            )
        model = self._model or Model(dict(request.description))
        options = dict(request.options)
        if math.isinf(self.period):
            options["duration"] *= _PART
        with working(None, "multipliers"):
            return multipliers(
                model, **options, smallest=smallest, progress=None, only_largest=only_largest
            )

    def section_forces(self, at: At, side: Side = "before") -> SectionForces:
        """Section forces of a shaft over the recorded period, as `Response.section_forces`.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, (shaft, position [m]), or the name of a shaft.
        side : {"before", "beyond"}
            Side of a node.

        Returns
        -------
        SectionForces
            N, Q_y, Q_z, M_y, M_z and T at each time.
        """
        return self.response.section_forces(at, side)

    def is_stable(self) -> bool:
        """Return whether small disturbances decay.

        Returns
        -------
        bool
            Whether none of the `multipliers` lies outside the unit circle, of which only the
            largest are computed. A motion that ran in has shown it: the difference of two runs
            has decayed.
        """
        return self.instability() is None

    def instability(self) -> str | None:
        """Name the kind of the instability.

        Returns
        -------
        str or None
            "fold", "flip" or "Neimark-Sacker", as which it ran in; None for a stable motion.
        """
        if self.method == "quasi-periodic":
            return None
        return instability(self._largest_multipliers())

    plot = plot

    def _to_record(self) -> RunRecord:
        """Give the recorded period as plain data."""
        return self.response._to_record()

    def _stored(self) -> tuple[RunRecord, dict[str, Any]]:
        found = self._multipliers
        steady = {
            "period": self.period,
            "residual": self.residual,
            "periods": self.periods,
            "method": self.method,
            "multipliers": None if found is None else [[z.real, z.imag] for z in found.tolist()],
        }
        return self._to_record(), {"steady": steady}

    @classmethod
    def _restored(cls, run: RunRecord, about: dict[str, Any], path: Any) -> "SteadyState":
        if "steady" not in about:
            raise GearbowError(f"{path}: is a response, not a steady state; use Response.load")
        _STEADY(about["steady"], "steady")
        return cls(Response._from_record(run), about["steady"])

    def __getstate__(self) -> dict[str, Any]:
        # The response knows the scene, from which the model can be built again.
        return {**self.__dict__, "_model": None}

    def __repr__(self) -> str:
        return (
            f"SteadyState(period {self.period:g} s, residual {self.residual:.1e}, "
            f"{self.response.time.size} times)"
        )

    def _heading(self) -> list[str]:
        """Give period, method and residual, and the stability if it is known."""
        state = ""
        if self._multipliers is not None:
            state = "; stable" if self.is_stable() else f"; unstable: {self.instability()}"
        period = "without a common period" if math.isinf(self.period) else f"{self.period:.6g} s"
        return [
            f"steady state: period {period}, {self.method}, residual {self.residual:.1e}{state}",
            *self.response._heading(),
        ]

    def _columns(self) -> list[Column]:
        return self.response._columns()

    def _series(self) -> list[Column]:
        return self.response._series()


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
            Columns with their unit: parameter, "stable", "kind", statistics and amplitude.
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
