//! Complex matrices of chains of nodes, with entries between any two unknowns, and their sparse LU factors ([`super::sparse_lu`]).
//!
//! A chain is a band matrix. A mesh, or a bearing on a housing, couples unknowns of two chains. It may also act on a combination φᵀq
//! of unknowns, such as a bearing seat on the modes q of an elastic housing. Multiplied out, φΔφᵀ would fill the diagonal matrix of the
//! modes. Therefore the displacement s of the combination and the force g on it are unknowns of their own:
//!
//! ```text
//! D q + φ g = f
//!       Δ s + … − g = 0
//!       φᵀq − s = 0
//! ```
//!
//! The modes are eliminated first, in time proportional to their number times the square of the number of seats. The block of s and g
//! has the determinant −1 and one negative eigenvalue, so that the determinant changes its sign with each combination, and each adds
//! one negative eigenvalue (Haynsworth, Linear Algebra and its Applications 1, 1968).
//!
//! The order of elimination belongs to the [`Structure`] of a model and is the same at all frequencies and speeds. On the machines of
//! `examples/machines`, the factors take 70 to 430 µs. Solutions are improved by iterative refinement until their componentwise
//! backward error is that of round-off (Higham 2002, Accuracy and Stability of Numerical Algorithms, chapter 12); a solution that does
//! not reach it is an error.

use std::sync::Arc;

use num_complex::Complex64;

use super::band::Band;
use super::dense::ENTRY_ROUND_OFF;
use super::determinant::Determinant;
use super::minimum_degree::minimum_degree;
use super::sparse_lu::{Number, Singular};
use super::sparse_lu::{Pivots, SparseColumns, SparseLu};
use crate::numerics::SUM_ROUND_OFF;

/// Which system of equations is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// S x = f.
    Right,
    /// Sᵀ x = f.
    Left,
}

/// Matrix of one chain.
pub type BandChain = Band<Complex64>;

/// Componentwise backward error from which one refinement reaches round-off: it reduces the error a thousandfold or more.
const REFINED_ONCE: f64 = 1e-12;
/// Largest componentwise backward error of a solution.
pub const MAX_BACKWARD_ERROR: f64 = 1e-11;
/// Largest number of refinements. One is enough unless a pivot is small.
const MAX_REFINEMENTS: usize = 4;

/// What the matrices of one model have in common.
#[derive(Clone, Debug, Default)]
pub struct Structure {
    /// Combinations of coordinates, as entries (coordinate, coefficient).
    combinations: Vec<Vec<(usize, f64)>>,
    /// Order of elimination of the unknowns.
    order: Vec<usize>,
}

/// Matrices of chains, and entries between any two unknowns.
#[derive(Clone, Debug, Default)]
pub struct CoupledChains {
    structure: Arc<Structure>,
    /// Matrices of the chains, in the order of the coordinates.
    chains: Vec<BandChain>,
    /// First coordinate of each chain.
    starts: Vec<usize>,
    /// Entries (row, column, value) outside of the bands.
    couplings: Vec<(usize, usize, Complex64)>,
    /// Number of coordinates.
    size: usize,
}

impl CoupledChains {
    /// Without chains, for matrices of a structure.
    pub fn new(structure: Arc<Structure>) -> Self {
        Self { structure, ..Self::default() }
    }

    /// Appends the coordinates of a chain.
    pub fn push(&mut self, chain: BandChain) {
        self.starts.push(self.size);
        self.size += chain.size();
        self.chains.push(chain);
    }

    /// Number of unknowns: coordinates, and the displacement of each combination and the force on it.
    fn unknowns(&self) -> usize {
        self.size + 2 * self.structure.combinations.len()
    }

    /// The number under which `add` couples a combination of coordinates, given as entries (coordinate, coefficient). No chain is
    /// appended afterwards.
    pub fn combination(&mut self, entries: &[(usize, f64)]) -> usize {
        let known = self.structure.combinations.iter().position(|known| known == entries);
        self.size
            + 2 * known.unwrap_or_else(|| {
                Arc::make_mut(&mut self.structure).combinations.push(entries.to_vec());
                self.structure.combinations.len() - 1
            })
    }

    /// Adds `value` to the entry of two coordinates or combinations.
    pub fn add(&mut self, row: usize, column: usize, value: Complex64) {
        if row.max(column) < self.size {
            let chain = self.starts.partition_point(|start| *start <= row) - 1;
            let start = self.starts[chain];
            let matrix = &mut self.chains[chain];
            if column >= start && column < start + matrix.size() && matrix.contains(row - start, column - start) {
                return matrix.add(row - start, column - start, value);
            }
        }
        self.couplings.push((row, column, value));
    }

    /// Entries (row, column, value) of the chains, `couplings`, and those of combinations. Several may have one place.
    fn entries<'a>(
        &'a self,
        couplings: &'a [(usize, usize, Complex64)],
    ) -> impl Iterator<Item = (usize, usize, Complex64)> + 'a {
        let rows = |(chain, start): (&'a BandChain, &'a usize)| {
            (0..chain.size()).flat_map(move |row| {
                let (columns, entries) = chain.row(row);
                columns.zip(entries).map(move |(column, value)| (start + row, start + column, *value))
            })
        };
        let chains = self.chains.iter().zip(&self.starts).flat_map(rows);
        let combinations = self.structure.combinations.iter().enumerate().flat_map(move |(index, combination)| {
            let displacement = self.size + 2 * index;
            let force = displacement + 1;
            combination.iter().copied().chain([(displacement, -1.0)]).flat_map(move |(unknown, coefficient)| {
                let value = Complex64::from(coefficient);
                [(unknown, force, value), (force, unknown, value)]
            })
        });
        chains.filter(|(_, _, value)| *value != Complex64::ZERO).chain(couplings.iter().copied()).chain(combinations)
    }

    /// The couplings without those that cancel each other.
    fn sums(&self) -> Vec<(usize, usize, Complex64)> {
        let mut couplings = self.couplings.clone();
        couplings.sort_by_key(|(row, column, _)| (*row, *column));
        couplings.dedup_by(|next, sum| {
            let is_same = (next.0, next.1) == (sum.0, sum.1);
            if is_same {
                sum.2 += next.2;
            }
            is_same
        });
        couplings.retain(|(_, _, value)| *value != Complex64::ZERO);
        couplings
    }

    /// The structure of matrices with entries in the same places.
    pub fn structure(&self) -> Structure {
        let places: Vec<_> = self.entries(&self.couplings).map(|(row, column, _)| (row, column)).collect();
        let order = minimum_degree(self.unknowns(), &places);
        Structure { order, ..Structure::clone(&self.structure) }
    }

    /// The same matrix by columns, and the order of their elimination.
    fn columns(&self) -> (SparseColumns<Complex64>, Vec<usize>) {
        let couplings = self.sums();
        let columns = SparseColumns::new(self.unknowns(), || self.entries(&couplings));
        let mut order = self.structure.order.clone();
        if order.is_empty() {
            order = self.structure().order;
        }
        // Combinations that the structure does not have come last.
        order.extend(order.len()..self.unknowns());
        (columns, order)
    }

    /// LU factors.
    ///
    /// # Errors
    /// [`Singular`] if the matrix is singular.
    pub fn factor(self) -> Result<CoupledFactors, Singular> {
        let ((matrix, order), size) = (self.columns(), self.size);
        // The factors reuse the memory of the chains.
        drop(self);
        let factors = SparseLu::new(&matrix, order, Pivots::Threshold)?;
        Ok(CoupledFactors { size, matrix, factors })
    }

    /// Determinant.
    ///
    /// # Errors
    /// As [`Self::factor`].
    pub fn determinant(self) -> Result<Determinant, Singular> {
        let (matrix, order) = self.columns();
        let factors = SparseLu::new(&matrix, order, Pivots::Threshold)?;
        let is_odd = factors.is_odd() != (self.structure.combinations.len() % 2 == 1);
        let sign = Complex64::from(if is_odd { -1.0 } else { 1.0 });
        Ok(Determinant::product(factors.pivots().iter().copied().chain([sign])))
    }

    /// Number of negative eigenvalues of the matrix, Hermitian but for the scale of the coordinates; `None` where a pivot does not
    /// tell its sign (Sylvester's law of inertia; Golub and Van Loan, Matrix Computations, 4th ed., section 8.1.5).
    pub fn negative_eigenvalues(&self) -> Option<usize> {
        let (matrix, order) = self.columns();
        let negative = match matrix.real() {
            Some(real) => negative_pivots(&real, order),
            None => negative_pivots(&matrix, order),
        };
        negative?.checked_sub(self.structure.combinations.len())
    }
}

/// Number of negative pivots on the diagonal; `None` where a pivot is zero, or its imaginary part, which is round-off, hides the sign.
fn negative_pivots<T: Number>(matrix: &SparseColumns<T>, order: Vec<usize>) -> Option<usize> {
    let factors = SparseLu::new(matrix, order, Pivots::Diagonal).ok()?;
    let is_negative = |pivot: &T| (pivot.real().abs() > pivot.imaginary().abs()).then(|| pivot.real() < 0.0);
    factors.pivots().iter().map(is_negative).map(|negative| negative.map(usize::from)).sum()
}

/// LU factors of [`CoupledChains`].
#[derive(Clone, Debug)]
pub struct CoupledFactors {
    /// Number of coordinates.
    size: usize,
    matrix: SparseColumns<Complex64>,
    factors: SparseLu<Complex64>,
}

impl CoupledFactors {
    /// Replaces the right-hand side `x` by the solution, refined until the componentwise backward error is at most `tolerance`, or
    /// decreases no more. Returns the backward error, that before the last refinement if there was one.
    ///
    /// # Errors
    /// [`Singular`] if round-off leaves no accurate solution.
    pub fn solve_to(&self, side: Side, tolerance: f64, x: &mut [Complex64]) -> Result<f64, Singular> {
        let right = self.with_combinations(x);
        let mut solution = right.clone();
        self.solve_all(side, &mut solution);
        let error = self.refine(side, tolerance, &right, &mut solution)?;
        x.copy_from_slice(&solution[..self.size]);
        Ok(error)
    }

    /// Refines the solution `x` for all unknowns.
    fn refine(&self, side: Side, tolerance: f64, right: &[Complex64], x: &mut [Complex64]) -> Result<f64, Singular> {
        let mut previous = f64::INFINITY;
        for _ in 0..=MAX_REFINEMENTS {
            let (mut residual, error) = self.residual(side, right, x);
            if error <= tolerance.max(SUM_ROUND_OFF) || (error >= previous / 2.0 && error <= MAX_BACKWARD_ERROR) {
                return Ok(error);
            }
            if !error.is_finite() {
                return Err(Singular);
            }
            self.solve_all(side, &mut residual);
            x.iter_mut().zip(&residual).for_each(|(x, change)| *x += change);
            if error <= REFINED_ONCE {
                return Ok(error);
            }
            previous = error;
        }
        if previous <= MAX_BACKWARD_ERROR { Ok(previous) } else { Err(Singular) }
    }

    /// Replaces the right-hand side `x` by the solution, without refinement.
    pub fn solve_once(&self, side: Side, x: &mut [Complex64]) {
        let mut solution = self.with_combinations(x);
        self.solve_all(side, &mut solution);
        x.copy_from_slice(&solution[..self.size]);
    }

    /// Right-hand side of all unknowns.
    fn with_combinations(&self, right: &[Complex64]) -> Vec<Complex64> {
        let mut all = Vec::with_capacity(self.matrix.size());
        all.extend_from_slice(right);
        all.resize(self.matrix.size(), Complex64::ZERO);
        all
    }

    fn solve_all(&self, side: Side, x: &mut [Complex64]) {
        match side {
            Side::Right => self.factors.solve(x),
            Side::Left => self.factors.solve_transposed(x),
        }
    }

    /// Residual f − S x and the componentwise backward error max |f − S x|/(|S||x| + |f|) (Oettli and Prager, Numer. Math. 6,
    /// 1964), with f = `right`; of the other `side` with Sᵀ.
    fn residual(&self, side: Side, right: &[Complex64], x: &[Complex64]) -> (Vec<Complex64>, f64) {
        let largest = x[..self.size].iter().map(|value| value.l1_norm()).fold(0.0, f64::max);
        let floor = ENTRY_ROUND_OFF * largest;
        let mut residual = right.to_vec();
        let mut sizes: Vec<f64> = right.iter().map(|force| force.l1_norm()).collect();
        for column in 0..x.len() {
            for entry in self.matrix.column(column) {
                let (row, column) = match side {
                    Side::Right => (entry.row as usize, column),
                    Side::Left => (column, entry.row as usize),
                };
                let term = entry.value * x[column];
                residual[row] -= term;
                sizes[row] += term.l1_norm() + floor * entry.value.l1_norm();
            }
        }
        let ratios = residual.iter().zip(&sizes).filter(|(_, size)| **size != 0.0);
        let error = ratios.map(|(value, size)| value.l1_norm() / size);
        // f64::max would ignore NaN.
        let error = error.fold(0.0, |most, one| if one <= most { most } else { one });
        (residual, error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// A sum of matrices, and the same as one dense matrix.
    struct Sum {
        sparse: CoupledChains,
        dense: DMatrix<Complex64>,
    }

    impl Sum {
        /// Zero matrix of chains of these sizes and numbers of subdiagonals.
        fn zeros(chains: &[(usize, usize)]) -> Self {
            let mut sparse = CoupledChains::default();
            chains.iter().for_each(|(size, reach)| sparse.push(BandChain::zeros(*size, *reach)));
            let size = chains.iter().map(|(size, _)| size).sum();
            Self { sparse, dense: DMatrix::zeros(size, size) }
        }

        fn add(&mut self, row: usize, column: usize, value: Complex64) {
            self.sparse.add(row, column, value);
            self.dense[(row, column)] += value;
        }

        /// Adds a spring of this stiffness on Σ coefficient·coordinate; several entries of `row` are a combination if it is given.
        fn spring(&mut self, stiffness: f64, row: &[(usize, f64)], combined: &[(usize, f64)]) {
            let mut motions = row.to_vec();
            if !combined.is_empty() {
                motions.push((self.sparse.combination(combined), 1.0));
            }
            for (a, left) in &motions {
                motions
                    .iter()
                    .for_each(|(b, right)| self.sparse.add(*a, *b, Complex64::from(stiffness * left * right)));
            }
            let all: Vec<_> = row.iter().chain(combined).collect();
            for (a, left) in &all {
                all.iter().for_each(|(b, right)| self.dense[(*a, *b)] += Complex64::from(stiffness * left * right));
            }
        }

        /// A chain of springs of the stiffness 1 between `count` coordinates from `first` on, whose masses add `diagonal`.
        fn chain(&mut self, first: usize, count: usize, diagonal: f64) {
            for i in first..first + count {
                self.add(i, i, Complex64::from(diagonal));
                if i + 1 < first + count {
                    self.spring(1.0, &[(i, 1.0), (i + 1, -1.0)], &[]);
                }
            }
        }

        /// Compares solutions, determinant and number of negative eigenvalues with those of the dense matrix.
        fn check(self, counts: bool) -> Result<(), Singular> {
            let Self { sparse, dense } = self;
            let wanted = dense.determinant();
            let found = sparse.clone().determinant()?;
            let found = found.phase * found.logarithm.exp();
            assert!((found - wanted).norm() < 1e-10 * wanted.norm(), "{found} {wanted}");
            if counts {
                let negative = dense.symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count();
                assert_eq!(sparse.negative_eigenvalues(), Some(negative));
            }
            let right = DVector::from_fn(dense.nrows(), |i, _| Complex64::new(i as f64 - 3.0, 1.0));
            let factors = sparse.factor()?;
            for (side, dense) in [(Side::Right, dense.clone()), (Side::Left, dense.transpose())] {
                let mut x = right.clone();
                let error = factors.solve_to(side, 0.0, x.as_mut_slice())?;
                assert!(error < 1e-13, "{error}");
                let size = dense.norm() * x.norm() + right.norm();
                assert!((dense * x - &right).norm() < 1e-13 * size);
            }
            Ok(())
        }
    }

    #[test]
    fn coupled_chains_give_the_dense_matrix() -> Result<(), Singular> {
        let row = [(1, Complex64::ONE), (2, Complex64::new(0.5, 0.3)), (7, Complex64::new(-0.4, 1.0))];
        for stiffness in [-0.3, 0.7, 1.5, 2.0, 2.5, 4.0] {
            for couplings in [[0.0; 3], [0.3, -0.1, 0.0], [-0.5, 2.0, 1.0], [-1.0, -1.0, 0.2], [5.0, 5.0, -0.3]] {
                let mut sum = Sum::zeros(&[(5, 1), (4, 1)]);
                sum.chain(0, 5, stiffness);
                sum.chain(5, 4, stiffness - 0.37);
                for (force, shift) in couplings.into_iter().zip(0..) {
                    for (i, left) in row {
                        row.iter().for_each(|(j, right)| {
                            sum.add((i + shift) % 9, (j + shift) % 9, left * right.conj() * force)
                        });
                    }
                }
                sum.check(true)?;
            }
        }
        Ok(())
    }

    #[test]
    fn a_chain_that_is_singular_alone_is_solved() -> Result<(), Singular> {
        // At standstill every chain is free, and at 1 a chain of two is at its natural frequency: the springs between them hold it.
        for diagonal in [0.0, -1.0, -2.0, -3.0] {
            for stiffness in [1.0, 1e-3, 1e3] {
                let mut sum = Sum::zeros(&[(2, 1), (3, 1), (1, 0)]);
                sum.chain(0, 2, diagonal);
                sum.chain(2, 3, diagonal);
                sum.add(5, 5, Complex64::from(2.5));
                sum.spring(stiffness, &[(1, 1.0), (2, -1.0)], &[]);
                sum.spring(stiffness, &[(4, 1.0), (5, -1.0)], &[]);
                sum.check(false)?;
            }
        }
        Ok(())
    }

    #[test]
    fn twelve_equal_modes_are_counted() -> Result<(), Singular> {
        for diagonal in [-0.999_999, -1.000_001] {
            let mut sum = Sum::zeros(&[(3, 1); 12]);
            (0..12).for_each(|chain| sum.chain(3 * chain, 3, diagonal));
            (0..11).for_each(|chain| sum.spring(1e-9, &[(3 * chain, 1.0), (3 * chain + 5, -1.0)], &[]));
            sum.check(true)?;
        }
        Ok(())
    }

    /// A chain, and modes of a housing with the squares of natural frequencies 0, 1, …, with `seats` that the chain couples to.
    fn housed(shift: f64, modes: usize, seats: usize) -> Sum {
        let mut sum = Sum::zeros(&[(4, 1), (modes, 0)]);
        (0..4).for_each(|i| sum.add(i, i, Complex64::from(2.0 - shift)));
        (0..modes).for_each(|i| sum.add(4 + i, 4 + i, Complex64::from(i as f64 - shift)));
        for seat in 0..seats {
            let row: Vec<(usize, f64)> = (4..4 + modes).map(|i| (i, -((3 * i + 2 * seat) as f64).cos())).collect();
            sum.spring(1.0, &[(seat % 4, 1.0)], &row);
        }
        sum
    }

    #[test]
    fn seats_on_the_modes_of_a_housing_give_the_dense_matrix() -> Result<(), Singular> {
        // At 0 and 2 a mode is at its own natural frequency. Seven seats on five modes depend on each other.
        for (shift, seats) in [(0.0, 3), (2.0, 7), (0.3, 2), (3.7, 6), (-1.0, 7)] {
            housed(shift, 5, seats).check(shift.fract() != 0.0 || shift < 0.0)?;
        }
        housed(0.5, 1, 3).check(true)
    }

    #[test]
    fn factors_of_a_housing_are_proportional_to_its_modes() -> Result<(), Singular> {
        let entries = |modes: usize| Ok(housed(-1.0, modes, 3).sparse.factor()?.factors.entries());
        let [few, more, many] = [20, 40, 80].map(entries);
        let few: usize = few?;
        assert_eq!(many? - few, 3 * (more? - few));
        Ok(())
    }

    #[test]
    fn combinations_outside_of_the_structure_are_added() -> Result<(), Singular> {
        let Sum { sparse, dense } = housed(-1.0, 5, 2);
        let mut sum = Sum { sparse: CoupledChains { structure: Arc::new(sparse.structure()), ..sparse }, dense };
        sum.spring(0.5, &[(2, 1.0)], &[(4, 1.0), (6, 0.3)]);
        sum.check(true)
    }
}
