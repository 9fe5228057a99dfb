//! Estimates of impacts that the model itself has made, on columns that differ from what the estimator knows of them.
//!
//! The impacts are drawn by a seed. Nothing in the estimator was chosen by them.

use std::path::Path;

use column_twin::column::{
    ColumnProperties, CrushCurve, CrushSpring, Impact, ShearProperties, Vehicle, simulate,
};
use column_twin::estimation::{
    CredibleInterval, ImpactEstimate, Readings, estimate_recorded, simulate_sensors,
};
use column_twin::parameters::{Parameters, parse_override};

use super::signals::{Normal, industrial};

/// Lengths below and above the impact point \[m\].
const COLUMNS: [[f64; 2]; 3] = [[0.8, 3.2], [1.25, 2.75], [1.0, 4.0]];

/// Impacts of each kind on each column.
const RIGID: u32 = 4;
const DEFORMABLE: u32 = 2;

/// Standard deviations of what the column differs by from its parameters, relative to these: yield strength, bending stiffness,
/// mass.
const DEVIATIONS: [f64; 3] = [0.02, 0.02, 0.05];

/// Damping of the column, of which the parameters say nothing.
const DAMPING: f64 = 0.01;

/// The readings end so long after the event \[s\].
const END: f64 = 0.35;

/// An impact with what is known of it.
struct Case {
    impact: Impact,
    peak: f64,
    estimates: Vec<ImpactEstimate>,
}

pub fn parameters([below, above]: [f64; 2]) -> Parameters {
    let overrides = [
        format!("geometry.length_below:={below:?}"),
        format!("geometry.length_above:={above:?}"),
        // The bars make the impacts, and the readings are not corrected by what a beam does otherwise.
        "beam.mode:=off".to_owned(),
    ];
    let overrides: Vec<_> = overrides.iter().map(|text| parse_override(text)).collect();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_s355.yaml");
    Parameters::load(&[file], &overrides).expect("parameters")
}

/// The column as it is.
pub fn real_column(known: &ColumnProperties, normal: &mut Normal) -> ColumnProperties {
    let [strength, stiffness, mass] = DEVIATIONS.map(|it| 1.0 + it * normal.next());
    ColumnProperties {
        resistance_moment: strength * known.resistance_moment,
        resistance_axial: strength * known.resistance_axial,
        bending_stiffness: stiffness * known.bending_stiffness,
        shear: known.shear.map(|shear| ShearProperties {
            web_resistance: strength * shear.web_resistance,
            flange_moment: strength * shear.flange_moment,
            rigidity: stiffness * shear.rigidity,
            ..shear
        }),
        mass_per_length: mass * known.mass_per_length,
        damping_ratio: DAMPING,
        ..*known
    }
}

/// A rigid mass of about 1.5 t at about 5 m/s, which no column here collapses under.
fn rigid(normal: &mut Normal) -> Impact {
    let mass = 1500.0 * (0.25 * normal.next().clamp(-1.5, 1.5)).exp();
    Impact::rigid(mass, 5.0 * (0.3 * normal.next().clamp(-1.5, 1.5)).exp())
}

/// A mass of about 2 t at about 8 m/s behind a spring of about 400 kN/m.
fn deformable(normal: &mut Normal) -> Impact {
    let mass = 2000.0 * (0.3 * normal.next().clamp(-1.5, 1.5)).exp();
    let stiffness = 400e3 * (0.3 * normal.next().clamp(-1.5, 1.5)).exp();
    let spring = CrushSpring {
        envelope: CrushCurve::new(&[[1.0, stiffness]]).expect("a curve"),
        unloading_stiffness: stiffness,
        slack: 0.0,
    };
    Impact {
        vehicle: Some(Vehicle::new(&[mass], &[spring]).expect("a vehicle")),
        ..Impact::rigid(mass, 8.0 * (0.3 * normal.next().clamp(-1.5, 1.5)).exp())
    }
}

fn estimated(column: [f64; 2], impact: Impact, seed: u32, normal: &mut Normal) -> Case {
    let parameters = parameters(column);
    let real = real_column(&parameters.column_properties(), normal);
    let sensors = industrial(column[0], column[0] + column[1]);
    let readings =
        simulate_sensors(&real, &impact, 1.0, &sensors, u64::from(seed)).expect("readings");
    let rows = readings.times.partition_point(|time| *time < END);
    let readings = Readings {
        times: readings.times[..rows].to_vec(),
        values: readings.values[..rows * sensors.len()].to_vec(),
        ..readings
    };
    let report = simulate(&real, &impact, 1.0, &mut |_| {}).expect("a response");
    assert!(report.outcome.stands(), "{impact:?} is too strong");
    let found = estimate_recorded(&parameters, &sensors, &readings, 1, &mut |_| {});
    let found = found
        .expect("sensors")
        .unwrap_or_else(|| panic!("{impact:?} is not detected"));
    Case {
        peak: report.max_v1,
        estimates: found.estimates,
        impact,
    }
}

/// Mass, speed, momentum and peak: estimated and true.
fn compared(case: &Case, of: &ImpactEstimate) -> [(CredibleInterval, f64); 4] {
    let Impact { mass, velocity, .. } = case.impact;
    [
        (of.mass, mass),
        (of.velocity, velocity),
        (of.momentum, mass * velocity),
        (of.peak_v1, case.peak),
    ]
}

/// Share of the intervals from 10 ms of data on that hold the truth.
fn coverage(cases: &[Case]) -> f64 {
    let (mut held, mut total) = (0_u32, 0_u32);
    for case in cases {
        for estimate in case.estimates.iter().filter(|it| it.data_until >= 9.9e-3) {
            for (interval, truth) in compared(case, estimate) {
                held += u32::from((interval.low..=interval.high).contains(&truth));
                total += 1;
            }
        }
    }
    println!("{held} of {total} intervals hold the truth");
    f64::from(held) / f64::from(total)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn cases(count: u32, seed: u64, draw: fn(&mut Normal) -> Impact) -> Vec<Case> {
    let mut normal = Normal::new(seed);
    let columns = COLUMNS
        .iter()
        .flat_map(|column| (0..count).map(move |_| *column));
    (1..)
        .zip(columns)
        .map(|(seed, column)| {
            let impact = draw(&mut normal);
            estimated(column, impact, seed, &mut normal)
        })
        .collect()
}

#[test]
#[ignore = "slow: estimates of many impacts take minutes"]
fn ten_milliseconds_tell_what_rigid_mass_has_struck_a_column_that_is_not_quite_as_known() {
    let cases = cases(RIGID, 15, rigid);
    let errors: Vec<[f64; 4]> = cases
        .iter()
        .map(|case| {
            let at_10_ms = case.estimates.iter().find(|it| it.data_until >= 9.9e-3);
            let at_10_ms = at_10_ms.expect("an estimate");
            assert_eq!(at_10_ms.vehicle_probabilities[0].0, "rigid", "{:?}", case.impact);
            let errors = compared(case, at_10_ms).map(|(of, truth)| (of.mean / truth - 1.0).abs());
            let Impact { mass, velocity, .. } = case.impact;
            println!("{mass:.0} kg at {velocity:.1} m/s: errors of mass, speed, momentum, peak {errors:.3?}");
            errors
        })
        .collect();
    let median = |k: usize| median(errors.iter().map(|it| it[k]).collect());
    let medians = [median(0), median(1), median(3)];
    for (found, most) in medians.into_iter().zip([0.2, 0.1, 0.1]) {
        assert!(found <= most, "medians of mass, speed, peak {medians:?}");
    }
    assert!(coverage(&cases) >= 0.8);
}

#[test]
#[ignore = "slow: estimates of many impacts take minutes"]
fn intervals_hold_what_elastic_front_has_struck_a_column_that_is_not_quite_as_known() {
    assert!(coverage(&cases(DEFORMABLE, 16, deformable)) >= 0.8);
}
