"""Steady-state response: one period of the motion, its multipliers and its files."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import number as number_of
from gearbow._core import Model, multipliers
from gearbow._progress import working
from gearbow._result import Column, WithSpeeds
from gearbow._types import At, ComplexArray, RunFigure, Side
from gearbow.errors import GearbowError
from gearbow.recording.container import any_number, each, number, optional, record, row, text, whole
from gearbow.recording.record import RunRecord
from gearbow.results.response import Response, Stored
from gearbow.results.section_forces import SectionForces

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Magnitude of the smallest multiplier that `SteadyState.multipliers` gives by default.
SMALLEST_MULTIPLIER = 0.9
#: Error of a multiplier. A motion with undamped modes, whose multipliers have the magnitude 1,
#: counts as stable.
_ERROR = 1e-6
#: Angle of a multiplier within which it counts as real [rad]: two real multipliers that meet have
#: angles of the square root of their error.
_REAL = 1e-3
#: Part of the record after which the multipliers of a motion without a period are given.
_PART = 0.1

#: Further entries of the metadata of a file.
_STEADY = record(
    period=any_number,
    residual=number,
    periods=whole,
    method=text,
    multipliers=optional(each(row(number, number))),
)


def instability(values: ComplexArray) -> str | None:
    """Name the instability of a periodic motion by its largest multiplier."""
    if not values.size:
        return None
    largest = values[np.argmax(np.abs(values))]
    if not abs(largest) > 1.0 + _ERROR:
        return None
    angle = abs(np.angle(largest))
    if angle < _REAL:
        return "fold"
    return "flip" if np.pi - angle < _REAL else "Neimark-Sacker"


class SteadyState(WithSpeeds, Stored):
    """The motion that repeats after each period, made by `gearbow.RotorSystem.steady_state`.

    Parameters
    ----------
    response : Response
        One period of the motion.
    data : mapping
        Period, residual, number of integrated periods and method.
    model : Model, optional
        The system; None builds it from the scene of the response when multipliers are needed.

    Attributes
    ----------
    response : Response
        One period of the motion, without the instant at its end. Without a period, a part of it.
    period : float
        Period [s]; infinite for a motion without a common period.
    residual : float
        Difference of the state after one more period, relative to the motion about the
        equilibrium, both in the energy norm, which is zero for no difference. It is measured by a
        run with the given tolerance. For a sum, the largest of them; for
        a quasi-periodic motion, the part of the state at the begin of the record that is transient.
    periods : int
        Number of periods that the solution integrated, with the recorded ones; without a common
        period, of those of the slowest source.
    method : {"linear", "nonlinear", "superposition", "quasi-periodic"}
        Whether the state after a period is an affine function of the state before; or how a motion
        without a common period was found: as a sum of motions, or by running in.

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4, bow=bow)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=1e3) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> steady = system.steady_state(100.0, record=[("rotor", 0.5)])
    >>> print(f"{steady.period:.4f} s, stable: {steady.is_stable()}")
    0.0628 s, stable: True
    """

    _indexed = True

    def __init__(
        self, response: Response, data: dict[str, Any], model: Model | None = None
    ) -> None:
        self.response = response
        self.period: float = data["period"]
        self.residual: float = data["residual"]
        self.periods: int = data["periods"]
        self.method: str = data["method"]
        # The orders of the response follow from the period.
        response.period = self.period if math.isfinite(self.period) else None
        self.speed_unit = response.speed_unit
        self._model = model
        found = data.get("multipliers")
        self._multipliers = None if found is None else np.array([complex(*z) for z in found])

    def multipliers(self, magnitude: float = SMALLEST_MULTIPLIER) -> ComplexArray:
        """Compute the Floquet multipliers, the largest first.

        They are the eigenvalues of the derivative of the state after a period with respect to the
        state before; for a motion without a period, after a tenth of the record. The rigid-body
        rotation of a train that nothing holds is left out. Modes that the run left out have the
        multipliers e^{λT} of the linear system. Those of the default magnitude are kept, and saved
        with the motion.

        Parameters
        ----------
        magnitude : float
            Smallest magnitude. The smaller it is, the more periods the computation takes.

        Returns
        -------
        ndarray, shape (m,)
            Complex multipliers.

        Raises
        ------
        ConvergenceError
            If a multiplier is not accurate.
        GearbowError
            If the motion does not know its system.
        """
        smallest = number_of(magnitude, "magnitude")
        if smallest != SMALLEST_MULTIPLIER:
            return self._computed(smallest)
        if self._multipliers is None:
            self._multipliers = self._computed(smallest)
        found: ComplexArray = self._multipliers.copy()
        return found

    def _computed(self, smallest: float) -> ComplexArray:
        """Compute the multipliers from a magnitude on."""
        request = self.response.request
        if request is None:
            raise GearbowError(
                "multipliers: this motion does not know its system; take that of steady_state"
            )
        model = self._model or Model(dict(request.description))
        options = dict(request.options)
        if math.isinf(self.period):
            options["duration"] *= _PART
        with working(None, "multipliers"):
            return multipliers(model, **options, smallest=smallest, progress=None)

    def section_forces(self, at: At, side: Side = "before") -> SectionForces:
        """Section forces of a shaft over the recorded period, as `Response.section_forces`.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, (shaft, position [m]), or the name of a shaft.
        side : {"before", "beyond"}
            Side of a node.

        Returns
        -------
        SectionForces
            N, Q_y, Q_z, M_y, M_z and T at each time.
        """
        return self.response.section_forces(at, side)

    def is_stable(self) -> bool:
        """Return whether small disturbances decay.

        Returns
        -------
        bool
            Whether none of the `multipliers` lies outside the unit circle. A motion that ran in
            has shown it: the difference of two runs has decayed.
        """
        return self.instability() is None

    def instability(self) -> str | None:
        """Name the kind of the instability.

        Returns
        -------
        str or None
            "fold", "flip", "Neimark-Sacker", or None for a stable motion, as each one is that ran
            in.
        """
        if self.method == "quasi-periodic":
            return None
        return instability(self.multipliers())

    def plot(self, kind: RunFigure = "orbits", at: Any = None, *, ax: Any = None) -> "Figure":
        """Draw recorded signals over one period, as `Response.plot`.

        Parameters
        ----------
        kind : str
            Kind of the figure, for example "orbits" or "mesh".
        at : str, tuple or sequence of them, optional
            Places or meshes; None is all.
        ax : Axes or sequence of Axes, optional
            One panel for each place, for a mesh three; None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            The figure. It is neither shown nor saved.
        """
        return self.response.plot(kind, at, ax=ax)

    def _stored(self) -> tuple[RunRecord, dict[str, Any]]:
        found = self._multipliers
        steady = {
            "period": self.period,
            "residual": self.residual,
            "periods": self.periods,
            "method": self.method,
            "multipliers": None if found is None else [[z.real, z.imag] for z in found.tolist()],
        }
        return self.response._to_record(), {"steady": steady}

    @classmethod
    def _restored(cls, run: RunRecord, about: dict[str, Any], path: Any) -> "SteadyState":
        if "steady" not in about:
            raise GearbowError(f"{path}: is a response, not a steady state; use Response.load")
        _STEADY(about["steady"], "steady")
        return cls(Response._from_record(run), about["steady"])

    def __getstate__(self) -> dict[str, Any]:
        # The response knows the scene, from which the model can be built again.
        return {**self.__dict__, "_model": None}

    def __repr__(self) -> str:
        return (
            f"SteadyState(period {self.period:g} s, residual {self.residual:.1e}, "
            f"{self.response.time.size} times)"
        )

    def _heading(self) -> list[str]:
        """Give period, method and residual, and the stability if it is known."""
        state = ""
        if self._multipliers is not None:
            state = "; stable" if self.is_stable() else f"; unstable: {self.instability()}"
        period = "without a common period" if math.isinf(self.period) else f"{self.period:.6g} s"
        return [
            f"steady state: period {period}, {self.method}, residual {self.residual:.1e}{state}",
            *self.response._heading(),
        ]

    def _columns(self) -> list[Column]:
        return self.response._columns()

    def _series(self) -> list[Column]:
        return self.response._series()
