"""Methods of every program, each with its settings from cheap to expensive."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

import gearbow as gb
from gearbow._types import Method as IntegrationMethod
from programs.scenes import SPEED, Array, Scene

Settings: TypeAlias = tuple[dict[str, float], ...]
#: Runs a prepared simulation, repeatable; returns displacements (points, times, 2) in m.
Run: TypeAlias = Callable[[], Array]
#: Prepares a run from duration [s], setting and limit of the CPU time [s].
Prepare: TypeAlias = Callable[[float, dict[str, float], float], Run]


class TooSlow(Exception):  # noqa: N818  # a stop signal, not an error
    """A run reached its limit of CPU time; `done` is the time it has simulated [s]."""

    def __init__(self, done: float) -> None:
        super().__init__(done)
        self.done = done


@dataclass(frozen=True)
class Method:
    """A way to simulate a scene."""

    program: str
    name: str
    prepare: Callable[[Scene], Prepare]
    settings: Settings
    short: bool = False  # whether it simulates only a part of the duration
    ross: bool = False  # whether it can simulate only the scenes that ROSS supports
    only: str = ""  # the only scene of this method; empty: all scenes that the program can model

    @property
    def title(self) -> str:
        """Program and method."""
        return f"{self.program} {self.name}"


def of_gearbow(method: IntegrationMethod) -> Callable[[Scene], Prepare]:
    """Prepare runs of gearbow; fixed steps h are given as h ω, with the highest frequency ω."""

    def prepare(scene: Scene) -> Prepare:
        system = scene.build()
        rest = system.simulate(0.0, scene.speed, initial="rest", geometry=scene.geometry)
        spectrum = rest.statistics

        def with_setting(duration: float, setting: dict[str, float], _: float) -> Run:
            options: dict[str, Any] = dict(setting)
            if "h ω" in options:
                options = {"step": options["h ω"] / spectrum.omega_max}

            def run() -> Array:
                response = system.simulate(
                    duration,
                    scene.speed,
                    method=method,
                    initial="rest",
                    times=scene.times(duration),
                    record=list(scene.points),
                    geometry=scene.geometry,
                    **options,
                )
                return np.stack([response.displacement(point) for point in scene.points])

            return run

        return with_setting

    return prepare


def of_scipy(method: str, limit: float = np.inf) -> Callable[[Scene], Prepare]:
    """Prepare runs of SciPy; `limit` is the longest step as h ω, with the highest frequency ω.

    Error control alone does not keep an explicit method stable for undamped stiff systems.
    """

    def prepare(scene: Scene) -> Prepare:
        from scipy.integrate import solve_ivp  # noqa: PLC0415  # not needed by gearbow

        from programs.dense import Dense  # noqa: PLC0415

        system = scene.build()
        dense = Dense(system, scene.geometry, SPEED)
        omega = system.simulate(0.0, SPEED, initial="rest").statistics.omega_max
        options: dict[str, Any] = {"max_step": limit / omega}
        if method in {"Radau", "LSODA"}:
            options["jac"] = lambda _t, _y: dense.jacobian
        rows = [[dense.index[shaft, x, d] for d in ("v", "w")] for shaft, x in scene.points]

        def with_setting(duration: float, setting: dict[str, float], patience: float) -> Run:
            def run() -> Array:
                deadline = time.process_time() + patience

                def rate(t: float, y: Array) -> Array:
                    if time.process_time() > deadline:
                        raise TooSlow(t)
                    return dense(t, y)

                times, rtol = scene.times(duration), setting["rtol"]
                start, span = np.zeros(2 * dense.n), (0.0, float(times[-1]))
                tolerance = {"rtol": rtol, "atol": 1e-6 * rtol}
                found = solve_ivp(rate, span, start, method, times, **tolerance, **options)
                return np.moveaxis(found.y[rows], 1, 2)

            return run

        return with_setting

    return prepare


def of_modes(method: str, count: int) -> Callable[[Scene], Prepare]:
    """Prepare runs of SciPy on the lowest modes of one shaft with unbalance and modal damping."""

    def prepare(scene: Scene) -> Prepare:
        from scipy.integrate import solve_ivp  # noqa: PLC0415  # not needed by gearbow

        from programs.few_modes import FewModes  # noqa: PLC0415

        modes = FewModes(scene, count)

        def with_setting(duration: float, setting: dict[str, float], _: float) -> Run:
            def run() -> Array:
                times, rtol = scene.times(duration), setting["rtol"]
                start, span = np.zeros(2 * count), (0.0, float(times[-1]))
                tolerance = {"rtol": rtol, "atol": 1e-5 * rtol}
                found = solve_ivp(modes, span, start, method, times, **tolerance)
                return modes.displacements(found.y)

            return run

        return with_setting

    return prepare


def of_ross(method: str) -> Callable[[Scene], Prepare]:
    """Prepare runs of ROSS; the force table is computed before the timed run."""

    def prepare(scene: Scene) -> Prepare:
        from programs.ross_rotor import Ross  # noqa: PLC0415  # slow import

        model = Ross(scene.build(), SPEED)

        def with_setting(duration: float, setting: dict[str, float], _: float) -> Run:
            step = setting["step"]
            times = np.linspace(0.0, duration, round(duration / step) + 1)
            force = model.force(times)
            every = max(1, round(scene.sample / step))

            def run() -> Array:
                motion = model.simulate(force, times, method)[::every]
                return np.stack([model.displacement(point, motion) for point in scene.points])

            return run

        return with_setting

    return prepare


def offered(name: str) -> bool:
    """Return whether the installed gearbow has a method; text after a comma is ignored."""
    method: Any = name.partition(",")[0]
    try:
        rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=1)
        gb.RotorSystem([rotor]).simulate(0.0, 0.0, method=method, initial="rest", record=["rotor"])
    except gb.SceneError as error:
        if str(error).startswith("method:"):
            return False
        raise
    return True


def each(key: str, *values: float) -> Settings:
    """Return one setting for each value."""
    return tuple({key: value} for value in values)


STEPS = each("h ω", 2.6, 2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25)
TOLERANCES = each("rtol", 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
#: Two stages; the default has three.
COARSE = {"rtol": 0.1, "stages": 2}
#: The same with a reduced basis: the 80 modes with the largest response to the loads.
FEWER = {"rtol": 0.1, "stages": 2, "modes": 80}
#: Hundreds of times more accurate than RK4 with its longest stable step, with separation.
CLOSE = {"rtol": 5e-6, "stages": 3}
#: Time steps of the force table that ROSS interpolates [s].
TABLES = each("step", 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5)
NEWMARK = each("step", 5e-5, 2e-5, 1e-5, 5e-6, 2.5e-6, 2e-6)

#: Reference solution.
REFERENCE = Method("gearbow", "rk45", of_gearbow("rk45"), each("rtol", 1e-10))
#: Independent check of the reference.
CHECK = Method("SciPy", "DOP853", of_scipy("DOP853", 5.8), each("rtol", 1e-10), short=True)

METHODS = (
    Method("gearbow", "exponential", of_gearbow("exponential"), (COARSE, *TOLERANCES)),
    Method("gearbow", "exponential, 80 modes", of_gearbow("exponential"), (FEWER,)),
    Method(
        "gearbow",
        "exponential, tighter tolerance",
        of_gearbow("exponential"),
        (CLOSE,),
        only="separation",
    ),
    Method("gearbow", "rk45", of_gearbow("rk45"), TOLERANCES),
    Method("gearbow", "rk4", of_gearbow("rk4"), STEPS),
    Method("SciPy", "RK45", of_scipy("RK45", 0.98), TOLERANCES, short=True),
    Method("SciPy", "DOP853", of_scipy("DOP853", 5.8), TOLERANCES, short=True),
    Method("SciPy", "Radau", of_scipy("Radau"), TOLERANCES, short=True),
    Method("SciPy", "LSODA", of_scipy("LSODA"), TOLERANCES, short=True),
    Method("SciPy", "RK45 on 6 modes", of_modes("RK45", 6), TOLERANCES[2:], only="jeffcott"),
    Method("SciPy", "DOP853 on 6 modes", of_modes("DOP853", 6), TOLERANCES[2:], only="jeffcott"),
    Method("ROSS", "lsim", of_ross("default"), TABLES, ross=True),
    Method("ROSS", "newmark", of_ross("newmark"), NEWMARK, short=True, ross=True),
)
