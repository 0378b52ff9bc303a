"""Rolling bearings of other programs: what their type, dimensions and designation say."""

import math
import re
from collections.abc import Iterable

from gearbow._types import Plain
from gearbow.description.rolling import RollingBearing, RollingEstimate
from gearbow.errors import SceneError

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
