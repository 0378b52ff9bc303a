"""
Contact ratio of a pair with a bowed shaft
==========================================

A bow moves the gear centres once per revolution. The pressure angle and the contact ratio follow
the distance of the centres. A bow of half a millimetre lets the contact ratio of this pair vary
between 1.44 and 1.78.

The figure shows the contact ratio over two revolutions of the input shaft, for three bows.
"""

import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

tooth = {"module": 3e-3, "face_width": 0.03}


def pair(bow):
    return gb.RotorSystem(
        shafts=[
            gb.Shaft("input", length=0.5, outer_diameter=0.05, bow=gb.Bow.half_sine(bow)),
            gb.Shaft("output", length=0.5, outer_diameter=0.05),
        ],
        gears=[
            gb.Gear("pinion", "input", 0.25, teeth=25, **tooth),
            gb.Gear("wheel", "output", 0.25, teeth=50, **tooth),
        ],
        meshes=[gb.Mesh("pinion", "wheel", stiffness=2e8, damping_ratio=0.05)],
        bearings=[
            gb.Bearing(shaft, x, stiffness=1e8, damping=500.0)
            for shaft in ("input", "output")
            for x in (0.0, 0.5)
        ],
        torques=[gb.Torque("pinion", 250.0), gb.Torque.balance("wheel")],
    )


speed = 100.0  # of the input shaft, rad/s
figure = Figure(figsize=(6.4, 4.0), layout="constrained")
panel = figure.subplots()
for bow in (5e-4, 2e-4, 1e-5):
    response = pair(bow).simulate(4 * np.pi / speed, speed, output_step=1e-4)
    ratio = response.mesh(("pinion", "wheel")).contact_ratio
    print(f"bow {1e6 * bow:3.0f} µm: contact ratio {ratio.min():.2f} to {ratio.max():.2f}")
    panel.plot(speed * response.time / (2 * np.pi), ratio, label=f"{1e6 * bow:g} µm")

panel.set(xlabel="revolutions of the input shaft", ylabel="contact ratio")
panel.legend(title="bow")
