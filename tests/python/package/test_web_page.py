"""The page that runs gearbow in a browser gives the numbers of the package.

The tests run where `make web` has built the page, and playwright and Chromium are installed.
"""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "target" / "web" / "try.html"
#: Milliseconds that a machine takes at most in the page.
TIME_LIMIT = 120_000

if not PAGE.exists():
    pytest.skip("the page is not built: make web", allow_module_level=True)
playwright = pytest.importorskip("playwright.sync_api")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
if CHROMIUM is None:
    pytest.skip("Chromium is not installed", allow_module_level=True)


@pytest.fixture(scope="module")
def page() -> Iterator[Any]:
    with playwright.sync_playwright() as run:
        browser = run.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        opened = browser.new_page(viewport={"width": 1400, "height": 1000}, offline=True)
        opened.errors = []
        opened.on("pageerror", lambda error: opened.errors.append(str(error)))
        opened.on(
            "console",
            lambda text: opened.errors.append(text.text) if text.type == "error" else None,
        )
        opened.goto(PAGE.as_uri())
        wait(opened)
        yield opened
        browser.close()


def wait(page: Any) -> None:
    page.wait_for_function("window.gearbowResults !== undefined", timeout=TIME_LIMIT)
    page.wait_for_function("!document.getElementById('compute').disabled", timeout=TIME_LIMIT)


def results(page: Any) -> Any:
    return json.loads(page.evaluate("JSON.stringify(window.gearbowResults)"))


def choose(page: Any, name: str) -> Any:
    page.evaluate("delete window.gearbowResults")
    page.select_option("#example", name)
    wait(page)
    return results(page)


def shown_examples(page: Any) -> list[str]:
    found = page.evaluate("Object.keys(EXAMPLES)")
    return [str(name) for name in found]


def test_every_example_computes_every_part_without_errors(page: Any) -> None:
    for name in shown_examples(page):
        found = choose(page, name)
        status = page.text_content("#status")
        assert set(found) == {"modes", "campbell", "synchronous", "run"}, f"{name}: {status}"
        assert page.evaluate("document.querySelectorAll('#drawing polygon').length") > 1, name
    assert page.errors == []


def test_five_numbers_are_those_of_the_package(page: Any) -> None:
    name = "double_stage_train"
    found = choose(page, name)
    system = gb.examples()[name].load()
    speed = gb.rpm(float(page.input_value("#speed")))
    fastest = gb.rpm(float(page.input_value("#fastest")))
    assert speed == pytest.approx(gb.examples()[name].speed, rel=1e-5)
    # The same operations in another order: WebAssembly has no fused or wide instructions.
    modes = system.modes(speed, count=12).frequencies_hz
    page_modes = [mode["frequency_hz"] for mode in found["modes"]]
    np.testing.assert_allclose(page_modes, modes, rtol=1e-9, atol=1e-5)
    speeds = fastest * np.arange(1, 26) / 25
    diagram = system.campbell(speeds, count=12, harmonics=1)
    criticals = [one["speed"] for one in found["campbell"]["intersections"]]
    np.testing.assert_allclose(criticals, [one.speed for one in diagram.intersections], rtol=1e-8)
    gear = found["synchronous"]["names"][0]
    y, z = system.synchronous([fastest]).displacement(gear)[0, 0]
    major = (abs(y - 1j * z) + abs(y + 1j * z)) / 2
    assert found["synchronous"]["semi_major_axes"][0][-1] == pytest.approx(major, rel=1e-8)
    # The run has the accuracy of the scene, and the page stores 4,000 samples at most.
    run = found["run"]
    response = system.simulate(run["time"][-1], speed, times=run["time"])
    mesh = response.mesh(run["meshes"][0]["name"])
    ratio, force = np.array(run["meshes"][0]["contact_ratio"]), np.array(run["meshes"][0]["force"])
    assert ratio.mean() == pytest.approx(mesh.contact_ratio.mean(), rel=1e-5)
    assert force.std() == pytest.approx(mesh.force.std(), rel=1e-2)


def test_a_bow_from_the_slider_moves_the_contact_ratio(page: Any) -> None:
    choose(page, "double_stage_train")
    spread = []
    for amplitude in ("0", "150"):
        page.evaluate("delete window.gearbowResults")
        page.evaluate("document.getElementById('shaft').selectedIndex = 1")
        page.evaluate(f"document.getElementById('bow').value = {amplitude}")
        page.click("#compute")
        wait(page)
        spread.append(float(np.ptp(results(page)["run"]["meshes"][0]["contact_ratio"])))
    # the other shafts of this train are bowed, too: 6e-3 of 0.6 is what this bow adds
    assert spread[1] - spread[0] > 1e-3


def test_the_largest_bow_is_that_of_the_package(page: Any) -> None:
    for name in ("double_stage_train", "idler_train"):
        choose(page, name)
        page.evaluate("delete window.gearbowResults")
        page.evaluate("delete window.gearbowLimits")
        page.evaluate("document.getElementById('shaft').selectedIndex = 1")
        page.evaluate("document.getElementById('shaft').dispatchEvent(new Event('change'))")
        wait(page)
        page.evaluate("document.getElementById('limits').click()")
        page.wait_for_function("window.gearbowLimits !== undefined", timeout=TIME_LIMIT)
        found = page.evaluate("window.gearbowLimits")
        system, shaft = gb.examples()[name].load(), page.input_value("#shaft")
        speed = gb.rpm(float(page.input_value("#speed")))
        limits = system.bow_limits(shaft, speed, shape=gb.Bow.half_sine(1e-4)).limits
        expected = {one.at: one.bow for one in limits if one.limit == "contact ratio"}
        assert [limit["mesh"] for limit in found] == list(expected)
        for limit in found:
            # The page adds the motions of all shafts; the package knows which angles go together.
            bow = expected[limit["mesh"]]
            if limit["bow"] is None:
                assert bow > 4.0 * max(gear.module for gear in system.gears)
            else:
                assert limit["bow"] == pytest.approx(bow, rel=0.02)
        assert any(limit["bow"] is not None for limit in found)
        assert page.is_visible("#limit-table")


def test_a_report_of_an_own_train_is_one_file(page: Any, tmp_path: Path) -> None:
    choose(page, "geared_pair")
    page.evaluate("delete window.gearbowResults")
    page.fill("#scene", "# my own train\n" + page.input_value("#scene"))
    page.click("#compute")
    wait(page)
    with page.expect_download() as download:
        page.click("#report")
    path = tmp_path / "report.html"
    download.value.save_as(path)
    text = path.read_text(encoding="utf-8")
    assert "# my own train" in text
    # the drawing, five plots, and twelve modes
    assert text.count("<img") == 5
    assert text.count("<tr>") >= 13
    assert "<script" not in text
    assert page.errors == []


def test_a_wrong_entry_is_named(page: Any) -> None:
    page.evaluate("delete window.gearbowResults")
    page.fill("#scene", '[[shafts]]\nname = "a"\nlength = "90 kg"\nouter_diameter = 0.01\n')
    page.click("#compute")
    wait(page)
    assert "shafts.length: must have a unit that converts to m" in page.text_content("#status")


def test_the_slider_begins_at_the_present_bow(page: Any) -> None:
    choose(page, "bowed_rotor")
    assert page.text_content("#bow-text") == "–"
    page.evaluate("delete window.gearbowResults")
    page.select_option("#shaft", "rotor")
    wait(page)
    assert page.text_content("#bow-text") == "40 µm"
    # a rotor without teeth has no contact ratio
    assert page.is_hidden("#meshing")
    assert page.errors == []


def test_a_narrow_page_does_not_scroll_sideways(page: Any) -> None:
    size = page.viewport_size
    page.set_viewport_size({"width": 400, "height": 800})
    page.wait_for_function("document.documentElement.scrollWidth === 400", timeout=TIME_LIMIT)
    page.set_viewport_size(size)
