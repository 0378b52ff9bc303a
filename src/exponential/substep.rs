//! The motion within a step: shorter tabulated steps under the polynomial of the loads, and a Taylor step over the rest.

use super::kernel::{self, TERMS};
use super::step::Stepper;
use crate::modal::StateMatrix;

/// A remainder below this fraction of the shortest substep is round-off.
const ROUND_OFF: f64 = 1e-9;

/// Samples states within the last step. Substeps that two samples share are computed once.
#[derive(Clone, Debug, Default)]
pub struct SubstepSampler {
    /// Number of the step that was sampled last.
    step: u64,
    /// Substeps of the shortest length from its beginning to the last sample.
    substeps: u64,
    /// States after the substeps of the last sample, one for each length, longest first.
    states: Vec<Vec<f64>>,
    /// State after the Taylor step.
    remainder_state: Vec<f64>,
    /// Coefficients of the load polynomials over the fraction of the step, highest power first, all loads of a power
    /// together.
    coefficients: Vec<f64>,
    /// Time derivatives of the loads, order after order.
    derivatives: Vec<f64>,
    /// Scratch: stage loads of a substep, a term of the Taylor series and its derivative.
    loads: Vec<f64>,
    term: Vec<f64>,
    rate: Vec<f64>,
}

impl SubstepSampler {
    /// Allocates the states of a stepper.
    pub fn new(stepper: &Stepper<'_>) -> Self {
        let cache = &stepper.context.cache;
        let len = cache.linear.len();
        let coefficients = stepper.nonlinear_loads().load_count() * cache.rule.whole.len();
        Self {
            step: 0,
            substeps: 0,
            states: vec![vec![0.0; len]; cache.time_grid.event + 1],
            remainder_state: vec![0.0; len],
            coefficients: vec![0.0; coefficients],
            derivatives: vec![0.0; coefficients],
            loads: vec![0.0; stepper.stages.loads.len()],
            term: vec![0.0; len],
            rate: vec![0.0; len],
        }
    }

    /// The state `within` seconds after the beginning of the last step, which had the step level `level` and began at the
    /// state `z`.
    pub fn state_at<'a>(&'a mut self, stepper: &Stepper<'_>, level: usize, z: &'a [f64], within: f64) -> &'a [f64] {
        let (cache, time_grid) = (&stepper.context.cache, &stepper.context.cache.time_grid);
        let (whole, shortest) = (time_grid.step(level), time_grid.substep_level(level));
        let substep = time_grid.step(shortest);
        let elapsed = (within / substep + ROUND_OFF).floor();
        let substeps = elapsed as u64;
        if self.step != stepper.steps {
            (self.step, self.substeps) = (stepper.steps, 0);
            self.set_polynomials(stepper);
        }
        let mut begun = 0.0;
        let mut last = None;
        // The binary digits of the number of substeps say which lengths the way to the sample consists of.
        for (index, shorter) in (level..=shortest).enumerate() {
            let bit = shortest - shorter;
            if (substeps >> bit) & 1 == 0 {
                continue;
            }
            let part = time_grid.step(shorter) / whole;
            // As long as the digits agree with those of the last sample, the states do.
            if (substeps ^ self.substeps) >> bit != 0 {
                self.interpolate_loads(stepper, begun, part);
                let (before, here) = self.states.split_at_mut(index);
                let from = last.map_or(z, |at: usize| &before[at]);
                cache.propagator(shorter).advance(stepper.context.arch, &self.loads, from, &mut here[0]);
            }
            last = Some(index);
            begun += part;
        }
        self.substeps = substeps;
        let rest = within - elapsed * substep;
        if rest > ROUND_OFF * substep {
            self.remainder_state.copy_from_slice(last.map_or(z, |at| &self.states[at]));
            self.differentiate_loads(stepper, begun, whole);
            self.taylor_step(stepper, rest);
            return &self.remainder_state;
        }
        last.map_or(z, |at| &self.states[at])
    }

    /// Computes the load polynomials of the last step through its beginning, its stages and its end.
    fn set_polynomials(&mut self, stepper: &Stepper<'_>) {
        let loads = stepper.nonlinear_loads().load_count().max(1);
        let polynomials = &stepper.context.cache.rule.whole;
        self.coefficients.fill(0.0);
        let points = [&stepper.begin.load[..], &stepper.stages.loads[..], &stepper.end.load[..]];
        let values = points.into_iter().flat_map(|points| points.chunks_exact(loads));
        for (polynomial, values) in polynomials.iter().zip(values) {
            for (sums, coefficient) in self.coefficients.rchunks_exact_mut(loads).zip(polynomial) {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += coefficient * value;
                }
            }
        }
    }

    /// Computes the loads at the stages of a substep, which begins at the fraction `begun` of the step and is `part` of
    /// it long.
    fn interpolate_loads(&mut self, stepper: &Stepper<'_>, begun: f64, part: f64) {
        let loads = stepper.nonlinear_loads().load_count().max(1);
        for (node, values) in stepper.context.cache.rule.nodes.iter().zip(self.loads.chunks_exact_mut(loads)) {
            let at = begun + node * part;
            values.fill(0.0);
            for coefficients in self.coefficients.chunks_exact(loads) {
                for (value, coefficient) in values.iter_mut().zip(coefficients) {
                    *value = *value * at + coefficient;
                }
            }
        }
    }

    /// Computes the time derivatives of the loads at the fraction `begun` of a step that is `whole` seconds long.
    fn differentiate_loads(&mut self, stepper: &Stepper<'_>, begun: f64, whole: f64) {
        let loads = stepper.nonlinear_loads().load_count().max(1);
        self.derivatives.fill(0.0);
        for (order, derivatives) in self.derivatives.chunks_exact_mut(loads).enumerate() {
            // dⁿ τᵐ = m!/(m − n)! τᵐ⁻ⁿ
            for (power, coefficients) in self.coefficients.rchunks_exact(loads).enumerate().skip(order) {
                let falling = (power - order + 1..=power).map(|factor| factor as f64).product::<f64>();
                let factor = falling * begun.powi((power - order) as i32) / whole.powi(order as i32);
                for (derivative, coefficient) in derivatives.iter_mut().zip(coefficients) {
                    *derivative += factor * coefficient;
                }
            }
        }
    }

    /// Advances [`Self::remainder_state`] by `rest` seconds: z + Σ restⁿ/n! z⁽ⁿ⁾, with z⁽ⁿ⁺¹⁾ = A z⁽ⁿ⁾ + b p⁽ⁿ⁾.
    fn taylor_step(&mut self, stepper: &Stepper<'_>, rest: f64) {
        let context = &stepper.context;
        let rotation = (context.cache.linear.radius * rest).abs();
        // The remaining terms are below round-off for every mode.
        let (mut terms, mut size) = (0, 1.0);
        while terms < TERMS && size >= f64::EPSILON / 8.0 {
            terms += 1;
            size *= rotation / terms as f64;
        }
        if let StateMatrix::Pairs(_) = &context.cache.linear.matrix {
            let (blocks, columns) = (&context.cache.linear.blocks, &context.columns);
            kernel::taylor_step(
                context.arch,
                blocks,
                columns,
                &self.derivatives,
                rest,
                terms,
                &mut self.remainder_state,
            );
            return;
        }
        let loads = stepper.nonlinear_loads().load_count().max(1);
        self.term.copy_from_slice(&self.remainder_state);
        let mut factor = 1.0;
        for order in 0..terms {
            let by = rest / (order + 1) as f64;
            factor *= by;
            context.cache.linear.multiply(&self.term, &mut self.rate);
            for (term, rate) in self.term.iter_mut().zip(&self.rate) {
                *term = by * rate;
            }
            if let Some(derivative) = self.derivatives.chunks_exact(loads).nth(order) {
                for (p, column) in derivative.iter().zip(&context.cache.maps.columns).filter(|(p, _)| **p != 0.0) {
                    for (term, b) in self.term.iter_mut().zip(column) {
                        *term += factor * b * p;
                    }
                }
            }
            for (z, term) in self.remainder_state.iter_mut().zip(&self.term) {
                *z += term;
            }
        }
    }
}
