//! Solutions of Reynolds' equation for one pad over the eccentricity and the directions of u and w, with smooth interpolation.
//!
//! ```text
//! f = f₀(β) + ε h(ε, ψ, β)/(1 − y²)^{5/2},    u = ε e_ψ,    w = |w| e_β
//! ```
//!
//! f₀ is the force of the centred journal. The table contains h, which is smooth and bounded, so that the derivatives by u are
//! regular at ε = 0. Cubic B-splines interpolate it: in ξ with x = ξ(2 − ξ), which resolves x near 1, and periodically in
//! the angles. The interpolated force has continuous second derivatives.
//! The table contains the components of h along e_ψ and across it, over x, ψ and γ = β − ψ; ψ counts from the middle of the
//! pad. Those of a pad of 360° do not depend on ψ, and x = y = ε.
//!
//! A journal opposite to a pad of the extent Θ may be further away than its clearance. Therefore
//!
//! ```text
//! y = ε (1 − a s²),    x = ε (1 − a s²/2),    s = sin(κψ/2) beyond the ends of the pad, from there on
//! κ = π/(π − Θ/2),    a = min(1, 2/κ²)
//! ```
//!
//! Along the pad y is ε, and beyond its ends y is at least 1 − H of the nearest end, which it equals to the second order: y < 1
//! means that the journal does not touch the pad. Beyond the last node, x = 0.99, h keeps its value there.

use std::f64::consts::{PI, TAU};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nalgebra::DMatrix;

use super::reynolds::Reynolds;
use super::{Matrix, Response, Vector, direction, store};
use crate::scene::Rupture;

/// Number of nodes in ξ, from 0 to [`MAX_RADIAL_COORDINATE`].
pub(super) const RADIAL_NODES: usize = 19;
/// Largest ξ of the table: x = 0.99.
const MAX_RADIAL_COORDINATE: f64 = 0.9;
/// Number of directions of w, and of those of u over a full turn for a pad of less than 360°; even.
pub(super) const DIRECTIONS: usize = 48;
/// Eccentricity ratio from which the derivative at the centre is computed.
const CENTRE_RATIO: f64 = 0.05;
/// Number of tables that are kept.
const KEPT_TABLES: usize = 64;

/// A dimensionless pad, from which a table follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PadShape {
    /// Ratio L/D.
    pub length_ratio: f64,
    /// Extent Θ of the arc, rad; 2π for a full film.
    pub extent: f64,
    /// Where the film ruptures.
    pub rupture: Rupture,
}

impl PadShape {
    /// Whether it is a full film.
    pub fn is_full(&self) -> bool {
        self.extent >= TAU
    }

    /// Number of directions of u in the table.
    pub(super) fn turns(&self) -> usize {
        if self.is_full() { 1 } else { DIRECTIONS }
    }

    /// 1 − a s² and 1 − a s²/2 and their derivatives by ψ, for an angle ψ from the middle of the pad.
    #[inline]
    pub(super) fn reach(&self, psi: f64) -> [[f64; 2]; 2] {
        let psi = (psi + PI).rem_euclid(TAU) - PI;
        let beyond = psi.abs() - self.extent / 2.0;
        if beyond <= 0.0 {
            return [[1.0, 0.0]; 2];
        }
        let kappa = PI / (PI - self.extent / 2.0);
        let amount = (2.0 / (kappa * kappa)).min(1.0);
        let (sin, cos) = (kappa * beyond / 2.0).sin_cos();
        let (square, slope) = (amount * sin * sin, amount * kappa * sin * cos * psi.signum());
        [[1.0 - square, -slope], [1.0 - square / 2.0, -slope / 2.0]]
    }
}

/// The tables of this process; the bearings of a study have the same few.
static KNOWN: Mutex<Vec<Arc<FilmTable>>> = Mutex::new(Vec::new());

/// The table of a pad, made at its first use.
#[derive(Debug)]
pub struct FilmTable {
    shape: PadShape,
    splines: OnceLock<Splines>,
}

/// Spline coefficients of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Splines {
    /// Those of h over ξ, ψ and γ.
    pub(super) deviation: Vec<Vector>,
    /// Those of f₀ along w and across it over β.
    pub(super) centre: Vec<Vector>,
}

/// The four splines that are not zero at a point of a periodic direction: index and weights.
type Local = ([usize; 4], [f64; 4], [f64; 4]);

impl Splines {
    /// Number of coefficients of h and of f₀.
    pub(super) fn lengths(shape: &PadShape) -> [usize; 2] {
        [(RADIAL_NODES + 2) * shape.turns() * DIRECTIONS, DIRECTIONS]
    }

    /// Computes the table of a pad. The motion that is mirrored about the middle of the pad has the mirrored force.
    pub(super) fn new(shape: &PadShape) -> Self {
        let (mut solver, turns) = (Reynolds::new(shape), shape.turns());
        let angle = |index: usize| TAU * index as f64 / DIRECTIONS as f64;
        let along_velocity = |i: usize| {
            let (sin, cos) = angle(i).sin_cos();
            turned([cos, -sin], solver.force([0.0; 2], angle(i)))
        };
        let centre: Vec<Vector> = (0..DIRECTIONS).map(along_velocity).collect();
        let mut values = vec![[0.0; 2]; RADIAL_NODES * turns * DIRECTIONS];
        let at = |node: usize, turn: usize, i: usize| (node * turns + turn % turns) * DIRECTIONS + i % DIRECTIONS;
        for turn in 0..=turns / 2 {
            let psi = TAU * turn as f64 / turns as f64;
            let is_own_image = turn == 0 || 2 * turn == turns;
            let count = if is_own_image { DIRECTIONS / 2 + 1 } else { DIRECTIONS };
            for i in 0..count {
                let centre = at_ratio(&mut solver, 0.0, psi, angle(i));
                for node in 0..RADIAL_NODES {
                    let value = deviation(&mut solver, node, psi, angle(i), centre);
                    values[at(node, turn, i)] = value;
                    values[at(node, turns - turn, DIRECTIONS - i)] = [value[0], -value[1]];
                }
            }
        }
        let shape = [RADIAL_NODES, turns, DIRECTIONS];
        let along = [bounded(RADIAL_NODES), periodic(DIRECTIONS), periodic(turns.max(3))];
        let [Some(radial), Some(directions), Some(around)] = along else {
            // The matrices are diagonally dominant.
            return Self { deviation: Vec::new(), centre };
        };
        let mut coefficients = transformed(&values, shape, 2, &directions);
        if turns > 1 {
            coefficients = transformed(&coefficients, shape, 1, &around);
        }
        let deviation = transformed(&coefficients, shape, 0, &radial);
        Self { deviation, centre: transformed(&centre, [1, 1, DIRECTIONS], 2, &directions) }
    }
}

impl FilmTable {
    /// The table of a pad, among those of this process.
    pub fn known(shape: PadShape) -> Arc<Self> {
        // A panic in another thread cannot leave the list half-written.
        let mut list = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(table) = list.iter().find(|table| table.shape == shape) {
            return Arc::clone(table);
        }
        let table = Arc::new(Self { shape, splines: OnceLock::new() });
        if list.len() >= KEPT_TABLES {
            list.remove(0);
        }
        list.push(Arc::clone(&table));
        table
    }

    /// The dimensionless pad.
    pub fn shape(&self) -> &PadShape {
        &self.shape
    }

    /// The coefficients: from a file of the user, or computed and kept there.
    #[inline]
    fn splines(&self) -> &Splines {
        self.splines.get_or_init(|| store::kept(&self.shape))
    }

    /// |w| f and its derivatives at u and w for a pad with its middle at an angle, rad.
    #[inline]
    pub fn response(&self, u: Vector, w: Vector, middle: f64) -> Response {
        let splines = self.splines();
        let ((radial, ratio), (along, size)) = (direction(u), direction(w));
        let (psi, beta) = (radial[1].atan2(radial[0]), along[1].atan2(along[0]));
        let reach = if self.shape.is_full() { [[1.0, 0.0]; 2] } else { self.shape.reach(psi - middle) };
        let [[near, near_slope], [range, range_slope]] = reach;
        let [value, slope, aside, along_gamma] = self
            .interpolated(splines, ratio * range, psi - middle, &local(beta - psi, TAU, DIRECTIONS))
            .map(|vector| turned(radial, vector));
        let (value_0, slope_0) = centre(splines, beta - middle, along);
        let y = ratio * near;
        let inside = (1.0 - y * y).max(f64::MIN_POSITIVE);
        let growth = 1.0 / (inside * inside * inside.sqrt());
        // (1/ε) ∂/∂y of the growth, times ε.
        let steeper = 5.0 * y / inside;
        let f = [0, 1].map(|i| value_0[i] + ratio * growth * value[i]);
        let by_ratio = [0, 1].map(|i| growth * ((1.0 + ratio * near * steeper) * value[i] + ratio * range * slope[i]));
        // (1/ε) ∂f/∂ψ at constant β: the vector turns with u, and γ = β − ψ decreases.
        let quarter = [-value[1], value[0]];
        let by_psi = [0, 1].map(|i| {
            let stretched = ratio * (near_slope * steeper * value[i] + range_slope * slope[i]);
            growth * (quarter[i] + aside[i] - along_gamma[i] + stretched)
        });
        let by_beta = [0, 1].map(|i| slope_0[i] + ratio * growth * along_gamma[i]);
        // First · nᵀ + second · n⊥ᵀ.
        let product = |first: Vector, n: Vector, second: Vector| -> Matrix {
            [0, 1].map(|i| [first[i] * n[0] - second[i] * n[1], first[i] * n[1] + second[i] * n[0]])
        };
        Response {
            force: f.map(|value| size * value),
            displacement: product(by_ratio, radial, by_psi).map(|row| row.map(|value| size * value)),
            velocity: product(f, along, by_beta),
        }
    }

    /// h over (e_ψ, e_ψ⊥) and its derivatives by x, ψ and γ.
    #[inline]
    fn interpolated(&self, splines: &Splines, x: f64, psi: f64, gamma: &Local) -> [Vector; 4] {
        // x = ξ(2 − ξ).
        let root = (1.0 - x).max(0.0).sqrt();
        let node = (1.0 - root) / MAX_RADIAL_COORDINATE * (RADIAL_NODES - 1) as f64;
        let limit = (RADIAL_NODES - 1) as f64;
        let (node, is_inside) = if node < limit { (node, true) } else { (limit, false) };
        let first = (node as usize).min(RADIAL_NODES - 2);
        let (at, by) = (weights(node - first as f64), slopes(node - first as f64));
        let by_ratio = if is_inside { (RADIAL_NODES - 1) as f64 / (2.0 * MAX_RADIAL_COORDINATE * root) } else { 0.0 };
        let turns = self.shape.turns();
        let (around, count) =
            if turns == 1 { (([0; 4], [1.0, 0.0, 0.0, 0.0], [0.0; 4]), 1) } else { (local(psi, TAU, turns), 4) };
        let mut sums = [[0.0; 2]; 4];
        for i in 0..4 {
            for j in 0..count {
                let row = ((first + i) * turns + around.0[j]) * DIRECTIONS;
                let (mut value, mut slope) = ([0.0; 2], [0.0; 2]);
                for k in 0..4 {
                    let [y, z] = splines.deviation[row + gamma.0[k]];
                    value = [value[0] + gamma.1[k] * y, value[1] + gamma.1[k] * z];
                    slope = [slope[0] + gamma.2[k] * y, slope[1] + gamma.2[k] * z];
                }
                for lane in 0..2 {
                    sums[0][lane] += at[i] * around.1[j] * value[lane];
                    sums[1][lane] += by_ratio * by[i] * around.1[j] * value[lane];
                    sums[2][lane] += at[i] * around.2[j] * value[lane];
                    sums[3][lane] += at[i] * around.1[j] * slope[lane];
                }
            }
        }
        sums
    }
}

/// f₀ and its derivative by β, for a velocity along a unit vector.
#[inline]
fn centre(splines: &Splines, beta: f64, along: Vector) -> (Vector, Vector) {
    let beta = local(beta, TAU, DIRECTIONS);
    let (mut value, mut slope) = ([0.0; 2], [0.0; 2]);
    for k in 0..4 {
        let [y, z] = splines.centre[beta.0[k]];
        value = [value[0] + beta.1[k] * y, value[1] + beta.1[k] * z];
        slope = [slope[0] + beta.2[k] * y, slope[1] + beta.2[k] * z];
    }
    (turned(along, value), turned(along, [slope[0] - value[1], slope[1] + value[0]]))
}

/// f over (e_ψ, e_ψ⊥) at an eccentricity ratio, for the directions ψ of u and ψ + γ of w.
fn at_ratio(solver: &mut Reynolds, ratio: f64, psi: f64, gamma: f64) -> Vector {
    let (sin, cos) = psi.sin_cos();
    turned([cos, -sin], solver.force([ratio * cos, ratio * sin], psi + gamma))
}

/// h over (e_ψ, e_ψ⊥) at a node in ξ, for the directions ψ of u and ψ + γ of w; `centre` is f at ε = 0.
fn deviation(solver: &mut Reynolds, node: usize, psi: f64, gamma: f64, centre: Vector) -> Vector {
    if node == 0 {
        let mut at = |ratio: f64| at_ratio(solver, ratio, psi, gamma);
        let (ahead, behind) = (at(CENTRE_RATIO), at(-CENTRE_RATIO));
        return [0, 1].map(|i| (ahead[i] - behind[i]) / (2.0 * CENTRE_RATIO));
    }
    let xi = MAX_RADIAL_COORDINATE * node as f64 / (RADIAL_NODES - 1) as f64;
    let [[near, _], [range, _]] = solver.shape().reach(psi);
    let ratio = xi * (2.0 - xi) / range;
    let (force, y) = (at_ratio(solver, ratio, psi, gamma), ratio * near);
    let inside = 1.0 - y * y;
    [0, 1].map(|i| (force[i] - centre[i]) * inside * inside * inside.sqrt() / ratio)
}

/// A vector turned by the angle whose unit vector is given.
#[inline]
fn turned([cos, sin]: Vector, v: Vector) -> Vector {
    [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1]]
}

/// The splines at an angle on `nodes` nodes over `period`. Derivatives are by the angle.
#[inline]
fn local(angle: f64, period: f64, nodes: usize) -> Local {
    let scale = nodes as f64 / period;
    let place = angle.rem_euclid(period) * scale;
    let first = (place as usize).min(nodes - 1);
    let t = place - first as f64;
    let index = [nodes - 1, 0, 1, 2].map(|offset| (first + offset) % nodes);
    (index, weights(t), slopes(t).map(|slope| slope * scale))
}

/// Applies a matrix along one of three axes of an array.
fn transformed(values: &[Vector], shape: [usize; 3], axis: usize, matrix: &DMatrix<f64>) -> Vec<Vector> {
    let (from, to) = (shape[axis], matrix.nrows());
    let inner: usize = shape[axis + 1..].iter().product();
    let outer: usize = shape[..axis].iter().product();
    let mut found = vec![[0.0; 2]; outer * to * inner];
    for block in 0..outer {
        for i in 0..to {
            for k in 0..from {
                let factor = matrix[(i, k)];
                for at in 0..inner {
                    let [y, z] = values[(block * from + k) * inner + at];
                    let sum = &mut found[(block * to + i) * inner + at];
                    *sum = [sum[0] + factor * y, sum[1] + factor * z];
                }
            }
        }
    }
    found
}

/// Weights of the four cubic B-splines on uniform nodes at the fraction `t` between two nodes.
#[inline]
fn weights(t: f64) -> [f64; 4] {
    let (r, t2, t3) = (1.0 - t, t * t, t * t * t);
    [r * r * r / 6.0, (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0, (1.0 + 3.0 * t + 3.0 * t2 - 3.0 * t3) / 6.0, t3 / 6.0]
}

/// Derivatives of [`weights`] over `t`.
#[inline]
fn slopes(t: f64) -> [f64; 4] {
    let (r, t2) = (1.0 - t, t * t);
    [-r * r / 2.0, (3.0 * t2 - 4.0 * t) / 2.0, (1.0 + 2.0 * t - 3.0 * t2) / 2.0, t2 / 2.0]
}

/// Matrix from the values at `nodes` nodes to the coefficients of a periodic spline.
fn periodic(nodes: usize) -> Option<DMatrix<f64>> {
    let mut matrix = DMatrix::zeros(nodes, nodes);
    for i in 0..nodes {
        for (offset, weight) in [(nodes - 1, 1.0 / 6.0), (0, 2.0 / 3.0), (1, 1.0 / 6.0)] {
            matrix[(i, (i + offset) % nodes)] += weight;
        }
    }
    matrix.try_inverse()
}

/// Matrix, shape (nodes + 2, nodes), from the values at the nodes to the coefficients of a spline between the first and the
/// last node. At the second and at the last node but one the third derivative is continuous.
fn bounded(nodes: usize) -> Option<DMatrix<f64>> {
    let count = nodes + 2;
    let mut matrix = DMatrix::zeros(count, count);
    for i in 0..nodes {
        for (offset, weight) in [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0].into_iter().enumerate() {
            matrix[(i, i + offset)] = weight;
        }
    }
    for (offset, factor) in [1.0, -4.0, 6.0, -4.0, 1.0].into_iter().enumerate() {
        matrix[(nodes, offset)] = factor;
        matrix[(nodes + 1, count - 1 - offset)] = factor;
    }
    Some(matrix.try_inverse()?.columns(0, nodes).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest difference between table and solution, relative to the force, at directions between the nodes, for y along the
    /// pad or towards it from outside.
    fn error(shape: PadShape, ratios: &[f64]) -> f64 {
        let table = FilmTable { shape, splines: OnceLock::from(Splines::new(&shape)) };
        let mut solver = Reynolds::new(&shape);
        let mut most = 0.0_f64;
        for ratio in ratios {
            for k in 0..29 {
                let (psi, beta) = (0.37 + 1.7 * f64::from(k), 0.11 + 2.0 * TAU / 29.0 * f64::from(k));
                let ratio = ratio / shape.reach(psi)[1][0];
                let u = [ratio * psi.cos(), ratio * psi.sin()];
                let exact = solver.force(u, beta);
                let found = table.response(u, [beta.cos(), beta.sin()], 0.0).force;
                // A pad has no force where it is not squeezed.
                let size = exact[0].hypot(exact[1]).max(0.1 * table.response([0.0; 2], [1.0, 0.0], 0.0).force[0]);
                most = most.max((found[0] - exact[0]).hypot(found[1] - exact[1]) / size);
            }
        }
        most
    }

    #[test]
    fn tables_equal_the_solutions_between_their_nodes() {
        for (length_ratio, extent, limits) in [
            (0.25, TAU, [5e-3, 3e-2]),
            (0.5, TAU, [5e-3, 3e-2]),
            (1.0, TAU, [5e-3, 3e-2]),
            (0.5, 160.0_f64.to_radians(), [2e-3, 5e-2]),
            (0.5, 60.0_f64.to_radians(), [2e-2, 8e-2]),
        ] {
            let shape = PadShape { length_ratio, extent, rupture: Rupture::Reynolds };
            let low = error(shape, &[0.03, 0.11, 0.33, 0.52, 0.74]);
            let high = error(shape, &[0.87, 0.95]);
            println!("L/D {length_ratio}, {extent:.2} rad: {low:.1e} {high:.1e}");
            assert!(low < limits[0] && high < limits[1], "{shape:?}: {low:e} {high:e}");
        }
    }
}
