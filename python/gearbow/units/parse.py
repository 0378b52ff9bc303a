"""Texts with a unit, such as "500 mm", "3 N/um" or "1500 rpm"."""

import math
import re
from fractions import Fraction
from functools import cache

from gearbow.errors import SceneError
from gearbow.units.fields import DIMENSIONLESS, unit_of

__all__ = ["OTHERS", "PREFIXES", "SIGNS", "WITH_PREFIX", "parsed"]

#: Exponents of m, kg and s.
_Dimension = tuple[int, int, int]

PREFIXES = {"": 0, "n": -9, "u": -6, "m": -3, "c": -2, "k": 3, "M": 6, "G": 9}
#: Exponent of ten and exponents of m, kg and s of units that take a prefix. Angles have no
#: dimension.
WITH_PREFIX: dict[str, tuple[int, _Dimension]] = {
    "m": (0, (1, 0, 0)),
    "g": (-3, (0, 1, 0)),
    "s": (0, (0, 0, 1)),
    "N": (0, (1, 1, -2)),
    "Pa": (0, (-1, 1, -2)),
    "Nm": (0, (2, 1, -2)),
    "J": (0, (2, 1, -2)),
    "rad": (0, (0, 0, 0)),
}
#: Factor, power of π and exponents of the other units.
OTHERS: dict[str, tuple[Fraction, int, _Dimension]] = {
    "1": (Fraction(1), 0, (0, 0, 0)),
    "%": (Fraction(1, 100), 0, (0, 0, 0)),
    "deg": (Fraction(1, 180), 1, (0, 0, 0)),
    "rev": (Fraction(2), 1, (0, 0, 0)),
    "rpm": (Fraction(1, 30), 1, (0, 0, -1)),
    "min": (Fraction(60), 0, (0, 0, 1)),
    "h": (Fraction(3600), 0, (0, 0, 1)),
    "t": (Fraction(1000), 0, (0, 1, 0)),
    "bar": (Fraction(100_000), 0, (-1, 1, -2)),
}
SIGNS = {"µ": "u", "μ": "u", "°": "deg", "·": " ", "*": " ", "²": "^2", "³": "^3"}
_TEXT = re.compile(r"([-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?)(?![\d.])\s*(\S.*)?", re.ASCII)
#: Most characters of a text with a unit; Python converts at most 4,300 digits to a whole number.
_LONGEST = 4000
_FACTOR = re.compile(r"([A-Za-z%]+|1)(?:\^\(?(-?\d)\)?)?")


def parsed(text: str, path: str, *, bare: bool = False) -> float:
    """Convert a text with a unit to SI units."""
    wanted = unit_of(path) or DIMENSIONLESS
    found = _TEXT.fullmatch(text.strip()) if len(text) <= _LONGEST else None
    if found is None:
        text = f"{text[:50]}…" if len(text) > _LONGEST else text
        raise SceneError(
            f"{path}: must be a number [{wanted}] or a text with a number and a unit, such as "
            f'"2.5 {wanted}", got {text!r}'
        )
    number, unit = float(found[1]), found[2]
    if unit is not None and unit[0] in ",_'":
        raise SceneError(
            f"{path}: must be a number with a decimal point and without other signs between its "
            f"digits, got {text!r}"
        )
    if unit is None:
        if bare:
            return number
        raise SceneError(
            f"{path}: the text {text!r} has no unit; write the number without quotes [{wanted}], "
            f'or with its unit, such as "{found[1]} {wanted}"'
        )
    factor, pi, dimension = _unit(unit, path)
    if dimension != _unit(wanted, path)[2]:
        raise SceneError(f"{path}: must have a unit that converts to {wanted}, got {text!r}")
    if number == 0.0 or math.isinf(number):
        return number  # a fraction would need very many digits
    try:
        return float(Fraction(found[1]) * factor) * math.pi**pi
    except OverflowError:
        return math.copysign(math.inf, number)  # the core rejects it


@cache
def _unit(text: str, path: str) -> tuple[Fraction, int, _Dimension]:
    """Read a product of units: factor, power of π and dimension."""
    factor, pi = Fraction(1), 0
    dimension = (0, 0, 0)
    plain = text.replace("**", "^")
    for sign, replacement in SIGNS.items():
        plain = plain.replace(sign, replacement)
    for word in re.findall(r"/?\s*[^\s/^]+(?:\^[^\s/]+)?|\S", plain):
        one = _FACTOR.fullmatch(word.lstrip("/ "))
        known = None if one is None else _single(one[1])
        if one is None or known is None:
            raise SceneError(f"{path}: {word.lstrip('/ ')!r} is not a known unit; {_known(word)}")
        power = int(one[2] or 1) * (-1 if word.startswith("/") else 1)
        factor *= known[0] ** power
        pi += known[1] * power
        a, b = dimension, known[2]
        dimension = (a[0] + power * b[0], a[1] + power * b[1], a[2] + power * b[2])
    return factor, pi, dimension


def _single(name: str) -> tuple[Fraction, int, _Dimension] | None:
    """Find one unit, with or without a prefix."""
    if name in OTHERS:
        return OTHERS[name]
    for unit, (ten, dimension) in WITH_PREFIX.items():
        prefix = name.removesuffix(unit)
        if name.endswith(unit) and prefix in PREFIXES:
            return Fraction(10) ** (ten + PREFIXES[prefix]), 0, dimension
    return None


def _known(word: str) -> str:
    """Say which units are known."""
    if "Hz" in word:
        return "a speed is in rad/s, rpm or rev/s"
    small = word.lstrip("/ ").lower()
    if _single(small) is not None:
        return f'did you mean "{small}"? Capital and small letters differ'
    return (
        f"known are {', '.join([*WITH_PREFIX, *(name for name in OTHERS if name != '1')])} and "
        f"the prefixes {' '.join(prefix for prefix in PREFIXES if prefix)}"
    )
