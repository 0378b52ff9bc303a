"""Damping ratios of modes: the plain form of what a user gives."""

from collections.abc import Mapping

import numpy as np

from gearbow._convert import array, number, whole
from gearbow._types import Plain
from gearbow.description.part import tuples
from gearbow.description.speed import evaluated
from gearbow.errors import SceneError

#: Keys of a table over the frequency, and the key of the modes without a ratio of their own.
_TABLE, _OTHER = ("frequencies", "ratios"), "other"
#: Exponents of ten of the frequencies [rad/s] at which a function is sampled, and points for a
#: decade: with 50, a ratio a/ω + bω differs by 2e-6 of its value between the points.
_DECADES, _POINTS = (1, 5), 50


def described_ratios(value: object, path: str) -> Plain:
    """Convert a ratio, ratios by mode number, a table or a function of ω to plain data."""
    if callable(value):
        begin, end = _DECADES
        frequencies = np.logspace(begin, end, (end - begin) * _POINTS + 1)
        ratios = evaluated(value, frequencies, path, "rad/s")
        return {"frequencies": frequencies.tolist(), "ratios": ratios.tolist()}
    if not isinstance(value, Mapping):
        return number(value, path)
    if any(key in value for key in _TABLE):
        if set(value) != set(_TABLE):
            raise SceneError(f"{path}: a table needs the keys frequencies and ratios only")
        return {key: array(value[key], f"{path}.{key}").tolist() for key in _TABLE}
    return {_key(key, path): number(ratio, f"{path}[{key!r}]") for key, ratio in value.items()}


def _key(key: object, path: str) -> str:
    """Give the name of a mode number in plain data."""
    if isinstance(key, str):
        return key if key == _OTHER or not key.isdecimal() else str(int(key))
    return str(whole(key, f"{path}: the number of a mode"))


def given_ratios(plain: Plain) -> Plain:
    """Give ratios of plain data with mode numbers as a user gives them."""
    if not isinstance(plain, Mapping):
        return plain
    return {int(key) if key.isdecimal() else key: tuples(value) for key, value in plain.items()}
