//! Quadrature rules on [0, 1] that integrate powers over a step.
//!
//! The rules of five and more points extend the Lobatto rule of three points as Patterson (1968) extends Gauss rules: each
//! contains the points of the one before, has positive weights, and integrates polynomials up to the degree 7, 13 or 25.

/// Abscissae and weights of the three-point Gauss rule.
pub const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Number of nested rules.
pub const NESTED_RULES: usize = 4;

/// Number of points of each nested rule.
pub const POINTS: [usize; NESTED_RULES] = [3, 5, 9, 17];

/// Abscissae, and the weights of each nested rule. The first two abscissae are the ends.
pub const NESTED: [(f64, [f64; NESTED_RULES]); 17] = [
    (0.0, [0.166_666_666_666_666_66, 0.05, 0.015_321_869_488_536_154, 0.004_665_703_519_874_249]),
    (1.0, [0.166_666_666_666_666_66, 0.05, 0.015_321_869_488_536_154, 0.004_665_703_519_874_249]),
    (0.5, [0.666_666_666_666_666_6, 0.355_555_555_555_555_57, 0.171_881_043_605_181_53, 0.079_443_959_392_825_36]),
    (0.172_673_164_646_011_43, [0.0, 0.272_222_222_222_222_2, 0.141_989_389_024_060_55, 0.067_801_437_802_545_29]),
    (0.827_326_835_353_988_5, [0.0, 0.272_222_222_222_222_2, 0.141_989_389_024_060_55, 0.067_801_437_802_545_29]),
    (0.054_797_236_243_665_61, [0.0, 0.0, 0.089_631_349_776_603_68, 0.046_990_759_114_075_11]),
    (0.945_202_763_756_334_4, [0.0, 0.0, 0.089_631_349_776_603_68, 0.046_990_759_114_075_11]),
    (0.329_508_867_044_503_5, [0.0, 0.0, 0.167_116_869_908_208_84, 0.088_082_559_871_010_55]),
    (0.670_491_132_955_496_4, [0.0, 0.0, 0.167_116_869_908_208_84, 0.088_082_559_871_010_55]),
    (0.016_900_068_453_146_073, [0.0, 0.0, 0.0, 0.028_000_190_391_696_65]),
    (0.983_099_931_546_853_9, [0.0, 0.0, 0.0, 0.028_000_190_391_696_65]),
    (0.108_791_979_439_769_23, [0.0, 0.0, 0.0, 0.059_812_584_159_555_47]),
    (0.891_208_020_560_230_7, [0.0, 0.0, 0.0, 0.059_812_584_159_555_47]),
    (0.245_549_399_365_302_73, [0.0, 0.0, 0.0, 0.078_618_522_342_789_7]),
    (0.754_450_600_634_697_3, [0.0, 0.0, 0.0, 0.078_618_522_342_789_7]),
    (0.417_831_280_417_607_53, [0.0, 0.0, 0.0, 0.086_306_263_102_040_31]),
    (0.582_168_719_582_392_5, [0.0, 0.0, 0.0, 0.086_306_263_102_040_31]),
];

#[cfg(test)]
mod tests {
    use super::{GAUSS, NESTED, POINTS};

    /// Checks that a rule integrates polynomials up to a degree, but not those of the next even degree.
    fn check(rule: &[(f64, f64)], degree: i32) {
        // Integrals of odd powers about the middle vanish.
        let integral = |power: i32| rule.iter().map(|(at, weight)| weight * (2.0 * at - 1.0).powi(power)).sum::<f64>();
        let exact = |power: i32| if power % 2 == 0 { 1.0 / f64::from(power + 1) } else { 0.0 };
        let error = |power: i32| (integral(power) - exact(power)).abs();
        // Each point contributes one rounding error.
        assert!((0..=degree).all(|power| error(power) < rule.len() as f64 * f64::EPSILON));
        assert!(error(degree + 1) > 1e-9);
    }

    #[test]
    fn rules_integrate_polynomials() {
        check(&GAUSS, 5);
        for (rule, (points, degree)) in POINTS.into_iter().zip([3, 7, 13, 25]).enumerate() {
            assert!(NESTED[points..].iter().all(|(_, weights)| weights[rule] == 0.0));
            check(&NESTED.map(|(at, weights)| (at, weights[rule]))[..points], degree);
        }
    }
}
