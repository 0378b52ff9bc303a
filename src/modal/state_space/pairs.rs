//! Decoupled pairs of real coordinates z from the eigenpairs of a first-order form, y = T z.
//!
//! Each pair moves by its own 2 × 2 block. A complex eigenvalue gives one pair ([`super::eigenpairs`]), the position
//! and velocity of a rigid-body mode give one pair ([`super::rigid_body`]), and the remaining real eigenvalues are
//! combined two by two. Pair k has the entries k and n + k of z.

use nalgebra::DMatrix;
use num_complex::Complex64;

use super::eigenpairs::Eigenpairs;
use super::first_order::FirstOrder;
use super::rigid_body::RigidBodyPositions;
use crate::linalg::{DecompositionError, MAX_BACKWARD_ERROR};
use crate::modal::undamped::RealModes;

/// Oscillations slower than this fraction of the lowest undamped frequency are rigid-body motions with round-off.
const SLOWEST_OSCILLATION: f64 = 1e-6;

/// Motion of one pair of coordinates (x, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModePair {
    /// Complex eigenvalue λ = a + ib, rad/s: block [[a, b], [−b, a]].
    Oscillation(Complex64),
    /// Two real eigenvalues, rad/s.
    Real([f64; 2]),
    /// Position and velocity of a rigid-body motion with decay rate λ ≤ 0, rad/s: block [[0, 1], [0, λ]].
    RigidBodyPair(f64),
}

impl ModePair {
    /// The 2 × 2 matrix A of (ẋ, ẏ) = A (x, y).
    pub fn block(&self) -> [[f64; 2]; 2] {
        match self {
            Self::Oscillation(value) => [[value.re, value.im], [-value.im, value.re]],
            Self::Real([a, d]) => [[*a, 0.0], [0.0, *d]],
            Self::RigidBodyPair(rate) => [[0.0, 1.0], [0.0, *rate]],
        }
    }

    /// The two eigenvalues, rad/s.
    pub fn eigenvalues(&self) -> [Complex64; 2] {
        let real = |value: f64| Complex64::new(value, 0.0);
        match self {
            Self::Oscillation(value) => [*value, value.conj()],
            Self::Real(values) => values.map(real),
            Self::RigidBodyPair(rate) => [0.0, *rate].map(real),
        }
    }

    /// Largest |λ|, rad/s.
    pub(in crate::modal) fn largest(&self) -> f64 {
        match self {
            Self::Oscillation(value) => value.norm(),
            Self::Real(values) => values[0].abs().max(values[1].abs()),
            Self::RigidBodyPair(rate) => rate.abs(),
        }
    }
}

/// Pairs of coordinates with the transformations y = T z and z = T⁻¹ y.
pub(in crate::modal) struct Pairs {
    /// The n pairs.
    pub pairs: Vec<ModePair>,
    /// T, 2n × 2n.
    pub right: DMatrix<f64>,
    /// T⁻¹, 2n × 2n.
    pub left: DMatrix<f64>,
    /// Condition number of the modes; infinite if they do not reproduce the matrix.
    pub condition: f64,
}

impl Pairs {
    /// Decouples a first-order form; `None` if round-off hides which eigenvalues belong to a rigid-body motion.
    pub fn new(real_modes: &RealModes, order: &FirstOrder) -> Result<Option<Self>, DecompositionError> {
        let Some(eigenpairs) = Eigenpairs::new(real_modes, order)? else {
            return Ok(None);
        };
        let n = real_modes.frequencies.len();
        // Rigid-body modes whose velocities are among the eigenvectors, and the rows of these velocities.
        let coupled: Vec<usize> = order.moving.iter().copied().filter(|i| order.rigid_body.contains(i)).collect();
        let velocities: Vec<usize> = coupled.iter().map(|mode| order.velocity_index(*mode)).collect();
        let lowest = order.elastic.first().map_or(0.0, |mode| real_modes.frequencies[*mode]);
        let round_off = f64::EPSILON * order.matrix.amax() * order.matrix.nrows() as f64;
        let smallest = round_off.max(SLOWEST_OSCILLATION * lowest);
        if !coupled.is_empty() && eigenpairs.complex.iter().any(|value| value.norm() <= smallest) {
            return Ok(None);
        }
        let rates = eigenpairs.vectors.select_rows(&velocities);
        let rigid = RigidBodyPositions::new(&rates, &eigenpairs, if lowest > 0.0 { lowest } else { 1.0 });
        let condition = if eigenpairs.residual(order) > MAX_BACKWARD_ERROR * order.matrix.norm() {
            f64::INFINITY
        } else {
            eigenpairs.condition().max(rigid.condition())
        };

        let Layout { mut pairs, columns, positions } = Layout::new(n, &eigenpairs, &rigid);
        let mut right = DMatrix::zeros(2 * n, 2 * n);
        let mut left = DMatrix::zeros(2 * n, 2 * n);
        for (column, place) in columns.iter().enumerate() {
            for row in 0..order.matrix.nrows() {
                right[(row, *place)] = eigenpairs.vectors[(row, column)];
                left[(*place, row)] = eigenpairs.inverse[(column, row)];
            }
        }
        // Positions: η = R p + F z, so p = R⁻¹ η − R⁻¹ F V⁻¹ y.
        let rows: Vec<usize> = coupled.iter().map(|mode| order.position_index(*mode)).collect();
        let back = &rigid.inverse * &rigid.response * &eigenpairs.inverse;
        for (j, row) in rows.iter().enumerate() {
            for (i, other) in rows.iter().enumerate() {
                right[(*row, positions[i])] = rigid.shapes[(j, i)];
                left[(positions[j], *other)] = rigid.inverse[(j, i)];
            }
            for (column, place) in columns.iter().enumerate() {
                right[(*row, *place)] += rigid.response[(j, column)];
            }
            for row in 0..order.matrix.nrows() {
                left[(positions[j], row)] = -back[(j, row)];
            }
        }
        for mode in &order.uncoupled {
            let pair = pairs.len();
            pairs.push(ModePair::RigidBodyPair(0.0));
            for (row, place) in [(order.position_index(*mode), pair), (order.velocity_index(*mode), pair + n)] {
                right[(row, place)] = 1.0;
                left[(place, row)] = 1.0;
            }
        }
        Ok(Some(Self { pairs, right, left, condition }))
    }
}

/// Assignment of eigenvectors and rigid-body positions to entries of z.
struct Layout {
    /// The pairs, without those of uncoupled rigid-body modes.
    pairs: Vec<ModePair>,
    /// Entry of z for each column of V.
    columns: Vec<usize>,
    /// Entry of z for each rigid-body position p.
    positions: Vec<usize>,
}

impl Layout {
    fn new(n: usize, eigenpairs: &Eigenpairs, rigid: &RigidBodyPositions) -> Self {
        let first_real = eigenpairs.first_real();
        let mut pairs = Vec::with_capacity(n);
        let mut columns = vec![0; eigenpairs.vectors.ncols()];
        let mut positions = vec![0; rigid.carriers.len()];
        for (index, value) in eigenpairs.complex.iter().enumerate() {
            (columns[2 * index], columns[2 * index + 1]) = (pairs.len(), pairs.len() + n);
            pairs.push(ModePair::Oscillation(*value));
        }
        for (carrier, position) in rigid.carriers.iter().zip(&mut positions) {
            if let Some(column) = carrier {
                (*position, columns[*column]) = (pairs.len(), pairs.len() + n);
                pairs.push(ModePair::RigidBodyPair(eigenpairs.real[column - first_real]));
            }
        }
        // The other real eigenvalues, and zero for each constant p, two by two.
        let mut rest: Vec<(f64, &mut usize)> = Vec::new();
        for ((column, place), value) in columns.iter_mut().enumerate().skip(first_real).zip(&eigenpairs.real) {
            if !rigid.carriers.contains(&Some(column)) {
                rest.push((*value, place));
            }
        }
        let constant = rigid.carriers.iter().zip(&mut positions).filter(|(carrier, _)| carrier.is_none());
        rest.extend(constant.map(|(_, position)| (0.0, position)));
        for two in rest.chunks_exact_mut(2) {
            (*two[0].1, *two[1].1) = (pairs.len(), pairs.len() + n);
            pairs.push(ModePair::Real([two[0].0, two[1].0]));
        }
        Self { pairs, columns, positions }
    }
}
