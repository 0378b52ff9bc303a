"""Check the links of a folder of HTML pages.

Every link within the folder leads to a file, and its anchor to an element of that file. No page
loads a script, a style sheet, a font or a picture from a network, so that the site works offline.
"""

import re
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

#: Attribute of each element that loads a file.
LOADS = {"script": "src", "link": "href", "img": "src", "iframe": "src", "source": "src"}
#: Links that a browser does not load by itself.
LINK_RELATIONS = {"index", "search", "next", "prev", "canonical", "author", "license"}


class Page(HTMLParser):
    """Anchors and links of one page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = {"", "top"}
        self.links: list[str] = []
        self.loads: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect the anchor and the link of an element."""
        values = dict(attrs)
        self.anchors.update(filter(None, (values.get("id"), values.get("name"))))
        target = values.get(LOADS.get(tag, "href"))
        if target is None:
            return
        loaded = tag in LOADS and values.get("rel") not in LINK_RELATIONS
        (self.loads if loaded else self.links).append(target)


@cache
def read(path: Path) -> Page:
    """Return anchors and links of a file."""
    return Page(path.read_text(encoding="utf-8"))


def problems(folder: Path) -> list[str]:
    """Return what is wrong with the links of the pages in a folder.

    Parameters
    ----------
    folder : Path
        Folder of a site.

    Returns
    -------
    list of str
        One line for each wrong link, which names page and link.
    """
    found = []
    for file in sorted(folder.rglob("*.html")):
        name = file.relative_to(folder)
        page = read(file)
        found += [
            f"{name}: loads {link} from a network"
            for link in page.loads
            if re.match(r"(https?:)?//", link)
        ]
        for link in sorted({*page.links, *page.loads}):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            if target.is_dir():
                target /= "index.html"
            if not target.is_file():
                found.append(f"{name}: no file {link}")
            elif target.suffix == ".html" and unquote(parts.fragment) not in read(target).anchors:
                found.append(f"{name}: no anchor {link}")
    for file in sorted(folder.rglob("*.css")):
        text = file.read_text(encoding="utf-8")
        if re.search(r"(@import|url\()\s*['\"]?(https?:)?//", text):
            found.append(f"{file.relative_to(folder)}: loads a file from a network")
    return found
