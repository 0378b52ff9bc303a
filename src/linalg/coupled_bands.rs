//! Complex band matrices, one for each chain of nodes, that a few coordinates couple.
//!
//! ```text
//! S = A + E Δ Eᵀ,    A = diag(A_1, A_2, …)
//! ```
//!
//! The columns of E are unit vectors, one for each of the r coordinates that belong to a coupling, and Δ is r × r. With the
//! LU factors of each A_c, the solution of S x = f is (Woodbury; Golub and Van Loan, Matrix Computations, 4th ed.,
//! section 2.1.4)
//!
//! ```text
//! x = A⁻¹f − A⁻¹E Δ (I + Z Δ)⁻¹ Eᵀ A⁻¹f,    Z = Eᵀ A⁻¹ E.
//! ```
//!
//! It takes time proportional to the number of rows plus r³.
//!
//! Without the couplings a chain may be singular, although S is not: a free shaft at standstill, or a shaft at one of its
//! own natural frequencies. Therefore A_c contains a damper on every coupled coordinate, an imaginary entry of the size of
//! the couplings, and Δ has its negative. A natural mode of a chain at a real frequency then makes A_c singular only if it
//! moves no coupled coordinate; such a mode makes S singular too. Every solution is improved by iterative refinement until
//! its componentwise backward error is that of round-off (Higham 2002, Accuracy and Stability of Numerical Algorithms,
//! chapter 12); a solution that does not reach it is an error.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use num_complex::Complex64;

use super::band::{Band, BandLu, Singular};
use super::dense::ComplexLu;

/// Matrix of one chain.
pub type BandChain = Band<Complex64>;
/// LU factors of one chain.
type ChainFactors = BandLu<Complex64>;

/// Componentwise backward error at which refinement ends.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;
/// Largest componentwise backward error of a solution.
const MAX_BACKWARD_ERROR: f64 = 1e-11;
/// Fraction of ‖S_i‖‖x‖∞ that is added to |S_i||x| of each row i: an entry of x that is zero up to round-off has no
/// relative accuracy.
const NEGLIGIBLE: f64 = 1e-8;
/// Largest number of refinements. One is enough unless a chain is close to singular.
const MAX_REFINEMENTS: usize = 4;

/// A determinant as a phase factor and the logarithm of its magnitude, which neither overflow nor underflow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Determinant {
    /// Number of magnitude one.
    pub phase: Complex64,
    /// Natural logarithm of the magnitude.
    pub logarithm: f64,
}

impl Determinant {
    /// Product of numbers.
    pub fn product(factors: impl Iterator<Item = Complex64>) -> Self {
        let one = Self { phase: Complex64::ONE, logarithm: 0.0 };
        factors.fold(one, |product, factor| {
            let size = factor.norm();
            Self { phase: product.phase * (factor / size), logarithm: product.logarithm + size.ln() }
        })
    }

    fn times(self, other: Self) -> Self {
        Self { phase: self.phase * other.phase, logarithm: self.logarithm + other.logarithm }
    }
}

/// Band matrices and their couplings.
#[derive(Clone, Debug, Default)]
pub struct CoupledBands {
    /// Matrices of the chains, in the order of the coordinates.
    chains: Vec<BandChain>,
    /// First coordinate of each chain.
    starts: Vec<usize>,
    /// Entries (row, column) outside of the bands.
    couplings: BTreeMap<(usize, usize), Complex64>,
    /// Number of coordinates.
    size: usize,
}

impl CoupledBands {
    /// Appends the coordinates of a chain.
    pub fn push(&mut self, chain: BandChain) {
        self.starts.push(self.size);
        self.size += chain.size();
        self.chains.push(chain);
    }

    /// Number of coordinates.
    pub fn size(&self) -> usize {
        self.size
    }

    fn chain_of(&self, coordinate: usize) -> usize {
        self.starts.partition_point(|start| *start <= coordinate) - 1
    }

    /// Adds `value` to the entry (`row`, `column`).
    pub fn add(&mut self, row: usize, column: usize, value: Complex64) {
        let chain = self.chain_of(row);
        let start = self.starts[chain];
        let matrix = &mut self.chains[chain];
        if column >= start && column < start + matrix.size() && matrix.contains(row - start, column - start) {
            matrix.add(row - start, column - start, value);
        } else {
            *self.couplings.entry((row, column)).or_default() += value;
        }
    }

    /// Calls `visit(row, column, value)` for every entry.
    #[inline]
    fn for_each(&self, mut visit: impl FnMut(usize, usize, Complex64)) {
        for (chain, start) in self.chains.iter().zip(&self.starts) {
            chain.for_each(|row, column, value| visit(start + row, start + column, value));
        }
        self.couplings.iter().for_each(|((row, column), value)| visit(*row, *column, *value));
    }

    /// LU factors. `sense` is the sign of the imaginary damper entries: that of the damping of the system.
    ///
    /// # Errors
    /// [`Singular`] if the matrix, or a chain with dampers, is singular.
    pub fn factor(self, sense: f64) -> Result<CoupledFactors, Singular> {
        let mut sizes: BTreeMap<usize, f64> = BTreeMap::new();
        for ((row, column), value) in self.couplings.iter().filter(|(_, value)| **value != Complex64::ZERO) {
            *sizes.entry(*row).or_default() += value.norm();
            // A coordinate of which the others only read is coupled too.
            sizes.entry(*column).or_default();
        }
        let coordinates: Vec<usize> = sizes.keys().copied().collect();
        let mut coupling = DMatrix::zeros(coordinates.len(), coordinates.len());
        let place = |coordinate: &usize| coordinates.binary_search(coordinate);
        for ((row, column), value) in &self.couplings {
            if let (Ok(i), Ok(j)) = (place(row), place(column)) {
                coupling[(i, j)] += value;
            }
        }
        let mut damped = self.chains.clone();
        for (i, (coordinate, size)) in sizes.iter().enumerate() {
            let damper = Complex64::new(0.0, size * sense);
            let chain = self.chain_of(*coordinate);
            let row = coordinate - self.starts[chain];
            damped[chain].add(row, row, damper);
            coupling[(i, i)] -= damper;
        }
        let chains = damped.iter().map(BandChain::factor).collect::<Result<Vec<_>, _>>()?;
        let mut receptance = DMatrix::zeros(coordinates.len(), coordinates.len());
        let mut columns = Vec::with_capacity(coordinates.len());
        for (j, coordinate) in coordinates.iter().enumerate() {
            let chain = self.chain_of(*coordinate);
            let start = self.starts[chain];
            let mut column = vec![Complex64::ZERO; self.chains[chain].size()];
            column[coordinate - start] = Complex64::ONE;
            chains[chain].solve(&mut column);
            for (i, other) in coordinates.iter().enumerate() {
                if let Some(value) = other.checked_sub(start).and_then(|row| column.get(row)) {
                    receptance[(i, j)] = *value;
                }
            }
            columns.push(column);
        }
        let capacity = DMatrix::identity(coordinates.len(), coordinates.len()) + receptance * &coupling;
        let capacity = ComplexLu::new(&capacity);
        if !capacity.is_regular() {
            return Err(Singular);
        }
        Ok(CoupledFactors { matrix: self, chains, coordinates, coupling, columns, capacity })
    }
}

/// LU factors of [`CoupledBands`].
#[derive(Clone, Debug)]
pub struct CoupledFactors {
    matrix: CoupledBands,
    /// Factors of the chains with dampers.
    chains: Vec<ChainFactors>,
    /// Coupled coordinates, ascending, r entries.
    coordinates: Vec<usize>,
    /// Δ without the dampers, r × r.
    coupling: DMatrix<Complex64>,
    /// Columns of A⁻¹E, each over the coordinates of its chain.
    columns: Vec<Vec<Complex64>>,
    /// Factors of I + Z Δ, r × r.
    capacity: ComplexLu,
}

impl CoupledFactors {
    /// Replaces the right-hand side `x` by the solution.
    ///
    /// # Errors
    /// [`Singular`] if round-off leaves no accurate solution.
    pub fn solve(&self, x: &mut [Complex64]) -> Result<(), Singular> {
        let right = x.to_vec();
        self.solve_once(x);
        let mut previous = f64::INFINITY;
        for _ in 0..=MAX_REFINEMENTS {
            let (mut residual, error) = self.residual(&right, x);
            if error <= ROUND_OFF || (error >= previous / 2.0 && error <= MAX_BACKWARD_ERROR) {
                return Ok(());
            }
            if !error.is_finite() {
                return Err(Singular);
            }
            previous = error;
            self.solve_once(&mut residual);
            x.iter_mut().zip(&residual).for_each(|(x, change)| *x += change);
        }
        if previous <= MAX_BACKWARD_ERROR { Ok(()) } else { Err(Singular) }
    }

    /// Replaces the right-hand side `x` by the solution, without refinement.
    pub fn solve_once(&self, x: &mut [Complex64]) {
        let mut rest = &mut *x;
        for (chain, matrix) in self.chains.iter().zip(&self.matrix.chains) {
            let (own, next) = rest.split_at_mut(matrix.size());
            chain.solve(own);
            rest = next;
        }
        if self.coordinates.is_empty() {
            return;
        }
        let mut coupled =
            DMatrix::from_iterator(self.coordinates.len(), 1, self.coordinates.iter().map(|coordinate| x[*coordinate]));
        self.capacity.solve(&mut coupled);
        let forces = &self.coupling * coupled;
        for ((coordinate, column), force) in self.coordinates.iter().zip(&self.columns).zip(forces.iter()) {
            let start = self.matrix.starts[self.matrix.chain_of(*coordinate)];
            for (x, value) in x[start..].iter_mut().zip(column) {
                *x -= value * force;
            }
        }
    }

    /// Residual f − S x and the componentwise backward error max |f − S x|/(|S||x| + |f|), with f = `right`.
    fn residual(&self, right: &[Complex64], x: &[Complex64]) -> (Vec<Complex64>, f64) {
        let mut residual = right.to_vec();
        let mut sizes: Vec<f64> = right.iter().map(|value| value.l1_norm()).collect();
        let floor = NEGLIGIBLE * x.iter().map(|value| value.l1_norm()).fold(0.0, f64::max);
        self.matrix.for_each(|row, column, value| {
            let term = value * x[column];
            residual[row] -= term;
            sizes[row] += term.l1_norm() + floor * value.l1_norm();
        });
        let ratios = residual.iter().zip(&sizes).filter(|(_, size)| **size != 0.0);
        let error = ratios.map(|(value, size)| value.l1_norm() / size);
        // f64::max would ignore NaN.
        let error = error.fold(0.0, |most, one| if one <= most { most } else { one });
        (residual, error)
    }

    /// Determinant of S.
    pub fn determinant(&self) -> Determinant {
        let chains = self.chains.iter().map(|factors| Determinant::product(factors.pivots()));
        chains.fold(Determinant::product(self.capacity.pivots()), Determinant::times)
    }
}
