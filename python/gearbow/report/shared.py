"""What the sections of a report share: options, and results that are computed once."""

import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import matplotlib as mpl
import numpy as np

from gearbow._types import Array
from gearbow.analysis.bow_motion import with_elements_for
from gearbow.description.bow import Bow, amplitude_of, scaled
from gearbow.description.bow_limit import BowLimit
from gearbow.description.rolling import RollingBearing
from gearbow.errors import ConvergenceError, GearbowError, StabilityError
from gearbow.report.page import Block, Note, Section
from gearbow.results.campbell import Campbell
from gearbow.results.modes import Modes
from gearbow.results.response import Response
from gearbow.results.static import Static
from gearbow.results.steady import SteadyState
from gearbow.results.synchronous import Synchronous
from gearbow.units.speed import SpeedUnit, speed_text

#: Largest number of speeds of a Campbell diagram, whose curves are smooth between them.
_DIAGRAM_SPEEDS = 25
#: Revolutions of the slowest shaft of a run in place of a steady state, and of its figures.
_REVOLUTIONS, SHOWN_REVOLUTIONS = 20.0, 1.0
#: Damping ratio below which a mode has none but round-off.
_NO_DAMPING = 1e-9
#: Lines of many points keep those that are half a point of the page away from the others.
_DENSE: Any = {"path.simplify_threshold": 0.5}


@dataclass(frozen=True)
class Options:
    """Heading, operating speeds, speeds of diagrams [rad/s], number of modes, limits of bows."""

    title: str
    operating: tuple[float, float] | None
    speeds: Array | None
    modes: int
    limits: tuple[BowLimit, ...]
    unit: SpeedUnit


@dataclass
class Contents:
    """The results that sections share; each is computed once, also if it fails."""

    system: Any
    options: Options
    #: Sentences of the summary; True for one that asks for attention.
    findings: list[tuple[str, bool]] = field(default_factory=list)
    #: Section and text of each warning.
    warned: list[tuple[str, str]] = field(default_factory=list)
    _kept: dict[str, Any] = field(default_factory=dict)

    def kept(self, name: str, compute: Callable[[], Any]) -> Any:
        """Give a result, or raise the error of the first attempt."""
        if name not in self._kept:
            try:
                self._kept[name] = compute()
            except Exception as error:  # noqa: BLE001  # sections that share it say so
                self._kept[name] = error
        if isinstance(self._kept[name], Exception):
            raise self._kept[name]
        return self._kept[name]

    def finished(self, name: str) -> Any:
        """Give a result that was computed; None for another one."""
        found = self._kept.get(name)
        return None if isinstance(found, Exception) else found

    @cached_property
    def speed(self) -> float:
        """Highest operating speed, or standstill [rad/s]."""
        return 0.0 if self.options.operating is None else self.options.operating[1]

    @cached_property
    def meshed(self) -> Any:
        """The system with numbers of elements, which its variants keep."""
        return type(self.system)._from_description(self.system._model.resolved())

    @property
    def with_bows(self) -> Any:
        """The system with elements for a bow of each shaft, chosen once for all their limits."""
        return self.kept("with bows", self._with_bows)

    def _with_bows(self) -> Any:
        bows = {}
        for shaft in self.system.shafts:
            size = amplitude_of(shaft.bow)
            # Bows of equal size: the elements must not follow the largest of the present bows.
            own = scaled(shaft.bow, 1.0 / size) if size else None
            bows[shaft.name] = own or Bow.half_sine(1.0)
        return with_elements_for(self.system, bows)

    def turn(self) -> float:
        """Duration of a revolution of the slowest shaft at the highest operating speed [s]."""
        return 2.0 * math.pi / float(np.abs(self.system.speed_ratios * self.need_operating()).min())

    def need_operating(self) -> float:
        """Give the highest operating speed, which must be given."""
        if self.options.operating is None:
            raise GearbowError("no operating speed was given (operating=, or --speed)")
        return self.speed

    def text(self, speed: float) -> str:
        """Write a speed in the unit of the report."""
        return speed_text(speed, self.options.unit)

    @property
    def static(self) -> Static:
        """Static equilibrium at the highest operating speed."""
        return self.kept("static", lambda: self.system.static(self.speed))  # type: ignore[no-any-return]

    @property
    def modes(self) -> Modes:
        """Modes at the highest operating speed: as many oscillations as wanted."""
        return self.kept("modes", self._modes)  # type: ignore[no-any-return]

    def _modes(self) -> Modes:
        wanted, count = self.options.modes, self.options.modes
        while True:
            found: Modes = self.system.modes(self.speed, count=count)
            oscillating = len(found._vibrations())
            if oscillating >= wanted or len(found.whirl) < count:
                return found
            # Overdamped modes may be most of the modes.
            count *= 2

    @property
    def campbell(self) -> Campbell:
        """Campbell diagram."""
        return self.kept("campbell", self._campbell)  # type: ignore[no-any-return]

    def _campbell(self) -> Campbell:
        speeds = np.sort(np.abs(self._speeds()))
        if speeds.size > _DIAGRAM_SPEEDS:
            speeds = speeds[np.linspace(0, speeds.size - 1, _DIAGRAM_SPEEDS).round().astype(int)]
        # The rigid-body rotation does not count there.
        rigid = sum(whirl == "rigid" for whirl in self.modes.whirl)
        return self.system.campbell(speeds, count=len(self.modes.whirl) - rigid)  # type: ignore[no-any-return]

    @property
    def synchronous(self) -> Synchronous:
        """Response to bow and unbalance."""
        return self.kept("synchronous", lambda: self.response_of(self.system))  # type: ignore[no-any-return]

    def response_of(self, system: Any) -> Synchronous:
        """Find the response of a system at the speeds of the report."""
        return system.synchronous(self._speeds())  # type: ignore[no-any-return]

    def _speeds(self) -> Array:
        if self.options.speeds is None:
            raise GearbowError("no speeds were given (speeds=, or --to)")
        return self.options.speeds

    @property
    def motion(self) -> tuple[Response, str, SteadyState | None]:
        """Motion at the highest operating speed, what it is, and the steady state."""
        return self.kept("motion", self._motion)  # type: ignore[no-any-return]

    def _motion(self) -> tuple[Response, str, SteadyState | None]:
        speed = self.need_operating()
        record = ["gears", "disks", "meshes", "bearings"]
        least = np.min(
            self.modes.damping_ratios, where=self.modes.frequencies_hz > 0.0, initial=1.0
        )
        rolling = any(isinstance(each, RollingBearing) for each in self.system.bearings)
        if rolling and least < _NO_DAMPING:
            # Rolling elements excite without end, and without damping nothing settles.
            run: Response
            turns = self._tooth_turns()
            run = self.system.simulate(turns * 2.0 * math.pi / abs(speed), speed, record=record)
            what = (
                f"a run over {360.0 * turns:.0f}° of the reference shaft, as a mode has no "
                "damping, so that nothing settles; give bearings and meshes damping"
            )
            return run, what, None
        try:
            steady = self.system.steady_state(speed, record=record)
        except (ConvergenceError, StabilityError) as error:
            run = self.system.simulate(_REVOLUTIONS * self.turn(), speed, record=record)
            what = f"a run of {_REVOLUTIONS:g} revolutions of the slowest shaft, because {error}"
            return run, what, None
        period = (
            "without a common period" if math.isinf(steady.period) else f"{steady.period:.4g} s"
        )
        what = f"the steady state, {steady.method}, period {period}, residual {steady.residual:.1e}"
        return steady.response, what, steady

    def _tooth_turns(self) -> float:
        """Give a revolution of the reference shaft, or those in which each mesh has a tooth."""
        names = [shaft.name for shaft in self.system.shafts]
        ratios = dict(zip(names, np.abs(self.system.speed_ratios), strict=True))
        orders = [ratios[gear.shaft] * gear.teeth for gear in self.system.gears]
        return max(1.0, 1.0 / min(orders, default=1.0))

    def section(self, name: str, title: str, make: "Make") -> Section:
        """Make a section, with a sentence in place of what cannot be computed."""
        section = Section(name, title)
        with warnings.catch_warnings(record=True) as caught, mpl.rc_context(_DENSE):
            warnings.simplefilter("always")
            try:
                for block in make(self):
                    section.blocks.append(block)
            except Exception as error:  # noqa: BLE001  # the other sections are of use
                reason = reason_of(error).rstrip(".")
                section.blocks.append(Note(f"Not computed: {reason}."))
                self.findings.append((f"{title}: not complete, because {reason}.", True))
        for text in dict.fromkeys(str(one.message) for one in caught):
            self.warned.append((title, text))
            section.blocks.append(Note(f"Warning: {text}", warning=True))
        return section


def reason_of(error: Exception) -> str:
    """Give the text of an error; one that is not of gearbow has its type."""
    known = isinstance(error, GearbowError)
    return str(error) if known else f"an unexpected {type(error).__name__}: {error}"


Make = Callable[[Contents], Iterator[Block]]
