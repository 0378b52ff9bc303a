"""Harmonic responses: phasors at places and of sensors, and comparison with measured ones."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import one_of, positive
from gearbow._core import Model
from gearbow._result import Column, Figured, Result, WithSpeeds
from gearbow._shown import ReadOnly, short
from gearbow._types import Array, At, ComplexArray, Plain, Side
from gearbow.description.coordinates import Coordinates, time_derivatives
from gearbow.description.places import Places
from gearbow.errors import SceneError
from gearbow.results.at_places import Vibration
from gearbow.results.section_forces import Motions, SectionForces, harmonic_forces
from gearbow.sensors import SignalSensor
from gearbow.units.fields import MOTIONS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow.exchange.harmonic import MeasuredCurve


#: Largest number of places in a table, and in a figure without names.
PRINTED_PLACES = 3


class HarmonicResponse(WithSpeeds, Result, ReadOnly, Vibration[ComplexArray, ComplexArray]):
    """Phasors x of a motion: each source contributes the real part of x exp(iωt)."""

    coordinates: Coordinates
    description: Mapping[str, Plain]
    _bearings: tuple[tuple[str, float], ...]
    _bearing_force: ComplexArray
    _bearing_displacement: ComplexArray
    _meshes: tuple[tuple[str, str], ...]
    _mesh_force: ComplexArray

    @property
    @abstractmethod
    def _motion(self) -> ComplexArray:
        """Displacement of each degree of freedom, shape (..., sources, n)."""

    @property
    @abstractmethod
    def _rates(self) -> Array:
        """Angular frequency of each source [rad/s], shape (..., sources) or (..., 1)."""

    def _model(self) -> Model:
        """Compile the system again: a result is plain data, without the compiled model."""
        return Model(dict(self.description))

    def axial_displacement(self, at: At) -> ComplexArray:
        """Axial displacement of a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            Place, as for `displacement`.

        Returns
        -------
        ndarray, shape (...,)
            Phasors [m].

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no axial motion.
        """
        return self._at("axial", at)

    def mesh_force(self, at: str | tuple[str, str]) -> ComplexArray:
        """Dynamic force of a mesh normal to the teeth.

        Parameters
        ----------
        at : str or tuple of (str, str)
            The mesh, "driver/driven" or (driver, driven) in either order.

        Returns
        -------
        ndarray, shape (...,)
            Phasors (k + iωc)(δ − e)/cos β_b [N] with k, c, δ and e of the transverse section,
            positive where the drive flanks are pressed.
        """
        force: ComplexArray = self._mesh_force[..., Places.of("mesh", self._meshes).index(at)]
        return force

    def measure(self, sensor: SignalSensor) -> ComplexArray:
        """Signal of a sensor.

        Parameters
        ----------
        sensor : Probe or Accelerometer
            The sensor. Its run-out, a complex number, has a part in the synchronous response to its
            own shaft, and none in the response to another source.

        Returns
        -------
        ndarray, shape (...,)
            Phasors in the unit of the sensor.

        Raises
        ------
        SceneError
            If the sensor gives no signal, as a tachometer.
        GearbowError
            If the system has no such place, or not the motion that the sensor measures.
        """
        if not isinstance(sensor, SignalSensor):
            raise SceneError(f"sensor: must be a gb.Probe or gb.Accelerometer, got {sensor!r}")
        return self._signal(sensor)

    def radiated_power(
        self, housing: str, *, density: float = 1.204, sound_speed: float = 343.2
    ) -> Array:
        """Equivalent radiated power of the surface of an elastic housing.

        Parameters
        ----------
        housing : str
            Name of a housing that `Housing.from_matrices` made with a `surface`.
        density, sound_speed : float
            Density ρ [kg/m³] and speed of sound c [m/s] of the air, by default those at 20 °C.

        Returns
        -------
        ndarray, shape (...,)
            Power [W] of each source.

        Notes
        -----
        P = ρ c/2 ∫ abs(v)² dA with the amplitude v of the velocity along the normal: the power if
        every part of the surface radiates as a plane wave does (radiation efficiency 1). It is an
        upper estimate at low frequencies, where neighbouring parts cancel (Fritze, Marburg and
        Hardtke, *Estimation of radiated sound power*, Acta Acustica 95, 2009).

        Examples
        --------
        >>> import numpy as np
        >>> import gearbow as gb
        >>> cover = gb.Surface([[0, 1, 2]], [[0.0, 0.0, 0.02]])
        >>> housing = gb.Housing.from_matrices(
        ...     "housing", mass=5.0 * np.eye(3), stiffness=1e6 * np.eye(3), surface=cover,
        ...     interfaces={"seat": gb.Interface((0.0, 0.0, 0.0), rows=[0, 1, 2])},
        ...     highest_frequency=1000.0)
        >>> rotor = gb.Shaft("rotor", length=0.5, outer_diameter=0.05)
        >>> seats = [("housing", "seat"), None]
        >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=1e3, support=support)
        ...             for x, support in zip((0.0, 0.5), seats)]
        >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings, housings=[housing])
        >>> source = gb.Force(("rotor", 0.25), (0.0, 10.0))
        >>> response = system.frequency_response([300.0], source=source)
        >>> print(f"{1e6 * response.radiated_power('housing')[0, 0]:.2f} µW")
        97.48 µW
        """
        impedance = positive(density, "density") * positive(sound_speed, "sound_speed")
        surfaces = {
            each["name"]: each["elastic"]["radiation"]
            for each in self.description.get("housings", ())
            if "radiation" in each.get("elastic", {})
        }
        if not surfaces:
            raise SceneError(
                "housing: no housing of this system has a surface that radiates; make one by "
                "gb.Housing.from_matrices(surface=)"
            )
        surface = np.array(surfaces[one_of(housing, surfaces, "housing")], dtype=np.float64)
        moved = self._motion[..., self.coordinates.modes_of(housing)]
        mean_square = np.einsum("...h,hk,...k->...", moved.conj(), surface, moved).real
        power: Array = impedance / 2.0 * self._rates**2 * mean_square
        return power

    def _signal(self, sensor: Any) -> ComplexArray:
        """Give the phasors of the signal of a sensor."""
        signal: ComplexArray = sensor._sensed(self._at)
        return signal

    def _at(self, quantity: str, at: Any) -> ComplexArray:
        found: ComplexArray
        of_bearings = {
            "bearing_force": self._bearing_force,
            "bearing_displacement": self._bearing_displacement,
        }
        if quantity in of_bearings:
            i = Places.of("bearing", self._bearings).index(at)
            found = of_bearings[quantity][..., 2 * i : 2 * i + 2]
        elif quantity == "torque":
            found = self.section_forces(at).torque
        else:
            found = self.coordinates.motion(self._motion, quantity, at)
            power = time_derivatives(quantity)
            if power:
                along = quantity.startswith("axial")
                found = found * (1j * (self._rates if along else self._rates[..., None])) ** power
        return found

    @abstractmethod
    def _motions(self) -> Motions:
        """Give the motions with what their section forces depend on."""

    def _section_forces(self, at: At, side: Side) -> SectionForces:
        return harmonic_forces(self._model(), self.coordinates, self._motions(), at, side)


@dataclass(frozen=True, eq=False)
class FrequencyComparison(Figured, ReadOnly):
    """Measured curves, and the computed ones at the same frequencies.

    `plot` draws amplitudes above phases, the measured curves solid and the computed ones
    dashed; all curves have one quantity.

    Parameters
    ----------
    measured : tuple of MeasuredCurve
        The curves with `at`, `direction`, `quantity`, `frequencies` [rad/s] and `values`.
    computed : tuple of ndarray
        Values of the computed curves.

    Notes
    -----
    FRAC is the frequency response assurance criterion
    abs(Σ conj(H_m) H_c)²/(Σ abs(H_m)² Σ abs(H_c)²) of one curve over its frequencies (Heylen and
    Lammens, 1996). MAC is the same ratio of the shapes at one frequency, over the curves (Allemang
    and Brown, 1982). Both are 1 for proportional functions.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> frequencies = np.linspace(100.0, 1000.0, 50)
    >>> response = system.frequency_response(frequencies, source=gb.Force("disk", 1.0))
    >>> values = response.displacement("disk")[:, 0, 0]
    >>> curve = gb.results.MeasuredCurve("disk", "y", "displacement", frequencies, values)
    >>> print(f"{response.compare([curve]).frac[0]:.3f}")
    1.000
    """

    measured: "tuple[MeasuredCurve, ...]"
    computed: tuple[ComplexArray, ...]

    def _facts(self) -> dict[str, str]:
        return {"curves": short([one.label for one in self.measured]), "frac": short(self.frac)}

    def _columns(self) -> list[Column]:
        return [
            Column("curve", [one.label for one in self.measured]),
            Column("quantity", [one.quantity for one in self.measured]),
            Column("frequencies", [one.frequencies.size for one in self.measured]),
            Column("FRAC", self.frac, "", ".4f"),
        ]

    @property
    def frac(self) -> Array:
        """FRAC of each curve, from 0 to 1; shape (curves,)."""
        pairs = zip(self.measured, self.computed, strict=True)
        return np.array([_assurance(one.values, own, 0) for one, own in pairs])

    @property
    def mac(self) -> Array:
        """MAC of the measured and computed shapes at each frequency, from 0 to 1; shape (k,).

        Raises
        ------
        SceneError
            If the curves have different frequencies or quantities.
        """
        first = self.measured[0]
        for one in self.measured[1:]:
            same = np.array_equal(one.frequencies, first.frequencies)
            if not same or one.quantity != first.quantity:
                raise SceneError(
                    f"mac: a shape needs curves of one quantity at the same frequencies; "
                    f"{one.label!r} differs from {first.label!r}"
                )
        mac: Array = _assurance(
            np.array([one.values for one in self.measured]), np.array(self.computed), 0
        )
        return mac

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import harmonic as figures  # noqa: PLC0415

        quantities = {one.quantity for one in self.measured}
        if len(quantities) > 1:
            raise SceneError(f"plot: the curves have different quantities: {sorted(quantities)}")
        unit = MOTIONS[quantities.pop()]
        lines = {}
        for one, own, frac in zip(self.measured, self.computed, self.frac, strict=True):
            for name, values in (("measured", one.values), (f"computed (FRAC {frac:.3f})", own)):
                lines[f"{one.label}, {name}"] = figures.Curve.of(one.frequencies, values)
        return figures.bode(lines, unit, over="frequency", frf=True, pairs=True, ax=ax)


def _assurance(measured: Any, computed: Any, axis: int) -> Any:
    """Give |Σ m* c|²/(Σ|m|² Σ|c|²) over an axis; 0 where one is zero."""
    cross = np.abs(np.sum(np.conj(measured) * computed, axis=axis)) ** 2
    sizes = np.sum(np.abs(measured) ** 2, axis=axis) * np.sum(np.abs(computed) ** 2, axis=axis)
    return np.divide(cross, sizes, out=np.zeros_like(sizes), where=sizes > 0.0)
