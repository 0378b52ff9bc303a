"""Markdown of the site for programs: one file for each page, and their list `llms.txt`.

The file of a page has the name of the page with the ending ``.md``. Documents are copied; notebooks
and examples of the gallery become text with blocks of code, and the entries of the reference come
from the docstrings.
"""

import ast
import inspect
import json
import re
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

import gearbow

#: Blocks of the documents that only Sphinx reads.
_TOCTREE = re.compile(r"^```\{toctree\}\n(.*?)^```\n*", re.MULTILINE | re.DOTALL)
_AUTOSUMMARY = re.compile(
    r"^```\{eval-rst\}\n\.\. currentmodule:: (\S+)\n\.\. autosummary::\n(.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
#: Folder of the entries of the reference.
_ENTRIES = "reference"


def markdown_pages(documents: Mapping[str, Path], gallery: Path) -> dict[str, str]:
    """Return the Markdown of every page, by its path on the site.

    Parameters
    ----------
    documents : mapping of str to Path
        Files of the documents, by their path on the site.
    gallery : Path
        Folder of the examples of the gallery.

    Returns
    -------
    dict of str to str
        Markdown texts, by paths that end with ``.md``.
    """
    found: dict[str, str] = {}
    for name, path in documents.items():
        if path.suffix == ".md":
            text = _TOCTREE.sub("", path.read_text(encoding="utf-8"))
            found[name] = _AUTOSUMMARY.sub(lambda block: _entries(block, found), text)
        elif path.suffix == ".ipynb":
            found[str(PurePosixPath(name).with_suffix(".md"))] = _notebook(path)
    examples = {path.stem: _example(path) for path in sorted(gallery.glob("*.py"))}
    for stem, text in examples.items():
        found[f"gallery/{stem}.md"] = text
    lines = [f"- [{_title(text)}]({stem}.md)" for stem, text in examples.items()]
    found["gallery/index.md"] = "\n".join(["# Gallery", "", *lines, ""])
    return found


def llms(index: str, pages: Mapping[str, str]) -> str:
    """Return ``llms.txt``: the pages in the order of the navigation, with a sentence each.

    Parameters
    ----------
    index : str
        Text of the first page, which has the navigation.
    pages : mapping of str to str
        Markdown of the pages, by their path on the site.

    Returns
    -------
    str
        Title, summary, and one list of links for each caption of the navigation.
    """
    lines = [f"# {_title(index)}", "", f"> {_first_sentence(index)}"]
    for block in _TOCTREE.findall(index):
        options = dict(re.findall(r"^:(\w+): ?(.*)$", block, re.MULTILINE))
        lines += ["", f"## {options['caption']}", ""]
        for entry in re.findall(r"^[^:\s].*$", block, re.MULTILINE):
            name = re.sub(r"^.*<(.+)>$", r"\1", entry) + ".md"
            sentence = _first_sentence(pages[name])
            lines.append(
                f"- [{_title(pages[name])}]({name})" + (f": {sentence}" if sentence else "")
            )
    return "\n".join([*lines, ""])


def _title(text: str) -> str:
    return next(line[2:] for line in text.splitlines() if line.startswith("# "))


def _first_sentence(text: str) -> str:
    """Return the first sentence of the first paragraph, without links."""
    for paragraph in re.split(r"\n\s*\n", text):
        if re.match(r"[A-Za-z`*\[]", paragraph):
            plain = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", " ".join(paragraph.split()))
            return re.split(r"(?<=[a-z`)])[.:](?: |$)", plain)[0] + "."
    return ""


def _entries(block: re.Match[str], found: dict[str, str]) -> str:
    """Return the list of the names of a table of the reference; add the page of each to `found`."""
    module = block[1]
    lines = []
    for name in re.findall(r"^ +(\w+)$", block[2], re.MULTILINE):
        page = f"{_ENTRIES}/{module}.{name}.md"
        thing = getattr(gearbow.results if module.endswith(".results") else gearbow, name)
        found[page] = _entry(f"{module}.{name}", thing)
        lines.append(f"- [{name}]({page}): {_summary(thing)}")
    return "\n".join(lines)


def _summary(thing: object) -> str:
    return (inspect.getdoc(thing) or "").split("\n\n")[0].replace("\n", " ")


def _entry(name: str, thing: object) -> str:
    """Return the page of a public name: its docstring, and those of the members of a class."""
    parts = [f"# {name}", *_described(thing)]
    if inspect.isclass(thing):
        for member in sorted(one for one in dir(thing) if not one.startswith("_")):
            given = inspect.getattr_static(thing, member)
            if inspect.getdoc(given) and not hasattr(Exception, member):
                bound = getattr(thing, member) if isinstance(given, classmethod) else given
                parts += [f"## {member}", *_described(bound)]
    return "\n\n".join([*parts, ""])


def _described(thing: object) -> list[str]:
    """Return signature and docstring as blocks; a docstring of numpydoc is read as it is."""
    text = f"```text\n{inspect.getdoc(thing) or ''}\n```"
    if not callable(thing):
        return [text]
    try:
        given = inspect.signature(thing)
    except ValueError:  # no text signature
        return [text]
    empty = inspect.Parameter.empty
    names = [one.replace(annotation=empty) for one in given.parameters.values()]
    return [f"`{given.replace(parameters=names, return_annotation=empty)}`", text]


def _notebook(path: Path) -> str:
    """Return the cells of a notebook as text and code."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    texts = [
        f"```python\n{''.join(cell['source'])}\n```"
        if cell["cell_type"] == "code"
        else "".join(cell["source"])
        for cell in cells
    ]
    return "\n\n".join([*texts, ""])


def _example(path: Path) -> str:
    """Return an example of the gallery: its title and text, then its code."""
    source = path.read_text(encoding="utf-8")
    title, _, text = (ast.get_docstring(ast.parse(source)) or "").partition("\n")
    code = source.split('"""', 2)[2].strip()
    text = text.lstrip("=\n")
    return f"# {title}\n\n{text}\n\n```python\n{code}\n```\n"
