"""Number and degree of elements that gearbow chooses."""

import copy
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from fleet import FOLDER
from gearbow.accuracy import LEVELS
from reference.comparisons import error
from reference.machines import inertia, rotor, toothed_pair
from test_errors import difference

SPEED = 100.0


def automatic(**options):
    """Return the pair without numbers of elements."""
    system = toothed_pair(**options)
    shafts = [replace(shaft, elements=None) for shaft in system.shafts]
    return system.replace(shafts=shafts)


def exact(system, factor=2):
    """Return the system with more elements of degree 7."""
    shafts = []
    for shaft in system.shafts:
        (number,) = system.discretisation.shafts[shaft.name].numbers
        shafts.append(replace(shaft, elements=factor * number, degree=7))
    return system.replace(shafts=shafts)


@pytest.mark.parametrize("level", ["draft", "engineering"])
def test_chosen_elements_keep_the_error_of_their_level(level):
    system = automatic().replace(accuracy=level)
    permitted = {"draft": 1e-1, "engineering": 1e-2}[level]
    assert system.discretisation.expected_error <= permitted
    assert system.discretisation.permitted_error == permitted
    response = system.simulate(0.05, SPEED, accuracy=level)
    fine = exact(system).simulate(0.05, SPEED, method="exponential", rtol=1e-8)
    errors = difference(response, fine)
    assert errors["mesh_force"] <= permitted
    assert errors["displacement"] <= permitted / 10
    for kind, size in errors.items():
        assert size / 3 < response.errors()[kind].total < 3 * size


def test_levels_differ_in_their_number_of_coordinates():
    levels = ("draft", "engineering", "reference")
    sizes = [len(automatic().replace(accuracy=level).dofs) for level in levels]
    assert sizes == sorted(set(sizes))


def test_engineering_is_the_default():
    system = automatic()
    assert system.accuracy == "engineering"
    assert "accuracy" not in system.description
    assert system.discretisation == system.replace(accuracy="engineering").discretisation
    assert system.discretisation.level == "engineering"


def test_given_numbers_are_kept():
    system = toothed_pair(3)
    assert system.discretisation.level is None
    assert system.discretisation.expected_error is None
    assert {s.degree for s in system.discretisation.shafts.values()} == {1}
    assert {s.numbers for s in system.discretisation.shafts.values()} == {(3,)}
    first, second = system.shafts
    mixed = system.replace(shafts=[first, replace(second, elements=None)])
    assert mixed.discretisation.shafts["input"].numbers == (3,)
    assert mixed.discretisation.shafts["output"].degree > 1
    cubic = system.replace(shafts=[replace(s, elements=None, degree=4) for s in system.shafts])
    assert {s.degree for s in cubic.discretisation.shafts.values()} == {4}


def test_a_number_for_one_segment_is_a_number_for_all():
    segments = [gb.Segment(0.2, 0.04, elements=2), gb.Segment(0.2, 0.05)]
    shaft = gb.Shaft("input", segments=segments)
    system = toothed_pair().replace(shafts=[shaft, toothed_pair().shafts[1]])
    found = system.discretisation.shafts["input"]
    assert (found.numbers, found.degree) == ((2, 1), 1)


def test_the_choice_is_not_written_into_the_description(tmp_path):
    system = automatic().replace(accuracy="draft")
    system.save(tmp_path / "scene.toml")
    loaded = gb.RotorSystem.load(tmp_path / "scene.toml")
    for other in (loaded, gb.RotorSystem.from_dict(system.description)):
        assert other.shafts[0].elements is None
        assert other.shafts[0].degree is None
        assert other.accuracy == "draft"
        assert other.dofs == system.dofs
        assert other.discretisation == system.discretisation
    assert "elements" not in (tmp_path / "scene.toml").read_text()


def test_an_unknown_level_is_refused():
    with pytest.raises(gb.SceneError, match=r"^accuracy: .*`fine`"):
        toothed_pair(accuracy="fine")


def test_the_choice_can_be_printed():
    text = str(automatic().discretisation)
    assert "input: " in text
    assert "elements of degree" in text
    assert "engineering: expected error" in text


def test_without_meshes_the_elements_serve_bow_and_unbalance():
    system = rotor(
        {"elements": None, "bow": gb.Bow.half_sine(1e-4)},
        inertia(10.0, 0.03, 0.06, position=0.4),
        {"stiffness": 1e8, "damping": 500.0},
    )
    assert_elements_serve(system, 1e-3, initial="rest")


def assert_elements_serve(system: gb.RotorSystem, bound: float, **options: Any) -> None:
    """Check the error of a run from elements with finer ones, and the estimate of this error."""
    run: dict[str, Any] = {"record": ["disk"], **options}
    response = system.simulate(0.1, 200.0, **run)
    run.pop("accuracy", None)
    fine = exact(system).simulate(0.1, 200.0, method="exponential", rtol=1e-9, **run)
    left = error(response.displacement("disk"), fine.displacement("disk"))
    assert left < bound
    assert left / 3 < response.errors()["displacement"].total < 3 * left


@pytest.mark.parametrize("level", ["draft", "engineering"])
@pytest.mark.parametrize("initial", ["rest", "static"])
def test_elements_serve_a_bow_that_an_undamped_run_releases(level, initial):
    shaft = {"elements": None, "bow": gb.Bow.mode(3, 1e-4)}
    system = rotor(shaft, inertia(10.0, 0.03, 0.06, position=0.3), accuracy=level)
    bound = {"draft": 1e-2, "engineering": 1e-3}[level]
    assert_elements_serve(system, bound, initial=initial, accuracy=level)


def test_elements_too_coarse_for_the_level_give_a_warning():
    with pytest.warns(gb.AccuracyWarning, match="^accuracy: the elements are too coarse for"):
        toothed_pair(1).simulate(1e-3, SPEED, accuracy="draft")
    # so does an accuracy of the system above the default
    with pytest.warns(gb.AccuracyWarning, match="too coarse for 'reference'.*the numbers of elem"):
        toothed_pair(8, accuracy="reference").simulate(0.0, SPEED)
    # the default level says it in the response
    assert "does not include the elements" in toothed_pair(1).simulate(1e-3, SPEED).accuracy
    assert "does not include" not in automatic(accuracy="draft").simulate(1e-3, SPEED).accuracy
    assert "does not include" not in automatic().simulate(1e-3, SPEED).accuracy


def test_a_choice_that_the_number_of_coordinates_limits_is_too_coarse():
    long = [gb.Shaft(name, length=2.0, outer_diameter=0.03) for name in ("input", "output")]
    bearings = [gb.Bearing(s, x, stiffness=1e8) for s in ("input", "output") for x in (0.0, 2.0)]
    system = automatic(accuracy="reference", stiffness=gb.Stiffness.square(2e8))
    system = system.replace(shafts=long, bearings=bearings, modal_damping=None)
    assert system.discretisation.expected_error > system.discretisation.permitted_error
    # `simulate` writes both into its warning; a run would take half a minute
    level = LEVELS["reference"]
    assert "the largest number of coordinates that gearbow chooses" in level.coarse(
        system._model, 100.0
    )
    assert "response.errors()" in level.finer(system._model, "reference")
    assert "replace(accuracy='reference')" in level.finer(automatic()._model, "engineering")


def test_bearings_with_a_speed_table_have_a_choice():
    table = gb.SpeedTable([50.0, 200.0], [1e8, 2e8])
    bearings = [replace(bearing, stiffness=table) for bearing in automatic().bearings]
    system = automatic().replace(bearings=bearings)
    assert system.discretisation.expected_error <= 1e-2


@pytest.mark.parametrize("level", ["draft", "engineering", "reference"])
def test_chosen_elements_are_not_much_shorter_than_equal_parts(level):
    """An equal part that ends close to a gear would leave a very short element beside it.

    Such an element has a natural frequency that is a thousand times as high as those of the others; the round-off error of
    the low modes grows with its square.
    """
    for k in range(4):
        position = 0.25 * (1 + 10.0 ** (-1 - k))
        system = gb.RotorSystem(
            shafts=[gb.Shaft("shaft", length=0.5, outer_diameter=0.02)],
            disks=[gb.Disk("disk", "shaft", position, 2.0, 1e-3, 2e-3)],
            bearings=[gb.Bearing("shaft", x, stiffness=1e8, damping=500.0) for x in (0.0, 0.5)],
            accuracy=level,
        )
        (number,) = system.discretisation.shafts["shaft"].numbers
        nodes = sorted({dof[1] for dof in system.dofs if not isinstance(dof[1], tuple)})
        assert min(np.diff(nodes)) >= 0.1 * 0.5 / number


@pytest.mark.parametrize(("degree", "elements"), [(2, 10), (3, 8), (4, 6)])
def test_the_expected_error_of_a_large_model_is_that_of_all_modes(degree, elements):
    # From 400 coordinates on, the modes follow from the loads. A shaft that carries nothing makes the model
    # larger; its coupling has a torsional stiffness of 1 N m/rad.
    system = toothed_pair()
    shafts = [replace(shaft, elements=elements, degree=degree) for shaft in system.shafts]
    small = system.replace(shafts=shafts)
    last = shafts[-1]
    idle = gb.Shaft("idle", length=1.0, outer_diameter=0.05, elements=80, degree=1)
    large = small.replace(
        shafts=[*shafts, idle],
        bearings=[*system.bearings, *(gb.Bearing("idle", x, stiffness=1e8) for x in (0.0, 1.0))],
        couplings=[gb.Coupling((last.name, last.length), ("idle", 0.0), torsional_stiffness=1.0)],
    )
    assert len(small.dofs) < 400 <= len(large.dofs)
    errors = [one._model.expected_error() for one in (small, large)]
    # The modes of a Krylov space of the loads give 11 % less with degree 4.
    assert errors[1] == pytest.approx(errors[0], rel=0.12)


def changed_by_round_off(description, seed):
    """Return a scene with each shaft and its parts longer or shorter by up to 1e-14 of its length, and no diameter the same."""
    random = np.random.default_rng(seed)
    changed = copy.deepcopy(description)
    factors = {
        shaft["name"]: 1.0 + 1e-14 * random.uniform(-1.0, 1.0) for shaft in changed["shafts"]
    }
    for shaft in changed["shafts"]:
        for part in (shaft, *shaft.get("segments", ())):
            if "length" in part:
                part["length"] *= factors[shaft["name"]]
            if "outer_diameter" in part:
                part["outer_diameter"] *= 1.0 + 1e-14 * random.uniform(-1.0, 1.0)
    for key in ("gears", "disks", "bearings"):
        for part in changed.get(key, ()):
            part["position"] *= factors[part["shaft"]]
    return changed


@pytest.mark.skipif(not FOLDER.is_dir(), reason="the examples are not installed")
def test_round_off_does_not_change_the_choice():
    for machine, accuracy in (
        ("branched_train", "draft"),
        ("coaxial_reducer", "engineering"),
        ("gearbox", "draft"),
        ("helical_gear", "engineering"),
        ("turbine_rotor", "engineering"),
        ("double_stage_train", "reference"),
    ):
        description = gb.RotorSystem.load(FOLDER / f"{machine}.toml").description
        description["accuracy"] = accuracy
        choice = gb.RotorSystem.from_dict(description).discretisation.shafts
        for seed in range(3):
            other = gb.RotorSystem.from_dict(changed_by_round_off(description, seed))
            assert other.discretisation.shafts == choice, (machine, seed)


def test_equal_shafts_do_not_leave_the_choice_to_round_off():
    # Coarser elements on one of three equal shafts increase the error equally.
    names = ("first", "second", "third")
    halves = [gb.Segment(0.25, 0.03)] * 2
    description = gb.RotorSystem(
        [gb.Shaft(name, segments=halves) for name in names],
        [gb.Gear(f"on {n}", n, 0.25, teeth=40, module=3e-3, face_width=0.03) for n in names],
        [
            gb.Mesh(f"on {a}", f"on {b}", stiffness=2e8, damping_ratio=0.05)
            for a, b in pairwise(names)
        ],
        [gb.Bearing(n, x, stiffness=1e8, damping=500.0) for n in names for x in (0.0, 0.5)],
        [gb.Torque("on first", 200.0), gb.Torque.balance("on third")],
    ).description
    choice = gb.RotorSystem.from_dict(description).discretisation.shafts
    for seed in range(3):
        other = gb.RotorSystem.from_dict(changed_by_round_off(description, seed))
        assert other.discretisation.shafts == choice, seed


def long_train(stages):
    """Return a helical train of many shafts, of which the last two are coupled, with a bow and bearings in housings."""
    names = [f"shaft {i}" for i in range(stages + 2)]
    halves = [gb.Segment(0.2, 0.04), gb.Segment(0.2, 0.045)]
    housings = [
        gb.Housing(f"housing {i}", mass=40.0, stiffness=3e8, damping=2e3)
        for i in range(stages // 4)
    ]
    gears, meshes = [], []
    for i in range(stages):
        hand = 0.2 * (-1) ** i
        common = {"module": 3e-3, "face_width": 0.03}
        gears += [
            gb.Gear(
                f"pinion {i}", names[i], 0.3, teeth=23 + 18 * (i % 2), helix_angle=hand, **common
            ),
            gb.Gear(
                f"wheel {i}",
                names[i + 1],
                0.1,
                teeth=43 - 18 * (i % 2),
                helix_angle=-hand,
                **common,
            ),
        ]
        meshes.append(gb.Mesh(f"pinion {i}", f"wheel {i}", stiffness=2e8, damping_ratio=0.05))

    def base(shaft):
        return f"housing {shaft // 4}" if shaft % 4 == 0 and shaft < stages else None

    bearings = [
        gb.Bearing(
            name, x, stiffness=1e8, damping=500.0, axial_stiffness=1e8 * (x == 0), support=base(i)
        )
        for i, name in enumerate(names)
        for x in (0.0, 0.4)
    ]
    return gb.RotorSystem(
        [
            gb.Shaft(n, segments=halves, bow=gb.Bow.half_sine(5e-5) if n == "shaft 3" else None)
            for n in names
        ],
        gears,
        meshes,
        bearings,
        [gb.Torque("pinion 0", 20.0), gb.Torque.balance((names[-1], 0.4))],
        housings=housings,
        couplings=[gb.Coupling((names[-2], 0.4), (names[-1], 0.0), torsional_stiffness=1e5)],
        drives=[gb.Drive((names[0], 0.0), stiffness=1e4)],
    )


def test_a_long_train_has_the_elements_that_its_meshes_need():
    """Above 1300 coordinates, the train is examined mesh by mesh."""
    train, longer = long_train(12), long_train(16)
    assert len(train.dofs) > 1300
    choice = train.discretisation
    assert choice.expected_error <= choice.permitted_error
    # Each shaft has the elements that its own meshes need, however long the train is.
    for name in ("shaft 5", "shaft 6"):
        assert choice.shafts[name] == longer.discretisation.shafts[name]
    # The frequency of waves has an error of 1e-3 at the stated limit; the modes are those of half as long elements.
    shafts = []
    for shaft in train.shafts:
        numbers = choice.shafts[shaft.name].numbers
        segments = [
            replace(s, elements=2 * n) for s, n in zip(shaft.segments, numbers, strict=True)
        ]
        shafts.append(replace(shaft, segments=segments, degree=choice.shafts[shaft.name].degree))
    found = train.modes(0.0, count=50).frequencies_hz
    exact = train.replace(shafts=shafts).modes(0.0, count=50).frequencies_hz
    below = (exact > 1.0) & (exact < choice.highest_frequency_hz)
    assert below.sum() > 40
    assert np.abs(found[below] / exact[below] - 1).max() < 1e-3
