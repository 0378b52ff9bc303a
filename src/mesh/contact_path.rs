//! The path of contact of a mesh at an instant, and the tooth pairs on it.

/// Position of the tooth pairs on the path of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPath {
    /// Position s of pair 0, m.
    pub position: f64,
    /// Length C sin α of the line of action between the base circles, m; negative if a gear is internal.
    pub tangent: f64,
    /// Beginning of the path of contact, m.
    pub low: f64,
    /// End of the path of contact, m.
    pub high: f64,
    /// Positions of the base circles of driver and driven gear, m, which limit the path; infinite for that of an internal gear.
    pub limits: [f64; 2],
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
        [f64::from(u8::from(self.low > self.limits[0])), f64::from(u8::from(self.high >= self.limits[1]))]
    }

    /// Positions of both ends among the pairs, in base pitches from pair 0, for a pair that touches anywhere on its face.
    pub fn ends(&self) -> [f64; 2] {
        let half = self.overlap / 2.0;
        [self.low - half, self.high + half].map(|end| (end - self.position) / self.pitch)
    }

    /// First and last pair between the ends; last < first if there is none.
    pub fn engaged(&self) -> (i64, i64) {
        let [low, high] = self.ends();
        (ceil(low), floor(high))
    }
}

/// ⌈x⌉. For x86-64 without extensions, `f64::ceil` is a call of the library.
fn ceil(x: f64) -> i64 {
    let whole = x as i64;
    if (whole as f64) < x { whole.saturating_add(1) } else { whole }
}

/// ⌊x⌋.
fn floor(x: f64) -> i64 {
    let whole = x as i64;
    if (whole as f64) > x { whole.saturating_sub(1) } else { whole }
}

#[cfg(test)]
mod tests {
    use super::{ceil, floor};

    #[test]
    fn numbers_are_rounded_as_by_the_library() {
        let sizes = [0.0, 1e-300, 0.3, 1.0, 2.5, 4e15, 1e18, 1e19, f64::INFINITY, f64::NAN];
        for x in sizes.into_iter().flat_map(|x| [x, -x]) {
            assert_eq!([ceil(x), floor(x)], [x.ceil() as i64, x.floor() as i64], "{x}");
        }
    }
}
