//! The coordinates at which band matrices are coupled, and the matrices of Woodbury's formula ([`super::coupled_bands`]).

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use num_complex::Complex64;

use super::band::{Band, BandLu, Number, Singular};
use super::dense::ComplexLu;

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
    /// Δ, r × r: the couplings without the dampers.
    pub matrix: DMatrix<Complex64>,
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
        let mut matrix = DMatrix::zeros(coordinates.len(), coordinates.len());
        let index = |coordinate: &usize| coordinates.binary_search(coordinate);
        for ((row, column), value) in entries {
            if let (Ok(i), Ok(j)) = (index(row), index(column)) {
                matrix[(i, j)] += value;
            }
        }
        for (i, damper) in dampers.iter().enumerate() {
            matrix[(i, i)] -= damper;
        }
        let place = |coordinate: &usize| {
            let chain = chain_of(starts, *coordinate);
            (chain, coordinate - starts[chain])
        };
        Self { places: coordinates.iter().map(place).collect(), coordinates, dampers, matrix }
    }

    /// Factors of the chains with the dampers.
    pub fn factor_chains(&self, mut chains: Vec<Band<Complex64>>) -> Result<Vec<BandLu<Complex64>>, Singular> {
        for ((chain, row), damper) in self.places.iter().zip(&self.dampers) {
            chains[*chain].add(*row, *row, *damper);
        }
        chains.into_iter().map(Band::factor).collect()
    }

    /// Numbers and rows of the coordinates in a chain.
    pub fn in_chain(&self, chain: usize) -> impl Iterator<Item = (usize, usize)> {
        let places = self.places.iter().enumerate();
        places.filter(move |(_, place)| place.0 == chain).map(|(number, place)| (number, place.1))
    }

    /// First coupled row of a chain.
    pub fn first_row(&self, chain: usize) -> usize {
        self.in_chain(chain).map(|(_, row)| row).min().unwrap_or_default()
    }

    /// Columns of A⁻¹E, each over the rows of its chain; those before `first(chain)` are not computed.
    pub fn columns<T: Number>(&self, chains: &[BandLu<T>], first: impl Fn(usize) -> usize) -> Vec<Vec<T>> {
        let column = |(chain, row): &(usize, usize)| {
            let mut column = vec![T::zero(); chains[*chain].size()];
            column[*row] = T::one();
            chains[*chain].solve_part(&mut column, *row, first(*chain));
            column
        };
        self.places.iter().map(column).collect()
    }

    /// Factors of I + Z Δ, where Z has the entries of the `columns` of A⁻¹E at the coupled coordinates.
    pub fn capacity(&self, columns: &[Vec<Complex64>]) -> Result<ComplexLu, Singular> {
        let size = self.places.len();
        let mut capacity = DMatrix::identity(size, size);
        for (k, column) in columns.iter().enumerate() {
            for (i, row) in self.in_chain(self.places[k].0) {
                for j in 0..size {
                    // Few coordinates are coupled to each other.
                    if self.matrix[(k, j)] != Complex64::ZERO {
                        capacity[(i, j)] += column[row] * self.matrix[(k, j)];
                    }
                }
            }
        }
        let capacity = ComplexLu::new(&capacity);
        if capacity.is_regular() { Ok(capacity) } else { Err(Singular) }
    }
}
