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
from gearbow.report.page import Block, Code, Section, note, say, speaking, word, write
from gearbow.report.shared import Contents, Options
from gearbow.units.speed import other_unit, speed_text

#: Sections whose findings come first in the summary; the others follow in their order.
_FIRST = ("resonances", "criticals", "stability", "strength", "life", "motion", "bow", "static")


def compose(system: Any, path: Path, options: Options, progress: bool | Progress | None) -> None:
    """Compute the sections and write the page, after Ctrl-C with the finished sections."""
    contents = Contents(system, options)
    sections: list[Section] = []
    total, look = len(SECTIONS), {"what": "report", "estimate": False, "numbers": ".0f"}
    parts = (each for own in system.description.values() if isinstance(own, list) for each in own)
    names = {str(each["name"]) for each in parts if isinstance(each, dict) and "name" in each}
    with (
        speaking(options.language, names),
        reported(progress, total, "sections", **look) as report,  # type: ignore[arg-type]
    ):
        try:
            for name, title, make in SECTIONS:
                sections.append(contents.section(name, say(title), make))
                if report is not None:
                    report(len(sections) / total)
        except KeyboardInterrupt:
            _write(path, contents, sections)
            raise
        _write(path, contents, sections)


def _write(path: Path, contents: Contents, sections: list[Section]) -> None:
    """Write the page with a summary and the way to repeat it."""
    summary = Section("summary", say("Summary"))
    order = {name: i for i, name in enumerate(_FIRST)}
    found = sorted(contents.findings, key=lambda one: order.get(one[0], len(order)))
    summary.blocks += [block for _, block in found]
    if len(sections) < len(SECTIONS):
        left = ", ".join(say(title) for _, title, _ in SECTIONS[len(sections) :])
        stopped = note("The report was stopped. It lacks: {sections}.", warning=True, sections=left)
        summary.blocks.append(stopped)
    again = contents.section("reproduction", say("Reproduction"), lambda made: _again(path, made))
    options = contents.options
    facts = [(say(name), text) for name, text in options.imprint]
    counts = {
        name: len(parts)
        for name, parts in contents.system.description.items()
        if isinstance(parts, list) and parts and isinstance(parts[0], dict)
    }
    counts["degrees of freedom"] = len(contents.system.dofs)
    facts.append((say("system"), ", ".join(f"{word(key)}: {n}" for key, n in counts.items())))
    if options.operating is not None:
        both = [
            _range([speed_text(speed, unit) for speed in options.operating])
            for unit in (options.unit, other_unit(options.unit))
        ]
        text = say("{speed} ({other}), of the reference shaft", speed=both[0], other=both[1])
        facts.append((say("operating speed"), text))
    if options.speeds is not None:
        ends = _range([contents.text(float(options.speeds[end])) for end in (0, -1)])
        facts.append((say("speeds of diagrams"), ends))
    made = datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    text = say("{time} by gearbow {version}", time=made, version=__version__)
    facts.append((say("made"), text))
    write(path, options.title, facts, [summary, *sections, again])


def _range(texts: list[str]) -> str:
    """Write the ends of a range; equal ones once."""
    return (
        texts[0] if texts[0] == texts[-1] else say("{low} to {high}", low=texts[0], high=texts[-1])
    )


def _again(path: Path, contents: Contents) -> Iterator[Block]:
    """Say how to make the report again."""
    system, options = contents.system, contents.options
    yield note(
        "Made by gearbow {version} with Python {python} and NumPy {numpy} on {platform}.",
        version=__version__,
        python=platform.python_version(),
        numpy=np.__version__,
        platform=f"{platform.platform(terse=True)}, {platform.machine()}",
    )
    arguments = [repr(path.name)]
    if options.operating is not None:
        arguments.append(f"operating=({', '.join(repr(float(x)) for x in options.operating)})")
    if options.speeds is not None:
        arguments.append(f"speeds={np.asarray(options.speeds).tolist()}")
    arguments.append(f"modes={options.modes}")
    if options.limits:
        arguments.append(f"limits={list(options.limits)!r}")
    given = {
        "title": options.title,
        "endurance_limit": options.endurance_limit,
        "tensile_strength": options.tensile_strength,
        "language": options.language,
        **dict(options.imprint),
    }
    default = {"language": "en"}
    arguments += [
        f"{name.replace(' ', '_')}={value!r}"
        for name, value in given.items()
        if value != default.get(name)
    ]
    lines = [
        "import gearbow as gb",
        "",
        'system = gb.RotorSystem.load("scene.toml")',
        "system.report(",
    ]
    program = "\n".join([*lines, *(f"    {each}," for each in arguments), ")"])
    yield Code(say("Program (speeds in rad/s)"), f"{program}\n", "report.py")
    refuse_functions(torques=system.torques, forces=system.forces)
    yield Code(say("Scene"), system._model.to_toml(), "scene.toml")
