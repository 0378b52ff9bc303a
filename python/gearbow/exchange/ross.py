"""Rotors of ROSS: the plain description of a rotor that ``rotor.save`` wrote.

The axes x, y and z of ROSS, with z along the shaft, are y, z and x here. A shaft element becomes a
segment with one element, and an element around another one a sleeve with its stiffness. Tables of
bearings are over speed, frequency or both in ROSS 3; what ROSS 2 calls frequency is the speed. https://ross.readthedocs.io
"""

import json
import os
import sys
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gearbow._files import reading
from gearbow._types import Array, Plain
from gearbow.errors import SceneError, SceneWarning, outside
from gearbow.exchange.names import cleaned

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["read_ross"]

#: Name of the shaft.
SHAFT = "rotor"
#: Values of a shaft element that the elements of gearbow have.
_FIXED = {
    "axial_force": 0,
    "torque": 0,
    "gyroscopic": True,
    "shear_method_calc": "cowper",
}
#: Properties that all elements of a shaft must share.
_SHARED = ("shear_effects", "alpha", "beta")
_KINDS = ("ShaftElement", "DiskElement", "PointMass")


#: Young's modulus of a layer, relative to that of the shaft, up to which it stands for mass only.
_MASS_ONLY = 1e-6
#: Version of ROSS from which `speed` is the axis of a table over the speed of the rotor.
_WITH_SPEED = 3


@dataclass
class _File:
    """The elements of a file, by kind."""

    path: str
    #: Major version of ROSS.
    version: int
    elements: dict[str, list[tuple[str, dict[str, Any]]]] = field(default_factory=dict)

    def all(self, kind: str) -> list[tuple[str, dict[str, Any]]]:
        return self.elements.get(kind, [])

    def error(self, name: str, text: str) -> SceneError:
        return SceneError(f"{self.path}: {name}: {text}")


def read_ross(path: str | os.PathLike[str]) -> dict[str, Plain]:
    """Read a rotor that ROSS saved."""
    file = _read(path)
    try:
        return _description(file)
    except SceneError:
        raise
    except KeyError as error:
        raise SceneError(f"{path}: an element has no {error}") from None
    except (ValueError, TypeError) as error:
        raise SceneError(f"{path}: an element has a wrong value: {error}") from None


def _description(file: _File) -> dict[str, Plain]:
    shaft, sleeves, positions = _shaft(file)
    masses = {mass["n"]: (name, mass) for name, mass in file.all("PointMass")}
    description: dict[str, Plain] = {"shafts": [shaft], "sleeves": sleeves, "disks": []}
    description["bearings"] = []
    _, first = file.all("ShaftElement")[0]
    if first.get("alpha") or first.get("beta"):
        description["rayleigh"] = [first.get("alpha", 0.0), first.get("beta", 0.0)]
    for name, disk in file.all("DiskElement"):
        inertias = {"diametral_inertia": disk["Id"], "polar_inertia": disk["Ip"]}
        at = _position(file, name, disk["n"], positions)
        description["disks"].append({**_named(name, disk), **at, "mass": disk["m"], **inertias})
    for n, (name, mass) in masses.items():
        if n < len(positions):
            inertias = {"diametral_inertia": 0.0, "polar_inertia": 0.0}
            at = _position(file, name, n, positions)
            body = {**_named(name, mass), **at, "mass": _mass(file, name, mass), **inertias}
            description["disks"].append(body)
    bearings = file.all("bearing")
    grounded = {one["n"]: (name, one) for name, one in bearings if one["n"] >= len(positions)}
    linked = {one.get("n_link") for _, one in bearings}
    for n, (name, _) in {**grounded, **masses}.items():
        if n >= len(positions) and n not in linked:
            raise file.error(name, f"node {n} is not on the shaft, and no bearing links it")
    for name, bearing in bearings:
        if bearing["n"] < len(positions):
            at = _position(file, name, bearing["n"], positions)
            found = {**at, **_coefficients(file, name, bearing)}
            link = bearing.get("n_link")
            if link is not None:
                found["support"] = _support(file, name, link, masses, grounded)
            description["bearings"].append(found)
    return {key: value for key, value in description.items() if value}


def _read(path: str | os.PathLike[str]) -> _File:
    try:
        with reading(path) as text:
            plain = json.loads(text) if Path(path).suffix == ".json" else tomllib.loads(text)
    except SceneError:
        raise
    except ValueError as error:  # of both formats
        raise SceneError(f"{path}: not a rotor of ROSS: {error}") from None
    if not isinstance(plain, dict) or "ross_version" not in plain:
        raise SceneError(f"{path}: not a rotor of ROSS: it has no ross_version")
    major = str(plain["ross_version"]).partition(".")[0]
    file = _File(str(path), int(major) if major.isdecimal() else 2)
    for key, element in plain.items():
        if not isinstance(element, dict) or key == "parameters":
            continue
        kind, _, name = key.partition("_")
        kind = next((known for known in _KINDS if kind.startswith(known)), kind)
        if kind not in _KINDS:
            if "kxx" not in element:
                raise file.error(name, f"gearbow cannot represent a {kind}")
            kind = "bearing"
        file.elements.setdefault(kind, []).append((name, element))
    if not file.all("ShaftElement"):
        raise SceneError(f"{path}: has no ShaftElement")
    return file


def _shaft(file: _File) -> tuple[dict[str, Plain], list[dict[str, Plain]], list[float]]:
    """Give the shaft, its sleeves, and the position of each node [m]."""
    layers: dict[int, list[tuple[str, dict[str, Any]]]] = {}
    for name, element in file.all("ShaftElement"):
        layers.setdefault(int(element["n"]), []).append((name, element))
    _, first = layers[min(layers)][0]
    positions, segments, sleeves = [0.0], [], []
    for i, (n, found) in enumerate(sorted(layers.items())):
        # The layers from the inside to the outside: the shaft, and what is around it.
        (name, element), *around = sorted(found, key=lambda one: float(one[1]["odl"]))
        if n != i:
            raise file.error(name, f"must begin at node {i}; gearbow reads one shaft without gaps")
        for each, values in found:
            _check_element(file, each, values, first)
        begin, end = positions[-1], positions[-1] + element["L"]
        segment = {"length": element["L"], "outer_diameter": element["odl"], "elements": 1}
        segment |= {"inner_diameter": element["idl"]}
        if element["material"] != first["material"]:
            segment["material"] = _material(element)
        for key, side in (("end_outer_diameter", "od"), ("end_inner_diameter", "id")):
            if element[f"{side}r"] != element[f"{side}l"]:
                segment[key] = element[f"{side}r"]
        segments.append(segment)
        for each, values in around:
            if values["L"] != element["L"]:
                raise file.error(each, f"must be as long as the other layer at node {n}")
            if values["odl"] != values["odr"] or values["idl"] != values["idr"]:
                raise file.error(each, "a conical layer around a shaft; divide it into steps")
            sleeve = {"outer_diameter": values["odl"], "inner_diameter": values["idl"]}
            sleeve |= {"begin": begin, "end": end, "material": _material(values)}
            carries = values["material"]["E"] > _MASS_ONLY * element["material"]["E"]
            sleeves.append({"shaft": SHAFT, **sleeve, "stiffness": "full" if carries else "none"})
        positions.append(end)
    if any(not one.get("rotary_inertia", True) for _, one in file.all("ShaftElement")):
        warnings.warn(
            f"{file.path}: rotary_inertia is false for some elements of the shaft; gearbow "
            "includes the rotary inertia of all, which lowers frequencies of short shafts",
            SceneWarning,
            stacklevel=outside(),
        )
    shear = bool(first.get("shear_effects", True))
    shaft = {"name": SHAFT, "segments": segments, "material": _material(first), "shear": shear}
    return shaft, sleeves, positions


def _check_element(
    file: _File, name: str, element: Mapping[str, Any], first: Mapping[str, Any]
) -> None:
    """Refuse what elements of gearbow do not have."""
    for key, value in _FIXED.items():
        if element.get(key, value) != value:
            raise file.error(name, f"{key} must be {value}, got {element[key]}")
    for key in _SHARED:
        if element.get(key) != first.get(key):
            raise file.error(name, f"{key} must be that of the other elements of the shaft")


def _material(element: Mapping[str, Any]) -> dict[str, Plain]:
    given = element["material"]
    return {
        "youngs_modulus": given["E"],
        "density": given["rho"],
        "shear_modulus": given["G_s"],
    }


def _position(file: _File, name: str, n: int, positions: list[float]) -> dict[str, Plain]:
    if n >= len(positions):
        raise file.error(name, f"node {n} is not on the shaft")
    return {"shaft": SHAFT, "position": positions[n]}


def _named(name: str, element: Mapping[str, Any]) -> dict[str, Plain]:
    return {"name": cleaned(str(element.get("tag") or name))}


def _mass(file: _File, name: str, mass: Mapping[str, Any]) -> float:
    values = {mass.get(key, mass.get("m")) for key in ("mx", "my")}
    if len(values) != 1:
        raise file.error(name, "masses along x and y must be equal")
    return float(values.pop())


def _coefficients(file: _File, name: str, bearing: Mapping[str, Any]) -> dict[str, Plain]:
    """Give stiffness and damping: constant, or tables over speed, frequency or both."""
    for key in ("mxx", "mxy", "myx", "myy", "mzz"):
        if any(_values(bearing.get(key))):
            raise file.error(name, f"gearbow cannot represent {key}, the added mass of a bearing")
    axes = _axes(file, bearing)
    found: dict[str, Plain] = {}
    for letter, key in (("k", "stiffness"), ("c", "damping")):
        entries = [
            _over_axes(file, name, bearing, f"{letter}{entry}", axes)
            for entry in ("xx", "xy", "yx", "yy")
        ]
        table = np.stack(entries, axis=-1).reshape(*entries[0].shape, 2, 2)
        # An axis along which nothing changes is none.
        kept = {
            axis: values
            for i, (axis, values) in enumerate(axes.items())
            if np.any(np.ptp(table, axis=i))
        }
        index = tuple(slice(None) if axis in kept else 0 for axis in axes)
        values = table[index].tolist()
        found[key] = {**kept, "values": values} if kept else values
        axial = _over_axes(file, name, bearing, f"{letter}zz", axes)
        if np.ptp(axial) > 0.0:
            raise file.error(name, f"{letter}zz must be constant")
        if np.any(axial):
            found[f"axial_{key}"] = float(np.ravel(axial)[0])
    return found


def _axes(file: _File, bearing: Mapping[str, Any]) -> dict[str, Plain]:
    """Give the axes of a table [rad/s]. ROSS 2 calls speeds frequency, that of whirl in ROSS 3."""
    keys = {"speeds": "speed", "frequencies": "frequency"}
    if file.version < _WITH_SPEED and bearing.get("speed") is None:
        keys = {"speeds": "frequency"}
    given = {axis: bearing.get(key) for axis, key in keys.items()}
    return {
        axis: [float(each) for each in values]
        for axis, values in given.items()
        if values is not None
    }


def _over_axes(
    file: _File, name: str, bearing: Mapping[str, Any], key: str, axes: Mapping[str, Any]
) -> Array:
    """Give a coefficient over the axes of its table."""
    given, shape = bearing.get(key), tuple(len(values) for values in axes.values())
    values = np.array(0.0 if given is None else given, dtype=float)
    if values.shape == shape:
        return values
    if np.ptp(values) > 0.0:
        wanted = f"the shape {shape} of its {' and '.join(axes)}" if axes else "one value"
        raise file.error(name, f"{key}: must have {wanted}, got {values.shape}")
    return np.full(shape, values.flat[0])


def _values(given: object) -> list[float]:
    """Give all values of a coefficient."""
    return [float(value) for value in np.ravel(np.array(0.0 if given is None else given, float))]


def _support(
    file: _File,
    name: str,
    link: int,
    masses: Mapping[int, tuple[str, dict[str, Any]]],
    grounded: Mapping[int, tuple[str, dict[str, Any]]],
) -> dict[str, Plain]:
    """Give the support of a bearing: the point mass at its node, on the bearing below it."""
    if link not in masses or link not in grounded:
        raise file.error(name, f"its n_link {link} needs a PointMass and a bearing to the ground")
    (mass_name, mass), (ground_name, ground) = masses[link], grounded[link]
    below = _coefficients(file, ground_name, ground)
    if isinstance(below["stiffness"], dict) or isinstance(below["damping"], dict):
        raise file.error(ground_name, "a support has constant stiffness and damping")
    if ground.get("n_link") is not None:
        raise file.error(ground_name, "a support stands on the ground")
    if "axial_damping" in below:
        below.setdefault("axial_stiffness", 0.0)
    return {**_named(mass_name, mass), "mass": _mass(file, mass_name, mass), **below}
