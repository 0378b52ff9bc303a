"""Every file that a document mentions exists."""

from __future__ import annotations

import re
from pathlib import Path

from reference.cases import each_case

ROOT = Path(__file__).parents[3]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])
FOLDERS = (
    ".github",
    "benches",
    "conda",
    "docs",
    "examples",
    "paper",
    "python",
    "src",
    "tests",
    "tools",
)
FILES = [
    "/" + file.relative_to(ROOT).as_posix()
    for folder in FOLDERS
    for file in (ROOT / folder).rglob("*")
    if "__pycache__" not in file.parts
] + [f"/{file.name}" for file in ROOT.iterdir()]


def names_of_files(text: str) -> list[str]:
    """Give the paths in code spans, such as `src/lib.rs`, `step.rs` or `src/mesh/`."""
    spans = re.findall(r"`([^`\n]+)`", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S))
    return [
        span for span in spans if re.fullmatch(r"[\w.\-/]+(?:\.(?:rs|py|pyi|md|toml|cff)|/)", span)
    ]


@each_case("document", DOCUMENTS, ids=lambda file: file.name)
def test_every_path_in_a_document_exists(document: Path):
    text = document.read_text(encoding="utf-8")
    for name in names_of_files(text):
        if name.split("/")[0] in {"target", ".venv"}:
            continue
        # A name without its folder refers to the folder that the sentence is about.
        assert any(file.endswith("/" + name.rstrip("/")) for file in FILES), name


@each_case("document", DOCUMENTS, ids=lambda file: file.name)
def test_every_link_between_documents_leads_to_a_heading(document: Path):
    text = document.read_text(encoding="utf-8")
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if link.startswith(("http", "mailto")):
            continue
        path, _, heading = link.partition("#")
        target = document.parent / path if path else document
        assert target.exists(), link
        if heading:
            titles = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), flags=re.M)
            anchors = {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}
            assert heading in anchors, link
