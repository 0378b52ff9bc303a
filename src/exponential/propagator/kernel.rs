//! The two loops over all modes: interface scalars from a state, and a state from loads.
//!
//! Sums run over fixed lanes in plain arithmetic, so that results do not depend on the instruction set. `pulp` selects
//! the instruction set at run time, and the compiler vectorises the loops for it.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::packed::{Aligned, BLOCK_SLOTS, Columns, Group, Rows};
use crate::linalg::LANES;

/// `out[i] = rows[i]·z`, with the rows one after the other.
pub fn scalars(arch: Arch, rows: &[f64], z: &[f64], out: &mut [f64]) {
    arch.dispatch(Scalars { rows, z, out });
}

struct Scalars<'a> {
    rows: &'a [f64],
    z: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Scalars<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (z, len) = (self.z, self.z.len());
        let whole = 0..len / LANES;
        let whole = std::slice::from_ref(&whole);
        // Four rows share one pass over the state.
        let (fours, rest) = self.out.as_chunks_mut::<4>();
        let (head, tail) = self.rows.split_at(4 * len * fours.len());
        for (out, rows) in fours.iter_mut().zip(head.chunks_exact(4 * len.max(1))) {
            *out = products(simd, rows, whole, z);
        }
        for (out, row) in rest.iter_mut().zip(tail.chunks_exact(len.max(1))) {
            [*out] = products(simd, row, whole, z);
        }
    }
}

/// `out[i] = rows[i]·z`.
pub fn row_products(arch: Arch, rows: &Rows, z: &[f64], out: &mut [f64]) {
    row_products_of(arch, rows, 1, z, out);
}

/// The same for several states, one after the other. Each row is read from memory once for all states.
pub fn row_products_of(arch: Arch, rows: &Rows, states: usize, z: &[f64], out: &mut [f64]) {
    arch.dispatch(RowProducts { rows, states, z, out });
}

struct RowProducts<'a> {
    rows: &'a Rows,
    states: usize,
    z: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for RowProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { rows, states, z, out } = self;
        let (seen, size) = (rows.count, rows.size);
        let mut values = &rows.values[..];
        for Group { rows, spans, len } in &rows.groups {
            let (own, rest) = values.split_at(rows.len() * len * LANES);
            values = rest;
            for k in 0..states {
                let (z, out) = (&z[k * size..(k + 1) * size], &mut out[k * seen..(k + 1) * seen]);
                match rows[..] {
                    [a, b, c, d, e, f] => {
                        [out[a], out[b], out[c], out[d], out[e], out[f]] = products(simd, own, spans, z);
                    }
                    [a, b, c, d] => [out[a], out[b], out[c], out[d]] = products(simd, own, spans, z),
                    [a, b] => [out[a], out[b]] = products(simd, own, spans, z),
                    [a] => [out[a]] = products(simd, own, spans, z),
                    _ => {}
                }
            }
        }
    }
}

/// Products of `N` rows with the `spans` of a state, which count chunks of [`LANES`].
#[inline(always)]
fn products<S: Simd, const N: usize>(simd: S, rows: &[f64], spans: &[Range<usize>], z: &[f64]) -> [f64; N] {
    match LANES / S::F64_LANES {
        1 => in_registers::<S, 1, N>(simd, rows, spans, z),
        2 => in_registers::<S, 2, N>(simd, rows, spans, z),
        4 => in_registers::<S, 4, N>(simd, rows, spans, z),
        _ => in_registers::<S, LANES, N>(simd, rows, spans, z),
    }
}

/// The same with `R` registers for a chunk. Explicit registers keep the compiler from interleaving the lanes of different
/// rows, which costs a shuffle in every iteration.
#[inline(always)]
fn in_registers<S: Simd, const R: usize, const N: usize>(
    simd: S,
    rows: &[f64],
    spans: &[Range<usize>],
    z: &[f64],
) -> [f64; N] {
    let [rows, z] = [rows, z].map(|values| S::as_simd_f64s(values).0.as_chunks::<R>().0);
    let mut sums = [[simd.splat_f64s(0.0); R]; N];
    let len = rows.len() / N;
    let mut at = 0;
    for span in spans {
        let z = &z[span.clone()];
        let rows: [&[[S::f64s; R]]; N] = std::array::from_fn(|k| &rows[k * len + at..k * len + at + z.len()]);
        for i in 0..z.len() {
            for (sums, row) in sums.iter_mut().zip(rows) {
                for (r, sum) in sums.iter_mut().enumerate() {
                    *sum = simd.add_f64s(*sum, simd.mul_f64s(row[i][r], z[i][r]));
                }
            }
        }
        at += z.len();
    }
    sums.map(|sums| {
        let mut lanes = [0.0; LANES];
        S::as_mut_simd_f64s(&mut lanes).0.copy_from_slice(&sums);
        let [a, b, c, d, e, f, g, h] = lanes;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    })
}

/// `out = transition·z + Σ columns[k] p[k]`. The transition consists of 2×2 blocks [[a, b], [c, d]], given as four lists.
pub fn advance(arch: Arch, transition: &[Aligned; 4], columns: &Columns, p: &[f64], z: &[f64], out: &mut [f64]) {
    arch.dispatch(Advance { transition, columns, p, z, out });
}

struct Advance<'a> {
    transition: &'a [Aligned; 4],
    columns: &'a Columns,
    p: &'a [f64],
    z: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        let mut values = &self.columns.values[..];
        for part in &self.columns.parts {
            for block in part.blocks() {
                let (own, rest) = values.split_at(2 * block.len() * part.columns.len());
                values = rest;
                if block.len() == BLOCK_SLOTS {
                    self.over::<BLOCK_SLOTS>(block.start, &part.columns, own);
                } else {
                    self.over::<LANES>(block.start, &part.columns, own);
                }
            }
        }
    }
}

impl Advance<'_> {
    /// Computes `N` slots of both coordinates from `columns` with the entries `values`, column after column.
    #[inline(always)]
    fn over<const N: usize>(&mut self, from: usize, columns: &[usize], values: &[f64]) {
        let (x, y) = self.z.split_at(self.z.len() / 2);
        let [a, b, c, d] = self.transition.each_ref().map(|list| &list[from..].as_chunks::<N>().0[0]);
        let [x, y] = [x, y].map(|half| &half[from..].as_chunks::<N>().0[0]);
        let (mut first, mut second) = ([0.0; N], [0.0; N]);
        for lane in 0..N {
            first[lane] = a[lane] * x[lane] + b[lane] * y[lane];
            second[lane] = c[lane] * x[lane] + d[lane] * y[lane];
        }
        for (k, [by_x, by_y]) in columns.iter().zip(values.as_chunks::<N>().0.as_chunks::<2>().0) {
            let p = self.p[*k];
            for lane in 0..N {
                first[lane] += by_x[lane] * p;
                second[lane] += by_y[lane] * p;
            }
        }
        let (x, y) = self.out.split_at_mut(self.out.len() / 2);
        x[from..].as_chunks_mut::<N>().0[0] = first;
        y[from..].as_chunks_mut::<N>().0[0] = second;
    }
}
