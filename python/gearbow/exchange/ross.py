"""Rotors of ROSS: the plain description of a rotor that ``rotor.save`` wrote.

The axes x, y and z of ROSS, with z along the shaft, are y, z and x here. A shaft element becomes a
segment with one element, and an element around another one a sleeve with its stiffness. An axial
force is positive for tension in both programs, and the sum over the layers. Tables of bearings are
over speed, frequency or both in ROSS 3; what ROSS 2 calls frequency is the speed.

A ``CoAxialRotor`` and a ``MultiRotor`` have several shafts: the next one begins where a node has no
element; a ``CouplingElement`` has such a node on both sides, and joins the two shafts. The file
contains the gears of a ``MultiRotor``, but not which of them mesh, the stiffness of the mesh and
the angle of the line of centres. https://ross.readthedocs.io
"""

import json
import math
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gearbow._files import parsing, reading
from gearbow._types import Array, Plain
from gearbow.description.places import cleaned
from gearbow.errors import SceneError, SceneWarning, warn

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

#: Name of the shaft; several shafts have a number behind it.
SHAFT = "rotor"
#: Values of a shaft element that the elements of gearbow have.
_FIXED = {
    "torque": 0,
    "gyroscopic": True,
    "shear_method_calc": "cowper",
}
#: Properties that all elements of a shaft must share, and those of all shafts.
_OF_SHAFT, _OF_ALL = ("shear_effects",), ("alpha", "beta")
_KINDS = ("ShaftElement", "CouplingElement", "DiskElement", "GearElement", "PointMass")
#: What ROSS takes for a value that a file does not have, by the kind of the element.
_DEFAULTS = {
    "ShaftElement": {"idr": "idl", "odr": "odl"},
    "bearing": {"kyy": "kxx", "cyy": "cxx"},
}
#: What ROSS 2 needs to save a gear.
_SAVE_GEARS = (
    "ROSS 2 cannot save gears in TOML, nor without their base_diameter: set "
    "gear.base_diameter = 2 * gear.base_radius for each GearElement, and save the rotor as .json"
)

#: Young's modulus of a layer, relative to that of the shaft, up to which it stands for mass only.
_MASS_ONLY = 1e-6
#: Version of ROSS from which `speed` is the axis of a table over the speed of the rotor.
_WITH_SPEED = 3
#: Bearings that versions of ROSS save with geometry and oil, from which they compute coefficients;
#: others save the coefficients as a BearingElement.
_OIL_FILMS = (
    *("PlainJournal", "TiltingPad", "SqueezeFilmDamper", "CylindricalBearing", "BearingFluidFlow"),
    *("EllipticalBearing", "OffsetHalvesBearing", "MultiLobeBearing", "PressureDamBearing"),
)
_COEFFICIENTS = (
    "save the rotor with rs.BearingElement(n, kxx=bearing.kxx, ..., frequency=bearing.frequency), "
    "or give gearbow the film: gb.JournalBearing, gb.TiltingPadBearing, gb.SqueezeFilm"
)


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


def read_ross(
    path: str | os.PathLike[str], meshes: Sequence[Mapping[str, Plain]] = ()
) -> dict[str, Plain]:
    """Read a rotor that ROSS saved; the meshes of its gears are not in the file."""
    with parsing(path, "a rotor of ROSS"):
        file = _read(path)
        try:
            return _description(file, meshes)
        except KeyError as error:
            raise SceneError(f"{path}: an element has no {error}") from None
        except (ValueError, TypeError) as error:
            if isinstance(error, SceneError):
                raise
            raise SceneError(f"{path}: an element has a wrong value: {error}") from None


def _description(file: _File, meshes: Sequence[Mapping[str, Plain]]) -> dict[str, Plain]:
    shafts, sleeves, places = _shafts(file)
    masses = {mass["n"]: (name, mass) for name, mass in file.all("PointMass")}
    description: dict[str, Any] = {"shafts": shafts, "sleeves": sleeves, "disks": []}
    description["gears"] = _gears(file, places, meshes)
    description["bearings"], description["meshes"] = [], list(meshes)
    _, first = file.all("ShaftElement")[0]
    if first.get("alpha") or first.get("beta"):
        description["rayleigh"] = [first.get("alpha", 0.0), first.get("beta", 0.0)]
    description["couplings"] = []
    for name, coupling in file.all("CouplingElement"):
        joint, halves = _coupling(file, name, coupling, places)
        description["couplings"].append(joint)
        description["disks"] += halves
    for name, disk in file.all("DiskElement"):
        inertias = {"diametral_inertia": disk["Id"], "polar_inertia": disk["Ip"]}
        at = _place(file, name, disk["n"], places)
        description["disks"].append({**_named(name, disk), **at, "mass": disk["m"], **inertias})
    for n, (name, mass) in masses.items():
        if n in places:
            inertias = {"diametral_inertia": 0.0, "polar_inertia": 0.0}
            at = _place(file, name, n, places)
            body = {**_named(name, mass), **at, "mass": _mass(file, name, mass), **inertias}
            description["disks"].append(body)
    bearings = file.all("bearing")
    grounded = {one["n"]: (name, one) for name, one in bearings if one["n"] not in places}
    linked = {one.get("n_link") for _, one in bearings}
    for n, (name, _) in {**grounded, **masses}.items():
        if n not in places and n not in linked:
            raise file.error(name, f"node {n} is not on the shaft, and no bearing links it")
    supports: dict[int, dict[str, Plain]] = {}
    for name, bearing in bearings:
        if bearing["n"] in places:
            found = {**places[bearing["n"]], **_coefficients(file, name, bearing)}
            link = bearing.get("n_link")
            if link in places:
                found["support"] = _other_shaft(file, name, places[link], found)
            elif link is not None:
                support = _support(file, name, link, masses, grounded)
                found["support"] = supports.setdefault(link, support)["name"]
            description["bearings"].append(found)
    description["supports"] = list(supports.values())
    _check_connections(file, description)
    return {key: value for key, value in description.items() if value}


def _coupling(
    file: _File, name: str, coupling: Mapping[str, Any], places: Mapping[int, dict[str, Plain]]
) -> tuple[dict[str, Plain], list[dict[str, Plain]]]:
    """Give the springs and dampers of a coupling, and its halves as disks."""
    joint: dict[str, Plain] = {}
    disks = []
    for side, key, n in (("l", "a", coupling["n"]), ("r", "b", coupling["n"] + 1)):
        at = _place(file, name, n, places)
        joint[key] = [at["shaft"], at["position"]]
        polar = coupling[f"Ip_{side}"]
        inertias = {"diametral_inertia": coupling.get(f"Id_{side}") or polar / 2.0}
        body = {"mass": coupling[f"m_{side}"], **inertias, "polar_inertia": polar}
        label = f"{_named(name, coupling)['name']} {'left' if side == 'l' else 'right'}"
        disks.append({"name": label, **at, **body})
    for letter, what in (("k", "stiffness"), ("c", "damping")):
        for motion, across, along in (("t", "lateral", "axial"), ("r", "tilting", "torsional")):
            x, y, z = (float(coupling.get(f"{letter}{motion}_{axis}") or 0.0) for axis in "xyz")
            if x != y:
                text = f"{letter}{motion}_x and {letter}{motion}_y must be equal, got {x:g}, {y:g}"
                raise file.error(name, text)
            joint |= {f"{across}_{what}": x, f"{along}_{what}": z}
    return joint, disks


def _gears(
    file: _File, places: Mapping[int, dict[str, Plain]], meshes: Sequence[Mapping[str, Plain]]
) -> list[dict[str, Plain]]:
    """Give the gears; the driver of a mesh has the helix angle of the mesh, as in ROSS."""
    given = file.all("GearElement")
    found = {_named(name, gear)["name"]: _gear(file, name, gear, places) for name, gear in given}
    for i, mesh in enumerate(meshes):
        for key in ("driver", "driven"):
            if mesh[key] not in found:
                names = ", ".join(f'"{name}"' for name in found) or "none"
                text = f'{file.path} has no gear "{mesh[key]}"; its gears: {names}'
                raise SceneError(f"meshes[{i}].{key}: {text}")
        if "helix_angle" in found[mesh["driver"]]:
            found[mesh["driven"]]["helix_angle"] = -found[mesh["driver"]]["helix_angle"]
    return list(found.values())


def _gear(
    file: _File, name: str, gear: Mapping[str, Any], places: Mapping[int, dict[str, Plain]]
) -> dict[str, Any]:
    """Give a gear; a ``GearElementTVMS`` has sizes in place of mass and moments of inertia."""
    place = _place(file, name, gear["n"], places)
    angle, helix = gear["pr_angle"], gear.get("helix_angle") or 0.0
    pitch = gear.get("pitch_diameter")
    if pitch is None:
        pitch = gear["module"] * gear["n_teeth"]
    # The pressure angle is that of the normal section.
    transverse = math.atan(math.tan(angle) / math.cos(helix))
    found = {**_named(name, gear), **place, "teeth": gear["n_teeth"], "pressure_angle": angle}
    found["base_radius"] = 0.5 * pitch * math.cos(transverse)
    if helix:
        found["helix_angle"] = helix
    if "m" in gear:
        inertias = {"diametral_inertia": gear["Id"], "polar_inertia": gear["Ip"]}
        return {**found, "mass": gear["m"], **inertias}
    width, bore, density = gear["width"], gear["bore_diameter"], _density(file, name, gear)
    mass = density * math.pi * width * (pitch**2 - bore**2) / 4.0
    polar = mass * (pitch**2 + bore**2) / 8.0
    inertias = {"diametral_inertia": polar / 2.0 + mass * width**2 / 12.0, "polar_inertia": polar}
    return {**found, "face_width": width, "mass": mass, **inertias}


def _density(file: _File, name: str, gear: Mapping[str, Any]) -> float:
    """Give the density of a gear [kg/m³]: that of the shaft below it, as ROSS writes none."""
    if isinstance(gear.get("material"), dict):
        return float(gear["material"]["rho"])
    before = [one for _, one in file.all("ShaftElement") if one["n"] <= gear["n"]]
    density = max(before, key=lambda one: int(one["n"]))["material"]["rho"]
    warn(
        f"{file.path}: {name}: the file does not contain the material of the gear; its mass is "
        f"that with the density of its shaft, {density:g} kg/m³",
        SceneWarning,
    )
    return float(density)


def _other_shaft(
    file: _File, name: str, place: Mapping[str, Plain], bearing: Mapping[str, Any]
) -> list[Plain]:
    """Give the place on the other shaft of a bearing between two shafts."""
    tables = [bearing[key] for key in ("stiffness", "damping") if isinstance(bearing[key], dict)]
    if any("speeds" in table for table in tables):
        text = "a bearing between shafts must not depend on the speed; its table is over"
        raise file.error(
            name, f"{text} the speed of the rotor in ROSS, the relative one in gearbow"
        )
    return [place["shaft"], place["position"]]


def _check_connections(file: _File, description: Mapping[str, Any]) -> None:
    """Require a connection of each shaft if there are several; without meshes, all turn alike."""
    shafts, gears = description["shafts"], description["gears"]
    if len(shafts) == 1:
        return
    if not description["bearings"]:
        raise SceneError(f"{file.path}: has {len(shafts)} shafts and no bearing. {_SAVE_GEARS}")
    if gears and not description["meshes"]:
        names = ", ".join(f'"{gear["name"]}" on "{gear["shaft"]}"' for gear in gears)
        raise SceneError(
            f"{file.path}: ROSS does not save which of its gears mesh ({names}); give them with "
            "the gear_mesh_stiffness and orientation_angle of the MultiRotor: "
            "meshes=[gb.Mesh(driver, driven, stiffness=..., centre_line_angle=...)], and gearbow "
            "import the options --mesh and --centre-line-angle"
        )
    between = [one for one in description["bearings"] if isinstance(one.get("support"), list)]
    meshing = {mesh[key] for mesh in description["meshes"] for key in ("driver", "driven")}
    connected = {one["shaft"] for one in between} | {one["support"][0] for one in between}
    geared = {gear["shaft"] for gear in gears if gear["name"] in meshing}
    coupled = {one[key][0] for one in description["couplings"] for key in ("a", "b")}
    connected |= geared | coupled
    for shaft in shafts:
        if shaft["name"] not in connected:
            raise SceneError(
                f"{file.path}: no bearing between shafts, mesh or coupling connects "
                f'"{shaft["name"]}"; '
                "a shaft ends at a node without a ShaftElement"
            )
        if meshing and shaft["name"] not in geared | coupled:
            raise SceneError(
                f'{file.path}: no mesh gives the speed of "{shaft["name"]}", which a bearing '
                "connects to another shaft; gearbow reads coaxial shafts or geared ones, not both "
                "in one file"
            )
    if not description["meshes"]:
        driven = {one["b"][0] for one in description["couplings"]}  # by the shaft before it
        for shaft in shafts[1:]:
            if shaft["name"] not in driven:
                shaft["speed_ratio"] = 1.0


def _read(path: str | os.PathLike[str]) -> _File:
    with reading(path, "a rotor of ROSS") as text:
        is_json = Path(path).suffix.lower() == ".json" or text.lstrip().startswith("{")
        try:
            plain = json.loads(text) if is_json else tomllib.loads(text)
        except ValueError as error:  # of both formats
            cause = f". {_SAVE_GEARS}" if '["GearElement' in text else ""
            raise SceneError(f"{path}: not a rotor of ROSS: {error}{cause}") from None
    if not isinstance(plain, dict) or not any(key.startswith(_KINDS) for key in plain):
        raise SceneError(f"{path}: not a rotor of ROSS: it has no ShaftElement")
    # Programs before ROSS 2 write no version.
    major = str(plain.get("ross_version", 1)).partition(".")[0]
    file = _File(str(path), int(major) if major.isdecimal() else 2)
    for key, element in plain.items():
        if not isinstance(element, dict) or key == "parameters" or key.startswith("_"):
            continue
        kind, _, name = key.partition("_")
        kind = next((known for known in _KINDS if kind.startswith(known)), kind)
        if kind not in _KINDS:
            if "kxx" not in element:
                remedy = f"; {_COEFFICIENTS}" if kind in _OIL_FILMS else ""
                raise file.error(name, f"gearbow cannot represent a {kind}{remedy}")
            kind = "bearing"
        file.elements.setdefault(kind, []).append((name, _complete(kind, element)))
    if not file.all("ShaftElement"):
        raise SceneError(f"{path}: has no ShaftElement")
    return file


def _complete(kind: str, element: dict[str, Any]) -> dict[str, Any]:
    """Add the values that ROSS takes from others where a file has none."""
    found = dict(element)
    for key, other in _DEFAULTS.get(kind, {}).items():
        if found.get(key) is None:
            found[key] = found.get(other)
    return found


def _shafts(
    file: _File,
) -> tuple[list[dict[str, Any]], list[dict[str, Plain]], dict[int, dict[str, Plain]]]:
    """Give the shafts, their sleeves, and the place of each node on them."""
    layers: dict[int, list[tuple[str, dict[str, Any]]]] = {}
    for name, element in file.all("ShaftElement"):
        layers.setdefault(int(element["n"]), []).append((name, element))
    # A shaft ends at a node at which no element begins.
    begins = [n for n in sorted(layers) if n - 1 not in layers]
    _, first = layers[begins[0]][0]
    shafts, sleeves = [], []
    places: dict[int, dict[str, Plain]] = {}
    for number, begin in enumerate(begins, start=1):
        name = SHAFT if len(begins) == 1 else f"{SHAFT} {number}"
        shaft, around, positions = _shaft(file, name, begin, layers, first)
        shafts.append(shaft)
        sleeves += around
        for n, position in enumerate(positions, start=begin):
            places[n] = {"shaft": name, "position": position}
    if any(not one.get("rotary_inertia", True) for _, one in file.all("ShaftElement")):
        warn(
            f"{file.path}: rotary_inertia is false for some elements of the shaft; gearbow "
            "includes the rotary inertia of all, which lowers frequencies of short shafts",
            SceneWarning,
        )
    return shafts, sleeves, places


def _shaft(
    file: _File,
    shaft: str,
    begin_node: int,
    layers: Mapping[int, list[tuple[str, dict[str, Any]]]],
    first_of_all: Mapping[str, Any],
) -> tuple[dict[str, Any], list[dict[str, Plain]], list[float]]:
    """Give the shaft that begins at a node, its sleeves, and the position of each node [m]."""
    _, first = layers[begin_node][0]
    positions, segments, sleeves = [0.0], [], []
    n, axial_force = begin_node, _axial_force(layers[begin_node])
    while n in layers:
        # The layers from the inside to the outside: the shaft, and what is around it.
        (_, element), *around = sorted(layers[n], key=lambda one: float(one[1]["odl"]))
        for each, values in layers[n]:
            _check_element(file, each, values, first, first_of_all)
        if _axial_force(layers[n]) != axial_force:
            text = (
                f"axial_force must be that of the other elements of the shaft, {axial_force:g} N, "
                f"got {_axial_force(layers[n]):g} N. Set it to 0 in all elements, and then use "
                "system.replace(geometric_stiffness=True) with gb.Force(axial=) where the force "
                "changes and axial_stiffness of a bearing"
            )
            raise file.error(layers[n][0][0], text)
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
            sleeves.append({"shaft": shaft, **sleeve, "stiffness": "full" if carries else "none"})
        positions.append(end)
        n += 1
    shear = bool(first.get("shear_effects", True))
    described = {"name": shaft, "segments": segments, "material": _material(first), "shear": shear}
    if axial_force:
        described["axial_force"] = axial_force
        if first.get("beta"):
            warn(
                f"{file.path}: beta of ROSS includes the stiffness of the axial force, that of "
                "gearbow does not; tension damps modes more in ROSS, and compression less",
                SceneWarning,
            )
    return described, sleeves, positions


def _axial_force(layers: Sequence[tuple[str, Mapping[str, Any]]]) -> float:
    """Give the tension [N] of a shaft between two nodes, the sum over its layers."""
    return math.fsum(float(values.get("axial_force") or 0.0) for _, values in layers)


def _check_element(
    file: _File,
    name: str,
    element: Mapping[str, Any],
    first: Mapping[str, Any],
    first_of_all: Mapping[str, Any],
) -> None:
    """Refuse what elements of gearbow do not have."""
    for key, value in _FIXED.items():
        if element.get(key, value) != value:
            raise file.error(name, f"{key} must be {value}, got {element[key]}")
    for key in _OF_SHAFT:
        if element.get(key) != first.get(key):
            raise file.error(name, f"{key} must be that of the other elements of the shaft")
    for key in _OF_ALL:
        if element.get(key) != first_of_all.get(key):
            raise file.error(name, f"{key} must be that of all other elements")


def _material(element: Mapping[str, Any]) -> dict[str, Plain]:
    given = element["material"]
    return {
        "youngs_modulus": given["E"],
        "density": given["rho"],
        "shear_modulus": given["G_s"],
    }


def _place(
    file: _File, name: str, n: int, places: Mapping[int, dict[str, Plain]]
) -> dict[str, Plain]:
    if n not in places:
        raise file.error(name, f"node {n} is not on the shaft")
    return places[n]


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
