"""The table of docs/limits.md: which analysis contains which excitation, each cell by computing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb

TABLE = Path(__file__).parents[3] / "docs" / "limits.md"
SPEED = 80.0
#: A place on each of two shafts of different speeds.
PLANES = ("rotor", "g2")


def machine(**changes: Any) -> gb.RotorSystem:
    """Build a motor that a coupling joins to a pair with friction and backlash."""
    lengths = {"motor": 0.3, "input": 0.4, "output": 0.5}
    tooth = {"module": 3e-3, "face_width": 0.03}
    parts: dict[str, Any] = {
        "shafts": [
            gb.Shaft(name, length=x, outer_diameter=0.05, elements=2) for name, x in lengths.items()
        ],
        "gears": [
            gb.Gear("g1", "input", 0.18, teeth=20, **tooth),
            gb.Gear("g2", "output", 0.22, teeth=40, **tooth),
        ],
        "meshes": [
            gb.Mesh(
                "g1",
                "g2",
                stiffness=2e8,
                damping_ratio=0.05,
                backlash=1e-4,
                friction=0.05,
                centre_line_angle=0.7,
            )
        ],
        "couplings": [
            gb.Coupling(
                ("motor", 0.3),
                ("input", 0.0),
                torsional_stiffness=1e4,
                lateral_stiffness=1e6,
                tilting_stiffness=1e3,
            )
        ],
        "disks": [gb.Disk("rotor", "motor", 0.15, 10.0, 0.02, 0.03)],
        "bearings": [
            gb.Bearing(name, x, stiffness=(1e8, 6e7), damping=1e3, dynamic_rating=3e4)
            for name, length in lengths.items()
            for x in (0.02, length - 0.03)
        ],
        "torques": [gb.Torque("rotor", 100.0), gb.Torque.balance("g2")],
        "forces": [gb.Force(("output", 0.31), 0.0)],  # a place of a load is a node
    }
    return gb.RotorSystem(**{**parts, **changes})


def changed(part: str, index: int, **fields: Any) -> dict[str, Any]:
    """Give one part other fields."""
    parts = list(getattr(machine(), part))
    parts[index] = replace(parts[index], **fields)
    return {part: parts}


def error(**harmonics: Any) -> dict[str, Any]:
    return changed("meshes", 0, error=gb.TransmissionError(**harmonics))


def torque(value: Any) -> dict[str, Any]:
    return {"torques": [*machine().torques[:1], gb.Torque("rotor", value), machine().torques[1]]}


def force(value: Any, order: float | None = None) -> dict[str, Any]:
    return {"forces": [gb.Force(("output", 0.31), value, order=order)]}


TIMES = gb.TimeSeries([0.0, 0.002, 0.004, 1.0], [0.0, 100.0, 0.0, 0.0])
#: The rows of the table; a bow or unbalance on a shaft whose own bow is not sought.
ROWS: dict[str, dict[str, Any]] = {
    "bow": changed("shafts", 2, bow=gb.Bow.half_sine(2e-5)),
    "unbalance": changed("gears", 1, unbalance=2e-3),
    "run-out of gears": changed("gears", 1, runout=2e-5),
    "run-out of couplings": changed("couplings", 0, runout=1e-4),
    "forces of order 1": force(300.0, 1.0),
    "forces of other orders": force(300.0, 2.0),
    "transmission errors of order 1": error(driven=[(2e-5, 0.3)]),
    "other transmission errors": error(tooth=[(5e-6, 0.0)]),
    "loads over time": force(TIMES),
    "constant forces": force(-500.0j),
    "constant torques": changed("torques", 0, value=150.0),
    "gravity": {"gravity": (0.0, -9.81)},
    "misalignment of couplings": changed("couplings", 0, offset=2e-4, angle=1e-3j),
}


def of_bow_limits(system: gb.RotorSystem) -> tuple[np.ndarray, str]:
    probe = gb.BowLimit.bearing_force(("input", 0.02), 4e3)
    found = system.bow_limits("input", SPEED, shape=gb.Bow.half_sine(1.0), limits=[probe])
    return np.array([one.bow for one in found.found]), str(found)


def of_balance(system: gb.RotorSystem) -> tuple[np.ndarray, str]:
    # a balance contains what turns with the shaft of its planes
    found = [system.balance([plane], SPEED, points=[plane]) for plane in PLANES]
    return np.concatenate([one.unbalances for one in found]), str(found[0])


def of_thermal_bow(system: gb.RotorSystem) -> tuple[np.ndarray, str]:
    found = [
        system.thermal_bow(gb.ThermalBow(at, 1e5, 100.0, shape=gb.Bow.half_sine(1e-6)), [SPEED])
        for at in PLANES
    ]
    return np.concatenate([one.vibration for one in found]), str(found[0])


def of_identify(system: gb.RotorSystem) -> tuple[np.ndarray, str]:
    probes = [gb.Probe("motor", 0.15), gb.Probe("output", 0.3)]
    measured = gb.Measurement([60.0, SPEED], [[5e-5, 2e-5j], [6e-5, 1e-5]], probes)
    # an unknown would replace the unbalance of a gear
    unknowns = [gb.unknown.unbalance(plane) for plane in ("rotor", ("output", 0.31))]
    found = gb.identify(system, measured, unknowns, runout=False, noise=1e-6)
    assert found.balance("rotor", SPEED).left_out == found.left_out
    return found.values, str(found)


def of_frequency_response(system: gb.RotorSystem) -> tuple[np.ndarray, str]:
    sources = [gb.ShaftExcitation(shaft.name) for shaft in system.shafts]
    found = system.frequency_response(order=1.0, speeds=[SPEED], source=sources)
    return found.phasors, str(found)


def of_steady_state(system: gb.RotorSystem) -> tuple[np.ndarray, str]:
    # The period is two turns of the input shaft. With linear teeth, the motion is periodic after a few periods.
    meshes = [replace(mesh, backlash=None, friction=None) for mesh in system.meshes]
    found = system.replace(meshes=meshes).steady_state(
        SPEED, geometry="frozen", period=4.0 * np.pi / SPEED, record=["gears", "rotor"]
    )
    places = ("g1", "g2", "rotor")
    return np.concatenate([found.response.displacement(place) for place in places]), ""


def of_run(system: gb.RotorSystem) -> tuple[np.ndarray, str]:
    run = system.simulate(0.01, SPEED, initial="static", record=["g1", "rotor"])
    return np.concatenate([run.displacement("g1"), run.displacement("rotor")]), ""


#: The columns: the numbers of a result, and its printed text.
COLUMNS: dict[str, Callable[[gb.RotorSystem], tuple[np.ndarray, str]]] = {
    "modes": lambda system: (system.modes(SPEED).frequencies_hz[:10], ""),
    "static": lambda system: (
        np.array([system.static(SPEED).displacement(one) for one in ("g1", "g2", "rotor")]),
        "",
    ),
    "bearing_life": lambda system: ((found := system.bearing_life(SPEED)).hours, str(found)),
    "efficiency": lambda system: (
        (found := system.efficiency(SPEED)).loss,
        str(found),
    ),
    "synchronous": lambda system: ((found := system.synchronous(SPEED)).amplitudes, str(found)),
    "bow_limits": of_bow_limits,
    "balance": of_balance,
    "thermal_bow": of_thermal_bow,
    "identify": of_identify,
    "frequency_response": of_frequency_response,
    "steady_state": of_steady_state,
    "simulate": of_run,
}


def cells() -> dict[str, dict[str, str]]:
    """Read the table of the document."""
    lines = TABLE.read_text(encoding="utf-8").split("| excitation |")[1].split("\n\n")[0]
    head, _, *rows = [
        [cell.strip() for cell in line.strip(" |").split("|")] for line in lines.splitlines()
    ]
    names = [name.strip("`") for name in head]
    return {row[0]: dict(zip(names, row[1:], strict=True)) for row in rows}


def test_the_table_has_every_excitation_and_analysis():
    found = cells()
    assert list(found) == list(ROWS)
    assert all(list(row) == list(COLUMNS) for row in found.values())


@pytest.mark.implausible
@pytest.mark.parametrize("analysis", COLUMNS)
def test_each_cell_says_what_an_analysis_does(analysis: str):
    compute, wrong = COLUMNS[analysis], {}
    without, _ = compute(machine())
    for name, changes in ROWS.items():
        try:
            values, text = compute(machine(**changes))
        except gb.GearbowError:
            found = "error"
        else:
            # Round-off changes a result by 1e-9, each of these excitations by more than 1e-5.
            with np.errstate(invalid="ignore"):
                same = values.shape == without.shape and np.allclose(
                    values,
                    without,
                    rtol=1e-7,
                    atol=1e-7 * np.abs(without[np.isfinite(without)]).max(initial=1e-9),
                )
            named = name in text.partition("excitation left out")[2]
            found = "yes" if not same else "named" if named else "–"
        if found != cells()[name][analysis]:
            wrong[name] = found
    assert not wrong
