//! Modes where coefficients of bearings depend on the frequency of the vibration: each mode with the coefficients at its own
//! frequency.
//!
//! With the coefficients of one frequency ω, the eigenvalue problem gives frequencies μ_1(ω) ≤ μ_2(ω) ≤ …. A mode is a root of
//! μ_k(ω) − ω, because only there mode and bearings belong to the same frequency. The functions μ_k are continuous, since
//! eigenvalues are. They are sampled at frequencies of the tables, and each change of sign is closed: by Newton's method for
//! the mode, with the coefficients at the frequency found before, or by the method of Illinois on μ_k.

use num_complex::Complex64;

use super::AnalysisError;
use super::modes::{FURTHER_MODES, accurate, highest_damped, linear_modes};
use crate::modal::{self, CachedModel, Eigenpair, Highest, Mode, ModeAtSpeed, ModeSelection, ascending};
use crate::numerics::{EQUALITY_TOLERANCE, ROOT_OF_ROUND_OFF, ROUND_OFF, Sample, root};
use crate::scene::SceneError;

/// Largest number of frequencies of the tables at which all modes are computed.
const MAX_SAMPLES: usize = 16;
/// Largest number of frequencies in the search of one mode.
const MAX_ITERATIONS: usize = 40;

/// What happens with modes whose frequency lies outside the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outside {
    /// They are an error.
    Refuse,
    /// They are left out.
    LeaveOut,
}

/// The modes with the coefficients of one frequency.
struct LinearModes {
    /// Frequency of the coefficients, rad/s.
    frequency: f64,
    modes: Vec<Mode>,
}

impl LinearModes {
    /// μ_k − ω, rad/s.
    fn distance(&self, index: usize) -> f64 {
        self.modes[index].eigenvalue.im - self.frequency
    }

    /// Whether another mode has the same eigenvalue.
    fn is_multiple(&self, index: usize) -> bool {
        let value = self.modes[index].eigenvalue;
        let equals = |other: usize| (self.modes[other].eigenvalue - value).norm() <= ROOT_OF_ROUND_OFF * value.norm();
        (0..self.modes.len()).any(|other| other != index && equals(other))
    }
}

/// The `count` lowest modes of a selection at `speed` of the reference shaft, rad/s, in ascending order of |λ|; a model with fewer
/// vibrations gives fewer.
///
/// # Errors
/// As `linear_modes`, and if a search does not converge or a mode lies outside the tables of bearings.
pub fn lowest_modes(
    cached: &CachedModel,
    speed: f64,
    count: usize,
    selection: ModeSelection,
) -> Result<Vec<Mode>, AnalysisError> {
    modes(cached, speed, count, selection, Outside::Refuse)
}

/// The `count` lowest modes, as [`lowest_modes`]. Modes whose frequency lies outside the tables of bearings are left out.
///
/// # Errors
/// As [`linear_modes`], and if a search does not converge.
pub(super) fn lowest_modes_in_tables(
    cached: &CachedModel,
    speed: f64,
    count: usize,
) -> Result<Vec<Mode>, AnalysisError> {
    modes(cached, speed, count, ModeSelection::All, Outside::LeaveOut)
}

/// As [`lowest_modes`].
fn modes(
    cached: &CachedModel,
    speed: f64,
    count: usize,
    selection: ModeSelection,
    outside: Outside,
) -> Result<Vec<Mode>, AnalysisError> {
    if !cached.model.depends_on_frequency() {
        return linear_modes(cached, speed, count, selection);
    }
    let mut wanted = count;
    loop {
        let mut found = lowest(cached, speed, wanted, outside)?;
        let is_all = found.len() < wanted;
        found.retain(|mode| selection.contains(&cached.model, speed, mode.eigenvalue));
        if found.len() >= count || is_all {
            found.truncate(count);
            return accurate(found, speed);
        }
        // Half as many again where the model has far more other motions than vibrations.
        wanted += (count - found.len()).max(wanted / 2);
    }
}

/// The `count` lowest modes.
///
/// # Errors
/// As [`modes`].
fn lowest(cached: &CachedModel, speed: f64, count: usize, outside: Outside) -> Result<Vec<Mode>, AnalysisError> {
    let search = Search { cached, speed, count: count.saturating_add(FURTHER_MODES) };
    let samples = search.samples()?;
    let known = samples.iter().map(|sample| sample.modes.len()).min().unwrap_or(0);
    let mut found: Vec<Mode> = Vec::new();
    let mut refused: Vec<(Complex64, AnalysisError)> = Vec::new();
    let mut end = |sample: &LinearModes, index: usize| {
        let mode = &sample.modes[index];
        // The coefficients have no effect on a rigid-body motion.
        let is_inside = mode.eigenvalue.norm() == 0.0 || mode.eigenvalue.im == sample.frequency;
        match if is_inside { Ok(()) } else { cached.at(speed, mode.eigenvalue.im).map(drop) } {
            Ok(()) => found.push(mode.clone()),
            Err(error) if outside == Outside::Refuse => {
                refused.push((mode.eigenvalue, search.named(error.into(), index)));
            }
            Err(_) => {}
        }
    };
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
        return Ok(Vec::new());
    };
    (0..known).filter(|index| first.distance(*index) <= 0.0).for_each(|index| end(first, index));
    (0..known).filter(|index| last.distance(*index) > 0.0).for_each(|index| end(last, index));
    for pair in samples.windows(2) {
        let mut index = 0;
        while index < known {
            let above = [pair[0].distance(index) > 0.0, pair[1].distance(index) > 0.0];
            let mut met = Vec::new();
            if above[0] != above[1] {
                met = search.between([&pair[0], &pair[1]], index, &found)?;
            }
            index += met.len().max(1);
            found.extend(met);
        }
    }
    found.sort_by(|a, b| ascending(a.eigenvalue, b.eigenvalue));
    found.truncate(count);
    let last = found.last().filter(|_| found.len() == count).map(|mode| mode.eigenvalue);
    let is_wanted = |value: Complex64| last.is_none_or(|last| ascending(value, last).is_lt());
    match refused.into_iter().find(|(value, _)| is_wanted(*value)) {
        Some((_, error)) => Err(error),
        None => Ok(found),
    }
}

/// A mode near `start` at its speed, with the coefficients of bearings at its own frequency; `None` if the iteration does not
/// converge.
///
/// # Errors
/// [`AnalysisError`] if a bearing has no coefficients at speed or frequency, or modal damping has no modes.
pub(super) fn mode_near(
    cached: &CachedModel,
    highest: Highest,
    start: &ModeAtSpeed,
) -> Result<Option<ModeAtSpeed>, AnalysisError> {
    let speed = start.speed;
    let near = |frequency: f64, start: &ModeAtSpeed| -> Result<Option<ModeAtSpeed>, AnalysisError> {
        let at = cached.at(speed, frequency)?;
        let modal = at.modal_damping(speed, highest)?;
        Ok(modal::mode_near(&at.model, modal.as_deref(), start))
    };
    let frequencies = cached.model.table_frequencies();
    let (Some(first), Some(last)) = (frequencies.first().copied(), frequencies.last().copied()) else {
        return near(0.0, start);
    };
    let mut frequency = start.eigenvalue.im.clamp(first, last);
    let (mut at, mut previous) = (start.clone(), None::<Sample>);
    for _ in 0..MAX_ITERATIONS {
        let Some(met) = near(frequency, &at)? else {
            return Ok(None);
        };
        let wanted = met.eigenvalue.im.clamp(first, last);
        let sample = Sample { at: frequency, value: wanted - frequency };
        at = met;
        let is_stalled = previous.is_some_and(|known| sample.value.abs() >= known.value.abs() / 2.0);
        if sample.value.abs() <= ROUND_OFF * wanted || is_stalled && sample.value.abs() <= EQUALITY_TOLERANCE * wanted {
            // Refuses a frequency outside the tables.
            cached.at(speed, at.eigenvalue.im)?;
            return Ok(Some(at));
        }
        let secant =
            previous.map(|known| frequency - sample.value * (frequency - known.at) / (sample.value - known.value));
        frequency = secant.filter(|next| next.is_finite()).unwrap_or(wanted).clamp(first, last);
        previous = Some(sample);
    }
    Ok(None)
}

/// The search of the modes at one speed.
struct Search<'a> {
    cached: &'a CachedModel,
    speed: f64,
    count: usize,
}

impl Search<'_> {
    /// The modes with the coefficients at a frequency, rad/s, in ascending order of their frequency.
    fn at(&self, frequency: f64) -> Result<LinearModes, AnalysisError> {
        let cached = &*self.cached.at(self.speed, frequency)?;
        let mut modes = linear_modes(cached, self.speed, self.count, ModeSelection::All)?;
        modes.sort_by(|a, b| a.eigenvalue.im.total_cmp(&b.eigenvalue.im));
        Ok(LinearModes { frequency, modes })
    }

    /// The modes at some frequencies of the tables, among them the first and the last one that all tables contain.
    fn samples(&self) -> Result<Vec<LinearModes>, AnalysisError> {
        let model = &self.cached.model;
        let all = model.table_frequencies();
        let contained =
            |frequency: &&f64| model.bearings.iter().all(|bearing| bearing.check_frequency(**frequency).is_ok());
        let mut knots: Vec<f64> = all.iter().filter(contained).copied().collect();
        if knots.is_empty() {
            knots = all;
        }
        let last = knots.len() - 1;
        let steps = last.min(MAX_SAMPLES - 1);
        (0..=steps).map(|step| self.at(knots[step * last / steps.max(1)])).collect()
    }

    /// The mode with a number between two frequencies at which μ_k − ω has different signs, and others with the same eigenvalue.
    fn between(&self, ends: [&LinearModes; 2], index: usize, known: &[Mode]) -> Result<Vec<Mode>, AnalysisError> {
        let [low, high] = ends;
        let nearer = if low.distance(index).abs() < high.distance(index).abs() { low } else { high };
        if !nearer.is_multiple(index) {
            let Mode { eigenvalue, shape, .. } = nearer.modes[index].clone();
            let start = ModeAtSpeed { speed: self.speed, eigenvalue, shape };
            let is_new = |met: &ModeAtSpeed| {
                let distance = |mode: &Mode| (mode.eigenvalue - met.eigenvalue).norm();
                known.iter().all(|mode| distance(mode) > ROOT_OF_ROUND_OFF * met.eigenvalue.norm())
            };
            let is_between = |met: &ModeAtSpeed| (low.frequency..=high.frequency).contains(&met.eigenvalue.im);
            let met = mode_near(self.cached, self.highest(), &start)?;
            if let Some(met) = met.filter(|met| is_between(met) && is_new(met)) {
                let cached = self.cached.at(self.speed, met.eigenvalue.im)?;
                let modal = cached.modal_damping(self.speed, self.highest())?;
                let pair = Eigenpair { value: met.eigenvalue, shape: met.shape };
                return Ok(modal::modes_of(&cached, self.speed, modal.as_deref(), [pair].into_iter())?);
            }
        }
        let sample = |end: &LinearModes| Sample { at: end.frequency, value: end.distance(index) };
        let frequency = root([sample(low), sample(high)], |frequency| {
            self.at(frequency).map(|found| found.modes.get(index).map_or(f64::INFINITY, |_| found.distance(index)))
        })?;
        let found = self.at(frequency)?;
        let value = found.modes[index].eigenvalue;
        if (value.im - frequency).abs() > EQUALITY_TOLERANCE * frequency {
            let message = format!(
                "mode {} at {} rad/s: no frequency near {frequency:.6} rad/s agrees with that of its bearing coefficients, which change too fast there; give more frequencies in the table",
                index + 1,
                self.speed
            );
            return Err(AnalysisError::Convergence(message));
        }
        let equals = |mode: &&Mode| (mode.eigenvalue - value).norm() <= ROOT_OF_ROUND_OFF * value.norm();
        Ok(found.modes[index..].iter().take_while(equals).cloned().collect())
    }

    /// Which undamped modes have modal damping.
    fn highest(&self) -> Highest {
        highest_damped(&self.cached.model, self.count)
    }

    /// An error of the mode with a number.
    fn named(&self, error: AnalysisError, index: usize) -> AnalysisError {
        match error {
            AnalysisError::Scene(SceneError { path, message }) => {
                let message = format!("mode {} at {} rad/s: {message}", index + 1, self.speed);
                SceneError { path, message }.into()
            }
            other => other,
        }
    }
}
