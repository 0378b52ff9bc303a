"""Three published rotors as input of the independent assembly; each states its sources."""

from __future__ import annotations

import numpy as np

from reference.closed_forms import solid_disk
from reference.elements import Section
from reference.mesh_law import MeshLaw
from reference.train import BearingSpec, MeshSpec, RigidSpec, ShaftPart, ShaftSpec, Train

# Geared two-rotor system: Rao, Shiau and Chang 1998; frequencies printed by Friswell, Penny, Garvey
# and Lees 2010. One element per listed length: the published values belong to this discretization.
V1_DENSITY, V1_E, V1_G = 7800.0, 207e9, 79.5e9
V1_LENGTHS = ((0.1, 4.24, 1.16, 0.3), (0.3, 5.0, 0.1))
V1_DIAMETERS = ((0.3, 0.3, 0.22, 0.22), (0.15, 0.15, 0.15))
# name, shaft, node, mass, diametral, polar; nodes count from 0
V1_DISKS = (
    ("d1", 0, 1, 525.7, 16.1, 32.2),
    ("d2", 0, 2, 116.04, 3.115, 6.23),
    ("d3", 1, 2, 7.45, 0.0745, 0.149),
)
V1_GEARS = (  # also base radius, teeth
    ("wheel", 0, 4, 726.4, 56.95, 113.9, 0.5086, 328),
    ("pinion", 1, 0, 5.0, 0.002, 0.004, 0.03567, 23),
)
V1_BEARINGS = (
    (0, 0, 183.9e6, 200.4e6),
    (0, 3, 183.9e6, 200.4e6),
    (1, 1, 10.1e6, 41.6e6),
    (1, 3, 10.1e6, 41.6e6),
)
V1_BEARING_DAMPING = 3e3
V1_MESH_STIFFNESS = 1e8
V1_PRESSURE_ANGLE = np.radians(22.5)
V1_SPEED = 1500 * 2 * np.pi / 60
V1_HZ = np.array(
    [
        11.641,
        12.284,
        17.268,
        18.458,
        23.956,
        37.681,
        49.889,
        50.861,
        56.248,
        57.752,
        59.188,
        63.113,
        74.203,
    ]
)

# Nelson and McVaugh 1976: stations, outer diameters and bores in cm
V2_STATIONS = (
    *(0, 1.27, 5.08, 7.62, 8.89, 10.16, 10.67, 11.43, 12.70, 13.46),
    *(16.51, 19.05, 22.86, 26.67, 28.70, 30.48, 31.50, 34.54, 35.50),
)
V2_OUTER = (
    *(1.02, 2.04, 1.52, 4.06, 4.06, 6.60, 6.60, 5.08, 5.08),
    *(2.54, 2.54, 3.04, 3.04, 2.54, 2.54, 7.62, 4.06, 4.06),
)
V2_BORES = {7: 3.04, 8: 3.56, 18: 3.04}  # by element, counted from 1
V2_E, V2_DENSITY, V2_POISSON = (
    2.078e11,
    7806.0,
    0.3,
)  # without shear, Poisson's ratio does not affect bending
V2_DISK = (0.0889, 1.401, 0.00136, 0.0020)  # position, mass, diametral, polar
V2_BEARING_STATIONS = (11, 15)
V2_BEARING_STIFFNESS = 4.378e7
V2_CRITICALS_RPM = (
    (15470, "backward"),
    (17159, "forward"),
    (46612, "backward"),
    (49983, "forward"),
    (64752, "backward"),
    (96457, "forward"),
)

# Friswell, Penny, Garvey and Lees 2010, example 5.9.1
V3_LENGTH, V3_DIAMETER, V3_ELEMENTS = 1.5, 0.05, 6
V3_E, V3_G, V3_DENSITY = 211e9, 81.2e9, 7810.0
V3_BEARING = 1e6
V3_DISKS = tuple(
    (name, x, *solid_disk(diameter / 2, 0.07, V3_DENSITY, 0.025))
    for name, x, diameter in (("small", 0.5, 0.28), ("large", 1.0, 0.35))
)
V3_AT_REST = np.array([86.66, 86.66, 274.31, 274.31, 716.78])
V3_TORSION = 650.41
V3_AT_4000_RPM = np.array([85.39, 87.80, 251.78, 294.71, 600.18])


def v1() -> Train:
    names = ("rotor1", "rotor2")
    nodes = [np.concatenate([[0.0], np.cumsum(lengths)]) for lengths in V1_LENGTHS]
    shafts = [
        ShaftSpec(
            name,
            [
                ShaftPart(length, Section(diameter, V1_E, V1_G, V1_DENSITY))
                for length, diameter in zip(lengths, diameters, strict=True)
            ],
            ratio,
        )
        for name, lengths, diameters, ratio in zip(
            names, V1_LENGTHS, V1_DIAMETERS, (1.0, -328 / 23), strict=True
        )
    ]
    rigid = [
        RigidSpec(d[0], names[d[1]], float(nodes[d[1]][d[2]]), *d[3:6])
        for d in (*V1_DISKS, *V1_GEARS)
    ]
    bearings = [
        BearingSpec(
            names[s], float(nodes[s][i]), np.diag([kyy, kzz]), V1_BEARING_DAMPING * np.eye(2)
        )
        for s, i, kyy, kzz in V1_BEARINGS
    ]
    r_a, r_b = V1_GEARS[0][6], V1_GEARS[1][6]
    law = MeshLaw(r_a, r_b, (r_a + r_b) / np.cos(V1_PRESSURE_ANGLE), 0.0, V1_MESH_STIFFNESS)
    return Train(shafts, rigid, bearings, [MeshSpec("wheel", "pinion", law)])


def v2() -> Train:
    shear_modulus = V2_E / (2 * (1 + V2_POISSON))
    parts = []
    for i, outer in enumerate(V2_OUTER):
        bore = V2_BORES.get(i + 1, 0.0) / 100
        section = Section(outer / 100, V2_E, shear_modulus, V2_DENSITY, bore, shear=False)
        parts.append(ShaftPart((V2_STATIONS[i + 1] - V2_STATIONS[i]) / 100, section))
    position, mass, diametral, polar = V2_DISK
    bearings = [
        BearingSpec(
            "shaft", V2_STATIONS[s - 1] / 100, V2_BEARING_STIFFNESS * np.eye(2), np.zeros((2, 2))
        )
        for s in V2_BEARING_STATIONS
    ]
    return Train(
        [ShaftSpec("shaft", parts)],
        [RigidSpec("disk", "shaft", position, mass, diametral, polar)],
        bearings,
    )


def v3() -> Train:
    part = ShaftPart(V3_LENGTH, Section(V3_DIAMETER, V3_E, V3_G, V3_DENSITY), V3_ELEMENTS)
    rigid = [RigidSpec(name, "shaft", x, m, d, p) for name, x, m, d, p in V3_DISKS]
    bearings = [
        BearingSpec("shaft", x, V3_BEARING * np.eye(2), np.zeros((2, 2))) for x in (0.0, V3_LENGTH)
    ]
    return Train([ShaftSpec("shaft", [part])], rigid, bearings)
