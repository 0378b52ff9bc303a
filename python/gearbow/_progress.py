"""Progress of long work: progress bar, and warning about a long run."""

import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from gearbow._convert import function
from gearbow._types import Progress
from gearbow.errors import AccuracyWarning, outside

#: A run with a longer estimated duration gives a warning [s].
LONG_RUN = 3600.0
#: Observation time before the estimate of the duration [s].
WATCHED = 1.0


@contextmanager
def reported(
    progress: bool | Progress | None,
    total: float,
    unit: str = "s",
    *,
    estimate: bool = True,
    numbers: str = ".3g",
) -> Iterator[Progress | None]:
    """Give the callable that receives the completed fraction; True makes a progress bar."""
    if progress is not True:
        is_off = progress is None or progress is False
        report = None if is_off else function(progress, "progress")
        yield _Estimate(report) if estimate else report
        return
    from tqdm import tqdm  # noqa: PLC0415  # its import takes longer than that of gearbow

    with tqdm(
        total=total,
        bar_format=f"{{l_bar}}{{bar}}| {{n:{numbers}}}/{{total:{numbers}}} {unit} "
        "[{elapsed}<{remaining}]",
        # Show every report, because the remaining time changes without progress too.
        miniters=0,
    ) as bar:

        def show(fraction: float) -> None:
            bar.update(fraction * total - bar.n)

        yield _Estimate(show) if estimate else show
        show(1.0)


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
            warnings.warn(
                f"simulate: takes about {(elapsed + left) / 3600.0:.3g} h at the rate of the first "
                f"{elapsed:.2g} s; reduce the duration, increase rtol, use fewer elements, or save "
                'the run in a file by checkpoint="run.npz"',
                AccuracyWarning,
                stacklevel=outside(),
            )
