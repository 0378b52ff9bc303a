"""Figures of analyses: limits, branches, losses, effects, films, section forces, stresses."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gearbow._types import Array, ComplexArray
from gearbow.plotting.style import (
    MICRO,
    PALETTE,
    GivenAxes,
    colour,
    common_round_off,
    legend_entries,
    log_scale,
    named_bars,
    named_ticks,
    panels,
    place_legend,
    remark,
    speed_axis,
    text_size,
)
from gearbow.units.speed import speed_text

if TYPE_CHECKING:
    from gearbow.description.journal import PadFilm


def balance(
    speeds: Sequence[str],
    points: Sequence[str | float],
    before: Array,
    residual: Array,
    *,
    label: str,
    limits: tuple[Array, Array] | None = None,
    ax: GivenAxes = None,
) -> Figure:
    """Draw the deflection at the points before and after the correction, a panel for each speed."""
    named = any(isinstance(point, str) for point in points)
    x = np.arange(len(points)) if named else np.array(points)
    label_of_x = "measuring point" if named else "position [m]"
    with panels(len(speeds), 3.4, sharex=True, ax=ax, x=label_of_x) as (figure, axes):
        for number, (panel, speed) in enumerate(zip(axes, speeds, strict=True)):
            parts = {"before": before[number], "predicted with the correction": residual[number]}
            for i, (name, values) in enumerate(parts.items()):
                style: dict[str, Any] = {"color": PALETTE[i], "label": name}
                if named:
                    panel.bar(x + 0.4 * (i - 0.5), MICRO * values, width=0.4, **style)
                else:
                    panel.plot(x, MICRO * values, "o-", markersize=4.0, **style)
            if named:
                named_ticks(panel.xaxis, x, [str(point) for point in points])
            if limits is not None:
                low, high = (MICRO * each[number] for each in limits)
                place = x + 0.2 if named else x
                panel.vlines(place, low, high, color="black", label="95 % interval")
            panel.set(ylabel=label)
            panel.set_ylim(bottom=0.0)
            panel.set_title(f"at {speed}", loc="left", fontsize=text_size(1.0))
    return figure


#: Ratio of the largest to the smallest bow from which their axis is logarithmic.
_WIDE = 30.0


def bow_limits(
    speeds: Array,
    lines: Mapping[str, Array],
    present: float,
    *,
    label: str,
    ax: GivenAxes = None,
) -> Figure:
    """Draw one curve for each of the first limits that are reached, and the present bow."""
    if speeds.size == 1:
        single = {name: MICRO * float(values[0]) for name, values in lines.items()}
        at = f"at {speed_text(float(speeds[0]))}"
        return _at_one_speed(single, MICRO * present, f"{label} [µm], {at}", ax=ax)
    factor, axis = speed_axis()
    with panels(1, 6.0, width=10.0, ax=ax) as (figure, (panel,)):
        reached = {name: MICRO * bows for name, bows in lines.items() if np.any(np.isfinite(bows))}
        # `lines` ascend: the further ones are above all of these.
        for number, (name, bows) in enumerate(list(reached.items())[: len(PALETTE)]):
            style: dict[str, Any] = {
                "color": colour(number),
                "linestyle": ("-", "--", "-.", ":")[number % 4],
                "marker": "o" if speeds.size < 20 else None,
                "markersize": 4.0,
            }
            panel.plot(factor * speeds, np.where(bows > 0.0, bows, np.nan), label=name, **style)
            if np.any(bows == 0.0):
                remark(panel, f"{name}: exceeded without bow")
        if len(reached) > len(PALETTE):
            remark(panel, f"{len(reached) - len(PALETTE)} further limits are above")
        if present > 0.0:
            panel.axhline(MICRO * present, color="0.2", linewidth=2.5, label="present bow")
        if reached or present > 0.0:
            log_scale(panel)
        else:
            remark(panel, "no limit is reached")
        if speeds.size > 1 and not panel.dataLim.width > 0.0:  # no limit has a curve
            panel.set_xlim(*sorted(factor * speeds[[0, -1]]))
        panel.set(xlabel=axis, ylabel=f"{label} [µm]")
    return figure


def _at_one_speed(
    bows: Mapping[str, float], present: float, label: str, *, ax: GivenAxes
) -> Figure:
    """Draw a bar for each of the first limits, and the present bow as a line."""
    shown = [(name, bow) for name, bow in bows.items() if np.isfinite(bow)][: len(PALETTE)]
    with panels(1, 0.5 * len(shown) + 1.2, ax=ax) as (figure, (panel,)):
        names = [f"{name}: exceeded without bow" if bow == 0.0 else name for name, bow in shown]
        for row, (_, bow) in enumerate(shown):
            exceeded = bow < present
            panel.barh(row, bow, height=0.55, color=PALETTE[1 if exceeded else 0])
        named_bars(panel, names)
        panel.set_ylim(max(len(shown), 1) - 0.5, -0.5)
        if present > 0.0:
            panel.axvline(present, color="0.2", linewidth=2.5, label="present bow")
        sizes = [bow for _, bow in shown if bow > 0.0] + [present] * (present > 0.0)
        if sizes and max(sizes) > _WIDE * min(sizes):
            panel.set_xscale("log")
            panel.set_xlim(0.5 * min(sizes), 1.2 * max(sizes))
        else:
            panel.set_xlim(0.0, 1.08 * max(sizes, default=1.0))
        panel.set(xlabel=label)
        if not shown:
            remark(panel, "no limit is reached")
        elif len(bows) > len(shown):
            left = len(bows) - len(shown)
            limits = "limits are" if left > 1 else "limit is"
            remark(panel, f"{left} further {limits} above, or not reached")
    return figure


#: Marker of each kind of special point.
_MARKS = {"fold": "o", "flip": "s", "contact loss": "D"}


def branch(
    values: Array,
    amplitudes: Array,
    stable: NDArray[np.bool_],
    kinds: Sequence[str],
    *,
    labels: tuple[str, str],
    is_open: bool = False,
    ax: GivenAxes = None,
) -> Figure:
    """Draw a branch: stable parts solid, unstable ones dashed; markers for points and open ends."""
    with panels(1, 4.5, width=7.0, ax=ax, legend=False) as (drawing, (axes,)):
        named = set()
        for is_stable, group in groupby(
            range(values.size - 1), key=lambda i: stable[i : i + 2].all()
        ):
            part = list(group)
            points = slice(part[0], part[-1] + 2)
            name = "stable" if is_stable else "unstable"
            axes.plot(
                values[points],
                amplitudes[points],
                linestyle="-" if is_stable else "--",
                color=PALETTE[0] if is_stable else PALETTE[1],
                label=None if name in named else name,
            )
            named.add(name)
        for kind, mark in _MARKS.items():
            chosen = np.array(kinds) == kind
            if chosen.any():
                axes.plot(
                    values[chosen], amplitudes[chosen], mark, color="0.2", markersize=5, label=kind
                )
        if is_open:
            axes.plot(
                values[-1:],
                amplitudes[-1:],
                marker="o",
                linestyle="none",
                color=PALETTE[0] if stable[-1] else PALETTE[1],
                markerfacecolor="white",
                markersize=9,
                label="open end",
            )
        axes.set(xlabel=labels[0], ylabel=labels[1])
        axes.legend()
    return drawing


def losses(
    speeds: Array,
    names: Sequence[str],
    shares: Array,
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw the loss of each mesh [% of the input power] over the speed; bars at a single speed."""
    factor, axis = speed_axis()
    total = shares.sum(axis=1)
    label = "loss by friction of teeth [% of input power]"
    height = 1.6 + 0.45 * len(names) if speeds.size == 1 else 5.0
    with panels(1, height, width=9.0, ax=ax) as (figure, (panel,)):
        if speeds.size == 1:
            values, shades = [*shares[0], total[0]], [colour(0)] * len(names) + ["0.4"]
            panel.barh(range(len(values)), values, color=shades)
            named_bars(panel, [*names, "train"])
            panel.set(xlabel=label, ylabel="mesh", title=speed_text(speeds[0], form=".5g"))
        else:
            for i, (name, values) in enumerate(zip(names, shares.T, strict=True)):
                panel.plot(factor * speeds, values, color=colour(i), label=name)
            panel.plot(factor * speeds, total, color="0.2", linewidth=2.5, label="train")
            panel.set(xlabel=axis, ylabel=label)
        panel.margins(y=0.08)
    return figure


#: Largest number of bars in a panel.
_BARS = 12


def tornado(
    parameters: Sequence[str],
    outputs: Sequence[str],
    effects: Array,
    *,
    of: str,
    ax: GivenAxes = None,
) -> Figure:
    """Draw bars of the effect of each parameter on each output, the largest on top."""
    count, bars = max(len(outputs), 1), min(len(parameters), _BARS)
    height = 1.6 + 0.45 * bars
    with panels(count, height, width=10.0, ax=ax) as (figure, found):
        if not outputs:
            remark(found[0], "no mode with stiffness")
        for panel, output, column in zip(found, outputs, effects.T, strict=False):
            order = np.argsort(-np.abs(column), kind="stable")[:_BARS]
            values = column[order]
            colours = [PALETTE[0] if value >= 0.0 else PALETTE[1] for value in values]
            panel.barh(range(order.size), values, color=colours)
            named_bars(panel, [parameters[i] for i in order])
            panel.axvline(0.0, color="0.2", linewidth=1.0)
            # Round-off is no effect: the axis shows at least a thousandth of a percent.
            most = max(float(np.max(np.abs(values), initial=0.0)), 1e-3)
            panel.set_xlim(-1.1 * most, 1.1 * most)
            axis = f"change of the {of} [%] for 1 % of the parameter"
            panel.set(title=output, xlabel=axis, ylabel="parameter")
            if len(parameters) > _BARS:
                remark(panel, f"{len(parameters) - _BARS} further parameters have less effect")
    return figure


def sweep(
    axes: Mapping[str, Sequence[float]],
    values: Array,
    name: str,
    *,
    labels: Mapping[str, str],
    ax: GivenAxes = None,
) -> Figure:
    """Draw a value over one, two or three parameters."""
    names = list(axes)
    # A map needs ascending axes; a grid may have any order.
    orders = [np.argsort(axis, kind="stable") for axis in axes.values()]
    points = [np.array(axis)[order] for axis, order in zip(axes.values(), orders, strict=True)]
    found = values[np.ix_(*orders)]
    if len(names) == 1:
        with panels(1, 4.5, width=7.0, ax=ax) as (figure, (panel,)):
            panel.plot(points[0], found, "o-", color=PALETTE[0], markersize=4.0)
            panel.set(xlabel=labels[names[0]], ylabel=labels[name])
        return figure
    # The first of three parameters has a panel for each value.
    parts = found if len(names) == 3 else found[np.newaxis]
    style: dict[str, Any] = {"cmap": "cividis", "shading": "nearest", "rasterized": True}
    style |= {"vmin": np.nanmin(found), "vmax": np.nanmax(found)}
    width = 7.0 if len(parts) == 1 else 13.0
    with panels(len(parts), 4.5, columns=2, width=width, ax=ax) as (figure, all_panels):
        for number, (panel, part) in enumerate(zip(all_panels, parts, strict=True)):
            drawn = panel.pcolormesh(*points[-2:], part.T, **style)
            figure.colorbar(drawn, ax=panel, label=labels[name])
            panel.grid(visible=False)
            panel.set(xlabel=labels[names[-2]], ylabel=labels[names[-1]])
            if len(names) == 3:
                title = f"{labels[names[0]]} = {points[0][number]:g}"
                panel.set_title(title, fontsize=text_size(1.0))
    return figure


def stability(speeds: Array, gain: ComplexArray, growth: Array, ax: GivenAxes = None) -> Figure:
    """Draw the loop gain, and the growth in each minute, over the speed."""
    factor, label = speed_axis()
    speeds = factor * speeds
    with panels(2, 3.4, sharex=True, ax=ax, x=label) as (figure, (upper, lower)):
        upper.plot(speeds, gain.real, color=PALETTE[0], label="real part")
        upper.plot(speeds, gain.imag, "--", color=PALETTE[1], label="imaginary part")
        upper.axhline(1.0, color="black", linewidth=1.0, linestyle=":", label="limit")
        upper.set_ylabel("loop gain")
        lower.plot(speeds, growth, color=PALETTE[0])
        lower.axhline(0.0, color="black", linewidth=1.0, linestyle=":")
        grows = np.maximum(growth, 0.0)
        lower.fill_between(speeds, 0.0, grows, color=PALETTE[1], alpha=0.3, linewidth=0.0)
        lower.set_ylabel("growth [1/min]")
    return figure


def spiral(time: Array, vibration: ComplexArray, ax: GivenAxes = None) -> Figure:
    """Draw the vibration [m] as a spiral, and its amplitude over time [s]."""
    with panels(2, 5.0, columns=2, ax=ax) as (figure, (plane, over_time)):
        scaled = MICRO * vibration
        plane.plot(scaled.real, scaled.imag, color=PALETTE[0])
        plane.plot(scaled.real[:1], scaled.imag[:1], "o", color=PALETTE[1])
        plane.axhline(0.0, color="black", linewidth=0.8)
        plane.axvline(0.0, color="black", linewidth=0.8)
        plane.set(xlabel="real part [µm]", ylabel="imaginary part [µm]", aspect="equal")
        plane.set_adjustable("datalim")
        over_time.plot(time, np.abs(scaled), color=PALETTE[0])
        over_time.set(xlabel="time [s]", ylabel="amplitude [µm]")
        over_time.set_ylim(bottom=0.0)
    return figure


#: Errors and CPU times [s] of a series of runs.
Points: TypeAlias = tuple[Sequence[float], Sequence[float]]

#: Filled markers for methods, open markers for models: distinguishable without colour.
_METHODS = ("o", "s", "D", "^", "v", "P")
_MODELS = ("X", "d", "<", ">", "p", "h", "8", "*")


def work_precision(
    methods: Mapping[str, Points],
    models: Mapping[str, Points],
    front: Points,
    *,
    floor: float,
    worst: float,
    simulated: float,
    ax: GivenAxes = None,
) -> Figure:
    """Draw the CPU time against the error, both on logarithmic axes."""
    with panels(1, 6.2, ax=ax, legend=False) as (figure, (panel,)):
        for i, (name, (x, y)) in enumerate(methods.items()):
            marker = f"-{_METHODS[i % len(_METHODS)]}"
            panel.plot(x, y, marker, color=colour(i), ms=9.0, label=name)
        for i, (name, (x, y)) in enumerate(models.items()):
            marker = _MODELS[i % len(_MODELS)]
            panel.plot(
                x, y, marker, ls="none", mfc="none", mec="0.35", mew=1.6, ms=10.0, label=name
            )
        # The cheapest run is optimal for every error above its own.
        x, y = [worst, *front[0]], [front[1][0], *front[1]]
        line: dict[str, Any] = {"color": "0.6", "lw": 7.0, "alpha": 0.5, "zorder": 1}
        panel.step(x, y, where="pre", label="Pareto front", **line)
        panel.set_xscale("log")
        panel.set_yscale("log")
        left = min(panel.get_xlim()[0], floor / 3.0)
        panel.axvspan(left, floor, color="0.93", zorder=0, label="reference uncertainty")
        panel.set_xlim(left=left)
        panel.set_xlabel("error: RMS of the difference / RMS of the signal about its mean")
        panel.set_ylabel(f"CPU time for {simulated:g} simulated s [s]")
        handles, labels = panel.get_legend_handles_labels()
        if ax is None:
            figure.legend(handles, labels, loc="outside right center")
        else:
            panel.legend(handles, labels, loc="best", fontsize="small")
    return figure


def lives(bearings: Sequence[str], hours: Mapping[str, Array], ax: GivenAxes = None) -> Figure:
    """Draw lives of bearings [h] as bars; an infinite one ends at the edge."""
    finite = [value for each in hours.values() for value in each if np.isfinite(value)] or [1.0]
    edge = 10.0 * max(finite)
    height = 0.8 / len(hours)
    many = len(hours) > 1
    with panels(1, 1.5 + 0.4 * len(bearings), ax=ax, legend=many) as (figure, (panel,)):
        places = np.arange(len(bearings))
        for i, (name, values) in enumerate(hours.items()):
            own = np.where(np.isfinite(values), values, edge)
            shift = height * (i - (len(hours) - 1) / 2.0)
            panel.barh(places + shift, own, height, color=colour(i), label=name)
        panel.set_xscale("log")
        panel.set_xlim(min(finite) / 10.0, edge)
        named_bars(panel, bearings)
        panel.set_xlabel("life [h]")
    return figure


#: Radius of the journal in clearances, so that a film is visible.
_JOURNAL_RADIUS = 4.0
#: Thickness of a pad and length of the highest pressure, in clearances.
_PAD_THICKNESS, _PRESSURE_LENGTH = 0.5, 2.5


def film(
    pads: Sequence["PadFilm"],
    place: tuple[float, float],
    clearance: float,
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw pads, journal and pressure across the shaft, and the film over the angle."""
    highest = max(float(pad.pressure.max()) for pad in pads)
    with panels(3, 4.4, columns=3, width=14.0, ax=ax, legend=False) as (figure, axes):
        across, thickness, pressure = axes
        centre = complex(*place) / clearance
        turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 181))
        _fill(across, centre + _JOURNAL_RADIUS * turn, fc="0.85", ec="black", label="journal")
        across.plot(0.0, 0.0, "+", color="black", label="centre of the bearing")
        across.plot(
            centre.real, centre.imag, "o", color="black", markersize=4.0, label="journal centre"
        )
        for number, pad in enumerate(pads):
            style: dict[str, Any] = {"color": colour(number)}
            direction = np.exp(1j * pad.angles)
            # the film of a tilted pad belongs to the journal at its place
            bore = centre + (_JOURNAL_RADIUS + pad.thickness / clearance) * direction
            back = bore + _PAD_THICKNESS * direction
            _fill(across, np.concatenate([bore, back[::-1]]), fc=style["color"], ec="black")
            share = pad.pressure / highest if highest > 0.0 else pad.pressure
            tips = back + _PRESSURE_LENGTH * share * direction
            _fill(
                across, np.concatenate([back, tips[::-1]]), fc=style["color"], ec="none", alpha=0.3
            )
            across.plot(tips.real, tips.imag, linewidth=1.0, **style)
            if pad.pivot is not None:
                at = np.interp(pad.pivot, pad.angles, np.arange(pad.angles.size))
                tip = back[round(float(at))] * (1.0 + 0.03)
                known: dict[str, Any] = {"label": "pivot"} if number == 0 else {}
                across.plot(tip.real, tip.imag, "^", color="black", markersize=7.0, **known)
            label = f"pad {number + 1}" if len(pads) > 1 else None
            degrees = np.degrees(pad.angles)
            thickness.plot(degrees, 1e6 * pad.thickness, label=label, **style)
            pressure.plot(degrees, 1e-6 * pad.pressure, **style)
        across.set_aspect("equal")
        across.set(xlabel="y [clearances]", ylabel="z [clearances]")
        across.set_title("gaps enlarged, pressure outside", loc="left")
        thickness.set(xlabel="angle from y towards z [°]", ylabel="film thickness [µm]")
        thickness.set_ylim(bottom=0.0)
        pressure.set(xlabel="angle from y towards z [°]", ylabel="pressure [MPa]")
        pressure.set_ylim(bottom=0.0)
        place_legend(figure, across, legend_entries([across]), ax=ax)
        if len(pads) > 1 and ax is None:
            thickness.legend()
    return figure


def _fill(panel: Any, points: Any, **style: Any) -> None:
    panel.fill(points.real, points.imag, **style)


#: Label of each panel, and the indices and names of its section forces.
_PANELS: tuple[tuple[str, dict[int, str]], ...] = (
    ("axial force [N]", {0: "N"}),
    ("shear force [N]", {1: "along y", 2: "along z"}),
    ("bending [N m]", {3: "about y", 4: "about z"}),
    ("torque [N m]", {5: "T"}),
)


class Course(NamedTuple):
    """Section forces along a shaft."""

    #: Positions of the sections, shape (k,) [m].
    positions: Array
    #: Smallest and largest section forces, shape (k, 6) [N, N m].
    low: Array
    high: Array
    #: Position [m] and name of what acts on the shaft.
    marks: Sequence[tuple[float, str]] = ()


def section_forces(courses: Mapping[str, Course], *, ax: GivenAxes = None) -> Figure:
    """Draw axial and shear force, bending moment and torque along shafts, a column for each."""
    columns = len(courses)
    count, width = len(_PANELS) * columns, max(7.0, 4.6 * columns)
    shared: dict[str, Any] = {"columns": columns, "width": width, "sharex": True, "legend": False}
    with panels(count, 2.1, ax=ax, **shared) as (figure, axes):
        for column, (shaft, course) in enumerate(courses.items()):
            own = axes[column::columns]
            for panel, (label, lines) in zip(own, _PANELS, strict=True):
                _draw(panel, course, lines)
                panel.set(ylabel=label if column == 0 else None)
            for x, name in course.marks:
                style: dict[str, Any] = {
                    "rotation": 40.0,
                    "fontsize": text_size(0.75),
                    "ha": "left",
                }
                own[0].text(
                    x, 1.02, name, transform=own[0].get_xaxis_transform(), va="bottom", **style
                )
            own[-1].set_xlabel(f"position on {shaft} [m]")
        for row in range(len(_PANELS)):
            common_round_off(axes[row * columns : (row + 1) * columns])
    return figure


def _draw(panel: Axes, course: Course, lines: Mapping[int, str]) -> None:
    """Draw the section forces of one panel between their smallest and largest values."""
    x = course.positions
    for number, (index, name) in enumerate(lines.items()):
        low, high = course.low[:, index], course.high[:, index]
        if (low != high).any():
            panel.fill_between(x, low, high, color=colour(number), alpha=0.25, linewidth=0.0)
            panel.plot(x, low, color=colour(number), linewidth=1.0)
        panel.plot(x, high, color=colour(number), linewidth=1.4, label=name)
    panel.axhline(0.0, color="0.6", linewidth=0.7, zorder=0.0)
    for at, _ in course.marks:
        panel.axvline(at, color="0.75", linewidth=0.7, linestyle=":", zorder=0.0)
    if len(lines) > 1:
        panel.legend(loc="best", fontsize=text_size(0.8))


def stresses(courses: Mapping[str, Sequence[Array]], *, ax: GivenAxes = None) -> Figure:
    """Draw positions [m], amplitudes and means of equivalent stresses [Pa] and utilisations."""
    # A row for each shaft: a page is as wide for many shafts as for one.
    has_limit = any(np.isfinite(course[3]).any() for course in courses.values())
    columns = 1 + has_limit
    count, width = columns * len(courses), 7.0 if columns == 1 else 12.0
    with panels(count, 2.6, columns=columns, width=width, ax=ax, legend=False) as (figure, axes):
        for row, (shaft, (x, amplitude, mean, utilisation)) in enumerate(courses.items()):
            own = axes[row * columns : (row + 1) * columns]
            own[0].plot(x, 1e-6 * amplitude, color=colour(0), label="amplitude, with notch factors")
            own[0].plot(x, 1e-6 * mean, color=colour(1), label="mean")
            own[0].set_ylabel("stress [MPa]")
            own[0].set_title(shaft, loc="left")
            if row == 0:
                own[0].legend(loc="best", fontsize=text_size(0.8))
            if has_limit:
                own[1].plot(x, utilisation, color=colour(2))
                own[1].axhline(1.0, color="0.5", linestyle="--", linewidth=0.9)
                own[1].set_ylabel("utilisation")
            for panel in own:
                panel.set_ylim(bottom=0.0)
                panel.locator_params(axis="x", nbins=6)
                panel.set_xlabel("position [m]")
    return figure
