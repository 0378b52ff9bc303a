"""The accuracy levels on some of the scenes of `make accuracy`."""

import sys
from pathlib import Path

import pytest

from gearbow.accuracy.levels import LEVELS

sys.path.insert(0, str(Path(__file__).parents[2] / "benches"))

from accuracy.measure import measure
from accuracy.scenes import SCENES


@pytest.mark.parametrize("level", ["draft", "engineering"])
@pytest.mark.parametrize("name", ["stepped pair", "heavy wheel", "rotor"])
def test_a_level_keeps_its_total_error_and_estimates_it(name, level):
    found = measure(SCENES[name], LEVELS[level])
    permitted = {
        "displacement": LEVELS[level].displacement,
        "mesh_force": LEVELS[level].mesh_force,
    }
    assert found.true
    for kind, error in found.true.items():
        assert error <= permitted[kind]
        assert error / 3 < found.estimated[kind] < 3 * error
