"""Typical mistakes of new users: every message says where, what, and how to correct it."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import gearbow as gb
from reference.cases import each_case
from reference.machines import SHAFTS, pair
from reference.processes import python


def system(**changes: Any) -> gb.RotorSystem:
    return pair(SHAFTS, ("pinion", "wheel"), shaft={"elements": 4}, **changes)


def with_shaft(**changes: Any) -> gb.RotorSystem:
    first, second = system().shafts
    return system(shafts=[replace(first, **changes), second])


def with_gears(**changes: Any) -> gb.RotorSystem:
    return system(gears=[replace(gear, **changes) for gear in system().gears])


def with_wheel(**changes: Any) -> gb.RotorSystem:
    pinion, wheel = system().gears
    return system(gears=[pinion, replace(wheel, **changes)])


def run(duration: float = 1e-3, speed: Any = 100.0, **options: Any) -> gb.Response:
    return system().simulate(duration, speed, **options)


#: What the user does; where the message points; the value it shows; the remedy it names.
MISTAKES: dict[str, tuple[Callable[[], object], str, str, str]] = {
    "a length in millimetres": (
        lambda: with_shaft(length=500, outer_diameter=50),
        "shafts[0].length: ",
        "500 m",
        "is it in millimetres?",
    ),
    "a module in millimetres": (
        lambda: with_gears(module=3),
        "gears[0].module: ",
        "3 m",
        "is it in millimetres?",
    ),
    "a position in millimetres": (
        lambda: system(bearings=[gb.Bearing("input", 250, stiffness=1e8)]),
        "bearings[0].position: ",
        "250 m is outside",
        "positions begin with 0 at its left end; is it in millimetres?",
    ),
    "a speed in rpm": (lambda: run(speed=15000), "speed: ", "15000 rad/s", "is the speed in rpm?"),
    "an angle in degrees": (
        lambda: with_gears(pressure_angle=20),
        "gears[0].pressure_angle: ",
        "got 20",
        "is it in degrees?",
    ),
    "a phase in degrees": (
        lambda: with_shaft(bow=gb.Bow.half_sine(1e-4, phase=90)),
        "shafts[0].bow.phase: ",
        "90 rad",
        "is it in degrees?",
    ),
    "a stiffness in N/mm": (
        lambda: system(bearings=[replace(b, stiffness=1e5) for b in system().bearings]),
        "bearings[0].stiffness: ",
        "100000 N/m",
        "is it in N/mm?",
    ),
    "a misspelt shaft": (
        lambda: with_wheel(shaft="outptu"),
        "gears[1].shaft: ",
        '"outptu"',
        'did you mean "output"?',
    ),
    "a misspelt gear": (
        lambda: system(meshes=[gb.Mesh("pinoin", "wheel", stiffness=2e8)]),
        "meshes[0].driver: ",
        '"pinoin"',
        'did you mean "pinion"?',
    ),
    "a misspelt keyword of a part": (
        lambda: gb.Shaft("input", lenght=0.5, outer_diameter=0.05),  # type: ignore[call-arg]
        "Shaft: ",
        "lenght=0.5",
        'did you mean "length"?',
    ),
    "a misspelt keyword of the system": (
        lambda: gb.RotorSystem([], bearing=[]),  # type: ignore[call-arg]
        "RotorSystem: ",
        "bearing=[]",
        'did you mean "bearings"?',
    ),
    "a misspelt keyword of an analysis": (
        lambda: system().simulate(0.1, sped=100.0),  # type: ignore[call-arg]
        "simulate: ",
        "sped=100.0",
        'did you mean "speed"?',
    ),
    "a misspelt keyword of a figure": (
        lambda: system().modes().plot(cuont=3),  # type: ignore[call-arg]
        "plot: ",
        "cuont=3",
        'did you mean "count"?',
    ),
    "a misspelt keyword of a bow": (
        lambda: gb.Bow.half_sine(1e-4, fase=0.5),  # type: ignore[call-arg]
        "half_sine: ",
        "fase=0.5",
        'did you mean "phase"?',
    ),
    "a misspelt keyword of a sweep": (
        lambda: gb.sweep(run, parameter={"speed": [100.0]}),  # type: ignore[call-arg]
        "sweep: ",
        "parameter={'speed': [100.0]}",
        'did you mean "parameters"?',
    ),
    "a list in place of a number": (
        lambda: with_shaft(length=[0.5]),
        "shafts[0].length: ",
        "got [0.5]",
        "write 0.5 without brackets",
    ),
    "a number as text": (
        lambda: with_shaft(length="0.5"),
        "shafts[0].length: ",
        "got '0.5'",
        "write 0.5 without quotes [m]",
    ),
    "a number with a unit as text": (
        lambda: with_shaft(length="500 mm"),
        "shafts[0].length: ",
        "got '500 mm'",
        "write 0.5 without quotes [m], or gb.mm(500)",
    ),
    "one part in place of a list": (
        lambda: system(shafts=system().shafts[0]),
        "shafts: ",
        "got Shaft(name='input'",
        "put it in brackets",
    ),
    "no balancing torque": (
        lambda: system(torques=[gb.Torque("pinion", 250.0)]).static(),
        "torques: ",
        "250 N m",
        "add gb.Torque.balance(at) where the load acts",
    ),
    "both gears on one shaft": (
        lambda: with_wheel(shaft="input", position=0.4),
        "meshes[0]: ",
        '"pinion" and "wheel" sit on the same shaft, "input"',
        "change the shaft of one gear",
    ),
    "a mesh by one gear": (
        lambda: run().mesh("wheel"),
        "at: ",
        "'wheel'",
        'must be (driver, driven) or "driver/driven"',
    ),
    "gears of different modules": (
        lambda: with_wheel(module=4e-3),
        "meshes[0]: ",
        '"pinion" has module 0.003 m, "wheel" 0.004 m',
        "give both the same module",
    ),
    "a negative length": (
        lambda: with_shaft(length=-0.5),
        "shafts[0].length: ",
        "got -0.5",
        "must be positive",
    ),
    "a position outside the shaft": (
        lambda: with_wheel(position=0.7),
        "gears[1].position: ",
        '0.7 m is outside the shaft "output", which is 0.5 m long',
        "positions begin with 0 at its left end",
    ),
    "a shaft without a bearing": (
        lambda: system(bearings=system().bearings[:2]).static(),
        "shafts[1]: ",
        '"output" is unconstrained: no bearing holds it',
        'add gb.Bearing("output", position, stiffness=...)',
    ),
    "a speed that ends before the run": (
        lambda: run(2e-3, ([0.0, 1e-3], [100.0, 110.0])),
        "speed: ",
        "the last time is 0.001 s, but the run ends at 0.002 s",
        "Give times up to the end of the run",
    ),
    "a misspelt recorded name": (
        lambda: run(record=["pinoin"]),
        "record[0]: ",
        '"pinoin"',
        'did you mean "pinion"?',
    ),
    "a recorded position in millimetres": (
        lambda: run(record=[("input", 120.0)]),
        "record[0]: ",
        'shaft "input" reaches from 0 to 0.5 m',
        "give a position on it in metres, got 120 m",
    ),
    "a signal that was not recorded": (
        lambda: run(record=["pinion"]).displacement("wheel"),
        "the motion of 'wheel' was not recorded",
        "recorded: 'pinion'",
        "give record=['wheel', ...] to simulate",
    ),
    "positions of a bow in millimetres": (
        lambda: with_shaft(bow=gb.Bow.points([0, 250, 500], [0, 9e-5, 0])),
        "shafts[0].bow.positions[1]: ",
        "250 m is outside the shaft",
        "is it in millimetres?",
    ),
    "a bow whose points end far from the ends": (
        lambda: with_shaft(bow=gb.Bow.points([0.2, 0.25, 0.3], [0, 9e-5, 0])),
        "shafts[0].bow.positions: ",
        "deflects the end of the shaft at 0 m by 7.2e-4 m",
        "add points up to the ends of the shaft",
    ),
    "a torque on a shaft": (
        lambda: system(torques=[gb.Torque("input", 250.0), gb.Torque.balance("wheel")]),
        "torques[0].at: ",
        'no gear or disk is called "input"',
        'write ("input", x) with the position x on it',
    ),
    "a mesh of shafts": (
        lambda: system(meshes=[gb.Mesh("input", "output")]),
        "meshes[0].driver: ",
        'no gear is called "input"',
        'it is a shaft, and a mesh needs one of its gears: "pinion"',
    ),
    "a load torque of the wrong sign": (
        lambda: system(
            torques=[gb.Torque("pinion", 250.0), gb.Torque("wheel", -500.0 / 3.0)]
        ).static(),
        "torques: ",
        "is 333.3 N m;",
        "torques of driver and load of one gear pair have the same sign",
    ),
    "a steady state without a balancing torque": (
        lambda: system(torques=[gb.Torque("pinion", 250.0)]).steady_state(100.0),
        "torques: ",
        "250 N m",
        "add gb.Torque.balance(at) where the load acts",
    ),
    "a recorded group in the singular": (
        lambda: run(record=["mesh"]),
        "record[0]: ",
        '"mesh" is no gear',
        'did you mean "meshes"?',
    ),
    "the acceleration of a bearing on the ground": (
        lambda: run(record=["bearings", "acceleration"]),
        "record: ",
        '"acceleration" is that of the recorded places, and a bearing is none',
        "add the name of its support, or (shaft, position)",
    ),
    "a module with the name of another program": (
        lambda: gb.Gear("pinion", "input", 0.25, modul=3e-3, teeth=25),  # type: ignore[call-arg]
        "Gear: ",
        "modul=0.003",
        'did you mean "module"?',
    ),
    "a number of teeth with the symbol of textbooks": (
        lambda: gb.Gear("pinion", "input", 0.25, z=25, module=3e-3),  # type: ignore[call-arg]
        "Gear: ",
        "z=25",
        'did you mean "teeth"?',
    ),
    "orders of a signal that has other frequencies": (
        lambda: (
            system(meshes=[gb.Mesh("pinion", "wheel", stiffness=gb.Stiffness.square(2e8))])
            .simulate(0.3, 100.0, output_step=1e-4, record=["meshes"])
            .orders(("pinion", "wheel"), shaft_harmonics=1, mesh_harmonics=0, skip_time=0.05)
        ),
        "orders: ",
        "% of the RMS of pinion/wheel force is not at these orders",
        "omit a transient with skip_time, or give more",
    ),
    "times of a figure that are not in the record": (
        lambda: run().plot("mesh", times=(0.0, 1.0)),
        "times: ",
        "got (0.0, 1.0)",
        "must ascend within the record, 0 s to 0.001 s",
    ),
    "two parts of one name": (
        lambda: with_gears(name="gear"),
        "gears[1].name: ",
        'gears[0] has the name "gear" too',
        "names must be unique",
    ),
}


@each_case("mistake", MISTAKES)
def test_a_message_says_where_what_and_how_to_correct_it(mistake: str):
    make, where, value, remedy = MISTAKES[mistake]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            make()
        except (gb.GearbowError, TypeError) as error:
            messages = [str(error)]
        else:
            messages = [str(warning.message) for warning in caught]
    (text,) = [message for message in messages if message.startswith(where)][:1] or messages[:1]
    assert text.startswith(where)
    assert value in text
    assert remedy in text
    assert "\n" not in text


SHAFT = """
[[shafts]]
name = "input"
length = 0.5
outer_diameter = 0.05
elements = 4
"""


@each_case(
    ("old", "new", "expected"),
    [
        ("length", "lenght", ("shafts[0].lenght: ", "lenght = 0.5", 'did you mean "length"?')),
        ("[[shafts]]", "[[shaft]]", ("shaft: ", "[[shaft]]", 'did you mean "shafts"?')),
        ("[[shafts]]", "[shafts]", ("shafts: ", "[shafts]", "[[shafts]]")),
        (
            "elements = 4",
            "elements = 4\n[gears]\nname = 'g'",
            ("gears: ", "[gears]", "write two brackets around the name of a list: [[gears]]"),
        ),
        (
            "elements = 4",
            "elements = 4\n[gears]\nname = 'a'\n[gears]\nname = 'b'",
            ("toml: ", "[gears]", "write two brackets around each name of a list: [[gears]]"),
        ),
        (
            "elements = 4",
            "elements = 4\n[gears]\nname = 'a'\n[[gears]]\nname = 'b'",
            ("toml: ", "[[gears]]", "write two brackets around each name of a list: [[gears]]"),
        ),
        (
            "[[shafts]]",
            "gears = ['g']\n[[shafts]]",
            ("gears[0]: ", '"g"', "expected entries with names; write [[gears]]"),
        ),
        (
            "elements = 4",
            "elements = 4\n[shafts.segments]\nlength = 0.5",
            ("shafts[0].segments: ", "[shafts.segments]", "[[shafts.segments]]"),
        ),
        ("0.5", '"0.5"', ("shafts[0].length: ", "'0.5'", "without quotes [m]")),
        ("0.5", '"500"', ("shafts[0].length: ", "'500'", 'such as "500 m"')),
        ("= 4", '= "4"', ("shafts[0].elements: ", 'elements = "4"', "a number without quotes")),
        ("0.5", '"500 mN"', ("shafts[0].length: ", "'500 mN'", "a unit that converts to m")),
        ("0.5", "-0.5", ("shafts[0].length: ", "got -0.5", "must be positive")),
    ],
)
def test_a_message_about_a_file(tmp_path: Path, old, new, expected):
    where, value, remedy = expected
    path = tmp_path / "scene.toml"
    assert old in SHAFT
    path.write_text(SHAFT.replace(old, new, 1))
    with pytest.raises(gb.SceneError) as caught:
        gb.RotorSystem.load(path)
    text = str(caught.value)
    assert text.startswith(where)
    assert value in text
    assert remedy in text


@each_case(
    ("path", "value", "expected"),
    [
        (("rayleigh",), [1.0], "rayleigh: invalid length 1, expected a pair [alpha, beta]"),
        (
            ("housings", 0, "inertia"),
            [1.0, 2.0],
            "housings[0].inertia: invalid length 2, expected 3 numbers [x, y, z]",
        ),
        (
            ("housings", 0, "points"),
            {"stiffness": [1.0]},
            "housings[0].points.stiffness: invalid length 1, expected 3 numbers [x, y, z]",
        ),
        (
            ("bearings", 0, "grooves"),
            [[1.0]],
            "bearings[0].grooves[0]: invalid length 1, expected a pair [angle of the middle, extent]",
        ),
        (
            ("torques", 0),
            "g1",
            'torques[0]: invalid type: string "g1", expected entries with names; write [[torques]]',
        ),
    ],
)
def test_a_message_says_what_the_entries_are(path, value, expected):
    description = system().description | {
        "housings": [{"name": "case", "mass": 1.0, "stiffness": 1e6}]
    }
    *owners, last = path
    owner = description
    for key in owners:
        owner = owner[key]
    owner[last] = value
    with pytest.raises(gb.SceneError) as caught:
        gb.RotorSystem.from_dict(description)
    assert str(caught.value).startswith(expected)


def test_a_missing_extra():
    code = (
        "import sys\n"
        "sys.modules['matplotlib'] = None\n"
        "import gearbow as gb\n"
        "shaft = gb.Shaft('a', length=1.0, outer_diameter=0.05, elements=2)\n"
        "bearings = [gb.Bearing('a', x, stiffness=1e8) for x in (0.0, 1.0)]\n"
        "try:\n"
        "    gb.RotorSystem([shaft], bearings=bearings).modes().plot()\n"
        "except gb.MissingExtraError as error:\n"
        "    print(error)\n"
    )
    ended = python(code)
    assert (
        ended.stdout
        == 'matplotlib: is not installed; install it with: pip install "gearbow[plot]"\n'
    ), ended.stderr


def test_a_keyword_keeps_its_place_in_signatures_and_copies():
    import copy
    import inspect
    import pickle

    assert list(inspect.signature(gb.Torque).parameters) == ["at", "value"]
    assert "shafts" in inspect.signature(gb.RotorSystem).parameters
    shaft = gb.Shaft("input", length=0.5, outer_diameter=0.05)
    assert pickle.loads(pickle.dumps(shaft)) == copy.deepcopy(shaft) == shaft

    class Own(gb.RotorSystem):
        def __init__(self, *args, label, **options):
            super().__init__(*args, **options)
            self.label = label

    assert Own([shaft], label="mine", gravity=9.81).gravity == 9.81


def test_every_result_names_the_parameters_of_its_methods():
    # `displacement` and `plot` are inherited by several results
    machine = system()
    for found in (machine.modes(), machine.static(), machine.synchronous([9.0]), run()):
        with pytest.raises(TypeError, match=r"displacement: has no parameter 'place', .* are at$"):
            found.displacement(place="pinion")
    with pytest.raises(TypeError, match=r'plot: has no parameter .*; did you mean "speed_unit"'):
        machine.static().plot(speed_units="rpm")


def test_a_warning_of_the_core_points_to_the_line_of_the_user():
    stiffness = [[3e7, 2e7], [-2e7, 3e7]]
    bearings = [gb.Bearing("s", x, stiffness=stiffness, damping=2e3) for x in (0.0, 1.0)]
    shaft = gb.Shaft("s", length=1.0, outer_diameter=0.05, bow=gb.Bow.half_sine(1e-4))
    with pytest.warns(gb.AccuracyWarning, match="unstable") as caught:
        gb.RotorSystem([shaft], bearings=bearings).synchronous([400.0])
    assert [one.filename for one in caught] == [__file__]


def test_the_warning_of_a_speed_points_to_the_line_of_the_user():
    with pytest.warns(gb.SceneWarning, match="the last time is") as caught:
        run(2e-3, ([0.0, 1e-3], [100.0, 110.0]))
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(2e-3, gb.SpeedProfile.table([0.0, 1e-3], [100.0, 110.0]))
        # a sum of times has round-off
        for end in (2e-3, math.nextafter(2e-3, 1.0)):
            run(end, ([0.0, 2e-3], [100.0, 110.0]))


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "data": (lambda: gb.Response(3, 1), "data: must be the data of a run, got 3"),
    "no run": (lambda: gb.waterfall([], "g1"), "responses: must be a list of at least one"),
    "no responses": (lambda: gb.waterfall(3, "g1"), "responses: must be a list of at least one"),
    "orders": (
        lambda: run().orders("pinion", shaft_harmonics=2**70),
        "shaft_harmonics: must be at most 1000, got 1180591620717411303424",
    ),
    "modes": (lambda: system().modes(count=2**63), "count: must be at most 4294967295, got"),
    "harmonics": (
        lambda: system().campbell([1.0, 2.0], harmonics=2**62),
        "harmonics: must be at most 4294967295, got",
    ),
    "truth": (
        lambda: system().tradeoff(1e-3, 100.0, budget=1.0, frozen="no"),
        "frozen: must be True or False, got 'no'",
    ),
    "bytes": (
        lambda: system().synchronous(memoryview(b"abc")),
        "speeds: must be a number, got <memory",
    ),
    "capital letters": (
        lambda: gb.SpeedProfile.ramp("1500 RPM", 0.0, 1.0),
        "must be a number, got '1500 RPM'; did you mean \"rpm\"? Capital and small letters differ",
    ),
    "a text of a function": (
        lambda: gb.SpeedProfile.function(lambda _: "1", 1.0),
        "speed: the function must give a number, got '1'",
    ),
    "a complex number of a function": (
        lambda: gb.SpeedProfile.function(lambda t: 1j * t, 1.0),
        "speed: the function must give a number, got 0j",
    ),
    "a large number of a function": (
        lambda: gb.SpeedProfile.function(lambda _: 10**400, 1.0),
        "speed: the function must give a number, got 1000",
    ),
    "no number of a function": (
        lambda: system(torques=[gb.Torque("pinion", lambda _: None)]).simulate(1e-3, 100.0),
        "torques[0].value: the function must give a number, got None",
    ),
    "a mapping": (
        lambda: run(record={"pinion": 1}),
        "record: must be a list of names or tuples, got {'pinion': 1}",
    ),
    "bytes of names": (
        lambda: run(record=b"p"),
        "record: must be a list of names or tuples, got b'p'",
    ),
    "planes": (
        lambda: system().balance({"pinion": 1}, 100.0),
        "planes: must be a list of names or tuples, got {'pinion': 1}",
    ),
    "a class of executors": (
        lambda: system().simulate_many([{}], 1e-3, 100.0, executor=ThreadPoolExecutor),  # type: ignore[arg-type]
        "executor: must be an executor of concurrent.futures, or None for threads, got <class",
    ),
    "a key": (
        lambda: gb.RotorSystem.from_dict({5: 5}),  # type: ignore[dict-item]
        "description: the key: must be text, got 5",
    ),
    "three stiffnesses": (
        lambda: system(bearings=[gb.Bearing("input", 0.0, stiffness=[1.0, 2.0, 3.0])]),
        "[[yy, yz], [zy, zz]], got [1.0, 2.0, 3.0]",
    ),
    "a gravity of three": (
        lambda: system().replace(gravity=[0.0, 0.0, 9.81]),
        "gravity: expected a number [m/s²] or a pair [y, z], got [0.0, 0.0, 9.81]",
    ),
    "many elements": (
        lambda: with_shaft(elements=2**70),
        "shafts[0].elements: must be smaller, got 1180591620717411300000",
    ),
    "a file": (lambda: gb.RotorSystem.load("a\0b"), "path: must be the name of a file, got 'a"),
    "no file": (lambda: gb.Response.load(None), "path: must be the name of a file, got None"),
}


@each_case("case", REFUSED)
def test_a_value_of_another_kind_is_refused(case: str):
    call, message = REFUSED[case]
    with pytest.raises(gb.SceneError) as caught:
        call()
    assert message in str(caught.value)


def test_a_place_that_is_none_is_refused():
    message = r"^at: must be a name or \(shaft, position\), got \('input', 'a', 'b'\)"
    with pytest.raises(gb.SceneError, match=message):
        run(record=["pinion"]).displacement(("input", "a", "b"))  # type: ignore[arg-type]


def test_a_name_with_nul_is_refused_in_descriptions_and_files(tmp_path: Path):
    description = system().description
    description["shafts"][0]["name"] = "in\0put"
    message = r"^shafts\[0\]\.name: must not contain the character NUL"
    with pytest.raises(gb.SceneError, match=message):
        gb.RotorSystem.from_dict(description)
    path = tmp_path / "scene.toml"
    system().save(path)
    name = system().shafts[0].name
    path.write_text(path.read_text().replace(f'"{name}"', f'"{name}\\u0000"'))
    with pytest.raises(gb.SceneError, match=message):
        gb.RotorSystem.load(path)
