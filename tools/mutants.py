"""Change one place of the program at a time, and count how many of these mutants the tests catch.

    python tools/mutants.py [--python 150] [--rust 60] [--seed 1] [--left-out PART ...]

The mutants are drawn at random from those of cosmic-ray (Python) and from the operators of the Rust
core (`SWAPS`); a Python mutant that changes only annotations, docstrings or `__all__` is not drawn.
All work happens in a copy of the repository in target/mutants. A Python mutant runs the tests that
execute its line, the shortest first, until one fails; a run of each file of tests with coverage
finds them. All Rust mutants are compiled into one program, and the environment variable
GEARBOW_MUTANT switches one of them on; a mutant runs the Python tests of `TESTS_OF`, then the Rust
tests, which are slower. The script prints each mutant that no test catches, and the share of caught
mutants with its standard deviation. It keeps coverage and fates in target/mutant-results: a call
that was interrupted goes on where it ended, and a file of tests that did not change keeps its
coverage.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import difflib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
from collections import defaultdict
from dataclasses import dataclass
from math import ceil, inf, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

import tree_sitter_rust
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names
from coverage import CoverageData
from tree_sitter import Language, Node, Parser

if TYPE_CHECKING:
    from collections.abc import Iterator

COPY = Path("target/mutants")
#: Coverage of the files of tests, and fates of mutants.
KEPT = Path("target/mutant-results")
#: Time limit of the tests of one mutant [s]. A mutant that exceeds it counts as caught.
TIME_LIMIT = 900.0
#: Longest sum of the durations of the tests for one Python mutant [s], well below the time limit.
TEST_TIME = 240.0
#: The number of the mutant of a process; no number in a program without mutants.
SWITCH = """
pub(crate) fn is_active(mutant: u32) -> bool {
    static ACTIVE: std::sync::LazyLock<Option<u32>> =
        std::sync::LazyLock::new(|| std::env::var("GEARBOW_MUTANT").ok()?.parse().ok());
    *ACTIVE == Some(mutant)
}
"""
#: Drawn Rust mutants for each wanted one: a few do not compile.
SPARE = 1.2
#: Parts of the names of operators that nearly every test catches: they change the type of a value.
CRUDE = ("Shift", "Bit", "Decorator", "Variable", "Invert", "Exception", "_Is", "Mod", "FloorDiv")
#: Patterns of the Python tests of a folder of the Rust core.
TESTS_OF = {
    "analysis/campbell": "campbell or stability or structured or closed_form or published",
    "analysis/discretisation": "discretisation or elements or accuracy",
    "analysis/simulate": "run or response or exponential or checkpoint or modal or initial",
    "analysis/steady": "steady or periodic or continuation",
    "analysis": "campbell or synchronous or balance or static or stability or memory or long_work",
    "connection": "bearing or mesh or teeth or drive or force or flank or random",
    "element": "element or closed_form or published or axial",
    "exponential": "exponential or sample or contact or step or teeth or changing",
    "film": "journal or equilibri",
    "integrate": "order or method or event or run or time",
    "linalg": "structured or mode or campbell or published",
    "mesh": "mesh or teeth or helical or path or flank or profile",
    "modal": "mode or modal or structured or campbell or static or equilibri or stability",
    "model": "scene or bow or support or coupling or axial or reference or matri",
    "motion": "energy or invariant or response or speed",
    "python": "error or options or persistence or checkpoint or names",
    "rolling": "rolling or equilibri",
    "scene": "scene or description or name or number or unit or kinematic",
}


def environment() -> dict[str, str]:
    """Return the environment of the commands."""
    return os.environ | {
        "CARGO_INCREMENTAL": "1",
        "CARGO_TARGET_DIR": str(Path("target").resolve()),
        "PYO3_PYTHON": sys.executable,
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONPATH": str((COPY / "python").resolve()),
    }


def passes(
    command: list[str], limit: float | None = TIME_LIMIT, coverage: Path | None = None
) -> bool:
    """Return whether a command succeeds in the copy within a time limit [s]."""
    more = {} if coverage is None else {"COVERAGE_FILE": str(coverage.resolve())}
    process = subprocess.Popen(
        command,
        cwd=COPY,
        env=environment() | more,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        return process.wait(limit) == 0
    except subprocess.TimeoutExpired:
        # The processes of the tests belong to the session of the command.
        os.killpg(process.pid, signal.SIGKILL)
        return False


def pytest(*arguments: str, **more: Any) -> bool:
    """Return whether Python tests of the copy pass."""
    return passes([sys.executable, "-m", "pytest", "-q", "-x", *arguments], **more)


def git(*arguments: str) -> str:
    """Return the output of a git command in the copy."""
    found = subprocess.run(
        ["git", *arguments], cwd=COPY, check=True, capture_output=True, text=True
    )
    return found.stdout.strip()


class Fates:
    """The fates of mutants by their descriptions, kept in a file."""

    def __init__(self, kind: str, state: str) -> None:
        self._path = KEPT / f"{kind}-{state[:12]}.json"
        known = self._path.exists()
        self._caught: dict[str, bool] = (
            json.loads(self._path.read_text(encoding="utf-8")) if known else {}
        )

    def get(self, mutant: str) -> bool | None:
        """Return whether a mutant was caught; None if it is new."""
        return self._caught.get(mutant)

    def add(self, mutant: str, caught: bool) -> None:
        """Keep the fate of a mutant."""
        self._caught[mutant] = caught
        self._path.write_text(json.dumps(self._caught, indent=1), encoding="utf-8")


def cargo(*arguments: str, limit: float | None = None) -> bool:
    """Return whether a cargo command succeeds in the copy; more parts compile faster."""
    parts = "profile.release.package.gearbow.codegen-units=64"
    return passes(["cargo", *arguments, "--release", "--locked", "--config", parts], limit)


def build() -> bool:
    """Compile the extension of the copy."""
    if not cargo("build", "--lib", "--features", "python"):
        return False
    shutil.copy("target/release/libgearbow.so", COPY / "python/gearbow/_core.abi3.so")
    return True


@dataclass(frozen=True)
class PythonMutant:
    """A changed module: its path, both texts, and the line of the change."""

    path: Path
    source: str
    text: str
    line: int

    @property
    def difference(self) -> str:
        """Lines that differ, with the path of the module in the repository."""
        lines = self.source.splitlines(), self.text.splitlines()
        name = str(self.path.relative_to(COPY))
        return "\n".join(difflib.unified_diff(*lines, name, n=0))


def draw_python(count: int, chance: random.Random, left_out: list[str]) -> list[PythonMutant]:
    """Draw mutants that are Python and change what the program does."""
    modules = [
        path
        for path in sorted((COPY / "python/gearbow").rglob("*.py"))
        if not any(part in path.as_posix() for part in left_out)
    ]
    operators = [n for n in operator_names() if not any(word in n for word in CRUDE)]
    drawn: list[PythonMutant] = []
    while len(drawn) < count:
        path = chance.choices(modules, [path.stat().st_size for path in modules])[0]
        source = path.read_text(encoding="utf-8")
        operator = get_operator(chance.choice(operators))()
        nodes = ast_nodes(get_ast(source))
        lines = [start[0] for node in nodes for start, _ in operator.mutation_positions(node)]
        if not lines:
            continue
        occurrence = chance.randrange(len(lines))
        text = mutate_code(source, operator, occurrence)
        with contextlib.suppress(SyntaxError):
            # An operator may leave what is no Python, such as {-a} of {**a}.
            if active_code(text) == active_code(source):
                continue
            drawn.append(PythonMutant(path, source, text, lines[occurrence]))
    return drawn


def active_code(source: str) -> str:
    """Return the syntax of a module without annotations, docstrings and `__all__`."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        for name in ("annotation", "returns"):
            if getattr(node, name, None) is not None:
                setattr(node, name, ast.Constant(None))
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            node.body = [part for part in node.body if not is_silent(part)]
    return ast.dump(tree)


def is_silent(statement: ast.stmt) -> bool:
    """Return whether a statement is a docstring or the list of public names."""
    if isinstance(statement, ast.Expr):
        return isinstance(statement.value, ast.Constant)
    names = statement.targets if isinstance(statement, ast.Assign) else []
    return any(isinstance(name, ast.Name) and name.id == "__all__" for name in names)


#: Tests that execute each line of each module, and the duration of each test [s].
Coverage = tuple[dict[str, dict[int, set[str]]], dict[str, float]]


def covered() -> Coverage:
    """Run each file of tests with coverage, unless its result is known."""
    folder = KEPT / f"coverage-{git('rev-parse', '--short=12', 'HEAD:python/gearbow')}"
    folder.mkdir(parents=True, exist_ok=True)
    lines: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
    durations: dict[str, float] = {}
    for path in git("ls-files", "tests/python/*/test_*.py").splitlines():
        name = f"{Path(path).stem}-{git('rev-parse', '--short=12', f'HEAD:{path}')}"
        data, report = folder / f"{name}.coverage", folder / f"{name}.xml"
        if not report.exists():
            made = folder / f"{name}.made"
            options = [
                "--cov=gearbow",
                "--cov-context=test",
                "--cov-report=",
                f"--junitxml={made.resolve()}",
            ]
            if not pytest(*options, path, limit=None, coverage=data):
                raise SystemExit(f"{path} fails without any change: mend it first.")
            made.replace(report)
        for case in ET.parse(report).iter("testcase"):
            # Names of classes of tests follow that of the module.
            classes = case.get("classname", "").split(Path(path).stem, 1)[1].replace(".", "::")
            durations[f"{path}{classes}::{case.get('name')}"] = float(case.get("time", 0.0))
        if data.exists():
            read = CoverageData(str(data))
            read.read()
            for module in read.measured_files():
                for line, contexts in read.contexts_by_lineno(module).items():
                    lines[module][line] |= {name.split("|")[0] for name in contexts if name}
    return lines, durations


def python_mutants(count: int, chance: random.Random, left_out: list[str]) -> list[str]:
    """Return the differences of the Python mutants that no test catches."""
    survivors: list[str] = []
    if not count:
        return survivors
    fates = Fates("python", git("rev-parse", "HEAD"))
    mutants = draw_python(count, chance, left_out)
    lines, durations = covered()
    for mutant in mutants:
        caught = fates.get(mutant.difference)
        if caught is None:
            known = lines[str(mutant.path.resolve())]
            # A line that runs at the import belongs to all tests of its module.
            tests = known.get(mutant.line) or set().union(*known.values())
            chosen, total = [], 0.0
            for test in sorted(tests, key=lambda test: durations.get(test, inf)):
                total += durations.get(test, inf)
                if total < TEST_TIME:
                    chosen.append(test)
            mutant.path.write_text(mutant.text, encoding="utf-8")
            caught = bool(chosen) and not pytest(*chosen)
            mutant.path.write_text(mutant.source, encoding="utf-8")
            fates.add(mutant.difference, caught)
        survivors += report(caught, mutant.difference)
    return survivors


#: What replaces a Rust operator.
SWAPS = {
    "+": ("-", "*"),
    "-": ("+", "*"),
    "*": ("+", "/"),
    "/": ("*", "+"),
    "<": ("<=", ">"),
    "<=": ("<", ">"),
    ">": (">=", "<"),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
    "&&": ("||",),
    "||": ("&&",),
    "+=": ("-=",),
    "-=": ("+=",),
    "*=": ("/=",),
    "/=": ("*=",),
}
#: Syntax without a run-time expression that a switch could replace, and modules of tests.
NO_EXPRESSIONS = {
    *("array_type", "attribute_item", "const_block", "const_item", "macro_invocation", "mod_item"),
    *("static_item", "token_tree", "type_arguments"),
}


@dataclass(frozen=True)
class RustMutant:
    """A changed operator of the Rust core: the bytes of its expression and of itself in a file."""

    file: str
    expression: tuple[int, int]
    operator: tuple[int, int]
    new: str
    name: str

    def texts(self, source: bytes) -> tuple[str, str]:
        """Return the expression of a file as it is, and as the mutant has it."""
        (begin, end), (first, last) = self.expression, self.operator
        changed = source[begin:first] + self.new.encode() + source[last:end]
        return source[begin:end].decode(), changed.decode().replace("\n", " ")


def operators_of(file: str, source: bytes, node: Node) -> Iterator[RustMutant]:
    """Find the operators of a syntax tree that a variable can switch to another one."""
    modifiers = [child.text for child in node.children if child.type == "function_modifiers"]
    if node.type in NO_EXPRESSIONS or any(b"const" in (text or b"") for text in modifiers):
        return
    begin, end = node.start_byte, node.end_byte
    operator: Any = None
    changes: tuple[str, ...] = ()
    if node.type in ("binary_expression", "compound_assignment_expr"):
        operator = node.child_by_field_name("operator")
        changes = SWAPS.get(operator.type, ())
    elif node.type == "unary_expression" and node.children[0].type in "-!":
        operator, changes = node.children[0], ("",)
    if b"//" not in source[begin:end]:
        line, text = node.start_point[0] + 1, " ".join(source[begin:end].decode().split())
        for new in changes:
            name = f"{file}:{line}: {operator.type} becomes {new or 'nothing'} in {text}"
            place = (operator.start_byte, operator.end_byte)
            yield RustMutant(file, (begin, end), place, new, name)
    for child in node.children:
        yield from operators_of(file, source, child)


def draw_rust(count: int, chance: random.Random, left_out: list[str]) -> list[RustMutant]:
    """Draw mutants of the Rust core that do not overlap."""
    parser = Parser(Language(tree_sitter_rust.language()))
    mutants: list[RustMutant] = []
    for path in sorted((COPY / "src").rglob("*.rs")):
        file, source = str(path.relative_to(COPY)), path.read_bytes()
        if not any(part in file for part in [*left_out, "test"]):
            mutants += operators_of(file, source, parser.parse(source).root_node)
    chance.shuffle(mutants)
    drawn: list[RustMutant] = []
    for mutant in mutants:
        begin, end = mutant.expression
        if len(drawn) < count and not any(
            other.file == mutant.file and begin < other.expression[1] and other.expression[0] < end
            for other in drawn
        ):
            drawn.append(mutant)
    return drawn


def write_rust(mutants: dict[int, RustMutant]) -> None:
    """Write all mutants into the sources of the copy, each behind its number."""
    subprocess.run(["git", "checkout", "--quiet", "src"], cwd=COPY, check=True)
    library = COPY / "src/lib.rs"
    library.write_text(library.read_text(encoding="utf-8") + SWITCH, encoding="utf-8")
    for number, mutant in sorted(mutants.items(), key=lambda item: -item[1].expression[0]):
        path = COPY / mutant.file
        source, (begin, end) = path.read_bytes(), mutant.expression
        keep, change = mutant.texts(source)
        text = f"(if crate::is_active({number}) {{ {change} }} else {{ {keep} }})"
        path.write_bytes(source[:begin] + text.encode() + source[end:])


def compile_rust(mutants: list[RustMutant]) -> dict[int, RustMutant]:
    """Compile a program with all mutants, and return those that compile, by number."""
    kept = dict(enumerate(mutants, start=1))
    while True:
        write_rust(kept)
        check = subprocess.run(
            [
                "cargo",
                "check",
                "--release",
                "--locked",
                "--message-format=json",
                "--features",
                "python",
            ],
            check=False,
            cwd=COPY,
            env=environment(),
            capture_output=True,
        )
        if check.returncode == 0:
            return kept
        places = set()
        for line in check.stdout.splitlines():
            message = json.loads(line).get("message") or {}
            if message.get("level") == "error":
                places |= {
                    (span["file_name"], line_number)
                    for span in message["spans"]
                    for line_number in range(span["line_start"], span["line_end"] + 1)
                }
        # The changed texts have no line breaks, so that lines keep their numbers.
        wrong = []
        for number, mutant in kept.items():
            source = subprocess.run(
                ["git", "show", f"HEAD:{mutant.file}"], cwd=COPY, capture_output=True, check=True
            ).stdout
            begin, end = mutant.expression
            first, last = (source[:place].count(b"\n") + 1 for place in (begin, end))
            if any((mutant.file, line) in places for line in range(first, last + 1)):
                wrong.append(number)
        if not wrong:
            raise SystemExit(check.stderr.decode())
        for number in wrong:
            del kept[number]


def rust_mutants(count: int, chance: random.Random, left_out: list[str]) -> list[str]:
    """Return the descriptions of the Rust mutants that no test catches."""
    survivors: list[str] = []
    if not count:
        return survivors
    kept = compile_rust(draw_rust(ceil(SPARE * count), chance, left_out))
    if not (cargo("test", "--no-run") and build() and cargo("test")):
        raise SystemExit("The program fails without any change: mend it first.")
    fates = Fates("rust", git("rev-parse", "HEAD"))
    for number in sorted(kept)[:count]:
        mutant = kept[number]
        caught = fates.get(mutant.name)
        if caught is None:
            named = (p for f, p in TESTS_OF.items() if mutant.file.startswith(f"src/{f}"))
            os.environ["GEARBOW_MUTANT"] = str(number)
            caught = not pytest("tests/python", "-k", next(named, ""))
            caught = caught or not cargo("test", limit=TIME_LIMIT)
            del os.environ["GEARBOW_MUTANT"]
            fates.add(mutant.name, caught)
        survivors += report(caught, mutant.name)
    return survivors


def report(caught: bool, difference: str) -> list[str]:
    """Print the fate of a mutant, and return its difference if no test catches it."""
    print("caught" if caught else "MISSED", difference, sep="\n", flush=True)
    return [] if caught else [difference]


def main() -> None:
    """Make the copy, examine the mutants, and print the share that the tests catch."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--python", type=int, default=150, help="number of Python mutants")
    parser.add_argument("--rust", type=int, default=60, help="number of Rust mutants")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--left-out", nargs="*", default=[], help="parts of names of files")
    given = parser.parse_args()
    KEPT.mkdir(parents=True, exist_ok=True)
    head = subprocess.run(["git", "rev-parse", "HEAD"], check=True, capture_output=True, text=True)
    if not COPY.exists() or git("rev-parse", "HEAD") != head.stdout.strip():
        shutil.rmtree(COPY, ignore_errors=True)
        subprocess.run(["git", "clone", "--quiet", ".", str(COPY)], check=True)
    git("checkout", "--quiet", ".")
    if not build():
        raise SystemExit("The extension does not compile.")
    missed = python_mutants(given.python, random.Random(given.seed), given.left_out)
    missed += rust_mutants(given.rust, random.Random(given.seed), given.left_out)
    count = given.python + given.rust
    share = 1.0 - len(missed) / count
    deviation = sqrt(share * (1.0 - share) / count)
    (KEPT / "missed.diff").write_text("\n\n".join(missed), encoding="utf-8")
    print(f"caught {count - len(missed)} of {count} mutants: {share:.0%} ± {deviation:.0%}")


if __name__ == "__main__":
    main()
