//! Quasi-periodic states: the state at the beginning of section n of length T is Σ Re(cₖ e^{iθₖn}), where the angle θₖ is
//! that of a combination of base frequencies within T.
//!
//! The combinations grow from the harmonics of each excitation towards those neighbours whose inner neighbours are all
//! significant. The coefficients follow from the states at as many sections as there are unknowns. A QR decomposition with
//! column pivoting selects the sections from a longer time, so that the coefficients depend little on errors of the states;
//! this also separates frequencies of almost the same angle.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use nalgebra::{Complex, DMatrix, DVector, Dyn, LU, RowDVector};

use crate::numerics::EQUALITY_TOLERANCE;

/// Number of sections for each unknown among which the sections are selected, and the factor by which it grows.
const CANDIDATE_SECTIONS: usize = 20;
const CANDIDATE_GROWTH: usize = 4;
/// Largest number of entries of the matrix of candidates: 64 MB.
const MAX_ENTRIES: usize = 8_000_000;
/// Smallest ratio of the pivots of the decomposition.
const MIN_PIVOT_RATIO: f64 = 0.05;
/// Largest number of unknowns of a coordinate.
const MAX_UNKNOWNS: usize = 400;

/// A frequency of the excitation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseFrequency {
    /// Periods within a section.
    pub cycles: f64,
    /// Number of harmonics of the excitation itself.
    pub harmonics: usize,
}

/// Combinations of base frequencies: their multiples, and their angles within a section.
#[derive(Clone, Debug)]
pub struct Combinations {
    base: Vec<BaseFrequency>,
    /// Number of the angle of each combination, by the multiples of the base frequencies.
    numbers: BTreeMap<Vec<i32>, usize>,
    /// Different angles, 0 to π; the first is zero.
    angles: Vec<f64>,
}

impl Combinations {
    /// The mean and the harmonics of each excitation.
    pub fn new(base: Vec<BaseFrequency>) -> Self {
        let mut first = Self { numbers: BTreeMap::new(), angles: Vec::new(), base };
        first.insert(vec![0; first.base.len()]);
        for source in 0..first.base.len() {
            for multiple in 1..=first.base[source].harmonics {
                let mut multiples = vec![0; first.base.len()];
                multiples[source] = i32::try_from(multiple).unwrap_or(i32::MAX);
                first.insert(multiples);
            }
        }
        first
    }

    /// Adds all neighbours whose inner neighbours are significant. Returns whether there are further angles.
    pub fn grow(&mut self, is_significant: impl Fn(usize) -> bool) -> bool {
        let (members, count) = (self.numbers.clone(), self.angles.len());
        let is_significant: Vec<bool> = (0..count).map(is_significant).collect();
        for (multiples, number) in &members {
            if !is_significant[*number] {
                continue;
            }
            for source in 0..self.base.len() {
                for step in [-1, 1] {
                    let mut neighbour = multiples.clone();
                    neighbour[source] += step;
                    let is_known = members.contains_key(&canonical(neighbour.clone()));
                    if !is_known
                        && inner(&neighbour)
                            .all(|inner| members.get(&inner).is_some_and(|number| is_significant[*number]))
                    {
                        self.insert(canonical(neighbour));
                    }
                }
            }
        }
        self.angles.len() > count
    }

    fn insert(&mut self, multiples: Vec<i32>) {
        let cycles: f64 =
            multiples.iter().zip(&self.base).map(|(multiple, base)| f64::from(*multiple) * base.cycles).sum();
        // A frequency and its negative give the same motion.
        let part = cycles.rem_euclid(1.0);
        let angle = TAU * part.min(1.0 - part);
        let known = self.angles.iter().position(|other| (other - angle).abs() <= TAU * EQUALITY_TOLERANCE);
        let number = known.unwrap_or_else(|| {
            self.angles.push(angle);
            self.angles.len() - 1
        });
        self.numbers.insert(multiples, number);
    }
}

/// The multiples of a combination or those of its negative: the first one that is not zero is positive.
fn canonical(multiples: Vec<i32>) -> Vec<i32> {
    match multiples.iter().find(|multiple| **multiple != 0) {
        Some(first) if *first < 0 => multiples.iter().map(|multiple| -multiple).collect(),
        _ => multiples,
    }
}

/// The neighbours of a combination that are one step closer to the mean.
fn inner(multiples: &[i32]) -> impl Iterator<Item = Vec<i32>> + '_ {
    (0..multiples.len()).filter(|source| multiples[*source] != 0).map(|source| {
        let mut inner = multiples.to_vec();
        inner[source] -= inner[source].signum();
        canonical(inner)
    })
}

/// The harmonics of a motion and the sections from which their coefficients follow.
pub struct Harmonics {
    /// Angle θ of each harmonic within a section, 0 to π; the first is zero.
    pub angles: Vec<f64>,
    /// Numbers of the sections.
    pub sections: Vec<i64>,
    /// Decomposition of the matrix with a row for each section and a column for each unknown.
    decomposition: LU<f64, Dyn, Dyn>,
}

impl Harmonics {
    /// The harmonics of combinations. None if there are too many, or if their angles are too close to each other.
    pub fn new(combinations: &Combinations) -> Option<Self> {
        let angles = combinations.angles.clone();
        let unknowns = count(&angles);
        if unknowns > MAX_UNKNOWNS {
            return None;
        }
        let mut candidates = CANDIDATE_SECTIONS * unknowns;
        while candidates * unknowns <= MAX_ENTRIES {
            if let Some(sections) = selected(&angles, candidates) {
                let rows: Vec<Vec<f64>> = sections.iter().map(|section| row(&angles, *section)).collect();
                let matrix = DMatrix::from_fn(unknowns, unknowns, |section, unknown| rows[section][unknown]);
                return Some(Self { angles, sections, decomposition: matrix.lu() });
            }
            candidates *= CANDIDATE_GROWTH;
        }
        None
    }

    /// Number of unknowns of a coordinate.
    pub fn unknowns(&self) -> usize {
        self.sections.len()
    }

    /// The coefficients, a column for each unknown, of states at the selected sections, a column for each section.
    pub fn coefficients(&self, states: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        self.decomposition.solve(&states.transpose()).map(|found| found.transpose())
    }

    /// The state at the beginning of a section.
    pub fn state(&self, coefficients: &DMatrix<f64>, section: i64) -> Vec<f64> {
        (coefficients * DVector::from_vec(row(&self.angles, section))).as_slice().to_vec()
    }

    /// The complex coefficients of a harmonic.
    pub fn complex(&self, harmonic: usize, coefficients: &DMatrix<f64>) -> Vec<Complex<f64>> {
        let (first, count) = self.unknowns_of(harmonic);
        let sine = |entry: usize| if count == 1 { 0.0 } else { coefficients[(entry, first + 1)] };
        coefficients.column(first).iter().enumerate().map(|(entry, cos)| Complex::new(*cos, -sine(entry))).collect()
    }

    /// Stores complex coefficients of a harmonic.
    pub fn store(&self, harmonic: usize, values: &[Complex<f64>], coefficients: &mut DMatrix<f64>) {
        let (first, count) = self.unknowns_of(harmonic);
        for (entry, value) in values.iter().enumerate() {
            coefficients[(entry, first)] = value.re;
            if count == 2 {
                coefficients[(entry, first + 1)] = -value.im;
            }
        }
    }

    /// Number of the first unknown of a harmonic, and how many it has.
    pub fn unknowns_of(&self, harmonic: usize) -> (usize, usize) {
        (count(&self.angles[..harmonic]), parts(self.angles[harmonic]))
    }
}

/// Number of unknowns of a harmonic: those of a cosine, and of a sine unless it is zero in all sections.
fn parts(angle: f64) -> usize {
    if angle <= TAU * EQUALITY_TOLERANCE || angle >= PI - TAU * EQUALITY_TOLERANCE { 1 } else { 2 }
}

fn count(angles: &[f64]) -> usize {
    angles.iter().map(|angle| parts(*angle)).sum()
}

/// Values of the harmonics at a section: 1, cos θn and sin θn.
fn row(angles: &[f64], section: i64) -> Vec<f64> {
    let mut values = Vec::with_capacity(2 * angles.len());
    for angle in angles {
        let (sin, cos) = (angle * section as f64).sin_cos();
        values.push(cos);
        if parts(*angle) == 2 {
            values.push(sin);
        }
    }
    values
}

/// Selects as many of the first `candidates` sections as there are unknowns; none if they are ill-conditioned.
fn selected(angles: &[f64], candidates: usize) -> Option<Vec<i64>> {
    let unknowns = count(angles);
    let mut matrix = DMatrix::zeros(unknowns, candidates);
    for (section, mut column) in matrix.column_iter_mut().enumerate() {
        column.copy_from_slice(&row(angles, section as i64));
    }
    let decomposition = matrix.col_piv_qr();
    let triangle = decomposition.r();
    let pivots: Vec<f64> = (0..unknowns).map(|row| triangle[(row, row)].abs()).collect();
    if pivots.iter().any(|pivot| *pivot < MIN_PIVOT_RATIO * pivots[0]) {
        return None;
    }
    let mut sections = RowDVector::from_fn(candidates, |_, section| section as i64);
    decomposition.p().permute_columns(&mut sections);
    Some(sections.as_slice()[..unknowns].to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base(cycles: f64) -> BaseFrequency {
        BaseFrequency { cycles, harmonics: 1 }
    }

    #[test]
    fn combinations_grow_towards_significant_ones() {
        let mut found = Combinations::new(vec![base(0.1), base(0.013)]);
        assert_eq!(found.angles, [0.0, TAU * 0.1, TAU * 0.013]);
        // The second frequency is not significant: neither are its multiples and sums with it.
        assert!(found.grow(|angle| angle < 2));
        assert_eq!(found.numbers.keys().cloned().collect::<Vec<_>>(), [[0, 0], [0, 1], [1, 0], [2, 0]]);
        assert!(found.grow(|_| true));
        let wanted = [[0, 0], [0, 1], [0, 2], [1, -1], [1, 0], [1, 1], [2, 0], [3, 0]];
        assert_eq!(found.numbers.keys().cloned().collect::<Vec<_>>(), wanted);
    }

    #[test]
    fn multiples_of_the_section_are_no_unknowns() {
        let whole = Combinations::new(vec![base(3.0), base(0.5)]);
        assert_eq!(whole.angles, [0.0, PI]);
        // A shaft that turns once in five sections has five states.
        let mut found = Combinations::new(vec![base(0.2)]);
        assert!(found.grow(|_| true));
        assert!(!found.grow(|_| true));
        assert_eq!(Harmonics::new(&found).map(|found| found.unknowns()), Some(5));
    }

    #[test]
    fn harmonics_of_an_excitation_come_first() {
        assert_eq!(Combinations::new(vec![BaseFrequency { cycles: 0.07, harmonics: 3 }]).angles.len(), 4);
    }

    #[test]
    fn coefficients_follow_from_the_states() -> Result<(), ()> {
        // Two frequencies that differ by 1e-4 of a turn in a section.
        let mut combinations = Combinations::new(vec![base(0.2501), base(0.25)]);
        combinations.grow(|_| true);
        let harmonics = Harmonics::new(&combinations).ok_or(())?;
        let wanted = DMatrix::from_fn(3, harmonics.unknowns(), |row, column| ((row + 5 * column) as f64).sin());
        let states: Vec<_> = harmonics.sections.iter().map(|section| harmonics.state(&wanted, *section)).collect();
        let states = DMatrix::from_fn(3, states.len(), |row, column| states[column][row]);
        let found = harmonics.coefficients(&states).ok_or(())?;
        assert!((found - wanted).amax() < 1e-9);
        Ok(())
    }
}
