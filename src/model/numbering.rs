//! Numbering of the coordinates: which entry of a vector belongs to which motion of which node.
//!
//! Internal order: for each shaft first bending, (v, w, Γ, −B) for each node, which is (u, φ) as complex numbers, then
//! torsion, θ for each node. User order: for each node v, w, B, Γ, θ; [`Numbering::dofs`] has this order.

use std::ops::Range;

use num_complex::Complex64;

use crate::scene::{Node, Scene};

/// Motion that a coordinate describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DofKind {
    /// Translation along y.
    V,
    /// Translation along z.
    W,
    /// Rotation about y.
    B,
    /// Rotation about z.
    Gamma,
    /// Rotation about x (torsion).
    Twist,
}

impl DofKind {
    /// Name in the user interface.
    pub fn name(self) -> &'static str {
        match self {
            Self::V => "v",
            Self::W => "w",
            Self::B => "B",
            Self::Gamma => "G",
            Self::Twist => "twist",
        }
    }

    /// Whether it belongs to bending.
    pub fn is_lateral(self) -> bool {
        self != Self::Twist
    }
}

/// One degree of freedom.
#[derive(Clone, Copy, Debug)]
pub struct Dof {
    /// Node.
    pub node: Node,
    /// Motion that it describes.
    pub kind: DofKind,
    /// Index in the internal order.
    pub index: usize,
    /// Sign of the internal coordinate: −1 for B, whose internal coordinate is −B, otherwise 1.
    pub sign: f64,
}

/// Coordinates of one shaft.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// Internal index of the first bending coordinate.
    lateral: Option<usize>,
    /// Internal index of the first torsion coordinate.
    torsion: Option<usize>,
    /// Number of nodes.
    nodes: usize,
}

/// Numbering of the coordinates of a scene.
#[derive(Clone, Debug)]
pub struct Numbering {
    blocks: Vec<Block>,
    dofs: Vec<Dof>,
}

impl Numbering {
    /// Numbers the coordinates that the scene requires.
    pub fn new(scene: &Scene) -> Self {
        let mut blocks = Vec::with_capacity(scene.shafts.len());
        let mut dofs = Vec::new();
        let mut len = 0;
        for (shaft, given) in scene.shafts.iter().enumerate() {
            let nodes = given.nodes.len();
            let mut reserve = |needed: bool, count: usize| {
                let start = len;
                len += if needed { count } else { 0 };
                needed.then_some(start)
            };
            let (lateral, torsion) = (reserve(scene.lateral, 4 * nodes), reserve(scene.torsion, nodes));
            let block = Block { lateral, torsion, nodes };
            for node in 0..nodes {
                let mut push = |kind, index, sign| dofs.push(Dof { node: Node { shaft, node }, kind, index, sign });
                if let Some(start) = block.lateral {
                    let first = start + 4 * node;
                    push(DofKind::V, first, 1.0);
                    push(DofKind::W, first + 1, 1.0);
                    push(DofKind::B, first + 3, -1.0);
                    push(DofKind::Gamma, first + 2, 1.0);
                }
                if let Some(start) = block.torsion {
                    push(DofKind::Twist, start + node, 1.0);
                }
            }
            blocks.push(block);
        }
        Self { blocks, dofs }
    }

    /// Number of coordinates.
    pub fn len(&self) -> usize {
        self.dofs.len()
    }

    /// Whether there are no coordinates.
    pub fn is_empty(&self) -> bool {
        self.dofs.is_empty()
    }

    /// Degrees of freedom in user order.
    pub fn dofs(&self) -> &[Dof] {
        &self.dofs
    }

    /// Internal index of the first bending coordinate of a shaft.
    pub fn lateral(&self, shaft: usize) -> Option<usize> {
        self.blocks[shaft].lateral
    }

    /// Internal index of the first torsion coordinate of a shaft.
    pub fn torsion(&self, shaft: usize) -> Option<usize> {
        self.blocks[shaft].torsion
    }

    /// Internal index ranges of the parts that only meshes couple: the bending of every shaft, then the torsion of
    /// every shaft.
    pub fn parts(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let part = |start: usize, per_node: usize, nodes: usize| start..start + per_node * nodes;
        let bending = move |block: &Block| block.lateral.map(|start| part(start, 4, block.nodes));
        let twist = move |block: &Block| block.torsion.map(|start| part(start, 1, block.nodes));
        self.blocks.iter().filter_map(bending).chain(self.blocks.iter().filter_map(twist))
    }

    /// Internal index of v at a node; w, Γ and −B have the next indices.
    pub fn translation(&self, node: Node) -> Option<usize> {
        self.lateral(node.shaft).map(|start| start + 4 * node.node)
    }

    /// Internal index of θ at a node.
    pub fn twist(&self, node: Node) -> Option<usize> {
        self.torsion(node.shaft).map(|start| start + node.node)
    }

    /// First internal index, and number of pairs (v, w) and (Γ, −B), of the bending of each shaft.
    pub fn bending(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.blocks.iter().filter_map(|block| block.lateral.map(|start| (start, 2 * block.nodes)))
    }

    /// Whether a coordinate, by its internal index, belongs to bending.
    pub fn is_lateral(&self, index: usize) -> bool {
        self.pair(index).is_some()
    }

    /// Circular coordinates of a coordinate with its force on them, for a unit force on the coordinate: 1 on p and m for
    /// the first of a pair, ±i for the second, and 1 on θ (`Model::dynamic_stiffness`).
    pub fn circular(&self, index: usize) -> impl Iterator<Item = (usize, Complex64)> + use<> {
        let one = Complex64::ONE;
        let [first, second] = match self.pair(index) {
            None => [Some((index, one)), None],
            Some((start, unknowns, offset)) => {
                let force = if offset % 2 == 0 { one } else { Complex64::i() };
                let p = start + offset / 2;
                [Some((p, force)), Some((p + unknowns, force.conj()))]
            }
        };
        first.into_iter().chain(second)
    }

    /// First index and number of pairs of the bending of the shaft to which an internal index belongs, and its offset.
    fn pair(&self, index: usize) -> Option<(usize, usize, usize)> {
        let block = self.blocks.iter().rev().find(|block| block.lateral.is_some_and(|start| start <= index))?;
        let (start, unknowns) = (block.lateral?, 2 * block.nodes);
        (index < start + 2 * unknowns).then_some((start, unknowns, index - start))
    }

    /// Converts a vector from internal order to user order, n entries.
    pub fn to_user_order<T: Copy + std::ops::Mul<f64, Output = T>>(&self, internal: &[T]) -> Vec<T> {
        self.dofs.iter().map(|dof| internal[dof.index] * dof.sign).collect()
    }
}
