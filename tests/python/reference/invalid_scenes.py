"""A scene with all kinds of numbers, as plain keywords, and the same scene with one invalid value."""

from __future__ import annotations

import copy
import math
from typing import Any

import gearbow as gb

SCENE: dict[str, Any] = {
    "shafts": [
        {
            "name": "input",
            "length": 0.5,
            "outer_diameter": 0.05,
            "inner_diameter": 0.01,
            "elements": 4,
            "degree": 2,
            "axial_force": 10.0,
            "internal_damping": 0.0,
            "loss_factor": 0.01,
            "material": {"youngs_modulus": 2e11, "density": 7800.0, "poisson_ratio": 0.3},
        },
        {
            "name": "output",
            "length": 0.5,
            "outer_diameter": 0.05,
            "elements": 4,
            "bow": ("half_sine", {"amplitude": 1e-4, "phase": 0.1}),
        },
        {
            "name": "third",
            "segments": [
                {"length": 0.2, "outer_diameter": 0.05, "inner_diameter": 0.01, "elements": 2},
                {
                    "length": 0.3,
                    "outer_diameter": 0.06,
                    "end_outer_diameter": 0.05,
                    "end_inner_diameter": 0.01,
                },
            ],
            "bow": (
                "points",
                {
                    "positions": [0.0, 0.2, 0.5],
                    "amplitudes": [0.0, 1e-4, 0.0],
                    "phases": [0.0, 0.1, 0.2],
                },
            ),
        },
    ],
    "gears": [
        {
            "name": "g1",
            "shaft": "input",
            "position": 0.25,
            "teeth": 25,
            "module": 3e-3,
            "face_width": 0.03,
            "pressure_angle": 0.35,
            "helix_angle": 0.0,
            "profile_shift": 0.01,
            "tip_radius": 0.0405,
            "mass": 1.0,
            "diametral_inertia": 1e-3,
            "polar_inertia": 2e-3,
            "unbalance": 1e-4 + 1e-5j,
        },
        {
            "name": "g2",
            "shaft": "output",
            "position": 0.25,
            "teeth": 50,
            "module": 3e-3,
            "face_width": 0.03,
            "pressure_angle": 0.35,
        },
        {
            "name": "g3",
            "shaft": "third",
            "position": 0.2,
            "teeth": 30,
            "base_radius": 30 * 1.5e-3 * math.cos(0.35),
            "face_width": 0.03,
            "pressure_angle": 0.35,
        },
    ],
    "meshes": [
        {
            "driver": "g1",
            "driven": "g2",
            "stiffness": 2e8,
            "damping_ratio": 0.05,
            "loss_factor": 0.02,
            "centre_line_angle": 0.2,
            "tooth_angle": 0.1,
            "centre_distance": 0.113,
        },
        {"driver": "g2", "driven": "g3", "stiffness": 2e8, "damping": 100.0},
    ],
    "bearings": [
        {
            "shaft": "input",
            "position": 0.0,
            "stiffness": 1e8,
            "damping": 500.0,
            "axial_stiffness": 1e7,
            "axial_damping": 100.0,
            "tilting_stiffness": 1e4,
            "tilting_damping": 1.0,
            "loss_factor": 0.02,
            "misalignment": 2e-5 + 1e-5j,
            "dynamic_rating": 3e4,
            "static_rating": 2e4,
            "contact_angle": 0.2,
        },
        {"shaft": "input", "position": 0.5, "stiffness": (1e8, 2e8), "damping": (500.0, 100.0)},
        {
            "shaft": "output",
            "position": 0.0,
            "stiffness": [[1e8, 1e6], [1e6, 1e8]],
            "damping": [[500.0, 0.0], [0.0, 500.0]],
        },
        {"shaft": "output", "position": 0.5, "stiffness": 1e8},
        {"shaft": "third", "position": 0.0, "stiffness": 1e8},
        {"shaft": "third", "position": 0.5, "stiffness": 1e8},
    ],
    "disks": [
        {
            "name": "wheel",
            "shaft": "output",
            "position": 0.375,
            "mass": 3.0,
            "diametral_inertia": 0.01,
            "polar_inertia": 0.02,
            "unbalance": 1e-4,
        }
    ],
    "torques": [
        {"at": "g1", "value": 100.0},
        {"at": ("output", 0.5), "value": 10.0},
        {"at": "g3", "balance": True},
    ],
    "modal_damping": 0.01,
    "gravity": [0.0, -9.81],
}
KINDS = {
    "gears": "Gear",
    "meshes": "Mesh",
    "bearings": "Bearing",
    "disks": "Disk",
}


def build(scene: dict[str, Any]) -> gb.RotorSystem:
    scene = copy.deepcopy(scene)
    for shaft in scene["shafts"]:
        if "material" in shaft:
            shaft["material"] = gb.Material(**shaft["material"])
        if "segments" in shaft:
            shaft["segments"] = [gb.Segment(**segment) for segment in shaft["segments"]]
        if "bow" in shaft:
            shape, arguments = shaft["bow"]
            shaft["bow"] = getattr(gb.Bow, shape)(**arguments)
    scene["shafts"] = [gb.Shaft(**shaft) for shaft in scene["shafts"]]
    for key, kind in KINDS.items():
        scene[key] = [getattr(gb, kind)(**part) for part in scene.get(key, [])]
    scene["torques"] = [
        gb.Torque.balance(t["at"]) if t.get("balance") else gb.Torque(t["at"], t["value"])
        for t in scene.get("torques", [])
    ]
    return gb.RotorSystem(**scene)


def with_value(path: list[str | int], value: Any) -> dict[str, Any]:
    """Give the scene with one value replaced."""
    scene = copy.deepcopy(SCENE)
    at: Any = scene
    for key in path[:-1]:
        if isinstance(at[key], tuple):
            at[key] = list(at[key])
        at = at[key]
    at[path[-1]] = value
    return scene


def numbers(part: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """Give the paths of all real numbers in the scene."""
    if isinstance(part, (bool, str)):
        return []
    if isinstance(part, (float, complex, int)):
        return [path]
    items = part.items() if isinstance(part, dict) else enumerate(part)
    return [found for key, item in items for found in numbers(item, (*path, key))]


def written(path: tuple[str | int, ...]) -> str:
    """Give the path as an error message prints it."""
    text = ""
    for i, key in enumerate(path):
        if i and path[i - 1] == "bow" and key == 1:
            continue  # constructor arguments of the bow are its own fields in the message
        if isinstance(key, int):
            text += f"[{key}]"
        else:
            text += f".{key}" if text else key
    return text
