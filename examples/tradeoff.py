"""Accuracy and cost: error and CPU time of every method and simplified model in three scenes.

``python examples/tradeoff.py SCENE`` measures the scene shaft, train or seats, prints its tables in
Markdown and draws its diagram. The number of elements is given and does not vary: the errors are
those of integration and simplification. docs/tradeoff.md contains these tables; ``make measure``
updates them.
"""

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import gearbow as gb

LENGTH = 0.5  # length of a shaft, m
DIAMETER = 0.05  # shaft diameter, m
SEATS = (0.06, 0.22, 0.28, 0.44)  # positions of the bearing seats, m
SEAT = 2e-3  # length of a seat, m
SPEED = 100.0  # speed of the input shaft, rad/s
DURATION = 0.1  # s
BUDGET = 300.0  # wall-clock limit for each scene, s
LONG = 1.0  # simulated time for the comparison of settings, s
WORST = 0.1  # the table omits settings with a larger error
TARGETS = (1e-2, 1e-4, 1e-6, 1e-8)
MESHES = (("g1", "g2"), ("g3", "g4"))


def shaft() -> gb.RotorSystem:
    """Return a bowed shaft with a disk."""
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "rotor",
                length=1.0,
                outer_diameter=DIAMETER,
                elements=16,
                bow=gb.Bow.half_sine(1e-4),
            )
        ],
        disks=[gb.Disk("disk", "rotor", 0.5, 10.0, 0.03, 0.06)],
        bearings=[gb.Bearing("rotor", x, stiffness=1e8, damping=500.0) for x in (0.0, 1.0)],
        modal_damping=0.01,
    )


def train(seats: bool = False) -> gb.RotorSystem:
    """Return the double-stage train: bowed shafts, potential-energy mesh stiffness."""
    return gb.RotorSystem(
        shafts=[_train_shaft(name, seats) for name in ("input", "middle", "output")],
        gears=[
            gb.Gear(name, shaft=shaft, position=position, teeth=teeth, module=3e-3, face_width=0.03)
            for name, shaft, position, teeth in (
                ("g1", "input", LENGTH / 2, 25),
                ("g2", "middle", LENGTH / 4, 50),
                ("g3", "middle", 3 * LENGTH / 4, 25),
                ("g4", "output", LENGTH / 2, 50),
            )
        ],
        meshes=[
            gb.Mesh(*pair, stiffness=gb.Stiffness.potential_energy(), damping_ratio=0.05)
            for pair in MESHES
        ],
        bearings=[
            gb.Bearing(name, position=x, stiffness=1e8, damping=500.0)
            for name in ("input", "middle", "output")
            for x in (0.0, LENGTH)
        ],
        torques=[gb.Torque("g1", 250.0), gb.Torque.balance("g4")],
    )


def _train_shaft(name: str, seats: bool) -> gb.Shaft:
    bow = gb.Bow.half_sine(1.5e-4)
    if not seats:
        return gb.Shaft(name, length=LENGTH, outer_diameter=DIAMETER, elements=8, bow=bow)
    segments, x = [], 0.0
    for begin in SEATS:
        between = begin - x
        segments.append(gb.Segment(between, DIAMETER, elements=max(1, round(16 * between))))
        segments.append(gb.Segment(SEAT, 1.2 * DIAMETER))
        x = begin + SEAT
    segments.append(gb.Segment(LENGTH - x, DIAMETER, elements=1))
    return gb.Shaft(name, segments=segments, bow=bow)


@dataclass(frozen=True)
class Scene:
    """A system, the compared signals and the initial state."""

    system: Callable[[], gb.RotorSystem]
    of: tuple[Any, ...]
    initial: Literal["synchronous", "rest"]


SCENES = {
    "shaft": Scene(shaft, ("disk",), "rest"),
    "train": Scene(train, ("g1", ("g1", "g2")), "synchronous"),
    "seats": Scene(lambda: train(seats=True), ("g1", ("g1", "g2")), "synchronous"),
}


def study(scene: Scene) -> gb.results.Tradeoff[gb.RotorSystem]:
    """Measure all settings that the budget allows."""
    return scene.system().tradeoff(
        DURATION,
        SPEED,
        signals=scene.of,
        initial=scene.initial,
        degrees=[],
        budget=BUDGET,
    )


def report(scene: Scene, tradeoff: gb.results.Tradeoff[gb.RotorSystem]) -> Iterator[str]:
    """Return the tables: methods, Pareto front and simplified models."""
    signals = " and ".join(tradeoff.signals)
    yield f"{scene.system()!r}."
    yield f"Duration {DURATION:g} s, speed {SPEED:g} rad/s. Signals: {signals}."
    yield f"Reference: {tradeoff.reference}."
    yield f"Its difference from {tradeoff.check} is {tradeoff.floor:.0e}."
    yield ""
    yield f"| CPU s per simulated s, error at most | {' | '.join(f'{e:.0e}' for e in TARGETS)} |"
    yield "|---|" + "---|" * len(TARGETS)
    given = [trial for trial in tradeoff.trials if trial.model == "as given"]
    for method in dict.fromkeys(trial.method for trial in given):
        cells = []
        for target in TARGETS:
            keep = [t for t in given if t.method == method and t.bound <= target]
            cells.append(f"{min(t.rate for t in keep):.2g}" if keep else "–")
        yield f"| {method} | {' | '.join(cells)} |"
    yield ""
    yield "| Pareto front | error | CPU s per simulated s | set-up [ms] | steps | limited by |"
    yield "|---|---|---|---|---|---|"
    for trial in tradeoff.front(duration=LONG):
        if trial.error > WORST:
            continue
        yield (
            f"| {trial} | {trial.error_text} | {trial.rate:.2g} | {1e3 * trial.setup:.2g} "
            f"| {trial.steps} | {trial.limited_by} |"
        )
    yield ""
    yield f"| simplification | {' | '.join(f'error of {signal}' for signal in tradeoff.signals)} |"
    yield "|---|" + "---|" * len(tradeoff.signals)
    tight = {trial.model: trial for trial in tradeoff.trials if trial.model != "as given"}
    for model, trial in tight.items():
        yield f"| {model} | {' | '.join(f'{error:.1e}' for error in trial.errors.values())} |"


def main() -> None:
    """Measure one scene."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("what", choices=list(SCENES))
    folder = Path(__file__).parents[1] / "docs" / "figures"
    parser.add_argument("--output", type=Path, default=folder, help="folder of the figure")
    given = parser.parse_args()
    scene = SCENES[given.what]
    tradeoff = study(scene)
    print(*report(scene, tradeoff), sep="\n")
    given.output.mkdir(parents=True, exist_ok=True)
    tradeoff.plot(duration=LONG).savefig(given.output / f"tradeoff_{given.what}.png")


if __name__ == "__main__":
    main()
