"""Files of REXS as plain components and relations: XML, JSON, or one of both in a zip archive.

REXS is the Reusable Engineering EXchange Standard of FVA for gear units, https://www.rexs.info. A
file lists components with attributes, relations between them, and load cases with the attributes
that they change. https://github.com/fva-net/rexs-api-java has the schemas of its versions.
"""

import base64
import binascii
import json
import math
import os
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from gearbow._convert import shown
from gearbow._files import check_name, parsing
from gearbow._types import Array
from gearbow.errors import SceneError
from gearbow.units.parse import parsed

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
    "1 / min": "rpm",
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
