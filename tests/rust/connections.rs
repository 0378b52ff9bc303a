//! Every analysis includes connections: springs modelled as connections give the same results as a bearing in the
//! matrices.

use crate::common::{largest, model, train};
use gearbow::analysis::simulate::{Initial, Method, Options, RecordPlan, Request, Response, simulate};
use gearbow::analysis::{
    ExcitationPart, Interrupt, Spectrum, campbell, critical_speeds, equilibrium, ill_conditioning, synchronous,
};
use gearbow::connection::Spring;
use gearbow::mesh::Geometry;
use gearbow::modal::{CachedModel, modes};
use gearbow::scene::SceneDescription;
use gearbow::scene::description::{Coefficient, Gravity};

const STIFFNESS: f64 = 1e8;
const DAMPING: f64 = 500.0;
/// Round-off of sums in a different order, in a problem with a condition number of 1e5.
const ROUND_OFF: f64 = 1e-9;

/// A scene, and the same scene with springs of stiffness `stiffness` and `cubic` instead of its first bearing.
fn with_springs(system: &SceneDescription, stiffness: f64, cubic: f64) -> CachedModel {
    let mut system = system.clone();
    system.bearings[0].stiffness = Coefficient::Isotropic(0.0).into();
    system.bearings[0].damping = None;
    let model = model(&system);
    let first = model.numbering.translation(model.scene.bearings[0].node).unwrap();
    let spring = |index| Spring { row: vec![(index, 1.0)], stiffness, cubic, damping: DAMPING };
    CachedModel::new(model.with_springs(vec![spring(first), spring(first + 1)]))
}

fn pair(system: &SceneDescription) -> [CachedModel; 2] {
    [CachedModel::new(model(system)), with_springs(system, STIFFNESS, 0.0)]
}

fn heavy() -> SceneDescription {
    let mut system = train();
    system.gravity = Some(Gravity::Down(9.81));
    system
}

/// Largest difference of two lists relative to their largest entry.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let gap: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    largest(&gap) / largest(a)
}

fn options(method: Method, step: Option<f64>) -> Options {
    Options {
        duration: 0.02,
        speed: 100.0.into(),
        method,
        step,
        rtol: matches!(method, Method::Rk45).then_some(1e-11),
        stages: None,
        modes: None,
        reduction: None,
        initial: Initial::Static,
        times: (0..=20).map(|k| f64::from(k) * 1e-3).collect(),
        geometry: Geometry::Live,
        start: 0.0,
        checkpoint: None,
    }
}

fn run(cached: &CachedModel, options: &Options) -> Response {
    let requests = ["gears", "energy"].map(|name| Request::Name(name.to_owned()));
    let plan = RecordPlan::new(&cached.model, &requests).unwrap();
    simulate(cached, options, &plan, &mut |_| true).unwrap()
}

#[test]
fn modes_and_critical_speeds_contain_connections() {
    let interrupt = Interrupt::default();
    let [matrices, springs] = pair(&train());
    let frequencies = |cached: &CachedModel| cached.real_modes(100.0).unwrap().frequencies.as_slice().to_vec();
    assert!(difference(&frequencies(&matrices), &frequencies(&springs)) < ROUND_OFF);
    let eigenvalues = |cached: &CachedModel| -> Vec<f64> {
        modes(cached, 100.0).unwrap().iter().map(|mode| mode.eigenvalue.im).take(20).collect()
    };
    assert!(difference(&eigenvalues(&matrices), &eigenvalues(&springs)) < ROUND_OFF);
    let damping = |cached: &CachedModel| -> Vec<f64> {
        modes(cached, 100.0).unwrap().iter().map(|mode| mode.eigenvalue.re).take(20).collect()
    };
    assert!(difference(&damping(&matrices), &damping(&springs)) < 1e-6);
    let critical = |cached: &CachedModel| -> Vec<f64> {
        critical_speeds(cached, 1.0, &interrupt).unwrap().iter().map(|critical| critical.speed).take(8).collect()
    };
    assert!(difference(&critical(&matrices), &critical(&springs)) < ROUND_OFF);
    let meetings = |cached: &CachedModel| -> Vec<f64> {
        let diagram = campbell(cached, &[10.0, 200.0, 400.0], 6, 1, &interrupt).unwrap();
        diagram.intersections.iter().map(|meeting| meeting.speed).collect()
    };
    assert!(difference(&meetings(&matrices), &meetings(&springs)) < ROUND_OFF);
}

#[test]
fn equilibrium_synchronous_response_and_step_limit_contain_connections() {
    let [matrices, springs] = pair(&heavy());
    for geometry in [Geometry::Live, Geometry::Frozen] {
        let rest = [&matrices, &springs].map(|cached| equilibrium(cached, geometry, 100.0).unwrap());
        assert!(difference(rest[0].as_slice(), rest[1].as_slice()) < ROUND_OFF);
    }
    let response = [&matrices, &springs].map(|cached| synchronous(cached, 100.0, ExcitationPart::Both).unwrap());
    assert!((&response[0] - &response[1]).norm() < ROUND_OFF * response[0].norm());
    let spectrum = [&matrices, &springs].map(|cached| Spectrum::new(cached, 100.0).unwrap());
    assert!((spectrum[0].omega_max / spectrum[1].omega_max - 1.0).abs() < ROUND_OFF);
    // The norm that bounds a damping matrix is √2 times that of its two dampers.
    let ratio = spectrum[0].damping / spectrum[1].damping;
    assert!((1.0 - ROUND_OFF..1.5).contains(&ratio), "{ratio}");
}

#[test]
fn a_connection_is_named_where_it_takes_digits() {
    let stiff = with_springs(&train(), 1e19, 0.0);
    let message = ill_conditioning(&stiff, 100.0).unwrap().unwrap();
    assert!(message.ends_with("a spring of 1.000e19 N/m"), "{message}");
}

#[test]
fn runs_of_every_method_contain_connections() {
    for (method, step) in
        [(Method::Exponential, None), (Method::ExactRk4, Some(1e-6)), (Method::Rk45, None), (Method::Rk4, None)]
    {
        let [matrices, springs] = pair(&heavy()).map(|cached| run(&cached, &options(method, step)));
        let (a, b) = (&matrices.record, &springs.record);
        // The steps of adaptive methods may differ. The results agree to the tolerance.
        let tolerance = if method == Method::Exponential { 1e-6 } else { 1e-8 };
        assert!(difference(&a.displacement, &b.displacement) < tolerance, "{}", method.name());
        let energy = |response: &Response| -> Vec<f64> {
            response.record.energy.iter().map(|(energies, _)| energies.total()).collect()
        };
        assert!(difference(&energy(&matrices), &energy(&springs)) < tolerance, "{}", method.name());
        let works = |response: &Response| -> Vec<f64> {
            response.record.energy.iter().map(|(_, works)| works.iter().sum::<f64>()).collect()
        };
        assert!(difference(&works(&matrices), &works(&springs)) < 10.0 * tolerance, "{}", method.name());
    }
}

#[test]
fn connections_act_as_loads_where_the_linear_motion_leaves_the_meshes_out() {
    let mut system = heavy();
    let teeth = r#"{ model = "parabolic", pair = 2e8, engagement = 0.2 }"#;
    let mesh = format!(
        r#"m = {{ driver = "g1", driven = "g2", stiffness = {teeth}, damping_ratio = 0.05, backlash = 1e-5 }}"#
    );
    let parsed: toml::Table = toml::from_str(&mesh).unwrap();
    let mesh: gearbow::scene::description::Mesh = parsed["m"].clone().try_into().unwrap();
    system.meshes[0] = mesh;
    let cached = pair(&system);
    assert!(cached[1].linear_without_meshes(100.0).unwrap().is_some());
    let [matrices, springs] = cached.map(|cached| run(&cached, &options(Method::Exponential, None)));
    let gap = difference(&matrices.record.displacement, &springs.record.displacement);
    // Both results are accurate to their tolerance of 1e-6.
    assert!(gap < 1e-5, "{gap:e}");
}

#[test]
fn a_cubic_spring_is_the_same_to_the_exponential_method_and_to_runge_kutta() {
    // At the equilibrium displacements of about 1e-5 m, the cubic term is one third of the force.
    let cached = with_springs(&heavy(), STIFFNESS, 3e17);
    let rest = equilibrium(&cached, Geometry::Live, 100.0).unwrap();
    let spring = &cached.model.springs[0];
    let contact = spring.contact(spring.scalar(rest.as_slice()), 0.0);
    assert!((contact.force / (STIFFNESS * contact.deflection) - 1.0).abs() > 0.01, "{contact:?}");
    let exact = run(&cached, &options(Method::Rk45, None));
    for method in [Method::Exponential, Method::ExactRk4] {
        let step = matches!(method, Method::ExactRk4).then_some(1e-6);
        let found = run(&cached, &options(method, step));
        let gap = difference(&exact.record.displacement, &found.record.displacement);
        assert!(gap < 1e-5, "{}: {gap:e}", method.name());
    }
    // The sum of the works equals the change of energy.
    let first = exact.record.energy[0].0.total();
    for (energies, works) in &exact.record.energy {
        let left = energies.total() - first - works.iter().sum::<f64>();
        assert!(left.abs() < 1e-6 * first.abs(), "{left:e} of {first:e}");
    }
}
