"""The program: its commands, errors and exit codes."""

import argparse
import os
import re
import sys
import warnings
from collections.abc import Sequence
from typing import Any

from gearbow._core import __version__
from gearbow.cli import linear, new, runs
from gearbow.cli.answer import Answer
from gearbow.cli.arguments import add_command
from gearbow.errors import GearbowError, SceneError
from gearbow.study import command as study

__all__ = ["FAILED", "INVALID", "STOPPED", "main"]

#: Exit codes: a computation failed, the input is invalid, Ctrl-C.
FAILED, INVALID, STOPPED = 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command, and exit with its code: 0 is fine.

    Parameters
    ----------
    arguments : sequence of str, optional
        The arguments; None is those of the program.

    Raises
    ------
    SystemExit
        With the exit code.
    """
    given = _parser().parse_args(arguments)
    with warnings.catch_warnings():
        warnings.showwarning = _show  # type: ignore[assignment]  # it ignores the place
        sys.exit(_code(given))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gearbow",
        description="Dynamics of geared shaft trains with residual bow.",
        epilog="examples:\n"
        "  gearbow new train.toml\n"
        "  gearbow check train.toml\n"
        '  gearbow modes train.toml --speed "1500 rpm"\n'
        '  gearbow run train.toml --duration 0.5 --speed "1500 rpm" --out run.npz\n'
        "\n`gearbow COMMAND --help` describes a command.\n"
        "Exit codes: 0 fine, 1 a computation failed, 2 invalid input, 130 Ctrl-C.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"gearbow {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in (new, linear, runs):
        module.add(commands)
    text = "compute what bent shafts do to a double-stage train: runs, tables and figures"
    examples = "  gearbow study --quick --out study\n  gearbow study --print runs"
    study.add(add_command(commands, "study", study.main, text, examples))
    return parser


def _code(given: argparse.Namespace) -> int:
    """Carry out a command, and give its exit code."""
    try:
        _write(given.call(given), given)
    except (SceneError, OSError) as error:
        if isinstance(error, BrokenPipeError):  # the reader, for example `head`, has enough
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return FAILED
        return _fail(given, error, INVALID)
    except (GearbowError, MemoryError) as error:
        return _fail(given, error, FAILED)
    except KeyboardInterrupt as stop:
        _write(getattr(stop, "answer", None), given)
        sys.stderr.write(f"{given.command}: stopped; what was done is kept\n")
        return STOPPED
    return 0


def _write(answer: Answer | None, given: argparse.Namespace) -> None:
    if answer is not None:
        sys.stdout.write((answer.json() if given.json else answer.text) + "\n")
        sys.stdout.flush()


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
