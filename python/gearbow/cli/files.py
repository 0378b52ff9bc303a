"""``gearbow orders`` and ``export``: commands for the file of a run."""

import argparse
from pathlib import Path
from typing import Any

from gearbow._files import check_output
from gearbow.cli.answer import Answer
from gearbow.cli.arguments import Commands, add_command, named_item, read_run
from gearbow.results.steady import SteadyState

__all__ = ["add"]


def add(commands: Commands) -> None:
    """Add the commands."""
    parser = add_command(
        commands,
        "orders",
        orders,
        "print the amplitudes of a run at the orders of shafts and teeth",
        "  gearbow orders run.npz\n"
        "  gearbow orders run.npz --at pinion --quantity z --skip-time 0.1",
    )
    parser.add_argument("run", type=Path, help="file of a run, .npz or .nc")
    parser.add_argument("--json", action="store_true", help="print JSON in place of text")
    parser.add_argument("--at", metavar="ITEM", help="place or mesh; default: the first recorded")
    parser.add_argument("--quantity", help='for example "z" or "force"; default: y or the force')
    parser.add_argument("--count", type=int, default=12, help="number of orders; default: 12")
    parser.add_argument(
        "--skip-time", type=float, default=0.0, help="time of the transient [s]; default: 0"
    )

    parser = add_command(
        commands,
        "export",
        export,
        "write the signals of a run as a table (.csv, .xlsx) or a data set (.nc)",
        "  gearbow export run.npz run.csv\n  gearbow export run.npz run.xlsx",
    )
    parser.add_argument("run", type=Path, help="file of a run, .npz or .nc")
    parser.add_argument("out", help="the new file, .csv, .xlsx, .nc or .npz")
    parser.add_argument("--json", action="store_true", help="print JSON in place of text")


def orders(given: argparse.Namespace) -> Answer:
    """Find the orders of a signal."""
    run = read_run(given.run)
    response = run.response if isinstance(run, SteadyState) else run
    recorded: list[Any] = response.recorded
    at = recorded[0] if given.at is None else named_item(recorded, given.at)
    found = response.orders(at, given.quantity, skip_time=given.skip_time)
    rows = zip(found.orders, found.frequencies_hz, found.amplitudes, strict=True)
    data = {
        "signal": found.label,
        "unit": found.unit,
        "mean": found.mean,
        "rest": found.rest,
        "orders": [
            {"order": o.value, "frequency_hz": hertz, "amplitude": abs(a), "excited_by": str(o)}
            for o, hertz, a in rows
        ],
    }
    return Answer(found.table(given.count), data)


def export(given: argparse.Namespace) -> Answer:
    """Write a run to a file of another format."""
    run = read_run(given.run)
    check_output(Path(given.out))
    run.save(given.out)
    return Answer(f"signals: {given.out}", {"file": given.out})
