"""The bow study of examples/bow_study: closed forms, bitwise reproducibility, and its files."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow import _core
from gearbow.sweeps import store

EXAMPLE = Path(__file__).parents[3] / "examples" / "bow_study"
if not EXAMPLE.is_dir():
    pytest.skip("the examples are not installed", allow_module_level=True)
pytest.importorskip("matplotlib")
sys.path.insert(0, str(EXAMPLE))

import drawings  # noqa: E402
from cases import Case, Settings, cases, quick, train  # noqa: E402
from findings import TABLES  # noqa: E402
from runs import Measured, Teeth, make, measure, run  # noqa: E402
from study import write  # noqa: E402

#: A run with the accuracy "reference" of a constant, sharply engaging mesh needs more elements than
#: gearbow chooses.
pytestmark = pytest.mark.filterwarnings(
    "ignore:accuracy. the elements are too coarse:gearbow.AccuracyWarning"
)


@pytest.fixture(scope="module")
def tiny() -> Settings:
    """Return settings of a dozen short runs."""
    settings = Settings()
    # A constant stiffness takes the longest steps.
    straight = settings.train.replace(
        meshes=[replace(mesh, stiffness=2e8) for mesh in settings.train.meshes],
        shafts=[replace(shaft, elements=4) for shaft in settings.train.shafts],
    )
    return replace(
        quick(settings),
        train=straight,
        layouts={"quarter": settings.layouts["quarter"]},
        samples=64,
        settle=0,
        phase_steps=1,
        modes=3,
        accuracy="draft",
    )


@pytest.fixture(scope="module")
def done(tiny, tmp_path_factory):
    with ThreadPoolExecutor(1) as one:
        return run(tiny, tmp_path_factory.mktemp("study"), one)


def files(study, folder):
    folder.mkdir()
    write(study, folder)
    return [path.read_bytes() for path in sorted(folder.iterdir())]


def test_two_workers_give_the_bits_of_one_worker(tiny, done, tmp_path):
    with ThreadPoolExecutor(2) as two:
        both = run(tiny, tmp_path / "runs", two)
    assert list(both.results) == list(done.results) == list(cases(tiny))
    assert files(done, tmp_path / "one") == files(both, tmp_path / "two")
    for case, found in done.results.items():
        for name in found.signals:
            np.testing.assert_array_equal(found[name], both.results[case][name])


def test_a_study_continues_with_the_missing_runs(tiny, done, tmp_path, monkeypatch):
    contents = store.read(done.folder / "runs.sweep")
    outcomes = dict(contents.outcomes)
    for number in (0, 3, 5):
        del outcomes[number]
    store.write(tmp_path / "runs.sweep", contents.head, outcomes)
    made = []
    monkeypatch.setattr(
        "runs.train", lambda settings, case: made.append(case) or train(settings, case)
    )
    again = run(tiny, tmp_path)
    assert set(made) == {cases(tiny)[number] for number in (0, 3, 5)}
    for case, found in done.results.items():
        for name in found.signals:
            np.testing.assert_array_equal(found[name], again.results[case][name])


def test_a_failed_run_keeps_the_others(tiny, tmp_path, monkeypatch):
    def failing(settings, case):
        # the accuracy "reference" takes long
        if case.geometry == "frozen" or case.accuracy == "reference":
            raise gb.ConvergenceError("made to fail")
        return train(settings, case)

    monkeypatch.setattr("runs.train", failing)
    with pytest.raises(gb.GearbowError, match=r"frozen.*ConvergenceError: made to fail"):
        run(tiny, tmp_path)
    kept = gb.Sweep.load(tmp_path / "runs.sweep")
    assert 0 < len(kept.failed) < kept.computed == len(cases(tiny))


@pytest.mark.parametrize("changed", ["samples", "settle", "modal_damping", "bows"])
def test_the_store_of_another_study_is_refused(tiny, done, changed):
    values = {"samples": 65, "settle": 1, "bows": (0.0, 0.02, 0.05)}
    values["train"] = tiny.train.replace(modal_damping=0.03)
    name = "train" if changed == "modal_damping" else changed
    with pytest.raises(gb.SceneError, match="belongs to a sweep with"):
        run(replace(tiny, **{name: values[name]}), done.folder)
    # A setting that no run depends on repeats no run.
    assert run(replace(tiny, backlash=1.0, modes=7), done.folder).results.keys() == set(cases(tiny))


def test_a_case_sets_bow_gear_position_and_load():
    settings = Settings()
    case = Case("half", 30.0, 50.0, bow=0.04, where="middle", phases=(0.5, 0.7), accuracy="draft")
    made = train(settings, case)
    assert [shaft.bow for shaft in made.shafts] == [None, gb.Bow.half_sine(1e-3, phase=0.5), None]
    assert [gear.position for gear in made.gears] == [0.25, 0.25, 0.375, 0.25]
    assert made.torques[0].value == 30.0
    assert made.accuracy == "draft"


def test_the_dimensions_of_the_teeth_are_those_of_gearbow():
    settings = Settings()
    gears = settings.train.gears
    for (driver, driven), mesh in zip(
        (gears[:2], gears[2:]), _core.mesh_geometry(settings.train.description), strict=True
    ):
        teeth = Teeth.of(driver, driven)
        for name in ("centre_distance", "pressure_angle"):
            assert getattr(teeth, name) == pytest.approx(mesh[name], rel=1e-14)
        reach = max(np.add(mesh["tip_radii"], mesh["root_radii"][::-1]))
        assert teeth.tip_clearance == pytest.approx(mesh["centre_distance"] - reach, rel=1e-12)
        pitch = 2.0 * math.pi * mesh["base_radii"][0] / driver.teeth
        assert teeth.base_pitch == pytest.approx(pitch, rel=1e-14)


@pytest.mark.parametrize("where", ["input", "middle", "output"])
def test_means_and_peak_to_peak_values_are_those_of_the_closed_forms(where):
    """At low speed, without load and with stiff parts, every gear centre moves on a circle with the
    local bow.
    """
    given = Settings().train
    stiff = given.replace(
        bearings=[replace(bearing, stiffness=1e10) for bearing in given.bearings],
        meshes=[replace(mesh, stiffness=2e8) for mesh in given.meshes],
        shafts=[replace(shaft, elements=4) for shaft in given.shafts],
        # the rotation by which a free shaft follows its gear centre would turn the bow
        bow_torque=False,
    )
    bow = 0.01
    found = measured(stiff, Case("quarter", 0.0, 2.0, bow=bow, where=where))
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
            reference = (
                rest
                if name != "contact_ratio"
                else measured(stiff, Case("quarter", 0.0, 2.0)).mean(pair, name)
            )
            assert found.mean(pair, name) - reference == pytest.approx(shift, rel=1e-2), name


def measured(straight, case):
    parameters = asdict(case)
    system = make(straight, Settings().layouts, **parameters)
    return Measured(measure(400, 0, system, **parameters))


@pytest.mark.skipif(os.name != "posix", reason="sends signals")
def test_a_killed_study_continues_to_the_bits_of_the_whole_one(tmp_path):
    # The study as a program, with short runs.
    program = tmp_path / "program.py"
    program.write_text(
        f"""import sys
from dataclasses import replace
from pathlib import Path
sys.path.insert(0, {str(EXAMPLE)!r})
import study
from cases import Settings
given = Settings()
short = replace(
    given, bows=tuple(step / 200 for step in range(6)), torques=(250.0,), speeds=(1000.0,), samples=64,
    settle=200, phase_steps=1, accuracy="draft", layouts={{"quarter": given.layouts["quarter"]}},
    train=given.train.replace(
        meshes=[replace(mesh, stiffness=2e8) for mesh in given.train.meshes],  # the longest steps
        shafts=[replace(shaft, elements=2) for shaft in given.train.shafts],
    ),
)
study.Settings = lambda: short
study.main()
""",
        encoding="utf-8",
    )
    folder = tmp_path / "killed"
    command = [sys.executable, "-W", "ignore", program, "--workers", "1"]
    command += ["--print", next(iter(TABLES)), "--out"]

    def stored() -> dict[int, Any]:
        return next((store.read(path).outcomes for path in folder.glob("runs/*.sweep")), {})

    done = 0
    for kill in (signal.SIGTERM, signal.SIGKILL):
        with subprocess.Popen(
            [*command, folder], stdout=subprocess.PIPE, stderr=subprocess.PIPE
        ) as process:
            while len(stored()) <= done and process.poll() is None:
                time.sleep(0.02)
            process.send_signal(kill)
            process.communicate()
        assert process.returncode == -kill
        assert len(stored()) > done
        done = len(stored())
    tables = [
        subprocess.run([*command, out], capture_output=True, check=True).stdout
        for out in (folder, tmp_path / "whole")
    ]
    assert tables[0] == tables[1]
    one, other = (
        store.read(tmp_path / name / "runs" / "runs.sweep").outcomes for name in ("killed", "whole")
    )
    assert len(one) == len(other) > done
    for number, outcome in one.items():
        for name, values in outcome.values.items():
            assert np.asarray(values).tobytes() == np.asarray(other[number].values[name]).tobytes()


def test_every_figure_is_drawn(done, tmp_path):
    paths = drawings.write(done, tmp_path)
    assert [path.name for path in paths] == [f"study_{name}.png" for name in drawings.FIGURES]
    assert all(1000 < path.stat().st_size < 150_000 for path in paths)


def kinematic_shifts(bow: float) -> dict[str, tuple[float, float, float, float]]:
    """Give Δε and Δα at phase 0 and on the mean of both pairs, whose centres are on one line and whose shafts are rigid.

    A bow turns with its shaft; all bows point to the next shaft at phase 0, and that of the middle shaft is bow/√2 at L/4 and 3L/4.
    """
    module, angle = 3e-3, math.radians(20.0)
    base = [0.5 * module * teeth * math.cos(angle) for teeth in (25, 50)]
    reach = sum(
        math.sqrt((0.5 * module * (teeth + 2)) ** 2 - r**2)
        for teeth, r in zip((25, 50), base, strict=True)
    )
    turn = np.linspace(0.0, 8.0 * math.pi, 40001)  # four turns of the input are one of the output
    input_, middle, output = (
        size * np.exp(1j * ratio * turn)
        for size, ratio in ((bow, 1.0), (bow / math.sqrt(2.0), -0.5), (bow, 0.25))
    )
    found = {}
    for pair, first, second in (("g1/g2", input_, middle), ("g3/g4", middle, output)):
        distance = np.abs(module * 37.5 + second - first)
        pressure = np.arccos(sum(base) / distance)
        contact = (reach - distance * np.sin(pressure)) / (math.pi * module * math.cos(angle))
        rest = (reach - module * 37.5 * math.sin(angle)) / (math.pi * module * math.cos(angle))
        found[pair] = (
            contact[0] - rest,
            pressure[0] - angle,
            contact[:-1].mean() - rest,
            pressure[:-1].mean() - angle,
        )
    return found


def test_bows_of_all_shafts_shift_both_means_alike():
    settings = Settings()
    case = replace(settings.base, torque=0.0, speed=min(settings.speeds), accuracy="draft")
    straight, bent = (
        Measured(
            measure(400, 0, make(settings.train, settings.layouts, **asdict(one)), **asdict(one))
        )
        for one in (case, replace(case, bow=0.01))
    )
    for pair, expected in kinematic_shifts(0.01 * 0.025).items():
        found = [
            shift
            for name in ("contact_ratio", "pressure_angle")
            for shift in (
                bent[pair, name][0] - straight[pair, name][0],
                bent.mean(pair, name) - straight.mean(pair, name),
            )
        ]
        # the shafts of the run bend by inertia and by the tooth force: 3 % of the motion
        assert found[0] == pytest.approx(expected[0], rel=0.05)
        assert found[2] == pytest.approx(expected[1], rel=0.05)
        # This bending changes the means, which are of second order, by up to their own size, but not their sign.
        assert 0.0 < found[1] < 2.0 * expected[2]
        assert 2.0 * expected[3] < found[3] < 0.0
    first, second = kinematic_shifts(0.01 * 0.025).values()
    assert first[0] > 0.0 > second[0]
    assert first[2] == pytest.approx(second[2], rel=0.05)
