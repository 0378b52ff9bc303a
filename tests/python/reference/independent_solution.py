"""Motion of an independent train from rest: SciPy's DOP853 on the first-order equations.

M q'' + (C + speed G) q' + K q + sum of mesh forces = bow(t) + unbalance(t) + torque + gravity

`from_rest` has a constant speed; `run_up` takes the speed with its integral and its derivative.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from reference import elements
from reference.train import Train

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    train: Train
    time: Array
    q: Array  # (k, n)
    qd: Array

    def displacement(self, name: str) -> Array:
        place = self.train.place(name)
        at = [self.train.dof(*place, c) for c in (elements.V, elements.W)]
        return self.q[:, at]

    def twist(self, name: str) -> Array:
        return self.q[:, self.train.dof(*self.train.place(name), elements.T)]

    def mesh_force(self, index: int, live: bool) -> Array:
        mesh = self.train.meshes[index]
        at = self.train.interface(mesh)
        return np.array(
            [mesh.law.force(q[at], qd[at], live)[0] for q, qd in zip(self.q, self.qd, strict=True)]
        )

    def contact_ratio(self, index: int) -> Array:
        mesh = self.train.meshes[index]
        at = self.train.interface(mesh)
        return np.array(
            [mesh.law.contact_ratio(mesh.law.centres(q[at][:2], q[at][3:5])[0]) for q in self.q]
        )


def from_rest(
    train: Train,
    speed: float,
    times: Array,
    live: bool = True,
    *,
    rtol: float = 1e-10,
    further: Callable[[float, Array, Array], Array] | None = None,
) -> Motion:
    """Integrate from q = q' = 0 at t = 0; `further` gives generalised forces (n,) at t, q and q'."""
    n = train.size
    stiffness, damping = train.grounded, train.viscous + speed * train.gyroscopic
    inverse = np.linalg.inv(train.mass)
    acceleration = np.hstack([-inverse @ stiffness, -inverse @ damping])
    steady = inverse @ train.steady_force()
    turning = [
        (spin, inverse @ at_0, inverse @ at_90) for spin, at_0, at_90 in train.turning_force(speed)
    ]
    interfaces = [(train.interface(mesh), mesh.law) for mesh in train.meshes]
    pushes = [inverse[:, at] for at, _ in interfaces]

    def rate(t: float, state: Array) -> Array:
        a = acceleration @ state + steady
        for spin, at_0, at_90 in turning:
            a += np.cos(spin * t) * at_0 + np.sin(spin * t) * at_90
        if train.turning_bows:
            a += inverse @ train.twisted_bow(speed * t, state[:n])
        for (at, law), push in zip(interfaces, pushes, strict=True):
            a += push @ law.force(state[at], state[n + at], live)[1]
        if further is not None:
            a += inverse @ further(t, state[:n], state[n:])
        return np.concatenate([state[n:], a])

    scale = np.concatenate([np.full(n, 1e-14), np.full(n, 1e-10)])  # m and rad; m/s and rad/s
    found = solve_ivp(
        rate, (0.0, times[-1]), np.zeros(2 * n), "DOP853", times, rtol=rtol, atol=scale
    )
    assert found.success, found.message
    return Motion(train, times, found.y[:n].T, found.y[n:].T)


#: Angle, speed and acceleration of the reference shaft at a time.
Turning = Callable[[float], tuple[float, float, float]]


def ramp(start: float, end: float, duration: float, begin: float = 0.0) -> Turning:
    """Return angle, speed and acceleration of a ramp in closed form."""
    slope = (end - start) / duration

    def at(t: float) -> tuple[float, float, float]:
        since = min(max(t - begin, 0.0), duration)
        angle = start * min(t, begin + since) + slope * since**2 / 2
        angle += end * max(0.0, t - begin - duration)
        return angle, start + slope * since, slope if 0.0 < t - begin < duration else 0.0

    return at


def run_up(
    train: Train,
    turning: Turning,
    times: Array,
    *,
    live: bool = True,
    rtol: float = 1e-11,
    kinks: Sequence[float] = (),
    bearings: Callable[[float], tuple[Array, Array]] | None = None,
) -> Motion:
    """Integrate from q = q' = 0 at t = 0 at variable speed; restart at each kink.

    `bearings` gives stiffness and damping (n, n) of further bearings at a speed of the reference shaft.
    """
    n = train.size
    inverse = np.linalg.inv(train.mass)
    grounded, viscous = inverse @ train.grounded, inverse @ train.viscous
    gyroscopic = inverse @ train.gyroscopic
    steady = inverse @ train.steady_force()
    # the bow gives the force at speed 0; speed 1 adds the unbalance times the ratio squared
    shafts = []
    for shaft, bow, both in zip(
        train.shafts, train.turning_force(0.0), train.turning_force(1.0), strict=True
    ):
        pushes = [inverse @ b for b in bow[1:]]
        unbalance = [
            inverse @ (a - b) / shaft.ratio**2 for a, b in zip(both[1:], bow[1:], strict=True)
        ]
        shafts.append((shaft.ratio, pushes, unbalance))
    interfaces = [(train.interface(mesh), mesh.law) for mesh in train.meshes]
    pushes = [inverse[:, at] for at, _ in interfaces]

    def rate(t: float, state: Array) -> Array:
        angle, speed, acceleration = turning(t)
        q, qd = state[:n], state[n:]
        a = steady - grounded @ q - viscous @ qd - speed * (gyroscopic @ qd)
        if bearings is not None:
            stiffness, damping = bearings(speed)
            a -= inverse @ (stiffness @ q + damping @ qd)
        for ratio, (b_0, b_90), (u_0, u_90) in shafts:
            c, s = np.cos(ratio * angle), np.sin(ratio * angle)
            spin, gain = ratio * speed, ratio * acceleration
            # a mass at e exp(i angle) has the acceleration (i gain - spin^2) e exp(i angle)
            a += c * b_0 + s * b_90
            a += spin**2 * (c * u_0 + s * u_90) + gain * (s * u_0 - c * u_90)
        if train.turning_bows:
            a += inverse @ train.twisted_bow(angle, q)
        for (at, law), push in zip(interfaces, pushes, strict=True):
            a += push @ law.force(q[at], qd[at], live)[1]
        return np.concatenate([qd, a])

    scale = np.concatenate([np.full(n, 1e-14), np.full(n, 1e-10)])  # m and rad; m/s and rad/s
    state, columns = np.zeros(2 * n), []
    ends = [0.0, *(kink for kink in kinks if 0.0 < kink < times[-1]), times[-1]]
    for begin, end in pairwise(ends):
        asked = np.append(times[(times >= begin) & (times < end)], end)
        found = solve_ivp(rate, (begin, end), state, "DOP853", asked, rtol=rtol, atol=scale)
        assert found.success, found.message
        columns.append(found.y[:, :-1])
        state = found.y[:, -1]
    columns.append(state[:, np.newaxis])
    y = np.hstack(columns)
    return Motion(train, times, y[:n].T, y[n:].T)
