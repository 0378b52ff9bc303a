//! The steps of a clock, and the rows and columns through which a motion is acted on.

use std::cell::OnceCell;
use std::ops::Range;

use num_complex::Complex64;

use super::clock::Clock;
use super::dense;
use super::level::{Passage, Sight};
use super::packed::Panel;
use super::rule::Rule;
use crate::modal::{Form, Linear, Pair};

/// Rows and columns of the interface over a state z.
#[derive(Clone, Debug, Default)]
pub struct Ports {
    /// w: scalars of the motion.
    pub rows: Vec<Vec<f64>>,
    /// b: loads, those of the meshes first.
    pub columns: Vec<Vec<f64>>,
    /// How many of the columns are the meshes'.
    pub meshes: usize,
    /// Slots of the parts of a state that nothing linear couples.
    pub parts: Vec<Range<usize>>,
    /// The laws of the meshes at rest.
    pub tangents: Vec<Tangent>,
    /// Amplitudes of the rows in the synchronous motion, source after source.
    pub synchronous: Vec<Complex64>,
}

/// The law of a mesh at rest: its force is that of δ = g·u over its scalars, and its loads are −g times that.
#[derive(Clone, Debug)]
pub struct Tangent {
    /// Its scalars among all.
    pub scalars: Range<usize>,
    /// g.
    pub gradient: Vec<f64>,
    /// √k where the energy of a state z does not contain that of the mesh; zero where it does.
    pub root: f64,
}

impl Tangent {
    /// g·u √k of scalars: its square is twice the energy that the mesh has beside that of the state.
    pub fn strain(&self, seen: &[f64]) -> f64 {
        self.root * self.along(seen, 0)
    }

    /// g times the scalars, or their rates, that begin at `from`.
    pub fn along(&self, seen: &[f64], from: usize) -> f64 {
        let own = &seen[from + self.scalars.start..from + self.scalars.end];
        own.iter().zip(&self.gradient).map(|(u, g)| u * g).sum()
    }
}

impl Ports {
    /// A state with the strain of the meshes after it: the square of its length is twice the energy of both.
    pub fn with_strain(&self, mut state: Vec<f64>) -> Vec<f64> {
        let product = |row: &Vec<f64>| row.iter().zip(&state).map(|(w, z)| w * z).sum();
        let seen: Vec<f64> = self.rows.iter().take(self.meshes).map(product).collect();
        state.extend(self.tangents.iter().map(|tangent| tangent.strain(&seen)));
        state
    }
}

/// Gram matrix of `count` vectors, one after the other.
pub fn gram(vectors: &[f64], count: usize) -> Panel {
    let len = vectors.len() / count.max(1);
    let vector = |k: usize| &vectors[k * len..(k + 1) * len];
    let dot = |i: usize, j: usize| vector(i).iter().zip(vector(j)).map(|(a, b)| a * b).sum();
    let entries: Vec<f64> = (0..count * count).map(|at| dot(at / count, at % count)).collect();
    Panel::new(&entries, count)
}

/// The steps of a clock, each made when it is first asked for.
#[derive(Clone, Debug)]
pub struct Table<'m> {
    /// The nodes.
    pub rule: Rule,
    /// The lengths of the steps.
    pub clock: Clock,
    /// The linear motion.
    pub linear: &'m Linear,
    /// The rows and columns through which it is acted on.
    pub ports: Ports,
    spins: Vec<f64>,
    /// Gram matrix of the meshes' columns b themselves.
    pub gram: Panel,
    passages: Vec<OnceCell<Passage>>,
    sights: Vec<OnceCell<Sight>>,
}

impl<'m> Table<'m> {
    /// The steps of `clock`; `spins` are those of what turns, rad/s.
    pub fn new(linear: &'m Linear, rule: Rule, ports: Ports, clock: Clock, spins: Vec<f64>) -> Self {
        let columns: Vec<f64> = ports.columns.iter().take(ports.meshes).flatten().copied().collect();
        let gram = gram(&columns, ports.meshes);
        let empty = Self { rule, clock, linear, ports, spins, gram, passages: Vec::new(), sights: Vec::new() };
        let (passages, sights) = match &linear.form {
            Form::Pairs(_) => (vec![OnceCell::new(); clock.finest + 1], vec![OnceCell::new(); clock.finest + 1]),
            // Longer steps are made of shorter ones, so all are made at once.
            Form::Dense(matrix) => dense::levels(matrix, &empty).into_iter().map(|(p, s)| (p.into(), s.into())).unzip(),
        };
        Self { passages, sights, ..empty }
    }

    /// What a step of a level makes of a state.
    pub fn passage(&self, level: usize) -> &Passage {
        self.passages[level]
            .get_or_init(|| Passage::of_pairs(self.pairs(), &self.rule, &self.ports, self.clock.step(level)))
    }

    /// What the nodes of a step of a level see.
    pub fn sight(&self, level: usize) -> &Sight {
        let step = self.clock.step(level);
        self.sights[level]
            .get_or_init(|| Sight::of_pairs(self.pairs(), &self.rule, &self.ports, step, self.turns(level)))
    }

    /// None where all has been made at once.
    fn pairs(&self) -> &[Pair] {
        if let Form::Pairs(pairs) = &self.linear.form { pairs } else { &[] }
    }

    /// e^{iΩ c_i h} of the nodes and the sources.
    pub(super) fn turns(&self, level: usize) -> Vec<Complex64> {
        let times = self.rule.nodes.iter().map(|node| node * self.clock.step(level));
        let at = |time: f64| self.spins.iter().map(move |spin| Complex64::from_polar(1.0, spin * time));
        times.flat_map(at).collect()
    }
}
