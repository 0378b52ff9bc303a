//! Every analysis and every method contains connections. A table with the same coefficients at all speeds gives the results
//! of a bearing in the matrices; tables, rolling elements and oil films give the same motion by every method.

use std::sync::Arc;

use crate::common::{Noise, largest, model, train};
use gearbow::analysis::simulate::{Initial, Method, Options, RecordPlan, Request, Response, System, simulate};
use gearbow::analysis::{
    ExcitationPart, Interrupt, Spectrum, Threads, campbell, critical_speeds, equilibrium, synchronous,
};
use gearbow::connection::{Connection, Instant, Interface, InterfaceOptions, Tangent};
use gearbow::integrate::Statistics;
use gearbow::mesh::{ContactMode, Geometry, ShaftPhase};
use gearbow::modal::{AtSpeed, ModeSelection, modes};
use gearbow::motion::{Energies, Profile, SourceTerms, Speed};
use gearbow::scene::SceneDescription;
use gearbow::scene::description::Gravity;

/// Round-off of sums in a different order, in a problem with a condition number of 1e5.
const ROUND_OFF: f64 = 1e-9;

/// A bearing with the coefficients of the other bearings, and the same in a table over the speed.
const CONSTANT: &str = "stiffness = 1e8, damping = 500.0";
const SAME_AT_ALL_SPEEDS: &str = "stiffness = { speeds = [0.0, 1e4], values = [1e8, 1e8] }, damping = 500.0";
/// A bearing whose stiffness and cross-coupling rise by a factor of three from 100 to 120 rad/s.
const STIFFENING: &str = "stiffness = { speeds = [0.0, 100.0, 120.0, 1e4], values = [[[1e8, 2e7], [-2e7, 8e7]], \
    [[1e8, 2e7], [-2e7, 8e7]], [[3e8, 6e7], [-6e7, 2.4e8]], [[3e8, 6e7], [-6e7, 2.4e8]]] }, \
    damping = { speeds = [0.0, 1e4], values = [500.0, 2e4] }";
/// Rolling elements with a clearance, whose force grows with the power 3/2 of the deflection.
const ROLLING: &str = "elements = 8, element_diameter = 0.01, pitch_diameter = 0.06, clearance = 2e-6, hertz_stiffness = 1e10, \
    damping = 500.0";
/// Balls and rollers between rings of five degrees of freedom, with a preload against a second ring.
const BALLS: &str = "elements = 12, element_diameter = 0.01, pitch_diameter = 0.06, contact_angle = -0.4, hertz_stiffness = 1e10, \
    degrees_of_freedom = 5, axial_preload = 500.0, clearance = 0.0, damping = 500.0, axial_damping = 500.0";
const ROLLERS: &str = "contact = \"roller\", elements = 12, element_diameter = 0.01, pitch_diameter = 0.06, contact_angle = -0.4, \
    hertz_stiffness = 1e8, degrees_of_freedom = 5, axial_preload = 500.0, clearance = 0.0, damping = 500.0, axial_damping = 500.0";
/// The oil film of a journal bearing.
const JOURNAL: &str = "diameter = 0.05, length = 0.02, clearance = 5e-5, viscosity = 0.02";

/// The system with other entries of its first bearing, and of the second one on the same shaft if an axial preload needs it.
fn with_bearing(system: &SceneDescription, entries: &str) -> SceneDescription {
    let bearing = |position: f64, entries: &str| {
        let text = format!(r#"bearing = {{ shaft = "input", position = {position:?}, {entries} }}"#);
        let parsed: toml::Table = toml::from_str(&text).unwrap();
        parsed["bearing"].clone().try_into().unwrap()
    };
    let mut system = system.clone();
    system.bearings[0] = bearing(0.0, entries);
    if entries.contains("axial_preload") {
        system.bearings[1] = bearing(0.5, &entries.replace("contact_angle = -", "contact_angle = "));
    }
    system
}

/// The system with its first bearing in the matrices, and as a connection.
fn forms(system: &SceneDescription) -> [System; 2] {
    [CONSTANT, SAME_AT_ALL_SPEEDS].map(|entries| System::new(model(&with_bearing(system, entries))))
}

fn heavy() -> SceneDescription {
    let mut system = train();
    system.gravity = Some(Gravity::Down(9.81));
    system
}

/// A run-up from 100 to 120 rad/s in 0.02 s.
fn run_up() -> Speed {
    Speed::Changing(Profile::new(vec![0.0, 1.0], &[[100.0, 1000.0, 0.0, 0.0]]).unwrap())
}

/// Largest difference of two lists relative to their largest entry.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let gap: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    largest(&gap) / largest(a)
}

fn options(speed: Speed, method: Method, step: Option<f64>) -> Options {
    Options {
        duration: 0.02,
        speed,
        method,
        step,
        rtol: matches!(method, Method::Rk45).then_some(1e-11),
        stages: None,
        modes: None,
        reduction: None,
        kept_modes: None,
        force_error: None,
        initial: Initial::Static,
        times: (0..=20).map(|k| f64::from(k) * 1e-3).collect(),
        geometry: Geometry::Live,
        start: 0.0,
        checkpoint: None,
    }
}

fn run(cached: &System, options: &Options) -> Response {
    let requests = ["gears", "energy"].map(|name| Request::Name(name.to_owned()));
    let plan = RecordPlan::new(&cached.model, &requests).unwrap();
    simulate(cached, options, &plan, &mut |_| true).unwrap()
}

#[test]
fn one_static_equilibrium_stands_for_all_speeds_of_a_direction_where_none_depends_on_the_speed() {
    let is_one = [(ROLLING, true), (BALLS, true), (ROLLERS, true), (JOURNAL, false), (STIFFENING, false)];
    for (entries, is_one) in is_one {
        let cached = System::new(model(&with_bearing(&heavy(), entries)));
        let [slow, fast, backward] = [100.0, 120.0, -100.0].map(|speed| match cached.at_speed(speed).unwrap() {
            AtSpeed::Specialised(found) => found,
            AtSpeed::Same(_) => panic!("{entries} has its coefficients at the equilibrium"),
        });
        assert_eq!(Arc::ptr_eq(&slow, &fast), is_one, "{entries}");
        // The other flanks carry the load.
        assert!(!Arc::ptr_eq(&slow, &backward), "{entries}");
    }
}

#[test]
fn modes_and_critical_speeds_contain_connections() {
    let interrupt = Interrupt::default();
    let [matrices, table] = forms(&train());
    let eigenvalues = |cached: &System| -> Vec<f64> {
        modes(&cached.at_speed(100.0).unwrap(), 100.0, usize::MAX, ModeSelection::All)
            .unwrap()
            .iter()
            .map(|mode| mode.eigenvalue.im)
            .take(20)
            .collect()
    };
    let damping = |cached: &System| -> Vec<f64> {
        modes(&cached.at_speed(100.0).unwrap(), 100.0, usize::MAX, ModeSelection::All)
            .unwrap()
            .iter()
            .map(|mode| mode.eigenvalue.re)
            .take(20)
            .collect()
    };
    let critical = |cached: &System| -> Vec<f64> {
        let found = critical_speeds(cached, 1.0, usize::MAX, &interrupt).unwrap();
        found.iter().map(|critical| critical.speed).take(8).collect()
    };
    let meetings = |cached: &System| -> Vec<f64> {
        let diagram = campbell(cached, &[10.0, 200.0, 400.0], 6, 1, &Threads::new(2, 6), &interrupt).unwrap();
        diagram.intersections.iter().map(|meeting| meeting.speed).collect()
    };
    assert!(difference(&eigenvalues(&matrices), &eigenvalues(&table)) < ROUND_OFF);
    assert!(difference(&damping(&matrices), &damping(&table)) < 1e-6);
    assert!(difference(&critical(&matrices), &critical(&table)) < ROUND_OFF);
    assert!(difference(&meetings(&matrices), &meetings(&table)) < ROUND_OFF);
}

#[test]
fn equilibrium_synchronous_response_and_step_limit_contain_connections() {
    let forms = forms(&heavy());
    for geometry in [Geometry::Live, Geometry::Frozen] {
        let rest = forms.each_ref().map(|cached| equilibrium(cached, geometry, 100.0).unwrap());
        assert!(difference(rest[0].as_slice(), rest[1].as_slice()) < ROUND_OFF);
    }
    let response = forms.each_ref().map(|cached| synchronous(cached, 100.0, ExcitationPart::All).unwrap());
    assert!((&response[0] - &response[1]).norm() < ROUND_OFF * response[0].norm());
    let spectrum = forms.each_ref().map(|cached| Spectrum::new(cached, 100.0).unwrap());
    assert!((spectrum[0].omega_max / spectrum[1].omega_max - 1.0).abs() < ROUND_OFF);
    // The norm that bounds a damping matrix is √2 times that of its two dampers.
    let ratio = spectrum[0].damping / spectrum[1].damping;
    assert!((1.0 / 1.5..1.5).contains(&ratio), "{ratio}");
}

/// The train with backlash and tooth pairs in its first mesh, so that the linear motion excludes all connections.
fn with_backlash() -> SceneDescription {
    let mut system = heavy();
    let teeth = r#"{ model = "parabolic", pair = 2e8, engagement = 0.2 }"#;
    let mesh = format!(
        r#"m = {{ driver = "g1", driven = "g2", stiffness = {teeth}, damping_ratio = 0.05, backlash = 1e-5 }}"#
    );
    let parsed: toml::Table = toml::from_str(&mesh).unwrap();
    system.meshes[0] = parsed["m"].clone().try_into().unwrap();
    system
}

#[test]
fn runs_of_every_method_contain_connections() {
    // ETDRK4 needs a constant speed, at which a table belongs to the matrices.
    for (method, step) in [(Method::Exponential, None), (Method::Rk45, None), (Method::Rk4, None)] {
        let [matrices, table] = forms(&heavy()).map(|cached| run(&cached, &options(run_up(), method, step)));
        let (a, b) = (&matrices.record, &table.record);
        // The steps of adaptive methods may differ. The results agree to the tolerance.
        let tolerance = if method == Method::Exponential { 1e-6 } else { 1e-8 };
        assert!(difference(&a.displacement, &b.displacement) < tolerance, "{}", method.name());
        let energy = |response: &Response| -> Vec<f64> {
            response.record.energy.iter().map(|(energies, _)| energies.total()).collect()
        };
        assert!(difference(&energy(&matrices), &energy(&table)) < tolerance, "{}", method.name());
        let works = |response: &Response| -> Vec<f64> {
            response.record.energy.iter().map(|(_, works)| works.values().iter().sum::<f64>()).collect()
        };
        assert!(difference(&works(&matrices), &works(&table)) < 10.0 * tolerance, "{}", method.name());
    }
}

#[test]
fn connections_act_as_loads_if_the_linear_motion_excludes_the_meshes() {
    let [matrices, table] = forms(&with_backlash());
    let [expected, found] =
        [&matrices, &table].map(|cached| run(cached, &options(run_up(), Method::Exponential, None)));
    assert!(expected.statistics.events > 0);
    let gap = difference(&expected.record.displacement, &found.record.displacement);
    // Both results are accurate to their tolerance of 1e-6.
    assert!(gap < 1e-5, "{gap:e}");
    assert_eq!(expected.statistics.events, found.statistics.events);
}

/// Largest difference between the sum of the works and the change of energy, relative to the initial energy.
fn imbalance(response: &Response) -> f64 {
    let first = response.record.energy[0].0.total();
    let left =
        |(energies, works): &(Energies, SourceTerms)| energies.total() - first - works.values().iter().sum::<f64>();
    response.record.energy.iter().map(left).fold(0.0_f64, |most, left| most.max(left.abs())) / first.abs()
}

/// Options of a short run with a tight tolerance.
fn tight(speed: Speed, method: Method) -> Options {
    Options {
        duration: 5e-3,
        times: (0..=5).map(|k| f64::from(k) * 1e-3).collect(),
        rtol: matches!(method, Method::Exponential | Method::Rk45).then_some(1e-11),
        ..options(speed, method, matches!(method, Method::ExactRk4 | Method::Rk4).then_some(1e-6))
    }
}

#[test]
fn every_method_gives_the_same_motion() {
    let mut damped = heavy();
    // With modal damping, Runge–Kutta methods also integrate in modes.
    damped.modal_damping = Some(0.01.into());
    let constant = || Speed::Constant(100.0);
    for (entries, speed) in [(STIFFENING, run_up()), (ROLLING, constant()), (ROLLING, run_up()), (JOURNAL, constant())]
    {
        // With backlash, the linear motion excludes the meshes.
        for system in [heavy(), damped.clone(), with_backlash()] {
            let cached = System::new(model(&with_bearing(&system, entries)));
            let exact = run(&cached, &tight(speed.clone(), Method::Rk45));
            assert!(imbalance(&exact) < 1e-6, "{entries}");
            // The damping of a film over the mass of a node is 3e7 1/s: the order of ETDRK4 falls (3e-5 at this step, 9e-7 at an
            // eighth of it), and rk4 is not stable. The step of rk4 is near its stability limit for the other bearings, so that
            // its fast modes are less accurate. ETDRK4 needs a constant speed.
            let methods = match (entries, &speed) {
                (JOURNAL, _) => vec![(Method::Exponential, 1e-8), (Method::ExactRk4, 1e-4)],
                (_, Speed::Changing(_)) => vec![(Method::Exponential, 1e-8), (Method::Rk4, 1e-6)],
                _ => vec![(Method::Exponential, 1e-8), (Method::ExactRk4, 1e-8), (Method::Rk4, 1e-6)],
            };
            for (method, tolerance) in methods {
                let found = run(&cached, &tight(speed.clone(), method));
                let gap = difference(&exact.record.displacement, &found.record.displacement);
                assert!(gap < tolerance, "{entries} {}: {gap:e}", method.name());
                assert!(imbalance(&found) < 1e-6, "{entries} {}", method.name());
            }
        }
    }
}

#[test]
fn the_tangent_is_the_derivative_of_the_load() {
    let mut noise = Noise::new(11);
    for (entries, count) in [(STIFFENING, 2), (ROLLING, 2), (BALLS, 5), (ROLLERS, 3), (JOURNAL, 2)] {
        let model = model(&with_bearing(&heavy(), entries));
        let cached = System::new(model);
        let at_speed = cached.at_speed(110.0).unwrap();
        // A table stays a connection; a nonlinear bearing needs its coefficients in the matrices.
        let model = if entries == STIFFENING { &cached.model } else { &at_speed.model };
        let reference = equilibrium(&cached, Geometry::Live, 110.0).unwrap();
        let options = InterfaceOptions {
            geometry: Geometry::Live,
            reference: reference.as_slice(),
            contained: true,
            speed: 110.0,
            bearing_speed: 110.0,
            highest_frequency: 0.0,
            mobility: 0.0,
        };
        let bearing =
            model.connections(110.0).find(|one| matches!(one, Connection::Bearing(_) | Connection::Nonlinear(_)));
        let interface = Interface::new(bearing.unwrap(), options).unwrap();
        let phase = ShaftPhase { angle: 0.7, spin: 115.0 };
        let instant = Instant { time: 0.0, phases: [phase, ShaftPhase::default()], contact_mode: ContactMode::ALWAYS };
        assert_eq!(interface.scalars(), count);
        let (u, rates) = (noise.vector(count, 1e-6), noise.vector(count, 1e-3));
        let load = |u: &[f64], rates: &[f64]| {
            let mut load = vec![0.0; count];
            interface.load(&instant, u, rates, &mut load, None).unwrap();
            load
        };
        let ([mut stiffness, mut damping], mut with_tangent) =
            ([(); 2].map(|()| vec![0.0; count * count]), vec![0.0; count]);
        let tangent = Tangent { stiffness: &mut stiffness, damping: &mut damping };
        interface.load(&instant, &u, &rates, &mut with_tangent, Some(tangent)).unwrap();
        assert_eq!(with_tangent, load(&u, &rates));
        for k in 0..count {
            let shifted = |values: &[f64], by: f64| -> Vec<f64> {
                values.iter().enumerate().map(|(i, value)| value + if i == k { by } else { 0.0 }).collect()
            };
            let steps = [1e-9, 1e-6];
            let differences = [(steps[0], true), (steps[1], false)].map(|(by, moves)| {
                let [after, before] = [by, -by].map(|by| match moves {
                    true => load(&shifted(&u, by), &rates),
                    false => load(&u, &shifted(&rates, by)),
                });
                (0..count).map(|i| -(after[i] - before[i]) / (2.0 * by)).collect::<Vec<_>>()
            });
            for ((tangent, difference), by) in [&stiffness, &damping].into_iter().zip(differences).zip(steps) {
                // Round-off of a force of 10 kN over the step.
                let round_off = f64::EPSILON * 1e4 / by;
                for i in 0..count {
                    let gap = (tangent[count * i + k] - difference[i]).abs();
                    assert!(
                        gap <= 1e-5 * largest(tangent) + round_off,
                        "{entries} {k} {i}: {tangent:?} {difference:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_loads_of_a_run_are_the_forces_of_rolling_elements() {
    // The combinations that a run has of rollers, of balls and of planar bearings carry all generalised forces.
    let mut noise = Noise::new(12);
    for entries in [ROLLING, BALLS, ROLLERS] {
        let cached = System::new(model(&with_bearing(&heavy(), entries)));
        let model = cached.at_speed(110.0).unwrap().model.clone();
        let reference = equilibrium(&cached, Geometry::Live, 110.0).unwrap();
        let options = InterfaceOptions {
            geometry: Geometry::Live,
            reference: reference.as_slice(),
            contained: true,
            speed: 110.0,
            bearing_speed: 110.0,
            highest_frequency: 0.0,
            mobility: 0.0,
        };
        let bearing = &model.nonlinear_bearings[0];
        let interface = Interface::new(Connection::Nonlinear(bearing), options).unwrap();
        let phase = ShaftPhase { angle: 0.7, spin: 115.0 };
        let instant = Instant { time: 0.0, phases: [phase, ShaftPhase::default()], contact_mode: ContactMode::ALWAYS };
        let (moved, v) = (noise.vector(model.len(), 1e-5), noise.vector(model.len(), 1e-3));
        let q: Vec<f64> = reference.iter().zip(&moved).map(|(reference, moved)| reference + moved).collect();
        let along = |values: &[f64]| -> Vec<f64> {
            let rows = interface.rows();
            rows.iter().map(|row| row.iter().map(|(index, factor)| factor * values[*index]).sum()).collect()
        };
        let mut load = vec![0.0; interface.scalars()];
        interface.load(&instant, &along(&moved), &along(&v), &mut load, None).unwrap();
        let mut found = vec![0.0; model.len()];
        for ((row, load), at_rest) in interface.rows().iter().zip(&load).zip(interface.reference_force()) {
            row.iter().for_each(|(index, factor)| found[*index] += factor * (load + at_rest));
        }
        let mut expected = vec![0.0; model.len()];
        bearing.apply(&phase, &q, &v, &mut expected).unwrap();
        // Forces of kilonewtons cancel to the remainder.
        assert!(difference(&expected, &found) < ROUND_OFF, "{entries}: {expected:?} {found:?}");
    }
}

#[test]
fn the_load_of_a_turning_bow_has_a_potential() {
    let cached = System::new(model(&SceneDescription { bow_torque: true, ..heavy() }));
    let model = &cached.model;
    assert!(!model.bows.is_empty());
    let reference = vec![0.0; model.len()];
    let options = InterfaceOptions {
        geometry: Geometry::Live,
        reference: &reference,
        contained: true,
        speed: 110.0,
        bearing_speed: 110.0,
        highest_frequency: 0.0,
        mobility: 0.0,
    };
    for bow in &model.bows {
        let interface = Interface::new(Connection::Bow(bow), options).unwrap();
        let phase = ShaftPhase { angle: 0.7, spin: 115.0 };
        let instant = Instant { time: 0.0, phases: [phase, ShaftPhase::default()], contact_mode: ContactMode::ALWAYS };
        let load = |u: [f64; 3]| {
            let mut load = [0.0; 3];
            interface.load(&instant, &u, &[], &mut load, None).unwrap();
            load
        };
        let u: [f64; 3] = [2e-4, -1e-4, 3e-2];
        // U = F Re(s* (e^{i(ϑ + θ)} − e^{iϑ})).
        let energy = |[real, imaginary, twist]: [f64; 3]| {
            let ((sin, cos), (turned_sin, turned_cos)) = (phase.angle.sin_cos(), (phase.angle + twist).sin_cos());
            bow.force * (real * (turned_cos - cos) + imaginary * (turned_sin - sin))
        };
        for k in 0..3 {
            let by = 1e-6;
            let shifted = |by: f64| std::array::from_fn(|i| u[i] + if i == k { by } else { 0.0 });
            let difference = (energy(shifted(by)) - energy(shifted(-by))) / (2.0 * by);
            // Round-off of the energy over the step.
            assert!((load(u)[k] - difference).abs() < 1e-9 * bow.force, "{k}: {difference} {:?}", load(u));
        }
    }
}

#[test]
fn a_rigid_rotation_does_not_turn_a_bow_that_nothing_holds() {
    let mut system = SceneDescription { bow_torque: true, ..train() };
    let free = model(&system);
    let drive = r#"drive = { at = "g1", stiffness = 1e4 }"#;
    let parsed: toml::Table = toml::from_str(drive).unwrap();
    system.drives = vec![parsed["drive"].clone().try_into().unwrap()];
    let held = model(&system);
    for (model, expected) in [(&free, 0.0), (&held, 1.0)] {
        for bow in &model.bows {
            let mut rotation = vec![0.0; model.len()];
            for shaft in &model.shafts {
                let chain = shaft.twist.as_ref().unwrap();
                rotation[chain.start..chain.start + chain.nodes].fill(shaft.ratio / model.shafts[bow.shaft].ratio);
            }
            assert!((bow.twist(&rotation) - expected).abs() < 1e-12);
        }
    }
}

#[test]
fn equilibrium_carries_gravity_by_a_hardening_bearing() {
    for entries in [ROLLING, JOURNAL] {
        let cached = System::new(model(&with_bearing(&heavy(), entries)));
        let q = equilibrium(&cached, Geometry::Frozen, 100.0).unwrap();
        let at_speed = cached.at_speed(100.0).unwrap();
        let model = &at_speed.model;
        let mut left = &model.constant_load - model.static_force(&q);
        for connection in model.connections(100.0) {
            let (rows, force) = match connection {
                Connection::Mesh(_, mesh, sigma) => {
                    (connection.rows(), vec![mesh.stiffness * mesh.deflection_at_rest(sigma, q.as_slice())])
                }
                Connection::Nonlinear(bearing) => {
                    (connection.rows(), bearing.static_tangent(100.0, q.as_slice()).0.as_slice().to_vec())
                }
                Connection::Bearing(_) | Connection::Load(_) | Connection::Bow(_) => continue,
            };
            for (row, force) in rows.iter().zip(force) {
                row.iter().for_each(|(index, factor)| left[*index] -= factor * force);
            }
        }
        assert!(left.norm() < 1e-9 * model.constant_load.norm(), "{entries}: {:e}", left.norm());
    }
}

#[test]
fn a_bearing_on_a_housing_acts_on_shaft_and_housing() {
    for (entries, speed) in [(STIFFENING, run_up()), (ROLLING, Speed::Constant(100.0))] {
        let mut system = with_bearing(&heavy(), &format!(r#"{entries}, support = "housing""#));
        let housing = r#"housing = { name = "housing", mass = 20.0, stiffness = 5e7, damping = 1e3 }"#;
        let parsed: toml::Table = toml::from_str(housing).unwrap();
        system.housings = vec![parsed["housing"].clone().try_into().unwrap()];
        let cached = System::new(model(&system));
        let [exact, found] =
            [Method::Rk45, Method::Exponential].map(|method| run(&cached, &tight(speed.clone(), method)));
        let gap = difference(&exact.record.displacement, &found.record.displacement);
        assert!(gap < 1e-8, "{entries}: {gap:e}");
        assert!(imbalance(&found) < 1e-6, "{entries}");
    }
}

#[test]
fn the_full_tangent_saves_iterations() {
    for (entries, speed) in [(STIFFENING, run_up()), (ROLLING, Speed::Constant(100.0))] {
        let cached = System::new(model(&with_bearing(&heavy(), entries)));
        let run = run(&cached, &options(speed, Method::Exponential, None));
        let Statistics { steps, rejected, evaluations, .. } = run.statistics;
        // A step evaluates three stages in each iteration, and its end.
        let iterations = (evaluations as f64 / (steps + rejected) as f64 - 1.0) / 3.0;
        // One iteration is the least; these need 1.2 and 1.04.
        assert!(iterations < 1.3, "{entries}: {iterations}");
    }
}
