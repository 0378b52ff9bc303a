"""Files of systems and responses are read back bit for bit."""

from __future__ import annotations

import copy
import json
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from gearbow.description.speed import plain_speed
from gearbow.recording.channels import arrays_of
from reference.machines import bowed_pair, hostile, rotor
from test_response import recorded


def assert_same(read: gb.Response, written: gb.Response) -> None:
    """Compare all data of a response bit by bit."""

    def walk(a: object, b: object, path: str) -> None:
        assert type(a) is type(b), path
        if isinstance(a, dict):
            assert a.keys() == b.keys(), path
            for key in a:
                walk(a[key], b[key], f"{path}.{key}")
        elif isinstance(a, np.ndarray):
            assert (a.dtype, a.shape) == (b.dtype, b.shape), path
            assert a.tobytes() == b.tobytes(), path
        else:
            assert a == b or a != a, path  # noqa: PLR0124  # NaN

    walk(read._data, written._data, "response")
    assert plain_speed(read.speed) == plain_speed(written.speed)
    assert read.recorded == written.recorded


@pytest.mark.parametrize("rows", [0, 5])
@pytest.mark.parametrize("energy", [True, False])
def test_a_response_is_read_back_bit_for_bit(tmp_path, rows, energy):
    written = recorded(rows=rows, energy=energy)
    path = tmp_path / "response.npz"
    written.save(path)
    assert_same(gb.Response.load(path), written)


def test_a_loaded_response_continues_like_the_saved_one(tmp_path):
    system = hostile()
    first = system.simulate(2e-3, -100.0, output_step=1e-4, record=["gears", "meshes", "bearings"])
    path = tmp_path / "first.npz"
    first.save(path)
    loaded = gb.Response.load(path)
    assert_same(loaded, first)
    going_on = system.simulate(1e-3, -100.0, output_step=1e-4, initial=first)
    gone_on = system.simulate(1e-3, -100.0, output_step=1e-4, initial=loaded)
    assert_same(gone_on, going_on)
    assert going_on.time[0] == first.final["time"]
    assert np.ptp(going_on.displacement("g1"), axis=0).min() > 0.0


def test_a_file_of_another_kind_is_refused(tmp_path):
    response = recorded()
    with pytest.raises(gb.GearbowError, match=r"^path: must end with \.npz, \.csv, \.xlsx or \.nc"):
        response.save(tmp_path / "response.txt")
    np.savez(tmp_path / "other.npz", time=np.zeros(3))
    with pytest.raises(gb.GearbowError, match="not a response of gearbow"):
        gb.Response.load(tmp_path / "other.npz")
    with pytest.raises(FileNotFoundError):
        gb.Response.load(tmp_path / "missing.npz")


@pytest.mark.parametrize("energy", [True, False])
def test_a_netcdf_file_contains_the_run_bit_for_bit(tmp_path, energy):
    xarray = pytest.importorskip("xarray")
    written, path = recorded(energy=energy), tmp_path / "response.nc"
    written.save(path)
    with xarray.open_dataset(path, engine="h5netcdf", decode_times=False) as data:
        assert {*data.variables} == {*written.to_xarray().variables}
        for name, values in arrays_of(written._to_record()).items():
            assert not values.size or data[name].values.tobytes() == values.tobytes(), name
        assert json.loads(data.attrs["metadata"])["points"][0][2] == ["g1"]
    with pytest.raises(gb.GearbowError, match=r"response\.nc is netCDF.*give a file \.npz"):
        gb.Response.load(path)


def test_netcdf_files_contain_units(tmp_path):
    xarray = pytest.importorskip("xarray")
    recorded().save(tmp_path / "response.nc")
    with xarray.open_dataset(
        tmp_path / "response.nc", engine="h5netcdf", decode_times=False
    ) as data:
        assert data["displacement"].dims == ("time", "point", "axis")
        assert data["displacement"].attrs["units"] == "m"
        assert data["mesh_pressure_angle"].attrs["units"] == "rad"
        assert list(data["point"].values) == ["g1", "g2", "input@0.1"]
        assert list(data["mesh"].values) == ["g4/g5", "g1/g2"]


@pytest.mark.parametrize(
    "bow", [gb.Bow.half_sine(1e-4, 0.3), gb.Bow.function(lambda x: 1e-4j * x * (0.5 - x))]
)
def test_a_system_is_read_back_unchanged(tmp_path, bow):
    system = hostile()
    system = system.replace(shafts=[replace(shaft, bow=bow) for shaft in system.shafts])
    system.save(tmp_path / "train.toml")
    loaded = gb.RotorSystem.load(tmp_path / "train.toml")
    assert loaded.description == system.description
    assert loaded.gears == system.gears
    assert loaded.meshes == system.meshes
    assert loaded.torques == system.torques
    assert [shaft.name for shaft in loaded.shafts] == ["input", "idler", "middle", "output"]
    a, b = (s.synchronous([100.0, -80.0]).amplitudes for s in (loaded, system))
    assert a.tobytes() == b.tobytes()
    assert np.abs(b).max() > 1e-6


def test_a_hand_written_file_has_the_names_of_the_parameters(tmp_path):
    (tmp_path / "rotor.toml").write_text(
        """
        modal_damping = 0.01
        [[shafts]]
        name = "rotor"
        length = 1.0
        outer_diameter = 0.05
        elements = 4
        bow = { shape = "half_sine", amplitude = 1e-4, phase = 0.5 }
        [[bearings]]
        shaft = "rotor"
        position = 0.0
        stiffness = [1e8, 2e8]
        [[bearings]]
        shaft = "rotor"
        position = 1.0
        stiffness = 1e8
        """,
        encoding="utf-8",
    )
    system = gb.RotorSystem.load(tmp_path / "rotor.toml")
    assert system.shafts[0].bow == gb.Bow.half_sine(1e-4, phase=0.5)
    assert list(system.bearings[0].stiffness) == [1e8, 2e8]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("shafts = 3", "shafts"),
        ("this is not TOML", "toml"),
        (
            "[[shafts]]\nname = 'a'\nlength = nan\nouter_diameter = 0.05\nelements = 2",
            r"^shafts\[0\].length",
        ),
    ],
)
def test_an_invalid_file_is_a_scene_error(tmp_path, text, message):
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    with pytest.raises(gb.SceneError, match=message):
        gb.RotorSystem.load(tmp_path / "scene.toml")


def test_numbers_with_all_digits_are_read_back_exactly():
    tenth = math.fsum([0.1] * 3)
    assert tenth != 0.3
    system = bowed_pair(bow=gb.Bow.half_sine(1e-4, phase=tenth))
    again = gb.RotorSystem._from_model(type(system._model).from_toml(system._model.to_toml()))
    assert again.description["shafts"][0]["bow"]["phase"] == tenth


def test_a_steady_state_goes_through_pickle():
    shaft = {"elements": 2, "bow": gb.Bow.half_sine(1e-4)}
    system = rotor(shaft, bearing={"stiffness": 1e8, "damping": 1e3})
    steady = system.steady_state(100.0, record=[("rotor", 0.5)])
    for found in (pickle.loads(pickle.dumps(steady)), copy.deepcopy(steady)):
        assert_same(found.response, steady.response)
        assert (found.period, found.method) == (steady.period, steady.method)
        np.testing.assert_array_equal(found.multipliers(), steady.multipliers())
