"""Errors, costs and choices of a study against trials with given numbers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.studies.result import Tradeoff, Trial
from gearbow.studies.study import Signal, signal_error, signal_errors
from reference.bows import HalfSine
from reference.records import response
from reference.scenes import PAIR

FLOOR, DURATION = 1e-6, 0.5
SYSTEM = PAIR.package()


def trial(setting: str, errors: tuple[float, float], **given: Any) -> Trial:
    values = {
        "setting": setting,
        "model": "as given",
        "options": {"method": setting},
        "system": SYSTEM,
        "method": setting.split(",", maxsplit=1)[0],
        "errors": {"the displacement of g1": errors[0], "the force of g1/g2": errors[1]},
        "integration_error": 2e-3,
        "model_error": 3e-4,
        "floor": FLOOR,
        "setup": 2.0,
        "stepping": 3.0,
        "duration": DURATION,
        "steps": 7,
        "evaluations": 28,
        "limited_by": "tolerance",
        "repeats": 1,
    }
    return Trial(**{**values, **given})


#: Low setup cost and slow steps; high setup cost and fast steps; an error below that of the
#: reference; dominated by another setting; a simplified model.
QUICK = trial("rk45, rtol 1e-3", (1e-4, 1e-3), setup=0.1, stepping=4.0)
LASTING = trial("exponential, rtol 1e-3", (3e-4, 1e-4), setup=3.0, stepping=2.0)
BELOW = trial("exponential, rtol 1e-9", (1e-8, 2e-8), setup=3.0, stepping=5.0)
BEATEN = trial("rk4, step 1e-6 s", (5e-3, 2e-3), setup=0.2, stepping=6.0)
SIMPLER = trial("exponential, rtol 1e-2", (8e-3, 2e-3), model="4 modes", setup=0.05, stepping=0.1)
STUDY = Tradeoff(
    trials=(QUICK, BEATEN, LASTING, BELOW, SIMPLER),
    skipped=(),
    reference="exponential, rtol 1e-12",
    check="rk45, rtol 1e-10",
    floor=FLOOR,
    discretisation=None,
    duration=DURATION,
    speed=100.0,
    signals=("the displacement of g1", "the force of g1/g2"),
)


def run(time: np.ndarray, motion: np.ndarray, force: np.ndarray | float = 0.0) -> gb.Response:
    """Return a response with this displacement of g1 and this force of the mesh g3/g4."""
    displacement, forces = np.zeros((time.size, 4, 2)), np.zeros((time.size, 2))
    displacement[:, 0], forces[:, 1] = motion, force
    mesh = {**response(time)._data["mesh"], "force": forces}
    return response(time, displacement=displacement, mesh=mesh)


class TestErrors:
    """Relative difference of two runs."""

    def test_rms_of_the_difference_over_rms_of_the_variation(self):
        # whole periods: a circle of radius 3 around (5, -2), and one of radius 0.1 beside it;
        # a force that differs by a constant: 4 against a cosine of amplitude 20 around 100
        time = np.linspace(0.0, 1.0, 400, endpoint=False)
        angle = 2 * np.pi * 7 * time
        circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        reference = run(time, [5.0, -2.0] + 3.0 * circle, 100.0 + 20.0 * np.cos(angle))
        other = run(
            time,
            [5.0, -2.0] + 3.0 * circle + 0.1 * circle[:, ::-1],
            104.0 + 20.0 * np.cos(angle),
        )
        wanted = (Signal("g1"), Signal(("g3", "g4")))
        exact, found = ({str(s): s.values(each) for s in wanted} for each in (reference, other))
        expected = {
            "the displacement of g1": 0.1 / 3.0,
            "the force of g3/g4": 4.0 / (20.0 / np.sqrt(2.0)),
        }
        assert signal_errors(found, exact, exact) == pytest.approx(expected)
        assert signal_error(found, exact, exact) == pytest.approx(max(expected.values()))
        assert signal_error(exact, exact, exact) == 0.0

    def test_errors_use_the_length_of_the_displacement_vector(self):
        # 1 along one axis against 3 and 4 along both, which is 5
        time = np.linspace(0.0, 1.0, 100, endpoint=False)
        wave = np.cos(2 * np.pi * 5 * time)
        reference = run(time, np.stack([3.0 * wave, 4.0 * wave], axis=1))
        other = run(time, np.stack([4.0 * wave, 4.0 * wave], axis=1))
        exact, found = ({"g1": Signal("g1").values(each)} for each in (reference, other))
        assert signal_error(found, exact, exact) == pytest.approx(1.0 / 5.0)


def test_derived_quantities_of_a_trial():
    assert LASTING.error == 3e-4
    assert QUICK.error == 1e-3
    assert (LASTING.bound, BELOW.bound) == (3e-4, FLOOR)
    assert (QUICK.error_text, BELOW.error_text) == ("1.0e-03", "<1.0e-06")
    assert LASTING.seconds == 5.0
    assert LASTING.rate == 4.0  # 2 s for half a simulated second
    assert LASTING.cost() == 5.0
    assert LASTING.cost(10.0) == 43.0
    assert str(QUICK) == "rk45, rtol 1e-3"
    assert str(SIMPLER) == "exponential, rtol 1e-2, 4 modes"


def test_the_pareto_front():
    assert STUDY.front() == (SIMPLER, QUICK, LASTING, BELOW)
    assert STUDY.front(simplified=False) == (QUICK, LASTING, BELOW)
    # over ten seconds, stepping counts: 80.1 s, 43 s, 103 s, and 2.05 s for the simplified model
    assert STUDY.front(duration=10.0) == (SIMPLER, LASTING, BELOW)
    assert STUDY.front(duration=10.0, simplified=False) == (LASTING, BELOW)


def test_recommendations():
    assert STUDY.recommend(5e-3).trial is QUICK
    assert STUDY.recommend(1e-2).trial is SIMPLER
    assert STUDY.recommend(1e-2, simplified=False).trial is QUICK
    assert STUDY.recommend(5e-3, duration=10.0).trial is LASTING
    best = STUDY.recommend(1e-6)
    assert best.trial is BELOW
    assert best.error == FLOOR
    assert best.options == {"method": "exponential, rtol 1e-9"}
    # its error is 2e-8, but the reference is only known to 1e-6
    with pytest.raises(gb.GearbowError, match="no setting of this study"):
        STUDY.recommend(1e-7)


def test_the_text_table():
    text = STUDY.table()
    assert text.splitlines()[-1].startswith("recommended for an error of 0.01: ")
    assert "\n* Pareto front: " in text
    head, *lines = text.split("\n\n")[1].splitlines()
    titles = (
        "setting", "model", "error", "integration error", "model error", "CPU [s]", "set-up [s]",
        "CPU per s [s/s]", "steps", "evaluations", "limited by",
    )  # fmt: skip
    places = [head.index(title) for title in titles]
    assert places == sorted(places)
    words = {line.lstrip("* ").split("  ")[0]: line.split() for line in lines}
    assert words["exponential, rtol 1e-3"] == [
        "*", "exponential,", "rtol", "1e-3", "as", "given", "3.0e-04", "2.0e-03", "–", "5", "3", "4",
        "7", "28", "tolerance",
    ]  # fmt: skip
    assert words["exponential, rtol 1e-2"][-9:] == [
        "8.0e-03", "2.0e-03", "3.0e-04", "0.15", "0.05", "0.2", "7", "28", "tolerance",
    ]  # fmt: skip
    assert words["exponential, rtol 1e-9"][6] == "<1.0e-06"
    assert words["rk4, step 1e-6 s"][0] == "rk4,"  # no star: not on the front


def test_the_data_frame():
    frame = STUDY.to_dataframe()
    expected = {
        "setting": [t.setting for t in STUDY.trials],
        "error": [1e-3, 5e-3, 3e-4, 2e-8, 8e-3],
        "integration error": [2e-3] * 5,
        "model error": [3e-4] * 5,
        "the displacement of g1": [1e-4, 5e-3, 3e-4, 1e-8, 8e-3],
        "the force of g1/g2": [1e-3, 2e-3, 1e-4, 2e-8, 2e-3],
        "below floor": [False, False, False, True, False],
        "seconds": [4.1, 6.2, 5.0, 8.0, 0.15],
        "set-up seconds": [0.1, 0.2, 3.0, 3.0, 0.05],
        "seconds per simulated second": [8.0, 12.0, 4.0, 10.0, 0.2],
        "front": [True, False, True, True, True],
    }
    for column, values in expected.items():
        if isinstance(values[0], float):
            assert list(frame[column]) == pytest.approx(values), column
        else:
            assert list(frame[column]) == values, column


@pytest.mark.parametrize("duration", [None, 10.0])
def test_the_diagram(duration: float | None):
    (panel,) = STUDY.plot(duration=duration).axes
    assert panel.get_xlabel() == "error: RMS of the difference / RMS of the signal about its mean"
    assert panel.get_ylabel() == f"CPU time for {0.5 if duration is None else 10:g} simulated s [s]"
    lines = {line.get_label(): line.get_xydata() for line in panel.get_lines()}
    costs = {None: (5.0, 8.0), 10.0: (43.0, 103.0)}[duration]
    # an error below the uncertainty of the reference is drawn at this uncertainty
    expected = np.column_stack([[3e-4, FLOOR], costs])
    np.testing.assert_allclose(lines["exponential"], expected)
    np.testing.assert_allclose(lines["4 modes"], [[8e-3, {None: 0.15, 10.0: 2.05}[duration]]])


def test_the_error_of_a_model_is_that_of_its_most_accurate_run():
    # the tight run of a simplified model is the last of its rows
    study = replace(PAIR, bows={"input": HalfSine(1.5e-4)}, elements=2).package().tradeoff(
        2e-3, 100.0, signals="g1", methods=["exponential"], tolerances=[1e-3, 1e-5],
        initial="rest", repeats=1, budget=60.0, degrees=[],
    )  # fmt: skip
    models = {trial.model for trial in study.trials} - {"as given"}
    assert models
    for model in models:
        *others, tight = [trial for trial in study.trials if trial.model == model]
        assert others
        assert tight.integration_error == 0.0
        assert tight.model_error == tight.error
        for other in others:
            assert other.model_error == tight.error
            # a less accurate run has its own error, which is round-off or zero in a linear model
            assert other.integration_error >= 0.0
            assert abs(other.error - tight.error) <= 1.001 * other.integration_error
