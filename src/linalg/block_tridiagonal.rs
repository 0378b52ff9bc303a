//! Symmetric block-tridiagonal matrices: a chain of nodes, each coupled to its neighbours alone.
//!
//! A node has `B` unknowns, and each unknown `L` lanes that the real matrix treats alike. Bending is `B = 2` (u, φ)
//! with `L = 2` lanes, the real and the imaginary part of the complex displacement; twist is `B = L = 1`. A vector
//! holds, node after node, unknown after unknown, its lanes.

use thiserror::Error;

use crate::element::Values;

/// A matrix that should be positive definite is not.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("the matrix is not positive definite at node {node}")]
pub struct NotPositiveDefinite {
    /// The node whose pivot fails.
    pub node: usize,
}

type Block<const B: usize> = [[f64; B]; B];

/// A symmetric block-tridiagonal matrix.
#[derive(Clone, Debug)]
pub struct BlockTridiagonal<const B: usize> {
    /// Diagonal block of each node.
    diagonal: Vec<Block<B>>,
    /// Block of each node (row) with the one before (column); zero for the first.
    lower: Vec<Block<B>>,
}

impl<const B: usize> BlockTridiagonal<B> {
    /// The zero matrix of a chain of `nodes`.
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

    /// Adds to the entry of `node`, unknowns `row` and `column`.
    pub fn add_at_node(&mut self, node: usize, row: usize, column: usize, value: f64) {
        self.diagonal[node][row][column] += value;
    }

    /// Adds an element between `first` and the next node; `entry(i, j)` is its matrix over the 2B unknowns of both.
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
        for (mine, theirs) in pairs {
            for (mine, theirs) in mine.iter_mut().flatten().zip(theirs.iter().flatten()) {
                *mine += factor * theirs;
            }
        }
    }

    /// Calls `visit(row, column, value)` for every entry of the stored pattern, unknowns counted through the chain.
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

    /// Row `node` of the product with `x`.
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
    pub fn quadratic<const L: usize>(&self, x: &[f64]) -> f64 {
        let mut sum = 0.0;
        for node in 0..self.nodes() {
            let row: Values<B, L> = self.row(node, x);
            for (value, x) in row.iter().flatten().zip(&x[node * B * L..]) {
                sum += value * x;
            }
        }
        sum
    }

    /// Block LDLᵀ of a positive definite matrix.
    ///
    /// # Errors
    /// [`NotPositiveDefinite`] where a pivot block is not.
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

/// Block LDLᵀ factor: multipliers below the diagonal, and the inverse of every pivot block.
#[derive(Clone, Debug)]
pub struct BlockTridiagonalFactor<const B: usize> {
    inverse: Vec<Block<B>>,
    lower: Vec<Block<B>>,
}

impl<const B: usize> BlockTridiagonalFactor<B> {
    /// Solves in place for the right-hand side `x`.
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

/// The values of `node` in a vector.
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

/// Inverse of a symmetric positive definite block by Gauss–Jordan elimination, `None` where it is not.
fn invert<const B: usize>(block: &Block<B>) -> Option<Block<B>> {
    let mut left = *block;
    let mut inverse = [[0.0; B]; B];
    for (i, row) in inverse.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for i in 0..B {
        let pivot = left[i][i];
        // A comparison that NaN fails too.
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
