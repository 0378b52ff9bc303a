"""Figures, tables, reports and animations of a system with an elastic housing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from reference.elastic import system

pytest.importorskip("matplotlib")
pytest.importorskip("scipy")


@pytest.fixture(scope="module")
def housed() -> gb.RotorSystem:
    return system("housing", sensor=True)


def test_the_train_shows_the_housing_and_the_interfaces_without_bearings(housed: gb.RotorSystem):
    panel = housed.plot().axes[0]
    words = {text.get_text() for text in panel.texts}
    assert {"housing", "sensor"} <= words
    assert not {"left seat", "2 mm"} & words  # where the symbols of the bearings are


def test_a_mode_in_space_draws_the_motion_of_every_interface(housed: gb.RotorSystem):
    modes = housed.modes()
    number = 1 + modes.names().index("housing")
    figure = modes.plot(number)
    ends = np.array(
        [
            np.array(line.get_data_3d())[:, -1]
            for line in figure.axes[0].lines
            if line.get_marker() == "s"
        ]
    ).real
    assert ends.shape[0] == 3
    body = housed.housings[0].elastic
    assert body is not None
    rest = np.array([each["position"] for each in body.interfaces.values()])
    moved = [
        [
            housed.coordinates.axial_displacement(modes.shapes[number - 1], name),
            *modes.shapes_at([name])[number - 1, 0],
        ]
        for name in body.interfaces
    ]
    shape = np.array(moved)
    # in phase: the drawing is the real shape times one factor
    drawn = (ends - rest).ravel()
    factor = shape.ravel() @ drawn / (shape.ravel() @ shape.ravel().conj())
    np.testing.assert_allclose(drawn, np.real(np.conj(factor) * shape.ravel()), atol=1e-6)


def test_tables_and_names(housed: gb.RotorSystem):
    modes = housed.modes()
    assert "housing" in modes.names()
    assert modes.plot() is not None
    shares = modes.energy_shares()
    np.testing.assert_allclose(sum(shares.values()), 1.0, rtol=1e-9)
    text = str(housed.replace(gravity=9.81).static())
    assert "sensor" in text
    assert "left seat" in text
    with pytest.raises(gb.SceneError, match='"housing" belongs to an elastic housing, of which'):
        modes.displacement("housing")


def test_a_report(housed: gb.RotorSystem, tmp_path: Path):
    pytest.importorskip("plotly")
    path = tmp_path / "report.html"
    housed.report(path, operating=100.0, speeds=np.linspace(20.0, 200.0, 4), modes=3)
    assert "Traceback" not in path.read_text(encoding="utf-8")
