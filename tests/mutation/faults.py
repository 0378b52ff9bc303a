"""Faults that the tests of the Python package must catch.

Each fault is the kind of mistake that a programmer makes: a wrong sign, unit, factor, index or
default, an argument that is ignored, a label that does not fit its values, metadata that is lost.
`run.py` plants one fault at a time and runs the named tests. At least one of them must fail.

The text of a fault occurs exactly once in its module; `tests/python/test_planted_faults.py` checks
this. If you change such a line, adapt the entry here.
"""

from __future__ import annotations

from typing import NamedTuple


class Fault(NamedTuple):
    """One fault in one line of the package.

    Parameters
    ----------
    module : str
        File path relative to the package folder.
    text : str
        Source text that occurs exactly once in the file.
    replacement : str
        The faulty source text.
    tests : tuple of str
        Names of the test files in `tests/python` that must catch the fault, without "test_".
    """

    module: str
    text: str
    replacement: str
    tests: tuple[str, ...]


def _faults(module: str, tests: str, *changes: tuple[str, str]) -> list[Fault]:
    """Give faults of one module that the same test files catch."""
    return [Fault(module, *change, tuple(tests.split())) for change in changes]


FAULTS: list[Fault] = [
    *_faults(
        "system/simulation.py",
        "exponential_run_up",
        ('            method = "exponential"\n', '            method = "rk45"\n'),
    ),
    *_faults(
        "results/static.py",
        "static_answers",
        (
            "self.coordinates.displacement(self.state, name)",
            "self.coordinates.displacement(self.state, name)[::-1]",
        ),
        (
            "float(self.state[self.coordinates.twist(name)])",
            "-float(self.state[self.coordinates.twist(name)])",
        ),
        (
            'self._data["bearing_force"][self._bearing(shaft, position)]',
            'self._data["bearing_force"][-1 - self._bearing(shaft, position)]',
        ),
        ("i = meshes.index((driver, driven))", "i = 0"),
    ),
    *_faults(
        "recording/motion.py",
        "signals figure_labels rates",
        (
            'self._data["displacement"][:, self._point(name)]',
            'self._data["displacement"][:, self._point(name), ::-1]',
        ),
        (
            'self._data["twist"][:, self._point(name)]',
            '-self._data["twist"][:, self._point(name)]',
        ),
        ('self._rate("twist_rate", name)', '-self._rate("twist_rate", name)'),
    ),
    *_faults(
        "sensors/probe.py",
        "sensors",
        ("self.angle - recording.angle(self.shaft)", "self.angle + recording.angle(self.shaft)"),
        ("motion - displacement(self.support)", "motion"),
        ("np.exp(-1j * angles)", "np.exp(1j * angles)"),
    ),
    *_faults(
        "sensors/tacho.py",
        "sensors",
        ("angle(t) - self.angle", "angle(t)"),
        ("angle(t) + _cubic(time, twist, twist_rate, t)", "angle(t)"),
    ),
    *_faults(
        "recording/resample.py",
        "sensors",
        ("PASS, STOP = 0.4, 0.5", "PASS, STOP = 0.5, 0.6"),
        ("np.i0(_BETA * np.sqrt(inside))", "1.0"),
    ),
    *_faults(
        "recording/recording.py",
        "signals figure_labels",
        ("i = meshes.index((driver, driven))", "i = 0"),
        ("time=self.time, **terms", "time=self.time - self.time[0], **terms"),
    ),
    *_faults(
        "recording/recorded_run.py",
        "signals figure_labels",
        ("np.full(self.time.shape, self.speed)", "np.full(self.time.shape, abs(self.speed))"),
    ),
    *_faults(
        "recording/bearings.py",
        "signals figure_labels journal_bearing",
        (
            'self._data["bearing_force"][:, self._bearing(shaft, position)]',
            '-self._data["bearing_force"][:, self._bearing(shaft, position)]',
        ),
        ("return found[:, bearing]", "return -found[:, bearing]"),
    ),
    *_faults(
        "results/signals.py",
        "signals figure_labels",
        ("skip_time=skip_time,", "skip_time=0.0,"),
        ("sidebands=sidebands,", "sidebands=1,"),
        ("shaft_harmonics=shaft_harmonics,", "shaft_harmonics=4,"),
        ("mesh_harmonics=mesh_harmonics,", "mesh_harmonics=3,"),
        ("spectrum(self, of, quantity, window=window)", "spectrum(self, of, quantity)"),
        ("shaft_harmonics: int = 4,", "shaft_harmonics: int = 3,"),
        ("mesh_harmonics: int | None = None,", "mesh_harmonics: int | None = 3,"),
    ),
    *_faults(
        "results/run_figures.py",
        "figure_labels given_axes",
        ("self._pairs(names)", "self._pairs(None)"),
        ("self._bearings(names)", "self._bearings(None)"),
        ('("force", "deflection", "stiffness")', '("force", "stiffness", "deflection")'),
        (
            '("contact_ratio", "pressure_angle", "centre_line_angle", "centre_distance")',
            '("contact_ratio", "centre_line_angle", "pressure_angle", "centre_distance")',
        ),
        ("2.0 * math.pi / slowest", "math.pi / slowest"),
    ),
    *_faults(
        "results/motion.py",
        "animation",
        ("ratio * angle for name", "abs(ratio) * angle for name"),
        ("values - values.mean(axis=0)", "values"),
        ("length / (span[1] - span[0])", "length"),
    ),
    *_faults(
        "plotting/development.py",
        "train_figure",
        ("height - body.radius, x + half", "height, x + half"),
        ("free[0] if free else", "wanted[0] if free else"),
    ),
    *_faults(
        "plotting/loads.py",
        "train_figure",
        ("-power / ratios[id(torque)]", "power / ratios[id(torque)]"),
        ("(-1.0 if (value or 0.0) < 0.0 else 1.0)", "1.0"),
    ),
    *_faults(
        "plotting/end_view.py",
        "train_figure",
        ("sense * np.cos(pressure_angle)", "np.cos(pressure_angle)"),
        ("if ratio < 0.0:", "if ratio > 0.0:"),
    ),
    *_faults(
        "recording/energy.py",
        "signals response",
        (
            "self.kinetic + self.shafts + self.bearings + self.meshes",
            "self.kinetic + self.shafts + self.bearings",
        ),
        ("(total - total[:1]) - (work - work[:1])", "(total - total[:1]) + (work - work[:1])"),
        ("(total - total[:1]) - (work - work[:1])", "(total - total[:1]) - work"),
        ('f"{name} [J]": getattr(self, name)', 'f"{name} [kJ]": getattr(self, name)'),
    ),
    *_faults(
        "orders/spectrum.py",
        "signals",
        ('"hann": (0.5, 0.5)', '"hann": (0.54, 0.46)'),
        ("amplitude = 2.0 * np.abs(", "amplitude = np.sqrt(2.0) * np.abs("),
        ("* column, axis=0)) / column.sum()", "* column, axis=0)) / time.size"),
        ("(column * values).sum(axis=0) / column.sum()", "values.mean(axis=0)"),
        ("amplitude[-1] /= 2.0", "amplitude[-1] /= 1.0"),
        ("if time.size % 2 == 0:", "if time.size % 2 == 1:"),
        ("np.arange(time.size) / time.size", "np.arange(time.size) / (time.size - 1)"),
        ("frequencies[1:], amplitude[1:]", "frequencies[:-1], amplitude[1:]"),
        (
            "np.fft.rfftfreq(time.size, steps.mean())",
            "2 * np.pi * np.fft.rfftfreq(time.size, steps.mean())",
        ),
        (
            "amplitudes(recording.time, signal.values, window)",
            "amplitudes(recording.time, signal.values)",
        ),
        ('values: Array, window: str = "hann"', 'values: Array, window: str = "flat top"'),
        ("> 1e-6 * abs(steps[0])", "> 1e-2 * abs(steps[0])"),
    ),
    *_faults(
        "orders/fit.py",
        "signals",
        ('begin + number(skip_time, "skip_time")', "begin"),
        ('begin + number(skip_time, "skip_time")', 'number(skip_time, "skip_time")'),
        ("abs(recording.speed) / (2.0 * np.pi)", "abs(recording.speed)"),
        ("hertz = abs(recording.speed) /", "hertz = recording.speed /"),
        ("fitted[1 : count + 1] - 1j *", "fitted[1 : count + 1] + 1j *"),
        ("turned = np.exp(-2j * np.pi", "turned = np.exp(2j * np.pi"),
        (
            "np.sqrt(np.mean(fitted.remainder**2))",
            "np.sqrt(np.sum(fitted.remainder**2))",
        ),
        ("step * frequencies[-1] >= 0.5", "step * frequencies[-1] >= 1.0"),
        ("np.diff(time).max()", "np.diff(time).min()"),
        ("span = float(time[-1] - time[0])", "span = float(time[-1])"),
        ("if span * gap < SEPARATION:", "if span * gap < 0.5 * SEPARATION:"),
        ("return float(abs(value))", "return float(value.real)"),
        ("{self.frequencies_hz[j]:>9.4g}", "{self.frequencies_hz[j - 1]:>9.4g}"),
        ("{abs(self.amplitudes[j]):>10.4g}", "{2 * abs(self.amplitudes[j]):>10.4g}"),
        ("time.size <= 2 * frequencies.size + 1:", "time.size < 2 * frequencies.size + 1:"),
        ("np.diff(frequencies, prepend=0.0)", "np.diff(frequencies)"),
        ("figures.orders(names, amplitudes[chosen]", "figures.orders(names, amplitudes[largest]"),
        ('[: whole(count, "count")]', '[: whole(count, "count") - 1]'),
    ),
    *_faults(
        "orders/channel.py",
        "signals",
        (
            "recording.bearing_force(item[1], item[2])[:, component]",
            "recording.bearing_force(item[1], item[2])[:, 0]",
        ),
        ('lateral[kind](at)[:, "vw".index(axis)]', "lateral[kind](at)[:, 0]"),
        ('{"force": MESH["force"], **MESH}', "MESH"),
        (
            'return Channel("energy", "J", recording.energy)',
            'return Channel("energy", "J", recording.energy - recording.energy[0])',
        ),
    ),
    *_faults(
        "description/kinematics.py",
        "signals",
        (
            "tooth = driver.teeth * ratios[driver.shaft]",
            "tooth = driven.teeth * ratios[driver.shaft]",
        ),
        ("n * abs(ratio), f", "n * ratio, f"),
        ('((1.0, "+"), (-1.0, "−"))', '((-1.0, "+"), (1.0, "−"))'),
        ("sign * n * ratios[shaft]", "sign * ratios[shaft]"),
        ("for n in range(1, harmonics + 1):", "for n in range(1, harmonics):"),
        ("for m in range(1, harmonics + 1):", "for m in range(1, harmonics):"),
        ("if value > 0.0:", "if value > 1.0:"),
        ("        sidebands: int = 1,\n", "        sidebands: int = 2,\n"),
        ("SAME = 1e-9", "SAME = 2e-2"),
    ),
    *_faults(
        "orders/waterfall.py",
        "signals",
        ("spectrum(run, of, quantity, window=window)", "spectrum(run, of, quantity)"),
        ("spectrum(run, of, quantity, window=window)", "spectrum(run, of, window=window)"),
        ("for each in spectra])[order]", "for each in spectra])"),
        ("np.array(speeds)[order]", "np.array(speeds)"),
        ("speeds.append(abs(run.speed))", "speeds.append(run.speed)"),
        ("runs[0].kinematics", "None"),
        ("rtol=1e-6, atol=0.0", "rtol=1e-1, atol=0.0"),
    ),
    *_faults(
        "description/kinematics.py",
        "rolling_bearing",
        ("k * passing", "passing"),
        ("bearing.cage_order * ratios", "bearing.ball_pass_order * ratios"),
    ),
    *_faults(
        "description/rolling.py",
        "rolling_bearing",
        ("return self.balls * self.cage_order", "return self.cage_order"),
        ("(0.0, -number(load", "(0.0, number(load"),
    ),
    *_faults(
        "recording/bearings.py",
        "rolling_bearing",
        (
            'np.moveaxis(self._data["rolling_contact"][:, i], -1, 0))',
            'np.moveaxis(self._data["rolling_contact"][:, i, ::-1], -1, 0))',
        ),
    ),
    *_faults(
        "plotting/orders.py",
        "figure_labels",
        (
            "panel.semilogy(frequencies_hz, amplitudes,",
            "panel.semilogy(frequencies_hz, 1e6 * amplitudes,",
        ),
        ("panel.set(xlabel=label)", 'panel.set(xlabel="amplitude")'),
        ("ax=panel, label=label", "ax=panel, location='right'"),
        ("order * speeds / (2.0 * np.pi * factor)", "order * speeds"),
        ("ylabel=speed)", 'ylabel="speed [rpm]")'),
        (
            "panel.set_xlim(0.0, highest)\n        _order",
            "panel.set_xlim(0.0, 2.0 * highest)\n        _order",
        ),
    ),
    *_faults(
        "recording/channels.py",
        "signals",
        ('{"v": "m", "w": "m", "twist"', '{"w": "m", "v": "m", "twist"'),
        ('"twist": "rad"', '"twist": "°"'),
    ),
    *_faults(
        "recording/tables.py",
        "units_of_files",
        (
            '"displacement": ("m", ("time", "point", "axis"))',
            '"displacement": ("mm", ("time", "point", "axis"))',
        ),
        ('"twist": ("rad", ("time", "point"))', '"twist": ("deg", ("time", "point"))'),
        ('"bearing_force": ("N", ', '"bearing_force": ("kN", '),
        ('f"energy_{name}": ("J", ', 'f"energy_{name}": ("W", '),
        ('f"mesh_{name}": (unit, ', 'f"mesh_{name}": ("1", '),
        ('{"units": unit}', "{}"),
        ('np.array(["y", "z"])', 'np.array(["z", "y"])'),
        ('data["time"], {"units": "s"}', 'data["time"], {"units": "ms"}'),
        ('"mesh": ["/".join(pair)', '"mesh": ["/".join(pair[::-1])'),
        (
            'columns[f"{name} w [m]"] = data["displacement"][:, i, 1]',
            'columns[f"{name} w [m]"] = data["displacement"][:, i, 0]',
        ),
        ('columns[f"{name} twist [rad]"]', 'columns[f"{name} twist [mrad]"]'),
        ('data["bearing_force"][:, i, axis]', 'data["bearing_force"][:, i, 1 - axis]'),
        ("name in ENERGIES else", "name not in ENERGIES else"),
        ('"errors": None if run.errors is None else', '"errors": None if True else'),
        ('"accuracy": run.accuracy', '"accuracy": None'),
        ('"events": data["events"]', '"events": []'),
    ),
    *_faults(
        "analysis/balance.py",
        "balance_numbers balance",
        ("lstsq(table, -before.reshape(-1)", "lstsq(table, before.reshape(-1)"),
        ("residual=before + influence @ unbalances", "residual=before"),
        ('found.elastic if target == "elastic" else found.displacement', "found.displacement"),
        ("unbalance=body.unbalance + unbalance", "unbalance=unbalance"),
        (
            "np.linalg.norm(self.residual) / np.linalg.norm(self.before)",
            "np.linalg.norm(self.before) / np.linalg.norm(self.residual)",
        ),
        ("source = found.shafts.index(shaft)", "source = 0"),
        ('"unbalance") - still for plane', '"unbalance") for plane'),
        ('before = read(base, "both")', 'before = read(base, "bow")'),
        ("for x in nodes)", "for x in list(nodes)[:-1])"),
        ("planes=chosen,", "planes=chosen[::-1],"),
        ("float(plane[1]), 0.0, 0.0, 0.0)", "float(plane[1]), 0.0, 1.0, 0.0)"),
        ('target: str = "total"', 'target: str = "elastic"'),
    ),
    *_faults(
        "results/peak.py",
        "synchronous_orbits",
        ("else abs(self.speed) / width", "else 2.0 * abs(self.speed) / width"),
        ("/ (factor - 1.5)", "/ (factor - 1.0)"),
        ("else 10.0 + margin", "else margin"),
        ("(low - speed) / low", "(low - speed) / speed"),
        ("(speed - high) / high", "(speed - high) / speed"),
        ("CRITICALLY_DAMPED = 2.5", "CRITICALLY_DAMPED = 3.5"),
    ),
    *_faults(
        "results/synchronous.py",
        "synchronous_orbits",
        ("(np.abs(v + 1j * w) + np.abs(v - 1j * w)) / 2.0", "np.hypot(np.abs(v), np.abs(w))"),
        ("circle = v + 1j * w", "circle = v - 1j * w"),
        ("[:, :, 2 * i : 2 * i + 2]", "[:, :, i : i + 2]"),
        ("elastic[:, own] -= self._bow[indices]", "elastic[:, own] += self._bow[indices]"),
        ("elastic[:, own] -= self._bow[indices]", "elastic[:, 0] -= self._bow[indices]"),
        ("amplitudes=self.amplitudes - run_out", "amplitudes=self.amplitudes + run_out"),
        (
            "self.amplitudes[:, :, self.coordinates.twist(name)]",
            "self.amplitudes[:, :, self.coordinates.twist(name)].conj()",
        ),
        ("synchronous(np.array([slow]), self.excitation)", 'synchronous(np.array([slow]), "both")'),
        ("np.unique(self.speeds),", "self.speeds,"),
        ("own if source is None else source", "own"),
    ),
    *_faults(
        "results/campbell.py",
        "tables",
        ("frequency_hz=float(value.imag) / (2.0 * np.pi)", "frequency_hz=float(value.imag)"),
        ("self.eigenvalues.imag / (2.0 * np.pi)", "np.abs(self.eigenvalues) / (2.0 * np.pi)"),
        ("size > 0.0, -eigenvalues.real /", "size > 0.0, eigenvalues.real /"),
        ('f"{mode + 1}"', 'f"{mode}"'),
        ('f"{100.0 * damping:.3f}"', 'f"{damping:.3f}"'),
        ('"frequency [Hz]": intersection.frequency_hz', '"frequency [Hz]": intersection.speed'),
        (
            '"damping ratio": intersection.damping_ratio',
            '"damping ratio": 100.0 * intersection.damping_ratio',
        ),
        ('intersection.line.kind == "shaft"', 'intersection.line.kind != "shaft"'),
    ),
    *_faults(
        "system/linear.py",
        "tables",
        (
            ".critical_speed_map(wanted, excitation, count)",
            ".critical_speed_map(2.0 * wanted, excitation, count)",
        ),
        (
            ".critical_speed_map(wanted, excitation, count)",
            ".critical_speed_map(wanted, 1.0, count)",
        ),
        (
            "CriticalSpeedMap.from_rows(wanted, excitation,",
            "CriticalSpeedMap.from_rows(wanted, 1.0,",
        ),
        (
            "self._model.campbell(wanted, count, harmonics)",
            "self._model.campbell(wanted, count, 1)",
        ),
    ),
    *_faults(
        "results/critical_speeds.py",
        "figure_labels",
        ("self.lines(whirl)[:, :most]", "self.lines(whirl)[:, :4]"),
    ),
    *_faults(
        "results/modes.py",
        "tables",
        ('{"v": "v", "G": "v", "w": "w", "B": "w"', '{"v": "w", "G": "w", "w": "v", "B": "v"'),
        ("[other == group for other in groups]", "[other[0] == group[0] for other in groups]"),
        ("{100.0 * ratio:>11.3f}", "{ratio:>11.3f}"),
        ('"damping ratio": self.damping_ratios', '"damping ratio": 100.0 * self.damping_ratios'),
    ),
    *_faults(
        "results/modes.py",
        "elements",
        ('direction.rstrip("0123456789")', "direction[:1]"),
    ),
    *_faults(
        "_lookup.py",
        "elements",
        ("if not isinstance(x, tuple)", "if isinstance(x, float) or direction"),
    ),
    *_faults(
        "description/shafts.py",
        "elements",
        ("degree: int | None = None", "degree: int | None = 2"),
    ),
    *_faults(
        "plotting/campbell.py",
        "figure_labels",
        ("100.0 * damping_ratios[:, mode]", "damping_ratios[:, mode]"),
        ("ends, slope * ends / (2.0 * np.pi)", "ends, slope * ends"),
        ('ylabel="frequency [Hz]"', 'ylabel="frequency [rad/s]"'),
    ),
    *_faults(
        "plotting/frequency.py",
        "figure_labels",
        ("np.degrees(np.unwrap(phase[known]))", "np.unwrap(phase[known])"),
        ("np.degrees(np.unwrap(phase[known]))", "np.degrees(phase[known])"),
        ('ylabel="phase [°]"', 'ylabel="phase [rad]"'),
        ('ylabel="amplitude [µm]"', 'ylabel="amplitude [mm]"'),
        ('ylabel=f"critical speed [{speed_unit}]"', 'ylabel="critical speed [rpm]"'),
        ("label=shaft,", "label=label,"),
        ('f"ω = {excitation:g} Ω"', 'f"ω = Ω"'),
    ),
    *_faults(
        "plotting/style.py",
        "figure_labels",
        ("MICRO = 1e6", "MICRO = 1e3"),
        ('f"speed of the reference shaft [{unit}]"', '"speed of the reference shaft [Hz]"'),
    ),
    *_faults(
        "plotting/response.py",
        "figure_labels",
        ('xlabel="v [µm]", ylabel="w [µm]"', 'xlabel="w [µm]", ylabel="v [µm]"'),
        ("v[-1:], w[-1:]", "v[:1], w[:1]"),
        ('("v − mean", "w − mean")', '("w − mean", "v − mean")'),
        ('MICRO * amplitude, ("v", "w")', 'amplitude, ("v", "w")'),
        ('("along y", "along z")', '("along z", "along y")'),
        ("MICRO * deflection", "deflection"),
        ("stiffness / MICRO", "stiffness"),
        ("1e3 * values", "1e6 * values"),
        ('ylabel=f"{label} [mrad]"', 'ylabel=f"{label} [rad]"'),
        ("np.degrees(centre_line_angle)", "np.degrees(pressure_angle)"),
        ('"pressure angle [°]":', '"pressure angle [rad]":'),
        ('f"{driver} – {driven}"', 'f"{driven} – {driver}"'),
        ('label_x(axes, "frequency [Hz]")', 'label_x(axes, "frequency [rad/s]")'),
        ('ylabel=f"{label} [J]"', 'ylabel=f"{label} [kJ]"'),
    ),
    *_faults(
        "plotting/modes.py",
        "figure_labels",
        ('xlabel="position [m]"', 'xlabel="position [mm]"'),
        ("return np.real(shape / largest)", "return np.imag(shape / largest)"),
        ('{"v": "-", "w": "--"}', '{"w": "-", "v": "--"}'),
    ),
    *_faults(
        "description/layout.py",
        "shape_plot frequency_plots",
        ("distance * np.cos(angle)", "-distance * np.cos(angle)"),
        ("body.module * body.teeth / 2.0", "body.module * body.teeth"),
        (
            "np.sqrt(2.0 * body.polar_inertia / body.mass)",
            "np.sqrt(body.polar_inertia / body.mass)",
        ),
        ("segment.outer_diameter / 2.0", "segment.outer_diameter"),
        ("24.0 * (1.0 + ratio)", "12.0 * (1.0 + ratio)"),
        ("(1.0 + square) / 16.0", "(1.0 - square) / 16.0"),
        ("if not shaft.shear:", "if shaft.shear is None:"),
    ),
    *_faults(
        "plotting/within_elements.py",
        "shape_plot",
        ('("w", "B", -1.0)', '("w", "B", 1.0)'),
        ("_integrated(n - 1).integ(lbnd=-1.0)", "_integrated(n)"),
        ("2.0 / length * own.deriv()", "own.deriv()"),
        ("(xi - xi**2) * phi / 2.0),\n        3.0", "(xi - xi**2) * phi),\n        3.0"),
    ),
    *_faults(
        "plotting/mode_shape.py",
        "shape_plot frequency_plots",
        ("along - gamma * y + beta * z", "along + gamma * y + beta * z"),
        (
            "np.cos(around + twist), radius * np.sin(around + twist)",
            "np.cos(around - twist), radius * np.sin(around - twist)",
        ),
        ('ylabel="y [m]", zlabel="z [m]"', 'ylabel="z [m]", zlabel="y [m]"'),
        ("np.conj(largest) / np.abs(largest)", "largest / np.abs(largest)"),
    ),
    *_faults(
        "results/modes.py",
        "shape_plot frequency_plots",
        ("self.shapes[number - 1 : number]", "self.shapes[number : number + 1]"),
        (
            "{100.0 * self.damping_ratios[number - 1]:.2f} %",
            "{self.damping_ratios[number - 1]:.2f} %",
        ),
    ),
    *_faults(
        "tradeoff/signals.py",
        "tradeoff_numbers",
        ("_rms(mine - others) / rms", "_rms(mine - others)"),
        ("_rms(values - values.mean(axis=0))", "_rms(values)"),
        ("np.sum(values**2, axis=1)", "np.sum(np.abs(values), axis=1)"),
        (
            "return max(self.errors(other, scale).values())",
            "return min(self.errors(other, scale).values())",
        ),
    ),
    *_faults(
        "tradeoff/trial.py",
        "tradeoff_numbers",
        ("return max(self.errors.values())", "return min(self.errors.values())"),
        ("return max(self.error, self.floor)", "return self.error"),
        ("return self.stepping / self.duration", "return self.seconds / self.duration"),
        ("self.setup + self.rate * duration", "self.rate * duration"),
        ("if error > floor else", "if error >= 0.0 else"),
        ('f"{trial.setup:.2g}"', 'f"{trial.stepping:.2g}"'),
    ),
    *_faults(
        "tradeoff/result.py",
        "tradeoff_numbers",
        ("if trial.bound <= wanted:", "if trial.error <= wanted:"),
        ("(trial.cost(duration), trial.bound)", "(trial.cost(), trial.bound)"),
        ("simplified or trial.model == GIVEN", "trial.model == GIVEN"),
        ('"set-up seconds": trial.setup', '"set-up seconds": trial.stepping'),
        ('"model error": trial.model_error', '"model error": trial.integration_error'),
        ('"front": trial in front', '"front": trial not in front'),
        (
            "[trial.bound for trial in trials], [trial.cost(duration)",
            "[trial.error for trial in trials], [trial.cost(duration)",
        ),
        ("[trial.cost(duration) for trial in trials]", "[trial.cost() for trial in trials]"),
    ),
    *_faults(
        "tradeoff/study.py",
        "tradeoff_numbers tradeoff",
        ("run.signals.error(own.signals, reference)", "run.signals.error(reference, reference)"),
        ("model_error=own.signals.error(", "model_error=run.signals.error("),
        (
            "errors = run.signals.errors(reference, reference)",
            "errors = run.signals.errors(run.signals, reference)",
        ),
    ),
    *_faults(
        "plotting/tradeoff.py",
        "tradeoff_numbers",
        ("simulated s [s]", "simulated s [ms]"),
    ),
    *_faults(
        "description/speed.py",
        "bow_and_speed_profile",
        (
            "[begin, begin + duration], [number(start",
            "[0.0, duration], [number(start",
        ),
        ("np.array([slopes, values[:-1]])", "np.array([slopes, values[1:]])"),
        ("value = value * since + row[piece]", "value = value + row[piece]"),
        ("(-5.5 * a + 9.0 * b - 4.5 * c + d) / h", "(-5.5 * a + 9.0 * b - 4.5 * c + d)"),
    ),
    *_faults(
        "description/bow.py",
        "bow_and_speed_profile",
        (
            'cls("half_sine", amplitude=amplitude, phase=phase)',
            'cls("half_sine", amplitude=amplitude)',
        ),
        (
            'cls("sag", amplitude=amplitude, phase=phase)',
            'cls("half_sine", amplitude=amplitude, phase=phase)',
        ),
        ("phase=phase, number=number", "phase=phase, number=1"),
        ("np.abs(curve), np.angle(curve)", "np.abs(curve), -np.angle(curve)"),
        ("np.linspace(0.0, length, SAMPLES)", "np.linspace(0.0, 1.0, SAMPLES)"),
        ("[angles] * len(deflections)", "[0.0] * len(deflections)"),
    ),
    *_faults(
        "accuracy/levels.py",
        "modal_reduction",
        (
            "return REDUCTION_SHARE * self.displacement, REDUCTION_SHARE * self.mesh_force",
            "return REDUCTION_SHARE * self.mesh_force, REDUCTION_SHARE * self.displacement",
        ),
        ("        if error > most:", "        if error < most:"),
        ("level or LEVELS[DEFAULT]", 'level or LEVELS["draft"]'),
        ('("displacements", "mesh forces")', '("mesh forces", "displacements")'),
    ),
    *_faults(
        "recording/file.py",
        "checkpoint",
        ("tuple(value) if isinstance(value, list) else value", "value"),
    ),
    *_faults(
        "recording/motion.py",
        "helical",
        ('self._axial("axial")[:, point]', 'self._axial("axial")[:, point - 1]'),
    ),
    *_faults(
        "recording/bearings.py",
        "helical",
        (
            'self._axial("axial_bearing_force")[:, bearing]',
            '-self._axial("axial_bearing_force")[:, bearing]',
        ),
    ),
    *_faults(
        "system/linear.py",
        "helical",
        (', "axial_stiffness", "tilting_stiffness")', ")"),
    ),
    *_faults(
        "description/couplings.py",
        "helical",
        ('axial = description.get("axial", 0.0)', "axial = 0.0"),
    ),
    *_faults(
        "results/steady.py",
        "steady_state",
        ("if np.pi - angle < _REAL", "if angle > _REAL"),
        ("abs(largest) > 1.0 + _ERROR", "abs(largest) > 1.1"),
    ),
    *_faults(
        "analysis/branch_point.py",
        "continuation",
        ("return float(point.tangent[-1])", "return abs(float(point.tangent[-1]))"),
    ),
]
