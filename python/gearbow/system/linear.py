"""Linear and static analyses of a system."""

from typing import TYPE_CHECKING, get_args

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, number, one_of, text, truth, whole
from gearbow._core import require_memory, shaft_origins
from gearbow._parallel import thread_count
from gearbow._progress import working
from gearbow._types import Excitation, Geometry
from gearbow.analysis.protocol import System
from gearbow.description.layout import Layout, layout, left_out, ratios_by_shaft
from gearbow.description.loads import Bearing
from gearbow.description.part import Part
from gearbow.description.speed import SpeedTable
from gearbow.errors import SceneError
from gearbow.results.campbell import Campbell
from gearbow.results.critical_speeds import CriticalSpeedMap
from gearbow.results.modes import Modes
from gearbow.results.properties import Matrices
from gearbow.results.static import Static
from gearbow.results.synchronous import Synchronous

if TYPE_CHECKING:
    from gearbow.results.properties import MassProperties
    from gearbow.results.static import Efficiency


def matrices(
    self: System, speed: float = 0.0, sparse: bool = False, *, frequency: float | None = None
) -> Matrices:
    """Assemble the matrices of the linear equations of motion.

    Parameters
    ----------
    speed : float
        Speed of the reference shaft [rad/s], whose sign, or at 0 the torques, choose the flanks.
    sparse : bool
        Whether the matrices are sparse ones of SciPy, with memory in proportion to their size.
    frequency : float, optional
        Frequency of the vibration [rad/s] for bearings whose coefficients depend on it.

    Returns
    -------
    Matrices
        Mass, stiffness, damping and gyroscopic matrix, with meshes at rest on the flank in contact.

    Raises
    ------
    SceneError
        If dense matrices do not fit into memory, sparse ones are asked for with modal damping,
        whose matrix has no zeros, or a bearing needs a frequency.
    """
    at = number(speed, "speed"), None if frequency is None else number(frequency, "frequency")
    if truth(sparse, "sparse"):
        return Matrices._from_sparse(self._model.sparse_matrices(*at), self.dofs)
    return Matrices(**self._model.matrices(*at), dofs=self.dofs)


def modes(
    self: System,
    speed: float = 0.0,
    *,
    count: int | None = None,
    vibrating: bool = False,
    progress: bool | None = None,
) -> Modes:
    """Find natural frequencies, damping, whirl and shapes at one speed.

    Parameters
    ----------
    speed : float
        Speed of the reference shaft [rad/s].
    count : int, optional
        Number of modes, those of smallest abs(λ); None is all.
    vibrating : bool
        Whether to leave out modes that are no vibrations, as Campbell diagrams do: the rotation of
        the train, growth without oscillation, and overdamped motions, with abs(Im λ) of at most
        0.05 abs(λ). A shaft with internal damping relaxes in its own frame, λ ≈ −1/β + iΩ as seen
        from the ground; with abs(Im λ − Ω) of at most 0.05 abs(λ − iΩ) this is no vibration either.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Modes
        The modes in ascending order of abs(λ), rigid-body modes first. For lightly damped modes
        this is the order of their frequencies. With `count` and `vibrating`, the first vibrations
        in this order, fewer if the system has fewer. A text says how many are overdamped.

    Raises
    ------
    SceneError
        If the speed or the count is invalid, or the coefficients of a bearing depend on the
        frequency and a mode has one that its table does not contain.
    ConvergenceError
        If the residual of a mode exceeds 1e-4 and its round-off ``100 ε ω_max/|λ|``, at most 0.1.

    Notes
    -----
    Where coefficients of bearings depend on the frequency, each mode has those at its own.
    """
    speed = number(speed, "speed")
    most = None if count is None else whole(count, "count")
    with working(progress, "modes"):
        data = self._model.modes(speed, most, truth(vibrating, "vibrating"))
    return Modes._from_data(data, speed, self.coordinates, layout_of(self))


def layout_of(self: System) -> Layout:
    """Find the geometry of the train at rest."""
    return layout(self, shaft_origins(self.description))


def mass_properties(self: System) -> "MassProperties":
    """Find mass, centre of mass and moments of inertia of each shaft and of the machine.

    Returns
    -------
    MassProperties
        The shafts with their sleeves, gears and disks. Compare them with a drawing first.
    """
    from gearbow.results.properties import MassProperties  # noqa: PLC0415

    names = [shaft.name for shaft in self.shafts]
    origins = shaft_origins(self.description)
    return MassProperties._of(names, self._model.mass_properties(), origins)


def static(
    self: System, speed: float = 0.0, *, geometry: Geometry = "live", progress: bool | None = None
) -> Static:
    """Find the equilibrium under torque, gravity and the non-linear meshes.

    Parameters
    ----------
    speed : float
        Speed of the reference shaft [rad/s]. Its sign determines the drive flanks. A torque
        against the rotation presses the back flanks, with a negative mesh force. At speed 0
        the torques determine the drive flanks. Journal bearings have the film force of this
        speed and carry nothing at speed 0. Other forces that depend on the speed are not
        included.
    geometry : {"live", "frozen"}
        Whether the line of action follows the moving centres or is that at rest.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Static
        Displacements, mesh states, bearing forces, and what remains unbalanced (`residual`).

    Raises
    ------
    SceneError
        If the speed is not finite, or the loads have no equilibrium.
    ContactError
        If the base circles of a pair overlap in live geometry.
    ConvergenceError
        If more than 1e-6 of the load of a shaft, support or housing remains; the error names it.
    """
    text(geometry, "geometry")
    speed = number(speed, "speed")
    with working(progress, "equilibrium"):
        data = self._model.static(geometry, speed)
    return Static(
        data,
        self.coordinates,
        layout=layout_of(self),
        description=self._model.resolved(),
        speed=speed,
        geometry=geometry,
        ratios=ratios_by_shaft(self),
        excitations=left_out(self, ()),
    )


def efficiency(
    self: System,
    speeds: "ArrayLike",
    *,
    geometry: Geometry = "live",
    progress: bool | None = None,
) -> "Efficiency":
    """Find the losses by friction of the teeth, and the efficiency of the train.

    Parameters
    ----------
    speeds : float or array_like, shape (k,)
        Speeds of the reference shaft [rad/s], not zero.
    geometry : {"live", "frozen"}
        Whether the path of contact is that of the displaced centres or that at rest.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Efficiency
        Power, coefficient of friction and loss of each mesh, and the efficiency of the train.

    Raises
    ------
    SceneError
        If no mesh has friction, or a speed is zero; and the errors of `static`.
    ContactError
        If the base circles of a pair overlap in live geometry.
    ConvergenceError
        If the static equilibrium does not converge.

    Notes
    -----
    The force of each mesh is that of the static equilibrium without friction. Its tooth pairs share
    it as the stiffness model says, equally without tooth pairs, and the loss is the mean over the
    mesh cycle. For pairs of equal stiffness that is μ P H_v with the tooth loss factor of Ohlendorf
    (1958). Churning of oil, seals and the friction of bearings are not modelled. Bow, unbalance and
    tooth errors are left out; `MeshResponse.friction_power` of a run contains them.
    """
    from gearbow.results.static import Efficiency  # noqa: PLC0415

    wanted = array(speeds, "speeds")
    one_of(geometry, get_args(Geometry), "geometry")
    if np.any(wanted == 0.0):
        raise SceneError(
            f"speeds[{int(np.argmin(np.abs(wanted)))}]: must not be zero: teeth at rest transmit "
            "no power"
        )
    with working(progress, f"efficiency at {wanted.size} speeds"):
        if not any("friction" in mesh for mesh in self.description.get("meshes", ())):
            raise SceneError(
                "meshes: no mesh has friction; give one a coefficient, such as friction = 0.05"
            )
        found = self._model.losses(wanted.tolist(), geometry)
    power, force, coefficient, loss = np.array([rows for _, rows in found]).transpose(2, 0, 1)
    return Efficiency(
        meshes=tuple((mesh.driver, mesh.driven) for mesh in self.meshes),
        speeds=wanted,
        input_power=np.array([power for power, _ in found]),
        power=power,
        force=force,
        coefficient=coefficient,
        loss=loss,
        left_out=left_out(self, ()),
    )


def campbell(
    self: System,
    speeds: "ArrayLike",
    *,
    count: int = 10,
    harmonics: int = 1,
    threads: int | None = None,
    progress: bool | None = None,
) -> Campbell:
    """Follow the modes over the speed, and find their intersections with excitation lines.

    Parameters
    ----------
    speeds : array_like, shape (k,)
        Speeds of the reference shaft [rad/s], from 0 or any other speed away from it. Negative ones
        are a rotation in the other sense, for example 0, -100, -200.
    count : int
        Number of modes without the rotation, from the lowest frequency at the first speed.
    harmonics : int
        Number of harmonics of every tooth frequency; 0 omits the teeth.
    threads : int, optional
        Largest number of threads. None is the number in the environment variable
        ``GEARBOW_THREADS``, or without it that of the cores. The result does not depend on it.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Campbell
        Eigenvalues and whirl of each mode, the intersections, and the stability thresholds. An
        eigenvalue problem gives intersections and thresholds to about 1e-12 of the speed, for
        any spacing of `speeds`.

    Raises
    ------
    ConvergenceError
        If the residual of a mode, an intersection or a threshold exceeds the limit of `modes`.
    """
    wanted = array(speeds, "speeds")
    count = whole(count, "count")
    harmonics = whole(harmonics, "harmonics", least=0)
    workers = thread_count(threads)
    with working(progress, f"Campbell diagram of {wanted.size} speeds"):
        data = self._model.campbell(wanted, count, harmonics, workers)
    return Campbell._from_data(wanted, data)


def critical_speed_map(
    self: System,
    stiffnesses: "ArrayLike",
    *,
    order: float = 1.0,
    count: int | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> CriticalSpeedMap:
    """Find the undamped critical speeds against the bearing stiffness.

    Parameters
    ----------
    stiffnesses : array_like, shape (k,)
        Stiffnesses of every bearing along y and z [N/m]. Damping has no effect.
    order : float
        Order of the excitation. At a critical speed, an undamped mode has the frequency
        order·Ω > 0. The order is 1 for unbalance of the reference shaft, and -1 for the same at
        negative speeds, where the other flanks are in contact.
    count : int, optional
        Number of the lowest critical speeds at each stiffness, which saves time; None is all.
    threads : int, optional
        Largest number of threads, as for `campbell`.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    CriticalSpeedMap
        Critical speeds by an eigenvalue problem at each stiffness, their whirl, residual and lines.

    Raises
    ------
    ConvergenceError
        If a mode does not satisfy the equations of motion.

    Notes
    -----
    Modes at neighbouring stiffnesses are matched by their shapes, as those of a Campbell
    diagram; the step of the stiffness is halved, up to six times, where the match is uncertain.
    All stiffnesses have the elements that the largest one needs.
    """
    wanted = array(stiffnesses, "stiffnesses")
    order = number(order, "order")
    count = None if count is None else whole(count, "count")
    workers = thread_count(threads)
    # The shortest list of critical speeds is empty; each speed is an object with its whirl.
    size = 500.0 * wanted.size * (1 + min(count or 2 * len(self.dofs), 2 * len(self.dofs)))
    what = f"the critical speeds at {wanted.size} stiffnesses"
    require_memory("stiffnesses", what, size, "give fewer stiffnesses, or a smaller count")
    with working(progress, f"critical speeds at {wanted.size} stiffnesses"):
        found = self._model.critical_speed_map(wanted, order, count, workers)
    actual = tuple(stiffness for each in self.bearings for stiffness in _stiffnesses(each))
    return CriticalSpeedMap._from_rows(wanted, order, found, actual)


def synchronous(
    self: System,
    speeds: "ArrayLike",
    *,
    excitation: Excitation = "both",
    threads: int | None = None,
    progress: bool | None = None,
) -> Synchronous:
    """Find the linear response to what turns once with a shaft, without time stepping.

    Where planets move laterally on a carrier that turns, the response is that in the frame of the
    carrier, with the speed of the shaft relative to it.

    Parameters
    ----------
    speeds : array_like, shape (speeds,) or scalar
        Speeds of the reference shaft [rad/s].
    excitation : {"both", "bow", "unbalance"}
        The excitation: "both" is bow, unbalance, turning forces of order 1, run-out of gears and
        couplings, and transmission errors of order 1 of a shaft; "bow" is bow and turning forces.
    threads : int, optional
        Largest number of threads, as for `campbell`.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Synchronous
        Complex amplitudes for each speed and each shaft as the source.

    Raises
    ------
    ConvergenceError
        If the residual of the response to a shaft exceeds 1e-4.

    Warns
    -----
    AccuracyWarning
        If the motion is unstable at some of the speeds: a mode with negative damping grows, so
        that the response does not occur. The message gives the ranges of speeds. Only an
        element that can feed energy into the motion makes a search necessary: an oil film,
        cross-coupled stiffness, negative damping or a torque that rises with the speed. It
        examines the lowest modes (6, and 4 more for each bearing) at nine of the speeds from
        the first to the last, and at the eight largest peaks of the response; bisection among
        the given speeds then finds the ends of each range.
    """
    wanted = array(speeds, "speeds")
    one_of(excitation, get_args(Excitation), "excitation")
    workers = thread_count(threads)
    with working(progress, f"synchronous response at {wanted.size} speeds"):
        data = self._model.synchronous(wanted, excitation, workers)
    return Synchronous(
        speeds=wanted,
        shafts=tuple(self._model.shafts),
        amplitudes=data["phasors"],
        excitation=excitation,
        slow_roll=None,
        residuals=data["residuals"],
        coordinates=self.coordinates,
        description=self.description,
        _bearings=tuple(data["bearings"]),
        _bearing_force=data["bearing_force"],
        _bearing_displacement=data["bearing_displacement"],
        _meshes=tuple(data["meshes"]),
        _mesh_force=data["mesh_force"],
        _bow=data["bow"],
        _ratios=self._model.ratios_in_frames,
        left_out=left_out(self) if excitation == "both" else (),
    )


def _stiffnesses(bearing: Part) -> tuple[float, ...]:
    """Give the positive constant stiffnesses of a bearing along y and z."""
    if not isinstance(bearing, Bearing) or isinstance(bearing.stiffness, SpeedTable):
        return ()
    given = np.asarray(bearing.stiffness, dtype=np.float64)
    along = np.diag(given) if given.ndim == 2 else given
    return tuple(float(stiffness) for stiffness in np.unique(along) if stiffness > 0.0)
