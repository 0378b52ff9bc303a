//! The assembled scene: numbering, matrices of every shaft, meshes, and what excites them.
//!
//! ```text
//! M q̈ + (C + ΩG) q̇ + K q + Σ_mesh F ∂δ/∂q = Σ_s K_s q_b,s(t) + f_unbalance(t) + f_torque + f_gravity
//! ```
//!
//! A shaft couples neighbouring nodes alone, a bearing one node, a mesh six coordinates by one scalar force. Nothing
//! here is ever stored as a dense matrix except on demand (`dense`), for eigenvalues and factorisations.

mod at_speed;
mod bow;
mod dense;
mod flanks;
mod form;
mod numbering;
mod shaft;

use nalgebra::{DMatrix, DVector};

pub use flanks::Rotation;
pub use numbering::{Dof, DofKind, Numbering};
pub use shaft::{BendingChain, Chain, Excitation, ShaftModel, TwistChain};

use crate::connection::{SpeedDependentBearing, Spring};
use crate::linalg::NotPositiveDefinite;
use crate::mesh::stiffness::Stiffness;
use crate::mesh::{GearMesh, MeshCoordinates};
use crate::scene::{Matrix2, Node, Scene, SceneError};

/// A bearing on its coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Support {
    /// Index of v; w follows.
    pub index: usize,
    /// Stiffness over (v, w), N/m.
    pub stiffness: [[f64; 2]; 2],
    /// The symmetric stiffness that stands for it in undamped modes and in the energy norm: it resists what K resists,
    /// and pushes nothing away.
    pub symmetric_part: [[f64; 2]; 2],
    /// Damping over (v, w), N s/m.
    pub damping: [[f64; 2]; 2],
}

impl Support {
    /// A bearing of this stiffness and damping on the coordinates from `index` on.
    pub fn new(index: usize, stiffness: Matrix2, damping: Matrix2) -> Self {
        Self { index, stiffness, symmetric_part: symmetric_part(&stiffness), damping }
    }

    /// The directions that it resists, orthogonal and of unit length.
    pub fn directions(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let [[a, b], [_, d]] = self.symmetric_part;
        let (mean, half) = (a / 2.0 + d / 2.0, ((a - d) / 2.0).hypot(b));
        let (sine, cosine) = (b.atan2((a - d) / 2.0) / 2.0).sin_cos();
        let both = [(mean + half, [cosine, sine]), (mean - half, [-sine, cosine])];
        both.into_iter()
            .filter(move |(stiffness, _)| *stiffness > NOTHING * (mean + half))
            .map(|(_, direction)| direction)
    }

    /// qᵀKq of the symmetric part, J for displacements in m.
    #[inline]
    pub fn elastic_form(&self, q: &[f64]) -> f64 {
        form::form(&self.symmetric_part, [q[self.index], q[self.index + 1]])
    }

    /// What the stiffness has beside its restoring part.
    pub fn skew_part(&self) -> [[f64; 2]; 2] {
        std::array::from_fn(|i| std::array::from_fn(|j| self.stiffness[i][j] - self.symmetric_part[i][j]))
    }
}

/// Stiffness below this part of the largest is round-off.
const NOTHING: f64 = 1e-12;
/// A symmetric part below this share of the whole says nothing of what a bearing resists.
const WEAK: f64 = 1e-3;

/// The symmetric part of K where that is positive definite; else the factor (KᵀK)^½ of its polar decomposition, which
/// has the null space of K (Higham 2008, chapter 8).
fn symmetric_part(k: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let norm = k.as_flattened().iter().fold(0.0_f64, |norm, value| norm.hypot(*value));
    let cross = k[0][1] / 2.0 + k[1][0] / 2.0;
    let lowest = k[0][0] / 2.0 + k[1][1] / 2.0 - ((k[0][0] - k[1][1]) / 2.0).hypot(cross);
    let diagonal = k[0][1] == 0.0 && k[1][0] == 0.0;
    if diagonal || lowest > WEAK * norm {
        return [[k[0][0], cross], [cross, k[1][1]]];
    }
    // √S = (S + √det S)/√(tr S + 2√det S), with √det S = |det K|; of K over its norm, so that no square overflows.
    let k = k.map(|row| row.map(|value| value / norm));
    let square = |i: usize, j: usize| k[0][i] * k[0][j] + k[1][i] * k[1][j];
    let root = (k[0][0] * k[1][1] - k[0][1] * k[1][0]).abs();
    let trace = (square(0, 0) + square(1, 1) + 2.0 * root).sqrt();
    std::array::from_fn(|i| std::array::from_fn(|j| norm * (square(i, j) + if i == j { root } else { 0.0 }) / trace))
}

/// An assembled scene.
#[derive(Clone, Debug)]
pub struct Model {
    /// The scene it was made from.
    pub scene: Scene,
    /// Which coordinate stands where.
    pub numbering: Numbering,
    /// Every shaft with the bodies on it.
    pub shafts: Vec<ShaftModel>,
    /// Bearings with constant coefficients; empty in a scene without bending.
    pub supports: Vec<Support>,
    /// Bearings whose coefficients depend on the speed; empty in a scene without bending and in a model
    /// [`at_speed`](Self::at_speed).
    pub bearings: Vec<SpeedDependentBearing>,
    /// Meshes.
    pub meshes: Vec<GearMesh>,
    /// Springs between coordinates, which no scene describes: see [`Self::with_springs`].
    pub springs: Vec<Spring>,
    /// Torque and gravity: the constant load.
    pub constant_load: DVector<f64>,
    /// σ of every mesh at speed zero.
    sigma_standing: Vec<f64>,
}

impl Model {
    /// Assembles a scene.
    ///
    /// # Errors
    /// [`SceneError`] if a node has no inertia, or a bow asks for a sag that the bearings do not define.
    pub fn new(scene: Scene) -> Result<Self, SceneError> {
        let numbering = Numbering::new(&scene);
        let shafts = (0..scene.shafts.len())
            .map(|index| ShaftModel::new(&scene, &numbering, index))
            .collect::<Result<Vec<_>, _>>()?;
        let (supports, bearings) = at_speed::bearings(&scene, &numbering);
        let meshes: Vec<_> = scene
            .meshes
            .iter()
            .map(|mesh| {
                let nodes = [mesh.driver, mesh.driven].map(|gear| scene.gears[gear].body.node);
                let [a, b] = nodes.map(|node| numbering.translation(node));
                let translation = a.zip(b).map(|(a, b)| [a, b]);
                // A scene with a mesh has twist: `Scene::required_motion` has seen to that.
                let twist = nodes.map(|node| numbering.twist(node).unwrap_or_default());
                GearMesh::new(mesh, &scene.gears, MeshCoordinates { translation, twist })
            })
            .collect();
        check_stiffness(&meshes)?;
        let constant_load = DVector::zeros(numbering.len());
        let mut model = Self {
            constant_load,
            sigma_standing: Vec::new(),
            scene,
            numbering,
            shafts,
            supports,
            bearings,
            meshes,
            springs: Vec::new(),
        };
        model.constant_load = model.assemble_constant_load();
        model.sigma_standing = model.sigma_at_rest();
        Ok(model)
    }

    /// Number of degrees of freedom n.
    pub fn len(&self) -> usize {
        self.numbering.len()
    }

    /// Whether there is nothing to move.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The same model with springs between its coordinates.
    pub fn with_springs(mut self, springs: Vec<Spring>) -> Self {
        self.springs = springs;
        self
    }

    /// Force of the shaft on the bearings with constant coefficients of a node over (y, z), N.
    pub fn bearing_force(&self, node: Node, q: &[f64], v: &[f64]) -> [f64; 2] {
        let mut force = [0.0; 2];
        let index = self.numbering.translation(node);
        for support in self.supports.iter().filter(|support| Some(support.index) == index) {
            let (i, k, c) = (support.index, &support.stiffness, &support.damping);
            for (row, force) in force.iter_mut().enumerate() {
                *force += k[row][0] * q[i] + k[row][1] * q[i + 1] + c[row][0] * v[i] + c[row][1] * v[i + 1];
            }
        }
        force
    }

    /// Indices of v and w of all nodes.
    pub fn translations(&self) -> impl Iterator<Item = usize> + '_ {
        self.numbering.dofs().iter().filter(|dof| matches!(dof.kind, DofKind::V | DofKind::W)).map(|dof| dof.index)
    }

    /// Names of the driving and the driven gear of a mesh.
    pub fn gear_names(&self, mesh: usize) -> [&str; 2] {
        let pair = &self.scene.meshes[mesh];
        [pair.driver, pair.driven].map(|gear| self.scene.gears[gear].body.name.as_str())
    }

    /// The fastest speed of a shaft over that of the reference shaft.
    pub fn fastest_turn(&self) -> f64 {
        self.scene.speed_ratios.iter().map(|ratio| ratio.abs()).fold(0.0, f64::max)
    }

    /// The fastest tooth frequency over the speed of the reference shaft; zero without a mesh.
    pub fn fastest_teeth(&self) -> f64 {
        self.fastest_teeth_of(|_| true)
    }

    /// The same among the meshes that are `chosen`.
    pub fn fastest_teeth_of(&self, chosen: impl Fn(&GearMesh) -> bool) -> f64 {
        let meshes = self.scene.meshes.iter().zip(&self.meshes).filter(|(_, gear_mesh)| chosen(gear_mesh));
        let teeth = meshes.map(|(mesh, _)| {
            let gear = &self.scene.gears[mesh.driver];
            f64::from(gear.teeth) * self.scene.speed_ratios[gear.body.node.shaft].abs()
        });
        teeth.fold(0.0, f64::max)
    }

    fn assemble_constant_load(&self) -> DVector<f64> {
        let mut load = DVector::zeros(self.len());
        for torque in &self.scene.torques {
            if let Some(index) = self.numbering.twist(torque.node) {
                load[index] += torque.value;
            }
        }
        if self.scene.gravity != [0.0; 2] {
            let mut acceleration = DVector::zeros(self.len());
            for dof in self.numbering.dofs() {
                match dof.kind {
                    DofKind::V => acceleration[dof.index] = self.scene.gravity[0],
                    DofKind::W => acceleration[dof.index] = self.scene.gravity[1],
                    _ => {}
                }
            }
            self.multiply_mass(acceleration.as_slice(), load.as_mut_slice());
        }
        load
    }

    /// K q of shafts and bearings.
    pub fn static_force(&self, q: &DVector<f64>) -> DVector<f64> {
        let (q, mut force) = (q.as_slice(), DVector::zeros(self.len()));
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                chain.subtract_elastic::<2>(&q[chain.start..], &mut force.as_mut_slice()[chain.start..]);
            }
            if let Some(chain) = &shaft.twist {
                chain.subtract_elastic::<1>(&q[chain.start..], &mut force.as_mut_slice()[chain.start..]);
            }
        }
        for support in &self.supports {
            let (i, k) = (support.index, &support.stiffness);
            for row in 0..2 {
                force[i + row] -= k[row][0] * q[i] + k[row][1] * q[i + 1];
            }
        }
        -force
    }

    /// `out += M x`.
    pub fn multiply_mass(&self, x: &[f64], out: &mut [f64]) {
        for shaft in &self.shafts {
            shaft.multiply_mass(x, out);
        }
    }

    /// M times the columns of a matrix.
    pub fn mass_times(&self, vectors: &DMatrix<f64>) -> DMatrix<f64> {
        let mut weighted = DMatrix::zeros(self.len(), vectors.ncols());
        for (vector, mut weighted) in vectors.as_slice().chunks_exact(self.len().max(1)).zip(weighted.column_iter_mut())
        {
            self.multiply_mass(vector, weighted.as_mut_slice());
        }
        weighted
    }
}

/// No stiffness may be below zero: it would push the flanks together.
fn check_stiffness(meshes: &[GearMesh]) -> Result<(), SceneError> {
    for (index, mesh) in meshes.iter().enumerate() {
        if mesh.stiffness.is_nan() || mesh.stiffness <= 0.0 {
            let message = format!(
                "ISO 6336-1 gives {:.4e} N/m: teeth and profile shifts are outside its range; give a number",
                mesh.stiffness
            );
            return Err(SceneError::new(format!("meshes[{index}].stiffness"), message));
        }
        if let Stiffness::Cycle(cycle) = &mesh.teeth {
            let smallest = cycle.smallest();
            if smallest < 0.0 {
                let message = format!("must not fall below zero over the mesh cycle, falls to {smallest:.4e} N/m");
                return Err(SceneError::new(format!("meshes[{index}].stiffness"), message));
            }
        }
    }
    Ok(())
}

/// The scene error of a shaft whose mass matrix cannot be factored.
fn massless(scene: &Scene, shaft: usize, failure: NotPositiveDefinite) -> SceneError {
    let x = scene.shafts[shaft].nodes[failure.node];
    SceneError::new(format!("shafts[{shaft}]"), format!("the node at {x} m has no inertia, or one lost to round-off"))
}
