"""The SI unit of every field of a description and of every argument, and values with other units.

The table of fields is the only place that knows units. Quantities of pint, texts such as "500 mm"
in scene files, and speeds on the command line are converted with it. This module does not import
pint: a value can only be a quantity of pint if the user imported it.
"""

import math
import re
import sys
from collections.abc import Mapping
from functools import cache
from typing import Any

from gearbow.errors import SceneError

#: Unit of a field without a unit.
DIMENSIONLESS = "1"

#: (shaft, position) or ("bearing", shaft, position).
_PLACE = (None, "m", "m")

#: Unit of a motion, each the derivative of the one before with respect to time.
MOTIONS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s²"}
#: Unit of each quantity that a result has at a place.
QUANTITIES = {**MOTIONS, "twist": "rad", "axial_displacement": "m", "bearing_force": "N"}

#: Unit of each field by the end of its path, without indices. A longer end precedes a shorter one,
#: and `*` stands for any name. A tuple gives the unit of each entry of a list; None is a text.
FIELDS: dict[str, str | tuple[str | None, ...] | None] = {
    # Lengths and angles
    "length": "m",
    "outer_diameter": "m",
    "inner_diameter": "m",
    "end_outer_diameter": "m",
    "end_inner_diameter": "m",
    "axial_force": "N",
    "axial_preload": "N",
    "degrees_of_freedom": DIMENSIONLESS,
    "internal_damping": "s",
    "sleeves.begin": "m",
    "sleeves.end": "m",
    "sleeves.stiffness": DIMENSIONLESS,
    "notches.bending": DIMENSIONLESS,
    "notches.torsion": DIMENSIONLESS,
    "position": "m",
    "positions": "m",
    "amplitude": "m",
    "amplitudes": "m",
    "phase": "rad",
    "phases": "rad",
    "points.*": "m",
    # Materials and bodies
    "youngs_modulus": "Pa",
    "shear_modulus": "Pa",
    "density": "kg/m^3",
    "mass": "kg",
    "diametral_inertia": "kg m^2",
    "polar_inertia": "kg m^2",
    "inertia": "kg m^2",
    "unbalance": "kg m",
    "runout": "m",
    # Teeth
    "module": "m",
    "base_radius": "m",
    "tip_radius": "m",
    "face_width": "m",
    "pressure_angle": "rad",
    "helix_angle": "rad",
    "centre_line_angle": "rad",
    "tooth_angle": "rad",
    "centre_distance": "m",
    "backlash": "m",
    "amount": "m",
    "roughness": "m",
    "tooth": ("m", "rad"),
    "driver": ("m", "rad"),
    "driven": ("m", "rad"),
    "table": "m",
    # Stiffness and damping
    "stiffness": "N/m",
    "damping": "N s/m",
    "stiffnesses": "N/m",
    "stiffness.values": "N/m",
    "stiffness.mean": "N/m",
    "stiffness.pair": "N/m",
    "stiffness.amplitudes": "N/m",
    "stiffness.phase": None,
    "stiffness.bore_radii": "m",
    "damping.values": "N s/m",
    "axial_stiffness": "N/m",
    "axial_damping": "N s/m",
    "tilting_stiffness": "N m/rad",
    "tilting_damping": "N m s/rad",
    "rotational_stiffness": "N m/rad",
    "rotational_damping": "N m s/rad",
    "drives.stiffness": "N m/rad",
    "drives.damping": "N m s/rad",
    "lateral_stiffness": "N/m",
    "lateral_damping": "N s/m",
    "torsional_stiffness": "N m/rad",
    "torsional_damping": "N m s/rad",
    "offset": "m",
    "misalignment": "m",
    "pin_errors": "m",
    "angle": "rad",
    # Journal and rolling bearings
    "diameter": "m",
    "clearance": "m",
    "viscosity": "Pa s",
    "grooves": "rad",
    "orientation": "rad",
    "pad_extent": "rad",
    "pad_inertia": "kg m^2",
    "pad_mass": "kg",
    "pivot_stiffness": "N/m",
    "pads.begin": "rad",
    "pads.extent": "rad",
    "pads.offset": DIMENSIONLESS,
    "bearings.offset": DIMENSIONLESS,
    "bearing.offset": DIMENSIONLESS,
    "element_diameter": "m",
    "pitch_diameter": "m",
    "boundary": "m",
    "bore": "m",
    "outer": "m",
    "width": "m",
    "roller_length": "m",
    "contact_angle": "rad",
    "cage_angle": "rad",
    "dynamic_rating": "N",
    "static_rating": "N",
    # Loads
    "torques.value": "N m",
    "torques.value.values": "N m",
    "torques.value.slopes": "N m/s",
    "forces.value": "N",
    "forces.value.values": "N",
    "forces.value.slopes": "N/s",
    "axial": "N",
    "load": "N",
    "thrust": "N",
    "tilt": "rad",
    # Options of a system
    "modal_damping.frequencies": "rad/s",
    "modal_damping.ratios": DIMENSIONLESS,
    "rayleigh": ("1/s", "s"),
    "gravity": "m/s^2",
    # Columns of measured tables
    "measured.velocity": "m/s",
    "measured.acceleration": "m/s^2",
    "measured.displacement": "m",
    "measured.twist": "rad",
    # Arguments of analyses
    "speed": "rad/s",
    "speeds": "rad/s",
    "frequency": "rad/s",
    "frequencies": "rad/s",
    "speed.start": "rad/s",
    "speed.end": "rad/s",
    "operating": "rad/s",
    "spectrum.torque": "N m",
    "spectrum.share": DIMENSIONLESS,
    "noise": "m",
    "endurance_limit": "Pa",
    "tensile_strength": "Pa",
    "phase_angle": "rad",
    "time": "s",
    "duration": "s",
    "begin": "s",
    "start": "s",
    "step": "s",
    "steps": "s",
    "breaks": "s",
    "output_step": "s",
    "times": "s",
    "skip_time": "s",
    "checkpoint_interval": "s",
    "budget": "s",
    "highest": "1/s",
    **dict.fromkeys(("at", "a", "b", "record", "planes", "points", "support", "carrier"), _PLACE),
    **dict.fromkeys(("signals", "target"), _PLACE),
}


@cache
def _end(names: tuple[str, ...]) -> str | tuple[str | None, ...] | None:
    """Find the entry of the longest end of a path."""
    for i in range(len(names)):
        for end in (names[i:], (*names[i:-1], "*")):
            key = ".".join(end)
            if key in FIELDS:
                return FIELDS[key]
    return DIMENSIONLESS


def unit_of(path: str) -> str | None:
    """Give the SI unit of a field."""
    names = tuple(re.sub(r"\[\d+\]", "", path).split("."))
    found = _end(names)
    if not isinstance(found, tuple):
        return found
    index = re.search(r"\[(\d+)\]$", path)
    i = None if index is None else int(index[1])
    return None if i is None or i >= len(found) else found[i]


def is_frequency(path: str) -> bool:
    """Tell whether a field in rad/s is the frequency of a vibration, which may be in Hz."""
    return re.search(r"\b(frequency|frequencies)(\[\d+\])*$", path) is not None


def quantities_exist() -> bool:
    """Return whether pint is imported, without which no value is a quantity."""
    return "pint" in sys.modules


def is_quantity(value: object) -> bool:
    """Return whether a value is a quantity of pint."""
    pint = sys.modules.get("pint")
    return pint is not None and isinstance(value, pint.Quantity)


def has_quantity(value: object) -> bool:
    """Return whether a value is a quantity of pint, or a nested sequence with one."""
    if not quantities_exist():
        return False
    if isinstance(value, list | tuple):
        return any(has_quantity(item) for item in value)
    if isinstance(value, Mapping):
        return any(has_quantity(item) for item in value.values())
    return is_quantity(value)


def magnitude(quantity: Any, path: str) -> Any:
    """Convert a quantity of pint to the SI unit of its field."""
    pint = sys.modules["pint"]
    unit = unit_of(path)
    if unit is None:
        raise SceneError(f"{path}: must not be one quantity, got {quantity}")
    # pint converts 50 Hz to 50 rad/s, although 50 cycles or turns per second are 314 rad/s.
    if unit == "rad/s" and "hertz" in str(quantity.units):
        if is_frequency(path):
            return 2.0 * math.pi * quantity.to("Hz").magnitude
        raise SceneError(
            f"{path}: a speed in Hz is ambiguous, got {quantity}; give rad/s, rpm or turns/s"
        )
    try:
        return quantity.to("" if unit == "1" else unit).magnitude
    except pint.DimensionalityError:
        wanted = "have no unit" if unit == "1" else f"have a unit that converts to {unit}"
        raise SceneError(f"{path}: must {wanted}, got {quantity}") from None


def without_texts(plain: Mapping[str, Any]) -> dict[str, Any]:
    """Convert texts with a unit in a plain description, such as "500 mm", to SI units."""
    listed = plain.get("housings")
    parts = listed if isinstance(listed, list | tuple) else ()
    names = [each.get("name") for each in parts if isinstance(each, Mapping)]
    return {key: _without_texts(value, str(key), names) for key, value in plain.items()}


def _without_texts(plain: Any, path: str, housings: list[Any]) -> Any:
    """Convert the texts in an entry; the second one of (housing, interface) is a name."""
    if isinstance(plain, Mapping):
        return {key: _without_texts(item, f"{path}.{key}", housings) for key, item in plain.items()}
    if isinstance(plain, list | tuple):
        if path.endswith(".support") and plain and plain[0] in housings:
            return list(plain)
        return [_without_texts(item, f"{path}[{i}]", housings) for i, item in enumerate(plain)]
    if isinstance(plain, str) and unit_of(path) not in (None, "1"):
        from gearbow.units.parse import parsed  # noqa: PLC0415  # most descriptions have no texts

        return parsed(plain, path)
    return plain
