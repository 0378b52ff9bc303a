"""What accuracy costs: three scenes, every method, and models that leave something out.

``python examples/tradeoff.py SCENE`` measures one of the scenes shaft, train and seats, prints its
tables in Markdown and draws its diagram; ``python examples/tradeoff.py words`` measures what the
words of ``simulate(accuracy=...)`` stand for. They are the tables of docs/tradeoff.md, which
``make measure`` measures anew.
"""

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gearbow as gb
from gearbow.accuracy import ACCURACIES

LENGTH = 0.5  # of a shaft, m
DIAMETER = 0.05  # m
SEATS = (0.06, 0.22, 0.28, 0.44)  # where they begin, m
SEAT = 2e-3  # their length, m
SPEED = 100.0  # of the input shaft, rad/s
DURATION = 0.1  # s
BUDGET = 300.0  # s for each scene
LONG = 1.0  # simulated time that settings are compared at, s
WORST = 0.1  # settings with a larger error are of no use
TARGETS = (1e-2, 1e-4, 1e-6, 1e-8)
MESHES = (("g1", "g2"), ("g3", "g4"))


def shaft() -> gb.RotorSystem:
    """Describe a bowed shaft with a disk, let go in its bearings."""
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
    """Describe the double-stage train with bowed shafts and stiffness from the teeth."""
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
    """A system, what is looked at, and where it starts."""

    system: Callable[[], gb.RotorSystem]
    of: tuple[Any, ...]
    initial: str


SCENES = {
    "shaft": Scene(shaft, ("disk",), "rest"),
    "train": Scene(train, ("g1", ("g1", "g2")), "synchronous"),
    "seats": Scene(lambda: train(seats=True), ("g1", ("g1", "g2")), "synchronous"),
}


def study(scene: Scene) -> gb.Tradeoff:
    """Measure everything that the budget allows."""
    return scene.system().tradeoff(
        DURATION,
        SPEED,
        of=scene.of,
        initial=scene.initial,
        budget=BUDGET,
        progress=True,
    )


def report(scene: Scene, tradeoff: gb.Tradeoff) -> Iterator[str]:
    """Give the tables: the front, and every simplification by itself."""
    yield f"{scene.system()!r}, {DURATION:g} s at {SPEED:g} rad/s, by {' and '.join(tradeoff.of)}."
    known = f"{tradeoff.floor:.0e} by {tradeoff.check}"
    yield f"The reference, {tradeoff.reference}, is known to {known}."
    if tradeoff.discretisation is not None:
        model, errors = tradeoff.discretisation
        changes = " and ".join(f"{signal} by {error:.0e}" for signal, error in errors.items())
        yield f"More elements ({model}) change {changes}."
    yield ""
    yield f"| CPU s per simulated s for an error of | {' | '.join(f'{e:.0e}' for e in TARGETS)} |"
    yield "|---|" + "---|" * len(TARGETS)
    given = [trial for trial in tradeoff.trials if trial.model == "as given"]
    for method in dict.fromkeys(trial.method for trial in given):
        cells = []
        for target in TARGETS:
            keep = [t for t in given if t.method == method and t.bound <= target]
            cells.append(f"{min(t.rate for t in keep):.2g}" if keep else "–")
        yield f"| {method} | {' | '.join(cells)} |"
    yield ""
    yield "| best setting | error | CPU s per simulated s | set-up [ms] | steps | limited by |"
    yield "|---|---|---|---|---|---|"
    for trial in tradeoff.front(duration=LONG):
        if trial.error > WORST:
            continue
        yield (
            f"| {trial} | {trial.error_text} | {trial.rate:.2g} | {1e3 * trial.setup:.2g} "
            f"| {trial.steps} | {trial.limited_by} |"
        )
    yield ""
    yield f"| simplification | {' | '.join(f'error of {signal}' for signal in tradeoff.of)} |"
    yield "|---|" + "---|" * len(tradeoff.of)
    tight = {trial.model: trial for trial in tradeoff.trials if trial.model != "as given"}
    for model, trial in tight.items():
        yield f"| {model} | {' | '.join(f'{error:.1e}' for error in trial.errors.values())} |"


def words() -> Iterator[str]:
    """Measure what the words of `accuracy` stand for, on every scene."""
    yield f"| accuracy | setting | {' | '.join(f'error, {name}' for name in SCENES)} | expected |"
    yield "|---|---|" + "---|" * (len(SCENES) + 1)
    cells: dict[str, list[str]] = {word: [] for word in ACCURACIES}
    for scene in SCENES.values():
        found = scene.system().tradeoff(
            DURATION,
            SPEED,
            of=scene.of,
            initial=scene.initial,
            methods=[each.method for each in ACCURACIES.values()],
            tolerances=[each.rtol for each in ACCURACIES.values()],
            elements=(),
            modes=(),
            frozen=False,
            mean_stiffness=False,
            budget=BUDGET,
            repeats=1,
        )
        trials = {}
        for word, each in ACCURACIES.items():
            options = {"method": each.method, "rtol": each.rtol}
            trials[word] = next(trial for trial in found.trials if trial.options == options)
            cells[word].append(trials[word].error_text)
        if any(trial.error > ACCURACIES[word].error for word, trial in trials.items()):
            sys.exit("gearbow/accuracy.py expects less than was measured")
    for word, each in ACCURACIES.items():
        setting = f"{each.method}, rtol {each.rtol:.0e}"
        yield f"| `{word}` | {setting} | {' | '.join(cells[word])} | {each.error:.0e} |"


def main() -> None:
    """Measure one scene, or the words."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("what", choices=[*SCENES, "words"])
    folder = Path(__file__).parents[1] / "docs" / "figures"
    parser.add_argument("--output", type=Path, default=folder, help="where to write the figure")
    given = parser.parse_args()
    if given.what == "words":
        print(*words(), sep="\n")
        return
    scene = SCENES[given.what]
    tradeoff = study(scene)
    print(*report(scene, tradeoff), sep="\n")
    given.output.mkdir(parents=True, exist_ok=True)
    tradeoff.plot(duration=LONG).savefig(given.output / f"tradeoff_{given.what}.png")


if __name__ == "__main__":
    main()
