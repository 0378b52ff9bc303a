"""Figures of harmonic responses and of identification: Bode and polar plots, orbits, waterfall."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearbow._types import Array, ComplexArray
from gearbow.plotting.labels import Labels
from gearbow.plotting.orders import speed_map
from gearbow.plotting.style import (
    MICRO,
    GivenAxes,
    colour,
    legend_entries,
    log_scale,
    panels,
    place_legend,
    quantity,
    remark,
    shade_operating,
    speed_axis,
    text_size,
)
from gearbow.units.speed import speed_text

#: Name of the amplitude by its unit, the unit of the figure and its factor.
_QUANTITIES = {
    "m": ("displacement", "µm", MICRO),
    "m/s": ("velocity", "mm/s", 1e3),
    "m/s²": ("acceleration", "m/s²", 1.0),
    "rad": ("twist", "mrad", 1e3),
    "N": ("force", "N", 1.0),
}
#: Smallest orbit of a figure relative to the largest one of its panels, and the size below which
#: one is shown only where all are small [m].
_VISIBLE, _TINY = 1e-5, 1e-10
#: Ratio of a peak to the median of a response from which its axis is logarithmic.
_RESONANT = 30.0
#: Directions in which a text stands from its point.
_AROUND = ((1.0, 0.5), (-1.0, 0.5), (1.0, -0.5), (-1.0, -0.5), (1.0, 1.0), (-1.0, 1.0))


@dataclass(frozen=True, eq=False)
class Curve:
    """Amplitude and phase [rad] of a signal along an axis; the phase is NaN where there is none."""

    along: Array
    size: Array
    phase: Array

    @classmethod
    def of(cls, along: Array, phasors: ComplexArray) -> "Curve":
        """Make the curve of phasors."""
        phase = np.where(phasors == 0.0, np.nan, np.angle(phasors))
        return cls(along, np.abs(phasors), phase)


def bode(
    curves: Mapping[str, Curve],
    unit: str,
    *,
    over: str = "speed",
    frf: bool = False,
    pairs: bool = False,
    peaks: Mapping[str, Sequence[tuple[float, float, str | None]]] | None = None,
    operating: tuple[float, float] | None = None,
    ax: GivenAxes = None,
) -> Figure:
    """Draw phase above amplitude; an `frf` has its amplitude above, on a logarithmic axis."""
    # Peaks have speed, amplitude and text, half-power points no text; with `pairs`, two curves each
    # have a colour.
    name, shown, scale = _QUANTITIES[unit]
    factor, label = speed_axis() if over == "speed" else (0.5 / np.pi, "frequency [Hz]")
    marked: list[tuple[tuple[float, float], str, Any]] = []
    still: list[str] = []
    with panels(2, 3.6, sharex=True, ax=ax, x=label) as (figure, axes):
        amplitudes, phases = axes if frf else axes[::-1]
        for panel in axes if operating is not None else ():
            shade_operating(panel, factor * np.array(operating))
        for number, (signal, curve) in enumerate(curves.items()):
            style: dict[str, Any] = {
                "color": colour(number // 2 if pairs else number),
                "linestyle": ("-", "--", "-.", ":")[number % (2 if pairs else 4)],
            }
            known = np.isfinite(curve.phase)
            if not np.any(known & (curve.size > 0.0)):
                still.append(signal)
                continue
            # The phase has no jumps of 360°; its value at the first point is unchanged.
            turned = np.degrees(np.unwrap(curve.phase[known]))
            own = (peaks or {}).get(signal, ())
            x, size = _merged(curve, own)
            if frf:
                # A logarithmic axis has no zero.
                size = np.where(size == 0.0, np.nan, size)
            phases.plot(factor * curve.along[known], turned, **style)
            amplitudes.plot(factor * x, scale * size, **style)
            axes[0].lines[-1].set_label(signal)
            for speed, peak, text in own:
                if text is not None:
                    at = (factor * speed, scale * peak)
                    amplitudes.plot(*at, "v", color=style["color"], markersize=8.0)
                    marked.append((at, text, style["color"]))
        if still:
            remark(axes[0], f"not excited: {', '.join(still)}")
        phases.set(ylabel="phase [°]")
        amplitudes.set(ylabel=f"{name if frf else 'amplitude'} [{shown}]")
        if frf:
            log_scale(amplitudes)
        else:
            _scale(amplitudes, has_peaks=bool(marked))
    _name(amplitudes, marked)
    return figure


def _name(panel: Axes, points: Sequence[tuple[tuple[float, float], str, Any]]) -> None:
    """Write the texts of points beside them, each in its colour."""
    labels = Labels(panel, 0.0)
    for at, text, shade in points:
        labels.add(text, [(at, way) for way in _AROUND], fontsize=text_size(0.79), color=shade)
    labels.place()


def _scale(panel: Axes, *, has_peaks: bool) -> None:
    """Scale amplitudes: from zero, or logarithmic if a peak would press all else to the axis."""
    drawn = [np.asarray(line.get_ydata(), dtype=np.float64) for line in panel.lines]
    curves = [values for values in drawn if values.size > 1]
    sizes = np.concatenate([np.zeros(1), *curves])
    top = float(np.max(sizes, initial=0.0))
    usual = float(np.median(sizes[sizes > 0.0])) if top > 0.0 else 0.0
    if top > _RESONANT * usual > 0.0:
        log_scale(panel)
        panel.set_ylim(max(0.5 * float(sizes[sizes > 0.0].min()), 1e-3 * usual), 3.0 * top)
        return
    panel.set_ylim(bottom=0.0)
    if has_peaks:
        # The factors of the peaks stay within the panel.
        panel.set_ylim(top=1.08 * panel.get_ylim()[1])


def polar(
    curves: Mapping[str, Curve], unit: str, *, ends: bool = False, ax: GivenAxes = None
) -> Figure:
    """Draw curves in the complex plane; with `ends`, speeds at ends and maximum."""
    _, shown, scale = _QUANTITIES[unit]
    named: list[tuple[tuple[float, float], str, Any]] = []
    with panels(1, 7.0, width=8.0, ax=ax) as (figure, (panel,)):
        for number, (name, curve) in enumerate(curves.items()):
            style: dict[str, Any] = {"color": colour(number), "label": name}
            points = scale * curve.size * np.exp(1j * curve.phase)
            panel.plot(points.real, points.imag, marker=".", markersize=3, **style)
            if ends and np.isfinite(points).any():
                known = np.flatnonzero(np.isfinite(points))
                largest = known[np.argmax(np.abs(points[known]))]
                for i in dict.fromkeys((int(known[0]), int(largest), int(known[-1]))):
                    at = (float(points[i].real), float(points[i].imag))
                    panel.plot(*at, "o", color=style["color"], markersize=5.0)
                    speed = speed_text(curve.along[i], form=".4g")
                    named.append((at, speed, style["color"]))
        panel.axhline(0.0, color="0.6", linewidth=0.8)
        panel.axvline(0.0, color="0.6", linewidth=0.8)
        panel.set_aspect("equal", adjustable="datalim")
        # Labels such as −0.0025 are longer than Matplotlib expects.
        panel.locator_params(axis="x", nbins=5)
        panel.set(xlabel=f"real part [{shown}]", ylabel=f"imaginary part [{shown}]")
    _name(panel, named)
    return figure


def waterfall(
    frequencies: Array,
    speeds: Array,
    amplitudes: Array,
    name: str,
    unit: str,
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw amplitudes over frequency and speed as a map."""
    _, shown, scale = _QUANTITIES[unit]
    with panels(1, 6.0, width=10.0, ax=ax) as (figure, (panel,)):
        hertz, label = frequencies / (2.0 * np.pi), f"{name} [{shown}]"
        factor, axis = speed_axis()
        least = float(np.min(amplitudes, where=amplitudes > 0.0, initial=amplitudes.max()))
        speed_map(panel, hertz, factor * speeds, scale * amplitudes, label, least=scale * least)
        panel.set(ylabel=axis)
    return figure


def synchronous(
    speeds: Array,
    orbits: Mapping[str, Array],
    shafts: Sequence[str],
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw the major semi-axis of the orbits against the speed."""
    factor, label = speed_axis()
    shared: dict[str, Any] = {"sharex": True, "x": label, "legend": "excited by the shaft"}
    with panels(len(orbits), 3.2, ax=ax, **shared) as (figure, axes):
        largest = max(float(orbit.max(initial=0.0)) for orbit in orbits.values())
        least = max(_VISIBLE * largest, min(_TINY, 1e-2 * largest))
        for panel, (name, orbit) in zip(axes, orbits.items(), strict=True):
            for source, shaft in enumerate(shafts):
                if np.any(orbit[:, source] > least):
                    values = MICRO * orbit[:, source]
                    panel.plot(factor * speeds, values, label=shaft, color=colour(source))
            panel.set(ylabel=f"{name} [µm]")
            if not panel.lines:
                remark(panel, f"below {quantity(least, 'm', 2)}")
                panel.set_yticks([])
                continue
            log_scale(panel)
            if panel.get_ylim()[0] < MICRO * least:
                panel.set_ylim(bottom=MICRO * least)
    return figure


def _merged(
    curve: Curve, further: Sequence[tuple[float, float, str | None]]
) -> tuple[Array, Array]:
    """Give a curve through its points and further ones in ascending order within its ends."""
    if not further:
        return curve.along, curve.size
    low, high = curve.along.min(), curve.along.max()
    within = [(x, y) for x, y, _ in further if low <= x <= high]
    x, y = np.array([*zip(curve.along, curve.size, strict=True), *within]).T
    order = np.argsort(x, kind="stable")
    return x[order], y[order]


@dataclass(frozen=True)
class Influence:
    """Influence coefficients of one plane on one probe over the speed."""

    speeds: Array
    measured: ComplexArray
    model: ComplexArray
    half_widths: Array


def measured_bode(
    speeds: Array,
    measured: Mapping[str, ComplexArray],
    fitted: Mapping[str, ComplexArray],
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw phase and amplitude of each probe over the speed."""
    with panels(2, 3.6, sharex=True, ax=ax, x=speed_axis()[1]) as (figure, axes):
        _measured(axes, speeds, measured, fitted, {})
    return figure


def influence(curves: Mapping[str, Influence], *, ax: GivenAxes = None) -> Figure:
    """Draw phase and amplitude of influence coefficients; 1 m/(kg m) is 1 µm/(g mm)."""
    with panels(2, 3.6, sharex=True, ax=ax, x=speed_axis()[1]) as (figure, (phase, amplitude)):
        for i, (name, curve) in enumerate(curves.items()):
            style: dict[str, Any] = {"color": colour(i)}
            order = np.argsort(curve.speeds)
            x, model = curve.speeds[order], curve.model[order]
            size = np.abs(curve.measured)
            # The angle that the interval takes up as seen from the origin.
            angles = np.arcsin(np.minimum(curve.half_widths / np.maximum(size, 1e-300), 1.0))
            marks: dict[str, Any] = {"fmt": "o", "markersize": 4.0, "capsize": 3.0, **style}
            phase.errorbar(
                curve.speeds,
                np.degrees(np.angle(curve.measured)),
                np.degrees(angles),
                label=name,
                **marks,
            )
            phase.plot(x, np.degrees(np.angle(model)), "x-", **style)
            amplitude.errorbar(curve.speeds, size, curve.half_widths, **marks)
            amplitude.plot(x, np.abs(model), "x-", **style)
        _scale_measured(phase, amplitude, "influence [µm/(g mm)]")
        remark(phase, "points: trial runs with 95 % intervals, crosses: model")
    return figure


def identification(
    speeds: Sequence[Array],
    measured: Sequence[Mapping[str, ComplexArray]],
    fitted: Sequence[ComplexArray],
    noise: Mapping[str, float],
    ellipses: Mapping[str, tuple[ComplexArray, float]],
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw vectors, residuals over the noise, and estimates with their 95 % ellipses."""
    numbers = {name: i for i, name in enumerate(noise)}
    with panels(5, 4.6, columns=2, width=14.0, ax=ax, legend=False) as (figure, axes):
        phase, amplitude, polar, rest, estimates = axes
        for x, vectors, fits in zip(speeds, measured, fitted, strict=True):
            order = np.argsort(x)
            named = dict(zip(vectors, fits, strict=True))
            _measured([phase, amplitude], x, vectors, named, numbers)
            for name, values in vectors.items():
                style: dict[str, Any] = {"color": colour(numbers[name])}
                polar.plot(MICRO * values.real, MICRO * values.imag, "o", markersize=3.5, **style)
                line = MICRO * named[name][order]
                polar.plot(line.real, line.imag, **style)
                left = values - named[name]
                for part, mark in ((left.real, "o"), (left.imag, "x")):
                    rest.plot(x, part / noise[name], mark, markersize=4.0, **style)
        rest.axhspan(-1.96, 1.96, color="0.9", zorder=0.5, label="95 % of the noise")
        rest.set(ylabel="residual / noise")
        remark(rest, "re: points, im: crosses")
        polar.set(xlabel="re [µm]", ylabel="im [µm]")
        polar.set_aspect("equal", adjustable="datalim")
        for panel in (phase, amplitude, rest):
            panel.set_xlabel(speed_axis()[1])
        remark(amplitude, "points: measured, lines: fitted")
        _ellipses(estimates, ellipses)
        place_legend(figure, phase, legend_entries([phase]), ax=ax)
    return figure


def _measured(
    axes: Sequence[Axes],
    speeds: Array,
    measured: Mapping[str, ComplexArray],
    fitted: Mapping[str, ComplexArray],
    numbers: Mapping[str, int],
) -> None:
    phase, amplitude = axes
    order = np.argsort(speeds)
    for i, (name, values) in enumerate(measured.items()):
        style: dict[str, Any] = {"color": colour(numbers.get(name, i))}
        mark: dict[str, Any] = {"markersize": 3.5, "label": name, **style}
        phase.plot(speeds, np.degrees(np.angle(values)), "o", **mark)
        amplitude.plot(speeds, MICRO * np.abs(values), "o", **mark)
        if name in fitted:
            line = fitted[name][order]
            phase.plot(speeds[order], np.degrees(np.angle(line)), **style)
            amplitude.plot(speeds[order], MICRO * np.abs(line), **style)
    _scale_measured(phase, amplitude, "amplitude [µm]")


def _scale_measured(phase: Axes, amplitude: Axes, label: str) -> None:
    """Scale phases to one turn, because measured ones may jump, and amplitudes from zero."""
    phase.set(ylabel="phase [°]", ylim=(-190.0, 190.0), yticks=[-180, -90, 0, 90, 180])
    amplitude.set(ylabel=label)
    amplitude.set_ylim(bottom=0.0)


def _ellipses(panel: Axes, ellipses: Mapping[str, tuple[ComplexArray, float]]) -> None:
    """Draw each estimate in units of its detectable amplitude."""
    turn = np.exp(2j * np.pi * np.linspace(0.0, 1.0, 73))
    panel.plot(turn.real, turn.imag, color="0.6", linestyle=":", label="detectable")
    for i, (name, (boundary, detectable)) in enumerate(ellipses.items()):
        scaled = boundary / detectable
        panel.plot(scaled.real, scaled.imag, color=colour(i), label=name)
        centre = scaled[:-1].mean()
        panel.plot(centre.real, centre.imag, "+", color=colour(i))
    # Well known amplitudes are hundreds of times the detectable one.
    panel.set_xscale("symlog", linthresh=2.0)
    panel.set_yscale("symlog", linthresh=2.0)
    panel.set(xlabel="re / detectable", ylabel="im / detectable")
    panel.legend(fontsize="small", loc="best")
