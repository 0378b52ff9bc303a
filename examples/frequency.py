"""Draw the figures of docs/frequency.md: a geared pair and a bowed rotor over the speed range.

Run with ``python examples/frequency.py``. The script writes the figures to ``docs/figures``.
"""

from pathlib import Path

import numpy as np

import gearbow as gb

FIGURES = Path(__file__).parent.parent / "docs" / "figures"


def train() -> gb.RotorSystem:
    """Return a geared pair whose output shaft carries an overhung flywheel."""
    return gb.RotorSystem(
        disks=[gb.Disk("flywheel", "output", 0.7, 15.0, 0.15, 0.3)],
        shafts=[
            gb.Shaft("input", length=0.5, outer_diameter=0.04, bow=gb.Bow.half_sine(1e-4)),
            gb.Shaft("output", length=0.7, outer_diameter=0.05),
        ],
        gears=[
            gb.Gear("pinion", "input", 0.2, teeth=25, module=3e-3, face_width=0.03),
            gb.Gear("wheel", "output", 0.2, teeth=50, module=3e-3, face_width=0.03),
        ],
        meshes=[gb.Mesh("pinion", "wheel", stiffness=2e8, damping_ratio=0.05)],
        bearings=[
            gb.Bearing(name, x, stiffness=1e8, damping=2e3)
            for name in ("input", "output")
            for x in (0.0, 0.5)
        ],
    )


def rotor() -> gb.RotorSystem:
    """Return a bowed rotor with two disks."""
    return gb.RotorSystem(
        shafts=[gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=gb.Bow.half_sine(1e-4))],
        disks=[
            gb.Disk("left", "rotor", 0.3, 20.0, 0.1, 0.2, unbalance=1e-3j),
            gb.Disk("right", "rotor", 0.7, 30.0, 0.2, 0.4),
        ],
        bearings=[gb.Bearing("rotor", x, stiffness=2e7, damping=1e5) for x in (0.0, 1.0)],
    )


def sealed() -> gb.RotorSystem:
    """Return the rotor on seals whose cross-coupled stiffness grows with the speed."""
    cross = [0.0, 1.4e6, 2.8e6, 4.2e6]  # N/m
    seal = gb.SpeedTable([0.0, 200.0, 400.0, 600.0], [[[2e7, k], [-k, 2.5e7]] for k in cross])
    return rotor().replace(
        bearings=[gb.Bearing("rotor", x, stiffness=seal, damping=5e3) for x in (0.0, 1.0)]
    )


def main() -> None:
    """Draw and save all figures."""
    bowed = rotor()
    pair = train()
    response = bowed.synchronous(np.linspace(5.0, 600.0, 400))
    figures = {
        "campbell": pair.campbell(np.linspace(0.0, 2500.0, 41), count=8).plot(
            operating=(250.0, 350.0)
        ),
        "stability": sealed().campbell(np.linspace(0.0, 600.0, 13), count=4).plot(),
        "critical_speed_map": bowed.critical_speed_map(np.geomspace(1e5, 1e10, 41)).plot(3),
        "bode": response.bode(["left", "right"]),
        "frf": pair.frequency_response(
            2.0 * np.pi * np.linspace(1.0, 1000.0, 1000),
            source=gb.Force(("input", 0.35), 1.0),
            speed=150.0,
        ).plot(["pinion", ("output", 0.65)]),
        "sensitivity": pair.sensitivity(
            [
                "shafts['output'].outer_diameter",
                "shafts['input'].outer_diameter",
                "bearings[3].stiffness",
                "disks['flywheel'].mass",
            ],
            pair.campbell(np.linspace(0.0, 1000.0, 5), count=2, harmonics=0),
        ).plot(count=2),
        "mode_shape": pair.modes(speed=300.0).plot(2),
    }
    for name, figure in figures.items():
        figure.savefig(FIGURES / f"{name}.png", dpi=80)


if __name__ == "__main__":
    main()
