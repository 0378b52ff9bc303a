"""Damping in separation: a gear pair with clearance, free flight, energy, and what it does not change."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearbow as gb
from reference.teeth import TeethLaw, Toothed, begin

K, BACKLASH, TORQUE = 2e8, 4e-5, 100.0
SCENE = Toothed(mesh={"stiffness": K, "backlash": BACKLASH}, torque=TORQUE)
LAW = SCENE.law()
MESH = ("ga", "gb")
METHODS: dict[str, dict[str, Any]] = {
    "exponential": {"method": "exponential", "rtol": 1e-9},
    "rk45": {"method": "rk45", "rtol": 1e-9},
    "rk4": {"method": "rk4", "step": 2e-8},
}

# --- The gear pair with clearance of Kahraman and Singh (1991), in the form
#
#     d²x/dt² + 2ζ dx/dt + K f(x) = 0.1 + Σ F_n (nΩ)² cos nΩt,
#     K = 1 − 0.2 cos Ωt − 0.1 cos 2Ωt − 0.05 cos 3Ωt
#
# with f = x − 1 beyond the clearance 1, and zero within. A mesh has x − 1 = δ/b, with a unit of length b and ω² = k/mₑ.

ZETA, SPEED = 0.05, 0.5
STIFFNESS, FORCES = (0.2, 0.1, 0.05), (0.01, 0.004, 0.002)
UNIT = 1e-5  # b, m


def clearance_pair(in_separation: bool) -> tuple[gb.RotorSystem, float]:
    """Return the pair as a scene, and the speed of the driver."""
    omega = np.sqrt(K / SCENE.effective_mass)
    # the stiffness is a function of the position of the teeth, the error one of the angle of the driver
    position, _, _ = TeethLaw(LAW).place(np.zeros(6), np.zeros(2))
    offset = 2 * np.pi * position / LAW.base_pitch
    orders = np.arange(1, 4)
    stiffness = gb.Stiffness.fourier(
        K, [-K * a for a in STIFFNESS], [-float(n * offset) for n in orders], phase="prescribed"
    )
    mesh = {
        "stiffness": stiffness,
        "damping_ratio": ZETA,
        "damping_in_separation": in_separation,
        "backlash": 2 * UNIT,
        "error": gb.TransmissionError(tooth=[(UNIT * f, 0.0) for f in FORCES]),
    }
    torque = 0.1 * UNIT * K * LAW.base_radius_a
    return replace(SCENE, mesh=mesh, torque=torque).package(), SPEED * omega / SCENE.teeth[0]


def independent(in_separation: bool, cycles: int) -> tuple[float, float]:
    """Give maximum and standard deviation of the last cycle, in steps that end at every contact change."""
    orders, a, f = np.arange(1, 4), np.array(STIFFNESS), np.array(FORCES)

    def stiffness(t: float) -> float:
        return float(1.0 - a @ np.cos(orders * SPEED * t))

    def rate(touches: bool) -> Any:
        def derivative(t: float, y: np.ndarray) -> list[float]:
            push = 0.1 + f @ ((orders * SPEED) ** 2 * np.cos(orders * SPEED * t))
            elastic = stiffness(t) * (y[0] - 1.0) if touches else 0.0
            damping = 2 * ZETA * y[1] if touches or in_separation else 0.0
            return [y[1], push - damping - elastic]

        return derivative

    def distance(_: float, y: np.ndarray) -> float:
        return float(y[0] - 1.0)

    def force(t: float, y: np.ndarray) -> float:
        return stiffness(t) * (y[0] - 1.0) + 2 * ZETA * y[1]

    period = 2 * np.pi / SPEED
    times = np.linspace((cycles - 1) * period, cycles * period, 20001)[:-1]
    found = np.full(len(times), np.nan)
    at, y, touches = 0.0, np.array([1.1, 0.0]), True
    while at < cycles * period:
        # damping in contact alone ends the contact at zero force
        event = distance if in_separation or not touches else force
        event.terminal, event.direction = True, -1.0 if touches else 1.0  # type: ignore[attr-defined]
        part = solve_ivp(
            rate(touches), (at, cycles * period), y, "DOP853", rtol=1e-11, atol=1e-12,
            events=event, dense_output=True,
        )  # fmt: skip
        inside = (times >= at) & (times <= part.t[-1])
        if inside.any():
            found[inside] = part.sol(times[inside])[0]
        at, y, touches = float(part.t[-1]), part.y[:, -1], not touches
    return float(found.max()), float(found.std())


@pytest.mark.parametrize("in_separation", [True, False])
@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_a_gear_pair_with_clearance(method: str, in_separation: bool):
    system, speed = clearance_pair(in_separation)
    cycle = 2 * np.pi / (speed * SCENE.teeth[0])
    # 2ζΩ⁻¹ per radian: e^{-ζ 2π cycles/Ω} of the beginning remains, 1e-11
    cycles = 40
    times = cycle * (cycles - 1 + np.arange(4000) / 4000)
    run = system.simulate(
        cycles * cycle, speed, initial="static", times=times, method=method, rtol=1e-9,
        record=["meshes"],
    )  # fmt: skip
    x = 1.0 + run.mesh(MESH).deflection / UNIT
    assert {"contact", "separation"} <= {event.kind for event in run.events}
    # With damping in contact alone, contact ends at zero force. Damping until x = 1, where a flank pulls, gives 1.2409335.
    known = (1.2423926, 0.0903348) if in_separation else (1.2405258, 0.0910232)
    assert [x.max(), x.std()] == pytest.approx(known, abs=1e-6)
    assert [x.max(), x.std()] == pytest.approx(independent(in_separation, cycles), abs=1e-6)


# --- Free flight, energy, and what stays equal


def film(**mesh: Any) -> Toothed:
    return replace(SCENE, mesh={**SCENE.mesh, "damping_in_separation": True, **mesh})


@pytest.mark.parametrize("method", METHODS)
def test_separated_gears_approach_as_a_damped_mass(method: str):
    """Flight under the load F: mₑ δ̈ + c δ̇ = F, so that δ̇ = aτ + (δ̇₀ − aτ) e^{−t/τ}, with τ = mₑ/c and a = F/mₑ."""
    damping, mass = 500.0, SCENE.effective_mass
    system = film(damping=damping, backlash=1e-3).package()
    n, rate, options = len(system.dofs), -0.05, METHODS[method]
    y = np.zeros(2 * n)
    radii = (LAW.base_radius_a, LAW.base_radius_b)
    share = np.array([mass * r / i for r, i in zip(radii, SCENE.inertia, strict=True)])
    y[:n], y[n:] = -1e-4 * np.repeat(share, 2), rate * np.repeat(share, 2)
    times = np.linspace(0.0, 2e-4, 21)
    state = begin(system, 0.0, y, **options)
    mesh = system.simulate(2e-4, 0.0, initial=state, times=times, **options).mesh(MESH)
    tau, a = mass / damping, TORQUE / LAW.base_radius_a / mass
    c, decay = rate - a * tau, np.exp(-times / tau)
    deflection = -1e-4 + a * tau * times + c * tau * (1 - decay)
    force = damping * (c * decay + a * tau)
    # the tolerance of the run is 1e-9 for each step
    assert mesh.deflection == pytest.approx(deflection, abs=1e-8 * np.ptp(deflection))
    assert mesh.force == pytest.approx(force, abs=1e-8 * np.ptp(force))
    assert mesh.force.min() < 0.0
    assert np.all(mesh.stiffness == 0.0)
    assert np.all(mesh.pairs_in_contact == 0.0)


@pytest.mark.parametrize("geometry", ["live", "frozen"])
@pytest.mark.parametrize("method", METHODS)
def test_the_film_dissipates_what_the_energy_loses(method: str, geometry: str):
    error = gb.TransmissionError(tooth=[(2e-5, 0.0)])
    mesh = {"damping_ratio": 0.1, "backlash": 1e-5, "error": error}
    runs = {}
    for in_separation in (True, False):
        scene = film(**mesh, damping_in_separation=in_separation)
        system = replace(scene, coupled=True, torque=20.0).package()
        run = system.simulate(
            2e-3, 400.0, geometry=geometry, record=["meshes", "energy"], output_step=1e-6,
            **METHODS[method] | ({"step": 2e-7} if method == "rk4" else {}),
        )  # fmt: skip
        balance = run.energy_balance()
        scale = np.abs(balance.damping).max()
        # a contact change is a kink of the force; the quadrature of the powers has the accuracy of the method
        assert np.abs(balance.residual).max() < 1e-5 * scale
        assert np.all(np.diff(balance.damping) <= 1e-9 * scale)
        runs[in_separation] = run.mesh(MESH)
        kinds = {event.kind for event in run.events}
        assert {"contact", "separation", "back contact"} <= kinds
    separated = runs[True].stiffness == 0.0
    assert np.abs(runs[True].force[separated]).max() > 1.0
    assert np.all(runs[False].force[runs[False].stiffness == 0.0] == 0.0)


@pytest.mark.parametrize("mesh", [{"damping_ratio": 0.05, "backlash": None}, {"backlash": 1e-6}])
def test_without_backlash_or_without_damping_it_changes_nothing(mesh: dict[str, Any]):
    runs = []
    for in_separation in (True, False):
        error = gb.TransmissionError(tooth=[(1e-5, 0.0)])
        scene = film(**mesh, error=error, damping_in_separation=in_separation)
        runs.append(
            scene.package().simulate(1e-3, 400.0, method="rk45", rtol=1e-9, output_step=1e-6)
        )
    first, second = (run.mesh(MESH).force for run in runs)
    assert np.ptp(second) > 0.0
    if mesh["backlash"] is None:
        assert np.array_equal(first, second)
    # undamped flanks separate at zero deflection and zero force, located to round-off
    assert first == pytest.approx(second, abs=1e-9 * np.ptp(second))


@pytest.mark.implausible
def test_description_and_errors():
    system = film(damping=100.0).package()
    assert system.description["meshes"][0]["damping_in_separation"] is True
    again = gb.RotorSystem.from_dict(system.description)
    assert again.meshes[0].damping_in_separation is True
    assert "damping_in_separation" not in SCENE.package().description["meshes"][0]
    with pytest.raises(gb.SceneError, match=r"^meshes\[0\]\.damping_in_separation: "):
        film(damping_in_separation="yes").package()
