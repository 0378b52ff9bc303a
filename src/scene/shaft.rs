//! Checks shafts and divides them into nodes and elements.

use super::description::{self, STEEL, SceneDescription};
use super::{Bow, EntryPath, MAX_ELEMENTS, Material, SceneError};
use crate::numerics::EQUALITY_TOLERANCE;

/// Largest degree of an element.
pub const MAX_DEGREE: usize = 8;

/// A hollow circular cylinder between two nodes of a shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// Length l, m.
    pub length: f64,
    /// Outer radius, m.
    pub outer_radius: f64,
    /// Inner radius, m.
    pub inner_radius: f64,
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
    /// Material.
    pub material: Material,
    /// Whether shear deformation is modelled.
    pub shear: bool,
    /// Degree p of the elements.
    pub degree: usize,
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
    /// Length of the shaft, m.
    pub fn length(&self) -> f64 {
        self.nodes.last().copied().unwrap_or(0.0)
    }

    /// Outer radius at a node, m; at a step the larger one.
    pub fn radius_at(&self, node: usize) -> f64 {
        let around = &self.elements[node.saturating_sub(1)..(node + 1).min(self.elements.len())];
        around.iter().map(|element| element.outer_radius).fold(0.0, f64::max)
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
    Ok(shafts)
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
    let uniform = [
        ("length", given.length.is_some()),
        ("outer_diameter", given.outer_diameter.is_some()),
        ("inner_diameter", given.inner_diameter.is_some()),
        ("elements", given.elements.is_some()),
    ];
    let list = at.field("segments");
    let segments = match &given.segments {
        Some(segments) => {
            if let Some((name, _)) = uniform.iter().find(|(_, given)| *given) {
                return Err(at.field(name).error("cannot be combined with segments; give it in the segments"));
            }
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
            return Err(at.field("inner_diameter").error(format!(
                "{} m does not fit into the outer diameter of {} m",
                segment.inner_diameter, segment.outer_diameter
            )));
        }
        if segment.elements == Some(0) {
            return Err(at.field("elements").error("must be at least 1, got 0"));
        }
    }
    Ok(segments)
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
    let element = |(span, section): (&[f64], &usize)| Element {
        length: span[1] - span[0],
        outer_radius: segments[*section].outer_diameter / 2.0,
        inner_radius: segments[*section].inner_diameter / 2.0,
    };
    let bow = given.bow.as_ref().map(|bow| Bow::new(bow, length, &at.field("bow"))).transpose()?;
    Ok(Shaft {
        name: given.name.clone(),
        elements: nodes.windows(2).zip(&sections).map(element).collect(),
        nodes,
        material: Material::new(given.material.as_ref().unwrap_or(&STEEL), &at.field("material"))?,
        shear: given.shear,
        degree: degree(given, at)?,
        bow,
        speed_ratio: given.speed_ratio,
    })
}
