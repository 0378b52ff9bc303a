//! Variable speed: its integral, and the equation of motion at a variable speed.

use crate::common::{Noise, cached, everything, train};
use gearbow::integrate::FirstOrderSystem as _;
use gearbow::mesh::Geometry;
use gearbow::motion::{Anchor, DoubleDouble, EquationOfMotion, Profile, ShaftRotation, Speed};
use nalgebra::DVector;
use num_complex::Complex64;

/// Continuous profile of cubic pieces between `breaks`, s, with the value `first` at the first break, rad/s. `rest`
/// holds the coefficients of τ, τ² and τ³ of each piece.
fn profile(breaks: &[f64], first: f64, rest: &[[f64; 3]]) -> Profile {
    let mut start = first;
    let mut coefficients = Vec::new();
    for (pair, [b, c, d]) in breaks.windows(2).zip(rest) {
        let t = pair[1] - pair[0];
        coefficients.push([start, *b, *c, *d]);
        start += t * (b + t * (c + t * d));
    }
    Profile::new(breaks.to_vec(), &coefficients).unwrap()
}

fn shaft_rotation(profile: Profile, origin: f64, end: f64) -> ShaftRotation {
    let speed = Speed::Changing(profile);
    ShaftRotation { fastest: speed.fastest(origin, end), speed, anchor: Anchor::default(), origin }
}

#[test]
fn the_angle_is_the_exact_integral() {
    // 12 + 6t + 3t² − 4t³ for 1 s, then 17 + 2τ for 2 s; all integrals are integers.
    let speed = Speed::Changing(profile(&[0.0, 1.0, 3.0], 12.0, &[[6.0, 3.0, -4.0], [2.0, 0.0, 0.0]]));
    assert_eq!(speed.angle_between(0.0, 1.0).high, 15.0);
    assert_eq!(speed.angle_between(0.0, 3.0).high, 15.0 + 38.0);
    assert_eq!(speed.angle_between(3.0, 0.0).high, -53.0);
    assert_eq!(speed.angle_between(-2.0, 0.0).high, 24.0, "constant before the first break");
    assert_eq!(speed.angle_between(3.0, 7.0).high, 84.0, "constant after the last break");
    assert_eq!((speed.at(-1.0), speed.at(0.5), speed.at(2.0), speed.at(9.0)), (12.0, 15.25, 19.0, 21.0));
    // 1/3 rad/s for one year: about 1e7 rad, where one ulp is 2e-9 rad.
    let (third, year) = (1.0 / 3.0, 31_557_600.0);
    let slow = Speed::Changing(profile(&[0.0, 1.0], third, &[[0.0; 3]]));
    assert_eq!(slow.angle_between(0.0, year + 0.5), DoubleDouble::product(third, year + 0.5));
    assert!(slow.angle_between(0.0, year + 0.5).low != 0.0);
}

#[test]
fn the_shaft_angle_does_not_depend_on_the_origin_of_time() {
    let cached = cached(&train());
    let n = cached.model.len();
    let pieces = profile(&[0.0, 0.5, 2.0], 40.0, &[[30.0, -20.0, 16.0], [-7.0, 5.0, -1.0]]);
    let speed = Speed::Changing(pieces.clone());
    for origin in [-1.0, 0.0, 0.3, 0.5, 1.7, 5.0] {
        let mut motion = EquationOfMotion::along(
            &cached,
            Geometry::Live,
            &shaft_rotation(pieces.clone(), origin, 9.0),
            DVector::zeros(n),
        );
        for time in [-1.0, 0.1, 0.5, 0.9, 1.9, 2.5, 8.0_f64].into_iter().filter(|time| *time >= origin) {
            let (elapsed, y, mut contact_modes) = (time - origin, vec![0.0; 2 * n], Vec::new());
            motion.contact_modes_at(elapsed, &y, &mut contact_modes).unwrap();
            motion.set_contact_modes(&contact_modes);
            for (index, shaft) in cached.model.shafts.iter().enumerate() {
                let expected = Complex64::from_polar(1.0, shaft.ratio * speed.angle_between(0.0, time).high);
                // Round-off of angles up to 400 rad.
                assert!((motion.phasor(index, elapsed) - expected).norm() < 1e-12, "{index} at {time} from {origin}");
            }
            let phases = motion.phases(0, elapsed);
            assert!((phases[0].spin - speed.at(time)).abs() < 1e-12 * speed.at(time));
            assert!((Complex64::from_polar(1.0, phases[0].angle) - motion.phasor(0, elapsed)).norm() < 1e-12);
        }
    }
}

#[test]
fn derivative_uses_the_current_spin_angle_and_angular_acceleration() {
    let cached = cached(&everything());
    let (model, n) = (&cached.model, cached.model.len());
    let pieces = profile(&[0.0, 0.25, 1.0], 150.0, &[[800.0, -900.0, 400.0], [300.0, 0.0, -100.0]]);
    let speed = Speed::Changing(pieces.clone());
    let origin = 0.1;
    let mut motion =
        EquationOfMotion::along(&cached, Geometry::Frozen, &shaft_rotation(pieces, origin, 2.0), DVector::zeros(n))
            .with_modal_damping(&cached)
            .unwrap();
    let mut noise = Noise::new(4);
    for time in [0.1, 0.2, 0.6, 1.5_f64] {
        let y = [noise.vector(n, 1e-4), noise.vector(n, 0.1)].concat();
        let (q, v) = y.split_at(n);
        let [q, v] = [q, v].map(DVector::from_column_slice);
        let (mut contact_modes, mut derivative) = (Vec::new(), vec![0.0; 2 * n]);
        motion.contact_modes_at(time - origin, &y, &mut contact_modes).unwrap();
        motion.set_contact_modes(&contact_modes);
        motion.derivative(time - origin, &y, &mut derivative).unwrap();
        let (now, angle) = (speed.at(time), speed.angle_between(0.0, time).high);
        let acceleration = match time {
            t if t < 0.25 => 800.0 - 1800.0 * t + 1200.0 * t * t,
            t if t < 1.0 => 300.0 - 300.0 * (t - 0.25) * (t - 0.25),
            _ => 0.0,
        };
        let mut force = model.constant_load.clone();
        for shaft in &model.shafts {
            let (spin, rate) = (shaft.ratio * now, shaft.ratio * acceleration);
            for excitation in &shaft.excitations {
                let amplitude = excitation.bow + excitation.unbalance * Complex64::new(spin * spin, -rate);
                let rotated = amplitude * Complex64::from_polar(1.0, shaft.ratio * angle);
                force[excitation.index] += rotated.re;
                force[excitation.index + 1] += rotated.im;
            }
        }
        let rate = cached.damping_matrix(now).unwrap() + model.gyroscopic_matrix() * now;
        let (mass, stiffness) = (model.mass_matrix(), model.stiffness_matrix(now));
        let a = DVector::from_column_slice(&derivative[n..]);
        let residual = &mass * &a + &rate * &v + &stiffness * &q - &force;
        let acting = mass.abs() * a.abs() + rate.abs() * v.abs() + stiffness.abs() * q.abs() + force.abs();
        // Backward error of each row: sums of twenty terms, and the factorization of M with the condition number 1e3.
        let largest = residual.abs().component_div(&acting).max();
        assert!(largest < 1e-12, "{largest:e} at {time} s");
    }
}

#[test]
fn the_largest_speed_is_found_within_pieces_and_keeps_its_sign() {
    // 27τ − τ³ has its maximum 54 at τ = 3.
    let speed = Speed::Changing(profile(&[0.0, 5.0, 6.0], 0.0, &[[27.0, 0.0, -1.0], [0.0; 3]]));
    assert_eq!(speed.fastest(0.0, 10.0), 54.0);
    // The result does not depend on the end of the run, so the step limits are the same in all parts of a run.
    assert_eq!(speed.fastest(0.0, 1.0), 54.0);
    let other = Speed::Changing(profile(&[0.0, 4.0], -3.0, &[[2.0, 0.0, 0.0]]));
    assert_eq!((other.fastest(0.0, 1.0), other.fastest(2.0, 3.0)), (-5.0, 5.0));
    let stopping = Speed::Changing(profile(&[0.0, 1.0], -8.0, &[[16.0, -8.0, 0.0]]));
    assert_eq!(stopping.fastest(0.0, 1.0), -8.0);
    // At rest after negative speed the loaded flanks are those of the negative speed.
    assert_eq!(stopping.fastest(1.0, 2.0), -8.0);
    assert_eq!(Speed::Constant(0.0).fastest(0.0, 1.0), 0.0);
}

#[test]
fn a_change_of_sign_is_an_error_that_names_the_time() {
    let speed = Speed::Changing(profile(&[0.0, 4.0], 3.0, &[[-2.0, 0.0, 0.0]]));
    for (start, end) in [(0.0, 1.5), (1.5, 4.0), (0.2, 1.0), (2.0, 9.0)] {
        speed.check(start, end).unwrap();
    }
    let error = speed.check(0.0, 4.0).unwrap_err();
    assert_eq!(error.path, "speed");
    assert!(error.message.contains("at 1.5 s"), "{error}");
    // A speed that touches zero without a change of sign is valid.
    let touching = Speed::Changing(profile(&[0.0, 2.0], 1.0, &[[-2.0, 1.0, 0.0]]));
    touching.check(0.0, 2.0).unwrap();
}

#[test]
fn an_invalid_profile_is_an_error() {
    let [one, two] = [[[1.0, 0.0, 0.0, 0.0]; 1].to_vec(), [[1.0, 0.0, 0.0, 0.0]; 2].to_vec()];
    let jump = vec![[1.0, 0.0, 0.0, 0.0], [1.1, 0.0, 0.0, 0.0]];
    let cases = [
        (vec![0.0], one.clone(), "needs 2 times for 1 pieces, got 1"),
        (vec![0.0, 0.0], one.clone(), "times must ascend, 0 s follows 0 s"),
        (vec![0.0, f64::NAN], one, "time 1 must be finite"),
        (vec![0.0, 1.0, 2.0], jump, "must not jump, goes from 1 to 1.1 rad/s at 1 s"),
        (vec![0.0, 1.0], vec![[1.0, f64::INFINITY, 0.0, 0.0]], "must be finite, and is not from 0 s on"),
    ];
    for (breaks, coefficients, text) in cases {
        let error = Profile::new(breaks, &coefficients).unwrap_err();
        assert!(error.to_string().starts_with("speed: ") && error.message.contains(text), "{error}");
    }
    Profile::new(vec![0.0, 1.0, 2.0], &two).unwrap();
}
