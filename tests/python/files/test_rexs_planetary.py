"""Planetary stages in REXS files: what becomes of carriers, pins, rings at rest and planets."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb

SUN, PLANET, RING, COUNT, MODULE = 18, 27, 72, 3, 3.0
DISTANCE = 0.5 * MODULE * (SUN + PLANET)


class File:
    """Writes a file of REXS component by component."""

    def __init__(self) -> None:
        self.components: list[str] = []
        self.relations: list[str] = []

    def component(self, number: int, kind: str, name: str, **attributes: object) -> int:
        lines = "".join(
            f'<attribute id="{key}" unit="{"mm" if isinstance(value, float) else "none"}">'
            f"{str(value).lower()}</attribute>"
            for key, value in attributes.items()
        )
        self.components.append(
            f'<component id="{number}" type="{kind}" name="{name}">{lines}</component>'
        )
        return number

    def relate(self, kind: str, **roles: int) -> None:
        refs = "".join(f'<ref id="{number}" role="{role}"/>' for role, number in roles.items())
        number = len(self.relations) + 1
        self.relations.append(f'<relation id="{number}" type="{kind}">{refs}</relation>')

    def shaft(self, number: int, name: str, diameter: float) -> None:
        self.component(number, "shaft", name)
        section = self.component(
            number + 500,
            "shaft_section",
            f"section {number}",
            u_coordinate_on_shaft=0.0,
            length=50.0,
            outer_diameter_begin=diameter,
            outer_diameter_end=diameter,
        )
        self.relate("assembly", assembly=number, part=section)

    def gear(self, number: int, kind: str, name: str, shaft: int, teeth: int) -> None:
        sizes = {"normal_module": MODULE, "face_width": 30.0, "u_coordinate_on_shaft": 25.0}
        self.component(number, kind, name, number_of_teeth=teeth, **sizes)
        self.relate("assembly", assembly=shaft, part=number)

    def write(self, path: Path) -> Path:
        path.write_text(
            '<model version="1.4" applicationId="test"><relations>'
            + "".join(self.relations)
            + "</relations><components>"
            + "".join(self.components)
            + "</components></model>"
        )
        return path


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Give a file with a carrier of two shafts, side plates, pins, and a ring in the casing."""
    file = File()
    file.component(1, "gear_casing", "casing")
    file.component(2, "planetary_stage", "stage")
    file.component(3, "planet_carrier", "carrier")
    for number, name in ((4, "input"), (5, "output"), (6, "far side")):
        file.shaft(number, name, 40.0)
    file.shaft(7, "ring shaft", 250.0)
    file.component(8, "side_plate", "plate")
    file.component(9, "side_plate", "far plate")
    for kind, shaft in (("planet_carrier_shaft", 5), ("planet_carrier_shaft", 6)):
        file.relate(kind, planetary_stage=2, shaft=shaft)
    for shaft, plate, joint in ((5, 8, 10), (6, 9, 11)):
        file.component(joint, "coupling", f"joint {joint}", u_coordinate_on_shaft_inner_side=45.0)
        file.relate("side", assembly=joint, inner_part=shaft, outer_part=plate)
        file.relate("assembly", assembly=3, part=plate)
    held = {"u_coordinate_on_shaft_inner_side": 25.0}
    file.component(12, "switchable_coupling", "support of the ring", is_engaged=True, **held)
    file.relate("side", assembly=12, inner_part=7, outer_part=1)
    file.component(13, "concept_bearing", "bearing", u_coordinate_on_shaft_inner_side=10.0)
    file.relate("side", assembly=13, inner_part=4, outer_part=1)
    file.gear(20, "cylindrical_gear", "sun", 4, SUN)
    file.gear(21, "ring_gear", "ring", 7, RING)
    for i in range(COUNT):
        file.shaft(30 + i, f"planet shaft {i}", 50.0)
        file.shaft(40 + i, f"pin {i}", 20.0)
        file.relate("planet_shaft", planetary_stage=2, shaft=30 + i)
        file.relate("planet_pin", planetary_stage=2, shaft=40 + i)
        file.component(50 + i, "concept_bearing", f"planet bearing {i}")
        file.relate("side", assembly=50 + i, inner_part=40 + i, outer_part=30 + i)
        file.gear(60 + i, "cylindrical_gear", f"planet {i}", 30 + i, PLANET)
        for stage, pair in ((70 + i, (20, 60 + i)), (80 + i, (60 + i, 21))):
            turn = 120 * i + (180 if pair[1] == 21 else 0)
            file.component(stage, "cylindrical_stage", f"mesh {stage}", center_distance=DISTANCE)
            file.components[-1] = file.components[-1].replace(
                "</component>",
                f'<attribute id="rotating_angle_around_neg_u_axis" unit="deg">{turn}</attribute>'
                "</component>",
            )
            file.relate("stage", stage=stage, gear_1=pair[0], gear_2=pair[1])
    file.component(90, "external_load", "drive", transmits_torque=True, u_coordinate_on_shaft=0.0)
    file.components[-1] = file.components[-1].replace(
        "</component>",
        '<attribute id="torque_around_u_axis" unit="Nm">100</attribute></component>',
    )
    file.relate("assembly", assembly=4, part=90)
    file.component(91, "external_load", "load", transmits_torque=True, u_coordinate_on_shaft=0.0)
    file.relate("assembly", assembly=5, part=91)
    return file.write(tmp_path / "planetary.rexs")


@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
def test_a_planetary_stage_is_read_in_torsion(path: Path):
    contents = gb.rexs_contents(path)
    assert not contents.missing
    assert any("computed in torsion" in note for note in contents.notes)
    train = gb.RotorSystem.read_rexs(path)
    ratios = dict(zip((s.name for s in train.shafts), train.speed_ratios, strict=True))
    assert "pin 0" not in ratios
    assert ratios["output"] == pytest.approx(SUN / (SUN + RING), rel=1e-12)
    assert ratios["far side"] == ratios["output"]
    assert ratios["ring shaft"] == 0.0
    assert {mesh.carrier for mesh in train.meshes} == {("output", 0.045)}
    # planets of the file on pins at the distance of the axes
    masses = train.mass_properties()
    planet = masses.mass[masses.names.index("planet shaft 0")]
    (orbit,) = (disk for disk in train.disks if disk.shaft == "output")
    assert orbit.polar_inertia == pytest.approx(COUNT * planet * (1e-3 * DISTANCE) ** 2, rel=1e-12)
    found = train.static(speed=100.0)
    radius = 0.5e-3 * MODULE * SUN * np.cos(np.radians(20.0))
    for mesh in train.meshes:
        force = found.mesh((mesh.driver, mesh.driven)).force
        assert force == pytest.approx(100.0 / COUNT / radius, rel=1e-9)


@pytest.mark.parametrize("kind", ["planet_shaft", "planet_carrier_shaft"])
def test_a_stage_without_its_shafts_is_an_error(path: Path, kind: str):
    text = path.read_text()
    path.write_text(text.replace(f'type="{kind}"', 'type="unknown"'))
    with pytest.raises(
        gb.SceneError, match=r'planetary_stage "stage": no relations of its planets'
    ):
        gb.rexs_contents(path)


def test_a_stage_without_the_distance_of_its_planets_is_an_error(path: Path):
    text = path.read_text()
    path.write_text(text.replace("center_distance", "another_distance"))
    with pytest.raises(gb.SceneError, match=r"needs a center_distance"):
        gb.rexs_contents(path)


@pytest.mark.implausible
@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
def test_the_published_planetary_stage_has_the_stated_torque():
    folder = os.environ.get("GEARBOW_TEST_DATA")
    if folder is None:
        pytest.skip("GEARBOW_TEST_DATA does not name the folder of the given files")
    file = Path(folder, "rexs", "FVA_Planetary_stage_-_Minus_gearing_1.1.rexs")
    train = gb.RotorSystem.read_rexs(file)
    assert sorted(set(np.round(train.speed_ratios, 12)))[-2:] == [round(17 / 78, 12), 1.0]
    # the file states 1500 rpm and 1591.549 N m on the sun of 17 teeth of 4 mm
    found = train.static(speed=gb.rpm(1500))
    radius = 0.034 * np.cos(np.radians(20.0))
    forces = [found.mesh((mesh.driver, mesh.driven)).force for mesh in train.meshes]
    assert forces == pytest.approx([1591.5494309189535 / 3 / radius] * 6, rel=1e-9)
