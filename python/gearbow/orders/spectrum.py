"""One recorded signal, and its amplitude spectrum."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from gearbow._convert import text
from gearbow._lookup import one_of
from gearbow._result import Column, Figured, WithSpeeds, in_micrometres, written_unit
from gearbow._shown import ReadOnly, Shown
from gearbow._types import Array, Record, SignalQuantity, Window
from gearbow.description.places import is_pair, place, place_label
from gearbow.description.speed import SpeedProfile
from gearbow.errors import ChannelError, GearbowError
from gearbow.recording import access
from gearbow.recording.channels import CHANNELS, quantities
from gearbow.recording.record import SECTION_FORCES, RunRecord
from gearbow.sensors import SignalSensor
from gearbow.units.speed import in_given_unit

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
    frequencies_hz : ndarray, shape (n,)
        Frequencies above zero [Hz].
    amplitudes : ndarray, shape (n,)
        Amplitudes in the unit of the signal.
    label : str
        Name of the signal, e.g. "g1 v".
    unit : str
        Unit of the signal.
    orders : tuple of (str, float)
        Names and frequencies [Hz] of the orders of the train at a constant speed.
    speed : float, optional
        Speed of the reference shaft [rad/s], if it is constant.
    periodic : bool
        Whether the record is a period of the motion, so that there is nothing between the lines.

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4,
    ...                  bow=gb.Bow.half_sine(1e-4))
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem([rotor], bearings=bearings)
    >>> middle = ("rotor", 0.5)
    >>> response = system.simulate(0.5, 100.0, record=[middle], output_step=1e-3)
    >>> response.spectrum(middle)
    Spectrum(rotor at 0.5 m y [m]; 250 frequencies)
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
