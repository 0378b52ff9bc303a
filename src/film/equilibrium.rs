//! Displacement at which a film carries a given static load.

use super::Film;
use crate::bearing_force::{BearingForce, Uncarried, Vector};

/// Largest number of Newton iterations; ten are usual.
const MAX_ITERATIONS: usize = 200;
/// Residual force, relative to the load, below which the iteration has converged.
const TOLERANCE: f64 = 1e-13;
/// Largest residual force, relative to the load, of a result.
const MAX_RESIDUAL: f64 = 1e-6;
/// Eccentricity ratio above which a search that fails means that the journal touches.
pub const TOUCHING: f64 = 0.9;
/// Largest eccentricity ratio: closer surfaces touch.
pub const CLOSEST: f64 = 0.99;
/// A Newton step may use this part of the clearance that is left.
const CLEARANCE_SHARE: f64 = 0.8;
/// Smallest fraction of a Newton step. With a smaller one, the residual changes by round-off only.
const LEAST_FRACTION: f64 = 1e-10;

impl Film {
    /// Displacement of the journal, m, and the film there, under a static load over (y, z), N, at a spin, rad/s.
    ///
    /// # Errors
    /// [`Uncarried`] if the journal touches the bearing, or comes closer than a hundredth of the clearance, or if the residual force
    /// exceeds `MAX_RESIDUAL` of the load.
    pub fn carrying(&self, load: Vector, spin: f64) -> Result<(Vector, BearingForce), Uncarried> {
        let size = |v: Vector| v[0].hypot(v[1]);
        let at = |e: Vector| self.at(e, [0.0; 2], spin);
        let residual = |film: &BearingForce| [load[0] - film.force[0], load[1] - film.force[1]];
        let mut e = [0.0; 2];
        let mut film = at(e);
        'search: for _ in 0..MAX_ITERATIONS {
            let missing = residual(&film);
            if size(missing) <= TOLERANCE * size(load) {
                break;
            }
            let [[a, b], [c, d]] = film.stiffness;
            let determinant = a * d - b * c;
            let step =
                [(d * missing[0] - b * missing[1]) / determinant, (a * missing[1] - c * missing[0]) / determinant];
            let limit = 1.0 - (1.0 - CLEARANCE_SHARE) * (1.0 - self.eccentricity_ratio(e));
            let mut fraction = 1.0;
            loop {
                let next = [e[0] + fraction * step[0], e[1] + fraction * step[1]];
                if self.eccentricity_ratio(next) <= limit {
                    let found = at(next);
                    if size(residual(&found)) < size(missing) {
                        (e, film) = (next, found);
                        break;
                    }
                }
                fraction /= 2.0;
                // Round-off limits the residual, or no load of this size is carried.
                if fraction < LEAST_FRACTION || !fraction.is_finite() {
                    break 'search;
                }
            }
        }
        let (missing, ratio) = (size(residual(&film)), self.eccentricity_ratio(e));
        let is_carried = missing <= MAX_RESIDUAL * size(load);
        match ratio {
            ratio if is_carried && ratio < CLOSEST => Ok((e, film)),
            ratio if ratio < TOUCHING => Err(Uncarried::Unbalanced(missing / size(load))),
            _ => Err(Uncarried::Touching),
        }
    }
}
