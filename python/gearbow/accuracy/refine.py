"""Scenes with finer elements."""

from collections.abc import Mapping
from typing import Any

from gearbow._types import Plain

__all__ = ["refined"]


def refined(description: Mapping[str, Plain], factor: int = 2) -> dict[str, Plain]:
    """Multiply the number of elements of every segment.

    Parameters
    ----------
    description : mapping
        The scene as plain data.
    factor : int
        Factor on the numbers of elements.

    Returns
    -------
    dict
        The finer scene. All nodes of the given scene are nodes of the finer scene.
    """
    shafts = [_shaft(shaft, factor) for shaft in description["shafts"]]
    return {**description, "shafts": shafts}


def _shaft(shaft: Mapping[str, Any], factor: int) -> dict[str, Any]:
    if "segments" not in shaft:
        return {**shaft, "elements": factor * shaft.get("elements", 1)}
    segments = [
        {**segment, "elements": factor * segment.get("elements", 1)}
        for segment in shaft["segments"]
    ]
    return {**shaft, "segments": segments}
