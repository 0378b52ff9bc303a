"""Files of other programs: rotors of ROSS, and CSV tables."""

from __future__ import annotations

import copy
import json
import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from reference.cases import each_case

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROSS = Path(__file__).parents[3] / "examples" / "ross_files"
needs_files = pytest.mark.skipif(not ROSS.is_dir(), reason="the examples are not installed")


@needs_files
def test_a_rotor_of_ross_has_the_modes_of_ross():
    system = gb.RotorSystem.from_ross(ROSS / "rotor.toml")
    rows = np.loadtxt(ROSS / "modes.csv", delimiter=",")
    for speed in np.unique(rows[:, 0]):
        _, frequencies, ratios = rows[rows[:, 0] == speed].T
        found = system.modes(speed)
        count = frequencies.size
        # the same elements: only rounding, and the nine digits of the file, differ
        np.testing.assert_allclose(found.frequencies_hz[:count], frequencies, rtol=1e-7)
        np.testing.assert_allclose(found.damping_ratios[:count], ratios, rtol=1e-5)


@needs_files
@pytest.mark.filterwarnings("ignore")  # of the libraries that ROSS imports
def test_ross_still_gives_the_stored_modes(tmp_path: Path):
    pytest.importorskip("ross", exc_type=ImportError)
    example = runpy.run_path(str(ROSS.parent / "from_ross.py"))
    rotor = example["rotor_of_ross"]()
    np.testing.assert_allclose(
        example["modes_of_ross"](rotor), np.loadtxt(ROSS / "modes.csv", delimiter=","), rtol=1e-6
    )
    for name in ("rotor.toml", "rotor.json"):
        rotor.save(tmp_path / name)
        found = gb.RotorSystem.from_ross(tmp_path / name).description
        assert found == gb.RotorSystem.from_ross(ROSS / "rotor.toml").description


@needs_files
def test_the_parts_of_a_rotor_of_ross():
    system = gb.RotorSystem.from_ross(ROSS / "rotor.toml")
    (shaft,) = system.shafts
    assert (shaft.name, len(shaft.segments)) == ("rotor", 7)
    assert shaft.segments[2] == gb.Segment(0.12, 0.07, 0.02, elements=1)
    assert shaft.material == gb.Material(211e9, 7810.0, shear_modulus=81.2e9)
    assert [(disk.name, disk.position, disk.mass) for disk in system.disks] == [
        ("impeller 1", 0.2, 15.0),
        ("impeller 2", pytest.approx(0.56), 22.0),
        ("hub", 0.0, 1.5),
    ]
    journal, ball = (
        next(bearing for bearing in system.bearings if bearing.position == pytest.approx(x))
        for x in (0.0, 0.76)
    )
    assert journal.stiffness.speeds == (0.0, 200.0, 500.0)
    assert journal.stiffness.values[1] == ((5e7, 2e6), (-2e6, 6e7))
    (support,) = system.supports
    assert ball.support == support.name == "pedestal mass"
    assert support.mass == 8.0
    assert np.array_equal(support.stiffness, [[2e8, 0.0], [0.0, 3e8]])


def changed(change) -> dict:
    plain = tomllib.loads((ROSS / "rotor.toml").read_text())
    plain = copy.deepcopy(plain)
    change(plain)
    return plain


def element(plain: dict, kind: str, i: int = 0) -> dict:
    return [value for key, value in plain.items() if key.startswith(kind)][i]


@needs_files
@each_case(
    ("change", "message"),
    [
        (
            lambda p: p.pop("ShaftElement_Shaft Element 3"),
            'no bearing between shafts, mesh or coupling connects "rotor 1"',
        ),
        (
            lambda p: element(p, "ShaftElement", 2).update(gyroscopic=False),
            "Shaft Element 2: gyroscopic must be True, got False",
        ),
        (
            lambda p: element(p, "BearingElement").update(mxx=[1.0]),
            "journal: gearbow cannot represent mxx, the added mass of a bearing",
        ),
        (
            lambda p: element(p, "DiskElement").update(n=12),
            "impeller 1: node 12 is not on the shaft",
        ),
        (
            lambda p: p.update({"RubbingElement_seal": {"n": 2, "m": 1.0}}),
            "seal: gearbow cannot represent a RubbingElement",
        ),
        (
            lambda p: p.update({"TiltingPad_pinion side": {"n": 2, "preload": [0.5] * 5}}),
            "pinion side: gearbow cannot represent a TiltingPad; save the rotor with rs.BearingElement",
        ),
        (
            lambda p: p.update({"CouplingElement_flange": {"n": 20, "m_l": 1.0}}),
            "flange: node 20 is not on the shaft",
        ),
        (
            lambda p: p.pop("PointMass_pedestal mass"),
            "ball: its n_link 8 needs a PointMass and a bearing to the ground",
        ),
        (
            lambda p: [part.pop("n_link", None) for part in p.values() if isinstance(part, dict)],
            "node 8 is not on the shaft, and no bearing links it",
        ),
        (lambda p: p.clear(), "not a rotor of ROSS: it has no ShaftElement"),
        (
            lambda p: [p.pop(key) for key in list(p) if key.startswith("ShaftElement")],
            "has no ShaftElement",
        ),
    ],
)
def test_what_cannot_be_represented_is_an_error_that_names_it(tmp_path, change, message: str):
    path = tmp_path / "rotor.json"
    path.write_text(json.dumps(changed(change)))
    with pytest.raises(gb.SceneError) as caught:
        gb.RotorSystem.from_ross(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)


@needs_files
def test_older_programs_write_no_version(tmp_path: Path):
    def older(plain: dict) -> None:
        del plain["ross_version"]
        for part in plain.values():  # what ROSS takes from the other direction or end
            for key, other in {"kyy": "kxx", "cyy": "cxx", "odr": "odl", "idr": "idl"}.items():
                if isinstance(part, dict) and key in part and part[key] == part[other]:
                    del part[key]

    path = tmp_path / "rotor.json"
    path.write_text(json.dumps(changed(older)))
    found = gb.RotorSystem.from_ross(path)
    assert found.description == gb.RotorSystem.from_ross(ROSS / "rotor.toml").description


def in_ross_3(plain: dict) -> dict:
    """Give the bearing of the file with tables as ROSS 3 names their axes."""
    plain["ross_version"] = "3.0.0"
    bearing = element(plain, "BearingElement")
    bearing["speed"] = bearing.pop("frequency")
    return bearing


@needs_files
def test_tables_of_ross_3_are_over_the_speed(tmp_path: Path):
    expected = gb.RotorSystem.from_ross(ROSS / "rotor.toml").description
    path = tmp_path / "rotor.json"
    path.write_text(json.dumps(changed(in_ross_3)))
    assert gb.RotorSystem.from_ross(path).description == expected

    def over_both(plain: dict, slope: float) -> None:
        bearing = in_ross_3(plain)
        bearing["frequency"] = [0.0, 100.0, 600.0]
        for key, values in bearing.items():
            if key[0] in "kc" and key[1] != "z" and len(key) == 3 and len(values) == 3:
                axis = zip(values, bearing["speed"], strict=True)
                bearing[key] = [
                    [value + slope * (f - speed) for f in bearing["frequency"]]
                    for value, speed in axis
                ]

    path.write_text(json.dumps(changed(lambda plain: over_both(plain, 0.0))))
    assert gb.RotorSystem.from_ross(path).description == expected  # and no warning
    path.write_text(json.dumps(changed(lambda plain: over_both(plain, 2.0))))

    def first_table() -> gb.SpeedTable:
        return next(
            bearing.stiffness
            for bearing in gb.RotorSystem.from_ross(path).bearings
            if isinstance(bearing.stiffness, gb.SpeedTable)
        )

    table = first_table()
    assert table.frequencies == (0.0, 100.0, 600.0)
    speed = table.speeds[1]
    expected = np.array([[5e7, 2e6], [-2e6, 6e7]])[None] + 2.0 * (
        np.array(table.frequencies)[:, None, None] - speed
    )
    np.testing.assert_allclose(table.values[1], expected, rtol=1e-12)

    def over_frequency(plain: dict) -> None:
        bearing = in_ross_3(plain)
        bearing["frequency"] = bearing.pop("speed")

    path.write_text(json.dumps(changed(over_frequency)))
    alone = first_table()
    assert (alone.speeds, len(alone.frequencies)) == (None, 3)
    np.testing.assert_allclose(alone.values[1], [[5e7, 2e6], [-2e6, 6e7]], rtol=1e-15)


@needs_files
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda p: in_ross_3(p).update(frequency=[0.0, 1.0]),
            "journal: kxx: must have the shape (3, 2) of its speeds and frequencies, got (3,)",
        ),
        (lambda p: element(p, "DiskElement").pop("Id"), "an element has no 'Id'"),
        (lambda p: element(p, "BearingElement").update(kxx=["a"]), "an element has a wrong value"),
        (lambda p: element(p, "ShaftElement").update(L="long"), "an element has a wrong value"),
    ],
)
def test_a_table_or_value_that_gearbow_cannot_read_is_an_error(tmp_path, change, message: str):
    path = tmp_path / "rotor.json"
    path.write_text(json.dumps(changed(change)))
    with pytest.raises(gb.SceneError, match=re.escape(f"{path}: {message}")):
        gb.RotorSystem.from_ross(path)


def test_another_file_is_not_a_rotor_of_ross(tmp_path: Path):
    (tmp_path / "rotor.json").write_text("{")
    with pytest.raises(gb.SceneError, match=r"rotor\.json: not a rotor of ROSS"):
        gb.RotorSystem.from_ross(tmp_path / "rotor.json")
    with pytest.raises(FileNotFoundError):
        gb.RotorSystem.from_ross(tmp_path / "nothing.toml")


COEFFICIENTS = """# measured
speed [rpm]; kyy [N/um]; kzz [kN/mm]; kyz [N/um]; c [N s/mm]

0;    20; 30; 1; 0.5
3000; 25; 35; 2; 0.4
"""


def test_a_table_of_coefficients(tmp_path: Path):
    path = tmp_path / "bearing.csv"
    path.write_text(COEFFICIENTS, encoding="utf-8-sig")
    table = gb.SpeedTable.read_table(path, outside="hold")
    assert table.speeds == pytest.approx((0.0, 100 * np.pi), rel=1e-15)
    assert table.outside == "hold"
    np.testing.assert_allclose(table.values[0], [[2e7, 1e6], [0.0, 3e7]], rtol=1e-15)
    damping = gb.SpeedTable.read_table(path, "damping")
    np.testing.assert_allclose(damping.values, [500.0, 400.0], rtol=1e-15)
    path.write_text("speed,k\n0,1e7\n100,2e7\n")
    assert gb.SpeedTable.read_table(path) == gb.SpeedTable([0.0, 100.0], [1e7, 2e7])


@each_case(
    ("old", "new", "message"),
    [
        ("[rpm]", "[Hz]", "line 2, column \"speed\": 'Hz' is not a known unit"),
        ("[rpm]", "[mm]", 'line 2, column "speed": must have a unit that converts to rad/s'),
        ("kyz", "kxy", "line 2: 'kxy [N/um]' is not a column; there are speed, rpm, k, kyy"),
        (
            "kyz",
            "kxy",
            'name the axes of the table, for example axes="xy": y here is its x, z its y',
        ),
        ("kyz [N/um]", "N/um", 'in brackets behind its column, for example "k [N/um]"'),
        ("[rpm]", "rpm", 'write the unit in brackets: "speed [rpm]"'),
        ("[rpm]", "{rpm}", 'write the unit in brackets: "speed [rpm]"'),
        ("[rpm]", "(rpm]", 'write the unit in brackets: "speed [rpm]"'),
        ("[rpm]", "[rpm", 'write the unit in brackets: "speed [rpm]"'),
        ("kyz", "kzz", "line 2: the column 'kzz' occurs twice"),
        (
            "25;",
            "25,5;",
            "line 5, column \"kyy\": must be a number with a decimal point, got ' 25,5'",
        ),
        (
            "25;",
            "nan;",
            "line 5, column \"kyy\": must be a number with a decimal point, got ' nan'",
        ),
        (
            "25;",
            "2_5;",
            "line 5, column \"kyy\": must be a number with a decimal point, got ' 2_5'",
        ),
        (
            "25;",
            "1e400;",
            "line 5, column \"kyy\": must be below 1.8e308 in SI units, got ' 1e400'",
        ),
        (
            "25;",
            "1e308;",
            "line 5, column \"kyy\": must be below 1.8e308 in SI units, got ' 1e308'",
        ),
        (
            "kyz",
            "k",
            'has the column "k", which is isotropic, and "kyy"; give either "k", or "kyy"',
        ),
        ("0.4", "0.4;", "line 5: must have 5 numbers, as the headings, got 6"),
        ("speed [rpm]; ", "", "line 4: must have 4 numbers"),
        ("kyy [N/um]", "kzy [N/um]", 'needs the column "k", or "kyy" and "kzz"'),
    ],
)
def test_a_mistake_in_a_table_names_line_and_column(tmp_path, old: str, new: str, message: str):
    path = tmp_path / "bearing.csv"
    assert old in COEFFICIENTS
    path.write_text(COEFFICIENTS.replace(old, new, 1))
    with pytest.raises(gb.SceneError) as caught:
        gb.SpeedTable.read_table(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)


def test_measured_runout(tmp_path: Path):
    path = tmp_path / "runout.csv"
    path.write_text(
        "position [mm]\tTotal run out [um]\tphase [deg]\n0\t0\t0\n250\t300\t90\n500\t0\t0\n"
    )
    bow = gb.Bow.read_table(path)
    assert bow.positions == (0.0, 0.25, 0.5)
    assert bow.amplitudes == pytest.approx((0.0, 150e-6, 0.0), rel=1e-15)
    assert bow.phases == pytest.approx((0.0, np.pi / 2, 0.0), rel=1e-15)
    path.write_text("position,amplitude\n0,0\n0.25,1e-4\n0.5,0\n")
    assert gb.Bow.read_table(path) == gb.Bow.points([0.0, 0.25, 0.5], [0.0, 1e-4, 0.0])
    # A line with another number of cells than that of the headings may have lost one.
    path.write_text("position,amplitude,,\n0,0,,\n0.25,1e-4,\n0.5,0,,\n")
    with pytest.raises(gb.SceneError, match="line 3: must have 2 numbers, as the headings, got 3"):
        gb.Bow.read_table(path)
    path.write_text("position,phase\n0,0\n0.25,1\n")
    with pytest.raises(gb.SceneError, match='needs the column "position" and one of "amplitude"'):
        gb.Bow.read_table(path)
    path.write_text("position,amplitude\n")
    with pytest.raises(gb.SceneError, match="needs a line of headings and lines of numbers"):
        gb.Bow.read_table(path)


# --- text files of other programs -----------------------------------------------------------------

DEEP = b"a = " + 20_000 * b"["


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            "speed;k [N/µm]\n0;10 # \x84\n".encode("latin1"),
            "line 1: byte 0xb5 is neither UTF-8, UTF-16 nor clearly Windows-1252; save it as UTF-8",
        ),
        (
            "speed;k [N/µm]\n0;10\n".encode() + b"\xff",
            "line 3: byte 0xff is neither UTF-8, UTF-16 nor clearly Windows-1252; save it as UTF-8",
        ),
        (b"\xff\xfes\0\n", "line 1: byte 0x0a is neither UTF-8, UTF-16 nor clearly"),
        (b"PK\0\0", "is no text file; a workbook of Excel must end with .xlsx"),
        (b"", "needs a line of headings and lines of numbers"),
        (b"speed;stiffness\n0;" + 140_000 * b"1", "line 2: is no line of a CSV file: field larger"),
    ],
)
def test_a_table_of_another_program_names_the_file_and_the_encoding(tmp_path, content, message):
    path = tmp_path / "table.csv"
    path.write_bytes(content)
    with pytest.raises(gb.SceneError) as caught:
        gb.SpeedTable.read_table(path)
    assert str(caught.value).startswith(f"{path}: {message}")


@each_case(
    ("read", "name", "content", "message"),
    [
        (gb.RotorSystem.load, "a.toml", DEEP, "is nested too deeply"),
        (gb.RotorSystem.from_ross, "a.toml", DEEP, "is nested too deeply"),
        (gb.RotorSystem.from_ross, "a.json", 200_000 * b"[", "is nested too deeply"),
        (gb.RotorSystem.from_ross, "a.toml", b"\xe9 = 1", "is not UTF-8 text: byte 0xe9 in line 1"),
        (gb.RotorSystem.load, "a.toml", b"\n\xe9 = 1", "is not UTF-8 text: byte 0xe9 in line 2"),
    ],
)
def test_a_damaged_text_file_is_an_error_that_names_it(tmp_path, read, name, content, message):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(gb.SceneError) as caught:
        read(path)
    assert str(caught.value).startswith(f"{path}: {message}")


def test_a_byte_order_mark_does_not_change_a_scene(tmp_path: Path):
    path = tmp_path / "scene.toml"
    gb.RotorSystem.from_ross(ROSS / "rotor.toml").save(path)
    expected = gb.RotorSystem.load(path).description
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert gb.RotorSystem.load(path).description == expected


# --- tables of bearing programs -------------------------------------------------------------------

FOREIGN = """Speed [rpm], Kxx [N/um], K_xy [N/um], Kyx [N/um], kyy [N/um], CXX [kN s/m], Cyy [kN s/m]
3000, 11, 12, -21, 22, 1, 2
6000, 13, 14, -23, 24, 3, 4
"""


def test_the_axes_of_a_foreign_table_are_named_in_the_call(tmp_path: Path):
    path = tmp_path / "bearing.csv"
    path.write_text(FOREIGN)
    with pytest.raises(gb.SceneError, match='name the axes of the table, for example axes="xy"'):
        gb.SpeedTable.read_table(path)
    table = gb.SpeedTable.read_table(path, axes="xy")
    np.testing.assert_allclose(table.speeds, gb.rpm(np.array([3000.0, 6000.0])), rtol=1e-15)
    np.testing.assert_allclose(table.values[0], [[11e6, 12e6], [-21e6, 22e6]], rtol=1e-15)
    turned = gb.SpeedTable.read_table(path, axes="yx")
    np.testing.assert_allclose(turned.values[0], [[22e6, -21e6], [12e6, 11e6]], rtol=1e-15)
    damping = gb.SpeedTable.read_table(path, "damping", axes="xy")
    np.testing.assert_allclose(damping.values[1], [[3e3, 0.0], [0.0, 4e3]], rtol=1e-15)
    for wrong in ("yy", "x", "", None, 1):
        with pytest.raises(gb.SceneError, match="axes: must be one of yz, zy, xy, yx, xz, zx, got"):
            gb.SpeedTable.read_table(path, axes=wrong)  # type: ignore[arg-type]


def test_the_spin_from_y_to_x_turns_the_cross_coefficients(tmp_path: Path):
    """A shaft that turns from y to x, seen from its other side, turns from x to y."""
    path = tmp_path / "bearing.csv"
    path.write_text(FOREIGN)
    rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4)
    ratios = {}
    for axes in ("xy", "yx"):
        stiffness = gb.SpeedTable.read_table(path, axes=axes)
        bearings = [gb.Bearing("rotor", x, stiffness=stiffness) for x in (0.0, 1.0)]
        modes = gb.RotorSystem(shafts=[rotor], bearings=bearings).modes(gb.rpm(3000))
        # Kxy > 0 > Kyx drives the whirl from x to y.
        ratios[axes] = dict(zip(modes.whirl[:2], modes.damping_ratios[:2], strict=True))
    assert ratios["xy"]["forward"] < 0.0 < ratios["xy"]["backward"]
    assert ratios["yx"]["backward"] < 0.0 < ratios["yx"]["forward"]


def test_units_of_headings_without_one_are_named_in_the_call(tmp_path: Path):
    path = tmp_path / "bearing.csv"
    path.write_text("RPM,K,C [N s/m]\n3000,1,400\n6000,2,500\n")
    table = gb.SpeedTable.read_table(path, units={"stiffness": "N/um"})
    assert table == gb.SpeedTable(gb.rpm(np.array([3000.0, 6000.0])), [1e6, 2e6])
    path.write_text("speed,K\n3000,1\n6000,2\n")
    units = {"speed": "rpm", "stiffness": "kN/mm"}
    assert gb.SpeedTable.read_table(path, units=units) == table
    for wrong, message in (
        ({"speed": "Hz"}, "column \"speed\": 'Hz' is not a known unit"),
        ({"speeds": "rpm"}, "units: must be one of speed, stiffness, damping, got 'speeds'"),
        ("rpm", "units: must be a mapping of names to units, got 'rpm'"),
        ({"speed": 1.0}, "units: must be a mapping of names to units"),
    ):
        with pytest.raises(gb.SceneError, match=re.escape(message)):
            gb.SpeedTable.read_table(path, units=wrong)  # type: ignore[arg-type]
    path.write_text("speed,rpm,K\n0,3000,1\n1,6000,2\n")
    with pytest.raises(gb.SceneError, match='needs the column "speed" or "rpm", and only one'):
        gb.SpeedTable.read_table(path)


def test_a_table_in_an_excel_file(tmp_path: Path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("openpyxl")
    (tmp_path / "bearing.csv").write_text(FOREIGN)
    path = tmp_path / "bearing.xlsx"
    rows = [line.split(", ") for line in FOREIGN.splitlines()]
    numbers = [[float(cell) for cell in row] for row in rows[1:]]
    comment = ["# measured", *6 * [None]]
    empty = 7 * [None]
    pandas.DataFrame([comment, rows[0], empty, *numbers]).to_excel(path, header=False, index=False)
    for quantity in ("stiffness", "damping"):
        found = gb.SpeedTable.read_table(path, quantity, axes="xy")
        assert found == gb.SpeedTable.read_table(tmp_path / "bearing.csv", quantity, axes="xy")
    numbers[1][2] = None
    pandas.DataFrame([rows[0], *numbers]).to_excel(path, header=False, index=False)
    with pytest.raises(
        gb.SceneError, match=r'bearing\.xlsx: row 3, column "kxy": must be a number'
    ):
        gb.SpeedTable.read_table(path, axes="xy")
    path.write_bytes(b"PK")
    with pytest.raises(gb.SceneError, match=r"bearing\.xlsx: is not an Excel file"):
        gb.SpeedTable.read_table(path, axes="xy")


def test_a_table_in_a_matlab_file(tmp_path: Path):
    io = pytest.importorskip("scipy.io")
    path = tmp_path / "bearing.mat"
    units = {"speed": "rpm", "stiffness": "N/um"}
    vectors = {"speed": [3000, 6000], "Kxx": [11.0, 13.5], "Kyy": np.array([[22.0], [24.0]])}
    io.savemat(path, vectors)
    table = gb.SpeedTable.read_table(path, axes="xy", units=units)
    np.testing.assert_allclose(table.speeds, gb.rpm(np.array([3000.0, 6000.0])), rtol=1e-15)
    np.testing.assert_allclose(table.values[1], [[13.5e6, 0.0], [0.0, 24e6]], rtol=1e-15)
    for wrong, message in (
        ({"Kyy": np.ones((2, 2))}, r"bearing\.mat: Kyy: must be a vector, has the shape \(2, 2\)"),
        ({"Kyy": "text"}, r"bearing\.mat: Kyy: must be a vector of numbers"),
        ({"Kyy": [1.0]}, r"bearing\.mat: its vectors must have one length, got \[1, 2\]"),
        ({"Kyy": [1.0, np.nan]}, r'bearing\.mat: value 2, column "kyy": must be a number'),
        ({"Kzz": [1.0, 2.0]}, r"bearing\.mat: names: 'Kzz' is not a column"),
    ):
        io.savemat(path, vectors | wrong)
        with pytest.raises(gb.SceneError, match=message):
            gb.SpeedTable.read_table(path, axes="xy", units=units)
    path.write_bytes(b"MATLAB 7.3")
    with pytest.raises(gb.SceneError, match=r"bearing\.mat: is not a MATLAB file"):
        gb.SpeedTable.read_table(path, axes="xy")
    with pytest.raises(FileNotFoundError):
        gb.SpeedTable.read_table(tmp_path / "nothing.mat")
