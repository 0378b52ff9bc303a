"""Build the documentation site into the folder site/, with every warning an error.

The pages are the documents of the repository, in the folders that they have there, so that their
links lead to the same places. `index.md` has the navigation; a document that is missing there
is an error. For programs that read the site, each page has its Markdown beside it, and `llms.txt`
lists the pages. The examples of the gallery and the notebooks run if they, or gearbow, have
changed. Run with ``python docs/site/build.py``.
"""

import argparse
import hashlib
import shutil
import sys
from pathlib import Path

from links import problems
from markdown_pages import llms, markdown_pages
from sphinx.cmd.build import main as sphinx

import gearbow

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
#: Documents and the files that they show or link to, besides the pages of the site itself.
DOCUMENTS = (
    "*.md",
    "LICENSE",
    "CITATION.cff",
    "conda/recipe.yaml",
    "docs/*.md",
    "docs/*.png",
    "docs/figures/*",
    "docs/notebooks/*.ipynb",
    "examples/*.py",
    "examples/machines/README.md",
    "examples/machines/*.toml",
    "examples/rotors/*.toml",
    "examples/bow_study/*.py",
    "examples/bow_study/*.toml",
)


def pages() -> dict[str, Path]:
    """Return the file of each page, by its path on the site."""
    own = {path.name: path for path in HERE.glob("*.md")}
    shared = {
        path.relative_to(ROOT).as_posix(): path
        for pattern in DOCUMENTS
        for path in ROOT.glob(pattern)
    }
    return own | shared


def stage(source: Path) -> None:
    """Copy the pages to `source`, where generated pages remain; remove those of deleted files."""
    wanted = pages()
    for name, path in wanted.items():
        target = source / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists() or target.read_bytes() != path.read_bytes():
            shutil.copyfile(path, target)
    for kind in ("md", "ipynb"):
        for target in [*source.glob(f"*.{kind}"), *source.glob(f"docs/**/*.{kind}")]:
            if target.relative_to(source).as_posix() not in wanted:
                target.unlink()


def digest() -> str:
    """Return a digest of the installed gearbow and this folder, of which the pages are made."""
    package = Path(gearbow.__file__).parent
    digest = hashlib.sha256()
    for path in sorted([*package.rglob("*.py"), *package.glob("_core*.so"), *HERE.rglob("*.*")]):
        if path.suffix not in {".md", ".pyc"}:
            digest.update(path.read_bytes())
    return digest.hexdigest()


def add_markdown(output: Path) -> None:
    """Write the Markdown of every page beside it, and the list of the pages, `llms.txt`."""
    texts = markdown_pages(pages(), ROOT / "examples" / "gallery")
    index = (HERE / "index.md").read_text(encoding="utf-8")
    for name, text in {**texts, "llms.txt": llms(index, texts)}.items():
        target = output / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")


def add_trial_page(output: Path) -> None:
    """Copy the page that runs gearbow in a browser to the site, or say that it is left out."""
    built = ROOT / "target" / "web" / "try.html"
    if built.exists():
        shutil.copyfile(built, output / "try.html")
    else:
        print("try.html is left out of the site: `make web` builds it")


def main() -> None:
    """Build the site and check its links."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--work", type=Path, default=ROOT / "target" / "docs-site")
    parser.add_argument("--output", type=Path, default=ROOT / "site")
    given = parser.parse_args()
    work: Path = given.work
    output: Path = given.output
    mark = work / "gearbow"
    if not mark.exists() or mark.read_text(encoding="utf-8") != digest():
        shutil.rmtree(work, ignore_errors=True)
    source, html = work / "source", work / "html"
    stage(source)
    # Every page has the whole navigation: pages of a previous build may have another one.
    shutil.rmtree(html, ignore_errors=True)
    arguments = ["-W", "--keep-going", "-q", "-a", "-c", HERE, "-d", work / "doctrees"]
    code = sphinx([*map(str, arguments), str(source), str(html)])
    if code:
        sys.exit(code)
    mark.write_text(digest(), encoding="utf-8")
    found = problems(html)
    if found:
        sys.exit("\n".join(found))
    shutil.rmtree(output, ignore_errors=True)
    shutil.copytree(html, output)
    add_markdown(output)
    add_trial_page(output)
    print(f"open {output / 'index.html'}")


if __name__ == "__main__":
    main()
