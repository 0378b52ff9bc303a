//! How long flanks are said to stay as they are, against a free swing about the force at rest.

use std::f64::consts::{PI, TAU};

use gearbow::integrate::FirstOrderSystem as _;
use gearbow::mesh::{Contact, ContactMode, Flank, Geometry};
use gearbow::modal::CachedModel;
use gearbow::model::Model;
use gearbow::motion::{EquationOfMotion, Interface};
use nalgebra::DVector;
use proptest::prelude::*;

const STIFFNESS: f64 = 3e8;
const BACKLASH: f64 = 4e-5;
/// The force at rest, N.
const CARRIED: f64 = 3e3;

fn cached() -> CachedModel {
    let mesh = format!("stiffness = {STIFFNESS:e}, damping = 2e3, backlash = {BACKLASH:e}");
    let gears = ["teeth = 25, module = 3e-3", "teeth = 50, module = 3e-3"];
    CachedModel::new(Model::new(crate::common::scene_of_mesh(gears, &mesh)).unwrap())
}

/// The motion, and its mesh with the force at rest on the drive flank, or on the back flank.
fn pressed(cached: &CachedModel, back: bool) -> (EquationOfMotion<'_>, Interface) {
    let motion = crate::common::motion(cached, Geometry::Frozen, 100.0, 0.0);
    let mesh = &cached.model.meshes[0];
    let sigma = cached.model.sigma(0, 100.0);
    let deflection = if back { -CARRIED / STIFFNESS - BACKLASH } else { CARRIED / STIFFNESS };
    let mut reference = DVector::zeros(cached.model.len());
    reference[mesh.coordinates.twist[0]] = sigma * deflection / mesh.involute.base_radius[0];
    let interface = Interface::new(&motion, 0, &reference, true).unwrap();
    (motion, interface)
}

proptest! {
    #![proptest_config(crate::common::cases(500))]

    #[test]
    fn flanks_stay_at_least_as_long_as_they_are_said_to(
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
        // The other half of the swing where this one is in the air.
        let phase = if 1.0 + amplitude * phase.sin() > 0.0 { phase } else { phase + PI };
        // Force on the flank that presses, and how far the other one is from its own.
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
        let hold = interface.hold(&motion, &contact);
        // Before or after: where the flank presses at both ends of a stretch, it may have lifted off between.
        let lifts = |t: &f64| [*t, -t].into_iter().any(|t| force(t) <= 0.0 || clear(t) <= 0.0);
        let lifts = (0..2000).map(|i| f64::from(i) * TAU / omega / 2000.0).find(lifts);
        prop_assert!((hold.swing / omega - 1.0).abs() < 1e-12 || hold.time == f64::INFINITY);
        if let Some(lifts) = lifts {
            prop_assert!(hold.time <= lifts, "{} {lifts}", hold.time);
            // And it is not nothing that is said: a third of that time, but for one step of the search.
            prop_assert!(hold.time >= lifts / 3.0 - TAU / omega / 2000.0, "{} {lifts}", hold.time);
        } else if amplitude <= 0.5 {
            prop_assert_eq!(hold.time, f64::INFINITY);
        }
    }
}

#[test]
fn flanks_that_are_apart_or_both_pressed_do_not_stay() {
    let cached = cached();
    let (mut motion, interface) = pressed(&cached, false);
    for flank in [Flank::Apart, Flank::Both] {
        let contact_mode = ContactMode { flank, ..ContactMode::ALWAYS };
        motion.set_contact_modes(&contact_mode.code());
        let contact = Contact { force: CARRIED, stiffness: STIFFNESS, ..Contact::default() };
        assert_eq!(interface.hold(&motion, &contact).time, 0.0);
    }
}
