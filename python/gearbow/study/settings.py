"""What a study is made of: one TOML file with a scene and a table of what to vary in it."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from gearbow._types import Plain
from gearbow.errors import SceneError
from gearbow.system import RotorSystem
from gearbow.system.accuracy import ACCURACIES

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["SCENE", "Settings"]

#: The file that comes with the package.
SCENE = Path(__file__).with_name("scene.toml")


@dataclass(frozen=True)
class Settings:
    """A scene, and what a study varies in it.

    Parameters
    ----------
    scene : mapping
        Description of the system, as `RotorSystem.description` gives it: straight shafts.
    bows : tuple of float
        Amplitudes of half-sine bows over the radius of the shaft; 0 is among them.
    torques : tuple of float
        Values of the first torque [N m].
    speeds : tuple of float
        Speeds of the reference shaft [rad/s].
    settle : int
        Turns of the slowest shaft before the one that is recorded.
    samples : int
        Recorded times in that turn.
    accuracy : str
        Accuracy of every run, as `RotorSystem.simulate` takes it.
    phase_steps : int
        How many phases of the middle and of the last shaft, over a whole turn.
    phase_bow : float
        The bow of the runs over the phases; one of `bows`.
    modes : int
        How many modes the table at rest has.
    backlash : float
        Backlash of a pair that the bow may use up [m].
    layouts : mapping of {str: mapping of {str: float}}
        Positions of the gears [m] by the name of the layout.

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
        """Read a study from a TOML file.

        Parameters
        ----------
        path : path-like
            A scene with a table ``study``; the one of the package by default.

        Returns
        -------
        Settings
            The study.

        Raises
        ------
        SceneError
            If the file is no such study; the text begins with where it is.
        """
        try:
            text = tomllib.loads(Path(path).read_text(encoding="utf-8"))
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
        """Give a small part of the study, for a first look.

        Returns
        -------
        Settings
            The same scene with the straight shafts, `phase_bow`, the last torque, one speed, two
            phases and an accuracy that is enough for a drawing.
        """
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
                    f"study.{name}: must be a whole number from {least}, got {value!r}"
                )
        if 0.0 not in self.bows or min(self.bows) < 0.0:
            raise SceneError(f"study.bows: must hold 0 and nothing below, got {self.bows}")
        if self.phase_bow not in self.bows or self.phase_bow == 0.0:
            raise SceneError(f"study.phase_bow: must be one of bows, got {self.phase_bow!r}")
        if min(self.speeds) <= 0.0:
            raise SceneError(f"study.speeds: must be positive, got {self.speeds}")
        if self.accuracy not in ACCURACIES:
            raise SceneError(
                f"study.accuracy: must be one of {', '.join(ACCURACIES)}, got {self.accuracy!r}"
            )
        gears = {gear["name"] for gear in self.scene["gears"]}
        if len(self.scene["shafts"]) != 3 or len(self.scene["meshes"]) != 2:
            raise SceneError("study: the scene must have three shafts and two meshes")
        if not self.layouts:
            raise SceneError("study.layouts: must name at least one")
        for name, layout in self.layouts.items():
            if set(layout) != gears:
                raise SceneError(f"study.layouts.{name}: must place {', '.join(sorted(gears))}")
        return self
