//! Eigenvalues: known spectra, the first-order form in modal coordinates, and rigid-body modes.

use crate::common::{Noise, cached, free_train, largest, train};
use gearbow::analysis::simulate::System;
use gearbow::linalg::{DecompositionError, eigen, symmetric_pencil};
use gearbow::modal::{self, ModeSelection, Whirl};
use gearbow::scene::SceneDescription;
use gearbow::scene::description::Coefficient;
use nalgebra::{Complex, DMatrix, DVector};

/// Backward error of a decomposition relative to the norm of the matrix, for up to a hundred rows.
const BACKWARD: f64 = 1e-13;

/// Checks that every eigenvalue is near an expected one, that every expected one is found, and that A v = λ v.
fn assert_spectrum(matrix: &DMatrix<f64>, expected: &[Complex<f64>], tolerance: f64) {
    let found = eigen(matrix).unwrap();
    let complex = matrix.map(|value| Complex::new(value, 0.0));
    for (value, vector) in found.values.iter().zip(found.vectors.column_iter()) {
        assert!((vector.norm() - 1.0).abs() < 1e-14, "eigenvectors have unit length");
        assert!((&complex * vector - vector * *value).norm() < BACKWARD * matrix.norm().max(1.0));
    }
    assert_eq!(found.values.len(), expected.len());
    let nearest = |value: &Complex<f64>, all: &[Complex<f64>]| {
        all.iter().map(|other| (value - other).norm()).fold(f64::INFINITY, f64::min)
    };
    for value in found.values.iter() {
        assert!(nearest(value, expected) < tolerance, "{value} is not an expected eigenvalue");
    }
    for value in expected {
        assert!(nearest(value, found.values.as_slice()) < tolerance, "{value} is missing");
    }
}

#[test]
fn general_matrices_have_their_known_spectra() {
    let phasor = |angle: f64| Complex::from_polar(1.0, angle);
    // A cyclic shift has the n-th roots of unity. It is a normal matrix, so the eigenvalues are accurate to round-off.
    let n = 12;
    let shift = DMatrix::from_fn(n, n, |i, j| if (i + 1) % n == j { 1.0 } else { 0.0 });
    let roots: Vec<_> = (0..n).map(|k| phasor(2.0 * std::f64::consts::PI * k as f64 / n as f64)).collect();
    assert_spectrum(&shift, &roots, BACKWARD);
    // A triangular matrix has the eigenvalues on its diagonal. It is not normal: their condition number is about 1e2.
    let triangle = DMatrix::from_fn(6, 6, |i, j| match j.cmp(&i) {
        std::cmp::Ordering::Less => 0.0,
        std::cmp::Ordering::Equal => 1.0 + i as f64,
        std::cmp::Ordering::Greater => 1.0,
    });
    let diagonal: Vec<_> = (1..7).map(|value| Complex::new(f64::from(value), 0.0)).collect();
    assert_spectrum(&triangle, &diagonal, 1e-11);
    // Damped oscillators, coupled by an orthogonal transformation.
    let mut noise = Noise::new(3);
    let q = DMatrix::from_fn(8, 8, |_, _| noise.next()).qr().q();
    let mut blocks = DMatrix::zeros(8, 8);
    let mut expected = Vec::new();
    for k in 0..4 {
        let (decay, frequency) = (-0.1 * f64::from(k), 1.0 + 3.0 * f64::from(k));
        let at = 2 * k as usize;
        blocks.view_mut((at, at), (2, 2)).copy_from_slice(&[decay, frequency, -frequency, decay]);
        expected.extend([Complex::new(decay, frequency), Complex::new(decay, -frequency)]);
    }
    assert_spectrum(&(&q * blocks * q.transpose()), &expected, 1e-12);
}

#[test]
fn repeated_eigenvalues_have_independent_eigenvectors() {
    // Ten damped oscillators, each three times, coupled by an orthogonal transformation; y = (x, ẋ/ω).
    let mut noise = Noise::new(11);
    let n = 30;
    let q = DMatrix::from_fn(n, n, |_, _| noise.next()).qr().q();
    let frequency = |k: usize| 10.0_f64.powf((k / 3) as f64 / 4.0);
    let transformed = |diagonal: &dyn Fn(usize) -> f64| {
        &q * DMatrix::from_fn(n, n, |i, j| if i == j { diagonal(i) } else { 0.0 }) * q.transpose()
    };
    let mut matrix = DMatrix::zeros(2 * n, 2 * n);
    matrix.view_mut((0, n), (n, n)).copy_from(&transformed(&frequency));
    matrix.view_mut((n, 0), (n, n)).copy_from(&transformed(&|k| -frequency(k)));
    matrix.view_mut((n, n), (n, n)).copy_from(&transformed(&|k| -0.1 * frequency(k)));
    let found = eigen(&matrix).unwrap();
    let complex = matrix.map(Complex::from);
    for (value, vector) in found.values.iter().zip(found.vectors.column_iter()) {
        assert!((&complex * vector - vector * *value).norm() < BACKWARD * matrix.norm());
    }
    // The inverse of 2n orthogonal unit vectors has the norm √(2n). A factor of ten allows vectors of equal eigenvalues
    // at an angle of a tenth.
    let inverse = found.vectors.clone().try_inverse().unwrap();
    assert!(inverse.norm() < 10.0 * (2.0 * n as f64).sqrt(), "{:e}", inverse.norm());
}

#[test]
fn defective_empty_nan_and_huge_matrices_are_handled() {
    // Round-off changes the triple eigenvalue of a Jordan block by its cube root, 6e-6.
    let jordan = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 0.0, 0.0, 2.0, 1.0, 0.0, 0.0, 2.0]);
    let near = DMatrix::from_row_slice(3, 3, &[1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0]);
    let similar = near.clone() * jordan * near.try_inverse().unwrap();
    assert_spectrum(&similar, &[Complex::new(2.0, 0.0); 3], 1e-4);
    assert_eq!(eigen(&DMatrix::zeros(0, 0)).unwrap().values.len(), 0);
    assert_spectrum(&DMatrix::zeros(2, 2), &[Complex::new(0.0, 0.0); 2], f64::MIN_POSITIVE);
    let nan = DMatrix::from_element(4, 4, f64::NAN);
    assert!(eigen(&nan).is_err_and(|error| error == DecompositionError::Eigenvalues));
    // One entry near overflow, in a matrix large enough for the blocked algorithm.
    let mut huge = DMatrix::from_fn(150, 150, |i, j| ((7 * i + 3 * j) % 11) as f64 - 5.0);
    huge[(0, 0)] = 1e308;
    let largest = eigen(&huge).map(|found| found.values.map(|value| value.norm()).max());
    assert!(largest.is_ok_and(|value| (value - 1e308).abs() < 1e308 * BACKWARD));
}

#[test]
fn eigenvectors_of_a_pencil_without_null_space_are_orthonormal() {
    let n = 40;
    let mut noise = Noise::new(7);
    let mut positive = |shift: f64| {
        let factor = DMatrix::from_fn(n, n, |_, _| noise.next());
        &factor * factor.transpose() + DMatrix::identity(n, n) * shift
    };
    let (stiffness, mass) = (positive(0.1), positive(1.0));
    let pencil = symmetric_pencil(&stiffness, &mass, &DMatrix::zeros(n, 0)).unwrap();
    assert!(pencil.values.as_slice().windows(2).all(|pair| pair[0] <= pair[1]), "ascending");
    let over = |matrix: &DMatrix<f64>| pencil.vectors.transpose() * matrix * &pencil.vectors;
    // M has the condition number 30, by which the triangular solves may multiply round-off.
    assert!((over(&mass) - DMatrix::identity(n, n)).amax() < 1e-12);
    let highest = pencil.values.max();
    assert!((over(&stiffness) - DMatrix::from_diagonal(&pencil.values)).amax() < 1e-12 * highest);
}

#[test]
fn null_vectors_of_a_pencil_are_exact() {
    // Two separate chains of different masses and springs, both free: two rigid-body translations.
    let n = 12;
    let mut stiffness = DMatrix::zeros(2 * n, 2 * n);
    for i in (0..2 * n - 1).filter(|i| *i != n - 1) {
        let spring = 1e9 * (1.0 + i as f64);
        stiffness[(i, i)] += spring;
        stiffness[(i + 1, i + 1)] += spring;
        stiffness[(i, i + 1)] -= spring;
        stiffness[(i + 1, i)] -= spring;
    }
    let mass = DMatrix::from_fn(2 * n, 2 * n, |i, j| if i == j { 1.0 + 0.3 * i as f64 } else { 0.0 });
    let null = DMatrix::from_fn(2 * n, 2, |i, j| {
        let total: f64 = (0..n).map(|k| mass[(j * n + k, j * n + k)]).sum();
        if i / n == j { 1.0 / total.sqrt() } else { 0.0 }
    });
    let pencil = symmetric_pencil(&stiffness, &mass, &null).unwrap();
    assert_eq!(pencil.values.as_slice()[..2], [0.0; 2]);
    assert_eq!(pencil.vectors.columns(0, 2), null);
    let over = |matrix: &DMatrix<f64>| pencil.vectors.transpose() * matrix * &pencil.vectors;
    assert!((over(&mass) - DMatrix::identity(2 * n, 2 * n)).amax() < 1e-13);
    let highest = pencil.values.max();
    assert!((over(&stiffness) - DMatrix::from_diagonal(&pencil.values)).amax() < BACKWARD * highest);
    assert!(pencil.values[2] > 1e-4 * highest, "the third mode is elastic");

    let negative = -mass;
    let error = symmetric_pencil(&stiffness, &negative, &DMatrix::zeros(2 * n, 0)).unwrap_err();
    assert_eq!(error, DecompositionError::Mass(0));
}

/// A shaft of 30 elements with a heavy disk, on two bearings with `damping` in N s/m.
fn rotor(damping: f64) -> System {
    let text = format!(
        r#"
        shafts = [{{ name = "rotor", length = 1.5, outer_diameter = 0.05, elements = 30 }}]
        disks = [{{ name = "disk", shaft = "rotor", position = 0.5, mass = 30.0, diametral_inertia = 0.2, polar_inertia = 0.4 }}]
        bearings = [
            {{ shaft = "rotor", position = 0.0, stiffness = [1e6, 3e6], damping = {damping} }},
            {{ shaft = "rotor", position = 1.5, stiffness = 1e6, damping = {damping} }},
        ]
        "#
    );
    cached(&SceneDescription::from_toml(&text).unwrap())
}

#[test]
fn an_undamped_gyroscopic_rotor_has_no_growth() {
    let undamped = rotor(0.0);
    let highest = undamped.real_modes(0.0).unwrap().highest();
    for speed in [0.0, 1.0, 400.0, -400.0, 5000.0] {
        let modes = modal::modes(&undamped, speed, usize::MAX, ModeSelection::All).unwrap();
        assert_eq!(modes.len(), undamped.model.len(), "one mode per degree of freedom");
        let growth = largest(&modes.iter().map(|mode| mode.eigenvalue.re).collect::<Vec<_>>());
        // The matrix in modal coordinates is skew-symmetric, so the error of its eigenvalues is a few ε·ω_max. In
        // physical coordinates the error would be 1e-4.
        assert!(growth < 1e-9 * highest, "{growth:e} 1/s at {speed} rad/s");
    }
    // With damped bearings every mode decays.
    assert!(
        modal::modes(&rotor(100.0), 400.0, usize::MAX, ModeSelection::All)
            .unwrap()
            .iter()
            .all(|mode| mode.eigenvalue.re < 0.0)
    );
}

#[test]
fn modes_satisfy_the_quadratic_eigenproblem() {
    let (cached, speed) = (rotor(100.0), 400.0);
    let model = &cached.model;
    let (mass, stiffness) = (model.mass_matrix(), model.stiffness_matrix(speed));
    let rate = cached.damping_matrix(speed).unwrap() + model.gyroscopic_matrix() * speed;
    let complex = |matrix: &DMatrix<f64>| matrix.map(|value| Complex::new(value, 0.0));
    let (mass, rate, stiffness) = (complex(&mass), complex(&rate), complex(&stiffness));
    for mode in modal::modes(&cached, speed, usize::MAX, ModeSelection::All).unwrap() {
        let (value, shape) = (mode.eigenvalue, &mode.shape);
        let inertia = &mass * shape * (value * value);
        let elastic = &stiffness * shape;
        let residual: DVector<Complex<f64>> = &inertia + &rate * shape * value + &elastic;
        // The error of φ in the directions of the stiffest modes is ε·ω_max²/ω², up to ε·1e7 here. K amplifies it.
        assert!(
            residual.norm()
                < 1e-9 * (complex(&model.stiffness_matrix(speed)) * shape.map(|z| Complex::new(z.norm(), 0.0))).norm()
        );
        assert!((shape.dotc(&(&mass * shape)).re - 1.0).abs() < 1e-10, "φᴴMφ = 1");
    }
}

#[test]
fn a_train_has_exactly_one_rigid_body_mode_its_rotation() {
    let cached = cached(&train());
    let (model, real) = (&cached.model, cached.real_modes(100.0).unwrap());
    assert_eq!(real.null, 1);
    assert_eq!(real.frequencies[0], 0.0);
    assert!(real.frequencies[1] > 1.0, "{} rad/s", real.frequencies[1]);
    let rotation = real.vectors.column(0);
    let scale = rotation.amax();
    for dof in model.numbering.dofs() {
        let ratio = if dof.kind.is_lateral() { 0.0 } else { model.scene.speed_ratios[dof.node.shaft] };
        let expected = rotation[model.numbering.torsion(0).unwrap()] * ratio;
        // Round-off of the small eigenproblem for rigid-body modes.
        assert!((rotation[dof.index] - expected).abs() < 1e-13 * scale, "{dof:?}");
    }
    // Very soft and very stiff bearings in one train still constrain all shafts.
    let mut system = train();
    for (index, bearing) in system.bearings.iter_mut().enumerate() {
        bearing.stiffness = Some(Coefficient::Isotropic(if index < 3 { 1e4 } else { 1e12 }).into());
    }
    assert_eq!(crate::common::cached(&system).real_modes(100.0).unwrap().null, 1);
    let modes = modal::modes(&cached, 100.0, usize::MAX, ModeSelection::All).unwrap();
    let rigid = modes.iter().filter(|mode| mode.eigenvalue == Complex::new(0.0, 0.0));
    assert_eq!(rigid.map(|mode| mode.whirl).collect::<Vec<_>>(), [Whirl::Rigid]);
}

#[test]
fn free_shafts_have_four_rigid_body_modes_in_bending_and_one_in_torsion() {
    let free = |motion: &str| {
        let text = format!(
            "motion = \"{motion}\"\nshafts = [{{ name = \"s\", length = 1.0, outer_diameter = 0.05, elements = 6 }}]"
        );
        cached(&SceneDescription::from_toml(&text).unwrap()).real_modes(0.0).unwrap().null
    };
    assert_eq!([free("lateral"), free("torsion"), free("coupled")], [4, 1, 5]);
    // Without bearings the three shafts of the train have fifteen rigid motions. Each of the two meshes constrains one.
    let mut unsupported = free_train();
    unsupported.bearings.clear();
    unsupported.motion = Some(gearbow::scene::MotionKind::Coupled);
    assert_eq!(cached(&unsupported).real_modes(0.0).unwrap().null, 13);
    // One isotropic bearing constrains two more.
    unsupported.bearings = vec![train().bearings[0].clone()];
    assert_eq!(cached(&unsupported).real_modes(0.0).unwrap().null, 11);
}

#[test]
fn undamped_modes_of_a_train_are_orthonormal() {
    // 75 and 255 coordinates. Above 128 the default of faer, divide and conquer, would be inaccurate for the repeated
    // frequencies of the two bending planes.
    for elements in [4, 16] {
        let mut system = train();
        system.shafts.iter_mut().for_each(|shaft| shaft.elements = Some(elements));
        let cached = cached(&system);
        let real = cached.real_modes(0.0).unwrap();
        let over = |matrix: DMatrix<f64>| real.vectors.transpose() * matrix * &real.vectors;
        let n = real.frequencies.len();
        // Masses of elements and gears differ by a factor of 1e3.
        assert!((over(cached.model.mass_matrix()) - DMatrix::identity(n, n)).amax() < 1e-11);
        let squares = real.frequencies.map(|frequency| frequency * frequency);
        let stiffness = over(cached.model.stiffness_matrix(0.0)) - DMatrix::from_diagonal(&squares);
        assert!(stiffness.amax() < 1e-12 * squares.max());
    }
}

#[test]
fn a_residual_has_the_size_of_the_error_of_shape_and_eigenvalue() {
    let cached = cached(&train());
    let speed = 100.0;
    let modes = modal::modes(&cached, speed, 12, ModeSelection::All).unwrap();
    for mode in modes.iter().filter(|mode| mode.eigenvalue.im > 0.0) {
        let residual = |value: Complex<f64>, shape: &DVector<Complex<f64>>| {
            modal::residual(&cached, speed, value, shape, modal::EquationForces::All(None)).unwrap()
        };
        let exact = residual(mode.eigenvalue, &mode.shape);
        assert!(exact.is_accurate() && exact.value < 1e-9, "{exact:?}");
        let error = 1e-3;
        let shifted = residual(mode.eigenvalue * (1.0 + error), &mode.shape);
        // λ² has twice the error of λ; the norm of a mode has two equal parts.
        assert!((error / 3.0..3.0 * error).contains(&shifted.value) && !shifted.is_accurate(), "{shifted:?}");
        // An error of the twist alone, whose forces are small beside those of translations.
        let mut wrong = mode.shape.clone();
        let twist = cached.model.numbering.torsion(0).unwrap();
        let size = (cached.model.complex_kinetic_form(&mode.shape)).sqrt();
        let mut unit = DVector::zeros(wrong.len());
        unit[twist] = Complex::new(1.0, 0.0);
        wrong[twist] += unit[twist] * (error * size / cached.model.complex_kinetic_form(&unit).sqrt());
        assert!(residual(mode.eigenvalue, &wrong).value > error / 3.0);
    }
}
