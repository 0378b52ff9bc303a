//! Positions of the rigid-body modes whose velocities are coupled to other modes.
//!
//! Such a position η integrates a velocity in which every eigenvector participates: η̇ = W z, where z are the
//! coordinates of the eigenvectors, ż = Λ z. The solution is
//!
//! ```text
//! η = R p + F z,    F = W Λ⁻¹,    p constant
//! ```
//!
//! For an eigenvector that hardly decays, W Λ⁻¹ z and R p would be large numbers of opposite sign, and their sum would
//! lose digits. Such an eigenvector is a *carrier*: its column of F is zero and it moves one p, ṗ = z.

use nalgebra::{DMatrix, DVector};

use super::eigenpairs::Eigenpairs;
use crate::linalg::solve;

/// Decomposition η = R p + F z of m rigid-body positions over the coordinates z of the eigenvectors.
pub(in crate::modal) struct RigidBodyPositions {
    /// For each p, the column of V of its carrier; `None` for a constant p.
    pub carriers: Vec<Option<usize>>,
    /// R, m × m.
    pub shapes: DMatrix<f64>,
    /// R⁻¹, m × m.
    pub inverse: DMatrix<f64>,
    /// F, m rows, one column per column of V; zero in the columns of carriers.
    pub response: DMatrix<f64>,
}

impl RigidBodyPositions {
    /// Decomposes positions with η̇ = W z, W = `rates`. Eigenvectors that decay more slowly than `slow`, rad/s, become
    /// carriers.
    pub fn new(rates: &DMatrix<f64>, eigenpairs: &Eigenpairs, slow: f64) -> Self {
        let (positions, first_real) = (rates.nrows(), eigenpairs.first_real());
        // Columns of R are chosen among the columns of W of real eigenvalues and the unit vectors: in each step the one
        // whose part independent of the columns chosen so far is largest relative to its decay rate.
        let candidates: Vec<(Option<usize>, DVector<f64>, f64)> = eigenpairs
            .real
            .iter()
            .enumerate()
            .map(|(i, value)| (Some(first_real + i), rates.column(first_real + i).into_owned(), value.abs()))
            .chain((0..positions).map(|i| (None, DVector::from_fn(positions, |k, _| f64::from(k == i)), slow)))
            .collect();
        let mut independent: Vec<DVector<f64>> = candidates.iter().map(|(_, column, _)| column.clone()).collect();
        let mut carriers = Vec::with_capacity(positions);
        let mut shapes = DMatrix::zeros(positions, positions);
        for position in 0..positions {
            let size = |i: usize| independent[i].norm() / candidates[i].2.max(f64::EPSILON * slow);
            let best = (0..independent.len()).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or_default();
            carriers.push(candidates[best].0);
            shapes.set_column(position, &candidates[best].1);
            let direction = independent[best].normalize();
            for column in &mut independent {
                let component = direction.dot(column);
                column.axpy(-component, &direction, 1.0);
            }
            independent[best].fill(0.0);
        }
        let inverse = solve(&shapes, &DMatrix::identity(positions, positions));
        let response = response(rates, eigenpairs, &carriers);
        Self { carriers, shapes, inverse, response }
    }

    /// Largest ‖column of R‖·‖row of R⁻¹‖.
    pub fn condition(&self) -> f64 {
        let condition = |i: usize| self.shapes.column(i).norm() * self.inverse.row(i).norm();
        (0..self.carriers.len()).map(condition).fold(1.0, f64::max)
    }
}

/// F = W Λ⁻¹, without the columns of the carriers.
fn response(rates: &DMatrix<f64>, eigenpairs: &Eigenpairs, carriers: &[Option<usize>]) -> DMatrix<f64> {
    let mut response = DMatrix::zeros(rates.nrows(), rates.ncols());
    for i in 0..rates.nrows() {
        for (index, value) in eigenpairs.complex.iter().enumerate() {
            let (r, s) = (rates[(i, 2 * index)], rates[(i, 2 * index + 1)]);
            let square = value.norm_sqr();
            // (r, s) times the inverse of [[a, b], [−b, a]].
            response[(i, 2 * index)] = (r * value.re + s * value.im) / square;
            response[(i, 2 * index + 1)] = (s * value.re - r * value.im) / square;
        }
        for (column, value) in (eigenpairs.first_real()..).zip(&eigenpairs.real) {
            if !carriers.contains(&Some(column)) {
                response[(i, column)] = rates[(i, column)] / value;
            }
        }
    }
    response
}
