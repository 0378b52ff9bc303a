"""Complete simulations against an independent program: matrices, mesh law, bow force, integrator.

The independent solution (see `reference`) assembles the train in NumPy from the design equations and integrates it with
DOP853 at rtol 1e-10, three orders below the tolerance required here.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reference import independent_solution
from reference.bows import HalfSine, Kinked
from reference.scenes import CHAIN, PAIR, GearAt, Geared

SPEED = 100.0
END, COUNT = 2e-3, 41
TOLERANCE = 1e-6  # required tolerance relative to the range of each signal

ALL = {
    "input": HalfSine(1.5e-4, 0.0),
    "middle": HalfSine(1.5e-4, 0.7),
    "output": HalfSine(2e-4, 2.0),
}
DEMO = Geared(bows=ALL, angles=(0.4, -1.1))
SCENES = {
    "bow on all, phases, angles": DEMO,
    "bow on the middle shaft": replace(DEMO, bows={"middle": HalfSine(1.5e-4)}, angles=(0.0, 0.0)),
    "bow at the bearings too": replace(
        DEMO, bows={"middle": Kinked(2e-4, 0.5), "output": Kinked(1e-4)}
    ),
    "large bow": replace(DEMO, bows={"input": HalfSine(1.2e-3, -2.0)}, angles=(2.5, 0.9)),
    "unbalance, gravity, skewed bearings": replace(
        DEMO,
        gears=[
            GearAt("g1", "input", 0.25, 25, unbalance=5e-3 + 1e-3j),
            GearAt("g2", "middle", 0.125, 50, unbalance=-2e-2j),
            GearAt("g3", "middle", 0.375, 25),
            GearAt("g4", "output", 0.25, 50, unbalance=3e-2),
        ],
        gravity=(1.0, -9.81),
        bearing_stiffness=np.array([[1e8, 2e7], [2e7, 6e7]]),
        bearing_damping=np.array([[800.0, 100.0], [100.0, 400.0]]),
    ),
    "wide centres": replace(DEMO, centre_distance_factor=1.01),
    "bows turn with the twist": replace(DEMO, options={"bow_torque": True}),
}
# tolerance and step at which the error of each method is below the required one: the highest
# frequency of these scenes is 1.7e5 rad/s
RUNS = {
    "rk4": {"method": "rk4", "step": 1.25e-7},
    "rk45": {"method": "rk45", "rtol": 1e-9},
    "exponential": {"method": "exponential", "rtol": 1e-9},
    "exponential, fixed": {"method": "exponential", "step": 5e-6, "stages": 3},
    "etdrk4": {"method": "etdrk4", "step": 1e-6},
}


def ranged(found: np.ndarray, exact: np.ndarray, scale: float | None = None) -> float:
    """Return the largest difference over the range of the exact signal."""
    return float(np.abs(found - exact).max() / (scale or np.ptp(exact, axis=0).max()))


def agree(scene: Geared, speed: float, live: bool, runs: dict[str, dict[str, object]]) -> None:
    times = np.linspace(0.0, END, COUNT)
    exact = independent_solution.from_rest(scene.reference(), speed, times, live)
    system = scene.package()
    geometry = "live" if live else "frozen"
    for how in runs.values():
        found = system.simulate(
            END * 1.001, speed, initial="rest", times=times, geometry=geometry, **how
        )
        where = f"{how['method']} {geometry}"
        for gear in scene.gears:
            name = gear.name
            error = ranged(found.displacement(name), exact.displacement(name))
            assert error < TOLERANCE, f"displacement of {name}, {where}: {error:.2e}"
            error = ranged(found.twist(name), exact.twist(name))
            assert error < TOLERANCE, f"twist of {name}, {where}: {error:.2e}"
        for i, pair in enumerate(scene.meshes):
            mesh, force = found.mesh(pair), exact.mesh_force(i, live)
            error = ranged(mesh.force, force)
            assert error < TOLERANCE, f"force of {pair}, {where}: {error:.2e}"
            error = ranged(mesh.contact_ratio, exact.contact_ratio(i))
            assert error < TOLERANCE, f"contact ratio of {pair}, {where}: {error:.2e}"


#: In frozen geometry, no bow is a new path of its own.
FROZEN = (
    "bow on all, phases, angles",
    "unbalance, gravity, skewed bearings",
    "wide centres",
    "bows turn with the twist",
)


@pytest.mark.parametrize(
    ("name", "live"), [(name, True) for name in SCENES] + [(name, False) for name in FROZEN]
)
def test_train_from_rest(name: str, live: bool):
    agree(SCENES[name], SPEED, live, RUNS)


@pytest.mark.parametrize(
    ("scene", "speed"),
    [
        (replace(DEMO, sigma=-1.0, torque=-250.0), -SPEED),
        (replace(DEMO, sigma=-1.0), -SPEED),
        (replace(DEMO, torque=0.0), 0.0),
        (replace(PAIR, bows={"output": HalfSine(1e-4, 1.0)}, angles=(1.3,)), 1500.0),
        (replace(CHAIN, elements=2, bows={"s3": HalfSine(2e-4, 1.0)}), 300.0),
    ],
    ids=["reversed", "reversed and braked", "at zero speed", "fast pair", "four shafts"],
)
def test_other_speeds_and_trains_from_rest(scene: Geared, speed: float):
    agree(scene, speed, True, {"rk45": RUNS["rk45"]})


def test_live_and_frozen_geometry_differ():
    # otherwise the tests above could not distinguish them
    times = np.linspace(0.0, END, COUNT)
    train = SCENES["large bow"].reference()
    live, frozen = (
        independent_solution.from_rest(train, SPEED, times, live) for live in (True, False)
    )
    gap = ranged(frozen.mesh_force(0, False), live.mesh_force(0, True))
    assert gap > 1e3 * TOLERANCE
    # both senses of rotation also differ
    train = replace(DEMO, sigma=-1.0).reference()
    other = independent_solution.from_rest(train, SPEED, times)
    train = DEMO.reference()
    assert (
        ranged(other.twist("g2"), independent_solution.from_rest(train, SPEED, times).twist("g2"))
        > 0.1
    )


@pytest.mark.parametrize("name", [*SCENES, "pair", "four shafts", "deep and hollow"])
def test_matrices(name: str):
    more = {"pair": PAIR, "four shafts": CHAIN, "deep and hollow": replace(PAIR, diameter=0.12)}
    scene = {**SCENES, **more}[name]
    own, found = scene.reference(), scene.package().matrices()
    dofs = own.dofs()
    assert [(d[0], d[2]) for d in found.dofs] == [(d[0], d[2]) for d in dofs]
    assert [d[1] for d in found.dofs] == pytest.approx([d[1] for d in dofs], abs=1e-12)
    stiffness, damping = own.linear()
    for label, exact in (
        ("mass", own.mass),
        ("stiffness", stiffness),
        ("damping", damping),
        ("gyroscopic", own.gyroscopic),
    ):
        # entries are sums of a few products: round-off of the largest of its row and column
        size = np.sqrt(np.abs(np.diag(exact if label != "gyroscopic" else own.mass)))
        scale = np.outer(size, size)
        scale[scale == 0] = np.abs(exact).max()
        gap = np.abs(getattr(found, label) - exact) / scale
        assert gap.max() < 1e-11, label


@pytest.mark.parametrize(
    "name", ["bow on all, phases, angles", "unbalance, gravity, skewed bearings"]
)
@pytest.mark.parametrize("speed", [30.0, 500.0, -500.0])
def test_synchronous_response(name: str, speed: float):
    # the rotation sense of the driver selects the line of action of the linearised meshes
    scene = replace(SCENES[name], sigma=float(np.sign(speed)))
    own = scene.reference()
    expected = own.synchronous(speed)
    found = scene.package().synchronous([speed]).amplitudes[0]
    for source, exact in enumerate(expected):
        # twist: it contains the rigid-body rotation; the matrix has a condition of 1e8
        for coordinate in range(5):
            part = slice(coordinate, None, 5)
            scale = np.abs(exact[part]).max()
            assert np.abs(found[source][part] - exact[part]).max() < 1e-6 * scale, coordinate


@pytest.mark.parametrize("speed", [0.0, 300.0])
def test_damped_eigenvalues(speed: float):
    own = DEMO.reference().eigenvalues(speed)
    own = own[own.imag > 1.0][:40]
    modes = DEMO.package().modes(speed=speed)
    found = modes.eigenvalues[np.abs(modes.frequencies_hz) > 1.0][:40]
    # nearly equal pairs can have either order: compare as sets
    for value in own:
        # eps times the squared ratio of the highest to this frequency: 2e-16 (1.7e5 / 500)^2
        assert np.abs(found - value).min() < 1e-8 * abs(value)
