"""Settings of the bow study: a TOML file with a scene and the values that the study varies."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from gearbow._files import reading
from gearbow._types import Plain
from gearbow.accuracy.levels import LEVELS
from gearbow.errors import SceneError
from gearbow.system import RotorSystem

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["SCENE", "Settings"]

#: Scene and settings of docs/study.md.
SCENE = Path(__file__).with_name("scene.toml")


@dataclass(frozen=True)
class Settings:
    """A scene and the values that the study varies.

    Parameters
    ----------
    scene : mapping
        System with straight shafts, in the form of `RotorSystem.description`.
    bows : tuple of float
        Amplitudes of the half-sine bows, divided by the shaft radius; they contain 0.
    torques : tuple of float
        Values of the first torque of the scene [N m].
    speeds : tuple of float
        Speeds of the reference shaft [rad/s].
    settle : int
        Revolutions of the slowest shaft before the recorded one.
    samples : int
        Number of output times in the recorded revolution.
    accuracy : str
        Accuracy of every run, as `RotorSystem.simulate` takes it.
    phase_steps : int
        Number of bow phases of the second and of the third shaft, over one revolution.
    phase_bow : float
        Bow of the phase grid, divided by the shaft radius; one of `bows`, not 0.
    modes : int
        Number of modes in the table of modes at rest.
    backlash : float
        Backlash of each mesh [m], for the table of limits only.
    layouts : mapping of {str: mapping of {str: float}}
        Position of each gear [m], by the name of the layout.

    Examples
    --------
    >>> from gearbow.study import Settings
    >>> settings = Settings.load()
    >>> settings.bows
    (0.0, 0.01, 0.025, 0.05, 0.075, 0.1)
    """

    scene: Mapping[str, Plain]
    bows: tuple[float, ...]
    torques: tuple[float, ...]
    speeds: tuple[float, ...]
    settle: int
    samples: int
    accuracy: str
    phase_steps: int
    phase_bow: float
    modes: int
    backlash: float
    layouts: Mapping[str, Mapping[str, float]]

    @classmethod
    def load(cls, path: Path = SCENE) -> "Settings":
        """Read the settings from a TOML file."""
        try:
            with reading(path) as document:
                text = tomllib.loads(document)
        except tomllib.TOMLDecodeError as error:
            raise SceneError(f"{path}: not TOML, {error}") from None
        table = text.pop("study", None)
        if not isinstance(table, dict):
            raise SceneError("study: this table is missing")
        known = {field.name for field in fields(cls)} - {"scene"}
        for name in sorted(known.symmetric_difference(table)):
            raise SceneError(f"study.{name}: {'is missing' if name in known else 'unknown key'}")
        given: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in table.items()
        }
        scene = RotorSystem._from_description(text).description
        return cls(scene=scene, **given)._checked()

    def quick(self) -> "Settings":
        """Return a small part of the study."""
        return replace(
            self,
            bows=(0.0, self.phase_bow),
            torques=self.torques[-1:],
            speeds=(self.speeds[len(self.speeds) // 2],),
            phase_steps=2,
            accuracy="draft",
        )

    def _checked(self) -> "Settings":
        for name in ("bows", "torques", "speeds"):
            values = getattr(self, name)
            if not isinstance(values, tuple) or not values or len(set(values)) < len(values):
                raise SceneError(f"study.{name}: must be distinct numbers, got {values!r}")
        for name, least in (("settle", 0), ("samples", 16), ("phase_steps", 1), ("modes", 1)):
            value = getattr(self, name)
            if not isinstance(value, int) or value < least:
                raise SceneError(
                    f"study.{name}: must be a whole number of at least {least}, got {value!r}"
                )
        if 0.0 not in self.bows or min(self.bows) < 0.0:
            raise SceneError(f"study.bows: must contain 0 and no negative value, got {self.bows}")
        if self.phase_bow not in self.bows or self.phase_bow == 0.0:
            raise SceneError(
                f"study.phase_bow: must be one of bows, and not 0, got {self.phase_bow!r}"
            )
        if min(self.speeds) <= 0.0:
            raise SceneError(f"study.speeds: must be positive, got {self.speeds}")
        if self.accuracy not in LEVELS:
            raise SceneError(
                f"study.accuracy: must be one of {', '.join(LEVELS)}, got {self.accuracy!r}"
            )
        gears = {gear["name"] for gear in self.scene["gears"]}
        if len(self.scene["shafts"]) != 3 or len(self.scene["meshes"]) != 2:
            raise SceneError("study: the scene must have three shafts and two meshes")
        if not self.layouts:
            raise SceneError("study.layouts: must contain at least one layout")
        for name, layout in self.layouts.items():
            if set(layout) != gears:
                raise SceneError(f"study.layouts.{name}: must place {', '.join(sorted(gears))}")
        return self
