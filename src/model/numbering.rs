//! Which coordinate of a vector belongs to which motion of which node.
//!
//! Inside, a shaft's bending comes first, (v, w, Γ, −B) node after node, which is (u, φ) as complex numbers; its twist
//! follows, θ node after node. Outside, a node has v, w, B, Γ, θ together; [`Numbering::dofs`] stands in that order.

use std::ops::Range;

use crate::scene::{Node, Scene};

/// What a coordinate measures.
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
    /// Twist about x.
    Twist,
}

impl DofKind {
    /// The name that users read.
    pub fn name(self) -> &'static str {
        match self {
            Self::V => "v",
            Self::W => "w",
            Self::B => "B",
            Self::Gamma => "G",
            Self::Twist => "twist",
        }
    }

    /// Whether it is a bending motion.
    pub fn is_lateral(self) -> bool {
        self != Self::Twist
    }
}

/// One degree of freedom, in the outside order.
#[derive(Clone, Copy, Debug)]
pub struct Dof {
    /// Node.
    pub node: Node,
    /// What it measures.
    pub kind: DofKind,
    /// Its index inside.
    pub index: usize,
    /// ±1: the inside coordinate is −B.
    pub sign: f64,
}

#[derive(Clone, Copy, Debug)]
struct Block {
    lateral: Option<usize>,
    torsion: Option<usize>,
    nodes: usize,
}

/// The numbering of a scene.
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
            let mut take = |wanted: bool, count: usize| {
                let start = len;
                len += if wanted { count } else { 0 };
                wanted.then_some(start)
            };
            let (lateral, torsion) = (take(scene.lateral, 4 * nodes), take(scene.torsion, nodes));
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

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.dofs.is_empty()
    }

    /// The coordinates in the outside order.
    pub fn dofs(&self) -> &[Dof] {
        &self.dofs
    }

    /// First bending coordinate of a shaft.
    pub fn lateral(&self, shaft: usize) -> Option<usize> {
        self.blocks[shaft].lateral
    }

    /// First twist of a shaft.
    pub fn torsion(&self, shaft: usize) -> Option<usize> {
        self.blocks[shaft].torsion
    }

    /// MeshCoordinates that only meshes couple to others: the bending of every shaft, then the twist of every shaft, so
    /// that what a mesh sees of its shafts stands side by side.
    pub fn parts(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let part = |start: usize, each: usize, nodes: usize| start..start + each * nodes;
        let bending = move |block: &Block| block.lateral.map(|start| part(start, 4, block.nodes));
        let twist = move |block: &Block| block.torsion.map(|start| part(start, 1, block.nodes));
        self.blocks.iter().filter_map(bending).chain(self.blocks.iter().filter_map(twist))
    }

    /// Index of v at a node; w, Γ and −B follow.
    pub fn translation(&self, node: Node) -> Option<usize> {
        self.lateral(node.shaft).map(|start| start + 4 * node.node)
    }

    /// Index of θ at a node.
    pub fn twist(&self, node: Node) -> Option<usize> {
        self.torsion(node.shaft).map(|start| start + node.node)
    }

    /// A vector from the inside order to the outside one.
    pub fn outside<T: Copy + std::ops::Mul<f64, Output = T>>(&self, inside: &[T]) -> Vec<T> {
        self.dofs.iter().map(|dof| inside[dof.index] * dof.sign).collect()
    }
}
