//! Mass, centre of mass and moments of inertia of shafts with their sleeves, gears and disks.

use crate::element::{GAUSS_POINTS, Section};
use crate::numerics::gauss;
use crate::scene::Scene;

/// Mass, centre of mass and moments of inertia of one shaft with the parts on it.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShaftMass {
    /// Mass, kg.
    pub mass: f64,
    /// Position of the centre of mass on the shaft, m; zero without mass.
    pub centre: f64,
    /// Moment of inertia about the axis, kg m².
    pub polar: f64,
    /// Moment of inertia about a diameter through the centre of mass, kg m².
    pub diametral: f64,
}

/// Mass properties of each shaft of a scene. Unbalances and bows are left out.
pub fn mass_properties(scene: &Scene) -> Vec<ShaftMass> {
    let rule = gauss(GAUSS_POINTS);
    let of_shaft = |index: usize| {
        let shaft = &scene.shafts[index];
        // Mass, polar and diametral inertia of slices and bodies, with their positions.
        let mut parts: Vec<[f64; 4]> = Vec::new();
        for (element, x) in shaft.elements.iter().zip(&shaft.nodes) {
            for (xi, weight) in &rule {
                let (section, dx) = (Section::at(element, false, *xi), weight * element.length);
                parts.push([section.mass * dx, section.polar_mass * dx, section.rotary * dx, x + xi * element.length]);
            }
        }
        for body in scene.bodies().filter(|body| body.node.shaft == index) {
            let x = shaft.nodes[body.node.node];
            parts.push([body.mass, body.polar_inertia, body.diametral_inertia, x]);
        }
        let mass: f64 = parts.iter().map(|[mass, ..]| mass).sum();
        let moment: f64 = parts.iter().map(|[mass, _, _, x]| mass * x).sum();
        let centre = if mass > 0.0 { moment / mass } else { 0.0 };
        ShaftMass {
            mass,
            centre,
            polar: parts.iter().map(|[_, polar, ..]| polar).sum(),
            diametral: parts.iter().map(|[mass, _, own, x]| own + mass * (x - centre) * (x - centre)).sum(),
        }
    };
    (0..scene.shafts.len()).map(of_shaft).collect()
}
