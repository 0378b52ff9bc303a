//! What a mesh sees of the motion and does to it, as a few scalars.
//!
//! The law of a mesh depends on six coordinates, but only through where the centres stand to each other and how far the
//! gears have rolled: three scalars. In frozen geometry the deflection alone is enough; teeth that move with the twist,
//! and gears off their centres, need either twist. What the linear motion already contains of a mesh, if anything its
//! mean stiffness and damping at rest, is taken off here, so that a load is what is left.

use nalgebra::DVector;

use super::Motion;
use crate::integrate::Halt;
use crate::mesh::{Contact, Coordinates, Coupling, Flank, Geometry, Law, Overlap, Pose, Relative, Turning};
use crate::scene::Phase;

/// Through which scalars a mesh sees the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scalars {
    /// δ along the line of action at rest.
    Along,
    /// u_b − u_a over (y, z), and r_a θ_a + r_b θ_b.
    Plane,
    /// u_b − u_a over (y, z), θ_a and θ_b.
    Each,
}

/// How long the flanks of a mesh stay as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// So long at least, s, whatever swings as the contact shows.
    pub time: f64,
    /// How fast the teeth swing, or may swing, if that is not for ever, the gears being all that moves, rad/s.
    pub swing: f64,
}

/// The most scalars that a mesh has.
const MOST: usize = 4;

/// The interface of one mesh with everything linear.
#[derive(Clone, Debug)]
pub struct Interface {
    /// Index of the mesh.
    pub mesh: usize,
    coupling: Coupling,
    scalars: Scalars,
    geometry: Geometry,
    sigma: f64,
    /// Its scalars, and its generalised forces, at the displacements that deviations are measured from.
    at: [f64; MOST],
    held: [f64; MOST],
    /// The force there, below zero on the back flank, N, and how fast its teeth swing, rad/s.
    carried: f64,
    swing: f64,
    /// Of its gears, along the line of action, 1/kg.
    mobility: f64,
    /// ∂δ/∂(scalars) along the line of action at rest.
    gradient: [f64; MOST],
    /// Stiffness, N/m, and damping, N·s/m, along it that the linear motion contains.
    contained: [f64; 2],
}

impl Interface {
    /// The interface of mesh `mesh` of a motion; deviations are measured from `reference`. The linear motion beside it
    /// is that of a `meshed` train, or of its shafts alone.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles at the reference.
    pub fn new(motion: &Motion, mesh: usize, reference: &DVector<f64>, meshed: bool) -> Result<Self, Overlap> {
        let coupling = motion.model.meshes[mesh].clone();
        let (geometry, sigma) = (motion.geometry, motion.sigma[mesh]);
        let follows_twist = coupling.phase == Phase::Twist && !coupling.teeth.is_constant();
        // The line of action of the back flank is another one, unless there is no bending.
        let frozen = geometry == Geometry::Frozen && coupling.backlash.is_none();
        let flat = frozen || coupling.coordinates.translation.is_none();
        let scalars = match (follows_twist || coupling.has_run_out(), flat) {
            (true, _) => Scalars::Each,
            (false, true) => Scalars::Along,
            (false, false) => Scalars::Plane,
        };
        let [ra, rb] = coupling.involute.base_radius;
        let [y, z] = coupling.normal_at_rest(sigma);
        let gradient = match scalars {
            Scalars::Along => [1.0, 0.0, 0.0, 0.0],
            Scalars::Plane => [-y, -z, sigma, 0.0],
            Scalars::Each => [-y, -z, sigma * ra, sigma * rb],
        };
        let contained = if meshed { [coupling.stiffness, coupling.damping] } else { [0.0; 2] };
        let mut interface = Self {
            mesh,
            coupling,
            scalars,
            geometry,
            sigma,
            at: [0.0; MOST],
            held: [0.0; MOST],
            carried: 0.0,
            swing: motion.fastest_swing(),
            mobility: motion.mobility(mesh),
            gradient,
            contained,
        };
        let rows = interface.rows();
        for (at, row) in interface.at.iter_mut().zip(rows) {
            *at = row.iter().map(|(index, coefficient)| coefficient * reference[*index]).sum();
        }
        (interface.held, interface.carried) = interface.mean_force(reference.as_slice())?;
        Ok(interface)
    }

    /// Number of scalars.
    pub fn scalars(&self) -> usize {
        match self.scalars {
            Scalars::Along => 1,
            Scalars::Plane => 3,
            Scalars::Each => 4,
        }
    }

    /// Whether its load depends on the rates of the scalars as well.
    pub fn has_rates(&self) -> bool {
        let contained = self.contained[1] > 0.0 && self.coupling.backlash.is_none() && self.scalars == Scalars::Along;
        self.coupling.damping > 0.0 && !contained || self.coupling.has_run_out()
    }

    /// Whether its load is a straight line over its one scalar, for a given law and time.
    pub fn is_affine(&self) -> bool {
        self.scalars == Scalars::Along
            && self.coupling.backlash.is_none()
            && !self.coupling.teeth.is_relieved()
            && !self.has_rates()
    }

    /// Every scalar as entries (index, coefficient) over the displacements of the model; a load on it acts on the same
    /// coordinates with the same coefficients.
    pub fn rows(&self) -> Vec<Vec<(usize, f64)>> {
        let (coupling, sigma) = (&self.coupling, self.sigma);
        let [ra, rb] = coupling.involute.base_radius;
        let Coordinates { translation, twist: [a, b] } = coupling.coordinates;
        let apart = |lane: usize| translation.map_or_else(Vec::new, |[a, b]| vec![(a + lane, -1.0), (b + lane, 1.0)]);
        match self.scalars {
            Scalars::Along => {
                let mut row = Vec::new();
                coupling.gradient(sigma, coupling.normal_at_rest(sigma), |index, slope| row.push((index, slope)));
                vec![row]
            }
            Scalars::Plane => vec![apart(0), apart(1), vec![(a, ra), (b, rb)]],
            Scalars::Each => vec![apart(0), apart(1), vec![(a, 1.0)], vec![(b, 1.0)]],
        }
    }

    /// What the mesh sees of these scalars, or of their rates.
    #[inline(always)]
    fn relative(&self, [a, b, c, d]: [f64; MOST]) -> Relative {
        let [ra, rb] = self.coupling.involute.base_radius;
        match self.scalars {
            Scalars::Along => Relative { rolled: self.sigma * a, ..Relative::default() },
            Scalars::Plane => Relative { apart: [a, b], rolled: c, ..Relative::default() },
            Scalars::Each => Relative { apart: [a, b], rolled: ra * c + rb * d, twist: [c, d] },
        }
    }

    /// The generalised forces of a contact on the scalars.
    #[inline(always)]
    fn forces(&self, contact: &Contact) -> [f64; MOST] {
        let [y, z] = contact.push;
        match self.scalars {
            Scalars::Along => [-contact.force, 0.0, 0.0, 0.0],
            Scalars::Plane => [y, z, contact.moments[0] / self.coupling.involute.base_radius[0], 0.0],
            Scalars::Each => [y, z, contact.moments[0], contact.moments[1]],
        }
    }

    /// The generalised forces of the mean stiffness at the reference, on the flank that carries there, and its force.
    fn mean_force(&self, reference: &[f64]) -> Result<([f64; MOST], f64), Overlap> {
        let pressed = |flank| self.coupling.mean_tangent(self.geometry, self.sigma, flank, reference, |_, _, _| {});
        let drive = pressed(Flank::Drive)?;
        let ((force, [y, z]), sigma) = match self.coupling.backlash {
            Some(_) if drive.0 < 0.0 => (pressed(Flank::Back)?, -self.sigma),
            _ => (drive, self.sigma),
        };
        let [ra, rb] = self.coupling.involute.base_radius;
        let held = match self.scalars {
            Scalars::Along => [-force * sigma * self.sigma, 0.0, 0.0, 0.0],
            Scalars::Plane => [force * y, force * z, -force * sigma, 0.0],
            Scalars::Each => [force * y, force * z, -force * sigma * ra, -force * sigma * rb],
        };
        Ok((held, force * sigma * self.sigma))
    }

    /// The generalised forces that it holds at the reference.
    pub fn held(&self) -> &[f64] {
        &self.held[..self.scalars()]
    }

    /// ∂δ/∂(scalars) along the line of action at rest, and the mean stiffness along it, N/m.
    pub fn tangent(&self) -> (&[f64], f64) {
        (&self.gradient[..self.scalars()], self.coupling.stiffness)
    }

    /// The load at deviations `u` of the scalars and their `rates` (empty where they do not matter), under the law that
    /// holds; returns the contact.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap.
    #[inline(always)]
    pub fn load(
        &self,
        motion: &Motion,
        elapsed: f64,
        u: &[f64],
        rates: &[f64],
        load: &mut [f64],
    ) -> Result<Contact, Halt> {
        let turning = motion.turning(self.mesh, elapsed);
        let law = &motion.laws[self.mesh];
        let contact = self.coupling.contact(&self.pose(&turning, u, rates), law);
        let contact = contact.map_err(|overlap| Halt::Overlap { mesh: self.mesh, overlap })?;
        let along = |values: &[f64]| values.iter().zip(&self.gradient).map(|(value, g)| value * g).sum::<f64>();
        let linear = self.contained[0] * along(u) + self.contained[1] * along(rates);
        let forces = self.forces(&contact);
        for (k, load) in load.iter_mut().enumerate() {
            *load = (forces[k] - self.held[k]) + linear * self.gradient[k];
        }
        Ok(contact)
    }

    /// Stiffness and damping along δ in a contact that the linear motion does not contain, N/m and N·s/m.
    #[inline(always)]
    pub fn rigidity(&self, motion: &Motion, contact: &Contact) -> [f64; 2] {
        let flank = motion.laws[self.mesh].flank;
        let flanks = f64::from(u8::from(flank.drives()) + u8::from(flank.holds_back()));
        [contact.stiffness - self.contained[0], flanks * self.coupling.damping - self.contained[1]]
    }

    /// How long the flanks stay as they are in a contact under the law that holds.
    pub fn hold(&self, motion: &Motion, contact: &Contact) -> Hold {
        let flank = motion.laws[self.mesh].flank;
        if self.coupling.backlash.is_none() || self.is_firm(flank, contact) {
            return Hold { time: f64::INFINITY, swing: 0.0 };
        }
        // Flanks that are apart are looked for as closely as teeth may swing once they meet.
        let swing = if contact.stiffness > 0.0 { (contact.stiffness * self.mobility).sqrt() } else { self.swing };
        let [drive, back] = self.margins(motion, contact);
        let presses = matches!(flank, Flank::Drive | Flank::Back);
        // Without rates there is no telling what swings.
        if !self.has_rates() || !presses || drive <= 0.0 || back <= 0.0 {
            return Hold { time: 0.0, swing };
        }
        // What is left of x after t is at least x − |ẋ|t − aω²t²/2, a the amplitude.
        let rate = contact.rate.abs();
        let amplitude = ((contact.force - self.carried) / contact.stiffness).hypot(rate / swing);
        let time = |left: f64| 2.0 * left / (rate + (rate * rate + 2.0 * amplitude * swing * swing * left).sqrt());
        Hold { time: time(drive).min(time(back)), swing }
    }

    /// How far the drive flank and the back flank are from a change of law, as the one that holds shows them in a
    /// contact, m: pressed in by so much, or clear by so much.
    pub fn margins(&self, motion: &Motion, contact: &Contact) -> [f64; 2] {
        // What damping holds together has not parted yet.
        let pressed = |force: f64, deflection: f64| {
            if contact.stiffness > 0.0 { force / contact.stiffness } else { deflection }
        };
        let Contact { force, deflection, behind, .. } = *contact;
        match motion.laws[self.mesh].flank {
            Flank::Drive => [pressed(force, deflection), -behind],
            Flank::Back => [-deflection, pressed(-force, behind)],
            Flank::Apart => [-deflection, -behind],
            Flank::Both => [deflection, behind],
        }
    }

    /// Whether the flank that presses in a contact stays pressed and the other one clear, whatever swings as the contact
    /// shows: about the force at rest by no more than half of it, as force and rate tell of what swings on the teeth or
    /// faster, and half of the backlash is left.
    fn is_firm(&self, flank: Flank, contact: &Contact) -> bool {
        let (carried, clear) = match flank {
            Flank::Drive => (self.carried, contact.behind),
            Flank::Back => (-self.carried, contact.deflection),
            Flank::Apart | Flank::Both => return false,
        };
        // In parts of the force at rest, so that no square overflows.
        let part = |force: f64| force / carried;
        let swung =
            part(contact.force - self.carried).powi(2) + part(contact.stiffness * contact.rate / self.swing).powi(2);
        self.has_rates()
            && carried > 0.0
            && swung <= 0.25
            && clear <= -self.coupling.backlash.unwrap_or(f64::INFINITY) / 2.0
    }

    /// The law that holds at deviations `u` and their `rates`; flanks that are `settled` stay as they are.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap.
    pub fn law(&self, motion: &Motion, elapsed: f64, u: &[f64], rates: &[f64], settled: bool) -> Result<Law, Halt> {
        if !self.coupling.switches() {
            return Ok(Law::ALWAYS);
        }
        if settled && !self.coupling.teeth.is_sharp() {
            return Ok(motion.laws[self.mesh]);
        }
        let law = self.coupling.law(&self.pose(&motion.turning(self.mesh, elapsed), u, rates));
        law.map_err(|overlap| Halt::Overlap { mesh: self.mesh, overlap })
    }

    /// Where the ends of the path of contact stand among the pairs of teeth that come and go at once, each with the pair
    /// that is the first or the last between them under the law that holds, flank by flank, into `ends`.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap.
    pub fn ends(&self, motion: &Motion, elapsed: f64, u: &[f64], ends: &mut Vec<(f64, i64)>) -> Result<(), Halt> {
        if !self.coupling.teeth.is_sharp() {
            return Ok(());
        }
        let turning = motion.turning(self.mesh, elapsed);
        for back in [false, true] {
            if !back || self.coupling.backlash.is_some() {
                let path = self.coupling.engagement(&self.pose(&turning, u, &[]), back);
                let [low, high] = path.map_err(|overlap| Halt::Overlap { mesh: self.mesh, overlap })?.ends();
                let (first, last) = motion.laws[self.mesh].engaged[usize::from(back)];
                ends.extend([(low, first), (high, last)]);
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn pose<'a>(&self, turning: &'a [Turning; 2], u: &[f64], rates: &[f64]) -> Pose<'a> {
        let (mut scalars, mut speeds) = (self.at, [0.0; MOST]);
        for (scalar, u) in scalars.iter_mut().zip(u) {
            *scalar += u;
        }
        for (speed, rate) in speeds.iter_mut().zip(rates) {
            *speed = *rate;
        }
        let (position, velocity) = (self.relative(scalars), self.relative(speeds));
        Pose { geometry: self.geometry, sigma: self.sigma, turning, position, velocity }
    }
}
