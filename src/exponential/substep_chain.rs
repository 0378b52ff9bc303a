//! The motion within a step of any linear motion: shorter tabulated steps under the polynomials of the loads, and a Taylor
//! step over the rest.

use super::load_polynomials::LoadPolynomials;
use super::step::Stepper;
use super::taylor_terms;

/// A remainder below this fraction of the shortest substep is round-off.
const ROUND_OFF: f64 = 1e-9;

/// States within the last step. Substeps that two samples share are computed once.
#[derive(Clone, Debug)]
pub(super) struct SubstepChain {
    /// Substeps of the shortest length from its beginning to the last sample.
    substeps: u64,
    /// States after the substeps of the last sample, one for each length, longest first.
    states: Vec<Vec<f64>>,
    /// State after the Taylor step.
    remainder_state: Vec<f64>,
    /// Time derivatives of the loads, order after order.
    derivatives: Vec<f64>,
    /// Scratch: stage loads of a substep, a term of the Taylor series and its derivative.
    loads: Vec<f64>,
    term: Vec<f64>,
    rate: Vec<f64>,
}

impl SubstepChain {
    /// Allocates the states of a stepper.
    pub fn new(stepper: &Stepper<'_>) -> Self {
        let cache = &stepper.context.cache;
        let len = cache.linear.len();
        Self {
            substeps: 0,
            states: vec![vec![0.0; len]; cache.time_grid.event + 1],
            remainder_state: vec![0.0; len],
            derivatives: vec![0.0; stepper.loads().load_count() * cache.rule.whole.len()],
            loads: vec![0.0; stepper.stages.loads.len()],
            term: vec![0.0; len],
            rate: vec![0.0; len],
        }
    }

    /// Starts with another step.
    pub fn begin(&mut self) {
        self.substeps = 0;
    }

    /// The state `within` seconds after the beginning `z` of the last step, with its level and the polynomials of its loads.
    pub fn state_at<'a>(
        &'a mut self,
        stepper: &Stepper<'_>,
        (level, polynomials): (usize, &LoadPolynomials),
        z: &'a [f64],
        within: f64,
    ) -> &'a [f64] {
        let (cache, time_grid) = (&stepper.context.cache, &stepper.context.cache.time_grid);
        let (whole, shortest) = (time_grid.step(level), time_grid.substep_level(level));
        let substep = time_grid.step(shortest);
        let elapsed = (within / substep + ROUND_OFF).floor();
        let substeps = elapsed as u64;
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
                polynomials.at_stages(stepper, begun, part, &mut self.loads);
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
            polynomials.differentiate(stepper, begun, whole, &mut self.derivatives);
            self.taylor_step(stepper, rest);
            return &self.remainder_state;
        }
        last.map_or(z, |at| &self.states[at])
    }

    /// Advances [`Self::remainder_state`] by `rest` seconds: z + Σ restⁿ/n! z⁽ⁿ⁾, with z⁽ⁿ⁺¹⁾ = A z⁽ⁿ⁾ + b p⁽ⁿ⁾.
    fn taylor_step(&mut self, stepper: &Stepper<'_>, rest: f64) {
        let context = &stepper.context;
        let terms = taylor_terms(context.cache.linear.radius * rest);
        let load_count = stepper.loads().load_count().max(1);
        self.term.copy_from_slice(&self.remainder_state);
        let mut factor = 1.0;
        for order in 0..terms {
            let by = rest / (order + 1) as f64;
            factor *= by;
            context.cache.linear.multiply(&self.term, &mut self.rate);
            for (term, rate) in self.term.iter_mut().zip(&self.rate) {
                *term = by * rate;
            }
            if let Some(derivative) = self.derivatives.chunks_exact(load_count).nth(order) {
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
