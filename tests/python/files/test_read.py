"""One function, and all commands, for every file that contains a system."""

from __future__ import annotations

import json
import os
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from gearbow.cli.main import _parser, main
from reference.cases import each_case
from reference.machines import inertia, rotor

REXS = Path(__file__).with_name("gearbox.rexs")
GIVEN = {"load_case": 1, "bearings": {"other": 1e8}}
OPTIONS = ("--load-case", "1", "--bearing", "other=1e8")
SCENE = """[[shafts]]
name = "rotor"
length = "40 in"
outer_diameter = "2 in"
elements = 4
[[bearings]]
shaft = "rotor"
position = "0 in"
stiffness = "8e4 lbf/in"
damping = "580 lbf-s/in"
[[bearings]]
shaft = "rotor"
position = "40 in"
stiffness = "8e4 lbf/in"
"""
ELEMENT = {"n": 0, "L": 0.5, "idl": 0.0, "odl": 0.05, "idr": 0.0, "odr": 0.05, "tag": "a"}
ELEMENT |= {"material": {"name": "Steel", "rho": 7810.0, "E": 2.11e11, "G_s": 8.12e10}}
BEARINGS = {
    f"BearingElement_{n}": {"n": n, "kxx": [1e7], "cxx": [100.0], "frequency": None, "tag": str(n)}
    for n in (0, 1)
}
ROSS = {"ross_version": "2.3.0", "parameters": {}, "ShaftElement_a": ELEMENT, **BEARINGS}

pytestmark = pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    """Write one file of each kind, some with the ending of another one."""
    found = {name: tmp_path / name for name in ("a.toml", "b.txt", "c.json", "d.rotor", "e.rexsz")}
    found["a.toml"].write_text(SCENE)
    found["b.txt"].write_text("\ufeff" + SCENE, encoding="utf-8")
    found["c.json"].write_text(json.dumps(ROSS))
    found["d.rotor"].write_text(json.dumps(ROSS, indent=1))
    with zipfile.ZipFile(found["e.rexsz"], "w") as archive:
        archive.write(REXS, "gearbox.rexs")
    return {**found, "f.rexs": REXS}


def test_every_file_is_read_by_its_contents(files: dict[str, Path]):
    load, ross, rexs = (
        getattr(gb.RotorSystem, name) for name in ("load", "from_ross", "read_rexs")
    )
    for name in ("a.toml", "b.txt"):
        assert gb.read(files[name]).description == load(files["a.toml"]).description
    for name in ("c.json", "d.rotor"):
        assert gb.read(files[name]).description == ross(files["c.json"]).description
    for name in ("e.rexsz", "f.rexs"):
        assert gb.read(files[name], **GIVEN).description == rexs(REXS, **GIVEN).description


def test_units_of_the_workshop_in_a_scene(files: dict[str, Path]):
    bearing = gb.read(files["a.toml"]).bearings[0]
    assert bearing.stiffness == pytest.approx(8e4 * 4.4482216152605 / 0.0254, rel=1e-15)
    assert bearing.damping == pytest.approx(580 * 4.4482216152605 / 0.0254, rel=1e-15)


@each_case(
    ("name", "options", "message"),
    [
        ("a.toml", {"load_case": 1}, "load_case: is for a REXS file, but {} is a scene file"),
        ("c.json", {"bearings": {}}, "bearings: is for a REXS file, but {} is a rotor of ROSS"),
        ("f.rexs", {"meshes": []}, "meshes: is for a rotor of ROSS, but {} is a REXS file"),
        (
            "f.rexs",
            {"loadcase": 1},
            "options: must be one of load_case, bearings, couplings, meshes, got 'loadcase'; did you",
        ),
    ],
)
def test_an_option_that_a_file_cannot_use_is_an_error(files, name, options, message):
    with pytest.raises(gb.SceneError, match=re.escape(message.format(files[name]))):
        gb.read(files[name], **options)


@each_case(
    ("name", "content"),
    [
        ("a.csv", b"speed;k\n1;2\n"),
        ("a.npz", b"PK\3\4"),
        ("a.json", b'{"shafts": []}'),
        ("a.txt", b""),
        ("a.bin", b"\0\1\2"),
    ],
)
def test_a_file_of_another_kind_is_an_error(tmp_path: Path, name: str, content: bytes):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(gb.SceneError, match=f"^{re.escape(str(path))}: is no system that gearbow"):
        gb.read(path)
    with pytest.raises(FileNotFoundError):
        gb.read(tmp_path / "nothing.toml")


# --- commands -------------------------------------------------------------------------------------


def called(capsys, *arguments: str) -> tuple[int, str, str]:
    """Call the program."""
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    return (ended.value.code, *capsys.readouterr())


def test_commands_read_files_of_other_programs(files, capsys):
    for name, options in (("c.json", ()), ("e.rexsz", OPTIONS), ("a.toml", ())):
        code, out, err = called(
            capsys, "modes", str(files[name]), *options, "--count", "3", "--json"
        )
        assert code == 0, err
        system = gb.read(files[name], **(GIVEN if options else {}))
        found = [mode["frequency_hz"] for mode in json.loads(out)["modes"]]
        # two computations of the same eigenvalues; rigid-body modes are zero
        assert found == pytest.approx(system.modes(count=3).frequencies_hz, rel=1e-9, abs=1e-9)


def test_every_command_of_a_system_has_its_options():
    """A command that takes a scene takes the options of all files."""
    commands = next(iter(_parser()._subparsers._group_actions)).choices
    takes = [
        {action.dest for action in command._actions}
        for command in commands.values()
        if any(action.dest == "scene" for action in command._actions)
    ]
    assert len(takes) >= 12
    for found in takes:
        assert {"load_case", "bearing", "coupling", "mesh", "centre_line_angle", "json"} <= found


@each_case(
    ("arguments", "message"),
    [
        (["modes", "a.toml", "--load-case", "1"], "--load-case: is for a REXS file, but"),
        (["import", "c.json", "--list"], "--list: is for a REXS file, but"),
        (
            ["check", "f.rexs", "--load-case", "9"],
            "see gearbow import --list, and the options --load-case, --bearing",
        ),
        (
            ["plot", "run.npz", "--bearing", "a=1"],
            "--bearing: is for a system, but run.npz is a run",
        ),
    ],
)
def test_a_command_refuses_what_a_file_cannot_use(files, capsys, arguments, message: str):
    arguments = [str(files.get(argument, argument)) for argument in arguments]
    code, _, err = called(capsys, *arguments)
    assert code == 2
    assert message in err


def test_the_given_files_are_read(tmp_path: Path):
    folder = os.environ.get("GEARBOW_TEST_DATA")
    if folder is None:
        pytest.skip("GEARBOW_TEST_DATA does not name the folder of the given files")
    cases = Path(folder, "cases")
    for name in ("rexs_mac_archive.rexsz", "gearbox.rexs.zip"):
        assert gb.read(cases / name, bearings={"other": 1e8}).shafts
    old = gb.read(cases / "ross1_file.toml")
    text = (cases / "ross1_file.toml").read_text(encoding="utf-8")
    (tmp_path / "new.toml").write_text(f'ross_version = "2.0.0"\n{text}', encoding="utf-8")
    np.testing.assert_array_equal(
        old.modes(count=6).frequencies_hz,
        gb.read(tmp_path / "new.toml").modes(count=6).frequencies_hz,
    )
    # The rigid coupling is 1e12 N/m instead of 1e15 N/m, in series with 1e7 N/m.
    for name in ("rexs_rigid_coupling", "rexs_stiff_coupling"):
        train = gb.read(cases / f"{name}.rexs", couplings={"flange": 1e9})
        found = train.modes(count=6).frequencies_hz
        assert found[1:5] == pytest.approx([354.99, 354.99, 647.57, 647.57], rel=2e-5)
    cone, plain = gb.read(cases / "rexs_cone.rexs", couplings={"flange": 1e9}).shafts
    assert (cone.segments[0].outer_diameter, cone.segments[0].end_outer_diameter) == (0.05, 0.04)
    assert plain.segments[0].end_outer_diameter is None


def test_the_given_roving_hammer_is_the_response_of_its_rotor():
    folder = os.environ.get("GEARBOW_TEST_DATA")
    if folder is None:
        pytest.skip("GEARBOW_TEST_DATA does not name the folder of the given files")
    disk, bearing = inertia(10.0, 0.05, 0.1, position=0.3), {"stiffness": 1e7, "damping": 500.0}
    system = rotor({"elements": None}, disk, bearing)
    places = {1: ("rotor", 0.3), 2: ("rotor", 0.7)}
    force = gb.Force(places[1], 1j)
    response = system.frequency_response([10.0, 20.0], source=force, speed=0.0)
    found = response.compare(Path(folder, "cases", "roving.uff"), places=places)
    assert found.frac == pytest.approx([1.0, 1.0], abs=1e-6)
    for measured, computed in zip(found.measured, found.computed, strict=True):
        # The phase of what both have in common; the elements of the file are not known.
        assert abs(np.angle(np.vdot(computed, measured.values))) < 1e-3
