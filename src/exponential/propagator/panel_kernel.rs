//! Loops over short columns, such as the interface states of all stages.
//!
//! Sums run over fixed lanes in plain arithmetic, so that results do not depend on the instruction set.

use pulp::{Arch, Simd, WithSimd};

use super::packed::Panel;
use crate::linalg::LANES;

/// Lanes of one register of AVX2.
const NARROW_LANES: usize = LANES / 2;

/// Extrapolates vectors from the stages and the end of a step to the stages of the next. `nodes` holds the vectors of the
/// stages, one after the other. For each new stage `weights` holds the weight of the end, then those of the stages.
pub fn extrapolate(arch: Arch, end: &[f64], nodes: &[f64], weights: &[f64], out: &mut [f64]) {
    arch.dispatch(Extrapolate { end, nodes, weights, out });
}

struct Extrapolate<'a> {
    end: &'a [f64],
    nodes: &'a [f64],
    weights: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Extrapolate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let each = self.end.len().max(1);
        let known = self.nodes.len() / each + 1;
        for (out, weights) in self.out.chunks_exact_mut(each).zip(self.weights.chunks_exact(known)) {
            out.iter_mut().zip(self.end).for_each(|(out, end)| *out = weights[0] * end);
            Accumulate { columns: self.nodes, p: &weights[1..], out }.with_simd(simd);
        }
    }
}

/// `out += Σ columns[k] p[k]`, with the columns one after the other.
pub fn accumulate(arch: Arch, columns: &[f64], p: &[f64], out: &mut [f64]) {
    arch.dispatch(Accumulate { columns, p, out });
}

struct Accumulate<'a> {
    columns: &'a [f64],
    p: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Accumulate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        let len = self.out.len();
        let wide = len / LANES * LANES;
        let narrow = len / NARROW_LANES * NARROW_LANES;
        self.over::<LANES>(0, wide);
        self.over::<NARROW_LANES>(wide, narrow);
        self.over::<1>(narrow, len);
    }
}

impl Accumulate<'_> {
    #[inline(always)]
    fn over<const N: usize>(&mut self, from: usize, to: usize) {
        let len = self.out.len();
        for (i, out) in self.out[from..to].as_chunks_mut::<N>().0.iter_mut().enumerate() {
            let at = from + i * N;
            let mut sum = *out;
            for (p, column) in self.p.iter().zip(self.columns.chunks_exact(len)) {
                let column = &column[at..at + N];
                for lane in 0..N {
                    sum[lane] += column[lane] * p;
                }
            }
            *out = sum;
        }
    }
}

/// `out += Σ columns[k] p[k]` with the columns of a panel.
pub fn accumulate_panel(arch: Arch, panel: &Panel, p: &[f64], out: &mut [f64]) {
    arch.dispatch(AccumulatePanel { panel, p, out });
}

struct AccumulatePanel<'a> {
    panel: &'a Panel,
    p: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for AccumulatePanel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let values = self.panel.values.as_chunks::<LANES>().0;
        let (whole, rest) = self.out.as_chunks_mut::<LANES>();
        let mut columns = values.chunks_exact(self.p.len().max(1));
        for (out, columns) in whole.iter_mut().zip(&mut columns) {
            let mut sum = *out;
            add_columns(&mut sum, self.p, columns);
            *out = sum;
        }
        // The remaining entries fit into one chunk.
        if let (Some(columns), false) = (columns.next(), rest.is_empty()) {
            if rest.len() <= NARROW_LANES {
                add_rest::<NARROW_LANES>(rest, self.p, columns)
            } else {
                add_rest::<LANES>(rest, self.p, columns)
            }
        }
    }
}

/// xᵀ P x of a square, symmetric panel P.
pub fn quadratic_form(arch: Arch, panel: &Panel, x: &[f64]) -> f64 {
    arch.dispatch(QuadraticForm { panel, x })
}

struct QuadraticForm<'a> {
    panel: &'a Panel,
    x: &'a [f64],
}

impl WithSimd for QuadraticForm<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let chunks = self.panel.values.as_chunks::<LANES>().0.chunks_exact(self.x.len().max(1));
        let mut form = 0.0;
        for (columns, own) in chunks.zip(self.x.chunks(LANES)) {
            let mut sum = [0.0; LANES];
            add_columns(&mut sum, self.x, columns);
            form += own.iter().zip(sum).map(|(x, sum)| x * sum).sum::<f64>();
        }
        form
    }
}

#[inline(always)]
fn add_rest<const N: usize>(out: &mut [f64], p: &[f64], columns: &[[f64; LANES]]) {
    let mut sum = [0.0; N];
    add_columns(&mut sum, p, columns);
    for (out, sum) in out.iter_mut().zip(sum) {
        *out += sum;
    }
}

#[inline(always)]
fn add_columns<const N: usize>(sum: &mut [f64; N], p: &[f64], columns: &[[f64; LANES]]) {
    for (p, column) in p.iter().zip(columns) {
        for lane in 0..N {
            sum[lane] += column[lane] * p;
        }
    }
}
