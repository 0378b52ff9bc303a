//! Energy of the motion and the state of its meshes, and the quadratic forms that measure an error as an energy.

use super::Motion;
use crate::mesh::{MeshState, Overlap};
use crate::model::Model;

impl<'m> Motion<'m> {
    /// Kinetic and elastic energy, J: ½vᵀMv + ½(q − q_b)ᵀK_s(q − q_b) + ½qᵀK_bearings q + ΣU of the meshes.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn energy(&mut self, elapsed: f64, q: &[f64], v: &[f64]) -> Result<f64, Overlap> {
        let mut unbent = std::mem::take(&mut self.scratch);
        unbent.copy_from_slice(q);
        for (index, shaft) in self.model.shafts.iter().enumerate() {
            if let (Some(bow), Some(chain)) = (&shaft.bow, &shaft.bending) {
                let turn = self.turn(index, elapsed);
                for (value, pair) in bow.iter().zip(unbent[chain.start..].chunks_exact_mut(2)) {
                    let free = value * turn;
                    pair[0] -= free.re;
                    pair[1] -= free.im;
                }
            }
        }
        let mut sum = self.model.kinetic_form(v) + self.model.shaft_form(&unbent) + self.model.support_form(q);
        self.scratch = unbent;
        for (index, (mesh, sigma)) in self.model.meshes.iter().zip(&self.sigma).enumerate() {
            let turning = self.turning(index, elapsed);
            sum += 2.0 * mesh.contact(self.geometry, *sigma, &self.laws[index], &turning, q, v)?.energy;
        }
        Ok(sum / 2.0)
    }

    /// What a response reports of a mesh.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn mesh_state(&self, mesh: usize, elapsed: f64, q: &[f64], v: &[f64]) -> Result<MeshState, Overlap> {
        let turning = self.turning(mesh, elapsed);
        self.model.meshes[mesh].state(self.geometry, self.sigma[mesh], &self.laws[mesh], &turning, q, v)
    }

    /// The model that moves.
    pub fn model(&self) -> &'m Model {
        self.model
    }
}
