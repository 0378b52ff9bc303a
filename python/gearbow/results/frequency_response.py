"""Harmonic response at any frequency: phasors of displacements, forces and sensors."""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, get_args

import numpy as np

from gearbow._convert import items, one_of, shown
from gearbow._extras import extra
from gearbow._files import check_name, replacing
from gearbow._result import Column, Written, data_frame
from gearbow._shown import short, span
from gearbow._types import (
    Array,
    At,
    ComplexArray,
    FrequencyFigure,
    FrequencyQuantity,
    LateralDirection,
    Plain,
)
from gearbow.description.coordinates import Coordinates, time_derivatives
from gearbow.description.loads import plain_sources
from gearbow.description.places import is_pair, place, place_label, places
from gearbow.errors import GearbowError, SceneError
from gearbow.results.harmonic import PRINTED_PLACES, FrequencyComparison, HarmonicResponse
from gearbow.results.section_forces import Motions
from gearbow.sensors import SignalSensor
from gearbow.units.fields import QUANTITIES
from gearbow.units.speed import SpeedUnit, speed_text

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from gearbow.exchange.harmonic import Curve, MeasuredCurve


@dataclass(frozen=True, eq=False)
class FrequencyResponse(HarmonicResponse):
    """Harmonic response of a system to one or several sources.

    All results are phasors x: the physical value is the real part of x exp(iωt), so that all
    amplitudes are zero to peak. The first axes of all values are those of `frequencies`, k in the
    shapes below, which stands for both of them where there are two, and the sources.

    Parameters
    ----------
    frequencies : ndarray, shape (k,) or (speeds, k)
        Frequencies ω [rad/s].
    speeds : ndarray, of the same shape
        Speed of the reference shaft at each frequency [rad/s].
    sources : tuple of str
        Labels of the sources.
    phasors : ndarray, shape (k, sources, n)
        Displacement of each degree of freedom [m, rad].
    residuals : ndarray, of the shape of the frequencies
        Largest relative residual of the equations of motion over the sources, as in `Synchronous`.
    axes : tuple of str
        Names of the first axes of all results: "frequency", "speed" or "order".
    coordinates : Coordinates
        Degrees of freedom of the system.
    description : mapping
        The plain system.
    left_out : tuple of str
        Excitations that a response to a `gb.ShaftExcitation` lacks; empty without one.

    Examples
    --------
    A rotor on bearings, hit in its middle:

    >>> import numpy as np
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e7, damping=100.0) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> hit = gb.Force(("rotor", 0.5), 1.0)
    >>> response = system.frequency_response([1.0, 600.0], source=hit)
    >>> np.abs(response.displacement(("rotor", 0.5))[:, 0, 0]).round(9)
    array([3.780e-07, 2.672e-06])
    """

    frequencies: Array
    speeds: Array
    sources: tuple[str, ...]
    phasors: ComplexArray
    residuals: Array
    axes: tuple[str, ...]
    coordinates: Coordinates = field(repr=False)
    description: Mapping[str, Plain] = field(repr=False)
    _sources: list[dict[str, Plain]] = field(repr=False)
    _bearings: tuple[tuple[str, float], ...] = field(repr=False)
    _bearing_force: ComplexArray = field(repr=False)
    _bearing_displacement: ComplexArray = field(repr=False)
    _meshes: tuple[tuple[str, str], ...] = field(repr=False)
    _mesh_force: ComplexArray = field(repr=False)
    left_out: tuple[str, ...] = ()

    _own_endings: ClassVar[tuple[str, ...]] = (".uff", ".mat")

    def _facts(self) -> dict[str, str]:
        return {
            "frequencies": f"{self.frequencies.size}, {span(self.frequencies)} rad/s",
            "speeds": self._speed_text(self.speeds),
            "sources": short(self.sources),
        }

    @property
    def _motion(self) -> ComplexArray:
        return self.phasors

    @property
    def _rates(self) -> Array:
        return self.frequencies[..., np.newaxis]

    def _motions(self) -> Motions:
        def _bowed(shaft: str) -> list[bool]:
            return [
                source.get("shaft") == shaft and source.get("excitation") in ("both", "bow")
                for source in self._sources
            ]

        speeds = np.broadcast_to(self.speeds, self.frequencies.shape)[..., np.newaxis]
        return Motions(self.phasors, self._rates, speeds, _bowed)

    def plot(
        self,
        at: Any,
        quantity: FrequencyQuantity = "displacement",
        *,
        direction: LateralDirection | None = None,
        kind: FrequencyFigure = "bode",
        ax: Any = None,
        speed_unit: SpeedUnit | None = None,
    ) -> "Figure":
        """Draw the response of places.

        Parameters
        ----------
        at : str, tuple, sensor, or sequence of them
            Places, meshes or sensors.
        quantity : {"displacement", "velocity", "acceleration", "twist", "bearing_force"}
            What to draw of the places. A mesh has its force, and a sensor its signal.
        direction : {"y", "z"}, optional
            Direction of a lateral quantity; None is the one with the larger response.
        kind : {"bode", "nyquist", "waterfall"}
            Amplitude and phase over the frequency; the curve in the complex plane; or amplitudes
            over frequency and speed, of a response with both axes.
        ax : Axes or sequence of Axes, optional
            Two panels for "bode", one for the others; None makes a new figure.
        speed_unit : str, optional
            Unit of speeds, as for `table`; None is that of the given ones.

        Returns
        -------
        matplotlib.figure.Figure
            The figure. It is neither shown nor saved.

        Raises
        ------
        GearbowError
            If there is no such place, or the response has not the axes of a waterfall.
        """
        with extra("plot"):
            from gearbow.plotting import harmonic  # noqa: F401, PLC0415  # as the figure does

        one_of(kind, get_args(FrequencyFigure), "kind")
        lines, unit = self._lines(at, quantity, direction)
        with self._showing(speed_unit):
            return self._figure(kind, lines, unit, ax)

    def _figure(self, kind: str, lines: Mapping[str, ComplexArray], unit: str, ax: Any) -> "Figure":
        from gearbow.plotting import harmonic as figures  # noqa: PLC0415

        two = self.frequencies.ndim == 2
        if kind == "waterfall":
            if self.axes != ("speed", "frequency"):
                raise GearbowError(
                    "plot: a waterfall needs a response at several speeds; give "
                    "frequency_response(frequencies, speed=[...])"
                )
            name, values = next(iter(lines.items()))
            return figures.waterfall(
                self.frequencies[0], self.speeds[:, 0], np.abs(values), name, unit, ax=ax
            )
        if two:
            parts = {
                f"{name}, {text}": figures.Curve.of(own, values[index])
                for name, values in lines.items()
                for text, index, own in self._rows_of_axes()
            }
        else:
            along = self.speeds if self.axes == ("speed",) else self.frequencies
            parts = {name: figures.Curve.of(along, values) for name, values in lines.items()}
        if kind == "nyquist":
            return figures.polar(parts, unit, ax=ax)
        over = "frequency" if self.axes[-1] == "frequency" else "speed"
        return figures.bode(parts, unit, over=over, frf=True, ax=ax)

    def _rows_of_axes(self) -> Iterator[tuple[str, Any, Array]]:
        """Give label, index and horizontal axis of each line of a response with two axes."""
        if self.axes == ("speed", "frequency"):
            for i, speed in enumerate(self.speeds[:, 0]):
                yield speed_text(speed, form="g"), i, self.frequencies[i]
        else:
            with np.errstate(invalid="ignore"):
                orders = np.nanmax(self.frequencies / self.speeds, axis=0)
            for j, order in enumerate(orders):
                yield f"{order:g}×", (slice(None), j), self.speeds[:, j]

    def _lines(
        self, at: Any, quantity: str, direction: LateralDirection | None
    ) -> tuple[dict[str, ComplexArray], str]:
        """Give label and phasors of each place and source, and their unit."""
        one_of(quantity, get_args(FrequencyQuantity), "quantity")
        if direction is not None:
            one_of(direction, get_args(LateralDirection), "direction")
        single = isinstance(at, (str, SignalSensor)) or (isinstance(at, tuple) and len(at) == 2)
        found: dict[str, ComplexArray] = {}
        units = set()
        listed = [at] if single else items(at, "at", "places, meshes and sensors")
        if not listed:
            raise SceneError("at: must name at least one place, mesh or sensor")
        for one in listed:
            if isinstance(one, SignalSensor):
                label, unit, values = one.label, one.unit, self.measure(one)
            elif is_pair(place(one)):
                label, unit, values = f"mesh {'/'.join(place(one))}", "N", self.mesh_force(one)
            else:
                unit, values = QUANTITIES[quantity], self._at(quantity, one)
                label = place_label(place(one))
                if quantity != "twist":
                    axis = (
                        direction
                        or "yz"[int(np.argmax(np.abs(values).max((*range(values.ndim - 1),))))]
                    )
                    label, values = f"{label}, {axis}", values[..., "yz".index(axis)]
            units.add(unit)
            for number, source in enumerate(self.sources):
                due = f", {source}" if len(self.sources) > 1 else ""
                found[label + due] = values[..., number]
        if len(units) > 1:
            raise SceneError(f"at: one figure has one unit, got {', '.join(sorted(units))}")
        return found, units.pop()

    def _curves(self, at: Sequence[At] | None = None) -> "list[Curve]":
        """Give the curves of places, or of everything that has a name."""
        from gearbow.exchange.harmonic import Curve  # noqa: PLC0415

        coordinates = self.coordinates
        named = [*coordinates.bodies, *coordinates.points, *coordinates.seats]
        at_bodies = set(coordinates.bodies.values())
        own = [bearing for bearing in self._bearings if bearing not in at_bodies]
        curves = []
        for one in [*named, *own] if at is None else places(at):
            for kind, unit, directions in (
                ("displacement", "m", ("y", "z")),
                ("twist", "rad", ("twist",)),
                ("axial_displacement", "m", ("x",)),
            ):
                try:
                    values = getattr(self, kind)(one)
                except SceneError:
                    if at is not None and kind == "displacement":
                        raise
                    continue
                except GearbowError:
                    continue
                for i, direction in enumerate(directions):
                    part = values[..., i] if kind == "displacement" else values
                    curves.append(Curve(one, "displacement", direction, unit, part))
        if at is None:
            for bearing in self._bearings:
                force = self.bearing_force(bearing)
                for i, direction in enumerate("yz"):
                    curves.append(Curve(bearing, "bearing force", direction, "N", force[..., i]))
            for mesh in self._meshes:
                curves.append(Curve(mesh, "mesh force", "mesh", "N", self.mesh_force(mesh)))
        return curves

    def to_dataframe(self, at: Any = None) -> "pd.DataFrame":
        """Give the response as a table with one row for each frequency and source.

        Parameters
        ----------
        at : str, tuple of (str, float), or sequence of them, optional
            Places; None is all gears, disks, supports, housings, bearings and meshes.

        Returns
        -------
        pandas.DataFrame
            Frequency, speed and source, and complex columns with their unit.
        """
        curves = self._curves(at)
        columns = [Column(curve.name, curve.values.ravel(), curve.unit) for curve in curves]
        return data_frame([*self._axis_columns(), *columns])

    def to_xarray(self, at: Any = None) -> "xr.Dataset":
        """Give the response as a data set.

        Parameters
        ----------
        at : str, tuple of (str, float), or sequence of them, optional
            As for `to_dataframe`.

        Returns
        -------
        xarray.Dataset
            One complex variable for each curve over the `axes` and the source, with its unit.
        """
        return self._curve_dataset(at, parts=False)

    def _dataset(self, at: Any = None) -> "xr.Dataset":
        return self._curve_dataset(at, parts=True)

    def _curve_dataset(self, at: Any, *, parts: bool) -> "xr.Dataset":
        from gearbow.exchange import harmonic  # noqa: PLC0415

        coordinates = {"frequency": self.frequencies, "speed": self.speeds}
        if self.axes == ("speed", "frequency"):
            coordinates = {"frequency": self.frequencies[0], "speed": self.speeds[:, 0]}
        elif self.axes == ("speed", "order"):
            coordinates = {"speed": self.speeds[:, 0], "angular_frequency": self.frequencies}
        return harmonic.to_xarray(
            self._curves(at), self.axes, coordinates, self.sources, parts=parts
        )

    def save(self, path: str | os.PathLike[str], at: Any = None) -> None:
        """Write the curves of places to a file, whose suffix means the format.

        Parameters
        ----------
        path : str or path-like
            ".nc" is netCDF (extra "netcdf"), in which a dimension "part" separates real and
            imaginary parts. ".uff" is a universal file with one data set 58 for each curve and
            source, divided by the amplitude of the source. ".mat" is for MATLAB (extra "matlab").
            ".csv" and ".xlsx" hold the table of `to_dataframe`, with a column "re" and a column
            "im" for each complex one.
        at : str, tuple of (str, float), or sequence of them, optional
            As for `to_dataframe`.

        Raises
        ------
        SceneError
            If the response has two axes, which a universal file cannot hold.
        """
        self._write(path, at)

    def _save_own(self, path: Any, ending: str, at: Any = None) -> None:
        from gearbow.exchange import harmonic  # noqa: PLC0415

        if ending == ".mat":
            curves = self._curves(at)
            with replacing(path) as file:
                harmonic.write_mat(file, curves, self.frequencies, self.speeds, self.sources)
            return
        if self.axes != ("frequency",):
            raise SceneError("path: a universal file holds a response at one speed")
        harmonic.write_uff(
            path,
            self._curves(at),
            frequencies=self.frequencies,
            speeds=self.speeds,
            sources=self.sources,
            plain=self._sources,
        )

    def _axis_columns(self) -> list[Column]:
        """Give frequency, speed and source of each row of a table."""
        count = len(self.sources)
        return [
            Column(
                "frequency",
                np.repeat(self.frequencies.ravel(), count),
                "rad/s",
                ".2f",
                Written("Hz", 0.5 / np.pi),
            ),
            Column("speed", np.repeat(self.speeds.ravel(), count), "rad/s", ".2f"),
            Column("source", list(self.sources) * self.frequencies.size),
        ]

    def _columns(self) -> list[Column]:
        sizes: dict[str, Any] = {}
        for curve in self._curves():
            if curve.kind == "displacement" and curve.unit == "m":
                size = np.abs(curve.values.ravel()) ** 2
                sizes[curve.place] = sizes.get(curve.place, 0.0) + size
        largest = sorted(sizes, key=lambda place: -float(np.max(sizes[place], initial=0.0)))
        places_of = largest[:PRINTED_PLACES]
        amplitudes = [Column(f"{at} amplitude", np.sqrt(sizes[at]), "m", ".4g") for at in places_of]
        return [*self._axis_columns(), *amplitudes]

    def compare(
        self,
        measured: "str | os.PathLike[str] | Sequence[MeasuredCurve]",
        *,
        places: Mapping[int, At] | None = None,
    ) -> FrequencyComparison:
        """Compare with measured frequency response functions.

        The response is computed again at the measured frequencies.

        Parameters
        ----------
        measured : str, path-like or sequence of MeasuredCurve
            A universal file (".uff", ".unv") with data sets 58; or a table, as for
            `SpeedTable.read_table`, with the column "frequency [Hz]" and pairs such as
            "pinion y re [m/s²]", "pinion y im [m/s²]" or "input@0.2 z re [mm]"; or the curves of
            another comparison.
        places : mapping of int to place, optional
            Place of each node of a universal file that gearbow did not write: of responses and of
            references. The response is computed for the force of one newton at the reference node
            in its direction; the `source` of this response counts where the file has none, or
            another denominator than a force. Units are those of the labels, or else of data set
            164, or else SI.

        Returns
        -------
        FrequencyComparison
            Both curves, FRAC of each curve, and MAC of the shapes at each frequency.

        Raises
        ------
        SceneError
            If the file is invalid, or the response has several speeds.
        """
        from gearbow.exchange.harmonic import MeasuredCurve, read_measured  # noqa: PLC0415
        from gearbow.exchange.tables import ENDINGS  # noqa: PLC0415

        if self.axes != ("frequency",):
            raise SceneError("measured: a comparison needs a response at one speed")
        if places is not None and not isinstance(places, Mapping):
            raise SceneError(f"places: must be a mapping of nodes to places, got {shown(places)}")
        if isinstance(measured, str | os.PathLike):
            path, _ = check_name(measured, [".uff", ".unv", *ENDINGS], "measured")
            curves = read_measured(path, places, self.sources, self._sources)
        else:
            curves = items(measured, "measured", "curves")
        if not curves or not all(isinstance(curve, MeasuredCurve) for curve in curves):
            raise SceneError(
                "measured: must be a file, or measured curves of a comparison, got "
                f"{shown(measured)}"
            )
        return FrequencyComparison(tuple(curves), tuple(map(self._computed, curves)))

    def _computed(self, curve: "MeasuredCurve") -> ComplexArray:
        """Compute a curve at the frequencies of a measured one."""
        if isinstance(curve.source, int) and not curve.source < len(self.sources):
            raise SceneError(
                f"measured: there are {len(self.sources)} sources, got a curve of more"
            )
        at = np.ascontiguousarray(curve.frequencies)
        speeds = np.full(at.shape, self.speeds.ravel()[0])
        if isinstance(curve.source, int):
            sources = [self._sources[curve.source]]
        else:
            sources, _ = plain_sources(curve.source)
        found = self._model().frequency_response(at, speeds, sources, 1)
        phasors = found["phasors"]
        kind = {"twist": "twist", "x": "axial"}.get(curve.direction, "displacement")
        values = self.coordinates.motion(phasors, kind, curve.at)[:, 0]
        if kind == "displacement":
            values = values[:, "yz".index(curve.direction)]
        computed: ComplexArray = values * (1j * at) ** time_derivatives(curve.quantity)
        return computed
