"""Report import cycles, long files, long functions and large structs.

The report informs; it always succeeds. An entry of `REASONS` explains why a finding remains.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
FILE_LINES, FUNCTION_LINES, STRUCT_FIELDS = 600, 90, 15

#: Findings that remain, and why.
REASONS: dict[str, str] = {
    "python/gearbow/description/gears.py:Gear": "public parameters",
    "python/gearbow/studies/result.py:Trial": "public row of a table",
    "python/gearbow/system/rotor_system.py:RotorSystem": "public parameters",
    "python/gearbow/description/rolling.py:RollingBearing": "public parameters",
    "src/scene/description/bearing.rs:Bearing": "entries of a scene",
    "src/scene/description/mod.rs:Gear": "entries of a scene",
    "src/scene/description/mod.rs:SceneDescription": "entries of a scene",
    "src/scene/mod.rs:Scene": "entries of a scene",
}

Graph = dict[str, set[str]]


def strong_components(graph: Graph) -> list[list[str]]:
    """Find the import cycles of a graph: its strongly connected components (Tarjan 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(graph.get(node, ())):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            at = stack.index(node)
            component = stack[at:]
            del stack[at:]
            if len(component) > 1:
                found.append(sorted(component))

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return found


def without_tests(text: str) -> str:
    """Cut the unit tests at the end of a Rust file."""
    return text.split("#[cfg(test)]", maxsplit=1)[0]


def code_of(text: str) -> str:
    """Cut the unit tests, the lines of comments and the paths of visibilities of a Rust file."""
    return re.sub(r"^\s*//.*$|\(in [\w:]+\)", "", without_tests(text), flags=re.M)


def use_paths(tree: str, prefix: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Expand the tree of a Rust `use` statement into paths."""
    depth, begin = 0, 0
    parts = []
    for at, sign in enumerate(tree):
        depth += (sign == "{") - (sign == "}")
        if sign == "," and depth == 0:
            parts.append(tree[begin:at])
            begin = at + 1
    for part in (*parts, tree[begin:]):
        head, brace, rest = part.strip().partition("{")
        names = tuple(name.strip() for name in head.split(" as ")[0].split("::") if name.strip())
        if brace:
            yield from use_paths(rest.rstrip().removesuffix("}"), (*prefix, *names))
        elif names:
            yield (*prefix, *names)


def module_of(file: Path) -> tuple[str, ...]:
    """Give the module path of a Rust file."""
    parts = file.relative_to(ROOT / "src").with_suffix("").parts
    return parts[:-1] if parts[-1] in {"mod", "lib"} else parts


def rust_graph(family: str = "none") -> Graph:
    """Collect the imports between the files of the crate.

    A module and its parent may use each other. `family` tells which of these two imports count:
    "none", "child" (the parent imports its child) or "parent" (the child imports its parent).
    """
    files = {module_of(file): file for file in sorted((ROOT / "src").rglob("*.rs"))}
    texts = {module: code_of(file.read_text(encoding="utf-8")) for module, file in files.items()}
    exports: dict[tuple[str, ...], dict[str, tuple[str, ...]]] = {}
    for module, text in texts.items():
        exports[module] = {
            path[-1]: path
            for use in re.findall(r"pub(?:\([a-z: ]+\))? use ([^;]+);", text)
            for path in use_paths(use)
        }

    def absolute(path: tuple[str, ...], module: tuple[str, ...]) -> tuple[str, ...]:
        at = module
        for number, name in enumerate(path):
            if name == "crate":
                at = ()
            elif name == "super":
                at = at[:-1]
            elif name != "self":
                return (*at, *path[number:]) if number or (*at, name) in files else path
        return at

    def home(path: tuple[str, ...]) -> tuple[str, ...] | None:
        for length in range(len(path), -1, -1):
            module = path[:length]
            if module in files:
                name = path[length] if length < len(path) else ""
                exported = exports[module].get(name)
                onward = absolute(exported, module) if exported else None
                return home(onward) if onward and onward != path else module
        return None

    graph: Graph = {}
    for module, text in texts.items():
        paths = [
            path
            for use in re.findall(r"^\s*(?:pub(?:\([a-z: ]+\))? )?use ([^;]+);", text, re.M)
            for path in use_paths(use)
        ]
        paths += [
            tuple(path.split("::"))
            for path in re.findall(r"\b((?:crate|super)(?:::\w+)+)\b(?!::)", text)
        ]
        names = graph.setdefault(str(files[module].relative_to(ROOT)), set())
        for path in paths:
            target = home(absolute(path, module))
            if target is None or target == module:
                continue
            if target == module[:-1] and family != "parent":
                continue
            if target[:-1] == module and family != "child":
                continue
            names.add(str(files[target].relative_to(ROOT)))
    return graph


def folder_graph() -> Graph:
    """Collect the imports between folders of the crate that lie in the same folder."""
    graph: Graph = {}
    for file, targets in rust_graph().items():
        for target in targets:
            parts, others = Path(file).with_suffix("").parts, Path(target).with_suffix("").parts
            depth = next(
                (
                    k
                    for k, pair in enumerate(zip(parts, others, strict=False))
                    if len(set(pair)) > 1
                ),
                0,
            )
            folder, other = Path(*parts[: depth + 1]), Path(*others[: depth + 1])
            if depth and (ROOT / folder).is_dir() and (ROOT / other).is_dir():
                graph.setdefault(str(folder), set()).add(str(other))
    return graph


def python_graph() -> Graph:
    """Collect the imports between the files of the package, also those inside functions."""
    folder = ROOT / "python"
    files = {file: str(file.relative_to(ROOT)) for file in sorted(folder.rglob("*.py"))}
    graph: Graph = {name: set() for name in files.values()}
    for file, name in files.items():
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                modules = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            elif isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names]
            else:
                continue
            for module in modules:
                base = folder / module.replace(".", "/")
                candidates = (base.with_suffix(".py"), base / "__init__.py")
                target = next((path for path in candidates if path in files), None)
                if target is None or target == file:
                    continue
                if target.name != "__init__.py" or target.parent != file.parent:
                    graph[name].add(files[target])
    return graph


def rust_functions(text: str) -> Iterator[tuple[str, int]]:
    """Give every function of a Rust file with its number of lines."""
    lines = text.splitlines()
    for at, line in enumerate(lines):
        match = re.match(r"(\s*)(?:pub(?:\([a-z: ]+\))? )?(?:const )?fn (\w+)", line)
        if match and not line.rstrip().endswith(";"):
            end = next(
                (k for k in range(at, len(lines)) if lines[k].rstrip() == f"{match[1]}}}"), at
            )
            yield match[2], end - at + 1


def rust_structs(text: str) -> Iterator[tuple[str, int]]:
    """Give every struct of a Rust file with its number of fields."""
    for match in re.finditer(
        r"^(?:pub(?:\([a-z: ]+\))? )?struct (\w+)[^;{]*\{\n(.*?)^\}", text, re.M | re.S
    ):
        yield match[1], len(re.findall(r"^    (?:pub(?:\([a-z: ]+\))? )?\w+:", match[2], re.M))


def python_functions(text: str) -> Iterator[tuple[str, int]]:
    """Give every function of a Python file with its number of lines, its docstring apart."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            documentation = ast.get_docstring(node, clean=False)
            lines = (node.end_lineno or 0) - node.lineno + 1
            yield node.name, lines - (len(documentation.splitlines()) if documentation else 0)


def python_classes(text: str) -> Iterator[tuple[str, int]]:
    """Give every class of a Python file with its number of annotated fields."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ClassDef):
            yield node.name, sum(isinstance(entry, ast.AnnAssign) for entry in node.body)


def findings() -> Iterator[tuple[str, str]]:
    """Give every finding: where it is, and what it is."""
    cycles = {
        tuple(component)
        for graph in (rust_graph("child"), rust_graph("parent"), python_graph())
        for component in strong_components(graph)
    }
    for cycle in sorted(cycles):
        yield cycle[0], f"import cycle of {len(cycle)} files: {', '.join(cycle)}"
    for component in strong_components(folder_graph()):
        yield component[0], f"import cycle of {len(component)} folders: {', '.join(component)}"
    for file in sorted([*(ROOT / "src").rglob("*.rs"), *(ROOT / "python").rglob("*.py")]):
        text, name = file.read_text(encoding="utf-8"), str(file.relative_to(ROOT))
        rust = file.suffix == ".rs"
        lines = len((without_tests(text) if rust else text).splitlines())
        if lines > FILE_LINES:
            yield name, f"{lines} lines"
        for function, length in rust_functions(text) if rust else python_functions(text):
            if length > FUNCTION_LINES:
                yield f"{name}:{function}", f"function of {length} lines"
        for struct, count in rust_structs(text) if rust else python_classes(text):
            if count > STRUCT_FIELDS:
                yield f"{name}:{struct}", f"struct of {count} fields"


def main() -> None:
    """Print the report."""
    found = list(findings())
    for where, what in found:
        reason = REASONS.get(where)
        print(f"{where}: {what}" + (f" ({reason})" if reason else ""))
    unexplained = sum(where not in REASONS for where, _ in found)
    print(f"{len(found)} findings, {unexplained} without a reason")


if __name__ == "__main__":
    main()
