//! Solutions of Reynolds' equation over the eccentricity and the directions of u and w, with smooth interpolation.
//!
//! ```text
//! f = f₀(β) + ε h(ε, ψ, β)/(1 − ε²)^{5/2},    u = ε e_ψ,    w = |w| e_β
//! ```
//!
//! f₀ is the force of the centred journal. The table contains h, which is smooth and bounded, so that the derivatives by u are
//! regular at ε = 0. Cubic B-splines interpolate it: in ξ with ε = ξ(2 − ξ), which resolves ε near 1, and periodically in
//! the angles. The interpolated force has continuous second derivatives.
//! The table contains the components of h along e_ψ and across it, over ε, ψ and γ = β − ψ. Without grooves they do not
//! depend on ψ. Grooves that a rotation by 2π/m maps to each other give the period 2π/m.
//! Beyond the last node, ε = 0.99, h keeps its value there.

use std::f64::consts::{PI, TAU};
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::DMatrix;

use super::reynolds::Reynolds;
use super::spline::{bounded, periodic, slopes, weights};
use super::{Matrix, Response, Vector, direction};
use crate::numerics::EQUALITY_TOLERANCE;

/// Number of nodes in ξ, from 0 to [`MAX_RADIAL_COORDINATE`].
const RADIAL_NODES: usize = 19;
/// Largest ξ of the table: ε = 0.99.
const MAX_RADIAL_COORDINATE: f64 = 0.9;
/// Number of directions of w.
const VELOCITY_DIRECTIONS: usize = 48;
/// Number of directions of u over a full turn, with grooves.
const DISPLACEMENT_DIRECTIONS: usize = 36;
/// Eccentricity ratio from which the derivative at the centre is computed.
const CENTRE_RATIO: f64 = 0.05;
/// Number of tables that are kept.
const KEPT_TABLES: usize = 16;

/// What a table follows from.
#[derive(Clone, Debug, PartialEq)]
struct TableKey {
    /// Ratio L/D.
    length_ratio: f64,
    /// Grooves (angle of the middle, extent), rad.
    grooves: Vec<[f64; 2]>,
}

/// The tables of this process; the bearings of a study have the same few.
static KNOWN: Mutex<Vec<(TableKey, Arc<FilmTable>)>> = Mutex::new(Vec::new());

/// The table of a film.
#[derive(Clone, Debug)]
pub struct FilmTable {
    /// Period in ψ, rad; none without grooves.
    sector: Option<f64>,
    /// First ψ of the table, rad.
    origin: f64,
    /// Number of directions of u.
    turns: usize,
    /// Spline coefficients of h over ξ, ψ and γ.
    coefficients: Vec<Vector>,
    /// Spline coefficients of f₀ over β; of a film without grooves f₀ = `centred` e_β.
    centre: Vec<Vector>,
    centred: f64,
}

/// The four splines that are not zero at a point of a periodic direction: index and weights.
type Local = ([usize; 4], [f64; 4], [f64; 4]);

impl FilmTable {
    /// The table of a ratio L/D and grooves (angle of the middle, extent), rad; computed at the first use.
    pub fn known(length_ratio: f64, grooves: &[[f64; 2]]) -> Arc<Self> {
        let key = TableKey { length_ratio, grooves: grooves.to_vec() };
        // A panic in another thread cannot leave the list half-written.
        let mut list = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, table)) = list.iter().find(|(known, _)| *known == key) {
            return Arc::clone(table);
        }
        let table = Arc::new(Self::new(&key));
        if list.len() >= KEPT_TABLES {
            list.remove(0);
        }
        list.push((key, Arc::clone(&table)));
        table
    }

    fn new(TableKey { length_ratio, grooves }: &TableKey) -> Self {
        let mut solver = Reynolds::new(*length_ratio, grooves);
        let sector = (!grooves.is_empty()).then(|| TAU / f64::from(symmetry(grooves)));
        let turns =
            sector.map_or(1, |sector| ((DISPLACEMENT_DIRECTIONS as f64 * sector / TAU).round() as usize).max(6));
        let angle = |index: usize| TAU * index as f64 / VELOCITY_DIRECTIONS as f64;
        let centre: Vec<Vector> = (0..VELOCITY_DIRECTIONS).map(|i| solver.force([0.0; 2], angle(i))).collect();
        let centred = centre[0][0];
        let axis = mirror(grooves);
        let origin = axis.unwrap_or(0.0);
        let mut values = vec![[0.0; 2]; RADIAL_NODES * turns * VELOCITY_DIRECTIONS];
        let at = |node: usize, turn: usize, i: usize| {
            (node * turns + turn % turns) * VELOCITY_DIRECTIONS + i % VELOCITY_DIRECTIONS
        };
        for turn in 0..turns {
            let psi = origin + sector.unwrap_or(0.0) * turn as f64 / turns as f64;
            // The motion that is mirrored about an axis of the bearing has the mirrored force.
            let count = match axis {
                Some(_) if 2 * turn > turns => continue,
                Some(_) if turn == 0 || 2 * turn == turns => VELOCITY_DIRECTIONS / 2 + 1,
                _ => VELOCITY_DIRECTIONS,
            };
            for i in 0..count {
                let centre = at_ratio(&mut solver, 0.0, psi, angle(i));
                for node in 0..RADIAL_NODES {
                    let value = deviation(&mut solver, node, psi, angle(i), centre);
                    values[at(node, turn, i)] = value;
                    if axis.is_some() {
                        values[at(node, turns - turn, VELOCITY_DIRECTIONS - i)] = [value[0], -value[1]];
                    }
                }
            }
        }
        let along = [bounded(RADIAL_NODES), periodic(VELOCITY_DIRECTIONS), periodic(turns.max(3))];
        let [Some(radial), Some(directions), Some(around)] = along else {
            // The matrices are diagonally dominant.
            return Self { sector, origin, turns, coefficients: Vec::new(), centre, centred };
        };
        let mut coefficients = transformed(&values, [RADIAL_NODES, turns, VELOCITY_DIRECTIONS], 2, &directions);
        if turns > 1 {
            coefficients = transformed(&coefficients, [RADIAL_NODES, turns, VELOCITY_DIRECTIONS], 1, &around);
        }
        let coefficients = transformed(&coefficients, [RADIAL_NODES, turns, VELOCITY_DIRECTIONS], 0, &radial);
        let centre = transformed(&centre, [1, 1, VELOCITY_DIRECTIONS], 2, &directions);
        Self { sector, origin, turns, coefficients, centre, centred }
    }

    /// |w| f and its derivatives at u and w.
    #[inline]
    pub fn response(&self, u: Vector, w: Vector) -> Response {
        let ((radial, ratio), (along, size)) = (direction(u), direction(w));
        let (psi, beta) = (radial[1].atan2(radial[0]), along[1].atan2(along[0]));
        let [value, slope, aside, along_gamma] = self
            .interpolated(ratio, psi, &local(beta - psi, TAU, VELOCITY_DIRECTIONS))
            .map(|vector| turned(radial, vector));
        let (value_0, slope_0) = self.centre(beta, along);
        let inside = (1.0 - ratio * ratio).max(f64::MIN_POSITIVE);
        let growth = 1.0 / (inside * inside * inside.sqrt());
        let f = [0, 1].map(|i| value_0[i] + ratio * growth * value[i]);
        let by_ratio = [0, 1].map(|i| growth * ((1.0 + 5.0 * ratio * ratio / inside) * value[i] + ratio * slope[i]));
        // (1/ε) ∂f/∂ψ at constant β: the vector turns with u, and γ = β − ψ decreases.
        let quarter = [-value[1], value[0]];
        let by_psi = [0, 1].map(|i| growth * (quarter[i] + aside[i] - along_gamma[i]));
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

    /// h over (e_ψ, e_ψ⊥) and its derivatives by ε, ψ and γ.
    #[inline]
    fn interpolated(&self, ratio: f64, psi: f64, gamma: &Local) -> [Vector; 4] {
        // ε = ξ(2 − ξ).
        let root = (1.0 - ratio).max(0.0).sqrt();
        let node = (1.0 - root) / MAX_RADIAL_COORDINATE * (RADIAL_NODES - 1) as f64;
        let limit = (RADIAL_NODES - 1) as f64;
        let (node, is_inside) = if node < limit { (node, true) } else { (limit, false) };
        let first = (node as usize).min(RADIAL_NODES - 2);
        let (at, by) = (weights(node - first as f64), slopes(node - first as f64));
        let by_ratio = if is_inside { (RADIAL_NODES - 1) as f64 / (2.0 * MAX_RADIAL_COORDINATE * root) } else { 0.0 };
        let around = match self.sector {
            None => ([0; 4], [1.0, 0.0, 0.0, 0.0], [0.0; 4]),
            Some(sector) => local(psi - self.origin, sector, self.turns),
        };
        let turns = if self.turns > 1 { 4 } else { 1 };
        let mut sums = [[0.0; 2]; 4];
        for i in 0..4 {
            for j in 0..turns {
                let row = ((first + i) * self.turns + around.0[j]) * VELOCITY_DIRECTIONS;
                let (mut value, mut slope) = ([0.0; 2], [0.0; 2]);
                for k in 0..4 {
                    let [y, z] = self.coefficients[row + gamma.0[k]];
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

    /// f₀ and its derivative by β.
    #[inline]
    fn centre(&self, beta: f64, along: Vector) -> (Vector, Vector) {
        if self.sector.is_none() {
            return (along.map(|value| self.centred * value), [-self.centred * along[1], self.centred * along[0]]);
        }
        let beta = local(beta, TAU, VELOCITY_DIRECTIONS);
        let (mut value, mut slope) = ([0.0; 2], [0.0; 2]);
        for k in 0..4 {
            let [y, z] = self.centre[beta.0[k]];
            value = [value[0] + beta.1[k] * y, value[1] + beta.1[k] * z];
            slope = [slope[0] + beta.2[k] * y, slope[1] + beta.2[k] * z];
        }
        (value, slope)
    }
}

/// f over (e_ψ, e_ψ⊥) at an eccentricity ratio, for the directions ψ of u and ψ + γ of w.
fn at_ratio(solver: &mut Reynolds, ratio: f64, psi: f64, gamma: f64) -> Vector {
    let (sin, cos) = psi.sin_cos();
    turned([cos, -sin], solver.force([ratio * cos, ratio * sin], psi + gamma))
}

/// h over (e_ψ, e_ψ⊥) at a node in ξ, for the directions ψ of u and ψ + γ of w; `centre` is f at ε = 0.
fn deviation(solver: &mut Reynolds, node: usize, psi: f64, gamma: f64, centre: Vector) -> Vector {
    let xi = MAX_RADIAL_COORDINATE * node as f64 / (RADIAL_NODES - 1) as f64;
    let ratio = xi * (2.0 - xi);
    let mut at = |ratio: f64| at_ratio(solver, ratio, psi, gamma);
    if node == 0 {
        let (ahead, behind) = (at(CENTRE_RATIO), at(-CENTRE_RATIO));
        return [0, 1].map(|i| (ahead[i] - behind[i]) / (2.0 * CENTRE_RATIO));
    }
    let (force, inside) = (at(ratio), 1.0 - ratio * ratio);
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

/// Largest m for which a rotation by 2π/m maps the grooves to each other.
fn symmetry(grooves: &[[f64; 2]]) -> u32 {
    let count = grooves.len() as u32;
    let maps = |m: u32| {
        let angle = TAU / f64::from(m);
        grooves.iter().all(|[middle, extent]| grooves.iter().any(|other| same([middle + angle, *extent], *other)))
    };
    (1..=count).rev().find(|m| maps(*m)).unwrap_or(1)
}

/// An axis about which the grooves are their own mirror image, rad.
fn mirror(grooves: &[[f64; 2]]) -> Option<f64> {
    let Some([first, _]) = grooves.first() else { return Some(0.0) };
    let maps = |axis: &f64| {
        let mirrored = grooves.iter().map(|[middle, extent]| [2.0 * axis - middle, *extent]);
        mirrored.into_iter().all(|image| grooves.iter().any(|other| same(image, *other)))
    };
    grooves.iter().map(|[middle, _]| (first + middle) / 2.0).find(maps)
}

/// Whether two grooves are equal.
fn same(a: [f64; 2], b: [f64; 2]) -> bool {
    ((a[0] - b[0] + PI).rem_euclid(TAU) - PI).abs() < EQUALITY_TOLERANCE && (a[1] - b[1]).abs() < EQUALITY_TOLERANCE
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest difference between table and solution, relative to the force, at directions between the nodes.
    fn error(length_ratio: f64, grooves: &[[f64; 2]], ratios: &[f64]) -> f64 {
        let table = FilmTable::known(length_ratio, grooves);
        let mut solver = Reynolds::new(length_ratio, grooves);
        let mut most = 0.0_f64;
        for ratio in ratios {
            for k in 0..29 {
                let (psi, beta) = (0.37 + 1.7 * f64::from(k), 0.11 + 2.0 * TAU / 29.0 * f64::from(k));
                let u = [ratio * psi.cos(), ratio * psi.sin()];
                let exact = solver.force(u, beta);
                let found = table.response(u, [beta.cos(), beta.sin()]).force;
                most = most.max((found[0] - exact[0]).hypot(found[1] - exact[1]) / exact[0].hypot(exact[1]));
            }
        }
        most
    }

    #[test]
    fn tables_equal_the_solutions_between_their_nodes() {
        for (length_ratio, grooves, limits) in [
            (0.25, vec![], [5e-3, 3e-2]),
            (0.5, vec![], [5e-3, 3e-2]),
            (1.0, vec![], [5e-3, 3e-2]),
            (0.5, vec![[0.0, 0.349], [PI, 0.349]], [1e-2, 5e-2]),
        ] {
            let low = error(length_ratio, &grooves, &[0.03, 0.11, 0.33, 0.52, 0.74]);
            let high = error(length_ratio, &grooves, &[0.87, 0.95]);
            println!("L/D {length_ratio}, {} grooves: {low:.1e} {high:.1e}", grooves.len());
            assert!(low < limits[0] && high < limits[1], "{length_ratio} {grooves:?}: {low:e} {high:e}");
        }
    }
}
