"""Functional mock-up units (FMI 3.0, co-simulation) that step a system with gearbow.

pythonfmu3 gives the library with the C interface, which loads Python and a class of this module.
"""

import json
import math
import pickle
import re
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numpy as np

from gearbow._core import __version__
from gearbow._extras import extra
from gearbow._files import replacing
from gearbow.errors import GearbowError, SceneError
from gearbow.system.cosimulation import CoSimulation, Instant, Interface, Knots

if TYPE_CHECKING:
    from gearbow.analysis.protocol import System

#: File beside the script of the unit: version of gearbow; the system, its inputs and outputs.
_CONTENTS = "train.pickle"
#: The script of the unit. The library finds its class by the word Fmi3Slave.
_SCRIPT = """from gearbow.exchange.fmu import Train
from pythonfmu3 import Fmi3Slave


class {name}(Train, Fmi3Slave):
    pass
"""
#: Difference of the times of the two programs, relative to a step, below which they are one time.
_SAME_TIME = 1e-6
#: Units of inputs and outputs as exponents of the base units of FMI.
_UNITS: dict[str, dict[str, int]] = {
    "1": {},
    "m": {"m": 1},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "m/s": {"m": 1, "s": -1},
    "m/s²": {"m": 1, "s": -2},
    "rad/s²": {"rad": 1, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N m": {"kg": 1, "m": 2, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "N/m": {"kg": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
}


def write_fmu(system: "System", face: Interface, path: Path) -> None:
    """Write a unit. Its beginning is run once, which checks inputs, outputs and options."""
    with extra("fmi"):
        from pythonfmu3 import FmuBuilder  # noqa: PLC0415

    trial = CoSimulation(system, face)
    trial.begin(0.0)
    outputs = [(column.name, column.unit) for column in trial.columns]
    contents = (pickle.dumps(system), face, outputs)
    name = re.sub(r"\W", "_", path.stem, flags=re.ASCII)
    name = name if name[:1].isalpha() else f"train_{name}"
    with replacing(path) as file, tempfile.TemporaryDirectory() as folder:
        # Python has one module of a name, but may load several units.
        script = Path(folder, f"train_{uuid4().hex}.py")
        script.write_text(_SCRIPT.format(name=name), encoding="utf-8")
        packed = Path(folder, _CONTENTS)
        packed.write_bytes(pickle.dumps(__version__) + pickle.dumps(contents))
        made = FmuBuilder.build_FMU(
            script,
            dest=folder,
            project_files=[packed],
            canGetAndSetFMUState=True,
            canSerializeFMUState=True,
        )
        file.write(Path(made).read_bytes())


def names_of(labels: Sequence[str]) -> list[str]:
    """Give names of FMI: letters, digits and underscores, each name once."""
    found: list[str] = []
    for label in labels:
        plain = re.sub(r"\W+", "_", label, flags=re.ASCII).strip("_") or "signal"
        plain = plain if not plain[0].isdigit() else f"_{plain}"
        same, number = plain, 2
        while same in found:
            same, number = f"{plain}_{number}", number + 1
        found.append(same)
    return found


class Train:
    """A system in a functional mock-up unit; the other base of its class is ``Fmi3Slave``."""

    # The library calls the methods by the names that pythonfmu3 gives them, and passes the folder
    # of the files of the unit.

    if TYPE_CHECKING:  # of Fmi3Slave
        log: Any
        register_units: Any
        register_variable: Any

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        with Path(given["resources"], _CONTENTS).open("rb") as file:
            version = pickle.load(file)
            if version != __version__:
                raise SceneError(
                    f"this unit was written by gearbow {version}, and gearbow {__version__} is "
                    f"installed: pip install gearbow=={version}, or write it again"
                )
            self._system, self._face, self._outputs = pickle.load(file)
        self.author = f"gearbow {version}"
        self.description = "Geared shaft train; inputs are reached at the end of a step"
        self._start = 0.0
        self._inputs: dict[str, float] = dict(self._face.inputs)
        self._stepped: CoSimulation | None = None
        self._register()

    def _register(self) -> None:
        """Declare the variables of the unit."""
        from pythonfmu3 import Float64, Fmi3Causality, Fmi3Initial, Fmi3Variability, Unit  # noqa: PLC0415  # every unit contains it

        inputs = {label: "rad/s" if label == "speed" else "N m" for label in self._inputs}
        known = {*inputs.values(), *(unit for _, unit in self._outputs)} & _UNITS.keys()
        self.register_units([Unit(unit, **_UNITS[unit]) for unit in sorted(known)])
        self.register_variable(
            Float64("time", causality=Fmi3Causality.independent, getter=lambda: self._time)
        )
        labels = [*inputs, *(label for label, _ in self._outputs)]
        names = dict(enumerate(names_of(labels)))
        continuous = {"variability": Fmi3Variability.continuous}
        for i, (label, unit) in enumerate(inputs.items()):
            self.register_variable(
                Float64(
                    names[i],
                    unit=unit,
                    description=label,
                    causality=Fmi3Causality.input,
                    getter=partial(self._inputs.__getitem__, label),
                    setter=partial(self._inputs.__setitem__, label),
                    **continuous,
                )
            )
        for i, (label, unit) in enumerate(self._outputs):
            self.register_variable(
                Float64(
                    names[len(inputs) + i],
                    unit=unit if unit in known else None,
                    description=label if unit in known else f"{label} [{unit}]",
                    causality=Fmi3Causality.output,
                    initial=Fmi3Initial.calculated,
                    getter=partial(self._output, i),
                    **continuous,
                )
            )

    @property
    def _time(self) -> float:
        return self._start if self._stepped is None else self._stepped.now.time

    def _output(self, index: int) -> float:
        return math.nan if self._stepped is None else self._stepped.now.outputs[index]

    def setup_experiment(self, start_time: float) -> None:
        """Take the time of the beginning [s]."""
        self._start = start_time

    def exit_initialization_mode(self) -> None:
        """Compute the state at the beginning."""
        stepped = CoSimulation(pickle.loads(self._system), self._face)
        stepped.begin(self._start, self._inputs)
        self._stepped = stepped

    def do_step(self, current_time: float, step_size: float) -> Any:
        """Continue the run by a step [s]; a failure is logged and leaves the state as it was."""
        from pythonfmu3 import Fmi3Status, Fmi3StepResult  # noqa: PLC0415

        try:
            if self._stepped is None:
                raise SceneError("the unit was not initialised")
            if abs(current_time - self._time) > _SAME_TIME * abs(step_size):
                raise SceneError(
                    f"the unit is at {self._time!r} s and cannot step from {current_time!r} s; an "
                    "earlier state is restored by fmi3SetFMUState"
                )
            self._stepped.set(self._inputs)
            self._stepped.step(step_size)
        except GearbowError as error:
            self.log(str(error), Fmi3Status.error)
            return Fmi3StepResult(status=Fmi3Status.error)
        return Fmi3StepResult(status=Fmi3Status.ok)

    def _get_fmu_state(self) -> dict[str, Any]:
        now = None if self._stepped is None else self._stepped.now
        return {"start": self._start, "inputs": dict(self._inputs), "now": now}

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self._start = state["start"]
        self._inputs.update(state["inputs"])
        if state["now"] is None:
            self._stepped = None
            return
        if self._stepped is None:
            self._stepped = CoSimulation(pickle.loads(self._system), self._face)
        self._stepped.now = state["now"]

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        now = state["now"]
        plain = {**state, "now": None if now is None else asdict(now)}
        return json.dumps(plain, default=_plain).encode()

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        plain: dict[str, Any] = json.loads(state, object_hook=_array)
        now = plain["now"]
        if now is not None:
            knots = {key: Knots(**now[key]) for key in ("torque_knots", "speed_knots")}
            plain["now"] = Instant(**{**now, **knots})
        return plain


def _plain(value: Any) -> Any:
    """Convert an array for JSON, which keeps every bit of a finite number."""
    return {"dtype": value.dtype.str, "values": value.tolist()}


def _array(entries: dict[str, Any]) -> Any:
    """Read an array of `_plain`."""
    if entries.keys() == {"dtype", "values"}:
        return np.array(entries["values"], dtype=entries["dtype"])
    return entries
