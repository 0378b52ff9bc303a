//! Harmonic sources of a frequency response: the force f of each in S(iω, Ω) x = f.
//!
//! A mesh or a bearing acts with (k + iωc) times a relative displacement. A transmission error e and a motion u of the ground
//! are parts of this displacement, δ − e and q − u, and give the forces (k + iωc) e and (K + iωC) u.

use std::collections::BTreeSet;

use nalgebra::DVector;
use num_complex::Complex64;

use super::ExcitationPart;
use super::synchronous::rotating_force;
use crate::connection::Row;
use crate::model::{Link, Model, PlaceRows, Support, coefficient};
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::description::{self, GroundQuantity, Place};
use crate::scene::{EntryPath, Matrix2, Node, SceneError, nearest};

/// Frequency and speed of a harmonic motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// Frequency ω, rad/s; negative for a backward rotation of a phasor.
    pub frequency: f64,
    /// Speed of the reference shaft, rad/s.
    pub speed: f64,
}

impl Harmonic {
    /// Dynamic stiffness k(1 + iη sgn ω) + iωc of a stiffness k with a loss factor η, and a damping c.
    fn stiffness(&self, stiffness: f64, loss_factor: f64, damping: f64) -> Complex64 {
        let sign = if self.frequency == 0.0 { 0.0 } else { self.frequency.signum() };
        Complex64::new(stiffness, sign * loss_factor * stiffness + self.frequency * damping)
    }
}

/// A linear element over one or two scalars of the displacements.
struct LinearElement<'m> {
    rows: Vec<Row>,
    coefficients: &'m Support,
    /// Forces of a damper that does not turn with the frame of the scalars, N/m.
    in_frame: Matrix2,
}

impl<'m> LinearElement<'m> {
    fn of_support(model: &Model, support: &'m Support) -> Self {
        let rows = vec![vec![(support.index, 1.0)], vec![(support.index + 1, 1.0)]];
        Self { rows, coefficients: support, in_frame: model.stiffness_from_frame(support) }
    }

    fn of_link(model: &Model, link: &'m Link) -> Self {
        Self { rows: link.rows.clone(), coefficients: &link.local, in_frame: model.stiffness_from_frame(&link.local) }
    }

    /// Rows of the force (K + iωC) u over the coordinates, N/m.
    fn force_rows(&self, at: Harmonic) -> [Vec<(usize, Complex64)>; 2] {
        let unit = |i: usize| std::array::from_fn(|j| if i == j { Complex64::ONE } else { Complex64::ZERO });
        let columns = [0, 1].map(|j| self.force(at, &unit(j)));
        [0, 1].map(|i| {
            let parts = self.rows.iter().zip(&columns).map(|(row, column)| scaled(row, column[i]));
            parts.flatten().collect()
        })
    }

    /// Force (K + iωC) u of scalars u.
    fn force(&self, at: Harmonic, scalars: &[Complex64; 2]) -> [Complex64; 2] {
        let Support { stiffness, damping, loss_factor, .. } = self.coefficients;
        let entry =
            |i: usize, j: usize| at.stiffness(stiffness[i][j], *loss_factor, damping[i][j]) + self.in_frame[i][j];
        [0, 1].map(|i| entry(i, 0) * scalars[0] + entry(i, 1) * scalars[1])
    }
}

/// All bearings and links of a model.
fn elements(model: &Model) -> impl Iterator<Item = LinearElement<'_>> {
    let supports = model.supports.iter().map(|support| LinearElement::of_support(model, support));
    supports.chain(model.links.iter().map(|link| LinearElement::of_link(model, link)))
}

/// A translation of the ground, with the coordinates on which it acts.
#[derive(Clone, Debug)]
pub struct GroundMotion {
    quantity: GroundQuantity,
    /// Translation of all parts of the model with the ground, n entries, m, m/s or m/s².
    translation: Vec<Complex64>,
    /// Coordinates of the places under which the ground moves; `None` for all.
    under: Option<BTreeSet<usize>>,
}

impl GroundMotion {
    /// Displacement of the ground below the scalars of an element, m.
    fn scalars(&self, frequency: f64, rows: &[Row]) -> [Complex64; 2] {
        let mut scalars = [Complex64::ZERO; 2];
        let moves =
            |row: &Row| self.under.as_ref().is_none_or(|under| row.iter().any(|(index, _)| under.contains(index)));
        if rows.iter().any(moves) {
            let rate = Complex64::new(0.0, frequency);
            let integral = match self.quantity {
                GroundQuantity::Displacement => Complex64::ONE,
                GroundQuantity::Velocity => rate.inv(),
                GroundQuantity::Acceleration => (rate * rate).inv(),
            };
            for (scalar, row) in scalars.iter_mut().zip(rows) {
                *scalar = integral * product(row, &self.translation);
            }
        }
        scalars
    }
}

/// A harmonic source.
#[derive(Clone, Debug)]
pub enum HarmonicSource {
    /// Forces and moments on coordinates, N or N m.
    Load(Vec<(usize, Complex64)>),
    /// A transmission error, m, of a mesh.
    MeshError {
        /// Index of the mesh.
        mesh: usize,
        /// Phasor of the error, m.
        error: Complex64,
    },
    /// A motion of the ground.
    Ground(GroundMotion),
    /// Bow, unbalance and turning forces of a shaft.
    Shaft {
        /// Index of the shaft.
        shaft: usize,
        /// The part of the excitation.
        part: ExcitationPart,
    },
}

impl HarmonicSource {
    /// Checks the description of a source, which the entry `at` contains.
    ///
    /// # Errors
    /// [`SceneError`] if a place, mesh or shaft does not exist, or the model lacks the motion on which the source acts.
    pub fn new(model: &Model, given: &description::Source, index: usize) -> Result<Self, SceneError> {
        let at = EntryPath::entry("source", index);
        match given {
            description::Source::Force { at: place, value, axial } => {
                let (value, axial) = (value.map(Complex64::from), Complex64::from(*axial));
                if value != [Complex64::ZERO; 2] {
                    model.scene.refuse_fixed_force(place, &at)?;
                }
                Ok(Self::Load(force(&model.place_rows(place, &at.field("at"))?, value, axial, &at)?))
            }
            description::Source::Torque { at: place, value } => {
                let rows = model.place_rows(place, &at.field("at"))?;
                let row = rows.twist.ok_or_else(|| missing(&at, "twist", "a torque"))?;
                Ok(Self::Load(scaled(&row, Complex64::from(*value))))
            }
            description::Source::MeshError { mesh, error } => {
                let [first, second] = mesh;
                let found = model.scene.mesh(first, second).ok_or_else(|| {
                    let pairs: Vec<_> = (0..model.meshes.len()).map(|mesh| model.gear_names(mesh).join("/")).collect();
                    let known = if pairs.is_empty() { "none".to_owned() } else { pairs.join(", ") };
                    at.field("at").error(format!("no mesh is called \"{first}/{second}\"; there are {known}"))
                })?;
                Ok(Self::MeshError { mesh: found, error: Complex64::from(*error) })
            }
            description::Source::Ground { quantity, value, axial, under } => {
                let (value, axial) = (value.map(Complex64::from), Complex64::from(*axial));
                if value != [Complex64::ZERO; 2] {
                    model.scene.refuse_fixed_motion(&at)?;
                }
                let translation = translation(model, value, axial, &at)?;
                let under = under.as_ref().map(|places| coordinates(model, places, &translation, &at)).transpose()?;
                Ok(Self::Ground(GroundMotion { quantity: *quantity, translation, under }))
            }
            description::Source::Shaft { shaft, excitation } => {
                let names = model.scene.shafts.iter().map(|shaft| shaft.name.as_str());
                let unknown =
                    || at.field("shaft").error(format!("no shaft is called \"{shaft}\"{}", nearest(shaft, names)));
                let shaft = model.scene.shaft(shaft).ok_or_else(unknown)?;
                Ok(Self::Shaft { shaft, part: ExcitationPart::named(excitation, &at.field("excitation"))? })
            }
        }
    }

    /// Number of integrations over time that lead from the quantity of a source to a displacement.
    pub fn integrations(&self) -> u32 {
        match self {
            Self::Ground(GroundMotion { quantity: GroundQuantity::Velocity, .. }) => 1,
            Self::Ground(GroundMotion { quantity: GroundQuantity::Acceleration, .. }) => 2,
            _ => 0,
        }
    }

    /// Phasors of the force, n entries in the order of the core, N or N m; `None` for a shaft without excitation.
    pub(super) fn force(&self, model: &Model, at: Harmonic) -> Option<DVector<Complex64>> {
        if let Self::Shaft { shaft, part } = self {
            return rotating_force(model, at, *shaft, *part);
        }
        let mut force = DVector::zeros(model.len());
        match self {
            Self::Load(entries) => entries.iter().for_each(|(index, value)| force[*index] += value),
            Self::MeshError { mesh, error } => {
                add_mesh_error(model, *mesh, at, *error, force.as_mut_slice());
            }
            Self::Ground(motion) => {
                for element in elements(model) {
                    let forces = element.force(at, &motion.scalars(at.frequency, &element.rows));
                    for (row, value) in element.rows.iter().zip(forces) {
                        row.iter().for_each(|(index, factor)| force[*index] += value * *factor);
                    }
                }
            }
            Self::Shaft { .. } => {}
        }
        Some(force)
    }

    /// Relative displacement along the line of action of a mesh that is no deflection, m.
    fn mesh_error(&self, model: &Model, index: usize, at: Harmonic) -> Complex64 {
        match self {
            Self::MeshError { mesh, error } if *mesh == index => *error,
            Self::Shaft { shaft, part: ExcitationPart::All } => {
                model.meshes[index].turning_error(model.sigma(index, at.speed), *shaft)
            }
            _ => Complex64::ZERO,
        }
    }

    /// Displacement of the ground below the scalars of an element, m.
    fn ground(&self, frequency: f64, rows: &[Row]) -> [Complex64; 2] {
        match self {
            Self::Ground(motion) => motion.scalars(frequency, rows),
            _ => [Complex64::ZERO; 2],
        }
    }
}

/// Forces of meshes and bearings in a harmonic motion.
pub struct HarmonicForces<'a> {
    /// The model at the speed of the motion.
    pub model: &'a Model,
    /// Frequency and speed.
    pub at: Harmonic,
    /// The source of the motion, if it contains a relative displacement in a mesh or a bearing.
    pub source: Option<&'a HarmonicSource>,
    /// Phasors of the displacements, n entries in the order of the core, m and rad.
    pub phasors: &'a [Complex64],
}

impl HarmonicForces<'_> {
    /// Phasors of the force of each mesh normal to the teeth, positive in compression of the drive flank, N.
    pub fn meshes(&self) -> impl Iterator<Item = Complex64> + '_ {
        (0..self.model.meshes.len()).map(|mesh| {
            let (row, stiffness) = self.normal_force(mesh);
            let error = self.source.map_or(Complex64::ZERO, |source| source.mesh_error(self.model, mesh, self.at));
            stiffness * (product(&row, self.phasors) - error)
        })
    }

    /// Phasors along (y, z) of the displacement of the shaft relative to what the bearing at a node stands on, m.
    pub fn in_bearing(&self, node: Node) -> [Complex64; 2] {
        let rows = self.model.bearing_displacement(node);
        rows.map_or([Complex64::ZERO; 2], |rows| rows.map(|row| product(&row, self.phasors)))
    }

    /// Row of the force of a mesh normal to the teeth over the phasors, N/m.
    pub(super) fn mesh_row(&self, mesh: usize) -> Vec<(usize, Complex64)> {
        let (row, stiffness) = self.normal_force(mesh);
        scaled(&row, stiffness)
    }

    /// Gradient ∂δ/∂q of a mesh at rest, and the force normal to the teeth over δ, N/m.
    fn normal_force(&self, mesh: usize) -> (Row, Complex64) {
        let (row, stiffness) = mesh_row(self.model, mesh, self.at);
        (row, stiffness / self.model.meshes[mesh].base_helix_cosine)
    }

    /// Rows of the force over (y, z) of the shaft on its bearings at a node over the phasors, N/m.
    pub(super) fn bearing_rows(&self, node: Node) -> [Vec<(usize, Complex64)>; 2] {
        let axes = self.axes(node);
        self.bearings_at(node).fold([Vec::new(), Vec::new()], |mut sum, element| {
            for (scalar, row) in element.rows.iter().zip(element.force_rows(self.at)) {
                for (sum, axis) in sum.iter_mut().zip(axes) {
                    let share = coefficient(scalar, axis);
                    sum.extend(row.iter().filter(|_| share != 0.0).map(|(index, value)| (*index, share * value)));
                }
            }
            sum
        })
    }

    /// Indices of v and w at a node; none without bending.
    fn axes(&self, node: Node) -> [Option<usize>; 2] {
        let index = self.model.numbering.translation(node);
        [index, index.map(|v| v + 1)]
    }

    /// The bearings at a node.
    fn bearings_at(&self, node: Node) -> impl Iterator<Item = LinearElement<'_>> {
        let index = self.model.numbering.translation(node);
        let supports = self.model.supports.iter().filter(move |support| Some(support.index) == index);
        let links = self.model.links.iter().filter(move |link| link.bearing == Some(node));
        let of_links = links.map(|link| LinearElement::of_link(self.model, link));
        supports.map(|support| LinearElement::of_support(self.model, support)).chain(of_links)
    }

    /// Phasors of the force over (y, z) of the shaft on its bearings at a node, N.
    pub fn bearing(&self, node: Node) -> [Complex64; 2] {
        let axes = self.axes(node);
        self.bearings_at(node).fold([Complex64::ZERO; 2], |mut sum, element| {
            for (row, force) in element.rows.iter().zip(self.element(&element)) {
                for (sum, axis) in sum.iter_mut().zip(axes) {
                    *sum += force * coefficient(row, axis);
                }
            }
            sum
        })
    }

    fn element(&self, element: &LinearElement<'_>) -> [Complex64; 2] {
        let ground = self.source.map(|source| source.ground(self.at.frequency, &element.rows));
        let mut scalars = ground.unwrap_or_default().map(|ground| -ground);
        for (scalar, row) in scalars.iter_mut().zip(&element.rows) {
            *scalar += product(row, self.phasors);
        }
        element.force(self.at, &scalars)
    }
}

/// Gradient ∂δ/∂q of a mesh at rest normal to the teeth, n entries, with the drive flanks of a speed, rad/s.
pub fn normal_gradient(model: &Model, mesh: usize, speed: f64) -> Vec<f64> {
    let mut gradient = vec![0.0; model.len()];
    let (row, _) = mesh_row(model, mesh, Harmonic { frequency: 0.0, speed });
    row.iter().for_each(|(index, slope)| gradient[*index] += slope * model.meshes[mesh].base_helix_cosine);
    gradient
}

/// Adds the force (k + iωc) e of a transmission error e of a mesh, m.
pub(super) fn add_mesh_error(model: &Model, mesh: usize, at: Harmonic, error: Complex64, force: &mut [Complex64]) {
    if error != Complex64::ZERO {
        let (row, stiffness) = mesh_row(model, mesh, at);
        row.iter().for_each(|(index, slope)| force[*index] += stiffness * error * *slope);
    }
}

/// Gradient ∂δ/∂q of a mesh at rest, and k + iωc, both in the transverse section.
fn mesh_row(model: &Model, mesh: usize, at: Harmonic) -> (Row, Complex64) {
    let (gear_mesh, sigma) = (&model.meshes[mesh], model.sigma(mesh, at.speed));
    let mut row = Row::new();
    gear_mesh.gradient(sigma, &gear_mesh.directions_at_rest(sigma), |index, slope| row.push((index, slope)));
    (row, at.stiffness(gear_mesh.stiffness, gear_mesh.loss_factor, gear_mesh.damping))
}

fn product(row: &Row, values: &[Complex64]) -> Complex64 {
    row.iter().map(|(index, factor)| values[*index] * *factor).sum()
}

fn scaled(row: &Row, value: Complex64) -> Vec<(usize, Complex64)> {
    row.iter().map(|(index, factor)| (*index, value * *factor)).collect()
}

/// The forces of a force with the components `value` over (y, z) and `axial` on the coordinates of its place.
fn force(
    rows: &PlaceRows,
    value: [Complex64; 2],
    axial: Complex64,
    at: &EntryPath<'_>,
) -> Result<Vec<(usize, Complex64)>, SceneError> {
    let mut entries = Vec::new();
    if value != [Complex64::ZERO; 2] {
        let across = rows.displacement.as_ref().ok_or_else(|| missing(at, "lateral motion", "a force"))?;
        across.iter().zip(value).for_each(|(row, value)| entries.extend(scaled(row, value)));
    }
    if axial != Complex64::ZERO {
        let along = rows.axial.as_ref().ok_or_else(|| missing(at, "axial motion", "an axial force"))?;
        entries.extend(scaled(along, axial));
    }
    Ok(entries)
}

fn missing(at: &EntryPath<'_>, motion: &str, what: &str) -> SceneError {
    let remedy = match motion {
        "axial motion" => "give a bearing an axial stiffness",
        _ => "use motion=\"coupled\"",
    };
    at.error(format!("{what} acts on a system without {motion} there; {remedy}"))
}

/// Translation of all parts of a model with the components `value` over (y, z) and `axial`, n entries.
fn translation(
    model: &Model,
    value: [Complex64; 2],
    axial: Complex64,
    at: &EntryPath<'_>,
) -> Result<Vec<Complex64>, SceneError> {
    let mut translation = vec![Complex64::ZERO; model.len()];
    let mut has_axial_motion = false;
    for dof in model.numbering.dofs().iter().filter(|dof| dof.degree.is_none()) {
        match dof.kind {
            crate::model::DofKind::V => translation[dof.index] = value[0],
            crate::model::DofKind::W => translation[dof.index] = value[1],
            crate::model::DofKind::Axial => {
                translation[dof.index] = axial;
                has_axial_motion = true;
            }
            _ => {}
        }
    }
    for (start, elastic) in model.elastic_housings() {
        let Some([x, y, z]) = &elastic.translation else {
            return Err(at.error(
                "the ground moves below an elastic housing that is clamped in its matrices; give free matrices, and stiffnesses of its feet",
            ));
        };
        for mode in 0..elastic.frequencies.len() {
            translation[start + mode] = axial * x[mode] + value[0] * y[mode] + value[1] * z[mode];
        }
    }
    if !model.scene.lateral {
        return Err(missing(at, "lateral motion", "a motion of the ground"));
    }
    if axial != Complex64::ZERO && !has_axial_motion {
        return Err(missing(at, "axial motion", "an axial motion of the ground"));
    }
    Ok(translation)
}

/// Coordinates of bearings, supports and housings that stand on the ground, of which the translation is given.
fn coordinates(
    model: &Model,
    places: &[Place],
    translation: &[Complex64],
    at: &EntryPath<'_>,
) -> Result<BTreeSet<usize>, SceneError> {
    let mut found = BTreeSet::new();
    let under = at.field("under");
    for (index, place) in places.iter().enumerate() {
        let entry = under.index(index);
        let rows = model.place_rows(place, &entry)?;
        let own: Vec<usize> =
            rows.displacement.iter().flatten().chain(&rows.axial).flatten().map(|(index, _)| *index).collect();
        // An element between two bodies does not stretch in a translation of both.
        let stretches = |row: &Row| {
            let parts = row.iter().map(|(index, factor)| (translation[*index] * *factor).norm()).sum::<f64>();
            product(row, translation).norm() > EQUALITY_TOLERANCE * parts
        };
        let acts = |element: LinearElement<'_>| {
            let moves = element.rows.iter().flatten().any(|(index, _)| own.contains(index));
            moves && element.rows.iter().any(stretches)
        };
        if !elements(model).any(acts) {
            return Err(entry.error("nothing there stands on the ground; name a bearing, support or housing"));
        }
        found.extend(own);
    }
    Ok(found)
}
