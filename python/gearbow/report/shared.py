"""What the sections of a report share: options, and results that are computed once."""

import math
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

from gearbow._result import Column
from gearbow._types import Array, Language
from gearbow.analysis.bow_motion import with_elements_for
from gearbow.description.bow import Bow, BowLimit, amplitude_of, scaled
from gearbow.description.layout import ratios_by_shaft, tooth_orders
from gearbow.description.places import Support, housing_and_interface, other_shaft
from gearbow.description.rolling import RollingBearing
from gearbow.description.speed import SpeedTable
from gearbow.errors import ConvergenceError, GearbowError, StabilityError
from gearbow.report.page import Block, Section, note, say, word
from gearbow.results.campbell import Campbell, Intersection
from gearbow.results.modes import Modes
from gearbow.results.peak import Peak
from gearbow.results.response import Response
from gearbow.results.static import Static
from gearbow.results.steady import SteadyState
from gearbow.results.synchronous import Synchronous
from gearbow.units.speed import SpeedUnit, speed_text

#: Largest number of speeds of a Campbell diagram, whose curves are smooth between them.
_DIAGRAM_SPEEDS = 25
#: Revolutions of the slowest shaft of a run in place of a steady state, and of its figures.
_REVOLUTIONS, SHOWN_REVOLUTIONS = 20.0, 1.0
#: Largest number of modes that are compared with tooth frequencies.
_MOST_MODES = 64
#: Where peaks may need a margin by API RP 684: 17 % below the operating speeds, 27 % above them.
BELOW, ABOVE = 0.83, 1.27
#: Folder of the library that draws, whose warnings concern figures and no result.
_DRAWING = str(Path(mpl.__file__).parent)
#: Damping ratio, without its sign, of a mode that neither grows nor decays: its resonance has no
#: finite amplitude.
UNDAMPED = 1e-6
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
    #: Endurance limit and tensile strength of the shafts [Pa], for all or by name.
    endurance_limit: float | Mapping[str, float] | None = None
    tensile_strength: float | Mapping[str, float] | None = None
    language: Language = "en"
    #: Name and text of what the document is: company, author, number, date.
    imprint: tuple[tuple[str, str], ...] = ()


@dataclass
class Contents:
    """The results that sections share; each is computed once, also if it fails."""

    system: Any
    options: Options
    #: Section and block of what the summary contains.
    findings: list[tuple[str, Block]] = field(default_factory=list)
    #: Section and text of each warning.
    warned: list[tuple[str, str]] = field(default_factory=list)
    _kept: dict[str, Any] = field(default_factory=dict)
    _section: str = ""

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

    def find(self, what: str | Block, /, *, warning: bool = False, **values: Any) -> Block:
        """Add a sentence with values or a block to the summary, and return the block."""
        block = note(what, warning=warning, **values) if isinstance(what, str) else what
        self.findings.append((self._section, block))
        return block

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
        ratios = np.abs(self.system.speed_ratios)
        return 2.0 * math.pi / float(ratios[ratios > 0.0].min() * abs(self.need_operating()))

    @cached_property
    def sensors(self) -> list[str]:
        """Names of the places that stand for sensors of the housings."""
        # Points of a rigid housing, or its name; interfaces of an elastic one without bearing and
        # spring, or all of them.
        bases: list[Any] = [bearing.support for bearing in self.system.bearings]
        bases += [
            base.support for base in (*bases, *self.system.supports) if isinstance(base, Support)
        ]
        carrying = {housing_and_interface(base) for base in bases}
        names: list[str] = []
        for housing in self.system.housings:
            if housing.elastic is None:
                names += list(housing.points) or [housing.name]
                continue
            interfaces = housing.elastic.interfaces
            names += [
                name
                for name, given in interfaces.items()
                if (housing.name, name) not in carrying and "stiffness" not in given
            ] or list(interfaces)
        return names

    def need_operating(self) -> float:
        """Give the highest operating speed, which must be given."""
        if self.options.operating is None:
            raise GearbowError(say("no operating speed was given (operating=, or --speed)"))
        return self.speed

    def text(self, speed: float) -> str:
        """Write a speed in the unit of the report."""
        return speed_text(speed, self.options.unit)

    @property
    def where(self) -> str:
        """The highest operating speed in a title or sentence."""
        if not self.speed:
            return say("at standstill")
        return say("at {speed}", speed=self.text(self.speed))

    @property
    def static(self) -> Static:
        """Static equilibrium at the highest operating speed."""
        return self.kept("static", lambda: self.system.static(self.speed))  # type: ignore[no-any-return]

    @property
    def modes(self) -> Modes:
        """Modes at the highest operating speed: as wanted, and those that teeth can excite."""
        return self.kept("modes", self._modes)  # type: ignore[no-any-return]

    def _modes(self) -> Modes:
        wanted, count = self.options.modes, self.options.modes
        while True:
            found: Modes = self.system.modes(self.speed, count=count)
            oscillating = len(found._vibrations())
            enough = oscillating >= wanted
            if count < _MOST_MODES and found.frequencies_hz.max(initial=0.0) < self.excited:
                enough = False
            if enough or len(found.whirl) < count:
                return found
            # Overdamped modes may be most of the modes.
            count *= 2

    @property
    def campbell(self) -> Campbell:
        """Campbell diagram."""
        return self.kept("campbell", self._campbell)  # type: ignore[no-any-return]

    def _campbell(self) -> Campbell:
        given = self._speeds()
        sense = np.sign(self.speed) or np.sign(given[np.abs(given).argmax()]) or 1.0
        sizes = np.unique(np.abs(given))
        if sizes.size > _DIAGRAM_SPEEDS:
            sizes = sizes[np.linspace(0, sizes.size - 1, _DIAGRAM_SPEEDS).round().astype(int)]
        if sizes[0] < sense * self.speed < sizes[-1]:
            # There the modes have the numbers of the other sections.
            sizes = np.union1d(sizes, [abs(self.speed)])
        speeds = (sense * sizes).view(type(given))
        # The modes that were asked for, without rigid-body motions, which do not count there.
        last = self.modes._vibrations()[: self.options.modes][-1:]
        rigid = sum(whirl == "rigid" for whirl in self.modes.whirl)
        return self.system.campbell(speeds, count=max([i + 1 - rigid for i in last], default=1))  # type: ignore[no-any-return]

    @property
    def near(self) -> Campbell:
        """Intersections of all modes within the largest margins about the operating speeds."""
        return self.kept("near", self._near)  # type: ignore[no-any-return]

    def _near(self) -> Campbell:
        self.need_operating()
        assert self.options.operating is not None
        ends = tuple(map(abs, self.options.operating))
        wanted = np.array([BELOW * ends[0], *ends, ABOVE * ends[1]])
        low, high = table_range(self.system)
        speeds = np.copysign(np.unique(np.clip(wanted, low, high)), self.speed)
        rigid = sum(whirl == "rigid" for whirl in self.modes.whirl)
        return self.system.campbell(speeds, count=max(1, len(self.modes.whirl) - rigid))  # type: ignore[no-any-return]

    @cached_property
    def excited(self) -> float:
        """Highest tooth frequency at the operating speed with the largest margin [Hz]."""
        orders = tooth_orders(self.system).values()
        # A resonance above the operating speed has a mode above the tooth frequency.
        return ABOVE * max(orders, default=0.0) * abs(self.speed) / (2.0 * math.pi)

    def numbers(self, diagram: Campbell) -> list[int]:
        """Give the numbers that the modes of a diagram have at the operating speed, from 1."""
        at = int(np.abs(diagram.speeds - self.speed).argmin())
        own, others = self.modes.eigenvalues, diagram.eigenvalues[at]
        distances = np.abs(others[:, np.newaxis] - own)
        found: dict[int, int] = {}
        for pair in np.argsort(distances, axis=None, kind="stable").tolist():
            mode, number = divmod(pair, len(own))
            if mode not in found and number + 1 not in found.values():
                found[mode] = number + 1
        more = iter(range(len(own) + 1, len(own) + len(others) + 1))
        return [found.get(mode) or next(more) for mode in range(len(others))]

    @property
    def synchronous(self) -> Synchronous:
        """Response to bow and unbalance."""
        return self.kept("synchronous", lambda: self.response_of(self.system))  # type: ignore[no-any-return]

    def response_of(self, system: Any) -> Synchronous:
        """Find the response of a system at the speeds of the report."""
        return system.synchronous(self._speeds())  # type: ignore[no-any-return]

    def _speeds(self) -> Array:
        if self.options.speeds is None:
            raise GearbowError(say("no speeds were given (speeds=, or --to)"))
        return self.options.speeds

    @property
    def motion(self) -> tuple[Response, str, SteadyState | None]:
        """Motion at the highest operating speed, what it is, and the steady state."""
        return self.kept("motion", self._motion)  # type: ignore[no-any-return]

    def _motion(self) -> tuple[Response, str, SteadyState | None]:
        speed = self.need_operating()
        record = ["gears", "disks", "meshes", "bearings", *self.sensors, "acceleration"]
        least = np.min(
            self.modes.damping_ratios, where=self.modes.frequencies_hz > 0.0, initial=1.0
        )
        rolling = any(isinstance(each, RollingBearing) for each in self.system.bearings)
        if rolling and least < _NO_DAMPING:
            # Rolling elements excite without end, and without damping nothing settles.
            run: Response
            turns = self._tooth_turns()
            run = self.system.simulate(turns * 2.0 * math.pi / abs(speed), speed, record=record)
            what = say(
                "a run over {angle}° of the reference shaft, as a mode has no damping, so that "
                "nothing settles; give bearings and meshes damping",
                angle=f"{360.0 * turns:.0f}",
            )
            return run, what, None
        try:
            steady = self.system.steady_state(speed, record=record)
        except (ConvergenceError, StabilityError) as error:
            run = self.system.simulate(_REVOLUTIONS * self.turn(), speed, record=record)
            what = say(
                "a run of {count} revolutions of the slowest shaft, because {reason}",
                count=f"{_REVOLUTIONS:g}",
                reason=error,
            )
            return run, what, None
        what = say(
            "the steady state, {method}, period {period}, residual {residual}",
            method=word(steady.method),
            period=say("none in common") if math.isinf(steady.period) else f"{steady.period:.4g} s",
            residual=f"{steady.residual:.1e}",
        )
        return steady.response, what, steady

    def _tooth_turns(self) -> float:
        """Give a revolution of the reference shaft, or those in which each mesh has a tooth."""
        orders = tooth_orders(self.system).values()
        return max(1.0, 1.0 / min(orders, default=1.0))

    def section(self, name: str, title: str, make: "Make") -> Section:
        """Make a section, with a sentence in place of what cannot be computed."""
        section, self._section = Section(name, title), name
        with warnings.catch_warnings(record=True) as caught, mpl.rc_context(_DENSE):
            warnings.simplefilter("always")
            try:
                for block in make(self):
                    section.blocks.append(block)
            except Exception as error:  # noqa: BLE001  # the other sections are of use
                reason = reason_of(error).rstrip(".")
                section.blocks.append(note("Not computed: {reason}.", reason=reason))
                self.find(
                    "{title}: not complete, because {reason}.",
                    warning=True,
                    title=title,
                    reason=reason,
                )
        own = [one for one in caught if not one.filename.startswith(_DRAWING)]
        for text in dict.fromkeys(str(one.message) for one in own):
            self.warned.append((title, text))
            section.blocks.append(note("Warning: {text}", warning=True, text=text))
        return section


def resonances_of(found: Iterable[Intersection], span: tuple[float, float] | None) -> list[Peak]:
    """Give the resonances at intersections of modes with lines of excitation."""
    # The half-power points of a mode of damping ratio ζ are at N (1 ± ζ).
    return [
        Peak(
            one.speed,
            math.nan,
            one.speed * (1.0 - one.damping_ratio),
            one.speed * (1.0 + one.damping_ratio),
            span,
            one.damping_ratio > -UNDAMPED,
        )
        for one in found
    ]


def margins(peaks: list[Peak]) -> list[Column]:
    """Give the columns of API RP 684."""
    return [
        Column("amplification factor", [peak.amplification_factor for peak in peaks]),
        Column("margin", [peak.separation_margin for peak in peaks], "%"),
        Column("required margin", [peak.required_margin for peak in peaks], "%"),
        Column("verdict", [peak.verdict for peak in peaks]),
    ]


def reason_of(error: Exception) -> str:
    """Give the text of an error; one that is not of gearbow has its type."""
    known = isinstance(error, GearbowError)
    if known:
        return str(error)
    return say("an unexpected {kind}: {error}", kind=type(error).__name__, error=error)


def table_range(system: Any) -> tuple[float, float]:
    """Give the sizes of the speeds that every table of bearing coefficients contains [rad/s]."""
    of_shaft, low, high = ratios_by_shaft(system), 0.0, math.inf
    for bearing in system.bearings:
        inner = other_shaft(bearing.support)
        other = of_shaft[inner[0]] if inner is not None else 0.0
        ratio = abs(of_shaft[bearing.shaft] - other)
        for table in (getattr(bearing, name, None) for name in ("stiffness", "damping")):
            if not isinstance(table, SpeedTable) or table.speeds is None or not ratio:
                continue
            if table.outside == "error":
                ends = np.asarray(table.speeds, dtype=np.float64)[[0, -1]] / ratio
                low, high = max(low, float(ends[0])), min(high, float(ends[1]))
    return low, high


Make = Callable[[Contents], Iterator[Block]]
