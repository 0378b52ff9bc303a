"""Draw the figure of docs/gear_noise.md: the mesh force of a straight and of a bent train.

Run with ``python examples/gear_noise.py``. The script writes the figure to ``docs/figures``.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

import gearbow as gb

FIGURES = Path(__file__).parent.parent / "docs" / "figures"
SPEED = 600.0  # rad/s
BOWS = (0.0, 1e-4)  # of the input shaft, m


def train(bow: float, stiffness: gb.Stiffness) -> gb.RotorSystem:
    """Return a geared pair on a housing."""
    bent = gb.Bow.half_sine(bow) if bow else None
    return gb.RotorSystem(
        shafts=[
            gb.Shaft("input", length=0.4, outer_diameter=0.045, elements=4, bow=bent),
            gb.Shaft("output", length=0.4, outer_diameter=0.05, elements=4),
        ],
        gears=[
            gb.Gear("pinion", "input", 0.2, teeth=25, module=3e-3, face_width=0.03),
            gb.Gear("wheel", "output", 0.2, teeth=50, module=3e-3, face_width=0.03),
        ],
        meshes=[gb.Mesh("pinion", "wheel", stiffness=stiffness, damping_ratio=0.1)],
        bearings=[
            *(gb.Bearing("input", x, stiffness=1e8, damping=2e3) for x in (0.0, 0.4)),
            *(
                gb.Bearing("output", x, stiffness=1e8, damping=2e3, support="housing")
                for x in (0.0, 0.4)
            ),
        ],
        supports=[gb.Support("housing", mass=60.0, stiffness=3e8, damping=2e4)],
        torques=[gb.Torque("pinion", 200.0), gb.Torque.balance("wheel")],
        rayleigh=(30.0, 2e-6),
    )


def draw() -> Figure:
    """Simulate both trains, and draw their orders beside the response to a transmission error."""
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(8.0, 7.0), layout="constrained")
    for bow, width in zip(BOWS, (5.0, 2.0), strict=True):
        system = train(bow, gb.Stiffness.parabolic(3e8))
        run = system.simulate(0.2, SPEED, output_step=1e-5, record=["meshes"])
        options = {"sidebands": 2, "mesh_harmonics": 4, "shaft_harmonics": 2}
        found = run.orders(("pinion", "wheel"), "force", skip_time=0.1, **options)
        orders = np.array([each.value for each in found.orders])
        # Round-off of the fit is no order.
        kept = (np.abs(found.amplitudes) > 1.0) & (orders < 30.0)
        label = "straight" if bow == 0.0 else f"bow {1e6 * bow:.0f} µm"
        top.vlines(
            orders[kept],
            0.5,
            np.abs(found.amplitudes)[kept],
            lw=width,
            label=label,
            color="0.6" if bow == 0.0 else "C1",
        )
    top.set(xlabel="order of the input shaft", ylabel="mesh force [N]", yscale="log", xlim=(0, 30))
    top.legend(loc="upper center")
    speeds = np.linspace(20.0, 1500.0, 741)
    noise = train(0.0, gb.Stiffness.constant(3e8)).mesh_response("pinion/wheel", speeds=speeds)
    bottom.semilogy(speeds, np.abs(noise.mesh_force("pinion/wheel"))[:, 0, 0])
    bottom.axvline(SPEED, color="C1", lw=1.0)
    bottom.set(xlabel="speed of the input shaft [rad/s]", ylabel="mesh force for 1 µm [N]")
    return figure


def main() -> None:
    """Write the figure."""
    draw().savefig(FIGURES / "gear_noise.png", dpi=100)


if __name__ == "__main__":
    main()
