"""Texts with a unit, such as "500 mm", "3 N/um" or "1500 rpm"."""

import math
import re
from fractions import Fraction
from functools import cache

from gearbow.errors import SceneError
from gearbow.units.fields import DIMENSIONLESS, is_frequency, unit_of

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
#: Inch [m], pound [kg] and standard acceleration of gravity [m/s²]. All are exact: A. Thompson and
#: B. N. Taylor, NIST Special Publication 811 (2008), appendix B.
_INCH, _POUND, _GRAVITY = Fraction("0.0254"), Fraction("0.45359237"), Fraction("9.80665")
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
    "cP": (Fraction(1, 1000), 0, (-1, 1, -1)),
    "cpm": (Fraction(1, 30), 1, (0, 0, -1)),
    "in": (_INCH, 0, (1, 0, 0)),
    "mil": (_INCH / 1000, 0, (1, 0, 0)),
    "mils": (_INCH / 1000, 0, (1, 0, 0)),
    "ft": (12 * _INCH, 0, (1, 0, 0)),
    "lbm": (_POUND, 0, (0, 1, 0)),
    "lbf": (_POUND * _GRAVITY, 0, (1, 1, -2)),
    "psi": (_POUND * _GRAVITY / _INCH**2, 0, (-1, 1, -2)),
}
#: Functions of the package that convert a number with a unit.
FUNCTIONS = {"mm": "mm", "rpm": "rpm", "deg": "degrees", "°": "degrees"}
#: Units of a frequency, which are ambiguous for a speed: factor and power of π.
FREQUENCIES = {"Hz": (Fraction(2), 1), "kHz": (Fraction(2000), 1)}
SIGNS = {"µ": "u", "μ": "u", "°": "deg", "·": " ", "*": " ", "²": "^2", "³": "^3"}
_TEXT = re.compile(r"([-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?)(?![\d.])\s*(\S.*)?", re.ASCII)
#: Most characters of a text with a unit; Python converts at most 4,300 digits to a whole number.
_LONGEST = 4000
#: A hyphen between two units, as in "N-s/m", stands for a product.
_HYPHEN = re.compile(r"(?<=[A-Za-z])-(?=[A-Za-z])")
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


def fits(unit: str, path: str) -> bool:
    """Tell whether a unit converts to that of a field; an unknown one is an error."""
    return _unit(unit, path)[2] == _unit(unit_of(path) or DIMENSIONLESS, path)[2]


@cache
def _unit(text: str, path: str) -> tuple[Fraction, int, _Dimension]:
    """Read a product of units: factor, power of π and dimension."""
    factor, pi = Fraction(1), 0
    dimension = (0, 0, 0)
    plain = _HYPHEN.sub(" ", text.replace("**", "^"))
    for sign, replacement in SIGNS.items():
        plain = plain.replace(sign, replacement)
    for word in re.findall(r"/?\s*[^\s/^]+(?:\^[^\s/]+)?|\S", plain):
        one = _FACTOR.fullmatch(word.lstrip("/ "))
        known = None if one is None else _single(one[1], path)
        if one is None or known is None:
            raise SceneError(
                f"{path}: {word.lstrip('/ ')!r} is not a known unit; {_known(word, path)}"
            )
        power = int(one[2] or 1) * (-1 if word.startswith("/") else 1)
        factor *= known[0] ** power
        pi += known[1] * power
        a, b = dimension, known[2]
        dimension = (a[0] + power * b[0], a[1] + power * b[1], a[2] + power * b[2])
    return factor, pi, dimension


def _single(name: str, path: str) -> tuple[Fraction, int, _Dimension] | None:
    """Find one unit of a field, with or without a prefix."""
    if name in OTHERS:
        return OTHERS[name]
    if name in FREQUENCIES and is_frequency(path):
        return (*FREQUENCIES[name], (0, 0, -1))
    for unit, (ten, dimension) in WITH_PREFIX.items():
        prefix = name.removesuffix(unit)
        if name.endswith(unit) and prefix in PREFIXES:
            return Fraction(10) ** (ten + PREFIXES[prefix]), 0, dimension
    return None


def _known(word: str, path: str) -> str:
    """Say which units are known."""
    name = word.lstrip("/ ")
    if "Hz" in name and unit_of(path) == "rad/s":
        return "a speed is in rad/s, rpm or rev/s; 50 Hz could be 50 rad/s or 50 rev/s"
    if name in ("lb", "lbs"):
        return "a force is in lbf, a mass in lbm"
    for small in (name.lower(), name.lower().removesuffix("hz") + "Hz"):
        if _single(small, path) is not None:
            return f'did you mean "{small}"? Capital and small letters differ'
    return (
        f"known are {', '.join([*WITH_PREFIX, *(name for name in OTHERS if name != '1')])}, Hz for "
        f"a frequency, and the prefixes {' '.join(prefix for prefix in PREFIXES if prefix)}"
    )
