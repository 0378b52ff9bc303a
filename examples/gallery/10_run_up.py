"""
Run-up through a critical speed
===============================

A bowed rotor accelerates through its critical speed. The faster it passes, the smaller is the peak,
and the later it appears. After the peak, the amplitude beats: the free vibration decays while the
excitation moves on.

The figure shows the distance of the disk from its axis against the speed, for three accelerations.
"""

import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

rotor = gb.RotorSystem(
    shafts=[gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=gb.Bow.half_sine(1e-4))],
    disks=[gb.Disk("disk", "rotor", 0.5, 20.0, diametral_inertia=0.1, polar_inertia=0.2)],
    bearings=[gb.Bearing("rotor", x, stiffness=5e7) for x in (0.0, 1.0)],
    modal_damping=0.02,
)
critical = 2 * np.pi * rotor.modes(count=1).frequencies_hz[0]

figure = Figure(figsize=(6.4, 4.0), layout="constrained")
panel = figure.subplots()
steady = rotor.synchronous(np.linspace(0.7, 1.5, 300) * critical)
panel.plot(steady.speeds / critical, 1e6 * steady.orbit("disk"), "k:", label="steady")
for duration in (3.0, 0.6, 0.2):
    ramp = gb.SpeedProfile.ramp(0.7 * critical, 1.5 * critical, duration=duration)
    run = rotor.simulate(duration, ramp, output_step=5e-4, record=["disk"])
    radius = np.hypot(*run.displacement("disk").T)
    top = run.speeds[radius.argmax()] / critical
    print(f"{duration:.1f} s: {1e6 * radius.max():.0f} µm at {top:.2f} of the critical speed")
    panel.plot(run.speeds / critical, 1e6 * radius, label=f"in {duration:g} s")

panel.set(xlabel="speed / critical speed", ylabel="distance from the axis [µm]")
panel.legend()
