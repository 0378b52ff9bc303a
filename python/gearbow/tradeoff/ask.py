"""The question, `gearbow.RotorSystem.tradeoff`: what every argument means."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from gearbow._convert import number
from gearbow._run import reported
from gearbow._types import Progress
from gearbow.errors import SceneError
from gearbow.tradeoff.plan import plan
from gearbow.tradeoff.result import Tradeoff
from gearbow.tradeoff.study import carry_out

if TYPE_CHECKING:
    from gearbow.system import RotorSystem

__all__ = ["tradeoff"]


def tradeoff(
    system: "RotorSystem",
    duration: float,
    speed: float,
    of: Any = None,
    *,
    methods: str | Iterable[str] | None = None,
    steps: Iterable[float] | None = None,
    tolerances: Iterable[float] | None = None,
    modes: Iterable[int] | None = None,
    elements: Iterable[float] = (0.5, 2.0),
    frozen: bool = True,
    mean_stiffness: bool = True,
    initial: str = "synchronous",
    output_step: float | None = None,
    repeats: int = 3,
    budget: float = 60.0,
    progress: bool | Progress | None = None,
) -> Tradeoff:
    """Measure what accuracy costs: methods, steps, tolerances and simpler models in one run.

    Parameters
    ----------
    system : RotorSystem
        The system.
    duration : float
        Simulated time [s]; an error is that of all of it.
    speed : float
        Speed Ω of the reference shaft [rad/s].
    of : str, tuple or list of them, optional
        What is compared: the displacement of a gear, disk or (shaft, position), the force of a
        mesh (driver, driven), or the worst of several. None is the first gear.
    methods : str or list of str, optional
        Methods to try, out of `gearbow.tradeoff.METHODS`; None is all. Simplified models are
        run by the first.
    steps : list of float, optional
        Steps of the methods that have fixed ones [s]; None is a ladder of them.
    tolerances : list of float, optional
        Tolerances of the other methods; None is a ladder of them.
    modes : list of int, optional
        Numbers of modes to keep; None is a half, a quarter and an eighth.
    elements : list of float
        Numbers of elements over those given: below one a simpler model, above one a finer one,
        which shows the error of the discretisation.
    frozen : bool
        Whether to try geometry="frozen".
    mean_stiffness : bool
        Whether to try the mean in place of tooth stiffness that varies.
    initial : {"synchronous", "static", "rest"}
        Where every run starts.
    output_step : float, optional
        Spacing of the times at which runs are compared [s]; None is that of `simulate`.
    repeats : int
        Runs of each setting, of whose CPU times the median is taken; fewer where they are slow.
    budget : float
        How long the study may take [s]; what is predicted to take too much of it is skipped.
    progress : bool or callable, optional
        True shows a bar; a callable is given the fraction that is done.

    Returns
    -------
    Tradeoff
        A row for each setting, the front, a diagram and a recommendation.

    Raises
    ------
    SceneError
        If an argument is impossible.
    GearbowError
        If the budget is too short for a reference.

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4, bow=bow)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> tradeoff = system.tradeoff(0.02, speed=100.0, of=("rotor", 0.5), initial="rest")
    >>> best = tradeoff.recommend(error=1e-4)
    >>> best.error <= 1e-4
    True
    >>> response = best.system.simulate(0.02, speed=100.0, initial="rest", **best.options)
    """
    made = plan(
        system,
        duration,
        speed,
        of,
        methods=methods,
        steps=steps,
        tolerances=tolerances,
        modes=modes,
        elements=elements,
        frozen=frozen,
        mean_stiffness=mean_stiffness,
        initial=initial,
        output_step=output_step,
        repeats=repeats,
    )
    seconds = number(budget, "budget", infinite=True)
    if not seconds > 0.0:
        raise SceneError(f"budget: must be positive, got {budget!r}")
    with reported(progress, 100.0, "%") as report:
        return carry_out(made, seconds, report or (lambda _: None))
