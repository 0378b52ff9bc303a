//! Elements of a shaft of which the scene gives neither number nor degree, and their dispersion error.

use super::{EXAMINED_LENGTHS, LENGTH_RATIO, RESOLVED_FREQUENCY_ERROR};
use crate::element::Section;
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::{Shaft, description};

/// Largest number of elements of a segment.
const MAX_ELEMENTS: f64 = 100.0;
/// Largest κ = wavenumber × element length that an element of degree p represents, divided by p.
const RESOLVED_WAVENUMBER: f64 = 2.5;
/// Smallest distance between the end of an equal part and a station, in lengths of a part. The highest natural frequency is
/// inversely proportional to the length of the shortest element, and the round-off error of the low modes grows with its
/// square. Lengths and positions are round numbers, so that distances of exactly 0.1 are common: round-off must not decide.
const MIN_STATION_DISTANCE: f64 = 0.1 - 1e-6;

/// A segment of a shaft, with nodes at given positions.
#[derive(Clone, Debug)]
struct Segment {
    /// Length, m.
    length: f64,
    /// Positions in the segment that are nodes, m.
    stations: Vec<f64>,
    /// Waves of bending.
    bending: BendingWave,
    /// Speed of a torsion wave, m/s.
    torsion: f64,
    /// Speed of an axial wave, m/s.
    axial: f64,
}

/// Dispersion of the bending waves of a Timoshenko beam: with the longitudinal speed c, the speed s of shear waves and the
/// radius of gyration r, k⁴ − (1/c² + 1/s²) ω²k² + ω⁴/(c²s²) − ω²/(c²r²) = 0 (Graff 1975, Wave motion in elastic solids,
/// section 3.4).
#[derive(Clone, Copy, Debug)]
struct BendingWave {
    /// 1/c², s²/m².
    longitudinal: f64,
    /// 1/s², s²/m²; zero without shear deformation.
    shear: f64,
    /// 1/(c²r²), s²/m⁴.
    flexural: f64,
}

impl BendingWave {
    /// Largest wavenumber at the angular frequency ω, rad/s, in 1/m.
    fn wavenumber(&self, frequency: f64) -> f64 {
        let square = frequency * frequency;
        let (sum, difference) = (self.longitudinal + self.shear, self.longitudinal - self.shear);
        let root = (square * square * difference * difference + 4.0 * square * self.flexural).sqrt();
        (0.5 * (square * sum + root)).sqrt()
    }

    /// Lowest angular frequency, rad/s, with the wavenumber k, 1/m.
    fn frequency(&self, wavenumber: f64) -> f64 {
        let square = wavenumber * wavenumber;
        let linear = square * (self.longitudinal + self.shear) + self.flexural;
        let root = (linear * linear - 4.0 * self.longitudinal * self.shear * square * square).max(0.0).sqrt();
        square * (2.0 / (linear + root)).sqrt()
    }
}

/// Segments of a shaft.
#[derive(Clone, Debug)]
pub struct Layout {
    segments: Vec<Segment>,
    /// Length of the shaft, m.
    length: f64,
}

impl Layout {
    /// Segments of a checked shaft, whose nodes are the ends of the segments and the places of parts.
    pub fn new(given: &description::Shaft, shaft: &Shaft) -> Self {
        let lengths: Vec<f64> = match &given.segments {
            Some(segments) => segments.iter().map(|segment| segment.length).collect(),
            None => vec![shaft.length()],
        };
        let mut start = 0.0;
        let mut segments = Vec::with_capacity(lengths.len());
        for length in lengths {
            let tolerance = EQUALITY_TOLERANCE * shaft.length();
            let inside = |x: &f64| *x > start + tolerance && *x < start + length - tolerance;
            let stations: Vec<f64> = shaft.nodes.iter().copied().filter(inside).map(|x| x - start).collect();
            // The shortest waves of the segment: cones and sleeves change its section.
            let elements = shaft.elements.iter().zip(&shaft.nodes);
            let within = elements.filter(|(_, x)| **x > start - tolerance && **x < start + length - tolerance);
            let sections: Vec<Section> =
                within.flat_map(|(element, _)| [0.0, 1.0].map(|xi| Section::at(element, shaft.shear, xi))).collect();
            let largest = |of: fn(&Section) -> f64| sections.iter().map(of).fold(0.0, f64::max);
            let bending = BendingWave {
                longitudinal: largest(|section| section.rotary / section.flexural),
                shear: if shaft.shear { largest(|section| section.mass / section.shear) } else { 0.0 },
                flexural: largest(|section| section.mass / section.flexural),
            };
            let torsion = 1.0 / largest(|section| section.polar_mass / section.torsional).sqrt();
            let axial = 1.0 / largest(|section| section.mass / section.axial).sqrt();
            segments.push(Segment { length, stations, bending, torsion, axial });
            start += length;
        }
        Self { segments, length: shaft.length() }
    }

    /// Number of elements of each segment, so that no element is longer than `longest`, m.
    pub fn counts(&self, longest: f64) -> Vec<usize> {
        self.segments.iter().map(|segment| segment.count(longest)).collect()
    }

    /// Number of elements of each segment, no element longer than `longest`, m, whose frequencies up to that of a tone, rad/s,
    /// are resolved.
    pub fn counts_for(&self, tone: f64, longest: f64, degree: usize) -> Vec<usize> {
        let resolves =
            |counts: &[usize]| self.highest_frequency(&self.lengths(counts), degree, RESOLVED_FREQUENCY_ERROR) >= tone;
        let mut counts = self.counts(longest);
        for i in 1..EXAMINED_LENGTHS {
            if resolves(&counts) {
                break;
            }
            counts = self.counts(longest * LENGTH_RATIO.powi(i));
        }
        counts
    }

    /// The largest number of elements below `count` that a segment of this index may have; `None` for the first number.
    pub fn fewer(&self, segment: usize, count: usize) -> Option<usize> {
        (1..count).rev().find(|fewer| self.segments[segment].keeps_clear(*fewer))
    }

    /// Number of elements of the shaft; stations inside a segment divide its equal parts further.
    pub fn elements(&self, counts: &[usize]) -> usize {
        self.segments.iter().zip(counts).map(|(segment, count)| segment.lengths(*count).len()).sum()
    }

    /// Length of the longest element with one element for each segment, m.
    pub fn longest(&self) -> f64 {
        let lengths = self.segments.iter().flat_map(|segment| segment.lengths(1));
        lengths.fold(0.0, f64::max)
    }

    /// What elements of these lengths add to the relative error of the frequency ω, rad/s, of a mode, from its fractions of elastic
    /// energy in the bending, in the torsion and in the axial strain of the shaft.
    pub fn frequency_error(&self, lengths: &[Vec<f64>], degree: usize, frequency: f64, energy: [f64; 3]) -> f64 {
        let mut error = 0.0;
        for (segment, lengths) in self.segments.iter().zip(lengths) {
            for (energy, wavenumber) in energy.into_iter().zip(segment.wavenumbers(frequency)) {
                // A system without bending or axial motion has no energy in it.
                if energy > 0.0 {
                    let sum: f64 = lengths.iter().map(|length| length * dispersion(degree, wavenumber * length)).sum();
                    error += energy * sum / self.length;
                }
            }
        }
        error
    }

    /// Lengths of the elements of each segment, m.
    pub fn lengths(&self, counts: &[usize]) -> Vec<Vec<f64>> {
        self.segments.iter().zip(counts).map(|(segment, count)| segment.lengths(*count)).collect()
    }

    /// Highest frequency, rad/s, at which no element has a larger relative error than `error`.
    pub fn highest_frequency(&self, lengths: &[Vec<f64>], degree: usize, error: f64) -> f64 {
        let most = (error / leading(degree, 1.0)).powf(0.5 / degree as f64);
        let highest = |(segment, lengths): (&Segment, &Vec<f64>)| {
            let length = lengths.iter().copied().fold(0.0, f64::max);
            let wavenumber = most / length;
            (segment.torsion * wavenumber).min(segment.bending.frequency(wavenumber))
        };
        self.segments.iter().zip(lengths).map(highest).fold(f64::INFINITY, f64::min)
    }
}

impl Segment {
    /// Lengths of the elements, m: equal parts, which the stations divide.
    fn lengths(&self, count: usize) -> Vec<f64> {
        let mut ends: Vec<f64> = (0..=count).map(|i| self.length * i as f64 / count as f64).collect();
        let tolerance = EQUALITY_TOLERANCE * self.length;
        for station in &self.stations {
            if ends.iter().all(|end| (end - station).abs() > tolerance) {
                ends.push(*station);
            }
        }
        ends.sort_by(f64::total_cmp);
        ends.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    /// Smallest number of parts for which no element is longer than `longest`, m, and no part ends close to a station.
    fn count(&self, longest: f64) -> usize {
        let most = (self.length / longest).ceil().clamp(1.0, MAX_ELEMENTS) as usize;
        let fits =
            |count: &usize| self.lengths(*count).iter().all(|length| *length <= longest * (1.0 + EQUALITY_TOLERANCE));
        let clear = |count: &usize| self.keeps_clear(*count);
        (1..most).find(|count| fits(count) && clear(count)).or_else(|| (most..=2 * most).find(clear)).unwrap_or(most)
    }

    /// Whether no part ends so close to a station that a very short element remains between them.
    fn keeps_clear(&self, count: usize) -> bool {
        let part = self.length / count as f64;
        self.stations.iter().all(|station| {
            let nearest = (station / part).round();
            let distance = (station / part - nearest).abs();
            // The ends of the segment are places that the scene gives.
            nearest == 0.0
                || nearest == count as f64
                || distance * part <= EQUALITY_TOLERANCE * self.length
                || distance >= MIN_STATION_DISTANCE
        })
    }

    /// Wavenumbers of bending, torsion and axial waves, 1/m.
    fn wavenumbers(&self, frequency: f64) -> [f64; 3] {
        [self.bending.wavenumber(frequency), frequency / self.torsion, frequency / self.axial]
    }
}

/// Relative error of the frequency of a wave in elements of degree p, with κ = wavenumber × element length:
/// ½ (p!/(2p)!)² κ^{2p}/(2p + 1) is the leading term of the dispersion of elements of degree p (Ainsworth, *Discrete
/// dispersion relation for hp-version finite element approximation at high wave number*, SIAM J. Numer. Anal. 42, 2004).
/// The factor exp(−κ²/(9p)) is fitted to the dispersion of p = 2…8 up to κ = 2.5p, within a factor of two; beyond, elements
/// represent no wave. Bending has the same error for p ≥ 2, or a smaller one.
fn dispersion(degree: usize, kappa: f64) -> f64 {
    let p = degree as f64;
    if kappa > RESOLVED_WAVENUMBER * p {
        return 1.0;
    }
    (leading(degree, kappa) * (-kappa * kappa / (9.0 * p)).exp()).min(1.0)
}

/// Leading term of the dispersion.
fn leading(degree: usize, kappa: f64) -> f64 {
    // (2p)!/p! = (p + 1)(p + 2) … 2p.
    let ratio: f64 = (degree + 1..=2 * degree).map(|factor| factor as f64).product();
    let power = kappa.powi(degree as i32) / ratio;
    0.5 * power * power / (2 * degree + 1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leading_terms_are_those_of_the_dispersion() {
        // Linear elements with a consistent mass: (ωh/c)² = 6(1 − cos κ)/(2 + cos κ); at this κ the next term is 1e-4.
        let kappa = 0.02_f64;
        let exact = (6.0 * (1.0 - kappa.cos()) / (2.0 + kappa.cos())).sqrt() / kappa - 1.0;
        assert!((leading(1, kappa) / exact - 1.0).abs() < 1e-3, "{exact}");
        // Quadratic elements: κ⁴/1440 (Thompson and Pinsky, Computational Mechanics 13, 1994).
        assert!((leading(2, kappa) * 1440.0 / kappa.powi(4) - 1.0).abs() < 1e-12);
        assert!(dispersion(2, kappa) < leading(2, kappa));
        assert!((dispersion(2, 10.0) - 1.0).abs() < 1e-15);
    }
}
