"""Derivatives with respect to numbers of the description; of modes and critical speeds."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from gearbow._convert import items, shown
from gearbow._core import Model
from gearbow._progress import working
from gearbow._types import Array, ComplexArray, SensitivityQuantity
from gearbow.analysis.protocol import System
from gearbow.description.train import Parameter
from gearbow.errors import GearbowError, SceneError
from gearbow.results.campbell import Campbell
from gearbow.results.frequency_response import FrequencyResponse
from gearbow.results.modes import Modes
from gearbow.results.sensitivity import Sensitivity
from gearbow.results.static import Static
from gearbow.results.synchronous import Synchronous
from gearbow.system.parameter_family import (
    Motions,
    ParameterFamily,
    Terms,
    described,
    is_damped,
    require_memory_of,
)

if TYPE_CHECKING:
    from gearbow.results.sensitivity import ResponseSensitivity


#: Eigenvalues with a smaller relative difference are equal.
_EQUAL = 1e-8


@dataclass(frozen=True)
class _Group:
    """Equal eigenvalues at one speed with their vectors, for which yᵀ (C + 2λM) x = 1."""

    value: complex
    speed: float
    #: Right and left vectors (count, n).
    right: ComplexArray
    left: ComplexArray

    @classmethod
    def of(
        cls, model: Model, at: tuple[complex, float], count: int, highest: float, what: str
    ) -> "_Group":
        """Compute the vectors of a number of eigenvalues at a value and a speed."""
        value, speed = at
        found = model.null_vectors((value.real, value.imag), speed, count, highest)
        if not found["is_accurate"]:
            raise SceneError(f"of: {what} is no mode of this system; give a result of this system")
        if found["has_more"]:
            raise GearbowError(
                f"of: {what} has the same eigenvalue as another mode, so that it has no derivative "
                "by itself; compute modes with a count that contains both"
            )
        product = found["slopes"]
        if np.linalg.cond(product) > 1.0 / _EQUAL:
            raise GearbowError(
                f"of: the eigenvalues of {what} have fewer vectors than their number (critical "
                "damping), so that they have no derivative; change the damping or leave it out"
            )
        left = np.linalg.solve(product, found["left"]).astype(np.complex128)
        return cls(value, speed, found["right"], left)


def _motions(
    family: ParameterFamily, parameters: Sequence[Parameter], groups: Sequence[_Group]
) -> Motions:
    """Give the motions of groups, whose vectors are filled up with zeros to the same number."""
    size = len(family.names)
    most = max((len(group.right) for group in groups), default=0)
    require_memory_of(len(groups), size, 2 * most)

    def filled(name: str) -> ComplexArray:
        found = np.zeros((len(groups), most, size), dtype=np.complex128)
        for own, group in zip(found, groups, strict=True):
            own[: len(group.right)] = getattr(group, name)
        return found

    return Motions(
        family,
        np.array([group.value for group in groups], dtype=np.complex128),
        np.array([group.speed for group in groups], dtype=np.float64),
        filled("right"),
        filled("left"),
        # No source excites a mode.
        [],
        np.zeros((0, size), dtype=np.complex128),
        [0] * most,
        is_damped(family, parameters),
    )


def _derivatives(motions: Motions, parameter: Parameter) -> ComplexArray:
    """Give -yᵀ dZ/dp x of all groups."""
    return motions.slopes(parameter, motions.highest, lambda _: motions.outputs)


def of_modes(family: ParameterFamily, parameters: Sequence[Parameter], of: Modes) -> Sensitivity:
    """Give the derivatives of the modes of a result."""
    members = _equal([complex(value) for value in of.eigenvalues])
    kept = [own for own in members if of.whirl[own[0]] != "rigid" and of.eigenvalues[own[0]] != 0.0]
    values = [complex(np.mean(of.eigenvalues[own])) for own in kept]
    highest = max(map(abs, values), default=1.0)
    groups = [
        _Group.of(family.base._model, (value, of.speed), len(own), highest, f"mode {own[0] + 1}")
        for value, own in zip(values, kept, strict=True)
    ]
    motions = _motions(family, parameters, groups)
    slopes = np.full((len(parameters), of.eigenvalues.size), complex(np.nan, np.nan))
    for row, parameter in enumerate(parameters):
        for own, form in zip(kept, _derivatives(motions, parameter), strict=True):
            found = np.linalg.eigvals(form[: len(own), : len(own)])
            slopes[row, own] = found[np.argsort(found.imag, kind="stable")]
    frequencies = np.abs(of.eigenvalues.imag) / (2.0 * math.pi)
    return Sensitivity(
        kind="frequency",
        **described(parameters),
        outputs=tuple(f"mode {i + 1} ({whirl})" for i, whirl in enumerate(of.whirl)),
        output_values=frequencies,
        derivatives=np.sign(of.eigenvalues.imag) * slopes.imag / (2.0 * math.pi),
        damping_ratios=_damping_slopes(of.eigenvalues, slopes),
        equal=tuple(tuple(i + 1 for i in own) for own in kept if len(own) > 1),
        speed=of.speed,
    )


def _equal(values: list[complex]) -> list[list[int]]:
    """Group equal eigenvalues."""
    groups: list[list[int]] = []
    for i, value in enumerate(values):
        for own in groups:
            if abs(value - values[own[0]]) <= _EQUAL * abs(value):
                own.append(i)
                break
        else:
            groups.append([i])
    return groups


def _damping_slopes(values: ComplexArray, slopes: ComplexArray) -> Array:
    """Differentiate the damping ratio -Re λ/|λ|."""
    with np.errstate(invalid="ignore", divide="ignore"):
        cross = values.real * slopes.imag - values.imag * slopes.real
        found: Array = values.imag * cross / np.abs(values) ** 3
    return found


def _along(motions: Motions) -> complex:
    """Give the derivative of one eigenvalue with respect to the speed."""
    model, speed = motions.family.base._model, float(motions.speeds[0])

    def of(value: float) -> list[Terms]:
        return motions.terms(model, motions.outputs, speed=value)

    gyroscopic = sum(motions.of_entries(each.gyroscopic()) for each in of(speed))
    found = complex(np.ravel(gyroscopic)[0]) / speed
    if model.depends_on_speed:
        found += complex(motions.change(of, "speed", speed, motions.highest)[0, 0, 0])
    return found


def of_intersections(
    family: ParameterFamily, parameters: Sequence[Parameter], of: Campbell
) -> Sensitivity:
    """Give the derivatives of the intersections of a Campbell diagram."""
    # An eigenvalue λ = σ + i n Ω of order n moves by a dp + b dΩ, so that dΩ/dp = Im a/(n - Im b).
    crossings = of.intersections
    ratios = [crossing.damping_ratio for crossing in crossings]
    frequencies = [2.0 * math.pi * crossing.frequency_hz for crossing in crossings]
    values = [
        complex(-ratio * frequency / math.sqrt(1.0 - ratio**2), frequency)
        for ratio, frequency in zip(ratios, frequencies, strict=True)
    ]
    highest, model = max(map(abs, values), default=1.0), family.base._model
    groups = [
        _Group.of(model, (value, crossing.speed), 1, highest, f"intersection {i + 1}")
        for i, (value, crossing) in enumerate(zip(values, crossings, strict=True))
    ]
    motions = _motions(family, parameters, groups)
    speeds = motions.speeds
    along = [_along(_motions(family, parameters, [group])) for group in groups]
    orders = np.array([crossing.line.order for crossing in crossings])
    rates, shape = np.array(along, dtype=complex), (len(parameters), len(crossings))
    fixed = np.empty(shape, dtype=complex)
    for row, parameter in enumerate(parameters):
        fixed[row] = _derivatives(motions, parameter)[:, 0, 0]
    derivatives = fixed.imag / (orders - rates.imag)
    return Sensitivity(
        kind="critical speed",
        **described(parameters),
        outputs=tuple(f"mode {each.mode + 1} with {each.line.name}" for each in crossings),
        output_values=speeds,
        derivatives=derivatives,
        damping_ratios=_damping_slopes(
            np.array(values, dtype=complex), fixed + rates * derivatives
        ),
        equal=(),
        speed=None,
    )


@overload
def sensitivity(
    self: System,
    parameters: str | Sequence[str],
    of: Modes | Campbell,
    *,
    progress: bool | None = None,
) -> "Sensitivity": ...
@overload
def sensitivity(
    self: System,
    parameters: str | Sequence[str],
    of: FrequencyResponse | Synchronous | Static,
    *,
    at: Any,
    quantity: SensitivityQuantity = "displacement",
    progress: bool | None = None,
) -> "ResponseSensitivity": ...
def sensitivity(
    self: System,
    parameters: str | Sequence[str],
    of: Modes | Campbell | FrequencyResponse | Synchronous | Static,
    *,
    at: Any = None,
    quantity: SensitivityQuantity | None = None,
    progress: bool | None = None,
) -> "Sensitivity | ResponseSensitivity":
    """Find derivatives of a result with respect to parameters of the system.

    Parameters
    ----------
    parameters : str or sequence of str
        Numbers of the system by their path, for example "bearings[0].stiffness",
        "shafts['input'].segments[1].outer_diameter", "gears['wheel'].position" or
        "modal_damping". Entries of lists have numbers from 0, or names in quotes.
    of : Modes, Campbell, FrequencyResponse, Synchronous or Static
        Result of this system: its modes; its Campbell diagram, for the intersections with the
        excitation lines (critical speeds and tooth resonances); a response or the equilibrium.
    at : str, tuple or sensor, optional
        Place, mesh or, of a response, sensor, whose signal is differentiated.
    quantity : str, optional
        What is differentiated at a place: "displacement" (default), "velocity", "acceleration",
        "twist", "axial_displacement" or "bearing_force"; of an equilibrium no velocity and
        acceleration. A mesh has its force.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Sensitivity or ResponseSensitivity
        Derivatives of frequencies or speeds and damping ratios; or of a signal.

    Raises
    ------
    SceneError
        If a path does not lead to a number, or `of` is not a result of this system.
    ConvergenceError
        If the matrices have no derivative with respect to a parameter: it cannot change at all, or
        the nodes would change, for example because a gear would leave the end of a segment.
    GearbowError
        If two modes meet at an intersection, a count separates equal ones, or the place is unknown.

    Notes
    -----
    For an eigenvalue with the right and the left vector x and y, the derivative is
    ``-yᴴ(dK + λ dC + λ² dM)x / yᴴ(C + 2λM)x``, where C includes ΩG. Groups of equal eigenvalues
    have the eigenvalues of their small matrix. For a response ``Z a = f`` with the output ``r a``,
    it is ``dr a + y(df - dZ a)`` with one adjoint solution ``Zᵀ y = r`` for all parameters. For an
    equilibrium q with the unbalanced forces F(q, p), ``dq = K⁻¹ dF`` with the tangent K. The
    derivatives of the matrices are central differences of the entries that change with the
    parameter, with two or three steps, extrapolated; those of an equilibrium (oil films) are
    included. The derivative of modal damping follows from the undamped modes of the system itself;
    above 250 degrees of freedom, from those that have damping in the response. Elements keep their
    number and their degree, and move with the segments and the parts at their ends. R. L. Fox, M.
    P. Kapoor, *Rates of change of eigenvalues and eigenvectors*, AIAA J. 6 (1968); equal
    eigenvalues: H. Baumgärtel, *Analytic perturbation theory* (1985); adjoint solutions: M. B.
    Giles, N. A. Pierce, *An introduction to the adjoint approach to design*, Flow Turbul. Combust.
    65 (2000).

    Examples
    --------
    The first critical speed of a stiff shaft in soft bearings is nearly proportional to the square
    root of their stiffness:

    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=0.2, outer_diameter=0.1)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e7) for x in (0.0, 0.2)]
    >>> system = gb.RotorSystem([rotor], bearings=bearings, motion="lateral")
    >>> paths = ["bearings[0].stiffness", "bearings[1].stiffness"]
    >>> found = system.sensitivity(paths, system.campbell([100.0, 2000.0], count=2))
    >>> f"{found.relative[:, 0].sum():.2f}"
    '0.50'

    The static deflection under a force is inversely proportional to it:

    >>> push = gb.Force(("rotor", 0.0), 1.0)
    >>> response = system.frequency_response([0.0], source=push)
    >>> found = system.sensitivity(paths, response, at=("rotor", 0.0))
    >>> found.relative[:, 0, 0, 0].round(2)
    array([-1., -0.])
    """
    # With the modules of the computations.
    from gearbow.system.response_sensitivity import of_equilibrium, of_harmonic, of_synchronous  # noqa: PLC0415

    given = [parameters] if isinstance(parameters, str) else items(parameters, "parameters", "text")
    if not given:
        raise SceneError('parameters: name at least one, such as "bearings[0].stiffness"')
    if not isinstance(of, Modes | Campbell | FrequencyResponse | Synchronous | Static):
        raise SceneError(
            "of: must be a result of modes, campbell, frequency_response, synchronous or static, "
            f"got {shown(of)}"
        )
    if isinstance(of, Modes | Campbell):
        for name, value in (("at", at), ("quantity", quantity)):
            if value is not None:
                raise SceneError(f"{name}: belongs to responses and equilibria, got {shown(value)}")
    elif at is None:
        raise SceneError("at: name the place, mesh or sensor whose signal is differentiated")
    wanted = "displacement" if quantity is None else quantity
    family = ParameterFamily(self)
    found = [Parameter.find(family.entry, path, f"parameters[{i}]") for i, path in enumerate(given)]
    with working(progress, f"derivatives with respect to {len(found)} parameters"):
        if isinstance(of, Modes):
            return of_modes(family, found, of)
        if isinstance(of, Campbell):
            return of_intersections(family, found, of)
        if isinstance(of, FrequencyResponse):
            return of_harmonic(family, found, of, at, wanted)
        if isinstance(of, Synchronous):
            return of_synchronous(family, found, of, at, wanted)
        return of_equilibrium(family, found, of, at, wanted)
