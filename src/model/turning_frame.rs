//! Shafts whose lateral motion is described in the frame of a carrier that turns.
//!
//! With v + iw = p e^{iϑ_c} and the speed Ω_c of the carrier, M ü + (C − iΩ_s G) u̇ + K u becomes
//!
//! ```text
//! M p̈ + (C − iΩ_s G + 2iΩ_c M) ṗ + (K − Ω_c² M + Ω_c Ω_s G + iΩ_c C) p
//! ```
//!
//! M, C and K are the same in all directions. The Coriolis term belongs to the gyroscopic matrix, the other two to the terms of the
//! stiffness that depend on the speed, with the circulatory forces of internal damping.
//!
//! The static force with which a planet presses on its pin turns with the twist of the carrier. Therefore the centrifugal term of a
//! planet acts on its displacement relative to the place to which the twist moves it: a train that nothing holds can turn.

use nalgebra::DVector;
use num_complex::Complex64;

use super::free_rotation::entries;
use super::matrices::Add;
use super::{BendingChain, Model, ShaftModel, Support};
use crate::connection::Row;
use crate::linalg::CoupledChains;
use crate::scene::{Matrix2, Node};

/// A planet on pins of a carrier that turns.
#[derive(Clone, Debug)]
pub struct Planet {
    /// Index of its shaft.
    shaft: usize,
    /// Index of the twist of the carrier.
    twist: usize,
    /// Speed of the carrier over that of the reference shaft.
    ratio: f64,
    /// M φ of the motion φ of the planet per twist of the carrier, kg m.
    momentum: Row,
    /// φᵀ M φ, kg m².
    inertia: f64,
    /// Centrifugal force at the unit speed of the carrier, kg m.
    centrifugal: Row,
}

impl Planet {
    /// Adds the terms of −Ω_c² (x − φθ)ᵀ M (x − φθ) that contain the twist θ of the carrier, at a speed of the reference shaft.
    fn visit_twist(&self, speed: f64, add: Add<'_>) {
        let square = (speed * self.ratio).powi(2);
        for (index, momentum) in &self.momentum {
            add(*index, self.twist, square * momentum);
            add(self.twist, *index, square * momentum);
        }
        add(self.twist, self.twist, -square * self.inertia);
    }
}

impl ShaftModel {
    /// Speed relative to the frame of its lateral motion, over that of the reference shaft.
    pub fn ratio_in_frame(&self) -> f64 {
        self.ratio - self.frame
    }

    /// Adds the Coriolis term 2iΩ_c M per unit speed of the reference shaft.
    pub(super) fn visit_coriolis(&self, add: Add<'_>) {
        for chain in self.turning_chain() {
            chain.mass.for_each(|row, column, value| {
                let (row, column) = (chain.start + 2 * row, chain.start + 2 * column);
                add(row, column + 1, -2.0 * self.frame * value);
                add(row + 1, column, 2.0 * self.frame * value);
            });
        }
    }

    /// Adds −Ω_c² M + Ω_c Ω_s G + iΩ_c C at a speed of the reference shaft.
    fn visit_frame(&self, speed: f64, add: Add<'_>) {
        let square = speed * speed * self.frame;
        for chain in self.turning_chain() {
            let parts = [(&chain.mass, -square * self.frame), (&self.gyroscopic, square * self.ratio)];
            for (part, factor) in parts {
                part.for_each(|row, column, value| {
                    for lane in 0..2 {
                        add(chain.start + 2 * row + lane, chain.start + 2 * column + lane, factor * value);
                    }
                });
            }
            if let Some(damping) = &chain.damping {
                damping.for_each(|row, column, value| {
                    let (row, column) = (chain.start + 2 * row, chain.start + 2 * column);
                    add(row, column + 1, -speed * self.frame * value);
                    add(row + 1, column, speed * self.frame * value);
                });
            }
        }
    }

    /// The bending of a shaft whose frame turns.
    fn turning_chain(&self) -> impl Iterator<Item = &BendingChain> {
        self.bending.iter().filter(|_| self.frame != 0.0)
    }
}

impl Support {
    /// Stiffness Ω_c C J that a damper adds if it does not turn with the frame, with J u = i u, at a speed of the reference shaft;
    /// zero for another damper.
    pub(super) fn stiffness_from_frame(&self, speed: f64) -> [[f64; 2]; 2] {
        let turn = speed * self.frame;
        self.damping.map(|[along_v, along_w]| [turn * along_w, -turn * along_v])
    }
}

impl Model {
    /// Stiffness that a damper at rest adds in a frame that turns, where a constant displacement has a velocity seen from the ground.
    /// Matrix over the scalars of the element, N/m or N m/rad; zero unless the model contains the terms of a speed.
    pub fn stiffness_from_frame(&self, element: &Support) -> Matrix2 {
        let speed = self.circulation.filter(|_| element.frame != 0.0);
        speed.map_or(Matrix2::default(), |speed| element.stiffness_from_frame(speed))
    }

    /// Force of this stiffness at the scalars u, N or N m.
    pub(super) fn frame_force(&self, element: &Support, u: [f64; 2]) -> [f64; 2] {
        self.stiffness_from_frame(element).map(|row| row[0] * u[0] + row[1] * u[1])
    }

    /// Planets on pins of carriers that turn.
    pub(super) fn find_planets(&self) -> Vec<Planet> {
        let mut found: Vec<Planet> = Vec::new();
        for (bearing, carrier, [_, y, z]) in self.scene.pins() {
            let shaft = bearing.node.shaft;
            let known = found.iter().any(|planet| planet.shaft == shaft);
            let Some(twist) = self.numbering.twist(carrier).filter(|_| !known) else { continue };
            let moved = |[v, w]: [f64; 2]| {
                let mut motion = vec![0.0; self.len()];
                for node in 0..self.scene.shafts[shaft].nodes.len() {
                    if let Some(index) = self.numbering.translation(Node { shaft, node }) {
                        (motion[index], motion[index + 1]) = (v, w);
                    }
                }
                let mut momentum = vec![0.0; self.len()];
                self.multiply_mass(&motion, &mut momentum);
                let inertia = motion.iter().zip(&momentum).map(|(motion, momentum)| motion * momentum).sum();
                (entries(momentum), inertia)
            };
            let ((momentum, inertia), (centrifugal, _)) = (moved([-z, y]), moved([y, z]));
            let ratio = self.scene.speed_ratios[carrier.shaft];
            found.push(Planet { shaft, twist, ratio, momentum, inertia, centrifugal });
        }
        found
    }

    /// Adds what the frames that turn add to the stiffness at a speed of the reference shaft, rad/s.
    pub fn visit_frames(&self, speed: f64, add: Add<'_>) {
        for shaft in &self.shafts {
            shaft.visit_frame(speed, add);
        }
        self.visit_supports(|support| support.stiffness_from_frame(speed), add);
        for planet in &self.planets {
            planet.visit_twist(speed, add);
        }
    }

    /// Adds the terms between planets and the twist of their carrier, at a speed of the reference shaft, to a weighted sum.
    pub(super) fn add_planets(&self, sum: &mut CoupledChains, speed: f64, factor: Complex64) {
        for planet in &self.planets {
            planet.visit_twist(speed, &mut |row, column, value| self.add_entry(sum, row, column, factor * value));
        }
    }

    /// Adds the Coriolis terms of all shafts per unit speed of the reference shaft.
    pub fn visit_coriolis(&self, add: Add<'_>) {
        for shaft in &self.shafts {
            shaft.visit_coriolis(add);
        }
    }

    /// Centrifugal forces on the planets at a speed of the reference shaft, rad/s, n entries, N and N m.
    pub fn add_centrifugal_forces(&self, speed: f64, load: &mut DVector<f64>) {
        for planet in &self.planets {
            let square = (speed * planet.ratio).powi(2);
            planet.centrifugal.iter().for_each(|(index, force)| load[*index] += square * force);
        }
    }
}
