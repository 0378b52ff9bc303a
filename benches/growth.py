"""Print how the time of the analyses with band matrices grows with the number of coordinates.

`python benches/growth.py` takes about a minute on one core. The exponent is that between the
smallest and the largest train.
"""

import time
import warnings
from collections.abc import Callable

import numpy as np

import gearbow as gb

ELEMENTS = (15, 40, 80, 160, 320)  # per shaft
SPEED = 100.0  # rad/s
REPEATS = 3

Work = Callable[[gb.RotorSystem], object]


def train(elements: int, damping: float = 500.0) -> gb.RotorSystem:
    """Return a train of three shafts with two meshes and bearings with this damping [N s/m]."""
    names = ("input", "middle", "output")
    bow = gb.Bow.half_sine(1.5e-4)
    shafts = [
        gb.Shaft(name, length=0.5, outer_diameter=0.05, elements=elements, degree=1, bow=bow)
        for name in names
    ]
    places = [("g1", "input", 0.25, 25), ("g2", "middle", 0.125, 50)]
    places += [("g3", "middle", 0.375, 25), ("g4", "output", 0.25, 50)]
    gears = [
        gb.Gear(name, shaft, position, teeth=teeth, module=3e-3, face_width=0.03)
        for name, shaft, position, teeth in places
    ]
    pairs = [("g1", "g2"), ("g3", "g4")]
    return gb.RotorSystem(
        shafts,
        gears=gears,
        meshes=[gb.Mesh(a, b, stiffness=2e8, damping_ratio=0.05) for a, b in pairs],
        bearings=[
            gb.Bearing(name, x, stiffness=1e8, damping=damping)
            for name in names
            for x in (0.0, 0.5)
        ],
        torques=[gb.Torque("g1", 250.0), gb.Torque.balance("g4")],
        gravity=(0.0, -9.81),
    )


WORK: dict[str, tuple[float, Work]] = {
    "static": (500.0, lambda system: system.static()),
    "synchronous, 10 speeds": (500.0, lambda system: system.synchronous(np.linspace(50, 500, 10))),
    "modes(count=10)": (500.0, lambda system: system.modes(SPEED, count=10)),
    "the same, overdamped": (5e4, lambda system: system.modes(SPEED, count=10)),
    "campbell, 5 speeds": (500.0, lambda system: system.campbell(np.linspace(0, 400, 5))),
    "critical_speed_map(count=10)": (
        500.0,
        lambda system: system.critical_speed_map([1e8], count=10),
    ),
}


def seconds(work: Work, elements: int, damping: float) -> float:
    """Return the CPU time of a first call [s]: nothing is cached."""
    best = np.inf
    for _ in range(REPEATS):
        system = train(elements, damping)
        start = time.process_time()
        work(system)
        best = min(best, time.process_time() - start)
    return best


def main() -> None:
    """Print the table."""
    sizes = [len(train(elements).dofs) for elements in ELEMENTS]
    print("| CPU seconds | " + " | ".join(f"n = {size}" for size in sizes) + " | exponent |")
    print("|---|" + "---:|" * (len(sizes) + 1))
    for name, (damping, work) in WORK.items():
        times = [seconds(work, elements, damping) for elements in ELEMENTS]
        exponent = np.log(times[-1] / times[0]) / np.log(sizes[-1] / sizes[0])
        print(f"| {name} | " + " | ".join(f"{t:.4f}" for t in times) + f" | {exponent:.2f} |")


if __name__ == "__main__":
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        main()
