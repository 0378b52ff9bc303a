"""The rotor system: its parts and options, files, variants, and all its analyses."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

from gearbow._convert import CheckedKeywords, copied, nearest, nested, showing, shown, text, truth
from gearbow._core import Model, mesh_geometry
from gearbow._files import check_name, replacing
from gearbow._shown import Shown, Table, listed
from gearbow._types import Accuracy, Array, Dof, Plain, ShaftMotion
from gearbow.accuracy import DEFAULT
from gearbow.analysis.balance import balance
from gearbow.description.coordinates import Coordinates
from gearbow.description.gears import Disk, Gear, Mesh
from gearbow.description.layout import assumptions, ratios_by_shaft, tooth_orders
from gearbow.description.loads import AnyBearing, Coupling, Drive, Force, Torque
from gearbow.description.part import Part, parts, tuples
from gearbow.description.places import Housing, Support
from gearbow.description.planetary import PlanetaryStage, expanded, planet_masses, tooth_angles
from gearbow.description.shafts import Notch, Shaft, Sleeve
from gearbow.description.time_series import (
    described_ratios,
    functions,
    given_ratios,
    over_time,
    refuse_functions,
)
from gearbow.description.train import PARTS, parts_of
from gearbow.errors import SceneError, SceneWarning, warn
from gearbow.results.properties import Discretisation
from gearbow.sweeps.many import simulate_many
from gearbow.system.bodies import write_bodies
from gearbow.system.bow_limits import bow_limits
from gearbow.system.continuation import continuation
from gearbow.system.frequency import frequency_response, mesh_response
from gearbow.system.linear import (
    campbell,
    critical_speed_map,
    efficiency,
    layout_of,
    mass_properties,
    matrices,
    modes,
    static,
    synchronous,
)
from gearbow.system.outputs import plot, report, to_fmu
from gearbow.system.sensitivity import sensitivity
from gearbow.system.simulation import default_output_step, require_memory_of_runs, simulate
from gearbow.system.steady import steady_state
from gearbow.system.strength import bearing_life, stresses, thermal_bow
from gearbow.system.tradeoff import tradeoff
from gearbow.units.fields import without_texts
from gearbow.units.speed import SpeedUnit, in_given_unit, unit_in_texts

if TYPE_CHECKING:
    from typing_extensions import Self

#: Options of a system, and their conversion to plain data.
_OPTIONS: dict[str, Callable[[object, str], Plain]] = {
    "reference": text,
    "modal_damping": described_ratios,
    "rayleigh": nested,
    "geometric_stiffness": truth,
    "bow_torque": truth,
    "gravity": nested,
    "motion": text,
    "accuracy": text,
}
#: Values of options that were not given, where they are not None.
_DEFAULTS: dict[str, Plain] = {
    "accuracy": DEFAULT,
    "geometric_stiffness": False,
    "bow_torque": False,
}


def _as_given(key: str, plain: Plain) -> Plain:
    """Give the value of an option as a user gives it."""
    return given_ratios(plain) if key == "modal_damping" else tuples(plain)


class RotorSystem(CheckedKeywords, Shown):
    """A system of shafts with gears, disks, bearings and torques.

    Parameters
    ----------
    shafts : sequence of Shaft
        The shafts, parallel to x.
    gears : sequence of Gear
        The gears.
    meshes : sequence of Mesh
        The meshes between gears.
    bearings : sequence of Bearing
        The bearings.
    torques : sequence of Torque
        Torques on the shafts.
    disks : sequence of Disk
        Rigid disks.
    supports : sequence of Support
        Supports that bearings refer to by name.
    housings : sequence of Housing
        Housings, which carry several bearings.
    couplings : sequence of Coupling
        Couplings between shafts of one speed.
    drives : sequence of Drive
        Drives, which hold the rotation.
    forces : sequence of Force
        Lateral forces.
    sleeves : sequence of Sleeve
        Sleeves around shafts.
    notches : sequence of Notch
        Notches of shafts, which only `stresses` depends on.
    planetary_stages : sequence of PlanetaryStage
        Planetary stages. Their planets, meshes and bearings are added to the parts above.
    reference : str, optional
        Name of the reference shaft, whose speed all speeds refer to; None is the first.
    modal_damping : float, mapping or callable, optional
        Damping ratio of the undamped modes: the same for every mode; ratios by mode number, such as
        {1: 0.02, 2: 0.01, "other": 0.03}, where "other" is 0 by default and the numbers count the
        elastic undamped modes of the speed from 1 in ascending frequency (rigid-body modes have no
        number); a table {"frequencies": [rad/s], "ratios": [...]}; or a function ζ(ω) of undamped
        frequencies [rad/s], which becomes a table from 10 to 1e5 rad/s. Tables are monotone cubics
        between their points, and constant outside.
    rayleigh : tuple of (float, float), optional
        Damping αM + βK of the shafts [1/s, s].
    geometric_stiffness : bool
        Whether the axial forces of the static equilibrium, such as the thrust of helical gears,
        change the bending stiffness of the shafts, beside `Shaft.axial_force`.
    bow_torque : bool
        Whether the bow of a shaft turns with the twist of the shaft, and so has a moment about it:
        about b/r of a mesh force once per revolution, with the bow b at a gear of the base radius
        r. False turns the bow with the prescribed angle, so that runs that are linear stay so.
    gravity : float or tuple of (float, float), optional
        Gravity [m/s²], along −z or as (y, z).
    motion : {"lateral", "torsion", "coupled"}, optional
        The degrees of freedom of a node; None chooses those that the scene requires. "coupled" is
        bending and torsion. Axial motion is added to bending, except to "lateral", where helical
        gears, an axial force or a bearing with an axial stiffness or damping act on it.
    accuracy : {"draft", "engineering", "reference"}
        Largest total error of runs: 1e-2, 1e-3 or 1e-6 of displacements, and 1e-1, 1e-2 or 1e-4 of
        mesh forces (RMS of the difference / RMS of the signal about its mean, at least 2 % of the
        mean, over the first 0.1 s or the time that damping needs to forget). It decides the
        elements of shafts without a number of elements (see `discretisation`), and the modes and
        the tolerance of runs without other settings. A run may have a lower accuracy.

    Attributes
    ----------
    shafts, gears, meshes, bearings, torques, disks : tuple
        The given parts.
    supports, housings, couplings, drives, forces, sleeves, notches : tuple
        The given parts.
    reference, modal_damping, rayleigh, geometric_stiffness, bow_torque, gravity, motion, accuracy
        The given options; None if not given.

    Warns
    -----
    SceneWarning
        If the description is implausible.

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1.5e-4)
    >>> system = gb.RotorSystem(
    ...     shafts=[
    ...         gb.Shaft("input", length=0.5, outer_diameter=0.05, bow=bow),
    ...         gb.Shaft("output", length=0.5, outer_diameter=0.05),
    ...     ],
    ...     gears=[
    ...         gb.Gear("g1", "input", position=0.25, teeth=25, module=3e-3, face_width=0.03),
    ...         gb.Gear("g2", "output", position=0.25, teeth=50, module=3e-3, face_width=0.03),
    ...     ],
    ...     meshes=[gb.Mesh("g1", "g2", stiffness=2e8, damping_ratio=0.05)],
    ...     bearings=[
    ...         gb.Bearing(shaft, position=x, stiffness=1e8, damping=500.0)
    ...         for shaft in ("input", "output")
    ...         for x in (0.0, 0.5)
    ...     ],
    ...     torques=[gb.Torque("g1", 250.0), gb.Torque.balance("g2")],
    ... )
    >>> system.speed_ratios
    array([ 1. , -0.5])
    >>> system.modes().names()[0]
    'rigid-body rotation'
    >>> response = system.simulate(0.1, speed=100.0)
    >>> contact_ratio = response.mesh(("g1", "g2")).contact_ratio
    >>> print(f"{contact_ratio.max() - contact_ratio.min():.2f}")
    0.10
    """

    shafts: tuple[Shaft, ...]
    gears: tuple[Gear, ...]
    meshes: tuple[Mesh, ...]
    bearings: tuple[AnyBearing, ...]
    torques: tuple[Torque, ...]
    disks: tuple[Disk, ...]
    supports: tuple[Support, ...]
    housings: tuple[Housing, ...]
    couplings: tuple[Coupling, ...]
    drives: tuple[Drive, ...]
    forces: tuple[Force, ...]
    sleeves: tuple[Sleeve, ...]
    notches: tuple[Notch, ...]
    reference: str | None
    modal_damping: float | dict[Any, Any] | None
    rayleigh: tuple[float, float] | None
    geometric_stiffness: bool
    bow_torque: bool
    gravity: float | tuple[float, float] | None
    motion: str | None
    accuracy: str
    #: Unit of speeds in tables and figures, that in the texts of the scene.
    _speed_unit: SpeedUnit = "rad/s"
    #: What the reader of a file assumed or left out.
    _notes: tuple[str, ...] = ()

    def __init__(
        self,
        shafts: Sequence[Shaft],
        gears: Sequence[Gear] = (),
        meshes: Sequence[Mesh] = (),
        bearings: Sequence[AnyBearing] = (),
        torques: Sequence[Torque] = (),
        *,
        disks: Sequence[Disk] = (),
        supports: Sequence[Support] = (),
        housings: Sequence[Housing] = (),
        couplings: Sequence[Coupling] = (),
        drives: Sequence[Drive] = (),
        forces: Sequence[Force] = (),
        sleeves: Sequence[Sleeve] = (),
        notches: Sequence[Notch] = (),
        planetary_stages: Sequence[PlanetaryStage] = (),
        reference: str | None = None,
        modal_damping: "float | Mapping[Any, Any] | Callable[[Any], Any] | None" = None,
        rayleigh: tuple[float, float] | None = None,
        geometric_stiffness: bool = False,
        bow_torque: bool = False,
        gravity: float | tuple[float, float] | None = None,
        motion: ShaftMotion | None = None,
        accuracy: Accuracy = DEFAULT,
    ) -> None:
        lists: tuple[Sequence[Part], ...] = (shafts, gears, meshes, bearings, torques, disks)
        lists = (*lists, supports, housings, couplings, drives, forces, sleeves, notches)
        stages = parts(planetary_stages, PlanetaryStage, "planetary_stages")
        if stages:
            given_parts = (
                parts(shafts, Shaft, "shafts"),
                parts(gears, Gear, "gears"),
                parts(disks, Disk, "disks"),
            )
            added = expanded(stages, *given_parts)
            lists = tuple(
                (*given, *added.get(key, ())) for key, given in zip(PARTS, lists, strict=True)
            )
        options = {
            "reference": reference,
            "modal_damping": modal_damping,
            "rayleigh": rayleigh,
            "geometric_stiffness": geometric_stiffness,
            "bow_torque": bow_torque,
            "gravity": gravity,
            "motion": motion,
            "accuracy": accuracy,
        }
        plain = self._read(lists, options)
        with showing(plain):
            self._model = Model(plain)
        if stages:
            found = self._of_stages(stages)
            lists = tuple(found.get(key, given) for key, given in zip(PARTS, lists, strict=True))
            self._model = Model(self._read(lists, options))
        _warn(self._model)

    def _of_stages(self, stages: Sequence[PlanetaryStage]) -> dict[str, tuple[Part, ...]]:
        """Give meshes with the phases of the teeth of planets, and disks with their masses."""
        pairs = [(mesh.driver, mesh.driven) for mesh in self.meshes]
        geometry = dict(zip(pairs, mesh_geometry(self._model.description()), strict=True))
        gears = {gear.name: gear for gear in self.gears}
        ratios = ratios_by_shaft(self)
        properties = self._model.mass_properties()
        masses = {name: mass for name, (mass, *_) in zip(ratios, properties, strict=True)}
        distances = {pair: own["centre_distance"] for pair, own in geometry.items()}
        found: dict[tuple[str, str], float] = {}
        disks = list(self.disks)
        for stage in stages:
            found |= tooth_angles(stage, self.meshes, geometry, gears, ratios)
            if not stage._bearings("bearing"):  # others move laterally themselves
                planets = {*stage._planets()}
                own = (mesh for mesh in self.meshes if planets & {mesh.driver, mesh.driven})
                name = f"{stage.planet.name} masses".format
                disks += planet_masses(own, distances, gears, masses, name)
        meshes = (
            replace(mesh, tooth_angle=found[pair]) if pair in found else mesh
            for pair, mesh in zip(pairs, self.meshes, strict=True)
        )
        return {"meshes": tuple(meshes), "disks": tuple(disks)}

    def _read(
        self, lists: Sequence[Sequence[Part]], options: Mapping[str, object]
    ) -> dict[str, Plain]:
        """Keep parts, in the order of `PARTS`, and options; return them as plain data."""
        for (key, (kind, *others)), given in zip(PARTS.items(), lists, strict=True):
            listed = enumerate(parts(given, kind, key, *others))
            setattr(self, key, tuple(part._in_si(f"{key}[{i}]") for i, part in listed))
        description: dict[str, Plain] = {
            key: [part._describe(f"{key}[{i}]") for i, part in enumerate(getattr(self, key))]
            for key in PARTS
        }
        for key, value in options.items():
            converted = None if value is None else _OPTIONS[key](value, key)
            setattr(self, key, _as_given(key, converted))
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
            setattr(system, key, _as_given(key, description.get(key, _DEFAULTS.get(key))))
        return system

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "Self":
        """Make a system that was checked before, without warnings."""
        plain = copied(without_texts(description), "")
        with showing(plain):
            system = cls._from_model(Model(plain))
        system._speed_unit = unit_in_texts(description)
        return system

    @classmethod
    def from_dict(cls, description: Mapping[str, Plain]) -> "Self":
        """Make a system from plain data, the inverse of `description`.

        Parameters
        ----------
        description : mapping
            The keys are the names of the parameters, as in a TOML file; complex numbers may be
            pairs [re, im], and values may be texts with a unit, such as "500 mm".

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
        _warn(system._model)
        return system

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Self":
        """Read a system from a TOML file.

        Parameters
        ----------
        path : str or path-like
            A file whose keys are the names of the parameters, as `save` writes it. A value is a
            number in SI units and radians, or a text with a unit, such as "500 mm".

        Raises
        ------
        SceneError
            If the file is not TOML, or if the file of an elastic housing is missing or was changed
            after the scene was saved.
        """
        from gearbow.system.outputs import read_scene  # noqa: PLC0415  # with a TOML parser

        scene = read_scene(path)
        _warn(scene.model)
        system = cls._from_model(scene.model)
        system._speed_unit = scene.speed_unit
        return system

    @classmethod
    def from_ross(cls, path: str | os.PathLike[str], *, meshes: Sequence[Mesh] = ()) -> "Self":
        """Read a rotor that ROSS saved.

        Parameters
        ----------
        path : str or path-like
            A file of ``rotor.save`` of ROSS 1 to 3, ``.toml``, or ``.json`` as of a ``MultiRotor``.
        meshes : sequence of Mesh
            The meshes of the gears of a ``MultiRotor``, which ROSS does not save. A gear has its
            tag as its name; `stiffness` is the ``gear_mesh_stiffness`` of ROSS, and
            `centre_line_angle` its ``orientation_angle``.

        Returns
        -------
        RotorSystem
            The rotor, with one element of degree 1 for each element of ROSS. The shaft has the name
            "rotor"; several shafts have the names "rotor 1", "rotor 2" and so on. Those of a
            ``CoAxialRotor`` turn with one speed. An element around another one is a `Sleeve` with
            all of its stiffness. A speed-dependent bearing has a `SpeedTable`, which ends at its
            speeds.

        Raises
        ------
        SceneError
            If the file is not one of ROSS, or has an element that gearbow cannot represent, for
            example a bearing with added mass; the message names it. If the file has several shafts
            and gears, and no mesh is given.

        Warns
        -----
        SceneWarning
            If a table of ROSS 3 over speed and frequency is read at the frequency of the speed, an
            element excludes its rotary inertia, a shaft has an axial force and ``beta``, the file
            does not contain the material of a gear, or the rotor is implausible.

        Notes
        -----
        The axes x, y, z of ROSS are y, z, x here. https://ross.readthedocs.io
        """
        from gearbow.exchange.ross import read_ross  # noqa: PLC0415  # with a TOML parser

        given = enumerate(parts(meshes, Mesh, "meshes"))
        described = [mesh._in_si(f"meshes[{i}]")._describe(f"meshes[{i}]") for i, mesh in given]
        return cls.from_dict(read_ross(path, described))

    @classmethod
    def read_rexs(
        cls,
        path: str | os.PathLike[str],
        *,
        load_case: int | None = None,
        bearings: Mapping[str, object] | Literal["catalogue"] | None = None,
        couplings: Mapping[str, object] | None = None,
    ) -> "Self":
        """Read a gear unit from a REXS file.

        REXS is the exchange format of FVA for gear units. It contains shafts, gears, stages and
        load cases, but seldom the stiffness of bearings.

        Parameters
        ----------
        path : str or path-like
            A file of version 1.0 to 2.0: ``.rexs``, ``.rexsj`` (JSON), ``.rexsz`` or ``.zip``.
        load_case : int, optional
            Number of the load case in the order of the file, from 1, whose torques and forces act.
            None is the first one. `gearbow.rexs_contents` lists them, with their speeds.
        bearings : "catalogue" or mapping of str to float, mapping or None, optional
            What the file does not contain, by the name of the bearing or a unique part of it: a
            stiffness for the directions in which the file says that it carries [N/m]; parameters
            of `gearbow.Bearing`, `gearbow.RollingBearing`, `gearbow.JournalBearing` or
            `gearbow.TiltingPadBearing` without
            shaft, position and support; options of the estimated rolling bearing, such as
            ``{"clearance": 1e-5}``; or None to leave the bearing out. "other" is for all bearings
            without an entry. Bearings that then have no stiffness are rolling bearings of
            estimated elements, if gearbow knows their dimensions or designation; "catalogue" or
            None is this for all.
        couplings : mapping of str to float, mapping or None, optional
            The same for couplings: a torsional stiffness [N m/rad] or fields of `Coupling`.

        Returns
        -------
        RotorSystem
            The train, with the names of the file. The axes u, v, w of its reference shaft are x, y,
            z. Its reference shaft is the one whose speed the file defines.

        Raises
        ------
        SceneError
            If the file is damaged, has a component that gearbow cannot represent, for example a
            ring gear, or does not contain a value that is not given either; the message names it.

        Warns
        -----
        SceneWarning
            What gearbow assumes or leaves out, and what is implausible.

        Notes
        -----
        https://www.rexs.info
        """
        from gearbow.exchange.rexs import read_system  # noqa: PLC0415  # with a parser of XML

        description, contents = read_system(path, load_case, bearings, couplings)
        for note in contents.notes:
            warn(f"{os.fspath(path)}: {note}", SceneWarning)
        try:
            system = cls.from_dict(description)
        except SceneError as error:
            raise SceneError(f"{os.fspath(path)}: {error}") from None
        system._notes = contents.notes
        return system

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the description to a TOML file, or what REXS can hold of it to a REXS file.

        Parameters
        ----------
        path : str or path-like
            The file. Its name ends with ".toml" or ".rexs". A TOML file contains the sampled points
            of a bow that is given as a function. An elastic housing is in a file of its own that
            belongs to it, such as "scene.housing-0123456789ab.npz" beside "scene.toml", whose name
            follows from its content. Files of an earlier scene remain: another copy of this scene
            may need them. REXS 1.4, which `read_rexs` reads, has shafts, gears, stages, bearings,
            couplings, masses, and constant torques and forces.

        Raises
        ------
        SceneError
            If the name has another ending, a load is a function of time, or REXS cannot hold an
            essential part, for example a housing, a journal bearing or a support.

        Warns
        -----
        SceneWarning
            What a REXS file does not contain, such as damping, bows and the stiffness of meshes.
        """
        path, ending = check_name(path, [".toml", ".rexs"])
        refuse_functions(torques=self.torques, forces=self.forces)
        if ending == ".rexs":
            from gearbow.exchange.rexs_writer import write_rexs  # noqa: PLC0415  # with XML

            write_rexs(self.description, layout_of(self), path)
            return
        text = write_bodies(self.housings, self._model.to_toml(), path)
        with replacing(path) as file:
            file.write(text.encode())

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
        return self._other(changes, is_variation=False)

    def _variation(self, **changes: Any) -> "Self":
        """Make a system as `replace`, with the elements of this one if only loads change."""
        return self._other(changes, is_variation=True)

    def _other(self, changes: Mapping[str, Any], is_variation: bool) -> "Self":
        given = self._changed(changes)
        system = type(self).__new__(type(self))
        lists = [given[key] for key in PARTS]
        description = system._read(lists, {key: given[key] for key in _OPTIONS})
        with showing(description):
            system._model = self._model.changed(description, is_variation)
        system._speed_unit = self._speed_unit
        _warn(system._model)
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
        """Number and degree of the elements of every shaft, with their expected error.

        Where a shaft has no number of elements, both are chosen once, when the system is created,
        from the scene and the option `accuracy`. The number of coordinates is the smallest for
        which the expected error stays below the level.

        Examples
        --------
        >>> import gearbow as gb
        >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
        >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
        >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
        >>> system.discretisation.expected_error < 1e-3
        True
        """
        return Discretisation._of(self._model.resolved(), self._model.choice, len(self.dofs))

    @property
    def speed_ratios(self) -> Array:
        """Signed speed r_s of each shaft over that of the reference shaft, shape (shafts,).

        Every external mesh reverses the sign.
        """
        return self._model.speed_ratios

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """All degrees of freedom, in the order of every matrix and vector.

        First those of the nodes: shaft, position [m] and "u" (translation along x, in a system with
        axial motion), "v", "w" (along y, z), "B", "G" (rotation about y, z) or "twist". Then those
        within elements of a degree above 1: shaft, positions of the two ends of the element [m],
        and the direction with the degree of the shape function, for example "v2". Last come
        supports and housings: name, x of the centre of mass [m] and "v", "w", with "B", "G",
        "twist" if they rotate.
        """
        return tuple(self._model.dofs)

    @property
    def coordinates(self) -> Coordinates:
        """Degrees of freedom by name and place."""
        return Coordinates.of(self)

    plot = plot
    mass_properties = mass_properties
    matrices = matrices
    modes = in_given_unit(modes)
    static = in_given_unit(static)
    efficiency = in_given_unit(efficiency)
    campbell = in_given_unit(campbell)
    critical_speed_map = in_given_unit(critical_speed_map)
    synchronous = in_given_unit(synchronous)
    stresses = in_given_unit(stresses)
    frequency_response = in_given_unit(frequency_response)
    mesh_response = in_given_unit(mesh_response)
    sensitivity = in_given_unit(sensitivity)
    balance = in_given_unit(balance)
    bearing_life = in_given_unit(bearing_life)
    bow_limits = in_given_unit(bow_limits)
    thermal_bow = in_given_unit(thermal_bow)
    simulate = in_given_unit(simulate)
    simulate_many = simulate_many
    default_output_step = default_output_step
    _require_memory_of_runs = require_memory_of_runs
    steady_state = in_given_unit(steady_state)
    continuation = in_given_unit(continuation)
    tradeoff = in_given_unit(tradeoff)
    report = report
    to_fmu = to_fmu

    def __reduce__(self) -> tuple[Callable[[dict[str, Plain]], "Self"], tuple[dict[str, Plain]]]:
        return type(self)._from_description, (self.description,)

    def __repr__(self) -> str:
        counts = [_count(key, len(getattr(self, key))) for key in PARTS if getattr(self, key)]
        dofs, ratios = len(self._model.dofs), listed(self.speed_ratios)
        text = f"{', '.join(counts)}; speed ratios {ratios}; {dofs} degrees of freedom"
        return f"{type(self).__name__}({text}; accuracy {self.accuracy!r})"

    def __str__(self) -> str:
        assumed = assumptions(self)
        return "\n".join([repr(self), *(f"  assumed for {text}" for text in assumed)])

    def _rows(self) -> Table:
        """Give a row for each shaft: speed ratio, gears, and tooth frequencies over the speed."""
        rows, tooth = [], tooth_orders(self)
        for shaft, ratio in ratios_by_shaft(self).items():
            gears = [gear for gear in self.gears if gear.shaft == shaft]
            teeth = ", ".join(f"{gear.name} ({gear.teeth})" for gear in gears)
            orders = ", ".join(f"{tooth[gear.name]:.6g}" for gear in gears)
            rows.append((shaft, f"{ratio:.6g}", teeth, orders))
        return (("shaft", "speed ratio", "gears (teeth)", "tooth frequency / speed"), *rows)


def _count(key: str, number: int) -> str:
    """Write a number of parts: "2 shafts", "1 mesh"."""
    singular = key.removesuffix("es") if key == "meshes" else key.removesuffix("s")
    return f"{number} {singular if number == 1 else key}"


def _warn(model: Model) -> None:
    """Warn about implausible entries, at the line outside the package that made the system."""
    for message in model.warnings:
        warn(message, SceneWarning)
