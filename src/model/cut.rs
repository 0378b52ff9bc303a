//! Section forces of a shaft at one place, from the motion of its element ([`ElementCut`]).
//!
//! The forces of an element are M a + C v + K(q − b): inertia, Rayleigh damping, gyroscopic forces, stiffness with the stress-free
//! shape b, internal damping, loss factor and axial force. The weight of the shaft acts as an acceleration −g. Modal damping acts
//! from outside on all coordinates and is no part of them.

use num_complex::Complex64;

use super::place::{Within, element_at};
use super::{Model, StructuralDamping};
use crate::connection::{Row, TurningBow};
use crate::element::{BendingFunction, ElementCut, RodCut, Section, rod_degrees};
use crate::scene::{Element, EntryPath, Material, SceneError};

/// Number of section forces: N, Q_y, Q_z, M_y, M_z and T.
pub const SECTION_FORCES: usize = 6;
/// Indices of N, of (Q_y, Q_z), (M_y, M_z) and T among them.
const AXIAL: usize = 0;
const SHEAR: usize = 1;
const MOMENT: usize = 3;
const TORQUE: usize = 5;

/// A sum of displacements, velocities and accelerations with a factor each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Combination {
    /// Entries over the displacements.
    pub displacement: Row,
    /// Entries over the velocities.
    pub velocity: Row,
    /// Entries over the accelerations.
    pub acceleration: Row,
}

/// A cut through a shaft.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// Index of the shaft.
    pub shaft: usize,
    /// Position on the shaft, m.
    pub position: f64,
    /// Whether it lies just beyond a node, where forces of the node have acted; otherwise just before it or between nodes.
    pub is_beyond: bool,
    /// Stresses per unit of force.
    pub stress: StressFactors,
    /// Section forces of a shaft that does not turn, N and N m, and what its turning adds per unit spin.
    standing: [Combination; SECTION_FORCES],
    turning: [Combination; SECTION_FORCES],
    /// Elastic forces times the loss factor, over the displacements.
    lossy: [Row; SECTION_FORCES],
    /// Forces of the weight, and the given axial force, N and N m.
    constant: [f64; SECTION_FORCES],
    /// Elastic shear force, N, and moment conjugate to φ, N m, of the stress-free shape at shaft angle zero.
    bow: [Complex64; 2],
    /// Speed of the shaft relative to the reference shaft.
    ratio: f64,
}

/// Stresses at the outer radius of the shaft itself. Sleeves carry their share of the forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressFactors {
    /// Outer radius, m.
    pub radius: f64,
    /// Axial stress per axial force, 1/m².
    pub axial: f64,
    /// Bending stress per bending moment, 1/m³.
    pub bending: f64,
    /// Shear stress per torque, 1/m³.
    pub torsion: f64,
}

/// A motion at one instant, in the order of the core.
#[derive(Clone, Copy, Debug)]
pub struct Moving<'a> {
    /// Displacements, n entries, m and rad.
    pub displacement: &'a [f64],
    /// Velocities, n entries, m/s and rad/s.
    pub velocity: &'a [f64],
    /// Accelerations, n entries, m/s² and rad/s².
    pub acceleration: &'a [f64],
}

/// Rotation of a shaft at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turning {
    /// Spin, rad/s.
    pub spin: f64,
    /// Phasor of the rotation of the bow; zero if the motion does not contain the bow.
    pub bow: Complex64,
}

/// A harmonic motion.
#[derive(Clone, Copy, Debug)]
pub struct Oscillating<'a> {
    /// Phasors of the displacements, n entries in the order of the core.
    pub phasors: &'a [Complex64],
    /// Frequency, and speed of the reference shaft, rad/s.
    pub at: StructuralDamping,
    /// Whether the motion contains the bow of the shaft of the cut.
    pub is_bowed: bool,
}

impl Model {
    /// The cuts at a position of a shaft, m: one between nodes, two at a node, one at an end. The entry `at` contains the position.
    ///
    /// # Errors
    /// [`SceneError`] if the position is beyond the shaft.
    pub(crate) fn cuts(&self, shaft: usize, position: f64, at: &EntryPath<'_>) -> Result<Vec<Cut>, SceneError> {
        let given = &self.scene.shafts[shaft];
        let Some(node) = given.node_at(position) else {
            return Ok(vec![self.cut(shaft, &element_at(given, position, at)?, position, false)]);
        };
        let before = node.checked_sub(1).map(|element| (Within { element, xi: 1.0 }, false));
        let beyond = (node < given.elements.len()).then_some((Within { element: node, xi: 0.0 }, true));
        let sides = before.into_iter().chain(beyond);
        Ok(sides.map(|(within, is_beyond)| self.cut(shaft, &within, given.nodes[node], is_beyond)).collect())
    }

    fn cut(&self, index: usize, within: &Within, position: f64, is_beyond: bool) -> Cut {
        let shaft = &self.scene.shafts[index];
        let element = &shaft.elements[within.element];
        let rows = ElementCut::new(element, shaft.shear, shaft.degree, within.xi);
        let mut cut = Cut {
            shaft: index,
            position,
            is_beyond,
            stress: StressFactors::new(element, within.xi),
            standing: Default::default(),
            turning: Default::default(),
            lossy: Default::default(),
            constant: [0.0; SECTION_FORCES],
            bow: [Complex64::ZERO; 2],
            ratio: self.shafts[index].ratio,
        };
        self.add_bending(&mut cut, within, &rows);
        let rods =
            [(AXIAL, self.numbering.axial(index), &rows.axial), (TORQUE, self.numbering.torsion(index), &rows.torsion)];
        for (force, start, rows) in rods {
            if let Some(start) = start {
                self.add_rod(&mut cut, within, force, (start, rows));
            }
        }
        cut.constant[AXIAL] = element.axial_force;
        cut
    }

    /// Adds shear force and bending moment.
    fn add_bending(&self, cut: &mut Cut, within: &Within, rows: &ElementCut) {
        let (shaft, Some(start)) = (&self.scene.shafts[cut.shaft], self.numbering.lateral(cut.shaft)) else { return };
        let ([alpha, beta], axial_force) = (self.scene.rayleigh, shaft.elements[within.element].axial_force);
        let viscous = beta + shaft.internal_damping;
        let per_element = BendingFunction::all(shaft.degree, shaft.shear).len();
        let first = start + 4 * shaft.nodes.len() + 2 * per_element * within.element;
        let nodal = (0..4).map(|i| start + 4 * within.element + 2 * i);
        // Indices of the real parts; the imaginary parts have the next ones.
        let coordinates: Vec<usize> = nodal.chain((0..per_element).map(|i| first + 2 * i)).collect();
        let bow = self.shafts[cut.shaft].bow.as_ref();
        let shape = |index: &usize| bow.map_or(Complex64::ZERO, |bow| bow[(index - start) / 2]);
        let [y, z] = self.scene.gravity;
        let bending = &rows.bending;
        for (moment, first) in [(false, SHEAR), (true, MOMENT)] {
            let row = |rows: &crate::element::ForceRows| if moment { rows.moment.clone() } else { rows.shear.clone() };
            let (inertia, elastic) = (row(&bending.inertia), row(&bending.stiffness));
            let (gyroscopic, geometric) = (row(&bending.gyroscopic), row(&bending.geometric));
            let weighted = |factor: f64, row: &[f64]| row.iter().map(|value| factor * value).collect::<Vec<_>>();
            let plus = |a: Vec<f64>, b: Vec<f64>| a.into_iter().zip(b).map(|(a, b)| a + b).collect::<Vec<_>>();
            let parts = Parts {
                stiffness: plus(elastic.clone(), weighted(axial_force, &geometric)),
                damping: plus(weighted(alpha, &inertia), weighted(viscous, &elastic)),
                circulatory: weighted(shaft.internal_damping, &elastic),
                lossy: weighted(shaft.loss_factor, &elastic),
                inertia,
                gyroscopic,
            };
            // The moment is conjugate to φ = Γ − iB: its parts are M_z and −M_y.
            let lanes =
                if moment { [(first + 1, 0, 1.0), (first, 1, -1.0)] } else { [(first, 0, 1.0), (first + 1, 1, 1.0)] };
            for (force, lane, sign) in lanes {
                // −iΩ times (a + ib) is Ω(b − ia).
                let other = if lane == 0 { sign } else { -sign };
                let entries = |row: &[f64], lane: usize, sign: f64| -> Row {
                    let own = coordinates.iter().zip(row).filter(|(_, value)| **value != 0.0);
                    own.map(|(index, value)| (index + lane, sign * value)).collect()
                };
                cut.standing[force] = Combination {
                    displacement: entries(&parts.stiffness, lane, sign),
                    velocity: entries(&parts.damping, lane, sign),
                    acceleration: entries(&parts.inertia, lane, sign),
                };
                cut.turning[force] = Combination {
                    displacement: entries(&parts.circulatory, 1 - lane, other),
                    velocity: entries(&parts.gyroscopic, 1 - lane, other),
                    acceleration: Row::new(),
                };
                cut.lossy[force] = entries(&parts.lossy, lane, sign);
                // (1, 0, 1, 0, 0 …) is a translation.
                cut.constant[force] = -sign * [y, z][lane] * (parts.inertia[0] + parts.inertia[2]);
            }
            cut.bow[usize::from(moment)] =
                coordinates.iter().zip(&elastic).map(|(index, value)| shape(index) * *value).sum();
        }
    }

    /// Adds the force of a rod, whose coordinates begin at an index.
    fn add_rod(&self, cut: &mut Cut, within: &Within, force: usize, (start, rows): (usize, &RodCut)) {
        let (shaft, [alpha, beta]) = (&self.scene.shafts[cut.shaft], self.scene.rayleigh);
        let per_element = rod_degrees(shaft.degree).count();
        let first = start + shaft.nodes.len() + per_element * within.element;
        let nodal = start + within.element;
        let coordinates: Vec<usize> = (nodal..nodal + 2).chain(first..first + per_element).collect();
        let entries = |row: &[f64], factor: f64| -> Row {
            let own = coordinates.iter().zip(row).filter(|(_, value)| factor * **value != 0.0);
            own.map(|(index, value)| (*index, factor * value)).collect()
        };
        let viscous = entries(&rows.stiffness, beta + shaft.internal_damping);
        cut.standing[force] = Combination {
            displacement: entries(&rows.stiffness, 1.0),
            velocity: entries(&rows.inertia, alpha).into_iter().chain(viscous).collect(),
            acceleration: entries(&rows.inertia, 1.0),
        };
        cut.lossy[force] = entries(&rows.stiffness, shaft.loss_factor);
    }

    /// The bow of a shaft that turns with the twist of the shaft, if the scene contains its torque.
    pub fn turning_bow(&self, shaft: usize) -> Option<&TurningBow> {
        self.bows.iter().find(|bow| bow.shaft == shaft)
    }
}

/// Rows of shear force or moment over the coordinates of an element, with the coefficients of the shaft.
struct Parts {
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    circulatory: Vec<f64>,
    lossy: Vec<f64>,
    inertia: Vec<f64>,
    gyroscopic: Vec<f64>,
}

impl StressFactors {
    fn new(element: &Element, xi: f64) -> Self {
        let section = Section::at(element, false, xi);
        let ([radius, _], Material { youngs_modulus, shear_modulus, .. }) =
            (element.body.radii(xi), element.body.material);
        Self {
            radius,
            axial: youngs_modulus / section.axial,
            bending: youngs_modulus * radius / section.flexural,
            torsion: shear_modulus * radius / section.torsional,
        }
    }
}

impl Combination {
    /// This one plus a multiple of another.
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let sum = |own: &Row, other: &Row| {
            let scaled = other.iter().map(|(index, value)| (*index, factor * value));
            own.iter().copied().chain(scaled).collect()
        };
        Self {
            displacement: sum(&self.displacement, &other.displacement),
            velocity: sum(&self.velocity, &other.velocity),
            acceleration: sum(&self.acceleration, &other.acceleration),
        }
    }

    /// Its value in a motion.
    pub fn value(&self, motion: &Moving<'_>) -> f64 {
        let product = |row: &Row, of: &[f64]| row.iter().map(|(index, factor)| factor * of[*index]).sum::<f64>();
        product(&self.displacement, motion.displacement)
            + product(&self.velocity, motion.velocity)
            + product(&self.acceleration, motion.acceleration)
    }

    /// Indices of all coordinates.
    fn coordinates(&self) -> impl Iterator<Item = usize> + '_ {
        let rows = [&self.displacement, &self.velocity, &self.acceleration];
        rows.into_iter().flatten().map(|(index, _)| *index)
    }
}

impl Cut {
    /// Indices of the coordinates from which the forces follow.
    pub fn coordinates(&self) -> impl Iterator<Item = usize> + '_ {
        self.standing.iter().chain(&self.turning).flat_map(Combination::coordinates)
    }

    /// The section forces without constant parts and bow at a spin, rad/s, as combinations; without a spin those of a shaft that
    /// does not turn, then what a unit spin adds to shear forces and moments.
    pub fn combinations(&self, spin: Option<f64>) -> Vec<Combination> {
        let Some(spin) = spin else {
            return self.standing.iter().chain(&self.turning[SHEAR..TORQUE]).cloned().collect();
        };
        self.standing.iter().zip(&self.turning).map(|(standing, turning)| standing.plus(spin, turning)).collect()
    }

    /// The section forces from the values of all [combinations](Self::combinations).
    pub fn combined(&self, values: &[f64], turning: Turning) -> [f64; SECTION_FORCES] {
        let turned = |force: usize| {
            let value = force.checked_sub(SHEAR).and_then(|index| values.get(SECTION_FORCES + index));
            value.map_or(0.0, |value| turning.spin * value)
        };
        self.with_constants(std::array::from_fn(|force| values[force] + turned(force)), turning)
    }

    /// N, Q_y and Q_z, N, M_y, M_z and T, N m, of a motion; zero for motions that the model does not have.
    pub fn forces(&self, motion: &Moving<'_>, turning: Turning) -> [f64; SECTION_FORCES] {
        let value = |force: usize| {
            let turned = if turning.spin == 0.0 { 0.0 } else { turning.spin * self.turning[force].value(motion) };
            self.standing[force].value(motion) + turned
        };
        self.with_constants(std::array::from_fn(value), turning)
    }

    /// The section forces with those that are constant in the frame of the ground or of the shaft.
    fn with_constants(&self, values: [f64; SECTION_FORCES], turning: Turning) -> [f64; SECTION_FORCES] {
        let [shear, moment] = self.bow.map(|force| force * turning.bow);
        let bow = [0.0, shear.re, shear.im, -moment.im, moment.re, 0.0];
        std::array::from_fn(|force| values[force] + self.constant[force] - bow[force])
    }

    /// Phasors of the section forces in a harmonic motion, without those that stand still.
    pub fn oscillating(&self, motion: &Oscillating<'_>) -> [Complex64; SECTION_FORCES] {
        let rate = Complex64::new(0.0, motion.at.frequency);
        let product =
            |row: &Row| -> Complex64 { row.iter().map(|(index, factor)| motion.phasors[*index] * *factor).sum() };
        let spin = self.ratio * motion.at.speed;
        let value = |combination: &Combination| {
            product(&combination.displacement)
                + product(&combination.velocity) * rate
                + product(&combination.acceleration) * rate * rate
        };
        let mut forces: [Complex64; SECTION_FORCES] =
            std::array::from_fn(|force| value(&self.standing[force]) + value(&self.turning[force]) * spin);
        // With v = (p + m)/2 and w = (p − m)/2i of the circular coordinates p and m, as in `structural_of_shafts`.
        let [forward, backward] = motion.at.turning(self.ratio);
        let (same, cross) = ((forward + backward) / 2.0, (forward - backward) / 2.0 * Complex64::I);
        let lossy = self.lossy.each_ref().map(product);
        for force in [AXIAL, TORQUE] {
            forces[force] += motion.at.standing() * lossy[force];
        }
        forces[SHEAR] += same * lossy[SHEAR] + cross * lossy[SHEAR + 1];
        forces[SHEAR + 1] += same * lossy[SHEAR + 1] - cross * lossy[SHEAR];
        forces[MOMENT] += same * lossy[MOMENT] + cross * lossy[MOMENT + 1];
        forces[MOMENT + 1] += same * lossy[MOMENT + 1] - cross * lossy[MOMENT];
        if motion.is_bowed {
            let [shear, moment] = self.bow;
            // The real part of b e^{iϑ} has the phasor b, the imaginary part −ib.
            let turned = [shear, -Complex64::I * shear, Complex64::I * moment, moment];
            forces[SHEAR..TORQUE].iter_mut().zip(turned).for_each(|(force, bow)| *force -= bow);
        }
        forces
    }
}
