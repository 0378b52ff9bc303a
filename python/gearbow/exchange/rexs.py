"""Gear units of REXS: the plain description of a train, what to add to it, and its load cases."""

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gearbow._convert import whole
from gearbow._files import parsing
from gearbow._shown import Shown, Table
from gearbow._types import Plain
from gearbow.description.places import unique
from gearbow.errors import SceneError
from gearbow.exchange.rexs_file import (
    Component,
    PlacedShaft,
    RexsFile,
    Shafts,
    read_rexs_file,
    segment,
)
from gearbow.exchange.rexs_joints import Joints, MissingValue, check_given
from gearbow.exchange.rexs_planetary import Planets, with_orbits
from gearbow.units.speed import PER_MINUTE, as_given, speed_text

#: Components that gearbow cannot represent, and why. The first that a file has is reported.
_REFUSED = {
    "bevel_gear": "gearbow has spur and helical gears on parallel shafts",
    "worm_gear": "gearbow has spur and helical gears on parallel shafts",
    "worm_wheel": "gearbow has spur and helical gears on parallel shafts",
    "general_gear": "gearbow has spur and helical gears on parallel shafts",
}
#: Components that are read, or that have no influence on a model of gearbow: strength, lubrication,
#: tools, and flank modifications below the size of the teeth.
_KNOWN = re.compile(
    "gear_unit|gear_casing|assembly_group|material|lubricant|shaft|shaft_section|cylindrical_gear|"
    "ring_gear|"
    "cylindrical_stage|external_load|additional_mass|(?!radial_plain).*bearing.*|rolling_element|.*coupling|"
    ".*(_flank|_geometry|gear_data|_tool|_settings|_relief|_crowning|_slope|_deviation|_twist|"
    "_modification|_data_set|_list|_curve|_point|_contact)|notch.*|.*groove|v_notch|shaft_shoulder.*|"
    ".*_datum_face|transverse_bore|root"
)
#: Largest difference of a distance or diameter that is not reported [m].
_SAME_LENGTH = 1e-6
#: Acceleration if the file asks for gravity and does not give it, ISO 80000-3 [m/s²].
_STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True)
class LoadCase(Shown):
    """A load case of a REXS file.

    Attributes
    ----------
    number : int
        Number in the order of the file, from 1.
    speed : float or None
        Speed of the reference shaft [rad/s]; None if the file has none. Results show it in 1/min.
    torques : dict of str to float
        The given torques, positive about +x [N m], by the name of the load.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.results.LoadCase(1, speed=150.0, torques={"input": 50.0}).torques["input"]
    50.0
    """

    number: int
    speed: float | None
    torques: dict[str, float]

    def __str__(self) -> str:
        speed = "no speed" if self.speed is None else speed_text(self.speed, PER_MINUTE)
        torques = [f'"{name}" {torque:.6g} N m' for name, torque in self.torques.items()]
        return f"load case {self.number}: {', '.join([speed, *torques])}"


@dataclass(frozen=True)
class RexsContents(Shown):
    """What a REXS file contains, and what must be added to it.

    Attributes
    ----------
    application, version : str
        Program and version that wrote the file, and version of REXS.
    reference : str
        Name of the reference shaft, whose speed the load cases give.
    load_cases : tuple of LoadCase
        The load cases.
    missing : tuple of MissingValue
        Values that the file does not contain and gearbow needs.
    notes : tuple of str
        What gearbow assumes or leaves out.
    bearings : dict of str to str
        What each bearing becomes, by its name.

    Examples
    --------
    >>> import gearbow as gb
    >>> case = gb.results.LoadCase(1, speed=100.0, torques={"input": 50.0})
    >>> print(gb.results.RexsContents("example 1", "1.4", "input", (case,), (), ()))
    load case 1: 954.93 rpm, "input" 50 N m
    """

    application: str
    version: str
    reference: str
    load_cases: tuple[LoadCase, ...]
    missing: tuple[MissingValue, ...]
    notes: tuple[str, ...]
    bearings: dict[str, str] = field(default_factory=dict)

    def table(self) -> str:
        """Format the load cases, what to add, the bearings, and the notes as text.

        Returns
        -------
        str
            One line for each.
        """
        lines = [str(case) for case in self.load_cases]
        lines += [f"to add: {each}" for each in self.missing]
        missing = [each.name for each in self.missing]
        lines += [
            f'bearing "{name}": {text}'
            for name, text in self.bearings.items()
            if name not in missing
        ]
        lines += [f"note: {note}" for note in self.notes]
        return "\n".join(lines)

    def _rows(self) -> Table:
        rows = (tuple(line.split(": ", 1)) for line in self.table().splitlines())
        return (("", ""), *((head, text) for head, text in rows))

    def __str__(self) -> str:
        return self.table()


def read_rexs(
    path: str | os.PathLike[str],
    load_case: int | None = None,
    bearings: Mapping[str, object] | str | None = None,
    couplings: Mapping[str, object] | None = None,
) -> tuple[dict[str, Plain], RexsContents]:
    """Read a gear unit: its description, without what is missing, and its contents."""
    given = [check_given(bearings, "bearings"), check_given(couplings, "couplings")]
    number = None if load_case is None else whole(load_case, "load_case")
    with parsing(path, "a REXS file"):
        return _read(read_rexs_file(path), number, given)


def _read(
    file: RexsFile, number: int | None, given: Sequence[Any]
) -> tuple[dict[str, Plain], RexsContents]:
    """Give the description of a file, and its contents."""
    for kind, reason in _REFUSED.items():
        for component in file.of_kind(kind):
            raise component.error(f"gearbow cannot represent it: {reason}")
    planets = Planets(file)
    train = _Train(file, planets)
    cases = file.load_cases or (file.components,)
    found = tuple(train.load_case(i, case) for i, case in enumerate(cases, start=1))
    description = train.description()
    joints = Joints(file, train.shafts, train.placed, description, train.notes, planets=planets)
    joints.add(*given)
    planets.add(description, train.shafts, train.placed, train.notes)
    kinds = {each.kind for each in file.components.values()} - planets.kinds
    unknown = {kind for kind in kinds if not _KNOWN.fullmatch(kind)}
    if unknown:
        train.notes.append(f"components of these types are left out: {', '.join(sorted(unknown))}")
    if number is not None and number > len(cases):
        raise SceneError(f"load_case: must be 1 to {len(cases)} for {file.path}, got {number}")
    train.add_loads(description, cases[(number or 1) - 1])
    planets.leave_bending_out(description, train.notes)
    reference = train.placed[train.reference.id].name
    contents = RexsContents(
        *(file.application, file.version, reference, found),
        *(tuple(joints.missing), tuple(dict.fromkeys(train.notes)), joints.becomes),
    )
    return {key: value for key, value in description.items() if value not in ([], None)}, contents


def read_system(
    path: str | os.PathLike[str],
    load_case: int | None,
    bearings: Mapping[str, object] | str | None,
    couplings: Mapping[str, object] | None,
) -> tuple[dict[str, Plain], RexsContents]:
    """Read a gear unit of which nothing is missing."""
    description, contents = read_rexs(path, load_case, bearings, couplings)
    if load_case is None and len(contents.load_cases) > 1:
        first, *_, last = contents.load_cases
        note = f"{first} acts; load_case chooses another one, up to {last.number}"
        contents = replace(contents, notes=(note, *contents.notes))
    if contents.missing:
        missing = "; ".join(str(each) for each in contents.missing)
        name, argument = contents.missing[0].name, contents.missing[0].argument
        raise SceneError(
            f'{path}: does not contain, give it for example with {argument}={{"{name}": 1e8}}: '
            f"{missing}"
        )
    return with_orbits(description), contents


def rexs_contents(path: str | os.PathLike[str]) -> RexsContents:
    """List what a REXS file contains, and what must be added to make a system of it.

    Parameters
    ----------
    path : str or path-like
        A file of version 1.0 to 2.0: ``.rexs``, ``.rexsj`` (JSON), ``.rexsz`` or ``.zip``.

    Returns
    -------
    RexsContents
        Load cases, missing values, notes, and what each bearing becomes.

    Raises
    ------
    SceneError
        If the file is damaged, or has a component that gearbow cannot represent.

    See Also
    --------
    RotorSystem.read_rexs : Make a system.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import gearbow as gb
    >>> sizes = {"u_coordinate_on_shaft": 0, "length": 200}
    >>> sizes |= {"outer_diameter_begin": 40, "outer_diameter_end": 40}
    >>> lines = [f'<attribute id="{name}" unit="mm">{x}</attribute>' for name, x in sizes.items()]
    >>> model = (
    ...     '<model version="1.4" applicationId="example"><relations>'
    ...     '<relation id="1" type="assembly">'
    ...     '<ref id="10" role="assembly"/><ref id="20" role="part"/></relation></relations>'
    ...     '<components><component id="10" type="shaft" name="input"/>'
    ...     f'<component id="20" type="shaft_section">{"".join(lines)}</component>'
    ...     "</components></model>"
    ... )
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "shaft.rexs")
    ...     count = file.write_text(model)
    ...     contents = gb.rexs_contents(file)
    >>> contents.reference
    'input'
    """
    return read_rexs(path)[1]


class _Train:
    """Shafts, gears, meshes and loads of a file as a plain description."""

    def __init__(self, file: RexsFile, planets: Planets) -> None:
        self._file = file
        self.notes: list[str] = []
        self._names: set[str] = set()
        self._without_material: list[str] = []
        #: The shaft that carries each part.
        self._carrier = {
            part.id: whole.id for part, whole in file.assembled() if whole.kind == "shaft"
        }
        shafts = [each for each in self._file.of_kind("shaft") if each.id not in planets.left_out]
        if not shafts:
            raise file.error("has no shaft")
        self.reference = self._reference(shafts)
        self.shafts = Shafts(file, self.reference, self.notes)
        self.placed = {shaft.id: self._place(shaft) for shaft in shafts}
        self._gear_names: dict[int, str] = {}

    def _reference(self, shafts: list[Component]) -> Component:
        """Find the shaft whose speed the file defines; the first without one."""
        case = self._file.load_cases[0] if self._file.load_cases else self._file.components
        defining = [shaft for shaft in shafts if case[shaft.id].flag("defines_speed")]
        with_speed = [shaft for shaft in shafts if case[shaft.id].has("rotational_speed")]
        return (defining or with_speed or shafts)[0]

    def _place(self, shaft: Component) -> PlacedShaft:
        sections = [
            each
            for each in self._file.of_kind("shaft_section")
            if self._carrier.get(each.id) == shaft.id
        ]
        return self.shafts.place(shaft, self._named(shaft), sections)

    def _named(self, component: Component) -> str:
        given = component.name or f"{component.kind} {component.id}"
        name = unique(given, component.id, self._names)
        self._names.add(name)
        return name

    def _on(self, component: Component) -> PlacedShaft:
        """Find the shaft that carries a component."""
        if component.id not in self._carrier:
            raise component.error("no relation of the type assembly puts it on a shaft")
        return self.placed[self._carrier[component.id]]

    def description(self) -> dict[str, Any]:
        """Describe everything but bearings, couplings and loads."""
        shafts = [self._shaft(placed) for placed in self.placed.values()]
        kinds = ("cylindrical_gear", "ring_gear")
        gears = [self._gear(gear) for kind in kinds for gear in self._file.of_kind(kind)]
        by_name = {gear["name"]: gear for gear in gears}
        if self._without_material:
            names = ", ".join(f'"{name}"' for name in self._without_material)
            self.notes.append(f"no material in the file for {names}: it is steel of 207 GPa")
        return {
            "shafts": shafts,
            "reference": self.placed[self.reference.id].name,
            "gears": gears,
            "meshes": [self._mesh(refs, by_name) for refs in self._file.related("stage")],
            "disks": [self._disk(each) for each in self._file.of_kind("additional_mass")],
            **{key: [] for key in ("bearings", "couplings", "torques", "forces")},
            "gravity": self._gravity(),
        }

    def _shaft(self, placed: PlacedShaft) -> dict[str, Plain]:
        shaft = placed.component
        described: dict[str, Plain] = {"name": placed.name}
        segments = [segment(each, placed.sense) for each, _, _ in placed.sections]
        described["segments"] = segments
        default = self._material(shaft)
        materials = [self._material(each) or default for each, _, _ in placed.sections]
        # A section without a material is steel, and so is then the material of the shaft.
        common = None if None in materials else materials[0]
        if common is None:
            self._without_material.append(placed.name)
        else:
            described["material"] = common
        for each, material in zip(segments, materials, strict=True):
            if material != common:
                each["material"] = material
        return described

    def _material(self, component: Component) -> dict[str, Plain] | None:
        for refs in self._file.related("reference"):
            material = refs.get("referenced")
            if material and material.kind == "material" and refs.get("origin") is component:
                return {
                    "youngs_modulus": material.number("elastic_modulus", "youngs_modulus"),
                    "density": material.number("density", "density"),
                    "poisson_ratio": material.number("poisson_ratio", "poisson_ratio"),
                }
        return None

    def _gear(self, gear: Component) -> dict[str, Plain]:
        placed = self._on(gear)
        # The numbers of teeth and diameters of an internal gear may be negative, as in ISO 21771.
        teeth = gear.count("number_of_teeth")
        internal = teeth < 0 or gear.kind == "ring_gear"
        name = self._gear_names[gear.id] = self._named(gear)
        module = gear.number("normal_module", "module")
        found: dict[str, Plain] = {
            "name": name,
            "shaft": placed.name,
            "position": self.shafts.locate(gear, placed, "u_coordinate_on_shaft"),
            "teeth": abs(teeth),
            "module": module,
        }
        if internal:
            found["internal"] = True
        if gear.has("face_width"):
            found["face_width"] = gear.number("face_width", "face_width")
        helix = gear.number("helix_angle_reference_diameter", "helix_angle", 0.0)
        if helix != 0.0:
            found["helix_angle"] = helix
        pressure, shift = self._flanks(gear, module)
        found["pressure_angle"] = pressure
        if shift != 0.0:
            found["profile_shift"] = shift
        if gear.has("tip_diameter"):
            tip = 0.5 * abs(gear.number("tip_diameter", "outer_diameter"))
            transverse = math.atan2(math.tan(pressure), math.cos(helix))
            base = 0.5 * abs(teeth) * module * math.cos(transverse) / math.cos(helix)
            if tip > base:
                found["tip_radius"] = tip
            else:
                self.notes.append(
                    f"{gear}: tip_diameter {2e3 * tip:g} mm is left out, because the base circle "
                    f"has {2e3 * base:.6g} mm"
                )
        return found

    def _flanks(self, gear: Component, module: float) -> tuple[float, float]:
        """Give pressure angle and profile shift coefficient, which both flanks must share."""
        flanks = [
            refs[side]
            for refs in self._file.related("flank")
            for side in ("left", "right")
            if refs.get("gear") is gear and side in refs
        ]
        pressure = self._shared(gear, flanks, "normal_pressure_angle", "pressure_angle")
        shift = self._shared(gear, flanks, "addendum_modification_coefficient", "profile_shift")
        if shift is None:
            length = self._shared(gear, flanks, "addendum_modification", "length")
            shift = None if length is None else length / module
        if pressure is None:
            self.notes.append(f"{gear}: no normal_pressure_angle in the file; it is 20°")
        if shift is None:
            self.notes.append(f"{gear}: no addendum modification in the file; it is 0")
        return math.radians(20.0) if pressure is None else pressure, shift or 0.0

    def _shared(
        self, gear: Component, flanks: list[Component], name: str, path: str
    ) -> float | None:
        found = {flank.number(name, path) for flank in (*flanks, gear) if flank.has(name)}
        if len(found) > 1:
            raise gear.error(f"{name} of both flanks must be equal")
        return found.pop() if found else None

    def _mesh(self, refs: Mapping[str, Component], gears: dict[str, Any]) -> dict[str, Plain]:
        try:
            stage, *pair = (refs[role] for role in ("stage", "gear_1", "gear_2"))
        except KeyError as error:
            raise self._file.error(f"a relation of the type stage has no {error}") from None
        for gear in pair:
            if gear.id not in self._gear_names:
                raise stage.error(f"{gear} is not a cylindrical_gear")
        first, second = (self._on(gear) for gear in pair)
        driver, driven = (self._gear_names[gear.id] for gear in pair)
        found: dict[str, Plain] = {"driver": driver, "driven": driven}
        distance = abs(stage.number("center_distance", "centre_distance", 0.0))
        angle = None
        if stage.has("rotating_angle_around_neg_u_axis"):
            turn = stage.number("rotating_angle_around_neg_u_axis", "phase")
            angle = math.remainder(0.5 * math.pi - turn, 2.0 * math.pi)
        if first.axis is not None and second.axis is not None:
            y, z = (second.axis - first.axis).tolist()
            between = math.hypot(y, z)
            if distance > 0.0 and abs(between - distance) > _SAME_LENGTH:
                self.notes.append(
                    f"{stage}: center_distance {1e3 * distance:.6g} mm is used; the shafts are "
                    f"{1e3 * between:.6g} mm apart"
                )
            distance, angle = distance or between, math.atan2(z, y)
        if angle is None:
            self.notes.append(f"{stage}: no direction of the centre line in the file; it is y")
        found["centre_line_angle"] = angle or 0.0
        if distance > 0.0:
            found["centre_distance"] = distance
        self._check_planes(stage, (first, second), [gears[name] for name in (driver, driven)])
        return found

    def _check_planes(
        self, stage: Component, placed: tuple[PlacedShaft, PlacedShaft], pair: list[Any]
    ) -> None:
        """Report gears whose middles lie in different planes, which gearbow does not need."""
        reference = self.shafts.reference
        middles: list[float] = []
        for shaft, gear in zip(placed, pair, strict=True):
            if shaft.frame is None:
                return
            offset = float(reference.axes[0] @ (shaft.frame.origin - reference.origin))
            middles.append(offset - shaft.position(0.0) + gear["position"])
        distance = abs(middles[0] - middles[1])
        if distance > _SAME_LENGTH:
            self.notes.append(
                f"{stage}: the middles of its gears are {1e3 * distance:.4g} mm apart along the "
                "shafts; the mesh force acts in the middle of each gear"
            )

    def _disk(self, mass: Component) -> dict[str, Plain]:
        placed = self._on(mass)
        return {
            "name": self._named(mass),
            "shaft": placed.name,
            "position": self.shafts.locate(mass, placed, "u_coordinate_on_shaft"),
            "mass": mass.number("mass_of_component", "mass"),
            "diametral_inertia": mass.number("moment_of_inertia_v_axis", "inertia"),
            "polar_inertia": mass.number("moment_of_inertia_u_axis", "inertia"),
        }

    def _gravity(self) -> list[float] | None:
        for unit in self._file.of_kind("gear_unit"):
            if not unit.flag("account_for_gravity"):
                continue
            names = [f"direction_vector_gravity_{axis}" for axis in "uvw"]
            along = np.array([unit.number(name, "teeth", 0.0) for name in names])
            size = math.hypot(*along.tolist())
            if size == 0.0:
                raise unit.error(f"{names[0]}: gravity needs a direction")
            value = unit.number("gravitational_acceleration", "gravity", _STANDARD_GRAVITY)
            axes = np.eye(3) if (frame := self.shafts.frame(unit)) is None else frame.axes
            x, y, z = (value / size * (self.shafts.reference.axes @ axes.T @ along)).tolist()
            if abs(x) > 1e-6 * value:
                self.notes.append(f"{unit}: gravity along the shafts, {x:.4g} m/s², is left out")
            return [y, z]
        return None

    def load_case(self, number: int, case: Mapping[int, Component]) -> LoadCase:
        """Give speed and torques of a load case."""
        speed = self._speed(case)
        torques: dict[str, float] = {}
        for load in self._loads(case):
            torque = self._torque(load, speed)
            if torque is not None and torque != "balance":
                torques[unique(load.name or str(load), load.id, torques)] = torque
        return LoadCase(number, speed, torques)

    def _speed(self, case: Mapping[int, Component]) -> float | None:
        shaft = case[self.reference.id]
        if not shaft.has("rotational_speed"):
            return None
        # REXS has speeds in 1/min: results at this speed show them so.
        found: float = as_given(shaft.number("rotational_speed", "speed"), PER_MINUTE)
        return found

    def _loads(self, case: Mapping[int, Component]) -> list[Component]:
        return [each for each in case.values() if each.kind == "external_load"]

    def _torque(self, load: Component, speed: float | None) -> Any:
        """Give the torque of a load, "balance" if it follows from the others, or None."""
        placed = self._on(load)
        if load.flag("defines_torque") is not False:
            if load.has("torque_around_u_axis"):
                return placed.sense * load.number("torque_around_u_axis", "torques.value")
            if load.has("power"):
                if speed is None or speed == 0.0 or placed.component.id != self.reference.id:
                    raise load.error(
                        "its power needs the speed of its shaft, which only the reference shaft "
                        "has; give torque_around_u_axis"
                    )
                return load.number("power", "torques.value") / speed
        return "balance" if load.flag("transmits_torque") else None

    def add_loads(self, description: dict[str, Any], case: Mapping[int, Component]) -> None:
        """Add torques and forces of a load case."""
        speed = self._speed(case)
        for load in self._loads(case):
            placed = self._on(load)
            at = [placed.name, self.shafts.locate(load, placed, "u_coordinate_on_shaft")]
            torque = self._torque(load, speed)
            if torque is not None:
                value = {"balance": True} if torque == "balance" else {"value": torque}
                description["torques"].append({"at": at, **value})
            across = self.shafts.across(load, placed, ("force_v_direction", "force_w_direction"))
            axial = placed.sense * load.number("force_u_direction", "load", 0.0)
            if across != 0.0 or axial != 0.0:
                force = {"at": at, "value": [across.real, across.imag]}
                description["forces"].append(force | ({"axial": axial} if axial else {}))
            for axis in "vw":
                moment = load.number(f"torque_around_{axis}_axis", "torques.value", 0.0)
                if moment != 0.0:
                    self.notes.append(
                        f"{load}: torque_around_{axis}_axis {moment:g} N m is left out, gearbow "
                        "has no bending moments"
                    )
