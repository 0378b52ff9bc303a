"""
Efficiency over the speed
=========================

The sliding friction of the teeth takes about one per cent of the power of each stage. With the
coefficient of ISO/TR 14179-2 for lubricated steel, it falls as the speed rises and the oil carries
more.

The figure shows the losses of both stages of the gearbox among the machines of the package. The
tables of a run (`friction_force`, `friction_power`) contain the same friction over time.
"""

from dataclasses import replace

import numpy as np

import gearbow as gb

gearbox = gb.RotorSystem.load(gb.examples()["coaxial_reducer"].path)
oil = gb.MeshFriction(viscosity=0.03, roughness=0.6e-6)
lossy = gearbox.replace(meshes=[replace(mesh, friction=oil) for mesh in gearbox.meshes])
found = lossy.efficiency(gb.rpm(np.linspace(200.0, 3000.0, 15)))
print(repr(found))
figure = found.plot()
