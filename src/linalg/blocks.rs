//! Square matrices of dense blocks, most of which are zero, and their elimination block by block.
//!
//! A block belongs to the coupled coordinates of one chain ([`super::couplings`]). The chain with the fewest neighbours is
//! eliminated first (minimum degree; George and Liu, SIAM Review 31, 1989), so that a train of many shafts fills few
//! blocks, and time is proportional to the number of shafts. Rows are exchanged within a block only.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use nalgebra::DMatrix;
use num_complex::Complex64;

use super::band::Singular;
use super::dense::ComplexLu;

/// A square matrix of blocks.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    /// Rows of each block, which are its columns too.
    parts: Vec<Range<usize>>,
    /// Blocks of each row of blocks that are not zero, by their column.
    rows: Vec<BTreeMap<usize, DMatrix<Complex64>>>,
}

impl Blocks {
    /// Zero matrix.
    pub fn zeros(parts: Vec<Range<usize>>) -> Self {
        Self { rows: vec![BTreeMap::new(); parts.len()], parts }
    }

    /// Number of rows.
    fn size(&self) -> usize {
        self.parts.last().map_or(0, |part| part.end)
    }

    /// The block of a row of blocks and a column of blocks.
    pub fn block(&mut self, row: usize, column: usize) -> &mut DMatrix<Complex64> {
        let [height, width] = [row, column].map(|part| self.parts[part].len());
        self.rows[row].entry(column).or_insert_with(|| DMatrix::zeros(height, width))
    }

    /// Adds `value` to an entry.
    pub fn add(&mut self, row: usize, column: usize, value: Complex64) {
        let part = |index: usize| self.parts.partition_point(|part| part.end <= index);
        let [above, left] = [part(row), part(column)];
        let first = [self.parts[above].start, self.parts[left].start];
        self.block(above, left)[(row - first[0], column - first[1])] += value;
    }

    /// Calls `visit(row, column, block)` for every block that is not zero.
    pub fn for_each(&self, mut visit: impl FnMut(usize, usize, &DMatrix<Complex64>)) {
        for (row, blocks) in self.rows.iter().enumerate() {
            blocks.iter().for_each(|(column, block)| visit(row, *column, block));
        }
    }

    /// The product with `x`.
    pub fn multiply(&self, x: &[Complex64]) -> Vec<Complex64> {
        let mut out = vec![Complex64::ZERO; x.len()];
        self.for_each(|row, column, block| {
            subtract(&mut out[self.parts[row].clone()], block, &x[self.parts[column].clone()], -Complex64::ONE);
        });
        out
    }

    /// The product of the transposed matrix with `x`.
    pub fn multiply_transposed(&self, x: &[Complex64]) -> Vec<Complex64> {
        let mut out = vec![Complex64::ZERO; x.len()];
        self.for_each(|row, column, block| {
            let (from, to) = (self.parts[row].clone(), self.parts[column].clone());
            subtract_transposed(&mut out[to], block, &x[from], -Complex64::ONE);
        });
        out
    }

    /// The same matrix as one block, whose elimination exchanges all rows.
    pub fn merged(&self) -> Self {
        let size = self.size();
        let mut whole = DMatrix::zeros(size, size);
        self.for_each(|row, column, block| {
            whole.view_mut((self.parts[row].start, self.parts[column].start), block.shape()).copy_from(block);
        });
        Self { parts: std::iter::once(0..size).collect(), rows: vec![BTreeMap::from([(0, whole)])] }
    }

    /// LU factors; `visit` is called with every block on the diagonal when all blocks before it are eliminated.
    ///
    /// # Errors
    /// [`Singular`] if such a block is singular.
    pub fn factor(mut self, mut visit: impl FnMut(&DMatrix<Complex64>)) -> Result<BlockFactors, Singular> {
        let mut neighbours = vec![BTreeSet::new(); self.parts.len()];
        self.for_each(|row, column, _| {
            if row != column {
                neighbours[row].insert(column);
                neighbours[column].insert(row);
            }
        });
        let degree = |parts: &[Range<usize>], neighbours: &BTreeSet<usize>| -> usize {
            neighbours.iter().map(|part| parts[*part].len()).sum()
        };
        let mut waiting: BTreeSet<(usize, usize)> =
            neighbours.iter().enumerate().map(|(part, own)| (degree(&self.parts, own), part)).collect();
        let mut steps = Vec::with_capacity(self.parts.len());
        while let Some((_, part)) = waiting.pop_first() {
            let mut upper = std::mem::take(&mut self.rows[part]);
            let pivot = upper.remove(&part).ok_or(Singular)?;
            visit(&pivot);
            let pivot = ComplexLu::new(&pivot);
            if !pivot.is_regular() {
                return Err(Singular);
            }
            upper.values_mut().for_each(|block| pivot.solve(block));
            let beside = std::mem::take(&mut neighbours[part]);
            let mut lower = Vec::new();
            for row in &beside {
                let Some(left) = self.rows[*row].remove(&part) else { continue };
                for (column, above) in &upper {
                    self.block(*row, *column).gemm(-Complex64::ONE, &left, above, Complex64::ONE);
                }
                lower.push((*row, left));
            }
            for row in &beside {
                waiting.remove(&(degree(&self.parts, &neighbours[*row]), *row));
                neighbours[*row].remove(&part);
                neighbours[*row].extend(beside.iter().filter(|other| *other != row));
                waiting.insert((degree(&self.parts, &neighbours[*row]), *row));
            }
            steps.push(Step { part, pivot, lower, upper: upper.into_iter().collect() });
        }
        Ok(BlockFactors { parts: self.parts, steps })
    }
}

/// Elimination of the rows of one block.
#[derive(Clone, Debug)]
struct Step {
    part: usize,
    /// Factors of the block D on the diagonal.
    pivot: ComplexLu,
    /// Blocks B of the rows that are eliminated later, by their row.
    lower: Vec<(usize, DMatrix<Complex64>)>,
    /// Blocks D⁻¹B of the columns that are eliminated later, by their column.
    upper: Vec<(usize, DMatrix<Complex64>)>,
}

/// LU factors of [`Blocks`].
#[derive(Clone, Debug)]
pub(super) struct BlockFactors {
    parts: Vec<Range<usize>>,
    steps: Vec<Step>,
}

impl BlockFactors {
    /// Replaces the right-hand side `x` by the solution.
    pub fn solve(&self, x: &mut [Complex64]) {
        for Step { part, pivot, lower, .. } in &self.steps {
            let own = self.solved(*part, x, |own| pivot.solve(own));
            lower
                .iter()
                .for_each(|(row, block)| subtract(&mut x[self.parts[*row].clone()], block, &own, Complex64::ONE));
        }
        for Step { part, upper, .. } in self.steps.iter().rev() {
            for (column, block) in upper {
                let known = x[self.parts[*column].clone()].to_vec();
                subtract(&mut x[self.parts[*part].clone()], block, &known, Complex64::ONE);
            }
        }
    }

    /// The same with the transposed matrix.
    pub fn solve_transposed(&self, x: &mut [Complex64]) {
        for Step { part, upper, .. } in &self.steps {
            let own = x[self.parts[*part].clone()].to_vec();
            for (column, block) in upper {
                subtract_transposed(&mut x[self.parts[*column].clone()], block, &own, Complex64::ONE);
            }
        }
        for Step { part, pivot, lower, .. } in self.steps.iter().rev() {
            for (row, block) in lower {
                let known = x[self.parts[*row].clone()].to_vec();
                subtract_transposed(&mut x[self.parts[*part].clone()], block, &known, Complex64::ONE);
            }
            self.solved(*part, x, |own| pivot.solve_transposed(own));
        }
    }

    /// Replaces the rows of a block by `solve` of them, and returns them.
    fn solved(&self, part: usize, x: &mut [Complex64], solve: impl Fn(&mut DMatrix<Complex64>)) -> Vec<Complex64> {
        let own = &mut x[self.parts[part].clone()];
        let mut solved = DMatrix::from_column_slice(own.len(), 1, own);
        solve(&mut solved);
        own.copy_from_slice(solved.as_slice());
        solved.data.into()
    }

    /// Numbers whose product is the determinant.
    pub fn pivots(&self) -> impl Iterator<Item = Complex64> + '_ {
        self.steps.iter().flat_map(|step| step.pivot.pivots())
    }
}

/// `out -= factor · block · x`.
fn subtract(out: &mut [Complex64], block: &DMatrix<Complex64>, x: &[Complex64], factor: Complex64) {
    for (column, x) in block.column_iter().zip(x) {
        let x = factor * x;
        out.iter_mut().zip(column.iter()).for_each(|(out, value)| *out -= value * x);
    }
}

/// `out -= factor · blockᵀ · x`.
fn subtract_transposed(out: &mut [Complex64], block: &DMatrix<Complex64>, x: &[Complex64], factor: Complex64) {
    for (column, out) in block.column_iter().zip(out) {
        *out -= factor * column.iter().zip(x).map(|(value, x)| value * x).sum::<Complex64>();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    /// A matrix of seven blocks in a ring with a branch, and the same as one dense matrix.
    fn matrix() -> (Blocks, DMatrix<Complex64>) {
        let sizes = [2, 1, 3, 2, 4, 1, 2];
        let ends = sizes.iter().scan(0, |end, size| {
            *end += size;
            Some(*end)
        });
        let parts: Vec<Range<usize>> = ends.zip(sizes).map(|(end, size)| end - size..end).collect();
        let size = parts[6].end;
        let (mut blocks, mut dense) = (Blocks::zeros(parts.clone()), DMatrix::zeros(size, size));
        let pairs = (0..6).map(|part| (part, (part + 1) % 6)).chain([(2, 6)]);
        for (a, b) in pairs.flat_map(|(a, b)| [(a, b), (b, a), (a, a), (b, b)]) {
            for row in parts[a].clone() {
                for column in parts[b].clone() {
                    let angle = (7 * row + 3 * column) as f64;
                    let value = Complex64::new(angle.sin(), (1.3 * angle).cos()) * if a == b { 2.0 } else { 1.0 };
                    blocks.add(row, column, value);
                    dense[(row, column)] += value;
                }
            }
        }
        (blocks, dense)
    }

    #[test]
    fn solutions_products_and_the_determinant_are_those_of_the_dense_matrix() -> Result<(), Singular> {
        let (blocks, dense) = matrix();
        let right = DVector::from_fn(dense.nrows(), |row, _| Complex64::new(row as f64 - 4.0, 1.0));
        assert!((DVector::from_vec(blocks.multiply(right.as_slice())) - &dense * &right).norm() < 1e-12);
        let transposed = DVector::from_vec(blocks.multiply_transposed(right.as_slice()));
        assert!((transposed - dense.tr_mul(&right)).norm() < 1e-12);
        for factors in [blocks.clone().factor(|_| {})?, blocks.merged().factor(|_| {})?] {
            let mut x = right.clone();
            factors.solve(x.as_mut_slice());
            assert!((&dense * &x - &right).norm() < 1e-11 * right.norm());
            let mut x = right.clone();
            factors.solve_transposed(x.as_mut_slice());
            assert!((dense.tr_mul(&x) - &right).norm() < 1e-11 * right.norm());
            let determinant: Complex64 = factors.pivots().product();
            let wanted = dense.determinant();
            assert!((determinant - wanted).norm() < 1e-11 * wanted.norm());
        }
        Ok(())
    }

    #[test]
    fn a_chain_of_blocks_fills_none() -> Result<(), Singular> {
        let parts: Vec<Range<usize>> = (0..50).map(|part| part..part + 1).collect();
        let mut blocks = Blocks::zeros(parts);
        for row in 0..50_usize {
            blocks.add(row, row, Complex64::new(3.0, 0.0));
            for other in [row + 1, row.wrapping_sub(1)].into_iter().filter(|other| *other < 50) {
                blocks.add(row, other, -Complex64::ONE);
            }
        }
        let factors = blocks.factor(|_| {})?;
        assert_eq!(factors.steps.iter().map(|step| step.upper.len()).sum::<usize>(), 49);
        Ok(())
    }
}
