//! Rotation of the reference shaft in a run: its speed, and one known angle.

use num_complex::Complex64;

use super::phase::{DoubleDouble, phasor};
use super::speed::{Profile, Speed};

/// A known angle of the reference shaft; by default it is 0 at the time 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anchor {
    /// Time, s.
    pub time: f64,
    /// Angle, rad, not reduced modulo 2π, because shaft s has r_s times this angle.
    pub angle: DoubleDouble,
}

/// Rotation of the reference shaft in a run.
#[derive(Clone, Debug)]
pub struct ShaftRotation {
    /// Speed.
    pub speed: Speed,
    /// A known angle.
    pub anchor: Anchor,
    /// Time at which elapsed time is zero, s.
    pub origin: f64,
    /// Largest speed, rad/s, with the sign of the speed in the run: see [`Speed::fastest`].
    pub fastest: f64,
}

impl ShaftRotation {
    /// Constant speed; shaft s has the angle r_s Ω t.
    pub fn constant(speed: f64, origin: f64) -> Self {
        Self { speed: Speed::Constant(speed), anchor: Anchor::default(), origin, fastest: speed }
    }

    /// Whether the speed is constant.
    pub(super) fn is_constant(&self) -> bool {
        matches!(self.speed, Speed::Constant(_))
    }

    /// Angle of the reference shaft at a time.
    pub fn angle(&self, time: f64) -> DoubleDouble {
        self.anchor.angle.plus(self.speed.angle_between(self.anchor.time, time))
    }

    /// Phasor e^{iϑ} of a shaft with the speed ratio r_s at elapsed time zero.
    pub fn phasor_at_origin(&self, ratio: f64) -> Complex64 {
        match &self.speed {
            Speed::Constant(speed) => {
                let known = self.anchor.angle.times(ratio.into()).phasor();
                known * phasor(ratio * speed, self.origin - self.anchor.time)
            }
            Speed::Changing(_) => self.angle(self.origin).times(ratio.into()).phasor(),
        }
    }

    /// The speed over elapsed time; none if it is constant.
    pub(super) fn variable_speed(&self) -> Option<VariableSpeed> {
        match &self.speed {
            Speed::Constant(_) => None,
            Speed::Changing(profile) => Some(VariableSpeed::new(profile, self.origin)),
        }
    }
}

/// Jump of the acceleration between two pieces of a speed profile, relative to the largest acceleration, below which the
/// acceleration is continuous. Pieces that are sampled from a smooth function have smaller jumps.
const ACCELERATION_JUMP_TOLERANCE: f64 = 1e-4;
/// Duration of a stretch, s, below which its acceleration is round-off: a function with a kink is sampled in such stretches.
const MIN_STRETCH: f64 = 1e-9;

/// A variable speed as a function of elapsed time. The current piece is fixed within a step, so that no step crosses a
/// kink and an evaluation needs no search.
#[derive(Clone, Debug)]
pub(super) struct VariableSpeed {
    stretches: Vec<Stretch>,
    /// Index of the first stretch of the current piece: a single stretch, or the stretches between two kinks.
    first: usize,
    /// Index of the last stretch of the current piece.
    last: usize,
}

/// A cubic polynomial of Ω in the elapsed time since the start of the piece.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    start: f64,
    /// Duration, s.
    length: f64,
    /// Angle since the origin, rad.
    angle: f64,
    cubic: [f64; 4],
    /// Index of the first stretch of its piece.
    piece: usize,
}

/// The reference shaft at an instant.
#[derive(Clone, Copy, Debug)]
pub struct RotationState {
    /// Angle since the origin, rad.
    pub angle: f64,
    /// Ω, rad/s.
    pub speed: f64,
    /// Ω̇, rad/s².
    pub acceleration: f64,
}

impl Stretch {
    /// Ω̇ at the time `since` its start, rad/s².
    fn acceleration(&self, since: f64) -> f64 {
        let [_, b, c, d] = self.cubic;
        b + since * (2.0 * c + since * (3.0 * d))
    }

    /// Ω̇ at its end, rad/s²; at its start if it has no end.
    fn last_acceleration(&self) -> f64 {
        self.acceleration(if self.length.is_finite() { self.length } else { 0.0 })
    }
}

impl VariableSpeed {
    fn new(profile: &Profile, origin: f64) -> Self {
        let pieces = profile.pieces().filter(|(_, end)| *end > origin);
        let stretches = pieces.enumerate().map(|(index, (piece, end))| {
            let begin = piece.begin.max(origin);
            Stretch {
                start: begin - origin,
                length: end - begin,
                angle: profile.angle_between(origin, begin).high,
                cubic: piece.moved_to(begin),
                piece: index,
            }
        });
        Self { stretches: stretches.collect(), first: 0, last: 0 }
    }

    /// Joins stretches at whose border Ω̇ does not jump to one piece. A very short stretch joins the next one, and counts
    /// as a part of the border before it.
    pub fn join_smooth_pieces(&mut self) {
        let long: Vec<Stretch> =
            self.stretches.iter().copied().filter(|stretch| stretch.length > MIN_STRETCH).collect();
        let ends = |stretch: &Stretch| stretch.acceleration(0.0).abs().max(stretch.last_acceleration().abs());
        let largest = long.iter().map(ends).fold(0.0, f64::max);
        let mut passed = 0_usize;
        for index in 0..self.stretches.len() {
            let after_short = index > 0 && self.stretches[index - 1].length <= MIN_STRETCH;
            let jumps = match (passed.checked_sub(1).map(|last| long[last]), long.get(passed)) {
                (Some(before), Some(after)) => {
                    (after.acceleration(0.0) - before.last_acceleration()).abs() > ACCELERATION_JUMP_TOLERANCE * largest
                }
                _ => false,
            };
            if index > 0 && (after_short || !jumps) {
                self.stretches[index].piece = self.stretches[index - 1].piece;
            }
            passed += usize::from(self.stretches[index].length > MIN_STRETCH);
        }
        self.set_piece(0);
    }

    /// Index of the piece at an elapsed time: that of its first stretch.
    pub fn piece_at(&self, elapsed: f64) -> i64 {
        let stretch = self.stretches.partition_point(|stretch| stretch.start <= elapsed).saturating_sub(1);
        self.stretches[stretch].piece as i64
    }

    /// Whether another piece than the current one holds at an elapsed time.
    pub fn leaves_piece(&self, elapsed: f64) -> bool {
        self.stretches.get(self.last + 1).is_some_and(|next| next.start <= elapsed)
    }

    /// Sets the piece for the following steps.
    pub fn set_piece(&mut self, piece: i64) {
        let first = usize::try_from(piece).unwrap_or(0).min(self.stretches.len() - 1);
        let last = self.stretches.partition_point(|stretch| stretch.piece <= first).saturating_sub(1);
        let last = last.max(first);
        // The law of the piece before its begin is that of its first long stretch.
        let is_long = |index: &usize| self.stretches[*index].length > MIN_STRETCH;
        self.first = (first..=last).find(is_long).unwrap_or(first);
        self.last = last;
    }

    /// The reference shaft at an instant of the current piece. A trial step may end after the piece, and may begin before it
    /// if it begins at the last unit of time before a kink. There Ω̇ is constant, because an extrapolated cubic has no bound.
    // Not inlined, because the constant speed is the common case.
    #[inline(never)]
    pub fn at(&self, elapsed: f64) -> RotationState {
        let Self { first, last, .. } = *self;
        let later = self.stretches[first + 1..=last].partition_point(|stretch| stretch.start <= elapsed);
        let stretch = &self.stretches[first + later];
        let since = elapsed - stretch.start;
        let ([a, b, c, d], t) = (stretch.cubic, since.clamp(0.0, stretch.length));
        let beyond = since - t;
        let (speed, acceleration) = (a + t * (b + t * (c + t * d)), b + t * (2.0 * c + t * (3.0 * d)));
        let angle = stretch.angle + t * (a + t * (b / 2.0 + t * (c / 3.0 + t * (d / 4.0))));
        RotationState {
            angle: angle + beyond * (speed + acceleration * beyond / 2.0),
            speed: speed + acceleration * beyond,
            acceleration,
        }
    }
}
