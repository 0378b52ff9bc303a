"""Elements for bows that are no part of a system."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from gearbow.analysis.protocol import S, variant
from gearbow.description.bow import Bow, amplitude_of, scaled
from gearbow.description.shafts import Shaft

#: Amplitude of the bows [m]. The elements depend on the shape only, as the response is linear.
_AMPLITUDE = 1e-6


def with_elements_for(system: S, *cases: Mapping[str, Bow]) -> S:
    """Make a system with fixed elements, as fine as if the bows of any case were its own."""
    # The bows of a case, by shaft, act at the same time, without those of other shafts.
    shafts: list[dict[str, Any]] = system._model.resolved()["shafts"]
    for bows in cases:
        largest = max(map(amplitude_of, bows.values()), default=0.0)
        if largest > 0.0:
            own = {name: scaled(bow, _AMPLITUDE / largest) for name, bow in bows.items()}
            bent = [replace(shaft, bow=own.get(shaft.name)) for shaft in system.shafts]
            chosen = variant(system, shafts=bent)._model.resolved()["shafts"]
            shafts = [_finer(a, b) for a, b in zip(shafts, chosen, strict=True)]
    return variant(system, shafts=[Shaft._from_description(shaft) for shaft in shafts])


def _finer(given: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Give a shaft, or a segment of one, the larger numbers and degrees of elements of two."""
    numbers = {
        key: max(given[key], other[key])
        for key in ("elements", "degree")
        if given.get(key) is not None and other.get(key) is not None
    }
    if given.get("segments"):
        pairs = zip(given["segments"], other["segments"], strict=True)
        numbers["segments"] = [_finer(*pair) for pair in pairs]
    return {**given, **numbers}
