//! Pairs of real coordinates from eigenvalues and eigenvectors, with the null motions, and how far they can be trusted.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::RealModes;
use super::damped::FirstOrder;
use crate::linalg::{DecompositionError, eigen, solve};

/// Null motions that swing more slowly than this part of the lowest frequency are round-off.
const SLOW: f64 = 1e-6;
/// Modes reproduce the matrix to this part of it, or they are not taken.
const RIGHT: f64 = 1e-11;

/// How a pair of coordinates moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModePair {
    /// λ = a + ib: [[a, b], [−b, a]].
    Oscillation(Complex64),
    /// Two real eigenvalues.
    Real([f64; 2]),
    /// Position and velocity of a motion that nothing restores and that λ ≤ 0 damps, if anything: [[0, 1], [0, λ]].
    RigidBodyPair(f64),
}

impl ModePair {
    /// Its 2×2 matrix.
    pub fn block(&self) -> [[f64; 2]; 2] {
        match self {
            Self::Oscillation(value) => [[value.re, value.im], [-value.im, value.re]],
            Self::Real([a, d]) => [[*a, 0.0], [0.0, *d]],
            Self::RigidBodyPair(rate) => [[0.0, 1.0], [0.0, *rate]],
        }
    }

    /// The largest |λ|, rad/s.
    pub(super) fn radius(&self) -> f64 {
        match self {
            Self::Oscillation(value) => value.norm(),
            Self::Real(values) => values[0].abs().max(values[1].abs()),
            Self::RigidBodyPair(rate) => rate.abs(),
        }
    }

    /// The smallest |λ|, rad/s.
    pub(super) fn slowest(&self) -> f64 {
        match self {
            Self::Real(values) => values[0].abs().min(values[1].abs()),
            Self::Oscillation(_) => self.radius(),
            Self::RigidBodyPair(_) => 0.0,
        }
    }
}

/// The pairs with the matrices y = right·z and z = left·y; z is split into first and second coordinates.
pub(super) struct Pairs {
    pub pairs: Vec<ModePair>,
    pub right: DMatrix<f64>,
    pub left: DMatrix<f64>,
    pub condition: f64,
}

impl Pairs {
    /// None where the eigenvalues do not tell what becomes of a null motion.
    pub fn new(real: &RealModes, order: &FirstOrder) -> Result<Option<Self>, DecompositionError> {
        let n = real.frequencies.len();
        let (e, block) = (order.elastic.len(), order.matrix.nrows());
        let mut oscillations: Vec<(Complex64, DVector<f64>, DVector<f64>)> = Vec::new();
        let mut single: Vec<(f64, DVector<f64>)> = Vec::new();
        if order.undamped {
            let axis = |i: usize| DVector::from_fn(block, |k, _| if k == i { 1.0 } else { 0.0 });
            for (i, mode) in order.elastic.iter().enumerate() {
                oscillations.push((Complex64::new(0.0, real.frequencies[*mode]), axis(i), axis(e + i)));
            }
        } else {
            let eigen = eigen(&order.matrix)?;
            for (value, vector) in eigen.values.iter().zip(eigen.vectors.column_iter()) {
                if value.im > 0.0 {
                    let (first, second) = balanced(vector.iter().copied());
                    oscillations.push((*value, first, second));
                } else if value.im == 0.0 {
                    single.push((value.re, vector.map(|entry| entry.re).normalize()));
                }
            }
        }
        if 2 * oscillations.len() + single.len() != block {
            return Ok(None);
        }
        // Where the velocities of null motions stand that are among the eigenvectors.
        let null: Vec<usize> = (0..n).filter(|i| real.frequencies[*i] == 0.0).collect();
        let held: Vec<usize> = (0..order.moving.len()).filter(|row| null.contains(&order.moving[*row])).collect();
        let lowest = order.elastic.first().map_or(0.0, |mode| real.frequencies[*mode]);
        let nothing = (f64::EPSILON * order.matrix.amax() * block as f64).max(SLOW * lowest);
        if !held.is_empty() && oscillations.iter().any(|(value, ..)| value.norm() <= nothing) {
            return Ok(None);
        }

        let columns: Vec<&DVector<f64>> = oscillations
            .iter()
            .flat_map(|(_, first, second)| [first, second])
            .chain(single.iter().map(|(_, vector)| vector))
            .collect();
        let vectors = if columns.is_empty() {
            DMatrix::zeros(0, 0)
        } else {
            DMatrix::from_columns(&columns.into_iter().cloned().collect::<Vec<_>>())
        };
        let inverse =
            if order.undamped { vectors.transpose() } else { solve(&vectors, &DMatrix::identity(block, block)) };
        let rates = vectors.select_rows(&held.iter().map(|row| e + row).collect::<Vec<_>>());
        let coasting = RigidBodyPair::new(&rates, &oscillations, &single, if lowest > 0.0 { lowest } else { 1.0 });
        let condition = if residual(order, &oscillations, &single, &vectors) > RIGHT * order.matrix.norm() {
            f64::INFINITY
        } else {
            condition(&vectors, &inverse, oscillations.len()).max(coasting.condition())
        };

        // y holds the block, then the positions of all null motions, then the velocities of those that stand alone.
        let mut right = DMatrix::zeros(2 * n, 2 * n);
        let mut left = DMatrix::zeros(2 * n, 2 * n);
        let mut pairs = Vec::with_capacity(n);
        let at = |slot: usize, which: usize| slot + which * n;
        // Where column j of `vectors` stands in z.
        let mut places = vec![0; block];
        for (index, (value, ..)) in oscillations.iter().enumerate() {
            (places[2 * index], places[2 * index + 1]) = (at(pairs.len(), 0), at(pairs.len(), 1));
            pairs.push(ModePair::Oscillation(*value));
        }
        let mut homes = vec![0; held.len()];
        for (carrier, home) in coasting.carriers.iter().zip(&mut homes) {
            if let Some(column) = carrier {
                (*home, places[*column]) = (at(pairs.len(), 0), at(pairs.len(), 1));
                pairs.push(ModePair::RigidBodyPair(single[column - 2 * oscillations.len()].0));
            }
        }
        // Real eigenvalues that carry nothing, and positions that nothing carries.
        let mut rest = Vec::new();
        for ((index, (value, _)), place) in single.iter().enumerate().zip(&mut places[2 * oscillations.len()..]) {
            if !coasting.carriers.contains(&Some(2 * oscillations.len() + index)) {
                rest.push((*value, place));
            }
        }
        rest.extend(
            coasting.carriers.iter().zip(&mut homes).filter(|(by, _)| by.is_none()).map(|(_, home)| (0.0, home)),
        );
        for two in rest.chunks_exact_mut(2) {
            (*two[0].1, *two[1].1) = (at(pairs.len(), 0), at(pairs.len(), 1));
            pairs.push(ModePair::Real([two[0].0, two[1].0]));
        }
        for (column, place) in places.iter().enumerate() {
            for row in 0..block {
                right[(row, *place)] = vectors[(row, column)];
                left[(*place, row)] = inverse[(column, row)];
            }
        }
        // Where the positions of the null motions stand in y.
        let position = |row: usize| block + null.iter().position(|i| *i == order.moving[row]).unwrap_or_default();
        let back = &coasting.inverse * &coasting.follows * &inverse;
        for (j, row) in held.iter().enumerate() {
            for (i, other) in held.iter().enumerate() {
                right[(position(*row), homes[i])] = coasting.shapes[(j, i)];
                left[(homes[j], position(*other))] = coasting.inverse[(j, i)];
            }
            for (column, place) in places.iter().enumerate() {
                right[(position(*row), *place)] += coasting.follows[(j, column)];
            }
            for row in 0..block {
                left[(homes[j], row)] = -back[(j, row)];
            }
        }
        let alone = null.iter().enumerate().filter(|(_, mode)| !order.moving.contains(mode));
        for (rate, (index, _)) in alone.enumerate() {
            let slot = pairs.len();
            pairs.push(ModePair::RigidBodyPair(0.0));
            for (row, place) in [(block + index, at(slot, 0)), (block + null.len() + rate, at(slot, 1))] {
                right[(row, place)] = 1.0;
                left[(place, row)] = 1.0;
            }
        }
        Ok(Some(Self { pairs, right, left, condition }))
    }
}

/// Positions of null motions: η = R p + F z over the coordinates z of the eigenvectors.
///
/// Such a position moves by its velocity, which every eigenvector has a part of: η̇ = W z. A motion that swings or decays
/// leaves η = W A⁻¹ z, and a p that stays where it is. Of one that hardly decays this would be a difference of large
/// numbers, so there ṗ = z: its eigenvector carries p.
struct RigidBodyPair {
    /// The eigenvector that carries each p, if any does.
    carriers: Vec<Option<usize>>,
    /// R, and its inverse.
    shapes: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// F, zero where a carrier stands.
    follows: DMatrix<f64>,
}

impl RigidBodyPair {
    /// From W; what decays more slowly than `slow` carries rather than leaves.
    fn new(
        rates: &DMatrix<f64>,
        oscillations: &[(Complex64, DVector<f64>, DVector<f64>)],
        single: &[(f64, DVector<f64>)],
        slow: f64,
    ) -> Self {
        let (positions, first) = (rates.nrows(), 2 * oscillations.len());
        // R is made of columns of W and of axes, the one that leaves most first, of what is independent of those before.
        let candidates: Vec<(Option<usize>, DVector<f64>, f64)> = single
            .iter()
            .enumerate()
            .map(|(i, (value, _))| (Some(first + i), rates.column(first + i).into_owned(), value.abs()))
            .chain((0..positions).map(|i| (None, DVector::from_fn(positions, |k, _| f64::from(k == i)), slow)))
            .collect();
        let mut left: Vec<DVector<f64>> = candidates.iter().map(|(_, column, _)| column.clone()).collect();
        let mut carriers = Vec::with_capacity(positions);
        let mut shapes = DMatrix::zeros(positions, positions);
        for position in 0..positions {
            let leaves = |i: usize| left[i].norm() / candidates[i].2.max(f64::EPSILON * slow);
            let best = (0..left.len()).max_by(|a, b| leaves(*a).total_cmp(&leaves(*b))).unwrap_or_default();
            carriers.push(candidates[best].0);
            shapes.set_column(position, &candidates[best].1);
            let direction = left[best].normalize();
            for column in &mut left {
                let along = direction.dot(column);
                column.axpy(-along, &direction, 1.0);
            }
            left[best].fill(0.0);
        }
        let inverse = solve(&shapes, &DMatrix::identity(positions, positions));
        let mut follows = DMatrix::zeros(positions, rates.ncols());
        for i in 0..positions {
            for (index, (value, ..)) in oscillations.iter().enumerate() {
                let (r, s) = (rates[(i, 2 * index)], rates[(i, 2 * index + 1)]);
                let square = value.norm_sqr();
                // (r, s) times the inverse of [[a, b], [−b, a]].
                follows[(i, 2 * index)] = (r * value.re + s * value.im) / square;
                follows[(i, 2 * index + 1)] = (s * value.re - r * value.im) / square;
            }
            for (column, (value, _)) in (first..).zip(single) {
                if !carriers.contains(&Some(column)) {
                    follows[(i, column)] = rates[(i, column)] / value;
                }
            }
        }
        Self { carriers, shapes, inverse, follows }
    }

    /// The largest ‖column of R‖·‖row of its inverse‖.
    fn condition(&self) -> f64 {
        let of = |i: usize| self.shapes.column(i).norm() * self.inverse.row(i).norm();
        (0..self.carriers.len()).map(of).fold(1.0, f64::max)
    }
}

/// Real and imaginary part of a complex vector of length √2, turned so that they are orthogonal.
fn balanced(vector: impl Iterator<Item = Complex64> + Clone) -> (DVector<f64>, DVector<f64>) {
    // v·v = (|r|² − |s|²) + 2i r·s is real and positive once v is turned by half its angle.
    let square: Complex64 = vector.clone().map(|value| value * value).sum();
    let norm: f64 = vector.clone().map(|value| value.norm_sqr()).sum::<f64>().sqrt();
    let turn = Complex64::from_polar(std::f64::consts::SQRT_2 / norm, -square.arg() / 2.0);
    let turned: Vec<Complex64> = vector.map(|value| value * turn).collect();
    let part = |of: fn(&Complex64) -> f64| DVector::from_iterator(turned.len(), turned.iter().map(of));
    (part(|value| value.re), part(|value| value.im))
}

/// Largest entry of A V − V B, with B the blocks.
fn residual(
    order: &FirstOrder,
    oscillations: &[(Complex64, DVector<f64>, DVector<f64>)],
    single: &[(f64, DVector<f64>)],
    vectors: &DMatrix<f64>,
) -> f64 {
    if order.undamped {
        return 0.0;
    }
    let mut left = &order.matrix * vectors;
    for (i, (value, first, second)) in oscillations.iter().enumerate() {
        let (first, second) = (first * value.re - second * value.im, first * value.im + second * value.re);
        left.column_mut(2 * i).zip_apply(&first, |entry, moved| *entry -= moved);
        left.column_mut(2 * i + 1).zip_apply(&second, |entry, moved| *entry -= moved);
    }
    for (i, (value, vector)) in single.iter().enumerate() {
        left.column_mut(2 * oscillations.len() + i).zip_apply(vector, |entry, moved| *entry -= value * moved);
    }
    left.amax()
}

/// The largest of ‖left‖·‖right‖ over the invariant subspaces: two columns of each oscillation, one of each real one.
fn condition(vectors: &DMatrix<f64>, inverse: &DMatrix<f64>, oscillations: usize) -> f64 {
    if inverse.iter().any(|entry| !entry.is_finite()) {
        return f64::INFINITY;
    }
    let mut worst: f64 = 1.0;
    for i in 0..oscillations {
        let [a, b] = [2 * i, 2 * i + 1];
        let right = (vectors.column(a).norm_squared() + vectors.column(b).norm_squared()) / 2.0;
        let left = (inverse.row(a).norm_squared() + inverse.row(b).norm_squared()) / 2.0;
        worst = worst.max((left * right).sqrt());
    }
    for i in 2 * oscillations..vectors.ncols() {
        worst = worst.max(vectors.column(i).norm() * inverse.row(i).norm());
    }
    worst
}
