"""The commands of the package: ``python -m gearbow COMMAND``."""

import argparse
import sys

from gearbow.errors import GearbowError
from gearbow.study import command as study


def main() -> None:
    """Run a command."""
    parser = argparse.ArgumentParser(prog="python -m gearbow")
    commands = parser.add_subparsers(dest="command", required=True)
    text = "what bent shafts do to a double-stage train: runs, tables and figures"
    study.add(commands.add_parser("study", help=text, description=text))
    given = parser.parse_args()
    try:
        study.main(given)
    except GearbowError as error:
        sys.exit(f"{given.command}: {error}")
    except KeyboardInterrupt:
        sys.exit(f"{given.command}: stopped; what was done is kept")


if __name__ == "__main__":
    main()
