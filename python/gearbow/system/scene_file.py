"""Scene files: TOML, with numbers in SI units or texts with units."""

import os
import re
import sys
from typing import Any, NamedTuple

from gearbow._convert import copied, showing
from gearbow._core import Model
from gearbow._files import reading
from gearbow.errors import SceneError
from gearbow.units.convert import without_texts
from gearbow.units.speed import SpeedUnit, unit_in_texts

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_NUL = re.compile(r"\\(u0000|U00000000)")


class Scene(NamedTuple):
    """A scene file: its model, and the unit of speeds in its texts."""

    model: Model
    speed_unit: SpeedUnit


def read_scene(path: str | os.PathLike[str]) -> Scene:
    """Read a scene file."""
    with reading(path, "a scene file") as document:
        try:
            plain = tomllib.loads(document)
        except tomllib.TOMLDecodeError:
            try:
                return Scene(Model.from_toml(document), "rad/s")  # which describes the error
            except SceneError as error:
                raise _with_remedy(error, document) from None
        converted = without_texts(plain)
        with showing(plain):
            return Scene(_model(document, plain, converted), unit_in_texts(plain))


def _model(document: str, plain: Any, converted: Any) -> Model:
    """Make the system of a document with the `plain` content, `converted` to numbers."""
    # Without units, the errors of the core name the line. Only an escape can give a NUL.
    if converted == plain and not _NUL.search(document):
        return Model.from_toml(document)
    return Model(copied(converted, ""))


def _with_remedy(error: SceneError, document: str) -> SceneError:
    """Say how to write a list of parts, if that is why the document is not TOML."""
    found = re.search(r"at line (\d+)", str(error))
    if found is None or "duplicate key" not in str(error):
        return error
    header = re.fullmatch(
        r"\s*\[\[?\s*(\w+)\s*\]?\]\s*(#.*)?", document.splitlines()[int(found[1]) - 1]
    )
    if header is None:
        return error
    return SceneError(f"{error}; write two brackets around each name of a list: [[{header[1]}]]")
