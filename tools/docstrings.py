"""Check the docstrings of the package: full ones for public names, one sentence for all others.

    python tools/docstrings.py

The public names are those of `dir(gearbow)`, of the modules in `MODULES`, and the public methods
and properties of their classes. numpydoc checks their docstrings. Every other docstring is one
paragraph.
"""

from __future__ import annotations

import ast
import inspect
import sys
from enum import Enum
from importlib import import_module
from pathlib import Path
from types import FunctionType

from numpydoc.validate import validate

import gearbow

#: Public modules.
MODULES = ("gearbow", "gearbow.results", "gearbow.identification.unknown")
#: Checks of numpydoc that do not apply.
IGNORED = {
    "ES01",  # an extended summary only where there is more to say
    "EX01",  # the example stands at the class or at the method that needs one
    "GL01",  # summaries begin beside the opening quotes
    "PR02",  # numpydoc does not see the parameters of a dataclass
    "SA01",  # cross references only where they help
    "YD01",  # no generators
}


def public_names() -> dict[str, object]:
    """Return the objects of the public names by their full names."""
    names: dict[str, object] = {}
    for module in map(import_module, MODULES):
        for name, value in inspect.getmembers(module):
            if name[0] == "_" or not isinstance(value, (type, FunctionType)):
                continue
            names[f"{module.__name__}.{name}"] = value
            if isinstance(value, type) and not issubclass(value, Enum):
                names |= {
                    f"{module.__name__}.{name}.{member}": attribute
                    for member, attribute in inspect.getmembers(value)
                    if member[0] != "_" and _is_ours(_function(attribute))
                }
    return names


def _is_ours(value: object) -> bool:
    """Tell whether a value is a function of gearbow."""
    return isinstance(value, FunctionType) and value.__module__.startswith("gearbow")


def makes_own_class(value: object) -> bool:
    """Tell whether a value is a constructor, a class method that returns its class."""
    owner = getattr(value, "__self__", None)
    if not isinstance(owner, type):
        return False
    returned = inspect.signature(value).return_annotation  # type: ignore[arg-type]  # a method
    return returned in {"Self", *(base.__name__ for base in owner.__mro__)}


def _function(attribute: object) -> object:
    """Return the function behind a property, a method or a cached property."""
    for name in ("fget", "func", "__func__"):
        attribute = getattr(attribute, name, attribute)
    return inspect.unwrap(attribute) if callable(attribute) else attribute


def places_of(names: dict[str, object]) -> set[tuple[str, str]]:
    """Return the file and the qualified name in it of each public object."""
    places = set()
    for value in map(_function, names.values()):
        if isinstance(value, (type, FunctionType)):
            bases = inspect.getmro(value) if isinstance(value, type) else (value,)
            for each in bases:
                if each.__module__.startswith("gearbow"):
                    places.add((inspect.getfile(each), each.__qualname__))
    return places


def long_docstrings(path: Path, public: set[tuple[str, str]]) -> list[str]:
    """Return the places of docstrings of other names that have more than one paragraph."""
    found = []

    def visit(node: ast.AST, prefix: str) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                name = f"{prefix}{child.name}"
                text = ast.get_docstring(child) or ""
                # An example is a test.
                is_long = "\n\n" in text and ">>>" not in text
                if is_long and (str(path), name) not in public:
                    found.append(f"{path}:{child.lineno}: {name}: one sentence is enough")
                visit(child, f"{name}." if isinstance(child, ast.ClassDef) else f"{name}.<locals>.")
            else:
                visit(child, prefix)

    visit(ast.parse(path.read_text(encoding="utf-8")), "")
    return found


def main() -> None:
    """Print every fault; the exit status is 1 if there is one."""
    names = public_names()
    faults = []
    for name, value in names.items():
        faults += [
            f"{name}: {text}"
            for code, text in validate(name)["errors"]
            # numpydoc takes private fields of dataclasses and parameters of Enum for parameters.
            if code not in IGNORED
            and (code != "PR01" or isinstance(value, FunctionType))
            and (code != "RT01" or not makes_own_class(value))
        ]
    public = places_of(names)
    for path in sorted(Path(inspect.getfile(gearbow)).parent.rglob("*.py")):
        faults += long_docstrings(path, public)
    print("\n".join(faults) or f"{len(names)} public docstrings, no fault")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
