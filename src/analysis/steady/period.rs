//! Common period of everything that a scene excites.
//!
//! Frequencies are exact ratios of tooth numbers to the speed of the reference shaft, so that the common period is
//! 1/gcd of them. It is one revolution of a shaft, one mesh cycle, or the hunting-tooth period of a train.

use std::f64::consts::TAU;

use crate::analysis::AnalysisError;
use crate::mesh::{GearMesh, Geometry};
use crate::model::Model;
use crate::numerics::ROUND_OFF;
use crate::scene::{LoadLaw, Scene, SceneError};

/// Largest denominator of an order that is not a ratio of tooth numbers, for example that of a force.
const LARGEST_DENOMINATOR: u64 = 1000;

/// What to do without a common period.
const RUN_IN_INSTEAD: &str = "or run in with simulate()";

/// A ratio of two whole numbers without a common divisor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Ratio {
    numerator: i128,
    /// Positive.
    denominator: i128,
}

impl Ratio {
    const ZERO: Self = Self { numerator: 0, denominator: 1 };
    const ONE: Self = Self { numerator: 1, denominator: 1 };

    /// The ratio; none for the denominator zero.
    fn new(numerator: i128, denominator: i128) -> Option<Self> {
        let divisor = gcd(numerator, denominator).checked_mul(denominator.signum())?;
        (divisor != 0).then(|| Self { numerator: numerator / divisor, denominator: denominator / divisor })
    }

    /// The sum; none on overflow.
    fn plus(self, other: Self) -> Option<Self> {
        let numerator = self.numerator.checked_mul(other.denominator)?;
        let numerator = numerator.checked_add(other.numerator.checked_mul(self.denominator)?)?;
        Self::new(numerator, self.denominator.checked_mul(other.denominator)?)
    }

    /// The product with `numerator`/`denominator`; none on overflow.
    fn times(self, numerator: i128, denominator: i128) -> Option<Self> {
        Self::new(self.numerator.checked_mul(numerator)?, self.denominator.checked_mul(denominator)?)
    }

    /// The largest ratio of which both are multiples; none on overflow.
    fn common(self, other: Self) -> Option<Self> {
        let divisor = gcd(self.denominator, other.denominator);
        let denominator = (self.denominator / divisor).checked_mul(other.denominator)?;
        Self::new(gcd(self.numerator, other.numerator), denominator)
    }

    /// The ratio of whole numbers that a positive number is up to round-off, by its continued fraction; none if there is
    /// none with a denominator up to [`LARGEST_DENOMINATOR`].
    fn of(value: f64) -> Option<Self> {
        if !(value.is_finite() && value > 0.0 && value < 1e9) {
            return None;
        }
        let ([mut p, mut q], mut rest) = ([[0_u64, 1], [1, 0]], value);
        loop {
            let whole = rest.floor();
            p = [p[1], (whole as u64).checked_mul(p[1])?.checked_add(p[0])?];
            q = [q[1], (whole as u64).checked_mul(q[1])?.checked_add(q[0])?];
            if q[1] > LARGEST_DENOMINATOR {
                return None;
            }
            if (p[1] as f64 / q[1] as f64 - value).abs() <= ROUND_OFF * value {
                return Self::new(i128::from(p[1]), i128::from(q[1]));
            }
            rest = (rest - whole).recip();
        }
    }

    fn value(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }
}

/// A frequency of the excitation.
struct Source {
    /// What excites.
    name: String,
    /// Frequency over that of the reference shaft; none if it is unknown.
    order: Option<f64>,
    /// The same as an exact ratio, if it is one.
    exact: Option<Ratio>,
}

/// Finds the common period of the excitation at a speed of the reference shaft, rad/s: `given`, or that of the scene, which
/// must not exceed `longest`, s.
///
/// # Errors
/// [`SceneError`] that names the frequencies if there is no period, or if it is too long.
pub fn common_period(model: &Model, speed: f64, given: Option<f64>, longest: f64) -> Result<f64, AnalysisError> {
    if let Some(period) = given {
        return Ok(period);
    }
    let sources = sources(model);
    let error = |reason: &str, action: &str| {
        let listed: Vec<String> = sources.iter().map(|source| source.description(speed)).collect();
        let listed = if listed.is_empty() { String::new() } else { format!(" ({})", listed.join(", ")) };
        AnalysisError::from(SceneError::new("period", format!("{reason}{listed}; {action}")))
    };
    if sources.is_empty() {
        return Err(error("nothing in the scene excites a periodic motion", "use static(), or give period="));
    }
    if speed == 0.0 {
        return Err(error("nothing rotates at speed 0", "give a speed, or period= for loads over time"));
    }
    let action = format!("give period= if you know one, {RUN_IN_INSTEAD}");
    let same = |a: f64, b: f64| (a - b).abs() <= ROUND_OFF * a.abs();
    let first = sources[0].order;
    let order = if sources.iter().all(|source| source.order.zip(first).is_some_and(|(a, b)| same(a, b))) {
        first
    } else {
        let mut exact = sources.iter().map(|source| source.exact);
        let first = exact.next().flatten();
        exact.fold(first, |common, next| common?.common(next?)).map(Ratio::value)
    };
    let Some(order) = order else {
        return Err(error("the frequencies have no common period", &action));
    };
    let period = TAU / (order * speed.abs());
    if period > longest {
        let reason =
            format!("the common period of the excitation is {period:.4} s, longer than max_period = {longest} s");
        return Err(error(&reason, &format!("give a larger max_period, {RUN_IN_INSTEAD}")));
    }
    Ok(period)
}

/// Whether the equation of motion is linear with constant coefficients, apart from given loads over time and angle: then
/// the steady motions of several sources superpose.
pub fn has_constant_coefficients(model: &Model, geometry: Geometry) -> bool {
    let mesh_is_constant = |mesh: &GearMesh| {
        mesh.teeth.is_constant()
            && !mesh.teeth.is_relieved()
            && mesh.backlash.is_none()
            && !mesh.has_runout()
            && mesh.friction.is_none()
            // Without bending, the line of action does not move.
            && (geometry == Geometry::Frozen || mesh.coordinates.translation.is_none())
    };
    model.nonlinear_bearings.is_empty()
        && model.meshes.iter().all(mesh_is_constant)
        && !model.loads.iter().any(|load| matches!(load.law, LoadLaw::SpeedTorque { .. }))
}

/// Longest period of a source at a speed of the reference shaft, rad/s, in s. None if nothing rotates or excites, or if a
/// load has an unknown frequency.
pub fn slowest_period(model: &Model, speed: f64) -> Option<f64> {
    let orders: Option<Vec<f64>> = sources(model).into_iter().map(|source| source.order).collect();
    let lowest = orders?.into_iter().reduce(f64::min)?;
    (speed != 0.0).then(|| TAU / (lowest * speed.abs()))
}

impl Source {
    fn exact(name: String, ratio: Option<Ratio>, order: f64) -> Self {
        Self { name, order: Some(order), exact: ratio }
    }

    fn description(&self, speed: f64) -> String {
        match self.order {
            Some(order) => format!("{:.6} Hz: {}", order * speed.abs() / TAU, self.name),
            None => format!("unknown: {}", self.name),
        }
    }
}

/// All frequencies of the excitation.
fn sources(model: &Model) -> Vec<Source> {
    let scene = &model.scene;
    let ratios = speed_ratios(scene);
    let shaft = |index: usize, what: &str| {
        let name = format!("{what} of shaft \"{}\"", scene.shafts[index].name);
        Source::exact(name, ratios[index], scene.speed_ratios[index].abs())
    };
    let turning = |index: &usize| {
        // Bow and unbalance of a carrier are constant in its frame.
        !model.shafts[*index].excitations.is_empty() && model.shafts[*index].ratio_in_frame() != 0.0
    };
    let mut sources: Vec<Source> = (0..scene.shafts.len())
        .filter(turning)
        .map(|index| {
            let name = format!("bow, unbalance or turning force of shaft \"{}\"", scene.shafts[index].name);
            let frame = scene.frame_of(index).map_or(Some(Ratio::ZERO), |carrier| ratios[carrier]);
            let exact = frame.zip(ratios[index]).and_then(|(frame, own)| own.plus(frame.times(-1, 1)?));
            Source::exact(name, exact, model.shafts[index].ratio_in_frame().abs())
        })
        .collect();
    // What is seen from the ground repeats after whole revolutions of the frames that turn.
    sources.extend(scene.carriers().into_iter().map(|index| shaft(index, "rotation of the carrier")));
    for (index, mesh) in scene.meshes.iter().enumerate() {
        let [driver, driven] = [mesh.driver, mesh.driven].map(|gear| &scene.gears[gear]);
        let [first, second] = [driver, driven].map(|gear| gear.body.node.shaft);
        let error = mesh.teeth.error.as_ref();
        if !model.meshes[index].teeth.is_constant()
            || error.is_some_and(|error| !error.tooth.is_empty() || !error.table.is_empty())
        {
            let name = format!("teeth of mesh \"{}\"-\"{}\"", driver.body.name, driven.body.name);
            let carrier = mesh.carrier.map_or(Some(Ratio::ZERO), |node| ratios[node.shaft]);
            let relative = carrier.zip(ratios[first]).and_then(|(carrier, own)| own.plus(carrier.times(-1, 1)?));
            let exact = relative.and_then(|ratio| ratio.times(i128::from(driver.teeth), 1));
            sources.push(Source::exact(name, exact, scene.mesh_order(mesh)));
        }
        let harmonics = [(first, error.map(|e| &e.driver)), (second, error.map(|e| &e.driven))];
        for (at, harmonics) in harmonics {
            if harmonics.is_some_and(|harmonics| !harmonics.is_empty()) {
                sources.push(shaft(at, "transmission error"));
            }
        }
        let out = [driver, driven].into_iter().filter(|gear| gear.runout.norm() > 0.0);
        sources.extend(out.map(|gear| shaft(gear.body.node.shaft, "run-out on a gear")));
    }
    sources.extend(loads(model, &ratios));
    sources.extend(model.nonlinear_bearings.iter().filter_map(|bearing| {
        let order = bearing.elements()? as f64 * bearing.ratio.abs();
        let name = format!("rolling elements of bearings[{}]", bearing.number);
        Some(Source::exact(name, Ratio::of(order), order))
    }));
    sources
}

/// Frequencies of the varying loads.
fn loads<'a>(model: &'a Model, ratios: &'a [Option<Ratio>]) -> impl Iterator<Item = Source> + 'a {
    model.loads.iter().filter_map(|load| {
        let name = load.path.clone();
        match &load.law {
            LoadLaw::Turning { order, .. } if *order != 0.0 => {
                let exact = Ratio::of(order.abs()).zip(ratios[load.shaft]);
                let exact = exact.and_then(|(order, ratio)| ratio.times(order.numerator, order.denominator));
                Some(Source::exact(name, exact, (order * load.ratio).abs()))
            }
            LoadLaw::Turning { .. } | LoadLaw::SpeedTorque { .. } => None,
            LoadLaw::Force(_) | LoadLaw::Torque(_) => {
                Some(Source { name: format!("{name} over time"), order: None, exact: None })
            }
        }
    })
}

/// Speed ratio of each shaft to the reference shaft; none where the numbers are too large.
fn speed_ratios(scene: &Scene) -> Vec<Option<Ratio>> {
    let given = |ratio: f64| {
        if ratio == 0.0 { Some(Ratio::ZERO) } else { Ratio::of(ratio.abs())?.times(ratio.signum() as i128, 1) }
    };
    let mut ratios: Vec<Option<Ratio>> = scene.shafts.iter().map(|shaft| given(shaft.speed_ratio?)).collect();
    let reference = scene.speed_ratios.iter().position(|ratio| *ratio == 1.0).unwrap_or(0);
    ratios[reference] = Some(Ratio::ONE);
    let relations = scene.speed_relations();
    // Each pass reaches at least one more shaft.
    for _ in 0..scene.shafts.len() {
        for entries in &relations {
            let mut unknown = entries.iter().filter(|(shaft, _)| ratios[*shaft].is_none());
            if let (Some((shaft, factor)), None) = (unknown.next(), unknown.next()) {
                let mut known = entries.iter().filter(|(other, _)| other != shaft);
                let term = |(other, factor): &(usize, i128)| ratios[*other]?.times(-factor, 1);
                let sum = known.try_fold(Ratio::ZERO, |sum, entry| sum.plus(term(entry)?));
                ratios[*shaft] = sum.and_then(|sum| sum.times(1, *factor));
            }
        }
    }
    ratios
}

fn gcd(a: i128, b: i128) -> i128 {
    let [mut a, mut b] = [a, b].map(i128::saturating_abs);
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_exact_ratios() {
        let third = Ratio::of(1.0 / 3.0);
        assert_eq!(third, Ratio::new(1, 3));
        assert_eq!(Ratio::of(2.5), Ratio::new(5, 2));
        assert_eq!(Ratio::of(std::f64::consts::PI), None);
        // A shaft at 25/50 and a mesh at 25 repeat after two revolutions; 23/47 after 47.
        assert_eq!(Ratio::new(1, 2).and_then(|a| a.common(Ratio::ONE)), Ratio::new(1, 2));
        assert_eq!(Ratio::new(23, 47).and_then(|a| a.common(Ratio::ONE)), Ratio::new(1, 47));
    }
}
