"""At which bow a pair comes to a limit: clearances used up, or no tooth left in contact."""

import math
from dataclasses import replace
from itertools import pairwise

from gearbow.study.case import ALL
from gearbow.study.measure import Measured
from gearbow.study.table import markdown
from gearbow.study.view import Study

__all__ = ["limits"]


def limits(study: Study) -> str:
    """Tabulate the bow, over the radius, at which a pair comes to a limit.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        One row for each layout and each place of the bow.
    """
    titles = ["layout", "bow on", "backlash used up", "tips reach roots", "contact ratio below 1"]
    rows = []
    for layout in study.settings.layouts:
        for where in (ALL, *study.shafts):
            reached = []
            for limit in (_backlash, _clearance, _overlap):
                margins = {
                    bow: min(
                        limit(
                            study,
                            study[replace(study.base, layout=layout, bow=bow, where=where)],
                            p,
                        )
                        for p in study.pairs
                    )
                    for bow in study.settings.bows
                }
                reached.append(_crossing(margins))
            rows.append([layout, where, *reached])
    return markdown(titles, rows)


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


def _overlap(study: Study, found: Measured, pair: str) -> float:
    del study
    return found.smallest(pair, "contact_ratio") - 1.0


def _crossing(margins: dict[float, float]) -> str:
    """Find where a margin is used up, straight between the bows that were run."""
    bows = sorted(margins)
    for low, high in pairwise(bows):
        a, b = margins[low], margins[high]
        if a > 0.0 >= b:
            return f"{low + (high - low) * a / (a - b):.3f}"
    return "at none" if margins[bows[0]] <= 0.0 else f"above {bows[-1]:g}"
