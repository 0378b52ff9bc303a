"""The program: its commands, errors and exit codes."""

import argparse
import errno
import io
import os
import re
import signal
import sys
import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from gearbow._core import __version__
from gearbow.cli import (
    completion,
    files,
    identify,
    importing,
    linear,
    new,
    report,
    response,
    runs,
)
from gearbow.cli.answer import Answer
from gearbow.errors import GearbowError, SceneError

__all__ = ["FAILED", "INVALID", "STOPPED", "TERMINATED", "main"]

#: Exit codes: a computation failed, the input is invalid, Ctrl-C, SIGTERM.
FAILED, INVALID, STOPPED, TERMINATED = 1, 2, 130, 143


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
    parser = _parser()
    given = parser.parse_args(arguments)
    if given.command is None:
        parser.print_help()
        sys.exit(0)
    with warnings.catch_warnings(), _stopped_by_signals():
        warnings.showwarning = _show  # type: ignore[assignment]  # it ignores the place
        sys.exit(_code(given))


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
    parser = argparse.ArgumentParser(
        prog="gearbow",
        description="Dynamics of geared shaft trains with residual bow.",
        epilog="examples:\n"
        "  gearbow demo\n"
        "  gearbow new train.toml\n"
        "  gearbow check train.toml\n"
        '  gearbow modes train.toml --speed "1500 rpm"\n'
        '  gearbow run train.toml --duration 0.5 --speed "1500 rpm" --out run.npz\n'
        "\n`gearbow COMMAND --help` describes a command.\n"
        "Exit codes: 0 fine, 1 a computation failed, 2 invalid input, 130 Ctrl-C, 143 SIGTERM.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"gearbow {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    for module in (new, report, importing, linear, response, runs, files, identify):
        module.add(commands)
    completion.add(commands, parser)
    return parser


def _code(given: argparse.Namespace) -> int:
    """Carry out a command, and give its exit code."""
    try:
        _write(given.call(given), given)
    except (_PrintError, BrokenPipeError) as error:
        cause = error.__cause__ or error
        # Python writes the rest at its end.
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not _is_broken_pipe(cause):  # the reader, for example `head`, has enough
            sys.stderr.write(f"{given.command}: stdout cannot be written: {cause}\n")
        return FAILED
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


def _is_broken_pipe(error: BaseException) -> bool:
    """Tell whether the reader of stdout has ended, which Windows calls an invalid argument."""
    is_invalid = isinstance(error, OSError) and error.errno == errno.EINVAL
    return isinstance(error, BrokenPipeError) or (os.name == "nt" and is_invalid)


def _write(answer: Answer | None, given: argparse.Namespace) -> None:
    """Print an answer, then draw its figure: an error of the figure must not lose the answer."""
    if answer is None:
        return
    text = answer.json() if given.json else answer.text
    _print(f"{text}\n" if text else "")
    if answer.drawing is not None:
        answer.drawing.save()
        _print("" if given.json else f"figure: {answer.drawing.path}\n")


def _print(text: str) -> None:
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        raise _PrintError from error


def _fail(given: argparse.Namespace, error: Exception, code: int) -> int:
    """Write an error as one line."""
    text = str(error) or type(error).__name__
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        text = f"{error.filename}: {error.strerror}"
    # The parser of TOML draws the line of the file below its message.
    lines = [line.strip() for line in text.splitlines()]
    text = "; ".join(line for line in lines if line and not re.match(r"\d* *\|", line))
    sys.stderr.write(f"{given.command}: {text}\n")
    return code


def _show(message: Warning | str, *_: Any) -> None:
    """Write a warning as one line."""
    sys.stderr.write(f"warning: {message}\n")
