"""The table of commands: name, help, examples, arguments, and the function that answers."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import get_args

from gearbow._types import StrengthLine
from gearbow.cli import answers
from gearbow.cli.answers import Answer
from gearbow.cli.arguments import (
    ACCURACY,
    COUNT,
    DURATION,
    ENDURANCE_LIMIT,
    JSON,
    RECORD,
    RUN,
    SIGNALS_OUT,
    SPEED,
    SPEEDS,
    TENSILE_STRENGTH,
    Argument,
    drawn,
    flag,
    kind,
    number,
    option,
    output,
    progress,
    quantity,
    scene,
    spectrum_case,
    speed,
)
from gearbow.exchange.tables import DETECTIONS
from gearbow.machines.examples import scene_files


class Command:
    """A command: its name, the function that answers it, its help, examples and arguments."""

    def __init__(
        self,
        name: str,
        call: Callable[[argparse.Namespace], Answer],
        text: str,
        examples: str,
        *arguments: Argument,
    ) -> None:
        self.name, self.call, self.text, self.examples = name, call, text, examples
        self.arguments = arguments


COMMANDS = (
    Command(
        "new",
        answers.new,
        "write a commented example of a scene file",
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
        "report",
        answers.report,
        "write a report of all analyses as one HTML page",
        '  gearbow report gearbox.toml --speed "1480 rpm"\n'
        '  gearbow report gearbox.toml --speed "1200 rpm" "1480 rpm" --to "3000 rpm" --out g.html',
        scene(),
        option(
            "--speed",
            'operating speed, or the lowest and the highest, for example "1480 rpm"; default: '
            "that of the load case of a REXS file; without any, the report has standstill",
            speed,
            nargs="+",
        ),
        option(
            "--from", "lowest speed of the diagrams; default: 5 %% of --to", speed, dest="first"
        ),
        option(
            "--to",
            "highest speed of the diagrams; default: 150 %% of the operating speed",
            speed,
            dest="last",
        ),
        number("--points", 100, "number of speeds"),
        number("--modes", 8, "number of modes"),
        option("--title", "heading; default: the name of the scene file"),
        ENDURANCE_LIMIT,
        TENSILE_STRENGTH,
        option("--company", "company below the heading"),
        option("--author", "author below the heading"),
        option("--document-number", "number of the document below the heading"),
        option("--date", "date of the document below the heading"),
        option(
            "--language", "language of the page; default: en", choices=["en", "de"], default="en"
        ),
        option("--out", "file .html; default: the name of the scene file"),
        progress,
    ),
    Command(
        "demo",
        answers.demo,
        "write the report of an example, and open it in the browser",
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
        JSON,
        progress,
    ),
    Command(
        "import",
        answers.import_,
        "print the scene of a REXS file (.rexs, .rexsj, .rexsz) or a rotor of ROSS (.toml, .json)",
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
        "check",
        answers.check,
        "check a scene file, and summarise the system",
        "  gearbow check scene.toml\n  gearbow check scene.toml --json",
        scene(),
    ),
    Command(
        "plot",
        answers.plot,
        "draw the train to scale, or the signals of a run",
        "  gearbow plot scene.toml\n  gearbow plot scene.toml --out train.svg\n"
        "  gearbow plot run.npz --kind spectrum --out spectrum.png",
        scene("or the file of a run"),
        kind(None),
        option("--at", "places or meshes of a run; default: all", nargs="+", metavar="ITEM"),
        drawn("--out", "file of the figure; default: train.png, or the kind of a run"),
    ),
    Command(
        "modes",
        answers.modes,
        "print natural frequencies, damping and whirl at one speed",
        '  gearbow modes scene.toml\n  gearbow modes scene.toml --speed "1500 rpm" --count 20',
        scene(),
        option("--speed", 'for example "1500 rpm"; default: 0', speed, default=0.0),
        COUNT,
        flag("--vibrating", "leave out rigid-body and overdamped motions"),
    ),
    Command(
        "campbell",
        answers.campbell,
        "print the speeds at which shafts and teeth excite a mode",
        '  gearbow campbell scene.toml --to "6000 rpm"\n'
        '  gearbow campbell scene.toml --to "6000 rpm" --harmonics 0 --out campbell.png',
        scene(),
        option("--from", "default: 0", speed, default=0.0, dest="first"),
        option("--to", 'for example "6000 rpm"', speed, required=True, dest="last"),
        number("--points", 50, "number of speeds"),
        COUNT,
        number("--harmonics", 1, "harmonics of the tooth frequencies"),
        drawn("--out", "write the diagram to this file, for example .png"),
    ),
    Command(
        "efficiency",
        answers.efficiency,
        "print the losses of the meshes by friction, and the efficiency of the train",
        '  gearbow efficiency scene.toml --speed "1500 rpm"\n'
        '  gearbow efficiency scene.toml --speed "500 rpm" "3000 rpm" --out losses.png',
        scene(),
        SPEEDS,
        drawn("--out", "write a figure to this file, for example .png"),
    ),
    Command(
        "stresses",
        answers.stresses,
        "print mean and alternating stresses of the turning shafts",
        '  gearbow stresses scene.toml --speed "1500 rpm"\n'
        '  gearbow stresses scene.toml --speed "1500 rpm" --endurance-limit "280 MPa"'
        ' --tensile-strength "700 MPa" --line din743',
        scene(),
        SPEED,
        ENDURANCE_LIMIT,
        TENSILE_STRENGTH,
        option(
            "--line", "line of mean stresses", choices=get_args(StrengthLine), default="goodman"
        ),
        drawn("--out", "write a figure to this file, for example .png"),
    ),
    Command(
        "life",
        answers.life,
        "print loads, rating life in hours and static safety of the rolling bearings",
        '  gearbow life scene.toml --speed "1500 rpm"\n'
        '  gearbow life scene.toml --spectrum "1500 rpm, 250 N m, 0.6" "3000 rpm, 100 N m, 0.4"',
        scene(),
        option("--speed", 'for example "1500 rpm"; or give --spectrum', speed),
        option(
            "--spectrum",
            'cases "speed, torque, share of the time"; the torque is that of the drive',
            spectrum_case,
            nargs="+",
            metavar="CASE",
        ),
        option(
            "--factor", "factor of lubrication and contamination; default: 1", float, default=1.0
        ),
        option("--reliability", "from 0.9 to 0.9995; default: 0.9", float, default=0.9),
        drawn("--out", "write a figure to this file, for example .png"),
    ),
    Command(
        "bow-limits",
        answers.bow_limits,
        "print the bow of a shaft at which teeth jam, interfere or lose contact",
        '  gearbow bow-limits scene.toml --shaft input --speed "1500 rpm"\n'
        '  gearbow bow-limits scene.toml --shaft input --speed "1500 rpm" --out bow.png',
        scene(),
        option("--shaft", "one shaft, or several together", nargs="+", required=True),
        SPEEDS,
        option("--phase", "angle in the shaft; default: the worst one", quantity("phase")),
        drawn("--out", "write a figure to this file, for example .png"),
    ),
    Command(
        "response",
        answers.response,
        "print or draw the response to a harmonic force, torque or transmission error",
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
        option("--from", "default: 1Hz", quantity("frequency"), default="1Hz", dest="first"),
        option("--to", "for example 5kHz", quantity("frequency"), required=True, dest="last"),
        number("--points", 1000, "number of frequencies"),
        option("--speed", 'for example "1500 rpm"; default: 0', speed, default=0.0),
        drawn("--plot", "write a Bode plot to this file"),
    ),
    Command(
        "run",
        answers.run,
        "simulate the motion, print the size of the signals, and save them",
        '  gearbow run scene.toml --duration 0.5 --speed "1500 rpm" --out run.npz\n'
        '  gearbow run scene.toml --duration "10 s" --speed 0 --end-speed "3000 rpm" \\\n'
        "      --record gears meshes shaft@0.25 --checkpoint run.npz",
        *(scene(), DURATION, SPEED, progress),
        option("--end-speed", "change the speed linearly to this one", speed),
        *(ACCURACY, RECORD, SIGNALS_OUT),
        option(
            "--checkpoint",
            "save during the run; the same command continues after an interruption",
            output,
        ),
        drawn("--figure", "draw the signals to this file, for example .png"),
        kind("orbits"),
    ),
    Command(
        "steady",
        answers.steady,
        "find the motion that remains after the transient, and whether it is stable",
        '  gearbow steady scene.toml --speed "1500 rpm" --record gears meshes --out steady.npz',
        scene(),
        SPEED,
        progress,
        ACCURACY,
        RECORD,
        SIGNALS_OUT,
    ),
    Command(
        "tradeoff",
        answers.tradeoff,
        "measure error and CPU time of methods and settings",
        '  gearbow tradeoff scene.toml --duration 0.1 --speed "1500 rpm" --signals pinion/wheel',
        *(scene(), DURATION, SPEED, progress),
        option(
            "--signals",
            "a gear, disk, shaft@position or driver/driven; default: the first gear, or "
            "the first disk without gears",
            nargs="+",
            metavar="ITEM",
        ),
        option("--budget", "limit of the time; default: 60 s", quantity("budget"), default=60.0),
    ),
    Command(
        "orders",
        answers.orders,
        "print the amplitudes of a run at the orders of shafts and teeth",
        "  gearbow orders run.npz\n"
        "  gearbow orders run.npz --at pinion --quantity z --skip-time 0.1",
        RUN,
        JSON,
        option("--at", "place or mesh; default: the first recorded", metavar="ITEM"),
        option("--quantity", 'for example "z" or "force"; default: y or the force'),
        number("--count", 12, "number of orders"),
        option("--skip-time", "time of the transient [s]; default: 0", float, default=0.0),
    ),
    Command(
        "export",
        answers.export,
        "write the signals of a run as a table (.csv, .xlsx) or a data set (.nc)",
        "  gearbow export run.npz run.csv\n  gearbow export run.npz run.xlsx",
        RUN,
        option("out", "the new file, .csv, .xlsx, .nc or .npz"),
        JSON,
    ),
    Command(
        "fmu",
        answers.fmu,
        "write a functional mock-up unit (FMI 3.0) for other simulation programs",
        '  gearbow fmu train.toml --speed "1500 rpm" --torque-input pinion\n'
        '  gearbow fmu train.toml --speed "1500 rpm" --speed-input "500 rpm" "3000 rpm"'
        " --record gears pinion/wheel --out train.fmu",
        scene(),
        SPEED,
        option(
            "--torque-input",
            "places with an input torque, for example pinion input@0.2",
            nargs="+",
            metavar="PLACE",
        ),
        option("--speed-input", "smallest and largest value of an input speed", speed, nargs=2),
        RECORD,
        ACCURACY,
        option("--out", "file .fmu; default: the name of the scene file"),
    ),
    Command(
        "identify",
        answers.identify,
        "find bow, unbalance and run-out from measured once-per-revolution vibration",
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
            metavar="UNKNOWN",
        ),
        flag("--no-runout", "the probes have no unknown run-out"),
        option(
            "--noise",
            'standard deviation of a component, for example "1 um"; default: from the residual',
            quantity("noise"),
        ),
        drawn("--plot", "write a figure to this file"),
    ),
    Command(
        "skill",
        answers.skill,
        "print a short guide for coding assistants: calls, units, traps",
        "  gearbow skill\n  gearbow skill > AGENTS.md",
    ),
    Command(
        "schema",
        answers.schema,
        "print the JSON schema of what a command prints with --json",
        "  gearbow schema modes",
        option("of", "a command, such as modes", metavar="COMMAND"),
    ),
    Command(
        "completion",
        answers.completion,
        "print a script with which a shell completes commands, options and files",
        '  eval "$(gearbow completion bash)"                          # in ~/.bashrc\n'
        "  gearbow completion zsh > ~/.zsh/completions/_gearbow        # in a folder of fpath",
        option("shell", "the shell", choices=("bash", "zsh", "tcsh")),
    ),
)
