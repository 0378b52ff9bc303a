"""One function for every file that contains a system."""

import inspect
import os
import re
from dataclasses import dataclass
from typing import Any

from gearbow._convert import one_of
from gearbow._files import as_path
from gearbow.errors import SceneError
from gearbow.system.rotor_system import RotorSystem

#: What the tables of a rotor of ROSS are called, in TOML and JSON.
_ROSS = re.compile(
    rb'^\s*\{?\s*(ross_version\s*=|"ross_version"|\["?ShaftElement|"ShaftElement)', re.M
)
#: A key or a table of TOML.
_TOML = re.compile(rb"^\s*(\[|[\w\".-]+\s*=|#)", re.M)
#: Bytes that show the format of a file; keys come early.
_BEGIN = 1 << 20


@dataclass(frozen=True)
class Format:
    """A format of systems, and the method of `RotorSystem` that reads it."""

    name: str
    method: str

    @property
    def options(self) -> list[str]:
        """Arguments of the method beside the path."""
        return list(inspect.signature(getattr(RotorSystem, self.method)).parameters)[1:]


SCENE = Format("scene file", "load")
REXS = Format("REXS file", "read_rexs")
ROSS = Format("rotor of ROSS", "from_ross")


def read(path: str | os.PathLike[str], **options: Any) -> RotorSystem:
    r"""Read a system from any file that contains one, by its contents.

    Parameters
    ----------
    path : str or path-like
        A scene (TOML), a gear unit of REXS (``.rexs``, ``.rexsj``, ``.rexsz``) or a rotor of ROSS.
    **options
        What the file does not contain. REXS: `load_case`, `bearings` and `couplings` of
        `RotorSystem.read_rexs`. ROSS: `meshes` of `RotorSystem.from_ross`.

    Returns
    -------
    RotorSystem
        The system.

    Raises
    ------
    SceneError
        If the file is damaged or of another kind, or cannot use an option.

    Warns
    -----
    SceneWarning
        What gearbow assumes or leaves out, and what is implausible.

    See Also
    --------
    RotorSystem.load : Read a scene file.
    RotorSystem.read_rexs : Read a gear unit of REXS.
    RotorSystem.from_ross : Read a rotor of ROSS.

    Examples
    --------
    >>> from pathlib import Path
    >>> import gearbow as gb
    >>> scene = '[[shafts]]\nname = "rotor"\nlength = "40 in"\nouter_diameter = "2 in"\n'
    >>> written = Path("rotor.toml").write_text(scene)
    >>> gb.read("rotor.toml").shafts[0].length
    1.016
    >>> Path("rotor.toml").unlink()
    """
    found = format_of(path)
    formats = (SCENE, REXS, ROSS)
    for name in options:
        one_of(name, [option for each in formats for option in each.options], "options")
        if name not in found.options:
            (owner,) = (each.name for each in formats if name in each.options)
            raise SceneError(f"{name}: is for a {owner}, but {os.fspath(path)} is a {found.name}")
    system: RotorSystem = getattr(RotorSystem, found.method)(path, **options)
    return system


def format_of(path: str | os.PathLike[str]) -> Format:
    """Tell the format of a file by its contents."""
    found = as_path(path, "path")
    with found.open("rb") as file:
        data = file.read(_BEGIN)
    begin = data.removeprefix(b"\xef\xbb\xbf").lstrip()[:1]
    ending = found.suffix.lower()
    if data.startswith(b"PK") and ending in (".rexsz", ".zip"):
        return REXS
    if _ROSS.search(data):
        return ROSS
    if begin == b"<" or (begin == b"{" and b'"model"' in data) or ending.startswith(".rexs"):
        return REXS
    if begin != b"{" and (ending == ".toml" or (b"\0" not in data and _TOML.search(data))):
        return SCENE
    raise SceneError(
        f"{found}: is no system that gearbow reads: it reads scene files (.toml), gear units of "
        "REXS (.rexs, .rexsj, .rexsz) and rotors of ROSS (.toml, .json)"
    )
