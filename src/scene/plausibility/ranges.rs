//! Ranges of quantities in built machines. A value outside its range is probably a mistake of units.

/// Range of a quantity in built machines.
pub(super) struct Usual {
    /// Name of the quantity, as the warning shows it.
    pub(super) quantity: &'static str,
    /// SI unit; empty for a ratio.
    pub(super) unit: &'static str,
    /// Lower end of the range.
    pub(super) low: f64,
    /// Upper end of the range.
    pub(super) high: f64,
    /// Probable cause of a value above the range.
    pub(super) above: &'static str,
    /// Probable cause of a value below the range.
    pub(super) below: &'static str,
}

// Questions of the warnings.
pub(super) const ASK_MILLIMETRES: &str = "is it in millimetres?";
pub(super) const ASK_UNIT: &str = "is it in another unit?";
pub(super) const ASK_DEGREES: &str = "is it in degrees?";
pub(super) const ASK_PERCENT: &str = "is it in percent?";

const fn usual(quantity: &'static str, unit: &'static str, low: f64, high: f64, above: &'static str) -> Usual {
    Usual { quantity, unit, low, high, above, below: ASK_UNIT }
}

/// Watch arbors: 2 mm; ship shaft lines: 100 m.
pub(super) const SHAFT_LENGTH: Usual = usual("the length of a shaft", "m", 1e-3, 150.0, ASK_MILLIMETRES);
/// Watch pivots: 0.07 mm; hydroelectric shafts: 3 m.
pub(super) const SHAFT_DIAMETER: Usual = usual("the diameter of a shaft", "m", 5e-5, 5.0, ASK_MILLIMETRES);
/// From flat hubs to long shafts that need more than two bearings.
pub(super) const SHAFT_SLENDERNESS: Usual =
    usual("length over diameter of a shaft", "", 0.3, 200.0, "are both in the same unit?");
/// Young's modulus. Polyethylene: 0.2 GPa; diamond: 1.2 TPa; idealised rigid shafts: up to 1000 TPa.
pub(super) const YOUNGS_MODULUS: Usual =
    Usual { below: "is it in MPa or GPa?", ..usual("the elastic modulus of a solid", "Pa", 1e8, 1e15, ASK_UNIT) };
/// About half of Young's modulus: G = E/2(1 + ν).
pub(super) const SHEAR_MODULUS: Usual =
    Usual { quantity: "the shear modulus of a solid", low: 3e7, high: 5e14, ..YOUNGS_MODULUS };
/// Foams: 100 kg/m³; osmium: 22 600 kg/m³.
pub(super) const SOLID_DENSITY: Usual =
    Usual { below: "is it in g/cm3 or t/mm3?", ..usual("the density of a solid", "kg/m3", 100.0, 23e3, ASK_UNIT) };
/// Sag between two bearings over the radius. Flexible rotors of test rigs reach 0.2.
pub(super) const SHAFT_SAG: Usual = usual(
    "the deflection of a shaft under its weight, over its radius,",
    "",
    0.0,
    0.5,
    "are lengths, modulus, density and masses in SI units?",
);
/// Watch wheels: 0.05 mm; jack-up rigs and ship lifts: 100 mm.
pub(super) const GEAR_MODULE: Usual = usual("the module of a gear", "m", 3e-5, 0.15, ASK_MILLIMETRES);
/// Face width over reference diameter, from thin instrument wheels to long pinions.
pub(super) const FACE_WIDTH: Usual = usual("face width over reference diameter", "", 2e-3, 20.0, ASK_MILLIMETRES);
/// ISO 21771 and DIN 3992: −0.5 to 1. Small tooth numbers and large centre distances need more.
pub(super) const PROFILE_SHIFT: Usual = Usual {
    below: ASK_MILLIMETRES,
    ..usual("the profile shift coefficient", "", -1.5, 2.5, "is it a length in millimetres?")
};
/// In use: 14.5° to 28°, in instruments 8°. The scene refuses 45° and more.
pub(super) const PRESSURE_ANGLE: Usual = usual("the pressure angle", "rad", 0.14, 0.8, ASK_DEGREES);
/// Tip radius minus pitch radius in modules: 0.8 to 1.35 plus the profile shift.
pub(super) const GEAR_ADDENDUM: Usual = usual("the addendum in modules", "", -1.5, 4.0, ASK_MILLIMETRES);
/// A solid steel wheel: 7850 kg/m³. Spokes reduce the value; a hub, a coupling or a flywheel increases it.
pub(super) const GEAR_DENSITY: Usual = usual(
    "mass of a gear over the volume of its reference cylinder",
    "kg/m3",
    20.0,
    1e5,
    "are mass and sizes in SI units?",
);
/// A solid disk: 0.71; a thin rim: 1.
pub(super) const GEAR_GYRATION: Usual =
    usual("radius of gyration of a gear over its reference radius", "", 0.05, 5.0, "is the inertia in kg m2?");
/// A solid disk: 0.35 of its diameter. Hydroelectric rotors have diameters of 16 m.
pub(super) const BODY_GYRATION: Usual =
    usual("the radius of gyration of a body", "m", 1e-4, 10.0, "is the inertia in kg m2?");
/// Watch wheels: 10 mg; hydroelectric rotors: 2000 t.
pub(super) const BODY_MASS: Usual = usual("the mass of a body", "kg", 1e-7, 3e6, "is it in grams?");
/// Unbalance over the mass of body and shaft, over the radius of the shaft. ISO 21940-11 allows eccentricities of
/// 1e-6 m to 1e-3 m.
pub(super) const BODY_ECCENTRICITY: Usual = usual(
    "eccentricity (unbalance over mass) over the radius of the shaft",
    "",
    0.0,
    0.25,
    "an unbalance is in kg m; is it in g mm?",
);
/// Shafts with a bow above 1e-3 of the length are straightened.
pub(super) const SHAFT_BOW: Usual = usual("bow over length of a shaft", "", 0.0, 0.05, ASK_MILLIMETRES);
/// Eccentric gears: 0.05 modules at most.
pub(super) const GEAR_RUNOUT: Usual = usual("run-out in modules", "", 0.0, 0.5, ASK_MILLIMETRES);
/// ISO/TR 10064-2 recommends 0.03 to 0.1 modules.
pub(super) const MESH_BACKLASH: Usual = usual("backlash in modules", "", 0.0, 1.0, ASK_MILLIMETRES);
/// ISO 21771 and common practice: 0.01 to 0.02 modules.
pub(super) const TIP_RELIEF: Usual =
    usual("tip relief in modules", "", 0.0, 0.3, "is it in millimetres or micrometres?");
/// The relief covers a part of the path of contact, which is shorter than six modules.
pub(super) const RELIEF_LENGTH: Usual = usual("length of tip relief in modules", "", 0.0, 10.0, ASK_MILLIMETRES);
/// ISO 1328-1, class 12: 0.05 modules.
pub(super) const TRANSMISSION_ERROR: Usual =
    usual("transmission error in modules", "", 0.0, 0.5, "is it in millimetres or micrometres?");
/// Working and reference centre distance differ by the profile shifts, a few modules at most.
pub(super) const CENTRE_DISTANCE: Usual =
    usual("centre distance over the sum of the reference radii", "", 0.9, 1.25, ASK_MILLIMETRES);
/// A tip circle that reaches the axis of the other gear cuts its shaft.
pub(super) const TIP_REACH: Usual = usual("tip radius over centre distance", "", 0.0, 1.0, ASK_MILLIMETRES);
/// ISO 6336-1 for steel: 1.4e10 N/m²; polymer gears: 1 % of it. A value for steel in N/mm would be 2e7.
pub(super) const MESH_STIFFNESS: Usual = Usual {
    below: "is it in N/mm?",
    ..usual("mesh stiffness over face width (ten modules where none is given)", "N/m2", 5e7, 3e11, ASK_UNIT)
};
/// Lubricated steel: 0.02 to 0.1; dry polymers: up to 0.3.
pub(super) const MESH_FRICTION: Usual = usual("the coefficient of friction of a mesh", "", 0.0, 0.3, ASK_PERCENT);
/// Polished flanks: 0.05 µm; cast teeth: 25 µm.
pub(super) const FLANK_ROUGHNESS: Usual = usual("the roughness of flanks", "m", 1e-8, 1e-4, "is it in micrometres?");
/// Measured values: 0.03 to 0.17.
pub(super) const MESH_DAMPING: Usual = usual("the damping ratio of a mesh", "", 0.0, 1.0, ASK_PERCENT);
/// Steel rotors: 0.001 to 0.02; squeeze-film dampers: up to 0.3.
pub(super) const MODAL_DAMPING: Usual = usual("a modal damping ratio", "", 0.0, 0.5, ASK_PERCENT);
/// Steel: 0.0005 to 0.005; built-up rotors: up to 0.1.
pub(super) const LOSS_FACTOR: Usual = usual("the loss factor of a shaft", "", 0.0, 0.5, ASK_PERCENT);
/// Shear strain at the surface at which steel yields: 0.01; polymers: 0.05.
pub(super) const SHAFT_TORSION: Usual =
    usual("the shear strain of the shaft under a torque", "", 0.0, 0.05, "is it in N mm?");
/// The largest planets: 25 m/s². Centrifuges, and loads that a user models as gravity, need more.
pub(super) const GRAVITY: Usual = usual("gravity", "m/s2", 0.0, 5e3, "is it in mm/s2?");
/// Turbo gears reach 200 m/s; AGMA 6011 covers speeds above 35 m/s.
pub(super) const PITCH_LINE_SPEED: Usual = usual("the pitch-line speed", "m/s", 0.0, 250.0, "is the speed in rpm?");
/// Stiffer bearings are rigid.
pub(super) const BEARING_STIFFNESS: Usual = usual("the stiffness of a bearing", "N/m", 0.0, 1e14, ASK_UNIT);
/// Usual in turbomachinery: 1e-3 to 2e-3. Dry instrument bearings need more.
pub(super) const JOURNAL_CLEARANCE: Usual =
    usual("radial clearance over the radius of a journal", "", 1e-4, 2e-2, ASK_MILLIMETRES);
/// Clearance or preload of a rolling bearing, ISO 5753: up to 1e-2; worn and idealised bearings have more.
pub(super) const ROLLING_CLEARANCE: Usual =
    usual("clearance of a rolling bearing over the diameter of its balls", "", 0.0, 5e-2, ASK_MILLIMETRES);
/// Static load ratings of thrust bearings, ISO 76: up to 1e8 Pa.
pub(super) const AXIAL_PRELOAD: Usual =
    usual("axial preload over the number and the squared diameter of the rolling elements", "Pa", 0.0, 1e8, ASK_UNIT);
/// Rolling bearings of catalogues: 1e6 to 1e8 Pa; slewing rings of 2 m: 3e5 Pa.
pub(super) const LOAD_RATING: Usual = Usual {
    below: "is it in kN?",
    ..usual("a load rating over the squared diameter of the shaft", "Pa", 1e5, 1e9, ASK_UNIT)
};
/// Gases: 1e-5 Pa s; cold gear oil: a few Pa s.
pub(super) const OIL_VISCOSITY: Usual =
    usual("the viscosity of an oil", "Pa s", 1e-6, 50.0, "is it in mPa s (centipoise)?");
