//! A mesh in a run: a few scalars of the motion, and the loads on these scalars.
//!
//! The force of a mesh depends on six coordinates, but only through the relative displacement of the gear centres and the
//! rolling displacement of the gears: three scalars. In frozen geometry the deflection alone is enough. Both twists are
//! needed if the tooth engagement depends on the twist, if a gear has run-out, or if the mesh has friction. Helical teeth add the
//! tilts and, with both twists, the axial displacement. The linear motion may contain the
//! mean stiffness and the damping of the mesh at rest; the load is the remainder.

use super::instant::{GuaranteedInterval, Instant, InterfaceOptions, Tangent};
use super::{Direction, Row};
use crate::mesh::{
    Contact, ContactMode, Directions, Flank, GearMesh, Geometry, MeshCoordinates, MeshPose, Overlap, RelativeMotion,
    ShaftPhase,
};
use crate::scene::Phase;

/// The scalars of the motion on which the mesh force depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scalars {
    /// Deflection δ along the line of action at rest, m.
    Deflection,
    /// u_b − u_a over (y, z), and r_a θ_a + r_b θ_b.
    Plane,
    /// u_b − u_a over (y, z), θ_a and θ_b.
    PlaneAndTwists,
    /// u_b − u_a over (y, z), the rolling displacement with its axial part, and the tilt τ of helical gears over (y, z).
    Space,
    /// u_b − u_a over (y, z), θ_a, θ_b, τ over (y, z), and the axial part of the rolling displacement of helical gears.
    SpaceAndTwists,
}

/// The largest number of scalars of a mesh, with the rotation that resists friction.
const MAX_SCALARS: usize = 8;

/// A mesh in a run.
#[derive(Clone, Debug)]
pub struct MeshInterface {
    /// Index of the mesh.
    pub mesh: usize,
    gear_mesh: GearMesh,
    scalars: Scalars,
    geometry: Geometry,
    /// σ, the sign of the spin of the driver.
    sigma: f64,
    /// Scalars at the reference.
    reference: [f64; MAX_SCALARS],
    /// Generalised forces on the scalars at the reference.
    reference_force: [f64; MAX_SCALARS],
    /// Mesh force at the reference, N, negative on the back flank.
    static_force: f64,
    /// Highest angular frequency of the gear oscillation on the mesh stiffness, rad/s.
    highest_frequency: f64,
    /// Acceleration of the teeth along the line of action per unit of mesh force, 1/kg.
    mobility: f64,
    /// ∂δ/∂(scalars) along the line of action at rest.
    gradient: [f64; MAX_SCALARS],
    /// Stiffness, N/m, and damping, N s/m, along the gradient that the linear motion contains.
    contained: [f64; 2],
}

impl MeshInterface {
    /// The interface of the mesh with index `mesh`; `sigma` is the sign of the spin of its driver.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles at the reference.
    pub(super) fn new(
        mesh: usize,
        gear_mesh: &GearMesh,
        sigma: f64,
        options: InterfaceOptions<'_>,
    ) -> Result<Self, Overlap> {
        let InterfaceOptions { geometry, reference, contained, highest_frequency, mobility, .. } = options;
        let follows_twist = gear_mesh.phase == Phase::Twist && !gear_mesh.teeth.is_constant();
        let needs_twists = follows_twist || gear_mesh.has_runout() || gear_mesh.friction.is_some();
        // The back flank has another line of action, unless there is no bending.
        let frozen = geometry == Geometry::Frozen && gear_mesh.backlash.is_none();
        let flat = frozen || gear_mesh.coordinates.translation.is_none();
        let scalars = match (needs_twists, flat, gear_mesh.helix.is_some()) {
            (true, _, false) => Scalars::PlaneAndTwists,
            (true, _, true) => Scalars::SpaceAndTwists,
            (false, true, _) => Scalars::Deflection,
            (false, false, false) => Scalars::Plane,
            (false, false, true) => Scalars::Space,
        };
        let [ra, rb] = gear_mesh.involute.base_radius;
        let Directions { normal: [y, z], centres } = gear_mesh.directions_at_rest(sigma);
        let slope = gear_mesh.helix.as_ref().map_or(0.0, |helix| helix.slope);
        let [j, k] = centres.map(|centre| sigma * slope * centre);
        let gradient = match scalars {
            Scalars::Deflection => [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            Scalars::Plane => [-y, -z, sigma, 0.0, 0.0, 0.0, 0.0, 0.0],
            Scalars::PlaneAndTwists => [-y, -z, sigma * ra, sigma * rb, 0.0, 0.0, 0.0, 0.0],
            Scalars::Space => [-y, -z, sigma, j, k, 0.0, 0.0, 0.0],
            Scalars::SpaceAndTwists => [-y, -z, sigma * ra, sigma * rb, j, k, sigma, 0.0],
        };
        let contained = if contained { [gear_mesh.stiffness, gear_mesh.damping] } else { [0.0; 2] };
        let mut interface = Self {
            mesh,
            gear_mesh: gear_mesh.clone(),
            scalars,
            geometry,
            sigma,
            reference: [0.0; MAX_SCALARS],
            reference_force: [0.0; MAX_SCALARS],
            static_force: 0.0,
            highest_frequency,
            mobility,
            gradient,
            contained,
        };
        let rows = interface.rows();
        for (scalar, row) in interface.reference.iter_mut().zip(rows) {
            *scalar = row.iter().map(|(index, coefficient)| coefficient * reference[*index]).sum();
        }
        (interface.reference_force, interface.static_force) = interface.mean_force(reference)?;
        Ok(interface)
    }

    /// Number of scalars.
    #[inline(always)]
    pub(super) fn scalars(&self) -> usize {
        self.motion_scalars() + usize::from(!self.rotation().is_empty())
    }

    /// The free rotation of the train, which the friction resists and the drive keeps, as a row; it is the last scalar.
    fn rotation(&self) -> &[(usize, f64)] {
        self.gear_mesh.friction.as_ref().map_or(&[], |friction| &friction.rotation)
    }

    /// Number of scalars of the relative motion of the gears.
    #[inline(always)]
    fn motion_scalars(&self) -> usize {
        match self.scalars {
            Scalars::Deflection => 1,
            Scalars::Plane => 3,
            Scalars::PlaneAndTwists => 4,
            Scalars::Space => 5,
            Scalars::SpaceAndTwists => 7,
        }
    }

    pub(super) fn has_rates(&self) -> bool {
        let contained =
            self.contained[1] > 0.0 && self.gear_mesh.backlash.is_none() && self.scalars == Scalars::Deflection;
        self.gear_mesh.damping > 0.0 && !contained || self.gear_mesh.has_runout()
    }

    pub(super) fn is_affine(&self) -> bool {
        self.scalars == Scalars::Deflection
            && self.gear_mesh.backlash.is_none()
            && !self.gear_mesh.teeth.is_relieved()
            && !self.has_rates()
    }

    pub(super) fn rows(&self) -> Vec<Row> {
        let mut rows = self.motion_rows();
        if !self.rotation().is_empty() {
            rows.push(self.rotation().to_vec());
        }
        rows
    }

    fn motion_rows(&self) -> Vec<Row> {
        let (gear_mesh, sigma) = (&self.gear_mesh, self.sigma);
        let [ra, rb] = gear_mesh.involute.base_radius;
        let MeshCoordinates { translation, carrier, .. } = gear_mesh.coordinates;
        let twists = |factors: [f64; 2]| gear_mesh.coordinates.twist_row(factors);
        let relative_displacement = |lane: usize| {
            let of_centres = translation.into_iter().flat_map(|[a, b]| [(a + lane, -1.0), (b + lane, 1.0)]);
            let of_carrier = carrier.map(|carrier| (carrier, -gear_mesh.arc()[lane]));
            of_centres.chain(of_carrier.filter(|(_, factor)| *factor != 0.0)).collect::<Row>()
        };
        match self.scalars {
            Scalars::Deflection => {
                let mut row = Vec::new();
                gear_mesh
                    .gradient(sigma, &gear_mesh.directions_at_rest(sigma), |index, slope| row.push((index, slope)));
                vec![row]
            }
            Scalars::Plane => vec![relative_displacement(0), relative_displacement(1), twists([ra, rb])],
            Scalars::PlaneAndTwists => {
                vec![relative_displacement(0), relative_displacement(1), twists([1.0, 0.0]), twists([0.0, 1.0])]
            }
            Scalars::Space | Scalars::SpaceAndTwists => {
                let plane = vec![relative_displacement(0), relative_displacement(1)];
                let Some(helix) = &gear_mesh.helix else { return plane };
                let [along, tilts @ ..] = helix.rows();
                let rolling = twists([ra, rb]).into_iter().chain(along.iter().copied()).collect();
                let rest = if self.scalars == Scalars::Space {
                    vec![rolling].into_iter().chain(tilts).collect::<Vec<_>>()
                } else {
                    vec![twists([1.0, 0.0]), twists([0.0, 1.0])].into_iter().chain(tilts).chain([along]).collect()
                };
                plane.into_iter().chain(rest).collect()
            }
        }
    }

    /// The relative motion of the gears for these scalars, or for their rates.
    #[inline(always)]
    fn relative(&self, scalars: [f64; MAX_SCALARS]) -> RelativeMotion {
        let [driver_radius, driven_radius] = self.gear_mesh.involute.base_radius;
        match self.scalars {
            Scalars::Deflection => {
                let [deflection, ..] = scalars;
                RelativeMotion { rolling_displacement: self.sigma * deflection, ..RelativeMotion::default() }
            }
            Scalars::Plane => {
                let [y, z, rolling_displacement, ..] = scalars;
                RelativeMotion { relative_displacement: [y, z], rolling_displacement, ..RelativeMotion::default() }
            }
            Scalars::PlaneAndTwists => {
                let [y, z, driver, driven, ..] = scalars;
                RelativeMotion {
                    relative_displacement: [y, z],
                    rolling_displacement: driver_radius * driver + driven_radius * driven,
                    twist: [driver, driven],
                    tilt: [0.0; 2],
                }
            }
            Scalars::Space => {
                let [y, z, rolling_displacement, tilt_y, tilt_z, ..] = scalars;
                RelativeMotion {
                    relative_displacement: [y, z],
                    rolling_displacement,
                    tilt: [tilt_y, tilt_z],
                    ..RelativeMotion::default()
                }
            }
            Scalars::SpaceAndTwists => {
                let [y, z, driver, driven, tilt_y, tilt_z, axial, _] = scalars;
                RelativeMotion {
                    relative_displacement: [y, z],
                    rolling_displacement: driver_radius * driver + driven_radius * driven + axial,
                    twist: [driver, driven],
                    tilt: [tilt_y, tilt_z],
                }
            }
        }
    }

    /// The generalised forces of a contact on the scalars.
    #[inline(always)]
    fn forces(&self, contact: &Contact) -> [f64; MAX_SCALARS] {
        let mut forces = self.motion_forces(contact);
        if !self.rotation().is_empty() {
            forces[self.motion_scalars()] = -contact.resistance;
        }
        forces
    }

    #[inline(always)]
    fn motion_forces(&self, contact: &Contact) -> [f64; MAX_SCALARS] {
        let [y, z] = contact.centre_force;
        match self.scalars {
            Scalars::Deflection => [-contact.force, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            Scalars::Plane => {
                [y, z, contact.moments[0] / self.gear_mesh.involute.base_radius[0], 0.0, 0.0, 0.0, 0.0, 0.0]
            }
            Scalars::PlaneAndTwists => [y, z, contact.moments[0], contact.moments[1], 0.0, 0.0, 0.0, 0.0],
            Scalars::Space => {
                let [j, k] = contact.helix.tilt;
                [y, z, -self.sigma * contact.force, j, k, 0.0, 0.0, 0.0]
            }
            Scalars::SpaceAndTwists => {
                let [j, k] = contact.helix.tilt;
                [y, z, contact.moments[0], contact.moments[1], j, k, -self.sigma * contact.force, 0.0]
            }
        }
    }

    /// Generalised forces of the mean stiffness at the reference, on the flanks that carry load, and the mesh force, N.
    fn mean_force(&self, reference: &[f64]) -> Result<([f64; MAX_SCALARS], f64), Overlap> {
        let [(drive, n), (back, m)] = self.gear_mesh.mean_forces(self.geometry, self.sigma, reference)?;
        let force = drive - back;
        let [y, z] = [0, 1].map(|lane| drive * n.normal[lane] + back * m.normal[lane]);
        let slope = self.gear_mesh.helix.as_ref().map_or(0.0, |helix| helix.slope);
        let [j, k] = n.centres.map(|centre| -force * self.sigma * slope * centre);
        let [ra, rb] = self.gear_mesh.involute.base_radius.map(|radius| -force * self.sigma * radius);
        let reference_force = match self.scalars {
            Scalars::Deflection => [-force, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            Scalars::Plane => [y, z, -force * self.sigma, 0.0, 0.0, 0.0, 0.0, 0.0],
            Scalars::PlaneAndTwists => [y, z, ra, rb, 0.0, 0.0, 0.0, 0.0],
            Scalars::Space => [y, z, -force * self.sigma, j, k, 0.0, 0.0, 0.0],
            Scalars::SpaceAndTwists => [y, z, ra, rb, j, k, -force * self.sigma, 0.0],
        };
        Ok((reference_force, force))
    }

    pub(super) fn reference_force(&self) -> &[f64] {
        &self.reference_force[..self.scalars()]
    }

    /// ∂δ/∂(scalars) along the line of action at rest, with the mean stiffness.
    pub(super) fn direction(&self) -> Direction {
        Direction { gradient: self.gradient[..self.scalars()].to_vec(), stiffness: self.gear_mesh.stiffness }
    }

    #[inline(always)]
    pub(super) fn load(
        &self,
        instant: &Instant,
        u: &[f64],
        rates: &[f64],
        load: &mut [f64],
        tangent: Option<Tangent<'_>>,
    ) -> Result<Contact, Overlap> {
        let contact = self.gear_mesh.contact(&self.pose(&instant.phases, u, rates), &instant.contact_mode)?;
        let along = |values: &[f64]| values.iter().zip(&self.gradient).map(|(value, g)| value * g).sum::<f64>();
        let linear = self.contained[0] * along(u) + self.contained[1] * along(rates);
        let forces = self.forces(&contact);
        for (k, load) in load.iter_mut().enumerate() {
            *load = (forces[k] - self.reference_force[k]) + linear * self.gradient[k];
        }
        if let Some(tangent) = tangent {
            let [k, c] = self.residual_tangent(instant.contact_mode.flank, &contact);
            tangent.stiffness[0] = k;
            tangent.damping.fill(c);
        }
        Ok(contact)
    }

    #[inline(always)]
    fn residual_tangent(&self, flank: Flank, contact: &Contact) -> [f64; 2] {
        let film = flank == Flank::Separated && self.gear_mesh.damping_in_separation;
        let dampers = f64::from(u8::from(flank.drives() || film) + u8::from(flank.holds_back()));
        [contact.stiffness - self.contained[0], dampers * self.gear_mesh.damping - self.contained[1]]
    }

    pub(super) fn guaranteed_interval(&self, flank: Flank, contact: &Contact) -> GuaranteedInterval {
        if self.gear_mesh.backlash.is_none() || self.is_firm(flank, contact) {
            return GuaranteedInterval { time: f64::INFINITY, frequency: 0.0 };
        }
        // For separated flanks, the frequency is that of the gear oscillation with teeth in contact.
        let frequency =
            if contact.stiffness > 0.0 { (contact.stiffness * self.mobility).sqrt() } else { self.highest_frequency };
        let [drive, back] = self.margins(flank, contact);
        let presses = matches!(flank, Flank::Drive | Flank::Back);
        // The amplitude of an oscillation is unknown without rates.
        if !self.has_rates() || !presses || drive <= 0.0 || back <= 0.0 {
            return GuaranteedInterval { time: 0.0, frequency };
        }
        // After the time t the distance is at least x − |ẋ|t − aω²t²/2, with the amplitude a.
        let rate = contact.rate.abs();
        let amplitude = ((contact.force - self.static_force) / contact.stiffness).hypot(rate / frequency);
        let time = |margin: f64| {
            2.0 * margin / (rate + (rate * rate + 2.0 * amplitude * frequency * frequency * margin).sqrt())
        };
        GuaranteedInterval { time: time(drive).min(time(back)), frequency }
    }

    pub(super) fn margins(&self, flank: Flank, contact: &Contact) -> [f64; 2] {
        // The force decides on separation unless damping acts in separation too: damping cancels the elastic force before
        // the deflection is zero.
        let by_force = contact.stiffness > 0.0 && !self.gear_mesh.damping_in_separation;
        let pressed = |force: f64, deflection: f64| if by_force { force / contact.stiffness } else { deflection };
        let Contact { force, deflection, back_flank_deflection, .. } = *contact;
        match flank {
            Flank::Drive => [pressed(force, deflection), -back_flank_deflection],
            Flank::Back => [-deflection, pressed(-force, back_flank_deflection)],
            Flank::Separated => [-deflection, -back_flank_deflection],
            Flank::Both => [deflection, back_flank_deflection],
        }
    }

    /// Whether the flank in contact stays pressed and the other flank stays separated. The oscillation of the mesh
    /// force, estimated from the force and its rate, must be at most half of the static force, and at least half of the
    /// backlash must remain.
    fn is_firm(&self, flank: Flank, contact: &Contact) -> bool {
        let (static_force, clear) = match flank {
            Flank::Drive => (self.static_force, contact.back_flank_deflection),
            Flank::Back => (-self.static_force, contact.deflection),
            Flank::Separated | Flank::Both => return false,
        };
        // Forces are relative to the static force, so that squares do not overflow.
        let part = |force: f64| force / static_force;
        let oscillation = part(contact.force - self.static_force).powi(2)
            + part(contact.stiffness * contact.rate / self.highest_frequency).powi(2);
        self.has_rates()
            && static_force > 0.0
            && oscillation <= 0.25
            && clear <= -self.gear_mesh.backlash.unwrap_or(f64::INFINITY) / 2.0
    }

    pub(super) fn contact_mode(
        &self,
        instant: &Instant,
        u: &[f64],
        rates: &[f64],
        unchanged: bool,
    ) -> Result<ContactMode, Overlap> {
        if !self.gear_mesh.switches() {
            return Ok(ContactMode::ALWAYS);
        }
        if unchanged && !self.gear_mesh.teeth.is_sharp() {
            return Ok(instant.contact_mode);
        }
        self.gear_mesh.contact_mode(&self.pose(&instant.phases, u, rates))
    }

    pub(super) fn ends(&self, instant: &Instant, u: &[f64], ends: &mut Vec<(f64, i64)>) -> Result<(), Overlap> {
        if !self.gear_mesh.teeth.is_sharp() {
            return Ok(());
        }
        for back in [false, true] {
            if !back || self.gear_mesh.backlash.is_some() {
                let [low, high] = self.gear_mesh.engagement(&self.pose(&instant.phases, u, &[]), back)?.ends();
                let (first, last) = instant.contact_mode.engaged[usize::from(back)];
                ends.extend([(low, first), (high, last)]);
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn pose<'a>(&self, phases: &'a [ShaftPhase; 2], u: &[f64], rates: &[f64]) -> MeshPose<'a> {
        let (mut scalars, mut speeds) = (self.reference, [0.0; MAX_SCALARS]);
        for (scalar, u) in scalars.iter_mut().zip(u) {
            *scalar += u;
        }
        for (speed, rate) in speeds.iter_mut().zip(rates) {
            *speed = *rate;
        }
        let (position, velocity) = (self.relative(scalars), self.relative(speeds));
        self.gear_mesh.pose_of(self.geometry, self.sigma, phases, position, velocity)
    }
}
