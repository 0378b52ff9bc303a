"""The programs of `make compare` do the same work."""

import sys
import time
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benches"))

from programs.analyses import ANALYSES, SUBJECTS
from programs.scenes import SCENES
from programs.search import check, reference
from programs.timing import once
from summary import ANALYSES as SUMMARISED, SCENES as SUMMARISED_SCENES, fastest


@pytest.mark.parametrize("name", ["modes", "synchronous", "static"])
@pytest.mark.parametrize("subject", ["rotor", "pair"])
def test_gearbow_and_scipy_agree_with_the_reference(name, subject):
    analysis = ANALYSES[name]
    if subject not in (analysis.subjects or SUBJECTS):
        pytest.skip("The analysis does not contain this system.")
    system = SUBJECTS[subject].build()
    exact = analysis.exact(system)
    for program in ("gearbow", "SciPy"):
        found = analysis.programs[program](system)()()
        # ARPACK stops at 1e-10 of the largest inverse; round-off of the others is far below.
        assert analysis.error(found, exact) < 1e-8


def test_the_reference_of_a_scene_agrees_with_scipy():
    scene = SCENES["shaft"].shortened()
    # Both have tolerances of 1e-10, and the difference grows over the steps.
    assert check(scene, reference(scene)) < 1e-9


def test_a_run_in_its_own_process_ends_at_its_limit():
    def endless():
        while True:
            time.process_time()

    assert once(lambda: endless, 1).reason == "> 1 s"


def test_a_run_in_its_own_process_returns_its_result_or_its_error():
    assert once(lambda: lambda: np.arange(3), 10).value.tolist() == [0, 1, 2]
    assert "division" in once(lambda: lambda: 1 // 0, 10).reason


def test_the_summary_contains_tables_that_exist():
    assert set(SUMMARISED) <= set(ANALYSES)
    assert set(SUMMARISED_SCENES) <= set(SCENES)


def test_the_summary_takes_the_cheapest_method_that_meets_the_error():
    rows = [
        ["SciPy", "RK45", "rtol 0.1", "2e-2", "≥ 1", "≥ 2", "", ""],
        ["SciPy", "DOP853", "rtol 0.1", "2e-4", "20", "40", "", ""],
        ["SciPy", "Radau", "rtol 0.1", "2e-4", "30", "60", "", ""],
        ["ROSS", "lsim", "not installed", "", "", "", "", ""],
    ]
    assert fastest(rows, "SciPy") == "20 (DOP853)"
    assert fastest(rows, "ROSS") == "not installed"
