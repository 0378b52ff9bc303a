"""CPU times of functions: repeated in alternating rounds, or once in a process of its own."""

import multiprocessing
import resource
import signal
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Generic, TypeAlias, TypeVar

T = TypeVar("T")
#: Work that can be repeated.
Run: TypeAlias = Callable[[], T]

ROUNDS = 5
LEAST = 0.1  # shortest CPU time that is measured; shorter work is repeated, s


@dataclass(frozen=True)
class Outcome(Generic[T]):
    """What a run in a process of its own returned, its CPU time [s], or why it has no result."""

    value: T | None
    cost: float
    reason: str = ""


def timed(prepare: Callable[[], Run[T]]) -> tuple[T, float]:
    """Return the result and the mean CPU time of a run [s], without the time of `prepare`."""
    spent, count = 0.0, 0
    while True:
        run = prepare()
        begin = time.process_time()
        found = run()
        spent += time.process_time() - begin
        count += 1
        if spent > LEAST:
            return found, spent / count


def in_rounds(works: Mapping[str, Callable[[], float]], rounds: int) -> dict[str, list[float]]:
    """Measure all works in turn, in several rounds: drifts of the processor speed affect all."""
    costs: dict[str, list[float]] = {name: [] for name in works}
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
