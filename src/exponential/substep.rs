//! The motion within a step: the loads are known as a polynomial, so it is made of shorter steps of the table.

use super::kernel::{self, TERMS};
use super::step::Stepper;
use crate::modal::Form;

/// Less than this part of the shortest step that events use is nothing.
const NOTHING: f64 = 1e-9;

/// Room for states within a step.
#[derive(Clone, Debug, Default)]
pub struct SubstepSampler {
    /// The step that it is in, and the ticks into it of the state found last.
    step: u64,
    ticks: u64,
    /// The states passed on the way there: after the parts of one length, level after level.
    passed: Vec<Vec<f64>>,
    /// A state between ticks.
    between: Vec<f64>,
    other: Vec<f64>,
    loads: Vec<f64>,
    /// Coefficients of the loads over the parts of the step, of the highest power first, load after load.
    course: Vec<f64>,
    /// Derivatives of the loads over time, order after order.
    derivatives: Vec<f64>,
    term: Vec<f64>,
}

impl SubstepSampler {
    /// Room for states of a stepper.
    pub fn new(stepper: &Stepper<'_>) -> Self {
        let len = stepper.cache.linear.len();
        let course = stepper.field.loads() * stepper.cache.rule.whole.len();
        Self {
            step: 0,
            ticks: 0,
            passed: vec![vec![0.0; len]; stepper.cache.time_grid.event + 1],
            between: vec![0.0; len],
            other: vec![0.0; len],
            loads: vec![0.0; stepper.loads.len()],
            course: vec![0.0; course],
            derivatives: vec![0.0; course],
            term: vec![0.0; len],
        }
    }

    /// The state after `within` seconds of the last step, which was one of `level` from `z`.
    pub fn within<'a>(&'a mut self, stepper: &Stepper<'_>, level: usize, z: &'a [f64], within: f64) -> &'a [f64] {
        let (cache, time_grid) = (&stepper.cache, &stepper.cache.time_grid);
        let (whole, shortest) = (time_grid.step(level), time_grid.part(level));
        let tick = time_grid.step(shortest);
        let elapsed = (within / tick + NOTHING).floor();
        let ticks = elapsed as u64;
        if self.step != stepper.steps {
            (self.step, self.ticks) = (stepper.steps, 0);
            self.follow(stepper);
        }
        let mut begun = 0.0;
        let mut last = None;
        for (above, shorter) in (level..=shortest).enumerate() {
            let below = shortest - shorter;
            if (ticks >> below) & 1 == 0 {
                continue;
            }
            let part = time_grid.step(shorter) / whole;
            // Up to where the two part, the way to the state found last was the same.
            if (ticks ^ self.ticks) >> below != 0 {
                self.interpolate(stepper, begun, part);
                let (before, here) = self.passed.split_at_mut(above);
                let from = last.map_or(z, |at: usize| &before[at]);
                cache.propagator(shorter).advance(stepper.arch, &self.loads, from, &mut here[0]);
            }
            last = Some(above);
            begun += part;
        }
        self.ticks = ticks;
        let rest = within - elapsed * tick;
        if rest > NOTHING * tick {
            self.between.copy_from_slice(last.map_or(z, |at| &self.passed[at]));
            self.differentiate(stepper, begun, whole);
            self.taylor_step(stepper, rest);
            return &self.between;
        }
        last.map_or(z, |at| &self.passed[at])
    }

    /// Takes the polynomials of the loads over the last step, through its beginning, its nodes and its end.
    fn follow(&mut self, stepper: &Stepper<'_>) {
        let loads = stepper.field.loads().max(1);
        let polynomials = &stepper.cache.rule.whole;
        self.course.fill(0.0);
        let sides = [&stepper.begin_load[..], &stepper.loads[..], &stepper.end_load[..]];
        let values = sides.into_iter().flat_map(|side| side.chunks_exact(loads));
        for (polynomial, values) in polynomials.iter().zip(values) {
            for (course, coefficient) in self.course.rchunks_exact_mut(loads).zip(polynomial) {
                for (course, value) in course.iter_mut().zip(values) {
                    *course += coefficient * value;
                }
            }
        }
    }

    /// The loads at the nodes of a part of the last step.
    fn interpolate(&mut self, stepper: &Stepper<'_>, begun: f64, part: f64) {
        let loads = stepper.field.loads().max(1);
        for (node, values) in stepper.cache.rule.nodes.iter().zip(self.loads.chunks_exact_mut(loads)) {
            let at = begun + node * part;
            values.fill(0.0);
            for course in self.course.chunks_exact(loads) {
                for (value, coefficient) in values.iter_mut().zip(course) {
                    *value = *value * at + coefficient;
                }
            }
        }
    }

    /// The derivatives of the loads at a part of the last step of length `whole`.
    fn differentiate(&mut self, stepper: &Stepper<'_>, begun: f64, whole: f64) {
        let loads = stepper.field.loads().max(1);
        self.derivatives.fill(0.0);
        for (order, derivatives) in self.derivatives.chunks_exact_mut(loads).enumerate() {
            // dⁿ τᵐ = m!/(m − n)! τᵐ⁻ⁿ
            for (power, course) in self.course.rchunks_exact(loads).enumerate().skip(order) {
                let falling = (power - order + 1..=power).map(|factor| factor as f64).product::<f64>();
                let factor = falling * begun.powi((power - order) as i32) / whole.powi(order as i32);
                for (derivative, coefficient) in derivatives.iter_mut().zip(course) {
                    *derivative += factor * coefficient;
                }
            }
        }
    }

    /// Goes on between ticks by `rest` under the loads whose derivatives stand: z⁽ⁿ⁺¹⁾ = A z⁽ⁿ⁾ + B p⁽ⁿ⁾,
    /// and z + Σ restⁿ/n! z⁽ⁿ⁾.
    fn taylor_step(&mut self, stepper: &Stepper<'_>, rest: f64) {
        let turned = (stepper.cache.linear.radius * rest).abs();
        // Up to terms that no mode can tell from nothing.
        let (mut terms, mut size) = (0, 1.0);
        while terms < TERMS && size >= f64::EPSILON / 8.0 {
            terms += 1;
            size *= turned / terms as f64;
        }
        if let Form::Pairs(_) = &stepper.cache.linear.form {
            let (blocks, columns) = (&stepper.cache.linear.blocks, &stepper.bare_columns);
            kernel::taylor_step(stepper.arch, blocks, columns, &self.derivatives, rest, terms, &mut self.between);
            return;
        }
        let loads = stepper.field.loads().max(1);
        self.term.copy_from_slice(&self.between);
        let mut factor = 1.0;
        for order in 0..terms {
            let by = rest / (order + 1) as f64;
            factor *= by;
            stepper.cache.linear.multiply(&self.term, &mut self.other);
            for (term, rate) in self.term.iter_mut().zip(&self.other) {
                *term = by * rate;
            }
            if let Some(derivative) = self.derivatives.chunks_exact(loads).nth(order) {
                for (p, column) in derivative.iter().zip(&stepper.cache.maps.columns).filter(|(p, _)| **p != 0.0) {
                    for (term, b) in self.term.iter_mut().zip(column) {
                        *term += factor * b * p;
                    }
                }
            }
            for (z, term) in self.between.iter_mut().zip(&self.term) {
                *z += term;
            }
        }
    }
}
