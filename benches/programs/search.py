"""Find the cheapest setting of a method that meets the required error of a scene."""

import time
from dataclasses import dataclass, replace

import numpy as np

from programs.methods import CHECK, REFERENCE, Method, TooSlow
from programs.scenes import Array, Scene
from programs.timing import timed

PATIENCE = 8.0  # limit of the CPU time of a run, s


@dataclass(frozen=True)
class Found:
    """A setting of a method, its error, and a first measure of its cost."""

    method: Method
    duration: float  # simulated time, s
    setting: dict[str, float]
    error: float | None  # None: no run ended within the limit
    cost: float  # CPU time per simulated second
    start: float | None = None  # CPU time before the first step, s


def error_of(found: Array, exact: Array) -> float:
    """Return the error over the times of `found`, which may end earlier than those of `exact`."""
    exact = exact[:, : found.shape[1]]
    motion = np.sqrt(np.mean((exact - exact.mean(axis=1, keepdims=True)) ** 2, axis=(1, 2)))
    return float(np.max(np.sqrt(np.mean((found - exact) ** 2, axis=(1, 2))) / motion))


def reference(scene: Scene) -> Array:
    """Return the reference of a scene."""
    return REFERENCE.prepare(scene)(scene.duration, REFERENCE.settings[0], np.inf)()


def check(scene: Scene, exact: Array) -> float:
    """Return the difference of the reference from an independent solution."""
    found = CHECK.prepare(scene)(scene.stretch / 2, CHECK.settings[0], np.inf)()
    return error_of(found, exact)


def search(scene: Scene, method: Method, exact: Array, patience: float) -> Found:
    """Find the cheapest setting that meets the required error."""
    duration = scene.stretch if method.short else scene.duration
    prepare = method.prepare(scene)
    best: Found | None = None
    for setting in method.settings:
        begun = time.process_time()
        try:
            found = prepare(duration, setting, patience)()
        except TooSlow as slow:
            cost = (time.process_time() - begun) / slow.done
            return best or Found(method, duration, setting, None, cost)
        spent = time.process_time() - begun
        error = error_of(found, exact[:, :: every(scene, setting)])
        if best is None or best.error is None or error < best.error:
            best = Found(method, duration, setting, error, spent / duration)
        if error <= scene.error or 2.0 * spent > patience:
            break
    if best is None:
        message = f"{method.title} has no settings"
        raise ValueError(message)
    return best


def measure(scene: Scene, row: Found) -> Found:
    """Measure the CPU time per simulated second, and that of the set-up before the first step."""
    prepare, duration = row.method.prepare(scene), row.duration
    first = prepare(2 * every(scene, row.setting) * scene.sample, row.setting, np.inf)
    timed(lambda: first)  # the first call fills caches
    start = timed(lambda: first)[1]
    whole = prepare(duration, row.setting, np.inf)
    cost = timed(lambda: whole)[1]
    if cost <= 3.0 * start:
        # A run that takes hardly longer than its set-up is timed over a longer duration.
        duration *= 10.0
        longer = prepare(duration, row.setting, np.inf)
        cost = timed(lambda: longer)[1]
    return replace(row, cost=(cost - start) / duration, start=start)


def every(scene: Scene, setting: dict[str, float]) -> int:
    """Return the number of samples per step, at least one."""
    return max(1, round(setting.get("step", 0.0) / scene.sample))
