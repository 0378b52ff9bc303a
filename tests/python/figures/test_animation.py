"""Animations: frames of the recorded motion, files, and errors before anything is drawn."""

from __future__ import annotations

import base64
import json
import re
from math import pi

import numpy as np
import pytest
from PIL import Image

import gearbow as gb
from gearbow.results import run_figures
from reference import machines
from reference.cases import each_case
from reference.machines import hostile
from test_response import recorded

SPEED = 100.0
RECORD = ["gears", "meshes"]


@pytest.fixture(scope="module")
def run() -> gb.Response:
    return hostile().simulate(0.25, SPEED, output_step=1e-3, record=RECORD, rtol=1e-4)


@pytest.fixture(scope="module")
def rotor() -> gb.Response:
    """Return a run-up of a rotor with a disk, without any mesh."""
    disk = machines.inertia(10.0, 0.05, 0.1, unbalance=1e-3)
    system = machines.rotor({"elements": 2}, disk, {"stiffness": 1e8, "damping": 1e3})
    ramp = gb.SpeedProfile.ramp(10.0, 30.0, duration=1.0)
    return system.simulate(1.0, ramp, output_step=2e-3, record=["disk"], rtol=1e-4)


def test_a_gif_has_the_asked_length_and_a_small_size(run, tmp_path):
    path = tmp_path / "run.gif"
    run.animate(path, duration=0.8, fps=10.0)
    assert path.stat().st_size < 300_000
    with Image.open(path) as image:
        assert image.n_frames == 8
        assert image.info["duration"] == 100
        assert image.info["loop"] == 0
        first = np.array(image.convert("RGB"))
        assert first[0, 0].tolist() == [255, 255, 255]
        image.seek(4)
        assert np.any(np.array(image.convert("RGB")) != first)


def test_a_page_contains_all_its_frames(run, tmp_path):
    path = tmp_path / "run.html"
    run.animate(path, duration=0.5, fps=8.0)
    page = path.read_text(encoding="utf-8")
    frames = json.loads(re.search(r"const frames = (.*);", page)[1])
    assert len(frames) == 4
    for frame in frames:
        assert base64.b64decode(frame).startswith(b"\x89PNG")
    assert "src=" not in page.replace("image.src", "")  # no other file
    assert ", 125);" in page


def test_the_motion_is_that_of_the_record(run):
    found = run_figures._motion(run._to_record(), None, (0.1, 0.2), 6, 3.0)
    time = np.linspace(0.1, 0.2, 6)
    np.testing.assert_allclose(found.time, time)
    np.testing.assert_allclose(found.speed, SPEED)
    assert found.slow == pytest.approx(30.0)
    # shafts turn at their signed speed
    np.testing.assert_allclose(found.angles["input"], SPEED * time)
    np.testing.assert_allclose(found.angles["idler"], -23 / 31 * SPEED * time)
    # displacements are those about the mean over the frames
    rows = np.arange(100, 201, 20)
    for name in ("g1", "g4", "g5"):
        exact = run.displacement(name)[rows]
        np.testing.assert_allclose(found.centres[name], exact - exact.mean(axis=0), atol=1e-15)
        np.testing.assert_allclose(found.twists[name], run.twist(name)[rows], rtol=1e-9)
    assert (found.mesh.driver, found.mesh.driven) == ("g1", "g2")
    mesh = run.mesh(("g1", "g2"))
    np.testing.assert_allclose(found.mesh.pressure_angle, mesh.pressure_angle[rows], rtol=1e-9)
    times, ratio = found.curves["contact ratio"]
    np.testing.assert_array_equal(times, run.time[100:201])
    np.testing.assert_array_equal(ratio, mesh.contact_ratio[100:201])


def test_the_last_turn_of_the_slowest_shaft_is_shown(run):
    first, last = run_figures._span(run._to_record(), None)
    assert last == run.time[-1]
    assert last - first == pytest.approx(2.0 * pi / (23 * 29 / (47 * 53) * SPEED))


def test_a_rotor_without_mesh_shows_its_displacement(rotor, tmp_path):
    found = run_figures._motion(rotor._to_record(), None, (0.0, 1.0), 5, 1.0)
    assert found.mesh is None
    assert list(found.curves) == ["disk y [µm]", "disk z [µm]"]
    # ∫(10 + 20 t) dt = 10 t + 10 t², and the speed at the frames
    time = np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(found.angles["rotor"], 10.0 * time + 10.0 * time**2, rtol=1e-6)
    np.testing.assert_allclose(found.speed, 10.0 + 20.0 * time)
    rotor.animate(tmp_path / "rotor.gif", duration=0.3, fps=10.0, magnify=20.0)
    assert (tmp_path / "rotor.gif").is_file()


@each_case(
    ("options", "message"),
    [
        (
            {"path": "run.mp4"},
            r"^path: must end with \.gif or \.html, which is the format, got '.*run\.mp4'",
        ),
        ({"duration": 0.0}, "^duration: must be positive, got 0"),
        ({"duration": 1e4}, "^duration: .* are 150000 frames, at most 2000"),
        ({"fps": 60.0}, "^fps: must be at most 50, got 60"),
        ({"fps": np.nan}, "^fps: must be finite"),
        ({"magnify": -1.0}, "^magnify: must be positive"),
        ({"times": (0.0, 1.0)}, "^times: must ascend within the record, 0 s to 0.25 s"),
        ({"times": (0.1, 0.1)}, "^times: must ascend"),
        ({"times": 0.1}, r"^times: must be \(first, last\)"),
        ({"mesh": "g1"}, r"^mesh: must be \(driver, driven\) or \"driver/driven\", got 'g1'"),
        ({"mesh": ("g1", "g7")}, "the mesh of 'g1' with 'g7'"),
    ],
)
def test_the_error_names_the_invalid_argument(run, tmp_path, options, message):
    given = {"path": "run.gif", **options}
    with pytest.raises(gb.GearbowError, match=message):
        run.animate(tmp_path / given.pop("path"), **given)
    assert list(tmp_path.iterdir()) == []


def test_the_error_says_what_is_missing(tmp_path):
    with pytest.raises(gb.GearbowError, match=r"^animate: this response does not know its system"):
        recorded().animate(tmp_path / "run.gif")
    system = hostile()
    run = system.simulate(0.01, SPEED, output_step=1e-3, record=[("input", 0.0)])
    with pytest.raises(
        gb.GearbowError, match=r"no gear or disk was recorded; give record=\['gears'"
    ):
        run.animate(tmp_path / "run.gif")
    run = system.simulate(0.01, SPEED, output_step=1e-3, record=["g1", ("g1", "g2")])
    with pytest.raises(gb.GearbowError, match=r"^mesh: the motion of 'g2' was not recorded"):
        run.animate(tmp_path / "run.gif", mesh=("g1", "g2"))
    run._data["time"] = run.time[:1]
    with pytest.raises(gb.GearbowError, match="at least two recorded times"):
        run.animate(tmp_path / "run.gif")


def test_a_file_that_cannot_be_written_is_an_error(run, tmp_path):
    with pytest.raises(OSError, match="missing"):
        run.animate(tmp_path / "missing" / "run.gif", duration=0.2, fps=10.0)
