"""``gearbow report`` and ``demo``: a report of a scene, or of an example of the package."""

import argparse
import webbrowser
from pathlib import Path

from gearbow._files import check_name
from gearbow.cli.answer import Answer
from gearbow.cli.arguments import Commands, add_command, add_progress, add_scene, spaced, speed
from gearbow.cli.systems import read_system
from gearbow.errors import SceneError
from gearbow.machines.examples import example
from gearbow.units.speed import RevolutionsPerMinuteArray, given_unit

__all__ = ["add"]

#: Example of `gearbow demo` without a name: it has gears and bows, and is small.
_DEMO = "double_stage_train"


def add(commands: Commands) -> None:
    """Add the commands."""
    parser = add_command(
        commands,
        "report",
        report,
        "write a report of all analyses as one HTML page",
        '  gearbow report gearbox.toml --speed "1480 rpm"\n'
        '  gearbow report gearbox.toml --speed "1200 rpm" "1480 rpm" --to "3000 rpm" --out g.html',
    )
    add_scene(parser)
    parser.add_argument(
        "--speed",
        type=speed,
        nargs="+",
        help='operating speed, or the lowest and the highest, for example "1480 rpm"; without it '
        "the report has standstill",
    )
    parser.add_argument(
        "--from",
        type=speed,
        dest="first",
        help="lowest speed of the diagrams; default: 5 %% of --to",
    )
    parser.add_argument(
        "--to",
        type=speed,
        dest="last",
        help="highest speed of the diagrams; default: 150 %% of the operating speed",
    )
    parser.add_argument("--points", type=int, default=100, help="number of speeds; default: 100")
    parser.add_argument("--modes", type=int, default=8, help="number of modes; default: 8")
    parser.add_argument("--title", help="heading; default: the name of the scene file")
    parser.add_argument("--out", help="file .html; default: the name of the scene file")
    add_progress(parser)

    parser = add_command(
        commands,
        "demo",
        demo,
        "write the report of an example, and open it in the browser",
        "  gearbow demo\n  gearbow demo gearbox --no-open",
    )
    parser.add_argument(
        "example", nargs="?", default=_DEMO, help="name of a machine; default: %(default)s"
    )
    parser.add_argument("--out", help="file .html; default: the name of the example")
    parser.add_argument("--no-open", action="store_true", help="do not open the browser")
    parser.add_argument("--json", action="store_true", help="print JSON in place of text")
    add_progress(parser)


def report(given: argparse.Namespace) -> Answer:
    """Write a report."""
    out, _ = check_name(given.out or f"{given.scene.stem}.html", [".html"], "--out")
    if given.speed is not None and len(given.speed) > 2:
        raise SceneError(f"--speed: give one speed, or two, got {len(given.speed)}")
    if given.first is not None and given.last is None:
        raise SceneError("--from: needs --to")
    if given.last is not None and given.first is None:
        # Journal bearings carry nothing at speed 0.
        given.first = type(given.last)(0.05 * given.last)
    speeds = None if given.last is None else spaced(given, "speeds")
    if speeds is not None and given_unit((given.first, given.last)) == "rpm":
        speeds = speeds.view(RevolutionsPerMinuteArray)
    read_system(given).report(
        out,
        operating=None if given.speed is None else (given.speed[0], given.speed[-1]),
        speeds=speeds,
        modes=given.modes,
        title=given.title or given.scene.stem,
        progress=given.progress,
    )
    return _answer(out)


def demo(given: argparse.Namespace) -> Answer:
    """Write the report of an example."""
    machine = example(given.example)
    out, _ = check_name(given.out or f"{machine.name}.html", [".html"], "--out")
    machine.load().report(
        out, operating=machine.speed, title=machine.title, progress=given.progress
    )
    if not given.no_open:
        webbrowser.open(out.resolve().as_uri())
    return _answer(out)


def _answer(out: Path) -> Answer:
    return Answer(f"report: {out}", {"file": str(out)})
