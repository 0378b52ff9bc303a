"""The initial state of a run, checked against its equations.

Runs of a system share the static equilibrium and the synchronous response with which they begin, so
that their comparison does not show an error of these.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gearbow._core import Model, user_order
from gearbow._types import Array
from gearbow.description.speed import SpeedProfile, read_speed
from gearbow.errors import ConvergenceError

#: Largest residual of the equations of an initial state, relative to their loads, and largest
#: difference of the state from the motion that it consists of, relative to this motion. Equilibria
#: and responses are accurate to 1e-9 or better; the smallest promised error is 1e-6.
_LIMIT = 1e-6


def check_initial_state(model: Model, options: Mapping[str, Any]) -> None:
    """Check that the initial state of a run satisfies its equations."""
    initial, begin = options["initial"], options["start"]
    if not isinstance(initial, str) or initial == "rest":
        return
    profile = read_speed(options["speed"])
    speed = float(profile(begin)) if isinstance(profile, SpeedProfile) else profile
    static = model.static(options["geometry"], speed)
    unbalanced = [residual for _, residual in static["residuals"]]
    _check("the forces at the static equilibrium do not balance", speed, unbalanced)
    motion = [static["state"], np.zeros_like(static["state"])]
    if initial == "synchronous":
        response = model.synchronous(np.array([speed]), "both", 1)
        problem = "the synchronous response does not satisfy the equations of motion"
        _check(problem, speed, response["residuals"])
        spins = speed * model.speed_ratios
        angle = profile.angle(begin) if isinstance(profile, SpeedProfile) else speed * begin
        phasors = np.exp(1j * model.speed_ratios * angle)
        moving = phasors[:, np.newaxis] * response["phasors"][0]
        motion[0] = motion[0] + moving.real.sum(axis=0)
        motion[1] = -(spins[:, np.newaxis] * moving.imag).sum(axis=0)
    state = _state(model, options)
    for found, exact in zip(np.split(state, 2), motion, strict=True):
        size = np.abs(exact).max(initial=0.0)
        difference = np.abs(found - exact).max(initial=0.0)
        problem = f"the state is not the motion {initial!r} that it stands for"
        _check(problem, speed, difference / size if size > 0.0 else difference)


def _state(model: Model, options: Mapping[str, Any]) -> Array:
    """Give the displacements and velocities with which a run of all modes begins."""
    given: Any = {**options, "duration": 0.0, "modes": None, "accuracy": None, "record": []}
    times = np.array([options["start"]])
    run = model.simulate(**given, times=times, checkpoint=None, progress=None)
    return user_order(model, run["final"]["state"])


def _check(problem: str, speed: float, residuals: Any) -> None:
    """Refuse residuals above the limit, and those that are no numbers."""
    residual = float(np.max(residuals, initial=0.0))
    if not residual <= _LIMIT:
        raise ConvergenceError(
            f"initial: {problem} at {speed:g} rad/s: the residual is {residual:.1e}, above "
            f"{_LIMIT:.0e}; give another initial state, for example initial='rest'"
        )
