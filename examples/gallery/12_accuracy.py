"""
Accuracy against cost
=====================

The error of a run falls with the number of evaluations of the right-hand side. The exponential
methods integrate the linear part exactly, so that short elements with high frequencies do not limit
their steps; the explicit Runge–Kutta method "rk45" has to resolve them at every tolerance.
`RotorSystem.tradeoff` measures error and computing time for your own system, and recommends a
setting.

The figure shows the error of the mesh force against the number of evaluations in 0.02 s.
"""

import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

tooth = {"module": 3e-3, "face_width": 0.03}
system = gb.RotorSystem(
    shafts=[
        gb.Shaft(name, length=0.5, outer_diameter=0.05, elements=4, bow=gb.Bow.half_sine(2e-4))
        for name in ("input", "output")
    ],
    gears=[
        gb.Gear("pinion", "input", 0.25, teeth=25, **tooth),
        gb.Gear("wheel", "output", 0.25, teeth=50, **tooth),
    ],
    meshes=[gb.Mesh("pinion", "wheel", stiffness=gb.Stiffness.parabolic(2e8), damping_ratio=0.05)],
    bearings=[
        gb.Bearing(shaft, x, stiffness=1e8, damping=500.0)
        for shaft in ("input", "output")
        for x in (0.0, 0.5)
    ],
    torques=[gb.Torque("pinion", 250.0), gb.Torque.balance("wheel")],
)


def run(**options):
    response = system.simulate(0.02, 300.0, output_step=1e-4, record=["meshes"], **options)
    return response.mesh(("pinion", "wheel")).force, response.statistics.evaluations


SETTINGS = {
    "exponential": [{"rtol": rtol} for rtol in (1e-2, 1e-4, 1e-6, 1e-8)],
    "etdrk4": [{"step": step} for step in (2e-4, 1e-4, 5e-5, 2e-5)],
    "rk45": [{"rtol": rtol} for rtol in (1e-2, 1e-4, 1e-6, 1e-8)],
}
exact, _ = run(method="exponential", rtol=1e-11)
figure = Figure(figsize=(6.4, 4.0), layout="constrained")
panel = figure.subplots()
for (method, settings), style in zip(SETTINGS.items(), ("o-", "^-.", "s--")):
    found = [run(method=method, **options) for options in settings]
    errors = [np.std(force - exact) / np.std(exact) for force, _ in found]
    counts = [count for _, count in found]
    print(f"{method}: {counts[0]} to {counts[-1]} evaluations")
    panel.loglog(counts, errors, style, label=method)

panel.set(xlabel="evaluations of the right-hand side", ylabel="RMS error of the mesh force")
panel.legend()
