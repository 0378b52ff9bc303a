"""Stresses of the shafts, for a report."""

from collections.abc import Iterator

import numpy as np

from gearbow._result import ROUND_OFF, Column, Written
from gearbow.report.page import Block, Table, note, picture
from gearbow.report.shared import Contents
from gearbow.report.texts import say, word

#: How tables write stresses.
_MPA = Written("MPa", 1e-6)


def strength(contents: Contents) -> Iterator[Block]:
    """Give the worst section of each shaft, its stresses and its utilisation."""
    options = contents.options
    found = contents.system.stresses(
        contents.speed,
        endurance_limit=options.endurance_limit,
        tensile_strength=options.tensile_strength,
    )
    limited = np.isfinite(found.utilisation)
    measure = np.where(limited, found.utilisation, found.amplitude)
    shafts = [shaft for shaft, *_ in found.sections]
    worst = [
        max((i for i, own in enumerate(shafts) if own == name), key=lambda i: measure[i])
        for name in dict.fromkeys(shafts)
    ]
    least = ROUND_OFF * float(found.amplitude.max(initial=0.0))
    pairs = {"bending": found.bending, "axial": found.axial, "torsion": found.torsion}
    stresses = {
        f"{name} {kind}": values[:, k]
        for name, values in pairs.items()
        for k, kind in enumerate(("mean", "±"))
    }
    stresses |= {"equivalent mean": found.mean, "equivalent ±": found.amplitude}
    use = [Column("utilisation", found.utilisation[worst], "", ".3f")] if limited.any() else []
    yield Table.of(
        say("The worst section of each shaft"),
        [
            Column("shaft", [shafts[i] for i in worst]),
            Column("position", np.array([found.sections[i][1] for i in worst]), "m"),
            *(
                Column(name, values[worst], "Pa", ".4g", _MPA, least)
                for name, values in stresses.items()
            ),
            Column("notch", [found.notches[i] for i in worst]),
            *use,
        ],
        [
            say(
                "Nominal stresses of the turning shafts by the static equilibrium, bow and "
                "unbalance; ± is the amplitude. The equivalent amplitude has the notch factors "
                "(bending / torsion)."
            ),
            *(
                [say("Excitations that are not contained: {names}.", names=names)]
                if (names := ", ".join(map(word, found.left_out)))
                else []
            ),
        ],
    )
    open_steps = sum(text == "none given" for text in found.notches)
    if open_steps:
        yield note(
            "Sections at a step of the diameter without notch factors: {count}. Their real "
            "stresses are larger.",
            warning=True,
            count=open_steps,
        )
    yield picture(found.plot(), say("Equivalent stresses along the shafts."))
    i = found.worst
    shaft, x, _ = found.sections[i]
    values = {
        "shaft": shaft,
        "position": f"{1e3 * x:.4g}",
        "amplitude": _written(found.amplitude[i], least),
        "mean": _written(found.mean[i], least),
    }
    if not limited.any():
        contents.find(
            "Largest stress: amplitude {amplitude} MPa, mean {mean} MPa, {shaft} at {position} mm "
            "(no endurance limit was given).",
            **values,
        )
        return
    contents.find(
        "Largest utilisation of a shaft: {use} (amplitude {amplitude} MPa, mean {mean} MPa, {shaft}"
        " at {position} mm).",
        warning=bool(found.utilisation[i] > 1.0),
        use=f"{found.utilisation[i]:.3f}",
        **values,
    )


def _written(stress: float, least: float) -> str:
    """Write a stress [Pa] in MPa; what is not above round-off is zero."""
    return f"{1e-6 * stress if abs(stress) > least else 0.0:.4g}"
