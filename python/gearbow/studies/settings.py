"""Settings of a study, each method with a series of steps or tolerances, and simplified models."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from typing import Any, Generic

from gearbow.accuracy import MAX_DEGREE
from gearbow.analysis.protocol import S, System, variant
from gearbow.description.shafts import Shaft
from gearbow.description.stiffness import Stiffness
from gearbow.results.properties import ShaftElements


@dataclass(frozen=True)
class Method:
    """A method of integration and the values of its error control."""

    options: Mapping[str, Any]
    control: str
    ladder: tuple[float, ...]
    finest: tuple[float, ...] = ()
    unit: str = ""


#: Methods of a study by name. The first method that fits the budget gives the reference.
METHODS: dict[str, Method] = {
    "exponential": Method(
        {"method": "exponential"},
        "rtol",
        (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10),
        (1e-12, 1e-10, 1e-8),
    ),
    "rk45": Method(
        {"method": "rk45"}, "rtol", (1e-2, 1e-4, 1e-6, 1e-8, 1e-10), (1e-12, 1e-10, 1e-8)
    ),
    "rk4": Method(
        {"method": "rk4"},
        "step",
        (2.5, 1.0, 0.5, 0.25, 0.125),
        (0.03125, 0.0625, 0.125, 0.25),
        "stability",
    ),
    "etdrk4": Method(
        {"method": "etdrk4"}, "step", (0.02, 0.01, 0.004, 0.002, 0.001), unit="passing"
    ),
    **{
        f"exponential, {stages} stages": Method(
            {"method": "exponential", "stages": stages},
            "step",
            (0.1, 0.04, 0.02, 0.01, 0.004),
            unit="passing",
        )
        for stages in (2, 4)
    },
}


@dataclass(frozen=True)
class Setting:
    """A method with a step [s] or a tolerance."""

    method: str
    value: float

    @property
    def options(self) -> dict[str, Any]:
        """The options of `simulate`."""
        method = METHODS[self.method]
        return {**method.options, method.control: self.value}

    def __str__(self) -> str:
        is_step = METHODS[self.method].control == "step"
        return f"{self.method}, " + (
            f"step {self.value:.3g} s" if is_step else f"rtol {self.value:.0e}"
        )


def ladders(
    system: System,
    speed: float,
    names: Sequence[str],
    steps: Sequence[float] | None,
    tolerances: Sequence[float] | None,
) -> list[Setting]:
    """Return the settings of a study, from loose to tight, with alternating methods."""
    columns = []
    for name in names:
        method = METHODS[name]
        given = steps if method.control == "step" else tolerances
        values = _values(system, speed, method, method.ladder) if given is None else list(given)
        columns.append([Setting(name, value) for value in sorted(values, reverse=True)])
    return _alternating(columns)


def references(system: System, speed: float) -> list[Setting]:
    """Return candidates for the reference run, the tightest first."""
    return _alternating(
        [Setting(name, value) for value in _values(system, speed, method, method.finest)]
        for name, method in METHODS.items()
    )


def _alternating(columns: Iterable[list[Setting]]) -> list[Setting]:
    """Return the first settings of all methods, then the second ones, and so on."""
    rows = zip_longest(*columns)
    return [setting for row in rows for setting in row if setting is not None]


def _values(system: System, speed: float, method: Method, ladder: Sequence[float]) -> list[float]:
    if method.control == "rtol":
        return list(ladder)
    if method.unit == "stability":
        unit = _stable_step(system, speed)
        # Three digits, so that the printed options are the options of the run.
        return [float(f"{unit * factor:.3g}") for factor in ladder]
    unit = _passing(system, speed)
    return [_round(unit * factor) for factor in ladder] if math.isfinite(unit) else []


def _round(value: float) -> float:
    """Round to 1, 2 or 5 times a power of ten, so that steps end at the output times."""
    power = math.floor(math.log10(value))
    return float(
        f"{min((1, 2, 5, 10), key=lambda digit: abs(digit - value / 10.0**power))}e{power}"
    )


def _stable_step(system: System, speed: float) -> float:
    """Return the default step of "rk4"."""
    omega = system.simulate(0.0, speed, method="rk4").statistics.omega_max
    few = system.simulate(10.0 / omega, speed, method="rk4", times=[0.0])
    return few.statistics.step_max


def _passing(system: System, speed: float) -> float:
    """Return the shortest period of a shaft rotation or tooth passing."""
    # The default output step is a twentieth of this period.
    return 20.0 * system.default_output_step(math.inf, speed)


#: Name of the model without simplification.
GIVEN = "as given"

#: Stiffness models that are constant over the mesh cycle.
_STEADY = ("constant", "iso6336")


@dataclass(frozen=True, eq=False)
class Model(Generic[S]):
    """A given or simplified system."""

    name: str
    system: S
    options: Mapping[str, Any] = field(default_factory=dict)
    methods: tuple[str, ...] | None = None


def simplified(
    system: S,
    *,
    frozen: bool,
    mean_stiffness: bool,
    factors: Sequence[float],
    degrees: Sequence[int],
    modes: Sequence[int],
) -> list[Model[S]]:
    """Make the simplified models that differ from the given system."""
    found = []
    if frozen and any(_moves(system, mesh.driver) for mesh in system.meshes):
        found.append(Model("frozen geometry", system, {"geometry": "frozen"}))
    if mean_stiffness:
        mean = _with_mean_stiffness(system)
        if mean is not None:
            found.append(Model("mean stiffness", mean))
    others = {f"elements × {factor:g}": _with_elements(system, factor) for factor in factors}
    others |= {f"degree {degree}": _with_elements(system, degree=degree) for degree in degrees}
    found += [Model(name, other) for name, other in others.items() if other is not None]
    found += [
        Model(f"{count} modes", system, {"modes": count}, ("exponential",)) for count in modes
    ]
    return found


def refined(system: S, degrees: Sequence[int]) -> Model[S]:
    """Make the model with finer elements than all others: the reference of the total error."""
    degree = max(*degrees, *degrees_of(system)) + 1
    # Degree 2 improves the lowest frequencies of few elements too little.
    degree = max(degree, 3)
    if degree <= MAX_DEGREE:
        return Model(f"degree {degree}", _with_elements(system, degree=degree) or system)
    finer = _with_elements(system, factor=2.0, degree=MAX_DEGREE)
    return Model(f"elements × 2, degree {MAX_DEGREE}", finer or system)


def degrees_of(system: System) -> list[int]:
    """Give the degrees of the elements of a system."""
    return [each.degree for each in system.discretisation.shafts.values()]


def _moves(system: System, gear: str) -> bool:
    """Tell whether the system models the lateral motion of a gear."""
    (shaft,) = (other.shaft for other in system.gears if other.name == gear)
    return any(name == shaft and direction == "v" for name, _, direction in system.dofs)


def _with_mean_stiffness(system: S) -> S | None:
    """Replace time-varying mesh stiffness by its mean, without tip relief."""
    varying = [mesh for mesh in system.meshes if _varies(mesh.stiffness)]
    if not varying:
        return None
    # Without backlash and tip relief the equilibrium has the mean stiffness of the cycle.
    closed = [replace(mesh, backlash=None, tip_relief=None) for mesh in system.meshes]
    static = variant(system, meshes=closed).static()
    meshes = []
    for mesh in system.meshes:
        if mesh in varying:
            mean = static.mesh((mesh.driver, mesh.driven)).stiffness
            mesh = replace(mesh, tip_relief=None, stiffness=mean)  # noqa: PLW2901
        meshes.append(mesh)
    return variant(system, meshes=meshes)


def _varies(stiffness: object) -> bool:
    return isinstance(stiffness, Stiffness) and stiffness.model not in _STEADY


def _with_elements(system: S, factor: float = 1.0, degree: int | None = None) -> S | None:
    """Multiply the numbers of elements, and change the degree; None if nothing changes."""
    known = system.discretisation.shafts
    shafts = [_scaled(shaft, known[shaft.name], factor, degree) for shaft in system.shafts]
    other = variant(system, shafts=shafts)
    return None if other.dofs == system.dofs else other


def _scaled(shaft: Shaft, known: ShaftElements, factor: float, degree: int | None) -> Shaft:
    """Multiply the numbers of elements of a shaft, and change the degree."""
    numbers = [max(1, round(number * factor)) for number in known.numbers]
    shaft = replace(shaft, degree=known.degree if degree is None else degree)
    if shaft.segments is None:
        return replace(shaft, elements=numbers[0])
    segments = [
        replace(segment, elements=number)
        for segment, number in zip(shaft.segments, numbers, strict=True)
    ]
    return replace(shaft, segments=segments)
