"""What the data cannot separate is named; what they can is not."""

from __future__ import annotations

import re

import numpy as np
import pytest

import gearbow as gb
from test_identify import MICRON, PROBES, SPEEDS, WANTED, bent_pair, noisy, unbent, vectors

#: First natural speed of the pair on its bearings [rad/s].
FIRST = 1457.0
UNBALANCE = [gb.unknown.unbalance("g1"), gb.unknown.unbalance(("input", 0.25))]
MIRRORED = [gb.unknown.unbalance(("input", 0.1)), gb.unknown.unbalance(("input", 0.4))]
BOW = [gb.unknown.bow("input")]


def low(share: float) -> np.ndarray:
    """Return speeds up to a share of the first natural speed."""
    return FIRST * share * np.linspace(0.3, 1.0, 8)


#: Speeds, probes, unknowns, run-out, and a pattern of what is said.
SCENES = [
    *(
        (
            low(share),
            PROBES[:count],
            BOW,
            True,
            r"^bow of input, half wave 1.* and run-out of .*no speed is above 0\.0",
        )
        for share in (0.01, 0.02, 0.03)
        for count in (1, 2)
    ),
    *(
        (
            speeds,
            PROBES,
            UNBALANCE,
            False,
            r"^unbalance of g1 and unbalance of input at 0\.25 m: only their sum",
        )
        for speeds in (SPEEDS, low(0.8), low(0.5))
    ),
    *(
        (
            SPEEDS[:n],
            PROBES,
            [gb.unknown.unbalance("g2"), *WANTED],
            False,
            r"^unbalance of g2: unknown, because no probe has output",
        )
        for n in (4, 8, 12)
    ),
    *(
        (
            low(share),
            PROBES[:1],
            [gb.unknown.bow("input", n)],
            False,
            (
                # sin(2πx/L)/sin(πx/L) at the probe
                r"^bow of input, half wave 1 and .* 2: only the first plus 1\.18 ∠ 0° times the second"
                if n == 2
                else r"^bow of input, half wave 1, .* and .* 3: only their combined effect .*no speed"
            ),
        )
        for share in (0.01, 0.03)
        for n in (2, 3)
    ),
    *(
        (
            low(share),
            PROBES[:1],
            [gb.unknown.bow("input", points=[0.1, 0.2, 0.3, 0.4])],
            False,
            r"^bow of input at 0\.1 m, .* and bow of input at 0\.4 m: only their combined effect",
        )
        for share in (0.02, 0.3)
    ),
    *(
        (
            speeds,
            [gb.Probe("input", 0.25)],
            MIRRORED,
            False,
            r"^unbalance of input at 0\.1 m and unbalance of input at 0\.4 m: only their sum",
        )
        for speeds in (SPEEDS, low(0.8))
    ),
]


@pytest.mark.parametrize("scene", range(len(SCENES)))
def test_combinations_that_the_data_cannot_separate_are_named(scene):
    speeds, probes, wanted, runout, pattern = SCENES[scene]
    measured = gb.Measurement(speeds, noisy(vectors(bent_pair(), speeds, probes), scene), probes)
    found = gb.identify(unbent(bent_pair()), measured, wanted, runout=runout, noise=MICRON)
    assert any(re.search(pattern, text) for text in found.inseparable), found.inseparable
    assert "not separable: " in str(found)


def test_there_are_twenty_scenes():
    assert len(SCENES) == 20


@pytest.mark.parametrize("runout", [False, True])
def test_what_the_data_separate_is_not_named(runout):
    measured = gb.Measurement(SPEEDS, noisy(vectors(bent_pair(), SPEEDS, PROBES), 5), PROBES)
    found = gb.identify(unbent(bent_pair()), measured, WANTED, runout=runout, noise=MICRON)
    assert found.inseparable == ()
    assert found.singular_values.min() > 2.0


def test_a_prior_of_the_run_out_narrows_the_interval_of_the_bow():
    speeds = low(0.03)
    measured = gb.Measurement(speeds, vectors(bent_pair(), speeds, PROBES), PROBES)
    system = unbent(bent_pair())
    wide = gb.identify(system, measured, BOW, noise=MICRON)
    known = [*BOW, gb.unknown.runout(prior=3e-6)]
    narrow = gb.identify(system, measured, known, noise=MICRON)
    # Three probes average the prior: 3 µm/√3 over a shape between 0.6 and 0.8 at their places.
    assert narrow.half_widths[0, 0] < 7e-6
    assert wide.half_widths[0, 0] > 60e-6


def test_detectable_bows_are_detected_in_95_percent():
    system = unbent(bent_pair())
    measured = gb.Measurement(SPEEDS, vectors(bent_pair(), SPEEDS, PROBES), PROBES)
    found = gb.identify(system, measured, WANTED, noise=MICRON)
    numbers = np.random.default_rng(1)
    root = np.linalg.cholesky(found.covariance[:2, :2])
    drawn = found.detectable[0] + (root @ numbers.standard_normal((2, 4000))).T @ [1.0, 1j]
    # The threshold of 5 % for χ² with two degrees of freedom.
    sizes = np.abs(drawn) / np.sqrt(found.covariance[0, 0])
    # 4,000 samples have a standard error of 0.35 %.
    assert np.mean(sizes > np.sqrt(-2.0 * np.log(0.05))) == pytest.approx(0.95, abs=0.015)


def test_unknowns_that_share_a_doubt_are_named():
    # bow and run-out are inseparable at low speeds, and the unbalance takes what the bow leaves
    speeds = low(0.1)
    measured = gb.Measurement(speeds, noisy(vectors(bent_pair(), speeds, PROBES), 1), PROBES)
    system = unbent(bent_pair())
    (text,) = gb.identify(system, measured, WANTED, noise=MICRON).inseparable
    assert text.endswith("; this doubt is most of the interval of unbalance of g1")
    # an independent proof: with the bow known, the unbalance has a far narrower interval
    bent = system.replace(shafts=bent_pair().shafts)
    unbalance = gb.unknown.unbalance("g1")
    alone = gb.identify(bent, measured, [unbalance], noise=MICRON)
    beside = gb.identify(system, measured, WANTED, noise=MICRON)
    assert alone.half_widths[0, 0] < 0.5 * beside.half_widths[1, 0]
    assert not alone.inseparable
