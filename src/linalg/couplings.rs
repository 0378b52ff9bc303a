//! The motions at which band matrices are coupled, and the matrices of Woodbury's formula ([`super::coupled_bands`]).

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::band::{Band, BandLu, Number, Singular};
use super::blocks::{BlockFactors, Blocks};
use super::coupled_bands::CoupledBands;
use super::dense::matrix_of_columns;
use super::product::LANES;
use crate::numerics::ROUND_OFF;

/// A coordinate is soft if its entry on the diagonal is below this fraction of its couplings. The solution of Woodbury's formula loses
/// this factor of accuracy, which one refinement gives back; with 1e-3, all modes of a housing would be soft under stiff bearings.
const SOFT: f64 = 1e-6;

/// Number of the chain of a coordinate, for chains with the first coordinates `starts`.
pub(super) fn chain_of(starts: &[usize], coordinate: usize) -> usize {
    starts.partition_point(|start| *start <= coordinate) - 1
}

/// A coordinate of one chain, or a combination of several.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Motion {
    /// Index of the chain.
    pub chain: usize,
    /// Row of the first coordinate in the matrix of the chain.
    pub first: usize,
    /// Coefficients of this coordinate and those after it.
    pub coefficients: Arc<[f64]>,
}

impl Motion {
    /// Whether it is a combination.
    fn is_combination(&self) -> bool {
        self.coefficients.len() > 1
    }

    /// Rows of its coordinates.
    fn rows(&self) -> Range<usize> {
        self.first..self.first + self.coefficients.len()
    }

    /// Its value in a vector over the coordinates of the chain, summed in lanes because one sum would wait for each addition.
    pub fn value<T: Number>(&self, x: &[T]) -> T {
        let (x, x_rest) = x[self.rows()].as_chunks::<LANES>();
        let (coefficients, coefficients_rest) = self.coefficients.as_chunks::<LANES>();
        let mut sums = [T::zero(); LANES];
        for (x, coefficients) in x.iter().zip(coefficients) {
            for (sum, (x, coefficient)) in sums.iter_mut().zip(x.iter().zip(coefficients)) {
                *sum += x.scale(*coefficient);
            }
        }
        let rest = x_rest.iter().zip(coefficients_rest).map(|(x, coefficient)| x.scale(*coefficient));
        rest.chain(sums).fold(T::zero(), |sum, part| sum + part)
    }

    /// Subtracts a force along it.
    pub fn subtract(&self, force: Complex64, x: &mut [Complex64]) {
        x[self.rows()].iter_mut().zip(&*self.coefficients).for_each(|(x, coefficient)| *x -= force * *coefficient);
    }
}

/// The motions that couplings join, and the couplings between them.
#[derive(Clone, Debug)]
pub(super) struct Couplings {
    /// Coupled motions by chain, the columns of E, r entries.
    pub motions: Vec<Motion>,
    /// Damper on each of them in the matrix of the chain.
    dampers: Vec<Complex64>,
    /// Numbers of the motions of each chain that has some.
    parts: Vec<Range<usize>>,
    /// Δ, r × r: the couplings without the dampers. A block belongs to two chains.
    pub matrix: Blocks,
}

impl Couplings {
    /// The couplings of a matrix, with dampers of the size of the couplings times `damper`: on every coupled coordinate, and on
    /// those coordinates of coupled combinations that are soft.
    pub fn new(bands: &CoupledBands, damper: Complex64) -> Self {
        let mut sizes: BTreeMap<usize, f64> = BTreeMap::new();
        let entries = || bands.couplings.iter().filter(|(_, value)| **value != Complex64::ZERO);
        for ((row, column), value) in entries() {
            *sizes.entry(*row).or_default() += value.norm();
            // A coordinate of which the others only read is coupled too.
            sizes.entry(*column).or_default();
        }
        if damper != Complex64::ZERO {
            sizes.extend(soft_coordinates(bands, &sizes));
        }
        let mut keys: Vec<(usize, usize)> = sizes.keys().map(|key| (bands.chain(*key), *key)).collect();
        keys.sort_unstable();
        let motions: Vec<Motion> = keys.iter().map(|(_, key)| bands.motion(*key)).collect();
        let of = |(_, key): &(usize, usize)| if *key < bands.size() { damper * sizes[key] } else { Complex64::ZERO };
        let dampers: Vec<Complex64> = keys.iter().map(of).collect();
        let parts = parts_of(&motions);
        let mut matrix = Blocks::zeros(parts.clone());
        let numbers: BTreeMap<usize, usize> = keys.iter().enumerate().map(|(i, (_, key))| (*key, i)).collect();
        entries().for_each(|((row, column), value)| matrix.add(numbers[row], numbers[column], *value));
        dampers.iter().enumerate().for_each(|(i, damper)| matrix.add(i, i, -damper));
        Self { motions, dampers, parts, matrix }
    }

    /// The same couplings of linearly independent motions.
    pub fn of_independent_motions(self) -> Self {
        let mut motions = Vec::new();
        // The motions of each chain are the columns of BC with independent columns B.
        let mut factors = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            let given = &self.motions[part.clone()];
            if !given.iter().any(Motion::is_combination) {
                factors.push(DMatrix::identity(part.len(), part.len()));
                motions.extend_from_slice(given);
                continue;
            }
            let rows = given.iter().map(|motion| motion.rows().end).max().unwrap_or(0);
            let mut columns = DMatrix::zeros(rows, given.len());
            for (motion, mut column) in given.iter().zip(columns.column_iter_mut()) {
                column.rows_range_mut(motion.rows()).copy_from_slice(&motion.coefficients);
            }
            let basis = independent_columns(&columns);
            factors.push((basis.transpose() * columns).map(Complex64::from));
            let motion = |column: nalgebra::DVectorView<'_, f64>| Motion {
                chain: given[0].chain,
                first: 0,
                coefficients: column.iter().copied().collect(),
            };
            motions.extend(basis.column_iter().map(|column| motion(column.as_view())));
        }
        let parts = parts_of(&motions);
        let mut matrix = Blocks::zeros(parts.clone());
        self.matrix.for_each(|row, column, block| {
            *matrix.block(row, column) += &factors[row] * block * factors[column].transpose();
        });
        Self { dampers: vec![Complex64::ZERO; motions.len()], motions, parts, matrix }
    }

    /// Factors of the chains with the dampers.
    pub fn factor_chains(&self, mut chains: Vec<Band<Complex64>>) -> Result<Vec<BandLu<Complex64>>, Singular> {
        for (motion, damper) in self.motions.iter().zip(&self.dampers).filter(|(_, damper)| **damper != Complex64::ZERO)
        {
            chains[motion.chain].add(motion.first, motion.first, *damper);
        }
        chains.into_iter().map(Band::factor).collect()
    }

    /// Columns of A⁻¹E, each over the rows of its chain; of the rows before the first coupled one, only if they are `complete`.
    pub fn columns<T: Number>(&self, chains: &[BandLu<T>], complete: bool) -> Vec<Vec<T>> {
        let mut columns = Vec::with_capacity(self.motions.len());
        for part in &self.parts {
            let motions = &self.motions[part.clone()];
            let first = if complete { 0 } else { motions.iter().map(|motion| motion.first).min().unwrap_or(0) };
            for motion in motions {
                let mut column = vec![T::zero(); chains[motion.chain].size()];
                let entries = column[motion.rows()].iter_mut().zip(&*motion.coefficients);
                entries.for_each(|(entry, coefficient)| *entry = T::from_real(*coefficient));
                chains[motion.chain].solve_part(&mut column, motion.first, first);
                columns.push(column);
            }
        }
        columns
    }

    /// Z of each chain, from the `columns` of A⁻¹E.
    pub fn receptances<T: Number>(&self, columns: &[Vec<T>]) -> Vec<DMatrix<Complex64>> {
        let receptance = |part: &Range<usize>| {
            let (motions, columns) = (&self.motions[part.clone()], &columns[part.clone()]);
            let mut receptance = DMatrix::zeros(part.len(), part.len());
            for (j, column) in columns.iter().enumerate() {
                for (i, motion) in motions.iter().enumerate() {
                    // Only diagonal entries act between the coordinates of a combination: its receptances are symmetric.
                    let is_symmetric = motion.is_combination() || motions[j].is_combination();
                    if i > j && is_symmetric {
                        continue;
                    }
                    let value = motion.value(column);
                    let value = Complex64::new(value.real(), value.imaginary());
                    receptance[(i, j)] = value;
                    if is_symmetric {
                        receptance[(j, i)] = value;
                    }
                }
            }
            receptance
        };
        self.parts.iter().map(receptance).collect()
    }

    /// I + Z Δ.
    fn capacity(&self, receptances: &[DMatrix<Complex64>]) -> Blocks {
        let mut capacity = Blocks::zeros(self.parts.clone());
        (0..receptances.len()).for_each(|part| capacity.block(part, part).fill_with_identity());
        self.matrix.for_each(|row, column, block| {
            let product = capacity.block(row, column);
            // Most motions are coupled to few others.
            for (mut product, couplings) in product.column_iter_mut().zip(block.column_iter()) {
                let couplings = receptances[row].column_iter().zip(couplings.iter());
                let couplings = couplings.filter(|(_, coupling)| **coupling != Complex64::ZERO);
                couplings.for_each(|(receptances, coupling)| product.axpy(*coupling, &receptances, Complex64::ONE));
            }
        });
        capacity
    }

    /// Factors of I + Z Δ. A chain that is singular until others are eliminated needs `all_exchanges` of rows, which take
    /// time proportional to r³.
    pub fn factor_capacity(&self, columns: &[Vec<Complex64>], all_exchanges: bool) -> Result<BlockFactors, Singular> {
        let receptances = self.receptances(columns);
        if !all_exchanges && let Ok(factors) = self.capacity(&receptances).factor(|_| {}) {
            return Ok(factors);
        }
        self.capacity(&receptances).merged().factor(|_| {})
    }

    /// Z + Z Δ Z.
    pub fn form(&self, receptances: &[DMatrix<Complex64>]) -> Blocks {
        let mut form = Blocks::zeros(self.parts.clone());
        receptances.iter().enumerate().for_each(|(part, receptance)| form.block(part, part).copy_from(receptance));
        self.matrix.for_each(|row, column, block| {
            form.block(row, column).gemm(
                Complex64::ONE,
                &(&receptances[row] * block),
                &receptances[column],
                Complex64::ONE,
            );
        });
        form
    }
}

/// Numbers of the motions of each chain.
fn parts_of(motions: &[Motion]) -> Vec<Range<usize>> {
    let mut first = 0;
    let parts = motions.chunk_by(|a, b| a.chain == b.chain).map(|chain| {
        first += chain.len();
        first - chain.len()..first
    });
    parts.collect()
}

/// Coordinates of coupled combinations whose entry on the diagonal is small against their couplings, with the size of these; `sizes`
/// are those of the couplings of every motion.
fn soft_coordinates(bands: &CoupledBands, sizes: &BTreeMap<usize, f64>) -> BTreeMap<usize, f64> {
    // Sizes of the couplings of the coordinates of each chain.
    let mut coupled: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for (key, size) in sizes.range(bands.size()..) {
        let motion = &bands.combinations[key - bands.size()];
        let sizes = coupled.entry(motion.chain).or_insert_with(|| vec![0.0; bands.chains[motion.chain].size()]);
        for (own, coefficient) in sizes[motion.rows()].iter_mut().zip(&*motion.coefficients) {
            *own += coefficient * coefficient * size;
        }
    }
    let mut soft = BTreeMap::new();
    for (chain, sizes) in coupled {
        for (row, size) in sizes.into_iter().enumerate() {
            let (columns, entries) = bands.chains[chain].row(row);
            if size > 0.0 && entries[row - columns.start].norm() <= SOFT * size {
                soft.insert(bands.starts[chain] + row, size);
            }
        }
    }
    soft
}

/// Orthonormal columns with the same span.
fn independent_columns(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for column in columns.column_iter() {
        let mut rest = column.into_owned();
        let size = rest.norm();
        for _ in 0..2 {
            basis.iter().for_each(|known| rest.axpy(-known.dot(&rest), known, 1.0));
        }
        // A motion whose part independent of the others is round-off is a combination of them.
        if rest.norm() > ROUND_OFF * size {
            basis.push(rest.normalize());
        }
    }
    matrix_of_columns(columns.nrows(), &basis)
}
