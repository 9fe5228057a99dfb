//! The cases of `data/fibre_cases.csv` and `data/beam_reference.json`, which OpenSees has computed.

use crate::reference::{column, hit, support, vehicle};
use column_beam::{BeamColumn, Hit};
use serde::Serialize;
use serde_json::Value;

/// The front of a vehicle that gives way: its stiffness \[N/m\], and the force at which it crushes \[N\].
#[derive(Clone, Copy, Serialize)]
pub struct Front {
    pub stiffness: f64,
    pub crush_force: Option<f64>,
}

/// A hit and its reference.
pub struct Case {
    pub name: String,
    /// As the reference writes it; empty where the name contains it.
    pub hardening: String,
    pub column: BeamColumn,
    pub hit: Hit,
    #[allow(dead_code, reason = "benches/cost.rs gives it to OpenSees")]
    pub front: Option<Front>,
    /// Peak of the displacement along the hit \[m\], when \[s\], and how much remains of it \[m\].
    pub peak: f64,
    pub time: f64,
    pub residual: f64,
    /// Time step of the reference \[s\].
    #[allow(dead_code, reason = "benches/cost.rs takes the same")]
    pub step: f64,
}

/// Steps of the table for a rigid and for a soft vehicle \[s\]; its times are multiples of them.
const STEPS: [f64; 2] = [20e-6, 40e-6];

/// Plane hits of the table, without those on steel that does not harden, which the beam does not compute, and without those on the
/// column of the paper: its plastic moment of 0.307 MNm is larger than `f_y sqrt(A I)` = 0.305 MNm, which no section of one yield
/// strength exceeds.
pub fn plane_cases() -> Vec<Case> {
    let mut reader = csv::Reader::from_reader(include_str!("../data/fibre_cases.csv").as_bytes());
    let records = reader.records().map(Result::unwrap);
    let cases = records.filter_map(|record| {
        if record[0].starts_with("paper") {
            return None;
        }
        let number = |k: usize| record[k].parse::<f64>().ok();
        let hardening = match &record[14] {
            "b=1e-4" => 1e-4,
            "b=1e-2" => 1e-2,
            _ => return None,
        };
        let mut it = column(&record[1], number(2).unwrap(), hardening);
        (it.length_below, it.length_above) = (number(3).unwrap(), number(4).unwrap());
        (it.base, it.top) = (support(&record[5]), support(&record[6]));
        it.top_spring_stiffness = number(7).unwrap();
        it.top_load = number(8).unwrap();
        let mass = number(9).unwrap();
        let front = number(12).map(|stiffness| Front {
            stiffness,
            crush_force: number(13),
        });
        Some(Case {
            name: record[0].trim().to_owned(),
            hardening: record[14].to_owned(),
            column: it,
            hit: struck(mass, number(10).unwrap(), front, 0.0),
            front,
            peak: number(15).unwrap(),
            time: number(16).unwrap(),
            residual: number(17).unwrap(),
            step: STEPS[usize::from(front.is_some())],
        })
    });
    cases.collect()
}

fn struck(mass: f64, velocity: f64, front: Option<Front>, degrees: f64) -> Hit {
    let vehicle = front.map(|front| vehicle(mass, front.stiffness, front.crush_force));
    hit(mass, velocity, vehicle, degrees)
}

/// The cases of one kind: `plane impact`, `3D impact` or `push-down (GMNIA)`.
pub fn cases(kind: &str) -> Vec<Value> {
    let text = include_str!("../data/beam_reference.json");
    let all: Value = serde_json::from_str(text).unwrap();
    let cases = all["cases"].as_array().unwrap().iter();
    cases.filter(|case| case["kind"] == kind).cloned().collect()
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn front(vehicle: &Value) -> Option<Front> {
    vehicle["stiffness_N_m"].as_f64().map(|stiffness| Front {
        stiffness,
        crush_force: vehicle["crush_force_N"].as_f64(),
    })
}

/// The column of a case and, except for push-downs of undamaged ones, the hit.
pub fn described(case: &Value) -> (BeamColumn, Option<Hit>) {
    let p = &case["parameters"];
    let mut it = column(
        p["section"].as_str().unwrap(),
        number(&p["yield_strength_Pa"]),
        number(&p["hardening_ratio"]),
    );
    it.length_below = number(&p["length_below_impact_m"]);
    it.length_above = number(&p["length_above_impact_m"]);
    it.base = support(p["base"].as_str().unwrap());
    it.top = support(p["top"].as_str().unwrap());
    it.top_spring_stiffness = number(&p["vertical_spring_top_N_m"]);
    it.top_load = number(&p["axial_load_N"]);
    it.torsion_constant = p["torsion_GJ_Nm2"]
        .as_f64()
        .map(|gj| gj / it.steel.shear_modulus());
    let v = &p["vehicle"];
    if v.is_null() {
        return (it, None);
    }
    let angle = p["angle_from_strong_axis_bending_deg"]
        .as_f64()
        .unwrap_or(0.0);
    let [mass, velocity] = ["mass_kg", "speed_m_s"].map(|key| number(&v[key]));
    (it, Some(struck(mass, velocity, front(v), angle)))
}

/// A hit of `data/beam_reference.json`, in the plane of the web or in space with Saint-Venant's torsion.
pub fn impact_case(case: &Value) -> Case {
    let (column, hit) = described(case);
    let (p, r) = (&case["parameters"], &case["reference"]);
    let mesh = p["mesh_used"].as_str().unwrap();
    let step = mesh.split("dt ").nth(1).and_then(|it| it.split(' ').next());
    let either = |keys: [&str; 2]| {
        let found = keys.iter().find_map(|key| r[key].as_f64());
        found.unwrap_or(f64::NAN)
    };
    Case {
        name: case["name"].as_str().unwrap().to_owned(),
        hardening: String::new(),
        column,
        hit: hit.unwrap(),
        front: front(&p["vehicle"]),
        peak: either(["max_displacement_m", "max_displacement_along_hit_m"]),
        time: number(&r["time_of_max_s"]),
        residual: either(["residual_m", "residual_along_hit_m"]),
        step: step.and_then(|it| it.parse().ok()).unwrap(),
    }
}
