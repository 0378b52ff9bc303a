"""The estimated error of a run, compared with errors that are measured by other means."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference.machines import toothed_pair

DURATION = 0.02
SPEED = 100.0


def difference(first, second, rows=np.s_[:]):
    """Return the errors of the first response as `errors` defines them, at some of the times."""
    both = (first, second)
    pairs = {
        "displacement": [tuple(r.displacement(g)[rows] for g in ("g1", "g2")) for r in both],
        "mesh_force": [(r.mesh(("g1", "g2")).force[rows, np.newaxis],) for r in both],
    }
    return {
        kind: max(rms(a - b) / rms(b - b.mean(axis=0)) for a, b in zip(*signals, strict=True))
        for kind, signals in pairs.items()
    }


def rms(values):
    return np.sqrt(np.mean(np.sum(values**2, axis=1)))


def test_errors_of_elements_are_those_against_a_high_degree():
    response = toothed_pair(2).simulate(DURATION, SPEED)
    shafts = [replace(shaft, elements=4, degree=6) for shaft in toothed_pair().shafts]
    exact = toothed_pair().replace(shafts=shafts)
    fine = exact.simulate(DURATION, SPEED, method="exponential", rtol=1e-9)
    for kind, error in difference(response, fine).items():
        found = response.errors()[kind]
        assert error / 2 < found.total < 2 * error
        assert found.elements == pytest.approx(found.total, rel=0.05)
        assert found.integration < 0.01 * found.total
        assert found.modes == 0.0


@pytest.mark.parametrize(
    "settings",
    [
        {"method": "exponential", "rtol": 1e-2},
        {"method": "rk45", "rtol": 1e-3},
        {"method": "etdrk4", "step": 2e-5},
    ],
    ids=lambda settings: settings["method"],
)
def test_errors_of_integration_are_those_against_a_small_tolerance(settings):
    system = toothed_pair()
    response = system.simulate(DURATION, SPEED, **settings)
    exact = system.simulate(DURATION, SPEED, method="exponential", rtol=1e-10)
    for kind, error in difference(response, exact).items():
        # the companion of a tolerance keeps about 1 % of the error
        assert response.errors()[kind].integration == pytest.approx(error, rel=0.1)


@pytest.mark.filterwarnings("ignore:modes. 20 modes leave an error:gearbow.AccuracyWarning")
def test_errors_of_modes_are_those_against_all_modes():
    system = toothed_pair(8)
    response = system.simulate(DURATION, SPEED, modes=20, method="exponential", rtol=1e-6)
    complete = system.simulate(DURATION, SPEED, method="exponential", rtol=1e-6)
    for kind, error in difference(response, complete).items():
        assert response.errors()[kind].modes == pytest.approx(error, rel=0.1)


@pytest.mark.parametrize("level", ["draft", "engineering"])
def test_errors_of_a_long_run_contain_the_modes_that_it_left_out(level):
    # a run of 0.1 s, the window of the errors, keeps all modes
    system = toothed_pair(None, accuracy=level)
    response = system.simulate(0.31, SPEED, accuracy=level)
    assert response.statistics.modes < len(system.dofs)
    options = {"times": response.time, "method": "exponential", "rtol": 1e-7}
    complete = system.simulate(0.31, SPEED, **options)
    first = response.time <= 0.1
    assert response.errors().window == 0.1
    for kind, error in difference(response, complete, first).items():
        found = response.errors()[kind]
        left_out = np.hypot(found.modes, found.integration)
        assert error / 3 < left_out < 3 * error
        assert found.modes > 0.1 * error


@pytest.mark.filterwarnings("ignore:modes. 10 modes leave an error:gearbow.AccuracyWarning")
@pytest.mark.parametrize(
    "settings",
    [{"rtol": 1e-2}, {"modes": 10, "rtol": 1e-7}, {"method": "rk45", "rtol": 1e-4}],
    ids=["exponential", "modes", "rk45"],
)
def test_errors_at_a_changing_speed_contain_elements_modes_and_integration(settings):
    system = toothed_pair(3)
    profile = ([0.0, DURATION], [SPEED, 1.5 * SPEED])
    response = system.simulate(DURATION, profile, **settings)
    shafts = [replace(shaft, elements=4, degree=6) for shaft in toothed_pair().shafts]
    exact = {"method": "exponential", "rtol": 1e-9}
    complete = system.simulate(DURATION, profile, **exact)
    fine = toothed_pair().replace(shafts=shafts).simulate(DURATION, profile, **exact)
    left_out = difference(response, complete)
    for kind, error in difference(response, fine).items():
        found = response.errors()[kind]
        assert error / 2 < found.total < 2 * error
        assert found.elements == pytest.approx(difference(complete, fine)[kind], rel=0.1)
        # at most one of both causes a difference to the run with all modes and a small tolerance
        cause = found.modes if "modes" in settings else found.integration
        assert cause == pytest.approx(left_out[kind], rel=0.1)


def test_errors_belong_to_the_recorded_signals():
    system = toothed_pair()
    assert set(system.simulate(1e-3, SPEED, record=["g1", "energy"]).errors()) == {"displacement"}
    assert set(system.simulate(1e-3, SPEED, record=[("g1", "g2")]).errors()) == {"mesh_force"}
    assert system.simulate(1e-3, SPEED, record=[("bearing", "input", 0.0)]).errors() == {}


def test_constant_signals_have_no_error():
    straight = toothed_pair(stiffness=2e8)
    straight = straight.replace(shafts=[replace(shaft, bow=None) for shaft in straight.shafts])
    assert straight.simulate(1e-3, SPEED, initial="static").errors() == {}


def test_errors_do_not_depend_on_the_recorded_times():
    system = toothed_pair()
    some = system.simulate(DURATION, SPEED, times=[0.0, 0.7 * DURATION])
    assert some.errors() == system.simulate(DURATION, SPEED).errors()


@pytest.mark.filterwarnings("ignore:modes. 20 modes leave an error:gearbow.AccuracyWarning")
def test_errors_go_with_a_response_into_its_file_and_through_pickle(tmp_path):
    response = toothed_pair().simulate(
        2e-3, SPEED, modes=20, initial="rest", record=["g1", ("g1", "g2")]
    )
    response.save(tmp_path / "later.npz")
    assert gb.Response.load(tmp_path / "later.npz").errors() == response.errors()
    assert pickle.loads(pickle.dumps(response)).errors() == response.errors()
    response.save(tmp_path / "now.npz")
    loaded = gb.Response.load(tmp_path / "now.npz")
    loaded.request = None
    assert loaded.errors() == response.errors()
    assert loaded.errors().window == response.errors().window == 2e-3


def test_a_response_without_its_system_has_no_errors():
    response = toothed_pair().simulate(1e-3, SPEED)
    response.request = None
    with pytest.raises(gb.GearbowError, match=r"^errors: this response does not know its system"):
        response.errors()


def test_the_error_is_averaged_until_damping_forgets():
    system = toothed_pair()
    modes = system.modes(SPEED)
    decay = -modes.eigenvalues.real[modes.frequencies_hz > 0.0].min()
    assert 0.1 > 3.0 / decay
    assert system.simulate(0.3, SPEED).errors().window == 0.1
    light = system.replace(modal_damping=0.004)
    assert 0.1 < light.simulate(0.5, SPEED).errors().window < 0.5


def test_chaotic_contact_is_named():
    light = toothed_pair(torque=5.0, backlash=1e-4).replace(modal_damping=0.005)
    response = light.simulate(0.1, 1500.0)
    assert response.errors().chaotic
    assert "chaotic contact" in str(response.errors())
    assert "chaotic" in response.accuracy
    smooth = toothed_pair().simulate(0.1, SPEED)
    assert not smooth.errors().chaotic
    assert "chaotic" not in str(smooth.errors())


def test_errors_of_a_continued_run_begin_with_its_state():
    system = toothed_pair()
    first = system.simulate(2e-3, SPEED)
    second = system.simulate(DURATION, SPEED, initial=first)
    exact = gb.RotorSystem.from_dict(
        {**system.description, "shafts": [{**s, "degree": 4} for s in system.description["shafts"]]}
    )
    final = dict(first.final)
    state = exact._model.embed(system._model, final["state"])
    final |= {"state": state, "memory": np.empty(0), "carry": 0.0}
    fine = exact.simulate(DURATION, SPEED, initial=final, method="exponential", rtol=1e-9)
    for kind, error in difference(second, fine).items():
        assert error / 2 < second.errors()[kind].total < 2 * error
    at_start = fine.displacement("g1")[0] - second.displacement("g1")[0]
    assert np.abs(at_start).max() < 1e-15
