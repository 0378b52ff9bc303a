"""Effect of moving gear centres on a mesh: stiffness models, separation, transmission error.

A pinion with 25 teeth drives a wheel with 50 teeth, module 3 mm. For each stiffness model the
script draws the mesh stiffness over two mesh cycles in three conditions: nominal centre distance,
a centre distance that is 0.3 mm larger as mounted, and a centre distance that a load increases by
0.3 mm. The script writes the figures of docs/mesh.md.
Run with ``python examples/mesh_models.py``.
"""

import argparse
import math
from pathlib import Path
from typing import Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import gearbow as gb
from gearbow import plotting

TEETH = (25, 50)
MODULE = 3e-3  # m
DISTANCE = MODULE * sum(TEETH) / 2  # nominal centre distance, m
OPENED = 3e-4  # increase of the centre distance, m
CYCLES = 2
ROWS = 1201  # output times
SLOW = 1.0  # rad/s: so slow that the response is quasi-static

MODELS = {
    "constant": gb.Stiffness.constant(3e8),
    "iso6336": gb.Stiffness.iso6336(),
    "square_sharp": gb.Stiffness.square(pair=2e8, engagement="sharp"),
    "square_smooth": gb.Stiffness.square(pair=2e8, engagement=0.2),
    "parabolic": gb.Stiffness.parabolic(pair=2.4e8, engagement=0.2),
    "potential_energy": gb.Stiffness.potential_energy(engagement=0.2),
    "table": gb.Stiffness.table([3.0e8, 3.4e8, 3.6e8, 3.1e8, 2.2e8, 2.0e8, 2.2e8, 2.6e8]),
    "fourier": gb.Stiffness.fourier(3e8, [7e7, 2e7], [0.0, 1.0]),
}


def pair(
    mesh: gb.Mesh,
    *,
    torque: float = 10.0,
    sideways: float = 0.0,
    motion: Literal["coupled", "torsion"] = "coupled",
) -> gb.RotorSystem:
    """Return the gear pair; `sideways` is an acceleration [m/s²] along the line of centres."""
    shafts = [gb.Shaft(name, length=0.2, outer_diameter=0.05) for name in ("input", "output")]
    # Stiff bearings hold the pinion; soft bearings let the wheel move.
    bearings = [
        gb.Bearing(shaft, x, stiffness=stiffness, damping=1e4)
        for shaft, stiffness in (("input", 1e9), ("output", 2e7))
        for x in (0.0, 0.2)
    ]
    return gb.RotorSystem(
        shafts=shafts,
        gears=[
            gb.Gear(name, shaft.name, 0.1, teeth, module=MODULE, face_width=0.03)
            for name, shaft, teeth in zip(("pinion", "wheel"), shafts, TEETH, strict=True)
        ],
        meshes=[mesh],
        bearings=bearings if motion == "coupled" else [],
        torques=[gb.Torque("pinion", torque), gb.Torque.balance("wheel")],
        gravity=(sideways, 0.0) if sideways else None,
        motion=motion,
    )


def over_cycles(system: gb.RotorSystem, speed: float = SLOW) -> tuple[gb.Response, float]:
    """Simulate a few mesh cycles; return the response and the duration of one cycle [s]."""
    cycle = 2.0 * math.pi / (TEETH[0] * speed)
    times = np.linspace(0.0, CYCLES * cycle, ROWS)
    return system.simulate(CYCLES * cycle, speed, times=times, initial="static"), cycle


def opened(stiffness: gb.Stiffness) -> dict[str, gb.results.MeshResponse]:
    """Simulate the mesh with nominal, with mounted larger and with loaded larger distance."""

    def mesh(more: float = 0.0) -> gb.Mesh:
        return gb.Mesh(
            "pinion",
            "wheel",
            stiffness=stiffness,
            damping_ratio=0.1,
            centre_distance=DISTANCE + more,
        )

    def distance(sideways: float) -> float:
        return pair(mesh(), sideways=sideways).static().mesh(("pinion", "wheel")).centre_distance

    pull = 1000.0 * OPENED / (distance(1000.0) - distance(0.0))
    systems = {
        "nominal": pair(mesh()),
        "mounted +0.3 mm": pair(mesh(OPENED)),
        "moved +0.3 mm": pair(mesh(), sideways=pull),
    }
    return {
        name: over_cycles(system)[0].mesh(("pinion", "wheel")) for name, system in systems.items()
    }


def stiffness_figure(meshes: dict[str, gb.results.MeshResponse]) -> Figure:
    """Draw the mesh stiffness against the mesh cycles."""
    with mpl.rc_context(plotting.STYLE):
        figure = Figure(figsize=(10.0, 3.6))
        panel = figure.subplots()
        cycles = np.linspace(0.0, CYCLES, ROWS)
        for (name, mesh), line in zip(meshes.items(), ("-", "-", "--"), strict=True):
            label = f"{name} (ε = {mesh.contact_ratio.mean():.2f})"
            panel.plot(cycles, 1e-6 * mesh.stiffness, line, label=label)
        panel.set(xlabel="mesh cycles", ylabel="stiffness [N/µm]", xlim=(0.0, CYCLES))
        panel.set_ylim(0.0, 1.1 * panel.get_ylim()[1])
        legend(figure, panel)
    return figure


def separation_figure(
    torque: float = 10.0, speed: float = 150.0, error: float = 2e-5, cycles: int = 8
) -> Figure:
    """Draw a lightly loaded mesh with backlash: separation and impacts of the flanks."""
    mesh = gb.Mesh(
        "pinion",
        "wheel",
        stiffness=gb.Stiffness.square(3e8),
        damping_ratio=0.05,
        backlash=1e-4,
        error=gb.TransmissionError(tooth=[(error, 0.0)]),
    )
    cycle = 2.0 * math.pi / (TEETH[0] * speed)
    response = pair(mesh, torque=torque, motion="torsion").simulate(
        cycles * cycle, speed, initial="static", output_step=cycle / 200, record=["meshes"]
    )
    found = response.mesh(("pinion", "wheel"))
    time = response.time / cycle
    with mpl.rc_context(plotting.STYLE):
        figure = Figure(figsize=(10.0, 6.0))
        above, below = figure.subplots(2, sharex=True)
        # The tooth error belongs to the driving flanks. The deflection is relative to them, so the
        # error shifts the limit at which the back flanks touch.
        behind = -(1e-4 + error * np.cos(2.0 * math.pi * time))
        above.fill_between(time, 1e6 * behind, 0.0, color="0.9", label="clearance")
        above.plot(time, 1e6 * found.deflection)
        above.set(ylabel="deflection [µm]")
        below.plot(time, 1e-3 * found.force)
        below.set(ylabel="force [kN]", xlabel="mesh cycles", xlim=(0.0, cycles))
        marks = {"contact": ("^", 1), "separation": ("v", 2), "back contact": ("s", 3)}
        for kind, (marker, colour) in marks.items():
            at = np.array([event.time for event in response.events if event.kind == kind]) / cycle
            below.plot(at, 0.0 * at, marker, color=plotting.PALETTE[colour], label=kind)
        figure.align_ylabels()
        legend(figure, above, below)
    return figure


def error_figure(torques: tuple[float, ...] = (1.0, 100.0, 200.0, 300.0)) -> Figure:
    """Draw the loaded transmission error, the lead of the pinion over the wheel."""
    error = gb.TransmissionError(tooth=[(5e-6, 0.0), (2e-6, 1.0)])
    with mpl.rc_context(plotting.STYLE):
        figure = Figure(figsize=(10.0, 3.8))
        panel = figure.subplots()
        for torque in torques:
            mesh = gb.Mesh(
                "pinion", "wheel", stiffness=MODELS["square_smooth"], damping_ratio=0.3, error=error
            )
            response, cycle = over_cycles(pair(mesh, torque=torque, motion="torsion"))
            radii = [MODULE * teeth / 2.0 * math.cos(math.radians(20.0)) for teeth in TEETH]
            ahead = radii[0] * response.twist("pinion") + radii[1] * response.twist("wheel")
            panel.plot(response.time / cycle, 1e6 * ahead, label=f"{torque:g} N m")
        panel.set(xlabel="mesh cycles", ylabel="loaded transmission error [µm]", xlim=(0.0, CYCLES))
        legend(figure, panel)
    return figure


def legend(figure: Figure, *panels: Axes) -> None:
    """Draw one legend for all panels above them."""
    handles, labels = zip(
        *(
            pair
            for panel in panels
            for pair in zip(*panel.get_legend_handles_labels(), strict=True)
        ),
        strict=True,
    )
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), fontsize=12.0)


def main() -> None:
    """Draw and save all figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    default = Path(__file__).parent.parent / "docs" / "figures"
    parser.add_argument("--output", type=Path, default=default, help="folder of the figures")
    output: Path = parser.parse_args().output

    output.mkdir(parents=True, exist_ok=True)
    figures = {f"mesh_{name}": stiffness_figure(opened(model)) for name, model in MODELS.items()}
    figures["mesh_separation"] = separation_figure()
    figures["mesh_error"] = error_figure()
    for name, figure in figures.items():
        figure.savefig(output / f"{name}.png", dpi=90)
        print(output / f"{name}.png")


if __name__ == "__main__":
    main()
