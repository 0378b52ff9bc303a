//! The equation of motion, compared with its dense matrices, and rotating loads.

use crate::common::{Noise, cached, everything, free_train, largest, motion, points, train};
use gearbow::integrate::FirstOrderSystem as _;
use gearbow::mesh::{ContactMode, Geometry, ShaftPhase};
use gearbow::modal::CachedModel;
use gearbow::motion::{EquationOfMotion, phasor};
use gearbow::scene::Node;
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

/// The sum of bow force, unbalance, torque and gravity, computed from their definitions.
fn load(cached: &CachedModel, speed: f64, time: f64) -> DVector<f64> {
    let model = &cached.model;
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
        let cached = cached(&system);
        let model = &cached.model;
        let (mass, stiffness) = (model.mass_matrix(), model.stiffness_matrix(speed));
        let rate = cached.damping_matrix(speed).unwrap() + model.gyroscopic_matrix() * speed;
        let mut noise = Noise::new(11);
        let n = model.len();
        let (origin, elapsed) = (0.3, 0.02);
        let force = load(&cached, speed, origin + elapsed);
        for _ in 0..5 {
            let y = [noise.vector(n, 1e-4), noise.vector(n, 0.1)].concat();
            let mut derivative = vec![0.0; 2 * n];
            motion(&cached, Geometry::Frozen, speed, origin).derivative(elapsed, &y, &mut derivative).unwrap();
            assert_eq!(derivative[..n], y[n..]);
            let [q, v, a] = [&y[..n], &y[n..], &derivative[n..]].map(DVector::from_column_slice);
            let residual = &mass * &a + &rate * &v + &stiffness * &q - &force;
            let acting = mass.abs() * a.abs() + rate.abs() * v.abs() + stiffness.abs() * q.abs() + force.abs();
            // Backward error of each row: sums of twenty terms, and the factorization of M with the condition number
            // 1e3.
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
    let damping = crate::common::model(&system).damping_matrix(0.0);
    for gear in &mut system.gears {
        (gear.mass, gear.diametral_inertia, gear.polar_inertia) = (Some(0.0), Some(0.0), Some(0.0));
    }
    let bare = crate::common::model(&system);
    let expected = bare.mass_matrix() * alpha + bare.shaft_stiffness_matrix() * beta;
    // Each entry has two products and one sum.
    assert!((damping - &expected).amax() < 1e-14 * expected.amax());
}

#[test]
fn live_differs_from_frozen_by_the_force_of_the_meshes() {
    let cached = cached(&everything());
    let (model, speed) = (&cached.model, 200.0);
    let n = model.len();
    let mut noise = Noise::new(5);
    let y = [noise.vector(n, 2e-4), noise.vector(n, 0.1)].concat();
    let (q, v) = y.split_at(n);
    let mut accelerations = Vec::new();
    let mut forces = Vec::new();
    for geometry in [Geometry::Live, Geometry::Frozen] {
        let mut derivative = vec![0.0; 2 * n];
        motion(&cached, geometry, speed, 0.0).derivative(0.1, &y, &mut derivative).unwrap();
        accelerations.push(DVector::from_column_slice(&derivative[n..]));
        let mut force = vec![0.0; n];
        for (index, mesh) in model.meshes.iter().enumerate() {
            let sigma = model.sigma(index, speed);
            let phases = [ShaftPhase::default(); 2];
            let contact = mesh.contact(&mesh.pose(geometry, sigma, &phases, q, v), &ContactMode::ALWAYS).unwrap();
            mesh.apply(&contact, &mut force);
        }
        forces.push(DVector::from_vec(force));
    }
    let found = model.mass_matrix() * (&accelerations[0] - &accelerations[1]);
    let expected = &forces[0] - &forces[1];
    assert!(expected.amax() > 1e-4 * forces[0].amax(), "the test sees the difference");
    // The tolerance is relative to the accelerations, which the stiff shafts dominate.
    let acting = (model.mass_matrix().abs() * accelerations[0].abs()).amax();
    assert!((found - expected).amax() < 1e-13 * acting);
}

#[test]
fn a_rigid_bow_gives_no_force() {
    let force = |curve: &dyn Fn(f64) -> Complex64| {
        let mut system = train();
        system.gears[0].unbalance = None;
        system.shafts[1].bow = None;
        system.shafts[0].bow = Some(points(vec![0.0, 0.5], curve));
        let model = crate::common::model(&system);
        model
            .shafts
            .iter()
            .flat_map(|shaft| &shaft.excitations)
            .map(|excitation| excitation.bow.norm())
            .fold(0.0, f64::max)
    };
    assert_eq!(force(&|_| Complex64::new(2e-4, 0.0)), 0.0, "eccentric");
    // The slope is accurate to one ulp of 1e-4 m over the elements. A stiffness of 5e8 N/m multiplies this error.
    let tilted = force(&|x| Complex64::new(2e-4 - 1e-3 * x, 3e-4 * x));
    assert!(tilted < 5e8 * 1e-4 * 1e-15 * 10.0, "{tilted:e} N");
    let bent = {
        let model = crate::common::model(&train());
        model.shafts[0].excitations.iter().map(|excitation| excitation.bow.norm()).fold(0.0, f64::max)
    };
    assert!(bent > 100.0, "a bent one does: {bent} N");
}

#[test]
fn a_rotated_bow_rotates_with_its_shaft() {
    // The whole load rotates with its shaft: after a quarter revolution of the input shaft, v becomes w.
    let mut system = train();
    system.shafts[1].bow = None;
    system.torques.clear();
    let cached = cached(&system);
    let (n, speed) = (cached.model.len(), 50.0);
    let at = |angle: f64| {
        let mut derivative = vec![0.0; 2 * n];
        motion(&cached, Geometry::Frozen, speed, angle / speed)
            .derivative(0.0, &vec![0.0; 2 * n], &mut derivative)
            .unwrap();
        DVector::from_column_slice(&derivative[n..])
    };
    let (start, quarter) = (at(0.0), at(std::f64::consts::FRAC_PI_2));
    let scale = start.amax();
    for i in (0..4 * cached.model.scene.shafts[0].nodes.len()).step_by(2) {
        // The angle has an error of one or two ulps.
        assert!((quarter[i + 1] - start[i]).abs() < 1e-14 * scale && (quarter[i] + start[i + 1]).abs() < 1e-14 * scale);
    }
}

#[test]
fn the_shaft_angle_keeps_its_accuracy_in_long_runs() {
    // At 1e10 rad the rounded product has an error of 1e-6 rad. Products of 26-bit halves are exact.
    let (spin, time) = (123_456.789_012_345_f64, 98_765.432_109_876_5_f64);
    let halves = |value: f64| {
        let high = f64::from_bits(value.to_bits() & !0x7ff_ffff);
        [high, value - high]
    };
    let mut expected = Complex64::ONE;
    for spin in halves(spin) {
        for time in halves(time) {
            expected *= Complex64::from_polar(1.0, spin * time);
        }
    }
    // Four rotations, each accurate to one ulp.
    assert!((phasor(spin, time) - expected).norm() < 1e-15);
    assert!((Complex64::from_polar(1.0, spin * time) - expected).norm() > 1e-8, "the test sees the difference");
    assert!((phasor(-spin, time) - expected.conj()).norm() < 1e-15);
    assert!(phasor(1e300, 1e300).re.is_nan());
}

#[test]
fn norms_agree_with_the_dense_matrices() {
    let cached = cached(&train());
    let model = &cached.model;
    let n = model.len();
    let mut noise = Noise::new(4);
    let equilibrium = DVector::from_vec(noise.vector(n, 1e-5));
    let mut motion = EquationOfMotion::new(&cached, Geometry::Live, 100.0, 0.0, equilibrium.clone()).unwrap();
    let y = [noise.vector(n, 1e-5), noise.vector(n, 0.1)].concat();
    let (q, v) = (DVector::from_column_slice(&y[..n]), DVector::from_column_slice(&y[n..]));
    let (mass, stiffness): (DMatrix<f64>, DMatrix<f64>) = (model.mass_matrix(), model.stiffness_matrix(100.0));
    let norm = |q: &DVector<f64>| (q.dot(&(&stiffness * q)) + v.dot(&(&mass * &v))).sqrt();
    // The norms are sums of squares. Cancellation occurs only in the dense product.
    assert!((motion.norm(&y) - norm(&q)).abs() < 1e-12 * norm(&q));
    let deviation = norm(&(&q - equilibrium));
    assert!((motion.size(&y) - deviation).abs() < 1e-12 * deviation);
    assert!(largest(&y) > 0.0 && motion.norm(&vec![0.0; 2 * n]) == 0.0);
}
