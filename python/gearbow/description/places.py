"""Supports and housings, and places in a system."""

import numbers
import re
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import BYTES, real, shown, text
from gearbow.description.elastic import ElasticBody, Interface, Matrices, Surface, reduced
from gearbow.description.part import Part, freeze
from gearbow.errors import ChannelError, SceneError
from gearbow.units.fields import is_quantity


@dataclass(frozen=True)
class Support(Part):
    """A mass on a spring and a damper, between one or more bearings and the ground or a housing.

    A support adds two coordinates, its displacements v and w, and with `axial_stiffness` its axial
    displacement u. `Bearing(support=...)` takes a support, or the name of one in the argument
    `supports` of `gearbow.RotorSystem`.

    Parameters
    ----------
    name : str, optional
        Name, unique in the system; a shared support needs it, and one whose motion is recorded.
    mass : float
        Mass m [kg].
    stiffness : float, pair or 2×2 array
        Stiffness to the ground or housing [N/m]: a number, (yy, zz), or [[yy, yz], [zy, zz]].
    damping : float, pair or 2×2 array
        Damping to the ground or housing [N s/m], in the same forms.
    axial_stiffness : float, optional
        Stiffness to the ground or housing along the axis [N/m]; it acts in a system with axial
        motion. None: the support does not move along the axis relative to the ground or housing.
    axial_damping : float
        Damping to the ground or housing along the axis [N s/m].
    loss_factor : float
        Loss factor η of the stiffness, as for `Bearing`.
    support : str or (str, str), optional
        Name of the housing on which the support stands, or (elastic housing, interface). Stiffness,
        damping and film then act between the support and the place of its bearing on the housing,
        with which it tilts. None: the support stands on the ground.

    Examples
    --------
    >>> import gearbow as gb
    >>> pedestal = gb.Support("pedestal", mass=12.0, stiffness=(5e7, 8e7), damping=2e3)
    >>> bearing = gb.Bearing("rotor", 0.0, stiffness=1e8, support=pedestal)
    """

    name: str | None = None
    _: KW_ONLY
    mass: float
    stiffness: "ArrayLike"
    damping: "ArrayLike" = 0.0
    axial_stiffness: float | None = None
    axial_damping: float = 0.0
    loss_factor: float = 0.0
    support: str | tuple[str, str] | None = None


#: What a bearing stands on: the name of a support or housing, a support, (shaft, position [m]), or
#: (elastic housing, interface).
Base: TypeAlias = str | Support | tuple[str, float] | tuple[str, str]


def other_shaft(base: object) -> tuple[str, float] | None:
    """Give the place of another shaft on which a bearing stands; None for another base."""
    if not isinstance(base, tuple) or isinstance(base[1], str):
        return None
    shaft, position = base
    return shaft, position


def housing_and_interface(base: object) -> tuple[str, str] | None:
    """Give the elastic housing and the interface on which a bearing stands; None if it has none."""
    if not isinstance(base, list | tuple) or not isinstance(base[1], str):
        return None
    housing, interface = base
    return housing, interface


def name_of_housing(base: object) -> str | None:
    """Give the name of the housing on which a support or interface stands; None for the ground."""
    seat = housing_and_interface(base)
    return seat[0] if seat is not None else base if isinstance(base, str) else None


@dataclass(frozen=True)
class Housing(Part):
    """A rigid body on springs and dampers that carries several bearings.

    `from_matrices` makes an elastic one. `Bearing(support=name)` puts a bearing on it. A housing
    adds two coordinates, its displacements v and w, with `inertia` three more: its rotations B, G
    about y, z and its roll "twist" about x, and with `axial_stiffness` its axial displacement u.
    The lever arms of the bearings follow from the positions of the shafts at rest: the first shaft
    begins at the origin, meshes and couplings give the positions of the others.

    Parameters
    ----------
    name : str
        Name, unique in the system.
    mass : float
        Mass m [kg].
    stiffness : float, pair or 2×2 array
        Stiffness to the ground at the centre of mass [N/m], as that of `Support`.
    damping : float, pair or 2×2 array
        Damping to the ground at the centre of mass [N s/m], in the same forms.
    axial_stiffness : float, optional
        Stiffness to the ground along the axis at the centre of mass [N/m]; it acts in a system with
        axial motion. None: the centre of mass does not move along the axis.
    axial_damping : float
        Damping to the ground along the axis at the centre of mass [N s/m].
    loss_factor : float
        Loss factor η of the stiffness, as for `Bearing`.
    inertia : (float, float, float), optional
        Moments of inertia about the axes through the centre of mass parallel to x, y and z
        [kg m²]; products of inertia are neglected. None: the housing does not rotate.
    position : (float, float, float)
        Centre of mass (x, y, z) [m].
    rotational_stiffness, rotational_damping : (float, float, float)
        Those to the ground about x, y and z [N m/rad, N m s/rad].
    points : mapping of {str: (float, float, float)}
        Points (x, y, z) [m] whose motion can be recorded by name, as of accelerometers.
    elastic : ElasticBody, optional
        Modes of an elastic housing, which `from_matrices` makes.

    Examples
    --------
    >>> import gearbow as gb
    >>> housing = gb.Housing(
    ...     "gearbox",
    ...     mass=80.0,
    ...     stiffness=2e8,
    ...     damping=1e4,
    ...     inertia=(2.0, 3.0, 3.0),
    ...     position=(0.25, 0.05, 0.0),
    ...     rotational_stiffness=(1e7, 2e7, 2e7),
    ...     points={"accelerometer": (0.0, 0.1, 0.15)},
    ... )
    """

    name: str
    _: KW_ONLY
    mass: float
    stiffness: "ArrayLike"
    damping: "ArrayLike" = 0.0
    axial_stiffness: float | None = None
    axial_damping: float = 0.0
    loss_factor: float = 0.0
    inertia: Sequence[float] | None = None
    position: Sequence[float] = (0.0, 0.0, 0.0)
    rotational_stiffness: Sequence[float] | None = None
    rotational_damping: Sequence[float] | None = None
    points: Mapping[str, Sequence[float]] = field(default_factory=dict)
    elastic: ElasticBody | None = None

    @classmethod
    def from_matrices(
        cls,
        name: str,
        *,
        mass: Any,
        stiffness: Any,
        interfaces: Mapping[str, Interface],
        highest_frequency: float,
        damping_ratio: float = 0.0,
        surface: Surface | None = None,
    ) -> "Housing":
        """Make an elastic housing of the matrices of a finite-element model.

        The model is reduced to its natural modes up to 2.2 times `highest_frequency` and the static
        responses to forces at the interfaces. `Bearing(support=("housing", "bearing 1"))` puts a
        bearing on an interface; the motion of every interface can be recorded by its name.

        Parameters
        ----------
        name : str
            Name, unique in the system.
        mass, stiffness : array_like, sparse matrix or path-like, shape (n, n)
            Symmetric matrices in SI units. A clamped model has no free motion, a free one six. A
            file has one of them, or both with names that begin with m, and with k or s: NumPy and
            SciPy (``.npz``, ``.npy``), MATLAB up to version 7 (``.mat``), Matrix Market
            (``.mtx``), or DMIG entries of Nastran (``.pch``, ``.bdf``, ``.dat``), whose rows are in
            ascending order of grid and component.
        interfaces : mapping of {str: Interface}
            Bearing seats, feet and sensors by unique names; the feet of a free model have springs.
        highest_frequency : float
            Highest frequency of interest [Hz].
        damping_ratio : float
            Damping ratio of every elastic mode.
        surface : Surface, optional
            The surface that radiates sound, for `radiated_power` of harmonic responses.

        Returns
        -------
        Housing
            The housing. Its weight counts if it is free; the own sag of a clamped one is left out.

        Raises
        ------
        SceneError
            If the matrices are no symmetric square matrices of one size, leave some but not six
            motions free, or do not fit the positions of the interfaces, or if a file is damaged,
            of another format, or has several matrices.

        Examples
        --------
        A mass of 5 kg on springs of 1e6 N/m along x, y and z:

        >>> import numpy as np
        >>> import gearbow as gb
        >>> seat = gb.Interface((0.0, 0.0, 0.0), rows=[0, 1, 2])
        >>> housing = gb.Housing.from_matrices(
        ...     "housing", mass=5.0 * np.eye(3), stiffness=1e6 * np.eye(3),
        ...     interfaces={"seat": seat}, highest_frequency=1000.0)
        >>> print(f"{housing.elastic.frequencies[0]:.1f} rad/s")
        447.2 rad/s
        """
        name = text(name, "name")
        body, total = reduced(
            Matrices.of(mass, stiffness),
            interfaces,
            highest_frequency=highest_frequency,
            damping_ratio=damping_ratio,
            surface=surface,
        )
        places_given = np.array([one.position for one in interfaces.values()], dtype=np.float64)
        middle = tuple(places_given.mean(axis=0).tolist())
        return cls(name, mass=total, stiffness=0.0, position=middle, elastic=body)

    def __post_init__(self) -> None:
        freeze(self, "inertia", "position", "rotational_stiffness", "rotational_damping")


#: Positions with a smaller difference [m], or relative to a position above 1 m, are equal.
_SAME_POSITION = 1e-9
#: Forms of a place, by what is there.
_FORMS = {
    "item": "a name or a tuple such as (shaft, position)",
    "place": "a name or (shaft, position)",
    "bearing": "(shaft, position)",
    "mesh": '(driver, driven) or "driver/driven"',
}


class Places:
    """Known places, each with all its forms: names, (shaft, position) or (driver, driven)."""

    def __init__(self, kind: str, known: Iterable[Sequence[Any]]) -> None:
        self.kind = kind
        self.known = [tuple(forms) for forms in known]
        self._named: dict[Any, int] = {}
        self._along: dict[str, list[tuple[float, int]]] = {}
        for i, forms in enumerate(self.known):
            for form in forms:
                if is_place(form):
                    self._along.setdefault(form[0], []).append((float(form[1]), i))
                    continue
                self._named.setdefault(form, i)
                if is_pair(form):
                    self._named.setdefault(form[::-1], i)

    def find(self, at: object, path: str = "at") -> int | None:
        """Give the index of a place; None if it is none of the known ones."""
        wanted = place(at, path, self.kind)
        if not is_place(wanted):
            return self._named.get(wanted)
        position = wanted[1]
        for x, i in self._along.get(wanted[0], ()):
            if abs(x - position) <= _SAME_POSITION * max(1.0, abs(x)):
                return i
        return None

    def index(self, at: object, what: str = "") -> int:
        """Give the index of a known place; `what` is its name in the error if there is none."""
        found = self.find(at)
        if found is None:
            where = place(at)
            named = f"of {where[0]!r} with {where[1]!r}" if is_pair(where) else f"at {where}"
            raise ChannelError(f"at: no {what or self.kind} {named}; there are {self}")
        return found

    @classmethod
    def of(cls, kind: str, known: Iterable[Sequence[Any]]) -> "Places":
        """Make known places of one form each."""
        return cls(kind, ([tuple(each)] for each in known))

    def positions(self, shaft: str) -> list[float]:
        """Give the known positions on a shaft [m]."""
        return [x for x, _ in self._along.get(shaft, ())]

    def __str__(self) -> str:
        return ", ".join(repr(forms[-1]) for forms in self.known) or "none"


def place(at: object, path: str = "at", kind: str = "item") -> Any:
    """Convert a name, (shaft, position), a mesh or another recorded item to plain Python."""
    found: Any = None
    if isinstance(at, str):
        driver, slash, driven = at.partition("/")
        found = (driver, driven) if slash else at
    elif isinstance(at, (tuple, list)) and len(at) in (2, 3) and isinstance(at[0], str):
        found = tuple(
            item if isinstance(item, str) else real(item, f"{path}[{i}]", "a name or a number")
            for i, item in enumerate(at)
        )
    suits = {
        "item": found is not None,
        "place": isinstance(found, str) or is_place(found),
        "bearing": is_place(found),
        "mesh": is_pair(found),
    }
    if not suits[kind]:
        raise SceneError(f"{path}: must be {_FORMS[kind]}, got {shown(at)}")
    return found


def is_place(at: object) -> bool:
    """Return whether this is (shaft, position)."""
    return (
        isinstance(at, tuple)
        and len(at) == 2
        and isinstance(at[0], str)
        and (isinstance(at[1], numbers.Real) or is_quantity(at[1]))
    )


def is_pair(at: object) -> bool:
    """Return whether this is (driver, driven)."""
    return isinstance(at, tuple) and len(at) == 2 and all(isinstance(name, str) for name in at)


def places(given: object, path: str = "at", kind: str = "place") -> tuple[Any, ...]:
    """Convert one place, or several."""
    if isinstance(given, str) or is_place(given) or (is_pair(given) and kind == "mesh"):
        return (place(given, path, kind),)
    if not isinstance(given, Iterable) or isinstance(given, (Mapping, *BYTES)):
        raise SceneError(f"{path}: must be a list of names or tuples, got {shown(given)}")
    found = tuple(place(at, f"{path}[{i}]", kind) for i, at in enumerate(given))
    if not found:
        raise SceneError(f"{path}: must name at least one gear, disk or (shaft, position)")
    return found


def place_label(at: str | tuple[str, float]) -> str:
    """Give the label of a place in figures, e.g. "rotor at 0.5 m"."""
    return at if isinstance(at, str) else f"{at[0]} at {at[1]:g} m"


def names_of_bases(own: Iterable[object], *listed: Support | Housing) -> list[str]:
    """Give the names of what bearings stand on: their own supports, and those that are listed."""
    bases = [*listed, *(base for base in own if isinstance(base, Support))]
    return [base.name for base in bases if base.name is not None]


def cleaned(name: str) -> str:
    """Replace what names of gearbow do not contain: "/" and ":"."""
    return re.sub("[/:]", "-", name)


def unique(name: str, number: int, taken: Container[str]) -> str:
    """Clean a name, and add the number of its component if another part has it."""
    found = cleaned(name)
    return f"{found} [{number}]" if found in taken else found
