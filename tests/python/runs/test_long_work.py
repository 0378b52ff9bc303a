"""Long runs and large systems: Ctrl-C, estimates of the run time, dense matrices."""

from __future__ import annotations

import io
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from contextlib import redirect_stderr

import numpy as np
import pytest
from tqdm import tqdm

import gearbow as gb
from gearbow import _progress
from reference.machines import bowed_pair, rotor
from reference.processes import printed

LARGE = """
import signal, sys, threading, time, warnings
from pathlib import Path
import numpy as np
import gearbow as gb

# Background jobs of a shell ignore SIGINT, and child processes inherit this.
signal.signal(signal.SIGINT, signal.default_int_handler)
warnings.simplefilter("ignore", gb.AccuracyWarning)

def large(elements, **options):
    rotor = gb.Shaft(
        "rotor", length=1.0, outer_diameter=0.05, elements=elements, bow=gb.Bow.half_sine(1e-4)
    )
    bearings = [
        gb.Bearing("rotor", x, stiffness=[[1e8, 2e6], [3e6, 7e7]], damping=[[1e4, 1e3], [2e3, 2e4]])
        for x in (0.0, 1.0)
    ]
    disk = gb.Disk("disk", "rotor", 0.5, 10.0, 0.1, 0.2)
    return gb.RotorSystem([rotor], bearings=bearings, disks=[disk], gravity=9.81, **options)

speeds = np.linspace(1.0, 500.0, 5000)
# every second speed has a peak
samples = [(speed, float(index % 2)) for index, speed in enumerate(np.linspace(1.0, 500.0, 50_000).tolist())]
"""

#: Analyses of a large system.
CALLS = {
    "modes": "system.modes(100.0)",
    "campbell": "system.campbell(speeds)",
    "critical_speed_map": "system.critical_speed_map([1e6, 1e7, 1e8])",
    "synchronous": "system.synchronous(speeds)",
    "peaks": "system._model.peaks(samples, 0, 0, 'both', None)",
    "balance": "system.balance(['disk'], speeds)",
    "matrices": "system.matrices()",
    "simulate": "system.simulate(1.0, 100.0)",
    "tradeoff": "system.tradeoff(1.0, 100.0, budget=1e6)",
}

#: Longest response time to Ctrl-C, s. Only a clock shows that a call ended before its work was
#: done. The work takes several times as long, and the response takes 0.3 s on an idle machine.
BOUND = 5.0


@pytest.mark.parametrize("name", list(CALLS))
def test_ctrl_c_ends_every_analysis(name: str):
    program = f"""{LARGE}
system = large(600, modal_damping=0.01)
threading.Timer(1.0, signal.raise_signal, [signal.SIGINT]).start()
begin = time.monotonic()
try:
    {CALLS[name]}
except KeyboardInterrupt:
    print(time.monotonic() - begin - 1.0)
"""
    assert float(printed(program)) < BOUND


def test_ctrl_c_ends_the_loops_over_speeds():
    # each mode solution is fast; the number of speeds makes the call long
    program = f"""{LARGE}
system = large(20)
speeds = np.linspace(1.0, 500.0, 2_000_000)
for call in (system.synchronous, lambda _: system._model.peaks(samples, 0, 0, "both", None)):
    threading.Timer(1.0, signal.raise_signal, [signal.SIGINT]).start()
    begin = time.monotonic()
    try:
        call(speeds)
    except KeyboardInterrupt:
        print(time.monotonic() - begin - 1.0)
print([path.parent.name for path in Path("/proc/self/task").glob("*/comm")
       if path.read_text() == "gearbow\\n"])
"""
    if sys.platform != "linux":
        pytest.skip("lists the threads of a process as Linux does")
    *times, threads = printed(program).splitlines()
    assert len(times) == 2
    assert all(float(time) < BOUND for time in times)
    assert threads == "[]"  # the work has ended and does not continue in the background


def test_a_system_is_usable_after_an_interrupt():
    program = f"""{LARGE}
system = large(40)
expected = large(40).modes(100.0).eigenvalues
interrupted = 0
for delay in (0.0, 0.1):
    try:
        threading.Timer(delay, signal.raise_signal, [signal.SIGINT]).start()
        system.modes(100.0)
        time.sleep(10.0)
    except KeyboardInterrupt:
        interrupted += 1
assert interrupted == 2
assert np.array_equal(system.modes(100.0).eigenvalues, expected)
"""
    printed(program)


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of the address space is Linux's")
def test_matrices_that_do_not_fit_are_an_error():
    # 9,000 elements: 2.6 GB of memory are available, the matrices need 62 GB. Band matrices are
    # enough for the response and for the few modes of a Campbell diagram.
    banded = ("campbell", "synchronous", "peaks", "balance")
    refused = {name: call for name, call in CALLS.items() if name not in banded}
    calls = "\n".join(f"check({name!r}, lambda: {call})" for name, call in refused.items())
    program = f"""{LARGE}
import resource
system = large(9000, modal_damping=0.01)
resource.setrlimit(resource.RLIMIT_AS, (3_000_000_000, resource.RLIM_INFINITY))

def check(name, call):
    try:
        call()
    except gb.GearbowError as error:
        text = str(error)
        assert "36004 degrees of freedom need" in text, (name, text)
        # all modes need their shapes as well as the matrices
        remedy = "ask for fewer modes" if name == "modes" else "use fewer elements"
        assert f"GB are available; {{remedy}}" in text, (name, text)
        print(name, type(error).__name__)

{calls}
"""
    lines = printed(program).splitlines()
    assert [line.split()[0] for line in lines] == list(refused)


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of the address space is Linux's")
def test_results_that_do_not_fit_are_an_error_before_the_computation():
    # Each result needs 8 GB and more; a computation would take minutes.
    calls = {
        "synchronous": "system.synchronous(speeds)",
        "balance": "system.balance(['disk'], speeds)",
        "balance (influence)": "system.balance(['disk'], speeds[:100_000])",
        "campbell": "system.campbell(speeds, count=20)",
        "critical_speed_map": "system.critical_speed_map(speeds)",
        "simulate": "system.simulate(1.0, 100.0, output_step=1e-6, record=['nodes', 'velocity'])",
        "steady_state": "system.steady_state(100.0, output_step=1e-8, record=['nodes'])",
        "simulate_many": "system.simulate_many([{}] * 2000, 1.0, 100.0, output_step=1e-4, record=['nodes'])",
        "sweep": "large_sweep()",
    }
    checks = "\n".join(f"check({name!r}, lambda: {call})" for name, call in calls.items())
    program = f"""{LARGE}
import resource
system = large(100)
speeds = np.linspace(1.0, 500.0, 3_000_000)

def large_sweep():
    # One value whose array would take 8 GB, as the broadcast of one number
    value = np.broadcast_to(0.0, (10_000, 100_000))
    from gearbow.sweeps.points import Outcome
    from gearbow.sweeps.result import column
    return column("value", {{0: Outcome({{"value": value}})}}, 1)

resource.setrlimit(resource.RLIMIT_AS, (3_000_000_000, resource.RLIM_INFINITY))

def check(name, call):
    try:
        call()
    except gb.GearbowError as error:
        text = str(error)
        assert "GB of memory, " in text and "GB are available; " in text, (name, text)
        print(name)

{checks}
"""
    assert printed(program).splitlines() == list(calls)


def test_arrays_adopt_what_the_core_computed():
    # A conversion row by row would stop the other threads of Python.
    model = rotor({"elements": 2})._model
    response, modes = model.synchronous(np.array([100.0]), "both", 1), model.modes(0.0)
    arrays = [response["phasors"], response["bearing_force"], modes["shapes"]]
    arrays += [modes["kinetic_shares"], model.matrices(0.0)["mass"]]
    assert {type(array.base).__name__ for array in arrays} == {"PySliceContainer"}


@pytest.mark.parametrize("damping", [0.0, 0.01])
def test_the_response_of_a_large_system_needs_no_dense_matrix(damping: float):
    program = f"""{LARGE}
system = large(1500, modal_damping={damping})
response = system.synchronous([10.0, 500.0]).amplitudes
coarse = large(100, modal_damping={damping})
wanted = coarse.synchronous([10.0, 500.0]).amplitudes
assert response.shape == (2, 1, 6004)
# deflection v in the middle of the shaft; elements are exact in statics
assert np.allclose(response[:, 0, 3000], wanted[:, 0, 200], rtol=1e-4)
found, wanted = (each.static().displacement(("rotor", 0.5)) for each in (system, coarse))
assert np.allclose(found, wanted, rtol=1e-4)
"""
    printed(program)


class TestEstimate:
    """The run time is estimated once, from the first second."""

    @pytest.fixture
    def clock(self, monkeypatch):
        class Clock:
            now = 100.0

            def perf_counter(self) -> float:
                return self.now

        clock = Clock()
        monkeypatch.setattr(_progress, "time", clock)
        return clock

    @staticmethod
    def report(clock, fractions, progress=None):
        with (
            warnings.catch_warnings(record=True) as caught,
            _progress.reported(progress, 1.0, what="run") as report,
        ):
            warnings.simplefilter("always")
            for seconds, fraction in fractions:
                clock.now = 100.0 + seconds
                report(fraction)
        return [str(warning.message) for warning in caught]

    def test_a_run_of_more_than_an_hour_gives_one_warning(self, clock):
        (text,) = self.report(
            clock, [(0.0, 0.0), (0.9, 1e-4), (1.0, 1e-4), (1.1, 1e-5), (2.0, 2e-4)]
        )
        assert text.startswith("simulate: takes about 2.78 h at the rate of the first 1 s")

    def test_a_shorter_run_gives_no_warning(self, clock):
        assert self.report(clock, [(0.0, 0.0), (1.0, 1.0 / 3600.0), (2.0, 1e-9)]) == []

    def test_earlier_work_does_not_count(self, clock):
        assert self.report(clock, [(0.0, 0.5), (1.0, 0.5), (1.1, 0.5 + 1e-3)]) == []
        (text,) = self.report(clock, [(0.0, 0.5), (1.0, 0.5), (1.5, 0.5 + 1e-4)])
        assert "2.08 h" in text

    def test_a_progress_callback_is_called_too(self, clock):
        seen: list[float] = []
        assert len(self.report(clock, [(0.0, 0.0), (1.0, 1e-9)], seen.append)) == 1
        assert seen == [0.0, 1e-9]

    def test_other_analyses_are_not_estimated(self):
        with _progress.reported(None, 100.0, "%", what="run", estimate=False) as report:
            assert report is None

    def test_the_bar_shows_the_remaining_time_at_the_first_report(self, monkeypatch):
        monkeypatch.setattr(_progress, "_RENEWAL", 0.01)
        with (
            redirect_stderr(io.StringIO()) as text,
            _progress.reported(True, 1e6, what="run") as report,
        ):
            for bar in tqdm._instances:
                # as if the first report came half a second after the start
                bar.start_t -= 0.5
                bar.last_print_t -= 0.5
            start = text.getvalue()
            report(1e-9)
            end = time.monotonic() + 10.0
            while text.getvalue() == start and time.monotonic() < end:
                time.sleep(0.01)
            shown = text.getvalue()
        assert "?" not in shown.rsplit("\r", 1)[-1]
        assert "/1e+06 s" in shown

    def test_a_report_does_not_draw(self):
        # an interrupt during a drawing would leave its lock taken, and the program would never end
        held, over = threading.Event(), threading.Event()

        def hold() -> None:
            with tqdm.get_lock():
                held.set()
                over.wait(10.0)

        with redirect_stderr(io.StringIO()), _progress.reported(True, 1.0, what="run") as report:
            holder = threading.Thread(target=hold)
            holder.start()
            assert held.wait(10.0)
            for bar in tqdm._instances:
                bar.last_print_t -= 0.5  # as if the last drawing were half a second ago
            reporter = threading.Thread(target=report, args=(0.5,))
            reporter.start()
            reporter.join(2.0)
            is_waiting = reporter.is_alive()
            over.set()
            holder.join()
        assert not is_waiting

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    @pytest.fixture
    def terminal(self, monkeypatch):
        monkeypatch.setattr(_progress, "_DELAY", 0.0)
        # pytest replaces the streams after the set-up of a test
        return lambda: redirect_stderr(self.Terminal())

    def test_every_long_analysis_shows_on_a_terminal_what_it_does(self, terminal):
        system, speeds = bowed_pair(), [50.0, 100.0]
        calls = {
            "equilibrium": system.static,
            "modes": system.modes,
            "Campbell diagram of 2 speeds": lambda **how: system.campbell(speeds, **how),
            "critical speeds at 2 stiff": lambda **how: system.critical_speed_map(
                [1e7, 1e8], **how
            ),
            "synchronous response at 2 speeds": lambda **how: system.synchronous(speeds, **how),
            "balancing": lambda **how: system.balance("g1", 100.0, **how),
            "simulate: modes, pilot runs": lambda **how: system.simulate(1e-3, 100.0, **how),
            "steady state: modes, pilot runs": lambda **how: system.steady_state(100.0, **how),
        }
        for name, call in calls.items():
            with terminal() as text:
                call(progress=False)
            assert text.getvalue() == ""
            with redirect_stderr(io.StringIO()) as text:  # a file
                call()
            assert text.getvalue() == ""
            with terminal() as text:
                call()
            shown = text.getvalue()
            assert name in shown
            # it disappears at the end, and the calls within show nothing of their own
            assert shown.endswith("\r")
        assert not _progress._decided

    def test_the_runs_of_a_sweep_and_of_threads_show_nothing(self, terminal):
        system = bowed_pair()

        def measure(_: object, speed: float) -> float:
            return system.simulate(1e-3, speed, output_step=1e-3).time[-1]

        with terminal() as text:
            gb.sweep(lambda speed: speed, {"speed": [90.0, 100.0]}, measure)
        assert "2 points" in text.getvalue()
        assert "simulate" not in text.getvalue()
        with terminal() as text, ThreadPoolExecutor(1) as pool:
            pool.submit(system.modes, 100.0).result()
        assert text.getvalue() == ""

    def test_a_log_contains_no_bar(self, monkeypatch):
        monkeypatch.setattr(_progress, "_DELAY", 0.0)
        with redirect_stderr(io.StringIO()) as text:
            bowed_pair().simulate(1e-3, 100.0)
            bowed_pair().modes(100.0)
        assert text.getvalue() == ""

    def test_the_time_goes_on_without_a_report(self, terminal, monkeypatch):
        monkeypatch.setattr(_progress, "_RENEWAL", 1e-3)
        asked = threading.Event()
        with terminal(), _progress.working(None, "work"):
            bar = next(iter(tqdm._instances))
            bar.mininterval = 0.0
            monkeypatch.setattr(bar, "refresh", lambda **_: asked.set())
            assert asked.wait(10.0)

    def test_a_warning_as_an_error_ends_the_run_with_its_results(self, monkeypatch):
        monkeypatch.setattr(_progress, "WATCHED", 0.0)
        monkeypatch.setattr(_progress, "LONG_RUN", 0.0)
        with warnings.catch_warnings():
            warnings.simplefilter("error", gb.AccuracyWarning)
            with pytest.raises(gb.AccuracyWarning, match="reduce the duration") as caught:
                bowed_pair().simulate(1e4, 100.0, output_step=0.1)
        assert 0 < caught.value.response.time.size < 100_001

    def test_the_warning_points_at_the_line_of_the_caller(self, monkeypatch):
        monkeypatch.setattr(_progress, "WATCHED", 0.0)
        monkeypatch.setattr(_progress, "LONG_RUN", 0.0)

        def stop(fraction: float) -> None:
            if fraction > 0.0 and caught:
                raise KeyboardInterrupt

        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            with pytest.raises(KeyboardInterrupt):
                bowed_pair().simulate(1e4, 100.0, output_step=0.1, progress=stop)
        assert [(warning.category, warning.filename) for warning in caught] == [
            (gb.AccuracyWarning, __file__)
        ]


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of the address space is Linux's")
def test_used_address_space_is_not_available():
    # 1.5 GB are left below the limit, of which results may fill all but a reserve of 64 MiB.
    program = """
import resource
import gearbow as gb
from gearbow import _core

used = next(int(line.split()[1]) << 10 for line in open("/proc/self/status") if "VmSize" in line)
limit = used + 1_500_000_000
resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
_core.require_memory("speeds", "amplitudes", 1.4e9, "give fewer speeds")
try:
    _core.require_memory("speeds", "amplitudes", 1.6e9, "give fewer speeds")
except gb.SceneError as error:
    print(error)
"""
    found = printed(program)
    assert "amplitudes need 1.600 GB" in found
    # What Python allocates in between is below 10 MB.
    available = float(found.split("memory, ")[1].split(" GB")[0])
    assert available == pytest.approx(1.5 - 64 * 2**20 / 1e9, abs=0.01)
