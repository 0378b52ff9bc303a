"""Peak memory of analyses of large systems and of runs, each in a process of its own."""

import multiprocessing
import resource
import signal
import time
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

import gearbow as gb
from programs.scenes import MEAN, SPEED, STAGES, TRAIN, geared

ELEMENTS = 3000  # of each of the three shafts
LIMIT = 30  # limit of the CPU time of an analysis, s


def run(duration: float) -> Callable[[gb.RotorSystem], Any]:
    """Return a run that records a gear at its start and at its end."""
    return lambda system: system.simulate(duration, SPEED, times=[0.0, duration], record=["g1"])


#: Number of elements of each shaft, and the work.
RUNS: dict[str, tuple[int, Callable[[gb.RotorSystem], Any]]] = {
    "`simulate`, 0.1 s, n = 240": (15, run(0.1)),
    "`simulate`, 10 s, n = 240": (15, run(10.0)),
    "`simulate`, 1 ms, n = 1,200": (79, run(1e-3)),
    "`simulate`, 1 ms, n = 4,800": (319, run(1e-3)),
}
WORKS: dict[str, Callable[[gb.RotorSystem], Any]] = {
    "description of the system only": lambda system: system.dofs,
    "`modes(count=10)`": lambda system: system.modes(SPEED, count=10),
    "`synchronous`, 10 speeds": lambda system: system.synchronous(np.linspace(1.0, 300.0, 10)),
    "`static`": lambda system: system.static(),
    "`campbell`, 20 speeds": lambda system: system.campbell(np.linspace(0.0, 300.0, 20)),
    "`simulate`, 1 ms": lambda system: system.simulate(1e-3, SPEED),
    "`matrices`": lambda system: system.matrices(SPEED),
}


def peak(title: str) -> tuple[str, str]:
    """Return the peak memory [MB] of a process, Python included, and its CPU time [s]."""
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(title, sender))
    process.start()
    sender.close()
    try:
        found: tuple[str, str] = receiver.recv()
    except EOFError:
        found = ("ended by the system", "")
    process.join()
    if process.exitcode == -signal.SIGXCPU:
        return "", f"> {LIMIT}"
    return found


def _work(title: str, sender: Connection) -> None:
    """Analyse, and send the peak memory and the CPU time."""
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT + 1))
    warnings.simplefilter("ignore", gb.AccuracyWarning)
    begin = time.process_time()
    elements, work = RUNS[title] if title in RUNS else (ELEMENTS, WORKS[title])
    try:
        work(geared(TRAIN, STAGES, MEAN, 0.05, elements=elements))
    except gb.SceneError as error:
        memory = "refused: " + str(error).partition(";")[0]
    else:
        memory = f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f}"
    sender.send((memory, f"{time.process_time() - begin:.2f}"))
