//! Elements of a shaft of which the scene gives neither number nor degree, and their dispersion error.

use crate::scene::{Material, Shaft, description};

/// Largest number of elements of a segment.
const MAX_ELEMENTS: f64 = 100.0;

/// A segment of a shaft: a uniform cross-section, with nodes at given positions.
#[derive(Clone, Debug)]
struct Segment {
    /// Length, m.
    length: f64,
    /// Positions in the segment that are nodes, m.
    stations: Vec<f64>,
    /// Angular frequency of a bending wave over the square of its wavenumber, m²/s.
    bending: f64,
    /// Speed of a torsion wave, m/s.
    torsion: f64,
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
            let tolerance = 1e-9 * shaft.length();
            let inside = |x: &f64| *x > start + tolerance && *x < start + length - tolerance;
            let stations: Vec<f64> = shaft.nodes.iter().copied().filter(inside).map(|x| x - start).collect();
            let element = shaft.nodes.partition_point(|x| *x <= start + tolerance).max(1) - 1;
            let element = shaft.elements[element.min(shaft.elements.len() - 1)];
            let Material { youngs_modulus, shear_modulus, density, .. } = shaft.material;
            // Radius of gyration of the section.
            let gyration = element.outer_radius.hypot(element.inner_radius) / 2.0;
            segments.push(Segment {
                length,
                stations,
                bending: (youngs_modulus / density).sqrt() * gyration,
                torsion: (shear_modulus / density).sqrt(),
            });
            start += length;
        }
        Self { segments, length: shaft.length() }
    }

    /// Number of elements of each segment, so that no element is longer than `longest`, m.
    pub fn counts(&self, longest: f64) -> Vec<usize> {
        self.segments.iter().map(|segment| segment.count(longest)).collect()
    }

    /// Number of elements of the shaft.
    pub fn elements(&self, counts: &[usize]) -> usize {
        self.segments.iter().zip(counts).map(|(segment, count)| segment.lengths(*count).len()).sum()
    }

    /// Length of the longest element with one element for each segment, m.
    pub fn longest(&self) -> f64 {
        let lengths = self.segments.iter().flat_map(|segment| segment.lengths(1));
        lengths.fold(0.0, f64::max)
    }

    /// Relative errors of a frequency ω, rad/s, at which the shaft vibrates in bending and in torsion, by the element
    /// lengths of each segment.
    pub fn frequency_errors(&self, lengths: &[Vec<f64>], degree: usize, frequency: f64) -> [f64; 2] {
        let mut errors = [0.0; 2];
        for (segment, lengths) in self.segments.iter().zip(lengths) {
            for (error, wavenumber) in errors.iter_mut().zip(segment.wavenumbers(frequency)) {
                let sum: f64 = lengths.iter().map(|length| length * dispersion(degree, wavenumber * length)).sum();
                *error += sum / self.length;
            }
        }
        errors
    }

    /// Lengths of the elements of each segment, m.
    pub fn lengths(&self, counts: &[usize]) -> Vec<Vec<f64>> {
        self.segments.iter().zip(counts).map(|(segment, count)| segment.lengths(*count)).collect()
    }

    /// Highest frequency, rad/s, at which no element has a larger relative error than `error`.
    pub fn highest_frequency(&self, lengths: &[Vec<f64>], degree: usize, error: f64) -> f64 {
        let most = (error / dispersion(degree, 1.0)).powf(0.5 / degree as f64);
        let highest = |(segment, lengths): (&Segment, &Vec<f64>)| {
            let length = lengths.iter().copied().fold(0.0, f64::max);
            let wavenumber = most / length;
            (segment.torsion * wavenumber).min(segment.bending * wavenumber * wavenumber)
        };
        self.segments.iter().zip(lengths).map(highest).fold(f64::INFINITY, f64::min)
    }
}

impl Segment {
    /// Lengths of the elements, m: equal parts, which the stations divide.
    fn lengths(&self, count: usize) -> Vec<f64> {
        let mut ends: Vec<f64> = (0..=count).map(|i| self.length * i as f64 / count as f64).collect();
        let tolerance = 1e-9 * self.length;
        for station in &self.stations {
            if ends.iter().all(|end| (end - station).abs() > tolerance) {
                ends.push(*station);
            }
        }
        ends.sort_by(f64::total_cmp);
        ends.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    /// Smallest number of parts for which no element is longer than `longest`, m.
    fn count(&self, longest: f64) -> usize {
        let most = (self.length / longest).ceil().clamp(1.0, MAX_ELEMENTS) as usize;
        let fits = |count: &usize| self.lengths(*count).iter().all(|length| *length <= longest * (1.0 + 1e-9));
        (1..most).find(fits).unwrap_or(most)
    }

    /// Wavenumbers of bending and torsion waves, 1/m.
    fn wavenumbers(&self, frequency: f64) -> [f64; 2] {
        [(frequency / self.bending).sqrt(), frequency / self.torsion]
    }
}

/// Relative error of the frequency of a wave in elements of degree p, with κ = wavenumber × element length:
/// ½ (p!/(2p)!)² κ^{2p}/(2p + 1), the leading term of the dispersion of elements of degree p (Ainsworth, *Discrete
/// dispersion relation for hp-version finite element approximation at high wave number*, SIAM J. Numer. Anal. 42, 2004).
/// Bending has the same error for p ≥ 2, within a factor of two.
fn dispersion(degree: usize, kappa: f64) -> f64 {
    // (2p)!/p! = (p + 1)(p + 2) … 2p.
    let ratio: f64 = (degree + 1..=2 * degree).map(|factor| factor as f64).product();
    let power = kappa.powi(degree as i32) / ratio;
    0.5 * power * power / (2 * degree + 1) as f64
}
