//! What the column computes arrives in its messages, value by value.

use column_twin::column::{
    BaseForces, BaseReport, End, HINGES, HingeReport, HingeSample, HingeState, Outcome, Phase,
    Report, Sample, VehicleReport, WEBS, WebSample,
};
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{ColumnState, HingeForces, ImpactReport};
use proptest::prelude::*;
use serde_json::{Map, Value, json};

/// An object in which every number is another one.
fn numbered(value: Value, next: &mut f64) -> Value {
    let mut number = || {
        *next += 1.25;
        json!(*next)
    };
    match value {
        Value::Number(_) => number(),
        Value::Array(elements) => elements
            .into_iter()
            .map(|element| numbered(element, next))
            .collect(),
        Value::Object(fields) => fields
            .into_iter()
            .map(|(name, value)| (name, numbered(value, next)))
            .collect(),
        other => other,
    }
}

fn sample() -> Sample {
    let states = [
        HingeState::Elastic,
        HingeState::Plastic,
        HingeState::Unloaded,
        HingeState::Plastic,
    ];
    let hinges = states.map(|state| HingeSample {
        state,
        ..HingeSample::default()
    });
    let sample = Sample {
        phase: Phase::Contact,
        hinges,
        // What is as by default is not written, and would not be numbered.
        webs: [WebSample {
            utilisation: 1.0,
            ..WebSample::default()
        }; WEBS],
        base: BaseForces {
            shear: 1.0,
            ..BaseForces::default()
        },
        ..Sample::default()
    };
    let mut numbered = numbered(serde_json::to_value(sample).unwrap(), &mut 0.0);
    numbered["vehicle"]["masses"] = json!(2);
    serde_json::from_value(numbered).unwrap()
}

fn fields(message: impl serde::Serialize) -> Map<String, Value> {
    let Value::Object(fields) = serde_json::to_value(message).unwrap() else {
        panic!("no struct")
    };
    fields
}

#[test]
fn column_state_has_every_value_of_the_sample() {
    let sample = sample();
    let message = ColumnState::from(&sample);
    assert_eq!(message.event_id, "");
    assert_eq!(message.phase, ColumnState::CONTACT);
    let expected = fields(sample);
    let of_vehicle = fields(sample.vehicle);
    for (name, value) in fields(&message) {
        let expected = match name.as_str() {
            "header" | "column_id" | "event_id" | "phase" => continue,
            "vehicle_elastic_energy" => of_vehicle["elastic_energy"].clone(),
            "vehicle_velocity" => of_both_masses(&of_vehicle["velocity"]),
            "spring_force" => of_both_masses(&of_vehicle["force"]),
            "vehicle_dissipated" => of_both_masses(&of_vehicle["dissipated"]),
            "crush" | "permanent_crush" => of_both_masses(&of_vehicle[&name]),
            _ => expected[&name].clone(),
        };
        assert_eq!(value, expected, "{name}");
    }
}

/// The vehicle of the sample has two masses of three.
fn of_both_masses(values: &Value) -> Value {
    Value::Array(values.as_array().unwrap()[..2].to_vec())
}

#[test]
fn a_rigid_vehicle_has_neither_masses_nor_springs() {
    let message = ColumnState::from(&Sample::default());
    for values in [
        message.vehicle_velocity,
        message.crush,
        message.permanent_crush,
        message.spring_force,
        message.vehicle_dissipated,
    ] {
        assert!(values.is_empty());
    }
}

#[test]
fn hinge_forces_have_every_value_of_the_sample() {
    let sample = sample();
    let message = HingeForces::from(&sample);
    assert_eq!(
        *message.state,
        [
            HingeForces::ELASTIC,
            HingeForces::PLASTIC,
            HingeForces::UNLOADED,
            HingeForces::PLASTIC
        ]
    );
    for (name, values) in fields(&message) {
        let of_web = match name.as_str() {
            "header" | "column_id" | "event_id" | "state" | "web_state" => continue,
            "base" => {
                assert_eq!(values, Value::Object(fields(sample.base)));
                continue;
            }
            "shear_force" => Some("shear_force"),
            "shear_angle" => Some("plastic_angle"),
            "shear_utilisation" => Some("utilisation"),
            "web_dynamic_factor" => Some("dynamic_factor"),
            _ => None,
        };
        let expected: Vec<_> = match of_web {
            Some(field) => sample
                .webs
                .iter()
                .map(|web| fields(web)[field].clone())
                .collect(),
            None => sample
                .hinges
                .iter()
                .map(|hinge| fields(hinge)[&name].clone())
                .collect(),
        };
        assert_eq!(values, Value::Array(expected), "{name}");
    }
}

#[test]
fn every_phase_has_its_constant() {
    for (phase, code) in [
        (Phase::Idle, ColumnState::IDLE),
        (Phase::Approach, ColumnState::APPROACH),
        (Phase::Contact, ColumnState::CONTACT),
        (Phase::Free, ColumnState::FREE),
    ] {
        assert_eq!(
            ColumnState::from(&Sample {
                phase,
                ..Sample::default()
            })
            .phase,
            code
        );
    }
}

/// A thousand times a second.
#[test]
fn making_a_message_of_a_sample_does_not_allocate() {
    let sample = sample();
    let memory = allocation_counter::measure(|| {
        std::hint::black_box((ColumnState::from(&sample), HingeForces::from(&sample)));
    });
    assert_eq!(memory.count_total, 0);
}

fn report() -> Report {
    Report {
        outcome: Outcome::Plastic,
        end: End::DurationReached,
        end_time: 0.5,
        max_v1: 1.0,
        max_v1_time: 2.0,
        residual_v1: Some(3.0),
        max_u2: 4.0,
        residual_u2: Some(5.0),
        first_contact_time: Some(6.0),
        release_time: Some(7.0),
        contact_duration: 8.0,
        impactor_velocity: 9.0,
        peak_contact_force: 10.0,
        peak_contact_force_time: Some(11.0),
        impact_impulses: 12,
        total_impact_impulse: 13.0,
        impulse: 14.0,
        input_energy: 15.0,
        column_kinetic_energy: 16.0,
        impactor_kinetic_energy: 17.0,
        elastic_energy_change: 18.0,
        plastic_work: 19.0,
        impact_loss: 20.0,
        damping_work: 21.0,
        load_work: 22.0,
        ledger_residual: 23.0,
        max_dynamic_factor: [90.0, 91.0, 92.0, 93.0],
        steps: 24,
        hinges: std::array::from_fn::<_, HINGES, _>(|index| HingeReport {
            first_yield: (index != 2).then_some(30.0 + index as f64),
            max_utilisation: 40.0 + index as f64,
            plastic_rotation: 50.0 + index as f64,
            plastic_elongation: 60.0 + index as f64,
        }),
        vehicle: VehicleReport {
            masses: 2,
            max_crush: [70.0, 71.0, 72.0],
            permanent_crush: [73.0, 74.0, 75.0],
            dissipated: [76.0, 77.0, 78.0],
            velocity: [79.0, 80.0, 81.0],
            elastic_energy: 82.0,
        },
        webs: Default::default(),
        base: numbered_base(),
    }
}

fn numbered_base() -> BaseReport {
    let unnumbered = BaseReport {
        plateau: Some(BaseForces::default()),
        ..BaseReport::default()
    };
    let unnumbered = serde_json::to_value(unnumbered).unwrap();
    serde_json::from_value(numbered(unnumbered, &mut 100.0)).unwrap()
}

/// Every reaction of the base has its own field, under the name that the report gives it.
#[test]
fn impact_report_has_the_reactions_of_the_base() {
    let report = report();
    let message = fields(ImpactReport::from(&report));
    let reactions = fields(report.base);
    for (name, reaction) in &reactions {
        assert_eq!(message[&format!("base_{name}")], *reaction, "{name}");
    }
    let published = message.keys().filter(|name| name.starts_with("base_"));
    assert_eq!(published.count(), reactions.len());
}

#[test]
fn impact_report_has_the_values_of_the_report() {
    let report = report();
    let message = ImpactReport::from(&report);
    assert_eq!(message.outcome, ImpactReport::PLASTIC);
    assert_eq!(message.end, ImpactReport::END_DURATION_REACHED);
    assert_eq!(message.impactor_rebound, report.impactor_velocity);
    assert!(message.compute_time.is_nan());
    assert_eq!(*message.max_crush, [70.0, 71.0]);
    assert_eq!(*message.permanent_crush, [73.0, 74.0]);
    assert_eq!(*message.vehicle_dissipated, [76.0, 77.0]);
    assert_eq!(*message.vehicle_velocity, [79.0, 80.0]);
    assert_eq!(*message.max_utilisation, [40.0, 41.0, 42.0, 43.0]);
    assert_eq!(*message.plastic_rotation, [50.0, 51.0, 52.0, 53.0]);
    assert_eq!(
        Vec::from_iter(message.first_yield_time.iter().map(|it| it.to_bits())),
        [30.0, 31.0, f64::NAN, 33.0].map(f64::to_bits)
    );
    let expected = fields(report);
    let same_name = [
        "end_time",
        "max_v1",
        "max_v1_time",
        "residual_v1",
        "max_u2",
        "residual_u2",
        "release_time",
        "peak_contact_force",
        "impulse",
        "plastic_work",
        "impact_loss",
        "ledger_residual",
        "max_dynamic_factor",
    ];
    let found = fields(&message);
    for name in same_name {
        assert_eq!(found[name], expected[name], "{name}");
    }
}

/// What did not happen is NaN, which no arithmetic can take for a value.
#[test]
fn what_a_report_does_not_know_is_nan() {
    let report = Report {
        residual_v1: None,
        residual_u2: None,
        release_time: None,
        base: BaseReport {
            plateau: None,
            ..report().base
        },
        ..report()
    };
    let report = Report {
        outcome: Outcome::Collapsed,
        end: End::Collapsed,
        ..report
    };
    let message = ImpactReport::from(&report);
    assert_eq!(
        (message.outcome, message.end),
        (ImpactReport::COLLAPSED, ImpactReport::END_COLLAPSED)
    );
    assert!(
        message.residual_v1.is_nan()
            && message.residual_u2.is_nan()
            && message.release_time.is_nan()
    );
    let plateau = message.base_plateau;
    assert!(
        plateau.shear.is_nan() && plateau.moment.is_nan() && plateau.normal_force.is_nan(),
        "{plateau:?}"
    );
    assert!(message.base_peak_shear.shear.is_finite());
}

proptest! {
    #[test]
    fn instants_survive_as_time(nanos in (i64::from(i32::MIN) * 1_000_000_000)..=(i64::from(i32::MAX) * 1_000_000_000)) {
        let time = Time::from_nanos(nanos).unwrap();
        prop_assert!(time.nanosec < 1_000_000_000);
        prop_assert_eq!(time.to_nanos(), Some(nanos));
    }
}

#[test]
fn instants_that_time_cannot_hold_are_none() {
    assert_eq!(
        Time::from_nanos(-1),
        Some(Time {
            sec: -1,
            nanosec: 999_999_999
        })
    );
    assert_eq!(Time::from_nanos(i64::MAX), None);
    assert_eq!(
        Time {
            sec: 0,
            nanosec: 1_000_000_000
        }
        .to_nanos(),
        None
    );
}
