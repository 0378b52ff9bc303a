"""Friction between the flanks: loss, force, moments, and the power that it dissipates."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.bows import HalfSine
from reference.cases import each_case
from reference.friction import FrictionLaw, helical_loss, ohlendorf
from reference.machines import helical_pair, hostile, pair
from reference.teeth import Equations, Toothed, integrate

MESH = ("pinion", "wheel")
SHARP = gb.Stiffness.square(pair=2e8, engagement="sharp")
SMOOTH = gb.Stiffness.square(pair=2e8)
THIN = 1e-6  # transition [base pitches] whose effect on a loss is below 1e-11


def mu(coefficient: float = 0.05, transition: float = THIN) -> gb.MeshFriction:
    return gb.MeshFriction(coefficient, transition=transition)


def gears(
    friction: Any = None,
    stiffness: Any = SHARP,
    torque: float = 100.0,
    teeth: tuple[int, int] = (25, 50),
    helix: float = 0.0,
    **more: Any,
) -> gb.RotorSystem:
    own = {MESH[0]: {"helix_angle": helix}, MESH[1]: {"helix_angle": -helix}}
    for name, given in more.pop("own", {}).items():
        own[name] = {**own.get(name, {}), **given}
    return pair(
        ("input", "output"),
        MESH,
        teeth,
        shaft={"length": 0.2, "outer_diameter": 0.05, "elements": 2, "degree": 1},
        position=0.1,
        mesh={"stiffness": stiffness, "damping_ratio": 0.1, "friction": friction}
        | more.pop("mesh", {}),
        bearing={"stiffness": 1e9, "damping": 1e4, "axial_stiffness": 1e9 if helix else 0.0},
        torque=torque,
        own=own,
        **more,
    )


def work(response: gb.Response, name: str = "friction_power") -> float:
    return float(np.trapezoid(getattr(response.mesh(MESH), name), response.time))


@pytest.mark.parametrize("teeth", [(25, 50), (17, 17), (40, 23)])
@pytest.mark.parametrize("stiffness", [SHARP, 2e8, gb.Stiffness.fourier(2e8, [2e7])])
def test_loss_of_spur_gears_is_that_of_ohlendorf(teeth: tuple[int, int], stiffness: Any):
    found = gears(mu(), stiffness, teeth=teeth).efficiency(100.0, geometry="frozen")
    tips = (teeth[0] / 2 + 1.0, teeth[1] / 2 + 1.0)
    expected = ohlendorf(teeth, np.radians(20.0), tips)
    # the rule over the mesh cycle is exact up to round-off, the transition below 1e-11
    assert found.loss_factor[0, 0] == pytest.approx(expected, rel=1e-9)
    assert found.efficiency[0] == pytest.approx(1.0 - 0.05 * expected, rel=1e-10)
    assert found.power[0, 0] == pytest.approx(100.0 * 100.0, rel=1e-9)
    assert found.input_power[0] == pytest.approx(100.0 * 100.0, rel=1e-12)


def test_published_example():
    """25/50 teeth of 20°: ε₁ 0.805826, ε₂ 0.877337, H_v 0.138716, loss 0.6936 % at μ = 0.05."""
    loss_factor = ohlendorf((25, 50), np.radians(20.0), (13.5, 26.0))
    assert loss_factor == pytest.approx(0.138716, abs=5e-7)
    found = gears(mu()).efficiency(100.0, geometry="frozen")
    assert 1.0 - found.efficiency[0] == pytest.approx(0.006936, abs=5e-7)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(
    ("stiffness", "helix"),
    [(SHARP, 0.0), (gb.Stiffness.parabolic(2e8), 0.0), (2e8, 0.0), (SHARP, 0.5), (2e8, 0.3)],
)
def test_slow_run_of_stiff_teeth_dissipates_the_loss(stiffness: Any, helix: float, sense: float):
    # 0.1 µm of deflection; larger ones change the sliding velocities
    friction = mu(1e-3, 0.1)
    system = gears(friction, stiffness, 1.0 * sense, helix=helix, mesh={"damping_ratio": 0.7})
    period = 2 * np.pi / 25
    times = np.linspace(2 * period, 3 * period, 8001)
    run = system.simulate(
        3 * period, sense, times=times, initial="static", geometry="frozen", record=[MESH]
    )
    found = system.efficiency(sense, geometry="frozen")
    # the deflection of 7e-8 m varies over some 1e-4 m of the path: 1e-4 of the sliding velocity
    assert work(run) / period == pytest.approx(found.loss[0, 0], rel=2e-4)
    assert work(run) / period / (1.0 * 1.0) == pytest.approx(1.0 - found.efficiency[0], rel=2e-4)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_friction_changes_its_direction_at_the_pitch_point(sense: float):
    # one tooth pair has the whole force in the middle of the cycle
    system = gears(mu(0.05, 0.02), SHARP, 100.0 * sense)
    period = 2 * np.pi / 25
    times = np.linspace(0.0, period, 2001)
    run = system.simulate(
        period, sense, times=times, initial="static", geometry="frozen", record=[MESH]
    )
    mesh = run.mesh(MESH)
    base = [0.0015 * z * np.cos(np.radians(20.0)) for z in (25, 50)]
    pitch_point = base[0] * np.tan(np.radians(20.0))
    pitch = 2 * np.pi * base[0] / 25
    # position of the pair next to the pitch point, from the angle of the driver
    s = base[0] * (times + np.radians(20.0))
    s = (s - pitch_point + pitch / 2) % pitch - pitch / 2
    alone = (mesh.pairs_in_contact == 1) & (np.abs(s) > 0.011 * pitch)
    # approach pushes the driven gear along m, which points to the tangent point of the driver; recess
    # pulls it back
    expected = -np.sign(s) * 0.05 * mesh.force
    assert alone.sum() > 500
    assert mesh.friction_force[alone] == pytest.approx(expected[alone], rel=1e-9)


CASES = {
    "sharp": ({"model": "square", "pair": 2e8, "engagement": "sharp", "phase": "prescribed"}, {}),
    "smooth": ({"model": "square", "pair": 2e8, "engagement": 0.2, "phase": "prescribed"}, {}),
    "twist": ({"model": "square", "pair": 2e8, "engagement": 0.2, "phase": "twist"}, {}),
    "frozen": (
        {"model": "square", "pair": 2e8, "engagement": 0.2, "phase": "prescribed"},
        {"geometry": "frozen"},
    ),
}


@pytest.mark.parametrize(
    ("case", "sense", "coupled"),
    [
        *((case, sense, False) for case in CASES for sense in (1.0, -1.0)),
        ("sharp", 1.0, True),
        ("smooth", -1.0, True),
        ("twist", 1.0, True),
        ("frozen", -1.0, True),
    ],
)
def test_motion_is_that_of_the_independent_model(case: str, sense: float, coupled: bool):
    stiffness, options = CASES[case]
    friction = {"coefficient": 0.1, "transition": 0.2}
    mesh = {"stiffness": stiffness, "damping_ratio": 0.05, "friction": friction}
    bows = {"a": HalfSine(2e-4, 0.7)} if coupled else {}
    scene = Toothed(mesh=mesh, torque=50.0 * sense, coupled=coupled, bows=bows)
    system = scene.package()
    # the damping ratio refers to the mean stiffness
    mean = system.static().mesh(("ga", "gb")).stiffness
    law = FrictionLaw(
        scene.law(sense, mean),
        pair=lambda _: 2e8,
        width=0.0 if stiffness["engagement"] == "sharp" else stiffness["engagement"],
        twist=stiffness["phase"] == "twist",
        live=not options,
        coefficient=0.1,
        transition=0.2,
    )
    # two mesh cycles
    speed, times = 800.0 * sense, np.linspace(0.0, 6.3e-4, 127)
    keeps = stiffness["phase"] != "twist"
    state, force = integrate(scene, law, speed, times, keep_rotation=keeps)
    select = Equations(scene, law.law).select  # type: ignore[attr-defined]
    half = state.shape[1] // 2
    own = (state[:, :half] @ select.T)[:, 5]
    # jumps of a sharp engagement limit SciPy's integrator; the exponential method with rtol 1e-8
    # keeps displacements to 1e-6, and forces of the stiff teeth less accurately
    limits = {"rk45": (1e-9, 1e-6, 1e-6), "exponential": (1e-8, 1e-5, 1e-6)}
    for method, (rtol, of_force, of_twist) in limits.items():
        jumps = 1e-4 if case == "sharp" else 0.0
        run = system.simulate(
            times[-1], speed, times=times, initial="rest", method=method, rtol=rtol, **options
        )
        found = run.mesh(("ga", "gb"))
        allowed = max(of_force, jumps) * np.abs(force).max()
        assert found.force == pytest.approx(force, abs=allowed), method
        allowed = max(of_twist, jumps) * np.abs(own).max()
        assert run.twist("gb") == pytest.approx(own, abs=allowed), method
    spins = np.array([speed, -speed / 2])
    for i in (30, 77, 126):
        q, v = select @ state[i, :half], select @ state[i, half:]
        on_b, _, power = law.friction(q, v, spins * times[i], spins, force[i])
        size, largest = (np.abs(getattr(found, f"friction_{x}")).max() for x in ("force", "power"))
        assert abs(found.friction_force[i]) == pytest.approx(np.hypot(*on_b), abs=1e-4 * size)
        assert found.friction_power[i] == pytest.approx(power, abs=1e-4 * largest)


ALL = {
    "tooth pairs": {"stiffness": SMOOTH},
    "mean": {"stiffness": 2e8},
    "shared bodies": {"stiffness": gb.Stiffness.potential_energy(foundation="shared")},
    "relief": {"stiffness": SMOOTH, "mesh": {"tip_relief": gb.TipRelief(15e-6, 3e-3)}},
    "backlash": {"stiffness": SMOOTH, "torque": 2.0, "mesh": {"backlash": 1e-5}},
    "twist": {"stiffness": gb.Stiffness.square(pair=2e8, phase="twist")},
    "back flank": {"stiffness": SMOOTH, "torque": -100.0},
    "run-out": {"stiffness": SMOOTH, "own": {"pinion": {"runout": 2e-5}}},
    "oil": {"stiffness": SMOOTH, "friction": gb.MeshFriction(viscosity=0.02, roughness=8e-7)},
}


@pytest.mark.parametrize("case", ALL)
def test_energy_balance_closes(case: str):
    system = gears(**{"friction": 0.1, **ALL[case]})
    record: list[Any] = [MESH, "energy"]
    run = system.simulate(5e-3, 100.0, initial="static", output_step=5e-6, rtol=1e-8, record=record)
    balance = run.energy_balance()
    taken = -balance.damping[-1]
    assert np.abs(balance.residual).max() < 1e-7 * taken
    # apart from the damping of the vibration, friction dissipates; the drive supplies it
    assert 0.5 * taken < work(run) <= taken * (1 + 1e-6)


def test_audit_of_helical_gears_and_a_ramp():
    system = helical_pair(mesh={"friction": 0.1, "stiffness": SMOOTH})
    ramp = gb.SpeedProfile.ramp(100.0, 140.0, duration=0.01)
    run = system.simulate(0.01, ramp, rtol=1e-8, record=["meshes", "energy"])
    balance = run.energy_balance()
    assert np.abs(balance.residual).max() < 1e-6 * np.abs(balance.damping[-1])
    same = system.simulate(0.01, ramp, rtol=1e-8, record=["meshes"], method="rk45")
    for name in ("force", "friction_force", "friction_power"):
        one, other = (getattr(each.mesh(("g1", "g2")), name) for each in (run, same))
        # errors of both methods at 1e-8
        assert one == pytest.approx(other, abs=1e-5 * np.abs(other).max()), name


def test_no_friction_and_zero_are_the_same():
    none, zero, table = (gears(friction) for friction in (None, 0.0, mu(0.0)))
    runs = [each.simulate(2e-3, 100.0) for each in (none, zero, table)]
    for other in runs[1:]:
        for name in ("force", "deflection", "friction_force", "friction_power"):
            own = [getattr(run.mesh(MESH), name) for run in (runs[0], other)]
            assert np.array_equal(*own), name
    assert not np.any(runs[0].mesh(MESH).friction_force)


def test_standing_teeth_have_no_friction():
    run = gears(0.1).simulate(1e-3, 0.0, initial="rest")
    same = gears().simulate(1e-3, 0.0, initial="rest")
    assert run.mesh(MESH).force == pytest.approx(same.mesh(MESH).force, rel=1e-9, abs=1e-6)
    assert not np.any(run.mesh(MESH).friction_force)


@pytest.mark.parametrize("stiffness", [gb.Stiffness.square(pair=2e8, engagement="sharp"), 2e8])
@pytest.mark.parametrize("helix", [8.0, 20.0, 30.0])
def test_loss_of_helical_gears(helix: float, stiffness: Any):
    system = helical_pair(
        np.radians(helix), mesh={"friction": mu(), "stiffness": stiffness}
    ).replace(gravity=None)
    found = system.efficiency(100.0, geometry="frozen")
    a, b = system.gears
    angle = np.arctan(np.tan(np.radians(20.0)) / np.cos(np.radians(helix)))
    radius = [0.5 * g.teeth * g.module / np.cos(np.radians(helix)) for g in (a, b)]
    base = [r * np.cos(angle) for r in radius]
    tips = [
        np.sqrt((r + g.module) ** 2 - c**2) for r, g, c in zip(radius, (a, b), base, strict=True)
    ]
    line = (base[0] + base[1]) * np.tan(angle)
    pitch = 2 * np.pi * base[0] / a.teeth
    tan_base = np.tan(np.radians(helix)) * np.cos(angle)
    overlap = min(a.face_width, b.face_width) * tan_base
    reach = (max(line - tips[1], 0.0), min(tips[0], line), base[0] * np.tan(angle))
    mean = helical_loss(reach, pitch, overlap)
    # normal force over transverse force, and the sliding velocity over that of the base circle
    expected = np.hypot(1.0, tan_base) * mean * (1 / base[0] + 1 / base[1])
    # 4000 sections of 200 positions
    assert found.loss_factor[0, 0] == pytest.approx(expected, rel=1e-3)


def test_loss_of_a_bowed_train_varies_over_a_revolution_with_its_centres():
    bow = {"input": {"bow": gb.Bow.half_sine(2e-4)}}
    system = gears(0.05, SMOOTH, own=bow, mesh={"damping_ratio": 0.7})
    speed, revolution = 10.0, 2 * np.pi / 10.0
    times = np.linspace(revolution, 2 * revolution, 25 * 200 + 1)
    varies = {}
    for geometry in ("live", "frozen"):
        run = system.simulate(2 * revolution, speed, times=times, geometry=geometry, record=[MESH])
        power = run.mesh(MESH).friction_power[:-1].reshape(25, 200).mean(axis=1)
        varies[geometry] = np.ptp(power) / power.mean()
    # 0.2 mm of bow shift the ends of the path by 0.2 mm/sin 20° each way, which is 0.066 base pitches:
    # the sum e1² + e2² − e1 − e2 + 1 of 0.736 varies by 2 × 0.066 (e1 + e2 − 1) = 0.09
    assert varies["live"] == pytest.approx(0.12, abs=0.02)
    # only the mesh force varies
    assert varies["frozen"] < 0.01


def test_steady_state_is_the_settled_run():
    system = gears(0.05, SMOOTH, mesh={"damping_ratio": 0.7})
    state = system.steady_state(100.0)
    run = system.simulate(0.1, 100.0, initial="static", record=[MESH], output_step=1e-5)
    late = run.time > 0.1 - 4 * 2 * np.pi / 2500
    steady, settled = state.response.mesh(MESH), run.mesh(MESH)
    # samples of four periods at other instants
    mean = np.mean(settled.friction_power[late])
    assert np.mean(steady.friction_power[:-1]) == pytest.approx(mean, rel=1e-3)
    assert steady.force.max() == pytest.approx(settled.force[late].max(), rel=1e-4)


def test_a_drive_with_stiffness_supplies_the_loss():
    slips = {}
    for friction in (0.05, None):
        drives = [gb.Drive("pinion", stiffness=1e5, damping=50.0)]
        system = gears(friction, 2e8, mesh={"damping_ratio": 0.7}).replace(drives=drives)
        run = system.simulate(2.0, 100.0, initial="static", output_step=0.01)
        slips[friction] = run.twist("pinion")[-1]
    power = gears(0.05, 2e8).simulate(0.5, 100.0, output_step=0.01).mesh(MESH).friction_power[-1]
    # the mean sums over the mesh cycle make the settled loss constant; the torque of the drive changes
    # the mesh force by 1e-2 of itself at most
    assert 1e5 * (slips[None] - slips[0.05]) == pytest.approx(power / 100.0, rel=1e-2)


def test_without_a_drive_the_prescribed_rotation_is_kept():
    run = gears(0.05, SMOOTH).simulate(0.2, 100.0, initial="static", record=["gears"])
    # the loss of 70 W would slow the train of 0.01 kg m² down by 14 rad/s, and turn it by 1 rad
    assert np.ptp(run.twist("pinion")) < 1e-3


def test_a_train_that_follows_the_twist_slows_down():
    stiffness = gb.Stiffness.square(pair=2e8, phase="twist")
    run = gears(0.05, stiffness).simulate(
        0.05, 100.0, initial="static", record=["gears", MESH, "energy"]
    )
    assert run.twist("pinion")[-1] < -0.01
    with pytest.raises(gb.SceneError, match="mean torque accelerates"):
        gears(0.05, stiffness).steady_state(100.0)


def test_coefficient_of_lubricated_steel():
    """The formula of ISO/TR 14179-2, written out for spur gears 25/50 of module 3 mm."""
    oil = gb.MeshFriction(viscosity=0.02, roughness=0.8e-6, lubricant_factor=0.8)
    found = gears(oil, torque=300.0).efficiency([20.0, 100.0, 3000.0], geometry="frozen")
    angle = np.radians(20.0)
    for i, speed in enumerate((20.0, 100.0, 3000.0)):
        line_load = max(300.0 / (0.0375 * np.cos(angle)) / 1e3 / 0.03, 150.0)
        velocity = 2 * min(0.0375 * speed, 50.0) * np.sin(angle)
        radius = 1e3 * np.sin(angle) * 0.0375 * 0.075 / (0.0375 + 0.075)
        expected = 0.048 * (line_load / (velocity * radius)) ** 0.2 * 20.0**-0.05 * 0.8**0.25 * 0.8
        assert found.coefficient[i, 0] == pytest.approx(expected, rel=1e-9)
    slow = gears(oil).efficiency(1e-6)
    assert slow.coefficient[0, 0] == 0.2


@pytest.mark.parametrize("helix", [15.0, 30.0])
def test_coefficient_of_lubricated_helical_gears(helix: float):
    """The formula of ISO/TR 14179-2 with ρ_redC = a u sin α_wt/((1 + u)² cos β_b), in the plane normal to the flanks."""
    oil = gb.MeshFriction(viscosity=0.02, roughness=0.8e-6)
    system = helical_pair(np.radians(helix), mesh={"friction": oil}).replace(gravity=None)
    found = system.efficiency(100.0, geometry="frozen")
    a, b = system.gears
    transverse = np.arctan(np.tan(np.radians(20.0)) / np.cos(np.radians(helix)))
    base_helix = np.arcsin(np.sin(np.radians(helix)) * np.cos(np.radians(20.0)))
    radius = [0.5e3 * g.teeth * g.module / np.cos(np.radians(helix)) for g in (a, b)]
    ratio = b.teeth / a.teeth
    line_load = 200.0e3 / (radius[0] * np.cos(transverse)) / (1e3 * min(a.face_width, b.face_width))
    velocity = 2 * 100.0 * radius[0] * 1e-3 * np.sin(transverse)
    reduced = sum(radius) * ratio * np.sin(transverse) / (1 + ratio) ** 2 / np.cos(base_helix)
    expected = 0.048 * (line_load / (velocity * reduced)) ** 0.2 * 20.0**-0.05 * 0.8**0.25
    assert found.coefficient[0, 0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_efficiency_of_several_stages_adds_their_losses(sense: float):
    system = hostile()
    rough = [
        replace(mesh, friction=mu(c))
        for mesh, c in zip(system.meshes, (0.05, 0.08, 0.06), strict=True)
    ]
    found = system.replace(meshes=rough).efficiency([sense * 50.0, sense * 100.0])
    assert found.loss.shape == (2, 3)
    assert np.all(found.loss > 0.0)
    assert found.input_power == pytest.approx([150.0 * 50.0, 150.0 * 100.0], rel=1e-9)
    lost = found.loss.sum(axis=1) / found.input_power
    assert found.efficiency == pytest.approx(1.0 - lost, rel=1e-14)
    assert found.mesh_efficiency == pytest.approx(1.0 - found.loss / found.power, rel=1e-14)
    # every stage transmits the input power; the centres move little
    assert found.power == pytest.approx(np.repeat(found.input_power[:, np.newaxis], 3, 1), rel=1e-3)
    alone = system.replace(meshes=[rough[0], *system.meshes[1:]]).efficiency(sense * 100.0)
    assert alone.loss[0, 0] == pytest.approx(found.loss[1, 0], rel=1e-9)
    assert np.all(alone.loss[0, 1:] == 0.0)
    assert np.all(np.isnan(alone.loss_factor[0, 1:]))


@each_case(
    ("friction", "message"),
    [
        (-0.1, r"meshes\[0\]\.friction\.coefficient: must not be negative"),
        (float("nan"), r"friction\.coefficient: must be finite"),
        (gb.MeshFriction(), "needs either coefficient, or viscosity"),
        (gb.MeshFriction(0.1, viscosity=0.02), "needs either coefficient"),
        (gb.MeshFriction(viscosity=0.02), "needs either coefficient"),
        (gb.MeshFriction(0.1, lubricant_factor=0.8), "lubricant_factor: needs"),
        (gb.MeshFriction(0.1, transition=0.6), "at most half a base pitch"),
        (gb.MeshFriction(0.1, transition=0.0), "must be positive"),
    ],
)
def test_wrong_friction(friction: Any, message: str):
    with pytest.raises(gb.SceneError, match=message):
        gears(friction)


def test_torques_over_the_speed_supply_the_input_power():
    # The wheel drives with a torque over its speed, the pinion is held by a drive of its own.
    wheel = gb.Torque("wheel", gb.SpeedTable([0.0, 100.0], [120.0, 40.0]))
    hold = gb.Drive("pinion", stiffness=1e5)
    system = gears(mu(), torque=0.0, torques=[wheel], drives=[hold])
    speeds = np.array([-120.0, -50.0])
    found = system.efficiency(speeds, geometry="frozen")
    spins = speeds * system.speed_ratios[1]
    # 120 to 40 N m over 100 rad/s
    exact = (120.0 - 0.8 * spins) * spins
    assert found.input_power == pytest.approx(exact, rel=1e-9)
    assert found.efficiency == pytest.approx(1.0 - found.loss[:, 0] / exact, rel=1e-9)


def test_efficiency_needs_friction_and_motion():
    with pytest.raises(gb.SceneError, match="no mesh has friction"):
        gears().efficiency(100.0)
    with pytest.raises(gb.SceneError, match=r"speeds\[1\]: must not be zero"):
        gears(0.1).efficiency([1.0, 0.0])


def test_improbable_friction_gives_a_warning():
    with pytest.warns(gb.SceneWarning, match="coefficient of friction of a mesh"):
        gears(5.0)
    with pytest.warns(gb.SceneWarning, match="roughness of flanks"):
        gears(gb.MeshFriction(viscosity=0.02, roughness=0.8))


def test_descriptions_return(tmp_path: Any):
    for friction in (0.05, mu(0.05, 0.2), gb.MeshFriction(viscosity=0.02, roughness=8e-7)):
        system = gears(friction)
        path = tmp_path / "train.toml"
        system.save(path)
        again = gb.RotorSystem.load(path)
        assert again.meshes[0].friction == friction
        assert again.description == system.description


GEARED = [
    name for name, machine in gb.examples().items() if gb.RotorSystem.load(machine.path).meshes
]


@pytest.mark.parametrize("name", GEARED)
def test_machines_of_the_package_with_friction(name: str):
    machine = gb.examples()[name]
    given = gb.RotorSystem.load(machine.path)
    system = given.replace(meshes=[replace(mesh, friction=0.06) for mesh in given.meshes])
    found = system.efficiency(machine.speed)
    # a stage of external gears loses about 1 % at this coefficient
    stages = len(found.meshes)
    assert 1.0 - 0.03 * stages < found.efficiency[0] < 1.0
    assert np.all((found.loss_factor > 0.05) & (found.loss_factor < 0.4))


@pytest.mark.parametrize("name", ["geared_pair", "idler_train", "torsional_drive_line"])
def test_runs_of_machines_of_the_package_with_friction(name: str):
    machine = gb.examples()[name]
    given = gb.RotorSystem.load(machine.path)
    system = given.replace(meshes=[replace(mesh, friction=0.06) for mesh in given.meshes])
    half_turn = np.pi / machine.speed
    run = system.simulate(half_turn, machine.speed, record=["meshes", "energy"])
    balance = run.energy_balance()
    # the accuracy of the run, "engineering", is 1e-2 of the forces
    assert np.abs(balance.residual).max() < 1e-3 * np.abs(balance.damping).max()
    meshes = [run.mesh((mesh.driver, mesh.driven)) for mesh in system.meshes]
    work = sum(np.trapezoid(mesh.friction_power, run.time) for mesh in meshes)
    # vibration of the first half turn beside the loss at rest
    expected = half_turn * system.efficiency(machine.speed).loss.sum()
    assert 0.4 * expected < work < 1.6 * expected


def test_a_branch_of_steady_states_with_friction():
    system = gears(0.05, SMOOTH, mesh={"damping_ratio": 0.7})
    found = system.continuation("speed", 100.0, 104.0, first_step=2.0, max_points=4, record=[MESH])
    assert found.values[-1] == pytest.approx(104.0)


def test_the_command_prints_the_efficiency(tmp_path: Any, capsys: Any):
    from gearbow.cli.main import main

    gears(mu()).save(tmp_path / "train.toml")
    command = ["efficiency", str(tmp_path / "train.toml"), "--speed", "1500 rpm"]
    printed = []
    for more in (["--json"], ["--out", str(tmp_path / "losses.png")]):
        with pytest.raises(SystemExit) as ended:
            main([*command, *more])
        assert not ended.value.code
        printed.append(capsys.readouterr().out)
    assert json.loads(printed[0])["efficiency"][0] == pytest.approx(0.9931, abs=1e-4)
    assert "99.3" in printed[1]
    assert (tmp_path / "losses.png").stat().st_size > 1000
