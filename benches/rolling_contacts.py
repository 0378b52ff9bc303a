"""Compare integration through the contact changes of rolling elements with steps that end at them.

A disk of 10 kg on one bearing of nine balls is integrated by SciPy's DOP853: through the changes,
and with an event at each of them. The counts are evaluations of the right-hand side, without those
of the search for the events. The exponential method of gearbow integrates a rotor on two such
bearings through the changes; its steps are counted as well.
"""

import math
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import gearbow as gb

Array = NDArray[np.float64]

BALLS, STIFFNESS, CLEARANCE, DAMPING, MASS = 9, 8e9, 2e-5, 300.0, 10.0
DIAMETER, PITCH = 0.0127, 0.065
CAGE = (1.0 - DIAMETER / PITCH) / 2.0
SPEED, END, GRAVITY = 100.0, 0.3, 9.81
TOLERANCES = (1e-4, 1e-7)
TIMES = np.linspace(0.0, END, 601)
START = np.array([5e-6, -1.5e-5, 0.0, 0.0])


def approaches(t: float, y: Array) -> tuple[Array, Array]:
    """Give the deflection of each ball [m], and the unit vectors of the balls."""
    angle = SPEED * CAGE * t + math.tau * np.arange(BALLS) / BALLS
    places = np.array([np.cos(angle), np.sin(angle)])
    return y[:2] @ places - CLEARANCE / 2.0, places


def slope(t: float, y: Array) -> Array:
    """Give the rates of displacement and velocity."""
    deflection, places = approaches(t, y)
    force = STIFFNESS * places @ np.maximum(deflection, 0.0) ** 1.5 + DAMPING * y[2:]
    return np.concatenate([y[2:], -force / MASS - [0.0, GRAVITY]])


def margin(ball: int) -> Callable[[float, Array], float]:
    """Give the function whose zeros are the contact changes of a ball."""

    def deflection(t: float, y: Array) -> float:
        return float(approaches(t, y)[0][ball])

    deflection.terminal = True  # type: ignore[attr-defined]
    return deflection


def integrate(rtol: float, *, located: bool) -> tuple[Array, int, int]:
    """Give the displacements at the times, the evaluations and the contact changes."""
    events = [margin(ball) for ball in range(BALLS)] if located else None
    start, y, evaluations, changes, found = 0.0, START, 0, 0, []
    options: dict[str, Any] = {
        "method": "DOP853",
        "rtol": rtol,
        "atol": 1e-5 * rtol,
        "events": events,
    }
    while True:
        part = solve_ivp(slope, (start, END), y, t_eval=TIMES[start <= TIMES], **options)
        evaluations += part.nfev
        found.append(part.y[:2].T)
        if part.status != 1:
            return np.concatenate(found), evaluations, changes
        changes += 1
        start, y = next(
            (times[0], states[0])
            for times, states in zip(part.t_events, part.y_events, strict=True)
            if times.size
        )
        # The next step begins behind the zero.
        ahead = 1e-11
        start, y = start + ahead, y + ahead * slope(start, y)


def exponential(rtol: float) -> tuple[int, int]:
    """Give the steps and evaluations of the exponential method for a similar rotor."""
    shaft = gb.Shaft("s", length=0.3, outer_diameter=0.04, elements=2)
    sizes: dict[str, Any] = {
        "element_diameter": DIAMETER,
        "pitch_diameter": PITCH,
        "clearance": CLEARANCE,
    }
    bearings = [
        gb.RollingBearing(
            "s", x, elements=BALLS, hertz_stiffness=STIFFNESS, damping=DAMPING, **sizes
        )
        for x in (0.0, 0.3)
    ]
    disk = gb.Disk("d", "s", 0.15, 2.0 * MASS, 0.02, 0.04)
    system = gb.RotorSystem([shaft], disks=[disk], bearings=bearings, gravity=GRAVITY)
    run = system.simulate(
        END, SPEED, times=TIMES, record=["d"], method="exponential", rtol=rtol, initial="static"
    )
    return run.statistics.steps, run.statistics.evaluations


def main() -> None:
    """Print the table."""
    exact, _, changes = integrate(1e-12, located=True)
    swing = np.ptp(exact, axis=0).max()
    print(f"{changes} contact changes in {END} s, {changes / END:.0f} per second.\n")
    print(
        "| rtol | evaluations through | error | evaluations with events | error "
        "| exponential: steps | evaluations |"
    )
    print("|---|---|---|---|---|---|---|")
    for rtol in TOLERANCES:
        row = [f"{rtol:.0e}"]
        for located in (False, True):
            found, evaluations, _ = integrate(rtol, located=located)
            row += [str(evaluations), f"{np.abs(found - exact).max() / swing:.0e}"]
        row += [str(count) for count in exponential(rtol)]
        print("| " + " | ".join(row) + " |")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
