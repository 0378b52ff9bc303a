"""Limits of the bow: zero backlash, interference of the teeth, and loss of contact."""

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise

from gearbow.study.case import ALL, Case
from gearbow.study.measure import Measured
from gearbow.study.table import markdown
from gearbow.study.view import Study

__all__ = ["limits"]

#: Tolerance of a limit, bow / radius: a tenth of the last printed digit.
_TOLERANCE = 1e-4


def limits(study: Study) -> str:
    """Tabulate the bow at which a mesh reaches each limit, divided by the shaft radius."""
    titles = ["layout", "bow on", "backlash used up", "tips reach root circles"]
    titles += ["tips pass base circles", "contact ratio below 1"]
    places = [
        replace(study.base, layout=layout, where=where)
        for layout in study.settings.layouts
        for where in (ALL, *study.shafts)
    ]
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        rows = list(pool.map(lambda case: _row(study, case), places))
    return markdown(titles, rows)


def _row(study: Study, case: Case) -> list[str]:
    def margin(limit: Callable[[Study, Measured, str], float]) -> Callable[[float], float]:
        return lambda bow: min(
            limit(study, study.find(replace(case, bow=bow)), pair) for pair in study.pairs
        )

    bows = study.settings.bows
    limits = (_backlash, _clearance, _involute, _contact)
    return [case.layout, case.where, *(_crossing(margin(limit), bows) for limit in limits)]


def _backlash(study: Study, found: Measured, pair: str) -> float:
    """Return the remaining backlash [m]; its derivative by the centre distance is 2 sin α."""
    distance, angle, _ = study.pair(pair)
    closer = distance - found.smallest(pair, "centre_distance")
    return study.settings.backlash - 2.0 * math.sin(angle) * closer


def _clearance(study: Study, found: Measured, pair: str) -> float:
    """Return the remaining tip clearance [m]."""
    distance, _, _ = study.pair(pair)
    return study.clearance(pair) - (distance - found.smallest(pair, "centre_distance"))


def _involute(study: Study, found: Measured, pair: str) -> float:
    """Return C sin α minus the longer reach √(tip radius² − base radius²) of both gears [m]."""
    mesh = study.mesh(pair)
    bases = mesh["base_radii"]
    reach = max(
        math.sqrt(tip**2 - base**2) for tip, base in zip(mesh["tip_radii"], bases, strict=True)
    )
    nearest = found.smallest(pair, "centre_distance")
    return math.sqrt(nearest**2 - sum(bases) ** 2) - reach


def _contact(study: Study, found: Measured, pair: str) -> float:
    del study
    return found.smallest(pair, "contact_ratio") - 1.0


def _crossing(margin: Callable[[float], float], bows: tuple[float, ...]) -> str:
    """Return the smallest bow at which a margin becomes zero, as text."""
    given = sorted(bows)
    margins = [margin(bow) for bow in given]
    if margins[0] <= 0.0:
        return "exceeded without bow"
    for low, high in pairwise(range(len(given))):
        if margins[high] <= 0.0:
            ends = ((given[low], margins[low]), (given[high], margins[high]))
            return f"{_root(margin, *ends):.3f}"
    return f"above {given[-1]:g}"


def _root(
    margin: Callable[[float], float], low: tuple[float, float], high: tuple[float, float]
) -> float:
    """Return the bow at which a margin changes sign, by the Illinois method."""
    kept = 0
    bow = before = low[0]
    while high[0] - low[0] > _TOLERANCE:
        bow = low[0] + (high[0] - low[0]) * low[1] / (low[1] - high[1])
        if abs(bow - before) < _TOLERANCE / 2.0:
            break
        value, before = margin(bow), bow
        if value > 0.0:
            low = (bow, value)
            high = (high[0], high[1] / 2.0 if kept > 0 else high[1])
            kept = 1
        else:
            high = (bow, value)
            low = (low[0], low[1] / 2.0 if kept < 0 else low[1])
            kept = -1
    return bow
