//! Tilting pads whose tilt is eliminated: force and coefficients over the displacement of the journal alone.
//!
//! A pad that tilts by δ about its pivot moves its centre of curvature by d = R δ across the direction n of the pivot, and one on
//! a flexible pivot by r along n. With the displacement e of the journal, its film has the displacement e − d t − r n, and
//!
//! ```text
//! (J/R²) d̈ = t·F,    m r̈ + k r = n·F
//! ```
//!
//! At rest t·F vanishes: the resultant passes through the pivot. For a vibration of the frequency ω about the equilibrium, the
//! dynamic stiffness Z = K + iωC of the film and B = (t, n) give the dynamic stiffness of the bearing
//!
//! ```text
//! Z − Z B (Bᵀ Z B + diag(−ω²J/R², k − ω²m))⁻¹ Bᵀ Z
//! ```
//!
//! A pad without load is in no film and counts for nothing.

use num_complex::Complex64;

use super::{FilmPad, Journal, MAX_ECCENTRICITY_RATIO, TOUCHING_RATIO};
use crate::bearing_force::{
    BalanceSearch, BearingForce, FORCE_TOLERANCE, MAX_ITERATIONS, MAX_RESIDUAL, Uncarried, Vector,
};
use crate::film::equilibrium::nearness_after_step;

/// Stiffness of a pad across its pivot, relative to κ|Ω|/c, below which the pad is not loaded.
const UNLOADED_STIFFNESS: f64 = 1e-9;

/// A bearing with tilting pads whose tilt is eliminated.
#[derive(Clone, Debug)]
pub struct TiltingPads {
    pads: Vec<TiltingPad>,
    /// Radial clearance c of the pads, m.
    clearance: f64,
}

#[derive(Clone, Debug)]
struct TiltingPad {
    film: FilmPad,
    /// Direction n of the pivot.
    pivot: Vector,
    /// J/R², kg.
    tilt_mass: f64,
    /// Mass, kg, and stiffness of the pivot, N/m; none for a rigid pivot.
    spring: Option<[f64; 2]>,
}

/// The film of a pad at rest.
struct AtRest {
    film: BearingForce,
    /// Displacement of the journal relative to the pad, m.
    displacement: Vector,
    is_loaded: bool,
}

/// The film of a pad at a tilt.
struct Tilted {
    film: BearingForce,
    nearness: f64,
}

impl TiltingPads {
    /// The pads of a checked bearing with tilting pads whose shaft turns in a direction, 1 or −1; none for another bearing.
    pub fn new(journal: &Journal, direction: f64) -> Option<Self> {
        let tilting = journal.tilting.as_ref()?;
        let pad = |pad| {
            let (sin, cos) = journal.tilting_pad(pad, 1.0).closest(1.0).sin_cos();
            TiltingPad {
                film: FilmPad::new(journal, &journal.tilting_pad(pad, direction), direction),
                pivot: [cos, sin],
                tilt_mass: tilting.tilt_mass(journal),
                spring: tilting.spring,
            }
        };
        Some(Self { pads: journal.pads.iter().map(pad).collect(), clearance: journal.clearance })
    }

    /// Radial clearance c of the pads, m.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// Whether its pads are made for the other direction of rotation than that of a spin.
    pub fn widens(&self, spin: f64) -> bool {
        self.pads.iter().any(|pad| pad.film.widens(spin))
    }

    /// Part of the clearance that the journal has used at the nearest pivot: 1 where it touches the pad there.
    pub fn nearness(&self, displacement: Vector) -> f64 {
        let at = |pad: &TiltingPad| {
            let u = pad.film.displacement(displacement);
            u[0] * pad.pivot[0] + u[1] * pad.pivot[1]
        };
        let larger = |most: f64, value: f64| if value > most || value.is_nan() { value } else { most };
        self.pads.iter().map(at).fold(0.0, larger)
    }

    /// Displacement of the journal relative to a pad at rest, m, for a displacement, m, and a spin, rad/s.
    pub fn relative(&self, pad: usize, displacement: Vector, spin: f64) -> Vector {
        self.pads[pad].at_rest(displacement, spin).displacement
    }

    /// Force, stiffness and damping at a displacement, m, at rest at a spin of the shaft, rad/s, with the coefficients for
    /// vibrations of a frequency, rad/s; the damping at the frequency 0 is its limit.
    pub fn at(&self, displacement: Vector, spin: f64, frequency: f64) -> BearingForce {
        let mut sum = BearingForce::default();
        for pad in &self.pads {
            let AtRest { film, is_loaded, .. } = pad.at_rest(displacement, spin);
            if !is_loaded {
                continue;
            }
            let [stiffness, damping] = pad.reduced(&film, frequency);
            for i in 0..2 {
                sum.force[i] += film.force[i];
                for j in 0..2 {
                    sum.stiffness[i][j] += stiffness[i][j];
                    sum.damping[i][j] += damping[i][j];
                }
            }
        }
        sum
    }

    /// Displacement of the journal, m, and the coefficients there at a frequency, rad/s, under a static load over (y, z), N, at a
    /// spin, rad/s.
    ///
    /// # Errors
    /// [`Uncarried`] as for a film of fixed geometry.
    pub fn carrying(&self, load: Vector, spin: f64, frequency: f64) -> Result<(Vector, BearingForce), Uncarried> {
        let search = BalanceSearch {
            load,
            force: &|e| self.at(e, spin, 0.0),
            // A bearing of which no pad is loaded yet has no stiffness.
            added_stiffness: &|residual| residual.min(1.0) * load[0].hypot(load[1]) / self.clearance,
            is_permitted: &|from, to| self.nearness(to) <= nearness_after_step(self.nearness(from)),
        };
        let found = search.from([0.0; 2]);
        match self.nearness(found.displacement) {
            ratio if found.residual <= MAX_RESIDUAL && ratio < MAX_ECCENTRICITY_RATIO => {
                Ok((found.displacement, self.at(found.displacement, spin, frequency)))
            }
            ratio if ratio < TOUCHING_RATIO => Err(Uncarried::Unbalanced(found.residual)),
            _ => Err(Uncarried::Touching),
        }
    }
}

impl TiltingPad {
    /// The film for a journal at a displacement, m, at which the resultant passes through the pivot and deflects it.
    fn at_rest(&self, displacement: Vector, spin: f64) -> AtRest {
        let ([y, z], Some([_, stiffness])) = (self.pivot, self.spring) else { return self.tilted(displacement, spin) };
        let mut deflection = 0.0;
        let mut found = self.tilted(displacement, spin);
        for _ in 0..MAX_ITERATIONS {
            let [force, slope] = [found.film.force, self.along(&found.film)].map(|v| y * v[0] + z * v[1]);
            let residual = force - stiffness * deflection;
            if residual.abs() <= FORCE_TOLERANCE * self.film.scale * spin.abs() {
                break;
            }
            deflection += residual / (stiffness + slope.max(0.0));
            found = self.tilted([displacement[0] - y * deflection, displacement[1] - z * deflection], spin);
        }
        found
    }

    /// Change of the force per displacement of the journal along the pivot, N/m, with the tilt that follows.
    fn along(&self, film: &BearingForce) -> Vector {
        let ([y, z], [tilting, _]) = (self.pivot, self.reduced_rigid(film, 0.0));
        [tilting[0][0] * y + tilting[0][1] * z, tilting[1][0] * y + tilting[1][1] * z]
    }

    /// The film with the tilt at which the moment about the pivot vanishes.
    ///
    /// The moment is a convex function of the displacement b across the pivot where the film narrows in the direction of rotation
    /// more than at rest, so that Newton's method goes to the equilibrium from there. Without one, b leads out of the film.
    fn tilted(&self, displacement: Vector, spin: f64) -> AtRest {
        let ([y, z], clearance) = (self.pivot, self.film.clearance);
        let (along, across) = (displacement[0] * y + displacement[1] * z, [-z, y]);
        let at = |b: f64| {
            let relative = [along * y + b * across[0], along * z + b * across[1]];
            let (mut film, nearness) = (BearingForce::default(), self.film.nearness(relative));
            if nearness < 1.0 {
                self.film.add(relative, [0.0; 2], spin / 2.0, &mut film);
            }
            Tilted { film, nearness }
        };
        let sign = spin.signum();
        let moment = |at: &Tilted| sign * (across[0] * at.film.force[0] + across[1] * at.film.force[1]);
        let slope = |Tilted { film, .. }: &Tilted| {
            (0..2).map(|i| (0..2).map(|j| across[i] * film.stiffness[i][j] * across[j]).sum::<f64>()).sum::<f64>()
        };
        let scale = self.film.scale * spin.abs();
        let least = UNLOADED_STIFFNESS * scale / clearance;
        let mut b = sign * clearance;
        let mut found = at(b);
        while found.nearness > TOUCHING_RATIO && b.abs() > f64::EPSILON * clearance {
            b /= 2.0;
            found = at(b);
        }
        for _ in 0..MAX_ITERATIONS {
            let (residual, stiffness) = (moment(&found), slope(&found));
            if residual.abs() <= FORCE_TOLERANCE * scale || stiffness <= least {
                break;
            }
            let mut step = -sign * (residual / stiffness).clamp(-clearance / 2.0, clearance / 2.0);
            let limit = nearness_after_step(found.nearness);
            let mut next = at(b + step);
            let is_beyond = |next: &Tilted| next.nearness > limit || slope(next) <= least && moment(next) < 0.0;
            while is_beyond(&next) && step.abs() > f64::EPSILON * clearance {
                step /= 2.0;
                next = at(b + step);
            }
            (b, found) = (b + step, next);
            if step.abs() <= f64::EPSILON * clearance {
                break;
            }
        }
        let displacement = [along * y + b * across[0], along * z + b * across[1]];
        AtRest { is_loaded: slope(&found) > least, displacement, film: found.film }
    }

    /// Stiffness, N/m, and damping, N s/m, for vibrations of a frequency, rad/s, with a rigid pivot.
    fn reduced_rigid(&self, film: &BearingForce, frequency: f64) -> [[[f64; 2]; 2]; 2] {
        let [y, z] = self.pivot;
        eliminated([film.stiffness, film.damping], [-z, y], -self.tilt_mass * frequency * frequency, frequency)
    }

    /// Stiffness, N/m, and damping, N s/m, for vibrations of a frequency, rad/s.
    fn reduced(&self, film: &BearingForce, frequency: f64) -> [[[f64; 2]; 2]; 2] {
        let rigid = self.reduced_rigid(film, frequency);
        match self.spring {
            None => rigid,
            Some([mass, stiffness]) => {
                eliminated(rigid, self.pivot, stiffness - mass * frequency * frequency, frequency)
            }
        }
    }
}

/// Smallest frequency of a reduction, rad/s: the limit of the damping at the frequency 0.
const LEAST_FREQUENCY: f64 = 1e-3;

/// Stiffness and damping after the elimination of a motion of a pad along a unit vector, on a dynamic stiffness of its own, N/m.
fn eliminated([stiffness, damping]: [[[f64; 2]; 2]; 2], b: Vector, own: f64, frequency: f64) -> [[[f64; 2]; 2]; 2] {
    let frequency = frequency.abs().max(LEAST_FREQUENCY);
    let z = [0, 1].map(|i| [0, 1].map(|j| Complex64::new(stiffness[i][j], frequency * damping[i][j])));
    let right = [0, 1].map(|i| z[i][0] * b[0] + z[i][1] * b[1]);
    let left = [0, 1].map(|j| z[0][j] * b[0] + z[1][j] * b[1]);
    let pivot = right[0] * b[0] + right[1] * b[1] + own;
    let entry = |i: usize, j: usize| z[i][j] - right[i] * left[j] / pivot;
    [[0, 1].map(|i| [0, 1].map(|j| entry(i, j).re)), [0, 1].map(|i| [0, 1].map(|j| entry(i, j).im / frequency))]
}
