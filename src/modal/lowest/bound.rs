//! Bounds of the eigenvalues of [λ²M + λ(C + ΩG) + K] x = 0 and of their damping ratios.

use num_complex::Complex64;

use super::contour::SECTOR;
use crate::model::{Model, Support, Weights};

/// Limits of the damping ratio that are tried, in this order. The second one is the cosine of [`SECTOR`].
const LIGHT: [f64; 2] = [0.2, 0.5];
/// Ratio of two rates below which no interval between them is divided.
const NARROW: f64 = 1.5;

/// Bound of all eigenvalues: |λ| ≤ c + Ωg + √(k + κ) follows from xᴴS(λ)x = 0, where c, g, k and κ bound the damping, the
/// gyroscopic matrix, the symmetric and the skew part of the stiffness relative to the mass.
pub(in crate::modal) struct Bound {
    /// c, 1/s, without modal damping.
    pub damping: f64,
    /// ζ of modal damping: its matrix is at most ζ(rM + K/r) for every rate r.
    modal: f64,
    /// Ωg, 1/s.
    pub gyroscopic: f64,
    /// κ, 1/s².
    pub circulatory: f64,
    /// √k, rad/s.
    fastest: f64,
    /// Whether the damping is positive semidefinite.
    pub dissipative: bool,
    /// Whether damping and stiffness are symmetric, and the stiffness is positive semidefinite.
    pub symmetric: bool,
}

impl Bound {
    /// The bound at a speed of the reference shaft, rad/s, for the highest undamped frequency, rad/s, and the ratio of modal
    /// damping.
    pub fn new(model: &Model, speed: f64, fastest: f64, modal: f64) -> Self {
        let [alpha, beta] = model.scene.rayleigh;
        let mut bound = Self {
            damping: alpha.abs() + beta.abs() * fastest * fastest,
            modal,
            gyroscopic: 0.0,
            circulatory: 0.0,
            fastest,
            dissipative: alpha >= 0.0 && beta >= 0.0,
            symmetric: true,
        };
        // The trace of M⁻¹C bounds the largest eigenvalue.
        let mobility = |row: &[(usize, f64)]| {
            let mut column = vec![0.0; model.len()];
            row.iter().for_each(|(index, coefficient)| column[*index] += coefficient);
            model.solve_mass(&mut column);
            row.iter().map(|(index, coefficient)| coefficient * column[*index]).sum::<f64>()
        };
        let supports = model.supports.iter().map(|support| (2.0 * mobility(&[(support.index, 1.0)]), support));
        let links = model.links.iter();
        let links = links.map(|link| (link.rows.iter().map(|row| mobility(row)).sum::<f64>(), &link.local));
        for (mobility, support) in supports.chain(links) {
            let [[a, b], [c, d]] = support.damping;
            bound.damping += mobility * a.hypot(b).hypot(c.hypot(d));
            bound.circulatory += mobility * support.skew_part().as_flattened().iter().fold(0.0_f64, |n, k| n.hypot(*k));
            bound.dissipative &= a >= 0.0 && d >= 0.0 && a * d >= (b + c) * (b + c) / 4.0;
            bound.symmetric &= b == c;
        }
        for connection in model.connections(speed) {
            let coefficients = connection.linear(speed);
            let [stiffness, rate] = [&coefficients.stiffness, &coefficients.damping];
            bound.symmetric &= *stiffness == stiffness.transpose() && *rate == rate.transpose();
            let damping = coefficients.damping;
            let mobility: f64 = connection.rows().iter().map(|row| mobility(row)).sum();
            bound.damping += mobility * damping.norm();
            bound.dissipative &= damping.amax() == 0.0 || damping.nrows() == 1 && damping[(0, 0)] >= 0.0;
        }
        let internal = model.scene.shafts.iter().zip(&model.shafts);
        for (given, shaft) in internal.filter(|(given, _)| given.internal_damping > 0.0) {
            bound.damping += given.internal_damping * fastest * fastest;
            let spin = shaft.ratio * model.circulation.unwrap_or(0.0);
            bound.circulatory += given.internal_damping * spin.abs() * fastest * fastest;
        }
        // Polar over diametral inertia is at most two, apart from bodies whose data say otherwise.
        let ratio = |body: &crate::scene::Body| body.polar_inertia / body.diametral_inertia;
        let ratios = model.scene.bodies().map(ratio).filter(|ratio| ratio.is_finite());
        bound.symmetric &= bound.circulatory == 0.0 && is_semidefinite(model, speed);
        bound.gyroscopic = ratios.fold(2.0, f64::max) * model.max_speed_ratio() * speed.abs();
        bound
    }

    /// Whether stiffness and damping are symmetric and positive semidefinite.
    pub fn is_dissipative(&self) -> bool {
        self.symmetric && self.dissipative
    }

    /// The bound without damping, gyroscopic and circulatory forces.
    pub fn without_damping(&self) -> Self {
        Self {
            damping: 0.0,
            modal: 0.0,
            gyroscopic: 0.0,
            circulatory: 0.0,
            fastest: self.fastest,
            dissipative: true,
            symmetric: true,
        }
    }

    /// Bound of |λ| for eigenvalues with Re λ > |λ| cos [`SECTOR`], rad/s. The real part of xᴴS(λ)x/λ contains
    /// |λ| xᴴMx cos φ, and of the forces only those of circulatory springs, κ xᴴMx sin φ/|λ| at most, can be negative.
    pub fn largest_growing(&self) -> f64 {
        if self.dissipative { (self.circulatory * SECTOR.tan()).sqrt() } else { self.largest() }
    }

    /// Bound of |λ|, rad/s.
    pub fn largest(&self) -> f64 {
        let modal = 2.0 * self.modal * self.fastest;
        2.0 * (self.damping + modal + self.gyroscopic + (self.fastest * self.fastest + self.circulatory).sqrt())
    }

    /// Damping ratio that no eigenvalue with |λ| ≥ `lowest` (rad/s) exceeds: the first of [`LIGHT`] that is certain.
    ///
    /// With λ = r e^{iφ}, the Hermitian part of S(λ)/λ is C + cos φ (rM + K/r) if K and C are symmetric. It is positive
    /// definite for cos φ > 0 if C is positive semidefinite, and negative definite for cos φ ≤ −ζ where ζ(rM + K/r) − C is
    /// positive definite. Modal damping takes its own ratio of ζ.
    pub fn largest_ratio(&self, model: &Model, speed: f64, lowest: f64) -> Option<f64> {
        let is_certain = |ratio: &f64| {
            // The mass alone is larger than C at higher rates.
            let left = ratio - self.modal;
            let highest = self.damping / left;
            left > 0.0 && (highest <= lowest || is_definite(model, speed, left, [lowest, highest]))
        };
        LIGHT.into_iter().filter(|_| self.is_dissipative()).find(is_certain)
    }
}

/// Whether the symmetric part of the stiffness of every bearing, link and connection is positive semidefinite.
pub(super) fn is_semidefinite(model: &Model, speed: f64) -> bool {
    let is_stable = |local: &Support| {
        let [[a, b], [_, d]] = local.symmetric_part;
        a >= 0.0 && d >= 0.0 && a * d >= b * b
    };
    let mut connections = model.connections(speed).map(|connection| connection.linear(speed).stiffness);
    model.local_elements().all(is_stable)
        && connections.all(|stiffness| (&stiffness + stiffness.transpose()).symmetric_eigenvalues().min() >= 0.0)
}

/// Whether `ratio`·(rM + K/r) − C is found to be positive definite for all r between two rates (1/s).
fn is_definite(model: &Model, speed: f64, ratio: f64, [low, high]: [f64; 2]) -> bool {
    // No form of this matrix is larger than that at a rate between them, because K is positive semidefinite.
    let weights = Weights {
        structural: None,
        stiffness: Complex64::from(ratio / high),
        damping: Complex64::from(-1.0),
        mass: Complex64::from(ratio * low),
        gyroscopic: Complex64::ZERO,
        symmetric: true,
    };
    if model.dynamic_stiffness(&weights, speed).is_positive_definite() {
        return true;
    }
    let middle = (low * high).sqrt();
    high > NARROW * low
        && is_definite(model, speed, ratio, [low, middle])
        && is_definite(model, speed, ratio, [middle, high])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::lowest::shift_invert::Problem;
    use crate::modal::{CachedModel, modes};
    use crate::scene::{Scene, SceneDescription, SceneError};

    /// A shaft with a disk on two bearings with these fields.
    fn rotor(bearing: &str) -> Result<CachedModel, SceneError> {
        let text = format!(
            r#"
            shafts = [{{ name = "s", length = 1.0, outer_diameter = 0.05, elements = 24 }}]
            disks = [{{ name = "d", shaft = "s", position = 0.4, mass = 20.0, diametral_inertia = 0.1, polar_inertia = 0.2 }}]
            bearings = [
                {{ shaft = "s", position = 0.0, {bearing} }},
                {{ shaft = "s", position = 1.0, {bearing} }},
            ]
            "#
        );
        let scene = Scene::new(&SceneDescription::from_toml(&text)?)?;
        Ok(CachedModel::new(Model::new(scene)?))
    }

    #[test]
    fn no_eigenvalue_exceeds_the_largest_damping_ratio() -> Result<(), Box<dyn std::error::Error>> {
        let mut known = Vec::new();
        for bearing in [
            "stiffness = 1e8, damping = 100.0",
            "stiffness = 1e7, damping = 3000.0",
            "stiffness = [1e7, 3e7], damping = [1000.0, 8000.0]",
            "stiffness = 1e7, damping = 3e4",
            "stiffness = 1e6, damping = 1e6",
            "stiffness = [[1e7, 6e6], [-6e6, 1e7]], damping = 300.0",
            "stiffness = [[1e7, 1.1e7], [1.1e7, 1e7]], damping = 300.0",
        ] {
            let cached = rotor(bearing)?;
            for speed in [0.0, 500.0] {
                let range = cached.spectral_range(speed)?;
                let problem = Problem::new(&cached.model, speed, range, None)?;
                let ratio = problem.largest_ratio_above(problem.shift);
                known.push(ratio);
                for mode in modes(&cached, speed, usize::MAX)? {
                    let size = mode.eigenvalue.norm();
                    let is_within = mode.eigenvalue.re.abs() <= ratio.unwrap_or(1.0) * size * (1.0 + 1e-9);
                    assert!(size < problem.shift || is_within, "{bearing}: {} for {ratio:?}", mode.eigenvalue);
                }
            }
        }
        // The bounds are sharp enough for light dampers, and none holds for strong or circulating ones.
        assert_eq!(known[..2], [Some(LIGHT[0]); 2]);
        assert_eq!(known[6..], [None; 8]);
        Ok(())
    }
}
