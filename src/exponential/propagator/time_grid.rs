//! Integer time: a count of units, and the step lengths that are powers of two of the unit.
//!
//! A step starts at a multiple of its length, or at a contact change. Steps and output times therefore meet, and the propagator of a length
//! serves all steps of that length.

/// The unit of time and the step lengths. Step level 0 is the longest; each level is half as long as the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeGrid {
    /// Length of the longest step, s.
    pub longest: f64,
    /// Step level of the shortest step, which is one unit long.
    pub finest: usize,
    /// Step level of the shortest substep. No mode rotates by a radian within it.
    pub substep: usize,
}

impl TimeGrid {
    /// Units in a step.
    pub fn units(&self, step_level: usize) -> u64 {
        1 << (self.finest - step_level)
    }

    /// Length of a step, s.
    pub fn step(&self, step_level: usize) -> f64 {
        self.longest / (1_u64 << step_level) as f64
    }

    /// Length of the unit, s.
    pub fn unit(&self) -> f64 {
        self.step(self.finest)
    }

    /// Time of a number of units, s.
    pub fn time(&self, units: u64) -> f64 {
        units as f64 * self.unit()
    }

    /// Level of the longest step that does not exceed `length`, s; the finest level if all steps do.
    pub fn level_of(&self, length: f64) -> usize {
        (0..self.finest).find(|level| self.step(*level) <= length).unwrap_or(self.finest)
    }

    /// Level of the shortest substep within a step; the step itself if it is shorter.
    pub fn substep_level(&self, step_level: usize) -> usize {
        step_level.max(self.substep)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_fit_into_each_other() {
        let time_grid = TimeGrid { longest: 5e-5, finest: 8, substep: 5 };
        for level in 0..=time_grid.finest {
            assert_eq!(time_grid.time(time_grid.units(level)), time_grid.step(level));
            assert_eq!(
                [time_grid.level_of(time_grid.step(level)), time_grid.level_of(1.9 * time_grid.step(level))],
                [level; 2]
            );
            let substep = time_grid.substep_level(level);
            assert!(substep >= time_grid.substep && time_grid.units(substep) <= time_grid.units(level));
        }
        assert_eq!([time_grid.level_of(f64::INFINITY), time_grid.level_of(0.0)], [0, time_grid.finest]);
    }
}
