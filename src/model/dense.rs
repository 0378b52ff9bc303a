//! The matrices of the whole scene, dense, for eigenvalues, factorisations and users.

use nalgebra::DMatrix;

use super::Model;
use super::shaft::{BendingChain, TwistChain};
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

    /// Stiffness of the meshes alone, linearised at rest.
    pub fn mesh_stiffness_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.mesh_matrix(speed, |mesh| self.meshes[mesh].stiffness)
    }

    /// Stiffness K of shafts, bearings and meshes.
    pub fn stiffness_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.shaft_stiffness_matrix() + self.support_stiffness_matrix() + self.mesh_stiffness_matrix(speed)
    }

    /// Damping of shafts, bearings and meshes; the modal damping is the basis's to add.
    pub fn damping_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.mesh_matrix(speed, |mesh| self.meshes[mesh].damping) + self.unmeshed_damping_matrix()
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

    fn mesh_matrix(&self, speed: f64, factor: impl Fn(usize) -> f64) -> DMatrix<f64> {
        let mut matrix = self.zeros();
        for (index, mesh) in self.meshes.iter().enumerate() {
            let sigma = self.sigma(index, speed);
            let (normal, factor) = (mesh.normal_at_rest(sigma), factor(index));
            mesh.gradient(sigma, normal, |row, left| {
                mesh.gradient(sigma, normal, |column, right| matrix[(row, column)] += factor * left * right);
            });
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
