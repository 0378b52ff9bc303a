//! A shaft with its rigid bodies, as chains of nodes: bending, and the rods of torsion and of axial motion.
//!
//! ```text
//! M ü + (αM_s + βK_s) u̇ − iΩ_s G u̇ + K_s u = f     bending, complex: u = v + iw, φ = Γ − iB at each node
//! J θ̈ + (αJ_s + βK_θ) θ̇ + K_θ θ = f               torsion, and axial displacement with the mass instead of J
//! ```
//!
//! An axial force adds its geometric stiffness to K_s, and internal damping β adds βK_s to the damping and −iΩ_s βK_s to the
//! stiffness, because it damps the motion relative to the rotating shaft.
//! A loss factor η of the material makes K_s(1 + iη sgn(ω − Ω_s)) of the stiffness in a harmonic motion u e^{iωt}, and
//! K_θ(1 + iη sgn ω) in torsion ([`super::StructuralDamping`]).
//! M and J contain shaft and bodies; Rayleigh damping (α, β) uses the matrices M_s and J_s of the shaft without bodies.
//! The forces of bow and unbalance rotate with the shaft angle ϑ:
//!
//! ```text
//! f = [K_s b + U (Ω_s² − iΩ̇_s)] e^{iϑ},    b bow,  U = m·e unbalance
//! ```

use std::ops::Range;

use num_complex::Complex64;

use super::numbering::Numbering;
use super::{bow, mass_error};
use crate::element::{
    Beam, Bending, Elastic, InternalBeam, InternalBlocks, InternalRod, Rod, RodMatrices, Values, geometric_stiffness,
};
use crate::linalg::{BlockTridiagonal, ChainFactor, ChainMatrix, load};
use crate::scene::{Body, Element, Node, Scene, SceneError, Shaft};

/// Matrices of one chain: elements of type `E` between nodes with `B` unknowns.
#[derive(Clone, Debug)]
pub struct Chain<const B: usize, E> {
    /// Index, in the order of the core, of the first coordinate.
    pub start: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Mass matrix of shaft and bodies.
    pub mass: ChainMatrix<B>,
    /// Factors of the mass matrix.
    pub mass_factor: ChainFactor<B>,
    /// Elastic elements between the nodes.
    pub elements: Vec<E>,
    /// Assembled stiffness matrix.
    pub stiffness: ChainMatrix<B>,
    /// Stiffness between nodes that the strains of `elements` do not contain; `None` if it is zero.
    pub beyond_strains: Option<BlockTridiagonal<B>>,
    /// Rayleigh damping matrix of the shaft; `None` if it is zero.
    pub damping: Option<ChainMatrix<B>>,
}

/// Bending: unknowns (u, φ); the lanes are the real and the imaginary part.
pub type BendingChain = Chain<2, Bending>;
/// Torsion or axial motion: unknown θ or axial displacement, with one lane.
pub type RodChain = Chain<1, Rod>;

impl<const B: usize, E: Elastic<B>> Chain<B, E> {
    /// Indices of the coordinates, each unknown with `L` lanes.
    #[inline(always)]
    pub fn coordinates<const L: usize>(&self) -> Range<usize> {
        self.start..self.start + L * self.stiffness.len()
    }

    /// `force −= K q`; both vectors begin at the first coordinate of this chain.
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
        self.stiffness.internal_product::<L>(q, |unknown, values| {
            for (force, value) in force[unknown * L..].iter_mut().zip(values) {
                *force -= value;
            }
        });
        if let Some(stiffness) = &self.beyond_strains {
            stiffness.multiply_add::<L>(-1.0, q, force);
        }
    }

    /// qᵀKq, J; `q` begins at the first coordinate of this chain.
    pub fn elastic_form<const L: usize>(&self, q: &[f64]) -> f64 {
        let pair = |(node, element): (usize, &E)| element.quadratic_form::<L>(&load(q, node), &load(q, node + 1));
        let mut sum: f64 = self.elements.iter().enumerate().map(pair).sum();
        self.stiffness.internal_product::<L>(q, |unknown, values| {
            sum += values.iter().zip(&q[unknown * L..]).map(|(value, q)| value * q).sum::<f64>();
        });
        sum + self.beyond_strains.as_ref().map_or(0.0, |stiffness| stiffness.quadratic_form::<L>(q))
    }
}

/// Force that rotates with the shaft: amplitude·e^{iϑ} at the shaft angle ϑ, where amplitude =
/// bow + force + unbalance·(Ω² − iΩ̇).
#[derive(Clone, Copy, Debug)]
pub struct Excitation {
    /// Index, in the order of the core, of the real part (v or Γ); the imaginary part (w or −B) has the next index.
    pub index: usize,
    /// Force K_s b of the bow, N or N m.
    pub bow: Complex64,
    /// Given force that turns with the shaft (`gb.Force` with an order of 1), N.
    pub force: Complex64,
    /// Unbalance mass·eccentricity, kg m.
    pub unbalance: Complex64,
}

impl Excitation {
    /// Amplitude at the spin Ω, rad/s, and its rate Ω̇, rad/s², in N or N m.
    pub fn amplitude(&self, spin: f64, rate: f64) -> Complex64 {
        self.steady_amplitude() + self.unbalance_amplitude(spin, rate)
    }

    /// Part of the amplitude that does not depend on the spin, N or N m.
    pub fn steady_amplitude(&self) -> Complex64 {
        self.bow + self.force
    }

    /// Part of the amplitude that is due to unbalance, N.
    pub fn unbalance_amplitude(&self, spin: f64, rate: f64) -> Complex64 {
        self.unbalance * Complex64::new(spin * spin, -rate)
    }
}

/// Assembled shaft.
#[derive(Clone, Debug)]
pub struct ShaftModel {
    /// Speed ratio Ω_s/Ω to the reference shaft; negative for the opposite direction of rotation.
    pub ratio: f64,
    /// Speed of the frame of its lateral coordinates over that of the reference shaft.
    pub frame: f64,
    /// Bending; `None` if the scene excludes it.
    pub bending: Option<BendingChain>,
    /// Gyroscopic matrix of bending per unit spin of this shaft, kg m².
    pub gyroscopic: ChainMatrix<2>,
    /// Torsion; `None` if the scene excludes it.
    pub twist: Option<RodChain>,
    /// Axial motion; `None` if the scene excludes it.
    pub axial: Option<RodChain>,
    /// Geometric stiffness of bending by axial forces, which `bending` contains; `None` without them.
    pub geometric: Option<ChainMatrix<2>>,
    /// βK of bending with the internal damping β, N s/m: the circulatory force on u is iΩ_s βK u; `None` without it.
    pub circulatory: Option<ChainMatrix<2>>,
    /// ηK of bending with the loss factor η, N/m, without geometric stiffness; `None` without it.
    pub structural: Option<ChainMatrix<2>>,
    /// Loss factor η.
    pub loss_factor: f64,
    /// Forces of bow and unbalance.
    pub excitations: Vec<Excitation>,
    /// Stress-free shape in shaft coordinates: (u, φ) of the nodes, then the internal coordinates of bending; `None` for a
    /// straight shaft.
    pub bow: Option<Vec<Complex64>>,
}

impl ShaftModel {
    /// Assembles shaft `index` of the scene.
    ///
    /// # Errors
    /// [`SceneError`] if a node has no inertia, or the bearings do not define the sag of the bow.
    pub fn new(scene: &Scene, numbering: &Numbering, index: usize) -> Result<Self, SceneError> {
        let shaft = &scene.shafts[index];
        let nodes = shaft.nodes.len();
        let [alpha, beta] = scene.rayleigh;
        let beams: Vec<_> = shaft.elements.iter().map(|element| Beam::new(element, shaft.shear)).collect();
        let inner = InternalBeam::of_shaft(shaft);
        let mut gyroscopic = ChainMatrix::zeros(nodes);
        let (mut geometric, mut circulatory, mut structural) = (None, None, None);
        let (internal_damping, loss_factor) = (shaft.internal_damping, shaft.loss_factor);

        let bending = match numbering.lateral(index) {
            None => None,
            Some(start) => {
                let mut mass = assemble(&beams, |beam, i, j| beam.mass[(i, j)], &inner, |inner| &inner.mass);
                let mut stiffness =
                    assemble(&beams, |beam, i, j| beam.stiffness[(i, j)], &inner, |inner| &inner.stiffness);
                gyroscopic = assemble(&beams, |beam, i, j| beam.gyroscopic[(i, j)], &inner, |inner| &inner.gyroscopic);
                let damping = rayleigh(alpha, &mass, beta + internal_damping, &stiffness);
                let scaled =
                    |factor: f64| (factor > 0.0).then(|| ChainMatrix::combination(factor, &stiffness, 0.0, &stiffness));
                (circulatory, structural) = (scaled(internal_damping), scaled(loss_factor));
                for body in scene.bodies().filter(|body| body.node.shaft == index) {
                    mass.nodal.add_at_node(body.node.node, 0, 0, body.mass);
                    mass.nodal.add_at_node(body.node.node, 1, 1, body.diametral_inertia);
                    gyroscopic.nodal.add_at_node(body.node.node, 1, 1, body.polar_inertia);
                }
                let mass_factor = mass.factor().map_err(|failure| mass_error(scene, index, failure))?;
                let elements = beams.iter().map(|beam| beam.bending).collect();
                let mut beyond_strains = beyond_strains(shaft, &beams);
                geometric = self::geometric(shaft);
                if let Some(geometric) = &geometric {
                    stiffness = ChainMatrix::combination(1.0, &stiffness, 1.0, geometric);
                    let own = beyond_strains.get_or_insert_with(|| BlockTridiagonal::zeros(nodes));
                    own.add_scaled(1.0, &geometric.nodal);
                }
                Some(Chain { start, nodes, mass, mass_factor, elements, stiffness, beyond_strains, damping })
            }
        };
        let elements = ShaftElements { beams: &beams, inner: &inner };
        let rod = |motion: RodMotion, start: Option<usize>| {
            start.map(|start| rod(scene, index, start, motion, &elements)).transpose()
        };
        let twist = rod(RodMotion::Torsion, numbering.torsion(index))?;
        let axial = rod(RodMotion::Axial, numbering.axial(index))?;
        let ratio = scene.speed_ratios[index];
        let excitations = Vec::new();
        let mut shaft = Self {
            ratio,
            frame: scene.frame_ratio(index),
            bending,
            gyroscopic,
            twist,
            axial,
            geometric,
            circulatory,
            structural,
            loss_factor,
            excitations,
            bow: None,
        };
        shaft.set_bow_and_unbalance(scene, index)?;
        Ok(shaft)
    }

    /// Sets bow and unbalance to those of shaft `index` of a scene.
    ///
    /// # Errors
    /// [`SceneError`] if the bearings do not define the sag of the bow.
    pub fn set_bow_and_unbalance(&mut self, scene: &Scene, index: usize) -> Result<(), SceneError> {
        if let Some(chain) = &self.bending {
            let elastic =
                self.geometric.as_ref().map(|part| ChainMatrix::combination(1.0, &chain.stiffness, -1.0, part));
            self.bow = bow::shape(scene, index, &chain.mass, elastic.as_ref().unwrap_or(&chain.stiffness))?;
            self.excitations = excitations(scene, index, self, chain);
        }
        Ok(())
    }

    /// Chains of torsion and of axial motion.
    #[inline(always)]
    pub fn rods(&self) -> impl Iterator<Item = &RodChain> {
        self.twist.iter().chain(&self.axial)
    }

    /// `out += M x`.
    pub fn multiply_mass(&self, x: &[f64], out: &mut [f64]) {
        if let Some(chain) = &self.bending {
            chain.mass.multiply_add::<2>(1.0, &x[chain.start..], &mut out[chain.start..]);
        }
        for chain in self.rods() {
            chain.mass.multiply_add::<1>(1.0, &x[chain.start..], &mut out[chain.start..]);
        }
    }

    /// `x ← M⁻¹ x`.
    pub fn solve_mass(&self, x: &mut [f64]) {
        if let Some(chain) = &self.bending {
            chain.mass_factor.solve::<2>(&mut x[chain.start..]);
        }
        for chain in self.rods() {
            chain.mass_factor.solve::<1>(&mut x[chain.start..]);
        }
    }
}

/// Elements of a shaft, and the matrices of their internal coordinates.
struct ShaftElements<'a> {
    beams: &'a [Beam],
    inner: &'a [InternalBeam],
}

/// A motion of a shaft with one coordinate at each node.
#[derive(Clone, Copy)]
enum RodMotion {
    Torsion,
    Axial,
}

impl RodMotion {
    /// Matrices of an element.
    fn matrices(self, beam: &Beam) -> &RodMatrices {
        match self {
            Self::Torsion => &beam.torsion,
            Self::Axial => &beam.axial,
        }
    }

    /// Matrices of the internal coordinates of an element.
    fn internal(self, inner: &InternalBeam) -> &InternalRod {
        match self {
            Self::Torsion => &inner.torsion,
            Self::Axial => &inner.axial,
        }
    }

    /// Inertia of a body, kg m² or kg.
    fn inertia(self, body: &Body) -> f64 {
        match self {
            Self::Torsion => body.polar_inertia,
            Self::Axial => body.mass,
        }
    }
}

/// The chain of torsion or of axial motion of shaft `index`, whose coordinates begin at `start`.
fn rod(
    scene: &Scene,
    index: usize,
    start: usize,
    motion: RodMotion,
    elements: &ShaftElements<'_>,
) -> Result<RodChain, SceneError> {
    let ([alpha, beta], internal_damping) = (scene.rayleigh, scene.shafts[index].internal_damping);
    let ShaftElements { beams, inner } = *elements;
    let mut mass =
        assemble(beams, |beam, i, j| motion.matrices(beam).mass[(i, j)], inner, |inner| &motion.internal(inner).mass);
    let stiffness = assemble(
        beams,
        |beam, i, j| motion.matrices(beam).stiffness[(i, j)],
        inner,
        |inner| &motion.internal(inner).stiffness,
    );
    let damping = rayleigh(alpha, &mass, beta + internal_damping, &stiffness);
    for body in scene.bodies().filter(|body| body.node.shaft == index) {
        mass.nodal.add_at_node(body.node.node, 0, 0, motion.inertia(body));
    }
    let mass_factor = mass.factor().map_err(|failure| mass_error(scene, index, failure))?;
    let elements = beams.iter().map(|beam| motion.matrices(beam).rod).collect();
    let nodes = beams.len() + 1;
    Ok(Chain { start, nodes, mass, mass_factor, elements, stiffness, beyond_strains: None, damping })
}

/// Geometric stiffness of bending of a shaft; `None` without axial force.
fn geometric(shaft: &Shaft) -> Option<ChainMatrix<2>> {
    if shaft.elements.iter().all(|element| element.axial_force == 0.0) {
        return None;
    }
    let mut sum = ChainMatrix::zeros(shaft.nodes.len());
    for (node, element) in shaft.elements.iter().enumerate() {
        let (nodal, internal) = geometric_stiffness(element, shaft.shear, shaft.degree);
        sum.nodal.add_element(node, |i, j| element.axial_force * nodal[(i, j)]);
        if shaft.degree > 1 {
            sum.internal.push(internal.times(element.axial_force));
        }
    }
    Some(sum)
}

/// Stiffness of bending between nodes that the strains of the elements do not contain: that of cones.
fn beyond_strains(shaft: &Shaft, beams: &[Beam]) -> Option<BlockTridiagonal<2>> {
    let is_cone = |element: &Element| !element.body.is_cylinder();
    shaft.elements.iter().any(is_cone).then(|| {
        let mut sum = BlockTridiagonal::zeros(beams.len() + 1);
        let cones = shaft.elements.iter().zip(beams).enumerate().filter(|(_, (element, _))| is_cone(element));
        for (node, (_, beam)) in cones {
            let stiffness = beam.stiffness_beyond_strains();
            sum.add_element(node, |i, j| stiffness[(i, j)]);
        }
        sum
    })
}

/// Assembles a matrix of the elements from the entries between their nodes and those of their internal coordinates.
fn assemble<const B: usize>(
    beams: &[Beam],
    entry: impl Fn(&Beam, usize, usize) -> f64,
    inner: &[InternalBeam],
    blocks: impl Fn(&InternalBeam) -> &InternalBlocks,
) -> ChainMatrix<B> {
    let mut matrix = ChainMatrix::zeros(beams.len() + 1);
    for (node, beam) in beams.iter().enumerate() {
        matrix.nodal.add_element(node, |i, j| entry(beam, i, j));
    }
    matrix.internal = inner.iter().map(|inner| blocks(inner).clone()).collect();
    matrix
}

/// Rayleigh damping αM + βK; `None` if it is zero.
fn rayleigh<const B: usize>(
    alpha: f64,
    mass: &ChainMatrix<B>,
    beta: f64,
    stiffness: &ChainMatrix<B>,
) -> Option<ChainMatrix<B>> {
    let damping = ChainMatrix::combination(alpha, mass, beta, stiffness);
    (!damping.is_zero()).then_some(damping)
}

/// Forces of bow and unbalance, without zero entries. The force of the bow is K_s b of the free shaft: bearings, bodies
/// and meshes do not contribute.
fn excitations(scene: &Scene, index: usize, shaft: &ShaftModel, chain: &BendingChain) -> Vec<Excitation> {
    let mut force = vec![0.0; chain.coordinates::<2>().len()];
    if let Some(bow) = &shaft.bow {
        let opposite: Vec<f64> = bow.iter().flat_map(|value| [-value.re, -value.im]).collect();
        chain.subtract_elastic::<2>(&opposite, &mut force);
        if let Some(geometric) = &shaft.geometric {
            geometric.multiply_add::<2>(1.0, &opposite, &mut force);
        }
    }
    let mut unbalance = vec![Complex64::ZERO; force.len() / 2];
    for body in scene.bodies().filter(|body| body.node.shaft == index) {
        let Node { node, .. } = body.node;
        unbalance[2 * node] += body.unbalance;
    }
    let entry = |(i, unbalance): (usize, &Complex64)| Excitation {
        index: chain.start + 2 * i,
        bow: Complex64::new(force[2 * i], force[2 * i + 1]),
        force: Complex64::ZERO,
        unbalance: *unbalance,
    };
    let acts = |excitation: &Excitation| excitation.bow != Complex64::ZERO || excitation.unbalance != Complex64::ZERO;
    unbalance.iter().enumerate().map(entry).filter(acts).collect()
}
