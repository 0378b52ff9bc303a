//! Symmetric matrices of a chain of nodes with internal unknowns in the elements between the nodes.
//!
//! The internal unknowns of an element are coupled to its two nodes only. A factorization eliminates them element by
//! element, which leaves a block-tridiagonal matrix of the nodes, so that products and solutions take time proportional
//! to the number of elements. A vector has the unknowns of the nodes first, then those of the elements in their order,
//! each with `L` lanes as in [`BlockTridiagonal`].

use nalgebra::DMatrix;

use super::band_order::BandOrder;
use super::block_tridiagonal::{BlockTridiagonal, BlockTridiagonalFactor, NotPositiveDefinite};
use crate::element::InternalBlocks;

/// A symmetric matrix of a chain of nodes with `B` unknowns each and of elements with internal unknowns.
#[derive(Clone, Debug)]
pub struct ChainMatrix<const B: usize> {
    /// Entries between nodes.
    pub nodal: BlockTridiagonal<B>,
    /// Entries of the internal unknowns of each element; empty if the elements have none.
    pub internal: Vec<InternalBlocks>,
}

impl<const B: usize> ChainMatrix<B> {
    /// Zero matrix of a chain of `nodes` without internal unknowns.
    pub fn zeros(nodes: usize) -> Self {
        Self { nodal: BlockTridiagonal::zeros(nodes), internal: Vec::new() }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.nodal.nodes()
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        B * self.nodes() + self.internal.iter().map(|blocks| blocks.block.nrows()).sum::<usize>()
    }

    /// Order of the unknowns in a band matrix. All elements have the same number of internal unknowns.
    pub fn band_order(&self) -> BandOrder {
        let per_element = self.internal.first().map_or(0, |blocks| blocks.block.nrows());
        BandOrder { per_node: B, nodes: self.nodes(), per_element }
    }

    /// Whether there are no unknowns.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether every entry is zero.
    pub fn is_zero(&self) -> bool {
        self.nodal.is_zero() && self.internal.iter().all(InternalBlocks::is_zero)
    }

    /// αA + βB for the matrices A and B of the same chain.
    pub fn combination(alpha: f64, a: &Self, beta: f64, b: &Self) -> Self {
        let mut nodal = BlockTridiagonal::zeros(a.nodes());
        nodal.add_scaled(alpha, &a.nodal);
        nodal.add_scaled(beta, &b.nodal);
        let pairs = a.internal.iter().zip(&b.internal);
        Self { nodal, internal: pairs.map(|(a, b)| a.times(alpha).plus(b.times(beta))).collect() }
    }

    /// Calls `visit(row, column, value)` for every stored entry.
    pub fn for_each(&self, mut visit: impl FnMut(usize, usize, f64)) {
        self.nodal.for_each(&mut visit);
        self.for_each_element(|nodes, own, blocks| {
            for i in 0..blocks.block.nrows() {
                for j in 0..blocks.block.nrows() {
                    visit(own + i, own + j, blocks.block[(i, j)]);
                }
                for (node, value) in blocks.coupling.iter().flat_map(|coupling| coupling.column(i)).enumerate() {
                    visit(nodes + node, own + i, *value);
                    visit(own + i, nodes + node, *value);
                }
            }
        });
    }

    /// Calls `visit` for every element with the index of the first unknown of its first node, the index of its first
    /// internal unknown, and its entries.
    #[inline(always)]
    fn for_each_element(&self, mut visit: impl FnMut(usize, usize, &InternalBlocks)) {
        let mut own = B * self.nodes();
        for (element, blocks) in self.internal.iter().enumerate() {
            visit(B * element, own, blocks);
            own += blocks.block.nrows();
        }
    }

    /// Calls `visit` with an unknown and a part of the value of the product with `x` there; a row of the product is the
    /// sum of its parts. Entries between nodes are left out.
    #[inline(always)]
    pub fn internal_product<const L: usize>(&self, x: &[f64], mut visit: impl FnMut(usize, [f64; L])) {
        self.for_each_element(|nodes, own, blocks| {
            for (i, column) in blocks.block.column_iter().enumerate() {
                visit(own + i, product(column.iter(), x, own));
            }
            if let Some(coupling) = &blocks.coupling {
                for (i, column) in coupling.column_iter().enumerate() {
                    visit(own + i, product(column.iter(), x, nodes));
                }
                for (node, row) in coupling.row_iter().enumerate() {
                    visit(nodes + node, product(row.iter(), x, own));
                }
            }
        });
    }

    /// `out += factor · self · x`.
    #[inline(always)]
    pub fn multiply_add<const L: usize>(&self, factor: f64, x: &[f64], out: &mut [f64]) {
        self.nodal.multiply_add::<L>(factor, x, out);
        self.internal_product::<L>(x, |unknown, values| {
            for (out, value) in out[unknown * L..].iter_mut().zip(values) {
                *out += factor * value;
            }
        });
    }

    /// xᵀ·self·x, summed over the lanes.
    pub fn quadratic_form<const L: usize>(&self, x: &[f64]) -> f64 {
        let mut sum = self.nodal.quadratic_form::<L>(x);
        self.internal_product::<L>(x, |unknown, values| {
            sum += values.iter().zip(&x[unknown * L..]).map(|(value, x)| value * x).sum::<f64>();
        });
        sum
    }

    /// Factorization of a positive definite matrix.
    ///
    /// # Errors
    /// [`NotPositiveDefinite`] with the node of a pivot block that is not positive definite, or with the first node of
    /// such an element.
    pub fn factor(&self) -> Result<ChainFactor<B>, NotPositiveDefinite> {
        if self.internal.is_empty() {
            return Ok(ChainFactor { nodal: self.nodal.factor()?, internal: Vec::new() });
        }
        let mut nodal = self.nodal.clone();
        let mut internal = Vec::with_capacity(self.internal.len());
        for (node, blocks) in self.internal.iter().enumerate() {
            let triangle = blocks.block.clone().cholesky().ok_or(NotPositiveDefinite { node })?.unpack();
            let mut coupling = DMatrix::zeros(0, 0);
            if let Some(entries) = &blocks.coupling {
                coupling = entries.transpose();
                triangle.solve_lower_triangular_mut(&mut coupling);
                let eliminated = coupling.tr_mul(&coupling);
                nodal.add_element(node, |i, j| -eliminated[(i, j)]);
            }
            internal.push(EliminatedElement { triangle, coupling });
        }
        Ok(ChainFactor { nodal: nodal.factor()?, internal })
    }
}

/// Values of Σ aᵢ x_{first + i} in each lane.
#[inline(always)]
fn product<'a, const L: usize>(a: impl Iterator<Item = &'a f64>, x: &[f64], first: usize) -> [f64; L] {
    let mut sum = [0.0; L];
    for (a, x) in a.zip(x[first * L..].chunks_exact(L)) {
        for (sum, x) in sum.iter_mut().zip(x) {
            *sum += a * x;
        }
    }
    sum
}

/// Factors of a [`ChainMatrix`]: of each element, and of the nodes after the elimination of the elements.
#[derive(Clone, Debug)]
pub struct ChainFactor<const B: usize> {
    nodal: BlockTridiagonalFactor<B>,
    internal: Vec<EliminatedElement>,
}

/// Factors of the internal unknowns of an element.
#[derive(Clone, Debug)]
struct EliminatedElement {
    /// Lower triangular L with the block LLᵀ between the m internal unknowns, m × m.
    triangle: DMatrix<f64>,
    /// L⁻¹Cᵀ of the coupling C, m × 2B; empty without coupling.
    coupling: DMatrix<f64>,
}

impl<const B: usize> ChainFactor<B> {
    /// Replaces the right-hand side `x` by the solution.
    #[inline(always)]
    pub fn solve<const L: usize>(&self, x: &mut [f64]) {
        if self.internal.is_empty() {
            return self.nodal.solve::<L>(x);
        }
        let (nodes, internal) = x.split_at_mut(B * L * (self.internal.len() + 1));
        let mut rest = &mut *internal;
        for (element, factors) in self.internal.iter().enumerate() {
            let own;
            (own, rest) = rest.split_at_mut(L * factors.triangle.nrows());
            factors.forward::<L>(own);
            for (node, column) in factors.coupling.column_iter().enumerate() {
                let values: [f64; L] = product(column.iter(), own, 0);
                for (x, value) in nodes[(B * element + node) * L..].iter_mut().zip(values) {
                    *x -= value;
                }
            }
        }
        self.nodal.solve::<L>(nodes);
        let mut rest = internal;
        for (element, factors) in self.internal.iter().enumerate() {
            let own;
            (own, rest) = rest.split_at_mut(L * factors.triangle.nrows());
            for (row, x) in factors.coupling.row_iter().zip(own.chunks_exact_mut(L)) {
                let values: [f64; L] = product(row.iter(), nodes, B * element);
                x.iter_mut().zip(values).for_each(|(x, value)| *x -= value);
            }
            factors.backward::<L>(own);
        }
    }
}

impl EliminatedElement {
    /// `x ← L⁻¹ x`.
    #[inline(always)]
    fn forward<const L: usize>(&self, x: &mut [f64]) {
        for (i, column) in self.triangle.column_iter().enumerate() {
            for lane in 0..L {
                let value = x[i * L + lane] / column[i];
                x[i * L + lane] = value;
                for j in i + 1..column.len() {
                    x[j * L + lane] -= column[j] * value;
                }
            }
        }
    }

    /// `x ← L⁻ᵀ x`.
    #[inline(always)]
    fn backward<const L: usize>(&self, x: &mut [f64]) {
        for (i, column) in self.triangle.column_iter().enumerate().rev() {
            for lane in 0..L {
                let sum: f64 = (i + 1..column.len()).map(|j| column[j] * x[j * L + lane]).sum();
                x[i * L + lane] = (x[i * L + lane] - sum) / column[i];
            }
        }
    }
}
