"""Progress of long work: progress bar, and warning about a long run.

A bar appears on a terminal by itself if a call takes long. Only the outermost call of the main
thread and process shows one, so that the runs of a sweep show nothing beside the bar of the sweep.
"""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

from gearbow._convert import function, truth
from gearbow._types import Progress
from gearbow.errors import AccuracyWarning, warn

#: A run with a longer estimated duration gives a warning [s].
LONG_RUN = 3600.0
#: Observation time before the estimate of the duration [s].
WATCHED = 1.0
#: Time before a bar appears by itself [s], and time between two renewals of its elapsed time [s].
_DELAY, _RENEWAL = 2.0, 0.5

#: Calls that show a bar or are asked to show none: the calls within show nothing by themselves.
_decided: list[str] = []


@contextmanager
def reported(
    progress: bool | Progress | None,
    total: float,
    unit: str = "s",
    *,
    what: str,
    setup: str | None = None,
    estimate: bool = True,
    numbers: str = ".3g",
) -> Iterator[Progress | None]:
    """Give the callable that receives the completed fraction; True or a terminal makes a bar."""
    if progress is not True and not (progress is None and _is_automatic()):
        is_off = progress is None or progress is False
        report = None if is_off else function(progress, "progress")
        with nullcontext() if progress is None else _deciding(what):
            yield _Estimate(report) if estimate else report
        return
    # The bar names the set-up while the fraction is zero.
    names = what if setup is None else f"{what}: {setup}"
    count = f"{{n:{numbers}}}/{{total:{numbers}}} {unit}"
    look = f"{{l_bar}}{{bar}}| {count} [{{elapsed}}<{{remaining}}]"
    with _bar(what, at_once=bool(progress), total=total, desc=names, bar_format=look) as done:

        def show(fraction: float) -> None:
            done.amount = fraction * total

        yield _Estimate(show) if estimate else show
        done.amount = total


@contextmanager
def working(progress: bool | None, what: str) -> Iterator[None]:
    """Show the time of work whose completed fraction is unknown, as `reported` does."""
    asked = _is_automatic() if progress is None else truth(progress, "progress")
    if not asked:
        with nullcontext() if progress is None else _deciding(what):
            yield
        return
    with _bar(what, at_once=False, desc=what, bar_format="{desc} [{elapsed}]"):
        yield


def _is_automatic() -> bool:
    """Return whether this call shows a bar by itself."""
    if _decided or not sys.stderr.isatty():
        return False
    if threading.current_thread() is not threading.main_thread():
        return False
    from multiprocessing import parent_process  # noqa: PLC0415  # its import takes 10 ms

    return parent_process() is None


@contextmanager
def _deciding(what: str) -> Iterator[None]:
    """Keep the calls within from showing a bar by themselves."""
    _decided.append(what)
    try:
        yield
    finally:
        _decided.remove(what)


class _Done:
    """What the clock of a bar shows next."""

    #: Completed part of the total, in its unit.
    amount = 0.0


@contextmanager
def _bar(what: str, *, at_once: bool, **look: Any) -> Iterator[_Done]:
    """Show a bar whose elapsed time goes on while the core reports nothing."""
    # Only its clock draws: an interrupt of the main thread would leave the lock of a drawing taken.
    from tqdm import tqdm  # noqa: PLC0415  # its import takes longer than that of gearbow

    class Bar(tqdm):  # type: ignore[type-arg]
        #: The clock draws often enough without the thread that tqdm starts for all its bars.
        monitor_interval = 0

    # `miniters=0` draws without progress too, because the remaining time changes. A bar that
    # appears by itself disappears at the end.
    delay = 0.0 if at_once else _DELAY
    stop, done = threading.Event(), _Done()
    with _deciding(what), Bar(miniters=0, delay=delay, leave=at_once, **look) as bar:

        def renew() -> None:
            is_last = False
            while not is_last:
                is_last = stop.wait(_RENEWAL)
                if done.amount > 0.0:
                    bar.set_description_str(what, refresh=False)
                bar.update(done.amount - bar.n)

        clock = threading.Thread(target=renew, name="gearbow progress", daemon=True)
        clock.start()
        try:
            yield done
        finally:
            stop.set()
            clock.join()


class _Estimate:
    """Forwards the completed fraction, and warns once about a run of more than one hour."""

    def __init__(self, report: Progress | None) -> None:
        self._report = report
        self._first: tuple[float, float] | None = None
        self._warned = False

    def __call__(self, fraction: float) -> None:
        if self._report is not None:
            self._report(fraction)
        now = time.perf_counter()
        # A continued run begins with a completed fraction. Set-up and pilot runs, which complete no
        # part of the run, do not count.
        if self._first is None or fraction <= 0.0:
            self._first = (now, fraction)
        begin, done = self._first
        elapsed = now - begin
        if self._warned or elapsed < WATCHED or fraction <= done:
            return
        self._warned = True
        left = elapsed * (1.0 - fraction) / (fraction - done)
        if elapsed + left > LONG_RUN:
            warn(
                f"simulate: takes about {(elapsed + left) / 3600.0:.3g} h at the rate of the first "
                f"{elapsed:.2g} s; reduce the duration, increase rtol, use fewer elements, or save "
                'the run in a file by checkpoint="run.npz"',
                AccuracyWarning,
            )
