//! Assembled model of a scene: numbering of coordinates, matrices of shafts and bearings, meshes, and excitation.
//!
//! ```text
//! M q̈ + (C + ΩG) q̇ + K q + Σ_mesh F ∂δ/∂q = Σ_s K_s q_b,s(t) + f_unbalance(t) + f_torque + f_gravity
//! ```
//!
//! A shaft couples neighbouring nodes, a bearing acts on one node, and a mesh acts on the coordinates of its two gears
//! with one scalar force F.
//!
//! - Shafts: `shaft` has up to three chains of nodes (bending, torsion, axial motion), and bow and unbalance as forces
//!   that rotate with the shaft; `bow` has the nodal values of the bow, `turning_bow` the scalars through which it turns with
//!   the twist.
//! - Other parts: `housing` (inertia), `link` (springs and dampers), `loads` (torques, forces, weight), `flanks` (which
//!   flank of a mesh is pressed), `at_speed` (coefficients of bearings at a speed), `turning_frame` (planets that turn with their
//!   carrier).
//! - `numbering` is the only file that knows the order of the coordinates.
//! - Matrices on demand: `matrices` (dense and sparse), `dynamic_stiffness` (bands of the shafts at a frequency, in the
//!   coordinates of `circular`), `quadratic_forms` (energies); `dissipative` decides whether a model can be unstable.

mod at_speed;
mod bow;
mod circular;
mod cut;
mod dissipative;
mod dynamic_stiffness;
mod flanks;
mod free_rotation;
mod housing;
mod link;
mod loads;
mod matrices;
mod numbering;
mod place;
mod quadratic_forms;
mod shaft;
mod turning_bow;
mod turning_frame;

use std::sync::{Arc, OnceLock};

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

pub use cut::{Combination, Cut, Moving, Oscillating, SECTION_FORCES, Turning};
pub use dynamic_stiffness::{SAME_ROTATION, StructuralDamping, Weights};
pub use flanks::Rotation;
pub use housing::{HousingInertia, point_rows};
pub use link::{Link, Rest, bearing_rows, coefficient};
pub use matrices::Add;
pub use numbering::{Dof, DofKind, Numbering};
pub use place::PlaceRows;
pub use shaft::{BendingChain, Chain, Excitation, RodChain, ShaftModel};
pub use turning_bow::{bow_force, is_bowed};
pub use turning_frame::Planet;

use crate::connection::{AppliedLoad, Connection, NonlinearBearing, Row, SpeedDependentBearing, TurningBow};
use crate::linalg::{NotPositiveDefinite, Structure};
use crate::mesh::stiffness::Stiffness;
use crate::mesh::{GearMesh, MeshCoordinates};
use crate::numerics::ROUND_OFF;
use crate::scene::{Gear, Matrix2, Node, Scene, SceneError};

/// A bearing with its coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Support {
    /// Index, in the order of the core, of v at its node; w has the next index.
    pub index: usize,
    /// Stiffness matrix over (v, w), N/m.
    pub stiffness: [[f64; 2]; 2],
    /// Symmetric, positive semidefinite matrix over (v, w) that represents the stiffness in undamped modes and in the
    /// energy norm, N/m. It has the null space of the stiffness.
    pub symmetric_part: [[f64; 2]; 2],
    /// Damping matrix over (v, w), N s/m.
    pub damping: [[f64; 2]; 2],
    /// Loss factor η of the stiffness, which analyses in the frequency domain contain.
    pub loss_factor: f64,
    /// Whether it has the coefficients of a nonlinear bearing at its operating point.
    pub is_operating_point: bool,
    /// Speed of the frame of its coordinates relative to its damper, over that of the reference shaft.
    pub frame: f64,
}

impl Support {
    /// A bearing with constant coefficients at the coordinates `index` (v) and `index` + 1 (w).
    pub fn new(index: usize, stiffness: Matrix2, damping: Matrix2) -> Self {
        let symmetric_part = symmetric_part(&stiffness);
        Self { index, stiffness, symmetric_part, damping, loss_factor: 0.0, is_operating_point: false, frame: 0.0 }
    }

    /// The same element in a frame that turns relative to its damper.
    pub fn in_frame(self, frame: f64) -> Self {
        Self { frame, ..self }
    }

    /// The same element with a loss factor η of its stiffness.
    pub fn with_loss_factor(self, loss_factor: f64) -> Self {
        Self { loss_factor, ..self }
    }

    /// Orthogonal unit vectors over (v, w) in which the bearing has stiffness.
    pub fn directions(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let [[a, b], [_, d]] = self.symmetric_part;
        let (mean, half) = (a / 2.0 + d / 2.0, ((a - d) / 2.0).hypot(b));
        let (sine, cosine) = (b.atan2((a - d) / 2.0) / 2.0).sin_cos();
        let principal = [(mean + half, [cosine, sine]), (mean - half, [-sine, cosine])];
        principal
            .into_iter()
            .filter(move |(stiffness, _)| *stiffness > ROUND_OFF * (mean + half))
            .map(|(_, direction)| direction)
    }

    /// Force of the shaft on the bearing over (y, z), K u + C u̇, N.
    #[inline(always)]
    pub fn force(&self, q: &[f64], v: &[f64]) -> [f64; 2] {
        let (i, c, elastic) = (self.index, &self.damping, self.elastic_force(q));
        [0, 1].map(|row| elastic[row] + c[row][0] * v[i] + c[row][1] * v[i + 1])
    }

    /// Elastic part K u of the force, N.
    #[inline(always)]
    pub fn elastic_force(&self, q: &[f64]) -> [f64; 2] {
        let (i, k) = (self.index, &self.stiffness);
        [0, 1].map(|row| k[row][0] * q[i] + k[row][1] * q[i + 1])
    }

    /// qᵀKq of the symmetric part, J for displacements in m.
    #[inline]
    pub fn elastic_form(&self, q: &[f64]) -> f64 {
        quadratic_forms::form(&self.symmetric_part, [q[self.index], q[self.index + 1]])
    }

    /// Stiffness minus its symmetric part, over (v, w), N/m.
    pub fn skew_part(&self) -> [[f64; 2]; 2] {
        std::array::from_fn(|i| std::array::from_fn(|j| self.stiffness[i][j] - self.symmetric_part[i][j]))
    }
}

/// Natural frequency, rad/s, below which a motion without stiffness and one that buckles are not told apart.
const SLOWEST_STABLE: f64 = 1e-2;

/// (K + Kᵀ)/2 counts as positive definite if its lower eigenvalue exceeds this fraction of ‖K‖.
const MIN_DEFINITE_FRACTION: f64 = 1e-3;

/// (K + Kᵀ)/2 if it is positive definite or K is diagonal; otherwise the factor (KᵀK)^½ of the polar decomposition of
/// K, which has the null space of K (Higham 2008, Functions of Matrices, chapter 8).
fn symmetric_part(k: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let norm = k.as_flattened().iter().fold(0.0_f64, |norm, value| norm.hypot(*value));
    let cross = k[0][1] / 2.0 + k[1][0] / 2.0;
    let lowest = k[0][0] / 2.0 + k[1][1] / 2.0 - ((k[0][0] - k[1][1]) / 2.0).hypot(cross);
    let diagonal = k[0][1] == 0.0 && k[1][0] == 0.0;
    if diagonal || lowest > MIN_DEFINITE_FRACTION * norm {
        return [[k[0][0], cross], [cross, k[1][1]]];
    }
    // √S = (S + √(det S) I)/√(tr S + 2√(det S)) with S = KᵀK and √(det S) = |det K|. K is divided by its norm, so that
    // no square overflows.
    let k = k.map(|row| row.map(|value| value / norm));
    let square = |i: usize, j: usize| k[0][i] * k[0][j] + k[1][i] * k[1][j];
    let root = (k[0][0] * k[1][1] - k[0][1] * k[1][0]).abs();
    let trace = (square(0, 0) + square(1, 1) + 2.0 * root).sqrt();
    std::array::from_fn(|i| std::array::from_fn(|j| norm * (square(i, j) + if i == j { root } else { 0.0 }) / trace))
}

/// Assembled model of a scene.
#[derive(Clone, Debug)]
pub struct Model {
    /// The scene.
    pub scene: Scene,
    /// Numbering of the coordinates.
    pub numbering: Numbering,
    /// Shafts with the bodies on them.
    pub shafts: Vec<ShaftModel>,
    /// Bearings with constant coefficients; empty for a scene without bending.
    pub supports: Vec<Support>,
    /// All other linear elements with constant coefficients: bearings on housings, mounts of housings, couplings, drives.
    pub links: Vec<Link>,
    /// Inertia of supports and housings.
    pub housings: HousingInertia,
    /// Bearings whose coefficients depend on the speed; empty in a scene without bending and in a model
    /// [with the tables at a speed](Self::with_tables_at).
    pub bearings: Vec<SpeedDependentBearing>,
    /// Bearings with oil films or rolling elements. In a model at a speed, `supports` and `links` contain their coefficients at
    /// the operating point.
    pub nonlinear_bearings: Vec<NonlinearBearing>,
    /// Gear meshes.
    pub meshes: Vec<GearMesh>,
    /// Forces and torques that depend on time, angle or speed.
    pub loads: Vec<AppliedLoad>,
    /// Bows that turn with the twist of their shafts.
    pub bows: Vec<TurningBow>,
    /// Constant load of torques, forces, gravity and misaligned couplings, n entries, N or N m.
    pub constant_load: DVector<f64>,
    /// Planets on pins of carriers that turn.
    pub planets: Vec<Planet>,
    /// Speed of the reference shaft, rad/s, whose circulatory forces of internal damping, and forces of frames that turn, belong to
    /// the stiffness.
    pub circulation: Option<f64>,
    /// σ of every mesh at speed zero.
    sigma_standing: Vec<f64>,
    /// Chains of all shafts, and the coordinates of supports and housings, ascending.
    parts: Vec<circular::Part>,
    /// Structure of the dynamic stiffness, which models of the same scene at all speeds, and those of a critical speed map, share.
    structure: Arc<OnceLock<Arc<Structure>>>,
}

impl Model {
    /// Assembles a scene.
    ///
    /// # Errors
    /// [`SceneError`] if a node has no inertia, the bearings do not define the sag of a bow, or a mesh stiffness is not
    /// positive.
    pub fn new(scene: Scene) -> Result<Self, SceneError> {
        let numbering = Numbering::new(&scene);
        scene.modal_damping.check_numbers(numbering.len())?;
        let shafts = (0..scene.shafts.len())
            .map(|index| ShaftModel::new(&scene, &numbering, index))
            .collect::<Result<Vec<_>, _>>()?;
        let nonlinear_bearings = at_speed::nonlinear_bearings(&scene, &numbering);
        let (supports, bearings) = at_speed::bearings(&scene, &numbering, nonlinear_bearings.len());
        let meshes: Vec<_> = scene
            .meshes
            .iter()
            .map(|mesh| {
                let nodes = [mesh.driver, mesh.driven].map(|gear| scene.gears[gear].body.node);
                let [a, b] = nodes.map(|node| numbering.translation(node));
                // With rigid pins, a stage whose carrier turns couples its shafts in torsion only.
                let moves = scene.acts_laterally(mesh);
                let translation = a.zip(b).filter(|_| moves).map(|(a, b)| [a, b]);
                // A scene with a mesh always includes torsion: `Scene::required_motion` ensures this.
                let twist = nodes.map(|node| numbering.twist(node).unwrap_or_default());
                let [a, b] = nodes.map(|node| numbering.displacement_along(node));
                let axial = a.zip(b).filter(|_| moves).map(|(a, b)| [a, b]);
                let carrier = mesh.carrier.and_then(|node| numbering.twist(node));
                GearMesh::new(mesh, &scene.gears, MeshCoordinates { translation, axial, twist, carrier })
            })
            .collect();
        check_stiffness(&meshes)?;
        let mut model = Self {
            constant_load: DVector::default(),
            links: link::links(&scene, &numbering),
            housings: HousingInertia::new(&scene, &numbering),
            sigma_standing: Vec::new(),
            scene,
            numbering,
            shafts,
            supports,
            bearings,
            nonlinear_bearings,
            meshes,
            loads: Vec::new(),
            planets: Vec::new(),
            circulation: None,
            bows: Vec::new(),
            parts: Vec::new(),
            structure: Arc::default(),
        };
        model.parts = model.find_parts();
        model.planets = model.find_planets();
        model.set_initial_stiffness();
        model.add_loads();
        model.check_buckling()?;
        Ok(model)
    }

    /// Refuses axial forces under which the shafts have no stable equilibrium.
    fn check_buckling(&self) -> Result<(), SceneError> {
        let compressed = |shaft: &crate::scene::Shaft| shaft.elements.iter().any(|element| element.axial_force < 0.0);
        let Some(index) = self.scene.shafts.iter().position(compressed) else { return Ok(()) };
        // Rigid-body motions count as stable.
        let mass = Complex64::from(SLOWEST_STABLE * SLOWEST_STABLE);
        let weights = Weights { mass, symmetric: true, ..Weights::stiffness() };
        if self.dynamic_stiffness(&weights, 0.0).negative_eigenvalues() == Some(0) {
            return Ok(());
        }
        let name = &self.scene.shafts[index].name;
        let force = self.scene.shafts[index].elements.iter().map(|element| element.axial_force).fold(0.0, f64::min);
        Err(SceneError::new(
            format!("shafts[{index}].axial_force"),
            format!("the shaft \"{name}\" buckles under the compression of {} N; use a smaller force", -force),
        ))
    }

    /// Number of degrees of freedom n.
    pub fn len(&self) -> usize {
        self.numbering.len()
    }

    /// Whether the model has no degrees of freedom.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether another model has the same nodes, the same kinds of coordinates and the same loaded flanks at rest, which also
    /// depend on the loads of a scene.
    pub fn has_coordinates_of(&self, other: &Self) -> bool {
        loads::has_same_coordinates(&self.scene, &other.scene) && self.sigma_standing == other.sigma_standing
    }

    /// Force of the shaft on the bearings with constant coefficients at a node along (y, z) and the axis, N, for displacements q
    /// and velocities v.
    pub fn bearing_force(&self, node: Node, q: &[f64], v: &[f64]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        let index = self.numbering.translation(node);
        for support in self.supports.iter().filter(|support| Some(support.index) == index) {
            let [y, z] = support.force(q, v);
            sum = [sum[0] + y, sum[1] + z, sum[2]];
            if support.frame != 0.0 {
                let [y, z] = self.frame_force(support, [q[support.index], q[support.index + 1]]);
                sum = [sum[0] + y, sum[1] + z, sum[2]];
            }
        }
        let axes = [index, index.map(|v| v + 1), self.numbering.displacement_along(node)];
        for link in self.links.iter().filter(|link| link.bearing == Some(node)) {
            let mut forces = link.force(q, v);
            if link.local.frame != 0.0 {
                let in_frame = self.frame_force(&link.local, link.scalars(q));
                forces = [forces[0] + in_frame[0], forces[1] + in_frame[1]];
            }
            if let Some(Rest { fixed, .. }) = link.rest {
                let at_rest = link.local.elastic_force(&[fixed.re, fixed.im]);
                forces = [forces[0] - at_rest[0], forces[1] - at_rest[1]];
            }
            for (row, force) in link.rows.iter().zip(forces) {
                for (sum, axis) in sum.iter_mut().zip(axes) {
                    *sum += coefficient(row, axis) * force;
                }
            }
        }
        sum
    }

    /// Indices, in the order of the core, of v and w of all nodes.
    pub fn translations(&self) -> impl Iterator<Item = usize> + '_ {
        self.numbering
            .nodal_dofs()
            .iter()
            .filter(|dof| matches!(dof.kind, DofKind::V | DofKind::W))
            .map(|dof| dof.index)
    }

    /// Names of the driving and the driven gear of a mesh.
    pub fn gear_names(&self, mesh: usize) -> [&str; 2] {
        let pair = &self.scene.meshes[mesh];
        [pair.driver, pair.driven].map(|gear| self.scene.gears[gear].body.name.as_str())
    }

    /// Largest ratio |Ω_s/Ω| of the speed of a shaft to that of the reference shaft.
    pub fn max_speed_ratio(&self) -> f64 {
        self.scene.speed_ratios.iter().map(|ratio| ratio.abs()).fold(0.0, f64::max)
    }

    /// Largest mesh order: tooth meshing frequency, rad/s, divided by the speed of the reference shaft; zero without
    /// meshes.
    pub fn max_mesh_order(&self) -> f64 {
        self.max_mesh_order_of(|_| true)
    }

    /// Largest mesh order of the meshes that satisfy `condition`.
    pub fn max_mesh_order_of(&self, condition: impl Fn(&GearMesh) -> bool) -> f64 {
        let meshes = self.scene.meshes.iter().zip(&self.meshes).filter(|(_, gear_mesh)| condition(gear_mesh));
        meshes.map(|(mesh, _)| self.scene.mesh_order(mesh)).fold(0.0, f64::max)
    }

    /// K q of shafts, bearings and links, n entries, N or N m.
    pub fn static_force(&self, q: &DVector<f64>) -> DVector<f64> {
        let (q, mut force) = (q.as_slice(), DVector::zeros(self.len()));
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                chain.subtract_elastic::<2>(&q[chain.start..], &mut force.as_mut_slice()[chain.start..]);
            }
            for chain in shaft.rods() {
                chain.subtract_elastic::<1>(&q[chain.start..], &mut force.as_mut_slice()[chain.start..]);
            }
        }
        for support in &self.supports {
            for (row, value) in support.elastic_force(q).into_iter().enumerate() {
                force[support.index + row] -= value;
            }
        }
        for link in &self.links {
            link.subtract(link.local.elastic_force(&link.scalars(q)), force.as_mut_slice());
        }
        self.visit_circulation(&mut |row, column, value| force[row] -= value * q[column]);
        -force
    }

    /// `out += M x`.
    pub fn multiply_mass(&self, x: &[f64], out: &mut [f64]) {
        for shaft in &self.shafts {
            shaft.multiply_mass(x, out);
        }
        self.housings.multiply_mass(x, out);
    }

    /// `x ← M⁻¹ x`.
    pub fn solve_mass(&self, x: &mut [f64]) {
        for shaft in &self.shafts {
            shaft.solve_mass(x);
        }
        self.housings.solve_mass(x);
    }

    /// Loads along which bearings, links and local connections act, each once and in a fixed order: on single coordinates, and on
    /// the modes of an elastic housing at each of its interfaces; `speed` of the reference shaft, rad/s, `further` coordinates
    /// with loads of their own.
    pub fn coupled_loads(&self, speed: f64, further: impl IntoIterator<Item = usize>) -> Vec<Row> {
        let mut single: Vec<usize> = further.into_iter().collect();
        single.extend(self.supports.iter().flat_map(|support| [support.index, support.index + 1]));
        let mut combined: Vec<Row> = Vec::new();
        let mut add = |rows: &[Row]| {
            for row in rows {
                for part in self.housings.parts(row) {
                    match part {
                        // The springs of the modes of an elastic housing are no interfaces.
                        [(index, _)] => single.extend((!self.housings.is_mode(*index)).then_some(*index)),
                        _ if combined.iter().any(|known| known == part) => {}
                        _ => combined.push(part.to_vec()),
                    }
                }
            }
        };
        let local = self.connections(speed).filter(Connection::is_local);
        local.for_each(|connection| add(&connection.rows()));
        self.links.iter().for_each(|link| add(&link.rows));
        single.retain(|index| *index < self.len());
        single.sort_unstable();
        single.dedup();
        single.into_iter().map(|index| vec![(index, 1.0)]).chain(combined).collect()
    }

    /// Highest angular frequency of two free gears on their mesh stiffness, rad/s.
    pub fn highest_mesh_frequency(&self) -> f64 {
        let square = |(mesh, gear_mesh): (usize, &GearMesh)| gear_mesh.largest_stiffness * self.mobility(mesh);
        self.meshes.iter().enumerate().map(square).fold(0.0, f64::max).sqrt()
    }

    /// Relative acceleration of the teeth of two free gears along the line of action per unit of mesh force, 1/kg.
    pub fn mobility(&self, mesh: usize) -> f64 {
        let bending = if self.meshes[mesh].coordinates.translation.is_some() { 1.0 } else { 0.0 };
        let helix = self.meshes[mesh].helix.as_ref().map_or(0.0, |helix| helix.slope);
        let mobility = |gear: usize| {
            let Gear { base_radius, pitch_radius, body, .. } = &self.scene.gears[gear];
            let along = || helix.powi(2) * (1.0 / body.mass + pitch_radius.powi(2) / body.diametral_inertia);
            let transverse = base_radius.powi(2) / body.polar_inertia + bending / body.mass;
            if helix == 0.0 { transverse } else { transverse + along() }
        };
        mobility(self.scene.meshes[mesh].driver) + mobility(self.scene.meshes[mesh].driven)
    }

    /// M X for a matrix X with n rows.
    pub fn mass_times(&self, vectors: &DMatrix<f64>) -> DMatrix<f64> {
        let mut weighted = DMatrix::zeros(self.len(), vectors.ncols());
        for (vector, mut weighted) in vectors.as_slice().chunks_exact(self.len().max(1)).zip(weighted.column_iter_mut())
        {
            self.multiply_mass(vector, weighted.as_mut_slice());
        }
        weighted
    }
}

/// Checks that every mesh stiffness is positive; a negative one would pull the flanks together.
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

/// Error for a shaft whose mass matrix is not positive definite.
fn mass_error(scene: &Scene, shaft: usize, failure: NotPositiveDefinite) -> SceneError {
    let x = scene.shafts[shaft].nodes[failure.node];
    SceneError::new(
        format!("shafts[{shaft}]"),
        format!(
            "the inertia of the node at {x} m is zero or lost to round-off; check the density and the distances of nodes"
        ),
    )
}
