"""
Campbell diagram with speed-dependent bearings
==============================================

A data sheet gives the stiffness and damping of the bearings of a turbine rotor at four speeds.
`SpeedTable` interpolates them, and every analysis uses the coefficients at its speed.
`SpeedTable.read_table` reads such a table from a file, with cross-coupled coefficients too. The
stiffness rises with the speed and lifts the frequencies. The table lists the critical speeds.

The figure shows the frequencies and damping ratios of the modes against the speed. The line
"1× rotor" crosses the frequencies at the critical speeds.
"""

import numpy as np

import gearbow as gb

table_speeds = [0.0, 200.0, 400.0, 800.0]  # of the shaft, rad/s
stiffness = gb.SpeedTable(table_speeds, [(1e7, 2e7), (2e7, 3e7), (4e7, 5e7), (8e7, 9e7)])
damping = gb.SpeedTable(table_speeds, [4e3, 3e3, 2e3, 1e3])
turbine = gb.RotorSystem(
    shafts=[gb.Shaft("rotor", length=1.2, outer_diameter=0.08)],
    disks=[
        gb.Disk("compressor", "rotor", 0.3, 30.0, diametral_inertia=0.2, polar_inertia=0.4),
        gb.Disk("turbine", "rotor", 1.2, 20.0, diametral_inertia=0.15, polar_inertia=0.3),
    ],
    bearings=[gb.Bearing("rotor", x, stiffness=stiffness, damping=damping) for x in (0.0, 1.0)],
)
campbell = turbine.campbell(np.linspace(0.0, 800.0, 17), count=6)
print(campbell)

figure = campbell.plot()
