"""``gearbow completion``: the script with which a shell completes the commands."""

import argparse
from pathlib import Path

from gearbow._extras import extra
from gearbow.cli.answer import Answer
from gearbow.cli.arguments import Commands, add_command, figure, output
from gearbow.machines.examples import scene_files

__all__ = ["add"]

#: Shells that the library knows.
_SHELLS = ("bash", "zsh", "tcsh")


def add(commands: Commands, program: argparse.ArgumentParser) -> None:
    """Add the command for all commands of the program."""
    parser = add_command(
        commands,
        "completion",
        completion,
        "print a script with which a shell completes commands, options and files",
        '  eval "$(gearbow completion bash)"                          # in ~/.bashrc\n'
        "  gearbow completion zsh > ~/.zsh/completions/_gearbow        # in a folder of fpath",
    )
    parser.add_argument("shell", choices=_SHELLS)
    parser.set_defaults(json=False, program=program, commands=commands)


def completion(given: argparse.Namespace) -> Answer:
    """Print the script."""
    with extra("completion"):
        import shtab  # noqa: PLC0415

    for command in given.commands.choices.values():
        for action in command._actions:
            if action.type in (Path, output, figure) or action.dest in ("path", "out"):
                action.complete = shtab.FILE
            if action.dest == "example":
                action.choices = list(scene_files())
    return Answer(shtab.complete(given.program, shell=given.shell), {})
