"""
Three-shaft train and its modes
===============================

Two stages of spur gears couple three shafts. Meshes couple bending and torsion, so that a mode of
the train moves several shafts. The table names the direction of whirl and the largest motion. A
mode can be drawn in three dimensions.

The figure shows the shape of mode 4; thin lines show the train at rest.
"""

import numpy as np

import gearbow as gb

tooth = {"module": 3e-3, "face_width": 0.03}
names = ("input", "middle", "output")
train = gb.RotorSystem(
    shafts=[gb.Shaft(name, length=0.5, outer_diameter=0.05) for name in names],
    gears=[
        gb.Gear("g1", "input", 0.25, teeth=25, **tooth),
        gb.Gear("g2", "middle", 0.125, teeth=50, **tooth),
        gb.Gear("g3", "middle", 0.375, teeth=25, **tooth),
        gb.Gear("g4", "output", 0.25, teeth=50, **tooth),
    ],
    meshes=[
        gb.Mesh("g1", "g2", stiffness=2e8, damping_ratio=0.05),
        gb.Mesh("g3", "g4", stiffness=2e8, damping_ratio=0.05, centre_line_angle=np.pi / 3),
    ],
    bearings=[
        gb.Bearing(name, x, stiffness=1e8, damping=500.0) for name in names for x in (0.0, 0.5)
    ],
)
modes = train.modes(speed=100.0)
print(modes.table(count=6))

figure = modes.plot(4)
