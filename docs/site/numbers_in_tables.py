"""Keep the numbers of tables on one line: a browser breaks 1.7e-10 behind its minus sign."""

import re

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

#: A cell of one number or of a few numbers and signs, perhaps with a short unit.
NUMBER = re.compile(r"[≥≤<>≈±+−-]?\s?\d[\d.e+−-]*(\s?(%|m?s|[±/×,]\s?\d[\d.e+−-]*))*")


def mark(_app: Sphinx, document: nodes.document) -> None:
    """Give the class `number` to each cell of a table that is a number."""
    for entry in document.findall(nodes.entry):
        if NUMBER.fullmatch(entry.astext().strip()):
            entry["classes"].append("number")


def setup(app: Sphinx) -> ExtensionMetadata:
    """Mark the cells when a page is read."""
    app.connect("doctree-read", mark)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
