"""Invalid response files: each is a `GearbowError` that names the file, before memory is allocated
for it.
"""

from __future__ import annotations

import copy
import json
import re
import struct
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.recording import container as storage
from gearbow.recording.channels import arrays_of, metadata_of
from reference.cases import each_case
from reference.machines import bowed_pair
from reference.processes import printed
from test_checkpoint import RUNS, EnoughError, Pause, Stop, asked
from test_persistence import assert_same
from test_response import recorded


def refused(path: Path, match: str | None = None) -> None:
    with pytest.raises(gb.GearbowError, match=match) as caught:
        gb.Response.load(path)
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 1000


def same_or_refused(path: Path, written: gb.Response) -> None:
    try:
        read = gb.Response.load(path)
    except gb.GearbowError as error:
        assert str(path) in str(error)  # noqa: PT017
    else:
        assert_same(read, written)


def content(response: gb.Response) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    return json.loads(metadata_of(response._to_record(), {})), arrays_of(response._to_record())


def write_npz(path: Path, metadata: str, arrays: dict[str, np.ndarray]) -> None:
    np.savez(path, metadata=np.array(metadata), **arrays)  # type: ignore[arg-type]


def rewrite(path: Path, change: Callable[[dict[str, Any]], None]) -> None:
    """Write a file that is valid except for a change of its metadata."""
    metadata, arrays = content(recorded())
    change(metadata)
    write_npz(path, json.dumps(metadata), arrays)


# --- damaged --------------------------------------------------------------------------------------


def test_a_truncated_file_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    recorded().save(path)
    whole = path.read_bytes()
    for length in {0, 1, 7, 8, 39, 40, 41, len(whole) - 1, *range(50, len(whole), 997)}:
        path.write_bytes(whole[:length])
        refused(path)


def test_a_changed_bit_is_detected_or_has_no_effect(tmp_path):
    path, written = tmp_path / "run.npz", recorded()
    written.save(path)
    whole = path.read_bytes()
    numbers = np.random.default_rng(5)
    # Every byte of the archive directory at the end, and a selection of the other bytes.
    places = [*range(len(whole) - 250, len(whole)), *numbers.integers(0, len(whole), 500)]
    for at in places:
        damaged = bytearray(whole)
        damaged[at] ^= 1 << int(numbers.integers(8))
        path.write_bytes(damaged)
        same_or_refused(path, written)


def test_other_content_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    for other in (b"", b"notes", b"PK\x05\x06" + bytes(18), b"\x89HDF\r\n\x1a\n" + bytes(200)):
        path.write_bytes(other)
        refused(path)


# --- metadata -------------------------------------------------------------------------------------


def entries(value: Any, place: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the paths of all entries of the metadata."""
    inner = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    return [
        found for key, entry in inner for found in [(*place, key), *entries(entry, (*place, key))]
    ]


def changed(
    metadata: dict[str, Any], place: tuple[Any, ...], change: Callable[[Any, Any], None]
) -> dict[str, Any]:
    metadata = copy.deepcopy(metadata)
    owner: Any = metadata
    for key in place[:-1]:
        owner = owner[key]
    change(owner, place[-1])
    return metadata


def drop(owner: Any, key: Any) -> None:
    del owner[key]


def rename(owner: Any, key: Any) -> None:
    if isinstance(owner, dict):
        owner[f"{key}x"] = owner.pop(key)
    else:
        owner.insert(key, owner[key])


WRONG: list[Any] = [
    None,
    "",
    "?",
    -1,
    10**400,
    1e300,
    float("nan"),
    True,
    [],
    {},
    [None],
    [[]],
    {"a": 1},
]


def test_every_metadata_entry_is_checked(tmp_path):
    """A changed entry is an error or gives a usable response: other numbers or names can be valid."""
    path, written = tmp_path / "run.npz", recorded()
    metadata, arrays = content(written)
    places = entries(metadata)
    assert len(places) > 60
    refusals = 0
    for place in places:
        for change in [
            drop,
            rename,
            *(lambda owner, key, value=value: owner.__setitem__(key, value) for value in WRONG),
        ]:
            write_npz(path, json.dumps(changed(metadata, place, change)), arrays)
            try:
                read = gb.Response.load(path)
            except gb.GearbowError as error:
                refusals += 1
                assert str(path) in str(error)  # noqa: PT017
            else:
                works(read)
    assert refusals > 0.7 * len(places) * (len(WRONG) + 2)


def works(response: gb.Response) -> None:
    """Use all data of a response."""
    assert repr(response)
    assert len(response.events) == len(response._data["events"])
    assert response.speeds.shape == response.time.shape
    for _, _, names in response._data["points"]:
        for name in names:
            assert response.displacement(name).shape == (response.time.size, 2)
    for shaft in response._to_record().recorded_shafts if response._data["sections"] else []:
        assert response.section_forces(shaft).shape[0] == response.time.size
    list(response.statistics)
    metadata_of(response._to_record(), {})


@each_case(
    ("place", "value", "text"),
    [
        (("format",), 99, "format 99, this version of gearbow reads 1"),
        (("format",), "1", "format: must be a whole number"),
        (("points",), {}, r"points: must be a list, got \{\}"),
        (("points", 0, 1), "left", r"points\[0\]\[1\]: must be a finite number, got 'left'"),
        (
            ("points",),
            [],
            r"displacement: must be float64 of shape \(5, 0, 2\), got float64 of shape \(5, 3, 2\)",
        ),
        (("meshes",), [["g1", "g2"]] * 3, r"mesh_deflection: must be .* of shape \(5, 3\)"),
        (("statistics", "steps"), 1.5, r"statistics\.steps: must be a whole number"),
        (("final", "elapsed"), -1e300, r"initial\.elapsed: must not be negative, got -1e300"),
        (("final", "elapsed"), 1e300, r"initial\.elapsed: must not be after the end of the run"),
        (("final", "elapsed"), float("nan"), r"initial\.elapsed: must be finite"),
        (("final", "carry"), -1e300, r"initial\.carry: must not be longer than the run"),
        (("final", "count"), 2**64 - 1, r"initial\.count: must be a whole number"),
        (
            ("final", "anchor"),
            [0.0, 1.0],
            r"initial\.anchor: must be a time and an angle in two parts",
        ),
        (("final", "speed"), {"breaks": []}, "speed"),
        (("final", "method"), 3, r"initial\.method: must be a text"),
    ],
)
def test_the_message_names_the_entry(tmp_path, place, value, text):
    path = tmp_path / "run.npz"

    def change(metadata: dict[str, Any]) -> None:
        metadata.update(changed(metadata, place, lambda owner, key: owner.__setitem__(key, value)))

    rewrite(path, change)
    refused(path, text)


@each_case(
    "text",
    [
        "",
        "{",
        "[]",
        "3",
        '{"format": 1',
        "[" * 100_000,
        '{"a":' * 100_000,
        "1" * 5000,
        '{"format": 1}',
    ],
    ids=lambda text: f"{text[:6]} of {len(text)}",
)
def test_metadata_that_are_no_valid_json_are_refused(tmp_path, text):
    path = tmp_path / "run.npz"
    write_npz(path, text, content(recorded())[1])
    refused(path)


# --- arrays ---------------------------------------------------------------------------------------


def test_every_array_is_checked(tmp_path):
    written = recorded()
    metadata, arrays = content(written)
    path = tmp_path / "run.npz"
    for name, values in arrays.items():
        if not values.size:
            continue
        wrong = {
            "missing": None,
            "longer": np.concatenate([values, values]),
            "flat": values.reshape(-1)[None, None, None],
            "single": values.astype(np.float32),
            "complex": values.astype(np.complex128),
            "text": values.astype("U3"),
        }
        for kind, other in wrong.items():
            if name.startswith("final") and kind == "longer":
                continue  # Its length depends on the method; the core compares it with the system.
            changed_arrays = {**arrays, name: other} if other is not None else {**arrays}
            if other is None:
                del changed_arrays[name]
            write_npz(path, json.dumps(metadata), changed_arrays)
            # With a longer time, all other arrays are too short.
            refused(path, None if (name, kind) == ("time", "longer") else name)


def test_an_array_of_objects_is_refused(tmp_path):
    metadata, arrays = content(recorded())
    path = tmp_path / "run.npz"
    write_npz(path, json.dumps(metadata), {**arrays, "time": np.array([{}], dtype=object)})
    refused(path, "time")


# --- memory ---------------------------------------------------------------------------------------

#: Load files in a process limited to 300 MB more; each must fail because of its declared size.
LIMITED = """
import resource, sys
import gearbow as gb
pages = int(open("/proc/self/statm").read().split()[0])
most = pages * resource.getpagesize() + 300_000_000
resource.setrlimit(resource.RLIMIT_AS, (most, most))
for path in sys.argv[1:]:
    try:
        gb.Response.load(path)
    except gb.GearbowError as error:
        assert path in str(error) and "MemoryError" not in str(error), str(error)
    else:
        raise SystemExit(f"{path} was read")
print("refused", len(sys.argv) - 1)
"""


def member(shape: str, dtype: str = "<f8") -> bytes:
    header = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header


def bombs(folder: Path) -> list[Path]:
    """Files with declared sizes of gigabytes."""
    metadata, arrays = content(recorded())
    paths = []

    def archive(name: str, kind: int = zipfile.ZIP_STORED, **replaced: bytes) -> None:
        paths.append(folder / f"{name}.npz")
        write_npz(paths[-1], json.dumps(metadata), arrays)
        with zipfile.ZipFile(paths[-1]) as old:
            members = {entry: old.read(entry) for entry in old.namelist()}
        with zipfile.ZipFile(paths[-1], "w", kind) as new:
            for entry, data in members.items():
                new.writestr(entry, replaced.get(entry.removesuffix(".npy"), data))

    for shape in (
        "(2000000000,)",
        "(10000000000000000000,)",
        "(-1,)",
        f"({2**62}, 4)",
        "(3, 0, 2)",
    ):
        archive(f"header{len(paths)}", time=member(shape))
    archive("text", metadata=member("()", "<U900000000"))
    archive("void", time=member("(1,)", "|V2000000000"))
    archive("deep", time=member("(" * 3000 + "5" + ",)" * 3000))
    zeros = member("(50000000,)") + bytes(400_000_000)
    archive("compressed", zipfile.ZIP_DEFLATED, time=zeros)
    # The size in the archive directory differs from that of the data.
    paths.append(folder / "sizes.npz")
    write_npz(paths[-1], json.dumps(metadata), {**arrays, "time": np.zeros(5)})
    data = bytearray(paths[-1].read_bytes())
    at = data.rfind(b"time.npy")
    struct.pack_into("<II", data, at - 46 + 20, 2_000_000_000, 2_000_000_000)
    paths[-1].write_bytes(data)
    return paths


@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="limits of the memory of a process"
)
def test_declared_gigabytes_are_refused_before_they_are_allocated(tmp_path):
    paths = bombs(tmp_path)
    assert printed(LIMITED, *paths) == f"refused {len(paths)}\n"


# --- impossible states ----------------------------------------------------------------------------


@each_case(
    ("changes", "text"),
    [
        ({"state": np.zeros(4)}, r"^initial: has 2 degrees of freedom"),
        ({"state": None}, r"^initial\.state: must be a contiguous array"),
        ({"contact_modes": np.zeros(3, dtype=np.int64)}, r"^initial\.contact_modes: are 3 numbers"),
        (
            {"contact_modes": np.zeros(500, dtype=np.int64)},
            r"^initial\.contact_modes: are 500 numbers",
        ),
        (
            {"contact_modes": np.array([0, 0, 2**62, 0, 0])},
            r"^initial\.contact_modes: are 5 numbers",
        ),
        ({"contact_modes": np.array([9, 0, 0, 0, 0])}, r"^initial\.contact_modes: are 5 numbers"),
        ({"contact_modes": "none"}, r"^initial\.contact_modes: must be"),
        ({"memory": 3}, r"^initial\.memory: must be"),
        ({"elapsed": -1e300}, r"^initial\.elapsed: must not be negative"),
        ({"origin": -1e300}, r"^initial\.elapsed: is 1e300 s before the end"),
        ({"carry": 1e300}, r"^initial\.carry: must not be longer"),
        ({"count": 2**63}, r"^initial\.count: must be a whole number"),
        ({"count": -1}, r"^initial\.count: must be a whole number"),
        ({"next_step": float("inf")}, r"^initial\.next_step: must be finite"),
        ({"setting": "wide"}, r"^initial\.setting: must be a number"),
        ({"speed": float("nan")}, r"^initial\.speed: must be finite"),
        ({"time": "now"}, r"^initial\.time: must be a number"),
    ],
    ids=str,
)
@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_an_invalid_final_state_is_a_scene_error(changes, text, method):
    system = bowed_pair()
    options: dict[str, Any] = {"speed": 100.0, "output_step": 1e-4, "method": method}
    final = system.simulate(1e-3, **options).final
    with pytest.raises(gb.SceneError, match=text):
        system.simulate(1e-3, **options, initial={**final, **changes})


@pytest.mark.parametrize("count", [0, 5, 2**53, 2**63 - 1])
@pytest.mark.parametrize("method", ["exponential", "rk45", "rk4"])
def test_a_wrong_count_of_steps_does_not_stop_the_interpreter(count, method):
    system = bowed_pair()
    options: dict[str, Any] = {"speed": 100.0, "output_step": 1e-4, "method": method}
    final = system.simulate(1e-3, **options).final
    try:
        further = system.simulate(1e-3, **options, initial={**final, "count": count})
    except gb.SceneError as error:
        assert "step" in str(error)  # noqa: PT017
    else:
        assert further.time[-1] == 2e-3


# --- checkpoints ----------------------------------------------------------------------------------


def stopped(
    path: Path,
) -> tuple[gb.RotorSystem, dict[str, Any], dict[str, Any], dict[str, np.ndarray]]:
    """Stop a run, and return it with the content of its file."""
    system, options = RUNS["smooth"][0].package(), asked("smooth")
    with pytest.raises(EnoughError):
        system.simulate(**options, checkpoint=path, progress=Stop(Pause()))
    response, about = storage.read(path)
    return system, options, about, arrays_of(response)


def test_a_checkpoint_with_an_invalid_entry_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    system, options, about, arrays = stopped(path)
    pauses = [("checkpoint", "checkpoint", key) for key in about["checkpoint"]["checkpoint"]]
    places = [("checkpoint",), ("checkpoint", "asked"), ("checkpoint", "checkpoint"), *pauses]
    nested: list[Any] = []
    for _ in range(500):
        nested = [nested]
    for place in places:
        for value in ("?", -1, [], {"a": 1}, nested, [[-1.0]] * 3, 2**63, [float("nan")] * 6):
            if place[-1] == "until" and value == 2**63:
                continue  # a valid time
            wrong = changed(
                about, place, lambda owner, key, value=value: owner.__setitem__(key, value)
            )
            write_npz(path, json.dumps(wrong), arrays)
            before = path.read_bytes()
            with pytest.raises(gb.SceneError, match=r"^checkpoint: .*run\.npz") as caught:
                system.simulate(**options, checkpoint=path)
            assert len(str(caught.value)) < 2000
            assert path.read_bytes() == before
        write_npz(path, json.dumps(changed(about, place, drop)), arrays)
        with pytest.raises(gb.SceneError, match=r"^checkpoint: .*run\.npz"):
            system.simulate(**options, checkpoint=path)


def test_a_damaged_checkpoint_is_refused_or_gives_the_whole_run(tmp_path):
    path = tmp_path / "run.npz"
    system, options, *_ = stopped(path)
    written, whole = path.read_bytes(), system.simulate(**options)
    numbers = np.random.default_rng(11)
    damaged = [written[: int(end)] for end in numbers.integers(0, len(written), 15)]
    for at in numbers.integers(0, len(written), 45):
        changed_bytes = bytearray(written)
        changed_bytes[at : at + int(numbers.integers(1, 9))] = numbers.bytes(1)
        damaged.append(bytes(changed_bytes))
    refusals = 0
    for content in damaged:
        path.write_bytes(content)
        try:
            found = system.simulate(**options, checkpoint=path)
        except gb.SceneError as error:
            assert re.match(r"checkpoint: .*run\.npz", str(error))  # noqa: PT017
            assert path.read_bytes() == content
            refusals += 1
        else:
            assert_same(found, whole)
    assert refusals >= 15


def test_a_checkpoint_with_too_many_meshes_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    system, options, about, arrays = stopped(path)
    about["checkpoint"]["checkpoint"]["margins"] *= 2
    write_npz(path, json.dumps(about), arrays)
    with pytest.raises(
        gb.SceneError, match=r"^checkpoint: .*run\.npz.*checkpoint: is of a run of another system"
    ):
        system.simulate(**options, checkpoint=path)


def test_a_system_entry_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "rotor.toml"
    path.write_bytes(b"\xff\xfe name")
    with pytest.raises(gb.SceneError, match=r"rotor\.toml: is not UTF-8 text"):
        gb.RotorSystem.load(path)


@pytest.mark.parametrize("header", [b"{'descr': '<f8', 'shape': (", b"{" + 4000 * b"("])
def test_a_header_that_numpy_cannot_read_is_an_error_of_gearbow(tmp_path, header):
    path = tmp_path / "run.npz"
    recorded().save(path)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    header += b"\n"
    members["time.npy"] = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    with pytest.raises(gb.GearbowError, match="not a response of gearbow, or damaged"):
        gb.Response.load(path)
