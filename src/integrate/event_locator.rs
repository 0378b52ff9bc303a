//! Contact changes within a Runge–Kutta step.
//!
//! The contact mode is constant within a step. If another mode holds within the step or at its end, bisection on the
//! interpolated motion locates the change, the driver repeats the step up to it, and adopts the new mode as it was found:
//! round-off may put the state at the change itself on either side.
//!
//! The exponential method has its own locator, `exponential::ExponentialEventLocator`, because its steps are long and end
//! at units of a time grid.

use super::{FirstOrderSystem, Halt, Span, State};
use crate::numerics::{EQUALITY_TOLERANCE, bisect};

/// Fractions of the step at which the contact mode is evaluated.
const EVALUATED_FRACTIONS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// A contact change is located to this fraction of the step.
const EVENT_RESOLUTION: f64 = 1e-13;
/// Contact changes at one instant after which a step is accepted as it is: grazing contact could change its mode for ever.
pub const MAX_CHANGES_AT_ONE_TIME: u32 = 8;

/// Where in a step the contact mode changes.
#[derive(Clone, Copy, Debug)]
pub(super) enum ChangeLocation {
    /// At the beginning: the new mode is adopted and the step repeated.
    AtBeginning,
    /// At this time after the beginning, s: the step ends there.
    Within(f64),
    /// At the end.
    AtEnd,
}

/// Locates contact changes within a Runge–Kutta step.
pub(super) struct RungeKuttaEventLocator {
    /// Contact modes at the fraction of the step that was evaluated last, as integer codes.
    pub new_contact_modes: Vec<i64>,
    /// Scratch: an interpolated state.
    interpolated: Vec<f64>,
}

impl RungeKuttaEventLocator {
    /// Adopts the contact modes of the initial state. None if the system has no contact modes.
    pub fn new(system: &mut impl FirstOrderSystem, state: &mut State) -> Result<Option<Self>, Halt> {
        if system.switching().is_none() {
            return Ok(None);
        }
        if state.contact_modes.is_empty() {
            system.contact_modes_at(state.elapsed, &state.y, &mut state.contact_modes)?;
        }
        system.set_contact_modes(&state.contact_modes);
        let interpolated = vec![0.0; state.y.len()];
        Ok(Some(Self { new_contact_modes: state.contact_modes.clone(), interpolated }))
    }

    /// Finds the first contact change within a step from `state`. The new modes are left in
    /// [`Self::new_contact_modes`].
    pub fn locate(
        &mut self,
        system: &mut impl FirstOrderSystem,
        state: &State,
        span: &Span<'_>,
    ) -> Result<Option<ChangeLocation>, Halt> {
        // Flanks may separate and meet again before the end of the step.
        let mut first = None;
        for part in EVALUATED_FRACTIONS {
            if self.differs(system, state, span, part)? {
                first = Some(part);
                break;
            }
        }
        let Some(first) = first else {
            return Ok(None);
        };
        let [_, high] = bisect(0.0, first, EVENT_RESOLUTION, |part| self.differs(system, state, span, part))?;
        self.differs(system, state, span, high)?;
        // A change at an end of the step takes that end: no step is shorter.
        Ok(Some(match high {
            high if high <= EQUALITY_TOLERANCE => ChangeLocation::AtBeginning,
            high if high >= 1.0 - EQUALITY_TOLERANCE => ChangeLocation::AtEnd,
            high => ChangeLocation::Within(high * span.step),
        }))
    }

    /// Whether the contact modes at a fraction of the step differ from those of `state`.
    fn differs(
        &mut self,
        system: &mut impl FirstOrderSystem,
        state: &State,
        span: &Span<'_>,
        part: f64,
    ) -> Result<bool, Halt> {
        let elapsed = if part < 1.0 { span.start + part * span.step } else { span.start + span.step };
        system.within(span, elapsed, &mut self.interpolated);
        system.contact_modes_at(elapsed, &self.interpolated, &mut self.new_contact_modes)?;
        Ok(self.new_contact_modes != state.contact_modes)
    }
}
