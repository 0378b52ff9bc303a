"""Maps of a geared pair: mesh force over speed and bow, and over unbalance and bow phase.

Two steel shafts with 25 and 50 teeth run under a light load of 10 N m. A bow of the driving shaft
moves its gear once in a revolution, so that the mesh force fluctuates. Where the fluctuation
exceeds the mean force, the teeth separate. `gb.sweep` computes every point of a map in parallel.
The option --sobol also prints Sobol indices of the same measure; it needs SALib.
Run with ``python examples/map.py``.
"""

import argparse
import math
import time
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import gearbow as gb
from gearbow import plotting

MESH = ("pinion", "wheel")
SPEEDS = np.linspace(100.0, 1000.0, 31)  # of the input shaft, rad/s
BOWS = np.linspace(2e-5, 4e-4, 20)  # of the input shaft, m
UNBALANCES = np.linspace(0.0, 1e-3, 11)  # of the pinion, kg m
PHASES = np.linspace(0.0, 2.0 * math.pi, 17)  # of the bow, rad
SPEED, BOW = 600.0, 1e-4  # of the second map
TURNS = 5  # revolutions of the output shaft; all but the last one are the transient
#: Uncertain parameters: name, smallest and largest value.
UNCERTAIN = {
    "speed": (300.0, 700.0),
    "bow": (2e-5, 1e-4),
    "phase": (0.0, 2.0 * math.pi),
    "unbalance": (0.0, 1e-3),
}


def train(
    bow: float, speed: float = SPEED, phase: float = 0.0, unbalance: float = 0.0
) -> gb.RotorSystem:
    """Return the pair; `speed` has no effect on the system."""
    del speed
    bent = gb.Bow.half_sine(bow, phase=phase) if bow else None
    return gb.RotorSystem(
        shafts=[
            gb.Shaft("input", length=0.5, outer_diameter=0.04, bow=bent),
            gb.Shaft("output", length=0.5, outer_diameter=0.05),
        ],
        gears=[
            gb.Gear(
                "pinion",
                "input",
                position=0.2,
                teeth=25,
                module=3e-3,
                face_width=0.03,
                unbalance=unbalance,
            ),
            gb.Gear("wheel", "output", position=0.2, teeth=50, module=3e-3, face_width=0.03),
        ],
        meshes=[gb.Mesh(*MESH, stiffness=2e8, damping_ratio=0.05, backlash=4e-4)],
        bearings=[
            gb.Bearing(shaft, position=x, stiffness=1e8, damping=2e3)
            for shaft in ("input", "output")
            for x in (0.0, 0.5)
        ],
        torques=[gb.Torque("pinion", 10.0), gb.Torque.balance("wheel")],
    )


def force(system: gb.RotorSystem, speed: float = SPEED, **_: Any) -> dict[str, float]:
    """Return amplitude and smallest value of the mesh force [N] over the last revolution."""
    turn = 2.0 * math.pi / (speed * float(np.abs(system.speed_ratios).min()))
    times = (TURNS - 1 + np.linspace(0.0, 1.0, 1001)[:-1]) * turn
    response = system.simulate(TURNS * turn, speed, times=times, record=["meshes"])
    values = response.mesh(MESH).force
    return {"amplitude": float(np.ptp(values)) / 2.0, "smallest": float(values.min())}


def heat_map(panel: Axes, sweep: gb.Sweep, scales: dict[str, tuple[str, float]], norm: str) -> Any:
    """Draw the amplitude over two parameters; `scales` gives label and unit of each.

    A line surrounds the points at which the teeth separate.
    """
    (y, (y_label, y_unit)), (x, (x_label, x_unit)) = scales.items()
    across, up = (
        np.array(sweep.parameters[name]) / unit for name, unit in ((x, x_unit), (y, y_unit))
    )
    wanted = sweep.to_xarray().squeeze().transpose(y, x)
    colours = panel.pcolormesh(across, up, wanted["amplitude"], norm=norm, rasterized=True)
    apart = np.asarray(wanted["smallest"]) <= 0.0
    if apart.any():
        panel.contour(across, up, apart.astype(float), [0.5], colors="w", linewidths=2.0)
    panel.set(xlabel=x_label, ylabel=y_label)
    panel.grid(visible=False)
    return colours


def figure(over_speed: gb.Sweep, over_unbalance: gb.Sweep) -> Figure:
    """Draw both maps."""
    with mpl.rc_context(plotting.STYLE):
        drawing = Figure(figsize=(13.0, 5.0), layout="constrained")
        left, right = drawing.subplots(1, 2)
        bow, speed = ("bow [µm]", 1e-6), ("speed of the input shaft [rad/s]", 1.0)
        phase, unbalance = ("phase of the bow [°]", math.pi / 180.0), ("unbalance [g m]", 1e-3)
        for panel, sweep, scales, norm, title in (
            (left, over_speed, {"bow": bow, "speed": speed}, "log", "without unbalance"),
            (
                right,
                over_unbalance,
                {"phase": phase, "unbalance": unbalance},
                "linear",
                f"bow of {1e6 * BOW:g} µm at {SPEED:g} rad/s",
            ),
        ):
            colours = heat_map(panel, sweep, scales, norm)
            drawing.colorbar(colours, ax=panel, label="amplitude of the mesh force [N]")
            panel.set_title(title)
    return drawing


def first_loss(sweep: gb.Sweep) -> str:
    """Return for some speeds the smallest bow at which the teeth separate."""
    apart = sweep.values("smallest") <= 0.0
    lines = ["| speed [rad/s] | smallest bow with loss of contact [µm] |", "|---|---|"]
    for row, speed in zip(apart[::4], sweep.parameters["speed"][::4], strict=True):
        bows = np.array(sweep.parameters["bow"])[row]
        lines.append(f"| {speed:g} | {f'{1e6 * bows.min():g}' if bows.size else 'none'} |")
    return "\n".join(lines)


def sobol(count: int) -> str:
    """Return the Sobol indices of the amplitude over the uncertain parameters."""
    from SALib.analyze import sobol as indices  # noqa: PLC0415  # an optional library
    from SALib.sample import sobol as sample  # noqa: PLC0415

    problem = {
        "num_vars": len(UNCERTAIN),
        "names": list(UNCERTAIN),
        "bounds": [list(bounds) for bounds in UNCERTAIN.values()],
    }
    values = sample.sample(problem, count, calc_second_order=False, seed=1)
    points = [dict(zip(UNCERTAIN, row, strict=True)) for row in values]
    found = gb.sweep(train, points, force).values("amplitude")
    result = indices.analyze(problem, found, calc_second_order=False, seed=1)
    lines = ["| parameter | first order | total |", "|---|---|---|"]
    for i, name in enumerate(UNCERTAIN):
        entries = [(result[kind][i], result[f"{kind}_conf"][i]) for kind in ("S1", "ST")]
        cells = " | ".join(f"{value:.2f} ± {half:.2f}" for value, half in entries)
        lines.append(f"| {name} | {cells} |")
    lines.append(f"\n{len(points)} runs")
    return "\n".join(lines)


def main() -> None:
    """Compute the maps, print the results and save the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    default = Path(__file__).parents[1] / "docs" / "figures" / "map.png"
    parser.add_argument("--output", type=Path, default=default, help="file of the figure")
    parser.add_argument("--sobol", type=int, metavar="N", help="print Sobol indices only")
    given = parser.parse_args()
    begin = time.process_time()
    if given.sobol:
        print(sobol(given.sobol))
    else:
        over_speed = gb.sweep(train, {"speed": SPEEDS, "bow": BOWS}, force)
        grid: dict[str, Any] = {"unbalance": UNBALANCES, "phase": PHASES, "bow": [BOW]}
        over_unbalance = gb.sweep(train, grid, force)
        print(first_loss(over_speed))
        print(f"\n{len(over_speed) + len(over_unbalance)} runs")
        output: Path = given.output
        output.parent.mkdir(parents=True, exist_ok=True)
        figure(over_speed, over_unbalance).savefig(output)
    print(f"in {time.process_time() - begin:.0f} s of CPU time")


if __name__ == "__main__":
    main()
