"""Known faults of similar programs, one test for each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference.bows import HalfSine
from reference.scenes import CHAIN, PAIR, GearAt, Geared

METHODS = ("exponential", "rk4", "rk45")
DEMO = Geared(
    bows={"input": HalfSine(1.5e-4), "middle": HalfSine(1.5e-4, 0.8), "output": HalfSine(1e-4)},
    angles=(0.4, -1.1),
)
QUIET = replace(CHAIN, torque=0.0, modal_damping=None)


# --- bow and unbalance rotate with their own shaft ------------------------------------------------


def whirl_at(response: gb.Response, name: str, spin: float) -> complex:
    """Return the part of v + iw that rotates at `spin`, over whole revolutions without the last
    time.
    """
    z = response.displacement(name)[:-1] @ np.array([1, 1j])
    return complex(np.mean(z * np.exp(-1j * spin * response.time[:-1])))


@pytest.mark.parametrize("shaft", [0, 1, 2, 3])
@pytest.mark.parametrize("cause", ["bow", "unbalance"])
def test_bow_and_unbalance_rotate_at_the_speed_of_their_own_shaft(shaft: int, cause: str):
    name = CHAIN.shafts[shaft]
    phase, speed = 0.7, 400.0
    gear = next(g for g in CHAIN.gears if g.shaft == name)
    if cause == "bow":
        scene = replace(QUIET, bows={name: HalfSine(1e-5, phase)})
    else:
        gears = [
            replace(g, unbalance=1e-2 * np.exp(1j * phase)) if g is gear else g for g in CHAIN.gears
        ]
        scene = replace(QUIET, gears=gears)
    system = scene.package()

    amplitudes = system.synchronous([speed]).displacement(gear.name)[0]  # (shafts, 2)
    others = np.delete(amplitudes, shaft, axis=0)
    assert np.abs(others).max() == 0.0  # no other shaft is excited
    assert np.abs(amplitudes[shaft]).max() > 0

    # eight revolutions of the first shaft are whole revolutions of all four; frozen geometry is
    # linear
    period = 8 * 2 * np.pi / speed
    response = system.simulate(
        period, speed, geometry="frozen", initial="synchronous", output_step=period / 512
    )
    parts = {r: abs(whirl_at(response, gear.name, r * speed)) for r in CHAIN.ratios}
    own = CHAIN.ratios[shaft]
    # the run starts from the linear solution, so only the integration error at 1e-6 remains;
    # meshes couple the two planes and can excite minus the spin, which is no shaft's speed here
    for ratio, part in parts.items():
        if ratio != own:
            assert part < 1e-4 * parts[own], ratio
    y, z = amplitudes[shaft]
    # Q exp(i r speed t): the part that rotates with the shaft is (Y + iZ) / 2
    assert abs(whirl_at(response, gear.name, own * speed) - (y + 1j * z) / 2) < 1e-4 * parts[own]
    if cause == "bow":
        # well below all natural frequencies, (400 / 1700)^2 = 6 %, on stiff bearings
        at = 1e-5 * np.exp(1j * phase) * np.sin(np.pi * gear.position / 0.5)
        assert whirl_at(response, gear.name, own * speed) == pytest.approx(at, rel=0.15)


def test_unbalance_is_a_force_of_the_square_of_its_own_spin():
    expected = []
    for shaft, name in enumerate(CHAIN.shafts):
        gear = next(g for g in CHAIN.gears if g.shaft == name)
        gears = [replace(g, unbalance=1e-3) if g is gear else g for g in CHAIN.gears]
        system = replace(QUIET, gears=gears).package()
        train = replace(QUIET, gears=gears).reference()
        found = system.synchronous([300.0]).displacement(gear.name)[0, shaft]
        i = train.dof(gear.shaft, gear.position, 0)
        expected = train.synchronous(300.0)[shaft][i : i + 2]
        # two assemblies and solvers; condition number of about 1e7
        assert np.abs(found - expected).max() < 1e-7 * np.abs(expected).max()


# --- speed ratios ---------------------------------------------------------------------------------


@pytest.mark.parametrize("reference", range(4))
def test_speed_ratios_whichever_shaft_is_the_reference(reference: int):
    ratios = np.array([1.0, -1 / 2, 1 / 4, -1 / 8])
    name = CHAIN.shafts[reference]
    system = replace(CHAIN, options={"reference": name}).package()
    # quotients of small integers
    assert system.speed_ratios == pytest.approx(ratios / ratios[reference], rel=1e-15)


@pytest.mark.parametrize("reference", ["middle", "output"])
def test_the_same_motion_whichever_shaft_is_the_reference(reference: str):
    other = replace(DEMO, options={"reference": reference})
    ratio = dict(zip(DEMO.shafts, DEMO.ratios, strict=True))[reference]
    first, second = DEMO.package(), other.package()
    speed = 120.0
    assert second.modes(speed=speed * ratio).frequencies_hz[:30] == pytest.approx(
        first.modes(speed=speed).frequencies_hz[:30],
        rel=1e-9,
        abs=1e-6,  # round-off
    )
    a = first.simulate(3e-3, speed, method="rk4", initial="rest", output_step=1e-4)
    b = second.simulate(3e-3, speed * ratio, method="rk4", initial="rest", output_step=1e-4)
    for name in ("g1", "g2", "g3", "g4"):
        u = a.displacement(name)
        assert np.abs(b.displacement(name) - u).max() < 1e-9 * np.abs(u).max()  # round-off
    force = a.mesh(("g1", "g2")).force
    assert np.abs(b.mesh(("g1", "g2")).force - force).max() < 1e-8 * np.abs(force).max()


def test_ratios_follow_meshes_whatever_their_order():
    # the pinion of the middle shaft is an idler
    idler = Geared(
        gears=(
            GearAt("g1", "input", 0.25, 20),
            GearAt("g2", "middle", 0.25, 30),
            GearAt("g4", "output", 0.25, 40),
        ),
        meshes=(("g2", "g4"), ("g1", "g2")),
        angles=(0.0, 2.0),
        torque=0.0,
    )
    assert idler.package().speed_ratios == pytest.approx([1.0, -2 / 3, 1 / 2], rel=1e-15)


# --- one law for modes, static and time -----------------------------------------------------------


@pytest.mark.parametrize("geometry", ["live", "frozen"])
def test_static_is_where_a_damped_run_comes_to_rest(geometry: str):
    scene = replace(
        DEMO,
        bows={},
        gravity=(0.0, -9.81),
        bearing_damping=3e4,
        mesh_damping_ratio=0.3,
        modal_damping=0.1,  # otherwise the bending of the shafts would decay slowly
    )
    system = scene.package()
    still = system.static(geometry=geometry)
    response = system.simulate(
        0.25, 60.0, initial="rest", geometry=geometry, times=[0.2, 0.25], method="rk45"
    )
    assert np.abs(np.asarray(still.displacement("g1"))).max() > 1e-6
    for name in ("g1", "g2", "g3", "g4"):
        u = np.asarray(still.displacement(name))
        # the slowest motion, 1.4e3 rad/s, decays by exp(-0.1 * 1.4e3 * 0.25) = 1e-15; a point that
        # is at rest is an equilibrium of the integrator for every tolerance
        assert np.abs(response.displacement(name)[-1] - u).max() < 1e-5 * np.abs(u).max()
    for pair in DEMO.meshes:
        mesh, at_rest = response.mesh(pair), still.mesh(pair)
        assert mesh.force[-1] == pytest.approx(float(at_rest.force), rel=1e-5)
        assert mesh.deflection[-1] == pytest.approx(float(at_rest.deflection), rel=1e-5)
    # the twist of the middle shaft between its gears; the rigid-body rotation is arbitrary
    twist = still.twist("g3") - still.twist("g2")
    found = response.twist("g3")[-1] - response.twist("g2")[-1]
    assert found == pytest.approx(float(twist), rel=1e-5)


def test_tooth_forces_of_the_equilibrium_follow_from_the_torque():
    still = replace(DEMO, bows={}).package().static()
    r = 3e-3 / 2 * np.cos(np.radians(20))  # base radius for each tooth
    # driver's torque over its base radius; the middle shaft transmits it
    assert still.mesh(("g1", "g2")).force == pytest.approx(250 / (25 * r), rel=1e-9)
    assert still.mesh(("g3", "g4")).force == pytest.approx(250 / (25 * r) * 2, rel=1e-9)
    for pair in DEMO.meshes:
        mesh = still.mesh(pair)
        assert mesh.force == pytest.approx(2e8 * mesh.deflection, rel=1e-12)
    total = sum(
        np.asarray(still.bearing_force((s, x)))
        for s in ("input", "middle", "output")
        for x in (0.0, 0.5)
    )
    # only internal forces: the bearing forces sum to zero
    assert np.abs(total).max() < 1e-8 * still.mesh(("g1", "g2")).force


@pytest.mark.parametrize("motion", ["torsion", "coupled"])
def test_small_free_vibration_has_the_frequencies_of_the_modes(motion: str):
    scene = replace(
        PAIR,
        torque=1e-3,  # small displacements: the geometry is nearly constant
        elements=1,
        bearing_damping=0.0,
        mesh_damping_ratio=0.0,
        options={"motion": motion},
    )
    system = scene.package()
    omega = 2 * np.pi * system.modes().frequencies_hz[1:]
    response = system.simulate(
        4e-3, 0.0, initial="rest", method="rk45", rtol=1e-9, output_step=4e-6
    )
    t = response.time
    series = [response.twist("g1"), response.twist("g2")]
    if motion == "coupled":
        series += [response.displacement("g1")[:, 0], response.displacement("g2")[:, 1]]

    def misfit(omega: np.ndarray, y: np.ndarray) -> float:
        """Return the residual of a fit by cosines at these frequencies."""
        columns = np.column_stack([np.ones_like(t), np.cos(np.outer(t, np.unique(omega.round(6))))])
        left = y - columns @ np.linalg.lstsq(columns, y, rcond=1e-9)[0]
        return float(np.abs(left).max() / np.ptp(y))

    for y in series:
        # released from rest: only cosines. The error is 1e-9 per step, and 1e-8 from the geometry
        # of the load
        assert misfit(omega, y) < 1e-5
        assert misfit(omega * 1.01, y) > 1e-3


def test_sign_of_mesh_force_in_time_and_in_bearings():
    scene = replace(PAIR, angles=(0.0,), bearing_damping=3e4)
    for torque in (250.0, -250.0):
        r = (
            replace(scene, torque=torque)
            .package()
            .simulate(
                0.2, 50.0, initial="static", times=[0.2], record=("gears", "meshes", "bearings")
            )
        )
        # the driven gear stands to the right and turns clockwise: the driver pushes it up and away
        assert np.sign(r.mesh(("g1", "g2")).force[0]) == np.sign(torque)
        assert np.sign(r.displacement("g2")[0]).tolist() == [np.sign(torque)] * 2
        assert np.sign(r.displacement("g1")[0]).tolist() == [-np.sign(torque)] * 2
        n = np.array([np.sin(np.radians(20)), np.cos(np.radians(20))])
        carried = sum(r.bearing_force(("output", x))[0] for x in (0.0, 0.5))
        # the shaft presses on its bearings with the tooth force; the line of action has rotated by
        # 1e-4 rad
        force = r.mesh(("g1", "g2")).force[0]
        assert carried == pytest.approx(force * n, rel=1e-3)


# --- independent runs, initial states -------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
def test_a_run_leaves_the_system_as_it_was(method: str):
    system = DEMO.package()
    before = system.matrices()
    how = {"method": method, "output_step": 1e-4, "initial": "synchronous"}
    first = system.simulate(2e-3, 100.0, **how)
    system.simulate(1e-3, -333.0, method=method, geometry="frozen")  # another run in between
    after = system.matrices()
    for name in ("mass", "stiffness", "damping", "gyroscopic"):
        assert np.array_equal(getattr(before, name), getattr(after, name)), name
    second = system.simulate(2e-3, 100.0, **how)
    assert_same_bits(first, second)


def assert_same_bits(first: gb.Response, second: gb.Response, rows: slice = slice(None)) -> None:
    for name in ("g1", "g2", "g3", "g4"):
        assert np.array_equal(first.displacement(name)[rows], second.displacement(name))
        assert np.array_equal(first.twist(name)[rows], second.twist(name))
    for pair in DEMO.meshes:
        a, b = first.mesh(pair), second.mesh(pair)
        for part in ("force", "deflection", "contact_ratio", "pressure_angle"):
            assert np.array_equal(getattr(a, part)[rows], getattr(b, part)), part


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("geometry", ["live", "frozen"])
def test_initial_state_is_honoured(method: str, geometry: str):
    system, speed = DEMO.package(), 100.0
    how = {"method": method, "geometry": geometry, "times": [0.0, 1e-4]}
    still = system.static(geometry=geometry)
    turning = system.synchronous([speed])
    rest = system.simulate(1e-4, speed, initial="rest", **how)
    static = system.simulate(1e-4, speed, initial="static", **how)
    synchronous = system.simulate(1e-4, speed, initial="synchronous", **how)
    for name in ("g1", "g2", "g3", "g4"):
        u = np.asarray(still.displacement(name))
        # round-off of the state, or of the difference between the equilibrium and its modal form
        rounding = 1e-12 if method == "exponential" else 0.0
        assert np.abs(rest.displacement(name)[0]).max() <= rounding * np.abs(u).max()
        assert abs(rest.twist(name)[0]) <= rounding * abs(float(still.twist(name)))
        assert np.abs(rest.displacement(name)[1]).max() > 1e-9 * np.abs(u).max()  # in motion
        # at most the round-off of the modal transform and its inverse
        assert np.abs(static.displacement(name)[0] - u).max() < 1e-9 * np.abs(u).max()
        swing = turning.displacement(name)[0].real.sum(axis=0)  # every shaft is at angle 0
        expected = u + swing
        found = synchronous.displacement(name)[0]
        assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
        assert np.abs(swing).max() > 1e-2 * np.abs(expected).max()
    default = system.simulate(1e-4, speed, **how)
    assert_same_bits(default, synchronous)


def test_rest_means_at_rest():
    # from q = q' = 0 the first motion is half a t^2
    train, t = DEMO.reference(), 1e-9
    force = train.steady_force() + sum(at_0 for _, at_0, _ in train.turning_force(100.0))
    acceleration = np.linalg.solve(train.mass, force)
    response = DEMO.package().simulate(
        2e-9, 100.0, initial="rest", method="rk4", times=[t], step=t, record=("nodes",)
    )
    for shaft, x in (("input", 0.25), ("middle", 0.125), ("output", 0.25)):
        i = train.dof(shaft, x, 0)
        exact = acceleration[i : i + 2] * t**2 / 2
        # the next term is (mesh damping / gear mass) t / 3 = 3e-6
        gap = np.abs(response.displacement((shaft, x))[0] - exact).max()
        assert gap < 1e-5 * np.abs(exact).max()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("initial", ["rest", "synchronous"])
def test_a_run_in_two_parts_equals_one_run_bit_for_bit(method: str, initial: str):
    system, speed = DEMO.package(), 100.0
    times = np.arange(25) * 1e-4
    part = float(times[12])
    how = {"method": method}
    if method == "rk4":
        how["step"] = 0.7e-6  # 1714.3 steps per segment
    whole = system.simulate(2 * part, speed, initial=initial, times=times, **how)
    first = system.simulate(part, speed, initial=initial, times=times[:13], **how)
    second = system.simulate(part, speed, initial=first, times=times[12:], **how)
    assert_same_bits(whole, first, slice(0, 13))
    assert_same_bits(whole, second, slice(12, 25))
    assert whole.final["time"] == second.final["time"]
    for key, value in whole.final.items():
        assert np.array_equal(value, second.final[key]), key


@pytest.mark.parametrize("method", METHODS)
def test_a_run_divided_at_any_time_ends_bitwise_equal(method: str):
    # a difference in the last bit of the time appears at one of eight places
    system, speed = DEMO.package(), 100.0
    for k in range(30):
        part = (1 + k * 0.0137) * 1e-3
        whole = system.simulate(2 * part, speed, initial="rest", method=method, times=[2 * part])
        first = system.simulate(part, speed, initial="rest", method=method, times=[part])
        second = system.simulate(part, speed, initial=first, method=method, times=[2 * part])
        assert_same_bits(whole, second)


@pytest.mark.parametrize("method", METHODS)
def test_three_uneven_parts_at_given_times(method: str):
    system, speed = DEMO.package(), 100.0
    whole = system.simulate(1.1e-3, speed, method=method, times=[2e-4, 7.3e-4, 1e-3])
    state: str | gb.Response = "synchronous"
    rows = []
    for begin, end, time in ((0.0, 3.1e-4, 2e-4), (3.1e-4, 9e-4, 7.3e-4), (9e-4, 1.1e-3, 1e-3)):
        state = system.simulate(end - begin, speed, method=method, times=[time], initial=state)
        rows.append(state.displacement("g3")[0])
    found = np.array(rows)
    exact = whole.displacement("g3")
    # ends lie between steps: round-off in `end`, or a shortened step (error of one step at rtol
    # 1e-6)
    assert np.abs(found - exact).max() < 1e-5 * np.abs(exact).max()


# --- load range -----------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("geometry", "closeness"),
    # frozen geometry is linear: round-off for a fixed step and for the exponential method, which is
    # exact for linear motion; the tolerance for an adaptive step. Live geometry at 1 N m moves the
    # centres by 3e-7 m of 0.11 m, a few 1e-6 of each result.
    [("frozen", None), ("live", 1e-4)],
)
def test_the_response_is_proportional_to_a_load_of_a_nanonewtonmetre(method, geometry, closeness):
    closeness = closeness or {"exponential": 1e-9, "rk4": 1e-9, "rk45": 1e-5}[method]
    runs = []
    for torque in (1.0, 1e-9):
        scene = replace(DEMO, bows={}, torque=torque)
        runs.append(
            scene.package().simulate(
                2e-3, 100.0, initial="rest", method=method, geometry=geometry, output_step=1e-4
            )
        )
    for name in ("g1", "g2", "g3", "g4"):
        unit, small = (run.displacement(name) for run in runs)
        assert np.abs(small * 1e9 - unit).max() < closeness * np.abs(unit).max()
        unit, small = (run.twist(name) for run in runs)
        assert np.abs(small * 1e9 - unit).max() < closeness * np.abs(unit).max()


def test_the_response_is_proportional_to_a_small_bow():
    at = [
        replace(DEMO, torque=0.0, bows={"middle": HalfSine(b)})
        .package()
        .simulate(2e-3, 100.0, initial="rest", output_step=1e-4, geometry="frozen")
        .displacement("g2")
        for b in (1e-7, 1e-12)  # the turn of the bow with the twist is of second order
    ]
    assert np.abs(at[1] * 1e5 - at[0]).max() < 1e-5 * np.abs(at[0]).max()  # rtol 1e-6 in each run
