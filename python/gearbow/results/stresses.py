"""Stresses in the sections of the shafts, as the turning shaft sees them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import number, one_of
from gearbow._core import Model
from gearbow._result import Column, Figured, WithSpeeds, Written
from gearbow._shown import ReadOnly
from gearbow._times import begin_after
from gearbow._types import Array, ComplexArray, Section, StrengthLine
from gearbow.description.part import parts
from gearbow.description.shafts import Notch
from gearbow.description.train import parts_of
from gearbow.errors import SceneError
from gearbow.recording import access
from gearbow.recording.record import Recorded

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Angles of the fibres around a shaft at which stresses are compared [rad]. Between two of them a
#: stress that is a cosine of the angle changes by 4e-5.
FIBRES = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
#: Instants of a turn; an extreme of the second order between two of them is missed by at most 4e-4.
_INSTANTS = 240
#: Relative step of the diameter that is a shoulder.
_STEP = 1e-6
#: Relative difference of frequencies that count as equal: round-off of speed ratios.
_SAME = 1e-9


@dataclass(frozen=True)
class Strength:
    """Endurance limits of the shafts, and what mean stresses leave of them."""

    #: Amplitude that a smooth specimen endures at no mean stress [Pa], by shaft.
    endurance_limit: Mapping[str, float]
    #: Tensile strength [Pa], by shaft.
    tensile_strength: Mapping[str, float]
    line: StrengthLine

    @classmethod
    def of(
        cls,
        shafts: Iterable[str],
        endurance_limit: float | Mapping[str, float] | None,
        tensile_strength: float | Mapping[str, float] | None,
        line: StrengthLine,
    ) -> "Strength":
        """Check the strength that a user gives for all shafts or by name."""
        one_of(line, ("goodman", "din743"), "line")
        names = list(shafts)
        given = {"endurance_limit": endurance_limit, "tensile_strength": tensile_strength}
        found = {name: _by_shaft(value, name, names) for name, value in given.items()}
        for shaft in set(found["endurance_limit"]) - set(found["tensile_strength"]):
            raise SceneError(
                f"tensile_strength: the line for mean stresses of shaft {shaft!r} needs it; give "
                "the tensile strength of its material [Pa]"
            )
        return cls(found["endurance_limit"], found["tensile_strength"], line)

    def utilisation(self, shaft: str, amplitude: Any, mean: Any, notch: Notch | None) -> Any:
        """Give amplitude over what the mean stress leaves of the endurance limit; NaN without."""
        if shaft not in self.endurance_limit:
            return np.full(np.shape(amplitude), np.nan)
        endured, strength = self.endurance_limit[shaft], self.tensile_strength[shaft]
        if self.line == "goodman":
            return amplitude / endured + mean / strength
        factor = 1.0 if notch is None else notch.bending
        # DIN 743-1: the amplitude endured at the notch falls by ψ = σ_WK/(2 σ_B − σ_WK) times the
        # mean stress, with σ_WK = σ_W/K.
        left = endured - endured / (2.0 * strength - endured / factor) * mean
        return np.where(left > 0.0, amplitude / np.where(left > 0.0, left, 1.0), np.inf)


def _by_shaft(
    given: float | Mapping[str, float] | None, path: str, shafts: Sequence[str]
) -> dict[str, float]:
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        given = dict.fromkeys(shafts, given)
    for name in given:
        one_of(name, shafts, path)
    found = {name: number(value, f"{path}[{name!r}]") for name, value in given.items()}
    for name, value in found.items():
        if value <= 0.0:
            raise SceneError(f"{path}[{name!r}]: must be above zero [Pa], got {value}")
    return found


@dataclass(frozen=True, eq=False)
class Stresses(WithSpeeds, Figured, ReadOnly):
    """Mean and alternating stresses at the worst fibre of each of k sections of the shafts.

    In the frame of a turning shaft, bow and unbalance bend it steadily, and tooth forces and
    gravity alternate once a turn. The fibre is that with the largest utilisation, or without an
    endurance limit with the largest equivalent amplitude. `plot` draws amplitudes and means of the
    equivalent stress along the shafts, and the utilisation.

    Parameters
    ----------
    sections : tuple of (str, float, str)
        Shaft, position [m], and the side of a node: "before" or "beyond".
    radius : ndarray, shape (k,)
        Outer radius of the shaft [m].
    fibre : ndarray, shape (k,)
        Angle of the worst fibre in the shaft, from y towards z at shaft angle zero [rad].
    bending, axial, torsion : ndarray, shape (k, 2)
        Mean and amplitude of the nominal bending, axial and torsional stress there [Pa].
    amplitude, mean : ndarray, shape (k,)
        Equivalent amplitude with the notch factors, and equivalent mean stress [Pa].
    utilisation : ndarray, shape (k,)
        Amplitude over what the mean stress leaves of the endurance limit; NaN without a limit.
    notches : tuple of str
        Notch factors of each section; "none given" where the diameter changes.
    left_out : tuple of str
        Excitations of the system that this result does not contain.

    Notes
    -----
    Nominal stresses are σ_b = M r E/(EI) with the rigidity of shaft and sleeves, σ = N E/(EA) and
    τ = T r G/(GJ). Equivalent are √((K_b(σ_b + σ))² + 3(K_t τ)²) of the amplitudes and
    √((σ_b + σ)² + 3τ²) of the means. With line "goodman" the utilisation is σ_a/σ_W + σ_m/R_m, with
    "din743" σ_a/(σ_W − K_b ψ σ_m) with ψ = σ_W/(2 K_b R_m − σ_W). Tones that repeat after a turn
    are sampled; the amplitudes of others are added, the largest that occur. There are no shear
    stresses of transverse forces, no residual stresses, and no sum of damage over a load spectrum.

    Examples
    --------
    A turning shaft under a force that stands still, σ = 32 M/(π d³) with M = 25 N m:

    >>> import gearbow as gb
    >>> light = gb.Material(207e9, 1.0, poisson_ratio=0.3)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.02, material=light)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> force = gb.Force(("rotor", 0.5), -100.0j)
    >>> notch = gb.Notch("rotor", 0.5, bending=1.5)
    >>> system = gb.RotorSystem([rotor], bearings=bearings, forces=[force], notches=[notch])
    >>> found = system.stresses(10.0, endurance_limit=250e6, tensile_strength=600e6)
    >>> print(f"{found.bending[found.worst, 1] / 1e6:.1f} MPa, {found.utilisation.max():.3f}")
    31.8 MPa, 0.191
    """

    sections: tuple[Section, ...]
    radius: Array
    fibre: Array
    bending: Array
    axial: Array
    torsion: Array
    amplitude: Array
    mean: Array
    utilisation: Array
    notches: tuple[str, ...]
    left_out: tuple[str, ...] = ()

    @property
    def worst(self) -> int:
        """Index of the section with the largest utilisation; without limits, of the amplitude."""
        measure = self.amplitude if np.isnan(self.utilisation).all() else self.utilisation
        return int(np.nanargmax(measure))

    def _facts(self) -> dict[str, str]:
        shaft, x, _ = self.sections[self.worst]
        return {
            "sections": str(len(self.sections)),
            "largest": f"{self.amplitude.max() / 1e6:.4g} MPa",
            "worst": f"({shaft!r}, {x:g})",
        }

    def _columns(self) -> list[Column]:
        mpa = Written("MPa", 1e-6)

        def _stress(name: str, values: Array) -> Column:
            largest = float(np.nanmax(self.amplitude, initial=0.0))
            return Column(name, values, "Pa", ".4g", mpa, 1e-6 * largest)

        return [
            Column("shaft", [shaft for shaft, *_ in self.sections]),
            Column("position", np.array([x for _, x, _ in self.sections]), "m"),
            Column("side", [side for *_, side in self.sections]),
            _stress("bending mean", self.bending[:, 0]),
            _stress("bending ±", self.bending[:, 1]),
            _stress("axial mean", self.axial[:, 0]),
            _stress("axial ±", self.axial[:, 1]),
            _stress("torsion mean", self.torsion[:, 0]),
            _stress("torsion ±", self.torsion[:, 1]),
            Column("notch", list(self.notches)),
            _stress("equivalent mean", self.mean),
            _stress("equivalent ±", self.amplitude),
            Column("utilisation", self.utilisation, "", ".3f"),
        ]

    def _heading(self) -> list[str]:
        return ["stresses in the turning shafts; ± is the amplitude"]

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting.analyses import stresses  # noqa: PLC0415

        shafts = list(dict.fromkeys(shaft for shaft, *_ in self.sections))
        own = {name: [i for i, (s, *_) in enumerate(self.sections) if s == name] for name in shafts}
        x = np.array([x for _, x, _ in self.sections])
        courses = {
            name: (x[i], self.amplitude[i], self.mean[i], self.utilisation[i])
            for name, i in own.items()
        }
        return stresses(courses, ax=ax)


@dataclass(frozen=True, eq=False)
class FibreStresses:
    """Mean and amplitude of the stresses of one section at all fibres, shape (fibres,) [Pa]."""

    bending_mean: Array
    bending: Array
    axial_mean: float
    axial: float
    #: Amplitude of bending and axial stress together.
    direct: Array
    torsion_mean: float
    torsion: float


@dataclass(frozen=True)
class Tones:
    """Section forces as sums of tones: mean values, and phasors with their frequencies."""

    #: N, Q_y, Q_z, M_y, M_z and T that stand still, shape (k, 6) [N, N m].
    standing: Array
    #: Phasors of the same, shape (sources, k, 6), and the frequency of each source [rad/s].
    phasors: ComplexArray
    frequencies: Array
    #: Spin of the shaft [rad/s].
    spin: float


def of_tones(tones: Tones, section: int, factors: Sequence[float]) -> FibreStresses:
    """Give the stresses that a turning shaft sees of forces in the fixed frame."""
    _, per_axial, per_bending, per_torque = factors
    spin, standing = tones.spin, tones.standing[section]
    # σ = −Im(M e^{−iψ}) r/I, the real part of i M e^{−iψ} r/I, with M = M_y + iM_z in the shaft.
    turned = 1j * per_bending * np.exp(-1j * FIBRES)
    bending = [(-spin, complex(standing[3], standing[4]) * turned)]
    axial: list[tuple[float, Any]] = [(0.0, per_axial * standing[0])]
    torsion: list[tuple[float, Any]] = [(0.0, per_torque * standing[5])]
    for rate, phasor in zip(tones.frequencies, tones.phasors[:, section], strict=True):
        bending.append((rate - spin, (phasor[3] + 1j * phasor[4]) / 2.0 * turned))
        bending.append((-rate - spin, np.conj(phasor[3] - 1j * phasor[4]) / 2.0 * turned))
        axial.append((rate, per_axial * phasor[0]))
        torsion.append((rate, per_torque * phasor[5]))
    bending_mean, bending_amplitude = _extremes(bending, spin)
    axial_mean, axial_amplitude = _extremes(axial, spin)
    torsion_mean, torsion_amplitude = _extremes(torsion, spin)
    _, direct = _extremes([*bending, *axial], spin)
    return FibreStresses(
        bending_mean=bending_mean,
        bending=bending_amplitude,
        axial_mean=float(axial_mean[0]),
        axial=float(axial_amplitude[0]),
        direct=direct,
        torsion_mean=float(torsion_mean[0]),
        torsion=float(torsion_amplitude[0]),
    )


def _extremes(tones: Iterable[tuple[float, Any]], spin: float) -> tuple[Array, Array]:
    """Give middle and half of the range of Σ Re(p e^{iνt}) for tones (ν, p), shape (fibres,)."""
    # Tones of whole multiples of the spin repeat after a turn, and are sampled. Others meet them,
    # and each other, at every phase, so that their amplitudes add up.
    given = list(tones)
    scale = max(*(abs(rate) for rate, _ in given), abs(spin)) or 1.0
    merged: dict[float, Any] = {}
    for rate, value in given:
        key = next((k for k in merged if abs(k - abs(rate)) <= _SAME * scale), abs(rate))
        merged[key] = merged.get(key, 0.0) + (value if rate >= 0.0 else np.conj(value))
    turn = np.zeros((1, _INSTANTS))
    apart = np.zeros(1)
    for rate, value in merged.items():
        column = np.reshape(value, (-1, 1))
        # A shaft at rest has no turn.
        order = round(rate / abs(spin)) if spin != 0.0 else 0
        if rate <= _SAME * scale:
            turn = turn + np.real(column)
        elif abs(rate - order * abs(spin)) <= _SAME * scale:
            angles = 2.0 * np.pi * order * np.arange(_INSTANTS) / _INSTANTS
            turn = turn + np.real(column * np.exp(1j * angles))
        else:
            apart = apart + np.abs(value)
    high, low = turn.max(axis=1), turn.min(axis=1)
    return (high + low) / 2.0, (high - low) / 2.0 + apart


def of_series(forces: Array, angle: Array, factors: Sequence[float]) -> FibreStresses:
    """Give the stresses of recorded section forces (times, 6) at angles of the shaft (times,)."""
    _, per_axial, per_bending, per_torque = factors
    moment = (forces[:, 3] + 1j * forces[:, 4]) * np.exp(-1j * angle)
    fibres = np.exp(-1j * FIBRES)
    bending = -per_bending * np.imag(moment[:, np.newaxis] * fibres)
    axial, torsion = per_axial * forces[:, 0], per_torque * forces[:, 5]
    direct = bending + axial[:, np.newaxis]

    def _middle(values: Array) -> Any:
        return (values.max(axis=0) + values.min(axis=0)) / 2.0

    def _half(values: Array) -> Any:
        return (values.max(axis=0) - values.min(axis=0)) / 2.0

    return FibreStresses(
        bending_mean=_middle(bending),
        bending=_half(bending),
        axial_mean=float(_middle(axial)),
        axial=float(_half(axial)),
        direct=_half(direct),
        torsion_mean=float(_middle(torsion)),
        torsion=float(_half(torsion)),
    )


def places_of(model: Model, shaft: str, notches: Sequence[Notch]) -> list[float] | None:
    """Give the positions of the sections of a shaft: its nodes, and notches between them."""
    own = [notch.position for notch in notches if notch.shaft == shaft]
    if not own:
        return None
    nodes = [x for (_, x, _), _ in model.sections(shaft)]
    return sorted({*nodes, *(x for x in own if np.abs(np.array(nodes) - x).min() > _STEP)})


def equivalent(
    each: FibreStresses, shaft: str, notch: Notch | None, strength: Strength
) -> tuple[Array, Array, Array]:
    """Give equivalent amplitude and mean [Pa] and utilisation at all fibres, shape (fibres,)."""
    by_bending, by_torsion = (1.0, 1.0) if notch is None else (notch.bending, notch.torsion)
    amplitude = np.hypot(by_bending * each.direct, np.sqrt(3.0) * by_torsion * each.torsion)
    mean = np.hypot(each.bending_mean + each.axial_mean, np.sqrt(3.0) * each.torsion_mean)
    return amplitude, mean, strength.utilisation(shaft, amplitude, mean, notch)


def stresses(
    self: Recorded,
    *,
    endurance_limit: float | Mapping[str, float] | None = None,
    tensile_strength: float | Mapping[str, float] | None = None,
    line: StrengthLine = "goodman",
    notches: Sequence[Notch] | None = None,
    skip_time: float = 0.0,
) -> Stresses:
    """Find mean and alternating stresses of the turning shafts from recorded section forces.

    The mean is the middle between the largest and the smallest stress of each fibre, the
    amplitude half of their difference. `section_forces` has the series for a count of cycles.

    Parameters
    ----------
    endurance_limit : float or mapping, optional
        Amplitude that a smooth specimen endures [Pa], as for `gearbow.RotorSystem.stresses`.
    tensile_strength : float or mapping, optional
        Tensile strength of the material [Pa].
    line : {"goodman", "din743"}
        How a mean stress lowers the endured amplitude.
    notches : sequence of Notch, optional
        Notches in place of those of the system.
    skip_time : float
        Time at the beginning that is ignored [s].

    Returns
    -------
    Stresses
        Stresses at the worst fibre of each recorded section.

    Raises
    ------
    GearbowError
        If the response does not know its system, or an argument is invalid.
    """
    run = self._to_record()
    description = run.asked("stresses").description
    names = [shaft["name"] for shaft in description["shafts"]]
    strength = Strength.of(names, endurance_limit, tensile_strength, line)
    own = parts_of({"notches": description.get("notches", ())})["notches"]
    marked = own if notches is None else parts(notches, Notch, "notches")
    begin = int(np.searchsorted(run.time, begin_after(run.time, skip_time)))
    shafts = run.recorded_shafts
    model, found = Model(dict(description)), []
    for shaft in shafts:
        sections, forces = access.section_forces(run, shaft)
        # A position may have two sections, one on each side.
        positions = list(dict.fromkeys(x for _, x, _side in sections))
        angle = access.angle(run, shaft)[begin:]
        known = dict(model.sections(shaft, positions))
        found += [
            (section, known[section], of_series(forces[begin:, k], angle, known[section]))
            for k, section in enumerate(sections)
        ]
    return collect(found, marked, strength, ())


def collect(
    found: Iterable[tuple[Section, Sequence[float], FibreStresses]],
    notches: Sequence[Notch],
    strength: Strength,
    left_out: Sequence[str],
) -> Stresses:
    """Choose the worst fibre of each section."""
    sections, factors, fibres = zip(*found, strict=True)
    rows: list[dict[str, Any]] = []
    for i, (section, each) in enumerate(zip(sections, fibres, strict=True)):
        shaft, x, _ = section
        notch = notch_at(notches, shaft, x)
        amplitude, mean, use = equivalent(each, shaft, notch, strength)
        worst = int(np.argmax(amplitude if np.isnan(use).any() else use))
        rows.append(
            {
                "fibre": FIBRES[worst],
                "bending": (each.bending_mean[worst], each.bending[worst]),
                "axial": (each.axial_mean, each.axial),
                "torsion": (each.torsion_mean, each.torsion),
                "amplitude": amplitude[worst],
                "mean": mean[worst],
                "utilisation": use[worst],
                "notches": _notch_text(notch, sections, factors, i),
            }
        )
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    names = tuple(columns.pop("notches").tolist())
    radii = np.array([radius for radius, *_ in factors])
    return Stresses(sections, radii, notches=names, left_out=tuple(left_out), **columns)


def notch_at(notches: Sequence[Notch], shaft: str, x: float) -> Notch | None:
    """Find the notch of a section; of several, the one with the largest factor of bending."""
    own = [each for each in notches if each.shaft == shaft and abs(each.position - x) <= _STEP]
    return max(own, key=lambda each: each.bending, default=None)


def _notch_text(
    notch: Notch | None,
    sections: Sequence[Section],
    factors: Sequence[Sequence[float]],
    index: int,
) -> str:
    """Write the notch factors of a section, or that none are given at a step of the diameter."""
    if notch is not None:
        return f"{notch.bending:g} / {notch.torsion:g}"
    place, radius = sections[index][:2], factors[index][0]
    steps = (
        abs(other[0] - radius) > _STEP * radius
        for section, other in zip(sections, factors, strict=True)
        if section[:2] == place
    )
    return "none given" if any(steps) else ""
