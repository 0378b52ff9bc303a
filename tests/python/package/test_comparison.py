"""The programs of `make compare` do the same work."""

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

# Last, because both folders have a module `fleet`.
sys.path.append(str(Path(__file__).parents[3] / "benches"))

from programs.analyses import ANALYSES, SUBJECTS
from programs.fleet import LINEAR, Machine
from programs.scenes import SCENES
from programs.search import check, reference
from programs.timing import once
from summary import ANALYSES as SUMMARISED, SCENES as SUMMARISED_SCENES, machines, scene

BENCHES = Path(__file__).parents[3] / "benches"


@pytest.mark.parametrize("name", ["modes", "synchronous", "frequency", "static"])
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
    assert all(machines(analysis) for analysis in SUMMARISED)
    assert set(SUMMARISED_SCENES) <= set(SCENES)


def test_the_summary_takes_the_cheapest_method_that_meets_the_error():
    rows = [
        ["program", "method", "setting", "error", "CPU", "cost ratio", "set-up", "simulated"],
        ["gearbow", "exponential", "rtol 0.1", "2e-4", "0.5", "1", "", ""],
        ["gearbow", "exponential, 80 modes", "modes 80", "2e-2", "≥ 0.1", "≥ 1", "", ""],
        ["SciPy", "RK45", "rtol 0.1", "2e-2", "≥ 1", "≥ 2", "", ""],
        ["SciPy", "DOP853", "rtol 0.1", "2e-4", "20", "40", "", ""],
        ["SciPy", "Radau", "rtol 0.1", "2e-4", "30", "60", "", ""],
        ["ROSS", "lsim", "not installed", "", "", "", "", ""],
    ]
    found = scene("train", rows)
    assert found is not None
    assert found.ratio == 0.5 / 20
    assert found.words == "train: 0.5 s per simulated s, SciPy (DOP853) 20 s"
    assert scene("train", [*rows[:4], rows[-1]]) is None


MACHINE = """\
# Rated speed: 1000 rpm of the input shaft.
gravity = 9.81

[[shafts]]
name = "input"
segments = [{ length = 0.4, outer_diameter = 0.05, elements = 4 }]
bow = { shape = "half_sine", amplitude = 1e-4 }

[[shafts]]
name = "output"
segments = [{ length = 0.4, outer_diameter = 0.05, elements = 4 }]

[[gears]]
name = "g1"
shaft = "input"
position = 0.2
teeth = 20
module = 0.004
face_width = 0.03
unbalance = 1e-4

[[gears]]
name = "g2"
shaft = "output"
position = 0.2
teeth = 30
module = 0.004
face_width = 0.03

[[meshes]]
driver = "g1"
driven = "g2"
stiffness = 2e8

"""
BEARINGS = "".join(
    f"""
[[bearings]]
shaft = "{shaft}"
position = {x}
stiffness = [1e8, 2e8]
damping = 1e3
"""
    for shaft in ("input", "output")
    for x in (0.0, 0.4)
)


@pytest.mark.parametrize("modal_damping", [None, 0.02])
def test_gearbow_and_scipy_agree_on_a_machine(tmp_path, monkeypatch, modal_damping):
    monkeypatch.setattr("programs.fleet.MANY", 5)
    path = tmp_path / "pair.toml"
    damping = "" if modal_damping is None else f"modal_damping = {modal_damping}\n"
    path.write_text(MACHINE.replace("gravity", f"{damping}gravity") + BEARINGS, encoding="utf-8")
    machine = Machine(path)
    for name, prepare in LINEAR.items():
        work = prepare(machine)
        found, exact = work.gearbow()(), work.scipy()()
        # The limit of the bench; SciPy has modal damping on all modes but two.
        assert work.difference(found, exact) < 1e-6, name
        wrong = wrong_result(name, exact)
        assert work.difference(found, wrong) > 1e-6, name


def wrong_result(name, exact):
    """Every number 1e-4 too large."""
    if name in ("synchronous", "frequency_response"):
        return 1.0001 * exact
    return [1.0001 * np.asarray(row) for row in exact] if name != "modes" else 1.0001 * exact


def test_the_bench_of_the_machines_stores_and_prints_its_rows(tmp_path):
    stored = tmp_path / "fleet.json"
    chosen = ["--machine", "idler_train", "--analysis", "modes", "--analysis", "static"]
    command = [sys.executable, str(BENCHES / "fleet.py"), "--results", str(stored)]
    done = subprocess.run([*command, *chosen], capture_output=True, encoding="utf-8", check=True)
    kept = json.loads(stored.read_text("utf-8"))["idler_train"]
    assert set(kept["measured"]) == {"modes", "static"}
    assert kept["measured"]["modes"]["difference"] <= 1e-6
    again = [*command, "--stored"]
    printed = subprocess.run(again, capture_output=True, encoding="utf-8", check=True).stdout
    assert printed == done.stdout
    rows = [line for line in printed.splitlines() if line.startswith("| idler_train")]
    assert len(rows) == 2
    assert f"`modes`, 12 modes | {1e3 * kept['measured']['modes']['cpu']:.3g} ms" in rows[0]


def test_an_analysis_that_a_machine_cannot_have_is_a_row_that_says_so(tmp_path):
    stored = tmp_path / "fleet.json"
    chosen = ["--machine", "torsional_drive_line", "--analysis", "synchronous"]
    command = [sys.executable, str(BENCHES / "fleet.py"), "--results", str(stored), *chosen]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr
    reason = "`synchronous`: none, because the machine has no lateral motion"
    assert f"| torsional_drive_line | 61 | {reason} |" in done.stdout
