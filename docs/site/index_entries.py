"""Make index entries of the comments ``<!-- index: word, word -->`` of the documents.

The search of the site finds these words, among them those that it does not find in a text, such
as the number of a bearing. GitHub does not show the comments.
"""

import re

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

ENTRIES = re.compile(r"^<!-- index: (.+) -->$", re.MULTILINE)


def with_entries(text: str) -> str:
    """Return the text of a document with an ``index`` directive in place of each comment."""
    return ENTRIES.sub(r"```{index} \1\n```", text)


def _read(_: Sphinx, __: str, source: list[str]) -> None:
    source[0] = with_entries(source[0])


def setup(app: Sphinx) -> ExtensionMetadata:
    """Add the extension to Sphinx."""
    app.connect("source-read", _read)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
