"""Change one place of the program at a time, and count how many of these mutants the tests notice.

    python tools/mutants.py [--python 60] [--rust 60] [--seed 1] [--jobs 2] [--left-out PART ...]

The mutants are drawn at random from those of cosmic-ray (Python) and from the operators of the Rust
core (`SWAPS`); a Python mutant that changes only annotations, docstrings or `__all__` is not drawn.
All of them are written into one copy of the working tree, in target/mutants. The environment
variable GEARBOW_MUTANT switches one of them on.

One run of the Python tests without a mutant, with the first case of each test, records which
tests reach which mutants (`mutant_switch.py`). A mutant then runs tests that reach it until one
fails: first the shortest test of each file, then others, with a limit of their total time. A Rust
mutant that these tests do not notice runs the Rust tests too. The script prints each mutant with
the test that noticed it, and the share of noticed mutants of each language with its standard
deviation. Records and results are kept in target/mutant-results: a call that was interrupted goes
on where it ended, and a later call runs new tests, and the mutants that no test noticed.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import difflib
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from math import ceil, inf, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tree_sitter_rust
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names
from tree_sitter import Language, Node, Parser

if TYPE_CHECKING:
    from collections.abc import Iterator

COPY = Path("target/mutants")
#: Records of the tests and results of the mutants.
KEPT = Path("target/mutant-results")
#: The Python tests, without the documents, whose examples run long and check little.
TESTS = ("python/gearbow", "tests/python", "tests/extremes")
#: Longest sum of the durations of the Python tests for one mutant, and longest phase of one
#: test [s]. A test that takes longer is stopped while the record is made.
TEST_TIME, LONGEST = 60.0, 30.0
#: Time limit of the Python tests of one mutant: this many times the sum of their durations, and
#: a time for the start of pytest [s]. A mutant that exceeds a time limit counts as noticed.
TIME_FACTOR, START_TIME = 4.0, 60.0
#: Time limit of the Rust tests of one mutant [s].
RUST_TIME = 900.0
#: What the Rust core of the copy gets. Only the extension module writes a record.
SWITCH = r"""
pub(crate) fn is_active(mutant: usize) -> bool {
    static ACTIVE: std::sync::LazyLock<Option<usize>> = std::sync::LazyLock::new(|| {
        std::env::var("GEARBOW_MUTANT").ok()?.strip_prefix("rust ")?.parse().ok()
    });
    #[cfg(feature = "python")]
    if !REACHED[mutant].load(std::sync::atomic::Ordering::Relaxed) {
        record(mutant);
    }
    *ACTIVE == Some(mutant)
}

#[cfg(feature = "python")]
static REACHED: [std::sync::atomic::AtomicBool; COUNT] =
    [const { std::sync::atomic::AtomicBool::new(false) }; COUNT];

#[cfg(feature = "python")]
fn record(mutant: usize) {
    use std::io::Write;
    REACHED[mutant].store(true, std::sync::atomic::Ordering::Relaxed);
    let Some(path) = std::env::var_os("GEARBOW_RECORD") else { return };
    let current = std::env::var("PYTEST_CURRENT_TEST").unwrap_or_default();
    let (test, when) = current.rsplit_once(" (").unwrap_or_default();
    let when = when.trim_end_matches(')');
    let entry = format!("\"mutant\": \"rust {mutant}\", \"test\": {test:?}, \"when\": {when:?}");
    let line = format!("{{{entry}}}\n");
    if let Ok(mut file) = std::fs::OpenOptions::new().append(true).create(true).open(path) {
        let _ = file.write_all(line.as_bytes());
    }
}

#[cfg(feature = "python")]
pub(crate) fn forget_reached() {
    for mutant in &REACHED {
        mutant.store(false, std::sync::atomic::Ordering::Relaxed);
    }
}
"""
#: The function of the extension module that `mutant_switch.py` calls before each phase of a test.
FORGET = """mod _core {
    #[pyo3::pyfunction]
    fn forget_reached() {
        crate::forget_reached();
    }
"""
#: Drawn Rust mutants for each wanted one: a few do not compile.
SPARE = 1.2
#: Parts of the names of operators that nearly every test notices: they change the type of a value.
CRUDE = ("Shift", "Bit", "Decorator", "Variable", "Invert", "Exception", "_Is", "Mod", "FloorDiv")


def environment(**more: str) -> dict[str, str]:
    """Return the environment of the commands."""
    paths = [COPY / "python", Path(__file__).parent]
    return {
        "CARGO_TARGET_DIR": str(Path("target/mutants-build").resolve()),
        **os.environ,
        "PYO3_PYTHON": sys.executable,
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONPATH": os.pathsep.join(str(path.resolve()) for path in paths),
        **more,
    }


def run(command: list[str], limit: float = inf, **more: str) -> tuple[int | None, str]:
    """Run a command in the copy.

    Return its exit code, None at the time limit [s], and its standard output.
    """
    process = subprocess.Popen(
        command,
        cwd=COPY,
        env=environment(**more),
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        text=True,
    )
    try:
        output, _ = process.communicate(timeout=None if limit == inf else limit)
    except subprocess.TimeoutExpired:
        # The processes of the tests belong to the session of the command.
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return None, ""
    return process.returncode, output


def pytest(*arguments: str, **more: Any) -> tuple[int | None, str]:
    """Run Python tests of the copy."""
    common = ["-q", "--no-header", "--tb=no", "-rfE", "-p", "no:cacheprovider"]
    return run([sys.executable, "-m", "pytest", *common, *arguments], **more)


@dataclass(frozen=True)
class PythonMutant:
    """A changed module: its path, both texts, and the place of the innermost changed statement.

    The place is the number of the statement in `ast.walk`, and its first and last line.
    """

    path: Path
    source: str
    text: str
    statement: int
    lines: range

    @property
    def name(self) -> str:
        """Lines that differ, with the path of the module."""
        lines = self.source.splitlines(), self.text.splitlines()
        return "\n".join(difflib.unified_diff(*lines, str(self.path), n=0))


def draw_python(count: int, chance: random.Random, left_out: list[str]) -> list[PythonMutant]:
    """Draw mutants in different statements that are Python and change what the program does."""
    modules = [
        path
        for path in sorted(Path("python/gearbow").rglob("*.py"))
        if not any(part in path.as_posix() for part in left_out)
    ]
    operators = [n for n in operator_names() if not any(word in n for word in CRUDE)]
    drawn: list[PythonMutant] = []
    while len(drawn) < count:
        path = chance.choices(modules, [path.stat().st_size for path in modules])[0]
        source = path.read_text(encoding="utf-8")
        operator = get_operator(chance.choice(operators))()
        nodes = ast_nodes(get_ast(source))
        places = sum(1 for node in nodes for _ in operator.mutation_positions(node))
        if not places:
            continue
        text = mutate_code(source, operator, chance.randrange(places))
        # An operator may leave what is no Python, such as {-a} of {**a}.
        with contextlib.suppress(SyntaxError):
            compile(text, path, "exec")
            if active_code(text) == active_code(source):
                continue
            before, after = (statements(ast.parse(text)) for text in (source, text))
            pairs = enumerate(zip(before, after, strict=True))
            # Statements come before those that they contain.
            changed = [i for i, (old, new) in pairs if ast.dump(old) != ast.dump(new)][-1]
            first = before[changed]
            begin = min(n.lineno for n in [first, *getattr(first, "decorator_list", [])])
            lines = range(begin, (first.end_lineno or begin) + 1)
            if not any(
                other.path == path
                and other.lines.start < lines.stop
                and lines.start < other.lines.stop
                for other in drawn
            ):
                drawn.append(PythonMutant(path, source, text, changed, lines))
    return drawn


def statements(tree: ast.AST) -> list[ast.stmt]:
    """Return the statements of a syntax tree, each before those that it contains."""
    return [node for node in ast.walk(tree) if isinstance(node, ast.stmt)]


def call_of_switch(mutant: str) -> ast.expr:
    """Return the expression that says whether a mutant is switched on."""
    text = f"__import__('mutant_switch').is_active({mutant!r})"
    return ast.parse(text, mode="eval").body


class Switches(ast.NodeTransformer):
    """Replace each changed statement by an `if` with the mutant and the original."""

    def __init__(self, changes: dict[ast.AST, tuple[str, ast.stmt]]) -> None:
        self._changes = changes

    def visit(self, node: ast.AST) -> ast.AST:
        """Replace a node if it is a changed statement."""
        known = self._changes.get(node)
        if known is None:
            return self.generic_visit(node)
        mutant, new = known
        assert isinstance(node, ast.stmt)
        return ast.If(call_of_switch(mutant), [new], [node])


def with_python_switches(mutants: dict[str, PythonMutant]) -> str:
    """Return the text of a module with all its mutants, each behind its switch."""
    tree = ast.parse(next(iter(mutants.values())).source)
    functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]
    inner = {part for function in functions for s in function.body for part in ast.walk(s)}
    changes: dict[ast.AST, tuple[str, ast.stmt]] = {}
    numbered = statements(tree)
    for name, mutant in mutants.items():
        old = numbered[mutant.statement]
        changes[old] = name, statements(ast.parse(mutant.text))[mutant.statement]
    for changed, (name, _) in changes.items():
        if changed not in inner:
            # It runs at the import: the tests that call a function of the module reach it.
            for function in functions:
                begin = 0 if ast.get_docstring(function, clean=False) is None else 1
                function.body.insert(begin, ast.Expr(call_of_switch(name)))
    return ast.unparse(ast.fix_missing_locations(Switches(changes).visit(tree))) + "\n"


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
    #: First and last line of the expression, from 1 on.
    lines: tuple[int, int]

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
        lines = node.start_point[0] + 1, node.end_point[0] + 1
        text = " ".join(source[begin:end].decode().split())
        for new in changes:
            name = f"{file}:{lines[0]}: {operator.type} becomes {new or 'nothing'} in {text}"
            place = (operator.start_byte, operator.end_byte)
            yield RustMutant(file, (begin, end), place, new, name, lines)
    for child in node.children:
        yield from operators_of(file, source, child)


def draw_rust(count: int, chance: random.Random, left_out: list[str]) -> list[RustMutant]:
    """Draw mutants of the Rust core that do not overlap."""
    parser = Parser(Language(tree_sitter_rust.language()))
    mutants: list[RustMutant] = []
    for path in sorted(Path("src").rglob("*.rs")):
        file, source = path.as_posix(), path.read_bytes()
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


def with_rust_switches(file: str, mutants: dict[str, RustMutant]) -> bytes:
    """Return the text of a file of the Rust core with all its mutants, each behind its switch."""
    text = source = Path(file).read_bytes()
    for name, mutant in sorted(mutants.items(), key=lambda item: -item[1].expression[0]):
        begin, end = mutant.expression
        keep, change = mutant.texts(source)
        number = name.split()[1]
        switched = f"(if crate::is_active({number}) {{ {change} }} else {{ {keep} }})"
        text = text[:begin] + switched.encode() + text[end:]
    return text


Mutant = PythonMutant | RustMutant


def write_copy(mutants: dict[str, Mutant]) -> None:
    """Copy the files of the working tree, with the mutants; what is unchanged keeps its time."""
    changed: dict[str, bytes] = {}
    of_file: dict[str, dict[str, Any]] = defaultdict(dict)
    for name, mutant in mutants.items():
        of_file[mutant.file if isinstance(mutant, RustMutant) else str(mutant.path)][name] = mutant
    for file, here in of_file.items():
        is_rust = file.endswith(".rs")
        changed[file] = (
            with_rust_switches(file, here) if is_rust else with_python_switches(here).encode()
        )
    count = 1 + max((int(n.split()[1]) for n in mutants if n.startswith("rust")), default=0)
    library, module = Path("src/lib.rs"), Path("src/python/mod.rs")
    switch = SWITCH.replace("COUNT", str(count)).encode()
    changed[str(library)] = changed.get(str(library), library.read_bytes()) + switch
    text = changed.get(str(module), module.read_bytes())
    changed[str(module)] = text.replace(b"mod _core {\n", FORGET.encode(), 1)
    listed = subprocess.run(["git", "ls-files", "-z"], check=True, capture_output=True, text=True)
    files = {file for file in listed.stdout.split("\0") if file and Path(file).exists()}
    for old in COPY.rglob("*"):
        if old.suffix in (".py", ".rs", ".md") and str(old.relative_to(COPY)) not in files:
            old.unlink()
    for file in files:
        path = COPY / file
        path.parent.mkdir(parents=True, exist_ok=True)
        if Path(file).is_symlink():
            if not path.is_symlink():
                path.symlink_to(Path(file).readlink())
            continue
        content = changed.get(file, Path(file).read_bytes())
        if not path.exists() or path.read_bytes() != content:
            path.write_bytes(content)


def build(mutants: dict[str, Mutant]) -> dict[str, Mutant]:
    """Compile the extension module of the copy, and return the mutants that compile."""
    options = ["--locked", "--profile", "quick", "--features", "python", "--lib"]
    while True:
        write_copy(mutants)
        code, output = run(
            ["cargo", "rustc", "--message-format=json", *options, "--crate-type", "cdylib"]
        )
        if code == 0:
            library = Path(environment()["CARGO_TARGET_DIR"]) / "quick/libgearbow.so"
            shutil.copy(library, COPY / "python/gearbow/_core.abi3.so")
            return mutants
        spans, messages = [], []
        for line in output.splitlines():
            message = json.loads(line).get("message") or {}
            if message.get("level") == "error":
                spans += message["spans"]
                messages.append(message["rendered"])
        # The changed texts have no line breaks, so that lines keep their numbers.
        wrong = [
            name
            for name, mutant in mutants.items()
            if isinstance(mutant, RustMutant)
            and any(
                span["file_name"] == mutant.file
                and span["line_start"] <= mutant.lines[1]
                and mutant.lines[0] <= span["line_end"]
                for span in spans
            )
        ]
        if not wrong:
            raise SystemExit("\n".join(messages) or "The extension module does not compile.")
        mutants = {name: mutant for name, mutant in mutants.items() if name not in wrong}


@dataclass
class Record:
    """What the first cases of the tests told."""

    #: Duration of each phase of a test that passes [s].
    durations: dict[str, dict[str, float]] = field(default_factory=lambda: defaultdict(dict))
    #: Tests that reach a mutant.
    reaching: dict[str, set[str]] = field(default_factory=lambda: defaultdict(set))
    #: Number of cases of a test that has several.
    cases: dict[str, int] = field(default_factory=dict)

    def duration(self, test: str) -> float:
        """Return the duration of all cases of a test [s]."""
        return self.durations[test]["call"] * self.cases.get(test, 1)

    def chosen(self, mutant: str) -> tuple[list[str], float]:
        """Return tests for a mutant in the order of their run, and the sum of their durations [s].

        The shortest test of each file comes first, then others, until the sum is `TEST_TIME`. A
        test runs with all its cases.
        """
        fixtures: dict[str, float] = defaultdict(float)
        for test, phases in self.durations.items():
            fixtures[file_of(test)] = max(fixtures[file_of(test)], phases["setup"])
        of_file: dict[str, list[str]] = defaultdict(list)
        for test in sorted(self.reaching[mutant], key=self.duration):
            of_file[file_of(test)].append(test)
        ranked = [
            (rank, self.duration(test), test)
            for tests in of_file.values()
            for rank, test in enumerate(tests)
        ]
        first: list[str] = []
        later: list[str] = []
        total = 0.0
        for rank, duration, test in sorted(ranked):
            added = duration + (0.0 if rank else fixtures[file_of(test)])
            if total + added < TEST_TIME:
                total += added
                (later if rank else first).append(test.split("[", maxsplit=1)[0])
        return first + sorted(later, key=file_of), total


def file_of(test: str) -> str:
    """Return the file of a test."""
    return test.split("::", maxsplit=1)[0]


def run_tests(folder: Path, jobs: int) -> None:
    """Run the tests that no earlier call recorded, and write a record."""
    number = len(list(folder.glob("*.jsonl")))
    options = ["-n", str(jobs), "--dist", "worksteal"] if jobs > 1 else []
    more = {
        "GEARBOW_RECORD": str((folder / f"{number}.jsonl").resolve()),
        "GEARBOW_TEST_LIMIT": str(LONGEST),
    }
    # gearbow may import the plugin before pytest does.
    plugin = ["-p", "mutant_switch", "-W", "ignore::pytest.PytestAssertRewriteWarning"]
    _, output = pytest(*plugin, *options, *TESTS, **more)
    (folder / "record.txt").write_text(output, encoding="utf-8")
    if number == 0 and "passed" not in output:
        raise SystemExit(f"No test passes without a mutant:\n{output}")


def read_records(folder: Path) -> Record:
    """Read the records of all calls."""
    record = Record()
    outcomes: dict[str, set[str]] = defaultdict(set)
    reached: list[dict[str, str]] = []
    for path in folder.glob("*.jsonl"):
        for line in path.read_text(encoding="utf-8").splitlines():
            entry = json.loads(line)
            if "mutant" in entry:
                reached.append(entry)
            elif "cases" in entry:
                record.cases[entry["test"]] = entry["cases"]
            else:
                record.durations[entry["test"]][entry["when"]] = entry["duration"]
                outcomes[entry["test"]].add(entry["outcome"])
    for test, seen in outcomes.items():
        # Setup, call and teardown
        if seen != {"passed"} or len(record.durations[test]) < 3:
            del record.durations[test]
    of_file: dict[str, list[str]] = defaultdict(list)
    for test in record.durations:
        of_file[file_of(test)].append(test)
    for entry in reached:
        # A fixture may serve all tests of its file.
        tests = of_file[file_of(entry["test"])] if entry["when"] == "setup" else [entry["test"]]
        known = (test for test in tests if test in record.durations)
        record.reaching[entry["mutant"]].update(known)
    return record


def noticed_by(name: str, record: Record) -> str:
    """Return the first Python test that fails with a mutant; an empty text if none does."""
    tests, total = record.chosen(name)
    if not tests:
        return ""
    code, output = pytest("-x", *tests, limit=START_TIME + TIME_FACTOR * total, GEARBOW_MUTANT=name)
    if code == 0:
        return ""
    failed = [line for line in output.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return "time limit" if code is None else failed[0] if failed else f"exit code {code}"


def rust_tests_notice(name: str) -> str:
    """Return a text that is not empty if the Rust tests of the copy fail with a mutant."""
    command = ["cargo", "test", "--locked", "--profile", "quick"]
    if run([*command, "--no-run"])[0] != 0:
        raise SystemExit("The Rust tests do not compile.")
    code, output = run(command, limit=RUST_TIME, GEARBOW_MUTANT=name)
    failed = [line for line in output.splitlines() if line.endswith("FAILED")]
    return "" if code == 0 else failed[0] if failed else "Rust tests"


def report(mutants: dict[str, Mutant], results: dict[str, str], reached: dict[str, int]) -> str:
    """Return the shares of noticed mutants, and those that no test noticed."""
    lines = []
    for language in ("python", "rust"):
        names = [name for name in results if name.startswith(language)]
        missed = [name for name in names if not results[name]]
        if names:
            share = 1.0 - len(missed) / len(names)
            deviation = sqrt(share * (1.0 - share) / len(names))
            lines.append(
                f"{language}: {len(names) - len(missed)} of {len(names)} mutants noticed: "
                f"{share:.0%} ± {deviation:.0%}"
            )
        for name in missed:
            lines.append(f"MISSED, reached by {reached[name]} tests:\n{mutants[name].name}\n")
    return "\n".join(lines)


def main() -> None:
    """Make the copy, run the tests of the mutants, and print the share that they notice."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--python", type=int, default=60, help="number of Python mutants")
    parser.add_argument("--rust", type=int, default=60, help="number of Rust mutants")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes")
    parser.add_argument("--left-out", nargs="*", default=[], help="parts of names of files")
    parser.add_argument("--no-rust-tests", action="store_true", help="run Python tests only")
    given = parser.parse_args()
    drawn: dict[str, Mutant] = {}
    python = draw_python(given.python, random.Random(given.seed), given.left_out)
    rust = draw_rust(ceil(SPARE * given.rust), random.Random(given.seed), given.left_out)
    drawn |= {f"python {number}": mutant for number, mutant in enumerate(python)}
    drawn |= {f"rust {number}": mutant for number, mutant in enumerate(rust)}
    names = "\n".join(mutant.name for mutant in drawn.values())
    folder = KEPT / hashlib.sha256(names.encode()).hexdigest()[:12]
    folder.mkdir(parents=True, exist_ok=True)
    compiled, kept = folder / "compiled.json", folder / "noticed.json"
    if compiled.exists():
        drawn = {name: drawn[name] for name in json.loads(compiled.read_text(encoding="utf-8"))}
    mutants = build(drawn)
    compiled.write_text(json.dumps(list(mutants)), encoding="utf-8")
    wanted = [name for name in mutants if name.startswith("python")]
    wanted += [name for name in mutants if name.startswith("rust")][: given.rust]
    run_tests(folder, given.jobs)
    record = read_records(folder)
    noticed: dict[str, str] = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    results = dict(noticed)

    def keep(name: str, test: str) -> None:
        results[name] = test
        print(f"{name}: {test or 'MISSED'}\n{mutants[name].name}", flush=True)
        found = {name: test for name, test in results.items() if test}
        kept.write_text(json.dumps(found, indent=1), encoding="utf-8")

    waiting = [name for name in wanted if name not in noticed]
    with ThreadPoolExecutor(given.jobs) as pool:
        for name, test in zip(
            waiting, pool.map(lambda name: noticed_by(name, record), waiting), strict=True
        ):
            keep(name, test)
    if not given.no_rust_tests:
        for name in [name for name in waiting if name.startswith("rust") and not results[name]]:
            keep(name, rust_tests_notice(name))
    reached = {name: len(record.reaching[name]) for name in wanted}
    text = report(mutants, results, reached)
    (folder / "report.txt").write_text(text + "\n", encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
