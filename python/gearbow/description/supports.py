"""What bearings stand on: supports and housings."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, TypeAlias

from numpy.typing import ArrayLike

from gearbow._convert import nested, shown, text
from gearbow._types import Plain
from gearbow.description.part import Part, freeze, tuples
from gearbow.errors import SceneError


@dataclass(frozen=True)
class Support(Part):
    """A mass on a spring and a damper, between one or more bearings and the ground.

    A support adds two coordinates, its displacements v and w, and with `axial_stiffness` its axial
    displacement u. `Bearing(support=...)` takes a support, or the name of one in the argument
    `supports` of `gearbow.RotorSystem`.

    Parameters
    ----------
    name : str, optional
        Name, unique in the system. A support that several bearings share needs a name, and so does
        one whose motion is recorded.
    mass : float
        Mass m [kg].
    stiffness : float, pair or 2×2 array
        Stiffness to the ground [N/m]: a number for every direction, (yy, zz), or
        [[yy, yz], [zy, zz]].
    damping : float, pair or 2×2 array
        Damping to the ground [N s/m], in the same forms.
    axial_stiffness : float, optional
        Stiffness to the ground along the axis [N/m]; it acts in a system with axial motion. None:
        the support does not move along the axis.
    axial_damping : float
        Damping to the ground along the axis [N s/m].
    loss_factor : float
        Loss factor η of the stiffness, K(1 + iη sgn ω): structural damping of modes,
        Campbell diagrams, `frequency_response` and `synchronous`. Runs refuse it.

    Examples
    --------
    >>> import gearbow as gb
    >>> pedestal = gb.Support("pedestal", mass=12.0, stiffness=(5e7, 8e7), damping=2e3)
    >>> bearing = gb.Bearing("rotor", 0.0, stiffness=1e8, support=pedestal)
    """

    name: str | None = None
    _: KW_ONLY
    mass: float
    stiffness: ArrayLike
    damping: ArrayLike = 0.0
    axial_stiffness: float | None = None
    axial_damping: float = 0.0
    loss_factor: float = 0.0


#: What a bearing stands on: the name of a support or housing, a support, or (shaft, position [m]).
Base: TypeAlias = str | Support | tuple[str, float]


def with_support(bearing: Mapping[str, Plain]) -> dict[str, Any]:
    """Replace the description of what a bearing stands on by the support or the place."""
    given = dict(bearing)
    base = given.get("support")
    if isinstance(base, Mapping):
        given["support"] = Support._from_description(base)
    elif isinstance(base, (list, tuple)):
        given["support"] = tuple(base)
    return given


@dataclass(frozen=True)
class Housing(Part):
    """A rigid body on springs and dampers that carries several bearings.

    `Bearing(support=name)` puts a bearing on it. A housing adds two coordinates, its displacements
    v and w, with `inertia` three more: its rotations B, G about y, z and its roll "twist" about x,
    and with `axial_stiffness` its axial displacement u. The lever arms of the bearings follow from
    the positions of the shafts at rest: the first shaft begins at the origin, meshes and couplings
    give the positions of the others.

    Parameters
    ----------
    name : str
        Name, unique in the system.
    mass : float
        Mass m [kg].
    stiffness : float, pair or 2×2 array
        Stiffness to the ground at the centre of mass [N/m]: a number for every direction, (yy, zz),
        or [[yy, yz], [zy, zz]].
    damping : float, pair or 2×2 array
        Damping to the ground at the centre of mass [N s/m], in the same forms.
    axial_stiffness : float, optional
        Stiffness to the ground along the axis at the centre of mass [N/m]; it acts in a system with
        axial motion. None: the centre of mass does not move along the axis.
    axial_damping : float
        Damping to the ground along the axis at the centre of mass [N s/m].
    loss_factor : float
        Loss factor η of the stiffness, K(1 + iη sgn ω): structural damping of modes,
        Campbell diagrams, `frequency_response` and `synchronous`. Runs refuse it.
    inertia : (float, float, float), optional
        Moments of inertia about the axes through the centre of mass parallel to x, y and z
        [kg m²]; products of inertia are neglected. None: the housing does not rotate.
    position : (float, float, float)
        Centre of mass (x, y, z) [m].
    rotational_stiffness : (float, float, float)
        Stiffness to the ground about x, y and z [N m/rad].
    rotational_damping : (float, float, float)
        Damping to the ground about x, y and z [N m s/rad].
    points : mapping of {str: (float, float, float)}
        Points (x, y, z) [m] whose motion can be recorded by name, for example those of
        accelerometers.

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
    stiffness: ArrayLike
    damping: ArrayLike = 0.0
    axial_stiffness: float | None = None
    axial_damping: float = 0.0
    loss_factor: float = 0.0
    inertia: Sequence[float] | None = None
    position: Sequence[float] = (0.0, 0.0, 0.0)
    rotational_stiffness: Sequence[float] | None = None
    rotational_damping: Sequence[float] | None = None
    points: Mapping[str, Sequence[float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        freeze(self, "inertia", "position", "rotational_stiffness", "rotational_damping")

    def _describe(self, path: str) -> dict[str, Plain]:
        if not isinstance(self.points, Mapping):
            raise SceneError(
                f"{path}.points: must be a dict of name: (x, y, z), got {shown(self.points)}"
            )
        # A mapping has no annotation that `Part` knows.
        given = super(Housing, replace(self, points=()))._describe(path)  # type: ignore[arg-type]
        given.pop("points", None)
        if given.get("position") == [0.0, 0.0, 0.0]:
            given.pop("position", None)
        if self.points:
            given["points"] = {
                text(name, f"{path}.points"): nested(place, f"{path}.points.{name}")
                for name, place in self.points.items()
            }
        return given

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "Housing":
        given = dict(description)
        given["points"] = {
            name: tuples(place) for name, place in description.get("points", {}).items()
        }
        return cls(**given)
