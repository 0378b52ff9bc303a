"""Results are plain data: they survive pickling, and they hold no compiled model."""

from __future__ import annotations

import copy
import dataclasses
import io
import pickle
from typing import Any

import numpy as np

import gearbow as gb
from gearbow._core import Model
from gearbow._shown import ReadOnly
from reference.cases import each_case
from reference.machines import bowed_pair, bowed_rotor, hostile, rated
from test_read_only import results, writable
from test_response import recorded

#: Results that contain systems on purpose: the corrected system, and the systems of the trials.
WITH_SYSTEMS = ("balance", "tradeoff", "identification", "correction")


HOT = gb.ThermalBow(("rotor", 0.1), 1e4, time_constant=9.0, shape=gb.Bow.half_sine(1e-6))
MEASURED = [
    gb.results.MeasuredCurve("g1", "y", "velocity", np.array([50.0, 60.0]), np.array([1j, 2.0]))
]


def everything() -> dict[str, Any]:
    system = hostile()
    pair = bowed_pair()
    run = pair.simulate(0.07, 100.0, output_step=2e-4, record=["g1"])
    bowed = bowed_rotor()
    film = gb.JournalBearing(
        "rotor", 0.0, diameter=0.05, length=0.02, clearance=5e-5, viscosity=0.02
    )
    floating = bowed.replace(bearings=[film, bowed.bearings[1]], gravity=(0.0, -9.81))
    balls = gb.RollingBearing(
        "rotor", 0.0, elements=9, element_diameter=0.0127, pitch_diameter=0.065, clearance=0.0
    )
    rolling = bowed.replace(bearings=[balls, bowed.bearings[1]], gravity=(0.0, -9.81))
    campbell, response = results()["campbell"], bowed.synchronous(np.linspace(100.0, 900.0, 9))
    study = bowed.tradeoff(2e-3, 100.0, signals=[("rotor", 0.5)], tolerances=[1e-3], repeats=1)
    measured = gb.Measurement([10.0, 50.0], [[3e-6], [4e-6j]], [gb.Probe("input", 0.25)])
    identified = gb.identify(system, measured, [gb.unknown.bow("input")], runout=False)
    return {
        **results(),
        "mesh state": system.static().mesh(("g1", "g2")),
        "example": gb.examples()["geared_pair"],
        "line": campbell.lines[0],
        "intersection": bowed.campbell([0.0, 900.0], count=2).criticals[0],
        "comparison": results()["frequency response"].compare(MEASURED),
        "measured": MEASURED[0],
        "mode comparison": bowed.modes(count=2).compare(bowed.modes(count=2)),
        "measured shapes": gb.results.MeasuredShapes(
            ("g1",), np.array([5.0]), np.array([[[1.0, 1j]]])
        ),
        "response sensitivity": bowed.sensitivity(
            "bearings[0].damping", bowed.synchronous([100.0, 200.0]), at=("rotor", 0.5)
        ),
        "efficiency": system.replace(
            meshes=[dataclasses.replace(mesh, friction=0.05) for mesh in system.meshes]
        ).efficiency(100.0),
        "mass properties": system.mass_properties(),
        "section forces": system.static().section_forces(system.shafts[0].name),
        "stresses": system.stresses(100.0),
        "thermal stability": bowed.thermal_bow(HOT, [100.0]),
        "thermal spiral": bowed.thermal_bow(HOT, [100.0]).spiral(100.0, 5.0),
        "peak": response.peaks(("rotor", 0.5))[0],
        "peaks": response.peaks(("rotor", 0.5)),
        "life": (life := rated(system).bearing_life(100.0)),
        "life of a bearing": life.bearings[0],
        "case of a spectrum": life.cases[0],
        "limits": system.bow_limits(system.shafts[0].name, 100.0),
        "limit": system.bow_limits(system.shafts[0].name, 100.0).limits[0],
        "orders": run.orders("g1", mesh_harmonics=0),
        "waterfall": gb.waterfall([run, pair.simulate(0.07, 90.0, output_step=2e-4)], "g1"),
        "variable": system.simulate(1e-3, (np.array([0.0, 1e-3]), np.array([90.0, 95.0]))),
        "identification": identified,
        "correction": identified.balance("g1", 100.0),
        "trial influence": gb.results.TrialInfluence(
            ("g1",), ("probe",), np.ones(1), np.full(1, 1j), np.full(1, 2j), np.ones(1)
        ),
        "event": gb.results.Event(0.0, "contact", "a", "b"),
        "statistics": run.statistics,
        "film coefficients": film.coefficients(100.0, 100.0),
        "film of a pad": film.coefficients(100.0, 100.0).pads[0],
        "squeeze coefficients": gb.SqueezeFilm(
            diameter=0.1, length=0.025, clearance=1e-4, viscosity=0.02
        ).coefficients(0.4),
        "rolling coefficients": balls.coefficients(100.0),
        "ring coefficients": balls.ring_coefficients(100.0),
        "rolling estimate": gb.RollingBearing("rotor", 0.0, "6308").estimate,
        "rolling motion": rolling.simulate(1e-3, 100.0, record=["bearings"]).rolling(
            ("rotor", 0.0)
        ),
        "journal motion": floating.static(speed=100.0).journal(("rotor", 0.0)),
        "tradeoff": study,
        "trial": study.trials[0],
        "recommendation": study.recommend(1.0),
    }


MADE = everything()


def parts(value: Any) -> dict[str, Any]:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {entry.name: getattr(value, entry.name) for entry in dataclasses.fields(value)}
    return dict(vars(value))


def same(a: Any, b: Any) -> bool:
    """Compare two values bit by bit."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, gb.RotorSystem):
        return a.description == b.description
    if hasattr(a, "__dict__"):
        return same(parts(a), parts(b))
    return bool(a == b or a != a)  # noqa: PLR0124  # NaN


class Visitor(pickle.Pickler):
    """Pickler that notes all objects of the package that a result holds."""

    def __init__(self) -> None:
        super().__init__(io.BytesIO())
        self.kinds: set[type] = set()

    def reducer_override(self, value: Any) -> Any:
        self.kinds.add(type(value))
        return NotImplemented


@each_case("name", MADE)
def test_a_pickled_result_comes_back_bit_for_bit(name: str):
    for twin in (pickle.loads(pickle.dumps(MADE[name])), copy.deepcopy(MADE[name])):
        assert same(twin, MADE[name])
        assert writable(twin) == []


@each_case("name", MADE)
def test_a_result_holds_no_compiled_model(name: str):
    visitor = Visitor()
    visitor.dump(MADE[name])
    assert Model not in visitor.kinds
    if name not in (*WITH_SYSTEMS, "trial", "recommendation"):
        assert gb.RotorSystem not in visitor.kinds


def test_every_public_class_of_results_is_tested():
    def below(kind: type) -> set[type]:
        return {kind}.union(*(below(child) for child in kind.__subclasses__()))

    kinds = {type(value) for value in MADE.values()}
    # The profile of a variable speed is part of a response.
    wanted = {kind for kind in below(ReadOnly) if kind.__name__ in dir(gb.results)} - {
        gb.SpeedProfile
    }
    assert wanted <= kinds
    assert {
        gb.results.Event,
        gb.results.Peak,
        gb.results.ExcitationLine,
        gb.results.Intersection,
        gb.results.Trial,
    } <= kinds


def test_copies_answer_as_the_originals():
    modes = pickle.loads(pickle.dumps(MADE["modes"]))
    assert modes.table() == MADE["modes"].table()
    response = bowed_pair(bow=gb.Bow.half_sine(1e-4)).synchronous(np.linspace(50.0, 900.0, 9))
    twin = pickle.loads(pickle.dumps(response))
    assert twin.peaks("g1") == response.peaks("g1")
    slow = twin.subtract_slow_roll(1.0).amplitudes
    assert np.array_equal(slow, response.subtract_slow_roll(1.0).amplitudes)


def test_a_run_continues_from_a_pickled_response():
    first = recorded()
    system = hostile()
    run = system.simulate(1e-3, 100.0)
    on, again = (
        system.simulate(1e-3, 100.0, initial=start)
        for start in (run, pickle.loads(pickle.dumps(run)))
    )
    assert np.array_equal(on.final["state"], again.final["state"])
    assert same(pickle.loads(pickle.dumps(first)).final, first.final)
