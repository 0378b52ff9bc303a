"""Internal damping of shafts at changing speed: the exponential method against rk45 at a tight tolerance.

The forward modes of a rotor with internal damping grow above their critical speed, so that an error grows with
the motion. Differences are relative to the motion at the end.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.machines import pair
from test_shaft_forces import rotor_of_ansys

#: Through the threshold of instability at 5000 rpm, 524 rad/s, and back.
UP = gb.SpeedProfile.ramp(0.0, 900.0, 0.1)
DOWN = gb.SpeedProfile.ramp(900.0, 100.0, 0.1)
BACKWARD = gb.SpeedProfile.ramp(0.0, -900.0, 0.1)
PROFILES = pytest.mark.parametrize("profile", [UP, DOWN, BACKWARD], ids=["up", "down", "backward"])


def rotor(internal_damping: float = 2e-4, **parts: Any) -> gb.RotorSystem:
    """Return the rotor of VM261 on a coarse mesh, which is cheap for rk45, with a bow and its weight."""
    bow = gb.Bow.half_sine(1e-4)
    system = rotor_of_ansys(bow=bow, elements=4, degree=2, internal_damping=internal_damping)
    return system.replace(gravity=9.81, **parts)


def train(**more: Any) -> gb.RotorSystem:
    """Return a pair with internal damping in both shafts, which turn in opposite senses."""
    own = {
        "input": {"internal_damping": 2e-4, "bow": gb.Bow.half_sine(5e-5)},
        "output": {"internal_damping": 1e-4},
    }
    return pair(shaft={"outer_diameter": 0.03, "elements": 2, "degree": 2}, own=own, **more)


def error(found: np.ndarray, exact: np.ndarray) -> float:
    """Return the RMS of the difference over that of the variation."""
    variation = np.sqrt(np.mean((exact - exact.mean(axis=0)) ** 2))
    return float(np.sqrt(np.mean((found - exact) ** 2)) / variation)


@PROFILES
def test_a_rotor_that_passes_its_threshold(profile: gb.SpeedProfile):
    middle = ("s", 0.635)
    options: dict[str, Any] = {"initial": "static", "record": [middle], "output_step": 1e-3}
    exact = rotor().simulate(0.1, profile, method="rk45", rtol=1e-10, **options)
    exact = exact.displacement(middle)
    for rtol in (1e-4, 1e-6, 1e-8):
        found = rotor().simulate(0.1, profile, rtol=rtol, **options).displacement(middle)
        # 100: as at constant speed; couplings are neglected up to ten times the tolerance.
        assert error(found, exact) < 100 * rtol
