"""The core of the package does not depend on its outbuildings, which use its public names only."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import gearbow

PACKAGE = Path(gearbow.__file__).parent
#: Folders of what a user of the core can do without.
OUTBUILDINGS = ("exchange", "identification", "report", "studies")
#: The other folders. A new folder belongs to one of the two.
CORE = (
    *("analysis", "cli", "description", "machines", "orders", "plotting", "recording", "results"),
    *("sweeps", "system", "units"),
)
#: Files of the core that are doors: the outbuildings that their functions import when called.
DOORS = {
    "__init__.py": {"exchange", "identification", "studies"},  # names imported at first use
    "description/bow.py": {"exchange"},  # Bow of a table in a file
    "description/elastic.py": {"exchange"},  # matrices of files
    "description/speed.py": {"exchange"},  # SpeedTable of a table in a file
    "results/__init__.py": {"exchange", "identification", "studies"},  # names, likewise
    "results/frequency_response.py": {"exchange"},  # save, tables, and compare with a file
    "results/modes.py": {"exchange"},  # save, and compare with a file
    "system/outputs.py": {"exchange", "report"},  # RotorSystem.to_fmu, RotorSystem.report
    "system/rotor_system.py": {"exchange"},  # read_rexs, from_ross, save
    "system/tradeoff.py": {"studies"},  # RotorSystem.tradeoff
}
#: The program `gearbow` is a door as a whole: its commands import what they call.
PROGRAM = "cli/"
#: Attributes with an underscore that outbuildings still use of the core. This list may only shrink.
PRIVATE = {
    "identification/responses.py": {"_variation"},
    "report/api617.py": {"_model", "_own", "_peaks", "_vibrations"},
    "report/contents.py": {
        "_drawn",
        "_largest",
        "_model",
        "_notes",
        "_own",
        "_peaks",
        "_places",
        "_vibrations",
    },
    "report/compose.py": {"_model"},
    "report/page.py": {"_columns", "_left_out", "_remarks", "_showing"},
    "report/shared.py": {"_from_description", "_model", "_vibrations"},
}


class Import(NamedTuple):
    """An import of a name of gearbow, and when it happens: "import", "call" or "typing"."""

    module: str
    name: str
    when: str

    @property
    def outbuilding(self) -> str | None:
        """The outbuilding from which the name comes."""
        _, folder, *_ = [*self.module.split("."), self.name]
        return folder if folder in OUTBUILDINGS else None


@cache
def parsed_files() -> tuple[tuple[str, ast.Module], ...]:
    paths = sorted(PACKAGE.rglob("*.py"))
    return tuple(
        (path.relative_to(PACKAGE).as_posix(), ast.parse(path.read_text(encoding="utf-8")))
        for path in paths
    )


def imports_of(node: ast.AST, when: str = "import") -> Iterator[Import]:
    """Give the imports of names of gearbow in a tree."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.ImportFrom):
            assert child.level == 0, "imports name the package"
            if (child.module or "").split(".")[0] == "gearbow":
                yield from (Import(child.module or "", alias.name, when) for alias in child.names)
        elif isinstance(child, ast.Import):
            for alias in child.names:
                if alias.name.split(".")[0] == "gearbow":
                    yield Import(f"{alias.name}.", "", when)
        elif isinstance(child, ast.If) and ast.unparse(child.test).endswith("TYPE_CHECKING"):
            yield from imports_of(ast.Module(child.body, []), "typing")
            yield from imports_of(ast.Module(child.orelse, []), when)
        elif not isinstance(child, ast.expr):
            is_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef)
            yield from imports_of(child, "call" if is_function else when)


def is_outbuilding(file: str) -> bool:
    return file.split("/", maxsplit=1)[0] in OUTBUILDINGS


def test_every_folder_is_core_or_outbuilding():
    folders = {path.parent.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("*.py")}
    assert folders - {"."} == {*CORE, *OUTBUILDINGS}


def test_the_core_imports_outbuildings_in_its_doors_only():
    doors: dict[str, set[str]] = {}
    for file, tree in parsed_files():
        if is_outbuilding(file) or file.startswith(PROGRAM):
            continue
        for each in imports_of(tree):
            if each.outbuilding is not None and each.when != "typing":
                assert each.when == "call", f"{file} imports {each.module} when it is imported"
                doors.setdefault(file, set()).add(each.outbuilding)
    # Two faces import the modules of their tables by name.
    for file, face, table in (
        ("__init__.py", gearbow, "_LAZY"),
        ("results/__init__.py", gearbow.results, "_MODULES"),
    ):
        lazy = {Import(module, "", "call").outbuilding for module in vars(face)[table].values()}
        doors[file] = {name for name in lazy if name is not None}
    texts = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    found = (path.relative_to(PACKAGE) for path, text in texts.items() if "import_module" in text)
    by_name = {path.as_posix() for path in found}
    assert by_name == {"__init__.py", "results/__init__.py", "exchange/tables.py"}
    assert doors == DOORS


def test_outbuildings_import_public_names_of_the_core_only():
    # Modules of the package itself, such as gearbow._files, are helpers of all folders.
    for file, tree in parsed_files():
        for each in imports_of(tree) if is_outbuilding(file) else ():
            _, *folders = each.module.split(".")
            hidden = [part for part in folders[1:] if part.startswith("_")]
            dunder = each.name.startswith("__")
            assert not hidden, f"{file} imports {each.module}"
            assert dunder or not each.name.startswith("_"), f"{file} imports {each.name}"


def test_outbuildings_use_public_attributes_of_the_core_only():
    trees = {file: tree for file, tree in parsed_files() if is_outbuilding(file)}
    own: dict[str, set[str]] = {}
    for file, tree in trees.items():
        classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
        for node in (member for each in classes for member in each.body):
            if isinstance(node, ast.FunctionDef):
                own.setdefault(file.split("/")[0], set()).add(node.name)
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                own.setdefault(file.split("/")[0], set()).add(node.target.id)
    found: dict[str, set[str]] = {}
    for file, tree in trees.items():
        for node in ast.walk(tree):
            if not isinstance(node, ast.Attribute) or not node.attr.startswith("_"):
                continue
            of_itself = isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")
            is_own = node.attr in own.get(file.split("/")[0], set())
            if not (of_itself or is_own or node.attr.startswith("__")):
                found.setdefault(file, set()).add(node.attr)
    assert found == PRIVATE
