//! Dense n × n matrices of the complete model in the order of the core, for eigenvalues, factorizations and users.
//!
//! SI units: translations in m, rotations in rad. A speed Ω is that of the reference shaft, rad/s; its sign selects the
//! loaded tooth flanks.

use nalgebra::DMatrix;

use super::Model;
use super::shaft::{BendingChain, TwistChain};
use crate::connection::Coefficients;
use crate::linalg::ChainMatrix;

impl Model {
    /// Mass matrix M.
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for shaft in &self.shafts {
            add_bending(&mut matrix, shaft.bending.as_ref(), |chain| Some(&chain.mass));
            add_twist(&mut matrix, shaft.twist.as_ref(), |chain| Some(&chain.mass));
        }
        matrix
    }

    /// Stiffness matrix of the shafts.
    pub fn shaft_stiffness_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for shaft in &self.shafts {
            add_bending(&mut matrix, shaft.bending.as_ref(), |chain| Some(&chain.stiffness));
            add_twist(&mut matrix, shaft.twist.as_ref(), |chain| Some(&chain.stiffness));
        }
        matrix
    }

    /// Stiffness matrix of the bearings.
    pub fn support_stiffness_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for support in &self.supports {
            add_support(&mut matrix, support.index, &support.stiffness);
        }
        matrix
    }

    /// Symmetric part of the bearing stiffness.
    pub fn symmetric_part_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for support in &self.supports {
            add_support(&mut matrix, support.index, &support.symmetric_part);
        }
        matrix
    }

    /// Bearing stiffness without its symmetric part.
    pub fn skew_part_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for support in &self.supports {
            add_support(&mut matrix, support.index, &support.skew_part());
        }
        matrix
    }

    /// Stiffness matrix of the connections at a speed of the reference shaft; meshes are linearised at rest.
    pub fn connection_stiffness_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.connection_matrix(speed, |coefficients| coefficients.stiffness)
    }

    /// Stiffness matrix K of shafts, bearings and connections.
    pub fn stiffness_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.shaft_stiffness_matrix() + self.support_stiffness_matrix() + self.connection_stiffness_matrix(speed)
    }

    /// Damping matrix of shafts, bearings and connections, without modal damping, which `CachedModel` adds.
    pub fn damping_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.connection_matrix(speed, |coefficients| coefficients.damping) + self.unmeshed_damping_matrix()
    }

    /// Damping matrix of shafts and bearings, without modal damping.
    pub fn unmeshed_damping_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for shaft in &self.shafts {
            add_bending(&mut matrix, shaft.bending.as_ref(), |chain| chain.damping.as_ref());
            add_twist(&mut matrix, shaft.twist.as_ref(), |chain| chain.damping.as_ref());
        }
        for support in &self.supports {
            add_support(&mut matrix, support.index, &support.damping);
        }
        matrix
    }

    /// Gyroscopic matrix G per unit speed of the reference shaft: the term −iΩ_s G_s u̇ of each shaft s for the real
    /// and imaginary part of u.
    pub fn gyroscopic_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                shaft.gyroscopic.for_each(|row, column, value| {
                    let (row, column) = (chain.start + 2 * row, chain.start + 2 * column);
                    matrix[(row, column + 1)] += shaft.ratio * value;
                    matrix[(row + 1, column)] -= shaft.ratio * value;
                });
            }
        }
        matrix
    }

    fn zeros(&self) -> DMatrix<f64> {
        DMatrix::zeros(self.len(), self.len())
    }

    fn connection_matrix(&self, speed: f64, of: impl Fn(Coefficients) -> DMatrix<f64>) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for connection in self.connections(speed) {
            let (rows, coefficients) = (connection.rows(), of(connection.linear(speed)));
            for (i, left) in rows.iter().enumerate() {
                for (j, right) in rows.iter().enumerate() {
                    let factor = coefficients[(i, j)];
                    for (row, left) in left {
                        for (column, right) in right {
                            matrix[(*row, *column)] += factor * left * right;
                        }
                    }
                }
            }
        }
        matrix
    }
}

/// Adds a matrix of the bending of a shaft to both planes.
fn add_bending<'a>(
    matrix: &mut DMatrix<f64>,
    chain: Option<&'a BendingChain>,
    select: impl Fn(&'a BendingChain) -> Option<&'a ChainMatrix<2>>,
) {
    if let Some((chain, part)) = chain.and_then(|chain| Some((chain, select(chain)?))) {
        part.for_each(|row, column, value| {
            for lane in 0..2 {
                matrix[(chain.start + 2 * row + lane, chain.start + 2 * column + lane)] += value;
            }
        });
    }
}

/// Adds a matrix of the torsion of a shaft.
fn add_twist<'a>(
    matrix: &mut DMatrix<f64>,
    chain: Option<&'a TwistChain>,
    select: impl Fn(&'a TwistChain) -> Option<&'a ChainMatrix<1>>,
) {
    if let Some((chain, part)) = chain.and_then(|chain| Some((chain, select(chain)?))) {
        part.for_each(|row, column, value| matrix[(chain.start + row, chain.start + column)] += value);
    }
}

/// Adds a 2 × 2 coefficient over (v, w) at the coordinates from `index` on.
fn add_support(matrix: &mut DMatrix<f64>, index: usize, coefficient: &[[f64; 2]; 2]) {
    for i in 0..2 {
        for j in 0..2 {
            matrix[(index + i, index + j)] += coefficient[i][j];
        }
    }
}
