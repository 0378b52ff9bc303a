"""Branches of solutions by pseudo-arclength, and events along them.

The method of H. B. Keller (*Numerical solution of bifurcation and nonlinear eigenvalue problems*,
in Applications of Bifurcation Theory, Academic Press 1977) follows a branch x(s), λ(s) by its
length s, so that it passes folds. The map N is the step of an iteration that almost converges: the
derivative of N(x) − x is minus the identity plus a matrix of low rank. This matrix is found from
differences along few directions, and passed on from point to point.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace as changed
from typing import Any, Protocol

import numpy as np

from gearbow._types import Array, ComplexArray
from gearbow.errors import ConvergenceError, GearbowError

# The derivative of a preconditioned residual: minus the identity, plus a matrix of low rank.
#
# Broyden's update (C. G. Broyden, *Mathematics of Computation* 19, 1965) makes the derivative agree
# with a measured change. Its inverse follows from a small system (the Sherman-Morrison-Woodbury
# formula).

#: Number of columns from which the matrix is compressed, and number of columns after that.
_COLUMNS = 60
_KEPT = 30
#: Part of a step outside the columns of R below which it is round-off.
_DEPENDENT = 1e-10


@dataclass(frozen=True)
class LowRank:
    """The derivative [−I + L Rᵀ, s] with respect to n states and a parameter."""

    left: Array
    right: Array
    slope: Array

    @classmethod
    def identity(cls, slope: Array) -> "LowRank":
        """Give the derivative without a matrix of low rank."""
        return cls(np.zeros((slope.size, 0)), np.zeros((slope.size, 0)), slope)

    def product(self, step: Array) -> Array:
        """Multiply by a step."""
        states, value = step[:-1], step[-1]
        change: Array = self.left @ (self.right.T @ states) - states + self.slope * value
        return change

    def updated(self, step: Array, change: Array) -> "LowRank":
        """Agree with the change of the residual along a step."""
        length = float(step @ step)
        if not length > 0.0:
            return self
        error = (change - self.product(step)) / length
        known = self.right.T @ step[:-1]
        left = self.left + np.outer(error, known)
        rest = step[:-1] - self.right @ known
        rest = rest - self.right @ (self.right.T @ rest)
        part = float(np.linalg.norm(rest))
        right = self.right
        if part > _DEPENDENT * np.sqrt(length):
            left = np.column_stack([left, part * error])
            right = np.column_stack([right, rest / part])
        if left.shape[1] > _COLUMNS:
            left, right = _compressed(left, right)
        return LowRank(left, right, self.slope + error * step[-1])

    def solve(self, row: Array, change: Array, length: float) -> Array:
        """Find the step with a change of the residual and a length along a row."""
        left, right, slope = self.left, self.right, self.slope
        count = left.shape[1]
        # The states of the step are L c + s λ − change with c = Rᵀ states.
        matrix = np.eye(count + 1)
        matrix[:count, :count] -= right.T @ left
        matrix[:count, count] = -right.T @ slope
        matrix[count, :count] = row[:-1] @ left
        matrix[count, count] = row[:-1] @ slope + row[-1]
        known = np.append(-right.T @ change, length + row[:-1] @ change)
        found = np.linalg.solve(matrix, known)
        return np.append(left @ found[:-1] + slope * found[-1] - change, found[-1])


def _compressed(left: Array, right: Array) -> tuple[Array, Array]:
    """Keep the largest singular values of L Rᵀ."""
    directions = np.linalg.svd(left, full_matrices=False)[2][:_KEPT].T
    return left @ directions, right @ directions


#: Kinds of located points.
KINDS = ("fold", "flip", "contact loss")


@dataclass
class BranchPoint:
    """A fixed point with its derivative."""

    state: Array
    value: float
    scale: float
    derivative: LowRank
    tangent: Array = field(default_factory=lambda: np.zeros(0))
    margin: float = np.inf
    kept: Any = None
    multipliers: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))
    kind: str = ""


def critical(point: BranchPoint, kind: str) -> float:
    """Give the function whose sign changes at a kind of special points."""
    if kind == "fold":
        return float(point.tangent[-1])
    if kind == "contact loss":
        return point.margin
    negative = point.multipliers.real[(point.multipliers.imag == 0.0)]
    return 1.0 + float(min(negative, default=0.0))


# The first root of a function that is positive at first: doubling steps, then Illinois' method.
#
# Steps double from a first one, so that a dip of the function within one step is missed. Method: M.
# Dowell and P. Jarratt, *A modified regula falsi method for computing the root of an equation*, BIT
# 11 (1971).


def first_crossing(
    margin: Callable[[float], float], first: float, most: float, tolerance: float
) -> float | None:
    """Find the smallest value up to `most` with a margin that is not positive; None without one."""
    low, below = 0.0, margin(0.0)
    if below <= 0.0:
        return 0.0
    high = min(first, most)
    while (above := margin(high)) > 0.0:
        if high >= most:
            return None
        low, below, high = high, above, min(2.0 * high, most)
    kept = 0
    root = low
    while high - low > tolerance * high:
        # An infinite margin, beyond which there is no motion, has no slope.
        part = below / (below - above) if math.isfinite(above) else 0.5
        before, root = root, low + (high - low) * part
        if abs(root - before) <= 0.5 * tolerance * root:
            return root
        value = margin(root)
        if value > 0.0:
            low, below = root, value
            above = above / 2.0 if kept > 0 else above
            kept = 1
        else:
            high, above = root, value
            below = below / 2.0 if kept < 0 else below
            kept = -1
    return (low + high) / 2.0


#: Difference of states for a derivative, relative to the size of the state: a derivative has six or
#: seven digits, by the rounding error of the map divided by it.
_DIFFERENCE = 1e-7
#: Difference of the parameter for the tangent, relative to the interval.
_PARAMETER = 1e-6
#: Largest distance of a point from its prediction, in lengths of the step.
_REACH = 2.0
#: Number of corrections of one point, and that at which the steps keep their length.
_CORRECTIONS = 12
_USUAL = 7
#: Reduction of the residual by a correction that is too little.
_SLOW = 0.3
#: Largest residual of the linear system of a correction that was too little, and of the tangent.
_SOLVED = 0.1
_TANGENT = 1e-4
#: Largest number of directions in which a derivative is taken for one linear system.
_DIRECTIONS = 40
#: Part of a direction that is not in the span of the others, below which it is round-off.
_DEPENDENT_DIRECTION = 1e-8
#: Largest angle between two tangents [cos], and that up to which steps become longer.
_TURN = 0.9
_SMALL_TURN = 0.96
#: Number of steps in which a point is located.
_LOCATIONS = 40


class Map(Protocol):
    """A map of states over a parameter."""

    def images(self, states: Array, value: float, *, adapt: bool = False) -> Array:
        """Give the images of states at one value of the parameter."""

    def observed(self, state: Array, value: float) -> tuple[Any, float]:
        """Observe a fixed point."""

    def multipliers(self, kept: Any, value: float) -> ComplexArray:
        """Compute the largest multipliers of a fixed point."""


@dataclass(frozen=True)
class Settings:
    """Settings of a branch."""

    begin: float
    end: float
    first_step: float = 0.02
    max_points: int = 400
    tolerance: float = 1e-8
    floor: float = 1e-300
    largest: float = 0.05
    smallest: float = 1e-6

    @property
    def interval(self) -> tuple[float, float]:
        """Smallest and largest value of the interval."""
        return min(self.begin, self.end), max(self.begin, self.end)

    @property
    def span(self) -> float:
        """Length of the interval."""
        return abs(self.end - self.begin)


def branch(map_: Map, state: Array, settings: Settings) -> Iterator[BranchPoint]:
    """Follow a branch until the parameter leaves the interval."""
    follower = _Follower(map_, settings)
    last = follower.first(state)
    yield last
    step = settings.first_step
    low, high = settings.interval
    for _ in range(settings.max_points):
        found, step = follower.advance(last, step)
        ends = not low <= found.value <= high
        if ends:
            found = follower.ended(last, found, low if found.value < low else high)
            follower.observe(found, KINDS)
        for kind in KINDS:
            if critical(last, kind) * critical(found, kind) < 0.0:
                yield follower.located(last, found, kind)
        yield found
        if ends:
            return
        last = found


class _Follower:
    """Predictor and corrector of one branch."""

    def __init__(self, map_: Map, settings: Settings) -> None:
        self.map, self.settings = map_, settings
        self.scale = 0.0

    def first(self, state: Array) -> BranchPoint:
        """Correct the first point at the start of the interval."""
        self.scale = self.size(state)
        forward = np.zeros(state.size + 1)
        forward[-1] = np.sign(self.settings.end - self.settings.begin)
        value = self.settings.begin
        image = self.map.images(state[None], value, adapt=True)[0]
        derivative = LowRank.identity(self.slope(state, value, image))
        guess = BranchPoint(state, value, self.scale, derivative)
        point, _ = self.corrected(guess, state, value, forward)
        self.observe(point, KINDS)
        return point

    def advance(self, last: BranchPoint, step: float) -> tuple[BranchPoint, float]:
        """Give the next point and the next length of a step."""
        while True:
            try:
                point, count = self.step(last, step)
                if point.tangent @ last.tangent < _TURN and step > 16.0 * self.settings.smallest:
                    raise ConvergenceError("the branch turns too much")
                low, high = self.settings.interval
                # The point at the bound replaces one beyond it.
                if low <= point.value <= high:
                    self.observe(point, KINDS)
            except GearbowError as error:
                step /= 3.0
                if step < self.settings.smallest:
                    raise ConvergenceError(
                        f"continuation: the branch cannot be followed beyond {last.value:.8g}: "
                        f"{error}"
                    ) from error
                continue
            turn = point.tangent @ last.tangent
            if count > _USUAL:
                factor = 0.6
            else:
                factor = 1.5 if count < _USUAL and turn > _SMALL_TURN else 1.0
            return point, min(step * factor, self.settings.largest)

    def step(self, last: BranchPoint, step: float) -> tuple[BranchPoint, int]:
        """Give the point at a length from another one, and its number of corrections."""
        along = last.tangent
        state = last.state + step * along[:-1] * last.scale
        value = last.value + step * along[-1] * self.settings.span
        return self.corrected(last, state, value, along, reach=_REACH * step)

    def ended(self, last: BranchPoint, beyond: BranchPoint, value: float) -> BranchPoint:
        """Give the point at a bound of the interval, between two points."""
        part = (value - last.value) / (beyond.value - last.value)
        along = np.zeros(last.state.size + 1)
        along[-1] = np.sign(beyond.value - last.value)
        state = last.state + part * (beyond.state - last.state)
        point, _ = self.corrected(beyond, state, value, along)
        if point.tangent @ last.tangent < 0.0:
            point.tangent = -point.tangent
        return point

    def corrected(
        self,
        base: BranchPoint,
        state: Array,
        value: float,
        along: Array,
        *,
        reach: float = math.inf,
    ) -> tuple[BranchPoint, int]:
        """Correct a predicted point in the plane across a direction, within a distance."""
        size, scale, derivative = self.size(state), base.scale, base.derivative
        image = self.map.images(state[None], value, adapt=True)[0]
        before, last, step = np.inf, np.zeros(0), np.zeros(0)
        moved = np.zeros(along.size)
        for count in range(1, _CORRECTIONS + 1):
            residual = (image - state) / scale
            error = float(np.linalg.norm(residual)) * scale / size
            if count > 1:
                derivative = derivative.updated(step, residual - last)
            if error <= self.settings.tolerance:
                # The largest motion so far, so that lengths are comparable along the branch.
                self.scale = max(self.scale, size)
                slope = self.slope(state, value, image)
                derivative = changed(derivative, slope=slope)
                return self.point((state, value, image), derivative, along), count
            if not error < 10.0 * before:
                break
            if error > _SLOW * before:
                slope = self.slope(state, value, image)
                derivative = changed(derivative, slope=slope)
                derivative, step = self.solved(
                    (state, value, image), derivative, (along, -residual, 0.0), _SOLVED
                )
            else:
                step = derivative.solve(along, -residual, 0.0)
            moved = moved + step
            if np.linalg.norm(moved) > reach:
                break
            state = state + step[:-1] * scale
            value = value + step[-1] * self.settings.span
            image = self.map.images(state[None], value)[0]
            before, last = error, residual
        raise ConvergenceError(f"the corrections do not converge (residual {error:.1e})")

    def solved(
        self,
        at: tuple[Array, float, Array],
        derivative: LowRank,
        system: tuple[Array, Array, float],
        rtol: float,
    ) -> tuple[LowRank, Array]:
        """Solve with the derivative at a point, which is measured along the solution."""
        measured = np.zeros((derivative.slope.size, 0))
        for _ in range(_DIRECTIONS):
            step = derivative.solve(*system)
            direction = step[:-1]
            for _ in range(2):
                direction = direction - measured @ (measured.T @ direction)
            length, whole = np.linalg.norm(direction), np.linalg.norm(step[:-1])
            if length <= _DEPENDENT_DIRECTION * whole:
                break
            unit = np.append(direction / length, 0.0)
            change = self.change(at, unit[:-1])
            residual = length * np.linalg.norm(change - derivative.product(unit))
            derivative = derivative.updated(unit, change)
            measured = np.column_stack([measured, unit[:-1]])
            if residual <= rtol * whole:
                break
        return derivative, derivative.solve(*system)

    def change(self, at: tuple[Array, float, Array], direction: Array) -> Array:
        """Give the change of N(x) − x along a direction of unit length."""
        state, value, image = at
        move = _DIFFERENCE * self.size(state) * direction
        ahead = self.map.images((state + move)[None], value)[0]
        change: Array = (ahead - image - move) / (_DIFFERENCE * self.size(state))
        return change

    def slope(self, state: Array, value: float, image: Array) -> Array:
        """Give the change of N(x) − x with the parameter, in scaled unknowns."""
        ahead = self.map.images(state[None], value + _PARAMETER * self.settings.span)[0]
        slope: Array = (ahead - image) / (_PARAMETER * self.scale)
        return slope

    def size(self, state: Array) -> float:
        """Give the size of a state that is not zero."""
        return max(float(np.linalg.norm(state)), self.settings.floor)

    def point(
        self, at: tuple[Array, float, Array], derivative: LowRank, forward: Array
    ) -> BranchPoint:
        """Give a fixed point, its parameter and its image a tangent in a direction."""
        system = (forward, np.zeros(forward.size - 1), 1.0)
        derivative, tangent = self.solved(at, derivative, system, _TANGENT)
        tangent = tangent / np.linalg.norm(tangent)
        return BranchPoint(at[0], at[1], self.scale, derivative, tangent)

    def observe(self, point: BranchPoint, kinds: tuple[str, ...]) -> None:
        """Add what the map observes, as far as the kinds need it."""
        if kinds == ("fold",):
            return
        point.kept, point.margin = self.map.observed(point.state, point.value)
        if "flip" in kinds:
            point.multipliers = self.map.multipliers(point.kept, point.value)

    def located(self, last: BranchPoint, after: BranchPoint, kind: str) -> BranchPoint:
        """Locate a special point between two points, by false position with halved weights."""
        chord = (after.state - last.state) @ last.tangent[:-1] / last.scale
        chord += (after.value - last.value) / self.settings.span * last.tangent[-1]
        ends = [(0.0, critical(last, kind)), (float(chord), critical(after, kind))]
        best, side = after, 0
        for _ in range(_LOCATIONS):
            (a, f), (b, g) = ends
            at = (a * g - b * f) / (g - f)
            found, _ = self.step(last, at)
            self.observe(found, (kind,))
            new = critical(found, kind)
            # The values are not more accurate than the states.
            done = abs(found.value - best.value) <= self.settings.tolerance * abs(found.value)
            best = found
            if done or new == 0.0:
                break
            if new * g < 0.0:
                ends, side = [(b, g), (at, new)], 0
            else:
                # The end that stays for a second time counts half (the Illinois algorithm).
                ends, side = [(a, f / 2.0 if side else f), (at, new)], 1
        self.observe(best, KINDS)
        best.kind = kind
        return best
