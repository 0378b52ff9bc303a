//! Connections of the model, and the coefficients of bearings at a speed and a frequency.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::link::{Link, axial_bearing_row, links, mount_rows, slope_rows};
use super::{Model, Numbering, Support, bearing_rows};
use crate::connection::{BearingLaw, Connection, NonlinearBearing, OperatingPoint, Row, SpeedDependentBearing, Tilt};
use crate::film::{Film, TiltingPads};
use crate::numerics::ROUND_OFF;
use crate::rolling::{Ring, RollingElements};
use crate::scene::{
    Attachment, Bearing, BearingCoefficient, EntryPath, Journal, LoadLaw, Matrix2, Node, Nonlinear, STANDARD_GRAVITY,
    Scene, SceneError,
};

/// Bearings with constant coefficients on the ground, and bearings that depend on the speed,
/// that follow the `nonlinear` ones.
pub(super) fn bearings(
    scene: &Scene,
    numbering: &Numbering,
    nonlinear: usize,
) -> (Vec<Support>, Vec<SpeedDependentBearing>) {
    let (mut supports, mut bearings) = (Vec::new(), Vec::new());
    for (number, bearing) in scene.bearings.iter().enumerate() {
        let rows = bearing_rows(scene, numbering, bearing).filter(|_| bearing.has_constant_part());
        let (Some(index), Some(rows)) = (numbering.translation(bearing.node), rows) else {
            continue;
        };
        match (bearing.stiffness.constant(), bearing.damping.constant()) {
            // Links contain the linear bearings that stand on a housing or on another shaft, or are misaligned.
            (Some(_), Some(_)) if !bearing.is_plain_support() => {}
            (Some(stiffness), Some(damping)) => {
                let support = Support::new(index, stiffness, damping).with_loss_factor(bearing.loss_factor);
                supports.push(support.in_frame(scene.frame_ratio(bearing.node.shaft)));
            }
            _ => {
                let [shaft, base] = scene.bearing_speed_ratios(bearing);
                let (ratio, turning) = (shaft - base, first_bearing(scene) + nonlinear + bearings.len());
                bearings.push(SpeedDependentBearing { number, bearing: bearing.clone(), rows, ratio, turning });
            }
        }
    }
    (supports, bearings)
}

/// Index in [`Model::turning_ratio`] of the first bearing.
fn first_bearing(scene: &Scene) -> usize {
    2 * scene.shafts.len()
}

/// Nonlinear bearings, without coefficients in the matrices.
pub(super) fn nonlinear_bearings(scene: &Scene, numbering: &Numbering) -> Vec<NonlinearBearing> {
    let direction = |bearing: &Bearing| scene.bearing_speed_ratios(bearing).iter().sum::<f64>();
    let law = |bearing: &Bearing| match bearing.nonlinear.as_ref()? {
        Nonlinear::Journal(journal) => {
            let direction = direction(bearing);
            let reduced = TiltingPads::new(journal, direction).map(BearingLaw::Tilting);
            Some(reduced.unwrap_or_else(|| BearingLaw::Film(Film::new(journal, direction))))
        }
        Nonlinear::Rolling(rolling) if bearing.ring().is_some() => Some(BearingLaw::Ring(Ring::new(rolling))),
        Nonlinear::Rolling(rolling) => {
            let damping = bearing.damping.constant().unwrap_or_default();
            Some(BearingLaw::Rolling(RollingElements::new(rolling, damping)))
        }
    };
    let mut found = Vec::new();
    for (number, bearing) in scene.bearings.iter().enumerate() {
        if let Some((pads, rows)) = pad_modes(scene, numbering, bearing).zip(bearing_rows(scene, numbering, bearing)) {
            for (film, motions) in pads.films(direction(bearing)) {
                let (turning, ratios) = (first_bearing(scene) + found.len(), scene.bearing_speed_ratios(bearing));
                let row = |axis: usize| {
                    let own = motions.iter().map(|(index, way)| (*index, -way[axis]));
                    rows[axis].iter().copied().chain(own).collect()
                };
                let rows = vec![row(0), row(1)];
                let pad = NonlinearBearing::new(number, rows, turning, ratios, BearingLaw::Film(film));
                let tilt = motions.first().map(|(index, way)| Tilt { index: *index, scale: way[0].hypot(way[1]) });
                found.push(NonlinearBearing { tilt, ..pad });
            }
        } else if let Some((law, rows)) = law(bearing).zip(bearing_rows(scene, numbering, bearing)) {
            let mut rows = Vec::from(rows);
            if let BearingLaw::Ring(ring) = &law {
                rows.push(axial_bearing_row(scene, numbering, bearing));
                let slopes = slope_rows(scene, numbering, bearing).unwrap_or_default();
                rows.extend(slopes.map(|row| row.into_iter().map(|(index, c)| (index, ring.radius * c)).collect()));
            }
            let (turning, ratios) = (first_bearing(scene) + found.len(), scene.bearing_speed_ratios(bearing));
            found.push(NonlinearBearing::new(number, rows, turning, ratios, law));
        }
    }
    for (index, housing) in scene.housings.iter().enumerate() {
        let node = Node { shaft: scene.shafts.len() + index, node: 0 };
        let stands = |bearing: &Bearing| matches!(bearing.attachment, Some(Attachment::Housing { housing, .. }) if housing == index);
        let (Some(squeeze), Some(first), Some(number)) =
            (&housing.squeeze, numbering.translation(node), scene.bearings.iter().position(stands))
        else {
            continue;
        };
        let rows = mount_rows(scene, numbering, housing, first).into();
        let turning = first_bearing(scene) + found.len();
        let law = BearingLaw::Film(Film::of_squeeze(squeeze));
        found.push(NonlinearBearing::new(number, rows, turning, [0.0; 2], law));
    }
    found
}

/// Tilting pads whose motions are coordinates.
struct PadModes<'a> {
    journal: &'a Journal,
    /// Index of the first coordinate: the tilts of all pads, then their motions along flexible pivots.
    start: usize,
}

/// The tilting pads of a bearing whose motions are coordinates; none for another bearing.
fn pad_modes<'a>(scene: &'a Scene, numbering: &Numbering, bearing: &'a Bearing) -> Option<PadModes<'a>> {
    let (Some(Nonlinear::Journal(journal)), Some(pads)) = (&bearing.nonlinear, bearing.pads) else { return None };
    let modes = numbering.modes(Node { shaft: scene.shafts.len() + pads, node: 0 })?;
    Some(PadModes { journal, start: modes.start })
}

impl PadModes<'_> {
    /// The film of each pad for a direction of rotation, and the displacement over (y, z) of the pad per unit of its coordinates,
    /// which have unit mass.
    fn films(&self, direction: f64) -> impl Iterator<Item = (Film, Vec<(usize, [f64; 2])>)> + '_ {
        let count = self.journal.pads.len();
        self.journal.pads.iter().enumerate().filter_map(move |(index, pad)| {
            let tilting = self.journal.tilting?;
            let (sin, cos) = pad.closest(1.0).sin_cos();
            let across = tilting.tilt_mass(self.journal).sqrt().recip();
            let mut motions = vec![(self.start + index, [-sin * across, cos * across])];
            if let Some([mass, _]) = tilting.spring {
                let along = mass.sqrt().recip();
                motions.push((self.start + count + index, [cos * along, sin * along]));
            }
            let pad = self.journal.tilting_pad(pad, direction);
            Some((Film::of_pad(self.journal, &pad, direction), motions))
        })
    }
}

/// A spring over one scalar.
struct Spring {
    /// The scalar.
    row: Row,
    /// Stiffness, N/m.
    stiffness: f64,
}

/// The symmetric stiffness of a bearing over its scalars as springs along its eigenvectors. The stiffness of elements that carry
/// in compression only is positive semidefinite: smaller eigenvalues are round-off.
fn principal_springs(bearing: &NonlinearBearing, point: &OperatingPoint) -> Vec<Spring> {
    let n = bearing.rows.len();
    let SymmetricEigen { eigenvectors, eigenvalues } =
        DMatrix::from_fn(n, n, |i, j| point.stiffness[i][j]).symmetric_eigen();
    let least = ROUND_OFF * eigenvalues.amax();
    (0..n)
        .filter(|spring| eigenvalues[*spring] > least)
        .map(|spring| {
            let scaled = |(row, factor): (&Row, &f64)| row.iter().map(|(i, c)| (*i, factor * c)).collect::<Vec<_>>();
            let column = eigenvectors.column(spring);
            Spring {
                row: bearing.rows.iter().zip(column.iter()).flat_map(scaled).collect(),
                stiffness: eigenvalues[spring],
            }
        })
        .collect()
}

impl Model {
    /// Whether the matrices need a speed: they lack the coefficients of bearings that depend on the speed.
    pub fn needs_speed(&self) -> bool {
        !self.bearings.is_empty()
            || self.nonlinear_bearings.iter().any(|bearing| bearing.point.is_none())
            || self.circulates() && self.circulation.is_none()
    }

    /// Whether a shaft has internal damping, whose circulatory forces depend on the speed.
    pub fn has_internal_damping(&self) -> bool {
        self.shafts.iter().any(|shaft| shaft.circulatory.is_some())
    }

    /// Whether the stiffness contains forces that depend on the speed: circulatory ones, or those of a frame that turns.
    pub fn circulates(&self) -> bool {
        self.has_internal_damping() || self.scene.has_turning_frame()
    }

    /// A speed of the reference shaft with the same static equilibrium and the same coefficients of bearings as `speed`, both rad/s:
    /// one for all speeds of a direction of rotation, where nothing at rest depends on the magnitude of the speed. The mean force
    /// of rolling elements does not.
    pub fn static_speed(&self, speed: f64) -> f64 {
        let rolls = |bearing: &NonlinearBearing| bearing.elements().is_some();
        let varies = !self.bearings.is_empty()
            || self.circulates()
            || !self.planets.is_empty()
            || self.has_torques_over_speed()
            || !self.nonlinear_bearings.iter().all(rolls);
        if varies { speed } else { self.rotation(speed).speed() }
    }

    /// Whether this is the model at a speed of the reference shaft, rad/s.
    pub fn is_at_speed(&self, speed: f64) -> bool {
        let known = Some(self.static_speed(speed));
        let is_at = |bearing: &NonlinearBearing| bearing.point.is_some_and(|point| point.speed == known);
        let circulates = !self.circulates() || self.circulation == Some(speed);
        self.bearings.is_empty() && circulates && self.nonlinear_bearings.iter().all(is_at)
    }

    /// The model with coefficients of its nonlinear bearings in the matrices, one for each.
    pub fn with_operating_points(self, point: impl Fn(&NonlinearBearing) -> OperatingPoint) -> Self {
        let mut model = self.without_operating_points();
        for bearing in &mut model.nonlinear_bearings {
            bearing.point = Some(point(bearing));
        }
        model.add_operating_points();
        model
    }

    /// The model without coefficients of its nonlinear bearings in the matrices.
    pub fn without_operating_points(mut self) -> Self {
        self.supports.retain(|support| !support.is_operating_point);
        self.links.retain(|link| !link.local.is_operating_point);
        self.nonlinear_bearings.iter_mut().for_each(|bearing| bearing.point = None);
        self
    }

    /// Adds the coefficients of the nonlinear bearings to the matrices: to the supports for a bearing on the ground with two
    /// scalars, to the links for another one.
    fn add_operating_points(&mut self) {
        for bearing in &self.nonlinear_bearings {
            let Some(point) = &bearing.point else {
                continue;
            };
            let given = &self.scene.bearings[bearing.number];
            let link = |rows: Vec<Row>, stiffness: Matrix2, damping: Matrix2| {
                let link = Link::new(format!("bearings[{}]", bearing.number), rows, stiffness, damping);
                let local = Support { is_operating_point: true, ..link.local };
                Link { bearing: (!bearing.is_squeeze()).then_some(given.node), local, ..link }
            };
            if bearing.rows.len() > 2 {
                let springs = principal_springs(bearing, point).into_iter();
                self.links.extend(springs.map(|Spring { row, stiffness }| {
                    link(vec![row], [[stiffness, 0.0], [0.0, 0.0]], Matrix2::default())
                }));
                continue;
            }
            let stiffness = [0, 1].map(|i| [0, 1].map(|j| point.stiffness[i][j]));
            match given.attachment {
                None if given.pads.is_none() => {
                    let support = Support::new(bearing.rows[0][0].0, stiffness, point.damping);
                    self.supports.push(Support { is_operating_point: true, ..support });
                }
                _ => self.links.push(link(bearing.rows.clone(), stiffness, point.damping)),
            }
        }
    }

    /// Sets the stiffness of nonlinear bearings with which a search of the equilibrium starts: that under the weight of their
    /// shaft.
    pub(super) fn set_initial_stiffness(&mut self) {
        let shaft = |bearing: &NonlinearBearing| self.scene.bearings[bearing.number].node.shaft;
        let weight = |bearing: &NonlinearBearing| STANDARD_GRAVITY * self.mass_of(shaft(bearing));
        let weights: Vec<f64> = self.nonlinear_bearings.iter().map(weight).collect();
        for (bearing, weight) in self.nonlinear_bearings.iter_mut().zip(weights) {
            bearing.set_initial_stiffness(weight);
        }
    }

    /// The model with the stiffness of its nonlinear bearings with which the search of the equilibrium starts.
    pub fn with_initial_operating_points(self) -> Self {
        self.with_operating_points(NonlinearBearing::initial_point)
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

    /// The model with the coefficients of its nonlinear bearings at the displacements q of the equilibrium at a speed, rad/s.
    pub fn with_operating_points_at(self, speed: f64, q: &[f64]) -> Self {
        self.with_operating_points(|bearing| bearing.point_at(speed, q))
    }

    /// Force of the shaft on the bearings at a node along (y, z) and the axis, N, for displacements q of a system at rest and a
    /// speed of the reference shaft, rad/s; bearings with tables are those of the model.
    pub fn static_bearing_force(&self, node: Node, speed: f64, q: &[f64]) -> [f64; 3] {
        let rest = vec![0.0; q.len()];
        self.nonlinear_bearings_at(node).fold(self.bearing_force(node, q, &rest), |sum, bearing| {
            let own = bearing.static_force(speed, q);
            [0, 1, 2].map(|axis| sum[axis] + own[axis])
        })
    }

    /// The nonlinear bearings at a node.
    pub fn nonlinear_bearings_at(&self, node: Node) -> impl Iterator<Item = &NonlinearBearing> {
        let is_there = move |bearing: &&NonlinearBearing| {
            self.scene.bearings[bearing.number].node == node && !bearing.is_squeeze()
        };
        self.nonlinear_bearings.iter().filter(is_there)
    }

    /// Ratio of a speed to that of the reference shaft: the speed of a shaft; after all shafts, that of a shaft relative to the frame
    /// of its lateral motion; then the mean speed of a nonlinear bearing; then the speed of a bearing with tables.
    pub fn turning_ratio(&self, turning: usize) -> f64 {
        let (shafts, nonlinear) = (self.shafts.len(), self.nonlinear_bearings.len());
        let first = first_bearing(&self.scene);
        match turning {
            _ if turning < shafts => self.shafts[turning].ratio,
            _ if turning < first => self.shafts[turning - shafts].ratio_in_frame(),
            _ if turning < first + nonlinear => self.nonlinear_bearings[turning - first].ratio,
            _ => self.bearings[turning - first - nonlinear].ratio,
        }
    }

    /// Number of speeds that [`Self::turning_ratio`] knows.
    pub fn turning_count(&self) -> usize {
        first_bearing(&self.scene) + self.nonlinear_bearings.len() + self.bearings.len()
    }

    /// Index in [`Self::turning_ratio`] of a shaft relative to the frame of its lateral motion.
    #[inline]
    pub fn in_frame(&self, shaft: usize) -> usize {
        self.shafts.len() + shaft
    }

    /// Whether a bearing at a node has rolling elements.
    pub fn rolls_at(&self, node: Node) -> bool {
        self.nonlinear_bearings_at(node).any(|bearing| bearing.elements().is_some())
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
        let nonlinear = self.nonlinear_bearings.iter().map(Connection::Nonlinear);
        let others = self.bearings.iter().map(Connection::Bearing).chain(nonlinear);
        let bows = self.bows.iter().map(Connection::Bow);
        meshes.chain(others).chain(self.loads.iter().map(Connection::Load)).chain(bows)
    }

    /// Refuses a speed of the reference shaft [rad/s] at which a bearing has no coefficients or a torque no value.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the table, the speed of the shaft and the range of the table.
    pub fn check_speed(&self, speed: f64) -> Result<(), SceneError> {
        if let Some(journal) = self.nonlinear_bearings.iter().find(|bearing| bearing.stands(speed)) {
            let message = if journal.ratio == 0.0 {
                "the film of a journal bearing between two shafts carries no load, because the sum of their speeds is 0; use another bearing"
            } else {
                "the film of a journal bearing carries no load at speed 0; give a speed, such as static(speed=...) or modes(speed=...), or speeds of a diagram that begin above 0"
            };
            return Err(EntryPath::entry("bearings", journal.number).error(message));
        }
        self.check_tables(speed)
    }

    /// Refuses a speed of the reference shaft [rad/s] that a table does not contain.
    fn check_tables(&self, speed: f64) -> Result<(), SceneError> {
        self.loads.iter().try_for_each(|load| load.check(speed))?;
        self.bearings.iter().try_for_each(|bearing| {
            let mut names = bearing.bearing.nodes().map(|node| &self.scene.shafts[node.shaft].name);
            let shaft = names.next().map(|name| format!("the shaft \"{name}\"")).unwrap_or_default();
            let base = names.next().map(|name| format!(" relative to \"{name}\"")).unwrap_or_default();
            bearing.check(speed, &format!("{shaft}{base}"))
        })
    }

    /// The model whose bearings with tables have the coefficients of a constant speed of the reference shaft [rad/s] and
    /// belong to the matrices.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the table, the speed of the shaft and the range of the table; for a table over the
    /// frequency.
    pub fn with_tables_at(&self, speed: f64) -> Result<Self, SceneError> {
        self.check_tables(speed)?;
        let mut model = self.with_coefficients(|bearing| bearing.at(speed).map(BearingCoefficient::Constant));
        model.circulation = model.circulates().then_some(speed);
        Ok(model)
    }

    /// The model whose bearings with tables over the frequency have the coefficients of one frequency, rad/s, which may depend on
    /// the speed.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the table, the frequency and the range of the table.
    pub fn at_frequency(&self, frequency: f64) -> Result<Self, SceneError> {
        self.bearings.iter().try_for_each(|bearing| bearing.check_frequency(frequency))?;
        Ok(self.with_coefficients(|SpeedDependentBearing { bearing, .. }| {
            [&bearing.stiffness, &bearing.damping].map(|coefficient| coefficient.at_frequency(frequency))
        }))
    }

    /// The model whose bearings with tables have other coefficients: stiffness and damping.
    fn with_coefficients(&self, of: impl Fn(&SpeedDependentBearing) -> [BearingCoefficient; 2]) -> Self {
        let mut model = self.clone();
        for bearing in &self.bearings {
            let given = &mut model.scene.bearings[bearing.number];
            [given.stiffness, given.damping] = of(bearing);
        }
        (model.supports, model.bearings) = bearings(&model.scene, &model.numbering, self.nonlinear_bearings.len());
        model.links = links(&model.scene, &model.numbering);
        model.add_operating_points();
        model
    }

    /// Frequencies at the knots of the tables of all bearings, rad/s, ascending; none without tables over the frequency.
    pub fn table_frequencies(&self) -> Vec<f64> {
        let mut found: Vec<f64> = self.bearings.iter().flat_map(SpeedDependentBearing::frequencies).collect();
        found.sort_by(f64::total_cmp);
        found.dedup();
        found
    }

    /// Whether stiffness or damping of a bearing depend on the frequency of the vibration.
    pub fn depends_on_frequency(&self) -> bool {
        self.bearings.iter().any(|bearing| bearing.frequencies().next().is_some())
    }

    /// Lowest frequency that the tables of all bearings contain, rad/s; zero without tables over the frequency.
    pub fn lowest_frequency(&self) -> f64 {
        let first = self.bearings.iter().filter_map(|bearing| bearing.frequencies().min_by(f64::total_cmp));
        first.reduce(f64::max).unwrap_or(0.0)
    }

    /// Lowest speed of the reference shaft that the tables of all bearings contain, rad/s; none without tables.
    pub fn lowest_speed(&self) -> Option<f64> {
        let first = self.bearings.iter().filter_map(|bearing| bearing.knots().min_by(f64::total_cmp));
        first.reduce(f64::max)
    }

    /// Whether stiffness or damping depend on the speed: those of bearings, or the slope of a torque over the speed.
    pub fn depends_on_speed(&self) -> bool {
        self.needs_speed() || self.has_torques_over_speed()
    }

    fn has_torques_over_speed(&self) -> bool {
        self.loads.iter().any(|load| matches!(load.law, LoadLaw::SpeedTorque { .. }))
    }

    /// Torques over the speed, N m, and centrifugal forces on planets, N, at a speed of the reference shaft, rad/s, n entries.
    pub fn speed_loads(&self, speed: f64) -> DVector<f64> {
        let mut loads = DVector::zeros(self.len());
        for load in &self.loads {
            load.rows[0].iter().for_each(|(index, factor)| loads[*index] += factor * load.constant(speed));
        }
        self.add_centrifugal_forces(speed, &mut loads);
        loads
    }

    /// The bearings at a node whose coefficients depend on the speed.
    pub fn bearings_at(&self, node: Node) -> impl Iterator<Item = &SpeedDependentBearing> {
        self.bearings.iter().filter(move |bearing| bearing.bearing.node == node)
    }
}
