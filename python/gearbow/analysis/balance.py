"""Balancing of a bowed rotor by least squares."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, get_args

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, nearest, nodal, one_of
from gearbow._core import require_memory
from gearbow._progress import working
from gearbow._result import Column, Figured, WithSpeeds, Written, in_degrees
from gearbow._shown import ReadOnly
from gearbow._types import Array, At, BalanceTarget, ComplexArray, Excitation
from gearbow.analysis.protocol import S, System, variant
from gearbow.description.gears import Disk, Gear
from gearbow.description.layout import left_out, shafts_of_bodies
from gearbow.description.places import place_label, places
from gearbow.errors import SceneError
from gearbow.results.synchronous import semi_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Unbalance of a trial run [kg m]. The response is linear; this one is small on every rotor,
#: so that no displacement looks too large.
_TRIAL = 1e-9


@dataclass(frozen=True, eq=False)
class Balance(WithSpeeds, Figured, ReadOnly, Generic[S]):
    """A balancing correction and the predicted residual deflection.

    `plot` draws the major semi-axis of the deflection before and after the correction over the
    position of the measuring points, or as bars for points with names, in one panel for each
    speed.

    Parameters
    ----------
    planes : tuple of str or (str, float)
        Gears, disks or (shaft, position [m]).
    unbalances : ndarray, shape (planes,)
        Complex unbalance to add in each plane [kg m]; its argument is the angle in the shaft.
    speeds : ndarray, shape (speeds,)
        Balancing speeds of the reference shaft [rad/s].
    points : tuple of str or (str, float)
        Measuring points.
    target : {"total", "elastic"}
        Balanced quantity: displacement, or elastic deflection (displacement minus bow).
    before : ndarray, shape (speeds, points, 2)
        Amplitudes along y and z [m] without the correction, the shaft of the planes as the source.
    residual : ndarray, shape (speeds, points, 2)
        Predicted amplitudes with the correction [m].
    influence : ndarray, shape (speeds, points, 2, planes)
        Influence coefficients: amplitudes per unbalance [m/(kg m)].
    system : RotorSystem
        The system with the correction.
    left_out : tuple of str
        Excitations of the system that this result does not contain.

    Notes
    -----
    With target "total" the rotor has no orbit at the balancing speed: the shaft bends by as much as
    its bow, which loads the bearings. With target "elastic" the shaft does not bend, and the bow
    remains as run-out. Both targets cannot be met together (Nicholas, Gunter and Allaire,
    *Effect of residual shaft bow on unbalance response and balancing of a single mass flexible
    rotor*, part 2, J. Eng. Power 98, 1976).

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=bow)
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
    target: BalanceTarget
    before: ComplexArray
    residual: ComplexArray
    influence: ComplexArray
    system: S = field(repr=False)
    left_out: tuple[str, ...] = ()

    @property
    def shaft(self) -> str:
        """Name of the shaft of the planes."""
        return shaft_of_planes(self.system, self.planes)

    @property
    def residual_ratio(self) -> float:
        """Norm of the residual divided by the norm before balancing; 0 without vibration.

        Both are root sums of squares over speeds and points.
        """
        before = float(np.linalg.norm(self.before))
        return float(np.linalg.norm(self.residual)) / before if before else 0.0

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import analyses as figures  # noqa: PLC0415

        return figures.balance(
            [self._speed_text(speed) for speed in self.speeds.tolist()],
            [point if isinstance(point, str) else float(point[1]) for point in self.points],
            semi_axes(self.before),
            semi_axes(self.residual),
            label=f"{self.target} deflection [µm]",
            ax=ax,
        )

    def _heading(self) -> list[str]:
        speeds = self._speed_text(self.speeds.tolist())
        remains = f"{100.0 * self.residual_ratio:.3g} % of it remains"
        return [f"balance of the {self.target} deflection at {speeds}: {remains}"]

    def _columns(self) -> list[Column]:
        """Give a row for each plane."""
        return [
            Column("plane", [place_label(plane) for plane in self.planes]),
            Column("unbalance", np.abs(self.unbalances), "kg m", ".4g", Written("g mm", 1e6)),
            Column("angle", np.angle(self.unbalances), "rad", ".1f", in_degrees()),
        ]


def balance(  # numpydoc ignore=PR01
    self: S,
    planes: At | Sequence[At],
    speed: "ArrayLike",
    *,
    target: BalanceTarget = "total",
    points: At | Sequence[At] | None = None,
    progress: bool | None = None,
) -> Balance[S]:
    """Find the unbalances that minimise the deflection of a bowed rotor.

    Parameters
    ----------
    planes : str, tuple of (str, float), or sequence of them
        Balancing planes on one shaft: gears, disks or (shaft, position [m]).
    speed : array_like, shape (speeds,) or scalar
        Balancing speeds of the reference shaft [rad/s], not zero.
    target : {"total", "elastic"}
        Quantity to minimise: the displacement, or the elastic deflection (displacement minus bow).
    points : str, tuple of (str, float), or sequence of them, optional
        Measuring points; None is every node of the shaft.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Balance
        Least-squares unbalances over points and speeds, predicted residual, and the system with
        the correction: added to the unbalance of a gear or disk, or a new disk without mass.
    """
    one_of(target, get_args(BalanceTarget), "target")
    chosen = places(planes, "planes")
    if len(set(chosen)) < len(chosen):
        raise SceneError(f"planes: must be different, got {list(chosen)}")
    shaft = shaft_of_planes(self, chosen)
    speeds = array(speed, "speed")
    if not np.all(speeds):
        raise SceneError(f"speed: must not be zero, got {speed!r}")

    # Influence coefficients are amplitudes per unbalance, in a system with a node at every plane.
    base = with_unbalances(self, dict.fromkeys(chosen, 0.0))
    if points is None:
        nodes = dict.fromkeys(x for name, x, _ in nodal(base.dofs) if name == shaft)
        measured: tuple[At, ...] = tuple((shaft, x) for x in nodes)
    else:
        measured = places(points, "points")

    # Amplitudes of all coordinates at a time; deflections in every plane, and their copies.
    amplitudes = len(base.shafts) * (len(base.dofs) + 2 * len(measured))
    deflections = 2 * len(measured) * (4 * len(chosen) + 4)
    require_memory(
        "speed",
        f"the influence coefficients at {speeds.size} speeds",
        16.0 * speeds.size * (amplitudes + deflections),
        "give fewer speeds, planes or points",
    )
    read = partial(_deflection, shaft=shaft, speeds=speeds, points=measured, target=target)
    with working(progress, "balancing"):
        before = read(base, "both")
        # A trial unbalance must be no small difference.
        alone = variant(base, **without_unbalance(base))
        influence = np.stack(
            [
                read(with_unbalances(alone, {plane: _TRIAL}), "unbalance") / _TRIAL
                for plane in chosen
            ],
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
        influence=influence,
        system=with_unbalances(base, dict(zip(chosen, unbalances.tolist(), strict=True))),
        left_out=left_out(self),
    )


def _deflection(
    system: System,
    excitation: Excitation,
    *,
    shaft: str,
    speeds: Array,
    points: Sequence[At],
    target: BalanceTarget,
) -> ComplexArray:
    """Find the deflection at all points with the shaft of the planes as the source."""
    found = system.synchronous(speeds, excitation=excitation)
    at = found.elastic if target == "elastic" else found.displacement
    source = found.shafts.index(shaft)
    return np.stack([at(point)[:, source] for point in points], axis=1)


def with_unbalances(system: S, unbalances: Mapping[At, complex]) -> S:
    """Add unbalances in planes. Corrections are not checked for plausibility."""
    bodies: dict[str, list[Gear | Disk]] = {"gears": [*system.gears], "disks": [*system.disks]}
    at: dict[str, tuple[str, int]] = {}
    for kind, given in bodies.items():
        at |= {body.name: (kind, i) for i, body in enumerate(given)}
    for plane, unbalance in unbalances.items():
        name = body_of(plane)
        if name not in at:
            at[name] = ("disks", len(bodies["disks"]))
            bodies["disks"].append(Disk(name, plane[0], float(plane[1]), 0.0, 0.0, 0.0))
        kind, i = at[name]
        body = bodies[kind][i]
        bodies[kind][i] = replace(body, unbalance=body.unbalance + unbalance)
    return variant(system, **bodies)


def body_of(plane: At) -> str:
    """Give the name of the gear or disk of a plane; between them, of a disk without mass."""
    return plane if isinstance(plane, str) else f"balance {plane[0]} {plane[1]:g}"


def bodies_with(system: System, unbalances: Mapping[str, complex]) -> dict[str, Any]:
    """Give the gears and disks of a system, some of them with other unbalances."""
    return {
        "gears": [replace(g, unbalance=unbalances.get(g.name, g.unbalance)) for g in system.gears],
        "disks": [replace(d, unbalance=unbalances.get(d.name, d.unbalance)) for d in system.disks],
    }


def without_unbalance(system: System) -> dict[str, Any]:
    """Give the gears and disks of a system without unbalance."""
    return bodies_with(system, dict.fromkeys(shafts_of_bodies(system), 0.0))


def shaft_of_planes(system: System, planes: Sequence[At]) -> str:
    """Find the shaft that has all planes."""
    bodies = shafts_of_bodies(system)
    shafts = []
    for i, plane in enumerate(planes):
        if isinstance(plane, str):
            if plane not in bodies:
                raise SceneError(
                    f'planes[{i}]: no gear or disk is called "{plane}"{nearest(plane, bodies)}'
                )
            shafts.append(bodies[plane])
        else:
            shafts.append(plane[0])
    if len(set(shafts)) != 1:
        raise SceneError(
            f"planes: must be one or more planes on the same shaft, got {list(planes)}"
        )
    return shafts[0]
