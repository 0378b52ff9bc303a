"""The machines of the package by name."""

import re
from dataclasses import dataclass
from pathlib import Path

from gearbow._convert import nearest
from gearbow._shown import Shown
from gearbow.errors import SceneError
from gearbow.system.rotor_system import RotorSystem
from gearbow.units.speed import parsed_speed

#: First line of a file: what the machine is. Its line with the rated speed.
_TITLE = re.compile(r"# (.+?)\.?\n")
_SPEED = re.compile(r"^# Rated speed: ([\d.]+ [a-z/]+)", re.MULTILINE)


@dataclass(frozen=True)
class Example(Shown):
    """A machine of the package, made by `gearbow.examples`.

    Parameters
    ----------
    name, title : str
        Name of the machine, and what it is.
    speed : float
        Rated speed of the reference shaft [rad/s].
    path : Path
        Its scene file, which names the sources of the data.

    Examples
    --------
    >>> import gearbow as gb
    >>> machine = gb.examples()["bowed_rotor"]
    >>> machine.path.name, round(machine.speed)
    ('bowed_rotor.toml', 419)
    """

    name: str
    title: str
    speed: float
    path: Path

    def load(self) -> RotorSystem:
        """Read the machine."""
        return RotorSystem.load(self.path)


def examples() -> dict[str, Example]:
    """Give the machines that the package contains, as scene files.

    Returns
    -------
    dict of str to Example
        Trains, gearboxes and rotors with bows by name, from 45 to 2,000 degrees of freedom.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["geared_pair"].load()
    >>> system.speed_ratios.round(2)
    array([  1.  , -14.26])
    """
    return {name: described(path) for name, path in scene_files().items()}


def scene_files() -> dict[str, Path]:
    """Give the scene files of the machines by name."""
    return {path.stem: path for path in sorted(Path(__file__).parent.glob("*.toml"))}


def described(path: Path) -> Example:
    """Give a machine with the title and the rated speed in the header of its file."""
    header = path.read_text(encoding="utf-8")
    title, found = _TITLE.match(header), _SPEED.search(header)
    if title is None or found is None:
        raise SceneError(f"{path}: the header must name the machine and its rated speed")
    return Example(path.stem, title[1], parsed_speed(found[1], "speed"), path)


def example(name: str) -> Example:
    """Find a machine by its name, or by a part of it that no other machine has."""
    known = scene_files()
    matches = [name] if name in known else [each for each in known if name in each]
    if len(matches) != 1:
        few = f"; {name!r} is a part of {', '.join(matches)}" if matches else nearest(name, known)
        raise SceneError(
            f"example: there is no machine {name!r}{few}; there are {', '.join(known)}"
        )
    return described(known[matches[0]])
