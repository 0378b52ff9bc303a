"""Recorded velocities and accelerations: closed forms, differences of fine samples, storage, errors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.machines import bowed_rotor_with_disk, pair_on_housing

RATES = ["velocity", "acceleration"]
METHODS: dict[str, dict[str, Any]] = {
    "exponential": {"method": "exponential", "rtol": 1e-9},
    "etdrk4": {"method": "etdrk4", "step": 2e-6},
    "rk45": {"method": "rk45", "rtol": 1e-10},
    "rk4": {"method": "rk4", "step": 2e-7},
    "reduced": {"method": "exponential", "rtol": 1e-9, "modes": 16},
}
# sixteen modes are few, on purpose
pytestmark = pytest.mark.filterwarnings("ignore:modes")
BEARING = {"stiffness": 1e8, "damping": 500.0}


# --- Closed forms


@pytest.mark.parametrize("method", METHODS)
def test_a_whirling_bowed_shaft(method: str):
    """A synchronous motion u = A e^{iΩt} has the velocity iΩu and the acceleration −Ω²u."""
    speed, system = 120.0, bowed_rotor_with_disk(gravity=9.81)
    run = system.simulate(0.2, speed, output_step=1e-3, record=["nodes", *RATES], **METHODS[method])
    static = system.static(speed=speed)
    places = [("rotor", x) for x in (0.0, 0.5, 1.0)]
    whirl = {place: run.displacement(place) - static.displacement(place) for place in places}
    scale = np.abs(whirl[places[1]]).max()
    # the linear motion of the exponential method is exact; rk4 and rk45 have the errors of their steps, which the
    # square of the natural frequencies multiplies
    slack = 1e-3 if method.startswith("rk") else 1e-10
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])
    for place in places:
        v, a = run.velocity(place), run.acceleration(place)
        assert np.abs(v - speed * whirl[place] @ quarter).max() < slack * speed * scale
        assert np.abs(a + speed**2 * whirl[place]).max() < slack * speed**2 * scale
        assert np.all(run.twist_rate(place) == 0.0)


@pytest.mark.parametrize("method", METHODS)
def test_an_undamped_support_accelerates_by_its_spring(method: str):
    """A support under a rotor obeys m a = F − k u, with the recorded force F of the bearings."""
    mass, stiffness = 40.0, 3e7
    base = gb.Support(stiffness=stiffness, mass=mass, name="base")
    bearings = [gb.Bearing("rotor", x, **BEARING, support="base") for x in (0.0, 1.0)]
    system = bowed_rotor_with_disk(bearings=bearings, supports=[base])
    run = system.simulate(
        0.05, 120.0, initial="rest", output_step=1e-4, record=["base", "bearings", *RATES],
        **METHODS[method],
    )  # fmt: skip
    force = sum(run.bearing_force(("rotor", x)) for x in (0.0, 1.0))
    expected = (force - stiffness * run.displacement("base")) / mass
    # a reduced model leaves out modes of the support, but not of the forces that it records
    slack = 1e-2 if method == "reduced" else 1e-9
    assert np.abs(run.acceleration("base") - expected).max() < slack * np.abs(expected).max()


# --- Differences of fine samples as an outside judge


def difference(values: np.ndarray, step: float) -> np.ndarray:
    """Differentiate samples by central differences of the fourth order, without the two ends."""
    return (8 * (values[3:-1] - values[1:-3]) - (values[4:] - values[:-4])) / (12 * step)


def assert_rates(run: gb.Response, places: list[Any], slack: float, changes: int = 0):
    """Compare rates with differences, except near so many changes of the contact, where rates jump or have a kink."""
    step = run.time[1] - run.time[0]
    for place in places:
        for values, rate in (
            (run.displacement(place), run.velocity(place)),
            (run.velocity(place), run.acceleration(place)),
            (run.twist(place)[:, None], run.twist_rate(place)[:, None]),
        ):
            error = np.sort(np.abs(difference(values, step) - rate[2:-2]).max(axis=1))
            largest = error[: error.size - 5 * changes].max()
            assert largest <= slack * np.abs(rate).max(), (place, largest)


PLACES = ["g1", "g2", "foot", "box", "corner"]


@pytest.mark.parametrize("geometry", ["live", "frozen"])
@pytest.mark.parametrize("method", METHODS)
def test_rates_are_those_of_fine_samples(method: str, geometry: str):
    step = 2e-7
    run = pair_on_housing().simulate(
        4e-4, 200.0, initial="rest", geometry=geometry, output_step=step,
        record=["gears", "housings", *RATES], **METHODS[method],
    )  # fmt: skip
    # differences have the error of the interpolation within a step: of order h⁴ for rk4 and rk45
    assert_rates(run, PLACES, 2e-3 if method.startswith("rk") else 1e-5)


@pytest.mark.parametrize("method", ["exponential", "rk45"])
@pytest.mark.parametrize(
    "changes",
    [
        {"modal_damping": 0.02},
        {"rayleigh": (5.0, 1e-7)},
        {"mesh": {"stiffness": gb.Stiffness.square(2e8, engagement="sharp")}},
        {"mesh": {"backlash": 1e-5, "stiffness": 2e8}},
        {"mesh": {"stiffness": gb.Stiffness.parabolic(2e8, phase="twist")}},
    ],
    ids=["modal damping", "rayleigh", "sharp", "backlash", "phase of the twist"],
)
def test_rates_of_other_systems(changes: dict[str, Any], method: str):
    step = 2e-7
    run = pair_on_housing(**changes).simulate(
        4e-4, 200.0, initial="rest", output_step=step, record=["gears", "housings", *RATES],
        **METHODS[method],
    )  # fmt: skip
    assert_rates(run, PLACES, 2e-3 if method == "rk45" else 1e-5, changes=3)


FILM = {"diameter": 0.06, "length": 0.03, "clearance": 6e-5, "viscosity": 0.02}


@pytest.mark.parametrize("method", ["exponential", "rk45"])
@pytest.mark.parametrize(
    "changes",
    [
        {"bearings": [gb.JournalBearing("rotor", x, **FILM) for x in (0.0, 1.0)]},
        {
            "bearings": [
                gb.RollingBearing(
                    "rotor",
                    x,
                    elements=9,
                    element_diameter=0.0127,
                    pitch_diameter=0.065,
                    clearance=0.0,
                )
                for x in (0.0, 1.0)
            ]
        },
        {"torques": [gb.Torque("disk", 50.0)]},
        {"forces": [gb.Force("disk", 200.0 + 50.0j, order=2.0)]},
    ],
    ids=["journal bearing", "rolling bearing", "unbalanced torque", "rotating force"],
)
def test_rates_of_rotors(changes: dict[str, Any], method: str):
    run = bowed_rotor_with_disk(gravity=9.81, **changes).simulate(
        2e-4, 120.0, initial="rest" if "torques" in changes else "static", output_step=1e-7,
        record=["disk", ("rotor", 0.0), *RATES], **METHODS[method],
    )  # fmt: skip
    # the differences at the sudden start in the oil film have an error of 5e-6, which falls with their fourth order
    assert_rates(run, ["disk", ("rotor", 0.0)], 2e-3 if method == "rk45" else 1e-5)
    if "torques" in changes:
        # a constant torque accelerates the twist evenly, beside torsional vibration
        assert run.twist_rate("disk")[-1] > 0.0


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_rates_at_changing_speed(method: str):
    speed = gb.SpeedProfile.ramp(100.0, 400.0, 0.01)
    run = pair_on_housing().simulate(
        1e-3, speed, initial="rest", output_step=5e-7, record=["gears", "housings", *RATES],
        **METHODS[method],
    )  # fmt: skip
    assert_rates(run, PLACES, 2e-3 if method == "rk45" else 1e-5)


# --- What recording them changes, storage, and errors


@pytest.mark.parametrize("method", METHODS)
def test_recording_rates_does_not_change_the_motion(method: str):
    options: dict[str, Any] = {"output_step": 1e-5, **METHODS[method]}
    record = ["gears", "meshes", "housings", "bearings"]
    plain = pair_on_housing().simulate(2e-3, 200.0, record=record, **options)
    rates = pair_on_housing().simulate(2e-3, 200.0, record=[*record, *RATES], **options)
    for name in PLACES:
        assert np.array_equal(plain.displacement(name), rates.displacement(name))
    assert np.array_equal(plain.mesh(("g1", "g2")).force, rates.mesh(("g1", "g2")).force)
    assert "velocity" not in plain.recorded
    assert rates.recorded[-2:] == RATES


def test_rates_are_saved_and_loaded(tmp_path: Path):
    path = tmp_path / "run.npz"
    for record in (RATES, ["velocity"], ["acceleration"], []):
        run = pair_on_housing().simulate(1e-3, 200.0, record=["gears", *record])
        run.save(path)
        again = gb.Response.load(path)
        assert again.recorded == run.recorded
        for name in record:
            assert np.array_equal(getattr(again, name)("g1"), getattr(run, name)("g1"))
        if "velocity" in record:
            assert np.array_equal(again.twist_rate("g2"), run.twist_rate("g2"))


def test_rates_in_tables_spectra_and_orders():
    run = pair_on_housing().simulate(0.05, 200.0, record=["gears", *RATES], output_step=1e-5)
    data, table = run.to_xarray(), run.to_dataframe()
    for array, unit in (("velocity", "m/s"), ("twist_rate", "rad/s"), ("acceleration", "m/s²")):
        assert data[array].attrs["units"] == unit
    for axis, lane in (("y", 0), ("z", 1)):
        assert np.array_equal(table[f"g1 velocity_{axis} [m/s]"], run.velocity("g1")[:, lane])
        assert np.array_equal(
            table[f"g1 acceleration_{axis} [m/s²]"], run.acceleration("g1")[:, lane]
        )
    assert np.array_equal(table["g2 twist_rate [rad/s]"], run.twist_rate("g2"))
    assert "g1 velocity_y [m/s]" not in pair_on_housing().simulate(1e-3, 200.0).to_dataframe()
    whirl = bowed_rotor_with_disk().simulate(0.5, 120.0, record=["disk", *RATES])
    moved, rate, rate2 = (
        whirl.orders("disk", name).amplitudes[0] for name in ("z", "velocity_z", "acceleration_z")
    )
    assert rate == pytest.approx(120j * moved, rel=1e-9)
    assert rate2 == pytest.approx(-(120**2) * moved, rel=1e-9)
    spectrum = run.spectrum("g1", "acceleration_y")
    assert (spectrum.label, spectrum.unit) == ("g1 acceleration_y", "m/s²")
    assert run.spectrum("g2", "twist_rate").unit == "rad/s"


def test_rates_in_any_order_of_times_and_over_a_checkpoint(tmp_path: Path):
    times = np.array([3e-4, 1e-4, 2e-4])
    options: dict[str, Any] = {"record": ["gears", *RATES]}
    run = pair_on_housing().simulate(3e-4, 200.0, times=times, **options)
    sorted_run = pair_on_housing().simulate(3e-4, 200.0, times=np.sort(times), **options)
    for name in RATES:
        found, expected = getattr(run, name)("g1"), getattr(sorted_run, name)("g1")
        assert np.array_equal(found, expected[[2, 0, 1]])
    options |= {"output_step": 1e-5, "rtol": 1e-6}
    whole = pair_on_housing().simulate(2e-2, 200.0, **options)
    path = tmp_path / "run.npz"
    parts = pair_on_housing().simulate(
        2e-2, 200.0, checkpoint=path, checkpoint_interval=1e-3, **options
    )
    for name in (*RATES, "twist_rate"):
        assert np.array_equal(getattr(parts, name)("g2"), getattr(whole, name)("g2"))


def test_errors_of_rates():
    shafts = [gb.Shaft(name, length=0.4, outer_diameter=0.05) for name in ("input", "output")]
    run = pair_on_housing(shafts=shafts).simulate(0.02, 200.0, record=["gears", *RATES])
    assert {"displacement", "velocity", "acceleration"} <= set(run.errors())
    assert run.errors()["acceleration"].total > run.errors()["displacement"].total


def test_clear_errors():
    system = pair_on_housing()
    with pytest.raises(gb.SceneError, match=r'^record: "acceleration" is that of the recorded'):
        system.simulate(1e-3, 100.0, record=["acceleration", "meshes"])
    with pytest.raises(gb.SceneError, match=r'^record\[1\]: "accelerations" is no gear'):
        system.simulate(1e-3, 100.0, record=["gears", "accelerations"])
    run = system.simulate(1e-3, 100.0, record=["gears", "velocity"])
    with pytest.raises(gb.ChannelError, match=r"acceleration of 'g1' was not recorded.*\['accel"):
        run.acceleration("g1")
    with pytest.raises(gb.ChannelError, match=r"motion of 'box' was not recorded.*\['box'"):
        run.velocity("box")
    with pytest.raises(gb.ChannelError, match=r"twist rate of 'g1' was not recorded.*\['velocity'"):
        system.simulate(1e-3, 100.0).twist_rate("g1")
    with pytest.raises(gb.ChannelError, match=r"acceleration of 'g1' was not recorded"):
        run.spectrum("g1", "acceleration_y")
