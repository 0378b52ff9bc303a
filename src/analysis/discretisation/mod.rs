//! Number and degree of the shaft elements, chosen from the scene where it does not give them.
//!
//! Teeth that enter and leave contact are steps of the load on the meshes. A run from rest or from the equilibrium begins
//! with a step of bow, unbalance, torques and gravity. Loads over time count by the free vibration that they leave in each
//! mode, which is that of a step at any time. The response to a step shows which modes it excites, with which
//! amplitude, and how fast they decay. An element changes the natural frequencies. Within the
//! time T, the change Δω of a frequency becomes a phase error Δω·T, unless damping decays the mode before. The expected
//! error is the RMS of the difference between the step responses with ω and with ω + Δω, relative to the RMS of the
//! response. A mesh has its least, its mean and its largest stiffness: between two engagements of teeth, the modes are those
//! of the momentary stiffness. Of all degrees and element lengths that meet the level, those with the fewest coordinates are
//! chosen; then the degree of single shafts and the number of elements of single segments decrease while the level is met.
//! The model whose modes are examined must meet the level itself. Otherwise the chosen elements are examined in turn.
//!
//! The speed is not known when the elements are chosen. At a speed at which a harmonic of the tooth frequency is close to a
//! natural frequency, one mode dominates the motion, and its error is that of the motion. [`ElementErrors`] know the speed.
//!
//! `excited_modes` finds the modes, `varying_loads` what loads over time excite, `parts` divides a large system, `layout` has the
//! elements of a shaft and their error, `tooth_harmonics` the error at a speed, `variation` the elements of a scene with other loads.

mod excited_modes;
mod layout;
mod parts;
mod tooth_harmonics;
mod variation;
mod varying_loads;

pub use variation::resolve_variation;

use super::{AnalysisError, Interrupt};
use excited_modes::{Excitation, ExcitedMode, LARGEST_TO_CHOOSE, LARGEST_TO_ESTIMATE, excitation};
use layout::Layout;
use parts::resolve_parts;
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;
use tooth_harmonics::{TOOTH_CYCLE_SAMPLES, ToothResponse};
use variation::Probe;
use varying_loads::highest_tone;

use crate::element::{BendingFunction, rod_degrees};
use crate::linalg::DecompositionError;
use crate::mesh::GearMesh;
use crate::modal::CachedModel;
use crate::model::Model;
use crate::scene::{Accuracy, COMPARED_DURATION, MAX_DEGREE, Scene, SceneDescription, SceneError};

/// Degree of the elements of the model whose modes are examined.
const PROBE_DEGREE: usize = 4;
/// Longest element of that model, in diameters of the shaft.
const PROBE_LENGTH: f64 = 10.0;
/// Largest number of elements of a shaft of that model that is due to this length.
const PROBE_ELEMENTS: f64 = 8.0;
/// Safety factor on the error of the step response. Without it, the measured error of mesh forces is between 1/200 and 0.9
/// of that error in the calibration scenes of `benches/accuracy`. Where a harmonic of the tooth frequency is close to a
/// lightly damped natural frequency, the responses to successive steps add up, and it is up to 1.2 times as large.
const STEP_RESPONSE_SAFETY: f64 = 2.0;
/// Further safety factor on displacements at [`Accuracy::Reference`]. Where teeth separate, a difference of the instants
/// of impact adds to that of the frequencies. Without this factor, the error of a displacement in random scene 1 of
/// `benches/accuracy` is 1.2e-6, and the expected one at most 9.2e-7.
const FINE_DISPLACEMENT_SAFETY: f64 = 2.0;
/// Ratio between successive element lengths that are examined.
const LENGTH_RATIO: f64 = 0.8;
/// Increases of the error for each saved coordinate count as equal up to this part of the permitted error. Equal shafts and
/// segments have equal increases except for round-off.
const PRICE_TOLERANCE: f64 = 1e-6;
/// Number of element lengths that are examined.
const EXAMINED_LENGTHS: i32 = 16;
/// Largest number of models that are examined until one meets the level.
const MAX_PROBES: usize = 4;
/// Largest number of coordinates that is chosen.
const MAX_COORDINATES: usize = 1200;
/// Relative error of a natural frequency that counts as resolved.
const RESOLVED_FREQUENCY_ERROR: f64 = 1e-3;

/// Numbers and degrees of the elements of a scene, and what to expect of them.
#[derive(Clone, Debug)]
pub struct Resolved {
    /// The description with numbers and degrees for every shaft.
    pub description: SceneDescription,
    /// The chosen elements; `None` if the scene gives all numbers.
    pub choice: Option<Choice>,
    /// The model whose modes were examined; `None` if none were.
    probe: Option<Arc<Probe>>,
}

/// The chosen elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The level that they meet.
    pub level: Accuracy,
    /// Expected error of mesh forces, or of displacements in a scene without meshes: RMS of the difference over RMS of the
    /// variation.
    pub expected_error: f64,
    /// Largest error that the level permits.
    pub permitted_error: f64,
    /// Highest frequency whose waves the elements represent with a relative error of 1e-3, rad/s.
    pub highest_frequency: f64,
}

/// Chooses number and degree of the elements where a description does not give them. The choice does not depend on `base`, whose
/// modes serve again where the two differ in loads only.
///
/// # Errors
/// [`AnalysisError`] if the scene is invalid, or `interrupt` requests a stop.
pub fn resolve(
    given: &SceneDescription,
    base: Option<&Resolved>,
    interrupt: &Interrupt,
) -> Result<Resolved, AnalysisError> {
    let automatic: Vec<usize> =
        given.shafts.iter().enumerate().filter(|(_, shaft)| shaft.is_automatic()).map(|(index, _)| index).collect();
    if automatic.is_empty() {
        return Ok(Resolved { description: given.clone(), choice: None, probe: None });
    }
    let level = given.accuracy.unwrap_or_default();
    // One element between any two places of parts; this scene is checked as the final one.
    let plain = with_elements(given, &automatic, |_| Elements { degree: 1, counts: Vec::new() });
    let scene = Scene::new(&plain)?;
    let layouts: Vec<Layout> =
        automatic.iter().map(|index| Layout::new(&given.shafts[*index], &scene.shafts[*index])).collect();
    let tone = highest_tone(&scene);
    let first = |i: usize| {
        let shaft = &scene.shafts[automatic[i]];
        let diameter = shaft.elements.iter().map(|element| 2.0 * element.outer_radius()).fold(f64::INFINITY, f64::min);
        let longest = (PROBE_LENGTH * diameter).max(shaft.length() / PROBE_ELEMENTS);
        Elements {
            degree: given.shafts[automatic[i]].degree.unwrap_or(PROBE_DEGREE),
            counts: layouts[i].counts_for(tone, longest, PROBE_DEGREE),
        }
    };
    let mut chosen: Vec<Elements> = (0..automatic.len()).map(first).collect();
    let mut examined = 0;
    loop {
        examined += 1;
        interrupt.check()?;
        let probe = with_elements(given, &automatic, |i| chosen[i].clone());
        let model = Model::new(Scene::new(&probe)?)?;
        if model.len() > LARGEST_TO_CHOOSE
            && let Some(resolved) = resolve_parts(given, &scene, interrupt)?
        {
            return Ok(resolved);
        }
        let permitted_error = permitted(level, model.meshes.is_empty());
        let known = at_lowest_speed(model.clone()).map(contact_phases).ok();
        if let (Some(phases), Some(base)) = (&known, base.and_then(|base| base.probe.as_ref())) {
            base.share(&probe, phases);
        }
        let known = known
            .and_then(|phases| excitations(&phases, LARGEST_TO_CHOOSE).ok().map(|excitations| (phases, excitations)));
        let Some((phases, excitations)) = known else {
            // Tables without a common speed, or a decomposition that fails: an analysis of the scene reports it.
            let choice = Choice { level, expected_error: f64::NAN, permitted_error, highest_frequency: f64::NAN };
            return Ok(Resolved { description: probe, choice: Some(choice), probe: None });
        };
        let weight = displacement_weight(level, &model);
        let search = Search::new(given, &automatic, &layouts, &excitations, weight, &model);
        let best = search.best(permitted_error, interrupt)?;
        let is_accurate = search.of(&chosen).error <= permitted_error;
        chosen = best.shafts.iter().map(|shaft| shaft.elements.clone()).collect();
        // Elements that do not meet the level have the largest number of coordinates: the next model is not better.
        if !is_accurate && best.error <= permitted_error && examined < MAX_PROBES {
            continue;
        }
        let highest = |i: usize| {
            layouts[i].highest_frequency(&best.shafts[i].lengths, chosen[i].degree, RESOLVED_FREQUENCY_ERROR)
        };
        let choice = Choice {
            level,
            expected_error: best.error.min(1.0),
            permitted_error,
            highest_frequency: (0..layouts.len()).map(highest).fold(f64::INFINITY, f64::min),
        };
        let description = with_elements(given, &automatic, |i| chosen[i].clone());
        let probe = Probe { description: probe, model, phases, automatic, layouts, chosen };
        return Ok(Resolved { description, choice: Some(choice), probe: Some(Arc::new(probe)) });
    }
}

/// The model with the mean, the least and the largest stiffness of its meshes over the tooth cycle; the model alone if none
/// varies.
fn contact_phases(model: Model) -> Vec<CachedModel> {
    let range = |(index, mesh): (usize, &GearMesh)| {
        let cycle = mesh.tooth_cycle(model.sigma(index, 0.0), TOOTH_CYCLE_SAMPLES);
        let stiffnesses = cycle.iter().map(|teeth| teeth.stiffness);
        // Teeth with a contact ratio below 1 separate in every cycle: no mode describes this.
        let stiffnesses = stiffnesses.filter(|stiffness| *stiffness > 0.0);
        stiffnesses.fold([mesh.stiffness; 2], |[least, most], k| [k.min(least), k.max(most)])
    };
    let ranges: Vec<[f64; 2]> = model.meshes.iter().enumerate().map(range).collect();
    let with = |bound: usize| {
        let mut model = model.clone();
        model.meshes.iter_mut().zip(&ranges).for_each(|(mesh, range)| mesh.stiffness = range[bound]);
        model
    };
    let varies = model.meshes.iter().any(|mesh| !mesh.teeth.is_constant());
    let bounds = if varies { vec![with(0), with(1)] } else { Vec::new() };
    [model].into_iter().chain(bounds).map(CachedModel::new).collect()
}

fn excitations(phases: &[CachedModel], largest: usize) -> Result<Vec<Excitation>, DecompositionError> {
    phases.iter().map(|phase| excitation(phase, largest)).collect()
}

/// The model with the bearing coefficients of the lowest speed and frequency that all tables contain. Nonlinear bearings have a
/// stiffness that follows from the weight of their shafts, because the loads and speeds of the analyses are not known.
fn at_lowest_speed(model: Model) -> Result<Model, SceneError> {
    let model = if model.nonlinear_bearings.is_empty() { model } else { model.with_initial_operating_points() };
    if model.bearings.is_empty() && !model.circulates() {
        return Ok(model);
    }
    model.at_frequency(model.lowest_frequency())?.with_tables_at(model.lowest_speed().unwrap_or(0.0))
}

/// Errors to expect of the elements of a model.
#[derive(Debug)]
pub struct ElementErrors {
    /// Error at any speed.
    error: f64,
    /// The response to the teeth, which have a harmonic close to a natural frequency at some speeds; none without meshes.
    teeth: Option<ToothResponse>,
}

impl ElementErrors {
    /// The errors of the elements of a model.
    ///
    /// # Errors
    /// [`AnalysisError`] if the modes cannot be computed.
    pub fn new(resolved: &Resolved, cached: &CachedModel) -> Result<Self, AnalysisError> {
        let (given, scene) = (&resolved.description, &cached.model.scene);
        let automatic: Vec<usize> = (0..scene.shafts.len()).collect();
        // Every node counts as a place of a part, so that the elements are those of the model.
        let layouts: Vec<Layout> =
            given.shafts.iter().zip(&scene.shafts).map(|(given, shaft)| Layout::new(given, shaft)).collect();
        let phases = contact_phases(at_lowest_speed(cached.model.clone())?);
        if !cached.model.needs_speed() {
            phases[0].share(cached);
        }
        let known = resolved.choice.as_ref().map(|choice| choice.expected_error);
        let excitations = if known.is_none() { excitations(&phases, LARGEST_TO_ESTIMATE)? } else { Vec::new() };
        let weight = displacement_weight(Accuracy::Engineering, &cached.model);
        let search = Search::new(given, &automatic, &layouts, &excitations, weight, &cached.model);
        let elements = search.uniform(1, f64::INFINITY);
        let has_teeth = !cached.model.meshes.is_empty();
        let teeth = has_teeth.then(|| ToothResponse::new(&search, &phases[0], &elements)).transpose()?;
        Ok(Self { error: known.unwrap_or(elements.error), teeth })
    }

    /// Expected error of mesh forces, or of displacements in a scene without meshes: RMS of the difference over RMS of the
    /// variation. At a constant speed of the reference shaft, rad/s, it contains the response to the teeth.
    pub fn expected(&self, speed: Option<f64>) -> f64 {
        let at_speed = self.teeth.as_ref().zip(speed.filter(|speed| *speed != 0.0));
        at_speed.map_or(self.error, |(teeth, speed)| self.error.max(teeth.error(speed))).min(1.0)
    }
}

/// Weight of the errors of displacements beside those of mesh forces: the ratio of the permitted errors, and a safety
/// factor. It is 1 for a scene without meshes, whose errors are those of displacements.
fn displacement_weight(level: Accuracy, model: &Model) -> f64 {
    if model.meshes.is_empty() {
        return 1.0;
    }
    let safety = if level == Accuracy::Reference { FINE_DISPLACEMENT_SAFETY } else { 1.0 };
    safety * permitted(level, false) / permitted(level, true)
}

/// Largest error of mesh forces, or of displacements in a scene without meshes.
fn permitted(accuracy: Accuracy, meshless: bool) -> f64 {
    let level = accuracy.level();
    if meshless { level.displacement } else { level.mesh_force }
}

/// The description with the number of elements of each segment, and the degree, of the automatic shafts. Missing numbers
/// are 1.
fn with_elements(
    given: &SceneDescription,
    automatic: &[usize],
    elements: impl Fn(usize) -> Elements,
) -> SceneDescription {
    let mut description = given.clone();
    for (i, index) in automatic.iter().enumerate() {
        let Elements { degree, counts } = elements(i);
        let shaft = &mut description.shafts[*index];
        let count = |segment: usize| Some(counts.get(segment).copied().unwrap_or(1));
        match &mut shaft.segments {
            Some(segments) => {
                segments.iter_mut().enumerate().for_each(|(i, segment)| segment.elements = count(i));
            }
            None => shaft.elements = count(0),
        }
        shaft.degree = shaft.degree.or(Some(degree));
    }
    description
}

/// Elements of a shaft.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Elements {
    degree: usize,
    /// Number of elements of each segment.
    counts: Vec<usize>,
}

/// Elements of a shaft in a candidate.
struct ShaftElements {
    elements: Elements,
    /// Lengths of the elements of each segment, m.
    lengths: Vec<Vec<f64>>,
    /// Number of coordinates.
    coordinates: usize,
    /// What these elements add to the relative error of the frequency of each mode; the modes of one excitation follow those of
    /// another.
    errors: Vec<f64>,
}

/// Elements of the automatic shafts.
struct Candidate {
    shafts: Vec<Rc<ShaftElements>>,
    /// Number of coordinates.
    coordinates: usize,
    /// Expected error.
    error: f64,
}

/// The search for the cheapest elements.
struct Search<'a> {
    given: &'a SceneDescription,
    /// Indices of the shafts without given elements.
    automatic: &'a [usize],
    /// Their segments.
    layouts: &'a [Layout],
    /// Signals and modes for each stiffness of the meshes.
    excitations: &'a [Excitation],
    /// Weight of the errors of displacements beside those of mesh forces.
    weight: f64,
    model: &'a Model,
    /// Elements that were examined, for each of these shafts: most candidates differ from another one in one shaft.
    examined: Vec<RefCell<HashMap<Elements, Rc<ShaftElements>>>>,
}

impl<'a> Search<'a> {
    fn new(
        given: &'a SceneDescription,
        automatic: &'a [usize],
        layouts: &'a [Layout],
        excitations: &'a [Excitation],
        weight: f64,
        model: &'a Model,
    ) -> Self {
        let examined = automatic.iter().map(|_| RefCell::default()).collect();
        Self { given, automatic, layouts, excitations, weight, model, examined }
    }

    /// The candidate with the fewest coordinates that meets the permitted error; otherwise the most accurate one.
    ///
    /// # Errors
    /// [`AnalysisError`] if `interrupt` requests a stop.
    fn best(&self, permitted: f64, interrupt: &Interrupt) -> Result<Candidate, AnalysisError> {
        let mut best: Option<Candidate> = None;
        let mut most_accurate: Option<Candidate> = None;
        let longest = self.layouts.iter().map(Layout::longest).fold(0.0, f64::max);
        for degree in 2..=MAX_DEGREE {
            for i in 0..EXAMINED_LENGTHS {
                interrupt.check()?;
                let candidate = self.uniform(degree, longest * LENGTH_RATIO.powi(i));
                let cheapest = best.as_ref().map_or(MAX_COORDINATES, |best| best.coordinates);
                if candidate.coordinates >= cheapest && (best.is_some() || most_accurate.is_some()) {
                    break;
                }
                if candidate.error <= permitted {
                    best = Some(candidate);
                    break;
                }
                if most_accurate.as_ref().is_none_or(|known| candidate.error < known.error) {
                    most_accurate = Some(candidate);
                }
            }
        }
        let best = best.map(|best| self.trimmed(best, permitted, interrupt)).transpose()?;
        Ok(best.or(most_accurate).unwrap_or_else(|| self.uniform(PROBE_DEGREE, longest)))
    }

    /// Lowers the degree of a shaft or the number of elements of a segment, as long as the permitted error is met: first
    /// where the error increases least for each saved coordinate. Among equal increases, round-off must not decide: most saved
    /// coordinates, then the first shaft and segment.
    ///
    /// # Errors
    /// As [`Self::best`].
    fn trimmed(&self, mut best: Candidate, permitted: f64, interrupt: &Interrupt) -> Result<Candidate, AnalysisError> {
        loop {
            interrupt.check()?;
            let price = |coarser: &Candidate| {
                (coarser.error - best.error).max(0.0) / (best.coordinates - coarser.coordinates) as f64
            };
            let meets = |coarser: &Candidate| coarser.error <= permitted && coarser.coordinates < best.coordinates;
            let coarser: Vec<Candidate> = self.coarser(&best).into_iter().filter(meets).collect();
            let least = coarser.iter().map(price).fold(f64::INFINITY, f64::min);
            let cheapest = coarser.into_iter().filter(|coarser| price(coarser) <= least + PRICE_TOLERANCE * permitted);
            match cheapest.min_by_key(|coarser| coarser.coordinates) {
                Some(coarser) => best = coarser,
                None => return Ok(best),
            }
        }
    }

    /// The candidates with one degree less on one shaft, or one element less in one segment.
    fn coarser(&self, given: &Candidate) -> Vec<Candidate> {
        let mut all = Vec::new();
        for (i, shaft) in given.shafts.iter().enumerate() {
            let Elements { degree, counts } = &shaft.elements;
            let mut push = |elements: Elements| {
                let mut shafts = given.shafts.clone();
                shafts[i] = self.shaft(i, elements);
                all.push(self.candidate(shafts));
            };
            if *degree > 2 {
                push(Elements { degree: self.degree(i, degree - 1), counts: counts.clone() });
            }
            for (segment, count) in counts.iter().enumerate() {
                if let Some(fewer) = self.layouts[i].fewer(segment, *count) {
                    let mut counts = counts.clone();
                    counts[segment] = fewer;
                    push(Elements { degree: *degree, counts });
                }
            }
        }
        all
    }

    /// Degree of an automatic shaft: the given one, or `degree`.
    fn degree(&self, i: usize, degree: usize) -> usize {
        self.given.shafts[self.automatic[i]].degree.unwrap_or(degree)
    }

    /// The same degree for all shafts, and no element longer than `longest`, m.
    fn uniform(&self, degree: usize, longest: f64) -> Candidate {
        let layouts = self.layouts.iter().enumerate();
        let elements =
            layouts.map(|(i, layout)| Elements { degree: self.degree(i, degree), counts: layout.counts(longest) });
        self.of(&elements.collect::<Vec<_>>())
    }

    /// The candidate with these elements of each shaft.
    fn of(&self, elements: &[Elements]) -> Candidate {
        self.candidate(elements.iter().enumerate().map(|(i, elements)| self.shaft(i, elements.clone())).collect())
    }

    fn candidate(&self, shafts: Vec<Rc<ShaftElements>>) -> Candidate {
        let coordinates = shafts.iter().map(|shaft| shaft.coordinates).sum();
        let error = self.error(&shafts);
        Candidate { shafts, coordinates, error }
    }

    /// Elements of an automatic shaft, with what they cost and what error they cause.
    fn shaft(&self, i: usize, elements: Elements) -> Rc<ShaftElements> {
        let find = || {
            let lengths = self.layouts[i].lengths(&elements.counts);
            let modes = self.excitations.iter().flat_map(|excitation| &excitation.modes);
            let (layout, shaft) = (&self.layouts[i], self.automatic[i]);
            let error = |mode: &ExcitedMode| {
                layout.frequency_error(&lengths, elements.degree, mode.frequency, mode.energy[shaft])
            };
            Rc::new(ShaftElements {
                coordinates: self.coordinates(i, &elements.counts, elements.degree),
                errors: modes.map(error).collect(),
                elements: elements.clone(),
                lengths,
            })
        };
        Rc::clone(self.examined[i].borrow_mut().entry(elements.clone()).or_insert_with(find))
    }

    /// Number of coordinates of an automatic shaft.
    fn coordinates(&self, i: usize, counts: &[usize], degree: usize) -> usize {
        let elements = self.layouts[i].elements(counts);
        let shear = self.given.shafts[self.automatic[i]].shear;
        let scene = &self.model.scene;
        let bending = 4 * (elements + 1) + 2 * BendingFunction::all(degree, shear).len() * elements;
        let rod = elements + 1 + rod_degrees(degree).count() * elements;
        usize::from(scene.lateral) * bending + (usize::from(scene.torsion) + usize::from(scene.axial)) * rod
    }

    /// Expected error of the worst load and stiffness of the meshes: RMS of the difference between the step responses.
    fn error(&self, shafts: &[Rc<ShaftElements>]) -> f64 {
        let mut errors = vec![0.0; shafts.first().map_or(0, |shaft| shaft.errors.len())];
        for shaft in shafts {
            errors.iter_mut().zip(&shaft.errors).for_each(|(sum, error)| *sum += error);
        }
        let (mut worst, mut rest) = (0.0, errors.as_slice());
        for excitation in self.excitations {
            let (own, others) = rest.split_at(excitation.modes.len().min(rest.len()));
            worst = f64::max(worst, self.step_error(excitation, own));
            rest = others;
        }
        STEP_RESPONSE_SAFETY * worst
    }

    /// The same for one stiffness of the meshes, with the relative error of the frequency of each mode.
    fn step_error(&self, excitation: &Excitation, errors: &[f64]) -> f64 {
        let Excitation { signals, modes } = excitation;
        let of_modes: Vec<_> = modes.iter().zip(errors).map(|(mode, error)| squares(mode, error.min(1.0))).collect();
        let relative = signals.iter().map(|signal| {
            let (mut difference, mut response) = (0.0, signal.steady * COMPARED_DURATION);
            for (square, of_mode) in signal.squares.iter().zip(&of_modes) {
                difference += square * of_mode[0];
                response += square * of_mode[1];
            }
            let weight = if signal.displacement { self.weight } else { 1.0 };
            weight * (difference / response.max(f64::MIN_POSITIVE)).sqrt()
        });
        relative.fold(0.0, f64::max)
    }
}

/// Integrals over T of the squares of e^{−ct/2}(cos ωt − cos(ω + Δω)t) and of e^{−ct/2} cos ωt, without their fast
/// oscillation, s; `error` is Δω/ω.
fn squares(mode: &ExcitedMode, error: f64) -> [f64; 2] {
    let (response, cosine) = (decay(mode.damping), decaying_cosine(mode.damping, mode.frequency * error));
    [response - cosine, response / 2.0]
}

/// ∫₀ᵀ e^{−ct} dt, s.
fn decay(damping: f64) -> f64 {
    if damping * COMPARED_DURATION > 1e-6 {
        -(-damping * COMPARED_DURATION).exp_m1() / damping
    } else {
        COMPARED_DURATION
    }
}

/// ∫₀ᵀ e^{−ct} cos(dt) dt, s.
fn decaying_cosine(c: f64, d: f64) -> f64 {
    if c.hypot(d) * COMPARED_DURATION < 1e-4 {
        // Two terms of the series in d; the difference from `decay` would lose its digits.
        return decay(c) - d * d * COMPARED_DURATION * COMPARED_DURATION * COMPARED_DURATION / 6.0;
    }
    let ((sin, cos), fade) = ((d * COMPARED_DURATION).sin_cos(), (-c * COMPARED_DURATION).exp());
    (c - fade * (c * cos - d * sin)) / (c * c + d * d)
}
