//! The mesh with its mean stiffness, for modes, equilibrium and all linear analyses.

use super::contact::MeshState;
use super::gear_mesh::GearMesh;
use super::helix::Helix;
use super::involute::{LineOfAction, Overlap};
use super::pose::{Directions, Geometry, RelativeMotion, dot};

/// The teeth at an angle of the driver, with the centres at rest.
#[derive(Clone, Copy, Debug)]
pub struct TeethAtAngle {
    /// Stiffness of the pairs in contact, N/m.
    pub stiffness: f64,
    /// Part of the transmission error that has the period of the teeth, m.
    pub error: f64,
}

/// Power that a mesh transmits in static equilibrium, and its loss.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshLoss {
    /// Transmitted power, W.
    pub power: f64,
    /// Mesh force normal to the teeth, N.
    pub force: f64,
    /// Coefficient of friction; zero without friction.
    pub coefficient: f64,
    /// Power that friction dissipates, mean over the mesh cycle, W.
    pub loss: f64,
}

/// The gears in an equilibrium.
struct AtRest {
    /// Whether the line of action follows the centres.
    geometry: Geometry,
    relative: RelativeMotion,
    line: LineOfAction,
}

impl GearMesh {
    /// The teeth at `count` equally spaced angles of one tooth cycle.
    pub fn tooth_cycle(&self, sigma: f64, count: usize) -> Vec<TeethAtAngle> {
        let Self { involute, teeth, error, .. } = self;
        let path = involute.path_at_rest();
        let cycle = path.pitch / involute.base_radius[0];
        let at = |i: usize| {
            let angle = cycle * i as f64 / count as f64;
            let position = involute.position(sigma, angle, involute.angle_at_rest(), involute.pressure_angle_at_rest());
            TeethAtAngle {
                stiffness: teeth.at(&path, position),
                error: error.as_ref().map_or(0.0, |error| error.of_teeth(angle)),
            }
        };
        (0..count).map(at).collect()
    }

    /// Deflection δ for small displacements `q`, along the line of action at rest, m.
    pub fn deflection_at_rest(&self, sigma: f64, q: &[f64]) -> f64 {
        let relative = self.position(Geometry::Frozen, q);
        let normal = self.at_rest[usize::from(sigma > 0.0)].normal;
        sigma * relative.rolling_displacement - dot(normal, relative.relative_displacement)
    }

    /// Directions of the deflection with the centres at rest.
    pub fn directions_at_rest(&self, sigma: f64) -> Directions {
        Directions { normal: self.at_rest[usize::from(sigma > 0.0)].normal, centres: self.involute.centres_at_rest() }
    }

    /// Directions of the deflection at a position, with its line of action.
    fn directions(&self, geometry: Geometry, sigma: f64, line: &LineOfAction, position: &RelativeMotion) -> Directions {
        let Some(helix) = &self.helix else {
            return Directions { normal: line.normal, ..self.directions_at_rest(sigma) };
        };
        let change = helix.forces(geometry, position, sigma).centre;
        Directions {
            normal: [line.normal[0] - change[0], line.normal[1] - change[1]],
            centres: helix.centres(geometry, position.relative_displacement),
        }
    }

    /// Static force of the mean stiffness at the displacements `q`, on the drive flank or on the `back` flank, and the
    /// tangent of the generalised forces. Calls `visit(row, column, ∂(F ∂δ/∂q)/∂q)` with the terms k·ggᵀ and, in live
    /// geometry, F ∂²δ/∂q². Returns F and the directions of the deflection.
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
    ) -> Result<(f64, Directions), Overlap> {
        let (sigma, clearance) = if back { (-sigma, self.backlash.unwrap_or(0.0)) } else { (sigma, 0.0) };
        let AtRest { geometry, relative, line } = self.at_rest_of(geometry, sigma, q)?;
        let force = self.stiffness * (sigma * relative.rolling_displacement + line.deflection - clearance);
        let directions = self.directions(geometry, sigma, &line, &relative);
        self.gradient(sigma, &directions, |row, left| {
            self.gradient(sigma, &directions, |column, right| visit(row, column, self.stiffness * left * right));
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
            let of_helix =
                |helix: &Helix| helix.curvature([a, b], |row, column, value| visit(row, column, sigma * force * value));
            self.helix.iter().for_each(of_helix);
        }
        Ok((force, directions))
    }

    /// Static forces of the mean stiffness on drive flank and back flank at the displacements `q`, N, and the directions of both. Flanks
    /// with backlash do not pull; without backlash the drive flank carries the whole force.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn mean_forces(&self, geometry: Geometry, sigma: f64, q: &[f64]) -> Result<[(f64, Directions); 2], Overlap> {
        let drive = self.mean_tangent(geometry, sigma, false, q, |_, _, _| {})?;
        let back = self.mean_tangent(geometry, sigma, true, q, |_, _, _| {})?;
        Ok(match self.backlash {
            None => [drive, (0.0, back.1)],
            Some(_) => [drive, back].map(|(force, directions)| (force.max(0.0), directions)),
        })
    }

    /// The gears in an equilibrium at the displacements `q`. The line of action of a planet which moves laterally on a carrier that
    /// turns does not follow the centres: the twist of the carrier moves it along the tangent of its path, which would count as a
    /// change of the distance.
    fn at_rest_of(&self, geometry: Geometry, sigma: f64, q: &[f64]) -> Result<AtRest, Overlap> {
        let is_carried = self.carrier.is_some() && self.coordinates.translation.is_some();
        let geometry = if is_carried { Geometry::Frozen } else { geometry };
        let relative = self.position(geometry, q);
        let centre_geometry = self.centre_geometry(geometry, relative.relative_displacement)?;
        let line = self.line(sigma, &centre_geometry, relative.relative_displacement);
        Ok(AtRest { geometry, relative, line })
    }

    /// The reported quantities of a mesh in equilibrium with the mean stiffness at the displacements `q`.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn state_at_rest(&self, geometry: Geometry, sigma: f64, q: &[f64]) -> Result<MeshState, Overlap> {
        let AtRest { geometry, relative, line } = self.at_rest_of(geometry, sigma, q)?;
        let (elastic, _) = self.mean_tangent(geometry, sigma, false, q, |_, _, _| {})?;
        let [(drive, _), (back, _)] = self.mean_forces(geometry, sigma, q)?;
        let flanks = if drive > 0.0 && back > 0.0 { 2.0 } else { 1.0 };
        let centres = self.reported_centres(geometry, relative.relative_displacement)?;
        let (first, last) = self.path(sigma, false, &line, 0.0, relative.twist[0]).engaged();
        Ok(self.normal_to_teeth(MeshState {
            deflection: elastic / self.stiffness,
            force: drive - back,
            stiffness: flanks * self.stiffness,
            pairs_in_contact: (last - first + 1).max(0) as f64,
            thrust: self.helix.as_ref().map_or(0.0, |helix| -sigma * helix.slope * (drive - back)),
            friction_force: 0.0,
            friction_power: 0.0,
            centres,
        }))
    }

    /// Transmitted power and mean loss of a mesh in equilibrium with the mean stiffness at the displacements `q`, with the spins
    /// of driver and driven gear, rad/s.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn loss_at_rest(
        &self,
        geometry: Geometry,
        sigma: f64,
        spins: [f64; 2],
        q: &[f64],
    ) -> Result<MeshLoss, Overlap> {
        let AtRest { geometry, line: LineOfAction { tangent, .. }, .. } = self.at_rest_of(geometry, sigma, q)?;
        let [(drive, _), (back, _)] = self.mean_forces(geometry, sigma, q)?;
        let force = drive - back;
        let power = (force * self.involute.base_radius[0] * spins[0]).abs();
        let without = MeshLoss { power, force: force / self.base_helix_cosine, ..MeshLoss::default() };
        let Some(friction) = self.friction.as_ref().filter(|_| spins[0] != 0.0 && force != 0.0) else {
            return Ok(without);
        };
        let sums = friction.cycle_mean(&self.involute.path(tangent), |path| {
            let deflection = self.teeth.deflection_under(force.abs(), path);
            friction.sums(&self.teeth, || *path, path.engaged(), deflection)
        });
        let coefficient = friction.coefficient(force, spins[0], tangent);
        Ok(MeshLoss { coefficient, loss: friction.mean_loss(force, spins, tangent, &sums), ..without })
    }
}
