"""Random scenes at a changing speed, and random speed profiles.

`make random` tries ten times as many, with new seeds.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import gearbow as gb
from test_fuzz import leaves
from test_random_scenes import TIMES, Drawn, assert_near, drawn, motion

pytestmark = pytest.mark.implausible

DURATION = 3e-3
TIME = np.linspace(0.0, DURATION, 31)


@st.composite
def profiles(draw: st.DrawFn) -> gb.SpeedProfile:
    """Draw a ramp, a table, or a speed that varies once per revolution; of one sign."""
    sense = draw(st.sampled_from([1.0, -1.0]))
    speeds = st.integers(0, 600).map(lambda value: sense * value)
    kind = draw(st.sampled_from(["ramp", "table", "wavering"]))
    if kind == "ramp":
        return gb.SpeedProfile.ramp(draw(speeds), draw(speeds), DURATION)
    if kind == "table":
        count = draw(st.integers(2, 4))
        breaks = np.linspace(0.0, DURATION, count)
        return gb.SpeedProfile.table(breaks, [draw(speeds) for _ in range(count)])
    mean = draw(speeds)
    return gb.SpeedProfile.function(lambda t: mean * (1.0 + 0.02 * np.sin(mean * t)), DURATION)


def cases(count: int) -> Any:
    """Run a test on this many random pairs of a scene and a profile."""

    def decorate(test: Any) -> Any:
        return settings(
            max_examples=count * int(TIMES or 1),
            derandomize=TIMES is None,
            database=None,
            deadline=None,
            suppress_health_check=list(HealthCheck),
        )(given(drawn(), profiles())(test))

    return decorate


def run(scene: Drawn, profile: gb.SpeedProfile, **how: Any) -> gb.Response:
    options = {"initial": "rest", "times": TIME} | how
    return scene.system().simulate(DURATION, profile, **options)


@cases(8)
def test_the_methods_agree(scene: Drawn, profile: gb.SpeedProfile):
    exact = motion(run(scene, profile, method="rk45", rtol=1e-10), scene)
    # A run omits weak gyroscopic couplings of modes: the largest error of 120 scenes was 420 rtol.
    # Contacts propagate errors of earlier event times.
    part = 1.0 if scene.backlash is None else 30.0
    for rtol in (1e-6, 1e-9):
        found = run(scene, profile, method="exponential", rtol=rtol)
        assert_near(motion(found, scene), exact, 1e3 * max(rtol, 1e-8) * part)


@cases(12)
def test_a_continued_run_gives_the_bits_of_one_run(scene: Drawn, profile: gb.SpeedProfile):
    system = scene.system()
    whole = system.simulate(DURATION, profile, initial="rest", rtol=1e-6)
    part: Any = "rest"
    for duration in (0.25 * DURATION, 0.5 * DURATION, 0.25 * DURATION):
        part = system.simulate(duration, profile, initial=part, rtol=1e-6)
    assert part.final["state"].tobytes() == whole.final["state"].tobytes()


@cases(12)
def test_the_energy_balance_closes(scene: Drawn, profile: gb.SpeedProfile):
    balance = run(scene, profile, rtol=1e-9, record=["energy"]).energy_balance()
    scale = max(np.abs(balance.total).max() + np.ptp(balance.work), 1e-9)
    assert np.abs(balance.residual).max() <= 1e-5 * scale


@settings(
    max_examples=150 * int(TIMES or 1),
    derandomize=TIMES is None,
    database=None,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)
@given(st.sampled_from(["ramp", "table", "pieces"]), st.lists(leaves, max_size=4), leaves)
def test_every_profile_gives_a_speed_or_an_error(kind: str, values: list[Any], value: Any):
    make = {
        "ramp": lambda: gb.SpeedProfile.ramp(*(values + [value] * 3)[:3]),
        "table": lambda: gb.SpeedProfile.table(values, [value] * len(values)),
        "pieces": lambda: gb.SpeedProfile(values, [[value] * max(len(values) - 1, 1)]),
    }[kind]
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            profile = make()
            speeds = profile(np.linspace(-1.0, 1.0, 5))
    except gb.GearbowError:
        return
    assert speeds.shape == (5,)
