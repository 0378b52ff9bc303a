"""Names are texts: no figure, table, file, page or command reads markup, mathematics or a formula in them."""

from __future__ import annotations

import json
import warnings
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.cli.main import main
from reference.cases import each_case
from reference.figure_texts import texts_of
from test_report import unpacked

#: No font of matplotlib has the picture of a unicorn.
pytestmark = pytest.mark.filterwarnings(r"ignore:Glyph \d+:UserWarning")

#: Shafts, gears, disk and support of the machine.
NAMES = (
    "$a$",
    r"$\frac$ a_b^c",
    "<b> &amp; <script>",
    "| %{x} %",
    "*x* [0] {y}",
    "=1+1, '\"` 🦄 " * 8,
)


def machine() -> gb.RotorSystem:
    first, second, pinion, wheel, disk, support = NAMES
    shaft: dict[str, Any] = {"length": 0.5, "outer_diameter": 0.05, "elements": 2}
    tooth: dict[str, Any] = {"module": 3e-3, "face_width": 0.03}
    bearing: dict[str, Any] = {"stiffness": 1e8, "damping": 500.0}
    pedestal = gb.Support(name=support, mass=20.0, stiffness=5e8, damping=500.0)
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(first, bow=gb.Bow.half_sine(5e-5), **shaft),
            gb.Shaft(second, **shaft),
        ],
        gears=[
            gb.Gear(pinion, first, 0.25, 20, unbalance=1e-4, **tooth),
            gb.Gear(wheel, second, 0.25, 40, **tooth),
        ],
        disks=[gb.Disk(disk, second, 0.5, 3.0, 0.01, 0.02)],
        meshes=[gb.Mesh(pinion, wheel, stiffness=2e8, damping_ratio=0.05)],
        bearings=[
            gb.Bearing(first, 0.0, support=pedestal, **bearing),
            *(
                gb.Bearing(name, x, **bearing)
                for name, x in ((first, 0.5), (second, 0.0), (second, 0.5))
            ),
        ],
        torques=[gb.Torque(pinion, 50.0), gb.Torque.balance(wheel)],
    )


@pytest.fixture(scope="module")
def run() -> gb.Response:
    return machine().simulate(0.02, 300.0, record=["gears", "disks", "meshes", "bearings"])


def figures(run: gb.Response) -> dict[str, tuple[Any, tuple[str, ...]]]:
    """Give each figure, and the names that it shows."""
    system = machine()
    first, second, pinion, wheel, disk, _ = NAMES
    response = system.synchronous([200.0, 300.0, 400.0])
    modes = system.modes(300.0, count=6)
    rubbing = system.replace(meshes=[gb.Mesh(pinion, wheel, stiffness=2e8, friction=0.05)])
    balance = system.balance([pinion], 300.0, points=[pinion, wheel])
    return {
        "train": (system.plot(), NAMES),
        "modes": (modes.plot(), (first, second)),
        "mode": (modes.plot(3), (first, second)),
        "static": (system.static(speed=300.0).plot(), (first, second)),
        "synchronous": (response.plot([pinion, wheel]), (pinion, wheel)),
        "bode": (response.bode([pinion, wheel]), (pinion, wheel)),
        "campbell": (system.campbell([100.0, 300.0], count=6).plot(), ()),
        "orbits": (run.plot("orbits", [pinion, wheel]), (pinion, wheel)),
        "history": (run.plot("history", [pinion, disk]), (pinion, disk)),
        "mesh": (run.plot("mesh"), (pinion, wheel)),
        "bearings": (run.plot("bearings"), (first, second)),
        "balance": (balance.plot(), (pinion, wheel)),
        "losses": (rubbing.efficiency(300.0).plot(), (pinion, wheel)),
    }


def test_figures_show_names_as_they_are(run):
    pytest.importorskip("matplotlib")
    for kind, (figure, names) in figures(run).items():
        figure.draw_without_rendering()  # formulas are read here
        texts = texts_of(figure)
        # a name at an axis has an escaped "$", which is drawn as "$"
        written = [text.get_text().replace(r"\$", "$") for text in texts]
        for name in names:
            assert any(name in text for text in written), f"{kind}: {name}"
        for text in (text for text in texts if "$" in text.get_text()):
            if not text.get_text().startswith(r"$\mathdefault{"):  # a power of ten at an axis
                drawn, is_formula = text._preprocess_math(text.get_text())
                assert not is_formula, f"{kind}: {text.get_text()}"
                assert r"\$" not in drawn


def test_given_axes_keep_the_formulas_of_their_owner(run):
    figure = pytest.importorskip("matplotlib.figure").Figure()
    upper, lower = figure.subplots(2)
    upper.set_title(r"$\alpha$")
    upper.text(0.1, 0.1, r"$\beta$")
    run.plot("history", list(NAMES[2:4]), ax=[upper, lower])
    figure.draw_without_rendering()
    assert upper.get_title() == r"$\alpha$"
    for text in (upper.title, upper.texts[0]):
        assert text.get_parse_math()
    assert NAMES[2] in upper.get_ylabel() + upper.get_title("left")


class _Page(HTMLParser):
    """The texts, the addresses and the elements of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.elements: set[str] = set()

    def handle_starttag(self, tag: str, attrs: Any) -> None:  # noqa: ARG002
        self.elements.add(tag)

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_a_report_shows_names_as_they_are(tmp_path):
    pytest.importorskip("plotly")
    pytest.importorskip("jinja2")
    path = tmp_path / "report.html"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # they are in the report
        machine().report(path, operating=300.0, modes=3)
    page = _Page()
    text = path.read_text("utf-8")
    page.feed(text)
    assert "b" not in page.elements
    for name in NAMES:
        assert any(name in each for each in page.texts), name
    assert "Not computed" not in text
    # plotly reads elements and templates in its texts, but nothing else
    texts = [
        unpacked(each) for each in page.texts if each.startswith("H4sI")
    ]  # of gzip, in base 64
    figures = [json.loads(each) for each in texts if each.startswith('{"data"')]
    assert figures
    for figure in figures:
        given = [trace.get("name", "") for trace in figure["data"]]
        given += [note["text"] for note in figure["layout"].get("annotations", ())]
        for each in given:
            assert "<b> &" not in each
            assert "%{x}" not in each


def test_tables_and_files_keep_names(run, tmp_path):
    system = machine()
    system.save(tmp_path / "machine.toml")
    assert gb.RotorSystem.load(tmp_path / "machine.toml").description == system.description
    pytest.importorskip("h5netcdf")
    xarray = pytest.importorskip("xarray")
    run.save(tmp_path / "run.npz")
    run.save(tmp_path / "run.nc")
    read = gb.Response.load(tmp_path / "run.npz")
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf", decode_times=False) as data:
        assert data.equals(run.to_xarray())
    for name in NAMES[2:5]:
        np.testing.assert_array_equal(read.displacement(name), run.displacement(name))
    pandas = pytest.importorskip("pandas")
    run.to_dataframe().to_csv(tmp_path / "run.csv")
    read = pandas.read_csv(tmp_path / "run.csv", nrows=1)
    for name in NAMES[2:5]:
        assert any(name in heading for heading in read.columns), name


@pytest.mark.parametrize("suffix", [".uff", ".csv", ".nc", ".mat"])
def test_frequency_responses_keep_names_in_files_of_others(suffix, tmp_path):
    pytest.importorskip({".uff": "pyuff", ".nc": "h5netcdf"}.get(suffix, "scipy"))
    source = gb.Force(NAMES[2], 1.0)
    response = machine().frequency_response([100.0, 200.0, 300.0], source=source)
    path = tmp_path / f"response{suffix}"
    response.save(path, at=[NAMES[2], NAMES[4]])
    if suffix == ".uff":
        read = response.compare(path)
        assert read is not None


def test_an_animation_draws_names(run, tmp_path):
    pytest.importorskip("matplotlib")
    run.animate(tmp_path / "run.html", duration=0.1, fps=10.0)
    assert (tmp_path / "run.html").read_text("utf-8").startswith("<!DOCTYPE html>")


@pytest.mark.parametrize("command", ["check", "plot", "modes", "run", "response"])
@pytest.mark.parametrize("end", [[], ["--json"]])
def test_commands_take_names(command, end, tmp_path, capsys):
    path = tmp_path / "machine.toml"
    machine().save(path)
    arguments = {
        "plot": ["--out", tmp_path / "train.png"],
        "modes": ["--speed", 300.0],
        "run": ["--duration", 1e-3, "--speed", 300.0, "--record", NAMES[2]],
        "response": ["--source", f"{NAMES[2]}:y", "--at", NAMES[2], "--to", "50Hz", "--points", 3],
    }.get(command, [])
    with pytest.raises(SystemExit) as stopped:
        main([str(each) for each in (command, path, *arguments, *end)])
    out, error = capsys.readouterr()
    assert stopped.value.code == 0, error
    if end:
        json.loads(out)


@each_case(
    ("name", "text"),
    [
        ("a\nb", r'^shafts\[0\]\.name: must not contain the character U\+000A, got "a\\nb"'),
        ("a\x1b[31m", r"^shafts\[0\]\.name: must not contain the character U\+001B"),
        ("a\x85", r"^shafts\[0\]\.name: must not contain the character U\+0085"),
        ("a\ufffe", r"^shafts\[0\]\.name: must not contain the character U\+FFFE"),
        ("a\uffff", r"^shafts\[0\]\.name: must not contain the character U\+FFFF"),
        ("a\ud800", r"^shafts\[0\]\.name: must not contain the lone surrogate U\+D800"),
    ],
)
def test_characters_that_no_file_keeps_are_refused(name, text):
    with pytest.raises(gb.SceneError, match=text):
        gb.RotorSystem([gb.Shaft(name, length=1.0, outer_diameter=0.05)])


def test_a_file_cannot_have_them_either(tmp_path):
    path: Path = tmp_path / "machine.toml"
    machine().save(path)
    path.write_text(path.read_text("utf-8").replace("$a$", "a\\u0007"), "utf-8")
    with pytest.raises(
        gb.SceneError, match=r"shafts\[0\]\.name: must not contain the character U\+0007"
    ):
        gb.RotorSystem.load(path)
