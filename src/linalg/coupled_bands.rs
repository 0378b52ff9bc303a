//! Complex band matrices, one for each chain of nodes, that a few coordinates couple.
//!
//! ```text
//! S = A + E Δ Eᵀ,    A = diag(A_1, A_2, …)
//! ```
//!
//! The columns of E are the r coupled motions, and Δ is r × r. A motion is a coordinate, a unit vector, or a combination of the
//! coordinates of one chain, such as a bearing seat on the modes of an elastic housing, which have a diagonal A_c: they cost
//! the number of modes times the square of the number of seats. With the LU factors of each A_c, the solution of S x = f is
//! (Woodbury; Golub and Van Loan, Matrix Computations, 4th ed., section 2.1.4)
//!
//! ```text
//! x = A⁻¹f − A⁻¹E Δ (I + Z Δ)⁻¹ Eᵀ A⁻¹f,    Z = Eᵀ A⁻¹ E.
//! ```
//!
//! I + ZΔ has a block for each chain ([`super::blocks`]), so that the time is proportional to the number of rows and chains. A
//! general sparse LU (supernodal, columns ordered by COLAMD, one symbolic analysis for all frequencies) takes 0.8 to 2.7 times as
//! long with assembly on the machines of `examples/machines`, and needs a refinement of its own: on two of them it leaves
//! backward errors of 5e-7 and 9e-6.
//!
//! Without the couplings a chain may be singular, although S is not: a free shaft at standstill, or a shaft at one of its
//! own natural frequencies. Therefore A_c contains a damper on every coupled coordinate, an imaginary entry of the size of
//! the couplings, and Δ has its negative. Of the coordinates of a combination, only those with a small entry on the diagonal have
//! one: a mode of a housing at its own natural frequency becomes a coupled coordinate. A natural mode of a chain at a real frequency then makes A_c singular only if it
//! moves no coupled coordinate; such a mode makes S singular too. Every solution is improved by iterative refinement until
//! its componentwise backward error is that of round-off (Higham 2002, Accuracy and Stability of Numerical Algorithms,
//! chapter 12); a solution that does not reach it is an error.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::DMatrix;
use num_complex::Complex64;

use super::band::{Band, BandLu, Number, Singular};
use super::blocks::{BlockFactors, Blocks};
use super::couplings::{Couplings, Motion, chain_of};
use super::dense::ENTRY_ROUND_OFF;
use super::determinant::Determinant;
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
/// LU factors of one chain.
type ChainFactors = BandLu<Complex64>;

/// Componentwise backward error from which one refinement reaches round-off: it reduces the error a thousandfold or more.
const REFINED_ONCE: f64 = 1e-12;
/// Largest componentwise backward error of a solution.
pub const MAX_BACKWARD_ERROR: f64 = 1e-11;
/// Largest number of refinements. One is enough unless a chain is close to singular.
const MAX_REFINEMENTS: usize = 4;

/// Band matrices and their couplings.
#[derive(Clone, Debug, Default)]
pub struct CoupledBands {
    /// Matrices of the chains, in the order of the coordinates.
    pub(super) chains: Vec<BandChain>,
    /// First coordinate of each chain.
    pub(super) starts: Vec<usize>,
    /// Entries (row, column) between motions outside of the bands. The numbers from `size` on are those of `combinations`.
    pub(super) couplings: BTreeMap<(usize, usize), Complex64>,
    /// Combinations of the coordinates of chains whose other entries are on the diagonal.
    pub(super) combinations: Vec<Motion>,
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

    /// The number under which `add` couples a combination of coordinates of one chain, given as entries (coordinate, coefficient).
    /// The matrix of the chain has no entries between these coordinates, and no chain is appended afterwards.
    pub fn combination(&mut self, entries: &[(usize, f64)]) -> usize {
        let indices = || entries.iter().map(|(index, _)| *index);
        let (first, last) = (indices().min().unwrap_or(0), indices().max().unwrap_or(0));
        let mut coefficients = vec![0.0; last + 1 - first];
        entries.iter().for_each(|(index, coefficient)| coefficients[index - first] += coefficient);
        let chain = chain_of(&self.starts, first);
        let motion = Motion { chain, first: first - self.starts[chain], coefficients: coefficients.into() };
        let known = self.combinations.iter().position(|known| *known == motion);
        self.size
            + known.unwrap_or_else(|| {
                self.combinations.push(motion);
                self.combinations.len() - 1
            })
    }

    /// The chain of the motion of a number.
    pub(super) fn chain(&self, number: usize) -> usize {
        match number.checked_sub(self.size) {
            Some(combination) => self.combinations[combination].chain,
            None => chain_of(&self.starts, number),
        }
    }

    /// The motion of a number.
    pub(super) fn motion(&self, number: usize) -> Motion {
        if let Some(combination) = number.checked_sub(self.size) {
            return self.combinations[combination].clone();
        }
        let chain = chain_of(&self.starts, number);
        Motion { chain, first: number - self.starts[chain], coefficients: Arc::new([1.0]) }
    }

    /// Adds `value` to the entry of two coordinates or combinations.
    pub fn add(&mut self, row: usize, column: usize, value: Complex64) {
        if row.max(column) >= self.size {
            *self.couplings.entry((row, column)).or_default() += value;
            return;
        }
        let chain = chain_of(&self.starts, row);
        let start = self.starts[chain];
        let matrix = &mut self.chains[chain];
        if column >= start && column < start + matrix.size() && matrix.contains(row - start, column - start) {
            matrix.add(row - start, column - start, value);
        } else {
            *self.couplings.entry((row, column)).or_default() += value;
        }
    }

    /// LU factors. `sense` is the sign of the imaginary damper entries: that of the damping of the system.
    ///
    /// # Errors
    /// [`Singular`] if the matrix, or a chain with dampers, is singular.
    pub fn factor(self, sense: f64) -> Result<CoupledFactors, Singular> {
        let couplings = Couplings::new(&self, Complex64::new(0.0, sense));
        let chains = couplings.factor_chains(self.chains.clone())?;
        let columns = couplings.columns(&chains, true);
        let capacity = couplings.factor_capacity(&columns, false)?;
        let row_sizes = self.row_sizes();
        Ok(CoupledFactors { matrix: self, row_sizes, chains, couplings, columns, capacity })
    }

    /// Determinant; `sense` is that of [`Self::factor`]. It takes about half the time of the factors.
    ///
    /// # Errors
    /// As [`Self::factor`].
    pub fn determinant(self, sense: f64) -> Result<Determinant, Singular> {
        let couplings = Couplings::new(&self, Complex64::new(0.0, sense));
        let chains = couplings.factor_chains(self.chains)?;
        let columns = couplings.columns(&chains, false);
        let capacity = couplings.factor_capacity(&columns, false)?;
        let chains = chains.iter().flat_map(BandLu::pivots);
        Ok(Determinant::product(chains.chain(capacity.pivots())))
    }

    /// Number of negative eigenvalues of the matrix, Hermitian but for the scale of the coordinates; `None` where a pivot does not
    /// tell its sign.
    ///
    /// With the inertia of A, that of S follows from Z of the solution above: motions x with EᵀA⁻¹x = 0 have the same form with
    /// both inverses, so that S has as many negative eigenvalues more than A as Z + ZΔZ has more than Z.
    pub fn negative_eigenvalues(&self) -> Option<usize> {
        match self.chains.iter().map(BandChain::real).collect::<Option<Vec<_>>>() {
            Some(real) => self.negative_with(real),
            None => self.negative_with(self.chains.clone()),
        }
    }

    /// The same with the matrices of the chains.
    fn negative_with<T: Number>(&self, chains: Vec<Band<T>>) -> Option<usize> {
        let chains: Vec<BandLu<T>> =
            chains.into_iter().map(Band::factor_without_exchanges).collect::<Result<_, _>>().ok()?;
        let mut count = 0;
        for pivot in chains.iter().flat_map(BandLu::pivots) {
            count += usize::from(is_negative(pivot)?);
        }
        let couplings = Couplings::new(self, Complex64::ZERO).of_independent_motions();
        let receptances = couplings.receptances(&couplings.columns(&chains, false));
        let own: usize = receptances.iter().map(|block| negative_pivots(block.clone())).sum::<Option<usize>>()?;
        (count + negative_eigenvalues(couplings.form(&receptances))?).checked_sub(own)
    }

    /// Sum of the magnitudes of the entries of each row.
    fn row_sizes(&self) -> Vec<f64> {
        let rows = self.chains.iter().flat_map(|chain| (0..chain.size()).map(|row| chain.row(row).1));
        let mut sizes: Vec<f64> = rows.map(|entries| entries.iter().map(|value| value.l1_norm()).sum()).collect();
        let mut of_combinations = vec![0.0; self.combinations.len()];
        for ((row, column), value) in &self.couplings {
            let width = column.checked_sub(self.size).map_or(1.0, |index| {
                self.combinations[index].coefficients.iter().map(|coefficient| coefficient.abs()).sum()
            });
            *sizes.get_mut(*row).unwrap_or_else(|| &mut of_combinations[*row - self.size]) += value.l1_norm() * width;
        }
        self.add_sizes(&of_combinations, &mut sizes);
        sizes
    }

    /// Adds the sizes of forces along the combinations to those of the rows.
    fn add_sizes(&self, of_combinations: &[f64], sizes: &mut [f64]) {
        for (Motion { chain, first, coefficients }, size) in self.combinations.iter().zip(of_combinations) {
            let own = &mut sizes[self.starts[*chain] + first..];
            own.iter_mut().zip(&**coefficients).for_each(|(own, coefficient)| *own += coefficient.abs() * size);
        }
    }
}

/// Number of negative eigenvalues of a matrix whose blocks on the diagonal are Hermitian, and the others but for the scale of
/// the coordinates: that of all blocks on the diagonal when the blocks before them are eliminated.
fn negative_eigenvalues(form: Blocks) -> Option<usize> {
    let mut count = Some(0);
    form.factor(|pivot| count = count.and_then(|sum| Some(sum + negative_pivots(pivot.clone())?))).ok()?;
    count
}

/// Number of negative eigenvalues of a Hermitian matrix; `None` where a pivot does not tell its sign.
fn negative_pivots(mut form: DMatrix<Complex64>) -> Option<usize> {
    let mut count = 0;
    for k in 0..form.nrows() {
        let pivot = form[(k, k)];
        count += usize::from(is_negative(pivot)?);
        for i in k + 1..form.nrows() {
            let factor = form[(i, k)] / pivot;
            for j in k + 1..form.nrows() {
                let change = factor * form[(k, j)];
                form[(i, j)] -= change;
            }
        }
    }
    Some(count)
}

/// Whether a pivot of a Hermitian matrix is negative; `None` where its imaginary part, which is round-off, hides the sign.
fn is_negative<T: Number>(pivot: T) -> Option<bool> {
    (pivot.is_finite() && pivot.real().abs() > pivot.imaginary().abs()).then(|| pivot.real() < 0.0)
}

/// LU factors of [`CoupledBands`].
#[derive(Clone, Debug)]
pub struct CoupledFactors {
    matrix: CoupledBands,
    /// Sum of the magnitudes of the entries of each row of S.
    row_sizes: Vec<f64>,
    /// Factors of the chains with dampers.
    chains: Vec<ChainFactors>,
    couplings: Couplings,
    /// Columns of A⁻¹E, each over the coordinates of its chain.
    columns: Vec<Vec<Complex64>>,
    /// Factors of I + Z Δ, r × r.
    capacity: BlockFactors,
}

impl CoupledFactors {
    /// Replaces the right-hand side `x` by the solution, refined until the componentwise backward error is at most `tolerance`, or decreases no more. Returns the
    /// backward error, that before the last refinement if there was one.
    ///
    /// # Errors
    /// [`Singular`] if round-off leaves no accurate solution.
    pub fn solve_to(&self, side: Side, tolerance: f64, x: &mut [Complex64]) -> Result<f64, Singular> {
        let right = x.to_vec();
        self.refine(side, tolerance, &right, x).or_else(|_| {
            let capacity = self.couplings.factor_capacity(&self.columns, true)?;
            x.copy_from_slice(&right);
            Self { capacity, ..self.clone() }.refine(side, tolerance, &right, x)
        })
    }

    /// The same, with the exchanges of rows of these factors.
    fn refine(&self, side: Side, tolerance: f64, right: &[Complex64], x: &mut [Complex64]) -> Result<f64, Singular> {
        self.solve_once(side, x);
        let mut previous = f64::INFINITY;
        for _ in 0..=MAX_REFINEMENTS {
            let (mut residual, error) = self.residual(side, right, x);
            if error <= tolerance.max(SUM_ROUND_OFF) || (error >= previous / 2.0 && error <= MAX_BACKWARD_ERROR) {
                return Ok(error);
            }
            if !error.is_finite() {
                return Err(Singular);
            }
            self.solve_once(side, &mut residual);
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
        let starts = &self.matrix.starts;
        if side == Side::Left {
            return self.solve_transposed(x);
        }
        for (chain, start) in self.chains.iter().zip(starts) {
            chain.solve(&mut x[*start..start + chain.size()]);
        }
        let Couplings { motions, matrix, .. } = &self.couplings;
        let mut coupled: Vec<Complex64> =
            motions.iter().map(|motion| motion.value(&x[starts[motion.chain]..])).collect();
        self.capacity.solve(&mut coupled);
        let forces = matrix.multiply(&coupled);
        for ((motion, column), force) in motions.iter().zip(&self.columns).zip(forces.iter()) {
            for (x, value) in x[starts[motion.chain]..].iter_mut().zip(column) {
                *x -= value * force;
            }
        }
    }

    /// The same with Sᵀ: x = A⁻ᵀ(f − E (I + ZΔ)⁻ᵀ Δᵀ (A⁻¹E)ᵀ f).
    fn solve_transposed(&self, x: &mut [Complex64]) {
        let starts = &self.matrix.starts;
        let Couplings { motions, matrix, .. } = &self.couplings;
        let product = |(motion, column): (&Motion, &Vec<Complex64>)| {
            x[starts[motion.chain]..].iter().zip(column).map(|(x, value)| x * value).sum::<Complex64>()
        };
        let read: Vec<Complex64> = motions.iter().zip(&self.columns).map(product).collect();
        let mut forces = matrix.multiply_transposed(&read);
        self.capacity.solve_transposed(&mut forces);
        motions.iter().zip(forces).for_each(|(motion, force)| motion.subtract(force, &mut x[starts[motion.chain]..]));
        for (chain, start) in self.chains.iter().zip(starts) {
            chain.solve_transposed(&mut x[*start..start + chain.size()]);
        }
    }

    /// Componentwise backward error max |f − S x|/(|S||x| + |f|) of a solution x, with f = `right` (Oettli and Prager, Numer.
    /// Math. 6, 1964).
    pub fn backward_error(&self, right: &[Complex64], x: &[Complex64]) -> f64 {
        self.residual(Side::Right, right, x).1
    }

    /// Residual f − S x and the componentwise backward error max |f − S x|/(|S||x| + |f|), with f = `right`; of the other `side`
    /// with Sᵀ.
    fn residual(&self, side: Side, right: &[Complex64], x: &[Complex64]) -> (Vec<Complex64>, f64) {
        let floor = ENTRY_ROUND_OFF * x.iter().map(|value| value.l1_norm()).fold(0.0, f64::max);
        let mut residual = right.to_vec();
        let size = |(force, row): (&Complex64, &f64)| force.l1_norm() + floor * row;
        let mut sizes: Vec<f64> = right.iter().zip(&self.row_sizes).map(size).collect();
        for (chain, start) in self.matrix.chains.iter().zip(&self.matrix.starts) {
            for row in 0..chain.size() {
                let (columns, entries) = chain.row(row);
                let columns = start + columns.start..start + columns.end;
                let row = start + row;
                if side == Side::Right {
                    let (mut rest, mut size) = (residual[row], sizes[row]);
                    for (value, x) in entries.iter().zip(&x[columns]) {
                        let term = value * x;
                        rest -= term;
                        size += term.l1_norm();
                    }
                    (residual[row], sizes[row]) = (rest, size);
                } else {
                    let places = residual[columns.clone()].iter_mut().zip(&mut sizes[columns]);
                    for (value, (rest, size)) in entries.iter().zip(places) {
                        let term = value * x[row];
                        *rest -= term;
                        *size += term.l1_norm();
                    }
                }
            }
        }
        let CoupledBands { couplings, combinations, .. } = &self.matrix;
        let starts = &self.matrix.starts;
        let value = |motion: &Motion| motion.value(&x[starts[motion.chain]..]);
        let combined: Vec<Complex64> = combinations.iter().map(value).collect();
        let mut forces = vec![Complex64::ZERO; combinations.len()];
        let mut force_sizes = vec![0.0; combinations.len()];
        for ((row, column), value) in couplings {
            let (row, column) = if side == Side::Right { (*row, *column) } else { (*column, *row) };
            let term = value * x.get(column).copied().unwrap_or_else(|| combined[column - x.len()]);
            match row.checked_sub(x.len()) {
                None => {
                    residual[row] -= term;
                    sizes[row] += term.l1_norm();
                }
                Some(combination) => {
                    forces[combination] += term;
                    force_sizes[combination] += term.l1_norm();
                }
            }
        }
        for (motion, force) in combinations.iter().zip(forces) {
            motion.subtract(force, &mut residual[starts[motion.chain]..]);
        }
        self.matrix.add_sizes(&force_sizes, &mut sizes);
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
    use nalgebra::DVector;

    /// A Hermitian matrix of two chains with couplings: a stiffness of all coordinates and forces of three couplings.
    fn matrix(stiffness: f64, couplings: [f64; 3]) -> (CoupledBands, DMatrix<Complex64>) {
        let sizes = [5, 4];
        let (mut sum, mut dense) = (CoupledBands::default(), DMatrix::zeros(9, 9));
        sizes.iter().for_each(|size| sum.push(BandChain::zeros(*size, 1)));
        let mut add = |row: usize, column: usize, value: Complex64| {
            sum.add(row, column, value);
            dense[(row, column)] += value;
        };
        for i in 0..9 {
            add(i, i, Complex64::from(stiffness + 0.1 * i as f64));
            if i != 4 && i != 8 {
                add(i, i + 1, Complex64::from(-1.0));
                add(i + 1, i, Complex64::from(-1.0));
            }
        }
        let row = [(1, Complex64::ONE), (2, Complex64::new(0.5, 0.3)), (7, Complex64::new(-0.4, 1.0))];
        for (force, shift) in couplings.into_iter().zip(0..) {
            for (i, left) in row {
                for (j, right) in row {
                    add((i + shift) % 9, (j + shift) % 9, left * right.conj() * force);
                }
            }
        }
        (sum, dense)
    }

    #[test]
    fn negative_eigenvalues_are_counted() {
        let mut counts = [0, 0];
        for stiffness in [-0.3, 0.7, 1.5, 2.0, 2.5, 4.0] {
            for couplings in [[0.0; 3], [0.3, -0.1, 0.0], [-0.5, 2.0, 1.0], [-1.0, -1.0, 0.2], [5.0, 5.0, -0.3]] {
                let (sum, dense) = matrix(stiffness, couplings);
                let negative = dense.symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count();
                assert_eq!(sum.negative_eigenvalues(), Some(negative), "{stiffness} {couplings:?}");
                counts[usize::from(negative == 0)] += 1;
            }
        }
        assert!(counts[0] > 4 && counts[1] > 4, "{counts:?}");
    }

    /// A Hermitian matrix of a chain and of a diagonal one, of which `count` combinations are coupled to the first chain; and the
    /// same as a dense matrix.
    fn with_combinations(shift: f64, count: usize) -> (CoupledBands, DMatrix<Complex64>) {
        let (mut sum, mut dense) = (CoupledBands::default(), DMatrix::zeros(9, 9));
        [(4, 1), (5, 0)].into_iter().for_each(|(size, reach)| sum.push(BandChain::zeros(size, reach)));
        for i in 0..9 {
            let value = Complex64::from(if i < 4 { 2.0 } else { (i - 4) as f64 } - shift);
            sum.add(i, i, value);
            dense[(i, i)] += value;
        }
        for k in 0..count {
            let row: Vec<(usize, f64)> = (4..9).map(|i| (i, ((3 * i + 2 * k) as f64).cos())).collect();
            let number = sum.combination(&row);
            assert_eq!(number, sum.combination(&row));
            let own = [vec![(k % 4, 1.0)], row.iter().map(|(i, value)| (*i, -value)).collect()].concat();
            let motions = [(k % 4, 1.0), (number, -1.0)];
            for (a, left) in motions {
                motions.iter().for_each(|(b, right)| sum.add(a, *b, Complex64::from(left * right)));
            }
            own.iter().for_each(|(i, a)| own.iter().for_each(|(j, b)| dense[(*i, *j)] += Complex64::from(a * b)));
        }
        (sum, dense)
    }

    #[test]
    fn combinations_give_the_dense_matrix() -> Result<(), Singular> {
        // Two coordinates of the diagonal chain are singular without the couplings at 0 and 2; seven combinations of five
        // coordinates depend on each other.
        for (shift, count) in [(0.0, 3), (2.0, 7), (0.3, 2), (3.7, 6), (-1.0, 7)] {
            let (sum, dense) = with_combinations(shift, count);
            if shift.fract() != 0.0 || shift < 0.0 {
                let negative = dense.symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count();
                assert_eq!(sum.negative_eigenvalues(), Some(negative), "{shift} {count}");
            }
            let wanted = dense.clone().determinant();
            let found = sum.clone().determinant(1.0)?;
            let found = found.phase * found.logarithm.exp();
            assert!((found - wanted).norm() < 1e-11 * wanted.norm(), "{found} {wanted}");
            let right = DVector::from_fn(9, |i, _| Complex64::new(i as f64 - 3.0, 1.0));
            let factors = sum.factor(1.0)?;
            for (side, dense) in [(Side::Right, dense.clone()), (Side::Left, dense.transpose())] {
                let mut x = right.clone();
                let error = factors.solve_to(side, 0.0, x.as_mut_slice())?;
                assert!(error < 1e-14, "{error}");
                assert!((dense * x - &right).norm() < 1e-11 * right.norm(), "{shift} {count}");
            }
        }
        Ok(())
    }

    #[test]
    fn factors_of_a_diagonal_chain_are_proportional_to_its_size() -> Result<(), Singular> {
        // The modes of a housing with three seats, each coupled to a coordinate of a shaft.
        let (rows, seats) = (4, 3);
        for modes in [10, 20, 100] {
            let mut sum = CoupledBands::default();
            sum.push(BandChain::zeros(rows, 1));
            sum.push(BandChain::zeros(modes, 0));
            (0..rows + modes).for_each(|i| sum.add(i, i, Complex64::from(1.0 + i as f64)));
            for k in 0..seats {
                let row: Vec<_> = (rows..rows + modes).map(|i| (i, ((3 * i + 2 * k) as f64).cos())).collect();
                let motions = [(k, 1.0), (sum.combination(&row), -1.0)];
                for (a, left) in motions {
                    motions.iter().for_each(|(b, right)| sum.add(a, *b, Complex64::from(left * right)));
                }
            }
            let factors = sum.factor(1.0)?;
            assert_eq!(factors.couplings.motions.len(), 2 * seats);
            assert_eq!(factors.columns.iter().map(Vec::len).sum::<usize>(), seats * (rows + modes));
        }
        Ok(())
    }

    #[test]
    fn determinant_and_solution_are_those_of_the_dense_matrix() -> Result<(), Singular> {
        for (stiffness, couplings) in [(2.5, [0.3, -0.1, 0.0]), (0.5, [-0.5, 2.0, 1.0]), (-0.7, [0.0; 3])] {
            let (sum, dense) = matrix(stiffness, couplings);
            let wanted = dense.clone().determinant();
            let found = sum.clone().determinant(1.0)?;
            let found = found.phase * found.logarithm.exp();
            assert!((found - wanted).norm() < 1e-12 * wanted.norm(), "{found} {wanted}");
            let right = DVector::from_fn(9, |i, _| Complex64::new(i as f64 - 3.0, 1.0));
            let mut x = right.clone();
            let factors = sum.factor(1.0)?;
            factors.solve_to(Side::Right, 0.0, x.as_mut_slice())?;
            assert!((&dense * x - &right).norm() < 1e-12 * right.norm());
            let mut x = right.clone();
            factors.solve_to(Side::Left, 0.0, x.as_mut_slice())?;
            assert!((dense.transpose() * x - &right).norm() < 1e-12 * right.norm());
        }
        Ok(())
    }
}
