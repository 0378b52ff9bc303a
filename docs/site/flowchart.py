"""Draw the Mermaid flowcharts of the documents as HTML, without a script from a network.

Only a chain of nodes from left to right is supported: ``flowchart LR`` and lines of the form
``a["first line<br>second line"] --> b["..."]``, each of which continues the line before.
"""

import re
from html import escape

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.typing import ExtensionMetadata

EDGE = re.compile(r'\s*(\w+)(?:\["(.+?)"\])? --> (\w+)(?:\["(.+?)"\])?\s*')


def chain(source: list[str]) -> list[str]:
    """Return the labels of the nodes of a chain, in its order.

    Parameters
    ----------
    source : list of str
        Lines of the flowchart.

    Returns
    -------
    list of str
        One label for each node; its lines stand between ``<br>``.

    Raises
    ------
    ValueError
        If the flowchart is no chain from left to right.
    """
    head, *edges = source
    labels: list[str] = []
    last = None
    for line in edges:
        found = EDGE.fullmatch(line)
        if head.strip() != "flowchart LR" or found is None or last not in {None, found[1]}:
            raise ValueError(f"{line!r} does not continue a chain of a `flowchart LR`")
        labels += [found[4] or found[3]] if last else [found[2] or found[1], found[4] or found[3]]
        last = found[3]
    return labels


class Flowchart(SphinxDirective):
    """The directive ``mermaid``."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return the chain as an ordered list, whose items the style sheet draws as boxes."""
        try:
            labels = chain(list(self.content))
        except ValueError as error:
            raise self.error(str(error)) from error
        items = "".join(
            f"<li>{'<br>'.join(map(escape, label.split('<br>')))}</li>" for label in labels
        )
        return [nodes.raw("", f'<ol class="flowchart">{items}</ol>', format="html")]


def setup(app: Sphinx) -> ExtensionMetadata:
    """Register the directive."""
    app.add_directive("mermaid", Flowchart)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
