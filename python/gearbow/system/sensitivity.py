"""Derivatives of results with respect to numbers of a system."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, overload

from gearbow._convert import items, shown
from gearbow._progress import working
from gearbow._types import SensitivityQuantity
from gearbow.analysis.protocol import System
from gearbow.description.parameter import Parameter
from gearbow.errors import SceneError
from gearbow.results.campbell import Campbell
from gearbow.results.frequency_response import FrequencyResponse
from gearbow.results.modes import Modes
from gearbow.results.static import Static
from gearbow.results.synchronous import Synchronous

if TYPE_CHECKING:
    from gearbow.results.response_sensitivity import ResponseSensitivity
    from gearbow.results.sensitivity import Sensitivity


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
        Place, mesh or, of a response, `gb.Probe` or `gb.Accelerometer`, whose signal of a response
        or equilibrium is differentiated.
    quantity : str, optional
        What is differentiated at a place: "displacement" (default), "velocity", "acceleration",
        "twist", "axial_displacement" or "bearing_force"; of an equilibrium no velocity and
        acceleration. A mesh has its force.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Sensitivity or ResponseSensitivity
        Derivatives of the natural frequencies or of the speeds, and of the damping ratios; or of a
        signal of a response or equilibrium.

    Raises
    ------
    SceneError
        If a path does not lead to a number, `of` is not a result of this system, or an argument is
        invalid.
    ConvergenceError
        If the matrices have no derivative with respect to a parameter: it cannot change at all, or
        the nodes would change, for example because a gear would leave the end of a segment.
    GearbowError
        If two modes have equal eigenvalues at an intersection, a count of modes separates them, or
        there is no such place.

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
    from gearbow.system.modal_sensitivity import of_intersections, of_modes  # noqa: PLC0415
    from gearbow.system.parameter_family import ParameterFamily  # noqa: PLC0415
    from gearbow.system.response_sensitivity import (  # noqa: PLC0415
        of_equilibrium,
        of_harmonic,
        of_synchronous,
    )

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
