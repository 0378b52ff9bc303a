"""
Journal bearing and oil whirl
=============================

A rotor runs on two journal bearings. Above a threshold speed the oil film destabilises it: the
journal whirls forward at about half the speed of the shaft. Linear analysis gives the threshold; a
run with the nonlinear film shows that the orbit stays within the clearance.

The figure shows the path of the left journal in its clearance, over 40 revolutions.
"""

import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

clearance = 1e-4  # m
oil = {"diameter": 0.05, "length": 0.025, "clearance": clearance, "viscosity": 0.02}
rotor = gb.RotorSystem(
    shafts=[gb.Shaft("rotor", length=0.3, outer_diameter=0.05)],
    disks=[gb.Disk("disk", "rotor", 0.15, 30.0, 0.05, 0.1, unbalance=2e-4)],
    bearings=[gb.JournalBearing("rotor", x, **oil) for x in (0.0, 0.3)],
    gravity=9.81,
)

figure = Figure(figsize=(7.0, 4.0), layout="constrained")
panels = figure.subplots(1, 2, sharey=True)
angle = np.linspace(0.0, 2 * np.pi, 200)
for panel, speed in zip(panels, (400.0, 1200.0)):
    eigenvalues = rotor.modes(speed).eigenvalues
    worst = max(eigenvalues[eigenvalues.imag > 1.0], key=lambda value: value.real)
    state = "stable" if worst.real < 0.0 else "unstable"
    print(f"{speed:.0f} rad/s: {state}, whirl at {worst.imag / speed:.2f} of the speed")
    revolution = 2 * np.pi / speed
    run = rotor.simulate(40 * revolution, speed, output_step=revolution / 50, record=["bearings"])
    v, w = run.bearing_displacement(("rotor", 0.0))[1:].T / clearance
    panel.plot(np.cos(angle), np.sin(angle), "k")
    panel.plot(v, w, linewidth=0.8)
    panel.set(title=f"{speed:.0f} rad/s, {state}", xlabel="y / clearance", aspect="equal")

panels[0].set_ylabel("z / clearance")
