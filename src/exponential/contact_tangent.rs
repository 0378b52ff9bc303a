//! How loads follow the motion that they cause: what the meshes make of each other within a step, for the stiffness and
//! the damping that their contacts have.
//!
//! A force f of a mesh acts as −g f on its scalars u. Where g·u and g·u̇ change by ℓ and ℓ̇, the forces of all nodes and
//! meshes are those of
//!
//! ```text
//! f = K(ℓ − G f) + C(ℓ̇ − Ġ f),
//! ```
//!
//! G and Ġ what their own forces make of g·u and g·u̇, K and C what the linear motion does not contain of stiffness and
//! damping.

use pulp::Arch;

use super::cache::LinearizedContact;
use super::kernel;
use super::nonlinear_loads::NonlinearLoads;
use super::packed::Panel;
use super::small_lu::SmallLu;
use super::step::Stepper;
use crate::mesh::Contact;

/// The system of all nodes and meshes.
#[derive(Clone, Debug)]
pub(super) struct ContactTangentSolver {
    /// K of all nodes and meshes and, where rates matter, C, for which the system is factored.
    pub residual_tangent: Vec<f64>,
    sought: Vec<f64>,
    /// The level of the step for which it is; whether it has a solution.
    level: usize,
    solvable: bool,
    /// Whether the linear motion contains all that there is.
    idle: bool,
    system: SmallLu,
    /// What the forces add to the loads of all nodes, −g.
    push: Panel,
    /// ℓ of all nodes and meshes and, where rates matter, ℓ̇.
    felt: Vec<f64>,
}

impl ContactTangentSolver {
    /// A system of so many nodes.
    pub fn new(field: &NonlinearLoads<'_>, tangents: &[LinearizedContact], nodes: usize) -> Self {
        let (size, loads) = (nodes * field.meshes(), nodes * field.loads());
        let mut push = vec![0.0; size * loads];
        for (unit, column) in push.chunks_exact_mut(loads.max(1)).enumerate() {
            let LinearizedContact { scalars, gradient, .. } = &tangents[unit % field.meshes()];
            let own = scalars.clone().map(|scalar| unit / field.meshes() * field.loads() + scalar);
            own.zip(gradient).for_each(|(at, g)| column[at] = -g);
        }
        let both = size * field.seen() / field.mesh_loads().max(1);
        Self {
            residual_tangent: vec![f64::NAN; both],
            sought: vec![0.0; both],
            level: usize::MAX,
            solvable: false,
            idle: false,
            system: SmallLu::new(size),
            push: Panel::new(&push, loads),
            felt: vec![0.0; both],
        }
    }

    /// Seeks the forces for K and C of the contacts of node after node; the first ones are those of all nodes that have
    /// none of their own.
    fn seek(&mut self, field: &NonlinearLoads<'_>, contacts: &[Contact]) {
        let meshes = field.meshes();
        let (stiffness, damping) = self.sought.split_at_mut(self.system.right.len());
        for (unit, (stands, contact)) in stiffness.iter_mut().zip(contacts.iter().cycle()).enumerate() {
            let [k, c] = field.residual_tangent(unit % meshes, contact);
            *stands = k;
            if let Some(stands) = damping.get_mut(unit) {
                *stands = c;
            }
        }
    }

    /// Seeks them for contacts like those at the beginning of a step, or as rigid as at the nodes of the one before it.
    pub fn guess(&mut self, field: &NonlinearLoads<'_>, at_begin: &[Contact], before: Option<&[f64]>) {
        match before {
            Some(before) => self.sought.copy_from_slice(before),
            None => self.seek(field, at_begin),
        }
    }

    /// Takes what is sought, for a step of a level. Whether there is a solution.
    fn take(&mut self, level: usize, own: &[f64]) -> bool {
        // Teeth that neither come nor go are as stiff as at the node before, and in the step before.
        if self.level != level || self.residual_tangent != self.sought {
            self.level = level;
            self.residual_tangent.copy_from_slice(&self.sought);
            self.idle = self.residual_tangent.iter().all(|value| *value == 0.0);
            self.solvable = self.idle || {
                self.system.fill(own, &self.residual_tangent);
                self.system.factor()
            };
        }
        self.solvable
    }

    /// Adds to the loads of the nodes what follows from what is felt.
    fn add(&mut self, arch: Arch, loads: &mut [f64]) {
        let size = self.system.right.len();
        self.system.right.fill(0.0);
        for (felt, residual_tangent) in self.felt.chunks_exact(size).zip(self.residual_tangent.chunks_exact(size)) {
            for ((force, felt), residual_tangent) in self.system.right.iter_mut().zip(felt).zip(residual_tangent) {
                *force += residual_tangent * felt;
            }
        }
        self.system.substitute();
        kernel::accumulate_panel(arch, &self.push, &self.system.right, loads);
    }
}

impl Stepper<'_> {
    /// Lets the loads that were guessed follow the motion that they cause, where it is not the one that was guessed with
    /// them. Whether that can be solved.
    pub(super) fn predict(&mut self, level: usize) -> bool {
        let (seen, rates) = (self.field.seen(), self.field.mesh_loads());
        let (stage_response, tangents) = (self.cache.stage_response(level), &self.cache.maps.tangents);
        let tangent_solver = &mut self.tangent_solver;
        if !tangent_solver.take(level, &stage_response.own) || tangent_solver.idle {
            return tangent_solver.solvable;
        }
        // What is guessed is taken off what is caused.
        for (node, homogeneous_response) in self.nodes.iter_mut().zip(&self.homogeneous_response) {
            *node = homogeneous_response - *node;
        }
        let size = tangent_solver.system.right.len();
        for (from, felt) in [0, rates].into_iter().zip(tangent_solver.felt.chunks_exact_mut(size)) {
            for (node, felt) in self.nodes.chunks_exact(seen).zip(felt.chunks_exact_mut(tangents.len())) {
                for (felt, tangent) in felt.iter_mut().zip(tangents) {
                    *felt = tangent.along(node, from);
                }
            }
        }
        kernel::accumulate_panel(self.arch, &stage_response.along, &self.loads, &mut tangent_solver.felt);
        tangent_solver.add(self.arch, &mut self.loads);
        true
    }

    /// Adds to the loads what follows from the changes in `residual` that they have just seen; contacts are those at the
    /// nodes. Whether that can be solved.
    pub(super) fn correct(&mut self, level: usize) -> bool {
        let stage_response = self.cache.stage_response(level);
        let tangent_solver = &mut self.tangent_solver;
        tangent_solver.seek(&self.field, &self.contacts);
        if !tangent_solver.take(level, &stage_response.own) || tangent_solver.idle {
            return tangent_solver.solvable;
        }
        tangent_solver.felt.fill(0.0);
        kernel::accumulate_panel(self.arch, &stage_response.along, &self.residual, &mut tangent_solver.felt);
        tangent_solver.add(self.arch, &mut self.loads);
        true
    }
}
