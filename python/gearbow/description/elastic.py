"""Elastic bodies from the matrices of a finite-element program, reduced to modes.

The basis of the reduction holds the natural modes up to a limit and the displacements under unit
forces at the interfaces (Rubin 1975, AIAA J. 13, 995–1006; MacNeal 1971), for clamped and for free
bodies alike. Its modes with unit modal mass are the coordinates of the body.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gearbow._convert import array, matrix as nested_array, number, positive, shown, text
from gearbow._extras import extra
from gearbow._shown import Shown
from gearbow._types import Array
from gearbow.description.part import Part, freeze, tuples
from gearbow.errors import SceneError

#: Rows of numbers over the modes.
Rows: TypeAlias = tuple[tuple[float, ...], ...]

#: Fields with rows that a body may lack.
OPTIONAL_ROWS = ("translation", "radiation")

#: Natural modes of the basis reach up to this multiple of the highest frequency of interest. Modes
#: left out respond statically; at the highest frequency of a portal of bars this is accurate to
#: 1.6e-3 with 1.7, and to 5e-4 with 2.2.
_REACH = 2.2
#: Shift of the static responses of a free body, relative to the square of the frequency limit.
_SHIFT = 1e-4
#: Frequency of a rigid-body motion relative to the limit, at most: round-off of the matrices.
_RIGID = 1e-3
#: Largest asymmetry of a matrix, relative to its largest entry.
_SYMMETRIC = 1e-6
#: Squared part of a vector that is not in the space of the others, below which it is left out.
_DEPENDENT = 1e-12
#: Largest deviation of interfaces from a rigid-body motion, relative to it.
_SAME_MOTION = 1e-3
#: Number of rigid-body motions of a free body.
_FREE = 6


@dataclass(frozen=True)
class Interface(Part):
    """A place of a finite-element model: a bearing seat, a foot or a sensor.

    Parameters
    ----------
    position : (float, float, float)
        Position (x, y, z) from the left end of the first shaft [m].
    rows : sequence
        Its displacements along x, y and z and, where it has them, its rotations about x, y and z:
        for each the index of a degree of freedom of the model, a row of factors over all of them,
        or None. Three entries give displacements only.
    stiffness, damping : (float, float, float), optional
        Spring [N/m] and damper [N s/m] to the ground along x, y and z, for example of a foot.

    Examples
    --------
    >>> import gearbow as gb
    >>> seat = gb.Interface((0.1, 0.0, 0.0), rows=[0, 1, 2, 3, 4, 5])
    >>> foot = gb.Interface((0.1, 0.0, -0.2), rows=[6, 7, 8], stiffness=(1e8, 1e8, 3e8))
    """

    position: Sequence[float]
    rows: Sequence[Any]
    _: KW_ONLY
    stiffness: Sequence[float] | None = None
    damping: Sequence[float] | None = None

    def __post_init__(self) -> None:
        freeze(self, "position", "stiffness", "damping")

    def _over(self, size: int, path: str) -> Array:
        """Give the rows over all degrees of freedom, shape (6, size)."""
        found = np.zeros((_FREE, size))
        given = list(self.rows)
        if len(given) not in (3, _FREE):
            raise SceneError(
                f"{path}.rows: must have 3 displacements, or 3 more rotations, got {len(given)}"
            )
        for axis, row in enumerate(given):
            where = f"{path}.rows[{axis}]"
            if row is None:
                continue
            if isinstance(row, int | np.integer):
                if not 0 <= row < size:
                    raise SceneError(f"{where}: must be below the {size} degrees of freedom")
                found[axis, row] = 1.0
                continue
            values = np.ravel(array(row, where))
            if values.size != size:
                raise SceneError(f"{where}: must have {size} factors, got {values.size}")
            found[axis] = values
        return found


@dataclass(frozen=True, eq=False)
class Surface(Shown):
    """The surface of a finite-element model, which radiates sound.

    Parameters
    ----------
    rows : array_like of int, shape (nodes, 3)
        For each node of the surface, the degrees of freedom of its displacements along x, y and z.
    areas : array_like, shape (nodes, 3)
        For each node, its share of the area times the outward normal [m²].

    Examples
    --------
    A cover of four nodes in the plane z = 0, of 0.1 m × 0.2 m:

    >>> import numpy as np
    >>> import gearbow as gb
    >>> rows = np.arange(12).reshape(4, 3)
    >>> cover = gb.Surface(rows, np.tile([0.0, 0.0, 0.005], (4, 1)))
    """

    rows: Any
    areas: Any

    def _over(self, modes: Array) -> Array:
        """Give ∫ n nᵀ dA over modes (n, h) [m²/kg], shape (h, h)."""
        rows = nested_array(self.rows, "surface.rows")
        areas = nested_array(self.areas, "surface.areas")
        if rows.shape != areas.shape or rows.shape[1:] != (3,):
            raise SceneError(
                "surface: rows and areas must have the shape (nodes, 3), got "
                f"{rows.shape} and {areas.shape}"
            )
        size = modes.shape[0]
        wrong = (rows != np.floor(rows)) | (rows < 0.0) | (rows >= size)
        if wrong.any():
            node = int(np.argwhere(wrong)[0, 0])
            raise SceneError(
                f"surface.rows[{node}]: must be whole numbers below the {size} degrees of freedom, "
                f"got {rows[node].tolist()}"
            )
        sizes = np.linalg.norm(areas, axis=1)
        if (sizes == 0.0).any():
            node = int(np.argmin(sizes))
            raise SceneError(f"surface.areas[{node}]: must not be zero; leave this node out")
        normals = areas / sizes[:, None]
        moved = np.einsum("ka,kah->kh", normals, modes[rows.astype(int)])
        radiation: Array = moved.T @ (sizes[:, None] * moved)
        return radiation


@dataclass(frozen=True)
class ElasticBody(Part):
    """Modes of an elastic body with unit modal mass, and the motion of its interfaces in them."""

    # Natural frequencies of the h modes [rad/s], shape (h,); zero for rigid-body motions.
    frequencies: tuple[float, ...]
    # Damping ratio of each mode, shape (h,).
    damping_ratios: tuple[float, ...]
    # For each interface its position, rows (6, h) and springs to the ground, as plain data.
    interfaces: Mapping[str, Mapping[str, Any]]
    # Modal coordinates of a translation along x, y and z, shape (3, h); None for a clamped body.
    translation: Rows | None = None
    # ∫ n nᵀ dA of the displacements n along the normal of the surface [m²/kg], shape (h, h).
    radiation: Rows | None = None


@dataclass(frozen=True, eq=False)
class Matrices:
    """Checked matrices of a model as sparse matrices of SciPy, n × n."""

    mass: Any
    stiffness: Any

    @classmethod
    def of(cls, mass: Any, stiffness: Any) -> "Matrices":
        """Check the matrices of a user."""
        with extra("sparse"):
            from scipy import sparse  # noqa: PLC0415

        found = {}
        for name, one in (("mass", mass), ("stiffness", stiffness)):
            given = _from_file(one, name) if isinstance(one, str | os.PathLike) else one
            is_array = isinstance(given, np.ndarray) and given.dtype.kind in "fiu"
            matrix = given if sparse.issparse(given) or is_array else nested_array(given, name)
            if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or matrix.shape[0] == 0:
                raise SceneError(f"{name}: must be a square matrix, got the shape {matrix.shape}")
            csc = sparse.csc_matrix(matrix, dtype=np.float64)
            if not np.isfinite(csc.data).all():
                raise SceneError(f"{name}: every entry must be finite")
            largest = float(np.abs(csc.data).max(initial=0.0))
            lopsided = float(np.abs((csc - csc.T).data).max(initial=0.0))
            if largest == 0.0 or lopsided > _SYMMETRIC * largest:
                raise SceneError(
                    f"{name}: must be symmetric and not zero; the largest difference from its "
                    f"transpose is {lopsided:.3g}, the largest entry {largest:.3g}"
                )
            found[name] = (csc + csc.T) / 2.0
        if found["mass"].shape != found["stiffness"].shape:
            raise SceneError(
                f"stiffness: must have the shape of mass, {found['mass'].shape}, got "
                f"{found['stiffness'].shape}"
            )
        return cls(**found)


def _from_file(path: str | os.PathLike[str], name: str) -> Any:
    from gearbow.exchange.matrices import read_matrix  # noqa: PLC0415

    return read_matrix(path, name)


def reduced(
    matrices: Matrices,
    interfaces: Any,
    *,
    highest_frequency: float,
    damping_ratio: float,
    surface: Surface | None = None,
) -> tuple[ElasticBody, float]:
    """Reduce a model to modes; give the body and its mass [kg], 1 of a clamped one."""
    limit = 2.0 * np.pi * positive(highest_frequency, "highest_frequency") * _REACH
    ratio = number(damping_ratio, "damping_ratio")
    if surface is not None and not isinstance(surface, Surface):
        raise SceneError(f"surface: must be a gb.Surface, got {shown(surface)}")
    if not isinstance(interfaces, Mapping) or not interfaces:
        raise SceneError(f"interfaces: must be a dict of gb.Interface, got {shown(interfaces)}")
    size = matrices.mass.shape[0]
    rows = {}
    for name, one in interfaces.items():
        path = f"interfaces[{text(name, 'interfaces')!r}]"
        if not isinstance(one, Interface):
            raise SceneError(f"{path}: must be a gb.Interface, got {shown(one)}")
        rows[name] = one._over(size, path)
    basis = _basis(matrices, np.vstack(list(rows.values())), limit)
    squares, modes = _modes(matrices, basis)
    rigid = squares < (_RIGID * limit) ** 2
    if np.count_nonzero(rigid) not in (0, _FREE):
        raise SceneError(
            f"stiffness: leaves {np.count_nonzero(rigid)} rigid-body motions free; a housing is "
            "clamped (none) or free (6), and then stands on the stiffness of its interfaces"
        )
    frequencies = np.where(rigid, 0.0, np.sqrt(np.maximum(squares, 0.0)))
    own = {name: row @ modes for name, row in rows.items()}
    translation, mass = None, 1.0
    if rigid.any():
        translation = _translations(own, interfaces, rigid)
        mass = float(np.mean(np.sum(translation**2, axis=1)))
    return (
        ElasticBody(
            tuple(frequencies.tolist()),
            tuple(np.where(rigid, 0.0, ratio).tolist()),
            {name: _seat(interfaces[name], own[name]) for name in interfaces},
            None if translation is None else tuples(translation.tolist()),
            None if surface is None else tuples(surface._over(modes).tolist()),
        ),
        mass,
    )


def _seat(interface: Interface, rows: Array) -> dict[str, Any]:
    """Give an interface with its rows over the modes."""
    given = {"position": interface.position, "rows": tuples(rows.tolist())}
    springs = {"stiffness": interface.stiffness, "damping": interface.damping}
    return given | {name: value for name, value in springs.items() if value is not None}


def _basis(matrices: Matrices, rows: Array, limit: float) -> Array:
    """Give natural modes up to a frequency, and static responses to forces at interfaces."""
    from scipy import sparse  # noqa: PLC0415
    from scipy.sparse import linalg  # noqa: PLC0415

    mass, stiffness = matrices.mass, matrices.stiffness
    size = mass.shape[0]
    used = rows[np.abs(rows).sum(axis=1) > 0.0]
    # A shift keeps the factors of a free body regular; the kept modes contain what it changes.
    try:
        factors = linalg.splu(sparse.csc_matrix(stiffness + _SHIFT * limit**2 * mass))
    except RuntimeError:
        raise SceneError(
            "stiffness: leaves a degree of freedom without stiffness and mass; remove its row and "
            "column from both matrices"
        ) from None
    static = factors.solve(used.T)
    if size <= max(3 * used.shape[0], 60):
        return np.hstack([static, _complete(matrices)])
    count = _count_below(matrices, limit)
    if count >= size - 1:
        return _complete(matrices)
    operator = linalg.LinearOperator((size, size), matvec=factors.solve, dtype=np.float64)
    _, modes = linalg.eigsh(
        stiffness, max(count, 1), mass, sigma=-_SHIFT * limit**2, OPinv=operator
    )
    return np.hstack([modes, static])


def _complete(matrices: Matrices) -> Array:
    """Give a basis of all motions, in which degrees of freedom without mass follow statically."""
    heavy = matrices.mass.diagonal() > 0.0
    basis = np.eye(heavy.size)[:, heavy]
    if not heavy.all():
        stiffness = matrices.stiffness.toarray()
        inner, across = stiffness[~heavy][:, ~heavy], stiffness[~heavy][:, heavy]
        basis[~heavy] = -np.linalg.lstsq(inner, across, rcond=None)[0]
    return basis


def _count_below(matrices: Matrices, limit: float) -> int:
    """Count the natural frequencies below a limit by Sylvester's law of inertia."""
    from scipy import sparse  # noqa: PLC0415
    from scipy.sparse import linalg  # noqa: PLC0415

    shifted = sparse.csc_matrix(matrices.stiffness - limit**2 * matrices.mass)
    # Without exchanges of rows, the signs of the pivots are those of LDLᵀ.
    factors = linalg.splu(
        shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    return int(np.count_nonzero(factors.U.diagonal() < 0.0))


def _modes(matrices: Matrices, basis: Array) -> tuple[Array, Array]:
    """Give squared frequencies and modes with unit modal mass in the space of a basis."""
    masses = np.einsum("ij,ij->j", basis, matrices.mass @ basis)
    scaled = basis / np.sqrt(np.where(masses > 0.0, masses, 1.0))
    gram = scaled.T @ (matrices.mass @ scaled)
    sizes, directions = np.linalg.eigh(gram)
    if masses.size == 0 or not (masses.min() > 0.0 and sizes[0] > -_SYMMETRIC * sizes[-1]):
        raise SceneError("mass: must be positive definite, except for rows and columns of zeros")
    kept = sizes > _DEPENDENT * sizes.max()
    space = scaled @ (directions[:, kept] / np.sqrt(sizes[kept]))
    projected = space.T @ (matrices.stiffness @ space)
    squares, shapes = np.linalg.eigh((projected + projected.T) / 2.0)
    return squares, space @ shapes


def _translations(
    rows: Mapping[str, Array], interfaces: Mapping[str, Interface], rigid: NDArray[np.bool_]
) -> Array:
    """Give the modal coordinates of translations of a free body, shape (3, modes)."""
    # The interfaces must move as their positions say in each rigid-body motion.
    moved, wanted = [], []
    for name, own in rows.items():
        x, y, z = (float(value) for value in interfaces[name].position)
        lever = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        motions = np.block([[np.eye(3), lever], [np.zeros((3, 3)), np.eye(3)]])
        known = np.abs(own).sum(axis=1) > 0.0
        moved.append(own[known][:, rigid])
        wanted.append(motions[known])
    found, *_ = np.linalg.lstsq(np.vstack(moved), np.vstack(wanted), rcond=None)
    left = np.abs(np.vstack(moved) @ found - np.vstack(wanted)).max()
    if left > _SAME_MOTION * max(1.0, float(np.abs(np.vstack(wanted)).max())):
        raise SceneError(
            "interfaces: positions and rows do not fit the rigid-body motions of the matrices (a "
            f"deviation of {left:.3g} in a unit motion); check the order of the rows x, y, z and "
            "rotations about them, the positions, and that all units are SI"
        )
    translation = np.zeros((3, rigid.size))
    translation[:, rigid] = found[:, :3].T
    return translation
