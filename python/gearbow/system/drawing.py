"""Figure of a system at rest."""

from typing import TYPE_CHECKING, Any

from gearbow._convert import number
from gearbow._extras import extra
from gearbow.analysis.protocol import System
from gearbow.description.train import Train
from gearbow.errors import SceneError

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

    Raises
    ------
    GearbowError
        If `ax` is not one or two Axes.
    SceneError
        If `magnify` is not positive and finite.

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=gb.Bow.half_sine(1e-4))
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> figure = gb.RotorSystem(shafts=[rotor], bearings=bearings).plot()
    >>> [panel.get_title() for panel in figure.axes]
    ['side view, bow × 50', 'end view, seen along −x']
    """
    with extra("plot"):
        from gearbow.plotting import train as figures  # noqa: PLC0415

    if magnify is not None:
        magnify = number(magnify, "magnify")
        if not magnify > 0.0:
            raise SceneError(f"magnify: must be positive, got {magnify!r}")
    train = Train.of(self._model.description(), self.speed_ratios)
    return figures.draw(train, magnify, ax)
