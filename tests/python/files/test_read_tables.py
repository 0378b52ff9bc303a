"""Tables of other programs and instruments: encodings, separators, units and probes."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from reference.cases import each_case

#: Inch [m], pound-force [N].
INCH, POUND = 0.0254, 4.4482216152605


def write(path: Path, text: str, encoding: str = "utf-8") -> Path:
    """Write a text file."""
    path.write_bytes(text.encode(encoding))
    return path


# --- bearing programs -----------------------------------------------------------------------------

UNITS_BELOW = """Speed,Kxx,Kxy,Kyx,Kyy,Cxx,Cyy,Mxx,Mxy,Myx,Myy
rpm,N/m,N/m,N/m,N/m,N-s/m,N-s/m,kg,-,,kg
3000,1.4e7,2e6,-2e6,1.5e7,1.0e5,1.1e5,0,0,0,0
6000,8.5e7,4e6,-4e6,9.0e7,1.5e5,1.6e5,0,0,0,0
"""
US = """Speed (rpm),Kxx (lbf/in),Kyy (lbf/in),Cxx (lbf-s/in),Cyy (lbf s/in)
3000,8e4,8e4,580,580
6000,4.9e5,4.9e5,860,860
"""


@pytest.mark.filterwarnings("error")
def test_units_in_a_line_below_the_headings(tmp_path: Path):
    path = write(tmp_path / "bearing.csv", UNITS_BELOW)
    stiffness = gb.SpeedTable.read_table(path, axes="xy")
    assert stiffness.speeds == pytest.approx(gb.rpm([3000, 6000]), rel=1e-15)
    assert stiffness.values[1] == ((8.5e7, 4e6), (-4e6, 9.0e7))
    damping = gb.SpeedTable.read_table(path, "damping", axes="xy")
    assert damping.values[0] == ((1.0e5, 0.0), (0.0, 1.1e5))
    write(path, UNITS_BELOW.replace("rpm,N/m", "[rpm],(kN/mm)"))
    assert gb.SpeedTable.read_table(path, axes="xy").values[0][0][0] == 1.4e13


def test_added_masses_that_are_not_zero_are_named(tmp_path: Path):
    path = write(
        tmp_path / "bearing.csv", UNITS_BELOW.replace("1.5e5,1.6e5,0,", "1.5e5,1.6e5,-12,")
    )
    with pytest.warns(
        gb.SceneWarning, match=r"bearing\.csv: the added masses are left out: mxx up to 12 kg$"
    ):
        gb.SpeedTable.read_table(path, axes="xy")


def test_units_of_the_workshop_in_a_bearing_table(tmp_path: Path):
    path = write(tmp_path / "bearing.csv", US)
    stiffness = gb.SpeedTable.read_table(path, axes="xy")
    # numbers and factors are rounded once each
    assert stiffness.values[0][0][0] == pytest.approx(8e4 * POUND / INCH, rel=1e-15)
    damping = gb.SpeedTable.read_table(path, "damping", axes="xy")
    assert damping.values[1][1][1] == pytest.approx(860 * POUND / INCH, rel=1e-15)


# --- encodings, separators, decimal signs ---------------------------------------------------------

PLAIN = "speed [rpm];k [N/µm];c [N s/mm]\n0;20.5;0.5\n3000;25;0.4\n"
GERMAN = PLAIN.replace(".", ",")


@each_case(
    ("text", "encoding"),
    [
        (PLAIN, "utf-8"),
        (PLAIN, "utf-8-sig"),
        (PLAIN, "utf-16"),
        (PLAIN, "cp1252"),
        (GERMAN, "cp1252"),
        (GERMAN.replace("\n", "\r\n"), "utf-16"),
        (GERMAN.replace("\n", "\r"), "utf-8"),
        (GERMAN.replace(";", "\t"), "utf-8"),
        (PLAIN.replace(";", ","), "utf-8"),
        (PLAIN.replace(";", "   "), "utf-8"),
        (PLAIN.replace("\n", ";;\n"), "utf-8"),
        (GERMAN.replace(";", " ; "), "utf-8"),
    ],
)
def test_a_table_is_the_same_in_every_dialect(tmp_path: Path, text: str, encoding: str):
    table = gb.SpeedTable.read_table(write(tmp_path / "a.txt", text, encoding))
    assert table.values == (20.5e6, 25e6)
    assert table.speeds == pytest.approx((0.0, 100 * np.pi), rel=1e-15)


@each_case(
    ("text", "message"),
    [
        # thousands, or decimals?
        ("speed\tk\n1,000\t1\n2,000\t2\n", "line 2, column \"speed\": must be a number with a decimal point, got '1,000'"),
        ('speed,k\n"1,5",1\n', "line 2, column \"speed\": must be a number with a decimal point, got '1,5'"),
        ("speed;k\n1,5;1.5\n", "line 2, column \"speed\": must be a number with a decimal point, got '1,5'"),
        ("speed;k\n1,5;1,5,0\n", "line 2, column \"k\": must be a number with a decimal comma, got '1,5,0'"),
        ("speed;k\n1;2\n2;#N/A\n", "line 3, column \"k\": must be a number with a decimal point, got '#N/A'"),
        ("speed;k\n1;2\n#DIV/0!;3\n", 'line 3, column "speed": must be a number'),
        ("speed;k\n1;2\n2;\n", "line 3, column \"k\": must be a number with a decimal point, got ''"),
        ("speed;k\n1;2\n2;inf\n", "line 3, column \"k\": must be a number with a decimal point, got 'inf'"),
        ("speed;k\nrpm;furlong\n1;2\n", "line 2, column \"k\": 'furlong' is not a known unit"),
        ("speed;k\nrpm;N\n1;2\n", "line 2, column \"k\": must have a unit that converts to N/m, got 'N'"),
        ("speed [rpm];k\nrad/s;N/m\n1;2\n", 'line 2, column "speed": has rpm in its heading and rad/s below it'),
        ("speed;k\nrpm;N/m\n", "needs a line of headings and lines of numbers"),
        ("speed;k;K\n1;2;3\n", "line 1: the column 'k' occurs twice"),
        ("speed k\n1 (2\n", "line 2, column \"k\": must be a number with a decimal point, got '(2'"),
        ("speed k\n1 2 (3)\n", "line 2, column \"k\": must be a number with a decimal point, got '2 (3)'"),
        ("speed;k\n1;" + 5000 * "1", 'line 2, column "k": must be a number'),
        ("speed;" + 5000 * "[", "line 1: '[[[["),
        ("speed;;k\n1;2;3\n", "line 1: '' is not a column"),
    ],
)  # fmt: skip
def test_an_odd_cell_is_an_error_with_its_place(tmp_path: Path, text: str, message: str):
    path = write(tmp_path / "a.csv", text)
    with pytest.raises(gb.SceneError) as caught:
        gb.SpeedTable.read_table(path)
    assert str(caught.value).startswith(f"{path}: {message}")


@each_case(
    ("name", "message"),
    [
        ("a.xls", "is an Excel file of before 2007; save it as .xlsx or .csv"),
        ("a.ods", "is no table that gearbow reads; save it as .xlsx or .csv"),
    ],
)
def test_an_unknown_kind_of_table_is_one_sentence(tmp_path: Path, name: str, message: str):
    path = tmp_path / name
    path.write_bytes(b"\xd0\xcf\x11\xe0")
    with pytest.raises(gb.SceneError, match=f"^{re.escape(f'{path}: {message}')}$"):
        gb.SpeedTable.read_table(path)


def test_a_sheet_with_units_decimal_commas_and_wrong_cells(tmp_path: Path):
    openpyxl = pytest.importorskip("openpyxl")
    path = tmp_path / "a.xlsx"

    def saved(*rows: list[object]) -> Path:
        book = openpyxl.Workbook()
        for row in rows:
            book.active.append(row)
        book.save(path)
        return path

    head = ["speed", "k", None]
    found = gb.SpeedTable.read_table(
        saved(["# title"], head, ["rpm", "N/um"], [0, "20,5"], [1, 25])
    )
    assert found.values == (20.5e6, 25e6)
    for cell in (True, "#N/A", None, __import__("datetime").date(2026, 1, 5)):
        with pytest.raises(gb.SceneError, match=r'a\.xlsx: row 2, column "k": must be a number'):
            gb.SpeedTable.read_table(saved(head, [1, cell]))


# --- vibration ------------------------------------------------------------------------------------

HEAD = "speed [rpm]; shaft; position [in]; angle [deg]; {}; phase_lag [deg]\n300; input; 8; 45; 0.12; 33\n"


@each_case(
    ("heading", "amplitude"),
    [
        ("amplitude [mil]", 3.048e-6),
        ("amplitude [mil pp]", 1.524e-6),
        ("Amplitude p-p [mil]", 1.524e-6),
        ("amplitude_pp (mils)", 1.524e-6),
        ("amplitude (mil pk-pk)", 1.524e-6),
        ("amplitude peak-to-peak [mil]", 1.524e-6),
        ("amplitude 0-pk [mil]", 3.048e-6),
        ("amplitude [mil rms]", 3.048e-6 * np.sqrt(2)),
    ],
)
def test_headings_tell_peak_peak_to_peak_and_rms_apart(tmp_path: Path, heading, amplitude):
    path = write(tmp_path / "a.csv", HEAD.format(heading))
    found = gb.Measurement.read_csv(path)
    assert abs(found.amplitudes[0, 0]) == pytest.approx(amplitude, rel=1e-15)
    assert np.angle(found.amplitudes[0, 0]) == pytest.approx(-np.radians(33), rel=1e-15)
    assert found.probes[0].position == pytest.approx(8 * INCH, rel=1e-15)


def test_an_argument_says_what_amplitudes_are(tmp_path: Path):
    path = write(tmp_path / "a.csv", HEAD.format("amplitude [mil]"))
    found = gb.Measurement.read_csv(path, detection="peak-to-peak")
    assert abs(found.amplitudes[0, 0]) == pytest.approx(1.524e-6, rel=1e-15)
    with pytest.raises(
        gb.SceneError, match="detection: must be one of peak, peak-to-peak, rms, got"
    ):
        gb.Measurement.read_csv(path, detection="pp")
    write(path, HEAD.format("amplitude [mil rms]"))
    with pytest.raises(gb.SceneError, match='"amplitude": its heading says rms, the argument'):
        gb.Measurement.read_csv(path, detection="peak")


WIDE = """speed [rpm]; A amplitude [um pp]; A phase [deg]; B amplitude p-p; B phase lag
           ;                    ;              ;  mil           ;  deg
3000       ; 10                 ; 20           ;  1             ;  90
6000       ; 20                 ; 30           ;  2             ;  80
"""  # fmt: skip


def test_a_line_with_several_probes(tmp_path: Path):
    path = write(tmp_path / "a.csv", WIDE)
    probes = {"A": gb.Probe("input", 0.1), "B": gb.Probe("input", 0.2, angle=1.0)}
    found = gb.Measurement.read_csv(path, probes)
    assert found.probes == tuple(probes.values())
    expected = [[5e-6 * np.exp(1j * np.radians(20)), 1.27e-5 * np.exp(-1j * np.radians(90))]]
    expected += [[10e-6 * np.exp(1j * np.radians(30)), 2.54e-5 * np.exp(-1j * np.radians(80))]]
    np.testing.assert_allclose(found.amplitudes, expected, rtol=1e-14)
    # a name can be a place
    write(path, WIDE.replace("A ", "input@100 mm y ").replace("B ", "input@0.2 z "))
    named = gb.Measurement.read_csv(path)
    places = [(probe.shaft, probe.position, probe.angle) for probe in named.probes]
    assert places == [("input", 0.1, 0.0), ("input", 0.2, np.pi / 2)]
    np.testing.assert_array_equal(named.amplitudes, found.amplitudes)


@each_case(
    ("text", "message"),
    [
        ("speed,A amplitude,A phase\n1,2e-6,0\n", "line 2: the place of probe 'A' is unknown"),
        ("speed,A amplitude\n1,2e-6\n", ': needs the columns "A amplitude" and one of "A phase"'),
        ("speed,A real,amplitude,phase\n1,2,3,4\n", ': has columns of the probe "A" beside "amplitude"'),
        ("speed,A real,A real\n1,2,3\n", "line 1: the column 'A real' occurs twice"),
        ("speed,A real,A imaginary\n0,2,3\n", 'line 2, column "speed": must not be zero'),
        ("speed,A amplitude,A phase\n1,-2,3\n", 'line 2, column "A amplitude": must not be negative'),
        ("speed,A amplitude,A phase\n1,2,3\n2,3,80\n", 'line 3, column "A phase": has no unit'),
        ("speed,A real,A velocity\n1,2,3\n", "line 1: 'A velocity' is no heading such as"),
        ("speed [rpm pp],A real\n1,2\n", 'line 1, column "speed": one of peak, peak-to-peak and RMS'),
        ("speed,amplitude pp [um rms]\n1,2\n", 'line 1, column "amplitude": one of peak'),
        ("speed,A real,A imaginary\n1,nan,3\n", 'line 2, column "A real": must be a number'),
        ("speed,A real,A imaginary\n1,1_0,3\n", 'line 2, column "A real": must be a number'),
    ],
)  # fmt: skip
def test_a_wrong_table_of_probes(tmp_path: Path, text: str, message: str):
    path = write(tmp_path / "a.csv", text)
    with pytest.raises(gb.SceneError, match=re.escape(message)) as caught:
        gb.Measurement.read_csv(path)
    assert str(caught.value).startswith(f"{path}: ")


# --- frequency responses --------------------------------------------------------------------------

RESPONSE = "frequency [Hz];hub y re [{0}];hub y im [{0}];hub twist re [deg];hub twist im [deg]\n"


def rotor() -> gb.RotorSystem:
    """Return a shaft with a disk."""
    return gb.RotorSystem(
        [gb.Shaft("s", length=0.5, outer_diameter=0.03, elements=4)],
        disks=[gb.Disk("hub", "s", 0.25, 5.0, 0.02, 0.04)],
        bearings=[gb.Bearing("s", x, stiffness=1e7, damping=100.0) for x in (0.0, 0.5)],
        motion="coupled",
    )


def test_a_frequency_response_in_units_of_the_workshop(tmp_path: Path):
    response = rotor().frequency_response([100.0, 200.0], source=gb.Force("hub", 1.0))
    path = tmp_path / "frf.csv"
    row = "10;1,5;2;3;4\n"
    for unit, quantity, factor in (
        ("mil", "displacement", 2.54e-5),
        ("in/s", "velocity", INCH),
        ("mm/s^2", "acceleration", 1e-3),
    ):
        write(path, RESPONSE.format(unit) + row)
        moved, turned = response.compare(path).measured
        assert (moved.at, moved.direction, moved.quantity) == ("hub", "y", quantity)
        assert moved.values == pytest.approx([factor * (1.5 + 2j)], rel=1e-15)
        assert moved.frequencies == pytest.approx([20 * np.pi], rel=1e-15)
        assert turned.values == pytest.approx([np.radians(3) + 1j * np.radians(4)], rel=1e-15)
        assert turned.quantity == "displacement"


@each_case(
    ("text", "message"),
    [
        # of two equal headings the second won
        ("frequency [Hz],hub y re [m],hub y re [m],hub y im [m]\n1,2,3,4\n", "line 1: the column 'hub y re' occurs twice"),
        *[
            (f"frequency [Hz],hub y re [m],hub y im [m]\n1,2,{cell}\n", 'line 2, column "hub y im": must be a number')
            for cell in ("nan", "inf", "1_0")
        ],
        ("frequency [Hz],hub y re [m],hub y im [m/s]\n1,2,3\n", ": hub y needs a column re and a column im of one"),
        ("frequency [Hz],hub y re [m]\n1,2\n", ": hub y needs a column re and a column im of one"),
        ("frequency [Hz],hub y re,hub y im\n1,2,3\n", 'column "hub y re": needs its unit in brackets, m or m/s or m/s^2'),
        ("frequency,hub y re [m],hub y im [m]\n1,2,3\n", 'column "frequency": needs its unit in brackets, rad/s, or Hz'),
        ("frequency [Hz],hub y re [kg],hub y im [kg]\n1,2,3\n", "must have a unit that converts to m or m/s or m/s^2"),
        ("hub y re [m],hub y im [m]\n1,2\n", ': needs the column "frequency [Hz]"'),
        ("frequency [Hz]\n1\n", ': needs columns such as "pinion y re [m/s²]"'),
    ],
)  # fmt: skip
def test_a_wrong_table_of_a_frequency_response(tmp_path: Path, text: str, message: str):
    path = write(tmp_path / "frf.csv", text)
    response = rotor().frequency_response([100.0, 200.0], source=gb.Force("hub", 1.0))
    with pytest.raises(gb.SceneError, match=re.escape(message)) as caught:
        response.compare(path)
    assert str(caught.value).startswith(f"{path}: ")


# --- given files ----------------------------------------------------------------------------------


def test_the_given_tables():
    folder = os.environ.get("GEARBOW_TEST_DATA")
    if folder is None:
        pytest.skip("GEARBOW_TEST_DATA does not name the folder of the given files")
    cases = Path(folder, "cases")
    table = gb.SpeedTable.read_table(cases / "xltrc_usekcm.csv", axes="xy")
    assert table.values[1] == ((8.5e7, 0.0), (0.0, 8.5e7))
    table = gb.SpeedTable.read_table(cases / "us_units.csv", axes="xy")
    assert table.values[0][0][0] == pytest.approx(1.40101e7, rel=1e-5)
    for name, size in (("rundown_pp.csv", 1.6e-6), ("rundown_mil.csv", 3.048e-6)):
        found = gb.Measurement.read_csv(cases / name).amplitudes
        assert abs(found[0, 0]) == pytest.approx(size, rel=1e-15)
