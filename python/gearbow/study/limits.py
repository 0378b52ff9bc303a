"""At which bow a pair comes to a limit: clearances used up, or no tooth left in contact."""

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

#: A limit is found to this bow over the radius, a fifth of the last digit that is printed.
_TOLERANCE = 1e-4


def limits(study: Study) -> str:
    """Tabulate the bow, over the radius, at which a pair comes to a limit.

    Parameters
    ----------
    study : Study
        The study; runs between its bows are made, and kept in its folder.

    Returns
    -------
    str
        One row for each layout and each place of the bow.
    """
    titles = ["layout", "bow on", "backlash used up", "tips reach roots"]
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
    limits = (_backlash, _clearance, _involute, _overlap)
    return [case.layout, case.where, *(_crossing(margin(limit), bows) for limit in limits)]


def _backlash(study: Study, found: Measured, pair: str) -> float:
    """Clearance that is left to the back flanks [m]: it shrinks by 2 sin α with the distance."""
    distance, angle, _ = study.pair(pair)
    closer = distance - found.smallest(pair, "centre_distance")
    return study.settings.backlash - 2.0 * math.sin(angle) * closer


def _clearance(study: Study, found: Measured, pair: str) -> float:
    """Distance of tips to the root circle [m]; full-depth teeth have a quarter of the module."""
    distance, _, _ = study.pair(pair)
    module = study.gear(pair.split("/", maxsplit=1)[0])["module"]
    return module / 4.0 - (distance - found.smallest(pair, "centre_distance"))


def _involute(study: Study, found: Measured, pair: str) -> float:
    """Length that the longer tips leave of the line of action between the base circles [m]."""
    _, angle, _ = study.pair(pair)
    gears = [study.gear(name) for name in pair.split("/")]
    radii = [gear["module"] * gear["teeth"] / 2.0 for gear in gears]
    bases = [radius * math.cos(angle) for radius in radii]
    reach = max(
        math.sqrt((radius + gear["module"]) ** 2 - base**2)
        for gear, radius, base in zip(gears, radii, bases, strict=True)
    )
    nearest = found.smallest(pair, "centre_distance")
    return math.sqrt(nearest**2 - sum(bases) ** 2) - reach


def _overlap(study: Study, found: Measured, pair: str) -> float:
    del study
    return found.smallest(pair, "contact_ratio") - 1.0


def _crossing(margin: Callable[[float], float], bows: tuple[float, ...]) -> str:
    """Find the first bow at which a margin is used up."""
    given = sorted(bows)
    margins = [margin(bow) for bow in given]
    if margins[0] <= 0.0:
        return "at none"
    for low, high in pairwise(range(len(given))):
        if margins[high] <= 0.0:
            ends = ((given[low], margins[low]), (given[high], margins[high]))
            return f"{_root(margin, *ends):.3f}"
    return f"above {given[-1]:g}"


def _root(
    margin: Callable[[float], float], low: tuple[float, float], high: tuple[float, float]
) -> float:
    """Find where a margin changes its sign, by the Illinois method (Dowell and Jarratt 1971).

    Both ends hold a bow and its margin, of which the first is positive. Unlike the plain rule of
    false position, the method halves the margin of an end that stays where it is twice.
    """
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
