//! The table of a motion that its modes cannot carry: matrix exponentials, without eigenvectors.
//!
//! The shortest step is short enough for a Taylor series; each longer one follows by doubling,
//!
//! ```text
//! e^{2z} − 1 = 2(e^z − 1) + (e^z − 1)²,        φ_m(2z) = 2⁻ᵐ [ e^z φ_m(z) + Σ_{j=1}^m φ_j(z)/(m − j)! ]
//! ```
//!
//! of which the exponential less one is kept, as round-off beside one would double with every step, and φ_m is only
//! ever needed times a load. What the interface sees at the nodes within a step is put together
//! from the shorter ones.

use nalgebra::{DMatrix, DVector, RowDVector};
use num_complex::Complex64;

use super::cache::{InterfaceMaps, PropagatorCache, gram};
use super::packed::Columns;
use super::phi::factorial;
use super::propagator::{StageResponse, StepPropagator, Transition};
use super::quadrature::QuadratureRule;

/// Terms of the series; with |A h| below 1/20 the last is below round-off.
const TERMS: usize = 14;

/// One rung of the ladder.
struct Rung {
    step: f64,
    /// e^{Ah} − 1.
    change: DMatrix<f64>,
    /// φ_m(Ah) b of load k at [k][m − 1].
    phi: Vec<Vec<DVector<f64>>>,
}

/// The steps of the clock of a table.
pub fn levels(matrix: &DMatrix<f64>, cache: &PropagatorCache<'_>) -> Vec<(StepPropagator, StageResponse)> {
    let (rule, maps, time_grid) = (&cache.rule, &cache.maps, &cache.time_grid);
    let finest = time_grid.finest;
    let orders = rule.stages() + 1;
    let loads: Vec<DVector<f64>> = maps.columns.iter().map(|column| DVector::from_column_slice(column)).collect();
    let mut rungs = vec![first(matrix, time_grid.step(finest), &loads, orders)];
    let mut levels = vec![level(matrix, &rungs, rule, maps, cache.phasors(finest))];
    for at in (0..finest).rev() {
        let rung = doubled(&rungs[rungs.len() - 1]);
        rungs.push(rung);
        levels.push(level(matrix, &rungs, rule, maps, cache.phasors(at)));
    }
    levels.reverse();
    levels
}

fn first(matrix: &DMatrix<f64>, step: f64, loads: &[DVector<f64>], orders: usize) -> Rung {
    let scaled = matrix * step;
    let identity = DMatrix::<f64>::identity(matrix.nrows(), matrix.nrows());
    let mut series = identity.clone();
    for term in (2..TERMS).rev() {
        series = &identity + &scaled * series / term as f64;
    }
    let change = &scaled * series;
    let series = |load: &DVector<f64>, m: usize| {
        // Σ zⁱ/(i + m)!
        let mut sum = load / factorial(m + TERMS);
        for i in (0..TERMS).rev() {
            sum = &scaled * sum + load / factorial(m + i);
        }
        sum
    };
    let phi = loads.iter().map(|load| (1..=orders).map(|m| series(load, m)).collect()).collect();
    Rung { step, change, phi }
}

fn doubled(half: &Rung) -> Rung {
    let of_load = |phi: &Vec<DVector<f64>>| {
        let of_order = |m: usize| {
            let mut sum = &phi[m - 1] + &half.change * &phi[m - 1];
            for j in 1..=m {
                sum += &phi[j - 1] / factorial(m - j);
            }
            sum * 0.5_f64.powi(m as i32)
        };
        (1..=phi.len()).map(of_order).collect()
    };
    Rung {
        step: 2.0 * half.step,
        change: &half.change * 2.0 + &half.change * &half.change,
        phi: half.phi.iter().map(of_load).collect(),
    }
}

/// h Σ a_m m! φ_{m+1} b of a polynomial Σ a_m τᵐ.
fn weighted(rung: &Rung, polynomial: &[f64], load: usize) -> DVector<f64> {
    let terms = polynomial.iter().enumerate().map(|(m, a)| &rung.phi[load][m] * (a * factorial(m)));
    terms.sum::<DVector<f64>>() * rung.step
}

/// The level of the last rung; those before it are the shorter ones.
fn level(
    matrix: &DMatrix<f64>,
    rungs: &[Rung],
    rule: &QuadratureRule,
    maps: &InterfaceMaps,
    phasors: Vec<Complex64>,
) -> (StepPropagator, StageResponse) {
    let rung = &rungs[rungs.len() - 1];
    let (stages, loads, scalars) = (rule.stages(), maps.columns.len(), maps.rows.len());
    let columns: Vec<Vec<f64>> = (0..stages)
        .flat_map(|j| (0..loads).map(move |k| (j, k)))
        .map(|(j, k)| weighted(rung, &rule.lagrange[j], k).as_slice().to_vec())
        .collect();
    let defect: Vec<f64> = (0..maps.meshes).flat_map(|k| weighted(rung, &rule.defect, k).as_slice().to_vec()).collect();

    let mut rows = Vec::new();
    let mut response = vec![vec![0.0; stages * loads * scalars]; stages];
    for (i, node) in rule.nodes.iter().enumerate() {
        rows.extend(maps.rows.iter().map(|row| row_after(matrix, rungs, row, *node).as_slice().to_vec()));
        for j in 0..stages {
            for k in 0..loads {
                let state = loaded(matrix, rungs, rule, &maps.columns[k], (j, k), *node);
                for (scalar, row) in maps.rows.iter().enumerate() {
                    let seen = row.iter().zip(state.iter()).map(|(w, z)| w * z).sum();
                    response[i][(j * loads + k) * scalars + scalar] = seen;
                }
            }
        }
    }
    // Row after row: the transpose of how it is stored.
    let transition = Transition::Dense(rung.change.transpose().as_slice().to_vec());
    let columns = Columns::new(&columns, &maps.parts);
    (
        StepPropagator { transition, columns, gram: gram(&defect, maps.meshes) },
        StageResponse::of_rows(maps, &rows, &response, phasors),
    )
}

/// The rungs that make up a part of the last one, longest first, and what is left of it, both in parts of its length.
fn pieces(rungs: &[Rung], part: f64) -> (Vec<usize>, f64) {
    let (mut left, mut pieces) = (part, Vec::new());
    for shorter in 1..rungs.len() {
        let length = 0.5_f64.powi(shorter as i32);
        if left >= length {
            left -= length;
            pieces.push(rungs.len() - 1 - shorter);
        }
    }
    (pieces, left)
}

/// w e^{A·part·h}.
fn row_after(matrix: &DMatrix<f64>, rungs: &[Rung], row: &[f64], part: f64) -> RowDVector<f64> {
    let (pieces, left) = pieces(rungs, part);
    let mut seen = RowDVector::from_row_slice(row);
    for piece in pieces {
        seen += &seen * &rungs[piece].change;
    }
    let rest = left * rungs[rungs.len() - 1].step;
    let mut term = seen.clone();
    for order in 1..TERMS {
        term = &term * matrix * (rest / order as f64);
        seen += &term;
    }
    seen
}

/// The state that the load l_j b_k leaves after a part of the step that began at rest.
fn loaded(
    matrix: &DMatrix<f64>,
    rungs: &[Rung],
    rule: &QuadratureRule,
    load: &[f64],
    (j, k): (usize, usize),
    part: f64,
) -> DVector<f64> {
    let whole = rungs[rungs.len() - 1].step;
    let (pieces, left) = pieces(rungs, part);
    let mut state = DVector::zeros(matrix.nrows());
    let mut begun = 0.0;
    for piece in pieces {
        let rung = &rungs[piece];
        let length = rung.step / whole;
        state += &rung.change * &state;
        for (node, lagrange) in rule.nodes.iter().zip(&rule.lagrange) {
            state += weighted(rung, lagrange, k) * rule.weight(j, begun + node * length);
        }
        begun += length;
    }
    // ż = A z + b l(t): every derivative follows from the one before it.
    let load = DVector::from_column_slice(load);
    let mut polynomial = rule.lagrange[j].clone();
    let value = |polynomial: &[f64]| polynomial.iter().rev().fold(0.0, |sum, a| sum * begun + a);
    let (rest, mut derivative, mut factor) = (left * whole, state.clone(), 1.0);
    for order in 1..TERMS {
        derivative = matrix * &derivative + &load * value(&polynomial);
        factor *= rest / order as f64;
        state += &derivative * factor;
        polynomial = polynomial.iter().enumerate().skip(1).map(|(power, a)| a * power as f64 / whole).collect();
    }
    state
}
