//! A step of one length: what it makes of a state, and what its nodes see.
//!
//! With nodes c_i, Lagrange polynomials l_j, interface rows w and columns b, over a step h:
//!
//! ```text
//! u_i = w e^{A c_i h} z + Σ_j H_ij p_j,        H_ij = h ∫₀^{c_i} w e^{A h(c_i − τ)} b l_j(τ) dτ
//! z⁺  = e^{Ah} z + Σ_j h ψ_j b p_j,            ψ_j = ∫₀¹ e^{Ah(1 − τ)} l_j(τ) dτ
//! ```

use num_complex::Complex64;
use pulp::Arch;

use super::cache::{InterfaceMaps, LinearizedContact, gram};
use super::kernel::{self, Aligned, aligned};
use super::packed::{Columns, Panel, Rows};
use super::phi::{Block, COUNT, factorial, phi_of_pair};
use super::quadrature::QuadratureRule;
use crate::modal::ModePair;

/// How a state moves by itself over a step.
#[derive(Clone, Debug)]
pub enum Transition {
    /// ModePair by pair: the lists of a, b, c, d of the blocks [[a, b], [c, d]].
    Pairs([Aligned; 4]),
    /// The matrix less one, row after row.
    Dense(Vec<f64>),
}

/// What a step makes of a state.
#[derive(Clone, Debug)]
pub struct StepPropagator {
    /// e^{Ah}.
    pub transition: Transition,
    /// h ψ_j b of node j and load k at j·loads + k.
    pub columns: Columns,
    /// Gram matrix of the errors that a missed load π(τ) of size one leaves in z, over the meshes' loads.
    pub gram: Panel,
}

impl StepPropagator {
    /// That of a step of length `step` of a motion in pairs.
    pub fn of_pairs(pairs: &[ModePair], rule: &QuadratureRule, maps: &InterfaceMaps, step: f64) -> Self {
        let whole: Vec<_> = pairs.iter().map(|pair| phi_of_pair(pair, step)).collect();
        let list = |row: usize, column: usize| whole.iter().map(|phi| phi[0][row][column]).collect::<Vec<_>>();
        let entry = |row: usize, column: usize| aligned(&list(row, column));
        let transition = Transition::Pairs([entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1)]);
        let mut columns = Vec::with_capacity(rule.stages() * maps.columns.len());
        for lagrange in &rule.lagrange {
            let psi = integrals(lagrange, &whole, 1.0, step);
            columns.extend(maps.columns.iter().map(|load| apply(&psi, load)));
        }
        let chi = integrals(&rule.defect, &whole, 1.0, step);
        let defect = maps.columns[..maps.meshes].iter().map(|load| maps.with_mesh_energy(apply(&chi, load)));
        let defect: Vec<f64> = defect.flatten().collect();
        Self { transition, columns: Columns::new(&columns, &maps.parts), gram: gram(&defect, maps.meshes) }
    }

    /// `out = e^{Ah} z + Σ_j h ψ_j b p_j`; `p` holds the loads at node after node.
    pub fn advance(&self, arch: Arch, p: &[f64], z: &[f64], out: &mut [f64]) {
        match &self.transition {
            Transition::Pairs(blocks) => kernel::advance(arch, blocks, &self.columns, p, z, out),
            Transition::Dense(matrix) => {
                kernel::scalars(arch, matrix, z, out);
                for (out, z) in out.iter_mut().zip(z) {
                    *out += z;
                }
                self.columns.add(p, out);
            }
        }
    }

    /// Energy norm of the error that a missed load of size `defect` at the end of the step leaves.
    pub fn error(&self, arch: Arch, defect: &[f64]) -> f64 {
        kernel::form(arch, &self.gram, defect).max(0.0).sqrt()
    }
}

/// What the nodes of a step see.
#[derive(Clone, Debug)]
pub struct StageResponse {
    /// w e^{A c_i h} of node i and scalar at i·scalars + scalar.
    pub rows: Rows,
    /// H: for each node i column (j, load) after column, of its scalars.
    pub response: Vec<Panel>,
    /// g·u of all nodes and meshes and, where rates matter, g·u̇: under every load, column after column, and under their
    /// own forces −g, row after row.
    pub along: Panel,
    pub own: Vec<f64>,
    /// e^{iΩ c_i h} of node i and source s at i·sources + s.
    pub phasors: Vec<Complex64>,
    /// What nodes see of the synchronous motion for sources that begin at 0 and at π/2, column after column.
    pub synchronous: Panel,
}

impl StageResponse {
    /// That of a step of length `step` of a motion in pairs.
    pub fn of_pairs(
        pairs: &[ModePair],
        rule: &QuadratureRule,
        maps: &InterfaceMaps,
        step: f64,
        phasors: Vec<Complex64>,
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

    /// That of rows of all nodes and scalars, and H_i of each node, column after column.
    pub fn of_rows(maps: &InterfaceMaps, rows: &[Vec<f64>], response: &[Vec<f64>], phasors: Vec<Complex64>) -> Self {
        let (loads, seen) = (maps.columns.len(), maps.rows.len());
        let (stages, meshes) = (response.len(), maps.tangents.len());
        let kinds: Vec<usize> = (0..seen).step_by(maps.meshes.max(1)).collect();
        let (size, felt) = (stages * meshes, kinds.len() * stages * meshes);
        let mut along = vec![0.0; stages * loads * felt];
        for (node, response) in response.iter().enumerate() {
            for (column, seen) in response.chunks_exact(seen.max(1)).enumerate() {
                for (mesh, tangent) in maps.tangents.iter().enumerate() {
                    for (kind, from) in kinds.iter().enumerate() {
                        along[column * felt + kind * size + node * meshes + mesh] = tangent.along(seen, *from);
                    }
                }
            }
        }
        let sources = phasors.len() / stages;
        let mut synchronous = Vec::with_capacity(2 * sources * stages * seen);
        for (source, amplitudes) in maps.synchronous.chunks_exact(seen.max(1)).enumerate() {
            let at_nodes = phasors.iter().skip(source).step_by(sources);
            let turned: Vec<Complex64> =
                at_nodes.flat_map(|turn| amplitudes.iter().map(move |amplitude| amplitude * turn)).collect();
            synchronous.extend(turned.iter().map(|value| value.re));
            synchronous.extend(turned.iter().map(|value| -value.im));
        }
        let mut own = vec![0.0; felt * size];
        for (unit, own) in (0..felt).zip(own.chunks_exact_mut(size.max(1))) {
            for node in 0..stages {
                for (mesh, LinearizedContact { scalars, gradient, .. }) in maps.tangents.iter().enumerate() {
                    let column = |scalar: usize| along[(node * loads + scalar) * felt + unit];
                    own[node * meshes + mesh] = scalars.clone().zip(gradient).map(|(k, g)| column(k) * g).sum();
                }
            }
        }
        let response = response.iter().map(|columns| Panel::new(columns, seen)).collect();
        let (along, synchronous) = (Panel::new(&along, felt), Panel::new(&synchronous, stages * seen));
        Self { rows: Rows::new(rows, &maps.parts), response, along, own, phasors, synchronous }
    }

    /// What a load of one at a column (node, load) adds to a scalar at node `i`.
    pub fn response_of(&self, i: usize, scalar: usize) -> impl Fn(usize) -> f64 + '_ {
        move |column| self.response[i].get(column, scalar)
    }
}

/// `step` ∫₀¹ e^{z(1−τ)} l(cτ) dτ of a polynomial l for every pair, from φ of z: Σ a_m c^m m! φ_{m+1}.
fn integrals(polynomial: &[f64], phi: &[[Block; COUNT]], c: f64, step: f64) -> Vec<Block> {
    let mut factors = [0.0; COUNT - 1];
    for (m, (factor, coefficient)) in factors.iter_mut().zip(polynomial).enumerate() {
        *factor = step * coefficient * c.powi(m as i32) * factorial(m);
    }
    let sum = |phi: &[Block; COUNT]| {
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

/// A block for every slot times a state.
fn apply(blocks: &[Block], state: &[f64]) -> Vec<f64> {
    let (x, y) = state.split_at(blocks.len());
    let side = |row: usize| {
        blocks.iter().zip(x.iter().zip(y)).map(move |(block, (x, y))| block[row][0] * x + block[row][1] * y)
    };
    side(0).chain(side(1)).collect()
}
