"""Files of REXS as components, attributes and relations, and the shafts in them."""

import base64
import binascii
import json
import math
import os
import re
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from gearbow._convert import shown
from gearbow._files import check_name, parsing
from gearbow._types import Array, Plain
from gearbow.errors import SceneError
from gearbow.units.parse import parsed
from gearbow.units.speed import PER_MINUTE

#: Endings of the three formats; the last one is another name of the third.
ENDINGS = (".rexs", ".rexsj", ".rexsz", ".zip")
#: Folder that macOS adds to an archive, with a file of metadata for each file.
_OF_MACOS = "__MACOSX/"
#: Largest file, and largest content of a zip archive [bytes]. Models of gear units have about 1e5.
_MAX_SIZE = 100_000_000
#: Units of REXS that gearbow writes otherwise. "1 / min" is only the unit of speeds.
_UNITS = {
    "": "1",
    "none": "1",
    "mum": "um",
    "1 / min": PER_MINUTE,
    "rad / s": "rad/s",
    "kg / dm^3": "g/cm^3",
    "kW": "kN m",  # of a power, which is divided by a speed
    "W": "N m",
}
#: Largest whole number of teeth or rolling elements.
_LARGEST_COUNT = 1e9
#: Types of the numbers in arrays that are encoded in Base64, little-endian.
_CODES = {"int32": "<i4", "float32": "<f4", "float64": "<f8"}


@dataclass(frozen=True)
class Attribute:
    """The value of an attribute, as the file has it, and its unit."""

    value: object
    unit: str


@dataclass(frozen=True)
class Component:
    """A component of a file, with the attributes of the load case that is read."""

    path: str
    id: int
    kind: str
    name: str
    attributes: Mapping[str, Attribute]

    def __str__(self) -> str:
        return f'{self.kind} "{self.name}"' if self.name else f"{self.kind} {self.id}"

    def error(self, text: str) -> SceneError:
        """Make the error of this component."""
        return SceneError(f"{self.path}: {self}: {text}")

    def has(self, name: str) -> bool:
        """Tell whether an attribute has a value."""
        return name in self.attributes and self.attributes[name].value not in (None, "", [])

    def number(self, name: str, path: str, default: float | None = None) -> float:
        """Give a number in SI units; `path` is a field of gearbow with the same dimension."""
        if not self.has(name):
            if default is None:
                raise self.error(f"needs the attribute {name}")
            return default
        given = self.attributes[name]
        return self._number(given.value, given.unit, name, path)

    def count(self, name: str) -> int:
        """Give a whole number."""
        found = self.number(name, "teeth")
        if found != int(found) or abs(found) > _LARGEST_COUNT:
            raise self.error(f"{name}: must be a whole number of at most 1e9, got {found:g}")
        return int(found)

    def text(self, name: str) -> str:
        """Give a text, which is empty if the attribute is missing."""
        return str(self.attributes[name].value).strip() if self.has(name) else ""

    def flag(self, name: str) -> bool | None:
        """Give a truth value; None if the attribute is missing."""
        if not self.has(name):
            return None
        given = self.attributes[name].value
        if isinstance(given, list):  # of a switchable coupling: one for each gear shift
            given = given[0]
        found = {"true": True, "false": False}.get(str(given).strip().lower())
        if found is None:
            raise self.error(f"{name}: must be true or false, got {shown(given)}")
        return found

    def vector(self, name: str, path: str) -> Array | None:
        """Give a vector of three numbers in SI units; None if the attribute is missing."""
        if not self.has(name):
            return None
        given = self.attributes[name]
        values = given.value if isinstance(given.value, list) else []
        if len(values) != 3:
            raise self.error(f"{name}: must have three numbers, got {shown(given.value)}")
        return np.array([self._number(value, given.unit, name, path) for value in values])

    def _number(self, value: object, unit: str, name: str, path: str) -> float:
        if not isinstance(value, str | int | float) or isinstance(value, bool):
            raise self.error(f"{name}: must be a number, got {shown(value)}")
        text = value.strip() if isinstance(value, str) else shown(value)
        try:
            found = parsed(f"{text} {_UNITS.get(unit.strip(), unit)}", path)
        except SceneError as error:
            raise self.error(f"{name}: {str(error).partition(': ')[2]}") from None
        if not math.isfinite(found):
            raise self.error(f"{name}: must be below 1.8e308 in SI units, got {shown(value)}")
        return found


@dataclass(frozen=True)
class Relation:
    """A relation between components: the component of each role."""

    kind: str
    refs: Mapping[str, Component]


@dataclass(frozen=True)
class RexsFile:
    """The content of a file."""

    path: str
    version: str
    application: str
    components: Mapping[int, Component]
    relations: Sequence[Relation]
    #: Components with the attributes of each load case.
    load_cases: Sequence[Mapping[int, Component]] = field(default_factory=tuple)

    def error(self, text: str) -> SceneError:
        """Make an error of the file."""
        return SceneError(f"{self.path}: {text}")

    def of_kind(self, *kinds: str) -> list[Component]:
        """Give the components of some types."""
        return [each for each in self.components.values() if each.kind in kinds]

    def assembled(self) -> list[tuple[Component, Component]]:
        """Give each part with its whole, by the relations of assemblies."""
        refs = [*self.related("assembly"), *self.related("ordered_assembly")]
        return [(e["part"], e["assembly"]) for e in refs if {"part", "assembly"} <= e.keys()]

    def related(self, kind: str) -> list[Mapping[str, Component]]:
        """Give the components of all relations of a kind."""
        return [relation.refs for relation in self.relations if relation.kind == kind]


def read_rexs_file(path: str | os.PathLike[str]) -> RexsFile:
    """Read a file in one of the three formats."""
    found, ending = check_name(path, ENDINGS)
    data = _read(found)
    if ending in ENDINGS[2:]:
        data, ending = _unzipped(data, found)
    with parsing(found, "a REXS file"):
        plain = _from_json(data) if ending == ".rexsj" else _from_xml(data)
        return _Reader(str(found)).file(plain)


def _read(path: Path) -> bytes:
    with path.open("rb") as file:
        data = file.read(_MAX_SIZE + 1)
    return _limited(data, path)


def _limited(data: bytes, path: Path) -> bytes:
    if len(data) > _MAX_SIZE:
        raise SceneError(f"{path}: has more than {_MAX_SIZE} bytes; no REXS file is that large")
    return data


def _unzipped(data: bytes, path: Path) -> tuple[bytes, str]:
    """Read the only model of a zip archive."""
    with parsing(path, "a zip archive that can be read"), zipfile.ZipFile(BytesIO(data)) as archive:
        names = [
            name
            for name in archive.namelist()
            if name.lower().endswith(ENDINGS[:2]) and not name.startswith(_OF_MACOS)
        ]
        if len(names) != 1:
            raise SceneError(
                f"{path}: must have one file with the ending {ENDINGS[0]} or {ENDINGS[1]}, got "
                f"{shown(archive.namelist())}"
            )
        # The size in the directory of the archive may be wrong.
        with archive.open(names[0]) as file:
            content = file.read(_MAX_SIZE + 1)
    return _limited(content, path), Path(names[0]).suffix.lower()


def _from_json(data: bytes) -> Any:
    plain = json.loads(data.decode("utf-8-sig"))
    if not isinstance(plain, dict) or not isinstance(plain.get("model"), dict):
        raise ValueError("it has no model")
    return plain["model"]


class _WithoutDoctype(ET.TreeBuilder):
    """Refuse a document type before its entities are expanded, which could fill the memory."""

    def doctype(self, *_: str | None) -> None:
        """Refuse the document type."""
        raise ValueError("it has a document type (<!DOCTYPE), which REXS does not have")


def _from_xml(data: bytes) -> Any:
    """Give a model in the form that JSON files have."""
    root = ET.fromstring(data, ET.XMLParser(target=_WithoutDoctype()))
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]  # without the namespace
    if root.tag != "model":
        raise ValueError(f"it begins with <{root.tag}>, not with <model>")
    spectra = [
        {
            "load_cases": [
                dict(case.attrib) | _components(case) for case in spectrum.iter("load_case")
            ]
        }
        for spectrum in root.iter("load_spectrum")
    ]
    relations = [
        dict(relation.attrib) | {"refs": [dict(ref.attrib) for ref in relation.iter("ref")]}
        for relation in root.iterfind("relations/relation")
    ]
    parts = root.find("components")
    plain = dict(root.attrib) | {"relations": relations, "load_spectrum": spectra}
    return plain | (_components(parts) if parts is not None else {})


def _components(parent: ET.Element) -> dict[str, Any]:
    return {
        "components": [
            dict(component.attrib)
            | {"attributes": [_attribute(each) for each in component.iterfind("attribute")]}
            for component in parent.iterfind("component")
        ]
    }


def _attribute(element: ET.Element) -> dict[str, Any]:
    """Give an attribute; matrices and arrays of arrays are not read."""
    array = element.find("array")
    value: Any = (element.text or "").strip()
    if array is not None:
        value = [(cell.text or "").strip() for cell in array.iterfind("c")]
        if "code" in array.attrib:
            value = {"code": array.attrib["code"], "value": (array.text or "").strip()}
    elif len(element) > 0:
        value = None
    return dict(element.attrib) | {"value": value}


class _Reader:
    """Makes a `RexsFile` of plain data, and checks their structure."""

    def __init__(self, path: str) -> None:
        self._path = path

    def file(self, plain: Mapping[str, Any]) -> RexsFile:
        version = str(plain.get("version", ""))
        if not re.fullmatch(r"(1\.[0-9]+|2\.0)(\.[0-9]+)?", version):
            raise self._error(f"version: must be 1.0 to 2.0, got {shown(plain.get('version'))}")
        application = f"{plain.get('applicationId', '')} {plain.get('applicationVersion', '')}"
        components = {}
        for each in self._mappings(plain, "components", "the model"):
            component = self._component(each)
            if component.id in components:
                raise self._error(f"two components have the id {component.id}")
            components[component.id] = component
        if not components:
            raise self._error("has no components")
        relations = [
            self._relation(each, components)
            for each in self._mappings(plain, "relations", "the model")
        ]
        cases = [
            self._load_case(case, components)
            for spectrum in self._mappings(plain, "load_spectrum", "the model")
            for case in self._mappings(spectrum, "load_cases", "a load spectrum")
        ]
        return RexsFile(self._path, version, application.strip(), components, relations, cases)

    def _error(self, text: str) -> SceneError:
        return SceneError(f"{self._path}: {text}")

    def _mappings(self, plain: Mapping[str, Any], key: str, where: str) -> list[dict[str, Any]]:
        """Give a list of mappings; JSON has a single load spectrum without a list."""
        found = plain.get(key)
        listed = [found] if isinstance(found, dict) else [] if found is None else found
        if not isinstance(listed, list) or not all(isinstance(each, dict) for each in listed):
            raise self._error(f"{key} of {where}: must be a list of objects, got {shown(found)}")
        return listed

    def _id(self, plain: Mapping[str, Any], where: str) -> int:
        found = plain.get("id")
        if isinstance(found, bool) or not re.fullmatch(r"[0-9]{1,18}", str(found).strip()):
            raise self._error(f"id of {where}: must be a whole number, got {shown(found)}")
        return int(str(found))

    def _component(self, plain: Mapping[str, Any]) -> Component:
        number = self._id(plain, "a component")
        where = f"component {number}"
        kind = plain.get("type")
        if not isinstance(kind, str) or not kind:
            raise self._error(f"type of {where}: must be a text, got {shown(kind)}")
        name = str(plain.get("name") or "").strip()
        return Component(self._path, number, kind, name, self._attributes(plain, where))

    def _attributes(self, plain: Mapping[str, Any], where: str) -> dict[str, Attribute]:
        found = {}
        for each in self._mappings(plain, "attributes", where):
            # The key of the value is its type, such as "floating_point".
            values = [value for key, value in each.items() if key not in ("id", "unit")]
            name = each.get("id")
            if not isinstance(name, str) or len(values) > 1:
                raise self._error(f"an attribute of {where}: must have an id, a unit and a value")
            value = values[0] if values else None
            if isinstance(value, dict):
                value = self._decoded(value, f"{name} of {where}")
            found[name] = Attribute(value, str(each.get("unit") or ""))
        return found

    def _decoded(self, plain: Mapping[str, Any], where: str) -> list[float] | None:
        """Decode an array of numbers; matrices are not read."""
        if "rows" in plain or plain.get("code") not in _CODES:
            return None
        try:
            data = base64.b64decode(str(plain.get("value")), validate=True)
            return [float(value) for value in np.frombuffer(data, _CODES[plain["code"]])]
        except (binascii.Error, ValueError) as error:
            raise self._error(f"{where}: is no array in Base64: {error}") from None

    def _relation(self, plain: Mapping[str, Any], components: Mapping[int, Component]) -> Relation:
        where = f"relation {shown(plain.get('id'))}"
        refs = {}
        for each in self._mappings(plain, "refs", where):
            number = self._id(each, f"a reference in {where}")
            if number not in components:
                raise self._error(f"{where}: there is no component {number}")
            refs[str(each.get("role"))] = components[number]
        return Relation(str(plain.get("type")), refs)

    def _load_case(
        self, plain: Mapping[str, Any], components: Mapping[int, Component]
    ) -> dict[int, Component]:
        found = dict(components)
        for each in self._mappings(plain, "components", "a load case"):
            number = self._id(each, "a component of a load case")
            if number not in components:
                raise self._error(f"a load case: there is no component {number}")
            base = components[number]
            given = self._attributes(each, f"component {number} in a load case")
            found[number] = Component(
                base.path, number, base.kind, base.name, {**base.attributes, **given}
            )
        return found


#: Largest difference of positions that counts as rounding of the file [m].
_ROUNDING = 1e-6
#: Most components that refer to the position of the next one; a gear unit has two or three.
_MAX_REFERENCES = 100
#: Largest sine of the angle between parallel shafts.
_MAX_SINE = 1e-6


@dataclass(frozen=True)
class Frame:
    """Origin [m] and axes u, v, w (rows) of a component in the coordinates of the gear unit."""

    origin: Array
    axes: Array


@dataclass(frozen=True)
class PlacedShaft:
    """A shaft and its place in the train."""

    component: Component
    name: str
    #: Sections in the order along +x, with the u coordinates of their ends [m].
    sections: tuple[tuple[Component, float, float], ...]
    frame: Frame | None
    #: Whether u points along +x, 1.0, or along −x, −1.0.
    sense: float
    #: Where its axis crosses the plane y, z of the reference shaft [m].
    axis: Array | None

    def position(self, u: float) -> float:
        """Give the position from the left end [m]."""
        begin = self.sections[0][1] if self.sense > 0.0 else self.sections[0][2]
        found = self.sense * (u - begin)
        return 0.0 if abs(found) < _ROUNDING else found


class Shafts:
    """The shafts of a file, and the frames of its components."""

    def __init__(self, file: RexsFile, reference: Component, notes: list[str]) -> None:
        self._file = file
        self._notes = notes
        self.reference = self.frame(reference) or Frame(np.zeros(3), np.eye(3))

    def frame(self, component: Component, below: tuple[int, ...] = ()) -> Frame | None:
        """Find the frame of a component; None if the file does not place it."""
        origin = component.vector("support_vector", "length")
        if origin is None:
            return None
        u = self._unit(component, "u_axis_vector", (1.0, 0.0, 0.0))
        w = self._unit(component, "w_axis_vector", (0.0, 0.0, 1.0))
        if abs(u @ w) > _MAX_SINE:
            raise component.error("u_axis_vector and w_axis_vector must be at right angles")
        axes = np.array([u, np.cross(w, u), w])
        base = None
        if component.has("reference_component_for_position"):
            number = component.count("reference_component_for_position")
            if number in below or len(below) > _MAX_REFERENCES:
                raise component.error("reference_component_for_position: refers back to itself")
            if number != component.id:
                if number not in self._file.components:
                    raise component.error(
                        f"reference_component_for_position: there is no component {number}"
                    )
                base = self.frame(self._file.components[number], (*below, component.id))
        if base is None:
            return Frame(origin, axes)
        return Frame(base.origin + base.axes.T @ origin, axes @ base.axes)

    def _unit(self, component: Component, name: str, default: tuple[float, ...]) -> Array:
        found = component.vector(name, "length")
        found = np.array(default) if found is None else found
        length = math.hypot(*found.tolist())
        if not 0.0 < length < math.inf:
            raise component.error(f"{name}: must have a length above 0")
        return found / length

    def place(self, component: Component, name: str, sections: Iterable[Component]) -> PlacedShaft:
        """Find the place of a shaft, and order its sections."""
        ordered = self._sections(component, sections)
        frame = self.frame(component)
        if frame is None:
            return PlacedShaft(component, name, ordered, None, 1.0, None)
        axes = frame.axes @ self.reference.axes.T
        sense = math.copysign(1.0, axes[0, 0])
        if math.hypot(axes[0, 1], axes[0, 2]) > _MAX_SINE:
            raise component.error("must be parallel to the other shafts; see its u_axis_vector")
        axis = (self.reference.axes @ (frame.origin - self.reference.origin))[1:]
        if sense < 0.0:
            ordered = ordered[::-1]
        return PlacedShaft(component, name, ordered, frame, sense, axis)

    def _sections(
        self, shaft: Component, sections: Iterable[Component]
    ) -> tuple[tuple[Component, float, float], ...]:
        found = []
        for section in sections:
            begin = section.number("u_coordinate_on_shaft", "position")
            found.append((section, begin, begin + section.number("length", "length")))
        found.sort(key=lambda each: each[1])
        if not found:
            raise shaft.error("has no shaft_section")
        for (before, _, end), (section, begin, _) in pairwise(found):
            if abs(begin - end) > _ROUNDING:
                raise shaft.error(
                    f"{section} begins at {1e3 * begin:g} mm, but {before} before it ends at "
                    f"{1e3 * end:g} mm; sections must join, without gaps and layers"
                )
        return tuple(found)

    def locate(self, component: Component, shaft: PlacedShaft, name: str) -> float:
        """Find the position of a component on a shaft [m]; `name` is its coordinate in the file."""
        # The coordinate of a gear is its middle or its begin: files differ, and its
        # support_vector, which is its middle, decides.
        frame = self.frame(component)
        given = component.number(name, "position") if component.has(name) else None
        if frame is None or shaft.frame is None:
            if given is None:
                raise component.error(f"needs the attribute {name}")
            if component.has("face_width"):
                self._notes.append(
                    f"{name} of gears without support_vector counts as the middle of the face width"
                )
            return shaft.position(given)
        u = float(shaft.frame.axes[0] @ (frame.origin - shaft.frame.origin))
        candidates = [] if given is None else [given]
        if given is not None and component.has("face_width"):
            candidates.append(given + 0.5 * component.number("face_width", "face_width"))
        for each in candidates:
            if abs(each - u) < _ROUNDING:
                return shaft.position(each)
        if given is not None:
            self._notes.append(
                f"{component}: its support_vector is at {1e3 * u:g} mm on the shaft, which is "
                f"used; {name} is {1e3 * given:g} mm"
            )
        return shaft.position(u)

    def across(self, component: Component, shaft: PlacedShaft, names: tuple[str, str]) -> complex:
        """Give a vector across the shaft as y + iz, in N; absent parts are zero."""
        v, w = (component.number(name, "load", 0.0) for name in names)
        if shaft.frame is None:
            return complex(v, w)
        axes = shaft.frame.axes @ self.reference.axes.T
        y, z = v * axes[1, 1:] + w * axes[2, 1:]
        return complex(y, z)


def segment(section: Component, sense: float) -> dict[str, Plain]:
    """Give a segment with the diameters of a section, from its left to its right end."""
    found: dict[str, Plain] = {"length": section.number("length", "length")}
    for side, default in (("outer_diameter", None), ("inner_diameter", 0.0)):
        left, right = (section.number(f"{side}_{end}", side, default) for end in ("begin", "end"))
        if sense < 0.0:
            left, right = right, left
        if left != 0.0:
            found[side] = left
        if abs(left - right) > _ROUNDING:
            found[f"end_{side}"] = right
    return found
