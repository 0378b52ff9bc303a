//! Connections of the model, and the model at a constant speed.

use nalgebra::DVector;

use super::link::links;
use super::{Model, Numbering, Support, bearing_rows};
use crate::connection::{AppliedLoad, Connection, JournalBearing, OperatingPoint, SpeedDependentBearing};
use crate::film::Film;
use crate::scene::{Bearing, BearingCoefficient, EntryPath, LoadLaw, Node, Scene, SceneError};

/// Standard gravity, m/s².
const STANDARD_GRAVITY: f64 = 9.806_65;

/// Bearings with constant coefficients on the ground, and bearings that depend on the speed.
pub(super) fn bearings(scene: &Scene, numbering: &Numbering) -> (Vec<Support>, Vec<SpeedDependentBearing>) {
    let (mut supports, mut bearings) = (Vec::new(), Vec::new());
    for (number, bearing) in scene.bearings.iter().enumerate() {
        let rows = bearing_rows(scene, numbering, bearing).filter(|_| bearing.journal.is_none());
        let (Some(index), Some(rows)) = (numbering.translation(bearing.node), rows) else {
            continue;
        };
        match (bearing.stiffness.constant(), bearing.damping.constant()) {
            // A bearing on a housing is a link.
            (Some(_), Some(_)) if bearing.attachment.is_some() => {}
            (Some(stiffness), Some(damping)) => supports.push(Support::new(index, stiffness, damping)),
            _ => {
                let ratio = scene.speed_ratios[bearing.node.shaft];
                bearings.push(SpeedDependentBearing { number, bearing: bearing.clone(), rows, ratio });
            }
        }
    }
    (supports, bearings)
}

/// Journal bearings, without coefficients in the matrices.
pub(super) fn journals(scene: &Scene, numbering: &Numbering) -> Vec<JournalBearing> {
    let journal = |(number, bearing): (usize, &Bearing)| {
        let (journal, index) = (bearing.journal.as_ref()?, numbering.translation(bearing.node)?);
        let ratio = scene.speed_ratios[bearing.node.shaft];
        Some(JournalBearing { number, index, ratio, film: Film::new(journal), point: None })
    };
    scene.bearings.iter().enumerate().filter_map(journal).collect()
}

impl Model {
    /// Whether the matrices lack the coefficients of bearings, because the model is not that of one speed.
    pub fn lacks_coefficients(&self) -> bool {
        !self.bearings.is_empty() || self.journals.iter().any(|journal| journal.point.is_none())
    }

    /// Whether this is the model at a speed of the reference shaft, rad/s.
    pub fn is_at(&self, speed: f64) -> bool {
        let is_at = |journal: &JournalBearing| journal.point.is_some_and(|point| point.speed == Some(speed));
        self.bearings.is_empty() && self.journals.iter().all(is_at)
    }

    /// The model with coefficients of its journal bearings in the matrices, one for each.
    pub fn with_points(mut self, point: impl Fn(&JournalBearing) -> OperatingPoint) -> Self {
        self.supports.truncate(self.supports.len() - self.journals.iter().filter(|it| it.point.is_some()).count());
        for journal in &mut self.journals {
            let found = point(journal);
            journal.point = Some(found);
            self.supports.push(Support::new(journal.index, found.stiffness, found.damping));
        }
        self
    }

    /// The model with a stiffness of its journal bearings with which the search of the equilibrium starts: the film carries
    /// the weight of its shaft at a displacement of a third of the clearance.
    pub fn with_provisional_points(self) -> Self {
        let weights: Vec<f64> = (0..self.shafts.len()).map(|shaft| STANDARD_GRAVITY * self.mass_of(shaft)).collect();
        let shafts: Vec<usize> = self.scene.bearings.iter().map(|bearing| bearing.node.shaft).collect();
        self.with_points(|journal| {
            let stiffness = 3.0 * weights[shafts[journal.number]] / journal.film.clearance();
            let stiffness = [[stiffness, 0.0], [0.0, stiffness]];
            OperatingPoint { speed: None, stiffness, damping: [[0.0; 2]; 2] }
        })
    }

    /// Mass of a shaft with the bodies on it, kg.
    fn mass_of(&self, shaft: usize) -> f64 {
        let mut motion = vec![0.0; self.len()];
        for node in 0..self.scene.shafts[shaft].nodes.len() {
            if let Some(v) = self.numbering.translation(Node { shaft, node }) {
                motion[v] = 1.0;
            }
        }
        self.kinetic_form(&motion)
    }

    /// The model with the coefficients of the films at the displacements q of the equilibrium at a speed, rad/s.
    pub fn with_points_at(self, speed: f64, q: &[f64]) -> Self {
        let rest = vec![0.0; q.len()];
        self.with_points(|journal| {
            let film = journal.film_force(speed, q, &rest);
            OperatingPoint { speed: Some(speed), stiffness: film.stiffness, damping: film.damping }
        })
    }

    /// Force of the shaft on the bearings at a node in the directions (y, z), N, for displacements q of a system at rest and
    /// a speed of the reference shaft, rad/s; bearings with tables are those of the model.
    pub fn static_bearing_force(&self, node: Node, speed: f64, q: &[f64]) -> [f64; 2] {
        let rest = vec![0.0; q.len()];
        self.journals_at(node).fold(self.bearing_force(node, q, &rest), |sum, journal| {
            let own = journal.static_tangent(speed, q).0;
            [sum[0] + own[0], sum[1] + own[1]]
        })
    }

    /// The journal bearings at a node.
    pub fn journals_at(&self, node: Node) -> impl Iterator<Item = &JournalBearing> {
        self.journals.iter().filter(move |journal| self.scene.bearings[journal.number].node == node)
    }

    /// All connections, meshes first, with the flanks that carry at a speed of the reference shaft, rad/s.
    pub fn connections(&self, speed: f64) -> impl Iterator<Item = Connection<'_>> {
        self.connections_with(move |mesh| self.sigma(mesh, speed))
    }

    /// All connections, meshes first, with the σ of each mesh.
    #[inline(always)]
    pub fn connections_with<'a>(
        &'a self,
        sigma: impl Fn(usize) -> f64 + 'a,
    ) -> impl Iterator<Item = Connection<'a>> + 'a {
        let meshes = self.meshes.iter().enumerate();
        let meshes = meshes.map(move |(index, mesh)| Connection::Mesh(index, mesh, sigma(index)));
        let others = self.bearings.iter().map(Connection::Bearing).chain(self.journals.iter().map(Connection::Journal));
        let others = others.chain(self.springs.iter().map(Connection::Spring));
        meshes.chain(others).chain(self.loads.iter().map(Connection::Load))
    }

    /// Refuses a speed of the reference shaft [rad/s] at which a bearing has no coefficients or a torque no value.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the table, the speed of the shaft and the range of the table.
    pub fn check_speed(&self, speed: f64) -> Result<(), SceneError> {
        if let Some(journal) = self.journals.iter().find(|journal| journal.stands(speed)) {
            let message = "the film of a journal bearing carries no load at speed 0; give a speed, such as static(speed=...) or modes(speed=...)";
            return Err(EntryPath::entry("bearings", journal.number).error(message));
        }
        self.check_tables(speed)
    }

    /// Refuses a speed of the reference shaft [rad/s] that a table does not contain.
    fn check_tables(&self, speed: f64) -> Result<(), SceneError> {
        self.loads.iter().try_for_each(|load| load.check(speed))?;
        self.bearings.iter().try_for_each(|bearing| {
            let shaft = &self.scene.shafts[bearing.bearing.node.shaft];
            bearing.check(speed, &shaft.name)
        })
    }

    /// The model at a constant speed of the reference shaft [rad/s]: every bearing has constant coefficients and belongs
    /// to the matrices.
    ///
    /// # Errors
    /// [`SceneError`] where [`Self::check_speed`] refuses the speed.
    pub fn at_speed(&self, speed: f64) -> Result<Self, SceneError> {
        self.check_speed(speed)?;
        self.at_tabulated_speed(speed)
    }

    /// The same for the bearings with tables only.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the table, the speed of the shaft and the range of the table.
    pub fn at_tabulated_speed(&self, speed: f64) -> Result<Self, SceneError> {
        self.check_tables(speed)?;
        let mut model = self.clone();
        for bearing in &self.bearings {
            let given = &mut model.scene.bearings[bearing.number];
            let [stiffness, damping] = bearing.at(speed);
            given.stiffness = BearingCoefficient::Constant(stiffness);
            given.damping = BearingCoefficient::Constant(damping);
        }
        let points: Vec<_> = self.journals.iter().filter_map(|journal| journal.point).collect();
        (model.supports, model.bearings) = bearings(&model.scene, &model.numbering);
        let journals = self.journals.iter().map(|journal| journal.index);
        model
            .supports
            .extend(journals.zip(points).map(|(index, point)| Support::new(index, point.stiffness, point.damping)));
        model.links = links(&model.scene, &model.numbering);
        Ok(model)
    }

    /// Whether stiffness or damping depend on the speed: those of bearings, or the slope of a torque over the speed.
    pub fn depends_on_speed(&self) -> bool {
        let is_over_speed = |load: &AppliedLoad| matches!(load.law, LoadLaw::SpeedTorque { .. });
        self.lacks_coefficients() || self.loads.iter().any(is_over_speed)
    }

    /// Torques over the speed at a speed of the reference shaft, rad/s, n entries, N m.
    pub fn speed_torques(&self, speed: f64) -> DVector<f64> {
        let mut torques = DVector::zeros(self.len());
        for load in &self.loads {
            load.rows[0].iter().for_each(|(index, factor)| torques[*index] += factor * load.constant(speed));
        }
        torques
    }

    /// The bearings at a node whose coefficients depend on the speed.
    pub fn bearings_at(&self, node: Node) -> impl Iterator<Item = &SpeedDependentBearing> {
        self.bearings.iter().filter(move |bearing| bearing.bearing.node == node)
    }
}
