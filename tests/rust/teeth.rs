//! Tooth contact of a mesh: error curves, stiffness models and contact modes, compared with their definitions.

use std::f64::consts::{PI, TAU};

use crate::common::COORDINATES;
use gearbow::mesh::stiffness::{CONTACT_COMPLIANCE, PeriodicCurve, Stiffness, Tooth, ToothPair, UniformCurve, iso6336};
use gearbow::mesh::{Contact, ContactMode, ContactPath, Flank, GearMesh, Geometry, MeshPose, ShaftPhase};
use gearbow::scene::{Engagement, Gear, Relief, Scene};
use nalgebra::{Matrix6, Vector6};
use proptest::prelude::*;

const TEETH: [f64; 2] = [25.0, 50.0];
const WIDTH: f64 = 0.03;
const AT_REST: [f64; 6] = [0.0; 6];

/// The scene of one mesh. `of_driver` and `of_driven` add fields to the gears; `mesh` gives the fields of the mesh.
fn scene(of_driver: &str, of_driven: &str, mesh: &str) -> Scene {
    let [a, b] = TEETH;
    let gear = |teeth: f64, more: &str| format!("teeth = {teeth}, module = 3e-3{more}");
    let mesh = format!("centre_line_angle = 0.4, {mesh}");
    crate::common::scene_of_mesh([&gear(a, of_driver), &gear(b, of_driven)], &mesh)
}

fn gear_mesh(mesh: &str) -> GearMesh {
    let scene = scene("", "", mesh);
    GearMesh::new(&scene.meshes[0], &scene.gears, COORDINATES)
}

/// Phases of two stationary shafts at the given angles, rad.
fn standing(angles: [f64; 2]) -> [ShaftPhase; 2] {
    angles.map(|angle| ShaftPhase { angle, spin: 0.0 })
}

/// Phases of the shafts after the fraction `part` of a mesh cycle.
fn at_part(part: f64) -> [ShaftPhase; 2] {
    standing([part * TAU / TEETH[0], -part * TAU / TEETH[1]])
}

/// Pose of the mesh in frozen geometry.
fn frozen<'a>(
    gear_mesh: &GearMesh,
    sigma: f64,
    turning: &'a [ShaftPhase; 2],
    q: &[f64; 6],
    v: &[f64; 6],
) -> MeshPose<'a> {
    gear_mesh.pose(Geometry::Frozen, sigma, turning, q, v)
}

fn touch(
    gear_mesh: &GearMesh,
    contact_mode: &ContactMode,
    turning: &[ShaftPhase; 2],
    q: &[f64; 6],
    v: &[f64; 6],
) -> Contact {
    gear_mesh.contact(&frozen(gear_mesh, 1.0, turning, q, v), contact_mode).unwrap()
}

/// The contact mode at this position, with the flank replaced by `flank`.
fn contact_mode(gear_mesh: &GearMesh, turning: &[ShaftPhase; 2], q: &[f64; 6], flank: Flank) -> ContactMode {
    ContactMode { flank, ..gear_mesh.contact_mode(&frozen(gear_mesh, 1.0, turning, q, &AT_REST)).unwrap() }
}

/// Rise of a cubic piece and its second derivatives at both ends, computed from its quadratic slope.
fn bends(at: impl Fn(f64) -> (f64, f64), start: f64, spacing: f64) -> (f64, [f64; 2]) {
    let [first, middle, last] = [0.25, 0.5, 0.75].map(|part| at(start + part * spacing).1);
    // Milne's rule is exact for a cubic. The parabola through three points gives the second derivatives.
    let rise = spacing * (2.0 * first - middle + 2.0 * last) / 3.0;
    let (slope, half) = (2.0 * (last - first), 8.0 * (first - 2.0 * middle + last));
    (rise, [slope - half, slope + half].map(|bend| bend / spacing))
}

proptest! {
    #![proptest_config(crate::common::cases(100))]

    #[test]
    fn a_curve_is_the_natural_spline_through_its_values(
        values in prop::collection::vec(-1.0..1.0_f64, 2..12), start in -2.0..2.0_f64, spacing in 0.1..3.0_f64,
        factor in -2.0..2.0_f64,
    ) {
        let curve = UniformCurve::new(start, spacing, &values);
        let at = |x: f64| curve.at(x);
        let last = values.len() - 1;
        // The values are of order one. Each second derivative, times the square of the spacing, has an error of 1e-12.
        let mut bend = 0.0;
        for i in 0..last {
            let begin = start + i as f64 * spacing;
            prop_assert!((at(begin + 1e-12).0 - values[i]).abs() < 1e-9);
            let (rise, [left, right]) = bends(at, begin, spacing);
            prop_assert!((rise - (values[i + 1] - values[i])).abs() < 1e-12);
            prop_assert!((left - bend).abs() < 1e-10 / (spacing * spacing), "{left} after {bend} at {i}");
            bend = right;
        }
        prop_assert!(bend.abs() < 1e-10 / (spacing * spacing), "{bend} at the end");
        prop_assert_eq!(at(start - 1.0), (values[0], 0.0));
        prop_assert_eq!(at(start + (last as f64 + 1.0) * spacing), (values[last], 0.0));
        let scaled = curve.clone().scaled(factor);
        let (x, (value, slope)) = (start + 0.3 * spacing, at(start + 0.3 * spacing));
        prop_assert!((scaled.at(x).0 - factor * value).abs() < 1e-13);
        prop_assert!((scaled.at(x).1 - factor * slope).abs() < 1e-12);
    }

    #[test]
    fn a_table_is_the_periodic_spline_through_its_values(
        values in prop::collection::vec(0.0..1.0_f64, 3..12), turns in -5..5_i32,
    ) {
        let cycle = PeriodicCurve::table(&values);
        let n = values.len();
        let spacing = 1.0 / n as f64;
        let at = |x: f64| cycle.at(x + f64::from(turns));
        let pieces: Vec<_> = (0..n).map(|i| bends(at, i as f64 * spacing, spacing)).collect();
        for (i, value) in values.iter().enumerate() {
            let next = (i + 1) % n;
            prop_assert!((at((i as f64 + 0.5) * spacing - spacing / 2.0).0 - value).abs() < 1e-12);
            prop_assert!((pieces[i].0 - (values[next] - value)).abs() < 1e-12);
            // Second derivatives are of order n², because the values are of order one.
            prop_assert!((pieces[i].1[1] - pieces[next].1[0]).abs() < 1e-10 * (n * n) as f64);
        }
        // Simpson's rule is exact on every piece.
        let middle = |i: usize| at((i as f64 + 0.5) * spacing).0;
        let mean: f64 = (0..n).map(|i| (values[i] + 4.0 * middle(i) + values[(i + 1) % n]) * spacing / 6.0).sum();
        prop_assert!((cycle.mean() - mean).abs() < 1e-12);
    }
}

#[test]
fn a_harmonic_oscillates_about_its_mean() {
    let cycle = PeriodicCurve::Fourier(3.0, vec![[1.0, 0.0]]);
    assert_eq!((cycle.mean(), cycle.largest()), (3.0, 4.0));
    assert!((cycle.smallest() - 2.0).abs() < 1e-15);
}

#[test]
fn every_error_rotates_with_its_own_shaft() {
    let harmonics = gear_mesh(
        "stiffness = 3e8, error = { tooth = [[5e-6, 0.4], [1e-6, 1.0]], driver = [[8e-6, 0.2]], driven = [[6e-6, -0.7]] }",
    );
    let values = [3e-6, -1e-6, 4e-6, 2e-6];
    let table = gear_mesh("stiffness = 3e8, error = { table = [3e-6, -1e-6, 4e-6, 2e-6] }");
    let off = |gear_mesh: &GearMesh, angles: [f64; 2]| {
        -touch(gear_mesh, &ContactMode::ALWAYS, &standing(angles), &AT_REST, &AT_REST).deflection
    };
    // The angles do not satisfy the gear ratio, so each harmonic depends on its own shaft.
    for [a, b] in [[0.3, 0.9], [-1.7, 0.2], [40.0, -3.0]] {
        let teeth = 5e-6 * (TEETH[0] * a + 0.4).cos() + 1e-6 * (2.0 * TEETH[0] * a + 1.0).cos();
        let expected = teeth + 8e-6 * (a + 0.2).cos() + 6e-6 * (b - 0.7).cos();
        // The tolerance is the round-off of the cosine of an angle of 2000 rad.
        assert!((off(&harmonics, [a, b]) - expected).abs() < 1e-17, "{:e} {expected:e}", off(&harmonics, [a, b]));
        for (i, value) in values.iter().enumerate() {
            let part = 7.0 + i as f64 / values.len() as f64;
            assert!((off(&table, [part * TAU / TEETH[0], b]) - value).abs() < 1e-17);
        }
    }
}

#[test]
fn runout_shifts_the_centres_of_a_constant_mesh_too() {
    let scene = scene(", runout = [2e-5, 1e-5]", ", runout = [0.0, -3e-5]", "stiffness = 3e8");
    let gear_mesh = GearMesh::new(&scene.meshes[0], &scene.gears, COORDINATES);
    let turned = |[y, z]: [f64; 2], angle: f64| {
        let (sin, cos) = angle.sin_cos();
        [cos * y - sin * z, sin * y + cos * z]
    };
    for angles in [[0.0, 0.0], [0.4, -0.2], [2.0, 5.0]] {
        let ([ay, az], [by, bz]) = (turned([2e-5, 1e-5], angles[0]), turned([0.0, -3e-5], angles[1]));
        let [ny, nz] = gear_mesh.directions_at_rest(1.0).normal;
        let found = touch(&gear_mesh, &ContactMode::ALWAYS, &standing(angles), &AT_REST, &AT_REST).deflection;
        assert!((found + ny * (by - ay) + nz * (bz - az)).abs() < 1e-18, "{found:e}");
    }
    assert!(gear_mesh.engagement_follows_motion() && gear_mesh.has_runout());
}

#[test]
fn a_damping_ratio_is_that_of_the_two_gears_on_their_mesh() {
    let scene = scene("", "", "stiffness = 3e8, damping_ratio = 0.07");
    let gear_mesh = GearMesh::new(&scene.meshes[0], &scene.gears, COORDINATES);
    // The relative oscillation of the gears is δ̈ + c/m δ̇ + k/m δ = 0, where 1/m is the acceleration of δ per unit
    // force.
    let yields: f64 = scene.gears.iter().map(|gear| gear.base_radius.powi(2) / gear.body.polar_inertia).sum();
    let (frequency, decay) = ((3e8 * yields).sqrt(), gear_mesh.damping * yields / 2.0);
    assert!((decay / frequency - 0.07).abs() < 1e-15);
}

/// Stiffness models that do not depend on the load, as TOML fields of a mesh.
const STIFFNESSES: [&str; 10] = [
    "stiffness = 3e8",
    r#"stiffness = { model = "square", pair = 2e8, engagement = "sharp" }"#,
    r#"stiffness = { model = "square", pair = 2e8, engagement = 0.3 }"#,
    r#"stiffness = { model = "parabolic", mean = 2e8, end_ratio = 0.5, engagement = "sharp" }"#,
    r#"stiffness = { model = "parabolic", pair = 2e8, end_ratio = 0.5, engagement = 0.5 }"#,
    r#"stiffness = { model = "potential_energy", engagement = 0.2 }"#,
    r#"stiffness = { model = "potential_energy", engagement = 0.2, foundation = "shared" }"#,
    r#"stiffness = { model = "potential_energy", engagement = "sharp", foundation = "shared" }"#,
    r#"stiffness = { model = "fourier", mean = 3e8, amplitudes = [4e7, 1e7], phases = [0.3, -1.0] }"#,
    r#"stiffness = { model = "table", values = [3e8, 2e8, 5e8, 4e8] }"#,
];

#[test]
fn the_mean_and_the_bound_are_those_of_the_cycle() {
    const PARTS: usize = 4000;
    for stiffness in STIFFNESSES {
        let gear_mesh = gear_mesh(&format!("backlash = 1e-5, {stiffness}"));
        let (mut sum, mut largest) = (0.0, 0.0_f64);
        for i in 0..PARTS {
            let turning = at_part((i as f64 + 0.5) / PARTS as f64);
            let contact_mode = |flank: Flank| contact_mode(&gear_mesh, &turning, &AT_REST, flank);
            sum += touch(&gear_mesh, &contact_mode(Flank::Drive), &turning, &AT_REST, &AT_REST).stiffness;
            largest =
                largest.max(touch(&gear_mesh, &contact_mode(Flank::Both), &turning, &AT_REST, &AT_REST).stiffness);
        }
        // Two ends of contact fall between the sample points. A smooth stiffness has a mean accurate to 1e-8, although
        // its ramps have jumps in the second derivative.
        let off = (sum / PARTS as f64 / gear_mesh.stiffness - 1.0).abs();
        let sharp = gear_mesh.teeth.is_sharp();
        assert!(off < if sharp { 2.0 / PARTS as f64 } else { 1e-8 }, "{off:e} of {stiffness}");
        assert!(
            largest <= gear_mesh.largest_stiffness * (1.0 + 1e-12),
            "{largest:e} {:e} of {stiffness}",
            gear_mesh.largest_stiffness
        );
    }
}

#[test]
fn means_have_their_closed_forms() {
    let ratio = |gear_mesh: &GearMesh| gear_mesh.involute.centres([0.0; 2]).unwrap().contact_ratio;
    for engagement in [r#""sharp""#, "0.1", "0.5"] {
        let of = |model: &str| gear_mesh(&format!("stiffness = {{ {model}, engagement = {engagement} }}"));
        // The ramp is symmetric about the end of the path, so the mean number of loaded pairs does not change.
        let square = of(r#"model = "square", pair = 2e8"#);
        assert!((square.stiffness / (2e8 * ratio(&square)) - 1.0).abs() < 1e-9, "{engagement}");
        for model in ["square", "parabolic"] {
            let given = of(&format!(r#"model = "{model}", mean = 2e8"#));
            assert!((given.stiffness / 2e8 - 1.0).abs() < 1e-14, "{engagement}");
        }
    }
    let parabolic =
        gear_mesh(r#"stiffness = { model = "parabolic", pair = 2e8, end_ratio = 0.4, engagement = "sharp" }"#);
    // The mean of a parabola is one third of its end value plus two thirds of its middle value.
    assert!((parabolic.stiffness / (2e8 * ratio(&parabolic) * 2.4 / 3.0) - 1.0).abs() < 1e-12);
    let ContactPath { tangent, low, high, .. } = parabolic.involute.path_at_rest();
    let Stiffness::Pairs { pair, .. } = &parabolic.teeth else { unreachable!() };
    let at = |part: f64| pair.at(low + part * (high - low), tangent)[0];
    for (part, expected) in [(0.0, 0.8e8), (0.5, 2e8), (1.0, 0.8e8)] {
        assert!((at(part) / expected - 1.0).abs() < 1e-14);
    }
    // Far beyond the ends of the path the pair stiffness is zero and does not become negative.
    assert_eq!((at(-1.0), at(2.0)), (0.0, 0.0));
}

#[test]
fn iso_6336_has_the_coefficients_of_the_standard() {
    let scene = scene("", "", "stiffness = 3e8");
    let gear = |teeth: u32, shift: f64| {
        let mut gear = scene.gears[0].clone();
        (gear.teeth, gear.profile_shift) = (teeth, shift);
        gear
    };
    let at = |[za, zb]: [u32; 2], [xa, xb]: [f64; 2]| iso6336(&gear(za, xa), &gear(zb, xb), 1.0).flexibility;
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    // q' = C1 + C2/z₁ + C3/z₂ + C4 x₁ + C5 x₁/z₁ + C6 x₂ + C7 x₂/z₂ + C8 x₁² + C9 x₂², one coefficient at a time.
    let standard = [0.047_23, 0.155_51, 0.257_91, -0.006_35, -0.116_54, -0.001_93, -0.241_88, 0.005_29, 0.001_82];
    let none = [0.0; 2];
    let by_teeth = |few: f64, many: f64| (few - many) * 20.0;
    close(by_teeth(at([10, 40], none), at([20, 40], none)), standard[1]);
    close(by_teeth(at([40, 10], none), at([40, 20], none)), standard[2]);
    close(2.0 * at([80, 80], none) - at([40, 40], none), standard[0]);
    let odd = |teeth: [u32; 2], x: [f64; 2]| (at(teeth, x) - at(teeth, x.map(|x| -x))) / 2.0;
    let even = |x: [f64; 2]| (at([20, 30], x) + at([20, 30], x.map(|x| -x))) / 2.0 - at([20, 30], none);
    let (first, second) = ([1.0, 0.0], [0.0, 1.0]);
    close(by_teeth(odd([10, 40], first), odd([20, 40], first)), standard[4]);
    close(2.0 * odd([20, 40], first) - odd([10, 40], first), standard[3]);
    close(by_teeth(odd([40, 10], second), odd([40, 20], second)), standard[6]);
    close(2.0 * odd([40, 20], second) - odd([40, 10], second), standard[5]);
    close(even(first), standard[7]);
    close(even(second), standard[8]);

    // With a contact ratio of one, the mesh stiffness equals the pair stiffness. Each further unit of contact ratio
    // adds three quarters of the pair stiffness to c_γ.
    let [one, two] = [1.0, 2.0].map(|ratio| iso6336(&gear(25, 0.0), &gear(50, 0.0), ratio));
    assert!((one.mesh / one.single - 1.0).abs() < 1e-15 && (two.mesh / two.single - 1.75).abs() < 1e-15);
    assert!((one.single * one.flexibility / 0.8e9 - 1.0).abs() < 1e-15);
    // A mesh without a given stiffness has that of the standard, times its face width.
    let gear_mesh = gear_mesh("damping = 0.0");
    let ratio = gear_mesh.involute.centres([0.0; 2]).unwrap().contact_ratio;
    let expected = WIDTH * iso6336(&scene.gears[0], &scene.gears[1], ratio).mesh;
    assert!((gear_mesh.stiffness / expected - 1.0).abs() < 1e-14);
}

/// Compliance per face width of a tooth of standard steel, loaded at the distance `rolling_displacement` from its base
/// point. The tooth is a cantilever of thin slices with the textbook thickness s_r = 2r[s/(2r_p) + inv α − inv α_r] at
/// each radius. Fillet and gear body follow Sainsot, Velex and Duverger (2004).
fn compliance(gear: &Gear, bore: f64, rolling_displacement: f64) -> f64 {
    const SLICES: u32 = 4000;
    let (e, g) = (207e9, 207e9 / 2.6);
    let involute = |angle: f64| angle.tan() - angle;
    let (base, root) = (gear.base_radius, gear.pitch_radius - gear.module * (1.25 - gear.profile_shift));
    let alpha = gear.pressure_angle;
    let thickness = gear.module * (PI / 2.0 + 2.0 * gear.profile_shift * alpha.tan());
    let pressure = |r: f64| (base / r).min(1.0).acos();
    let half = |r: f64| thickness / (2.0 * gear.pitch_radius) + involute(alpha) - involute(pressure(r));
    let place = |r: f64| (r * half(r).cos(), r * half(r).sin());
    let touched = rolling_displacement.hypot(base);
    let (height, side) = place(touched);
    // The force is inclined to the axis of the tooth by the angle of the flank normal at this point.
    let (sin, cos) = (pressure(touched) - half(touched)).sin_cos();
    let slice = |x: f64, h: f64| {
        let moment = cos * (height - x) - sin * side;
        moment * moment * 12.0 / (e * (2.0 * h).powi(3)) + (1.2 * cos * cos / g + sin * sin / e) / (2.0 * h)
    };
    let sum = |from: f64, to: f64, place: &dyn Fn(f64) -> (f64, f64)| -> f64 {
        let at = |i: f64| place(from + (to - from) * i / f64::from(SLICES));
        (0..SLICES)
            .map(|i| {
                let (x, h) = at(f64::from(i) + 0.5);
                slice(x, h) * (at(f64::from(i) + 1.0).0 - at(f64::from(i)).0)
            })
            .sum()
    };
    let lowest = base.max(root);
    let (foot, width) = place(base);
    let stub = if root < foot { sum(root, foot, &|x| (x, width)) } else { 0.0 };
    let (theta, h) = (half(lowest), root / bore);
    let [l, m, p, q] = [
        [-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045],
        [60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086],
        [-50.952e-5, 185.50e-3, 0.0538e-4, 53.3e-3, 0.2895, 0.9236],
        [-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904],
    ]
    .map(|[a, b, c, d, e, f]| a / theta.powi(2) + b * h * h + c * h / theta + d / theta + e * h + f);
    let reach = (height - side * sin / cos - root) / (2.0 * theta * root);
    let body = (cos * cos * (l * reach * reach + m * reach + p) + p * q * sin * sin) / e;
    sum(lowest, touched, &place) + stub + body
}

#[test]
fn a_tooth_is_a_cantilever_with_the_textbook_thickness() {
    // Root circles inside and outside the base circle, with and without profile shift.
    let scene = scene("", "", "stiffness = 3e8");
    for (teeth, profile_shift) in [(25, 0.0), (60, 0.0), (20, 0.4), (45, -0.3), (30, 0.5)] {
        let mut gear = scene.gears[0].clone();
        (gear.teeth, gear.profile_shift) = (teeth, profile_shift);
        gear.pitch_radius = gear.module * f64::from(teeth) / 2.0;
        gear.base_radius = gear.pitch_radius * gear.pressure_angle.cos();
        let Gear { base_radius, pitch_radius, .. } = gear;
        let reach = |radius: f64| (radius * radius - base_radius * base_radius).max(0.0).sqrt();
        let (root, tip) = (reach(gear.root_radius()), reach(pitch_radius + gear.module * (1.0 + profile_shift)));
        for part in [0.2, 0.6, 1.0] {
            let rolling_displacement = root + part * (tip - root);
            let (found, expected) = (
                Tooth::new(&gear, 0.015).compliance(rolling_displacement),
                compliance(&gear, 0.015, rolling_displacement),
            );
            // The relative slice thickness is 1/4000, and the error is of second order in it.
            assert!((found / expected - 1.0).abs() < 1e-5, "{teeth} {profile_shift} {part}: {}", found / expected);
        }
    }
}

#[test]
fn pair_compliance_is_the_sum_of_both_teeth_and_their_contact() {
    let bores = [0.012, 0.03];
    let mesh = r#"stiffness = { model = "potential_energy", engagement = 0.2, bore_radii = [0.012, 0.03] }"#;
    let scene = scene("", "", mesh);
    let gear_mesh = GearMesh::new(&scene.meshes[0], &scene.gears, COORDINATES);
    let teeth = [0, 1].map(|i| Tooth::new(&scene.gears[i], bores[i]));
    let Stiffness::Pairs { pair, .. } = &gear_mesh.teeth else { unreachable!() };
    let (involute, gears) = (&gear_mesh.involute, &scene.gears);
    let half = 0.1 * involute.base_pitch;
    // The contact of the driver covers base circle to tip at any centre distance. The contact of the wheel begins at
    // its root circle, which is outside its base circle. A smooth engagement carries load beyond the tips, by half of
    // its width.
    for i in 0..=40 {
        let s = -half + (gears[0].tip_reach() + 2.0 * half) * f64::from(i) / 40.0;
        for j in 0..=10 {
            let (root, tip) = (gears[1].root_reach() + half, gears[1].tip_reach() + half);
            let tangent = s + root + (tip - root) * f64::from(j) / 10.0;
            let compliance = CONTACT_COMPLIANCE + teeth[0].compliance(s) + teeth[1].compliance(tangent - s);
            let off = pair.at(s, tangent)[0] * compliance / WIDTH - 1.0;
            // Interpolation error of a natural spline through 257 values. It is largest near the ends.
            assert!(off.abs() < 1e-6, "{off:e} at {i}, {j}");
        }
    }
}

/// A path of contact of `length` base pitches of 9 mm that begins at 4 mm. Pair 0 is at the fraction `place` of a pitch
/// from the beginning.
fn path(length: f64, place: f64) -> ContactPath {
    let high = 4e-3 + length * 9e-3;
    let (tangent, position) = (high + 1e-2, 4e-3 + place * 9e-3);
    ContactPath { position, tangent, low: 4e-3, high, limits: [0.0, tangent], pitch: 9e-3, overlap: 0.0 }
}

/// The same pairs after the length of the line of action increases by `by`. An end of the path moves with it if the tip
/// circle or the base circle of the driven gear determines that end.
fn opened(path: ContactPath, by: f64) -> ContactPath {
    let moved = |end: f64, follows: bool| if follows { end + by } else { end };
    let ContactPath { tangent, low, high, .. } = path;
    let (low, high) = (moved(low, low > 0.0), moved(high, high == tangent));
    ContactPath { tangent: tangent + by, limits: [0.0, tangent + by], low, high, ..path }
}

proptest! {
    #![proptest_config(crate::common::cases(200))]

    #[test]
    fn derivatives_of_the_stored_energy_are_the_reported_ones(
        length in 0.05..2.5_f64, place in 0.0..1.0_f64, width in 0.1..0.5_f64, relieved: bool, uniform: bool,
        begins_at_base: bool, ends_at_base: bool, deflection in 1e-6..1e-4_f64,
    ) {
        let pair = match uniform {
            true => ToothPair::Uniform(2e8),
            false => ToothPair::Parabolic { middle: 2e8, end_ratio: 0.5, centre: 8e-3, half_length: 1e-2 },
        };
        let relief = relieved.then_some(Relief { amount: 2e-5, length: 3e-3, exponent: 2 });
        let teeth = Stiffness::Pairs { pair, engagement: Engagement::Smooth(width), relief };
        let mut at = path(length, place);
        if begins_at_base {
            (at.position, at.high, at.tangent, at.low) = (at.position - 4e-3, at.high - 4e-3, at.tangent - 4e-3, 0.0);
        }
        if ends_at_base {
            at.tangent = at.high;
        }
        at.limits[1] = at.tangent;
        let stored = |at: ContactPath, deflection: f64| teeth.elastic_state(|| at, (0, 0), deflection);
        let here = stored(at, deflection);
        // On a short path the ramps overlap, so both ends affect a pair at the same time.
        let slope = |step: f64, moved: &dyn Fn(f64) -> f64| (moved(step) - moved(-step)) / (2.0 * step);
        let by_position =
            slope(1e-8, &|by| stored(ContactPath { position: at.position + by, ..at }, deflection).energy);
        let by_tangent = slope(1e-8, &|by| stored(opened(at, by), deflection).energy);
        let by_deflection = slope(1e-10, &|by| stored(at, deflection + by).energy);
        // Energies are at most one joule and change over millimetres. The force of a pair that just touches has a kink
        // within a difference step.
        let size = 4e8 * deflection * deflection / 1e-3;
        prop_assert!((here.by_position - by_position).abs() < 1e-4 * size, "{:e} {by_position:e}", here.by_position);
        prop_assert!((here.by_tangent - by_tangent).abs() < 1e-4 * size, "{:e} {by_tangent:e}", here.by_tangent);
        prop_assert!((here.force - by_deflection).abs() < 1e-4 * 4e8 * deflection);
    }
}

#[test]
fn derivatives_with_shared_bodies_are_the_reported_ones() {
    let gear_mesh = gear_mesh(r#"stiffness = { model = "potential_energy", engagement = 0.3, foundation = "shared" }"#);
    let at_rest = gear_mesh.involute.path_at_rest();
    // The centre distance at rest, and two smaller ones at which the tips of the wheel, or of both gears, reach beyond
    // the base circles.
    for tangent in [at_rest.tangent, 0.030, 0.018] {
        let path = gear_mesh.involute.path(tangent);
        for i in 0..50 {
            let energy = |position: f64, by: f64| {
                let path = ContactPath { position, ..gear_mesh.involute.path(tangent + by) };
                gear_mesh.teeth.elastic_state(|| path, (0, 0), 1e-5)
            };
            let position = path.pitch * f64::from(i) / 50.0;
            let here = energy(position, 0.0);
            let slope = |moved: &dyn Fn(f64) -> f64| (moved(1e-8) - moved(-1e-8)) / 2e-8;
            let by_position = slope(&|by| energy(position + by, 0.0).energy);
            let by_tangent = slope(&|by| energy(position, by).energy);
            let size = 1e-4 * here.energy / 1e-3;
            assert!((here.by_position - by_position).abs() < size, "{:e} {by_position:e} at {i}", here.by_position);
            assert!((here.by_tangent - by_tangent).abs() < size, "{:e} {by_tangent:e} at {i}", here.by_tangent);
            assert!(here.stiffness > 0.0);
        }
    }
}

#[test]
fn the_stiffness_counts_the_pairs_in_contact() {
    let sharp = |relief: Option<Relief>| Stiffness::Pairs {
        pair: ToothPair::Uniform(2e8),
        engagement: Engagement::Sharp,
        relief,
    };
    for (engaged, pairs) in [((0, -1), 0.0), ((3, 3), 1.0), ((-2, 1), 4.0)] {
        let found = sharp(None).elastic_state(|| path(1.5, 0.2), engaged, 1e-5);
        assert_eq!((found.force, found.stiffness), (pairs * (2e8 * 1e-5), pairs * 2e8));
        assert!((found.energy - pairs * 2e8 * 1e-10 / 2.0).abs() < 1e-17);
    }
    // Halfway along a linear tip relief, the flank is relieved by half of the amount.
    let relief = Relief { amount: 8e-6, length: 1.8e-3, exponent: 1 };
    for place in [0.1, 0.8] {
        let [light, loaded] =
            [3e-6, 1e-5].map(|deflection| sharp(Some(relief)).elastic_state(|| path(0.9, place), (0, 0), deflection));
        assert_eq!((light.force, light.stiffness), (0.0, 0.0));
        assert!((loaded.force - 2e8 * (1e-5 - 4e-6)).abs() < 1e-9, "{}", loaded.force);
    }
    // At the end of the path a pair has half of its stiffness.
    let smooth = Stiffness::Pairs { pair: ToothPair::Uniform(2e8), engagement: Engagement::Smooth(0.2), relief: None };
    for place in [0.0, 0.7] {
        assert!((smooth.elastic_state(|| path(0.7, place), (0, 0), 1e-5).stiffness - 1e8).abs() < 1.0);
    }
}

#[test]
fn the_back_flank_is_one_tooth_thickness_behind_the_drive_flank() {
    // The tooth thickness on the pitch circle is m(π/2 + 2x tan α). The driver rotates by this arc between the passages
    // of the drive flank and the back flank through the pitch point.
    for shift in [0.0, 0.3, -0.2] {
        let [of_driver, of_driven] = [shift, -shift].map(|shift: f64| format!(", profile_shift = {shift}"));
        let scene = scene(&of_driver, &of_driven, "stiffness = 3e8");
        let gear_mesh = GearMesh::new(&scene.meshes[0], &scene.gears, COORDINATES);
        let gear = &scene.gears[0];
        let thickness = gear.module * (PI / 2.0 + 2.0 * shift * gear.pressure_angle.tan());
        let pitch_point = gear.base_radius * gear.pressure_angle.tan();
        for sigma in [-1.0, 1.0] {
            let beyond = |angle: f64, back: bool| {
                let turning = standing([angle, 0.0]);
                let path =
                    gear_mesh.engagement(&frozen(&gear_mesh, sigma, &turning, &AT_REST, &AT_REST), back).unwrap();
                (path.position - pitch_point) / path.pitch
            };
            let passes = -sigma * beyond(0.0, false) * TAU / TEETH[0];
            assert!(beyond(passes, false).abs() < 1e-13);
            let later = beyond(passes + sigma * thickness / gear.pitch_radius, true);
            assert!((later - later.round()).abs() < 1e-13, "{later} pitches beyond, {shift} {sigma}");
        }
    }
}

#[test]
fn only_pairs_of_the_loaded_flank_are_counted() {
    const PARTS: usize = 2000;
    let gear_mesh = gear_mesh(r#"backlash = 1e-5, stiffness = { model = "square", pair = 2e8, engagement = 0.1 }"#);
    let ratio = gear_mesh.involute.centres([0.0; 2]).unwrap().contact_ratio;
    for (flank, expected) in
        [(Flank::Drive, ratio), (Flank::Back, ratio), (Flank::Both, ratio), (Flank::Separated, 0.0)]
    {
        let mut sum = 0.0;
        for i in 0..PARTS {
            let turning = at_part((i as f64 + 0.5) / PARTS as f64);
            let contact_mode = contact_mode(&gear_mesh, &turning, &AT_REST, flank);
            let pose = frozen(&gear_mesh, 1.0, &turning, &AT_REST, &AT_REST);
            let state = gear_mesh.state(&pose, &contact_mode).unwrap();
            if flank != Flank::Separated {
                let path = gear_mesh.engagement(&pose, flank == Flank::Back).unwrap();
                let [low, high] = [path.low, path.high].map(|end| (end - path.position) / path.pitch);
                let between = (-20..20).filter(|j| low <= f64::from(*j) && f64::from(*j) <= high).count();
                assert_eq!(state.pairs_in_contact, between as f64, "{flank:?} at {i}");
            }
            sum += state.pairs_in_contact;
        }
        assert!((sum / PARTS as f64 - expected).abs() < 2.0 / PARTS as f64, "{flank:?}");
    }
}

#[test]
fn contact_lasts_while_the_force_is_compressive() {
    let (stiffness, damping, backlash) = (3e8, 2e3, 4e-5);
    let gear_mesh = gear_mesh("stiffness = 3e8, damping = 2e3, backlash = 4e-5");
    let radius = gear_mesh.involute.base_radius[1];
    let turning = at_part(0.3);
    // Only the twist of the driven gear produces the deflection of the drive flank and its rate.
    let moved = |value: f64| [0.0, 0.0, 0.0, 0.0, 0.0, value / radius];
    for (deflection, rate, expected) in [
        (1e-5, 0.0, Flank::Drive),
        (-1e-5, 0.0, Flank::Separated),
        (-5e-5, 0.0, Flank::Back),
        // While the flank opens, the damping force exceeds the spring force.
        (1e-6, -1.0, Flank::Separated),
        (-4.1e-5, 1.0, Flank::Separated),
        // A closing flank is in contact only after its deflection becomes positive.
        (-1e-6, 1.0, Flank::Separated),
    ] {
        let (q, v) = (moved(deflection), moved(rate));
        let contact_mode = gear_mesh.contact_mode(&frozen(&gear_mesh, 1.0, &turning, &q, &v)).unwrap();
        assert_eq!(contact_mode.flank, expected, "{deflection} {rate}");
        let contact = touch(&gear_mesh, &contact_mode, &turning, &q, &v);
        let force = match expected {
            Flank::Drive => stiffness * deflection + damping * rate,
            Flank::Back => stiffness * (deflection + backlash) + damping * rate,
            _ => 0.0,
        };
        assert!((contact.force - force).abs() < 1e-9, "{} {force}", contact.force);
        if expected != Flank::Back {
            // Separated flanks still report deflection and rate.
            assert!((contact.deflection - deflection).abs() < 1e-18 && (contact.rate - rate).abs() < 1e-14);
        }
    }
}

#[test]
fn a_mesh_reports_whether_it_switches_varies_or_follows_the_twist() {
    let of = |mesh: &str| {
        let gear_mesh = gear_mesh(mesh);
        (gear_mesh.switches(), gear_mesh.is_time_varying(), gear_mesh.engagement_follows_motion())
    };
    assert_eq!(of("stiffness = 3e8"), (false, false, false));
    assert_eq!(of("stiffness = 3e8, backlash = 1e-5"), (true, true, false));
    assert_eq!(of(r#"stiffness = { model = "square", pair = 2e8, engagement = "sharp" }"#), (true, true, false));
    assert_eq!(of(r#"stiffness = { model = "square", pair = 2e8 }"#), (false, true, false));
    assert_eq!(of(r#"stiffness = { model = "square", pair = 2e8, phase = "twist" }"#), (false, true, true));
}

proptest! {
    #![proptest_config(crate::common::cases(100))]

    #[test]
    fn the_mean_mesh_is_the_contact_of_a_constant_stiffness(
        numbers in prop::array::uniform6(-1.0..1.0_f64), live: bool, forward: bool,
    ) {
        let gear_mesh = gear_mesh("stiffness = 3e8, backlash = 4e-5");
        let geometry = if live { Geometry::Live } else { Geometry::Frozen };
        let sigma = if forward { 1.0 } else { -1.0 };
        let scales = Vector6::new(1e-4, 1e-4, 1e-4, 1e-4, 2e-3, 1e-3);
        let q = Vector6::from(numbers).component_mul(&scales);
        let turning = standing([0.0; 2]);
        let forces = |flank: Flank, q: &Vector6<f64>| {
            let contact_mode = ContactMode { flank, ..ContactMode::ALWAYS };
            let pose = gear_mesh.pose(geometry, sigma, &turning, q.as_slice(), &AT_REST);
            let contact = gear_mesh.contact(&pose, &contact_mode).unwrap();
            let mut forces = Vector6::zeros();
            gear_mesh.apply(&contact, forces.as_mut_slice());
            (contact, forces)
        };
        for (flank, sign) in [(Flank::Drive, 1.0), (Flank::Back, -1.0)] {
            let mut tangent = Matrix6::zeros();
            let add = |i: usize, j: usize, value: f64| tangent[(i, j)] += value;
            let (force, directions) = gear_mesh.mean_tangent(geometry, sigma, flank == Flank::Back, q.as_slice(), add).unwrap();
            let (contact, acting) = forces(flank, &q);
            // Forces are at most 1e5 N; the tolerance is their round-off.
            prop_assert!((force - sign * contact.force).abs() < 1e-9, "{force} {}", contact.force);
            let mut expected = Vector6::zeros();
            gear_mesh.gradient(sign * sigma, &directions, |index, slope| expected[index] -= force * slope);
            prop_assert!((acting - expected).amax() < 1e-9);
            // Differences with steps of 1e-6 m in stiffnesses of 3e8 N/m. Relative to centre distances of 0.1 m these
            // steps are 1e-5.
            for j in 0..6 {
                let mut ahead = Vector6::zeros();
                ahead[j] = 1e-6;
                let column = (forces(flank, &(q - ahead)).1 - forces(flank, &(q + ahead)).1) / 2e-6;
                prop_assert!((column - tangent.column(j)).amax() < 1e-6 * 3e8);
            }
        }

        let state = gear_mesh.state_at_rest(geometry, sigma, q.as_slice()).unwrap();
        let (drive, back) = (forces(Flank::Drive, &q).0, forces(Flank::Back, &q).0);
        prop_assert!((state.deflection - drive.deflection).abs() < 1e-17);
        // Both flanks are pressed if the centres are closer than the backlash allows. The pressed back flank has a negative
        // force.
        let expected = drive.force.max(0.0) + back.force.min(0.0);
        prop_assert!((state.force - expected).abs() < 1e-9, "{} {expected}", state.force);
    }
}
