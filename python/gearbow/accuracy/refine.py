"""Scenes with finer elements."""

from collections.abc import Mapping
from typing import Any

from gearbow._types import Plain

#: Largest degree of an element. The core uses the same value.
MAX_DEGREE = 8


def refined(description: Mapping[str, Plain]) -> dict[str, Plain]:
    """Increase the degree of the elements of every shaft."""
    return {**description, "shafts": [_shaft(shaft) for shaft in description["shafts"]]}


def _shaft(shaft: Mapping[str, Any]) -> dict[str, Any]:
    degree = shaft.get("degree", 1)
    if degree < MAX_DEGREE:
        return {**shaft, "degree": 3 if degree == 1 else degree + 1}
    if "segments" not in shaft:
        return _divided(shaft)
    return {**shaft, "segments": [_divided(segment) for segment in shaft["segments"]]}


def _divided(part: Mapping[str, Any]) -> dict[str, Any]:
    return {**part, "elements": 2 * part.get("elements", 1)}
