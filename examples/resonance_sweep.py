"""Resonance of a spur gear pair over the speed: loss of contact causes jumps.

Two steel gears have 50 teeth, module 3 mm and a face width of 20 mm. The model has torsion only. A
tooth error of 2 µm excites the pair at the mesh frequency. Under a light load the flanks separate
near resonance. Separation reduces the average mesh stiffness, so the resonance peak bends to lower
speeds. Between two folds there are two stable steady motions, and an unstable one between them: a
run with rising speed jumps at one fold, a run with falling speed at the other. Under a load that
exceeds the dynamic mesh force the flanks stay in contact, and the peak is that of a linear system.
Run with ``python examples/resonance_sweep.py``.
"""

import argparse
import math
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import gearbow as gb
from gearbow import plotting

TEETH = 50
TORQUES = (200.0, 400.0, 1000.0)  # N m
ERROR = 2e-6  # m, at the mesh frequency
MESH = ("pinion", "wheel")
RANGE = (1.2, 0.55)  # speeds, divided by the resonance speed


def pair(torque: float) -> gb.RotorSystem:
    """Return the gear pair. Its tip radii exceed the standard ones: the contact ratio is 2."""
    # The engagement follows the prescribed rotation. With phase="twist" the damping losses would
    # slow the free train down.
    stiffness = gb.Stiffness.potential_energy((0.025, 0.025), phase="prescribed")
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(f"{name} shaft", length=0.1, outer_diameter=0.03, elements=1) for name in MESH
        ],
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
        # The shafts have a little damping: without it, their own modes have sharp resonances.
        rayleigh=(0.0, 1e-6),
        motion="torsion",
    )


def resonance(system: gb.RotorSystem) -> float:
    """Return the speed [rad/s] of the mesh resonance: mesh frequency = first natural frequency."""
    return 2.0 * math.pi * float(system.modes().frequencies_hz[1]) / TEETH


def figure(curves: dict[float, tuple[float, float, gb.Continuation]]) -> Figure:
    """Draw the branches, one panel for each torque."""
    with mpl.rc_context(plotting.STYLE):
        drawing = Figure(figsize=(13.0, 5.0), layout="constrained")
        panels = drawing.subplots(1, len(curves), sharey=True)
        for panel, (torque, (static, speed, branch)) in zip(panels, curves.items(), strict=True):
            ratios, rms = branch.values / speed, 1e6 * branch.statistic("rms", MESH, "deflection")
            panel.plot(
                ratios,
                np.where(branch.stable, rms, np.nan),
                color=plotting.PALETTE[0],
                lw=2.5,
                label="stable",
            )
            unstable = ~branch.stable
            # Unstable parts include their folds.
            unstable[:-1] |= ~branch.stable[1:]
            unstable[1:] |= ~branch.stable[:-1]
            panel.plot(
                ratios,
                np.where(unstable, rms, np.nan),
                color=plotting.PALETTE[1],
                ls=(0, (4.0, 2.0)),
                lw=2.0,
                label="unstable",
            )
            for kind, mark in (("fold", "o"), ("contact loss", "D")):
                at = np.array(branch.kinds) == kind
                panel.plot(ratios[at], rms[at], mark, color="0.2", ms=6.0, ls="none", label=kind)
            panel.set(title=f"{torque:g} N m: static {1e6 * static:.1f} µm")
            panel.set_xlabel("mesh frequency / natural frequency")
        panels[0].set_ylabel("RMS of the deflection about its mean [µm]")
        drawing.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return drawing


def main() -> None:
    """Follow the branches, print the results and save the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    default = Path(__file__).parents[1] / "docs" / "figures" / "resonance_sweep.png"
    parser.add_argument("--output", type=Path, default=default, help="file of the figure")
    output: Path = parser.parse_args().output

    curves = {}
    for torque in TORQUES:
        system = pair(torque)
        speed = resonance(system)
        static = float(system.static().mesh(MESH).deflection)
        branch = system.continuation(
            "speed", RANGE[0] * speed, RANGE[1] * speed, rtol=1e-9, record=["meshes"]
        )
        curves[torque] = (static, speed, branch)
        rms = branch.statistic("rms", MESH, "deflection")
        folds = ", ".join(f"{fold:.4f}" for fold in np.sort(branch.folds / speed)) or "none"
        print(
            f"{torque:6g} N m  static deflection {1e6 * static:5.1f} µm  RMS at the peak: "
            f"{1e6 * rms.max():5.1f} µm  folds at speed ratios: {folds}"
        )
    output.parent.mkdir(parents=True, exist_ok=True)
    figure(curves).savefig(output)
    print(f"figure: {output}")


if __name__ == "__main__":
    main()
