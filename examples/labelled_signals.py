"""Bow or unbalance? A classifier is trained on labelled signals and tested on other machines.

Each machine is a geared pair that runs down from 450 to 100 rad/s past a probe beside the input
shaft. It has a bow and an unbalance, as every machine; one of them is the fault, and mostly the
larger one. The features of the classifier are complex 1× amplitudes of the probe, relative to the
largest of them: at one speed, over a part of the speeds, or over all. A quarter of the machines is
held back. Run with ``python examples/labelled_signals.py``; it needs scikit-learn
(``pip install "gearbow[netcdf]" scikit-learn``).
"""

import argparse
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import gearbow as gb

RUN_DOWN = gb.SpeedProfile.ramp(450.0, 100.0, duration=1.0)  # rad/s
SENSORS = {"y": gb.Probe("input", 0.2), "mark": gb.Tacho("input")}
NOISE = {"y": 2e-6}  # m
UNITS = {
    "bow": "m",
    "bow_phase": "rad",
    "unbalance": "kg m",
    "unbalance_phase": "rad",
    "torque": "N m",
}
#: Ranges of the bow [m] and of the unbalance [kg m]: of the fault, and of what every machine has.
FAULTS = {"bow": (1e-5, 1e-4), "unbalance": (1e-4, 1e-3)}
USUAL = {"bow": 3e-5, "unbalance": 3e-4}
ORDERS = {"shaft_harmonics": 1, "mesh_harmonics": 0, "sidebands": 0, "revolutions": 8}


def machine(
    *,
    fault: str,  # noqa: ARG001  # the class, which follows from the other labels
    bow: float,
    bow_phase: float,
    unbalance: float,
    unbalance_phase: float,
    torque: float,
) -> gb.RotorSystem:
    """Return a geared pair with a bent, unbalanced input shaft."""
    bent = gb.Bow.half_sine(bow, phase=bow_phase)
    excess = unbalance * np.exp(1j * unbalance_phase)
    return gb.RotorSystem(
        shafts=[
            gb.Shaft("input", length=0.8, outer_diameter=0.05, bow=bent),
            gb.Shaft("output", length=0.8, outer_diameter=0.05),
        ],
        gears=[
            gb.Gear(
                "pinion", "input", 0.4, teeth=25, module=3e-3, face_width=0.03, unbalance=excess
            ),
            gb.Gear("wheel", "output", 0.4, teeth=50, module=3e-3, face_width=0.03),
        ],
        meshes=[gb.Mesh("pinion", "wheel", stiffness=2e8, damping_ratio=0.05)],
        bearings=[
            gb.Bearing(shaft, x, stiffness=1e8, damping=2e3)
            for shaft in ("input", "output")
            for x in (0.0, 0.8)
        ],
        torques=[gb.Torque("pinion", torque), gb.Torque.balance("wheel")],
        modal_damping=0.02,
    )


def run_down(system: gb.RotorSystem, **_: Any) -> gb.Response:
    """Run down from 450 to 100 rad/s in 1 s, sampled at 2 kHz."""
    return system.simulate(
        1.0, RUN_DOWN, output_step=5e-4, record=[("input", 0.2)], accuracy="draft"
    )


def machines(count: int, seed: int = 1) -> list[dict[str, Any]]:
    """Draw machines at random: half of them are bent, half of them unbalanced."""
    random = np.random.default_rng(seed)
    found = []
    for i in range(count):
        fault = ("bow", "unbalance")[i % 2]
        sizes = {name: random.uniform(0.0, USUAL[name]) for name in USUAL}
        sizes[fault] = float(np.exp(random.uniform(*np.log(FAULTS[fault]))))
        phases = random.uniform(-np.pi, np.pi, 2)
        found.append(
            {
                "fault": fault,
                "bow": sizes["bow"],
                "bow_phase": phases[0],
                "unbalance": sizes["unbalance"],
                "unbalance_phase": phases[1],
                "torque": random.uniform(50.0, 300.0),
            }
        )
    return found


def features(amplitudes: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Give amplitudes over the speed without their size and phase, which say nothing."""
    first = amplitudes[:, :1] / np.abs(amplitudes[:, :1])
    relative = amplitudes / (first * np.abs(amplitudes).max(axis=1, keepdims=True))
    return np.hstack([relative.real, relative.imag])


def report(made: gb.Sweep) -> None:
    """Print which share of the machines that were held back the classifier names correctly."""
    from sklearn.ensemble import RandomForestClassifier  # noqa: PLC0415

    names = list(made.values("order")[0])
    amplitudes = made.values("y_orders")[:, :, names.index("1× input")]
    speeds = made.values("segment_speed")[0]
    faults = np.array(made.parameters["fault"])
    usual = [
        point.parameters[fault] < USUAL[fault] for point, fault in zip(made, faults, strict=True)
    ]
    trained = 3 * len(made) // 4
    held_back = np.arange(len(made)) >= trained
    small = np.array(usual)
    print(
        f"{trained} machines for training, {held_back.sum()} held back: "
        f"{(held_back & ~small).sum()} with a large fault, {(held_back & small).sum()} with one "
        "that other machines have too.\n"
    )
    print("| 1× amplitudes | large faults | small faults |\n|---|---|---|")
    for title, chosen in {
        f"at {speeds[0]:.0f} rad/s": speeds == speeds[0],
        "below 200 rad/s": speeds < 200.0,
        "200 to 300 rad/s": (speeds > 200.0) & (speeds < 300.0),
        "above 300 rad/s": speeds > 300.0,
        "at all speeds": speeds > 0.0,
    }.items():
        values = features(amplitudes[:, chosen])
        forest = RandomForestClassifier(300, random_state=0)
        forest.fit(values[~held_back], faults[~held_back])
        right = forest.predict(values) == faults
        shares = [right[held_back & group].mean() for group in (~small, small)]
        print(f"| {title} | {shares[0]:.0%} | {shares[1]:.0%} |")


def main() -> None:
    """Make the data, train on three quarters of the machines and test on the others."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--count", type=int, default=320, help="number of machines")
    parser.add_argument("--out", type=Path, help="folder of the data; none keeps no files")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        made = gb.dataset(
            machine,
            machines(given.count),
            run_down,
            SENSORS,
            (given.out or Path(folder)) / "run_downs.nc",
            noise=NOISE,
            orders=ORDERS,
            units=UNITS,
            description="Run-downs of a geared pair, to tell a bent shaft from an unbalanced one.",
        )
    report(made)


if __name__ == "__main__":
    main()
