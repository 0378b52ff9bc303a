//! The motion within a step under the polynomials of its loads, in mode pairs.
//!
//! Under loads Σ aₘ τᵐ over the fraction τ = t/h of the step, a mode with the eigenvalue λ has the motion
//!
//! ```text
//! z(t) = e^{λt} z₀ + t Σ τᵐ ψₘ(λt) b aₘ,        ψₘ(x) = ∫₀¹ e^{x(1−s)} sᵐ ds = m! φₘ₊₁(x)
//! ```
//!
//! Since xψ₀ = eˣ − 1 and xψₘ = m ψₘ₋₁ − 1, a fast mode has the motion e^{λt} (z₀ − g₀) + Σ gₘ τᵐ, where
//! λh gₘ = (m + 1) gₘ₊₁ − h b aₘ: a free motion and a polynomial. For a slow mode, |λ|h < 1, both are large and nearly cancel, so
//! that round-off would remain. For slow modes, a power series gives the function ψ of the highest index, and the relation
//! xψₘ = m ψₘ₋₁ − 1 gives the others.

use pulp::{Simd, WithSimd};

use crate::exponential::propagator::{Aligned, MAX_STAGES, aligned, panel_kernel};
use crate::exponential::step::Stepper;
use crate::linalg::LANES;
use crate::modal::ModePair;
use crate::numerics::exponential;

/// Largest number of functions ψ: one for each coefficient of a load, and a further one for rigid-body motions.
const MAX_FUNCTIONS: usize = MAX_STAGES + 3;
/// Terms of the series for |x| < 1. Its last term is then below 2/17!, which is round-off.
const SERIES_TERMS: usize = 16;

type Lanes = [f64; LANES];

/// Samples states within the last step.
#[derive(Clone, Debug)]
pub struct SubstepSampler {
    /// Number of the step that was sampled last.
    step: u64,
    /// Coefficients of the loads over the fraction of that step, highest power first, all loads of a power together.
    coefficients: Vec<f64>,
    /// Real and imaginary parts of the eigenvalues λ, 1/s: one for each slot, then both of each of [`Self::others`].
    eigenvalues: [Aligned; 2],
    /// Smallest |λ| of each chunk of [`LANES`] slots, 1/s; zero if one of [`Self::others`] is in it.
    slowest: Vec<f64>,
    /// Pairs that are no oscillation.
    others: Vec<OtherPair>,
    /// For each power m of the loads, lowest first, b aₘ of all slots, or gₘ in chunks of fast modes; empty without loads.
    forces: Vec<f64>,
    /// Number of functions ψ of an eigenvalue.
    count: usize,
    /// Real and imaginary parts of e^{λt}, and of the functions ψ in chunks with slow modes, chunk after chunk.
    exponentials: Vec<[Lanes; 2]>,
    functions: Vec<[Lanes; 2]>,
    state: Vec<f64>,
}

/// A pair that is no oscillation.
#[derive(Clone, Copy, Debug)]
struct OtherPair {
    slot: usize,
    /// Index of the first of its two eigenvalues.
    first: usize,
    /// Whether it is the position and the velocity of a rigid-body motion.
    is_rigid: bool,
}

impl SubstepSampler {
    /// Allocates the sampler of a stepper.
    pub fn new(stepper: &Stepper<'_>) -> Self {
        let (cache, loads) = (&stepper.context.cache, stepper.loads().load_count());
        let pairs = cache.pairs();
        let (mut real, mut imaginary): (Vec<f64>, Vec<f64>) =
            pairs.iter().map(|pair| (pair.eigenvalues()[0].re, pair.eigenvalues()[0].im)).unzip();
        let sizes: Vec<f64> = real.iter().zip(&imaginary).map(|(re, im): (&f64, &f64)| re.hypot(*im)).collect();
        let least = |sizes: &[f64]| sizes.iter().copied().fold(f64::INFINITY, f64::min);
        let mut slowest: Vec<f64> = sizes.chunks_exact(LANES).map(least).collect();
        let mut others = Vec::new();
        for (slot, pair) in pairs.iter().enumerate() {
            let values = pair.eigenvalues().map(|value| value.re);
            let is_rigid = matches!(pair, ModePair::RigidBodyPair(_));
            // Equal real eigenvalues, also those of empty slots, are an oscillation without frequency.
            if is_rigid || matches!(pair, ModePair::Real(_)) && values[0] != values[1] {
                others.push(OtherPair { slot, first: real.len(), is_rigid });
                slowest[slot / LANES] = 0.0;
                real.extend(values);
            }
        }
        real.resize(real.len().next_multiple_of(LANES), 0.0);
        imaginary.resize(real.len(), 0.0);
        let powers = if loads > 0 { cache.rule.whole.len() } else { 0 };
        let (count, chunks) = (powers + 1, real.len() / LANES);
        Self {
            step: 0,
            coefficients: vec![0.0; loads * powers],
            eigenvalues: [aligned(&real), aligned(&imaginary)],
            slowest,
            others,
            forces: vec![0.0; powers * cache.linear.len()],
            count,
            exponentials: vec![[[0.0; LANES]; 2]; chunks],
            functions: vec![[[0.0; LANES]; 2]; chunks * count],
            state: vec![0.0; cache.linear.len()],
        }
    }

    /// Computes the polynomials of the loads of the last step through its beginning, its stages and its end, and those of the
    /// fast modes. It is `step` seconds long.
    fn begin(&mut self, stepper: &Stepper<'_>, step: f64) {
        let (arch, load_count) = (stepper.context.arch, stepper.loads().load_count().max(1));
        self.coefficients.fill(0.0);
        let points = [&stepper.begin.load[..], &stepper.stages.loads[..], &stepper.end.load[..]];
        let values = points.into_iter().flat_map(|points| points.chunks_exact(load_count));
        for (polynomial, values) in stepper.context.cache.rule.whole.iter().zip(values) {
            for (sums, coefficient) in self.coefficients.rchunks_exact_mut(load_count).zip(polynomial) {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += coefficient * value;
                }
            }
        }
        let coefficients = self.coefficients.rchunks_exact(load_count);
        self.forces.fill(0.0);
        for (force, coefficients) in self.forces.chunks_exact_mut(self.state.len().max(1)).zip(coefficients) {
            panel_kernel::accumulate(arch, &stepper.context.columns, coefficients, force);
        }
        arch.dispatch(Polynomials {
            eigenvalues: self.eigenvalues.each_ref().map(|part| &part[..]),
            slowest: &self.slowest,
            step,
            forces: &mut self.forces,
        });
    }

    /// The state `within` seconds after the beginning of the last step, which had the step level `level` and began at the
    /// state `z`.
    pub fn state_at(&mut self, stepper: &Stepper<'_>, level: usize, z: &[f64], within: f64) -> &[f64] {
        let (arch, step) = (stepper.context.arch, stepper.step_length(level));
        if self.step != stepper.steps {
            self.step = stepper.steps;
            self.begin(stepper, step);
        }
        let Self { eigenvalues, slowest, count, forces, exponentials, functions, state, .. } = self;
        let eigenvalues = eigenvalues.each_ref().map(|part| &part[..]);
        arch.dispatch(Exponentials { eigenvalues, time: within, exponentials });
        arch.dispatch(Sum {
            eigenvalues,
            slowest,
            exponentials,
            functions,
            count: *count,
            step,
            time: within,
            z,
            forces,
            state,
        });
        self.add_others(step, z, within);
        &self.state
    }

    /// Computes the coordinates of the pairs that are no oscillation.
    fn add_others(&mut self, step: f64, z: &[f64], within: f64) {
        let half = z.len() / 2;
        for OtherPair { slot, first, is_rigid } in &self.others {
            // e^{λt} has the order 0, and ψₘ the order m + 1.
            let function = |order: usize, index: usize| {
                let (chunk, lane) = (index / LANES, index % LANES);
                match order {
                    0 => self.exponentials[chunk][0][lane],
                    _ => self.functions[chunk * self.count + order - 1][0][lane],
                }
            };
            let (mut sum, mut factor) = ([0.0; 2], 1.0);
            let forces = self.forces.chunks_exact(z.len());
            for (order, state) in std::iter::once(z).chain(forces).enumerate() {
                let [a, d] = [function(order, *first), function(order, first + 1)];
                // The off-diagonal entry of a function of [[0, 1], [0, λ]] is its divided difference between 0 and λ.
                let b = if *is_rigid { within * function(order + 1, first + 1) / order.max(1) as f64 } else { 0.0 };
                let [x, y] = [state[*slot], state[half + slot]];
                sum = [sum[0] + factor * (a * x + b * y), sum[1] + factor * d * y];
                factor = if order == 0 { within } else { factor * (within / step) };
            }
            [self.state[*slot], self.state[half + slot]] = sum;
        }
    }
}

/// Converts the loads of fast modes to the polynomials gₘ.
struct Polynomials<'a> {
    eigenvalues: [&'a [f64]; 2],
    slowest: &'a [f64],
    step: f64,
    forces: &'a mut [f64],
}

impl WithSimd for Polynomials<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [real, imaginary] = self.eigenvalues.map(|part| part.as_chunks::<LANES>().0);
        let forces = self.forces.as_chunks_mut::<LANES>().0;
        // Chunks of real parts, behind which those of imaginary parts begin.
        let chunks = self.slowest.len();
        for i in (0..chunks).filter(|i| self.slowest[*i] * self.step >= 1.0) {
            let inverse = inverse(&scaled(&real[i], &imaginary[i], self.step));
            let mut next = [[0.0; LANES]; 2];
            for (m, forces) in forces.chunks_exact_mut(2 * chunks).enumerate().rev() {
                for lane in 0..LANES {
                    next[0][lane] = (m + 1) as f64 * next[0][lane] - self.step * forces[i][lane];
                    next[1][lane] = (m + 1) as f64 * next[1][lane] - self.step * forces[chunks + i][lane];
                }
                next = rotated(&inverse, &next[0], &next[1]);
                [forces[i], forces[chunks + i]] = next;
            }
        }
    }
}

/// Computes e^{λt} of all eigenvalues.
struct Exponentials<'a> {
    eigenvalues: [&'a [f64]; 2],
    time: f64,
    exponentials: &'a mut [[Lanes; 2]],
}

impl WithSimd for Exponentials<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [real, imaginary] = self.eigenvalues.map(|part| part.as_chunks::<LANES>().0);
        for (out, parts) in self.exponentials.iter_mut().zip(real.iter().zip(imaginary)) {
            *out = exponential(&scaled(parts.0, parts.1, self.time));
        }
    }
}

/// Sums the free motion and the motion under the loads.
struct Sum<'a> {
    eigenvalues: [&'a [f64]; 2],
    slowest: &'a [f64],
    exponentials: &'a [[Lanes; 2]],
    functions: &'a mut [[Lanes; 2]],
    count: usize,
    step: f64,
    time: f64,
    z: &'a [f64],
    forces: &'a [f64],
    state: &'a mut [f64],
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [real, imaginary] = self.eigenvalues.map(|part| part.as_chunks::<LANES>().0);
        // Chunks of real parts, behind which those of imaginary parts begin, and the fraction τ of the step.
        let (chunks, fraction) = (self.slowest.len(), self.time / self.step);
        let (z, state) = (self.z.as_chunks::<LANES>().0, self.state.as_chunks_mut::<LANES>().0);
        let forces = self.forces.as_chunks::<LANES>().0;
        let powers = self.count - 1;
        for (i, (functions, exponential)) in
            self.functions.chunks_exact_mut(self.count).zip(self.exponentials).enumerate()
        {
            let force = |m: usize| [forces[2 * chunks * m + i], forces[2 * chunks * m + chunks + i]];
            if i < chunks && powers > 0 && self.slowest[i] * self.step >= 1.0 {
                let begin = force(0);
                let free: [Lanes; 2] = [
                    std::array::from_fn(|lane| z[i][lane] - begin[0][lane]),
                    std::array::from_fn(|lane| z[chunks + i][lane] - begin[1][lane]),
                ];
                let mut sum = [[0.0; LANES]; 2];
                for m in (0..powers).rev() {
                    add(&mut sum, fraction, &force(m), |sum, fraction, force| sum * fraction + force);
                }
                add(&mut sum, 1.0, &rotated(exponential, &free[0], &free[1]), |sum, _, free| sum + free);
                [state[i], state[chunks + i]] = sum;
                continue;
            }
            let x = scaled(&real[i], &imaginary[i], self.time);
            integrals(&x, exponential, functions);
            // The eigenvalues behind those of the slots belong to other pairs.
            if i < chunks {
                let (mut sum, mut factor) = (rotated(exponential, &z[i], &z[chunks + i]), self.time);
                for (m, function) in functions[..powers].iter().enumerate() {
                    let [x, y] = force(m);
                    add(&mut sum, factor, &rotated(function, &x, &y), |sum, factor, added| sum + factor * added);
                    factor *= fraction;
                }
                [state[i], state[chunks + i]] = sum;
            }
        }
    }
}

/// Computes ψ₀, ψ₁, … of one chunk of numbers x from eˣ.
#[inline(always)]
fn integrals(x: &[Lanes; 2], exponential: &[Lanes; 2], functions: &mut [[Lanes; 2]]) {
    let square: Lanes = std::array::from_fn(|lane| x[0][lane] * x[0][lane] + x[1][lane] * x[1][lane]);
    let is_slow = square.map(|square| square < 1.0);
    let last = functions.len() - 1;
    let mut slow = [[[0.0; LANES]; 2]; MAX_FUNCTIONS];
    if is_slow.contains(&true) {
        // ψ_last = Σ xʲ/((last + 1)…(last + 1 + j))
        let mut sum = [[0.0; LANES]; 2];
        for j in (0..SERIES_TERMS).rev() {
            sum = affine(&product(x, &sum), 1.0, 1.0 / (last + 1 + j) as f64);
        }
        slow[last] = sum;
        for m in (1..=last).rev() {
            slow[m - 1] = affine(&product(x, &slow[m]), 1.0, 1.0 / m as f64);
        }
        if !is_slow.contains(&false) {
            functions.copy_from_slice(&slow[..=last]);
            return;
        }
    }
    let inverse = inverse(x);
    let mut before = *exponential;
    for (m, (function, slow)) in functions.iter_mut().zip(&slow).enumerate() {
        let factor = m.max(1) as f64;
        before = product(&inverse, &affine(&before, -1.0 / factor, factor));
        for part in 0..2 {
            for lane in 0..LANES {
                function[part][lane] = if is_slow[lane] { slow[part][lane] } else { before[part][lane] };
            }
        }
    }
}

/// Complex numbers times a factor.
#[inline(always)]
fn scaled(re: &Lanes, im: &Lanes, factor: f64) -> [Lanes; 2] {
    [re.map(|value| value * factor), im.map(|value| value * factor)]
}

/// 1/x.
#[inline(always)]
fn inverse([re, im]: &[Lanes; 2]) -> [Lanes; 2] {
    let square: Lanes = std::array::from_fn(|lane| re[lane] * re[lane] + im[lane] * im[lane]);
    [std::array::from_fn(|lane| re[lane] / square[lane]), std::array::from_fn(|lane| -im[lane] / square[lane])]
}

/// (x + real) times a factor.
#[inline(always)]
fn affine([re, im]: &[Lanes; 2], real: f64, factor: f64) -> [Lanes; 2] {
    [re.map(|value| (value + real) * factor), im.map(|value| value * factor)]
}

/// Product of complex numbers.
#[inline(always)]
fn product([a, b]: &[Lanes; 2], [c, d]: &[Lanes; 2]) -> [Lanes; 2] {
    [
        std::array::from_fn(|lane| a[lane] * c[lane] - b[lane] * d[lane]),
        std::array::from_fn(|lane| a[lane] * d[lane] + b[lane] * c[lane]),
    ]
}

/// Products of the block [[a, b], [−b, a]] of a function a + ib with both coordinates.
#[inline(always)]
fn rotated([a, b]: &[Lanes; 2], x: &Lanes, y: &Lanes) -> [Lanes; 2] {
    [
        std::array::from_fn(|lane| a[lane] * x[lane] + b[lane] * y[lane]),
        std::array::from_fn(|lane| a[lane] * y[lane] - b[lane] * x[lane]),
    ]
}

/// Replaces each entry of a sum by a function of it, a factor and an entry.
#[inline(always)]
fn add(sum: &mut [Lanes; 2], factor: f64, entries: &[Lanes; 2], of: impl Fn(f64, f64, f64) -> f64) {
    for (sum, entry) in sum.as_flattened_mut().iter_mut().zip(entries.as_flattened()) {
        *sum = of(*sum, factor, *entry);
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::exponential::propagator::phi::{factorial, phi};

    #[test]
    fn functions_are_those_of_single_numbers() {
        let directions = [0.0, 0.5, 1.0].map(|part: f64| Complex64::from_polar(1.0, part * std::f64::consts::PI));
        for (size, direction) in [0.0_f64, 1e-9, 0.3, 0.999, 1.001, 2.0, 40.0, 900.0]
            .into_iter()
            .flat_map(|size| directions.map(|d| (size, d)))
        {
            let x = direction * size.min(if direction.re > 0.5 { 40.0 } else { size });
            let mut functions = [[[0.0; LANES]; 2]; MAX_FUNCTIONS];
            let parts = |value: Complex64| [[value.re; LANES], [value.im; LANES]];
            integrals(&parts(x), &parts(x.exp()), &mut functions);
            for (m, value) in phi::<{ MAX_FUNCTIONS + 1 }>(x).into_iter().skip(1).enumerate() {
                let found = Complex64::new(functions[m][0][0], functions[m][1][0]) / factorial(m);
                // Six upward divisions at |x| = 1 cancel three digits.
                assert!((found - value).norm() < 1e-12 * value.norm().max(1e-3), "{m} {x}: {found} {value}");
            }
        }
    }
}
