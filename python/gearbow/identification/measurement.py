"""Measured once-per-revolution vibration: amplitudes and phases of probes over the speed."""

import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, complex_number, items, number, one_of, shown, text, whole
from gearbow._files import as_path
from gearbow._result import Column, Figured, in_degrees, in_micrometres
from gearbow._shown import ReadOnly, span
from gearbow._types import Array, At, ComplexArray
from gearbow.description.places import place
from gearbow.errors import AccuracyWarning, SceneError, warn
from gearbow.exchange.tables import DETECTIONS, VIBRATION, NamedColumns, Table, read_table
from gearbow.sensors import Probe, Tacho
from gearbow.units.parse import parsed
from gearbow.units.speed import SpeedUnit, given_unit, speed_factor, unit_in_texts

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: What the columns of a probe contain, and the fields that give their units.
_QUANTITIES = {
    "amplitude": VIBRATION,
    "phase": "phase",
    "phase_lag": "phase",
    "real": VIBRATION,
    "imaginary": VIBRATION,
}
#: Columns of a file with a line for each speed and probe; those with an empty field have names.
_COLUMNS = {
    **{name: name for name in ("speed", "position", "angle")},
    **_QUANTITIES,
    **dict.fromkeys(("probe", "shaft", "reference"), ""),
}
#: Columns of a file with a line for each speed.
_OF_PROBES = NamedColumns(
    re.compile(rf"(.+?)[\s_]+({'|'.join(_QUANTITIES).replace('_', '[ _-]')})", re.IGNORECASE),
    {name: (field,) for name, field in _QUANTITIES.items()},
    "A amplitude [um]",
)
#: Name of a probe that says where it is: "input@0.2 y".
_PLACE = re.compile(r"(.+)@(.+) ([yz])")
#: Largest phase of a file in radians [rad]: one turn and some round-off.
_LARGEST_PHASE = 7.0


@dataclass(frozen=True, eq=False)
class Measurement(Figured, ReadOnly):
    """Once-per-revolution (1×) vibration of probes over the speed.

    The signal of a probe is ``Re(A exp(iφ))``. Its phase reference φ grows by 2π with every turn
    of the reference shaft of the probe, in either sense of rotation; it is zero where this shaft
    stands at the angle `phase_angle`, for example where its mark passes the tachometer.

    `plot` draws the phase of every probe against the speed, and the amplitude below.

    Parameters
    ----------
    speeds : array_like, shape (k,)
        Speeds of the shaft `speed_shaft` [rad/s], not zero; at least two over all measurements.
        Negative ones are a rotation against that of the positive speeds of the system.
    amplitudes : array_like of complex, shape (k, probes)
        Amplitudes A towards the probes [m]; their argument is the lead of phase. NaN is missing.
    probes : sequence of Probe
        The probes. The same place and angle mean the same probe, also in several measurements.
    references : str or sequence of str, optional
        Shaft of the phase reference of each probe: its amplitudes are those at once per revolution
        of this shaft. None is the shaft of the probe itself.
    phase_angle : float
        Angle of the reference shafts at phase zero [rad].
    speed_shaft : str, optional
        Shaft of the speeds; None is the reference shaft of the system.
    trial_weights : mapping, optional
        Known unbalances [kg m, complex] in this measurement beyond those in the system, by gear,
        disk or (shaft, position [m]).
    slow_roll : float, optional
        Speed whose amplitudes were subtracted from all others [rad/s].
    speed_unit : str
        Unit of speeds in tables and figures, as for `table`.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> speeds = np.array([50.0, 100.0, 150.0])
    >>> vectors = np.array([[80e-6], [83e-6 - 1e-6j], [90e-6 - 3e-6j]])
    >>> measured = gb.Measurement(speeds, vectors, [gb.Probe("input", 0.3)])
    >>> print(measured.table(count=1))
    1× vibration of 1 probe at 3 speeds
    speed [rad/s]                          probe  reference  amplitude [µm]  phase [°]
               50  probe input at 0.3 m, 0°  input                  80        0.0
    """

    speeds: Array
    amplitudes: ComplexArray
    probes: tuple[Probe, ...]
    references: tuple[str, ...]
    phase_angle: float
    speed_shaft: str | None
    trial_weights: Mapping[At, complex]
    slow_roll: float | None
    speed_unit: SpeedUnit

    def __init__(
        self,
        speeds: "ArrayLike",
        amplitudes: "ArrayLike",
        probes: Sequence[Probe],
        *,
        references: str | Sequence[str] | None = None,
        phase_angle: float = 0.0,
        speed_shaft: str | None = None,
        trial_weights: Mapping[At, complex] | None = None,
        slow_roll: float | None = None,
        speed_unit: SpeedUnit | None = None,
    ) -> None:
        own = tuple(items(probes, "probes", "gb.Probe"))
        for i, probe in enumerate(own):
            if not isinstance(probe, Probe) or probe.axial:
                raise SceneError(f"probes[{i}]: must be a lateral gb.Probe, got {shown(probe)}")
        wanted_speeds = array(speeds, "speeds")
        zero = np.flatnonzero(wanted_speeds == 0.0)
        if zero.size:
            raise SceneError(f"speeds[{zero[0]}]: must not be zero, a shaft at rest has no phase")
        names: Any = [probe.shaft for probe in own] if references is None else references
        names = [names] * len(own) if isinstance(names, str) else names
        listed = items(names, "references", "names of shafts")
        if len(listed) != len(own):
            raise SceneError(
                f"references: must be one shaft for each of {len(own)} probes, got {len(listed)}"
            )
        unit = given_unit(speeds) or "rad/s" if speed_unit is None else speed_unit
        given: dict[str, Any] = {
            "speeds": wanted_speeds,
            "amplitudes": _checked_amplitudes(amplitudes, (wanted_speeds.size, len(own))),
            "probes": own,
            "references": tuple(text(n, f"references[{i}]") for i, n in enumerate(listed)),
            "phase_angle": number(phase_angle, "phase_angle"),
            "speed_shaft": None if speed_shaft is None else text(speed_shaft, "speed_shaft"),
            "trial_weights": _checked_weights(trial_weights),
            "slow_roll": None if slow_roll is None else number(slow_roll, "slow_roll"),
            "speed_unit": one_of(unit, get_args(SpeedUnit), "speed_unit"),
        }
        for name, value in given.items():
            object.__setattr__(self, name, value)
        ReadOnly.__post_init__(self)

    @classmethod
    def read_csv(
        cls,
        path: str | os.PathLike[str],
        probes: Mapping[str, Probe] | None = None,
        *,
        detection: str | None = None,
        **options: Any,
    ) -> "Measurement":
        r"""Read amplitudes and phases from a table.

        Parameters
        ----------
        path : str or path-like
            A file as for `SpeedTable.read_table` with the column "speed" and a line for each speed
            and probe, or one line for each speed. The former has the columns "shaft", "position"
            and optionally "angle" of a probe, or its name "probe"; and "amplitude" with "phase"
            (lead) or "phase_lag", or "real" with "imaginary". The column "reference" is the shaft
            of the phase reference. The latter has these two columns for each probe, behind its
            name: "A amplitude [um]", "A phase [deg]". A heading has the unit in brackets; without
            one it is the SI unit. It says what its amplitudes are by "pp", "p-p" or "pk-pk" (peak
            to peak), "pk" or "0-pk" (zero to peak) or "rms": "amplitude p-p [mil]".
        probes : mapping, optional
            Probes by their names in the table; "input@0.2 y" or "input@200 mm z" says the place.
        detection : {"peak", "peak-to-peak", "rms"}, optional
            What amplitudes are whose heading does not say it; None is zero to peak.
        **options
            `phase_angle`, `speed_shaft`, `trial_weights` or `slow_roll` of `Measurement`.

        Returns
        -------
        Measurement
            The measurement, ordered by speed; its amplitudes are from zero to peak.

        Raises
        ------
        SceneError
            If a heading, a unit or a number is invalid, a column is missing, a probe occurs twice
            at one speed, or phases without a unit are no radians.

        Warns
        -----
        AccuracyWarning
            If a probe has no line at some of the speeds.

        Examples
        --------
        >>> from pathlib import Path
        >>> import gearbow as gb
        >>> lines = ["speed [rpm], shaft, position [mm], amplitude [um pp], phase [deg]"]
        >>> lines += ["500, input, 300, 160, 0", "1000, input, 300, 168, -2"]
        >>> written = Path("run_down.csv").write_text("\n".join(lines))
        >>> gb.Measurement.read_csv("run_down.csv")
        Measurement(speeds=2, 500 to 1000 rpm, probes=1)
        >>> Path("run_down.csv").unlink()
        """
        if probes is not None and not isinstance(probes, Mapping):
            raise SceneError(f"probes: must be a mapping of names to gb.Probe, got {shown(probes)}")
        if detection is not None:
            one_of(detection, tuple(DETECTIONS), "detection")
        found = read_table(path, _COLUMNS, named=_OF_PROBES, detection=detection)
        if "speed" not in found.numbers:
            raise SceneError(f'{path}: needs the column "speed", got {", ".join(found.units)}')
        zero = np.flatnonzero(found.numbers["speed"] == 0.0)
        if zero.size:
            where = found.where(zero[0], "speed")
            raise SceneError(f"{where}: must not be zero, a shaft at rest has no phase")
        channels: dict[tuple[Any, ...], int] = {}
        known: list[Probe] = []
        references: list[str] = []
        readings = []
        for of_probe, vectors in _vectors(found):
            for i, vector in enumerate(vectors.tolist()):
                probe, key = _probe_of(found, i, of_probe, probes)
                named = found.texts.get("reference")
                reference = probe.shaft if named is None else named[i]
                own = (*key, reference)
                if own not in channels:
                    channels[own] = len(known)
                    known.append(probe)
                    references.append(reference)
                readings.append((i, channels[own], vector))
        speeds, rows = np.unique(found.numbers["speed"], return_inverse=True)
        table = np.full((speeds.size, len(known)), np.nan, dtype=np.complex128)
        lines: dict[tuple[int, int], int] = {}
        for i, column, vector in readings:
            row = int(rows[i])
            if (row, column) in lines:
                raise SceneError(
                    f"{path}: {found.lines[lines[row, column]]} and {found.lines[i]}: "
                    f"{known[column].label} occurs twice at {speeds[row]:.6g} rad/s; put the "
                    "second series into a file of its own, and give both to identify"
                )
            lines[row, column] = i
            table[row, column] = vector
        _warn_of_missing(table, speeds, known, str(path))
        unit = unit_in_texts(f"1 {found.units['speed']}")
        return cls(speeds, table, known, references=references, speed_unit=unit, **options)

    @classmethod
    def from_signals(
        cls,
        time: "ArrayLike",
        signals: Mapping[Probe, "ArrayLike"],
        pulses: Mapping[Tacho, "ArrayLike"],
        *,
        revolutions: int = 20,
        trial_weights: Mapping[At, complex] | None = None,
    ) -> "Measurement":
        """Find the 1× vibration in signals of probes with the pulses of a tachometer.

        Each amplitude is the least-squares fit of a mean and the 1× vibration of all reference
        shafts to a window of whole revolutions. The angle within a window is a polynomial through
        the pulses, so that the speed may change.

        Parameters
        ----------
        time : array_like, shape (n,)
            Times of the samples [s], ascending.
        signals : mapping of Probe to array_like, shape (n,)
            Signals [m], as from ``response.measure(probe)``.
        pulses : mapping of Tacho to array_like
            Times of the pulses [s] of one tachometer for each shaft whose 1× vibration is wanted,
            as from ``response.measure(tacho)``. Those of the first one give the speed. A probe
            beside a shaft without a tachometer has the first one as its phase reference.
        revolutions : int
            Revolutions of the first shaft in a window.
        trial_weights : mapping, optional
            As for `Measurement`.

        Returns
        -------
        Measurement
            One row for each window.

        Raises
        ------
        SceneError
            If there are too few pulses or samples, or the angles of the tachometers differ.
        """
        from gearbow.identification.signals import windows  # noqa: PLC0415  # few runs need it

        return cls(**windows(time, signals, pulses, revolutions), trial_weights=trial_weights)

    @classmethod
    def read_uff(
        cls,
        path: str | os.PathLike[str],
        channels: Mapping[int, Probe | Tacho | tuple[str, float]],
        *,
        revolutions: int = 20,
        trial_weights: Mapping[At, complex] | None = None,
    ) -> "Measurement":
        """Find the 1× vibration in the time histories of a universal file.

        Parameters
        ----------
        path : str or path-like
            A file with data sets 58 of function type 1: displacements and a tachometer. Units are
            those of the labels, or of data set 164.
        channels : mapping of int to Probe, Tacho or (str, float)
            What each node of the file is. A place (shaft, position [m]) is a probe along y or z, as
            the direction of the node; a direction below zero reverses the signal. The pulses of a
            `Tacho` are where its signal rises through the middle of its range. Other nodes are left
            out.
        revolutions : int
            Revolutions of the first shaft in a window.
        trial_weights : mapping, optional
            As for `Measurement`.

        Returns
        -------
        Measurement
            One row for each window of revolutions.

        Raises
        ------
        SceneError
            If the file is damaged, has no such signal, or a signal has no pulses.

        See Also
        --------
        from_signals : The same with arrays.
        """
        from gearbow.identification.signals import read_signals  # noqa: PLC0415  # few runs need it

        if not isinstance(channels, Mapping):
            raise SceneError(f"channels: must be a mapping of nodes, got {shown(channels)}")
        turns = whole(revolutions, "revolutions", least=2)
        weights = _checked_weights(trial_weights)
        signals = read_signals(as_path(path, "path"), channels)
        return cls.from_signals(*signals, revolutions=turns, trial_weights=weights)

    def subtract_slow_roll(self, speed: float) -> "Measurement":
        """Subtract the amplitudes at the measured speed that is nearest to a slow-roll speed.

        The slow-roll amplitudes contain the bow, not only the run-out. `gearbow.identify` therefore
        needs no subtraction; with it, the run-out that it finds is what remains of both.

        Parameters
        ----------
        speed : float
            Slow-roll speed [rad/s].

        Returns
        -------
        Measurement
            The other rows, minus the amplitudes at this speed.
        """
        row = int(np.argmin(np.abs(self.speeds - number(speed, "speed"))))
        kept = np.arange(self.speeds.size) != row
        return Measurement(
            self.speeds[kept],
            self.amplitudes[kept] - self.amplitudes[row],
            self.probes,
            references=self.references,
            phase_angle=self.phase_angle,
            speed_shaft=self.speed_shaft,
            trial_weights=self.trial_weights,
            slow_roll=float(self.speeds[row]),
            speed_unit=self.speed_unit,
        )

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the probes; with their reference shaft where it is not their own."""
        return tuple(
            probe.label + ("" if name == probe.shaft else f", 1× {name}")
            for probe, name in zip(self.probes, self.references, strict=True)
        )

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import harmonic as figures  # noqa: PLC0415

        series = dict(zip(self.labels, self.amplitudes.T, strict=True))
        return figures.measured_bode(speed_factor() * self.speeds, series, {}, ax=ax)

    def _facts(self) -> dict[str, str]:
        unit = self.speed_unit
        speeds = f"{self.speeds.size}, {span(speed_factor(unit) * self.speeds)} {unit}"
        return {"speeds": speeds, "probes": str(len(self.probes))}

    def _heading(self) -> list[str]:
        count = len(self.probes)
        plural = "" if count == 1 else "s"
        return [f"1× vibration of {count} probe{plural} at {self.speeds.size} speeds"]

    def _columns(self) -> list[Column]:
        """Give a row for each speed and probe."""
        count = len(self.probes)
        vectors = self.amplitudes.ravel()
        return [
            Column("speed", np.repeat(self.speeds, count), "rad/s", ".6g"),
            Column("probe", [probe.label for probe in self.probes] * self.speeds.size),
            Column("reference", list(self.references) * self.speeds.size),
            Column("amplitude", np.abs(vectors), "m", ".4g", in_micrometres()),
            Column("phase", np.angle(vectors), "rad", ".1f", in_degrees()),
        ]


def _checked_amplitudes(given: ArrayLike, wanted: tuple[int, int]) -> ComplexArray:
    """Convert amplitudes to a table of complex numbers."""
    try:
        vectors = np.array(given)
        if vectors.dtype.kind not in "iufc":
            raise TypeError
        vectors = vectors.astype(np.complex128)
    except (TypeError, ValueError):
        raise SceneError(
            f"amplitudes: must be complex numbers in rows of equal lengths, got {shown(given)}"
        ) from None
    if vectors.ndim == 1 and wanted[1] == 1:
        vectors = vectors[:, None]
    if vectors.shape != wanted:
        raise SceneError(
            f"amplitudes: must have the shape (speeds, probes) = {wanted}, got {vectors.shape}"
        )
    if np.isinf(vectors).any() or not np.isfinite(vectors).any():
        raise SceneError("amplitudes: must be finite, or NaN where they are missing")
    return vectors


def _checked_weights(given: Mapping[At, complex] | None) -> dict[At, complex]:
    """Convert trial weights to complex numbers by place."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise SceneError(f"trial_weights: must be a mapping of planes, got {shown(given)}")
    weights: dict[At, complex] = {}
    for at, value in given.items():
        plain = complex_number(value, "trial_weights")
        weights[place(at, "trial_weights", "place")] = complex(*np.ravel(plain))
    return weights


def _vectors(table: Table) -> Iterator[tuple[str | None, ComplexArray]]:
    """Give the complex amplitudes of each probe with its name; None is a line for each probe."""
    quantities: dict[str | None, list[str]] = {}
    for name in table.numbers:
        own, _, quantity = name.rpartition(" ")
        if quantity in _QUANTITIES:
            quantities.setdefault(own or None, []).append(quantity)
    if None in quantities and len(quantities) > 1:
        first = next(filter(None, quantities))
        raise SceneError(
            f'{table.path}: has columns of the probe "{first}" beside "{quantities[None][0]}"; '
            "give columns for each probe, or a line for each probe"
        )
    for probe, names in (quantities or {None: []}).items():
        yield probe, _vector(table, "" if probe is None else f"{probe} ", names)


def _vector(table: Table, prefix: str, names: Sequence[str]) -> ComplexArray:
    """Make complex amplitudes of two columns."""
    numbers = {name: table.numbers[f"{prefix}{name}"] for name in names}
    if sorted(names) == ["imaginary", "real"]:
        return numbers["real"] + 1j * numbers["imaginary"]
    phases = [name for name in names if name != "amplitude"]
    if "amplitude" not in numbers or len(names) != 2 or phases[0] not in ("phase", "phase_lag"):
        raise SceneError(
            f'{table.path}: needs the columns "{prefix}amplitude" and one of "{prefix}phase" and '
            f'"{prefix}phase_lag", or "{prefix}real" and "{prefix}imaginary", got '
            f"{', '.join(table.units)}"
        )
    phase = numbers[phases[0]]
    largest = int(np.abs(phase).argmax())
    if not table.units[f"{prefix}{phases[0]}"] and abs(phase[largest]) > _LARGEST_PHASE:
        raise SceneError(
            f"{table.where(largest, prefix + phases[0])}: has no unit, which means rad, but "
            f'reaches {abs(phase[largest]):g}; write "{prefix}{phases[0]} [deg]" if these are '
            "degrees"
        )
    negative = np.flatnonzero(numbers["amplitude"] < 0.0)
    if negative.size:
        where = table.where(negative[0], f"{prefix}amplitude")
        value = numbers["amplitude"][negative[0]]
        raise SceneError(f"{where}: must not be negative, got {value:g} m")
    sense = -1.0 if phases[0] == "phase_lag" else 1.0
    vectors: ComplexArray = numbers["amplitude"] * np.exp(1j * sense * phase)
    return vectors


def _probe_of(
    table: Table, row: int, name: str | None, probes: Mapping[str, Probe] | None
) -> tuple[Probe, tuple[Any, ...]]:
    """Find the probe of a line, and what tells it from others; `name` is that in the headings."""
    texts, numbers = table.texts, table.numbers
    place = f"{table.path}: {table.lines[row]}"
    if name is None and "shaft" in texts and "position" in numbers:
        angle = float(numbers["angle"][row]) if "angle" in numbers else 0.0
        key = (texts["shaft"][row], float(numbers["position"][row]), angle)
        try:
            return Probe(key[0], key[1], angle=angle), key
        except SceneError as error:
            raise SceneError(f"{place}: {error}") from None
    if name is None and "probe" not in texts:
        raise SceneError(f'{table.path}: needs the columns "shaft" and "position", or "probe"')
    own = texts["probe"][row] if name is None else name
    found = _PLACE.fullmatch(own)
    if probes is not None and own in probes:
        return probes[own], (own,)
    if found is None:
        raise SceneError(
            f"{place}: the place of probe {own!r} is unknown; give "
            f"probes={{{own!r}: gb.Probe(shaft, position)}}, or the columns shaft and position"
        )
    position = parsed(found[2], "position", bare=True)
    return Probe(found[1], position, angle={"y": 0.0, "z": math.pi / 2.0}[found[3]]), (own,)


def _warn_of_missing(table: ComplexArray, speeds: Array, probes: list[Probe], path: str) -> None:
    """Warn of probes without a line at some of the speeds."""
    missing = np.argwhere(np.isnan(table))
    if missing.size:
        row, column = missing[0]
        warn(
            f"{path}: {len(missing)} of {table.size} amplitudes are missing, the first that of "
            f"{probes[column].label} at {speeds[row]:.6g} rad/s",
            AccuracyWarning,
        )
