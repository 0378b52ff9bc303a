"""Missing optional libraries: the error gives the install command before any computation."""

from __future__ import annotations

import sys

import pytest

import gearbow as gb
from reference.processes import assert_done
from test_file_failures import names
from test_response import recorded

EXTRAS = """
import sys
from reference.machines import bowed_pair
from test_response import recorded

missing = sys.argv[1].split(",")
for name in [name for name in sys.modules if name.partition(".")[0] in missing]:
    del sys.modules[name]

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in missing:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
import gearbow as gb
system, response = bowed_pair(), recorded()
run = system.simulate(1e-3, 100.0, output_step=1e-5, record=["gears", "meshes", "energy"])
speeds = [50.0, 100.0, 150.0]
modes, campbell, synchronous = system.modes(), system.campbell(speeds), system.synchronous(speeds)
spectrum, folder = run.spectrum("g1"), sys.argv[2]
sweep = gb.sweep(dict, {"a": [1.0, 2.0]}, lambda system, a: a)
calls = {
    "plot": [
        response.plot, modes.plot, campbell.plot, lambda: synchronous.plot("g1"),
        lambda: synchronous.bode("g1"), spectrum.plot,
        run.energy_balance().plot, system.critical_speed_map([1e7, 1e8]).plot,
        system.plot, lambda: run.animate(f"{folder}/run.gif"),
    ],
    "netcdf": [
        response.to_xarray,
        lambda: response.save(f"{folder}/run.nc"),
        lambda: modes.save(f"{folder}/modes.nc"),
    ],
    "matlab": [
        lambda: system.frequency_response([9.0], source=gb.Force("g1", 1.0)).save(f"{folder}/x.mat")
    ],
    "sweep": [sweep.to_xarray],
    "report": [lambda: system.report(f"{folder}/report.html")],
    "dataframe": [
        response.to_dataframe, modes.to_dataframe, campbell.to_dataframe, run.energy_balance().to_dataframe,
        sweep.to_dataframe, lambda: modes.save(f"{folder}/modes.csv"),
        lambda: gb.SpeedTable.read_table("x.xlsx"), lambda: gb.Bow.read_table("x.xlsx"),
    ],
}
for call in calls[sys.argv[3]]:
    try:
        call()
    except gb.MissingExtraError as error:
        assert f'pip install "gearbow[{sys.argv[3]}]"' in str(error), error
        assert isinstance(error, ImportError) and error.name.partition(".")[0] in missing, error.name
        continue
    raise SystemExit(f"{call} needs none of {missing}")
print("done")
"""


@pytest.mark.parametrize(
    ("extra", "missing"),
    [
        ("plot", "matplotlib"),
        ("netcdf", "xarray,h5netcdf,h5py"),
        ("dataframe", "pandas"),
        ("matlab", "scipy"),
        ("sweep", "xarray,pandas"),
        ("report", "jinja2"),
        ("report", "matplotlib"),
    ],
)
def test_the_error_says_how_to_install_a_missing_library(tmp_path, extra, missing):
    assert_done(EXTRAS, missing, tmp_path, extra)
    assert names(tmp_path) == []


@pytest.mark.parametrize("missing", ["xarray", "h5netcdf", "h5py"])
def test_an_export_without_one_of_its_libraries_leaves_no_file(tmp_path, monkeypatch, missing):
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(gb.MissingExtraError, match=r'pip install "gearbow\[netcdf\]"'):
        recorded().save(tmp_path / "run.nc")
    assert names(tmp_path) == []
