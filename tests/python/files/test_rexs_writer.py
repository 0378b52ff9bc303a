"""REXS files that gearbow writes: what is read again is the machine without what the file leaves out."""

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.cli.main import main
from gearbow.exchange.rexs import read_system
from reference.machines import BETWEEN, hostile

#: Machines that REXS cannot hold, with the part that it cannot.
REFUSED = {
    "coaxial_reducer": "housings: REXS cannot hold",
    "compressor_rotor": "sleeves: REXS cannot hold",
    "dual_rotor": r"bearings\[0\].support: REXS has bearings between shafts or in the casing",
    "gearbox": "housings: REXS cannot hold",
    "geared_pair": r"gears\[0\].face_width: REXS needs it",
    "housed_pair": "housings: REXS cannot hold",
    "overhung_rotor": r"bearings\[0\].support: REXS has bearings",
    "star_gear": "housings: REXS cannot hold",
    "turbo_gear": r"bearings\[0\]: REXS cannot hold the film of a journal bearing",
    "tapered_reducer": "housings: REXS cannot hold",
    "wind_turbine": r"meshes\[0\].carrier: REXS cannot hold",
    "turbine_rotor": r"bearings\[0\].support: REXS has bearings",
}
#: Lowest modes that are compared.
COUNT = 8
#: Speed of the modes [rad/s].
SPEED = 100.0


def written(system: gb.RotorSystem, path: Path) -> list[str]:
    """Write a system, and give the fields that the warning names."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        system.save(path)
    texts = [str(each.message).partition("does not contain: ")[2] for each in caught]
    return [field for text in texts for field in text.split(", ")]


def without(description: dict[str, Any], fields: list[str]) -> dict[str, Any]:
    """Leave fields out of a description."""
    found = {key: value for key, value in description.items() if key not in fields}
    for key, value in found.items():
        if isinstance(value, list):
            found[key] = [
                {name: each[name] for name in each if f"{key}.{name}" not in fields}
                for each in value
            ]
    return found


def simple(description: dict[str, Any]) -> gb.RotorSystem:
    """Make a system with one element for each segment, for a test of the file only."""
    shafts = []
    for shaft in description["shafts"]:
        keys = ("length", "outer_diameter", "inner_diameter")
        own = {key: shaft[key] for key in keys if key in shaft}
        segments = [{**each, "elements": 1} for each in shaft.get("segments", [own])]
        shafts.append({**{k: shaft[k] for k in shaft if k not in keys}, "segments": segments})
    return gb.RotorSystem.from_dict({**description, "shafts": shafts})


@pytest.mark.implausible
@pytest.mark.parametrize("name", gb.examples())
def test_a_machine_is_read_again_without_what_the_warning_names(name: str, tmp_path: Path):
    system = gb.examples()[name].load()
    path = tmp_path / f"{name}.rexs"
    if name in REFUSED:
        with pytest.raises(gb.SceneError, match=REFUSED[name]):
            system.save(path)
        assert not path.exists()
        return
    left = written(system, path)
    found, contents = read_system(path, None, None, None)
    assert contents.notes == ()
    expected = without(system.description, left)
    # The file has a drive as the load that takes the torque which the others leave over.
    drives = expected.pop("drives", [])
    balance = [{"at": each["at"], "balance": True} for each in drives]
    expected["torques"] = [*expected.get("torques", []), *balance]
    torsional = system.description.get("motion") == "torsion"
    options = {"motion": "torsion"} if torsional else {}
    modes = [
        simple({**each, **options}).modes(SPEED, count=COUNT).eigenvalues
        for each in (expected, found)
    ]
    # The file has decimal numbers of 17 digits, and angles in degrees.
    scale = np.abs(modes[0]).max()
    np.testing.assert_allclose(modes[1], modes[0], rtol=1e-7, atol=1e-7 * scale)


def test_what_rexs_cannot_hold_is_named(tmp_path: Path):
    shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    table = gb.SpeedTable((0.0, 100.0), (1e8, 2e8))
    other = gb.Bearing("rotor", 1.0, stiffness=1e8)
    system = gb.RotorSystem([shaft], bearings=[gb.Bearing("rotor", 0.0, stiffness=table), other])
    with pytest.raises(gb.SceneError, match=r"bearings\[0\]\.stiffness: REXS cannot hold a table"):
        system.save(tmp_path / "a.rexs")
    damped = gb.Bearing("rotor", 0.0, stiffness=1e8, damping=100.0)
    system = gb.RotorSystem([shaft], bearings=[damped, other])
    assert written(system, tmp_path / "a.rexs") == ["bearings.damping"]
    with pytest.raises(gb.SceneError, match=r"must end with \.toml or \.rexs"):
        system.save(tmp_path / "a.rexsz")


def test_the_command_writes_a_gear_unit(tmp_path: Path):
    given, path = Path(__file__).with_name("gearbox.rexs"), tmp_path / "again.rexs"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(SystemExit) as ended:
            main(["import", str(given), "--bearing", "other=1e8", "--out", str(path)])
        assert ended.value.code == 0
        again, first = gb.read(path), gb.read(given, bearings={"other": 1e8})
    assert [gear.teeth for gear in again.gears] == [gear.teeth for gear in first.gears]


def test_a_stiffness_with_cross_coupling_is_that_of_the_operating_point(tmp_path: Path):
    shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    stiffness = ((1e8, 2e6), (-3e6, 2e8))
    bearings = [gb.Bearing("rotor", at, stiffness=stiffness) for at in (0.1, 0.9)]
    path = tmp_path / "a.rexs"
    gb.RotorSystem([shaft], bearings=bearings).save(path)
    found = gb.RotorSystem.read_rexs(path)
    np.testing.assert_array_equal(found.bearings[1].stiffness, stiffness)
    # A shaft that points the other way, and is turned about its axis by its axis w.
    text = path.read_text()
    first = text.index('type="shaft"')
    u, w = text.index("u_axis_vector", first), text.index("w_axis_vector", first)
    assert first < u < w
    turned = text[:w] + text[w:].replace("<c>1.0</c>", "<c>-1.0</c>", 1)
    path.write_text(turned)
    found = gb.RotorSystem.read_rexs(path)
    # Both axes of the reference shaft turn with it.
    np.testing.assert_allclose(found.bearings[1].stiffness, stiffness, rtol=1e-12)


def test_loads_are_read_again(tmp_path: Path):
    # the default machine with bearings on the ground that are equal at all speeds
    train = hostile()
    iron = gb.Material(1.7e11, 7300.0, shear_modulus=6.5e10)
    shafts = [replace(one, material=iron) if one.name == "middle" else one for one in train.shafts]
    plain = {"stiffness": 1.2e8, "damping": 0.0, "support": None}
    *others, table, between = train.bearings
    bearings = [*others, replace(table, **plain), replace(between, **plain)]
    forces = [gb.Force("g4", 300.0 - 500.0j, axial=-120.0), gb.Force(BETWEEN, 40.0 + 70.0j)]
    system = train.replace(shafts=shafts, bearings=bearings, forces=forces)
    path = tmp_path / "loads.rexs"
    left = written(system, path)
    assert "forces" not in {field.partition(".")[0] for field in left}
    again = gb.read(path)
    given, read = (
        {(one.value.real, one.value.imag, one.axial) for one in each.forces}
        for each in (system, again)
    )
    assert read == given
    speed = -SPEED
    expected, found = (each.static(speed) for each in (system, again))
    for bearing in system.bearings:
        at = (bearing.shaft, bearing.position)
        # decimal numbers of 17 digits, and an equilibrium that is found to 1e-6 of the loads
        np.testing.assert_allclose(found.bearing_force(at), expected.bearing_force(at), rtol=1e-5)
