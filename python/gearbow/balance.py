"""Balancing a bowed rotor: what unbalance cancels its deflection, and what that leaves."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array
from gearbow._describe import places
from gearbow._lookup import nearest
from gearbow._read_only import ReadOnly
from gearbow._types import Array, At, ComplexArray
from gearbow.errors import SceneError
from gearbow.scene import Disk, Gear

if TYPE_CHECKING:
    from gearbow.system import RotorSystem

__all__ = ["Balance", "balance"]


@dataclass(frozen=True, eq=False)
class Balance(ReadOnly):
    """A correction, and the deflection that is left with it.

    Parameters
    ----------
    planes : tuple of str or (str, float)
        Gears, disks or (shaft, position [m]).
    unbalances : ndarray, shape (planes,)
        Complex unbalance to add in each [kg m], with its angle in the shaft.
    speeds : ndarray, shape (speeds,)
        Speeds of the reference shaft that were balanced at [rad/s].
    points : tuple of str or (str, float)
        Where the deflection was measured.
    target : {"total", "elastic"}
        Whether displacement, or displacement less the bow.
    before : ndarray, shape (speeds, points, 2)
        Amplitudes of v and w [m] without the correction, the shaft of the planes as the source.
    residual : ndarray, shape (speeds, points, 2)
        What is predicted to be left of them [m].
    system : RotorSystem
        The system with the correction fitted.

    Notes
    -----
    Cancelling the total deflection lets the rotor run true at the balancing speed by bending its
    bow away, which loads the bearings. Cancelling the elastic one leaves the bow as run-out, and
    the rotor turns as if it had been made so. One is not the other (Nicholas, Gunter and Allaire,
    *Effect of residual shaft bow on unbalance response and balancing of a single mass flexible
    rotor*, part 2, J. Eng. Power 98, 1976).

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4, bow=bow)
    >>> disk = gb.Disk("disk", "rotor", 0.5, mass=50.0, diametral_inertia=0.5, polar_inertia=1.0)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=1e4) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem([rotor], bearings=bearings, disks=[disk])
    >>> for target in ("total", "elastic"):
    ...     found = system.balance(["disk"], speed=150.0, target=target, points=["disk"])
    ...     print(target, f"{1e3 * found.unbalances[0].real:.1f} g m")
    total -13.3 g m
    elastic -5.8 g m
    """

    planes: tuple[At, ...]
    unbalances: ComplexArray
    speeds: Array
    points: tuple[At, ...]
    target: str
    before: ComplexArray
    residual: ComplexArray
    system: "RotorSystem" = field(repr=False)

    @property
    def residual_ratio(self) -> float:
        """How much of the deflection is left.

        Returns
        -------
        float
            Root of the sum of the squares of the residual over that before.
        """
        return float(np.linalg.norm(self.residual) / np.linalg.norm(self.before))


def balance(
    system: "RotorSystem",
    planes: At | Sequence[At],
    speed: ArrayLike,
    *,
    target: str = "total",
    points: At | Sequence[At] | None = None,
) -> Balance:
    """Find the unbalance in given planes that best cancels the deflection of a bowed rotor.

    Parameters
    ----------
    system : RotorSystem
        The system.
    planes : str, tuple of (str, float), or sequence of them
        Balancing planes on one shaft: gears, disks or (shaft, position [m]).
    speed : array_like, shape (speeds,) or scalar
        Speeds of the reference shaft to balance at [rad/s], not zero.
    target : {"total", "elastic"}
        What to cancel: the displacement, or the displacement less the bow.
    points : str, tuple of (str, float), or sequence of them, optional
        Where to measure; None is every node of the shaft.

    Returns
    -------
    Balance
        The unbalances of least squares over points and speeds, what is predicted to be left, and
        the system with the correction fitted: added to gears and disks, elsewhere on a disk without
        mass.

    Raises
    ------
    SceneError
        If an argument is impossible.
    """
    if target not in ("total", "elastic"):
        raise SceneError(f'target: must be "total" or "elastic", got {target!r}')
    chosen = places(planes, "planes")
    shaft = _shaft(system, chosen)
    speeds = array(speed, "speed")
    if not np.all(speeds):
        raise SceneError(f"speed: must not be zero, got {speed!r}")

    # Every influence is that of one kilogram metre, in a system that has a node at every plane.
    base = _fitted(system, chosen, np.zeros(len(chosen), dtype=np.complex128))
    if points is None:
        nodes = dict.fromkeys(x for name, x, _ in base.dofs if name == shaft)
        measured: tuple[At, ...] = tuple((shaft, x) for x in nodes)
    else:
        measured = places(points, "points")

    read = partial(_deflection, shaft=shaft, speeds=speeds, points=measured, target=target)
    one = np.ones(1, dtype=np.complex128)
    before = read(base, "both")
    still = read(base, "unbalance")
    influence = np.stack(
        [read(_fitted(base, (plane,), one), "unbalance") - still for plane in chosen],
        axis=-1,
    )
    table = influence.reshape(-1, len(chosen))
    least = np.linalg.lstsq(table, -before.reshape(-1), rcond=None)[0]
    unbalances: ComplexArray = np.asarray(least, dtype=np.complex128)
    return Balance(
        planes=chosen,
        unbalances=unbalances,
        speeds=speeds,
        points=measured,
        target=target,
        before=before,
        residual=before + influence @ unbalances,
        system=_fitted(base, chosen, unbalances),
    )


def _deflection(
    system: "RotorSystem",
    excitation: str,
    *,
    shaft: str,
    speeds: Array,
    points: Sequence[At],
    target: str,
) -> ComplexArray:
    """Read the deflection at all points, with the shaft of the planes as the source."""
    found = system.synchronous(speeds, excitation=excitation)
    at = found.elastic if target == "elastic" else found.displacement
    source = found.shafts.index(shaft)
    return np.stack([at(point)[:, source] for point in points], axis=1)


def _fitted(system: "RotorSystem", planes: Iterable[At], unbalances: ComplexArray) -> "RotorSystem":
    """Give the system with unbalances added in planes."""
    bodies: dict[str, list[Gear | Disk]] = {"gears": [*system.gears], "disks": [*system.disks]}
    at: dict[str, tuple[str, int]] = {}
    for kind, given in bodies.items():
        at |= {body.name: (kind, i) for i, body in enumerate(given)}
    for plane, unbalance in zip(planes, unbalances.tolist(), strict=True):
        name = plane if isinstance(plane, str) else f"balance {plane[0]} {plane[1]:g}"
        if name not in at:
            at[name] = ("disks", len(bodies["disks"]))
            bodies["disks"].append(Disk(name, plane[0], float(plane[1]), 0.0, 0.0, 0.0))
        kind, i = at[name]
        body = bodies[kind][i]
        bodies[kind][i] = replace(body, unbalance=body.unbalance + unbalance)
    described = {
        kind: [body._describe(f"{kind}[{i}]") for i, body in enumerate(given)]
        for kind, given in bodies.items()
    }
    # Corrections are not checked for slips again, unlike in `RotorSystem.replace`.
    return type(system)._from_description({**system.description, **described})


def _shaft(system: "RotorSystem", planes: Sequence[At]) -> str:
    """Name the one shaft that all planes stand on."""
    bodies: dict[str, Gear | Disk] = {gear.name: gear for gear in system.gears}
    bodies |= {disk.name: disk for disk in system.disks}
    shafts = []
    for i, plane in enumerate(planes):
        if isinstance(plane, str):
            if plane not in bodies:
                raise SceneError(
                    f'planes[{i}]: no gear or disk is called "{plane}"{nearest(plane, bodies)}'
                )
            shafts.append(bodies[plane].shaft)
        else:
            shafts.append(plane[0])
    if len(set(shafts)) != 1:
        raise SceneError(
            "planes: must be one or more on one shaft, whose speed they turn at, "
            f"got {list(planes)}"
        )
    return shafts[0]
