"""Scene files: TOML, with numbers in SI units or texts with units."""

import os
import sys
from pathlib import Path

from gearbow._convert import copied
from gearbow._core import Model
from gearbow.errors import SceneError
from gearbow.units.convert import without_texts

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["read_scene"]


def read_scene(path: str | os.PathLike[str]) -> Model:
    """Read a scene file.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    Model
        The checked system.

    Raises
    ------
    SceneError
        If the description is invalid, or the file is not TOML.
    OSError
        If the file cannot be opened.
    """
    try:
        document = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise SceneError(
            f"toml: {path} is not UTF-8 text (byte {error.object[error.start]:#04x} at "
            f"position {error.start}); save it as UTF-8"
        ) from None
    try:
        plain = tomllib.loads(document)
    except tomllib.TOMLDecodeError:
        return Model.from_toml(document)  # which describes the error
    converted = without_texts(plain)
    # Without units, the errors of the core name the line.
    return Model.from_toml(document) if converted == plain else Model(copied(converted, ""))
