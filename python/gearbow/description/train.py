"""Parts of a system made from its plain description, and numbers in a description by their path.

A path is, for example, "shafts['input'].segments[1].outer_diameter".
"""

import dataclasses
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, TypeAlias, get_args, get_type_hints

import numpy as np

from gearbow._convert import nearest, nodal, shown, text
from gearbow._core import Model, shaft_motion, shaft_origins
from gearbow._shown import ReadOnly
from gearbow._types import Array, ComplexArray, Plain
from gearbow.description.coordinates import drawn_positions
from gearbow.description.gears import Disk, Gear, Mesh
from gearbow.description.layout import Layout, layout
from gearbow.description.loads import AnyBearing, Coupling, Drive, Force, Torque
from gearbow.description.part import Part, made
from gearbow.description.places import Housing, Support
from gearbow.description.shafts import Notch, Shaft, Sleeve
from gearbow.errors import AccuracyWarning, SceneError
from gearbow.units.fields import unit_of

#: Classes of the parts of each list of a system.
PARTS: dict[str, tuple[type[Part], ...]] = {
    "shafts": (Shaft,),
    "gears": (Gear,),
    "meshes": (Mesh,),
    "bearings": get_args(AnyBearing),
    "torques": (Torque,),
    "disks": (Disk,),
    "supports": (Support,),
    "housings": (Housing,),
    "couplings": (Coupling,),
    "drives": (Drive,),
    "forces": (Force,),
    "sleeves": (Sleeve,),
    "notches": (Notch,),
}


def parts_of(description: Mapping[str, Plain]) -> dict[str, tuple[Any, ...]]:
    """Make the parts of a system from its plain description."""
    return {
        key: tuple(made(kinds, part) for part in description.get(key, ()))
        for key, kinds in PARTS.items()
    }


@dataclass(frozen=True, eq=False)
class Train(ReadOnly):
    """A train at rest: parts, positions, senses of rotation and bows."""

    parts: Mapping[str, tuple[Any, ...]]
    layout: Layout
    ratios: Mapping[str, float]
    #: Positions [m] and deflections y + iz [m] of each bowed shaft.
    bows: Mapping[str, tuple[Array, ComplexArray]]

    @classmethod
    def of(cls, description: Mapping[str, Plain], ratios: Array) -> "Train":
        """Make the train of a plain description."""
        parts = parts_of(description)
        lists: Any = SimpleNamespace(**parts)
        bowed = [shaft.name for shaft in parts["shafts"] if shaft.bow is not None]
        return cls(
            parts=parts,
            layout=layout(lists, shaft_origins(description)),
            ratios={s.name: float(r) for s, r in zip(parts["shafts"], ratios, strict=True)},
            bows={name: _bow(description, name) for name in bowed},
        )


def _bow(description: Mapping[str, Plain], name: str) -> tuple[Array, ComplexArray]:
    """Give positions and deflections of a bowed shaft, from a model of this shaft alone."""
    own: dict[str, list[Plain]] = {
        key: [part for part in description.get(key, ()) if part["shaft"] == name]
        for key in ("gears", "disks", "bearings", "sleeves")
    }
    # Of the bearings, also of those that stand on the shaft, a sag depends on the positions only.
    positions = [bearing["position"] for bearing in own["bearings"]]
    bases = [bearing.get("support") for bearing in description.get("bearings", ())]
    positions += [base[1] for base in bases if isinstance(base, list) and base[0] == name]
    own["bearings"] = [{"shaft": name, "position": x, "stiffness": 1e8} for x in positions]
    shafts = (shaft for shaft in description["shafts"] if shaft["name"] == name)
    own["shafts"] = [{**shaft, "speed_ratio": 1.0} for shaft in shafts]
    model = Model({**own, "motion": "lateral"})
    with warnings.catch_warnings():
        # The conditioning of the modes does not affect the bow.
        warnings.simplefilter("ignore", AccuracyWarning)
        bow = model.synchronous(np.empty(0), "bow", 1)["bow"].real
    nodes = list(dict.fromkeys(x for _, x, _ in nodal(model.dofs)))
    positions = drawn_positions(nodes)
    rows = shaft_motion(model.resolved(), name, positions)
    return np.array(positions), rows["v"] @ bow + 1j * (rows["w"] @ bow)


#: Options of a system that are numbers.
_OPTIONS = ("modal_damping", "rayleigh", "gravity")
#: A step of a path: a field, the number of an entry or "*" for all entries, or a name in quotes.
_STEP = re.compile(r"\.?([A-Za-z_]\w*)|\[(\d+|\*)\]|\[(?:'([^']*)'|\"([^\"]*)\")\]")
#: A name in quotes, which the unit of a field does not depend on.
_NAME = re.compile(r"\[(?:'[^']*'|\"[^\"]*\")\]")
#: A field or a name, the number of an entry, or all entries.
_Step: TypeAlias = str | int | slice
_ALL = slice(None)
#: Gives the entry of a list of parts or the option of a system with this name.
Entry = Callable[[str], Any]


@dataclass(frozen=True)
class Parameter:
    """The path of a number in a system: a list of parts or an option, and the steps from there."""

    path: str
    key: str
    steps: tuple[_Step, ...]
    value: float
    unit: str

    @classmethod
    def find(cls, entry: Entry, path: object, where: str, *, several: bool = False) -> "Parameter":
        """Find a number by its path; with `several`, "[*]" means the number of every entry."""
        written = text(path, where)
        first, *steps = _steps(written, where, several=several)
        names = (*PARTS, *_OPTIONS)
        if first not in names:
            near = nearest(str(first), names)
            known = ", ".join(names)
            raise SceneError(f"{where}: {written!r} must begin with one of {known}{near}")
        found = _found(entry(str(first)), steps, where, str(first))
        field = _NAME.sub("", found.place)
        return cls(written, str(first), tuple(steps), found.value, unit_of(field) or "1")

    def changed(self, owner: Any, value: float) -> Any:
        """Give the list of parts or the option with another value of this number."""
        return _changed(owner, self.steps, value)


@dataclass(frozen=True)
class _Number:
    """A number with its place in the system."""

    value: float
    place: str


def _found(owner: Any, steps: Sequence[_Step], where: str, at: str, kind: Any = None) -> _Number:
    """Follow steps to a number; through all entries of a list to that of the first one."""
    if not steps:
        return _Number(_number(owner, kind, f"{where}: {at}"), at)
    step, rest = steps[0], steps[1:]
    if step == _ALL and _is_list(owner) and len(owner):
        # Every entry must have the number.
        first, *_ = [_found(each, rest, where, f"{at}[{i}]") for i, each in enumerate(owner)]
        return first
    inner, kind = _inner(owner, step, f"{where}: {at}"), _type_of(owner, step)
    is_field = isinstance(step, str) and kind is not None
    return _found(inner, rest, where, f"{at}.{step}" if is_field else at + _bracketed(step), kind)


def _bracketed(step: _Step) -> str:
    return "[*]" if step == _ALL else f"[{step!r}]"


def _steps(path: str, where: str, *, several: bool) -> list[_Step]:
    """Take a path apart."""
    found: list[_Step] = []
    end = 0
    while end < len(path) and (step := _STEP.match(path, end)):
        field, number, *quoted = step.groups()
        name = field if field is not None else quoted[0] if quoted[0] is not None else quoted[1]
        found.append(name if number is None else _ALL if number == "*" else int(number))
        end = step.end()
    if end < len(path) or not found or (_ALL in found and not several):
        raise SceneError(
            f'{where}: must be a path such as "bearings[0].stiffness" or '
            f"\"shafts['input'].outer_diameter\", got {shown(path)}"
        )
    return found


def _inner(value: Any, step: _Step, at: str) -> Any:
    """Give a field of a part, or an entry of a list or mapping."""
    wanted = repr(step) if isinstance(step, str) else _bracketed(step)
    if dataclasses.is_dataclass(value):
        known = [field.name for field in dataclasses.fields(value) if field.name != "_"]
        if step in known:
            return getattr(value, str(step))
    elif isinstance(value, Mapping):
        known = [str(key) for key in value]
        if step in known:
            return value[step]
    elif _is_list(value):
        if isinstance(step, int) and step < len(value):
            return value[step]
        named = [str(each.name) for each in value if getattr(each, "name", None) is not None]
        if step in named:
            return value[_place(value, step)]
        known = [repr(name) for name in named] or [
            f"[0] to [{len(value) - 1}]" if len(value) else "none"
        ]
    else:
        raise SceneError(f"{at}: has no {wanted}; it is {shown(value)}")
    near = nearest(step, known) if isinstance(step, str) else ""
    raise SceneError(f"{at}: has no {wanted}, only {', '.join(known)}{near}")


def _place(values: Sequence[Any], step: str | int) -> int:
    """Give the number of an entry of a list, which can be given by its name."""
    if isinstance(step, int):
        return step
    return [getattr(each, "name", None) for each in values].index(step)


def _type_of(owner: Any, step: _Step) -> Any:
    """Give the type of a field of a part; None for entries of lists and mappings."""
    return get_type_hints(type(owner))[str(step)] if dataclasses.is_dataclass(owner) else None


def _is_list(value: Any) -> bool:
    return isinstance(value, list | tuple | np.ndarray)


def _number(value: Any, kind: Any, at: str) -> float:
    """Check that the value is a real number that can change continuously."""
    if value is None:
        raise SceneError(f"{at}: is not given; give the system a number there")
    if kind is int or (kind is not None and int in get_args(kind) and float not in get_args(kind)):
        raise SceneError(f"{at}: is a whole number, which has no derivative, got {shown(value)}")
    number = isinstance(value, int | float | np.floating | np.integer)
    if isinstance(value, bool) or not number:
        inner = ""
        if dataclasses.is_dataclass(value):
            own = (field.name for field in dataclasses.fields(value))
            inner = f"; continue with one of {', '.join(f'.{name}' for name in own)}"
        elif isinstance(value, Mapping):
            inner = f"; continue with one of {', '.join(f'[{key!r}]' for key in value)}"
        elif _is_list(value):
            inner = f"; continue with [0] to [{len(value) - 1}]" if len(value) else ""
        raise SceneError(f"{at}: must be one real number, got {shown(value)}{inner}")
    return float(value)


def _changed(owner: Any, steps: tuple[_Step, ...], value: float) -> Any:
    if not steps:
        return value
    step, rest = steps[0], steps[1:]
    if dataclasses.is_dataclass(owner) and not isinstance(owner, type):
        name = str(step)
        return replace(owner, **{name: _changed(getattr(owner, name), rest, value)})
    if isinstance(owner, Mapping):
        return {**owner, step: _changed(owner[step], rest, value)}
    if isinstance(step, slice):
        return [_changed(each, rest, value) for each in owner]
    at = _place(owner, step)
    entries = list(owner)
    entries[at] = _changed(entries[at], rest, value)
    return entries
