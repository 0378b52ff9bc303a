//! The motion within a step of a linear motion in mode pairs: free motion plus polynomials, see [`ModeSplit`].

use pulp::{Simd, WithSimd};

use super::fractions::{Fractions, MAX_DIGITS};
use super::load_polynomials::LoadPolynomials;
use super::mode_split::{DEGREE, ModeSplit};
use super::packed::{Aligned, WIDTH};
use super::quadrature::MAX_STAGES;
use super::step::Stepper;
use super::{MAX_TERMS, taylor_terms};

/// A remainder below this fraction of a unit is round-off.
const ROUND_OFF: f64 = 1e-9;
/// Largest number of coefficients of a load.
const MAX_POWERS: usize = MAX_STAGES + 2;
/// Coefficients of the motion of a chunk of slots: both coordinates of [`WIDTH`] slots for each power.
const CHUNK: usize = 2 * WIDTH * (DEGREE + 1);

/// States within the last step.
#[derive(Clone, Debug)]
pub(super) struct SubstepModes {
    /// Free motion z₀ − g₀ at the beginning.
    free: Vec<f64>,
    /// Coefficients gₙ, chunk after chunk and power after power.
    motion: Vec<f64>,
    /// Number of coefficients of a load; zero without loads, where all motion is free.
    powers: usize,
    state: Vec<f64>,
}

impl SubstepModes {
    /// Allocates the states of a stepper.
    pub fn new(stepper: &Stepper<'_>) -> Self {
        let cache = &stepper.context.cache;
        let len = cache.linear.len();
        Self {
            free: vec![0.0; len],
            motion: vec![0.0; len / (2 * WIDTH) * CHUNK],
            powers: if stepper.loads().load_count() > 0 { cache.rule.whole.len() } else { 0 },
            state: vec![0.0; len],
        }
    }

    /// Starts with the last step, which begins at the state `z`.
    pub fn begin(&mut self, stepper: &Stepper<'_>, (split, loads): (&ModeSplit, &LoadPolynomials), z: &[f64]) {
        if self.powers == 0 {
            self.free.copy_from_slice(z);
            return;
        }
        let context = &stepper.context;
        let (free, motion) = (&mut self.free[..], &mut self.motion[..]);
        let (columns, loads) = (&context.columns[..], &loads.coefficients[..]);
        context.arch.dispatch(Expand { split, columns, loads, powers: self.powers, z, free, motion });
    }

    /// The state `within` seconds after the beginning of the step, which has a level.
    pub fn state_at(&mut self, stepper: &Stepper<'_>, (level, split): (usize, &ModeSplit), within: f64) -> &[f64] {
        let cache = &stepper.context.cache;
        let (fractions, pairs) = (&cache.fractions, cache.pairs());
        let mut matrices = [[&[][..]; 4]; MAX_DIGITS];
        let (mut count, mut rest) = (0, 0.0);
        let (fraction, at_fraction) = Fractions::nearest(within, split.step);
        let part = (at_fraction == within).then(|| fractions.part(pairs, level, fraction)).flatten();
        if let Some(part) = part {
            matrices[0] = lists(part);
            count = 1;
        } else {
            let whole = (within / fractions.unit + ROUND_OFF).floor();
            for (position, digit) in Fractions::digits(whole as u64).filter(|(_, digit)| *digit > 0) {
                matrices[count] = lists(fractions.matrix(pairs, position, digit));
                count += 1;
            }
            rest = within - whole * fractions.unit;
        }
        let is_whole = rest <= ROUND_OFF * fractions.unit;
        stepper.context.arch.dispatch(Evaluate {
            split,
            matrices: &matrices[..count],
            blocks: &cache.linear.blocks,
            rest,
            terms: if is_whole { 0 } else { taylor_terms(cache.linear.radius * rest) },
            powers: self.powers,
            part: within / split.step,
            motion: &self.motion,
            free: &self.free,
            state: &mut self.state,
        });
        &self.state
    }
}

/// The entries of packed blocks.
fn lists(matrix: &[Aligned; 4]) -> [&[f64]; 4] {
    matrix.each_ref().map(|list| &list[..])
}

/// Computes the coefficients of the motion, and the free motion.
struct Expand<'a> {
    split: &'a ModeSplit,
    /// Columns b, one after the other.
    columns: &'a [f64],
    /// Coefficients of the loads, highest power first.
    loads: &'a [f64],
    powers: usize,
    z: &'a [f64],
    free: &'a mut [f64],
    motion: &'a mut [f64],
}

type Lanes = [f64; WIDTH];

impl WithSimd for Expand<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { split, powers, z, free, motion, .. } = self;
        let (half, count) = (z.len() / (2 * WIDTH), self.loads.len() / powers);
        let (z, free) = (z.as_chunks::<WIDTH>().0, free.as_chunks_mut::<WIDTH>().0);
        let columns = self.columns.as_chunks::<WIDTH>().0;
        let inverses = split.inverses.each_ref().map(|list| list.as_chunks::<WIDTH>().0);
        let blocks = split.slow_blocks.each_ref().map(|list| list.as_chunks::<WIDTH>().0);
        let is_slow = split.is_slow.each_ref().map(|list| list.as_chunks::<WIDTH>().0);
        for (i, motion) in motion.chunks_exact_mut(CHUNK).enumerate() {
            let motion = motion.as_chunks_mut::<WIDTH>().0.as_chunks_mut::<2>().0;
            let mut forces = [[[0.0; WIDTH]; 2]; MAX_POWERS];
            for side in 0..2 {
                for (force, power) in forces[..powers].iter_mut().zip((0..powers).rev()) {
                    let loads = &self.loads[power * count..][..count];
                    force[side] =
                        sum_loads(split.step, loads, &columns[(side * half + i).min(columns.len())..], 2 * half);
                }
            }
            let mut next = [[0.0; WIDTH]; 2];
            for (power, force) in forces[..powers].iter().enumerate().rev() {
                let factor = (power + 1) as f64;
                let mut right = [[0.0; WIDTH]; 2];
                for side in 0..2 {
                    for lane in 0..WIDTH {
                        right[side][lane] = factor * next[side][lane] - force[side][lane];
                    }
                }
                next = product(inverses.map(|list| &list[i]), &right);
                motion[power] = next;
            }
            let mut slow = [[0.0; WIDTH]; 2];
            for side in 0..2 {
                let (z, mask) = (&z[side * half + i], &is_slow[side][i]);
                for lane in 0..WIDTH {
                    slow[side][lane] = mask[lane] * z[lane];
                    free[side * half + i][lane] = (1.0 - mask[lane]) * (z[lane] - next[side][lane]);
                }
            }
            let terms = split.terms[i];
            if terms > 0 {
                motion[powers..terms].fill([[0.0; WIDTH]; 2]);
                let masks = is_slow.map(|list| &list[i]);
                add_series(blocks.map(|list| &list[i]), masks, &forces[..powers], slow, &mut motion[..terms]);
            }
        }
    }
}

/// Step times Σ c_i b_i, for one chunk of slots: load i has the coefficient c_i and the column b_i, which stands at the
/// index i × `stride` of `columns`.
#[inline(always)]
fn sum_loads(step: f64, coefficients: &[f64], columns: &[Lanes], stride: usize) -> Lanes {
    let mut sum = [0.0; WIDTH];
    for (coefficient, column) in coefficients.iter().zip(columns.iter().step_by(stride)) {
        for lane in 0..WIDTH {
            sum[lane] += column[lane] * coefficient;
        }
    }
    for value in &mut sum {
        *value *= step;
    }
    sum
}

/// Adds the power series of the slow modes, which begin at `term`.
#[inline(always)]
fn add_series(
    blocks: [&Lanes; 4],
    masks: [&Lanes; 2],
    forces: &[[Lanes; 2]],
    mut term: [Lanes; 2],
    motion: &mut [[Lanes; 2]],
) {
    let (forced, free) = motion.split_at_mut(forces.len().min(motion.len()));
    for (power, (motion, force)) in forced.iter_mut().zip(forces).enumerate() {
        add(motion, &term);
        term = product(blocks, &term);
        for side in 0..2 {
            for lane in 0..WIDTH {
                term[side][lane] += masks[side][lane] * force[side][lane];
            }
        }
        scale(&mut term, 1.0 / (power + 1) as f64);
    }
    for (power, motion) in free.iter_mut().enumerate() {
        add(motion, &term);
        term = product(blocks, &term);
        scale(&mut term, 1.0 / (forces.len() + power + 1) as f64);
    }
}

/// `sum += term`, both coordinates.
#[inline(always)]
fn add(sum: &mut [Lanes; 2], term: &[Lanes; 2]) {
    for side in 0..2 {
        for lane in 0..WIDTH {
            sum[side][lane] += term[side][lane];
        }
    }
}

/// `term *= factor`, both coordinates.
#[inline(always)]
fn scale(term: &mut [Lanes; 2], factor: f64) {
    for value in term.as_flattened_mut() {
        *value *= factor;
    }
}

/// Value at τ of the polynomial with coefficients of both coordinates, lowest power first. Even and odd powers are summed
/// apart, as polynomials in τ²: one sum would wait for each addition.
#[inline(always)]
fn polynomial(coefficients: &[[Lanes; 2]], part: f64) -> [Lanes; 2] {
    let (pairs, last) = coefficients.as_chunks::<2>();
    let (mut even, mut odd) = ([[0.0; WIDTH]; 2], [[0.0; WIDTH]; 2]);
    if let [last] = last {
        even = *last;
    }
    let square = part * part;
    for [zeroth, first] in pairs.iter().rev() {
        scale(&mut even, square);
        add(&mut even, zeroth);
        scale(&mut odd, square);
        add(&mut odd, first);
    }
    scale(&mut odd, part);
    add(&mut even, &odd);
    even
}

/// Products of 2×2 blocks with both coordinates.
#[inline(always)]
fn product([a, b, c, d]: [&Lanes; 4], [x, y]: &[Lanes; 2]) -> [Lanes; 2] {
    let mut out = [[0.0; WIDTH]; 2];
    for lane in 0..WIDTH {
        out[0][lane] = a[lane] * x[lane] + b[lane] * y[lane];
        out[1][lane] = c[lane] * x[lane] + d[lane] * y[lane];
    }
    out
}

/// Moves the free motion and adds the polynomials.
struct Evaluate<'a> {
    split: &'a ModeSplit,
    /// Factors of e^{At}.
    matrices: &'a [[&'a [f64]; 4]],
    /// Entries of the blocks of A.
    blocks: &'a [Vec<f64>; 4],
    /// Remaining time, s, and the terms of its Taylor series.
    rest: f64,
    terms: usize,
    powers: usize,
    /// Fraction τ of the step.
    part: f64,
    motion: &'a [f64],
    free: &'a [f64],
    state: &'a mut [f64],
}

impl WithSimd for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let half = self.state.len() / (2 * WIDTH);
        let (free, state) = (self.free.as_chunks::<WIDTH>().0, self.state.as_chunks_mut::<WIDTH>().0);
        let parts: [f64; MAX_TERMS] = std::array::from_fn(|order| self.rest / (order + 1) as f64);
        for (i, motion) in self.motion.chunks_exact(CHUNK).enumerate() {
            let mut sum = [free[i], free[half + i]];
            for matrix in self.matrices {
                sum = product(matrix.map(|list| &list.as_chunks::<WIDTH>().0[i]), &sum);
            }
            if self.terms > 0 {
                let blocks = self.blocks.each_ref().map(|list| &list.as_chunks::<WIDTH>().0[i]);
                let mut term = sum;
                for part in &parts[..self.terms] {
                    term = product(blocks, &term);
                    for side in 0..2 {
                        for lane in 0..WIDTH {
                            term[side][lane] *= part;
                            sum[side][lane] += term[side][lane];
                        }
                    }
                }
            }
            let motion = motion.as_chunks::<WIDTH>().0.as_chunks::<2>().0;
            let powers = self.powers.max(if self.powers > 0 { self.split.terms[i] } else { 0 });
            let forced = polynomial(&motion[..powers], self.part);
            for side in 0..2 {
                for lane in 0..WIDTH {
                    state[side * half + i][lane] = sum[side][lane] + forced[side][lane];
                }
            }
        }
    }
}
