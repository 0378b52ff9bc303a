"""The method `gearbow.RotorSystem.simulate_many`."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from gearbow._convert import items, shown
from gearbow._parallel import ParallelCalls
from gearbow._progress import reported
from gearbow._types import Progress
from gearbow.analysis.protocol import System
from gearbow.errors import GearbowError, SceneError
from gearbow.results.response import Response

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future


def simulate_many(
    system: System,
    variations: Iterable[Mapping[str, Any]],
    duration: float,
    speed: Any,
    *,
    executor: "Executor | None" = None,
    progress: bool | Progress | None = None,
    **options: Any,
) -> list[Response]:
    """Simulate variations of this system in parallel.

    Variations that differ from the system in loads only (torques, forces, bows, unbalance, gravity)
    share its elements, its modes and the number of modes that `accuracy` needs. These are chosen
    for a run of the system itself, and each variation checks them with its own loads: where they
    do not keep the accuracy, it chooses its own. The responses depend neither on the order of the
    variations nor on the number of workers. Without a choice to share, they have the bits of
    ``system.replace(**variation).simulate(duration, speed, **options)``.

    Parameters
    ----------
    system : RotorSystem
        The system.
    variations : iterable of mapping
        Arguments of `replace` for each variation, for example ``{"torques": [...]}``.
    duration : float
        Simulated time [s].
    speed : float, SpeedProfile, callable or (times, speeds)
        Speed of the reference shaft [rad/s].
    executor : concurrent.futures.Executor, optional
        Runs the variations; None is one thread for each core. Processes share no modes.
    progress : bool or callable, optional
        True shows a progress bar, None after 2 s on a terminal; a callable gets the fraction.
    **options
        Further arguments of `simulate`, except `checkpoint`.

    Returns
    -------
    list of Response
        The response of each variation.

    Raises
    ------
    GearbowError
        The error of `simulate`. Its message begins with the number and the content of the
        variation. This and every other exception has the attribute `.responses`: the list of
        responses, None for those that were not computed.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> variations = [{"gravity": g} for g in (1.62, 9.81)]
    >>> moon, earth = system.simulate_many(variations, 0.5, 100.0, record=["disk"])
    >>> print([f"{1e6 * run.displacement('disk')[:, 1].mean():.0f} µm" for run in (moon, earth)])
    ['-21 µm', '-130 µm']
    """
    wanted = [
        _variation(entry, number)
        for number, entry in enumerate(items(variations, "variations", "dicts"))
    ]
    if options.get("checkpoint") is not None:
        raise SceneError("checkpoint: one file cannot contain several runs; use simulate")
    system._require_memory_of_runs(len(wanted), duration, speed, options)
    responses: dict[int, Response] = {}
    total = len(wanted)

    def keep(number: int, future: "Future[Response]") -> None:
        error = future.exception()
        if error is not None:
            raise _named(error, number, wanted[number])
        responses[number] = future.result()

    arguments = ((system, changes, duration, speed, options) for changes in wanted)
    calls = ParallelCalls(_simulate, arguments, executor)
    try:
        with reported(
            progress, total, "runs", what="simulate_many", estimate=False, numbers=".0f"
        ) as report:
            calls.collect(keep, lambda: report and report(len(responses) / total))
    except BaseException as error:
        error.responses = list(map(responses.get, range(total)))  # type: ignore[attr-defined]
        raise
    return [responses[number] for number in range(total)]


def _variation(entry: object, number: int) -> dict[str, Any]:
    if not isinstance(entry, Mapping):
        raise SceneError(
            f"variations[{number}]: must be a dict of arguments of `replace`, got {shown(entry)}"
        )
    return dict(entry)


def _simulate(
    system: System, changes: dict[str, Any], duration: float, speed: Any, options: dict[str, Any]
) -> Response:
    return system._variation(**changes).simulate(duration, speed, **options)  # type: ignore[no-any-return]


def _named(error: BaseException, number: int, changes: dict[str, Any]) -> BaseException:
    """Return the same error with the number and the content of the variation in its message."""
    if not isinstance(error, GearbowError):
        return error
    named = type(error)(f"variations[{number}] = {shown(changes)}: {error}")
    named.response = error.response
    named.__cause__ = error
    return named
