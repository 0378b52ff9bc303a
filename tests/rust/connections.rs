//! Every analysis includes connections: springs modelled as connections give the same results as a bearing in the
//! matrices.

use crate::common::{largest, model, train};
use gearbow::analysis::simulate::{Initial, Method, Options, RecordPlan, Request, Response, simulate};
use gearbow::analysis::{
    ExcitationPart, Interrupt, Spectrum, campbell, critical_speeds, equilibrium, ill_conditioning, synchronous,
};
use gearbow::connection::{Connection, Row, Spring};
use gearbow::integrate::Statistics;
use gearbow::mesh::Geometry;
use gearbow::modal::{CachedModel, modes};
use gearbow::motion::Energies;
use gearbow::scene::SceneDescription;
use gearbow::scene::description::{Coefficient, Gravity};

const STIFFNESS: f64 = 1e8;
const DAMPING: f64 = 500.0;
/// Round-off of sums in a different order, in a problem with a condition number of 1e5.
const ROUND_OFF: f64 = 1e-9;

/// The model of a scene with springs instead of its first bearing. `rows` gives the scalars of each spring from the index
/// of v of the bearing's node.
fn without_bearing(
    system: &SceneDescription,
    rows: impl Fn(usize) -> Vec<Vec<Row>>,
    stiffness: f64,
    cubic: f64,
) -> CachedModel {
    let mut system = system.clone();
    system.bearings[0].stiffness = Some(Coefficient::Isotropic(0.0).into());
    system.bearings[0].damping = None;
    let model = model(&system);
    let first = model.numbering.translation(model.scene.bearings[0].node).unwrap();
    let springs = rows(first).into_iter().map(|rows| Spring { rows, stiffness, cubic, damping: DAMPING });
    CachedModel::new(model.with_springs(springs.collect()))
}

/// Two springs on one scalar each.
fn with_springs(system: &SceneDescription, stiffness: f64, cubic: f64) -> CachedModel {
    without_bearing(system, |v| vec![vec![vec![(v, 1.0)]], vec![vec![(v + 1, 1.0)]]], stiffness, cubic)
}

/// One isotropic spring on two scalars.
fn with_isotropic_spring(system: &SceneDescription, stiffness: f64, cubic: f64) -> CachedModel {
    without_bearing(system, |v| vec![vec![vec![(v, 1.0)], vec![(v + 1, 1.0)]]], stiffness, cubic)
}

/// The scene with its first bearing in the matrices, as two springs on one scalar each, and as one spring on two scalars.
fn forms(system: &SceneDescription) -> [CachedModel; 3] {
    [
        CachedModel::new(model(system)),
        with_springs(system, STIFFNESS, 0.0),
        with_isotropic_spring(system, STIFFNESS, 0.0),
    ]
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
    let [matrices, springs @ ..] = forms(&train());
    let frequencies = |cached: &CachedModel| cached.real_modes(100.0).unwrap().frequencies.as_slice().to_vec();
    let eigenvalues = |cached: &CachedModel| -> Vec<f64> {
        modes(cached, 100.0, usize::MAX).unwrap().iter().map(|mode| mode.eigenvalue.im).take(20).collect()
    };
    let damping = |cached: &CachedModel| -> Vec<f64> {
        modes(cached, 100.0, usize::MAX).unwrap().iter().map(|mode| mode.eigenvalue.re).take(20).collect()
    };
    let critical = |cached: &CachedModel| -> Vec<f64> {
        critical_speeds(cached, 1.0, usize::MAX, &interrupt)
            .unwrap()
            .iter()
            .map(|critical| critical.speed)
            .take(8)
            .collect()
    };
    let meetings = |cached: &CachedModel| -> Vec<f64> {
        let diagram = campbell(cached, &[10.0, 200.0, 400.0], 6, 1, &interrupt).unwrap();
        diagram.intersections.iter().map(|meeting| meeting.speed).collect()
    };
    for springs in &springs {
        assert!(difference(&frequencies(&matrices), &frequencies(springs)) < ROUND_OFF);
        assert!(difference(&eigenvalues(&matrices), &eigenvalues(springs)) < ROUND_OFF);
        assert!(difference(&damping(&matrices), &damping(springs)) < 1e-6);
        assert!(difference(&critical(&matrices), &critical(springs)) < ROUND_OFF);
        assert!(difference(&meetings(&matrices), &meetings(springs)) < ROUND_OFF);
    }
}

#[test]
fn equilibrium_synchronous_response_and_step_limit_contain_connections() {
    let [matrices, springs @ ..] = forms(&heavy());
    for springs in &springs {
        for geometry in [Geometry::Live, Geometry::Frozen] {
            let rest = [&matrices, springs].map(|cached| equilibrium(cached, geometry, 100.0).unwrap());
            assert!(difference(rest[0].as_slice(), rest[1].as_slice()) < ROUND_OFF);
        }
        let response = [&matrices, springs].map(|cached| synchronous(cached, 100.0, ExcitationPart::Both).unwrap());
        assert!((&response[0] - &response[1]).norm() < ROUND_OFF * response[0].norm());
        let spectrum = [&matrices, springs].map(|cached| Spectrum::new(cached, 100.0).unwrap());
        assert!((spectrum[0].omega_max / spectrum[1].omega_max - 1.0).abs() < ROUND_OFF);
        // The norm that bounds a damping matrix is √2 times that of its two dampers.
        let ratio = spectrum[0].damping / spectrum[1].damping;
        assert!((1.0 - ROUND_OFF..1.5).contains(&ratio), "{ratio}");
    }
}

#[test]
fn diagnostics_name_the_connection_that_causes_round_off() {
    let stiff = with_springs(&train(), 1e19, 0.0);
    let message = ill_conditioning(&stiff, 100.0).unwrap().unwrap();
    assert!(message.ends_with("a spring of 1.000e19 N/m"), "{message}");
}

#[test]
fn runs_of_every_method_contain_connections() {
    for (method, step) in
        [(Method::Exponential, None), (Method::ExactRk4, Some(1e-6)), (Method::Rk45, None), (Method::Rk4, None)]
    {
        let [matrices, springs @ ..] = forms(&heavy()).map(|cached| run(&cached, &options(method, step)));
        for springs in &springs {
            let (a, b) = (&matrices.record, &springs.record);
            // The steps of adaptive methods may differ. The results agree to the tolerance.
            let tolerance = if method == Method::Exponential { 1e-6 } else { 1e-8 };
            assert!(difference(&a.displacement, &b.displacement) < tolerance, "{}", method.name());
            let energy = |response: &Response| -> Vec<f64> {
                response.record.energy.iter().map(|(energies, _)| energies.total()).collect()
            };
            assert!(difference(&energy(&matrices), &energy(springs)) < tolerance, "{}", method.name());
            let works = |response: &Response| -> Vec<f64> {
                response.record.energy.iter().map(|(_, works)| works.iter().sum::<f64>()).collect()
            };
            assert!(difference(&works(&matrices), &works(springs)) < 10.0 * tolerance, "{}", method.name());
        }
    }
}

/// The heavy train with backlash and tooth pairs in its first mesh, so that the linear motion excludes all connections.
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
fn connections_act_as_loads_if_the_linear_motion_excludes_the_meshes() {
    let [matrices, springs @ ..] = forms(&with_backlash());
    let expected = run(&matrices, &options(Method::Exponential, None));
    assert!(expected.statistics.events > 0);
    for springs in springs {
        assert!(springs.linear_without_meshes(100.0).unwrap().is_some());
        let found = run(&springs, &options(Method::Exponential, None));
        let gap = difference(&expected.record.displacement, &found.record.displacement);
        // Both results are accurate to their tolerance of 1e-6.
        assert!(gap < 1e-5, "{gap:e}");
        assert_eq!(expected.statistics.events, found.statistics.events);
    }
}

/// Largest difference between the sum of the works and the change of energy, relative to the initial energy.
fn imbalance(response: &Response) -> f64 {
    let first = response.record.energy[0].0.total();
    let left = |(energies, works): &(Energies, [f64; 6])| energies.total() - first - works.iter().sum::<f64>();
    response.record.energy.iter().map(left).fold(0.0_f64, |most, left| most.max(left.abs())) / first.abs()
}

#[test]
fn exponential_method_and_runge_kutta_agree_for_a_cubic_spring() {
    // At the equilibrium displacements of about 1e-5 m, the cubic term is one third of the force.
    let cached = with_springs(&heavy(), STIFFNESS, 3e17);
    let rest = equilibrium(&cached, Geometry::Live, 100.0).unwrap();
    let square = cached.model.springs[0].square(rest.as_slice());
    assert!(3e17 * square > 0.01 * STIFFNESS, "{square:e}");
    let exact = run(&cached, &options(Method::Rk45, None));
    for method in [Method::Exponential, Method::ExactRk4] {
        let step = matches!(method, Method::ExactRk4).then_some(1e-6);
        let found = run(&cached, &options(method, step));
        let gap = difference(&exact.record.displacement, &found.record.displacement);
        assert!(gap < 1e-5, "{}: {gap:e}", method.name());
    }
    assert!(imbalance(&exact) < 1e-6);
}

#[test]
fn the_tangent_of_a_spring_on_two_scalars_is_the_derivative_of_its_force() {
    let rows = vec![vec![(0, 1.0), (2, -1.0)], vec![(1, 1.0), (3, -1.0)]];
    let spring = Spring { rows, stiffness: 2.0, cubic: 3.0, damping: 0.0 };
    let q = [0.7, -0.4, 0.2, 0.5];
    let (force, tangent) = spring.static_tangent(&q);
    assert!(tangent[(0, 1)].abs() > 1.0 && tangent.determinant() > 1.0, "{tangent}");
    for k in 0..2 {
        let shifted = |by: f64| {
            let mut q = q;
            q[k] += by;
            spring.static_tangent(&q).0
        };
        // Central differences of a cubic polynomial err by h²k₃; round-off is ε/h.
        let slope = (shifted(1e-5) - shifted(-1e-5)) / 2e-5;
        assert!((slope - tangent.column(k)).norm() < 1e-8 * tangent.norm());
    }
    let mut out = [0.0; 4];
    spring.apply(&q, &[0.0; 4], &mut out);
    assert_eq!(out, [-force[0], -force[1], force[0], force[1]]);
}

#[test]
fn equilibrium_carries_gravity_by_a_hardening_spring_on_two_scalars() {
    // Gravity and torques press the shaft in both directions, so that the tangent has entries off the diagonal.
    for cubic in [3e17, 1e21] {
        let cached = with_isotropic_spring(&heavy(), STIFFNESS, cubic);
        let (model, spring) = (&cached.model, &cached.model.springs[0]);
        let q = equilibrium(&cached, Geometry::Frozen, 100.0).unwrap();
        let (_, tangent) = spring.static_tangent(q.as_slice());
        assert!(tangent[(0, 1)].abs() > 1e-3 * tangent[(0, 0)], "{tangent}");
        let meshes = model.connections(100.0).filter(|connection| matches!(connection, Connection::Mesh(..)));
        let mut left = &model.constant_load - model.static_force(&q);
        for mesh in meshes {
            let (rows, stiffness) = (mesh.rows(), mesh.linear(100.0).stiffness[(0, 0)]);
            let deflection: f64 = rows[0].iter().map(|(index, factor)| factor * q[*index]).sum();
            rows[0].iter().for_each(|(index, factor)| left[*index] -= factor * stiffness * deflection);
        }
        spring.apply(q.as_slice(), &vec![0.0; model.len()], left.as_mut_slice());
        assert!(left.norm() < 1e-9 * model.constant_load.norm(), "{:e}", left.norm());
    }
}

/// Options of a short run with a tight tolerance.
fn tight(method: Method) -> Options {
    Options {
        duration: 5e-3,
        times: (0..=5).map(|k| f64::from(k) * 1e-3).collect(),
        rtol: matches!(method, Method::Exponential | Method::Rk45).then_some(1e-11),
        ..options(method, matches!(method, Method::ExactRk4 | Method::Rk4).then_some(1e-6))
    }
}

#[test]
fn every_method_agrees_for_a_hardening_spring_on_two_scalars() {
    let mut damped = heavy();
    // With modal damping, Runge–Kutta methods also integrate in modes.
    damped.modal_damping = Some(0.01);
    // With backlash, the linear motion excludes stiffness and damping of the spring.
    for system in [heavy(), damped, with_backlash()] {
        let cached = with_isotropic_spring(&system, STIFFNESS, 3e17);
        let exact = run(&cached, &tight(Method::Rk45));
        assert!(imbalance(&exact) < 1e-6);
        // The step of rk4 is near its stability limit, so that its fast modes are less accurate.
        for (method, tolerance) in [(Method::Exponential, 1e-8), (Method::ExactRk4, 1e-8), (Method::Rk4, 1e-6)] {
            let found = run(&cached, &tight(method));
            let gap = difference(&exact.record.displacement, &found.record.displacement);
            assert!(gap < tolerance, "{}: {gap:e}", method.name());
            assert!(imbalance(&found) < 1e-6);
        }
    }
}

#[test]
fn a_spring_between_two_shafts_acts_on_both() {
    let other = model(&heavy());
    let other = other.numbering.translation(other.scene.bearings[4].node).unwrap();
    let rows = |v: usize| {
        let between = |lane: usize| vec![(v + lane, 1.0), (other + lane, -1.0)];
        vec![vec![vec![(v, 1.0)], vec![(v + 1, 1.0)]], vec![between(0), between(1)]]
    };
    let cached = without_bearing(&heavy(), rows, STIFFNESS, 3e17);
    let [exact, found] = [Method::Rk45, Method::Exponential].map(|method| run(&cached, &tight(method)));
    let gap = difference(&exact.record.displacement, &found.record.displacement);
    assert!(gap < 1e-8, "{gap:e}");
    assert!(imbalance(&found) < 1e-6);
}

#[test]
fn the_full_tangent_saves_iterations_of_stiff_hardening_springs() {
    let cached = with_isotropic_spring(&heavy(), 1e7, 1e20);
    let q = equilibrium(&cached, Geometry::Live, 100.0).unwrap();
    // The cubic term is a hundred times the linear one.
    assert!(1e20 * cached.model.springs[0].square(q.as_slice()) > 50.0 * 1e7);
    let Statistics { steps, rejected, evaluations, .. } = run(&cached, &options(Method::Exponential, None)).statistics;
    // A step evaluates three stages in each iteration, and its end.
    let iterations = (evaluations as f64 / (steps + rejected) as f64 - 1.0) / 3.0;
    // One iteration is the least. Only the diagonal of the tangent needs 1.6, no tangent 2.4.
    assert!(iterations < 1.3, "{iterations}");
}
