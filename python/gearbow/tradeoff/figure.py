"""Work-precision diagram of a study."""

from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearbow.plots import PALETTE, STYLE
from gearbow.tradeoff.models import GIVEN

if TYPE_CHECKING:
    from gearbow.tradeoff.result import Tradeoff
    from gearbow.tradeoff.trial import Trial

__all__ = ["draw", "work_precision"]

#: Filled markers for methods, open markers for models: distinguishable without colour.
_METHODS = ("o", "s", "D", "^", "v", "P")
_MODELS = ("X", "d", "<", ">", "p", "h", "8", "*")


def work_precision(tradeoff: "Tradeoff", duration: float | None = None) -> Figure:
    """Draw the CPU time against the error, both on logarithmic axes.

    Parameters
    ----------
    tradeoff : Tradeoff
        The study.
    duration : float, optional
        Simulated time of the compared runs [s]; None is the duration of the study.

    Returns
    -------
    matplotlib.figure.Figure
        The figure.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(12.0, 7.0), layout="constrained")
        panel = figure.subplots()
        draw(panel, tradeoff, duration)
        handles, labels = panel.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside right center")
    return figure


def draw(panel: Axes, tradeoff: "Tradeoff", duration: float | None = None) -> None:
    """Draw the diagram into given axes, without a legend.

    Parameters
    ----------
    panel : matplotlib.axes.Axes
        The axes.
    tradeoff : Tradeoff
        The study.
    duration : float, optional
        Simulated time of the compared runs [s]; None is the duration of the study.
    """
    given = [trial for trial in tradeoff.trials if trial.model == GIVEN]
    simpler = [trial for trial in tradeoff.trials if trial.model != GIVEN]
    for i, method in enumerate(dict.fromkeys(trial.method for trial in given)):
        x, y = _points([trial for trial in given if trial.method == method], duration)
        panel.plot(
            x,
            y,
            f"-{_METHODS[i % len(_METHODS)]}",
            color=PALETTE[i % len(PALETTE)],
            ms=9.0,
            label=method,
        )
    for i, model in enumerate(dict.fromkeys(trial.model for trial in simpler)):
        # The last run of a model is its reference run: it shows the model error, not the saving.
        chosen = [trial for trial in simpler if trial.model == model]
        x, y = _points(chosen[:-1] or chosen, duration)
        marker = _MODELS[i % len(_MODELS)]
        panel.plot(x, y, marker, ls="none", mfc="none", mec="0.35", mew=1.6, ms=10.0, label=model)
    front = tradeoff.front(duration=duration)
    x, y = _points(list(front), duration)
    # The cheapest setting is optimal for every error above its own.
    x, y = [max(trial.bound for trial in tradeoff.trials), *x], [y[0], *y]
    panel.step(x, y, where="pre", color="0.6", lw=7.0, alpha=0.5, zorder=1, label="Pareto front")
    panel.set_xscale("log")
    panel.set_yscale("log")
    left = min(panel.get_xlim()[0], tradeoff.floor / 3.0)
    panel.axvspan(left, tradeoff.floor, color="0.93", zorder=0, label="reference uncertainty")
    panel.set_xlim(left=left)
    simulated = tradeoff.duration if duration is None else duration
    panel.set_xlabel("error: RMS of the difference / RMS of the signal about its mean")
    panel.set_ylabel(f"CPU time for {simulated:g} simulated s [s]")


def _points(trials: "list[Trial]", duration: float | None) -> tuple[list[float], list[float]]:
    # A point below the uncertainty of the reference is drawn at this uncertainty.
    return [trial.bound for trial in trials], [trial.cost(duration) for trial in trials]
