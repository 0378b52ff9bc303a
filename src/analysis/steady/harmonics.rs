//! Quasi-periodic states: the state at the beginning of section n of length T is Σ Re(cₖ e^{iθₖn}), where the angle θₖ is
//! that of a combination of base frequencies within T.
//!
//! The coefficients follow from the states at as many sections as there are unknowns. A QR decomposition with column
//! pivoting selects the sections from a longer time, so that the coefficients depend little on errors of the states; this
//! also separates frequencies of almost the same angle.

use std::f64::consts::{PI, TAU};

use nalgebra::{Complex, DMatrix, DVector, Dyn, LU, RowDVector};

/// Difference of two angles, relative to a turn, below which both harmonics are the same.
const SAME: f64 = 1e-9;
/// Number of sections for each unknown among which the sections are selected, and the factor by which it grows.
const CANDIDATES: usize = 20;
const GROWTH: usize = 4;
/// Largest number of entries of the matrix of candidates: 64 MB.
const MAX_ENTRIES: usize = 8_000_000;
/// Smallest ratio of the pivots of the decomposition.
const WELL_CONDITIONED: f64 = 0.05;
/// Largest number of unknowns of a coordinate.
const MAX_UNKNOWNS: usize = 400;

/// A frequency of the excitation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseFrequency {
    /// Periods within a section.
    pub cycles: f64,
    /// Number of harmonics that the excitation has itself.
    pub harmonics: usize,
}

/// The harmonics of a motion and the sections from which their coefficients follow.
pub struct Harmonics {
    /// Angle θ of each harmonic within a section, 0 to π, by increasing order; the first is zero.
    pub angles: Vec<f64>,
    /// Numbers of the sections.
    pub sections: Vec<u64>,
    /// Decomposition of the matrix with a row for each section and a column for each unknown.
    decomposition: LU<f64, Dyn, Dyn>,
}

impl Harmonics {
    /// The harmonics of all combinations of base frequencies up to an order; the harmonics of an excitation count as one
    /// order. None if there are too many, or if their angles are too close to each other.
    pub fn new(base: &[BaseFrequency], order: usize) -> Option<Self> {
        let angles = angles(base, order);
        let unknowns = count(&angles);
        if unknowns > MAX_UNKNOWNS {
            return None;
        }
        let mut candidates = CANDIDATES * unknowns;
        while candidates * unknowns <= MAX_ENTRIES {
            if let Some(sections) = selected(&angles, candidates) {
                let rows: Vec<Vec<f64>> = sections.iter().map(|section| row(&angles, *section)).collect();
                let matrix = DMatrix::from_fn(unknowns, unknowns, |section, unknown| rows[section][unknown]);
                return Some(Self { angles, sections, decomposition: matrix.lu() });
            }
            candidates *= GROWTH;
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
    pub fn state(&self, coefficients: &DMatrix<f64>, section: u64) -> Vec<f64> {
        (coefficients * DVector::from_vec(row(&self.angles, section))).as_slice().to_vec()
    }

    /// The complex coefficients of a harmonic, whose unknowns begin with `first`.
    pub fn complex(&self, harmonic: usize, first: usize, coefficients: &DMatrix<f64>) -> Vec<Complex<f64>> {
        let is_real = parts(self.angles[harmonic]) == 1;
        let sine = |entry: usize| if is_real { 0.0 } else { coefficients[(entry, first + 1)] };
        coefficients.column(first).iter().enumerate().map(|(entry, cos)| Complex::new(*cos, -sine(entry))).collect()
    }

    /// Stores complex coefficients of a harmonic.
    pub fn store(&self, harmonic: usize, first: usize, values: &[Complex<f64>], coefficients: &mut DMatrix<f64>) {
        for (entry, value) in values.iter().enumerate() {
            coefficients[(entry, first)] = value.re;
            if parts(self.angles[harmonic]) == 2 {
                coefficients[(entry, first + 1)] = -value.im;
            }
        }
    }

    /// Number of each harmonic and of its first unknown.
    pub fn first_unknowns(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.angles.iter().enumerate().scan(0, |first, (harmonic, angle)| {
            let this = *first;
            *first += parts(*angle);
            Some((harmonic, this))
        })
    }
}

/// Number of unknowns of a harmonic: those of a cosine, and of a sine unless it is zero in all sections.
fn parts(angle: f64) -> usize {
    if angle <= TAU * SAME || angle >= PI - TAU * SAME { 1 } else { 2 }
}

fn count(angles: &[f64]) -> usize {
    angles.iter().map(|angle| parts(*angle)).sum()
}

/// Values of the harmonics at a section: 1, cos θn and sin θn.
fn row(angles: &[f64], section: u64) -> Vec<f64> {
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

/// The angles of all combinations of base frequencies up to an order, by increasing order.
fn angles(base: &[BaseFrequency], order: usize) -> Vec<f64> {
    let mut found = vec![0.0];
    for order in 1..=order {
        let mut combinations = Vec::new();
        combine(base, order, 0.0, &mut combinations);
        for cycles in combinations {
            // A frequency and its negative give the same motion.
            let part = cycles.rem_euclid(1.0);
            let angle = TAU * part.min(1.0 - part);
            if found.iter().all(|other: &f64| (other - angle).abs() > TAU * SAME) {
                found.push(angle);
            }
        }
    }
    found
}

/// Adds the cycles of all combinations whose order is exactly `order` to `found`, beginning with `sum` cycles.
fn combine(base: &[BaseFrequency], order: usize, sum: f64, found: &mut Vec<f64>) {
    let Some((first, rest)) = base.split_first() else {
        if order == 0 {
            found.push(sum);
        }
        return;
    };
    let most = order * first.harmonics;
    for multiple in 0..=most {
        let left = order - multiple.div_ceil(first.harmonics);
        let cycles = multiple as f64 * first.cycles;
        combine(rest, left, sum + cycles, found);
        if multiple > 0 {
            combine(rest, left, sum - cycles, found);
        }
    }
}

/// Selects as many of the first `candidates` sections as there are unknowns; none if they are ill-conditioned.
fn selected(angles: &[f64], candidates: usize) -> Option<Vec<u64>> {
    let unknowns = count(angles);
    let mut matrix = DMatrix::zeros(unknowns, candidates);
    for (section, mut column) in matrix.column_iter_mut().enumerate() {
        column.copy_from_slice(&row(angles, section as u64));
    }
    let decomposition = matrix.col_piv_qr();
    let triangle = decomposition.r();
    let pivots: Vec<f64> = (0..unknowns).map(|row| triangle[(row, row)].abs()).collect();
    if pivots.iter().any(|pivot| *pivot < WELL_CONDITIONED * pivots[0]) {
        return None;
    }
    let mut sections = RowDVector::from_fn(candidates, |_, section| section as u64);
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
    fn combinations_of_two_frequencies() {
        let found = angles(&[base(0.1), base(0.013)], 2);
        let wanted = [0.0, 0.013, 0.1, 0.026, 0.113, 0.087, 0.2].map(|cycles| TAU * cycles);
        assert_eq!(found.len(), wanted.len());
        for angle in wanted {
            assert!(found.iter().any(|other| (other - angle).abs() < 1e-14), "{angle} is missing");
        }
    }

    #[test]
    fn multiples_of_the_section_are_no_unknowns() {
        assert_eq!(angles(&[base(3.0), base(0.5)], 2), [0.0, PI]);
        // A shaft that turns once in five sections has five states.
        let harmonics = Harmonics::new(&[base(0.2)], 7);
        assert_eq!(harmonics.map(|found| found.unknowns()), Some(5));
    }

    #[test]
    fn harmonics_of_an_excitation_are_of_first_order() {
        let found = angles(&[BaseFrequency { cycles: 0.07, harmonics: 3 }], 1);
        assert_eq!(found.len(), 4);
    }

    #[test]
    fn coefficients_follow_from_the_states() -> Result<(), ()> {
        // Two frequencies that differ by 1e-4 of a turn in a section.
        let harmonics = Harmonics::new(&[base(0.2501), base(0.25)], 2).ok_or(())?;
        let wanted = DMatrix::from_fn(3, harmonics.unknowns(), |row, column| ((row + 5 * column) as f64).sin());
        let states: Vec<_> = harmonics.sections.iter().map(|section| harmonics.state(&wanted, *section)).collect();
        let states = DMatrix::from_fn(3, states.len(), |row, column| states[column][row]);
        let found = harmonics.coefficients(&states).ok_or(())?;
        assert!((found - wanted).amax() < 1e-9);
        Ok(())
    }
}
