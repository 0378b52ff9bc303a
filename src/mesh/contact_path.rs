//! The path of contact of a mesh at an instant, and the tooth pairs on it.

/// Position of the tooth pairs on the path of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPath {
    /// Position s of pair 0, m.
    pub position: f64,
    /// Length C sin α of the line of action between the base circles, m.
    pub tangent: f64,
    /// Beginning of the path of contact, m.
    pub low: f64,
    /// End of the path of contact, m.
    pub high: f64,
    /// Base pitch, m.
    pub pitch: f64,
    /// Length b tan β_b of the path by which the contact at one end of the face width is ahead of the other end, m; zero for
    /// spur gears.
    pub overlap: f64,
}

impl ContactPath {
    /// Derivatives of both ends with respect to C sin α: 1 if a tip or the base circle of the driven gear is the end,
    /// otherwise 0.
    #[inline]
    pub(super) fn end_slopes(&self) -> [f64; 2] {
        [f64::from(u8::from(self.low > 0.0)), f64::from(u8::from(self.high >= self.tangent))]
    }

    /// Positions of both ends among the pairs, in base pitches from pair 0, for a pair that touches anywhere on its face.
    pub fn ends(&self) -> [f64; 2] {
        let half = self.overlap / 2.0;
        [self.low - half, self.high + half].map(|end| (end - self.position) / self.pitch)
    }

    /// First and last pair between the ends; last < first if there is none.
    pub fn engaged(&self) -> (i64, i64) {
        let [low, high] = self.ends();
        (low.ceil() as i64, high.floor() as i64)
    }
}
