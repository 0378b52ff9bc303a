"""A scene file names the files of its elastic housings, with a digest of each."""

from __future__ import annotations

import dataclasses
import hashlib
import pickle
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest

import gearbow as gb
from gearbow.cli.main import main
from reference.elastic import system

pytest.importorskip("scipy")


def body_of(path: Path) -> Path:
    """Give the one file of an elastic housing beside a scene."""
    (body,) = list(path.parent.glob(f"{path.stem}.housing-*.npz"))
    return body


@pytest.mark.parametrize("names", [("housing",), ("left [box]", 'right "box"')])
def test_a_saved_system_is_read_as_it_was(tmp_path: Path, names: tuple[str, ...]):
    saved = system(*names)
    path = tmp_path / "scene.toml"
    saved.save(path)
    files = sorted(file.name for file in tmp_path.iterdir())
    # the names follow from the content
    bodies = list(tmp_path.glob("*.npz"))
    assert len(bodies) == len(names)
    digests = [hashlib.sha256(body.read_bytes()).hexdigest() for body in bodies]
    assert files == [*sorted(f"scene.housing-{each[:12]}.npz" for each in digests), "scene.toml"]
    assert "frequencies" not in path.read_text(encoding="utf-8")
    for again in (gb.read(path), gb.RotorSystem.load(str(path))):
        assert again.description == saved.description
        assert again.housings[0].elastic is not None
    np.testing.assert_array_equal(again.modes().eigenvalues, saved.modes().eigenvalues)
    with pytest.raises(SystemExit, match="0"):
        main(["check", str(path)])
    # units elsewhere in the scene leave the names of interfaces as they are
    path.write_text(path.read_text(encoding="utf-8").replace("length = 1.0", 'length = "1000 mm"'))
    assert gb.read(path).description == saved.description


def test_a_failed_save_leaves_the_scene_before_and_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    before = system("housing")
    path = tmp_path / "scene.toml"
    before.save(path)
    (housing,) = before.housings
    assert housing.elastic is not None
    frequencies = tuple(1.1 * value for value in housing.elastic.frequencies)
    other = dataclasses.replace(housing.elastic, frequencies=frequencies)
    after = before.replace(housings=[dataclasses.replace(housing, elastic=other)])
    with monkeypatch.context() as patch:
        patch.setattr("gearbow.system.rotor_system.replacing", failing)
        with pytest.raises(OSError, match="no space"):
            after.save(path)
    assert gb.read(path).description == before.description
    after.save(path)
    assert gb.read(path).description == after.description
    # the file of the scene before remains: a copy of this scene may need it
    assert len(list(tmp_path.glob("scene.housing-*.npz"))) == 2


def failing(_: Path) -> NoReturn:
    """Fail as a full disk does."""
    raise OSError("no space left on device")


def test_descriptions_and_copies_keep_the_numbers():
    saved = system("housing")
    for again in (
        gb.RotorSystem.from_dict(saved.description),
        pickle.loads(pickle.dumps(saved)),
        saved.replace(gravity=9.81).replace(gravity=None),
    ):
        assert again.description == saved.description
        assert again.housings == saved.housings


def test_a_scene_may_contain_the_numbers_itself(tmp_path: Path):
    saved = system("housing")
    path = tmp_path / "scene.toml"
    path.write_text(saved._model.to_toml(), encoding="utf-8")
    assert gb.read(path).description == saved.description


def test_wrong_files_are_errors(tmp_path: Path):
    path = tmp_path / "scene.toml"
    system("housing").save(path)
    body, text = body_of(path), path.read_text(encoding="utf-8")
    data = body.read_bytes()

    def refused(match: str) -> None:
        with pytest.raises(gb.SceneError, match=match):
            gb.read(path)

    body.write_bytes(data[:-1])
    refused(
        r"housings\[0\]\.elastic\.digest: .*scene\.housing-.*\.npz has the digest sha256:.* not"
    )
    body.unlink()
    refused(r"housings\[0\]\.elastic\.file: .*scene\.housing-.*\.npz cannot be read: No such file")
    body.write_bytes(data)
    path.write_text(text.replace("digest =", "digests ="), encoding="utf-8")
    refused(r"housings\[0\]\.elastic\.digest: must be a text, got None")
    path.write_text(text.replace("digest =", "frequencies = [1.0]\ndigest ="), encoding="utf-8")
    refused(r"housings\[0\]\.elastic\.frequencies: is in the file scene\.housing-.*\.npz")
    path.write_text(text.replace('file = "', 'file = 3 # "'), encoding="utf-8")
    refused(r"housings\[0\]\.elastic\.file: must be a text, got 3")
    path.write_text(text, encoding="utf-8")
    assert gb.read(path).housings


def test_a_file_that_is_no_body_is_an_error_despite_its_digest(tmp_path: Path):
    path = tmp_path / "scene.toml"
    system("housing").save(path)
    body = body_of(path)
    before = hashlib.sha256(body.read_bytes()).hexdigest()
    np.savez(body, names=["seat"])
    after = hashlib.sha256(body.read_bytes()).hexdigest()
    text = path.read_text(encoding="utf-8").replace(before, after)
    path.write_text(text, encoding="utf-8")
    with pytest.raises(gb.SceneError, match=r"scene\.housing-.*\.npz: is not an elastic body"):
        gb.read(path)
