"""Figures of a thermal bow."""

import numpy as np
from matplotlib.figure import Figure

from gearbow._types import Array, ComplexArray
from gearbow.plotting.style import MICRO, PALETTE, GivenAxes, label_x, legend, panels, speed_axis

__all__ = ["spiral", "stability"]


def stability(
    speeds: Array, unit: str, gain: ComplexArray, growth: Array, ax: GivenAxes = None
) -> Figure:
    """Draw the loop gain, and the growth in each minute, over speeds in their unit."""
    with panels(2, 3.4, columns=1, sharex=True, ax=ax) as (figure, axes):
        upper, lower = axes
        upper.plot(speeds, gain.real, color=PALETTE[0], label="real part")
        upper.plot(speeds, gain.imag, "--", color=PALETTE[1], label="imaginary part")
        upper.axhline(1.0, color="black", linewidth=1.0, linestyle=":", label="limit")
        upper.set_ylabel("loop gain")
        legend(figure, upper, ax=ax)
        lower.plot(speeds, growth, color=PALETTE[0])
        lower.axhline(0.0, color="black", linewidth=1.0, linestyle=":")
        grows = np.maximum(growth, 0.0)
        lower.fill_between(speeds, 0.0, grows, color=PALETTE[1], alpha=0.3, linewidth=0.0)
        lower.set_ylabel("growth [1/min]")
        label_x(axes, speed_axis(unit)[1])
    return figure


def spiral(time: Array, vibration: ComplexArray, ax: GivenAxes = None) -> Figure:
    """Draw the vibration [m] as a spiral, and its amplitude over time [s]."""
    with panels(2, 5.0, columns=2, ax=ax) as (figure, axes):
        plane, over_time = axes
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
