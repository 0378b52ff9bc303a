"""Limits of the bow: zero backlash, interference of the teeth, and loss of contact."""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from functools import partial
from itertools import pairwise
from typing import Any

import gearbow as gb
from cases import ALL, Case, Settings, bent
from runs import Measured, Study, Teeth, make, measure, swept

#: Tolerance of a limit, bow / radius: a tenth of the last printed digit.
TOLERANCE = 1e-4


def backlash(settings: Settings, teeth: Teeth, found: Measured, pair: str) -> float:
    """Return the remaining backlash [m]; its derivative by the centre distance is 2 sin α."""
    closer = teeth.centre_distance - found.smallest(pair, "centre_distance")
    return settings.backlash - 2.0 * math.sin(teeth.pressure_angle) * closer


def clearance(_: Settings, teeth: Teeth, found: Measured, pair: str) -> float:
    """Return the remaining tip clearance [m]."""
    closer = teeth.centre_distance - found.smallest(pair, "centre_distance")
    return teeth.tip_clearance - closer


def involute(_: Settings, teeth: Teeth, found: Measured, pair: str) -> float:
    """Return C sin α minus the longer reach √(tip radius² − base radius²) of both gears [m]."""
    radii = zip(teeth.tip_radii, teeth.base_radii, strict=True)
    reach = max(math.sqrt(tip**2 - base**2) for tip, base in radii)
    nearest = found.smallest(pair, "centre_distance")
    return math.sqrt(nearest**2 - sum(teeth.base_radii) ** 2) - reach


def contact(_: Settings, __: Teeth, found: Measured, pair: str) -> float:
    """Return the contact ratio above 1."""
    return found.smallest(pair, "contact_ratio") - 1.0


#: Margins that become zero at a limit, by the title of the limit.
LIMITS: dict[str, Callable[[Settings, Teeth, Measured, str], float]] = {
    "backlash used up": backlash,
    "tips reach root circles": clearance,
    "tips pass base circles": involute,
    "contact ratio below 1": contact,
}


def margin(settings: Settings, limit: str, teeth: Mapping[str, Teeth], found: Measured) -> float:
    """Return the margin of the worse mesh."""
    return min(LIMITS[limit](settings, own, found, pair) for pair, own in teeth.items())


def limits(study: Study) -> dict[tuple[str, str, str], str]:
    """Return the bow at which a mesh reaches each limit, by layout, bowed shaft and limit."""
    texts: dict[tuple[str, str, str], str] = {}
    brackets = []
    for layout in study.settings.layouts:
        for where in (ALL, *study.shafts):
            case = replace(study.base, layout=layout, where=where)
            for limit in LIMITS:
                found = _between(study, case, limit)
                if isinstance(found, str):
                    texts[layout, where, limit] = found
                else:
                    brackets.append({**asdict(case), "limit": limit, **found})
    if brackets:
        train, layouts = study.settings.train, study.settings.layouts
        crossings = swept(
            partial(straight, train, layouts),
            brackets,
            partial(crossing, study.settings, study.teeth),
            None,
            study.folder / "limits.sweep",
        )
        for point, bow in zip(brackets, crossings.values(), strict=True):
            texts[point["layout"], point["where"], point["limit"]] = f"{bow:.3f}"
    return texts


def _between(study: Study, case: Case, limit: str) -> str | dict[str, float]:
    """Return the bows of the study on both sides of a limit with their margins, or a text."""
    bows = sorted(study.settings.bows)
    runs = [study[replace(case, bow=bow)] for bow in bows]
    margins = [margin(study.settings, limit, study.teeth, found) for found in runs]
    if margins[0] <= 0.0:
        return "exceeded without bow"
    for low, high in pairwise(range(len(bows))):
        if margins[high] <= 0.0:
            ends = {"low": bows[low], "low_margin": margins[low]}
            return {**ends, "high": bows[high], "high_margin": margins[high]}
    return f"above {bows[-1]:g}"


def straight(
    train: gb.RotorSystem, layouts: Mapping[str, Mapping[str, float]], **parameters: Any
) -> gb.RotorSystem:
    """Return the system of a case without bow."""
    return make(train, layouts, **{key: parameters[key] for key in asdict(Case("", 0.0, 0.0))})


def crossing(
    settings: Settings,
    teeth: Mapping[str, Teeth],
    system: gb.RotorSystem,
    *,
    limit: str,
    low: float,
    low_margin: float,
    high: float,
    high_margin: float,
    **parameters: Any,
) -> float:
    """Return the bow at which a margin changes sign, by the Illinois method."""
    kept = 0
    bow = before = low
    while high - low > TOLERANCE:
        bow = low + (high - low) * low_margin / (low_margin - high_margin)
        if abs(bow - before) < TOLERANCE / 2.0:
            break
        case = Case(**parameters | {"bow": bow})
        bowed = system.replace(shafts=bent(system.shafts, case))
        values = measure(settings.samples, settings.settle, bowed, **asdict(case))
        value, before = margin(settings, limit, teeth, Measured(values)), bow
        if value > 0.0:
            low, low_margin = bow, value
            high_margin = high_margin / 2.0 if kept > 0 else high_margin
            kept = 1
        else:
            high, high_margin = bow, value
            low_margin = low_margin / 2.0 if kept < 0 else low_margin
            kept = -1
    return bow
