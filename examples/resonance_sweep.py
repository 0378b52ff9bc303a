"""A spur pair swept up and down through its mesh resonance: flanks that part make it jump.

Two steel gears with 50 teeth, module 3 mm, 20 mm wide, on shafts that do nothing but hold them. A
tooth error of 2 µm shakes them. Under a light load the flanks part near resonance; the mesh is then
soft, the peak leans over to lower speeds, and what is found there depends on where one came from.
Under a load that exceeds the dynamic force they never part, and the peak is a linear system's.
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
from gearbow import plots

TEETH = 50
TORQUES = (200.0, 400.0, 1000.0)  # N m
ERROR = 2e-6  # m, at the mesh frequency
MESH = ("pinion", "wheel")
SPEEDS = np.linspace(0.55, 1.2, 131)  # over that of the resonance
SETTLE, MEASURE, SAMPLES = 150, 20, 40  # mesh cycles, mesh cycles, samples in each


def pair(torque: float) -> gb.RotorSystem:
    """Describe the pair; tips a little above standard make the contact ratio 2."""
    # The stiffness is moved by the spin, which a motor holds: twist would let the losses brake it.
    stiffness = gb.Stiffness.potential_energy((0.025, 0.025), phase="prescribed")
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(f"{name} shaft", length=1.0, outer_diameter=1e-3, elements=1) for name in MESH
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
        motion="torsion",
    )


def resonance(system: gb.RotorSystem) -> float:
    """Give the speed at which the teeth meet at the highest natural frequency, that of the mesh."""
    return 2.0 * math.pi * float(system.modes().frequencies_hz.max()) / TEETH


def sweep(system: gb.RotorSystem, speeds: Iterable[float]) -> NDArray[np.float64]:
    """Give (rms, least) of the deflection at each speed, each begun where the one before ended."""
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
    """Draw the sweeps, a panel for each torque."""
    with mpl.rc_context(plots.STYLE):
        drawing = Figure(figsize=(13.0, 5.0), layout="constrained")
        panels = drawing.subplots(1, len(curves), sharey=True)
        for panel, (torque, (static, up, down)) in zip(panels, curves.items(), strict=True):
            for curve, name, colour, width in (
                (down, "speed falling", plots.PALETTE[1], 3.5),
                (up, "speed rising", plots.PALETTE[0], 1.2),
            ):
                panel.plot(SPEEDS, 1e6 * curve[:, 0], color=colour, lw=width, label=name)
            panel.fill_between(
                SPEEDS,
                0.0,
                1.0,
                where=down[:, 1] < 0.0,
                transform=panel.get_xaxis_transform(),
                color="0.93",
                label="flanks part, speed falling",
            )
            panel.set(title=f"{torque:g} N m: {1e6 * static:.1f} µm at rest")
            panel.set_xlabel("mesh frequency over resonance")
        panels[0].set_ylabel("deflection, rms about its mean [µm]")
        drawing.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return drawing


def main() -> None:
    """Sweep, print what was found, and write the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    default = Path(__file__).parents[1] / "docs" / "figures" / "resonance_sweep.png"
    parser.add_argument("--output", type=Path, default=default, help="where to write the figure")
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
            f"{torque:6g} N m  rests at {1e6 * static:5.1f} µm  peak, rms: "
            f"{1e6 * up[:, 0].max():5.1f} µm rising, {1e6 * down[:, 0].max():5.1f} µm falling"
            f"  two motions at: {where}"
        )
    output.parent.mkdir(parents=True, exist_ok=True)
    figure(curves).savefig(output)
    print(f"figure: {output}")


if __name__ == "__main__":
    main()
