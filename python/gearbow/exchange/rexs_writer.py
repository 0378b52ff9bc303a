"""Gear units as REXS 1.4: a file that other programs and `RotorSystem.read_rexs` read.

Each part is taken out of the description field by field; what remains is what REXS cannot hold.
"""

import math
import os
from collections.abc import Sequence
from datetime import datetime, timezone
from decimal import Decimal
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

import numpy as np

from gearbow._core import __version__
from gearbow._files import check_name, replacing
from gearbow._types import Array
from gearbow.description.rolling import RollingBearing
from gearbow.errors import SceneError, SceneWarning, warn
from gearbow.exchange.rexs_file import ENDINGS
from gearbow.exchange.rexs_joints import OPERATING, STIFFNESSES

if TYPE_CHECKING:
    from gearbow.description.layout import Layout

#: Units of REXS with the power of ten of their value over that in SI units.
_UNITS = {"mm": 3, "mum": 6, "N / m": 0, "N mm / rad": 3, "kg": 0, "kg m^2": 0, "N / mm^2": -6}
_UNITS |= {"kg / dm^3": -3, "N m": 0, "N": 0, "m / s^2": 0, "none": 0}
#: Parts without which the file would be another machine.
_REFUSED = ("sleeves", "housings")
#: Numbers of the gear unit and of its casing.
_UNIT, _CASING = 1, 2


def write_rexs(description: dict[str, Any], layout: "Layout", path: str | os.PathLike[str]) -> None:
    """Write a system; what REXS cannot hold is a warning, or an error if it is essential."""
    found, _ = check_name(path, ENDINGS[:1])
    for key in _REFUSED:
        if description.get(key):
            raise SceneError(f"{key}: REXS cannot hold them; save the system as .toml")
    writer = _Writer(description, layout)
    model = ET.Element("model", version="1.4", applicationId="gearbow")
    model.attrib |= {
        "applicationVersion": __version__,
        "date": datetime.now(timezone.utc).isoformat(timespec="seconds"),
    }
    model.extend([writer.relations, writer.components])
    spectrum = ET.SubElement(model, "load_spectrum", id="1")
    spectrum.append(writer.load_case)
    ET.indent(model)
    with replacing(found) as file:
        file.write(ET.tostring(model, encoding="utf-8", xml_declaration=True) + b"\n")
    if writer.left:
        warn(
            f"{found}: REXS cannot hold, and the file does not contain: "
            f"{', '.join(sorted(writer.left))}",
            SceneWarning,
        )


class _Writer:
    """Components and relations of a file."""

    def __init__(self, description: dict[str, Any], layout: "Layout") -> None:
        self.components, self.relations = ET.Element("components"), ET.Element("relations")
        self.load_case = ET.Element("load_case", id="1")
        #: Fields that the file does not contain.
        self.left: set[str] = set()
        given = {
            key: [dict(each) for each in value] if isinstance(value, list) else value
            for key, value in description.items()
        }
        self._bodies = {
            each["name"]: (each["shaft"], each["position"])
            for key in ("gears", "disks")
            for each in given.get(key, [])
        }
        self._origins = {shaft.name: shaft.origin for shaft in layout.shafts}
        self._materials: dict[str, int] = {}
        self._where = ""
        self._ids = {"gear_unit": _UNIT, "casing": _CASING}
        unit = self._component("gear_unit", "gear unit")
        self._component("gear_casing", "casing")
        gravity = given.pop("gravity", None)
        if gravity is not None:
            self._gravity(unit, gravity)
        self._reference = given.pop("reference", given["shafts"][0]["name"])
        for key, write in (
            ("shafts", self._shaft),
            ("gears", self._gear),
            ("disks", self._disk),
            ("meshes", self._mesh),
            ("bearings", self._bearing),
            ("couplings", self._coupling),
            ("torques", self._torque),
            ("forces", self._force),
            ("drives", self._drive),
        ):
            for i, part in enumerate(given.pop(key, [])):
                self._where = f"{key}[{i}]"
                write(part)
                self.left |= {f"{key}.{field}" for field in part}
        self.left |= {key for key, value in given.items() if value not in ([], None)}

    def _component(self, kind: str, name: str) -> ET.Element:
        number = str(len(self.components) + 1)
        found = ET.SubElement(self.components, "component", id=number, type=kind, name=name)
        self._ids[f"{kind} {name}"] = int(number)
        return found

    def _relation(self, kind: str, **refs: ET.Element | int) -> None:
        number = str(len(self.relations) + 1)
        relation = ET.SubElement(self.relations, "relation", id=number, type=kind)
        for role, ref in refs.items():
            component = self.components[ref - 1] if isinstance(ref, int) else ref
            hint, at = component.attrib["type"], component.attrib["id"]
            ET.SubElement(relation, "ref", hint=hint, id=at, role=role)

    def _number(self, component: ET.Element, name: str, value: float, unit: str) -> None:
        """Write a number in SI units, exactly; angles are in degrees."""
        if unit == "deg":
            text = repr(math.degrees(value))
        else:
            text = str(Decimal(repr(float(value))).scaleb(_UNITS[unit]))
        self._text(component, name, text, unit)

    def _text(self, component: ET.Element, name: str, text: str, unit: str = "none") -> ET.Element:
        attribute = ET.SubElement(component, "attribute", id=name, unit=unit)
        attribute.text = text
        return attribute

    def _placed(
        self, component: ET.Element, shaft: str, position: float, side: str = ""
    ) -> ET.Element:
        """Place a component on a shaft, and in the gear unit."""
        self._number(component, f"u_coordinate_on_shaft{side}", position, "mm")
        if component.attrib["type"] != "external_load":
            self._frame(component, self._origins[shaft] + np.array([position, 0.0, 0.0]))
        if not side:
            self._relation("assembly", assembly=self._ids[f"shaft {shaft}"], part=component)
        return component

    def _frame(self, component: ET.Element, origin: Array) -> None:
        for name, vector in (
            ("support_vector", 1e3 * origin),
            ("u_axis_vector", np.array([1.0, 0.0, 0.0])),
            ("w_axis_vector", np.array([0.0, 0.0, 1.0])),
        ):
            array = ET.SubElement(self._text(component, name, "", "mm"), "array")
            for value in vector.tolist():
                ET.SubElement(array, "c").text = repr(value)
        self._text(component, "reference_component_for_position", str(_UNIT))

    def _gravity(self, unit: ET.Element, gravity: Any) -> None:
        along = np.array([0.0, -gravity] if np.ndim(gravity) == 0 else gravity, dtype=float)
        size = float(np.hypot(*along))
        if size == 0.0:
            return
        self._text(unit, "account_for_gravity", "true")
        self._number(unit, "gravitational_acceleration", size, "m / s^2")
        for axis, value in zip("uvw", (0.0, *(along / size)), strict=True):
            self._number(unit, f"direction_vector_gravity_{axis}", value, "none")

    def _shaft(self, shaft: dict[str, Any]) -> None:
        name = shaft.pop("name")
        component = self._component("shaft", name)
        self._text(component, "defines_speed", str(name == self._reference).lower())
        self._frame(component, self._origins[name])
        own = shaft.pop("material", None)
        keys = ("length", "outer_diameter", "inner_diameter")
        segments = shaft.pop("segments", None) or [
            {key: shaft.pop(key) for key in keys if key in shaft}
        ]
        begin = 0.0
        for i, each in enumerate(map(dict, segments)):
            section = self._component("shaft_section", f"{name} {i + 1}")
            self._relation("assembly", assembly=component, part=section)
            length = each.pop("length")
            self._number(section, "u_coordinate_on_shaft", begin, "mm")
            self._number(section, "length", length, "mm")
            begin += length
            for side in ("outer_diameter", "inner_diameter"):
                left = each.pop(side, 0.0)
                self._number(section, f"{side}_begin", left, "mm")
                self._number(section, f"{side}_end", each.pop(f"end_{side}", left), "mm")
            self._material(section, each.pop("material", own))
            self.left |= {f"shafts.segments.{key}" for key in each if key != "elements"}
        self._relation("assembly", assembly=_UNIT, part=component)

    def _material(self, section: ET.Element, material: Any) -> None:
        given = dict(material or {})
        steel = {"youngs_modulus": 207e9, "density": 7850.0, "poisson_ratio": 0.3}
        values = {key: given.pop(key, value) for key, value in steel.items()}
        if "shear_modulus" in given:
            modulus = given.pop("shear_modulus")
            values["poisson_ratio"] = values["youngs_modulus"] / (2.0 * modulus) - 1.0
        self.left |= {f"materials.{key}" for key in given}
        if (key := repr(values)) not in self._materials:
            component = self._component("material", f"material {len(self._materials) + 1}")
            self._number(component, "elastic_modulus", values["youngs_modulus"], "N / mm^2")
            self._number(component, "density", values["density"], "kg / dm^3")
            self._number(component, "poisson_ratio", values["poisson_ratio"], "none")
            self._materials[key] = int(component.attrib["id"])
        self._relation("reference", origin=section, referenced=self._materials[key])

    def _gear(self, gear: dict[str, Any]) -> None:
        name = gear.pop("name")
        component = self._component("cylindrical_gear", name)
        self._placed(component, gear.pop("shaft"), gear.pop("position"))
        teeth, helix = gear.pop("teeth"), gear.pop("helix_angle", 0.0)
        pressure = gear.pop("pressure_angle", math.radians(20.0))
        module, base = gear.pop("module", None), gear.pop("base_radius", None)
        if module is None:
            transverse = math.atan2(math.tan(pressure), math.cos(helix))
            module = 2.0 * base * math.cos(helix) / (teeth * math.cos(transverse))
        # As in ISO 21771, an internal gear has a negative number of teeth.
        self._text(
            component, "number_of_teeth", str(-teeth if gear.pop("internal", False) else teeth)
        )
        self._number(component, "normal_module", module, "mm")
        self._number(component, "helix_angle_reference_diameter", helix, "deg")
        if "face_width" in gear:
            self._number(component, "face_width", gear.pop("face_width"), "mm")
        else:
            raise SceneError(
                f'{self._where}.face_width: REXS needs it of "{name}"; give one, or save as .toml'
            )
        if "tip_radius" in gear:
            self._number(component, "tip_diameter", 2.0 * gear.pop("tip_radius"), "mm")
        shift = gear.pop("profile_shift", 0.0)
        flanks = {}
        for side in ("left", "right"):
            flanks[side] = self._component("cylindrical_gear_flank", f"{name} ({side} flank)")
            self._number(flanks[side], "normal_pressure_angle", pressure, "deg")
            self._number(flanks[side], "addendum_modification_coefficient", shift, "none")
        self._relation("flank", gear=component, **flanks)

    def _disk(self, disk: dict[str, Any]) -> None:
        component = self._component("additional_mass", disk.pop("name"))
        self._placed(component, disk.pop("shaft"), disk.pop("position"))
        self._number(component, "mass_of_component", disk.pop("mass"), "kg")
        diametral, polar = disk.pop("diametral_inertia"), disk.pop("polar_inertia")
        for axis, inertia in (("u", polar), ("v", diametral), ("w", diametral)):
            self._number(component, f"moment_of_inertia_{axis}_axis", inertia, "kg m^2")

    def _mesh(self, mesh: dict[str, Any]) -> None:
        if "carrier" in mesh:
            raise SceneError(
                f"{self._where}.carrier: REXS cannot hold a carrier without pins; save it as .toml"
            )
        names = mesh.pop("driver"), mesh.pop("driven")
        first, second = (self._ids[f"cylindrical_gear {name}"] for name in names)
        component = self._component("cylindrical_stage", "–".join(names))
        distance = mesh.pop("centre_distance", None)
        if distance is None:
            origins = [self._origins[self._bodies[name][0]] for name in names]
            distance = float(np.hypot(*(origins[1] - origins[0])[1:]))
        self._number(component, "center_distance", distance, "mm")
        turn = 0.5 * math.pi - mesh.pop("centre_line_angle", 0.0)
        self._number(component, "rotating_angle_around_neg_u_axis", turn, "deg")
        self._relation("stage", stage=component, gear_1=first, gear_2=second)

    def _bearing(self, bearing: dict[str, Any]) -> None:
        shaft, position = bearing.pop("shaft"), bearing.pop("position")
        outer = bearing.pop("support", None)
        if isinstance(outer, str | dict) or outer == {}:
            raise SceneError(
                f"{self._where}.support: REXS has bearings between shafts or in the casing"
            )
        if "viscosity" in bearing:
            raise SceneError(f"{self._where}: REXS cannot hold the film of a journal bearing")
        rolling = "stiffness" not in bearing
        kind = "rolling_bearing_with_detailed_geometry" if rolling else "concept_bearing"
        component = self._component(
            kind, f"bearing {self._where.partition('[')[2][:-1]} of {shaft}"
        )
        self._placed(component, shaft, position, "_inner_side")
        outside_at = _CASING if outer is None else self._ids[f"shaft {outer[0]}"]
        if outer is not None:
            self._number(component, "u_coordinate_on_shaft_outer_side", outer[1], "mm")
        inner = self._ids[f"shaft {shaft}"]
        self._relation("side", assembly=component, inner_part=inner, outer_part=outside_at)
        along = "both_directions" if bearing.get("axial_stiffness") else "no_direction"
        if rolling:
            along = self._rolling(component, bearing, along)
        else:
            self._radial(component, bearing.pop("stiffness"))
        self._text(component, "axial_force_absorption", along)
        self._text(component, "radial_force_absorption", "true")
        self._springs(component, bearing)

    def _springs(self, component: ET.Element, part: dict[str, Any]) -> None:
        for each in STIFFNESSES:
            if each.coupling in part:
                self._number(component, each.file, part.pop(each.coupling), each.unit)

    def _radial(self, component: ET.Element, stiffness: Any) -> None:
        """Write a radial stiffness, which may differ along both axes."""
        if isinstance(stiffness, dict):
            raise SceneError(f"{self._where}.stiffness: REXS cannot hold a table over the speed")
        given = np.array(stiffness, dtype=float)
        matrix = given if given.ndim == 2 else np.diag(np.broadcast_to(given, 2))
        self._number(component, "radial_stiffness", float(np.trace(matrix)) / 2.0, "N / m")
        if given.ndim > 0:
            for (i, j), value in np.ndenumerate(matrix):
                self._number(component, OPERATING.format("vw"[i], "vw"[j]), value, "N / m")

    def _rolling(self, component: ET.Element, bearing: dict[str, Any], along: str) -> str:
        """Write the rolling elements, and give the directions in which they carry thrust."""
        known = RollingBearing("", 0.0, **{k: v for k, v in bearing.items() if k != "damping"})
        estimate = known.estimate
        sizes = {} if estimate is None else vars(estimate)
        for key in ("designation", "kind", "boundary"):
            bearing.pop(key, None)
        sides = {"bore": "inner_diameter", "outer": "outer_diameter", "width": "width"}
        for key, name in sides.items() if sizes else ():
            self._number(component, name, sizes[key], "mm")
        rollers = known.contact == "roller" or sizes.get("roller_length") is not None
        tapered = "tapered_" if sizes.get("kind") == "tapered_roller" else ""
        self._text(
            component,
            "bearing_type",
            f"radial_{tapered}roller_bearing" if rollers else "radial_grooved_ball_bearing",
        )
        bearing.pop("contact", None)
        self._number(
            component, "operating_radial_bearing_clearance", bearing.pop("clearance", 0.0), "mum"
        )
        row = self._component("rolling_bearing_row", "row")
        self._relation("assembly", assembly=component, part=row)
        element = self._component("rolling_element", "element")
        self._relation("assembly", assembly=row, part=element)
        angle = bearing.pop("contact_angle", sizes.get("contact_angle", 0.0))
        elements = bearing.pop("elements", sizes.get("elements"))
        self._text(row, "number_of_rolling_elements", str(elements))
        self._number(row, "pressure_angle", abs(angle), "deg")
        for part, key, name in (
            (row, "pitch_diameter", "reference_diameter"),
            (element, "element_diameter", "diameter_of_rolling_element"),
            (element, "roller_length", "length_of_rolling_element"),
        ):
            value = bearing.pop(key, sizes.get(key))
            if value is not None:
                self._number(part, name, value, "mm")
        if bearing.pop("degrees_of_freedom", 2) == 2:
            return along
        return "negative" if angle < 0.0 else "positive" if angle > 0.0 else "both_directions"

    def _coupling(self, coupling: dict[str, Any]) -> None:
        (a, begin), (b, end) = (self._at(coupling.pop(key)) for key in ("a", "b"))
        component = self._component("coupling", f"{a}–{b}")
        self._placed(component, a, begin, "_inner_side")
        self._number(component, "u_coordinate_on_shaft_outer_side", end, "mm")
        shafts = [self._ids[f"shaft {name}"] for name in (a, b)]
        self._relation("side", assembly=component, inner_part=shafts[0], outer_part=shafts[1])
        self._springs(component, coupling)

    def _at(self, at: Any) -> tuple[str, float]:
        return self._bodies[at] if isinstance(at, str) else (at[0], at[1])

    def _load(self, part: dict[str, Any]) -> tuple[ET.Element, ET.Element]:
        """Write a load, and give it and its values in the load case."""
        component = self._component("external_load", self._where)
        self._placed(component, *self._at(part.pop("at")))
        number = component.attrib["id"]
        return component, ET.SubElement(
            self.load_case, "component", id=number, type="external_load"
        )

    def _torque(self, torque: dict[str, Any]) -> None:
        value = torque.get("value", 0.0)
        if not isinstance(value, int | float):
            raise SceneError(f"{self._where}.value: REXS has a constant torque in each load case")
        component, values = self._load(torque)
        self._text(component, "transmits_torque", "true")
        balance = bool(torque.pop("balance", False))
        self._text(component, "defines_torque", str(not balance).lower())
        torque.pop("value", None)
        if not balance:
            self._number(values, "torque_around_u_axis", value, "N m")

    def _drive(self, drive: dict[str, Any]) -> None:
        """Write a drive as the load that takes the torque which the others leave over."""
        self._torque({"at": drive.pop("at"), "balance": True})

    def _force(self, force: dict[str, Any]) -> None:
        value, axial = force.get("value", 0.0), force.get("axial", 0.0)
        if isinstance(value, dict) or isinstance(axial, dict):
            raise SceneError(f"{self._where}.value: REXS has a constant force in each load case")
        component, values = self._load(force)
        self._text(component, "transmits_torque", "false")
        across = complex(*value) if isinstance(value, Sequence) else complex(value)
        for axis, part in (("u", axial), ("v", across.real), ("w", across.imag)):
            self._number(values, f"force_{axis}_direction", part, "N")
        force.pop("value", None), force.pop("axial", None)
