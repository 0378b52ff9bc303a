"""Section forces of shafts: axial and shear force, bending moment and torque."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearbow._core import Model
from gearbow._result import ROUND_OFF, Column, Figured
from gearbow._shown import ReadOnly
from gearbow._types import Array, At, ComplexArray, Section, Side
from gearbow.description.coordinates import Coordinates
from gearbow.description.places import is_place, place
from gearbow.errors import SceneError
from gearbow.recording import access
from gearbow.recording.record import SECTION_FORCES, RunRecord

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class SectionForces(Figured, ReadOnly):
    """What the part of a shaft beyond a section exerts on the part before it.

    The part beyond is that at larger x. Axial force N (positive in tension), shear forces Q_y and
    Q_z, bending moments M_y and M_z and torque T act along the axes x, y and z, which stand still.
    Forces jump at a node where something acts: a bearing, a mesh, a disk or a torque. NumPy takes
    the result as the array of its values.

    `plot` draws N, Q, M and T along the shaft: at rest the values, of runs and harmonic motions
    their envelope.

    Parameters
    ----------
    shaft : str
        Name of the shaft.
    positions : ndarray, shape (k,)
        Positions of the sections [m].
    sides : tuple of str
        Whether each section lies just "before" a node or just "beyond" it; "before" between nodes.
    values : ndarray, shape (..., 6) or (..., k, 6)
        N, Q_y, Q_z [N], M_y, M_z, T [N m] at one place, or at the k sections of a whole shaft. The
        first axes are those of the result; the values of harmonic motions are phasors.

    Notes
    -----
    They follow from the equilibrium of the part of an element up to the section: from elastic
    forces, inertia and weight, not from the curvature. A bowed shaft without load has none.
    docs/formulation.md has a sketch of the signs.

    Examples
    --------
    A weight of 100 N in the middle of a light shaft, M = F l/4:

    >>> import gearbow as gb
    >>> light = gb.Material(207e9, 1.0, poisson_ratio=0.3)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.02, material=light)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> force = gb.Force(("rotor", 0.5), (0.0, -100.0))
    >>> static = gb.RotorSystem([rotor], bearings=bearings, forces=[force]).static()
    >>> forces = static.section_forces(("rotor", 0.5))
    >>> print(f"{forces.bending[0]:.2f} N m")
    -25.00 N m
    """

    shaft: str
    positions: Array
    sides: tuple[str, ...]
    values: NDArray[Any]

    @property
    def axial_force(self) -> NDArray[Any]:
        """Axial force N [N], positive in tension."""
        return self.values[..., 0]

    @property
    def shear(self) -> NDArray[Any]:
        """Shear forces along y and z [N], shape (..., 2)."""
        return self.values[..., 1:3]

    @property
    def bending(self) -> NDArray[Any]:
        """Bending moments about y and z [N m], shape (..., 2)."""
        return self.values[..., 3:5]

    @property
    def torque(self) -> NDArray[Any]:
        """Torque about x [N m]."""
        return self.values[..., 5]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of `values`."""
        return self.values.shape

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if copy:
            return np.array(self.values, dtype=dtype)
        return np.asarray(self.values, dtype=dtype)

    def __getitem__(self, index: Any) -> Any:
        return self.values[index]

    def _facts(self) -> dict[str, str]:
        return {"shaft": repr(self.shaft), "sections": str(self.positions.size)}

    @property
    def _extremes(self) -> tuple[Array, Array]:
        """Smallest and largest values at each section, shape (k, 6); amplitudes of phasors."""
        values = self.values.reshape(-1, self.positions.size, len(SECTION_FORCES))
        if np.iscomplexobj(values):
            largest = np.abs(values).max(axis=0)
            return -largest, largest
        return values.min(axis=0), values.max(axis=0)

    def _columns(self) -> list[Column]:
        low, high = self._extremes
        found = np.where(-low > high, low, high)
        if np.iscomplexobj(self.values):
            found = high
        least = ROUND_OFF * np.abs(found).max(axis=0, initial=0.0)
        return [
            Column("position", self.positions, "m"),
            Column("side", list(self.sides)),
            *(
                Column(name.replace("_", " "), series, unit, round_off=size)
                for (name, unit), series, size in zip(
                    SECTION_FORCES.items(), found.T, least, strict=True
                )
            ),
        ]

    def _heading(self) -> list[str]:
        what = "section forces"
        if np.iscomplexobj(self.values):
            what = "largest amplitudes of the section forces"
        elif self.values.size > self.positions.size * len(SECTION_FORCES):
            what = "section forces of largest size"
        return [f"{what} of shaft {self.shaft!r}"]

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting.analyses import Course, section_forces  # noqa: PLC0415

        if self.positions.size < 2:
            raise SceneError(
                f"plot: one section has no course; take section_forces({self.shaft!r}) of the shaft"
            )
        return section_forces({self.shaft: Course(self.positions, *self._extremes)}, ax=ax)


class Motions(NamedTuple):
    """Harmonic motions, whose axes are those of the result."""

    #: Phasors of the degrees of freedom, shape (..., n) [m, rad].
    phasors: ComplexArray
    #: Angular frequencies, and speeds of the reference shaft [rad/s]; shapes that fit (...).
    frequencies: Array
    speeds: Array
    #: Gives whether each motion contains the bow of a shaft.
    bowed: Callable[[str], Any]


def shaft_of(coordinates: Coordinates, at: At) -> tuple[str, list[float] | None]:
    """Find the shaft of a place and the position on it; none for the name of a whole shaft."""
    at = place(at)
    if isinstance(at, str):
        found = coordinates.bodies.get(at)
        if found is not None:
            return found[0], [found[1]]
        if at in coordinates.shafts:
            return at, None
    shaft = coordinates.shaft(at)
    if shaft not in coordinates.shafts or not is_place(at):
        raise SceneError(f"at: {at!r} is no place of a shaft, and only shafts have section forces")
    return shaft, [float(at[1])]


def chosen(
    sections: Sequence[Section], values: NDArray[Any], *, whole: bool, side: Side
) -> SectionForces:
    """Take a whole shaft, or one place, of the sections that `values` (..., k, 6) belong to."""
    shaft = sections[0][0]
    if whole:
        positions = np.array([x for _, x, _ in sections])
        return SectionForces(shaft, positions, tuple(own for *_, own in sections), values)
    index = access.at_side(sections, side)
    _, x, own = sections[index]
    return SectionForces(shaft, np.array([x]), (own,), values[..., index, :])


def forces_at_rest(
    model: Model, coordinates: Coordinates, rest: tuple[Array, float], at: At, side: Side
) -> SectionForces:
    """Give the section forces of a state at rest (n,), with the shafts at a speed [rad/s]."""
    shaft, positions = shaft_of(coordinates, at)
    sections = [section for section, _ in model.sections(shaft, positions)]
    values = model.static_section_forces(shaft, positions, *rest)
    return chosen(sections, values, whole=positions is None, side=side)


def harmonic_forces(
    model: Model, coordinates: Coordinates, motions: Motions, at: At, side: Side
) -> SectionForces:
    """Give the phasors of the section forces of harmonic motions."""
    shaft, positions = shaft_of(coordinates, at)
    sections = [section for section, _ in model.sections(shaft, positions)]
    axes = motions.phasors.shape[:-1]
    values = model.harmonic_section_forces(
        shaft,
        positions,
        {
            "phasors": motions.phasors.reshape(-1, motions.phasors.shape[-1]),
            "frequencies": np.broadcast_to(motions.frequencies, axes).ravel().tolist(),
            "speeds": np.broadcast_to(motions.speeds, axes).ravel().tolist(),
            "bowed": np.broadcast_to(motions.bowed(shaft), axes).ravel().tolist(),
        },
    )
    found = values.reshape(*axes, len(sections), len(SECTION_FORCES))
    return chosen(sections, found, whole=positions is None, side=side)


def recorded_forces(run: RunRecord, at: At, side: Side) -> SectionForces:
    """Give the section forces that a run recorded."""
    sections, values = access.section_forces(run, at)
    whole = len({x for _, x, _ in sections}) > 1
    return chosen(sections, values, whole=whole, side=side)
