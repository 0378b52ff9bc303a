"""Stresses of the shafts of a system at a speed."""

from collections.abc import Mapping, Sequence

from gearbow._convert import number
from gearbow._progress import working
from gearbow._types import StrengthLine
from gearbow.analysis.protocol import System
from gearbow.description.layout import left_out
from gearbow.description.part import parts
from gearbow.description.shafts import Notch
from gearbow.results.stresses import Strength, Stresses, Tones, collect, of_tones, places_of
from gearbow.system.linear import static, synchronous


def stresses(
    self: System,
    speed: float,
    *,
    endurance_limit: float | Mapping[str, float] | None = None,
    tensile_strength: float | Mapping[str, float] | None = None,
    line: StrengthLine = "goodman",
    notches: Sequence[Notch] | None = None,
    progress: bool | None = None,
) -> Stresses:
    """Find mean and alternating stresses of the turning shafts at a speed.

    They follow from the section forces of the static equilibrium and of the synchronous response.
    `Response.stresses` gives those of a run, with tooth forces over the mesh cycle.

    Parameters
    ----------
    speed : float
        Speed of the reference shaft [rad/s].
    endurance_limit : float or mapping, optional
        Stress amplitude that a smooth specimen of the size of the shaft endures without a mean
        stress [Pa], for all shafts or by name. None gives no utilisation.
    tensile_strength : float or mapping, optional
        Tensile strength of the material [Pa], for the line of mean stresses.
    line : {"goodman", "din743"}
        How a mean stress lowers the endured amplitude.
    notches : sequence of Notch, optional
        Notches in place of those of the system.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Stresses
        Stresses at the worst fibre of each section: at the nodes of the shafts and at notches.

    Raises
    ------
    ConvergenceError
        If there is no equilibrium, or the residual of a response exceeds 1e-4.
    """
    speed = number(speed, "speed")
    given = self.notches if notches is None else tuple(parts(notches, Notch, "notches"))
    names = [shaft.name for shaft in self.shafts]
    strength = Strength.of(names, endurance_limit, tensile_strength, line)
    with working(progress, "stresses"):
        rest = static(self, speed).state
        response = synchronous(self, [speed])
    found = []
    frequencies = self.speed_ratios * speed
    for index, name in enumerate(names):
        positions = places_of(self._model, name, given)
        motions = {
            "phasors": response.amplitudes[0],
            "frequencies": frequencies.tolist(),
            "speeds": [speed] * len(names),
            "bowed": [source == name for source in names],
        }
        tones = Tones(
            standing=self._model.static_section_forces(name, positions, rest, speed),
            phasors=self._model.harmonic_section_forces(name, positions, motions),
            frequencies=frequencies,
            spin=float(frequencies[index]),
        )
        sections = self._model.sections(name, positions)
        found += [
            (section, factors, of_tones(tones, k, factors))
            for k, (section, factors) in enumerate(sections)
        ]
    return collect(found, given, strength, left_out(self))
