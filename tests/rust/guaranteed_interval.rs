//! The guaranteed interval without contact change, compared with a free oscillation about the static force.

use std::f64::consts::{PI, TAU};

use gearbow::connection::{Interface, InterfaceOptions};
use gearbow::integrate::FirstOrderSystem as _;
use gearbow::mesh::{Contact, ContactMode, Flank, Geometry};
use gearbow::modal::CachedModel;
use gearbow::model::Model;
use gearbow::motion::EquationOfMotion;
use nalgebra::DVector;
use proptest::prelude::*;

const STIFFNESS: f64 = 3e8;
const BACKLASH: f64 = 4e-5;
/// Static mesh force, N.
const CARRIED: f64 = 3e3;

fn cached() -> CachedModel {
    let mesh = format!("stiffness = {STIFFNESS:e}, damping = 2e3, backlash = {BACKLASH:e}");
    let gears = ["teeth = 25, module = 3e-3", "teeth = 50, module = 3e-3"];
    CachedModel::new(Model::new(crate::common::scene_of_mesh(gears, &mesh)).unwrap())
}

/// The motion, and the interface of its mesh with the static force on the drive flank or on the back flank.
fn pressed(cached: &CachedModel, back: bool) -> (EquationOfMotion<'_>, Interface) {
    let motion = crate::common::motion(cached, Geometry::Frozen, 100.0, 0.0);
    let mesh = &cached.model.meshes[0];
    let sigma = cached.model.sigma(0, 100.0);
    let deflection = if back { -CARRIED / STIFFNESS - BACKLASH } else { CARRIED / STIFFNESS };
    let mut reference = DVector::zeros(cached.model.len());
    reference[mesh.coordinates.twist[0]] = sigma * deflection / mesh.involute.base_radius[0];
    let options = InterfaceOptions {
        geometry: Geometry::Frozen,
        reference: reference.as_slice(),
        contained: true,
        speed: 100.0,
        bearing_speed: 100.0,
        highest_frequency: motion.highest_mesh_frequency(),
        mobility: motion.mobility(0),
    };
    let connection = cached.model.connections(100.0).next().unwrap();
    let interface = Interface::new(connection, options).unwrap();
    (motion, interface)
}

proptest! {
    #![proptest_config(crate::common::cases(500))]

    #[test]
    fn flanks_keep_their_state_in_the_guaranteed_interval(
        amplitude in 0.0..4.0_f64, phase in 0.0..TAU, back: bool,
    ) {
        let cached = cached();
        let (mut motion, interface) = pressed(&cached, back);
        let contact_mode = ContactMode {
            flank: if back { Flank::Back } else { Flank::Drive },
            ..ContactMode::ALWAYS
        };
        motion.set_contact_modes(&contact_mode.code());
        let omega = (STIFFNESS * motion.mobility(0)).sqrt();
        // If the flank is separated at this phase, use the phase half a period later.
        let phase = if 1.0 + amplitude * phase.sin() > 0.0 { phase } else { phase + PI };
        // Force on the loaded flank, N, and clearance of the opposite flank, m.
        let force = |t: f64| CARRIED * (1.0 + amplitude * (phase + omega * t).sin());
        let clear = |t: f64| BACKLASH + force(t) / STIFFNESS;
        let sign = if back { -1.0 } else { 1.0 };
        let contact = Contact {
            force: sign * force(0.0),
            rate: sign * CARRIED / STIFFNESS * amplitude * omega * phase.cos(),
            stiffness: STIFFNESS,
            deflection: if back { -clear(0.0) } else { force(0.0) / STIFFNESS },
            back_flank_deflection: if back { 0.0 } else { -clear(0.0) },
            ..Contact::default()
        };
        let hold = interface.guaranteed_interval(motion.contact_mode(Some(0)), &contact);
        // Search forward and backward in time: a flank that is in contact at both ends of an interval may separate
        // within it.
        let lifts = |t: &f64| [*t, -t].into_iter().any(|t| force(t) <= 0.0 || clear(t) <= 0.0);
        let lifts = (0..2000).map(|i| f64::from(i) * TAU / omega / 2000.0).find(lifts);
        prop_assert!((hold.frequency / omega - 1.0).abs() < 1e-12 || hold.time == f64::INFINITY);
        if let Some(lifts) = lifts {
            prop_assert!(hold.time <= lifts, "{} {lifts}", hold.time);
            // The bound is also useful: it is at least one third of the exact time, less one step of the search.
            prop_assert!(hold.time >= lifts / 3.0 - TAU / omega / 2000.0, "{} {lifts}", hold.time);
        } else if amplitude <= 0.5 {
            prop_assert_eq!(hold.time, f64::INFINITY);
        }
    }
}

#[test]
fn separated_or_double_contact_has_no_guaranteed_interval() {
    let cached = cached();
    let (mut motion, interface) = pressed(&cached, false);
    for flank in [Flank::Separated, Flank::Both] {
        let contact_mode = ContactMode { flank, ..ContactMode::ALWAYS };
        motion.set_contact_modes(&contact_mode.code());
        let contact = Contact { force: CARRIED, stiffness: STIFFNESS, ..Contact::default() };
        assert_eq!(interface.guaranteed_interval(motion.contact_mode(Some(0)), &contact).time, 0.0);
    }
}
