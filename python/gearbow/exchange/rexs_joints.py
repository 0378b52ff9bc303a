"""Bearings and couplings of a REXS file, whose stiffness the file often does not contain.

A file gives the dimensions of bearings, and a very large stiffness where a program counts them as
rigid. What gearbow needs then is listed, and given by name.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gearbow._convert import number, shown
from gearbow._lookup import nearest
from gearbow._shown import Shown
from gearbow._types import Plain
from gearbow.errors import SceneError
from gearbow.exchange.rexs_file import Component, RexsFile
from gearbow.exchange.rexs_shafts import PlacedShaft, Shafts

__all__ = ["OTHER", "Joints", "MissingValue", "check_given"]

#: The entry of `bearings` for all bearings without an entry of their own.
OTHER = "other"
#: Names of the radial clearance, the preferred first: the second is that of REXS 1.0.
_CLEARANCES = ("operating_radial_bearing_clearance", "radial_backlash", "radial_bearing_clearance")
_COUPLINGS = ("coupling", "switchable_coupling", "fixed_coupling")


@dataclass(frozen=True)
class _Stiffness:
    """A stiffness of bearings and couplings: its names, and the least value that means rigid."""

    file: str
    bearing: str
    coupling: str
    #: [N/m or N m/rad]. Programs write 1e12 to 1e23; large bearings have about 1e10 and 1e8.
    rigid: float


_STIFFNESSES = (
    _Stiffness("radial_stiffness", "stiffness", "lateral_stiffness", 1e12),
    _Stiffness("axial_stiffness", "axial_stiffness", "axial_stiffness", 1e12),
    _Stiffness("bending_stiffness", "tilting_stiffness", "tilting_stiffness", 1e10),
    _Stiffness("rotational_stiffness", "", "torsional_stiffness", 1e10),
)


@dataclass(frozen=True)
class MissingValue(Shown):
    """Values of a bearing or coupling that a REXS file does not contain.

    Attributes
    ----------
    argument : str
        "bearings" or "couplings", the argument of `gearbow.RotorSystem.read_rexs` that gives them.
    name : str
        Name of the part in the file.
    part : str
        Its type, dimensions and place.
    keys : tuple of str
        The parameters of `gearbow.Bearing`, `gearbow.RollingBearing` or `gearbow.Coupling`.
    hint : str
        What else to know, or an empty text.

    Examples
    --------
    >>> import gearbow as gb
    >>> print(gb.results.MissingValue("bearings", "B1", "ball bearing at 0.1 m", ("stiffness",)))
    stiffness of "B1" (ball bearing at 0.1 m)
    """

    argument: str
    name: str
    part: str
    keys: tuple[str, ...]
    hint: str = ""

    def __str__(self) -> str:
        hint = f"; {self.hint}" if self.hint else ""
        return f'{", ".join(self.keys)} of "{self.name}" ({self.part}){hint}'


@dataclass(frozen=True)
class _Joint:
    """A bearing or coupling with its inner and outer part."""

    component: Component
    inner: Component
    outer: Component

    @property
    def name(self) -> str:
        return self.component.name or str(self.component)


class Joints:
    """Adds the bearings and couplings of a file to a description."""

    def __init__(
        self,
        file: RexsFile,
        shafts: Shafts,
        placed: Mapping[int, PlacedShaft],
        description: dict[str, Any],
        notes: list[str],
    ) -> None:
        self._file = file
        self._shafts = shafts
        self._placed = placed
        self._description = description
        self._notes = notes
        self.missing: list[MissingValue] = []

    def add(self, bearings: Mapping[str, object], couplings: Mapping[str, object]) -> None:
        """Add all of them, with the values that are given by name."""
        joints = self._found()
        of_bearings = [each for each in joints if "bearing" in each.component.kind]
        of_couplings = [each for each in joints if each.component.kind in _COUPLINGS]
        for argument, given, known in (
            ("bearings", bearings, of_bearings),
            ("couplings", couplings, of_couplings),
        ):
            names = [each.name for each in known]
            for name in given:
                if name not in (*names, OTHER):
                    raise SceneError(
                        f'{argument}: {self._file.path} has no "{name}", it has '
                        f"{', '.join(names) or 'none'}{nearest(name, names)}"
                    )
        for joint in of_bearings:
            self._add_bearing(joint, bearings)
        for joint in of_couplings:
            self._add_coupling(joint, couplings)

    def _found(self) -> list[_Joint]:
        joints = []
        for refs in (*self._file.related("side"), *self._file.related("coupling")):
            sides = [
                refs.get(first, refs.get(second))
                for first, second in (("inner_part", "side_1"), ("outer_part", "side_2"))
            ]
            if "assembly" in refs and all(sides):
                joints.append(_Joint(refs["assembly"], *sides))  # type: ignore[arg-type]
        with_sides = {each.component.id for each in joints}
        for component in self._file.components.values():
            kind = component.kind
            is_bearing = kind.endswith("_bearing") or kind.startswith("rolling_bearing_with")
            if (is_bearing or kind in _COUPLINGS) and component.id not in with_sides:
                raise component.error("no relation of the type side says what it joins")
        return joints

    def _add_bearing(self, joint: _Joint, bearings: Mapping[str, object]) -> None:
        component = joint.component
        on_shafts = [
            (side, part)
            for side, part in (("inner", joint.inner), ("outer", joint.outer))
            if part.id in self._placed
        ]
        if not on_shafts:
            raise component.error(f"joins {joint.inner} and {joint.outer}, none of them a shaft")
        side, part = on_shafts[0]
        placed = self._placed[part.id]
        between = len(on_shafts) == 2
        given = bearings.get(joint.name)
        if joint.name in bearings and given is None:
            return
        position = self._shafts.locate(component, placed, f"u_coordinate_on_shaft_{side}_side")
        carries = self._carried(component)
        found = {} if between else self._stiffness(component, "bearings")
        if "stiffness" not in carries:
            found["stiffness"] = 0.0
        if "stiffness" not in found and side == "inner":
            found = {**found, **self._rolling(component)}
        if given is not None:
            found = self._replaced(found, given, carries, f'bearings["{joint.name}"]')
        keys = self._required(found, carries, placed.name)
        other = None if between else bearings.get(OTHER)
        if keys and other is not None:
            filled = self._replaced({}, other, carries, f'bearings["{OTHER}"]')
            found = {**{key: filled[key] for key in keys if key in filled}, **found}
            keys = self._required(found, carries, placed.name)
        hint = ""
        if between and given is None:
            hint = (
                f'it joins the shafts "{self._placed[joint.inner.id].name}" and '
                f'"{self._placed[joint.outer.id].name}", and a bearing of gearbow stands on the '
                "ground: give its stiffness to the ground, or None to leave it out"
            )
            keys = keys or ("stiffness",)
        bearing = {"shaft": placed.name, "position": position, **found}
        self._description["bearings"].append(bearing)
        if keys:
            self._miss("bearings", joint, placed, position, (keys, hint))

    def _replaced(
        self, found: dict[str, Plain], given: object, carries: tuple[str, ...], path: str
    ) -> dict[str, Plain]:
        """Replace values of the file by those that are given for a bearing."""
        if not isinstance(given, Mapping):
            given = dict.fromkeys(carries, number(given, path))
        for key in ("shaft", "position"):
            if key in given:
                raise SceneError(f"{path}: the file has its {key}; leave it out")
        if {"stiffness", "elements", "viscosity"} & given.keys():  # a bearing of another kind
            kept = ("axial_stiffness", "tilting_stiffness")
            found = {key: value for key, value in found.items() if key in kept}
        return {**found, **given}

    def _carried(self, component: Component) -> tuple[str, ...]:
        """Give the stiffnesses of the directions in which the file says that a bearing carries."""
        carries = () if component.flag("radial_force_absorption") is False else ("stiffness",)
        axial = component.text("axial_force_absorption")
        return (*carries, "axial_stiffness") if axial not in ("", "no_direction") else carries

    def _required(
        self, found: Mapping[str, Plain], carries: tuple[str, ...], shaft: str
    ) -> tuple[str, ...]:
        """List the parameters that are missing."""
        keys: tuple[str, ...] = ("stiffness",)
        if "elements" in found:
            keys = ("element_diameter", "pitch_diameter", "clearance")
            if found.get("contact") == "roller":
                keys = (*keys, "roller_length")
        elif "viscosity" in found:  # a journal bearing, which the core checks
            keys = ()
        helical = any(
            gear["shaft"] == shaft and "helix_angle" in gear for gear in self._description["gears"]
        )
        if helical and "axial_stiffness" in carries:
            keys = (*keys, "axial_stiffness")
        return tuple(key for key in keys if key not in found)

    def _stiffness(self, component: Component, argument: str) -> dict[str, Plain]:
        """Give the stiffnesses of the file that are neither zero nor rigid."""
        found: dict[str, Plain] = {}
        for each in _STIFFNESSES:
            key = each.bearing if argument == "bearings" else each.coupling
            if key and component.has(each.file):
                value = component.number(each.file, f"couplings.{each.coupling}")
                if 0.0 < value < each.rigid:
                    found[key] = value
                elif key == "tilting_stiffness" and value > 0.0:
                    self._notes.append(
                        f"{component}: its {each.file} {value:g} N m/rad means rigid and is left "
                        "out"
                    )
        return found

    def _rolling(self, bearing: Component) -> dict[str, Plain]:
        """Give the geometry of the rolling elements, if the file has it."""
        rows = self._parts(bearing, "rolling_bearing_row")
        if len(rows) != 1 or not rows[0].has("number_of_rolling_elements"):
            return {}
        (row,) = rows
        elements = [row, *self._parts(row, "rolling_element")]
        found: dict[str, Plain] = {"elements": row.count("number_of_rolling_elements")}
        pitch = ("reference_diameter_rolling_bearing", "reference_diameter")
        for key, sources, names in (
            ("element_diameter", elements, ("diameter_of_rolling_element",)),
            ("roller_length", elements, ("length_of_rolling_element",)),
            ("pitch_diameter", [row], pitch),
            ("contact_angle", [row], ("pressure_angle",)),
            ("clearance", [bearing], _CLEARANCES),
        ):
            name = next((n for n in names if any(each.has(n) for each in sources)), None)
            if name is not None:
                values = {each.number(name, key) for each in sources if each.has(name)}
                if len(values) > 1:
                    raise bearing.error(f"{name}: all rolling elements must be equal")
                found[key] = values.pop()
        if "roller" in bearing.text("bearing_type"):
            found["contact"] = "roller"
        else:
            found.pop("roller_length", None)
        return found

    def _parts(self, whole: Component, kind: str) -> list[Component]:
        refs = [*self._file.related("assembly"), *self._file.related("ordered_assembly")]
        return [
            each["part"]
            for each in refs
            if each.get("assembly") is whole and "part" in each and each["part"].kind == kind
        ]

    def _add_coupling(self, joint: _Joint, couplings: Mapping[str, object]) -> None:
        component = joint.component
        if component.flag("is_engaged") is False:
            self._notes.append(f"{component} is left out, because it is not engaged")
            return
        given = couplings.get(joint.name)
        if joint.name in couplings and given is None:
            return
        if not all(part.id in self._placed for part in (joint.inner, joint.outer)):
            raise component.error(
                f"joins {joint.inner} and {joint.outer}; a coupling of gearbow joins two shafts"
            )
        found = self._stiffness(component, "couplings")
        if given is not None:
            found |= _torsional(given, f'couplings["{joint.name}"]')
        if "torsional_stiffness" not in found and couplings.get(OTHER) is not None:
            found = {**_torsional(couplings[OTHER], f'couplings["{OTHER}"]'), **found}
        places: dict[str, list[Any]] = {}
        for key, part, side, other in (
            ("a", joint.inner, "inner_side", "side_1"),
            ("b", joint.outer, "outer_side", "side_2"),
        ):
            coordinate = f"u_coordinate_on_shaft_{side}"
            if not component.has(coordinate):
                coordinate = f"u_coordinate_on_shaft_{other}"
            placed = self._placed[part.id]
            places[key] = [placed.name, self._shafts.locate(component, placed, coordinate)]
        self._description["couplings"].append({**places, **found})
        if "torsional_stiffness" not in found:
            placed = self._placed[joint.inner.id]
            missing = (("torsional_stiffness",), "a rigid coupling has a large stiffness")
            self._miss("couplings", joint, placed, places["a"][1], missing)

    def _miss(
        self,
        argument: str,
        joint: _Joint,
        placed: PlacedShaft,
        position: float,
        missing: tuple[tuple[str, ...], str],
    ) -> None:
        component = joint.component
        texts = [component.text(name) for name in ("catalogue_designation", "name", "bearing_type")]
        sizes = [
            f"{1e3 * component.number(name, 'length'):g}"
            for name in ("inner_diameter", "outer_diameter", "width")
            if component.has(name)
        ]
        kind = re.sub("_", " ", next((text for text in texts[::-1] if text), component.kind))
        designation = next((text for text in texts[:2] if text), "")
        size = f"{'x'.join(sizes)} mm" if sizes else ""
        place = f'on "{placed.name}" at {1e3 * position:g} mm'
        part = ", ".join(text for text in (designation, kind, size, place) if text)
        self.missing.append(MissingValue(argument, joint.name, part, *missing))


def _torsional(given: object, path: str) -> dict[str, Plain]:
    """Give the parameters of a coupling; a number is its torsional stiffness."""
    if isinstance(given, Mapping):
        return dict(given)
    return {"torsional_stiffness": number(given, path)}


def check_given(given: object, argument: str) -> Mapping[str, object]:
    """Check the values that are given by name."""
    if given is None:
        return {}
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise SceneError(f"{argument}: must be a mapping of names to values, got {shown(given)}")
    return given
