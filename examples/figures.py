"""Draw the figures of the section on figures in docs/using.md: spectrum, orders, animation.

Run with ``python examples/figures.py``. The script writes the figures to ``docs/figures``.
"""

import math
from pathlib import Path

import gearbow as gb

FIGURES = Path(__file__).parent.parent / "docs" / "figures"

SPEED = 100.0  # of the input shaft, rad/s
BOW = 2e-4  # of the input and the middle shaft, m
TURN = 2.0 * math.pi / (0.25 * SPEED)  # of the output shaft, s
MESH = ("g1", "g2")


def train(amplitude: float = BOW) -> gb.RotorSystem:
    """Return a double-stage train with tooth pairs on the path of contact and two bent shafts."""
    teeth = gb.Stiffness.parabolic(2e8, engagement=0.2)
    bow = gb.Bow.half_sine(amplitude)
    names = ("input", "middle", "output")
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(name, length=0.5, outer_diameter=0.05, bow=bow if name != "output" else None)
            for name in names
        ],
        gears=[
            gb.Gear(name, shaft, position, z, module=3e-3, face_width=0.03)
            for name, shaft, position, z in (
                ("g1", "input", 0.25, 25),
                ("g2", "middle", 0.125, 50),
                ("g3", "middle", 0.375, 25),
                ("g4", "output", 0.25, 50),
            )
        ],
        meshes=[
            gb.Mesh(*pair, stiffness=teeth, damping_ratio=0.05) for pair in (MESH, ("g3", "g4"))
        ],
        bearings=[
            gb.Bearing(name, x, stiffness=1e8, damping=2e3) for name in names for x in (0.0, 0.5)
        ],
        torques=[gb.Torque("g1", 250.0), gb.Torque.balance("g4")],
        modal_damping=0.01,
    )


def main() -> None:
    """Draw and save all figures."""
    record = ["gears", "meshes"]
    response = train().simulate(4.0 * TURN, SPEED, output_step=TURN / 2500, record=record)
    response.spectrum(MESH).plot().savefig(FIGURES / "spectrum.png", dpi=80)
    found = response.orders(MESH, skip_time=TURN, sidebands=3)
    found.plot(10).savefig(FIGURES / "orders.png", dpi=80)
    response.animate(FIGURES / "train.gif", duration=5.0, fps=10.0)


if __name__ == "__main__":
    main()
