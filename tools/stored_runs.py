"""Compare twenty runs with stored ones, bit by bit: a change of structure must not change a result.

``python tools/stored_runs.py --write FILE`` stores the digests of the runs before a change;
``--check FILE`` compares after it. Digests are valid on one machine and compiler only, because
libraries of linear algebra choose their code by processor.
"""

import argparse
import hashlib
import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import gearbow as gb

SPEED = 100.0  # of the reference shaft, rad/s
DURATION = 0.02  # s

Run = Callable[[], gb.Response]


def train(
    stiffness: gb.Stiffness | float, *, backlash: float | None = None, **options: Any
) -> gb.RotorSystem:
    """Describe a double-stage train with bowed shafts."""
    bow = gb.Bow.half_sine(1.5e-4, phase=0.3)
    tooth: dict[str, Any] = {"module": 3e-3, "face_width": 0.03}
    mesh: dict[str, Any] = {"stiffness": stiffness, "damping_ratio": 0.05, "backlash": backlash}
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(name, length=0.5, outer_diameter=0.05, elements=4, bow=bow)
            for name in ("input", "middle", "output")
        ],
        gears=[
            gb.Gear("g1", "input", 0.25, 25, **tooth, unbalance=1e-4 + 2e-5j),
            gb.Gear("g2", "middle", 0.125, 50, **tooth),
            gb.Gear("g3", "middle", 0.375, 25, **tooth),
            gb.Gear("g4", "output", 0.25, 50, **tooth),
        ],
        meshes=[gb.Mesh("g1", "g2", **mesh), gb.Mesh("g3", "g4", **mesh, centre_line_angle=0.4)],
        bearings=[
            gb.Bearing(name, x, stiffness=(1e8, 8e7), damping=500.0)
            for name in ("input", "middle", "output")
            for x in (0.0, 0.5)
        ],
        torques=[gb.Torque("g1", 100.0), gb.Torque.balance("g4")],
        **options,
    )


def rotor() -> gb.RotorSystem:
    """Describe one bowed shaft with a disk."""
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "rotor", length=1.0, outer_diameter=0.05, elements=6, bow=gb.Bow.half_sine(1e-4)
            )
        ],
        disks=[gb.Disk("disk", "rotor", 0.4, 20.0, 0.1, 0.2, unbalance=1e-4j)],
        bearings=[gb.Bearing("rotor", x, stiffness=1e8, damping=1e3) for x in (0.0, 1.0)],
        gravity=9.81,
    )


def simulate(system: gb.RotorSystem, duration: float = DURATION, **options: Any) -> gb.Response:
    """Run with everything recorded."""
    record = ["gears", "disks", "meshes", "bearings", "energy"]
    if not system.gears:
        record = ["disks", "bearings", "energy"]
    if not system.disks:
        record.remove("disks")
    return system.simulate(duration, **{"speed": SPEED, "record": record, **options})


def continued(**options: Any) -> gb.Response:
    """Run in two parts."""
    system = train(gb.Stiffness.square(2e8))
    half = simulate(system, DURATION / 2, **options)
    return simulate(system, DURATION / 2, initial=half, **options)


def kept() -> gb.Response:
    """Run with a checkpoint file."""
    with tempfile.TemporaryDirectory() as folder:
        return simulate(train(2e8), checkpoint=Path(folder) / "run.npz")


def runs() -> dict[str, Run]:
    """List the runs."""
    sharp = gb.Stiffness.square(2e8)
    smooth = gb.Stiffness.parabolic(2e8, engagement=0.2)
    teeth = gb.Stiffness.potential_energy()
    ramp = gb.SpeedProfile.table([0.0, DURATION], [50.0, 150.0])
    return {
        "rotor": lambda: simulate(rotor()),
        "rotor, rk45": lambda: simulate(rotor(), method="rk45"),
        "constant stiffness": lambda: simulate(train(2e8)),
        "constant stiffness, frozen": lambda: simulate(train(2e8), geometry="frozen"),
        "constant stiffness, from rest": lambda: simulate(train(2e8), initial="rest"),
        "reversed": lambda: simulate(train(2e8), speed=-SPEED),
        "sharp, one stage": lambda: simulate(train(sharp), stages=1, rtol=1e-4),
        "sharp, four stages": lambda: simulate(train(sharp), stages=4, rtol=1e-8),
        "sharp, frozen, 30 modes": lambda: simulate(train(sharp), geometry="frozen", modes=30),
        "smooth": lambda: simulate(train(smooth)),
        "smooth, fixed step": lambda: simulate(train(smooth), step=2e-5),
        "teeth": lambda: simulate(train(teeth)),
        "teeth, backlash": lambda: simulate(train(teeth, backlash=5e-5), initial="static"),
        "teeth, backlash, rk45": lambda: simulate(train(teeth, backlash=5e-5), method="rk45"),
        "modal damping": lambda: simulate(train(teeth, modal_damping=0.02)),
        "modal damping, rk45": lambda: simulate(train(smooth, modal_damping=0.02), method="rk45"),
        "rk4": lambda: simulate(train(smooth), DURATION / 4, method="rk4"),
        "etdrk4": lambda: simulate(train(smooth), method="etdrk4", step=1e-5),
        "changing speed": lambda: simulate(train(teeth), DURATION / 4, speed=ramp),
        "continued": continued,
        "checkpoint": kept,
    }


def digest(response: gb.Response) -> str:
    """Hash every array of a data set of the response."""
    found = hashlib.sha256()
    dataset = response.to_xarray()
    for name in sorted(map(str, dataset.data_vars)):
        if not name.startswith("final_"):
            found.update(np.ascontiguousarray(dataset[name].to_numpy()).tobytes())
    return found.hexdigest()[:16]


def main() -> None:
    """Store or compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    action = parser.add_mutually_exclusive_group(required=True)
    action.add_argument("--write", type=Path, metavar="FILE", help="store the digests")
    action.add_argument("--check", type=Path, metavar="FILE", help="compare with stored digests")
    given = parser.parse_args()
    found = {name: digest(run()) for name, run in runs().items()}
    if given.write:
        given.write.write_text(json.dumps(found, indent=1), encoding="utf-8")
        return
    stored = json.loads(given.check.read_text(encoding="utf-8"))
    different = [name for name in found if stored.get(name) != found[name]]
    print(f"{len(found) - len(different)} of {len(found)} runs are identical")
    if different:
        sys.exit(f"different: {', '.join(different)}")


if __name__ == "__main__":
    main()
