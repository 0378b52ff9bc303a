"""Composition of a report: sections one after the other, the summary, and how to repeat it."""

import platform
from collections.abc import Iterator
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np

from gearbow._core import __version__
from gearbow._progress import reported
from gearbow._types import Progress
from gearbow.description.time_series import refuse_functions
from gearbow.report.contents import SECTIONS
from gearbow.report.page import Block, Code, Note, Section, write
from gearbow.report.shared import Contents, Options
from gearbow.units.speed import SpeedUnit, speed_text


def compose(system: Any, path: Path, options: Options, progress: bool | Progress | None) -> None:
    """Compute the sections and write the page, after Ctrl-C with the finished sections."""
    contents = Contents(system, options)
    sections: list[Section] = []
    total, look = len(SECTIONS), {"what": "report", "estimate": False, "numbers": ".0f"}
    with reported(progress, total, "sections", **look) as report:  # type: ignore[arg-type]
        try:
            for name, title, make in SECTIONS:
                sections.append(contents.section(name, title, make))
                if report is not None:
                    report(len(sections) / total)
        except KeyboardInterrupt:
            _write(path, contents, sections)
            raise
    _write(path, contents, sections)


def _write(path: Path, contents: Contents, sections: list[Section]) -> None:
    """Write the page with a summary and the way to repeat it."""
    summary = Section("summary", "Summary")
    summary.blocks += [Note(text, warning) for text, warning in contents.findings]
    if len(sections) < len(SECTIONS):
        left = ", ".join(title for _, title, _ in SECTIONS[len(sections) :])
        summary.blocks.append(Note(f"The report was stopped. It lacks: {left}.", warning=True))
    again = contents.section("reproduction", "Reproduction", lambda made: _again(path, made))
    options = contents.options
    facts = [("system", repr(contents.system).partition("(")[2][:-1])]
    if options.operating is not None:
        both = [
            " to ".join(dict.fromkeys(speed_text(speed, unit) for speed in options.operating))
            for unit in (options.unit, _other(options.unit))
        ]
        facts.append(("operating speed", f"{both[0]} ({both[1]}), of the reference shaft"))
    if options.speeds is not None:
        ends = " to ".join(contents.text(float(options.speeds[end])) for end in (0, -1))
        facts.append(("speeds of diagrams", ends))
    made = datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    facts.append(("made", f"{made} by gearbow {__version__}"))
    write(path, options.title, facts, [summary, *sections, again])


def _other(unit: SpeedUnit) -> SpeedUnit:
    return "rpm" if unit == "rad/s" else "rad/s"


def _again(path: Path, contents: Contents) -> Iterator[Block]:
    """Say how to make the report again."""
    system, options = contents.system, contents.options
    yield Note(
        f"Made by gearbow {__version__} with Python {platform.python_version()} and NumPy "
        f"{np.__version__} on {platform.platform(terse=True)}, {platform.machine()}."
    )
    arguments = [repr(path.name)]
    if options.operating is not None:
        arguments.append(f"operating=({', '.join(repr(float(x)) for x in options.operating)})")
    if options.speeds is not None:
        arguments.append(f"speeds={np.asarray(options.speeds).tolist()}")
    arguments.append(f"modes={options.modes}")
    if options.limits:
        arguments.append(f"limits={list(options.limits)!r}")
    arguments.append(f"title={options.title!r}")
    lines = [
        "import gearbow as gb",
        "",
        'system = gb.RotorSystem.load("scene.toml")',
        "system.report(",
    ]
    program = "\n".join([*lines, *(f"    {each}," for each in arguments), ")"])
    yield Code("Program (speeds in rad/s)", f"{program}\n", "report.py")
    refuse_functions(torques=system.torques, forces=system.forces)
    yield Code("Scene", system._model.to_toml(), "scene.toml")
