"""Branches of fixed points of a map over a parameter: pseudo-arclength continuation.

The method of H. B. Keller (*Numerical solution of bifurcation and nonlinear eigenvalue problems*,
in Applications of Bifurcation Theory, Academic Press 1977) follows a branch x(s), λ(s) by its
length s, so that it passes folds. The Jacobian is dense and taken from differences at each point.
It is the matrix of the corrector, its eigenvalues are the multipliers, and its null vector is the
tangent.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from gearbow._types import Array, ComplexArray
from gearbow.errors import ConvergenceError, GearbowError

__all__ = ["BranchPoint", "Map", "Settings", "branch", "critical"]

#: Difference of states for the Jacobian, relative to the size of the state: the central difference
#: has an error of its square, and the rounding error of the map divided by it.
_DIFFERENCE = 1e-5
#: Difference of the parameter for the tangent, relative to the interval.
_PARAMETER = 1e-6
#: Number of corrections of one point, and that at which the steps keep their length.
_CORRECTIONS = 12
_USUAL = 7
#: Largest angle between two tangents [cos].
_TURN = 0.9
#: Relative accuracy of a located point.
_LOCATED = 1e-8
_LOCATIONS = 40


class Map(Protocol):
    """A map of states over a parameter."""

    def images(self, states: Array, value: float) -> Array:
        """Give the images of states at one value of the parameter.

        Parameters
        ----------
        states : ndarray, shape (k, n)
            States.
        value : float
            The parameter.

        Returns
        -------
        ndarray, shape (k, n)
            Their images, by the same steps.
        """

    def observed(self, state: Array, value: float) -> tuple[Any, float]:
        """Observe a fixed point.

        Parameters
        ----------
        state : ndarray, shape (n,)
            The fixed point.
        value : float
            The parameter.

        Returns
        -------
        kept : object
            What to keep of it.
        margin : float
            Distance from the first contact loss.
        """


@dataclass(frozen=True)
class Settings:
    """Settings of a branch.

    Parameters
    ----------
    start, stop : float
        Interval of the parameter.
    step : float
        First step over the interval.
    max_points : int
        Largest number of points.
    tolerance : float
        Largest |P(x) − x| over |x|.
    floor : float
        Smallest |x| that differences and tolerances are relative to.
    largest, smallest : float
        Largest and smallest step along the branch.
    """

    start: float
    stop: float
    step: float = 0.02
    max_points: int = 400
    tolerance: float = 1e-8
    floor: float = 1e-300
    largest: float = 0.05
    smallest: float = 1e-6

    @property
    def span(self) -> float:
        """Length of the interval.

        Returns
        -------
        float
            |stop − start|.
        """
        return abs(self.stop - self.start)


@dataclass
class BranchPoint:
    """A fixed point with its derivative.

    Parameters
    ----------
    state : ndarray, shape (n,)
        The fixed point.
    value : float
        The parameter.
    jacobian : ndarray, shape (n, n)
        Derivative of the map.
    slope : ndarray, shape (n,)
        Derivative of the map with respect to the parameter, times the interval.
    scale : float
        Size of the states.
    tangent : ndarray, shape (n + 1,)
        Unit tangent of the branch over states / scale and parameter / interval.
    margin : float
        Distance from the first contact loss.
    kept : object
        What the map keeps of the point.
    kind : str
        "" or "fold", "flip", "contact loss" for a located point.
    """

    state: Array
    value: float
    jacobian: Array
    slope: Array
    scale: float
    tangent: Array = field(default_factory=lambda: np.zeros(0))
    margin: float = np.inf
    kept: Any = None
    kind: str = ""

    @property
    def multipliers(self) -> ComplexArray:
        """List the eigenvalues of the derivative.

        Returns
        -------
        ndarray, shape (n,)
            The largest first.
        """
        values: ComplexArray = np.linalg.eigvals(self.jacobian).astype(complex)
        return values[np.argsort(-np.abs(values))]

    @property
    def flip(self) -> float:
        """Give a function that changes its sign where a multiplier passes −1.

        Returns
        -------
        float
            Determinant of the derivative plus the identity, as the n-th root of its magnitude.
        """
        sign, logarithm = np.linalg.slogdet(self.jacobian + np.eye(self.state.size))
        return float(sign * np.exp(logarithm / self.state.size))


def branch(map_: Map, state: Array, settings: Settings) -> Iterator[BranchPoint]:
    """Follow a branch until the parameter leaves the interval.

    Parameters
    ----------
    map_ : Map
        The map.
    state : ndarray, shape (n,)
        A state near the fixed point at the start.
    settings : Settings
        Interval, steps and tolerances.

    Yields
    ------
    BranchPoint
        The points in their order along the branch, with the located ones between them.

    Raises
    ------
    ConvergenceError
        If no step is short enough; all points so far are given before.
    """
    follower = _Follower(map_, settings)
    last = follower.first(state)
    yield last
    step = settings.step
    low, high = sorted((settings.start, settings.stop))
    for _ in range(settings.max_points):
        found, step = follower.advance(last, step)
        ends = not low <= found.value <= high
        if ends:
            found = follower.ended(last, found, low if found.value < low else high)
        for name in ("fold", "flip", "contact loss"):
            if critical(last, name) * critical(found, name) < 0.0:
                yield follower.located(last, found, name)
        yield found
        if ends:
            return
        last = found


def critical(point: BranchPoint, name: str) -> float:
    """Give the function whose sign changes at a kind of special points.

    Parameters
    ----------
    point : BranchPoint
        A point.
    name : str
        "fold", "flip" or "contact loss".

    Returns
    -------
    float
        Its value.
    """
    if name == "fold":
        return float(point.tangent[-1])
    return point.flip if name == "flip" else point.margin


class _Follower:
    """Predictor and corrector of one branch."""

    def __init__(self, map_: Map, settings: Settings) -> None:
        self.map, self.settings = map_, settings
        self.scale = 0.0

    def first(self, state: Array) -> BranchPoint:
        """Correct the first point at the start of the interval."""
        point = self.derived(state, self.settings.start)
        along = np.zeros(state.size + 1)
        along[-1] = 1.0
        state, value, _ = self.corrected(point, point.state, point.value, along)
        point = self.derived(state, value)
        forward = np.zeros(state.size + 1)
        forward[-1] = np.sign(self.settings.stop - self.settings.start)
        self.complete(point, forward)
        return point

    def advance(self, last: BranchPoint, step: float) -> tuple[BranchPoint, float]:
        """Give the next point and the next length of a step."""
        while True:
            try:
                point, count = self.step(last, step)
                if point.tangent @ last.tangent < _TURN and step > 16.0 * self.settings.smallest:
                    raise ConvergenceError("the branch turns too much")
            except GearbowError as error:
                step /= 3.0
                if step < self.settings.smallest:
                    raise ConvergenceError(
                        f"continuation: the branch cannot be followed beyond {last.value:.8g}: "
                        f"{error}"
                    ) from error
                continue
            factor = 1.5 if count < _USUAL else 1.0 if count == _USUAL else 0.6
            return point, min(step * factor, self.settings.largest)

    def step(self, last: BranchPoint, step: float) -> tuple[BranchPoint, int]:
        """Give the point at a length from another one, and its number of corrections."""
        along = last.tangent
        state = last.state + step * along[:-1] * last.scale
        value = last.value + step * along[-1] * self.settings.span
        state, value, count = self.corrected(last, state, value, along)
        point = self.derived(state, value)
        self.complete(point, along)
        return point, count

    def ended(self, last: BranchPoint, beyond: BranchPoint, value: float) -> BranchPoint:
        """Give the point at a bound of the interval, between two points."""
        part = (value - last.value) / (beyond.value - last.value)
        along = np.zeros(last.state.size + 1)
        along[-1] = 1.0
        state = last.state + part * (beyond.state - last.state)
        state, _, _ = self.corrected(beyond, state, value, along)
        point = self.derived(state, value)
        self.complete(point, last.tangent)
        return point

    def corrected(
        self, base: BranchPoint, state: Array, value: float, along: Array
    ) -> tuple[Array, float, int]:
        """Correct a predicted point in the plane across the branch."""
        matrix = self.bordered(base, along)
        size = max(float(np.linalg.norm(state)), self.settings.floor)
        before = np.inf
        for count in range(1, _CORRECTIONS + 1):
            defect = self.map.images(state[None], value)[0] - state
            error = float(np.linalg.norm(defect)) / size
            if error <= self.settings.tolerance:
                return state, value, count
            if not error < 10.0 * before:
                break
            if error > 0.3 * before and count % 3 == 0:
                base = self.derived(state, value)
                matrix = self.bordered(base, along)
            change = np.linalg.solve(matrix, np.append(-defect / base.scale, 0.0))
            state = state + change[:-1] * base.scale
            value = value + change[-1] * self.settings.span
            before = error
        raise ConvergenceError(f"the corrections do not converge (residual {error:.1e})")

    def bordered(self, base: BranchPoint, along: Array) -> Array:
        """Give the Jacobian of P(x) − x and of the plane across the branch, in scaled unknowns."""
        n = base.state.size
        matrix = np.zeros((n + 1, n + 1))
        matrix[:n, :n] = base.jacobian - np.eye(n)
        matrix[:n, n] = base.slope / base.scale
        matrix[n] = along
        return matrix

    def derived(self, state: Array, value: float) -> BranchPoint:
        """Take the derivatives of the map at a state."""
        n = state.size
        size = max(float(np.linalg.norm(state)), self.settings.floor)
        # The largest motion so far, so that lengths are comparable along the branch.
        self.scale = max(self.scale, size)
        width = _DIFFERENCE * size
        moved = np.concatenate([state + width * np.eye(n), state - width * np.eye(n)])
        images = self.map.images(np.concatenate([state[None], moved]), value)[1:]
        jacobian = (images[:n] - images[n:]).T / (2.0 * width)
        small = _PARAMETER * self.settings.span
        sides = [self.map.images(state[None], value + sign * small)[0] for sign in (1.0, -1.0)]
        slope = (sides[0] - sides[1]) / (2.0 * _PARAMETER)
        return BranchPoint(state, value, jacobian, slope, self.scale)

    def complete(self, point: BranchPoint, forward: Array) -> None:
        """Add the tangent, in the direction of another one, and what the map observes."""
        matrix = self.bordered(point, forward)
        right = np.zeros(point.state.size + 1)
        right[-1] = 1.0
        tangent = np.linalg.solve(matrix, right)
        point.tangent = tangent / np.linalg.norm(tangent)
        point.kept, point.margin = self.map.observed(point.state, point.value)

    def located(self, last: BranchPoint, after: BranchPoint, name: str) -> BranchPoint:
        """Locate a special point between two points, by false position with halved weights."""
        chord = (after.state - last.state) @ last.tangent[:-1] / last.scale
        chord += (after.value - last.value) / self.settings.span * last.tangent[-1]
        ends = [(0.0, critical(last, name)), (float(chord), critical(after, name))]
        best, side = after, 0
        for _ in range(_LOCATIONS):
            (a, f), (b, g) = ends
            at = (a * g - b * f) / (g - f)
            found, _ = self.step(last, at)
            new = critical(found, name)
            done = abs(found.value - best.value) <= _LOCATED * abs(found.value)
            best = found
            if done or new == 0.0:
                break
            if new * g < 0.0:
                ends, side = [(b, g), (at, new)], 0
            else:
                # The end that stays for a second time counts half (the Illinois algorithm).
                ends, side = [(a, f / 2.0 if side else f), (at, new)], 1
        best.kind = name
        return best
