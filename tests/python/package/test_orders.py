"""Spectra and order analysis recover the components of a signal."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
import pytest

import gearbow as gb
from gearbow._types import SensitivityQuantity, SignalQuantity
from gearbow.description.layout import Order
from gearbow.orders import Kinematics, spectrum
from gearbow.orders.separation import Sampling, SignalSegment, cut, fit, significant
from gearbow.orders.spectrum import WINDOWS, amplitudes
from gearbow.recording.record import SECTION_FORCES
from gearbow.system import response_sensitivity
from reference.machines import bowed_pair, hostile, inertia, rotor, without_tooth_errors
from test_response import recorded

SPEED = 100.0


def made(duration=1.0, step=1e-4, start=0.0, speed=SPEED, system=None, **content):
    """Return a response whose g1 y is a sum of orders, {name of the order: complex amplitude}."""
    rows = round(duration / step)
    response = recorded(rows=rows)
    response._data["time"] = start + step * np.arange(rows)
    response.speed = speed
    response.kinematics = Kinematics.of(system or bowed_pair())
    motion = np.zeros((rows, 3, 2))
    angle = response.angle("input")
    for value, amplitude in content.values():
        motion[:, 0, 0] += np.real(amplitude * np.exp(1j * value * np.abs(angle)))
    response._data["displacement"] = motion + 7e-6
    return response


PAIR = {
    "1× input": (1.0, 3e-6 - 1e-6j),
    "1× output": (0.5, 2e-6j),
    "1× mesh g1–g2": (25.0, 1e-7 + 0j),
    "1× mesh g1–g2 − 1× output": (24.5, -4e-8 + 0j),
    "3× mesh g1–g2 + 1× input": (76.0, 5e-9j),
}
#: The speeds of the shafts follow from the numbers of teeth.
MIDDLE, OUTPUT = 23 / 47, 23 * 29 / (47 * 53)
HOSTILE = {
    "1× input": (1.0, 3e-6 - 1e-6j),
    "1× output": (OUTPUT, 2e-6j),
    "1× mesh g4–g5": (29 * MIDDLE, 1e-7 + 0j),
    "1× mesh g4–g5 − 1× output": (29 * MIDDLE - OUTPUT, -4e-8 + 0j),
    "3× mesh g2–g3 + 1× middle": (69.0 + MIDDLE, 5e-9j),
}


@pytest.mark.parametrize(
    ("system", "speed", "content"),
    [(bowed_pair, SPEED, PAIR), (hostile, -SPEED, HOSTILE)],
    ids=["pair", "backwards"],
)
def test_least_squares_recover_amplitude_and_phase_of_every_order(system, speed, content):
    # 5.37 s is not a whole number of revolutions, and the record does not start at 0.
    found = made(5.37, 2e-4, 0.21, speed, system(), **content).orders("g1", "y")
    names = {name: j for j, order in enumerate(found.orders) for name in order.names}
    for name, (value, amplitude) in content.items():
        assert found.orders[names[name]].value == pytest.approx(value)
        # Round-off of 1e4 values of 1e-5 m in a well-conditioned fit.
        assert abs(found.amplitudes[names[name]] - amplitude) < 1e-18
        assert found.amplitude(name) == pytest.approx(abs(amplitude), abs=1e-18)
    assert found.mean == pytest.approx(7e-6, rel=1e-12)
    assert found.rest < 1e-18
    others = set(range(len(found.orders))) - {names[name] for name in content}
    assert max(abs(found.amplitudes[j]) for j in others) < 1e-18


def test_the_residual_of_the_fit_is_the_part_outside_all_orders():
    with pytest.warns(gb.AccuracyWarning, match=r"^orders: 100 % of the RMS of g1 y is not at"):
        found = made(2.0, stray=(3.77, 1e-6)).orders("g1", "y")
    assert found.rest_share == pytest.approx(1.0, abs=0.01)
    assert "rest 0.71 µm RMS (99.9 % of the motion)" in found.table()
    # The RMS of a sine; the fit absorbs a small part of it.
    assert found.rest == pytest.approx(1e-6 / np.sqrt(2.0), rel=0.02)


def test_the_default_contains_significant_higher_harmonics():
    content = {
        "1× mesh": (25.0, 1e-6 + 0j),
        "7× mesh": (175.0, 3e-6j),
        "7× mesh + 1× input": (176.0, 1e-6 + 0j),
        "9× mesh": (225.0, 1e-9 + 0j),
        "31× mesh": (775.0, 1e-7 + 0j),
    }
    found = made(1.0, **content).orders("g1", "y")
    # The lines outside the fit disturb it by 2e-5.
    assert found.amplitude("7× mesh g1–g2") == pytest.approx(3e-6, rel=1e-4)
    assert found.amplitude("7× mesh g1–g2 + 1× input") == pytest.approx(1e-6, rel=1e-4)
    # The ninth harmonic is below 1 % of the largest; the default ends with the thirtieth.
    values = {round(order.value, 6) for order in found.orders}
    assert not {225.0, 775.0} & values
    assert {50.0, 75.0} < values
    assert found.rest == pytest.approx(1e-7 / np.sqrt(2.0), rel=0.01)
    assert found.rest_share == pytest.approx(
        1e-7 / np.sqrt(1e-12 + 9e-12 + 1e-12 + 1e-14), rel=0.01
    )
    fixed = made(1.0, **content)
    with pytest.warns(gb.AccuracyWarning, match=r"of the RMS of g1 y is not at these orders"):
        assert max(o.value for o in fixed.orders("g1", "y", mesh_harmonics=3).orders) == 76.0


def test_the_default_takes_only_what_the_record_resolves_and_separates():
    # 0.25 s separate orders with a distance of 0.126.
    response = made(0.25, 1e-4, a=(25.0, 1e-6 + 0j), b=(125.0, 1e-6 + 0j))
    found = response.orders("g1", "y")
    assert found.amplitude("5× mesh g1–g2") == pytest.approx(1e-6)
    assert found.rest < 1e-12
    # A step of 0.4 ms resolves orders below 78.5: the fourth harmonic appears as another order.
    coarse = made(1.0, 4e-4, a=(25.0, 1e-6 + 0j), b=(100.0, 1e-6 + 0j))
    with pytest.warns(gb.AccuracyWarning, match="is not at these orders"):
        assert max(order.value for order in coarse.orders("g1", "y").orders) == 76.0


def test_a_signal_at_rest_has_no_rest():
    found = made(1.0, a=(0.0, 1e-6 + 0j)).orders("g1", "y")
    assert found.rest_share <= 1.0
    assert max(order.value for order in found.orders) == 76.0


def test_coinciding_orders_are_one_order_with_all_names():
    orders = Kinematics.of(bowed_pair()).orders(2, 0, 0)
    assert [(order.value, order.names) for order in orders] == [
        (0.5, ("1× output",)),
        (1.0, ("1× input", "2× output")),
        (2.0, ("2× input",)),
    ]
    assert str(orders[1]) == "1× input = 2× output"


def test_orders_of_a_train_are_relative_to_the_reference_shaft():
    middle, output = 23 / 47, 23 * 29 / (47 * 53)
    found = {order.names[0]: order.value for order in Kinematics.of(hostile()).orders(1, 1, 1)}
    expected = {"idler": 23 / 31, "middle": middle, "output": output}
    expected = {f"1× {name}": value for name, value in expected.items()}
    expected |= {"1× mesh g1–g2": 23.0, "1× mesh g4–g5": 29 * middle}
    expected["1× mesh g4–g5 − 1× output"] = 29 * middle - output
    expected["1× mesh g2–g3 + 1× middle"] = 23.0 + middle
    assert {name: found[name] for name in expected} == pytest.approx(expected)


def test_without_sidebands_an_order_has_each_name_once():
    orders = Kinematics.of(bowed_pair()).orders(0, 1, 0)
    assert [(order.value, order.names) for order in orders] == [(25.0, ("1× mesh g1–g2",))]


def test_a_table_lists_the_largest_first():
    table = made(a=(1.0, 3e-6), b=(25.0, 5e-6)).orders("g1").table(2).splitlines()
    assert len(table) == 4
    assert table[0].startswith("orders of g1 y at 100 rad/s: mean 7 µm")
    assert table[2].endswith("1× mesh g1–g2")
    assert table[3].endswith("1× input = 2× output")


def test_a_short_coarse_record_has_all_reasons_and_remedies_in_one_warning():
    # 0.6 revolutions of the input shaft separate orders with a distance of 0.83; a step of 8 ms
    # resolves orders below 3.9
    with pytest.warns(gb.AccuracyWarning) as caught:
        found = made(0.0378, 8e-3, a=(1.0, 1e-6 + 0j)).orders("g1", "y")
    (message,) = [str(w.message) for w in caught]
    for part in (
        "in a record of 0.032 s", "cannot be separated from the mean", "less than two samples",
        "simulate for", "reduce output_step from 0.008 s to 0.00041 s", "fewer orders",
    ):  # fmt: skip
        assert part in message
    with pytest.raises(gb.GearbowError, match="times are too far apart for '1× mesh g1–g2'"):
        found.amplitude("1× mesh g1–g2")
    with pytest.raises(gb.GearbowError, match="too short to separate '1× output' from the mean"):
        found.amplitude("1× output")


def test_orders_that_a_record_does_not_separate_share_one_amplitude():
    # 0.8 revolutions: the sideband at 25.5 belongs to 25, that at 26 does not
    with pytest.warns(gb.AccuracyWarning, match=r"share 7 amplitudes .*'1× mesh g1–g2' with"):
        found = made(0.0503, 1e-5, a=(25.0, 1e-6 + 0j), b=(1.0, 2e-6j)).orders("g1", "y")
    assert found.amplitude("1× mesh g1–g2 + 1× output") == found.amplitude("1× mesh g1–g2")
    assert found.amplitude("1× mesh g1–g2") == pytest.approx(1e-6, rel=1e-6)
    assert found.amplitude("1× input") == pytest.approx(2e-6, rel=1e-6)
    assert found.rest < 1e-12


def test_an_unknown_name_and_a_train_at_rest_are_refused():
    response = made()
    with pytest.raises(gb.GearbowError, match="no order is called '9× input'"):
        response.orders("g1", "y").amplitude("9× input")
    with pytest.raises(gb.GearbowError, match="revolutions: must be positive and at most the 15"):
        response.orders("g1", revolutions=16.0)
    response.speed = 0.0
    with pytest.raises(gb.GearbowError, match="need a rotating train"):
        response.orders("g1")


# --- Changing speed


def run_up(duration=20.0, step=1e-3, begin=0.0, end=300.0, **content):
    """Return a run-up whose g1 y is a sum of orders, {name: (order, amplitude over the angle)}."""
    response = made(duration, step)
    response.speed = gb.SpeedProfile.ramp(begin, end, duration=duration)
    motion = np.zeros((response.time.size, 3, 2))
    angle = response.angle("input")
    for value, amplitude in content.values():
        size = amplitude(angle) if callable(amplitude) else amplitude
        motion[:, 0, 0] += np.real(size * np.exp(1j * value * np.abs(angle)))
    response._data["displacement"] = motion + 7e-6
    return response


@pytest.mark.parametrize(("begin", "end"), [(0.0, 300.0), (300.0, 20.0), (-10.0, -300.0)])
def test_the_orders_of_a_chirp_have_their_amplitudes(begin, end):
    content = {"1× input": (1.0, 3e-6 - 1e-6j), "1× output": (0.5, 2e-6j), "2× input": (2.0, 5e-7)}
    run = run_up(begin=begin, end=end, **content)
    found = run.orders("g1", "y", mesh_harmonics=0)
    for name, (_, amplitude) in content.items():
        # the signal belongs to the model: round-off
        assert found.track(name) == pytest.approx(abs(amplitude), rel=1e-9)
        assert found.amplitude(name) == pytest.approx(abs(amplitude), rel=1e-9)
    assert found.tracks[:, found._index("1× input")] == pytest.approx(3e-6 - 1e-6j, rel=1e-9)
    assert found.rest < 1e-12
    assert found.times.shape == found.speeds.shape == (len(found.tracks),)
    assert found.speeds == pytest.approx(np.abs(begin + (end - begin) * found.times / 20.0))
    # the times are the middles of segments of one length, which begin and end with the record
    turned = begin * found.times + (end - begin) * found.times**2 / 40.0
    last = begin * run.time[-1] + (end - begin) * run.time[-1] ** 2 / 40.0
    assert turned[0] == pytest.approx(last - turned[-1], rel=1e-3)  # of interpolated times
    assert np.diff(turned) == pytest.approx((turned[-1] - turned[0]) / (turned.size - 1), rel=1e-2)


def test_amplitudes_that_change_over_the_speed_are_followed():
    # 477 revolutions; amplitudes with periods of 100 and 60 revolutions, and a foreign order 3.3
    def slow(angle):
        return 2e-6 * (1.0 + 0.5 * np.cos(angle / 100.0))

    def turning(angle):
        return 1e-6 * np.exp(1j * angle / 60.0)

    run = run_up(a=(1.0, slow), b=(0.5, turning), c=(3.3, 1e-8))
    found = run.orders("g1", "y", mesh_harmonics=0)
    angle = run.angle("input", found.times)
    assert found.track("1× input") == pytest.approx(slow(angle), rel=0.01)
    assert found.track("1× output") == pytest.approx(1e-6, rel=0.01)
    assert found.rest == pytest.approx(1e-8 / np.sqrt(2.0), rel=0.05)


def test_samples_that_divide_a_period_evenly_have_the_amplitudes_of_least_squares():
    random = np.random.default_rng(5)
    period, count = 3.0, 501
    orders = tuple(Order(number / period, (f"{number}",)) for number in (1, 2, 7, 30))
    more = [Order(number / period, (f"{number}",)) for number in (9, 60)]
    turns = 0.4 + period * np.arange(count) / count
    values = random.normal(size=count)
    sampling = Sampling(period, 0.5, count, 1, period / count, 1e-3, 10.0, is_segment=False)
    even, uneven = (cut(turns, values, None, given) for given in (period, None))
    assert (even[0].period, uneven[0].period) == (period, None)
    # a sample at another place leaves least squares
    late = turns + 1e-3 * period / count * (np.arange(count) == 100)
    assert cut(late, values, None, period)[0].period is None
    found, exact = fit(even, orders), fit(uneven, orders)
    np.testing.assert_allclose(found.amplitudes, exact.amplitudes, atol=1e-12)
    np.testing.assert_allclose(found.means, exact.means, atol=1e-12)
    np.testing.assert_allclose(found.remainders[0], exact.remainders[0], atol=1e-12)
    taken = significant(even, found, more, sampling)
    assert taken
    assert taken == significant(uneven, exact, more, sampling)


def test_amplitudes_of_a_segment_are_those_of_its_middle():
    turns = np.linspace(0.0, 40.0, 8001)
    orders = (Order(1.0, ("1",)), Order(2.5, ("2.5",)))
    # Parabolas of complex amplitudes, which the fit of a segment contains.
    exact = [
        lambda t: (2.0 - 1.0j) + (0.05j - 0.1) * t + 3e-3 * t**2,
        lambda t: 0.3j + 0.04 * t - 2e-3j * t**2,
    ]
    waves = [
        np.real(of(turns) * np.exp(2j * np.pi * order.value * turns))
        for order, of in zip(orders, exact, strict=True)
    ]
    segments = cut(turns, 1.5 - 0.02 * turns + np.sum(waves, axis=0), 8.0)
    found = fit(segments, orders)
    centres = np.array([segment.centre for segment in segments])
    assert centres.size > 10
    # round-off of normal equations with a condition of 1e4
    assert found.means == pytest.approx(1.5 - 0.02 * centres, rel=1e-9)
    for j, of in enumerate(exact):
        assert found.amplitudes[:, j] == pytest.approx(of(centres), rel=1e-9)


def test_the_window_of_a_record_ends_at_its_ends():
    turns = np.linspace(3.7, 8.2, 101)
    window = SignalSegment(5.95, turns, turns).window
    assert window == pytest.approx(window[::-1], abs=1e-15)
    assert window[0] == pytest.approx(0.0, abs=1e-15)
    assert (window.sum(), window.argmax()) == (pytest.approx(1.0), 50)


def test_higher_harmonics_of_a_run_up_are_found():
    found = run_up(step=1e-4, end=150.0, a=(25.0, 1e-6), b=(125.0, 3e-7)).orders("g1", "y")
    assert found.track("5× mesh g1–g2") == pytest.approx(3e-7, rel=1e-6)


def test_the_segments_of_a_settled_run_agree_with_the_complete_record():
    response = made(3.0, a=(1.0, 3e-6 - 1e-6j), b=(25.0, 1e-6j), c=(25.5, 2e-7), d=(3.77, 1e-9))
    complete = response.orders("g1", "y", mesh_harmonics=1)
    segments = response.orders("g1", "y", mesh_harmonics=1, revolutions=10.0)
    assert complete.tracks.shape == (1, len(complete.orders))
    assert [o.names for o in segments.orders] == [o.names for o in complete.orders]
    # the foreign order disturbs both by a part of its amplitude
    assert np.abs(segments.tracks - complete.amplitudes).max() < 1e-9
    profile = made(3.0, a=(1.0, 3e-6 - 1e-6j), b=(25.0, 1e-6j), c=(25.5, 2e-7), d=(3.77, 1e-9))
    profile.speed = gb.SpeedProfile.ramp(SPEED, SPEED, duration=3.0)
    constant = profile.orders("g1", "y", mesh_harmonics=1, revolutions=10.0)
    assert np.abs(constant.tracks - segments.tracks).max() < 1e-15
    assert constant.plot().axes[0].get_xlabel() == "time [s]"


def test_the_peak_of_a_run_up_through_a_resonance_is_that_of_the_exact_envelope():
    # a bowed shaft through its first critical speed; both directions have one frequency, so that
    # y + iz is a complex envelope times the rotation
    shaft = {"elements": None, "bow": gb.Bow.half_sine(2e-5)}
    system = rotor(shaft, inertia(20.0, 0.1, 0.0), modal_damping=0.02)
    critical = 2.0 * np.pi * system.modes(count=1).frequencies_hz[0]
    profile = gb.SpeedProfile.ramp(0.3 * critical, 1.7 * critical, duration=6.0)
    run = system.simulate(6.0, profile, output_step=4e-4, record=["disk"], rtol=1e-8)
    exact = np.linalg.norm(run.displacement("disk"), axis=1)
    found = run.orders("disk", "y")
    # 3 % of the peak, at the peak and everywhere between the segments
    assert found.amplitude("1× rotor") == pytest.approx(exact.max(), rel=0.03)
    at_segments = np.interp(found.times, run.time, exact)
    assert np.abs(found.track("1× rotor") - at_segments).max() < 0.03 * exact.max()
    settled = np.abs(system.synchronous(critical).displacement("disk")[0, 0, 0])
    assert 0.5 * settled < exact.max() < settled
    panel = found.plot(speed_unit="rpm").axes[0]
    assert panel.get_xlabel() == "speed of the reference shaft [rpm]"
    # an order of the frequency that the segments separate from no other one
    with pytest.warns(gb.AccuracyWarning, match=r"segments of 2 revolutions, .* revolutions=4"):
        run.orders("disk", "y", revolutions=2.0)


def test_a_run_up_is_sampled_at_equal_angles():
    run = run_up(begin=10.0, a=(1.0, 3e-6), b=(0.5, 2e-6j))
    for shaft, samples in (("input", 16), ("output", 32)):
        found = run.resample(samples, shaft=shaft)
        turns = np.abs(found.angle(shaft)) / (2.0 * np.pi) * samples
        assert turns == pytest.approx(np.rint(turns), abs=1e-6)
        assert np.diff(turns) == pytest.approx(1.0)
        angle = np.abs(found.angle("input"))
        expected = 7e-6 + 3e-6 * np.cos(angle) - 2e-6 * np.sin(0.5 * angle)
        # the ripple of the filter is 1e-4; the shaft turns by 0.3 of a sample between two times
        assert found.displacement("g1")[:, 0] == pytest.approx(expected, abs=6e-10)
    with pytest.raises(gb.ChannelError, match="no shaft is called 'middle'"):
        run.resample(16, shaft="middle")
    with pytest.raises(gb.GearbowError, match=r"at most .* 20\.9.* in a revolution of 'input'"):
        run.resample(64, shaft="input")


def test_histories_over_speed_and_angle():
    run = run_up(begin=10.0, a=(1.0, 3e-6))
    panel = run.plot("history", "g1", against="speed", speed_unit="rpm").axes[0]
    assert panel.get_xlabel() == "speed of the reference shaft [rpm]"
    x, y = panel.lines[0].get_data()
    assert x == pytest.approx(run.speeds * 30.0 / np.pi)
    assert y.size == run.time.size
    panel = run.plot("mesh", against="angle").axes[-1]
    assert panel.get_xlabel() == "angle of the reference shaft [revolutions]"
    assert panel.lines[0].get_xdata()[-1] == pytest.approx(run.angle("input")[-1] / (2.0 * np.pi))
    with pytest.raises(gb.GearbowError, match="the figure 'orbits' has no axis of time"):
        run.plot("orbits", against="speed")
    with pytest.raises(gb.GearbowError, match="speed of this run is constant"):
        made().plot("history", against="speed")
    with pytest.raises(gb.SceneError, match="against: must be one of"):
        run.plot("history", against="rpm")


def test_a_waterfall_of_a_run_up_has_the_amplitudes_of_its_orders():
    run = run_up(begin=50.0, a=(1.0, 3e-6), b=(2.0, 1e-6))
    found = gb.waterfall(run, "g1", "y", window="flat top")
    assert found.amplitudes.shape == found.frequencies_hz.shape
    orders = found.frequencies_hz * 2.0 * np.pi / found.speeds[:, np.newaxis]
    for value, amplitude in ((1.0, 3e-6), (2.0, 1e-6)):
        near = np.abs(orders - value) < 0.3
        peaks = np.where(near, found.amplitudes, 0.0).max(axis=1)
        assert peaks == pytest.approx(amplitude, rel=0.01)
    assert np.all(np.diff(found.speeds) > 0.0)
    assert 50.0 < found.speeds[0] < 100.0
    assert 280.0 < found.speeds[-1] < 300.0
    panel = found.plot(speed_unit="rpm").axes[0]
    assert "1× input" in {text.get_text() for text in panel.texts}
    printed = [float(row.split()[-1]) for row in found.table().splitlines()[2:]]
    assert printed == pytest.approx(61 * [1.0], abs=0.02)  # half the distance of its lines
    table = found.to_dataframe()
    assert table["frequency [Hz]"].to_numpy() == pytest.approx(found.frequencies_hz.ravel())
    fine = gb.waterfall(run, "g1", "y", revolutions=50.0)
    assert fine.frequencies_hz[0, 0] * 2.0 * np.pi / fine.speeds[0] == pytest.approx(1 / 50)
    for call, message in (
        (lambda: gb.waterfall([run], "g1"), "several runs needs constant speeds"),
        (lambda: gb.waterfall([made()], "g1", revolutions=3.0), "only one run-up has segments"),
        (lambda: gb.waterfall(run, "g1", revolutions=1e4), "revolutions: must be positive"),
    ):
        with pytest.raises(gb.GearbowError, match=message):
            call()


@pytest.mark.parametrize("window", list(WINDOWS))
def test_a_sine_at_a_spectral_line_has_its_amplitude(window):
    time = np.arange(1000) * 1e-3
    signal = 4.0 + 3.0 * np.cos(2 * np.pi * 50.0 * time + 0.3)
    frequency, amplitude = amplitudes(time, signal, window)
    peak = np.argmax(amplitude)
    assert frequency[peak] == pytest.approx(50.0)
    # The published coefficients of the flat top have nine digits.
    assert amplitude[peak] == pytest.approx(3.0, rel=1e-8)


def test_a_flat_top_window_gives_the_amplitude_between_lines():
    time = np.arange(1000) * 1e-3
    _, amplitude = amplitudes(time, np.cos(2 * np.pi * 50.5 * time), "flat top")
    assert amplitude.max() == pytest.approx(1.0, rel=2e-3)  # 0.01 dB of Heinzel et al.
    _, hann = amplitudes(time, np.cos(2 * np.pi * 50.5 * time), "hann")
    assert hann.max() == pytest.approx(0.849, rel=1e-2)  # its scalloping loss, 1.42 dB


@pytest.mark.parametrize(
    ("of", "quantity", "label", "unit"),
    [
        ("g1", None, "g1 y", "m"),
        (("input", 0.1), "z", "input at 0.1 m z", "m"),
        ("g2", "twist", "g2 twist", "rad"),
        (("g1", "g2"), None, "g1/g2 force", "N"),
        (("g1", "g2"), "contact_ratio", "g1/g2 contact ratio", "1"),
        (("bearing", "input", 0.0), "z", "bearing input at 0 m z", "N"),
        ("energy", None, "energy", "J"),
    ],
)
def test_every_channel_has_a_spectrum(of, quantity, label, unit):
    spectrum = recorded(rows=64).spectrum(of, quantity)
    assert (spectrum.label, spectrum.unit) == (label, unit)
    assert spectrum.amplitudes.shape == spectrum.frequencies_hz.shape == (32,)
    written = "µm" if unit == "m" else unit
    assert spectrum.plot().axes[0].get_ylabel() == f"{label} [{written}]"


def test_the_error_names_the_invalid_argument():
    response = recorded(rows=64)
    with pytest.raises(gb.ChannelError, match=r"has y, z, twist, x, velocity_y, .*, got 'v'"):
        response.spectrum("g1", "v")
    with pytest.raises(gb.ChannelError, match="was not recorded"):
        response.spectrum("g7")
    with pytest.raises(gb.SceneError, match="window: must be one of"):
        response.spectrum("g1", window="box")
    with pytest.raises(gb.GearbowError, match="unknown"):
        response.orders("g1")


def test_bow_and_unbalance_appear_at_the_order_of_their_shaft(tmp_path):
    system, speed = hostile(), -SPEED
    response = system.simulate(0.6, speed, output_step=2e-4, record=["gears"], geometry="frozen")
    linear = system.synchronous([speed])
    few: dict[str, Any] = {"skip_time": 0.1, "shaft_harmonics": 1, "mesh_harmonics": 1}
    for j, gear in enumerate(["g1", "g2", "g4", "g5"]):
        found, expected = response.orders(gear, "y", **few), linear.displacement(gear)[0, j, 0]
        # what the teeth add to the linear motion at once per turn
        assert found.amplitude(f"1× {linear.shafts[j]}") == pytest.approx(abs(expected), rel=1e-2)
        assert found.rest < 3e-2 * abs(expected)  # sidebands of the teeth, and the transient
    response.save(tmp_path / "run.npz")
    again = gb.Response.load(tmp_path / "run.npz")
    assert again.kinematics == response.kinematics
    repeated = again.orders("g5", "y", **few)
    np.testing.assert_array_equal(repeated.amplitudes, found.amplitudes)
    assert len(found.plot(5).axes[0].get_yticks()) == 5


def test_a_waterfall_has_a_ridge_along_each_order():
    system = bowed_pair()
    speeds = (150.0, 50.0, 100.0)
    runs = [system.simulate(1.0, speed, output_step=1e-3, record=["g1"]) for speed in speeds]
    result = gb.waterfall(runs, "g1")
    np.testing.assert_array_equal(result.speeds, (50.0, 100.0, 150.0))
    peaks = result.frequencies_hz[result.amplitudes.argmax(axis=1)]
    # A record of 1 s has a line spacing of 1 Hz.
    np.testing.assert_allclose(peaks, result.speeds / (2 * np.pi), atol=0.51)
    panel = result.plot().axes[0]
    assert "1× input" in {text.get_text() for text in panel.texts}
    # white lines at the frequencies of the orders, from the lowest to the highest speed
    lines = [line for line in panel.lines if line.get_color() == "white"]
    assert lines
    for line in lines:
        path = line.get_xydata()
        assert (path[0, 1], path[-1, 1]) == pytest.approx(panel.get_ylim())
        seen = path[np.isfinite(path[:, 0])]
        order = seen[:, 0] * 2.0 * np.pi / seen[:, 1]
        assert order == pytest.approx(np.full(order.size, order.mean()), rel=1e-9)
    with pytest.raises(gb.GearbowError, match="different frequencies"):
        gb.waterfall([runs[0], system.simulate(0.5, 50.0, output_step=1e-3)], "g1")
    with pytest.raises(
        gb.GearbowError, match=r"^responses: must be a list of at least one response"
    ):
        gb.waterfall([], "g1")


def test_the_order_of_a_force_is_among_the_orders(tmp_path):
    # order 2.5 of the output shaft, which turns forwards at a negative speed, and −2 of the idler
    speed, forces = -SPEED, [gb.Force("g5", 50.0, order=2.5), gb.Force("g2", 1.0, order=-2)]
    system = without_tooth_errors(hostile()).replace(forces=forces)
    kinematics = Kinematics.of(system)
    names = {name: order.value for order in kinematics.orders() for name in order.names}
    assert names["2.5× force at g5"] == pytest.approx(2.5 * OUTPUT)
    assert names["2× force at g2"] == names["2× idler"] == pytest.approx(2 * 23 / 31)
    response = system.simulate(1.3, speed, record=["g5"], output_step=1e-3, geometry="frozen")
    found = response.orders("g5", "y", skip_time=0.2, shaft_harmonics=1, mesh_harmonics=0)
    # the phasors along y and z of a force that turns forwards are 50 and −50i
    matrices, frequency = system.matrices(speed), 2.5 * OUTPUT * SPEED
    rate = matrices.damping + speed * matrices.gyroscopic
    dynamic = matrices.stiffness + 1j * frequency * rate - frequency**2 * matrices.mass
    indices = [system.dofs.index(("output", 0.08, direction)) for direction in ("v", "w")]
    force = np.zeros(len(system.dofs), dtype=complex)
    force[indices] = 50.0, -50.0j
    expected = abs(np.linalg.solve(dynamic, force)[indices[0]])
    assert found.amplitude("2.5× force at g5") == pytest.approx(expected, rel=1e-2)
    response.save(tmp_path / "run.npz")
    assert gb.Response.load(tmp_path / "run.npz").kinematics == kinematics


def test_quantities_of_signatures_are_those_that_runs_record():
    # an editor offers the words of the type, and the table decides which of them a place has
    known = {"energy", *spectrum._MOTION, *spectrum._MESH, *spectrum._BEARING, *SECTION_FORCES}
    assert set(get_args(SignalQuantity)) == known
    assert set(get_args(SensitivityQuantity)) == set(response_sensitivity.QUANTITIES)
