//! The frame in which the lateral motion of each shaft is described: at rest, or turning with the carrier of planets.
//!
//! Pins and meshes of planets have fixed directions in the frame of their carrier. What couples shafts laterally to them must then be
//! the same in all directions, so that the coefficients are constant in this frame.

use std::collections::BTreeSet;

use super::description::Place;
use super::{Attachment, Bearing, Coupling, EntryPath, Matrix2, Mesh, Node, Scene, SceneError, VaryingLoad};
use crate::numerics::EQUALITY_TOLERANCE;

/// Why something with a direction of its own is refused in a frame that turns.
const FIXED: &str = "has a fixed direction, and planets that turn with their carrier are coupled laterally to it";
/// What still works where planets cannot move laterally.
const IN_TORSION: &str = "leave out the bearings of the planets to couple this stage in torsion only";

impl Scene {
    /// Whether a mesh acts on the lateral motion: not where a stage whose carrier turns has planets on rigid pins.
    pub fn acts_laterally(&self, mesh: &Mesh) -> bool {
        mesh.carrier.is_none() || self.carrier_of(self.planet_shaft(mesh)).is_some()
    }

    /// The carrier that turns on whose pins a shaft stands.
    pub fn carrier_of(&self, shaft: usize) -> Option<Node> {
        self.pins().find_map(|(bearing, carrier, _)| (bearing.node.shaft == shaft).then_some(carrier))
    }

    /// Bearings on pins of carriers that turn, with the node of the carrier and the distance (x, y, z) of the bearing from it, m.
    pub fn pins(&self) -> impl Iterator<Item = (&Bearing, Node, [f64; 3])> {
        self.bearings.iter().filter(|_| self.lateral).filter_map(|bearing| match bearing.attachment {
            Some(Attachment::Pin { carrier, arm }) => Some((bearing, carrier, arm)),
            _ => None,
        })
    }

    /// Whether a shaft moves laterally in a frame that turns.
    pub fn has_turning_frame(&self) -> bool {
        self.frames.iter().any(Option::is_some)
    }

    /// Shaft of the carrier with which the frame of the lateral motion of a shaft turns.
    pub fn frame_of(&self, shaft: usize) -> Option<usize> {
        self.frames.get(shaft).copied().flatten()
    }

    /// Shafts of the carriers with which frames turn, ascending.
    pub fn carriers(&self) -> BTreeSet<usize> {
        self.frames.iter().copied().flatten().collect()
    }

    /// Refuses an equilibrium with weight in a frame that turns.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the gravity.
    pub fn refuse_turning_weight(&self) -> Result<(), SceneError> {
        if self.gravity != [0.0; 2] && self.has_turning_frame() {
            return Err(EntryPath::root("gravity").error(format!(
                "{FIXED}, so that there is no equilibrium in their frame; use simulate() or steady_state(), or leave it out"
            )));
        }
        Ok(())
    }

    /// Speed of the frame of a shaft over that of the reference shaft.
    pub fn frame_ratio(&self, shaft: usize) -> f64 {
        self.frame_of(shaft).map_or(0.0, |carrier| self.speed_ratios[carrier])
    }

    /// Refuses an analysis whose loads or results have directions that do not turn with the carrier of planets.
    ///
    /// # Errors
    /// [`SceneError`] with the path of the first bearing on a pin of a carrier that turns.
    pub fn refuse_turning_frame(&self, analysis: &str) -> Result<(), SceneError> {
        let pin = |bearing: &Bearing| matches!(bearing.attachment, Some(Attachment::Pin { .. }));
        match self.bearings.iter().position(pin).filter(|_| self.lateral) {
            Some(index) => Err(EntryPath::entry("bearings", index).error(format!(
                "lets a planet move laterally on a carrier that turns, for which gearbow has no {analysis}; {IN_TORSION}",
            ))),
            None => Ok(()),
        }
    }

    /// Refuses a lateral force with a fixed direction in a frame that turns; one on a planet or its carrier turns with the carrier.
    ///
    /// # Errors
    /// [`SceneError`] at `at`.
    pub(crate) fn refuse_fixed_force(&self, place: &Place, at: &EntryPath<'_>) -> Result<(), SceneError> {
        let shaft = match place {
            Place::Shaft(name, _) => self.shaft(name),
            Place::Body(name) => self.body(name).map(|body| body.node.shaft),
        };
        match shaft.filter(|shaft| self.frame_of(*shaft).is_some() && !self.is_carried(*shaft)) {
            Some(shaft) => Err(at.error(format!(
                "{FIXED} by the shaft \"{}\", so that it has two frequencies in their frame; give a force on a planet or on the carrier, whose direction turns with the carrier, or {IN_TORSION}",
                self.shafts[shaft].name
            ))),
            None => Ok(()),
        }
    }

    /// Refuses a lateral motion of the ground below a frame that turns.
    ///
    /// # Errors
    /// [`SceneError`] at `at`.
    pub(crate) fn refuse_fixed_motion(&self, at: &EntryPath<'_>) -> Result<(), SceneError> {
        if self.has_turning_frame() {
            return Err(at.error(format!(
                "a lateral motion of the ground {FIXED}, so that it has two frequencies in their frame; give another source, or {IN_TORSION}"
            )));
        }
        Ok(())
    }

    /// Refuses section forces of a state or of phasors in a frame that turns, which leave out the inertia of this rotation.
    ///
    /// # Errors
    /// [`SceneError`] for a shaft in such a frame.
    pub fn refuse_section_forces(&self, shaft: &str) -> Result<(), SceneError> {
        if self.shaft(shaft).and_then(|index| self.frame_of(index)).is_some() {
            return Err(EntryPath::root("shaft").error(format!(
                "\"{shaft}\" moves in the frame of a carrier that turns, where only runs have section forces; record \"section_forces\" in simulate()"
            )));
        }
        Ok(())
    }

    /// Whether a shaft is a carrier that turns, or a planet on it.
    fn is_carried(&self, shaft: usize) -> bool {
        self.frame_of(shaft) == Some(shaft) || self.carrier_of(shaft).is_some()
    }

    /// Shaft of the planet of a mesh with a carrier: the one on a pin, or that of the driven gear.
    fn planet_shaft(&self, mesh: &Mesh) -> usize {
        let [a, b] = [mesh.driver, mesh.driven].map(|gear| self.gears[gear].body.node.shaft);
        if self.carrier_of(a).is_some() { a } else { b }
    }

    /// Finds the frames of all shafts, and refuses what is not constant in one that turns.
    pub(super) fn set_frames(&mut self) -> Result<(), SceneError> {
        let is_pin = |bearing: &Bearing| matches!(bearing.attachment, Some(Attachment::Pin { .. }));
        if let Some(index) = self.bearings.iter().position(is_pin).filter(|_| !self.lateral) {
            return Err(EntryPath::entry("bearings", index).error(format!(
                "is that of a planet on a carrier that turns, and motion=\"torsion\" has no lateral motion, in which pins yield; {IN_TORSION}"
            )));
        }
        for (index, mesh) in self.meshes.iter().enumerate().filter(|(_, mesh)| mesh.carrier.is_some()) {
            let gears = [mesh.driver, mesh.driven].map(|gear| &self.gears[gear].body);
            let still = gears.into_iter().find(|body| self.only_twists(body.node.shaft));
            if let Some(body) = still.filter(|_| self.acts_laterally(mesh)) {
                return Err(EntryPath::entry("meshes", index).error(format!(
                    "the planet moves laterally on its bearings, and \"{}\" on the shaft \"{}\" cannot; give its shaft bearings, or a ring on the ground a lateral_stiffness, or {IN_TORSION}",
                    body.name, self.shafts[body.node.shaft].name
                )));
            }
        }
        let carriers: Vec<_> = self.pins().map(|(bearing, carrier, _)| [bearing.node, carrier]).collect();
        for [planet, carrier] in carriers {
            for shaft in self.joined_to(planet.shaft) {
                let known = self.frames[shaft].replace(carrier.shaft).unwrap_or(carrier.shaft);
                if self.speed_ratios[known] != self.speed_ratios[carrier.shaft] {
                    let [first, second] = [known, carrier.shaft].map(|shaft| &self.shafts[shaft].name);
                    return Err(SceneError::new(
                        "planetary_stages",
                        format!(
                            "the carriers on \"{first}\" and \"{second}\" turn at different speeds, and \"{}\" couples their planets laterally; separate the stages by a coupling with torsional stiffness only, or {IN_TORSION}",
                            self.shafts[shaft].name
                        ),
                    ));
                }
            }
        }
        if self.has_turning_frame() { self.check_frames() } else { Ok(()) }
    }

    /// The shafts that are coupled laterally to a shaft, with this one.
    fn joined_to(&self, shaft: usize) -> Vec<usize> {
        let of_meshes = self.meshes.iter().filter(|mesh| self.acts_laterally(mesh)).map(|mesh| {
            let gears = [mesh.driver, mesh.driven].map(|gear| self.gears[gear].body.node.shaft);
            [gears[0], gears[1]]
        });
        let of_bearings = self.bearings.iter().filter_map(|bearing| {
            let mut nodes = bearing.nodes();
            Some([nodes.next()?.shaft, nodes.next()?.shaft])
        });
        let acts = |coupling: &&Coupling| [coupling.lateral, coupling.tilting].iter().any(|part| !part.is_zero());
        let of_couplings = self.couplings.iter().filter(acts).map(|coupling| coupling.hubs.map(|hub| hub.shaft));
        let pairs: Vec<[usize; 2]> = of_meshes.chain(of_bearings).chain(of_couplings).collect();
        let mut found = vec![shaft];
        let mut next = 0;
        while next < found.len() {
            for [a, b] in &pairs {
                for (from, to) in [(a, b), (b, a)] {
                    if *from == found[next] && !found.contains(to) {
                        found.push(*to);
                    }
                }
            }
            next += 1;
        }
        found
    }

    /// Refuses what has a direction of its own in a frame that turns.
    fn check_frames(&self) -> Result<(), SceneError> {
        let turns = |shaft: usize| self.frames[shaft].is_some();
        let name = |shaft: usize| &self.shafts[shaft].name;
        for (index, mesh) in self.meshes.iter().enumerate().filter(|(_, mesh)| mesh.carrier.is_none()) {
            let gears = [mesh.driver, mesh.driven].map(|gear| self.gears[gear].body.node.shaft);
            if let Some(shaft) = gears.into_iter().find(|shaft| turns(*shaft)) {
                return Err(EntryPath::entry("meshes", index).error(format!(
                    "{FIXED} by the shaft \"{}\"; separate them by a coupling with torsional stiffness only, or {IN_TORSION}",
                    name(shaft)
                )));
            }
        }
        for (index, bearing) in self.bearings.iter().enumerate().filter(|(_, bearing)| turns(bearing.node.shaft)) {
            let at = EntryPath::entry("bearings", index);
            let shaft = name(bearing.node.shaft);
            let (Some(stiffness), Some(damping)) = (bearing.stiffness.constant(), bearing.damping.constant()) else {
                return Err(at.error(format!(
                    "on the shaft \"{shaft}\" has coefficients that depend on the speed, and planets that turn with their carrier are coupled laterally to it; give constant coefficients, or {IN_TORSION}",
                )));
            };
            let on_pin = matches!(bearing.attachment, Some(Attachment::Pin { .. }));
            if matches!(bearing.attachment, Some(Attachment::Housing { .. })) {
                return Err(at.field("support").error(format!(
                    "a support or housing {FIXED} by the shaft \"{shaft}\"; let the bearing stand on the ground, or {IN_TORSION}",
                )));
            }
            if !bearing.has_constant_part() || bearing.nonlinear.is_some() {
                return Err(at.error(format!(
                    "on the shaft \"{shaft}\" is nonlinear, and planets that turn with their carrier are coupled laterally to it; give a gb.Bearing, or {IN_TORSION}",
                )));
            }
            if !on_pin && ![stiffness, damping].iter().all(is_isotropic) {
                return Err(at.error(format!(
                    "on the shaft \"{shaft}\" is not the same in all directions, and planets that turn with their carrier are coupled laterally to it; give an isotropic bearing, or {IN_TORSION}",
                )));
            }
            if !on_pin && bearing.misalignment.norm() != 0.0 {
                return Err(at
                    .field("misalignment")
                    .error(format!("{FIXED} by the shaft \"{shaft}\"; leave it out, or {IN_TORSION}")));
            }
            if bearing.loss_factor != 0.0 {
                return Err(at.field("loss_factor").error("has no meaning in the frame of a carrier that turns, where frequencies differ from those of the bearing; give a damping"));
            }
        }
        for (index, shaft) in self.shafts.iter().enumerate().filter(|(index, _)| turns(*index)) {
            if shaft.loss_factor != 0.0 {
                return Err(EntryPath::entry("shafts", index).field("loss_factor").error("has no meaning in the frame of a carrier that turns, where frequencies differ from those of the shaft; give internal_damping"));
            }
        }
        for (index, coupling) in self.couplings.iter().enumerate() {
            let is_aligned = coupling.offset.norm() == 0.0 && coupling.angle.norm() == 0.0;
            if turns(coupling.hubs[0].shaft) && !is_aligned {
                return Err(EntryPath::entry("couplings", index).error(format!(
                    "its misalignment {FIXED} by the shaft \"{}\"; leave it out, or {IN_TORSION}",
                    name(coupling.hubs[0].shaft)
                )));
            }
        }
        if !self.modal_damping.is_zero() {
            return Err(EntryPath::root("modal_damping").error("is that of modes at rest, and planets that turn with their carrier have others; give damping of bearings and meshes, or rayleigh"));
        }
        for (index, force) in self.forces.iter().enumerate().filter(|(_, force)| !force.turns) {
            let shaft = force.node.shaft;
            // A force on a planet or its carrier turns with the carrier.
            if force.value.norm() != 0.0 && turns(shaft) && !self.is_carried(shaft) {
                return Err(EntryPath::entry("forces", index).error(format!(
                    "{FIXED} by the shaft \"{}\"; give a force on a planet or on the carrier, whose direction turns with the carrier, or {IN_TORSION}",
                    name(shaft)
                )));
            }
        }
        let acts = |load: &&VaryingLoad| !load.law.is_torque() && turns(load.node.shaft);
        match self.varying_loads.iter().find(acts) {
            Some(load) => Err(SceneError::new(
                load.path.clone(),
                format!("{FIXED} by the shaft \"{}\"; leave it out, or {IN_TORSION}", name(load.node.shaft)),
            )),
            None => Ok(()),
        }
    }
}

/// Whether a matrix over (y, z) is the same in all directions: a multiple of a rotation.
fn is_isotropic([[a, b], [c, d]]: &Matrix2) -> bool {
    let tolerance = EQUALITY_TOLERANCE * (a.abs() + b.abs());
    (a - d).abs() <= tolerance && (b + c).abs() <= tolerance
}
