//! Nested quadrature rules of three, seven and fifteen points (Patterson 1968): each contains the points of the one before.

/// Abscissae on [0, 1], and the weights of each rule.
pub const NESTED_RULES: [(f64, [f64; 3]); 15] = [
    (0.112_701_665_379_258_31, [5.0 / 18.0, 0.134_244_044_934_166_72, 0.067_207_627_621_892_11]),
    (0.5, [8.0 / 18.0, 0.225_458_269_329_237_07, 0.112_755_249_899_103_34]),
    (0.887_298_334_620_741_7, [5.0 / 18.0, 0.134_244_044_934_166_72, 0.067_207_627_621_892_11]),
    (0.019_754_365_645_989_858, [0.0, 0.052_328_113_013_233_63, 0.025_801_641_498_539_87]),
    (0.282_878_125_326_598_73, [0.0, 0.200_698_707_387_981_12, 0.100_314_264_688_494_51]),
    (0.717_121_874_673_401_3, [0.0, 0.200_698_707_387_981_12, 0.100_314_264_688_494_51]),
    (0.980_245_634_354_010_1, [0.0, 0.052_328_113_013_233_63, 0.025_801_641_498_539_87]),
    (0.003_084_018_393_622_489, [0.0, 0.0, 0.008_500_859_814_970_13]),
    (0.055_770_383_563_871_5, [0.0, 0.0, 0.046_463_597_657_562_27]),
    (0.189_448_526_631_386_8, [0.0, 0.0, 0.085_755_954_568_195_7]),
    (0.388_306_656_785_516_57, [0.0, 0.0, 0.109_578_429_200_793_75]),
    (0.611_693_343_214_483_4, [0.0, 0.0, 0.109_578_429_200_793_75]),
    (0.810_551_473_368_613_2, [0.0, 0.0, 0.085_755_954_568_195_7]),
    (0.944_229_616_436_128_5, [0.0, 0.0, 0.046_463_597_657_562_27]),
    (0.996_915_981_606_377_5, [0.0, 0.0, 0.008_500_859_814_970_13]),
];
/// Number of abscissae of each rule.
pub const RULE_POINTS: [usize; 3] = [3, 7, 15];

#[cfg(test)]
mod tests {
    use super::{NESTED_RULES as RULES, RULE_POINTS as POINTS};

    #[test]
    fn rules_integrate_polynomials() {
        for (rule, (points, degree)) in POINTS.into_iter().zip([5, 11, 23]).enumerate() {
            assert!(RULES[points..].iter().all(|(_, weights)| weights[rule] == 0.0));
            // Integrals of odd powers about the middle vanish.
            let integral = |power: i32| {
                RULES.iter().map(|(at, weights)| weights[rule] * (2.0 * at - 1.0).powi(power)).sum::<f64>()
            };
            let exact = |power: i32| if power % 2 == 0 { 1.0 / f64::from(power + 1) } else { 0.0 };
            let error = |power: i32| (integral(power) - exact(power)).abs();
            // Each point contributes one rounding error.
            assert!((0..=degree).all(|power| error(power) < points as f64 * f64::EPSILON));
            assert!(error(degree + 1) > 1e-9);
        }
    }
}
