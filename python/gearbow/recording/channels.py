"""Channels of a recorded run, their tables, and records at a lower rate.

Files, tables, data sets, spectra and sensors read this table. The core lists what a run can record
of a mesh or a bearing (`Connection::channels`).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from gearbow._convert import number
from gearbow._core import connection_channels
from gearbow._extras import extra
from gearbow._result import Column, written_unit
from gearbow._times import crossings
from gearbow._types import Array, RunData
from gearbow.description.places import place_label
from gearbow.description.speed import plain_speed
from gearbow.errors import GearbowError
from gearbow.recording import access
from gearbow.recording.access import ENERGIES, WORKS
from gearbow.recording.record import SECTION_FORCES, RunRecord

if TYPE_CHECKING:
    import xarray as xr


#: Entry of the data of a run that lists the places of each kind of owner.
OWNERS = {
    "point": "points",
    "mesh": "meshes",
    "bearing": "bearings",
    "rolling": "rolling_bearings",
    "section": "sections",
}


class RecordedChannel(NamedTuple):
    """One array over time; arrays of one `group` may be absent together."""

    unit: str
    owner: str | None
    quantities: tuple[str, ...]
    group: str | None = None

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes of the array."""
        owner = () if self.owner is None else (self.owner,)
        axis = {1: (), 2: ("axis",), 3: ("component",)}[len(self.quantities)]
        return ("time", *owner, *axis)


def _connections(owner: str) -> dict[str, RecordedChannel]:
    """List the quantities of a kind of connection, an array each."""
    return {
        f"{owner}_{name}": RecordedChannel(unit, owner, (name,))
        for name, unit in connection_channels()[owner].items()
    }


_point = "point"
_SECTION = tuple(SECTION_FORCES)
#: Every array over time, by its name in a file.
CHANNELS: dict[str, RecordedChannel] = {
    "displacement": RecordedChannel("m", _point, ("y", "z")),
    "twist": RecordedChannel("rad", _point, ("twist",)),
    "axial": RecordedChannel("m", _point, ("x",), "axial"),
    "velocity": RecordedChannel("m/s", _point, ("velocity_y", "velocity_z"), "velocity"),
    "twist_rate": RecordedChannel("rad/s", _point, ("twist_rate",), "twist_rate"),
    "acceleration": RecordedChannel(
        "m/s²", _point, ("acceleration_y", "acceleration_z"), "acceleration"
    ),
    "axial_velocity": RecordedChannel("m/s", _point, ("velocity_x",), "axial_velocity"),
    "axial_acceleration": RecordedChannel(
        "m/s²", _point, ("acceleration_x",), "axial_acceleration"
    ),
    **_connections("mesh"),
    "bearing_force": RecordedChannel("N", "bearing", tuple(connection_channels()["bearing"])),
    "axial_bearing_force": RecordedChannel("N", "bearing", ("force_x",), "axial"),
    "bearing_displacement": RecordedChannel(
        "m", "bearing", ("displacement_y", "displacement_z"), "bearing_displacement"
    ),
    **_connections("rolling"),
    "section_force": RecordedChannel("N", "section", _SECTION[:3], "section"),
    "section_moment": RecordedChannel("N m", "section", _SECTION[3:], "section"),
    "energy": RecordedChannel("J", None, ("energy",), "energy"),
    **{
        f"energy_{name}": RecordedChannel("J", None, (f"energy {name}",), "energy")
        for name in ENERGIES
    },
    **{f"energy_{name}": RecordedChannel("J", None, (f"work {name}",), "energy") for name in WORKS},
}


def quantities(owner: str) -> Iterator[tuple[str, str, int | None]]:
    """Give each quantity of a kind of owner with its array and its component in it."""
    for name, channel in CHANNELS.items():
        if channel.owner == owner:
            for component, quantity in enumerate(channel.quantities):
                yield quantity, name, component if len(channel.quantities) > 1 else None


def signals(data: RunData) -> dict[str, Array]:
    """Collect the recorded arrays over time in the order of the table."""
    plain: dict[str, Any] = dict(data)
    found = {name: plain[name] for name in CHANNELS if plain.get(name) is not None}
    for owner, values in (("mesh", data["mesh"]), ("energy", data["energy_terms"] or {})):
        found |= {f"{owner}_{name}": series for name, series in values.items()}
    if data["rolling_bearings"]:
        for k, (_, name, _) in enumerate(quantities("rolling")):
            found[name] = data["rolling_contact"][:, :, k].copy()
    return {name: found[name] for name in CHANNELS if name in found}


def with_signals(data: Mapping[str, Any], time: Array, found: Mapping[str, Array]) -> RunData:
    """Replace the times of a run and its arrays over time."""

    def _nested(owner: str) -> dict[str, Array]:
        begin = f"{owner}_"
        return {k.removeprefix(begin): v for k, v in found.items() if k.startswith(begin)}

    rolling = list(_nested("rolling").values())
    nothing = np.empty((time.size, 0, sum(1 for _ in quantities("rolling"))))
    plain: dict[str, Any] = {
        **data,
        **{k: v for k, v in found.items() if not k.startswith(("mesh_", "rolling_", "energy_"))},
        "time": time,
        "mesh": _nested("mesh"),
        "rolling_contact": np.stack(rolling, 2) if rolling else nothing,
        "energy": found.get("energy"),
        "energy_terms": _nested("energy") or None,
    }
    return plain  # type: ignore[return-value]


#: Size of a mean value that is an error of the times of a run, relative to its extremes.
_ROUND_OFF = 1e-4
#: Number of the file format. It increases if older readers cannot read a newer file.
FORMAT = 1


def to_xarray(run: RunRecord) -> "xr.Dataset":
    """Convert a recorded run to a data set with units."""
    with extra("netcdf"):
        import xarray as xr  # noqa: PLC0415

    arrays = {name: values for name, values in arrays_of(run).items() if values.size}
    data = run.data
    variables: dict[str, Any] = {}
    for name, values in arrays.items():
        if name in CHANNELS:
            channel = CHANNELS[name]
            variables[name] = (channel.axes, values, {"units": channel.unit})
        elif name.startswith("final_"):
            variables[name] = ((f"{name}_entry",), values)
    labels = {owner: ["+".join(names) for names in _labels(data, owner)] for owner in OWNERS}
    coordinates: dict[str, Any] = {
        name: (name, np.array(label)) for name, label in labels.items() if label
    }
    coordinates["axis"] = ("axis", np.array(["y", "z"]))
    if "time" in arrays:
        coordinates["time"] = ("time", data["time"], {"units": "s"})
    dataset = xr.Dataset(variables, coordinates, {"metadata": metadata_of(run, {})})
    for variable in dataset.variables.values():
        # No array uses a value that marks missing data.
        variable.encoding["_FillValue"] = None
    return dataset


def series(run: RunRecord) -> list[Column]:
    """Give the times and all recorded signals as columns."""
    columns = [Column("time", run.time, "s")]
    recorded = signals(run.data)
    for owner in (*OWNERS, None):
        own = {name: values for name, values in recorded.items() if CHANNELS[name].owner == owner}
        places = [("",)] if owner is None else _labels(run.data, owner)
        for i, label in ((i, label) for i, names in enumerate(places) for label in names):
            for name, values in own.items():
                channel = CHANNELS[name]
                series = values if owner is None else values[:, i]
                parts = series.reshape(-1, len(channel.quantities)).T
                for quantity, part in zip(channel.quantities, parts, strict=True):
                    columns.append(Column(f"{label} {quantity}".lstrip(), part, channel.unit))
    return columns


def summary(run: RunRecord) -> list[Column]:
    """Give a row for each recorded signal: mean, extremes and peak-to-peak value."""
    names: list[str] = []
    units: list[str] = []
    values: list[Array] = []

    def add(name: str, signal: Array, unit: str) -> None:
        factor, own = written_unit(unit)
        names.append(name)
        units.append(own)
        values.append(factor * signal)

    data = run.data
    for i, (shaft, x, labels) in enumerate(data["points"]):
        label = ", ".join(labels) or place_label((shaft, x))
        for along, moved in zip("yz", data["displacement"][:, i].T, strict=True):
            add(f"{label} {along}", moved, "m")
    for i, pair in enumerate(data["meshes"]):
        add(f"{'/'.join(pair)} force", data["mesh"]["force"][:, i], "N")
        add(f"{'/'.join(pair)} contact ratio", data["mesh"]["contact_ratio"][:, i], "")
    for i, bearing in enumerate(data["bearings"]):
        force = np.hypot(*data["bearing_force"][:, i].T)
        add(f"bearing {place_label(bearing)} force", force, "N")
    if data["energy"] is not None:
        add("energy", data["energy"], "J")
    known = np.array(values).reshape(len(values), data["time"].size)
    if not known.size:
        known = np.full((len(values), 1), np.nan)
    low, high = known.min(axis=1), known.max(axis=1)
    return [
        Column("signal", names),
        Column("mean", known.mean(axis=1), round_off=_ROUND_OFF * np.maximum(abs(low), abs(high))),
        Column("smallest", low),
        Column("largest", high),
        Column("peak-to-peak", high - low),
        Column("unit", units),
    ]


def _labels(data: RunData, owner: str) -> list[tuple[str, ...]]:
    """Give the labels of the places of a kind; a point may have several names."""
    if owner == "point":
        points = data["points"]
        return [tuple(names) or (f"{shaft}@{position:g}",) for shaft, position, names in points]
    if owner == "mesh":
        return [("/".join(pair),) for pair in data["meshes"]]
    if owner == "section":
        sections = data["sections"]
        return [(f"{shaft}@{x:g}" + "+" * (side == "beyond"),) for shaft, x, side in sections]
    bearings = data["bearings"] if owner == "bearing" else data["rolling_bearings"]
    return [(f"{shaft}@{position:g}",) for shaft, position in bearings]


def arrays_of(run: RunRecord) -> dict[str, NDArray[Any]]:
    """Collect all arrays of a recorded run by their names in a file."""
    state = run.data["final"].items()
    return {
        "time": run.time,
        **signals(run.data),
        **{f"final_{name}": value for name, value in state if isinstance(value, np.ndarray)},
    }


def metadata_of(run: RunRecord, more: dict[str, Any]) -> str:
    """Write everything except arrays as JSON, which keeps all digits of a float."""
    data = run.data
    about = {
        "format": FORMAT,
        "speed": plain_speed(run.speed),
        "speed_unit": run.speed_unit,
        "accuracy": run.accuracy,
        "request": None if run.request is None else run.request.plain(),
        "errors": None if run.errors is None else run.errors._plain(),
        "kinematics": None if run.kinematics is None else asdict(run.kinematics),
        "points": data["points"],
        "bearings": data["bearings"],
        "rolling_bearings": data["rolling_bearings"],
        "meshes": data["meshes"],
        "sections": data["sections"],
        "statistics": data["statistics"],
        "events": data["events"],
        "final": {
            name: value
            for name, value in data["final"].items()
            if not isinstance(value, np.ndarray)
        },
        "empty": {},  # versions up to 0.2 require it
        **more,
    }
    import json  # noqa: PLC0415  # files only

    return json.dumps(about)


# Sampling of a recorded run at a lower rate, with a low-pass filter against aliasing.
#
# The filter is a sinc function of the cut-off frequency 0.45 of the new rate in the window of
# Kaiser (Oppenheim and Schafer, *Discrete-time signal processing*, 1989, section 7.4). It is
# symmetric, so that it shifts no phase, and is evaluated at any time between the recorded ones.
#
# New samples are equally spaced in time, or in the angle of a shaft. The filter then acts over the
# angle: its integral over the angle is a sum over the recorded times, with the speed as weight.

#: Frequencies up to which signals pass, and from which they are suppressed, as fractions of the new
#: rate. The second one is the highest frequency that the new rate represents.
PASS, STOP = 0.4, 0.5
#: Suppression, and deviation of the passed amplitudes, 80 dB.
_RIPPLE = 1e-4
#: Length of the filter on both sides, in new samples, and the parameter of the window for it, by
#: the formulas of Kaiser.
_ATTENUATION = -20.0 * math.log10(_RIPPLE)
_HALF_LENGTH = (_ATTENUATION - 7.95) / (2.285 * 2.0 * math.pi * (STOP - PASS)) / 2.0
_BETA = 0.1102 * (_ATTENUATION - 8.7)
#: Largest relative difference of the intervals between recorded times.
_EQUAL = 1e-6
#: Weights that are held in memory at once, and largest number of new samples with one window.
_WEIGHTS, _BLOCK = 4_000_000, 256


def resampled(run: RunRecord, rate: float, shaft: str | None = None) -> RunRecord:
    """Filter and sample the signals of a recorded run."""
    low_pass = LowPass.of(run, number(rate, "rate"), shaft)
    found = signals(run.data)
    filtered = dict(zip(found, low_pass.apply(list(found.values())), strict=True))
    return replace(run, data=with_signals(run.data, low_pass.times, filtered))


@dataclass(frozen=True, eq=False)
class LowPass:
    """The filter, and the new samples that it gives."""

    # The position of a recorded sample counts the new samples: rate · time, or samples in a
    # revolution · revolutions. New samples are where it is a whole number.
    #: New samples in a second, or in a revolution of a shaft.
    rate: float
    #: Times of the new samples [s], and their positions.
    times: Array
    whole_numbers: Array
    #: Positions of the recorded samples, and a weight in proportion to their rate of change.
    positions: Array
    density: Array

    @classmethod
    def of(cls, run: RunRecord, rate: float | None, shaft: str | None = None) -> "LowPass":
        """Make the filter for a rate [Hz], or for samples in a revolution of a shaft."""
        time, step = run.time, _step(run.time)

        def turned(t: Array) -> Array:
            """Give what is divided into samples: seconds, or revolutions of the shaft."""
            return t if shaft is None else sense * access.angle(run, shaft, t) / (2.0 * np.pi)

        def speed(t: Array) -> Array:
            """Give the rate of `turned`."""
            if shaft is None:
                return np.ones_like(t)
            return sense * access.spin(run, shaft, t) / (2.0 * np.pi)

        sense = 1.0 if shaft is None or access.spin(run, shaft).sum() >= 0.0 else -1.0
        density, unit = speed(time), "Hz" if shaft is None else f"in a revolution of {shaft!r}"
        fastest = float(density.max())
        most = math.inf if fastest == 0.0 else 1.0 / (fastest * step)
        rate = float(math.floor(most)) if rate is None else rate
        if not 0.0 < rate <= most * (1.0 + _EQUAL):
            raise GearbowError(
                f"rate: must be positive and at most that of the recording, {most:.6g} {unit}, "
                f"got {rate:.6g}; give a shorter output_step to simulate"
            )
        positions = rate * turned(time)
        begin, end = positions[0] + _HALF_LENGTH, positions[-1] - _HALF_LENGTH
        first = math.ceil(begin - 1e-12 * abs(begin))
        last = math.floor(end + 1e-12 * abs(end))
        if last < first:
            what = "s" if shaft is None else f"revolutions of {shaft!r}"
            raise GearbowError(
                f"resample: the recording of {np.ptp(positions) / rate:.3g} {what} is shorter than "
                f"the filter for {rate:.6g} {unit}, {2.0 * _HALF_LENGTH / rate:.3g} {what}; "
                "simulate for longer"
            )
        whole_numbers = np.arange(first, last + 1, dtype=np.float64)
        if shaft is None:
            return cls(rate, whole_numbers / rate, whole_numbers, positions, density)
        times = crossings(time[[0, -1]], lambda t: rate * turned(t), lambda t: rate * speed(t))
        times = times[first - math.ceil(positions[0]) :][: whole_numbers.size]
        return cls(rate, times, whole_numbers, positions, density)

    def apply(self, arrays: Sequence[Array]) -> list[Array]:
        """Filter arrays over the recorded times."""
        size = arrays[0].shape[0]
        columns = np.hstack([values.reshape(size, -1) for values in arrays])
        found = np.empty((self.whole_numbers.size, columns.shape[1]))
        first = np.searchsorted(self.positions, self.whole_numbers - _HALF_LENGTH)
        end = np.searchsorted(self.positions, self.whole_numbers + _HALF_LENGTH, "right")
        at = 0
        while at < found.shape[0]:
            taps = int((end - first)[at : at + _BLOCK].max())
            count = min(_BLOCK, max(1, _WEIGHTS // (taps * max(1, columns.shape[1]))))
            part = slice(at, at + count)
            starts = np.minimum(first[part], size - taps)
            windows = sliding_window_view(columns, taps, axis=0)[starts]
            weights = self._weights(self.whole_numbers[part], starts, taps)
            found[part] = np.einsum("mt,mct->mc", weights, windows)
            at += count
        counts = np.cumsum([values[0].size for values in arrays])[:-1]
        parts = np.split(found, counts, axis=1)
        return [
            part.reshape(found.shape[0], *values.shape[1:])
            for part, values in zip(parts, arrays, strict=True)
        ]

    def _weights(self, numbers: Array, starts: NDArray[np.intp], taps: int) -> Array:
        """Give the weights of the recorded samples from the first one on, for every new sample."""
        indices = starts[:, np.newaxis] + np.arange(taps)
        x = self.positions[indices] - numbers[:, np.newaxis]
        inside = np.clip(1.0 - (x / _HALF_LENGTH) ** 2, 0.0, None)
        weights = np.sinc((PASS + STOP) * x) * np.i0(_BETA * np.sqrt(inside))
        weights *= self.density[indices]
        weights[np.abs(x) > _HALF_LENGTH] = 0.0
        # A constant signal passes exactly.
        normal: Array = weights / weights.sum(axis=1, keepdims=True)
        return normal


def _step(time: Array) -> float:
    """Give the interval between the recorded times."""
    steps = np.diff(time)
    if steps.size < 2 or np.ptp(steps) > _EQUAL * abs(steps[0]) or not steps[0] > 0.0:
        raise GearbowError("resample: needs equally spaced times; give output_step to simulate")
    return float(time[-1] - time[0]) / steps.size
