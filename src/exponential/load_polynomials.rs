//! Polynomials of the loads within a step.

use super::step::Stepper;

/// The load polynomials of the last step.
#[derive(Clone, Debug, Default)]
pub(super) struct LoadPolynomials {
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

    /// Computes the loads at the stages of a substep, which begins at the fraction `begun` of the step and is `part` of
    /// it long.
    pub fn at_stages(&self, stepper: &Stepper<'_>, begun: f64, part: f64, out: &mut [f64]) {
        let load_count = stepper.loads().load_count().max(1);
        for (node, values) in stepper.context.cache.rule.nodes.iter().zip(out.chunks_exact_mut(load_count)) {
            let at = begun + node * part;
            values.fill(0.0);
            for coefficients in self.coefficients.chunks_exact(load_count) {
                for (value, coefficient) in values.iter_mut().zip(coefficients) {
                    *value = *value * at + coefficient;
                }
            }
        }
    }

    /// Computes the time derivatives of the loads at the fraction `begun` of a step that is `whole` seconds long.
    pub fn differentiate(&self, stepper: &Stepper<'_>, begun: f64, whole: f64, out: &mut [f64]) {
        let load_count = stepper.loads().load_count().max(1);
        out.fill(0.0);
        for (order, derivatives) in out.chunks_exact_mut(load_count).enumerate() {
            // dⁿ τᵐ = m!/(m − n)! τᵐ⁻ⁿ
            for (power, coefficients) in self.coefficients.rchunks_exact(load_count).enumerate().skip(order) {
                let falling = (power - order + 1..=power).map(|factor| factor as f64).product::<f64>();
                let factor = falling * begun.powi((power - order) as i32) / whole.powi(order as i32);
                for (derivative, coefficient) in derivatives.iter_mut().zip(coefficients) {
                    *derivative += factor * coefficient;
                }
            }
        }
    }
}
