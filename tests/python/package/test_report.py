"""Reports: sections, tables and figures of the page, what a system lacks, and the page in a browser."""

from __future__ import annotations

import ast
import base64
import gzip
import html
import json
import re
import shutil
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.report import page as texts
from gearbow.report.contents import SECTIONS, accuracy, bow, campbell, data
from gearbow.report.operation import resonances, strength
from gearbow.report.page import parts_tables, picture
from gearbow.report.shared import Contents, Options, table_range
from reference.equations import base_radius
from reference.machines import (
    bowed_rotor_with_disk,
    hostile,
    mirrored,
    rated,
    rotor_with_two_disks,
    without_tooth_errors,
)

SECTION_NAMES = (
    *("summary", "drawing", "data", "mass", "static", "life", "modes", "campbell", "criticals"),
    *("resonances", "stability", "response", "strength", "bow", "motion", "accuracy"),
    "reproduction",
)
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
#: Width and height of A4 without the margins of the page [px of CSS], 96 to an inch.
PAPER = (96 * 180 / 25.4, 96 * 263 / 25.4)


def read_sections(path: Path) -> dict[str, str]:
    """Return the content of each section of a report."""
    page = path.read_text(encoding="utf-8")
    return dict(re.findall(r'<section id="(\w+)">(.*?)</section>', page, re.DOTALL))


def rows(section: str, title: str) -> list[list[str]]:
    """Return the rows of a table, the headings first."""
    table = section[section.index(f"<caption>{title}") :].partition("</table>")[0]
    found = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row) for row in table.split("<tr>")[1:]]
    return [[html.unescape(cell) for cell in row] for row in found]


def written(system: gb.RotorSystem, folder: Path, **options: Any) -> Path:
    pytest.importorskip("matplotlib")
    pytest.importorskip("plotly")
    pytest.importorskip("jinja2")
    path = folder / "report.html"
    system.report(path, **options)
    return path


@pytest.fixture
def undrawn(monkeypatch):
    """Make figures without images: `page` draws one of each kind, which takes most of its time."""
    interactive = pytest.importorskip("gearbow.plotting.interactive")
    empty = {"layout": {"width": 1.0, "height": 1.0}}
    monkeypatch.setattr(interactive, "converted", lambda *_: empty)
    monkeypatch.setattr(interactive, "write_png", lambda *_: None)


@pytest.fixture
def only(monkeypatch) -> Callable[..., None]:
    """Leave some sections in the reports of a test."""
    compose = pytest.importorskip("gearbow.report.compose")

    def choose(*names: str) -> None:
        monkeypatch.setattr(compose, "SECTIONS", [one for one in SECTIONS if one[0] in names])

    return choose


@pytest.fixture(scope="module")
def train() -> gb.RotorSystem:
    return rated(hostile())


@pytest.fixture(scope="module")
def page(train, tmp_path_factory) -> Path:
    return written(
        train,
        tmp_path_factory.mktemp("report"),
        operating=(gb.rpm(900.0), gb.rpm(1000.0)),
        speeds=np.linspace(20.0, 400.0, 20),
        modes=4,
        title="a <pair>",
    )


def test_a_report_is_one_file_with_every_section(page):
    text = page.read_text(encoding="utf-8")
    assert tuple(read_sections(page)) == SECTION_NAMES
    assert "matplotlib" not in re.sub(
        r"<script.*?</script>|src=\"[^\"]*\"", "", text, flags=re.DOTALL
    )
    assert "<title>a &lt;pair&gt;</title>" in text
    # The page loads nothing; addresses in the script of plotly are texts.
    (script,) = re.findall(r'<script type="text/plain" id="plotly">(.*?)</script>', text, re.DOTALL)
    assert "plotly.js v" in unpacked(script)[:1000]
    without = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    addresses = re.findall(r'(?:src|href)="(.{5})', without)
    assert addresses
    assert all(address.startswith(("data:", "#")) for address in addresses)
    for section in read_sections(page).values():
        for image, figure in zip(
            re.findall(r'<img class="image" src="data:image/([^"]*)', section),
            re.findall(r'<script type="text/plain">(.*?)</script>', section, re.DOTALL),
            strict=True,
        ):
            kind, data = image.split(";base64,")
            assert base64.b64decode(data).startswith(b"\x89PNG" if kind == "png" else b"<?xml")
            assert json.loads(unpacked(figure))["data"]
    assert len(text) < 6e6


def unpacked(text: str) -> str:
    """Give a text that the script of the page unpacks."""
    return gzip.decompress(base64.b64decode(text)).decode()


def eigenvalues(system: gb.RotorSystem, speed: float) -> np.ndarray:
    """Return the eigenvalues of the dense first-order matrix [rad/s]."""
    given = system.matrices(speed)
    rate, nothing = given.damping + speed * given.gyroscopic, np.zeros_like(given.mass)
    right = np.block([[nothing, np.eye(len(nothing))], [-given.stiffness, -rate]])
    right[len(nothing) :] = np.linalg.solve(given.mass, right[len(nothing) :])
    return np.linalg.eigvals(right)


def check_tables(page: Path, system: gb.RotorSystem, speed: float) -> None:
    """Compare modes and mesh forces of a report with dense matrices and the equilibrium of the torques."""
    sections = read_sections(page)
    head, *found = rows(sections["modes"], "Modes at")
    assert head[:3] == ["mode", "frequency [Hz]", "damping [%]"]
    values = eigenvalues(system, speed)
    vibrating = np.sort(values.imag[values.imag > 0.05 * np.abs(values)]) / (2.0 * np.pi)
    printed = np.array([float(row[1]) for row in found])
    # the lowest four, and perhaps more that decay fast; three decimals are printed
    for value in vibrating[:4]:
        assert np.abs(printed - value).min() < 6e-4
    for row in found:
        assert np.abs(values.imag / (2.0 * np.pi) - float(row[1])).min() < 6e-4
    _, *decaying = rows(sections["stability"], "Logarithmic decrement")
    assert len(decaying) >= 4
    for row in decaying:
        near = values[np.abs(values.imag / (2.0 * np.pi) - float(row[1])).argmin()]
        # the logarithm of the ratio of amplitudes one period apart
        decrement = -2.0 * np.pi * near.real / near.imag
        assert float(row[2]) == pytest.approx(decrement, rel=1e-3)
    torque, power = system.torques[0].value, {}
    ratios = dict(zip([shaft.name for shaft in system.shafts], system.speed_ratios, strict=True))
    gears = {gear.name: gear for gear in system.gears}
    _, *meshes = rows(sections["static"], "Meshes at equilibrium")
    assert len(meshes) == len(system.meshes)
    for row, mesh in zip(meshes, system.meshes, strict=True):
        driver = gears[mesh.driver]
        # every mesh transmits the whole power of the torque on the input
        power[mesh.driver] = torque / abs(ratios[driver.shaft])
        lead = np.arcsin(np.sin(driver.helix_angle) * np.cos(driver.pressure_angle))
        force = power[mesh.driver] / (base_radius(driver) * np.cos(lead))
        # without backlash, teeth pull against the sense of the torque
        assert float(row[1]) == pytest.approx(np.sign(speed * torque) * force, rel=1e-5)


def test_tables_are_those_of_the_results(page, train):
    check_tables(page, train, gb.rpm(1000.0))
    sections = read_sections(page)
    static = train.static(gb.rpm(1000.0))
    _, first, *_ = rows(sections["static"], "Meshes at equilibrium")
    assert float(first[4]) == pytest.approx(
        np.degrees(static.mesh("g1/g2").pressure_angle), rel=1e-5
    )
    life = static.bearing_life()
    head, *bearings = rows(sections["life"], "Life of bearings")
    hours = [row[head.index("life [h]")] for row in bearings]
    assert [float(one) for one in hours] == pytest.approx(list(life.hours), rel=1e-3)
    assert "Shortest basic rating life" in sections["summary"]
    _, *shafts = rows(sections["data"], "Shafts")
    assert [row[0] for row in shafts] == ["input", "idler", "middle", "output"]
    assert any("amplitude 0.1 mm" in cell for cell in shafts[0])
    _, *masses = rows(sections["mass"], "Mass properties of the shafts")
    shaft = train.shafts[0]
    own = 7850.0 * np.pi / 4.0 * shaft.outer_diameter**2 * shaft.length
    gear = train.gears[0]
    radius = 0.5 * gear.teeth * gear.module / np.cos(gear.helix_angle)
    own += 7850.0 * np.pi * radius**2 * gear.face_width
    assert float(masses[0][1]) == pytest.approx(own, rel=1e-3)  # of the four printed digits


@pytest.mark.usefixtures("undrawn")
def test_a_report_at_a_negative_speed(train, tmp_path):
    # without teeth that excite, the motion is a sum of those of the shafts, which is cheap
    system, speed = without_tooth_errors(train), -gb.rpm(1000.0)
    path = written(system, tmp_path, operating=speed, speeds=[50.0, 100.0, 150.0], modes=4)
    check_tables(path, system, speed)
    for name, text in read_sections(path).items():
        assert "Not computed" not in text, name


@pytest.mark.usefixtures("undrawn")
def test_a_report_shows_the_modes_of_its_sense_of_rotation(only, tmp_path):
    # all that has a sense is turned around in the image, and the operating speed with it
    machine = hostile()
    only("campbell", "criticals", "resonances")
    shown = []
    for system, sign in ((machine, -1.0), (mirrored(machine), 1.0), (machine, 1.0)):
        found = []
        folder = tmp_path / f"{len(shown)}"
        folder.mkdir()
        speeds = sign * np.linspace(20.0, 110.0, 4)
        sections = read_sections(
            written(system, folder, operating=75.0 * sign, speeds=speeds, modes=5)
        )
        for name, title in (
            ("campbell", "Intersections and stability thresholds"),
            ("summary", "Modes that orders of shafts and teeth meet near the operating speed"),
        ):
            head, *body = rows(sections[name], title)
            at, frequency = (
                next(i for i, each in enumerate(head) if each.startswith(word))
                for word in ("speed", "frequency")
            )
            # meshes with the same orders come in any order
            found += sorted((float(row[at]) * sign, float(row[frequency])) for row in body)
        shown.append(np.array(found))
    own, image, forward = shown
    assert own == pytest.approx(image, rel=1e-4)  # of the printed digits
    assert len(own) != len(forward) or np.abs(own - forward).max() > 0.1


def test_the_unbalance_of_api_617(page):
    head, *found = rows(read_sections(page)["criticals"], "Unbalance of API 617, 2")
    amount, mass, speed = (
        head.index(next(name for name in head if name.startswith(word)))
        for word in ("unbalance", "mass", "speed")
    )
    assert found
    for row in found:
        expected = 2 * 6350 * float(row[mass]) / float(row[speed])
        assert float(row[amount]) == pytest.approx(expected, rel=2e-3)  # of printed digits


def test_level_1_of_api_617(only, tmp_path):
    # In an isotropic rotor the cross-coupled stiffness that removes the damping c of a bearing at
    # its place is c ω, and the curve of the decrement is a line up to the change of ω.
    rotor = bowed_rotor_with_disk()
    only("stability")
    path = written(rotor, tmp_path, operating=100.0, speeds=[50.0, 100.0, 150.0], modes=4)
    text = html.unescape(read_sections(path)["stability"])
    limit = float(re.search(r"zero at Q₀ = ([\d.e+]+) N/m", text)[1])
    (disk,) = rotor.disks

    def damping(stiffness: float) -> float:
        cross = [[0.0, stiffness], [-stiffness, 0.0]]
        added = gb.Bearing(disk.shaft, disk.position, stiffness=cross)
        modes = rotor.replace(bearings=[*rotor.bearings, added]).modes(100.0, count=4)
        return float(modes.damping_ratios[[w == "forward" for w in modes.whirl]].min())

    # the curve has seven points, between which it is a line
    assert damping(0.95 * limit) > 0.0 > damping(1.05 * limit)


def test_level_1_of_a_soft_rotor_on_unequal_bearings(only, tmp_path):
    # Two planar modes keep their small damping until the cross-coupled stiffness couples them; in
    # a larger one the search of 1e6 N/m missed the zero.
    kit = gb.examples()["bowed_rotor"]
    only("stability")
    path = written(kit.load(), tmp_path, operating=kit.speed, modes=4)
    text = html.unescape(read_sections(path)["stability"])
    limit = float(re.search(r"zero at Q₀ = ([\d.e+]+) N/m", text)[1])
    rotor = kit.load()

    def damping(stiffness: float) -> float:
        cross = [[0.0, stiffness], [-stiffness, 0.0]]
        added = gb.Bearing("rotor", rotor.disks[0].position, stiffness=cross)
        return float(
            rotor.replace(bearings=[*rotor.bearings, added])
            .modes(kit.speed, count=2)
            .damping_ratios.min()
        )

    # the zero is found to 1 % of the decrement, and is printed with three digits
    assert damping(0.98 * limit) > 0.0 > damping(1.02 * limit)


def test_tables_have_no_round_off(page):
    for name, section in read_sections(page).items():
        cells = re.findall(r'<td class="n">([^<]*)</td>', section)
        if name in ("mass", "modes", "life"):
            # numbers are aligned at the right, words at the left
            assert len(cells) > 4
            assert all(re.search(r"\d", cell) or cell in ("", "–") for cell in cells), name
        if name != "accuracy":  # residuals are round-off
            assert not [
                cell for cell in cells if re.search(r"e-\d\d", cell) and abs(float(cell)) < 1e-9
            ]
        assert "inf" not in cells


def test_speeds_have_both_units_and_frequencies(page):
    text = page.read_text(encoding="utf-8")
    assert "900 rpm to 1000 rpm (94.2478 rad/s to 104.72 rad/s), of the reference shaft" in text
    head, *shafts = rows(read_sections(page)["drawing"], "Shafts and tooth frequencies")
    assert head[2:] == ["speed [rpm]", "1× [Hz]", "gears (teeth)", "tooth frequency [Hz]"]
    # g1 with 23 teeth drives g2 with 31, g2 drives g3 with 47; g4 with 29 drives g5 with 53
    turns = np.array([1.0, -23 / 31, 23 / 47, -23 / 47 * 29 / 53])
    assert [float(row[2]) for row in shafts] == pytest.approx(1000.0 * turns, rel=1e-4)
    assert [float(row[3]) for row in shafts] == pytest.approx(np.abs(turns) * 1e3 / 60, rel=1e-4)
    assert shafts[0][5] == shafts[1][5] == shafts[2][5].split(", ")[0]
    assert shafts[2][5].split(", ")[1] == shafts[3][5]
    for row, expected in ((shafts[0], 23e3 / 60), (shafts[3], 29 * 23 / 47 * 1e3 / 60)):
        assert float(row[5]) == pytest.approx(expected, rel=1e-4)


def test_segments_have_a_table():
    rotor = gb.examples()["dual_rotor"].load()
    (table,) = [one for one in parts_tables(rotor) if one.title.startswith("Segments of shafts")]
    assert list(table.head)[:3] == ["of", "length [mm]", "outer diameter [mm]"]
    assert len(table.rows) == sum(len(shaft.segments) for shaft in rotor.shafts)
    assert any("high at 680 mm" in row for one in parts_tables(rotor) for row in one.rows)


def test_the_page_says_whether_the_steady_state_of_a_train_is_stable(page, train):
    text = html.unescape(read_sections(page)["motion"])
    assert "The steady state is stable" in text
    values = eigenvalues(train, gb.rpm(1000.0))
    # the rotation of the train is free: its eigenvalue 0 has round-off
    assert np.all(values.real < 1e-6 * np.abs(values).max())


@pytest.mark.usefixtures("undrawn")
def test_what_a_system_lacks_is_said(tmp_path):
    path = written(rotor_with_two_disks(), tmp_path)  # neither speeds nor meshes
    sections = {name: html.unescape(text) for name, text in read_sections(path).items()}
    assert "no operating speed was given (operating=, or --speed)" in sections["motion"]
    assert "no speeds were given (speeds=, or --to)" in sections["campbell"]
    assert "Campbell diagram: not complete" in sections["summary"]
    # what was computed before the error stays
    assert "Logarithmic decrement at standstill" in sections["stability"]
    assert "<table>" in sections["modes"]


@pytest.mark.usefixtures("undrawn")
def test_an_unexpected_error_ends_one_section(tmp_path, monkeypatch):
    def fails(*_: object, **__: object) -> None:
        raise ValueError("a fault of the program")

    for name in ("bow_limits", "static", "campbell", "synchronous", "critical_speed_map"):
        monkeypatch.setattr(gb.RotorSystem, name, fails)
    rotor_with_two_disks().report(tmp_path / "page.html", operating=100.0)
    text = html.unescape((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert "not computed, because an unexpected ValueError: a fault of the program" in text
    assert "Not computed: an unexpected ValueError" in text
    assert "Reproduction" in text


@pytest.mark.usefixtures("undrawn")
def test_torsion_alone(tmp_path):
    line = gb.examples()["torsional_drive_line"]
    path = written(line.load(), tmp_path, operating=line.speed, modes=3)
    sections = read_sections(path)
    assert "the system has no lateral motion" in sections["response"]
    assert "A bow has no effect" in sections["bow"]
    assert "Twist of gears and disks" in sections["motion"]
    assert "Not computed" not in "".join(sections.values())


@pytest.mark.usefixtures("undrawn")
def test_ctrl_c_keeps_finished_sections(train, tmp_path):
    def stop(fraction: float) -> None:
        if fraction > 0.19:  # three of fifteen sections
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        written(train, tmp_path, operating=100.0, progress=stop)
    sections = read_sections(tmp_path / "report.html")
    assert tuple(sections) == ("summary", "drawing", "data", "mass", "reproduction")
    assert "The report was stopped. It lacks: Static loads" in sections["summary"]


def test_the_program_of_a_report_makes_it_again(page, train, tmp_path, monkeypatch):
    section = read_sections(page)["reproduction"]
    links = re.findall(r'href="data:text/plain;base64,([^"]*)" download="([^"]*)"', section)
    files = {name: base64.b64decode(data).decode() for data, name in links}
    (tmp_path / "scene.toml").write_text(files["scene.toml"], encoding="utf-8")
    assert gb.RotorSystem.load(tmp_path / "scene.toml").description == train.description
    given: dict[str, Any] = {}
    monkeypatch.setattr(gb.RotorSystem, "report", lambda _, path, **o: given.update(o, path=path))
    monkeypatch.chdir(tmp_path)
    exec(files["report.py"], {})
    assert given["operating"] == (gb.rpm(900.0), gb.rpm(1000.0))
    assert (given["path"], given["modes"], given["title"]) == ("report.html", 4, "a <pair>")
    np.testing.assert_allclose(given["speeds"], np.linspace(20.0, 400.0, 20))


def test_wrong_arguments(train, tmp_path):
    with pytest.raises(gb.SceneError, match=r"path: must end with \.html"):
        train.report(tmp_path / "report.pdf")
    with pytest.raises(gb.SceneError, match="operating: must be above 0"):
        train.report(tmp_path / "report.html", operating=(-1.0, 1.0))
    with pytest.raises(gb.SceneError, match="tensile_strength: the line for mean stresses"):
        train.report(tmp_path / "report.html", endurance_limit=250e6)
    with pytest.raises(gb.SceneError, match="language: "):
        train.report(tmp_path / "report.html", language="fr")
    with pytest.raises(FileNotFoundError):
        train.report(tmp_path / "none" / "report.html")


@pytest.fixture(scope="module")
def browser():
    api = pytest.importorskip("playwright.sync_api")
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip(f"there is no browser ({', '.join(BROWSERS)})")
    with api.sync_playwright() as program:
        # Software draws in three dimensions where there is no graphics card.
        options = ["--no-sandbox", "--enable-unsafe-swiftshader"]
        started = program.chromium.launch(executable_path=found, args=options)
        yield started
        started.close()


@pytest.fixture
def opened(browser, page) -> Callable[..., Any]:
    contexts = []

    def open_page(**options: Any) -> Any:
        context = browser.new_context(viewport={"width": 1100, "height": 900}, **options)
        contexts.append(context)
        shown = context.new_page()
        shown.set_default_timeout(120_000.0)  # a busy machine draws slowly
        shown.problems = []
        shown.on("pageerror", lambda error: shown.problems.append(str(error)))
        shown.on(
            "console",
            lambda message: message.type == "error" and shown.problems.append(message.text),
        )
        shown.goto(page.as_uri(), wait_until="domcontentloaded")
        return shown

    yield open_page
    for context in contexts:
        context.close()


def test_a_browser_shows_figures_that_zoom(opened):
    shown = opened()
    assert shown.locator("section").count() == len(SECTION_NAMES)
    figure = shown.locator("#campbell .interactive")
    figure.scroll_into_view_if_needed()
    figure.locator(".main-svg").first.wait_for()
    assert not shown.locator("#campbell img.image").is_visible()
    panel = figure.locator(".nsewdrag").first
    box = panel.bounding_box()
    assert box["width"] > 500
    read = "figure => [...figure.querySelector('.js-plotly-plot')._fullLayout.xaxis.range]"
    before = figure.evaluate(read)
    # hover over a point of a curve
    place = figure.evaluate(
        """figure => {
            const plot = figure.querySelector('.js-plotly-plot'), full = plot._fullLayout;
            const one = plot._fullData.find(t => t.xaxis === 'x' && t.x.length > 5 && t.visible);
            const middle = Math.floor(one.x.length / 2);
            return [full.xaxis.l2p(one.x[middle]), full.yaxis.l2p(one.y[middle])];
        }"""
    )
    shown.mouse.move(box["x"] + place[0] - 3, box["y"] + place[1])
    shown.mouse.move(box["x"] + place[0], box["y"] + place[1])
    figure.locator(".hoverlayer .hovertext").first.wait_for()
    assert "frequency [Hz]" in figure.locator(".hoverlayer").text_content()
    # drag over a part of the panel
    x, y = box["x"] + 0.3 * box["width"], box["y"] + 0.3 * box["height"]
    shown.mouse.move(x, y)
    shown.mouse.down()
    shown.mouse.move(x + 200, y + 120, steps=4)
    shown.mouse.up()
    shown.wait_for_function(
        "before => document.querySelector('#campbell .js-plotly-plot')"
        "._fullLayout.xaxis.range[0] > before + 1",
        arg=before[0],
    )
    assert shown.problems == []


def test_a_page_without_scripts_shows_images(opened):
    shown = opened(java_script_enabled=False)
    images = shown.locator("img.image")
    assert images.count() > 8
    for number in range(images.count()):
        assert images.nth(number).is_visible()


def test_figures_and_tables_fit_on_paper(opened, tmp_path):
    shown = opened()
    shown.set_viewport_size({"width": round(PAPER[0]), "height": 900})
    shown.emulate_media(media="print")
    shown.wait_for_function(
        "() => [...document.images].every(image => image.complete && image.naturalWidth)"
    )
    sizes = shown.evaluate(
        "() => [...document.querySelectorAll('figure, table')].map(each => {"
        " const box = each.getBoundingClientRect();"
        " return [each.tagName, each.innerText.slice(0, 60), box.width, box.height]; })"
    )
    for kind, name, width, height in sizes:
        assert 0.0 < width <= PAPER[0] + 1.0, name
        assert kind == "TABLE" or height < PAPER[1], name
    shown.pdf(path=tmp_path / "report.pdf", prefer_css_page_size=True)
    assert (tmp_path / "report.pdf").read_bytes().startswith(b"%PDF")


def test_a_report_shows_oscillations_among_overdamped_modes():
    """Internal damping makes many motions overdamped, and gyroscopic moments let these turn slowly."""
    shaft = gb.Shaft("s", length=0.8, outer_diameter=0.04, elements=12, internal_damping=1e-4)
    rotor = gb.RotorSystem(
        [shaft],
        disks=[gb.Disk("d", "s", 0.6, 10.0, diametral_inertia=0.05, polar_inertia=0.1)],
        bearings=[gb.Bearing("s", x, stiffness=5e7, damping=2e4) for x in (0.0, 0.5)],
    )
    modes = Contents(rotor, Options("", (300.0, 300.0), None, 8, (), "rad/s")).modes
    slow = (modes.eigenvalues.imag > 0.0) & (modes.damping_ratios > 0.99)
    assert slow.sum() > 4
    assert np.sum(modes.damping_ratios < 0.9) >= 8


@pytest.mark.usefixtures("undrawn")
def test_undamped_rolling_bearings_have_a_short_run_in_place_of_a_steady_state(only, tmp_path):
    shaft = gb.Shaft("rotor", length=0.4, outer_diameter=0.03)
    bearings = [gb.RollingBearing("rotor", at, "6206") for at in (0.0, 0.4)]
    disk = gb.Disk("disk", "rotor", 0.2, 5.0, 0.01, 0.02, unbalance=1e-5)
    system = gb.RotorSystem([shaft], bearings=bearings, disks=[disk], gravity=9.81)
    only("motion")
    sections = read_sections(written(system, tmp_path, operating=gb.rpm(3000)))
    text = next(section for section in sections.values() if "Motion at 3000 rpm" in section)
    assert "a run over 360° of the reference shaft, as a mode has no damping" in text


def test_a_report_of_a_file_says_what_its_reader_assumed():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        train = gb.read(
            Path(__file__).parents[1] / "files" / "gearbox.rexs", bearings={"other": 1e8}
        )
    shaft = gb.Shaft("rotor", length=0.4, outer_diameter=0.03)
    bearings = [gb.RollingBearing("rotor", at, "6206") for at in (0.0, 0.4)]
    rotor = gb.RotorSystem([shaft], bearings=bearings)
    options = Options("", (157.0, 157.0), np.linspace(10.0, 20.0, 3), 4, (), "rad/s")
    warned = list(accuracy(Contents(train, options)))[-1]
    assert [row for row in warned.rows if row[0] == "file"] == [("file", n) for n in train._notes]
    assert train._notes
    assumed = [
        block
        for block in data(Contents(rotor, options))
        if "Assumed" in getattr(block, "title", "")
    ]
    text = "number and size of rolling elements by estimates, stiffness within 15%"
    assert ["bearings", text] in [list(row) for row in assumed[0].rows]
    # Between 10 and 20 rad/s no line crosses a mode of this rotor.
    *_, note = campbell(Contents(rotor, options))
    assert note.text.startswith("No line of excitation crosses a mode")


def test_a_run_without_damping_has_a_tooth_of_every_mesh():
    system = hostile()
    options = Options("", (-100.0, -100.0), None, 4, (), "rad/s")
    turns = Contents(system, options)._tooth_turns()
    ratios = dict(zip([shaft.name for shaft in system.shafts], system.speed_ratios, strict=True))
    teeth = [turns * abs(ratios[gear.shaft]) * gear.teeth for gear in system.gears]
    assert turns >= 1.0
    assert min(teeth) >= 1.0 - 1e-12  # round-off


def found_in_summary(contents: Contents, make: Callable[..., Any]) -> list[Any]:
    """Give what a section adds to the summary."""
    list(make(contents))
    return [block for _, block in contents.findings]


def test_the_summary_names_resonances_of_teeth_and_shafts():
    # g4 with 29 teeth has 23/47 of the speed of the input. The tooth frequency is 0.9 % below that of
    # a mode, which the gyroscopic moments change with the speed.
    system, order, near = hostile(), 29 * 23 / 47, 100.0
    for _ in range(3):
        frequency = system.modes(near, count=6).frequencies_hz[2]
        near = 2.0 * np.pi * frequency / order / 1.009
    contents = Contents(system, Options("", (near, near), None, 4, (), "rad/s"))
    table, text = found_in_summary(contents, resonances)
    (row,) = [row for row in table.rows if float(row[6]) == 0.9]
    assert (row[0], row[3]) == ("3", "1× teeth of g4–g5")
    assert float(row[4]) == pytest.approx(order, rel=4e-4)  # of four printed digits
    assert float(row[1]) == pytest.approx(frequency, rel=1e-5)  # of three decimals
    assert "0.9 % beside the operating speed" in text.text
    assert text.warning
    # The response is that of the mesh to 1 µm at the resonance.
    mesh = ("g4", "g5")
    response = system.mesh_response(mesh, speeds=[float(row[5])])
    force = abs(response.mesh_force(mesh)).max()
    assert float(row[7].split(" ")[0]) == pytest.approx(force, rel=1e-2)  # of the printed speed


def test_the_summary_has_the_largest_utilisation():
    train = hostile()
    limits = {"endurance_limit": 250e6, "tensile_strength": 600e6}
    options = Options("", (-100.0, -100.0), None, 4, (), "rad/s")
    (alone,) = found_in_summary(Contents(train, options), strength)
    assert "no endurance limit was given" in alone.text
    (text,) = found_in_summary(Contents(train, replace(options, **limits)), strength)
    found = train.stresses(-100.0, **limits)
    assert f"utilisation of a shaft: {found.utilisation.max():.3f} " in text.text


def test_bow_limits_above_the_diameter_are_none(monkeypatch):
    rotor = gb.examples()["bowed_rotor"].load()
    options = Options("", (100.0, 100.0), None, 4, (), "rad/s")
    limit = gb.results.ReachedLimit("displacement", "far", 100.0, 8.0)
    made = gb.results.BowLimits(("rotor",), 0.0, np.array([100.0]), (limit,))
    monkeypatch.setattr(gb.RotorSystem, "bow_limits", lambda *_, **__: made)
    contents = Contents(rotor, options)
    table, _ = list(bow(contents))
    assert table.rows[0][3] == "–"
    assert "above the diameter of the shaft" in table.rows[0][-1]
    assert [one.text for _, one in contents.findings] == [
        "No bow of rotor up to its diameter reaches a limit."
    ]


def test_default_speeds_stay_within_the_tables_of_bearings():
    table = gb.SpeedTable([0.0, 80.0, 120.0], [1e7, 1.1e7, 1.2e7])
    shaft = gb.Shaft("rotor", length=0.4, outer_diameter=0.03)
    bearings = [gb.Bearing("rotor", at, stiffness=table) for at in (0.0, 0.4)]
    rotor = gb.RotorSystem([shaft], bearings=bearings)
    assert table_range(rotor) == (0.0, 120.0)
    held = gb.SpeedTable([0.0, 80.0, 120.0], [1e7, 1.1e7, 1.2e7], outside="hold")
    others = [gb.Bearing("rotor", at, stiffness=held) for at in (0.0, 0.4)]
    assert table_range(rotor.replace(bearings=others)) == (0.0, np.inf)


def test_modes_have_one_numbering():
    # The rotation of the train is mode 1, which a Campbell diagram does not have.
    speed = 130.0
    options = Options("", (speed, speed), np.linspace(0.05, 1.5, 5) * speed, 4, (), "rad/s")
    contents = Contents(hostile(), options)
    diagram = contents.campbell
    numbers = contents.numbers(diagram)
    at = int(np.abs(diagram.speeds - speed).argmin())
    np.testing.assert_allclose(
        diagram.frequencies_hz[at], contents.modes.frequencies_hz[np.array(numbers) - 1], rtol=1e-8
    )
    table = next(block for block in campbell(contents) if getattr(block, "kind", "") == "table")
    assert {int(row[4]) for row in table.rows} <= set(numbers)
    assert min(numbers) == 2
    assert diagram.eigenvalues.shape == (diagram.speeds.size, 4)
    # half as many modes would end below the tooth frequencies
    found = contents.modes.frequencies_hz
    assert found.max() > contents.excited > found[: found.size // 2].max()


def sentences() -> set[str]:
    """Give every text that the program of the report says: literals, and those of tables."""
    found = {title for _, title, _ in SECTIONS}
    found |= {"company", "author", "document number", "date"}
    for path in Path(texts.__file__).parent.glob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        constants = {
            node.targets[0].id: node.value.value
            for node in tree.body
            if isinstance(node, ast.Assign)
            and isinstance(node.targets[0], ast.Name)
            and isinstance(node.value, ast.Constant)
        }
        for node in ast.walk(tree):
            func = node.func if isinstance(node, ast.Call) else None
            says = getattr(func, "id", getattr(func, "attr", "")) in ("say", "note", "find")
            if says:
                (text, *_) = node.args
                if isinstance(text, ast.Constant):
                    found.add(text.value)
                elif isinstance(text, ast.Name) and text.id in constants:
                    found.add(constants[text.id])
    return found


def test_every_sentence_has_a_german_one():
    tables = texts.german()
    assert sentences() == set(tables["sentences"])
    places = re.compile(r"\{\w+\}")
    for english, german in {**tables["sentences"], **tables["words"]}.items():
        assert sorted(places.findall(english)) == sorted(places.findall(german)), english


@pytest.mark.usefixtures("undrawn")
def test_a_german_report(tmp_path):
    shaft = gb.Shaft("disk shaft", length=0.4, outer_diameter=0.03)
    disk = gb.Disk("mesh", "disk shaft", 0.2, 5.0, 0.01, 0.02, unbalance=1e-5)
    rating = {"dynamic_rating": 3e4, "static_rating": 2e4}
    bearings = [
        gb.Bearing("disk shaft", at, stiffness=1e7, damping=1e3, **rating) for at in (0, 0.4)
    ]
    rotor = gb.RotorSystem([shaft], disks=[disk], bearings=bearings, gravity=(0.0, -9.81))
    options = {"operating": gb.rpm(3000.0), "modes": 3, "speeds": np.linspace(50.0, 500.0, 9)}
    german = written(
        rotor, tmp_path, language="de", company="Ä & Söhne", document_number="4711", **options
    )
    page = german.read_text(encoding="utf-8")
    assert '<html lang="de">' in page
    assert "<dt>Firma</dt><dd>Ä &amp; Söhne</dd>" in page
    section = read_sections(german)["modes"]
    head, *found = rows(section, "Eigenschwingungen bei 3000 rpm")
    assert head == [
        "Eigenform",
        "Frequenz [Hz]",
        "Dämpfung [%]",
        "Bewegungsform",
        "größte Bewegung",
    ]
    assert {row[3] for row in found} <= {
        "Gleichlauf",
        "Gegenlauf",
        "eben",
        "axial",
        "Torsion",
        "starr",
    }
    head, first, _ = rows(read_sections(german)["life"], "Lebensdauer der Lager")
    assert head[:3] == ["Lager", "Radialkraft [N]", "P [N]"]
    assert (first[0], first[4]) == ("disk shaft bei 0 m", "gegeben")
    assert "Lager disk shaft bei 0 m." in read_sections(german)["summary"]
    assert "enthalten: Schmierung und Verunreinigung" in read_sections(german)["life"]
    accuracy_ = read_sections(german)["accuracy"]
    assert "Freiheitsgrade.</p>" in accuracy_
    assert "Stufe Engineering: erwarteter" in accuracy_
    # Bows that are no limits leave the unit of the speed.
    assert rows(read_sections(german)["bow"], "Grenzen")[0][2] == "Drehzahl [rpm]"
    # Headings of tables have German words, and names of the user stay.
    words = texts.german()["words"]
    texts_of = re.sub(r"<(script|style|pre).*?</\1>|<img[^>]*>", "", page, flags=re.DOTALL)
    for heading in re.findall(r"<th[^>]*>(.*?)</th>", texts_of):
        name = html.unescape(heading).partition(" [")[0]
        assert name not in words or words[name] == name, name
    assert "<td>mesh</td>" in texts_of
    # Numbers have the digits of the English page.
    frequencies = rotor.modes(gb.rpm(3000.0), count=len(found)).frequencies_hz
    assert [row[1] for row in found] == [f"{one:.3f}" for one in frequencies]


def test_a_german_figure_has_german_names_of_ticks():
    pytest.importorskip("matplotlib")
    pytest.importorskip("plotly")
    figure = rated(hostile()).bearing_life(gb.rpm(900.0)).plot()
    with texts.speaking("de", ()):
        picture(figure, "")
    figure.canvas.draw()
    (panel,) = figure.axes
    assert panel.get_xlabel() == "Lebensdauer [h]"
    labels = [label.get_text() for label in panel.get_yticklabels()]
    assert all(" bei " in label for label in labels), labels


def test_a_result_with_other_fields_keeps_its_unit_of_speed():
    found = rated(hostile()).synchronous(gb.rpm(np.array([900.0, 950.0])))
    assert found.subtract_slow_roll(gb.rpm(100.0)).speed_unit == "rpm"


def test_elements_for_the_limits_of_all_bows_are_chosen_once(monkeypatch):
    pytest.importorskip("matplotlib")
    system, speed = hostile(), -100.0
    made = []
    of_class = gb.RotorSystem.bow_limits

    def limits(self, *args, **options):
        made.append((self, of_class(self, *args, **options)))
        return made[-1][1]

    monkeypatch.setattr(gb.RotorSystem, "bow_limits", limits)
    list(bow(Contents(system, Options("rotor", (speed, speed), None, 8, (), "rad/s"))))
    assert len(made) == len(system.shafts) > 1
    # Shafts that give numbers of elements leave nothing to choose.
    assert [used._model.choice for used, _ in made] == len(made) * [None]
    shaft = system.shafts[0].name
    own = of_class(system, shaft, speed)
    expected = {(one.limit, one.at): one.bow for one in own.limits}
    found = {(one.limit, one.at): one.bow for one in made[0][1].limits}
    # Bows are found to 1e-6; a table has four digits.
    assert {key: found[key] for key in expected} == pytest.approx(expected, rel=1e-5)


def test_a_housing_of_modes_has_a_line_and_a_table_of_its_interfaces():
    system = gb.examples()["housed_pair"].load()
    # a bearing on a housing has no table of coefficients that depend on another shaft
    assert table_range(system) == (0.0, np.inf)
    options = Options("", (150.0, 150.0), None, 4, (), "rad/s")
    assert Contents(system, options).sensors == ["sensor at bearing"]
    tables = {table.title: table for table in parts_tables(system)}
    assert tables["Housings"].rows[0][-1] == "91 modes up to 15 kHz"
    interfaces = tables["Interfaces of elastic housings"]
    assert interfaces.rows[0] == [
        *("housing", "foot back left", "0, 220, -120", "100, 100, 300", "5000, 5000, 5000")
    ]
    assert len(interfaces.rows) == 9
