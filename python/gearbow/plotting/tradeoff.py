"""Work-precision diagram of a study."""

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from matplotlib.figure import Figure

from gearbow.plotting.style import GivenAxes, colour, panels

__all__ = ["work_precision"]

#: Errors and CPU times [s] of a series of runs.
Points: TypeAlias = tuple[Sequence[float], Sequence[float]]

#: Filled markers for methods, open markers for models: distinguishable without colour.
_METHODS = ("o", "s", "D", "^", "v", "P")
_MODELS = ("X", "d", "<", ">", "p", "h", "8", "*")


def work_precision(
    methods: Mapping[str, Points],
    models: Mapping[str, Points],
    front: Points,
    *,
    floor: float,
    worst: float,
    simulated: float,
    ax: GivenAxes = None,
) -> Figure:
    """Draw the CPU time against the error, both on logarithmic axes."""
    with panels(1, 6.2, columns=1, ax=ax) as (figure, (panel,)):
        for i, (name, (x, y)) in enumerate(methods.items()):
            marker = f"-{_METHODS[i % len(_METHODS)]}"
            panel.plot(x, y, marker, color=colour(i), ms=9.0, label=name)
        for i, (name, (x, y)) in enumerate(models.items()):
            marker = _MODELS[i % len(_MODELS)]
            panel.plot(
                x, y, marker, ls="none", mfc="none", mec="0.35", mew=1.6, ms=10.0, label=name
            )
        # The cheapest run is optimal for every error above its own.
        x, y = [worst, *front[0]], [front[1][0], *front[1]]
        line: dict[str, Any] = {"color": "0.6", "lw": 7.0, "alpha": 0.5, "zorder": 1}
        panel.step(x, y, where="pre", label="Pareto front", **line)
        panel.set_xscale("log")
        panel.set_yscale("log")
        left = min(panel.get_xlim()[0], floor / 3.0)
        panel.axvspan(left, floor, color="0.93", zorder=0, label="reference uncertainty")
        panel.set_xlim(left=left)
        panel.set_xlabel("error: RMS of the difference / RMS of the signal about its mean")
        panel.set_ylabel(f"CPU time for {simulated:g} simulated s [s]")
        handles, labels = panel.get_legend_handles_labels()
        if ax is None:
            figure.legend(handles, labels, loc="outside right center")
        else:
            panel.legend(handles, labels, loc="best", fontsize="small")
    return figure
