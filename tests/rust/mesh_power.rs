//! Forces and powers of a contact, compared with the change of its stored energy.
//!
//! For every tooth model, flank and geometry, and along any motion with forces Q on the coordinates,
//!
//! ```text
//! U̇ = drive power − damping power − Q·q̇
//! ```
//!
//! so a wrong sign, a missing term or an exchanged coordinate in the contact leaves a residual. U̇ is a central
//! difference along the motion, in the contact mode of the midpoint.

use gearbow::mesh::{Contact, ContactMode, Flank, GearMesh, Geometry, MeshPose, ShaftPhase};
use nalgebra::Vector6;
use proptest::prelude::*;

const TEETH: [f64; 2] = [25.0, 50.0];
const DAMPING: f64 = 2e3;
const BACKLASH: f64 = 4e-5;

/// Tooth stiffness models, as TOML fields of a mesh.
const STIFFNESSES: [&str; 9] = [
    "stiffness = 3e8",
    r#"stiffness = { model = "square", pair = 2e8, engagement = "sharp" }"#,
    r#"stiffness = { model = "square", pair = 2e8, engagement = 0.3 }"#,
    r#"stiffness = { model = "parabolic", pair = 2e8, end_ratio = 0.5, engagement = "sharp" }"#,
    r#"stiffness = { model = "parabolic", pair = 2e8, end_ratio = 0.5, engagement = 0.3, phase = "twist" }"#,
    r#"stiffness = { model = "square", pair = 2e8, engagement = 0.3, phase = "twist" }"#,
    r#"stiffness = { model = "potential_energy", engagement = 0.2, phase = "twist" }"#,
    r#"stiffness = { model = "fourier", mean = 3e8, amplitudes = [4e7, 1e7], phases = [0.3, -1.0] }"#,
    r#"stiffness = { model = "parabolic", pair = 2e8, end_ratio = 0.5, engagement = 0.3 }, tip_relief = { amount = 8e-6, length = 0.3 }"#,
];
const ERRORS: [&str; 2] =
    ["", ", error = { tooth = [[5e-6, 0.4], [1e-6, 1.0]], driver = [[8e-6, 0.2]], driven = [[6e-6, -0.7]] }"];
const RUNOUTS: [&str; 2] = ["0.0, 0.0", "2e-5, -1e-5"];

fn gear_mesh(stiffness: &str, error: &str, runout: &str, damping: f64) -> GearMesh {
    let gears = TEETH.map(|teeth| format!("teeth = {teeth}, module = 3e-3, runout = [{runout}]"));
    let mesh = format!("damping = {damping}, centre_line_angle = 0.4, backlash = {BACKLASH:e}, {stiffness}{error}");
    crate::common::mesh([&gears[0], &gears[1]], &mesh)
}

/// A motion with constant velocities.
#[derive(Clone, Debug)]
struct ShaftRotation {
    geometry: Geometry,
    spin: f64,
    angle: f64,
    q: Vector6<f64>,
    v: Vector6<f64>,
}

impl ShaftRotation {
    fn sigma(&self) -> f64 {
        self.spin.signum()
    }

    fn phases(&self, after: f64) -> [ShaftPhase; 2] {
        let ratio = -TEETH[0] / TEETH[1];
        let spins = [self.spin, self.spin * ratio];
        spins.map(|spin| ShaftPhase { angle: self.angle * spin / self.spin + spin * after, spin })
    }

    /// The contact mode at this time, with the flank replaced by `flank`.
    fn contact_mode(&self, gear_mesh: &GearMesh, flank: Flank) -> ContactMode {
        let (q, v) = (self.q.as_slice(), self.v.as_slice());
        let phases = self.phases(0.0);
        ContactMode { flank, ..gear_mesh.contact_mode(&self.pose(gear_mesh, &phases, q, v)).unwrap() }
    }

    fn contact(&self, gear_mesh: &GearMesh, contact_mode: &ContactMode, after: f64) -> Contact {
        let q = self.q + self.v * after;
        gear_mesh
            .contact(&self.pose(gear_mesh, &self.phases(after), q.as_slice(), self.v.as_slice()), contact_mode)
            .unwrap()
    }

    fn pose<'a>(&self, gear_mesh: &GearMesh, phases: &'a [ShaftPhase; 2], q: &[f64], v: &[f64]) -> MeshPose<'a> {
        gear_mesh.pose(self.geometry, self.sigma(), phases, q, v)
    }
}

/// Displacements of up to 5e-5 m and velocities of up to 5e-2 m/s. The twists give similar values at the teeth.
fn courses() -> impl Strategy<Value = ShaftRotation> {
    let numbers = || prop::array::uniform6(-1.0..1.0);
    let scaled = |numbers: [f64; 6], size: f64| {
        Vector6::from(numbers).component_mul(&Vector6::new(size, size, size, size, size / 0.04, size / 0.08))
    };
    (prop_oneof![Just(Geometry::Live), Just(Geometry::Frozen)], 0.5..2.0, any::<bool>(), 0.0..6.0, numbers(), numbers())
        .prop_map(move |(geometry, pace, forward, angle, q, v)| ShaftRotation {
            geometry,
            spin: 100.0 * pace * if forward { 1.0 } else { -1.0 },
            angle,
            q: scaled(q, 5e-5),
            v: scaled(v, 5e-2),
        })
}

const FLANKS: [Flank; 4] = [Flank::Drive, Flank::Back, Flank::Separated, Flank::Both];

proptest! {
    #![proptest_config(crate::common::cases(300))]

    #[test]
    fn energy_is_accounted_for(
        rotation in courses(), stiffness in 0..STIFFNESSES.len(), error in 0..2_usize, runout in 0..2_usize,
        flank in 0..FLANKS.len(),
    ) {
        let gear_mesh = gear_mesh(STIFFNESSES[stiffness], ERRORS[error], RUNOUTS[runout], DAMPING);
        let contact_mode = rotation.contact_mode(&gear_mesh, FLANKS[flank]);
        let contact = rotation.contact(&gear_mesh, &contact_mode, 0.0);
        let mut forces = [0.0; 6];
        gear_mesh.apply(&contact, &mut forces);
        let delivered: f64 = forces.iter().zip(&rotation.v).map(|(force, rate)| force * rate).sum();
        // This step moves the teeth by 1e-6 m, which is small compared with the 3e-3 m of a smooth engagement.
        let step = 1e-7;
        let [before, after] = [-step, step].map(|after| rotation.contact(&gear_mesh, &contact_mode, after));
        let change = (after.energy - before.energy) / (2.0 * step);
        // At a kink of the energy slope, for example where a relieved pair just touches, the difference has this error.
        let bends = ((after.energy + before.energy) / 2.0 - contact.energy).abs() / step;
        let left = change + delivered + contact.damping_power - contact.drive_power;
        let size = contact.energy * 1e3 + delivered.abs() + contact.damping_power + contact.drive_power.abs();
        prop_assert!(left.abs() <= 1e-6 * size + bends, "{left:e} of {size:e}, bends {bends:e}");
    }

    #[test]
    fn the_stiffness_is_the_slope_of_the_force(
        rotation in courses(), stiffness in 0..STIFFNESSES.len(), error in 0..2_usize, flank in 0..FLANKS.len(),
    ) {
        // The twist of the driven gear does not move the engagement. Without run-out it changes only the deflection.
        let gear_mesh = gear_mesh(STIFFNESSES[stiffness], ERRORS[error], RUNOUTS[0], 0.0);
        let contact_mode = rotation.contact_mode(&gear_mesh, FLANKS[flank]);
        let contact = rotation.contact(&gear_mesh, &contact_mode, 0.0);
        let turned = |by: f64| {
            let mut turned = rotation.clone();
            turned.q[5] += by;
            turned.contact(&gear_mesh, &contact_mode, 0.0).force
        };
        let by = 1e-9;
        let [low, high] = [turned(-by), turned(by)];
        let slope = (high - low) / (2.0 * by) / (rotation.sigma() * gear_mesh.involute.base_radius[1]);
        // Forces of 2e4 N are accurate to 4e-12 N, and the deflection changes by 7e-11 m. The force has a kink where a
        // pair just touches.
        let bends = ((high + low) / 2.0 - contact.force).abs() / by;
        prop_assert!((slope - contact.stiffness).abs() <= 1e3 + 1e2 * bends, "{slope:e}, {:e}", contact.stiffness);
    }

    #[test]
    fn damping_acts_along_the_line_of_action_of_every_loaded_flank(
        rotation in courses(), stiffness in 0..STIFFNESSES.len(), flank in 0..FLANKS.len(),
    ) {
        let [with, without] =
            [DAMPING, 0.0].map(|damping| gear_mesh(STIFFNESSES[stiffness], "", RUNOUTS[0], damping));
        let contact_mode = rotation.contact_mode(&with, FLANKS[flank]);
        let [damped, elastic] = [&with, &without].map(|gear_mesh| rotation.contact(gear_mesh, &contact_mode, 0.0));
        let mut forces = [0.0; 6];
        with.apply(&damped, &mut forces);
        let mut springs = [0.0; 6];
        without.apply(&elastic, &mut springs);
        let taken: f64 = forces.iter().zip(springs).zip(&rotation.v).map(|((force, spring), v)| (spring - force) * v).sum();
        prop_assert!((taken - damped.damping_power).abs() <= 1e-9 * (taken.abs() + elastic.energy * 1e3));
        let mut rate_squared = 0.0;
        for (presses, back) in [(contact_mode.flank.drives(), false), (contact_mode.flank.holds_back(), true)] {
            if presses {
                let alone = ContactMode { flank: if back { Flank::Back } else { Flank::Drive }, ..contact_mode };
                rate_squared += rotation.contact(&with, &alone, 0.0).damping_power / DAMPING;
            }
        }
        prop_assert!((damped.damping_power - DAMPING * rate_squared).abs() <= 1e-12 * damped.damping_power);
    }
}

#[test]
fn contact_modes_survive_conversion_to_numbers() {
    for flank in FLANKS {
        let contact_mode = ContactMode { flank, engaged: [(-3, 4), (5, 6)] };
        assert_eq!(ContactMode::from_code(&contact_mode.code()), contact_mode);
    }
}
