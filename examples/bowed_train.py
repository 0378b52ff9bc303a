"""Effect of shaft bow on a double-stage train: displacement, contact ratio, pressure angle.

The train has three steel shafts on six equal bearings, two meshes and an input torque of 250 N m.
All shafts have a half-sine bow in the same plane. Its amplitude ranges from zero to 0.05 of the
shaft radius.
Run with ``python examples/bowed_train.py``.
"""

import argparse
import math
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import gearbow as gb
from gearbow import plotting

RADIUS = 0.025  # m
LENGTH = 0.5  # m
BOWS = (0.0, 0.01, 0.03, 0.05)  # divided by the shaft radius
SPEED = 100.0  # of the input shaft, rad/s
TURNS = 3  # revolutions of the output shaft; the first one is the transient
GEARS = ("g1", "g2", "g3", "g4")
MESHES = (("g1", "g2"), ("g3", "g4"))


def train(bow: float) -> gb.RotorSystem:
    """Return the train; `bow` is the deflection at mid-length [m]."""
    shafts = [
        gb.Shaft(
            name,
            length=LENGTH,
            outer_diameter=2.0 * RADIUS,
            bow=gb.Bow.half_sine(bow) if bow else None,
        )
        for name in ("input", "middle", "output")
    ]
    gears = [
        gb.Gear(name, shaft=shaft, position=position, teeth=teeth, module=3e-3, face_width=0.03)
        for name, shaft, position, teeth in (
            ("g1", "input", LENGTH / 2, 25),
            ("g2", "middle", LENGTH / 4, 50),
            ("g3", "middle", 3 * LENGTH / 4, 25),
            ("g4", "output", LENGTH / 2, 50),
        )
    ]
    return gb.RotorSystem(
        shafts=shafts,
        gears=gears,
        meshes=[gb.Mesh(*pair, stiffness=2e8, damping_ratio=0.05) for pair in MESHES],
        bearings=[
            gb.Bearing(shaft.name, position=x, stiffness=1e8, damping=500.0)
            for shaft in shafts
            for x in (0.0, LENGTH)
        ],
        torques=[gb.Torque("g1", 250.0), gb.Torque.balance("g4")],
    )


def simulate(system: gb.RotorSystem) -> gb.Response:
    """Simulate a few revolutions of the slowest shaft."""
    turn = 2.0 * math.pi / (SPEED * float(np.abs(system.speed_ratios).min()))
    return system.simulate(TURNS * turn, SPEED, output_step=turn / 1000)


def settled(response: gb.Response) -> slice:
    """Return the samples after the transient: the first revolution of the slowest shaft."""
    return slice(response.time.size // TURNS, None)


def displacement_table(responses: dict[float, gb.Response]) -> str:
    """Return a table of the peak-to-peak displacement of each gear.

    Each entry is the larger value of v and w; the ratio to the bow stands in parentheses.
    """
    lines = ["peak-to-peak displacement of the gears [µm] (ratio to the bow)"]
    lines.append(f"{'bow [µm]':>10}" + "".join(f"{gear:>18}" for gear in GEARS))
    for ratio, response in responses.items():
        bow = ratio * RADIUS
        line = f"{1e6 * bow:>10.0f}"
        for gear in GEARS:
            span = float(np.ptp(response.displacement(gear)[settled(response)], axis=0).max())
            line += f"{1e6 * span:>11.2f}" + (f" ({span / bow:4.2f})" if bow else " " * 7)
        lines.append(line)
    return "\n".join(lines)


def mesh_table(responses: dict[float, gb.Response]) -> str:
    """Return a table of the contact ratio and pressure angle of each mesh."""
    lines = ["contact ratio and pressure angle of the meshes"]
    lines.append(
        f"{'bow [µm]':>10}  {'mesh':<7}  {'contact ratio: min':>18} {'mean':>8} {'max':>8}"
        f"  {'pressure angle [°]: min':>23} {'max':>8}"
    )
    for ratio, response in responses.items():
        for pair in MESHES:
            mesh = response.mesh(pair)
            contact = mesh.contact_ratio[settled(response)]
            angle = np.degrees(mesh.pressure_angle[settled(response)])
            lines.append(
                f"{1e6 * ratio * RADIUS:>10.0f}  {'–'.join(pair):<7}"
                f"  {contact.min():>18.4f} {contact.mean():>8.4f} {contact.max():>8.4f}"
                f"  {angle.min():>23.3f} {angle.max():>8.3f}"
            )
    return "\n".join(lines)


def figure(responses: dict[float, gb.Response]) -> Figure:
    """Draw orbits, contact ratio and pressure angle for each bow."""
    with mpl.rc_context(plotting.STYLE):
        drawing = Figure(figsize=(15.0, 11.5))
        grid = drawing.add_gridspec(3, 4, height_ratios=[1.25, 1.0, 1.0])
        halves = (slice(0, 2), slice(2, 4))
        orbits = [drawing.add_subplot(grid[0, column]) for column in range(4)]
        contacts = [drawing.add_subplot(grid[1, half]) for half in halves]
        angles = [drawing.add_subplot(grid[2, half]) for half in halves]
        # Draw the largest bow first: the smaller orbits remain visible on top.
        for ratio, response in reversed(responses.items()):
            colour = plotting.PALETTE[BOWS.index(ratio)]
            for panel, gear in zip(orbits, GEARS, strict=True):
                v, w = 1e6 * response.displacement(gear)[settled(response)].T
                panel.plot(v, w, color=colour, label=f"{ratio:g}")
                panel.set(title=gear, xlabel="y [µm]", ylabel="z [µm]")
            for contact, angle, pair in zip(contacts, angles, MESHES, strict=True):
                mesh = response.mesh(pair)
                contact.plot(response.time, mesh.contact_ratio, color=colour)
                contact.set(title="–".join(pair), ylabel="contact ratio", xlabel="time [s]")
                angle.plot(response.time, np.degrees(mesh.pressure_angle), color=colour)
                angle.set(title="–".join(pair), ylabel="pressure angle [°]", xlabel="time [s]")
        plotting.equal_ranges(orbits)
        handles, labels = orbits[0].get_legend_handles_labels()
        drawing.legend(
            handles[::-1],
            labels[::-1],
            loc="outside upper center",
            ncols=len(labels),
            title="bow / shaft radius",
        )
    return drawing


def main() -> None:
    """Print the tables and save the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    default = Path(__file__).parent / "output" / "bowed_train.png"
    parser.add_argument("--output", type=Path, default=default, help="file of the figure")
    output: Path = parser.parse_args().output

    print("natural frequencies at rest")
    print(train(0.0).modes(count=12).table(), end="\n\n")
    responses = {ratio: simulate(train(ratio * RADIUS)) for ratio in BOWS}
    print(displacement_table(responses), end="\n\n")
    print(mesh_table(responses), end="\n\n")
    output.parent.mkdir(parents=True, exist_ok=True)
    figure(responses).savefig(output)
    print(f"figure: {output}")


if __name__ == "__main__":
    main()
