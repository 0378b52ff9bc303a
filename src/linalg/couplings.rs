//! The coordinates at which band matrices are coupled, and the matrices of Woodbury's formula ([`super::coupled_bands`]).

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::DMatrix;
use num_complex::Complex64;

use super::band::{Band, BandLu, Number, Singular};
use super::blocks::{BlockFactors, Blocks};

/// Number of the chain of a coordinate, for chains with the first coordinates `starts`.
pub(super) fn chain_of(starts: &[usize], coordinate: usize) -> usize {
    starts.partition_point(|start| *start <= coordinate) - 1
}

/// The coordinates that couplings join, and the couplings between them.
#[derive(Clone, Debug)]
pub(super) struct Couplings {
    /// Coupled coordinates, ascending, r entries.
    pub coordinates: Vec<usize>,
    /// Chain of each of them, and its row in the matrix of the chain.
    pub places: Vec<(usize, usize)>,
    /// Damper on each of them in the matrix of the chain.
    dampers: Vec<Complex64>,
    /// Numbers of the coordinates of each chain that has some.
    parts: Vec<Range<usize>>,
    /// Δ, r × r: the couplings without the dampers. A block belongs to two chains.
    pub matrix: Blocks,
}

impl Couplings {
    /// The couplings `entries` of chains with the first coordinates `starts`, with dampers of the size of the couplings times
    /// `damper`.
    pub fn new(entries: &BTreeMap<(usize, usize), Complex64>, starts: &[usize], damper: Complex64) -> Self {
        let mut sizes: BTreeMap<usize, f64> = BTreeMap::new();
        for ((row, column), value) in entries.iter().filter(|(_, value)| **value != Complex64::ZERO) {
            *sizes.entry(*row).or_default() += value.norm();
            // A coordinate of which the others only read is coupled too.
            sizes.entry(*column).or_default();
        }
        let coordinates: Vec<usize> = sizes.keys().copied().collect();
        let dampers: Vec<Complex64> = sizes.values().map(|size| damper * *size).collect();
        let place = |coordinate: &usize| {
            let chain = chain_of(starts, *coordinate);
            (chain, coordinate - starts[chain])
        };
        let places: Vec<(usize, usize)> = coordinates.iter().map(place).collect();
        let mut first = 0;
        let parts = places.chunk_by(|(a, _), (b, _)| a == b).map(|chain| {
            first += chain.len();
            first - chain.len()..first
        });
        let parts: Vec<Range<usize>> = parts.collect();
        let mut matrix = Blocks::zeros(parts.clone());
        for ((row, column), value) in entries.iter().filter(|(_, value)| **value != Complex64::ZERO) {
            if let (Ok(i), Ok(j)) = (coordinates.binary_search(row), coordinates.binary_search(column)) {
                matrix.add(i, j, *value);
            }
        }
        dampers.iter().enumerate().for_each(|(i, damper)| matrix.add(i, i, -damper));
        Self { coordinates, places, dampers, parts, matrix }
    }

    /// Factors of the chains with the dampers.
    pub fn factor_chains(&self, mut chains: Vec<Band<Complex64>>) -> Result<Vec<BandLu<Complex64>>, Singular> {
        for ((chain, row), damper) in self.places.iter().zip(&self.dampers) {
            chains[*chain].add(*row, *row, *damper);
        }
        chains.into_iter().map(Band::factor).collect()
    }

    /// Columns of A⁻¹E, each over the rows of its chain; of the rows before the first coupled one, only if they are `complete`.
    pub fn columns<T: Number>(&self, chains: &[BandLu<T>], complete: bool) -> Vec<Vec<T>> {
        let mut columns = Vec::with_capacity(self.places.len());
        for part in &self.parts {
            let places = &self.places[part.clone()];
            let first = if complete { 0 } else { places[0].1 };
            for (chain, row) in places {
                let mut column = vec![T::zero(); chains[*chain].size()];
                column[*row] = T::one();
                chains[*chain].solve_part(&mut column, *row, first);
                columns.push(column);
            }
        }
        columns
    }

    /// Z of each chain, from the `columns` of A⁻¹E.
    pub fn receptances<T: Number>(&self, columns: &[Vec<T>]) -> Vec<DMatrix<Complex64>> {
        let receptance = |part: &Range<usize>| {
            DMatrix::from_fn(part.len(), part.len(), |i, j| {
                let value = columns[part.start + j][self.places[part.start + i].1];
                Complex64::new(value.real(), value.imaginary())
            })
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
