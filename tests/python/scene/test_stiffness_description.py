"""Stiffness models, relief, error and run-out: representation, values in the core, round trip."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import gearbow as gb
from reference.cases import each_case
from reference.machines import twisting_pair

MODELS = {
    "constant": (gb.Stiffness.constant(2e8), {"mean": 2e8}),
    "iso6336": (gb.Stiffness.iso6336(), {}),
    "square": (gb.Stiffness.square(2e8), {"mean": 2e8}),
    "square pair": (
        gb.Stiffness.square(pair=1.5e8, engagement="sharp", phase="prescribed"),
        {"pair": 1.5e8, "engagement": "sharp", "phase": "prescribed"},
    ),
    "parabolic": (
        gb.Stiffness.parabolic(pair=1.5e8, end_ratio=0.7, engagement=0.25),
        {"pair": 1.5e8, "end_ratio": 0.7, "engagement": 0.25},
    ),
    "potential_energy": (
        gb.Stiffness.potential_energy((0.02, 0.03), phase="twist"),
        {"bore_radii": [0.02, 0.03], "phase": "twist"},
    ),
    "table": (gb.Stiffness.table([2e8, 3e8, 1e8, 2e8]), {"values": [2e8, 3e8, 1e8, 2e8]}),
    "fourier": (
        gb.Stiffness.fourier(2e8, [3e7, 1e7], [0.5, -1.0]),
        {"mean": 2e8, "amplitudes": [3e7, 1e7], "phases": [0.5, -1.0]},
    ),
}


def cycle(system: gb.RotorSystem, rows: int = 200, **options) -> gb.results.MeshResponse:
    """Simulate one quasi-static mesh cycle."""
    duration = 2.0 * math.pi / 25.0
    times = np.linspace(0.0, duration, rows, endpoint=False)
    return system.simulate(duration, 1.0, times=times, **options).mesh(("g1", "g2"))


class TestDescription:
    """Parts become plain data, and plain data become parts."""

    @pytest.mark.parametrize("name", MODELS)
    def test_a_model_is_a_dict_of_its_arguments(self, name):
        stiffness, given = MODELS[name]
        assert stiffness._describe("stiffness") == {"model": name.split()[0], **given}

    def test_a_number_stays_a_number(self):
        assert gb.Mesh("g1", "g2", stiffness=2e8)._describe("m")["stiffness"] == 2e8
        described = gb.Mesh("g1", "g2", stiffness=np.float64(2e8))._describe("m")
        assert type(described["stiffness"]) is float

    def test_omitted_arguments_are_not_sent_to_the_core(self):
        assert gb.Mesh("g1", "g2")._describe("m") == {"driver": "g1", "driven": "g2"}
        assert gb.TipRelief(1e-5, 2e-3)._describe("r") == {"amount": 1e-5, "length": 2e-3}
        assert gb.TransmissionError()._describe("e") == {}
        assert "runout" not in gb.Gear("g1", "input", 0.05, 25)._describe("g")

    def test_arrays_equal_lists(self):
        values = np.array([2e8, 3e8, 1e8])
        assert gb.Stiffness.table(values) == gb.Stiffness.table(list(values))
        assert hash(gb.Stiffness.table(values)) == hash(gb.Stiffness.table(tuple(values)))
        harmonics = np.array([[1e-6, 0.0], [2e-6, 0.5]])
        error = gb.TransmissionError(tooth=harmonics, driven=[(3e-6, 1)], table=0.0 * values)
        assert error.tooth == ((1e-6, 0.0), (2e-6, 0.5))
        assert error._describe("error") == {
            "tooth": [[1e-6, 0.0], [2e-6, 0.5]],
            "driven": [[3e-6, 1]],
            "table": [0.0, 0.0, 0.0],
        }

    @pytest.mark.parametrize("name", MODELS)
    def test_parts_are_read_back_from_a_file(self, tmp_path, name):
        paired = name.split()[0] in {"square", "parabolic", "potential_energy"}
        system = twisting_pair(
            stiffness=MODELS[name][0],
            backlash=1e-4,
            tip_relief=gb.TipRelief(1e-5, 2e-3, "parabolic") if paired else None,
            error=gb.TransmissionError(tooth=[(1e-6, 0.5)], driver=[(2e-6, 0.0)], driven=[]),
            driver={"runout": 1e-5 + 2e-5j},
        )
        system.save(tmp_path / "pair.toml")
        loaded = gb.RotorSystem.load(tmp_path / "pair.toml")
        assert loaded.description == system.description
        assert loaded.meshes == system.meshes
        assert loaded.gears == system.gears
        copy = pickle.loads(pickle.dumps(system))
        assert copy.meshes == system.meshes

    def test_a_hand_written_file_has_the_names_of_the_parameters(self, tmp_path):
        twisting_pair().save(tmp_path / "pair.toml")
        text = (tmp_path / "pair.toml").read_text(encoding="utf-8")
        (tmp_path / "pair.toml").write_text(
            text.replace(
                'driven = "g2"\n',
                """driven = "g2"
                stiffness = { model = "parabolic", mean = 2e8, engagement = "sharp" }
                tip_relief = { amount = 1e-5, length = 2e-3 }
                error = { tooth = [[5e-6, 0.0], [1e-6, 1.0]] }
                """,
            ),
            encoding="utf-8",
        )
        assert gb.RotorSystem.load(tmp_path / "pair.toml").meshes == (
            gb.Mesh(
                "g1",
                "g2",
                stiffness=gb.Stiffness.parabolic(2e8, engagement="sharp"),
                tip_relief=gb.TipRelief(1e-5, 2e-3),
                error=gb.TransmissionError(tooth=[(5e-6, 0.0), (1e-6, 1.0)]),
            ),
        )


SQUARE = gb.Stiffness.square(2e8)


@each_case(
    ("mesh", "text"),
    [
        (
            {"stiffness": "soft"},
            r"^meshes\[0\].stiffness: must be a number or a gb.Stiffness",
        ),
        ({"stiffness": {"model": "square"}}, r"^meshes\[0\].stiffness: must be"),
        ({"stiffness": -1.0}, r"^meshes\[0\].stiffness: "),
        ({"stiffness": gb.Stiffness("banana")}, r"^meshes\[0\].stiffness.model: "),
        ({"stiffness": gb.Stiffness.square()}, r"^meshes\[0\].stiffness: needs one of mean and"),
        ({"stiffness": gb.Stiffness.square(1e8, pair=1e8)}, r"needs one of mean and pair"),
        (
            {"stiffness": gb.Stiffness.square(math.nan)},
            r"^meshes\[0\].stiffness.mean: .*nan",
        ),
        (
            {"stiffness": gb.Stiffness.square(2e8, engagement=0.7)},
            r"^meshes\[0\].stiffness.engagement: .*0.7",
        ),
        (
            {"stiffness": gb.Stiffness.square(2e8, engagement="soft")},
            r"^meshes\[0\].stiffness.engagement: .*soft",
        ),
        (
            {"stiffness": gb.Stiffness.square(2e8, engagement="sharp", phase="twist")},
            r"^meshes\[0\].stiffness.phase: ",
        ),
        (
            {"stiffness": gb.Stiffness.parabolic(2e8, end_ratio=1.5)},
            r"^meshes\[0\].stiffness.end_ratio: .*1.5",
        ),
        (
            {"stiffness": gb.Stiffness.potential_energy([0.02, 0.08])},
            r"^meshes\[0\].stiffness.bore_radii\[1\]: 0.08 m leaves no gear body",
        ),
        ({"stiffness": gb.Stiffness.table([1e8])}, r"^meshes\[0\].stiffness.values: "),
        (
            {"stiffness": gb.Stiffness.fourier(2e8, [1e7], [0.0, 1.0])},
            r"^meshes\[0\].stiffness.phases: ",
        ),
        ({"stiffness": SQUARE, "tip_relief": 1e-5}, r"^meshes\[0\].tip_relief: must be a gb.Tip"),
        (
            {"stiffness": SQUARE, "tip_relief": gb.TipRelief(1e-5, 0.0)},
            r"^meshes\[0\].tip_relief.length: ",
        ),
        (
            {"stiffness": SQUARE, "tip_relief": gb.TipRelief(1e-5, 1e-3, "round")},
            r"^meshes\[0\].tip_relief.shape: .*round",
        ),
        (
            {"stiffness": 2e8, "tip_relief": gb.TipRelief(1e-5, 1e-3)},
            r"^meshes\[0\].tip_relief: needs a stiffness model of tooth pairs",
        ),
        ({"error": 1e-6}, r"^meshes\[0\].error: must be a gb.TransmissionError"),
        (
            {"error": gb.TransmissionError(tooth=[(1e-6, math.inf)])},
            r"^meshes\[0\].error.tooth\[0\]\[1\]: ",
        ),
        ({"error": gb.TransmissionError(tooth=[1e-6])}, r"^meshes\[0\].error.tooth\[0\]"),
        ({"backlash": -1e-6}, r"^meshes\[0\].backlash: "),
        ({"driver": {"runout": complex(0.0, math.nan)}}, r"^gears\[0\].runout"),
    ],
)
def test_the_error_names_the_place_of_a_mistake(mesh, text):
    with pytest.raises(gb.SceneError, match=text):
        twisting_pair(**mesh)


def test_the_defaults_of_the_core_are_those_of_the_docstrings():
    iso = cycle(twisting_pair()).stiffness
    np.testing.assert_array_equal(
        iso, cycle(twisting_pair(stiffness=gb.Stiffness.iso6336())).stiffness
    )
    for left_out, spelt_out in (
        (SQUARE, gb.Stiffness.square(2e8, engagement=0.1, phase="prescribed")),
        (
            gb.Stiffness.parabolic(2e8),
            gb.Stiffness.parabolic(2e8, end_ratio=0.6, engagement=0.1, phase="prescribed"),
        ),
        (
            gb.Stiffness.square(2e8, engagement="sharp"),
            gb.Stiffness.square(2e8, engagement="sharp", phase="prescribed"),
        ),
        (
            gb.Stiffness.potential_energy(),
            gb.Stiffness.potential_energy((0.025, 0.025), engagement=0.1, phase="prescribed"),
        ),
        (
            gb.Stiffness.fourier(2e8, [1e7]),
            gb.Stiffness.fourier(2e8, [1e7], [0.0], phase="prescribed"),
        ),
        (
            gb.Stiffness.table([1e8, 2e8, 2e8]),
            gb.Stiffness.table([1e8, 2e8, 2e8], phase="prescribed"),
        ),
    ):
        a, b = (cycle(twisting_pair(stiffness=stiffness)) for stiffness in (left_out, spelt_out))
        np.testing.assert_array_equal(a.stiffness, b.stiffness)
        assert np.ptp(a.stiffness) > 1e6


class TestValues:
    """Each constructor gives the stiffness of its model."""

    def test_a_square_wave_is_the_pair_stiffness_times_the_number_of_pairs(self):
        mesh = cycle(twisting_pair(stiffness=gb.Stiffness.square(pair=1.5e8, engagement="sharp")))
        np.testing.assert_allclose(mesh.stiffness, 1.5e8 * mesh.pairs_in_contact)
        assert set(mesh.pairs_in_contact) == {1.0, 2.0}
        assert mesh.pairs_in_contact.mean() == pytest.approx(mesh.contact_ratio[0], abs=0.01)

    @pytest.mark.parametrize("model", [gb.Stiffness.square, gb.Stiffness.parabolic])
    def test_a_mean_is_the_mean_over_the_cycle(self, model):
        stiffness = cycle(twisting_pair(stiffness=model(2e8, phase="prescribed"))).stiffness
        assert stiffness.mean() == pytest.approx(2e8, rel=1e-3)
        assert np.ptp(stiffness) > 5e7

    def test_harmonics_follow_the_path_of_contact(self):
        harmonics = gb.Stiffness.fourier(2e8, [3e7, 1e7], [0.4, -0.7], phase="prescribed")
        spectrum = np.fft.rfft(cycle(twisting_pair(stiffness=harmonics)).stiffness) / 200
        assert spectrum[0].real == pytest.approx(2e8)
        np.testing.assert_allclose(2.0 * np.abs(spectrum[1:4]), [3e7, 1e7, 0.0], atol=1.0)

    def test_a_table_interpolates_its_values(self):
        values = np.array([2e8, 3e8, 2.5e8, 1e8])
        # The cycle begins where a pair is at the interference point: s = r α at the start.
        alpha = math.radians(20.0)
        place = alpha * 25.0 / (2.0 * math.pi)
        x = (place + np.arange(200) / 200) % 1.0
        stiffness = cycle(
            twisting_pair(stiffness=gb.Stiffness.table(values, phase="prescribed"))
        ).stiffness
        knots = np.array([0.0, 0.25, 0.5, 0.75])
        nearest = [np.argmin(np.abs((x - knot + 0.5) % 1.0 - 0.5)) for knot in knots]
        np.testing.assert_allclose(stiffness[nearest], values, rtol=0.02)

    def test_a_larger_centre_distance_has_fewer_pairs(self):
        model = gb.Stiffness.square(pair=1.5e8, engagement="sharp")
        rest, opened = (
            cycle(twisting_pair(stiffness=model, centre_distance=0.1125 + more))
            for more in (0.0, 5e-4)
        )
        assert opened.contact_ratio[0] < rest.contact_ratio[0] - 0.1
        for mesh in (rest, opened):
            mean = mesh.stiffness.mean() / 1.5e8
            assert mean == pytest.approx(mesh.contact_ratio[0], abs=0.01)

    @pytest.mark.implausible
    def test_relief_shortens_the_contact_of_a_pair(self):
        model = gb.Stiffness.square(2e8, phase="prescribed")
        plain, relieved = (
            cycle(
                twisting_pair(stiffness=model, tip_relief=relief, damping_ratio=0.1),
                initial="static",
            )
            for relief in (None, gb.TipRelief(1e-3, 2e-3))
        )
        assert plain.stiffness.mean() == pytest.approx(2e8, rel=1e-3)
        # The relief shortens a path of 15 mm by almost 2 mm at each end; the mean stiffness is that
        # of the whole path.
        lost = 4e-3 / (plain.contact_ratio[0] * 3e-3 * math.pi * math.cos(math.radians(20.0)))
        assert relieved.stiffness.mean() == pytest.approx((1.0 - lost) * 2e8, rel=0.02)

    def test_a_slow_transmission_error_does_not_change_the_force(self):
        error = gb.TransmissionError(tooth=[(5e-6, 0.0)])
        mesh = cycle(
            twisting_pair(stiffness=2e8, damping_ratio=0.3, error=error),
            initial="static",
            rtol=1e-8,
        )
        settled = mesh.force[100:]
        force = 50.0 / (0.5 * 3e-3 * 25 * math.cos(math.radians(20.0)))
        np.testing.assert_allclose(settled, force, rtol=1e-2)

    def test_flanks_with_backlash_separate_and_close(self):
        system = twisting_pair(
            stiffness=2e8,
            damping_ratio=0.02,
            backlash=1e-4,
            error=gb.TransmissionError(tooth=[(50e-6, 0.0)]),
        )
        response = system.simulate(0.02, 150.0, initial="static", record=["meshes"])
        kinds = {event.kind for event in response.events}
        assert {"separation", "contact"} <= kinds
        assert all((e.driver, e.driven) == ("g1", "g2") for e in response.events)
        assert response.mesh(("g1", "g2")).pairs_in_contact.min() == 0.0
        times = [event.time for event in response.events]
        assert times == sorted(times)
