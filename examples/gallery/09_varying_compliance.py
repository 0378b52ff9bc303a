"""
Rolling bearing: varying compliance
===================================

The balls of a bearing turn with the cage. While they pass the load, the stiffness varies, and a
rotor without any unbalance moves at the ball-pass frequency. More clearance means fewer loaded
balls and a larger motion.

The figure shows the vertical motion of the disk about its mean, while three balls pass the load.
"""

import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

sizes = {"elements": 9, "element_diameter": 0.0127, "pitch_diameter": 0.065}
speed = 50.0  # rad/s


def rotor(clearance):
    return gb.RotorSystem(
        shafts=[gb.Shaft("rotor", length=0.3, outer_diameter=0.04)],
        disks=[gb.Disk("disk", "rotor", 0.15, 10.0, 0.02, 0.04)],
        bearings=[
            gb.RollingBearing("rotor", x, clearance=clearance, damping=2000.0, **sizes)
            for x in (0.0, 0.3)
        ],
        gravity=9.81,
    )


passes = gb.RollingBearing("rotor", 0.0, clearance=0.0, **sizes).ball_pass_order
period = 2 * np.pi / (speed * passes)  # between two balls, s
figure = Figure(figsize=(6.4, 4.0), layout="constrained")
panel = figure.subplots()
for clearance in (5e-6, 1e-5, 2e-5):
    times = np.linspace(20 * period, 23 * period, 600)
    run = rotor(clearance).simulate(23 * period, speed, times=times, record=["disk"])
    height = 1e6 * run.displacement("disk")[:, 1]
    print(f"clearance {1e6 * clearance:2.0f} µm: {np.ptp(height):.2f} µm peak-to-peak")
    panel.plot((times - times[0]) / period, height - height.mean(), label=f"{1e6 * clearance:g} µm")

panel.set(xlabel="ball passes", ylabel="vertical motion [µm]")
panel.legend(title="clearance")
