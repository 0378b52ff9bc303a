"""Parallel calls of a function, a stop of running calls, and the number of threads of an analysis.

Python delivers Ctrl-C to the main thread only. The compiled core therefore asks in every thread, at
the begin of an analysis and every 50 ms, whether the call must stop (`check_stop`).
"""

import os
import queue
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import cache
from itertools import islice
from types import TracebackType
from typing import TYPE_CHECKING, Any

from gearbow._convert import shown, whole
from gearbow.errors import GearbowError, SceneError

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future

#: Largest number of calls that are submitted and not finished: enough to keep a cluster busy, and
#: little memory.
PENDING = 1000
#: Time that running calls have to end after a request to stop [s]. An analysis needs 0.3 s.
GRACE = 1.0
#: Time between two questions whether a call that waits for its own calls must stop [s].
HEARTBEAT = 0.05

#: Identifiers of the groups of calls that must stop.
_stopped: set[str] = set()
#: Data of the current thread: `groups` are the identifiers of the group of its call, and of the
#: groups of the calls within which this group was made.
_current = threading.local()


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def thread_count(threads: int | None) -> int:
    """Return the number of threads of an analysis; None stands for the limit of the environment."""
    given = os.environ.get("GEARBOW_THREADS", "").strip()
    if threads is not None:
        limit = whole(threads, "threads")
    elif given:
        # The environment holds texts.
        if not (given.isascii() and given.isdecimal() and int(given) > 0):
            raise SceneError(
                f"GEARBOW_THREADS: must be a whole number of at least 1, got {shown(given)}; unset "
                "the environment variable to use all cores"
            )
        limit = int(given)
    else:
        limit = cores()
    processes = sys.modules.get("multiprocessing.process")
    is_worker = processes is not None and processes.parent_process() is not None
    # The calls of a sweep and of worker processes share the cores.
    return 1 if _groups() or is_worker else min(limit, cores())


def _groups() -> tuple[str, ...]:
    """Give the groups of the call in this thread."""
    return getattr(_current, "groups", ())


def check_stop() -> None:
    """Raise `KeyboardInterrupt` in a call whose group, or that of a call around it, must stop."""
    if not _stopped.isdisjoint(_groups()):
        raise KeyboardInterrupt


def _call(groups: tuple[str, ...], function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """Call a function as part of groups. It is at module level so that processes can import it."""
    _end_with_parent()
    before = _groups()
    _current.groups = groups
    try:
        check_stop()
        return function(*arguments)
    finally:
        _current.groups = before


@cache
def _end_with_parent() -> None:
    """End this process when the process that started it ends, also if that was killed."""
    import multiprocessing  # noqa: PLC0415

    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def end() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end, name="gearbow-parent", daemon=True).start()


class ParallelCalls:
    """Calls of one function with many arguments, in the order of their completion."""

    def __init__(
        self,
        function: Callable[..., Any],
        arguments: Iterable[tuple[Any, ...]],
        executor: "Executor | None" = None,
    ) -> None:
        is_one = callable(getattr(executor, "submit", None)) and not isinstance(executor, type)
        if executor is not None and not is_one:
            raise SceneError(
                "executor: must be an executor of concurrent.futures, or None for threads, got "
                f"{shown(executor)}"
            )
        self._function = function
        self._waiting = enumerate(arguments)
        self._own = executor is None
        from concurrent.futures import ThreadPoolExecutor  # noqa: PLC0415  # parallel calls only

        self._executor = ThreadPoolExecutor(cores(), "gearbow") if executor is None else executor
        self._group = os.urandom(16).hex()
        self._pending: dict[Future[Any], int] = {}
        self._done: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()

    def __enter__(self) -> "ParallelCalls":
        return self

    def __iter__(self) -> Iterator[tuple[int, "Future[Any]"]]:
        self._submit()
        while self._pending:
            try:
                future = self._done.get(timeout=HEARTBEAT)
            except queue.Empty:
                check_stop()
                continue
            yield self._pending[future], future
            # Only after the caller has taken it: an exception before that must not lose it.
            del self._pending[future]
            self._submit()

    def _submit(self) -> None:
        for number, arguments in islice(self._waiting, PENDING - len(self._pending)):
            future = self._submitted(arguments)
            self._pending[future] = number
            future.add_done_callback(self._done.put)

    def _submitted(self, arguments: tuple[Any, ...]) -> "Future[Any]":
        """Submit one call."""
        try:
            return self._executor.submit(
                _call, (*_groups(), self._group), self._function, arguments
            )
        except Exception as error:
            raise GearbowError(
                f"executor: does not accept calls: {str(error) or type(error).__name__}; give an "
                "executor that is open and whose workers run"
            ) from error

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        _stopped.add(self._group)
        for future in list(self._pending):
            future.cancel()
        running = [future for future in self._pending if not future.cancelled()]
        # Calls that do not end in time continue in the background.
        from concurrent.futures import wait  # noqa: PLC0415  # parallel calls only

        ended = not wait(running, timeout=GRACE).not_done
        if self._own:
            self._executor.shutdown(wait=ended, cancel_futures=True)
        if ended:
            _stopped.discard(self._group)

    def collect(
        self, keep: Callable[[int, "Future[Any]"], None], report: Callable[[], object]
    ) -> None:
        """Keep every call that ends, after an exception also those that returned meanwhile."""
        try:
            with self:
                for number, future in self:
                    keep(number, future)
                    report()
        except BaseException:
            with suppress(OSError):  # the exception may be that of a full disk
                for future, number in self._pending.items():
                    if future.done() and not future.cancelled() and future.exception() is None:
                        keep(number, future)
            raise
