//! Propagators from matrix exponentials, for a motion with ill-conditioned modes.
//!
//! The shortest step is short enough for a Taylor series. Doubling gives each longer step:
//!
//! ```text
//! e^{2z} − 1 = 2(e^z − 1) + (e^z − 1)²,        φ_m(2z) = 2⁻ᵐ [ e^z φ_m(z) + Σ_{j=1}^m φ_j(z)/(m − j)! ]
//! ```
//!
//! e^z − 1 is stored, because round-off relative to 1 would double with every step. φ_m is stored as its product with each
//! load. Shorter steps give the interface states at the stages.

use nalgebra::{DMatrix, DVector, RowDVector};
use num_complex::Complex64;

use super::interface_maps::{InterfaceMaps, gram};
use super::packed::Columns;
use super::phi::factorial;
use super::propagator::{StageResponse, StepPropagator, Transition};
use super::quadrature::QuadratureRule;
use super::time_grid::TimeGrid;

/// Terms of the series. With |A h| below 1/20 the last one is below round-off.
const TERMS: usize = 14;

/// The exponential of one step length.
struct DenseStep {
    /// Length h, s.
    step: f64,
    /// e^{Ah} − 1.
    change: DMatrix<f64>,
    /// φ_m(Ah) b of load k at [k][m − 1].
    phi: Vec<Vec<DVector<f64>>>,
}

/// Computes the propagators and stage responses of all step levels of a time grid. `phasors` gives the stage phasors of a
/// level.
pub fn levels(
    matrix: &DMatrix<f64>,
    rule: &QuadratureRule,
    maps: &InterfaceMaps,
    time_grid: &TimeGrid,
    phasors: impl Fn(usize) -> Vec<Complex64>,
) -> Vec<(StepPropagator, StageResponse)> {
    let finest = time_grid.finest;
    let orders = rule.stages() + 1;
    let loads: Vec<DVector<f64>> = maps.columns.iter().map(|column| DVector::from_column_slice(column)).collect();
    let mut steps = vec![shortest(matrix, time_grid.step(finest), &loads, orders)];
    let mut levels = vec![level(matrix, &steps, rule, maps, phasors(finest))];
    for at in (0..finest).rev() {
        let longer = doubled(&steps[steps.len() - 1]);
        steps.push(longer);
        levels.push(level(matrix, &steps, rule, maps, phasors(at)));
    }
    levels.reverse();
    levels
}

/// The shortest step, by Taylor series.
fn shortest(matrix: &DMatrix<f64>, step: f64, loads: &[DVector<f64>], orders: usize) -> DenseStep {
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
    DenseStep { step, change, phi }
}

/// A step of twice the length.
fn doubled(half: &DenseStep) -> DenseStep {
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
    DenseStep {
        step: 2.0 * half.step,
        change: &half.change * 2.0 + &half.change * &half.change,
        phi: half.phi.iter().map(of_load).collect(),
    }
}

/// h Σ a_m m! φ_{m+1} b of a polynomial Σ a_m τᵐ.
fn weighted(step: &DenseStep, polynomial: &[f64], load: usize) -> DVector<f64> {
    let terms = polynomial.iter().enumerate().map(|(m, a)| &step.phi[load][m] * (a * factorial(m)));
    terms.sum::<DVector<f64>>() * step.step
}

/// Propagator and stage response of the last of `steps`; those before it are the shorter ones.
fn level(
    matrix: &DMatrix<f64>,
    steps: &[DenseStep],
    rule: &QuadratureRule,
    maps: &InterfaceMaps,
    phasors: Vec<Complex64>,
) -> (StepPropagator, StageResponse) {
    let step = &steps[steps.len() - 1];
    let (stages, loads, scalars) = (rule.stages(), maps.columns.len(), maps.rows.len());
    let columns: Vec<Vec<f64>> = (0..stages)
        .flat_map(|j| (0..loads).map(move |k| (j, k)))
        .map(|(j, k)| weighted(step, &rule.lagrange[j], k).as_slice().to_vec())
        .collect();
    let defect: Vec<f64> =
        (0..maps.coupled_loads).flat_map(|k| weighted(step, &rule.defect, k).as_slice().to_vec()).collect();

    let mut rows = Vec::new();
    let mut response = vec![vec![0.0; stages * loads * scalars]; stages];
    for (i, node) in rule.nodes.iter().enumerate() {
        rows.extend(maps.rows.iter().map(|row| row_after(matrix, steps, row, *node).as_slice().to_vec()));
        for j in 0..stages {
            for k in 0..loads {
                let state = loaded(matrix, steps, rule, &maps.columns[k], (j, k), *node);
                for (scalar, row) in maps.rows.iter().enumerate() {
                    let value = row.iter().zip(state.iter()).map(|(w, z)| w * z).sum();
                    response[i][(j * loads + k) * scalars + scalar] = value;
                }
            }
        }
    }
    // The kernel reads rows; nalgebra stores columns.
    let transition = Transition::Dense(step.change.transpose().as_slice().to_vec());
    let columns = Columns::new(&columns, &maps.parts);
    (
        StepPropagator { transition, columns, gram: gram(&defect, maps.coupled_loads) },
        StageResponse::of_rows(maps, &rows, &response, phasors),
    )
}

/// Decomposes a fraction of the last step: indices of shorter steps, longest first, and the remaining fraction.
fn pieces(steps: &[DenseStep], part: f64) -> (Vec<usize>, f64) {
    let (mut left, mut pieces) = (part, Vec::new());
    for shorter in 1..steps.len() {
        let length = 0.5_f64.powi(shorter as i32);
        if left >= length {
            left -= length;
            pieces.push(steps.len() - 1 - shorter);
        }
    }
    (pieces, left)
}

/// w e^{A·part·h}, with h the length of the last step.
fn row_after(matrix: &DMatrix<f64>, steps: &[DenseStep], row: &[f64], part: f64) -> RowDVector<f64> {
    let (pieces, left) = pieces(steps, part);
    let mut moved = RowDVector::from_row_slice(row);
    for piece in pieces {
        moved += &moved * &steps[piece].change;
    }
    let rest = left * steps[steps.len() - 1].step;
    let mut term = moved.clone();
    for order in 1..TERMS {
        term = &term * matrix * (rest / order as f64);
        moved += &term;
    }
    moved
}

/// The state after a fraction of the last step under the load l_j b_k, from zero.
fn loaded(
    matrix: &DMatrix<f64>,
    steps: &[DenseStep],
    rule: &QuadratureRule,
    load: &[f64],
    (j, k): (usize, usize),
    part: f64,
) -> DVector<f64> {
    let whole = steps[steps.len() - 1].step;
    let (pieces, left) = pieces(steps, part);
    let mut state = DVector::zeros(matrix.nrows());
    let mut begun = 0.0;
    for piece in pieces {
        let step = &steps[piece];
        let length = step.step / whole;
        state += &step.change * &state;
        for (node, lagrange) in rule.nodes.iter().zip(&rule.lagrange) {
            state += weighted(step, lagrange, k) * rule.weight(j, begun + node * length);
        }
        begun += length;
    }
    // Differentiating ż = A z + b l(t) gives the terms of the Taylor series.
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
