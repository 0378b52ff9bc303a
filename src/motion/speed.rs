//! The speed Ω of the reference shaft: constant, or continuous cubic pieces with constant speed before and after them.
//!
//! Pieces are polynomials, so the angle ϑ = ∫Ω dt and the acceleration Ω̇ are exact.

use super::phase::DoubleDouble;
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::{EntryPath, SceneError};

/// Speed of the reference shaft, rad/s.
#[derive(Clone, Debug, PartialEq)]
pub enum Speed {
    /// Constant.
    Constant(f64),
    /// Changing with time.
    Changing(Profile),
}

impl From<f64> for Speed {
    fn from(speed: f64) -> Self {
        Self::Constant(speed)
    }
}

impl Speed {
    /// Ω at a time.
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Constant(speed) => *speed,
            Self::Changing(profile) => profile.piece_at(time).at(time),
        }
    }

    /// Largest |Ω| of the whole profile with the sign of Ω between two times. If Ω is zero between them, the sign is
    /// that of the whole profile. The sign decides which flanks are in contact. The magnitude is the same for every
    /// section of a run, so that a continued run has the same steps.
    pub fn fastest(&self, start: f64, end: f64) -> f64 {
        match self {
            Self::Constant(speed) => *speed,
            Self::Changing(profile) => {
                let largest = profile.largest(profile.breaks[0], profile.end());
                match profile.largest(start, end) {
                    0.0 => largest,
                    within => largest.abs().copysign(within),
                }
            }
        }
    }

    /// A time between `start` and `end` at which |Ω| is largest, s: `start` at a constant speed.
    pub fn time_of_fastest(&self, start: f64, end: f64) -> f64 {
        match self {
            Self::Constant(_) => start,
            Self::Changing(profile) => {
                let faster = |most: (f64, f64), next: (f64, f64)| if next.1.abs() > most.1.abs() { next } else { most };
                profile.extremes(start, end).into_iter().fold((start, 0.0), faster).0
            }
        }
    }

    /// The smallest and the largest magnitude of the speed at all times, rad/s.
    pub fn magnitudes(&self) -> [f64; 2] {
        match self {
            Self::Constant(speed) => [speed.abs(); 2],
            Self::Changing(profile) => {
                let extremes = profile.extremes(profile.breaks[0], profile.end());
                let crosses = extremes.windows(2).any(|pair| pair[0].1 * pair[1].1 <= 0.0);
                let magnitudes = extremes.into_iter().map(|(_, speed)| speed.abs());
                let [least, most] =
                    magnitudes.fold([f64::INFINITY, 0.0], |[least, most], speed| [least.min(speed), most.max(speed)]);
                [if crosses { 0.0 } else { least }, most]
            }
        }
    }

    /// The angle ∫Ω dt between two times, rad.
    pub fn angle_between(&self, from: f64, to: f64) -> DoubleDouble {
        match self {
            Self::Constant(speed) => DoubleDouble::from(*speed).times(DoubleDouble::sum(to, -from)),
            Self::Changing(profile) => profile.angle_between(from, to),
        }
    }

    /// Checks that the speed is finite and does not change its sign between two times.
    ///
    /// # Errors
    /// [`SceneError`] with the time of the change.
    pub fn check(&self, start: f64, end: f64) -> Result<(), SceneError> {
        match self {
            Self::Constant(speed) => EntryPath::root("speed").finite(*speed).map(|_| ()),
            Self::Changing(profile) => profile.keeps_its_sign(start, end),
        }
    }
}

/// A variable speed of cubic pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    breaks: Vec<f64>,
    /// Pieces before the first break, between the breaks, and after the last break.
    pieces: Vec<Piece>,
}

impl Profile {
    /// Creates the pieces between `breaks`, s, with the coefficients of 1, τ, τ², τ³ in the time τ since the break.
    ///
    /// # Errors
    /// [`SceneError`] if times do not ascend, a number is not finite, or the speed jumps.
    pub fn new(breaks: Vec<f64>, coefficients: &[[f64; 4]]) -> Result<Self, SceneError> {
        let error = |message: String| SceneError::new("speed", message);
        let (pieces, times) = (coefficients.len(), breaks.len());
        if pieces == 0 || times != pieces + 1 {
            return Err(error(format!("needs {} times for {pieces} pieces, got {times}", pieces + 1)));
        }
        if let Some((index, time)) = breaks.iter().enumerate().find(|(_, time)| !time.is_finite()) {
            let time = time.to_string().to_lowercase();
            return Err(error(format!("time {index} must be finite, got {time}")));
        }
        if let Some(pair) = breaks.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(error(format!("times must ascend, {} s follows {} s", pair[1], pair[0])));
        }
        let finite = |cubic: &[f64; 4]| cubic.iter().all(|value| value.is_finite());
        if let Some((begin, _)) = breaks.iter().zip(coefficients).find(|(_, cubic)| !finite(cubic)) {
            return Err(error(format!("must be finite, and is not from {begin} s on")));
        }
        let piece = |(about, cubic): (&f64, &[f64; 4])| Piece { begin: *about, about: *about, cubic: *cubic };
        let mut pieces: Vec<_> = breaks.iter().zip(coefficients).map(piece).collect();
        let reference_force = |about: f64, speed: f64| Piece { begin: about, about, cubic: [speed, 0.0, 0.0, 0.0] };
        let (first, last) = (breaks[0], breaks[coefficients.len()]);
        let (before, after) =
            (reference_force(first, pieces[0].at(first)), reference_force(last, pieces[pieces.len() - 1].at(last)));
        pieces.insert(0, Piece { begin: f64::NEG_INFINITY, ..before });
        pieces.push(after);
        let profile = Self { breaks, pieces };
        let least = EQUALITY_TOLERANCE * profile.largest(first, last).abs();
        for (pair, time) in profile.pieces.windows(2).zip(&profile.breaks) {
            let (left, right) = (pair[0].at(*time), pair[1].at(*time));
            if (right - left).abs() > least {
                return Err(error(format!("must not jump, goes from {left} to {right} rad/s at {time} s")));
            }
        }
        Ok(profile)
    }

    /// Times between the pieces, and the coefficients of each.
    pub fn breaks_and_polynomials(&self) -> (&[f64], impl Iterator<Item = &[f64; 4]>) {
        (&self.breaks, self.pieces[1..self.breaks.len()].iter().map(|piece| &piece.cubic))
    }

    fn end(&self) -> f64 {
        self.breaks[self.breaks.len() - 1]
    }

    /// The pieces, each with the time at which it ends.
    pub(super) fn pieces(&self) -> impl Iterator<Item = (&Piece, f64)> {
        self.pieces.iter().zip(self.breaks.iter().copied().chain([f64::INFINITY]))
    }

    fn piece_at(&self, time: f64) -> &Piece {
        &self.pieces[self.breaks.partition_point(|begin| *begin <= time)]
    }

    pub(super) fn angle_between(&self, from: f64, to: f64) -> DoubleDouble {
        if from > to {
            return self.angle_between(to, from).times(DoubleDouble::from(-1.0));
        }
        let within = self.pieces().filter(|(piece, end)| piece.begin < to && *end > from);
        let angle = |(piece, end): (&Piece, f64)| piece.angle_between(from.max(piece.begin), to.min(end));
        within.map(angle).fold(DoubleDouble::default(), DoubleDouble::plus)
    }

    /// Ω at both ends, at every break and at every extremum between two times, as ascending (time, Ω).
    fn extremes(&self, start: f64, end: f64) -> Vec<(f64, f64)> {
        let mut found = Vec::new();
        for (piece, until) in self.pieces().filter(|(piece, until)| piece.begin <= end && *until >= start) {
            let (from, to) = (start.max(piece.begin), end.min(until));
            let mut times = [from, to, to, to];
            let [first, second] = piece.level();
            for (time, level) in times[1..3].iter_mut().zip([first.min(second), first.max(second)]) {
                if level > from && level < to {
                    *time = level;
                }
            }
            times.sort_by(f64::total_cmp);
            found.extend(times.map(|time| (time, piece.at(time))));
        }
        found
    }

    fn largest(&self, start: f64, end: f64) -> f64 {
        let speeds = self.extremes(start, end).into_iter().map(|(_, speed)| speed);
        speeds.fold(0.0, |largest: f64, speed| if speed.abs() > largest.abs() { speed } else { largest })
    }

    fn keeps_its_sign(&self, start: f64, end: f64) -> Result<(), SceneError> {
        let least = EQUALITY_TOLERANCE * self.largest(start, end).abs();
        let turning =
            self.extremes(start, end).into_iter().filter(|(_, speed)| speed.abs() > least).collect::<Vec<_>>();
        let Some(pair) = turning.windows(2).find(|pair| pair[0].1 * pair[1].1 < 0.0) else {
            return Ok(());
        };
        let (mut before, mut after) = (pair[0].0, pair[1].0);
        while (before + after) / 2.0 > before && (before + after) / 2.0 < after {
            let middle = (before + after) / 2.0;
            let same = self.piece_at(middle).at(middle) * pair[0].1 > 0.0;
            *(if same { &mut before } else { &mut after }) = middle;
        }
        let message =
            format!("changes its sign at {after} s, where the teeth would change their flanks: end the run there");
        Err(SceneError::new("speed", message))
    }
}

/// A piece of the speed profile: a cubic polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    /// Time at which the piece begins, s.
    pub begin: f64,
    /// Time at which τ is zero, s.
    pub about: f64,
    /// Coefficients of 1, τ, τ², τ³.
    pub cubic: [f64; 4],
}

impl Piece {
    /// Speed Ω at a time, rad/s.
    fn at(&self, time: f64) -> f64 {
        let ([a, b, c, d], t) = (self.cubic, time - self.about);
        a + t * (b + t * (c + t * d))
    }

    /// Angle ∫Ω dt between two times, rad.
    fn angle_between(&self, from: f64, to: f64) -> DoubleDouble {
        let [a, b, c, d] = self.cubic;
        let since = |time: f64| {
            let t = DoubleDouble::sum(time, -self.about);
            let cubic = t.times((d / 4.0).into()).plus(DoubleDouble::quotient(c, 3.0));
            t.times(t.times(t.times(cubic).plus((b / 2.0).into())).plus(a.into()))
        };
        since(to).plus(since(from).times(DoubleDouble::from(-1.0)))
    }

    /// Times at which Ω̇ = 0, s; NaN or infinite if there are none.
    fn level(&self) -> [f64; 2] {
        let [_, b, c, d] = self.cubic;
        let root = (c * c - 3.0 * b * d).sqrt();
        // The root without cancellation, and the other root from the product of both (Vieta).
        let sum = -(c + root.copysign(c));
        [self.about + sum / (3.0 * d), self.about + b / sum]
    }

    /// Coefficients for τ measured from another time.
    pub fn moved_to(&self, about: f64) -> [f64; 4] {
        let ([a, b, c, d], t) = (self.cubic, about - self.about);
        [a + t * (b + t * (c + t * d)), b + t * (2.0 * c + 3.0 * t * d), c + 3.0 * t * d, d]
    }
}
