//! Displacement at which a film carries a given static load.

use std::f64::consts::TAU;

use super::Film;
use crate::bearing_force::{Balance, BalanceSearch, BearingForce, MAX_RESIDUAL, Uncarried, Vector};

/// Eccentricity ratio above which a search that fails means that the journal touches.
pub const TOUCHING_RATIO: f64 = 0.9;
/// Largest eccentricity ratio: closer surfaces touch.
pub const MAX_ECCENTRICITY_RATIO: f64 = 0.99;
/// Displacement across the pivot of a tilting pad with which its search starts, in clearances: right of the equilibrium, which is
/// at 0.1 to 0.3 with a pivot in the middle.
const START_WEDGE: f64 = 0.4;
/// Distances from the centre, in clearances, and number of directions from that of the load, with which a search starts that finds
/// nothing from the centre.
const START_RATIOS: [f64; 3] = [0.3, 0.6, 0.8];
const START_DIRECTIONS: usize = 8;
/// A Newton step may use this part of the clearance that is left.
const CLEARANCE_SHARE: f64 = 0.8;

/// Largest part of the clearance that may be used after a Newton step from a displacement that uses a part of it.
pub fn nearness_after_step(nearness: f64) -> f64 {
    1.0 - (1.0 - CLEARANCE_SHARE) * (1.0 - nearness).max(0.0)
}

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
        let search = BalanceSearch {
            load,
            force: &|e| self.at(e, [0.0; 2], spin),
            added_stiffness: &|_| 0.0,
            is_permitted: &|from, to| self.nearness(to) <= nearness_after_step(self.nearness(from)),
        };
        // A tilting pad carries where its film narrows in the direction of rotation.
        let wedge = self.start_wedge(spin);
        let start = self.pivot().map_or([0.0; 2], |[y, z]| [-z * wedge, y * wedge]);
        let carries = |found: &Balance<2>| {
            found.residual <= MAX_RESIDUAL && self.nearness(found.displacement) < MAX_ECCENTRICITY_RATIO
        };
        let first = search.from(start);
        let others = || self.starts(load).map(|start| search.from(start)).find(carries);
        match Some(first).filter(carries).or_else(others) {
            Some(found) => Ok((found.displacement, found.bearing)),
            None if self.nearness(first.displacement) < TOUCHING_RATIO => Err(Uncarried::Unbalanced(first.residual)),
            None => Err(Uncarried::Touching),
        }
    }

    /// Other displacements, m, with which a search under a load starts: a film that widens along the rotation has no stiffness
    /// near its centre. A tilting pad has none: the film of one that widens carries nothing.
    fn starts(&self, load: Vector) -> impl Iterator<Item = Vector> {
        let along = load[1].atan2(load[0]);
        let place = move |number: usize| {
            let (sin, cos) = (along + TAU * (number % START_DIRECTIONS) as f64 / START_DIRECTIONS as f64).sin_cos();
            let radius = START_RATIOS[number / START_DIRECTIONS] * self.clearance;
            [radius * cos, radius * sin]
        };
        let count = if self.pivot().is_some() { 0 } else { START_RATIOS.len() * START_DIRECTIONS };
        (0..count).map(place).filter(|start| self.nearness(*start) < 1.0)
    }
}
