//! The modal form of the linear motion, the step propagators, and interpolation within a step.

use std::sync::Arc;

use crate::common::{Noise, cached, everything, largest, motion, train};
use gearbow::analysis::{ExcitationPart, equilibrium, synchronous};
use gearbow::exponential::{
    InterfaceMaps, LevelControl, Loads, OutputMap, PropagatorCache, PropagatorKey, QuadratureRule, Selection, Stepper,
    TimeGrid, run,
};
use gearbow::integrate::{Halt, Observer, State, Statistics, Trajectory};
use gearbow::mesh::Geometry;
use gearbow::modal::{CachedModel, ModalStateSpace, StateMatrix};
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
    system.modal_damping = Some(modal);
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
    let mut amplitudes = synchronous(cached, SPEED, ExcitationPart::Both).unwrap();
    if !linear.includes_meshes {
        for source in motion.sources() {
            let amplitude = linear.synchronous(source.spin, &source.columns());
            amplitudes.set_column(source.shaft, &amplitude.unwrap());
        }
    }
    Loads::new(motion, linear, reference, &amplitudes).unwrap()
}

/// The same linear motion in dense form.
fn dense(linear: &ModalStateSpace) -> ModalStateSpace {
    let [a, b, c, d] = &linear.blocks;
    let slots = linear.slots;
    let mut matrix = DMatrix::zeros(2 * slots, 2 * slots);
    for slot in 0..slots {
        (matrix[(slot, slot)], matrix[(slot, slots + slot)]) = (a[slot], b[slot]);
        (matrix[(slots + slot, slot)], matrix[(slots + slot, slots + slot)]) = (c[slot], d[slot]);
    }
    let mut same = linear.clone();
    same.matrix = StateMatrix::Dense(matrix);
    same
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
fn dense_propagators_equal_modal_propagators() {
    for (system, geometry) in [(train(), Geometry::Live), (everything(), Geometry::Frozen)] {
        let cached = cached(&system);
        let linear = cached.linear(SPEED).unwrap();
        let whole = Arc::new(dense(&linear));
        for stages in 1..=4 {
            let (field, maps) = field(&cached, geometry, &linear);
            let longest = 1e-4;
            let finest = (longest * linear.radius).log2().ceil() as usize + 1;
            let time_grid = TimeGrid { longest, finest, event: finest };
            let rule = QuadratureRule::gauss(stages);
            let pairs = propagators(&linear, &rule, &maps, time_grid, &field);
            let matrices = propagators(&whole, &rule, &maps, time_grid, &field);
            let mut z = vec![0.0; linear.len()];
            let noise = linear.state(
                &cached.model,
                &Noise::new(5).vector(cached.model.len(), 1e-6),
                &vec![0.0; cached.model.len()],
            );
            z.copy_from_slice(noise.as_slice());
            let arch = pulp::Arch::new();
            let p = vec![0.0; stages * field.load_count()];
            for level in 0..=time_grid.finest {
                let (a, b) = (pairs.propagator(level), matrices.propagator(level));
                let (seen_a, seen_b) = (pairs.stage_response(level), matrices.stage_response(level));
                let responses = |table: &PropagatorCache| -> Vec<f64> {
                    table.stage_response(level).response.iter().flat_map(|panel| panel.values.iter().copied()).collect()
                };
                let mut after = [vec![0.0; z.len()], vec![0.0; z.len()]];
                a.advance(arch, &p, &z, &mut after[0]);
                b.advance(arch, &p, &z, &mut after[1]);
                // Repeated squaring of a matrix exponential loses only the digits of its angle ω h. The error estimate
                // uses the integral of a polynomial that nearly vanishes.
                let closeness = 1e-13 * (time_grid.step(level) * linear.radius).max(10.0);
                for (what, gap, closeness) in [
                    ("transition", apart(&after[0], &after[1]), closeness),
                    ("columns", apart(&a.columns.values, &b.columns.values), closeness),
                    ("rows", apart(&seen_a.rows.values, &seen_b.rows.values), closeness),
                    ("response", apart(&responses(&pairs), &responses(&matrices)), closeness),
                    ("gram", apart(&a.gram.values, &b.gram.values), 1e-6),
                ] {
                    assert!(gap < closeness, "{stages} stages, level {level}, {what}: {gap:e}");
                }
                assert_eq!(seen_a.phasors, seen_b.phasors);
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
    let event = (longest * form.radius.min(1e6) / 0.8).log2().ceil() as usize;
    let time_grid = TimeGrid { longest, finest: event + 4, event };
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
fn modal_and_dense_runs_are_equal() {
    let (mut apart_by_backlash, mut damped) = (sharp(), train());
    apart_by_backlash.meshes.iter_mut().for_each(|mesh| mesh.backlash = Some(1e-5));
    damped.meshes.iter_mut().for_each(|mesh| (mesh.damping, mesh.damping_ratio) = (Some(800.0), None));
    for (name, system) in [("mean", train()), ("sharp", sharp()), ("backlash", apart_by_backlash), ("damped", damped)] {
        for geometry in [Geometry::Live, Geometry::Frozen] {
            let cached = cached(&system);
            let linear = cached.linear(SPEED).unwrap();
            let mut whole = dense(&linear);
            // The matrix norm overestimates the spectral radius.
            whole.radius = linear.radius;
            let motion = |form: &ModalStateSpace, ends: &[f64]| {
                let mut last = Last(vec![0.0; 2 * cached.model.len()]);
                integrate((&cached, geometry), form, 3, ends, &mut last);
                last.0
            };
            let (of_modes, without) = (motion(&linear, &[2e-3]), motion(&whole, &[2e-3]));
            let gap = apart(&of_modes, &without);
            // The tolerance is 1e-9; contact amplifies the difference.
            assert!(gap < 1e-7, "{name}, {geometry:?}: {gap:e}");
            assert_eq!(motion(&whole, &[8.3e-4, 2e-3]), without, "{name}, {geometry:?}");
            // The result is also the same if the linear motion excludes the meshes.
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
    for (stages, form) in [(2, (*linear).clone()), (3, (*linear).clone()), (4, (*linear).clone()), (3, dense(&linear))]
    {
        let n = cached.model.len();
        let mut edges = Edges { coordinates: (0..n).collect(), ..Edges::default() };
        integrate((&cached, Geometry::Live), &form, stages, &[2e-3], &mut edges);
        assert!(edges.steps > 40);
        // Interpolation within a step uses other propagators than the full step. Its loads differ by less than the
        // tolerance. The linear extrapolation from the end has the smaller error (1e-7 ω h)².
        assert!(edges.inside < 1e-9, "{stages} {:e}", edges.inside);
        // Without a contact change, the end of a step equals the beginning of the next bit by bit. With a contact
        // change, both agree to the tolerance.
        assert!(edges.between < 1e-9, "{stages} {:e}", edges.between);
    }
}
