"""Draw the figure of docs/housing.md: the acceleration of an elastic housing, with and without bow.

Run with ``python examples/housing.py``. The script writes the figure to ``docs/figures``.
"""

from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import gearbow as gb

FIGURES = Path(__file__).parent.parent / "docs" / "figures"
SPEED = 150.0  # rad/s
BOW = 5e-5  # of the input shaft, m
LENGTH, DISTANCE = 0.4, 0.1125  # between the walls, between the axes, m
Array = NDArray[np.float64]
Point = tuple[float, float, float]


def beam(begin: Point, end: Point, side: float = 0.025) -> tuple[Array, Array]:
    """Give mass and stiffness of a square bar of cast iron: (x, y, z, rotations) of both ends."""
    e, g, density = 1.1e11, 4.4e10, 7200.0
    area, moment = side**2, side**4 / 12.0
    axis = np.subtract(end, begin)
    s = float(np.linalg.norm(axis))
    k = np.zeros((12, 12))
    for i, rigidity in ((0, e * area), (3, g * 1.7 * moment)):
        k[np.ix_([i, i + 6], [i, i + 6])] = rigidity / s * np.array([[1, -1], [-1, 1]])
    bend = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    for places, sign in (((1, 5, 7, 11), 1.0), ((2, 4, 8, 10), -1.0)):
        lever = np.diag([1.0, sign * s, 1.0, sign * s])
        k[np.ix_(places, places)] += e * moment / s**3 * lever @ bend @ lever
    half = density * area * s / 2.0
    m = half * np.diag(2 * [1.0, 1.0, 1.0, side**2 / 6.0, side**2 / 12.0, side**2 / 12.0])
    x = axis / s
    y = np.cross([0.0, 0.0, 1.0] if abs(x[2]) < 0.9 else [0.0, 1.0, 0.0], x)
    turned = np.kron(np.eye(4), np.array([x, y, np.cross(x, y)]))
    return turned.T @ m @ turned, turned.T @ k @ turned


def box() -> tuple[Array, Array, list[Point]]:
    """Give mass, stiffness and nodes of a box: two walls with bearing seats, and bars along x."""
    xs, ys, zs = (0.0, LENGTH / 2.0, LENGTH), (-0.1, 0.0, DISTANCE, 0.22), (-0.12, 0.0, 0.12)
    inside = {(LENGTH / 2.0, y, 0.0) for y in ys[1:3]}  # where the shafts and gears are
    nodes = [(x, y, z) for x in xs for y in ys for z in zs if (x, y, z) not in inside]
    bars = [((x, a, z), (x, b, z)) for x in xs for a, b in pairwise(ys) for z in zs]
    bars += [((x, y, a), (x, y, b)) for x in xs for y in ys for a, b in pairwise(zs)]
    bars += [((a, y, z), (b, y, z)) for a, b in pairwise(xs) for y in ys for z in zs]
    mass, stiffness = np.zeros((2, 6 * len(nodes), 6 * len(nodes)))
    for ends in bars:
        if inside.isdisjoint(ends):
            index = [6 * nodes.index(end) + i for end in ends for i in range(6)]
            own_mass, own_stiffness = beam(*ends)
            mass[np.ix_(index, index)] += own_mass
            stiffness[np.ix_(index, index)] += own_stiffness
    return mass, stiffness, nodes


def housing() -> gb.Housing:
    """Reduce the box to its modes: four bearing seats, four feet and a sensor."""
    mass, stiffness, nodes = box()

    def interface(at: Point, **springs: tuple[float, float, float]) -> gb.Interface:
        first = 6 * nodes.index(at)
        return gb.Interface(at, rows=list(range(first, first + 6)), **springs)

    feet = {"stiffness": (1e8, 1e8, 3e8), "damping": (5e3, 5e3, 5e3)}
    interfaces = {"sensor": interface((LENGTH / 2.0, 0.0, 0.12))}
    for end, x in (("left", 0.0), ("right", LENGTH)):
        for shaft, y in (("input", 0.0), ("output", DISTANCE)):
            interfaces[f"{shaft} {end}"] = interface((x, y, 0.0))
        for side, y in (("front", -0.1), ("back", 0.22)):
            interfaces[f"foot {side} {end}"] = interface((x, y, -0.12), **feet)
    return gb.Housing.from_matrices(
        "housing",
        mass=mass,
        stiffness=stiffness,
        interfaces=interfaces,
        highest_frequency=2500.0,
        damping_ratio=0.01,
    )


def train(bow: float) -> gb.RotorSystem:
    """Return a geared pair in the box."""
    bent = gb.Bow.half_sine(bow) if bow else None
    ends = (("left", 0.0), ("right", LENGTH))
    return gb.RotorSystem(
        shafts=[
            gb.Shaft("input", length=LENGTH, outer_diameter=0.045, elements=4, bow=bent),
            gb.Shaft("output", length=LENGTH, outer_diameter=0.05, elements=4),
        ],
        gears=[
            gb.Gear("pinion", "input", 0.2, teeth=25, module=3e-3, face_width=0.03),
            gb.Gear("wheel", "output", 0.2, teeth=50, module=3e-3, face_width=0.03),
        ],
        meshes=[
            gb.Mesh("pinion", "wheel", stiffness=gb.Stiffness.parabolic(3e8), damping_ratio=0.1)
        ],
        bearings=[
            gb.Bearing(shaft, x, stiffness=1e8, damping=2e3, support=("housing", f"{shaft} {end}"))
            for shaft in ("input", "output")
            for end, x in ends
        ],
        housings=[housing()],
        torques=[gb.Torque("pinion", 200.0), gb.Torque.balance("wheel")],
        rayleigh=(30.0, 2e-6),
    )


def draw() -> Figure:
    """Simulate both trains, and draw the orders of the acceleration at the sensor."""
    figure, panel = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
    for bow, width in ((BOW, 5.0), (0.0, 2.0)):
        run = train(bow).simulate(1.0, SPEED, output_step=1e-4, record=["sensor", "acceleration"])
        options = {"sidebands": 2, "mesh_harmonics": 4, "shaft_harmonics": 2}
        found = run.orders("sensor", "acceleration_z", skip_time=0.5, **options)
        orders = np.array([each.value for each in found.orders])
        sizes = np.abs(found.amplitudes)
        # Round-off of the fit, and what is left of the transient, is no order.
        kept = sizes > 1e-3
        label = f"bow {1e6 * bow:.0f} µm" if bow else "straight"
        colour = "C1" if bow else "C0"
        panel.vlines(orders[kept], 1e-3, sizes[kept], colour, linewidth=width, label=label)
    panel.set(yscale="log", ylim=(1e-3, None), xlabel="order of the input shaft")
    panel.set(ylabel="acceleration z at the sensor [m/s²]")
    panel.legend()
    return figure


def main() -> None:
    """Draw and write the figure."""
    draw().savefig(FIGURES / "housing.png", dpi=120)


if __name__ == "__main__":
    main()
