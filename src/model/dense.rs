//! The matrices of the whole scene, dense, for eigenvalues, factorisations and users.

use nalgebra::DMatrix;

use super::Model;
use super::shaft::{BendingChain, TwistChain};
use crate::connection::Coefficients;
use crate::linalg::BlockTridiagonal;

impl Model {
    /// Mass M.
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for shaft in &self.shafts {
            add_bending(&mut matrix, shaft.bending.as_ref(), |chain| Some(&chain.mass));
            add_twist(&mut matrix, shaft.twist.as_ref(), |chain| Some(&chain.mass));
        }
        matrix
    }

    /// Stiffness of the shafts alone.
    pub fn shaft_stiffness_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for shaft in &self.shafts {
            add_bending(&mut matrix, shaft.bending.as_ref(), |chain| Some(&chain.stiffness));
            add_twist(&mut matrix, shaft.twist.as_ref(), |chain| Some(&chain.stiffness));
        }
        matrix
    }

    /// Stiffness of the bearings alone.
    pub fn support_stiffness_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for support in &self.supports {
            add_support(&mut matrix, support.index, &support.stiffness);
        }
        matrix
    }

    /// The restoring part of it.
    pub fn symmetric_part_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for support in &self.supports {
            add_support(&mut matrix, support.index, &support.symmetric_part);
        }
        matrix
    }

    /// What is left without it.
    pub fn skew_part_matrix(&self) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for support in &self.supports {
            add_support(&mut matrix, support.index, &support.skew_part());
        }
        matrix
    }

    /// Stiffness of the connections alone at a speed of the reference shaft: meshes are linearised at rest.
    pub fn connection_stiffness_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.connection_matrix(speed, |coefficients| coefficients.stiffness)
    }

    /// Stiffness K of shafts, bearings and connections.
    pub fn stiffness_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.shaft_stiffness_matrix() + self.support_stiffness_matrix() + self.connection_stiffness_matrix(speed)
    }

    /// Damping of shafts, bearings and connections; the modal damping is the basis's to add.
    pub fn damping_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.connection_matrix(speed, |coefficients| coefficients.damping) + self.unmeshed_damping_matrix()
    }

    /// Damping of shafts and bearings.
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

    /// Gyroscopic matrix G per unit reference speed: −iΩ_s G_s u̇ on (re, im) pairs.
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

fn add_bending<'a>(
    matrix: &mut DMatrix<f64>,
    chain: Option<&'a BendingChain>,
    of: impl Fn(&'a BendingChain) -> Option<&'a BlockTridiagonal<2>>,
) {
    if let Some((chain, part)) = chain.and_then(|chain| Some((chain, of(chain)?))) {
        part.for_each(|row, column, value| {
            for lane in 0..2 {
                matrix[(chain.start + 2 * row + lane, chain.start + 2 * column + lane)] += value;
            }
        });
    }
}

fn add_twist<'a>(
    matrix: &mut DMatrix<f64>,
    chain: Option<&'a TwistChain>,
    of: impl Fn(&'a TwistChain) -> Option<&'a BlockTridiagonal<1>>,
) {
    if let Some((chain, part)) = chain.and_then(|chain| Some((chain, of(chain)?))) {
        part.for_each(|row, column, value| matrix[(chain.start + row, chain.start + column)] += value);
    }
}

fn add_support(matrix: &mut DMatrix<f64>, index: usize, coefficient: &[[f64; 2]; 2]) {
    for i in 0..2 {
        for j in 0..2 {
            matrix[(index + i, index + j)] += coefficient[i][j];
        }
    }
}
