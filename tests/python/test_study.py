"""Bow study: closed forms, bitwise reproducibility, and its files."""

from __future__ import annotations

import dataclasses
import math
import os
import re
import signal
import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.study import Case, Settings, cases, run
from gearbow.study.case import description, key, system
from gearbow.study.findings import TABLES
from gearbow.study.measure import measure
from gearbow.study.settings import SCENE
from gearbow.study.table import write
from gearbow.study.view import Study
from gearbow.sweeps import store

#: A run with the accuracy "reference" of a constant, sharply engaging mesh needs more elements than
#: gearbow chooses.
pytestmark = pytest.mark.filterwarnings(
    "ignore:accuracy. the elements are too coarse:gearbow.AccuracyWarning"
)


@pytest.fixture(scope="module")
def tiny() -> Settings:
    """Return settings of a dozen short runs."""
    settings = dataclasses.replace(
        Settings.load().quick(), samples=64, settle=0, phase_steps=1, modes=3, accuracy="draft"
    )
    first = dict(list(settings.layouts.items())[:1])
    scene = dict(settings.scene)
    # A constant stiffness takes the longest steps.
    scene["meshes"] = [{**mesh, "stiffness": 2e8} for mesh in scene["meshes"]]
    scene["shafts"] = [{**shaft, "elements": 4} for shaft in scene["shafts"]]
    return dataclasses.replace(settings, layouts=first, scene=scene)


@pytest.fixture(scope="module")
def done(tiny, tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    return folder, run(tiny, folder, workers=1)


def bits(settings, results, folder):
    folder.mkdir()
    write(settings, results, folder)
    tables = [table(Study(settings, results)) for table in TABLES.values()]
    return [path.read_bytes() for path in sorted(folder.glob("*.csv"))], tables


def test_two_workers_give_the_bits_of_one_worker(tiny, done, tmp_path):
    _, alone = done
    both = run(tiny, tmp_path / "runs", workers=2)
    assert list(both) == list(alone) == list(cases(tiny))
    one, other = bits(tiny, alone, tmp_path / "one"), bits(tiny, both, tmp_path / "two")
    assert one == other
    for case, found in alone.items():
        for name, values in found.signals.items():
            np.testing.assert_array_equal(values, both[case].signals[name])


def test_a_study_continues_with_the_missing_runs(tiny, done, tmp_path, monkeypatch):
    folder, whole = done
    (path,) = folder.glob("*.sweep")
    contents = store.read(path)
    outcomes = dict(contents.outcomes)
    for number in (0, 3, 5):
        del outcomes[number]
    store.write(tmp_path / path.name, contents.head, outcomes)
    made = []
    monkeypatch.setattr(
        "gearbow.study.runs.system",
        lambda settings, case: made.append(case) or system(settings, case),
    )
    again = run(tiny, tmp_path, workers=1)
    assert set(made) == {cases(tiny)[number] for number in (0, 3, 5)}
    for case, found in whole.items():
        for name, values in found.signals.items():
            np.testing.assert_array_equal(values, again[case].signals[name])


def test_a_failed_run_keeps_the_others(tiny, tmp_path, monkeypatch):
    def failing(settings, case):
        # the accuracy "reference" takes long
        if case.geometry == "frozen" or case.accuracy == "reference":
            raise gb.ConvergenceError("made to fail")
        return system(settings, case)

    monkeypatch.setattr("gearbow.study.runs.system", failing)
    with pytest.raises(gb.GearbowError, match=r"frozen.*ConvergenceError: made to fail"):
        run(tiny, tmp_path, workers=1)
    (path,) = tmp_path.iterdir()
    kept = gb.Sweep.load(path)
    assert 0 < len(kept.failed) < kept.computed == len(cases(tiny))


def test_the_name_of_the_runs_tells_every_parameter(tiny):
    case = cases(tiny)[1]
    names = {key(tiny, [case])}
    changed = [
        dataclasses.replace(tiny, **{n: getattr(tiny, n) + 1}) for n in ("samples", "settle")
    ]
    scene = dict(tiny.scene)
    scene["modal_damping"] = 0.03
    changed.append(dataclasses.replace(tiny, scene=scene))
    names |= {key(settings, [case]) for settings in changed}
    names |= {
        key(tiny, [dataclasses.replace(case, **{name: value})])
        for name, value in {
            "torque": 1.0,
            "speed": 99.0,
            "bow": 0.02,
            "where": "middle",
            "phases": (1.0, 0.0),
            "geometry": "frozen",
            "accuracy": "reference",
        }.items()
    }
    assert len(names) == 11
    # A parameter without influence on a run does not repeat it.
    assert key(dataclasses.replace(tiny, backlash=1.0, modes=7), [case]) in names


def test_a_case_sets_bow_gear_position_and_load():
    settings = Settings.load()
    case = Case("half", 30.0, 50.0, bow=0.04, where="middle", phases=(0.5, 0.7), accuracy="draft")
    made = description(settings, case)
    assert [shaft.get("bow") for shaft in made["shafts"]] == [
        None,
        {"shape": "half_sine", "amplitude": pytest.approx(1e-3), "phase": 0.5},
        None,
    ]
    assert [gear["position"] for gear in made["gears"]] == [0.25, 0.25, 0.375, 0.25]
    assert made["torques"][0]["value"] == 30.0
    assert made["resolution"] == "draft"
    assert settings.scene["torques"][0]["value"] == 250.0  # the study itself stays as it is
    assert system(settings, case).shafts[1].bow == gb.Bow.half_sine(1e-3, phase=0.5)


@pytest.mark.parametrize("where", ["input", "middle", "output"])
def test_means_and_peak_to_peak_values_are_those_of_the_closed_forms(where):
    """At low speed, without load and with stiff parts, every gear centre moves on a circle with the
    local bow.
    """
    settings = Settings.load()
    scene = dict(settings.scene)
    scene["bearings"] = [{**bearing, "stiffness": 1e10} for bearing in scene["bearings"]]
    scene["meshes"] = [{**mesh, "stiffness": 2e8} for mesh in scene["meshes"]]
    scene["shafts"] = [{**shaft, "elements": 4} for shaft in scene["shafts"]]
    settings = dataclasses.replace(settings, scene=scene, samples=400, settle=0)
    bow = 0.01
    found = measure(settings, Case("quarter", 0.0, 2.0, bow=bow, where=where))
    for pair, shafts in (("g1/g2", ("input", "middle")), ("g3/g4", ("middle", "output"))):
        if where not in shafts:
            continue
        # Bow at the gear: at the middle, or at a quarter of the length.
        b = bow * 0.025 * (math.sqrt(0.5) if where == "middle" else 1.0)
        distance, angle = 3e-3 * 75 / 2, math.radians(20.0)
        pitch = math.pi * 3e-3 * math.cos(angle)
        at_rest = 1.6831601
        expected = {
            "centre_distance": (b**2 / (4 * distance), 2 * b, distance),
            "contact_ratio": (
                b**2 * math.cos(2 * angle) / (4 * pitch * distance * math.sin(angle) ** 3),
                2 * b / (pitch * math.sin(angle)),
                at_rest,
            ),
            "pressure_angle": (
                -(b**2) / (4 * distance**2 * math.tan(angle) * math.sin(angle) ** 2),
                2 * b / (distance * math.tan(angle)),
                angle,
            ),
        }
        for name, (shift, peak_to_peak, rest) in expected.items():
            # The closed forms are the first terms of series in b / C sin²α, 2 % here, whose next
            # terms are two orders higher; bearings and mesh deflect by about 0.1 %.
            assert found.peak_to_peak(pair, name) == pytest.approx(peak_to_peak, rel=1e-2), name
            # Shift over the value at rest: 1e-6 to 2e-4, far above the rounding of the mean.
            reference = rest if name != "contact_ratio" else found_at_rest(settings, pair)
            assert found.mean(pair, name) - reference == pytest.approx(shift, rel=1e-2), name


def found_at_rest(settings, pair):
    return measure(settings, Case("quarter", 0.0, 2.0)).mean(pair, "contact_ratio")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a = ", "not TOML"),
        ("a = 1", "study: this table is missing"),
        ("[study]\nbows = [0.0]", "study.accuracy: is missing"),
    ],
)
def test_a_file_that_is_no_study_is_refused(tmp_path, text, sentence):
    path = tmp_path / "scene.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(gb.SceneError, match=sentence):
        Settings.load(path)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"bows": (0.01,)}, "study.bows: must contain 0"),
        ({"bows": (0.0, 0.0)}, "study.bows: must be distinct"),
        ({"speeds": (-1.0,)}, "study.speeds: must be positive"),
        ({"phase_bow": 0.3}, "study.phase_bow: must be one of bows"),
        ({"samples": 2}, "study.samples: must be a whole number of at least 16"),
        ({"accuracy": "best"}, "study.accuracy: must be one of draft"),
        ({"layouts": {"other": {"g1": 0.1}}}, "study.layouts.other: must place g1, g2, g3, g4"),
    ],
)
def test_the_error_names_the_invalid_setting(given, sentence):
    with pytest.raises(gb.SceneError, match=sentence):
        dataclasses.replace(Settings.load(), **given)._checked()


def test_the_command_prints_a_table_and_refuses_invalid_arguments(tmp_path):
    command = [sys.executable, "-m", "gearbow", "study", "--out", str(tmp_path)]
    failed = subprocess.run(
        [*command, "--workers", "0"], capture_output=True, text=True, check=False
    )
    assert failed.returncode == 2
    assert "must be at least 1, got 0" in failed.stderr
    (tmp_path / "scene.toml").write_text("a = 1", encoding="utf-8")
    failed = subprocess.run(
        [*command, "--scene", str(tmp_path / "scene.toml")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert failed.returncode == 2
    assert failed.stderr == "study: study: this table is missing\n"


@pytest.mark.skipif(os.name != "posix", reason="sends signals")
def test_a_killed_study_continues_to_the_bits_of_the_whole_one(tmp_path):
    small = {"samples": "64", "settle": "0", "speeds": "[1000.0]", "phase_steps": "1"}
    small |= {
        "bows": str([step / 200 for step in range(11)]),
        "torques": "[250.0]",
        "accuracy": '"draft"',
        "half": "",
    }
    text = SCENE.read_text(encoding="utf-8")
    for name, value in small.items():
        text, count = re.subn(
            rf"^{name} = .*$", f"{name} = {value}" * bool(value), text, flags=re.M
        )
        assert count == 1
    text = text.replace('{ model = "potential_energy" }', "2e8")  # takes the longest steps
    text = text.replace("outer_diameter = 0.05", "outer_diameter = 0.05\nelements = 2")
    scene, folder = tmp_path / "scene.toml", tmp_path / "killed"
    scene.write_text(text, encoding="utf-8")
    study = [sys.executable, "-W", "ignore", "-m", "gearbow", "study", "--scene", scene]
    study += ["--workers", "1", "--print", next(iter(TABLES))]

    def stored() -> dict[int, Any]:
        return next((store.read(path).outcomes for path in folder.glob("runs/*.sweep")), {})

    done = 0
    for kill in (signal.SIGTERM, signal.SIGKILL):  # SIGTERM far from the end, where it is obeyed
        command = [*study, "--out", folder]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            while len(stored()) <= done and process.poll() is None:
                time.sleep(0.02)
            process.send_signal(kill)
            process.communicate()
        assert process.returncode == (-kill if kill == signal.SIGKILL else 143)
        assert len(stored()) > done
        done = len(stored())
    tables = [
        subprocess.run([*study, "--out", out], capture_output=True, check=True).stdout
        for out in (folder, tmp_path / "whole")
    ]
    assert tables[0] == tables[1]
    (one,), (other,) = (
        [store.read(path).outcomes for path in tmp_path.glob(f"{name}/runs/*.sweep")]
        for name in ("killed", "whole")
    )
    assert len(one) == len(other) > done
    for number, outcome in one.items():
        for name, values in outcome.values.items():
            assert np.asarray(values).tobytes() == np.asarray(other[number].values[name]).tobytes()


def test_every_figure_is_drawn(tiny, done, tmp_path):
    from gearbow.study.figures import FIGURES, write

    _, results = done
    paths = write(Study(tiny, results), tmp_path)
    assert [path.name for path in paths] == [f"study_{name}.png" for name in FIGURES]
    assert all(1000 < path.stat().st_size < 150_000 for path in paths)
