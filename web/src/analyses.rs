//! What the page asks of a train.

use gearbow::analysis::simulate::{self, Initial, Method, Options, RecordPlan, Request, System, sample_step};
use gearbow::analysis::{self, ExcitationPart, ExcitationSource, Interrupt, Threads};
use gearbow::connection::MESH_CHANNELS;
use gearbow::mesh::{Geometry, Involute};
use gearbow::modal::ModeSelection;
use gearbow::model::Model;
use gearbow::motion::Speed;
use gearbow::scene::{Node, Scene, SceneDescription};
use num_complex::Complex64;
use serde::Serialize;

use crate::units::Units;

/// Most output times of a run: what a browser draws at once.
const MAX_OUTPUT_TIMES: f64 = 4000.0;

/// Amplitude of the bow whose response stands for that of any other one, m: the response is linear in the bow.
const SMALL_BOW: f64 = 1e-6;

/// Smallest displacement of gear centres relative to the bow that counts as motion, as in the package.
const MIN_MOTION: f64 = 1e-3;

/// Bisections for a limit of the bow: the error is 4 modules over 2 to this power.
const BISECTIONS: usize = 40;

/// A bow of one half wave, which replaces the bow of a shaft.
pub struct Bow {
    /// Name of the shaft.
    pub shaft: String,
    /// Deflection in the middle, m.
    pub amplitude: f64,
}

/// A checked and assembled train.
pub struct Train {
    /// The scene as it was read, with numbers in place of texts with units.
    plain: toml::Value,
    description: SceneDescription,
    cached: System,
}

/// Largest bow of a shaft up to which the teeth of a mesh keep contact.
#[derive(Serialize)]
pub struct BowLimit {
    /// Names of the gears.
    mesh: String,
    /// Bow in the middle of the shaft, m; none if the bow does not move the gears, or if four modules leave the teeth in contact.
    bow: Option<f64>,
}

/// A piece of a shaft with its sleeves: position of its left end, length, and outer radii at both ends, m.
#[derive(Serialize)]
struct Piece {
    x: f64,
    length: f64,
    outer_radii: [f64; 2],
}

/// A shaft.
#[derive(Serialize)]
struct ShaftLayout {
    name: String,
    /// Speed relative to the reference shaft.
    ratio: f64,
    length: f64,
    pieces: Vec<Piece>,
    /// Positions of nodes, m.
    nodes: Vec<f64>,
    /// Size of the bow at the nodes, m.
    bow: Vec<f64>,
}

/// A gear, disk or bearing; sizes of the last two are zero.
#[derive(Serialize)]
struct BodyLayout {
    name: String,
    /// Index of the shaft.
    shaft: usize,
    /// Position on the shaft, m.
    x: f64,
    /// Pitch radius, m.
    radius: f64,
    /// Face width, m.
    width: f64,
    teeth: u32,
}

/// Sizes of a train.
#[derive(Serialize)]
pub struct Layout {
    shafts: Vec<ShaftLayout>,
    gears: Vec<BodyLayout>,
    disks: Vec<BodyLayout>,
    bearings: Vec<BodyLayout>,
    /// Indices of driving and driven gear, one pair for each mesh.
    meshes: Vec<[usize; 2]>,
    degrees_of_freedom: usize,
    warnings: Vec<String>,
}

/// A mode.
#[derive(Serialize)]
pub struct ModeRow {
    frequency_hz: f64,
    damping_ratio: f64,
    whirl: String,
}

/// An excitation line of a Campbell diagram: a name and the frequency over the speed of the reference shaft.
#[derive(Serialize)]
struct Line {
    name: String,
    order: f64,
}

/// A speed, rad/s, at which an excitation line meets a mode.
#[derive(Serialize)]
struct Intersection {
    speed: f64,
    frequency_hz: f64,
    line: String,
    whirl: String,
    damping_ratio: f64,
}

/// A Campbell diagram: frequencies, Hz, for each speed, rad/s, and mode.
#[derive(Serialize)]
pub struct Campbell {
    speeds: Vec<f64>,
    frequencies_hz: Vec<Vec<f64>>,
    lines: Vec<Line>,
    intersections: Vec<Intersection>,
}

/// Semi-major axes of the orbits, m: one list over the speeds, rad/s, for each gear and disk.
#[derive(Serialize)]
pub struct Synchronous {
    speeds: Vec<f64>,
    names: Vec<String>,
    semi_major_axes: Vec<Vec<f64>>,
}

/// Motion of one point: its names, and displacements along y and z, m.
#[derive(Serialize)]
struct PointMotion {
    name: String,
    y: Vec<f64>,
    z: Vec<f64>,
}

/// Motion of one mesh.
#[derive(Serialize)]
struct MeshMotion {
    name: String,
    /// Force, N.
    force: Vec<f64>,
    contact_ratio: Vec<f64>,
    /// Operating pressure angle, rad.
    pressure_angle: Vec<f64>,
}

/// A run.
#[derive(Serialize)]
pub struct Run {
    /// Times, s.
    time: Vec<f64>,
    points: Vec<PointMotion>,
    meshes: Vec<MeshMotion>,
    steps: u64,
}

fn message(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// `count` equally spaced speeds from the first one to `fastest`, rad/s. Zero is left out: a critical speed is above it.
fn speeds(fastest: f64, count: usize) -> Vec<f64> {
    (1..=count).map(|index| fastest * index as f64 / count as f64).collect()
}

impl Train {
    /// Reads a scene, and replaces a bow.
    pub fn new(scene: &str, units: &Units, bow: Option<&Bow>) -> Result<Self, String> {
        let table: toml::Table = scene.parse().map_err(|error| format!("the scene is not TOML: {error}"))?;
        let mut plain = units.without_texts(toml::Value::Table(table), &mut Vec::new())?;
        if let Some(bow) = bow {
            replace_bow(&mut plain, bow)?;
        }
        Self::from_plain(plain)
    }

    /// Reads a scene without texts in place of numbers.
    fn from_plain(plain: toml::Value) -> Result<Self, String> {
        let description = SceneDescription::deserialize(plain.clone()).map_err(message)?;
        let resolved = analysis::resolve(&description, None, &Interrupt::default()).map_err(message)?;
        let model = Model::new(Scene::new(&resolved.description).map_err(message)?).map_err(message)?;
        Ok(Self { plain, description, cached: System::new(model) })
    }

    /// Sizes of all parts.
    pub fn layout(&self) -> Layout {
        let scene = &self.cached.model.scene;
        let place = |node: Node| (node.shaft, scene.shafts[node.shaft].nodes[node.node]);
        let bow = analysis::bow(&self.cached.model);
        let shafts = scene.shafts.iter().enumerate().map(|(index, shaft)| {
            let starts = shaft.nodes.iter();
            let piece = |(x, element): (&f64, &gearbow::scene::Element)| {
                let radii = |end: usize| element.tubes().map(|tube| tube.outer_radius[end]).fold(0.0, f64::max);
                Piece { x: *x, length: element.length, outer_radii: [radii(0), radii(1)] }
            };
            let size = |node: usize| {
                let translation = self.cached.model.numbering.translation(Node { shaft: index, node });
                translation.map_or(0.0, |v| bow[v].norm())
            };
            ShaftLayout {
                name: shaft.name.clone(),
                ratio: scene.speed_ratios[index],
                length: shaft.length(),
                pieces: starts.zip(&shaft.elements).map(piece).collect(),
                nodes: shaft.nodes.clone(),
                bow: (0..shaft.nodes.len()).map(size).collect(),
            }
        });
        let plain = |name: &str, node: Node| {
            let (shaft, x) = place(node);
            BodyLayout { name: name.to_owned(), shaft, x, radius: 0.0, width: 0.0, teeth: 0 }
        };
        // The nodes of supports and housings are on no shaft.
        let on_shaft = |node: &Node| node.shaft < scene.shafts.len();
        Layout {
            shafts: shafts.collect(),
            gears: scene
                .gears
                .iter()
                .map(|gear| BodyLayout {
                    radius: gear.pitch_radius,
                    width: gear.face_width.unwrap_or(0.0),
                    teeth: gear.teeth,
                    ..plain(&gear.body.name, gear.body.node)
                })
                .collect(),
            disks: scene.disks.iter().map(|disk| plain(&disk.name, disk.node)).collect(),
            bearings: scene.bearing_nodes().into_iter().filter(on_shaft).map(|node| plain("", node)).collect(),
            meshes: scene.meshes.iter().map(|mesh| [mesh.driver, mesh.driven]).collect(),
            degrees_of_freedom: self.cached.model.len(),
            warnings: scene.warnings.clone(),
        }
    }

    /// Modes of lowest frequency.
    pub fn modes(&self, speed: f64, count: usize) -> Result<Vec<ModeRow>, String> {
        let modes = analysis::lowest_modes(&self.cached, speed, count, ModeSelection::All).map_err(message)?;
        let row = |mode: &gearbow::modal::Mode| ModeRow {
            frequency_hz: mode.frequency_hz(),
            damping_ratio: mode.damping_ratio(),
            whirl: mode.whirl.to_string(),
        };
        Ok(modes.iter().map(row).collect())
    }

    /// Campbell diagram.
    pub fn campbell(&self, fastest: f64, points: usize, count: usize) -> Result<Campbell, String> {
        let speeds = speeds(fastest, points);
        // A page has one thread.
        let one = Threads::new(1, 1);
        let found =
            analysis::campbell(&self.cached, &speeds, count, 1, &one, &Interrupt::default()).map_err(message)?;
        let model = &self.cached.model;
        let name = |line: &analysis::ExcitationLine| match line.source {
            ExcitationSource::Shaft(shaft) => format!("{}× {}", line.harmonic, model.scene.shafts[shaft].name),
            ExcitationSource::Mesh(mesh) => format!("{}× teeth of {}", line.harmonic, model.gear_names(mesh).join("/")),
        };
        let hertz = |eigenvalue: &Complex64| eigenvalue.im / std::f64::consts::TAU;
        let intersection = |at: &analysis::Intersection| Intersection {
            speed: at.speed,
            frequency_hz: hertz(&at.eigenvalue),
            line: name(&found.lines[at.line]),
            whirl: at.whirl.to_string(),
            damping_ratio: -at.eigenvalue.re / at.eigenvalue.norm(),
        };
        Ok(Campbell {
            frequencies_hz: found.eigenvalues.iter().map(|modes| modes.iter().map(hertz).collect()).collect(),
            lines: found.lines.iter().map(|line| Line { name: name(line), order: line.order }).collect(),
            intersections: found.intersections.iter().map(intersection).collect(),
            speeds,
        })
    }

    /// Synchronous response of each gear and disk to bow and unbalance of its own shaft.
    pub fn synchronous(&self, fastest: f64, points: usize) -> Result<Synchronous, String> {
        let speeds = speeds(fastest, points);
        let (model, bodies) = (&self.cached.model, self.bodies());
        let mut semi_major_axes = vec![Vec::with_capacity(points); bodies.len()];
        for speed in &speeds {
            let found = analysis::synchronous(&self.cached, *speed, ExcitationPart::All).map_err(message)?;
            for ((_, node), axes) in bodies.iter().zip(&mut semi_major_axes) {
                let phasor = |index: usize| found[(index, node.shaft)];
                axes.push(
                    model.numbering.translation(*node).map_or(0.0, |v| semi_major_axis(phasor(v), phasor(v + 1))),
                );
            }
        }
        Ok(Synchronous { speeds, names: bodies.into_iter().map(|(name, _)| name).collect(), semi_major_axes })
    }

    /// Names and nodes of gears and disks.
    fn bodies(&self) -> Vec<(String, Node)> {
        self.cached.model.scene.bodies().map(|body| (body.name.clone(), body.node)).collect()
    }

    /// A run over a number of turns of the slowest shaft.
    pub fn run(&self, speed: f64, turns: f64) -> Result<Run, String> {
        let model = &self.cached.model;
        let slowest = model.scene.speed_ratios.iter().fold(f64::INFINITY, |least, ratio| least.min(ratio.abs()));
        let duration = turns * std::f64::consts::TAU / (slowest * speed.abs());
        let requests = ["gears", "disks", "meshes"].map(|name| Request::Name(name.to_owned()));
        let plan = RecordPlan::new(model, &requests).map_err(message)?;
        let count = (duration / sample_step(model, speed)).clamp(2.0, MAX_OUTPUT_TIMES) as usize;
        let level = self.description.accuracy.unwrap_or_default().level();
        let options = Options {
            duration,
            speed: Speed::Constant(speed),
            method: Method::Exponential,
            step: None,
            rtol: Some(level.rtol),
            stages: None,
            modes: None,
            reduction: level.reduction(),
            kept_modes: None,
            force_error: Some(level.mesh_force),
            initial: Initial::Synchronous,
            times: (0..=count).map(|index| duration * index as f64 / count as f64).collect(),
            geometry: Geometry::Live,
            start: 0.0,
            checkpoint: None,
        };
        let response = simulate::simulate(&self.cached, &options, &plan, &mut |_| true)
            .map_err(|stopped| message(stopped.error))?;
        let record = response.record;
        let column = |values: &[f64], width: usize, index: usize| {
            values.iter().skip(index).step_by(width).copied().collect::<Vec<f64>>()
        };
        let width = plan.points.len();
        let channel = |name: &str, mesh: usize| {
            let index = MESH_CHANNELS.iter().position(|channel| channel.name == name);
            index.map_or_else(Vec::new, |index| column(&record.mesh[index], plan.meshes.len(), mesh))
        };
        let point = |(index, point): (usize, &simulate::Point)| PointMotion {
            name: point.names.join(", "),
            y: column(&record.displacement, 2 * width, 2 * index),
            z: column(&record.displacement, 2 * width, 2 * index + 1),
        };
        let mesh = |(index, mesh): (usize, &usize)| MeshMotion {
            name: model.gear_names(*mesh).join("/"),
            force: channel("force", index),
            contact_ratio: channel("contact_ratio", index),
            pressure_angle: channel("pressure_angle", index),
        };
        Ok(Run {
            points: plan.points.iter().enumerate().map(point).collect(),
            meshes: plan.meshes.iter().enumerate().map(mesh).collect(),
            time: record.time.clone(),
            steps: response.statistics.steps,
        })
    }

    /// The bow of a shaft, one half wave, at which the contact ratio of each mesh falls to 1, at the worst angle of the bow
    /// relative to everything else that turns.
    pub fn bow_limits(&self, shaft: &str, speed: f64) -> Result<Vec<BowLimit>, String> {
        let with_bow = |amplitude| {
            let mut plain = self.plain.clone();
            replace_bow(&mut plain, &Bow { shaft: shaft.to_owned(), amplitude })?;
            Self::from_plain(plain)
        };
        let (straight, bent) = (with_bow(0.0)?, with_bow(SMALL_BOW)?);
        let response = |train: &Self, part| analysis::synchronous(&train.cached, speed, part).map_err(message);
        let (others, alone) = (response(&straight, ExcitationPart::All)?, response(&bent, ExcitationPart::Bow)?);
        let rest = analysis::equilibrium(&straight.cached, Geometry::Live, speed).map_err(message)?;
        let scene = &straight.cached.model.scene;
        let column = scene.shafts.iter().position(|one| one.name == shaft).unwrap_or_default();
        let limit = |(index, mesh): (usize, &gearbow::scene::Mesh)| {
            let involute = Involute::new(mesh, &scene.gears);
            let direction = involute.centres_at_rest().map(|component| component / mesh.centre_distance);
            // Components of the displacement of the driven gear relative to that of the driver.
            let moved = |train: &Self| {
                let nodes = [mesh.driver, mesh.driven].map(|gear| train.cached.model.scene.gears[gear].body.node);
                nodes.map(|node| train.cached.model.numbering.translation(node))
            };
            let [Some(from), Some(to)] = moved(&straight) else {
                return BowLimit { mesh: straight.cached.model.gear_names(index).join("/"), bow: None };
            };
            let along = |phasors: &dyn Fn(usize) -> Complex64, [from, to]: [usize; 2]| {
                (direction[0] * (phasors(to) - phasors(from)) + direction[1] * (phasors(to + 1) - phasors(from + 1)))
                    .norm()
            };
            let every = (0..others.ncols()).map(|source| along(&|row| others[(row, source)], [from, to]));
            let present: f64 = every.sum();
            let of_bow = match moved(&bent) {
                [Some(from), Some(to)] => along(&|row| alone[(row, column)], [from, to]) / SMALL_BOW,
                _ => 0.0,
            };
            let excess = |bow: f64| {
                let reach = present + bow * of_bow;
                let ratio = |sign: f64| {
                    let at = [0, 1].map(|axis| rest[to + axis] - rest[from + axis] + sign * reach * direction[axis]);
                    involute.centres(at).map_or(0.0, |centres| centres.contact_ratio)
                };
                ratio(1.0).min(ratio(-1.0)) - 1.0
            };
            let gear = &scene.gears[mesh.driver];
            let most = 8.0 * gear.pitch_radius / f64::from(gear.teeth);
            BowLimit {
                mesh: straight.cached.model.gear_names(index).join("/"),
                bow: (of_bow > MIN_MOTION).then(|| end(excess, most)).flatten(),
            }
        };
        Ok(scene.meshes.iter().enumerate().map(limit).collect())
    }
}

/// Where a falling function becomes negative between zero and `most`; none if it does not.
fn end(value: impl Fn(f64) -> f64, most: f64) -> Option<f64> {
    let (mut low, mut high) = (0.0, most);
    if value(high) > 0.0 {
        return None;
    }
    for _ in 0..BISECTIONS {
        let middle = (low + high) / 2.0;
        *(if value(middle) > 0.0 { &mut low } else { &mut high }) = middle;
    }
    Some(low)
}

/// Half the longest diameter of the ellipse Re(p e^{iϑ}) of two phasors.
fn semi_major_axis(y: Complex64, z: Complex64) -> f64 {
    let i = Complex64::i();
    ((y - i * z).norm() + (y + i * z).norm()) / 2.0
}

/// Gives a shaft a bow of one half wave.
fn replace_bow(plain: &mut toml::Value, bow: &Bow) -> Result<(), String> {
    let shafts = plain.get_mut("shafts").and_then(toml::Value::as_array_mut);
    let is_it = |shaft: &&mut toml::Value| shaft.get("name").and_then(toml::Value::as_str) == Some(&bow.shaft);
    let shaft = shafts.and_then(|shafts| shafts.iter_mut().find(is_it)).and_then(toml::Value::as_table_mut);
    let shaft = shaft.ok_or_else(|| format!("bow: no shaft is called \"{}\"", bow.shaft))?;
    let entries = [("shape", toml::Value::from("half_sine")), ("amplitude", toml::Value::from(bow.amplitude))];
    let table: toml::Table = entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
    shaft.insert("bow".to_owned(), toml::Value::Table(table));
    Ok(())
}
