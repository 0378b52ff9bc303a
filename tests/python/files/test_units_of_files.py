"""Units, labels and metadata of data sets, tables and files against a hand-written table."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from gearbow.recording.record import OPTIONS, ErrorEstimate, Errors, RunRequest
from reference.records import ENERGIES, KINEMATICS, MESH_UNITS, WORKS, response

TIME = 2.0 + 0.25 * np.arange(5)

#: Unit and axes of every variable of a data set.
VARIABLES = {
    "displacement": ("m", ("time", "point", "axis")),
    "twist": ("rad", ("time", "point")),
    "bearing_force": ("N", ("time", "bearing", "axis")),
    "energy": ("J", ("time",)),
    **{f"energy_{name}": ("J", ("time",)) for name in (*ENERGIES, *WORKS)},
    **{f"mesh_{name}": (unit, ("time", "mesh")) for name, unit in MESH_UNITS.items()},
}
POINTS = {"g1": 0, "g2": 1, "g3+wheel": 2, "output@0.3": 3}
MESHES = {"g1/g2": 0, "g3/g4": 1}
BEARINGS = {"input@0": 0, "output@0.5": 1}


def check_dataset(dataset, made: gb.Response) -> None:
    """Compare a data set with the response that it is made from."""
    data = made._data
    found = {
        name: (dataset[name].attrs["units"], dataset[name].dims)
        for name in dataset.data_vars
        if not name.startswith("final_")
    }
    assert found == VARIABLES
    assert dataset["time"].attrs["units"] == "s"
    np.testing.assert_array_equal(dataset["time"], TIME)
    for name, series in data["mesh"].items():
        for mesh, i in MESHES.items():
            np.testing.assert_array_equal(dataset[f"mesh_{name}"].sel(mesh=mesh), series[:, i])
    for point, i in POINTS.items():
        np.testing.assert_array_equal(dataset["twist"].sel(point=point), data["twist"][:, i])
        for component, axis in enumerate(("y", "z")):
            np.testing.assert_array_equal(
                dataset["displacement"].sel(point=point, axis=axis),
                data["displacement"][:, i, component],
            )
    for bearing, i in BEARINGS.items():
        for component, axis in enumerate(("y", "z")):
            np.testing.assert_array_equal(
                dataset["bearing_force"].sel(bearing=bearing, axis=axis),
                data["bearing_force"][:, i, component],
            )
    np.testing.assert_array_equal(dataset["energy"], data["energy"])
    for name, series in data["energy_terms"].items():
        np.testing.assert_array_equal(dataset[f"energy_{name}"], series)


def test_a_data_set_has_units_and_labels():
    made = response(TIME)
    check_dataset(made.to_xarray(), made)


def test_a_netcdf_file_has_units_and_labels(tmp_path):
    xarray = pytest.importorskip("xarray")
    made = response(TIME)
    made.save(tmp_path / "run.nc")
    # without the default decoding, as another program reads it
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf", decode_times=False) as dataset:
        check_dataset(dataset, made)
        np.testing.assert_array_equal(dataset["final_state"], np.arange(4.0))
        # no value marks missing data
        assert all("_FillValue" not in dataset[name].encoding for name in VARIABLES)


def test_a_table_has_a_column_for_every_series():
    made = response(TIME)
    data, table = made._data, made.to_dataframe()
    expected: dict[str, np.ndarray] = {}
    # a point with two names has its columns under each of them
    for name, i in (("g1", 0), ("g2", 1), ("g3", 2), ("wheel", 2), ("output@0.3", 3)):
        expected[f"{name} y [m]"] = data["displacement"][:, i, 0]
        expected[f"{name} z [m]"] = data["displacement"][:, i, 1]
        expected[f"{name} twist [rad]"] = data["twist"][:, i]
    for pair, i in MESHES.items():
        for name, unit in MESH_UNITS.items():
            expected[f"{pair} {name} [{unit}]"] = data["mesh"][name][:, i]
    for place, i in BEARINGS.items():
        expected[f"{place} force_y [N]"] = data["bearing_force"][:, i, 0]
        expected[f"{place} force_z [N]"] = data["bearing_force"][:, i, 1]
    expected["energy [J]"] = data["energy"]
    for kind, names in (("energy", ENERGIES), ("work", WORKS)):
        for name in names:
            expected[f"{kind} {name} [J]"] = data["energy_terms"][name]
    assert set(table.columns) == set(expected)
    assert table.index.name == "time [s]"
    np.testing.assert_array_equal(table.index, TIME)
    for column, values in expected.items():
        np.testing.assert_array_equal(table[column], values, err_msg=column)


def test_a_file_contains_the_metadata(tmp_path):
    made = response(TIME, speed=-123.25)
    made.accuracy = "engineering: as measured"
    estimate = ErrorEstimate(elements=1e-3, modes=0.0, integration=1e-5, total=2e-3)
    made._errors = Errors({"mesh_force": estimate}, window=0.125, chaotic=True)
    final = {"state": np.array([0.1, 1e-300]), "contact_modes": np.array([-1]), "time": 0.5}
    options = {**dict.fromkeys(OPTIONS), "initial": final, "record": [("g1", "g2"), "g1"]}
    made.request = RunRequest({"shafts": [{"name": "input"}]}, options)
    made.save(tmp_path / "run.npz")
    loaded = gb.Response.load(tmp_path / "run.npz")
    assert loaded.speed == -123.25
    assert loaded.errors() == {"mesh_force": estimate}
    assert loaded.errors().window == 0.125
    assert loaded.errors().chaotic
    assert loaded.request.description == made.request.description
    given = dict(loaded.request.options)
    for name, value in final.items():
        np.testing.assert_array_equal(given["initial"][name], value)
    assert {**given, "initial": final} == options
    assert loaded.accuracy == "engineering: as measured"
    assert loaded.kinematics == KINEMATICS
    assert loaded.events == ((0.25, "g3", "g4", "separation"), (0.5, "g1", "g2", "contact"))
    assert loaded.statistics == made.statistics
    assert loaded.final["method"] == "rk45"
    assert loaded.recorded == made.recorded
    for name in ("g2", ("output", 0.3)):
        np.testing.assert_array_equal(loaded.displacement(name), made.displacement(name))
    np.testing.assert_array_equal(loaded.time, TIME)
