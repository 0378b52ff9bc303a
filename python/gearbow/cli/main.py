"""The program: its commands, errors and exit codes."""

import argparse
import errno
import io
import json
import math
import os
import re
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout, suppress
from dataclasses import fields, is_dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._core import __version__
from gearbow._files import printable, replacing
from gearbow.cli.answers import Answer
from gearbow.cli.commands import COMMANDS
from gearbow.errors import GearbowError, SceneError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Exit codes: a computation failed, the input is invalid, Ctrl-C, the reader of the output has
#: ended (SIGPIPE), SIGTERM.
FAILED, INVALID, STOPPED, UNREAD, TERMINATED = 1, 2, 130, 141, 143
#: Commands of which the help of the program shows an example.
_FIRST = ("new", "demo", "check", "modes", "run")
#: What the help of a command with units says of them.
_UNITS = 'A number without a unit is in SI units and radians; "500 ms" and "5 mm" have a unit.\n\n'

#: Signals that end a command as Ctrl-C does. SIGBREAK is Ctrl-Break of Windows, the only signal
#: that another program can send there.
_ENDING = [getattr(signal, name) for name in ("SIGTERM", "SIGBREAK") if hasattr(signal, name)]


class _Terminated(KeyboardInterrupt):
    """One of the signals that end a command."""


class _PrintError(Exception):
    """The answer cannot be written to stdout."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command, and exit with its code: 0 is fine."""
    _prepare_output()
    given = argparse.Namespace(command=None, json=False)
    with warnings.catch_warnings(), _stopped_by_signals():
        try:
            code = _code(arguments, given)
        except (_PrintError, BrokenPipeError) as error:
            code = _unprinted(error.__cause__ or error, given)
        sys.exit(code)


def _prepare_output() -> None:
    """Refuse a closed stdout before a computation; escape characters outside its encoding."""
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115  # until the end
    if sys.stdout is None:
        sys.stderr.write(f"gearbow: stdout is closed; redirect it, for example to {os.devnull}\n")
        sys.exit(INVALID)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


@contextmanager
def _stopped_by_signals() -> Iterator[None]:
    """Let SIGTERM and SIGBREAK stop a computation as Ctrl-C does, which keeps what was done."""
    if threading.current_thread() is not threading.main_thread():  # others get no signals
        yield
        return

    def stop(*_: object) -> None:
        for number in _ENDING:
            signal.signal(number, signal.SIG_IGN)  # a second one must not interrupt the saving
        raise _Terminated

    before = {number: signal.signal(number, stop) for number in _ENDING}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _parser() -> argparse.ArgumentParser:
    first = "\n".join(
        command.examples.splitlines()[0] for command in COMMANDS if command.name in _FIRST
    )
    parser = argparse.ArgumentParser(
        prog="gearbow",
        description="Dynamics of geared shaft trains with residual bow.",
        epilog=f"examples:\n{first}\n\n`gearbow COMMAND --help` describes a command.\n"
        "Exit codes: 0 fine, 1 a computation failed, 2 invalid input, 130 Ctrl-C,\n"
        "141 the reader of the output has ended, 143 SIGTERM.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"gearbow {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    parser.set_defaults(program=parser, commands=commands)
    for command in COMMANDS:
        text = _summary(command.method or command.answer)
        each = commands.add_parser(
            command.name,
            help=text,
            description=text,
            epilog=f"{_UNITS if command.method else ''}examples:\n{command.examples}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        each.set_defaults(analysis=command.method, answer=command.answer)
        for one in command.arguments:
            one(each)
        each.set_defaults(options=_options(each))
    return parser


def _summary(function: Callable[..., Any]) -> str:
    """Give the first sentence of the documentation of a function; python -OO has none."""
    text = (function.__doc__ or "").strip().partition("\n\n")[0].removesuffix(".")
    return text[:1].lower() + text[1:]


def _options(parser: argparse.ArgumentParser) -> dict[str, str]:
    """Give the options of a command by the names that messages have for them."""
    found = {}
    # The values of an option with choices are valid.
    for action in (action for action in parser._actions if action.choices is None):
        option = action.option_strings[0] if action.option_strings else action.dest
        found[option.removeprefix("--").replace("-", "_")] = option
        found[action.dest] = option
    return found


def _code(arguments: Sequence[str] | None, given: argparse.Namespace) -> int:
    """Read the arguments, carry out the command, and give its exit code."""
    try:
        _parse(arguments, given)
        warnings.showwarning = partial(_show, given)
        _write(given.answer(given), given)
    except BrokenPipeError:
        raise
    except (SceneError, OSError) as error:
        return _fail(given, error, INVALID)
    except (GearbowError, MemoryError) as error:
        return _fail(given, error, FAILED)
    except KeyboardInterrupt as stop:
        with suppress(_PrintError):
            _write(getattr(stop, "answer", None), given)
        sys.stderr.write(f"{given.command}: stopped; what was done is kept\n")
        return TERMINATED if isinstance(stop, _Terminated) else STOPPED
    return 0


def _parse(arguments: Sequence[str] | None, given: argparse.Namespace) -> None:
    """Read the arguments; help and wrong arguments end the program."""
    parser = _parser()
    help_text = io.StringIO()  # argparse would ignore that stdout cannot be written
    try:
        with redirect_stdout(help_text):
            parser.parse_args(arguments, given)
            if given.command is None:
                parser.print_help()
                parser.exit()
    finally:
        _print(help_text.getvalue())


def _unprinted(error: BaseException, given: argparse.Namespace) -> int:
    """Say that stdout cannot be written, unless its reader, for example `head`, has enough."""
    # Windows calls a pipe without reader an invalid argument.
    is_invalid = isinstance(error, OSError) and error.errno == errno.EINVAL
    is_unread = isinstance(error, BrokenPipeError) or (os.name == "nt" and is_invalid)
    for stream in (sys.stdout, sys.stderr) if is_unread else (sys.stdout,):
        # Python writes the rest at its end.
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    if is_unread:
        return UNREAD
    sys.stderr.write(f"{given.command or 'gearbow'}: stdout cannot be written: {error}\n")
    return FAILED


def _write(answer: Answer | None, given: argparse.Namespace) -> None:
    """Print an answer, then draw its figure: an error of the figure must not lose the answer."""
    if answer is None:
        return
    text = answer.text
    if given.json:
        text = json.dumps(_plain(answer.data), indent=2, allow_nan=False)
    _print(f"{text}\n" if text else "")
    path = getattr(given, "figure", None)
    if answer.draw is not None and path is not None:
        save_figure(answer.draw(), path)
        _print("" if given.json else f"figure: {path}\n")


def _plain(value: Any) -> Any:
    """Give a value as JSON has it; numbers that it lacks (NaN, infinity) become null."""
    if is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def save_figure(figure: "Figure", path: Path) -> None:
    """Write a figure to a file."""
    ending = path.suffix[1:].lower()
    with replacing(path) as file:
        if ending == "svg":  # a file of XML, which a name may not make invalid
            stream = io.StringIO()
            figure.savefig(stream, format=ending)
            file.write(printable(stream.getvalue()).encode())
        else:
            figure.savefig(file, format=ending)


def _print(text: str) -> None:
    if not text:
        return
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        raise _PrintError from error


def _fail(given: argparse.Namespace, error: Exception, code: int) -> int:
    text = str(error) or type(error).__name__
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        text = f"{error.filename}: {error.strerror}"
    # The parser of TOML draws the line of the file below its message.
    lines = [line.strip() for line in text.splitlines()]
    text = "; ".join(line for line in lines if line and not re.match(r"\d* *\|", line))
    sys.stderr.write(f"{given.command}: {_in_options(text, given.options)}\n")
    return code


def _show(given: argparse.Namespace, message: Warning | str, *_: Any) -> None:
    sys.stderr.write(f"warning: {_in_options(str(message), given.options)}\n")


def _in_options(text: str, options: Mapping[str, str]) -> str:
    """Name the options of the command in a message that names arguments of a method."""
    place = re.match(r"(\w+)((?:\[\d+\]|\.\w+)*)(\['.*?'\])?(?=: )", text)
    if place is not None and place[1] in options:
        # A value for one of several parts, as in "endurance_limit['input']".
        part = "" if place[3] is None else f" of {place[3][2:-2]}"
        text = options[place[1]] + part + text[place.end() :]
    # As in "give noise= or more speeds".
    return re.sub(r"\b(\w+)=(?= )", lambda found: options.get(found[1], found[0]), text)
