//! Dynamic stiffness S(λ) = λ²M + λ(C + ΩG) + K as band matrices of the shafts that a few coordinates couple.
//!
//! The circular coordinates p = v + iw (forward) and m = v − iw (backward) of each node uncouple the two planes of a shaft:
//! the gyroscopic term is −iλΩ_s G_s for p and +iλΩ_s G_s for m. A shaft is therefore three chains: p, m and torsion. A
//! bearing with the same coefficients in every direction belongs to the chains. Other bearings couple p and m of their
//! node, and a mesh couples six coordinates.
//!
//! A vector of circular coordinates has, in the place of the bending coordinates of a shaft, first p and then m of all
//! nodes. Forces transform in the same way as displacements: f_p = f_v + i f_w.

use num_complex::Complex64;

use super::Model;
use super::shaft::ShaftModel;
use crate::connection::Row;
use crate::linalg::{BlockTridiagonal, ChainMatrix, CoupledBands};

/// Weights of the matrices in S = stiffness·K + damping·C + mass·M + gyroscopic·G, where G is that of the unit speed of
/// the reference shaft.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// Factor of K.
    pub stiffness: Complex64,
    /// Factor of C.
    pub damping: Complex64,
    /// Factor of M.
    pub mass: Complex64,
    /// Factor of G.
    pub gyroscopic: Complex64,
    /// Whether K contains only the symmetric part of the stiffness of the bearings.
    pub symmetric: bool,
}

impl Weights {
    /// Weights of S(λ) at a speed of the reference shaft, rad/s; λ in rad/s.
    pub fn dynamic(eigenvalue: Complex64, speed: f64) -> Self {
        Self {
            stiffness: Complex64::ONE,
            damping: eigenvalue,
            mass: eigenvalue * eigenvalue,
            gyroscopic: eigenvalue * speed,
            symmetric: false,
        }
    }

    /// Weights of ∂S/∂λ.
    pub fn slope(eigenvalue: Complex64, speed: f64) -> Self {
        Self {
            stiffness: Complex64::ZERO,
            damping: Complex64::ONE,
            mass: 2.0 * eigenvalue,
            gyroscopic: Complex64::from(speed),
            symmetric: false,
        }
    }

    /// Weights of K.
    pub fn stiffness() -> Self {
        Self::dynamic(Complex64::ZERO, 0.0)
    }
}

impl Model {
    /// Weighted sum of the matrices of shafts, bearings and connections, with the loaded flanks at `speed` (reference
    /// shaft, rad/s).
    pub fn dynamic_stiffness(&self, weights: &Weights, speed: f64) -> CoupledBands {
        let mut sum = self.shaft_stiffness(weights);
        for connection in self.connections(speed) {
            let (rows, coefficients) = (connection.rows(), connection.linear(speed));
            for (i, left) in rows.iter().enumerate() {
                for (j, right) in rows.iter().enumerate() {
                    let value = weights.stiffness * coefficients.stiffness[(i, j)]
                        + weights.damping * coefficients.damping[(i, j)];
                    self.add_product(&mut sum, left, right, value);
                }
            }
        }
        sum
    }

    /// Weighted sum of the matrices of shafts and bearings.
    pub fn shaft_stiffness(&self, weights: &Weights) -> CoupledBands {
        let mut sum = CoupledBands::default();
        for shaft in &self.shafts {
            push_bending(&mut sum, shaft, weights);
            push_torsion(&mut sum, shaft, weights);
        }
        for support in &self.supports {
            let stiffness = if weights.symmetric { &support.symmetric_part } else { &support.stiffness };
            for (i, (stiffness, damping)) in stiffness.iter().zip(&support.damping).enumerate() {
                for (j, (stiffness, damping)) in stiffness.iter().zip(damping).enumerate() {
                    let value = weights.stiffness * *stiffness + weights.damping * *damping;
                    self.add_entry(&mut sum, support.index + i, support.index + j, value);
                }
            }
        }
        sum
    }

    /// Diagonal entries of the stiffness matrix of the shafts, n entries in internal order.
    pub fn chain_stiffness(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.len()];
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                chain.stiffness.for_each(|row, column, value| {
                    if row == column {
                        diagonal[chain.start + 2 * row..chain.start + 2 * row + 2].fill(value);
                    }
                });
            }
            if let Some(chain) = &shaft.twist {
                chain.stiffness.for_each(|row, column, value| {
                    if row == column {
                        diagonal[chain.start + row] = value;
                    }
                });
            }
        }
        diagonal
    }

    /// Adds value·left·rightᵀ.
    pub fn add_product(&self, sum: &mut CoupledBands, left: &Row, right: &Row, value: Complex64) {
        for (row, left) in left {
            for (column, right) in right {
                self.add_entry(sum, *row, *column, value * left * right);
            }
        }
    }

    /// Adds `value` to the entry of two coordinates in internal order.
    pub fn add_entry(&self, sum: &mut CoupledBands, row: usize, column: usize, value: Complex64) {
        if value == Complex64::ZERO {
            return;
        }
        // A force along v or w is f_p = 1 or i and f_m = 1 or −i; v = (p + m)/2 and w = (p − m)/2i.
        for (row, left) in self.numbering.circular(row) {
            for (column, right) in self.numbering.circular(column) {
                let share = if self.numbering.is_lateral(column) { 0.5 } else { 1.0 };
                sum.add(row, column, value * left * right.conj() * share);
            }
        }
    }

    /// Converts a vector of displacements or forces from internal order to circular coordinates.
    pub fn to_circular(&self, x: &[Complex64]) -> Vec<Complex64> {
        let mut out = x.to_vec();
        for (start, unknowns) in self.numbering.bending() {
            for i in 0..unknowns {
                let (v, w) = (x[start + 2 * i], Complex64::i() * x[start + 2 * i + 1]);
                (out[start + i], out[start + unknowns + i]) = (v + w, v - w);
            }
        }
        out
    }

    /// Converts a vector from circular coordinates to internal order.
    pub fn from_circular(&self, x: &[Complex64]) -> Vec<Complex64> {
        let mut out = x.to_vec();
        for (start, unknowns) in self.numbering.bending() {
            for i in 0..unknowns {
                let (p, m) = (x[start + i], x[start + unknowns + i]);
                out[start + 2 * i] = (p + m) * 0.5;
                out[start + 2 * i + 1] = (p - m) * Complex64::new(0.0, -0.5);
            }
        }
        out
    }
}

/// Appends the chains p and m of a shaft.
fn push_bending(sum: &mut CoupledBands, shaft: &ShaftModel, weights: &Weights) {
    let Some(chain) = &shaft.bending else {
        return;
    };
    let mut band = ChainMatrix::wide(2 * chain.nodes);
    add(&mut band, &chain.stiffness, weights.stiffness);
    add(&mut band, &chain.mass, weights.mass);
    if let Some(damping) = &chain.damping {
        add(&mut band, damping, weights.damping);
    }
    for sign in [-1.0, 1.0] {
        let mut band = band.clone();
        add(&mut band, &shaft.gyroscopic, weights.gyroscopic * Complex64::new(0.0, sign * shaft.ratio));
        sum.push(band);
    }
}

/// Appends the torsional chain of a shaft.
fn push_torsion(sum: &mut CoupledBands, shaft: &ShaftModel, weights: &Weights) {
    let Some(chain) = &shaft.twist else {
        return;
    };
    let mut band = ChainMatrix::narrow(chain.nodes);
    add(&mut band, &chain.stiffness, weights.stiffness);
    add(&mut band, &chain.mass, weights.mass);
    if let Some(damping) = &chain.damping {
        add(&mut band, damping, weights.damping);
    }
    sum.push(band);
}

/// Adds `weight` times a matrix of the chain.
fn add<const B: usize>(band: &mut ChainMatrix, matrix: &BlockTridiagonal<B>, weight: Complex64) {
    if weight != Complex64::ZERO {
        matrix.for_each(|row, column, value| band.add(row, column, weight * value));
    }
}
