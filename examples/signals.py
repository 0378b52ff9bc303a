"""Draw the figures of docs/signals.md: probes, pulses, an acceleration without aliasing, a run-up.

Run with ``python examples/signals.py``. The script writes the figures to ``docs/figures``.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

FIGURES = Path(__file__).parent.parent / "docs" / "figures"
SPEED = 100.0  # rad/s
RATE = 2500.0  # Hz


def train() -> gb.RotorSystem:
    """Return a geared pair with a bowed input shaft; the output shaft stands on a pedestal."""
    return gb.RotorSystem(
        shafts=[
            gb.Shaft("input", length=0.5, outer_diameter=0.06, bow=gb.Bow.half_sine(4e-5)),
            gb.Shaft("output", length=0.5, outer_diameter=0.06),
        ],
        gears=[
            gb.Gear("pinion", "input", 0.25, teeth=25, module=3e-3, face_width=0.03),
            gb.Gear("wheel", "output", 0.25, teeth=50, module=3e-3, face_width=0.03),
        ],
        meshes=[gb.Mesh("pinion", "wheel", stiffness=gb.Stiffness.square(3e8), damping_ratio=0.05)],
        bearings=[
            *(gb.Bearing("input", x, stiffness=1e8, damping=2e3) for x in (0.0, 0.5)),
            *(
                gb.Bearing("output", x, stiffness=1e8, damping=2e3, support="pedestal")
                for x in (0.0, 0.5)
            ),
        ],
        supports=[gb.Support(name="pedestal", mass=40.0, stiffness=2e8, damping=2e4)],
        torques=[gb.Torque("pinion", 100.0), gb.Torque.balance("wheel")],
    )


def draw(system: gb.RotorSystem) -> Figure:
    """Simulate, measure, and draw both parts of the figure."""
    place = ("input", 0.25)
    response, coarse = (
        system.simulate(
            0.5,
            SPEED,
            record=[place, "pedestal", "acceleration"],
            rtol=1e-6,
            output_step=step,
        )
        for step in (2e-5, 1.0 / RATE)
    )

    figure, (top, bottom) = plt.subplots(2, 1, figsize=(8.0, 7.0), layout="constrained")
    surface = 3e-6 * np.exp(1j * np.radians(120.0))
    for angle in (45.0, 135.0):
        probe = gb.Probe(*place, angle=np.radians(angle), runout=surface)
        top.plot(response.time, 1e6 * response.measure(probe), label=f"probe at {angle:.0f}°")
    for index, time in enumerate(response.measure(gb.Tacho("input"))):
        label = "pulse of the tachometer" if index == 0 else None
        top.axvline(time, color="0.6", linestyle=":", label=label)
    top.set(xlim=(0.0, 0.2), ylim=(-115.0, 60.0), xlabel="time [s]", ylabel="displacement [µm]")
    top.legend(loc="upper center", ncols=3)

    sensor = gb.Accelerometer("pedestal", angle=np.pi / 2)
    for run, label, style in (
        (coarse, f"sampled at {RATE:.0f} Hz without a filter", {"color": "C1"}),
        (response, "recorded at 50 kHz", {"color": "0.5", "linewidth": 3.0}),
        (response.resample(RATE), f"resampled at {RATE:.0f} Hz", {"color": "C0"}),
    ):
        found = run.spectrum(sensor, window="flat top")
        bottom.semilogy(found.frequencies_hz, found.amplitudes, label=label, **style)
    bottom.axvline(RATE / 2.0, color="k", linestyle="--", linewidth=1.0, label="half of the rate")
    bottom.set(
        xlim=(0.0, 2000.0),
        ylim=(1e-4, 1e3),
        xlabel="frequency [Hz]",
        ylabel="acceleration of the pedestal [m/s²]",
    )
    bottom.legend(loc="upper center", ncols=2)
    for axes in (top, bottom):
        axes.grid(alpha=0.3)
    return figure


def draw_run_up() -> Figure:
    """Draw the orders and the waterfall of a bowed rotor that passes its first critical speed."""
    rotor = gb.RotorSystem(
        [gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=gb.Bow.half_sine(2e-5))],
        disks=[gb.Disk("disk", "rotor", 0.5, 20.0, 0.1, 0.2)],
        bearings=[gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)],
        modal_damping=0.02,
    )
    ramp = gb.SpeedProfile.ramp(50.0, 500.0, duration=5.0)
    run = rotor.simulate(5.0, ramp, output_step=5e-4, record=["disk"])
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(8.0, 8.0), layout="constrained")
    run.orders("disk", "y").plot(ax=top, speed_unit="rpm")
    gb.waterfall(run, "disk", "y").plot(120.0, ax=bottom, speed_unit="rpm")
    return figure


def main() -> None:
    """Draw and save the figures."""
    draw(train()).savefig(FIGURES / "signals.png", dpi=80)
    draw_run_up().savefig(FIGURES / "run_up.png", dpi=80)


if __name__ == "__main__":
    main()
