"""Figures, reports and scene files of a system."""

import os
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, copied, one_of, positive, showing, text, whole
from gearbow._core import Model
from gearbow._extras import extra
from gearbow._files import check_name, check_output, reading
from gearbow._types import Accuracy, At, InitialState, Language, Progress, Record
from gearbow.analysis.protocol import System
from gearbow.description.bow import BowLimit
from gearbow.description.part import parts
from gearbow.description.train import Train
from gearbow.errors import SceneError
from gearbow.results.peak import operating_range
from gearbow.results.stresses import Strength
from gearbow.sensors import SignalSensor
from gearbow.system.bodies import with_bodies
from gearbow.units.fields import without_texts
from gearbow.units.speed import SpeedUnit, as_given, given_unit, showing_in, unit_in_texts

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot(  # numpydoc ignore=PR01
    self: System, *, ax: Any = None, magnify: float | None = None
) -> "Figure":
    """Draw the train to scale, from the side and from the end.

    The side view shows shafts, gears, disks, bearings with what they stand on, couplings, drives,
    torques and forces, and the enlarged bow of each shaft in its own plane, with its size and its
    angle in the shaft. The train is developed into one plane: neighbouring shafts have their centre
    distance. An arrow of a torque or a rotation has its head in the positive sense, y towards z,
    where its value is positive.

    The end view shows the pitch circles, the sense of rotation of each shaft at a positive speed of
    the reference shaft, and the line of action of each mesh between the base circles, with the
    direction of the force on the driven gear.

    Parameters
    ----------
    ax : Axes or pair of Axes, optional
        Panel for the side view, or panels for side view and end view; None makes a new figure.
    magnify : float, optional
        Factor that enlarges the bows; None chooses one, which the title names.

    Returns
    -------
    matplotlib.figure.Figure
        The figure. It is neither shown nor saved.

    Examples
    --------
    >>> import gearbow as gb
    >>> figure = gb.examples()["bowed_rotor"].load().plot()
    >>> [panel.get_title() for panel in figure.axes]
    ['side view, bow × 200', 'end view, seen along −x']
    """
    with extra("plot"):
        from gearbow.plotting import train as figures  # noqa: PLC0415

    if magnify is not None:
        magnify = positive(magnify, "magnify")
    train = Train.of(self._model.description(), self.speed_ratios)
    return figures.draw(train, magnify, ax)


#: Default speeds of the diagrams: their number, and the lowest and the highest one divided by the
#: highest operating speed. API RP 684 (2005) requires the response to unbalance up to 1.5. The
#: speed 0 is left out, because journal bearings carry no load there.
_SPEEDS, _LOWEST, _HIGHEST = 100, 0.05, 1.5


def report(
    self: System,
    path: str | os.PathLike[str],
    *,
    operating: float | tuple[float, float] | None = None,
    speeds: "ArrayLike | None" = None,
    modes: int = 8,
    limits: Sequence[BowLimit] = (),
    title: str | None = None,
    endurance_limit: float | Mapping[str, float] | None = None,
    tensile_strength: float | Mapping[str, float] | None = None,
    company: str | None = None,
    author: str | None = None,
    document_number: str | None = None,
    date: str | None = None,
    language: Language = "en",
    progress: bool | Progress | None = None,
) -> None:
    """Write a report: one HTML page with drawing, data, and the results of the usual analyses.

    The page has interactive figures and contains all that it needs. Without scripts, and in print
    (A4), it shows images. What cannot be computed for this system is a sentence with the reason.

    Parameters
    ----------
    path : str or path-like
        The file. Its name ends with ".html".
    operating : float or tuple of (float, float), optional
        Operating speed of the reference shaft, or the lowest and the highest [rad/s]. Static loads,
        modes, limits of bows and the motion are those of the highest speed. Without it the report
        has standstill, and no motion.
    speeds : array_like, shape (k,), optional
        Speeds of the reference shaft for the diagrams [rad/s]; None is 100 speeds from 5 % to 150 %
        of the highest operating speed, within the tables of bearings. The Campbell diagram takes up
        to 25 of their magnitudes, in the sense of rotation of the operating speed.
    modes : int
        Number of modes that oscillate.
    limits : sequence of BowLimit
        Limits of the bow in addition to those of the teeth.
    title : str, optional
        Heading of the page; None is the name of the file.
    endurance_limit, tensile_strength : float or mapping, optional
        Strength of the shafts [Pa], as for `stresses`; None gives stresses without utilisation.
    company, author, document_number, date : str, optional
        Facts of the document below the heading, as they are.
    language : {"en", "de"}
        Language of the page; numbers, messages and names in the description are the same in both.
    progress : bool or callable, optional
        True shows a progress bar, None after 2 s on a terminal; a callable gets the fraction.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C; the file then has the sections that were finished.

    Notes
    -----
    Separation margins and amplification factors follow API RP 684, the unbalance of the response
    analysis and level 1 of the stability analysis API 617. The interactive figures are of plotly.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> system.report("rotor.html", operating=418.9)  # doctest: +SKIP
    """
    file, _ = check_name(path, [".html"])
    check_output(file)
    span = operating_range(operating)
    unit = given_unit(operating) or given_unit(speeds) or self._speed_unit
    wanted = None if speeds is None else np.atleast_1d(array(speeds, "speeds"))
    count = whole(modes, "modes")
    added = tuple(parts(limits, BowLimit, "limits"))
    heading = file.stem if title is None else text(title, "title")
    one_of(language, get_args(Language), "language")
    Strength.of([shaft.name for shaft in self.shafts], endurance_limit, tensile_strength, "goodman")
    given = {
        "company": company,
        "author": author,
        "document_number": document_number,
        "date": date,
    }
    with extra("report"):
        import jinja2  # noqa: F401, PLC0415
        import matplotlib as mpl  # noqa: F401, PLC0415
        import plotly  # noqa: F401, PLC0415
    imprint = tuple(
        (key.replace("_", " "), text(each, key)) for key, each in given.items() if each is not None
    )
    from gearbow.report.compose import compose  # noqa: PLC0415
    from gearbow.report.shared import Options, table_range  # noqa: PLC0415

    if wanted is None and span is not None:
        low, high = np.clip([_LOWEST * abs(span[1]), _HIGHEST * abs(span[1])], *table_range(self))
        wanted = np.copysign(np.linspace(low, high, _SPEEDS), span[1])
    options = Options(
        heading,
        as_given(span, unit),
        as_given(wanted, unit),
        count,
        added,
        unit,
        endurance_limit=endurance_limit,
        tensile_strength=tensile_strength,
        language=language,
        imprint=imprint,
    )
    with showing_in(unit):
        compose(self, file, options, progress)


_NUL = re.compile(r"\\(u0000|U00000000)")


class Scene(NamedTuple):
    """A scene file: its model, and the unit of speeds in its texts."""

    model: Model
    speed_unit: SpeedUnit


def read_scene(path: str | os.PathLike[str]) -> Scene:
    """Read a scene file."""
    if sys.version_info >= (3, 11):
        import tomllib  # noqa: PLC0415
    else:
        import tomli as tomllib  # noqa: PLC0415

    with reading(path, "a scene file") as document:
        try:
            plain = tomllib.loads(document)
        except tomllib.TOMLDecodeError:
            try:
                return Scene(Model.from_toml(document), "rad/s")  # which describes the error
            except SceneError as error:
                raise _with_remedy(error, document) from None
        converted = without_texts(with_bodies(plain, Path(path)))
        with showing(plain):
            return Scene(_model(document, plain, converted), unit_in_texts(plain))


def _model(document: str, plain: Any, converted: Any) -> Model:
    """Make the system of a document with the `plain` content, `converted` to numbers."""
    # Without units and files, the errors of the core name the line. Only an escape can give a NUL.
    if converted == plain and not _NUL.search(document):
        return Model.from_toml(document)
    return Model(copied(converted, ""))


def _with_remedy(error: SceneError, document: str) -> SceneError:
    """Say how to write a list of parts, if that is why the document is not TOML."""
    found = re.search(r"at line (\d+)", str(error))
    if found is None or "duplicate key" not in str(error):
        return error
    header = re.fullmatch(
        r"\s*\[\[?\s*(\w+)\s*\]?\]\s*(#.*)?", document.splitlines()[int(found[1]) - 1]
    )
    if header is None:
        return error
    return SceneError(f"{error}; write two brackets around each name of a list: [[{header[1]}]]")


def to_fmu(
    self: System,
    path: str | os.PathLike[str],
    speed: float,
    *,
    torque_inputs: Iterable[At] = (),
    speed_input: tuple[float, float] | None = None,
    record: Iterable[Record] | None = None,
    sensors: Iterable[SignalSensor] = (),
    accuracy: Accuracy | None = None,
    initial: InitialState = "synchronous",
) -> None:
    """Write a functional mock-up unit (FMI 3.0, co-simulation) of the system.

    The unit steps the system by `simulate`, so that it needs Python with this version of gearbow
    where it runs. Each communication step continues the run of the steps before. The unit saves,
    restores and serialises its state; equal states give equal steps to the last bit.

    Parameters
    ----------
    path : str or path-like
        The file. Its name ends with ".fmu".
    speed : float
        Speed of the reference shaft at the beginning [rad/s].
    torque_inputs : iterable of str or tuple of (str, float)
        Gears, disks or (shaft, position [m]), each with an input torque [N m] that acts beside the
        torques of the system and is 0 at the beginning. In a step it goes from the last value to
        the present one, as a cubic with slope zero at both ends.
    speed_input : tuple of (float, float), optional
        Smallest and largest value of an input speed [rad/s] of the reference shaft, of one sign. In
        a step, the speed goes linearly from the last value to the present one. None keeps `speed`.
    record : iterable, optional
        Places and quantities that are outputs, as for `simulate`.
    sensors : iterable of Probe, Accelerometer, StrainGauge or RingSensor
        Sensors whose signals are outputs. `record` contains their places.
    accuracy : {"draft", "engineering", "reference"}, optional
        Accuracy of the steps, as for `simulate`.
    initial : {"synchronous", "static", "rest"}
        State at the beginning.

    Raises
    ------
    SceneError
        If an argument is invalid, or a load is a function of time.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["coaxial_reducer"].load()  # doctest: +SKIP
    >>> system.to_fmu("train.fmu", 100.0, speed_input=(50.0, 150.0))  # doctest: +SKIP
    """
    from gearbow.exchange.fmu import write_fmu  # noqa: PLC0415  # with pickle, JSON and archives
    from gearbow.system.cosimulation import Interface  # noqa: PLC0415

    file, _ = check_name(path, [".fmu"])
    check_output(file)
    face = Interface.of(
        speed, torque_inputs, speed_input, record, sensors, accuracy=accuracy, initial=initial
    )
    write_fmu(self, face, file)
