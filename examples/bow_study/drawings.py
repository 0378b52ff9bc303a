"""Figures of the bow study: one function for each figure."""

import math
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from cases import ALL, Case, train
from gearbow import plotting as plots
from runs import Measured, Study

_MICRO = 1e6
_BOW = "bow / shaft radius"
_LINES, _WORDS = ("-", "--", ":"), ("solid", "dashed", "dotted")


def write(study: Study, folder: Path) -> list[Path]:
    """Draw figures and write them as PNG files."""
    paths = []
    for name, draw in FIGURES.items():
        path = folder / f"study_{name}.png"
        drawn = BytesIO()
        draw(study).savefig(drawn, format="png", dpi=90)
        # A palette of few colours makes the file small.
        with Image.open(drawn) as image:
            few = image.convert("RGB").quantize(96, dither=Image.Dither.NONE)
        few.save(path, format="PNG", optimize=True)
        paths.append(path)
    return paths


def turn(study: Study) -> Figure:
    """Draw gear orbits and mesh geometry over one revolution of the output shaft."""
    colours = dict(zip(study.settings.bows, _ordered(len(study.settings.bows)), strict=True))
    rows = {
        "contact ratio": ("contact_ratio", 1.0),
        "pressure angle [°]": ("pressure_angle", math.degrees(1.0)),
        "line of action [°]": ("line_of_action", math.degrees(1.0)),
    }
    with mpl.rc_context(plots.STYLE):
        figure = Figure(figsize=(15.0, 16.0))
        grid = figure.add_gridspec(4, 4, height_ratios=[1.3, 1.0, 1.0, 1.0])
        orbits = [figure.add_subplot(grid[0, column]) for column in range(4)]
        panels = [
            [figure.add_subplot(grid[1 + row, 2 * half : 2 * half + 2]) for half in range(2)]
            for row in range(3)
        ]
        for bow in reversed(study.settings.bows):
            found = study[replace(study.base, bow=bow)]
            for panel, gear in zip(orbits, study.gears, strict=True):
                v, w = (_MICRO * found[gear, name] for name in ("v", "w"))
                panel.plot(v, w, color=colours[bow], label=f"{bow:g}")
                panel.set(title=gear, xlabel="y [µm]", ylabel="z [µm]")
            for line, (label, (name, scale)) in zip(panels, rows.items(), strict=True):
                for panel, pair in zip(line, study.pairs, strict=True):
                    values = scale * found[pair, name]
                    panel.plot(found.turn, values, color=colours[bow])
                    panel.set(ylabel=f"{label}, {pair}")
        plots.equal_ranges(orbits)
        for panel in panels[0]:
            panel.axhline(1.0, color="black", linewidth=1.0)
        for panel in panels[-1]:
            panel.set(xlabel="revolutions of the output shaft")
        handles, labels = orbits[0].get_legend_handles_labels()
        figure.legend(
            handles[::-1], labels[::-1], loc="outside upper center", ncols=len(labels), title=_BOW
        )
    return figure


def where(study: Study) -> Figure:
    """Draw peak-to-peak values against the bow, on all shafts and on each shaft."""
    bows = study.settings.bows
    title = "bow on, layout"
    with plots.panels(4, 4.2, columns=2, width=14.0, legend=title) as (figure, panels):
        shown = [(pair, "contact_ratio") for pair in study.pairs]
        shown += [(gear, "orbit") for gear in list(study.gears)[1:3]]
        for panel, (of, what) in zip(panels, shown, strict=True):
            for number, place in enumerate((ALL, *study.shafts)):
                for line, layout in zip(_LINES, study.settings.layouts, strict=False):
                    panel.plot(
                        bows,
                        [
                            _peak_to_peak(study[_at(study, layout, place, bow)], of, what)
                            for bow in bows
                        ],
                        line,
                        marker="o",
                        markersize=4,
                        color=plots.PALETTE[number],
                        label=f"{place}, {layout}",
                    )
            name = f"displacement {of} [mm]" if what == "orbit" else f"contact ratio {of}"
            panel.set(xlabel=_BOW, ylabel=f"{name}, peak-to-peak")
    return figure


def limits(study: Study) -> Figure:
    """Draw the decrease of the centre distance and the smallest contact ratio against the bow."""
    with plots.panels(2, 5.0, columns=2, width=14.0, legend="bow on") as (figure, (near, few)):
        for number, place in enumerate((ALL, *study.shafts)):
            closer, ratios = [], []
            for bow in study.settings.bows:
                found = study[_at(study, study.base.layout, place, bow)]
                closer.append(
                    max(
                        study.teeth[pair].centre_distance - found.smallest(pair, "centre_distance")
                        for pair in study.pairs
                    )
                )
                ratios.append(min(found.smallest(pair, "contact_ratio") for pair in study.pairs))
            style: dict[str, Any] = {"marker": "o", "markersize": 4, "color": plots.PALETTE[number]}
            near.plot(study.settings.bows, 1e3 * np.array(closer), label=place, **style)
            few.plot(study.settings.bows, ratios, **style)
        angle = study.teeth[study.pairs[0]].pressure_angle
        lines = {
            "tips reach root circles": min(teeth.tip_clearance for teeth in study.teeth.values()),
            "backlash used up": study.settings.backlash / (2.0 * math.sin(angle)),
        }
        for text, value in lines.items():
            near.axhline(1e3 * value, color="black", linewidth=1.0)
            near.annotate(
                text,
                (study.settings.bows[-1], 1e3 * value),
                xytext=(0, 4),
                textcoords="offset points",
                ha="right",
            )
        few.axhline(1.0, color="black", linewidth=1.0)
        near.set(xlabel=_BOW, ylabel="largest decrease of centre distance [mm]")
        few.set(xlabel=_BOW, ylabel="smallest contact ratio")
    return figure


def frozen(study: Study) -> Figure:
    """Draw the mesh forces with live and with frozen geometry."""
    title = "geometry of the meshes"
    with plots.panels(4, 4.2, columns=2, width=14.0, legend=title) as (figure, panels):
        styles: tuple[tuple[Literal["live", "frozen"], str], ...] = (
            ("live", plots.PALETTE[0]),
            ("frozen", plots.PALETTE[1]),
        )
        for panel, pair in zip(panels[:2], study.pairs, strict=True):
            for geometry, colour in styles:
                found = study[replace(study.bent, geometry=geometry)]
                panel.plot(
                    found.turn,
                    1e-3 * found[pair, "force"],
                    color=colour,
                    linewidth=1.0,
                    label=geometry,
                )
            # A tenth of a revolution around the largest force; a longer range shows no details.
            live = study[study.bent]
            peak = live.turn[live[pair, "force"].argmax()]
            begin = min(max(peak - 0.05, 0.0), 0.9)
            panel.set_xlim(begin, begin + 0.1)
            panel.set(xlabel="revolutions of the output shaft", ylabel=f"force {pair} [kN]")
        for panel, pair in zip(panels[2:], study.pairs, strict=True):
            for geometry, colour in styles:
                for line, speed in zip(_LINES, study.settings.speeds, strict=False):
                    cases = [
                        replace(study.base, speed=speed, bow=bow, geometry=geometry)
                        for bow in study.settings.bows
                    ]
                    # With loss of contact, the model does not describe the mesh force.
                    contact = [
                        case
                        for case in cases
                        if study[replace(case, geometry="live")].always_in_contact
                    ]
                    panel.plot(
                        [case.bow for case in contact],
                        [1e-3 * study[case].peak_to_peak(pair, "force") for case in contact],
                        line,
                        marker="o",
                        markersize=4,
                        color=colour,
                    )
            names = ", ".join(
                f"{word} {speed:g}"
                for word, speed in zip(_WORDS, study.settings.speeds, strict=False)
            )
            panel.set(
                xlabel=_BOW, ylabel=f"force {pair}, peak-to-peak [kN]", title=f"{names} rad/s"
            )
    return figure


def over_phases(study: Study) -> Figure:
    """Draw the smallest contact ratio against the phases of the bows."""
    angles = study.settings.phases
    ticks = np.degrees(angles)
    count = len(study.settings.layouts)
    with plots.panels(2 * count, 5.0, columns=2, width=13.0) as (figure, panels):
        fields = []
        for layout in study.settings.layouts:
            bent = replace(study.bent, layout=layout)
            for pair in study.pairs:
                fields.append(
                    np.array(
                        [
                            [
                                study[replace(bent, phases=(second, third))].smallest(
                                    pair, "contact_ratio"
                                )
                                for second in angles
                            ]
                            for third in angles
                        ]
                    )
                )
        low, high = min(map(np.min, fields)), max(map(np.max, fields))
        titles = [f"{pair}, {layout}" for layout in study.settings.layouts for pair in study.pairs]
        for panel, field, title in zip(panels, fields, titles, strict=True):
            drawn = panel.pcolormesh(ticks, ticks, field, cmap="cividis", vmin=low, vmax=high)
            for (row, column), value in np.ndenumerate(field):
                dark = value < (low + high) / 2.0
                panel.text(
                    ticks[column],
                    ticks[row],
                    f"{value:.2f}",
                    ha="center",
                    va="center",
                    color="white" if dark else "black",
                )
            panel.set(title=title, xticks=ticks, yticks=ticks)
            panel.set(xlabel="phase of the middle bow [°]", ylabel="phase of the output bow [°]")
            panel.grid(visible=False)
        figure.colorbar(drawn, ax=panels, label="smallest contact ratio")
    return figure


def modes(study: Study) -> Figure:
    """Draw the first mode shapes at rest."""
    return train(study.settings, study.base).modes().plot(count=min(6, study.settings.modes))


#: Figures by name.
FIGURES: dict[str, Callable[[Study], Figure]] = {
    "modes": modes,
    "turn": turn,
    "limits": limits,
    "where": where,
    "phases": over_phases,
    "frozen": frozen,
}


def _at(study: Study, layout: str, place: str, bow: float) -> Case:
    return replace(study.base, layout=layout, where=place, bow=bow)


def _peak_to_peak(found: Measured, of: str, what: str) -> float:
    return 1e3 * found.orbit(of) if what == "orbit" else found.peak_to_peak(of, what)


def _ordered(count: int) -> list[Any]:
    """Return colours from dark to light; colour-blind readers see the same order."""
    return list(mpl.colormaps["viridis"](np.linspace(0.0, 0.92, count)))
