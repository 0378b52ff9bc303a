"""Runs of the exponential method: interruption, continuation, invalid options, parallel runs."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.bows import HalfSine
from reference.cases import each_case
from reference.teeth import Toothed

SPEED = 600.0
BOWED = Toothed(
    coupled=True,
    torque=80.0,
    bows={"a": HalfSine(5e-5, 0.4), "b": HalfSine(3e-5, -1.0)},
    mesh={"centre_line_angle": 0.3, "damping_ratio": 0.03},
)
SMOOTH = {"model": "square", "pair": 1.5e8, "engagement": 0.2}
SHARP = {"model": "square", "pair": 1.5e8, "engagement": "sharp"}


def with_mesh(**mesh: Any) -> Toothed:
    return replace(BOWED, mesh={**BOWED.mesh, **mesh})


SCENES: dict[str, tuple[Toothed, dict[str, Any]]] = {
    "smooth, live": (with_mesh(stiffness=SMOOTH), {}),
    "mean, frozen": (with_mesh(stiffness=2e8), {"geometry": "frozen"}),
    "sharp, frozen": (with_mesh(stiffness=SHARP), {"geometry": "frozen"}),
    "sharp, live": (with_mesh(stiffness=SHARP), {}),
    "rattling, live": (replace(with_mesh(stiffness=SMOOTH, backlash=5e-6), torque=5.0), {}),
    "rattling, frozen": (
        replace(with_mesh(stiffness=SHARP, backlash=5e-6), torque=5.0),
        {"geometry": "frozen"},
    ),
    "fixed step": (with_mesh(stiffness=SHARP, backlash=5e-6), {"step": 1.3e-5, "stages": 2}),
    "etdrk4": (with_mesh(stiffness=SHARP), {"method": "etdrk4", "step": 3e-6}),
    "reversed": (with_mesh(stiffness=SHARP), {"speed": -SPEED}),
    "standing": (with_mesh(stiffness=SMOOTH, backlash=5e-6), {"speed": 0.0}),
}


def run(name: str, duration: float, **more: Any) -> gb.Response:
    scene, options = SCENES[name]
    options = {"initial": "rest", **options, **more}
    return scene.package().simulate(duration, options.pop("speed", SPEED), **options)


def same_end(first: gb.Response, second: gb.Response) -> None:
    for key, value in first.final.items():
        assert np.array_equal(value, second.final[key]), key


# --- in parts -------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [2, 7])
@pytest.mark.parametrize("name", SCENES)
def test_a_run_in_parts_is_bitwise_equal_to_the_whole_run(name: str, count: int):
    duration = 2.1e-3
    inner = np.sort(np.random.default_rng(count).uniform(0.0, duration, count - 1))
    stops = [0.0, *inner, duration]
    times = np.linspace(0.0, duration, 43)
    whole = run(name, duration, times=times)
    part: str | gb.Response = "rest"
    events, rows = [], []
    for begin, end in pairwise(stops):
        began = 0.0 if isinstance(part, str) else part.final["time"]
        own = times[(times >= began) & (times < end)] if end < duration else times[times >= began]
        part = run(name, end - began, initial=part, times=own)
        assert part.final["time"] == pytest.approx(end, rel=1e-14)
        events += part.events
        rows.append(part.displacement("ga"))
        assert begin < end
    assert isinstance(part, gb.Response)
    # the end times of both runs differ by round-off; the state belongs to the last step
    assert np.array_equal(part.final["state"], whole.final["state"])
    assert np.array_equal(np.concatenate(rows), whole.displacement("ga"))
    assert tuple(events) == whole.events
    if "sharp" in name or "rattling" in name:
        assert whole.statistics.events > 3


@pytest.mark.parametrize("name", SCENES)
def test_recording_does_not_change_the_motion(name: str):
    duration = 1.5e-3
    plain = run(name, duration, times=[duration])
    numbers = np.random.default_rng(3).uniform(0.0, duration, 60)
    watched = [
        {"output_step": 1e-6},
        {"times": np.concatenate([numbers, numbers, [0.0, duration]])},
        {"times": [], "record": []},
        {"times": numbers, "record": ["energy", "nodes", "bearings", "meshes"]},
    ]
    for more in watched:
        found = run(name, duration, **more)
        same_end(plain, found)
        assert found.events == plain.events or not more.get("record", True)


@pytest.mark.parametrize("name", ["smooth, live", "sharp, live", "rattling, live"])
def test_an_output_does_not_depend_on_other_outputs(name: str):
    duration = 1e-3
    times = np.sort(np.random.default_rng(5).uniform(0.0, duration, 80))
    together = run(name, duration, times=np.repeat(times, 2))
    alone = [run(name, duration, times=[t]) for t in times[::9]]
    assert np.array_equal(together.displacement("gb")[::2], together.displacement("gb")[1::2])
    for row, single in zip(together.displacement("gb")[::18], alone, strict=True):
        assert np.array_equal(row, single.displacement("gb")[0])


@pytest.mark.parametrize("name", ["smooth, live", "sharp, frozen", "rattling, live"])
def test_outputs_are_continuous_across_steps(name: str):
    # outputs 1e-9 s apart differ by the velocity times 1e-9 s, also across a step boundary
    duration = 4e-4
    times = np.linspace(1e-6, duration - 1e-6, 2001)
    pairs = np.stack([times - 5e-10, times + 5e-10], axis=1).ravel()
    found = run(name, duration, times=pairs, rtol=1e-9)
    twist = found.twist("ga").reshape(-1, 2)
    slope = np.diff(twist, axis=1)[:, 0] / 1e-9
    across = np.gradient(found.twist("ga")[::2], pairs[::2])
    # a jump of one tolerance between two outputs would be a slope of 1e-9 range / 1e-9 s
    assert np.abs(slope - across).max() < 0.02 * np.ptp(across)


# --- continued ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["smooth, live", "sharp, frozen", "rattling, live"])
def test_one_method_continues_the_run_of_another(name: str):
    tight = {"rtol": 1e-10}
    whole = run(name, 2e-3, times=np.linspace(0, 2e-3, 21), method="rk45", rtol=1e-11)
    first = run(name, 7e-4, method="rk45", **tight)
    second = run(name, 7e-4, initial=first, **tight)
    third = run(name, 6e-4, initial=second, method="rk45", times=[1.5e-3, 2e-3], **tight)
    assert second.statistics.steps < first.statistics.steps
    wanted = whole.twist("ga")[[15, 20]]
    # contact changes amplify earlier errors
    tolerance = 1e-6 if "rattling" in name else 1e-7
    assert third.twist("ga") == pytest.approx(wanted, abs=tolerance * np.ptp(whole.twist("ga")))


@pytest.mark.parametrize("name", ["smooth, live", "sharp, live", "rattling, live"])
def test_a_state_without_step_history_continues_within_the_tolerance(name: str):
    rtol = 1e-8
    whole = run(name, 2e-3, times=np.linspace(0, 2e-3, 21), rtol=rtol)
    half = dict(run(name, 1e-3, rtol=rtol).final)
    half["memory"] = np.zeros(0)
    rest = run(name, 1e-3, initial=half, times=[1.5e-3, 2e-3], rtol=rtol)
    wanted = whole.twist("ga")[[15, 20]]
    assert rest.twist("ga") == pytest.approx(wanted, abs=100 * rtol * np.ptp(whole.twist("ga")))


@pytest.mark.parametrize("stages", [(3, 4), (4, 3), (2, 3), (3, 1)])
@pytest.mark.parametrize("name", ["smooth, live", "rattling, live"])
def test_a_run_continues_with_another_number_of_stages(name: str, stages: tuple[int, int]):
    """The loads of the previous step cannot be extrapolated: the motion changes by the tolerance
    only.
    """
    rtol = 1e-4 if 1 in stages else 1e-8
    first = run(name, 1e-3, rtol=rtol, stages=stages[0])
    rest = run(name, 1e-3, initial=first, times=[1.5e-3, 2e-3], rtol=rtol, stages=stages[1])
    wanted = run(name, 2e-3, times=[0.0, 1.5e-3, 2e-3], rtol=1e-9).twist("ga")
    assert rest.twist("ga") == pytest.approx(wanted[1:], abs=100 * rtol * np.ptp(wanted))


def test_a_changed_state_continues_from_its_values():
    half = dict(run("smooth, live", 1e-3).final)
    state = np.array(half["state"])
    state[: len(state) // 2] = 0.0
    half["state"] = state
    rest = run("smooth, live", 1e-4, initial=half, times=[half["time"]])
    other = run("smooth, live", 1e-4, initial={**half, "memory": np.zeros(0)}, times=[half["time"]])
    assert np.array_equal(rest.displacement("ga"), other.displacement("ga"))
    assert np.abs(rest.displacement("ga")).max() < 1e-5  # the motion starts from zero


@pytest.mark.parametrize("initial", ["rest", "static", "synchronous"])
@pytest.mark.parametrize("speed", [SPEED, 0.0, -SPEED])
def test_every_initial_state_at_both_senses_of_rotation(speed: float, initial: str):
    options = {"speed": speed, "initial": initial, "times": np.linspace(0.0, 1e-3, 21)}
    exact = run("smooth, live", 1e-3, method="rk45", rtol=1e-10, **options)
    found = run("smooth, live", 1e-3, rtol=1e-8, **options)
    scale = np.abs(exact.displacement("ga")).max()
    # the tolerance is relative to the whole motion, which is larger than the oscillation about the
    # initial state
    assert found.displacement("ga") == pytest.approx(exact.displacement("ga"), abs=1e-6 * scale)


# --- refused --------------------------------------------------------------------------------------


@each_case(
    ("options", "text"),
    [
        ({"stages": 0}, "^stages: must be"),
        ({"stages": 5}, "^stages: must be 1 to 4, got 5"),
        ({"stages": 2.5}, "^stages: must be a whole number"),
        ({"modes": 0}, "^modes: must be at least 1"),
        ({"modes": "few"}, "^modes: must be a whole number"),
        ({"stages": 2, "method": "rk45"}, '^stages: "rk45" cannot use it; .*"exponential"$'),
        ({"stages": 2, "method": "rk4"}, '^stages: "rk4" cannot use it; .*"exponential"$'),
        ({"stages": 2, "method": "etdrk4"}, '^stages: "etdrk4" cannot use it'),
        ({"modes": 8, "method": "rk4"}, '^modes: "rk4" cannot use it; .*"etdrk4"$'),
        ({"modes": 8, "method": "rk45"}, '^modes: "rk45" cannot use it; .*"exponential", '),
        ({"rtol": 1e-6, "method": "rk4"}, '^rtol: "rk4" cannot use it; .*"exponential", "rk45"$'),
        ({"rtol": 1e-6, "method": "etdrk4"}, "^rtol: .* cannot use it"),
        ({"rtol": 1e-6, "step": 1e-6}, "^rtol: cannot be used with a fixed step"),
        ({"step": 1e-6, "method": "rk45"}, '^step: "rk45" cannot use it; .*"exponential", "rk4"'),
        ({"method": "x"}, '^method: must be "exponential", "rk45", "rk4" or "etdrk4", got "x"'),
        ({"rtol": 1.0}, "^rtol: must lie between 0 and 1"),
        ({"step": -1e-6}, "^step: must be positive"),
    ],
    ids=str,
)
def test_the_error_names_the_invalid_option(options: dict[str, Any], text: str):
    with pytest.raises(gb.SceneError, match=text):
        run("smooth, live", 1e-4, **options)


# --- stopped and parallel runs --------------------------------------------------------------------


def test_an_error_in_the_progress_callback_keeps_the_results():
    class EnoughError(Exception):
        pass

    def stop(fraction: float) -> None:
        if fraction > 3e-5:
            raise EnoughError

    # Without an accuracy level, the long and the short run have the same modes.
    with pytest.raises(EnoughError) as caught:
        run("rattling, live", 1e3, times=np.arange(0.0, 1e3, 1e-2), rtol=1e-5, progress=stop)
    done = caught.value.response
    assert isinstance(done, gb.Response)
    again = run("rattling, live", done.time[-1] + 1e-3, times=done.time, rtol=1e-5)
    assert len(done.time) > 1
    assert np.array_equal(done.displacement("ga"), again.displacement("ga"))
    # and it can be continued from its last state
    ended = done.final["time"]
    assert done.time[-1] <= ended < done.time[-1] + 1e-2 + 1e-4
    rest = run("rattling, live", 1e-3, initial=done, times=[ended + 5e-4], rtol=1e-5)
    whole = run("rattling, live", ended + 1e-3, times=[ended + 5e-4], rtol=1e-5)
    assert np.array_equal(rest.displacement("ga"), whole.displacement("ga"))


@pytest.mark.parametrize("name", ["smooth, live", "rattling, live", "etdrk4"])
def test_two_threads_give_the_same_bits(name: str):
    system, options = SCENES[name][0].package(), SCENES[name][1]
    gate = threading.Barrier(2)

    def one(_: int) -> gb.Response:
        gate.wait()
        return system.simulate(5e-3, SPEED, initial="rest", output_step=1e-5, **options)

    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(one, range(2))
    alone = run(name, 5e-3, output_step=1e-5)
    for found in (first, second):
        same_end(found, alone)
        assert np.array_equal(found.mesh(("ga", "gb")).force, alone.mesh(("ga", "gb")).force)


@pytest.mark.parametrize("name", ["smooth, live", "sharp, frozen"])
def test_the_first_step_is_found_in_a_few_tries(name: str):
    """The first step from rest is a small fraction of the longest step; repeated halving would need
    many attempts.
    """
    tight = {"rtol": 1e-9, "times": [0.0]}
    shortest = run(name, 2e-5, **tight).statistics.step_min
    halvings = np.log2(run(name, 2e-2, rtol=0.5, times=[0.0]).statistics.step_max / shortest)
    assert halvings >= 4
    # the first step is attempted, then the run ends
    assert 1 <= run(name, 1e-9, **tight).statistics.rejected <= halvings / 2
