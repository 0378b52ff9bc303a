"""
Tip relief and transmission error
=================================

The transmission error under load varies over the mesh cycle, because one or two tooth pairs carry
the load. Tip relief removes material towards the ends of the path of contact, so that a pair takes
up its load gradually. With a linear relief over the part of the path where two pairs share the
load, the error is constant at one torque, the design load: there the relief at the tip is the
deflection of a single pair.

The figure shows the transmission error, on the line of action, over two mesh cycles.
"""

import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

tooth = {"module": 3e-3, "face_width": 0.03}
relief = gb.TipRelief(28.4e-6, length=6.05e-3)  # for 200 N m


def pair(torque, tip_relief):
    mesh = gb.Mesh(
        "pinion",
        "wheel",
        stiffness=gb.Stiffness.square(pair=2e8),
        damping_ratio=0.1,
        tip_relief=tip_relief,
    )
    return gb.RotorSystem(
        shafts=[gb.Shaft(name, length=0.2, outer_diameter=0.05) for name in ("input", "output")],
        gears=[
            gb.Gear("pinion", "input", 0.1, teeth=25, **tooth),
            gb.Gear("wheel", "output", 0.1, teeth=50, **tooth),
        ],
        meshes=[mesh],
        torques=[gb.Torque("pinion", torque), gb.Torque.balance("wheel")],
        motion="torsion",
    )


cycle = 2 * np.pi / 25  # s at 1 rad/s: so slow that the motion is quasi-static
times = np.linspace(cycle, 3 * cycle, 800)
figure = Figure(figsize=(7.0, 4.0), layout="constrained")
panels = figure.subplots(1, 2, sharey=True)
for panel, tip_relief, title in zip(panels, (None, relief), ("no relief", "tip relief")):
    for torque in (400.0, 200.0, 100.0):
        run = pair(torque, tip_relief).simulate(3 * cycle, 1.0, times=times, initial="static")
        error = 1e6 * run.mesh(("pinion", "wheel")).deflection
        print(f"{title}, {torque:.0f} N m: {np.ptp(error):.1f} µm peak-to-peak")
        panel.plot(times / cycle - 1.0, error, label=f"{torque:g} N m")
    panel.set(title=title, xlabel="mesh cycles")

panels[0].set(ylabel="transmission error [µm]", ylim=(0.0, 90.0))
panels[0].legend(title="torque", loc="upper center")
