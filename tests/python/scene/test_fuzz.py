"""Random Python descriptions: each gives a system or a `GearbowError`.

`make fuzz` tries many more, including texts (`tests/rust/fuzz.rs`).
"""

from __future__ import annotations

import copy
import os
import time
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import gearbow as gb
from gearbow._core import Model
from reference.machines import bowed_pair

pytestmark = pytest.mark.implausible

TIMES = os.environ.get("GEARBOW_CASES")

leaves = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(-3, 3),
    st.floats(),
    st.sampled_from([0.0, -1.0, 1e-300, 1e300, 10**9, 2**63, 2**64]),
    st.text(max_size=5),
    st.sampled_from(["g1", "input", "gears", "sharp", "half_sine", "square"]),
    st.binary(max_size=3),
    st.complex_numbers(),
)
anything = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=8), inner, max_size=4)
    ),
    max_leaves=8,
)


def places(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the path of every entry of a description."""
    inner = data.items() if isinstance(data, dict) else enumerate(data)
    found = []
    for key, value in inner:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places(value, (*path, key))
    return found


SYSTEM = bowed_pair().description
FILM = gb.JournalBearing(
    "input",
    0.5,
    diameter=0.05,
    length=0.025,
    clearance=5e-5,
    viscosity=0.03,
    film="finite",
    grooves=[(0.0, 0.35), (3.0, 0.35)],
)
ROLLING = gb.RollingBearing(
    "input",
    0.0,
    elements=9,
    element_diameter=0.0127,
    pitch_diameter=0.065,
    clearance=1e-5,
    hertz_stiffness=1e10,
    contact_angle=0.2,
    damping=100.0,
    phase=0.1,
    inner_groove=0.52,
    outer_groove=0.53,
)
#: The same with an oil film, whose table takes seconds and is not computed again for a change of another entry.
WITH_FILM = {**SYSTEM, "bearings": [*SYSTEM["bearings"][:-1], FILM._describe("bearing")]}
#: The same with rolling elements.
WITH_BALLS = {**SYSTEM, "bearings": [ROLLING._describe("bearing"), *SYSTEM["bearings"][1:]]}
#: The same with helical teeth in the first stage.
HELICAL = {
    **SYSTEM,
    "gears": [
        {**gear, "helix_angle": {"g1": 0.25, "g2": -0.25}[gear["name"]]}
        if gear["name"] in ("g1", "g2")
        else gear
        for gear in SYSTEM["gears"]
    ],
}


@st.composite
def descriptions(draw: st.DrawFn) -> Any:
    if draw(st.integers(0, 19)) == 0:
        return draw(anything)
    chosen = {0: WITH_FILM, 1: WITH_BALLS, 2: HELICAL}.get(draw(st.integers(0, 5)), SYSTEM)
    description = copy.deepcopy(chosen)
    for _ in range(draw(st.integers(1, 3))):
        *path, last = draw(st.sampled_from(places(chosen)))
        here: Any = description
        try:
            for key in path:
                here = here[key]
            here[last] = draw(anything)
        except (LookupError, TypeError):  # an earlier change has removed this entry
            continue
    return description


@settings(
    max_examples=250 * int(TIMES or 1),
    derandomize=TIMES is None,
    database=None,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)
@given(descriptions())
def test_every_description_gives_a_system_or_an_error(description: Any):
    begun = time.monotonic()
    try:
        model = Model(description)
    except gb.GearbowError:
        pass
    else:
        assert Model(model.description()).to_toml() == model.to_toml()
    assert time.monotonic() - begun < 20.0  # most take a millisecond, and machines may be busy


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"output_step": 1e-12}, "^output_step: .* 1e\\+13 times"),
        ({"output_step": 5e-324}, "^output_step: "),
        ({"output_step": 1e-10}, "^output_step: .* 1e\\+11 times"),
    ],
    ids=str,
)
def test_an_array_larger_than_the_memory_is_refused_before_allocation(options, text):
    with pytest.raises(gb.SceneError, match=text):
        bowed_pair().simulate(10.0, 100.0, **options)


def test_more_elements_than_a_system_may_have_are_refused():
    with pytest.raises(gb.SceneError, match=r"^shafts\[0\]: .* 1000000000 elements"):
        gb.RotorSystem([gb.Shaft("a", length=1.0, outer_diameter=0.1, elements=10**9)])


def test_the_largest_allowed_number_of_times():
    assert np.size(bowed_pair().simulate(1e-3, 100.0, output_step=1e-6, record=[]).time) == 1001
