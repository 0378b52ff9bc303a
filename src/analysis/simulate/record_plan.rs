//! Quantities to record, with names resolved to nodes and meshes. A run computes only the coordinates that they need.

use crate::analysis::{Kept, product};
use crate::connection::{MESH_CHANNELS, ROLLING_CHANNELS, TurningBow};
use crate::exponential::Selection;
use crate::model::{Combination, Cut, Model, PlaceRows, SECTION_FORCES};
use crate::motion::{Energies, EquationOfMotion, PowerCoordinates, SourceTerms, connected_coordinates};
use crate::scene::description::Place;
use crate::scene::{EntryPath, Node, SceneError, nearest};

/// Names of everything of one kind.
const RECORD_GROUPS: [&str; 10] = [
    "gears",
    "disks",
    "meshes",
    "bearings",
    "nodes",
    "housings",
    "energy",
    VELOCITY,
    ACCELERATION,
    SECTION_FORCES_NAME,
];

const VELOCITY: &str = "velocity";
const ACCELERATION: &str = "acceleration";
const SECTION_FORCES_NAME: &str = "section_forces";

/// One entry of the list of quantities to record.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// A gear, disk, shaft, housing or point of a housing, or a group: gears, disks, meshes, bearings, nodes, housings,
    /// energy, velocity, acceleration or section forces of the recorded nodes.
    Name(String),
    /// A place on a shaft.
    OnShaft(String, f64),
    /// The mesh of two gears.
    Mesh(String, String),
    /// The bearings at a node of a shaft.
    Bearing(String, f64),
}

impl Request {
    /// Whether it is this name.
    fn is(&self, name: &str) -> bool {
        matches!(self, Self::Name(own) if own == name)
    }
}

/// A place to record.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Name of the shaft or housing.
    pub part: String,
    /// Position x, m: on the shaft, or of the centre of mass of the housing.
    pub position: f64,
    /// Names of the gears and disks there, or of the point of the housing.
    pub names: Vec<String>,
    /// Displacements over the coordinates.
    pub rows: PlaceRows,
}

/// The quantities to record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordPlan {
    /// Places whose displacement, twist and axial displacement are recorded.
    pub points: Vec<Point>,
    /// Nodes whose bearing force is recorded.
    pub bearings: Vec<Node>,
    /// Indices of the recorded meshes.
    pub meshes: Vec<usize>,
    /// Whether energies and works are recorded.
    pub energy: bool,
    /// Whether velocities and twist rates of the points are recorded.
    pub velocity: bool,
    /// Whether accelerations of the points are recorded.
    pub acceleration: bool,
    /// Cuts through the shafts at the points, whose section forces are recorded.
    pub cuts: Vec<Cut>,
}

impl Point {
    /// Whether it is at a position, m, of the shaft or housing called `part`.
    fn is_at(&self, part: &str, position: f64) -> bool {
        self.part == part && self.position == position
    }
}

impl RecordPlan {
    /// Resolves `requests`. A quantity that is requested twice is recorded once.
    ///
    /// # Errors
    /// [`SceneError`] for an entry that the scene does not have.
    pub fn new(model: &Model, requests: &[Request]) -> Result<Self, SceneError> {
        let mut plan = Self::default();
        for (index, request) in requests.iter().enumerate() {
            plan.add(model, request, &EntryPath::entry("record", index))?;
        }
        let of_points =
            |request: &&Request| [VELOCITY, ACCELERATION, SECTION_FORCES_NAME].iter().any(|name| request.is(name));
        if let (true, Some(Request::Name(name))) = (plan.points.is_empty(), requests.iter().find(of_points)) {
            let message = if plan.bearings.is_empty() {
                format!("\"{name}\" is that of the recorded places; add one, such as \"gears\"")
            } else {
                format!(
                    "\"{name}\" is that of the recorded places, and a bearing is none: it stands on the ground or on a support; add the name of its support, or (shaft, position)"
                )
            };
            return Err(SceneError::new("record", message));
        }
        if requests.iter().any(|request| request.is(SECTION_FORCES_NAME)) {
            plan.add_cuts(model)?;
        }
        Ok(plan)
    }

    /// Memory of the record of a number of times, bytes.
    pub fn bytes(&self, model: &Model, times: usize) -> u64 {
        let axial = usize::from(model.scene.axial);
        // Displacements over y and z, the twist and the axial displacement, and their rates and accelerations.
        let rates = 1 + usize::from(self.velocity) + usize::from(self.acceleration);
        let rolling = self.bearings.iter().filter(|node| model.rolls_at(**node)).count();
        let values = 1
            + rates * (3 + axial) * self.points.len()
            + (4 + axial) * self.bearings.len()
            + ROLLING_CHANNELS.len() * rolling
            + SECTION_FORCES * self.cuts.len()
            + MESH_CHANNELS.len() * self.meshes.len();
        // Energies are kept in the record and in the arrays of the result.
        let energies = usize::from(self.energy) * (size_of::<(Energies, SourceTerms)>() + 12 * size_of::<f64>());
        product(&[times, values * size_of::<f64>() + energies])
    }

    /// Refuses a record of a number of times that does not fit into memory.
    ///
    /// # Errors
    /// [`SceneError`] with the required and the available memory.
    pub fn require_memory(&self, model: &Model, times: usize) -> Result<(), SceneError> {
        let kept = Kept {
            argument: "record",
            what: format!("the recorded quantities at {times} times"),
            bytes: self.bytes(model, times),
            remedy: "record fewer places or quantities (record=), or fewer times (output_step=, times=)",
        };
        kept.require()
    }

    fn add(&mut self, model: &Model, request: &Request, at: &EntryPath) -> Result<(), SceneError> {
        let scene = &model.scene;
        match request {
            Request::Name(name) => match name.as_str() {
                "gears" => scene.gears.iter().for_each(|gear| self.add_point(model, gear.body.node)),
                "disks" => scene.disks.iter().for_each(|disk| self.add_point(model, disk.node)),
                "meshes" => (0..scene.meshes.len()).for_each(|mesh| self.add_mesh(mesh)),
                "bearings" => scene.bearings.iter().for_each(|bearing| self.add_bearing(model, bearing.node)),
                "nodes" => (0..scene.shafts.len()).for_each(|shaft| self.add_shaft(model, shaft)),
                "energy" => self.energy = true,
                VELOCITY => self.velocity = true,
                ACCELERATION => self.acceleration = true,
                // The cuts follow when all places are known.
                SECTION_FORCES_NAME => {}
                "housings" => scene.housing_names().for_each(|name| self.add_housing_point(model, name)),
                _ if scene.housing_point(name).is_some() => self.add_housing_point(model, name),
                _ => match (scene.body(name), scene.shaft(name)) {
                    (Some(body), _) => self.add_point(model, body.node),
                    (None, Some(shaft)) => self.add_shaft(model, shaft),
                    (None, None) => {
                        let bodies = scene.bodies().map(|body| body.name.as_str());
                        let shafts = scene.shafts.iter().map(|shaft| shaft.name.as_str());
                        // "mesh" is the beginning of a group, but its edit distance to "meshes" is large.
                        let near = match RECORD_GROUPS
                            .iter()
                            .find(|group| name.len() > 2 && group.starts_with(name.as_str()))
                        {
                            Some(group) => format!("; did you mean \"{group}\"?"),
                            None => {
                                nearest(name, bodies.chain(shafts).chain(scene.housing_names()).chain(RECORD_GROUPS))
                            }
                        };
                        let groups = RECORD_GROUPS.join(", ");
                        return Err(at.error(format!(
                            "\"{name}\" is no gear, disk, shaft or housing, and none of {groups}{near}"
                        )));
                    }
                },
            },
            Request::OnShaft(shaft, position) => {
                let index = scene.known_shaft(shaft, at)?;
                match scene.shafts[index].node_at(*position) {
                    Some(node) => self.add_point(model, Node { shaft: index, node }),
                    None => self.add_place(model, &Place::Shaft(shaft.clone(), *position), at)?,
                }
            }
            Request::Bearing(shaft, position) => {
                let node = node(model, shaft, *position, at)?;
                if scene.bearings.iter().all(|bearing| bearing.node != node) {
                    return Err(at.error(format!("no bearing stands at {position} m of shaft \"{shaft}\"")));
                }
                self.add_bearing(model, node);
            }
            Request::Mesh(first, second) => {
                let mesh = scene.mesh(first, second);
                let near = || {
                    let gears = || scene.gears.iter().map(|gear| gear.body.name.as_str());
                    let unknown = [first, second].into_iter().find(|name| !gears().any(|gear| gear == name.as_str()));
                    unknown.map_or_else(String::new, |name| nearest(name, gears()))
                };
                let error = || at.error(format!("\"{first}\" and \"{second}\" are not in mesh{}", near()));
                self.add_mesh(mesh.ok_or_else(error)?);
            }
        }
        Ok(())
    }

    fn add_shaft(&mut self, model: &Model, shaft: usize) {
        for node in 0..model.scene.shafts[shaft].nodes.len() {
            self.add_point(model, Node { shaft, node });
        }
    }

    fn add_point(&mut self, model: &Model, node: Node) {
        let (part, position) = model.scene.place(node);
        if self.points.iter().all(|point| !point.is_at(part, position)) {
            let bodies = model.scene.bodies().filter(|body| body.node == node);
            let names = bodies.map(|body| body.name.clone()).collect();
            let rows = model.node_rows(node);
            self.points.push(Point { part: part.to_owned(), position, names, rows });
        }
    }

    /// Adds a place between the nodes of a shaft.
    fn add_place(&mut self, model: &Model, place: &Place, at: &EntryPath) -> Result<(), SceneError> {
        let rows = model.place_rows(place, at)?;
        if let Place::Shaft(part, position) = place
            && self.points.iter().all(|point| !point.is_at(part, *position))
        {
            self.points.push(Point { part: part.clone(), position: *position, names: Vec::new(), rows });
        }
        Ok(())
    }

    fn add_housing_point(&mut self, model: &Model, name: &str) {
        let known = self.points.iter().any(|point| point.names.iter().any(|known| known == name));
        if let Some((node, point)) = model.scene.housing_point(name).filter(|_| !known) {
            let (part, position) = model.scene.place(node);
            let (names, rows) = (vec![name.to_owned()], model.housing_rows(node, point));
            self.points.push(Point { part: part.to_owned(), position, names, rows });
        }
    }

    /// Adds the cuts at all points of shafts.
    fn add_cuts(&mut self, model: &Model) -> Result<(), SceneError> {
        for point in &self.points {
            if let Some(shaft) = model.scene.shaft(&point.part) {
                self.cuts.extend(model.cuts(shaft, point.position, &EntryPath::root("record"))?);
            }
        }
        if self.cuts.is_empty() {
            let message = format!("\"{SECTION_FORCES_NAME}\" are those of the recorded places of shafts; add one");
            return Err(SceneError::new("record", message));
        }
        Ok(())
    }

    fn add_mesh(&mut self, mesh: usize) {
        if !self.meshes.contains(&mesh) {
            self.meshes.push(mesh);
        }
    }

    /// Adds the bearings at a node. The eccentricity of a journal needs its displacement.
    fn add_bearing(&mut self, model: &Model, node: Node) {
        if !self.bearings.contains(&node) {
            self.bearings.push(node);
        }
        if model.nonlinear_bearings_at(node).any(|bearing| bearing.is_journal()) {
            self.add_point(model, node);
        }
    }

    /// Indices of the coordinates that recording needs, ascending.
    pub(super) fn coordinates(&self, model: &Model) -> Vec<usize> {
        if self.energy {
            return (0..model.len()).collect();
        }
        let mut coordinates = Vec::new();
        let mut add_node = |node: Node| {
            coordinates.extend(model.numbering.translation(node).into_iter().flat_map(|v| [v, v + 1]));
            coordinates.extend(model.numbering.twist(node));
            coordinates.extend(model.numbering.displacement_along(node));
        };
        self.bearings.iter().for_each(|node| add_node(*node));
        let points: Vec<usize> = self.points.iter().flat_map(|point| point.rows.coordinates()).collect();
        let bases: Vec<usize> = self.bearings.iter().flat_map(|node| model.bearing_coordinates(*node)).collect();
        let of_meshes: Vec<usize> = self.meshes.iter().flat_map(|mesh| model.meshes[*mesh].indices()).collect();
        for mesh in &self.meshes {
            let pair = &model.scene.meshes[*mesh];
            for gear in [pair.driver, pair.driven] {
                add_node(model.scene.gears[gear].body.node);
            }
        }
        coordinates.extend(points.into_iter().chain(bases).chain(of_meshes));
        if model.scene.has_turning_frame() {
            // The recorder turns the coordinates to those seen from the ground, which combinations do not.
            coordinates.extend(self.cuts.iter().flat_map(Cut::coordinates));
        }
        let turning = self.cuts.iter().filter_map(|cut| model.turning_bow(cut.shaft));
        coordinates.extend(turning.flat_map(TurningBow::twist_coordinates));
        coordinates.sort_unstable();
        coordinates.dedup();
        coordinates
    }
}

impl RecordPlan {
    /// Indices of the coordinates whose accelerations recording needs, ascending.
    pub(super) fn accelerated(&self, model: &Model) -> Vec<usize> {
        let points = if self.acceleration { self.points.clone() } else { Vec::new() };
        Self { points, cuts: self.cuts.clone(), ..Self::default() }.coordinates(model)
    }

    /// Combinations of coordinates from which [`Cut::combined`] finds the section forces in a motion.
    pub(super) fn combinations(&self, motion: &EquationOfMotion<'_>) -> Vec<Combination> {
        let spin = |cut: &Cut| motion.has_constant_speed().then(|| motion.spin(cut.shaft));
        self.cuts.iter().flat_map(|cut| cut.combinations(spin(cut))).collect()
    }

    /// Indices of the displacements, velocities and accelerations that recording needs.
    pub(super) fn selection(&self, model: &Model) -> Selection {
        let accelerations = self.accelerated(model);
        let [displacements, velocities] = self.without_energies(model);
        if !self.energy {
            return Selection { displacements, velocities, accelerations, ..Selection::default() };
        }
        let connected = connected_coordinates(model);
        let without_energies = [displacements, velocities].map(|mut own| {
            own.extend(&connected);
            own.sort_unstable();
            own.dedup();
            own
        });
        Selection {
            displacements: self.coordinates(model),
            velocities: self.coordinates(model),
            accelerations,
            combinations: Vec::new(),
            without_energies: Some(without_energies),
            powers: Some(PowerCoordinates::new(model)),
        }
    }

    /// Indices of the displacements and of the velocities that recording needs besides the energies, ascending.
    fn without_energies(&self, model: &Model) -> [Vec<usize>; 2] {
        let resting = Self { energy: false, ..self.clone() };
        // Seen from the ground, the acceleration in a frame that turns depends on the velocity.
        let has_velocity = self.velocity || self.acceleration && model.scene.has_turning_frame();
        let points = if has_velocity { self.points.clone() } else { Vec::new() };
        let mut moving = Self { points, ..resting.clone() };
        // Contact events need the velocities at all meshes with backlash.
        (0..model.meshes.len()).filter(|mesh| model.meshes[*mesh].backlash.is_some()).for_each(|m| moving.add_mesh(m));
        [resting, moving].map(|plan| plan.coordinates(model))
    }
}

fn node(model: &Model, shaft: &str, position: f64, at: &EntryPath) -> Result<Node, SceneError> {
    let index = model.scene.known_shaft(shaft, at)?;
    Ok(Node { shaft: index, node: model.scene.shafts[index].require_node(position, at)? })
}
