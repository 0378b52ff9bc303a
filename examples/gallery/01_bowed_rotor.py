"""
Bowed rotor and its critical speed
==================================

A shaft with a bow of 0.1 mm carries a disk. At low speed the disk orbits with the bow. The orbit
grows towards the critical speed and shrinks above it. An unbalance opposite to the bow adds a force
that grows with the square of the speed; at one speed it cancels the bow. `synchronous` computes the
steady orbit without time integration.

The figure shows the radius of the orbit of the disk against the speed.
"""

import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

disk = gb.Disk("disk", "rotor", 0.5, mass=20.0, diametral_inertia=0.1, polar_inertia=0.2)
heavy = gb.Disk("disk", "rotor", 0.5, 20.0, 0.1, 0.2, unbalance=-20.0 * 2e-4)
rotor = gb.RotorSystem(
    shafts=[gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=gb.Bow.half_sine(1e-4))],
    disks=[disk],
    bearings=[gb.Bearing("rotor", x, stiffness=5e7, damping=2e4) for x in (0.0, 1.0)],
    modal_damping=0.03,
)

speeds = np.linspace(1.0, 700.0, 700)
bowed = rotor.synchronous(speeds)
unbalanced = rotor.replace(disks=[heavy]).synchronous(speeds)
peak = bowed.peaks("disk")[0]
print(f"critical speed {peak.speed:.0f} rad/s, orbit {1e6 * peak.amplitude:.0f} µm")

figure = Figure(figsize=(6.4, 4.0), layout="constrained")
panel = figure.subplots()
panel.semilogy(speeds, 1e6 * bowed.orbit("disk"), label="bow")
panel.semilogy(speeds, 1e6 * unbalanced.orbit("disk"), "--", label="bow and opposite unbalance")
panel.axvline(peak.speed, color="k", linestyle=":", label="critical speed")
panel.set(xlabel="speed [rad/s]", ylabel="radius of the orbit [µm]")
panel.legend()
