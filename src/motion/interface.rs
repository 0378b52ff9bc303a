//! What a mesh sees of the motion and does to it, as a few scalars.
//!
//! The law of a mesh depends on six coordinates, but only through where the centres stand to each other and how far the
//! gears have rolled: three scalars. In frozen geometry the deflection alone is enough; teeth that move with the twist,
//! and gears off their centres, need either twist. What the linear motion already contains of a mesh, if anything its
//! mean stiffness and damping at rest, is taken off here, so that a load is what is left.

use nalgebra::DVector;

use super::EquationOfMotion;
use crate::integrate::Halt;
use crate::mesh::{
    Contact, ContactMode, Flank, GearMesh, Geometry, MeshCoordinates, MeshPose, Overlap, RelativeMotion, ShaftPhase,
};
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
pub struct GuaranteedInterval {
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
    gear_mesh: GearMesh,
    scalars: Scalars,
    geometry: Geometry,
    sigma: f64,
    /// Its scalars, and its generalised forces, at the displacements that deviations are measured from.
    at: [f64; MOST],
    reference_force: [f64; MOST],
    /// The force there, below zero on the back flank, N, and how fast its teeth swing, rad/s.
    static_force: f64,
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
    pub fn new(
        motion: &EquationOfMotion,
        mesh: usize,
        reference: &DVector<f64>,
        meshed: bool,
    ) -> Result<Self, Overlap> {
        let gear_mesh = motion.model.meshes[mesh].clone();
        let (geometry, sigma) = (motion.geometry, motion.sigma[mesh]);
        let follows_twist = gear_mesh.phase == Phase::Twist && !gear_mesh.teeth.is_constant();
        // The line of action of the back flank is another one, unless there is no bending.
        let frozen = geometry == Geometry::Frozen && gear_mesh.backlash.is_none();
        let flat = frozen || gear_mesh.coordinates.translation.is_none();
        let scalars = match (follows_twist || gear_mesh.has_run_out(), flat) {
            (true, _) => Scalars::Each,
            (false, true) => Scalars::Along,
            (false, false) => Scalars::Plane,
        };
        let [ra, rb] = gear_mesh.involute.base_radius;
        let [y, z] = gear_mesh.normal_at_rest(sigma);
        let gradient = match scalars {
            Scalars::Along => [1.0, 0.0, 0.0, 0.0],
            Scalars::Plane => [-y, -z, sigma, 0.0],
            Scalars::Each => [-y, -z, sigma * ra, sigma * rb],
        };
        let contained = if meshed { [gear_mesh.stiffness, gear_mesh.damping] } else { [0.0; 2] };
        let mut interface = Self {
            mesh,
            gear_mesh,
            scalars,
            geometry,
            sigma,
            at: [0.0; MOST],
            reference_force: [0.0; MOST],
            static_force: 0.0,
            swing: motion.fastest_swing(),
            mobility: motion.mobility(mesh),
            gradient,
            contained,
        };
        let rows = interface.rows();
        for (at, row) in interface.at.iter_mut().zip(rows) {
            *at = row.iter().map(|(index, coefficient)| coefficient * reference[*index]).sum();
        }
        (interface.reference_force, interface.static_force) = interface.mean_force(reference.as_slice())?;
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
        let contained = self.contained[1] > 0.0 && self.gear_mesh.backlash.is_none() && self.scalars == Scalars::Along;
        self.gear_mesh.damping > 0.0 && !contained || self.gear_mesh.has_run_out()
    }

    /// Whether its load is a straight line over its one scalar, for a given law and time.
    pub fn is_affine(&self) -> bool {
        self.scalars == Scalars::Along
            && self.gear_mesh.backlash.is_none()
            && !self.gear_mesh.teeth.is_relieved()
            && !self.has_rates()
    }

    /// Every scalar as entries (index, coefficient) over the displacements of the model; a load on it acts on the same
    /// coordinates with the same coefficients.
    pub fn rows(&self) -> Vec<Vec<(usize, f64)>> {
        let (gear_mesh, sigma) = (&self.gear_mesh, self.sigma);
        let [ra, rb] = gear_mesh.involute.base_radius;
        let MeshCoordinates { translation, twist: [a, b] } = gear_mesh.coordinates;
        let relative_displacement =
            |lane: usize| translation.map_or_else(Vec::new, |[a, b]| vec![(a + lane, -1.0), (b + lane, 1.0)]);
        match self.scalars {
            Scalars::Along => {
                let mut row = Vec::new();
                gear_mesh.gradient(sigma, gear_mesh.normal_at_rest(sigma), |index, slope| row.push((index, slope)));
                vec![row]
            }
            Scalars::Plane => vec![relative_displacement(0), relative_displacement(1), vec![(a, ra), (b, rb)]],
            Scalars::Each => vec![relative_displacement(0), relative_displacement(1), vec![(a, 1.0)], vec![(b, 1.0)]],
        }
    }

    /// What the mesh sees of these scalars, or of their rates.
    #[inline(always)]
    fn relative(&self, [a, b, c, d]: [f64; MOST]) -> RelativeMotion {
        let [ra, rb] = self.gear_mesh.involute.base_radius;
        match self.scalars {
            Scalars::Along => RelativeMotion { rolling_displacement: self.sigma * a, ..RelativeMotion::default() },
            Scalars::Plane => {
                RelativeMotion { relative_displacement: [a, b], rolling_displacement: c, ..RelativeMotion::default() }
            }
            Scalars::Each => {
                RelativeMotion { relative_displacement: [a, b], rolling_displacement: ra * c + rb * d, twist: [c, d] }
            }
        }
    }

    /// The generalised forces of a contact on the scalars.
    #[inline(always)]
    fn forces(&self, contact: &Contact) -> [f64; MOST] {
        let [y, z] = contact.push;
        match self.scalars {
            Scalars::Along => [-contact.force, 0.0, 0.0, 0.0],
            Scalars::Plane => [y, z, contact.moments[0] / self.gear_mesh.involute.base_radius[0], 0.0],
            Scalars::Each => [y, z, contact.moments[0], contact.moments[1]],
        }
    }

    /// The generalised forces of the mean stiffness at the reference, on the flank that carries there, and its force.
    fn mean_force(&self, reference: &[f64]) -> Result<([f64; MOST], f64), Overlap> {
        let pressed = |flank| self.gear_mesh.mean_tangent(self.geometry, self.sigma, flank, reference, |_, _, _| {});
        let drive = pressed(Flank::Drive)?;
        let ((force, [y, z]), sigma) = match self.gear_mesh.backlash {
            Some(_) if drive.0 < 0.0 => (pressed(Flank::Back)?, -self.sigma),
            _ => (drive, self.sigma),
        };
        let [ra, rb] = self.gear_mesh.involute.base_radius;
        let reference_force = match self.scalars {
            Scalars::Along => [-force * sigma * self.sigma, 0.0, 0.0, 0.0],
            Scalars::Plane => [force * y, force * z, -force * sigma, 0.0],
            Scalars::Each => [force * y, force * z, -force * sigma * ra, -force * sigma * rb],
        };
        Ok((reference_force, force * sigma * self.sigma))
    }

    /// The generalised forces that it holds at the reference.
    pub fn reference_force(&self) -> &[f64] {
        &self.reference_force[..self.scalars()]
    }

    /// ∂δ/∂(scalars) along the line of action at rest, and the mean stiffness along it, N/m.
    pub fn tangent(&self) -> (&[f64], f64) {
        (&self.gradient[..self.scalars()], self.gear_mesh.stiffness)
    }

    /// The load at deviations `u` of the scalars and their `rates` (empty where they do not matter), under the law that
    /// holds; returns the contact.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap.
    #[inline(always)]
    pub fn load(
        &self,
        motion: &EquationOfMotion,
        elapsed: f64,
        u: &[f64],
        rates: &[f64],
        load: &mut [f64],
    ) -> Result<Contact, Halt> {
        let turning = motion.turning(self.mesh, elapsed);
        let contact_mode = &motion.contact_modes[self.mesh];
        let contact = self.gear_mesh.contact(&self.pose(&turning, u, rates), contact_mode);
        let contact = contact.map_err(|overlap| Halt::Overlap { mesh: self.mesh, overlap })?;
        let along = |values: &[f64]| values.iter().zip(&self.gradient).map(|(value, g)| value * g).sum::<f64>();
        let linear = self.contained[0] * along(u) + self.contained[1] * along(rates);
        let forces = self.forces(&contact);
        for (k, load) in load.iter_mut().enumerate() {
            *load = (forces[k] - self.reference_force[k]) + linear * self.gradient[k];
        }
        Ok(contact)
    }

    /// Stiffness and damping along δ in a contact that the linear motion does not contain, N/m and N·s/m.
    #[inline(always)]
    pub fn residual_tangent(&self, motion: &EquationOfMotion, contact: &Contact) -> [f64; 2] {
        let flank = motion.contact_modes[self.mesh].flank;
        let flanks = f64::from(u8::from(flank.drives()) + u8::from(flank.holds_back()));
        [contact.stiffness - self.contained[0], flanks * self.gear_mesh.damping - self.contained[1]]
    }

    /// How long the flanks stay as they are in a contact under the law that holds.
    pub fn hold(&self, motion: &EquationOfMotion, contact: &Contact) -> GuaranteedInterval {
        let flank = motion.contact_modes[self.mesh].flank;
        if self.gear_mesh.backlash.is_none() || self.is_firm(flank, contact) {
            return GuaranteedInterval { time: f64::INFINITY, swing: 0.0 };
        }
        // Flanks that are apart are looked for as closely as teeth may swing once they meet.
        let swing = if contact.stiffness > 0.0 { (contact.stiffness * self.mobility).sqrt() } else { self.swing };
        let [drive, back] = self.margins(motion, contact);
        let presses = matches!(flank, Flank::Drive | Flank::Back);
        // Without rates there is no telling what swings.
        if !self.has_rates() || !presses || drive <= 0.0 || back <= 0.0 {
            return GuaranteedInterval { time: 0.0, swing };
        }
        // What is left of x after t is at least x − |ẋ|t − aω²t²/2, a the amplitude.
        let rate = contact.rate.abs();
        let amplitude = ((contact.force - self.static_force) / contact.stiffness).hypot(rate / swing);
        let time = |left: f64| 2.0 * left / (rate + (rate * rate + 2.0 * amplitude * swing * swing * left).sqrt());
        GuaranteedInterval { time: time(drive).min(time(back)), swing }
    }

    /// How far the drive flank and the back flank are from a change of law, as the one that holds shows them in a
    /// contact, m: pressed in by so much, or clear by so much.
    pub fn margins(&self, motion: &EquationOfMotion, contact: &Contact) -> [f64; 2] {
        // What damping holds together has not parted yet.
        let pressed = |force: f64, deflection: f64| {
            if contact.stiffness > 0.0 { force / contact.stiffness } else { deflection }
        };
        let Contact { force, deflection, back_flank_deflection, .. } = *contact;
        match motion.contact_modes[self.mesh].flank {
            Flank::Drive => [pressed(force, deflection), -back_flank_deflection],
            Flank::Back => [-deflection, pressed(-force, back_flank_deflection)],
            Flank::Apart => [-deflection, -back_flank_deflection],
            Flank::Both => [deflection, back_flank_deflection],
        }
    }

    /// Whether the flank that presses in a contact stays pressed and the other one clear, whatever swings as the contact
    /// shows: about the force at rest by no more than half of it, as force and rate tell of what swings on the teeth or
    /// faster, and half of the backlash is left.
    fn is_firm(&self, flank: Flank, contact: &Contact) -> bool {
        let (static_force, clear) = match flank {
            Flank::Drive => (self.static_force, contact.back_flank_deflection),
            Flank::Back => (-self.static_force, contact.deflection),
            Flank::Apart | Flank::Both => return false,
        };
        // In parts of the force at rest, so that no square overflows.
        let part = |force: f64| force / static_force;
        let swung = part(contact.force - self.static_force).powi(2)
            + part(contact.stiffness * contact.rate / self.swing).powi(2);
        self.has_rates()
            && static_force > 0.0
            && swung <= 0.25
            && clear <= -self.gear_mesh.backlash.unwrap_or(f64::INFINITY) / 2.0
    }

    /// The law that holds at deviations `u` and their `rates`; flanks that are `unchanged` stay as they are.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap.
    pub fn contact_mode(
        &self,
        motion: &EquationOfMotion,
        elapsed: f64,
        u: &[f64],
        rates: &[f64],
        unchanged: bool,
    ) -> Result<ContactMode, Halt> {
        if !self.gear_mesh.switches() {
            return Ok(ContactMode::ALWAYS);
        }
        if unchanged && !self.gear_mesh.teeth.is_sharp() {
            return Ok(motion.contact_modes[self.mesh]);
        }
        let contact_mode = self.gear_mesh.contact_mode(&self.pose(&motion.turning(self.mesh, elapsed), u, rates));
        contact_mode.map_err(|overlap| Halt::Overlap { mesh: self.mesh, overlap })
    }

    /// Where the ends of the path of contact stand among the pairs of teeth that come and go at once, each with the pair
    /// that is the first or the last between them under the law that holds, flank by flank, into `ends`.
    ///
    /// # Errors
    /// [`Halt`] where base circles overlap.
    pub fn ends(
        &self,
        motion: &EquationOfMotion,
        elapsed: f64,
        u: &[f64],
        ends: &mut Vec<(f64, i64)>,
    ) -> Result<(), Halt> {
        if !self.gear_mesh.teeth.is_sharp() {
            return Ok(());
        }
        let turning = motion.turning(self.mesh, elapsed);
        for back in [false, true] {
            if !back || self.gear_mesh.backlash.is_some() {
                let path = self.gear_mesh.engagement(&self.pose(&turning, u, &[]), back);
                let [low, high] = path.map_err(|overlap| Halt::Overlap { mesh: self.mesh, overlap })?.ends();
                let (first, last) = motion.contact_modes[self.mesh].engaged[usize::from(back)];
                ends.extend([(low, first), (high, last)]);
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn pose<'a>(&self, turning: &'a [ShaftPhase; 2], u: &[f64], rates: &[f64]) -> MeshPose<'a> {
        let (mut scalars, mut speeds) = (self.at, [0.0; MOST]);
        for (scalar, u) in scalars.iter_mut().zip(u) {
            *scalar += u;
        }
        for (speed, rate) in speeds.iter_mut().zip(rates) {
            *speed = *rate;
        }
        let (position, velocity) = (self.relative(scalars), self.relative(speeds));
        MeshPose { geometry: self.geometry, sigma: self.sigma, turning, position, velocity }
    }
}
