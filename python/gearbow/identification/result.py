"""Estimates of bow, unbalance, run-out and parameters, and what the data say about them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import nearest, text
from gearbow._result import Column, Figured, WithSpeeds, in_degrees
from gearbow._shown import ReadOnly, Shown, listed, short
from gearbow._types import Array, At, ComplexArray
from gearbow.analysis.protocol import S
from gearbow.errors import GearbowError
from gearbow.identification.correction import Correction, correct
from gearbow.identification.measurement import Measurement
from gearbow.identification.responses import LinearModel
from gearbow.units.speed import in_given_unit, speed_factor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Units in which tables write estimates, and their factors.
_WRITTEN = {"m": ("µm", 1e6), "kg m": ("g mm", 1e6)}
#: Smallest probability of the χ² of a probe without a remark.
_UNLIKELY = 0.01


@dataclass(frozen=True)
class ProbeResidual(Shown):
    """What the fit leaves of the vibration at one probe.

    Parameters
    ----------
    probe : str
        Label of the probe.
    rms : float
        RMS of a component of the residual [m].
    chi_squared : float
        Sum of the squares of the residual over the noise.
    degrees_of_freedom : float
        Expected value of this sum: the components of the probe minus their share of the unknowns.
    probability : float
        Probability of a larger sum if model and noise are right; small where the model is wrong.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.results.ProbeResidual("probe input at 0.2 m, 0°", 1e-6, 61.0, 56.5, 0.32)
    ProbeResidual(probe='probe input at 0.2 m, 0°', rms=1e-06, chi_squared=61.0, ...)
    """

    probe: str
    rms: float
    chi_squared: float
    degrees_of_freedom: float
    probability: float


@dataclass(frozen=True, eq=False)
class Identification(WithSpeeds, Figured, ReadOnly, Generic[S]):
    """Unknowns of a system, estimated from measured 1× vibration.

    `plot` has five panels: measured and fitted phase and amplitude over the speed, vectors in
    the complex plane, residuals over the noise, and estimates with 95 % ellipses relative to
    their detectable amplitude.

    Parameters
    ----------
    names, units : tuple of str
        Names of the unknowns, for example "bow of input, half wave 1", and their units.
    values : ndarray, shape (unknowns,)
        Complex amplitudes; their argument is the angle in the shaft. Parameters are real. A
        combination that data and priors do not determine is zero.
    components : tuple of str
        Names of the components: real and imaginary part of an amplitude, or a parameter.
    estimates : ndarray, shape (components,)
        The components.
    covariance : ndarray, shape (components, components)
        Covariance of the components; infinite for one that the data do not determine.
    factor : float
        Half width of a 95 % interval over the standard deviation.
    singular_values : ndarray, shape (components,)
        Of the responses to unknowns of the size that alone causes the largest measured amplitude,
        over the noise, and of the priors; descending. The inverse of one is the standard deviation
        of its combination in units of this size.
    inseparable : tuple of str
        Combinations of unknowns that data and priors cannot separate: their 95 % interval contains
        values that alone would explain the whole vibration.
    detectable : ndarray, shape (unknowns,)
        Smallest amplitude that these probes, speeds and this noise would show in 95 % of all
        measurements, by a test that finds one where there is none in 5 %.
    noise : ndarray, shape (channels,)
        Standard deviation of a component of the measured amplitudes of each probe [m].
    noise_is_estimated : bool
        Whether the noise follows from the residual. The χ² of all probes then agrees by definition.
    probes : tuple of ProbeResidual
        Residual of each probe.
    measurements : tuple of Measurement
        The measurements.
    fitted : tuple of ndarray, shape (speeds, probes) each
        Fitted amplitudes [m]; NaN where none was measured.
    system : RotorSystem
        The system with the identified values.
    left_out : tuple of str
        Excitations of the system that the model of the vibration does not contain.

    Notes
    -----
    Intervals are those of the linearised model with normally distributed noise. They do not contain
    errors of the model: a wrong bearing is visible only where it shifts the vibration by more than
    the noise.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> measured = gb.Measurement([10.0, 200.0], [[50e-6], [85e-6]], [gb.Probe("rotor", 0.23)])
    >>> found = gb.identify(system, measured, [gb.unknown.bow("rotor")], runout=False, noise=1e-6)
    >>> found.names, f"{1e6 * found.half_widths[0, 0]:.1f} µm"
    (('bow of rotor, half wave 1',), '1.1 µm')
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: ComplexArray
    components: tuple[str, ...]
    estimates: Array
    covariance: Array
    factor: float
    singular_values: Array
    inseparable: tuple[str, ...]
    detectable: Array
    noise: Array
    noise_is_estimated: bool
    probes: tuple[ProbeResidual, ...]
    measurements: tuple[Measurement, ...]
    fitted: tuple[ComplexArray, ...]
    system: S = field(repr=False)
    left_out: tuple[str, ...] = ()
    _model: LinearModel[S] | None = field(repr=False, default=None)

    @property
    def standard_deviations(self) -> Array:
        """Standard deviation of each component, in its unit; shape (components,)."""
        deviations: Array = np.sqrt(np.diag(self.covariance))
        return deviations

    @property
    def intervals(self) -> Array:
        """Lower and upper limit of the 95 % interval of each component, shape (components, 2)."""
        half = self.factor * self.standard_deviations
        return np.column_stack([self.estimates - half, self.estimates + half])

    @property
    def correlation(self) -> Array:
        """Correlation of the components, shape (components, components).

        Values are between −1 and 1; zero for a component with an infinite variance.
        """
        deviations = self.standard_deviations
        with np.errstate(invalid="ignore"):
            found = self.covariance / np.outer(deviations, deviations)
        found[~np.isfinite(found)] = 0.0
        np.fill_diagonal(found, 1.0)
        return found

    @property
    def half_widths(self) -> Array:
        """Half width of the 95 % interval of each amplitude and of its angle, shape (unknowns, 2).

        The units are that of the unknown, along the amplitude, and rad, across it. The angle is
        unknown (π) where the interval contains zero; it is NaN for a parameter.
        """
        found = np.full((len(self.names), 2), np.nan)
        for j, (value, own) in enumerate(zip(self.values, self._groups(), strict=True)):
            block = self.covariance[np.ix_(own, own)]
            if len(own) == 1:
                found[j, 0] = self.factor * np.sqrt(block[0, 0])
                continue
            unit = value / abs(value) if value else 1.0
            along = np.array([np.real(unit), np.imag(unit)])
            across = np.array([-np.imag(unit), np.real(unit)])
            if not np.isfinite(block).all():
                found[j] = np.inf, np.pi
                continue
            found[j, 0] = self.factor * np.sqrt(along @ block @ along)
            sideways = self.factor * np.sqrt(across @ block @ across)
            found[j, 1] = np.pi if sideways >= abs(value) else np.arcsin(sideways / abs(value))
        return found

    def _groups(self) -> list[list[int]]:
        groups, next_one = [], 0
        for i in range(len(self.names)):
            own = self.components[next_one] != self.names[i]
            groups.append([next_one, next_one + 1] if own else [next_one])
            next_one += 1 + own
        return groups

    def value(self, name: str) -> complex:
        """Give the estimate of an unknown by its name.

        Parameters
        ----------
        name : str
            A name of `names`.

        Returns
        -------
        complex
            The estimate.
        """
        if text(name, "name") not in self.names:
            raise GearbowError(
                f"no unknown is called {name!r}; there are {', '.join(self.names)}"
                f"{nearest(name, self.names)}"
            )
        return complex(self.values[self.names.index(name)])

    @in_given_unit
    def balance(
        self,
        planes: At | Sequence[At],
        speeds: "ArrayLike",
        *,
        points: At | Sequence[At] | None = None,
    ) -> Correction[S]:
        """Find balancing weights for the identified system, and what they will leave.

        Parameters
        ----------
        planes : str, tuple of (str, float), or sequence of them
            Balancing planes on one shaft: gears, disks or (shaft, position [m]).
        speeds : array_like, shape (speeds,) or scalar
            Speeds of the reference shaft [rad/s], not zero.
        points : str, tuple of (str, float), or sequence of them, optional
            Where the vibration shall be small; None is the places of the probes beside this shaft.

        Returns
        -------
        Correction
            Weights, the expected residual with its interval, and the system with the weights. Run-
            out of probes is no vibration and is not balanced.
        """
        return correct(self, planes, speeds, points)

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import harmonic as figures  # noqa: PLC0415

        return figures.identification(
            [speed_factor() * each.speeds for each in self.measurements],
            [dict(zip(each.labels, each.amplitudes.T, strict=True)) for each in self.measurements],
            [each.T for each in self.fitted],
            {one.probe: noise for one, noise in zip(self.probes, self.noise, strict=True)},
            self._ellipses(),
            ax=ax,
        )

    def _ellipses(self) -> dict[str, tuple[ComplexArray, float]]:
        """Give the boundary of the 95 % region and the detectable size of each amplitude."""
        turn = np.exp(2j * np.pi * np.linspace(0.0, 1.0, 73))
        found = {}
        for j, own in enumerate(self._groups()):
            block = self.covariance[np.ix_(own, own)]
            if len(own) == 2 and np.isfinite(block).all():
                sizes, vectors = np.linalg.eigh(block)
                # χ² with two degrees of freedom is below −2 ln 0.05 in 95 %.
                root = vectors * np.sqrt(np.maximum(sizes, 0.0) * -2.0 * np.log(0.05))
                y, z = root @ np.array([turn.real, turn.imag])
                found[self.names[j]] = (self.values[j] + y + 1j * z, float(self.detectable[j]))
        return found

    def to_dict(self) -> dict[str, Any]:
        """Give the result as plain data, for JSON.

        Returns
        -------
        dict
            Estimates with intervals, covariance, correlation, singular values, inseparable
            combinations, noise, and residuals of the probes. Infinite numbers are None.
        """
        half = self.half_widths
        unknowns = [
            {
                "name": name,
                "unit": unit,
                "re": float(value.real),
                "im": float(value.imag),
                "half_width": _finite(half[j, 0]),
                "half_width_of_angle": _finite(half[j, 1]),
                "detectable": _finite(self.detectable[j]),
            }
            for j, (name, unit, value) in enumerate(
                zip(self.names, self.units, self.values.tolist(), strict=True)
            )
        ]
        return {
            "unknowns": unknowns,
            "components": list(self.components),
            "intervals": _finite(self.intervals),
            "covariance": _finite(self.covariance),
            "correlation": _finite(self.correlation),
            "singular_values": _finite(self.singular_values),
            "inseparable": list(self.inseparable),
            "noise": _finite(self.noise),
            "noise_is_estimated": self.noise_is_estimated,
            "probes": [dict(vars(one)) for one in self.probes],
        }

    def _facts(self) -> dict[str, str]:
        return {
            "unknowns": short(self.names),
            "inseparable": str(len(self.inseparable)),
            "noise": f"{listed(1e6 * self.noise, '.3g')} µm",
        }

    def _heading(self) -> list[str]:
        rows = sum(int(np.isfinite(each.amplitudes).sum()) for each in self.measurements)
        origin = "estimated" if self.noise_is_estimated else "given"
        noise = listed(1e6 * np.unique(self.noise), ".3g")
        source = f"identification from {rows} amplitudes of {len(self.probes)} probes"
        return [f"{source}, noise {noise} µm ({origin}); intervals of 95 %"]

    def _columns(self) -> list[Column]:
        """Give a row for each unknown, each in its own unit."""
        written = [_WRITTEN.get(unit, (unit, 1.0)) for unit in self.units]
        factors = np.array([factor for _, factor in written])
        half = self.half_widths
        angles = np.where(np.isnan(half[:, 1]), np.nan, np.angle(self.values))
        return [
            Column("unknown", list(self.names)),
            Column("estimate", factors * self._sizes(), "", ".5g"),
            Column("±", factors * half[:, 0], "", ".2g"),
            Column("unit", [unit for unit, _ in written]),
            Column("angle", angles, "rad", ".1f", in_degrees()),
            Column("± angle", half[:, 1], "rad", ".1f", in_degrees()),
            Column("detectable", factors * self.detectable, "", ".2g"),
        ]

    def _series(self) -> list[Column]:
        half = self.half_widths
        return [
            Column("unknown", list(self.names)),
            Column("unit", list(self.units)),
            Column("re", self.values.real),
            Column("im", self.values.imag),
            Column("size", self._sizes()),
            Column("half_width", half[:, 0]),
            Column("angle", np.angle(self.values), "rad"),
            Column("half_width_of_angle", half[:, 1], "rad"),
            Column("detectable", self.detectable),
        ]

    def _sizes(self) -> Array:
        """Give amplitudes, and parameters with their sign."""
        singles = np.array([len(own) == 1 for own in self._groups()])
        return np.where(singles, self.values.real, np.abs(self.values))

    def _remarks(self) -> list[str]:
        found = [f"not separable: {each}" for each in self.inseparable]
        for one in self.probes:
            if one.probability < _UNLIKELY:
                found.append(
                    f"{one.probe}: the residual of {1e6 * one.rms:.3g} µm RMS does not agree with "
                    f"the noise: χ² = {one.chi_squared:.4g}, expected {one.degrees_of_freedom:.4g}"
                )
        return found


def _finite(values: Any) -> Any:
    """Convert to plain numbers, None for infinite ones."""
    plain = np.asarray(values, dtype=np.float64)
    return np.where(np.isfinite(plain), plain, None).tolist()  # type: ignore[call-overload]
