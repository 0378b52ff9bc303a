//! Displacement at which a film carries a given static load.

use super::Film;
use crate::bearing_force::{BalanceSearch, BearingForce, Uncarried, Vector};

/// Largest residual force, relative to the load, of a result.
pub(super) const MAX_RESIDUAL: f64 = 1e-6;
/// Eccentricity ratio above which a search that fails means that the journal touches.
pub const TOUCHING_RATIO: f64 = 0.9;
/// Largest eccentricity ratio: closer surfaces touch.
pub const MAX_ECCENTRICITY_RATIO: f64 = 0.99;
/// Displacement across the pivot of a tilting pad with which its search starts, in clearances: right of the equilibrium, which is
/// at 0.1 to 0.3 with a pivot in the middle.
const START_WEDGE: f64 = 0.4;
/// A Newton step may use this part of the clearance that is left.
pub(super) const CLEARANCE_SHARE: f64 = 0.8;

impl Film {
    /// Displacement of the journal across the pivot of a tilting pad, m, with which a search starts at a spin, rad/s.
    pub fn start_wedge(&self, spin: f64) -> f64 {
        START_WEDGE * self.clearance * spin.signum()
    }

    /// Displacement of the journal, m, and the film there, under a static load over (y, z), N, at a spin, rad/s.
    ///
    /// # Errors
    /// [`Uncarried`] if the journal touches the bearing, or comes closer than a hundredth of the clearance, or if the residual force
    /// exceeds `MAX_RESIDUAL` of the load.
    pub fn carrying(&self, load: Vector, spin: f64) -> Result<(Vector, BearingForce), Uncarried> {
        let limit = |ratio: f64| 1.0 - (1.0 - CLEARANCE_SHARE) * (1.0 - ratio);
        let search = BalanceSearch {
            load,
            force: &|e| self.at(e, [0.0; 2], spin),
            added_stiffness: &|_| 0.0,
            is_permitted: &|from, to| self.nearness(to) <= limit(self.nearness(from)),
        };
        // A tilting pad carries where its film narrows in the direction of rotation.
        let wedge = self.start_wedge(spin);
        let start = self.pivot().map_or([0.0; 2], |[y, z]| [-z * wedge, y * wedge]);
        let found = search.from(start);
        match self.nearness(found.displacement) {
            ratio if found.residual <= MAX_RESIDUAL && ratio < MAX_ECCENTRICITY_RATIO => {
                Ok((found.displacement, found.bearing))
            }
            ratio if ratio < TOUCHING_RATIO => Err(Uncarried::Unbalanced(found.residual)),
            _ => Err(Uncarried::Touching),
        }
    }
}
