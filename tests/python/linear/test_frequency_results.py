"""Frequency response as tables, files, figures and comparisons, and the command `gearbow response`."""

from __future__ import annotations

import json

import numpy as np
import pytest

import gearbow as gb
from gearbow.cli.main import main
from test_frequency_response import train

FREQUENCIES = 2.0 * np.pi * np.linspace(20.0, 800.0, 40)


@pytest.fixture(scope="module")
def response():
    sources = [gb.Force(("in", 0.1), 1.0), gb.MeshExcitation("pinion/wheel")]
    return train().frequency_response(FREQUENCIES, source=sources, speed=70.0)


def test_tables_have_every_place_frequency_and_source(response):
    table = response.to_dataframe()
    assert len(table) == 2 * FREQUENCIES.size
    own = table[table["source"] == "mesh pinion/wheel"]
    assert own["pinion/wheel mesh force [N]"].to_numpy() == pytest.approx(
        response.mesh_force("pinion/wheel")[:, 1]
    )
    assert own["in@0.4 bearing force z [N]"].to_numpy() == pytest.approx(
        response.bearing_force(("in", 0.4))[:, 1, 1]
    )
    assert list(response.to_dataframe(("out", 0.33)).columns[3:]) == [
        "out@0.33 y [m]",
        "out@0.33 z [m]",
        "out@0.33 twist [rad]",
    ]
    data = response.to_xarray()
    assert data["wheel y"].dims == ("frequency", "source")
    assert data["wheel y"].sel(source="force at in at 0.1 m").values == pytest.approx(
        response.displacement("wheel")[:, 0, 0]
    )
    rows = train().mesh_response("pinion/wheel", speeds=[10.0, 20.0, 30.0], harmonics=[1, 2])
    assert rows.to_xarray()["pedestal y"].shape == (3, 2, 1)


def test_files_keep_the_values(response, tmp_path):
    import xarray as xr
    from scipy.io import loadmat

    response.save(tmp_path / "frf.nc")
    data = xr.open_dataset(tmp_path / "frf.nc", engine="h5netcdf")
    assert data["pinion z"].sel(
        part="imaginary", source="mesh pinion/wheel"
    ).values == pytest.approx(response.displacement("pinion")[:, 1, 1].imag)
    response.save(tmp_path / "frf.mat")
    found = loadmat(tmp_path / "frf.mat", simplify_cells=True)
    curve = next(
        one for one in found["curves"] if (one["place"], one["direction"]) == ("wheel", "y")
    )
    assert curve["values"] == pytest.approx(response.displacement("wheel")[..., 0])
    response.save(tmp_path / "frf.csv", at="pinion")
    assert (tmp_path / "frf.csv").read_text(encoding="utf-8").count("\n") == 2 * 40 + 1
    assert "pinion amplitude" in response.table(3)
    with pytest.raises(gb.SceneError, match="path: must end with"):
        response.save(tmp_path / "frf.txt")


def test_universal_files_are_read_again(response, tmp_path):
    pytest.importorskip("pyuff")
    response.save(tmp_path / "frf.uff", at=["pinion", ("in", 0.33)])
    compared = response.compare(tmp_path / "frf.uff")
    # places × (y, z, twist) × sources
    assert len(compared.measured) == 12
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
    response.save(tmp_path / "frf.uff", at="pinion")
    sets = pyuff.UFF(str(tmp_path / "frf.uff")).read_sets()
    sets = [each for each in sets if each["type"] == 58]
    moved = response.displacement("pinion")
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


def test_a_measured_response_is_compared(response, tmp_path):
    acceleration = response.acceleration(("in", 0.33))[:, 0]
    lines = [
        "frequency [Hz],in@0.33 y re [m/s²],in@0.33 y im [m/s²],in@0.33 z re [m/s²],in@0.33 z im [m/s²]"
    ]
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
    upper, lower = response.plot(["pinion", "wheel"], direction="y").axes
    assert len(upper.lines) == 4
    assert upper.lines[0].get_ydata() == pytest.approx(
        1e6 * np.abs(response.displacement("pinion")[:, 0, 0])
    )
    assert upper.get_ylabel() == "displacement [µm]"
    assert lower.get_xlabel() == "frequency [Hz]"
    assert response.plot("pinion/wheel").axes[0].get_ylabel() == "force [N]"
    nyquist = response.plot(gb.Accelerometer("pedestal"), kind="nyquist").axes[0]
    assert nyquist.get_xlabel() == "real part [m/s²]"
    with pytest.raises(gb.GearbowError, match="a waterfall needs a response at several speeds"):
        response.plot("pinion", kind="waterfall")
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
