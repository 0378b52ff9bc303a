//! Time in ticks, and the lengths of step that there are.
//!
//! A step is a power of two of ticks and begins at a multiple of itself, so that steps and the times asked for meet, and
//! what is tabulated for a length serves all steps of it.

/// How time is counted, and which steps there are: level 0 is the longest, each other half as long as the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeGrid {
    /// The longest step, s.
    pub longest: f64,
    /// The level of the shortest step, a tick.
    pub finest: usize,
    /// The level of the shortest step that events use: what is left to an event, no mode turns by a radian in.
    pub event: usize,
}

impl TimeGrid {
    /// Ticks in a step.
    pub fn ticks(&self, level: usize) -> u64 {
        1 << (self.finest - level)
    }

    /// The length of a step, s.
    pub fn step(&self, level: usize) -> f64 {
        self.longest / (1_u64 << level) as f64
    }

    /// A tick, s.
    pub fn tick(&self) -> f64 {
        self.step(self.finest)
    }

    /// The time of so many ticks, s.
    pub fn time(&self, ticks: u64) -> f64 {
        ticks as f64 * self.tick()
    }

    /// The level of the longest step that is not above `length`, seconds, or of the shortest there is.
    pub fn level_of(&self, length: f64) -> usize {
        (0..self.finest).find(|level| self.step(*level) <= length).unwrap_or(self.finest)
    }

    /// The level of the shortest part that what lies within a step of `level` is made of: that of events, or the step.
    pub fn part(&self, level: usize) -> usize {
        level.max(self.event)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_fit_into_each_other() {
        let time_grid = TimeGrid { longest: 5e-5, finest: 8, event: 5 };
        for level in 0..=time_grid.finest {
            assert_eq!(time_grid.time(time_grid.ticks(level)), time_grid.step(level));
            assert_eq!(
                [time_grid.level_of(time_grid.step(level)), time_grid.level_of(1.9 * time_grid.step(level))],
                [level; 2]
            );
            assert!(
                time_grid.part(level) >= time_grid.event
                    && time_grid.ticks(time_grid.part(level)) <= time_grid.ticks(level)
            );
        }
        assert_eq!([time_grid.level_of(f64::INFINITY), time_grid.level_of(0.0)], [0, time_grid.finest]);
    }
}
