//! gearbow for a web page: a train as TOML, what the page asks of it as JSON.
//!
//! [`Train`] has the methods that the page calls; `analyses` answers them, and `units` converts texts such as "90 mm".

mod analyses;
mod units;

pub use analyses::Bow;
use serde::Serialize;
use units::Units;
use wasm_bindgen::prelude::*;

/// A checked and assembled train.
#[wasm_bindgen]
pub struct Train(analyses::Train);

fn json<T: Serialize>(found: Result<T, String>) -> Result<String, JsError> {
    let text = found.and_then(|found| serde_json::to_string(&found).map_err(|error| error.to_string()));
    text.map_err(|message| JsError::new(&message))
}

#[wasm_bindgen]
impl Train {
    /// Reads a scene.
    ///
    /// `units` is the table of units as JSON, which `web/build.py` writes. A `shaft` gets a bow of one half wave with
    /// `amplitude`, m, in place of the bow of the scene; an empty name keeps all bows.
    ///
    /// # Errors
    /// A message with the path of the wrong entry.
    #[wasm_bindgen(constructor)]
    pub fn new(scene: &str, units: &str, shaft: &str, amplitude: f64) -> Result<Self, JsError> {
        let bow = (!shaft.is_empty()).then(|| Bow { shaft: shaft.to_owned(), amplitude });
        let train = serde_json::from_str::<Units>(units)
            .map_err(|error| error.to_string())
            .and_then(|units| analyses::Train::new(scene, &units, bow.as_ref()));
        train.map(Self).map_err(|message| JsError::new(&message))
    }

    /// Shafts, gears, disks and bearings with their sizes, and warnings.
    ///
    /// # Errors
    /// None are expected.
    pub fn layout(&self) -> Result<String, JsError> {
        json(Ok(self.0.layout()))
    }

    /// The `count` modes of lowest frequency at `speed`, rad/s.
    ///
    /// # Errors
    /// The message of the analysis.
    pub fn modes(&self, speed: f64, count: usize) -> Result<String, JsError> {
        json(self.0.modes(speed, count))
    }

    /// Campbell diagram of `count` modes at `points` speeds up to `fastest`, rad/s.
    ///
    /// # Errors
    /// The message of the analysis.
    pub fn campbell(&self, fastest: f64, points: usize, count: usize) -> Result<String, JsError> {
        json(self.0.campbell(fastest, points, count))
    }

    /// Synchronous response of gears and disks at `points` speeds up to `fastest`, rad/s.
    ///
    /// # Errors
    /// The message of the analysis.
    pub fn synchronous(&self, fastest: f64, points: usize) -> Result<String, JsError> {
        json(self.0.synchronous(fastest, points))
    }

    /// Motion over a number of turns of the slowest shaft at `speed`, rad/s.
    ///
    /// # Errors
    /// The message of the run.
    pub fn run(&self, speed: f64, turns: f64) -> Result<String, JsError> {
        json(self.0.run(speed, turns))
    }

    /// Largest bow of a shaft, m, up to which the teeth of each mesh keep contact at `speed`, rad/s.
    ///
    /// # Errors
    /// The message of the analysis.
    pub fn bow_limits(&self, shaft: &str, speed: f64) -> Result<String, JsError> {
        json(self.0.bow_limits(shaft, speed))
    }
}
