"""Draw the figures of docs/gearbox.md: a two-stage helical gearbox with its motor and housing.

Run with ``python examples/gearbox.py``. The script writes the figures to ``docs/figures``.
"""

from dataclasses import replace
from math import cos, pi, radians, tan
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import gearbow as gb
from gearbow import plotting

FIGURES = Path(__file__).parent.parent / "docs" / "figures"

POWER = 30e3  # W
SPEED = 1480.0 * pi / 30.0  # of the motor, rad/s
BOW = 3e-5  # of the intermediate shaft, m
DURATION = 0.6  # of a run, s
SKIPPED = 0.1  # its beginning, with the transient, s
POINT = "accelerometer"
STAGES = (("pinion 1", "wheel 1"), ("pinion 2", "wheel 2"))


def gearbox() -> gb.RotorSystem:
    """Return the motor, its coupling and the gearbox."""
    first: dict[str, Any] = {"module": 2.5e-3, "face_width": 0.04}
    second: dict[str, Any] = {"module": 3.5e-3, "face_width": 0.06}
    ball_6308: dict[str, Any] = {
        "elements": 8,
        "element_diameter": 0.01508,
        "pitch_diameter": 0.065,
        "clearance": 1e-5,
    }
    ball_6310: dict[str, Any] = {
        "elements": 8,
        "element_diameter": 0.01905,
        "pitch_diameter": 0.080,
        "clearance": 1e-5,
    }
    rollers: dict[str, Any] = {
        "elements": 13,
        "element_diameter": 0.016,
        "pitch_diameter": 0.081,
        "roller_length": 0.014,
    }
    film: dict[str, Any] = {"diameter": 0.08, "length": 0.06, "clearance": 5e-5, "viscosity": 0.07}
    thrust: dict[str, Any] = {"axial_stiffness": 1e8, "axial_damping": 1e3}
    on_housing: dict[str, Any] = {"damping": 500.0, "support": "housing"}
    return gb.RotorSystem(
        shafts=[
            gb.Shaft("motor", length=0.5, outer_diameter=0.06),
            gb.Shaft("input", segments=[gb.Segment(0.09, 0.038), gb.Segment(0.20, 0.048)]),
            gb.Shaft(
                "intermediate",
                segments=[gb.Segment(0.03, 0.05), gb.Segment(0.16, 0.06), gb.Segment(0.03, 0.05)],
                bow=gb.Bow.half_sine(BOW),
            ),
            gb.Shaft("output", segments=[gb.Segment(0.25, 0.08), gb.Segment(0.13, 0.07)]),
        ],
        disks=[
            gb.Disk("rotor", "motor", 0.25, 70.0, 0.50, 0.28, unbalance=1.1e-3),
            gb.Disk("flange", "output", 0.37, 18.0, 0.08, 0.12),
        ],
        gears=[
            gb.Gear("pinion 1", "input", 0.15, 23, **first, helix_angle=radians(20.0)),
            gb.Gear("wheel 1", "intermediate", 0.07, 61, **first, helix_angle=-radians(20.0)),
            gb.Gear("pinion 2", "intermediate", 0.145, 22, **second, helix_angle=-radians(12.0)),
            gb.Gear("wheel 2", "output", 0.155, 57, **second, helix_angle=radians(12.0)),
        ],
        meshes=[
            gb.Mesh(
                "pinion 1",
                "wheel 1",
                stiffness=gb.Stiffness.iso6336(),
                damping_ratio=0.07,
                backlash=1.2e-4,
                error=gb.TransmissionError(tooth=[(1.0e-6, 0.0), (0.4e-6, 1.0)]),
            ),
            gb.Mesh(
                "pinion 2",
                "wheel 2",
                stiffness=gb.Stiffness.iso6336(),
                damping_ratio=0.07,
                backlash=1.5e-4,
                error=gb.TransmissionError(tooth=[(1.5e-6, 0.0), (0.6e-6, 1.0)]),
            ),
        ],
        bearings=[
            gb.Bearing("motor", 0.05, stiffness=2e8, damping=500.0, **thrust),
            gb.Bearing("motor", 0.45, stiffness=2e8, damping=500.0),
            gb.RollingBearing("input", 0.10, **ball_6308, **on_housing),
            gb.RollingBearing("input", 0.28, **ball_6308, **on_housing, **thrust),
            gb.RollingBearing("intermediate", 0.02, **ball_6310, **on_housing, **thrust),
            gb.RollingBearing(
                "intermediate", 0.20, **rollers, clearance=3e-5, contact="roller", **on_housing
            ),
            gb.JournalBearing("output", 0.03, **film, film="finite", support="housing", **thrust),
            gb.JournalBearing("output", 0.21, **film, film="finite", support="housing"),
        ],
        couplings=[
            gb.Coupling(
                ("motor", 0.5),
                ("input", 0.0),
                axial_stiffness=5e5,
                lateral_stiffness=1e6,
                tilting_stiffness=500.0,
                torsional_stiffness=2e4,
                axial_damping=50.0,
                lateral_damping=50.0,
                tilting_damping=0.1,
                torsional_damping=5.0,
                offset=2e-4,
            )
        ],
        housings=[
            gb.Housing(
                "housing",
                mass=140.0,
                stiffness=(1.2e8, 2e8),
                damping=(5e3, 8e3),
                inertia=(4.5, 2.5, 4.5),
                position=(0.69, 0.12, 0.0),
                rotational_stiffness=(8e6, 3e6, 6e6),
                rotational_damping=(300.0, 100.0, 250.0),
                points={"accelerometer": (0.09, 0.13, 0.15)},
            )
        ],
        torques=[gb.Torque("rotor", POWER / SPEED), gb.Torque.balance("flange")],
        gravity=9.81,
        modal_damping=0.01,
        accuracy="draft",
    )


def straight(system: gb.RotorSystem) -> gb.RotorSystem:
    """Return the system without the bow of its shafts."""
    return system.replace(shafts=[replace(shaft, bow=None) for shaft in system.shafts])


def reference_radius(gear: gb.Gear) -> float:
    """Return the radius of the reference circle [m]."""
    return gear.teeth * (gear.module or 0.0) / (2.0 * cos(gear.helix_angle))


def tooth_forces(torque: float, gear: gb.Gear) -> tuple[float, float, float]:
    """Return tangential, radial and axial force at the reference circle of a gear [N].

    `torque` is that of its shaft [N m]; the pressure angle is 20°.
    """
    tangential = torque / reference_radius(gear)
    radial = tangential * tan(radians(20.0)) / cos(gear.helix_angle)
    return tangential, radial, tangential * tan(abs(gear.helix_angle))


def run(system: gb.RotorSystem) -> gb.Response:
    """Return a run at the operating speed."""
    return system.simulate(
        DURATION,
        SPEED,
        rtol=1e-4,
        output_step=1e-4,
        record=["gears", "meshes", "housings", "bearings", "acceleration"],
    )


def frequencies(modes: gb.results.Modes, orders: dict[str, float]) -> Figure:
    """Draw the natural frequencies with their damping, and the excitation frequencies [Hz]."""
    with mpl.rc_context(plotting.STYLE):
        drawing = Figure(figsize=(10.0, 5.0))
        panel = drawing.add_subplot()
        shown = (modes.frequencies_hz > 20.0) & (modes.frequencies_hz < 1300.0)
        panel.plot(modes.frequencies_hz[shown], 100.0 * modes.damping_ratios[shown], "ko")
        top = 1.1 * 100.0 * float(modes.damping_ratios[shown].max())
        for (name, frequency), colour in zip(orders.items(), plotting.PALETTE, strict=False):
            style = "--" if name.startswith("passing") else "-"
            panel.axvline(frequency, color=colour, ls=style, label=name)
        drawing.legend(loc="outside right upper")
        panel.set(xlabel="frequency [Hz]", ylabel="damping ratio of a mode [%]")
        panel.set(xlim=(0.0, 1300.0), ylim=(0.0, top))
    return drawing


def forces(response: gb.Response) -> Figure:
    """Draw the forces of both meshes and of the bearing beside pinion 2 over 0.1 s."""
    shown = (response.time >= 0.3) & (response.time <= 0.4)
    time = 1e3 * response.time[shown]
    with mpl.rc_context(plotting.STYLE):
        drawing = Figure(figsize=(10.0, 7.5))
        panels = drawing.subplots(3, 1, sharex=True)
        for panel, pair in zip(panels, STAGES, strict=False):
            panel.plot(time, 1e-3 * response.mesh(pair).force[shown], lw=0.8)
            panel.set(ylabel="force [kN]", title="mesh of " + " and ".join(pair))
        force = np.hypot(*response.bearing_force(("intermediate", 0.2))[shown].T)
        panels[2].plot(time, 1e-3 * force, lw=0.8)
        panels[2].set(ylabel="force [kN]", title="bearing beside pinion 2", xlabel="time [ms]")
    return drawing


def spectra(responses: dict[str, gb.Response]) -> Figure:
    """Draw displacement and acceleration of the accelerometer at the orders of the train."""
    with mpl.rc_context(plotting.STYLE):
        drawing = Figure(figsize=(10.0, 7.5))
        panels = drawing.subplots(2, 1, sharex=True)
        marks: list[dict[str, Any]] = [{"marker": "o", "mfc": "none", "ms": 9.0}, {"marker": "."}]
        for (name, response), colour, mark in zip(
            responses.items(), plotting.PALETTE, marks, strict=False
        ):
            options: dict[str, Any] = {"bearing_harmonics": 0, "skip_time": SKIPPED}
            moved = response.orders(POINT, "z", **options)
            felt = response.orders(gb.Accelerometer(POINT, angle=pi / 2.0), **options)
            style = {"color": colour, "label": name, "ls": "none", **mark}
            panels[0].semilogy(moved.frequencies_hz, 1e6 * np.abs(moved.amplitudes), **style)
            panels[1].semilogy(felt.frequencies_hz, np.abs(felt.amplitudes), **style)
        panels[0].set(ylabel="displacement z [µm]", ylim=(1e-5, 10.0))
        panels[1].set(ylabel="acceleration [m/s²]", ylim=(1e-5, 10.0))
        panels[1].set(xlabel="frequency [Hz]")
        panels[0].legend()
    return drawing


def excitation(system: gb.RotorSystem) -> dict[str, float]:
    """Return the mesh and ball-pass frequencies at the operating speed [Hz]."""
    turns = {
        shaft.name: abs(ratio) * SPEED / (2.0 * pi)
        for shaft, ratio in zip(system.shafts, system.speed_ratios, strict=True)
    }
    found = {}
    for n, gear in enumerate((system.gears[0], system.gears[2]), start=1):
        for harmonic in (1, 2):
            found[f"{harmonic}× mesh {n}"] = harmonic * gear.teeth * turns[gear.shaft]
    for bearing in system.bearings:
        if isinstance(bearing, gb.RollingBearing):
            kind = "rollers" if bearing.contact == "roller" else "balls"
            found[f"passing {kind}, {bearing.shaft}"] = (
                bearing.ball_pass_order * turns[bearing.shaft]
            )
    return found


def main() -> None:
    """Draw and save all figures."""
    system = gearbox()
    bent = run(system)
    figures = {
        "train": system.plot(),
        "frequencies": frequencies(system.modes(SPEED), excitation(system)),
        "forces": forces(bent),
        "spectra": spectra({"with the bow": bent, "without a bow": run(straight(system))}),
    }
    for name, figure in figures.items():
        figure.savefig(FIGURES / f"gearbox_{name}.png", dpi=80)


if __name__ == "__main__":
    main()
