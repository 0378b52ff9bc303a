"""Scene files: TOML, with numbers in SI units or texts with units."""

import os
import re
import sys

from gearbow._convert import copied
from gearbow._core import Model
from gearbow._files import reading
from gearbow.units.convert import without_texts

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["read_scene"]

_NUL = re.compile(r"\\(u0000|U00000000)")


def read_scene(path: str | os.PathLike[str]) -> Model:
    """Read a scene file."""
    with reading(path) as document:
        try:
            plain = tomllib.loads(document)
        except tomllib.TOMLDecodeError:
            return Model.from_toml(document)  # which describes the error
        converted = without_texts(plain)
        # Without units, the errors of the core name the line. Only an escape can give a NUL.
        if converted == plain and not _NUL.search(document):
            return Model.from_toml(document)
        return Model(copied(converted, ""))
