"""
Backlash and loss of contact
============================

A light load of 10 N m drives a pair with a bowed shaft. The bow lets the mesh force fluctuate by
more than its mean: the teeth separate, move freely in the backlash and meet again. Each contact and
each separation is an event with its exact time.

The figure shows the mesh force over two revolutions of the input shaft, and the instants at which
the teeth separate.
"""

import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

tooth = {"module": 3e-3, "face_width": 0.03}
system = gb.RotorSystem(
    shafts=[
        gb.Shaft("input", length=0.5, outer_diameter=0.04, bow=gb.Bow.half_sine(3.5e-4)),
        gb.Shaft("output", length=0.5, outer_diameter=0.05),
    ],
    gears=[
        gb.Gear("pinion", "input", 0.2, teeth=25, **tooth),
        gb.Gear("wheel", "output", 0.2, teeth=50, **tooth),
    ],
    meshes=[gb.Mesh("pinion", "wheel", stiffness=2e8, damping_ratio=0.05, backlash=4e-4)],
    bearings=[
        gb.Bearing(shaft, x, stiffness=1e8, damping=2e3)
        for shaft in ("input", "output")
        for x in (0.0, 0.5)
    ],
    torques=[gb.Torque("pinion", 10.0), gb.Torque.balance("wheel")],
)
speed = 820.0  # of the input shaft, rad/s
turn = 2 * np.pi / speed
times = np.linspace(6 * turn, 8 * turn, 2001)
response = system.simulate(8 * turn, speed, times=times, record=["meshes"])
separations = [event.time for event in response.events if event.kind == "separation"]
print(f"{len(separations)} separations in 8 revolutions of the input shaft")
shares = response.contact_shares(("pinion", "wheel"))
print(f"no contact of the drive flanks during {100 * shares.lost:.0f} % of the last two")

figure = Figure(figsize=(6.4, 4.0), layout="constrained")
panel = figure.subplots()
panel.plot(response.time / turn, response.mesh(("pinion", "wheel")).force)
shown = [time / turn for time in separations if time >= times[0]]
panel.plot(shown, np.zeros(len(shown)), "kv", label="separation")
panel.set(xlabel="revolutions of the input shaft", ylabel="mesh force [N]")
panel.legend()
