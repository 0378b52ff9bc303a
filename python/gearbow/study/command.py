"""``python -m gearbow study``: write runs, tables and figures into one folder."""

import argparse
import sys
from pathlib import Path

from gearbow._extras import extra
from gearbow._files import replacing
from gearbow.errors import MissingExtraError
from gearbow.study.findings import TABLES
from gearbow.study.runs import run
from gearbow.study.settings import SCENE, Settings
from gearbow.study.table import write
from gearbow.study.view import Study

__all__ = ["add", "main"]


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command to its parser."""
    parser.add_argument(
        "--workers", type=_positive, help="number of parallel runs; default: number of cores"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("study"), help="folder for tables, figures and runs"
    )
    parser.add_argument("--quick", action="store_true", help="run a small part of the study only")
    parser.add_argument(
        "--scene", type=Path, default=SCENE, help="TOML file with another scene and settings"
    )
    parser.add_argument(
        "--print",
        choices=list(TABLES),
        dest="table",
        help="print one table in Markdown; write only missing runs, no tables and figures",
    )


def main(given: argparse.Namespace) -> None:
    """Carry out the study."""
    settings = Settings.load(given.scene)
    if given.quick:
        settings = settings.quick()
    folder: Path = given.out
    results = run(settings, folder / "runs", given.workers, progress=sys.stderr.isatty())
    study = Study(settings, results, folder / "runs")
    if given.table:
        sys.stdout.write(f"{TABLES[given.table](study)}\n")
        return
    write(settings, results, folder)
    tables = "\n\n".join(f"## {name}\n\n{table(study)}" for name, table in TABLES.items())
    with replacing(folder / "findings.md") as file:
        file.write(f"# Bow study\n\n{tables}\n".encode())
    sys.stdout.write(f"{len(results)} runs; tables: {folder}\n")
    try:
        with extra("plot"):
            from gearbow.study import figures  # noqa: PLC0415
    except MissingExtraError as error:
        sys.exit(f"no figures: {error}")
    for path in figures.write(study, folder):
        sys.stdout.write(f"figure: {path}\n")


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, got {value}")
    return value
