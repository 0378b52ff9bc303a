"""The data card of a data set: what was simulated, with units, versions and limits, in Markdown."""

import inspect
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._core import __version__
from gearbow.sensors.sensor import Sensor, SignalSensor
from gearbow.sweeps.points import identity
from gearbow.sweeps.result import Sweep

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
