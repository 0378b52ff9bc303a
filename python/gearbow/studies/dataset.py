"""The function `gearbow.dataset`: a sweep whose signals and labels become a netCDF file.

The labels of a sample are the parameters of its point. The noise of a sample follows from its label
`noise_seed` alone, so that the samples depend neither on their order nor on the workers. The data
card says in Markdown what was simulated, with units, versions and limits.
"""

import inspect
import os
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import checked, nearest, number, shown, text, whole
from gearbow._core import __version__
from gearbow._extras import extra
from gearbow._files import check_name, check_output, printable, replacing
from gearbow._types import Array, Progress
from gearbow.errors import GearbowError, SceneError
from gearbow.orders.fit import orders as fitted_orders
from gearbow.recording.container import require_netcdf, write_netcdf
from gearbow.recording.record import Recorded, recorded_run
from gearbow.results.response import Response
from gearbow.sensors import Sensor, SignalSensor, Tacho
from gearbow.sweeps.points import Parameters, Points, identity
from gearbow.sweeps.result import Sweep, for_netcdf
from gearbow.sweeps.run import check_call, sweep
from gearbow.units.fields import DIMENSIONLESS, unit_of

if TYPE_CHECKING:
    import xarray as xr


#: A sentence by which a data card is known.
CARD_SIGN = "The data are computed, not measured."

#: Most values of a label that are listed one by one.
_MOST_LISTED = 8

_ORDERS = (
    "Amplitudes at orders are complex, from zero to peak, and their phases refer to the angle zero "
    "of the reference shaft. They are fitted to the signals with noise; a record at a constant "
    "speed has one segment."
)
_LIMITS = f"""\
- {CARD_SIGN} They contain what the system of `make` contains: no wear, no
  lubrication faults, no elastic casing unless it is modelled, no other machine beside it.
- The noise is white and normally distributed. Sensors have no frequency response and no drift.
- A model that separates these samples separates simulated machines with the labels of the table.
  It says nothing about faults, machines or loads outside their ranges. Hold back whole machines,
  not only other noise of the same machine, when you test it.
- Within one seed, each sample has its own noise; samples with equal labels differ in it only."""


def data_card(
    found: Sweep,
    data: "xr.Dataset",
    *,
    make: Callable[..., Any],
    run: Callable[..., Any],
    sensors: Mapping[str, Sensor],
    noise: Mapping[str, float],
    file: Path,
) -> str:
    """Write the data card; it has the same text for the same data."""
    labels = [str(name) for name, variable in data.coords.items() if variable.dims == ("point",)]
    first = next(i for i, point in enumerate(found) if point.values is not None)
    own = {name: found[first].parameters[name] for name in labels if name != "noise_seed"}
    python = ".".join(platform.python_version_tuple()[:2])
    versions = (
        f"gearbow {__version__}, NumPy {np.__version__}, Python {python}; seed "
        f"{data.attrs['seed']}. The same call with these versions gives the same data on any "
        "number of workers."
    )
    lines = [f"# {data.attrs['title']}", ""]
    if data.attrs["description"]:
        lines += [data.attrs["description"], ""]
    failed = f" {len(found.failed)} of them failed." if found.failed else ""
    lines += [
        f"{len(found)} simulated samples in `{file.name}` (netCDF).{failed}",
        "",
        f'Read the file with `xarray.open_dataset("{file.name}", engine="h5netcdf")`.',
        "",
        "## Signals and orders",
        "",
        *_table(("variable", "dimensions", "unit", "meaning"), _variables(data)),
        "",
        *([_ORDERS, ""] if "order" in data.coords else []),
        "## Labels",
        "",
        *_table(
            ("label", "unit", "values"),
            [(name, data[name].attrs.get("units", "–"), _values(data[name])) for name in labels],
        ),
        "",
        "## Sensors",
        "",
        *_table(("variable", "sensor", "noise"), [_sensor(*x, noise) for x in sensors.items()]),
        "",
        "## What was simulated",
        "",
        "The system of the first sample:",
        "",
        "```text",
        str(make(**own)),
        "```",
        "",
        *_table(
            ("function", "name", "what it does", "digest"), [_of("make", make), _of("run", run)]
        ),
        "",
        "## Versions",
        "",
        versions,
        "",
        "## Limits",
        "",
        _LIMITS,
        "",
    ]
    if found.failed:
        lines += [
            "## Failed samples",
            "",
            "Their signals are NaN; the variable `error` has the reason.",
            "",
            *(
                f"- {dict(point.parameters)}: {point.error}"
                for point in found.failed[:_MOST_LISTED]
            ),
            *([f"- and {more} more"] if (more := len(found.failed) - _MOST_LISTED) > 0 else []),
            "",
        ]
    return "\n".join(lines)


def _table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    lines = [heading, ["---"] * len(heading), *rows]
    return [f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |" for row in lines]


def _variables(data: "xr.Dataset") -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for name in ("time", "order", *data.data_vars):
        if name in data:
            variable = data[name]
            shape = " × ".join(f"{dim} {data.sizes[dim]}" for dim in variable.dims)
            meaning = variable.attrs.get("long_name", _MEANINGS.get(str(name), ""))
            rows.append((f"`{name}`", shape, variable.attrs.get("units", "–"), meaning))
    return rows


_MEANINGS = {
    "time": "recorded times",
    "order": "names of the orders",
    "error": "reason why a sample failed; empty otherwise",
}


def _values(label: "xr.DataArray") -> str:
    """List the values of a label, or give their range."""
    distinct = list(dict.fromkeys(label.to_numpy().tolist()))
    if label.name == "noise_seed":
        return f"{len(distinct)} seeds of the noise"
    if len(distinct) <= _MOST_LISTED or label.dtype == object:
        named = [f"{x:.6g}" if isinstance(x, float) else str(x) for x in distinct[:_MOST_LISTED]]
        more = len(distinct) - len(named)
        return ", ".join(named) + (f" and {more} more" if more else "")
    return f"{label.min().item():.4g} to {label.max().item():.4g}, {len(distinct)} values"


def _sensor(name: str, sensor: Sensor, noise: Mapping[str, float]) -> tuple[str, ...]:
    unit = sensor.unit if isinstance(sensor, SignalSensor) else "s"
    scatter = f"standard deviation {noise[name]:.4g} {unit}" if noise.get(name) else "none"
    return f"`{name}`", f"`{sensor!r}`", scatter


def _of(role: str, function: Callable[..., Any]) -> tuple[str, ...]:
    """Name a function, with the first line of its documentation."""
    known = identity(function)
    document = (inspect.getdoc(function) or "").partition("\n")[0]
    return f"`{role}`", f"`{known['name']}`", document or "–", known["digest"]


#: Label of a sample that is the seed of its random noise.
_SEED = "noise_seed"
#: Largest seed: whole numbers of netCDF have 64 bits with a sign.
_MOST_SEED = 2**63 - 1
#: Variables of a file that are neither signals nor labels.
_OWN = ("error", "noise_seed", "order", "point", "segment", "segment_speed", "time")
#: Harmonics of each tooth frequency, unless the user chooses: all samples need the same orders.
_MESH_HARMONICS = 3


@checked
def dataset(
    make: Callable[..., Any],
    parameters: Parameters,
    run: Callable[..., Response],
    sensors: Mapping[str, Sensor],
    path: str | os.PathLike[str],
    *,
    noise: Mapping[str, float] | None = None,
    seed: int = 0,
    orders: Mapping[str, Any] | None = None,
    units: Mapping[str, str] | None = None,
    description: str = "",
    executor: Executor | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: bool | Progress | None = None,
) -> Sweep:
    """Simulate labelled signals of many systems, and write them to a netCDF file.

    It is a `sweep` whose points are the samples of a data set and whose parameters are the labels:
    bow, phase, unbalance, misalignment, load. The data have the same bits for every executor and
    every number of workers. A data card in Markdown beside the file says what was simulated, with
    units, versions and limits.

    Parameters
    ----------
    make : callable
        ``make(**parameters)`` returns the system of a sample.
    parameters : mapping of {str: sequence} or sequence of mapping
        The labels, as for `sweep`: all combinations of a grid, or those of each sample. Each sample
        has the further label ``noise_seed``, which `make` and `run` do not receive; it follows from
        `seed` and the number of the sample if it is not given.
    run : callable
        ``run(system, **parameters)`` returns a `Response` with what the sensors need. All samples
        have the same recorded times.
    sensors : mapping of {str: Probe, Accelerometer or Tacho}
        The sensors, with the names of their signals in the file.
    path : str or path-like
        The file. Its name ends with ".nc"; the data card has the same name with ".md".
    noise : mapping of {str: float}, optional
        Standard deviation of the normally distributed noise of each sample of a signal, or of each
        time of a pulse, in the unit of the sensor. Sensors that are not named have none.
    seed : int
        Begin of the random numbers. Another seed gives other noise.
    orders : mapping of {str: object}, optional
        Arguments of `Response.orders`, such as ``{"shaft_harmonics": 2, "sidebands": 0}``: the
        complex amplitudes of the signals, with their noise. `mesh_harmonics` is 3 unless given.
        None writes no orders.
    units : mapping of {str: str}, optional
        Units of labels, e.g. ``{"bow": "m"}``. A label with the name of a field of a part, such as
        ``unbalance``, has the unit of this field.
    description : str
        What the data are for; the first paragraph of the data card.
    executor : concurrent.futures.Executor, optional
        Runs the samples, as for `sweep`; processes need functions at the top of a module.
    store : str or path-like, optional
        A ".sweep" file of the finished samples, with which an interrupted call continues.
    progress : bool or callable, optional
        As for `sweep`.

    Returns
    -------
    Sweep
        The values of all samples as `sweep` gives them. A sample with an error is one of
        `Sweep.failed`; the file contains its labels, NaN and the error.

    Raises
    ------
    SceneError
        If an argument is invalid, the store belongs to another data set or is in use, or the data
        card would replace a file that is none.
    GearbowError
        If no sample has signals, or samples have other times or orders than the first one.

    Examples
    --------
    >>> import gearbow as gb
    >>> def rotor(bow):
    ...     bent = gb.Bow.half_sine(bow)
    ...     shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=2, bow=bent)
    ...     bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=1e3) for x in (0.0, 1.0)]
    ...     return gb.RotorSystem(shafts=[shaft], bearings=bearings)
    >>> def run(system, bow):
    ...     return system.simulate(0.3, 100.0, output_step=1e-3, record=[("rotor", 0.5)])
    >>> sensors = {"middle": gb.Probe("rotor", 0.5), "mark": gb.Tacho("rotor")}
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder) / "rotor.nc"
    ...     made = gb.dataset(rotor, {"bow": [5e-5, 1e-4]}, run, sensors, path, units={"bow": "m"})
    ...     print(*sorted(file.name for file in Path(folder).iterdir()))
    rotor.md rotor.nc
    >>> print(made.values("middle").shape, abs(made.values("middle")).max().round(7))
    (2, 301) 0.0001026
    """
    file, _ = check_name(path, (".nc",))
    require_netcdf()
    card_file = file.with_suffix(".md")
    for each in (file, card_file):
        check_output(each)
    _check_card(card_file)
    rows = _rows(parameters, whole(seed, "seed", least=0))
    labels = tuple(rows[0])
    own = {name: value for name, value in rows[0].items() if name != _SEED}
    check_call("make", make, (), own)
    check_call("run", run, (None,), own)
    wanted = _checked_sensors(sensors, labels)
    recording = _Recording(run, wanted, _deviations(noise, wanted), _order_options(orders))
    known = {name: _unit(name, units, labels) for name in labels}
    text(description, "description")
    found = sweep(_Made(make), rows, recording, executor, store, progress)
    try:
        data = _to_xarray(found, wanted, known, has_orders=orders is not None)
        data.attrs = {"title": file.stem, "description": description, "seed": seed}
        card = data_card(
            found, data, make=make, run=run, sensors=wanted, noise=recording.noise, file=file
        )
        # Both are written before one of them replaces a file.
        with replacing(card_file) as second, replacing(file) as stream:
            second.write(printable(card).encode())
            second.flush()
            write_netcdf(for_netcdf(data), stream)
    except Exception as error:
        error.sweep = found  # type: ignore[attr-defined]
        raise
    return found


def _check_card(path: Path) -> None:
    """Refuse to replace a file that is no data card of gearbow."""
    if path.exists() and CARD_SIGN not in path.read_bytes().decode(errors="replace"):
        raise SceneError(
            f"path: the data card would replace {path}, which is no data card of gearbow; rename "
            "it, or give another path"
        )


@dataclass(frozen=True, eq=False)
class _Made:
    """Make the system of a sample."""

    make: Callable[..., Any]

    def __call__(self, *, noise_seed: int, **parameters: Any) -> Any:  # noqa: ARG002
        return self.make(**parameters)


@dataclass(frozen=True, eq=False)
class _Recording:
    """Simulate a sample and measure it."""

    run: Callable[..., Response]
    sensors: dict[str, Sensor]
    noise: dict[str, float]
    orders: dict[str, Any] | None

    def __call__(self, system: Any, *, noise_seed: int, **parameters: Any) -> dict[str, Any]:
        response = self.run(system, **parameters)
        if not isinstance(response, Response):
            raise SceneError(f"run: must return a Response, got {shown(response)}")
        random = np.random.default_rng(noise_seed)
        found: dict[str, Any] = {"time": response.time}
        for name, sensor in self.sensors.items():
            values = response.measure(sensor)
            if name in self.noise:
                values = values + self.noise[name] * random.standard_normal(values.size)
            found[name] = values
            if self.orders is not None and isinstance(sensor, SignalSensor):
                measured, noise = _Measured(sensor, values), self.noise.get(name, 0.0)
                fitted = fitted_orders(
                    recorded_run(response, "run"), measured, noise=noise, **self.orders
                )
                found[f"{name}_orders"] = fitted.tracks
                found["order"] = np.array([str(order) for order in fitted.orders])
                found["segment_speed"] = fitted.speeds
        return found


@dataclass(frozen=True, eq=False)
class _Measured(SignalSensor):
    """The signal of a sensor, with its noise."""

    sensor: SignalSensor
    values: Array

    @property
    def unit(self) -> str:  # type: ignore[override]  # that of the sensor
        return self.sensor.unit

    @property
    def label(self) -> str:
        return self.sensor.label

    def measure(self, recording: Recorded) -> Array:  # noqa: ARG002
        return self.values

    def _sensed(self, motion: Any) -> Any:
        return self.sensor._sensed(motion)


def _rows(parameters: Parameters, seed: int) -> list[dict[str, Any]]:
    """Give the labels of each sample, with the seeds of its noise."""
    points = Points(parameters)
    rows = []
    for i in range(len(points)):
        row = points[i]
        # A hash of both numbers: data sets with neighbouring seeds have no noise in common.
        own = np.random.SeedSequence((seed, i)).generate_state(1, np.uint64)[0] >> np.uint64(1)
        noise = whole(row.pop(_SEED, int(own)), f"parameters.{_SEED}", least=0, most=_MOST_SEED)
        rows.append({**row, _SEED: noise})
    if len(rows[0]) < 2:
        raise SceneError("parameters: must name at least one label besides noise_seed, got none")
    return rows


def _checked_sensors(given: Any, labels: tuple[str, ...]) -> dict[str, Sensor]:
    if not isinstance(given, Mapping) or not given:
        raise SceneError(
            f"sensors: must be a dict of names and sensors, such as "
            f'{{"y": gb.Probe("input", 0.2)}}, got {shown(given)}'
        )
    for name, sensor in given.items():
        where = f"sensors[{shown(name)}]"
        if not text(name, "sensors") or "/" in name:
            raise SceneError(f"{where}: is no name of a variable of a file; leave out '/'")
        if not isinstance(sensor, Sensor):
            raise SceneError(
                f"{where}: must be a Probe, an Accelerometer or a Tacho, got {shown(sensor)}"
            )
        if name in (*labels, *_OWN):
            raise SceneError(f"{where}: is the name of another variable of the file; rename it")
    if all(isinstance(sensor, Tacho) for sensor in given.values()):
        raise SceneError("sensors: only tachometers are given; add a Probe or an Accelerometer")
    return dict(given)


def _deviations(
    noise: Mapping[str, float] | None, sensors: Mapping[str, Sensor]
) -> dict[str, float]:
    if noise is not None and not isinstance(noise, Mapping):
        raise SceneError(
            f"noise: must be a dict of the names of sensors and numbers, got {shown(noise)}"
        )
    found = {}
    for name, value in (noise or {}).items():
        if name not in sensors:
            raise SceneError(
                f"noise[{shown(name)}]: is no sensor{nearest(name, sensors)}; the sensors are "
                f"{', '.join(sensors)}"
            )
        found[name] = number(value, f"noise[{shown(name)}]")
        if found[name] < 0.0:
            raise SceneError(f"noise[{shown(name)}]: must not be negative, got {found[name]:g}")
    return found


def _order_options(orders: Mapping[str, Any] | None) -> dict[str, Any] | None:
    if orders is None:
        return None
    if not isinstance(orders, Mapping):
        raise SceneError(
            f"orders: must be a dict of arguments of Response.orders, got {shown(orders)}"
        )
    known = list(inspect.signature(Response.orders).parameters)[3:]  # without self and place
    for name in orders:
        if name not in known:
            raise SceneError(
                f"orders[{shown(name)}]: is no argument of Response.orders{nearest(name, known)}; "
                f"they are {', '.join(known)}"
            )
    if orders.get("mesh_harmonics", 0) is None:
        raise SceneError("orders['mesh_harmonics']: must be a number, as all samples need the same")
    return {"mesh_harmonics": _MESH_HARMONICS, **orders}


def _unit(name: str, units: Mapping[str, str] | None, labels: tuple[str, ...]) -> str:
    if units is not None and not isinstance(units, Mapping):
        raise SceneError(f"units: must be a dict of labels and units, got {shown(units)}")
    for each in units or {}:
        if each not in labels:
            raise SceneError(f"units[{shown(each)}]: is no label; they are {', '.join(labels)}")
    if name in (units or {}):
        return text((units or {})[name], f"units[{name!r}]")
    known = unit_of(name)
    return known if known is not None and known != DIMENSIONLESS else ""


def _to_xarray(
    found: Sweep, sensors: Mapping[str, Sensor], units: Mapping[str, str], *, has_orders: bool
) -> "xr.Dataset":
    """Give the data set of a file."""
    with extra("netcdf"):
        import xarray as xr  # noqa: PLC0415

    valid = [i for i, point in enumerate(found) if point.values is not None]
    if not valid:
        first = found[0].error
        raise GearbowError(f"no sample has signals: all {len(found)} failed, the first by {first}")
    coordinates: dict[str, Any] = {
        "time": ("time", _common(found, valid, "time"), {"units": "s"}),
    }
    variables: dict[str, Any] = {}
    for name, unit in units.items():
        values = [point.parameters[name] for point in found]
        coordinates[name] = ("point", _plain(values), {"units": unit} if unit else {})
    for name, sensor in sensors.items():
        if isinstance(sensor, SignalSensor):
            about = {"units": sensor.unit, "long_name": sensor.label}
            variables[name] = (("point", "time"), found.values(name), about)
            if has_orders:
                about = {"units": sensor.unit, "long_name": f"amplitudes of {sensor.label}"}
                dims = ("point", "segment", "order")
                complex_values = found.values(f"{name}_orders")
                parts = {"real": complex_values.real, "imag": complex_values.imag}
                for part, numbers in parts.items():
                    variables[f"{name}_orders_{part}"] = (dims, numbers, about)
        else:
            about = {"units": "s", "long_name": "times of the pulses, then NaN"}
            variables[name] = (("point", f"{name}_pulse"), _padded(found, valid, name), about)
    if has_orders:
        order = _common(found, valid, "order")
        coordinates["order"] = ("order", order.astype(object))
        speed = {"units": "rad/s", "long_name": "speed of the reference shaft"}
        variables["segment_speed"] = (("point", "segment"), found.values("segment_speed"), speed)
    if found.failed:
        errors = np.array([point.error for point in found], object)
        variables["error"] = ("point", errors)
    return xr.Dataset(variables, coordinates)


def _common(found: Sweep, valid: list[int], name: str) -> Any:
    """Give a value that all samples share."""
    remedy = {
        "time": "let `run` simulate all samples with the same duration and output_step",
        "order": "let `run` record longer, so that the orders of all samples are separate, or ask "
        "for fewer orders",
    }[name]
    first = np.asarray((found[valid[0]].values or {})[name])
    for i in valid:
        if not np.array_equal(first, (found[i].values or {})[name]):
            raise GearbowError(
                f"{name}: that of sample {i} ({dict(found[i].parameters)}) differs from that of "
                f"sample {valid[0]}; {remedy}"
            )
    return first


def _padded(found: Sweep, valid: list[int], name: str) -> Array:
    """Give arrays of different lengths as rows, filled up with NaN."""
    given = {i: (found[i].values or {})[name] for i in valid}
    rows = np.full((len(found), max(values.size for values in given.values())), np.nan)
    for i, values in given.items():
        rows[i, : values.size] = values
    return rows


def _plain(values: list[Any]) -> Any:
    """Give numbers as an array, and everything else as texts."""
    if all(isinstance(value, bool | int | float) for value in values):
        return np.array(values)
    return np.array([str(value) for value in values], object)
