"""Every analysis of a machine of the fleet: how to compute it, and the equations that its result has to satisfy.

The equations are those of `reference.equations`; a result without equations of its own is compared with a second mechanism. A
new analysis is an entry of `ANALYSES`. An expensive analysis names the largest system whose cell is not slow.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.equations import Balance, Equations, rotating_force
from reference.machines import without_tooth_errors
from reference.standards import rated_hours

#: Number of modes.
COUNT = 6
#: Speeds of diagrams and responses, relative to the rated speed. Journal bearings carry nothing at speed 0.
SHARES = np.array([0.4, 0.8, 1.2])
#: Bearing stiffnesses of the map of critical speeds [N/m].
STIFFNESSES = (3e7, 3e8)
#: Loads of variations, relative to those of the machine.
LOADS = (0.8, 0.9)


def lateral(system: gb.RotorSystem) -> bool:
    return any(kind == "v" for _, _, kind in system.dofs)


def meshed(system: gb.RotorSystem) -> bool:
    return bool(system.meshes)


def internally_damped(system: gb.RotorSystem) -> bool:
    """Tell whether overdamped motions of the shafts are the lowest modes."""
    return any(shaft.internal_damping for shaft in system.shafts)


def balanced_shaft(system: gb.RotorSystem) -> gb.Shaft | None:
    """Return the first shaft with a bow; up to two of its bodies are the planes."""
    return next((s for s in system.shafts if s.bow is not None), None)


def bodies_on(system: gb.RotorSystem, shaft: gb.Shaft) -> list[str]:
    return [body.name for body in (*system.gears, *system.disks) if body.shaft == shaft.name]


def places(system: gb.RotorSystem) -> list[str]:
    return [body.name for body in (*system.gears, *system.disks)]


def varied(system: gb.RotorSystem, share: float) -> dict[str, Any]:
    """Return the change of the torques, of the gravity without them, to a share of their values."""
    if not system.torques:
        return {"gravity": 9.81 * share}
    return {
        "torques": [
            torque if torque.value == "balance" else replace(torque, value=share * torque.value)
            for torque in system.torques
        ]
    }


def quantity(system: gb.RotorSystem) -> str:
    """Quantity of a place that every run of the system has."""
    return "z" if lateral(system) else "twist"


def turn(system: gb.RotorSystem, speed: float) -> float:
    """Time after which the slowest shaft and all shafts with a drive of their own complete revolutions [s]."""
    slowest = min(abs(ratio) for ratio in system.speed_ratios if ratio != 0.0)
    own = [
        abs(ratio) / slowest
        for shaft, ratio in zip(system.shafts, system.speed_ratios, strict=True)
        if shaft.speed_ratio is not None
    ]
    # the motion has no period if they never do within 20 turns
    whole = (n for n in range(1, 21) if all(abs(n * r - round(n * r)) < 1e-6 for r in own))
    return 2.0 * pi * next(whole) / (slowest * abs(speed))


def chosen(system: gb.RotorSystem) -> list[gb.Shaft]:
    """Return the shafts with their numbers of elements: a new choice takes longer than most analyses."""
    return [gb.Shaft._from_description(each) for each in system._model.resolved()["shafts"]]


def recorded(system: gb.RotorSystem) -> list[Any]:
    """Return what the sums of forces on each body need."""
    hubs = [hub for coupling in system.couplings for hub in (coupling.a, coupling.b)]
    pedestals = [b.support.name for b in system.bearings if isinstance(b.support, gb.Support)]
    return ["gears", "disks", "meshes", "bearings", "housings", *pedestals, *hubs]


def close(system: gb.RotorSystem, one: gb.Response, other: gb.Response) -> None:
    """Require equal motions of bodies and forces of teeth, relative to the RMS that the accuracy of a run refers to.

    A run promises an error of 1e-3 of displacements and 1e-2 of mesh forces; two runs differ by twice as much at most.
    """
    pairs = [
        (read(one, name), read(other, name)) for name in places(system) for read in motions(system)
    ]
    forces = [(r.mesh((m.driver, m.driven)).force for r in (one, other)) for m in system.meshes]
    # the smallest motions of a train carry the error of the largest ones
    scale = max(rms(values) for values, _ in pairs)
    for values, others in pairs:
        assert np.sqrt(np.mean((values - others) ** 2)) < 2e-3 * max(rms(values), 0.1 * scale)
    for values, others in forces:
        assert np.sqrt(np.mean((values - others) ** 2)) < 2e-2 * rms(values)


def motions(system: gb.RotorSystem) -> list[Callable[[gb.Response, str], Any]]:
    if lateral(system):
        return [lambda run, name: run.displacement(name)]
    return [lambda run, name: run.twist(name)]


def rms(values: Any) -> float:
    """RMS about the mean, at least 2 % of the mean."""
    mean = values.mean(axis=0)
    return max(float(np.sqrt(np.mean((values - mean) ** 2))), 0.02 * float(np.abs(mean).max()))


def compute_run(system: gb.RotorSystem, speed: float) -> gb.Response:
    """Run two revolutions of the slowest shaft."""
    return system.simulate(2.0 * turn(system, speed), speed, record=recorded(system))


def check_static(system: gb.RotorSystem, speed: float, static: gb.results.Static) -> None:
    balance = Balance(system, static, speed)
    for body in balance.terms:
        # round-off reaches 1e-14
        assert balance.residual(body) < 1e-6, body
    assert set(balance.terms) >= {shaft.name for shaft in system.shafts}


def check_modes(system: gb.RotorSystem, speed: float, modes: gb.results.Modes) -> None:
    equations = Equations(system, speed)
    assert len(modes.eigenvalues) == COUNT
    # 1e-9 is reached with films, whose eigenvalues range from 1e1 to 1e8; of large trains, only modes of low frequency have modal
    # damping, which leaves 2e-7
    is_partial = system.modal_damping is not None and len(system.dofs) >= 100
    limit = 1e-6 if is_partial else 1e-7
    for value, shape in zip(modes.eigenvalues, modes.shapes, strict=True):
        assert equations.mode_residual(value, shape) < limit, value
    sizes = np.abs(modes.eigenvalues)
    assert np.all(np.diff(sizes) >= -1e-9 * sizes.max())
    # the circle lies in the disk of all modes that are not greater than the last one
    highest = float(sizes.max())
    if highest > 0.0:
        for value in equations.eigenvalues_below(highest):
            # round-off splits the double eigenvalue 0 of the rotation of a train: 1.4e-3 is reached, and √ε times the highest
            # frequency of a model is 3e-2
            near = np.abs(modes.eigenvalues - value).min() < 1e-6 * highest
            assert near or abs(value) < 3e-2, f"{value} is missing"


def check_campbell(system: gb.RotorSystem, _: float, campbell: gb.results.Campbell) -> None:
    assert campbell.eigenvalues.shape == (len(SHARES), COUNT)
    for speed, values in zip(campbell.speeds, campbell.eigenvalues, strict=True):
        equations = Equations(system, speed)
        for value in values:
            assert equations.eigenvalue_residual(value) < 1e-8, (speed, value)
    for crossing in campbell.intersections[:: max(1, len(campbell.intersections) // 3)]:
        rate = 2.0 * pi * crossing.frequency_hz
        # the frequency is that of the excitation, and belongs to an eigenvalue at this speed
        assert rate == pytest.approx(crossing.line.order * crossing.speed, rel=1e-8)
        ratio = crossing.damping_ratio
        value = rate * (1j - ratio / np.sqrt(1.0 - ratio**2))
        assert Equations(system, crossing.speed).eigenvalue_residual(value) < 1e-8, crossing


def check_map(system: gb.RotorSystem, _: float, found: gb.results.CriticalSpeedMap) -> None:
    shafts = chosen(system)
    for stiffness, speeds in zip(found.stiffnesses, found.speeds, strict=True):
        bearings = [
            gb.Bearing(
                each.shaft,
                each.position,
                stiffness=float(stiffness),
                axial_stiffness=each.axial_stiffness,
                support=each.support,
            )
            for each in system.bearings
        ]
        without = system.replace(
            shafts=shafts, bearings=bearings, modal_damping=None, rayleigh=None
        )
        assert len(speeds) == 2
        for speed in speeds:
            equations = Equations(without, speed)
            equations.damping = speed * without.matrices(speed).gyroscopic
            # the elements of the map are finer or coarser: frequencies differ by their error, 1e-4
            assert equations.eigenvalue_residual(1j * speed) < 1e-3, (stiffness, speed)


def check_synchronous(system: gb.RotorSystem, _: float, found: gb.results.Synchronous) -> None:
    excited = False
    for speed, amplitudes in zip(found.speeds, found.amplitudes, strict=True):
        equations = Equations(system, speed)
        for shaft, ratio, given in zip(system.shafts, system.speed_ratios, amplitudes, strict=True):
            spin = ratio * speed
            force = rotating_force(system, shaft, spin)
            if not force.any():
                assert not given.any()
                continue
            excited = True
            scale = equations.scale(spin)
            residual = equations.dynamic_stiffness(1j * spin) @ given - force
            # of large trains, only modes of low frequency have modal damping: responses are known to 1e-5
            is_partial = system.modal_damping is not None and len(system.dofs) >= 100
            # 4e-11 is reached, and 4e-5 with modal damping
            limit = 1e-4 if is_partial else 1e-9
            assert np.linalg.norm(residual / scale) < limit * np.linalg.norm(force / scale)
            difference = scale * (given - equations.response(spin, force))
            # the direct solution loses digits where the train nearly rotates freely: 3e-9 is reached
            limit = 1e-5 if is_partial else 1e-7
            assert np.linalg.norm(difference) < limit * np.linalg.norm(scale * given)
    assert excited


def check_limits(system: gb.RotorSystem, speed: float, found: gb.results.BowLimits) -> None:
    """Require that no given phase of the bow is worse than the worst one."""
    given = system.bow_limits(found.shafts, speed, phase=0.7)
    for worst, one in zip(found.found, given.found, strict=True):
        assert (worst.limit, worst.at) == (one.limit, one.at)
        # The phases and instants meet the worst motion to 1 − cos 5° of the orbits.
        assert one.bow >= (1.0 - 5e-3) * worst.bow


def check_life(system: gb.RotorSystem, speed: float, found: gb.results.BearingLife) -> None:
    """Compare the life with the load, the relative speed of the rings and the static load rating."""
    ratios = dict(zip([s.name for s in system.shafts], system.speed_ratios, strict=True))
    bearings = {(one.shaft, one.position): one for one in system.bearings}
    static = system.static(speed)
    for one in found.bearings:
        base = bearings[one.at].support
        relative = ratios[one.at[0]] - (ratios[base[0]] if isinstance(base, tuple) else 0.0)
        hours = rated_hours(one.equivalent_load, one.dynamic_rating, one.exponent, speed * relative)
        # the printed speed and the sum of both ratios have round-off
        assert one.hours == pytest.approx(hours, rel=1e-9)
        radial = float(np.linalg.norm(static.bearing_force(one.at)))
        assert one.radial_force == pytest.approx(radial, rel=1e-9)
        # P is at least X F_r of a contact of 40° and at most the load of pure thrust, except at light loads of rollers
        if one.method == "ISO 281":
            most = (radial + 2.3 * one.axial_force) * (1.0 + 1e-9)
            assert 0.35 * radial <= one.equivalent_load <= most
        assert one.static_safety <= one.static_rating / radial * (1.0 + 1e-9)


def compute_peaks(
    system: gb.RotorSystem, speed: float
) -> tuple[gb.results.Synchronous, list[gb.results.Peak]]:
    found = system.synchronous(speed * np.linspace(0.3, 1.2, 31))
    shaft = next(s for s in system.shafts if rotating_force(system, s, speed).any())
    return found, found.peaks(bodies_on(system, shaft)[0], operating=speed)


def check_peaks(
    system: gb.RotorSystem,
    speed: float,
    result: tuple[gb.results.Synchronous, list[gb.results.Peak]],
) -> None:
    _, peaks = result
    at = next(i for i, s in enumerate(system.shafts) if rotating_force(system, s, speed).any())
    name = bodies_on(system, system.shafts[at])[0]
    for peak in peaks:
        near = peak.speed * (1.0 + np.array([-1e-4, 0.0, 1e-4]))
        below, amplitude, above = system.synchronous(near).orbit(name)[:, at]
        assert amplitude == pytest.approx(peak.amplitude, rel=1e-6)
        # a search by function values finds a maximum to the root of round-off
        assert amplitude > max(below, above) * (1.0 - 1e-9)
        assert peak.separation_margin == pytest.approx(
            100.0 * abs(peak.speed / speed - 1.0), rel=1e-9
        )
        sides = [side for side in (peak.lower, peak.upper) if np.isfinite(side)]
        for side in sides:
            half = system.synchronous(side).orbit(name)[0, at]
            assert half == pytest.approx(amplitude / np.sqrt(2.0), rel=1e-4)


def compute_balance(system: gb.RotorSystem, speed: float) -> gb.results.Balance:
    planes = bodies_on(system, balanced_shaft(system))[:2]
    return system.balance(planes, speed, points=planes)


def check_balance(system: gb.RotorSystem, speed: float, found: gb.results.Balance) -> None:
    source = [shaft.name for shaft in system.shafts].index(balanced_shaft(system).name)

    def amplitudes(corrected: gb.RotorSystem) -> Any:
        response = corrected.synchronous(speed)
        return np.array([response.displacement(point)[:, source] for point in found.points])

    def moved(plane: str, share: complex) -> gb.RotorSystem:
        parts = {"gears": [*found.system.gears], "disks": [*found.system.disks]}
        step = share * np.abs(found.unbalances).max()
        for kind, given in parts.items():
            parts[kind] = [
                replace(body, unbalance=body.unbalance + step) if body.name == plane else body
                for body in given
            ]
        with warnings.catch_warnings():
            # a correction that bends the shaft against its bow may be larger than a usual unbalance
            warnings.simplefilter("ignore", gb.SceneWarning)
            return found.system.replace(**parts)

    before, after = amplitudes(system), amplitudes(found.system)
    scale = np.linalg.norm(before)
    np.testing.assert_allclose(
        before, found.before.transpose(1, 0, 2), rtol=1e-9, atol=1e-12 * scale
    )
    # the response to the corrected unbalance is that which the influence coefficients predict
    np.testing.assert_allclose(after, found.residual.transpose(1, 0, 2), atol=1e-9 * scale)
    assert found.residual_ratio < 1.0
    for plane in found.planes:
        for share in (0.01, -0.01, 0.01j, -0.01j):
            # a least-squares solution: any other unbalance leaves more
            assert np.linalg.norm(amplitudes(moved(plane, share))) > np.linalg.norm(after)


def check_run(system: gb.RotorSystem, speed: float, run: gb.Response) -> None:
    turn = slice(len(run.time) // 2, -1)
    balance = Balance(system, run, speed, turn)
    for body in balance.terms:
        # the decaying transient changes the momentum of a shaft by up to 1e-3 of its load in this turn
        assert balance.residual(body) < 3e-3, body
    static = system.static(speed=speed)
    mean = {
        (m.driver, m.driven): run.mesh((m.driver, m.driven)).force[turn].mean()
        for m in system.meshes
    }
    forces = {pair: static.mesh(pair).force for pair in mean}
    # Of several paths between two shafts, the bow moves the load from one to another within its turn, which is no whole part
    # of that of the slowest shaft; the sum at the gear that they share keeps.
    is_shared = len(mean) >= len(system.shafts)
    for mesh in system.meshes:
        pair = (mesh.driver, mesh.driven)
        # equal torques, and radii that the bow does not change: 1e-4 is reached; the moment of the friction is up to 1 % of the torque
        limit = 1e-3 if mesh.friction is None and not is_shared else 2e-2
        assert mean[pair] == pytest.approx(forces[pair], rel=limit)
    for side in (0, 1) if is_shared else ():
        for gear in {pair[side] for pair in mean if sum(p[side] == pair[side] for p in mean) > 1}:
            own = [pair for pair in mean if pair[side] == gear]
            assert sum(mean[p] for p in own) == pytest.approx(sum(forces[p] for p in own), rel=1e-3)


def compute_changing(system: gb.RotorSystem, speed: float) -> tuple[gb.Response, gb.Response]:
    """Run at a speed that changes by 1e-9 of it, and at the constant one."""
    time = 0.25 * turn(system, speed)
    ramp = gb.SpeedProfile.ramp(speed, speed * (1.0 + 1e-9), time)
    given = {"record": ["gears", "disks", "meshes"], "output_step": time / 200}
    return system.simulate(time, ramp, **given), system.simulate(time, speed, **given)


def check_changing(system: gb.RotorSystem, _: float, runs: tuple[gb.Response, gb.Response]) -> None:
    close(system, *runs)


def compute_run_up(system: gb.RotorSystem, speed: float) -> gb.Response:
    time = 0.25 * turn(system, speed)
    ramp = gb.SpeedProfile.ramp(0.95 * speed, speed, time)
    return system.simulate(time, ramp, record=["gears", "disks", "energy"])


def check_run_up(_: gb.RotorSystem, speed: float, run: gb.Response) -> None:
    assert run.speeds[0] == pytest.approx(0.95 * speed, rel=1e-12)
    assert np.all(np.diff(run.speeds * np.sign(speed)) > 0.0)
    balance = run.energy_balance()
    terms = [
        balance.torque,
        balance.gravity,
        balance.drive,
        balance.unbalance,
        balance.teeth,
        balance.damping,
    ]
    scale = max(np.ptp(balance.total), *(np.ptp(term) for term in terms))
    # the integration error of displacements at "engineering" is 1e-3
    assert np.abs(balance.residual).max() < 1e-3 * scale


def compute_steady(system: gb.RotorSystem, speed: float) -> gb.SteadyState:
    return system.steady_state(speed, record=recorded(system))


def check_steady(system: gb.RotorSystem, speed: float, steady: gb.SteadyState) -> None:
    run = steady.response
    balance = Balance(system, run, speed)
    for body in balance.terms:
        # the momentum at the end is that of the begin, in a motion without a period nearly; the modes that the accuracy
        # leaves out change the mean forces by up to 1.1e-4, within the promised 1e-3
        assert balance.residual(body) < 2e-4, body
    if steady.method == "quasi-periodic":
        assert steady.period == np.inf
        return
    step = run.time[1] - run.time[0]
    # the end of the period is its begin
    assert run.time[-1] - run.time[0] + step == pytest.approx(steady.period, rel=1e-9)
    count = min(len(run.time), 400)
    again = system.simulate(
        (count - 1) * step,
        speed,
        initial=steady,
        times=steady.period + run.time[:count],
        record=["gears", "disks", "meshes"],
    )
    close(system, again, Part(run, count))


@dataclass(frozen=True)
class Part:
    """The first instants of a run."""

    run: gb.Response
    count: int

    def displacement(self, name: str) -> Any:
        return self.run.displacement(name)[: self.count]

    def twist(self, name: str) -> Any:
        return self.run.twist(name)[: self.count]

    def mesh(self, at: tuple[str, str]) -> Any:
        return SimpleNamespace(force=self.run.mesh(at).force[: self.count])


def compute_branch(system: gb.RotorSystem, speed: float) -> gb.Continuation:
    return system.continuation(
        "speed",
        speed,
        1.01 * speed,
        first_step=1.0,
        max_points=2,
        record=["gears", "disks", "meshes"],
    )


def check_branch(system: gb.RotorSystem, speed: float, branch: gb.Continuation) -> None:
    assert branch.values[0] == pytest.approx(speed, rel=1e-12)
    assert branch.stable.shape == branch.values.shape
    name = places(system)[0]
    # Losses of a free train slow it down, which a tolerance far below that of the motion notices.
    alone = system.steady_state(float(branch.values[-1]), record=[name]).response
    values = alone.displacement(name)[:, 1] if lateral(system) else alone.twist(name)
    # the instants of the samples miss the extremes by 1e-3 of them
    expected = 0.5 * np.ptp(values)
    assert branch.amplitude(name, quantity(system))[-1] == pytest.approx(expected, rel=5e-3)


def compute_sweep(system: gb.RotorSystem, speed: float) -> gb.Sweep:
    return gb.sweep(
        lambda share: system.replace(**varied(system, share)),
        {"share": LOADS},
        lambda other, **_: {"motion": float(np.linalg.norm(other.static(speed=speed).state))},
    )


def check_sweep(system: gb.RotorSystem, speed: float, found: gb.Sweep) -> None:
    others = [system.replace(**varied(system, share)) for share in LOADS]
    alone = [np.linalg.norm(other.static(speed=speed).state) for other in others]
    assert not found.failed
    assert found.to_dataframe()["motion"].tolist() == alone
    assert found.to_xarray()["motion"].values.tolist() == alone
    assert found.to_xarray()["share"].values.tolist() == list(LOADS)


def short_run(system: gb.RotorSystem, speed: float) -> dict[str, Any]:
    """Return the options of a run over a tenth of a revolution of the slowest shaft."""
    record = ["gears", "disks", "meshes"]
    return {"duration": 0.1 * turn(system, speed), "speed": speed, "record": record}


def compute_many(system: gb.RotorSystem, speed: float) -> list[gb.Response]:
    return system.simulate_many(
        [varied(system, share) for share in LOADS], **short_run(system, speed)
    )


def check_many(system: gb.RotorSystem, speed: float, runs: list[gb.Response]) -> None:
    for share, run in zip(LOADS, runs, strict=True):
        alone = system.replace(**varied(system, share)).simulate(**short_run(system, speed))
        close(system, run, alone)


def compute_waterfall(
    system: gb.RotorSystem, speed: float
) -> tuple[list[gb.Response], gb.results.Waterfall]:
    time = 0.5 * turn(system, speed)
    name = places(system)[0]
    runs = [
        system.simulate(time, share * speed, output_step=time / 256, record=[name])
        for share in (1.0, 0.9)
    ]
    return runs, gb.waterfall(runs, name, quantity(system))


def check_waterfall(
    system: gb.RotorSystem, _: float, result: tuple[list[gb.Response], gb.results.Waterfall]
) -> None:
    runs, found = result
    assert np.all(np.diff(found.speeds) > 0.0)
    order = np.argsort([run.speed for run in runs])
    for k, given in zip(order, found.amplitudes, strict=True):
        expected = hann_amplitudes(signal_of(system, runs[k]))
        np.testing.assert_allclose(given, expected, atol=1e-9 * expected.max())


def signal_of(system: gb.RotorSystem, run: gb.Response) -> Any:
    name = places(system)[0]
    return run.displacement(name)[:, 1] if lateral(system) else run.twist(name)


def hann_amplitudes(values: Any) -> Any:
    """Amplitudes of the sines above frequency 0, from a sum with a periodic Hann window."""
    count = len(values)
    at = np.arange(count)
    window = 0.5 - 0.5 * np.cos(2.0 * pi * at / count)
    rest = (values - np.average(values, weights=window)) * window
    lines = np.arange(1, count // 2 + 1)
    sums = np.abs(np.exp(-2j * pi * np.outer(lines, at) / count) @ rest) / window.sum()
    # the line at half the sampling rate has no mirror image
    return sums * np.where(2 * lines == count, 1.0, 2.0)


def compute_orders(system: gb.RotorSystem, speed: float) -> tuple[gb.Response, gb.results.Orders]:
    name = places(system)[0]
    run = system.simulate(2.0 * turn(system, speed), speed, record=[name])
    return run, run.orders(
        name,
        quantity(system),
        shaft_harmonics=1,
        mesh_harmonics=1,
        sidebands=0,
        bearing_harmonics=0,
    )


def check_orders(
    system: gb.RotorSystem, _: float, result: tuple[gb.Response, gb.results.Orders]
) -> None:
    run, found = result
    values = signal_of(system, run)
    phase = np.exp(2j * pi * np.outer(run.time, found.frequencies_hz))
    rest = values - found.mean - (phase @ found.amplitudes).real
    scale = np.abs(values).max()
    assert np.sqrt(np.mean(rest**2)) == pytest.approx(found.rest, rel=1e-6, abs=1e-9 * scale)
    # least squares: the remainder contains nothing of the orders
    assert np.abs(phase.T @ rest).max() < 1e-6 * scale * len(rest)


def sensors_of(system: gb.RotorSystem) -> list[Any]:
    body = next(b for b in (*system.gears, *system.disks) if b.name == places(system)[0])
    return [
        gb.Probe(body.shaft, body.position, angle=0.7, runout=2e-6j),
        gb.Accelerometer((body.shaft, body.position), angle=0.7),
        gb.Tacho(body.shaft, 61),
    ]


def compute_sensors(system: gb.RotorSystem, speed: float) -> gb.Response:
    time = 0.05 * turn(system, speed)
    record = [places(system)[0], "velocity", "acceleration"]
    return system.simulate(time, speed, record=record, output_step=time / 4000)


def check_sensors(system: gb.RotorSystem, _: float, run: gb.Response) -> None:
    probe, accelerometer, tacho = sensors_of(system)
    name = places(system)[0]
    times = tacho.measure(run)
    turns = run.angle(tacho.shaft, times) * 61.0 / (2.0 * pi)
    assert len(times) == int(abs(run.angle(tacho.shaft)[-1]) * 61.0 / (2.0 * pi)) + 1
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    if not lateral(system):
        # a shaft that only twists does not move towards a sensor
        assert not run.displacement(name).any()
        assert not accelerometer.measure(run).any()
        return
    direction = np.array([np.cos(0.7), np.sin(0.7)])
    turned = 0.7 - run.angle(probe.shaft) - run.twist(name)
    surface = run.displacement(name) @ direction + 2e-6 * np.sin(turned)
    np.testing.assert_allclose(probe.measure(run), surface, atol=1e-15)
    # the integral of the acceleration is the change of the velocity
    measured, step = accelerometer.measure(run), run.time[1]
    change = np.cumsum(0.5 * step * (measured[1:] + measured[:-1]))
    velocity = run.velocity(name) @ direction
    # the trapezoidal rule meets frequencies up to a tenth of the sampling rate to 3 %: 1 % is reached
    assert np.abs(change - (velocity[1:] - velocity[0])).max() < 0.03 * np.ptp(velocity)


@dataclass(frozen=True)
class Analysis:
    """How to compute a result, the equations that it has to satisfy, and to which systems it applies.

    `largest` is the number of degrees of freedom above which the cell is slow; `expensive` are smaller machines, at a sense of
    rotation, whose cell is slow too.
    """

    compute: Callable[[gb.RotorSystem, float], Any]
    check: Callable[[gb.RotorSystem, float, Any], None]
    senses: tuple[int, ...] = (1, -1)
    largest: int = 10_000
    applies: Callable[[gb.RotorSystem], bool] = lambda _: True
    expensive: tuple[str, ...] = ()


ANALYSES = {
    "static": Analysis(lambda s, speed: s.static(speed=speed), check_static),
    "life": Analysis(
        lambda s, speed: s.bearing_life(speed),
        check_life,
        applies=lambda s: any(isinstance(one, gb.RollingBearing) for one in s.bearings),
    ),
    "modes": Analysis(
        lambda s, speed: s.modes(speed, count=COUNT, vibrating=internally_damped(s)),
        check_modes,
        largest=1000,
    ),
    # the speeds of a diagram are not negative
    "campbell": Analysis(
        lambda s, speed: s.campbell(SHARES * speed, count=COUNT), check_campbell, (1,), 400
    ),
    "map": Analysis(lambda s, _: s.critical_speed_map(STIFFNESSES, count=2), check_map, (1,), 500),
    "synchronous": Analysis(
        lambda s, speed: without_tooth_errors(s).synchronous(SHARES * speed),
        check_synchronous,
        largest=1000,
        applies=lateral,
    ),
    "limits": Analysis(
        lambda s, speed: s.bow_limits(s.shafts[0].name, speed),
        check_limits,
        largest=350,
        applies=lateral,
    ),
    "peaks": Analysis(compute_peaks, check_peaks, (1,), 350, lateral),
    "balance": Analysis(
        compute_balance,
        check_balance,
        largest=350,
        applies=lambda s: balanced_shaft(s) is not None,
    ),
    "run": Analysis(
        compute_run,
        check_run,
        largest=1000,
        # 7 to 33 s at the negative speed, 3 to 14 s at the positive one, whose run the figures and files have
        expensive=("tapered_reducer -", "gearbox -", "spindle_drive -", "coaxial_reducer -"),
    ),
    "changing": Analysis(compute_changing, check_changing, largest=350),
    "run up": Analysis(compute_run_up, check_run_up, (1,), 350),
    "steady": Analysis(compute_steady, check_steady, largest=350, expensive=("idler_train -",)),
    # the hunting tooth period of the pair takes 40 s
    "branch": Analysis(compute_branch, check_branch, (1,), 150, expensive=("geared_pair +",)),
    "sweep": Analysis(compute_sweep, check_sweep, (1,), 150),
    "many": Analysis(compute_many, check_many, (1,), 350),
    "waterfall": Analysis(compute_waterfall, check_waterfall, (1,), 350),
    "orders": Analysis(compute_orders, check_orders, (1,), 350),
    "sensors": Analysis(compute_sensors, check_sensors, (1, -1), 350),
}
