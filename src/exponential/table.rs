//! What a step of one length needs: how a state moves by itself, what loads at the nodes add, and what the interface
//! sees of both.
//!
//! With nodes c_i, Lagrange polynomials l_j, interface rows w and columns b, over a step h:
//!
//! ```text
//! u_i = w e^{A c_i h} z + Σ_j H_ij p_j,        H_ij = h ∫₀^{c_i} w e^{A h(c_i − τ)} b l_j(τ) dτ
//! z⁺  = e^{Ah} z + Σ_j h ψ_j b p_j,            ψ_j = ∫₀¹ e^{Ah(1 − τ)} l_j(τ) dτ
//! ```

use num_complex::Complex64;
use pulp::Arch;

use super::phi::{Block, COUNT, factorial, phi_of_pair};
use super::rule::Rule;
use super::{dense, kernel};
use crate::modal::{Form, Linear, Pair};

/// Levels beyond the shortest for events, where they cannot be made later.
pub const HELD_BACK: usize = 4;

/// Rows and columns of the interface over a state z.
#[derive(Clone, Debug, Default)]
pub struct Ports {
    /// w: scalars of the motion.
    pub rows: Vec<Vec<f64>>,
    /// b: loads, those of the meshes first.
    pub columns: Vec<Vec<f64>>,
    /// How many of the columns are the meshes'.
    pub meshes: usize,
}

/// How a state moves by itself over a step.
#[derive(Clone, Debug)]
pub enum Transition {
    /// Pair by pair: the lists of a, b, c, d of the blocks [[a, b], [c, d]].
    Pairs([Vec<f64>; 4]),
    /// The matrix less one, row after row.
    Dense(Vec<f64>),
}

/// A step of one length.
#[derive(Clone, Debug)]
pub struct Level {
    /// Its length h, s.
    pub step: f64,
    /// e^{Ah}.
    pub transition: Transition,
    /// h ψ_j b of node j and load k at j·loads + k, one after the other.
    pub columns: Vec<f64>,
    /// w e^{A c_i h} of node i and scalar at i·scalars + scalar, one after the other.
    pub rows: Vec<f64>,
    /// H: column (j, load) after column, of rows (i, scalar).
    pub response: Vec<f64>,
    /// Gram matrix of the errors that a missed load π(τ) of size one leaves in z, over the meshes' loads.
    pub gram: Vec<f64>,
    /// e^{iΩ c_i h} of node i and source s at i·sources + s.
    pub turns: Vec<Complex64>,
}

impl Level {
    /// The level of a step of length `step` of a motion in pairs.
    pub fn of_pairs(pairs: &[Pair], rule: &Rule, ports: &Ports, step: f64, turns: Vec<Complex64>) -> Self {
        let (slots, stages) = (pairs.len(), rule.stages());
        let (scalars, loads) = (ports.rows.len(), ports.columns.len());
        let len = 2 * slots;
        let mut transition: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; slots]);
        let mut columns = vec![0.0; stages * loads * len];
        let mut rows = vec![0.0; stages * scalars * len];
        let mut response = vec![0.0; stages * scalars * stages * loads];
        let mut missed = vec![0.0; ports.meshes * len];
        for (slot, pair) in pairs.iter().enumerate() {
            let whole = phi_of_pair(pair, step);
            let [[a, b], [c, d]] = whole[0];
            for (list, value) in transition.iter_mut().zip([a, b, c, d]) {
                list[slot] = value;
            }
            let load = |k: usize| [ports.columns[k][slot], ports.columns[k][slots + slot]];
            for j in 0..stages {
                let psi = integral(&rule.lagrange[j], &whole, 1.0);
                for k in 0..loads {
                    let [x, y] = apply(&psi, load(k));
                    let at = (j * loads + k) * len + slot;
                    (columns[at], columns[at + slots]) = (step * x, step * y);
                }
            }
            let chi = integral(&rule.missed, &whole, 1.0);
            for k in 0..ports.meshes {
                let [x, y] = apply(&chi, load(k));
                (missed[k * len + slot], missed[k * len + slot + slots]) = (step * x, step * y);
            }
            for (i, node) in rule.nodes.iter().enumerate() {
                let part = phi_of_pair(pair, node * step);
                let until: Vec<Block> = if rule.explicit {
                    rule.before(i, &phi_of_pair(pair, step / 2.0))
                } else {
                    rule.lagrange.iter().map(|l| integral(l, &part, *node)).collect()
                };
                for (scalar, row) in ports.rows.iter().enumerate() {
                    let (x, y) = (row[slot], row[slots + slot]);
                    let [[a, b], [c, d]] = part[0];
                    let at = (i * scalars + scalar) * len + slot;
                    (rows[at], rows[at + slots]) = (x * a + y * c, x * b + y * d);
                    for (j, integral) in until.iter().enumerate() {
                        for k in 0..loads {
                            let [p, q] = apply(integral, load(k));
                            response[(j * loads + k) * stages * scalars + i * scalars + scalar] +=
                                step * node * (x * p + y * q);
                        }
                    }
                }
            }
        }
        let gram = gram(&missed, ports.meshes);
        Self { step, transition: Transition::Pairs(transition), columns, rows, response, gram, turns }
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
                for (p, column) in p.iter().zip(self.columns.chunks_exact(z.len())) {
                    for (out, value) in out.iter_mut().zip(column) {
                        *out += value * p;
                    }
                }
            }
        }
    }

    /// `u += H p`, as (node, scalar).
    pub fn respond(&self, arch: Arch, p: &[f64], u: &mut [f64]) {
        kernel::accumulate(arch, &self.response, p, u);
    }

    /// Row (node, scalar) of the `rows` of H: what a load of one at a column (node, load) adds to it.
    pub fn response_of(&self, row: usize, rows: usize) -> impl Fn(usize) -> f64 + '_ {
        move |column| self.response[column * rows + row]
    }

    /// Energy norm of the error that a missed load of size `missed` at the end of the step leaves.
    pub fn error(&self, missed: &[f64]) -> f64 {
        form(&self.gram, missed).max(0.0).sqrt()
    }
}

/// xᵀ G x of a symmetric G.
pub fn form(gram: &[f64], x: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (i, row) in gram.chunks_exact(x.len().max(1)).enumerate() {
        let off_diagonal: f64 = row[..i].iter().zip(x).map(|(g, x)| g * x).sum();
        sum += x[i] * (2.0 * off_diagonal + row[i] * x[i]);
    }
    sum
}

/// Gram matrix of `count` vectors, one after the other.
pub fn gram(vectors: &[f64], count: usize) -> Vec<f64> {
    if count == 0 {
        return Vec::new();
    }
    let len = vectors.len() / count;
    let vector = |k: usize| &vectors[k * len..(k + 1) * len];
    let dot = |i: usize, j: usize| vector(i).iter().zip(vector(j)).map(|(a, b)| a * b).sum();
    (0..count * count).map(|at| dot(at / count, at % count)).collect()
}

/// ∫₀¹ e^{z(1−τ)} l(cτ) dτ of a polynomial l, from φ of z: Σ a_m c^m m! φ_{m+1}.
fn integral(polynomial: &[f64], phi: &[Block; COUNT], c: f64) -> Block {
    let mut sum = [[0.0; 2]; 2];
    for (m, coefficient) in polynomial.iter().enumerate() {
        let factor = coefficient * c.powi(m as i32) * factorial(m);
        for (sum, entry) in sum.as_flattened_mut().iter_mut().zip(phi[m + 1].as_flattened()) {
            *sum += factor * entry;
        }
    }
    sum
}

fn apply(block: &Block, [x, y]: [f64; 2]) -> [f64; 2] {
    block.map(|[a, b]| a * x + b * y)
}

/// The tables of a clock: levels 0 to `finest`, each half as long as the one before.
#[derive(Clone, Debug)]
pub struct Table {
    /// The nodes.
    pub rule: Rule,
    /// The levels that have been asked for.
    pub levels: Vec<Level>,
    longest: f64,
    spins: Vec<f64>,
    /// Gram matrix of the meshes' columns b themselves.
    pub gram: Vec<f64>,
}

impl Table {
    /// The table of steps from `longest` down to `longest`·2^−`finest`; `spins` are those of what turns, rad/s.
    pub fn new(linear: &Linear, rule: Rule, ports: &Ports, longest: f64, finest: usize, spins: Vec<f64>) -> Self {
        let columns: Vec<f64> = ports.columns.iter().take(ports.meshes).flatten().copied().collect();
        let gram = gram(&columns, ports.meshes);
        let mut table = Self { rule, levels: Vec::new(), longest, spins, gram };
        match &linear.form {
            Form::Pairs(_) => table.reach(linear, ports, finest),
            Form::Dense(matrix) => {
                // Longer steps are made of shorter ones, so the shortest comes first.
                let finest = finest + HELD_BACK;
                table.levels = dense::levels(matrix, &table.rule, ports, longest, finest, |level| table.turns(level));
            }
        }
        table
    }

    /// Makes the levels down to `level` that are not there yet.
    pub fn reach(&mut self, linear: &Linear, ports: &Ports, level: usize) {
        if let Form::Pairs(pairs) = &linear.form {
            while self.levels.len() <= level {
                let next = self.levels.len();
                let level = Level::of_pairs(pairs, &self.rule, ports, self.step(next), self.turns(next));
                self.levels.push(level);
            }
        }
    }

    fn step(&self, level: usize) -> f64 {
        self.longest * 0.5_f64.powi(level as i32)
    }

    fn turns(&self, level: usize) -> Vec<Complex64> {
        let times = self.rule.nodes.iter().map(|node| node * self.step(level));
        let at = |time: f64| self.spins.iter().map(move |spin| Complex64::from_polar(1.0, spin * time));
        times.flat_map(at).collect()
    }
}
