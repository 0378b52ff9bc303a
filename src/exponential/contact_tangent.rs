//! Correction of the stage loads by the stiffness and the damping of the contacts.
//!
//! A force f of a mesh acts on its scalars u as the load −g f. If the other loads change g·u by ℓ and g·u̇ by ℓ̇, the
//! forces of all stages and meshes follow from
//!
//! ```text
//! f = K(ℓ − G f) + C(ℓ̇ − Ġ f),
//! ```
//!
//! where −G f and −Ġ f are the changes of g·u and g·u̇ that the forces cause themselves. K and C are the stiffness and the
//! damping of the contacts beyond those that the linear motion contains.

use pulp::Arch;

use super::context::StepContext;
use super::interface_maps::LinearizedContact;
use super::nonlinear_loads::NonlinearLoads;
use super::packed::Panel;
use super::panel_kernel;
use super::small_lu::SmallLu;
use super::stages::Stages;
use crate::mesh::Contact;

/// The linear system of all stages and meshes. One unknown is the force of one mesh at one stage.
#[derive(Clone, Debug)]
pub(super) struct ContactTangentSolver {
    /// K (N/m) of all stages and meshes and, where rates matter, C (N·s/m), for which the matrix is factorised.
    pub residual_tangent: Vec<f64>,
    /// K and C that the next solution needs.
    next_tangent: Vec<f64>,
    /// Step level for which the matrix is factorised.
    level: usize,
    /// Whether the matrix is regular.
    solvable: bool,
    /// Whether K and C vanish, so that there is nothing to correct.
    idle: bool,
    system: SmallLu,
    /// Loads of all stages for a unit force: −g.
    force_loads: Panel,
    /// ℓ (m) of all stages and meshes and, where rates matter, ℓ̇ (m/s).
    deflection_change: Vec<f64>,
}

impl ContactTangentSolver {
    /// Allocates the system of a number of stages.
    pub fn new(nonlinear_loads: &NonlinearLoads<'_>, tangents: &[LinearizedContact], stages: usize) -> Self {
        let (meshes, load_count) = (nonlinear_loads.mesh_count(), nonlinear_loads.load_count());
        let (size, loads) = (stages * meshes, stages * load_count);
        let mut force_loads = vec![0.0; size * loads];
        for (unknown, column) in force_loads.chunks_exact_mut(loads.max(1)).enumerate() {
            let LinearizedContact { scalars, gradient, .. } = &tangents[unknown % meshes];
            let own = scalars.clone().map(|scalar| unknown / meshes * load_count + scalar);
            own.zip(gradient).for_each(|(at, g)| column[at] = -g);
        }
        let len = if nonlinear_loads.has_rates() { 2 * size } else { size };
        Self {
            residual_tangent: vec![f64::NAN; len],
            next_tangent: vec![0.0; len],
            level: usize::MAX,
            solvable: false,
            idle: false,
            system: SmallLu::new(size),
            force_loads: Panel::new(&force_loads, loads),
            deflection_change: vec![0.0; len],
        }
    }

    /// Takes K and C from contacts, stage after stage. The contacts of one instant apply to all stages.
    pub fn set_contacts(&mut self, nonlinear_loads: &NonlinearLoads<'_>, contacts: &[Contact]) {
        let meshes = nonlinear_loads.mesh_count();
        let (stiffness, damping) = self.next_tangent.split_at_mut(self.system.right.len());
        for (unknown, (stiffness, contact)) in stiffness.iter_mut().zip(contacts.iter().cycle()).enumerate() {
            let [k, c] = nonlinear_loads.residual_tangent(unknown % meshes, contact);
            *stiffness = k;
            if let Some(damping) = damping.get_mut(unknown) {
                *damping = c;
            }
        }
    }

    /// Takes K and C of the stages of the previous step.
    pub fn set_tangent(&mut self, previous: &[f64]) {
        self.next_tangent.copy_from_slice(previous);
    }

    /// Factorises the matrix for a step of a level, where K, C or the level have changed. `own_response` holds G and Ġ.
    /// Returns whether the matrix is regular.
    fn factorize(&mut self, level: usize, own_response: &[f64]) -> bool {
        // K and C change only if tooth pairs enter or leave contact, so that most steps reuse the factors.
        if self.level != level || self.residual_tangent != self.next_tangent {
            self.level = level;
            self.residual_tangent.copy_from_slice(&self.next_tangent);
            self.idle = self.residual_tangent.iter().all(|value| *value == 0.0);
            self.solvable = self.idle || {
                self.system.fill(own_response, &self.residual_tangent);
                self.system.factor()
            };
        }
        self.solvable
    }

    /// Solves for the forces under `deflection_change` and adds their loads −g f.
    fn add_forces(&mut self, arch: Arch, loads: &mut [f64]) {
        let size = self.system.right.len();
        self.system.right.fill(0.0);
        let factors = self.deflection_change.chunks_exact(size).zip(self.residual_tangent.chunks_exact(size));
        for (change, tangent) in factors {
            for ((force, change), tangent) in self.system.right.iter_mut().zip(change).zip(tangent) {
                *force += tangent * change;
            }
        }
        self.system.substitute();
        panel_kernel::accumulate_panel(arch, &self.force_loads, &self.system.right, loads);
    }

    /// Corrects predicted stage loads for the difference between the motion that they cause and the predicted interface
    /// states. Returns whether the correction exists. The interface states are scratch afterwards.
    pub fn predict(&mut self, context: &StepContext<'_>, level: usize, stages: &mut Stages) -> bool {
        let nonlinear_loads = &context.nonlinear_loads;
        let (len, rates) = (nonlinear_loads.interface_len(), nonlinear_loads.scalars());
        let (stage_response, tangents) = (context.cache.stage_response(level), &context.cache.maps.tangents);
        if !self.factorize(level, &stage_response.own) || self.idle {
            return self.solvable;
        }
        for (state, homogeneous) in stages.interface_states.iter_mut().zip(&stages.homogeneous_response) {
            *state = homogeneous - *state;
        }
        let size = self.system.right.len();
        for (from, changes) in [0, rates].into_iter().zip(self.deflection_change.chunks_exact_mut(size)) {
            let of_stages = stages.interface_states.chunks_exact(len).zip(changes.chunks_exact_mut(tangents.len()));
            for (state, changes) in of_stages {
                for (change, tangent) in changes.iter_mut().zip(tangents) {
                    *change = tangent.along(state, from);
                }
            }
        }
        panel_kernel::accumulate_panel(context.arch, &stage_response.along, &stages.loads, &mut self.deflection_change);
        self.add_forces(context.arch, &mut stages.loads);
        true
    }

    /// Corrects the stage loads for the motion that their last change, the residual, causes at the contacts of the
    /// stages. Returns whether the correction exists.
    pub fn correct(&mut self, context: &StepContext<'_>, level: usize, stages: &mut Stages) -> bool {
        let stage_response = context.cache.stage_response(level);
        self.set_contacts(&context.nonlinear_loads, &stages.contacts);
        if !self.factorize(level, &stage_response.own) || self.idle {
            return self.solvable;
        }
        self.deflection_change.fill(0.0);
        panel_kernel::accumulate_panel(
            context.arch,
            &stage_response.along,
            &stages.residual,
            &mut self.deflection_change,
        );
        self.add_forces(context.arch, &mut stages.loads);
        true
    }
}
