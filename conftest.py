"""Run the code blocks of the Markdown documents as tests.

The Python blocks of a document run in order and share their names. A `text` block contains the
expected output of the Python block before it. A `toml` block becomes the file `scene.toml`, an
`xml` block the file `gearbox.rexs`, a `json` block the file `rotor.json`, for the blocks after it.
Each document runs in a folder that has `examples/machines/` only. The cells of a notebook run in
order; its outputs are not stored. A document with `<!-- needs: NAME -->` is skipped where this
library is not installed.
"""

import contextlib
import doctest
import io
import json
import os
import re
import shutil
import tempfile
from pathlib import Path

import pytest

# Each process of the tests, and each of its children, uses one thread for dense matrices. With two
# threads in each of two processes, threads that wait took most of the CPU time: the modes of one
# machine took 7 s instead of 0.3 s. NumPy reads this setting when it is imported.
os.environ.setdefault("OMP_NUM_THREADS", "1")

NEEDS = re.compile(r"<!-- needs: (\w+) -->")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
#: Scene files that documents load.
MACHINES = Path(__file__).parent / "python" / "gearbow" / "machines"
# They need the packages of the extra docs, and have no examples.
collect_ignore_glob = ["docs/site/*.py"]
#: File that a block becomes, by its language.
FILES = {"toml": "scene.toml", "xml": "gearbox.rexs", "json": "rotor.json"}
ALIKE = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def pytest_configure(config):
    config.addinivalue_line(
        "markers", "slow: expensive; `make random` runs it, `make test` does not"
    )
    config.addinivalue_line(
        "markers", "implausible: the scenes are no machines on purpose; their warnings are ignored"
    )


@pytest.hookimpl(tryfirst=True)  # before pytest selects by markers
def pytest_collection_modifyitems(items):
    for item in items:
        # A module of tests may tell which of its cases are slow.
        is_slow = getattr(getattr(item, "module", None), "is_slow", None)
        if is_slow is not None and hasattr(item, "callspec") and is_slow(item.callspec.params):
            item.add_marker("slow")
        if item.get_closest_marker("implausible"):
            item.add_marker(pytest.mark.filterwarnings("ignore::gearbow.SceneWarning"))


def pytest_collect_file(file_path, parent):
    kind = {".md": Document, ".ipynb": Notebook}.get(file_path.suffix)
    return kind.from_parent(parent, path=file_path) if kind else None


class Document(pytest.File):
    def collect(self):
        text = self.path.read_text(encoding="utf-8")
        blocks = [
            (match[1], match[2], text.count("\n", 0, match.start(2)))
            for match in BLOCK.finditer(text)
        ]
        if any(language == "python" for language, _, _ in blocks):
            needed = NEEDS.findall(text)
            yield Examples.from_parent(self, name="examples", blocks=blocks, needed=needed)


class Notebook(pytest.File):
    def collect(self):
        yield Cells.from_parent(self, name="cells")


class Cells(pytest.Item):
    def runtest(self):
        names = {"__name__": self.path.stem}
        cells = json.loads(self.path.read_text(encoding="utf-8"))["cells"]
        with tempfile.TemporaryDirectory() as folder, inside(folder):
            for cell in cells:
                if cell["cell_type"] == "code":
                    # A line of the notebook program, such as %matplotlib, is no Python.
                    lines = [line for line in cell["source"] if not line.startswith("%")]
                    exec(compile("".join(lines), self.path, "exec"), names)

    def reportinfo(self):
        return self.path, None, f"{self.path.name}: cells"


class Examples(pytest.Item):
    def __init__(self, *, blocks, needed, **given):
        super().__init__(**given)
        self.blocks, self.needed = blocks, needed

    def runtest(self):
        for library in self.needed:
            pytest.importorskip(library, reason=f"{library} is not installed")
        names = {"__name__": self.path.stem}
        printed = io.StringIO()
        with tempfile.TemporaryDirectory() as folder, inside(folder):
            # Documents name the machines from the root of the repository.
            shutil.copytree(
                MACHINES, "examples/machines", ignore=shutil.ignore_patterns("*.py", "__pycache__")
            )
            for language, text, line in self.blocks:
                if language in FILES:
                    Path(FILES[language]).write_text(text, encoding="utf-8")
                elif language == "python":
                    self.compare("", printed.getvalue(), line)
                    printed = io.StringIO()
                    # Leading empty lines: a traceback shows the line numbers of the document.
                    code = compile("\n" * line + text, self.path, "exec")
                    with contextlib.redirect_stdout(printed):
                        exec(code, names)
                elif language == "text":
                    self.compare(text, printed.getvalue(), line)
                    printed = io.StringIO()
            self.compare("", printed.getvalue(), line)

    def compare(self, expected, printed, line):
        example = doctest.Example("", expected, lineno=line)
        checker = doctest.OutputChecker()
        if not checker.check_output(expected, printed, ALIKE):
            difference = checker.output_difference(example, printed, ALIKE)
            raise AssertionError(f"{self.path}:{line + 1}: {difference}")

    def reportinfo(self):
        return self.path, None, f"{self.path.name}: examples"


@contextlib.contextmanager
def inside(folder):
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
