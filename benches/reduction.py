"""Error of reduced models and its estimate, and the cost of large models: for docs/methods.md.

``python benches/reduction.py`` prints three tables: the error of the mesh force for a number of
modes, errors and their estimates on twelve scenes, and CPU times by the number of coordinates.
Errors are RMS of the difference to the run with all modes over RMS of the signal about its mean,
for the worst gear displacement and the worst mesh force, over the first 0.1 s.
"""

import time
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

import gearbow as gb

DURATION = 0.1  # s
SPEED = 100.0  # of the input shaft, rad/s
RTOL = 1e-6


def train(elements: int = 15, **options: Any) -> gb.RotorSystem:
    """Describe a double-stage train; `options` replace values of it."""
    given: dict[str, Any] = {
        "lengths": (0.5, 0.5, 0.5),
        "diameters": (0.05, 0.05, 0.05),
        "teeth": (25, 50, 25, 50),
        "bows": (1.5e-4, 1.5e-4, 0.0),
        "engagement": "sharp",
        "mesh": {"damping_ratio": 0.05},
        "bearing": {"stiffness": 1e8, "damping": 500.0},
        "torque": 250.0,
        "system": {},
        **options,
    }
    names = ("input", "middle", "output")
    lengths = given["lengths"]
    shafts = [
        gb.Shaft(
            name,
            length=length,
            outer_diameter=diameter,
            elements=elements,
            bow=gb.Bow.half_sine(bow, phase=0.7 * index) if bow else None,
        )
        for index, (name, length, diameter, bow) in enumerate(
            zip(names, lengths, given["diameters"], given["bows"], strict=True)
        )
    ]
    places = (("input", 0.5), ("middle", 0.25), ("middle", 0.75), ("output", 0.5))
    gears = [
        gb.Gear(
            f"g{index + 1}",
            shaft,
            part * lengths[names.index(shaft)],
            teeth,
            module=3e-3,
            face_width=0.03,
        )
        for index, ((shaft, part), teeth) in enumerate(zip(places, given["teeth"], strict=True))
    ]
    stiffness = gb.Stiffness.square(pair=2e8, engagement=given["engagement"])
    return gb.RotorSystem(
        shafts=shafts,
        gears=gears,
        meshes=[
            gb.Mesh(*pair, stiffness=stiffness, **given["mesh"])
            for pair in (("g1", "g2"), ("g3", "g4"))
        ],
        bearings=[
            gb.Bearing(name, x, **given["bearing"])
            for name, length in zip(names, lengths, strict=True)
            for x in (0.0, length)
        ],
        torques=[gb.Torque("g1", given["torque"]), gb.Torque.balance("g4")],
        **given["system"],
    )


def scenes() -> Iterator[tuple[str, gb.RotorSystem, dict[str, Any]]]:
    """Give name, system and options of the run of twelve scenes."""
    undamped: dict[str, Any] = {"mesh": {}, "bearing": {"stiffness": 1e8}}
    anisotropic = [[1e8, 1e7], [1e7, 4e7]]
    yield "sharp engagement, live", train(), {}
    yield "sharp engagement, frozen", train(), {"geometry": "frozen"}
    yield "smooth engagement", train(engagement=0.4), {}
    yield "undamped", train(engagement=0.2, **undamped), {}
    yield "modal damping 2 %", train(system={"modal_damping": 0.02}), {}
    yield "from the equilibrium", train(engagement=0.4), {"initial": "static"}
    yield "bearings couple the planes", train(bearing={"stiffness": anisotropic}), {}
    loose = {"damping_ratio": 0.05, "backlash": 1e-4}
    yield "backlash, separation", train(mesh=loose, torque=15.0), {}
    random = np.random.default_rng(20)
    for index in range(4):
        system = train(
            elements=int(random.integers(15, 20)),
            lengths=tuple(random.uniform(0.3, 0.9, 3)),
            diameters=tuple(random.uniform(0.03, 0.07, 3)),
            teeth=tuple(int(value) for value in random.integers(18, 60, 4)),
            bows=tuple(random.uniform(0.0, 2e-4, 3)),
            engagement=float(random.uniform(0.1, 0.5)),
            mesh={"damping_ratio": float(random.uniform(0.0, 0.1))},
            bearing={"stiffness": 10 ** random.uniform(7.5, 8.5), "damping": 300.0},
            torque=float(random.uniform(50.0, 400.0)),
        )
        yield f"random {index + 1}", system, {}


def errors(found: gb.Response, exact: gb.Response) -> tuple[float, float]:
    """Compute the errors of displacements and of mesh forces."""
    gears = ("g1", "g2", "g3", "g4")
    pairs = (("g1", "g2"), ("g3", "g4"))

    def error(found: np.ndarray, exact: np.ndarray) -> float:
        variation = ((exact - exact.mean(axis=0)) ** 2).sum()
        return float(np.sqrt(((found - exact) ** 2).sum() / variation))

    return (
        max(error(found.displacement(gear), exact.displacement(gear)) for gear in gears),
        max(error(found.mesh(pair).force, exact.mesh(pair).force) for pair in pairs),
    )


def by_modes() -> None:
    """Print the errors by the number of modes."""
    system = train(14)
    exact = system.simulate(DURATION, SPEED, rtol=RTOL)
    print(f"\n{len(system.dofs)} coordinates\n| modes kept | displacement | mesh force |")
    print("|---|---|---|")
    for modes in (67, 80, 120):
        found = system.simulate(DURATION, SPEED, rtol=RTOL, modes=modes)
        print("| {} | {:.1e} | {:.1e} |".format(modes, *errors(found, exact)))


def by_scene() -> None:
    """Print errors and their estimates."""
    print("\n| scene | modes | displacement | estimate | mesh force | estimate |")
    print("|---|---|---|---|---|---|")
    for name, system, options in scenes():
        exact = system.simulate(DURATION, SPEED, rtol=RTOL, **options)
        for level in ("draft", "engineering"):
            found = system.simulate(
                4 * DURATION, SPEED, accuracy=level, times=exact.time, **options
            )
            same = system.simulate(
                DURATION, SPEED, rtol={"draft": 1e-3, "engineering": 1e-5}[level], **options
            )
            kept, estimates = found.statistics.modes, found.statistics.modes_error
            if estimates is None:
                print(f"| {name}, {level} | all of {len(system.dofs)} | | | | |", flush=True)
                continue
            true = errors(found, same)
            row = (true[0], estimates[0], true[1], estimates[1])
            cells = " | ".join(f"{value:.1e}" for value in row)
            print(f"| {name}, {level} | {kept} of {len(system.dofs)} | {cells} |", flush=True)


def by_size() -> None:
    """Print CPU times of the set-up and of a simulated second."""
    print("\n| coordinates | modes | set-up | second run | s per simulated second |")
    print("|---|---|---|---|---|")
    for elements in (8, 14, 40, 60):
        system = train(elements)

        def run(duration: float, system: gb.RotorSystem = system) -> tuple[float, gb.Response]:
            begin = time.process_time()
            response = system.simulate(duration, SPEED, accuracy="engineering")
            return time.process_time() - begin, response

        first, _ = run(1e-4)
        again, _ = run(1e-4)
        short, _ = run(0.4)
        long, response = run(1.4)
        kept = response.statistics.modes or len(system.dofs)
        print(
            f"| {len(system.dofs)} | {kept} | {first:.2f} | {again:.2f} | {long - short:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    warnings.simplefilter("ignore", gb.SceneWarning)
    by_size()
    by_modes()
    by_scene()
