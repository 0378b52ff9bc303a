"""Waterfall diagram: spectra of one signal at several speeds, or over the speed of a run-up.

The signal of a run-up is sampled at equal angles of the reference shaft, so that each order is a
sine with a slowly varying amplitude (Fyfe and Munck, *Analysis of computed order tracking*, Mech.
Syst. Signal Process. 11, 1997). A spectrum of a segment has lines at multiples of the speed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import number, shown
from gearbow._extras import extra
from gearbow._lookup import checked
from gearbow._result import Column, Result, WithSpeeds, in_micrometres, written_unit
from gearbow._shown import ReadOnly
from gearbow._types import Array, Record, SignalQuantity, Window
from gearbow.description.layout import Kinematics
from gearbow.description.speed import SpeedProfile
from gearbow.errors import GearbowError, SceneError
from gearbow.orders.spectrum import amplitudes, channel, spectrum
from gearbow.recording import access
from gearbow.recording.channels import PASS, LowPass
from gearbow.recording.record import Recorded, RunRecord, recorded_run
from gearbow.sensors import SignalSensor
from gearbow.units.speed import SpeedUnit, in_given_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Length of the segments of a run-up by default, relative to the run, and distance of neighbouring
#: segments, relative to their length.
_PART, _DISTANCE = 1 / 16, 0.25


@dataclass(frozen=True, eq=False)
class Waterfall(WithSpeeds, Result, ReadOnly):
    """Spectra of one signal at several speeds.

    Parameters
    ----------
    speeds : ndarray, shape (rows,)
        Speeds of the reference shaft, ascending [rad/s]: of the runs, or of segments of a run-up.
    frequencies_hz : ndarray, shape (n,) or (rows, n)
        Frequencies above zero [Hz]. In a run-up, each segment has its own: multiples of its speed.
    amplitudes : ndarray, shape (rows, n)
        Amplitudes in the unit of the signal.
    label : str
        Name of the signal, e.g. "g1 v".
    unit : str
        Unit of the signal.
    kinematics : Kinematics or None
        Speed ratios and tooth frequencies, which determine the order lines.

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4,
    ...                  bow=gb.Bow.half_sine(1e-4))
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem([rotor], bearings=bearings)
    >>> options = {"record": [("rotor", 0.5)], "output_step": 1e-3}
    >>> runs = [system.simulate(0.5, speed, **options) for speed in (100.0, 120.0)]
    >>> gb.waterfall(runs, ("rotor", 0.5)).amplitudes.shape
    (2, 250)
    """

    speeds: Array
    frequencies_hz: Array
    amplitudes: Array
    label: str
    unit: str
    kinematics: Kinematics | None = field(repr=False)

    def plot(
        self, highest: float | None = None, *, ax: Any = None, speed_unit: SpeedUnit | None = None
    ) -> "Figure":
        """Draw amplitudes against speed and frequency, with the order lines of shafts and meshes.

        Parameters
        ----------
        highest : float, optional
            Largest frequency of the figure [Hz]; None includes all visible amplitudes.
        ax : Axes, optional
            Panel for the diagram; None makes a new figure.
        speed_unit : str, optional
            Unit of the axis of speeds, as for `table`; None is that of the given ones.

        Returns
        -------
        matplotlib.figure.Figure
            Colours show the amplitude over three decades.
        """
        with extra("plot"):
            from gearbow.plotting import orders as figures  # noqa: PLC0415

        factor, unit = written_unit(self.unit)
        lines = () if self.kinematics is None else self.kinematics.orders(1, 4, 0)
        with self._showing(speed_unit):
            return figures.waterfall(
                self.speeds,
                self.frequencies_hz,
                factor * self.amplitudes,
                f"{self.label} [{unit}]",
                lines=[(line.names[0], line.value) for line in lines],
                highest=None if highest is None else number(highest, "highest"),
                ax=ax,
            )

    def _frequencies(self) -> Array:
        """Give the frequency of each amplitude [Hz]; those of a run-up differ from row to row."""
        return np.broadcast_to(self.frequencies_hz, self.amplitudes.shape)

    def _heading(self) -> list[str]:
        speeds = f"{self.speeds.size} speeds, {self._speed_text(self.speeds)}"
        return [f"spectra of {self.label}, {speeds}"]

    def _columns(self) -> list[Column]:
        """Give a row for each speed, with its largest amplitude."""
        largest = self.amplitudes.argmax(axis=1, keepdims=True)
        frequencies = np.take_along_axis(self._frequencies(), largest, axis=1)[:, 0]
        amplitudes, written = self.amplitudes.max(axis=1), in_micrometres(self.unit)
        orders = np.divide(
            2.0 * np.pi * frequencies,
            self.speeds,
            out=np.full(self.speeds.shape, np.nan),
            where=self.speeds > 0.0,
        )
        return [
            Column("speed", self.speeds, "rad/s", ".2f"),
            Column("largest amplitude", amplitudes, self.unit, ".4g", written),
            Column("frequency", frequencies, "Hz"),
            Column("order", orders),
        ]

    def _series(self) -> list[Column]:
        return [
            Column("speed", np.repeat(self.speeds, self.amplitudes.shape[1]), "rad/s"),
            Column("frequency", self._frequencies().ravel(), "Hz"),
            Column("amplitude", self.amplitudes.ravel(), self.unit),
        ]


@checked
@in_given_unit
def waterfall(
    responses: Recorded | Sequence[Recorded],
    at: Record | SignalSensor,
    quantity: SignalQuantity | None = None,
    *,
    window: Window | None = None,
    revolutions: float | None = None,
) -> Waterfall:
    """Collect the spectra of runs at several speeds, or of segments of one run-up.

    Parameters
    ----------
    responses : Response or sequence of Response
        One run at a changing speed; or runs at constant speeds, in any order, with equal output
        steps and numbers of times.
    at : str, tuple or SignalSensor
        A gear or disk, (shaft, position [m]), (driver, driven), ("bearing", shaft, position [m])
        or "energy".
    quantity : str, optional
        Quantity, as for `Response.spectrum`.
    window : {"hann", "flat top", "none"}, optional
        Window function, as for `Response.spectrum`.
    revolutions : float, optional
        Length of the segments of a run-up in revolutions of the reference shaft. Orders with a
        distance of 2/`revolutions` have separate lines. None is a sixteenth of the run. Two
        neighbouring segments have three quarters in common.

    Returns
    -------
    Waterfall
        The spectra, by ascending speed. Those of a run-up end at 0.4 times the samples in a
        revolution at the highest speed.

    Raises
    ------
    GearbowError
        If the speed of one of several runs changes, or their output steps or numbers of times
        differ. If the times of a run-up are not equally spaced, or `revolutions` is longer than the
        run or given for several runs.

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4,
    ...                  bow=gb.Bow.half_sine(1e-4))
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> middle = ("rotor", 0.5)
    >>> runs = [
    ...     system.simulate(1.0, speed, output_step=1e-3, record=[middle])
    ...     for speed in (100.0, 200.0)
    ... ]
    >>> result = gb.waterfall(runs, middle)
    >>> result.amplitudes.shape
    (2, 500)
    """
    if isinstance(responses, Sequence) or not hasattr(responses, "_to_record"):
        if revolutions is not None:
            raise GearbowError("revolutions: only one run-up has segments, not several runs")
        return _of_runs(_runs(responses), at, quantity, window)
    run = recorded_run(responses, "responses")
    return _of_segments(run, at, quantity, window or "hann", revolutions)


def _of_runs(
    runs: list[RunRecord],
    at: Record | SignalSensor,
    quantity: SignalQuantity | None,
    window: Window | None,
) -> Waterfall:
    """Collect the spectra of runs at constant speeds."""
    speeds = []
    for run in runs:
        if isinstance(run.speed, SpeedProfile):
            raise GearbowError(
                "a waterfall of several runs needs constant speeds; the speed of one run changes"
            )
        speeds.append(abs(run.speed))
    spectra = [spectrum(run, at, quantity, window=window) for run in runs]
    first = spectra[0]
    for other in spectra[1:]:
        if other.frequencies_hz.shape != first.frequencies_hz.shape or not np.allclose(
            other.frequencies_hz, first.frequencies_hz, rtol=1e-6, atol=0.0
        ):
            raise GearbowError(
                "a waterfall needs runs of one duration and one output_step: "
                "their spectra have different frequencies"
            )
    order = np.argsort(speeds, kind="stable")
    return Waterfall(
        np.array(speeds)[order],
        first.frequencies_hz,
        np.array([each.amplitudes for each in spectra])[order],
        first.label,
        first.unit,
        runs[0].kinematics,
    )


def _of_segments(
    run: RunRecord,
    at: Record | SignalSensor,
    quantity: SignalQuantity | None,
    window: Window,
    revolutions: float | None,
) -> Waterfall:
    """Find the spectra of segments of a run with equal angles of the reference shaft."""
    signal = channel(run, at, quantity)
    span = float(np.ptp(access.reference_angle(run))) / (2.0 * np.pi) if run.time.size else 0.0
    length = _PART * span if revolutions is None else number(revolutions, "revolutions")
    if not 0.0 < length <= span:
        raise GearbowError(
            f"revolutions: must be positive and at most the {span:.6g} revolutions of the run, "
            f"got {length:g}; the train must rotate"
        )
    reference = None if run.kinematics is None else run.kinematics.reference
    if reference is None:
        raise GearbowError("the angles of the shafts are unknown: the response has no kinematics")
    low_pass = LowPass.of(run, None, reference)
    (values,) = low_pass.apply([signal.values])
    rate = low_pass.rate
    turns = np.arange(values.size) / rate
    size = min(values.size, max(3, round(length * rate)))
    count = max(1, round((values.size - size) / (_DISTANCE * size)) + 1)
    begins = np.rint(np.linspace(0.0, values.size - size, count)).astype(np.intp)
    spectra = [amplitudes(turns[:size], values[i : i + size], window) for i in begins]
    lines = spectra[0][0]
    kept = lines <= PASS * rate
    middles = low_pass.times[begins + size // 2]
    speeds = np.abs(access.speeds(run, middles))
    order = np.argsort(speeds, kind="stable")
    return Waterfall(
        speeds[order],
        np.outer(speeds[order] / (2.0 * np.pi), lines[kept]),
        np.array([found[kept] for _, found in spectra])[order],
        signal.label,
        signal.unit,
        run.kinematics,
    )


def _runs(responses: object) -> list[RunRecord]:
    """Give the data of at least one response."""
    try:
        runs = [recorded_run(each, "responses") for each in responses]  # type: ignore[attr-defined]
    except (TypeError, SceneError):
        runs = []
    if not runs:
        raise SceneError(
            f"responses: must be a list of at least one response, got {shown(responses)}"
        )
    return runs
