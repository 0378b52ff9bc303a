//! Symmetric block-tridiagonal matrices of a chain of nodes, where each node is coupled to its two neighbours only.
//!
//! A node has `B` unknowns. Each unknown has `L` lanes, and the same real matrix applies to every lane. Bending has
//! `B = 2` unknowns (u, φ) and `L = 2` lanes, the real and the imaginary part of the complex displacement. Torsion has
//! `B = L = 1`. A vector is ordered by node, then by unknown, then by lane.
//!
//! Products and solutions take time proportional to the number of nodes. The factorization is block LDLᵀ (Golub and Van
//! Loan, Matrix Computations, section 4.5).

use thiserror::Error;

use crate::element::Values;

/// Error: a matrix is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("the matrix is not positive definite at node {node}")]
pub struct NotPositiveDefinite {
    /// Node whose pivot block is not positive definite.
    pub node: usize,
}

type Block<const B: usize> = [[f64; B]; B];

/// A symmetric block-tridiagonal matrix.
#[derive(Clone, Debug)]
pub struct BlockTridiagonal<const B: usize> {
    /// Diagonal block of each node, B × B.
    diagonal: Vec<Block<B>>,
    /// Block of each node (rows) and the node before it (columns), B × B; zero for the first node.
    lower: Vec<Block<B>>,
}

impl<const B: usize> BlockTridiagonal<B> {
    /// Zero matrix of a chain of `nodes`.
    pub fn zeros(nodes: usize) -> Self {
        Self { diagonal: vec![[[0.0; B]; B]; nodes], lower: vec![[[0.0; B]; B]; nodes] }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.diagonal.len()
    }

    /// Whether every entry is zero.
    pub fn is_zero(&self) -> bool {
        self.diagonal.iter().chain(&self.lower).flatten().flatten().all(|entry| *entry == 0.0)
    }

    /// Adds `value` to the entry (`row`, `column`) of the diagonal block of `node`.
    pub fn add_at_node(&mut self, node: usize, row: usize, column: usize, value: f64) {
        self.diagonal[node][row][column] += value;
    }

    /// Adds an element between the node `first` and the next one; `entry(i, j)` gives its 2B × 2B matrix.
    pub fn add_element(&mut self, first: usize, entry: impl Fn(usize, usize) -> f64) {
        for i in 0..B {
            for j in 0..B {
                self.diagonal[first][i][j] += entry(i, j);
                self.diagonal[first + 1][i][j] += entry(B + i, B + j);
                self.lower[first + 1][i][j] += entry(B + i, j);
            }
        }
    }

    /// Adds `factor` times `other`.
    pub fn add_scaled(&mut self, factor: f64, other: &Self) {
        let pairs = self.diagonal.iter_mut().zip(&other.diagonal).chain(self.lower.iter_mut().zip(&other.lower));
        for (block, added) in pairs {
            for (entry, added) in block.iter_mut().flatten().zip(added.iter().flatten()) {
                *entry += factor * added;
            }
        }
    }

    /// Calls `visit(row, column, value)` for every stored entry; unknowns are counted along the chain.
    pub fn for_each(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for node in 0..self.nodes() {
            for i in 0..B {
                for j in 0..B {
                    visit(node * B + i, node * B + j, self.diagonal[node][i][j]);
                    if node > 0 {
                        visit(node * B + i, (node - 1) * B + j, self.lower[node][i][j]);
                        visit((node - 1) * B + j, node * B + i, self.lower[node][i][j]);
                    }
                }
            }
        }
    }

    /// Values of the product with `x` at `node`.
    #[inline(always)]
    pub fn row<const L: usize>(&self, node: usize, x: &[f64]) -> Values<B, L> {
        let mut sum = [[0.0; L]; B];
        accumulate(&mut sum, &self.diagonal[node], &load(x, node));
        if node > 0 {
            accumulate(&mut sum, &self.lower[node], &load(x, node - 1));
        }
        if node + 1 < self.diagonal.len() {
            accumulate_transposed(&mut sum, &self.lower[node + 1], &load(x, node + 1));
        }
        sum
    }

    /// `out += factor · self · x`.
    pub fn multiply_add<const L: usize>(&self, factor: f64, x: &[f64], out: &mut [f64]) {
        for node in 0..self.nodes() {
            let row: Values<B, L> = self.row(node, x);
            for (out, value) in out[node * B * L..].iter_mut().zip(row.iter().flatten()) {
                *out += factor * value;
            }
        }
    }

    /// xᵀ·self·x, summed over the lanes.
    pub fn quadratic_form<const L: usize>(&self, x: &[f64]) -> f64 {
        let mut sum = 0.0;
        for node in 0..self.nodes() {
            let row: Values<B, L> = self.row(node, x);
            for (value, x) in row.iter().flatten().zip(&x[node * B * L..]) {
                sum += value * x;
            }
        }
        sum
    }

    /// Block LDLᵀ factorization of a positive definite matrix.
    ///
    /// # Errors
    /// [`NotPositiveDefinite`] if a pivot block is not positive definite.
    pub fn factor(&self) -> Result<BlockTridiagonalFactor<B>, NotPositiveDefinite> {
        let nodes = self.nodes();
        let mut inverse: Vec<Block<B>> = Vec::with_capacity(nodes);
        let mut lower: Vec<Block<B>> = Vec::with_capacity(nodes);
        for node in 0..nodes {
            let mut pivot = self.diagonal[node];
            let mut multiplier = [[0.0; B]; B];
            if node > 0 {
                let (coupling, previous) = (&self.lower[node], &inverse[node - 1]);
                for i in 0..B {
                    for j in 0..B {
                        multiplier[i][j] = (0..B).map(|k| coupling[i][k] * previous[k][j]).sum();
                    }
                }
                for i in 0..B {
                    for j in 0..B {
                        pivot[i][j] -= (0..B).map(|k| multiplier[i][k] * coupling[j][k]).sum::<f64>();
                    }
                }
            }
            inverse.push(invert(&pivot).ok_or(NotPositiveDefinite { node })?);
            lower.push(multiplier);
        }
        Ok(BlockTridiagonalFactor { inverse, lower })
    }
}

/// Block LDLᵀ factors of a [`BlockTridiagonal`].
#[derive(Clone, Debug)]
pub struct BlockTridiagonalFactor<const B: usize> {
    /// Inverse of the pivot block of each node.
    inverse: Vec<Block<B>>,
    /// Block of L of each node (rows) and the node before it (columns).
    lower: Vec<Block<B>>,
}

impl<const B: usize> BlockTridiagonalFactor<B> {
    /// Replaces the right-hand side `x` by the solution.
    #[inline(always)]
    pub fn solve<const L: usize>(&self, x: &mut [f64]) {
        let nodes = self.inverse.len();
        let mut previous: Values<B, L> = load(x, 0);
        for node in 1..nodes {
            let mut value: Values<B, L> = load(x, node);
            subtract(&mut value, &self.lower[node], &previous);
            store(x, node, &value);
            previous = value;
        }
        let mut next = [[0.0; L]; B];
        for node in (0..nodes).rev() {
            let mut value = [[0.0; L]; B];
            accumulate(&mut value, &self.inverse[node], &load(x, node));
            if node + 1 < nodes {
                subtract_transposed(&mut value, &self.lower[node + 1], &next);
            }
            store(x, node, &value);
            next = value;
        }
    }
}

/// Values of `node` in a vector.
#[inline(always)]
pub fn load<const B: usize, const L: usize>(x: &[f64], node: usize) -> Values<B, L> {
    let chunk = &x[node * B * L..(node + 1) * B * L];
    let mut values = [[0.0; L]; B];
    for (i, value) in values.iter_mut().enumerate() {
        value.copy_from_slice(&chunk[i * L..(i + 1) * L]);
    }
    values
}

#[inline(always)]
fn store<const B: usize, const L: usize>(x: &mut [f64], node: usize, values: &Values<B, L>) {
    let chunk = &mut x[node * B * L..(node + 1) * B * L];
    for (i, value) in values.iter().enumerate() {
        chunk[i * L..(i + 1) * L].copy_from_slice(value);
    }
}

#[inline(always)]
fn accumulate<const B: usize, const L: usize>(sum: &mut Values<B, L>, block: &Block<B>, x: &Values<B, L>) {
    for i in 0..B {
        for j in 0..B {
            for lane in 0..L {
                sum[i][lane] += block[i][j] * x[j][lane];
            }
        }
    }
}

#[inline(always)]
fn accumulate_transposed<const B: usize, const L: usize>(sum: &mut Values<B, L>, block: &Block<B>, x: &Values<B, L>) {
    for i in 0..B {
        for j in 0..B {
            for lane in 0..L {
                sum[i][lane] += block[j][i] * x[j][lane];
            }
        }
    }
}

#[inline(always)]
fn subtract<const B: usize, const L: usize>(sum: &mut Values<B, L>, block: &Block<B>, x: &Values<B, L>) {
    for i in 0..B {
        for j in 0..B {
            for lane in 0..L {
                sum[i][lane] -= block[i][j] * x[j][lane];
            }
        }
    }
}

#[inline(always)]
fn subtract_transposed<const B: usize, const L: usize>(sum: &mut Values<B, L>, block: &Block<B>, x: &Values<B, L>) {
    for i in 0..B {
        for j in 0..B {
            for lane in 0..L {
                sum[i][lane] -= block[j][i] * x[j][lane];
            }
        }
    }
}

/// Inverse of a symmetric positive definite block by Gauss–Jordan elimination; `None` if it is not positive definite.
fn invert<const B: usize>(block: &Block<B>) -> Option<Block<B>> {
    let mut left = *block;
    let mut inverse = [[0.0; B]; B];
    for (i, row) in inverse.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for i in 0..B {
        let pivot = left[i][i];
        // This form of the comparison rejects NaN too.
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        for j in 0..B {
            left[i][j] /= pivot;
            inverse[i][j] /= pivot;
        }
        for other in (0..B).filter(|other| *other != i) {
            let factor = left[other][i];
            for j in 0..B {
                left[other][j] -= factor * left[i][j];
                inverse[other][j] -= factor * inverse[i][j];
            }
        }
    }
    Some(inverse)
}
