"""Run options: unusable options are errors, and a loose tolerance is still stable."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference.bows import HalfSine
from reference.cases import each_case
from reference.scenes import PAIR, Geared

DEMO = Geared(bows={"input": HalfSine(1.5e-4), "middle": HalfSine(1.5e-4, 0.8)}, angles=(0.4, -1.1))


@each_case(
    "options",
    [
        {"method": "euler"},
        {"geometry": "still"},
        {"initial": "warm"},
        {"step": -1e-6, "method": "rk4"},
        {"step": 0.0, "method": "rk4"},
        {"step": np.nan, "method": "rk4"},
        {"rtol": -1e-6, "method": "rk45"},
        {"rtol": np.nan, "method": "rk45"},
        {"output_step": 1e-4, "times": [1e-4]},
        {"output_step": -1e-4},
        {"output_step": 0.0},
        {"times": [np.nan]},
        {"times": [2.0]},  # after the end
        {"times": [-1e-4]},  # before the start
        {"record": ("g9",)},
        {"record": ("noise",)},
    ],
    ids=lambda o: " ".join(f"{k}={v}" for k, v in o.items()),
)
def test_an_unusable_option_is_an_error(options: dict[str, object]):
    with pytest.raises(gb.GearbowError):
        DEMO.package().simulate(1e-3, 100.0, **options)


@each_case(
    ("duration", "speed"),
    [(-1.0, 1.0), (np.nan, 1.0), (np.inf, 1.0), (1e-3, np.nan), (1e-3, np.inf)],
)
def test_impossible_duration_and_speed(duration: float, speed: float):
    with pytest.raises(gb.GearbowError):
        DEMO.package().simulate(duration, speed)


def test_a_run_records_what_its_system_has():
    plain = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=2)
    bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=500.0) for x in (0.0, 1.0)]
    disk = gb.Disk("disk", "rotor", 0.5, 20.0, 0.1, 0.2)
    nodes = [("rotor", x) for x in (0.0, 0.5, 1.0)]
    forces = [("bearing", "rotor", x) for x in (0.0, 1.0)]
    cases = [
        (DEMO.package(), ["g1", "g2", "g3", "g4", ("g1", "g2"), ("g3", "g4")]),
        (gb.RotorSystem([plain], bearings=bearings, disks=[disk]), ["disk", *forces]),
        (gb.RotorSystem([plain], bearings=bearings), [*nodes, *forces]),
        (gb.RotorSystem([plain], disks=[disk], motion="torsion"), ["disk"]),
        (gb.RotorSystem([plain], motion="torsion"), nodes),
    ]
    for system, expected in cases:
        assert system.simulate(1e-4, 100.0, initial="rest").recorded == expected
        assert system.simulate(1e-4, 100.0, initial="rest", record=[]).recorded == []
    _, (rotor, _), *_ = cases
    rotor = rotor.replace(disks=[gb.Disk("disk", "rotor", 0.5, 20.0, 0.1, 0.2, unbalance=1e-4)])
    assert rotor.steady_state(100.0).response.recorded == ["disk", *forces]


def test_times_in_any_order_and_twice():
    system = DEMO.package()
    times = [5e-4, 1e-4, 1e-4, 3.3e-4, 0.0]
    found = system.simulate(5e-4, 100.0, times=times, method="rk4")
    assert np.array_equal(found.time, times)
    u = found.displacement("g1")
    assert np.array_equal(u[1], u[2])
    ordered = system.simulate(5e-4, 100.0, times=sorted(set(times)), method="rk4")
    assert np.array_equal(u[[4, 1, 3, 0]], ordered.displacement("g1"))


def test_a_step_above_the_stability_limit_is_refused_with_the_reason():
    scene = replace(PAIR, elements=4)
    # a shoulder of 2 mm determines the limit, not the speed
    shaft = gb.Shaft(
        "input",
        segments=[
            gb.Segment(length=0.25, outer_diameter=0.05, elements=2),
            gb.Segment(length=0.002, outer_diameter=0.06),
            gb.Segment(length=0.248, outer_diameter=0.05, elements=2),
        ],
    )
    package = scene.package()
    system = gb.RotorSystem(
        shafts=[shaft, package.shafts[1]],
        gears=package.gears,
        meshes=package.meshes,
        bearings=package.bearings,
        torques=package.torques,
    )
    omega = system.simulate(1e-6, 10.0, method="rk4", times=[0.0]).statistics.omega_max
    limit = 2.828 / omega
    matrices = system.matrices()
    scale = 1 / np.sqrt(np.diag(matrices.mass))
    # the highest frequency is that of the matrices, by another solver
    low = np.linalg.inv(np.linalg.cholesky(matrices.mass * np.outer(scale, scale)))
    squares = np.linalg.eigvalsh(low @ (matrices.stiffness * np.outer(scale, scale)) @ low.T)
    assert omega == pytest.approx(np.sqrt(squares[-1]), rel=1e-3)

    with pytest.raises(gb.StabilityError) as caught:
        system.simulate(1.0, 10.0, method="rk4", step=1.05 * limit)
    text = str(caught.value)
    numbers = [float(x) for x in re.findall(r"\d+\.?\d*(?:e[-+]?\d+)?", text)]
    # the message contains the highest frequency, the limit and the shortest element, in any unit
    # prefix
    for wanted in (omega, limit, 0.002):
        mantissas = [
            abs(x * 10.0**k / wanted - 1) for x in numbers if x for k in (-9, -6, -3, 0, 3, 6, 9)
        ]
        assert min(mantissas) < 2e-2, f"{wanted:g} is not in: {text}"
    assert "input" in text
    # far below the limit the run succeeds
    system.simulate(1e-4, 10.0, method="rk4", step=0.5 * limit)


@pytest.mark.parametrize("rtol", [1e-2, 1e-3])
def test_rk45_without_damping_stays_bounded_at_a_loose_tolerance(rtol: float):
    # the error control of an explicit method does not detect growth of the stiffest mode
    scene = replace(
        PAIR, bows={"input": HalfSine(1e-4)}, bearing_damping=0.0, mesh_damping_ratio=0.0
    )
    response = scene.package().simulate(
        0.1, 100.0, method="rk45", rtol=rtol, initial="rest", record=("nodes", "energy", "meshes")
    )
    energy = response.energy
    # the energy after a start from rest oscillates, but stays below a multiple of its first peak
    early = energy[response.time < 0.02].max()
    assert energy.max() < 3 * early
    assert np.abs(response.displacement(("input", 0.25))).max() < 10e-4


def test_overlapping_base_circles_end_a_run_with_mesh_and_time():
    # the gear moves by twice its bow of 5 mm; the gap of the base circles is 6.8 mm
    scene = replace(PAIR, bows={"input": HalfSine(5e-3)}, torque=0.0)
    with pytest.raises(gb.ContactError) as caught:
        scene.package().simulate(5e-3, 100.0, initial="rest", output_step=1e-5, method="rk45")
    text = str(caught.value)
    assert "g1" in text
    assert "g2" in text
    done = caught.value.response
    assert 0 < done.time[-1] < 5e-3
    # the motion is valid until just before the overlap
    closing = done.mesh(("g1", "g2")).centre_distance
    apart = scene.law(0).sum_of_radii
    assert np.isfinite(done.displacement("g1")).all()
    assert apart < closing[-1] < apart + 1e-3
    times = [float(x) for x in re.findall(r"\d+\.?\d*(?:e[-+]?\d+)?", text)]
    late = done.time[-1] + 2e-5
    assert any(done.time[-1] <= x * 10.0**-k <= late for x in times for k in (0, 3, 6)), text


def test_a_late_start_equals_an_early_start_with_rotated_shafts():
    # 1e8 rad of the first shaft: a late reduction of the angle loses 1e-8 rad
    begin, speed = 1e6, 100.0
    how = {"method": "rk4", "initial": "rest", "step": 5e-7}
    offsets = np.arange(21) * 2.0**-13  # sums with 1e6 are exact
    late = DEMO.package().simulate(2.6e-3, speed, start=begin, times=begin + offsets, **how)
    turned = {
        name: HalfSine(bow.amplitude, bow.phase + np.angle(np.exp(1j * ratio * speed * begin)))
        for (name, bow), ratio in zip(DEMO.bows.items(), DEMO.ratios, strict=False)
    }
    early = replace(DEMO, bows=turned).package().simulate(2.6e-3, speed, times=offsets, **how)
    for name in ("g1", "g2", "g3", "g4"):
        u = early.displacement(name)
        # one more rounding of the phases
        assert np.abs(late.displacement(name) - u).max() < 1e-10 * np.abs(u).max()
