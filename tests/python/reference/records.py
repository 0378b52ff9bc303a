"""A response with artificial values on a train of three shafts, with every kind of record."""

from __future__ import annotations

from typing import Any

import numpy as np

import gearbow as gb
from gearbow.orders import Kinematics

#: Unit of each quantity of a mesh, as the documentation of `MeshResponse` gives it.
MESH_UNITS = {
    "deflection": "m",
    "force": "N",
    "stiffness": "N/m",
    "pressure_angle": "rad",
    "centre_distance": "m",
    "centre_line_angle": "rad",
    "contact_ratio": "1",
    "pairs_in_contact": "1",
    "thrust": "N",
    "friction_force": "N",
    "friction_power": "W",
}
ENERGIES = ("kinetic", "shafts", "bearings", "meshes")
WORKS = ("torque", "gravity", "drive", "unbalance", "teeth", "damping")
#: Input 1, middle 0.4, output 0.16: two pairs of 20 and 50 teeth.
KINEMATICS = Kinematics(
    shafts=(("input", 1.0), ("middle", 0.4), ("output", 0.16)),
    meshes=(
        ("g1", "g2", "input", "middle", 20.0),
        ("g3", "g4", "middle", "output", 8.0),
    ),
)


def response(time: np.ndarray, speed: float = 100.0, **data: Any) -> gb.Response:
    """Give a response with different values in every series; `data` replaces some of them."""
    rows, numbers = time.size, np.random.default_rng(11)
    series = {
        "time": time,
        "points": [
            ("input", 0.25, ["g1"]),
            ("middle", 0.1, ["g2"]),
            ("middle", 0.4, ["g3", "wheel"]),
            ("output", 0.3, []),
        ],
        "displacement": 1e-5 * numbers.standard_normal((rows, 4, 2)),
        "twist": 1e-3 * numbers.standard_normal((rows, 4)),
        "bearings": [("input", 0.0), ("output", 0.5)],
        "bearing_force": numbers.standard_normal((rows, 2, 2)),
        "rolling_bearings": [],
        "sections": [],
        "rolling_contact": np.empty((rows, 0, 2)),
        "meshes": [("g1", "g2"), ("g3", "g4")],
        "mesh": {name: numbers.standard_normal((rows, 2)) for name in MESH_UNITS},
        "energy": 5.0 + numbers.standard_normal(rows),
        "energy_terms": {name: numbers.standard_normal(rows) for name in (*ENERGIES, *WORKS)},
        "events": [(0.25, "g3", "g4", "separation"), (0.5, "g1", "g2", "contact")],
        "final": {
            "method": "rk45",
            "time": float(time[-1]),
            "origin": 0.0,
            "speed": 100.0,
            "anchor": [0.0, 1 / 3, 1e-17],
            "geometry": "live",
            "setting": 1e-6,
            "count": 2**62 + 1,
            "elapsed": float(time[-1]),
            "carry": -1e-17,
            "next_step": 1e-5,
            "previous_error": float("inf"),
            "contact_modes": np.array([2**53 + 1, -1], dtype=np.int64),
            "memory": np.empty(0),
            "state": np.arange(4.0),
        },
        "statistics": {
            "steps": 4,
            "rejected": 1,
            "evaluations": 30,
            "events": 0,
            "step_min": 1e-7,
            "step_max": 1e-6,
            "omega_max": 3e4,
            "limited_by": "stability",
            "condition": 1.5,
        },
    }
    made = gb.Response({**series, **data}, speed=speed)
    made.kinematics = KINEMATICS
    return made


def of_series(time: np.ndarray, values: np.ndarray, speed: float = 100.0) -> gb.Response:
    """Give a response with the given displacement w of gear g1; all other series are zero."""
    motion = np.zeros((time.size, 4, 2))
    motion[:, 0, 1] = values
    return response(time, speed, displacement=motion)
