"""Linear response to what turns once with a shaft: amplitudes, phases, peaks and bearing forces."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from gearbow._convert import nodal, number, one_of, text
from gearbow._core import Model
from gearbow._extras import extra
from gearbow._result import Column, in_degrees, in_micrometres, replaced
from gearbow._shown import short
from gearbow._types import Array, At, ComplexArray, Excitation, Plain, SynchronousFigure
from gearbow.description.coordinates import Coordinates
from gearbow.description.places import place_label, places
from gearbow.errors import GearbowError
from gearbow.results.harmonic import PRINTED_PLACES, HarmonicResponse
from gearbow.results.peak import Peak, Peaks, marks, operating_range
from gearbow.results.section_forces import Motions
from gearbow.sensors import Accelerometer, Probe, SignalSensor
from gearbow.units.speed import SpeedUnit, in_given_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow.plotting.harmonic import Curve


def semi_axes(amplitudes: ComplexArray) -> Array:
    """Give the major semi-axes of orbits with amplitudes along y and z on the last axis."""
    v, w = np.moveaxis(amplitudes, -1, 0)
    found: Array = (np.abs(v + 1j * w) + np.abs(v - 1j * w)) / 2.0
    return found


@dataclass(frozen=True, eq=False)
class _HarmonicSignal:
    """What one shaft excites at a place or in a sensor."""

    label: str
    unit: str
    curve: "Curve"
    at: At | None
    source: str


@dataclass(frozen=True, eq=False)
class Synchronous(HarmonicResponse):
    """Linear response to everything that turns once with a shaft, without time stepping.

    Each shaft s excites the train at its own speed r_s Ω. The motion is Σ_s Re(a_s exp(i r_s Ω t)),
    so that all amplitudes are zero to peak. The first axes of all values are (speeds, shafts): for
    each speed, the phasor a_s with each shaft as the source.

    Parameters
    ----------
    speeds : ndarray, shape (speeds,)
        Speeds Ω of the reference shaft [rad/s].
    shafts : tuple of str
        The shafts, which are the sources of excitation.
    amplitudes : ndarray, shape (speeds, shafts, n)
        Complex amplitudes a_s of each degree of freedom [m, rad].
    excitation : {"both", "bow", "unbalance"}
        The excitation; "both" is bow, unbalance, turning forces, run-out of gears and couplings,
        and transmission errors of order 1 of a shaft.
    slow_roll : float or None
        Speed [rad/s] of the subtracted slow-roll amplitudes; None if none were subtracted.
    residuals : ndarray, shape (speeds,)
        Relative residual of the equations of motion at each speed, the largest of all sources: the
        backward error ``max |f − S a|/(|S| |a| + |f|)`` over the degrees of freedom, with the
        dynamic stiffness S and the force f; of a large system with modal damping, the part of the
        response in the energy norm.
    coordinates : Coordinates
        Degrees of freedom of the system.
    description : mapping
        The plain system, for slow roll and peaks.
    left_out : tuple of str
        Excitations of the system that this result does not contain.

    Examples
    --------
    The orbit of a slowly rotating shaft is its bow. It grows towards the critical speed:

    >>> import numpy as np
    >>> import gearbow as gb
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e9) for x in (0.0, 1.0)]
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=bow)
    >>> response = gb.RotorSystem(shafts=[rotor], bearings=bearings).synchronous([1.0, 300.0])
    >>> np.abs(response.displacement(("rotor", 0.5))[:, 0, 0]).round(6)
    array([0.0001  , 0.000129])
    """

    speeds: Array
    shafts: tuple[str, ...]
    amplitudes: ComplexArray
    excitation: Excitation
    slow_roll: float | None
    residuals: Array
    coordinates: Coordinates = field(repr=False)
    description: Mapping[str, Plain] = field(repr=False)
    _bearings: tuple[tuple[str, float], ...] = field(repr=False)
    _bearing_force: ComplexArray = field(repr=False)
    _bearing_displacement: ComplexArray = field(repr=False)
    _meshes: tuple[tuple[str, str], ...] = field(repr=False)
    _mesh_force: ComplexArray = field(repr=False)
    _bow: ComplexArray = field(repr=False)
    _ratios: Array = field(repr=False)
    left_out: tuple[str, ...] = ()

    def _facts(self) -> dict[str, str]:
        slow = None if self.slow_roll is None else self._speed_text(self.slow_roll)
        speeds = self._speed_text(self.speeds) if self.speeds.size else ""
        found = {
            "speeds": f"{self.speeds.size}, {speeds}" if self.speeds.size else "0",
            "shafts": short(self.shafts),
            "excitation": short(self.excitation),
            "slow_roll": slow,
        }
        return {name: text for name, text in found.items() if text is not None}

    @property
    def _motion(self) -> ComplexArray:
        return self.amplitudes

    @property
    def _rates(self) -> Array:
        return self.speeds[:, np.newaxis] * self._ratios

    def _motions(self) -> Motions:
        if self.slow_roll is not None:
            raise GearbowError(
                "section_forces: the slow roll was subtracted from this motion; take the section "
                "forces of the response before"
            )
        has_bow = self.excitation != "unbalance"
        return Motions(
            self.amplitudes,
            self._rates,
            self.speeds[:, np.newaxis],
            lambda shaft: [has_bow and source == shaft for source in self.shafts],
        )

    def _signal(self, sensor: Any) -> ComplexArray:
        """Give the signal of a sensor, with the run-out that turns with its shaft."""
        signal: ComplexArray = super()._signal(sensor)
        runout = getattr(sensor, "runout", None)
        # The subtraction of slow-roll amplitudes removes run-out too.
        if runout is None or sensor.shaft not in self.shafts or self.slow_roll is not None:
            return signal
        if not isinstance(runout, complex | float | int):
            raise GearbowError(
                "sensor: the run-out of a probe must be a complex number here, because the "
                "response contains what repeats once per revolution"
            )
        signal = signal.copy()
        signal[:, self.shafts.index(sensor.shaft)] += runout * np.exp(-1j * sensor.angle)
        return signal

    def orbit(self, at: At) -> Array:
        """Major semi-axis of the orbit that each shaft causes at a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (speeds, shafts)
            Semi-axis [m], the sum of the radii of the forward and the backward circular motion.
        """
        return semi_axes(self.displacement(at))

    def phase(self, at: At) -> Array:
        """Phase of the orbit that each shaft causes, relative to the angle of this shaft.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (speeds, shafts)
            Phase [rad] between −π and π of the circular motion in the direction of rotation of
            the exciting shaft: the angle of the high spot in the shaft. On isotropic bearings this
            circular motion is the orbit. NaN without an orbit.
        """
        v, w = np.moveaxis(self.displacement(at), -1, 0)
        # v = Re(a e^{iϑ}), w = Re(b e^{iϑ}): the part of v + iw that rotates with the shaft is
        # (a + ib) e^{iϑ}/2.
        circle = v + 1j * w
        phase: Array = np.where(circle == 0.0, np.nan, np.angle(circle))
        return phase

    def elastic(self, at: At) -> ComplexArray:
        """Complex amplitudes of the elastic deflection of the shaft: displacement minus bow.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (speeds, shafts, 2)
            Amplitudes along y and z [m]. The bow is subtracted from the amplitudes with the own
            shaft as the source, unless `excitation` is "unbalance".
        """
        indices = self.coordinates.lateral(at)
        elastic: ComplexArray = self.amplitudes[:, :, indices].copy()
        shaft = self.coordinates.shaft(at)
        if shaft not in self.shafts:
            raise GearbowError(f"{at!r} is no place of a shaft: only shafts have a bow")
        own = self.shafts.index(shaft)
        if self.excitation != "unbalance" and self.slow_roll is None:
            elastic[:, own] -= self._bow[indices]
        return elastic

    @in_given_unit
    def subtract_slow_roll(self, speed: float) -> "Synchronous":
        """Subtract the amplitudes at a slow-roll speed, as for measured run-out.

        Parameters
        ----------
        speed : float
            Speed of the reference shaft [rad/s], far below the first critical speed.

        Returns
        -------
        Synchronous
            The response minus its amplitudes at slow roll. Forces on bearings and of meshes do not
            change.
        """
        slow = number(speed, "speed")
        runout = self._model().synchronous(np.array([slow]), self.excitation, 1)
        return replaced(
            self,
            amplitudes=self.amplitudes - runout["phasors"],
            _bearing_displacement=self._bearing_displacement - runout["bearing_displacement"],
            slow_roll=slow,
        )

    @in_given_unit
    def peaks(
        self,
        at: At,
        source: str | None = None,
        *,
        operating: float | tuple[float, float] | None = None,
    ) -> Peaks:
        """Find the peaks of the orbit at a place, with the criteria of API RP 684.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).
        source : str, optional
            The shaft that excites; None is the shaft of the place.
        operating : float or tuple of (float, float), optional
            Operating speed, or the lowest and the highest [rad/s], of one sign and not zero.

        Returns
        -------
        Peaks
            A sequence of `Peak` with a table: the peaks on the grid `speeds`, refined by further
            solutions. Each sense of rotation is searched from standstill on. The lowest modes at
            the speed of a peak decide whether it is `stable`.
        """
        return self._peaks(self._model(), at, source, operating_range(operating))

    def _peaks(
        self, model: Model, at: At, source: str | None, span: tuple[float, float] | None
    ) -> Peaks:
        """Find the peaks with a compiled model."""
        indices = self.coordinates.lateral(at)
        shaft = self._source(at, source)
        speeds, first = np.unique(self.speeds, return_index=True)
        sizes = self.orbit(at)[first, shaft]
        found = model.peaks(
            list(zip(speeds.tolist(), sizes.tolist(), strict=True)),
            indices[0],
            shaft,
            self.excitation,
            self.slow_roll,
        )
        peaks = tuple(
            Peak(speed, amplitude, lower, upper, span, stable)
            for speed, amplitude, lower, upper, stable in found
        )
        return Peaks(
            peaks,
            at,
            self.shafts[shaft],
            self.speeds,
            self.phase(at)[:, shaft],
            self.orbit(at)[:, shaft],
            span,
        )

    def _source(self, at: At, source: str | None) -> int:
        """Find the number of the shaft that excites; None is the shaft of the place."""
        shaft = self.coordinates.shaft(at) if source is None else source
        if text(shaft, "source") not in self.shafts:
            wanted = "name one with source=" if source is None else "see `shafts`"
            raise GearbowError(
                f"source: no shaft is called {shaft!r}; {wanted}: {list(self.shafts)}"
            )
        return self.shafts.index(shaft)

    def _sources(self, at: At, source: str | None) -> list[str]:
        """Give the shafts whose excitation a Bode diagram shows; all for a place on no shaft."""
        on_shaft = source is not None or (
            at not in self.coordinates.points and self.coordinates.shaft(at) in self.shafts
        )
        return [self.shafts[self._source(at, source)]] if on_shaft else list(self.shafts)

    def _places(self) -> list[At]:
        """Give the gears and disks, or the place of each shaft with the largest orbit."""
        nodes = [(name, x) for name, x, kind in nodal(self.coordinates.dofs) if kind == "v"]
        bending = {name for name, _ in nodes} & set(self.shafts)
        bodies = self.coordinates.bodies.items()
        named: list[At] = [name for name, (shaft, _) in bodies if shaft in bending]
        if named:
            return named
        by_shaft = ([node for node in nodes if node[0] == shaft] for shaft in self.shafts)
        return [
            max(own, key=lambda node: float(self.orbit(node).max(initial=0.0)))
            for own in by_shaft
            if own
        ]

    def bode(
        self,
        at: At | SignalSensor | Sequence[At | SignalSensor] | None = None,
        source: str | None = None,
        *,
        operating: float | tuple[float, float] | None = None,
        ax: Any = None,
        speed_unit: SpeedUnit | None = None,
    ) -> "Figure":
        """Draw amplitude and phase against the speed.

        Parameters
        ----------
        at : str, tuple of (str, float), Probe, Accelerometer, or sequence of them, optional
            A gear or disk by name, (shaft, position [m]), a support, a housing or its point, or a
            sensor; None is the three gears or disks with the largest orbits.
        source : str, optional
            The shaft that excites; None is that of each place, or every one for a place on none.
        operating : float or tuple of (float, float), optional
            Operating speed, or the lowest and the highest [rad/s], which the figure shades.
        ax : sequence of two Axes, optional
            Panels for phase and amplitude; None makes a new figure.
        speed_unit : str, optional
            Unit of the axis of speeds, as for `table`; None is that of the given ones.

        Returns
        -------
        matplotlib.figure.Figure
            Phase above, major semi-axis of the orbits or amplitude of the sensors below. The peaks
            of places have marks with their amplification factor, see `peaks`.

        Raises
        ------
        GearbowError
            If there is no such place or shaft, or the signals have different units.
        """
        with extra("plot"):
            from gearbow.plotting import harmonic  # noqa: PLC0415

        signals = self._signals(at, source)
        span, model = operating_range(operating), self._model()
        peaks = {
            one.label: marks(self._peaks(model, one.at, one.source, span))
            for one in signals
            if one.at is not None and np.any(one.curve.size)
        }
        with self._showing(speed_unit):
            return harmonic.bode(
                {one.label: one.curve for one in signals},
                signals[0].unit if signals else "m",
                peaks=peaks,
                operating=span,
                ax=ax,
            )

    def _signals(self, given: Any, source: str | None) -> list["_HarmonicSignal"]:
        """Give the signals of places and sensors; a place on no shaft has one for each shaft."""
        from gearbow.plotting.harmonic import Curve  # noqa: PLC0415

        if given is None:
            given = self._largest(self._chosen())
        if isinstance(given, SignalSensor):
            given = [given]
        listed = given if isinstance(given, list | tuple) else []
        several = any(isinstance(each, SignalSensor) for each in listed)
        found = []
        for one in listed if several else places(given):
            sensor = one if isinstance(one, SignalSensor) else None
            at = one if sensor is None else _place_of(sensor)
            shafts = self._sources(at, source)
            for shaft in shafts:
                own = self.shafts.index(shaft)
                if sensor is None:
                    label, unit = place_label(one), "m"
                    curve = Curve(self.speeds, self.orbit(one)[:, own], self.phase(one)[:, own])
                else:
                    label, unit = sensor.label, sensor.unit
                    curve = Curve.of(self.speeds, self._signal(sensor)[:, own])
                if len(shafts) > 1:
                    if not np.any(curve.size):
                        continue
                    label = f"{label}, excited by {shaft}"
                place = None if sensor is not None or len(shafts) > 1 else one
                found.append(_HarmonicSignal(label, unit, curve, place, shaft))
        if len({signal.unit for signal in found}) > 1:
            raise GearbowError("at: displacements and accelerations need a figure each")
        return found

    def _chosen(self) -> list[At]:
        """Give the places of a figure without names."""
        found = self._places()
        if not found:
            raise GearbowError("at: this system has no lateral motion, which the figure shows")
        return found

    def plot(
        self,
        at: At | SignalSensor | Sequence[At | SignalSensor] | None = None,
        kind: SynchronousFigure = "orbit",
        *,
        source: str | None = None,
        ax: Any = None,
        speed_unit: SpeedUnit | None = None,
    ) -> "Figure":
        """Draw the orbits against the speed, a Bode diagram or a polar plot.

        Parameters
        ----------
        at : str, tuple of (str, float), sensor, or sequence of them, optional
            A gear or disk by name, (shaft, position [m]), or several, for "bode" and "polar" also
            sensors; None is all gears and disks, or the place with the largest orbit on each shaft,
            for "bode" and "polar" the three largest. A kind in place of a name stands for itself:
            ``plot("polar")``.
        kind : {"orbit", "bode", "polar"}
            Major semi-axis of the orbits; amplitude and phase, as `bode`; or both as a curve in the
            complex plane, with the speed at its ends and its largest amplitude.
        source : str, optional
            The shaft that excites. None is every shaft for "orbit", else as in `bode`.
        ax : Axes or sequence of Axes, optional
            One panel for each place, two for "bode", one for "polar"; None makes a new figure.
        speed_unit : str, optional
            Unit of speeds, as for `table`; None is that of the given ones.

        Returns
        -------
        matplotlib.figure.Figure
            The figure. It is neither shown nor saved.

        Raises
        ------
        GearbowError
            If there is no such place or shaft, or the signals have different units.
        """
        with extra("plot"):
            from gearbow.plotting import harmonic  # noqa: PLC0415

        kinds = get_args(SynchronousFigure)
        if isinstance(at, str) and at in kinds and at not in self.coordinates.bodies:
            at, kind = None, at  # type: ignore[assignment]  # one of the kinds
        one_of(kind, kinds, "kind")
        if kind == "bode":
            return self.bode(at, source, ax=ax, speed_unit=speed_unit)
        if kind == "polar":
            signals = self._signals(at, source)
            curves = {one.label: one.curve for one in signals}
            of = signals[0].unit if signals else "m"
            with self._showing(speed_unit):
                return harmonic.polar(curves, of, ends=True, ax=ax)
        chosen = self._chosen() if at is None else places(at)
        shafts = self.shafts if source is None else (self.shafts[self._source(chosen[0], source)],)
        own = [self.shafts.index(shaft) for shaft in shafts]
        orbits = {place_label(one): self.orbit(one)[:, own] for one in chosen}
        with self._showing(speed_unit):
            return harmonic.synchronous(self.speeds, orbits, shafts, ax=ax)

    def _heading(self) -> list[str]:
        excitation = "bow and unbalance" if self.excitation == "both" else self.excitation
        lines = [f"synchronous response to {excitation}, {self._speed_text(self.speeds)}"]
        count = len(self._places())
        if count > PRINTED_PLACES:
            lines.append(f"{PRINTED_PLACES} of {count} places; to_dataframe gives all")
        return [*lines, "major semi-axis and phase of the orbit that the own shaft excites"]

    def _columns(self) -> list[Column]:
        return self._of(self._largest(self._places()))

    def _largest(self, chosen: Sequence[At]) -> list[At]:
        """Give the places with the largest orbits, in their order."""
        sizes = {at: float(self._own(self.orbit(at), at).max(initial=0.0)) for at in chosen}
        largest = sorted(sizes, key=lambda at: -sizes[at])[:PRINTED_PLACES]
        return [at for at in sizes if at in largest]

    def _series(self) -> list[Column]:
        return self._of(self._places())

    def _of(self, chosen: Sequence[At]) -> list[Column]:
        """Give a row for each speed, with amplitude and phase of the orbit of each place."""
        columns = [Column("speed", self.speeds, "rad/s", ".2f")]
        for at in chosen:
            label, orbit, phase = place_label(at), self.orbit(at), self.phase(at)
            columns += [
                Column(f"{label} orbit", self._own(orbit, at), "m", ".4g", in_micrometres()),
                Column(f"{label} phase", self._own(phase, at), "rad", ".1f", in_degrees()),
            ]
        return columns

    def _own(self, values: Array, at: At) -> Array:
        """Give the values with the shaft of the place as the source."""
        return values[:, self._source(at, None)]


def _place_of(sensor: SignalSensor) -> At:
    if isinstance(sensor, Probe):
        return (sensor.shaft, sensor.position)
    if isinstance(sensor, Accelerometer):
        return sensor.at
    raise GearbowError(f"at: must be a place, a Probe or an Accelerometer, got {sensor!r}")
