"""What the runs of a study say, as tables in Markdown: one function for each question."""

import math
from collections.abc import Callable
from dataclasses import replace

from gearbow.study.case import ALL, cases, phases, system
from gearbow.study.limits import limits
from gearbow.study.measure import Measured
from gearbow.study.table import markdown
from gearbow.study.view import Study

__all__ = ["TABLES"]

_MICRO = 1e6


def runs(study: Study) -> str:
    """Tell how many runs there were, and what error they keep.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        Sentences and a table.
    """
    count = len(cases(study.settings))
    # Without torque there is hardly a force whose swing could be taken.
    unsettled = max(
        found.unsettled()
        for case, found in study.results.items()
        if found.sound and case.torque == study.base.torque
    )
    rows = []
    for bow in (0.0, study.settings.phase_bow):
        given = replace(study.base, bow=bow)
        exact = study[replace(given, accuracy="reference")]
        finer = study[replace(given, refine=2)]
        for what, other in (
            (f"integration (`{study.settings.accuracy}`)", exact),
            ("elements (against twice as many)", finer),
        ):
            errors = [
                max(study[given].apart(other, of, names) for of in items)
                for items, names in ((study.gears, ("v", "w")), (study.pairs, ("force",)))
            ]
            rows.append([what, f"{bow:g}", *(f"{error:.1e}" for error in errors)])
    table = markdown(["error of", "bow / radius", "displacement", "mesh force"], rows)
    return (
        f"{count} runs, each over {study.settings.settle + 1} turns of the output shaft, the last "
        f"of which is kept.\nWhat repeats after that turn does so to {unsettled:.0e} of its swing "
        f"under torque, where no pair loses contact.\n\n{table}"
    )


def modes(study: Study) -> str:
    """Tabulate the modes at rest.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        One row for each mode; frequencies of every layout.
    """
    found = [
        system(study.settings, replace(study.base, layout=layout)).modes(count=study.settings.modes)
        for layout in study.settings.layouts
    ]
    titles = ["mode", *(f"{layout} [Hz]" for layout in study.settings.layouts), "whirl", "motion"]
    names, whirl = found[0].names(), found[0].whirl
    rows = [
        [
            f"{mode + 1}",
            *(f"{each.frequencies_hz[mode]:.1f}" for each in found),
            whirl[mode],
            names[mode],
        ]
        for mode in range(study.settings.modes)
    ]
    return markdown(titles, rows)


def growth(study: Study) -> str:
    """Tabulate swings against the bow.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        One row for each bow, on all shafts.
    """
    titles = ["bow / radius", *(f"{gear} [µm]" for gear in study.gears)]
    titles += [f"ε {pair}" for pair in study.pairs]
    titles += [f"α {pair} [°]" for pair in study.pairs]
    titles += [f"force {pair} [N]" for pair in study.pairs]
    rows = []
    for bow in study.settings.bows:
        found = study[replace(study.base, bow=bow)]
        row = [f"{bow:g}", *(f"{_MICRO * found.orbit(gear):.0f}" for gear in study.gears)]
        row += [f"{found.swing(pair, 'contact_ratio'):.3f}" for pair in study.pairs]
        row += [_degrees(found.swing(pair, "pressure_angle")) for pair in study.pairs]
        row += [f"{found.swing(pair, 'force'):.0f}" for pair in study.pairs]
        rows.append(row)
    return markdown(titles, rows)


def loads(study: Study) -> str:
    """Tabulate swings at every torque and speed.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        One row for each torque and speed, at the bow of the phases.
    """
    titles = ["torque [N m]", "speed [rad/s]", *(f"{gear} [µm]" for gear in study.gears)]
    titles += [f"ε {pair}: mean" for pair in study.pairs]
    titles += [f"ε {pair}: swing" for pair in study.pairs]
    rows = []
    for torque in study.settings.torques:
        for speed in study.settings.speeds:
            found = study[replace(study.bent, torque=torque, speed=speed)]
            row = [f"{torque:g}", f"{speed:g}"]
            row += [f"{_MICRO * found.orbit(gear):.0f}" for gear in study.gears]
            row += [f"{found.mean(pair, 'contact_ratio'):.4f}" for pair in study.pairs]
            row += [f"{found.swing(pair, 'contact_ratio'):.4f}" for pair in study.pairs]
            rows.append(row)
    return markdown(titles, rows)


def ratio(study: Study) -> str:
    """Tabulate the displacement of gears over the bow.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        One row for each gear: smallest and largest over all bows, speeds, torques and layouts.
    """
    titles = ["gear", "peak to peak / bow", "amplitude / bow"]
    rows = []
    for gear in study.gears:
        found = [
            result.orbit(gear) / study.amplitude(case.bow)
            for case, result in study.results.items()
            if case.bow and case.where == ALL and case.phases == (0.0, 0.0) and result.sound
        ]
        low, high = min(found), max(found)
        rows.append([gear, f"{low:.2f} to {high:.2f}", f"{low / 2.0:.2f} to {high / 2.0:.2f}"])
    return markdown(titles, rows)


def shift(study: Study) -> str:
    """Tabulate what a bow on one shaft does to each pair: at phase 0, in the mean, as a swing.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        One row for each shaft and each of its pairs, with the closed forms of a steady rotation.
    """
    bow = study.bows[0]
    case = replace(study.base, torque=min(study.settings.torques), speed=min(study.settings.speeds))
    straight = study[case]
    titles = ["bow on", "pair", "Δε at phase 0", "Δα at phase 0 [°]", "mean Δε", "closed form"]
    titles += ["mean Δα [°]", "closed form", "swing of ε", "closed form"]
    rows = []
    for where in study.shafts:
        found = study[replace(case, bow=bow, where=where)]
        for pair in study.pairs:
            if where not in [study.gear(gear)["shaft"] for gear in pair.split("/")]:
                continue
            distance, angle, pitch = study.pair(pair)
            b = found.swing(pair, "centre_distance") / 2.0
            first = [
                float(found.signals[pair, name][0] - straight.signals[pair, name][0])
                for name in ("contact_ratio", "pressure_angle")
            ]
            mean = [
                found.mean(pair, name) - straight.mean(pair, name)
                for name in ("contact_ratio", "pressure_angle")
            ]
            contact = b**2 * math.cos(2 * angle) / (4 * pitch * distance * math.sin(angle) ** 3)
            pressure = -(b**2) / (4 * distance**2 * math.tan(angle) * math.sin(angle) ** 2)
            rows.append(
                [
                    where,
                    pair,
                    f"{first[0]:+.3f}",
                    f"{math.degrees(first[1]):+.3f}",
                    f"{mean[0]:+.5f}",
                    f"{contact:+.5f}",
                    f"{math.degrees(mean[1]):+.5f}",
                    f"{math.degrees(pressure):+.5f}",
                    f"{found.swing(pair, 'contact_ratio'):.4f}",
                    f"{2.0 * b / (pitch * math.sin(angle)):.4f}",
                ]
            )
    return markdown(titles, rows)


def which(study: Study) -> str:
    """Tabulate swings with the bow on one shaft at a time.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        One row for each layout and shaft.
    """
    titles = ["layout", "bow on", *(f"ε {pair}" for pair in study.pairs)]
    titles += [f"α {pair} [°]" for pair in study.pairs]
    titles += [f"largest force {pair} [N]" for pair in study.pairs]
    titles += [f"{gear} [µm]" for gear in study.gears]
    rows = []
    for layout in study.settings.layouts:
        for where in (*study.shafts, ALL):
            found = study[replace(study.bent, layout=layout, where=where)]
            row = [layout, where]
            row += [f"{found.swing(pair, 'contact_ratio'):.3f}" for pair in study.pairs]
            row += [_degrees(found.swing(pair, "pressure_angle")) for pair in study.pairs]
            row += [f"{found.largest(pair, 'force'):.0f}" for pair in study.pairs]
            row += [f"{_MICRO * found.orbit(gear):.0f}" for gear in study.gears]
            rows.append(row)
    return markdown(titles, rows)


def layouts(study: Study) -> str:
    """Tabulate what the place of the second gear changes.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        One row for each bow and layout.
    """
    pair = study.pairs[0]
    titles = ["bow / radius", "layout", *(f"{gear} [µm]" for gear in study.gears)]
    titles += [f"ε {pair}: mean", "smallest", "largest"]
    titles += [f"α {pair} [°]: mean", "smallest", "largest"]
    rows = []
    for bow in (0.0, study.bows[0], study.settings.phase_bow):
        for layout in study.settings.layouts:
            found = study[replace(study.base, layout=layout, bow=bow)]
            row = [f"{bow:g}", layout]
            row += [f"{_MICRO * found.orbit(gear):.0f}" for gear in study.gears]
            for name, form in (("contact_ratio", "{:.4f}".format), ("pressure_angle", _degrees)):
                row += [
                    form(getattr(found, which)(pair, name))
                    for which in ("mean", "smallest", "largest")
                ]
            rows.append(row)
    return markdown(titles, rows)


def frozen(study: Study) -> str:
    """Tabulate what a constant line of action and contact ratio would have missed.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        One row for each speed and bow: swing of the forces with both geometries, and how far apart
        forces and displacements are, over the swing with the live one.
    """
    titles = ["speed [rad/s]", "bow / radius"]
    for pair in study.pairs:
        titles += [f"force {pair}: swing live [N]", "frozen [N]", "missed"]
    titles += ["displacement missed"]
    rows = []
    for speed in study.settings.speeds:
        for bow in study.settings.bows:
            live = study[replace(study.base, speed=speed, bow=bow)]
            if not live.sound:
                continue
            still = study[replace(study.base, speed=speed, bow=bow, geometry="frozen")]
            row = [f"{speed:g}", f"{bow:g}"]
            for pair in study.pairs:
                row += [f"{live.swing(pair, 'force'):.0f}", f"{still.swing(pair, 'force'):.0f}"]
                row += [_percent(still.apart(live, pair, ("force",)))]
            worst = max(still.apart(live, gear, ("v", "w")) for gear in study.gears)
            rows.append([*row, _percent(worst)])
    return markdown(titles, rows)


def turned(study: Study) -> str:
    """Tabulate what the phases of the bows change.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    str
        One row for each layout and quantity: the mildest and the worst phases.
    """
    titles = ["layout", "quantity", "mildest", "worst", "phases of the worst [°]"]
    rows = []
    grid = [
        (second, third) for second in phases(study.settings) for third in phases(study.settings)
    ]
    for layout in study.settings.layouts:
        found = {
            angles: study[replace(study.bent, layout=layout, phases=angles)] for angles in grid
        }
        for pair in study.pairs:
            for title, name, value in (
                ("smallest ε", "contact_ratio", Measured.smallest),
                ("largest α [°]", "pressure_angle", Measured.largest),
                ("largest force [N]", "force", Measured.largest),
            ):
                sign = -1.0 if value is Measured.smallest else 1.0
                numbers = {angles: value(each, pair, name) for angles, each in found.items()}
                ordered = sorted(numbers, key=lambda angles: sign * numbers[angles])
                form = {
                    "contact_ratio": "{:.3f}".format,
                    "pressure_angle": _degrees,
                    "force": "{:.0f}".format,
                }[name]
                worst = ", ".join(f"{math.degrees(angle):.0f}" for angle in ordered[-1])
                ends = (form(numbers[ordered[0]]), form(numbers[ordered[-1]]))
                rows.append([layout, f"{title} of {pair}", *ends, worst])
    return markdown(titles, rows)


#: The tables by the name that ``python -m gearbow study --print`` takes.
TABLES: dict[str, Callable[[Study], str]] = {
    "runs": runs,
    "modes": modes,
    "growth": growth,
    "loads": loads,
    "limits": limits,
    "ratio": ratio,
    "shift": shift,
    "which": which,
    "layouts": layouts,
    "frozen": frozen,
    "phases": turned,
}


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.3f}"


def _percent(part: float) -> str:
    return f"{100.0 * part:.0f} %" if part >= 0.1 else f"{100.0 * part:.1f} %"
