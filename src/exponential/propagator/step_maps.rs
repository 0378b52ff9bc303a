//! Linear maps of a step of one length: to the state at its end, and to the interface states at its stages.
//!
//! With the nodes c_i, the Lagrange polynomials l_j, the interface rows w and the columns b, over a step h:
//!
//! ```text
//! u_i = w e^{A c_i h} z + Σ_j H_ij p_j,        H_ij = h ∫₀^{c_i} w e^{A h(c_i − τ)} b l_j(τ) dτ
//! z⁺  = e^{Ah} z + Σ_j h ψ_j b p_j,            ψ_j = ∫₀¹ e^{Ah(1 − τ)} l_j(τ) dτ
//! ```

use num_complex::Complex64;
use pulp::Arch;

use super::interface_maps::{InterfaceMaps, LinearizedDirection, gram};
use super::kernel;
use super::packed::{Aligned, Columns, Panel, Rows, aligned};
use super::panel_kernel;
use super::phi::{Block, PHI_COUNT, factorial, phi_of_pair};
use super::quadrature::QuadratureRule;
use crate::modal::ModePair;

/// Map from the state and the stage loads to the state at the end of a step.
#[derive(Clone, Debug)]
pub struct StepPropagator {
    /// e^{Ah}: one block [[a, b], [c, d]] for each mode pair, as the lists of a, b, c and d.
    pub transition: [Aligned; 4],
    /// h ψ_j b of stage j and load k, at j·loads + k.
    pub columns: Columns,
    /// Gram matrix of h ∫₀¹ e^{Ah(1−τ)} π(τ) dτ b over the loads that depend on the motion: a load defect
    /// d π(τ) causes the error norm √(dᵀ G d).
    pub gram: Panel,
}

impl StepPropagator {
    /// Computes the propagator of a step of length `step`, s, of a motion in mode pairs.
    pub fn of_pairs(pairs: &[ModePair], rule: &QuadratureRule, maps: &InterfaceMaps, step: f64) -> Self {
        let whole: Vec<_> = pairs.iter().map(|pair| phi_of_pair(pair, step)).collect();
        let list = |row: usize, column: usize| whole.iter().map(|phi| phi[0][row][column]).collect::<Vec<_>>();
        let entry = |row: usize, column: usize| aligned(&list(row, column));
        let transition = [entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1)];
        let mut columns = Vec::with_capacity(rule.stages() * maps.columns.len());
        for lagrange in &rule.lagrange {
            let psi = integrals(lagrange, &whole, 1.0, step);
            columns.extend(maps.columns.iter().map(|load| apply(&psi, load)));
        }
        let chi = integrals(&rule.defect, &whole, 1.0, step);
        let defect = maps.columns[..maps.coupled_loads].iter().map(|load| maps.with_mesh_energy(apply(&chi, load)));
        let defect: Vec<f64> = defect.flatten().collect();
        Self { transition, columns: Columns::new(&columns, &maps.parts), gram: gram(&defect, maps.coupled_loads) }
    }

    /// `out = e^{Ah} z + Σ_j h ψ_j b p_j`. `p` holds the loads stage after stage.
    pub fn advance(&self, arch: Arch, p: &[f64], z: &[f64], out: &mut [f64]) {
        kernel::advance(arch, &self.transition, &self.columns, p, z, out);
    }

    /// Energy norm of the error from a load defect d π(τ) with d = `defect`, N.
    pub fn error(&self, arch: Arch, defect: &[f64]) -> f64 {
        panel_kernel::quadratic_form(arch, &self.gram, defect).max(0.0).sqrt()
    }
}

/// Map from the state and the stage loads to the interface states at the stages.
#[derive(Clone, Debug)]
pub struct StageResponse {
    /// w e^{A c_i h} of stage i and each scalar, at i·scalars + scalar.
    pub rows: Rows,
    /// H_ij: for each stage i one column for each (j, load).
    pub response: Vec<Panel>,
    /// g·u of all stages and directions and, where rates matter, g·u̇, under unit loads: one column for each load.
    pub along: Panel,
    /// G and Ġ: changes of −g·u and −g·u̇ under unit forces of all stages and directions, row after row.
    pub own: Vec<f64>,
    /// Interface states of the synchronous motion: for each source one column for the phasor 1 and one for i.
    pub synchronous: Panel,
}

impl StageResponse {
    /// Computes the response of a step of length `step`, s, of a motion in mode pairs; `phasors` are e^{iΩ c_i h} of every stage i
    /// and source, stage after stage.
    pub fn of_pairs(
        pairs: &[ModePair],
        rule: &QuadratureRule,
        maps: &InterfaceMaps,
        step: f64,
        phasors: &[Complex64],
    ) -> Self {
        let (arch, stages, scalars, loads) = (Arch::new(), rule.stages(), maps.rows.len(), maps.columns.len());
        let bare = maps.rows.concat();
        let of_step = |part: f64| -> Vec<_> { pairs.iter().map(|pair| phi_of_pair(pair, part * step)).collect() };
        let half = if rule.explicit { of_step(0.5) } else { Vec::new() };
        let mut rows = Vec::with_capacity(stages * scalars);
        let mut response = vec![vec![0.0; stages * loads * scalars]; stages];
        for ((i, node), response) in rule.nodes.iter().enumerate().zip(&mut response) {
            let part = of_step(*node);
            let moved: Vec<Block> = part.iter().map(|phi| transposed(phi[0])).collect();
            rows.extend(maps.rows.iter().map(|row| apply(&moved, row)));
            let before: Vec<Vec<Block>> = half.iter().map(|half| rule.before(i, half)).collect();
            let mut to = response.chunks_exact_mut(scalars.max(1));
            for (j, lagrange) in rule.lagrange.iter().enumerate() {
                let until = if rule.explicit {
                    before.iter().map(|before| scaled(before[j], step * node)).collect()
                } else {
                    integrals(lagrange, &part, *node, step * node)
                };
                for (load, to) in maps.columns.iter().zip(&mut to) {
                    kernel::scalars(arch, &bare, &apply(&until, load), to);
                }
            }
        }
        Self::of_rows(maps, &rows, &response, phasors)
    }

    /// Assembles the response from the rows of all stages and scalars, and from H_i of each stage, column after column.
    pub fn of_rows(maps: &InterfaceMaps, rows: &[Vec<f64>], response: &[Vec<f64>], phasors: &[Complex64]) -> Self {
        let (loads, seen) = (maps.columns.len(), maps.rows.len());
        let (stages, directions) = (response.len(), maps.tangents.len());
        // First rows of the scalars and of their rates.
        let kinds: &[usize] = if maps.has_rates { &[0, maps.scalars] } else { &[0] };
        let (size, felt) = (stages * directions, kinds.len() * stages * directions);
        let mut along = vec![0.0; stages * loads * felt];
        for (node, response) in response.iter().enumerate() {
            for (column, seen) in response.chunks_exact(seen.max(1)).enumerate() {
                for (direction, tangent) in maps.tangents.iter().enumerate() {
                    for (kind, from) in kinds.iter().enumerate() {
                        along[column * felt + kind * size + node * directions + direction] = tangent.along(seen, *from);
                    }
                }
            }
        }
        let sources = phasors.len() / stages;
        let mut synchronous = Vec::with_capacity(2 * sources * stages * seen);
        for (source, amplitudes) in maps.synchronous.chunks_exact(seen.max(1)).enumerate() {
            let at_nodes = phasors.iter().skip(source).step_by(sources);
            let rotated: Vec<Complex64> =
                at_nodes.flat_map(|phasor| amplitudes.iter().map(move |amplitude| amplitude * phasor)).collect();
            synchronous.extend(rotated.iter().map(|value| value.re));
            synchronous.extend(rotated.iter().map(|value| -value.im));
        }
        let mut own = vec![0.0; felt * size];
        for (unit, own) in (0..felt).zip(own.chunks_exact_mut(size.max(1))) {
            for node in 0..stages {
                for (direction, LinearizedDirection { scalars, gradient, .. }) in maps.tangents.iter().enumerate() {
                    let column = |scalar: usize| along[(node * loads + scalar) * felt + unit];
                    own[node * directions + direction] =
                        scalars.clone().zip(gradient).map(|(k, g)| column(k) * g).sum();
                }
            }
        }
        let response = response.iter().map(|columns| Panel::new(columns, seen)).collect();
        let (along, synchronous) = (Panel::new(&along, felt), Panel::new(&synchronous, stages * seen));
        Self { rows: Rows::new(rows, &maps.parts), response, along, own, synchronous }
    }

    /// Change of a scalar at stage `i` under a unit load of a column (stage, load).
    pub fn response_of(&self, i: usize, scalar: usize) -> impl Fn(usize) -> f64 + '_ {
        move |column| self.response[i].get(column, scalar)
    }
}

/// `step` ∫₀¹ e^{z(1−τ)} l(cτ) dτ = Σ a_m c^m m! φ_{m+1} of a polynomial l, for every mode pair, from its φ-functions.
fn integrals(polynomial: &[f64], phi: &[[Block; PHI_COUNT]], c: f64, step: f64) -> Vec<Block> {
    let mut factors = [0.0; PHI_COUNT - 1];
    for (m, (factor, coefficient)) in factors.iter_mut().zip(polynomial).enumerate() {
        *factor = step * coefficient * c.powi(m as i32) * factorial(m);
    }
    let sum = |phi: &[Block; PHI_COUNT]| {
        let mut sum = [[0.0; 2]; 2];
        for (factor, phi) in factors.iter().zip(&phi[1..]) {
            for (sum, entry) in sum.as_flattened_mut().iter_mut().zip(phi.as_flattened()) {
                *sum += factor * entry;
            }
        }
        sum
    };
    phi.iter().map(sum).collect()
}

fn transposed([[a, b], [c, d]]: Block) -> Block {
    [[a, c], [b, d]]
}

fn scaled(block: Block, factor: f64) -> Block {
    block.map(|row| row.map(|entry| factor * entry))
}

/// The product of one block for each slot with a state.
fn apply(blocks: &[Block], state: &[f64]) -> Vec<f64> {
    let (x, y) = state.split_at(blocks.len());
    let side = |row: usize| {
        blocks.iter().zip(x.iter().zip(y)).map(move |(block, (x, y))| block[row][0] * x + block[row][1] * y)
    };
    side(0).chain(side(1)).collect()
}
