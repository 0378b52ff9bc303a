"""Frequency response as tables, files, figures and comparisons, and the command `gearbow response`."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import gearbow as gb
from gearbow.cli.main import main
from reference.machines import BETWEEN, hostile
from test_frequency_response import train

FREQUENCIES = 2.0 * np.pi * np.linspace(20.0, 800.0, 40)


@pytest.fixture(scope="module", params=[70.0, -70.0])
def response(request):
    sources = [gb.Force(("input", 0.1), 1.0), gb.MeshExcitation("g4/g5")]
    return hostile().frequency_response(FREQUENCIES, source=sources, speed=request.param)


def test_tables_have_every_place_frequency_and_source(response):
    table = response.to_dataframe()
    assert len(table) == 2 * FREQUENCIES.size
    own = table[table["source"] == "mesh g4/g5"]
    for mesh in ("g1/g2", "g2/g3", "g4/g5"):
        assert own[f"{mesh} mesh force [N]"].to_numpy() == pytest.approx(
            response.mesh_force(mesh)[:, 1]
        )
    for shaft, x in (("input", 0.3), ("output", 0.0)):
        assert own[f"{shaft}@{x} bearing force z [N]"].to_numpy() == pytest.approx(
            response.bearing_force((shaft, x))[:, 1, 1]
        )
    assert list(response.to_dataframe(BETWEEN).columns[3:]) == [
        f"middle@0.2137 {name}" for name in ("y [m]", "z [m]", "twist [rad]", "x [m]")
    ]
    data = response.to_xarray()
    assert data["g5 y"].dims == ("frequency", "source")
    assert data["g5 y"].sel(source="force at input at 0.1 m").values == pytest.approx(
        response.displacement("g5")[:, 0, 0]
    )
    rows = train().mesh_response("pinion/wheel", speeds=[10.0, 20.0, 30.0], harmonics=[1, 2])
    assert rows.to_xarray()["pedestal y"].shape == (3, 2, 1)


def test_files_keep_the_values(response, tmp_path):
    import xarray as xr
    from scipy.io import loadmat

    response.save(tmp_path / "frf.nc")
    data = xr.open_dataset(tmp_path / "frf.nc", engine="h5netcdf")
    assert data["g4 z"].sel(part="imaginary", source="mesh g4/g5").values == pytest.approx(
        response.displacement("g4")[:, 1, 1].imag
    )
    response.save(tmp_path / "frf.mat")
    found = loadmat(tmp_path / "frf.mat", simplify_cells=True)
    curve = next(one for one in found["curves"] if (one["place"], one["direction"]) == ("g5", "y"))
    assert curve["values"] == pytest.approx(response.displacement("g5")[..., 0])
    response.save(tmp_path / "frf.csv")
    head, *lines = (tmp_path / "frf.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 2 * 40
    column = head.split(",").index("g5 y im [m]")
    found = [float(line.split(",")[column]) for line in lines[1::2]]
    assert found == pytest.approx(response.displacement("g5")[:, 1, 0].imag)
    head, first = response.table(1).splitlines()[:2]
    names = re.findall(r"(\S+) amplitude \[m\]", head)
    assert "g4" in names
    for name, text in zip(names, first.split()[-len(names) :], strict=True):
        shaft, is_position, x = name.partition("@")
        at = (shaft, float(x)) if is_position else name
        parts = [*response.displacement(at)[0, 0], response.axial_displacement(at)[0, 0]]
        assert float(text) == pytest.approx(np.linalg.norm(parts), rel=1e-3)  # four digits
    with pytest.raises(gb.SceneError, match="path: must end with"):
        response.save(tmp_path / "frf.txt")


def test_universal_files_are_read_again(response, tmp_path):
    pytest.importorskip("pyuff")
    response.save(tmp_path / "frf.uff", at=["g4", BETWEEN])
    compared = response.compare(tmp_path / "frf.uff")
    # places × (x, y, z, twist) × sources
    assert len(compared.measured) == 16
    # the file has 13 digits, its frequencies have at least 8
    assert compared.frac == pytest.approx(1.0, abs=1e-12)
    for measured, computed in zip(compared.measured, compared.computed, strict=True):
        np.testing.assert_allclose(
            measured.values, computed, rtol=1e-6, atol=1e-7 * np.abs(computed).max()
        )
    two = train().frequency_response([1.0, 2.0], source=gb.Force("pinion", 1.0), speed=[1.0, 2.0])
    with pytest.raises(gb.SceneError, match="path: a universal file holds a response at one speed"):
        two.save(tmp_path / "two.uff")


def test_pyuff_reads_the_functions_of_a_universal_file(response, tmp_path):
    pyuff = pytest.importorskip("pyuff")
    response.save(tmp_path / "frf.uff", at="g4")
    sets = pyuff.UFF(str(tmp_path / "frf.uff")).read_sets()
    sets = [each for each in sets if each["type"] == 58]
    moved = response.displacement("g4")
    for source in range(moved.shape[1]):
        # A file has functions for one newton and for one metre of transmission error.
        amplitude, denominator = ((1.0, (13, "N")), (1e-6, (8, "m")))[source]
        for direction in range(2):
            values = moved[:, source, direction] / amplitude
            matches = [
                each
                for each in sets
                if np.allclose(each["data"], values, rtol=1e-6, atol=1e-6 * np.abs(values).max())
            ]
            assert matches
            assert denominator == (
                matches[0]["orddenom_spec_data_type"],
                matches[0]["orddenom_axis_units_lab"],
            )
            # A field of 13 characters
            np.testing.assert_allclose(2.0 * np.pi * matches[0]["x"], FREQUENCIES, rtol=1e-9)


def test_directions_of_universal_files_have_numbers_and_signs(response, tmp_path):
    pyuff = pytest.importorskip("pyuff")
    path = tmp_path / "frf.uff"
    response.save(path, at="g4")
    file = pyuff.UFF(str(path))
    sets = [each for each in file.read_sets() if each["type"] == 58]
    moved = response.displacement("g4")
    expected = {2: moved[:, 0, 0], 3: moved[:, 0, 1], 4: response.twist("g4")[:, 0]}
    for number, values in expected.items():
        (own,) = [each for each in sets if (each["rsp_dir"], each["ref_node"]) == (number, 1)]
        # the file has 7 digits
        atol = 1e-6 * np.abs(values).max()
        np.testing.assert_allclose(own["data"], values, rtol=1e-6, atol=atol)
    # a sensor that looks along −y measures the opposite
    for each in sets:
        each["rsp_dir"], each["data"] = -each["rsp_dir"], -each["data"]
    file.write_sets(sets, mode="overwrite")
    turned = response.compare(path)
    assert turned.frac == pytest.approx(1.0, abs=1e-9)
    for curve in turned.measured:
        if curve.direction == "y" and curve.source == 0:
            atol = 1e-6 * np.abs(moved[:, 0, 0]).max()
            np.testing.assert_allclose(curve.values, moved[:, 0, 0], rtol=1e-6, atol=atol)


#: Data set 58 of the definitions of SDRC, records 6 to 11: nodes and directions of response and
#: reference, displacement in m, and in N or N m what it is divided by. Directions are 1, 2, 3 for
#: translations along x, y, z and 4, 5, 6 for rotations about them, negative for the opposite sense.
RECORDS = """\
    4         0    0         0 NONE      {response[0]:10d}{response[1]:4d} NONE      {reference[0]:10d}{reference[1]:4d}
         6{count:10d}         0  0.00000E+00  0.00000E+00  0.00000E+00
        18    0    0    0 NONE                 Hz
         8    0    0    0 NONE                 {unit}
        13    0    0    0 NONE                 {divisor}
         0    0    0    0 NONE                 NONE
"""


def measured_function(response, reference, values):
    """Give a data set 58 of another program; (node, direction) of response and reference."""
    unit, divisor = "rad" if abs(response[1]) > 3 else "m", "N m" if abs(reference[1]) > 3 else "N"
    records = RECORDS.format(
        response=response, reference=reference, count=len(values), unit=unit, divisor=divisor
    )
    rows = [
        f"{x:13.7f}{value.real:20.12E}{value.imag:20.12E}"
        for x, value in zip(FREQUENCIES[:3] / (2.0 * np.pi), values, strict=True)
    ]
    mark = "    -1\n"
    return mark + "    58\n" + 5 * "NONE\n" + records + "\n".join(rows) + "\n" + mark


def test_negative_directions_of_measured_functions_are_the_opposite_senses(tmp_path):
    # A sensor along −z measures −z; a hammer that strikes along −y pushes along −y.
    system = hostile()
    at = {1: "g4", 2: BETWEEN}
    along = {
        1: gb.Force(at[2], axial=1.0),
        2: gb.Force(at[2], 1.0),
        3: gb.Force(at[2], 1.0j),
        4: gb.Torque(at[2], 1.0),
    }
    found = system.frequency_response(FREQUENCIES[:3], source=list(along.values()), speed=-70.0)
    moved = found.displacement(at[1])
    receptance = {
        1: found.axial_displacement(at[1]),
        2: moved[..., 0],
        3: moved[..., 1],
        4: found.twist(at[1]),
    }
    cases = [
        (ahead * i, back * j, ahead * back * receptance[i][:, j - 1])
        for i in along
        for j in along
        for ahead in (1, -1)
        for back in (1, -1)
    ]
    path = tmp_path / "measured.uff"
    texts = [measured_function((1, i), (2, j), values) for i, j, values in cases]
    path.write_text("".join(texts), encoding="utf-8")
    compared = found.compare(path, places=at)
    for (i, j, _), measured, computed in zip(
        cases, compared.measured, compared.computed, strict=True
    ):
        sense = np.sign(j)
        expected = sense * receptance[abs(i)][:, abs(j) - 1]
        source = along[abs(j)]
        if abs(j) == 4:
            assert measured.source == gb.Torque(at[2], sense)
        else:
            assert measured.source == gb.Force(
                at[2], sense * source.value, axial=sense * source.axial
            )
        assert measured.direction == ("x", "y", "z", "twist")[abs(i) - 1]
        # 12 digits, and frequencies of 7 digits after the point
        np.testing.assert_allclose(measured.values, expected, rtol=1e-9)
        np.testing.assert_allclose(computed, expected, rtol=1e-6)
    # no source turns a shaft about y, and no response is an angle about z
    for reference in (5, -5, 6, -6):
        path.write_text(measured_function((1, 2), (2, reference), moved[:, 0, 0]), encoding="utf-8")
        with pytest.raises(gb.SceneError, match=rf"no source in the direction {reference}"):
            found.compare(path, places=at)
    for response in (5, -5, 6, -6):
        path.write_text(measured_function((1, response), (2, 2), moved[:, 0, 0]), encoding="utf-8")
        with pytest.raises(gb.SceneError, match="no frequency response function of a motion"):
            found.compare(path, places=at)


def test_a_universal_file_has_the_function_of_one_newton_along_each_force(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    # direction and size of the reference; an oblique force has no direction
    forces = {
        (-2, 3.0): gb.Force("g4", -3.0),
        (-3, 4.0): gb.Force("g4", -4.0j),
        (-1, 2.0): gb.Force("g4", axial=-2.0),
        (2, 3.0j): gb.Force("g4", (3.0j, 0.0)),
        (0, 5.0): gb.Force("g4", 3.0 - 4.0j),
    }
    found = hostile().frequency_response(FREQUENCIES[:3], source=list(forces.values()), speed=-70.0)
    found.save(tmp_path / "frf.uff", at=BETWEEN)
    sets = [each for each in pyuff.UFF(str(tmp_path / "frf.uff")).read_sets() if each["type"] == 58]
    moved = found.displacement(BETWEEN)
    for source, (direction, size) in enumerate(forces):
        for axis in range(2):
            (own,) = [
                each
                for each in sets
                if (each["ref_node"], each["rsp_dir"]) == (source + 1, axis + 2)
            ]
            assert (own["rsp_node"], own["ref_dir"]) == (1, direction)
            expected = moved[:, source, axis] / size
            # the file has 7 digits
            atol = 1e-6 * np.abs(expected).max()
            np.testing.assert_allclose(own["data"], expected, rtol=1e-6, atol=atol)
    # what is read again are the phasors of the forces themselves
    assert found.compare(tmp_path / "frf.uff").frac == pytest.approx(1.0, abs=1e-9)


def test_a_measured_response_is_compared(response, tmp_path):
    acceleration = response.acceleration(BETWEEN)[:, 0]
    parts = [f"middle@0.2137 {axis} {part} [m/s²]" for axis in "yz" for part in ("re", "im")]
    lines = [",".join(["frequency [Hz]", *parts])]
    for w, (y, z) in zip(FREQUENCIES, acceleration, strict=True):
        values = (w / (2.0 * np.pi), 2.0 * y.real, 2.0 * y.imag, z.real, -z.imag)
        lines.append(",".join(repr(float(value)) for value in values))
    path = tmp_path / "measured.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    compared = response.compare(path)
    # A factor does not change FRAC; the conjugate is another function.
    assert compared.frac[0] == pytest.approx(1.0, abs=1e-12)
    assert compared.frac[1] < 0.9
    assert compared.computed[0] == pytest.approx(acceleration[:, 0])
    shapes = np.array([one.values for one in compared.measured]), np.array(compared.computed)
    cross = np.abs(np.sum(np.conj(shapes[0]) * shapes[1], axis=0)) ** 2
    sizes = np.prod([np.sum(np.abs(shape) ** 2, axis=0) for shape in shapes], axis=0)
    assert compared.mac == pytest.approx(cross / sizes)
    assert len(compared.plot().axes[0].lines) == 4
    path.write_text("frequency [Hz],in y\n1,2\n", encoding="utf-8")
    with pytest.raises(gb.SceneError, match="'in y' is no heading"):
        response.compare(path)


def test_figures(response):
    upper, lower = response.plot(["g4", "g5"], direction="y").axes
    assert len(upper.lines) == 4
    assert upper.lines[0].get_ydata() == pytest.approx(
        1e6 * np.abs(response.displacement("g4")[:, 0, 0])
    )
    assert upper.get_ylabel() == "displacement [µm]"
    assert lower.get_xlabel() == "frequency [Hz]"
    assert response.plot("g4/g5").axes[0].get_ylabel() == "force [N]"
    nyquist = response.plot(gb.Accelerometer(BETWEEN), kind="nyquist").axes[0]
    assert nyquist.get_xlabel() == "real part [m/s²]"
    with pytest.raises(gb.GearbowError, match="a waterfall needs a response at several speeds"):
        response.plot("g4", kind="waterfall")
    speeds = [10.0, 50.0, 90.0]
    several = train().frequency_response(FREQUENCIES, source=gb.Force("pinion", 1.0), speed=speeds)
    assert several.displacement("wheel").shape == (3, 40, 1, 2)
    assert len(several.plot("wheel", kind="waterfall").axes) == 2
    assert len(several.plot("wheel").axes[0].lines) == 3
    orders = train().mesh_response("pinion/wheel", speeds=speeds, harmonics=[1, 2])
    assert len(orders.plot(("out", 0.5), "bearing_force").axes[0].lines) == 2


def code(*arguments: str) -> int:
    """Return the exit code of the program."""
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    return int(ended.value.code or 0)


def test_the_command_prints_and_draws(tmp_path, capsys):
    scene, figure = tmp_path / "train.toml", tmp_path / "frf.png"
    train().save(scene)
    arguments = ["response", str(scene), "--source", "in:0.1:y", "--at", "pinion"]
    arguments += ["--from", "1Hz", "--to", "0.8kHz", "--points", "50"]
    assert code(*arguments, "--plot", str(figure), "--speed", "70") == 0
    assert "largest response at pinion to in:0.1:y:" in capsys.readouterr().out
    assert figure.stat().st_size > 10_000
    assert code(*arguments, "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert data["frequencies"][-1] == pytest.approx(2.0 * np.pi * 800.0)
    arguments[3] = "in:0.1:up"
    assert code(*arguments) == 2
    assert "--source: must be a place and a direction" in capsys.readouterr().err
