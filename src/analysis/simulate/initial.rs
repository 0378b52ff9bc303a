//! The state that a run begins with.

use nalgebra::DVector;

use super::super::synchronous::{motion, synchronous};
use super::super::{AnalysisError, equilibrium};
use super::{Initial, Options};
use crate::integrate::State;
use crate::mesh::Geometry;
use crate::modal::Basis;
use crate::motion::phase;
use crate::scene::SceneError;

/// A tolerance is relative to no less than this part of the energy norm of the equilibrium: what round-off leaves of it.
const FLOOR: f64 = 1e-9;

/// Where and how a run begins.
pub(super) struct Start {
    /// Time that elapsed time counts from, s.
    pub origin: f64,
    /// The equilibrium that deviations are measured from.
    pub equilibrium: DVector<f64>,
    /// The smallest energy norm that a tolerance is relative to.
    pub floor: f64,
    /// The state.
    pub state: State,
}

/// The beginning that the options ask for.
pub(super) fn start(basis: &Basis, options: &Options) -> Result<Start, AnalysisError> {
    let model = &basis.model;
    let n = model.len();
    let found = equilibrium(basis, options.geometry, options.speed);
    let zero = || DVector::zeros(n);
    let (displacement, state, origin) = match &options.initial {
        // From rest a scene may move that has no equilibrium; tolerances are then relative to the motion itself.
        Initial::Rest => (found.unwrap_or_else(|_| zero()), State::new(vec![0.0; 2 * n]), options.start),
        Initial::Continue(last) => {
            if last.state.y.len() != 2 * n {
                let message = format!("has {} degrees of freedom, this system has {n}", last.state.y.len() / 2);
                return Err(SceneError::new("initial", message).into());
            }
            let displacement = found.unwrap_or_else(|_| zero());
            if options.resumes(last) {
                (displacement, last.state.clone(), last.origin)
            } else {
                let at = last.origin + last.state.elapsed;
                (displacement, State::new(last.state.y.clone()), at)
            }
        }
        Initial::Static => {
            let found = found?;
            let y = [found.as_slice(), zero().as_slice()].concat();
            (found, State::new(y), options.start)
        }
        Initial::Synchronous => {
            let found = found?;
            let amplitudes = synchronous(basis, options.speed)?;
            let turns: Vec<_> =
                model.shafts.iter().map(|shaft| phase(shaft.ratio * options.speed, options.start)).collect();
            let (q, v) = motion(basis, options.speed, &amplitudes, &turns);
            let y = [(&found + q).as_slice(), v.as_slice()].concat();
            (found, State::new(y), options.start)
        }
    };
    let mut norm = crate::motion::Motion::new(basis, Geometry::Frozen, options.speed, origin, zero())?;
    let whole = [displacement.as_slice(), zero().as_slice()].concat();
    let floor = FLOOR * crate::integrate::System::norm(&mut norm, &whole);
    Ok(Start { origin, equilibrium: displacement, floor: floor.max(f64::MIN_POSITIVE), state })
}
