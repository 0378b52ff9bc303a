"""Every writer: a failed or killed save leaves the previous file; texts of any kind are kept."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

import gearbow as gb
from gearbow._files import printable
from gearbow.exchange.universal import Function, Quantity, function_lines, write
from reference.elastic import system as housed
from reference.processes import printed
from test_damaged_files import (
    HISTORIES,
    TIME,
    functions_with,
    histories,
    measured_value,
    named,
    response,
    rotor,
)
from test_response import recorded

posix = pytest.mark.skipif(os.name != "posix", reason="signals and limits of a process")


def command(*given: object) -> None:
    from gearbow.cli.main import main

    assert main([str(each) for each in given]) == 0


def drawing(path: Path) -> None:
    from gearbow.cli.main import save_figure

    save_figure(rotor().modes(count=2).plot(), path)


def imported(path: Path) -> None:
    command(
        "import",
        Path(__file__).parents[3] / "tests/python/files/gearbox.rexs",
        "--load-case",
        1,
        "--bearing",
        "other=1e8",
        "--out",
        path,
    )


def scene(path: Path) -> None:
    path.unlink(missing_ok=True)  # the command replaces nothing
    command("new", path)


def animation(path: Path) -> None:
    rotor().simulate(0.02, 100.0, output_step=1e-3).animate(path, duration=0.2)


def data_set(path: Path) -> None:
    gb.dataset(
        lambda x: rotor(),  # noqa: ARG005
        {"x": [1.0]},
        lambda system, **_: system.simulate(0.01, 100.0, output_step=1e-3, record=["pinion"]),
        {"y": gb.Probe("input", 0.1)},
        path,
    )


def page(path: Path) -> None:
    from gearbow.report import compose

    # The file does not depend on the sections.
    with patch.object(compose, "SECTIONS", compose.SECTIONS[1:2]):
        rotor().report(path)


#: A file of every format of each writer, by the function of the package that opens it.
WRITERS: dict[str, dict[str, Callable[[Path], Any]]] = {
    "recording.container.save_netcdf": {
        "modes.nc": lambda path: rotor().modes(count=2).save(path),
        "curves.nc": lambda path: response().save(path),
        "run.nc": lambda path: recorded(rows=20).save(path),
        "map.nc": lambda path: gb.sweep(named, {"x": [1.0]}, measured_value).save(path),
    },
    "_sheets.save_table": {
        "modes.csv": lambda path: rotor().modes(count=2).save(path),
        "modes.xlsx": lambda path: rotor().modes(count=2).save(path),
    },
    "exchange.universal.write": {
        "curves.uff": lambda path: response().save(path),
        "modes.uff": lambda path: rotor().modes(count=2).save(path),
    },
    "results.frequency_response._save_own": {
        "curves.mat": lambda path: response().save(path),
    },
    "recording.container.save": {
        "run.npz": lambda path: recorded(rows=20).save(path),
    },
    "sweeps.store.write": {
        "map.sweep": lambda path: gb.sweep(named, {"x": [1.0]}, measured_value).save(path)
    },
    "studies.dataset.dataset": {"set.nc": data_set},
    "system.rotor_system.save": {"rotor.toml": lambda path: rotor().save(path)},
    "system.bodies.write_bodies": {"housed.toml": lambda path: housed("housing").save(path)},
    "report.page.write": {"page.html": page},
    "results.run_figures.animate": {"run.gif": animation},
    "cli.main.save_figure": {"modes.svg": drawing, "modes.png": drawing},
    "cli.answers.import_": {"train.toml": imported},
    "exchange.rexs_writer.write_rexs": {"train.rexs": lambda path: rotor().save(path)},
    "exchange.fmu.write_fmu": {"unit.fmu": lambda path: rotor().to_fmu(path, 100.0)}
    if find_spec("pythonfmu3")
    else {},
    "cli.answers.new": {},  # it replaces no file
}


def test_every_writer_is_tested():
    """Files are opened for writing by `replacing` only."""
    assert functions_with("replacing") == set(WRITERS)
    writing = functions_with("write_bytes", "write_text", "to_csv", "to_excel", "savemat", "savez")
    # A table as a text, files in a temporary folder, and two that write to an open file.
    assert writing == {
        "_sheets._csv",
        "exchange.fmu.write_fmu",
        "exchange.harmonic.write_mat",
        "recording.container.save",
    }


def write_one(name: str, path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        next(group[name] for group in WRITERS.values() if name in group)(path)


FAILING = """
import errno, os, pathlib, resource, signal, sys
from test_writers import WRITERS, write_one

def content():
    return {each: each.read_bytes() for each in folder.iterdir() if each.suffix != ".part"}

folder = pathlib.Path(sys.argv[2])
hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
for name in WRITERS[sys.argv[1]]:
    path = folder / name
    write_one(name, path)
    before = content()
    for limit in (1, path.stat().st_size // 2):
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
        try:
            write_one(name, path)
        except OSError as error:
            assert "cannot be written and is unchanged" in str(error), error
        else:
            raise SystemExit(f"{limit} bytes were enough for {name}")
        resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
        assert content() == before and not list(folder.glob(".*.part")), name
    # A disk that is full when the data of the temporary file go to it.
    def full(number):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    os.fsync, sync = full, os.fsync
    try:
        write_one(name, path)
    except OSError as error:
        assert error.errno == errno.ENOSPC and "is unchanged" in str(error), error
    else:
        raise SystemExit(f"{name} is not written to the disk")
    os.fsync = sync
    assert content() == before and not list(folder.glob(".*.part")), name
    # A kill while the data of the temporary file go to the disk.
    child = os.fork()
    if not child:
        os.fsync = lambda number: os.kill(os.getpid(), signal.SIGKILL)
        write_one(name, path)
        os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL, name
    assert content() == before and list(folder.glob(".*.part")), name
    write_one(name, path)
    assert not list(folder.glob(".*.part")), name
"""


@posix
@pytest.mark.parametrize("writer", [writer for writer, group in WRITERS.items() if group])
def test_a_failed_or_killed_writer_leaves_the_previous_files(tmp_path: Path, writer: str):
    printed(FAILING, writer, tmp_path)


# --- exports of any text --------------------------------------------------------------------------

TEXTS = ["=1+1", "+x", "-x", "@x", "a\ufffeb", "a\x01b", "a\ud800b", "<&>", "-1", "größe"]


def test_texts_stay_texts_in_tables(tmp_path: Path):
    openpyxl = pytest.importorskip("openpyxl")
    found = gb.sweep(named, {"x": [1.0]}, measured_value)
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"=1+1": TEXTS, "y": np.arange(len(TEXTS)) / 3.0})
    object.__setattr__(found, "to_dataframe", lambda: frame)
    found.save(tmp_path / "a.xlsx")
    sheet = openpyxl.load_workbook(tmp_path / "a.xlsx").active
    cells = [row[0] for row in sheet.iter_rows()]
    assert all(cell.data_type in "s" or cell.data_type == "inlineStr" for cell in cells)
    assert [cell.value for cell in cells] == ["=1+1", *(printable(each) for each in TEXTS)]
    assert [row[1].value for row in sheet.iter_rows(min_row=2)] == frame["y"].tolist()
    found.save(tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "'=1+1,y"
    assert [line.split(",")[0] for line in lines[1:5]] == ["'=1+1", "'+x", "'-x", "'@x"]
    assert lines[9].startswith("-1,")


def test_a_figure_with_any_text_is_xml(tmp_path: Path):
    from xml.etree import ElementTree as ET

    from matplotlib.figure import Figure

    from gearbow.cli.main import save_figure

    figure = Figure()
    figure.text(0.5, 0.5, "a\ufffeb")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # no glyph for it
        save_figure(figure, tmp_path / "a.svg")
    ET.parse(tmp_path / "a.svg")


def test_a_frequency_response_is_a_table_of_numbers(tmp_path: Path):
    openpyxl = pytest.importorskip("openpyxl")
    response().save(tmp_path / "a.xlsx", at="pinion")
    rows = list(openpyxl.load_workbook(tmp_path / "a.xlsx").active.iter_rows(values_only=True))
    assert rows[0][3:5] == ("pinion y re [m]", "pinion y im [m]")
    values = np.array([row[3:5] for row in rows[1:]], dtype=np.float64)
    expected = response().displacement("pinion")[:, 0, 0]
    np.testing.assert_array_equal(values @ [1.0, 1.0j], expected)


def test_a_data_card_replaces_only_data_cards(tmp_path: Path):
    pytest.importorskip("h5netcdf")
    notes = tmp_path / "set.md"
    notes.write_text("my notes")
    with pytest.raises(gb.SceneError, match=r"set\.md, which is no data card of gearbow"):
        data_set(tmp_path / "set.nc")
    assert notes.read_text() == "my notes"
    notes.unlink()
    data_set(tmp_path / "set.nc")
    data_set(tmp_path / "set.nc")
    assert "computed, not measured" in notes.read_text()


# --- universal files ------------------------------------------------------------------------------


def test_names_and_positions_are_complete_in_universal_files(tmp_path: Path):
    at = ("input", 0.1 + 1e-9)
    path = tmp_path / "a.uff"
    response().save(path, at=at)
    assert response().compare(path).measured[0].at == at
    long = "x" * 90
    system = rotor().replace(disks=[gb.Disk(long, "input", 0.1, 1.0, 1e-3, 1e-3)])
    found = system.frequency_response([10.0], source=gb.Force(("input", 0.1), 1.0))
    with pytest.raises(gb.SceneError, match="a line of a universal file has 80 printable"):
        found.save(path, at=long)
    assert response().compare(path).measured[0].at == at


HERTZ = np.linspace(5.0, 200.0, 20)


def foreign(
    path: Path,
    hits: list[tuple[tuple[int, int], Any]],
    units: tuple[str, str] = ("m/s^2", "N"),
    *,
    kind: int = 4,
    more: tuple[tuple[int, list[str]], ...] = (),
) -> None:
    """Write functions of another program: acceleration of node 1 towards +z for each hit."""
    sets = [
        (
            58,
            function_lines(
                Function(
                    kind,
                    ["hammer", *["NONE"] * 4],
                    (1, 3),
                    hit,
                    HERTZ,
                    values,
                    (Quantity(18, "Hz"), Quantity(12, units[0]), Quantity(13, units[1])),
                )
            ),
        )
        for hit, values in hits
    ]
    write(path, [*more, *sets])


def struck(at: Any, value: complex) -> Any:
    """Acceleration along z at the first place for a force."""
    found = rotor().frequency_response(2.0 * np.pi * HERTZ, source=gb.Force(at, value), speed=10.0)
    return found.acceleration(("input", 0.1))[:, 0, 1]


PLACES = {1: ("input", 0.1), 2: ("input", 0.25)}


def test_a_roving_hammer_is_compared_with_each_of_its_hits(tmp_path: Path):
    path = tmp_path / "a.uff"
    hits = [((1, 3), struck(PLACES[1], 1j)), ((2, -3), struck(PLACES[2], -1j))]
    foreign(path, hits)
    found = response().compare(path, places=PLACES)
    for measured, computed in zip(found.measured, found.computed, strict=True):
        # 12 digits, and frequencies of 8
        np.testing.assert_allclose(measured.values, computed, rtol=1e-7)
    with pytest.raises(gb.SceneError, match="needs the place of the reference node 2"):
        response().compare(path, places={1: PLACES[1]})
    foreign(path, hits, more=((151, ["rig 7", "NONE", "Test.Lab", "", "", "", ""]),))
    with pytest.raises(gb.SceneError, match=r"data set 58 \(rig 7, Test\.Lab\)"):
        response().compare(path, places={1: PLACES[1]})
    # Units of the labels, and of data set 164 where there is none: mm, and kN.
    scaled = [(hit, values / 9.80665) for hit, values in hits]
    foreign(path, scaled, ("g", "N"))
    again = response().compare(path, places=PLACES)
    np.testing.assert_allclose(again.measured[1].values, found.measured[1].values, rtol=1e-11)
    foreign(path, [(hit, 1e6 * values) for hit, values in hits], ("mm/s2", "kN"))
    again = response().compare(path, places=PLACES)
    np.testing.assert_allclose(again.measured[1].values, found.measured[1].values, rtol=1e-11)
    factors = "".join(f"{each:25.17E}" for each in (1e3, 1e-3, 1.0)).replace("E", "D")
    about = (164, [f"{10:10d}{'mm kN':>20}{2:10d}", factors, f"{273.15:25.17E}"])
    foreign(path, [(hit, 1e6 * v) for hit, v in hits], ("NONE", "NONE"), more=(about,))
    again = response().compare(path, places=PLACES)
    np.testing.assert_allclose(again.measured[1].values, found.measured[1].values, rtol=1e-11)
    foreign(path, hits, ("EU", "N"))
    with pytest.raises(gb.SceneError, match="the unit 'EU' is unknown"):
        response().compare(path, places=PLACES)
    foreign(path, hits, kind=1)
    with pytest.raises(gb.SceneError, match=r"no frequency response .*function type 1"):
        response().compare(path, places=PLACES)


def test_time_histories_are_a_measurement(tmp_path: Path):
    path = histories(tmp_path / "run.uff")
    tacho = gb.Tacho("input")
    found = gb.Measurement.read_uff(path, {1: ("input", 0.1), 7: tacho}, revolutions=6)
    assert [(probe.position, probe.angle) for probe in found.probes] == [
        (0.1, 0.0),
        (0.1, np.pi / 2.0),
    ]
    assert found.speeds == pytest.approx(40.0 * np.pi, rel=1e-9)
    # The pulse rises between two samples: half of an interval is 40π · 1.25e-4 = 0.016 rad.
    assert np.abs(found.amplitudes) == pytest.approx(np.tile([30e-6, 40e-6], (3, 1)), rel=1e-9)
    assert np.angle(found.amplitudes) == pytest.approx(np.tile([0.5, -0.3], (3, 1)), abs=0.016)
    probe = gb.Probe("input", 0.1, angle=0.7)
    turned = gb.Measurement.read_uff(
        histories(path, HISTORIES[1:3]), {1: probe, 7: tacho}, revolutions=6
    )
    assert turned.probes == (probe,)
    for given, channels, message in (
        (HISTORIES, {7: tacho}, r"has no time history \(data set 58, function type 1\)"),
        (
            HISTORIES,
            {9: ("input", 0.1), 7: tacho},
            r"line \d+: data set 58: must be a displacement .*has 12",
        ),
        (HISTORIES, {1: ("input", 0.1)}, "pulses: needs one tachometer"),
        ([((1, 1), *HISTORIES[0][1:])], {1: ("input", 0.1)}, "direction 1 is neither y nor z"),
        (HISTORIES[:1] * 2, {1: ("input", 0.1)}, "is a second signal of probe input"),
    ):
        with pytest.raises(gb.SceneError, match=message):
            gb.Measurement.read_uff(histories(path, given), channels, revolutions=6)
    noisy = HISTORIES[2][2] * np.where(np.arange(TIME.size) % 7 == 0, 0.0, 1.0)
    histories(path, [HISTORIES[1], (*HISTORIES[2][:2], noisy)])
    with pytest.raises(gb.SceneError, match="pulses at unequal distances"):
        gb.Measurement.read_uff(path, {1: ("input", 0.1), 7: tacho}, revolutions=6)


def test_an_incomplete_universal_file_is_refused(tmp_path: Path):
    path = tmp_path / "a.uff"
    response().save(path, at="pinion")
    path.write_bytes(path.read_bytes()[:-8])
    with pytest.raises(gb.SceneError, match=r"a\.uff: line \d+: the data set has no end"):
        response().compare(path)
