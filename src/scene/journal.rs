//! Journal bearing: check of its entries.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use super::description::{self, FilmModel, Profile, Reduction, Rupture};
use super::{EntryPath, SceneError, given};
use crate::numerics::EQUALITY_TOLERANCE;

/// Ratios L/D for which the grid of the finite film is made; its errors were measured within them.
const LENGTH_RATIOS: RangeInclusive<f64> = 0.1..=2.0;
/// Extents of a pad for which the grid is made, rad, or 2π.
const EXTENTS: RangeInclusive<f64> = 0.1..=6.2;
/// Extent of the axial grooves between the pads of a profile, rad.
const GROOVE: f64 = TAU / 18.0;
/// Numbers of tilting pads that hold a shaft.
const TILTING_PADS: RangeInclusive<u32> = 3..=12;
/// Usual part of the turn that tilting pads cover: 60° of 72° with five pads.
const PAD_SHARE: f64 = 5.0 / 6.0;
/// Preload of a profile with lobes.
const LOBE_PRELOAD: f64 = 0.5;

/// Geometry and oil of a journal bearing.
#[derive(Clone, Debug, PartialEq)]
pub struct Journal {
    /// Diameter D of the journal, m.
    pub diameter: f64,
    /// Radial clearance c, m.
    pub clearance: f64,
    /// Dynamic viscosity μ, Pa s.
    pub viscosity: f64,
    /// Model of the film.
    pub film: FilmKind,
    /// Its pads; one of 2π for a plain bearing.
    pub pads: Vec<Pad>,
    /// How its pads tilt; none for a bearing of fixed geometry.
    pub tilting: Option<Tilting>,
}

/// How the pads of a bearing tilt about their pivots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilting {
    /// Moment of inertia J about the pivot, kg m².
    pub inertia: f64,
    /// Mass, kg, and radial stiffness of the pivot, N/m; none for a rigid pivot.
    pub spring: Option<[f64; 2]>,
    /// Whether linear analyses have coefficients at the frequency of the rotation.
    pub is_synchronous: bool,
}

impl Tilting {
    /// J/R², kg.
    pub fn tilt_mass(&self, journal: &Journal) -> f64 {
        4.0 * self.inertia / journal.diameter.powi(2)
    }
}

/// A squeeze film.
#[derive(Clone, Debug, PartialEq)]
pub struct Squeeze {
    /// Geometry and oil of the film around its ring.
    pub journal: Journal,
    /// Whether it ruptures (π film) or not (2π film).
    pub is_ruptured: bool,
}

impl Squeeze {
    /// Checks the entries of a squeeze film of the support at the entry `at`; none for another support.
    ///
    /// # Errors
    /// [`SceneError`] as for the film of a journal.
    pub(crate) fn new(given: &description::Support, at: &EntryPath) -> Result<Option<Self>, SceneError> {
        if given.film_entries().iter().all(|(_, is_given)| !is_given) {
            return Ok(None);
        }
        let film = description::Bearing {
            diameter: given.diameter,
            length: given.length,
            clearance: given.clearance,
            viscosity: given.viscosity,
            film: given.film,
            ..description::Bearing::default()
        };
        let journal = Journal::new(&film, at)?;
        Ok(journal.map(|journal| Self { journal, is_ruptured: given.ruptures.unwrap_or(true) }))
    }
}

/// A pad of fixed geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pad {
    /// Angle from y towards z at which its arc begins, rad.
    pub begin: f64,
    /// Extent of its arc, rad.
    pub extent: f64,
    /// Axial length L, m.
    pub length: f64,
    /// Radial clearance c of the pad, m.
    pub clearance: f64,
    /// Preload m: the centre of the pad is m c away from the centre of the bearing.
    pub preload: f64,
    /// Place closest to the centred journal, as a part of the extent, in the direction of rotation.
    pub offset: f64,
}

impl Pad {
    /// Angle of the place closest to the centred journal for a direction of rotation, 1 or −1, rad.
    pub fn closest(&self, direction: f64) -> f64 {
        let part = if direction < 0.0 { 1.0 - self.offset } else { self.offset };
        self.begin + part * self.extent
    }
}

/// Model of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilmKind {
    /// Short film, closed form.
    Short,
    /// Film of finite length.
    Finite(Rupture),
}

impl Journal {
    /// Whether its tilting pads are eliminated in linear analyses.
    pub fn is_reduced(&self) -> bool {
        self.tilting.is_some_and(|tilting| tilting.is_synchronous)
    }

    /// A tilting pad for a direction of rotation, 1 or −1: its arc is mirrored about its pivot where the shaft turns backwards.
    pub fn tilting_pad(&self, pad: &Pad, direction: f64) -> Pad {
        let begin = if direction < 0.0 { 2.0 * pad.closest(1.0) - pad.begin - pad.extent } else { pad.begin };
        Pad { begin, ..*pad }
    }

    /// Checks the entries of a bearing at the entry `at`; none for a linear bearing.
    ///
    /// # Errors
    /// [`SceneError`] for a bearing with both stiffness and film or with none, a film on a support, a missing entry, a value that is not
    /// positive, a clearance that is not below the radius, grooves that do not leave a pad, and pads that overlap.
    pub(super) fn new(given: &description::Bearing, at: &EntryPath) -> Result<Option<Self>, SceneError> {
        let entries = [
            ("diameter", given.diameter),
            ("length", given.length),
            ("clearance", given.clearance),
            ("viscosity", given.viscosity),
        ];
        if !given.film_entries().iter().any(|(_, is_given)| *is_given) {
            return match given.stiffness {
                Some(_) => Ok(None),
                None => Err(at.error("missing field `stiffness`, or those of a journal bearing or rolling bearing")),
            };
        }
        at.refuse(&given![given; stiffness, damping], "a journal bearing takes none, its film has it; leave it out, or leave out diameter, length, clearance, viscosity and the other entries of the film")?;
        let read = |(name, value): (&str, Option<f64>)| {
            let missing = || at.error(format!("missing field `{name}` of the journal bearing"));
            at.field(name).positive(value.ok_or_else(missing)?)
        };
        let [diameter, length, clearance, viscosity] = entries.map(read);
        let (diameter, length, clearance) = (diameter?, length?, clearance?);
        if clearance >= diameter / 2.0 {
            let message = format!(
                "must be below the radius of the journal, {} m, got {clearance}; usual is about a thousandth of it",
                diameter / 2.0
            );
            return Err(at.field("clearance").error(message));
        }
        let film = film(given, at)?;
        let tilting = tilting(given, at)?;
        let pads = match given.pad_count {
            Some(count) => tilting_pads(given, count, [length, clearance], at)?,
            None => pads(given, length, clearance, at)?,
        };
        if film != FilmKind::Short {
            let own = at.field("pads");
            pads.iter().enumerate().try_for_each(|(index, pad)| {
                let own = own.index(index);
                check_length(pad.length / diameter, &if given.pads.is_some() { &own } else { at }.field("length"))
            })?;
        }
        Ok(Some(Self { diameter, clearance, viscosity: viscosity?, film, pads, tilting }))
    }
}

fn film(given: &description::Bearing, at: &EntryPath) -> Result<FilmKind, SceneError> {
    let grooves = given.grooves.as_deref().unwrap_or_default();
    let is_full = given.pads.is_none()
        && given.pad_count.is_none()
        && grooves.is_empty()
        && given.profile.unwrap_or_default() == Profile::Plain;
    match given.film {
        Some(FilmModel::Short) if !grooves.is_empty() => {
            let message = format!("a short film has none, got {}; use film=\"finite\"", grooves.len());
            Err(at.field("grooves").error(message))
        }
        Some(FilmModel::Short) if !is_full => {
            Err(at.field("film").error("a short film has a plain profile; use film=\"finite\""))
        }
        Some(FilmModel::Short) | None if given.rupture.is_some() && is_full => Err(at
            .field("rupture")
            .error("a short film ruptures by Gümbel's condition; use film=\"finite\", or leave it out")),
        Some(FilmModel::Short) => Ok(FilmKind::Short),
        None if is_full => Ok(FilmKind::Short),
        None if !grooves.is_empty() && given.profile.is_none() && given.pads.is_none() => {
            let message = format!("a short film has none, got {}; use film=\"finite\"", grooves.len());
            Err(at.field("grooves").error(message))
        }
        Some(FilmModel::Finite) | None => Ok(FilmKind::Finite(given.rupture.unwrap_or_default())),
    }
}

fn check_length(ratio: f64, at: &EntryPath) -> Result<(), SceneError> {
    if LENGTH_RATIOS.contains(&ratio) {
        return Ok(());
    }
    let (least, most) = LENGTH_RATIOS.into_inner();
    Err(at.error(format!(
        "length / diameter of a finite film must be between {least} and {most}, got {ratio}; a shorter film is film=\"short\""
    )))
}

/// How the pads of a bearing tilt; none for a bearing of fixed geometry.
fn tilting(given: &description::Bearing, at: &EntryPath) -> Result<Option<Tilting>, SceneError> {
    if given.pad_count.is_none() {
        let entries = given![given; pad_extent, pad_inertia, pad_mass, pivot_stiffness, reduced];
        return at.refuse(&entries, "is that of tilting pads; give pad_count").map(|()| None);
    }
    let positive = |name: &str, value: Option<f64>| value.map(|value| at.field(name).positive(value)).transpose();
    let inertia = positive("pad_inertia", given.pad_inertia)?;
    let (mass, stiffness) =
        (positive("pad_mass", given.pad_mass)?, positive("pivot_stiffness", given.pivot_stiffness)?);
    let spring = match (mass, stiffness) {
        (Some(mass), Some(stiffness)) => Some([mass, stiffness]),
        (None, None) => None,
        (Some(_), None) => return Err(at.field("pad_mass").error("moves on a flexible pivot; give pivot_stiffness")),
        (None, Some(_)) => return Err(at.field("pivot_stiffness").error("needs the mass of a pad; give pad_mass")),
    };
    let is_synchronous = given.reduced == Some(Reduction::Synchronous);
    match inertia {
        None if !is_synchronous => Err(at.field("pad_inertia").error(
            "missing: the moment of inertia of a pad about its pivot [kg m^2]; without inertia use reduced=\"synchronous\"",
        )),
        inertia => Ok(Some(Tilting { inertia: inertia.unwrap_or(0.0), spring, is_synchronous })),
    }
}

/// The pads of a tilting-pad bearing, by default with the load along −z between two of them.
fn tilting_pads(
    given: &description::Bearing,
    count: u32,
    [length, clearance]: [f64; 2],
    at: &EntryPath,
) -> Result<Vec<Pad>, SceneError> {
    at.refuse(&given![given; profile, grooves, pads], "a tilting-pad bearing takes none; leave it out")?;
    if !TILTING_PADS.contains(&count) {
        let message = format!("must be from {} to {}, got {count}", TILTING_PADS.start(), TILTING_PADS.end());
        return Err(at.field("pad_count").error(message));
    }
    let sector = TAU / f64::from(count);
    let extent = at.field("pad_extent").positive(given.pad_extent.unwrap_or(PAD_SHARE * sector))?;
    if !(*EXTENTS.start()..sector).contains(&extent) {
        let least = EXTENTS.start();
        let message = format!("must be between {least} and {sector:.4} rad, got {extent}; is it in degrees?");
        return Err(at.field("pad_extent").error(message));
    }
    let preload = preload(given.preload, LOBE_PRELOAD, at)?;
    if preload == 0.0 && given.reduced != Some(Reduction::Synchronous) {
        let message = "must be positive, got 0: the pads opposite to the load would carry nothing, and their tilt would be free; use reduced=\"synchronous\", which leaves them out";
        return Err(at.field("preload").error(message));
    }
    let offset = given.offset.unwrap_or(0.5);
    if !(0.0..=1.0).contains(&at.field("offset").finite(offset)?) {
        let message = format!("must be the place of the pivot from 0 (leading edge) to 1, got {offset}");
        return Err(at.field("offset").error(message));
    }
    let first = at.field("orientation").finite(given.orientation.unwrap_or(sector / 2.0 - TAU / 4.0))?;
    let pad = |index| {
        let pivot = first + f64::from(index) * sector;
        Pad { begin: pivot - offset * extent, extent, length, clearance, preload, offset }
    };
    Ok((0..count).map(pad).collect())
}

/// The pads of a bearing: those given, those between grooves, or those of a profile.
fn pads(given: &description::Bearing, length: f64, clearance: f64, at: &EntryPath) -> Result<Vec<Pad>, SceneError> {
    if let Some(pads) = &given.pads {
        let entries = given![given; profile, grooves, preload, offset, orientation];
        at.refuse(&entries, "the pads have it; leave it out, or leave out pads")?;
        return given_pads(pads, length, clearance, &at.field("pads"));
    }
    let profile = given.profile.unwrap_or_default();
    let grooves = given.grooves.as_deref().unwrap_or_default();
    if given.grooves.is_some() && given.profile.is_some() {
        return Err(at.field("grooves").error("the profile has its own; leave them out, or leave out profile"));
    }
    let has_lobes = !matches!(profile, Profile::Plain | Profile::Grooves);
    if !has_lobes {
        let message = "is that of lobes; use profile=\"lemon\", \"offset\", \"three-lobe\" or \"four-lobe\"";
        at.refuse(&given![given; preload, offset], message)?;
    }
    check_grooves(grooves, &at.field("grooves"))?;
    let orientation = at.field("orientation").finite(given.orientation.unwrap_or(0.0))?;
    let preload = preload(given.preload, if has_lobes { LOBE_PRELOAD } else { 0.0 }, at)?;
    let (count, offset) = match profile {
        Profile::Plain => (0, 0.5),
        Profile::Grooves | Profile::Lemon => (2, 0.5),
        // The halves are displaced along the joint, in which the grooves lie: the closest place is in the middle of a groove.
        Profile::Offset => (2, 1.0 + GROOVE / 2.0 / (TAU / 2.0 - GROOVE)),
        Profile::ThreeLobe => (3, 0.5),
        Profile::FourLobe => (4, 0.5),
    };
    let offset = at.field("offset").finite(given.offset.unwrap_or(offset))?;
    let pad = |begin: f64, extent: f64| Pad { begin, extent, length, clearance, preload, offset };
    if count > 0 {
        let sector = TAU / f64::from(count);
        // A lobe of three has its middle at −z, and a groove of two or four is at y.
        let first = orientation + GROOVE / 2.0 - if count == 3 { TAU / 4.0 + sector / 2.0 } else { 0.0 };
        return Ok((0..count).map(|index| pad(first + f64::from(index) * sector, sector - GROOVE)).collect());
    }
    if grooves.is_empty() {
        return Ok(vec![pad(-TAU / 2.0, TAU)]);
    }
    let mut edges: Vec<[f64; 2]> =
        grooves.iter().map(|[middle, extent]| [orientation + middle - extent / 2.0, *extent]).collect();
    edges.iter_mut().for_each(|edge| edge[0] = edge[0].rem_euclid(TAU));
    edges.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let next = |i: usize| if i + 1 < edges.len() { edges[i + 1][0] } else { edges[0][0] + TAU };
    Ok((0..edges.len()).map(|i| pad(edges[i][0] + edges[i][1], next(i) - edges[i][0] - edges[i][1])).collect())
}

fn preload(given: Option<f64>, usual: f64, at: &EntryPath) -> Result<f64, SceneError> {
    let (at, value) = (at.field("preload"), given.unwrap_or(usual));
    if (0.0..1.0).contains(&at.finite(value)?) {
        return Ok(value);
    }
    Err(at.error(format!("must be from 0 to below 1, got {value}; it is 1 - bearing clearance / pad clearance")))
}

fn given_pads(given: &[description::Pad], length: f64, clearance: f64, at: &EntryPath) -> Result<Vec<Pad>, SceneError> {
    if given.is_empty() {
        return Err(at.error("must have at least one gb.Pad"));
    }
    let pad = |(index, pad): (usize, &description::Pad)| {
        let at = at.index(index);
        let extent = at.field("extent").positive(pad.extent)?;
        if !EXTENTS.contains(&extent) && (extent - TAU).abs() > EQUALITY_TOLERANCE {
            let (least, most) = EXTENTS.into_inner();
            let message = format!("must be between {least} and {most} rad, or 2 pi, got {extent}; is it in degrees?");
            return Err(at.field("extent").error(message));
        }
        Ok(Pad {
            begin: at.field("begin").finite(pad.begin)?,
            extent: if extent > *EXTENTS.end() { TAU } else { extent },
            length: at.field("length").positive(pad.length.unwrap_or(length))?,
            clearance: at.field("clearance").positive(pad.clearance.unwrap_or(clearance))?,
            preload: preload(pad.preload, 0.0, &at)?,
            offset: at.field("offset").finite(pad.offset.unwrap_or(0.5))?,
        })
    };
    let pads = given.iter().enumerate().map(pad).collect::<Result<Vec<Pad>, SceneError>>()?;
    for (index, pad) in pads.iter().enumerate() {
        for (other, next) in pads.iter().enumerate().filter(|(other, _)| *other != index) {
            let apart = (next.begin - pad.begin).rem_euclid(TAU);
            if apart < pad.extent - EQUALITY_TOLERANCE {
                let message = format!("overlaps pads[{other}], which begins {apart:.4} rad after its begin");
                return Err(at.index(index).field("extent").error(message));
            }
        }
    }
    Ok(pads)
}

/// Refuses grooves that overlap or leave pads that are too short.
fn check_grooves(grooves: &[[f64; 2]], at: &EntryPath) -> Result<(), SceneError> {
    for (index, [middle, extent]) in grooves.iter().enumerate() {
        at.index(index).index(0).finite(*middle)?;
        at.index(index).index(1).positive(*extent)?;
    }
    let mut order: Vec<usize> = (0..grooves.len()).collect();
    let begin = |index: usize| (grooves[index][0] - grooves[index][1] / 2.0).rem_euclid(TAU);
    order.sort_by(|a, b| begin(*a).total_cmp(&begin(*b)));
    for (place, index) in order.iter().enumerate() {
        let next = order[(place + 1) % order.len()];
        let turn = if place + 1 == order.len() { TAU } else { 0.0 };
        let pad = begin(next) + turn - begin(*index) - grooves[*index][1];
        let least = *EXTENTS.start();
        if pad < least {
            let message = format!(
                "leaves a pad of {pad:.4} rad to grooves[{next}], at least {least} is needed; give (angle of the middle, extent) of each groove in radians"
            );
            return Err(at.index(*index).error(message));
        }
    }
    Ok(())
}
