"""Description of a system: parts and options, variants, files and degrees of freedom."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gearbow._convert import copied, nested, number, showing, shown, text
from gearbow._core import Model
from gearbow._keywords import CheckedKeywords
from gearbow._lookup import nearest
from gearbow._shown import Shown, Table, listed
from gearbow._types import Array, Dof, Plain
from gearbow.description.assumptions import assumptions
from gearbow.description.coordinates import Coordinates
from gearbow.description.couplings import Coupling, Drive, Force
from gearbow.description.gears import Disk, Gear, Mesh
from gearbow.description.journal import JournalBearing
from gearbow.description.load_values import functions, over_time, refuse_functions
from gearbow.description.loads import Bearing, Torque
from gearbow.description.part import Part, parts, tuples
from gearbow.description.places import names_of_bases
from gearbow.description.rolling import RollingBearing
from gearbow.description.shafts import Shaft
from gearbow.description.supports import Housing, Support
from gearbow.description.train import PARTS, parts_of
from gearbow.errors import SceneError, SceneWarning, outside
from gearbow.results.discretisation import Discretisation
from gearbow.units.convert import without_texts

if TYPE_CHECKING:
    from typing_extensions import Self

__all__ = ["SystemDescription", "warn"]

#: Further classes of a list of parts.
_OTHERS: dict[str, tuple[type[Part], ...]] = {"bearings": (JournalBearing, RollingBearing)}
#: Options of a system, and their conversion to plain data.
_OPTIONS: dict[str, Callable[[object, str], Plain]] = {
    "reference": text,
    "modal_damping": number,
    "rayleigh": nested,
    "gravity": nested,
    "motion": text,
    "resolution": text,
}
#: Values of options that were not given, where they are not None.
_DEFAULTS = {"resolution": "engineering"}


class SystemDescription(CheckedKeywords, Shown):
    """Parts and options of a system, checked by the core.

    The parameters are those of `gearbow.RotorSystem`.
    """

    shafts: tuple[Shaft, ...]
    gears: tuple[Gear, ...]
    meshes: tuple[Mesh, ...]
    bearings: tuple[Bearing | JournalBearing | RollingBearing, ...]
    torques: tuple[Torque, ...]
    disks: tuple[Disk, ...]
    supports: tuple[Support, ...]
    housings: tuple[Housing, ...]
    couplings: tuple[Coupling, ...]
    drives: tuple[Drive, ...]
    forces: tuple[Force, ...]
    reference: str | None
    modal_damping: float | None
    rayleigh: tuple[float, float] | None
    gravity: float | tuple[float, float] | None
    motion: str | None
    resolution: str

    def __init__(
        self,
        shafts: Sequence[Shaft],
        gears: Sequence[Gear] = (),
        meshes: Sequence[Mesh] = (),
        bearings: Sequence[Bearing | JournalBearing | RollingBearing] = (),
        torques: Sequence[Torque] = (),
        *,
        disks: Sequence[Disk] = (),
        supports: Sequence[Support] = (),
        housings: Sequence[Housing] = (),
        couplings: Sequence[Coupling] = (),
        drives: Sequence[Drive] = (),
        forces: Sequence[Force] = (),
        reference: str | None = None,
        modal_damping: float | None = None,
        rayleigh: tuple[float, float] | None = None,
        gravity: float | tuple[float, float] | None = None,
        motion: str | None = None,
        resolution: str = "engineering",
    ) -> None:
        lists: tuple[Sequence[Part], ...] = (shafts, gears, meshes, bearings, torques, disks)
        lists = (*lists, supports, housings, couplings, drives, forces)
        options = {
            "reference": reference,
            "modal_damping": modal_damping,
            "rayleigh": rayleigh,
            "gravity": gravity,
            "motion": motion,
            "resolution": resolution,
        }
        plain = self._read(lists, options)
        with showing(plain):
            self._model = Model(plain)
        warn(self._model)

    def _read(
        self, lists: Sequence[Sequence[Part]], options: Mapping[str, object]
    ) -> dict[str, Plain]:
        """Keep parts, in the order of `PARTS`, and options; return them as plain data."""
        for (key, kind), given in zip(PARTS.items(), lists, strict=True):
            listed = enumerate(parts(given, kind, key, *_OTHERS.get(key, ())))
            setattr(self, key, tuple(part._in_si(f"{key}[{i}]") for i, part in listed))
        description: dict[str, Plain] = {
            key: [part._describe(f"{key}[{i}]") for i, part in enumerate(getattr(self, key))]
            for key in PARTS
        }
        for key, value in options.items():
            converted = None if value is None else _OPTIONS[key](value, key)
            setattr(self, key, tuples(converted))
            if converted is not None and converted != _DEFAULTS.get(key):
                description[key] = converted
        return description

    @classmethod
    def _from_model(cls, model: Model) -> "Self":
        """Make a system of a checked model; parts and options follow from its description."""
        system = cls.__new__(cls)
        system._model = model
        description = model.description()
        for key, parts_given in parts_of(description).items():
            setattr(system, key, parts_given)
        for key in _OPTIONS:
            setattr(system, key, tuples(description.get(key, _DEFAULTS.get(key))))
        return system

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "Self":
        """Make a system that was checked before, without warnings."""
        plain = copied(without_texts(description), "")
        with showing(plain):
            return cls._from_model(Model(plain))

    @classmethod
    def from_dict(cls, description: Mapping[str, Plain]) -> "Self":
        """Make a system from plain data, the inverse of `description`.

        Parameters
        ----------
        description : mapping
            The keys are the names of the parameters, as in a TOML file; complex numbers may be
            pairs [re, im], and values may be texts with a unit, such as "500 mm".

        Returns
        -------
        RotorSystem
            The system.

        Raises
        ------
        SceneError
            If the description is invalid, or has an unknown key.

        Warns
        -----
        SceneWarning
            If the description is implausible.

        Examples
        --------
        >>> import gearbow as gb
        >>> shaft = {"name": "rotor", "length": 1.0, "outer_diameter": 0.05, "elements": 4}
        >>> gb.RotorSystem.from_dict({"shafts": [shaft], "gravity": 9.81}).gravity
        9.81
        """
        if not isinstance(description, Mapping):
            raise SceneError(f"description: must be a mapping, got {shown(description)}")
        system = cls._from_description(description)
        warn(system._model)
        return system

    def replace(self, **changes: Any) -> "Self":
        """Make a system with other parts or options. All others stay the same.

        The new system shares the modes of this one if they differ only in forces, torques (except
        over the speed), gravity, bows and unbalances, and have no journal bearings.

        Parameters
        ----------
        **changes
            Parameters of `RotorSystem` by name: lists of parts replace the whole list, None removes
            an option. `dataclasses.replace` changes a single part.

        Returns
        -------
        RotorSystem
            The new system. This system does not change.

        Raises
        ------
        SceneError
            If a name is unknown, or the new system is invalid.

        Warns
        -----
        SceneWarning
            If the new system is implausible.

        Examples
        --------
        >>> from dataclasses import replace
        >>> import gearbow as gb
        >>> shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
        >>> system = gb.RotorSystem(shafts=[shaft], gravity=9.81)
        >>> bent = system.replace(shafts=[replace(shaft, bow=gb.Bow.half_sine(1e-4))])
        >>> bent.shafts[0].bow.amplitude, bent.gravity
        (0.0001, 9.81)
        >>> system.replace(gravity=None).gravity is None
        True
        """
        system = type(self)(**self._changed(changes))
        system._model.share(self._model)
        return system

    def _variation(self, **changes: Any) -> "Self":
        """Make a system as `replace`, with elements and modes of this one if only loads change."""
        given = self._changed(changes)
        system = type(self).__new__(type(self))
        lists = [given[key] for key in PARTS]
        description = system._read(lists, {key: given[key] for key in _OPTIONS})
        with showing(description):
            system._model = self._model.variation(description)
        warn(system._model)
        return system

    def _changed(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """Give all parts and options with some of them changed."""
        names = (*PARTS, *_OPTIONS)
        for key in changes:
            if key not in names:
                raise SceneError(
                    f"replace: {key!r} is not a parameter of a system{nearest(key, names)}"
                )
        return {**{key: getattr(self, key) for key in names}, **changes}

    @property
    def description(self) -> dict[str, Plain]:
        """Description of the system as plain data.

        Returns
        -------
        dict
            The keys are the names of the parameters. Options that were not given are absent.

        Raises
        ------
        SceneError
            If a force or torque is a function of time, which has no plain form.
        """
        refuse_functions(torques=self.torques, forces=self.forces)
        return self._model.description()

    def _over_time(self, begin: float, duration: float) -> "Self":
        """Replace functions of time by their samples over a run. The elements stay the same."""
        lists = {"torques": self.torques, "forces": self.forces}
        if not functions(**lists):
            return self
        changes: dict[str, Any] = {k: over_time(v, begin, duration, k) for k, v in lists.items()}
        if self._model.choice is not None:
            given = self._model.resolved()["shafts"]
            changes["shafts"] = [Shaft._from_description(shaft) for shaft in given]
        return self.replace(**changes)

    @property
    def discretisation(self) -> Discretisation:
        """Give the number and degree of the elements of every shaft.

        Where a shaft has no number of elements, both are chosen once, when the system is created,
        from the scene and the option `resolution`. The number of coordinates is the smallest for
        which the expected error stays below the level.

        Returns
        -------
        Discretisation
            Elements, their expected error and the highest frequency that they represent.

        Examples
        --------
        >>> import gearbow as gb
        >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
        >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
        >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
        >>> system.discretisation.expected_error < 1e-3
        True
        """
        return Discretisation.of(self._model.resolved(), self._model.choice, len(self.dofs))

    @property
    def speed_ratios(self) -> Array:
        """Signed speed of each shaft over that of the reference shaft.

        Returns
        -------
        ndarray, shape (shafts,)
            The ratios r_s; every external mesh reverses the sign.
        """
        return self._model.speed_ratios

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """All degrees of freedom, in the order of every matrix and vector.

        Returns
        -------
        tuple of (str, float or (float, float), str)
            First those of the nodes: shaft, position [m] and "u" (translation along x, in a system
            with axial motion), "v", "w" (along y, z), "B", "G" (rotation about y, z) or "twist".
            Then those within elements of a degree above 1: shaft, positions of the two ends of the
            element [m], and the direction with the degree of the shape function, for example "v2".
            Last come supports and housings: name, x of the centre of mass [m] and "v", "w", with
            "B", "G", "twist" if they rotate.
        """
        return tuple(self._model.dofs)

    @property
    def coordinates(self) -> Coordinates:
        """Give the degrees of freedom by name and place.

        Returns
        -------
        Coordinates
            The coordinates.
        """
        own = (bearing.support for bearing in self.bearings)
        bases = names_of_bases(own, *self.supports, *self.housings)
        return Coordinates.of(self.dofs, self.gears, self.disks, bases, self.housings)

    def __reduce__(self) -> tuple[Callable[[dict[str, Plain]], "Self"], tuple[dict[str, Plain]]]:
        return type(self)._from_description, (self.description,)

    def __repr__(self) -> str:
        counts = [f"{len(getattr(self, key))} {key}" for key in PARTS if getattr(self, key)]
        dofs, ratios = len(self._model.dofs), listed(self.speed_ratios)
        text = f"{', '.join(counts)}; speed ratios {ratios}; {dofs} degrees of freedom"
        return f"{type(self).__name__}({text})"

    def __str__(self) -> str:
        assumed = assumptions(self.shafts, self.gears, self.meshes)
        return "\n".join([repr(self), *(f"  assumed for {text}" for text in assumed)])

    def _rows(self) -> Table:
        """Give a row for each shaft: speed ratio, gears, and tooth frequencies over the speed."""
        rows = []
        for shaft, ratio in zip(self.shafts, self.speed_ratios, strict=True):
            gears = [gear for gear in self.gears if gear.shaft == shaft.name]
            teeth = ", ".join(f"{gear.name} ({gear.teeth})" for gear in gears)
            orders = ", ".join(f"{abs(ratio) * gear.teeth:.6g}" for gear in gears)
            rows.append((shaft.name, f"{ratio:.6g}", teeth, orders))
        return (("shaft", "speed ratio", "gears (teeth)", "tooth frequency / speed"), *rows)


def warn(model: Model) -> None:
    """Warn about implausible entries, at the line outside the package that made the system."""
    for message in model.warnings:
        warnings.warn(message, SceneWarning, stacklevel=outside())
