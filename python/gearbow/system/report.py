"""The report of a system."""

import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, text, whole
from gearbow._extras import extra
from gearbow._files import check_name, check_output
from gearbow._types import Progress
from gearbow.analysis.protocol import System
from gearbow.description.bow_limit import BowLimit
from gearbow.description.part import parts
from gearbow.results.peak import operating_range
from gearbow.units.speed import RevolutionsPerMinute, RevolutionsPerMinuteArray, given_unit

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
        of the highest operating speed. The Campbell diagram takes up to 25 of them.
    modes : int
        Number of modes that oscillate.
    limits : sequence of BowLimit
        Limits of the bow in addition to those of the teeth.
    title : str, optional
        Heading of the page; None is the name of the file.
    progress : bool or callable, optional
        True shows a progress bar; None shows one on a terminal after 2 s; a callable receives the
        completed fraction.

    Raises
    ------
    SceneError
        If an argument is invalid, or the file has another ending.
    MissingExtraError
        If an extra is not installed: "report".
    OSError
        If the file cannot be written. An existing file is unchanged.
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
    >>> system.report("rotor.html", operating=gb.rpm(4000))  # doctest: +SKIP
    """
    file, _ = check_name(path, [".html"])
    check_output(file)
    span = operating_range(operating)
    unit = given_unit(operating) or given_unit(speeds) or self._speed_unit
    wanted = None if speeds is None else np.atleast_1d(array(speeds, "speeds"))
    count = whole(modes, "modes")
    added = tuple(parts(limits, BowLimit, "limits"))
    heading = file.stem if title is None else text(title, "title")
    if wanted is None and span is not None:
        wanted = np.linspace(_LOWEST, _HIGHEST, _SPEEDS) * span[1]
    if unit == "rpm":
        span = (
            None if span is None else (RevolutionsPerMinute(span[0]), RevolutionsPerMinute(span[1]))
        )
        wanted = None if wanted is None else wanted.view(RevolutionsPerMinuteArray)
    with extra("report"):
        import jinja2  # noqa: F401, PLC0415
        import matplotlib as mpl  # noqa: F401, PLC0415
        import plotly  # noqa: F401, PLC0415
    from gearbow.report.compose import compose  # noqa: PLC0415
    from gearbow.report.contents import Options  # noqa: PLC0415

    compose(self, file, Options(heading, span, wanted, count, added, unit), progress)
