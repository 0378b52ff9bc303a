//! Dynamic stiffness S(λ) = λ²M + λ(C + ΩG) + K as band matrices of the shafts, and couplings between them.
//!
//! The circular coordinates p = v + iw (forward) and m = v − iw (backward) of each node uncouple the two planes of a shaft:
//! the gyroscopic term is −iλΩ_s G_s for p and +iλΩ_s G_s for m. A shaft is therefore three chains, p, m and torsion,
//! and a fourth one where it moves along its axis. A
//! bearing with the same coefficients in every direction belongs to the chains. Other bearings couple p and m of their
//! node, and a mesh couples those of its two gears. The inertia of supports and housings couples none of their coordinates.
//!
//! `circular.rs` has the order of the circular coordinates, in which the internal coordinates of an element lie between
//! those of its nodes.

use std::sync::Arc;

use num_complex::Complex64;

use super::shaft::{Chain, ShaftModel};
use super::{HousingInertia, Link, Model, Support};
use crate::connection::{Connection, Row};
use crate::linalg::{BandChain, ChainMatrix, CoupledChains, Structure};

/// Structural damping, ηK of the elements with a loss factor η, in a motion of the frequency ω at a speed of the reference
/// shaft. The force i sgn(ω) ηK u of an element that stands still does the same work in each cycle, whatever the frequency is.
/// Relative to a shaft of the speed Ω_s, the circular coordinate p = v + iw of a motion p e^{iωt} has the frequency ω − Ω_s, and
/// m = v − iw the frequency ω + Ω_s.
#[derive(Clone, Copy, Debug)]
pub struct StructuralDamping {
    /// Frequency ω, rad/s.
    pub frequency: f64,
    /// Speed of the reference shaft, rad/s.
    pub speed: f64,
}

impl StructuralDamping {
    /// i sgn ω.
    pub fn standing(&self) -> Complex64 {
        self.relative_to(0.0)
    }

    /// i sgn(ω − Ω_s) and i sgn(ω + Ω_s) for p and m of a shaft with this speed ratio.
    pub fn turning(&self, ratio: f64) -> [Complex64; 2] {
        let spin = ratio * self.speed;
        [self.relative_to(spin), self.relative_to(-spin)]
    }

    /// i times the sign of the frequency relative to a rotation: zero where both are equal up to round-off.
    fn relative_to(&self, rotation: f64) -> Complex64 {
        let relative = self.frequency - rotation;
        let is_zero = relative.abs() <= SAME_ROTATION * rotation.abs();
        Complex64::new(0.0, if is_zero { 0.0 } else { relative.signum() })
    }
}

/// Relative difference of a frequency from the speed of a shaft that round-off causes.
pub const SAME_ROTATION: f64 = 1e-13;

/// Weights of the matrices in S = stiffness·K + damping·C + mass·M + gyroscopic·G + structural damping, where G is that of the
/// unit speed of the reference shaft.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// Factor of K.
    pub stiffness: Complex64,
    /// Structural damping; `None` without it.
    pub structural: Option<StructuralDamping>,
    /// Factor of C.
    pub damping: Complex64,
    /// Factor of M.
    pub mass: Complex64,
    /// Factor of G.
    pub gyroscopic: Complex64,
    /// Whether K contains only the symmetric part of the stiffness of the bearings.
    pub symmetric: bool,
}

impl Weights {
    /// Weights of S(λ) at a speed of the reference shaft, rad/s; λ in rad/s.
    pub fn dynamic(eigenvalue: Complex64, speed: f64) -> Self {
        Self {
            stiffness: Complex64::ONE,
            structural: None,
            damping: eigenvalue,
            mass: eigenvalue * eigenvalue,
            gyroscopic: eigenvalue * speed,
            symmetric: false,
        }
    }

    /// Weights of S(iω) of a harmonic motion of the frequency ω at a speed of the reference shaft, both rad/s, with structural
    /// damping.
    pub fn harmonic(frequency: f64, speed: f64) -> Self {
        let structural = Some(StructuralDamping { frequency, speed });
        Self { structural, ..Self::dynamic(Complex64::new(0.0, frequency), speed) }
    }

    /// Weights of S(λ) of a mode at a speed of the reference shaft, rad/s, with the structural damping of the frequency Im λ.
    /// A motion without oscillation has none.
    pub fn mode(eigenvalue: Complex64, speed: f64) -> Self {
        let damping = StructuralDamping { frequency: eigenvalue.im, speed };
        Self { structural: (eigenvalue.im != 0.0).then_some(damping), ..Self::dynamic(eigenvalue, speed) }
    }

    /// Factor of the stiffness of an element with a loss factor.
    fn stiffness_of(&self, loss_factor: f64) -> Complex64 {
        self.stiffness + self.structural.map_or(Complex64::ZERO, |damping| damping.standing() * loss_factor)
    }

    /// Weights of ∂S/∂λ.
    pub fn slope(eigenvalue: Complex64, speed: f64) -> Self {
        Self {
            stiffness: Complex64::ZERO,
            structural: None,
            damping: Complex64::ONE,
            mass: 2.0 * eigenvalue,
            gyroscopic: Complex64::from(speed),
            symmetric: false,
        }
    }

    /// Weights of K.
    pub fn stiffness() -> Self {
        Self::dynamic(Complex64::ZERO, 0.0)
    }
}

impl Model {
    /// Takes the order of elimination of another model that has the same coordinates, and couplings in the same places.
    pub fn share_order(&mut self, other: &Self) {
        self.structure = Arc::clone(&other.structure);
    }

    /// Weighted sum of the matrices of shafts, bearings and connections, with the loaded flanks at `speed` (reference
    /// shaft, rad/s).
    pub fn dynamic_stiffness(&self, weights: &Weights, speed: f64) -> CoupledChains {
        let mut sum = self.shaft_stiffness(weights);
        for connection in self.connections(speed).filter(Connection::is_local) {
            let (rows, coefficients) = (connection.rows(), connection.linear(speed));
            let factor = weights.stiffness_of(connection.loss_factor());
            self.add_form(&mut sum, &rows, |i, j| {
                factor * coefficients.stiffness[(i, j)] + weights.damping * coefficients.damping[(i, j)]
            });
        }
        sum
    }

    /// Weighted sum of the matrices of shafts and bearings.
    pub fn shaft_stiffness(&self, weights: &Weights) -> CoupledChains {
        let structure = self.structure.get_or_init(|| Arc::new(self.find_structure()));
        let mut sum = self.chains(weights, Arc::clone(structure));
        let speed = self.circulation.filter(|_| !weights.symmetric).unwrap_or_default();
        let stiffness_from_frame = |support: &Support| support.stiffness_from_frame(speed);
        for support in &self.supports {
            let stiffness = if weights.symmetric { &support.symmetric_part } else { &support.stiffness };
            let factor = weights.stiffness_of(support.loss_factor);
            for (i, (stiffness, damping)) in stiffness.iter().zip(&support.damping).enumerate() {
                for (j, (stiffness, damping)) in stiffness.iter().zip(damping).enumerate() {
                    let value = factor * *stiffness + weights.damping * *damping;
                    let value = value + weights.stiffness * stiffness_from_frame(support)[i][j];
                    self.add_entry(&mut sum, support.index + i, support.index + j, value);
                }
            }
        }
        for Link { rows, local, .. } in &self.links {
            let stiffness = if weights.symmetric { &local.symmetric_part } else { &local.stiffness };
            let factor = weights.stiffness_of(local.loss_factor);
            let frame = stiffness_from_frame(local);
            self.add_form(&mut sum, rows, |i, j| {
                factor * stiffness[i][j] + weights.damping * local.damping[i][j] + weights.stiffness * frame[i][j]
            });
        }
        if let Some(speed) = self.circulation.filter(|_| !weights.symmetric) {
            self.add_planets(&mut sum, speed, weights.stiffness);
        }
        sum
    }

    /// Weighted sum of the matrices of shafts and of the inertia of housings.
    fn chains(&self, weights: &Weights, structure: Arc<Structure>) -> CoupledChains {
        let mut sum = CoupledChains::new(structure);
        for shaft in &self.shafts {
            push_bending(&mut sum, shaft, weights, self.circulation);
            let stiffness = weights.stiffness_of(shaft.loss_factor);
            shaft.rods().for_each(|chain| sum.push(weighted_sum(chain, &Weights { stiffness, ..*weights })));
        }
        push_housings(&mut sum, &self.housings, weights);
        sum
    }

    /// Structure of the matrices at all speeds and frequencies: that of a matrix in which every element couples all its scalars.
    fn find_structure(&self) -> Structure {
        let one = Complex64::ONE;
        let standing = Weights::stiffness();
        let mut sum = self.chains(&Weights { damping: one, mass: one, gyroscopic: one, ..standing }, Arc::default());
        for Support { index, .. } in &self.supports {
            for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                self.add_entry(&mut sum, index + row, index + column, one);
            }
        }
        for Link { rows, .. } in &self.links {
            self.add_form(&mut sum, rows, |_, _| one);
        }
        for connection in self.connections(0.0).filter(Connection::is_local) {
            self.add_form(&mut sum, &connection.rows(), |_, _| one);
        }
        self.add_planets(&mut sum, 1.0, one);
        sum.structure()
    }

    /// Diagonal entries of the stiffness matrix of the shafts, and of the links at supports and housings (one where these
    /// have none), n entries in the order of the core.
    pub fn chain_stiffness(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.len()];
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                chain.stiffness.for_each(|row, column, value| {
                    if row == column {
                        diagonal[chain.start + 2 * row..chain.start + 2 * row + 2].fill(value);
                    }
                });
            }
            for chain in shaft.rods() {
                chain.stiffness.for_each(|row, column, value| {
                    if row == column {
                        diagonal[chain.start + row] = value;
                    }
                });
            }
        }
        let housings = self.housings.coordinates();
        for Link { rows, local, .. } in &self.links {
            for (i, row) in rows.iter().enumerate() {
                for (index, coefficient) in row.iter().filter(|(index, _)| housings.contains(index)) {
                    diagonal[*index] += local.symmetric_part[i][i] * coefficient * coefficient;
                }
            }
        }
        diagonal[housings].iter_mut().filter(|value| **value == 0.0).for_each(|value| *value = 1.0);
        diagonal
    }

    /// Adds Σᵢⱼ value(i, j)·rᵢ·rⱼᵀ, where rᵢ is the vector `rows[i]`.
    pub fn add_form(&self, sum: &mut CoupledChains, rows: &[Row], value: impl Fn(usize, usize) -> Complex64) {
        // Motions with the force on each for a unit force on the row, and the part of each in the displacement of the row.
        let mut circular = |row: &Row| {
            let mut motions = Vec::with_capacity(2 * row.len().min(2));
            for part in self.housings.parts(row) {
                let [(index, factor)] = *part else {
                    motions.push((sum.combination(part), Complex64::ONE, Complex64::ONE));
                    continue;
                };
                let circular = self.circular(index).into_iter().flatten();
                motions.extend(circular.map(|(motion, force, place)| (motion, force * factor, place * factor)));
            }
            motions
        };
        let motions: Vec<_> = rows.iter().map(&mut circular).collect();
        for (i, left) in motions.iter().enumerate() {
            for (j, right) in motions.iter().enumerate() {
                let value = value(i, j);
                if value == Complex64::ZERO {
                    continue;
                }
                for (row, force, _) in left {
                    for (column, _, displacement) in right {
                        sum.add(*row, *column, value * force * displacement);
                    }
                }
            }
        }
    }
}

/// Appends the chains p and m of a shaft, with its circulatory forces and those of its frame at the speed `circulation`, rad/s.
fn push_bending(sum: &mut CoupledChains, shaft: &ShaftModel, weights: &Weights, circulation: Option<f64>) {
    let Some(chain) = &shaft.bending else {
        return;
    };
    let band = weighted_sum(chain, weights);
    for sign in [-1.0, 1.0] {
        let mut band = band.clone();
        add(&mut band, &shaft.gyroscopic, weights.gyroscopic * Complex64::new(0.0, sign * shaft.ratio));
        add(&mut band, &chain.mass, weights.gyroscopic * Complex64::new(0.0, -2.0 * sign * shaft.frame));
        if let Some(speed) = circulation.filter(|_| !weights.symmetric && shaft.frame != 0.0) {
            let (turn, square) = (weights.stiffness * speed * shaft.frame, weights.stiffness * speed * speed);
            add(&mut band, &chain.mass, -square * shaft.frame * shaft.frame);
            add(&mut band, &shaft.gyroscopic, square * shaft.frame * shaft.ratio);
            if let Some(damping) = &chain.damping {
                add(&mut band, damping, turn * Complex64::new(0.0, -sign));
            }
        }
        if let (Some(circulatory), Some(speed), false) = (&shaft.circulatory, circulation, weights.symmetric) {
            let weight = weights.stiffness * Complex64::new(0.0, sign * shaft.ratio * speed);
            add(&mut band, circulatory, weight);
        }
        if let (Some(structural), Some(damping)) = (&shaft.structural, weights.structural) {
            let [forward, backward] = damping.turning(shaft.ratio);
            add(&mut band, structural, if sign < 0.0 { forward } else { backward });
        }
        sum.push(band);
    }
}

/// Appends the coordinates of supports and housings, whose inertia couples none of them.
fn push_housings(sum: &mut CoupledChains, housings: &HousingInertia, weights: &Weights) {
    let mut band = BandChain::zeros(housings.inertia.len(), 0);
    housings.inertia.iter().enumerate().for_each(|(row, inertia)| band.add(row, row, weights.mass * *inertia));
    sum.push(band);
}

/// stiffness·K + mass·M + damping·C of a chain, without gyroscopic terms.
fn weighted_sum<const B: usize, E>(chain: &Chain<B, E>, weights: &Weights) -> BandChain {
    let mut band = zeros(&chain.stiffness);
    add(&mut band, &chain.stiffness, weights.stiffness);
    add(&mut band, &chain.mass, weights.mass);
    if let Some(damping) = &chain.damping {
        add(&mut band, damping, weights.damping);
    }
    band
}

/// Zero band matrix for the coordinates of a chain.
fn zeros<const B: usize>(matrix: &ChainMatrix<B>) -> BandChain {
    let order = matrix.band_order();
    BandChain::zeros(order.len(), order.reach())
}

/// Adds `weight` times a matrix of the chain.
fn add<const B: usize>(band: &mut BandChain, matrix: &ChainMatrix<B>, weight: Complex64) {
    if weight != Complex64::ZERO {
        let order = matrix.band_order();
        matrix.for_each(|row, column, value| band.add(order.row(row), order.row(column), weight * value));
    }
}
