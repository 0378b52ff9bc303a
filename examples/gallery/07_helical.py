"""
Helix angle: thrust against smoothness
======================================

The contact of helical teeth moves gradually across the face, so that the mesh stiffness varies less
than that of spur teeth. The price is a thrust that grows with the tangent of the helix angle, and
that one bearing of each shaft has to carry.

The figure shows the thrust, and variation of the mesh force at 100 rad/s, against the helix angle.
"""

import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

tooth = {"module": 3e-3, "face_width": 0.03}


def pair(helix):
    places = [(shaft, x) for shaft in ("input", "output") for x in (0.0, 0.4)]
    return gb.RotorSystem(
        shafts=[gb.Shaft(name, length=0.4, outer_diameter=0.05) for name in ("input", "output")],
        gears=[
            gb.Gear("pinion", "input", 0.15, teeth=25, helix_angle=helix, **tooth),
            gb.Gear("wheel", "output", 0.15, teeth=50, helix_angle=-helix, **tooth),
        ],
        meshes=[
            gb.Mesh("pinion", "wheel", stiffness=gb.Stiffness.parabolic(3e8), damping_ratio=0.05)
        ],
        bearings=[
            gb.Bearing(
                shaft, x, stiffness=1e8, damping=500.0, axial_stiffness=5e7 if x == 0.0 else 0.0
            )
            for shaft, x in places
        ],
        torques=[gb.Torque("pinion", 200.0), gb.Torque.balance("wheel")],
    )


angles = np.arange(0.0, 31.0, 5.0)
thrusts, variations = [], []
for angle in np.radians(angles):
    system = pair(angle)
    thrusts.append(system.static().axial_bearing_force(("input", 0.0)))
    response = system.simulate(0.02, 100.0, output_step=2e-5, record=["meshes"])
    variations.append(np.ptp(response.mesh(("pinion", "wheel")).force[500:]))

figure = Figure(figsize=(6.4, 4.0), layout="constrained")
panel = figure.subplots()
panel.plot(angles, np.abs(thrusts), "o-", label="thrust")
panel.plot(angles, variations, "s--", label="mesh force, peak-to-peak")
panel.set(xlabel="helix angle [°]", ylabel="force [N]")
panel.legend()
