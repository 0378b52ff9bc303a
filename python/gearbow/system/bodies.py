"""Elastic bodies of scene files: a file beside the scene has the numbers of each.

The scene names the file and the SHA-256 digest of its bytes. The name of the file has the first
digits of the digest, so that a file is never replaced by other numbers: a scene and its files fit,
whatever happens while another scene is written in its place.
"""

import re
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from gearbow._convert import shown
from gearbow._files import parsing, replacing
from gearbow.description.elastic import OPTIONAL_ROWS, ElasticBody
from gearbow.description.places import Housing
from gearbow.errors import SceneError

#: Beginning of a section of TOML; the core writes lists of numbers on one line.
_SECTION = re.compile(r"(?m)^(?=\[)")
_BODY, _PART_OF_BODY = "[housings.elastic]", "[housings.elastic."
#: Digits of the digest in a name: equal ones of different files would take millions of saves.
_DIGITS = 12
#: Springs of an interface, which may have none.
_SPRINGS = ("stiffness", "damping")


def write_bodies(housings: tuple[Housing, ...], scene: str, path: Path) -> str:
    """Write the elastic bodies of a scene beside its file; give the text that names them."""
    bodies = [housing.elastic for housing in housings if housing.elastic is not None]
    found, number = [], 0
    for section in _SECTION.split(scene):
        if section.startswith(_BODY):
            data = _packed(bodies[number])
            number += 1
            digest = _digest(data)
            file = path.with_suffix(f".housing-{digest.partition(':')[2][:_DIGITS]}.npz")
            with replacing(file) as opened:
                opened.write(data)
            found.append(f'{_BODY}\nfile = "{file.name}"\ndigest = "{digest}"\n\n')
        elif not section.startswith(_PART_OF_BODY):
            found.append(section)
    return "".join(found)


def with_bodies(plain: Any, path: Path) -> Any:
    """Put the numbers of elastic bodies into the plain content of a scene file that names files."""
    housings = plain.get("housings")
    if not isinstance(housings, list):
        return plain
    read = [_with_body(each, f"housings[{i}].elastic", path) for i, each in enumerate(housings)]
    return (
        plain
        if all(a is b for a, b in zip(read, housings, strict=True))
        else {**plain, "housings": read}
    )


def _with_body(housing: Any, where: str, scene: Path) -> Any:
    """Replace the name of a file in a housing by the numbers in it."""
    given = housing.get("elastic") if isinstance(housing, dict) else None
    if not isinstance(given, dict) or "file" not in given:
        return housing
    name, digest = given["file"], given.get("digest")
    for key, value in (("file", name), ("digest", digest)):
        if not isinstance(value, str) or "\0" in value:
            raise SceneError(f"{where}.{key}: must be a text, got {shown(value)}")
    for key in given.keys() - {"file", "digest"}:
        raise SceneError(f"{where}.{key}: is in the file {name}, not in the scene; remove it")
    file = scene.parent / name
    try:
        data = file.read_bytes()
    except OSError as error:
        raise SceneError(
            f"{where}.file: {file} cannot be read: {error.strerror}; a scene needs this file "
            "beside it; copy both, or save the system again"
        ) from None
    found = _digest(data)
    if found != digest:
        raise SceneError(
            f"{where}.digest: {file} has the digest {found}, not {digest}: it is damaged or "
            "belongs to another scene; copy the file of this scene, or save the system again"
        )
    with parsing(file, "an elastic body of gearbow", own=True):
        return {**housing, "elastic": _unpacked(data)._describe(where)}


def _digest(data: bytes) -> str:
    """Give the digest that a scene has of the file of a body."""
    import hashlib  # noqa: PLC0415  # most scenes have no elastic body

    return f"sha256:{hashlib.sha256(data).hexdigest()}"


def _packed(body: ElasticBody) -> bytes:
    """Give the bytes of a file of NumPy with the arrays of a body."""
    own = list(body.interfaces.values())
    arrays: dict[str, Any] = {
        "frequencies": body.frequencies,
        "damping_ratios": body.damping_ratios,
        "names": list(body.interfaces),
        "positions": [each["position"] for each in own],
        "rows": [each["rows"] for each in own],
    }
    for name in _SPRINGS:
        arrays[name] = [each.get(name) or (np.nan,) * 3 for each in own]
    for name in OPTIONAL_ROWS:
        rows = getattr(body, name)
        if rows is not None:
            arrays[name] = rows
    file = BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()


def _unpacked(data: bytes) -> ElasticBody:
    """Read a body from the bytes of its file."""
    loaded = np.load(BytesIO(data), allow_pickle=False)
    arrays = {name: loaded[name].tolist() for name in loaded.files}
    interfaces: dict[str, dict[str, Any]] = {}
    for i, name in enumerate(arrays["names"]):
        interfaces[name] = {"position": arrays["positions"][i], "rows": arrays["rows"][i]}
        springs = {key: arrays[key][i] for key in _SPRINGS}
        interfaces[name] |= {k: value for k, value in springs.items() if not np.isnan(value).any()}
    optional = {name: arrays.get(name) for name in OPTIONAL_ROWS}
    return ElasticBody(arrays["frequencies"], arrays["damping_ratios"], interfaces, **optional)
