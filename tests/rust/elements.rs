//! Matrices of one shaft element, compared with closed forms that its implementation does not use.

use std::f64::consts::PI;

use gearbow::element::{Beam, Elastic, shear_coefficient};
use gearbow::scene::{Element, Material, Tube};
use nalgebra::{Matrix2, Matrix4, Vector4};
use proptest::prelude::*;

const STEEL: Material =
    Material { youngs_modulus: 207e9, shear_modulus: 207e9 / 2.6, poisson_ratio: 0.3, density: 7850.0 };

/// Relative round-off of a few operations on numbers of similar size.
const ROUND_OFF: f64 = 1e-13;

/// Properties of a section.
struct Section {
    /// ρA, kg/m.
    mass: f64,
    /// ρI, kg m.
    rotary: f64,
    /// EI, N m².
    bending: f64,
    /// κGA, N.
    shear: f64,
}

fn section(element: &Element, material: &Material) -> Section {
    let [outer, inner] = element.body.radii(0.0);
    let area = PI * (outer.powi(2) - inner.powi(2));
    let second = PI * (outer.powi(4) - inner.powi(4)) / 4.0;
    let kappa = shear_coefficient(material.poisson_ratio, inner / outer);
    Section {
        mass: material.density * area,
        rotary: material.density * second,
        bending: material.youngs_modulus * second,
        shear: kappa * material.shear_modulus * area,
    }
}

fn solid(length: f64, outer_radius: f64) -> Element {
    Element::cylinder(length, outer_radius, 0.0, STEEL)
}

/// Largest difference of entries relative to √(aᵢᵢ aⱼⱼ) of `expected`, which has the unit of the entry.
fn difference(found: &Matrix4<f64>, expected: &Matrix4<f64>) -> f64 {
    let scale = |i: usize, j: usize| (expected[(i, i)] * expected[(j, j)]).sqrt();
    Matrix4::from_fn(|i, j| (found[(i, j)] - expected[(i, j)]).abs() / scale(i, j)).max()
}

/// Symmetric matrix from its upper triangle by rows, times `factor`.
fn symmetric(factor: f64, entries: [f64; 10]) -> Matrix4<f64> {
    let [a, b, c, d, e, f, g, h, i, j] = entries;
    factor * Matrix4::new(a, b, c, d, b, e, f, g, c, f, h, i, d, g, i, j)
}

/// Mass matrices of translation and of rotary inertia of the Timoshenko element (Przemieniecki 1968, eqs. 11.33 and
/// 11.34).
fn published_mass(section: &Section, l: f64, phi: f64) -> [Matrix4<f64>; 2] {
    let square = phi * phi;
    let a = 13.0 / 35.0 + 7.0 * phi / 10.0 + square / 3.0;
    let b = (11.0 / 210.0 + 11.0 * phi / 120.0 + square / 24.0) * l;
    let c = 9.0 / 70.0 + 3.0 * phi / 10.0 + square / 6.0;
    let d = -(13.0 / 420.0 + 3.0 * phi / 40.0 + square / 24.0) * l;
    let e = (1.0 / 105.0 + phi / 60.0 + square / 120.0) * l * l;
    let f = -(1.0 / 140.0 + phi / 60.0 + square / 120.0) * l * l;
    let translation = symmetric(section.mass * l / (1.0 + phi).powi(2), [a, b, c, d, e, -d, f, a, -b, e]);
    let p = 6.0 / 5.0;
    let q = (1.0 / 10.0 - phi / 2.0) * l;
    let r = (2.0 / 15.0 + phi / 6.0 + square / 3.0) * l * l;
    let s = (-1.0 / 30.0 - phi / 6.0 + square / 6.0) * l * l;
    let rotary = symmetric(section.rotary / (l * (1.0 + phi).powi(2)), [p, q, -p, q, r, -q, s, p, -q, r]);
    [translation, rotary]
}

#[test]
fn mass_and_gyroscopic_matrices_equal_the_published_ones() {
    for (length, inner_radius, shear) in [(0.1, 0.0, true), (0.02, 0.015, true), (0.3, 0.01, false)] {
        let element = Element::cylinder(length, 0.025, inner_radius, STEEL);
        let section = section(&element, &STEEL);
        let phi = if shear { 12.0 * section.bending / (section.shear * length * length) } else { 0.0 };
        let [translation, rotary] = published_mass(&section, length, phi);
        let beam = Beam::new(&element, shear);
        assert!(difference(&beam.mass, &(translation + rotary)) < ROUND_OFF);
        assert!(difference(&beam.gyroscopic, &(2.0 * rotary)) < ROUND_OFF);
    }
}

#[test]
fn stiffness_without_shear_is_that_of_the_euler_bernoulli_beam() {
    let element = solid(0.2, 0.01);
    let l = element.length;
    let expected = symmetric(
        section(&element, &STEEL).bending / l.powi(3),
        [12.0, 6.0 * l, -12.0, 6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l, 12.0, -6.0 * l, 4.0 * l * l],
    );
    assert!(difference(&Beam::new(&element, false).stiffness, &expected) < ROUND_OFF);
}

#[test]
fn shear_deformation_vanishes_for_large_shear_modulus_and_for_slender_elements() {
    // φ = 12EI/(κGAl²) is 1e-18 here, which is below round-off.
    let rigid = Material { shear_modulus: 1e30, ..STEEL };
    let element = Element::cylinder(0.1, 0.02, 0.0, rigid);
    let (with, without) = (Beam::new(&element, true), Beam::new(&element, false));
    assert!(difference(&with.stiffness, &without.stiffness) < ROUND_OFF);
    assert!(difference(&with.mass, &without.mass) < ROUND_OFF);

    // For a slender element the difference is φ to first order, so it decreases with the square of the length.
    let deviation = |length: f64| {
        let element = solid(length, 0.02);
        difference(&Beam::new(&element, true).stiffness, &Beam::new(&element, false).stiffness)
    };
    let ratio = deviation(2.0) / deviation(4.0);
    // φ is 1e-3 at 2 m. Terms of second order change the ratio by a similar relative amount.
    assert!((ratio - 4.0).abs() < 1e-2, "{ratio}");
}

#[test]
fn a_cantilever_of_one_element_has_the_exact_flexibility() {
    for (element, shear) in [(solid(0.8, 0.02), true), (solid(0.03, 0.02), true), (solid(0.03, 0.02), false)] {
        let section = section(&element, &STEEL);
        let l = element.length;
        let shear_flexibility = if shear { l / section.shear } else { 0.0 };
        let stiffness = Beam::new(&element, shear).stiffness;
        let free: Matrix2<f64> = stiffness.fixed_view::<2, 2>(2, 2).into();
        let flexibility = free.try_inverse().unwrap();
        // Tip deflection and section rotation for a unit force and a unit moment at the tip.
        let expected = Matrix2::new(
            l.powi(3) / (3.0 * section.bending) + shear_flexibility,
            l * l / (2.0 * section.bending),
            l * l / (2.0 * section.bending),
            l / section.bending,
        );
        // The determinant of the inverted 2 × 2 matrix is a difference of numbers of similar size.
        assert!((flexibility - expected).component_div(&expected).amax() < 1e-12);
    }
}

#[test]
fn torsion_has_the_stiffness_and_the_inertia_of_a_tube() {
    let element = Element::cylinder(0.3, 0.03, 0.02, STEEL);
    let beam = Beam::new(&element, true);
    let polar = PI / 2.0 * (0.03_f64.powi(4) - 0.02_f64.powi(4));
    let stiffness = STEEL.shear_modulus * polar / element.length;
    let inertia = STEEL.density * polar * element.length;
    let expected = Matrix2::new(1.0, -1.0, -1.0, 1.0) * stiffness;
    assert!((beam.torsion.stiffness - expected).amax() < ROUND_OFF * stiffness);
    assert!((beam.torsion.mass.sum() - inertia).abs() < ROUND_OFF * inertia);
    // For a rotation that increases linearly from 0 to 1 the effective inertia is ∫ξ² dξ = 1/3 of the total inertia.
    assert!((beam.torsion.mass[(1, 1)] - inertia / 3.0).abs() < ROUND_OFF * inertia);
    assert!((beam.torsion.rod.stiffness - stiffness).abs() < ROUND_OFF * stiffness);
}

#[test]
fn shear_coefficient_agrees_with_cowper() {
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    for nu in [0.0, 0.25, 0.3, 0.5] {
        close(shear_coefficient(nu, 0.0), 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu));
        // Thin-walled circular tube (Cowper 1966).
        close(shear_coefficient(nu, 1.0), 2.0 * (1.0 + nu) / (4.0 + 3.0 * nu));
    }
    // m = 1/2, ν = 0.3: 6·1.3·1.5625/(8.8·1.5625 + 23.6·0.25).
    close(shear_coefficient(0.3, 0.5), 12.1875 / 19.65);
}

#[test]
fn a_tube_equals_the_solid_shaft_minus_its_core() {
    // Without shear all matrices are linear in A and I. With shear κ depends on the ratio of radii.
    let [tube, solid, core] = [(0.03, 0.02), (0.03, 0.0), (0.02, 0.0)].map(|(outer_radius, inner_radius)| {
        Beam::new(&Element::cylinder(0.1, outer_radius, inner_radius, STEEL), false)
    });
    for matrix in [|beam: &Beam| beam.mass, |beam: &Beam| beam.stiffness, |beam: &Beam| beam.gyroscopic] {
        assert!(difference(&matrix(&tube), &(matrix(&solid) - matrix(&core))) < ROUND_OFF);
    }
}

/// A solid cone of steel.
fn cone(length: f64, outer_radius: [f64; 2]) -> Element {
    let body = Tube { outer_radius, ..Tube::cylinder(outer_radius[0], 0.0, STEEL) };
    Element { body, ..Element::cylinder(length, outer_radius[0], 0.0, STEEL) }
}

#[test]
fn a_cantilever_cone_has_the_exact_flexibility() {
    let (l, radii) = (0.4, [0.03, 0.015]);
    for shear in [false, true] {
        let stiffness = Beam::new(&cone(l, radii), shear).stiffness;
        let free: Matrix2<f64> = stiffness.fixed_view::<2, 2>(2, 2).into();
        let flexibility = free.try_inverse().unwrap();
        // ∫(l − x)ⁿ/EI dx with EI = EI₀ s⁴ and s = 1 − cx, from the begin to the end, where s is `end`: l − x = (s − end)/c.
        let (bending, end) = (STEEL.youngs_modulus * PI / 4.0 * radii[0].powi(4), radii[1] / radii[0]);
        let c = (1.0 - end) / l;
        let power = |n: i32| (end.powi(-n) - 1.0) / (f64::from(n) * c);
        let [first, second, third] = [power(1), power(2), power(3)];
        let kappa = shear_coefficient(STEEL.poisson_ratio, 0.0);
        let sheared = if shear { l / (kappa * STEEL.shear_modulus * PI * radii[0] * radii[1]) } else { 0.0 };
        let square = (first - 2.0 * end * second + end * end * third) / (c * c * bending) + sheared;
        let linear = (second - end * third) / (c * bending);
        let expected = Matrix2::new(square, linear, linear, third / bending);
        assert!((flexibility - expected).component_div(&expected).amax() < 1e-11, "{flexibility} {expected}");
    }
}

#[test]
fn layers_with_full_stiffness_equal_one_tube_of_their_material() {
    // Without shear deformation all matrices are linear in A and I.
    let shaft = Element::cylinder(0.1, 0.02, 0.01, STEEL);
    let layered = Element { sleeves: vec![Tube::cylinder(0.03, 0.02, STEEL)], ..shaft };
    let [layered, tube] =
        [layered, Element::cylinder(0.1, 0.03, 0.01, STEEL)].map(|element| Beam::new(&element, false));
    for matrix in [|beam: &Beam| beam.mass, |beam: &Beam| beam.stiffness, |beam: &Beam| beam.gyroscopic] {
        assert!(difference(&matrix(&layered), &matrix(&tube)) < ROUND_OFF);
    }
    assert!((layered.torsion.stiffness - tube.torsion.stiffness).amax() < ROUND_OFF * tube.torsion.stiffness.amax());
    assert!((layered.axial.mass - tube.axial.mass).amax() < ROUND_OFF * tube.axial.mass.amax());
}

proptest! {
    #![proptest_config(crate::common::cases(200))]

    #[test]
    fn rigid_motions_have_no_elastic_force_and_the_exact_inertia(
        length in 1e-3..2.0, outer_radius in 1e-3..0.5, bore in 0.0..0.95, nu in -0.5..0.5, shear: bool,
    ) {
        let material = Material { poisson_ratio: nu, shear_modulus: 207e9 / (2.0 + 2.0 * nu), ..STEEL };
        let element = Element::cylinder(length, outer_radius, bore * outer_radius, material);
        let beam = Beam::new(&element, shear);
        let section = section(&element, &material);
        prop_assert_eq!(beam.stiffness, beam.stiffness.transpose());
        // Both triangles are summed over the Gauss points in the same order, but their products round differently.
        prop_assert!(difference(&beam.mass, &beam.mass.transpose()) < 1e-15);

        let translation = Vector4::new(1.0, 0.0, 1.0, 0.0);
        let rotation = Vector4::new(-length / 2.0, 1.0, length / 2.0, 1.0);
        for motion in [translation, rotation] {
            let force = beam.stiffness * motion;
            let acting = beam.stiffness.abs() * motion.abs();
            prop_assert!(force.abs().component_div(&acting).max() < 1e-15);
        }
        let mass = section.mass * length;
        let inertia = mass * length * length / 12.0 + section.rotary * length;
        // Rotary inertia of a short element cancels in these sums, so round-off is relative to the sum of magnitudes.
        let form = |matrix: &Matrix4<f64>, a: &Vector4<f64>, b: &Vector4<f64>, expected: f64| {
            (a.dot(&(matrix * b)) - expected).abs() < ROUND_OFF * a.abs().dot(&(matrix.abs() * b.abs()))
        };
        prop_assert!(form(&beam.mass, &translation, &translation, mass));
        prop_assert!(form(&beam.mass, &rotation, &rotation, inertia));
        prop_assert!(form(&beam.mass, &translation, &rotation, 0.0));
        // The gyroscopic moment of a rotation has the polar inertia 2ρIl; a translation has none.
        prop_assert!(form(&beam.gyroscopic, &rotation, &rotation, 2.0 * section.rotary * length));
        prop_assert!(form(&beam.gyroscopic, &translation, &translation, 0.0));
    }

    #[test]
    fn strains_give_the_same_force_and_energy_as_the_matrix(
        length in 1e-2..2.0, outer_radius in 1e-3..0.2, q in prop::array::uniform8(-1.0..1.0),
    ) {
        let beam = Beam::new(&solid(length, outer_radius), true);
        // Two lanes of (u₁, φ₁, u₂, φ₂) must stay independent.
        let at = |lane: usize| Vector4::from_fn(|i, _| q[2 * i + lane]);
        let node = |first: usize| [[q[first], q[first + 1]], [q[first + 2], q[first + 3]]];
        let forces = beam.bending.forces::<2>(&node(0), &node(4));
        let mut form = 0.0;
        for lane in [0, 1] {
            let expected = -beam.stiffness * at(lane);
            let acting = beam.stiffness.abs() * at(lane).abs();
            for i in 0..4 {
                prop_assert!((forces[i / 2][i % 2][lane] - expected[i]).abs() < 1e-14 * acting[i]);
            }
            form += at(lane).dot(&(beam.stiffness * at(lane)));
        }
        let acting = beam.stiffness.amax() * q.iter().map(|value| value * value).sum::<f64>();
        prop_assert!((beam.bending.quadratic_form::<2>(&node(0), &node(4)) - form).abs() < 1e-14 * acting);

        let torques = [q[2] - q[0], q[3] - q[1]].map(|twist| beam.torsion.rod.stiffness * twist);
        let found = beam.torsion.rod.forces::<2>(&[[q[0], q[1]]], &[[q[2], q[3]]]);
        prop_assert_eq!(found, [[torques], [torques.map(|torque| -torque)]]);
        let squares = (q[2] - q[0]).powi(2) + (q[3] - q[1]).powi(2);
        let form = beam.torsion.rod.quadratic_form::<2>(&[[q[0], q[1]]], &[[q[2], q[3]]]);
        prop_assert!((form - beam.torsion.rod.stiffness * squares).abs() <= 1e-15 * form);
    }
}
