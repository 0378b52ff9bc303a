"""The gallery runs, and the documentation site is complete; `make docs` builds it and checks its links."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import pytest

import gearbow as gb

ROOT = Path(__file__).parents[3]
SITE = ROOT / "docs" / "site"
GALLERY = sorted((ROOT / "examples" / "gallery").glob("*.py"))

pytestmark = pytest.mark.skipif(not SITE.is_dir(), reason="the documents are not installed")


@pytest.fixture
def site(monkeypatch: pytest.MonkeyPatch):
    """Make the modules of the site importable."""
    monkeypatch.syspath_prepend(SITE)
    yield
    for name in ("links", "markdown_pages", "flowchart", "index_entries", "numbers_in_tables"):
        sys.modules.pop(name, None)


@pytest.mark.parametrize("path", GALLERY, ids=lambda path: path.stem)
def test_an_example_of_the_gallery_draws_a_figure(path: Path):
    pytest.importorskip("matplotlib")
    pytest.importorskip("pandas")
    figure = runpy.run_path(str(path))["figure"]
    labels = [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes]
    assert any(x for x, _ in labels)
    assert any(y for _, y in labels)


def test_an_example_of_the_gallery_is_short():
    assert len(GALLERY) >= 12
    for path in GALLERY:
        code = path.read_text(encoding="utf-8").split('"""', 2)[2]
        assert len([line for line in code.splitlines() if line.strip()]) <= 60, path.name


def test_the_reference_lists_every_public_name_once():
    text = (SITE / "reference.md").read_text(encoding="utf-8")
    public = text.partition("## Entries of results")[0]
    names = re.findall(r"^   (\w+)$", public, flags=re.M)
    assert sorted(names) == sorted({*dir(gb), *dir(gb.results)} - {"__version__"})


def test_the_navigation_lists_every_document_once():
    text = (SITE / "index.md").read_text(encoding="utf-8")
    listed = [
        re.sub(r".*<(.+)>$", r"\1", line)
        for block in re.findall(r"^```\{toctree\}\n(.*?)^```$", text, flags=re.M | re.S)
        for line in block.splitlines()
        if line and not line.startswith(":")
    ]
    documents = [
        *ROOT.glob("*.md"),
        *ROOT.glob("examples/machines/*.md"),
        *ROOT.glob("docs/*.md"),
        *ROOT.glob("docs/notebooks/*.ipynb"),
    ]
    own = ["gallery/index", "reference"]
    paths = [path.relative_to(ROOT).with_suffix("").as_posix() for path in documents]
    assert sorted(listed) == sorted(paths + own)


@pytest.mark.usefixtures("site")
def test_links_and_anchors_are_checked(tmp_path: Path):
    from links import problems

    (tmp_path / "a.html").write_text(
        '<a href="b.html#there">x</a> <a href="https://example.org">x</a> <img src="c.png">'
    )
    (tmp_path / "b.html").write_text('<h1 id="there">x</h1> <a href="#top">x</a>')
    (tmp_path / "c.png").touch()
    assert problems(tmp_path) == []
    (tmp_path / "d.html").write_text(
        '<script src="https://example.org/x.js"></script> <a href="b.html#away">x</a>'
        ' <a href="e.html">x</a> <a href="#away">x</a>'
    )
    assert problems(tmp_path) == [
        "d.html: loads https://example.org/x.js from a network",
        "d.html: no anchor #away",
        "d.html: no anchor b.html#away",
        "d.html: no file e.html",
    ]


@pytest.mark.usefixtures("site")
def test_every_page_of_the_navigation_has_markdown():
    from markdown_pages import llms, markdown_pages

    documents = {
        path.relative_to(ROOT).as_posix(): path
        for pattern in ("*.md", "docs/*.md", "docs/notebooks/*.ipynb", "examples/machines/*.md")
        for path in ROOT.glob(pattern)
    }
    documents |= {path.name: path for path in SITE.glob("*.md")}
    pages = markdown_pages(documents, ROOT / "examples" / "gallery")
    index = (SITE / "index.md").read_text(encoding="utf-8")
    text = llms(index, pages)
    assert text.startswith("# gearbow\n\n> gearbow computes the dynamics of geared shaft trains")
    linked = re.findall(r"^- \[.+\]\((\S+)\): \S", text, flags=re.M)
    assert {name for name in linked if name not in pages} == set()
    assert {"docs/validation.md", "docs/notebooks/study.md", "reference.md"} <= set(linked)
    # The reference has a page for every public name, with the docstrings of its members.
    assert "toctree" not in "".join(pages.values())
    names = {f"reference/gearbow.{name}.md" for name in dir(gb)} - {
        "reference/gearbow.__version__.md"
    }
    assert names <= set(pages)
    system = pages["reference/gearbow.RotorSystem.md"]
    assert "## modes\n\n`(self, speed=0.0, *, count=None, vibrating=False" in system
    assert pages["gallery/01_bowed_rotor.md"].startswith(
        "# Bowed rotor and its critical speed\n\nA"
    )


@pytest.mark.usefixtures("site")
def test_every_flowchart_of_a_document_can_be_drawn():
    pytest.importorskip("sphinx")
    from flowchart import chain

    charts = [
        chart
        for path in [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")]
        for chart in re.findall(
            r"^```mermaid\n(.*?)^```$", path.read_text(encoding="utf-8"), flags=re.M | re.S
        )
    ]
    assert charts
    for chart in charts:
        assert len(chain(chart.splitlines())) > 2
    assert chain(["flowchart LR", 'a["x<br>y"] --> b', "b --> c"]) == ["x<br>y", "b", "c"]
    with pytest.raises(ValueError, match="does not continue a chain"):
        chain(["flowchart LR", "a --> b", "a --> c"])


@pytest.mark.usefixtures("site")
def test_cells_with_numbers_are_recognised():
    pytest.importorskip("sphinx")
    from numbers_in_tables import NUMBER

    for text in ("1.7e-10", "−4.6", "≥ 7.56e+04", "0.59 ± 0.36", "11.1 ms", "2 %", "180, 180"):
        assert NUMBER.fullmatch(text), text
    for text in ("", "rtol 0.1", "at 200, 400 rad/s", "Rao 1998"):
        assert not NUMBER.fullmatch(text), text


#: Words that a user searches for, and a page that the search of the site has to find.
SEARCHED = {
    "Excel": "using",
    "FRF": "frequency",
    "3D": "frequency",
    "6308": "gearbox",
    "log decrement": "using",
    "waterfall": "signals",
    "hammer test": "frequency",
}


@pytest.mark.parametrize("word", SEARCHED)
@pytest.mark.usefixtures("site")
def test_the_search_finds_a_word_in_its_page(word: str):
    pytest.importorskip("sphinx")
    from index_entries import with_entries

    text = with_entries((ROOT / "docs" / f"{SEARCHED[word]}.md").read_text(encoding="utf-8"))
    listed = re.findall(r"^```\{index\} (.+)\n```$", text, flags=re.M)
    assert word in ", ".join(listed).split(", ")
    assert "<!-- index" not in text


@pytest.mark.usefixtures("site")
def test_a_comment_becomes_an_entry_of_the_built_index(tmp_path: Path):
    pytest.importorskip("myst_parser")
    from sphinx.cmd.build import main

    source, html = tmp_path / "source", tmp_path / "html"
    source.mkdir()
    (source / "conf.py").write_text('extensions = ["myst_parser", "index_entries"]')
    text = "# Bearings\n\n<!-- index: 6308, ball pass -->\n\nText.\n"
    (source / "index.md").write_text(text)
    assert main(["-q", "-W", str(source), str(html)]) == 0
    built = (html / "searchindex.js").read_text(encoding="utf-8")
    entries = built.partition('"indexentries":')[2].partition('"objects"')[0]
    assert '"6308"' in entries
    assert '"ball pass"' in entries
