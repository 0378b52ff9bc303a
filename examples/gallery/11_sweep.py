"""
Sweep over speed and bow: a table and a map
===========================================

`sweep` computes a measure of many systems in parallel. It needs two functions: one makes the system
of a point, the other measures it. The result is an array, or a data frame with one row for each
point.

The figure shows the amplitude of the mesh force over speed and bow. Red crosses mark the points
at which the teeth lose contact; the mesh has backlash, so that its teeth separate and do not pull.
The first turn is the transient.
"""

import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

elements = {"elements": 4, "degree": 3}
tooth = {"module": 3e-3, "face_width": 0.03}


def make(speed, bow):
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "input", length=0.5, outer_diameter=0.04, bow=gb.Bow.half_sine(bow), **elements
            ),
            gb.Shaft("output", length=0.5, outer_diameter=0.05, **elements),
        ],
        gears=[
            gb.Gear("pinion", "input", 0.2, teeth=25, **tooth),
            gb.Gear("wheel", "output", 0.2, teeth=50, **tooth),
        ],
        meshes=[gb.Mesh("pinion", "wheel", stiffness=2e8, damping_ratio=0.05, backlash=2e-4)],
        bearings=[
            gb.Bearing(shaft, x, stiffness=1e8, damping=2e3)
            for shaft in ("input", "output")
            for x in (0.0, 0.5)
        ],
        torques=[gb.Torque("pinion", 250.0), gb.Torque.balance("wheel")],
    )


def measure(system, speed, bow):
    turn = 4 * np.pi / speed  # of the output shaft, s
    times = np.linspace(turn, 2 * turn, 200)
    run = system.simulate(2 * turn, speed, times=times, record=["meshes"], accuracy="draft")
    force = run.mesh(("pinion", "wheel")).force
    lost = run.contact_shares(("pinion", "wheel")).lost  # share of the time
    return {"mean": force.mean(), "amplitude": np.ptp(force) / 2, "lost": lost}


grid = {"speed": np.linspace(200.0, 1600.0, 8), "bow": np.linspace(2.5e-5, 1e-4, 4)}
sweep = gb.sweep(make, grid, measure)
table = sweep.to_dataframe()
print(table.sort_values("amplitude").tail(3).to_string(index=False, float_format="{:.3g}".format))

figure = Figure(figsize=(6.4, 4.0), layout="constrained")
panel = figure.subplots()
colours = panel.pcolormesh(
    grid["speed"], 1e6 * grid["bow"], sweep.values("amplitude").T, norm="log"
)
row, column = np.nonzero(sweep.values("lost"))
panel.plot(grid["speed"][row], 1e6 * grid["bow"][column], "rx")
figure.colorbar(colours, label="amplitude of the mesh force [N]")
panel.set(xlabel="speed of the input shaft [rad/s]", ylabel="bow [µm]")
