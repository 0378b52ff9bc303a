//! LU factorisation of small dense matrices, in place.
//!
//! Sums run over fixed lanes in plain arithmetic, so that results do not depend on the instruction set.

use pulp::{Arch, Simd, WithSimd};

use crate::linalg::product;

/// The loads of a stage: the first `coupled` of its `load_count` loads depend on the motion and are unknowns.
#[derive(Clone, Copy, Debug)]
pub struct StageUnknowns {
    pub coupled: usize,
    pub load_count: usize,
}

/// A linear system of fixed size. Solving it allocates no memory.
#[derive(Clone, Debug)]
pub struct SmallLu {
    size: usize,
    /// The matrix, row after row; after [`Self::factor`] its factors.
    matrix: Vec<f64>,
    /// Row with which each row was exchanged.
    pivots: Vec<usize>,
    /// Derivatives of all loads with respect to one scalar.
    slopes: Vec<f64>,
    /// The right-hand side; after [`Self::solve`] the solution.
    pub right: Vec<f64>,
    /// Instruction set of the processor.
    arch: Arch,
}

impl SmallLu {
    /// Allocates a system of `size` unknowns.
    pub fn new(size: usize) -> Self {
        Self {
            size,
            matrix: vec![0.0; size * size],
            pivots: vec![0; size],
            slopes: Vec::new(),
            right: vec![0.0; size],
            arch: Arch::new(),
        }
    }

    /// Sets the matrix to the identity.
    pub fn begin(&mut self) {
        self.matrix.fill(0.0);
        self.matrix.iter_mut().step_by(self.size + 1).for_each(|diagonal| *diagonal = 1.0);
    }

    /// Sets the matrix to the identity plus a sum of terms (row, factor, values): the factor times the values is added to
    /// the row.
    pub fn fill<'a>(&mut self, terms: impl Iterator<Item = (usize, f64, &'a [f64])>) {
        self.begin();
        // Most entries of the damping are zero: that of a bearing is in the matrices.
        for (row, factor, values) in terms.filter(|(_, factor, _)| *factor != 0.0) {
            add_scaled(&mut self.matrix[row * self.size..(row + 1) * self.size], factor, values);
        }
    }

    /// Scratch for the derivatives of all loads with respect to one scalar.
    pub fn slopes(&mut self, load_count: usize) -> &mut [f64] {
        self.slopes.resize(load_count, 0.0);
        &mut self.slopes
    }

    /// Subtracts from the rows of a stage, which begin at `first_row`, the [`Self::slopes`] of its loads over one scalar times
    /// the `response` of this scalar to each load.
    pub fn subtract_slopes(&mut self, first_row: usize, unknowns: StageUnknowns, response: impl Fn(usize) -> f64) {
        for k in 0..unknowns.coupled {
            self.subtract(first_row + k, self.slopes[k], unknowns, &response);
        }
    }

    /// Subtracts from one row `slope` times the `response` of a scalar to each unknown. The argument of `response` counts the
    /// loads of all stages.
    pub fn subtract(&mut self, row: usize, slope: f64, unknowns: StageUnknowns, response: impl Fn(usize) -> f64) {
        if slope != 0.0 {
            let line = &mut self.matrix[row * self.size..(row + 1) * self.size];
            for (stage, entries) in line.chunks_exact_mut(unknowns.coupled).enumerate() {
                for (k, entry) in entries.iter_mut().enumerate() {
                    *entry -= slope * response(stage * unknowns.load_count + k);
                }
            }
        }
    }

    /// Factorises the matrix and solves the system. Returns whether the matrix is regular.
    pub fn solve(&mut self) -> bool {
        let factored = self.factor();
        if factored {
            self.substitute();
        }
        factored
    }

    /// Factorises the matrix by elimination with partial pivoting. Returns whether it is regular.
    pub fn factor(&mut self) -> bool {
        let Self { size, matrix, pivots, arch, .. } = self;
        match *size {
            TWO_MESHES => factor(TWO_MESHES, matrix, pivots),
            size => arch.dispatch(Factor { size, matrix, pivots }),
        }
    }

    /// Solves the factorised system.
    pub fn substitute(&mut self) {
        let Self { size, matrix, pivots, right, arch, .. } = self;
        match *size {
            TWO_MESHES => substitute(TWO_MESHES, matrix, pivots, right),
            size => arch.dispatch(Substitute { size, matrix, pivots, right }),
        }
    }
}

/// Unknowns of two meshes at three stages. The compiler unrolls the loops for this size.
const TWO_MESHES: usize = 6;

struct Factor<'a> {
    size: usize,
    matrix: &'a mut [f64],
    pivots: &'a mut [usize],
}

impl WithSimd for Factor<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        factor(self.size, self.matrix, self.pivots)
    }
}

struct Substitute<'a> {
    size: usize,
    matrix: &'a [f64],
    pivots: &'a [usize],
    right: &'a mut [f64],
}

impl WithSimd for Substitute<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        substitute(self.size, self.matrix, self.pivots, self.right);
    }
}

/// Factorises a matrix of `n` rows in place.
#[inline(always)]
fn factor(n: usize, matrix: &mut [f64], pivots: &mut [usize]) -> bool {
    let (matrix, pivots) = (&mut matrix[..n * n], &mut pivots[..n]);
    for column in 0..n {
        let (mut pivot, mut value) = (column, 0.0_f64);
        for (row, line) in matrix.chunks_exact(n).enumerate().skip(column) {
            let entry = line[column];
            if entry.abs() >= value.abs() || entry.is_nan() {
                (pivot, value) = (row, entry);
            }
        }
        if value == 0.0 || !value.is_finite() {
            return false;
        }
        let (above, below) = matrix.split_at_mut((column + 1) * n);
        let line = &mut above[column * n..];
        if pivot != column {
            line.swap_with_slice(&mut below[(pivot - column - 1) * n..(pivot - column) * n]);
        }
        pivots[column] = pivot;
        for row in below.chunks_exact_mut(n) {
            let factor = row[column] / value;
            // The factor takes the place of the eliminated entry.
            row[column] = factor;
            if factor != 0.0 {
                add_scaled(&mut row[column + 1..], -factor, &line[column + 1..]);
            }
        }
    }
    true
}

/// Solves a factorised system of `n` unknowns in place.
#[inline(always)]
fn substitute(n: usize, matrix: &[f64], pivots: &[usize], right: &mut [f64]) {
    let (matrix, pivots, right) = (&matrix[..n * n], &pivots[..n], &mut right[..n]);
    for (column, pivot) in pivots.iter().enumerate() {
        right.swap(column, *pivot);
    }
    for (row, line) in matrix.chunks_exact(n.max(1)).enumerate() {
        let (known, unknown) = right.split_at_mut(row);
        unknown[0] -= product(&line[..row], known);
    }
    for (row, line) in matrix.chunks_exact(n.max(1)).enumerate().rev() {
        let (unknown, known) = right.split_at_mut(row + 1);
        unknown[row] = (unknown[row] - product(&line[row + 1..], known)) / line[row];
    }
}

/// `row += factor * values`.
#[inline(always)]
fn add_scaled(row: &mut [f64], factor: f64, values: &[f64]) {
    for (entry, value) in row.iter_mut().zip(values) {
        *entry += factor * value;
    }
}
