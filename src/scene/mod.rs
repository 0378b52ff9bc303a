//! The checked description of a rotor system: `description` → [`Scene::new`] → [`Scene`].
//!
//! [`Scene::new`] checks every value, replaces names by indices, fills in defaults, and places a node at every position
//! of a gear, disk, bearing or torque. It computes the speed ratios of the shafts from the meshes, and the torque that
//! balances the others. An error has the path of its entry and a message.
//!
//! - What the user describes: [`description`], one serde type for TOML files and Python dictionaries.
//! - Parts: `shaft`, `bow`, `gear`, `mesh`, `teeth`, `stiffness`, `bearing`, `journal`,
//!   `rolling` (`catalogue` estimates its elements), `housing`, `loads`.
//! - The train: `train` (speed ratios, balance of the torques), `centre_distance` (gears with profile shift), `contact`
//!   (path of contact at rest), `place` (names and positions), `rigid` (the largest stiffness of springs), `frame`
//!   (frames that turn with the carrier of planets).
//! - Values: `curve` and `speed_table` (tables), `modal_damping` (ratios of modes), `hertz` (stiffness of rolling elements), `accuracy` (the promised errors
//!   and the settings that keep them).
//! - Messages: `error`, `number`; `plausibility` warns of values that no real machine has.

mod accuracy;
mod bearing;
mod bow;
mod catalogue;
mod centre_distance;
mod contact;
mod curve;
pub mod description;
mod error;
mod frame;
mod friction;
mod gear;
mod hertz;
mod housing;
mod journal;
mod loads;
mod mesh;
mod modal_damping;
mod number;
mod place;
mod plausibility;
mod rigid;
mod rolling;
mod shaft;
mod speed_table;
mod stiffness;
mod teeth;
mod train;

use num_complex::Complex64;

pub use accuracy::{Accuracy, AccuracyLevel, COMPARED_DURATION, REDUCTION_SHARE, SHARE_OF_MEAN};
pub use bearing::{Bearing, Nonlinear, bearing};
pub use bow::{Bow, BowCurve};
#[cfg(feature = "python")]
pub(crate) use catalogue::estimate;
pub(crate) use contact::PairGeometry;
pub use curve::Curve;
pub use description::{Foundation, MotionKind, Phase, Rupture, STEEL, STEEL_POISSON_RATIO, SceneDescription};
pub use error::SceneError;
pub use friction::{Friction, FrictionLaw};
pub use gear::Gear;
pub use hertz::{LINE_CONTACT, POINT_CONTACT};
pub use housing::{Attachment, Housing, HousingPoint};
pub use journal::{FilmKind, Journal, Pad, Squeeze};
pub use loads::{Coupling, Drive, Force, LoadLaw, SpringDamper, VaryingLoad};
pub use mesh::{Damping, Mesh};
pub use modal_damping::DampingRatios;
pub use number::{outside_frequencies, outside_table, range_with_rpm, short, with_rpm};
pub use rigid::RIGID;
pub use rolling::Rolling;
pub use shaft::{Element, MAX_DEGREE, Material, Shaft, Tube};
pub use speed_table::{BearingCoefficient, Matrix2, excluding};
pub use stiffness::{Scale, StiffnessModel};
pub use teeth::{Engagement, Relief, Teeth, TransmissionError};

pub(crate) use error::{EntryPath, given, nearest};
use place::Names;
pub(crate) use plausibility::{eccentricity, implausible_unbalance};

/// Standard gravity, m/s².
pub const STANDARD_GRAVITY: f64 = 9.806_65;
/// Largest number of elements of a scene, counted by their degree. Analyses of a few modes and at given frequencies need memory in
/// proportion to it, about 0.5 GB at this number; more elements are a mistake of the scene.
pub const MAX_ELEMENTS: usize = 50_000;
/// Sum of the unit vectors from a gear to the planets around it below which the planets stand at equal angles: angles of files
/// have eleven digits.
const UNBALANCED_PLANETS: f64 = 1e-6;

/// A node of a shaft, or the centre of mass of a housing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Node {
    /// Index of the shaft. A housing counts as a shaft with one node; its index follows those of the shafts.
    pub shaft: usize,
    /// Index of the node on the shaft; node 0 is at x = 0.
    pub node: usize,
}

/// A rigid body on a shaft: a disk or a gear.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// Name.
    pub name: String,
    /// Node of the body.
    pub node: Node,
    /// Mass, kg.
    pub mass: f64,
    /// Moment of inertia about a diameter, kg m².
    pub diametral_inertia: f64,
    /// Moment of inertia about the axis, kg m².
    pub polar_inertia: f64,
    /// Unbalance (mass times eccentricity), kg m, with its angle in the rotating shaft.
    pub unbalance: Complex64,
}

/// A constant torque about +x.
#[derive(Clone, Debug)]
pub struct Torque {
    /// Node on which it acts.
    pub node: Node,
    /// Torque, N m.
    pub value: f64,
}

/// A checked scene.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Shafts with their nodes and elements, in the order of the description.
    pub shafts: Vec<Shaft>,
    /// Left end (x, y, z) of each shaft at rest, m; the first shaft begins at the origin.
    pub origins: Vec<[f64; 3]>,
    /// Gears, in the order of the description.
    pub gears: Vec<Gear>,
    /// Disks, in the order of the description.
    pub disks: Vec<Body>,
    /// Meshes, in the order of the description.
    pub meshes: Vec<Mesh>,
    /// Bearings, in the order of the description.
    pub bearings: Vec<Bearing>,
    /// Supports and housings, on which bearings stand.
    pub housings: Vec<Housing>,
    /// Couplings.
    pub couplings: Vec<Coupling>,
    /// Drives.
    pub drives: Vec<Drive>,
    /// Forces that are constant or turn with their shaft.
    pub forces: Vec<Force>,
    /// Forces and torques that depend on time, angle or speed.
    pub varying_loads: Vec<VaryingLoad>,
    /// Torques, in the order of the description, with the value of the balancing torque.
    pub torques: Vec<Torque>,
    /// Signed speed of each shaft relative to the reference shaft.
    pub speed_ratios: Vec<f64>,
    /// Damping ratios of the undamped modes; zero by default.
    pub modal_damping: DampingRatios,
    /// Rayleigh damping `[α, β]` of the shafts, 1/s and s.
    pub rayleigh: [f64; 2],
    /// Gravity along y and z, m/s².
    pub gravity: [f64; 2],
    /// For each shaft, that of the carrier with which the frame of its lateral motion turns; none for the frame at rest.
    pub frames: Vec<Option<usize>>,
    /// Whether nodes have the lateral coordinates v, w, B, Γ.
    pub lateral: bool,
    /// Whether nodes have the twist θ.
    pub torsion: bool,
    /// Whether nodes have the axial displacement u.
    pub axial: bool,
    /// Whether bows turn with the twist of their shafts.
    pub bow_torque: bool,
    /// Warnings of implausible values.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Checks a description.
    ///
    /// # Errors
    /// [`SceneError`] at the first invalid entry.
    pub fn new(system: &SceneDescription) -> Result<Self, SceneError> {
        if system.shafts.is_empty() {
            return Err(SceneError::new("shafts", "at least one shaft is needed"));
        }
        let names = Names::new(system)?;
        let stations = names.stations(system)?;
        let shafts = shaft::build(system, &stations)?;
        shaft::check_notches(system, &names, &shafts)?;
        let mut warnings = Vec::new();
        let mut gears = gear::gears(system, &names, &shafts)?;
        let meshes = mesh::meshes(system, &names, &shafts, &mut gears, &mut warnings)?;
        let couplings = loads::couplings(system, &names, &shafts)?;
        let train = train::Train { gears: &gears, meshes: &meshes, couplings: &couplings };
        let speed_ratios = train::speed_ratios(system, &names, train)?;
        let torques = train::torques(system, &names, &shafts, train)?;
        let mut housings = housing::housings(system)?;
        let housing::Places { origins, attachments } = housing::places(system, &names, &shafts, train, &mut housings)?;
        let mut scene = Self {
            disks: disks(system, &names, &shafts)?,
            bearings: bearing::bearings(system, &names, &shafts, &attachments)?,
            housings,
            drives: loads::drives(system, &names, &shafts)?,
            forces: loads::forces(system, &names, &shafts)?,
            varying_loads: loads::varying(system, &names, &shafts)?,
            couplings,
            modal_damping: DampingRatios::new(system.modal_damping.as_ref())?,
            rayleigh: rayleigh(system)?,
            bow_torque: system.bow_torque,
            gravity: gravity(system)?,
            shafts,
            origins,
            gears,
            meshes,
            torques,
            frames: vec![None; system.shafts.len()],
            speed_ratios,
            lateral: true,
            torsion: true,
            axial: false,
            warnings,
        };
        scene.add_tilting_pads();
        (scene.lateral, scene.torsion) = scene.required_motion(system.motion)?;
        scene.check_planet_angles()?;
        scene.set_frames()?;
        scene.axial = scene.has_axial_motion(system.motion);
        let implausible = plausibility::check(system, &scene)?;
        scene.warnings.extend(implausible);
        scene.limit_stiffness();
        Ok(scene)
    }

    /// Adds the tilting pads whose motions are coordinates to the housings.
    fn add_tilting_pads(&mut self) {
        for (index, bearing) in self.bearings.iter_mut().enumerate() {
            let Some(Nonlinear::Journal(journal)) = &bearing.nonlinear else { continue };
            if !journal.is_reduced()
                && let Some(pads) = housing::pads(format!("bearings[{index}].pads"), journal)
            {
                bearing.pads = Some(self.housings.len());
                self.housings.push(pads);
            }
        }
    }

    /// Refuses reduced coefficients of tilting pads, which have no meaning for a motion in time.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the first bearing that has them.
    pub fn refuse_reduced_pads(&self) -> Result<(), SceneError> {
        let is_reduced =
            |bearing: &Bearing| matches!(&bearing.nonlinear, Some(Nonlinear::Journal(journal)) if journal.is_reduced());
        match self.bearings.iter().position(is_reduced) {
            Some(index) => Err(EntryPath::entry("bearings", index).field("reduced").error(
                "coefficients for one frequency are for linear analyses; leave it out for runs, in which the tilts of the pads are coordinates",
            )),
            None => Ok(()),
        }
    }

    /// Refuses loss factors, which have no meaning for a motion in time.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the first loss factor.
    pub fn refuse_loss_factors(&self) -> Result<(), SceneError> {
        let shafts = self.shafts.iter().map(|shaft| shaft.loss_factor).enumerate();
        let shafts = shafts.map(|(index, factor)| (format!("shafts[{index}]"), factor));
        let bearings = self.bearings.iter().map(|bearing| bearing.loss_factor).enumerate();
        let bearings = bearings.map(|(index, factor)| (format!("bearings[{index}]"), factor));
        let housings = self.housings.iter().map(|housing| (housing.name.clone(), housing.loss_factor));
        let meshes = self.meshes.iter().map(|mesh| mesh.loss_factor).enumerate();
        let meshes = meshes.map(|(index, factor)| (format!("meshes[{index}]"), factor));
        match shafts.chain(bearings).chain(housings).chain(meshes).find(|(_, factor)| *factor != 0.0) {
            Some((name, factor)) => Err(SceneError::new(
                format!("{name}.loss_factor"),
                format!(
                    "has a meaning in the frequency domain only, and a run integrates over time; give a damping instead of {factor}"
                ),
            )),
            None => Ok(()),
        }
    }

    /// Refuses planets on rigid pins at unequal angles on a carrier that turns in a scene with bending. There a stage couples its shafts in torsion
    /// only, because equal forces of planets at equal angles cancel on sun, ring and carrier.
    fn check_planet_angles(&self) -> Result<(), SceneError> {
        let twists = |mesh: &Mesh| mesh.carrier.is_some() && !self.acts_laterally(mesh);
        for (index, first) in self.meshes.iter().enumerate().filter(|(_, mesh)| self.lateral && twists(mesh)) {
            let shaft = |mesh: &Mesh| mesh.carrier.map(|node| node.shaft);
            let of_stage = || self.meshes.iter().filter(|mesh| shaft(mesh) == shaft(first));
            let entry = EntryPath::entry("meshes", index);
            let at = entry.field("carrier");
            if self.gears[first.driver].helix_angle != 0.0 {
                return Err(at.error(
                    "turns, and the gears are helical: gearbow computes the axial motion of helical planets with a carrier at rest only; give motion=\"torsion\", or spur gears",
                ));
            }
            // The forces of a sun or a ring cancel; those of a planet act on its pin.
            let is_balanced = |gear: usize| {
                let outwards = of_stage().filter_map(|mesh| {
                    let sign = f64::from(i8::from(mesh.driver == gear) - i8::from(mesh.driven == gear));
                    (sign != 0.0).then(|| Complex64::cis(mesh.centre_line_angle) * sign)
                });
                outwards.sum::<Complex64>().norm() < UNBALANCED_PLANETS
            };
            if ![first.driver, first.driven].into_iter().any(is_balanced) {
                return Err(at.error(
                    "turns, and its planets do not stand at equal angles, so that their forces bend the shafts in directions that turn with the carrier; gearbow computes such planets in torsion only: give motion=\"torsion\", or at least two planets at equal angles",
                ));
            }
        }
        Ok(())
    }

    /// Whether a shaft only twists: one in a planetary stage whose carrier turns, and which no bearing and no coupling holds
    /// laterally, as that of a planet on a rigid pin.
    pub fn only_twists(&self, shaft: usize) -> bool {
        let has_gear = |mesh: &Mesh| {
            let of_gears = [mesh.driver, mesh.driven].map(|gear| self.gears[gear].body.node.shaft);
            mesh.carrier.is_some() && of_gears.contains(&shaft)
        };
        let held = self.bearings.iter().flat_map(Bearing::nodes).any(|node| node.shaft == shaft)
            || self.couplings.iter().flat_map(|coupling| coupling.hubs).any(|hub| hub.shaft == shaft);
        !held && self.meshes.iter().any(has_gear)
    }

    /// Speeds of driver and driven gear of a mesh relative to its carrier, over that of the reference shaft.
    pub fn mesh_speed_ratios(&self, mesh: &Mesh) -> [f64; 2] {
        let carrier = mesh.carrier.map_or(0.0, |node| self.speed_ratios[node.shaft]);
        [mesh.driver, mesh.driven].map(|gear| self.speed_ratios[self.gears[gear].body.node.shaft] - carrier)
    }

    /// Mesh order: tooth meshing frequency, rad/s, divided by the speed of the reference shaft.
    pub fn mesh_order(&self, mesh: &Mesh) -> f64 {
        f64::from(self.gears[mesh.driver].teeth) * self.mesh_speed_ratios(mesh)[0].abs()
    }

    /// All rigid bodies: gears, then disks.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.gears.iter().map(|gear| &gear.body).chain(&self.disks)
    }

    /// Finds a gear or disk by name.
    pub fn body(&self, name: &str) -> Option<&Body> {
        self.bodies().find(|body| body.name == name)
    }

    /// Finds a housing, or a point of it, by name: its node, and the point.
    pub fn housing_point(&self, name: &str) -> Option<(Node, HousingPoint)> {
        self.housings.iter().enumerate().find_map(|(index, housing)| {
            let node = Node { shaft: self.shafts.len() + index, node: 0 };
            housing.point(name).map(|point| (node, point))
        })
    }

    /// Names of all supports, housings and points of housings.
    pub fn housing_names(&self) -> impl Iterator<Item = &str> {
        self.housings.iter().flat_map(|housing| std::iter::once(housing.name.as_str()).chain(housing.point_names()))
    }

    /// Name of the shaft, or of the housing, and the position x of a node, m.
    pub fn place(&self, node: Node) -> (&str, f64) {
        match self.shafts.get(node.shaft) {
            Some(shaft) => (&shaft.name, shaft.nodes[node.node]),
            None => {
                let housing = &self.housings[node.shaft - self.shafts.len()];
                (&housing.name, housing.centre[0])
            }
        }
    }

    /// Nodes with bearings, each once.
    pub fn bearing_nodes(&self) -> Vec<Node> {
        let mut nodes: Vec<Node> = Vec::new();
        for bearing in &self.bearings {
            if !nodes.contains(&bearing.node) {
                nodes.push(bearing.node);
            }
        }
        nodes
    }

    /// The nodes of a shaft at which bearings hold it, with the index of each bearing.
    pub fn held_nodes(&self, shaft: usize) -> impl Iterator<Item = (usize, usize)> + Clone + '_ {
        let nodes = |(index, bearing): (usize, &Bearing)| bearing.nodes().map(move |node| (index, node));
        self.bearings
            .iter()
            .enumerate()
            .flat_map(nodes)
            .filter_map(move |(index, node)| (node.shaft == shaft).then_some((index, node.node)))
    }

    /// Speeds of the shaft of a bearing and of what the bearing stands on, over that of the reference shaft.
    pub fn bearing_speed_ratios(&self, bearing: &Bearing) -> [f64; 2] {
        let mut ratios = bearing.nodes().map(|node| self.speed_ratios[node.shaft]);
        [(); 2].map(|()| ratios.next().unwrap_or(0.0))
    }

    /// Finds a shaft by name.
    pub fn shaft(&self, name: &str) -> Option<usize> {
        self.shafts.iter().position(|shaft| shaft.name == name)
    }

    /// Finds a shaft by the name that the entry `at` contains.
    ///
    /// # Errors
    /// [`SceneError`] if no shaft has this name.
    pub(crate) fn known_shaft(&self, name: &str, at: &EntryPath) -> Result<usize, SceneError> {
        let names = || self.shafts.iter().map(|shaft| shaft.name.as_str());
        let unknown = || at.error(format!("no shaft is called \"{name}\"{}", nearest(name, names())));
        self.shaft(name).ok_or_else(unknown)
    }

    /// Finds the mesh of two gears, in either order.
    pub fn mesh(&self, first: &str, second: &str) -> Option<usize> {
        let name = |gear: usize| self.gears[gear].body.name.as_str();
        self.meshes.iter().position(|mesh| {
            let pair = (name(mesh.driver), name(mesh.driven));
            pair == (first, second) || pair == (second, first)
        })
    }

    /// The shortest element: name of its shaft, position of its begin, m, and length, m.
    pub fn shortest_element(&self) -> (&str, f64, f64) {
        let mut shortest = (self.shafts[0].name.as_str(), 0.0, f64::INFINITY);
        for shaft in &self.shafts {
            for (element, x) in shaft.elements.iter().zip(&shaft.nodes) {
                if element.length < shortest.2 {
                    shortest = (&shaft.name, *x, element.length);
                }
            }
        }
        shortest
    }

    /// Whether nodes have lateral coordinates and twist: `(lateral, torsion)`.
    ///
    /// By default, bearings, bow, unbalance, gravity and forces need lateral coordinates; meshes, torques, drives and
    /// couplings need twist.
    fn required_motion(&self, requested: Option<MotionKind>) -> Result<(bool, bool), SceneError> {
        let varying = |torque: bool| self.varying_loads.iter().any(|load| load.law.is_torque() == torque);
        let driven = !self.drives.is_empty() || varying(true);
        let twisted = !self.meshes.is_empty() || !self.torques.is_empty() || driven;
        let bent = self.shafts.iter().any(|shaft| shaft.bow.is_some())
            || self.bodies().any(|body| body.unbalance.norm() > 0.0)
            || self.gravity != [0.0; 2]
            || !self.forces.is_empty()
            || varying(false);
        let thrust = self.forces.iter().any(|force| force.axial != 0.0)
            || self.bearings.iter().any(|bearing| bearing.ring().is_some());
        let coupled = !self.couplings.is_empty();
        let supported = !self.bearings.is_empty();
        let motion = EntryPath::root("motion");
        match requested {
            Some(MotionKind::Lateral) if twisted => {
                Err(motion.error("\"lateral\" has no twist, on which meshes, torques and drives act; use \"coupled\""))
            }
            Some(MotionKind::Lateral) if thrust => {
                Err(motion.error("\"lateral\" has no axial motion, on which axial forces and bearings with five degrees of freedom act; use \"coupled\""))
            }
            Some(MotionKind::Torsion) if bent => Err(motion
                .error("\"torsion\" has no bending, on which bow, unbalance, gravity and forces act; use \"coupled\"")),
            Some(MotionKind::Lateral) => Ok((true, false)),
            Some(MotionKind::Torsion) => Ok((false, true)),
            Some(MotionKind::Coupled) => Ok((true, true)),
            None if supported || bent => Ok((true, twisted || coupled)),
            None => Ok((!twisted, true)),
        }
    }

    /// Whether nodes have an axial displacement: in a scene with lateral coordinates if a mesh has a helix, or if an axial
    /// force or a bearing acts along the axis.
    fn has_axial_motion(&self, requested: Option<MotionKind>) -> bool {
        let helical = self.meshes.iter().any(|mesh| self.gears[mesh.driver].helix_angle != 0.0);
        let loaded = self.forces.iter().any(|force| force.axial != 0.0);
        let held = self.bearings.iter().any(|bearing| !bearing.axial.is_zero() || bearing.ring().is_some());
        self.lateral && requested != Some(MotionKind::Lateral) && (helical || loaded || held)
    }
}

fn disks(system: &SceneDescription, names: &Names, shafts: &[Shaft]) -> Result<Vec<Body>, SceneError> {
    let body = |(index, disk): (usize, &description::Disk)| {
        let at = EntryPath::entry("disks", index);
        Ok(Body {
            name: disk.name.clone(),
            node: names.node(shafts, &disk.shaft, disk.position, &at)?,
            mass: at.field("mass").non_negative(disk.mass)?,
            diametral_inertia: at.field("diametral_inertia").non_negative(disk.diametral_inertia)?,
            polar_inertia: at.field("polar_inertia").non_negative(disk.polar_inertia)?,
            unbalance: complex(disk.unbalance, &at.field("unbalance"))?,
        })
    };
    system.disks.iter().enumerate().map(body).collect()
}

fn complex(given: Option<description::Complex>, at: &EntryPath) -> Result<Complex64, SceneError> {
    let value = given.map_or(Complex64::ZERO, Complex64::from);
    at.finite(value.re)?;
    at.finite(value.im)?;
    Ok(value)
}

fn rayleigh(system: &SceneDescription) -> Result<[f64; 2], SceneError> {
    let [alpha, beta] = system.rayleigh.unwrap_or([0.0; 2]);
    let at = EntryPath::root("rayleigh");
    Ok([at.index(0).non_negative(alpha)?, at.index(1).non_negative(beta)?])
}

fn gravity(system: &SceneDescription) -> Result<[f64; 2], SceneError> {
    let at = EntryPath::root("gravity");
    match system.gravity {
        None => Ok([0.0; 2]),
        Some(description::Gravity::Down(g)) => Ok([0.0, -at.finite(g)?]),
        Some(description::Gravity::Vector([y, z])) => Ok([at.index(0).finite(y)?, at.index(1).finite(z)?]),
    }
}
