//! The motions at which band matrices are coupled, and the matrices of Woodbury's formula ([`super::coupled_bands`]).

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::band::{Band, BandLu, Number, Singular};
use super::blocks::{BlockFactors, Blocks};
use super::coupled_bands::CoupledBands;
use super::dense::matrix_of_columns;

/// A coordinate is soft if its entry on the diagonal is below this fraction of its couplings. The solution of Woodbury's formula loses
/// this factor of accuracy, which one refinement gives back; with 1e-3, all modes of a housing would be soft under stiff bearings.
const SOFT: f64 = 1e-6;
/// A motion whose part independent of the others is below this fraction is a combination of them.
const DEPENDENT: f64 = 1e-12;

/// Number of the chain of a coordinate, for chains with the first coordinates `starts`.
pub(super) fn chain_of(starts: &[usize], coordinate: usize) -> usize {
    starts.partition_point(|start| *start <= coordinate) - 1
}

/// A coordinate of one chain, or a combination of several.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Motion {
    /// Index of the chain.
    pub chain: usize,
    /// Entries (row in the matrix of the chain, coefficient), ascending.
    pub entries: Vec<(usize, f64)>,
}

impl Motion {
    /// Its value in a vector over the coordinates of the chain.
    pub fn value<T: Number>(&self, x: &[T]) -> T {
        self.entries.iter().fold(T::zero(), |sum, (row, coefficient)| sum + x[*row].scale(*coefficient))
    }

    /// Subtracts a force along it.
    pub fn subtract(&self, force: Complex64, x: &mut [Complex64]) {
        self.entries.iter().for_each(|(row, coefficient)| x[*row] -= force * *coefficient);
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
            if given.iter().all(|motion| motion.entries.len() == 1) {
                factors.push(DMatrix::identity(part.len(), part.len()));
                motions.extend_from_slice(given);
                continue;
            }
            let rows = given.iter().flat_map(|motion| &motion.entries).map(|(row, _)| row + 1).max().unwrap_or(0);
            let mut columns = DMatrix::zeros(rows, given.len());
            for (motion, mut column) in given.iter().zip(columns.column_iter_mut()) {
                motion.entries.iter().for_each(|(row, coefficient)| column[*row] = *coefficient);
            }
            let basis = independent_columns(&columns);
            factors.push((basis.transpose() * columns).map(Complex64::from));
            let motion = |column: nalgebra::DVectorView<'_, f64>| Motion {
                chain: given[0].chain,
                entries: column.iter().copied().enumerate().collect(),
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
            let row = motion.entries[0].0;
            chains[motion.chain].add(row, row, *damper);
        }
        chains.into_iter().map(Band::factor).collect()
    }

    /// Columns of A⁻¹E, each over the rows of its chain; of the rows before the first coupled one, only if they are `complete`.
    pub fn columns<T: Number>(&self, chains: &[BandLu<T>], complete: bool) -> Vec<Vec<T>> {
        let mut columns = Vec::with_capacity(self.motions.len());
        let first_row = |motion: &Motion| motion.entries.first().map_or(0, |(row, _)| *row);
        for part in &self.parts {
            let motions = &self.motions[part.clone()];
            let first = if complete { 0 } else { motions.iter().map(first_row).min().unwrap_or(0) };
            for motion in motions {
                let mut column = vec![T::zero(); chains[motion.chain].size()];
                motion.entries.iter().for_each(|(row, coefficient)| column[*row] = T::from_real(*coefficient));
                chains[motion.chain].solve_part(&mut column, first_row(motion), first);
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
                    let is_symmetric = motion.entries.len() > 1 || motions[j].entries.len() > 1;
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
            capacity.block(row, column).gemm(Complex64::ONE, &receptances[row], block, Complex64::ONE);
        });
        capacity
    }

    /// Factors of I + Z Δ. A chain that is singular until others are eliminated needs `all_exchanges` of rows, which take
    /// time proportional to r³.
    pub fn factor_capacity(&self, columns: &[Vec<Complex64>], all_exchanges: bool) -> Result<BlockFactors, Singular> {
        let capacity = self.capacity(&self.receptances(columns));
        if !all_exchanges && let Ok(factors) = capacity.clone().factor(|_| {}) {
            return Ok(factors);
        }
        capacity.merged().factor(|_| {})
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
        let Motion { chain, entries } = &bands.combinations[key - bands.size()];
        let sizes = coupled.entry(*chain).or_insert_with(|| vec![0.0; bands.chains[*chain].size()]);
        for (row, coefficient) in entries {
            sizes[*row] += coefficient * coefficient * size;
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
        if rest.norm() > DEPENDENT * size {
            basis.push(rest.normalize());
        }
    }
    matrix_of_columns(columns.nrows(), &basis)
}
