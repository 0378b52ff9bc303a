"""Linear response to what turns with the shafts: amplitudes, phases, peaks, bearing forces."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, number
from gearbow._extras import extra
from gearbow._lookup import locate
from gearbow._read_only import ReadOnly
from gearbow._types import Array, At, ComplexArray
from gearbow.errors import ChannelError, GearbowError
from gearbow.peak import Peak, operating_range

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow.system import RotorSystem

__all__ = ["Synchronous", "synchronous"]


@dataclass(frozen=True, eq=False)
class Synchronous(ReadOnly):
    """Linear response to bow and unbalance, without time stepping.

    Every shaft s excites the whole train at its own speed r_s Ω: the motion is Σ_s Re(a_s exp(i r_s
    Ω t)).

    Parameters
    ----------
    speeds : ndarray, shape (speeds,)
        Speeds Ω of the reference shaft [rad/s].
    shafts : tuple of str
        The shafts as sources of excitation.
    amplitudes : ndarray, shape (speeds, shafts, n)
        Complex amplitudes a_s of each degree of freedom [m, rad].
    excitation : {"both", "bow", "unbalance"}
        What excites.
    slow_roll : float or None
        The speed [rad/s] whose amplitudes were taken off as run-out.
    system : RotorSystem
        The system that was asked.

    Examples
    --------
    A shaft that turns slowly runs out by its bow, and by more on the way to its critical speed:

    >>> import numpy as np
    >>> import gearbow as gb
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e9) for x in (0.0, 1.0)]
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=8, bow=bow)
    >>> response = gb.RotorSystem(shafts=[rotor], bearings=bearings).synchronous([1.0, 300.0])
    >>> np.abs(response.displacement(("rotor", 0.5))[:, 0, 0]).round(6)
    array([0.0001  , 0.000129])
    """

    speeds: Array
    shafts: tuple[str, ...]
    amplitudes: ComplexArray
    excitation: str
    slow_roll: float | None
    system: "RotorSystem" = field(repr=False)
    _bearings: tuple[tuple[str, float], ...] = field(repr=False)
    _bearing_force: ComplexArray = field(repr=False)
    _bow: ComplexArray = field(repr=False)

    def displacement(self, name: At) -> ComplexArray:
        """Complex amplitudes of the lateral displacement somewhere.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (speeds, shafts, 2)
            Amplitudes a of v and w [m] for each speed and each shaft as the source: shaft s adds
            Re(a exp(i r_s Ω t)).

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no lateral motion.
        """
        return self.amplitudes[:, :, self.system._lateral(name)]

    def twist(self, name: At) -> ComplexArray:
        """Complex amplitudes of the twist somewhere.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (speeds, shafts)
            Amplitudes [rad] for each speed and each shaft as the source.

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no twist.
        """
        return self.amplitudes[:, :, self.system._twist(name)]

    def orbit(self, name: At) -> Array:
        """Largest semi-axis of the orbit that each shaft causes somewhere.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (speeds, shafts)
            Semi-axis [m], the sum of the forward and the backward circle that an elliptic orbit is
            made of.
        """
        v, w = np.moveaxis(self.displacement(name), -1, 0)
        semi_axis: Array = (np.abs(v + 1j * w) + np.abs(v - 1j * w)) / 2.0
        return semi_axis

    def phase(self, name: At) -> Array:
        """Phase lead of the orbit that each shaft causes over the shaft's own angle.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (speeds, shafts)
            Phase [rad] between −π and π of the circle that turns with the exciting shaft: where the
            high spot is, from the zero of bow and unbalance. On isotropic bearings this circle is
            the orbit. It is NaN where there is no orbit.
        """
        v, w = np.moveaxis(self.displacement(name), -1, 0)
        # v = Re(a e^{iϑ}), w = Re(b e^{iϑ}): v + iw turns with the shaft by (a + ib) e^{iϑ}/2.
        circle = v + 1j * w
        phase: Array = np.where(circle == 0.0, np.nan, np.angle(circle))
        return phase

    def elastic(self, name: At) -> ComplexArray:
        """Complex amplitudes of the deflection that bends the shaft: displacement less its bow.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (speeds, shafts, 2)
            Amplitudes of v and w [m]. The bow is that of the shaft itself as the source, as far as
            it is asked for (`excitation` is not "unbalance").

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no lateral motion.
        """
        indices = self.system._lateral(name)
        elastic: ComplexArray = self.amplitudes[:, :, indices].copy()
        own = self.shafts.index(self.system.dofs[indices[0]][0])
        if self.excitation != "unbalance" and self.slow_roll is None:
            elastic[:, own] -= self._bow[indices]
        return elastic

    def bearing_force(self, shaft: str, position: float) -> ComplexArray:
        """Complex amplitudes of the force of a shaft on its bearing.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        ndarray, shape (speeds, shafts, 2)
            Amplitudes along y and z [N] for each speed and each shaft as the source.

        Raises
        ------
        ChannelError
            If there is no such bearing.
        """
        i = locate(self._bearings, shaft, position)
        if i is None:
            raise ChannelError(
                f"no bearing at ({shaft!r}, {position:g}); there are {list(self._bearings)}"
            )
        force: ComplexArray = self._bearing_force[:, :, 2 * i : 2 * i + 2]
        return force

    def subtract_slow_roll(self, speed: float) -> "Synchronous":
        """Take the amplitudes at a slow roll off all others, as one does with measured run-out.

        Parameters
        ----------
        speed : float
            Speed of the reference shaft [rad/s], far below the first critical speed.

        Returns
        -------
        Synchronous
            The response less that at the speed, each shaft's in its own turning frame; bearing
            forces stay what they are.

        Raises
        ------
        SceneError
            If the speed is impossible.
        """
        slow = number(speed, "speed")
        run_out = self.system._model.synchronous(np.array([slow]), self.excitation)["amplitudes"]
        return replace(self, amplitudes=self.amplitudes - run_out, slow_roll=slow)

    def peaks(
        self,
        name: At,
        source: str | None = None,
        *,
        operating: float | tuple[float, float] | None = None,
    ) -> list[Peak]:
        """Find the peaks of the orbit somewhere, with what API RP 684 asks of them.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).
        source : str, optional
            The shaft that excites; None is the shaft of the place.
        operating : float or tuple of (float, float), optional
            Operating speed, or the lowest and the highest, of the reference shaft [rad/s]; of one
            sign and not zero.

        Returns
        -------
        list of Peak
            The peaks that show on `speeds`, refined on the response itself. Each sense of rotation
            is searched from standstill on.

        Raises
        ------
        GearbowError
            If there is no such place or shaft.
        SceneError
            If the operating speeds are impossible.
        """
        indices = self.system._lateral(name)
        shaft = self.system.dofs[indices[0]][0] if source is None else source
        if shaft not in self.shafts:
            raise GearbowError(f"no shaft is called {shaft!r}; there are {list(self.shafts)}")
        span = operating_range(operating)
        found = self.system._model.peaks(
            np.unique(self.speeds),
            indices[0],
            self.shafts.index(shaft),
            self.excitation,
            self.slow_roll,
        )
        return [Peak(*row, operating=span) for row in found]

    def bode(self, names: At | Sequence[At], source: str | None = None) -> "Figure":
        """Draw amplitude and phase against the speed.

        Parameters
        ----------
        names : str, tuple of (str, float), or sequence of them
            A gear or disk by name, (shaft, position [m]), or several.
        source : str, optional
            The shaft that excites; None is the shaft of each place.

        Returns
        -------
        matplotlib.figure.Figure
            Phase above, the largest semi-axis of the orbits below.
        """
        with extra("plot"):
            from gearbow import frequency_plots  # noqa: PLC0415

        return frequency_plots.bode(self, names, source)

    def plot(self, names: At | Sequence[At]) -> "Figure":
        """Draw the largest semi-axis of the orbits against the speed.

        Parameters
        ----------
        names : str, tuple of (str, float), or sequence of them
            A gear or disk by name, (shaft, position [m]), or several.

        Returns
        -------
        matplotlib.figure.Figure
            One panel for each name, one line for each shaft as the source.
        """
        with extra("plot"):
            from gearbow import plots  # noqa: PLC0415

        return plots.synchronous(self, names)


def synchronous(
    system: "RotorSystem", speeds: ArrayLike, *, excitation: str = "both"
) -> Synchronous:
    """Find the linear response to bow and unbalance, without time stepping.

    Parameters
    ----------
    system : RotorSystem
        The system.
    speeds : array_like, shape (speeds,) or scalar
        Speeds of the reference shaft [rad/s].
    excitation : {"both", "bow", "unbalance"}
        What excites.

    Returns
    -------
    Synchronous
        Complex amplitudes for each speed and each shaft as the source.

    Raises
    ------
    SceneError
        If a speed or the excitation is impossible.
    """
    wanted = array(speeds, "speeds")
    data = system._model.synchronous(wanted, excitation)
    return Synchronous(
        speeds=wanted,
        shafts=tuple(system._model.shafts),
        amplitudes=data["amplitudes"],
        excitation=excitation,
        slow_roll=None,
        system=system,
        _bearings=tuple(data["bearings"]),
        _bearing_force=data["bearing_force"],
        _bow=data["bow"],
    )
