//! Oil film of a journal bearing: force of the journal on the film, and its derivatives.
//!
//! The film is isoviscous, incompressible and laminar, and cannot pull. The journal is parallel to the bearing. With the
//! displacement u = e/c of its centre, in clearances, the film has the thickness c(1 − u·e_α) at the angle α. Reynolds'
//! equation contains the speed Ω and the velocity u̇ only as
//!
//! ```text
//! w = u̇ − (Ω/2) x × u
//! ```
//!
//! the velocity in a frame that turns at Ω/2 (Childs, Moes and van Leeuwen, J. Lubr. Technol. 99, 1977, call it the pure
//! squeeze velocity). The force of the journal on the film is
//!
//! ```text
//! F = κ |w| f(u, w/|w|),    κ = μ R L³/c²
//! ```
//!
//! `short.rs` has f for a short film in closed form. `reynolds.rs` solves Reynolds' equation for a film of finite length,
//! `table.rs` and `spline.rs` interpolate its solutions, and `equilibrium.rs` finds the displacement under a load.

mod equilibrium;
mod reynolds;
mod short;
mod spline;
mod table;

use std::sync::Arc;

pub use equilibrium::{MAX_ECCENTRICITY_RATIO, TOUCHING_RATIO};
pub use reynolds::Reynolds;
pub use table::FilmTable;

use crate::bearing_force::{BearingForce, Matrix, Vector};
use crate::scene::{FilmKind, Journal};

/// Dimensionless force f and its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// |w| f.
    pub force: Vector,
    /// ∂(|w| f)/∂u at constant w.
    pub displacement: Matrix,
    /// ∂(|w| f)/∂w at constant u.
    pub velocity: Matrix,
}

/// The law of a film.
#[derive(Clone, Debug)]
enum Law {
    /// Short film, closed form.
    Short,
    /// Film of finite length, interpolated.
    Finite(Arc<FilmTable>),
}

/// The oil film of a journal bearing.
#[derive(Clone, Debug)]
pub struct Film {
    law: Law,
    /// Radial clearance c, m.
    clearance: f64,
    /// κ = μ R L³/c², N s.
    scale: f64,
}

impl Film {
    /// The film of a checked journal bearing. A finite film computes its table, or finds it among the known ones.
    pub fn new(journal: &Journal) -> Self {
        let Journal { diameter, length, clearance, viscosity, film } = journal;
        let law = match film {
            FilmKind::Short => Law::Short,
            FilmKind::Finite(grooves) => Law::Finite(FilmTable::known(length / diameter, grooves)),
        };
        let scale = viscosity * diameter / 2.0 * length.powi(3) / (clearance * clearance);
        Self { law, clearance: *clearance, scale }
    }

    /// Radial clearance c, m.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// Eccentricity ratio ε = |e|/c at a displacement e, m.
    #[inline]
    pub fn eccentricity_ratio(&self, displacement: Vector) -> f64 {
        displacement[0].hypot(displacement[1]) / self.clearance
    }

    /// Force, stiffness and damping at a displacement, m, a velocity, m/s, and a spin of the shaft, rad/s. The
    /// eccentricity ratio must be below one.
    #[inline]
    pub fn at(&self, displacement: Vector, velocity: Vector, spin: f64) -> BearingForce {
        let u = displacement.map(|value| value / self.clearance);
        let half = spin / 2.0;
        let w = [velocity[0] / self.clearance + half * u[1], velocity[1] / self.clearance - half * u[0]];
        let response = match &self.law {
            Law::Short => short::response(u, w),
            Law::Finite(table) => table.response(u, w),
        };
        let Response { force, displacement: du, velocity: dw } = response;
        let (force_scale, rate) = (self.scale, self.scale / self.clearance);
        // ∂w/∂u = (Ω/2) [[0, 1], [−1, 0]].
        let turned = [0, 1].map(|i| [-half * dw[i][1], half * dw[i][0]]);
        BearingForce {
            force: force.map(|value| force_scale * value),
            stiffness: [0, 1].map(|i| [0, 1].map(|j| rate * (du[i][j] + turned[i][j]))),
            damping: dw.map(|row| row.map(|value| rate * value)),
        }
    }
}

/// The unit vector along `w` and its length; the unit vector along y if `w` is zero.
#[inline]
fn direction(w: Vector) -> (Vector, f64) {
    let size = w[0].hypot(w[1]);
    if size > 0.0 { ([w[0] / size, w[1] / size], size) } else { ([1.0, 0.0], 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn journal(film: FilmKind) -> Journal {
        Journal { diameter: 0.1, length: 0.05, clearance: 1e-4, viscosity: 0.02, film }
    }

    #[test]
    fn stiffness_and_damping_are_derivatives_of_the_force() {
        let grooved = FilmKind::Finite(vec![[0.0, 0.35], [std::f64::consts::PI, 0.35]]);
        for kind in [FilmKind::Short, FilmKind::Finite(Vec::new()), grooved] {
            let film = Film::new(&journal(kind));
            for (e, v) in [([3e-5, -4e-5], [1e-3, 2e-3]), ([-7e-5, 2e-5], [0.0, 0.0]), ([1e-7, 0.0], [-3e-4, 1e-3])] {
                let found = film.at(e, v, 150.0);
                let (de, dv) = (1e-11, 1e-9);
                for j in 0..2 {
                    let moved = |sign: f64| {
                        let (mut e, mut v) = (e, v);
                        e[j] += sign * de;
                        let by_displacement = film.at(e, v, 150.0).force;
                        e[j] -= sign * de;
                        v[j] += sign * dv;
                        [by_displacement, film.at(e, v, 150.0).force]
                    };
                    let (plus, minus) = (moved(1.0), moved(-1.0));
                    for i in 0..2 {
                        let stiffness = (plus[0][i] - minus[0][i]) / (2.0 * de);
                        let damping = (plus[1][i] - minus[1][i]) / (2.0 * dv);
                        let size = found.stiffness[0][0].abs() + found.stiffness[0][1].abs();
                        // Round-off of the differences.
                        assert!((stiffness - found.stiffness[i][j]).abs() < 2e-5 * size, "{stiffness} {found:?}");
                        let size = found.damping[0][0].abs();
                        assert!((damping - found.damping[i][j]).abs() < 2e-5 * size, "{damping} {found:?}");
                    }
                }
            }
        }
    }
}
