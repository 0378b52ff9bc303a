"""Rotors of ROSS with several shafts, against eigenvalues that ROSS 2.3 gives for the same elements."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from gearbow.cli.main import main

#: Eigenvalues of `CoAxialRotor` and `MultiRotor` by the speed [rad/s], from K, M, C and G of ROSS, by size.
COAXIAL = {
    0.0: [
        complex(-3.296185642, 1007.2832682),
        complex(-3.100644397, 1064.3513765),
        complex(-12.685986871, 1715.9794699),
        complex(-13.932424479, 1949.1281548),
        complex(42.220119792, 2864.6520114),
        complex(-121.525804941, 2864.8961451),
        complex(-38.656493761, 3697.3731995),
        complex(-36.984907485, 3885.7433943),
    ],
    600.0: [
        complex(-8.589256763, 934.5611316),
        complex(1.076861038, 1126.2190714),
        complex(-13.97467263, 1712.6826189),
        complex(-8.259455264, 1948.7091744),
        complex(-120.626315098, 2614.3357457),
        complex(34.172937427, 3194.5822018),
        complex(-44.135646044, 3504.5336874),
        complex(-25.797713859, 4098.3413245),
    ],
}
GEARED = {
    0.0: [
        complex(-1.854949544, 1281.2792843),
        complex(-1.034909484, 1378.1720181),
        complex(-8.137372624, 2056.8726547),
        complex(-24.177035088, 3237.2799663),
        complex(-15.284857724, 3532.4886055),
        complex(-21.420081605, 3757.7550654),
        complex(-8.588399613, 5095.0774708),
        complex(-11.235508048, 6182.1120072),
    ],
    600.0: [
        complex(-1.220511448, 1200.3444365),
        complex(-1.754350891, 1451.8479256),
        complex(-8.239454915, 2056.969567),
        complex(-24.08170898, 3222.0470039),
        complex(-15.603085489, 3525.3760312),
        complex(-21.324058375, 3759.099705),
        complex(-8.966823153, 5060.5327823),
        complex(-7.95759299, 5805.5080909),
    ],
}
#: Largest relative difference: the elements are the same, and only rounding differs (measured: 1e-9).
DIFFERENCE = 1e-8
PRESSURE_ANGLE = math.radians(20.0)


def shaft(nodes: range, outer: float, inner: float = 0.0) -> dict[str, dict]:
    material = {"name": "steel", "rho": 7810.0, "E": 211e9, "G_s": 81.2e9}
    sizes = {"L": 0.1, "idl": inner, "idr": inner, "odl": outer, "odr": outer}
    return {f"ShaftElement_{n}": {"n": n, **sizes, "material": material} for n in nodes}


def bearing(n: int, kxx: float, damping: float, **given) -> dict[str, dict]:
    """Give a bearing as ROSS saves it, with lists of one value and equal damping along x and y."""
    values = {"kxx": kxx, "kyy": given.get("kyy", kxx), "kxy": 0.0, "kyx": 0.0}
    listed = {key: [given.pop(key, value)] for key, value in values.items()}
    coefficients = {**listed, "cxx": [damping], "cyy": [damping], "mxx": [0], "kzz": [0]}
    return {f"BearingElement_{n}": {"n": n, "tag": f"bearing {n}", **coefficients, **given}}


def disk(n: int, mass: float, diametral: float, polar: float, tag: str) -> dict[str, dict]:
    return {f"DiskElement_{tag}": {"n": n, "m": mass, "Id": diametral, "Ip": polar, "tag": tag}}


def gear(n: int, mass: float, diametral: float, teeth: int, tag: str, **given) -> dict[str, dict]:
    body = {"m": mass, "Id": diametral, "Ip": 1.8 * diametral, "material": None}
    pitch = 3e-3 * teeth
    diameters = {"pitch_diameter": pitch, "base_diameter": pitch * math.cos(PRESSURE_ANGLE)}
    angles = {"pr_angle": PRESSURE_ANGLE, "helix_angle": 0}
    values = {"n": n, **body, "n_teeth": teeth, **diameters, **angles, "tag": tag, **given}
    return {f"GearElement_{tag}": values}


def pedestal(n: int) -> dict[str, dict]:
    return {f"PointMass_{n}": {"n": n, "m": 2.0, "mx": 2.0, "my": 2.0, "tag": f"pedestal {n}"}}


def coaxial_rotor() -> dict[str, dict]:
    """Give an inner shaft with the nodes 0 to 4, an outer one with 5 to 7, and a pedestal 8."""
    return {
        **shaft(range(4), 0.04),
        **shaft(range(5, 7), 0.12, 0.1),
        **disk(1, 5.0, 0.02, 0.03, "fan"),
        **disk(6, 8.0, 0.05, 0.09, "drum"),
        **bearing(0, 2e7, 300.0, n_link=8),
        **bearing(3, 1e7, 100.0, kyy=2e7, kxy=1e6, n_link=7),
        **bearing(4, 3e7, 200.0, kyy=2e7),
        **bearing(5, 4e7, 400.0, kxy=2e6, kyx=-3e6),
        **bearing(8, 1e8, 50.0),
        **pedestal(8),
    }


def geared_rotors(**of_gear) -> dict[str, dict]:
    """Give a driving rotor with the nodes 0 to 2, a driven one with 3 to 6, and a pedestal 7."""
    return {
        **shaft(range(2), 0.04),
        **shaft(range(3, 6), 0.03),
        **gear(1, 3.0, 0.004, 40, "wheel", **of_gear),
        **gear(4, 0.8, 0.0005, 20, "pinion", **of_gear),
        **disk(6, 2.0, 0.004, 0.007, "fan"),
        **bearing(0, 5e7, 300.0),
        **bearing(2, 6e7, 200.0, kyy=2e7, kxy=3e6),
        **bearing(3, 4e7, 100.0, n_link=7),
        **bearing(5, 2e7, 100.0, kyy=3e7),
        **bearing(7, 1e8, 50.0),
        **pedestal(7),
    }


#: ROSS: `gear_mesh_stiffness=2e8, orientation_angle=0.6`.
MESH = gb.Mesh("wheel", "pinion", stiffness=2e8, centre_line_angle=0.6)


def read(folder: Path, elements: dict[str, dict], *meshes: gb.Mesh) -> gb.RotorSystem:
    plain = {"ross_version": "2.3.0", "parameters": {}, **elements}
    (folder / "rotor.json").write_text(json.dumps(plain))
    return gb.RotorSystem.from_ross(folder / "rotor.json", meshes=meshes)


def check_modes(system: gb.RotorSystem, expected: dict[float, list[complex]]) -> None:
    for speed, eigenvalues in expected.items():
        found = system.modes(speed).eigenvalues
        for one in eigenvalues:
            assert np.abs(found - one).min() < DIFFERENCE * abs(one), (speed, one)


def test_a_coaxial_rotor_has_the_modes_of_ross(tmp_path: Path):
    system = read(tmp_path, coaxial_rotor())
    assert [(one.name, one.speed_ratio) for one in system.shafts] == [
        ("rotor 1", None),
        ("rotor 2", 1.0),
    ]
    assert [(one.name, one.shaft) for one in system.disks] == [
        ("fan", "rotor 1"),
        ("drum", "rotor 2"),
    ]
    between = system.bearings[1]
    assert (between.shaft, between.position) == ("rotor 1", pytest.approx(0.3))
    assert between.support == ("rotor 2", pytest.approx(0.2))
    check_modes(system, COAXIAL)


def test_two_shafts_share_a_pedestal(tmp_path: Path):
    elements = coaxial_rotor()
    elements["BearingElement_5"]["n_link"] = 8
    system = read(tmp_path, elements)
    (support,) = system.supports
    on_support = [one.shaft for one in system.bearings if one.support == support.name]
    assert on_support == ["rotor 1", "rotor 2"]


def test_geared_rotors_have_the_modes_of_ross(tmp_path: Path):
    system = read(tmp_path, geared_rotors(), MESH)
    np.testing.assert_allclose(system.speed_ratios, [1.0, -2.0])
    assert [(one.name, one.shaft, one.teeth) for one in system.gears] == [
        ("wheel", "rotor 1", 40),
        ("pinion", "rotor 2", 20),
    ]
    check_modes(system, GEARED)
    # The angle of the line of centres matters to these rotors.
    with pytest.raises(AssertionError):
        check_modes(
            read(tmp_path, geared_rotors(), gb.Mesh("wheel", "pinion", stiffness=2e8)), GEARED
        )


def test_helical_gears_have_opposite_hands(tmp_path: Path):
    helix = math.radians(15.0)
    elements = geared_rotors(helix_angle=helix)
    for element in elements.values():
        if element.get("tag") in ("wheel", "pinion"):
            element["pitch_diameter"] /= math.cos(helix)
    wheel, pinion = read(tmp_path, elements, MESH).gears
    assert (wheel.helix_angle, pinion.helix_angle) == (helix, -helix)
    transverse = math.atan(math.tan(PRESSURE_ANGLE) / math.cos(helix))
    radius = 0.5 * 40 * 3e-3 / math.cos(helix) * math.cos(transverse)
    assert wheel.base_radius == pytest.approx(radius, rel=1e-14)


def test_gears_with_sizes_have_the_mass_of_ross(tmp_path: Path):
    sizes = {"width": 0.02, "bore_diameter": 0.035, "module": 0.002, "n_teeth": 62}
    given = {"n": 1, **sizes, "pr_angle": PRESSURE_ANGLE, "material": None, "tag": "wheel"}
    plain = {**shaft(range(2), 0.035), "GearElementTVMS_wheel": given}
    plain |= bearing(0, 1e8, 0.0) | bearing(2, 1e8, 0.0)
    with pytest.warns(gb.SceneWarning, match="wheel: the file does not contain the material"):
        (wheel,) = read(tmp_path, plain).gears
    # `m`, `Id` and `Ip` of ROSS 2.3 with the same density
    found = (wheel.mass, wheel.diametral_inertia, wheel.polar_inertia)
    ross = (1.7360332618790646, 0.0018591107866743656, 0.0036024860225567935)
    assert found == pytest.approx(ross, rel=1e-14)
    assert wheel.face_width == 0.02


def without(elements: dict[str, dict], *tags: str) -> dict[str, dict]:
    return {key: value for key, value in elements.items() if value.get("tag") not in tags}


def test_what_is_missing_is_an_error_that_names_it(tmp_path: Path):
    table = {"frequency": [0.0, 100.0], "kxx": [1e7, 2e7], "n_link": 7}
    over_speed = coaxial_rotor()
    over_speed["BearingElement_3"] |= table
    # ROSS 2.3 cannot make this rotor.
    geared_and_coaxial = {**shaft(range(8, 10), 0.05, 0.04), **geared_rotors()}
    geared_and_coaxial |= bearing(2, 6e7, 0.0, n_link=8) | bearing(10, 1e8, 0.0)
    bearings = [f"bearing {n}" for n in range(8)]
    cases = [
        (geared_rotors(), [], r'which of its gears mesh \("wheel" on "rotor 1", "pinion" on'),
        (without(geared_rotors(), *bearings, "pedestal 7"), [MESH], "2 shafts and no bearing"),
        (without(coaxial_rotor(), "bearing 3"), [], 'mesh or coupling connects "rotor 1"'),
        (
            geared_and_coaxial,
            [MESH],
            'no mesh gives the speed of "rotor 3", which a bearing connects',
        ),
        (over_speed, [], "3: a bearing between shafts must not depend on the speed"),
        (
            geared_rotors(),
            [gb.Mesh("wheel", "gear", stiffness=2e8)],
            r'meshes\[0\].driven: .* no gear "gear"; its gears: "wheel", "pinion"',
        ),
    ]
    for elements, meshes, message in cases:
        with pytest.raises(gb.SceneError, match=message):
            read(tmp_path, elements, *meshes)


def test_the_command_takes_the_meshes(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    expected = read(tmp_path, geared_rotors(), MESH)
    scene = tmp_path / "scene.toml"
    options = ["--mesh", "wheel/pinion=200 N/um", "--centre-line-angle", "wheel/pinion=0.6"]
    with pytest.raises(SystemExit) as ended:
        main(["import", str(tmp_path / "rotor.json"), *options, "--out", str(scene)])
    assert ended.value.code == 0, capsys.readouterr().err
    assert gb.RotorSystem.load(scene).description == expected.description
    with pytest.raises(SystemExit) as ended:
        main(["import", str(tmp_path / "rotor.json")])
    assert ended.value.code == 2
    assert "the options --mesh and --centre-line-angle" in capsys.readouterr().err


def test_a_toml_file_with_gears_says_how_to_save_them(tmp_path: Path):
    path = tmp_path / "rotor.toml"
    material = 'material = "Material(name="Steel", rho=7.81000e+03)"'
    path.write_text(f'ross_version = "2.3.0"\n["GearElement_Gear 0"]\nn = 1\n{material}\n')
    with pytest.raises(gb.SceneError, match=r"ROSS 2 cannot save gears in TOML.*as \.json"):
        gb.RotorSystem.from_ross(path)


@pytest.mark.implausible
def test_a_coupling_joins_two_shafts(tmp_path: Path):
    # Light and stiff shafts: the torsional frequency is that of the two halves.
    light = {"name": "light", "rho": 1.0, "E": 1e13, "G_s": 4e12}
    shaft = {"L": 0.1, "idl": 0.0, "idr": 0.0, "odl": 0.05, "odr": 0.05, "material": light}
    coupling = {"n": 1, "m_l": 4.0, "m_r": 6.0, "Ip_l": 0.02, "Ip_r": 0.03, "Id_r": 0.016}
    coupling |= {"kt_x": 2e6, "kt_y": 2e6, "kt_z": 1e6, "kr_x": 5e3, "kr_y": 5e3, "kr_z": 1e4}
    bearing = {"kxx": [1e8], "cxx": [10.0]}
    plain = {
        "ShaftElement_0": {**shaft, "n": 0},
        "ShaftElement_1": {**shaft, "n": 2},
        "CouplingElement_flange": {**coupling, "cr_z": 2.0},
        **{f"BearingElement_{n}": {**bearing, "n": n} for n in range(4)},
    }
    path = tmp_path / "rotor.json"
    path.write_text(json.dumps(plain))
    system = gb.RotorSystem.from_ross(path)
    (found,) = system.couplings
    assert (found.a, found.b) == (("rotor 1", 0.1), ("rotor 2", 0.0))
    assert (found.lateral_stiffness, found.axial_stiffness) == (2e6, 1e6)
    assert (found.tilting_stiffness, found.torsional_damping) == (5e3, 2.0)
    halves = [(disk.name, disk.mass, disk.diametral_inertia) for disk in system.disks]
    assert halves == [("flange left", 4.0, 0.01), ("flange right", 6.0, 0.016)]
    undamped = system.replace(motion="torsion", couplings=[replace(found, torsional_damping=0.0)])
    exact = math.sqrt(1e4 * (1.0 / 0.02 + 1.0 / 0.03)) / (2.0 * math.pi)
    # The inertia of a shaft is 3e-6 of that of a half.
    assert undamped.modes(count=2).frequencies_hz[1] == pytest.approx(exact, rel=1e-5)
    plain["CouplingElement_flange"]["kt_y"] = 3e6
    path.write_text(json.dumps(plain))
    with pytest.raises(
        gb.SceneError, match=r"flange: kt_x and kt_y must be equal, got 2e.06, 3e.06"
    ):
        gb.RotorSystem.from_ross(path)
