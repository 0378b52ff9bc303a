"""The rotor system: checked when it is made, then asked."""

import os
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearbow._checkpoint import Checkpoint
from gearbow._convert import copied, nested, number, shown, text, whole
from gearbow._core import Model
from gearbow._describe import Part, parts, place, tuples
from gearbow._files import replacing
from gearbow._lookup import nearest, require
from gearbow._run import (
    SpeedLike,
    beginning,
    distinct,
    given_speed,
    grid,
    in_order,
    plain_speed,
    reported,
)
from gearbow._types import Array, At, CoreCheckpoint, Dof, Plain, Progress, Record, RunData
from gearbow.accuracy import accuracy_of
from gearbow.balance import balance
from gearbow.campbell import campbell
from gearbow.critical import critical_speed_map
from gearbow.errors import SceneError, SceneWarning
from gearbow.modes import Modes
from gearbow.orders.kinematics import Kinematics
from gearbow.response import Response
from gearbow.results import Matrices, Static
from gearbow.scene import Bearing, Disk, Gear, Mesh, Shaft, Torque
from gearbow.speed import SpeedProfile
from gearbow.synchronous import synchronous
from gearbow.tradeoff.ask import tradeoff

__all__ = ["RotorSystem"]

_PARTS: dict[str, type[Part]] = {
    "shafts": Shaft,
    "gears": Gear,
    "meshes": Mesh,
    "bearings": Bearing,
    "torques": Torque,
    "disks": Disk,
}
#: The options of a system, and how each is converted.
_OPTIONS: dict[str, Callable[[object, str], Plain]] = {
    "reference": text,
    "modal_damping": number,
    "rayleigh": nested,
    "gravity": nested,
    "motion": text,
}


class RotorSystem:
    """Shafts with gears, disks, bearings and torques, as one system of equations of motion.

    Parameters
    ----------
    shafts : sequence of Shaft
        The shafts, parallel to x.
    gears : sequence of Gear
        The gears on them.
    meshes : sequence of Mesh
        The pairs of gears in mesh.
    bearings : sequence of Bearing
        The bearings.
    torques : sequence of Torque
        Torques on the shafts.
    disks : sequence of Disk
        Rigid disks.
    reference : str, optional
        Name of the shaft that a speed speaks of; None is the first.
    modal_damping : float, optional
        Damping ratio of the shafts' motion, the same for every mode.
    rayleigh : tuple of (float, float), optional
        Damping αM + βK of the shafts [1/s, s].
    gravity : float or tuple of (float, float), optional
        Gravity [m/s²], along −z or as (y, z).
    motion : {"lateral", "torsion", "coupled"}, optional
        The degrees of freedom of a node; None is what the scene requires.

    Attributes
    ----------
    shafts, gears, meshes, bearings, torques, disks : tuple
        The parts as they were given.
    reference, modal_damping, rayleigh, gravity, motion
        The options as they were given; None where one was left out.

    Raises
    ------
    SceneError
        If the description is impossible; the text begins with where it is.

    Warns
    -----
    SceneWarning
        If the description looks like a slip.

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1.5e-4)
    >>> system = gb.RotorSystem(
    ...     shafts=[
    ...         gb.Shaft("input", length=0.5, outer_diameter=0.05, elements=8, bow=bow),
    ...         gb.Shaft("output", length=0.5, outer_diameter=0.05, elements=8),
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
    >>> contact_ratio = response.mesh("g1", "g2").contact_ratio
    >>> print(f"{contact_ratio.max() - contact_ratio.min():.2f}")
    0.10
    """

    shafts: tuple[Shaft, ...]
    gears: tuple[Gear, ...]
    meshes: tuple[Mesh, ...]
    bearings: tuple[Bearing, ...]
    torques: tuple[Torque, ...]
    disks: tuple[Disk, ...]
    reference: str | None
    modal_damping: float | None
    rayleigh: tuple[float, float] | None
    gravity: float | tuple[float, float] | None
    motion: str | None

    def __init__(
        self,
        shafts: Sequence[Shaft],
        gears: Sequence[Gear] = (),
        meshes: Sequence[Mesh] = (),
        bearings: Sequence[Bearing] = (),
        torques: Sequence[Torque] = (),
        *,
        disks: Sequence[Disk] = (),
        reference: str | None = None,
        modal_damping: float | None = None,
        rayleigh: tuple[float, float] | None = None,
        gravity: float | tuple[float, float] | None = None,
        motion: str | None = None,
    ) -> None:
        self.shafts = parts(shafts, Shaft, "shafts")
        self.gears = parts(gears, Gear, "gears")
        self.meshes = parts(meshes, Mesh, "meshes")
        self.bearings = parts(bearings, Bearing, "bearings")
        self.torques = parts(torques, Torque, "torques")
        self.disks = parts(disks, Disk, "disks")
        options = {
            "reference": reference,
            "modal_damping": modal_damping,
            "rayleigh": rayleigh,
            "gravity": gravity,
            "motion": motion,
        }
        description: dict[str, Plain] = {
            key: [part._describe(f"{key}[{i}]") for i, part in enumerate(getattr(self, key))]
            for key in _PARTS
        }
        for key, value in options.items():
            converted = None if value is None else _OPTIONS[key](value, key)
            setattr(self, key, tuples(converted))
            if converted is not None:
                description[key] = converted
        self._model = Model(description)
        _warn(self._model)

    @classmethod
    def _from_model(cls, model: Model) -> "RotorSystem":
        """Wrap a checked model; its parts and options come from its description."""
        system = cls.__new__(cls)
        system._model = model
        description = model.description()
        for key, kind in _PARTS.items():
            setattr(
                system,
                key,
                tuple(kind._from_description(part) for part in description.get(key, ())),
            )
        for key in _OPTIONS:
            setattr(system, key, tuples(description.get(key)))
        return system

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "RotorSystem":
        """Make a system that was checked before, without repeating its warnings."""
        return cls._from_model(Model(copied(description, "")))

    @classmethod
    def from_dict(cls, description: Mapping[str, Plain]) -> "RotorSystem":
        """Make a system from plain data, the inverse of `description`.

        Parameters
        ----------
        description : mapping
            The keys are the names of the parameters, as in a TOML file; complex numbers may be
            pairs [re, im].

        Returns
        -------
        RotorSystem
            The system.

        Raises
        ------
        SceneError
            If the description is impossible, or has an unknown key.

        Warns
        -----
        SceneWarning
            If the description looks like a slip.

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

    def replace(self, **changes: Any) -> "RotorSystem":
        """Make a system with other parts or options; all that is not given stays.

        Parameters
        ----------
        **changes
            Parameters of `RotorSystem` by name: lists of parts replace the whole list, None removes
            an option. `dataclasses.replace` changes a single part.

        Returns
        -------
        RotorSystem
            The new system; this one stays as it is.

        Raises
        ------
        SceneError
            If a name is unknown, or the new system is impossible.

        Warns
        -----
        SceneWarning
            If the new system looks like a slip.

        Examples
        --------
        >>> from dataclasses import replace
        >>> import gearbow as gb
        >>> shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4)
        >>> system = gb.RotorSystem(shafts=[shaft], gravity=9.81)
        >>> bent = system.replace(shafts=[replace(shaft, bow=gb.Bow.half_sine(1e-4))])
        >>> bent.shafts[0].bow.amplitude, bent.gravity
        (0.0001, 9.81)
        >>> system.replace(gravity=None).gravity is None
        True
        """
        names = (*_PARTS, *_OPTIONS)
        for key in changes:
            if key not in names:
                raise SceneError(
                    f"replace: {key!r} is no parameter of a system{nearest(key, names)}"
                )
        return RotorSystem(**{**{key: getattr(self, key) for key in names}, **changes})

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "RotorSystem":
        """Read a system from a TOML file.

        Parameters
        ----------
        path : str or path-like
            A file whose keys are the names of the parameters, as `save` writes it.

        Returns
        -------
        RotorSystem
            The system.

        Raises
        ------
        SceneError
            If the description is impossible, or the file is not TOML.
        OSError
            If the file cannot be opened.
        """
        try:
            document = Path(path).read_text(encoding="utf-8")
        except UnicodeDecodeError as error:
            raise SceneError(
                f"toml: {path} is not UTF-8 text (byte {error.object[error.start]:#04x} at "
                f"position {error.start}); save it as UTF-8"
            ) from None
        model = Model.from_toml(document)
        _warn(model)
        return cls._from_model(model)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the description to a TOML file.

        Parameters
        ----------
        path : str or path-like
            The file. A bow given as a function is written as the points at which it was read.

        Raises
        ------
        OSError
            If the file cannot be written; a file that was there is unchanged.
        """
        text = self._model.to_toml()
        with replacing(path) as file:
            file.write(text.encode())

    @property
    def description(self) -> dict[str, Plain]:
        """What was given, as plain data.

        Returns
        -------
        dict
            The keys are the names of the parameters; options that were left out are absent.
        """
        return self._model.description()

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
        tuple of (str, float, str)
            Shaft, position [m] and "v", "w" (translation along y, z), "B", "G" (rotation about y,
            z) or "twist".
        """
        return tuple(self._model.dofs)

    def matrices(self, speed: float = 0.0) -> Matrices:
        """Assemble the matrices of the linear equations of motion.

        Parameters
        ----------
        speed : float
            Speed of the reference shaft [rad/s], whose sign says which flanks press. At speed 0
            these are the flanks that the torques press.

        Returns
        -------
        Matrices
            Mass, stiffness, damping and gyroscopic matrix, each mesh linearised at rest on the
            flank that presses at this speed.

        Raises
        ------
        SceneError
            If the speed is not finite.
        """
        return Matrices(**self._model.matrices(number(speed, "speed")), dofs=self.dofs)

    def modes(self, speed: float = 0.0, count: int | None = None) -> Modes:
        """Find natural frequencies, damping, whirl and shapes at one speed.

        Parameters
        ----------
        speed : float
            Speed of the reference shaft [rad/s].
        count : int, optional
            How many modes; None is all of them.

        Returns
        -------
        Modes
            The modes in ascending order of frequency.

        Raises
        ------
        SceneError
            If the speed or the count is impossible.
        """
        speed = number(speed, "speed")
        data = self._model.modes(speed, None if count is None else whole(count, "count"))
        return Modes(
            frequencies_hz=data["frequencies_hz"],
            damping_ratios=data["damping_ratios"],
            whirl=tuple(data["whirl"]),
            shapes=data["shapes"],
            eigenvalues=data["eigenvalues"],
            speed=speed,
            dofs=self.dofs,
            system=self,
        )

    def static(self, geometry: str = "live", *, speed: float = 0.0) -> Static:
        """Find the equilibrium under torque, gravity and the non-linear meshes.

        Parameters
        ----------
        geometry : {"live", "frozen"}
            Whether the line of action follows the centres or stays that of the centres at rest.
        speed : float
            Speed of the reference shaft [rad/s], whose sign says which flanks drive: a torque may
            then press the back flank, whose force is negative. At speed 0 the drive flanks are
            those that the torques press. No force that depends on the speed acts.

        Returns
        -------
        Static
            Displacements, mesh states and bearing forces.

        Raises
        ------
        SceneError
            If the speed is not finite, or the load has no equilibrium.
        ContactError
            If the base circles of a pair overlap, in live geometry.
        ConvergenceError
            If no equilibrium is found.
        """
        data = self._model.static(text(geometry, "geometry"), number(speed, "speed"))
        return Static(data, self)

    def simulate(
        self,
        duration: float,
        speed: SpeedLike,
        *,
        accuracy: str | None = None,
        method: str | None = None,
        linear: str | None = None,
        step: float | None = None,
        rtol: float | None = None,
        stages: int | None = None,
        modes: int | None = None,
        initial: str | Response | Mapping[str, Any] = "synchronous",
        output_step: float | None = None,
        times: ArrayLike | None = None,
        record: Iterable[Record] = ("gears", "meshes"),
        geometry: str = "live",
        start: float | None = None,
        progress: bool | Progress | None = None,
        checkpoint: str | os.PathLike[str] | None = None,
        every: float = 60.0,
    ) -> Response:
        """Integrate the equations of motion at a constant or a changing speed.

        Parameters
        ----------
        duration : float
            Simulated time [s].
        speed : float, SpeedProfile, callable or (times, speeds)
            Speed Ω of the reference shaft [rad/s]; shaft s stands at angle r_s Ω t, or r_s ∫Ω dt
            from the time 0 on. A function of the time [s] is followed over the run, between points
            the speed is linear. It may begin or end at rest, but not change its sign. What
            accelerates a section of a shaft is taken to act where its inertia is.
        accuracy : {"draft", "engineering", "reference"}, optional
            In place of method, step, rtol, stages and modes: settings whose error was measured. The
            response says what to expect, `Response.expected_error` and `Response.accuracy`.
        method : {"exponential", "rk45", "rk4"}, optional
            Exact where the motion is linear, with Gauss collocation of the mesh forces, the
            default at constant speed; Dormand–Prince 5(4) with error control, the default where the
            speed changes; or the classical method with fixed steps.
        linear : {"integrated", "exact"}, optional
            How "rk4" treats everything but the meshes: like the rest, or exactly, by the modes
            (ETDRK4, Cox and Matthews 2002), which frees its step from the shortest element.
        step : float, optional
            Fixed step [s] of "rk4", where None is one that resolves the fastest motion, or of
            "exponential", where None is what `rtol` allows.
        rtol : float, optional
            Error of a step of "exponential" and "rk45", relative to the motion in the energy norm;
            None is 1e-6. It cannot be given with a fixed step.
        stages : int, optional
            Gauss nodes in a step of "exponential", 1 to 4: its order is twice that. None is 3.
        modes : int, optional
            How many modes "exponential" keeps, those that the loads of the scene move most; None is
            all.
        initial : {"synchronous", "static", "rest"} or Response
            Where it starts: static equilibrium plus linear synchronous response, static equilibrium
            alone, or q = q̇ = 0. Errors and run-out of the teeth are part of neither equilibrium.
            A response (or its `final`) is continued from where it ended, at the same speed to the
            last bit; at another one displacements, velocities and the angles of the shafts go on.
        output_step : float, optional
            Spacing of the recorded times [s], from the start to the end. None is fine enough for
            the fastest shaft.
        times : array_like, shape (k,), optional
            Absolute times to record [s] instead, in any order and off any grid.
        record : sequence of str or tuple
            What to record: names of gears, disks or shafts (all their nodes), (shaft, position),
            (driver, driven), ("bearing", shaft, position), and the groups "gears", "disks",
            "meshes", "bearings", "nodes", "energy".
        geometry : {"live", "frozen"}
            "live": the line of action and the engagement of the teeth follow the centres; "frozen":
            they stay those of the centres at rest.
        start : float, optional
            Time at the start [s]; 0 by default.
        progress : bool or callable, optional
            True shows a bar; a callable is given the fraction that is done.
        checkpoint : str or path-like, optional
            A ``.npz`` or ``.nc`` file that the run is kept in while it goes on, what was recorded
            so far included. The same call goes on from there to the same bits as a run that
            nothing stopped; at the end the file is the response, and the same call reads it.
            Only one run at a time can use a file.
        every : float, optional
            Wall-clock time between two writings of that file [s]. It is replaced as a whole.

        Returns
        -------
        Response
            The motion at the recorded times.

        Raises
        ------
        SceneError
            If an argument is impossible, or the checkpoint is of another run or in use by another
            run.
        MissingExtraError
            If the checkpoint is a ``.nc`` file and the extra "netcdf" is not installed.
        StabilityError
            If the step is above the limit of stability, or the run diverged.
        ContactError
            If the base circles of a pair overlap.
        KeyboardInterrupt
            At Ctrl-C. This and every other error that ends a run has `.response`: what was
            computed, or None before the first step.

        Warns
        -----
        CheckpointWarning
            If the checkpoint cannot be written, for example on a full disk; the run goes on and
            the file stays as it was.

        Examples
        --------
        A shaft that is let go from rest in the plane of its bow, recorded in the middle:

        >>> import gearbow as gb
        >>> bow = gb.Bow.half_sine(1e-4)
        >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4, bow=bow)
        >>> bearings = [gb.Bearing("rotor", x, stiffness=1e9) for x in (0.0, 1.0)]
        >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
        >>> middle = ("rotor", 0.5)
        >>> options = {"initial": "rest", "record": [middle, "energy"], "rtol": 1e-8}
        >>> response = system.simulate(0.01, speed=0.0, **options)
        >>> print(f"{1e6 * response.displacement(middle)[:, 0].max():.0f} µm")
        200 µm
        """
        duration = number(duration, "duration")
        if method is not None:
            method = text(method, "method")
        if linear is not None:
            linear = text(linear, "linear")
        state, begin = beginning(initial.final if isinstance(initial, Response) else initial, start)
        speed = given_speed(speed, begin, duration)
        expected = None
        if accuracy is not None:
            given = {"method": method, "linear": linear, "step": step, "rtol": rtol}
            given |= {"stages": stages, "modes": modes}
            expected = accuracy_of(accuracy, given, constant=isinstance(speed, float))
            method, rtol = expected.method, expected.rtol
        if method is None:
            method = "exponential" if isinstance(speed, float) else "rk45"
        if times is None:
            if output_step is None:
                output_step = self._model.default_output_step(duration, plain_speed(speed), begin)
            wanted, rows = grid(begin, duration, number(output_step, "output_step")), None
        elif output_step is None:
            wanted, rows = distinct(times)
        else:
            raise SceneError("times: cannot be given together with output_step")

        asked: dict[str, Any] = {
            "duration": duration,
            "speed": plain_speed(speed),
            "method": method,
            "linear": linear,
            "step": None if step is None else number(step, "step"),
            "rtol": None if rtol is None else number(rtol, "rtol"),
            "stages": None if stages is None else whole(stages, "stages"),
            "modes": None if modes is None else whole(modes, "modes"),
            "initial": state,
            "record": _requests(record),
            "geometry": text(geometry, "geometry"),
            "start": begin,
        }

        scene, rest = self.description, {"times": wanted, "rows": rows, "accuracy": accuracy}
        with (
            nullcontext()
            if checkpoint is None
            else Checkpoint(checkpoint, every, {"scene": scene, **asked, **rest})
        ) as file:
            if file is not None and file.complete is not None:
                return file.complete
            response = self._run(asked, speed, (wanted, rows), progress, file)
            if expected is not None:
                expected.explain(response)
            if file is not None:
                file.finish(response)
        return response

    def _run(
        self,
        asked: dict[str, Any],
        speed: float | SpeedProfile,
        times: tuple[Array, NDArray[np.intp] | None],
        progress: bool | Progress | None,
        file: Checkpoint | None,
    ) -> Response:
        """Run in one go, or by the file; what ends the run early carries what there is."""
        wanted, rows = times

        def core(
            left: Array, checkpoint: CoreCheckpoint | None, report: Progress | None
        ) -> RunData:
            return self._model.simulate(**asked, times=left, checkpoint=checkpoint, progress=report)

        try:
            with reported(progress, asked["duration"]) as report:
                if file is None:
                    data = core(wanted, None, report)
                else:
                    data = file.run(core, wanted, speed, report)
        except BaseException as error:
            partial: RunData | None = getattr(error, "partial", None)
            if partial is not None:
                error.response = self._response(partial, rows, speed)  # type: ignore[attr-defined]
                del error.partial  # type: ignore[attr-defined]
            elif not hasattr(error, "response"):
                error.response = None  # type: ignore[attr-defined]  # it ended before the first step
            raise
        return self._response(data, rows, speed)

    tradeoff = tradeoff
    campbell = campbell
    critical_speed_map = critical_speed_map
    synchronous = synchronous
    balance = balance

    def _response(
        self, data: RunData, rows: NDArray[np.intp] | None, speed: float | SpeedProfile
    ) -> Response:
        response = Response(in_order(data, rows), speed)
        response.kinematics = Kinematics.of(self)
        return response

    def _lateral(self, name: At) -> list[int]:
        """Give the indices of v and w somewhere."""
        v, w, _ = self._model.indices(place(name))
        return [require(v, name, "lateral motion"), require(w, name, "lateral motion")]

    def _twist(self, name: At) -> int:
        """Give the index of the twist somewhere."""
        return require(self._model.indices(place(name))[2], name, "twist")

    def __reduce__(
        self,
    ) -> tuple[Callable[[dict[str, Plain]], "RotorSystem"], tuple[dict[str, Plain]]]:
        return RotorSystem._from_description, (self.description,)

    def __repr__(self) -> str:
        counts = [f"{len(getattr(self, key))} {key}" for key in _PARTS if getattr(self, key)]
        return f"RotorSystem({', '.join(counts)}; {len(self._model.dofs)} degrees of freedom)"


def _requests(record: object) -> list[Any]:
    """Convert what to record to names and tuples of names and positions."""
    if isinstance(record, str):
        return [record]
    if not isinstance(record, Iterable):
        raise SceneError(f"record: must be a list of names or tuples, got {shown(record)}")
    return [place(entry, f"record[{i}]") for i, entry in enumerate(record)]


def _warn(model: Model) -> None:
    """Warn of what looks like a slip, at the line outside the package that made the system."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__") == __name__:
        level, frame = level + 1, frame.f_back
    for message in model.warnings:
        warnings.warn(message, SceneWarning, stacklevel=level)
