//! Checks shafts and their materials, and divides them into nodes and elements.

use std::f64::consts::PI;

use super::description::{self, STEEL, SceneDescription, SleeveStiffness, SleeveStiffnessWord};
use super::place::Names;
use super::{Bow, EntryPath, MAX_ELEMENTS, SceneError, given};
use crate::numerics::EQUALITY_TOLERANCE;

/// Largest degree of an element.
pub const MAX_DEGREE: usize = 8;

/// A checked isotropic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus E, Pa.
    pub youngs_modulus: f64,
    /// Shear modulus G, Pa.
    pub shear_modulus: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Density ρ, kg/m³.
    pub density: f64,
}

impl Material {
    pub(super) fn new(given: &description::Material, at: &EntryPath) -> Result<Self, SceneError> {
        let youngs_modulus = at.field("youngs_modulus").positive(given.youngs_modulus)?;
        let density = at.field("density").positive(given.density)?;
        let (shear_modulus, poisson_ratio) = match (given.shear_modulus, given.poisson_ratio) {
            (None, Some(nu)) => (youngs_modulus / (2.0 * (1.0 + nu)), nu),
            (Some(g), None) => {
                let g = at.field("shear_modulus").positive(g)?;
                (g, youngs_modulus / (2.0 * g) - 1.0)
            }
            _ => return Err(at.error("needs one of poisson_ratio and shear_modulus")),
        };
        if !(-1.0 < poisson_ratio && poisson_ratio <= 0.5) {
            return Err(at
                .field("poisson_ratio")
                .error(format!("must lie above -1 and up to 0.5, got {poisson_ratio}")));
        }
        Ok(Self { youngs_modulus, shear_modulus, poisson_ratio, density })
    }
}

/// A tube of one material, cylindrical or conical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tube {
    /// Outer radius at its begin and at its end, m.
    pub outer_radius: [f64; 2],
    /// Inner radius at its begin and at its end, m.
    pub inner_radius: [f64; 2],
    /// Material.
    pub material: Material,
    /// Fraction of its stiffness that acts: 1 for a part of a shaft.
    pub stiffness_fraction: f64,
}

/// A part of a shaft between two nodes, with the sleeves around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Length l, m.
    pub length: f64,
    /// The shaft itself.
    pub body: Tube,
    /// Sleeves around it, which are as long as the element.
    pub sleeves: Vec<Tube>,
    /// Axial force, N, positive for tension.
    pub axial_force: f64,
}

impl Tube {
    /// A cylinder.
    pub fn cylinder(outer_radius: f64, inner_radius: f64, material: Material) -> Self {
        Self { outer_radius: [outer_radius; 2], inner_radius: [inner_radius; 2], material, stiffness_fraction: 1.0 }
    }

    /// Outer and inner radius at ξ = x/l, m.
    pub fn radii(&self, xi: f64) -> [f64; 2] {
        [self.outer_radius, self.inner_radius].map(|[begin, end]| begin + xi * (end - begin))
    }

    /// Whether both ends have the same radii.
    pub fn is_cylinder(&self) -> bool {
        self.outer_radius[0] == self.outer_radius[1] && self.inner_radius[0] == self.inner_radius[1]
    }

    /// The part between two values of ξ.
    fn between(&self, begin: f64, end: f64) -> Self {
        if self.is_cylinder() {
            return *self;
        }
        let [[outer, inner], [outer_end, inner_end]] = [self.radii(begin), self.radii(end)];
        Self { outer_radius: [outer, outer_end], inner_radius: [inner, inner_end], ..*self }
    }

    /// Mass of a length, kg.
    fn mass(&self, length: f64) -> f64 {
        let square = |[a, b]: [f64; 2]| if a == b { a * a } else { (a * a + a * b + b * b) / 3.0 };
        self.material.density * PI * (square(self.outer_radius) - square(self.inner_radius)) * length
    }
}

impl Element {
    /// A cylinder without sleeves.
    pub fn cylinder(length: f64, outer_radius: f64, inner_radius: f64, material: Material) -> Self {
        let body = Tube::cylinder(outer_radius, inner_radius, material);
        Self { length, body, sleeves: Vec::new(), axial_force: 0.0 }
    }

    /// Larger outer radius of both ends of the shaft, m.
    pub fn outer_radius(&self) -> f64 {
        self.body.outer_radius[0].max(self.body.outer_radius[1])
    }

    /// The tubes that it consists of.
    pub fn tubes(&self) -> impl Iterator<Item = &Tube> {
        std::iter::once(&self.body).chain(&self.sleeves)
    }

    /// EA, N, EI and GJ, N m², in the middle.
    pub(super) fn rigidities(&self) -> [f64; 3] {
        self.tubes().fold([0.0; 3], |[axial, bending, torsion], tube| {
            let [outer, inner] = tube.radii(0.5);
            let area = tube.stiffness_fraction * PI * (outer * outer - inner * inner);
            let inertia = area * (outer * outer + inner * inner) / 4.0;
            let Material { youngs_modulus, shear_modulus, .. } = tube.material;
            [axial + youngs_modulus * area, bending + youngs_modulus * inertia, torsion + 2.0 * shear_modulus * inertia]
        })
    }

    /// Mass with sleeves, kg.
    pub fn mass(&self) -> f64 {
        self.tubes().map(|tube| tube.mass(self.length)).sum()
    }
}

/// A checked shaft.
#[derive(Clone, Debug)]
pub struct Shaft {
    /// Name.
    pub name: String,
    /// Positions of the nodes, ascending from 0, m.
    pub nodes: Vec<f64>,
    /// Elements between successive nodes.
    pub elements: Vec<Element>,
    /// Whether shear deformation is modelled.
    pub shear: bool,
    /// Degree p of the elements.
    pub degree: usize,
    /// Internal damping β, s.
    pub internal_damping: f64,
    /// Loss factor η.
    pub loss_factor: f64,
    /// Residual bow.
    pub bow: Option<Bow>,
    /// Speed relative to the reference shaft where the description gives it.
    pub speed_ratio: Option<f64>,
}

/// A position on a shaft that needs a node.
#[derive(Clone, Copy)]
pub(super) struct Station {
    /// Position, m.
    pub position: f64,
    /// List of the description whose entry contains the position.
    pub list: &'static str,
    /// Index of the entry in the list.
    pub index: usize,
    /// Field of the entry.
    pub field: &'static str,
}

impl Shaft {
    /// Whether the description says that the shaft does not turn, as the ring or the sun of a planetary stage.
    pub fn is_at_rest(&self) -> bool {
        self.speed_ratio == Some(0.0)
    }

    /// Length of the shaft, m.
    pub fn length(&self) -> f64 {
        self.nodes.last().copied().unwrap_or(0.0)
    }

    /// Outer radius at a node, m; at a step the larger one.
    pub fn radius_at(&self, node: usize) -> f64 {
        let around = &self.elements[node.saturating_sub(1)..(node + 1).min(self.elements.len())];
        around.iter().map(Element::outer_radius).fold(0.0, f64::max)
    }

    /// Finds the node at a position, m.
    pub fn node_at(&self, position: f64) -> Option<usize> {
        let tolerance = EQUALITY_TOLERANCE * self.length();
        self.nodes.iter().position(|x| (x - position).abs() <= tolerance)
    }

    /// Finds the node at a position, m; the error names the nearest one.
    ///
    /// # Errors
    /// [`SceneError`] at `at` if no node is there.
    pub(crate) fn require_node(&self, position: f64, at: &EntryPath) -> Result<usize, SceneError> {
        self.node_at(position).ok_or_else(|| {
            let distance = |x: &&f64| (**x - position).abs();
            let nearest = self.nodes.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let nearest = nearest.map(|x| format!("; the nearest is at {x} m")).unwrap_or_default();
            at.error(format!("shaft \"{}\" has no node at {position} m{nearest}", self.name))
        })
    }
}

/// Builds all shafts with a node at every station.
pub(super) fn build(system: &SceneDescription, stations: &[Vec<Station>]) -> Result<Vec<Shaft>, SceneError> {
    let mut elements = 0;
    let mut shafts = Vec::with_capacity(system.shafts.len());
    for (index, given) in system.shafts.iter().enumerate() {
        let at = EntryPath::entry("shafts", index);
        let segments = segments(given, &at)?;
        let degree = degree(given, &at)?;
        let count = |segment: &description::Segment| segment.elements.unwrap_or(1);
        let own = segments.iter().fold(stations[index].len(), |sum, segment| count(segment).saturating_add(sum));
        elements = own.saturating_mul(degree).saturating_add(elements);
        if elements > MAX_ELEMENTS {
            let counted = if degree > 1 { ", counted by their degree" } else { "" };
            return Err(at.error(format!(
                "the shafts up to this one have {elements} elements and positions{counted}, a system may have at most {MAX_ELEMENTS}; use fewer elements"
            )));
        }
        shafts.push(shaft(given, &segments, &stations[index], &at)?);
    }
    for (index, sleeve) in system.sleeves.iter().enumerate() {
        add_sleeve(&mut shafts, sleeve, &EntryPath::entry("sleeves", index))?;
    }
    Ok(shafts)
}

/// Adds a sleeve to the elements between its ends, which are nodes.
fn add_sleeve(shafts: &mut [Shaft], given: &description::Sleeve, at: &EntryPath) -> Result<(), SceneError> {
    let [outer, inner] = [given.outer_diameter, given.inner_diameter];
    at.field("outer_diameter").positive(outer)?;
    at.field("inner_diameter").positive(inner)?;
    if inner >= outer {
        return Err(at.field("inner_diameter").error(does_not_fit(inner, outer)));
    }
    if given.begin >= given.end {
        return Err(at.field("end").error(format!("must exceed begin, {} m, got {}", given.begin, given.end)));
    }
    let stiffness = match given.stiffness {
        None | Some(SleeveStiffness::Word(SleeveStiffnessWord::None)) => 0.0,
        Some(SleeveStiffness::Word(SleeveStiffnessWord::Full)) => 1.0,
        Some(SleeveStiffness::Fraction(fraction)) => fraction,
    };
    if !(0.0..=1.0).contains(&stiffness) {
        return Err(at.field("stiffness").error(format!(
            "must be \"none\", \"full\" or a fraction of the stiffness of the sleeve from 0 to 1, got {stiffness}"
        )));
    }
    let material = Material::new(given.material.as_ref().unwrap_or(&STEEL), &at.field("material"))?;
    let tube = Tube { stiffness_fraction: stiffness, ..Tube::cylinder(outer / 2.0, inner / 2.0, material) };
    // The place of names found the shaft, and made nodes of both ends.
    let Some(shaft) = shafts.iter_mut().find(|shaft| shaft.name == given.shaft) else { return Ok(()) };
    let [begin, end] =
        [shaft.require_node(given.begin, &at.field("begin"))?, shaft.require_node(given.end, &at.field("end"))?];
    for (element, x) in shaft.elements[begin..end].iter_mut().zip(&shaft.nodes[begin..]) {
        for (radius, place) in element.body.outer_radius.into_iter().zip([*x, x + element.length]) {
            if tube.inner_radius[0] < radius * (1.0 - EQUALITY_TOLERANCE) {
                return Err(at.field("inner_diameter").error(format!(
                    "{inner} m is less than the diameter of the shaft \"{}\" at {place} m, {} m",
                    shaft.name,
                    2.0 * radius
                )));
            }
        }
        let around = element.sleeves.iter().find(|other| {
            let [own, other] = [tube, **other].map(|tube| [tube.inner_radius[0], tube.outer_radius[0]]);
            own[0] < other[1] * (1.0 - EQUALITY_TOLERANCE) && other[0] < own[1] * (1.0 - EQUALITY_TOLERANCE)
        });
        if let Some(other) = around {
            return Err(at.field("begin").error(format!(
                "another sleeve with diameters of {} and {} m is at the same place, from {x} m on",
                2.0 * other.inner_radius[0],
                2.0 * other.outer_radius[0]
            )));
        }
        element.sleeves.push(tube);
    }
    Ok(())
}

fn does_not_fit(inner: f64, outer: f64) -> String {
    format!("{inner} m does not fit into the outer diameter of {outer} m")
}

/// The degree of the elements of a shaft.
fn degree(given: &description::Shaft, at: &EntryPath) -> Result<usize, SceneError> {
    let degree = given.degree.unwrap_or(1);
    if (1..=MAX_DEGREE).contains(&degree) {
        return Ok(degree);
    }
    Err(at.field("degree").error(format!("must be from 1 to {MAX_DEGREE}, got {degree}")))
}

/// The segments of a shaft. A uniform shaft is one segment.
fn segments(given: &description::Shaft, at: &EntryPath) -> Result<Vec<description::Segment>, SceneError> {
    let list = at.field("segments");
    let segments = match &given.segments {
        Some(segments) => {
            let uniform = given![given; length, outer_diameter, inner_diameter, elements];
            at.refuse(&uniform, "cannot be combined with segments; give it in the segments")?;
            if segments.is_empty() {
                return Err(list.error("at least one segment is needed"));
            }
            segments.clone()
        }
        None => {
            let needed =
                |value: Option<f64>, name: &str| value.ok_or_else(|| at.error(format!("needs {name}, or segments")));
            let segment = description::Segment {
                length: needed(given.length, "length")?,
                outer_diameter: needed(given.outer_diameter, "outer_diameter")?,
                inner_diameter: given.inner_diameter.unwrap_or(0.0),
                elements: given.elements,
                end_outer_diameter: None,
                end_inner_diameter: None,
                material: None,
            };
            vec![segment]
        }
    };
    for (index, segment) in segments.iter().enumerate() {
        let at = if given.segments.is_some() { list.index(index) } else { *at };
        at.field("length").positive(segment.length)?;
        at.field("outer_diameter").positive(segment.outer_diameter)?;
        at.field("inner_diameter").non_negative(segment.inner_diameter)?;
        if segment.inner_diameter >= segment.outer_diameter {
            return Err(at.field("inner_diameter").error(does_not_fit(segment.inner_diameter, segment.outer_diameter)));
        }
        let [outer, inner] = end_diameters(segment);
        at.field("end_outer_diameter").positive(outer)?;
        at.field("end_inner_diameter").non_negative(inner)?;
        if inner >= outer {
            let field = if segment.end_inner_diameter.is_some() { "end_inner_diameter" } else { "end_outer_diameter" };
            return Err(at.field(field).error(format!("{}, at the end of the segment", does_not_fit(inner, outer))));
        }
        if segment.elements == Some(0) {
            return Err(at.field("elements").error("must be at least 1, got 0"));
        }
    }
    Ok(segments)
}

/// Outer and inner diameter at the end of a segment, m.
fn end_diameters(segment: &description::Segment) -> [f64; 2] {
    let end = |given: Option<f64>, begin: f64| given.unwrap_or(begin);
    [end(segment.end_outer_diameter, segment.outer_diameter), end(segment.end_inner_diameter, segment.inner_diameter)]
}

fn shaft(
    given: &description::Shaft,
    segments: &[description::Segment],
    stations: &[Station],
    at: &EntryPath,
) -> Result<Shaft, SceneError> {
    let length: f64 = segments.iter().map(|segment| segment.length).sum();
    let tolerance = EQUALITY_TOLERANCE * length;
    let mut nodes = vec![0.0];
    let mut sections = Vec::new();
    let mut start = 0.0;
    for (index, segment) in segments.iter().enumerate() {
        let count = segment.elements.unwrap_or(1);
        for piece in 1..=count {
            nodes.push(start + segment.length * piece as f64 / count as f64);
            sections.push(index);
        }
        start += segment.length;
    }
    for Station { position, list, index, field } in stations {
        let entry = EntryPath::entry(list, *index);
        let path = entry.field(field);
        path.finite(*position)?;
        if *position < -tolerance || *position > length + tolerance {
            let millimetres = *position > 10.0 * length && position / 1e3 <= length + tolerance;
            return Err(path.error(format!(
                "{position} m is outside the shaft \"{}\", which is {length} m long; positions begin with 0 at its left end{}",
                given.name,
                if millimetres { "; is it in millimetres?" } else { "" }
            )));
        }
        let next = nodes.partition_point(|x| *x < position - tolerance);
        if (nodes[next.min(nodes.len() - 1)] - position).abs() > tolerance {
            nodes.insert(next, *position);
            sections.insert(next - 1, sections[next - 1]);
        }
    }
    let material = Material::new(given.material.as_ref().unwrap_or(&STEEL), &at.field("material"))?;
    let axial_force = at.field("axial_force").finite(given.axial_force.unwrap_or(0.0))?;
    let list = at.field("segments");
    let mut tubes = Vec::with_capacity(segments.len());
    let mut start = 0.0;
    for (index, segment) in segments.iter().enumerate() {
        let place = list.index(index);
        let own = segment.material.as_ref().map(|given| Material::new(given, &place.field("material"))).transpose()?;
        let [outer_end, inner_end] = end_diameters(segment);
        let tube = Tube {
            outer_radius: [segment.outer_diameter / 2.0, outer_end / 2.0],
            inner_radius: [segment.inner_diameter / 2.0, inner_end / 2.0],
            material: own.unwrap_or(material),
            stiffness_fraction: 1.0,
        };
        tubes.push((start, segment.length, tube));
        start += segment.length;
    }
    let element = |(span, section): (&[f64], &usize)| {
        let (start, length, tube) = &tubes[*section];
        let body = tube.between((span[0] - start) / length, (span[1] - start) / length);
        Element { length: span[1] - span[0], body, sleeves: Vec::new(), axial_force }
    };
    let bow = given.bow.as_ref().map(|bow| Bow::new(bow, length, &at.field("bow"))).transpose()?;
    Ok(Shaft {
        name: given.name.clone(),
        elements: nodes.windows(2).zip(&sections).map(element).collect(),
        nodes,
        shear: given.shear,
        degree: degree(given, at)?,
        internal_damping: at.field("internal_damping").non_negative(given.internal_damping.unwrap_or(0.0))?,
        loss_factor: at.field("loss_factor").non_negative(given.loss_factor.unwrap_or(0.0))?,
        bow,
        speed_ratio: given.speed_ratio,
    })
}

/// Checks the places and factors of notches.
///
/// # Errors
/// [`SceneError`] at the first invalid entry.
pub(super) fn check_notches(system: &SceneDescription, names: &Names, shafts: &[Shaft]) -> Result<(), SceneError> {
    for (index, notch) in system.notches.iter().enumerate() {
        let at = EntryPath::entry("notches", index);
        let shaft = &shafts[names.shaft(&notch.shaft, &at.field("shaft"))?];
        let (position, end) = (at.field("position").non_negative(notch.position)?, shaft.length());
        if position > end {
            let message = format!("lies beyond the end of shaft \"{}\" at {end} m, got {position}", shaft.name);
            return Err(at.field("position").error(message));
        }
        for (field, factor) in [("bending", notch.bending), ("torsion", notch.torsion)] {
            let factor = factor.unwrap_or(1.0);
            if at.field(field).finite(factor)? < 1.0 {
                return Err(at.field(field).error(format!("a notch factor is at least 1, got {factor}")));
            }
        }
    }
    Ok(())
}
