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
//! A bearing is a sum over pads. A pad has its own clearance c and centre, so that its u is the displacement relative to that
//! centre; a plain bearing is one pad of 360°.
//!
//! `short.rs` has f for a short film in closed form. `reynolds.rs` solves Reynolds' equation for a pad of finite length,
//! `table.rs` interpolates its solutions, `store.rs` keeps them in files, `equilibrium.rs` finds the displacement
//! under a load, and `tilting.rs` eliminates the tilt of pads.
//!
//! A squeeze film is the film of a ring that does not turn. Without rupture its force is f(u, w) − f(u, −w), which is linear in w.

mod equilibrium;
mod reynolds;
mod short;
mod store;
mod table;
mod tilting;

use std::f64::consts::TAU;
use std::sync::Arc;

pub use equilibrium::{MAX_ECCENTRICITY_RATIO, TOUCHING_RATIO, nearness_after_step};
pub use reynolds::Reynolds;
pub use table::{FilmTable, PadShape};
pub use tilting::TiltingPads;

use crate::bearing_force::{BearingForce, Matrix, Vector};
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::{FilmKind, Journal, Pad, Squeeze};

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

/// The law of a pad.
#[derive(Clone, Debug)]
enum Law {
    /// Short film of 360°, closed form.
    Short,
    /// Pad of finite length, interpolated.
    Finite(Arc<FilmTable>),
}

/// The film of one pad.
#[derive(Clone, Debug)]
struct FilmPad {
    law: Law,
    /// Angle of the middle of the arc from y towards z, rad.
    middle: f64,
    /// Displacement of the centred journal from the centre of the pad, in clearances.
    offset: Vector,
    /// Radial clearance c of the pad, m.
    clearance: f64,
    /// κ = μ R L³/c², N s.
    scale: f64,
}

impl FilmPad {
    fn new(journal: &Journal, pad: &Pad, direction: f64) -> Self {
        let law = match journal.film {
            FilmKind::Short => Law::Short,
            FilmKind::Finite(rupture) => {
                let length_ratio = pad.length / journal.diameter;
                Law::Finite(FilmTable::known(PadShape { length_ratio, extent: pad.extent, rupture }))
            }
        };
        let (clearance, middle) = (pad.clearance, pad.begin + pad.extent / 2.0);
        let (sin, cos) = pad.closest(direction).sin_cos();
        let scale = journal.viscosity * journal.diameter / 2.0 * pad.length.powi(3) / (clearance * clearance);
        Self { law, middle, offset: [pad.preload * cos, pad.preload * sin], clearance, scale }
    }

    /// Displacement of the journal from the centre of the pad, in clearances.
    #[inline]
    fn displacement(&self, displacement: Vector) -> Vector {
        [0, 1].map(|i| displacement[i] / self.clearance + self.offset[i])
    }

    /// Part of the clearance that the journal has used: 1 where it touches the pad.
    #[inline]
    fn nearness(&self, displacement: Vector) -> f64 {
        let u = self.displacement(displacement);
        let ratio = u[0].hypot(u[1]);
        match &self.law {
            Law::Finite(table) if !table.shape().is_full() => {
                ratio * table.shape().reach(u[1].atan2(u[0]) - self.middle)[0][0]
            }
            _ => ratio,
        }
    }

    /// The film at rest for a journal at a displacement, m, at a spin, rad/s, with radius and length, m.
    fn along_middle(&self, displacement: Vector, spin: f64, [radius, length]: [f64; 2], pivot: Option<f64>) -> PadFilm {
        let u = self.displacement(displacement);
        let (along, rate) = direction([u[1] * spin / 2.0, -u[0] * spin / 2.0]);
        let gap = |angle: f64| 1.0 - u[0] * angle.cos() - u[1] * angle.sin();
        let beta = along[1].atan2(along[0]);
        let [angles, pressure] = match &self.law {
            Law::Short => {
                let angles: Vec<f64> =
                    (0..SHORT_FILM_ANGLES).map(|i| TAU * i as f64 / (SHORT_FILM_ANGLES - 1) as f64).collect();
                let square = (length / (2.0 * radius)).powi(2);
                let at = |angle: &f64| (angle - beta).cos().max(0.0) * square / (2.0 * gap(*angle).powi(3));
                let pressure = angles.iter().map(at).collect();
                [angles, pressure]
            }
            Law::Finite(table) => {
                let mut solver = Reynolds::new(table.shape());
                let (sin, cos) = self.middle.sin_cos();
                // A pad that carries nothing may lie beyond the journal.
                let place = if self.nearness(displacement) < 1.0 { u } else { [0.0; 2] };
                solver.force([cos * place[0] + sin * place[1], cos * place[1] - sin * place[0]], beta - self.middle);
                let [angles, pressure] = solver.middle_line();
                [angles.iter().map(|angle| angle + self.middle).collect(), pressure]
            }
        };
        let scale = 12.0 * self.scale * radius / length.powi(3) * rate;
        PadFilm {
            thickness: angles.iter().map(|angle| self.clearance * gap(*angle)).collect(),
            pressure: pressure.iter().map(|value| scale * value).collect(),
            angles,
            pivot,
        }
    }

    /// Whether its film is closest before its middle in the direction of a spin, so that most of it widens along the rotation.
    fn widens(&self, spin: f64) -> bool {
        let (sin, cos) = self.middle.sin_cos();
        let ahead = cos * self.offset[1] - sin * self.offset[0];
        ahead * spin.signum() < -EQUALITY_TOLERANCE
    }

    /// Adds its force, stiffness and damping.
    #[inline]
    fn add(&self, displacement: Vector, velocity: Vector, half_spin: f64, sum: &mut BearingForce) {
        let u = self.displacement(displacement);
        let w = [velocity[0] / self.clearance + half_spin * u[1], velocity[1] / self.clearance - half_spin * u[0]];
        self.add_response(self.response(u, w), half_spin, self.scale, sum);
    }

    #[inline]
    fn response(&self, u: Vector, w: Vector) -> Response {
        match &self.law {
            Law::Short => short::response(u, w),
            Law::Finite(table) => table.response(u, w, self.middle),
        }
    }

    /// Adds a part, with the scale κ, N s, of a force of a film without rotation that is linear in the velocity: that of the film
    /// without rupture.
    fn add_linear(&self, displacement: Vector, velocity: Vector, scale: f64, sum: &mut BearingForce) {
        let u = self.displacement(displacement);
        // The two parts have opposite directions at rest, too.
        let (along, size) = direction(velocity.map(|value| value / self.clearance));
        for sign in [1.0, -1.0] {
            let part = self.response(u, along.map(|value| sign * value));
            let part = Response {
                force: part.force.map(|value| sign * size * value),
                displacement: part.displacement.map(|row| row.map(|value| sign * size * value)),
                velocity: part.velocity,
            };
            self.add_response(part, 0.0, scale, sum);
        }
    }

    #[inline]
    fn add_response(&self, response: Response, half_spin: f64, scale: f64, sum: &mut BearingForce) {
        let Response { force, displacement: du, velocity: dw } = response;
        let (force_scale, rate) = (scale, scale / self.clearance);
        for i in 0..2 {
            sum.force[i] += force_scale * force[i];
            // ∂w/∂u = (Ω/2) [[0, 1], [−1, 0]].
            sum.stiffness[i][0] += rate * (du[i][0] - half_spin * dw[i][1]);
            sum.stiffness[i][1] += rate * (du[i][1] + half_spin * dw[i][0]);
            sum.damping[i][0] += rate * dw[i][0];
            sum.damping[i][1] += rate * dw[i][1];
        }
    }
}

/// The film of a pad at rest, along the middle of its length.
#[derive(Clone, Debug)]
pub struct PadFilm {
    /// Angles from y towards z, rad.
    pub angles: Vec<f64>,
    /// Thickness of the film there, m.
    pub thickness: Vec<f64>,
    /// Pressure there, Pa.
    pub pressure: Vec<f64>,
    /// Angle of the pivot of a tilting pad, rad.
    pub pivot: Option<f64>,
}

/// Number of angles at which a short film is given.
const SHORT_FILM_ANGLES: usize = 181;

/// The films of the pads of a checked bearing at rest at a displacement of the journal, m, at a spin, rad/s.
pub fn pad_films(journal: &Journal, displacement: Vector, spin: f64) -> Vec<PadFilm> {
    let at = |(number, given): (usize, &Pad)| {
        let (pad, place, pivot) = match &journal.tilting {
            Some(_) => {
                let pad = journal.tilting_pad(given, spin);
                let film = FilmPad::new(journal, &pad, spin);
                let place = TiltingPads::new(journal, spin).map(|pads| pads.relative(number, displacement, spin));
                (film, place.unwrap_or(displacement), Some(pad.closest(spin)))
            }
            None => (FilmPad::new(journal, given, spin), displacement, None),
        };
        pad.along_middle(place, spin, [journal.diameter / 2.0, given.length], pivot)
    };
    journal.pads.iter().enumerate().map(at).collect()
}

/// The oil film of a journal bearing.
#[derive(Clone, Debug)]
pub struct Film {
    pads: Vec<FilmPad>,
    /// Radial clearance c of the bearing as given, m.
    clearance: f64,
    /// Whether it is the film of a journal, or a squeeze film with or without rupture.
    kind: Kind,
}

/// What moves in a film.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// A journal that turns.
    Journal,
    /// A journal that turns in the film of one tilting pad with its pivot in a direction.
    TiltingPad(Vector),
    /// A ring that does not turn, in a film that ruptures.
    RupturedSqueeze,
    /// A ring that does not turn, in a film that does not rupture.
    Squeeze,
}

impl Film {
    /// The film of a checked journal bearing whose shaft turns in a direction, 1 or −1, at a positive speed of the reference
    /// shaft. The table of a pad of finite length is made at its first use.
    pub fn new(journal: &Journal, direction: f64) -> Self {
        let pads = journal.pads.iter().map(|pad| FilmPad::new(journal, pad, direction)).collect();
        Self { pads, clearance: journal.clearance, kind: Kind::Journal }
    }

    /// The film of one tilting pad, over the displacement of the journal relative to the pad.
    pub fn of_pad(journal: &Journal, pad: &Pad, direction: f64) -> Self {
        let pads = vec![FilmPad::new(journal, pad, direction)];
        let (sin, cos) = pad.closest(direction).sin_cos();
        Self { pads, clearance: journal.clearance, kind: Kind::TiltingPad([cos, sin]) }
    }

    /// A squeeze film.
    pub fn of_squeeze(squeeze: &Squeeze) -> Self {
        let kind = if squeeze.is_ruptured { Kind::RupturedSqueeze } else { Kind::Squeeze };
        Self { kind, ..Self::new(&squeeze.journal, 1.0) }
    }

    /// Whether it is a squeeze film, which carries no static load.
    pub fn is_squeeze(&self) -> bool {
        matches!(self.kind, Kind::Squeeze | Kind::RupturedSqueeze)
    }

    /// Direction of the pivot of a tilting pad; none for another film.
    pub fn pivot(&self) -> Option<Vector> {
        match self.kind {
            Kind::TiltingPad(pivot) => Some(pivot),
            Kind::Journal | Kind::Squeeze | Kind::RupturedSqueeze => None,
        }
    }

    /// Radial clearance c, m.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// Whether its pads are made for the other direction of rotation than that of a spin.
    pub fn widens(&self, spin: f64) -> bool {
        self.pads.iter().any(|pad| pad.widens(spin))
    }

    /// Part of the clearance that a journal at a displacement, m, has used at the nearest pad: 1 where it touches; the
    /// eccentricity ratio |e|/c of a plain film.
    #[inline]
    pub fn nearness(&self, displacement: Vector) -> f64 {
        let larger = |most: f64, value: f64| if value > most || value.is_nan() { value } else { most };
        self.pads.iter().map(|pad| pad.nearness(displacement)).fold(0.0, larger)
    }

    /// Force, stiffness and damping at a displacement, m, a velocity, m/s, and a spin of the shaft, rad/s. The nearness must
    /// be below one.
    #[inline]
    pub fn at(&self, displacement: Vector, velocity: Vector, spin: f64) -> BearingForce {
        let mut sum = BearingForce::default();
        match self.kind {
            Kind::Journal | Kind::TiltingPad(_) => {
                self.pads.iter().for_each(|pad| pad.add(displacement, velocity, spin / 2.0, &mut sum))
            }
            Kind::RupturedSqueeze => self.pads.iter().for_each(|pad| pad.add(displacement, velocity, 0.0, &mut sum)),
            Kind::Squeeze => {
                self.pads.iter().for_each(|pad| pad.add_linear(displacement, velocity, pad.scale, &mut sum));
            }
        }
        sum
    }

    /// Force and linear coefficients at rest. A squeeze film that ruptures has half the damping of one that does not: a small
    /// vibration squeezes one side and then the other.
    pub fn at_rest(&self, displacement: Vector, spin: f64) -> BearingForce {
        if self.kind != Kind::RupturedSqueeze {
            return self.at(displacement, [0.0; 2], spin);
        }
        let mut sum = BearingForce::default();
        self.pads.iter().for_each(|pad| pad.add_linear(displacement, [0.0; 2], pad.scale / 2.0, &mut sum));
        sum
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

    use crate::scene::Rupture;

    fn journal(film: FilmKind, pads: &[[f64; 3]]) -> Journal {
        let (length, clearance) = (0.05, 1e-4);
        let pad = |[begin, extent, preload]: &[f64; 3]| Pad {
            begin: *begin,
            extent: *extent,
            length,
            clearance,
            preload: *preload,
            offset: 0.5,
        };
        Journal { diameter: 0.1, clearance, viscosity: 0.02, film, pads: pads.iter().map(pad).collect(), tilting: None }
    }

    #[test]
    fn stiffness_and_damping_are_derivatives_of_the_force() {
        let (full, finite) = ([[0.0, TAU, 0.0]], FilmKind::Finite(Rupture::Reynolds));
        let lobes = [0.2, 2.3, 4.4].map(|begin| [begin, 1.7, 0.2]);
        for (kind, pads) in [(FilmKind::Short, &full[..]), (finite, &full), (finite, &lobes)] {
            let film = Film::new(&journal(kind, pads), 1.0);
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
                        assert!((stiffness - found.stiffness[i][j]).abs() < 5e-5 * size, "{stiffness} {found:?}");
                        let size = found.damping[0][0].abs();
                        assert!((damping - found.damping[i][j]).abs() < 2e-5 * size, "{damping} {found:?}");
                    }
                }
            }
        }
    }
}
