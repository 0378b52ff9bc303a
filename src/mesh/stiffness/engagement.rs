//! Beginning and end of the contact of a tooth pair, and tip relief.

use crate::mesh::ContactPath;
use crate::scene::{Engagement, Relief};

/// The twice differentiable ramp 6x⁵ − 15x⁴ + 10x³ from 0 to 1 for x in the same range.
#[inline(always)]
pub(in crate::mesh) fn smooth_step(x: f64) -> f64 {
    x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
}

impl Engagement {
    /// First and last tooth pair that can carry load.
    pub(super) fn range(&self, path: &ContactPath, engaged: (i64, i64)) -> (i64, i64) {
        match self {
            Self::Sharp => engaged,
            Self::Smooth(_) => self.touching(path),
        }
    }

    /// First and last tooth pair within the path of contact and the ramps at its ends.
    pub(super) fn touching(&self, path: &ContactPath) -> (i64, i64) {
        let half_ramp = self.half_ramp(path.pitch);
        ContactPath { low: path.low - half_ramp, high: path.high + half_ramp, ..*path }.engaged()
    }

    /// Half of the width of the ramps at the ends of the path of contact, m.
    pub(super) fn half_ramp(&self, pitch: f64) -> f64 {
        match self {
            Self::Sharp => 0.0,
            Self::Smooth(width) => width * pitch / 2.0,
        }
    }

    /// Engagement weight of a pair, and its derivatives with respect to `entered` and `left`: the distances from the
    /// beginning and to the end of the path of contact, m.
    ///
    /// The ramp [`smooth_step`] is symmetric, so the mean number of pairs equals the contact ratio.
    #[inline]
    pub(super) fn weight(&self, entered: f64, left: f64, pitch: f64) -> [f64; 3] {
        match self {
            Self::Sharp => [1.0, 0.0, 0.0],
            Self::Smooth(width) => {
                let over = width * pitch;
                let ramp = |distance: f64| {
                    // Most pairs are far from both ends of the path.
                    if distance >= over / 2.0 {
                        return (1.0, 0.0);
                    }
                    let x = (distance / over + 0.5).clamp(0.0, 1.0);
                    let rest = x * (1.0 - x);
                    (smooth_step(x), 30.0 * rest * rest / over)
                };
                let ((a, slope_a), (b, slope_b)) = (ramp(entered), ramp(left));
                [a * b, slope_a * b, a * slope_b]
            }
        }
    }
}

impl Relief {
    /// Tip relief of a pair, m, and its derivatives with respect to `entered` and `left`: the distances from the
    /// beginning and to the end of the path of contact, m.
    ///
    /// The function is not inlined, so that its constants are not computed for teeth without relief.
    #[inline(never)]
    pub(super) fn at(&self, entered: f64, left: f64) -> [f64; 3] {
        let one = |distance: f64| {
            let x = (1.0 - distance / self.length).max(0.0);
            let value = self.amount * x.powi(self.exponent);
            let slope = -self.amount * f64::from(self.exponent) * x.powi(self.exponent - 1) / self.length;
            (value, if x > 0.0 { slope } else { 0.0 })
        };
        let ((entering, by_entered), (leaving, by_left)) = (one(entered), one(left));
        [entering + leaving, by_entered, by_left]
    }
}
