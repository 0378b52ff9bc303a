"""Harmonic response of a system to sources at any frequency."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, items, number, whole
from gearbow._parallel import thread_count
from gearbow._types import Array
from gearbow.analysis.protocol import System
from gearbow.description.layout import left_out, mesh_orders
from gearbow.description.loads import MeshExcitation, Source, plain_sources
from gearbow.description.places import Places
from gearbow.errors import SceneError
from gearbow.results.frequency_response import FrequencyResponse


def frequency_response(
    self: System,
    frequencies: "ArrayLike | None" = None,
    *,
    source: Source | Sequence[Source],
    speed: "ArrayLike | None" = None,
    order: "ArrayLike | None" = None,
    speeds: "ArrayLike | None" = None,
    threads: int | None = None,
) -> FrequencyResponse:
    """Find the response to harmonic sources, without time stepping.

    Give `frequencies` and, for a rotating train, `speed`; or `order` and `speeds`.

    Parameters
    ----------
    frequencies : array_like, shape (k,), optional
        Frequencies ω [rad/s], also negative ones.
    source : source or sequence of sources
        What excites the system: a `gb.Force`, `gb.Torque`, `gb.MeshExcitation`, `gb.GroundMotion`
        or `gb.ShaftExcitation`, or several, each of which has its own response. The value y + iz
        of a force is a direction, in phase along y and z; the pair (F_y, F_z) gives phasors, of
        which (1, -1j) rotates forward. The value of a torque and the axial part of a force are
        phasors.
    speed : float or array_like, shape (m,), optional
        Speed of the reference shaft [rad/s], or several, each with all frequencies; None is 0.
    order : float or array_like, shape (m,), optional
        Frequency over the speed of the reference shaft, or several.
    speeds : array_like, shape (k,), optional
        Speeds of the reference shaft [rad/s].
    threads : int, optional
        Largest number of threads, as for `campbell`.

    Returns
    -------
    FrequencyResponse
        Phasors of displacements and forces. Their first axis is that of the frequencies or
        speeds; before it comes that of several values of `speed`, after it that of several
        values of `order`.

    Raises
    ------
    SceneError
        If an argument is invalid, or a source acts on a motion that the system does not have; at
        frequency 0 also if a source accelerates a rigid-body motion.
    ConvergenceError
        If the residual of a response exceeds 1e-4.

    Notes
    -----
    The equations are linearised about the static equilibrium at the speed, as in `modes`. Sources
    add to nothing: constant loads, bow and unbalance of the system have no part in the response
    unless a `gb.ShaftExcitation` is a source.

    Examples
    --------
    The transmission from the tooth contact to a bearing:

    >>> import numpy as np
    >>> import gearbow as gb
    >>> system = gb.examples()["geared_pair"].load()
    >>> error = gb.MeshExcitation("pinion/wheel", 1e-6)
    >>> response = system.frequency_response([2000.0, 6000.0], source=error, speed=100.0)
    >>> np.abs(response.bearing_force(("rotor 2", 0.3))[:, 0]).round(1)
    array([[ 6.1, 56.9],
           [ 0.8,  4.2]])
    """
    at, shaft_speeds, axes = _pairs(frequencies, speed, order, speeds)
    plain, labels = plain_sources(source)
    _check_ground(plain, at.ravel())
    workers = thread_count(threads)
    data = self._model.frequency_response(at.ravel(), shaft_speeds.ravel(), plain, workers)
    shape = at.shape

    def shaped(values: Any) -> Any:
        return values.reshape(shape + values.shape[1:])

    return FrequencyResponse(
        frequencies=at,
        speeds=shaft_speeds,
        sources=tuple(labels),
        phasors=shaped(data["phasors"]),
        residuals=shaped(data["residuals"]),
        axes=axes,
        coordinates=self.coordinates,
        description=self.description,
        _sources=plain,
        _bearings=tuple(data["bearings"]),
        _bearing_force=shaped(data["bearing_force"]),
        _bearing_displacement=shaped(data["bearing_displacement"]),
        _meshes=tuple(data["meshes"]),
        _mesh_force=shaped(data["mesh_force"]),
        left_out=left_out(self) if any(one.get("excitation") == "both" for one in plain) else (),
    )


def mesh_response(
    self: System,
    at: str | tuple[str, str],
    *,
    speeds: "ArrayLike",
    harmonics: Sequence[int] = (1,),
    error: complex = 1e-6,
    threads: int | None = None,
) -> FrequencyResponse:
    """Find the response to a transmission error at harmonics of the tooth frequency of a mesh.

    Parameters
    ----------
    at : str or tuple of (str, str)
        The mesh, "driver/driven" or (driver, driven) in either order.
    speeds : array_like, shape (speeds,)
        Speeds of the reference shaft [rad/s].
    harmonics : sequence of int
        Harmonics of the tooth frequency.
    error : complex
        Phasor of the transmission error at every harmonic [m], by default 1 µm.
    threads : int, optional
        Largest number of threads, as for `campbell`.

    Returns
    -------
    FrequencyResponse
        The response, whose first two axes are those of speeds and harmonics.

    Raises
    ------
    ConvergenceError
        If the residual of a response exceeds 1e-4.
    """
    known = Places.of("mesh", [(mesh.driver, mesh.driven) for mesh in self.meshes])
    index = known.index(at)
    numbers = [
        whole(one, f"harmonics[{i}]")
        for i, one in enumerate(items(harmonics, "harmonics", "numbers"))
    ]
    if not numbers:
        raise SceneError("harmonics: needs at least one harmonic, got none")
    orders = mesh_orders(self)[index] * np.array(numbers, dtype=np.float64)
    return frequency_response(
        self,
        source=MeshExcitation(known.known[index][0], error),
        order=orders,
        speeds=speeds,
        threads=threads,
    )


def _pairs(
    frequencies: "ArrayLike | None",
    speed: "ArrayLike | None",
    order: "ArrayLike | None",
    speeds: "ArrayLike | None",
) -> tuple[Array, Array, tuple[str, ...]]:
    """Give frequencies, the speed at each, and the names of their axes."""
    if frequencies is not None and order is None and speeds is None:
        wanted = array(frequencies, "frequencies")
        if speed is None or np.ndim(speed) == 0:
            fixed = 0.0 if speed is None else number(speed, "speed")
            return wanted, np.full(wanted.shape, fixed), ("frequency",)
        several = array(speed, "speed")
        at, shaft_speeds = np.broadcast_arrays(wanted[None, :], several[:, None])
        return at.copy(), shaft_speeds.copy(), ("speed", "frequency")
    if frequencies is None and speed is None and order is not None and speeds is not None:
        wanted = array(speeds, "speeds")
        if np.ndim(order) == 0:
            return number(order, "order") * wanted, wanted, ("speed",)
        orders = array(order, "order")
        repeated = np.repeat(wanted[:, None], orders.size, axis=1)
        return repeated * orders, repeated, ("speed", "order")
    raise SceneError(
        "frequencies: give either frequencies, with or without speed=, or order= and speeds="
    )


def _check_ground(plain: Sequence[Any], frequencies: Array) -> None:
    """Refuse frequency 0 for a velocity or acceleration of the ground."""
    for i, source in enumerate(plain):
        integrated = source["kind"] == "ground" and source["quantity"] != "displacement"
        if integrated and not frequencies.all():
            j = int(np.argmin(np.abs(frequencies)))
            raise SceneError(
                f"frequencies[{j}]: must not be 0, where the {source['quantity']} of source[{i}] "
                "gives no displacement; leave 0 out"
            )
