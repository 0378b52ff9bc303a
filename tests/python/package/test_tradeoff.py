"""Trade-off study: errors against an independent program, Pareto front, budget, report text."""

from __future__ import annotations

import re
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import gearbow as gb
from gearbow.accuracy import LEVELS
from gearbow.studies.study import measure
from reference import independent_solution
from reference.bows import HalfSine
from reference.cases import each_case
from reference.machines import pair_on_housing, rotor
from reference.scenes import PAIR

SPEED, END = 100.0, 4e-3
SCENE = replace(PAIR, bows={"input": HalfSine(1.5e-4)}, elements=2)
FORCE = ("g1", "g2")
TOLERANCES = [1e-3, 1e-5, 1e-7, 1e-9]


def toothed() -> gb.RotorSystem:
    """Return the gear pair with varying stiffness."""
    package = SCENE.package()
    teeth = gb.Stiffness.parabolic(1.5e8, engagement=0.3)
    meshes = [replace(mesh, stiffness=teeth) for mesh in package.meshes]
    return package.replace(meshes=meshes)


def apart(found: np.ndarray, exact: np.ndarray) -> float:
    """Return the RMS of the difference over the RMS of the variation, by an independent formula."""
    square = np.sum((found - exact).reshape(len(exact), -1) ** 2, axis=1).mean()
    variation = np.sum((exact - exact.mean(axis=0)).reshape(len(exact), -1) ** 2, axis=1).mean()
    return float(np.sqrt(square / variation))


@pytest.fixture(scope="module")
def study() -> gb.results.Tradeoff:
    return toothed().tradeoff(
        END,
        SPEED,
        signals=["g1", FORCE],
        methods=["exponential", "rk45"],
        tolerances=TOLERANCES,
        initial="rest",
        repeats=1,
        budget=60.0,
        degrees=[],
    )


def of_method(study: gb.results.Tradeoff, method: str) -> list[gb.results.Trial]:
    return [t for t in study.trials if t.method == method and t.model == "as given"]


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_errors_decrease_with_the_tolerance_down_to_the_uncertainty_of_the_reference(study, method):
    errors = [trial.bound for trial in of_method(study, method)]
    assert len(errors) >= len(TOLERANCES)
    # at a loose tolerance the stability limit sets the steps of rk45: the error stays the same
    assert all(tight <= 1.01 * loose for loose, tight in pairwise(errors))
    assert errors[-1] == study.floor < 1e-6
    assert errors[0] > 1e2 * study.floor


def test_the_reference_agrees_with_an_independent_program():
    times = np.linspace(0.0, END, 101)
    exact = independent_solution.from_rest(SCENE.reference(), SPEED, times).displacement("g1")
    system = SCENE.package()
    found = system.tradeoff(
        END,
        SPEED,
        signals="g1",
        initial="rest",
        tolerances=TOLERANCES,
        steps=[],
        degrees=[],
        modes=[],
        repeats=1,
    )
    # the error of the independent solution at its tolerance of 1e-10 hides
    # smaller errors
    hidden = 1e-7
    for trial in found.trials:
        response = trial.system.simulate(END, SPEED, initial="rest", times=times, **trial.options)
        error = apart(response.displacement("g1"), exact)
        # other times than those of the study: means over time differ by a few percent
        assert error == pytest.approx(trial.error, rel=0.3, abs=hidden + found.floor), str(trial)


@pytest.mark.parametrize("wanted", [1e-2, 1e-4, 1e-6])
def test_a_recommended_setting_has_its_error_against_an_independent_program(wanted):
    times = np.linspace(0.0, END, 101)
    motion = independent_solution.from_rest(SCENE.reference(), SPEED, times)
    found = SCENE.package().tradeoff(
        END, SPEED, signals=["g1", FORCE], initial="rest", degrees=[], repeats=1
    )
    best = found.recommend(error=wanted)
    assert best.error <= wanted
    response = best.system.simulate(END, SPEED, initial="rest", times=times, **best.options)
    assert apart(response.displacement("g1"), motion.displacement("g1")) < 1.3 * wanted
    assert apart(response.mesh(FORCE).force, motion.mesh_force(0, live=True)) < 1.3 * wanted
    cheaper = [t for t in found.trials if t.seconds < best.trial.seconds]
    assert all(trial.bound > wanted for trial in cheaper)


def test_the_error_of_a_simplification_is_that_of_a_direct_comparison(study):
    system = toothed()
    times = np.arange(0.0, END, system.default_output_step(END, SPEED))
    how = {"method": "rk45", "rtol": 1e-11, "initial": "rest", "times": times}
    exact = system.simulate(END, SPEED, **how)
    mean = system.static().mesh(FORCE).stiffness
    coarse = [replace(shaft, elements=1) for shaft in system.shafts]
    level = [replace(mesh, stiffness=mean) for mesh in system.meshes]
    others = {
        "frozen geometry": system.simulate(END, SPEED, geometry="frozen", **how),
        "mean stiffness": system.replace(meshes=level).simulate(END, SPEED, **how),
    }
    assert len(system.replace(shafts=coarse).dofs) == len(system.dofs)  # gears stand on the nodes
    assert {t.model for t in study.trials} - {"as given"} >= set(others)
    assert "elements × 0.5" not in {t.model for t in study.trials}
    for model, response in others.items():
        *_, tight = (trial for trial in study.trials if trial.model == model)
        error = apart(response.displacement("g1"), exact.displacement("g1"))
        assert tight.errors["the displacement of g1"] == pytest.approx(error, rel=1e-2)
        error = apart(response.mesh(FORCE).force, exact.mesh(FORCE).force)
        assert tight.errors["the force of g1/g2"] == pytest.approx(error, rel=1e-2)
        assert tight.integration_error <= study.floor
        assert tight.model_error == tight.error > 1e-3


def test_fewer_modes_and_more_elements_are_separate_models(study):
    counts = [t for t in study.trials if t.model.endswith("modes")]
    assert counts
    for trial in counts:
        assert trial.options["modes"] == int(trial.model.split()[0])
        assert trial.options["method"] == "exponential"
        # its error is the sum of integration error and model error, with unknown signs
        assert trial.error <= 1.001 * (trial.integration_error + trial.model_error)
    assert study.discretisation is None


def test_errors_count_from_elements_of_a_higher_degree():
    system = toothed()
    given = {"initial": "rest", "record": ["g1", FORCE]}
    found = system.tradeoff(
        END,
        SPEED,
        signals=["g1", FORCE],
        methods="exponential",
        tolerances=[1e-6],
        modes=[],
        frozen=False,
        mean_stiffness=False,
        initial="rest",
        repeats=1,
    )
    model, errors = found.discretisation
    assert model == "degree 3"
    assert {trial.model for trial in found.trials} == {"as given", "degree 2"}
    shafts = [replace(shaft, degree=3) for shaft in system.shafts]
    times = np.arange(0.0, END, system.default_output_step(END, SPEED))
    given |= {"method": "exponential", "rtol": 1e-9, "times": times}
    coarse = system.simulate(END, SPEED, **given)
    fine = system.replace(shafts=shafts).simulate(END, SPEED, **given)
    error = apart(coarse.mesh(FORCE).force, fine.mesh(FORCE).force)
    assert errors["the force of g1/g2"] == pytest.approx(error, rel=0.05)
    for trial in found.trials:
        assert trial.error <= 1.001 * (trial.integration_error + trial.model_error)
    (last,) = [trial for trial in found.trials if trial.model == "as given"][-1:]
    assert last.model_error == pytest.approx(max(errors.values()))


def test_no_setting_of_the_pareto_front_is_dominated(study):
    for duration in (None, 10.0):
        front = study.front(duration=duration)
        assert front
        for trial in study.trials:
            better = [
                f
                for f in front
                if f.cost(duration) <= trial.cost(duration) and f.bound <= trial.bound
            ]
            assert better or trial in front, str(trial)
        costs = [trial.cost(duration) for trial in front]
        bounds = [trial.bound for trial in front]
        assert costs == sorted(costs)
        assert all(tight < loose for loose, tight in pairwise(bounds))
    assert all(t.model == "as given" for t in study.front(simplified=False))


def test_a_recommendation_compares_setup_and_stepping_cost(study):
    quick, lasting = study.recommend(1e-4), study.recommend(1e-4, duration=1e4)
    assert lasting.trial.rate <= quick.trial.rate
    assert quick.trial.seconds <= lasting.trial.seconds
    assert study.recommend(1e-4, simplified=False).system.dofs == toothed().dofs


def test_an_error_bound_below_all_settings_is_refused(study):
    with pytest.raises(gb.GearbowError, match=r"meets 1e-15; the most accurate is .*uncertainty"):
        study.recommend(1e-15)
    with pytest.raises(gb.SceneError, match=r"^error: must be positive"):
        study.recommend(-1.0)
    with pytest.raises(gb.SceneError, match=r"^duration: must be positive"):
        study.front(duration=0.0)


def test_the_table_contains_all_results(study):
    text = str(study)
    assert f"uncertainty {study.floor:.1e}" in text
    lines = study.table().split("\n\n")[1].splitlines()
    assert len(lines) == 1 + len(study.trials)
    assert sum(line.startswith("*") for line in lines) == len(study.front())
    assert all(
        "<" in line for line, t in zip(lines[1:], study.trials, strict=True) if t.error <= t.floor
    )
    frame = study.to_dataframe()
    assert list(frame["error"]) == [trial.error for trial in study.trials]
    assert list(frame["seconds"]) == [t.setup + t.stepping for t in study.trials]
    assert list(frame["steps"]) == [trial.steps for trial in study.trials]
    assert set(frame["limited by"]) == {trial.limited_by for trial in study.trials}


def test_the_diagram_shows_every_method_and_model(study, tmp_path):
    figure = study.plot()
    (panel,) = figure.axes
    assert panel.get_xscale() == panel.get_yscale() == "log"
    lines = {line.get_label(): line for line in panel.get_lines()}
    models = {trial.model for trial in study.trials} - {"as given"}
    assert set(lines) >= {"exponential", "rk45", "Pareto front", *models}
    drawn = lines["exponential"]
    np.testing.assert_allclose(
        drawn.get_xdata(), [t.bound for t in of_method(study, "exponential")]
    )
    np.testing.assert_allclose(
        drawn.get_ydata(), [t.seconds for t in of_method(study, "exponential")]
    )
    # marker shapes, for readers who cannot distinguish the colours
    markers = [lines[name].get_marker() for name in {"exponential", "rk45", *models}]
    assert len(set(markers)) == len(markers)
    study.plot(duration=10.0).savefig(tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 1000


def test_the_same_study_finds_the_same_errors(study):
    again = toothed().tradeoff(
        END,
        SPEED,
        signals=["g1", FORCE],
        methods=["exponential", "rk45"],
        tolerances=TOLERANCES,
        initial="rest",
        repeats=2,
        budget=60.0,
        degrees=[],
    )
    assert [str(t) for t in again.trials] == [str(t) for t in study.trials]
    assert [t.errors for t in again.trials] == [t.errors for t in study.trials]
    assert again.floor == study.floor


def test_a_budget_ends_a_long_setting():
    budget = 6.0
    begin = time.perf_counter()
    found = toothed().tradeoff(
        0.02,
        SPEED,
        signals="g1",
        methods=["rk4", "rk45"],
        steps=[1e-6, 1e-9],
        budget=budget,
        repeats=1,
    )
    # a run checks the time every 50 ms; the factor two allows for other work on the machine
    assert time.perf_counter() - begin < 2.0 * budget
    slow = [skipped for skipped in found.skipped if skipped.setting == "rk4, step 1e-09 s"]
    assert slow
    assert slow[0].reason.startswith("takes ")
    assert str(slow[0]) in str(found)
    assert any(trial.setting == "rk4, step 1e-06 s" for trial in found.trials)


def test_no_setting_starts_after_the_budget_is_spent(monkeypatch):
    def dawdling(*args, **options):
        time.sleep(0.2)
        return measure(*args, **options)

    monkeypatch.setattr("gearbow.studies.study.measure", dawdling)
    found = toothed().tradeoff(END, SPEED, signals="g1", budget=2.0)
    # of more than 30 settings, those that end within two seconds
    late = [skipped for skipped in found.skipped if skipped.reason == "the budget is spent"]
    assert len(late) > 10
    assert 2 <= len(found.trials) <= 11


def test_a_budget_too_short_for_a_reference_is_an_error():
    system = gb.RotorSystem(
        [replace(shaft, elements=40) for shaft in toothed().shafts],
        toothed().gears,
        toothed().meshes,
        toothed().bearings,
        toothed().torques,
    )
    with pytest.raises(gb.GearbowError, match=r"^budget: too short for a reference"):
        system.tradeoff(10.0, SPEED, signals="g1", methods="rk4", budget=0.1)


def test_a_study_may_consist_of_the_reference_and_its_check():
    alone = {"modes": [], "elements": [], "degrees": [], "frozen": False, "mean_stiffness": False}
    found = toothed().tradeoff(
        1e-3, SPEED, signals="g1", methods="exponential", tolerances=[1e-12], repeats=1, **alone
    )
    assert [trial.setting for trial in found.trials] == [found.reference, found.check]
    assert found.skipped == ()


def test_an_interrupted_study_keeps_its_settings():
    def interrupt(fraction):
        if fraction > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stopped:
        toothed().tradeoff(1e-3, SPEED, signals="g1", repeats=1, progress=interrupt)
    kept = stopped.value.tradeoff
    assert {kept.reference, kept.check} < {trial.setting for trial in kept.trials}
    assert kept.recommend(1.0).error <= 1.0


def test_an_unstable_step_is_skipped_with_a_reason():
    found = toothed().tradeoff(
        1e-3, SPEED, signals="g1", methods="rk4", steps=[1e-3, 1e-6], initial="rest", repeats=1
    )
    unstable = [skipped for skipped in found.skipped if skipped.setting == "rk4, step 0.001 s"]
    assert unstable
    assert "stability limit" in unstable[0].reason


def test_progress_increases_from_0_to_1(capsys):
    seen: list[float] = []
    how = {"signals": "g1", "methods": "exponential", "tolerances": [1e-3], "repeats": 1}
    toothed().tradeoff(1e-3, SPEED, progress=seen.append, **how)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    toothed().tradeoff(1e-3, SPEED, progress=True, **how)
    assert re.search(r"(\d+)/\1 points", capsys.readouterr().err)


@each_case(
    ("given", "text"),
    [
        ({"duration": 0.0}, "duration: must be positive, got 0.0"),
        ({"duration": "long"}, "duration: must be a number, got 'long'"),
        ({"speed": np.nan}, "speed: must be finite, got nan"),
        ({"signals": "g9"}, 'signals: no gear, disk, support or housing is called "g9"'),
        ({"signals": ("input", 0.1)}, 'signals: shaft "input" has no node at 0.1 m'),
        ({"signals": ("g2", "g1")}, "signals: no gear 'g2' drives a gear 'g1'"),
        ({"signals": 3}, "signals: must be a name, (shaft, position) or (driver, driven), got 3"),
        ({"signals": []}, "signals: must name at least one signal"),
        ({"methods": ["euler"]}, "methods[0]: must be one of exponential, rk45, rk4"),
        ({"methods": []}, "methods: must name at least one method"),
        ({"methods": "rk45", "tolerances": []}, "methods: no settings for rk45"),
        ({"steps": [1e-6, 0.0]}, "steps[1]: must be positive, got 0.0"),
        ({"tolerances": [2.0]}, "tolerances[0]: must be between 0 and 1, got 2.0"),
        ({"tolerances": 1e-3}, "tolerances: must be a list of numbers, got 0.001"),
        ({"elements": [-1.0]}, "elements[0]: must be positive, got -1.0"),
        ({"modes": [0]}, "modes[0]: must be at least 1, got 0"),
        ({"repeats": 0}, "repeats: must be at least 1, got 0"),
        ({"budget": 0.0}, "budget: must be positive, got 0.0"),
        ({"initial": "warm"}, "initial: must be one of synchronous, static, rest, got 'warm'"),
        ({"output_step": 0.0}, "output_step: must be positive, got 0.0"),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else "",
)
def test_the_error_names_the_invalid_argument(given, text):
    with pytest.raises(gb.SceneError) as caught:
        toothed().tradeoff(**{"duration": 1e-3, "speed": SPEED, "signals": "g1"} | given)
    assert str(caught.value).startswith(text)


def test_a_constant_signal_has_no_relative_error():
    straight = replace(PAIR, elements=2).package()
    with pytest.raises(gb.SceneError, match=r"^signals: the displacement of g1 is constant"):
        straight.tradeoff(1e-3, SPEED, signals="g1", initial="static")


def test_tradeoff_of_a_torsional_train_compares_mesh_forces():
    package = replace(PAIR, elements=2).package()
    teeth = [replace(mesh, stiffness=gb.Stiffness.parabolic(1.5e8)) for mesh in package.meshes]
    system = gb.RotorSystem(
        package.shafts, package.gears, teeth, (), package.torques, motion="torsion"
    )
    with pytest.raises(gb.SceneError, match=r"^signals: 'g1' has no lateral motion"):
        system.tradeoff(1e-3, SPEED, signals="g1")
    found = system.tradeoff(2e-3, SPEED, signals=FORCE, methods="exponential", repeats=1)
    # its gear centres do not move, so that frozen geometry is no simplification
    assert "frozen geometry" not in {trial.model for trial in found.trials}


@pytest.mark.filterwarnings("ignore:accuracy:gearbow.AccuracyWarning")
@pytest.mark.parametrize("word", list(LEVELS))
def test_a_level_keeps_its_integration_error(word):
    times = np.linspace(0.0, END, 101)
    motion = independent_solution.from_rest(SCENE.reference(), SPEED, times)
    system = SCENE.package().replace(accuracy=word)
    response = system.simulate(END, SPEED, initial="rest", times=times)
    level = LEVELS[word]
    assert word in response.accuracy
    # both systems have the same elements, so that only the error of the integration remains; the
    # level leaves most of its error to the elements
    moved = apart(response.displacement("g1"), motion.displacement("g1"))
    forced = apart(response.mesh(FORCE).force, motion.mesh_force(0, live=True))
    assert moved < level.displacement / 10
    assert forced < level.mesh_force / 4
    same = SCENE.package().simulate(
        END, SPEED, method="exponential", rtol=level.rtol, initial="rest", times=times
    )
    # the level may take shorter steps, so that the mesh forces keep their error too
    assert same.statistics.evaluations <= response.statistics.evaluations
    assert same.accuracy is None


def test_the_default_level_is_engineering():
    given = {"duration": END, "speed": SPEED, "initial": "rest"}
    response = SCENE.package().simulate(**given)
    assert response.accuracy.startswith("engineering")
    with pytest.warns(gb.AccuracyWarning, match="^accuracy: the elements are too coarse"):
        same = SCENE.package().simulate(**given, accuracy="engineering")
    assert np.array_equal(same.displacement("g1"), response.displacement("g1"))
    for setting in ({"method": "rk45"}, {"step": 1e-5}, {"rtol": 1e-4}):
        assert SCENE.package().simulate(**given, **setting).accuracy is None
    # the level promises nothing for stages that someone chooses
    assert SCENE.package().simulate(**given, stages=2).accuracy is None


@pytest.mark.parametrize(
    "other", [{"method": "rk4"}, {"step": 1e-6}, {"rtol": 1e-3}, {"stages": 2}]
)
def test_a_named_accuracy_with_a_setting_is_an_error(other):
    (name,) = other
    with pytest.raises(gb.SceneError, match=rf"^accuracy: cannot be given together with {name}"):
        SCENE.package().simulate(1e-4, SPEED, accuracy="draft", **other)


def test_the_error_for_an_unknown_accuracy_lists_the_known_ones():
    with pytest.raises(
        gb.SceneError, match=r"^accuracy: must be one of draft, engineering, reference, got 'good'"
    ):
        SCENE.package().simulate(1e-4, SPEED, accuracy="good")


@pytest.mark.filterwarnings("ignore:accuracy:gearbow.AccuracyWarning")
def test_separation_limits_the_expected_accuracy():
    package = replace(PAIR, elements=2, torque=5.0).package()
    error = gb.TransmissionError(tooth=[(2e-5, 0.0)])
    meshes = [replace(mesh, backlash=1e-4, error=error) for mesh in package.meshes]
    rattling = gb.RotorSystem(
        package.shafts, package.gears, meshes, package.bearings, package.torques
    )
    response = rattling.simulate(0.01, SPEED, accuracy="draft")
    assert any(event.kind == "separation" for event in response.events)
    assert "flanks separated" in response.accuracy
    closed = SCENE.package().simulate(1e-3, SPEED, accuracy="draft")
    assert "separated" not in closed.accuracy


def test_a_linear_rotor_has_an_error_of_round_off(tmp_path):
    # the exponential method is exact without meshes: reference and check are equal to the last bit
    found = rotor({"elements": 2, "bow": gb.Bow.half_sine(1e-4)}).tradeoff(
        0.01, 100.0, signals=("rotor", 0.5), initial="rest", methods="exponential", repeats=1
    )
    assert found.floor >= np.finfo(float).eps
    assert "0.0e+00" not in str(found)
    figure = found.plot()
    (panel,) = figure.axes
    assert panel.get_xlim()[0] > 0.0
    figure.savefig(tmp_path / "figure.png")


@pytest.mark.parametrize("speed", [gb.rpm(900.0), -SPEED])
def test_signals_may_name_supports_and_housings(speed: float):
    system, names = pair_on_housing(), ["foot", "box"]
    alone = {"modes": [], "degrees": [], "elements": [], "frozen": False, "mean_stiffness": False}
    given = {"methods": "exponential", "tolerances": [1e-2], "repeats": 1, "initial": "rest"}
    found = system.tradeoff(END, speed, signals=names, **alone, **given)
    assert found.signals == ("the displacement of foot", "the displacement of box")
    assert f" s at {'900 rpm' if speed > 0.0 else '-100 rad/s'}; signals: " in str(found)
    (trial,) = (trial for trial in found.trials if "1e-02" in trial.setting)
    shared = {"record": names, "initial": "rest", "method": "exponential"}
    exact = system.simulate(END, speed, rtol=1e-10, **shared)
    run = system.simulate(END, speed, rtol=1e-2, **shared)
    for name in names:
        expected = apart(run.displacement(name), exact.displacement(name))
        assert expected > 1e-7
        assert trial.errors[f"the displacement of {name}"] == pytest.approx(expected, rel=1e-3)
