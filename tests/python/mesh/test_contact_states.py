"""Contact of the flanks over a run: states at recorded instants, and shares of the time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from gearbow.recording.record import first_contact
from reference.machines import separating_pair

MESH = ("pinion", "wheel")
SPEED = 820.0


def run(system: gb.RotorSystem, turns: float = 4.0, step: float = 1e-4) -> gb.Response:
    turn = 2.0 * np.pi / SPEED
    return system.simulate(turns * turn, SPEED, output_step=step * turn * 10, record=["meshes"])


def kinds(response: gb.Response) -> set[str]:
    return {event.kind for event in response.events}


@pytest.fixture(scope="module")
def rattling() -> gb.Response:
    """The teeth separate; the back flanks meet too."""
    return run(separating_pair(3.5e-4, 1e-4))


@pytest.fixture(scope="module")
def tight() -> gb.Response:
    """The bow reduces the centre distance by more than the backlash allows."""
    return run(separating_pair(3.5e-4, 5e-5))


def test_the_contact_agrees_with_the_force_and_the_stiffness(rattling):
    mesh = rattling.mesh(MESH)
    assert {"separation", "contact", "back contact"} <= kinds(rattling)
    apart = mesh.contact == gb.results.Contact.NONE
    assert apart.any()
    assert np.all(mesh.force[apart] == 0.0)
    assert np.all(mesh.stiffness[apart] == 0.0)
    assert np.all(mesh.stiffness[~apart] > 0.0)
    # Damping may give a flank that is about to separate a force of round-off.
    assert np.all(mesh.force[mesh.contact == gb.results.Contact.DRIVE] > -1e-6)
    assert np.all(mesh.force[mesh.contact == gb.results.Contact.BACK] < 1e-6)


def test_both_flanks_have_twice_the_stiffness(tight):
    mesh = tight.mesh(MESH)
    assert "tight" in kinds(tight)
    both = mesh.contact == gb.results.Contact.BOTH
    assert both.any()
    np.testing.assert_allclose(mesh.stiffness[both], 4e8)
    np.testing.assert_allclose(mesh.stiffness[mesh.contact == gb.results.Contact.DRIVE], 2e8)


@pytest.mark.parametrize("geometry", ["live", "frozen"])
def test_the_contact_before_the_first_event_follows_from_the_backlash(geometry):
    # The bow alone closes the gap at the start, or does not; the phase turns it.
    for phase, backlash in ((0.0, 2e-5), (np.pi, 2e-5), (0.0, None), (np.pi, 8e-4)):
        system = separating_pair(2e-4, backlash)
        bow = gb.Bow.half_sine(2e-4, phase=phase)
        system = system.replace(shafts=[replace(system.shafts[0], bow=bow), system.shafts[1]])
        found = system.simulate(
            2e-5, SPEED, output_step=1e-6, record=["meshes"], geometry=geometry
        ).mesh(MESH)
        flanks = {0: 0, 1: 1, 2: 1, 3: 2}
        expected = np.array([flanks[state] for state in found.contact.tolist()]) * 2e8
        np.testing.assert_allclose(found.stiffness, expected)


def test_shares_are_exact_times_between_events(rattling):
    shares = rattling.contact_shares(MESH)
    assert sum((shares.drive, shares.back, shares.both, shares.none)) == pytest.approx(1.0)
    samples = np.bincount(rattling.mesh(MESH).contact, minlength=4) / rattling.time.size
    given = (shares.none, shares.drive, shares.back, shares.both)
    # The share from samples is wrong by at most one sample for each change of the contact.
    error = len(rattling.events) / rattling.time.size
    np.testing.assert_allclose(given, samples, atol=error)
    assert shares.lost == shares.back + shares.none > 0.05
    changes = [event for event in rattling.events if event.kind in ("separation", "back contact")]
    begin = changes[-1].time - rattling.time[0]
    late = rattling.contact_shares(MESH, skip_time=begin)
    assert late != shares
    with pytest.raises(gb.SceneError, match=r"^skip_time: "):
        rattling.contact_shares(MESH, skip_time=1.0)


def test_a_mesh_without_backlash_never_loses_contact():
    response = run(separating_pair(3.5e-4, None), turns=1.0)
    assert response.mesh(MESH).force.min() < 0.0
    assert set(response.mesh(MESH).contact) == {gb.results.Contact.DRIVE}
    assert response.contact_shares(MESH) == gb.results.ContactShares(1.0, 0.0, 0.0, 0.0)


def test_a_file_and_a_lower_rate_keep_the_contact(rattling, tmp_path: Path):
    rattling.save(tmp_path / "run.npz")
    loaded = gb.Response.load(tmp_path / "run.npz")
    np.testing.assert_array_equal(loaded.mesh(MESH).contact, rattling.mesh(MESH).contact)
    slow = rattling.resample(0.25 / np.diff(rattling.time).max())
    at = np.interp(slow.time, rattling.time, np.arange(rattling.time.size))
    exact = np.isclose(at, np.rint(at), atol=1e-6)
    same = rattling.mesh(MESH).contact[np.rint(at[exact]).astype(int)]
    np.testing.assert_array_equal(slow.mesh(MESH).contact[exact], same)


@pytest.mark.parametrize(
    ("force", "stiffness", "contact"),
    [(5.0, 1e8, "DRIVE"), (-5.0, 1e8, "BACK"), (0.0, 0.0, "NONE")],
)
def test_without_a_scene_the_force_tells_the_first_contact(force, stiffness, contact):
    mesh = {"force": np.array([force]), "stiffness": np.array([stiffness])}
    assert first_contact(np.zeros(1), mesh, [], None) is gb.results.Contact[contact]


def test_a_state_has_a_name():
    names: Mapping[int, str] = {state.value: state.name for state in gb.results.Contact}
    assert names == {0: "NONE", 1: "DRIVE", 2: "BACK", 3: "BOTH"}
