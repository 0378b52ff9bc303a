//! The equation of motion against its dense matrices, and what it must conserve.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{Noise, basis, free_train, largest, train};
use gearbow::analysis::Spectrum;
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{Adaptive, Control, Halt, Observer, RungeKutta, Span, State, Statistics, System as _, run};
use gearbow::mesh::Geometry;
use gearbow::modal::Basis;
use gearbow::motion::{Motion, phase};
use gearbow::scene::description::{Bow, BowShape, Coefficient, Gravity};
use gearbow::scene::{Node, System};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

/// Asks for nothing.
struct Nobody;

impl Observer for Nobody {
    fn next(&self) -> Option<f64> {
        None
    }

    fn observe(&mut self, _: &Span<'_>, _: f64) -> Result<(), Halt> {
        Ok(())
    }

    fn go_on(&mut self, _: f64) -> bool {
        true
    }
}

fn motion(basis: &Basis, geometry: Geometry, speed: f64, origin: f64) -> Motion<'_> {
    Motion::new(basis, geometry, speed, origin, DVector::zeros(basis.model.len())).unwrap()
}

fn integrate<const S: usize>(motion: &mut Motion<'_>, tableau: Tableau<S>, control: Control, y: Vec<f64>, end: f64) -> State {
    let (mut method, mut state) = (RungeKutta::new(tableau, y.len()), State::new(y));
    run(motion, &mut method, &control, &mut state, end, &mut Nobody, &mut Statistics::new()).unwrap();
    state
}

/// A train with everything that a scene can have: cross-coupled bearings, gravity, both dampings, a tilted bow.
fn everything() -> System {
    let mut system = train();
    system.bearings[1].stiffness = Coefficient::Full([[1e8, 3e6], [-2e6, 7e7]]);
    system.bearings[1].damping = Some(Coefficient::Full([[500.0, -80.0], [60.0, 300.0]]));
    system.gravity = Some(Gravity::Vector([1.0, -9.0]));
    system.rayleigh = Some([20.0, 1e-6]);
    system.modal_damping = Some(0.01);
    system.gears[3].unbalance = Some(gearbow::scene::description::Complex::Pair([0.0, 2e-4]));
    system.shafts[2].bow = Some(points(vec![0.0, 0.2, 0.5], |x| Complex64::new(1e-4 + 3e-3 * x * x, -1e-3 * x)));
    system
}

fn points(positions: Vec<f64>, curve: impl Fn(f64) -> Complex64) -> Bow {
    let values: Vec<_> = positions.iter().map(|x| curve(*x)).collect();
    Bow {
        shape: BowShape::Points,
        amplitude: None,
        phase: None,
        number: None,
        amplitudes: Some(values.iter().map(|value| value.norm()).collect()),
        phases: Some(values.iter().map(|value| value.arg()).collect()),
        positions: Some(positions),
    }
}

/// The load of bow, unbalance, torque and gravity, from their definitions.
fn load(basis: &Basis, speed: f64, time: f64) -> DVector<f64> {
    let model = &basis.model;
    let turn = |shaft: usize| Complex64::from_polar(1.0, model.scene.speed_ratios[shaft] * speed * time);
    let mut bent = DVector::zeros(model.len());
    for (index, shaft) in model.shafts.iter().enumerate() {
        let start = model.numbering.lateral(index).unwrap();
        for (i, value) in shaft.bow.iter().flatten().enumerate() {
            let turned = value * turn(index);
            bent[start + 2 * i] = turned.re;
            bent[start + 2 * i + 1] = turned.im;
        }
    }
    let mut force = model.shaft_stiffness_matrix() * bent;
    for body in model.scene.bodies() {
        let spin = model.scene.speed_ratios[body.node.shaft] * speed;
        let turned = body.unbalance * turn(body.node.shaft) * (spin * spin);
        let index = model.numbering.translation(body.node).unwrap();
        force[index] += turned.re;
        force[index + 1] += turned.im;
    }
    for torque in &model.scene.torques {
        force[model.numbering.twist(torque.node).unwrap()] += torque.value;
    }
    let mut falling = DVector::zeros(model.len());
    for (shaft, given) in model.scene.shafts.iter().enumerate() {
        for node in 0..given.nodes.len() {
            let index = model.numbering.translation(Node { shaft, node }).unwrap();
            falling[index] = model.scene.gravity[0];
            falling[index + 1] = model.scene.gravity[1];
        }
    }
    force + model.mass_matrix() * falling
}

#[test]
fn derivative_is_that_of_the_dense_matrices() {
    for (system, speed) in [(everything(), 310.0), (everything(), -70.0), (train(), 100.0), (free_train(), 0.0)] {
        let basis = basis(&system);
        let model = &basis.model;
        let (mass, stiffness) = (model.mass_matrix(), model.stiffness_matrix(speed));
        let rate = basis.damping_matrix(speed).unwrap() + model.gyroscopic_matrix() * speed;
        let mut noise = Noise::new(11);
        let n = model.len();
        let (origin, elapsed) = (0.3, 0.02);
        let force = load(&basis, speed, origin + elapsed);
        for _ in 0..5 {
            let y = [noise.vector(n, 1e-4), noise.vector(n, 0.1)].concat();
            let mut derivative = vec![0.0; 2 * n];
            motion(&basis, Geometry::Frozen, speed, origin).derivative(elapsed, &y, &mut derivative).unwrap();
            assert_eq!(derivative[..n], y[n..]);
            let [q, v, a] = [&y[..n], &y[n..], &derivative[n..]].map(DVector::from_column_slice);
            let residual = &mass * &a + &rate * &v + &stiffness * &q - &force;
            let acting =
                mass.abs() * a.abs() + rate.abs() * v.abs() + stiffness.abs() * q.abs() + force.abs();
            // Backward error, row by row: sums of twenty terms, and the factor of a mass of condition 1e3.
            let worst = residual.abs().component_div(&acting).max();
            assert!(worst < 1e-12, "{worst:e} at {speed} rad/s");
        }
    }
}

#[test]
fn rayleigh_damping_is_that_of_the_shafts_alone() {
    let mut system = free_train();
    let [alpha, beta] = [20.0, 1e-6];
    system.rayleigh = Some([alpha, beta]);
    let damping = common::model(&system).damping_matrix(0.0);
    for gear in &mut system.gears {
        (gear.mass, gear.diametral_inertia, gear.polar_inertia) = (Some(0.0), Some(0.0), Some(0.0));
    }
    let bare = common::model(&system);
    let expected = bare.mass_matrix() * alpha + bare.shaft_stiffness_matrix() * beta;
    // Two products and a sum an entry.
    assert!((damping - &expected).amax() < 1e-14 * expected.amax());
}

#[test]
fn live_differs_from_frozen_by_the_force_of_the_meshes() {
    let basis = basis(&everything());
    let (model, speed) = (&basis.model, 200.0);
    let n = model.len();
    let mut noise = Noise::new(5);
    let y = [noise.vector(n, 2e-4), noise.vector(n, 0.1)].concat();
    let (q, v) = y.split_at(n);
    let mut accelerations = Vec::new();
    let mut forces = Vec::new();
    for geometry in [Geometry::Live, Geometry::Frozen] {
        let mut derivative = vec![0.0; 2 * n];
        motion(&basis, geometry, speed, 0.0).derivative(0.1, &y, &mut derivative).unwrap();
        accelerations.push(DVector::from_column_slice(&derivative[n..]));
        let mut force = vec![0.0; n];
        for (index, mesh) in model.meshes.iter().enumerate() {
            let sigma = model.sigma(index, speed);
            let contact = mesh.contact(geometry, sigma, q, v).unwrap();
            mesh.apply(sigma, contact.force, contact.normal, &mut force);
        }
        forces.push(DVector::from_vec(force));
    }
    let found = model.mass_matrix() * (&accelerations[0] - &accelerations[1]);
    let expected = &forces[0] - &forces[1];
    assert!(expected.amax() > 1e-4 * forces[0].amax(), "the test sees the difference");
    // The difference of accelerations that the stiff shafts dominate.
    let acting = (model.mass_matrix().abs() * accelerations[0].abs()).amax();
    assert!((found - expected).amax() < 1e-13 * acting);
}

/// A state of slow motions alone: the lowest elastic modes, none of which a small step fails to resolve.
fn slow(basis: &Basis, size: f64) -> Vec<f64> {
    let real = basis.real_modes(0.0).unwrap();
    let mut q = DVector::zeros(basis.model.len());
    for mode in real.null..real.null + 12 {
        let shape = real.vectors.column(mode);
        q += shape * (size / shape.amax());
    }
    [q.as_slice(), &vec![0.0; basis.model.len()]].concat()
}

#[test]
fn an_undamped_free_motion_conserves_energy_with_the_order_of_the_method() {
    // Few elements, so that steps can be long enough for their error to stand above round-off.
    let mut system = free_train();
    system.shafts.iter_mut().for_each(|shaft| shaft.elements = Some(1));
    let basis = basis(&system);
    let n = basis.model.len();
    let highest = basis.real_modes(0.0).unwrap().highest();
    let drift = |geometry: Geometry, step: f64, size: f64| {
        let mut motion = motion(&basis, geometry, 300.0, 0.0);
        let y = slow(&basis, size);
        let before = motion.energy(0.0, &y[..n], &y[n..]).unwrap();
        let state = integrate(&mut motion, RK4, Control::Fixed(step), y, 0.01);
        (motion.energy(state.elapsed, &state.y[..n], &state.y[n..]).unwrap() - before) / before
    };
    // 3e-4 m of a centre distance of 0.11 m: the line of action turns by 1e-2 rad.
    let step = 2.0_f64.powi(-18);
    assert!(step * highest < 1.0 && step * highest > 0.1, "{}", step * highest);
    for geometry in [Geometry::Live, Geometry::Frozen] {
        let (coarse, fine) = (drift(geometry, step, 3e-4), drift(geometry, step / 2.0, 3e-4));
        let ratio = coarse / fine;
        // RK4 loses ω⁶h⁵/72 of its energy a second: 2⁵, or 2⁴ for what is not quadratic.
        assert!(ratio > 28.0 && ratio < 40.0, "{coarse:e} {fine:e}");
        assert!(fine.abs() < 1e-8 && fine.abs() > 1e-13, "{fine:e}");
    }
}

#[test]
fn the_gyroscopic_matrix_is_skew_and_does_no_work() {
    let basis = basis(&free_train());
    let model = &basis.model;
    let gyroscopic = model.gyroscopic_matrix();
    assert_eq!(gyroscopic, -gyroscopic.transpose());
    assert!(gyroscopic.amax() > 0.0);
    let n = model.len();
    let mut noise = Noise::new(2);
    let y = [noise.vector(n, 1e-5), noise.vector(n, 0.1)].concat();
    let acceleration = |speed: f64| {
        let mut derivative = vec![0.0; 2 * n];
        motion(&basis, Geometry::Live, speed, 0.0).derivative(0.0, &y, &mut derivative).unwrap();
        DVector::from_column_slice(&derivative[n..])
    };
    let added = model.mass_matrix() * (acceleration(3000.0) - acceleration(0.0));
    let v = DVector::from_column_slice(&y[n..]);
    let acting = v.abs().dot(&added.abs());
    assert!(acting > 0.0);
    // Round-off of accelerations 1e3 times larger than what the spin adds to them.
    assert!(v.dot(&added).abs() < 1e-10 * acting, "{:e}", v.dot(&added) / acting);
}

#[test]
fn a_rigid_bow_gives_no_force() {
    let force = |curve: &dyn Fn(f64) -> Complex64| {
        let mut system = train();
        system.gears[0].unbalance = None;
        system.shafts[1].bow = None;
        system.shafts[0].bow = Some(points(vec![0.0, 0.5], curve));
        let model = common::model(&system);
        model.shafts.iter().flat_map(|shaft| &shaft.excitations).map(|excitation| excitation.bow.norm()).fold(0.0, f64::max)
    };
    assert_eq!(force(&|_| Complex64::new(2e-4, 0.0)), 0.0, "eccentric");
    // A slope is exact to an ulp of 1e-4 m over the elements, and meets a stiffness of 5e8 N/m.
    let tilted = force(&|x| Complex64::new(2e-4 - 1e-3 * x, 3e-4 * x));
    assert!(tilted < 5e8 * 1e-4 * 1e-15 * 10.0, "{tilted:e} N");
    let bent = {
        let model = common::model(&train());
        model.shafts[0].excitations.iter().map(|excitation| excitation.bow.norm()).fold(0.0, f64::max)
    };
    assert!(bent > 100.0, "a bent one does: {bent} N");
}

#[test]
fn a_turned_bow_follows_its_shaft() {
    // The whole load turns with its shaft: at a quarter turn of the input v has become w.
    let mut system = train();
    system.shafts[1].bow = None;
    system.torques.clear();
    let basis = basis(&system);
    let (n, speed) = (basis.model.len(), 50.0);
    let at = |angle: f64| {
        let mut derivative = vec![0.0; 2 * n];
        motion(&basis, Geometry::Frozen, speed, angle / speed).derivative(0.0, &vec![0.0; 2 * n], &mut derivative).unwrap();
        DVector::from_column_slice(&derivative[n..])
    };
    let (start, quarter) = (at(0.0), at(std::f64::consts::FRAC_PI_2));
    let scale = start.amax();
    for i in (0..4 * basis.model.scene.shafts[0].nodes.len()).step_by(2) {
        // The sine of π/2 times the spin, an ulp or two away from a quarter turn.
        assert!((quarter[i + 1] - start[i]).abs() < 1e-14 * scale && (quarter[i] + start[i + 1]).abs() < 1e-14 * scale);
    }
    // Long runs keep their angle: a whole number of turns later the load is the same. 1e9 turns of 2⁻²⁰ s.
    let spin = 2.0 * std::f64::consts::PI * 2.0_f64.powi(20);
    let turned = phase(spin, 1e9 * 2.0_f64.powi(-20));
    // π itself is known to 1e-16, a billion turns of it to 2.5e-7 rad: the remainder is that of the double nearest 2π.
    let remainder = 2.449_293_598_294_706_5e-16 * 1e9;
    assert!((turned.arg() + remainder).abs() < 1e-15, "{:e}", turned.arg());
}

#[test]
fn the_rolling_momentum_is_conserved() {
    // Torque in balance does no work on the rolling, and live mesh forces have no part along it.
    let mut system = train();
    system.meshes.iter_mut().for_each(|mesh| mesh.centre_line_angle = Some(0.3));
    let basis = basis(&system);
    let (n, speed) = (basis.model.len(), 100.0);
    let real = basis.real_modes(speed).unwrap();
    let mut motion = motion(&basis, Geometry::Live, speed, 0.0);
    let weighted = basis.model.mass_matrix() * real.vectors.column(0);
    let mut noise = Noise::new(9);
    let y = [noise.vector(n, 1e-6), noise.vector(n, 0.01)].concat();
    let momentum = |y: &[f64]| weighted.dot(&DVector::from_column_slice(&y[n..]));
    let passing = |y: &[f64]| weighted.abs().dot(&DVector::from_column_slice(&y[n..]).abs());
    let before = momentum(&y);
    let step = 1.0 / Spectrum::new(&basis, speed).unwrap().radius();
    let (mut method, mut state) = (RungeKutta::new(RK4, 2 * n), State::new(y));
    let (mut drift, mut most) = (0.0_f64, 0.0_f64);
    for part in 1..=20 {
        let end = (f64::from(part) * 5000.0 + 0.5) * step;
        run(&mut motion, &mut method, &Control::Fixed(step), &mut state, end, &mut Nobody, &mut Statistics::new()).unwrap();
        drift = drift.max((momentum(&state.y) - before).abs());
        most = most.max(passing(&state.y));
    }
    assert_eq!(state.count, 100_000);
    // An ulp of the momentum that swings between the shafts each step, adding up at random: 300 of them.
    assert!(drift < 300.0 * f64::EPSILON * most, "{:e}", drift / most);
    assert!(before.abs() > 1e-6 * most, "the train rolls: {:e}", before / most);
}

#[test]
fn a_balanced_train_does_not_move_the_rolling_motion_from_rest() {
    let basis = basis(&train());
    let rolling = basis.real_modes(0.0).unwrap().vectors.column(0).into_owned();
    let load = &basis.model.constant_load;
    let acting = rolling.abs().dot(&load.abs());
    // A sum of two torques that cancel.
    assert!(rolling.dot(load).abs() < 1e-14 * acting);
}

/// The bits of a run.
fn bits(basis: &Basis, live: bool) -> Vec<u64> {
    let geometry = if live { Geometry::Live } else { Geometry::Frozen };
    let n = basis.model.len();
    let longest = Spectrum::new(basis, 100.0).unwrap().longest_step(&DORMAND_PRINCE);
    let mut noise = Noise::new(1);
    let y = [noise.vector(n, 1e-6), noise.vector(n, 0.01)].concat();
    let control = Control::Adaptive(Adaptive { rtol: 1e-6, floor: 1e-9, longest });
    let first = integrate(&mut motion(basis, geometry, 100.0, 0.0), DORMAND_PRINCE, control, y, 1e-3);
    let second = integrate(&mut motion(basis, geometry, 100.0, 0.0), RK4, Control::Fixed(longest), first.y, 1e-3);
    second.y.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn a_run_gives_the_same_bits_again_and_in_any_thread() {
    let first = basis(&everything());
    let once = [bits(&first, true), bits(&first, false)];
    assert_ne!(once[0], once[1]);
    assert_eq!([bits(&first, true), bits(&first, false)], once, "twice");
    let again = basis(&everything());
    assert_eq!(bits(&again, true), once[0], "assembled anew");
    std::thread::scope(|scope| {
        // Two threads on one basis, each with a motion of its own.
        let threads = [true, false].map(|live| scope.spawn(move || bits(&basis(&everything()), live)));
        let shared = [true, false].map(|live| scope.spawn({ let first = &first; move || bits(first, live) }));
        assert_eq!(threads.map(|thread| thread.join().unwrap()), once);
        assert_eq!(shared.map(|thread| thread.join().unwrap()), once);
    });
}

#[test]
fn norms_are_those_of_the_dense_matrices() {
    let basis = basis(&train());
    let model = &basis.model;
    let n = model.len();
    let mut noise = Noise::new(4);
    let equilibrium = DVector::from_vec(noise.vector(n, 1e-5));
    let mut motion = Motion::new(&basis, Geometry::Live, 100.0, 0.0, equilibrium.clone()).unwrap();
    let y = [noise.vector(n, 1e-5), noise.vector(n, 0.1)].concat();
    let (q, v) = (DVector::from_column_slice(&y[..n]), DVector::from_column_slice(&y[n..]));
    let (mass, stiffness): (DMatrix<f64>, DMatrix<f64>) = (model.mass_matrix(), model.stiffness_matrix(100.0));
    let norm = |q: &DVector<f64>| (q.dot(&(&stiffness * q)) + v.dot(&(&mass * &v))).sqrt();
    // Sums of squares: nothing cancels but in the dense product itself.
    assert!((motion.norm(&y) - norm(&q)).abs() < 1e-12 * norm(&q));
    let deviation = norm(&(&q - equilibrium));
    assert!((motion.size(&y) - deviation).abs() < 1e-12 * deviation);
    assert!(largest(&y) > 0.0 && motion.norm(&vec![0.0; 2 * n]) == 0.0);
}
