//! Numbering of the coordinates: which entry of a vector belongs to which motion of which node.
//!
//! Order of the core: for each shaft first bending, (v, w, Γ, −B) for each node, which is (u, φ) as complex numbers, then
//! the internal coordinates of bending of each element, as complex numbers too; then torsion, θ for each node and the
//! internal coordinates of the twist of each element; then axial motion, u in the same way. Last come supports and housings:
//! v, w, and Γ, −B, θ if they rotate, and u if they move along the axis.
//! User order: for each node u, v, w, B, Γ, θ; then for each element and
//! each degree of its shape functions the same directions; then supports and housings. [`Numbering::dofs`] has this order.

use std::collections::HashMap;
use std::ops::Range;

use crate::element::{BendingFunction, rod_degrees};
use crate::scene::{Node, Scene, Shaft};

/// Motion that a coordinate describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DofKind {
    /// Translation along x, the axis of the shaft.
    Axial,
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
    /// Mode of an elastic housing, with its number as the degree.
    Mode,
}

impl DofKind {
    /// Name in the user interface.
    pub fn name(self) -> &'static str {
        match self {
            Self::Axial => "u",
            Self::V => "v",
            Self::W => "w",
            Self::B => "B",
            Self::Gamma => "G",
            Self::Twist => "twist",
            Self::Mode => "mode",
        }
    }

    /// Whether it belongs to bending.
    pub fn is_lateral(self) -> bool {
        matches!(self, Self::V | Self::W | Self::B | Self::Gamma)
    }
}

/// One degree of freedom.
#[derive(Clone, Copy, Debug)]
pub struct Dof {
    /// Node; for an internal coordinate the first node of its element.
    pub node: Node,
    /// Motion that it describes.
    pub kind: DofKind,
    /// Degree of the shape function of an internal coordinate; `None` at a node.
    pub degree: Option<usize>,
    /// Index in the order of the core.
    pub index: usize,
    /// Sign of the coordinate of the core: −1 for B, whose coordinate there is −B, otherwise 1.
    pub sign: f64,
}

impl Dof {
    /// Name in the user interface, with the degree of an internal coordinate.
    pub fn name(&self) -> String {
        let degree = self.degree.map_or_else(String::new, |degree| degree.to_string());
        self.kind.name().to_owned() + &degree
    }
}

/// Coordinates of one shaft.
#[derive(Clone, Debug)]
struct Block {
    /// Indices of the bending coordinates in the order of the core.
    lateral: Option<Range<usize>>,
    /// Indices of the torsion coordinates in the order of the core.
    torsion: Option<Range<usize>>,
    /// Indices of the axial coordinates in the order of the core.
    axial: Option<Range<usize>>,
    /// Indices of the modes of an elastic housing in the order of the core.
    modes: Option<Range<usize>>,
}

/// Numbering of the coordinates of a scene.
#[derive(Clone, Debug)]
pub struct Numbering {
    blocks: Vec<Block>,
    dofs: Vec<Dof>,
    /// Number of coordinates of nodes, which are the first of `dofs`.
    nodal: usize,
    /// Number of coordinates of shafts.
    of_shafts: usize,
}

impl Numbering {
    /// Numbers the coordinates that the scene requires.
    pub fn new(scene: &Scene) -> Self {
        let mut len = 0;
        let mut reserve = |needed: bool, count: usize| {
            let start = len;
            len += if needed { count } else { 0 };
            needed.then_some(start..len)
        };
        let block = |(index, shaft): (usize, &Shaft)| {
            let bends = !scene.only_twists(index);
            let (nodes, elements) = (shaft.nodes.len(), shaft.elements.len());
            let bending = BendingFunction::all(shaft.degree, shaft.shear).len();
            let rod = nodes + rod_degrees(shaft.degree).count() * elements;
            Block {
                lateral: reserve(scene.lateral && bends, 4 * nodes + 2 * bending * elements),
                torsion: reserve(scene.torsion, rod),
                axial: reserve(scene.axial && bends, rod),
                modes: None,
            }
        };
        let mut blocks: Vec<Block> = scene.shafts.iter().enumerate().map(block).collect();
        blocks.extend(scene.housings.iter().map(|housing| {
            let (rotates, modes) = (housing.inertia.is_some(), housing.mode_count());
            Block {
                lateral: reserve(scene.lateral && modes == 0, if rotates { 4 } else { 2 }),
                torsion: reserve(scene.lateral && rotates, 1),
                axial: reserve(scene.axial && housing.axial.is_some(), 1),
                modes: reserve(scene.lateral && modes > 0, modes),
            }
        }));
        let mut dofs = Vec::with_capacity(len);
        for (shaft, (given, block)) in scene.shafts.iter().zip(&blocks).enumerate() {
            for node in 0..given.nodes.len() {
                push_node(&mut dofs, Node { shaft, node }, block);
            }
        }
        let nodal = dofs.len();
        for (shaft, (given, block)) in scene.shafts.iter().zip(&blocks).enumerate() {
            for element in 0..given.elements.len() {
                push_element(&mut dofs, Node { shaft, node: element }, given, block);
            }
        }
        let of_shafts = dofs.len();
        for (shaft, block) in blocks.iter().enumerate().skip(scene.shafts.len()) {
            push_housing(&mut dofs, Node { shaft, node: 0 }, block);
        }
        Self { blocks, dofs, nodal, of_shafts }
    }

    /// Number of coordinates of shafts; those of supports and housings follow.
    pub fn end_of_shafts(&self) -> usize {
        self.of_shafts
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

    /// Degrees of freedom of the nodes of shafts, the first ones in user order.
    pub fn nodal_dofs(&self) -> &[Dof] {
        &self.dofs[..self.nodal]
    }

    /// Index, in the order of the core, of the first bending coordinate of a shaft.
    pub fn lateral(&self, shaft: usize) -> Option<usize> {
        self.blocks[shaft].lateral.as_ref().map(|range| range.start)
    }

    /// Index, in the order of the core, of the first torsion coordinate of a shaft.
    pub fn torsion(&self, shaft: usize) -> Option<usize> {
        self.blocks[shaft].torsion.as_ref().map(|range| range.start)
    }

    /// Index, in the order of the core, of the first axial coordinate of a shaft.
    pub fn axial(&self, shaft: usize) -> Option<usize> {
        self.blocks[shaft].axial.as_ref().map(|range| range.start)
    }

    /// Index ranges, in the order of the core, of the parts that only meshes and links couple: the bending of every shaft,
    /// then the torsion and the axial motion of every shaft.
    pub fn uncoupled_parts(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let bending = self.blocks.iter().filter_map(|block| block.lateral.clone());
        let torsion = self.blocks.iter().filter_map(|block| block.torsion.clone());
        bending.chain(torsion).chain(self.blocks.iter().filter_map(|block| block.axial.clone()))
    }

    /// Index, in the order of the core, of v at a node; w, Γ and −B have the next indices.
    pub fn translation(&self, node: Node) -> Option<usize> {
        self.lateral(node.shaft).map(|start| start + 4 * node.node)
    }

    /// Indices, in the order of the core, of the modes of an elastic housing.
    pub fn modes(&self, node: Node) -> Option<Range<usize>> {
        self.blocks[node.shaft].modes.clone()
    }

    /// Index, in the order of the core, of θ at a node.
    pub fn twist(&self, node: Node) -> Option<usize> {
        self.torsion(node.shaft).map(|start| start + node.node)
    }

    /// Index, in the order of the core, of u at a node.
    pub fn displacement_along(&self, node: Node) -> Option<usize> {
        self.axial(node.shaft).map(|start| start + node.node)
    }

    /// Writes a vector of a numbering with the same nodes and elements of lower degree in this numbering. The shape
    /// functions are hierarchical: all further coordinates are zero. `None` if a coordinate is missing here.
    pub fn embed(&self, coarser: &Self, vector: &[f64]) -> Option<Vec<f64>> {
        let key = |dof: &Dof| (dof.node.shaft, dof.node.node, dof.kind.name(), dof.degree);
        let own: HashMap<_, usize> = self.dofs.iter().map(|dof| (key(dof), dof.index)).collect();
        let mut embedded = vec![0.0; self.len()];
        for dof in &coarser.dofs {
            embedded[*own.get(&key(dof))?] = vector[dof.index];
        }
        Some(embedded)
    }

    /// Converts a vector from the order of the core to user order, n entries.
    pub fn to_user_order<T: Copy + std::ops::Mul<f64, Output = T>>(&self, internal: &[T]) -> Vec<T> {
        self.dofs.iter().map(|dof| internal[dof.index] * dof.sign).collect()
    }

    /// Converts a vector from user order to the order of the core, n entries.
    pub fn in_core_order(&self, outside: &[f64]) -> Vec<f64> {
        let mut inside = vec![0.0; outside.len()];
        for (dof, value) in self.dofs.iter().zip(outside) {
            inside[dof.index] = value * dof.sign;
        }
        inside
    }
}

/// Appends the coordinates of a node.
fn push_node(dofs: &mut Vec<Dof>, node: Node, block: &Block) {
    let mut push = |kind, index, sign| dofs.push(Dof { node, kind, degree: None, index, sign });
    if let Some(range) = &block.axial {
        push(DofKind::Axial, range.start + node.node, 1.0);
    }
    if let Some(range) = &block.lateral {
        let first = range.start + 4 * node.node;
        push(DofKind::V, first, 1.0);
        push(DofKind::W, first + 1, 1.0);
        push(DofKind::B, first + 3, -1.0);
        push(DofKind::Gamma, first + 2, 1.0);
    }
    if let Some(range) = &block.torsion {
        push(DofKind::Twist, range.start + node.node, 1.0);
    }
}

/// Appends the coordinates of a support or housing.
fn push_housing(dofs: &mut Vec<Dof>, node: Node, block: &Block) {
    let modes = block.modes.clone().into_iter().flatten().enumerate();
    dofs.extend(modes.map(|(number, index)| Dof {
        node,
        kind: DofKind::Mode,
        degree: Some(number + 1),
        index,
        sign: 1.0,
    }));
    let mut push = |kind, index, sign| dofs.push(Dof { node, kind, degree: None, index, sign });
    if let Some(range) = &block.axial {
        push(DofKind::Axial, range.start, 1.0);
    }
    if let Some(range) = &block.lateral {
        push(DofKind::V, range.start, 1.0);
        push(DofKind::W, range.start + 1, 1.0);
        if range.len() == 4 {
            push(DofKind::B, range.start + 3, -1.0);
            push(DofKind::Gamma, range.start + 2, 1.0);
        }
    }
    if let Some(range) = &block.torsion {
        push(DofKind::Twist, range.start, 1.0);
    }
}

/// Appends the internal coordinates of the element after `node`, by the degree of their shape functions.
fn push_element(dofs: &mut Vec<Dof>, node: Node, shaft: &Shaft, block: &Block) {
    let (nodes, functions) = (shaft.nodes.len(), BendingFunction::all(shaft.degree, shaft.shear));
    let rods = rod_degrees(shaft.degree);
    for degree in 2..=shaft.degree + 1 {
        let mut push = |kind, index, sign| dofs.push(Dof { node, kind, degree: Some(degree), index, sign });
        let in_rod = |range: &Range<usize>| range.start + nodes + rods.clone().count() * node.node + degree - 2;
        let has_rod = rods.contains(&degree);
        if let Some(range) = block.axial.as_ref().filter(|_| has_rod) {
            push(DofKind::Axial, in_rod(range), 1.0);
        }
        if let Some(range) = &block.lateral {
            let first = range.start + 4 * nodes + 2 * functions.len() * node.node;
            for (i, function) in functions.iter().enumerate() {
                let v = first + 2 * i;
                match function {
                    BendingFunction::Displacement(n) | BendingFunction::Deflection(n) if *n == degree => {
                        push(DofKind::V, v, 1.0);
                        push(DofKind::W, v + 1, 1.0);
                    }
                    BendingFunction::Rotation(n) if *n == degree => {
                        push(DofKind::B, v + 1, -1.0);
                        push(DofKind::Gamma, v, 1.0);
                    }
                    _ => {}
                }
            }
        }
        if let Some(range) = block.torsion.as_ref().filter(|_| has_rod) {
            push(DofKind::Twist, in_rod(range), 1.0);
        }
    }
}
