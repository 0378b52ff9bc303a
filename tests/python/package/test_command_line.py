"""The command line: output, JSON, exit codes, errors of one line, and Ctrl-C."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import gearbow as gb
from gearbow.cli.answers import EXAMPLE, SCHEMAS
from gearbow.cli.main import _parser, main
from reference.cases import each_case
from reference.machines import bowed_pair

COMMAND = [sys.executable, "-m", "gearbow"]


@pytest.fixture
def scene(tmp_path: Path) -> str:
    path = tmp_path / "scene.toml"
    path.write_bytes(EXAMPLE.read_bytes())
    return str(path)


def called(capsys, *arguments: object) -> tuple[int, str, str]:
    """Run a command in this process, and return its code and what it prints."""
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    printed = capsys.readouterr()
    code = ended.value.code
    return (0 if code is None else code), printed.out, printed.err


def answer(capsys, *arguments: object) -> dict:
    """Run a command with --json; what it prints must follow the schema of the command."""
    code, out, err = called(capsys, *arguments, "--json")
    assert (code, err) == (0, "")
    found = json.loads(out)
    code, schema, err = called(capsys, "schema", arguments[0])
    assert (code, err) == (0, "")
    Draft202012Validator(json.loads(schema)).validate(found)
    return found


def test_every_command_with_json_has_a_schema(capsys):
    schemas = json.loads(SCHEMAS.read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(schemas)
    commands = _parser().parse_args(["skill"]).commands.choices
    with_json = [
        name
        for name, each in commands.items()
        if any("--json" in action.option_strings for action in each._actions)
    ]
    assert sorted(schemas["properties"]) == sorted(with_json)
    code, _, err = called(capsys, "schema", "nothing")
    assert (code, err.count("\n")) == (2, 1)
    assert err.startswith("schema: COMMAND: must be one of report, demo,")


def test_files_that_commands_write_are_named_in_json(
    scene: str, tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch
):
    """The commands whose JSON no other test reads; reports take seconds and have tests of their own."""
    monkeypatch.setattr(gb.RotorSystem, "report", lambda *_, **__: None)
    run, exported = tmp_path / "run.npz", tmp_path / "run.csv"
    answer(capsys, "run", scene, "--duration", 1e-4, "--speed", 100, "--out", run)
    assert answer(capsys, "export", run, exported) == {"file": str(exported)}
    assert answer(capsys, "import", scene)["file"] == scene
    figure = tmp_path / "train.png"
    assert answer(capsys, "plot", scene, "--out", figure) == {"file": str(figure)}
    page = tmp_path / "train.html"
    assert answer(capsys, "report", scene, "--out", page) == {"file": str(page)}
    calls = []
    monkeypatch.setattr(gb.RotorSystem, "to_fmu", lambda _, *a, **o: calls.append((a, o)))
    unit = tmp_path / "train.fmu"
    options = ("--torque-input", "pinion", "--speed-input", 50, 200, "--out", unit)
    assert answer(capsys, "fmu", scene, "--speed", 100, *options) == {"file": str(unit)}
    assert calls[0][0] == (unit, 100.0)
    assert calls[0][1]["torque_inputs"] == ["pinion"]
    assert calls[0][1]["speed_input"] == [50.0, 200.0]
    assert answer(capsys, "demo", "bowed_rotor", "--out", page, "--no-open") == {"file": str(page)}
    response = ("--source", "pinion:y", "--at", "pinion", "--to", "500Hz", "--points", 3)
    assert answer(capsys, "response", scene, *response)["unit"] == "m"


def test_losses_of_meshes_follow_their_schema(tmp_path: Path, capsys):
    path = tmp_path / "train.toml"
    system = bowed_pair(torque=100.0)
    system.replace(meshes=[replace(mesh, friction=0.05) for mesh in system.meshes]).save(path)
    assert answer(capsys, "efficiency", path, "--speed", 100)["efficiency"][0] < 1.0


def test_the_guide_for_assistants_is_printed(capsys):
    code, out, _ = called(capsys, "skill")
    assert code == 0
    assert out.startswith("# gearbow for coding assistants\n")


def test_new_writes_a_scene_with_comments(tmp_path: Path, capsys):
    path = tmp_path / "train.toml"
    code, out, _ = called(capsys, "new", path)
    assert code == 0
    assert f"wrote {path}" in out
    text = path.read_text()
    assert len(re.findall('^#|[^"] #', text, re.M)) > 8
    system = gb.RotorSystem.load(path)  # without a warning
    assert [shaft.name for shaft in system.shafts] == ["input", "output"]
    path.write_text("mine")
    code, _, err = called(capsys, "new", path)
    assert (code, path.read_text()) == (2, "mine")
    assert err == f"new: {path}: exists; give another name, or --force to replace it\n"
    assert called(capsys, "new", path, "--force")[0] == 0
    assert path.read_text() == text


def test_new_writes_a_machine_of_the_package(tmp_path: Path, capsys):
    path = tmp_path / "reducer.toml"
    code, out, _ = called(capsys, "new", path, "--example", "coaxial")
    assert code == 0
    assert out.endswith('--speed "1234 rpm"\n')
    machine = gb.examples()["coaxial_reducer"]
    assert path.read_bytes() == machine.path.read_bytes()
    assert machine.speed == gb.rpm(1234.0)
    code, _, err = called(capsys, "new", tmp_path / "x.toml", "--example", "rotor")
    assert code == 2
    assert "'rotor' is a part of bowed_rotor, compressor_rotor, dual_rotor, overhung_rotor" in err
    code, _, err = called(capsys, "new", tmp_path / "x.toml", "--example", "geared_par")
    assert 'did you mean "geared_pair"?' in err


def test_machines_of_the_package():
    machines = gb.examples()
    assert len(machines) >= 12
    for name, machine in machines.items():
        assert (machine.name, machine.path.suffix) == (name, ".toml")
        assert machine.title.strip()
        assert machine.speed > 0.0
    assert machines["geared_pair"].load().speed_ratios[0] == 1.0


def test_report(scene: str, tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch):
    written: list[tuple] = []
    monkeypatch.setattr(gb.RotorSystem, "report", lambda _, *a, **o: written.append((*a, o)))
    out = tmp_path / "train.html"
    found = answer(
        capsys, "report", scene, "--speed", "900 rpm", "1500 rpm", "--to", "3000 rpm", "--out", out
    )
    assert found == {"file": str(out)}
    ((path, options),) = written
    assert (path, options["title"], options["modes"]) == (out, "scene", 8)
    assert options["operating"] == (gb.rpm(900), gb.rpm(1500))
    np.testing.assert_allclose(options["speeds"], gb.rpm(np.linspace(150.0, 3000.0, 100)))
    for wrong in (["--speed", 1, 2, 3], ["--from", 1], ["--out", "x.pdf"]):
        code, _, err = called(capsys, "report", scene, *wrong)
        assert code == 2
        assert err.startswith(f"report: {wrong[0]}: ")


def test_a_report_is_at_the_speed_of_the_load_case(capsys, tmp_path: Path, monkeypatch):
    written: list[dict] = []
    monkeypatch.setattr(gb.RotorSystem, "report", lambda *_, **o: written.append(o))
    path = Path(__file__).parents[1] / "files" / "gearbox.rexs"
    other = ["--out", tmp_path / "train.html", "--bearing", "other=1e8 N/m"]
    for options, speed in (
        (["--load-case", 1], 1500.0),
        (["--load-case", 2], 3000.0),
        (["--load-case", 2, "--speed", "900 rpm"], (900.0, 900.0)),
    ):
        answer(capsys, "report", path, *options, *other)
        assert np.asarray(written[-1]["operating"]) == pytest.approx(gb.rpm(np.array(speed)))
        assert getattr(written[-1]["operating"], "speed_unit", "rpm") == "rpm"


def test_demo(tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch):
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr(
        gb.RotorSystem, "report", lambda _, path, **__: Path(path).write_text("report")
    )
    out = tmp_path / "demo.html"
    code, text, _ = called(capsys, "demo", "coaxial", "--out", out)
    assert (code, text) == (0, f"report: {out}\n")
    assert opened == [out.resolve().as_uri()]
    assert called(capsys, "demo", "--out", out, "--no-open")[0] == 0
    assert len(opened) == 1


def test_completion_knows_commands_options_and_machines(capsys):
    pytest.importorskip("shtab")
    code, out, _ = called(capsys, "completion", "bash")
    assert code == 0
    for word in ("bow-limits", "--harmonics", "coaxial_reducer", "_shtab_compgen_files"):
        assert word in out
    assert called(capsys, "completion", "zsh")[1].startswith("#compdef gearbow")


def test_check(scene: str, capsys):
    code, out, err = called(capsys, "check", scene)
    assert (code, err) == (0, "")
    assert out.startswith(f"{scene}: valid, no warnings\nRotorSystem(")
    found = answer(capsys, "check", scene)
    assert found["warnings"] == []
    assert found["parts"] == {"shafts": 2, "gears": 2, "meshes": 1, "bearings": 4, "torques": 2}
    assert found["speed_ratios"] == {"input": 1.0, "output": -0.5}
    assert found["degrees_of_freedom"] == len(gb.RotorSystem.load(scene).dofs)


def test_check_prints_warnings_on_stderr(scene: str, capsys):
    text = Path(scene).read_text().replace('face_width = "30 mm"', 'face_width = "30 m"')
    Path(scene).write_text(text)
    code, out, err = called(capsys, "check", scene)
    assert code == 0
    assert "valid, " in out
    lines = err.splitlines()
    assert lines
    assert all(line.startswith("warning: ") for line in lines)
    assert any("gears[0].face_width" in line for line in lines)
    code, out, err = called(capsys, "check", scene, "--json")
    assert json.loads(out)["warnings"] == [line.removeprefix("warning: ") for line in lines]


@pytest.mark.skipif(not hasattr(gb.RotorSystem, "plot"), reason="systems have no figure")
def test_plot(scene: str, tmp_path: Path, capsys):
    pytest.importorskip("matplotlib")
    code, out, err = called(capsys, "plot", scene, "--out", tmp_path / "train.png")
    assert (code, out, err) == (0, f"figure: {tmp_path / 'train.png'}\n", "")
    assert (tmp_path / "train.png").stat().st_size > 1000


def test_modes(scene: str, capsys):
    expected = gb.RotorSystem.load(scene).modes(gb.rpm(1500), count=4)
    found = answer(capsys, "modes", scene, "--speed", "1500 rpm", "--count", 4)
    assert found["speed"] == pytest.approx(gb.rpm(1500), rel=1e-15)
    frequencies = [mode["frequency_hz"] for mode in found["modes"]]
    np.testing.assert_allclose(frequencies, expected.frequencies_hz, rtol=1e-12)
    assert [mode["whirl"] for mode in found["modes"]] == list(expected.whirl)
    code, out, _ = called(capsys, "modes", scene, "--speed", gb.rpm(1500), "--count", 4)
    # a plain number is in rad/s, and the first line has both units
    table = expected.table(speed_unit="rad/s")
    assert (code, out) == (0, f"157.08 rad/s = 1,500 rpm\n{table}\n")
    code, out, _ = called(capsys, "modes", scene, "--speed", "1500 rpm", "--count", 4)
    assert (code, out) == (0, f"1500 rpm = 157.08 rad/s\n{expected.table()}\n")
    assert "modes at 1500 rpm" in out
    options = ["--speed", "1500 rpm", "--count", 3, "--vibrating"]
    found = answer(capsys, "modes", scene, *options)
    # The rigid-body mode is no vibration.
    np.testing.assert_allclose(
        [mode["frequency_hz"] for mode in found["modes"]], expected.frequencies_hz[1:], rtol=1e-9
    )


def test_stresses(tmp_path: Path, capsys):
    scene = tmp_path / "reducer.toml"
    scene.write_bytes(gb.examples()["coaxial_reducer"].path.read_bytes())
    strength = ["--endurance-limit", "280 MPa", "--tensile-strength", "700 MPa"]
    given = ["stresses", scene, "--speed", "-1234 rpm", *strength, "--line", "din743"]
    found = answer(capsys, *given, "--out", tmp_path / "stresses.png")
    expected = gb.RotorSystem.load(scene).stresses(
        gb.rpm(-1234), endurance_limit=280e6, tensile_strength=700e6, line="din743"
    )
    for name in ("amplitude", "mean", "utilisation", "bending"):
        np.testing.assert_allclose(found[name], getattr(expected, name))
    assert (tmp_path / "stresses.png").stat().st_size > 1000
    # the message of the method names the argument and the shaft
    wrong = ["stresses", scene, "--speed", "100", "--endurance-limit", "-1"]
    _, _, errors = called(capsys, *wrong)
    assert errors.startswith("stresses: --endurance-limit of ")
    code, _, error = called(capsys, *given[:4], *strength[:2])
    assert code == 2
    assert "--tensile-strength" in error


def test_life(tmp_path: Path, capsys):
    scene = tmp_path / "reducer.toml"
    scene.write_bytes(gb.examples()["coaxial_reducer"].path.read_bytes())
    given = ["life", scene, "--reliability", 0.95, "--factor", 2]
    found = answer(capsys, *given, "--speed", "1234 rpm", "--out", tmp_path / "life.png")
    system = gb.RotorSystem.load(scene)
    expected = system.bearing_life(gb.rpm(1234), reliability=0.95, factor=2.0)
    hours = [one["modified_hours"] for one in found["bearings"]]
    np.testing.assert_allclose(hours, [one.modified_hours for one in expected.bearings])
    assert found["notes"] == list(expected.notes)
    assert (tmp_path / "life.png").stat().st_size > 1000
    cases = ["1234 rpm, 150 N m, 60 %", "150, 80 N m, 0.4"]
    code, out, _ = called(capsys, *given, "--spectrum", *cases)
    assert code == 0
    spectrum = [(gb.rpm(1234), 150.0, 0.6), (150.0, 80.0, 0.4)]
    expected = system.bearing_life(spectrum=spectrum, reliability=0.95, factor=2.0)
    assert out == f"1234 to 1432.39 rpm = 129.22 to 150 rad/s\n{expected.table()}\n"
    code, _, err = called(capsys, *given, "--spectrum", cases[0])
    assert (code, err.split(";")[0]) == (
        2,
        "life: --spectrum: the shares of the time must sum to 1, got 0.6",
    )
    code, _, err = called(capsys, *given, "--spectrum", "1 rpm, 2")
    assert 'must be "speed, torque, share", such as' in err
    code, _, err = called(capsys, *given)
    assert (code, err) == (2, "life: --speed: give either a speed or a spectrum\n")


def test_bow_limits(scene: str, tmp_path: Path, capsys):
    given = ["bow-limits", scene, "--shaft", "input", "--speed", "1500 rpm", "--phase", "0 deg"]
    found = answer(capsys, *given, "--out", tmp_path / "limits.png")
    expected = gb.RotorSystem.load(scene).bow_limits("input", gb.rpm(1500), phase=0.0)
    assert [one["limit"] for one in found["limits"]] == [one.limit for one in expected.found]
    assert found["present"] == expected.present
    assert (tmp_path / "limits.png").stat().st_size > 1000


def test_campbell(scene: str, tmp_path: Path, capsys):
    pytest.importorskip("matplotlib")
    given = ["campbell", scene, "--to", "6000 rpm", "--points", 5, "--count", 3, "--harmonics", 0]
    found = answer(capsys, *given, "--out", tmp_path / "campbell.png")
    system = gb.RotorSystem.load(scene)
    expected = system.campbell(np.linspace(0, gb.rpm(6000), 5), count=3, harmonics=0)
    assert np.shape(found["frequencies_hz"]) == (5, 3)
    assert len(found["intersections"]) == len(expected.intersections)
    assert (tmp_path / "campbell.png").stat().st_size > 1000
    table = expected.table(speed_unit="rpm")
    assert called(capsys, *given)[1] == f"0 to 6000 rpm = 0 to 628.32 rad/s\n{table}\n"


def test_run_prints_and_saves_signals(scene: str, tmp_path: Path, capsys):
    given = ["run", scene, "--duration", "2 ms", "--speed", "1500 rpm", "--out", tmp_path / "r.npz"]
    items = ["gears", "meshes", "input@500 mm", "bearing:output@0"]
    found = answer(capsys, *given, "--record", *items)
    response = gb.Response.load(tmp_path / "r.npz")
    assert response.speed == pytest.approx(gb.rpm(1500), rel=1e-15)
    assert response.time[-1] == 2e-3
    assert list(found["points"]) == ["pinion", "wheel", "input at 0.5 m"]
    expected = np.ptp(response.displacement("pinion"), axis=0)
    np.testing.assert_allclose(found["points"]["pinion"]["peak_to_peak"], expected)
    force = response.mesh(("pinion", "wheel")).force
    assert found["meshes"]["pinion/wheel"]["force"]["max"] == force.max()
    assert found["complete"]
    force = np.hypot(*response.bearing_force(("output", 0.0)).T)
    assert found["bearings"]["output at 0 m"]["force"]["max"] == pytest.approx(force.max())
    _, printed, _ = called(capsys, *given, "--record", *items)
    assert printed.startswith(f"1500 rpm = 157.08 rad/s\n{response.table()}\n")
    (row,) = [line.split() for line in printed.splitlines() if line.startswith("pinion y")]
    assert row[-2:] == [f"{1e6 * expected[0]:.4g}", "µm"]
    code, out, err = called(capsys, *given, "--end-speed", "3000 rpm")
    assert (code, err) == (0, "")
    assert f"signals: {tmp_path / 'r.npz'}" in out
    assert gb.Response.load(tmp_path / "r.npz").speeds[-1] == pytest.approx(gb.rpm(3000))


def test_steady_prints_and_saves_the_periodic_motion(scene: str, tmp_path: Path, capsys):
    given = ["steady", scene, "--speed", "1500 rpm", "--out", tmp_path / "steady.npz"]
    found = answer(capsys, *given)
    steady = gb.SteadyState.load(tmp_path / "steady.npz")
    assert found["period"] == steady.period
    assert found["residual"] == steady.residual < 1e-3
    assert found["stable"] is steady.is_stable() is True
    force = steady.response.mesh(("pinion", "wheel")).force
    assert found["meshes"]["pinion/wheel"]["force"]["max"] == force.max()
    code, out, err = called(capsys, *given[:4])
    assert (code, err) == (0, "")
    assert f"steady state: period {steady.period:g} s" in out
    assert "\nstable; magnitude of the largest multiplier " in out


def test_identify_prints_and_draws(scene: str, tmp_path: Path, capsys):
    system = gb.RotorSystem.load(scene)
    shaft, gear = system.shafts[0].name, system.gears[0].name
    head = "speed [rpm], shaft, position, amplitude [um], phase [deg]"
    rows = [
        f"{100 * k}, {shaft}, {system.gears[0].position}, {50 + k}, {k % 3}" for k in range(1, 9)
    ]
    path, figure = tmp_path / "run_down.csv", tmp_path / "fit.png"
    path.write_text("\n".join([head, *rows]))
    given = ["identify", scene, path, "--unknown", f"bow:{shaft}", "--no-runout", "--plot", figure]
    found = answer(capsys, *given, "--noise", "1 um")
    measured = gb.Measurement.read_csv(path)
    expected = gb.identify(system, measured, [gb.unknown.bow(shaft)], runout=False, noise=1e-6)
    assert found["unknowns"][0]["re"] == expected.values[0].real
    assert figure.stat().st_size > 0
    code, out, _ = called(capsys, *given, "--unknown", f"unbalance:{gear}")
    assert code == 0
    assert f"unbalance of {gear}" in out
    code, _, err = called(capsys, *given, "--unknown", f"bows:{shaft}")
    assert code == 2
    assert err.startswith("identify: --unknown: must be bow:SHAFT, ")
    assert 'did you mean "bow"?' in err


def test_run_shows_progress_on_stderr_only(scene: str, capsys):
    code, out, err = called(
        capsys, "run", scene, "--duration", 1e-3, "--speed", 100, "--json", "--progress"
    )
    assert code == 0
    json.loads(out)
    assert "100%" in err


def test_tradeoff(scene: str, capsys):
    arguments = ["--duration", 1e-3, "--speed", 100, "--signals", "pinion/wheel", "--budget", 3]
    found = answer(capsys, "tradeoff", scene, *arguments)
    assert found["signals"] == ["the force of pinion/wheel"]
    assert any(trial["front"] for trial in found["trials"])


@each_case(
    ("arguments", "message"),
    [
        (["check", "nothing.toml"], "check: nothing.toml: No such file or directory"),
        (
            ["run", "SCENE", "--duration", "-1", "--speed", "1"],
            "run: --duration: must not be negative, got -1",
        ),
        (
            ["run", "SCENE", "--duration", "1", "--speed", "1", "--record", "pinoin"],
            'did you mean "pinion"?',
        ),
        (
            ["run", "SCENE", "--duration", "1 m", "--speed", "1"],
            "must have a unit that converts to s",
        ),
        (
            ["run", "SCENE", "--duration", "1", "--speed", "50 Hz"],
            "a speed is in rad/s, rpm or rev/s",
        ),
        (
            ["run", "SCENE", "--duration", "1", "--speed", "1", "--out", "run.csv"],
            "must end with .npz or .nc, which is the format, got 'run.csv'",
        ),
        (
            ["run", "SCENE", "--duration", "1e9", "--speed", "1", "--checkpoint", "none/run.npz"],
            "argument --checkpoint: none/run.npz: the file cannot be written and is unchanged: ",
        ),
        (
            ["campbell", "SCENE", "--to", "1e3", "--out", "a.xyz"],
            ", .svgz, .tif, .tiff or .webp, which is the format, got 'a.xyz'",
        ),
        (["plot", "SCENE", "--out", ""], "--out: must be the name of a file, got ''"),
        (["steady", "SCENE", "--speed", "1", "--out", ""], "must be the name of a file, got ''"),
        (["new", "rotor.xyz"], "new: path: must end with .toml"),
        (["campbell", "SCENE", "--to", "0"], "campbell: --to: need --points of at least 2"),
        (["modes", "SCENE", "--count", "0"], "modes: --count: must be at least 1, got 0"),
        (["efficiency", "SCENE", "--speed", "0"], "efficiency: --speed: must not be zero"),
        (
            ["run", "SCENE", "--duration", "1", "--speed", "1", "--record", "input@x"],
            "run: --record: must be a number [m]",
        ),
        (
            ["response", "SCENE", "--source", "pin:y", "--at", "pinion", "--to", "5Hz"],
            'response: --source: no gear, disk, support or housing is called "pin"',
        ),
        (["orders", "SCENE"], "orders: run: must end with .npz, which is the format"),
        (["swim"], "invalid choice: 'swim'"),
    ],
)
def test_invalid_input_has_the_code_2_and_one_line(scene: str, capsys, arguments, message: str):
    arguments = [scene if argument == "SCENE" else argument for argument in arguments]
    code, out, err = called(capsys, *arguments)
    assert (code, out) == (2, "")
    assert message in err
    if "usage:" not in err:
        assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("teeth = 25", "teeth = twenty", "toml: TOML parse error at line "),
        ("teeth = 25", "teth = 25", 'did you mean "teeth"?'),
        ('"3 mm"', '"3 kg"', "gears[0].module: must have a unit that converts to m, got '3 kg'"),
        ('at = "pinion"', 'at = "pinoin"', 'torques[0].at: no gear or disk is called "pinoin"'),
    ],
)
def test_an_invalid_scene_has_the_code_2_and_one_line(scene, capsys, old, new, message: str):
    text = Path(scene).read_text()
    assert old in text
    Path(scene).write_text(text.replace(old, new))
    code, out, err = called(capsys, "check", scene)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert message in err


def test_a_failed_computation_has_the_code_1(scene: str, capsys, monkeypatch):
    def fails(*_, **__):
        raise gb.StabilityError("step: 1 s is above the limit")

    monkeypatch.setattr(gb.RotorSystem, "simulate", fails)
    code, out, err = called(capsys, "run", scene, "--duration", "1", "--speed", "1")
    assert (code, out, err) == (1, "", "run: step: 1 s is above the limit\n")


def test_every_command_has_examples_in_its_help(capsys):
    """Every example is a valid command line."""
    code, out, _ = called(capsys, "--help")
    assert code == 0
    commands = re.findall(r"^    (\w+) +", out, re.M)
    assert commands == [
        "new",
        "report",
        "demo",
        "import",
        "check",
        "plot",
        "modes",
        "campbell",
        "stresses",
        "life",
        "response",
        "run",
        "steady",
        "tradeoff",
        "orders",
        "export",
        "fmu",
        "identify",
        "skill",
        "schema",
    ]
    for command in commands:
        _, out, _ = called(capsys, command, "--help")
        examples = out.split("examples:\n")[1].replace("\\\n", "").splitlines()
        assert examples
        for example in examples:
            given = _parser().parse_args(shlex.split(example.partition(" > ")[0])[1:])
            assert given.command == command, example


def test_a_stopped_run_keeps_its_signals(scene: str, tmp_path: Path):
    out = tmp_path / "part.npz"
    arguments = ["run", scene, "--duration", "1000", "--speed", "100", "--out", str(out)]
    process = subprocess.Popen(
        [*COMMAND, *arguments, "--progress"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    seen = b""
    while not re.search(rb"\| 0?\.?0*[1-9]\S*/1e\+03 s", seen):
        piece = process.stderr.read1(1000)
        assert piece, seen
        seen += piece
    process.send_signal(signal.SIGINT)
    printed, errors = process.communicate()
    assert process.returncode == 130
    assert errors.decode().splitlines()[-1] == "run: stopped; what was done is kept"
    assert b"Traceback" not in errors
    assert f"signals: {out}" in printed.decode()
    assert gb.Response.load(out).time.size > 10


def ended(*arguments: str, **given: object) -> subprocess.CompletedProcess[bytes]:
    """Run the program as a process of its own, with further variables of the environment."""
    environment = {**os.environ, **given.pop("env", {})}
    return subprocess.run(
        [*COMMAND, *arguments], env=environment, check=False, stderr=subprocess.PIPE, **given
    )


RUN = ("--duration", "1 ms", "--speed", "100")


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_an_output_that_is_not_utf_8_has_escapes(scene: str, encoding: str):
    text = Path(scene).read_text().replace('"wheel"', '"Räder 齿轮"')
    Path(scene).write_text(text, encoding="utf-8")
    environment = {"PYTHONIOENCODING": encoding}
    for form in ((), ("--json",)):
        found = ended("run", scene, *RUN, *form, env=environment, stdout=subprocess.PIPE)
        assert (found.returncode, found.stderr) == (0, b"")
        printed = found.stdout.decode(encoding)
        if form:
            assert "Räder 齿轮" in json.loads(printed)["points"]
        else:
            assert r" \u9f7f\u8f6e y " in printed


@pytest.mark.skipif(os.name != "posix", reason="devices")
def test_a_full_or_closed_stdout_is_an_error_of_one_line(scene: str, tmp_path: Path):
    with Path("/dev/full").open("wb") as full:
        found = ended("run", scene, *RUN, "--out", str(tmp_path / "r.npz"), stdout=full)
    assert (found.returncode, found.stderr.count(b"\n")) == (1, 1)
    assert b"run: stdout cannot be written: " in found.stderr
    assert gb.Response.load(tmp_path / "r.npz").time.size
    line = shlex.join([*COMMAND, "run", scene, "--duration", "1e9", "--speed", "1"])
    found = subprocess.run(["sh", "-c", f"{line} >&-"], check=False, stderr=subprocess.PIPE)
    expected = b"gearbow: stdout is closed; redirect it, for example to /dev/null\n"
    assert (found.returncode, found.stderr) == (2, expected)


@pytest.mark.skipif(os.name != "posix", reason="SIGPIPE")
@pytest.mark.parametrize(
    ("arguments", "streams"),
    [
        (["modes", "SCENE"], ("stdout",)),
        (["modes", "--help"], ("stdout",)),
        (["modes", "nothing.toml"], ("stderr",)),
        (["check", "SCENE"], ("stdout", "stderr")),
    ],
)
def test_a_reader_that_ends_early_is_no_error(scene: str, arguments, streams: tuple[str, ...]):
    text = Path(scene).read_text().replace('face_width = "30 mm"', 'face_width = "30 m"')
    Path(scene).write_text(text)  # with warnings
    ours, theirs = os.pipe()
    os.close(ours)
    given = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **dict.fromkeys(streams, theirs)}
    arguments = [scene if each == "SCENE" else each for each in arguments]
    found = subprocess.run([*COMMAND, *arguments], check=False, **given)
    os.close(theirs)
    assert found.returncode == 128 + signal.SIGPIPE
    printed = (found.stdout or b"") + (found.stderr or b"")
    assert all(line.startswith(b"warning: ") for line in printed.splitlines())


@pytest.mark.parametrize("missing", [["plotly"], ["jinja2"], ["matplotlib"]])
def test_the_demo_names_the_extra_that_it_needs(missing, tmp_path, capsys, monkeypatch):
    for name in list(sys.modules):
        if name.partition(".")[0] in missing:
            monkeypatch.delitem(sys.modules, name)
    for name in missing:
        monkeypatch.setitem(sys.modules, name, None)
    computed: list[object] = []
    monkeypatch.setattr(gb.RotorSystem, "modes", lambda *_, **__: computed.append(None))
    code, out, err = called(capsys, "demo", "--no-open", "--out", tmp_path / "demo.html")
    assert (code, out, computed) == (1, "", [])
    assert err.endswith('is not installed; install it with: pip install "gearbow[report]"\n')


def test_the_installation_of_the_readme_has_the_extras_of_the_demo():
    readme = (Path(__file__).parents[3] / "README.md").read_text(encoding="utf-8")
    (extras,) = re.findall(r'pip install "gearbow\[([\w,]+)\]"', readme)
    assert {"plot", "report"} <= set(extras.split(","))


def test_an_unknown_backend_is_refused_before_the_computation(scene: str, tmp_path: Path):
    pytest.importorskip("matplotlib")
    environment = {"MPLBACKEND": "nonsense"}
    out = ("--out", str(tmp_path / "c.png"))
    found = ended("campbell", scene, "--to", "1e3", *out, env=environment, stdout=subprocess.PIPE)
    assert (found.returncode, found.stdout) == (2, b"")
    assert b"MPLBACKEND: 'nonsense' is no backend of matplotlib; remove this" in found.stderr
    assert b"Traceback" not in found.stderr


def test_the_table_is_printed_before_the_figure_is_drawn(scene, tmp_path, capsys, monkeypatch):
    pytest.importorskip("matplotlib")

    def fails(_: object) -> None:
        raise gb.GearbowError("no figure")

    monkeypatch.setattr("gearbow.results.campbell.Campbell.plot", fails)
    given = ["campbell", scene, "--to", "6000 rpm", "--points", 5, "--harmonics", 0]
    code, out, err = called(capsys, *given, "--out", tmp_path / "c.svg")
    assert (code, err) == (1, "campbell: no figure\n")
    assert "excited by" in out


@pytest.mark.skipif(os.name != "posix", reason="sends a signal")
def test_sigterm_keeps_the_checkpoint_and_the_signals(scene: str, tmp_path: Path):
    out, checkpoint = tmp_path / "part.npz", tmp_path / "run.npz"
    arguments = ["run", scene, "--duration", "1000", "--speed", "100", "--out", str(out)]
    process = subprocess.Popen(
        [*COMMAND, *arguments, "--checkpoint", str(checkpoint), "--progress"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    seen = b""
    while not re.search(rb"\| 0?\.?0*[1-9]\S*/1e\+03 s", seen):
        piece = process.stderr.read1(1000)
        assert piece, seen
        seen += piece
    process.send_signal(signal.SIGTERM)
    printed, errors = process.communicate()
    assert process.returncode == 143
    assert errors.decode().splitlines()[-1] == "run: stopped; what was done is kept"
    assert f"signals: {out}" in printed.decode()
    assert gb.Response.load(out).time.size == gb.Response.load(checkpoint).time.size > 10


def test_the_program_and_the_module_are_the_same(scene: str):
    given = ["check", scene]
    ended = subprocess.run([*COMMAND, *given], capture_output=True, text=True, check=True)
    assert "valid, no warnings" in ended.stdout
    project = (Path(__file__).parents[3] / "pyproject.toml").read_text()
    assert '[project.scripts]\ngearbow = "gearbow.cli.main:main"\n' in project


def test_the_program_alone_prints_its_help(capsys):
    code, out, err = called(capsys)
    assert (code, err) == (0, "")
    assert out == called(capsys, "--help")[1]


@pytest.fixture
def saved(scene: str, tmp_path: Path, capsys) -> Path:
    """Return the file of a run at 1500 rpm."""
    path = tmp_path / "run.npz"
    given = ("--duration", "0.3", "--speed", "1500 rpm", "--out", path)
    assert called(capsys, "run", scene, *given)[0] == 0
    return path


def test_figures_orders_and_tables_follow_from_the_file_of_a_run(saved: Path, capsys, monkeypatch):
    pytest.importorskip("matplotlib")
    response, folder = gb.Response.load(saved), saved.parent
    monkeypatch.chdir(folder)
    assert called(capsys, "plot", saved, "--kind", "spectrum", "--at", "pinion")[::2] == (0, "")
    assert (folder / "spectrum.png").stat().st_size > 1000
    assert called(capsys, "plot", saved, "--out", folder / "x.png")[0] == 0
    assert (folder / "x.png").stat().st_size > 1000

    code, out, _ = called(capsys, "orders", saved, "--at", "pinion/wheel", "--count", 5)
    expected = response.orders(("pinion", "wheel"))
    assert (code, out) == (0, expected.table(5) + "\n")
    assert "at 1500 rpm" in out
    found = answer(capsys, "orders", saved)
    assert found["signal"] == "pinion y"
    assert len(found["orders"]) == len(response.orders("pinion").orders)

    pd, xr = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    assert called(capsys, "export", saved, folder / "run.csv")[0] == 0
    table = pd.read_csv(folder / "run.csv", index_col=0)
    assert list(table.columns) == list(response.to_dataframe().columns)
    assert called(capsys, "export", saved, folder / "run.nc")[0] == 0
    with xr.open_dataset(folder / "run.nc", engine="h5netcdf", decode_times=False) as data:
        np.testing.assert_array_equal(data["time"], response.time)
    code, out, err = called(capsys, "orders", folder / "run.nc")
    assert (code, out) == (2, "")
    assert "run.nc is netCDF, which gearbow writes for other programs and does not read" in err
    code, out, err = called(capsys, "export", saved, folder / "run.txt")
    assert (code, out) == (2, "")
    assert "must end with .npz, .csv, .xlsx or .nc" in err


def test_a_run_draws_its_figure(scene: str, tmp_path: Path, capsys):
    pytest.importorskip("matplotlib")
    given = ("--duration", "2 ms", "--speed", "1500 rpm", "--figure", tmp_path / "mesh.png")
    code, out, _ = called(capsys, "run", scene, *given, "--kind", "mesh")
    assert code == 0
    assert out.endswith(f"figure: {tmp_path / 'mesh.png'}\n")
    assert (tmp_path / "mesh.png").stat().st_size > 1000


def test_the_figure_of_a_scene_has_no_kind(scene: str, capsys):
    code, out, err = called(capsys, "plot", scene, "--kind", "mesh")
    assert (code, out) == (2, "")
    assert err.startswith("plot: --kind: is for the file of a run")


def test_a_response_of_a_drive_line_is_its_twist(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    machine = gb.examples()["torsional_drive_line"]
    figure = tmp_path / "response.png"
    options = ["--source", "pinion:twist", "--at", "pinion", "--from", "5Hz", "--to", "20Hz"]
    with pytest.raises(SystemExit) as end:
        main(["response", str(machine.path), *options, "--points=3", f"--plot={figure}", "--json"])
    out, error = capsys.readouterr()
    assert end.value.code == 0, error
    found = json.loads(out)
    assert found["unit"] == "rad"
    expected = gb.RotorSystem.load(machine.path).frequency_response(
        found["frequencies"], source=gb.Torque("pinion", 1.0)
    )
    np.testing.assert_allclose(found["twist_real"], expected.twist("pinion")[:, 0].real, rtol=1e-9)
    assert figure.stat().st_size > 1000
