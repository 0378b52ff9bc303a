"""Limits of the bow: zero backlash, interference of the teeth, and loss of contact."""

from dataclasses import replace

import gearbow as gb
from cases import ALL, Settings, radius, train

#: Limits of `RotorSystem.bow_limits` by their titles in the table.
LIMITS = {
    "backlash used up": "backlash used up",
    "tips reach root circles": "tips touch roots",
    "tips pass base circles": "involutes end",
    "contact ratio below 1": "contact ratio",
}


def limits(settings: Settings) -> dict[tuple[str, str, str], str]:
    """Return the bow at which a mesh reaches each limit, by layout, bowed shaft and limit."""
    texts: dict[tuple[str, str, str], str] = {}
    names = [shaft.name for shaft in settings.train.shafts]
    for layout in settings.layouts:
        system = train(settings, replace(settings.base, layout=layout))
        system = system.replace(
            meshes=[replace(mesh, backlash=settings.backlash) for mesh in system.meshes]
        )
        for where in (ALL, *names):
            found = system.bow_limits(
                names if where == ALL else where,
                settings.base.speed,
                shape=gb.Bow.half_sine(1.0),
                phase=0.0,
            )
            for title, name in LIMITS.items():
                # Limits ascend: the first one is that of the worse mesh.
                bow = next(one.bow for one in found.limits if one.limit == name)
                texts[layout, where, title] = f"{bow / radius(system.shafts[0]):.3f}"
    return texts
