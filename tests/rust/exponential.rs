//! The modal form of the linear motion, the step propagators, and interpolation within a step.

use std::sync::Arc;

use crate::common::{Noise, cached, everything, largest, motion, train};
use gearbow::analysis::equilibrium;
use gearbow::exponential::{
    InterfaceMaps, LevelControl, Loads, OutputMap, PropagatorCache, PropagatorKey, QuadratureRule, Selection, Stepper,
    TimeGrid, run,
};
use gearbow::integrate::{Halt, Observer, State, Statistics, Trajectory};
use gearbow::mesh::Geometry;
use gearbow::modal::{CachedModel, ModalStateSpace};
use gearbow::scene::SceneDescription;
use gearbow::scene::description::{Coefficient, Stiffness, StiffnessKind, StiffnessModel};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

const SPEED: f64 = 100.0;

/// A small train with all damping models.
fn damped(bearing: [f64; 4], cross: [f64; 2], rayleigh: [f64; 2], modal: f64) -> SceneDescription {
    let mut system = train();
    system.shafts.iter_mut().for_each(|shaft| shaft.elements = Some(2));
    let [k_y, k_z, c_y, c_z] = bearing;
    for bearing in &mut system.bearings {
        bearing.stiffness = Some(Coefficient::Full([[k_y, cross[0]], [-cross[1], k_z]]).into());
        bearing.damping = Some(Coefficient::Full([[c_y, 0.0], [0.0, c_z]]).into());
    }
    system.rayleigh = Some(rayleigh);
    system.modal_damping = Some(modal.into());
    system
}

/// Checks that the transformation to z and back is the identity, and that ż = A z is the equation of motion.
fn obeys(cached: &CachedModel, speed: f64, seed: u64) -> Result<(), TestCaseError> {
    let (stiffness, damping) = (cached.model.stiffness_matrix(speed), cached.damping_matrix(speed).unwrap());
    moves_by(&cached.linear(speed).unwrap(), cached, (stiffness, damping), speed, seed)
}

/// The same check for a linear motion with the matrices K and C.
fn moves_by(
    linear: &ModalStateSpace,
    cached: &CachedModel,
    (stiffness, damping): (DMatrix<f64>, DMatrix<f64>),
    speed: f64,
    seed: u64,
) -> Result<(), TestCaseError> {
    let model = &cached.model;
    let n = model.len();
    let mut noise = Noise::new(seed);
    let (q, v) = (noise.vector(n, 1e-6), noise.vector(n, 1e-2));
    let z = linear.state(&cached.model, &q, &v);
    let (q_back, v_back) = linear.motion(z.as_slice());
    let (q, v) = (DVector::from_vec(q), DVector::from_vec(v));
    // Round-off of a product of eigenvectors, multiplied by their condition number.
    let loss = 1e-11 * linear.condition;
    prop_assert!((&q_back - &q).amax() < loss * q.amax(), "{:e}", (&q_back - &q).amax());
    prop_assert!((&v_back - &v).amax() < loss * v.amax(), "{:e}", (&v_back - &v).amax());

    let mut rate = vec![0.0; linear.len()];
    linear.multiply(z.as_slice(), &mut rate);
    let (velocity, acceleration) = linear.motion(&rate);
    let inertia = model.mass_matrix() * acceleration;
    let elastic = stiffness * &q;
    let viscous = (damping + model.gyroscopic_matrix() * speed) * &v;
    let scale = elastic.amax().max(viscous.amax());
    prop_assert!((inertia + elastic + viscous).amax() < loss * scale);
    // The velocity is at most the spectral radius times the displacement.
    prop_assert!((velocity - &v).amax() < loss * (v.amax() + linear.radius * q.amax()));
    Ok(())
}

proptest! {
    #![proptest_config(crate::common::cases(24))]

    #[test]
    fn modes_at_speed_are_the_equation_of_motion(
        bearing in (1e6..1e9_f64, 1e6..1e9_f64, 0.0..1e5_f64, 0.0..1e5_f64),
        cross in (0.0..1e6_f64, 0.0..1e6_f64),
        rayleigh in (0.0..100.0_f64, 0.0..1e-6_f64),
        modal in 0.0..0.2_f64,
        speed in -500.0..500.0_f64,
        seed in 0..1000_u64,
    ) {
        let bearing = [bearing.0, bearing.1, bearing.2, bearing.3];
        let system = damped(bearing, [cross.0, cross.1], [rayleigh.0, rayleigh.1], modal);
        obeys(&cached(&system), speed, seed)?;
    }

    #[test]
    fn parts_move_as_shafts_without_meshes(
        bearing in (1e6..1e9_f64, 1e6..1e9_f64, 0.0..1e5_f64, 0.0..1e5_f64),
        cross in (0.0..1e6_f64, 0.0..1e6_f64),
        rayleigh in (0.0..100.0_f64, 0.0..1e-6_f64),
        speed in -500.0..500.0_f64,
        seed in 0..1000_u64,
    ) {
        let bearing = [bearing.0, bearing.1, bearing.2, bearing.3];
        let cached = cached(&damped(bearing, [cross.0, cross.1], [rayleigh.0, rayleigh.1], 0.0));
        let model = &cached.model;
        // If bearing damping makes two eigenvalues nearly equal, no modal form is available.
        let Some(linear) = cached.linear_without_meshes(speed).unwrap() else {
            return Ok(());
        };
        let stiffness = model.shaft_stiffness_matrix() + model.support_stiffness_matrix();
        moves_by(&linear, &cached, (stiffness, model.damping_matrix_without_meshes()), speed, seed)?;
        // Bending of one shaft affects neither the other shafts nor its own twist.
        let parts: Vec<_> = model.numbering.uncoupled_parts().collect();
        prop_assert_eq!(linear.parts.len(), parts.len());
        for (own, dofs) in linear.parts.iter().zip(parts) {
            let rows = [linear.row(&[(dofs.start, 1.0)], false), linear.row(&[(dofs.start, 1.0)], true)];
            for vector in rows.iter().chain([&linear.column(&[(dofs.start, 1.0)])]) {
                let outside = |slot: &usize| !own.contains(&(slot % linear.slots));
                prop_assert!((0..vector.len()).filter(outside).all(|at| vector[at] == 0.0));
            }
        }
    }
}

#[test]
fn slowly_decaying_rigid_body_rotation_keeps_its_accuracy() {
    // The train rotates freely. Mass-proportional damping decelerates it at its own rate.
    for rate in [1e-9, 1e-6, 1e-3, 0.17, 10.0, 1e3] {
        let cached = cached(&damped([1e6, 1.17e8, 0.0, 0.0], [0.0; 2], [rate, 0.0], 0.0));
        let linear = cached.linear(0.0).unwrap();
        assert!(linear.condition < 10.0, "{rate}: {}", linear.condition);
        for seed in 0..8 {
            obeys(&cached, 0.0, seed).unwrap();
        }
    }
}

#[test]
fn uncoupled_planes_of_bending_have_well_conditioned_modes() {
    // At zero speed the two bending planes of a shaft have the same eigenvalues.
    for damping in [0.0, 10.0, 500.0, 501.0, 5e3, 1e5] {
        let mut system = damped([1e8, 1e8, damping, damping], [0.0; 2], [0.0; 2], 0.0);
        system.shafts.truncate(1);
        system.gears.retain(|gear| gear.shaft == "input");
        system.bearings.retain(|bearing| bearing.shaft == "input");
        system.meshes.clear();
        system.torques.clear();
        let cached = cached(&system);
        obeys(&cached, 0.0, 3).unwrap();
        obeys(&cached, 1e-9, 4).unwrap();
    }
}

#[test]
fn equal_modes_of_coupled_planes_carry_the_motion() {
    // Shafts of equal sections have repeated modes at zero speed and nearly repeated modes at low speed. The meshes
    // couple the planes.
    for elements in [4, 6, 8] {
        for speed in [0.0, 1e-3, 100.0] {
            let mut system = train();
            system.shafts.iter_mut().for_each(|shaft| shaft.elements = Some(elements));
            system.rayleigh = Some([20.0, 1e-5]);
            let cached = cached(&system);
            let linear = cached.linear(speed).unwrap();
            assert!(linear.condition < 100.0, "{elements} {speed}: {:e}", linear.condition);
            obeys(&cached, speed, 5).unwrap();
        }
    }
}

/// Nonlinear loads and interface maps for a linear motion.
fn field<'m>(cached: &'m CachedModel, geometry: Geometry, linear: &ModalStateSpace) -> (Loads<'m>, InterfaceMaps) {
    let reference = equilibrium(cached, geometry, SPEED).unwrap();
    let motion = motion(cached, geometry, SPEED, 0.0);
    let mut amplitudes = DMatrix::zeros(cached.model.len(), motion.sources().len());
    for (column, source) in motion.sources().iter().enumerate() {
        amplitudes.set_column(column, &linear.synchronous(source.spin, &source.columns()).unwrap());
    }
    Loads::new(motion, linear, reference, &amplitudes).unwrap()
}

/// The matrix A of a linear motion.
fn matrix(linear: &ModalStateSpace) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(linear.len(), linear.len());
    for entry in 0..linear.len() {
        let unit = DVector::from_fn(linear.len(), |k, _| if k == entry { 1.0 } else { 0.0 });
        linear.multiply(unit.as_slice(), matrix.column_mut(entry).as_mut_slice());
    }
    matrix
}

/// Largest difference divided by the largest value.
fn apart(first: &[f64], second: &[f64]) -> f64 {
    assert_eq!(first.len(), second.len());
    let difference: Vec<f64> = first.iter().zip(second).map(|(a, b)| a - b).collect();
    largest(&difference) / largest(first).max(f64::MIN_POSITIVE)
}

/// The propagators of a linear motion with a rule and the loads of `field`.
fn propagators(
    linear: &Arc<ModalStateSpace>,
    rule: &QuadratureRule,
    maps: &InterfaceMaps,
    time_grid: TimeGrid,
    field: &Loads<'_>,
) -> PropagatorCache {
    let (linear, rule, maps, spins) = (Arc::clone(linear), rule.clone(), maps.clone(), field.spins());
    PropagatorCache::new(Arc::new(PropagatorKey { linear, rule, maps, time_grid, spins }))
}

#[test]
fn propagators_are_matrix_exponentials() {
    for (system, geometry) in [(train(), Geometry::Live), (everything(), Geometry::Frozen)] {
        let cached = cached(&system);
        let linear = cached.linear(SPEED).unwrap();
        let (a, len) = (matrix(&linear), linear.len());
        let (field, maps) = field(&cached, geometry, &linear);
        let time_grid = TimeGrid { longest: 1e-4, finest: 8, substep: 8 };
        let arch = pulp::Arch::new();
        let table = |stages| propagators(&linear, &QuadratureRule::gauss(stages), &maps, time_grid, &field);
        let tables: Vec<_> = (1..=4).map(|stages| (stages, table(stages))).collect();
        for level in [0, 4, 8] {
            let step = time_grid.step(level);
            // Repeated squaring of a matrix exponential loses the digits of its angle ω h.
            let closeness = 1e-13 * (step * linear.radius).max(10.0);
            for load in 0..field.load_count() {
                // With a constant load b, the last column of the exponential of [[A, b], [0, 0]] h is h φ_1(Ah) b.
                let mut augmented = DMatrix::zeros(len + 1, len + 1);
                augmented.view_mut((0, 0), (len, len)).copy_from(&(&a * step));
                let b = DVector::from_column_slice(&maps.columns[load]) * step;
                augmented.view_mut((0, len), (len, 1)).copy_from(&b);
                let exact = augmented.exp();
                for (stages, table) in &tables {
                    for (z, value) in [(Noise::new(5).vector(len, 1e-3), 0.0), (vec![0.0; len], 1.0)] {
                        let mut loads = vec![0.0; stages * field.load_count()];
                        loads.iter_mut().skip(load).step_by(field.load_count()).for_each(|p| *p = value);
                        let mut after = vec![0.0; len];
                        table.propagator(level).advance(arch, &loads, &z, &mut after);
                        let wanted = &exact * DVector::from_fn(len + 1, |k, _| if k < len { z[k] } else { value });
                        let gap = apart(&wanted.as_slice()[..len], &after);
                        assert!(gap < closeness, "{stages} stages, level {level}, load {load}, {value}: {gap:e}");
                    }
                }
            }
        }
    }
}

/// Compares the motion at both ends of every step with the motion just inside them.
#[derive(Default)]
struct Edges {
    coordinates: Vec<usize>,
    last: Option<Vec<f64>>,
    inside: f64,
    between: f64,
    steps: u32,
}

impl Observer for Edges {
    fn next(&self) -> Option<f64> {
        None
    }

    fn sees_every_step(&self) -> bool {
        true
    }

    fn observe(&mut self, motion: &mut impl Trajectory, end: f64) -> Result<(), Halt> {
        let (begin, n) = (motion.begin(), self.coordinates.len());
        let mut look = |at: f64| {
            let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
            motion.states(&[at], &self.coordinates, &mut q, &mut v);
            (q, v)
        };
        let near = 1e-7 * (end - begin);
        for (inside, edge) in [(begin + near, begin), (end - near, end)] {
            let ((q, _), (at, rate)) = (look(inside), look(edge));
            let carried: Vec<f64> = at.iter().zip(&rate).map(|(at, rate)| at + rate * (inside - edge)).collect();
            self.inside = self.inside.max(apart(&carried, &q));
        }
        let first = look(begin).0;
        if let Some(last) = self.last.replace(look(end).0) {
            self.between = self.between.max(apart(&last, &first));
        }
        self.steps += 1;
        Ok(())
    }

    fn continues(&mut self, _: f64) -> bool {
        true
    }
}

/// Stores displacements and velocities at the end of the last step.
struct Last(Vec<f64>);

impl Observer for Last {
    fn next(&self) -> Option<f64> {
        None
    }

    fn sees_every_step(&self) -> bool {
        true
    }

    fn observe(&mut self, motion: &mut impl Trajectory, end: f64) -> Result<(), Halt> {
        let n = self.0.len() / 2;
        let (q, v) = self.0.split_at_mut(n);
        motion.states(&[end], &(0..n).collect::<Vec<_>>(), q, v);
        Ok(())
    }

    fn continues(&mut self, _: f64) -> bool {
        true
    }
}

/// The steady motion of a train without its time-varying mesh forces, plus a disturbance.
fn disturbed(cached: &CachedModel, geometry: Geometry) -> [DVector<f64>; 2] {
    let (q, v) = field(cached, geometry, &cached.linear(SPEED).unwrap()).0.reference_motion(0.0);
    let noise = Noise::new(8).vector(q.len(), 1e-7);
    [q + DVector::from_vec(noise), v]
}

/// Integrates a disturbed train in parts that end at `ends`, with the form `form` of its linear motion.
fn integrate(
    (cached, geometry): (&CachedModel, Geometry),
    form: &ModalStateSpace,
    stages: usize,
    ends: &[f64],
    edges: &mut impl Observer,
) -> State {
    let n = cached.model.len();
    let (field, maps) = field(cached, geometry, form);
    let longest = 5e-5;
    let substep = (longest * form.radius.min(1e6) / 0.8).log2().ceil() as usize;
    let time_grid = TimeGrid { longest, finest: substep + 4, substep };
    let selection = Selection { displacements: (0..n).collect(), velocities: (0..n).collect(), ..Selection::default() };
    let mut output = OutputMap::new(&field, form, &maps, selection);
    let table = propagators(&Arc::new(form.clone()), &QuadratureRule::gauss(stages), &maps, time_grid, &field);
    let (carried, turning) = field.reference_motion(0.0);
    let [q, v] = disturbed(cached, geometry);
    let z = form.state(&cached.model, (q - carried).as_slice(), (v - turning).as_slice());
    let mut state = State::new(z.as_slice().to_vec());
    let mut stepper = Stepper::new(field, table.into());
    let control = LevelControl::Adaptive { rtol: 1e-9, floor: 1e-12, force_error: None };
    let mut statistics = Statistics::new();
    for end in ends {
        run(&mut stepper, &mut output, control.clone(), &mut state, *end, edges, &mut statistics).unwrap();
    }
    state
}

/// A train whose mesh stiffness jumps.
fn sharp() -> SceneDescription {
    let mut system = train();
    let square = StiffnessModel::of(StiffnessKind::Square);
    for mesh in &mut system.meshes {
        mesh.stiffness = Some(Stiffness::Model(StiffnessModel { mean: Some(2e8), engagement: None, ..square.clone() }));
    }
    system
}

#[test]
fn runs_with_and_without_meshes_in_the_linear_motion_are_equal() {
    let (mut apart_by_backlash, mut damped) = (sharp(), train());
    apart_by_backlash.meshes.iter_mut().for_each(|mesh| mesh.backlash = Some(1e-5));
    damped.meshes.iter_mut().for_each(|mesh| (mesh.damping, mesh.damping_ratio) = (Some(800.0), None));
    for (name, system) in [("mean", train()), ("sharp", sharp()), ("backlash", apart_by_backlash), ("damped", damped)] {
        for geometry in [Geometry::Live, Geometry::Frozen] {
            let cached = cached(&system);
            let linear = cached.linear(SPEED).unwrap();
            let motion = |form: &ModalStateSpace, ends: &[f64]| {
                let mut last = Last(vec![0.0; 2 * cached.model.len()]);
                integrate((&cached, geometry), form, 3, ends, &mut last);
                last.0
            };
            let of_modes = motion(&linear, &[2e-3]);
            assert_eq!(motion(&linear, &[8.3e-4, 2e-3]), of_modes, "{name}, {geometry:?}");
            let shafts = cached.linear_without_meshes(SPEED).unwrap().unwrap();
            let gap = apart(&of_modes, &motion(&shafts, &[2e-3]));
            // Without the meshes every step also adds an error to the mesh oscillation, and event times are accurate to
            // 1e-6. Contact amplifies the difference: 1.3e-5 with backlash, which decreases to 1e-6 at a tolerance of 1e-12.
            assert!(gap < 3e-5, "{name}, {geometry:?}, in parts: {gap:e}");
            assert_eq!(motion(&shafts, &[8.3e-4, 2e-3]), motion(&shafts, &[2e-3]), "{name}, {geometry:?}");
        }
    }
}

#[test]
fn interpolation_within_a_step_matches_both_ends() {
    let cached = cached(&sharp());
    let linear = cached.linear(SPEED).unwrap();
    for stages in 2..=4 {
        let n = cached.model.len();
        let mut edges = Edges { coordinates: (0..n).collect(), ..Edges::default() };
        integrate((&cached, Geometry::Live), &linear, stages, &[2e-3], &mut edges);
        assert!(edges.steps > 40);
        // Interpolation within a step uses other propagators than the full step. Its loads differ by less than the
        // tolerance. The linear extrapolation from the end has the smaller error (1e-7 ω h)².
        assert!(edges.inside < 1e-9, "{stages} {:e}", edges.inside);
        // Without a contact change, the end of a step equals the beginning of the next bit by bit. With a contact
        // change, both agree to the tolerance.
        assert!(edges.between < 1e-9, "{stages} {:e}", edges.between);
    }
}
