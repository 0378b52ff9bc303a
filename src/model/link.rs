//! Linear springs and dampers of constant coefficients over one or two scalars of the displacements.
//!
//! A bearing between a shaft and the ground acts on v and w of a node and is a [`Support`]. Every other linear element is a
//! link: a misaligned bearing, one on a housing or between two shafts, the stiffness of a bearing along the axis and against
//! tilting, the mount of a housing, a coupling, a drive. All are part of the matrices.

use std::ops::Range;

use num_complex::Complex64;

use super::housing::{axial_row, base_of, modal_row, point_rows, slope_rows as housing_slopes};
use super::{Model, Numbering, Support};
use crate::connection::Row;
use crate::scene::description::ElasticBody;
use crate::scene::{Attachment, Bearing, Coupling, Housing, Matrix2, Node, Scene, SpringDamper};

/// A spring and damper over one or two scalars u = Wᵀq: f = K u + C u̇, which acts as −W f.
#[derive(Clone, Debug)]
pub struct Link {
    /// Path of its entry in the scene.
    pub name: String,
    /// Node of the bearing of which it is a part; `None` for another element.
    pub bearing: Option<Node>,
    /// The scalars as entries (index of a coordinate, coefficient).
    pub rows: Vec<Row>,
    /// Coefficients over the scalars, with the index 0; entries beyond the number of scalars are zero.
    pub local: Support,
    /// Scalars at which it has no force; `None` if they are zero.
    pub rest: Option<Rest>,
}

/// Coefficient of a coordinate in a row; zero for a coordinate that the model does not have.
#[inline]
pub fn coefficient(row: &Row, index: Option<usize>) -> f64 {
    row.iter().filter(|(other, _)| Some(*other) == index).map(|(_, coefficient)| coefficient).sum()
}

/// Scalars of a misaligned coupling or bearing at which it has no force: fixed + turning·e^{iϑ}, as v + iw.
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    /// Part that is fixed in the frame of the scalars, m or rad.
    pub fixed: Complex64,
    /// Part that turns with the shaft, m.
    pub turning: Complex64,
    /// Index of the shaft.
    pub shaft: usize,
}

impl Link {
    /// An element over the scalars of `rows` that is no bearing.
    pub fn new(name: String, rows: Vec<Row>, stiffness: Matrix2, damping: Matrix2) -> Self {
        Self { name, bearing: None, rows, local: Support::new(0, stiffness, damping), rest: None }
    }

    /// The same element in a frame that turns relative to its damper with a multiple `frame` of the speed of the reference shaft. Such
    /// a damper adds stiffness to that frame ([`Support::stiffness_from_frame`]).
    fn in_frame(self, frame: f64) -> Self {
        Self { local: self.local.in_frame(frame), ..self }
    }

    /// The same element with a loss factor of its stiffness.
    fn with_loss_factor(self, loss_factor: f64) -> Self {
        Self { local: self.local.with_loss_factor(loss_factor), ..self }
    }

    /// The scalars u for displacements q, or u̇ for velocities; zero beyond their number.
    #[inline]
    pub fn scalars(&self, q: &[f64]) -> [f64; 2] {
        let mut scalars = [0.0; 2];
        for (scalar, row) in scalars.iter_mut().zip(&self.rows) {
            *scalar = row.iter().map(|(index, coefficient)| coefficient * q[*index]).sum();
        }
        scalars
    }

    /// Force K u + C u̇ over the scalars, N or N m.
    #[inline]
    pub fn force(&self, q: &[f64], v: &[f64]) -> [f64; 2] {
        self.local.force(&self.scalars(q), &self.scalars(v))
    }

    /// Subtracts a force over the scalars from the generalised forces.
    #[inline]
    pub fn subtract(&self, force: [f64; 2], out: &mut [f64]) {
        for (row, force) in self.rows.iter().zip(force) {
            row.iter().for_each(|(index, coefficient)| out[*index] -= coefficient * force);
        }
    }

    /// Generalised forces W K u₀ of scalars u₀ = v + iw, as entries over the coordinates, N or N m.
    pub fn rest_force(&self, rest: Complex64) -> impl Iterator<Item = (usize, f64)> + '_ {
        let force = self.local.elastic_force(&[rest.re, rest.im]);
        let scaled = |(row, force): (&Row, f64)| row.iter().map(|(i, c)| (*i, force * c)).collect::<Vec<_>>();
        self.rows.iter().zip(force).flat_map(scaled)
    }

    /// ½(u − u₀)ᵀK(u − u₀) − ½uᵀKu, J, with the scalars u₀ without force at the phasor e^{iϑ} of its shaft.
    pub fn rest_energy(&self, phasor: Complex64, q: &[f64]) -> f64 {
        let Some(rest) = &self.rest else { return 0.0 };
        let (at_rest, u) = (rest.fixed + rest.turning * phasor, self.scalars(q));
        let [y, z] = self.local.elastic_force(&[at_rest.re, at_rest.im]);
        y * (at_rest.re / 2.0 - u[0]) + z * (at_rest.im / 2.0 - u[1])
    }

    /// Power, W, that turns the part of the scalars without force that rotates with its shaft, at the phasor e^{iϑ} and the
    /// spin, rad/s, of the shaft.
    pub fn rest_power(&self, phasor: Complex64, spin: f64, q: &[f64]) -> f64 {
        let Some(rest) = &self.rest else { return 0.0 };
        let (u, turning) = (self.scalars(q), rest.turning * phasor);
        let stretch = [u[0] - rest.fixed.re - turning.re, u[1] - rest.fixed.im - turning.im];
        let (force, rate) = (self.local.elastic_force(&stretch), turning * Complex64::new(0.0, spin));
        -(rate.re * force[0] + rate.im * force[1])
    }

    /// Directions in which it has stiffness, as entries over the coordinates.
    pub fn directions(&self) -> impl Iterator<Item = Row> + '_ {
        self.local.directions().map(|direction| {
            let scaled = |(row, factor): (&Row, f64)| row.iter().map(|(i, c)| (*i, factor * c)).collect::<Vec<_>>();
            self.rows.iter().zip(direction).flat_map(scaled).collect()
        })
    }

    /// The scalars of a complex vector of displacements.
    pub fn complex_scalars(&self, shape: &[Complex64]) -> [Complex64; 2] {
        let mut scalars = [Complex64::ZERO; 2];
        for (scalar, row) in scalars.iter_mut().zip(&self.rows) {
            *scalar = row.iter().map(|(index, coefficient)| shape[*index] * *coefficient).sum();
        }
        scalars
    }

    /// Norm of WᵀM⁻¹W, an upper bound of the acceleration of the scalars per unit force on them; `solve_mass` gives
    /// M⁻¹x.
    pub fn mobility(&self, len: usize, solve_mass: impl Fn(&mut [f64])) -> f64 {
        let accelerated = |row: &Row| {
            let mut column = vec![0.0; len];
            row.iter().for_each(|(index, coefficient)| column[*index] += coefficient);
            solve_mass(&mut column);
            self.scalars(&column)
        };
        self.rows.iter().map(|row| accelerated(row).iter().map(|a| a.abs()).sum()).fold(0.0, f64::max)
    }
}

impl Model {
    /// Coordinates and factors of the displacements v and w of the shaft at a node relative to what its first bearing stands
    /// on; `None` in a model without lateral motion.
    pub fn bearing_displacement(&self, node: Node) -> Option<[Row; 2]> {
        let bearing = self.scene.bearings.iter().find(|bearing| bearing.node == node)?;
        bearing_rows(&self.scene, &self.numbering, bearing)
    }

    /// Coefficients of all bearings with constant coefficients and of all links.
    pub fn local_elements(&self) -> impl Iterator<Item = &Support> {
        self.supports.iter().chain(self.links.iter().map(|link| &link.local))
    }

    /// Coordinates on which the bearings at a node act.
    pub fn bearing_coordinates(&self, node: Node) -> Vec<usize> {
        let links = self.links.iter().filter(|link| link.bearing == Some(node)).flat_map(|link| &link.rows);
        let rows = links.chain(self.bearings_at(node).flat_map(|bearing| &bearing.rows));
        let rows = rows.chain(self.nonlinear_bearings_at(node).flat_map(|bearing| &bearing.rows));
        rows.flatten().map(|(index, _)| *index).collect()
    }

    /// Index ranges, in the order of the core, of the parts that only meshes couple.
    pub fn uncoupled_parts(&self) -> Vec<Range<usize>> {
        if self.links.is_empty() {
            self.numbering.uncoupled_parts().collect()
        } else {
            std::iter::once(0..self.len()).collect()
        }
    }
}

/// The links of a scene: mounts of supports and housings, couplings, drives, bearings with constant coefficients that do not
/// stand on the ground, and the axial and tilting coefficients of all bearings.
pub(super) fn links(scene: &Scene, numbering: &Numbering) -> Vec<Link> {
    let mut links = Vec::new();
    for (index, housing) in scene.housings.iter().enumerate() {
        let node = Node { shaft: scene.shafts.len() + index, node: 0 };
        if let (Some(modes), Some(elastic)) = (numbering.modes(node), &housing.elastic) {
            springs(&housing.name, elastic, modes.start, &mut links);
        }
        if let Some(first) = numbering.translation(node) {
            mounts(scene, numbering, (housing, node), first, &mut links);
        }
    }
    for (number, coupling) in scene.couplings.iter().enumerate() {
        join(coupling, number, numbering, scene.frame_ratio(coupling.hubs[0].shaft), &mut links);
    }
    for (number, drive) in scene.drives.iter().enumerate() {
        if let Some(index) = numbering.twist(drive.node) {
            let [stiffness, damping] = [drive.stiffness, drive.damping].map(|value| [[value, 0.0], [0.0, 0.0]]);
            links.push(Link::new(format!("drives[{number}]"), vec![vec![(index, 1.0)]], stiffness, damping));
        }
    }
    for (number, bearing) in scene.bearings.iter().enumerate() {
        hold(scene, numbering, number, bearing, &mut links);
        let (Some(stiffness), Some(damping)) = (bearing.stiffness.constant(), bearing.damping.constant()) else {
            continue;
        };
        if let Some(rows) = bearing_rows(scene, numbering, bearing)
            .filter(|_| !bearing.is_plain_support() && bearing.has_constant_part())
        {
            let link = Link::new(format!("bearings[{number}]"), rows.into(), stiffness, damping);
            let link = link.with_loss_factor(bearing.loss_factor).in_frame(frame_speed_over_damper(scene, bearing));
            let rest = Rest { fixed: bearing.misalignment, turning: Complex64::ZERO, shaft: bearing.node.shaft };
            let rest = (rest.fixed != Complex64::ZERO).then_some(rest);
            links.push(Link { bearing: Some(bearing.node), rest, ..link });
        }
    }
    links
}

/// Springs and dampers of a bearing along the axis and against tilting, relative to what the bearing stands on: a support may
/// move along the axis, and a housing that rotates or another shaft moves along the axis at the place of the bearing and
/// tilts.
fn hold(scene: &Scene, numbering: &Numbering, number: usize, bearing: &Bearing, links: &mut Vec<Link>) {
    let name = format!("bearings[{number}]");
    let isotropic = |value: f64| [[value, 0.0], [0.0, value]];
    let mut push = |rows: Vec<Row>, stiffness: Matrix2, damping: Matrix2| {
        // One scalar, along the axis, has no direction that turns.
        let frame = if rows.len() > 1 { frame_speed_over_damper(scene, bearing) } else { 0.0 };
        let link = Link::new(name.clone(), rows, stiffness, damping).with_loss_factor(bearing.loss_factor);
        let link = link.in_frame(frame);
        links.push(Link { bearing: Some(bearing.node), ..link });
    };
    if numbering.displacement_along(bearing.node).is_some() && !bearing.axial.is_zero() {
        let SpringDamper { stiffness, damping } = bearing.axial;
        let along = |value: f64| [[value, 0.0], [0.0, 0.0]];
        push(vec![axial_bearing_row(scene, numbering, bearing)], along(stiffness), along(damping));
    }
    if let Some(rows) = slope_rows(scene, numbering, bearing).filter(|_| !bearing.tilting.is_zero()) {
        let SpringDamper { stiffness, damping } = bearing.tilting;
        push(rows.into(), isotropic(stiffness), isotropic(damping));
    }
}

/// Speed of the frame of a bearing relative to its damper, over that of the reference shaft: the damper of a pin turns with it.
fn frame_speed_over_damper(scene: &Scene, bearing: &Bearing) -> f64 {
    match bearing.attachment {
        Some(Attachment::Pin { .. }) => 0.0,
        _ => scene.frame_ratio(bearing.node.shaft),
    }
}

/// Axial displacement of the shaft relative to what its bearing stands on; empty without axial motion of the shaft.
pub(super) fn axial_bearing_row(scene: &Scene, numbering: &Numbering, bearing: &Bearing) -> Row {
    let Some(index) = numbering.displacement_along(bearing.node) else {
        return Row::new();
    };
    let under = match bearing.attachment {
        None => Row::new(),
        Some(Attachment::Shaft(node)) => numbering.displacement_along(node).map(|u| (u, 1.0)).into_iter().collect(),
        Some(Attachment::Pin { carrier, arm: [_, y, z] }) => {
            let along = numbering.displacement_along(carrier).map(|u| (u, 1.0));
            // The coordinates are Γ and −B.
            let tilt = numbering.translation(carrier).into_iter().flat_map(|v| [(v + 2, -y), (v + 3, -z)]);
            along.into_iter().chain(tilt).collect()
        }
        Some(Attachment::Housing { housing, point }) => {
            axial_row(scene, numbering, Node { shaft: scene.shafts.len() + housing, node: 0 }, point)
        }
    };
    std::iter::once((index, 1.0)).chain(under.into_iter().map(|(index, coefficient)| (index, -coefficient))).collect()
}

/// Slopes dv/dx and dw/dx of the shaft relative to what its bearing stands on; `None` without bending.
pub(super) fn slope_rows(scene: &Scene, numbering: &Numbering, bearing: &Bearing) -> Option<[Row; 2]> {
    let v = numbering.translation(bearing.node)?;
    // The coordinates after v and w are Γ = dv/dx and −B = dw/dx.
    let tilting = match bearing.attachment {
        Some(Attachment::Shaft(node) | Attachment::Pin { carrier: node, .. }) => {
            numbering.translation(node).map(|first| [2, 3].map(|lane| vec![(first + lane, 1.0)]))
        }
        Some(Attachment::Housing { housing, point }) => {
            housing_slopes(scene, numbering, Node { shaft: scene.shafts.len() + housing, node: 0 }, point)
        }
        None => None,
    };
    Some([0, 1].map(|lane| {
        let tilted = tilting.iter().flat_map(|rows| &rows[lane]).map(|(index, factor)| (*index, -factor));
        std::iter::once((v + 2 + lane, 1.0)).chain(tilted).collect()
    }))
}

/// Displacements (v, w) of the shaft relative to what its bearing stands on; `None` without bending.
pub fn bearing_rows(scene: &Scene, numbering: &Numbering, bearing: &Bearing) -> Option<[Row; 2]> {
    let index = numbering.translation(bearing.node)?;
    let mut rows = [vec![(index, 1.0)], vec![(index + 1, 1.0)]];
    let base = match bearing.attachment {
        None => return Some(rows),
        Some(Attachment::Shaft(node)) => {
            let first = numbering.translation(node)?;
            [vec![(first, 1.0)], vec![(first + 1, 1.0)]]
        }
        Some(Attachment::Pin { carrier, arm: [x, y, z] }) => {
            let (first, twist) = (numbering.translation(carrier)?, numbering.twist(carrier)?);
            [vec![(first, 1.0), (first + 2, x), (twist, -z)], vec![(first + 1, 1.0), (first + 3, x), (twist, y)]]
        }
        Some(Attachment::Housing { housing, point }) => {
            point_rows(scene, numbering, Node { shaft: scene.shafts.len() + housing, node: 0 }, point)?
        }
    };
    rows.iter_mut().zip(base).for_each(|(row, base)| subtract(row, base));
    Some(rows)
}

/// Springs and dampers of a coupling, over the displacements of hub a relative to hub b, whose frame turns with the ratio `frame`.
fn join(coupling: &Coupling, number: usize, numbering: &Numbering, frame: f64, links: &mut Vec<Link>) {
    let (name, [a, b]) = (format!("couplings[{number}]"), coupling.hubs);
    let isotropic = |value: f64| [[value, 0.0], [0.0, value]];
    let single = |value: f64| [[value, 0.0], [0.0, 0.0]];
    let relative = |a: usize, b: usize| vec![(a, 1.0), (b, -1.0)];
    if let (Some(v), Some(w)) = (numbering.translation(a), numbering.translation(b)) {
        let misaligned = [
            (coupling.lateral, 0, coupling.offset, coupling.runout),
            // The slopes along y and z are Γ and −B.
            (coupling.tilting, 2, coupling.angle, Complex64::ZERO),
        ];
        for (coefficients, at, fixed, turning) in misaligned {
            let [stiffness, damping] = [coefficients.stiffness, coefficients.damping].map(isotropic);
            let rows = vec![relative(v + at, w + at), relative(v + at + 1, w + at + 1)];
            let rest = Rest { fixed, turning, shaft: a.shaft };
            let rest = (fixed != Complex64::ZERO || turning != Complex64::ZERO).then_some(rest);
            let link = Link::new(name.clone(), rows, stiffness, damping).in_frame(frame);
            links.push(Link { rest, ..link });
        }
    }
    let twists = (numbering.twist(a), numbering.twist(b), coupling.torsional);
    let along = (numbering.displacement_along(a), numbering.displacement_along(b), coupling.axial);
    for (a, b, coefficients) in [twists, along] {
        if let (Some(a), Some(b)) = (a, b) {
            let [stiffness, damping] = [coefficients.stiffness, coefficients.damping].map(single);
            links.push(Link::new(name.clone(), vec![relative(a, b)], stiffness, damping));
        }
    }
}

/// Springs and dampers of the modes of an elastic housing with unit modal mass, and those between its interfaces and the ground.
/// `start` is the index of the first mode.
fn springs(name: &str, elastic: &ElasticBody, start: usize, links: &mut Vec<Link>) {
    let single = |value: f64| [[value, 0.0], [0.0, 0.0]];
    let mut push = |row: Row, stiffness: f64, damping: f64| {
        if stiffness != 0.0 || damping != 0.0 {
            let name = format!("the housing \"{name}\"");
            links.push(Link::new(name, vec![row], single(stiffness), single(damping)));
        }
    };
    for (mode, (frequency, ratio)) in elastic.frequencies.iter().zip(&elastic.damping_ratios).enumerate() {
        push(vec![(start + mode, 1.0)], frequency * frequency, 2.0 * ratio * frequency);
    }
    for interface in elastic.interfaces.values() {
        let (stiffness, damping) = (interface.stiffness.unwrap_or_default(), interface.damping.unwrap_or_default());
        for (axis, row) in interface.rows[..3].iter().enumerate() {
            push(modal_row(row, start, 1.0), stiffness[axis], damping[axis]);
        }
    }
}

/// Displacements (v, w) of a support or housing relative to what it stands on. `first` is the index of its v.
pub(super) fn mount_rows(scene: &Scene, numbering: &Numbering, housing: &Housing, first: usize) -> [Row; 2] {
    let mut rows = [vec![(first, 1.0)], vec![(first + 1, 1.0)]];
    if let Some(base) = base_of(scene, housing).and_then(|(node, point)| point_rows(scene, numbering, node, point)) {
        rows.iter_mut().zip(base).for_each(|(row, base)| subtract(row, base));
    }
    rows
}

/// Subtracts the entries of another row.
fn subtract(row: &mut Row, other: Row) {
    row.extend(other.into_iter().map(|(index, coefficient)| (index, -coefficient)));
}

/// Springs and dampers between a support or housing at a node and what it stands on. `first` is the index of v.
fn mounts(
    scene: &Scene,
    numbering: &Numbering,
    (housing, node): (&Housing, Node),
    first: usize,
    links: &mut Vec<Link>,
) {
    let single = |value: f64| [[value, 0.0], [0.0, 0.0]];
    let rows = mount_rows(scene, numbering, housing, first).into();
    let name = format!("the mount of \"{}\"", housing.name);
    let mut push = |rows: Vec<Row>, stiffness: Matrix2, damping: Matrix2| {
        links.push(Link::new(name.clone(), rows, stiffness, damping).with_loss_factor(housing.loss_factor));
    };
    push(rows, housing.stiffness, housing.damping);
    if housing.inertia.is_some() {
        // The description lists the rotations about x, y and z. The coordinates of the core have another order: −B (minus
        // the rotation about y), Γ (about z) and θ (about x).
        for (axis, index) in [(0, first + 4), (1, first + 3), (2, first + 2)] {
            let (k, c) = (housing.rotational_stiffness[axis], housing.rotational_damping[axis]);
            push(vec![vec![(index, 1.0)]], single(k), single(c));
        }
    }
    if let Some((index, [k, c])) = numbering.displacement_along(node).zip(housing.axial) {
        let mut row = vec![(index, 1.0)];
        if let Some((base, point)) = base_of(scene, housing) {
            subtract(&mut row, axial_row(scene, numbering, base, point));
        }
        push(vec![row], single(k), single(c));
    }
}
