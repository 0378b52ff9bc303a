"""The table of commands: name, function that answers, method, examples and arguments."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gearbow.cli import answers
from gearbow.cli.answers import Answer
from gearbow.cli.arguments import (
    ACCURACY,
    FIGURE,
    JSON,
    KIND,
    RECORD,
    RUN,
    SIGNALS,
    SIGNALS_OUT,
    Argument,
    drawn,
    flag,
    from_to,
    option,
    output,
    parameter,
    progress,
    quantity,
    scene,
    spectrum_case,
)
from gearbow.exchange.tables import DETECTIONS
from gearbow.identification.identify import identify
from gearbow.machines.examples import scene_files
from gearbow.results.response import Response
from gearbow.system.rotor_system import RotorSystem


class Command:
    """A command, whose help is that of the method it calls, or of the function that answers it."""

    # The name is that of the function unless it is given. An argument that is a text is a
    # parameter of the method.
    def __init__(
        self,
        answer: Callable[[argparse.Namespace], Answer],
        examples: str,
        *arguments: Argument | str,
        method: Callable[..., Any] | None = None,
        name: str = "",
    ) -> None:
        self.answer, self.examples, self.method = answer, examples, method
        self.arguments = [parameter(one) if isinstance(one, str) else one for one in arguments]
        self.name = name or answer.__name__.rstrip("_").replace("_", "-")


COMMANDS = (
    Command(
        answers.new,
        "  gearbow new\n  gearbow new pump.toml\n  gearbow new --example coaxial reducer.toml",
        option("path", "default: %(default)s", nargs="?", default="scene.toml"),
        option(
            "--example",
            "a complete machine, by its name or a part of it: " + ", ".join(scene_files()),
            metavar="NAME",
        ),
        flag("--force", "replace an existing file"),
    ),
    Command(
        answers.report,
        '  gearbow report gearbox.toml --speed "1480 rpm"\n'
        '  gearbow report gearbox.toml --speed "1200 rpm" "1480 rpm" --to "3000 rpm" --out g.html',
        scene(),
        parameter(
            "operating",
            "--speed",
            "default: that of the load case of a REXS file",
            nargs="+",
        ),
        from_to(
            *("speeds", 100, "default: 5 %% of --to", "default: 150 %% of the operating speed"),
            required=False,
        ),
        *("modes", "endurance_limit", "tensile_strength"),
        *("title", "company", "author", "document_number", "date", "language"),
        option("--out", "file .html; default: the name of the scene file", dest="path"),
        progress,
        method=RotorSystem.report,
    ),
    Command(
        answers.demo,
        "  gearbow demo\n  gearbow demo gearbox --no-open",
        # A machine with gears and bows that is small.
        option(
            "example",
            "name of a machine; default: %(default)s",
            nargs="?",
            default="double_stage_train",
        ),
        option("--out", "file .html; default: the name of the example"),
        flag("--no-open", "do not open the browser"),
        *(JSON, progress),
    ),
    Command(
        answers.import_,
        "  gearbow import gearbox.rexs --list\n"
        '  gearbow import gearbox.rexs --load-case 2 --bearing "other=1e8" --out train.toml\n'
        "  gearbow import rotor.json > rotor.toml\n"
        '  gearbow import geared.json --mesh "Gear 0/Gear 1=2e8" \\\n'
        '      --centre-line-angle "Gear 0/Gear 1=30 deg" --out geared.toml',
        scene(),
        flag("--list", "print load cases, missing values and notes instead"),
        option(
            "--out",
            "write the scene to this file .toml, in UTF-8 on all systems, or to a file "
            ".rexs, with a warning about what REXS cannot hold",
        ),
    ),
    Command(
        answers.check,
        "  gearbow check scene.toml\n  gearbow check scene.toml --json",
        scene(),
    ),
    Command(
        answers.plot,
        "  gearbow plot scene.toml\n  gearbow plot scene.toml --out train.svg\n"
        "  gearbow plot run.npz --kind spectrum --out spectrum.png",
        scene("or the file of a run"),
        KIND,
        option("--at", "places or meshes of a run; default: all", nargs="+", metavar="ITEM"),
        drawn("--out", "file of the figure; default: train.png, or the kind of a run"),
    ),
    Command(
        answers.modes,
        '  gearbow modes scene.toml\n  gearbow modes scene.toml --speed "1500 rpm" --count 20',
        *(scene(), parameter("speed", text="default: 0", default=None)),
        *(parameter("count", default=10), "vibrating"),
        method=RotorSystem.modes,
    ),
    Command(
        answers.campbell,
        '  gearbow campbell scene.toml --to "6000 rpm"\n'
        '  gearbow campbell scene.toml --to "6000 rpm" --harmonics 0 --out campbell.png',
        scene(),
        from_to("speeds", 50, "default: 0", 'for example "6000 rpm"', default=0.0),
        *("count", "harmonics"),
        drawn("--out", "write the diagram to this file, for example .png"),
        method=RotorSystem.campbell,
    ),
    Command(
        answers.result,
        '  gearbow efficiency scene.toml --speed "1500 rpm"\n'
        '  gearbow efficiency scene.toml --speed "500 rpm" "3000 rpm" --out losses.png',
        scene(),
        parameter("speeds", "--speed"),
        FIGURE,
        method=RotorSystem.efficiency,
        name="efficiency",
    ),
    Command(
        answers.result,
        '  gearbow stresses scene.toml --speed "1500 rpm"\n'
        '  gearbow stresses scene.toml --speed "1500 rpm" --endurance-limit "280 MPa"'
        ' --tensile-strength "700 MPa" --line din743',
        *(scene(), "speed", "endurance_limit", "tensile_strength", "line", FIGURE),
        method=RotorSystem.stresses,
        name="stresses",
    ),
    Command(
        answers.result,
        '  gearbow life scene.toml --speed "1500 rpm"\n'
        '  gearbow life scene.toml --spectrum "1500 rpm, 250 N m, 0.6" "3000 rpm, 100 N m, 0.4"',
        *(scene(), parameter("speed", text="or give --spectrum")),
        parameter(
            "spectrum",
            text='CASE: "speed, torque, share"; the torque is that of the drive',
            type=spectrum_case,
            metavar="CASE",
        ),
        *("factor", "reliability", FIGURE),
        method=RotorSystem.bearing_life,
        name="life",
    ),
    Command(
        answers.bow_limits,
        '  gearbow bow-limits scene.toml --shaft input --speed "1500 rpm"\n'
        '  gearbow bow-limits scene.toml --shaft input --speed "1500 rpm" --out bow.png',
        scene(),
        parameter("shaft", text="or several together"),
        *("speed", "phase", FIGURE),
        method=RotorSystem.bow_limits,
    ),
    Command(
        answers.response,
        "  gearbow response train.toml --source input:0.2:y --at pinion --from 1Hz --to 5kHz"
        " --plot frf.png\n"
        '  gearbow response train.toml --source pinion/wheel --at input@0.1 --to 5kHz --speed "50'
        ' rad/s"',
        scene(),
        option(
            "--source",
            "unit force at a place along y, z or x (input:0.2:y, pinion:z), unit torque "
            "(pinion:twist), or a mesh with a transmission error of 1 µm (pinion/wheel)",
            required=True,
        ),
        option("--at", "pinion, input@0.2, or a mesh pinion/wheel for its force", required=True),
        from_to("frequencies", 1000, "default: 1Hz", "for example 5kHz", default="1Hz"),
        parameter("speed", nargs=None, help="speed of the reference shaft [rad/s]; default: 0"),
        drawn("--plot", "write a Bode plot to this file"),
        method=RotorSystem.frequency_response,
    ),
    Command(
        answers.run,
        '  gearbow run scene.toml --duration 0.5 --speed "1500 rpm" --out run.npz\n'
        '  gearbow run scene.toml --duration "10 s" --speed 0 --end-speed "3000 rpm" \\\n'
        "      --record gears meshes shaft@0.25 --checkpoint run.npz",
        *(scene(), "duration", parameter("speed", nargs=None)),
        option("--end-speed", "change the speed linearly to this one", quantity("speed")),
        *(ACCURACY, RECORD, SIGNALS_OUT),
        parameter(
            "checkpoint",
            text="the same command continues after an interruption",
            type=output,
        ),
        drawn("--figure", "draw the signals to this file, for example .png"),
        *(KIND, progress),
        method=RotorSystem.simulate,
    ),
    Command(
        answers.steady,
        '  gearbow steady scene.toml --speed "1500 rpm" --record gears meshes --out steady.npz',
        *(scene(), "speed", ACCURACY, RECORD, SIGNALS_OUT, progress),
        method=RotorSystem.steady_state,
    ),
    Command(
        answers.tradeoff,
        '  gearbow tradeoff scene.toml --duration 0.1 --speed "1500 rpm" --signals pinion/wheel',
        *(scene(), "duration", "speed", SIGNALS, "budget", progress),
        method=RotorSystem.tradeoff,
    ),
    Command(
        answers.orders,
        "  gearbow orders run.npz\n"
        "  gearbow orders run.npz --at pinion --quantity z --skip-time 0.1",
        *(RUN, JSON),
        option("--at", "place or mesh; default: the first recorded", metavar="ITEM"),
        option("--quantity", 'for example "z" or "force"; default: y or the force'),
        option("--count", "number of orders; default: %(default)s", int, default=12),
        "skip_time",
        method=Response.orders,
    ),
    Command(
        answers.export,
        "  gearbow export run.npz run.csv\n  gearbow export run.npz run.xlsx",
        RUN,
        option("out", "the new file, .csv, .xlsx, .nc or .npz"),
        JSON,
    ),
    Command(
        answers.fmu,
        '  gearbow fmu train.toml --speed "1500 rpm" --torque-input pinion\n'
        '  gearbow fmu train.toml --speed "1500 rpm" --speed-input "500 rpm" "3000 rpm"'
        " --record gears pinion/wheel --out train.fmu",
        *(scene(), "speed"),
        parameter(
            "torque_inputs",
            "--torque-input",
            "PLACE: a name or shaft@position",
            metavar="PLACE",
        ),
        parameter("speed_input", type=quantity("speed"), nargs=2),
        *(RECORD, ACCURACY),
        option("--out", "file .fmu; default: the name of the scene file", dest="path"),
        method=RotorSystem.to_fmu,
    ),
    Command(
        answers.identify,
        "  gearbow identify scene.toml run_down.csv --unknown bow:input:2 "
        "--unknown unbalance:pinion --plot fit.png\n"
        '  gearbow identify scene.toml run_down.csv --unknown bow:input --noise "1 um"',
        scene(),
        option(
            "measured",
            "table: speed, shaft, position and angle of a probe, amplitude, phase; or a "
            'line for each speed, with columns such as "input@0.2 y amplitude [um pp]"',
            Path,
            nargs="+",
        ),
        option(
            "--detection",
            "what amplitudes are whose heading does not say it; default: peak",
            choices=DETECTIONS,
        ),
        option(
            "--unknown",
            "bow:SHAFT, bow:SHAFT:SHAPES, unbalance:NAME, unbalance:SHAFT@POSITION or "
            "parameter:PATH; may be repeated",
            action="append",
            required=True,
            dest="unknowns",
            metavar="UNKNOWN",
        ),
        flag("--no-runout", "the probes have no unknown run-out"),
        parameter("noise", text="default: from the residual", nargs=None),
        drawn("--plot", "write a figure to this file"),
        method=identify,
    ),
    Command(
        answers.skill,
        "  gearbow skill\n  gearbow skill > AGENTS.md",
    ),
    Command(
        answers.schema,
        "  gearbow schema modes",
        option("of", "a command, such as modes", metavar="COMMAND"),
    ),
    Command(
        answers.completion,
        '  eval "$(gearbow completion bash)"                          # in ~/.bashrc\n'
        "  gearbow completion zsh > ~/.zsh/completions/_gearbow        # in a folder of fpath",
        option("shell", "the shell", choices=("bash", "zsh", "tcsh")),
    ),
)
