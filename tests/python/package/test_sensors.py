"""Probes, accelerometers, tachometers and sampling at a lower rate: closed forms, other programs, errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import gearbow as gb
from reference.machines import BETWEEN, bowed_rotor_with_disk, hostile, pair_on_housing

MIDDLE = ("rotor", 0.5)
#: Speed ratios of the default machine.
RATIOS = {"input": 1.0, "idler": -23 / 31, "middle": 23 / 47, "output": -23 * 29 / (47 * 53)}


# --- Probes


def test_a_slow_bowed_shaft_shows_bow_and_runout():
    """Far below its critical speed a shaft turns about its bearings: u = bow e^{iΩt}."""
    speed, runout = 0.1, 20e-6 * np.exp(0.7j)
    run = bowed_rotor_with_disk(disks=[]).simulate(70.0, speed, output_step=0.5, record=[MIDDLE])
    bow = 1e-4 * np.exp(0.4j)
    for angle in (0.0, 0.6, np.pi / 2, -2.0):
        probe = gb.Probe(*MIDDLE, angle=angle, runout=runout)
        # a probe at φ sees what has the angle φ − Ωt in the shaft
        expected = np.real((bow + runout) * np.exp(1j * (speed * run.time - angle)))
        assert run.measure(probe) == pytest.approx(expected, abs=1e-4 * abs(bow))


def test_forms_of_runout_agree():
    run = bowed_rotor_with_disk().simulate(0.1, 100.0, output_step=1e-3, record=[MIDDLE])
    angles = np.linspace(0.0, 2 * np.pi, 20000, endpoint=False)
    forms = [
        5e-6 * np.exp(0.3j),
        lambda angle: 5e-6 * np.cos(angle - 0.3),
        (angles, 5e-6 * np.cos(angles - 0.3)),
    ]
    first, second, third = (
        run.measure(gb.Probe(*MIDDLE, angle=1.0, runout=form)) for form in forms
    )
    assert second == pytest.approx(first, abs=1e-18)
    # linear interpolation of 20000 points
    assert third == pytest.approx(first, abs=1e-7 * 5e-6)
    twice = gb.Probe(*MIDDLE, runout=lambda angle: 1e-6 * np.cos(2 * angle))
    clean = run.measure(gb.Probe(*MIDDLE))
    assert run.measure(twice) - clean == pytest.approx(1e-6 * np.cos(200.0 * run.time), abs=1e-15)


def test_a_probe_on_a_support_measures_the_relative_motion():
    run = pair_on_housing().simulate(
        0.01, 100.0, record=["foot", ("output", 0.2), ("output", 0.4), "bearings"]
    )
    for angle, axis in ((0.0, 0), (np.pi / 2, 1)):
        probe = gb.Probe("output", 0.4, angle=angle, support="foot")
        relative = run.bearing_displacement(("output", 0.4))[:, axis]
        assert run.measure(probe) == pytest.approx(relative, abs=1e-12 * np.abs(relative).max())


@pytest.mark.parametrize("speed", [100.0, -60.0])
def test_the_runout_of_each_shaft_passes_at_its_own_speed(speed: float):
    places = [("idler", 0.2), BETWEEN, ("output", 0.17)]
    run = hostile().simulate(0.05, speed, record=places, output_step=1e-3)
    for shaft, x in places:
        probe = gb.Probe(shaft, x, angle=0.4, runout=1e-6j)
        error = run.measure(probe) - run.measure(gb.Probe(shaft, x, angle=0.4))
        turned = RATIOS[shaft] * speed * run.time + run.twist((shaft, x))
        assert error == pytest.approx(-1e-6 * np.sin(turned - 0.4), abs=1e-15)


# --- Accelerometers


def test_an_accelerometer_sees_the_component_in_its_direction():
    on_housing = pair_on_housing().simulate(2e-3, 200.0, record=["foot", "corner", "acceleration"])
    train = hostile().simulate(2e-3, -200.0, record=["gears", BETWEEN, "acceleration"])
    cases = [(on_housing, "foot"), (on_housing, "corner"), (train, "g4"), (train, BETWEEN)]
    for run, place in cases:
        a = run.acceleration(place)
        for angle in (0.0, 0.8, 2.0):
            along = a[:, 0] * np.cos(angle) + a[:, 1] * np.sin(angle)
            found = run.measure(gb.Accelerometer(place, angle=angle))
            assert found == pytest.approx(along, rel=1e-12, abs=1e-12 * np.abs(a).max())


# --- Tachometers


@pytest.mark.parametrize("speed", [100.0, -100.0])
def test_pulses_at_constant_speed(speed: float):
    run = hostile().simulate(0.2, speed, output_step=1e-3)
    for pulses, angle in ((1, 0.0), (1, 1.0), (7, -0.3)):
        for shaft, ratio in RATIOS.items():
            spin = ratio * speed
            found = run.measure(gb.Tacho(shaft, pulses, angle=angle))
            k = np.arange(-200, 201)
            times = np.sort((angle + 2 * np.pi * k / pulses) / spin)
            expected = times[(times >= 0.0) & (times < 0.2)]
            # the times are round numbers of the angle, not of the samples
            assert found == pytest.approx(expected, rel=1e-14, abs=1e-15)


def test_pulses_of_a_continued_run_continue():
    tacho = gb.Tacho("rotor", 5)
    first = bowed_rotor_with_disk().simulate(0.1, 100.0, output_step=1e-3)
    second = bowed_rotor_with_disk().simulate(0.1, 130.0, initial=first, output_step=1e-3)
    found = np.concatenate([first.measure(tacho), second.measure(tacho)])
    k = np.arange(0, 40) * 2 * np.pi / 5
    expected = np.where(k < 10.0, k / 100.0, 0.1 + (k - 10.0) / 130.0)
    assert found == pytest.approx(expected[expected < 0.2], abs=1e-14)


@pytest.mark.parametrize(
    ("profile", "angle"),
    [
        (gb.SpeedProfile.ramp(50.0, 400.0, 0.3), None),
        (gb.SpeedProfile.ramp(-100.0, -300.0, 0.3), None),
        (gb.SpeedProfile.table([0.0, 0.1, 0.2, 0.3], [0.0, 300.0, 300.0, 20.0]), None),
        (
            gb.SpeedProfile.function(lambda t: 200.0 + 30.0 * np.sin(40.0 * t), 0.3),
            lambda t: 200.0 * t + 0.75 * (1.0 - np.cos(40.0 * t)),
        ),
    ],
    ids=["ramp", "backwards", "table", "function"],
)
def test_pulses_at_changing_speed(profile: gb.SpeedProfile, angle: Any):
    run = bowed_rotor_with_disk().simulate(0.3, profile, output_step=1e-2)

    def turned(t: float) -> float:
        if angle:
            return float(angle(t))
        # trapezoids are exact between the breaks of a linear profile
        points = np.unique([0.0, *profile.breaks[profile.breaks < t], t])
        return float(np.trapezoid(profile(points), points))

    found = run.measure(gb.Tacho("rotor", 3))
    expected = []
    fine = np.linspace(0.0, 0.3, 3001)
    angles = np.array([turned(t) for t in fine]) * 3 / (2 * np.pi)
    for a, b, begin, end in zip(angles, angles[1:], fine, fine[1:], strict=False):
        for level in np.unique([np.ceil(min(a, b)), np.floor(max(a, b))]):
            if a <= level < b or b < level <= a:
                value = [turned(t) * 3 / (2 * np.pi) - level for t in (begin, end)]
                root = begin if value[0] == 0.0 else brentq(
                    lambda t, level=level: turned(t) * 3 / (2 * np.pi) - level,
                    begin, end, xtol=1e-16,
                )  # fmt: skip
                expected.append(root)
    assert found.size == len(expected) > 5
    # the function is approximated to 1e-10 of the speed
    assert found == pytest.approx(np.array(expected), abs=1e-11 if angle else 1e-13)


def test_pulses_with_twist():
    """Torsional vibration shifts the pulses by −θ/Ω; the twist between samples follows from its rate."""
    system, place = hostile(), BETWEEN
    fine = system.simulate(0.02, 200.0, output_step=1e-6, record=[place, "velocity"])
    coarse = system.simulate(0.02, 200.0, output_step=2e-5, record=[place, "velocity"])
    tacho = gb.Tacho("middle", 20, position=BETWEEN[1])
    found = coarse.measure(tacho)
    whole = fine.angle("middle") + fine.twist(place)
    k = np.arange(np.ceil(whole[0] * 20 / (2 * np.pi)), np.ceil(whole[-1] * 20 / (2 * np.pi)))
    # linear interpolation of samples a microsecond apart
    expected = np.interp(k * 2 * np.pi / 20, whole, fine.time)
    bare = coarse.measure(gb.Tacho("middle", 20))
    assert found == pytest.approx(expected, abs=1e-9)
    assert np.abs(found - bare[: found.size]).max() > 1e-7


# --- Sampling at a lower rate


def with_signal(run: gb.Response, values: np.ndarray) -> gb.Response:
    """Replace the displacements of a recorded run by a signal."""
    record = run._to_record()
    displacement = np.repeat(values[:, None, None], record.data["displacement"].shape[1], 1)
    data: Any = {**record.data, "displacement": np.repeat(displacement, 2, 2)}
    return gb.Response._from_record(
        type(record)(data, record.speed, record.kinematics, record.accuracy, record.request)
    )


@pytest.fixture(scope="module")
def base() -> gb.Response:
    return bowed_rotor_with_disk().simulate(0.1, 100.0, output_step=1e-5, record=["disk"])


@pytest.mark.parametrize("rate", [1000.0, 3333.3, 25600.0])
def test_a_tone_above_half_of_the_rate_disappears(base: gb.Response, rate: float):
    for ratio in (0.501, 0.6, 0.9, 1.0, 1.37, 2.6):
        tone = np.cos(2 * np.pi * ratio * rate * base.time + 0.3)
        found = with_signal(base, tone).resample(rate).displacement("disk")
        assert np.abs(found).max() < 1.5e-4
        # sampling alone makes a tone of full size of it
        assert np.abs(np.interp(np.arange(20, 80) / rate, base.time, tone)).max() > 0.5


@pytest.mark.parametrize("rate", [1000.0, 3333.3, 25600.0])
def test_a_tone_below_passes_without_a_change(base: gb.Response, rate: float):
    for ratio in (0.0, 1e-3, 0.1, 0.3, 0.399):
        sampled = with_signal(base, np.cos(2 * np.pi * ratio * rate * base.time + 0.3))
        found = sampled.resample(rate)
        expected = np.cos(2 * np.pi * ratio * rate * found.time + 0.3)
        assert found.displacement("disk")[:, 0] == pytest.approx(expected, abs=1.5e-4)
        assert np.diff(found.time) == pytest.approx(1.0 / rate, rel=1e-9)
        assert found.time[0] == pytest.approx(25.1 / rate, abs=1.0 / rate)


def test_every_array_is_sampled(tmp_path: Any):
    record = ["gears", "meshes", "bearings", "energy", "velocity", "acceleration"]
    run = hostile().simulate(0.02, 200.0, output_step=1e-5, record=record)
    found = run.resample(1e4)
    size = found.time.size
    assert 120 < size < 160
    table = found.to_dataframe()
    assert len(table) == size
    assert list(table) == list(run.to_dataframe())
    assert np.all(np.isfinite(table.to_numpy()))
    found.save(tmp_path / "run.npz")
    again = gb.Response.load(tmp_path / "run.npz")
    assert np.array_equal(again.acceleration("g1"), found.acceleration("g1"))
    assert found.events == run.events
    assert found.measure(gb.Tacho("input")).size <= run.measure(gb.Tacho("input")).size
    # filtering and differentiation commute: the filtered velocity is the rate of the filtered motion
    rate = np.gradient(found.displacement("g1")[:, 0], found.time)
    velocity = found.velocity("g1")[:, 0]
    assert np.corrcoef(rate, velocity)[0, 1] > 0.9


# --- Spectra, tables, errors


def test_sensors_in_spectra_orders_and_tables():
    run = bowed_rotor_with_disk().simulate(0.5, 120.0, record=[MIDDLE, "acceleration"])
    probe, sensor = gb.Probe(*MIDDLE, angle=np.pi / 4), gb.Accelerometer(MIDDLE)
    spectrum = run.spectrum(probe)
    assert (spectrum.label, spectrum.unit) == ("probe rotor at 0.5 m, 45°", "m")
    amplitude = run.orders(probe).amplitude("1× rotor")
    assert amplitude == pytest.approx(run.orders(MIDDLE, "y").amplitude("1× rotor"), rel=1e-9)
    rate = run.orders(sensor).amplitude("1× rotor")
    assert rate == pytest.approx(120.0**2 * amplitude, rel=1e-9)
    table = run.to_dataframe(sensors=[probe, sensor])
    assert np.array_equal(table["probe rotor at 0.5 m, 45° [m]"], run.measure(probe))
    name = "accelerometer rotor at 0.5 m, 0° [m/s²]"
    assert np.array_equal(table[name], run.measure(sensor))


# The relation is one of fits, and holds for each record: this one is short.
@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_orders_of_a_probe_are_the_components_of_those_of_its_place():
    run = hostile().simulate(0.3, -120.0, record=[BETWEEN, "acceleration"], output_step=2e-4)
    for angle in (np.pi / 4, -2.0):
        probe, sensor = gb.Probe(*BETWEEN, angle=angle), gb.Accelerometer(BETWEEN, angle=angle)
        for of, parts in ((probe, ("y", "z")), (sensor, ("acceleration_y", "acceleration_z"))):
            found, y, z = (
                run.orders(*given, mesh_harmonics=1)
                for given in ((of,), *((BETWEEN, part) for part in parts))
            )
            # the fit is linear in the signal: round-off
            expected = y.amplitudes * np.cos(angle) + z.amplitudes * np.sin(angle)
            scale = np.abs(expected).max()
            assert found.amplitudes == pytest.approx(expected, rel=1e-9, abs=1e-11 * scale)


def test_angles_and_spins_of_shafts():
    run = hostile().simulate(0.01, -100.0)
    for shaft, ratio in RATIOS.items():
        assert run.angle(shaft) == pytest.approx(-100.0 * ratio * run.time, rel=1e-14)
        assert run.spin(shaft, [0.0, 1.0]) == pytest.approx(2 * [-100.0 * ratio])
    profile = gb.SpeedProfile.table([0.1, 0.3, 0.4], [10.0, 50.0, 20.0])
    exact = [-1.0, 0.0, 2.0, 6.0, 9.5, 9.5 + 2.0]
    assert profile.angle([0.0, 0.1, 0.2, 0.3, 0.4, 0.5]) == pytest.approx(exact, abs=1e-12)


def test_clear_errors():
    run = bowed_rotor_with_disk().simulate(0.1, 100.0, output_step=1e-3, record=["disk"])
    cases: list[tuple[Any, type[Exception], str]] = [
        (lambda: gb.Probe("rotor", np.nan), gb.SceneError, r"^probe\.position: "),
        (lambda: gb.Probe("rotor", 0.1, angle=np.inf), gb.SceneError, r"^probe\.angle: "),
        (lambda: gb.Probe("rotor", 0.1, runout="a"), gb.SceneError, r"^probe\.runout: "),
        (lambda: gb.Probe("rotor", 0.1, runout=([0, 1], [2])), gb.SceneError, r"as many angles"),
        (lambda: gb.Probe(3, 0.1), gb.SceneError, r"^probe\.shaft: must be text"),
        (lambda: gb.Accelerometer(3), gb.SceneError, r"^accelerometer\.at: "),
        (lambda: gb.Tacho("rotor", 0), gb.SceneError, r"^tacho\.pulses: "),
        (lambda: gb.Tacho("rotor", 1.5), gb.SceneError, r"^tacho\.pulses: "),
        (lambda: run.measure("probe"), gb.SceneError, r"^sensor: must be a Probe"),
        (lambda: run.measure(gb.Probe("rotor", 0.3)), gb.ChannelError, r"\('rotor', 0.3\) was not"),
        (lambda: run.measure(gb.Accelerometer("disk")), gb.ChannelError, r"\['acceleration'"),
        (lambda: run.measure(gb.Tacho("shaft")), gb.ChannelError, r"no shaft is called 'shaft'"),
        (
            lambda: run.measure(gb.Tacho("rotor", position=0.5)),
            gb.ChannelError,
            r"twist rate of .* was not recorded.*\['velocity'",
        ),
        (lambda: run.spectrum(gb.Probe(*MIDDLE), "y"), gb.ChannelError, r"^quantity: a sensor"),
        (lambda: run.resample(2000.0), gb.GearbowError, r"^rate: .* at most .* 1000 Hz, got 2000"),
        (lambda: run.resample(-1.0), gb.GearbowError, r"^rate: must be positive"),
        (lambda: run.resample(100.0), gb.GearbowError, r"shorter than the filter"),
        (lambda: run.resample(np.nan), gb.SceneError, r"^rate: "),
    ]
    for call, kind, text in cases:
        with pytest.raises(kind, match=text):
            call()
    uneven = bowed_rotor_with_disk().simulate(0.1, 100.0, times=[0.0, 0.01, 0.1], record=["disk"])
    with pytest.raises(gb.GearbowError, match="equally spaced"):
        uneven.resample(10.0)
