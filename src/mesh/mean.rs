//! The mesh with its mean stiffness, for modes, equilibrium and all linear analyses.

use super::contact::MeshState;
use super::gear_mesh::{GearMesh, Geometry, dot};
use super::involute::Overlap;

impl GearMesh {
    /// Deflection δ for small displacements `q`, along the line of action at rest, m.
    pub fn deflection_at_rest(&self, sigma: f64, q: &[f64]) -> f64 {
        let relative = self.relative(q);
        let normal = self.at_rest[usize::from(sigma > 0.0)].normal;
        sigma * relative.rolling_displacement - dot(normal, relative.relative_displacement)
    }

    /// Unit vector n of the line of action with the centres at rest.
    pub fn normal_at_rest(&self, sigma: f64) -> [f64; 2] {
        self.at_rest[usize::from(sigma > 0.0)].normal
    }

    /// Static force of the mean stiffness at the displacements `q`, on the drive flank or on the `back` flank, and the
    /// tangent of the generalised forces. Calls `visit(row, column, ∂(F ∂δ/∂q)/∂q)` with the terms k·ggᵀ and, in live
    /// geometry, F ∂²δ/∂q². Returns F and n.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn mean_tangent(
        &self,
        geometry: Geometry,
        sigma: f64,
        back: bool,
        q: &[f64],
        mut visit: impl FnMut(usize, usize, f64),
    ) -> Result<(f64, [f64; 2]), Overlap> {
        let relative = self.relative(q);
        let (sigma, clearance) = if back { (-sigma, self.backlash.unwrap_or(0.0)) } else { (sigma, 0.0) };
        let line = self.line(
            sigma,
            &self.centre_geometry(geometry, relative.relative_displacement)?,
            relative.relative_displacement,
        );
        let force = self.stiffness * (sigma * relative.rolling_displacement + line.deflection - clearance);
        self.gradient(sigma, line.normal, |row, left| {
            self.gradient(sigma, line.normal, |column, right| visit(row, column, self.stiffness * left * right));
        });
        if let (Geometry::Live, Some([a, b])) = (geometry, self.coordinates.translation) {
            // ∂²δ/∂(u_b − u_a)² = −m mᵀ/(C sin α): the line of action rotates if the centres move perpendicular to it.
            let curvature = -force / line.tangent;
            for (row, sign) in [(a, -1.0), (b, 1.0)] {
                for (column, other) in [(a, -1.0), (b, 1.0)] {
                    for i in 0..2 {
                        for j in 0..2 {
                            let value =
                                curvature * line.tangent_direction[i] * line.tangent_direction[j] * sign * other;
                            visit(row + i, column + j, value);
                        }
                    }
                }
            }
        }
        Ok((force, line.normal))
    }

    /// Static forces of the mean stiffness on drive flank and back flank at the displacements `q`, N, and n of both. Flanks
    /// with backlash do not pull; without backlash the drive flank carries the whole force.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn mean_forces(&self, geometry: Geometry, sigma: f64, q: &[f64]) -> Result<[(f64, [f64; 2]); 2], Overlap> {
        let drive = self.mean_tangent(geometry, sigma, false, q, |_, _, _| {})?;
        let back = self.mean_tangent(geometry, sigma, true, q, |_, _, _| {})?;
        Ok(match self.backlash {
            None => [drive, (0.0, back.1)],
            Some(_) => [drive, back].map(|(force, normal)| (force.max(0.0), normal)),
        })
    }

    /// The reported quantities of a mesh in equilibrium with the mean stiffness at the displacements `q`.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn state_at_rest(&self, geometry: Geometry, sigma: f64, q: &[f64]) -> Result<MeshState, Overlap> {
        let relative = self.relative(q);
        let (elastic, _) = self.mean_tangent(geometry, sigma, false, q, |_, _, _| {})?;
        let [(drive, _), (back, _)] = self.mean_forces(geometry, sigma, q)?;
        let flanks = if drive > 0.0 && back > 0.0 { 2.0 } else { 1.0 };
        let centres = self.reported_centres(geometry, relative.relative_displacement)?;
        let line = self.line(
            sigma,
            &self.centre_geometry(geometry, relative.relative_displacement)?,
            relative.relative_displacement,
        );
        let (first, last) = self.path(sigma, false, &line, 0.0, relative.twist[0]).engaged();
        Ok(MeshState {
            deflection: elastic / self.stiffness,
            force: drive - back,
            stiffness: flanks * self.stiffness,
            pairs_in_contact: (last - first + 1).max(0) as f64,
            centres,
        })
    }
}
