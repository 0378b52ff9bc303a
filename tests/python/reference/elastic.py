"""A rotor in elastic housings of a few masses."""

from __future__ import annotations

import numpy as np

import gearbow as gb


def system(*names: str, sensor: bool = False) -> gb.RotorSystem:
    """Give a rotor whose bearings stand on the masses of elastic housings, 1 m above each other."""
    rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=2)
    ends = [(0.0, names[0], "left seat"), (1.0, names[-1], "2 mm")]
    bearings = [gb.Bearing("rotor", x, stiffness=1e8, support=(n, at)) for x, n, at in ends]
    seats = [("left seat", (0.0, 0.0, 0.0)), ("2 mm", (1.0, 0.0, 0.0))]
    if sensor:
        seats.append(("sensor", (0.5, 0.0, 0.2)))
    housings = []
    for number, name in enumerate(names):
        own = seats if len(names) == 1 else [seats[number]]
        interfaces = {
            seat: gb.Interface(place, rows=[3 * i, 3 * i + 1, 3 * i + 2], damping=(1.0, 2.0, 3.0))
            for i, (seat, place) in enumerate(own)
        }
        size = 3 * len(own)
        stiffness = 1e7 * (number + 1.0) * np.diag(np.arange(1.0, size + 1.0))
        housings.append(
            gb.Housing.from_matrices(
                name,
                mass=np.diag(np.arange(size) + 5.0),
                stiffness=stiffness,
                interfaces=interfaces,
                highest_frequency=500.0,
            )
        )
    return gb.RotorSystem(shafts=[rotor], bearings=bearings, housings=housings)
