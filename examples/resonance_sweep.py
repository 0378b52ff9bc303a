"""Speed sweep of a spur gear pair through its mesh resonance: loss of contact causes jumps.

Two steel gears have 50 teeth, module 3 mm and a face width of 20 mm. The model has torsion only. A
tooth error of 2 µm excites the pair at the mesh frequency. Under a light load the flanks separate
near resonance. Separation reduces the average mesh stiffness, so the resonance peak bends to lower
speeds. In a range of speeds two steady motions exist: a sweep with rising speed finds one, a sweep
with falling speed finds the other. Under a load that exceeds the dynamic mesh force the flanks stay
in contact, and the peak is that of a linear system.
Run with ``python examples/resonance_sweep.py``.
"""

import argparse
import math
from collections.abc import Iterable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import gearbow as gb
from gearbow import plotting

TEETH = 50
TORQUES = (200.0, 400.0, 1000.0)  # N m
ERROR = 2e-6  # m, at the mesh frequency
MESH = ("pinion", "wheel")
SPEEDS = np.linspace(0.55, 1.2, 131)  # divided by the resonance speed
SETTLE, MEASURE, SAMPLES = 150, 20, 40  # mesh cycles, mesh cycles, samples per cycle


def pair(torque: float) -> gb.RotorSystem:
    """Return the gear pair. Its tip radii exceed the standard ones: the contact ratio is 2."""
    # The engagement follows the prescribed rotation. With phase="twist" the damping losses would
    # slow the free train down.
    stiffness = gb.Stiffness.potential_energy((0.025, 0.025), phase="prescribed")
    return gb.RotorSystem(
        shafts=[gb.Shaft(f"{name} shaft", length=0.1, outer_diameter=0.03) for name in MESH],
        gears=[
            gb.Gear(
                name,
                shaft=f"{name} shaft",
                position=0.0,
                teeth=TEETH,
                module=3e-3,
                face_width=0.02,
                tip_radius=78.47e-3,
            )
            for name in MESH
        ],
        meshes=[
            gb.Mesh(
                *MESH,
                stiffness=stiffness,
                damping_ratio=0.05,
                backlash=1e-4,
                error=gb.TransmissionError(tooth=[(ERROR, 0.0)]),
            )
        ],
        torques=[gb.Torque("pinion", torque), gb.Torque.balance("wheel")],
        motion="torsion",
    )


def resonance(system: gb.RotorSystem) -> float:
    """Return the speed [rad/s] of the mesh resonance: mesh frequency = first natural frequency."""
    return 2.0 * math.pi * float(system.modes().frequencies_hz[1]) / TEETH


def sweep(system: gb.RotorSystem, speeds: Iterable[float]) -> NDArray[np.float64]:
    """Return (RMS, minimum) of the mesh deflection [m] at each speed.

    Each run starts from the final state of the previous speed.
    """
    last: str | gb.Response = "static"
    found = []
    for speed in speeds:
        cycle = 2.0 * math.pi / (speed * TEETH)
        begin = 0.0 if isinstance(last, str) else float(last.final["time"])
        times = begin + (SETTLE + np.arange(MEASURE * SAMPLES) / SAMPLES) * cycle
        last = system.simulate(
            (SETTLE + MEASURE) * cycle, speed, initial=last, times=times, record=["meshes"]
        )
        deflection = last.mesh(*MESH).deflection
        found.append((float(np.std(deflection)), float(deflection.min())))
    return np.array(found)


def figure(curves: dict[float, tuple[float, NDArray[np.float64], NDArray[np.float64]]]) -> Figure:
    """Draw the sweeps, one panel for each torque."""
    with mpl.rc_context(plotting.STYLE):
        drawing = Figure(figsize=(13.0, 5.0), layout="constrained")
        panels = drawing.subplots(1, len(curves), sharey=True)
        for panel, (torque, (static, up, down)) in zip(panels, curves.items(), strict=True):
            for curve, name, colour, width in (
                (down, "speed falling", plotting.PALETTE[1], 3.5),
                (up, "speed rising", plotting.PALETTE[0], 1.2),
            ):
                panel.plot(SPEEDS, 1e6 * curve[:, 0], color=colour, lw=width, label=name)
            panel.fill_between(
                SPEEDS,
                0.0,
                1.0,
                where=down[:, 1] < 0.0,
                transform=panel.get_xaxis_transform(),
                color="0.93",
                label="loss of contact, speed falling",
            )
            panel.set(title=f"{torque:g} N m: static {1e6 * static:.1f} µm")
            panel.set_xlabel("mesh frequency / natural frequency")
        panels[0].set_ylabel("RMS of the deflection about its mean [µm]")
        drawing.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return drawing


def main() -> None:
    """Run the sweeps, print the results and save the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    default = Path(__file__).parents[1] / "docs" / "figures" / "resonance_sweep.png"
    parser.add_argument("--output", type=Path, default=default, help="file of the figure")
    output: Path = parser.parse_args().output

    curves = {}
    for torque in TORQUES:
        system = pair(torque)
        speeds = SPEEDS * resonance(system)
        static = system.static().mesh(*MESH).deflection
        up, down = sweep(system, speeds), sweep(system, speeds[::-1])[::-1]
        curves[torque] = (static, up, down)
        apart = np.abs(up[:, 0] - down[:, 0]) > 0.02 * down[:, 0]
        where = f"{SPEEDS[apart].min():.3f} to {SPEEDS[apart].max():.3f}" if apart.any() else "none"
        print(
            f"{torque:6g} N m  static deflection {1e6 * static:5.1f} µm  RMS at the peak: "
            f"{1e6 * up[:, 0].max():5.1f} µm (rising speed), "
            f"{1e6 * down[:, 0].max():5.1f} µm (falling speed)"
            f"  two steady motions at speed ratios: {where}"
        )
    output.parent.mkdir(parents=True, exist_ok=True)
    figure(curves).savefig(output)
    print(f"figure: {output}")


if __name__ == "__main__":
    main()
