//! Polynomials of the loads within a step.

use crate::exponential::step::Stepper;

/// The load polynomials of the last step.
#[derive(Clone, Debug, Default)]
pub(in crate::exponential) struct LoadPolynomials {
    /// Coefficients over the fraction of the step, highest power first, all loads of a power together.
    pub coefficients: Vec<f64>,
}

impl LoadPolynomials {
    /// Allocates the polynomials of a stepper.
    pub fn new(stepper: &Stepper<'_>) -> Self {
        let powers = stepper.context.cache.rule.whole.len();
        Self { coefficients: vec![0.0; stepper.loads().load_count() * powers] }
    }

    /// Computes the polynomials of the last step through its beginning, its stages and its end.
    pub fn set(&mut self, stepper: &Stepper<'_>) {
        let load_count = stepper.loads().load_count().max(1);
        let polynomials = &stepper.context.cache.rule.whole;
        self.coefficients.fill(0.0);
        let points = [&stepper.begin.load[..], &stepper.stages.loads[..], &stepper.end.load[..]];
        let values = points.into_iter().flat_map(|points| points.chunks_exact(load_count));
        for (polynomial, values) in polynomials.iter().zip(values) {
            for (sums, coefficient) in self.coefficients.rchunks_exact_mut(load_count).zip(polynomial) {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += coefficient * value;
                }
            }
        }
    }
}
