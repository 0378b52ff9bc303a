"""Figures of time responses: orbits, time histories, spectra and energies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearbow._types import Array
from gearbow.plotting.orders import name_orders, say_resolution, spectral_lines, spectrum_limits
from gearbow.plotting.style import (
    MICRO,
    PALETTE,
    ROUND_OFF,
    GivenAxes,
    colour,
    equal_ranges,
    log_scale,
    panels,
    place_legend,
    quantity,
    remark,
    text_size,
)

#: Colour of the transient at the beginning of a run.
TRANSIENT = "0.75"


@dataclass(frozen=True, eq=False)
class TimeAxis:
    """Horizontal axis of a figure, and the number of values before those that set its scale."""

    values: Array
    label: str = "time [s]"
    skipped: int = 0
    #: Whether the skipped times are the transient, which the figure shades.
    transient: bool = False


def orbits(axis: TimeAxis, motion: Mapping[str, Array], *, ax: GivenAxes = None) -> Figure:
    """Draw the orbit of each centre in the plane of rotation."""
    count, skipped = len(motion), axis.skipped
    given: dict[str, Any] = {"columns": 4, "width": 4.2 * min(4, count), "legend": False}
    with panels(count, 4.3, ax=ax, **given) as (figure, axes):
        if ax is None:
            # Titles of a row do not touch the labels of the row above.
            layout: Any = figure.get_layout_engine()
            layout.set(h_pad=0.12)
        for panel, (label, values) in zip(axes, motion.items(), strict=True):
            v, w = MICRO * values.T
            if skipped:
                early = slice(0, skipped + 1)
                panel.plot(v[early], w[early], color=TRANSIENT, linewidth=0.8, label="earlier")
            late = "after the transient" if axis.transient else "last turn"
            name = late if skipped else "orbit"
            panel.plot(v[skipped:], w[skipped:], color=PALETTE[0], label=name)
            panel.plot(v[-1:], w[-1:], "o", color=PALETTE[1], label="end")
            panel.set(title=label, xlabel="y [µm]", ylabel="z [µm]")
        equal_ranges(axes)
        entries = axes[0].get_legend_handles_labels()
        place_legend(figure, axes[0], entries, ax=ax, outside=True)
    return figure


def history(axis: TimeAxis, motion: Mapping[str, Array], *, ax: GivenAxes = None) -> Figure:
    """Draw the displacement of each centre about its mean against time."""
    with panels(len(motion), 2.9, sharex=True, ax=ax, x=axis.label) as (figure, axes):
        for panel, (label, values) in zip(axes, motion.items(), strict=True):
            mean = values[axis.skipped :].mean(axis=0) if values.size else np.zeros(2)
            _lines(panel, axis.values, MICRO * (values - mean), ("y − mean", "z − mean"))
            y, z = (quantity(part, "m") for part in mean)
            panel.set(ylabel=f"{label} [µm]")
            remark(panel, f"mean y {y}, z {z}")
            _settle(panel, MICRO * (values - mean), axis.skipped)
        _shade(axes, axis)
    return figure


def twist(axis: TimeAxis, twists: Mapping[str, Array], *, ax: GivenAxes = None) -> Figure:
    """Draw the twist of each place against time."""
    with panels(len(twists), 2.6, sharex=True, ax=ax, x=axis.label) as (figure, axes):
        for panel, (label, values) in zip(axes, twists.items(), strict=True):
            panel.plot(axis.values, 1e3 * values, color=PALETTE[0], linewidth=1.1)
            panel.set(ylabel=f"{label} [mrad]")
            _settle(panel, 1e3 * values, axis.skipped)
        _shade(axes, axis)
    return figure


def bearings(axis: TimeAxis, forces: Mapping[str, Array], *, ax: GivenAxes = None) -> Figure:
    """Draw the force of the shaft on each bearing against time."""
    shared: dict[str, Any] = {"columns": 2, "sharex": True, "x": axis.label}
    with panels(2 * len(forces), 2.6, ax=ax, **shared) as (figure, axes):
        for row, (label, values) in enumerate(forces.items()):
            for column, along in enumerate("yz"):
                panel = axes[2 * row + column]
                panel.plot(axis.values, values[:, column], color=colour(column), linewidth=1.1)
                panel.set(ylabel=f"force along {along} [N]")
                _settle(panel, values[:, column], axis.skipped)
                # A short time at the end of a long run has numbers of many digits.
                panel.locator_params(axis="x", nbins=4)
            axes[2 * row].set_title(label, loc="left", fontsize=text_size(1.0))
        _shade(axes, axis)
    return figure


def mesh(
    axis: TimeAxis,
    meshes: Mapping[tuple[str, str], tuple[Array, Array, Array]],
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw force, deflection and stiffness of the meshes."""
    rows = {
        pair: {
            "force [N]": force,
            "deflection [µm]": MICRO * deflection,
            "stiffness [N/µm]": stiffness / MICRO,
        }
        for pair, (force, deflection, stiffness) in meshes.items()
    }
    return _columns(axis, rows, ax=ax)


def geometry(
    axis: TimeAxis,
    meshes: Mapping[tuple[str, str], tuple[Array, Array, Array, Array]],
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw the geometry of the meshes at the moving centres."""
    rows = {
        pair: {
            "contact ratio": contact_ratio,
            "pressure angle [°]": np.degrees(pressure_angle),
            "line of centres [°]": np.degrees(centre_line_angle),
            "centre distance [mm]": 1e3 * distance,
        }
        for pair, (contact_ratio, pressure_angle, centre_line_angle, distance) in meshes.items()
    }
    return _columns(axis, rows, ax=ax)


def spectrum(
    spectra: Mapping[str, tuple[Array, Array]],
    *,
    orders: Sequence[tuple[str, float]] = (),
    periodic: bool = False,
    ax: GivenAxes = None,
) -> Figure:
    """Draw the amplitude spectrum of the displacement of each centre; of a period, its lines."""
    with panels(len(spectra), 3.8, sharex=True, ax=ax, x="frequency [Hz]") as (figure, axes):
        highest = 0.0
        for panel, (label, (frequency, amplitude)) in zip(axes, spectra.items(), strict=True):
            log_scale(panel)
            panel.set(ylabel=f"{label} [µm]")
            limits = spectrum_limits(panel, frequency, MICRO * amplitude, periodic=periodic)
            highest = max(highest, limits)
            if not periodic:
                _lines(panel, frequency, MICRO * amplitude, ("y", "z"))
                continue
            # A wide line is visible behind a narrow one at the same frequency.
            count = int(np.sum(frequency <= limits))
            for number, (along, width) in enumerate((("y", 3.2), ("z", 1.4))):
                curve = spectral_lines(panel, frequency, MICRO * amplitude[:, number])
                style: Any = {"color": colour(number), "label": along}
                panel.plot(*curve, linewidth=width * min(1.0, 300.0 / max(count, 1)), **style)
        for panel, (frequency, amplitude) in zip(axes, spectra.values(), strict=True):
            if highest > 0.0:
                panel.set_xlim(0.0, highest)
            largest = MICRO * amplitude.max(axis=1)
            given: Any = {"most": 8, "sidebands": False, "periodic": periodic}
            name_orders(panel, frequency, largest, orders, **given)
        say_resolution(axes[0], next(iter(spectra.values()))[0], orders, periodic=periodic)
    return figure


def energy_balance(
    time: Array,
    rows: Mapping[str, tuple[Mapping[str, Array], Array]],
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw energies, works and the residual against time."""
    shared: dict[str, Any] = {"sharex": True, "x": "time [s]", "legend": False}
    with panels(len(rows), 3.0, ax=ax, **shared) as (figure, axes):
        for panel, (label, (terms, total)) in zip(axes, rows.items(), strict=True):
            for i, (name, values) in enumerate(terms.items()):
                if np.any(values != 0.0):
                    panel.plot(time, values, color=colour(i), label=name)
            panel.plot(time, total, color=PALETTE[-1], label="all")
            panel.set(ylabel=f"{label} [J]")
            if terms and ax is None:
                panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
            elif terms:
                panel.legend(loc="best", fontsize="small")
    return figure


def _columns(
    axis: TimeAxis, meshes: Mapping[tuple[str, str], Mapping[str, Array]], *, ax: GivenAxes
) -> Figure:
    """Draw a column for each mesh, with a panel for each of its quantities."""
    columns, count = len(meshes), len(next(iter(meshes.values())))
    shared: dict[str, Any] = {"columns": columns, "width": max(9.0, 6.0 * columns)}
    shared |= {"sharex": True, "x": axis.label}
    with panels(count * columns, 2.6, ax=ax, **shared) as (figure, axes):
        for column, ((driver, driven), rows) in enumerate(meshes.items()):
            for row, (label, values) in enumerate(rows.items()):
                panel = axes[row * columns + column]
                panel.plot(axis.values, values, color=colour(column), linewidth=1.1)
                panel.set(ylabel=label)
                # Ticks without an offset show an angle of 20.01° in full.
                panel.ticklabel_format(axis="y", useOffset=False)
                _settle(panel, values, axis.skipped)
            name = f"{driver} – {driven}"
            axes[column].set_title(name, loc="left", fontsize=text_size(1.0))
        for panel in axes:
            # A short time at the end of a long run has numbers of many digits.
            panel.locator_params(axis="x", nbins=4)
        _shade(axes, axis)
    return figure


def _lines(panel: Axes, x: Array, values: Array, names: Sequence[str]) -> None:
    """Draw the columns of values in the colours of the palette."""
    for number, name in enumerate(names):
        panel.plot(x, values[:, number], color=colour(number), linewidth=1.1, label=name)


def _settle(panel: Axes, values: Array, skipped: int) -> None:
    """Scale a panel to the values after the skipped ones, and give the range of those beyond."""
    late, early = values[skipped:], values[:skipped]
    if early.size == 0 or late.size == 0:
        return
    low, high = float(late.min()), float(late.max())
    first, last = float(early.min()), float(early.max())
    half = 0.5 * (high - low)
    moves = half > ROUND_OFF * max(abs(first), abs(last))
    if not moves or (first >= low - half and last <= high + half):
        return
    bottom, top = min(low, max(first, low - half)), max(high, min(last, high + half))
    margin = float(mpl.rcParams["axes.ymargin"]) * (top - bottom)
    panel.set_ylim(bottom - margin, top + margin)
    unit = panel.get_ylabel().partition("[")[2].rstrip("]")
    ends = [np.format_float_positional(x, 4, fractional=False, trim="-") for x in (first, last)]
    remark(panel, f"earlier {' to '.join(ends)} {unit}".rstrip().replace("-", "−"))


def _shade(axes: Sequence[Axes], axis: TimeAxis) -> None:
    """Shade the time of the transient."""
    for panel in axes if axis.transient and axis.skipped else ():
        shade: dict[str, Any] = {"color": TRANSIENT, "alpha": 0.5, "linewidth": 0.0}
        begin, end = axis.values[[0, axis.skipped]].tolist()
        panel.axvspan(begin, end, label="transient", **shade)
