"""CPU times of functions: repeated in alternating rounds, or once in a process of its own."""

import multiprocessing
import os
import resource
import signal
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Generic, TypeAlias, TypeVar

T = TypeVar("T")
#: Work that can be repeated.
Run: TypeAlias = Callable[[], T]

ROUNDS = 5
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
LEAST = 0.1  # shortest CPU time that is measured; shorter work is repeated, s


@dataclass(frozen=True)
class Cost:
    """CPU time of all threads, and wall time [s]."""

    cpu: float
    wall: float


@dataclass(frozen=True)
class Outcome(Generic[T]):
    """What a run in a process of its own returned, its CPU time [s], or why it has no result."""

    value: T | None
    cost: float
    reason: str = ""


def one_thread() -> None:
    """Restart the script with one thread for each library, unless it runs so."""
    if any(os.environ.get(name) != "1" for name in THREADS):
        # Libraries read these variables when they are loaded.
        os.environ.update(dict.fromkeys(THREADS, "1"))
        os.execv(sys.executable, [sys.executable, *sys.argv])


def timed(prepare: Callable[[], Run[T]]) -> tuple[T, float]:
    """Return the result and the mean CPU time of a run [s], without the time of `prepare`."""
    found, cost = measured(prepare)
    return found, cost.cpu


def measured(prepare: Callable[[], Run[T]]) -> tuple[T, Cost]:
    """Return the result and the mean cost of a run, without that of `prepare`."""
    cpu, wall, count = 0.0, 0.0, 0
    while True:
        run = prepare()
        begin, clock = time.process_time(), time.perf_counter()
        found = run()
        cpu += time.process_time() - begin
        wall += time.perf_counter() - clock
        count += 1
        if cpu > LEAST:
            return found, Cost(cpu / count, wall / count)


def in_rounds(works: Mapping[str, Callable[[], T]], rounds: int) -> dict[str, list[T]]:
    """Measure all works in turn, in several rounds: drifts of the processor speed affect all."""
    costs: dict[str, list[T]] = {name: [] for name in works}
    for _ in range(rounds):
        for name, work in works.items():
            costs[name].append(work())
    return costs


def median_ratio(costs: list[float], units: list[float]) -> float:
    """Return the median of the ratios within the rounds."""
    return statistics.median(a / b for a, b in zip(costs, units, strict=True))


def once(prepare: Callable[[], Run[Any]], limit: float) -> Outcome[Any]:
    """Run in a forked process that ends when its CPU time exceeds `limit` [s]."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(prepare, limit, sender))
    process.start()
    sender.close()
    try:
        outcome: Outcome[Any] = receiver.recv()
    except EOFError:
        outcome = Outcome(None, limit, "ended by the system")
    process.join()
    if process.exitcode == -signal.SIGXCPU:
        return Outcome(None, limit, f"> {limit:g} s")
    return outcome


def _work(prepare: Callable[[], Run[Any]], limit: float, sender: Connection) -> None:
    """Run, and send the outcome."""
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 1))
    run = prepare()
    begin = time.process_time()
    try:
        value = run()
    except Exception as error:  # noqa: BLE001  # the table shows why a program has no result
        # One line that fits into a cell of a table.
        reason = str(error).partition("\n")[0].partition(";")[0].replace("|", "/")
        sender.send(Outcome(None, time.process_time() - begin, f"{type(error).__name__}: {reason}"))
    else:
        sender.send(Outcome(value, time.process_time() - begin))
