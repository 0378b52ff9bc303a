"""Spectra of signals, and spectra over the speed (waterfalls)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from gearbow._convert import checked, number, one_of, shown, text
from gearbow._extras import extra
from gearbow._result import Column, Figured, Result, WithSpeeds, in_micrometres, written_unit
from gearbow._shown import ReadOnly, Shown
from gearbow._types import Array, Record, SignalQuantity, Window
from gearbow.description.layout import Kinematics
from gearbow.description.places import is_pair, place, place_label
from gearbow.description.speed import SpeedProfile
from gearbow.errors import ChannelError, GearbowError, SceneError
from gearbow.recording import access
from gearbow.recording.channels import CHANNELS, PASS, LowPass, quantities
from gearbow.recording.record import SECTION_FORCES, Recorded, RunRecord, recorded_run
from gearbow.sensors import SignalSensor
from gearbow.units.speed import SpeedUnit, in_given_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Quantities of each kind of place: array, component and unit.
_MOTION, _MESH = (
    {quantity: (array, component, CHANNELS[array].unit) for quantity, array, component in known}
    for known in map(quantities, ("point", "mesh"))
)
#: Components of the force on a bearing.
_BEARING = {
    quantity.removeprefix("force_"): (array, component, CHANNELS[array].unit)
    for quantity, array, component in quantities("bearing")
    if quantity.startswith("force_")
}


@dataclass(frozen=True, eq=False)
class Channel(Shown):
    """A signal over time."""

    label: str
    unit: str
    values: Array


def channel(
    run: RunRecord, at: Record | SignalSensor, quantity: SignalQuantity | None = None
) -> Channel:
    """Find one recorded signal."""
    if isinstance(at, SignalSensor):
        if quantity is not None:
            raise ChannelError(f"quantity: a sensor has one signal; leave out {quantity!r}")
        return Channel(at.label, at.unit, at.measure(run))
    item: Any = place(at)
    if isinstance(item, tuple) and len(item) == 3:
        return _of_bearing(run, item, quantity)
    if item == "energy":
        _chosen(item, quantity, ["energy"])
        return Channel("energy", "J", access.energy(run))
    if is_pair(item):
        name = _chosen(item, quantity, ["force", *(name for name in _MESH if name != "force")])
        values = getattr(access.mesh(run, item), name)
        driver, driven = access.mesh_names(run, item)
        return Channel(f"{driver}/{driven} {name.replace('_', ' ')}", _MESH[name][2], values)
    name = _chosen(item, quantity, [*_MOTION, *SECTION_FORCES])
    if name in SECTION_FORCES:
        sections, forces = access.section_forces(run, item)
        index = access.at_side(sections, "before")
        values = forces[:, index, list(SECTION_FORCES).index(name)]
        label = f"{place_label(item)} {name.replace('_', ' ')}"
        return Channel(label, SECTION_FORCES[name], values)
    array, component, unit = _MOTION[name]
    motion = access.motion(run, array, item)  # type: ignore[arg-type]
    values = motion if component is None else motion[:, component]
    return Channel(f"{place_label(item)} {name}", unit, values)


def _of_bearing(
    run: RunRecord, item: tuple[str, str, float], quantity: SignalQuantity | None
) -> Channel:
    """Find a component of the force on a bearing, ("bearing", shaft, position)."""
    _, shaft, position = item
    name = _chosen(item, quantity, list(_BEARING))
    _, component, unit = _BEARING[name]
    if component is None:
        values = access.axial_bearing_force(run, (shaft, position))
    else:
        values = access.bearing_force(run, (shaft, position))[:, component]
    return Channel(f"bearing {shaft} at {position:g} m {name}", unit, values)


def _chosen(at: Record, quantity: SignalQuantity | None, names: list[str]) -> str:
    name = names[0] if quantity is None else quantity
    if text(name, "quantity") not in names:
        raise ChannelError(f"quantity: {at!r} has {', '.join(names)}, got {quantity!r}")
    return name


#: Coefficients of the window functions a₀ − a₁ cos + a₂ cos 2 − … after Heinzel, Rüdiger and
#: Schilling, *Spectrum and spectral density estimation by the DFT* (2002). A flat-top window gives
#: the amplitude of a sine between two spectral lines.
WINDOWS: dict[Window, tuple[float, ...]] = {
    "none": (1.0,),
    "hann": (0.5, 0.5),
    "flat top": (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
}


#: Smallest peak of a table of a spectrum, relative to the largest amplitude.
_SMALLEST_PEAK = 1e-3
#: Number of harmonics of the tooth frequencies with a name in a spectrum.
_NAMED_HARMONICS = 20


@dataclass(frozen=True, eq=False)
class Spectrum(WithSpeeds, Figured, ReadOnly):
    """Amplitudes against frequency. A sine of amplitude 1 on a spectral line gives 1.

    `plot` draws the amplitude on a logarithmic scale, up to the highest frequency with a
    signal. Marks show the peaks at orders of shafts, meshes, their sidebands and bearings; the
    largest have names.

    Parameters
    ----------
    frequencies_hz, amplitudes : ndarray, shape (n,)
        Frequencies above zero [Hz], and amplitudes in the unit of the signal.
    label, unit : str
        Name of the signal, e.g. "g1 v", and its unit.
    orders : tuple of (str, float)
        Names and frequencies [Hz] of the orders of the train at a constant speed.
    speed : float, optional
        Speed of the reference shaft [rad/s], if it is constant.
    periodic : bool
        Whether the record is a period of the motion, so that there is nothing between the lines.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> system.simulate(0.5, 100.0, record=["disk"], output_step=1e-3).spectrum("disk")
    Spectrum(disk y [m]; 250 frequencies)
    """

    frequencies_hz: Array
    amplitudes: Array
    label: str
    unit: str
    orders: tuple[tuple[str, float], ...] = field(default=(), repr=False)
    speed: float | None = None
    periodic: bool = False

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import orders as figures  # noqa: PLC0415

        factor, unit = written_unit(self.unit)
        return figures.spectrum(
            self.frequencies_hz,
            factor * self.amplitudes,
            f"{self.label} [{unit}]",
            orders=self.orders,
            periodic=self.periodic,
            ax=ax,
        )

    def _heading(self) -> list[str]:
        at = "" if self.speed is None else f" at {self._speed_text(self.speed)}"
        size = self.frequencies_hz.size
        end = f" up to {self.frequencies_hz[-1]:.4g} Hz" if size else ""
        peaks = f"peaks above {100.0 * _SMALLEST_PEAK:g} % of the largest"
        return [f"spectrum of {self.label}{at}: {size} frequencies{end}; {peaks}"]

    def _columns(self) -> list[Column]:
        """Give a row for each peak, the largest first, with the order that is nearest to it."""
        size, padded = self.amplitudes, np.pad(self.amplitudes, 1)
        is_peak = (size >= padded[:-2]) & (size > padded[2:])
        peaks = np.flatnonzero(is_peak & (size > _SMALLEST_PEAK * size.max(initial=0.0)))
        peaks = peaks[np.argsort(-size[peaks], kind="stable")]
        return [
            Column("frequency", self.frequencies_hz[peaks], "Hz"),
            Column("amplitude", size[peaks], self.unit, ".4g", in_micrometres(self.unit)),
            Column("order", [self._order(self.frequencies_hz[peak]) for peak in peaks]),
        ]

    def _series(self) -> list[Column]:
        return [
            Column("frequency", self.frequencies_hz, "Hz"),
            Column("amplitude", self.amplitudes, self.unit),
        ]

    def _order(self, frequency: float) -> str:
        """Name the order within a line of the spectrum; "" without one."""
        line = float(self.frequencies_hz[0])
        near = [(abs(hertz - frequency), name) for name, hertz in self.orders]
        distance, name = min(near, default=(np.inf, ""))
        return name if distance <= line else ""

    def __repr__(self) -> str:
        return f"Spectrum({self.label} [{self.unit}]; {self.frequencies_hz.size} frequencies)"


def amplitudes(time: Array, values: Array, window: Window = "hann") -> tuple[Array, Array]:
    """Find the amplitude spectra of signals along the first axis."""
    one_of(window, get_args(Window), "window")
    steps = np.diff(time)
    if steps.size < 2 or np.ptp(steps) > 1e-6 * abs(steps[0]) or steps[0] <= 0.0:
        raise GearbowError("a spectrum needs equally spaced times: give output_step to simulate")
    turn = 2.0 * np.pi * np.arange(time.size) / time.size
    weights = sum((-1) ** n * a * np.cos(n * turn) for n, a in enumerate(WINDOWS[window]))
    column = np.reshape(weights, (-1, *(1,) * (values.ndim - 1)))
    # Subtract the weighted mean: the amplitude at zero frequency is then exactly 0.
    mean = (column * values).sum(axis=0) / column.sum()
    amplitude = 2.0 * np.abs(np.fft.rfft((values - mean) * column, axis=0)) / column.sum()
    if time.size % 2 == 0:
        amplitude[-1] /= 2.0  # the line at half the sampling rate has no mirror image
    frequencies = np.asarray(np.fft.rfftfreq(time.size, steps.mean()), dtype=np.float64)
    return frequencies[1:], amplitude[1:]


@in_given_unit
def spectrum(
    run: RunRecord,
    at: Record | SignalSensor,
    quantity: SignalQuantity | None = None,
    *,
    window: Window | None = None,
) -> Spectrum:
    """Find the amplitude spectrum of a recorded signal."""
    signal = channel(run, at, quantity)
    chosen = default_window(run) if window is None else window
    frequencies, amplitude = amplitudes(run.time, signal.values, chosen)
    named = order_frequencies(run)
    speed = None if isinstance(run.speed, SpeedProfile) else abs(run.speed)
    return Spectrum(
        frequencies,
        amplitude,
        signal.label,
        signal.unit,
        named,
        speed,
        periodic=run.period is not None and chosen == "none",
    )


def default_window(run: RunRecord) -> Window:
    """Choose a window: none for a period of a motion, whose lines are exact without one."""
    return "hann" if run.period is None else "none"


def order_frequencies(run: RunRecord) -> tuple[tuple[str, float], ...]:
    """List the orders of a train with their frequencies."""
    if run.kinematics is None or isinstance(run.speed, SpeedProfile):
        return ()
    turns = abs(run.speed) / (2.0 * np.pi)
    found = run.kinematics.orders(mesh_harmonics=_NAMED_HARMONICS)
    return tuple((each.names[0], each.value * turns) for each in found)


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
    label, unit : str
        Name of the signal, e.g. "g1 v", and its unit.
    kinematics : Kinematics or None
        Speed ratios and tooth frequencies, which determine the order lines.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> options = {"record": ["disk"], "output_step": 1e-3}
    >>> runs = [system.simulate(0.5, speed, **options) for speed in (100.0, 120.0)]
    >>> gb.waterfall(runs, "disk").amplitudes.shape
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
        One run at a changing speed; or runs at constant speeds with equal times, in any order.
    at : str, tuple or SignalSensor
        A gear or disk, (shaft, x [m]), (driver, driven), ("bearing", shaft, x [m]) or "energy".
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
        The spectra by ascending speed; a run-up up to 0.4 of its samples in a revolution.

    Raises
    ------
    GearbowError
        If the speed of one of several runs changes, their times differ, those of a run-up are not
        equally spaced, or `revolutions` is longer than the run or given for several runs.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> options = {"record": ["disk"], "output_step": 1e-3}
    >>> runs = [system.simulate(1.0, speed, **options) for speed in (100.0, 200.0)]
    >>> gb.waterfall(runs, "disk").amplitudes.shape
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
