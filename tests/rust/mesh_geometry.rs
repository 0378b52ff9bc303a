//! The exact mesh deflection, compared with finite differences, closed forms and published numbers.

use std::f64::consts::PI;

use gearbow::mesh::{
    Centres, ContactMode, ContactPath, Directions, GearMesh, Geometry, Involute, LineOfAction, MeshPose, Overlap,
    ShaftPhase,
};
use nalgebra::{Matrix6, Vector6};
use proptest::prelude::*;

const STIFFNESS: f64 = 3e8;
const DAMPING: f64 = 2e3;

/// A gear pair: tooth numbers, module, m, centre-line angle, rad, and the relative excess of the centre distance over
/// the sum of the pitch radii.
#[derive(Clone, Copy, Debug)]
struct Pair {
    teeth: [u32; 2],
    module: f64,
    angle: f64,
    stretch: f64,
}

impl Pair {
    fn gear_mesh(self) -> GearMesh {
        let Self { teeth: [a, b], module, angle, stretch } = self;
        let distance = module * f64::from(a + b) / 2.0 * (1.0 + stretch);
        let gear = |teeth: u32| format!("teeth = {teeth}, module = {module}");
        let mesh = format!(
            "stiffness = {STIFFNESS:e}, damping = {DAMPING}, centre_line_angle = {angle}, centre_distance = {distance}"
        );
        crate::common::mesh([&gear(a), &gear(b)], &mesh)
    }

    fn centre_distance(self) -> f64 {
        self.module * f64::from(self.teeth[0] + self.teeth[1]) / 2.0 * (1.0 + self.stretch)
    }
}

const PLAIN: Pair = Pair { teeth: [25, 50], module: 3e-3, angle: 0.4, stretch: 0.0 };

fn pairs() -> impl Strategy<Value = Pair> {
    // The excess of the centre distance is less than one module, so gears with few teeth are also in contact.
    (12_u32..120, 12_u32..120, 1e-3..2e-2, -10.0..10.0, 0.0..0.9).prop_map(|(a, b, module, angle, opened)| Pair {
        teeth: [a, b],
        module,
        angle,
        stretch: 2.0 * opened / f64::from(a + b),
    })
}

fn sigmas() -> impl Strategy<Value = f64> {
    prop_oneof![Just(-1.0), Just(1.0)]
}

/// Displacements of at most 1e-3 of the centre distance, from six random numbers between −1 and 1.
fn displaced(pair: Pair, numbers: [f64; 6]) -> Vector6<f64> {
    let size = 1e-3 * pair.centre_distance();
    let radius = pair.centre_distance() / 2.0;
    Vector6::from(numbers).component_mul(&Vector6::new(size, size, size, size, size / radius, size / radius))
}

/// A contact and its line of action.
#[derive(Debug)]
struct Contact {
    deflection: f64,
    rate: f64,
    force: f64,
    normal: [f64; 2],
    tangent_direction: [f64; 2],
    tangent: f64,
}

/// Stationary shafts.
const STILL: [ShaftPhase; 2] = [ShaftPhase { angle: 0.0, spin: 0.0 }; 2];

fn touch(gear_mesh: &GearMesh, geometry: Geometry, sigma: f64, q: &[f64], v: &[f64]) -> Result<Contact, Overlap> {
    let found = gear_mesh.contact(&gear_mesh.pose(geometry, sigma, &STILL, q, v), &ContactMode::ALWAYS)?;
    let LineOfAction { normal, tangent_direction, tangent, .. } = match geometry {
        Geometry::Live => gear_mesh.involute.line_of_action(sigma, [q[2] - q[0], q[3] - q[1]])?,
        Geometry::Frozen => gear_mesh.involute.line_at_rest(sigma),
    };
    Ok(Contact {
        deflection: found.deflection,
        rate: found.rate,
        force: found.force,
        normal,
        tangent_direction,
        tangent,
    })
}

/// Live geometry at zero displacement.
fn still(gear_mesh: &GearMesh, sigma: f64, q: &Vector6<f64>) -> MeshPose<'static> {
    gear_mesh.pose(Geometry::Live, sigma, &STILL, q.as_slice(), &[0.0; 6])
}

fn at_rest(gear_mesh: &GearMesh, sigma: f64) -> Contact {
    touch(gear_mesh, Geometry::Frozen, sigma, &[0.0; 6], &[0.0; 6]).unwrap()
}

fn live(gear_mesh: &GearMesh, sigma: f64, q: &Vector6<f64>) -> Contact {
    touch(gear_mesh, Geometry::Live, sigma, q.as_slice(), &[0.0; 6]).unwrap()
}

fn gradient(gear_mesh: &GearMesh, sigma: f64, contact: &Contact) -> Vector6<f64> {
    let mut gradient = Vector6::zeros();
    let directions = Directions { normal: contact.normal, ..gear_mesh.directions_at_rest(sigma) };
    gear_mesh.gradient(sigma, &directions, |index, slope| gradient[index] += slope);
    gradient
}

/// Central differences of `value` along each coordinate with a step of 1e-5 of the centre distance. The relative error
/// is 1e-10 from the third derivative and 1e-11 from round-off.
fn differentiate<T>(pair: Pair, q: &Vector6<f64>, value: impl Fn(&Vector6<f64>) -> T) -> [T; 6]
where
    T: std::ops::Sub<Output = T> + std::ops::Div<f64, Output = T>,
{
    let step = 1e-5 * pair.centre_distance();
    std::array::from_fn(|index| {
        let step = if index < 4 { step } else { 1e-5 };
        let (mut ahead, mut back_flank_deflection) = (*q, *q);
        ahead[index] += step;
        back_flank_deflection[index] -= step;
        (value(&ahead) - value(&back_flank_deflection)) / (ahead[index] - back_flank_deflection[index])
    })
}

proptest! {
    #![proptest_config(crate::common::cases(300))]

    #[test]
    fn gradient_is_that_of_the_deflection(
        pair in pairs(), sigma in sigmas(), numbers in prop::array::uniform6(-1.0..1.0), rates in prop::array::uniform6(-1.0..1.0),
    ) {
        let (gear_mesh, q) = (pair.gear_mesh(), displaced(pair, numbers));
        let contact = live(&gear_mesh, sigma, &q);
        let found = gradient(&gear_mesh, sigma, &contact);
        let expected = differentiate(pair, &q, |q| live(&gear_mesh, sigma, q).deflection);
        for (found, expected) in found.iter().zip(expected) {
            prop_assert!((found - expected).abs() < 1e-8, "{found} {expected}");
        }
        let [y, z] = contact.normal;
        // n consists of the sine and cosine of one angle, each accurate to one ulp.
        prop_assert!((y.hypot(z) - 1.0).abs() < 1e-14);
        prop_assert!((y * contact.tangent_direction[0] + z * contact.tangent_direction[1]).abs() < 1e-14);
        prop_assert!((contact.tangent_direction[0].hypot(contact.tangent_direction[1]) - 1.0).abs() < 1e-14);

        let moving = touch(&gear_mesh, Geometry::Live, sigma, q.as_slice(), &rates).unwrap();
        prop_assert!((moving.rate - found.dot(&Vector6::from(rates))).abs() < 1e-14);
        let force = STIFFNESS * contact.deflection + DAMPING * moving.rate;
        prop_assert!((moving.force - force).abs() < 1e-15 * (STIFFNESS * contact.deflection.abs() + DAMPING * moving.rate.abs()) * 4.0);
    }

    #[test]
    fn tangent_is_the_derivative_of_the_force(
        pair in pairs(), sigma in sigmas(), numbers in prop::array::uniform6(-1.0..1.0),
    ) {
        let (gear_mesh, q) = (pair.gear_mesh(), displaced(pair, numbers));
        let contact = live(&gear_mesh, sigma, &q);
        let mut tangent = Matrix6::zeros();
        let add = |i: usize, j: usize, value: f64| tangent[(i, j)] += value;
        let (pressed, directions) = gear_mesh.mean_tangent(Geometry::Live, sigma, false, q.as_slice(), add).unwrap();
        prop_assert_eq!((pressed, directions.normal), (contact.force, contact.normal));
        let slopes = gradient(&gear_mesh, sigma, &contact);
        let curvature: Matrix6<f64> = tangent - STIFFNESS * slopes * slopes.transpose();
        let force = |q: &Vector6<f64>| {
            let contact = gear_mesh.contact(&still(&gear_mesh, sigma, q), &ContactMode::ALWAYS).unwrap();
            let mut force = Vector6::zeros();
            gear_mesh.apply(&contact, force.as_mut_slice());
            -force
        };
        let columns = differentiate(pair, &q, force);
        // Differences of the gradient at constant force give the effect of the rotating line of action, F ∂²δ/∂q².
        let turning = differentiate(pair, &q, |q| gradient(&gear_mesh, sigma, &live(&gear_mesh, sigma, q)) * contact.force);
        for j in 0..6 {
            prop_assert!((columns[j] - tangent.column(j)).amax() < 1e-8 * STIFFNESS);
            // ∂²δ/∂u² is 1/(C sin α), about 3/C.
            let scale = contact.force.abs() / contact.tangent;
            prop_assert!((turning[j] - curvature.column(j)).amax() < 1e-7 * scale + 1e-9);
        }
        prop_assert!((tangent - tangent.transpose()).amax() < 1e-15 * tangent.amax());
    }

    #[test]
    fn rotating_the_pair_about_a_gear_causes_no_deflection(pair in pairs(), sigma in sigmas(), turn in -3.0..3.0_f64) {
        let (gear_mesh, distance) = (pair.gear_mesh(), pair.centre_distance());
        let (sin, cos) = pair.angle.sin_cos();
        let (turned_sin, turned_cos) = (pair.angle + turn).sin_cos();
        let q = Vector6::new(0.0, 0.0, distance * (turned_cos - cos), distance * (turned_sin - sin), turn, turn);
        let contact = live(&gear_mesh, sigma, &q);
        // Round-off of the centre displacements, which this test computes.
        prop_assert!(contact.deflection.abs() < 1e-14 * distance, "{:e}", contact.deflection / distance);
        let state = gear_mesh.state(&still(&gear_mesh, sigma, &q), &ContactMode::ALWAYS).unwrap();
        prop_assert!((state.centres.distance - distance).abs() < 1e-14 * distance);
        prop_assert!((state.centres.angle - pair.angle - turn).abs() < 1e-13);
    }

    #[test]
    fn the_smallest_displacement_keeps_its_digits(
        pair in pairs(), sigma in sigmas(), numbers in prop::array::uniform6(-1.0..1.0), exponent in -300..-10,
    ) {
        let gear_mesh = pair.gear_mesh();
        let slopes = gradient(&gear_mesh, sigma, &at_rest(&gear_mesh, sigma));
        // A power of two, so that scaling is exact.
        let scale = 2.0_f64.powi(exponent * 3);
        let unit = displaced(pair, numbers) * 1e3;
        let found = live(&gear_mesh, sigma, &(unit * scale)).deflection;
        let terms = slopes.component_mul(&unit) * scale;
        // A few ulps of the terms, the neglected quadratic terms, and the smallest subnormal numbers.
        let allowed = 4e-15 * terms.abs().sum() + 20.0 * scale * scale * pair.centre_distance() + 1e-320;
        prop_assert!((found - terms.sum()).abs() <= allowed, "{found:e} {:e}", terms.sum());
    }

    #[test]
    fn frozen_is_the_linearisation_of_live(
        pair in pairs(), sigma in sigmas(), numbers in prop::array::uniform6(-1.0..1.0),
    ) {
        let (gear_mesh, q) = (pair.gear_mesh(), displaced(pair, numbers));
        let frozen = |q: &Vector6<f64>| touch(&gear_mesh, Geometry::Frozen, sigma, q.as_slice(), q.as_slice()).unwrap();
        let deflection = frozen(&q).deflection;
        let slopes = gradient(&gear_mesh, sigma, &at_rest(&gear_mesh, sigma));
        let terms = slopes.component_mul(&q);
        let round_off = 4e-15 * terms.abs().sum();
        prop_assert!((deflection - terms.sum()).abs() < round_off);
        prop_assert!((frozen(&q).rate - terms.sum()).abs() < round_off);
        prop_assert!((gear_mesh.deflection_at_rest(sigma, q.as_slice()) - deflection).abs() < round_off);
        prop_assert!((frozen(&(-3.0 * q)).force + 3.0 * frozen(&q).force).abs() < 1e-14 * (STIFFNESS + DAMPING) * terms.abs().sum());

        // To second order, live geometry adds −(m·u)²/(2 C sin α). The third-order term is smaller by 1e-3·C/(C sin α).
        let at_rest = at_rest(&gear_mesh, sigma);
        let tangent_direction = at_rest.tangent_direction[0] * (q[2] - q[0]) + at_rest.tangent_direction[1] * (q[3] - q[1]);
        let second = -tangent_direction * tangent_direction / (2.0 * at_rest.tangent);
        let third = 1e3 * (1e-3_f64).powi(3) * pair.centre_distance();
        let found = live(&gear_mesh, sigma, &q).deflection - deflection;
        prop_assert!((found - second).abs() < third, "{found:e} {second:e}");
    }

    #[test]
    fn reported_centres_are_the_positions_of_the_gears(pair in pairs(), numbers in prop::array::uniform6(-1.0..1.0)) {
        let (gear_mesh, q) = (pair.gear_mesh(), displaced(pair, numbers));
        let apart = [q[2] - q[0], q[3] - q[1]];
        let (sin, cos) = pair.angle.sin_cos();
        let [y, z] = [pair.centre_distance() * cos + apart[0], pair.centre_distance() * sin + apart[1]];
        let centres = gear_mesh.involute.centres(apart).unwrap();
        let sum: f64 = gear_mesh.involute.base_radius.iter().sum();
        prop_assert!((centres.distance - y.hypot(z)).abs() < 1e-14 * centres.distance);
        prop_assert!((centres.pressure_angle.cos() - sum / y.hypot(z)).abs() < 1e-14);
        // γ stays near ψ, even if ψ contains several revolutions.
        prop_assert!((centres.angle - pair.angle).abs() < 0.01);
        prop_assert!((centres.angle.cos() - y / centres.distance).abs() < 1e-13);
        let tips = pair.teeth.map(|z| pair.module * (f64::from(z) / 2.0 + 1.0));
        let reach = |tip: f64, base: f64| (tip * tip - base * base).sqrt();
        let [a, b] = gear_mesh.involute.base_radius;
        let segment = centres.distance * centres.pressure_angle.sin();
        // A tip circle cuts off at most the whole segment between the base circles.
        let path = reach(tips[0], a).min(segment) + reach(tips[1], b).min(segment) - segment;
        prop_assert!((centres.contact_ratio - path * f64::from(pair.teeth[0]) / (2.0 * PI * a)).abs() < 1e-11);
    }
}

#[test]
fn contact_ratios_are_the_published_ones() {
    let involute = |pair: Pair| pair.gear_mesh().involute;
    let wide = involute(Pair { teeth: [62, 62], module: 2e-3, ..PLAIN });
    // The sources print eight and six digits.
    assert!((wide.centres([0.0; 2]).unwrap().contact_ratio - 1.789_779_9).abs() < 5e-8);
    let plain = involute(PLAIN);
    assert!((plain.centres([0.0; 2]).unwrap().contact_ratio - 1.683_16).abs() < 5e-6);

    // Central differences along the centre distance: steps of 1e-6 m at 0.1 m, so the slopes are accurate to 1e-8.
    let along = |step: f64| {
        let (sin, cos) = PLAIN.angle.sin_cos();
        plain.centres([step * cos, step * sin]).unwrap()
    };
    let (ahead, back_flank_deflection) = (along(1e-6), along(-1e-6));
    let slope = (ahead.contact_ratio - back_flank_deflection.contact_ratio) / 2e-6;
    assert!((slope + 330.13).abs() < 0.005, "{slope}");
    let alpha = 20_f64.to_radians();
    let steeper = (ahead.pressure_angle - back_flank_deflection.pressure_angle) / 2e-6;
    let expected = 1.0 / (PLAIN.centre_distance() * alpha.tan());
    assert!((steeper - expected).abs() < 1e-7 * expected, "{steeper} {expected}");
}

fn pairs_in_contact(involute: &Involute, centres: &Centres, sigma: f64, turned: f64) -> f64 {
    let position = involute.position(sigma, turned, centres.angle, centres.pressure_angle);
    let path = involute.path(centres.distance * centres.pressure_angle.sin());
    let (first, last) = ContactPath { position, ..path }.engaged();
    (last - first + 1).max(0) as f64
}

/// Mean, minimum and maximum of the number of pairs in contact over one base pitch.
fn count(involute: &Involute, apart: [f64; 2], sigma: f64, teeth: u32) -> (f64, f64, f64) {
    let centres = involute.centres(apart).unwrap();
    let samples = 20_000;
    let pitch = 2.0 * PI / f64::from(teeth);
    let counts = (0..samples)
        .map(|i| pairs_in_contact(involute, &centres, sigma, 1.0 + pitch * f64::from(i) / f64::from(samples)));
    let fold = |(sum, least, most): (f64, f64, f64), count: f64| (sum + count, least.min(count), most.max(count));
    let (sum, least, most) = counts.fold((0.0, f64::INFINITY, 0.0), fold);
    (sum / f64::from(samples), least, most)
}

#[test]
fn tooth_pairs_share_the_path_of_contact() {
    // Contact ratios above 2, between 1 and 2, and below 1, where no pair is in contact for a fraction of the pitch.
    let involute = PLAIN.gear_mesh().involute;
    let (sin, cos) = PLAIN.angle.sin_cos();
    for sigma in [-1.0, 1.0] {
        for moved in [-8e-4, -2e-4, 0.0, 1e-3, 2.05e-3, 2.5e-3] {
            let apart = [moved * cos, moved * sin];
            let ratio = involute.centres(apart).unwrap().contact_ratio;
            let (mean, least, most) = count(&involute, apart, sigma, 25);
            // Two ends of contact fall between the sample points.
            assert!((mean - ratio).abs() < 2.0 / 20_000.0, "{mean} {ratio}");
            assert_eq!((least, most), (ratio.floor(), ratio.ceil()), "at a contact ratio of {ratio}");
        }
    }
    let parted = involute.centres([6e-3 * cos, 6e-3 * sin]).unwrap();
    assert!(parted.contact_ratio < 0.0);
    assert_eq!(pairs_in_contact(&involute, &parted, 1.0, 0.3), 0.0);
}

#[test]
fn reversed_rotation_mirrors_the_gear_pair() {
    // Mirrored at the line of centres, the gear pair with reversed rotation is the same gear pair.
    let gear_mesh = Pair { angle: 0.0, ..PLAIN }.gear_mesh();
    let q = Vector6::new(1e-4, -2e-4, -3e-5, 5e-5, 1e-3, 2e-3);
    let mirrored = Vector6::new(q[0], -q[1], q[2], -q[3], -q[4], -q[5]);
    let (forward, backward) = (live(&gear_mesh, 1.0, &q), live(&gear_mesh, -1.0, &mirrored));
    assert_eq!(forward.deflection, backward.deflection);
    assert_eq!(forward.normal, [backward.normal[0], -backward.normal[1]]);
    // A driver that rotates counter-clockwise pushes a driven gear on its right downwards. The reaction pushes the
    // driver upwards.
    assert!(forward.normal[1] > 0.0 && forward.normal[0] > 0.0);
}

#[test]
fn overlapping_base_circles_are_an_error() {
    let gear_mesh = PLAIN.gear_mesh();
    let (sin, cos) = PLAIN.angle.sin_cos();
    let sum: f64 = gear_mesh.involute.base_radius.iter().sum();
    let to = |distance: f64| {
        let moved = distance - PLAIN.centre_distance();
        Vector6::new(0.0, 0.0, moved * cos, moved * sin, 0.0, 0.0)
    };
    let apart = |q: &Vector6<f64>| touch(&gear_mesh, Geometry::Live, 1.0, q.as_slice(), &[0.0; 6]);
    assert!(apart(&to(sum * (1.0 + 1e-9))).is_ok());
    let overlap = apart(&to(sum * (1.0 - 1e-9))).unwrap_err();
    assert!((overlap.distance - sum).abs() < 2e-9 * sum && (overlap.base_circles - sum).abs() < 1e-15);
    assert!(apart(&to(0.0)).unwrap_err().distance.abs() < 1e-9);
    // Frozen geometry has no such limit. The integrator reports a NaN.
    assert!(touch(&gear_mesh, Geometry::Frozen, 1.0, to(0.0).as_slice(), &[0.0; 6]).is_ok());
    assert!(apart(&Vector6::repeat(f64::NAN)).is_ok_and(|contact| contact.force.is_nan()));
}
