"""Figures of an identification: vectors over the speed, residuals and estimates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearbow._types import Array, ComplexArray
from gearbow.plotting.style import (
    MICRO,
    GivenAxes,
    colour,
    label_x,
    legend,
    panels,
    place_legend,
    remark,
    speed_axis,
)

__all__ = ["Influence", "bode", "identification", "influence"]


@dataclass(frozen=True)
class Influence:
    """Influence coefficients of one plane on one probe over the speed."""

    speeds: Array
    measured: ComplexArray
    model: ComplexArray
    half_widths: Array


def bode(
    speeds: Array,
    measured: Mapping[str, ComplexArray],
    fitted: Mapping[str, ComplexArray],
    *,
    unit: str,
    ax: GivenAxes = None,
) -> Figure:
    """Draw phase and amplitude of each probe over the speed."""
    with panels(2, 3.6, columns=1, sharex=True, ax=ax) as (figure, axes):
        _bode(axes, speeds, measured, fitted, {})
        label_x(axes, speed_axis(unit)[1])
        legend(figure, axes[1], ax=ax)
    return figure


def influence(curves: Mapping[str, Influence], *, unit: str, ax: GivenAxes = None) -> Figure:
    """Draw phase and amplitude of influence coefficients; 1 m/(kg m) is 1 µm/(g mm)."""
    with panels(2, 3.6, columns=1, sharex=True, ax=ax) as (figure, axes):
        phase, amplitude = axes
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
        phase.set(ylabel="phase [°]", ylim=(-190.0, 190.0), yticks=[-180, -90, 0, 90, 180])
        amplitude.set(ylabel="influence [µm/(g mm)]")
        amplitude.set_ylim(bottom=0.0)
        remark(phase, "points: trial runs with 95 % intervals, crosses: model")
        label_x(axes, speed_axis(unit)[1])
        legend(figure, phase, ax=ax)
    return figure


def identification(
    speeds: Sequence[Array],
    measured: Sequence[Mapping[str, ComplexArray]],
    fitted: Sequence[ComplexArray],
    noise: Mapping[str, float],
    ellipses: Mapping[str, tuple[ComplexArray, float]],
    *,
    unit: str,
    ax: GivenAxes = None,
) -> Figure:
    """Draw vectors, residuals over the noise, and estimates with their 95 % ellipses."""
    numbers = {name: i for i, name in enumerate(noise)}
    with panels(5, 4.6, columns=2, width=14.0, ax=ax) as (figure, axes):
        phase, amplitude, polar, rest, estimates = axes
        for x, vectors, fits in zip(speeds, measured, fitted, strict=True):
            order = np.argsort(x)
            named = dict(zip(vectors, fits, strict=True))
            _bode([phase, amplitude], x, vectors, named, numbers)
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
            panel.set_xlabel(speed_axis(unit)[1])
        remark(amplitude, "points: measured, lines: fitted")
        _ellipses(estimates, ellipses)
        handles, labels = phase.get_legend_handles_labels()
        own = dict(zip(labels, handles, strict=True))
        place_legend(figure, phase, (list(own.values()), list(own)), ax=ax)
    return figure


def _bode(
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
    phase.set(ylabel="phase [°]", ylim=(-190.0, 190.0), yticks=[-180, -90, 0, 90, 180])
    amplitude.set(ylabel="amplitude [µm]")
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
