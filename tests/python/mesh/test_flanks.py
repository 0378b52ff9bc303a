"""Choice of the loaded flank: sign of the speed, or of the torque at rest, in every analysis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from test_random_scenes import Drawn, motion, unturned

TRAIN = Drawn(
    lengths=(0.4, 0.5, 0.6),
    diameters=(0.05, 0.04, 0.06),
    elements=(1, 2, 1),
    places=(0.25, 0.6, 0.4),
    teeth=(20, 32, 28),
    bows=(1e-4 + 5e-5j, -5e-5j, 3e-5 + 0j),
    rayleigh=1e-7,
)
SPEEDS = (0.0, 100.0, -100.0)


def mirrored(vector: np.ndarray) -> np.ndarray:
    """Mirror (y, z) like `Drawn.mirror`: y changes its sign."""
    return vector * [-1.0, 1.0]


@pytest.mark.parametrize("torque", [60.0, -60.0])
@pytest.mark.parametrize("backlash", [None, 2e-5])
@pytest.mark.parametrize("speed", SPEEDS)
def test_a_mirrored_train_has_the_mirrored_response(
    speed: float, backlash: float | None, torque: float
):
    drawn = replace(TRAIN, torque=torque, backlash=backlash, speed=speed)
    image = replace(drawn, mirror=True)
    one, other = drawn.system(), image.system()
    # sums of the same numbers in a different order
    modes, reflected = one.modes(speed), other.modes(-speed)
    # rigid-body frequencies are zero up to the round-off of the highest frequency
    floor = 1e-8 * modes.frequencies_hz.max()
    assert reflected.frequencies_hz == pytest.approx(modes.frequencies_hz, rel=1e-8, abs=floor)
    for geometry in ("live", "frozen"):
        still, turned = (
            one.static(speed, geometry=geometry),
            other.static(-speed, geometry=geometry),
        )
        for gear in ("g0", "g1", "g2"):
            wanted = mirrored(still.displacement(gear))
            assert turned.displacement(gear) == pytest.approx(wanted, rel=1e-8, abs=1e-15)
        for pair in (("g0", "g1"), ("g1", "g2")):
            assert turned.mesh(pair).force == pytest.approx(still.mesh(pair).force, rel=1e-8)
            assert turned.mesh(pair).deflection == pytest.approx(
                still.mesh(pair).deflection, rel=1e-8
            )
    response, image_response = one.synchronous([speed]), other.synchronous([-speed])
    sizes = [np.abs(r.displacement("g1")) for r in (response, image_response)]
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-7, abs=1e-14)
    for initial in ("rest", "static"):
        wanted = motion(drawn.run(initial=initial), drawn)
        found = unturned(image.run(initial=initial), image)
        # both runs meet the tolerance; contacts propagate errors of earlier event times
        part = 1e-6 if backlash is None else 1e-4
        for kind in (slice(0, 2), slice(2, 3)):
            scale = np.abs(wanted[..., kind]).max()
            assert np.abs(found[..., kind] - wanted[..., kind]).max() < part * scale


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("torque", [60.0, -60.0])
def test_modes_are_those_of_the_matrices_at_their_speed(speed: float, torque: float):
    system = replace(TRAIN, torque=torque).system()
    given = system.matrices(speed)
    n = len(given.dofs)
    rate = given.damping + speed * given.gyroscopic
    state = np.zeros((2 * n, 2 * n))
    state[:n, n:] = np.eye(n)
    state[n:, :n] = -np.linalg.solve(given.mass, given.stiffness)
    state[n:, n:] = -np.linalg.solve(given.mass, rate)
    wanted = np.linalg.eigvals(state)
    wanted = np.sort(np.abs(wanted.imag[wanted.imag > 1.0]))
    found = system.modes(speed).eigenvalues
    found = np.sort(found.imag[found.imag > 1.0])
    # eigenvalues of an unsymmetric matrix: round-off of the highest, over the lowest
    assert found[:20] == pytest.approx(wanted[:20], rel=1e-6)


def test_the_sign_of_the_speed_matters_where_a_mesh_couples_bending_and_twist():
    system = TRAIN.system()
    forward, backward = system.matrices(100.0), system.matrices(-100.0)
    for name in ("stiffness", "damping"):
        a, b = getattr(forward, name), getattr(backward, name)
        assert np.abs(a - b).max() > 1e-4 * np.abs(a).max()
    assert np.array_equal(system.matrices().stiffness, forward.stiffness)
    assert np.array_equal(system.matrices(1e-300).stiffness, forward.stiffness)
    with pytest.raises(gb.SceneError, match=r"^speed: "):
        system.matrices(np.nan)
    with pytest.raises(gb.SceneError, match=r"^speed: "):
        system.static(speed=np.inf)


@pytest.mark.parametrize("torque", [60.0, -60.0])
# More than the reduction of backlash by the load of the middle gear: one flank is in contact.
@pytest.mark.parametrize("backlash", [None, 1e-4])
def test_at_rest_the_torque_decides_which_flank_is_loaded(backlash: float | None, torque: float):
    system = replace(TRAIN, torque=torque, backlash=backlash, gravity=(0.0, 0.0)).system()
    forces = [abs(torque) / (0.0015 * 20 * np.cos(np.radians(20.0)))] * 2
    for geometry in ("live", "frozen"):
        still = system.static(geometry=geometry)
        found = [still.mesh(pair).force for pair in (("g0", "g1"), ("g1", "g2"))]
        # gears with live geometry also move along the line of action, without a moment: round-off
        assert found == pytest.approx(forces, rel=1e-7)
    turning = system.static(speed=np.sign(torque))
    assert np.array_equal(turning.state, system.static().state)
    start = system.simulate(1e-5, 0.0, initial="static", times=[0.0])
    assert start.mesh(("g0", "g1")).force[0] == pytest.approx(forces[0], rel=1e-7)
    # with the opposite rotation the same torque loads the back flank
    braked = system.static(speed=-np.sign(torque)).mesh(("g0", "g1")).force
    assert braked == pytest.approx(-forces[0], rel=1e-7)


def test_torques_without_mesh_force_or_balance():
    parts = TRAIN.parts()
    # Without a torque, or with torques balanced on one shaft, flanks follow the speed ratios.
    on_one = [gb.Torque("g0", -60.0), gb.Torque(("s0", 0.0), 60.0)]
    forward = TRAIN.system().matrices(1.0).stiffness
    for torques in ([], on_one):
        system = gb.RotorSystem(**{**parts, "torques": torques})
        assert np.array_equal(system.matrices().stiffness, forward)
    # An unbalanced torque accelerates the train: the teeth drive the last shaft.
    for value, speed in ((60.0, 1.0), (-60.0, -1.0)):
        system = gb.RotorSystem(**{**parts, "torques": [gb.Torque("g0", value)]})
        assert np.array_equal(system.matrices().stiffness, system.matrices(speed).stiffness)


def test_a_run_does_not_continue_on_the_other_flanks():
    system = replace(TRAIN, torque=-60.0, backlash=2e-5).system()
    first = system.simulate(1e-4, 0.0, initial="static")
    system.simulate(1e-4, -50.0, initial=first)
    with pytest.raises(gb.SceneError, match=r"^initial: .*would change their flanks"):
        system.simulate(1e-4, 50.0, initial=first)


def test_a_campbell_diagram_of_a_braked_train_is_continuous_at_rest():
    system = replace(TRAIN, torque=-60.0).system()
    campbell = system.campbell(np.linspace(0.0, 10.0, 3), count=12)
    frequencies = np.asarray(campbell.frequencies_hz)
    assert np.all(np.isfinite(frequencies))
    # gyroscopic moments change a frequency by at most the speed
    assert np.abs(np.diff(frequencies, axis=0)).max() < 10.0 / (2 * np.pi)


#: At rest, the torque moves the middle gear towards its neighbours by more than the backlash, so that both flanks press.
TIGHT = replace(
    TRAIN,
    bows=(0j, 0j, 0j),
    unbalance=0j,
    gravity=(0.0, 0.0),
    bearing=(1.0, 0.6, 0.1, 50.0),
    mesh=("mean", 1e8, 0.3),
    rayleigh=1e-5,
    backlash=2e-5,
    speed=100.0,
)


@pytest.mark.parametrize("geometry", ["live", "frozen"])
@pytest.mark.parametrize("backlash", [0.0, 2e-5])
def test_both_flanks_press_in_equilibrium_where_the_gears_come_closer(
    backlash: float, geometry: str
):
    system = replace(TIGHT, backlash=backlash).system()
    static = system.static(100.0, geometry=geometry)
    run = system.simulate(
        0.25, 100.0, initial="rest", method="rk45", geometry=geometry, output_step=0.05
    )
    for pair in (("g0", "g1"), ("g1", "g2")):
        still, last = static.mesh(pair), run.mesh(pair)
        assert still.stiffness == last.stiffness[-1] == 2e8
        # The slowest mode decays to below 1e-4 of its beginning.
        assert still.force == pytest.approx(last.force[-1], rel=1e-4)
        assert still.deflection == pytest.approx(last.deflection[-1], rel=1e-4)
    assert static.displacement("g1") == pytest.approx(run.displacement("g1")[-1], rel=1e-4)
    # The difference of both flank forces transmits the torque.
    torque = static.mesh(("g0", "g1")).force * 0.0015 * 20 * np.cos(np.radians(20.0))
    assert torque == pytest.approx(60.0, rel=1e-9)


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_a_run_from_an_equilibrium_on_both_flanks_stays_there(method: str):
    run = TIGHT.system().simulate(
        0.01, 100.0, initial="static", method=method, geometry="live", rtol=1e-8
    )
    assert run.events == ()
    assert np.ptp(run.mesh(("g0", "g1")).force) < 1e-9 * run.mesh(("g0", "g1")).force[0]
