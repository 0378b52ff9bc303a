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

/// A variable speed as a function of elapsed time. The current piece is fixed within a step, so that no step crosses a
/// kink and an evaluation needs no search.
#[derive(Clone, Debug)]
pub(super) struct VariableSpeed {
    pieces: Vec<SpeedPiece>,
    current: usize,
}

/// A cubic polynomial of Ω in the elapsed time since the start of the piece.
#[derive(Clone, Copy, Debug)]
struct SpeedPiece {
    start: f64,
    /// Duration, s.
    length: f64,
    /// Angle since the origin, rad.
    angle: f64,
    cubic: [f64; 4],
}

/// The reference shaft at an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct RotationState {
    /// Angle since the origin, rad.
    pub angle: f64,
    /// Ω, rad/s.
    pub speed: f64,
    /// Ω̇, rad/s².
    pub acceleration: f64,
}

impl VariableSpeed {
    fn new(profile: &Profile, origin: f64) -> Self {
        let pieces = profile.pieces().filter(|(_, end)| *end > origin).map(|(piece, end)| {
            let begin = piece.begin.max(origin);
            SpeedPiece {
                start: begin - origin,
                length: end - begin,
                angle: profile.angle_between(origin, begin).high,
                cubic: piece.moved_to(begin),
            }
        });
        Self { pieces: pieces.collect(), current: 0 }
    }

    /// Index of the piece at an elapsed time.
    pub fn piece_at(&self, elapsed: f64) -> i64 {
        self.pieces.partition_point(|piece| piece.start <= elapsed).saturating_sub(1) as i64
    }

    /// Sets the piece for the following steps.
    pub fn set_piece(&mut self, piece: i64) {
        self.current = usize::try_from(piece).unwrap_or(0).min(self.pieces.len() - 1);
    }

    /// The reference shaft at an instant of the current piece. A trial step may end after the piece. There Ω̇ is
    /// constant, because an extrapolated cubic has no bound.
    // Not inlined, because the constant speed is the common case.
    #[inline(never)]
    pub fn at(&self, elapsed: f64) -> RotationState {
        let piece = &self.pieces[self.current];
        let since = elapsed - piece.start;
        let ([a, b, c, d], t) = (piece.cubic, since.min(piece.length));
        let beyond = since - t;
        let (speed, acceleration) = (a + t * (b + t * (c + t * d)), b + t * (2.0 * c + t * (3.0 * d)));
        let angle = piece.angle + t * (a + t * (b / 2.0 + t * (c / 3.0 + t * (d / 4.0))));
        RotationState {
            angle: angle + beyond * (speed + acceleration * beyond / 2.0),
            speed: speed + acceleration * beyond,
            acceleration,
        }
    }
}
