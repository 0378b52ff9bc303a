"""Bearings and couplings of a REXS file, whose stiffness the file often does not contain.

A file gives the dimensions of bearings, and a very large stiffness where a program counts them as
rigid. What gearbow needs then is listed, and given by name. Type, dimensions and designation tell
what rolling bearing it is.
"""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gearbow._convert import nearest, number, shown
from gearbow._shown import Shown
from gearbow._types import Plain
from gearbow.description.journal import Pad
from gearbow.description.rolling import RollingBearing, RollingEstimate
from gearbow.errors import SceneError
from gearbow.exchange.rexs_file import Component, PlacedShaft, RexsFile, Shafts
from gearbow.exchange.rexs_planetary import Planets

#: Kinds of gearbow by the `bearing_type` of REXS.
_KINDS = {
    "radial_grooved_ball_bearing": "deep_groove",
    "angular_contact_ball_bearing": "angular_contact",
    "radial_roller_bearing": "cylindrical_roller",
    "radial_tapered_roller_bearing": "tapered_roller",
}
#: The dimension series of ISO 15 by the series of a designation of gearbow that has it.
_DIMENSIONS = {"0": "60", "10": "60", "2": "62", "3": "63"}
#: Kinds of ball bearings by the first digit of the designation.
_BALL_KINDS = {"6": "deep_groove", "7": "angular_contact"}
_BALLS = re.compile(r"(?<![0-9A-Z])(?P<kind>[67])(?P<series>[023])(?P<code>\d\d)(?!\d)")
_ROLLERS = re.compile(r"(?<![A-Z])(?P<kind>NUP|NU|NJ|NF|N)(?P<series>10|2|3)(?P<code>\d\d)(?!\d)")
_TAPERED = re.compile(r"(?<![0-9A-Z])32(0\d\d)X?(?!\d)")
_TAPERED_330 = re.compile(r"(?<![0-9A-Z])330(\d\d)(?!\d)")
_NEEDLES = re.compile(r"(?<![A-Z])K ?(\d+)X(\d+)X(\d+)(?!\d)")
#: Tapered roller bearings 330.. of ISO 355 by bore code: outside diameter, width T [mm], contact
#: angle [degrees].
_SERIES_330 = {
    5: (47.0, 17.0, 10.917),
    6: (55.0, 20.0, 11.0),
    7: (62.0, 21.0, 11.5),
    8: (68.0, 22.0, 10.667),
    9: (75.0, 24.0, 11.083),
    10: (80.0, 24.0, 11.917),
    11: (90.0, 27.0, 11.75),
    12: (95.0, 27.0, 12.333),
    13: (100.0, 27.0, 13.083),
    14: (110.0, 31.0, 10.75),
    15: (115.0, 31.0, 11.25),
    16: (125.0, 36.0, 10.5),
    17: (130.0, 36.0, 11.0),
    18: (140.0, 39.0, 10.167),
    19: (145.0, 39.0, 10.5),
    20: (150.0, 39.0, 10.833),
}


def bearing_of_dimensions(kind: str, boundary: tuple[float, ...]) -> dict[str, Plain]:
    """Give the bearing of a type of REXS with bore, outside diameter and width [m]."""
    if kind not in _KINDS or not 0.0 < boundary[0] < boundary[1] or boundary[2] <= 0.0:
        return {}
    return {"kind": _KINDS[kind], "boundary": list(boundary)}


def bearing_of_designation(texts: Iterable[str]) -> dict[str, Plain]:
    """Give fields of a `RollingBearing` by the first designation in texts; empty without one."""
    for text in texts:
        for pattern, make in (
            (_ROLLERS, _of_series),
            (_TAPERED_330, _tapered_330),
            (_TAPERED, _tapered),
            (_BALLS, _of_series),
            (_NEEDLES, _needles),
        ):
            for found in pattern.finditer(text.upper()):
                if fields := make(found):
                    return fields
    return {}


def _of_series(found: re.Match[str]) -> dict[str, Plain]:
    """Give a bearing with the dimensions of a ball bearing that gearbow knows."""
    known = _estimate(f"{_DIMENSIONS[found['series']]}{found['code']}")
    if known is None:
        return {}
    kind = _BALL_KINDS.get(found["kind"], "cylindrical_roller")
    return {"kind": kind, "boundary": [known.bore, known.outer, known.width]}


def _estimate(designation: str) -> RollingEstimate | None:
    """Give the estimate of a designation; None if gearbow does not know it."""
    try:
        return RollingBearing("", 0.0, designation).estimate
    except SceneError:
        return None


def _tapered(found: re.Match[str]) -> dict[str, Plain]:
    designation = f"32{found[1]}"
    return {} if _estimate(designation) is None else {"designation": designation}


def _tapered_330(found: re.Match[str]) -> dict[str, Plain]:
    code = int(found[1])
    if code not in _SERIES_330:
        return {}
    outer, width, angle = _SERIES_330[code]
    boundary: list[Plain] = [5e-3 * code, 1e-3 * outer, 1e-3 * width]
    return {"kind": "tapered_roller", "boundary": boundary, "contact_angle": math.radians(angle)}


def _needles(found: re.Match[str]) -> dict[str, Plain]:
    boundary: list[Plain] = [1e-3 * float(size) for size in found.groups()]
    return {"kind": "needle_cage", "boundary": boundary}


#: The entry of `bearings` for all bearings without an entry of their own.
OTHER = "other"
#: The value of `bearings` for rolling bearings of estimated elements, which is the default.
CATALOGUE = "catalogue"
#: Fields of rolling bearings whose elements gearbow estimates, those without an estimate, and the
#: fields that say which radial law a bearing has.
_CATALOGUED = {"designation", "kind", "boundary"}
_ELEMENTS = {"elements", "element_diameter", "pitch_diameter"}
_LAWS = {"stiffness", "viscosity", *_CATALOGUED}
#: Values of the file that a given radial law does not replace.
_WITH_EVERY_LAW = ("axial_stiffness", "tilting_stiffness")
#: Names of the radial clearance, the preferred first: the second is that of REXS 1.0.
_CLEARANCES = ("operating_radial_bearing_clearance", "radial_backlash", "radial_bearing_clearance")
#: Names of the entries of the stiffness at the operating point, which calculations write.
OPERATING = "operating_point_stiffness_f_{}_d_{}"
_COUPLINGS = ("coupling", "switchable_coupling", "fixed_coupling")


@dataclass(frozen=True)
class _Stiffness:
    """A stiffness of bearings and couplings: its names, and the least value that means rigid."""

    file: str
    bearing: str
    coupling: str
    unit: str
    #: [N/m or N m/rad]. Programs write 1e12 to 1e23; large bearings have about 1e10 and 1e8. This
    #: is the stiffness of a rigid coupling.
    rigid: float


STIFFNESSES = (
    _Stiffness("radial_stiffness", "stiffness", "lateral_stiffness", "N / m", 1e12),
    _Stiffness("axial_stiffness", "axial_stiffness", "axial_stiffness", "N / m", 1e12),
    _Stiffness("bending_stiffness", "tilting_stiffness", "tilting_stiffness", "N mm / rad", 1e10),
    _Stiffness("rotational_stiffness", "", "torsional_stiffness", "N mm / rad", 1e10),
)


@dataclass(frozen=True)
class MissingValue(Shown):
    """Values of a bearing or coupling that a REXS file does not contain.

    Attributes
    ----------
    argument : str
        "bearings" or "couplings", the argument of `gearbow.RotorSystem.read_rexs` that gives them.
    name, part : str
        Name of the part in the file; its type, dimensions and place.
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
        *,
        planets: Planets,
    ) -> None:
        self._file = file
        self._shafts = shafts
        self._placed = placed
        self._description = description
        self._notes = notes
        self._planets = planets
        self.missing: list[MissingValue] = []
        #: What each bearing becomes.
        self.becomes: dict[str, str] = {}
        self._estimated: list[str] = []

    def add(self, bearings: Mapping[str, object], couplings: Mapping[str, object]) -> None:
        """Add all of them, with the values that are given by name."""
        joints = [each for each in self._found() if not self._planets.take(*_ends(each))]
        of_bearings = [each for each in joints if "bearing" in each.component.kind]
        if self._planets.stages:  # torsion has no bearings
            of_bearings = []
        of_couplings = [each for each in joints if each.component.kind in _COUPLINGS]
        given = self._by_name(bearings, "bearings", of_bearings)
        for joint in of_bearings:
            self._add_bearing(joint, given)
        given = self._by_name(couplings, "couplings", of_couplings)
        for joint in of_couplings:
            self._add_coupling(joint, given)
        if self._estimated:
            names = ", ".join(f'"{name}"' for name in self._estimated)
            self._notes.append(
                f"number and size of the rolling elements of {names} are estimates, which change "
                "the stiffness by 15 to 30 %; clearance and damping are 0 unless they are given"
            )

    def _by_name(
        self, given: Mapping[str, object], argument: str, joints: list[_Joint]
    ) -> Mapping[str, object]:
        """Give values by the whole names of the file; a part of a single name is enough."""
        names = list(dict.fromkeys(each.name for each in joints))
        found = {}
        for name, value in given.items():
            fitting = [name] if name in (*names, OTHER) else [one for one in names if name in one]
            if len(fitting) != 1:
                several = f"; it is a part of {', '.join(fitting)}" if fitting else ""
                raise SceneError(
                    f'{argument}: {self._file.path} has no "{name}", it has '
                    f"{', '.join(names) or 'none'}{several or nearest(name, names)}"
                )
            found[fitting[0]] = value
        return found

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
        on_shafts = {
            side: self._placed[part.id]
            for side, part in (("inner", joint.inner), ("outer", joint.outer))
            if part.id in self._placed
        }
        if not on_shafts:
            raise component.error(f"joins {joint.inner} and {joint.outer}, none of them a shaft")
        (side, placed), *others = on_shafts.items()
        given = bearings.get(joint.name)
        if joint.name in bearings and given is None:
            self.becomes[joint.name] = "left out"
            return
        position = self._shafts.locate(component, placed, f"u_coordinate_on_shaft_{side}_side")
        carries = self._carried(component)
        found = self._stiffness(component, "bearings")
        if "stiffness" not in carries:
            found["stiffness"] = 0.0
        elif component.has(OPERATING.format("v", "v")):
            found["stiffness"] = self._operating(component, placed)
        rolls = "stiffness" not in found and side == "inner"
        geometry = self._rolling(component) if rolls else {}
        for key, value in ((joint.name, given), (OTHER, bearings.get(OTHER))):
            keys = self._required({**geometry, **found}, carries, placed.name)
            if key == OTHER and not keys:
                continue
            values = self._values(value, carries, f'bearings["{key}"]')
            if key == OTHER and keys == ("axial_stiffness",):  # the radial law stays
                values = {each: values[each] for each in keys if each in values}
            if _has_law(values):  # of another kind
                rolls, geometry = False, {}
                if key != OTHER:
                    found = {each: found[each] for each in found if each in _WITH_EVERY_LAW}
            # What the file gives precedes only the values for all others.
            found = {**values, **found} if key == OTHER else {**found, **values}
        found = {**geometry, **found}
        if rolls:
            found = self._rolling_on(component, found, carries, placed)
        keys = self._required(found, carries, placed.name)
        bearing: dict[str, Plain] = {"shaft": placed.name, "position": position, **found}
        for outer in others:
            at = self._shafts.locate(component, outer[1], "u_coordinate_on_shaft_outer_side")
            bearing["support"] = [outer[1].name, at]
        self._description["bearings"].append(bearing)
        self.becomes[joint.name] = "needs values" if keys else _described(bearing)
        self._estimated += [joint.name] if _CATALOGUED & found.keys() and not keys else []
        if keys:
            self._miss("bearings", joint, placed, position, (keys, ""))

    def _rolling_on(
        self,
        component: Component,
        found: dict[str, Plain],
        carries: tuple[str, ...],
        placed: PlacedShaft,
    ) -> dict[str, Plain]:
        """Complete a rolling bearing by what its designation says."""
        keys = self._required(found, carries, placed.name)
        if keys and keys != ("axial_stiffness",):
            found = {**self._catalogue(component), **found}
            keys = self._required(found, carries, placed.name)
        if keys == ("axial_stiffness",):
            found = self._with_thrust(component, found, placed.sense)
        return found

    def _catalogue(self, component: Component) -> dict[str, Plain]:
        """Give a rolling bearing of one row by its dimensions or designation, if it is known."""
        if component.number("number_of_bearing_rows", "teeth", 1.0) > 1.0:
            return {}
        sizes = ("inner_diameter", "outer_diameter", "width")
        boundary = tuple(component.number(name, "length", 0.0) for name in sizes)
        texts = [component.text(name) for name in ("catalogue_designation", "name")]
        return bearing_of_dimensions(
            component.text("bearing_type"), boundary
        ) or bearing_of_designation((*texts, component.name))

    def _with_thrust(
        self, component: Component, found: dict[str, Plain], sense: float
    ) -> dict[str, Plain]:
        """Let the rolling elements carry the thrust too, if they can."""
        if "degrees_of_freedom" in found:
            return found
        bearing = RollingBearing("", 0.0, **found)
        angle, estimate = bearing.contact_angle, bearing.estimate
        if angle is None:
            angle = 0.0 if estimate is None else estimate.contact_angle
        rollers = bearing.contact == "roller" or (estimate and estimate.roller_length is not None)
        if rollers and angle == 0.0:
            return found
        # A positive angle carries a load of the shaft along +x.
        if component.text("axial_force_absorption") == "negative":
            sense = -sense
        angle = math.copysign(angle, sense) if angle else 0.0
        return {**found, "degrees_of_freedom": 5, "contact_angle": angle}

    def _values(self, given: object, carries: tuple[str, ...], path: str) -> dict[str, Plain]:
        """Give the parameters that are given for a bearing."""
        if given is None or (isinstance(given, str) and given == CATALOGUE):
            return {}
        if not isinstance(given, Mapping):
            return dict.fromkeys(carries, number(given, path))
        for key in ("shaft", "position", "support"):
            if key in given:
                raise SceneError(f"{path}: the file has its {key}; leave it out")
        found = dict(given)
        if found.get("pads") is not None:
            found["pads"] = [
                {key: value for key, value in vars(each).items() if value is not None}
                if isinstance(each, Pad)
                else each
                for each in found["pads"]
            ]
        return found

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
        if "elements" in found and not _CATALOGUED & found.keys():
            keys = ("element_diameter", "pitch_diameter", "clearance")
            if found.get("contact") == "roller":
                keys = (*keys, "roller_length")
        elif _LAWS & found.keys():  # the core checks the other values
            keys = ()
        if found.get("degrees_of_freedom") == 5:
            return tuple(key for key in keys if key not in found)
        helical = any(
            gear["shaft"] == shaft and "helix_angle" in gear for gear in self._description["gears"]
        )
        if helical and "axial_stiffness" in carries:
            keys = (*keys, "axial_stiffness")
        return tuple(key for key in keys if key not in found)

    def _stiffness(self, component: Component, argument: str) -> dict[str, Plain]:
        """Give the stiffnesses of the file that are neither zero nor rigid."""
        found: dict[str, Plain] = {}
        for each in STIFFNESSES:
            key = each.bearing if argument == "bearings" else each.coupling
            if key and component.has(each.file):
                value = component.number(each.file, f"couplings.{each.coupling}")
                if value > 0.0 and (value < each.rigid or argument == "couplings"):
                    found[key] = min(value, each.rigid)
                elif key == "tilting_stiffness" and value > 0.0:
                    self._notes.append(
                        f"{component}: its {each.file} {value:g} N m/rad means rigid and is left "
                        "out"
                    )
            elif key and component.kind == "fixed_coupling":
                found[key] = each.rigid
        return found

    def _operating(self, component: Component, placed: PlacedShaft) -> list[list[float]]:
        """Give the radial stiffness at the operating point, as a matrix along y and z."""
        matrix = np.array(
            [
                [component.number(OPERATING.format(i, j), "bearings.stiffness", 0.0) for j in "vw"]
                for i in "vw"
            ]
        )
        turn = np.eye(2)
        if placed.frame is not None:
            turn = (placed.frame.axes @ self._shafts.reference.axes.T)[1:, 1:]
        found: list[list[float]] = (turn.T @ matrix @ turn).tolist()
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
        pairs = self._file.assembled()
        return [part for part, owner in pairs if owner is whole and part.kind == kind]

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


def _ends(joint: _Joint) -> tuple[Component, Component, Component]:
    return joint.component, joint.inner, joint.outer


def _has_law(values: Mapping[str, Plain]) -> bool:
    """Tell whether values give all of the radial law; others go over an estimate."""
    return bool(_LAWS & values.keys()) or values.keys() >= _ELEMENTS


def _described(bearing: Mapping[str, Plain]) -> str:
    """Describe a bearing in a few words."""
    between = f', on "{support[0]}"' if isinstance(support := bearing.get("support"), list) else ""
    if "viscosity" in bearing:
        kind = "TiltingPadBearing" if "pad_count" in bearing else "JournalBearing"
        return f"{kind}{between}"
    if not {"elements", *_CATALOGUED} & bearing.keys():
        stiffness = bearing["stiffness"]
        text = f"{stiffness:g} N/m" if isinstance(stiffness, (int, float)) else "given stiffness"
        return f"Bearing, {text}{between}"
    alone = {key: value for key, value in bearing.items() if key != "support"}
    estimate = RollingBearing(**alone).estimate
    known = {} if estimate is None else vars(estimate)
    elements, diameter = (
        bearing.get(key, known.get(key)) for key in ("elements", "element_diameter")
    )
    kind = "" if estimate is None else f" {estimate.kind.replace('_', ' ')},"
    error = "" if estimate is None else f", estimated within {estimate.stiffness_uncertainty:.0%}"
    size = f"{1e3 * float(diameter):.3g} mm" if isinstance(diameter, (int, float)) else "no size"
    return f"RollingBearing,{kind} {elements} elements of {size}{error}{between}"


def _torsional(given: object, path: str) -> dict[str, Plain]:
    """Give the parameters of a coupling; a number is its torsional stiffness."""
    if isinstance(given, Mapping):
        return dict(given)
    return {"torsional_stiffness": number(given, path)}


def check_given(given: object, argument: str) -> Mapping[str, object]:
    """Check the values that are given by name."""
    if given is None or (isinstance(given, str) and given == CATALOGUE and argument == "bearings"):
        return {}
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise SceneError(f"{argument}: must be a mapping of names to values, got {shown(given)}")
    return given
