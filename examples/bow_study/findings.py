"""Findings of the bow study as tables in Markdown: one function for each table."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from bow_limits import LIMITS, limits
from cases import ALL, radius, train
from runs import Measured, Study

_MICRO = 1e6


def markdown(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [titles, ["---"] * len(titles), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def runs(study: Study) -> str:
    """State the number of runs, their periodicity and their numerical error."""
    count = len(study.results)
    # Without torque the mesh force is almost zero, and so is its peak-to-peak value.
    periodicity = max(
        found.periodicity_error()
        for case, found in study.results.items()
        if found.always_in_contact and case.torque == study.base.torque
    )
    rows = []
    for bow in (0.0, study.settings.phase_bow):
        given = replace(study.base, bow=bow)
        exact = study[replace(given, accuracy="reference")]
        errors = [
            max(study[given].relative_difference(exact, of, names) for of in items)
            for items, names in ((study.gears, ("v", "w")), (study.pairs, ("force",)))
        ]
        rows.append([f"{bow:g}", *(f"{error:.1e}" for error in errors)])
    table = markdown(["bow / radius", "displacement", "mesh force"], rows)
    return (
        f"The study makes {count} runs of {study.settings.settle + 1} revolutions of the output "
        "shaft each and evaluates the last revolution.\nIn the runs under torque without loss of "
        "contact, the values at the start and at the end of this revolution\n"
        f"differ by at most {periodicity:.0e} of the peak-to-peak value.\n\n{table}"
    )


def modes(study: Study) -> str:
    """Tabulate the modes at rest."""
    found = [
        train(study.settings, replace(study.base, layout=layout)).modes(count=study.settings.modes)
        for layout in study.settings.layouts
    ]
    titles = [
        "mode",
        *(f"{layout} [Hz]" for layout in study.settings.layouts),
        "whirl",
        "largest motion",
    ]
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
    """Tabulate peak-to-peak values against the bow."""
    titles = ["bow / radius", *(f"{gear} [µm]" for gear in study.gears)]
    titles += [f"ε {pair}" for pair in study.pairs]
    titles += [f"α {pair} [°]" for pair in study.pairs]
    titles += [f"force {pair} [N]" for pair in study.pairs]
    rows = []
    for bow in study.settings.bows:
        found = study[replace(study.base, bow=bow)]
        row = [f"{bow:g}", *(f"{_MICRO * found.orbit(gear):.0f}" for gear in study.gears)]
        row += [f"{found.peak_to_peak(pair, 'contact_ratio'):.3f}" for pair in study.pairs]
        row += [_degrees(found.peak_to_peak(pair, "pressure_angle")) for pair in study.pairs]
        row += [f"{found.peak_to_peak(pair, 'force'):.0f}" for pair in study.pairs]
        rows.append(row)
    return markdown(titles, rows)


def loads(study: Study) -> str:
    """Tabulate peak-to-peak values at every torque and speed."""
    titles = ["torque [N m]", "speed [rad/s]", *(f"{gear} [µm]" for gear in study.gears)]
    titles += [f"ε {pair}: mean" for pair in study.pairs]
    titles += [f"ε {pair}: peak-to-peak" for pair in study.pairs]
    rows = []
    for torque in study.settings.torques:
        for speed in study.settings.speeds:
            found = study[replace(study.bent, torque=torque, speed=speed)]
            row = [f"{torque:g}", f"{speed:g}"]
            row += [f"{_MICRO * found.orbit(gear):.0f}" for gear in study.gears]
            row += [f"{found.mean(pair, 'contact_ratio'):.4f}" for pair in study.pairs]
            row += [f"{found.peak_to_peak(pair, 'contact_ratio'):.4f}" for pair in study.pairs]
            rows.append(row)
    return markdown(titles, rows)


def ratio(study: Study) -> str:
    """Tabulate the displacements of the gears, divided by the bow amplitude."""
    titles = ["gear", "peak-to-peak / bow", "amplitude / bow"]
    rows = []
    for gear in study.gears:
        found = [
            result.orbit(gear) / (case.bow * radius(study.settings.train.shafts[0]))
            for case, result in study.results.items()
            if case.bow
            and case.where == ALL
            and case.phases == (0.0, 0.0)
            and result.always_in_contact
        ]
        low, high = min(found), max(found)
        rows.append([gear, f"{low:.2f} to {high:.2f}", f"{low / 2.0:.2f} to {high / 2.0:.2f}"])
    return markdown(titles, rows)


def shift(study: Study) -> str:
    """Tabulate the effect of a bow on one shaft: at phase 0, on the mean, and peak-to-peak."""
    bow = study.bows[0]
    case = replace(study.base, torque=min(study.settings.torques), speed=min(study.settings.speeds))
    straight = study[case]
    titles = ["bow on", "pair", "Δε at phase 0", "Δα at phase 0 [°]", "mean Δε", "closed form"]
    titles += ["mean Δα [°]", "closed form", "peak-to-peak ε", "closed form"]
    rows = []
    for where in study.shafts:
        found = study[replace(case, bow=bow, where=where)]
        for pair in study.pairs:
            if where not in [study.gears[gear].shaft for gear in pair.split("/")]:
                continue
            teeth = study.teeth[pair]
            distance, angle, pitch = teeth.centre_distance, teeth.pressure_angle, teeth.base_pitch
            b = found.peak_to_peak(pair, "centre_distance") / 2.0
            first = [
                float(found[pair, name][0] - straight[pair, name][0])
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
                    f"{found.peak_to_peak(pair, 'contact_ratio'):.4f}",
                    f"{2.0 * b / (pitch * math.sin(angle)):.4f}",
                ]
            )
    return markdown(titles, rows)


def together(study: Study) -> str:
    """Tabulate the effect of bows on all shafts in phase: at phase 0, and on the mean."""
    case = replace(study.base, torque=min(study.settings.torques), speed=min(study.settings.speeds))
    straight, found = study[case], study[replace(case, bow=study.bows[0])]
    titles = ["pair", "Δε at phase 0", "Δα at phase 0 [°]", "mean Δε", "mean Δα [°]"]
    rows = []
    for pair in study.pairs:
        contact, pressure = (
            (
                float(found[pair, name][0] - straight[pair, name][0]),
                found.mean(pair, name) - straight.mean(pair, name),
            )
            for name in ("contact_ratio", "pressure_angle")
        )
        angles = [math.degrees(each) for each in pressure]
        first = [f"{contact[0]:+.3f}", f"{angles[0]:+.3f}"]
        rows.append([pair, *first, f"{contact[1]:+.5f}", f"{angles[1]:+.5f}"])
    return markdown(titles, rows)


def which(study: Study) -> str:
    """Tabulate the effect of a bow on one shaft at a time."""
    titles = ["layout", "bow on", *(f"ε {pair}" for pair in study.pairs)]
    titles += [f"α {pair} [°]" for pair in study.pairs]
    titles += [f"largest force {pair} [N]" for pair in study.pairs]
    titles += [f"{gear} [µm]" for gear in study.gears]
    rows = []
    for layout in study.settings.layouts:
        for where in (*study.shafts, ALL):
            found = study[replace(study.bent, layout=layout, where=where)]
            row = [layout, where]
            row += [f"{found.peak_to_peak(pair, 'contact_ratio'):.3f}" for pair in study.pairs]
            row += [_degrees(found.peak_to_peak(pair, "pressure_angle")) for pair in study.pairs]
            row += [f"{found.largest(pair, 'force'):.0f}" for pair in study.pairs]
            row += [f"{_MICRO * found.orbit(gear):.0f}" for gear in study.gears]
            rows.append(row)
    return markdown(titles, rows)


def layouts(study: Study) -> str:
    """Tabulate the effect of the position of the second gear."""
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


def limits_of_bow(study: Study) -> str:
    """Tabulate the bow at which a mesh reaches each limit, divided by the shaft radius."""
    found = limits(study.settings)
    rows = [
        [layout, where, *(found[layout, where, limit] for limit in LIMITS)]
        for layout in study.settings.layouts
        for where in (ALL, *study.shafts)
    ]
    return markdown(["layout", "bow on", *LIMITS], rows)


def frozen(study: Study) -> str:
    """Tabulate the difference between frozen and live mesh geometry."""
    titles = ["speed [rad/s]", "bow / radius"]
    for pair in study.pairs:
        titles += [f"force {pair}: live [N]", "frozen [N]", "difference"]
    titles += ["difference of displacement"]
    rows = []
    for speed in study.settings.speeds:
        for bow in study.settings.bows:
            live = study[replace(study.base, speed=speed, bow=bow)]
            if not live.always_in_contact:
                continue
            still = study[replace(study.base, speed=speed, bow=bow, geometry="frozen")]
            row = [f"{speed:g}", f"{bow:g}"]
            for pair in study.pairs:
                row += [
                    f"{live.peak_to_peak(pair, 'force'):.0f}",
                    f"{still.peak_to_peak(pair, 'force'):.0f}",
                ]
                row += [_percent(still.relative_difference(live, pair, ("force",)))]
            worst = max(still.relative_difference(live, gear, ("v", "w")) for gear in study.gears)
            rows.append([*row, _percent(worst)])
    return markdown(titles, rows)


def phase_effects(study: Study) -> str:
    """Tabulate the effect of the phases of the bows."""
    titles = ["layout", "quantity", "best", "worst", "phases of the worst [°]"]
    rows = []
    angles = study.settings.phases
    grid = [(second, third) for second in angles for third in angles]
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


#: Tables by their name, the argument of ``--print``.
TABLES: dict[str, Callable[[Study], str]] = {
    "runs": runs,
    "modes": modes,
    "growth": growth,
    "loads": loads,
    "limits": limits_of_bow,
    "ratio": ratio,
    "shift": shift,
    "together": together,
    "which": which,
    "layouts": layouts,
    "frozen": frozen,
    "phases": phase_effects,
}


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.3f}"


def _percent(part: float) -> str:
    return f"{100.0 * part:.0f} %" if part >= 0.1 else f"{100.0 * part:.1f} %"
