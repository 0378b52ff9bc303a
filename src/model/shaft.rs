//! A shaft with the rigid bodies on it, as two chains of nodes: bending and twist.
//!
//! Bending is complex, u = v + iw and φ = Γ − iB at each node: M ü + (αM_s + βK_s) u̇ − iΩ_s G u̇ + K u = f. Twist is
//! J θ̈ + (αJ_s + βK_θ) θ̇ + K_θ θ = f. Damping takes the shaft's own matrices (index s), without the bodies on it.

use num_complex::Complex64;

use super::numbering::Numbering;
use super::{bow, massless};
use crate::element::{Beam, Bending, Elastic, Twist, Values};
use crate::linalg::{BlockTridiagonal, BlockTridiagonalFactor, load};
use crate::scene::{Node, Scene, SceneError};

/// The matrices of one chain, elements of kind `E` between nodes of `B` unknowns.
#[derive(Clone, Debug)]
pub struct Chain<const B: usize, E> {
    /// Index of the first coordinate.
    pub start: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Mass, with the bodies.
    pub mass: BlockTridiagonal<B>,
    /// Factor of the mass.
    pub mass_factor: BlockTridiagonalFactor<B>,
    /// The elastic elements between the nodes.
    pub elements: Vec<E>,
    /// Elastic stiffness of the shaft, assembled.
    pub stiffness: BlockTridiagonal<B>,
    /// Rayleigh damping of the shaft, where the scene has any.
    pub damping: Option<BlockTridiagonal<B>>,
}

/// Bending: nodes of (u, φ), real and imaginary part as lanes.
pub type BendingChain = Chain<2, Bending>;
/// Twist: nodes of θ, one lane.
pub type TwistChain = Chain<1, Twist>;

impl<const B: usize, E: Elastic<B>> Chain<B, E> {
    /// `force −= K q`, both of this chain alone.
    #[inline(always)]
    pub fn subtract_elastic<const L: usize>(&self, q: &[f64], force: &mut [f64]) {
        let mut first: Values<B, L> = load(q, 0);
        for (node, element) in self.elements.iter().enumerate() {
            let second: Values<B, L> = load(q, node + 1);
            let forces = element.forces(&first, &second);
            let both = forces.as_flattened().as_flattened();
            for (force, value) in force[node * B * L..(node + 2) * B * L].iter_mut().zip(both) {
                *force += value;
            }
            first = second;
        }
    }

    /// qᵀKq of this chain alone.
    pub fn elastic_form<const L: usize>(&self, q: &[f64]) -> f64 {
        let pair = |(node, element): (usize, &E)| element.form::<L>(&load(q, node), &load(q, node + 1));
        self.elements.iter().enumerate().map(pair).sum()
    }
}

/// A force that turns with the shaft: at shaft angle ϑ it is amplitude·e^{iϑ}, amplitude = bow + unbalance·(Ω² − iΩ̇).
#[derive(Clone, Copy, Debug)]
pub struct Excitation {
    /// Index of the real part (v or Γ); the imaginary part (w or −B) follows.
    pub index: usize,
    /// K_s b of the bow, N or N m.
    pub bow: Complex64,
    /// Unbalance, kg m.
    pub unbalance: Complex64,
}

impl Excitation {
    /// Amplitude at a spin Ω that changes at the rate Ω̇.
    pub fn amplitude(&self, spin: f64, rate: f64) -> Complex64 {
        self.bow + self.of_unbalance(spin, rate)
    }

    /// The part of it that unbalance has.
    pub fn of_unbalance(&self, spin: f64, rate: f64) -> Complex64 {
        self.unbalance * Complex64::new(spin * spin, -rate)
    }
}

/// An assembled shaft.
#[derive(Clone, Debug)]
pub struct ShaftModel {
    /// Signed spin over the reference shaft's.
    pub ratio: f64,
    /// Bending, where the scene has it.
    pub bending: Option<BendingChain>,
    /// Gyroscopic matrix of bending, per unit spin of this shaft.
    pub gyroscopic: BlockTridiagonal<2>,
    /// Twist, where the scene has it.
    pub twist: Option<TwistChain>,
    /// Where bow and unbalance act.
    pub excitations: Vec<Excitation>,
    /// The bow at every node: u and φ of the stress-free shape in the shaft.
    pub bow: Option<Vec<Complex64>>,
}

impl ShaftModel {
    /// Assembles shaft `index` of the scene.
    ///
    /// # Errors
    /// [`SceneError`] if a node has no inertia, or the bow's sag is not defined.
    pub fn new(scene: &Scene, numbering: &Numbering, index: usize) -> Result<Self, SceneError> {
        let shaft = &scene.shafts[index];
        let nodes = shaft.nodes.len();
        let [alpha, beta] = scene.rayleigh;
        let beams: Vec<_> =
            shaft.elements.iter().map(|element| Beam::new(element, &shaft.material, shaft.shear)).collect();
        let mut gyroscopic = BlockTridiagonal::zeros(nodes);
        let mut bow_shape = None;

        let bending = match numbering.lateral(index) {
            None => None,
            Some(start) => {
                let mut mass = BlockTridiagonal::zeros(nodes);
                let mut stiffness = BlockTridiagonal::zeros(nodes);
                for (node, beam) in beams.iter().enumerate() {
                    mass.add_element(node, |i, j| beam.mass[(i, j)]);
                    stiffness.add_element(node, |i, j| beam.stiffness[(i, j)]);
                    gyroscopic.add_element(node, |i, j| beam.gyroscopic[(i, j)]);
                }
                let damping = rayleigh(alpha, &mass, beta, &stiffness);
                for body in scene.bodies().filter(|body| body.node.shaft == index) {
                    mass.add_at_node(body.node.node, 0, 0, body.mass);
                    mass.add_at_node(body.node.node, 1, 1, body.diametral_inertia);
                    gyroscopic.add_at_node(body.node.node, 1, 1, body.polar_inertia);
                }
                bow_shape = bow::shape(scene, index, &mass, &stiffness)?;
                let mass_factor = mass.factor().map_err(|failure| massless(scene, index, failure))?;
                let elements = beams.iter().map(|beam| beam.bending).collect();
                Some(Chain { start, nodes, mass, mass_factor, elements, stiffness, damping })
            }
        };
        let twist = match numbering.torsion(index) {
            None => None,
            Some(start) => {
                let mut mass = BlockTridiagonal::zeros(nodes);
                let mut stiffness = BlockTridiagonal::zeros(nodes);
                for (node, beam) in beams.iter().enumerate() {
                    mass.add_element(node, |i, j| beam.torsional_mass[(i, j)]);
                    stiffness.add_element(node, |i, j| beam.torsional_stiffness[(i, j)]);
                }
                let damping = rayleigh(alpha, &mass, beta, &stiffness);
                for body in scene.bodies().filter(|body| body.node.shaft == index) {
                    mass.add_at_node(body.node.node, 0, 0, body.polar_inertia);
                }
                let mass_factor = mass.factor().map_err(|failure| massless(scene, index, failure))?;
                let elements = beams.iter().map(|beam| beam.twist).collect();
                Some(Chain { start, nodes, mass, mass_factor, elements, stiffness, damping })
            }
        };
        let excitations = bending.as_ref().map(|chain| excitations(scene, index, chain, bow_shape.as_deref()));
        Ok(Self {
            ratio: scene.speed_ratios[index],
            excitations: excitations.unwrap_or_default(),
            bending,
            gyroscopic,
            twist,
            bow: bow_shape,
        })
    }

    /// `out += M x`.
    pub fn multiply_mass(&self, x: &[f64], out: &mut [f64]) {
        if let Some(chain) = &self.bending {
            chain.mass.multiply_add::<2>(1.0, &x[chain.start..], &mut out[chain.start..]);
        }
        if let Some(chain) = &self.twist {
            chain.mass.multiply_add::<1>(1.0, &x[chain.start..], &mut out[chain.start..]);
        }
    }

    /// `x ← M⁻¹ x`.
    pub fn solve_mass(&self, x: &mut [f64]) {
        if let Some(chain) = &self.bending {
            chain.mass_factor.solve::<2>(&mut x[chain.start..]);
        }
        if let Some(chain) = &self.twist {
            chain.mass_factor.solve::<1>(&mut x[chain.start..]);
        }
    }
}

/// αM + βK, or nothing where both vanish.
fn rayleigh<const B: usize>(
    alpha: f64,
    mass: &BlockTridiagonal<B>,
    beta: f64,
    stiffness: &BlockTridiagonal<B>,
) -> Option<BlockTridiagonal<B>> {
    let mut damping = BlockTridiagonal::zeros(mass.nodes());
    damping.add_scaled(alpha, mass);
    damping.add_scaled(beta, stiffness);
    (!damping.is_zero()).then_some(damping)
}

/// The bow as the force K_s b that straightens the shaft (no bearing, body or mesh term enters it), and unbalance.
fn excitations(scene: &Scene, index: usize, chain: &BendingChain, bow: Option<&[Complex64]>) -> Vec<Excitation> {
    let mut force = vec![0.0; 4 * chain.nodes];
    if let Some(bow) = bow {
        let opposite: Vec<f64> = bow.iter().flat_map(|value| [-value.re, -value.im]).collect();
        chain.subtract_elastic::<2>(&opposite, &mut force);
    }
    let mut unbalance = vec![Complex64::ZERO; 2 * chain.nodes];
    for body in scene.bodies().filter(|body| body.node.shaft == index) {
        let Node { node, .. } = body.node;
        unbalance[2 * node] += body.unbalance;
    }
    let entry = |(i, unbalance): (usize, &Complex64)| Excitation {
        index: chain.start + 2 * i,
        bow: Complex64::new(force[2 * i], force[2 * i + 1]),
        unbalance: *unbalance,
    };
    let acts = |excitation: &Excitation| excitation.bow != Complex64::ZERO || excitation.unbalance != Complex64::ZERO;
    unbalance.iter().enumerate().map(entry).filter(acts).collect()
}
