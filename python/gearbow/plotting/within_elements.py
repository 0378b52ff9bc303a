"""Mode shapes between the nodes: more positions, so that a long element is drawn curved."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from gearbow._types import ComplexArray, Dof, NodalDof
from gearbow.description.coordinates import Entries, motion_within
from gearbow.description.layout import Layout

__all__ = ["refined"]

#: Smallest number of intervals between the drawn positions of a shaft.
INTERVALS = 48


def refined(
    shapes: ComplexArray, dofs: Sequence[Dof], layout: Layout
) -> tuple[ComplexArray, list[NodalDof]]:
    """Evaluate mode shapes at the nodes and between them."""
    entries: dict[str, Entries] = {}
    for n, (name, x, direction) in enumerate(dofs):
        entries.setdefault(name, {}).setdefault(x, {})[direction] = shapes[:, n]
    found: dict[NodalDof, ComplexArray] = {}
    for shaft in layout.shafts:
        own = entries.get(shaft.name, {})
        for begin, end in pairwise(x for x in own if not isinstance(x, tuple)):
            xi = np.linspace(0.0, 1.0, 1 + int(np.ceil(INTERVALS * (end - begin) / shaft.length)))
            positions = [begin, *(begin + xi[1:-1] * (end - begin)).tolist(), end]
            phi = (shaft.shear_length((begin + end) / 2.0) / (end - begin)) ** 2
            for direction, values in motion_within(own, (begin, end), xi, phi):
                for x, value in zip(positions, values, strict=True):
                    found[shaft.name, x, direction] = value
    for base in layout.bases:
        for x, moved in entries.get(base.name, {}).items():
            if not isinstance(x, tuple):
                found |= {(base.name, x, direction): value for direction, value in moved.items()}
    return np.array(list(found.values())).T, list(found)
