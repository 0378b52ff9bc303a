"""Mode shapes in universal files, and MAC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from reference.machines import hostile
from test_frequency_response import train


def test_mac_is_that_of_the_definition_and_leaves_out_what_was_not_measured():
    modes = train().modes(80.0, count=5)
    places = (("in", 0.07), "wheel", "pedestal")
    shapes = modes.shapes_at(places)
    random = np.random.default_rng(3)
    noisy = (2.0 - 1j) * shapes + 0.2 * np.abs(shapes).max() * random.normal(size=shapes.shape)
    noisy[:, 1, 0] = np.nan
    found = modes.compare(gb.results.MeasuredShapes(places, modes.frequencies_hz + 1.0, noisy))
    kept = [0, 1, 3, 4, 5]
    a, b = (each.reshape(5, -1)[:, kept] for each in (shapes, noisy))
    for i in range(5):
        for j in range(5):
            value = abs(np.vdot(b[j], a[i])) ** 2 / (np.vdot(a[i], a[i]) * np.vdot(b[j], b[j])).real
            assert found.mac[i, j] == pytest.approx(value, rel=1e-12)
    assert found.measured_hz == pytest.approx(found.computed_hz + 1.0)


def test_modes_of_another_model_are_compared_at_gears():
    system = train()
    stiffer = system.replace(
        bearings=[*system.bearings[:3], gb.Bearing("out", 0.5, stiffness=1.5e8)]
    )
    found = system.modes(count=6).compare(stiffer.modes(count=6))
    assert [pair[0] for pair in found.pairs[1:3]] == [2, 3]
    assert "MAC" in found.table()
    panel = found.plot().axes[0]
    assert panel.get_xlabel() == "computed mode"


def test_a_universal_file_keeps_shapes(tmp_path: Path):
    pytest.importorskip("pyuff")
    system = train()
    modes = system.modes(80.0, count=6)
    modes.save(tmp_path / "modes.uff")
    # five digits of the format
    found = modes.compare(tmp_path / "modes.uff")
    moving = modes.frequencies_hz > 0.0
    assert np.diag(found.mac)[moving] == pytest.approx(np.ones(moving.sum()), abs=1e-9)
    assert found.measured_hz == pytest.approx(modes.frequencies_hz, rel=1e-5)
    # nodes of another program need places
    named = {1: ("in", 0.0), 3: "pinion"}
    fewer = modes.compare(tmp_path / "modes.uff", places=named)
    assert fewer.mac.shape == (6, 6)
    import pyuff

    sets = pyuff.UFF(str(tmp_path / "modes.uff")).read_sets()
    nodes, first = sets[0], sets[1]
    assert nodes["type"] == 2411
    assert first["type"] == 55
    at = [node for node in dict.fromkeys((s, x) for s, x, _ in system.dofs) if node[0] == "out"]
    centre = system.meshes and float(nodes["y"][-1] ** 2 + nodes["z"][-1] ** 2) ** 0.5
    assert len(at) > 2
    assert centre > 0.1
    shape = modes.displacement(("in", 0.0))[0]
    assert first["r2"][0] == pytest.approx(shape[0], rel=1e-4, abs=1e-5 * np.abs(shape).max())


def test_every_shape_that_pyuff_reads_is_that_of_the_mode(tmp_path: Path):
    pyuff = pytest.importorskip("pyuff")
    system = hostile()
    modes = system.modes(-80.0, count=8)
    modes.save(tmp_path / "modes.uff")
    nodes, *sets = pyuff.UFF(str(tmp_path / "modes.uff")).read_sets()
    assert [each["mode_n"] for each in sets] == list(range(1, 9))
    named = [float(each["id2"].removesuffix(" Hz")) for each in sets]
    assert named == pytest.approx(modes.frequencies_hz, rel=1e-8)
    places = list(dict.fromkeys((shaft, x) for shaft, x, kind in system.dofs if kind == "v"))
    assert len(nodes["x"]) == len(places)
    along = modes.shapes[:, [system.dofs.index((*place, "u")) for place in places]]
    across = np.stack([modes.displacement(place) for place in places], axis=1)
    own = np.concatenate([along[..., np.newaxis], across], axis=-1)
    read = np.array([[each["r1"], each["r2"], each["r3"]] for each in sets]).swapaxes(1, 2)
    flat = [shapes.reshape(len(sets), -1) for shapes in (own, read)]
    cross = np.abs(flat[0].conj() @ flat[1].T) ** 2
    sizes = [np.sum(np.abs(shapes) ** 2, axis=1) for shapes in flat]
    lateral = sizes[0] > 1e-12 * sizes[0].max()
    mac = (cross / np.maximum(np.outer(*sizes), 1e-300))[np.ix_(lateral, lateral)]
    # The format has five digits.
    assert np.diag(mac) == pytest.approx(np.ones(lateral.sum()), abs=1e-9)
    exact = np.abs(flat[0].conj() @ flat[0].T) ** 2 / np.maximum(
        np.outer(sizes[0], sizes[0]), 1e-300
    )
    np.testing.assert_allclose(mac, exact[np.ix_(lateral, lateral)], atol=2e-5)
    values = np.array([complex(each["eig"]) for each in sets])
    np.testing.assert_allclose(values, modes.eigenvalues, rtol=1e-4, atol=1e-4)


def test_wrong_measured_shapes_are_refused(tmp_path: Path):
    modes = train().modes(count=3)
    with pytest.raises(gb.SceneError, match="measured: must be a universal file"):
        modes.compare(3.0)  # type: ignore[arg-type]
    with pytest.raises(gb.SceneError, match="places: belongs to a universal file"):
        modes.compare(modes, places={1: "pinion"})
    shaft = gb.Shaft("s", length=0.5, outer_diameter=0.03)
    with pytest.raises(gb.GearbowError, match="torsion has not"):
        gb.RotorSystem([shaft], motion="torsion").modes().save(tmp_path / "modes.uff")
