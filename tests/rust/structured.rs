//! The lowest modes and responses with modal damping from the band matrices of the shafts, against those of
//! dense matrices.

use gearbow::linalg::Side;
use gearbow::modal::{
    self, CachedModel, DynamicKey, DynamicStiffnessSolver, EquationForces, Highest, Mode, ModeSelection, ModeSpace,
    Solved, Unknown,
};
use gearbow::model::Model;
use gearbow::scene::{Scene, SceneDescription};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use crate::common::TRAIN;

/// The train with more elements on each shaft, after a change of its description.
fn train(elements: usize, change: impl Fn(String) -> String) -> CachedModel {
    let text = change(TRAIN.replace("elements = 4", &format!("elements = {elements}")));
    CachedModel::new(Model::new(Scene::new(&SceneDescription::from_toml(&text).unwrap()).unwrap()).unwrap())
}

/// One shaft on two bearings with these fields, and a disk in the middle.
fn rotor(elements: usize, bearing: &str) -> CachedModel {
    let text = format!(
        r#"
        shafts = [{{ name = "s", length = 1.0, outer_diameter = 0.05, elements = {elements} }}]
        disks = [{{ name = "d", shaft = "s", position = 0.4, mass = 20.0, diametral_inertia = 0.1, polar_inertia = 0.2 }}]
        bearings = [
            {{ shaft = "s", position = 0.0, {bearing} }},
            {{ shaft = "s", position = 1.0, {bearing} }},
        ]
        "#
    );
    CachedModel::new(Model::new(Scene::new(&SceneDescription::from_toml(&text).unwrap()).unwrap()).unwrap())
}

/// Part of a shape in the space of other shapes, which are orthonormal in M up to damping.
fn captured(model: &Model, shape: &DVector<Complex64>, others: &[&Mode]) -> f64 {
    let weighted = |part: fn(&Complex64) -> f64| {
        let mut product = vec![0.0; model.len()];
        model.multiply_mass(shape.map(|value| part(&value)).as_slice(), &mut product);
        DVector::from_vec(product)
    };
    let weighted = weighted(|value| value.re).zip_map(&weighted(|value| value.im), Complex64::new);
    others.iter().map(|other| other.shape.dotc(&weighted).norm_sqr()).sum()
}

/// ‖S(λ)φ‖ relative to the sum of the norms of its terms.
fn residual(model: &Model, speed: f64, mode: &Mode) -> f64 {
    let (lambda, shape) = (mode.eigenvalue, &mode.shape);
    let terms = [
        model.product(shape, |x, out| model.multiply_stiffness(speed, false, x, out)),
        model.product(shape, |x, out| model.multiply_damping(speed, x, out)) * lambda,
        model.product(shape, |x, out| model.multiply_gyroscopic(x, out)) * (lambda * speed),
        model.product(shape, |x, out| model.multiply_mass(x, out)) * (lambda * lambda),
    ];
    let size: f64 = terms.iter().map(|term| term.norm()).sum();
    let sum = terms.iter().fold(DVector::zeros(model.len()), |sum, term| sum + term);
    // All terms of a rigid-body mode are round-off.
    if lambda == Complex64::ZERO { 0.0 } else { sum.norm() / size }
}

fn assert_same_modes(cached: &CachedModel, speed: f64, count: usize) {
    let found = modal::structured_modes(cached, speed, count, ModeSelection::All).unwrap().unwrap();
    let wanted = modal::modes(cached, speed, usize::MAX, ModeSelection::All).unwrap();
    assert_eq!(found.len(), count);
    let highest = wanted.last().unwrap().eigenvalue.norm();
    for (one, other) in found.iter().zip(&wanted) {
        let size = other.eigenvalue.norm();
        let part = 1e-9_f64.max(10.0 * f64::EPSILON * (highest / size.max(1e-9 * highest)).powi(2));
        assert!(
            (one.eigenvalue - other.eigenvalue).norm() <= part * size,
            "{} is not {} at {speed} rad/s",
            one.eigenvalue,
            other.eigenvalue
        );
        assert!(residual(&cached.model, speed, one) < 1e-8, "residual of {}", other.eigenvalue);
        // Shapes of strongly damped modes are not orthogonal: their residual is the better measure.
        if other.eigenvalue.re.abs() > 0.5 * size {
            continue;
        }
        let equal: Vec<&Mode> =
            wanted.iter().filter(|mode| (mode.eigenvalue - other.eigenvalue).norm() <= 1e-6 * size).collect();
        assert!(captured(&cached.model, &one.shape, &equal) > 1.0 - 1e-6, "shape of {}", other.eigenvalue);
        if equal.len() == 1 {
            assert_eq!(one.whirl, other.whirl, "whirl of {}", other.eigenvalue);
        }
    }
}

#[test]
fn a_damped_train_has_the_modes_of_dense_matrices() {
    let cached = train(8, |text| text);
    for speed in [0.0, 150.0, -800.0] {
        assert_same_modes(&cached, speed, 12);
    }
}

#[test]
fn elements_of_every_degree_have_the_modes_of_dense_matrices() {
    for (degree, elements) in [(2, 4), (3, 3), (7, 2)] {
        let cached = train(elements, |text| text.replace("elements = ", &format!("degree = {degree}, elements = ")));
        assert!(cached.model.numbering.nodal_dofs().len() < cached.model.len());
        for speed in [0.0, 150.0] {
            assert_same_modes(&cached, speed, 12);
        }
    }
}

#[test]
fn an_undamped_train_has_the_modes_of_dense_matrices() {
    let cached = train(8, |text| {
        text.replace("damping_ratio = 0.05", "damping_ratio = 0.0").replace("damping = 500.0", "damping = 0.0")
    });
    for speed in [0.0, 150.0, -800.0] {
        assert_same_modes(&cached, speed, 12);
    }
}

#[test]
fn repeated_modes_are_all_found() {
    // Equal planes, almost equal planes, and equal planes with damping.
    for bearing in ["stiffness = 1e8", "stiffness = [1e8, 1.0000001e8]", "stiffness = 1e7, damping = 300.0"] {
        let cached = rotor(24, bearing);
        for speed in [0.0, 1e-3, 400.0] {
            assert_same_modes(&cached, speed, 9);
        }
    }
}

#[test]
fn unstable_modes_are_found() {
    assert_same_modes(&rotor(24, "stiffness = [[1e7, 6e6], [-6e6, 1e7]], damping = 300.0"), 100.0, 8);
}

#[test]
fn overdamped_modes_are_not_left_out() {
    // Strong dampers on soft springs relax slowly: these motions are among the lowest modes.
    for bearing in
        ["stiffness = 1e7, damping = 1e5", "stiffness = 1e6, damping = 1e6", "stiffness = 1e7, damping = 3e4"]
    {
        assert_same_modes(&rotor(24, bearing), 100.0, 8);
    }
    assert_same_modes(&train(8, |text| text.replace("damping = 500.0", "damping = 5e4")), 100.0, 14);
}

#[test]
fn modes_with_moderate_damping_are_in_the_order_of_their_magnitudes() {
    for damping in [3e3, 1e4, 2e4] {
        let cached = rotor(24, &format!("stiffness = [1e7, 2e7], damping = {damping}"));
        for count in [4, 7, 10] {
            assert_same_modes(&cached, 100.0, count);
        }
    }
}

#[test]
#[ignore = "in the order of |λ|, the search does not tell equal strong dampers apart: dense matrices answer"]
fn strong_dampers_with_modal_damping_need_no_dense_matrices_on_fine_meshes() {
    // Equal dampers have close eigenvalues far from the origin.
    let train = train(70, |text| format!("modal_damping = 0.02\n{}", text.replace("damping = 500.0", "damping = 5e4")));
    assert_eq!(modal::structured_modes(&train, 100.0, 10, ModeSelection::All).unwrap().unwrap().len(), 10);
    // Approximations of strongly damped motions lie on both sides of the border of the count.
    let film = r#"
        modal_damping = 0.02
        gravity = 9.81
        shafts = [{ name = "s", length = 1.0, outer_diameter = 0.06, elements = 300, degree = 1 }]
        disks = [{ name = "d", shaft = "s", position = 0.4, mass = 60.0, diametral_inertia = 0.5, polar_inertia = 0.9 }]
        bearings = [
            { shaft = "s", position = 0.1, diameter = 0.06, length = 0.03, clearance = 6e-5, viscosity = 0.03, film = "finite" },
            { shaft = "s", position = 0.9, diameter = 0.06, length = 0.03, clearance = 6e-5, viscosity = 0.03, film = "finite" },
        ]
    "#;
    let rotor = CachedModel::new(Model::new(Scene::new(&SceneDescription::from_toml(film).unwrap()).unwrap()).unwrap());
    let rotor = rotor.at_speed(300.0).unwrap();
    assert_eq!(modal::structured_modes(&rotor, 300.0, 10, ModeSelection::All).unwrap().unwrap().len(), 10);
}

#[test]
fn coordinates_with_hardly_any_inertia_do_not_hide_the_lowest_modes() {
    // Disks on short shafts, joined by couplings: only the disks have inertia, so that the frequencies are those of six masses.
    let inertias = [1170.0, 1950.0, 10800.0, 11100.0, 10900.0, 430.0];
    let springs = [4.6e7, 8.3e7, 1.2e8, 1.7e8, 6.7e6];
    let mut scaled = DMatrix::<f64>::zeros(6, 6);
    for (index, spring) in springs.iter().enumerate() {
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let (i, j) = (index + row, index + column);
            let sign = if row == column { 1.0 } else { -1.0 };
            scaled[(i, j)] += sign * spring / f64::sqrt(inertias[i] * inertias[j]);
        }
    }
    let mut wanted: Vec<f64> = scaled.symmetric_eigenvalues().iter().map(|square| square.max(0.0).sqrt()).collect();
    wanted.sort_by(f64::total_cmp);
    for density in [1e-3, 1e-6, 1e-9] {
        for elements in [2, 40] {
            let list =
                |line: &dyn Fn(usize) -> String, count: usize| (0..count).map(line).collect::<Vec<_>>().join(",\n");
            let shaft = |i: usize| {
                format!(
                    r#"{{ name = "s{i}", length = 0.1, outer_diameter = 0.1, elements = {elements}, material = {{ youngs_modulus = 2.07e11, density = {density:e}, poisson_ratio = 0.3 }} }}"#
                )
            };
            let disk = |i: usize| {
                let inertia = inertias[i];
                format!(
                    r#"{{ name = "d{i}", shaft = "s{i}", position = 0.05, mass = 1.0, diametral_inertia = {}, polar_inertia = {inertia} }}"#,
                    inertia / 2.0
                )
            };
            let coupling =
                |i: usize| format!(r#"{{ a = "d{i}", b = "d{}", torsional_stiffness = {} }}"#, i + 1, springs[i]);
            let text = format!(
                "motion = \"torsion\"\nshafts = [{}]\ndisks = [{}]\ncouplings = [{}]\n",
                list(&shaft, 6),
                list(&disk, 6),
                list(&coupling, 5)
            );
            let scene = Scene::new(&SceneDescription::from_toml(&text).unwrap()).unwrap();
            let cached = CachedModel::new(Model::new(scene).unwrap());
            let found = if elements == 2 {
                modal::modes(&cached, 0.0, 6, ModeSelection::All).unwrap()
            } else {
                modal::structured_modes(&cached, 0.0, 6, ModeSelection::All).unwrap().unwrap()
            };
            for (mode, wanted) in found.iter().zip(&wanted) {
                // The shafts have less than 1e-11 of the inertia of the disks.
                let error = (mode.eigenvalue.im - wanted).abs();
                assert!(
                    error <= 1e-7 * wanted.max(1.0),
                    "{} is not {wanted}: {density:e}, {elements}",
                    mode.eigenvalue
                );
                assert!(mode.residual.is_accurate(), "{:?} with {density:e}, {elements}", mode.residual);
            }
        }
    }
}

#[test]
fn critical_speeds_are_those_of_dense_matrices() {
    for cached in [rotor(24, "stiffness = 1e8"), rotor(24, "stiffness = [1e7, 3e8]"), train(8, |text| text)] {
        for order in [1.0, 0.5, 3.0] {
            let found = modal::lowest_critical(&cached.model, order, 9).unwrap().unwrap();
            let wanted = modal::CriticalProblem::new(&cached, 1.0).unwrap().critical(order).unwrap();
            assert_eq!(found.len(), 9);
            for (one, other) in found.iter().zip(&wanted) {
                assert!((one.speed - other.speed).abs() < 1e-9 * other.speed, "{} is not {}", one.speed, other.speed);
            }
        }
    }
}

#[test]
fn an_intersection_in_a_growing_space_is_a_mode_of_dense_matrices() {
    let cached = train(4, |text| text);
    let model = &cached.model;
    for start in &modal::CriticalProblem::new(&cached, 1.0).unwrap().critical(1.0).unwrap()[..6] {
        let mut space = ModeSpace::new(model);
        space.extend(model, None, start.speed, &start.shape);
        let residual = |met: &modal::ModeAtSpeed| {
            let forces = EquationForces::All(None);
            modal::residual(&cached, met.speed, met.eigenvalue, &met.shape, forces)
        };
        let unknown = Unknown::Speed(1.0);
        let found = space.mode_near(model, None, unknown, start.clone(), residual, |residual| residual.value);
        let (met, _) = found.unwrap().unwrap();
        assert_eq!(met.eigenvalue.im, met.speed);
        let exact = modal::modes(&cached, met.speed, usize::MAX, ModeSelection::All).unwrap();
        let nearest = exact.iter().min_by(|a, b| {
            let distance = |mode: &Mode| (mode.eigenvalue - met.eigenvalue).norm();
            distance(a).total_cmp(&distance(b))
        });
        let nearest = nearest.unwrap();
        assert!((nearest.eigenvalue - met.eigenvalue).norm() < 1e-9 * met.speed);
        assert!(captured(model, &met.shape, &[nearest]) > 1.0 - 1e-6);
    }
}

#[test]
fn responses_with_modal_damping_take_as_many_iterations_on_fine_as_on_coarse_meshes() {
    for (ratio, most) in [(0.001, 4), (0.02, 7), (0.3, 14)] {
        for elements in [6, 24] {
            let damped = |text: String| format!("modal_damping = {ratio}\n{text}");
            let cached = train(elements, damped);
            let model = &cached.model;
            for speed in [-800.0, 1.0, 150.0, 2000.0] {
                let range = cached.spectral_range(speed).unwrap();
                // All modes have damping, as in the dense matrix.
                let damping = cached.modal_damping(speed, Highest::Frequency(f64::INFINITY)).unwrap();
                let at = DynamicKey { speed, spin: speed, flank_speed: speed };
                let damped = DynamicStiffnessSolver::new(model, at, damping).unwrap().unwrap();
                let mut force = DVector::zeros(model.len());
                let place = model.translations().next().unwrap();
                (force[place], force[place + 1]) = (Complex64::ONE, -Complex64::I);
                let Solved { phasors: found, products: iterations, residual } =
                    damped.solve(model, Side::Right, 0.0, &force).unwrap();
                assert!(residual < 1e-10, "{residual:e}");
                assert!(
                    iterations <= most,
                    "{iterations} iterations with {ratio} at {speed} rad/s, n = {}",
                    model.len()
                );
                if elements > 6 {
                    continue;
                }
                let rate = cached.damping_matrix(speed).unwrap() + model.gyroscopic_matrix() * speed;
                let elastic = model.stiffness_matrix(speed) - model.mass_matrix() * (speed * speed);
                let dynamic = DMatrix::from_fn(model.len(), model.len(), |i, j| {
                    Complex64::new(elastic[(i, j)], speed * rate[(i, j)])
                });
                let wanted = dynamic.lu().solve(&force).unwrap();
                let round_off = f64::EPSILON * (range.fastest / speed.abs().min(range.slowest.unwrap())).powi(2);
                let largest = |x: &DVector<Complex64>| x.map(|value| value.norm()).max();
                assert!(largest(&(found - &wanted)) <= (10.0 * round_off).max(1e-9) * largest(&wanted));
            }
        }
    }
}
